"""How many repetitions, of how many paths, with or without splitting: until the probabilities are known well enough."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import per_cent, with_error
from springpot.machine.plain import plain
from springpot.machine.progress import COMPILATION, Clock, Estimate, FractionDone, OutOfTimeError
from springpot.problem.messages import Message, say
from springpot.problem.outputs import about_shocks
from springpot.simulation.lowering.outputs import about_contacts
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.statistics import NORMAL, UPPER, spread_by_logarithms
from springpot.simulation.rare.event import Event
from springpot.simulation.rare.saved import Saved
from springpot.simulation.rare.splitting import Tally, repetitions

REPETITIONS = 32  # first ones: fewer do not tell their own spread
FEWEST = 8  # when the time is over
PLAIN_PATHS, SPLIT_PATHS = 64, 256  # of a repetition
MOST_PATHS = 4096
FREQUENT = 0.01  # probability above which plain paths are cheaper
EVEN, UNEVEN = 0.4, 0.7  # standard deviation of the repetitions over their mean above which each gets more paths
DOUBTFUL = 1.0  # the same above which their spread says little, or the largest share of one of them in their sum:
LARGEST_SHARE = 0.3
MOST_SKEW = 2.0  # by which the spread of the logarithms may widen an interval: 1.0 to 1.4 at 1e-7
WIDE = 2.0  # times two errors: an interval of the logarithm that is said
MOST_OF_A_RATE = 0.5  # share of one repetition in a rate from which on it is not known
PATHS_AT_ONCE = 65536
MOST_UNSEEN = 1_000_000  # plain paths without the event
FARTHER = 0.25  # power of the paths of a repetition with which the coordinate grows at which it dies out
ADDED_LENGTH = 0.14  # of all paths, in an iteration: measured from 12 to 60 of them
USUAL_SQUARE = 8.0  # of the spread of repetitions, over iterations per path: measured 4 to 6 of 12 to 28 iterations
MANY_ITERATIONS = 40.0  # from which on it grows like their third power: measured 13 to 76 of 65
KNOWN = 1.0  # s of work after which the speed of the machine is that of this work
USUAL_RATE = 2e8  # path-steps per second of a thread, until MEASURED of them tell
MEASURED = 1e8
_TOO_SHORT = f"max_time is too short for any result: the first paths have not ended. {COMPILATION}"
UNSETTLED = "not known: the motion has no stationary state"
_ROUNDING = 1e-12  # of a probability of 1, which splitting has as a sum of shares


@dataclass(frozen=True, eq=False)
class ProbabilityWithin:
    """Probabilities that levels are exceeded within a time that is longer than that of the paths.

    Attributes
    ----------
    duration : float
        In s.
    probability, error : ndarray
        Of each level, and its standard error; NaN where the rate is not known.
    low, high : ndarray
        Ends of the 95 % intervals.
    """

    duration: float
    probability: Floats
    error: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class ExceedanceCurve:
    """Probabilities that the largest value of a quantity within a time exceeds levels.

    Attributes
    ----------
    name, unit : str
        The quantity, and the unit of its levels.
    levels : ndarray
    probability, error : ndarray
        Of each level, and its standard error, from the spread of the repetitions.  Few of them seldom have the large
        ones that make most of it: between calls with 32 repetitions probabilities of 1e-7 differed by 1.0 to 1.4 of
        it.
    low, high : ndarray
        Ends of the 95 % intervals of the probabilities, which allow for that by the spread of the logarithms: between
        1e-2 and 1e-8 they held in 93 to 98 of 100 calls with ``rtol=0.2``.  Where no path exceeded the level, 0 and an
        upper bound, and where all did, a lower one.
    rate, rate_error : ndarray
        Of first exceedances in the second half of the time, per second, and the standard errors; NaN where no path was
        left by the end, where one repetition saw half of these exceedances or none saw any, and where the motion has no
        stationary state.
    method : {"plain", "splitting"}
    repetitions, paths : int
        Independent repetitions, and the paths of each.
    spread : float
        Standard deviation of the repetitions over their mean, at the rarest level.
    iterations, path_steps, seconds : float
        Of a repetition, on average; steps of all paths, and the time that they took.
    duration : float
        The time in s.
    settles : bool
        Whether the motion has a stationary state; without one exceedances have no rate.
    downwards : bool
        Whether a level is exceeded by what is below it.
    warnings : tuple of str
    """

    name: str
    unit: str
    levels: Floats
    probability: Floats
    error: Floats
    low: Floats
    high: Floats
    rate: Floats
    rate_error: Floats
    method: str
    repetitions: int
    paths: int
    spread: float
    iterations: float
    path_steps: float
    seconds: float
    duration: float
    settles: bool = True
    downwards: bool = False
    warnings: tuple[Message, ...] = ()

    @property
    def return_period(self) -> Floats:
        """Mean time between exceedances in s, one over the rate; NaN where that is."""
        return np.asarray(1.0 / self.rate)

    @property
    def return_interval(self) -> tuple[Floats, Floats]:
        """Ends of the 95 % intervals of the return periods in s, which are those of their logarithms: as many errors
        wide as those of the probabilities.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            wide = np.log(self.probability / self.low) / (self.error / self.probability)
        factor = np.exp(np.where(self.error > 0.0, wide, NORMAL) * self.rate_error / self.rate)
        return self.return_period / factor, self.return_period * factor

    def within(self, duration: float) -> ProbabilityWithin:
        """Probabilities that the levels are exceeded within a longer time, from the rate: 1 - (1 - p) e^(-rate t).

        Here p is the probability within the time of the paths, and t what comes after it.

        Parameters
        ----------
        duration : float
            In s, at least that of the paths.

        Returns
        -------
        ProbabilityWithin

        Raises
        ------
        TypeError, ValueError
            If it is no such number, or the motion has no stationary state.

        Notes
        -----
        It assumes that the rate stays that of the second half of the paths' time: that a motion which has not exceeded
        the level for so long has forgotten its start.  First exceedances then follow a Poisson process, as in
        `springpot.theory.exceedance`.  Rare levels have it when the time of the paths is some relaxation times long.
        Of a level that no path exceeded the interval begins at 0, and ends with the bound of its rate.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
        >>> hour = sp.exceedance(device, {"x": 4.8}, duration=40.0, rtol=0.2)["x"].within(3600.0)
        >>> formula = sp.theory.exceedance(device, {"x": 4.8})["x"].probability(3600.0)["envelope"]
        >>> bool(hour.low < formula < hour.high)
        True
        """
        time = finite_number(
            duration, "duration", low=self.duration, high=LARGEST, hint="It is in s, at least that of the paths."
        )
        if not self.settles:
            raise ValueError("duration must be that of the paths: the motion has no stationary state, so no rate.")
        later, all_did = time - self.duration, self.probability > 1.0 - _ROUNDING
        seen, known = self.probability > 0.0, np.isfinite(self.rate)
        rate = np.where(seen, np.where(all_did, 0.0, self.rate), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):  # a rate is at most that of all in the second half
            most = -2.0 / self.duration * np.log1p(-self.high)
            shortest, longest = self.return_interval
            begin, end = np.where(known, 1.0 / longest, 0.0), np.where(known, 1.0 / shortest, most)
            left = (1.0 - self.probability) * np.exp(-rate * later)
            low, high = (1.0 - (1.0 - p) * np.exp(-each * later)
                         for p, each in ((self.low, begin), (self.high, end)))  # fmt: skip
            relative = self.error / (1.0 - self.probability) + np.where(seen, self.rate_error, 0.0) * later
            error = np.where(all_did, self.error, left * relative)
        return ProbabilityWithin(time, 1.0 - left, error, low, np.where(self.high < 1.0, high, 1.0))

    @property
    def said(self) -> tuple[str, ...]:
        """Of each level its probability, or the bound, and the return period, with their intervals, in words."""
        found, columns = [], (self.probability, self.error, self.low, self.high, self.return_period)
        for p, error, low, high, again, *ends in zip(*map(np.ravel, (*columns, *self.return_interval)), strict=True):
            often = f", once in {again:.2g} s (95 %: {ends[0]:.2g} to {ends[1]:.2g})" if math.isfinite(again) else ""
            own = f"{with_error(p, error)} (95 %: {low:.2g} to {high:.2g})" if p > 0.0 else f"at most {high:.2g}"
            found.append(own + often)
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """Its numbers and words, but the warnings; what is not finite is None."""
        own = {field.name: getattr(self, field.name) for field in fields(self) if field.name != "warnings"}
        return plain(own | {"return_period": self.return_period})

    def arranged(self, order: npt.NDArray[np.int64], shape: tuple[int, ...]) -> ExceedanceCurve:
        """The same with its levels in another order and shape."""
        numbers = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays: Any = {n: a[order].reshape(shape) for n, a in numbers.items() if isinstance(a, np.ndarray)}
        return replace(self, **arrays)

    def __repr__(self) -> str:
        """What it holds; printed, it shows its numbers."""
        how = f"{self.method}, {self.repetitions} repetitions of {self.paths} paths"
        return f"ExceedanceCurve({self.levels.size} levels of {self.name}: {how})"

    def __str__(self) -> str:
        levels = zip(np.ravel(self.levels), self.said, strict=True)
        than = "<" if self.downwards else ">"
        each = [f"{f'{self.name} {than} {level:g} {self.unit}'.strip()}: {said}" for level, said in levels]
        return "\n".join(each + [f"return periods of {self.name}: {UNSETTLED}."] * (not self.settles))


