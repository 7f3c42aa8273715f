"""The complex modulus of linear parts, with its derivatives, beside measured moduli."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.fitting.likelihood import Coordinates, GammaSquares
from springpot.fitting.part_data import MeasuredModuli
from springpot.machine.arguments import Free
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.free_numbers import free_numbers, restarted
from springpot.problem.parts.registration import Slopes
from springpot.problem.system import System


def complex_modulus(system: System, frequency_hz: Floats) -> tuple[Complexes, Slopes]:
    """Storage + i loss of springs, dampers, memory and circuits, without the inertia of the mass.

    Parameters
    ----------
    system : System
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
    >>> from springpot.problem.parts import Dashpot, Spring
    >>> found, _ = complex_modulus(System(Spring(2.0), Dashpot(0.5)), np.array([1.0]))
    >>> found.round(3)
    array([2.+3.142j])
    """
    return modulus_at(system, np.asarray(2j * np.pi * frequency_hz, complex))


def modulus_at(system: System, p: Complexes) -> tuple[Complexes, Slopes]:
    """The same at Laplace variables.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring
    >>> modulus_at(System(Spring(2.0), Dashpot(0.5)), np.array([2.0 + 0j]))[0].real.tolist()
    [3.0]
    """
    total = np.zeros(p.shape, complex)
    slopes: Slopes = []
    for name, part in system.named():
        if {"stored", "damping", "inertia"}.isdisjoint(part.powers):
            continue
        if not part.is_linear:
            raise NotCoveredError(f"the modulus of a linear system is needed, but {name} is not linear.")
        total = total + part.modulus(p)
        slopes += part.slopes(p)
    return total, slopes


def slopes_by_name(slopes: Slopes, names: Sequence[str], size: int) -> Complexes:
    """From derivatives by the numbers of parts to those by the free numbers, shape (size, names).

    Examples
    --------
    >>> slopes_by_name([(2.0 * Free(1.0, "k", 0.1, 9.0), 3.0), (4.0, 5.0)], ["k"], 1)
    array([[6.+0.j]])
    """
    by_name = {name: np.zeros(size, complex) for name in names}
    for number, slope in slopes:
        if isinstance(number, Free):
            by_name[number.name] = by_name[number.name] + number.slope * slope
    return np.array([*by_name.values()], complex).reshape(len(names), size).T


class ModuliLikelihood(GammaSquares):
    """Moduli that scatter with a variance proportional to their square.

    Parameters
    ----------
    system : System
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

    def __init__(self, system: System, data: MeasuredModuli) -> None:
        self.system, self.data = system, data
        self.coordinates = Coordinates(tuple(free_numbers(system).values()))
        self.size = data.size
        self.known = data.relative_error is not None
        self.certainty = 1.0 / (data.relative_error or 1.0)
        self.values = np.concatenate([values for _, values in data.columns()])
        self.at = np.tile(data.frequency_hz, self.values.size // data.frequency_hz.size)
        self.group = np.concatenate([np.full(values.size, name) for name, values in data.columns()])
        entering = {
            number.name for number, _ in complex_modulus(system, data.frequency_hz)[1] if isinstance(number, Free)
        }
        if idle := [name for name in self.coordinates.names if name not in entering]:
            raise ValueError(
                f"{listed(idle)} must not be free: moduli depend on springs, dampers, springpots and circuits only."
            )

    def _moduli(self, theta: Floats) -> tuple[Floats, Floats]:
        """Expected data, and their derivatives by the numbers."""
        system = restarted(self.system, self.coordinates.named(theta))
        modulus, slopes = complex_modulus(system, self.data.frequency_hz)
        matrix = slopes_by_name(slopes, self.coordinates.names, modulus.size)
        parts = {"storage": (modulus.real, matrix.real), "loss": (modulus.imag, matrix.imag)}
        found = [parts[name] for name, _ in self.data.columns()]
        expected = np.concatenate([own for own, _ in found])
        if not (expected > 0.0).all():
            place = int(np.argmax(~(expected > 0.0)))
            raise ValueError(
                f"model must have a positive {self.group[place]} modulus at every frequency, not {expected[place]:g} "
                f"for {', '.join(f'{k} = {v:.6g}' for k, v in self.coordinates.named(theta).items())}."
            )
        return expected, np.concatenate([own for _, own in found])

    def expected(self, theta: Floats) -> Floats:
        """The moduli."""
        return self._moduli(theta)[0]

    def sensitivity(self, theta: Floats) -> Floats:
        """Relative change of the moduli, in its standard deviations."""
        expected, slopes = self._moduli(theta)
        return self.certainty * slopes / expected[:, None]
