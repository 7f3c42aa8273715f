"""The parts of a kernel: schemes, walls and loads, and the functions that the kernel calls for them.

A part is a ``NamedTuple`` of numbers.  Its *type* chooses the code at compile time; its values stay arguments, so one
kernel serves every oscillator.  A new part needs no change of the kernel: its module registers the part's functions
with :func:`answers` and passes the part to `springpot.simulation.kernel.block`.  The functions:

``push(load, n, x, v, e, g)``
    The impulse of step ``n`` other than those of the linear spring and the springpot (noise, a nonlinear spring, a
    harmonic or recorded force), and the next value of ``e``, one state variable of the load (of a filter, say).
``begin(scheme, wall, start, accumulators, lane, weight)``
    From the state at time 0 to the first kick.
``kick(scheme, x, v, memory_force, push)``
    The velocity after the whole impulse of a step (memory, load, and the spring if the scheme puts it here), and the
    springpot's force during it.
``drift(scheme, x, v)``
    From one kick to the next as if there were no wall: state at the observation, state at the end.
``clearance(scheme, wall, x0, xm, x)``
    Distance between such a drift and the wall; negative if it may have reached the wall.  Called for every lane.
``bounce(scheme, wall, x, v, accumulators, lane, before, after)``
    The drift with the wall.  Called only for lanes that may have reached it.  Each impact is added to the accumulators
    if its half step lies in the window (weight 1, otherwise 0).

Two schemes:

``Splitting`` (the default).  Between kicks the bare oscillator moves exactly, impacts included; each kick applies the
impulse of memory and load over a whole step.  The springpot's reaction to this impulse is averaged over the step, which
makes the kick implicit but scalar.  No impact between two kicks is missed, and at order 1 with an elastic wall the
stationary distribution is exact for every step.

``Euler``, the paper's scheme.  v += h (force at x_n) + noise, x += h v, and the velocity is reversed when x is within
``contact`` of the wall or beyond it and moves towards it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload
from scipy import special

from springpot.simulation.lanes import FAST, INLINE
from springpot.simulation.observers import add_impacts

__all__ = [
    "Euler", "NoWall", "Rigid", "Splitting", "Start", "White",
    "answers", "begin", "bounce", "clearance", "drift", "euler", "fly", "kick", "push", "splitting",
]  # fmt: skip

# Chattering against a preload ends when a flight between two impacts is shorter than this fraction of a half step.
SHORTEST_HOP = 1e-4
SHORTEST_ELASTIC_HOP = 1e-12  # elastic flights are counted in one go, down to rounding


class Splitting(NamedTuple):
    """Numbers of the default scheme; :func:`splitting` makes them."""

    step: float
    frequency: float
    cosine: float  # of the half-step rotation
    sine_over_frequency: float
    sine_times_frequency: float
    whole_cosine: float  # of the whole step
    whole_sine_over_frequency: float
    whole_sine_times_frequency: float
    share: float  # 1 / (1 + answer h): part of an impulse that is left after the springpot's reaction
    damping: float  # weight of the present velocity in the springpot's force
    answer: float  # the springpot's mean force within a step per unit of impulse in that step


class Euler(NamedTuple):
    """Numbers of the paper's scheme; :func:`euler` makes them."""

    step: float
    stiffness: float
    contact: float

    @property
    def share(self) -> float:
        """Of an impulse: all of it."""
        return 1.0


class White(NamedTuple):
    """White noise and nothing else."""

    strength: float  # sqrt(q h)


class Start(NamedTuple):
    """State of every path at time 0."""

    x: float
    v: float
    energy: float
    early: float  # displacement at the first kick due to the Riemann-Liouville force before it


class NoWall(NamedTuple):
    """No wall (with an unused field, because Numba cannot type an empty tuple)."""

    unused: float


class Rigid(NamedTuple):
    """A rigid wall under x >= position."""

    position: float
    restitution: float


def splitting(frequency: float, order: float, coefficient: float, step: float) -> Splitting:
    """The default scheme's numbers for one step size.

    Parameters
    ----------
    frequency, order, coefficient, step : float
        Omega, alpha, C and h, in the kernel's units.

    Returns
    -------
    Splitting

    Examples
    --------
    >>> round(splitting(1.0, 0.5, 0.0, 0.1).whole_cosine, 4)  # without a springpot it turns by Omega h
    0.995
    """
    phase = 0.5 * frequency * step
    # mean over a step of the springpot's force due to a unit impulse spread evenly over the same step
    answer = coefficient * step ** (1.0 - order) / math.gamma(4.0 - order)
    return Splitting(
        step=step,
        frequency=frequency,
        cosine=math.cos(phase),
        sine_over_frequency=math.sin(phase) / frequency,
        sine_times_frequency=math.sin(phase) * frequency,
        whole_cosine=math.cos(2.0 * phase),
        whole_sine_over_frequency=math.sin(2.0 * phase) / frequency,
        whole_sine_times_frequency=math.sin(2.0 * phase) * frequency,
        share=1.0 / (1.0 + answer * step),
        damping=2.0 * answer,
        answer=answer,
    )


