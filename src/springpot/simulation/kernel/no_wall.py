"""No wall in the kernel, and what walls answer that do not answer themselves."""

from __future__ import annotations

from typing import NamedTuple

from springpot.simulation.kernel.lanes import typed
from springpot.simulation.kernel.questions import (
    Euler,
    Splitting,
    answers,
    begin,
    bounce,
    clearance,
    drift,
    extras,
    gather,
    held_by,
    in_lanes,
    limited,
    meet,
    stay,
)  # fmt: skip


class NoWall(NamedTuple):
    """No wall (with an unused field, because Numba cannot type an empty tuple)."""

    unused: float


@answers(extras, NoWall)
def _no_extras(wall):
    return 0


@answers(clearance, Euler, NoWall)
@answers(clearance, Splitting, NoWall)
def _clear_of_nothing(scheme, wall, least, greatest):
    return typed(1.0, least)


@answers(bounce, Euler, NoWall)
@answers(bounce, Splitting, NoWall)
def bounce_never(scheme, wall, x, v, push, accumulators, lane, before, after):
    xm, vm, xn, vn = drift(scheme, x, v)
    return x + xm, v + vm, x + xn, v + vn


@answers(begin, Splitting, NoWall)
def _begin_free(scheme, wall, x, v, early, accumulators, lane, weight):
    moved, change, _, _ = drift(scheme, x, v)
    return x + moved + early, v + change


@answers(in_lanes, object, object)
def _not_in_lanes(scheme, wall):
    return False


@answers(meet, object, object)
def _meet_nothing(scheme, wall, x, v):
    xm, vm, dx, dv = drift(scheme, x, v)
    nothing = typed(0.0, x)
    return xm, vm, dx, dv, (nothing, nothing), (nothing, nothing), False


@answers(held_by, object, object)
def _not_held(scheme, wall, x, v):
    return 0.0


@answers(stay, object, object)
def _not_staying(scheme, wall, side, x, moving, impulse, others, pull, accumulators, lane, weight):
    return impulse, moving, pull, 0.0


@answers(limited, object)
def _not_limited(wall, x):
    return x


@answers(gather, object)
def _gather_nothing(wall, struck, accumulators, clear, within, beyond):
    return 0


@answers(begin, Euler, NoWall)
def begin_euler(scheme, wall, x, v, early, accumulators, lane, weight):
    return x, v
