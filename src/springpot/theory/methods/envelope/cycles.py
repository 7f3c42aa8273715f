"""Cycles of systems: periodic motions in any single well, with the memory as springs, for the envelope."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.polynomial import legendre

from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import ParametricNoise, Springpot
from springpot.problem.parts.registration import Element
from springpot.problem.potential import Potential
from springpot.problem.system import System
from springpot.theory.numerics.panels import Labels, panel_rule

REACH = "The envelope of systems covers one well, between walls or without them, with stationary noise"
FINE = (96, 64)  # places of a half cycle, by Gauss's rule over theta with x = mid + half sin(theta); harmonics
COARSE = (40, 12)  # the same in the search for the energies of interest, and for the mean field
_BISECTIONS = 54
_SETTLED = 1e-10, 1e-4, 200  # of the cycles' own stiffness: change at the end, tolerated change, steps
_AHEAD = 30  # steps in which their limit is foreseen
_NEAR, _BROAD = 0.25, 1.0  # widths of panels in ln E, up to a hundred times the typical energy and beyond
_ROUGHLY = 1e-5, 1e-2, 80  # the same in the search


@dataclass(frozen=True)
class Field:
    """Averages over all cycles on which each cycle with a springpot depends.

    Parameters
    ----------
    slow_stiffness, about : float
        Of the springpots against slow changes of a cycle's mean, and the place about which it acts, seen from the
        bottom.
    width : float
        Decay rate of the amplitude over the frequency: the harmonics are lines of this width.
    extra : float
        The part of the decay rate that gives the broadened lines more power.
    taken : float
        Share of the dissipated power that impacts do not take.
    """

    slow_stiffness: float = 0.0
    about: float = 0.0
    width: float = 0.0
    extra: float = 0.0
    taken: float = 1.0


@dataclass(frozen=True)
class Problem:
    """A system per unit mass, its potential seen from the bottom of the well.

    Parameters
    ----------
    potential : Potential
        As a function of x - origin.
    origin : float
        The bottom: the place of least potential energy; 0 where the cycles are arcs.
    damping : float
        Of all linear dampers.
    elements : tuple
        What has a modulus and memory, without ``springpots``.
    circuits : tuple of Circuit
    unit : System
    closed : bool
        Whether cycles are arcs in closed form (`arcs`): of a linear spring of frequency 1 with at most one springpot, a
        wall on the left, and white noise of intensity 1.
    field : Field
    """

    potential: Potential
    origin: float
    damping: float
    elements: tuple[Element, ...]
    circuits: tuple[Element, ...]
    unit: System
    closed: bool = False
    field: Field = Field()

    @cached_property
    def white(self) -> float:
        """The intensity of white noise on the mass, impulses too."""
        return sum((noise.white_intensity for noise in self.unit.excitations.values()), 0.0)

    @cached_property
    def multiplied(self) -> float:
        """The intensity of the noise that multiplies x."""
        return sum((noise.intensity for noise in self.unit.of(ParametricNoise)), 0.0)

    @property
    def walls(self) -> int:
        """How many rigid walls there are: 0, 1 or 2."""
        return sum(map(math.isfinite, (self.potential.low, self.potential.high)))

    @property
    def remembers(self) -> bool:
        """Whether anything has memory."""
        return bool(self.springpots or self.elements or self.circuits)

    @cached_property
    def springpots(self) -> tuple[Springpot, ...]:
        """The springpots that are not in series with a spring."""
        return tuple(springpot for springpot in self.unit.springpots.values() if springpot.remembers)

    def in_phase(self, springpot: Springpot) -> float:
        """Stiffness of a springpot on a line at frequency 1, which has a width."""
        quarter = springpot.order * math.pi / 2.0
        broadened = math.cos(quarter) - (1.0 - springpot.order) * self.field.width * math.sin(quarter)
        return springpot.coefficient * max(broadened, 0.0)

    def electric(self, p: Any) -> Complexes:
        """Force over displacement of the circuits."""
        return np.asarray(sum((circuit.modulus(p) for circuit in self.circuits), np.zeros_like(p)))

    def modulus(self, p: Any) -> Complexes:
        """The same of everything with memory but the springpots."""
        return np.asarray(sum((element.modulus(p) for element in self.elements), self.electric(p)))

    @property
    def places(self) -> list[float]:
        """Where cycles change their kind as they grow: walls and the beginnings of contacts, seen from the bottom."""
        ends = self.potential.low, self.potential.high, *(contact.position for contact in self.potential.contacts)
        return [place for place in ends if math.isfinite(place)]


class Beside(NamedTuple):
    """What is beside springs, walls, dashpots, springpots and white noise: one entry per cycle.

    Mean power that is taken, the part of it in resistors, what the memory adds to the action, and the rate at which
    noise makes the variance of the energy grow.
    """

    loss: Floats
    electric: Floats
    action: Floats
    spread: Floats


@dataclass(frozen=True)
class Cycles:
    """Closed cycles of one system; one entry per cycle for every array.

    Parameters
    ----------
    period, mean, x_square, v_square : ndarray
        Mean and mean square of x are those of x - origin.
    arc : ndarray
        Square of the frequency between impacts: the slope of the force over x.
    """

    period: Floats
    mean: Floats
    x_square: Floats
    v_square: Floats
    arc: Floats

    @property
    def frequency(self) -> Floats:
        return np.asarray(2.0 * math.pi / self.period)

    def sum_of(self, power: float) -> Floats:
        """sum_n n^power X_n^2 with all harmonics."""
        raise NotImplementedError

    def speed_at(self, problem: Problem, place: float) -> Floats:
        """Speed at a place, NaN where it is not reached."""
        raise NotImplementedError

    def on(self, labels: Labels, label: Floats) -> Self:
        """The cycles with other labels, from those at the nodes."""
        columns, size = {each.name: getattr(self, each.name) for each in fields(self)}, self.period.size
        found = {
            name: labels.interpolate(values.reshape(size, -1), label).reshape(-1, *values.shape[1:])
            for name, values in columns.items()
        }
        return replace(self, **found)

    def path(self, problem: Problem, part: Floats) -> tuple[Floats, Floats]:
        """x - origin and speed on the way from the largest x, part 0, to the least, part 1; a row for each cycle."""
        raise NotImplementedError

    def beside(self, problem: Problem) -> Beside:
        """What other parts do."""
        nothing = np.zeros_like(self.period)
        return Beside(nothing, nothing, nothing, nothing)


@dataclass(frozen=True)
class CyclesInWell(Cycles):
    """Cycles in any well, by quadrature.

    Parameters
    ----------
    energy : ndarray
        Above the least, with the cycle's own stiffness.
    v_third, v_fourth, xv_square : ndarray
        Means of \\|v\\|^3, v^4 and x^2 v^2 (x itself).
    harmonics : ndarray
        Squares of the cosine coefficients of x, one column for each.
    tail : ndarray
        n^4 times the squares of those that follow.
    stiffness, centre : ndarray
        Of the memory, in phase, and the place about which it acts.
    least, left, right : ndarray
        The place of least energy, with the cycle's own stiffness, and the ends of the cycle.
    """

    energy: Floats
    v_third: Floats
    v_fourth: Floats
    xv_square: Floats
    harmonics: Floats
    tail: Floats
    stiffness: Floats
    centre: Floats
    least: Floats
    left: Floats
    right: Floats

    def sum_of(self, power: float) -> Floats:
        count = self.harmonics.shape[1]
        n, far, steps = _harmonic_numbers(count)
        return np.asarray(self.harmonics @ n**power + self.tail * float(far ** (power - 4.0) @ steps))

    def sum_over(self, factor: Any) -> Floats:
        """sum_n f(n, n w) X_n^2 with all harmonics; f takes arrays."""
        n, far, steps = _harmonic_numbers(self.harmonics.shape[1])
        w = self.frequency[:, None]
        found = np.sum(factor(n, n * w) * self.harmonics, axis=1)
        return np.asarray(found + self.tail * ((factor(far, far * w) / far**4) @ steps))

    def speed_at(self, problem: Problem, place: float) -> Floats:
        square = self._speed_square(problem, np.asarray(place))
        return np.where(square > 0.0, np.sqrt(np.maximum(square, 0.0)), np.nan)

    def path(self, problem: Problem, part: Floats) -> tuple[Floats, Floats]:
        x = self.left[:, None] + (self.right - self.left)[:, None] * np.cos(0.5 * math.pi * part) ** 2
        return x, np.sqrt(np.maximum(self._speed_square(problem, x.T).T, 0.0))

    def _speed_square(self, problem: Problem, place: Floats) -> Floats:
        """The square of the speed at places in the cycles, negative beyond them."""
        potential, least, k = problem.potential, self.least, self.stiffness
        at = potential.energy(place) - potential.energy(least)
        at = at + 0.5 * k * (place - least) * (place + least - 2.0 * self.centre)
        return np.asarray(2.0 * (self.energy - at))

    def beside(self, problem: Problem) -> Beside:
        unit, nothing = problem.unit, np.zeros_like(self.period)
        loss, electric, action = nothing, nothing, nothing
        for part in unit.parts:
            for c, mean in zip(part.damping_coefficients()[1:], (self.v_third, self.v_fourth), strict=False):
                loss = loss + c * mean
            loss = loss + part.power_beside(self)
        memory = nothing
        if problem.elements or problem.circuits:
            memory = 0.5 * self.sum_over(lambda n, w: w * problem.modulus(1j * w).imag)
            electric = 0.5 * self.sum_over(lambda n, w: w * problem.electric(1j * w).imag)
            action = -0.5 * math.pi * self.sum_over(lambda n, w: n * _slope(problem, w))
        spread = 2.0 * unit.temperature * memory + problem.multiplied * self.xv_square
        colored = [noise for noise in unit.excitations.values() if noise.has_density and not noise.is_white]
        colored.sort(key=lambda noise: noise.filter_order or 0)  # the last bit of a sum depends on its order
        for density in (np.vectorize(noise.density, otypes=[float]) for noise in colored):
            spread = spread + math.pi * self.sum_over(lambda n, w, density=density: w * w * density(w))
        return Beside(loss + memory, electric, action, spread)


def _slope(problem: Problem, w: Floats) -> Floats:
    """Derivative of the in-phase stiffness by the frequency."""
    step = 1e-5
    up, down = (problem.modulus(1j * w * factor).real for factor in (1.0 + step, 1.0 - step))
    return np.asarray((up - down) / (2.0 * step * w))


@lru_cache(maxsize=2)
def _harmonic_numbers(count: int) -> tuple[Floats, Floats, Floats]:
    """1 to ``count``, and places and weights of an integral in place of the sum from there on."""
    z, weights = panel_rule([0.0, 1.0], 16)
    return np.arange(1.0, count + 1.0), (count + 0.5) / z**2, weights * 2.0 * (count + 0.5) / z**3


@lru_cache(maxsize=2)
def _half_cycle(places: int) -> tuple[Floats, Floats, Floats]:
    """Angles theta from -pi/2 to pi/2, their weights, and the matrix of integrals up to each angle."""
    points, weights = legendre.leggauss(places)
    values = legendre.legvander(points, places)
    k = np.arange(places)
    integrals = np.empty((places, places))
    integrals[:, 0] = points + 1.0
    integrals[:, 1:] = (values[:, 2:] - values[:, :-2])[:, : places - 1] / (2.0 * k[1:] + 1.0)
    to_series = (values[:, :places] * weights[:, None]).T * (k[:, None] + 0.5)
    quarter = 0.5 * math.pi
    return quarter * points, quarter * weights, quarter * integrals @ to_series


def cycles_of(
    problem: Problem, above: Floats, place: Floats, size: tuple[int, int], like: CyclesInWell | None = None
) -> CyclesInWell:
    """The cycles whose energy is ``above`` that at a place, or above the least where the place is NaN.

    The memory's force in phase is a spring about the cycle's mean, and a weaker one about the mean of all cycles; the
    first of them, moved by the second, and the cycle are found together, from those of ``like``.  A cycle for which
    they do not settle has no period.
    """
    stiffness, centre = np.zeros_like(above), np.zeros_like(above)
    if like is not None and like.energy.shape == above.shape:
        stiffness, centre = like.stiffness, like.centre
    found = _given(problem, above, place, stiffness, centre, size)
    if not problem.remembers:
        return found
    settled, nearly, steps = _ROUGHLY if size == COARSE else _SETTLED
    last = here = np.stack([stiffness, centre])
    for number in range(steps):
        found = _given(problem, above, place, stiffness, centre, size)
        squares, whole = np.maximum(found.sum_of(0.0), 1e-300), np.zeros_like(above)
        for springpot in problem.springpots:
            whole = whole + problem.in_phase(springpot) * found.frequency**springpot.order * found.sum_of(
                springpot.order
            )
        if problem.elements or problem.circuits:
            whole = whole + found.sum_over(lambda n, w: problem.modulus(1j * w).real)
        wanted = whole / squares
        moved = found.mean - problem.field.slow_stiffness / (wanted + 1e-300) * (found.mean - problem.field.about)
        change = np.abs(wanted - stiffness) / (wanted + 1e-300) + np.abs(moved - centre) / np.sqrt(0.5 * squares)
        last, here, before = here, np.stack([wanted, moved]), last
        # far from the bottom of the well energies near the least cancel
        rounded = 1e-7 * np.sqrt(stiffness * centre**2 / found.energy) if problem.field.slow_stiffness else 0.0
        if not np.any(change > settled + rounded):  # far out of range they may not be numbers
            return found
        stiffness, centre = _ahead(before, last, here) if number % 3 == 2 and number < _AHEAD else here
    return replace(found, period=np.where(change > nearly, np.nan, found.period))


def _ahead(before: Floats, last: Floats, here: Floats) -> Floats:
    """Where a sequence that approaches its limit geometrically ends (Aitken)."""
    first, second = last - before, here - last
    ratio = np.divide(second, first, out=np.zeros_like(first), where=np.abs(first) > 1e-14 * np.abs(here))
    ratio = np.clip(ratio, -0.8, 0.8)
    return np.asarray(here + second * ratio / (1.0 - ratio))


def _given(
    problem: Problem, above: Floats, place: Floats, k: Floats, centre: Floats, size: tuple[int, int]
) -> CyclesInWell:
    """Cycles with a spring k about a centre beside the potential."""
    potential = problem.potential

    def force(x: Floats) -> Floats:
        return potential.force(x) + k * (x - centre)

    # between the bottom and the centre both forces change their sign
    here, there = np.zeros_like(above), np.clip(centre, potential.low, potential.high)
    side = np.sign(force(here))
    pulled = np.sign(there) * side < 0.0
    inner = pulled & (side != np.sign(force(there)))
    beyond = np.where(pulled, there, 0.0)
    for _ in range(_BISECTIONS if np.any(inner) else 0):
        middle = 0.5 * (here + there)
        same = np.sign(force(middle)) == side
        here, there = np.where(same, middle, here), np.where(same, there, middle)
    least = np.where(inner, here, beyond)
    offset = potential.energy(least)

    def energy(x: Floats) -> Floats:
        rows = (slice(None),) + (None,) * (x.ndim - 1)
        springs = 0.5 * k[rows] * (x - least[rows]) * (x + least[rows] - 2.0 * centre[rows])
        return np.asarray(potential.energy(x) - offset[rows] + springs)

    def force_at(x: Floats) -> Floats:
        return np.asarray(potential.force(x) + k[:, None] * (x - centre[:, None]))

    e = np.where(np.isnan(place), above, above + energy(np.nan_to_num(place)))
    e = np.maximum(e, 1e-300)
    left, right = (_turning(potential, energy, least, e, sign, k) for sign in (-1.0, 1.0))
    theta, weights, integrals = _half_cycle(size[0])
    half = 0.5 * (right - left)
    # 1 - sin and 1 + sin without cancellation
    x = np.where(theta < 0.0, left[:, None] + 2.0 * half[:, None] * np.sin(0.5 * (theta + 0.5 * math.pi)) ** 2,
                 right[:, None] - 2.0 * half[:, None] * np.sin(0.5 * (0.5 * math.pi - theta)) ** 2)  # fmt: skip
    v = np.sqrt(2.0 * np.maximum(e[:, None] - energy(x), 1e-15 * e[:, None] * np.cos(theta) ** 2))
    pace = half[:, None] * np.cos(theta) / v
    share = pace * weights
    t = np.sum(share, axis=1)
    share = share / t[:, None]
    mean = np.sum(share * x, axis=1)
    swing = x - mean[:, None]
    phase = math.pi * (1.0 - pace @ integrals.T / t[:, None])
    squares = _harmonics(share * swing, phase, size[1])
    v_square = np.sum(share * v * v, axis=1)
    frequency = math.pi / t
    missing = v_square - 0.5 * frequency**2 * (squares @ np.arange(1.0, size[1] + 1.0) ** 2)
    missing = np.where(missing > 1e-6 * v_square, missing, 0.0)
    place_x = x + problem.origin
    return CyclesInWell(
        energy=e,
        period=2.0 * t,
        mean=mean,
        x_square=np.sum(share * x * x, axis=1),
        v_square=v_square,
        v_third=np.sum(share * v**3, axis=1),
        v_fourth=np.sum(share * v**4, axis=1),
        xv_square=np.sum(share * (place_x * v) ** 2, axis=1),
        harmonics=squares,
        tail=2.0 * missing * (size[1] + 0.5) / frequency**2,
        stiffness=k,
        centre=centre,
        least=least,
        left=left,
        right=right,
        arc=np.sum(share * swing * force_at(x), axis=1) / np.maximum(np.sum(share * swing * swing, axis=1), 1e-300),
    )


def _harmonics(weighted: Floats, phase: Floats, count: int) -> Floats:
    """Squares of X_n = (4/T) int x cos(n w t) dt over half a cycle."""
    cosine = np.cos(phase)
    before, now = np.ones_like(cosine), cosine
    found = np.empty((weighted.shape[0], count))
    for n in range(count):
        found[:, n] = 2.0 * np.sum(weighted * now, axis=1)
        before, now = now, 2.0 * cosine * now - before
    return found * found


def _turning(potential: Potential, energy: Any, least: Floats, e: Floats, sign: float, k: Floats) -> Floats:
    """Where the cycles turn on one side, or the wall before that."""
    wall = potential.low if sign < 0.0 else potential.high
    stiff = np.maximum(potential.curvature(least) + k, 0.0)
    push = np.maximum(sign * potential.force(least), 0.0)
    with np.errstate(divide="ignore"):
        reach = np.minimum(np.minimum(np.sqrt(2.0 * e / stiff), e / push), 1e30)
    room = sign * (wall - least) if math.isfinite(wall) else np.full_like(e, math.inf)
    reach = np.minimum(reach, room)
    for _ in range(400):
        short = (energy(least + sign * reach) < e) & (reach < room)
        if not np.any(short):
            break
        reach = np.where(short, np.minimum(2.0 * reach, room), reach)
    for _ in range(400):
        long = energy(least + 0.5 * sign * reach) > e
        if not np.any(long):
            break
        reach = np.where(long, 0.5 * reach, reach)
    struck = (reach >= room) & (energy(least + sign * reach) <= e)
    low, high = 0.5 * reach, reach
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        inside = energy(least + sign * middle) <= e
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.where(struck, wall, least + sign * high)


@dataclass(frozen=True)
class Ladder:
    """One label for all cycles, rising with their size: an energy, counted from that at the last place passed.

    Parameters
    ----------
    places : tuple of float
        Walls and contacts in the order in which growing cycles reach them.
    starts : tuple of float
        The label at which they do.
    lengths : tuple of float
        Energy above that at the place, when the next one is reached.
    """

    places: tuple[float, ...]
    starts: tuple[float, ...]
    lengths: tuple[float, ...]

    def cycles(
        self, problem: Problem, label: Floats, size: tuple[int, int], like: CyclesInWell | None = None
    ) -> CyclesInWell:
        """The cycles with these labels, found from those of ``like``."""
        above, place = np.array(label), np.full_like(label, math.nan)
        ends = (*self.starts, math.inf)[1:]
        for where, start, end, length in zip(self.places, self.starts, ends, self.lengths, strict=True):
            here = (label > start) & (label <= end)
            scale = length / (end - start) if math.isfinite(end) else 1.0
            above = np.where(here, (label - start) * scale, above)
            place = np.where(here, where, place)
        return cycles_of(problem, above, place, size, like)

    def grid(
        self, problem: Problem, found: tuple[float, ...], size: tuple[int, int], like: CyclesInWell | None
    ) -> tuple[Labels, CyclesInWell]:
        """Panels of the label from the least to the largest one of interest, and the cycles at their nodes."""
        low, high, typical = found
        if low > 0.02 * high:
            edges = np.linspace(low, high, 25)
        else:
            least = typical / 30.0
            near = np.arange(math.log(least), math.log(min(high, 100.0 * typical)), _NEAR)
            edges = np.r_[0.0, np.exp(near), np.exp(np.arange(near[-1] + _NEAR, math.log(high), _BROAD)), high]
        cuts = [start for start in self.starts if edges[0] < start < edges[-1]]
        edges = np.unique(np.r_[edges, cuts])
        edges = edges[np.r_[True, np.diff(edges) > 1e-9 * edges[1:]]]
        labels = Labels(np.arange(float(edges.size)))
        panel = np.repeat(np.arange(edges.size - 1), labels.nodes.shape[1])
        part = labels.nodes.ravel() - panel
        bent = np.isin(edges, [0.0, *cuts])[panel]  # roots of the energy above a place that is just reached
        label = edges[panel] + (edges[panel + 1] - edges[panel]) * np.where(bent, part * part, part)
        cycles = self.cycles(problem, label, size, like)
        check_settled(cycles)
        return labels, cycles


def ladder_of(problem: Problem) -> Ladder:
    places = np.array(problem.places)
    away = problem.potential.energy(places) > 1e-12 * problem.potential.size(places)
    drawn = problem.potential.force(places) + problem.field.slow_stiffness * (places - problem.field.about)
    away |= (places == problem.potential.low) & (drawn < 0.0) | (places == problem.potential.high) & (drawn > 0.0)
    at_rest, places = [float(place) for place in places[~away]], places[away]
    if not places.size:
        return Ladder(tuple(at_rest[:1]), (0.0,) * len(at_rest[:1]), (math.inf,) * len(at_rest[:1]))
    touching = cycles_of(problem, np.zeros_like(places), places, FINE)
    check_settled(touching)
    energies = touching.energy
    order = np.argsort(energies, kind="stable")
    kept: list[int] = []
    for index in order:
        if not kept or energies[index] > energies[kept[-1]] * (1.0 + 1e-9):
            kept.append(int(index))
    passed = (*at_rest[:1], *(float(places[index]) for index in kept))
    starts = (*(0.0 for _ in at_rest[:1]), *(float(energies[index]) for index in kept))
    lengths = []
    for place, following in zip(passed, kept[len(passed) == len(kept) :], strict=False):
        square = touching.speed_at(problem, place)[following] ** 2
        if not square > 0.0:
            raise NotCoveredError(f"{REACH}; here cycles of different size cross: the memory is too strong.")
        lengths.append(0.5 * float(square))
    return Ladder(passed, starts, (*lengths, math.inf))


def check_settled(cycles: CyclesInWell) -> None:
    if np.any(np.isnan(cycles.period)):
        raise NotCoveredError(f"{REACH}; here cycles and their own stiffness do not settle: the memory is too strong.")