def weight_of_last_impulse(order: float) -> float:
    """Correction of the memory weight for the velocity jump at the last kick, in units of h^(1 - alpha).

    An impulse stands for a force spread over the step around it, and the springpot's force is its mean over the step
    around a later kick: the integral of the kernel between them, t^(1 - alpha) / Gamma(2 - alpha), averaged twice.
    Summed over all earlier kicks the correction is -1 / Gamma(4 - alpha) - zeta(alpha - 1) / Gamma(2 - alpha).  All of
    it is given to the last kick, which has most of it; for smooth motion only the sum matters up to order h^2.
    """
    # first moments of the kernel over all earlier steps, summed
    moment = -(1.0 + float(special.zetac(order - 1.0))) / math.gamma(2.0 - order)
    return moment - 1.0 / math.gamma(4.0 - order)


def newest_weights_splitting(order: float) -> tuple[float, float]:
    """Corrections to the L1 weights of the newest two displacement increments, in units of h^-alpha.

    The damping term, of weight 2 / Gamma(4 - alpha), uses the present velocity.  It differs from the mean velocity of
    the last step by half a step of the spring's acceleration, as in every earlier step.  The last impulse is the change
    of the mean velocity between the last two steps less twice this difference.
    """
    last = weight_of_last_impulse(order)
    return last - 2.0 / math.gamma(4.0 - order), -last


def euler(frequency: float, step: float, contact: float) -> Euler:
    """The paper's scheme's numbers for one step size.

    Parameters
    ----------
    frequency, step, contact : float
        Omega, h and the tolerance of contact, in the kernel's units.

    Returns
    -------
    Euler

    Examples
    --------
    >>> euler(2.0, 0.1, 1e-5).stiffness
    4.0
    """
    return Euler(step, frequency * frequency, contact)


