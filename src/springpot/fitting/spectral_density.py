"""The spectral density of a linear system's response: of the motion itself, sampled, and seen through a window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from springpot.fitting.motion_data import is_output, window_samples
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.coordinates import product_of
from springpot.problem.parts import (
    Harmonic,
    ParametricNoise,
    RecordedExcitation,
    SpectralExcitation,
)
from springpot.problem.parts.excitations import GroundNoise
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import companion_of
from springpot.theory.methods.systems.outputs import output_spectrum

Density = Callable[[Floats], Floats]
_FOLDS = 4
_DECADES = 20.0  # of the integral beyond the folds, in powers of e
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def response(system: System, of: str, *, at: str | None = None, sampled: bool = False) -> Density:
    """The one-sided spectral density per Hz of a linear system's stationary response.

    Parameters
    ----------
    system : System
        Without walls; linear.
    of : str
        ``"x"``, ``"v"``, or a force or acceleration by its name.
        ``"a"``: what an accelerometer on the mass shows, the acceleration of x plus that of the ground.
    at : str or None
        The mass, where there are several.
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
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> found = response(System(Spring(4.0), Dashpot(0.5), WhiteNoise(1.0)), "x")
    >>> found(np.array([1.0 / np.pi])).round(6).tolist()  # 2 q / (c w)^2 at resonance
    [2.0]
    """
    for name, part in system.named():
        if isinstance(part, Harmonic | ParametricNoise | RecordedExcitation):
            raise NotCoveredError(f"{name} is no stationary noise that acts on the mass: this fit does not cover it.")
    own = companion_of(system)
    if not own.noises and not own.temperature:
        raise NotCoveredError("a system without noise has no spectrum: add a WhiteNoise or another noise.")
    if is_output(of):
        output = output_spectrum(system, own, of)
        return lambda frequency: 4.0 * np.pi * output(2.0 * np.pi * np.asarray(frequency, float))
    seen_by, coordinates = row_of(system, at), system.coordinates
    if of == "a" and len({part.of_ground for part in system.noises.values()}) > 1:
        raise NotCoveredError("an acceleration with forces on the mass and of the ground together is not covered.")
    rough = [
        name for name, part in system.excitations.items()
        if part.is_white and not part.of_ground
        and product_of(seen_by, coordinates.accelerations(coordinates.forces[name]))
    ]  # fmt: skip
    if of == "a" and sampled and rough:
        raise NotCoveredError(
            f"the acceleration under {rough[0]} on the mass has no finite variance, so it has no samples."
        )
    temperature = system.temperature

    def density(frequency: Floats) -> Floats:
        w = 2.0 * np.pi * np.asarray(frequency, float).ravel()
        p, power = np.asarray(1j * w, complex), w ** {"x": 0, "v": 2, "a": 4}[of]
        seen = own.displaced(w, seen_by)
        found: Any = np.zeros(p.shape)
        for name, part in system.noises.items():
            spread = _density(part, w)
            if of == "a" and part.of_ground:  # of the mass itself
                found = found + spread * np.abs(np.sum(seen * held_by(system, p), axis=1)) ** 2
            else:
                found = found + spread * np.abs(seen @ coordinates.forces[name]) ** 2 * power
        for name, row in coordinates.elongations.items() if temperature > 0.0 else ():
            loss = np.imag(dict(system.named())[name].modulus(p)) / w
            found = found + temperature / np.pi * loss * np.abs(seen @ row) ** 2 * power
        return np.asarray(4.0 * np.pi * found).reshape(np.shape(frequency))

    return density


def _density(noise: Any, w: Floats) -> Any:
    """Of a noise at many frequencies."""
    one_by_one = isinstance(noise, GroundNoise | SpectralExcitation)
    return np.vectorize(noise.density, otypes=[float])(w) if one_by_one else noise.density(w)


def row_of(system: System, point: str | None, name: str = "at") -> Floats:
    """How a point moves with the coordinates; ``name`` is the argument that has it.

    Raises
    ------
    ValueError
        If it is none of them, or not given where there are several.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> row_of(System(Spring(1.0)), None).tolist()
    [1.0]
    """
    rows = system.coordinates.called
    if (point or "") in rows:
        return rows[point or ""]
    known = listed([repr(each) for each in system.points], "or")
    raise ValueError(f"{name} of the data must be {known}, not {point!r}.")


def held_by(system: System, p: Complexes) -> Complexes:
    """The forces of parts where all is moved alike against the ground, shape (n, coordinates).

    They are what the ground's displacement does to the masses' own one.
    """
    alike = system.coordinates.participations
    found = np.zeros((p.size, alike.size), complex)
    for row, modulus in moduli(system, p).values():
        found += modulus[:, None] * row * float(row @ alike)
    return found


def moduli(system: System, p: Complexes) -> dict[str, tuple[Floats, Complexes]]:
    """The row of each part with two ends, and its force per elongation, with that of its inertia, by its name.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot
    >>> moduli(System(Dashpot(0.5)), np.array([2j]))
    {'dashpot': (array([1.]), array([0.+1.j]))}
    """
    return {
        name: (system.coordinates.elongations[name], part.modulus(p) + part.inertia * p**2 + np.zeros_like(p))
        for name, part in system.elements.items()
    }


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
    far = 0.5 * _DECADES * (_NODES + 1.0)  # logarithms of frequencies beyond the last fold
    begin = (_FOLDS + 0.5) * rate

    def sampled(frequency: Floats) -> Floats:
        f = np.asarray(frequency, float)
        n = np.arange(1, _FOLDS + 1)[:, None]
        found = density(f) + (density(n * rate + f) + density(n * rate - f)).sum(axis=0)
        before, last, after = density(begin * np.array([1.0 / 1.01, 1.0, 1.01]))
        power = float(np.log(before / after) / (2.0 * np.log(1.01)))
        if not power > 1.001:
            raise NotCoveredError("the response has no finite variance, so it has no samples.")
        beyond = begin * np.exp(far)
        rest = float(0.5 * _DECADES * _WEIGHTS @ (density(beyond) * beyond))
        slope = -power * last / begin  # the first derivative there, and the third
        third = slope * (power + 1.0) * (power + 2.0) / begin**2
        both = 2.0 * rest - f**2 * slope - f**4 / 12.0 * third
        ends = rate * (2.0 * slope + f**2 * third) / 24.0 - 7.0 / 2880.0 * rate**3 * third
        return np.asarray(found + both / rate + ends)

    return sampled


def windowed(sampled: Density, rate: float, window: str, segment: int, grid: int) -> Floats:
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
