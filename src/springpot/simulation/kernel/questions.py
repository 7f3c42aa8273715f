"""The questions that the kernel asks its parts, and the schemes that answer how a step is taken.

A part is a ``NamedTuple`` of numbers.  Its *type* chooses the code at compile time; its values stay arguments, so one
kernel serves every problem of one structure.  A new part needs no change of the kernel: its module registers the part's
functions with :func:`answers`.  Forces are in `springpot.simulation.kernel.forces`, walls in
`springpot.simulation.lowering.walls`.

Of a force (``slot``: its number among the named forces of the sum; ``who``: the numbers of the paths of all lanes;
``forcing``: the arrays they share, see `Forcing`):

``slots(force)``
    How many named forces it is: those whose work is summed.  0 for white noise.
``wake(force, slot, who, stream, k0, k1, forcing)``
    Its own state at time 0, for all lanes.
``supply(force, slot, group, who, stream, k0, k1, forcing)``
    Once for every group of four steps, for all lanes: the impulses that do not depend on the motion.
``push(force, slot, n, x, v, g, forcing, at, lane, weight)``
    The impulses of step ``n``, of the noise with independent increments and of everything else; ``g`` is a normal.
``damp(force, slot, n, x, v, forcing, lane, weight, after)``
    The change of the velocity in half a step of a nonlinear damper alone; called before and ``after`` each kick.

Of a scheme and a wall:

``begin(scheme, wall, x, v, early, accumulators, lane, weight)``
    From the state at time 0 to the first kick.
``kick(scheme, x, v, memory_force, push)``
    The whole impulse of a step (memory, forces, and the spring if the scheme puts it here), and the force of springpots
    and dashpots during it.
``drift(scheme, x, v)``
    From one kick to the next as if there were no wall: changes of x and v until the observation, and until the end.
``extras(wall)``
    How many sums of its own the wall keeps, beside the impacts of all walls.
``clearance(scheme, wall, least, greatest)``
    Distance between the wall and drifts whose ends and observations lie between these two; not above 0 if one of them
    may have reached the wall.  Called for every lane.
``meet(scheme, wall, x, v)``
    The drift with the wall, in vector code, where lanes with impacts are many: the changes as of ``drift``, the speeds
    of the impacts (below and above the motion) in either half, 0 for none, and whether no impact is missed.
``gather(wall, struck, accumulators, clear, within, beyond)``
    In how many lanes ``meet`` found impacts in a group.  ``within`` the window those of lanes whose ``clear`` is 1, not
    0, are added to the accumulators; those of the last half step if the step ``beyond`` the group is in the window.
``limited(wall, x)``
    ``x``, or the place of the wall if ``x`` is beyond it by rounding.
``in_lanes(scheme, wall)``
    Whether ``meet`` finds impacts; otherwise it is not used.
``held_by(scheme, wall, x, v)``
    Whether a mass rests on a wall that lets it rest: 1 on one below the motion, -1 on one above it, otherwise 0.
``stay(scheme, wall, side, x, moving, impulse, others, pull, accumulators, lane, weight)``
    The kick of such a mass, from the velocity that it has after the kick if nothing holds it, the impulse of the kick,
    and that of nonlinear dampers at rest: what is given, the velocity after it, the force of springpots and dashpots,
    and the mean velocity at which forces work.
``bounce(scheme, wall, x, v, push, accumulators, lane, before, after)``
    The drift with the wall.  Called only for lanes that may have reached it.  ``push`` is the acceleration by the last
    kick.  Each impact is added to the accumulators if its half step lies in the window (weight 1, otherwise 0).

All lanes are first advanced without walls in the precision of ``Sweep``; what it may ask, from ``push`` to
``clearance``, is written so that no literal makes doubles of single numbers
(`springpot.simulation.kernel.lanes.typed`). Where few lanes may have struck, these are advanced again in double
precision.

Two schemes:

``Splitting`` (the default).  Between kicks the bare oscillator moves exactly, impacts included; each kick applies the
impulse of memory and forces over a whole step.  The reaction of springpots and dashpots to this impulse is averaged
over the step, which makes the kick implicit but scalar.  No impact between two kicks is missed, and at order 1 with an
elastic wall the stationary distribution is exact for every step.

``Euler``, the paper's scheme.  v += h (force at x_n) + noise, x += h v, and the velocity is reversed when x is within
``contact`` of the wall or beyond it and moves towards it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from numba.extending import overload

from springpot.machine.arrays import Floats
from springpot.memory.zeta import zeta_beyond_one
from springpot.simulation.kernel.lanes import INLINE, typed


class Splitting(NamedTuple):
    """Numbers of the default scheme; :func:`splitting` makes them."""

    step: float
    frequency: float
    half_loss: float  # cosine of the half-step rotation, less 1
    half_sine: float  # sine over the frequency
    half_back: float  # sine times the frequency
    loss: float  # the same of the whole step
    sine: float
    back: float
    share: float  # 1 / (1 + answer h): part of an impulse that is left after the springpot's reaction
    drag: float  # share times the step
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


class Sweep(NamedTuple):
    """The parts as the sweep over all lanes takes them, in its precision."""

    scheme: Any
    wall: Any
    load: Any
    zero: Any  # of that precision


class Start(NamedTuple):
    """State of the paths at time 0."""

    states: Floats  # (1 or paths, 3): x, v and the energy of mass and linear spring
    early: float  # displacement at the first kick due to the Riemann-Liouville force before it


class Forcing(NamedTuple):
    """Lane arrays that the forces share, in the precision of the sweep; those of ``slot`` begin at ``slot * LANES``."""

    impulses: Any  # of the present step, by force
    works: Any  # in the present group and window, by force
    given: Any  # (slot, step of the group, lane): impulses that do not depend on the motion
    state: Any  # of the forces that have one
    normals: Any  # four steps of normals, for the moment
    white: Any  # those of white noise


def answer_of_springpot(order: float, coefficient: float, step: float) -> float:
    """Mean over a step of a springpot's force due to a unit impulse that is spread evenly over the same step.

    Examples
    --------
    >>> answer_of_springpot(1.0, 3.0, 0.1)  # of a dashpot: half of its coefficient
    1.5
    """
    return float(coefficient * step ** (1.0 - order) / math.gamma(4.0 - order))


def splitting(frequency: float, answer: float, step: float) -> Splitting:
    """The default scheme's numbers for one step size.

    Parameters
    ----------
    frequency, answer, step : float
        Omega, the sum of the answers of springpots and dashpots, and h, in the kernel's units.

    Returns
    -------
    Splitting

    Examples
    --------
    >>> round(1.0 + splitting(1.0, 0.0, 0.1).loss, 4)  # without a springpot it turns by Omega h
    0.995
    """
    phase = 0.5 * frequency * step
    share = 1.0 / (1.0 + answer * step)
    return Splitting(
        step=step,
        frequency=frequency,
        half_loss=-2.0 * math.sin(0.5 * phase) ** 2,
        half_sine=math.sin(phase) / frequency,
        half_back=math.sin(phase) * frequency,
        loss=-2.0 * math.sin(phase) ** 2,
        sine=math.sin(2.0 * phase) / frequency,
        back=math.sin(2.0 * phase) * frequency,
        share=share,
        drag=share * step,
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
    return _summed_moments(order) - 1.0 / math.gamma(4.0 - order)


def _summed_moments(order: float) -> float:
    """First moments of the kernel over all earlier steps, summed: -zeta(alpha - 1) / Gamma(2 - alpha).

    By the functional equation this is (2 pi)^(alpha - 1) cos(pi alpha / 2) zeta(2 - alpha) / pi.

    Examples
    --------
    >>> _summed_moments(1.0), round(_summed_moments(0.5), 12)
    (0.5, 0.234574485391)
    """
    rest = 1.0 - order
    if rest == 0.0:
        return 0.5
    zeta = float(zeta_beyond_one(rest))
    return math.pow(2.0 * math.pi, -rest) * math.sin(0.5 * math.pi * rest) * zeta / math.pi


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


def slots(force: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def wake(force: Any, slot: Any, who: Any, stream: Any, k0: Any, k1: Any, forcing: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def supply(force: Any, slot: Any, group: Any, who: Any, stream: Any, k0: Any, k1: Any, forcing: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def push(force: Any, slot: Any, n: Any, x: Any, v: Any, g: Any, forcing: Any, at: Any, lane: Any, weight: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def damp(force: Any, slot: Any, n: Any, x: Any, v: Any, forcing: Any, lane: Any, weight: Any, after: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def begin(scheme: Any, wall: Any, x: Any, v: Any, early: Any, accumulators: Any, lane: Any, weight: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def kick(scheme: Any, x: Any, v: Any, memory_force: Any, push: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def drift(scheme: Any, x: Any, v: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def extras(wall: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def clearance(scheme: Any, wall: Any, least: Any, greatest: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def meet(scheme: Any, wall: Any, x: Any, v: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def gather(wall: Any, struck: Any, accumulators: Any, clear: Any, within: Any, beyond: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def limited(wall: Any, x: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def in_lanes(scheme: Any, wall: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def held_by(scheme: Any, wall: Any, x: Any, v: Any) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def stay(
    scheme: Any, wall: Any, side: Any, x: Any, moving: Any, impulse: Any, others: Any, pull: Any, accumulators: Any,
    lane: Any, weight: Any,
) -> Any:  # fmt: skip
    """Compiled code only; see the module's text."""
    raise NotImplementedError


