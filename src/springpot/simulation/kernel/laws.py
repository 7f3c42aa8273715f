"""Laws of nonlinear dampers and of parts that yield, as vectors: the change of a velocity in half a step.

Each is followed alone for half a step before the kick and half a step after it.  Numbers of a law are per unit of the
reduced mass along its row, where they are impulses.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES
from springpot.simulation.kernel.vectors import choose, filled, larger, load, power, root, size, smaller, store

# kinds; WHOLE is the law of Bouc and Wen with an exponent of 1, 2, ... 50; larger numbers are addresses of functions
COULOMB, POLYNOMIAL, VAN_DER_POL, JENKINS, WHOLE, ANY = range(6)
NUMBERS_OF_DAMPER = 6  # the last is the reduced mass
STATES_OF_YIELDING = 4
"""Of a part that yields: its slider, x and velocity after the last kick; and its z in the present step.

The state is the place of a slider, at which the force is 0: the force is the stiffness times z = x - slider, and only
yielding moves the slider.  So a part that does not yield is a spring, and rounding does not add up.  The way is that of
the drift: from one kick to the next the slider follows x in one stroke, or in two where x turns, be it by a spring or
by an impact.  The kick has the force of its own z, half of it before and half after all that answers to it.
"""


@njit(**INLINE)
def powers(quadratic, cubic, v, after):
    """The dampers c2 v abs(v) and c3 v^3, each followed exactly, in reverse order after the kick."""
    change = filled(v, 0.0)
    if after:
        change = _cubically(cubic, v)
    left = v + change
    rate = quadratic * size(left)
    change = change - left * rate / (1.0 + rate)
    if not after:
        change = change + _cubically(cubic, v + change)
    return change


@njit(**INLINE)
def _cubically(cubic, v):
    square = cubic * v * v
    whole = 1.0 + square
    return 0.0 - v * square / (whole + root(whole))  # a product with a root would be taken by its estimate somewhere


@njit(**INLINE)
def van_der_pol(rate, square, x, v):
    """The damper mu (x^2 - l^2) v at the x of the kick: of second order, and it never turns v round."""
    a = rate * (x * x - square)
    growth = size(a) + 0.5 * a * a
    return choose(a > 0.0, 0.0 - v * growth / (1.0 + growth), v * growth)


@njit(**INLINE)
def coulomb(impulse, v):
    """Dry friction."""
    return 0.0 - smaller(larger(v, 0.0 - impulse), impulse)


@njit(**INLINE)
def _raised(kind, exponent, ratio):
    """The share of the yield force to the power of n - 1.

    With a whole number the product of those of the powers 1, 2, 4, ... 32 that it has as binary digits.
    """
    if kind == ANY:
        return power(ratio, filled(ratio, exponent - 1.0))
    left, product, factor = int(exponent) - 1, filled(ratio, 1.0), ratio
    for _ in range(6):
        if left & 1 == 1:
            product = product * factor
        factor, left = factor * factor, left >> 1
    return product


@njit(**INLINE)
def _stroke(kind, limit, beta, exponent, slider, begin, way):
    """The slider after a straight way of x from ``begin``."""
    if kind == JENKINS:
        end = begin + way
        return smaller(larger(slider, end - limit), end + limit)
    sign = choose(way > 0.0, filled(way, 1.0), -1.0)
    return slider + sign * _slip(kind, limit, beta, exponent, sign * (begin - slider), size(way))


@njit(**INLINE)
def _slip(kind, limit, beta, exponent, y, length):
    """How far the slider goes in a stroke of this length from z = y, both along the stroke.

    dz/dx = 1 - r^n where z has the sign of the stroke, and 1 + (2 beta - 1) r^n before it turns round.

    An exponential step of the second order in the length, and but for the exponential exact with n = 1.  Both cases are
    worked out and one is chosen.
    """
    turn = beta + beta - 1.0
    ratio = size(y) / limit
    bent = _raised(kind, exponent, ratio)  # r^(n - 1)
    steep = choose(y >= 0.0, filled(y, 1.0), 0.0 - turn)
    share = steep * bent * ratio
    eased = _eased(size(steep) * (exponent / limit) * bent * length)
    whole = larger(length * (eased + (1.0 - eased) * share), y + length - limit)
    mean = 2.0 - share  # where it passes z = 0
    left = larger(length + (y + y) / mean, 0.0)
    start = _raised(kind, exponent, filled(y, 0.0)) * (exponent / limit)
    passed = larger(left * _eased(start * left), left - limit) - y * share / mean
    return choose((y < 0.0) & (y + length - whole > 0.0), passed, whole)


@njit(**INLINE)
def _eased(s):
    """1 - (1 - exp(-s)) / s, with 1 / (1 + s + s^2 / 2 + s^3 / 6) for the exponential: it never overshoots."""
    second, third = 0.5 * s, (1.0 / 6.0) * s * s
    return (second + third + third + s * third) / (1.0 + s + s * second + s * third)


@njit(**INLINE)
def _followed(kind, limit, beta, exponent, step, slider, x0, v0, x, v):
    """The slider at a kick, from what the last kick left."""
    way = x - x0
    # as far as the first of two straight lines leads
    reach = v0 * smaller(larger((way - v * step) / (v0 - v), 0.0), step)
    reach = choose(v0 * v < 0.0, reach, way)
    slider = _stroke(kind, limit, beta, exponent, slider, x0, reach)
    return _stroke(kind, limit, beta, exponent, slider, x0 + reach, way - reach)


@njit(**INLINE)
def yielding(kind, impulse, limit, beta, exponent, step, x, v, state, o, after):
    """A part that yields; its STATES_OF_YIELDING begin at ``state``."""
    if not after:
        slider, x0, v0 = load(state, o), load(state, LANES + o), load(state, 2 * LANES + o)
        slider = _followed(kind, limit, beta, exponent, step, slider, x0, v0, x, v)
        store(state, o, slider)
        store(state, 3 * LANES + o, x - slider)
    change = 0.0 - impulse * (x - load(state, o))
    if after:
        store(state, LANES + o, x)
        store(state, 2 * LANES + o, v + change)
    return change
