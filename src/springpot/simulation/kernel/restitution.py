"""Restitution in the kernel: a number, a power of the speed, or a user's function of it.

``share_left(rule, speed)``
    The restitution at a speed.
``rebound(rule, arriving, frequency, accumulators, place, lane, weight)``
    The speed after an impact.  Speeds are over ``frequency``.  A rule other than a number adds the energy that the wall
    takes to sum ``place`` of the walls' own, and the momentum to the next one.
``lossless(rule)``
    Whether every impact is elastic.
``number_of(rule)``
    The restitution, if it is a number; otherwise NaN.
``takings(rule)``
    How many sums the rule needs: 2, or 0 for a number, for which they follow from the speeds and their squares.
"""

from __future__ import annotations

import itertools
import math
from collections import namedtuple
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

from numba import float64, njit

from springpot.problem.parts import Barrier
from springpot.problem.parts.walls import PowerRestitution, Restitution
from springpot.simulation.kernel.lanes import INLINE, LANES, lesser
from springpot.simulation.kernel.questions import answers
from springpot.simulation.kernel.user_functions import inlined


class Fixed(NamedTuple):
    """A number."""

    restitution: float


class Power(NamedTuple):
    """The least of 1 and restitution (v / speed)^-exponent."""

    restitution: float
    speed: float
    exponent: float


def share_left(rule: Any, speed: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def lossless(rule: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def number_of(rule: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def takings(rule: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


@answers(share_left, Fixed)
def _share_fixed(rule, speed):
    return rule.restitution


@answers(lossless, Fixed)
def _lossless_fixed(rule):
    return rule.restitution == 1.0


@answers(number_of, Fixed)
def _number_of_fixed(rule):
    return rule.restitution


@answers(takings, Fixed)
def _takings_of_number(rule):
    return 0


@answers(share_left, Power)
def _share_of_power(rule, speed):
    return lesser(1.0, rule.restitution * (speed / rule.speed) ** -rule.exponent) if speed > 0.0 else 1.0


@answers(lossless, Power)
def _lossless_power(rule):
    return False


@answers(number_of, Power)
def _no_number(rule):
    return math.nan


@answers(takings, Power)
def _takings_of_power(rule):
    return 2


@njit(**INLINE)
def rebound(rule, arriving, frequency, accumulators, place, lane, weight):
    """Compiled code only; see the module's text."""
    speed = frequency * arriving
    share = share_left(rule, speed)
    if takings(rule) > 0:
        accumulators.extras[place * LANES + lane] += weight * 0.5 * (1.0 - share * share) * speed * speed
        accumulators.extras[(place + 1) * LANES + lane] += weight * (1.0 + share) * speed
    return share * arriving


def rule_of(wall: Barrier, name: str, unit: float) -> Any:
    """The kernel's rule for a wall.

    Parameters
    ----------
    wall : Barrier
    name : str
        Of the wall, for the sentence.
    unit : float
        The kernel's unit of speed, in m/s.

    Raises
    ------
    ValueError
        If Numba cannot compile the function of the speed.
    """
    law = wall.restitution
    if isinstance(law, PowerRestitution):
        return Power(law.restitution, law.speed / unit, law.exponent)
    if isinstance(law, Restitution):
        return _of_function(type(law).formula, name, len(law.numbers))(unit, *law.values)
    return _of_function(law, name)(unit) if callable(law) else Fixed(law)


_numbers = itertools.count(1)


@lru_cache(maxsize=64)
def _of_function(function: Callable[..., float], name: str, numbers: int = 0) -> Any:
    """A type of rule of its own, because types choose the code; its fields are the unit of speed, and a law's numbers.

    What the function returns is cut off at 0 and 1, but not where it is no number.
    """
    inner = inlined(function, float64(*[float64] * (1 + numbers)), f"{name} has a restitution")
    make: Any = namedtuple  # a type checker wants the name to be known
    kind = make(f"UserRestitution{next(_numbers)}", ("unit", *(f"number_{n}" for n in range(numbers))))
    kind.__module__ = "__user__"  # so that its kernels are not kept on disk

    @answers(share_left, kind)
    def follow(rule, speed):
        share = inner(rule.unit * speed, *rule[1:])
        return 0.0 if share < 0.0 else 1.0 if share > 1.0 else share

    @answers(lossless, kind)
    def never(rule):
        return False

    answers(number_of, kind)(_no_number)

    @answers(takings, kind)
    def two(rule):
        return 2

    return kind
