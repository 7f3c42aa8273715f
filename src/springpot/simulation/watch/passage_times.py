"""First-passage times of independent paths, censored by the end of the run: survival curve, quantiles, mean.

All paths are observed for the same time, so the Kaplan-Meier estimate of the survival curve is the share of the paths
that have not passed yet.  The mean of censored times needs an assumption; the mean of min(time, horizon) does not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import finite_number, real_array
from springpot.machine.arrays import Columns, Floats
from springpot.machine.faults import per_cent, shown
from springpot.problem.catalogue import OF_A_LEVEL
from springpot.problem.messages import Message, say
from springpot.simulation.paths.statistics import binomial_interval
from springpot.simulation.watch.passage_rates import Bounded, PassageRate, rate_of

FEWEST_LATE = 20  # passages needed in the second half of the horizon to estimate their rate
FEWEST_AT_ALL = 5  # the same if censored paths add less than a standard error to the mean
MOST_DRIFT = 3.0  # largest difference between the rates in the two halves of it, in standard errors
POINTS = 101  # of the survival curve in files

_SAID = {"_se": "standard error of"} | {f"_{end}": f"{end} end of the 95 % interval of" for end in ("low", "high")}


@dataclass(frozen=True, eq=False)
class PassageTimes:
    """When each path first passed a level.

    Attributes
    ----------
    quantity : str
    level, reference : float
        The level, and the position from which a distance is measured (NaN for other quantities).
    unit : str
        Of the level; empty for an observable.
    begin : float
        Start of the observation, in s: 0 from rest, the start of the window from the stationary state.
    horizon : float
        Duration of the observation, in s.
    settling : float
        Time after which the rate of passages is assumed constant, in s: needed for a mean if some paths are censored.
        Infinite where the excitation ends, or there is no stationary state for another reason.
    times : ndarray, shape (paths,)
        Since ``begin``, in s; 0 for a path beyond the level at ``begin``, infinite for one that did not pass.
    """

    quantity: str
    level: float
    reference: float
    unit: str
    begin: float
    horizon: float
    settling: float
    times: Floats = field(repr=False)

    @property
    def paths(self) -> int:
        """Number of paths."""
        return int(self.times.size)

    @property
    def share_at_start(self) -> float:
        """Share of the paths that were beyond the level at ``begin``."""
        return float(np.mean(self.times == 0.0))

    @property
    def share_censored(self) -> float:
        """Share of the paths that had not passed at the end of the run."""
        return float(np.mean(np.isinf(self.times)))

    def survival(self, time: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Probability that the level has not been passed by a time, and its standard error.

        Parameters
        ----------
        time : array_like
            In s, from 0 to the horizon.

        Returns
        -------
        survival, standard_error : ndarray

        Raises
        ------
        ValueError
            If a time lies outside.

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0, np.inf]))
        >>> passages.survival([0.0, 2.5])[0]
        array([1. , 0.5])
        """
        t = real_array(time, "time")
        if np.any(~((t >= 0.0) & (t <= self.horizon * (1.0 + 1e-12)))):
            raise ValueError(f"time must be in [0, {self.horizon:g}] s, where the paths were watched.")
        share = 1.0 - np.searchsorted(np.sort(self.times), t, side="right") / self.paths
        return np.asarray(share), np.asarray(_share_error(share, self.paths))

    def survival_interval(self, time: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Ends of the 95 % interval of the survival at each time: exact ones of a share of independent paths.

        Parameters
        ----------
        time : array_like
            In s, from 0 to the horizon.

        Returns
        -------
        low, high : ndarray

        Raises
        ------
        ValueError
            If a time lies outside.

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.full(100, np.inf))
        >>> low, high = passages.survival_interval(4.0)
        >>> float(low.round(3)), float(high)
        (0.97, 1.0)
        """
        left = self.survival(time)[0] * self.paths
        return binomial_interval(np.rint(left), self.paths)

    @cached_property
    def rate(self) -> PassageRate:
        """The rate of passages of the paths that have not passed yet, from when it is constant, in 1/s.

        A test on the passages must not contradict that it is constant; what was left out of the start, and what the
        test says, is in ``statement``.  If it is not constant, or the run is too short, the value is NaN.  Where no
        path has passed, the value is 0 and ``high`` the bound, 3 over the time of all paths.

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 100.0, 10.0, np.full(50, np.inf))
        >>> print(passages.rate)
        at most 0.00067 s-1 with 95 %
        >>> passages.rate.statement
        'the rate is taken for constant after 10 s, which are left out; no passages are too few to test it.'
        """
        return rate_of(self.times, self.horizon, self.settling)

    @property
    def return_period(self) -> Bounded:
        """Mean time between passages in s, one over the rate; infinite where none was seen, with a lower bound.

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 100.0, 10.0, np.full(50, np.inf))
        >>> print(passages.return_period)
        at least 1.5e+03 s with 95 %
        """
        rate = self.rate
        low, value, high = (1.0 / end if end else math.inf for end in (rate.high, rate.value, rate.low))
        error = rate.error * value**2 if rate.value else math.nan
        return Bounded(value, error, low, high, "s", rate.statement)

    def probability(self, duration: float) -> Bounded:
        """Probability that the level is passed within a time from the start of the clock, however long.

        Within the run it is the share of the paths that passed.  Beyond it, it is 1 - S e^(-rate (duration - since)),
        with the share S that has not passed by ``rate.since``: this assumes that the constant rate goes on, and
        ``statement`` says so.  If the rate is not known, neither is the value, and the interval is what must hold.

        Parameters
        ----------
        duration : float
            In s.

        Returns
        -------
        Bounded
            With ``value``, ``error``, the 95 % interval ``low`` and ``high``, and a ``statement``.

        Raises
        ------
        TypeError, ValueError
            If the duration is not a positive number.

        Notes
        -----
        The interval joins those of -ln S and of the rate, which come from different times of the paths, by their
        distances from the values (G. Y. Zou and A. Donner, Statistics in Medicine 27, 2008).

        Examples
        --------
        >>> times = np.random.default_rng(1).exponential(50.0, 400)
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 20.0, 2.0, np.where(times < 20.0, times, np.inf))
        >>> print(passages.probability(100.0))  # 1 - e^-2 = 0.865
        0.892 +- 0.021, from 0.845 to 0.929 with 95 %
        """
        end = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in seconds.")
        rate = self.rate
        known = end > self.horizon and not math.isnan(rate.value)
        since = rate.since if known else min(end, self.horizon)
        share = float(np.mean(self.times <= since))
        low, high = (float(bound) for bound in binomial_interval(share * self.paths, self.paths))
        error = float(_share_error(share, self.paths))
        if end <= self.horizon:
            return Bounded(share, error, low, high)
        beyond = f"{end - self.horizon:.3g} s of {end:.3g} s lie beyond the run"
        if not known:
            return Bounded(math.nan, math.nan, low, 1.0, "1", f"{beyond}, and {rate.statement}")
        least, likely, most = (
            np.array([-math.log1p(-passed), constant * (end - since)])
            for passed, constant in ((low, rate.low), (share, rate.value), (high, rate.high))
        )
        total = float(likely.sum())
        under, over = (float(np.linalg.norm(side - likely)) for side in (least, most))
        low, high = (-math.expm1(-max(each, 0.0)) for each in (total - under, total + over))
        error = math.exp(-total) * math.hypot(error / (1.0 - share), rate.error * (end - since))
        said = f"{beyond}: this assumes that the constant rate goes on; {rate.statement}"
        return Bounded(-math.expm1(-total), error, low, high, "1", said)

    def quantile(self, probability: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Times by which shares of the paths have passed, and their standard errors.

        NaN for a share that has not passed by the end of the run.

        Parameters
        ----------
        probability : array_like
            In [0, 1].

        Returns
        -------
        quantile, standard_error : ndarray
            In s.

        Raises
        ------
        ValueError
            If a probability is outside [0, 1].

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0, np.inf]))
        >>> passages.quantile([0.5, 0.9])[0]
        array([ 2., nan])
        """
        p = real_array(probability, "probability")
        if np.any(~((p >= 0.0) & (p <= 1.0))):
            raise ValueError(f"probability must be in [0, 1], not {shown(probability)}.")
        away = np.sqrt(p * (1.0 - p) / self.paths)
        ordered = np.sort(self.times)
        low, at, high = (
            ordered[np.clip(np.ceil(self.paths * q - 1e-9).astype(int) - 1, 0, self.paths - 1)]
            for q in (p - away, p, np.minimum(p + away, 1.0))
        )
        with np.errstate(invalid="ignore"):
            error = 0.5 * (high - low)
        known = np.isfinite(high) & (self.paths * p * (1.0 - p) >= 4.0)
        return np.where(np.isfinite(at), at, np.nan), np.where(known, error, np.nan)

    @property
    def restricted_mean(self) -> tuple[float, float]:
        """Mean of min(time, horizon), and its standard error, in s: known for any share of censored paths."""
        seen = np.minimum(self.times, self.horizon)
        return float(seen.mean()), _standard_error(seen)

    @cached_property
    def mean(self) -> tuple[float, float, str]:
        """Mean time in s, its standard error, and a sentence: the assumption, or why there is no mean.

        If every path has passed it is the mean of the times.  Otherwise the remaining paths are assumed to pass at the
        constant rate of passages in the second half of the horizon.  If that adds more than a standard error, the mean
        is NaN where the rate is not constant, comes from too few passages, or that half begins before ``settling``.  It
        is NaN, too, where ``settling`` is infinite, as of an earthquake: who has not passed by its end need never pass.

        Examples
        --------
        >>> passages = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0]))
        >>> passages.mean[0], passages.mean[2]
        (2.0, '')
        """
        censored = np.isinf(self.times)
        if not censored.any():
            return *self.restricted_mean, ""
        half = 0.5 * self.horizon
        share = f"{per_cent(self.share_censored)} of the paths have not passed by the end of the run"
        seen = np.minimum(self.times, self.horizon)
        late = (self.times > half) & ~censored
        exposure = np.maximum(seen - half, 0.0)
        c, e, d = censored.mean(), exposure.mean(), late.mean()
        lasts = math.isfinite(self.settling)
        small = lasts and late.sum() >= FEWEST_AT_ALL and c * e / d < _standard_error(seen)
        refusal = "" if small else self._no_mean(share, half, late, exposure)
        if refusal:
            return math.nan, math.nan, refusal
        # linearized: mean = restricted + censored * exposure / late
        value = float(seen.mean() + c * e / d)
        samples = seen + censored * (e / d) + exposure * (c / d) - late * (c * e / d**2)
        assumed = f"{share}; the mean time assumes that they pass at the rate of the second half, {d / e:.3g} per s."
        return value, _standard_error(samples), assumed

    def _no_mean(self, share: str, half: float, late: npt.NDArray[np.bool_], exposure: Floats) -> str:
        """Why there is no mean; empty if there is one."""
        seen = np.minimum(self.times, self.horizon)
        if math.isinf(self.settling):
            return f"{share}, and no later rate of passages is known, so there is no mean time: use quantiles."
        if half < self.settling:
            return (
                f"{share}, so the run is too short for a mean time: use a run of at least {2.0 * self.settling:.3g} s "
                "from the start of the clock, or quantiles or the survival curve."
            )
        if late.sum() < FEWEST_LATE:
            return (
                f"{share}, and fewer than {FEWEST_LATE} have passed in its second half, too few for a mean time: use a "
                "longer run or more paths."
            )
        middle = 0.75 * self.horizon
        first = int((late & (self.times <= middle)).sum()), float(np.minimum(exposure, middle - half).sum())
        second = int(late.sum()) - first[0], float(np.maximum(seen - middle, 0.0).sum())
        rates = [count / time for count, time in (first, second)]
        spread = math.hypot(*(math.sqrt(max(count, 1)) / time for count, time in (first, second)))
        if abs(rates[1] - rates[0]) > MOST_DRIFT * spread:
            return (
                f"{share}, and the rate of passages still changes in its second half, so there is no mean time: use a "
                "longer run, or quantiles."
            )
        return ""

    @property
    def mean_time(self) -> float:
        """The mean time in s, NaN if there is none; `mean` also has its standard error and its assumption."""
        return self.mean[0]

    @property
    def title(self) -> str:
        """What is passed, in words.

        Examples
        --------
        >>> PassageTimes("x", 2.5, 0.5, "m", 0.0, 4.0, 1.0, np.ones(2)).title
        'x out of -2 to 3 m'
        """
        low, high = self.reference - self.level, self.reference + self.level
        words = f"{self.quantity} out of {low:g} to {high:g}"
        if math.isnan(self.reference) or self.quantity.endswith("distance"):
            words = f"{self.quantity} through {self.level:g}"
        return f"{words} {self.unit}".rstrip()

    @property
    def numbers(self) -> dict[str, float]:
        """The single numbers of `OF_A_LEVEL`, by name and ending."""
        count, found = self.paths, dict[str, float]()
        for key, part in (("censored", self.share_censored), ("at_start", self.share_at_start)):
            found |= {key: part, f"{key}_se": float(_share_error(part, count))}
        for key, (value, error, *_) in (("mean", self.mean), ("restricted_mean", self.restricted_mean)):
            found |= {key: value, f"{key}_se": error}
        bounded = {
            "probability": self.probability(self.horizon),
            "rate": self.rate,
            "return_period": self.return_period,
        }
        for key, own in bounded.items():
            found |= {key: own.value, f"{key}_se": own.error, f"{key}_low": own.low, f"{key}_high": own.high}
        return found

    def columns(self, name: str, probabilities: Sequence[float]) -> Columns:
        """Everything for tables and files."""
        name = f"{name}_first_passage"
        numbers, found = self.numbers, Columns()
        for key, (unit, text, endings) in OF_A_LEVEL.items():
            for end in endings:
                words = f"{_SAID[end]} {name}_{key}" if end else f"{text}: {self.title}"
                found[f"{name}_{key}{end}"] = (), numbers[key + end], {"units": unit, "long_name": words}
        axis, t = f"{name}_time", np.linspace(0.0, self.horizon, POINTS)
        found[axis] = (axis,), t, {"units": "s"}
        survival = zip(("", "_se", "_low", "_high"), (*self.survival(t), *self.survival_interval(t)), strict=True)
        found |= {f"{name}_survival{end}": ((axis,), values, {"units": "1"}) for end, values in survival}
        found["probability"] = ("probability",), [*probabilities], {"units": "1"}
        for end, values in zip(("", "_se"), self.quantile(probabilities), strict=True):
            found[f"{name}_quantile{end}"] = ("probability",), values, {"units": "s"}
        return found

    def __str__(self) -> str:
        return f"{self.title}: rate {self.rate}"

    @property
    def warnings(self) -> tuple[Message, ...]:
        """Warnings: one sentence each."""
        name, (mean, error, assumed) = f"{self.quantity}_first_passage", self.mean
        sentences = []
        if assumed and math.isfinite(self.settling) and not mean - self.restricted_mean[0] < error:
            sentences.append(say("passage_mean_extrapolated", name=name, assumed=assumed))
        if self.share_at_start > 0.0:
            sentences.append(say("passed_at_start", name=name, share=per_cent(self.share_at_start)))
        return tuple(sentences)