def bounce(
    scheme: Any, wall: Any, x: Any, v: Any, push: Any, accumulators: Any, lane: Any, before: Any, after: Any
) -> Any:
    """Compiled code only; see the module's text."""
    raise NotImplementedError


_ANSWERS: dict[Callable[..., Any], dict[tuple[object, ...], Callable[..., Any]]] = {}


def answers(question: Callable[..., Any], *kinds: type) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register the function that the kernel calls as ``question`` for parts of these types (its first arguments).

    Parameters
    ----------
    question : callable
        One of the functions in the module's text.
    *kinds : type
        Types of the parts, ``NamedTuple`` classes; all of them ``object`` for parts that do not answer themselves.

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
    A constant force that is not named:

    >>> class Pushed(NamedTuple):
    ...     impulse: float
    >>> @answers(push, Pushed)
    ... def push_on(force, slot, n, x, v, g, forcing, at, lane, weight):
    ...     return 0.0, force.impulse
    """
    alike = _names_and_fields(kinds)
    known = _ANSWERS.get(question)
    if known is None:
        known = _ANSWERS[question] = {}
        _let_numba_ask(question, known, len(kinds))
    if alike in known:
        names = ", ".join(kind.__name__ for kind in kinds)
        raise ValueError(f"{question.__name__} of {names} is defined already: give the part another name.")

    def register(function: Callable[..., Any]) -> Callable[..., Any]:
        known[alike] = function
        return function

    return register


def _names_and_fields(kinds: Sequence[Any]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What compiled code knows of types."""
    return tuple((kind.__name__, getattr(kind, "_fields", ())) for kind in kinds)


