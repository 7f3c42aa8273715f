"""The modulus of linear parts, and their relaxation and creep, with derivatives, beside what was measured."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from springpot.fitting.likelihood import USUAL, GammaSquares, How, refuse_idle
from springpot.fitting.part_data import MeasuredCreep, MeasuredModuli, MeasuredRelaxation
from springpot.machine.arguments import Free
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import Dashpot, FractionalMaxwell, Maxwell, Spring, Springpot
from springpot.problem.parts.registration import Slopes
from springpot.problem.system import System

PartData = MeasuredModuli | MeasuredRelaxation | MeasuredCreep

_NODES = 32
_IDLE = 1e-9  # relative change of all data by which a number has an influence


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


def stepped(system: System, time: Floats, names: tuple[str, ...], creep: bool) -> tuple[Floats, Floats]:
    """The relaxation modulus of springs, dampers and memory, or their creep compliance.

    Parameters
    ----------
    system : System
    time : ndarray, shape (n,)
        Since the step, in s.
    names : tuple of str
        Of free numbers.
    creep : bool

    Returns
    -------
    found : ndarray, shape (n,)
    slopes : ndarray, shape (n, names)
        By the numbers.

    Raises
    ------
    NotCoveredError
        If a part is another one.

    Notes
    -----
    The modulus K(p) gives G(t) = L^-1[K(p) / p] and J(t) = L^-1[1 / (p K(p))].  Both have their singularities on the
    negative axis alone, so that the integral along a parabola around it converges like 2.85^-n with n nodes (J. A. C.
    Weideman and L. N. Trefethen, "Parabolic and hyperbolic contours for computing the Bromwich integral", Mathematics
    of Computation 76, 2007).

    Examples
    --------
    A springpot: G = C t^-order / Gamma(1 - order):

    >>> found, _ = stepped(System(Springpot(0.5, 2.0)), np.array([4.0]), (), creep=False)
    >>> float(found[0] * np.sqrt(np.pi)).__round__(12)
    1.0
    """
    for name, part in system.named():
        if {"stored", "damping", "inertia"}.isdisjoint(part.powers):
            continue
        if not isinstance(part, Spring | Dashpot | Springpot | Maxwell | FractionalMaxwell):
            raise NotCoveredError(f"relaxation and creep cover springs, dashpots, springpots and arms, not {name}.")
    angle = np.pi * (2.0 * np.arange(_NODES // 2) + 1.0) / _NODES
    place = _NODES * (0.1309 - 0.1194 * angle**2 + 0.25j * angle)
    weight = 2.0 / _NODES * np.exp(place) * _NODES * (0.25 + 0.2388j * angle)  # of the upper half; the real part counts
    p = np.asarray((place / time[:, None]).ravel(), complex)
    modulus, slopes = modulus_at(system, p)
    matrix = slopes_by_name(slopes, names, p.size)

    def integral(transform: Complexes) -> Floats:
        shaped = transform.reshape(time.size, angle.size, -1)
        return np.asarray((weight[:, None] * shaped).sum(axis=1).real / time[:, None])

    if creep:
        return integral(1.0 / (p * modulus))[:, 0], integral(-matrix / (p * modulus**2)[:, None])
    return integral(modulus / p)[:, 0], integral(matrix / p[:, None])


class PartLikelihood(GammaSquares):
    """Data of linear parts that scatter with a variance proportional to their square; derivatives are exact.

    Parameters
    ----------
    system : System
        With free numbers.
    data : MeasuredModuli, MeasuredRelaxation or MeasuredCreep
    """

    def __init__(self, system: System, data: PartData, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self.known = data.relative_error is not None
        self.certainty = 1.0 / (data.relative_error or 1.0)

    @abstractmethod
    def with_slopes(self, theta: Floats) -> tuple[Floats, Floats]:
        """Expected data, and their derivatives by the numbers."""

    def expected(self, theta: Floats) -> Floats:
        """What the data are expected to be."""
        return self.with_slopes(theta)[0]

    def sensitivity(self, theta: Floats) -> Floats:
        """Relative change of the expected data, in its standard deviations."""
        expected, slopes = self.with_slopes(theta)
        return self.certainty * slopes / expected[:, None]


class ModuliLikelihood(PartLikelihood):
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

    def __init__(self, system: System, data: MeasuredModuli, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self.values = np.concatenate([values for _, values in data.columns()])
        self.at = np.tile(data.frequency_hz, self.values.size // data.frequency_hz.size)
        self.group = np.concatenate([np.full(values.size, name) for name, values in data.columns()])
        entering = {
            number.name for number, _ in complex_modulus(system, data.frequency_hz)[1] if isinstance(number, Free)
        }
        idle = [name for name in self.coordinates.names if name not in entering]
        refuse_idle(idle, "moduli depend on springs, dampers, springpots and circuits only")

    def with_slopes(self, theta: Floats) -> tuple[Floats, Floats]:
        """The moduli."""
        modulus, slopes = complex_modulus(self.restarted(theta), self.data.frequency_hz)
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


class SteppedLikelihood(PartLikelihood):
    """Relaxation moduli or creep compliances that scatter with a variance proportional to their square.

    Parameters
    ----------
    system : System
        With free numbers.
    data : MeasuredRelaxation or MeasuredCreep

    Raises
    ------
    ValueError
        If a free number does not enter.
    """

    axis = "time_s", "s"

    def __init__(self, system: System, data: MeasuredRelaxation | MeasuredCreep, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self.at = data.time
        self.creep = isinstance(data, MeasuredCreep)
        self.values = data.compliance if isinstance(data, MeasuredCreep) else data.modulus
        self.group = np.full(data.size, "creep" if self.creep else "relaxation")
        own = self.coordinates
        expected, slopes = self.with_slopes(own.outer(own.start))
        moves = np.abs(slopes * own.outer(own.start) / expected[:, None]).max(axis=0, initial=0.0)
        idle = [name for name, move in zip(own.names, moves.tolist(), strict=True) if move < _IDLE]
        refuse_idle(idle, f"{self.group[0]} does not depend on it")

    def with_slopes(self, theta: Floats) -> tuple[Floats, Floats]:
        """The moduli or compliances."""
        found, slopes = stepped(self.restarted(theta), self.at, self.coordinates.names, self.creep)
        if not (found > 0.0).all():
            raise ValueError(f"model must have a positive {self.group[0]} at every time.")
        return found, slopes
