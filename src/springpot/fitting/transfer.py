"""Measured frequency responses beside those of linear systems, in closed form with their derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.likelihood import Coordinates, FloatArray, LeastSquares, Table
from springpot.fitting.moduli import complex_modulus, slopes_by_name
from springpot.problem.free_numbers import free_numbers, restarted
from springpot.problem.parts.registration import Slopes
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import companion_of

__all__ = ["ResponseLikelihood", "response_of"]

ComplexArray = NDArray[np.complex128]


def response_of(system: System, frequency_hz: FloatArray, of: str, on: str) -> tuple[ComplexArray, Slopes]:
    """The response, and the derivative of its logarithm by each number that enters.

    Parameters
    ----------
    system : System
        Linear, without walls.
    frequency_hz : ndarray, shape (n,)
    of : {"x", "v", "a"}
    on : {"mass", "ground"}

    Raises
    ------
    NotCoveredError
        If there is a wall, or something nonlinear.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Mass, Spring
    >>> device = System(Mass(2.0), Spring(8.0), Dashpot(0.4))
    >>> found, _ = response_of(device, np.array([1.0 / np.pi]), "x", "mass")
    >>> bool(abs(found[0] + 1.25j) < 1e-12)
    True
    """
    companion_of(system)  # refuses what it does not cover
    mass, power = system.mass, {"x": 0, "v": 1, "a": 2}[of]
    p = np.asarray(2j * np.pi * frequency_hz, complex)
    modulus, slopes = complex_modulus(system, frequency_hz)
    whole = modulus + system.inertia * p**2
    slopes += [(part.inertia, p**2) for part in system.parts if part.inertia]
    share: Any = 0.0  # of the slopes of the whole, in those of the numerator
    of_mass: Any = 0.0
    if on == "mass":
        response = p**power
    elif of == "a":  # of the mass itself: the ground moves the other end of all parts but it
        response = modulus + (system.inertia - mass) * p**2
        share, of_mass = 1.0 / response, -(p**2) / response
    else:
        response, of_mass = -mass * p**power, 1.0 / mass
    found = [(number, slope * share - slope / whole) for number, slope in slopes]
    return np.asarray(response / whole), [*found, (mass, of_mass)]


class ResponseLikelihood(LeastSquares):
    """Magnitudes and phases of a frequency response.

    Parameters
    ----------
    system : System
        Linear, without walls, with free numbers.
    data : MeasuredFrequencyResponse

    Raises
    ------
    ValueError
        If a free number has no influence.

    Notes
    -----
    The error of a measured response H (1 + z) is complex, with parts of equal variance.  The residuals are the real and
    the imaginary part of ln(1 + z).  Its mean is that of z, 0, whatever the size of z is, because the logarithm is
    analytic (but for values beyond |z| = 1): the estimates are not biased by it.
    """

    def __init__(self, system: System, data: MeasuredFrequencyResponse) -> None:
        self.system, self.data = system, data
        self.coordinates = Coordinates(tuple(free_numbers(system).values()))
        self.size = data.size
        self.known = data.errors is not None
        self._unit = np.ones(data.size) if data.errors is None else np.tile(data.errors, 2)

    def _at(self, system: System) -> tuple[ComplexArray, Slopes]:
        return response_of(system, self.data.frequency_hz, self.data.of, self.data.on)

    def _expected(self, theta: FloatArray) -> ComplexArray:
        return self._at(restarted(self.system, self.coordinates.named(theta)))[0]

    def residuals(self, theta: FloatArray) -> FloatArray:
        """Logarithms of the ratios of the magnitudes, then differences of the phases."""
        ratio = self.data.response / self._expected(theta)
        return np.asarray(np.concatenate([np.log(np.abs(ratio)), np.angle(ratio)]) / self._unit)

    def sensitivity(self, theta: FloatArray) -> FloatArray:
        """Change of the logarithm of the response, in its standard deviations."""
        _, slopes = self._at(restarted(self.system, self.coordinates.named(theta)))
        matrix = slopes_by_name(slopes, self.coordinates.names, self.data.response.size)
        return np.asarray(np.concatenate([matrix.real, matrix.imag]) / self._unit[:, None])

    def constant(self) -> float:
        """Of the errors, where they are known."""
        return float(2.0 * np.log(self._unit).sum() + self.size * np.log(2.0 * np.pi))

    def table(self, theta: FloatArray) -> Table:
        """Magnitude and phase against frequency."""
        data, found = self.data.response, self._expected(theta)
        count = data.size
        return Table(
            "frequency_hz", "Hz", np.tile(self.data.frequency_hz, 2), np.repeat(["magnitude", "phase"], count),
            np.concatenate([np.abs(data), np.angle(data)]),
            np.concatenate([np.abs(found), np.angle(data) - np.angle(data / found)]),
            self.residuals(theta) / self.scatter(theta, len(self.coordinates.free)) ** 0.5,
        )  # fmt: skip
