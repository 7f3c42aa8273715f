"""The stationary start: an initial displacement without a slow transient of the mean.

From rest the mean displacement rises to its stationary value, and the memory of this rise is a force
C E[x] t^-alpha / Gamma(1 - alpha), which decays only like t^-alpha: with a small order even a long run is not
stationary.  With Caputo's derivative, an empty memory and x(0) = E[x] there is no such force.  E[x] is the fixed point
of the function m -> mean displacement of a run that starts at m.  It is found by a secant iteration over short pilot
runs with the same normals; a last pilot run with independent normals measures the residual.
"""

from __future__ import annotations

import math
from dataclasses import replace

from springpot.oscillator import Barrier, Oscillator
from springpot.simulation.scales import scales_of
from springpot.simulation.schemes import Splitting
from springpot.simulation.settings import Settings
from springpot.simulation.simulation import Adapted, Progress, simulation_of
from springpot.simulation.statistics import controlled, standard_error
from springpot.theory import averaging

__all__ = ["adapt"]

PILOT_PATHS = (8192, 65536)
FEWEST_PATHS = 1024
PILOT_PATH_STEPS = 2e8  # bound on the work of one pilot
WANTED = 0.002  # change of x(0), relative to the root mean square displacement, at which the iteration ends
SETTLED = 3.0  # relaxation times before a pilot run may begin to average
MOST_PILOTS = 8  # before the one that measures the residual


def adapt(
    oscillator: Oscillator, settings: Settings, *, paths: int | None = None, progress: Progress | None = None
) -> Adapted:
    """Find x(0) = E[x] for a stationary start.

    Parameters
    ----------
    oscillator : Oscillator
    settings : Settings
        Of the run to come; its seed and threads are used.
    paths : int
        Most paths of a pilot run; if left out, as many as the run has, within [8192, 65536].
    progress : callable, optional
        Called with 0 after every block of paths; whatever it raises ends the search.

    Returns
    -------
    Adapted
        Without a wall x(0) = 0 by symmetry, and no pilot is run.
    """
    if oscillator.barrier is None:
        return Adapted(0.0, 0.0, 0.0, 0.0, 0)
    most = min(max(settings.paths, PILOT_PATHS[0]), PILOT_PATHS[1]) if paths is None else paths
    pilot = _pilot_settings(oscillator, settings, most)
    alive = None if progress is None else (lambda _: progress(0.0))
    sign = oscillator.direction
    wall = sign * oscillator.barrier.position
    now = max(wall, abs(averaging(replace(oscillator, barrier=Barrier(0.0, oscillator.restitution))).x_mean))
    if pilot.window[0] < SETTLED * scales_of(oscillator).energy_time:
        return Adapted(sign * now, None, None, None, 0)

    def mean(position: float, stream: int) -> tuple[float, float, float]:
        """Mean displacement (seen from a wall below) from this start, its error, the root mean square."""
        simulation = simulation_of(oscillator, replace(pilot, initial_position=sign * position))
        estimates = simulation.samples(simulation.advance(stream=stream, progress=alive).rows)
        means = controlled(estimates["x_mean"][1], estimates["energy_residual"][1][:, None])
        return sign * float(means.mean()), standard_error(means), estimates["x_mean_square"][0] ** 0.5

    tried: list[tuple[float, float]] = []  # starts and the means they reached
    while True:
        reached, error, spread = mean(now, 1)
        tried.append((now, reached))
        # impacts separate paths with the same normals, so that two pilots differ at least by their standard errors
        if abs(reached - now) <= max(WANTED * spread, error) or len(tried) == MOST_PILOTS:
            break
        now = max(wall, now + (reached - now) / (1.0 - _slope(tried)))
    check, its_error, spread = mean(now, 2)
    # the fixed point from the last two pilots, which have independent normals
    settled = now + (0.5 * (reached + check) - now) / (1.0 - _slope(tried))
    return Adapted(
        position=sign * max(wall, settled),
        residual=abs(check - now) / spread,
        residual_se=its_error / spread,
        error=0.5 * math.hypot(error, its_error) / (1.0 - _slope(tried)) / spread,
        pilots=len(tried) + 1,
    )


def _slope(tried: list[tuple[float, float]]) -> float:
    """Change of the mean reached per change of the start, from the last two pilots.

    The influence of the start decays, so the slope lies in [0, 1); anything else is sampling error.
    """
    if len(tried) < 2 or tried[-1][0] == tried[-2][0]:
        return 0.0
    (start, reached), (later_start, later_reached) = tried[-2:]
    return min(max((later_reached - reached) / (later_start - start), 0.0), 0.9)


def _pilot_settings(oscillator: Oscillator, settings: Settings, most: int) -> Settings:
    """Ten relaxation times at a coarse step of the default scheme; the average is over the last six."""
    scales = scales_of(oscillator)
    step = 8.0 * (Splitting.default_step / scales.fastest_rate)
    cycle = 5.0 / oscillator.natural_frequency
    duration = 10.0 * max(scales.energy_time, min(scales.creep_time, 20.0 * cycle), cycle)
    steps = round(min(duration / step, PILOT_PATH_STEPS / FEWEST_PATHS))
    paths = int(min(most, max(FEWEST_PATHS, PILOT_PATH_STEPS / steps)))
    return replace(
        settings,
        paths=paths,
        duration=steps * step,
        step=step,
        window=(steps * 2 // 5 * step, steps * step),
        scheme="default",
        initial_velocity=0.0,
        memory_tolerance=max(settings.memory_tolerance, 1e-6),
        record=0,
    )
