"""Random systems in which every kind of part stands beside every other kind that it may stand beside."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any

import numpy as np

from tests.golden import doors

__all__ = ["PARTS", "pairs_in", "system"]

Draw = np.random.Generator


def _push(t: float, x: float, v: float) -> float:
    return 0.05 * math.sin(t) - 0.02 * v + 0.0 * x


def _law(speed: float) -> float:
    return 0.9 / (1.0 + 0.1 * speed)


def _on(draw: Draw) -> str:
    return ("mass", "ground")[int(draw.integers(2))]


def _record(draw: Draw) -> Any:
    time = np.arange(0.0, 40.0, 0.5)
    return doors.recorded(tuple(time.tolist()), tuple(draw.normal(0.0, 0.3, time.size).tolist()), _on(draw))


PARTS: dict[str, Callable[[Draw], object]] = {
    "mass": lambda draw: doors.mass(draw.uniform(0.5, 2.0)),
    "spring": lambda draw: doors.spring(draw.uniform(0.5, 3.0)),
    "polynomial_spring": lambda draw: doors.polynomial_spring((draw.uniform(0.0, 0.5), 0.0, draw.uniform(0.01, 0.5))),
    "springpot": lambda draw: doors.springpot(draw.uniform(0.05, 0.95), draw.uniform(0.05, 0.8)),
    "springpot_0": lambda draw: doors.springpot(0.0, draw.uniform(0.05, 0.8)),
    "springpot_1": lambda draw: doors.springpot(1.0, draw.uniform(0.05, 0.5)),
    "series": lambda draw: doors.series(
        doors.springpot(draw.uniform(0.2, 0.9), 0.5), doors.spring(draw.uniform(0.5, 2.0))
    ),
    "maxwell": lambda draw: doors.maxwell(draw.uniform(0.2, 1.0), draw.uniform(0.2, 1.0)),
    "circuit": lambda draw: doors.circuit(draw.uniform(0.1, 0.5), draw.uniform(0.5, 2.0), draw.uniform(0.5, 2.0)),
    "dashpot": lambda draw: doors.dashpot(draw.uniform(0.05, 0.5)),
    "polynomial_dashpot": lambda draw: doors.polynomial_dashpot(
        (0.05, draw.uniform(0.0, 0.1), draw.uniform(0.01, 0.1))
    ),
    "van_der_pol": lambda draw: doors.van_der_pol(draw.uniform(0.02, 0.2), draw.uniform(0.5, 1.5)),
    "friction": lambda draw: doors.friction(draw.uniform(0.02, 0.2)),
    "wall": lambda draw: doors.wall(-draw.uniform(0.0, 1.5), draw.uniform(0.4, 1.0)),
    "wall_below": lambda draw: doors.wall(draw.uniform(0.2, 1.5), draw.uniform(0.4, 1.0), free_side="below"),
    "wall_elastic": lambda draw: doors.wall(-draw.uniform(0.0, 1.5)),
    "wall_power": lambda draw: doors.wall(-draw.uniform(0.3, 1.5), doors.power_restitution(0.8, 1.0, 0.2)),
    "wall_law": lambda draw: doors.wall(draw.uniform(0.3, 1.5), _law, free_side="below"),
    "contact": lambda draw: doors.contact(-draw.uniform(0.3, 1.0), draw.uniform(20.0, 200.0)),
    "contact_lossy": lambda draw: doors.contact(draw.uniform(0.3, 1.0), 50.0, 1.5, draw.uniform(0.1, 0.5), "below"),
    "white_noise": lambda draw: doors.white_noise(draw.uniform(0.2, 1.5), _on(draw)),
    "coloured_noise": lambda draw: doors.coloured_noise(draw.uniform(0.1, 0.8), draw.uniform(0.2, 2.0), _on(draw)),
    "filtered_noise": lambda draw: doors.filtered_noise(draw.uniform(1.0, 3.0), draw.uniform(0.2, 0.6), 0.3, _on(draw)),
    "thermal_noise": lambda draw: doors.thermal_noise(draw.uniform(0.1, 0.6)),
    "poisson_impulses": lambda draw: doors.poisson_impulses(draw.uniform(0.2, 1.0), draw.uniform(0.1, 0.5), _on(draw)),
    "parametric_noise": lambda draw: doors.parametric_noise(draw.uniform(0.001, 0.02)),
    "harmonic": lambda draw: doors.harmonic(draw.uniform(0.1, 0.6), draw.uniform(0.5, 2.0), _on(draw)),
    "constant": lambda draw: doors.constant(draw.uniform(-0.3, 0.3)),
    "recorded": _record,
    "force": lambda draw: doors.force(_push, 0.5),
}
"""Ways of making a part, each with numbers at random."""

FUNCTIONS = ("force", "wall_law")
"""Kinds with functions of the user, which are compiled anew in every process."""
_TRIES, _MOST, _SEED = 200, 7, 28
_OWN = 52  # systems that may have them
CHOSEN: tuple[int, ...] = (
    5, 55, 9, 21, 39, 15, 101, 10, 132, 186, 157, 183, 121, 160, 141, 28, 72, 152, 85, 15, 193, 38, 61, 21, 182, 20,
    105, 192, 110, 100, 159, 40, 27, 16, 11, 8, 18, 199, 11, 57, 183, 25, 92, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1,
    0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0,
    0, 1, 0, 0, 0, 72,
)  # fmt: skip
"""Of each system the try that was taken: fixed, so that the systems stay when other ones are refused.

All as `chosen` has it but the last, which has a harmonic force beside a springpot of order 1 and can be simulated."""


def _drawn(number: int, attempt: int) -> tuple[tuple[str, ...], list[Any]]:
    """Kinds of parts, and the parts; with a spring where nothing else holds the mass, mostly."""
    draw = np.random.default_rng([_SEED, number, attempt])
    size = int(draw.integers(2, _MOST + 1))
    kinds = [name for name in PARTS if number < _OWN or name not in FUNCTIONS]
    names = tuple(str(name) for name in draw.choice(kinds, size, replace=False))
    parts = [PARTS[name](draw) for name in names]
    if not any(doors.is_spring(part) for part in parts) and draw.random() < 0.9:
        parts.append(doors.spring(1.0))
    return names, parts


def system(number: int) -> tuple[tuple[str, ...], list[Any]]:
    """The kinds of parts of a system, and its parts."""
    return _drawn(number, CHOSEN[number])


def pairs_in(names: tuple[str, ...]) -> set[tuple[str, str]]:
    """All pairs among some kinds of parts, in alphabetical order."""
    return set(combinations(sorted(names), 2))


def chosen(count: int = 100) -> Iterator[int]:
    """Each time the one of many tries that fits together and has most pairs of parts that none before it has."""
    seen: set[tuple[str, str]] = set()
    for number in range(count):
        best = None
        for attempt in range(_TRIES):
            names, parts = _drawn(number, attempt)
            if best is None or len(pairs_in(names) - seen) > len(pairs_in(_drawn(number, best)[0]) - seen):
                try:
                    doors.system(*parts)
                except doors.REFUSALS:
                    continue
                best = attempt
        assert best is not None
        seen |= pairs_in(_drawn(number, best)[0])
        yield best


if __name__ == "__main__":
    print(tuple(chosen()))
