"""A modal model as parts: a mass, a spring and a dashpot for each mode, and points that move as the modes say."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import check_plain, checked_name, numbers_in_array, one_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.problem.coordinates import MOST_PARTS
from springpot.problem.messages import StationarityWarning, say
from springpot.problem.parts import Dashpot, Mass, Point, Spring
from springpot.problem.parts.registration import Part

FrequencyUnit = Literal["rad/s", "Hz"]
MARK_PARTS = "mark numbers of the parts that are made"  # what a matrix or a list of modes cannot hold


def parts_of_modes(
    frequencies: ArrayLike,
    masses: ArrayLike,
    shapes: Mapping[str, ArrayLike],
    damping_ratios: ArrayLike = 0.0,
    participations: ArrayLike = 0.0,
    unit: FrequencyUnit = "rad/s",
) -> Iterator[Part]:
    """The parts of `springpot.System.from_modes`.

    Raises
    ------
    TypeError, ValueError
        If numbers are not as many as the modes, not finite or negative, or a shape has no name.

    Examples
    --------
    >>> [*parts_of_modes([2.0], [0.5], {"tip": [1.0]}, 0.1)][1:]
    [Spring(stiffness=2.0, between=('ground', 'mode_1')), Dashpot(coefficient=0.2, between=('ground', 'mode_1')), \
Point(at='tip', of=('mode_1',), shares=(1.0,))]
    """
    one_of(unit, "unit", get_args(FrequencyUnit), "It is that of frequencies.")
    w = numbers_for("frequencies", frequencies)
    size = len(w)
    m, ratios, moved = (
        numbers_for(name, given, size)
        for name, given in (
            ("masses", masses), ("damping_ratios", damping_ratios), ("participations", participations)
        )
    )  # fmt: skip
    for name, values in (("frequencies", w), ("damping_ratios", ratios)):
        if values.min() < 0.0:
            raise ValueError(f"{name} must not be negative, and {values.min():g} is among them.")
    if not m.min() > 0.0:
        raise ValueError(f"masses must be positive, and {m.min():g} is among them.")
    if not isinstance(shapes, Mapping) or not shapes:
        raise TypeError(f"shapes must say how points move, as {{'tip': [1.0, -1.0]}}, not {shown(shapes)}.")
    check_points(shapes, "shapes")
    rows = {point: numbers_for(f"shapes of {point}", row, size, several=True) for point, row in shapes.items()}
    say_if_free(int(np.count_nonzero(w == 0.0)))
    w = w * (2.0 * math.pi if unit == "Hz" else 1.0)
    yield from with_modes(m, w**2 * m, 2.0 * ratios * w * m, moved, rows)


def with_modes(
    masses: Floats, stiffnesses: Floats, dampings: Floats, participations: Floats, rows: Mapping[str, Floats]
) -> Iterator[Part]:
    """The parts of modes of which everything is known; springs and dashpots of 0 are left out.

    Examples
    --------
    >>> [*with_modes(*np.array([[2.0], [0.0], [0.0], [1.0]]), {"tip": np.array([1.0])})]
    [Mass(value=2.0, at='mode_1'), Point(at='tip', of=('mode_1',), shares=(1.0,))]
    """
    modes = [f"mode_{n + 1}" for n in range(len(masses))]
    if taken := [point for point in rows if point in modes]:
        raise ValueError(f"{listed(taken)} cannot be the name of a point, for a mode is called so.")
    for mode, mass, moved in zip(modes, masses.tolist(), participations.tolist(), strict=True):
        yield Mass(mass, at=mode, participation=moved)
    for kind, values in ((Spring, stiffnesses), (Dashpot, dampings)):
        for mode, value in zip(modes, values.tolist(), strict=True):
            if value:
                yield kind(value, between=("ground", mode))
    for point, row in rows.items():
        seen = [(mode, share) for mode, share in zip(modes, row.tolist(), strict=True) if share]
        yield Point(point, tuple(mode for mode, _ in seen) or (modes[0],), tuple(share for _, share in seen) or (0.0,))


def say_if_free(count: int) -> None:
    """Warn, where a function of the library was called, of motions that no spring holds."""
    if count:
        sentence = say("free_modes", count="1 mode has" if count == 1 else f"{count} modes have")
        warnings.warn(sentence, StationarityWarning, stacklevel=4)


def check_points(named: Mapping[Any, Any], name: str) -> None:
    """That points have names, and are not more than a system has parts.

    Raises
    ------
    ValueError
        If there is none, there are too many, or a name is none.

    Examples
    --------
    >>> check_points({"tip": [1.0]}, "shapes")
    """
    if not 0 < len(named) < MOST_PARTS:
        raise ValueError(f"{name} must be of 1 to {MOST_PARTS - 1} points, not of {len(named)}.")
    for point in named:
        checked_name(point, f"each name in {name}")


def rows_in(given: Any) -> int:
    """How many rows or numbers a list or an array has, before it is read.

    Examples
    --------
    >>> rows_in([[1.0], [2.0]]), rows_in(3.0)
    (2, 0)
    """
    try:
        return len(given)
    except Exception:  # of an array without a dimension, or whatever fails in its own way
        return 0


def numbers_for(
    name: str, given: ArrayLike, size: int | None = None, several: bool = False, each: str = "mode"
) -> Floats:
    """Finite numbers in a row, one for each mode; one number is that of all of them, unless ``several`` are needed.

    Raises
    ------
    TypeError, ValueError
        If they are not.

    Examples
    --------
    >>> numbers_for("masses", 2.0, 3).tolist()
    [2.0, 2.0, 2.0]
    """
    if (rows := rows_in(given)) >= MOST_PARTS and rows != size:
        raise ValueError(f"{name} must be fewer numbers than {MOST_PARTS}, the most parts of a system, not {rows:,}.")
    check_plain(given, name, MARK_PARTS)
    found = numbers_in_array(given, f"{name} must be numbers, one for each {each}")
    if found.ndim == 0 and size is not None and not several:
        found = np.full(size, float(found))
    if found.ndim != 1 or not found.size:
        raise ValueError(f"{name} must be numbers in a row, one for each {each}, not an array of shape {found.shape}.")
    if size is not None and len(found) != size:
        raise ValueError(f"{name} must be {size} numbers, one for each {each}, not {len(found)}.")
    if not np.all(np.isfinite(found)):
        raise ValueError(f"{name} must be finite numbers.")
    return found
