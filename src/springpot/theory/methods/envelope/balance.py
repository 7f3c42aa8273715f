"""The self-consistent balance of the envelope: loss, action and probability of cycles of every size.

The cycles are those of any well, by quadrature (`cycles`), or those of the paper's problem in closed form (`arcs`); all
else is one for both.  The fixed point is described by a few numbers (`Field`); the physics is in `method`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import Barrier, Spring, Springpot, WhiteNoise
from springpot.problem.parts.walls import restitution_at
from springpot.problem.system import System
from springpot.theory.methods.envelope.arcs import arcs_up_to
from springpot.theory.methods.envelope.cycles import (
    COARSE,
    FINE,
    REACH,
    Cycles,
    CyclesInWell,
    Field,
    Ladder,
    Problem,
    ladder_of,
)
from springpot.theory.methods.envelope.walls import after_impact
from springpot.theory.numerics.energy_diffusion import EnergyDiffusion, make_energy_diffusion
from springpot.theory.numerics.equations import Anderson
from springpot.theory.numerics.panels import Labels, panel_rule
from springpot.theory.problem import Problem as PaperProblem

_FINE_NODES, _FEWEST, _FINE_CELLS = 30, 10, 450  # of a panel, at least, and in all: the fluxes are of second order
_FAR, _FAR_IN_WELL = 45.0, 42.0  # the density of arcs, and the share of others in the mean energy, end at e^-45, e^-42
_LOWEST, _HIGHEST = -50.0, 40.0  # decades of energy that are searched, in m^2/s^2
_STEPS, _FREE = 40, 19  # largest number of steps, and of steps without damping
_SETTLED = 1e-8, 3e-4  # change of the mean field at the end: of arcs, and of cycles in any well
_DEPTH, _CUTOFF = 3, 1e-8  # of the acceleration
_UNSETTLED = 0.02  # change of the numbers per step above which there is no result; a smaller one gives a warning
_FORGETFUL = 3.0  # decay over frequency above which the motion is overdamped: the line-width correction diverges
_STILL = 1e-8, 1e-6  # variance of the mean of a cycle over <x^2>, below which it is not followed: of both kinds
_SHORT = 2.0  # power by which broadening decreases in short flights: of 1, 2, 4 the best at r = 0.5 and 0.8, b = 1
NEVER = 1e-15  # rate of impacts that is none
_FASTEST, _FARTHEST = 1e150, 1e60  # largest velocity and displacement whose powers do not overflow


class Struck(NamedTuple):
    """One wall or contact: its impact speed in each cycle, NaN where it is not reached, the restitution, and the square
    of the speed before an impact over the square of that."""

    speed: Floats
    restitution: float | Floats
    before: Floats


class _Rates(NamedTuple):
    """What changes the energy of cycles: one entry per cycle.

    Power that is taken, without that of impacts, and in resistors; the rate at which the variance of the energy grows;
    the action of the cycle with its memory, times 2 pi; and each wall and contact.
    """

    loss: Floats
    damped: Floats
    electric: Floats
    spread: Floats
    action: Floats
    struck: tuple[Struck, ...]


@dataclass(frozen=True)
class Stretch:
    """Correction of the cycles for a lossy wall: displacements are stretched, outgoing velocities reduced.

    A point (x, v) of a cycle goes to x' = wall + factor ((x - wall + near)^power - near^power) and
    v' = v_factor (v - skew sqrt(v^2 + soft^2) + lift), where ``lift`` makes the mean velocity 0.

    Parameters
    ----------
    wall, near, factor, power, soft, skew, lift, v_factor : float
        As above; ``near`` and ``soft`` keep both smooth at the wall and at rest, and the skew is below 1.
    """

    wall: float
    near: float
    factor: float
    power: float
    soft: float
    skew: float
    lift: float
    v_factor: float

    def x(self, x: Floats) -> Floats:
        """Corrected displacements."""
        above = np.maximum(x - self.wall, 0.0) + self.near
        return np.asarray(self.wall + self.factor * (above**self.power - self.near**self.power))

    def v(self, v: Floats) -> Floats:
        """Corrected velocities."""
        return np.asarray(self.v_factor * (v - self.skew * np.hypot(v, self.soft) + self.lift))

    def v_slope(self, v: Floats) -> Floats:
        """Derivative of the corrected velocities."""
        return np.asarray(self.v_factor * (1.0 - self.skew * v / np.hypot(v, self.soft)))

    def origin(self, x: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Inverse of the correction, and the factor on areas."""
        z = np.clip(v / self.v_factor - self.lift, -_FASTEST, _FASTEST)
        rest = 1.0 - self.skew**2
        before = (z + self.skew * np.hypot(z, math.sqrt(rest) * self.soft)) / rest
        away = np.clip(x - self.wall, 0.0, _FARTHEST) / self.factor
        above = (away + self.near**self.power) ** (1.0 / self.power)
        place = np.where(x < self.wall, x, self.wall + above - self.near)
        return place, before, self.v_slope(before) * self.factor * self.power * above ** (self.power - 1.0)


