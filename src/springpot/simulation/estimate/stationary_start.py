"""The stationary start: an initial displacement without a slow transient of the mean.

From rest the mean displacement rises to its stationary value, and the memory of this rise is a force
C E[x] t^-alpha / Gamma(1 - alpha), which decays only like t^-alpha: with a small order even a long run is not
stationary.  With Caputo's derivative, an empty memory and x(0) = E[x] there is no such force.  E[x] is the fixed point
of the function m -> mean displacement of a run that starts at m.  It is found by a secant iteration over short pilot
runs with the same normals; a last pilot run with independent normals measures the residual.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from springpot.problem.oscillator import Barrier, Oscillator
from springpot.problem.parts import FractionalMaxwell, Maxwell, PiezoelectricCircuit, Springpot, ThermalNoise
from springpot.problem.system import System
from springpot.simulation.estimate.statistics import controlled, standard_error
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.schemes import Splitting
from springpot.simulation.plan.settings import TOO_FAR_APART, Settings
from springpot.simulation.plan.start import Adapted
from springpot.simulation.plan.system_scales import is_symmetric, scales_of_problem, system_scales, typical_frequency
from springpot.theory import averaging

__all__ = ["adapt"]

PILOT_PATHS = (8192, 65536)
FEWEST_PATHS = 1024
PILOT_PATH_STEPS = 2e8  # bound on the work of one pilot
WANTED = 0.002  # change of x(0), relative to the root mean square displacement, at which the iteration ends
SETTLED = 3.0  # relaxation times before a pilot run may begin to average
MOST_PILOTS = 8  # before the one that measures the residual


def adapt(
    problem: Oscillator | System, settings: Settings, *, paths: int | None = None, progress: Progress | None = None
) -> Adapted:
    """Find x(0) = E[x] for a stationary start.

    Parameters
    ----------
    problem : Oscillator or System
    settings : Settings
        Of the run to come; its seed and threads are used.
    paths : int
        Most paths of a pilot run; if left out, as many as the run has, within [8192, 65536].
    progress : callable, optional
        Called with 0 after every block of paths; whatever it raises ends the search.

    Returns
    -------
    Adapted
        No pilot is run where x(0) = 0 by symmetry, where nothing remembers x(0), or where x(0) is drawn from
        Boltzmann's law.
    """
    guess = _guess(problem)
    if not guess.searched:
        return Adapted(guess.position, 0.0, 0.0, 0.0, 0)
    most = min(max(settings.paths, PILOT_PATHS[0]), PILOT_PATHS[1]) if paths is None else paths
    pilot = _pilot_settings(problem, settings, most)
    alive = None if progress is None else (lambda _: progress(0.0))
    sign, now = guess.sign, guess.position
    if pilot.window[0] < SETTLED * scales_of_problem(problem).energy_time:
        return Adapted(sign * now, None, None, None, 0)

    def mean(position: float, stream: int) -> tuple[float, float, float]:
        """Mean displacement (seen from a wall below) from this start, its error, the root mean square."""
        simulation = simulation_of(problem, replace(pilot, initial_position=sign * position))
        estimates = simulation.samples(simulation.advance(stream=stream, progress=alive).rows)
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
        now = guess.inside(now + (reached - now) / (1.0 - _slope(tried)))
    check, its_error, spread = mean(now, 2)
    if not 0.0 < spread < math.inf:
        raise ValueError(TOO_FAR_APART)
    # the fixed point from the last two pilots, which have independent normals
    settled = now + (0.5 * (reached + check) - now) / (1.0 - _slope(tried))
    return Adapted(
        position=sign * guess.inside(settled),
        residual=abs(check - now) / spread,
        residual_se=its_error / spread,
        error=0.5 * math.hypot(error, its_error) / (1.0 - _slope(tried)) / spread,
        pilots=len(tried) + 1,
    )


@dataclass(frozen=True)
class _Guess:
    """A first x(0), seen from a wall below; its sign in the user's coordinate; the walls; whether pilots are needed."""

    position: float
    sign: float = 1.0
    low: float = -math.inf
    high: float = math.inf
    searched: bool = True

    def inside(self, position: float) -> float:
        """The nearest place between the walls."""
        return min(max(self.low, position), self.high)


def _guess(problem: Oscillator | System) -> _Guess:
    if isinstance(problem, System):
        law, low, high = system_scales(problem).law, problem.potential.low, problem.potential.high
        return _Guess(law.mean, 1.0, low, high, _remembers(problem) and not problem.of(ThermalNoise))
    if problem.barrier is None:
        return _Guess(0.0, searched=False)
    sign = problem.direction
    wall = sign * problem.barrier.position
    mean = abs(averaging(replace(problem, barrier=Barrier(0.0, problem.restitution))).x_mean)
    return _Guess(max(wall, mean), sign, wall)


def _remembers(system: System) -> bool:
    """Whether the past acts, and E[x] is not 0 by symmetry."""
    memory = system.of(FractionalMaxwell, Maxwell, PiezoelectricCircuit) or [
        pot for pot in system.of(Springpot) if pot.remembers
    ]
    return bool(memory) and not is_symmetric(system)


def _slope(tried: list[tuple[float, float]]) -> float:
    """Change of the mean reached per change of the start, from the last two pilots.

    The influence of the start decays, so the slope lies in [0, 1); anything else is sampling error.
    """
    if len(tried) < 2 or tried[-1][0] == tried[-2][0]:
        return 0.0
    (start, reached), (later_start, later_reached) = tried[-2:]
    return min(max((later_reached - reached) / (later_start - start), 0.0), 0.9)


def _pilot_settings(problem: Oscillator | System, settings: Settings, most: int) -> Settings:
    """Ten relaxation times at a coarse step of the default scheme; the average is over the last six."""
    scales = scales_of_problem(problem)
    step = 8.0 * (Splitting.default_step / scales.fastest_rate)
    cycle = 5.0 / typical_frequency(problem)
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
