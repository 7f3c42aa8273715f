"""The parts a kernel is composed of: schemes, walls and loads, and their answers to the kernel's questions.

A part is a ``NamedTuple`` of numbers.  Its *type* chooses the code at compile time, its values stay arguments, so one
kernel serves every oscillator and a new part does not touch the kernel: a module of its own registers its answers with
:func:`answers` and hands the part to `springpot.simulation.kernel.block`.  The questions:

``push(load, n, x, v, e, g)``
    The impulse of step ``n`` that is neither the linear spring's nor the springpot's (noise, a nonlinear spring, a
    harmonic or recorded force), and the next value of ``e``, one number of the load's own (a filter's state, say).
``begin(scheme, wall, start, accumulators, lane, weight)``
    From the state at time 0 to the first kick.
``kick(scheme, x, v, past, push)``
    The velocity after the whole impulse of a step (that of the spring if the scheme kicks it, memory, load) and the
    springpot's force in it.
``drift(scheme, x, v)``
    From one kick to the next as if there were no wall: state at the observation, state at the end.
``clearance(scheme, wall, x0, xm, x)``
    How far a drift that looks like this stays from the wall; negative if it may have met it.  Asked of every lane.
``bounce(scheme, wall, x, v, accumulators, lane, before, after)``
    The drift again, with the wall in it.  Asked of the few lanes that were struck; impacts are added to the
    accumulators with the weight (0 or 1) of the half of the step they happen in.

Two schemes:

``Splitting`` (the default).  The flow of the bare oscillator, exact, with the wall in it, from kick to kick; at each
kick the whole impulse of a step: memory and load.  The springpot's force answers its own impulse through the mean of
its kernel, which makes the kick implicit but scalar.  Since the kick moves only v and the drift is exact, no impact is
missed between two noisy points, and at order 1 with an elastic wall the stationary law is exact at every step size.

``Euler``, as the paper did it.  v += h (force at x_n) + noise, x += h v, and the velocity is reversed when x is within
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

# A chatter against a preload is over when a hop lasts less than this fraction of a half step.
SHORTEST_HOP = 1e-4
SHORTEST_ELASTIC_HOP = 1e-12  # elastic hops are counted, not walked, down to what rounding leaves of them


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
    share: float  # 1 / (1 + answer h): what the springpot's answer leaves of an impulse
    damping: float  # weight of the present velocity in the springpot's force
    answer: float  # the springpot's mean force per impulse of its own step


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
    early: float  # displacement to add at the first kick: Riemann-Liouville's force before it


class NoWall(NamedTuple):
    """No wall at all (the field is there because an empty tuple has no type)."""

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
    # mean over a step of the force that answers an impulse spread evenly over the same step
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
    """Weight, in units of h^(1 - alpha), of the impulse at the last kick beyond what increments say of it.

    An impulse stands for a force spread over the step around it, and the springpot's force is wanted as a mean over the
    step around a later kick: the kernel's integral t^(1 - alpha) / Gamma(2 - alpha) between them, averaged twice.  The
    sum of what that changes over all kicks before the present one is -1 / Gamma(4 - alpha) - zeta(alpha - 1) /
    Gamma(2 - alpha), most of it due to the last; for smooth motion the sum is all that counts up to order h^2.
    """
    # first moment of the kernel over every step of the past, summed
    moment = -(1.0 + float(special.zetac(order - 1.0))) / math.gamma(2.0 - order)
    return moment - 1.0 / math.gamma(4.0 - order)


def newest_weights_splitting(order: float) -> tuple[float, float]:
    """What the newest two displacement increments weigh beyond their L1 weights, in units of h^-alpha.

    The present velocity less the mean velocity of the last step, which the force's damping weighs by 2 / Gamma(4 -
    alpha), is half a step of the spring's acceleration, which every step of the past has too.  The last impulse is the
    change of the mean velocity between the last two steps less twice this difference.
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


def kick(scheme: Any, x: Any, v: Any, past: Any, push: Any) -> Any:
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
    """Register a function as the answer to ``question`` for parts of these types (its first arguments).

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
        If parts of these names and fields have an answer already: compiled code tells types apart by name and fields.

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
        raise ValueError(f"{question.__name__} of {names} is answered already: give the part another name.")
    _ANSWERED.add(alike)

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        names = ", ".join(function.__code__.co_varnames[: function.__code__.co_argcount])

        def matches(*arguments: Any) -> Callable[..., Any] | None:
            found = tuple(getattr(a, "instance_class", None) for a in arguments[: len(kinds)])
            return function if found == kinds else None

        # overload() wants a function with the question's own argument names
        choose = eval(f"lambda {names}: matches({names})", {"matches": matches})
        overload(question, jit_options=INLINE)(choose)
        return function

    return register


@answers(push, White)
def _push_white(load, n, x, v, e, g):
    return load.strength * g, e


@answers(kick, Splitting)
def _kick_splitting(scheme, x, v, past, push):
    force = past + scheme.damping * v
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
    """Place above which both ends of half a step must lie for the wall not to be met in it.

    With a gap the spring pulls away from the wall, and a path may dip under it between two points that lie above: by at
    most (acceleration at the wall) (half step)^2 / 8 below the lower of them.
    """
    dip = max(0.0, -wall.position) * (scheme.frequency * scheme.step) ** 2 * (1.01 / 32.0)
    return wall.position + dip


@njit(**INLINE)
def _half_step(scheme, wall, x, v, accumulators, lane, weight):
    """Half a step with the wall in it; its trigonometry is for the few that meet the wall."""
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

    Returns x and v; impacts are added to the accumulators.  A chatter that has shrunk to hops shorter than
    ``SHORTEST_HOP`` of the flight has collapsed: the mass rests on the wall until the flight ends.
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
        if position > 0.0 and x == position and u >= 0.0:  # a preload: the mass hops
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
        if not square > 0.0:  # a gap never closed (or a path that is no number any more)
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
def _kick_euler(scheme, x, v, past, push):
    return v + (push - scheme.step * (scheme.stiffness * x + past)), past


@answers(drift, Euler)
def _drift_euler(scheme, x, v):
    xn = x + scheme.step * v
    return xn, v, xn, v


@answers(clearance, Euler, Rigid)
def _clearance_euler(scheme, wall, x0, xm, x):
    # a path that moves away behind the wall is asked again too, and told that nothing happened
    return x - (wall.position + scheme.contact)


@answers(bounce, Euler, Rigid)
def _bounce_euler(scheme, wall, x, v, accumulators, lane, before, after):
    xm, _, xn, vn = drift(scheme, x, v)
    if clearance(scheme, wall, x, xm, xn) <= 0.0 and vn < 0.0:
        add_impacts(accumulators, lane, before, 1.0, -vn)
        vn = -wall.restitution * vn
    return xn, vn, xn, vn
