"""What observers cost: time per path-step of a springpot with a wall, against the same run without them."""

from __future__ import annotations

from typing import Any

from benchmarks.measure import Row, cpu_by_turns
from springpot import Barrier, Basquin, Oscillator, Springpot, WhiteNoise
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.watch.requested import requested

__all__ = ["observers"]

_STEP = 0.01
_FREQUENCIES = [4.0 + 0.2 * n for n in range(20)]
_ASKED: dict[str, dict[str, Any]] = {
    "nothing": {},
    "distributions": {"distributions": True},
    "distributions, of the springpot's force too": {"distributions": True, "forces": ["springpot_force"]},
    "a spectrum of 20 frequencies": {"spectrum": _FREQUENCIES},
    "two spectra, one of the springpot's force": {"spectrum": _FREQUENCIES, "forces": ["springpot_force"]},
    "first passages of x, 1 level": {"first_passage": {"x": 3.0}},
    "first passages of x, 5 levels": {"first_passage": {"x": [2.0, 2.5, 3.0, 3.5, 4.0]}},
    "a profile of 20 bins": {"profile": 20},
    "the force of the spring": {"forces": ["spring_force"]},
    "the force of the springpot": {"forces": ["springpot_force"]},
    "the force on the ground and the impulses": {"forces": ["force_on_ground", "barrier_impulse"]},
    "rainflow of x": {"rainflow": {"x": Basquin(5.0)}},
    "rainflow of the springpot's force": {"rainflow": {"springpot_force": Basquin(5.0)}},
}


def observers(quick: bool) -> list[Row]:
    """Rows of the section on observers; the cases are run by turns, and each has its least time."""
    paths, steps, turns = (64, 400, 1) if quick else (256, 10_000, 41)
    system = Oscillator(1.0, Springpot(0.5, 0.5), Barrier(-0.5, 0.9), WhiteNoise(1.0))
    asked: Any = {"paths": paths, "duration": _STEP * steps, "step": _STEP, "threads": 1, "start": "rest"}
    plan = plan_of(system, **asked, window=(0.0, _STEP * steps)).but(initial_position=0.0)
    works = {}
    for name, wishes in _ASKED.items():
        simulation = simulation_of(plan)
        own = requested(plan, wishes).observers
        works[name] = lambda run=simulation.advance, own=own: run(observers=own)
        works[name]()  # compiled
    least = cpu_by_turns(works, turns)
    plain = least["nothing"]
    return [
        Row("observers", name, 1e9 * taken / (paths * steps), "ns per path-step", taken / plain, "the plain run")
        for name, taken in least.items()
    ]
