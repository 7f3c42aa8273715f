"""Forces in the kernel: what pushes the mass beside the linear spring, springpots and dashpots.

The module's text of `springpot.simulation.parts` says what the kernel asks a force.  All numbers are in the kernel's
units; impulses are those of a whole step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from springpot.simulation.parts import answers, damp, push, slots, supply, wake

__all__ = ["Sum", "White", "only_pushes"]


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
def _wake_sum(force, slot, first, stream, k0, k1, forcing):
    wake(force.first, slot, first, stream, k0, k1, forcing)
    wake(force.second, slot + slots(force.first), first, stream, k0, k1, forcing)


@answers(supply, Sum)
def _supply_sum(force, slot, group, first, stream, k0, k1, forcing):
    supply(force.first, slot, group, first, stream, k0, k1, forcing)
    supply(force.second, slot + slots(force.first), group, first, stream, k0, k1, forcing)


@answers(push, Sum)
def _push_sum(force, slot, n, x, v, g, forcing, at, lane, weight):
    noise, impulse = push(force.first, slot, n, x, v, g, forcing, at, lane, weight)
    more, again = push(force.second, slot + slots(force.first), n, x, v, g, forcing, at, lane, weight)
    return noise + more, impulse + again


@answers(damp, Sum)
def _damp_sum(force, slot, x, v, forcing, lane, weight, after):
    """The order is reversed after the kick, so that the whole step is symmetric."""
    if after:
        v = damp(force.second, slot + slots(force.first), x, v, forcing, lane, weight, after)
        return damp(force.first, slot, x, v, forcing, lane, weight, after)
    v = damp(force.first, slot, x, v, forcing, lane, weight, after)
    return damp(force.second, slot + slots(force.first), x, v, forcing, lane, weight, after)


def _nothing_named(force):
    return 0


def _one_named(force):
    return 1


def _wake_nothing(force, slot, first, stream, k0, k1, forcing):
    pass


def _supply_nothing(force, slot, group, first, stream, k0, k1, forcing):
    pass


def _damp_nothing(force, slot, x, v, forcing, lane, weight, after):
    return v


def only_pushes(kind: type, *, named: bool = False) -> None:
    """Register everything but `push` of a force that keeps no state, has no given impulses and is no damper.

    Parameters
    ----------
    kind : type
        Of the force.
    named : bool
        Whether its work is summed: its `push` then writes ``forcing.impulses[slot * LANES + lane]``.
    """
    answers(slots, kind)(_one_named if named else _nothing_named)
    answers(wake, kind)(_wake_nothing)
    answers(supply, kind)(_supply_nothing)
    answers(damp, kind)(_damp_nothing)


only_pushes(White)


@answers(push, White)
def _push_white(force, slot, n, x, v, g, forcing, at, lane, weight):
    return force.strength * g, 0.0
