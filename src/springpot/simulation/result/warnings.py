"""Warnings of a run: one sentence for each reason to doubt a number, and for each argument without effect."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import listed, per_cent
from springpot.problem.parts import Springpot
from springpot.simulation.estimate.few_events import about_few
from springpot.simulation.estimate.samples import impacts_of, watched_time
from springpot.simulation.estimate.slow_impacts import (
    missed_impacts,
    quantile_step_bias,
    slow_impact_order,
    slow_impacts,
)
from springpot.simulation.estimate.step_biases import impact_biases
from springpot.simulation.kernel.block import COLUMNS
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.statistics import NORMAL, standard_error
from springpot.simulation.plan.adapted import Adapted
from springpot.simulation.plan.options import Options
from springpot.simulation.plan.plan import Plan, default_start
from springpot.simulation.plan.settings import SINGLE_PRECISION
from springpot.simulation.plan.transient import MOST_TRANSIENT
from springpot.simulation.watch.distributions import Distribution
from springpot.theory.walls import about_walls, named_walls

if TYPE_CHECKING:
    from springpot.simulation.error.reach import Reached

__all__ = ["about_observables", "about_options", "about_quantiles", "about_uncontrolled_impacts", "doubts"]

Floats = npt.NDArray[np.float64]
Values = Mapping[str, float]

FAR_OFF = 5.0  # standard errors beyond which a mean that should be 0 gives a warning
MOST_RESIDUAL = 0.01  # of an adapted start
MOST_REMEMBERED = 0.03  # mean force of the memory over the springs', in the window
MOST_MISSED = 0.01  # of the impacts, by estimate
LEAST_BIAS = 0.01  # of a quantile; a smaller one gives no warning
GUESSED_DRIFT, DRIFT = 0.04, 0.02  # change of the energy over the window that gives a warning, over the energy


def doubts(simulation: Simulation, values: Values, errors: Values, rows: Floats, *, bounded: bool = False) -> list[str]:
    """One sentence for each reason to doubt a number of a run.

    ``bounded``: the total errors include those of step and transient, so these give no warning.
    """
    system = simulation.motion.system
    if not all(math.isfinite(values[name]) for name in ("x_mean_square", "v_mean_square")):
        own = listed(system.with_functions, "or")
        cause = f": the function of {own} returns no number, or the step is too long." if own else (
            ": a much finer step may help."
        )  # fmt: skip
        return [f"the response is not a finite number{cause}"]
    of_the_step = [] if bounded else [*_about_step(simulation), *_about_window(simulation)]
    return [
        *_about_contact_tolerance(simulation, values),
        *_about_counts(simulation),
        *of_the_step,
        *_about_start(simulation.plan.adapted),
        *_about_energy(simulation, values, errors, rows),
        *_about_memory(simulation, values, errors),
        *([] if bounded else _about_slow_impacts(simulation, values)),
        *_about_walls(simulation, values, rows),
    ]


def _about_contact_tolerance(simulation: Simulation, values: Values) -> Iterator[str]:
    settings, size = simulation.settings, math.sqrt(max(values["x_mean_square"], 0.0))
    if settings.scheme == "grunwald" and simulation.motion.walls and settings.contact_tolerance > 1e-3 * size:
        yield (
            f"contact_tolerance is {settings.contact_tolerance:g} m, which is not small compared with the root mean "
            f"square displacement of {size:.2g} m: the response is biased by about their ratio; use at most "
            f"{1e-4 * size:.1g} m."
        )


def _about_counts(simulation: Simulation) -> Iterator[str]:
    if reason := simulation.motion.uncountable:
        yield (
            f"impact rate and speeds are undefined, but energies are correct: {reason}. slowest_counted_impact counts "
            "those that are faster."
        )


def _about_step(simulation: Simulation) -> Iterator[str]:
    settings, fastest = simulation.settings, simulation.motion.scales.fastest_rate
    limit = settings.numerical_scheme.coarsest_step
    if settings.step * fastest <= limit * (1.0 + 1e-9):
        return
    so_long = f"step is {settings.step:g} s, {settings.step * fastest:.2g} of the shortest time scale: "
    if simulation.plan.keeps_the_law:
        yield (
            f"{so_long}stationary averages of motion and impacts have no error of the step at order 1, but transients, "
            f"spectra, extremes and first passages have; use at most {limit / fastest:.2g} s for these."
        )
    else:
        yield f"{so_long}expect errors of about 1 % above {limit:g}; use at most {limit / fastest:.2g} s."


def _about_window(simulation: Simulation) -> Iterator[str]:
    plan, scales = simulation.plan, simulation.motion.scales
    if plan.motion.recorded or plan.transient_left <= MOST_TRANSIENT:
        return
    if reason := plan.motion.not_stationary:
        yield f"there is no stationary state: {reason}."
        return
    yield (
        f"window starts at {plan.settings.window[0]:g} s, when about {per_cent(plan.transient_left)} of the transient "
        f"is left: start it after {4.6 * scales.relaxation_time:.3g} s for stationary values."
    )


def _about_start(adapted: Adapted | None) -> Iterator[str]:
    if adapted is None:
        return
    if adapted.residual is None or adapted.residual_se is None:
        yield (
            "the adapted start was taken from a rough theory and was not checked: long enough pilot runs would take "
            "too much time."
        )
    elif adapted.residual > MOST_RESIDUAL:
        yield (
            f"the adapted start was off by {per_cent(adapted.residual)} of the root mean square displacement "
            f"(standard error {per_cent(adapted.residual_se, 1)}) before its last correction."
        )


def _about_energy(simulation: Simulation, values: Values, errors: Values, rows: Floats) -> Iterator[str]:
    """Warn of an energy that still changes, and of a balance that fails."""
    plan, scales, mass = simulation.plan, simulation.motion.scales, simulation.motion.system.inertia
    drift = rows[:, COLUMNS.index("energy_last")] - rows[:, COLUMNS.index("energy_first")]
    gained, its_error = float(drift.mean()), standard_error(drift)
    square = values.get("amplitude_mean_square", math.nan) * simulation.motion.system.natural_frequency**2
    energy = 0.5 * (values["v_mean_square"] if scales.guessed else square)
    settled = not plan.motion.not_stationary and plan.transient_left <= (
        math.exp(-3.0) if scales.guessed else MOST_TRANSIENT
    )
    most = GUESSED_DRIFT if scales.guessed else DRIFT
    if settled and energy > 0.0 and math.isfinite(its_error) and abs(gained) > max(FAR_OFF * its_error, most * energy):
        yield (
            f"the mean energy still changed by {per_cent(gained / energy)} over the window "
            f"({gained / its_error:.0f} standard errors), so it is not stationary yet: use a longer run and a later "
            "window."
        )
    residual, error = values.get("energy_residual", 0.0), errors.get("energy_residual", math.nan)
    supplied = values.get("input_power", 0.0) / mass * (plan.settings.window[1] - plan.settings.window[0])
    # with a large energy the rounding of single-precision memory shows, and is accepted
    floor = max(0.01, 1e-4 * energy / supplied) if supplied > 0.0 else 0.01
    if math.isfinite(error) and abs(residual) > max(FAR_OFF * error, floor):
        yield (
            f"the energy balance fails by {per_cent(residual)} of the input power (standard error "
            f"{per_cent(error, 1)}): repeat the run with a finer step before you trust it."
        )


def _about_memory(simulation: Simulation, values: Values, errors: Values) -> Iterator[str]:
    """Warn if the start still acts through the memory: its mean force is then not 0."""
    motion, error = simulation.motion, errors.get("damping_force_mean", math.nan)
    if not motion.springpots or motion.not_stationary or simulation.plan.transient_left > MOST_TRANSIENT:
        return
    stiffness = motion.system.inertia * motion.scales.frequency**2
    size = stiffness * (math.sqrt(values["x_mean_square"]) if motion.scales.guessed else abs(values["x_mean"]))
    force = abs(values.get("damping_force_mean", 0.0))
    if math.isfinite(error) and force > max(FAR_OFF * error, MOST_REMEMBERED * size):
        slowest = min(pot.order for pot in motion.springpots)
        yield (
            f"the memory still acts of the start: its mean force is {per_cent(force / size)} of the springs' (0 in "
            f"the stationary state) and decays only like t^-{slowest:.2g}, so mean displacement and impact rate are "
            "not yet stationary (energies are barely affected). Use start='stationary' for them."
        )


def _about_slow_impacts(simulation: Simulation, values: Values) -> Iterator[str]:
    """Warn if the step misses more than MOST_MISSED of the impacts."""
    motion, step, rate = simulation.motion, simulation.settings.step, values.get("impact_rate", 0.0)
    bound = impact_biases(motion, step, dict(values)).get("impact_rate", 0.0)
    if not bound > 0.0 or not rate > 0.0:
        return
    missed = missed_impacts(motion.struck, step, values["impact_speed_mean_square"])
    order = slow_impact_order(motion.struck.restitution)
    if motion.struck.crowded and missed > MOST_MISSED:
        yield (
            f"impact rate is about {per_cent(missed)} too low and the mean impact speed "
            f"{per_cent(missed / (1.0 - missed))} too high at a step of {step:g} s: the step misses slow impacts "
            f"behind this lossy wall, and the error decreases only like step^{order:.2g}; energies are "
            "correct. With rtol= the error is bounded."
        )
    elif not motion.struck.crowded and bound > MOST_MISSED * rate:
        low = f"may be {per_cent(bound / rate)} too low" if bound < rate else "is far too low"
        yield (
            f"impact rate {low} at a step of {step:g} s: the step misses slow impacts behind a lossy wall; energies "
            "are correct."
        )


def _about_walls(simulation: Simulation, values: Values, rows: Floats) -> Iterator[str]:
    """One sentence for each wall that is misplaced, it seems, or of which few impacts were seen."""
    system = simulation.motion.system
    rates = {name: values[f"{name}_impact_rate"] for name in named_walls(system)}
    said = about_walls(system, values["x_mean"], values["x_mean_square"], values["v_mean_square"], rates)
    yield from said.values()
    impacts = impacts_of(simulation, rows)
    few = {name: impacts[name] for name, rate in rates.items() if math.isfinite(rate) and name not in said}
    yield from about_few(few, watched_time(simulation, rows))


def about_uncontrolled_impacts(reached: Reached, rtol: float) -> list[str]:
    """Warn of large errors of impact rate and speed in a run with ``rtol`` that does not control them."""
    left = {
        name: reached.budgets[name].total / abs(reached.values[name])
        for name in ("impact_rate", "impact_speed_mean")
        if name not in reached.wanted and name in reached.budgets and reached.values.get(name, 0.0) != 0.0
    }
    off = [f"{name} {per_cent(share)}" for name, share in left.items() if share > max(3.0 * rtol, 2.0 * MOST_MISSED)]
    if not off:
        return []
    return [
        f"quantities does not name these results, which may be wrong by up to: {', '.join(off)}; name them to "
        "bound their errors."
    ]


def about_observables(names: Iterable[str], values: Values) -> list[str]:
    """Warn of observables without a finite value."""
    return [
        f"observable {name} is not a finite number: its function raised an error, or is not finite everywhere."
        for name in names
        if not math.isfinite(values[name])
    ]


def about_options(plan: Plan, given: Mapping[str, Any]) -> list[str]:
    """One sentence for a start from rest that the user did not choose, and for each argument that changes nothing.

    Parameters
    ----------
    plan : Plan
    given : dict
        The arguments that the user gave, without defaults.

    Returns
    -------
    list of str

    Examples
    --------
    >>> from springpot.problem.oscillator import Oscillator
    >>> from springpot.simulation.plan.plan import plan_of
    >>> about_options(plan_of(Oscillator()), {"contact_tolerance": 1e-4})
    ["contact_tolerance has no effect without scheme='grunwald'."]
    """
    motion, sentences = plan.motion, []
    _, reason = default_start(motion, cast(Options, given))
    if given.get("start") is None and reason:
        sentences.append(f"the run starts from rest, because there is no stationary state: {reason}.")
    if "contact_tolerance" in given:
        if given.get("scheme", "default") != "grunwald":
            sentences.append("contact_tolerance has no effect without scheme='grunwald'.")
        elif not motion.walls:
            sentences.append("contact_tolerance has no effect without a wall.")
    if "derivative" in given and not any(pot.order > 0.0 for pot in motion.system.of(Springpot)):
        sentences.append("derivative has no effect: no springpot has an order above 0.")
    elif given.get("derivative") == "riemann-liouville" and plan.settings.initial_position == 0.0:
        sentences.append("derivative='riemann-liouville' has no effect with x(0) = 0: both derivatives are the same.")
    # a smaller tolerance also means double precision, so it has an effect
    if not motion.remembers and given.get("memory_tolerance", 0.0) >= SINGLE_PRECISION:
        sentences.append("memory_tolerance has no effect: no part has memory.")
    return sentences


def about_quantiles(simulation: Simulation, speeds: Distribution, probability: Sequence[float]) -> list[str]:
    """Warn of quantiles of the impact speed whose step bias is larger than their standard error."""
    step = simulation.settings.step
    missed = slow_impacts(simulation.motion.struck, step, speeds)
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