@dataclass(frozen=True, eq=False)
class PassagesOfLevels(Sequence[PassageTimes]):
    """First passages of several levels of one quantity, in the order in which they were given.

    Attributes
    ----------
    of_levels : tuple of PassageTimes

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
    >>> run = sp.simulate(device, paths=256, duration=60.0, start="rest", first_passage={"x": [2.0, 3.0, 9.0]})
    >>> passages = run.first_passages["x"]
    >>> len(passages), passages.levels, passages[2].rate.events
    (3, (2.0, 3.0, 9.0), 0)
    """

    of_levels: tuple[PassageTimes, ...]

    def __len__(self) -> int:
        return len(self.of_levels)

    def __getitem__(self, number: Any) -> Any:
        return self.of_levels[number]

    @property
    def levels(self) -> tuple[float, ...]:
        """The levels; of an interval half its width."""
        return tuple(each.level for each in self)

    def columns(self, name: str, probabilities: Sequence[float]) -> Columns:
        """As those of one level, over one more axis."""
        each = [one.columns(name, probabilities) for one in self]
        name = f"{name}_first_passage"
        axis, found = f"{name}_level", each[0]
        common = {axis: found.pop(axis) for axis in (f"{name}_time", "probability")}
        stacked = {
            key: (
                (axis, *axes),
                np.stack([np.asarray(own[key][1], dtype=float) for own in each]),
                {what: text.partition(":")[0] for what, text in words.items()},  # without the first level
            )
            for key, (axes, _, words) in found.items()
        }
        places = {axis: ((axis,), np.array(self.levels), {"units": self[0].unit})}
        if not all(math.isnan(one.reference) for one in self):
            where = np.array([one.reference for one in self])
            stacked[f"{name}_reference"] = (axis,), where, {"units": self[0].unit}
        return {**places, **common, **stacked}

    @property
    def warnings(self) -> tuple[Message, ...]:
        """One sentence of each kind: that of the first level that has one."""
        found = dict[str, Message]()
        for message in (message for one in self for message in one.warnings):
            found.setdefault(message.name, message)
        return tuple(found.values())

    def __str__(self) -> str:
        return "\n".join(map(str, self))


def _standard_error(samples: Floats) -> float:
    return float(samples.std(ddof=1) / math.sqrt(samples.size)) if samples.size > 1 else math.nan


def _share_error(share: npt.ArrayLike, count: int) -> Floats:
    """Standard error of a share, computed with one path more on either side, so that it is not 0 for a share of 0."""
    likely = (np.asarray(share, dtype=float) * count + 1.0) / (count + 2.0)
    return np.asarray(np.sqrt(likely * (1.0 - likely) / count))
