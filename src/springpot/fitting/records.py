"""Sampled motion: the exact Gaussian likelihood."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.estimate import search
from springpot.fitting.kalman import innovations_of
from springpot.fitting.likelihood import USUAL, Coordinates, How, Table, inverse, replaced
from springpot.fitting.motion_data import MeasuredRecord
from springpot.fitting.spectra import NOISE, OfMotion, SpectrumLikelihood, check_name
from springpot.fitting.spectral_density import response
from springpot.fitting.state_space import state_space
from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, Stopped
from springpot.problem.system import System
from springpot.theory.normal_modes import modes

_GRADIENT_STEP = 0.03  # in standard errors
_HESSIAN_STEP = 0.3
_LAGS = 20
_LEAST_NOISE, _FIRST_NOISE = 1e-8, 1e-4  # over the spread of the data: its lower bound, and the least start of a search
_VAGUE = 9.0  # range of a logarithm as it is known before a search
_EVENLY, _MOST_DIGITS = 0.02, 12  # of a step, by which rounded data may be no multiples of it; of decimals
_MAY_BE_LOST = 100.0  # of the deviance: noise that explains more is found, whatever the other numbers are
_PERIODS = 5.0


class OfRecord(OfMotion):
    """Samples of which each is expected from those before."""

    smooth_start = True
    not_gaussian: str  # what it means if the innovations are not

    @abstractmethod
    def expected_and_innovations(self, theta: Floats) -> tuple[Floats, Floats]:
        """What was expected of each sample, and its difference in standard deviations."""

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """Whether the innovations are independent and Gaussian."""
        return checks_of(self.expected_and_innovations(theta)[1], moving, self.not_gaussian)

    def table(self, theta: Floats) -> Table:
        """Samples, and what was expected from those before."""
        names = [f"path {k}" for k in range(self.data.paths)]
        return Table.of_record(self.data.time, names, self.data.values, *self.expected_and_innovations(theta))


class RecordLikelihood(OfRecord):
    """Samples of one path or of several, with the whole of their correlation.

    Parameters
    ----------
    system : System
        Linear, without walls, under Gaussian noise, with free numbers.
    data : MeasuredRecord
    how : How
        Its seed is that of the search in the spectrum of the record, from which the search in the record starts.
    """

    not_gaussian = "the motion is not Gaussian: a wall, a nonlinear part or impulses"

    def __init__(self, system: System, data: MeasuredRecord, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self._duration = float(data.time[-1] - data.time[0])
        self.coordinates = Coordinates(with_noise(self.coordinates.free, data))
        of, at = data.channel
        response(system, of, at=at, sampled=True)  # what a record cannot be of is an error before any work
        _check_length(system, data)
        self._filtered(self.coordinates.given)
        without_leakage = replace(data.spectrum(), window=None, segment=None)  # as good for a start, and quicker
        self._spectrum = SpectrumLikelihood(system, without_leakage, how)
        self.coordinates = self._from_spectrum()

    def _from_spectrum(self) -> Coordinates:
        """Those of the same numbers, which start where the spectrum has them."""
        own, free = self._spectrum.coordinates, self.coordinates.free
        if not own.free:
            return self.coordinates
        theta = own.outer(search(self._spectrum, self.how.seed).u)
        if self.data.noise is None:
            theta[-1] = max(np.sqrt(theta[-1] / (2.0 * self.data.step)), _FIRST_NOISE * float(free[-1].high))
        return self.coordinates.moved(theta)

    def _filtered(self, theta: Floats) -> tuple[float, Floats, Floats]:
        """-2 ln L, the innovations in standard deviations, and these."""
        (system, noise), (of, at) = self.model_at(theta), self.data.channel
        sampled = state_space(system, of, self.data.step, self._duration, at)
        return innovations_of(sampled, noise, self.data.values)

    def misfit(self, theta: Floats) -> float:
        """-2 ln L of the record."""
        return self._filtered(theta)[0]

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """Whether it was stopped, and where its errors come from then."""
        return tuple(f"{said[:-1]}, with errors as the spectrum has them." for said in super().doubts(theta))

    def lost(self, u: Floats, deviance: float) -> NDArray[np.bool_]:
        """Measurement noise, where the data agree about as well with none."""
        found = np.zeros(u.size, bool)
        if self.data.noise is None and not self.stopped:
            without = u.copy()
            without[-1] = self.coordinates.low[-1]
            found[-1] = self.deviance(self.coordinates.outer(without)) < deviance + _MAY_BE_LOST
        return found

    def at_bound(self, name: str, end: str, value: float) -> str:
        """One sentence about a number that is held."""
        if name != NOISE or self.data.noise is not None or end != "low":
            return super().at_bound(name, end, value)
        return (
            f"The measurement noise cannot be found, because the data agree as well with none: it is fixed at "
            f"{value:.2g}, {'the' if rounding_of(self.data.values) else 'far below any'} rounding of the data, and the "
            "errors of the others hold for this value."
        )

    def _information(self, theta: Floats) -> Floats:
        """Of the coordinates, as the spectrum has it: each periodogram of Welch's average counts once."""
        inner = theta.copy()
        if self.data.noise is None:
            least = self._spectrum.coordinates.free[-1].low  # below it there are no differences
            inner[-1] = max(2.0 * self.data.step * theta[-1] ** 2, least)
        own = self._spectrum.sensitivity(inner) * self._spectrum.coordinates.slope(inner)
        if self.data.noise is None:
            own[:, -1] *= 2.0  # of the standard deviation, not of the density
        return np.asarray(own.T @ own)

    def _whitening(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        """A matrix that gives the numbers that move in units of about one independent standard error."""
        own = self.coordinates
        known = np.where(own.logarithmic, np.minimum(own.high - own.low, _VAGUE), own.high - own.low)
        whole = self._information(own.outer(u)) + np.diag(4.0 / known**2)
        return np.asarray(np.linalg.cholesky(inverse(whole[np.ix_(moves, moves)])))

    def solve(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """By BFGS in units of the standard errors; by L-BFGS-B where a bound is near."""
        from scipy import optimize

        minimize: Any = optimize.minimize
        own = self.coordinates
        low, high = own.low, own.high
        root = self._whitening(begin, moves)
        centre = begin[moves]

        def place(w: Floats) -> Floats:
            return replaced(begin, moves, centre + root @ w)

        def misfit_at(u: Floats) -> float:
            return min(0.5 * self.deviance(own.outer(u)), 1e15)

        def misfit(w: Floats) -> float:
            u = place(w)
            inside = np.clip(u, low, high)
            return misfit_at(inside) + 1e3 * float(np.sum(((u - inside) / (high - low)) ** 2))  # leads back inside

        steps = _GRADIENT_STEP * np.eye(centre.size)

        def gradient(w: Floats) -> Floats:
            return np.array([(misfit(w + step) - misfit(w - step)) / (2.0 * _GRADIENT_STEP) for step in steps])

        found = minimize(
            misfit, np.zeros(centre.size), jac=gradient, method="BFGS",
            options={"gtol": 2e-3, "maxiter": 60},
        )  # fmt: skip
        u = place(found.x)
        near = 1e-3 * (high - low)
        if ((u > low + near) & (u < high - near))[moves].all():
            return u
        size = np.sqrt(np.diag(root @ root.T))
        bounds = [*zip((low[moves] - centre) / size, (high[moves] - centre) / size, strict=True)]

        def place_by_each(w: Floats) -> Floats:
            return np.clip(replaced(begin, moves, centre + size * w), low, high)

        found = minimize(
            lambda w: misfit_at(place_by_each(w)), np.clip((u[moves] - centre) / size, *np.array(bounds).T),
            method="L-BFGS-B", jac="3-point", bounds=bounds,
            options={"maxiter": 100, "ftol": 1e-10, "finite_diff_rel_step": 1e-4},
        )  # fmt: skip
        return place_by_each(found.x)

    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """From second differences of the likelihood; from the spectrum if stopped, or where a number is at a bound."""
        own = self.coordinates
        u = own.inner(theta)
        whole = self._information(theta)
        root = self._whitening(u, moves)
        reach = 2.0 * _HESSIAN_STEP * np.sqrt(np.diag(root @ root.T))
        at = u[moves]
        if self.stopped or (at - reach < own.low[moves]).any() or (at + reach > own.high[moves]).any():
            return inverse(whole[np.ix_(moves, moves)])

        def misfit(w: Floats) -> float:
            return 0.5 * self.deviance(own.outer(replaced(u, moves, at + root @ w)))

        try:
            hessian = _hessian(misfit, at.size)
        except Stopped:
            return inverse(whole[np.ix_(moves, moves)])
        if not np.isfinite(hessian).all() or not (np.linalg.eigvalsh(hessian) > 0.0).all():
            return inverse(whole[np.ix_(moves, moves)])
        return np.asarray(root @ inverse(hessian) @ root.T)

    def expected_and_innovations(self, theta: Floats) -> tuple[Floats, Floats]:
        """By the filter."""
        _, innovations, spread = self._filtered(theta)
        return self.data.values - spread * innovations, innovations


def with_noise(free: tuple[Free, ...], data: MeasuredRecord, least: float = 0.0) -> tuple[Free, ...]:
    """The free numbers, with that of the measurement, at least so large, where it is not stated."""
    if data.noise is not None:
        return free
    check_name(free)
    spread = float(data.values.std())
    return (*free, Free(0.05 * spread, NOISE, max(rounding_of(data.values), _LEAST_NOISE * spread, least), spread))


def checks_of(innovations: Floats, moving: int, meaning: str) -> dict[str, tuple[float, str]]:
    """Whether innovations in standard deviations are independent and Gaussian, and what it means if they are not."""
    from scipy import stats

    count, size = innovations.shape[1], innovations.size
    lags = np.arange(1, min(_LAGS, count // 4) + 1)
    rows = innovations / np.sqrt(np.mean(innovations**2))
    shares = np.array([np.sum(rows[:, k:] * rows[:, :-k]) for k in lags]) / size
    box = size * float(np.sum(shares**2 * count / (count - lags)))
    odd, even = float(stats.skew(rows, axis=None)), float(stats.kurtosis(rows, axis=None))
    shape = size * (odd**2 / 6.0 + even**2 / 24.0)
    return {
        "order of the innovations (Ljung and Box)": (
            float(stats.chi2.sf(box, max(lags.size - moving, 1))),
            "the model does not explain how samples follow each other",
        ),
        "distribution of the innovations (Jarque and Bera)": (float(stats.chi2.sf(shape, 2)), meaning),
    }


def rounding_of(values: Floats) -> float:
    """Standard deviation of the rounding of data, to decimals or to the steps of a converter; 0 if none is seen.

    Examples
    --------
    >>> round(rounding_of(np.array([0.1, 0.4, 0.21, 0.9])) * 12.0**0.5, 12), rounding_of(np.sin(np.arange(99.0)))
    (0.01, 0.0)
    """
    gaps = np.diff(np.unique(values))
    first = -int(np.floor(np.log10(np.abs(values).max())))
    decimals = ((float(10.0**-places), values) for places in range(first, first + _MOST_DIGITS))
    for step, numbers in ((float(gaps.min()), gaps), *decimals):
        if (np.abs(numbers / step - np.rint(numbers / step)) < _EVENLY).all():
            return float(step / 12.0**0.5)
    return 0.0


def _check_length(system: System, data: MeasuredRecord) -> None:
    """Samples must be frequent and long enough to see the motion that the model has at its start."""
    own = modes(system).frequencies
    frequency = float(own[own > 0.0].min(initial=np.inf)) / (2.0 * np.pi)
    if math.isinf(frequency):
        raise NotCoveredError("model must have a spring that holds the mass for a record: fit data.spectrum() instead.")
    rate, duration = 1.0 / data.step, float(data.time[-1] - data.time[0])
    if frequency > 0.5 * rate:
        raise ValueError(f"data must have more than two samples in a period of the model: its natural frequency is "
                         f"{frequency:.4g} Hz, the sampling rate {rate:.4g} Hz.")  # fmt: skip
    if duration * frequency < _PERIODS:
        raise ValueError(f"data must last at least {_PERIODS:g} periods of the model: its natural frequency is "
                         f"{frequency:.4g} Hz, the record lasts {duration:.4g} s.")  # fmt: skip


def _hessian(function: Callable[[Floats], float], size: int) -> Floats:
    """Second central differences about 0."""
    steps = _HESSIAN_STEP * np.eye(size)
    middle = function(np.zeros(size))
    found = np.empty((size, size))
    for i in range(size):
        found[i, i] = function(steps[i]) - 2.0 * middle + function(-steps[i])
        for j in range(i):
            corners = [a * b * function(a * steps[i] + b * steps[j]) for a in (1, -1) for b in (1, -1)]
            found[i, j] = found[j, i] = sum(corners) / 4.0
    return found / _HESSIAN_STEP**2
