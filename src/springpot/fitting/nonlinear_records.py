"""Records of a mass that strikes walls or has a nonlinear spring, under noise that was not measured."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.impact_filter import Flow, filtered
from springpot.fitting.likelihood import USUAL, Coordinates, How, inverse
from springpot.fitting.motion_data import MeasuredRecord
from springpot.fitting.records import OfRecord, with_noise
from springpot.fitting.spectra import NOISE
from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.parts import (
    Barrier,
    Contact,
    Dashpot,
    Mass,
    PolynomialSpring,
    Spring,
    Springpot,
    WhiteNoise,
)
from springpot.problem.system import System, check_single

_REACH = (
    "A fit of a record whose input was not measured covers linear systems, and one mass with springs, dashpots, "
    "springpots, walls and contacts under white noise"
)
_KINDS = Mass | Spring | PolynomialSpring | Dashpot | Springpot | Barrier | Contact | WhiteNoise
_SPACING = 0.5 * math.log(10.0)  # of the rates of memory, in the logarithm: the ripple of the kernel is 1e-3
_SLOWEST, _FASTEST = 1.0 / 3.0, 1.5  # rates, over 1 / duration and 1 / step
_NEVER = 1e-3  # of the slowest rate: that of what memory does not forget in the record
_FINER = 4  # rates for an acceleration, which has the memory's forces in it
_FLOW_STEP, _KICK_STEP = 2.0, 0.25  # of the flow's series, over 1 / the largest rate; of a kick, over sqrt(1 / slope)
_FASTER = 1.5  # than the start are the numbers for which substeps are small enough
_NODES, _SHARES = np.polynomial.hermite_e.hermegauss(16)
_SHARES = _SHARES / _SHARES.sum()
_POSITIONS = 60  # of a wall, from the best of which a search starts where x was not measured
_STEPS, _GAIN = 40, 1e-3  # of a search at most, and the log-likelihood to be gained where it ends
_GAIN_OF_PROFILE = 0.02  # the same, on a profile
_AT_WALLS = 2  # substeps at least, where a wall is struck
_LONGEST = 0.7  # step of a logarithm
_SLOPE = 1e-3  # step of differences: of a logarithm, or of a number over its size
_DAMPED, _MOST_DAMPED = 1e-3, 1e8
_WIDE = 4.0  # variances, for what is not known at a start
_OWN_NOISE = 1e-4  # of the spread of the samples: what the laws of the filter are off by
_BLURRED, _FEW_IMPACTS = 0.3, 3.0  # restitution below which, and number below which, there is a warning
_NONE = 0.01  # impacts
_TURNS = 40  # of the equivalent stiffness
_THREADS = 2


class NonlinearRecordLikelihood(OfRecord):
    """Samples of one mass with walls, contacts or nonlinear springs under white noise.

    Parameters
    ----------
    system : System
        With free numbers.
    data : MeasuredRecord
    how : How
    """

    not_gaussian = "the motion has another law: a wall or nonlinear part that the model lacks"
    _settled = False  # whether the substeps are chosen for good

    def __init__(self, system: System, data: MeasuredRecord, how: How = USUAL) -> None:
        _check(system, data)
        super().__init__(system, data, how)
        self._values = np.ascontiguousarray(data.values)
        self._seen = "xva".index(str(data.of))
        self._least_noise = _OWN_NOISE * float(self._values.std())
        free = with_noise(self.coordinates.free, data, self._least_noise)
        duration = data.step * (data.time.size - 1)
        fastest = _FASTEST * (_FINER if data.of == "a" else 1) / data.step
        count = math.ceil(math.log(fastest * duration / _SLOWEST) / _SPACING) + 1
        self._rates = _SLOWEST / duration * np.exp(_SPACING * np.arange(count))
        if data.of == "x":
            free = _from_lowest(system, free, data.values)
        self.coordinates = Coordinates(free)
        walls = [stop.position.name for stop in system.stops.values() if isinstance(stop.position, Free)]
        self._places = np.isin(self.coordinates.names, walls)
        self._prepare(self.coordinates.outer(self.coordinates.start))
        if data.of != "x":
            self.coordinates = self._with_best_positions()

    def flow(self, theta: Floats) -> tuple[Flow, float]:
        """The motion of the mass, and the standard deviation of the measurement noise."""
        system, noise = self.model_at(theta)
        return flow_of(system, self._rates), max(noise, self._least_noise)

    def _with_best_positions(self) -> Coordinates:
        """Free positions of walls start where the other numbers, as they are, agree best with the samples."""
        free, theta = self.coordinates.free, self.coordinates.given
        for name in (wall.position.name for wall in self.system.walls.values() if isinstance(wall.position, Free)):
            place = self.coordinates.names.index(name)
            found = []
            for at in np.linspace(free[place].low, free[place].high, _POSITIONS):
                theta[place] = at
                found.append((-self.deviance(theta), float(at)))
            theta[place] = max(found)[1]
        return self.coordinates.moved(theta)

    def _prepare(self, theta: Floats) -> None:
        """Choose the substeps, and what is known before the first sample, for numbers like these."""
        flow, _ = self.flow(theta)
        step, values = self.data.step, self._values
        self._more = equivalent_stiffness(flow, float(values.std()))
        start = stationary(flow, self._more)
        place = float(np.abs(values).max()) if self._seen == 0 else 4.0 * math.sqrt(start[0, 0])
        stiffest = max(slope_of(flow, place), slope_of(flow, -place), 0.0)
        kicks = math.ceil(_FASTER * step * math.sqrt(stiffest) / _KICK_STEP)
        self._substeps = max(kicks, _AT_WALLS if flow.walls.size else 1)
        rate = max(math.sqrt(max(flow.stiffness, 0.0)), flow.damping, *flow.rates / _FASTER)
        self._halvings = max(math.ceil(math.log2(_FASTER * step * rate / (_FLOW_STEP * self._substeps))), 0)
        self._spread = _WIDE * float(values.var()) if self._seen == 0 else 0.0
        self._past = _WIDE * (float(np.mean(values**2)) if self._seen == 0 else start[0, 0])
        self._size = float(values.std()) if self._seen == 0 else math.sqrt(start[0, 0])  # of x
        self.least = None  # of other substeps

    def _run(self, theta: Floats) -> tuple[Floats, Floats, Floats, float]:
        """Of each sample: its log-likelihood, what was expected and how surely; and the number of impacts.

        A place where the model has no stationary state without its walls has no likelihood.
        """
        terms, expected, spread = (np.zeros(self._values.shape) for _ in range(3))
        try:
            flow, noise = self.flow(theta)
            start = self._start(flow)
        except ValueError:
            terms[:] = -np.inf
            return terms, expected, spread + 1.0, 0.0
        impacts = filtered(
            self._values, self.data.step, self._substeps, self._halvings, self._seen, noise**2, start, flow,
            terms, expected, spread,
        )  # fmt: skip
        return terms, expected, spread, float(impacts)

    def _start(self, flow: Flow) -> Floats:
        """Covariance at the first sample: the stationary one, wider by what walls and the past add.

        Walls take energy, so it is not much wider than the samples say.
        """
        start = stationary(flow, self._more)
        if flow.walls.size:
            row = np.eye(len(start))[self._seen] if self._seen < 2 else flow.drift()[1]
            start *= min(1.0, _WIDE * float(np.mean(self._values**2)) / float(row @ start @ row))
        start[0, 0] += self._spread
        start[range(2, len(start)), range(2, len(start))] += self._past
        return start

    def misfit(self, theta: Floats) -> float:
        """-2 ln L of the samples."""
        found = -2.0 * float(self._run(theta)[0].sum())
        return found if math.isfinite(found) else math.inf

    def solve(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """By Levenberg's steps with the information of the scores, twice: the second time with its own substeps.

        Where x was not measured the noise of the sensor is held at first: a small one makes the likelihood rough far
        from its maximum.
        """
        u = np.clip(begin, self.coordinates.low, self.coordinates.high)
        if moves.any():
            held = moves & (np.array(self.coordinates.names) != NOISE)
            first = [moves, moves] if self._seen == 0 else [held, moves, moves]
            for these in [moves] if self._settled else first:
                if not self._settled:
                    self._prepare(self.coordinates.outer(u))
                u = self._climbed(u, these)
            self._settled = True
        return u

    def _climbed(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        own, damped = self.coordinates, _DAMPED
        low, high = own.low, own.high
        reach = np.where(own.logarithmic, _LONGEST, 0.3 * (high - low))
        here = -0.5 * self.deviance(own.outer(u))
        if not math.isfinite(here):
            return u
        for _ in range(_STEPS):
            scores = self._scores(u)
            slope = scores.sum(axis=0)
            going = moves & ~((u <= low) & (slope < 0.0)) & ~((u >= high) & (slope > 0.0))
            if not going.any():
                return u
            _, innovations = self.expected_and_innovations(own.outer(u))
            # far from the maximum a few samples would make steps small
            scores /= np.maximum(np.abs(innovations), 1.0).reshape(-1, 1)
            information = scores.T @ scores
            information[np.diag_indices_from(information)] += 1e-12
            while damped < _MOST_DAMPED:
                most = np.where(going, np.minimum(reach, high - u), 0.0)
                least = np.where(going, np.maximum(-reach, low - u), 0.0)
                there = u + _boxed(information + damped * np.diag(np.diag(information)), slope, least, most)
                value = -0.5 * self.deviance(own.outer(there))
                if value > here:
                    break
                damped *= 8.0
            else:
                return u
            gain, u, here = value - here, there, value
            if gain < (_GAIN_OF_PROFILE if self.ended else _GAIN) and damped < 1.0:
                return u
            damped = max(damped / 10.0, 1e-6)
        return u

    def _scores(self, u: Floats) -> Floats:
        """Derivatives of the log-likelihood of each sample by the coordinates."""
        own = self.coordinates
        sizes = np.maximum(np.abs(u), 0.01 * (own.high - own.low))
        sizes = _SLOPE * np.where(own.logarithmic, 1.0, np.where(self._places, np.minimum(sizes, self._size), sizes))
        ends = np.array([
            np.clip(u + sign * size * unit, own.low, own.high)
            for unit, size in zip(np.eye(u.size), sizes, strict=True) for sign in (1.0, -1.0)
        ])  # fmt: skip
        self.ask()
        with ThreadPoolExecutor(_THREADS) as pool:
            found = [*pool.map(lambda each: self._run(own.outer(each))[0].ravel(), ends)]
        if missing := [n for n, each in enumerate(found) if not np.isfinite(each).all()]:  # differences on one side
            here = self._run(own.outer(u))[0].ravel()
            for n in missing:
                found[n], ends[n] = here, u
        steps = np.diag(ends[0::2] - ends[1::2])
        with np.errstate(invalid="ignore"):
            apart = np.array(found[0::2]) - np.array(found[1::2])
        scores = np.where(steps != 0.0, apart.T / np.where(steps != 0.0, steps, 1.0), 0.0)
        return np.where(np.isfinite(scores), scores, 0.0)

    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """The inverse of the sum of the products of the scores."""
        scores = self._scores(self.coordinates.inner(theta))[:, moves]
        return inverse(scores.T @ scores)

    def without_influence(self, theta: Floats, moves: NDArray[np.bool_]) -> str:
        """Of numbers on which no sample depends."""
        moved = self._scores(self.coordinates.inner(theta)).any(axis=0)
        idle = np.array(self.coordinates.names)[moves & ~moved].tolist()
        why = ", in which no wall is struck," if self.system.walls and self._run(theta)[3] < _NONE else ""
        them = "it" if len(idle) == 1 else "them"
        return f"{listed(idle)} must not be free: the record{why} does not depend on {them}." if idle else ""

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """Of impacts that are too few, and of those that follow each other too fast."""
        said, (flow, _) = [*super().doubts(theta)], self.flow(theta)
        walls = [*self.system.walls.values()]
        found = [any(isinstance(each, Free) for each in (wall.position, wall.restitution)) for wall in walls]
        if any(found) and (impacts := self._run(theta)[3]) < _FEW_IMPACTS:
            said.append(
                f"The record has about {impacts:.1f} impacts: it hardly tells where a wall is, or its restitution."
            )
        if flow.walls.size and flow.walls[:, 2].min() < _BLURRED:
            if isinstance(walls[int(flow.walls[:, 2].argmin())].restitution, Free):
                what = "finds it too low by up to a half of it, with errors that are too small"
            else:
                what = "is inexact"
            said.append(
                f"The restitution is {flow.walls[:, 2].min():.2g}. Below {_BLURRED} many impacts follow each other "
                f"within a sample, and this fit {what}."
            )
        return tuple(said)

    def expected_and_innovations(self, theta: Floats) -> tuple[Floats, Floats]:
        """By the filter."""
        _, expected, spread, _ = self._run(theta)
        return expected, (self._values - expected) / spread


def _boxed(matrix: Floats, slope: Floats, low: Floats, high: Floats) -> Floats:
    """The step to the maximum of slope' w - w' matrix w / 2 with w in a box: what would leave it stays at its end.

    So a number that the data hardly know, whose own step would be huge, does not make the others' steps small.
    """
    found, free = np.zeros(slope.size), high > low
    while free.any():
        rest = slope[free] - matrix[np.ix_(free, ~free)] @ found[~free]
        found[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        out = free & ((found < low) | (found > high))
        if not out.any():
            break
        found = np.clip(found, low, high)
        free &= ~out
    return found


def flow_of(system: System, rates: Floats) -> Flow:
    """The motion of one mass, with memory of these rates.

    Parameters
    ----------
    system : System
    rates : ndarray
        Of the memory, at equal steps of their logarithm.

    Returns
    -------
    Flow

    Notes
    -----
    t^-a / Gamma(1 - a) is sin(pi a) / pi times the integral of s^(a-1) exp(-s t) over the rates s.  In its logarithm
    the trapezoidal rule has the weights sin(pi a) / pi s_j^a D.  Half a spacing beyond the rates the faster ones act as
    a dashpot, sin(pi a) / pi s^(a-1) / (1-a), the slower ones as one that forgets nothing, sin(pi a) / pi s^a / a:
    where x has a mean, its force depends on what was before the record.

    Examples
    --------
    >>> found = flow_of(System(Spring(4.0), Springpot(0.5, 1.0), WhiteNoise(1.0)), np.array([0.1, 1.0, 10.0]))
    >>> round(found.stiffness, 4), found.weights.round(4).tolist()
    (4.0, [0.1132, 0.2318, 0.7329, 2.3177])
    """
    unit, potential = system.per_unit_mass, system.potential
    stiffness = potential.coefficients[1] if len(potential.coefficients) > 1 else 0.0
    damping = unit.damping
    weights, memory = np.zeros(rates.size + 1), np.append(_NEVER * rates[0], rates)
    springpots = unit.springpots.values()
    spacing = math.log(rates[1] / rates[0])
    slow, fast = rates[0] * math.exp(-0.5 * spacing), rates[-1] * math.exp(0.5 * spacing)
    for springpot in springpots:
        a, c = float(springpot.order), float(springpot.coefficient)
        weights[1:] += c * math.sin(math.pi * a) / math.pi * rates**a * spacing
        weights[0] += c * float(np.sinc(a)) * slow**a
        damping += c * float(np.sinc(1.0 - a)) * fast ** (a - 1.0)
    if not springpots:
        weights, memory = rates[:0], rates[:0]
    walls = [(wall.position, wall.inwards, wall.restitution) for wall in unit.walls.values()]
    contacts = [(c.position, c.inwards, c.stiffness, c.exponent, c.dissipation) for c in unit.contacts.values()]
    return Flow(
        float(stiffness), float(damping), float(sum(noise.white_intensity for noise in unit.excitations.values())),
        weights, memory, np.array(walls, float).reshape(-1, 3), np.array(potential.coefficients[2:], float),
        np.array(contacts, float).reshape(-1, 5),
    )  # fmt: skip


def force_at(flow: Flow, x: Floats) -> Floats:
    """The nonlinear force that pulls back, without what dissipates."""
    found = sum((k * x**n for n, k in enumerate(flow.powers, start=2)), np.zeros_like(x))
    for position, side, stiffness, exponent, _ in flow.contacts:
        found = found - side * stiffness * np.maximum(side * (position - x), 0.0) ** exponent
    return np.asarray(found)


def slope_of(flow: Flow, x: float) -> float:
    """Of that force."""
    step = 1e-4 * abs(x)
    low, high = force_at(flow, np.array([x - step, x + step]))
    return float(high - low) / (2.0 * step)


def stationary(flow: Flow, more: float = 0.0) -> Floats:
    """Covariance of the state without walls, with this stiffness in place of the nonlinear forces.

    Raises
    ------
    ValueError
        If nothing holds the mass or takes its energy.
    """
    from scipy import linalg

    drift, random = flow.drift(), np.zeros((2 + flow.weights.size,) * 2)
    random[1, 1] = flow.intensity
    drift[1, 0] -= more
    found = np.array(linalg.solve_continuous_lyapunov(drift, -random)).astype(np.float64)
    if not (drift[1, 0] < flow.weights.sum() and found[0, 0] > 0.0 and found[1, 1] > 0.0):
        raise ValueError(
            "model must have a spring that holds the mass without its walls, a damper and noise for a fit of a record."
        )
    return np.asarray(0.5 * (found + found.T))


def equivalent_stiffness(flow: Flow, spread: float) -> float:
    """Of the spring that deviates least from the nonlinear forces in the stationary motion; 0 where there are none.

    Parameters
    ----------
    flow : Flow
    spread : float
        A first guess of the standard deviation of x.
    """
    if not flow.powers.size and not flow.contacts.size:
        return 0.0
    for _ in range(_TURNS):
        more = float(np.sum(_SHARES * _NODES * force_at(flow, spread * _NODES))) / spread
        if flow.stiffness + more > 0.0:
            spread = math.sqrt(spread) * float(stationary(flow, more)[0, 0]) ** 0.25
        else:
            spread *= 2.0
    return more


def _from_lowest(system: System, free: tuple[Free, ...], values: Floats) -> tuple[Free, ...]:
    """Free positions of walls start beside the samples that are farthest out."""
    found = {number.name: number for number in free}
    for wall in system.walls.values():
        if isinstance(wall.position, Free):
            own = wall.position.itself
            place = float(values.min() if wall.free_side == "above" else values.max())
            ends = [float(wall.position.at(each)) for each in (own.low, own.high)]
            if (ends[0] - place) * (ends[1] - place) < 0.0:
                from scipy import optimize

                at = optimize.brentq(
                    lambda each, at=wall.position, to=place: float(at.at(each)) - to, own.low, own.high
                )
                found[own.name] = own.moved_to(float(at))
    return (*found.values(),)


def _check(system: System, data: MeasuredRecord) -> None:
    """What the filter covers; all else is an error before any work."""
    check_single(system)
    for name, part in system.named():
        if not isinstance(part, _KINDS) or getattr(part, "envelope", None) is not None:
            raise NotCoveredError(f"{_REACH}, not {name}.")
        if name in system.walls and callable(system.walls[name].restitution):
            raise NotCoveredError(f"{_REACH}, not the law of restitution of {name}.")
        if data.of == "a" and part.noise == "white" and not part.of_ground:
            raise NotCoveredError(
                f"the acceleration under {name} on the mass has no finite variance, so it has no samples."
            )
    if any(row[0] != 1.0 for row in system.coordinates.elongations.values()):
        raise NotCoveredError(f"{_REACH}, each between the ground and the mass in this order.")
    if not any(noise.is_white for noise in system.excitations.values()):
        raise NotCoveredError("a system without noise does not move: add a WhiteNoise.")
