"""The flight of the bare oscillator over less than a quarter of a cycle with at most one impact, without angles.

Only additions, one root and one division are needed, so the same lines serve vector code and single paths.
"""

from __future__ import annotations

import math

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, greater, typed

LONGEST = 2.8  # phase of a whole step, of which each half is one flight


@njit(**INLINE)
def flight(frequency, place, side, restitution, x, v, moved, change):
    """From x, v, where the flight without a wall has the changes ``moved`` and ``change``.

    ``side`` is 1 for a wall at ``place`` below the motion, -1 above it.  Returns the changes, the speed of the impact
    or 0 if there is none, and whether this is sure: not if a preload brings the mass back to the wall at once.

    Let the free flight end at X, V.  The energy, which it keeps, gives the speed H at the wall, and with this the
    cosine and the sine of the phase that is left there; the rebound adds a flight from the wall's place with velocity
    (1 + r) H.  The energy is that of the beginning, so that a processor finds H while it turns x and v.
    """
    nothing, one = typed(0.0, x), typed(1.0, x)
    p, start, leaving = side * place, side * x, side * v
    x1, v1 = start + side * moved, leaving + side * change
    square = frequency * frequency
    total = leaving * leaving + square * (start * start)
    at_wall = leaving * leaving + square * ((start - p) * (start + p))
    speed = at_wall * (one / math.sqrt(at_wall))  # which processors do sooner than the root itself; NaN if not possible
    share = (one + restitution) * speed / total
    possible = at_wall > nothing
    # with a gap it may also have turned round behind the wall
    dipped = (p < nothing) & (leaving < nothing) & (v1 > nothing) & possible
    beyond = x1 < p
    struck = (beyond | dipped) & possible
    x2 = x1 - share * (speed * x1 + p * v1)
    v2 = v1 + share * (square * p * x1 - speed * v1)
    sure = (possible | (not beyond)) & (((p <= nothing) | (x2 >= p)) | (not struck))
    dx = side * (greater(x2, p) - start)
    dv = side * (v2 - leaving)
    return dx if struck else moved, dv if struck else change, speed if struck else nothing, sure
