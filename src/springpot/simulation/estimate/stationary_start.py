"""The stationary start: an initial displacement without a slow transient of the mean.

From rest the mean displacement rises to its stationary value, and the memory of this rise is a force
C E[x] t^-alpha / Gamma(1 - alpha), which decays only like t^-alpha: with a small order even a long run is not
stationary.  With Caputo's derivative, an empty memory and x(0) = E[x] there is no such force.  E[x] is the fixed point
of the function m -> mean displacement of a run that starts at m.  It is found by a secant iteration over short pilot
runs with the same normals; a last pilot run with independent normals measures the residual.
"""

from __future__ import annotations

import math

from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.paths.statistics import controlled, standard_error
from springpot.simulation.plan.adapted import Adapted
from springpot.simulation.plan.plan import TOO_FAR_APART, Plan
from springpot.simulation.plan.schemes import Splitting

PILOT_PATHS = (8192, 65536)
FEWEST_PATHS = 1024
PILOT_PATH_STEPS = 2e8  # bound on the work of one pilot
WANTED = 0.002  # change of x(0), relative to the root mean square displacement, at which the iteration ends
SETTLED = 3.0  # relaxation times before a pilot run may begin to average
MOST_PILOTS = 8  # before the one that measures the residual


def adapt(plan: Plan, *, paths: int | None = None, progress: Progress | None = None) -> Plan:
    """Find x(0) = E[x] for a stationary start.

    Parameters
    ----------
    plan : Plan
        Of the run to come; its seed and threads are used.
    paths : int
        Most paths of a pilot run; if left out, as many as the run has, within [8192, 65536].
    progress : callable, optional
        Called with 0 after every block of paths; whatever it raises ends the search.

    Returns
    -------
    Plan
        With x(0).  No pilot is run where x(0) = 0 by symmetry, where nothing remembers x(0), or where x(0) is drawn
        from Boltzmann's law; a start from rest stays as it is.
    """
    motion = plan.motion
    if plan.settings.start == "rest":
        return plan
    if not motion.searched:
        return plan.started_at(Adapted(motion.scales.mean, 0.0, 0.0, 0.0, 0))
    most = min(max(plan.settings.paths, PILOT_PATHS[0]), PILOT_PATHS[1]) if paths is None else paths
    pilot = _pilot(plan, most)
    alive = None if progress is None else (lambda _: progress(0.0))
    sign, (low, high) = motion.sign, sorted((motion.sign * motion.low, motion.sign * motion.high))
    now = sign * motion.scales.mean
    if pilot.settings.window[0] < SETTLED * motion.scales.energy_time:
        return plan.started_at(Adapted(sign * now, None, None, None, 0))

    def mean(position: float, stream: int) -> tuple[float, float, float]:
        """Mean displacement (seen from a wall below) from this start, its error, the root mean square."""
        simulation = simulation_of(pilot.but(initial_position=sign * position))
        estimates = samples_of(simulation, simulation.advance(stream=stream, progress=alive).rows)
        means = estimates["x_mean"][1]
        if "energy_residual" in estimates:
            means = controlled(means, estimates["energy_residual"][1][:, None])
        return sign * float(means.mean()), standard_error(means), estimates["x_mean_square"][0] ** 0.5

    tried: list[tuple[float, float]] = []  # starts and the means they reached
    while True:
        reached, error, spread = mean(now, 1)
        tried.append((now, reached))
        # impacts separate paths with the same normals, so that two pilots differ at least by their standard errors
        if abs(reached - now) <= max(WANTED * spread, error) or len(tried) == MOST_PILOTS:
            break
        now = min(max(low, now + (reached - now) / (1.0 - _slope(tried))), high)
    check, its_error, spread = mean(now, 2)
    if not 0.0 < spread < math.inf:
        raise ValueError(TOO_FAR_APART)
    # the fixed point from the last two pilots, which have independent normals
    settled = now + (0.5 * (reached + check) - now) / (1.0 - _slope(tried))
    found = Adapted(
        position=sign * min(max(low, settled), high),
        residual=abs(check - now) / spread,
        residual_se=its_error / spread,
        error=0.5 * math.hypot(error, its_error) / (1.0 - _slope(tried)) / spread,
        pilots=len(tried) + 1,
    )
    return plan.started_at(found)


def _slope(tried: list[tuple[float, float]]) -> float:
    """Change of the mean reached per change of the start, from the last two pilots.

    The influence of the start decays, so the slope lies in [0, 1); anything else is sampling error.
    """
    if len(tried) < 2 or tried[-1][0] == tried[-2][0]:
        return 0.0
    (start, reached), (later_start, later_reached) = tried[-2:]
    return min(max((later_reached - reached) / (later_start - start), 0.0), 0.9)


def _pilot(plan: Plan, most: int) -> Plan:
    """Ten relaxation times at a coarse step of the default scheme; the average is over the last six."""
    scales = plan.motion.scales
    step = 8.0 * (Splitting.default_step / scales.fastest_rate)
    cycle = 5.0 / scales.frequency
    duration = 10.0 * max(scales.energy_time, min(scales.creep_time, 20.0 * cycle), cycle)
    steps = round(min(duration / step, PILOT_PATH_STEPS / FEWEST_PATHS))
    return plan.but(
        paths=int(min(most, max(FEWEST_PATHS, PILOT_PATH_STEPS / steps))),
        duration=steps * step,
        step=step,
        window=(steps * 2 // 5 * step, steps * step),
        scheme="default",
        initial_velocity=0.0,
        memory_tolerance=max(plan.settings.memory_tolerance, 1e-6),
        record=0,
    )
