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

__all__ = ["STATES", "AnyPower", "FirstPower", "Hysteresis", "Plastic"]

STATES = 6 + GROUP
"""Of a part: slider, x and velocity after the last kick, of even groups and of odd ones; z in the four steps.

A group begins from what the other one before it left, so that a lane that is advanced again begins from the same.
"""


class Plastic(NamedTuple):
    """Elastic, then perfectly plastic."""

    limit: float  # of z


class FirstPower(NamedTuple):
    """The law of Bouc and Wen with the exponent 1."""

    limit: float  # of z in a long stroke
    beta: float


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


def slip(law: Any, y: Any, length: Any) -> Any:
    """Compiled code only: how far the slider goes in a stroke of this length from z = y, both along the stroke."""
    raise NotImplementedError


def raised(law: Any, ratio: Any) -> Any:
    """Compiled code only: the share of the yield force to the power of n - 1."""
    raise NotImplementedError


@answers(raised, FirstPower)
def _not_raised(law, ratio):
    return typed(1.0, ratio)


@answers(raised, AnyPower)
def _raised(law, ratio):
    return ratio ** (law.exponent - typed(1.0, ratio))


@answers(slip, Plastic)
def _slip_plastic(law, y, length):
    return greater(y + length - law.limit, typed(0.0, y))


@answers(slip, FirstPower)
def _slip_first_power(law, y, length):
    return _slip_smooth(law, typed(1.0, y), y, length)


@answers(slip, AnyPower)
def _slip_any_power(law, y, length):
    return _slip_smooth(law, law.exponent, y, length)


@njit(**INLINE)
def _slip_smooth(law, exponent, y, length):
    """dz/dx = 1 - r^n where z has the sign of the stroke, and 1 + (2 beta - 1) r^n before it turns round.

    An exponential step of the second order in the length, and but for the exponential exact with n = 1.
    """
    one, nothing = typed(1.0, y), typed(0.0, y)
    turn = law.beta + law.beta - one
    ratio = abs(y) / law.limit
    bent = raised(law, ratio)  # r^(n - 1)
    rate = exponent * bent / law.limit
    power = bent * ratio
    if y < nothing:
        eased = _eased(turn * rate * length)
        whole = length * (eased - (one - eased) * turn * power)
        if y + length - whole > nothing:  # it passes z = 0
            mean = typed(2.0, y) + turn * power
            left = greater(length + (y + y) / mean, nothing)
            start = exponent * raised(law, nothing) / law.limit
            after = greater(left * _eased(start * left), left - law.limit)
            whole = y * turn * power / mean + after
        return whole
    eased = _eased(rate * length)
    return greater(length * (eased + (one - eased) * power), y + length - law.limit)


@njit(**INLINE)
def _eased(s):
    """1 - (1 - exp(-s)) / s, with 1 / (1 + s + s^2 / 2 + s^3 / 6) for the exponential: it never overshoots."""
    one, half = typed(1.0, s), typed(0.5, s)
    second, third = s * half, s * s * typed(1.0 / 6.0, s)
    return (second + third + third + s * third) / (one + s + s * second + s * third)


@njit(**INLINE)
def _stroke(law, slider, begin, way):
    """The slider after a straight way of x from ``begin``."""
    sign = typed(1.0, way) if way > typed(0.0, way) else typed(-1.0, way)
    return slider + sign * slip(law, sign * (begin - slider), abs(way))


@njit(**INLINE)
def _followed(force, slider, x0, v0, x, v):
    """The slider at a kick, from what the last kick left."""
    way, nothing = x - x0, typed(0.0, x)
    turned = v0 * v < nothing
    # as far as the first of two straight lines leads
    reach = v0 * lesser(greater((way - v * force.step) / (v0 - v), nothing), force.step) if turned else way
    slider = _stroke(force.law, slider, x0, reach)
    return _stroke(force.law, slider, x0 + reach, way - reach) if turned else slider


def _wake(force, slot, who, stream, k0, k1, forcing):
    for i in range(STATES * LANES):
        forcing.state[force.place * LANES + i] = 0.0


register_damper(Hysteresis, _wake)


@answers(damp, Hysteresis)
def _damp_hysteresis(force, slot, n, x, v, forcing, lane, weight, after):
    state, odd, step = forcing.state, n // GROUP % 2, n % GROUP
    own, before = (force.place + 3 - 3 * odd) * LANES + lane, (force.place + 3 * odd) * LANES + lane
    if not after:
        old = before if step == 0 else own
        state[own] = _followed(force, typed(state[old], x), state[old + LANES], state[old + 2 * LANES], x, v)
    z = x - typed(state[own], x)
    change = -force.impulse * z
    if after:
        state[own + LANES], state[own + 2 * LANES] = x, v + change
    else:
        state[(force.place + 6 + step) * LANES + lane] = z
    forcing.works[slot * LANES + lane] += weight * change * (v + typed(0.5, v) * change)
    return change
