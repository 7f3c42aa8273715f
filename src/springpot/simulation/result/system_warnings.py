"""Warnings of a run of a system, and the bounds on what its step leaves: one sentence for each reason to doubt."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import listed, per_cent
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Barrier, RecordedExcitation, ThermalNoise, WhiteNoise
from springpot.problem.parts.walls import restitution_of_missed
from springpot.problem.system import System
from springpot.simulation.estimate.slow_impacts import impact_step_biases
from springpot.simulation.estimate.statistics import standard_error
from springpot.simulation.estimate.system_samples import uncountable
from springpot.simulation.kernel.block import COLUMNS
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.plan.settings import default_start
from springpot.simulation.plan.system_scales import system_scales
from springpot.simulation.plan.transient import MOST_TRANSIENT
from springpot.theory.mckean import COLLAPSE_BELOW

__all__ = ["doubts_of_system", "step_biases_of_system"]

Floats = npt.NDArray[np.float64]

_UNDEFINED = "impact rate and speeds are undefined, but energies are correct"
_FAR_OFF = 5.0  # standard errors beyond which a mean that should be 0 gives a warning
_MOST_MISSED = 0.01
_COUNTABLE = 1.0001 * COLLAPSE_BELOW
_MOST_REMEMBERED = 0.03


def step_biases_of_system(system: System, step: float, values: dict[str, float]) -> dict[str, float]:
    """Bounds on the step bias of impact rate and speeds behind lossy walls, as for an oscillator with that wall."""
    unit, biases = system.per_unit_mass, dict[str, float]()
    intensity = sum(noise.intensity for noise in unit.of(WhiteNoise))
    if uncountable(system) or not intensity > 0.0 or "impact_rate" not in values:
        return {}
    for wall in unit.of(Barrier):
        slow = restitution_of_missed(wall, intensity, step)
        if slow < 1.0:  # a law may be below the limit here and above it for slower impacts, of which most are missed
            alone = Oscillator(barrier=Barrier(0.0, max(slow, _COUNTABLE)), excitation=WhiteNoise(intensity))
            for name, bias in impact_step_biases(alone, step, values).items():
                biases[name] = max(bias, biases.get(name, 0.0))
    return biases


def doubts_of_system(
    simulation: Simulation, values: dict[str, float], errors: dict[str, float], rows: Floats, *, bounded: bool = False
) -> tuple[str, ...]:
    """One sentence for each reason to doubt a number of a run of a system.

    ``bounded``: the total errors include those of step and transient, so these give no warning.
    """
    system = simulation.problem
    if not isinstance(system, System):
        raise TypeError("the simulation must be of a system.")
    if not all(math.isfinite(values[name]) for name in ("x_mean_square", "v_mean_square")):
        own = listed(system.with_functions, "or")
        cause = f": the function of {own} returns no number, or the step is too long." if own else (
            ": a much finer step may help."
        )  # fmt: skip
        return (f"the response is not a finite number{cause}",)
    reason = uncountable(system)
    return (
        *([f"{_UNDEFINED}: {reason}. slowest_counted_impact counts those that are faster."] if reason else []),
        *([] if bounded else _about_step(simulation, values)),
        *([] if bounded else _about_window(simulation, system)),
        *_about_energy(simulation, rows, values, errors),
        *_about_start(simulation, system, values, errors),
    )


def _about_step(simulation: Simulation, values: dict[str, float]) -> Iterator[str]:
    settings, fastest = simulation.settings, simulation.scales.fastest_rate
    limit = settings.numerical_scheme.coarsest_step
    if settings.step * fastest > limit * (1.0 + 1e-9):
        yield (
            f"step is {settings.step:g} s, {settings.step * fastest:.2g} of the shortest time scale: expect errors of "
            f"about 1 % above {limit:g}; use at most {limit / fastest:.2g} s."
        )
    system = simulation.problem
    if isinstance(system, System):
        missed = step_biases_of_system(system, settings.step, values).get("impact_rate", 0.0)
        if missed > _MOST_MISSED * values.get("impact_rate", 0.0) > 0.0:
            share = missed / values["impact_rate"]
            low = f"may be {per_cent(share)} too low" if share < 1.0 else "is far too low"
            yield (
                f"impact rate {low} at a step of {settings.step:g} s: the step misses slow impacts behind "
                "a lossy wall; energies are correct."
            )


def _about_window(simulation: Simulation, system: System) -> Iterator[str]:
    settings, scales = simulation.settings, simulation.scales
    drawn = settings.start == "stationary" and bool(system.of(ThermalNoise))
    if drawn or bool(system.of(RecordedExcitation)):
        return
    _, reason = default_start(system)
    if reason:
        yield f"there is no stationary state: {reason}."
        return
    left = math.exp(-settings.window[0] / scales.relaxation_time)
    if left > MOST_TRANSIENT:
        yield (
            f"window starts at {settings.window[0]:g} s, when about {per_cent(left)} of the transient is left: "
            f"start it after {4.6 * scales.relaxation_time:.3g} s for stationary values."
        )


def _about_energy(
    simulation: Simulation, rows: Floats, values: dict[str, float], errors: dict[str, float]
) -> Iterator[str]:
    gained = rows[:, COLUMNS.index("energy_last")] - rows[:, COLUMNS.index("energy_first")]
    error, energy = standard_error(gained), 0.5 * values["v_mean_square"]
    settled = simulation.settings.window[0] > 3.0 * simulation.scales.relaxation_time
    if settled and energy > 0.0 and math.isfinite(error) and abs(gained.mean()) > max(_FAR_OFF * error, 0.04 * energy):
        yield (
            f"the mean energy still changed by {per_cent(gained.mean() / energy)} of the kinetic energy over the "
            "window, so it is not stationary yet: use a longer run and a later window."
        )
    residual, its_error = values.get("energy_residual", 0.0), errors.get("energy_residual", math.nan)
    if math.isfinite(its_error) and abs(residual) > max(_FAR_OFF * its_error, 0.01):
        yield (
            f"the energy balance fails by {per_cent(residual)} of the input power (standard error "
            f"{per_cent(its_error, 1)}): repeat the run with a finer step before you trust it."
        )


def _about_start(
    simulation: Simulation, system: System, values: dict[str, float], errors: dict[str, float]
) -> Iterator[str]:
    adapted = simulation.adapted
    if adapted is not None and adapted.residual is None:
        yield (
            "the adapted start was taken from a rough theory and was not checked: long enough pilot runs would take "
            "too much time."
        )
    force, error = abs(values.get("damping_force_mean", 0.0)), errors.get("damping_force_mean", math.nan)
    size = system.mass * system_scales(system).law.frequency ** 2 * math.sqrt(values["x_mean_square"])
    if math.isfinite(error) and force > max(_FAR_OFF * error, _MOST_REMEMBERED * size):
        yield (
            f"the memory still acts of the start: its mean force is {per_cent(force / size)} of what the springs need "
            "for the root mean square displacement, so mean displacement and impact rate are not yet stationary. Use "
            "start='stationary'."
        )
