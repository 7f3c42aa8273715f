"""Repetitions of splitting in which devices differ: their devices are drawn from the laws, then where they matter."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.machine.arguments import Uncertain
from springpot.machine.arrays import Floats
from springpot.machine.progress import Clock, OutOfTimeError
from springpot.problem.system import System
from springpot.scattering.devices import Correlation, plans_like, scrambled, simulations_of, systems_of, values_at
from springpot.scattering.estimates import SCRAMBLINGS
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.together import alike
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan
from springpot.simulation.rare.event import Event, Quantity, constants_of, event_of
from springpot.simulation.rare.search import FREQUENT
from springpot.simulation.rare.splitting import Population, Tally, repetitions

DEVICES = 32  # of a repetition: more of them cost more than they tell
PILOT_PATHS, PATHS, MOST_PATHS = 512, 4096, 16384  # of a repetition
MOST_ROUNDS = 24  # of SCRAMBLINGS repetitions
_FIRST_ROUND = 2  # after plain paths, and those that tell where
_MOST_UNSEEN = 3  # rounds in which no path exceeded the last level, after which more are hopeless
FROM_THE_LAWS = 0.25  # share of the devices of the second stage that is drawn from the laws
_WIDER, _LEAST_WIDTH = 1.5, 0.05  # of the covariance of the scores of devices that exceeded a level
_FEWEST_SEEN = 2  # devices for each number from which their covariance is taken
_UNEVEN = 0.4  # spread of the repetitions over their mean above which each gets more paths


def normal_scores(inputs: int, seed: int, count: int, number: int = 0) -> Floats:
    """Normal scores at so many points of Sobol's sequence, scrambled by ``seed`` and ``number``."""
    from scipy.special import ndtri

    return np.asarray(ndtri(scrambled(inputs, count, np.random.default_rng([seed, 0x5CA9, number]))))


@dataclass(frozen=True, eq=False)
class Tilt:
    """Where devices of the second stage are drawn: one in four from the laws, the others from a normal law of scores.

    Attributes
    ----------
    mean : ndarray, shape (numbers,)
    root : ndarray, shape (numbers, numbers)
        Lower triangular: Cholesky's factor of the covariance.
    """

    mean: Floats
    root: Floats

    def drawn(self, scores: Floats) -> tuple[Floats, Floats]:
        """Scores, and the weights with which they count, from normal scores."""
        moved, kept = scores.copy(), round(FROM_THE_LAWS * len(scores))
        moved[:-kept] = self.mean + scores[:-kept] @ self.root.T
        away = np.linalg.solve(self.root, (moved - self.mean).T)
        ratio = np.exp(0.5 * ((moved**2).sum(axis=1) - (away**2).sum(axis=0))) / np.prod(np.diag(self.root))
        return moved, np.asarray(1.0 / (FROM_THE_LAWS + (1.0 - FROM_THE_LAWS) * ratio))


@dataclass(frozen=True, eq=False)
class Drawn:
    """Devices of SCRAMBLINGS repetitions.

    Attributes
    ----------
    scores, values : ndarray, shape (devices, numbers)
    population : Population
    """

    scores: Floats
    values: Floats
    population: Population


@dataclass(frozen=True, eq=False)
class Stage:
    """What repetitions found, each with devices of its own.

    Attributes
    ----------
    tally : Tally
    scores, values : ndarray, shape (devices, numbers)
    weights : ndarray, shape (devices,)
    paths : int
        Of a repetition.
    splits : bool
    """

    tally: Tally
    scores: Floats
    values: Floats
    weights: Floats
    paths: int
    splits: bool

    @property
    def found(self) -> Floats:
        """Probabilities, shape (repetitions, levels)."""
        return self.tally.exceeded[:, 1]

    @property
    def error(self) -> Floats:
        """Standard errors of their means."""
        return np.asarray(self.found.std(axis=0, ddof=1) / math.sqrt(len(self.found)))

    @property
    def of_repetitions(self) -> Floats:
        """What the devices of each add to it, shape (repetitions, devices of each, levels)."""
        return self.tally.of_devices.reshape(len(self.found), -1, self.found.shape[1])

    def with_more(self, other: Stage) -> Stage:
        """Both together."""

        def joined(a: object, b: object, *names: str) -> dict[str, Any]:
            return {name: np.concatenate([getattr(a, name), getattr(b, name)]) for name in names}

        rows = joined(self.tally, other.tally, "exceeded", "weights", "of_devices", "of_ancestors")
        tally = replace(self.tally, path_steps=self.tally.path_steps + other.tally.path_steps, **rows)
        return replace(self, tally=tally, **joined(self, other, "scores", "values", "weights"))

    def tilt(self) -> Tilt | None:
        """Towards the devices that exceeded the rarest level that enough of them did; None if too few exceeded any."""
        inputs = self.scores.shape[1]
        for own in self.tally.of_devices.T[::-1]:
            if np.count_nonzero(own) >= _FEWEST_SEEN * inputs + 2:
                shares = own / own.sum()
                mean = shares @ self.scores
                away = self.scores - mean
                covariance = _WIDER * (shares[:, None] * away).T @ away + _LEAST_WIDTH * np.eye(inputs)
                return Tilt(mean, np.linalg.cholesky(covariance))
        return None


