"""The spectrum of x, estimated in the run: one windowed Fourier sum for each path and frequency.

The whole window of a path is one segment with a Hann taper.  The mean is subtracted, and the periodograms of the paths
are averaged; standard errors come from independent paths.  The estimate is the density averaged over frequencies with a
root mean square width of ``resolution`` = sqrt(4/3) pi / length, which lowers a Lorentzian peak of half-width g by
about (resolution / g)^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_number
from springpot.simulation.kernel.cache import callback
from springpot.simulation.kernel.lanes import GROUP, LANES
from springpot.simulation.kernel.watching import HEADER, ON_STEPS, Observer
from springpot.simulation.plan.seen import Seen
from springpot.simulation.plan.settings import Settings
from springpot.simulation.watch.distributions import observer_of

__all__ = ["Spectrum", "checked_frequencies", "spectral", "spectrum_in"]

Floats = npt.NDArray[np.float64]

MOST_SUMS = 30_000_000  # stored numbers, 0.24 GB; evaluation needs about four times as much
SAMPLES_PER_CYCLE = 12  # of the fastest rate and the highest frequency, against aliasing
FEWEST_CYCLES = 2.0  # of the lowest frequency in the window


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Two-sided spectral density of a displacement about its mean.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        In rad/s.
    density, standard_error : ndarray, shape (n,)
        In m^2 s per rad: the integral of the density over all frequencies, negative ones too, is the variance of x.
    resolution : float
        Each value is an average over frequencies with this root mean square width, in rad/s.
    """

    frequency: Floats
    density: Floats
    standard_error: Floats
    resolution: float


def checked_frequencies(frequencies: npt.ArrayLike, settings: Settings, fastest: float, spectra: int) -> Floats:
    """The frequencies of so many spectra as an array; ``fastest`` is the fastest rate of the problem, in 1/s.

    Raises
    ------
    TypeError, ValueError
        If they are not positive numbers, too many, too high for the step or too low for the window.
    """
    try:
        given = [finite_number(w, "spectrum frequency", low=0.0, high=LARGEST, open_low=True) for w in frequencies]  # type: ignore[union-attr]
    except TypeError as reason:
        raise TypeError(f"spectrum must be a sequence of frequencies in rad/s: {reason}") from reason
    if not given:
        raise ValueError("spectrum must hold at least one frequency.")
    values = np.array(given)
    if (3 * values.size + 1) * settings.paths * spectra > MOST_SUMS:
        most = MOST_SUMS // (3 * settings.paths * spectra)
        raise ValueError(
            f"spectrum must hold at most {most} frequencies for {settings.paths} paths, not {values.size}."
        )
    length = settings.window[1] - settings.window[0]
    if (lowest := float(values.min())) * length < FEWEST_CYCLES * 2.0 * math.pi:
        raise ValueError(
            f"spectrum goes down to {lowest:g} rad/s, too low for a window of {length:g} s: use a window of at least "
            f"{FEWEST_CYCLES * 2.0 * math.pi / lowest:.3g} s."
        )
    if (highest := max(float(values.max()), fastest)) * GROUP * settings.step > 2.0 * math.pi / SAMPLES_PER_CYCLE:
        raise ValueError(
            f"spectrum has to resolve {highest:g} rad/s, too fast for a step of {settings.step:g} s: use a step of "
            f"at most {2.0 * math.pi / SAMPLES_PER_CYCLE / GROUP / highest:.2g} s."
        )
    return values


def spectral(seen: Seen, frequencies: Floats, settings: Settings, fastest: float) -> Observer:
    """Fourier sums of each path at frequencies in rad/s."""
    spacing = 2.0 * math.pi / (SAMPLES_PER_CYCLE * max(float(frequencies.max()), fastest))
    every = max(1, int(spacing / (GROUP * settings.step)))
    turns = np.repeat(frequencies * settings.step, LANES)  # of one step
    initial = np.concatenate([turns, np.zeros((2 * frequencies.size + 1) * LANES)])
    return observer_of(seen, _spectral_part(frequencies.size), None, initial, every=every)


@cache
def _spectral_part(count: int) -> Any:
    first = len(HEADER)
    cosines, sines, weighed = first + count * LANES, first + 2 * count * LANES, first + 3 * count * LANES

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        if low <= n < high:
            taper = math.sin(math.pi * (n + 0.5 - low) / (high - low)) ** 2
            scale = taper * array[0]
            for lane in range(LANES):
                array[weighed + lane] += scale * x[lane]
            for k in range(count):
                angle = array[first + k * LANES] * (n + 1.0)
                c, s = scale * math.cos(angle), scale * math.sin(angle)
                for lane in range(LANES):
                    array[cosines + k * LANES + lane] += c * x[lane]
                    array[sines + k * LANES + lane] -= s * x[lane]

    return on_steps


def spectrum_in(frequencies: Floats, settings: Settings, sums: Floats, every: int) -> Spectrum:
    """The spectrum from the sums of `spectral`.

    Parameters
    ----------
    sums : ndarray, shape (paths, 3 * n + 1)
    every : int
        Groups of steps between two samples.
    """
    count, spacing = frequencies.size, GROUP * every
    low, high = settings.window_steps
    n = np.arange(low // GROUP * GROUP, high, spacing)
    n = n[n >= low]
    taper = np.sin(np.pi * (n + 0.5 - low) / (high - low)) ** 2
    turned = np.exp(-1j * np.outer(n + 1.0, frequencies * settings.step)).T @ taper
    paths = sums[:, count : 2 * count] + 1j * sums[:, 2 * count : 3 * count]
    mean = sums[:, -1].mean() / taper.sum()  # over all paths: the mean of one path contains its slow motion
    periodograms = np.abs(paths - mean * turned) ** 2
    periodograms *= spacing * settings.step / (2.0 * np.pi * (taper**2).sum())
    error = np.full(count, np.nan)
    if len(sums) > 1:
        error = periodograms.std(axis=0, ddof=1) / math.sqrt(len(sums))
    resolution = math.sqrt(4.0 / 3.0) * math.pi / ((high - low) * settings.step)
    return Spectrum(frequencies, periodograms.mean(axis=0), error, resolution)
