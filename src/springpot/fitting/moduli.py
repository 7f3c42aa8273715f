"""The complex modulus of linear parts, with its derivatives, beside measured moduli."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.likelihood import Coordinates, FloatArray, LeastSquares, Table, gamma_residuals, gamma_slope
from springpot.fitting.part_data import MeasuredModuli
from springpot.machine.arguments import Free
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.free_numbers import free_numbers, restarted
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import (
    Dashpot,
    FractionalMaxwell,
    Maxwell,
    PiezoelectricCircuit,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
)
from springpot.problem.system import System

__all__ = ["ModuliLikelihood", "complex_modulus"]

ComplexArray = NDArray[np.complex128]
Slopes = list[tuple[float, Any]]

_LINEAR = (
    Spring,
    PolynomialSpring,
    Dashpot,
    PolynomialDashpot,
    Springpot,
    FractionalMaxwell,
    Maxwell,
    PiezoelectricCircuit,
)


def complex_modulus(model: System | Oscillator, frequency_hz: FloatArray) -> tuple[ComplexArray, Slopes]:
    """Storage + i loss of springs, dampers, memory and circuits, without the inertia of the mass.

    Parameters
    ----------
    model : System or Oscillator
    frequency_hz : ndarray, shape (n,)

    Returns
    -------
    modulus : ndarray of complex, shape (n,)
    slopes : list of (number, derivative)
        Of each number that enters.

    Raises
    ------
    NotCoveredError
        If a spring or a damper is not linear.

    Examples
    --------
    >>> found, _ = complex_modulus(System(Spring(2.0), Dashpot(0.5)), np.array([1.0]))
    >>> found.round(3)
    array([2.+3.142j])
    """
    p = np.asarray(2j * np.pi * frequency_hz, complex)
    total = np.zeros(frequency_hz.size, complex)
    slopes: Slopes = []
    for modulus, own in _contributions(model, p):
        total = total + modulus
        slopes += own
    return total, slopes


def _contributions(model: System | Oscillator, p: ComplexArray) -> Iterator[tuple[Any, Slopes]]:
    if isinstance(model, Oscillator):
        w = model.natural_frequency
        yield w * w, [(w, 2.0 * w)]
        yield _of_part(model.springpot, p)
        return
    for name, part in model.named():
        if isinstance(part, PolynomialSpring | PolynomialDashpot) and not part.is_linear:
            raise NotCoveredError(f"the modulus of a linear system is needed, but {name} is not linear.")
        if isinstance(part, _LINEAR):
            yield _of_part(part, p)


def _of_part(part: Any, p: ComplexArray) -> tuple[Any, Slopes]:
    """Modulus of a part, and its derivatives by its numbers."""
    match part:
        case Spring(stiffness=k):
            return k, [(k, 1.0)]
        case PolynomialSpring(coefficients=(k, *_)):
            return k, [(k, 1.0)]
        case Dashpot(coefficient=c):
            return c * p, [(c, p)]
        case PolynomialDashpot(coefficients=(c, *_)):
            return c * p, [(c, p)]
        case Springpot(order=order, coefficient=c):
            unit = p**order
            return c * unit, [(order, c * unit * np.log(p)), (c, unit)]
        case FractionalMaxwell(springpot=pot, spring=spring):
            soft, own = _of_part(pot, p)
            return _in_series(soft, own, spring.stiffness)
        case Maxwell(stiffness=k, coefficient=c):
            return _in_series(c * p, [(c, p)], k)
        case PiezoelectricCircuit(coupling=theta, resistance=r, capacitance=cp):
            rate = 1.0 / part.time
            found = theta**2 / cp * p / (p + rate)
            turn = found * rate / (p + rate)  # -rate d/d rate
            return found, [(theta, 2.0 * found / theta), (r, turn / r), (cp, (turn - found) / cp)]
    raise TypeError(f"{part!r} has no modulus.")  # pragma: no cover


def _in_series(soft: Any, own: Slopes, stiffness: float) -> tuple[Any, Slopes]:
    share = stiffness / (stiffness + soft)
    return share * soft, [*((number, slope * share**2) for number, slope in own), (stiffness, (1.0 - share) ** 2)]


class ModuliLikelihood(LeastSquares):
    """Moduli that scatter with a variance proportional to their square: the gamma quasi-likelihood.

    Parameters
    ----------
    model : System or Oscillator
        With free numbers.
    data : MeasuredModuli

    Raises
    ------
    ValueError
        If a free number does not enter the modulus.

    Notes
    -----
    Its estimates are unbiased for errors of any distribution whose mean is 0 (R. W. M. Wedderburn, "Quasi-likelihood
    functions, generalized linear models, and the Gauss-Newton method", Biometrika 61, 1974).
    """

    def __init__(self, model: System | Oscillator, data: MeasuredModuli) -> None:
        self.model, self.data = model, data
        self.coordinates = Coordinates(tuple(free_numbers(model).values()))
        self.size = data.size
        self.known = data.relative_error is not None
        self._unit = data.relative_error or 1.0
        self._data = np.concatenate([values for _, values in data.columns()])
        self._group = np.concatenate([np.full(values.size, name) for name, values in data.columns()])
        entering = {number.name for number in self._entering()}
        if idle := [name for name in self.coordinates.names if name not in entering]:
            raise ValueError(
                f"{listed(idle)} must not be free: moduli depend on springs, dampers, springpots and circuits only."
            )

    def _entering(self) -> list[Free]:
        return [n for n, _ in complex_modulus(self.model, self.data.frequency_hz)[1] if isinstance(n, Free)]

    def _moduli(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Expected data, and their derivatives by the numbers."""
        model = restarted(self.model, self.coordinates.named(theta))
        modulus, slopes = complex_modulus(model, self.data.frequency_hz)
        by_name = {name: np.zeros(modulus.size, complex) for name in self.coordinates.names}
        for number, slope in slopes:
            if isinstance(number, Free):
                by_name[number.name] = by_name[number.name] + number.times * slope
        matrix = np.stack([*by_name.values()], axis=-1)
        parts = {"storage": (modulus.real, matrix.real), "loss": (modulus.imag, matrix.imag)}
        found = [parts[name] for name, _ in self.data.columns()]
        expected = np.concatenate([own for own, _ in found])
        if not (expected > 0.0).all():
            place = int(np.argmax(~(expected > 0.0)))
            raise ValueError(
                f"model must have a positive {self._group[place]} modulus at every frequency, not {expected[place]:g} "
                f"for {', '.join(f'{k} = {v:.6g}' for k, v in self.coordinates.named(theta).items())}."
            )
        return expected, np.concatenate([own for _, own in found])

    def residuals(self, theta: FloatArray) -> FloatArray:
        """Signed roots of the deviance."""
        return gamma_residuals(self._data / self._moduli(theta)[0]) / self._unit

    def jacobian(self, theta: FloatArray) -> FloatArray:
        """Of the residuals."""
        expected, slopes = self._moduli(theta)
        return np.asarray(gamma_slope(self._data / expected)[:, None] * slopes / expected[:, None] / self._unit)

    def sensitivity(self, theta: FloatArray) -> FloatArray:
        """Relative change of the moduli."""
        expected, slopes = self._moduli(theta)
        return slopes / expected[:, None] / self._unit

    def pearson(self, theta: FloatArray) -> FloatArray:
        """Relative differences."""
        return np.asarray((self._data / self._moduli(theta)[0] - 1.0) / self._unit)

    def constant(self) -> float:
        """The logarithms of the data."""
        return float(2.0 * np.log(self._data).sum() + self.size * np.log(2.0 * np.pi * self._unit**2))

    def extras(self, theta: FloatArray) -> dict[str, float]:
        """The relative error, where it was estimated."""
        return {} if self.known else {"relative_error": self.scatter(theta, len(self.coordinates.free)) ** 0.5}

    def table(self, theta: FloatArray) -> Table:
        """Moduli against frequency."""
        columns = len([*self.data.columns()])
        return Table(
            "frequency_hz", "Hz", np.tile(self.data.frequency_hz, columns), self._group, self._data,
            self._moduli(theta)[0], self.pearson(theta) / self.scatter(theta, len(self.coordinates.free)) ** 0.5,
        )  # fmt: skip
