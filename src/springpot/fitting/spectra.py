"""Spectral densities of a response: Whittle's likelihood."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.fitting.estimate import search
from springpot.fitting.likelihood import USUAL, Coordinates, GammaSquares, How, Likelihood, slopes
from springpot.fitting.motion_data import MeasuredSpectrum
from springpot.fitting.spectral_density import Density, correlations_of_bins, folded, response, windowed
from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import restarted
from springpot.problem.system import System

NOISE = "noise"
"""Name of the measurement noise that is found with the rest."""

_LARGEST_GRID = 2**20


def check_name(free: tuple[Free, ...]) -> None:
    """No number of the model may have the name of the noise that is found with it.

    Raises
    ------
    ValueError
        If one has.
    """
    if NOISE in {number.name for number in free}:
        raise ValueError(f"{NOISE} must not be the name of a free number of the model: the measurement noise has it.")


class OfMotion(Likelihood):
    """Data of a motion, whose measurement has a noise that is stated, or found with the numbers of the model."""

    def model_at(self, theta: Floats) -> tuple[System, float]:
        """The model with these numbers, and the noise."""
        named = self.coordinates.named(theta)
        noise = named.pop(NOISE) if self.data.noise is None else self.data.noise
        return restarted(self.system, named), noise


class SpectrumLikelihood(OfMotion, GammaSquares):
    """Averages of periodograms: gamma distributed about the expected one.

    Parameters
    ----------
    system : System
        Linear, without walls, with free numbers.
    data : MeasuredSpectrum
    how : How
        Its seed is that of the search without leakage, from which that with leakage starts.

    Notes
    -----
    P. Whittle, "Estimation and information in stationary time series", Arkiv för Matematik 2 (1953).
    """

    def __init__(self, system: System, data: MeasuredSpectrum, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        free = self.coordinates.free
        if data.noise is None:
            check_name(free)
            low, high = float(data.density.min()), float(data.density.max())
            free = (*free, Free(0.5 * low, NOISE, 1e-4 * low, high))
        self.coordinates = Coordinates(free)
        self.values, self.certainty = data.density, data.averages**0.5
        self.at, self.group = data.frequency_hz, np.full(data.size, "density")
        self._grid = 0
        if data.window is not None and free:
            rough = SpectrumLikelihood(system, replace(data, window=None, segment=None), how)
            theta = rough.coordinates.outer(search(rough, how.seed).u)
            self.coordinates = self.coordinates.moved(theta)
            self.smooth_start = True
        self.expected(self.coordinates.given)

    def expected(self, theta: Floats) -> Floats:
        """The density, as it was measured."""
        (system, noise), data = self.model_at(theta), self.data
        density = response(system, data.of, at=data.at, sampled=data.sampling_rate is not None)
        if data.sampling_rate is None:
            return density(data.frequency_hz) + noise
        density = folded(density, data.sampling_rate)
        if data.window is None or data.segment is None:
            return density(data.frequency_hz) + noise
        if not self._grid:
            self._grid = _grid(density, data.sampling_rate, data.segment)
        found = windowed(density, data.sampling_rate, data.window, data.segment, self._grid)
        places = np.round(data.frequency_hz * data.segment / data.sampling_rate).astype(int)
        return np.asarray(np.maximum(found[places], 1e-12 * found.max()) + noise)

    def sensitivity(self, theta: Floats) -> Floats:
        """Relative change of the density, in its standard deviations."""
        return np.asarray(self.certainty * slopes(lambda t: np.log(self.expected(t)), theta, self.coordinates.free))

    def constant(self) -> float:
        """0: only models of the same spectrum are compared."""
        return 0.0

    def spread(self, sensitivity: Floats) -> Floats:
        """From both sides of the information where the window correlates neighbouring points."""
        whole, data = super().spread(sensitivity), self.data
        if data.window is None or data.segment is None or data.sampling_rate is None:
            return whole
        found = sensitivity.T @ sensitivity
        places = np.round(data.frequency_hz * data.segment / data.sampling_rate).astype(int)
        at = np.full((places[-1] + 8, sensitivity.shape[1]), 0.0)
        at[places] = sensitivity
        for lag, share in enumerate(correlations_of_bins(data.window, data.segment), start=1):
            both = share * at[:-lag].T @ at[lag:]
            found = found + both + both.T
        return np.asarray(whole @ found @ whole)

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """As for independent points; where the window correlates them, with fewer degrees of freedom."""
        from scipy import stats

        if self.data.window is None or self.data.segment is None:
            return super().checks(theta, moving)
        shares = correlations_of_bins(self.data.window, self.data.segment)
        count = (self.size - moving) / (1.0 + 2.0 * sum(share**2 for share in shares))
        chi = float(np.mean(self.pearson(theta) ** 2)) * self.size / (self.size - moving) * count
        meaning = "the model misses more than the scatter of the periodograms explains"
        return {"size of the residuals (chi-square)": (float(stats.chi2.sf(chi, count)), meaning)}


def _grid(density: Density, rate: float, segment: int) -> int:
    """So many points that the correlation has died away: twice those that are enough at the start."""

    grid = 1 << (max(2 * segment, 512) - 1).bit_length()
    while grid < _LARGEST_GRID // 4:
        f = np.arange(grid // 2 + 1, dtype=float) * (rate / grid)
        f[0] = 0.25 * f[1]
        correlation = np.fft.irfft(density(f), grid)
        if np.abs(correlation[grid // 4 : grid // 2]).max() < 1e-3 * correlation[0]:
            break
        grid *= 2
    return 2 * grid