@dataclass(frozen=True)
class Cells:
    """Cells of the diffusion in time; one entry per cell for every array.

    ``area`` is that of the plane of x and v between cycles, over the action: 1 without memory.
    """

    problem: Problem
    diffusion: EnergyDiffusion
    label: Floats
    area: Floats
    cycles: Cycles
    stretch: Stretch | None


@dataclass(frozen=True)
class Balance:
    """The stationary law on a grid of cycles; one entry per node for every array.

    Parameters
    ----------
    problem, labels, cycles
        The problem with its mean field, the nodes, and the cycles.
    range : tuple of float
        The labels of interest: the largest amplitude of arcs; of other cycles the least and largest energy and the
        typical one.
    rates : _Rates
    measure : ndarray
        d action / d label.
    weight, plane : ndarray
        The probability of the node's cell per action, and, where one wall is struck, per area of the plane of x and v.
    fall, density : ndarray
        -ln of the stationary density per action, and the density per label.
    mobility, strength : ndarray
        D / J of the diffusion of the action, D being half the rate at which its variance grows, and D f / J.
    steps, change : int, float
        Number of fixed-point steps, and the change in the last one.
    stretch : Stretch or None
        Correction of arcs for a lossy wall or a memory.  It is included in the means of ``cycles``; the other arrays
        are those of the cycles.
    """

    problem: Problem
    labels: Labels
    cycles: Cycles
    range: tuple[float, ...]
    rates: _Rates
    measure: Floats
    weight: Floats
    plane: Floats
    fall: Floats
    density: Floats
    mobility: Floats
    steps: int = 0
    change: float = 0.0
    stretch: Stretch | None = None

    def average(self, values: Floats) -> float:
        """Stationary mean of a quantity of the cycles."""
        return float(self.weight @ values)

    @property
    def is_struck(self) -> bool:
        """Whether any cycle of interest has impacts."""
        period = self.cycles.period
        often = sum(self.average(np.isfinite(stop.speed) / period) for stop in self.rates.struck)
        return often > NEVER / self.average(period)

    @property
    def moments(self) -> tuple[float, float, float]:
        """Mean and mean square of x - origin, per action, and mean square of v: of arcs per area, else per action."""
        cycles, of_v = self.cycles, self.plane if self.problem.closed else self.weight
        return self.average(cycles.mean), self.average(cycles.x_square), float(of_v @ cycles.v_square)

    @property
    def input_power(self) -> float:
        """What noise feeds: the power that is taken, as a mean per area of the plane; exact also where cycles cross."""
        return 0.5 if self.problem.closed else self.average(self.rates.loss) / self.average(self.area)

    @property
    def taken(self) -> float:
        """Share of the input power that impacts do not take."""
        return min(self.average(self.rates.damped) / self.input_power, 1.0)

    @property
    def strength(self) -> Floats:
        return self.mobility * self.density / self.measure

    @property
    def area(self) -> Floats:
        """Area of the plane between cycles, over the action: 1 without memory."""
        between = np.maximum(self.labels.derivative(self.cycles.period * self.cycles.v_square), 0.0)
        return between / self.measure

    def cells(self) -> Cells:
        """The same cycles on a finer grid, for the diffusion in time."""
        panels = self.labels.edges.size - 1
        label, measure = panel_rule(self.labels.edges, min(max(_FINE_CELLS // panels, _FEWEST), _FINE_NODES))
        columns = np.stack([self.rates.action, self.measure, self.fall, self.mobility, self.area], axis=1)
        action, slope, fall, mobility, area = self.labels.interpolate(columns, label).T
        density = np.exp(-fall)
        diffusion, kept = _diffusion(action, density * np.maximum(slope, 0.0) * measure, density * mobility)
        return Cells(
            self.problem, diffusion, label[kept], area[kept], self.cycles.on(self.labels, label[kept]), self.stretch
        )


def _diffusion(action: Floats, mass: Floats, strength: Floats) -> tuple[EnergyDiffusion, NDArray[np.intp]]:
    """The diffusion of the action, and which cells it keeps."""
    likely = np.flatnonzero((mass > 1e-25 * mass.max()) & (np.diff(np.maximum.accumulate(action), prepend=0.0) > 0.0))
    diffusion = make_energy_diffusion(action[likely], mass[likely], strength[likely])
    return diffusion, likely[np.isin(action[likely], diffusion.action)]


def balance(problem: Problem | PaperProblem) -> Balance | str:
    """The stationary law, with the mean field that it makes itself where the two can be found together.

    Parameters
    ----------
    problem : Problem
        Of any system; or that of the paper, one that dissipates energy.

    Returns
    -------
    Balance or str
        Or why there is no stationary state.

    Raises
    ------
    NotCoveredError
        If cycles of different size cross, the preload is too deep, or the iteration does not converge.

    Examples
    --------
    >>> from springpot.theory.problem import Problem
    >>> settled = balance(Problem(order=1.0, coefficient=0.5, position=0.0, restitution=1.0))
    >>> round(settled.average(settled.cycles.v_square), 6)
    1.0
    """
    if isinstance(problem, PaperProblem):
        problem = of_paper(problem)
    if not problem.springpots or problem.unit.temperature > 0.0:  # matched noise balances the broadened lines too
        return _law(problem)
    if problem.closed:
        return _law_in_its_field(problem)
    first, second = (_law, _law_in_its_field) if problem.walls == 2 else (_law_in_its_field, _law)
    try:
        return first(problem)
    except NotCoveredError:
        return second(problem)


def of_paper(paper: PaperProblem) -> Problem:
    """The dimensionless problem of the paper, whose cycles are in closed form."""
    walls = (Barrier(paper.position, paper.restitution, free_side="above"),) if paper.position > -math.inf else ()
    unit = System(Spring(1.0), Springpot(paper.order, paper.coefficient), WhiteNoise(1.0), *walls).per_unit_mass
    return Problem(unit.potential, 0.0, unit.dashpots, (), (), unit, closed=True)


def _law_in_its_field(problem: Problem) -> Balance | str:
    """The law and its mean field, found together."""
    law, closed = _law(problem, COARSE), problem.closed
    mix, best = Anderson(_DEPTH, _CUTOFF), None
    for steps in range(1, _STEPS + 1):
        if isinstance(law, str):
            return law
        here, there = np.array(astuple(law.problem.field)), np.array(astuple(_field(law)))
        arc = law.average(law.cycles.arc)
        scales = np.array([arc, math.sqrt(law.average(law.cycles.x_square)), 1.0, math.sqrt(arc), 1.0])
        change = float(np.max(np.abs(there - here) / scales))
        # where cycles nearly cross, convergence is not monotonic
        if there[2] * math.sqrt(arc) < _FORGETFUL * law.average(law.cycles.frequency) and (
            best is None or change < best.change
        ):
            best = replace(law, steps=steps, change=change)
            if change < _SETTLED[not closed]:
                break
        part = 1.0 if steps <= _FREE else 1.0 / 3.0
        mixed = mix.part_of_step(here, there, part)
        if min(mixed[0], *mixed[2:]) < 0.0 or mixed[4] > 1.0:
            mixed = here + part * (there - here)
        law = _law(replace(problem, field=Field(*mixed.tolist())), COARSE, law)
    if best is None or best.change > _UNSETTLED:
        raise NotCoveredError(f"{REACH}; here the mean field of the cycles does not settle: the memory is too strong.")
    return best if closed else _law(replace(problem, field=_field(best)), like=best)


def _field(law: Balance) -> Field:
    """The averages of a law."""
    problem, cycles = law.problem, law.cycles
    mean, decay = law.average(cycles.mean), law.input_power / (2.0 * law.average(cycles.v_square))
    width = decay / law.average(np.sqrt(np.maximum(cycles.arc, 0.0)))
    lossy = any(not wall.is_elastic for wall in problem.unit.walls.values())
    taken = law.taken if lossy else 1.0
    diffusion, kept = _diffusion(law.rates.action, law.weight, law.strength)
    rate, squares = diffusion.spectrum(cycles.mean[kept])
    variance = float(squares.sum())
    # between two walls the mean of a growing cycle turns back at the second one: worse with such a spring than without
    if problem.walls == 2 or variance <= _STILL[not problem.closed] * law.average(cycles.x_square):
        return Field(0.0, mean, width, 0.0, taken)
    whole = law.average(_broadened(replace(problem, field=replace(problem.field, extra=decay)), cycles))
    springpots = [(springpot.order, springpot.coefficient) for springpot in problem.springpots]
    stiffness, share = slow_line(springpots, rate, squares, law.average(cycles.frequency), whole)
    return Field(stiffness, mean, width, share * decay, taken)


def _broadened(problem: Problem, cycles: Cycles) -> Floats:
    """Power that springpots take because the harmonics are lines of finite width, beyond that of an arc.

    The width comes from the decay of the amplitude's correlation.  The part due to impacts is not power of the
    springpot, so the correction is reduced in short flights from a lossy wall.
    """
    found, w1, field = np.zeros_like(cycles.period), cycles.frequency, problem.field
    if field.extra == 0.0:
        return found
    arc = np.maximum(cycles.arc, 1e-300)
    for springpot in problem.springpots:
        whole = (
            0.25
            * springpot.coefficient
            * math.cos(springpot.order * math.pi / 2.0)
            * (1.0 - springpot.order)
            * field.extra
        )
        lines = w1 * w1 / arc * cycles.sum_of(2.0 + springpot.order) - cycles.sum_of(springpot.order)
        found = found + whole * w1**springpot.order * lines
    counts = field.taken ** (_SHORT * np.maximum(1.0 - 2.0 * np.sqrt(arc) / w1, 0.0))
    return np.asarray(np.maximum(found * counts, 0.0))


def _rates(problem: Problem, cycles: Cycles) -> _Rates:
    unit, w1, beside = problem.unit, cycles.frequency, cycles.beside(problem)
    linear, action = problem.damping * cycles.v_square, cycles.period * cycles.v_square + beside.action
    for springpot in problem.springpots:
        a = springpot.order
        power = 0.5 * springpot.coefficient * math.sin(a * math.pi / 2.0) * w1 ** (1.0 + a) * cycles.sum_of(1.0 + a)
        linear = linear + power
        # Whitham's: its change is that of the stored energy over w1
        action = action - 0.5 * math.pi * a * problem.in_phase(springpot) * w1 ** (a - 1.0) * cycles.sum_of(a)
    wide = _broadened(problem, cycles)
    spread = problem.white * cycles.v_square + 2.0 * unit.temperature * (linear + wide) + beside.spread
    plain = linear + beside.loss
    loss, struck = plain + wide, []
    for name, stop in unit.stops.items():
        speed, before = cycles.speed_at(problem, stop.position - problem.origin), np.ones_like(loss)
        r: float | Floats = 1.0
        if wall := unit.walls.get(name):
            r, before = after_impact(problem, wall, speed, plain, cycles)
            loss = loss + 0.5 * before * np.nan_to_num(speed) ** 2 * (1.0 - r**2) / cycles.period
        struck.append(Struck(speed, r, before))
    return _Rates(loss, plain + wide, beside.electric, spread, action, tuple(struck))


def _range(problem: Problem, ladder: Ladder) -> tuple[float, float, float] | str:
    """The least and largest label of interest and their typical size, or why there is no stationary state."""
    low, high = _LOWEST, _HIGHEST
    for count in (361, 241, 241):
        decades = np.linspace(low, high, count)
        label = 10.0**decades
        with np.errstate(all="ignore"):
            cycles = ladder.cycles(problem, label, COARSE)
            rates = _rates(problem, cycles)
            slope = 2.0 * rates.loss / (rates.spread * cycles.period)
            known = np.isfinite(slope) & np.isfinite(rates.action) & (rates.action > 0.0)
        if not np.any(known):
            raise NotCoveredError(f"{REACH}; here the energies are beyond double precision.")
        label, decades, slope, action = label[known], decades[known], slope[known], rates.action[known]
        fall = np.r_[0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(action))]
        near = np.log(action) - fall
        far = near + np.log(label)
        first = int(np.argmax(near > near.max() - _FAR_IN_WELL))
        last = label.size - 1 - int(np.argmax((far > far.max() - _FAR_IN_WELL)[::-1]))
        if last == label.size - 1 and (high == _HIGHEST or far[-1] > far.max() - 0.5 * _FAR_IN_WELL):
            if problem.multiplied > 0.0:
                return "There is no stationary mean square: the noise that multiplies x feeds more than is dissipated."
            return "There is no stationary state: nothing dissipates energy, so it grows without end."
        typical = float(np.exp(np.average(np.log(label), weights=np.exp(near - near.max()))))
        low, high = float(decades[max(first - 1, 0)]), float(decades[min(last + 1, decades.size - 1)])
    return 10.0**low, 10.0**high, typical


def _law(problem: Problem, size: tuple[int, int] = FINE, like: Balance | None = None) -> Balance | str:
    """The stationary law in a given mean field, found from that in a similar one."""
    if problem.closed:
        return _law_of_arcs(problem, like.range[0] if like else _first_reach(problem))
    ladder = ladder_of(problem)
    found = like.range if like else _range(problem, ladder)
    if isinstance(found, str):
        return found
    before = like.cycles if like and isinstance(like.cycles, CyclesInWell) else None
    labels, cycles = ladder.grid(problem, found, size, before)
    law = _law_on(problem, labels, cycles, found)
    if not np.all(np.isfinite(law.weight)):
        raise NotCoveredError(f"{REACH}; here cycles and their own stiffness do not settle: the memory is too strong.")
    signed = law.weight / law.measure * labels.derivative(law.rates.action)
    if np.any(signed < -1e-6 * np.abs(signed).sum()):
        raise NotCoveredError(f"{REACH}; here cycles of different size cross: the memory is too strong.")
    return law


def _law_of_arcs(problem: Problem, reach: float) -> Balance:
    """The law of the paper's problem, with arcs as far as its density reaches."""
    short, long = 0.0, math.inf  # reaches that were too short and too long
    while True:
        law = _law_on(problem, *arcs_up_to(problem, reach), (reach,))
        fall = float(law.fall[-1] - law.fall[0])
        # with a far wall, cycles with impacts may be too long and those without too short
        if 0.9 * _FAR < fall < 1.3 * _FAR or (fall > _FAR and long < 1.001 * short) or not math.isfinite(fall):
            return law
        short, long = (max(reach, short), long) if fall < _FAR else (short, reach)
        if short > 0.0 and long < math.inf:
            reach = long if long < 1.001 * short else math.sqrt(short * long)
        else:
            reach *= math.sqrt(min(max(1.05 * _FAR / max(fall, 1e-9), 0.05), 10.0))


def _first_reach(problem: Problem) -> float:
    """Estimate of the largest amplitude of interest, from light damping at b = 0."""
    damping, b = problem.damping, problem.potential.low
    for springpot in problem.springpots:
        damping += springpot.coefficient * math.sin(springpot.order * math.pi / 2.0)
    for wall in problem.unit.walls.values():
        r = restitution_at(wall, 0.0)
        damping += (2.0 / math.pi) * (1.0 - r * r) / (1.0 + r * r)
    reach = math.sqrt(_FAR / damping)
    if b > 0.0:  # the energy above the preload is b h rather than h^2 / 2
        return min(reach, 1.5 * _FAR / (damping * b))
    return reach


def _law_on(problem: Problem, labels: Labels, cycles: Cycles, found: tuple[float, ...]) -> Balance:
    """The stationary law on these cycles."""
    rates = _rates(problem, cycles)
    measure = np.maximum(labels.derivative(rates.action), 1e-12 * rates.action)
    fall = labels.integral(2.0 * rates.loss / (rates.spread * cycles.period) * measure)
    fall = fall - fall.min()
    density = np.exp(-fall) * measure
    weight = labels.weights.ravel() * density
    law = Balance(
        problem=problem,
        labels=labels,
        cycles=cycles,
        range=found,
        rates=rates,
        measure=measure,
        weight=weight / weight.sum(),
        plane=weight / weight.sum(),
        fall=fall,
        density=density / weight.sum(),
        mobility=0.5 * rates.spread * cycles.period**2 / rates.action,
    )
    # between two walls, of which a cycle may strike both, rates per action are better
    if problem.walls != 1 or not law.is_struck:
        return law
    plane = law.weight * law.area
    return replace(law, plane=plane / plane.sum())


def slow_line(
    springpots: Iterable[tuple[float, float]], rates: Floats, squares: Floats, frequency: float, broadened: float
) -> tuple[float, float]:
    """What springpots do to the slow changes of the cycles' mean.

    Its correlation is a sum of exponentials, on each of which a springpot acts with C rate^alpha, less what makes the
    correlation smooth at lag 0.

    Parameters
    ----------
    springpots : iterable of (order, coefficient)
    rates, squares : ndarray
        Of the exponentials, and their parts of the variance.
    frequency : float
        Mean frequency of the cycles.
    broadened : float
        Power that the springpots would take because all lines but this one are broad.

    Returns
    -------
    stiffness, share : float
        The stiffness, and the share of the broadened lines' power that is left.
    """
    variance, stiffness, back, least = float(squares.sum()), 0.0, 0.0, 1.0
    for order, coefficient in springpots:
        late = saturated((rates / frequency) ** (1.0 - order) * math.sin(order * math.pi / 2.0), 1.0 / (1.0 - order))
        stiffness += coefficient * float(squares @ (rates**order * late)) / variance
        back += coefficient * float(squares @ rates) * float(squares @ rates**order) / variance
        least = min(least, order)
    return stiffness, float(saturated(np.array(back / broadened), 1.0 / least)) if broadened > 0.0 else 0.0


def saturated(y: Floats, power: float) -> Floats:
    """(1 - y) / (1 - y^power): 1 - y for small y, and never negative.

    Examples
    --------
    >>> saturated(np.array([0.5, 2.0]), 2.0).round(4)
    array([0.6667, 0.3333])
    """
    log = np.log(np.clip(y, 1e-200, 1e200))
    high = np.minimum(power * log, 700.0)
    near = np.abs(log) < 1e-9
    return np.where(near, 1.0 / power, np.expm1(log) / np.where(near, 1.0, np.expm1(high)))