def search(
    simulation: Simulation, event: Event, rtol: float, clock: Clock, told: Callable[[float], None], stream: int,
    saved: Saved, watch: Callable[[ExceedanceCurve], None] | None = None,
) -> ExceedanceCurve:  # fmt: skip
    """The probability of each level, in the order of rarity, to a relative standard error.

    Plain paths come first.  If less than one in a hundred exceeds the last level, they are left for splitting; where
    its repetitions differ much, they begin again with more paths each, and where they cost more than plain paths for
    the same error, these go on; where all die out so far below the last level that larger ones would too, only the
    levels that they exceed count.
    All this depends on what is found, and on time only when it is over.

    Parameters
    ----------
    told : callable
        Called with the fraction done, which carries an `Estimate` of the repetitions that have begun.
    stream : int
        The first one of random numbers.
    saved : Saved
        Where repetitions are read and written; if to a file, they are advanced one after another, and plain ones as
        many at once as there are threads.
    watch : callable
        Called again and again with the curve so far: a level that no path has exceeded yet has probability 0.

    Raises
    ------
    TimeoutError
        If the time is over before the first paths have ended.
    """
    begun, reason = time.perf_counter(), ""
    clock.rate = USUAL_RATE * simulation.settings.threads
    now = plain = _Repetitions(simulation, event, PLAIN_PATHS, False, stream, clock, told, saved, rtol, watch)
    try:
        now.add(REPETITIONS)
        if now.last.mean() < FREQUENT and simulation.motion.is_noisy:
            now = now.again(SPLIT_PATHS)
            now = plain if now.is_dear else now
        while True:
            more = now.lacking()
            many = more >= 3 * REPETITIONS  # as many paths in larger repetitions have a smaller spread
            uneven = now.spread > (EVEN if many else UNEVEN if more else DOUBTFUL)
            is_idle = now.is_hopeless and not now.exceeded.any()
            if now.splits and uneven and now.paths < MOST_PATHS and not is_idle:
                now = now.again(4 * now.paths)
            elif more:
                now.add(more)
            else:
                break
    except OutOfTimeError:
        if now.count < FEWEST:
            raise TimeoutError(_TOO_SHORT) from None
        reason = "max_time is over"
    return now.curve(reason, time.perf_counter() - begun)


