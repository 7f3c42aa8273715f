"""The stationary start: initial displacements without a slow transient of their means.

From rest the mean displacement rises to its stationary value, and the memory of this rise is a force
C E[x] t^-alpha / Gamma(1 - alpha), which decays only like t^-alpha: with a small order even a long run is not
stationary.  With Caputo's derivative, an empty memory and x(0) = E[x] there is no such force: the history of every
springpot is then its own mean.  E[x], of all masses at once, is the fixed point of the function m -> mean displacements
of a run that starts at m.  It is found by a secant iteration over short pilot runs with the same normals, with one
slope for all masses; a last pilot run with independent normals measures the residual.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.paths.statistics import controlled, standard_error
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import TOO_FAR_APART, Adapted, Plan
from springpot.simulation.plan.schemes import Splitting

FEWEST_PATHS, ENOUGH_PATHS, MOST_PATHS = 1024, 8192, 65536
PATHS_OF_A_FEW = 16  # paths of a pilot for each path of a run with so few that these are less than enough
PILOT_PATH_STEPS = 2e8  # bound on the work of one pilot
WANTED = 0.002  # change of x(0), relative to the root mean square displacement, at which the iteration ends
SETTLED = 3.0  # relaxation times before a pilot run may begin to average
MOST_PILOTS = 8  # before the one that measures the residual
CLEAR = 0.2  # root mean squares between the starts of two pilots that show how results change with x(0)


def pilot_paths(paths: int) -> int:
    """Most paths of a pilot for a run of so many: the error of x(0) must be small beside that of the run.

    Examples
    --------
    >>> [pilot_paths(paths) for paths in (10, 100, 5000, 20_000, 10**6)]
    [1024, 1600, 8192, 20000, 65536]
    """
    return max(min(ENOUGH_PATHS, max(FEWEST_PATHS, PATHS_OF_A_FEW * paths)), min(paths, MOST_PATHS))


def adapt(plan: Plan, *, paths: int | None = None, progress: Progress | None = None) -> Plan:
    """Find x(0) = E[x] for a stationary start.

    Parameters
    ----------
    plan : Plan
        Of the run to come; its seed and threads are used.
    paths : int
        Most paths of a pilot run; if left out, `pilot_paths` of those of the run.
    progress : callable, optional
        Called with 0 after every block of paths; whatever it raises ends the search.

    Returns
    -------
    Plan
        With x(0).  No pilot is run where the means that memory keeps are 0 by symmetry, where nothing remembers x(0),
        or where x(0) is drawn from Boltzmann's law; a start from rest stays as it is.
    """
    motion = plan.motion
    if plan.settings.start == "rest":
        return plan
    now = motion.near_mean
    if not motion.searched:
        return plan.started_at(Adapted(motion.system.coordinates.as_given(now), 0.0, 0.0, 0.0, 0))
    pilot = _pilot(plan, pilot_paths(plan.settings.paths) if paths is None else paths)
    if pilot.settings.window[0] < SETTLED * motion.scales.energy_time:
        return plan.started_at(Adapted(motion.system.coordinates.as_given(now), None, None, None, 0))
    free = np.array([name not in motion.zeros for name in motion.mean_names])
    tried: list[_Pilot] = []
    while True:
        tried.append(_run(pilot, now, 1, progress))
        # impacts separate paths with the same normals, so that two pilots differ at least by their standard errors
        near = np.abs(tried[-1].change) <= np.maximum(WANTED * tried[-1].spread, tried[-1].errors)
        if near[free].all() or len(tried) == MOST_PILOTS:
            break
        further = now + tried[-1].change / (1.0 - _slope(tried))
        now = motion.within_walls(np.where(free, further, now))
    check = _run(pilot, now, 2, progress)
    if not all(0.0 < spread < math.inf for spread in check.spread[free]):
        raise ValueError(TOO_FAR_APART)
    last, slope = tried[-1], _slope(tried)
    # the fixed point from the last two pilots, which have independent normals
    settled = now + (0.5 * (last.reached + check.reached) - now) / (1.0 - slope)
    residuals = np.divide(np.abs(check.change), check.spread, out=np.zeros(free.size), where=free)
    worst = int(residuals.argmax())
    errors = 0.5 * np.hypot(last.errors, check.errors) / (1.0 - slope)
    errors = np.divide(errors, check.spread, out=np.zeros(free.size), where=free)
    way, slopes = _way(tried, motion)
    found = Adapted(
        position=motion.system.coordinates.as_given(motion.within_walls(np.where(free, settled, now))),
        residual=float(residuals[worst]),
        residual_se=float(check.errors[worst] / check.spread[worst]),
        # as if the errors of all masses were one
        error=float(np.abs(way) @ errors if slopes else errors.max()),
        pilots=len(tried) + 1,
        slopes=slopes,
    )
    return plan.started_at(found)


@dataclass(frozen=True, eq=False)
class _Pilot:
    """A pilot run: where it started, the means it reached with their errors, root mean squares, and all its results."""

    start: Floats
    reached: Floats
    errors: Floats
    spread: Floats
    values: dict[str, float]

    @property
    def change(self) -> Floats:
        return self.reached - self.start

    def apart(self, other: _Pilot) -> Floats:
        """The way from the start of another to its own, over the root mean squares."""
        way = self.start - other.start
        return np.divide(way, self.spread, out=np.zeros_like(way), where=(way != 0.0) & (self.spread > 0.0))


def _run(pilot: Plan, start: Floats, stream: int, progress: Progress | None) -> _Pilot:
    motion, alive = pilot.motion, None if progress is None else (lambda _: progress(0.0))
    simulation = simulation_of(pilot.but(initial_position=motion.system.coordinates.as_given(start)))
    estimates = samples_of(simulation, simulation.advance(stream=stream, progress=alive).rows)
    means = [estimates[name][1] for name in motion.mean_names]
    if "energy_residual" in estimates:
        means = [controlled(own, estimates["energy_residual"][1][:, None]) for own in means]
    values = {name: value for name, (value, _) in estimates.items()}
    return _Pilot(
        start,
        np.array([float(own.mean()) for own in means]),
        np.array([standard_error(own) for own in means]),
        np.array([motion.square_about_origin(values, name) ** 0.5 for name in motion.mean_names]),
        values,
    )


def _slope(tried: Sequence[_Pilot]) -> float:
    """Change of the means reached per change of the start, from the last two pilots: one number for all masses.

    Each counts by the square of its change over its root mean square.  The influence of the start decays, so the slope
    lies in [0, 1); anything else is sampling error.
    """
    if len(tried) < 2:
        return 0.0
    before, after = tried[-2:]
    squares = after.apart(before) ** 2
    moved = squares > 0.0
    if not moved.any():
        return 0.0
    with np.errstate(all="ignore"):  # of means at the end of double precision
        each = (after.reached - before.reached)[moved] / (after.start - before.start)[moved]
        slope = float((squares[moved] / squares[moved].sum()) @ each)
    return min(max(slope, 0.0), 0.9) if math.isfinite(slope) else 0.0


def _way(tried: Sequence[_Pilot], motion: Motion) -> tuple[Floats, dict[str, float]]:
    """The direction between the starts of two pilots that are clearly apart, and how results change along it.

    The later ones, since they are nearer to the end; none where the error of x(0) fades, or all pilots are near.
    """
    last = tried[-1]
    for other in reversed(tried[:-1]) if motion.left_of_start(1.0, 0.0) is None else ():
        way = last.apart(other)
        if (length := float(np.linalg.norm(way))) >= CLEAR:
            changes = {name: abs(value - other.values[name]) / length for name, value in last.values.items()}
            return way / length, changes
    return np.zeros_like(last.start), {}


def _pilot(plan: Plan, most: int) -> Plan:
    """Ten relaxation times at a coarse step of the default scheme; the average is over the last six."""
    motion = plan.motion
    scales = motion.scales
    step = 0.8 * Splitting.default_step / scales.fastest_rate
    steps = round(min(10.0 * motion.pilot_time / step, PILOT_PATH_STEPS / FEWEST_PATHS))
    return plan.but(
        paths=int(min(most, max(FEWEST_PATHS, PILOT_PATH_STEPS / steps))),
        duration=steps * step,
        step=step,
        window=(steps * 2 // 5 * step, steps * step),
        scheme=motion.scheme_for("default"),
        initial_velocity=motion.moving(None),
        memory_tolerance=max(plan.settings.memory_tolerance, 1e-6),
        record=0,
    )
