"""Parts that yield, in the kernel of one mass and of several: their force depends on the way that x took.

The state is the place of a slider, at which the force is 0: the force is the stiffness times z = x - slider, and only
yielding moves the slider.  So a part that does not yield is a spring, and rounding does not add up.  The way is that of
the drift: from one kick to the next the slider follows x in one stroke, or in two where x turns, be it by a spring or
by an impact.  The kick has the force of its own z, half of it before and half after all that answers to it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba import njit

from springpot.simulation.kernel.forces import register_damper
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, greater, lesser, typed
from springpot.simulation.kernel.questions import answers, damp

STATES = 6 + GROUP
"""Of a part: slider, x and velocity after the last kick before the group, and after the last kick; z in the four steps.

A lane that is advanced again begins from the first three.
"""


class Plastic(NamedTuple):
    """Elastic, then perfectly plastic."""

    limit: float  # of z


class WholePower(NamedTuple):
    """The law of Bouc and Wen with an exponent of 1, 2, ... 50: vector code."""

    limit: float  # of z in a long stroke
    beta: float
    exponent: float


class AnyPower(NamedTuple):
    """The law of Bouc and Wen."""

    limit: float
    beta: float
    exponent: float


class Hysteresis(NamedTuple):
    """A part that yields."""

    impulse: float  # of its stiffness in half a step
    step: float
    place: int  # of its STATES among those of all forces
    law: Any


def stroke(law: Any, slider: Any, begin: Any, way: Any) -> Any:
    """Compiled code only: the slider after a straight way of x from ``begin``."""
    raise NotImplementedError


def raised(law: Any, ratio: Any) -> Any:
    """Compiled code only: the share of the yield force to the power of n - 1."""
    raise NotImplementedError


@answers(raised, WholePower)
def _raised_to_a_whole_number(law, ratio):
    """Product of those of the powers 1, 2, 4, ... 32 that the number has as binary digits."""
    left, power, factor = int(law.exponent) - 1, typed(1.0, ratio), ratio
    for _ in range(6):
        power *= factor if (left & 1) == 1 else typed(1.0, ratio)
        factor, left = factor * factor, left >> 1
    return power


@answers(raised, AnyPower)
def _raised(law, ratio):
    return ratio ** (law.exponent - typed(1.0, ratio))


@answers(stroke, Plastic)
def _stroke_plastic(law, slider, begin, way):
    end = begin + way
    return lesser(greater(slider, end - law.limit), end + law.limit)


@answers(stroke, WholePower)
@answers(stroke, AnyPower)
def _stroke_smooth(law, slider, begin, way):
    sign = typed(1.0, way) if way > typed(0.0, way) else typed(-1.0, way)
    return slider + sign * _slip(law, sign * (begin - slider), abs(way))


@njit(**INLINE)
def _slip(law, y, length):
    """How far the slider goes in a stroke of this length from z = y, both along the stroke.

    dz/dx = 1 - r^n where z has the sign of the stroke, and 1 + (2 beta - 1) r^n before it turns round.

    An exponential step of the second order in the length, and but for the exponential exact with n = 1.  Both cases are
    worked out and one is chosen, which vector code can do.
    """
    one, nothing = typed(1.0, y), typed(0.0, y)
    turn = law.beta + law.beta - one
    ratio = abs(y) / law.limit
    bent = raised(law, ratio)  # r^(n - 1)
    steep = one if y >= nothing else -turn
    power = steep * bent * ratio
    eased = _eased(abs(steep) * law.exponent * bent / law.limit * length)
    whole = greater(length * (eased + (one - eased) * power), y + length - law.limit)
    mean = typed(2.0, y) - power  # where it passes z = 0
    left = greater(length + (y + y) / mean, nothing)
    start = law.exponent * raised(law, nothing) / law.limit
    passed = greater(left * _eased(start * left), left - law.limit) - y * power / mean
    return passed if (y < nothing) & (y + length - whole > nothing) else whole


@njit(**INLINE)
def _eased(s):
    """1 - (1 - exp(-s)) / s, with 1 / (1 + s + s^2 / 2 + s^3 / 6) for the exponential: it never overshoots."""
    one, half = typed(1.0, s), typed(0.5, s)
    second, third = s * half, s * s * typed(1.0 / 6.0, s)
    return (second + third + third + s * third) / (one + s + s * second + s * third)


@njit(**INLINE)
def _followed(force, slider, x0, v0, x, v):
    """The slider at a kick, from what the last kick left."""
    way, nothing = x - x0, typed(0.0, x)
    # as far as the first of two straight lines leads
    reach = v0 * lesser(greater((way - v * force.step) / (v0 - v), nothing), force.step)
    reach = reach if v0 * v < nothing else way
    slider = stroke(force.law, slider, x0, reach)
    return stroke(force.law, slider, x0 + reach, way - reach)


def _wake(force, slot, who, stream, k0, k1, forcing):
    for i in range(STATES * LANES):
        forcing.state[force.place * LANES + i] = 0.0


def _supply(force, slot, group, who, stream, k0, k1, forcing):
    begin = force.place * LANES
    for i in range(3 * LANES):
        forcing.state[begin + i] = forcing.state[begin + 3 * LANES + i]


register_damper(Hysteresis, _wake, _supply)


@answers(damp, Hysteresis)
def _damp_hysteresis(force, slot, n, x, v, forcing, lane, weight, after):
    state, step, begun = forcing.state, n & (GROUP - 1), force.place * LANES + lane
    own = begun + 3 * LANES
    if not after:
        old = begun if step == 0 else own
        state[own] = _followed(force, typed(state[old], x), state[old + LANES], state[old + 2 * LANES], x, v)
    z = x - typed(state[own], x)
    change = -force.impulse * z
    if after:
        state[own + LANES], state[own + 2 * LANES] = x, v + change
    else:
        state[own + (3 + step) * LANES] = z
    forcing.works[slot * LANES + lane] += weight * change * (v + typed(0.5, v) * change)
    return change
