"""The spectral density of a linear system's response: of the motion itself, sampled, and seen through a window."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from springpot.fitting.likelihood import FloatArray
from springpot.fitting.motion_data import Of, window_samples
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Constant,
    Harmonic,
    KanaiTajimiNoise,
    ParametricNoise,
    PoissonImpulses,
    RecordedExcitation,
    SpectralExcitation,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.parts.excitations import Excitation
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import companion_of

__all__ = ["Density", "correlations_of_bins", "folded", "response", "windowed"]

Density = Callable[[FloatArray], FloatArray]
_FOLDS = 4
_DECADES = 20.0  # of the integral beyond the folds, in powers of e


def response(system: System, of: Of, *, sampled: bool = False) -> Density:
    """The one-sided spectral density per Hz of a linear system's stationary response.

    Parameters
    ----------
    system : System
        Without walls; linear.
    of : {"x", "v", "a"}
        ``"a"``: what an accelerometer on the mass shows, the acceleration of x plus that of the ground.
    sampled : bool
        Whether single values of it are used, so that its variance must be finite.

    Returns
    -------
    function
        Of frequencies in Hz, positive.

    Raises
    ------
    NotCoveredError
        If a part is not linear, or the excitation is not a stationary noise.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring
    >>> found = response(System(Spring(4.0), Dashpot(0.5), WhiteNoise(1.0)), "x")
    >>> found(np.array([1.0 / np.pi])).round(6).tolist()  # 2 q / (c w)^2 at resonance
    [2.0]
    """
    for name, part in system.named():
        if isinstance(part, Harmonic | ParametricNoise | RecordedExcitation):
            raise NotCoveredError(f"{name} is no stationary noise that acts on the mass: this fit does not cover it.")
    own, share = companion_of(system), system.mass / system.inertia  # of the inertia, which the ground accelerates
    noises = [part for part in system.of(Excitation) if not isinstance(part, Constant | ThermalNoise)]
    on = {"ground" if part.of_ground else "mass" for part in noises}
    if of == "a" and len(on) > 1:
        raise NotCoveredError("an acceleration with forces on the mass and of the ground together is not covered.")
    rough = [name for name, part in system.named() if isinstance(part, WhiteNoise | PoissonImpulses)]
    if of == "a" and sampled and rough and "mass" in on:
        raise NotCoveredError(
            f"the acceleration under {rough[0]} on the mass has no finite variance, so it has no samples."
        )
    if not own.noises and not own.temperature:
        raise NotCoveredError("a system without noise has no spectrum: add a WhiteNoise or another noise.")

    def density(frequency: FloatArray) -> FloatArray:
        w = 2.0 * np.pi * np.asarray(frequency, float)
        loss = own.dissipative(w)
        stiffness = own.stiffness + loss
        force: Any = np.zeros(w.shape)
        for noise in own.noises:
            force = force + _density(noise, w)
        if own.temperature > 0.0:
            force = force + own.temperature / np.pi * loss.imag / w
        found = 4.0 * np.pi * force / np.abs(stiffness - w * w) ** 2
        if of == "x":
            return np.asarray(found)
        if of == "v":
            return np.asarray(found * w**2)
        if "ground" not in on:
            return np.asarray(found * w**4)
        return np.asarray(found * np.abs((stiffness - (1.0 - share) * w**2) / share) ** 2)

    return density


def _density(noise: Any, w: FloatArray) -> Any:
    """Of a noise at many frequencies."""
    if isinstance(noise, KanaiTajimiNoise):
        return _filtered(noise, w)
    return np.vectorize(noise.density, otypes=[float])(w) if isinstance(noise, SpectralExcitation) else noise.density(w)


def _filtered(noise: KanaiTajimiNoise, w: FloatArray) -> FloatArray:
    square, damped = (w / noise.frequency) ** 2, (2.0 * noise.damping * w / noise.frequency) ** 2
    return np.asarray(noise.intensity / (2.0 * np.pi) * (1.0 + damped) / ((1.0 - square) ** 2 + damped))


def folded(density: Density, rate: float) -> Density:
    """The density of the samples: every frequency f holds f + n rate too.

    Parameters
    ----------
    density : function
        One-sided, per Hz.
    rate : float
        Samples per second.

    Returns
    -------
    function
        Of frequencies up to half of the rate.

    Notes
    -----
    Four folds are summed on each side; the sum of the rest is its integral, with the first terms of Euler's and
    Maclaurin's formula.

    Examples
    --------
    >>> found = folded(lambda f: 1.0 / (1.0 + f * f), 1.0)
    >>> found(np.array([0.25])).round(5).tolist()  # pi sinh(2 pi) / cosh(2 pi)
    [3.14157]
    """
    nodes, weights = _gauss()
    far = 0.5 * _DECADES * (nodes + 1.0)  # logarithms of frequencies beyond the last fold
    begin = (_FOLDS + 0.5) * rate

    def sampled(frequency: FloatArray) -> FloatArray:
        f = np.asarray(frequency, float)
        n = np.arange(1, _FOLDS + 1)[:, None]
        found = density(f) + (density(n * rate + f) + density(n * rate - f)).sum(axis=0)
        before, last, after = density(begin * np.array([1.0 / 1.01, 1.0, 1.01]))
        power = float(np.log(before / after) / (2.0 * np.log(1.01)))
        if not power > 1.001:
            raise NotCoveredError("the response has no finite variance, so it has no samples.")
        beyond = begin * np.exp(far)
        rest = float(0.5 * _DECADES * weights @ (density(beyond) * beyond))
        slope = -power * last / begin  # the first derivative there, and the third
        third = slope * (power + 1.0) * (power + 2.0) / begin**2
        both = 2.0 * rest - f**2 * slope - f**4 / 12.0 * third
        ends = rate * (2.0 * slope + f**2 * third) / 24.0 - 7.0 / 2880.0 * rate**3 * third
        return np.asarray(found + both / rate + ends)

    return sampled


@lru_cache
def _gauss() -> tuple[FloatArray, FloatArray]:
    nodes, weights = np.polynomial.legendre.leggauss(48)
    return nodes, weights


def windowed(sampled: Density, rate: float, window: str, segment: int, grid: int) -> FloatArray:
    """The expected periodogram at the frequencies 0, rate / segment, ... up to half of the rate.

    Parameters
    ----------
    sampled : function
        The density of the samples.
    rate : float
    window : {"boxcar", "hann"}
    segment : int
    grid : int
        Number of frequencies up to the rate at which the density is taken: so many that its correlation is short
        beside ``grid`` samples.

    Returns
    -------
    ndarray

    Notes
    -----
    The correlation of the samples times that of the window, transformed (A. M. Sykulski et al., "The debiased Whittle
    likelihood", Biometrika 106, 2019).

    Examples
    --------
    >>> windowed(np.ones_like, 1.0, "hann", 8, 64).round(12).tolist()
    [1.0, 1.0, 1.0, 1.0, 1.0]
    """
    f = np.arange(grid // 2 + 1, dtype=float) * (rate / grid)
    f[0] = 0.25 * f[1]
    correlation = np.fft.irfft(0.5 * sampled(f), grid)[:segment] * rate
    shape = window_samples(window, segment)
    twice = np.fft.rfft(shape, 2 * segment)
    own = np.fft.irfft(np.abs(twice) ** 2, 2 * segment)[:segment] / float(shape @ shape)
    product = correlation * own
    return np.asarray(2.0 / rate * (2.0 * np.fft.rfft(product).real - product[0]))


def correlations_of_bins(window: str, segment: int) -> list[float]:
    """Correlation of a periodogram with its neighbour one, two, ... bins away, for a smooth density.

    Examples
    --------
    >>> [round(number, 4) for number in correlations_of_bins("hann", 64)]
    [0.4444, 0.0278]
    """
    square = window_samples(window, segment) ** 2
    found = np.abs(np.fft.rfft(square) / square.sum()) ** 2
    return [float(number) for number in found[1:6] if number > 1e-6]
