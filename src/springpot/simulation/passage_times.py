"""Times of first passage of independent paths, some of them cut off by the end of the run, and what follows from them.

All paths are watched for the same time, so the Kaplan-Meier estimate of the survival curve is the share of the paths
that have not passed yet.  The mean of a time that is cut off is not known without an assumption; the mean of
min(time, horizon) is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

__all__ = ["PassageTimes"]

Floats = npt.NDArray[np.float64]

FEWEST_LATE = 20  # passages in the second half of the horizon, for a rate of them
FEWEST_AT_ALL = 5  # the same where the paths that have not passed add less than a standard error to the mean
MOST_DRIFT = 3.0  # standard errors between the rates of its two halves
POINTS = 101  # of the survival curve in files


@dataclass(frozen=True, eq=False)
class PassageTimes:
    """When each path first passed a level.

    Attributes
    ----------
    quantity : str
    level, reference : float
        The level, and the place that a distance is counted from (NaN for other quantities).
    unit : str
        Of the level; empty for an observable.
    begin : float
        Time at which the clock starts, in s: 0 from rest, the start of the window from the stationary state.
    horizon : float
        How long each path is watched, in s.
    settling : float
        Time after which the rate of passages is taken to be constant, in s: needed for a mean if some paths are cut
        off.
    times : ndarray, shape (paths,)
        Since ``begin``, in s; 0 for a path beyond the level when the clock starts, infinite for one that did not pass.
    """

    quantity: str
    level: float
    reference: float
    unit: str
    begin: float
    horizon: float
    settling: float
    times: Floats

    @property
    def paths(self) -> int:
        """How many paths were watched."""
        return int(self.times.size)

    @property
    def share_at_start(self) -> float:
        """Share of the paths that were beyond the level when the clock started."""
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
            If a time lies outside; nothing was seen there.

        Examples
        --------
        >>> found = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0, np.inf]))
        >>> found.survival([0.0, 2.5])[0]
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
        >>> found = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0, np.inf]))
        >>> found.quantile([0.5, 0.9])[0]
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
        """Mean of min(time, horizon), and its standard error, in s: known whatever share of the paths is cut off."""
        seen = np.minimum(self.times, self.horizon)
        return float(seen.mean()), _standard_error(seen)

    @cached_property
    def mean(self) -> tuple[float, float, str]:
        """Mean time in s, its standard error, and what was assumed or why there is none.

        If every path has passed it is the mean of the times.  Otherwise those that have not are taken to pass at the
        constant rate that the others had in the second half of the horizon.  Where that adds more than a standard error
        to the mean, there is none (NaN) if the rate is not seen to be constant there, or from too few passages, or the
        half begins too early.

        Examples
        --------
        >>> found = PassageTimes("x", 1.0, math.nan, "m", 0.0, 4.0, 1.0, np.array([1.0, 2.0, 3.0]))
        >>> found.mean[0], found.mean[2]
        (2.0, '')
        """
        censored = np.isinf(self.times)
        if not censored.any():
            return *self.restricted_mean, ""
        half = 0.5 * self.horizon
        share = f"{100.0 * self.share_censored:.2g} % of the paths have not passed by the end of the run"
        seen = np.minimum(self.times, self.horizon)
        late = (self.times > half) & ~censored
        exposure = np.maximum(seen - half, 0.0)
        c, e, d = censored.mean(), exposure.mean(), late.mean()
        small = late.sum() >= FEWEST_AT_ALL and c * e / d < _standard_error(seen)
        refusal = "" if small else self._no_mean(share, half, late, exposure)
        if refusal:
            return math.nan, math.nan, refusal
        # to first order in the spread: mean = restricted + censored * exposure / late
        value = float(seen.mean() + c * e / d)
        samples = seen + censored * (e / d) + exposure * (c / d) - late * (c * e / d**2)
        assumed = f"{share}; the mean time takes them to pass at the rate of the second half, {d / e:.3g} per s."
        return value, _standard_error(samples), assumed

    def _no_mean(self, share: str, half: float, late: npt.NDArray[np.bool_], exposure: Floats) -> str:
        """Why the paths that have not passed leave no mean; empty if they do."""
        seen = np.minimum(self.times, self.horizon)
        if half < self.settling:
            wanted = "quantiles or the survival curve"
            if math.isfinite(self.settling):
                wanted = f"a run of at least {2.0 * self.settling:.3g} s from the start of the clock, or {wanted}"
            return f"{share}, too early for a mean time: use {wanted}."
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
        """The mean time in s, NaN if there is none; `mean` has its standard error and what it assumes."""
        return self.mean[0]

    def numbers(self) -> dict[str, tuple[float, str, str]]:
        """Scalars for tables and files, by name: value, unit and what it is."""
        name = f"{self.quantity}_first_passage"
        what = f"first passage of {self.quantity} through {self.level:g} {self.unit}".rstrip()
        (mean, error, _), (restricted, its_error) = self.mean, self.restricted_mean
        n = self.paths
        found = {
            f"{name}_mean": (mean, error, "s", f"mean time of the {what}"),
            f"{name}_restricted_mean": (restricted, its_error, "s", f"mean of the time cut off at {self.horizon:g} s"),
            f"{name}_censored": (self.share_censored, float(_share_error(self.share_censored, n)), "1",
                                 "share of the paths that have not passed by the end of the run"),
            f"{name}_at_start": (self.share_at_start, float(_share_error(self.share_at_start, n)), "1",
                                 "share of the paths beyond the level when the clock starts"),
        }  # fmt: skip
        numbers = {}
        for key, (value, se, unit, text) in found.items():
            numbers[key] = value, unit, text
            numbers[f"{key}_se"] = se, unit, f"standard error of {key}"
        return numbers

    def curve(self) -> tuple[Floats, Floats, Floats]:
        """Times, survival and its standard error, for files and pictures."""
        t = np.linspace(0.0, self.horizon, POINTS)
        return t, *self.survival(t)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What has to be said about it."""
        name, (mean, error, assumed) = f"{self.quantity}_first_passage", self.mean
        found = []
        if assumed and not mean - self.restricted_mean[0] < error:
            found.append(f"{name}: {assumed}")
        if self.share_at_start > 0.0:
            share = f"{100.0 * self.share_at_start:.2g} %"
            found.append(f"{name}: {share} of the paths were beyond the level when the clock started; their time is 0.")
        return tuple(found)


def _standard_error(samples: Floats) -> float:
    return float(samples.std(ddof=1) / math.sqrt(samples.size)) if samples.size > 1 else math.nan


def _share_error(share: npt.ArrayLike, count: int) -> Floats:
    """Standard error of a share, with one path more on either side: none of ``count`` paths is not none at all."""
    likely = (np.asarray(share, dtype=float) * count + 1.0) / (count + 2.0)
    return np.asarray(np.sqrt(likely * (1.0 - likely) / count))
