"""First-passage times of independent paths, censored by the end of the run: survival curve, quantiles, mean.

All paths are observed for the same time, so the Kaplan-Meier estimate of the survival curve is the share of the paths
that have not passed yet.  The mean of censored times needs an assumption; the mean of min(time, horizon) does not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import per_cent
from springpot.problem.messages import Message, say

__all__ = ["PassageTimes"]

Floats = npt.NDArray[np.float64]

FEWEST_LATE = 20  # passages needed in the second half of the horizon to estimate their rate
FEWEST_AT_ALL = 5  # the same if censored paths add less than a standard error to the mean
MOST_DRIFT = 3.0  # largest difference between the rates in the two halves of it, in standard errors
POINTS = 101  # of the survival curve in files


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
        t = np.asarray(time, dtype=float)
        if np.any(~((t >= 0.0) & (t <= self.horizon * (1.0 + 1e-12)))):
            raise ValueError(f"time must be in [0, {self.horizon:g}] s, where the paths were watched.")
        share = 1.0 - np.searchsorted(np.sort(self.times), t, side="right") / self.paths
        return np.asarray(share), np.asarray(_share_error(share, self.paths))

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
        p = np.asarray(probability, dtype=float)
        if np.any(~((p >= 0.0) & (p <= 1.0))):
            raise ValueError(f"probability must be in [0, 1], not {probability!r}.")
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
        is NaN where the rate is not constant, comes from too few passages, or that half begins before ``settling``.

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
        small = late.sum() >= FEWEST_AT_ALL and c * e / d < _standard_error(seen)
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
        if half < self.settling:
            wanted = "quantiles or the survival curve"
            if math.isfinite(self.settling):
                wanted = f"a run of at least {2.0 * self.settling:.3g} s from the start of the clock, or {wanted}"
            return f"{share}, so the run is too short for a mean time: use {wanted}."
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

    def numbers(self) -> dict[str, tuple[float, str, str]]:
        """Scalars for tables and files, by name: value, unit and description."""
        name = f"{self.quantity}_first_passage"
        what = f"first passage of {self.quantity} through {self.level:g} {self.unit}".rstrip()
        (mean, error, _), (restricted, its_error) = self.mean, self.restricted_mean
        n = self.paths
        entries = {
            f"{name}_mean": (mean, error, "s", f"mean time of the {what}"),
            f"{name}_restricted_mean": (restricted, its_error, "s", f"mean of the time cut off at {self.horizon:g} s"),
            f"{name}_censored": (self.share_censored, float(_share_error(self.share_censored, n)), "1",
                                 "share of the paths that have not passed by the end of the run"),
            f"{name}_at_start": (self.share_at_start, float(_share_error(self.share_at_start, n)), "1",
                                 "share of the paths beyond the level when the clock starts"),
        }  # fmt: skip
        numbers = {}
        for key, (value, se, unit, text) in entries.items():
            numbers[key] = value, unit, text
            numbers[f"{key}_se"] = se, unit, f"standard error of {key}"
        return numbers

    def curve(self) -> tuple[Floats, Floats, Floats]:
        """Times, survival and its standard error, for files and pictures."""
        t = np.linspace(0.0, self.horizon, POINTS)
        return t, *self.survival(t)

    @property
    def warnings(self) -> tuple[Message, ...]:
        """Warnings: one sentence each."""
        name, (mean, error, assumed) = f"{self.quantity}_first_passage", self.mean
        sentences = []
        if assumed and not mean - self.restricted_mean[0] < error:
            sentences.append(say("passage_mean_extrapolated", name=name, assumed=assumed))
        if self.share_at_start > 0.0:
            sentences.append(say("passed_at_start", name=name, share=per_cent(self.share_at_start)))
        return tuple(sentences)


def _standard_error(samples: Floats) -> float:
    return float(samples.std(ddof=1) / math.sqrt(samples.size)) if samples.size > 1 else math.nan


def _share_error(share: npt.ArrayLike, count: int) -> Floats:
    """Standard error of a share, computed with one path more on either side, so that it is not 0 for a share of 0."""
    likely = (np.asarray(share, dtype=float) * count + 1.0) / (count + 2.0)
    return np.asarray(np.sqrt(likely * (1.0 - likely) / count))
