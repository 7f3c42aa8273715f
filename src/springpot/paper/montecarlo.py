"""The Monte Carlo runs behind the paper's pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from scipy import special

from springpot.machine.installed import __version__
from springpot.machine.record import Record, digest
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Springpot, WhiteNoise
from springpot.problem.system import System
from springpot.simulation import Run
from springpot.simulation.monte_carlo import simulated
from springpot.theory import averaging

ALPHAS = (0.05, 0.075, *(round(0.05 * n, 2) for n in range(2, 21)))
"""The 21 orders of Fig. 2; one extra where the curve is steepest.  At 0 there is no stationary state."""

INTENSITIES = (1.0, 5.0, 10.0)
"""q of the three curves of Fig. 2, in m^2 s^-3."""

StartKind = Literal["rest", "adapted"]
_STARTS: tuple[Literal["rest"], Literal["stationary"]] = ("rest", "stationary")  # as `run` names them


@dataclass(frozen=True)
class Point:
    """One point of Fig. 2, at C = Omega = 1; every mu is <A^2> in m^2 with A^2 = x^2 + v^2 / Omega^2.

    Parameters
    ----------
    alpha, q : float
    mu_printed, mu_corrected : float
        The paper's Eq. 20 as printed and corrected.
    mu_mc, mu_mc_se : float
        Mean over paths and over the second half of the run, from rest, as in the paper; and its standard error.
    mu_end, mu_end_se : float
        Mean over paths at the end of that run.
    mu_adapted, mu_adapted_se : float
        Mean over paths and time in a run that starts from the stationary mean, with no memory of a start.
    start_residual : float
        How far the last pilot run's mean displacement was from its x(0), over the root mean square displacement; x(0)
        was then corrected by it.  NaN where no pilot run could tell.
    """

    alpha: float
    q: float
    mu_printed: float
    mu_corrected: float
    mu_mc: float
    mu_mc_se: float
    mu_end: float
    mu_end_se: float
    mu_adapted: float
    mu_adapted_se: float
    start_residual: float


@dataclass(frozen=True)
class Estimate:
    """A number and its standard error.

    Parameters
    ----------
    value, error : float
    """

    value: float
    error: float

    @classmethod
    def of(cls, run: Run, name: str = "amplitude_mean_square") -> Estimate:
        """A result of a run by its name."""
        return cls(run[name].value, run[name].error)

    def under(self, formula: float) -> Estimate:
        """The formula over this estimate, less 1: how far the formula is too high.

        Examples
        --------
        >>> Estimate(2.0, 0.02).under(2.2)
        Estimate(value=0.10000000000000009, error=0.011000000000000001)
        """
        ratio = formula / self.value
        return Estimate(ratio - 1.0, abs(ratio) * self.error / abs(self.value))


@dataclass(frozen=True)
class Collapse:
    """How well the curves of Fig. 2, divided by q, fall on one.

    Parameters
    ----------
    chi_square : float
        Sum over the points of the squared distance from the curves' common mean, in standard errors.
    degrees : int
        Degrees of freedom.
    probability : float
        Chance of a chi-square at least as large when the curves are one.
    largest : float
        Largest distance of one point, in standard errors of that distance.
    """

    chi_square: float
    degrees: int
    probability: float
    largest: float


@dataclass(frozen=True)
class Gap:
    """The averaging formula against Monte Carlo at Omega = q = 1; all in m^2.

    Parameters
    ----------
    alpha, coefficient, formula : float
    rest, adapted : Estimate
        <A^2> with its standard error, from rest and from the adapted start.
    twice_x, twice_v : float
        2 <x^2> and 2 <v^2> / Omega^2 of the adapted run, two other readings of "amplitude".
    """

    alpha: float
    coefficient: float
    formula: float
    rest: Estimate
    adapted: Estimate
    twice_x: float
    twice_v: float


def points(
    alphas: Sequence[float] = ALPHAS,
    intensities: Sequence[float] = INTENSITIES,
    *,
    paths: int = 5000,
    duration: float = 100.0,
    step: float = 1e-3,
    seed: int = 1,
    threads: int | None = None,
    record: Record,
) -> Iterator[Point]:
    """Compute the points of Fig. 2 one after the other.

    Parameters
    ----------
    alphas, intensities : sequence of float
        Orders alpha, and noise intensities q in m^2 s^-3.
    paths : int
        Samples of each run.
    duration, step : float
        Of the run from rest, in s; its mean is over the second half.  The adapted run takes its mean over as long a
        time, after the transient, with a step ten times as long, which its scheme allows.
    seed : int
        Every run has a seed of its own, made from this one, so that all points are independent.
    threads : int, optional
        All processors by default.
    record : Record
        Points in it are not computed again, and each new one is added.

    Yields
    ------
    Point

    Notes
    -----
    Errors are those of `springpot.simulation.monte_carlo`.
    """
    seeds = iter(range(1000 * seed, 1000 * seed + 2 * len(alphas) * len(intensities)))
    for q in intensities:
        for alpha in alphas:
            settings = (alpha, q, paths, duration, step, next(seeds), next(seeds))
            yield Point(**record.of(digest([__version__, *settings]), partial(_point, *settings, threads)))


def _point(
    alpha: float, q: float, paths: int, duration: float, step: float, seed: int, seed_of_adapted: int,
    threads: int | None,
) -> dict[str, float]:  # fmt: skip
    oscillator = Oscillator(1.0, Springpot(alpha, 1.0), excitation=WhiteNoise(q))
    rest = simulated(
        oscillator, paths=paths, duration=duration, step=step, window=(duration / 2, duration), seed=seed,
        threads=threads, scheme="grunwald", start="rest",
    )  # fmt: skip
    begin = settled(oscillator, duration)
    adapted = simulated(
        oscillator, paths=paths, duration=begin + duration / 2, step=10 * step, window=(begin, begin + duration / 2),
        seed=seed_of_adapted, threads=threads, start="stationary",
    )  # fmt: skip
    return {
        "alpha": alpha,
        "q": q,
        "mu_printed": averaging(oscillator, form="printed").amplitude_mean_square,
        "mu_corrected": averaging(oscillator).amplitude_mean_square,
        "mu_mc": rest["amplitude_mean_square"].value,
        "mu_mc_se": rest["amplitude_mean_square"].error,
        "mu_end": rest["amplitude_mean_square_end"].value,
        "mu_end_se": rest["amplitude_mean_square_end"].error,
        "mu_adapted": adapted["amplitude_mean_square"].value,
        "mu_adapted_se": adapted["amplitude_mean_square"].error,
        "start_residual": adapted.diagnostics["start_residual"],
    }


def settled(oscillator: System, least: float) -> float:
    """Time after which less than 0.1 % of the transient is left, by the paper's Eq. 19; in s, at least ``least``.

    Examples
    --------
    >>> settled(Oscillator(), 10.0) > 15.0
    True
    """
    return max(least, math.ceil(math.log(1e3) / (2.0 * averaging(oscillator).decay_rate)))


def shortfall(oscillator: System, duration: float) -> float:
    """Share of the stationary <A^2> that the second half of a run from rest has not reached, by the paper's Eq. 19.

    Examples
    --------
    >>> round(shortfall(Oscillator(springpot=Springpot(0.05, 1.0)), 100.0), 3)
    0.093
    """
    result = averaging(oscillator)
    times = np.linspace(duration / 2, duration, 201)
    return 1.0 - float(np.mean(result.mean_square(times))) / result.amplitude_mean_square


def pooled(rows: Sequence[Point], start: StartKind) -> dict[float, Estimate]:
    """Mu / q for each alpha: the mean over the intensities, each with the weight of its precision.

    Examples
    --------
    >>> row = Point(0.5, 1.0, 2.0, 2.0, 2.0, 0.3, 2.0, 0.1, 2.0, 0.1, 0.0)
    >>> other = Point(0.5, 5.0, 10.0, 10.0, 11.0, 2.0, 10.0, 0.5, 10.0, 0.5, 0.0)
    >>> {alpha: (round(mu.value, 3), round(mu.error, 3)) for alpha, mu in pooled([row, other], "rest").items()}
    {0.5: (2.072, 0.24)}
    """
    estimates = {}
    for alpha in sorted({row.alpha for row in rows}):
        group = _over_q(rows, alpha, start)
        weight = math.fsum(each.error**-2 for each in group)
        estimates[alpha] = Estimate(math.fsum(each.value * each.error**-2 for each in group) / weight, weight**-0.5)
    return estimates


def _over_q(rows: Sequence[Point], alpha: float, start: StartKind) -> list[Estimate]:
    mu = "mu_mc" if start == "rest" else "mu_adapted"
    return [Estimate(*(getattr(r, name) / r.q for name in (mu, f"{mu}_se"))) for r in rows if r.alpha == alpha]


def collapse(rows: Sequence[Point], start: StartKind = "rest") -> Collapse:
    """Compare the curves of Fig. 2 with each other after dividing each by its q.

    By the scaling of the equation mu / q is one function of alpha, whatever the formula: this tests the simulation.

    Examples
    --------
    >>> row = Point(0.5, 1.0, 2.0, 2.0, 2.0, 0.1, 2.0, 0.1, 2.0, 0.1, 0.0)
    >>> other = Point(0.5, 5.0, 10.0, 10.0, 11.0, 0.5, 10.0, 0.5, 10.0, 0.5, 0.0)
    >>> round(collapse([row, other]).chi_square, 6), collapse([row, other]).degrees
    (2.0, 1)
    """
    chi_square, degrees, largest = 0.0, 0, 0.0
    for alpha, mean in pooled(rows, start).items():
        group = _over_q(rows, alpha, start)
        chi_square += math.fsum(((each.value - mean.value) / each.error) ** 2 for each in group)
        degrees += len(group) - 1
        if len(group) > 1:
            # a point pulls the common mean towards itself, which makes its distance from it smaller than its error
            far = (abs(each.value - mean.value) / math.sqrt(each.error**2 - mean.error**2) for each in group)
            largest = max(largest, *far)
    return Collapse(chi_square, degrees, float(special.chdtrc(degrees, chi_square)), largest)


def gaps(
    cases: Sequence[tuple[float, float]],
    *,
    paths: int = 4096,
    duration: float = 200.0,
    step: float = 5e-3,
    seed: int = 1,
    threads: int | None = None,
) -> Iterator[Gap]:
    """Measure how far the averaging formula is from Monte Carlo at Omega = q = 1, for pairs (alpha, C).

    Parameters
    ----------
    cases : sequence of (float, float)
        Order alpha and coefficient C.
    paths, duration, step, seed, threads
        As in `points`; the mean is over the second half of the run.

    Yields
    ------
    Gap

    Notes
    -----
    Errors are those of `springpot.simulation.monte_carlo`.
    """
    for number, (alpha, coefficient) in enumerate(cases):
        oscillator = Oscillator(1.0, Springpot(alpha, coefficient))
        rest, adapted = (
            simulated(
                oscillator, paths=paths, duration=duration, step=step, window=(duration / 2, duration),
                seed=1000 * seed + 500 + 2 * number + _STARTS.index(start), threads=threads, start=start,
            )
            for start in _STARTS
        )  # fmt: skip
        yield Gap(
            alpha=alpha,
            coefficient=coefficient,
            formula=averaging(oscillator).amplitude_mean_square,
            rest=Estimate.of(rest),
            adapted=Estimate.of(adapted),
            twice_x=2.0 * adapted["x_mean_square"].value,
            twice_v=2.0 * adapted["v_mean_square"].value,
        )
