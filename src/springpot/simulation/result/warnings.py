"""Warnings of a run: one sentence for each reason to doubt a number, and for each argument without effect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import per_cent
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.simulation.estimate.slow_impacts import (
    impacts_are_countable,
    missed_impacts,
    quantile_step_bias,
    slow_impact_order,
    slow_impacts,
)
from springpot.simulation.estimate.statistics import standard_error
from springpot.simulation.estimate.step_biases import NORMAL
from springpot.simulation.kernel.block import COLUMNS
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.options import Options
from springpot.simulation.plan.settings import SINGLE_PRECISION, default_start, keeps_the_law
from springpot.simulation.plan.start import Adapted
from springpot.simulation.plan.transient import MOST_TRANSIENT, transient_left
from springpot.simulation.watch.distributions import Distribution
from springpot.theory.mckean import COLLAPSE_BELOW

if TYPE_CHECKING:
    from springpot.simulation.error.reach import Reached

__all__ = [
    "about_default_start", "about_observables", "about_quantiles", "about_uncontrolled_impacts", "doubts",
    "without_effect",
]  # fmt: skip

Floats = npt.NDArray[np.float64]

FAR_OFF = 5.0  # standard errors beyond which a mean that should be 0 gives a warning
MOST_RESIDUAL = 0.01  # of an adapted start
MOST_REMEMBERED = 0.03  # mean force of the springpot over the spring's, in the window
MOST_MISSED = 0.01  # of the impacts, by estimate
LEAST_BIAS = 0.01  # of a quantile; a smaller one gives no warning


def about_default_start(problem: Oscillator | System, given: Options) -> list[str]:
    """Warn of a start from rest that the user did not choose."""
    if given.get("start") is not None:
        return []
    _, reason = default_start(problem, given)
    return [f"the run starts from rest, because there is no stationary state: {reason}."] if reason else []


def doubts(
    simulation: Simulation, values: dict[str, float], errors: dict[str, float], rows: Floats, *, bounded: bool = False
) -> tuple[str, ...]:
    """One sentence for each reason to doubt a number of a run.

    ``bounded``: the total errors include those of step and transient, so these give no warning.
    """
    oscillator, settings = simulation.oscillator, simulation.settings
    sentences = [*_about_settings(simulation, values, bounded), *_about_start(simulation.adapted)]
    if not math.isfinite(values["amplitude_mean_square"]):
        return (*sentences, "the response is not a finite number: a much finer step may help.")
    energy = 0.5 * oscillator.natural_frequency**2 * values["amplitude_mean_square"]
    gained, its_error = _energy_drift(rows)
    settled = oscillator.excitation.intensity > 0.0 and transient_left(oscillator, settings) <= MOST_TRANSIENT
    if settled and math.isfinite(its_error) and abs(gained) > max(FAR_OFF * its_error, 0.02 * energy):
        sentences.append(
            f"the mean energy still changed by {per_cent(gained / energy)} over the window "
            f"({gained / its_error:.0f} standard errors), so it is not stationary yet: use a longer run and a later "
            "window."
        )
    if settled:
        sentences.extend(_about_memory(oscillator, values, errors))
    residual, error = values["energy_residual"], errors["energy_residual"]
    # with a large energy the rounding of single-precision memory shows, and is accepted
    energy_supplied = 0.5 * oscillator.excitation.intensity * (settings.window[1] - settings.window[0])
    floor = max(0.01, 1e-4 * energy / energy_supplied) if energy_supplied > 0.0 else 0.01
    if math.isfinite(error) and abs(residual) > max(FAR_OFF * error, floor):
        sentences.append(
            f"the energy balance fails by {per_cent(residual)} of the input power (standard error "
            f"{per_cent(error, 1)}): repeat the run with a finer step before you trust it."
        )
    if not bounded:
        sentences.extend(_about_slow_impacts(simulation, values))
    return tuple(sentences)


def _about_start(adapted: Adapted | None) -> list[str]:
    if adapted is None:
        return []
    if adapted.residual is None or adapted.residual_se is None:
        return [
            "the adapted start was taken from averaging and was not checked: long enough pilot runs would take "
            "too much time."
        ]
    if adapted.residual > MOST_RESIDUAL:
        return [
            f"the adapted start was off by {per_cent(adapted.residual)} of the root mean square displacement "
            f"(standard error {per_cent(adapted.residual_se, 1)}) before its last correction."
        ]
    return []


def _energy_drift(rows: Floats) -> tuple[float, float]:
    """Mean energy gained over the window, and its standard error."""
    gained = rows[:, COLUMNS.index("energy_last")] - rows[:, COLUMNS.index("energy_first")]
    return float(gained.mean()), standard_error(gained)


def _about_memory(oscillator: Oscillator, values: dict[str, float], errors: dict[str, float]) -> list[str]:
    """Warn if the start still acts through the memory: the mean force of the springpot is then not 0."""
    order = oscillator.springpot.order
    force, error = values["springpot_force_mean"], errors["springpot_force_mean"]
    spring = oscillator.natural_frequency**2 * abs(values["x_mean"])
    if not 0.0 < order < 1.0 or abs(force) <= max(FAR_OFF * error, MOST_REMEMBERED * spring):
        return []
    return [
        f"the springpot remembers the start: its mean force is {per_cent(abs(force) / spring)} of the spring's (0 in "
        f"the stationary state) and decays only like t^-{order:.2g}, so mean displacement and impact rate are not yet "
        "stationary (energies are barely affected). Use start='stationary' for them."
    ]


def _about_settings(simulation: Simulation, values: dict[str, float], bounded: bool) -> list[str]:
    sentences = []
    oscillator, settings, scales = simulation.oscillator, simulation.settings, simulation.scales
    fastest, limit = scales.fastest_rate, settings.numerical_scheme.coarsest_step
    if settings.step * fastest > limit * (1.0 + 1e-9) and not bounded:
        so_long = f"step is {settings.step:g} s, {settings.step * fastest:.2g} of the shortest time scale: "
        sentences.append(
            f"{so_long}stationary averages of motion and impacts have no error of the step at order 1, but transients, "
            f"spectra, extremes and first passages have; use at most {limit / fastest:.2g} s for these."
            if keeps_the_law(oscillator, settings.scheme)
            else f"{so_long}expect errors of about 1 % above {limit:g}; use at most {limit / fastest:.2g} s."
        )
    left = transient_left(oscillator, settings)
    if oscillator.excitation.intensity > 0.0 and left > MOST_TRANSIENT and not bounded:
        sentences.append(
            "without dissipation there is no stationary state: the averages are those of a growing response."
            if math.isinf(scales.energy_time)
            else f"window starts at {settings.window[0]:g} s, when about {per_cent(left)} of the transient is "
            f"left: start it after {4.6 * scales.relaxation_time:.3g} s for stationary values."
        )
    size = math.sqrt(max(values["x_mean_square"], 0.0))
    if settings.scheme == "grunwald" and oscillator.barrier is not None and settings.contact_tolerance > 1e-3 * size:
        sentences.append(
            f"contact_tolerance is {settings.contact_tolerance:g} m, which is not small compared with the root mean "
            f"square displacement of {size:.2g} m: the response is biased by about their ratio; use at most "
            f"{1e-4 * size:.1g} m."
        )
    if oscillator.barrier is not None and not impacts_are_countable(oscillator):
        sentences.append(
            f"restitution {oscillator.restitution:g} is not above {COLLAPSE_BELOW:.3f} (= exp(-pi/sqrt 3)): "
            "white noise causes infinitely many impacts in a finite time, so impact rate and speeds are undefined; "
            "energies are still correct."
        )
    return sentences


def _about_slow_impacts(simulation: Simulation, values: dict[str, float]) -> list[str]:
    """Warn if the step misses more than MOST_MISSED of the impacts."""
    oscillator, settings = simulation.oscillator, simulation.settings
    if oscillator.barrier is None or not impacts_are_countable(oscillator):
        return []
    missed = missed_impacts(oscillator, settings.step, values["impact_speed_mean_square"])
    if missed <= MOST_MISSED:
        return []
    order = slow_impact_order(oscillator.restitution)
    return [
        f"impact rate is about {per_cent(missed)} too low and the mean impact speed "
        f"{per_cent(missed / (1.0 - missed))} too high at a step of {settings.step:g} s: the step misses slow impacts "
        f"behind this lossy wall, and the error decreases only like step^{order:.2g}; energies are correct. With "
        "rtol= the error is bounded."
    ]


def about_uncontrolled_impacts(reached: Reached, quantities: Sequence[str], rtol: float) -> list[str]:
    """Warn of large errors of impact rate and speed in a run with ``rtol`` that does not control them."""
    left = {
        name: reached.budgets[name].total / abs(reached.values[name])
        for name in ("impact_rate", "impact_speed_mean")
        if name not in quantities and reached.values.get(name, 0.0) != 0.0
    }
    off = [f"{name} {per_cent(share)}" for name, share in left.items() if share > max(3.0 * rtol, 2.0 * MOST_MISSED)]
    if not off:
        return []
    return [
        f"quantities does not name these results, which may be wrong by up to: {', '.join(off)}; name them to "
        "bound their errors."
    ]


def about_observables(names: Iterable[str], values: dict[str, float]) -> list[str]:
    """Warn of observables without a finite value."""
    return [
        f"observable {name} is not a finite number: its function raised an error, or is not finite everywhere."
        for name in names
        if not math.isfinite(values[name])
    ]


def without_effect(oscillator: Oscillator, given: Options) -> list[str]:
    """One sentence for each argument that was given and changes nothing.

    Parameters
    ----------
    oscillator : Oscillator
    given : dict
        The arguments that the user gave, without defaults.

    Returns
    -------
    list of str

    Examples
    --------
    >>> without_effect(Oscillator(), {"contact_tolerance": 1e-4})
    ["contact_tolerance has no effect without scheme='grunwald'."]
    """
    order = oscillator.springpot.order
    sentences = []
    if "contact_tolerance" in given:
        if given.get("scheme", "default") != "grunwald":
            sentences.append("contact_tolerance has no effect without scheme='grunwald'.")
        elif oscillator.barrier is None:
            sentences.append("contact_tolerance has no effect without a wall.")
    if "derivative" in given:
        if order == 0.0:
            sentences.append("derivative has no effect at order 0: both derivatives are x itself.")
        elif given["derivative"] == "riemann-liouville" and _starts_at_zero(oscillator, given):
            sentences.append(
                "derivative='riemann-liouville' has no effect with x(0) = 0: both derivatives are the same."
            )
    no_memory = order in (0.0, 1.0) or oscillator.springpot.coefficient == 0.0
    # a smaller tolerance also means double precision, so it has an effect
    if no_memory and given.get("memory_tolerance", 0.0) >= SINGLE_PRECISION:
        what = "a coefficient of 0" if oscillator.springpot.coefficient == 0.0 else f"order {order:g}"
        sentences.append(f"memory_tolerance has no effect at {what}: there is no memory.")
    return sentences


def _starts_at_zero(oscillator: Oscillator, given: Options) -> bool:
    position = given.get("initial_position")
    if position is not None or oscillator.barrier is None:
        return not position
    return oscillator.direction * oscillator.barrier.position <= 0.0  # at the equilibrium, otherwise on the wall


def about_quantiles(
    oscillator: Oscillator, step: float, speeds: Distribution, probability: Sequence[float]
) -> list[str]:
    """Warn of quantiles of the impact speed whose step bias is larger than their standard error."""
    missed = slow_impacts(oscillator, step, speeds)
    if missed is None:
        return []
    at, error = speeds.quantile(probability)
    bias = quantile_step_bias(missed, speeds, probability)
    off = (bias > NORMAL * error) & (bias > LEAST_BIAS * at)  # False where there is no error
    if not off.any():
        return []
    named = ", ".join(
        f"{per_cent(p, 3)} (by up to {per_cent(b / x)})"
        for p, b, x in zip(np.asarray(probability)[off], bias[off], at[off], strict=True)
    )
    return [
        f"the step of {step:g} s misses slow impacts, so these quantiles of the impact speed are wrong: {named}. "
        "impact_speed_quantile_step_bias bounds the error; a shorter step reduces it."
    ]
