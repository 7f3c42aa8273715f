"""The chain of half cycles: how often and how fast a mass between two stops strikes each of them.

Speeds are in units of the standard deviation of v without the stops, and lengths and times such that the frequency of
that motion is 1.  Between two passages of the equilibrium 0 the mass flies out to a turning point, or to a stop and
back.  The state is the speed there; its law after each of the four flights of a cycle (out and back above, out and back
below) comes from the one before, and the stationary law is the one that a cycle leaves as it is.

On a flight of time t and action J = int v^2 dt / V^2 (V the speed at 0 with the same energy), damping c takes the mean
of the speed to V e^(-cJ).  White noise adds a normal number of variance 1 - e^(-2cJ) along the motion, and one of
variance 1 - e^(-2c(t-J)) across it: the new speed is the length of the sum.

A springpot takes more or less in a flight than c says, because it remembers the flights before it, an impact among
them.  `_extra_work` finds that: the mean path of the eight flights before, given the speed now, is made of arcs whose
amplitudes are conditional means of the chain itself, and the force of the memory on that path is integrated over the
flight.  What the same sum gives for the chain without stops is in c already.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from springpot.machine.arrays import Floats
from springpot.problem.parts import Springpot

FASTEST = 7.0  # the grid of speeds ends here
_CELLS, _LEAST_CELLS = 160, 4  # of the grid, and between two marks of it
MOST_CELLS = 420
_RESOLVED = 4.5  # cells over which the noise of a cycle reaches
_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(24)  # along a flight
_ANGLES, _SHARES = (0.25 * math.pi * each for each in np.polynomial.legendre.leggauss(12))
_ANGLES, _SHARES = _ANGLES + 0.25 * math.pi, _SHARES / math.sqrt(2.0 * math.pi)
_PASSES = 2  # of the chain and the work of the memory, which settle together
_PROBES = 26  # speeds at which that work is found; between them it is a straight line
_BEFORE, _POINTS = 8, 24  # flights that are remembered, and intervals in each
_LIKELY = 1e-9  # states less likely than this part of the likeliest are not asked for their past


@dataclass(frozen=True)
class Stop:
    """One stop: its distance from the equilibrium, and the speed after an impact with a speed."""

    distance: float
    rebound: Callable[[Floats], Floats] = field(default=np.copy)

    def after(self, size: Floats, needed: float) -> Floats:
        """The size of the motion (speed at 0, or amplitude) after the stop, which needs this square of it."""
        hits, found = size**2 > needed, size.copy()
        found[hits] = np.sqrt(needed + self.rebound(np.sqrt(size[hits] ** 2 - needed)) ** 2)
        return found


@dataclass(frozen=True)
class Flights:
    """Flights from 0 to the turning point or to a stop, one for each speed at 0.

    Parameters
    ----------
    time, action : ndarray
        Its length, and int v^2 dt.
    first, second : ndarray
        int x dt and int x^2 dt, with x counted outwards.
    """

    time: Floats
    action: Floats
    first: Floats
    second: Floats


@dataclass(frozen=True)
class HardSpring:
    """The force linear x + cubic x^3."""

    linear: float = 1.0
    cubic: float = 0.0

    def energy(self, x: Floats | float) -> Floats:
        square = np.square(x)
        return np.asarray(0.5 * square * (self.linear + 0.5 * self.cubic * square))

    def speed_to(self, x: float) -> float:
        """The speed at 0 with which x is just reached."""
        return math.sqrt(2.0 * float(self.energy(x)))

    def turning(self, speed: Floats) -> Floats:
        """Where a mass with this speed at 0 turns back."""
        stiffness = self.linear + np.sqrt(self.linear**2 + 2.0 * self.cubic * speed**2)
        return np.asarray(speed * np.sqrt(2.0 / stiffness))

    def flights(self, speed: Floats, end: float) -> Flights:
        """With x = X sin(phase), dx/dt = X cos(phase) slope(x), so that nothing is singular at the turning point."""
        top = self.turning(speed)[:, None]
        reach = np.arcsin(np.minimum(1.0, end / top))
        phase, weight = 0.5 * reach * (_PLACES + 1.0), 0.5 * reach * _WEIGHTS
        x = top * np.sin(phase)
        slope = np.sqrt(self.linear + 0.5 * self.cubic * (top**2 + x**2))
        spent = weight / slope
        return Flights(
            time=spent.sum(1),
            action=(weight * (top * np.cos(phase)) ** 2 * slope).sum(1),
            first=(spent * x).sum(1),
            second=(spent * x * x).sum(1),
        )


@dataclass(frozen=True)
class Problem:
    """What is solved.

    Parameters
    ----------
    spring : HardSpring
        With the in-phase stiffness of the springpots at the frequency 1.
    damping : float
        c, with which white noise of intensity 2 c gives <v^2> = 1 without stops.
    memory : tuple of Springpot
        Those that remember.
    upper, lower : Stop
    """

    spring: HardSpring
    damping: float
    memory: tuple[Springpot, ...]
    upper: Stop
    lower: Stop

    @property
    def cells(self) -> int:
        """Of speed: enough for the noise of a cycle, as a standard deviation, to reach over some of them."""
        flights = [self.spring.flights(np.ones(1), stop.distance) for stop in (self.upper, self.lower)]
        noise = math.sqrt(-math.expm1(-4.0 * self.damping * sum(float(flight.time[0]) for flight in flights)))
        return max(_CELLS, math.ceil(min(_RESOLVED * FASTEST / max(noise, 1e-9), 1e9)))

    @property
    def edges(self) -> Floats:
        """Of the cells of speed; those that just reach a stop are among them."""
        reaching = (self.spring.speed_to(stop.distance) for stop in (self.upper, self.lower))
        marks = sorted({0.0, FASTEST, *(speed for speed in reaching if speed < FASTEST)})
        pieces = [
            np.linspace(a, b, max(_LEAST_CELLS, round(self.cells * (b - a) / FASTEST)), endpoint=False)
            for a, b in pairwise(marks)
        ]
        return np.append(np.concatenate(pieces), FASTEST)


@dataclass(frozen=True)
class Stage:
    """One of the four flights of a cycle, for each cell of speed.

    Parameters
    ----------
    stop : Stop
    side : float
        1 above the equilibrium, -1 below.
    back : bool
        Whether it comes from the stop, or the turning point.
    start : ndarray
        The speed at 0 that has the energy with which it starts.
    flights : Flights
    hits : ndarray of bool
        Whether the stop is reached.
    """

    stop: Stop
    side: float
    back: bool
    start: Floats
    flights: Flights
    hits: NDArray[np.bool_]


@dataclass(frozen=True)
class Chain:
    """The stationary chain.

    Parameters
    ----------
    edges : ndarray
        Of the cells of speed.
    stages : tuple of Stage
        Out and back above, out and back below.
    probabilities : tuple of ndarray
        Of the cells at the start of each.
    """

    problem: Problem
    edges: Floats
    stages: tuple[Stage, ...]
    probabilities: tuple[Floats, ...]
    matrices: tuple[Floats, ...] = field(repr=False)

    @property
    def speeds(self) -> Floats:
        return _middles(self.edges)

    @property
    def period(self) -> float:
        """The mean time of a cycle."""
        return self.total(lambda stage: stage.flights.time)

    def total(self, what: Callable[[Stage], Floats]) -> float:
        """Mean over cycles of a sum over its flights."""
        return float(sum(p @ what(stage) for p, stage in zip(self.probabilities, self.stages, strict=True)))


def chain_of(problem: Problem) -> Chain:
    """The stationary chain, found together with the work of the memory."""
    edges = problem.edges
    none = (np.zeros(edges.size - 1),) * 4
    chain = _chain(problem, edges, none)
    if not problem.memory:
        return chain
    free = Stop(math.inf)
    without = _extra_work(_chain(replace(problem, upper=free, lower=free), edges, none))
    for _ in range(_PASSES):
        extra = tuple(now - free for now, free in zip(_extra_work(chain), without, strict=True))
        chain = _chain(problem, edges, extra)
    return chain


def _middles(edges: Floats) -> Floats:
    return np.asarray(0.5 * (edges[1:] + edges[:-1]))


def _stages(problem: Problem, speeds: Floats) -> tuple[Stage, ...]:
    found = []
    for stop, side in ((problem.upper, 1.0), (problem.lower, -1.0)):
        needed = problem.spring.speed_to(stop.distance) ** 2 if math.isfinite(stop.distance) else math.inf
        for back, start in ((False, speeds), (True, stop.after(speeds, needed))):
            flights = problem.spring.flights(start, stop.distance)
            found.append(Stage(stop, side, back, start, flights, speeds**2 > needed))
    return tuple(found)


def _chain(problem: Problem, edges: Floats, extra: tuple[Floats, ...]) -> Chain:
    """The stationary chain with given extra work of the memory in each stage."""
    stages = _stages(problem, _middles(edges))
    matrices = tuple(_law(problem, edges, stage, work) for stage, work in zip(stages, extra, strict=True))
    whole = np.linalg.multi_dot(matrices)
    n = edges.size - 1
    equations = whole.T - np.eye(n)
    equations[0] = 1.0  # the sum of the probabilities in place of one equation
    first = np.linalg.solve(equations, np.eye(n)[0])
    probabilities = [np.maximum(first, 0.0)]
    for matrix in matrices[:-1]:
        probabilities.append(probabilities[-1] @ matrix)
    return Chain(problem, edges, stages, tuple(probabilities), matrices)


def _law(problem: Problem, edges: Floats, stage: Stage, extra: Floats) -> Floats:
    """Probability of each cell at the end of a stage, given that at its start."""
    c, flights = problem.damping, stage.flights
    action = flights.action / stage.start**2
    mean = np.sqrt(np.maximum(stage.start**2 - 2.0 * extra, 0.0)) * np.exp(-c * action)
    along = np.sqrt(-np.expm1(-2.0 * c * action))
    across = np.sqrt(-np.expm1(-2.0 * c * np.maximum(flights.time - action, 0.0)))
    mean, along, across = (each[:, None, None] for each in (mean, along, np.maximum(across, 1e-9)))
    # the part across the motion, y = Y sin(angle) up to the length or six standard deviations
    highest = np.minimum(edges[:, None], 6.0 * across)
    y = highest * np.sin(_ANGLES)
    left = np.sqrt(edges[:, None] ** 2 - y**2)
    share = highest * (2.0 * _SHARES * np.cos(_ANGLES)) * np.exp(-0.5 * (y / across) ** 2) / across
    below = np.einsum("ijk,ijk->ij", share, ndtr((left - mean) / along) - ndtr(-(left + mean) / along))
    below /= below[:, -1:]  # what is faster than the grid, and the error of the sum
    rows = np.maximum(np.diff(below, axis=1), 0.0)
    return np.asarray(rows / rows.sum(1, keepdims=True))


@dataclass(frozen=True)
class _Arc:
    """Part of a mean past path, x = side a(t) sin(phase), one for each probe; a^2 is a straight line in time."""

    side: float
    first: Floats
    last: Floats
    begin: Floats
    end: Floats


def _arc(stage: Stage, amplitude: Floats, following: Floats | None) -> _Arc:
    """A flight from a state to the next one; the last flight is undamped."""

    def reach(size: Floats) -> Floats:
        return np.arcsin(np.minimum(1.0, stage.stop.distance / size))

    if not stage.back:
        last = amplitude if following is None else following
        return _Arc(stage.side, amplitude, last, np.zeros_like(amplitude), reach(last))
    start = stage.stop.after(amplitude, stage.stop.distance**2)
    last = start if following is None else following
    return _Arc(stage.side, start, last, math.pi - reach(start), np.full_like(start, math.pi))


def _extra_work(chain: Chain) -> list[Floats]:
    """What the memory takes in each stage, per state, beyond a spring and a damper of the frequency 1."""
    speeds, stages = chain.speeds, chain.stages
    amplitude = chain.problem.spring.turning(speeds)
    mean = chain.total(lambda stage: stage.side * stage.flights.first) / chain.period
    found = []
    for now, likelihood in enumerate(chain.probabilities):
        likely = np.flatnonzero(likelihood > _LIKELY * likelihood.max())
        probes = np.unique(np.linspace(likely[0], likely[-1], _PROBES).astype(int))
        arcs, following = [_arc(stages[now], amplitude[probes], None)], amplitude[probes]
        onward = np.eye(speeds.size)[:, probes]  # probability of the probe, from each state before
        for back in range(1, _BEFORE + 1):
            i = (now - back) % 4
            onward = chain.matrices[i] @ onward
            p = chain.probabilities[i]
            before = np.sqrt((p * amplitude**2) @ onward / np.maximum(p @ onward, 1e-300))
            arcs.insert(0, _arc(stages[i], before, following))
            following = before
        found.append(np.interp(speeds, speeds[probes], _work(arcs, chain.problem.memory, mean)))
    return found


def _work(arcs: list[_Arc], memory: tuple[Springpot, ...], mean: float) -> Floats:
    """The work of the memory on the last arc, less that of a spring and a damper.

    Before the first arc the motion is taken to be harmonic, about the mean, with the mean square of the arcs.
    """
    t, x, v = _path(arcs)
    size = np.sqrt(np.mean([0.5 * (arc.first**2 + arc.last**2) for arc in arcs[:-1]], axis=0))
    start = np.arcsin(np.clip((x[:, 0] - mean) * arcs[0].side / size, -1.0, 1.0))
    start = start if arcs[0].begin[0] < 0.5 * math.pi else math.pi - start
    swing, phase = (arcs[0].side * size)[:, None], start[:, None] + t
    other = v - swing * np.cos(phase)  # of the speed, from the harmonic motion
    length = np.diff(t)
    slope = np.divide(np.diff(other), length, out=np.zeros_like(length), where=length > 0.0)
    last = slice(-_POINTS - 1, None)
    now, place, speed, ahead = t[:, last], x[:, last], v[:, last], phase[:, last]
    lag = np.maximum(now[:, :, None] - t[:, None, :], 0.0)
    counted = (length > 0.0)[:, None, :] & (t[:, None, 1:] <= now[:, :, None] + 1e-12)
    total = np.zeros(t.shape[0])
    for springpot in memory:
        order, c, quarter = springpot.order, springpot.coefficient, 0.5 * math.pi * springpot.order
        once = lag ** (1.0 - order) / (1.0 - order)  # integrals of the kernel, for a speed that is piecewise linear
        twice = once * lag / (2.0 - order)
        pieces = other[:, None, :-1] * once[..., :-1] - other[:, None, 1:] * once[..., 1:]
        pieces += slope[:, None, :] * (twice[..., :-1] - twice[..., 1:])
        force = c / math.gamma(1.0 - order) * np.where(counted, pieces, 0.0).sum(2)
        force += c * swing * np.sin(ahead + quarter) - c * math.cos(quarter) * place
        total += np.trapezoid((force - c * math.sin(quarter) * speed) * speed, now, axis=1)
    return total


def _path(arcs: list[_Arc]) -> tuple[Floats, Floats, Floats]:
    """Times, places and speeds, one row for each probe; where arcs meet there are two points at one time."""
    part = np.linspace(0.0, 1.0, _POINTS + 1)
    pieces, before = [], np.zeros((arcs[0].first.size, 1))
    for arc in arcs:
        length = (arc.end - arc.begin)[:, None]
        gained = (arc.last**2 - arc.first**2)[:, None]
        size = np.sqrt(arc.first[:, None] ** 2 + gained * part)
        phase = arc.begin[:, None] + length * part
        rate = gained / (2.0 * size * length)
        pieces.append((
            before + length * part,
            arc.side * size * np.sin(phase),
            arc.side * (rate * np.sin(phase) + size * np.cos(phase)),
        ))  # fmt: skip
        before = before + length
    t, x, v = (np.concatenate(each, axis=1) for each in zip(*pieces, strict=True))
    return t, x, v
