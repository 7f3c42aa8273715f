"""Signals, which observers see: displacements with their velocities, and outputs, by the names of their results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.catalogue import LEVELS
from springpot.problem.system import System


@dataclass(frozen=True, eq=False)
class Signal:
    """A displacement and its velocity; or a force or an absolute acceleration, which has the place of x.

    Attributes
    ----------
    names : dict
        The names of its results, by those of one mass: ``x``, ``v``, ``amplitude``, ``impact_speed``.
    number : int or None
        In the order in which the kernel shows displacements: of the coordinates, then of other rows; None of impacts
        alone.
    row : ndarray, shape (coordinates,)
        By which it is made of the coordinates.
    stop : str or None
        The wall or contact whose impacts belong to it; empty for all, None for none.
    place, side : float
        Of this wall: its position, NaN where it may be one of several, and 1 if the displacement stays above it, -1
        below.
    low, high : float
        Between which rigid walls keep it.
    outputs : tuple of int
        The number of a force or an acceleration among all outputs; empty of a displacement.
    peaks : bool
        Whether the impacts are the touches of a contact, with their largest forces in place of speeds.
    impulse : float
        Of an impact over its speed, in kg, where impulses take the place of speeds; otherwise 0.
    """

    names: Mapping[str, str] = field(default_factory=dict)
    number: int | None = 0
    row: Floats = field(default_factory=lambda: np.ones(1))
    stop: str | None = None
    place: float = 0.0
    side: float = 1.0
    low: float = -math.inf
    high: float = math.inf
    outputs: tuple[int, ...] = ()
    peaks: bool = False
    impulse: float = 0.0


def signals_of(system: System) -> tuple[Signal, ...]:
    """Each point and each pair, with the impacts on the wall at it; then those on other walls.

    A point alone has all impacts, and its amplitude.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Mass, Spring
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(1.0, between=("ground", "a")),
    ...     gap=Barrier(-0.1, between=("a", "b")), floor=Barrier(-1.0, between=("ground", "b")),
    ... )
    >>> for each in signals_of(pair):
    ...     print(each.number, each.names)
    0 {'x': 'a_x', 'v': 'a_v'}
    1 {'x': 'b_x', 'v': 'b_v', 'impact_speed': 'floor_impact_speed'}
    3 {'x': 'a_b_elongation', 'impact_speed': 'gap_impact_speed'}
    """
    at = system.coordinates
    if at.lone:
        names = ("x", "v", *(("amplitude",) if system.natural_frequency > 0.0 else ()), "impact_speed")
        return (replace(_alone(system), names={name: name for name in names}),)
    found = [_displacement(system, row, x=f"{own}x", v=f"{own}v") for own, row in at.beginnings.items()]
    found += [_displacement(system, row, x=f"{pair}_elongation") for pair, row in at.pairs.items()]
    there = {each.stop for each in found}
    others = [
        Signal({"impact_speed": f"{name}_impact_speed"}, None, stop=name) for name in system.stops if name not in there
    ]
    return (*found, *others)


def levels_of(system: System) -> dict[str, tuple[str, Signal]]:
    """What can pass a level, by name: the quantity of one mass, and the displacement that it is of.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> ends = ("ground", "a"), ("a", "b")
    >>> pair = System(Mass(1.0, at="a"), Mass(1.0, at="b"), *(Spring(1.0, between=each) for each in ends))
    >>> [name for name, (quantity, _) in levels_of(pair).items() if quantity == "x"]
    ['a_x', 'b_x', 'spring_1_elongation', 'spring_2_elongation', 'a_b_elongation']
    """
    at = system.coordinates
    if at.lone:  # an impact is reported without its place: of several walls it may be any, and ends of steps have to do
        one_wall = len(system.stops) == len(system.walls) <= 1
        return {name: (name, replace(_alone(system), stop="" if one_wall else None)) for name in LEVELS}
    found = dict[str, tuple[str, Signal]]()
    for begin, row in at.beginnings.items():
        own = _displacement(system, row)
        found |= {f"{begin}{quantity}": (quantity, own) for quantity in ("x", "v", "distance", "speed")}
    for name, row in {**at.elongations, **at.pairs}.items():
        own = _displacement(system, row)
        found |= {f"{name}_elongation": ("x", own), f"{name}_distance": ("distance", own)}
    return found


def _alone(system: System) -> Signal:
    """The only displacement: its impacts are all there are."""
    walls = [*system.walls.values()]
    place = walls[0].position if len(walls) == len(system.stops) == 1 else math.nan  # of several it may be any
    return replace(_displacement(system, system.coordinates.rows[0]), names={}, stop="", place=place, side=1.0)


def _displacement(system: System, row: Floats, **names: str) -> Signal:
    """With the walls along its row: between which it is, and the impacts if there is one wall or contact."""
    at, found = system.coordinates, []
    for name, part in system.stops.items():
        sign = next((sign for sign in (1.0, -1.0) if np.array_equal(at.elongations[name], sign * row)), 0.0)
        if sign:
            found.append((name, sign * part.position, sign * part.inwards))
    low = [place for name, place, side in found if name in system.walls and side > 0.0]
    high = [place for name, place, side in found if name in system.walls and side < 0.0]
    own = np.flatnonzero((at.rows[: len(at.names)] == row).all(axis=1))
    number = int(own[0]) if own.size else len(at.names) + at.numbers[tuple(row.tolist())]
    signal = Signal(names, number, row, low=max(low, default=-math.inf), high=min(high, default=math.inf))
    if len(found) != 1:
        return signal
    ((name, place, side),) = found
    return replace(
        signal, names={**signal.names, "impact_speed": f"{name}_impact_speed"}, stop=name, place=place, side=side
    )
