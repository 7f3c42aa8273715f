"""The rate of first passages from which time on it is constant, with its interval; nothing is assumed to be constant
that the passages themselves contradict.

After a start the rate changes, so what passes in the first relaxation times is left out.  From then on the times of
passages, counted in time of all paths that have not passed yet, are those of a Poisson process if the rate is constant:
in that clock they are uniform.  The statistic of Cramer and von Mises tests it; if it refuses, twice as much is left
out, and so on.  The number of passages then has Poisson's law, and its interval that of the rate.

J. F. Lawless, "Statistical models and methods for lifetime data", 2nd ed., Wiley 2003 (sections 4.1 and 10.2);
R. E. Barlow and R. Campo, "Total time on test processes", in Reliability and Fault Tree Analysis, SIAM 1975.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import with_error
from springpot.simulation.paths.statistics import NORMAL, UPPER, poisson_interval

FEWEST_TESTED = 5  # passages
LEVEL = 0.01  # probability below which the test refuses
LARGEST_SHARE = 0.5  # of the run that may be left out


@dataclass(frozen=True)
class Bounded:
    """A number with its standard error and the ends of its 95 % interval.

    Attributes
    ----------
    value, error, low, high : float
        NaN if it is not known; where no event was seen, a bound.
    unit : str
    statement : str
        What it rests on, or why it is not known.

    Examples
    --------
    >>> print(Bounded(0.2, 0.05, 0.12, 0.31, "s-1"))
    0.200 +- 0.050 s-1, from 0.12 to 0.31 with 95 %
    >>> print(Bounded(0.0, 0.001, 0.0, 0.002, "s-1"))
    at most 0.002 s-1 with 95 %
    >>> print(Bounded(math.inf, math.nan, 500.0, math.inf, "s"))
    at least 5e+02 s with 95 %
    """

    value: float
    error: float
    low: float
    high: float
    unit: str = "1"
    statement: str = ""

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        if math.isnan(self.value):
            return f"not known: {self.statement}"
        if self.value == 0.0:
            return f"at most {self.high:.2g}{unit} with 95 %"
        if math.isinf(self.value):
            return f"at least {self.low:.2g}{unit} with 95 %"
        return f"{with_error(self.value, self.error, self.unit)}, from {self.low:.3g} to {self.high:.3g} with 95 %"


@dataclass(frozen=True)
class PassageRate(Bounded):
    """The constant rate of first passages.

    Attributes
    ----------
    since : float
        From which it is constant, in s from the start of the clock.
    events : int
        Passages after that.
    exposure : float
        Time after that of all paths together until they passed, in s.
    p_value : float
        Of the test that the rate is constant; NaN if there were too few passages for it.
    """

    since: float = math.nan
    events: int = 0
    exposure: float = 0.0
    p_value: float = math.nan


def rate_of(times: Floats, horizon: float, settling: float) -> PassageRate:
    """The constant rate of the passages of independent paths.

    Parameters
    ----------
    times : ndarray, shape (paths,)
        In s; infinite for a path that did not pass by the horizon.
    horizon, settling : float
        Duration of the observation, and how much of it is left out at least, in s.

    Examples
    --------
    >>> times = np.random.default_rng(1).exponential(50.0, 400)
    >>> found = rate_of(np.where(times < 20.0, times, np.inf), 20.0, 2.0)
    >>> found.events, round(found.value, 4), round(found.low, 4), round(found.high, 4), round(found.p_value, 2)
    (128, 0.0224, 0.0187, 0.0266, 0.69)
    """
    since, found = settling, PassageRate(math.nan, math.nan, math.nan, math.nan, "s-1")
    while since <= LARGEST_SHARE * horizon:
        late = np.sort(times[times > since])
        passed = late[np.isfinite(late)]
        # time of all paths together by each passage
        clock = np.cumsum(passed - since) + (late.size - 1 - np.arange(passed.size)) * (passed - since)
        exposure = float(np.sum(passed - since) + (late.size - passed.size) * (horizon - since))
        events = int(passed.size)
        if not exposure > 0.0:
            break
        p_value = uniformity(clock / exposure) if events >= FEWEST_TESTED else math.nan
        if not p_value < LEVEL:
            low, high = (end / exposure for end in poisson_interval(events))
            error = (math.sqrt(events) if events else UPPER / NORMAL) / exposure
            tested = f"a test does not contradict it, p = {p_value:.2g}"
            if events < FEWEST_TESTED:
                tested = f"{events or 'no'} passage{'s are' if events != 1 else ' is'} too few to test it"
            said = f"the rate is taken for constant after {since:.3g} s, which are left out; {tested}."
            return PassageRate(events / exposure, error, low, high, "s-1", said, since, events, exposure, p_value)
        found = replace(found, since=since, events=events, exposure=exposure, p_value=p_value)
        since *= 2.0
    if math.isinf(settling):
        said = "the motion has no stationary state, in which the rate of passages would be constant."
    elif found.events:
        tested = f"p = {found.p_value:.1g}"
        said = f"the rate of passages still changes after {found.since:.3g} s ({tested}): use a longer run."
    elif settling > LARGEST_SHARE * horizon:
        said = f"the rate of passages is constant at the earliest after {settling:.3g} s: use a run of twice that time."
    else:
        said = "no path is left after the start whose passages could be counted: use a higher level."
    return replace(found, statement=said)


def uniformity(sample: Floats) -> float:
    """Probability that a uniform sample has a larger statistic of Cramer and von Mises than this rising one.

    Notes
    -----
    The law in the limit of many, within 0.01 from five on: S. Csorgo and J. Faraway, "The exact and asymptotic
    distributions of Cramer-von Mises statistics", J. R. Stat. Soc. B 58, 1996.

    Examples
    --------
    >>> round(uniformity(np.array([0.1, 0.3, 0.5, 0.7, 0.9])), 3), round(uniformity(np.linspace(0.0, 0.3, 9)), 6)
    (0.999, 0.000241)
    """
    from scipy.special import binom, kv  # most runs need none of it

    n = sample.size
    w = 1.0 / (12.0 * n) + float(np.sum(((2.0 * np.arange(n) + 1.0) / (2.0 * n) - sample) ** 2))
    w, k = min(w, 4.0), np.arange(20)  # beyond 4 it is below 1e-8
    with np.errstate(under="ignore", divide="ignore", over="ignore"):
        z = (4.0 * k + 1.0) ** 2 / (16.0 * w)
        terms = (-1.0) ** k * binom(-0.5, k) * np.sqrt(4.0 * k + 1.0) * np.exp(-z) * kv(0.25, z)
    return float(np.clip(1.0 - np.sum(terms) / (math.pi * math.sqrt(w)), 0.0, 1.0))