def _let_numba_ask(question: Callable[..., Any], known: Mapping[tuple[object, ...], Any], kinds: int) -> None:
    """Tell Numba which function answers a question: the one known for the types of the first arguments."""
    others = _names_and_fields([object] * kinds)
    names = ", ".join(question.__code__.co_varnames[: question.__code__.co_argcount])

    def choose(*arguments: Any) -> Callable[..., Any] | None:
        given = [getattr(argument, "instance_class", None) for argument in arguments[:kinds]]
        return None if None in given else known.get(_names_and_fields(given), known.get(others))

    # overload() needs a function with the same argument names
    overload(question, jit_options=INLINE)(eval(f"lambda {names}: choose({names})", {"choose": choose}))


@answers(kick, Splitting)
def _kick_splitting(scheme, x, v, memory_force, push):
    force = memory_force + scheme.damping * v
    impulse = scheme.share * push - scheme.drag * force
    return impulse, force + scheme.answer * impulse


@answers(drift, Splitting)
def _drift_splitting(scheme, x, v):
    xm = scheme.half_loss * x + scheme.half_sine * v
    vm = scheme.half_loss * v - scheme.half_back * x
    xn = scheme.loss * x + scheme.sine * v
    vn = scheme.loss * v - scheme.back * x
    return xm, vm, xn, vn


@answers(kick, Euler)
def _kick_euler(scheme, x, v, memory_force, push):
    return push - scheme.step * (scheme.stiffness * x + memory_force), memory_force


@answers(drift, Euler)
def _drift_euler(scheme, x, v):
    moved, no_change = scheme.step * v, typed(0.0, v)
    return moved, no_change, moved, no_change