@dataclass(frozen=True, eq=False)
class Lot:
    """Devices that can be drawn, with one plan for all.

    Attributes
    ----------
    system : System
    numbers : dict of Uncertain
        Of the system, and of levels.
    together : Correlation
    plan : Plan
        Of the nominal device; its window is the time that counts.
    nominal : Simulation
        The same, in whose window paths are split: it may begin sooner.
    """

    system: System
    numbers: dict[str, Uncertain]
    together: Correlation
    plan: Plan
    nominal: Simulation

    def devices(self, scores: Floats, tell: Callable[[float], None]) -> tuple[Floats, list[Simulation]]:
        """The values of their numbers, and they themselves."""
        from scipy.special import ndtr

        values = values_at(self.numbers, self.together, ndtr(scores))
        systems = systems_of(self.system, [*self.numbers], values)
        whole = self.nominal.plan
        found = simulations_of(plans_like(whole, [motion_of(each) for each in systems]), whole, tell)
        if not alike([each.parts.tables for each in found]):
            raise ValueError(
                "system must have devices that share blocks of paths, but they differ in a rate of their memory, in an "
                "exponent, or in which parts act."
            )
        return values, found


@dataclass(frozen=True, eq=False)
class EventOfDevices:
    """A quantity whose levels are asked of devices.

    Attributes
    ----------
    lot : Lot
    quantity : Quantity
    levels : ndarray
        In the order of rarity.
    sign : float
        As of `event_of`.
    marked : Uncertain or None
        Of which the levels are multiples, as one of them has it.
    stream : int
        The first one of random numbers.
    """

    lot: Lot
    quantity: Quantity
    levels: Floats
    sign: float
    marked: Uncertain | None
    stream: int

    def search(self, rtol: float, clock: Clock, tell: Callable[[float], None]) -> Stage:
        """Repetitions until the probability of the last level is known.

        Plain paths come first; where they exceed the last level too seldom, the same devices are split to see which
        of them do, and then others are drawn there.  The first devices only tell where: they do not count.

        Raises
        ------
        OutOfTimeError
            If the time is over before the plain paths have ended.
        """
        event = event_of(self.lot.plan, self.lot.nominal.parts, self.quantity, self.levels, self.sign)
        first = self._drawn(0, None, event, clock, lambda done: tell(0.15 * done))
        known = plain = self._run(event, first, PILOT_PATHS, False, 0, clock)
        splits, tilt, paths = bool(plain.found[:, -1].mean() < FREQUENT), None, PILOT_PATHS
        stage = None if splits else plain
        try:
            if splits:
                event = event.told_by(plain.tally.ends)
                known = self._run(event, first, PILOT_PATHS, True, 1, clock)
                tilt, paths = known.tilt(), PATHS
            for number in range(_FIRST_ROUND, _FIRST_ROUND + MOST_ROUNDS):
                if stage is not None:
                    p, error = float(stage.found[:, -1].mean()), float(stage.error[-1])
                    if error <= rtol * p if p > 0.0 else number >= _FIRST_ROUND + _MOST_UNSEEN:
                        break
                    tell(0.2 + 0.8 * (min(1.0, (rtol * p / error) ** 2) if p > 0.0 else number / MOST_ROUNDS))
                    if splits and not error * math.sqrt(len(stage.found)) <= _UNEVEN * p:
                        paths = min(4 * paths, MOST_PATHS)
                drawn = self._drawn(number, tilt, event, clock, lambda _: None)
                more = self._run(event, drawn, paths, splits, number, clock)
                stage = more if stage is None else stage.with_more(more)
        except OutOfTimeError:  # what only tells where is right on average too
            pass
        return stage or known

    def _drawn(
        self, number: int, tilt: Tilt | None, event: Event, clock: Clock, tell: Callable[[float], None]
    ) -> Drawn:  # fmt: skip
        def told(done: float) -> None:
            clock.check()
            tell(done)

        lot, scores, weights = self.lot, list[Floats](), list[Floats]()
        for n in range(SCRAMBLINGS):
            place = (self.stream + number) * SCRAMBLINGS + n + 1
            own = normal_scores(len(lot.numbers), lot.plan.settings.seed, DEVICES, place)
            of_devices = np.ones(DEVICES)
            if tilt is not None:
                own, of_devices = tilt.drawn(own)
            scores.append(own)
            weights.append(of_devices)
        whole = np.concatenate(scores)
        values, simulations = lot.devices(whole, told)
        factors = np.ones(len(values))
        if self.marked is not None:
            place = [*lot.numbers].index(self.marked.name)
            factors = np.array([self.marked.at(value) for value in values[:, place].tolist()]) / float(self.marked)
            if not factors.min() > 0.0:
                raise ValueError(f"levels of {self.quantity.name} must have one sign in all devices: give bounds.")
        devices = [(each.plan, each.parts) for each in simulations]
        constants = constants_of(
            (lot.plan, lot.nominal.parts), devices, self.quantity, event, self.sign, factors
        )  # fmt: skip
        return Drawn(whole, values, Population(simulations, constants, np.concatenate(weights)))

    def _run(self, event: Event, drawn: Drawn, paths: int, splits: bool, number: int, clock: Clock) -> Stage:
        tally = repetitions(
            self.lot.nominal, event, first=0, count=SCRAMBLINGS, paths=paths, stream=self.stream + number,
            splits=splits, clock=clock, tell=lambda _: None, population=drawn.population,
        )  # fmt: skip
        if not tally.complete:
            raise OutOfTimeError
        return Stage(tally, drawn.scores, drawn.values, drawn.population.weights, paths, splits)
