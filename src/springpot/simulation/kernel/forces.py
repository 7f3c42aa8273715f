"""Forces in the kernel: what pushes the mass beside the linear spring, springpots and dashpots.

The module's text of `springpot.simulation.kernel.questions` says what the kernel asks a force.  All numbers are in the
kernel's units; impulses are those of a whole step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES, greater, lesser, typed
from springpot.simulation.kernel.questions import answers, damp, push, slots, supply, wake


class White(NamedTuple):
    """White noise."""

    strength: float  # sqrt(q h)


class Sum(NamedTuple):
    """Two forces, or sums of forces."""

    first: Any
    second: Any


@answers(slots, Sum)
def _slots_of_sum(force):
    return slots(force.first) + slots(force.second)


@answers(wake, Sum)
def _wake_sum(force, slot, who, stream, k0, k1, forcing):
    wake(force.first, slot, who, stream, k0, k1, forcing)
    wake(force.second, slot + slots(force.first), who, stream, k0, k1, forcing)


@answers(supply, Sum)
def _supply_sum(force, slot, group, who, stream, k0, k1, forcing):
    supply(force.first, slot, group, who, stream, k0, k1, forcing)
    supply(force.second, slot + slots(force.first), group, who, stream, k0, k1, forcing)


@answers(push, Sum)
def _push_sum(force, slot, n, x, v, g, forcing, at, lane, weight):
    noise, impulse = push(force.first, slot, n, x, v, g, forcing, at, lane, weight)
    more, again = push(force.second, slot + slots(force.first), n, x, v, g, forcing, at, lane, weight)
    return noise + more, impulse + again


@answers(damp, Sum)
def _damp_sum(force, slot, n, x, v, forcing, lane, weight, after):
    """The order is reversed after the kick, so that the whole step is symmetric."""
    if after:
        change = damp(force.second, slot + slots(force.first), n, x, v, forcing, lane, weight, after)
        return change + damp(force.first, slot, n, x, v + change, forcing, lane, weight, after)
    change = damp(force.first, slot, n, x, v, forcing, lane, weight, after)
    return change + damp(force.second, slot + slots(force.first), n, x, v + change, forcing, lane, weight, after)


def _nothing_named(force):
    return 0


def _one_named(force):
    return 1


def _wake_nothing(force, slot, who, stream, k0, k1, forcing):
    pass


def _supply_nothing(force, slot, group, who, stream, k0, k1, forcing):
    pass


def _damp_nothing(force, slot, n, x, v, forcing, lane, weight, after):
    return typed(0.0, v)


def only_pushes(kind: type, *, named: bool = False) -> None:
    """Register everything but `push` of a force that keeps no state, has no given impulses and is no damper.

    Parameters
    ----------
    kind : type
        Of the force.
    named : bool
        Whether its work is summed: its `push` then writes ``forcing.impulses[slot * LANES + lane]``.

    Raises
    ------
    ValueError
        If a part of this name and these fields is registered already.

    Examples
    --------
    >>> class Gust(NamedTuple):
    ...     impulse: float
    >>> only_pushes(Gust)
    """
    answers(slots, kind)(_one_named if named else _nothing_named)
    answers(wake, kind)(_wake_nothing)
    answers(supply, kind)(_supply_nothing)
    answers(damp, kind)(_damp_nothing)


only_pushes(White)


@answers(push, White)
def _push_white(force, slot, n, x, v, g, forcing, at, lane, weight):
    return force.strength * g, typed(0.0, x)


class Parametric(NamedTuple):
    """White noise of which one part multiplies x: one normal for both, since their sum has the sum of their variances.

    Named for its compensator: the mean work of the part that multiplies x, given x at the kick, is summed as its work.
    """

    square: float  # q h
    square_of_x: float  # q2 h
    feed: float  # q2 h / 2, less what dashpots and springpots take of it within the step


only_pushes(Parametric, named=True)


@answers(push, Parametric)
def _push_parametric(force, slot, n, x, v, g, forcing, at, lane, weight):
    forcing.impulses[slot * LANES + lane] = 0.0
    forcing.works[slot * LANES + lane] += weight * force.feed * x * x
    return math.sqrt(force.square + force.square_of_x * x * x) * g, typed(0.0, x)


class Cubic(NamedTuple):
    """A force -(k0 + k1 x + k2 x^2 + k3 x^3), times the step."""

    k0: float
    k1: float
    k2: float
    k3: float


only_pushes(Cubic, named=True)


@njit(**INLINE)
def cubic(force, x):
    """The law of `Cubic`."""
    return -(force.k0 + x * (force.k1 + x * (force.k2 + x * force.k3)))


@answers(push, Cubic)
def _push_cubic(force, slot, n, x, v, g, forcing, at, lane, weight):
    impulse = cubic(force, x)
    forcing.impulses[slot * LANES + lane] = impulse
    return typed(0.0, x), impulse


class Nonic(NamedTuple):
    """As `Cubic`, up to the ninth power."""

    k0: float
    k1: float
    k2: float
    k3: float
    k4: float
    k5: float
    k6: float
    k7: float
    k8: float
    k9: float


only_pushes(Nonic, named=True)


@njit(**INLINE)
def nonic(force, x):
    """The law of `Nonic`."""
    high = force.k5 + x * (force.k6 + x * (force.k7 + x * (force.k8 + x * force.k9)))
    return -(force.k0 + x * (force.k1 + x * (force.k2 + x * (force.k3 + x * (force.k4 + x * high)))))


@answers(push, Nonic)
def _push_nonic(force, slot, n, x, v, g, forcing, at, lane, weight):
    impulse = nonic(force, x)
    forcing.impulses[slot * LANES + lane] = impulse
    return typed(0.0, x), impulse


class PowerDamper(NamedTuple):
    """The dampers c2 v abs(v) and c3 v^3, each followed exactly for half a step."""

    quadratic: float  # c2 h / 2
    cubic: float  # c3 h


@answers(damp, PowerDamper)
def _damp_powers(force, slot, n, x, v, forcing, lane, weight, after):
    change = typed(0.0, v)
    if after:
        change = _cubically(force, v)
    left = v + change
    change -= left * (force.quadratic * abs(left)) / (typed(1.0, v) + force.quadratic * abs(left))
    if not after:
        change += _cubically(force, v + change)
    forcing.works[slot * LANES + lane] += _work(weight, v, change)
    return change


@njit(**INLINE)
def _cubically(force, v):
    one, square = typed(1.0, v), force.cubic * v * v
    root = math.sqrt(one + square)
    return -v * square / (root * (one + root))


@njit(**INLINE)
def _work(weight, v, change):
    """Work of a force that changes the velocity by ``change``."""
    return weight * change * (v + typed(0.5, v) * change)


class VanDerPolDamper(NamedTuple):
    """The damper mu (x^2 - l^2) v for half a step at the x of the kick: of second order, and it never turns v round."""

    rate: float  # mu h / 2
    square: float  # l^2


@answers(damp, VanDerPolDamper)
def _damp_van_der_pol(force, slot, n, x, v, forcing, lane, weight, after):
    a = force.rate * (x * x - force.square)
    growth = abs(a) + typed(0.5, a) * a * a
    change = -v * growth / (typed(1.0, a) + growth) if a > typed(0.0, a) else v * growth
    forcing.works[slot * LANES + lane] += _work(weight, v, change)
    return change


class CoulombDamper(NamedTuple):
    """Dry friction for half a step."""

    impulse: float  # F h / 2


@answers(damp, CoulombDamper)
def _damp_coulomb(force, slot, n, x, v, forcing, lane, weight, after):
    change = -lesser(greater(v, -force.impulse), force.impulse)
    forcing.works[slot * LANES + lane] += _work(weight, v, change)
    return change


def _push_nothing(force, slot, n, x, v, g, forcing, at, lane, weight):
    forcing.impulses[slot * LANES + lane] = 0.0
    return typed(0.0, x), typed(0.0, x)


def register_damper(
    kind: type, wakes: Callable[..., Any] = _wake_nothing, supplies: Callable[..., Any] = _supply_nothing
) -> None:
    """Register everything but `damp` of a damper, and what becomes of its state at time 0 and before each group.

    Its work is summed, and it does not push.
    """
    answers(slots, kind)(_one_named)
    answers(wake, kind)(wakes)
    answers(supply, kind)(supplies)
    answers(push, kind)(_push_nothing)


for _damper in (PowerDamper, VanDerPolDamper, CoulombDamper):
    register_damper(_damper)