def push(load: Any, n: Any, x: Any, v: Any, e: Any, g: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def begin(scheme: Any, wall: Any, start: Any, accumulators: Any, lane: Any, weight: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def kick(scheme: Any, x: Any, v: Any, memory_force: Any, push: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def drift(scheme: Any, x: Any, v: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def clearance(scheme: Any, wall: Any, x0: Any, xm: Any, x: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def bounce(scheme: Any, wall: Any, x: Any, v: Any, accumulators: Any, lane: Any, before: Any, after: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


_ANSWERED: set[tuple[object, ...]] = set()


def answers(question: Callable[..., Any], *kinds: type) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register the function that the kernel calls as ``question`` for parts of these types (its first arguments).

    Parameters
    ----------
    question : callable
        `push`, `begin`, `kick`, `drift`, `clearance` or `bounce`.
    *kinds : type
        Types of the parts, ``NamedTuple`` classes.

    Returns
    -------
    callable
        A decorator for the function, which has the arguments of the question and can be compiled by Numba.

    Raises
    ------
    ValueError
        If parts of these names and fields have one already: compiled code tells types apart by name and fields.

    Examples
    --------
    Noise, and a constant force:

    >>> class Pushed(NamedTuple):
    ...     strength: float
    ...     impulse: float
    >>> @answers(push, Pushed)
    ... def push_on(load, n, x, v, e, g):
    ...     return load.strength * g + load.impulse, e
    """
    alike = (question, *((kind.__name__, getattr(kind, "_fields", ())) for kind in kinds))
    if alike in _ANSWERED:
        names = ", ".join(kind.__name__ for kind in kinds)
        raise ValueError(f"{question.__name__} of {names} is defined already: give the part another name.")
    _ANSWERED.add(alike)

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        names = ", ".join(function.__code__.co_varnames[: function.__code__.co_argcount])

        def matches(*arguments: Any) -> Callable[..., Any] | None:
            given = tuple(getattr(a, "instance_class", None) for a in arguments[: len(kinds)])
            return function if given == kinds else None

        # overload() needs a function with the same argument names
        choose = eval(f"lambda {names}: matches({names})", {"matches": matches})
        overload(question, jit_options=INLINE)(choose)
        return function

    return register


@answers(push, White)
def _push_white(load, n, x, v, e, g):
    return load.strength * g, e


@answers(kick, Splitting)
def _kick_splitting(scheme, x, v, memory_force, push):
    force = memory_force + scheme.damping * v
    impulse = scheme.share * (push - scheme.step * force)
    return v + impulse, force + scheme.answer * impulse


@answers(drift, Splitting)
def _drift_splitting(scheme, x, v):
    xm = scheme.cosine * x + scheme.sine_over_frequency * v
    vm = scheme.cosine * v - scheme.sine_times_frequency * x
    xn = scheme.whole_cosine * x + scheme.whole_sine_over_frequency * v
    vn = scheme.whole_cosine * v - scheme.whole_sine_times_frequency * x
    return xm, vm, xn, vn


@answers(clearance, Euler, NoWall)
@answers(clearance, Splitting, NoWall)
def _clear_of_nothing(scheme, wall, x0, xm, x):
    return 1.0


@answers(bounce, Euler, NoWall)
@answers(bounce, Splitting, NoWall)
def _bounce_never(scheme, wall, x, v, accumulators, lane, before, after):
    return drift(scheme, x, v)


@answers(begin, Splitting, NoWall)
def _begin_free(scheme, wall, start, accumulators, lane, weight):
    x, v, _, _ = drift(scheme, start.x, start.v)
    return x + start.early, v


@answers(begin, Splitting, Rigid)
def _begin_splitting(scheme, wall, start, accumulators, lane, weight):
    phase = 0.5 * scheme.frequency * scheme.step
    x, v = fly(wall.position, wall.restitution, scheme.frequency, start.x, start.v, phase, accumulators, lane, weight)
    return max(x + start.early, wall.position), v


@answers(begin, Euler, NoWall)
@answers(begin, Euler, Rigid)
def _begin_euler(scheme, wall, start, accumulators, lane, weight):
    return start.x, start.v


@answers(clearance, Splitting, Rigid)
def _clearance_splitting(scheme, wall, x0, xm, x):
    return min(x0, min(xm, x)) - _reach(scheme, wall)


@njit(**INLINE)
def _reach(scheme, wall):
    """Position above which both ends of a half step must lie so that it has no impact.

    With a gap the spring pulls away from the wall, and a path may go below the lower of the two ends in between: by at
    most (acceleration at the wall) (half step)^2 / 8.
    """
    dip = max(0.0, -wall.position) * (scheme.frequency * scheme.step) ** 2 * (1.01 / 32.0)
    return wall.position + dip


@njit(**INLINE)
def _half_step(scheme, wall, x, v, accumulators, lane, weight):
    """Half a step with the wall; trigonometric functions are called only near the wall."""
    xh = scheme.cosine * x + scheme.sine_over_frequency * v
    vh = scheme.cosine * v - scheme.sine_times_frequency * x
    if min(x, xh) > _reach(scheme, wall):
        return xh, vh
    phase = 0.5 * scheme.frequency * scheme.step
    return fly(wall.position, wall.restitution, scheme.frequency, x, v, phase, accumulators, lane, weight)


@answers(bounce, Splitting, Rigid)
def _bounce_splitting(scheme, wall, x, v, accumulators, lane, before, after):
    xm, vm = _half_step(scheme, wall, x, v, accumulators, lane, before)
    xn, vn = _half_step(scheme, wall, xm, vm, accumulators, lane, after)
    return xm, vm, xn, vn


@njit(**FAST)
def fly(position, restitution, frequency, x, v, phase, accumulators, lane, weight):
    """Exact flight of the bare oscillator over ``phase`` = frequency * time above a wall, impacts included.

    Returns x and v; impacts are added to the accumulators.  When the flights of a chattering sequence are shorter than
    ``SHORTEST_HOP`` of ``phase``, the mass rests on the wall until the end.
    """
    u = v / frequency
    left = phase
    arriving = -u if x <= position and u < 0.0 else 0.0  # already there and moving in: an impact at once
    struck = False
    x = max(x, position)
    while True:
        if arriving > 0.0:
            add_impacts(accumulators, lane, weight, 1.0, frequency * arriving)
            struck = True
            x = position
            u = restitution * arriving
        if position > 0.0 and x == position and u >= 0.0:  # a preload brings the mass back to the wall
            hop = 2.0 * math.atan2(u, position)
            if restitution == 1.0 and hop > SHORTEST_ELASTIC_HOP * phase:
                whole = np.floor(left / hop)
                if whole > 0.0:
                    add_impacts(accumulators, lane, weight, whole, frequency * u)
                left -= whole * hop
            elif hop < SHORTEST_HOP * phase and hop < left:
                accumulators.collapses[lane] += 1.0 if struck else 0.0
                return position, 0.0
        square = u * u + (x - position) * (x + position)
        if not square > 0.0:  # the gap is never closed (or the state is NaN)
            break
        height = math.sqrt(square)  # u at the wall
        until = math.atan2(height, position) - math.atan2(-u, x)
        if not until < left:
            break
        left -= until
        arriving = height
    c = math.cos(left)
    s = math.sin(left)
    return max(c * x + s * u, position), frequency * (c * u - s * x)


@answers(kick, Euler)
def _kick_euler(scheme, x, v, memory_force, push):
    return v + (push - scheme.step * (scheme.stiffness * x + memory_force)), memory_force


@answers(drift, Euler)
def _drift_euler(scheme, x, v):
    xn = x + scheme.step * v
    return xn, v, xn, v


@answers(clearance, Euler, Rigid)
def _clearance_euler(scheme, wall, x0, xm, x):
    # `bounce` is called also for a path behind the wall that moves away; it changes nothing then
    return x - (wall.position + scheme.contact)


@answers(bounce, Euler, Rigid)
def _bounce_euler(scheme, wall, x, v, accumulators, lane, before, after):
    xm, _, xn, vn = drift(scheme, x, v)
    if clearance(scheme, wall, x, xm, xn) <= 0.0 and vn < 0.0:
        add_impacts(accumulators, lane, before, 1.0, -vn)
        vn = -wall.restitution * vn
    return xn, vn, xn, vn
