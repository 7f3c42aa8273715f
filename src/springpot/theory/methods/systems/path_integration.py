"""Path integration of a system with colored noise: the stationary law of the noise, x and v on a grid."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    Constant,
    Springpot,
    VanDerPol,
)
from springpot.problem.potential import Potential
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import DAMPERS, SPRINGS, STOPS, Coverage, unheld
from springpot.theory.methods.envelope.walls import endless_walls
from springpot.theory.methods.systems.chain import Chain, Grid, grid_over, kernel_weights, make_chain
from springpot.theory.numerics.equations import Anderson, roots_of
from springpot.theory.result import Moments, NoConvergenceError, Result, moments_of

REACH = "Path integration covers one colored noise with springs, contacts without loss, dampers, springpots and walls"
_COVERED = Coverage(REACH, SPRINGS | DAMPERS | VanDerPol | Springpot | STOPS | Constant | ColoredNoise)

_ROUGH, _ROUGH_FREE, _FINE = (7, 26, 31), (7, 36, 37), (11, 40, 49)  # nodes of y, x and v
_WIDE = 6.0  # standard deviations of x to the ends of the grid where there is no wall, and half a deviation less of v
_STEP, _SHORTEST = 0.1, 0.2  # step over the time in which v crosses a deviation of x, and over the correlation time
_SOFT, _STIFF = 0.25, 2.0  # the same, over the inverse of a usual frequency, and of the highest and of the damping
_LEAST = 0.006  # step over the first of these times below which there would be too many
_TOGETHER = 0.5, 0.1  # time of the steps of one vector of Arnoldi's iteration, over that and over the second
_MOST = 100  # of these steps
_GROWTH = 1.0005  # of a wave in them that is tolerated beside a memory
_LONGEST = 80.0  # of correlations, over the first
_FITS = 1.15  # change of a scale up to which the grid stays
_SETTLED, _ROUNDS, _FINE_ROUNDS = 2e-3, 24, 2  # change of the moments from one memory force to the next
_STARTS, _WIDER = 10, (1.3, 1.8)  # grids that are tried; how much wider than one without a law
_WIDENED = 3  # times at most


@dataclass(frozen=True)
class _Problem:
    """A system per unit mass, as the chain takes it."""

    unit: System
    noise: ColoredNoise
    springpots: tuple[Springpot, ...]
    stops: tuple[Barrier, ...]
    damping: float


@dataclass(frozen=True)
class _Memory:
    """The mean force of the springpots at given y, x and v: a polynomial of these over scales, about a centre.

    Parameters
    ----------
    centre, x_scale, v_scale, y_scale : float
    coefficients : ndarray, shape (10,)
    """

    centre: float
    x_scale: float
    v_scale: float
    y_scale: float
    coefficients: Floats

    def terms(self, y: Floats, x: Floats, v: Floats) -> Floats:
        y, x, v = y / self.y_scale, (x - self.centre) / self.x_scale, v / self.v_scale
        return np.stack([np.ones_like(x), x, v, y, x * x, x * v, v * v, x * y, v * y, y * y])

    def force(self, y: Floats, x: Floats, v: Floats) -> Floats:
        return np.asarray(np.tensordot(self.coefficients, self.terms(y, x, v), 1))


@dataclass(frozen=True)
class _Law:
    """The stationary weights of a chain, and their first moments."""

    chain: Chain
    weights: Floats
    mean: float
    deviation: float
    speed: float

    @classmethod
    def of(cls, chain: Chain, weights: Floats) -> _Law:
        _, x, v = chain.grid.places
        mean = float(weights @ x)
        square, speed = float(weights @ (x - mean) ** 2), float(weights @ v**2)
        if not (square > 0.0 and speed > 0.0):
            raise NoConvergenceError(
                "path integration found no stationary law: the weights of its nodes are not those of a law."
            )
        return cls(chain, weights, mean, math.sqrt(square), math.sqrt(speed))


@np.errstate(all="ignore")  # what is not finite is no answer
def path_integration(system: System) -> Result:
    """Solve a system with colored noise by a Markov chain of the noise, x and v on a grid.

    Parameters
    ----------
    system : System
        One colored noise and no other; springs, constant forces and contacts without loss that leave any wells;
        dampers; springpots; rigid walls of any restitution.

    Returns
    -------
    Result

    Raises
    ------
    NotCoveredError
        If the system is another one; the sentence names the part.
    springpot.theory.NoConvergenceError
        If the iteration of the memory's force does not settle.
    TypeError
        If it is not a System.

    Notes
    -----
    The noise, x and v are together a Markov process if there is no memory.  Its stationary law is that of a chain of
    short steps [1]_, without any further approximation: slow noise that presses the mass on a wall, and a mass that
    comes to rest there, need nothing special.

    With springpots the law of the noise, x and v still obeys the same equation, exactly, with the mean force of the
    springpots at given noise, x and v.  That function is not known; it is taken to be the polynomial of second degree
    that differs least from the force in mean square.  Its coefficients need averages of the force times products of the
    noise, x and v.  These are integrals over the springpot's kernel of correlations with v, which the chain itself
    gives; chain and coefficients are found together.

    References
    ----------
    .. [1] H. T. Sykora, R. Kuske and D. Yurchenko, "Stochastic dynamics of mechanical systems with impacts via the
       step matrix multiplication based path integration method", Nonlinear Dynamics (2024).

    Examples
    --------
    >>> import springpot as sp
    >>> noise = sp.ColoredNoise(1.0, 2.0)
    >>> held = sp.System(sp.Spring(1.0), sp.Dashpot(1.0), noise, sp.Barrier(0.0, 0.8))
    >>> round(path_integration(held).x_mean_square, 1)  # the envelope has a third of it
    0.4
    """
    system = checked_system(system)
    unit, problem = system.per_unit_mass, check_covered(system)
    stationary: Moments | str
    if not unit.potential.holds():
        stationary = unheld(unit.elements.values(), "no spring or wall holds the mass on one side")
    elif not any(part.dissipates for part in unit.parts):
        stationary = "There is no stationary state: nothing dissipates energy, so it grows without end."
    else:
        stationary = _moments(system, problem, _solve(problem))
    warnings: tuple[str, ...] = ()
    if not isinstance(stationary, str):
        warnings = tuple(_warnings(unit, stationary))
    law = "The law of the noise, x and v is that of a chain on a grid, which has an error of some 0.5 %."
    memory = "The mean force of the memory at given noise, x and v is a polynomial of second degree."
    return Result(
        method="path_integration",
        system=system,
        stationary=stationary,
        assumptions=(law, memory) if problem.springpots else (law,),
        warnings=warnings,
    )


def check_covered(system: System) -> _Problem:
    """What the method solves, where it is covered; otherwise `NotCoveredError`."""
    unit = system.per_unit_mass
    _COVERED.check(unit)
    noises: list[Any] = [noise for noise in unit.excitations.values() if noise.excites]
    if len(noises) != 1:
        raise NotCoveredError(f"{REACH}; here there {'are several' if noises else 'is no colored noise'}.")
    return _Problem(
        unit=unit,
        noise=noises[0],
        springpots=tuple(part for part in unit.parts if part.remembers),
        stops=tuple(unit.walls.values()),
        damping=unit.dashpots,
    )


def _grid(problem: _Problem, mean: float, deviation: float, speed: float, size: tuple[int, int, int]) -> Grid:
    potential = problem.unit.potential
    low, high = mean - _WIDE * deviation, mean + _WIDE * deviation
    walls = low <= potential.low, high >= potential.high
    low, high = max(low, potential.low), min(high, potential.high)
    deviation_of_noise = math.sqrt(problem.noise.variance)
    return grid_over(deviation_of_noise, low, high, (_WIDE - 0.5) * speed, walls, size)


def _step(problem: _Problem, mean: float, deviation: float, speed: float) -> float:
    """The length of a step: short beside the motion, the correlation of the noise, contacts and dampers.

    Raises
    ------
    NotCoveredError
        If it is too short beside the motion.
    """
    potential = problem.unit.potential

    def frequency(reach: float) -> float:
        places = np.linspace(max(mean - reach, potential.low), min(mean + reach, potential.high), 200)
        return max(math.sqrt(max(float(np.max(potential.curvature(places))), 0.0)), 1e-150)

    stiffest = frequency(4.0 * deviation)
    limits = {
        "the noise is so fast beside the motion that it is white, so WhiteNoise of its density takes its place":
            _SHORTEST * problem.noise.correlation_time,
        "a spring or contact is too stiff": _STIFF / stiffest,
        "the damping is too strong": _STIFF / problem.damping if problem.damping > 0.0 else math.inf,
    }  # fmt: skip
    reason, shortest = min(limits.items(), key=lambda item: item[1])
    if shortest < _LEAST * deviation / speed:
        raise NotCoveredError(f"{REACH}; here {reason}.")
    return min(_STEP * deviation / speed, _SOFT / frequency(1.5 * deviation), shortest)


def _law(problem: _Problem, grid: Grid, step: float, memory: _Memory | None, start: Floats | None) -> _Law:
    unit = problem.unit

    def acceleration(y: Floats, x: Floats, v: Floats) -> Floats:
        # beyond the grid the polynomial may feed the motion
        x, v = np.clip(x, grid.x[0], grid.x[-1]), np.clip(v, grid.v[0], grid.v[-1])
        found = y - unit.potential.force(x) - problem.damping * v
        for part in unit.parts:
            for c, power in zip(part.damping_coefficients()[1:], (np.abs(v) * v, v**3), strict=False):
                found = found - c * power
        for part in unit.parts:
            found = found - part.force_beside(x, v)
        return np.asarray(found if memory is None else found - memory.force(y, x, v))

    tau = problem.noise.correlation_time
    chain = make_chain(grid, step, tau, acceleration, problem.stops)
    crossing = float(grid.x[-1] - grid.x[0]) / float(grid.v[-1])  # about twice the time over a deviation
    together = min(math.ceil(max(_TOGETHER[0] * crossing, _TOGETHER[1] * tau) / step), _MOST)
    return _Law.of(chain, chain.stationary(start, together, math.inf if memory is None else _GROWTH))


def _solve(problem: _Problem) -> _Law:
    """The law, first on a rough grid that is fitted to it."""
    law, memory = _fitted(problem)
    if memory is not None:
        law, memory = _with_memory(problem, law, memory, _ROUNDS)
    scales = law.mean, law.deviation, law.speed
    grid = _grid(problem, *scales, _FINE)
    fine = _law(problem, grid, _step(problem, *scales), memory, None)
    if memory is not None:
        fine, _ = _with_memory(problem, fine, memory, _FINE_ROUNDS)
    return fine


def _fitted(problem: _Problem) -> tuple[_Law, _Memory | None]:
    """A rough law on a grid that fits it, with a first guess of the memory."""
    mean, deviation, speed = _guess(problem)
    refused: list[NoConvergenceError] = []
    for _ in range(_STARTS):
        memory = _first_memory(problem, mean, deviation, speed)
        grid = _grid(problem, mean, deviation, speed, _ROUGH if problem.stops else _ROUGH_FREE)
        try:
            law = _law(problem, grid, _step(problem, mean, deviation, speed), memory, None)
        except NoConvergenceError as failed:  # the grid may be too narrow
            refused.append(failed)
            if len(refused) > _WIDENED:  # it was not that: the damping is too light, and more tries take long
                raise
            deviation, speed = _WIDER[0] * deviation, _WIDER[1] * speed
            continue
        changes = abs(law.mean - mean) / deviation, law.deviation / deviation, law.speed / speed
        mean, deviation, speed = law.mean, law.deviation, law.speed
        if changes[0] < 0.3 and all(1.0 / _FITS < each < _FITS for each in changes[1:]):
            return law, memory
    if refused:
        raise refused[-1]
    raise NoConvergenceError("path integration found no grid that fits the law of x and v.")


def _guess(problem: _Problem) -> tuple[float, float, float]:
    """Mean and deviation of x, and deviation of v: of springs that hold what the noise feeds."""
    potential, noise = problem.unit.potential, problem.noise
    low, high = _wells(potential)
    force, tau = math.sqrt(noise.variance), noise.correlation_time
    away = -1.0 if high == potential.high else 1.0  # from a wall on which the mass is pressed
    place, deviation = (low if away < 0.0 else high), max(high - low, 1e-3 * abs(high), 1e-6)
    for _ in range(400):  # the displacement at which springs balance twice the noise
        reach = abs(float(potential.force(place + away * deviation)) - float(potential.force(place)))
        if abs(math.log(max(reach, 1e-300) / (2.0 * force))) < 0.2:
            break
        deviation *= 0.8 if reach > 2.0 * force else 1.25
    room = potential.high - potential.low
    frequency = math.sqrt(2.0 * force / deviation)
    lost = problem.damping + sum(
        springpot.coefficient * frequency ** (springpot.order - 1.0) for springpot in problem.springpots
    )
    speed = math.sqrt(force**2 * tau / (max(lost, 0.02 * frequency) * (1.0 + (frequency * tau) ** 2)))
    wide = min(max(0.5 * (high - low) + deviation, speed / frequency), 0.3 * room)
    walled = place in (potential.low, potential.high)
    mean = min(max(0.5 * (low + high) + (away * wide if walled else 0.0), potential.low), potential.high)
    return mean, wide, max(speed, 0.1 * wide * frequency)


def _wells(potential: Potential) -> tuple[float, float]:
    """The outermost places where the mass can rest."""
    roots = roots_of(potential.coefficients) if len(potential.coefficients) > 1 else np.zeros(0)
    marks = [float(root.real) for root in roots if abs(root.imag) < 1e-9 * (1.0 + abs(root))]
    rests = [place for place in marks if potential.low <= place <= potential.high and potential.curvature(place) > 0.0]
    if math.isfinite(potential.low) and float(potential.force(potential.low)) >= 0.0:
        rests.append(potential.low)
    if math.isfinite(potential.high) and float(potential.force(potential.high)) <= 0.0:
        rests.append(potential.high)
    if not rests:
        rests = [place for place in (potential.low, potential.high) if math.isfinite(place)] or [0.0]
    return min(rests), max(rests)


def _first_memory(problem: _Problem, mean: float, deviation: float, speed: float) -> _Memory | None:
    """The memory of a motion of one frequency."""
    if not problem.springpots:
        return None
    w = speed / deviation
    coefficients = np.zeros(10)
    for springpot in problem.springpots:
        modulus = springpot.modulus(1j * w)
        coefficients[1] += modulus.real * deviation
        coefficients[2] += modulus.imag / w * speed
    return _Memory(mean, deviation, speed, math.sqrt(problem.noise.variance), coefficients)


def _with_memory(problem: _Problem, law: _Law, memory: _Memory, rounds: int) -> tuple[_Law, _Memory]:
    """The law and the memory's mean force, found together on the grid of a first law."""
    grid, step = law.chain.grid, law.chain.step
    mix = Anderson(3, 1e-8)
    moments = _scaled(law)
    for number in range(rounds):
        wanted = _refitted(problem, law, memory)
        mixed = mix.part_of_step(memory.coefficients, wanted.coefficients, 1.0)
        memory = replace(memory, coefficients=mixed)
        law = _law(problem, grid, step, memory, law.weights)
        before, moments = moments, _scaled(law)
        if np.all(np.abs(moments - before) < _SETTLED) and number > 0:
            return law, memory
    if rounds == _FINE_ROUNDS:
        return law, memory
    raise NoConvergenceError("path integration did not find the force of the memory: its iteration did not settle.")