def shares_of_plain_paths(simulation: Simulation, event: Event, clock: Clock, stream: int) -> Floats:
    """The shares of the first plain paths that exceed the levels.

    Raises
    ------
    TimeoutError
        If the time is over before they have ended.
    """
    try:
        tally = repetitions(
            simulation, event, first=0, count=REPETITIONS, paths=PLAIN_PATHS, stream=stream, splits=False, clock=clock,
            tell=lambda _: None,
        )  # fmt: skip
    except OutOfTimeError:
        raise TimeoutError(_TOO_SHORT) from None
    return np.asarray(tally.exceeded[:, 1].mean(axis=0))


def factor_of_interval(shares: Floats, splits: bool = True) -> Floats:
    """By which a probability is divided and multiplied for the ends of its 95 % interval, one of its logarithm.

    Parameters
    ----------
    shares : ndarray, shape (repetitions, levels)
        What each repetition found.
    splits : bool
        Whether by splitting, whose repetitions are skew.
    """
    from scipy import special  # slow to import

    p, count = shares.mean(axis=0), len(shares)
    off = _error(shares) / np.where(p > 0.0, p, 1.0)
    if splits:
        by_logarithms = np.array([spread_by_logarithms(each) for each in shares.T]) / math.sqrt(count)
        off = np.clip(by_logarithms, off, MOST_SKEW * off)
    return np.asarray(np.exp(float(special.stdtrit(count - 1, 0.975)) * off))


