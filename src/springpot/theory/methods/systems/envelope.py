"""The energy envelope of systems: slow diffusion of the size of the cycles in any single well."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre, polynomial
from numpy.typing import NDArray
from scipy import optimize

from springpot.faults import NotCovered
from springpot.parts import (
    Barrier,
    Circuit,
    ColouredNoise,
    Contact,
    FilteredNoise,
    Harmonic,
    Maxwell,
    ParametricNoise,
    PoissonImpulses,
    PolynomialDashpot,
    Series,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.parts.walls import restitution_at, slow_restitution
from springpot.potential import Potential
from springpot.system import System
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.methods.envelope.balance import Labels
from springpot.theory.methods.systems.result import (
    SystemMoments,
    SystemResult,
    at_all_walls,
    checked_system,
    walls_of,
)

__all__ = ["envelope_of_system"]

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_REACH = "The envelope of systems covers one well, between walls or without them, with stationary noise"
_PLACES = 96  # of a half cycle, by Gauss's rule over theta with x = mid + half sin(theta)
_HARMONICS = 64
_COARSE = (40, 12)  # the same in the search for the energies of interest
_BISECTIONS = 54
_SETTLED = 1e-10, 1e-4, 200  # of the cycles' own stiffness: change at the end, tolerated change, steps
_ROUGHLY = 1e-5, 1e-2, 40  # the same in the search
_LOWEST, _HIGHEST = -50.0, 40.0  # decades of energy that are searched, in m^2/s^2
_FAR = 42.0  # the density ends where its share in the mean energy has fallen by e^-42
_REBOUNDS = 20  # iterations for the restitution of a law of the speed
_NEAR, _BROAD = 0.25, 1.0  # widths of panels in ln E, up to a hundred times the typical energy and beyond
_STRONG, _TOO_STRONG = 1.0, 3.0  # loss in a cycle over the energy: above them moments can be off by some 5 and 10 %


@dataclass(frozen=True)
class _Problem:
    """A system per unit mass, its potential seen from the bottom of the well.

    Parameters
    ----------
    potential : Potential
        As a function of x - origin.
    origin : float
        The bottom: the place of least potential energy.
    damping : float
        Of all linear dampers.
    elements : tuple
        What has a modulus and memory.
    circuits : tuple of Circuit
    unit : System
    """

    potential: Potential
    origin: float
    damping: float
    elements: tuple[Springpot | Series | Maxwell, ...]
    circuits: tuple[Circuit, ...]
    unit: System

    @property
    def remembers(self) -> bool:
        """Whether anything has memory."""
        return bool(self.elements or self.circuits)

    def modulus(self, p: Any) -> ComplexArray:
        """Force over displacement of everything with memory."""
        found: ComplexArray = np.zeros_like(p)
        for element in self.elements:
            found = found + element.modulus(p)
        return found + self.electric(p)

    def electric(self, p: Any) -> ComplexArray:
        """The same of the circuits alone."""
        found: ComplexArray = np.zeros_like(p)
        for circuit in self.circuits:
            found = found + circuit.coupling**2 / circuit.capacitance * p / (p + 1.0 / circuit.time)
        return found

    @property
    def places(self) -> list[float]:
        """Where cycles change their kind as they grow: walls and the beginnings of contacts, seen from the bottom."""
        ends = self.potential.low, self.potential.high, *(contact.position for contact in self.potential.contacts)
        return [place for place in ends if math.isfinite(place)]


@dataclass(frozen=True)
class _Cycles:
    """Closed cycles of one system; one entry per cycle for every array.

    Parameters
    ----------
    energy : ndarray
        Above the least, with the cycle's own stiffness.
    period, mean, x_square, v_square : ndarray
        Mean and mean square of x are those of x - origin.
    v_third, v_fourth, xv_square : ndarray
        Means of \\|v\\|^3, v^4 and x^2 v^2 (x itself).
    harmonics : ndarray
        Squares of the cosine coefficients of x, one column for each.
    tail : ndarray
        n^4 times the squares of those that follow.
    stiffness, centre : ndarray
        Of the memory, in phase, and the cycle's mean about which it acts.
    """

    energy: FloatArray
    period: FloatArray
    mean: FloatArray
    x_square: FloatArray
    v_square: FloatArray
    v_third: FloatArray
    v_fourth: FloatArray
    xv_square: FloatArray
    harmonics: FloatArray
    tail: FloatArray
    stiffness: FloatArray
    centre: FloatArray
    least: FloatArray

    @property
    def frequency(self) -> FloatArray:
        return np.asarray(2.0 * math.pi / self.period)

    def sum_over(self, factor: Any) -> FloatArray:
        """sum_n f(n, n w) X_n^2 with all harmonics; f takes arrays."""
        count = self.harmonics.shape[1]
        n = np.arange(1.0, count + 1.0)
        found = np.sum(factor(n, n * self.frequency[:, None]) * self.harmonics, axis=1)
        z, weights = _tail_nodes()
        far = (count + 0.5) / z**2  # the sum from there on as an integral
        steps = weights * 2.0 * (count + 0.5) / z**3
        return np.asarray(found + self.tail * ((factor(far, far * self.frequency[:, None]) / far**4) @ steps))


@lru_cache(maxsize=1)
def _tail_nodes() -> tuple[FloatArray, FloatArray]:
    points, weights = legendre.leggauss(16)
    return 0.5 * (points + 1.0), 0.5 * weights


@lru_cache(maxsize=2)
def _half_cycle(places: int) -> tuple[FloatArray, FloatArray, FloatArray]:
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


def _cycles(problem: _Problem, above: FloatArray, place: FloatArray, size: tuple[int, int]) -> _Cycles:
    """The cycles whose energy is ``above`` that at a place, or above the least where the place is NaN.

    The memory's force in phase is a spring about the cycle's mean; the two are found together.  A cycle for which they
    do not settle has no period.
    """
    stiffness, centre = np.zeros_like(above), np.zeros_like(above)
    found = _given(problem, above, place, stiffness, centre, size)
    if not problem.remembers:
        return found
    settled, nearly, steps = _ROUGHLY if size == _COARSE else _SETTLED
    for _ in range(steps):
        found = _given(problem, above, place, stiffness, centre, size)
        squares = found.sum_over(lambda n, w: np.ones_like(w))
        wanted = found.sum_over(lambda n, w: problem.modulus(1j * w).real) / squares
        change = np.abs(wanted - stiffness) / (wanted + 1e-300) + np.abs(found.mean - centre) / np.sqrt(0.5 * squares)
        stiffness, centre = wanted, found.mean
        if not np.any(change > settled):  # far out of range they may not be numbers
            return found
    return replace(found, period=np.where(change > nearly, np.nan, found.period))


def _given(
    problem: _Problem, above: FloatArray, place: FloatArray, k: FloatArray, centre: FloatArray, size: tuple[int, int]
) -> _Cycles:
    """Cycles with a spring k about a centre beside the potential."""
    potential = problem.potential

    def force(x: FloatArray) -> FloatArray:
        return potential.force(x) + k * (x - centre)

    # between the bottom and the centre both forces change their sign
    here, there = np.zeros_like(above), np.array(centre)
    inner = np.sign(force(here)) != np.sign(force(there))
    for _ in range(_BISECTIONS):
        middle = 0.5 * (here + there)
        same = np.sign(force(middle)) == np.sign(force(here))
        here, there = np.where(same, middle, here), np.where(same, there, middle)
    least = np.where(inner, here, 0.0)
    offset = potential.energy(least)

    def energy(x: FloatArray) -> FloatArray:
        rows = (slice(None),) + (None,) * (x.ndim - 1)
        springs = 0.5 * k[rows] * (x - least[rows]) * (x + least[rows] - 2.0 * centre[rows])
        return np.asarray(potential.energy(x) - offset[rows] + springs)

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
    return _Cycles(
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
    )


def _harmonics(weighted: FloatArray, phase: FloatArray, count: int) -> FloatArray:
    """Squares of X_n = (4/T) int x cos(n w t) dt over half a cycle."""
    cosine = np.cos(phase)
    before, now = np.ones_like(cosine), cosine
    found = np.empty((weighted.shape[0], count))
    for n in range(count):
        found[:, n] = 2.0 * np.sum(weighted * now, axis=1)
        before, now = now, 2.0 * cosine * now - before
    return found * found


def _turning(
    potential: Potential, energy: Any, least: FloatArray, e: FloatArray, sign: float, k: FloatArray
) -> FloatArray:
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
class _Ladder:
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

    def cycles(self, problem: _Problem, label: FloatArray, size: tuple[int, int]) -> _Cycles:
        """The cycles with these labels."""
        above, place = np.array(label), np.full_like(label, math.nan)
        ends = (*self.starts, math.inf)[1:]
        for where, start, end, length in zip(self.places, self.starts, ends, self.lengths, strict=True):
            here = (label > start) & (label <= end)
            scale = length / (end - start) if math.isfinite(end) else 1.0
            above = np.where(here, (label - start) * scale, above)
            place = np.where(here, where, place)
        return _cycles(problem, above, place, size)


def _ladder(problem: _Problem) -> _Ladder:
    places = np.array(problem.places)
    away = problem.potential.energy(places) > 1e-12 * problem.potential.size(places)
    at_rest, places = [float(place) for place in places[~away]], places[away]
    if not places.size:
        return _Ladder(tuple(at_rest[:1]), (0.0,) * len(at_rest[:1]), (math.inf,) * len(at_rest[:1]))
    touching = _cycles(problem, np.zeros_like(places), places, (_PLACES, _HARMONICS))
    _check_settled(touching)
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
        square = _speed_at(problem, touching, place)[following] ** 2
        if not square > 0.0:
            raise NotCovered(f"{_REACH}; here cycles of different size cross: the memory is too strong.")
        lengths.append(0.5 * float(square))
    return _Ladder(passed, starts, (*lengths, math.inf))


@dataclass(frozen=True)
class _Rates:
    """What changes the energy of cycles: one entry per cycle.

    Parameters
    ----------
    loss, spread : ndarray
        Mean power that is taken, and the rate D at which the variance of the energy grows.
    action : ndarray
        That of the cycle with its memory: the integral of v dx, less what the memory lends out to a slow change.
    electric : ndarray
        Power in the resistors.
    struck : tuple of ndarray
        The speed at each wall and contact at first touch, before the loss is counted; NaN where it is not reached.
    """

    loss: FloatArray
    spread: FloatArray
    action: FloatArray
    electric: FloatArray
    struck: tuple[FloatArray, ...]


def _rates(problem: _Problem, cycles: _Cycles) -> _Rates:
    unit = problem.unit
    loss = problem.damping * cycles.v_square
    for part in unit.of(PolynomialDashpot):
        for c, mean in zip(part.coefficients[1:], (cycles.v_third, cycles.v_fourth), strict=False):
            loss = loss + c * mean
    for pump in unit.of(VanDerPol):
        loss = loss + pump.coefficient * (cycles.xv_square - pump.length**2 * cycles.v_square)
    memory, electric = np.zeros_like(loss), np.zeros_like(loss)
    action = cycles.period * cycles.v_square
    if problem.remembers:
        memory = 0.5 * cycles.sum_over(lambda n, w: w * problem.modulus(1j * w).imag)
        electric = 0.5 * cycles.sum_over(lambda n, w: w * problem.electric(1j * w).imag)
        action = action - 0.5 * math.pi * cycles.sum_over(lambda n, w: n * _slope(problem, w))
    kinetic = problem.damping * cycles.v_square + memory
    spread = 2.0 * sum(noise.temperature for noise in unit.of(ThermalNoise)) * kinetic
    white = sum(n.intensity for n in unit.of(WhiteNoise)) + sum(n.intensity for n in unit.of(PoissonImpulses))
    spread = spread + white * cycles.v_square
    spread = spread + sum(noise.intensity for noise in unit.of(ParametricNoise)) * cycles.xv_square
    densities = *(n.density for n in unit.of(ColouredNoise)), *(n.density for n in unit.of(FilteredNoise))
    for density in (np.vectorize(each, otypes=[float]) for each in densities):
        spread = spread + math.pi * cycles.sum_over(lambda n, w, density=density: w * w * density(w))
    loss, struck = loss + memory, []
    for wall in walls_of(unit):
        place = wall.position - problem.origin
        speed = _speed_at(problem, cycles, place)
        struck.append(speed)
        if isinstance(wall, Barrier):
            r_square = _restitution(wall, speed) ** 2
            loss = loss + np.nan_to_num(speed) ** 2 * (1.0 - r_square) / (1.0 + r_square) / cycles.period
    return _Rates(loss, spread, action, electric, tuple(struck))


def _restitution(wall: Barrier, speed: FloatArray) -> float | FloatArray:
    """r of the impacts of a cycle that reaches the wall with this speed in the middle of its loss.

    The squares of the speeds before and after an impact have that of ``speed`` as their mean.
    """
    if not callable(wall.restitution):
        return wall.restitution
    law = np.vectorize(lambda v: restitution_at(wall, v), otypes=[float])
    known = np.nan_to_num(speed)
    r = np.clip(law(known), 0.0, 1.0)
    for _ in range(_REBOUNDS):
        r = np.clip(law(known * np.sqrt(2.0 / (1.0 + r**2))), 0.0, 1.0)
    return np.asarray(r)


def _slope(problem: _Problem, w: FloatArray) -> FloatArray:
    """Derivative of the in-phase stiffness by the frequency."""
    step = 1e-5
    up, down = (problem.modulus(1j * w * factor).real for factor in (1.0 + step, 1.0 - step))
    return np.asarray((up - down) / (2.0 * step * w))


def _speed_at(problem: _Problem, cycles: _Cycles, place: float) -> FloatArray:
    potential, least, k = problem.potential, cycles.least, cycles.stiffness
    at = potential.energy(place) - potential.energy(least)
    at = at + 0.5 * k * (place - least) * (place + least - 2.0 * cycles.centre)
    square = 2.0 * (cycles.energy - at)
    return np.where(square > 0.0, np.sqrt(np.maximum(square, 0.0)), np.nan)


@dataclass(frozen=True)
class _Law:
    """The stationary law on a grid of cycles: their probabilities."""

    cycles: _Cycles
    rates: _Rates
    weight: FloatArray

    def average(self, values: FloatArray) -> float:
        return float(self.weight @ values)


def _range(problem: _Problem, ladder: _Ladder) -> tuple[float, float, float] | str:
    """The least and largest label of interest and their typical size, or why there is no stationary state."""
    low, high = _LOWEST, _HIGHEST
    for count in (361, 241, 241):
        decades = np.linspace(low, high, count)
        label = 10.0**decades
        with np.errstate(all="ignore"):
            cycles = ladder.cycles(problem, label, _COARSE)
            rates = _rates(problem, cycles)
            slope = 2.0 * rates.loss / (rates.spread * cycles.period)
            known = np.isfinite(slope) & np.isfinite(rates.action) & (rates.action > 0.0)
        if not np.any(known):
            raise NotCovered(f"{_REACH}; here the energies are beyond double precision.")
        label, decades, slope, action = label[known], decades[known], slope[known], rates.action[known]
        fall = np.r_[0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(action))]
        near = np.log(action) - fall
        far = near + np.log(label)
        first = int(np.argmax(near > near.max() - _FAR))
        last = label.size - 1 - int(np.argmax((far > far.max() - _FAR)[::-1]))
        if last == label.size - 1 and (high == _HIGHEST or far[-1] > far.max() - 0.5 * _FAR):
            return "feeds"
        typical = float(np.exp(np.average(np.log(label), weights=np.exp(near - near.max()))))
        low, high = float(decades[max(first - 1, 0)]), float(decades[min(last + 1, decades.size - 1)])
    return 10.0**low, 10.0**high, typical


def _check_settled(cycles: _Cycles) -> None:
    if np.any(np.isnan(cycles.period)):
        raise NotCovered(f"{_REACH}; here cycles and their own stiffness do not settle: the memory is too strong.")


def _law(problem: _Problem) -> _Law | str:
    ladder = _ladder(problem)
    found = _range(problem, ladder)
    if isinstance(found, str):
        if problem.unit.of(ParametricNoise):
            return "There is no stationary mean square: the noise that multiplies x feeds more than is dissipated."
        return "There is no stationary state: nothing dissipates energy, so it grows without end."
    low, high, typical = found
    if low > 0.02 * high:
        edges = np.linspace(low, high, 25)
    else:
        least = typical / 30.0
        near = np.arange(math.log(least), math.log(min(high, 100.0 * typical)), _NEAR)
        edges = np.r_[0.0, np.exp(near), np.exp(np.arange(near[-1] + _NEAR, math.log(high), _BROAD)), high]
    cuts = [start for start in ladder.starts if edges[0] < start < edges[-1]]
    edges = np.unique(np.r_[edges, cuts])
    edges = edges[np.r_[True, np.diff(edges) > 1e-9 * edges[1:]]]
    labels = Labels(np.arange(float(edges.size)), 0, 0.0)
    panel = np.repeat(np.arange(edges.size - 1), labels.nodes.shape[1])
    part = labels.nodes.ravel() - panel
    bent = np.isin(edges, [0.0, *cuts])[panel]  # roots of the energy above a place that is just reached
    label = edges[panel] + (edges[panel + 1] - edges[panel]) * np.where(bent, part * part, part)
    cycles = ladder.cycles(problem, label, (_PLACES, _HARMONICS))
    _check_settled(cycles)
    rates = _rates(problem, cycles)
    measure = labels.derivative(rates.action)
    fall = labels.integral(2.0 * rates.loss / (rates.spread * cycles.period) * measure)
    weight = labels.weights.ravel() * measure * np.exp(fall.min() - fall)
    if np.any(weight < -1e-6 * np.abs(weight).sum()):
        raise NotCovered(f"{_REACH}; here cycles of different size cross: the memory is too strong.")
    return _Law(cycles, rates, np.maximum(weight, 0.0) / np.maximum(weight, 0.0).sum())


def envelope_of_system(system: System) -> SystemResult:
    """Solve a system by diffusion of the energy of its cycles.

    Parameters
    ----------
    system : System
        Any springs, contacts without loss and constant forces that leave one well; rigid walls; dampers, memory and
        circuits; white, coloured, filtered, Poisson, parametric and thermal noise.

    Returns
    -------
    SystemResult

    Raises
    ------
    NotCovered
        If there are two wells, a harmonic force, a contact with loss, or memory so strong that cycles of different size
        cross; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    A cycle is a periodic motion in the potential U(x) + k1 (x - X0)^2 / 2 between the walls.  k1 is the mean in-phase
    stiffness of the memory over the harmonics X_n of the cycle, X0 the cycle's mean.  With the power
    P = (1/2) sum n w Im K(n w) X_n^2 that an element of modulus K takes, further losses L, the rate D at which noise
    spreads the energy, and the action J = int v dx - (pi/2) sum n Re K'(n w) X_n^2, the stationary density per action
    is exp(-int 2 (P + L) / (D T) dJ).  The second term makes J that of a wave with dispersion [1]_: for a linear
    oscillator <v^2> is then exact to first order in K.

    References
    ----------
    .. [1] G. B. Whitham, "Linear and nonlinear waves", Wiley (1974), chapter 14.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 0.2), sp.WhiteNoise(0.5),
    ...     sp.Barrier(-1.0, 0.9), sp.Barrier(0.7, 0.8, side="below"),
    ... )
    >>> result = envelope_of_system(device)
    >>> round(result.x_mean_square, 2), [round(rate, 2) for rate in result.barrier_impact_rate]
    (0.23, [0.17, 0.24])
    """
    unit = checked_system(system).per_unit_mass
    _check_covered(unit)
    warnings: tuple[str, ...] = ()
    stationary: SystemMoments | str
    noises = unit.of(WhiteNoise, ColouredNoise, FilteredNoise, PoissonImpulses, ThermalNoise)
    if all(isinstance(noise, WhiteNoise) and noise.intensity == 0.0 for noise in noises):
        stationary = "There is no random stationary state: nothing excites the motion."
    elif not unit.potential.holds():
        stationary = "There is no stationary state: no spring or wall holds the mass on one side."
    else:
        problem = _problem(unit)
        if problem.remembers and not np.any(unit.potential.coefficients) and not unit.of(Contact):
            raise NotCovered(f"{_REACH}; with memory it needs a spring or a force to hold a small cycle in its place.")
        if unit.of(ThermalNoise) and not problem.remembers and not problem.damping > 0.0:
            raise NotCovered(
                "ThermalNoise needs something that dissipates: a dashpot, a springpot, an arm or a circuit."
            )
        law = _law(problem)
        stationary = law if isinstance(law, str) else _moments(system, problem, law)
        warnings = () if isinstance(law, str) else tuple(_warnings(problem, law))
    return SystemResult(
        method="envelope",
        system=system,
        stationary=stationary,
        assumptions=(
            "The energy changes little in one cycle: damping and noise are light or moderate.",
            "The memory acts on a cycle as a spring about its mean and as a damper, not on slow changes of the mean.",
            "After an impact the energy is that of the whole cycle: many impacts in one hop are not resolved.",
        ),
        warnings=warnings,
    )


def _check_covered(unit: System) -> None:
    for name, part in unit.named():
        if isinstance(part, Harmonic):
            raise NotCovered(f"{_REACH}, not {name}.")
        if isinstance(part, Contact) and part.dissipation > 0.0:
            raise NotCovered(f"{_REACH}, not the dissipation of {name}.")


def _problem(unit: System) -> _Problem:
    origin = _bottom(unit.potential)
    return _Problem(
        potential=unit.potential.seen_from(origin),
        origin=origin,
        damping=unit.damping + sum(part.coefficient for part in unit.of(Springpot) if part.order == 1.0),
        elements=(*(pot for pot in unit.of(Springpot) if pot.remembers), *unit.of(Series), *unit.of(Maxwell)),
        circuits=unit.of(Circuit),
        unit=unit,
    )


def _bottom(potential: Potential) -> float:
    """The place of the one well.

    Raises
    ------
    NotCovered
        If there are several.
    """
    low, high = potential.low, potential.high
    roots = polynomial.polyroots(potential.coefficients).real if len(potential.coefficients) > 1 else np.zeros(0)
    starts = [contact.position for contact in potential.contacts]
    walls = [place for place in (low, high) if math.isfinite(place)]
    marks = np.unique([*roots, *starts, *walls, 0.0])
    steps = np.geomspace(1e-12, 1e6, 400) * max(float(np.abs(marks).max()), _length(potential))
    places = np.concatenate([*(mark + sign * steps for mark in marks for sign in (-1.0, 1.0)), marks])
    places = np.unique(places[(places >= low) & (places <= high)])
    force = potential.force(places)
    size = polynomial.polyval(np.abs(places), np.abs(potential.coefficients))
    told = np.abs(force) > 1e-10 * (size + np.abs(force))
    places, signs = places[told], np.sign(force[told])
    if not places.size:
        return 0.5 * (low + high)
    wells = [(a, b) for a, b, s, t in zip(places, places[1:], signs, signs[1:], strict=False) if s < 0.0 < t]
    at_walls = [low] * bool(signs[0] > 0.0) + [high] * bool(signs[-1] < 0.0)
    if len(wells) + len(at_walls) > 1:
        raise NotCovered(f"{_REACH}, not two wells.")
    if at_walls:
        return float(at_walls[0])
    return float(optimize.brentq(lambda x: float(potential.force(x)), *wells[0], xtol=1e-300, rtol=1e-15))


def _length(potential: Potential) -> float:
    """Some length of the potential, where no place has one."""
    terms = [(n, abs(c)) for n, c in enumerate(potential.coefficients) if c != 0.0 and n > 0]
    if len(terms) < 2:
        return 1.0
    (n, first), (m, last) = terms[0], terms[-1]
    return math.exp(min(max(math.log(first / last) / (m - n), -100.0), 100.0))


def _moments(system: System, problem: _Problem, law: _Law) -> SystemMoments:
    unit, cycles = problem.unit, law.cycles
    shift, square = law.average(cycles.mean), law.average(cycles.x_square)
    x_square = problem.origin * (problem.origin + 2.0 * shift) + square
    v_square = law.average(cycles.v_square)
    rates, means, squares = [], [], []
    for wall, speed in zip(walls_of(unit), law.rates.struck, strict=True):
        before = np.sqrt(2.0 / (1.0 + _restitution(wall, speed) ** 2)) if isinstance(wall, Barrier) else 1.0
        hits, fast = np.isfinite(speed) / cycles.period, before * np.nan_to_num(speed)
        rate = law.average(hits)
        many = isinstance(wall, Barrier) and _endless(unit, wall) and rate > 0.0
        rates.append(math.nan if many else rate)
        means.append(law.average(hits * fast) / rate if rate > 0.0 and not many else math.nan)
        squares.append(law.average(hits * fast**2) / rate if rate > 0.0 and not many else math.nan)
    omega = system.natural_frequency
    harvested = law.average(law.rates.electric) * system.mass if problem.circuits else math.nan
    return SystemMoments(
        amplitude_mean_square=x_square + v_square / omega**2,
        x_mean=problem.origin + shift,
        x_mean_square=x_square,
        v_mean_square=v_square,
        **at_all_walls(rates, means, squares),
        harvested_power=math.nan if unit.of(ThermalNoise) else harvested,
    )


def _endless(unit: System, wall: Barrier) -> bool:
    """Whether a wall is struck infinitely often: by slow impacts, or without white noise."""
    white = any(noise.intensity > 0.0 for noise in unit.of(WhiteNoise))
    smooth = not white and not unit.of(PoissonImpulses) and not unit.of(ThermalNoise)
    slow = slow_restitution(wall)
    return slow <= COLLAPSE_BELOW or (slow < 1.0 and smooth)


def _warnings(problem: _Problem, law: _Law) -> Iterator[str]:
    unit, cycles, rates = problem.unit, law.cycles, law.rates
    harmless = problem.damping * cycles.v_square  # exact between elastic walls
    taken = law.average(np.abs(rates.loss - harmless) * cycles.period) / law.average(cycles.energy)
    if taken > _STRONG:
        error = "some 5 % and impact rates by 15 %" if taken < _TOO_STRONG else "more than 10 %"
        yield (
            f"Damping is not light: a cycle takes {taken:.2g} times the mean energy, so that moments can be off by "
            f"{error}."
        )
    for name, part in unit.named():
        if isinstance(part, Barrier) and _endless(unit, part):
            yield f"{name} is struck infinitely often by slow impacts: its impact rate and speeds do not exist."
    decay = law.average(rates.loss) / law.average(cycles.energy)
    for name, part in unit.named():
        if isinstance(part, ColouredNoise | FilteredNoise):
            slow = part.correlation_time if isinstance(part, ColouredNoise) else 1.0 / (part.damping * part.frequency)
            if slow * decay > _STRONG:
                yield f"{name} remembers longer than the energy does: its work is not that of a short correlation."
        if isinstance(part, PoissonImpulses) and 0.5 * part.mean_square > 0.1 * law.average(cycles.energy):
            yield f"The impulses of {name} are so rare that the energy jumps: here they act as white noise."
