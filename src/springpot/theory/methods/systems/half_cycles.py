"""Half cycles: a mass between two stops on both sides of its equilibrium, under white noise."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import real_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, known_word, shown
from springpot.problem.parts import (
    Barrier,
    PolynomialDashpot,
    Spring,
    Springpot,
    WhiteNoise,
)
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import DAMPERS, SPRINGS, Coverage
from springpot.theory.densities import WithLaw
from springpot.theory.mckean import COLLAPSE_BELOW, slow_impact_power
from springpot.theory.methods.envelope.impacts import Impacts, with_short_returns
from springpot.theory.methods.envelope.walls import endless_walls, restitutions
from springpot.theory.methods.systems.half_cycle_chain import (
    FASTEST,
    MOST_CELLS,
    Chain,
    HardSpring,
    Problem,
    Stop,
    chain_of,
)
from springpot.theory.methods.systems.linear import linear
from springpot.theory.result import Moments, moments_of

_REACH = "The half cycles cover two rigid walls, one on each side of the equilibrium 0"
_COVERED = Coverage(
    f"{_REACH}, linear springs and cubic ones that harden, dashpots, springpots and white noise",
    SPRINGS | DAMPERS | Springpot | Barrier | WhiteNoise,
    linear=PolynomialDashpot,
    nonlinear="",
)
_REACHED = FASTEST - 0.5  # the fastest states that are resolved, in standard deviations of the speed without walls
_ROUNDS, _SETTLED = 200, 1e-9  # of the linear spring with the mean square of a hardening one
_NEAREST = 0.45  # of the walls, where springpots remember
_SHORT = 0.5  # of the flight to the turning point and of that to the other side: longer returns are due to springs


@dataclass(frozen=True)
class _Scales:
    """The motion without walls: the standard deviation of x, its frequency, the damping at it, and the mass."""

    length: float
    frequency: float
    damping: float

    @property
    def speed(self) -> float:
        return self.length * self.frequency


@dataclass(frozen=True)
class HalfCycles(WithLaw[tuple[Chain, _Scales]]):
    """The chain of half cycles of a system between two walls.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`.
    """

    def x_density(self, displacement: ArrayLike) -> Floats:
        """Density of x, per m; 0 beyond the walls.

        Parameters
        ----------
        displacement : array_like
            In m.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError
            If a displacement is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> stops = sp.Barrier(-1.5, 0.6), sp.Barrier(2.2, 0.6, free_side="below")
        >>> found = half_cycles(sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.4), *stops))
        >>> found.x_density([-2.0, 0.0, 3.0]).round(2).tolist()
        [0.0, 0.44, 0.0]
        """
        chain, scales = self._stationary_law()
        x = real_array(displacement, "displacement") / scales.length
        return np.asarray(_x_density(chain, x) / scales.length)

    def impact_speed_density(self, speed: ArrayLike, wall: str) -> Floats:
        """Density of the speed just before an impact on a wall, per m/s.

        Parameters
        ----------
        speed : array_like
            In m/s.
        wall : str
            Its name in the system.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError
            If a speed is not a number.
        ValueError
            If the system has no such wall, or its impacts have no density: it is never struck, or infinitely often.

        Examples
        --------
        >>> import springpot as sp
        >>> stops = {"near": sp.Barrier(-1.5, 0.6), "far": sp.Barrier(2.2, 0.6, free_side="below")}
        >>> found = half_cycles(sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.4), **stops))
        >>> found.impact_speed_density([0.0, 1.0], "far").round(2).tolist()
        [0.0, 0.71]
        """
        chain, scales = self._stationary_law()
        u = real_array(speed, "speed") / scales.speed
        walls = self.system.walls
        found = _impacts(chain, walls[known_word(wall, walls, "wall")], scales)
        if found is None or not found.speeds.size:
            raise ValueError(f"wall {shown(wall)} has no density of speeds: it is struck never, or infinitely often.")
        return np.asarray(np.interp(u, found.speeds, found.density, left=0.0, right=0.0) / scales.speed)


@np.errstate(all="ignore")  # what is not finite is no answer
def half_cycles(system: System) -> HalfCycles:
    """Solve a system between two walls by a chain of half cycles.

    Parameters
    ----------
    system : System
        Linear springs, and cubic ones that harden; dashpots and springpots; white noise; one rigid wall on either side
        of the equilibrium at 0, at any distances and with any restitutions, also laws of the speed.

    Returns
    -------
    HalfCycles

    Raises
    ------
    NotCoveredError
        If the system is another; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    The envelope spreads the loss of an impact over the whole cycle.  Between stops of unlike distances this is wrong:
    a mass that has just lost its speed at the near stop does not reach the far one.  Here the state is the speed at
    the equilibrium, four times in a cycle, and its law goes from one half of a cycle to the next: noise and damping act
    along a flight, and an impact at its end.  The work of springpots over a flight follows from the mean path before
    it, with its impacts [1]_; what they take beyond a damper decides how often a far stop is struck.  After a slow
    impact on a lossy wall noise alone may bring the mass back: such short returns are counted by McKean's law.

    With elastic walls and dashpots the exact law is known.  With walls at 1 and 1.7 standard deviations the rates are
    within 0.3, 2 and 4 % of it at c = 0.05, 0.2 and 0.5 (in units of the frequency); with both at 0.5 within 1.3, 5 and
    11 %.  Very light damping, and walls that are very near, change the energy of a flight by less than the chain
    resolves, and are refused.

    References
    ----------
    .. [1] The chain is new here.  Its step of a flight is stochastic averaging over half a cycle: R. L. Stratonovich,
       "Topics in the theory of random noise", vol. 2, Gordon and Breach (1967).

    Examples
    --------
    >>> import springpot as sp
    >>> stops = sp.Barrier(-1.5, 0.6), sp.Barrier(2.2, 0.6, free_side="below")
    >>> result = half_cycles(sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.4), *stops))
    >>> round(result.barrier_1_impact_rate, 4), round(result.barrier_2_impact_rate, 4)  # Monte Carlo: 0.0494, 0.0088
    (0.0492, 0.0089)
    """
    system = checked_system(system)
    unit, (lower, upper) = system.per_unit_mass, check_covered(system)
    law = None
    stationary: Moments | str
    warnings: tuple[str, ...] = ()
    if not any(noise.excites for noise in unit.excitations.values()):
        stationary = "There is no random stationary state: nothing excites the motion."
    else:
        linear_part, scales = _motion_without_walls(unit)
        problem = _problem(unit, lower, upper, linear_part, scales)
        _check_walls(problem)
        law = chain_of(problem), scales
        stationary = _moments(system, *law)
        warnings = tuple(_warnings(unit, linear_part, scales))
    return HalfCycles(
        method="half_cycles",
        system=system,
        stationary=stationary,
        assumptions=(
            "A flight between two passages of the equilibrium changes the energy little, except in an impact.",
            "Springpots act as on the mean path that leads to the present speed, with its impacts.",
            "After a slow impact on a lossy wall short returns are due to noise alone.",
        ),
        warnings=warnings,
        _law=law,
    )


def check_covered(system: System) -> tuple[Barrier, Barrier]:
    """The lower and the upper wall, where everything else is covered too.

    Raises
    ------
    NotCoveredError
        Where it is not.
    """
    unit = system.per_unit_mass
    _COVERED.check(unit)
    walls = [*unit.walls.values()]
    below = [wall for wall in walls if wall.free_side == "above" and wall.position < 0.0]
    above = [wall for wall in walls if wall.free_side == "below" and wall.position > 0.0]
    if len(walls) != 2 or not (below and above):
        here = {0: "there is no wall", 1: "there is one wall"}.get(len(walls), "the walls are different")
        raise NotCoveredError(f"{_REACH}; here {here}.")
    coefficients = (*unit.potential.coefficients, *[0.0] * 10)
    if any(coefficients[n] != 0.0 for n in (0, 2, *range(4, 10))) or coefficients[3] < 0.0:
        raise NotCoveredError(
            f"{_REACH}, and linear springs and cubic ones that harden; here the springs are different."
        )
    if not any(part.dissipates and "damping" in part.powers for part in unit.parts):
        raise NotCoveredError(f"{_REACH} with a dashpot or springpot; here there is none.")
    if not coefficients[1] > 0.0:
        raise NotCoveredError(f"{_REACH} and a linear spring that draws the mass there; here there is none.")
    return below[0], above[0]


def _motion_without_walls(unit: System) -> tuple[HardSpring, _Scales]:
    """The springs with the stiffness of the springpots in it, in units of the motion without walls, and these units.

    The cubic spring is replaced by the linear one that differs least in mean square.
    """
    coefficients = (*unit.potential.coefficients, *[0.0] * 4)
    stiffness, cubic = coefficients[1], coefficients[3]
    q = float(sum(noise.white_intensity for noise in unit.excitations.values()))
    others = [part for part in unit.parts if "damping" in part.powers and not part.force_coefficients()]
    square: float = 0.0
    for _ in range(_ROUNDS):
        spring = Spring(float(stiffness + 3.0 * cubic * square))
        found = linear(System(spring, *others, WhiteNoise(q))).moments
        before, square = square, found.x_mean_square
        if cubic == 0.0 or abs(square - before) < _SETTLED * square:
            break
        square = math.sqrt(square * before) if before > 0.0 else 0.1 * square
    speed = found.v_mean_square
    scales = _Scales(math.sqrt(square), math.sqrt(speed / square), 0.5 * q / speed)
    bend = cubic * square / scales.frequency**2
    return HardSpring(1.0 - 3.0 * bend, bend), scales


def _problem(unit: System, lower: Barrier, upper: Barrier, spring: HardSpring, scales: _Scales) -> Problem:
    w = scales.frequency
    return Problem(
        spring=spring,
        damping=scales.damping / w,
        memory=tuple(
            Springpot(springpot.order, float(springpot.coefficient * w ** (springpot.order - 2.0)))
            for springpot in unit.parts
            if springpot.remembers
        ),
        upper=_stop(upper, scales),
        lower=_stop(lower, scales),
    )


def _check_walls(problem: Problem) -> None:
    """Refuse walls that are so near, or damping that is so light, that the chain does not resolve them."""
    if problem.cells > MOST_CELLS:
        raise NotCoveredError(
            "The half cycles cover flights in which the energy changes a little; here it changes by less than they "
            "resolve, because the damping is very light or the walls are very near."
        )
    if problem.memory and min(problem.upper.distance, problem.lower.distance) < _NEAREST:
        raise NotCoveredError(
            f"The half cycles cover springpots where each wall is at least {_NEAREST:g} standard deviations of x "
            "without walls away from the equilibrium; here a wall is nearer."
        )


def _stop(wall: Barrier, scales: _Scales) -> Stop:
    return Stop(
        -wall.inwards * wall.position / scales.length, lambda speed: restitutions(wall, speed * scales.speed) * speed
    )


def _moments(system: System, chain: Chain, scales: _Scales) -> Moments:
    per_time = 1.0 / chain.period
    x = scales.length * per_time * chain.total(lambda stage: stage.side * stage.flights.first)
    x_square = scales.length**2 * per_time * chain.total(lambda stage: stage.flights.second)
    v_square = scales.speed**2 * per_time * chain.total(lambda stage: stage.flights.action)
    hits, far = [], {}
    for name, wall in system.walls.items():
        found = _impacts(chain, wall, scales)
        if found is None:
            hits.append((math.nan, math.nan, math.nan))
            continue
        speeds = found.speed_mean * scales.speed, found.speed_mean_square * scales.speed**2
        if math.isnan(found.rate):  # struck too rarely for the chain: in the rate of all walls it counts nothing
            far[f"{name}_impact_rate"] = math.nan
        hits.append((0.0 if math.isnan(found.rate) else found.rate * scales.frequency, *speeds))
    moments = moments_of(system, [(x, x_square, v_square)], hits=hits)
    return replace(moments, of_parts={**moments.of_parts, **far})


def _impacts(chain: Chain, wall: Barrier, scales: _Scales) -> Impacts | None:
    """The impacts on one wall in the chain's units; None where there are infinitely many."""
    slow = slow_restitution(wall)
    if slow <= COLLAPSE_BELOW:
        return None
    first = 0 if wall.free_side == "below" else 2
    out, back = chain.stages[first], chain.stages[first + 1]
    hits, spring = out.hits, chain.problem.spring
    if spring.speed_to(out.stop.distance) > _REACHED:
        return Impacts(math.nan, math.nan, math.nan, np.zeros(0), np.zeros(0))
    needed = spring.speed_to(out.stop.distance) ** 2
    speed = np.sqrt(chain.speeds[hits] ** 2 - needed)
    ends = np.sqrt(np.maximum(chain.edges[np.r_[hits, False] | np.r_[False, hits]] ** 2 - needed, 0.0))
    struck = chain.probabilities[first + 1][hits] / chain.period
    flux = struck / np.diff(ends)
    regular = tuple(float(struck @ speed**power) for power in (0, 1, 2))
    likely = flux > 1e-13 * flux.max()
    if not regular[0] > 0.0:
        return Impacts(0.0, math.nan, math.nan, np.zeros(0), np.zeros(0))
    if np.count_nonzero(likely) < 5:
        return Impacts(regular[0], regular[1] / regular[0], regular[2] / regular[0], np.zeros(0), np.zeros(0))
    onward = chain.stages[(first + 2) % 4]
    flight = back.flights.time[hits] + np.interp(back.start[hits], chain.speeds, onward.flights.time)
    pull = float(spring.linear * out.stop.distance + spring.cubic * out.stop.distance**3)

    def limit(v: Floats) -> Floats:
        """The longest short return: until the spring has turned the speed, or part of the way to the next impact."""
        intensity = 2.0 * chain.problem.damping
        return np.asarray(intensity / (1.0 / np.interp(v, speed, _SHORT * flight) + pull / v))

    return with_short_returns(speed[likely], flux[likely], limit, out.stop.rebound, slow_impact_power(slow), regular)


def _x_density(chain: Chain, x: Floats) -> Floats:
    """Time at x over that of a cycle: 1 / sqrt(V^2 - 2 U(x)), averaged over a cell, in which V^2 is uniform."""
    found = np.zeros_like(x)
    least = 2.0 * chain.problem.spring.energy(x)
    for stage, p in zip(chain.stages, chain.probabilities, strict=True):
        here = (np.sign(stage.side) * x >= 0.0) & (np.abs(x) <= stage.stop.distance)
        edges = chain.edges
        if stage.back and math.isfinite(stage.stop.distance):
            edges = stage.stop.after(edges, chain.problem.spring.speed_to(stage.stop.distance) ** 2)
        left = np.sqrt(np.maximum(edges[:, None] ** 2 - least[here], 0.0))
        lower, upper, width = left[:-1], left[1:], np.diff(edges**2)[:, None]
        inside = (lower > 0.0) & (upper > 0.0)  # the same by another way, for edges that lie together after an impact
        apart = np.where(inside | (width == 0.0), np.inf, width)
        found[here] += p @ np.where(inside, 2.0 / np.maximum(lower + upper, 1e-12), 2.0 * (upper - lower) / apart)
    twice = np.where(x == 0.0, 0.5, 1.0)  # 0 is on both sides
    return np.asarray(twice * found / chain.period)


def _warnings(unit: System, spring: HardSpring, scales: _Scales) -> Iterator[str]:
    yield from endless_walls(unit, lambda wall: slow_restitution(wall) <= COLLAPSE_BELOW)
    for name, part in unit.stops.items():
        if spring.speed_to(abs(part.position) / scales.length) > _REACHED:
            away = abs(part.position) / scales.length
            yield f"{name} is {away:.3g} standard deviations of x away: its rate is too small for the half cycles."
