"""What more masses cost: time per path-step against one mass with one springpot and its wall, at the same step."""

from __future__ import annotations

import itertools
import time

from benchmarks.measure import Row, cpu_by_turns
from springpot import Barrier, Dashpot, Mass, Oscillator, Spring, Springpot, System, WhiteNoise
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.plan.plan import plan_of

__all__ = ["several_masses"]

_STEP = 0.02
_CASES = (2, 2, 0), (2, 2, 2), (4, 4, 0), (4, 4, 2), (8, 0, 0), (8, 8, 0), (8, 8, 4)  # masses, springpots, walls


def _row_of(masses: int, springpots: int, walls: int) -> System:
    """Masses in a row from the ground, with white noise on each; where there is no springpot there is a dashpot."""
    points = [f"m{n}" for n in range(masses)]
    ends = [*itertools.pairwise(("ground", *points))]
    return System(
        *(Mass(1.0 - 0.05 * n, at=point) for n, point in enumerate(points)),
        *(WhiteNoise(0.5, on=point) for point in points), *(Spring(6.0, between=e) for e in ends),
        *(Springpot(0.5, 0.3, between=e) if n < springpots else Dashpot(0.2, between=e) for n, e in enumerate(ends)),
        *(Barrier(-0.3 if n else -0.2, 0.9, "above", between=e) for n, e in enumerate(ends[:walls])),
    )  # fmt: skip


def several_masses(quick: bool) -> list[Row]:
    """Rows of the section on several masses; the cases are run by turns, and each has its least time."""
    section = "several masses"
    steps, turns = (200, 1) if quick else (10_000, 15)
    problems = {
        "one mass, one springpot, its wall": Oscillator(1.0, Springpot(0.5, 1.0), Barrier(0.0), WhiteNoise(1.0))
    }
    problems |= {"{} masses, {} springpots, {} walls".format(*case): _row_of(*case) for case in _CASES}
    prepared, first = dict[str, Simulation](), {}
    for name, problem in problems.items():
        begun = time.perf_counter()
        plan = plan_of(problem, paths=512, duration=_STEP * steps, step=_STEP, threads=1, start="rest")
        prepared[name] = simulation_of(plan)
        prepared[name].but(duration=0.4, window=(0.0, 0.4)).advance()
        first[name] = time.perf_counter() - begun
    least = cpu_by_turns({name: simulation.advance for name, simulation in prepared.items()}, turns)
    base, *_ = least.values()
    return [
        Row(section, name, 1e9 * taken / (512 * steps), "ns per path-step", taken / base, "one mass",
            f"{first[name]:.1f} s before the first path, from the cache or compiled")
        for name, taken in least.items()
    ]  # fmt: skip
