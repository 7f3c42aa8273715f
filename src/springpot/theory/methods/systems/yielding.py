"""Parts that yield in statistical linearization: each is replaced by a spring and a dashpot in series."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy import optimize, special

from springpot.machine.arrays import Floats
from springpot.problem.parts import BoucWen, Jenkins, Maxwell
from springpot.problem.parts.hysteresis import Yielding
from springpot.theory.methods.systems.linear import Companion, pulled
from springpot.theory.result import NoConvergenceError, NoStationaryStateError

_ROUNDS = 40  # of halfway steps, before Newton's method
_TOLERANCE = 1e-10
_HARDLY = 7.0  # standard deviations beyond which it is no matter how seldom the slider slips


def nearest_arm(part: BoucWen, speed: float, correlation: float) -> tuple[Maxwell, float]:
    """The Maxwell element nearest to a part in mean square, and the standard deviation of its force.

    With v and z as Gaussian, z' = c v - d z by the means of the derivatives of its law [1]_.  Since z is stationary,
    the correlation of the two gives the size of z, and is a better unknown: that has a largest value, where it is 1.

    Parameters
    ----------
    part : BoucWen
    speed : float
        Standard deviation of v.
    correlation : float
        Of v and z, in (0, 1).

    References
    ----------
    .. [1] Y.-K. Wen, "Equivalent linearization for hysteretic systems under random excitation", Journal of Applied
       Mechanics 47 (1980); his beta and gamma are exchanged.

    Examples
    --------
    >>> arm, force = nearest_arm(BoucWen(0.5, 0.5), 0.66244, 0.3514)  # of the first system of the documentation
    >>> round(arm.stiffness, 3), round(arm.stiffness / arm.coefficient, 3), round(force**2 / 0.25, 3)
    (0.37, 0.357, 0.233)
    """
    n, beta, rho = part.exponent, part.beta, correlation
    size = 2.0 ** (0.5 * n) / math.pi
    even, odd = size * math.gamma(0.5 * n + 1.0), size * math.sqrt(math.pi) * math.gamma(0.5 * (n + 1.0))
    arc = float(special.beta(0.5, 0.5 * (n + 1.0)) * special.betainc(0.5, 0.5 * (n + 1.0), rho * rho))
    slower = beta * even * arc + (1.0 - beta) * odd  # of what r^n takes from c
    faster = beta * even * (2.0 * (1.0 - rho * rho) ** (0.5 * (n + 1.0)) + n * rho * arc) + (1.0 - beta) * n * rho * odd
    power = rho / (faster + rho * slower)
    spread = power ** (1.0 / n)  # of z over its limit
    rate = faster * spread ** (n - 1.0) * speed / part.yield_displacement
    stiffness = part.stiffness * (1.0 - power * slower)
    return Maxwell(float(stiffness), float(stiffness / rate), between=part.between), spread * part.yield_force


def nearest_arm_of_slider(part: Jenkins, speed: float, reached: float) -> tuple[Maxwell, float]:
    """The Maxwell element nearest to a Jenkins part in mean square, and the standard deviation of its force.

    Not z is taken as Gaussian with v, since it rests at its limits, but a variable g of which z is what lies within
    the limits.  The slider slips where g is beyond them and v points outward.  Since z is stationary, the work of the
    slip is that of the force, which gives the correlation of v and g; the moments of v and z of z' then give
    z' = c v - d z.  So a part that hardly yields becomes a spring, and one that always does dry friction.

    Parameters
    ----------
    part : Jenkins
    speed : float
        Standard deviation of v.
    reached : float
        That of g over the limit of z.

    Examples
    --------
    >>> arm, force = nearest_arm_of_slider(Jenkins(0.5, 0.5), 0.7, 1.0)
    >>> round(arm.stiffness, 3), round(arm.coefficient, 3), round(force, 3)
    (0.382, 1.751, 0.359)
    """
    h = min(1.0 / reached, _HARDLY)
    within, beyond, density = math.erf(h * math.sqrt(0.5)), float(special.ndtr(-h)), _density(h)

    def slipped(rho: float) -> float:
        """E[abs(v)] over the slips, per the standard deviation of v."""
        across = h / math.sqrt(1.0 - rho * rho)
        return 2.0 * (_density(0.0) * float(special.ndtr(-across)) + rho * density * float(special.ndtr(rho * across)))

    rho = float(optimize.brentq(lambda rho: rho * within / h - slipped(rho), 0.0, 1.0 - 1e-14, xtol=1e-300, rtol=1e-14))
    rest = math.sqrt(1.0 - rho * rho)
    square = (within - 2.0 * h * density) / (h * h) + 2.0 * beyond  # of z over its limit
    both = rho * within / h  # E[v z], of unit v and limit
    lost = beyond + 2.0 * float(special.owens_t(h, rho / rest))  # E[v^2] over the slips
    lost += 2.0 * rho * density * rho * h * float(special.ndtr(rho * h / rest))
    lost += 2.0 * rho * rest * _density(0.0) * _density(h / rest)
    c = (1.0 - lost) / (1.0 - both * both / square)
    stiffness, rate = part.stiffness * c, c * both / square * speed / part.yield_displacement
    size = math.sqrt(square) * min(reached * _HARDLY, 1.0)
    return Maxwell(float(stiffness), float(stiffness / rate), between=part.between), size * part.yield_force


def _density(x: float) -> float:
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)


def _arm(part: Yielding, speed: float, state: float) -> tuple[Maxwell, float]:
    """By the unknown of the search, which may be any number."""
    if isinstance(part, Jenkins):
        return nearest_arm_of_slider(part, speed, math.exp(state))
    assert isinstance(part, BoucWen)
    return nearest_arm(part, speed, float(special.expit(state)))


def with_arms(companion: Companion, parts: Sequence[Yielding], settled: Callable[[Companion], Companion]) -> Companion:
    """A linear system with Maxwell elements that agree with its motion, last among its elements.

    Parameters
    ----------
    companion : Companion
        The linear system without them.
    parts : sequence of BoucWen or Jenkins
    settled : callable
        What makes of a linear system with them one whose springs and dampers agree with its motion too.

    Raises
    ------
    NoConvergenceError, NoStationaryStateError
        If there are none that are found, or no stationary state.
    """
    count = len(parts)

    def arms(state: Floats) -> tuple[list[Maxwell], Floats]:
        speeds = np.exp(state[:count])
        each = map(_arm, parts, speeds.tolist(), state[count:].tolist())
        found, forces = zip(*each, strict=True)
        return [*found], np.concatenate([speeds, forces])

    def missing(state: Floats) -> Floats:
        found, sizes = arms(state)
        return np.log(_sizes(settled(_with(companion, found)), found) / sizes)

    heaviest = float(np.diag(companion.mass).max())
    speeds = [part.yield_displacement * math.sqrt(part.stiffness / heaviest) for part in parts]
    state = np.concatenate([np.log(speeds), np.zeros(count)])
    for _ in range(_ROUNDS):
        step = missing(state)
        state = state + 0.5 * step
        if np.abs(step).max() < 0.01:
            break
    state = optimize.root(missing, state, method="hybr", options={"xtol": _TOLERANCE}).x
    if not np.abs(missing(state)).max() < 1e-7:
        raise NoConvergenceError("statistical linearization found no solution: its equations did not settle.")
    return _with(companion, arms(state)[0])


def _with(companion: Companion, arms: Sequence[Maxwell]) -> Companion:
    return replace(companion, elements=(*companion.elements, *arms))


def _sizes(companion: Companion, arms: Sequence[Maxwell]) -> Floats:
    """Standard deviations of the velocities of the arms' elongations, and of their forces."""
    found = pulled(companion, arms)
    if isinstance(found, str):
        raise NoStationaryStateError(found)
    return np.asarray(np.sqrt(found)).T.ravel()