def _scaled(law: _Law) -> Floats:
    return np.array([law.mean / law.deviation, 2.0 * math.log(law.deviation), 2.0 * math.log(law.speed)])


def _refitted(problem: _Problem, law: _Law, memory: _Memory) -> _Memory:
    """The polynomial nearest to the memory's force in mean square, in the motion of a law."""
    chain, weights = law.chain, law.weights
    y, x, v = chain.grid.places
    terms = memory.terms(y, x, v)
    longest = math.ceil(_LONGEST * law.deviation / law.speed / chain.step)
    correlation = chain.correlation(weights * v, terms, longest)
    averages = np.zeros(terms.shape[0])
    for springpot in problem.springpots:
        averages += (
            springpot.coefficient * kernel_weights(springpot.order, chain.step, len(correlation) - 1) @ correlation
        )
    averages[0] = 0.0  # the mean force of a memory that sees changes only
    try:
        found = np.linalg.solve((terms * weights) @ terms.T, averages)
    except np.linalg.LinAlgError as failed:
        raise NoConvergenceError(
            "path integration did not find the force of the memory: its terms are not apart."
        ) from failed
    return replace(memory, coefficients=np.asarray(found, float))


def _moments(system: System, problem: _Problem, law: _Law) -> Moments:
    _, x, v = law.chain.grid.places
    x_square, v_square = float(law.weights @ x**2), float(law.weights @ v**2)
    hits = []
    struck = iter(law.chain.impacts(law.weights))
    for name in system.stops:
        rate = mean = square = math.nan
        if name in system.walls:
            rate, first, second = next(struck)
            rate = math.nan if system.walls[name].dissipates else max(rate, 0.0)
            mean, square = (first / rate, second / rate) if rate > 1e-12 else (math.nan, math.nan)
        hits.append((rate, mean, square))
    return moments_of(system, [(law.mean, x_square, v_square)], hits=hits)


def _warnings(unit: System, found: Moments) -> Iterator[str]:
    yield from endless_walls(unit, lambda wall: not wall.is_elastic)
    for name, wall in unit.stops.items():
        if name in unit.contacts:
            yield f"The impacts on {name} are not counted."
        elif not wall.dissipates and math.isnan(found[f"{name}_impact_rate"]):
            yield f"On {name} the mass is pressed, and hops are too short for the grid: there is no impact rate."