@dataclass(eq=False)
class _Repetitions:
    """Those of one kind, so far."""

    simulation: Simulation
    event: Event
    paths: int
    splits: bool
    stream: int
    clock: Clock
    told: Callable[[float], None]
    saved: Saved
    rtol: float
    watch: Callable[[ExceedanceCurve], None] | None
    path_steps: float = 0.0
    most: float = 1.0  # probability of the last level, if no path exceeds it

    def __post_init__(self) -> None:
        self.tallies = list[Tally]()

    def again(self, paths: int) -> _Repetitions:
        """Splitting of so many paths each."""
        event = self.event
        if not self.splits:
            ends = np.concatenate([tally.ends for tally in self.tallies])
            event = event.told_by(ends[: REPETITIONS * self.paths])
        own = replace(self, event=event, paths=paths, splits=True, stream=self.stream + 1, most=self._bound())
        try:
            own.add(REPETITIONS)
        except OutOfTimeError:
            if self.splits or own.count < FEWEST:
                raise
            own.clock = Clock(0.0)  # an unfinished iteration says more than plain paths
        return own

    def add(self, count: int) -> None:
        """So many more."""
        done = self.count
        wanted = done + count
        while done < wanted:
            self.clock.check()
            found = self.saved.find(self.stream, self.splits, self.paths, done)
            for tally in self._computed(done, wanted) if found is None else [found]:
                self.path_steps += tally.path_steps
                if tally.complete or not self.tallies:
                    self.tallies.append(tally)
                if not tally.complete:
                    raise OutOfTimeError
            done = self.count
            self._show()

    def _computed(self, done: int, wanted: int) -> list[Tally]:
        """Some more of those that are wanted, written as they end, with what is told meanwhile."""
        threads, is_saved = self.simulation.settings.threads, self.saved.file.path is not None
        count = min(wanted - done, (1 if self.splits else threads) if is_saved else PATHS_AT_ONCE // self.paths)
        steps = sum(tally.path_steps for tally in self.tallies)
        usual = 1.0 + (float(np.mean(self.tallies[-1].iterations)) if self.tallies else self.event.iterations)
        each = steps / done if done else self._length(self.paths)
        reason = f"{wanted} repetitions of {self.paths} paths"
        later = 0.0 if done else self._later(wanted)

        def tell(iterations: float) -> None:
            share = min(1.0, iterations / usual)
            ended = done + count * share
            if share > 0.0 and (elapsed := time.perf_counter() - begun) > KNOWN:
                self.clock.measure(each * count * share, elapsed)
            left, whole = each * (wanted - ended) + later, each * (wanted - done) + later
            estimate = Estimate(self.path_steps + whole, self.clock.seconds(left), reason, self.rtol)
            self.told(FractionDone(ended / wanted * (1.0 - later / whole), estimate))

        begun = time.perf_counter()
        tally = repetitions(
            self.simulation, self.event, first=done, count=count, paths=self.paths, stream=self.stream,
            splits=self.splits, clock=self.clock, tell=tell, watch=self._show if self.watch else None,
        )  # fmt: skip
        if tally.path_steps > MEASURED:
            self.clock.measure(tally.path_steps, time.perf_counter() - begun)
        tallies = tally.apart() if is_saved and not self.splits else [tally]
        for number, own in enumerate(tallies, done):
            ends = own.ends if number < REPETITIONS else own.ends[:0]
            self.saved.add(replace(own, ends=ends), self.stream, self.splits, self.paths, number)
        return tallies

    def _length(self, paths: int) -> float:
        """Steps of a repetition of so many paths, about."""
        return paths * self.simulation.settings.steps * (1.0 + ADDED_LENGTH * self.event.iterations * self.splits)

    def _later(self, count: int) -> float:
        """Steps after so many first repetitions, about: of more of them, or of larger ones."""
        if not self.splits:
            return 0.0
        paths, iterations = self.paths, self.event.iterations
        square = USUAL_SQUARE * (1.0 + (iterations / MANY_ITERATIONS) ** 3) * iterations / paths
        if square > UNEVEN**2 and paths < MOST_PATHS:
            larger = replace(self, paths=4 * paths)
            return REPETITIONS * self._length(4 * paths) + larger._later(REPETITIONS)
        return max(square / self.rtol**2 - count, 0.0) * self._length(paths)

    def _show(self, *tallies: Tally) -> None:
        """The curve so far, with these."""
        so_far = replace(self)
        so_far.tallies = [*self.tallies, *tallies]
        if self.watch is not None and so_far.count >= FEWEST:
            self.watch(so_far.curve("", 0.0))

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(len(tally.weights) for tally in self.tallies)

    @property
    def is_hopeless(self) -> bool:
        """Whether larger ones would die out too before the last level."""
        reached, floor = max(float(tally.reached.max()) for tally in self.tallies), self.event.floor
        farther = (MOST_PATHS / self.paths) ** FARTHER
        return not self.last.any() and floor < reached < floor + (self.event.target - floor) / farther

    def lacking(self) -> int:
        """How many more are needed."""
        done, p = self.count, self.exceeded[:, 1].mean(axis=0)
        if not p[-1] > 0.0 and not self.splits and self.paths * done < MOST_UNSEEN:
            return 3 * done
        known = p > 0.0
        off = float(np.max(_error(self.exceeded[:, 1, known]) / p[known], initial=0.0)) / self.rtol
        return 0 if off <= 1.0 else min(max(math.ceil(done * (1.05 * off**2 - 1.0)), REPETITIONS // 4), 3 * done)

    @property
    def exceeded(self) -> Floats:
        """Of each, by half time and by the end, the probability of each level."""
        return np.concatenate([tally.exceeded for tally in self.tallies])

    @property
    def last(self) -> Floats:
        """Of each the probability of the last level."""
        return np.asarray(self.exceeded[:, 1, -1])

    @property
    def rarest(self) -> Floats:
        """Of each the probability of the rarest level that any exceeded."""
        return np.asarray(self.exceeded[:, 1, np.flatnonzero(self.exceeded[:, 1].any(axis=0))[-1:]].sum(axis=1))

    @property
    def spread(self) -> float:
        """Standard deviation over the mean, at the last level; if that is out of reach, at the last one exceeded."""
        return _spread(self.rarest if self.is_hopeless else self.last)

    @property
    def is_dear(self) -> bool:
        """Whether plain paths would reach the same error at the last level in fewer steps."""
        p, steps = float(self.last.mean()), self.path_steps / len(self.last)
        return float(self.last.var(ddof=1)) * steps > p * (1.0 - p) * self.simulation.settings.steps

    def curve(self, reason: str, seconds: float) -> ExceedanceCurve:
        """What they say; ``reason`` is why there are no more."""
        half, whole = self.exceeded.transpose(1, 0, 2)
        p, error, count = whole.mean(axis=0), _error(whole), len(whole)
        wide = factor_of_interval(whole, self.splits)
        high = np.where(p > 0.0, np.minimum(p * wide, 1.0), self._bound())
        all_did = p > 1.0 - _ROUNDING  # and no path was left whose rate could be known
        late = whole - half
        of_few = late.max(axis=0) >= MOST_OF_A_RATE * late.sum(axis=0)  # or of none
        no_rate = all_did | of_few | (not self.simulation.motion.settles)
        p_of_most, half_of_most = (np.where(no_rate, np.nan, each) for each in (p, half.mean(axis=0)))
        rate = -2.0 / self.event.duration * (np.log1p(-p_of_most) - np.log1p(-half_of_most))
        rate_error = 2.0 / self.event.duration * _error(late) / (1.0 - p_of_most)
        unseen = UPPER / (self.paths * count)
        error, low = np.where(all_did, unseen / NORMAL, error), np.where(all_did, math.exp(-unseen), p / wide)
        name, units = self.event.name, self.event.unit
        return ExceedanceCurve(
            name, units, self.event.given, p, error, low, high, rate, rate_error,
            method="splitting" if self.splits else "plain",
            repetitions=count,
            paths=self.paths,
            spread=self.spread,
            iterations=float(np.concatenate([tally.iterations for tally in self.tallies]).mean()),
            path_steps=self.path_steps,
            seconds=seconds,
            duration=self.event.duration,
            settles=self.simulation.motion.settles,
            downwards=self.event.downwards,
            warnings=tuple(self._doubts(p, error, low, high, reason)),
        )  # fmt: skip

    def _bound(self) -> float:
        """On the probability of a level that no path has exceeded."""
        weights = np.concatenate([tally.weights for tally in self.tallies])
        own = float(weights.mean() + 2.0 * _error(weights)) if self.splits else UPPER / (self.paths * len(weights))
        return min(self.most, own) if not self.last.any() else 1.0

    def _doubts(self, p: Floats, error: Floats, low: Floats, high: Floats, reason: str) -> Iterator[Message]:
        rtol, of = self.rtol, {"name": self.event.name, "unit": self.event.unit}
        motion, seen = self.simulation.motion, {k for each in self.event.observers for k in each.signal.outputs}
        names = [[*motion.outputs][k] for k in sorted(seen)]
        yield from about_shocks(motion.system, [self.event.name], {})
        yield from about_contacts(motion, self.simulation.settings.step, names, {})
        if not p.all():
            n = int(np.argmin(p))
            yield say("level_not_reached", **of, level=self.event.given[n], most=high[n])
        if reason and (error > rtol * p).any():
            n = int(np.argmax(error / np.where(p > 0.0, p, math.inf)))
            known = {"reached": per_cent(error[n] / p[n]), "rtol": per_cent(rtol), "reason": reason}
            yield say("rare_not_known", **of, level=self.event.given[n], **known)
        with np.errstate(divide="ignore", invalid="ignore"):
            wide = np.nan_to_num(np.log(p / low) / (NORMAL * error / p), posinf=0.0)
        if self.splits and wide.max() > WIDE:
            n = int(np.argmax(wide))
            ends = {"low": f"{low[n]:.2g}", "high": f"{high[n]:.2g}"}
            yield say("wide_interval", **of, level=self.event.given[n], times=wide[n], **ends)
        if self.splits and p.any():
            spread, largest = _spread(self.rarest), float(self.rarest.max() / self.rarest.sum())
            if spread > DOUBTFUL or largest > LARGEST_SHARE:
                yield say("uneven_repetitions", **of, spread=spread, most=per_cent(largest))


def unknown(event: Event) -> ExceedanceCurve:
    """What is known of a quantity whose first paths have not ended: nothing, so the bound of each level is 1."""
    none = np.full(len(event.given), np.nan)
    said = say("level_not_reached", name=event.name, unit=event.unit, level=event.given[0], most=1.0)
    return ExceedanceCurve(
        event.name, event.unit, event.given, none, none, np.zeros_like(none), np.ones_like(none), none, none,
        method="plain", repetitions=0, paths=0, spread=math.inf, iterations=0.0, path_steps=0.0, seconds=0.0,
        duration=event.duration,
        warnings=(said,),
    )  # fmt: skip


def _spread(samples: Floats) -> float:
    """Standard deviation over the mean; infinite without either."""
    return float(samples.std(ddof=1) / samples.mean()) if samples.any() else math.inf


def _error(samples: Floats) -> Floats:
    return np.asarray(samples.std(axis=0, ddof=1) / math.sqrt(len(samples)))
