"""Linear systems without walls: moments, spectra and frequency response, for any memory and any spectrum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.problem.parts import (
    ColoredNoise,
    Constant,
    Dashpot,
    FractionalMaxwell,
    Harmonic,
    KanaiTajimiNoise,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.system import System, checked_system
from springpot.theory.distributions import real_array
from springpot.theory.methods.systems.coverage import check_kinds
from springpot.theory.numerics.frequencies import integral, resonances
from springpot.theory.result import Moments, Result, moments_of

__all__ = ["Companion", "LinearResponse", "companion_of", "linear", "linear_moments"]

FloatArray = NDArray[np.float64]

_REACH = "The linear theory covers linear springs, dampers, memory and circuits, without walls and contacts"
_NOISES = (WhiteNoise, ColoredNoise, KanaiTajimiNoise, PoissonImpulses)


@dataclass(frozen=True)
class Companion:
    """A linear system per unit mass: what its spectra are made of.

    Parameters
    ----------
    stiffness, damping : float
        Of springs and dashpots, per unit mass.
    elements : tuple
        Elements with memory, per unit mass: each has ``modulus(p)``.
    circuits : tuple of Circuit
    noises : tuple
        Stationary noises, each with ``density(w)``.
    temperature : float
        kT per unit mass of matched noise; 0 without.
    harmonics : tuple of Harmonic
    force : float
        Constant force per unit mass.
    parametric : float
        Intensity of the noise that multiplies x, per unit mass.
    """

    stiffness: float
    damping: float
    elements: tuple[Springpot | FractionalMaxwell | Maxwell, ...]
    circuits: tuple[PiezoelectricCircuit, ...]
    noises: tuple[WhiteNoise | ColoredNoise | KanaiTajimiNoise | PoissonImpulses, ...]
    temperature: float
    harmonics: tuple[Harmonic, ...]
    force: float
    parametric: float

    def dissipative(self, w: FloatArray) -> NDArray[np.complex128]:
        """Force over displacement of dampers, memory and circuits at frequencies w."""
        p = 1j * np.asarray(w, float)
        found = self.damping * p
        for element in (*self.elements, *self.circuits):
            found = found + element.modulus(p)
        return np.asarray(found)

    def dynamic_stiffness(self, w: FloatArray) -> NDArray[np.complex128]:
        """Force over displacement, D(w) = k - w^2 + ..., per unit mass."""
        return np.asarray(self.stiffness - np.asarray(w, float) ** 2 + self.dissipative(w))

    def force_density(self, w: float) -> float:
        """Two-sided spectral density of all noise that does not multiply x, per rad/s."""
        found = self.noise_density(w)
        if self.temperature > 0.0 and w == 0.0:
            pots = (each.springpot if isinstance(each, FractionalMaxwell) else each for each in self.elements)
            fractional = any(isinstance(pot, Springpot) and pot.remembers for pot in pots)
            return math.inf if fractional else self.force_density(1e-150)  # unbounded at low frequency
        if self.temperature > 0.0:
            found += self.temperature / math.pi * float(self.dissipative(np.array([w]))[0].imag) / w
        return found

    def noise_density(self, w: float) -> float:
        """The same without matched noise."""
        return math.fsum(noise.density(w) for noise in self.noises)

    @property
    def scales(self) -> list[float]:
        """Frequencies around which something changes."""
        stiff = self.stiffness
        found = [math.sqrt(stiff), self.damping, stiff / self.damping if self.damping > 0.0 else 0.0]
        for element in self.elements:
            match element:
                case Springpot(order=order, coefficient=c) if c > 0.0:
                    found.append(c ** (1.0 / (2.0 - order)))
                    found.append(min(_power_of(stiff / c, 1.0 / order), math.sqrt(stiff)))
                case FractionalMaxwell(springpot=pot, spring=spring):
                    found += [math.sqrt(stiff + spring.stiffness), pot.coefficient ** (1.0 / (2.0 - pot.order))]
                    found.append(_power_of(spring.stiffness / pot.coefficient, 1.0 / pot.order))
                case Maxwell(stiffness=k, coefficient=c):
                    found += [math.sqrt(stiff + k), k / c]
        for circuit in self.circuits:
            found += [1.0 / circuit.time, math.sqrt(stiff + circuit.coupling**2 / circuit.capacitance)]
        for noise in self.noises:
            if isinstance(noise, ColoredNoise):
                found.append(1.0 / noise.correlation_time)
            elif isinstance(noise, KanaiTajimiNoise):
                found.append(noise.frequency)
        return [scale for scale in found if scale > 0.0]

    @property
    def dissipates(self) -> bool:
        """Whether anything takes energy from the motion."""
        pots = [e for e in self.elements if not isinstance(e, Springpot) or e.dissipates]
        return self.damping > 0.0 or bool(pots) or bool(self.circuits)


def _power_of(base: float, power: float) -> float:
    """A frequency, kept within what matters: so far off, an element is nothing or a spring."""
    return math.exp(min(max(power * math.log(base), -140.0), 140.0))


@dataclass(frozen=True)
class LinearResponse(Result):
    """The stationary state of a linear system, and how it responds at a frequency.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`, and the linear system per unit mass.
    """

    companion: Companion

    def frequency_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Displacement over force, in m/N (s^2 in a system without a `Mass`).

        Parameters
        ----------
        frequency : array_like
            w in rad/s.

        Raises
        ------
        TypeError
            If a frequency is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(0.4), sp.WhiteNoise(1.0))
        >>> complex(sp.theory.linear(device).frequency_response(2.0))
        -1.25j
        """
        w = real_array(frequency, "frequency")
        return np.asarray(1.0 / (self.system.inertia * self.companion.dynamic_stiffness(w)))

    def spectrum(self, frequency: ArrayLike) -> FloatArray:
        """Two-sided spectral density of x, in m^2 s per rad, without the lines of harmonic forces.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError
            If a frequency is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0))
        >>> float(sp.theory.linear(device).spectrum(1.0).round(4))
        0.1592
        """
        moments = self.moments
        w = np.abs(real_array(frequency, "frequency"))
        force = np.vectorize(self.companion.force_density, otypes=[float])(w)
        force = force + self.companion.parametric * moments.x_mean_square / (2.0 * math.pi)
        return np.asarray(force / np.abs(self.companion.dynamic_stiffness(w)) ** 2)


@np.errstate(all="ignore")  # what is not finite is no answer
def linear(system: System) -> LinearResponse:
    """The exact stationary moments of a linear system without walls.

    Parameters
    ----------
    system : System
        Linear springs, dashpots, springpots, arms and circuits; constant, harmonic, white, colored, filtered, Poisson,
        parametric and thermal excitation.

    Returns
    -------
    LinearResponse
        Its moments are those of the equation of motion, to about 1e-9 of their size.

    Raises
    ------
    NotCoveredError
        If the system has a wall, a contact or something nonlinear; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    <x^2> = int S(w) / \\|D(w)\\|^2 dw and <v^2> with w^2.  A harmonic force F cos(nu t + phase) of random phase adds
    F^2 / (2 \\|D(nu)\\|^2).  x does not depend on the future of the noise xi2 that multiplies it, so that the force
    x xi2 acts like a white noise of intensity q2 <x^2>, for any memory.

    Examples
    --------
    A harvester with a springpot:

    >>> import springpot as sp
    >>> harvester = sp.System(
    ...     sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.PiezoelectricCircuit(0.5, 3.2, 0.625), sp.WhiteNoise(1.0)
    ... )
    >>> result = linear(harvester)
    >>> round(result.x_mean_square, 5), round(result.harvested_power, 5)
    (1.17038, 0.18032)
    """
    system = checked_system(system)
    companion = companion_of(system)
    return LinearResponse(
        method="linear",
        system=system,
        stationary=linear_moments(system, companion),
        assumptions=("None: this solves the linear equation of motion as it stands, with memory of the whole past.",),
        warnings=(),
        is_exact=True,
        companion=companion,
    )


def companion_of(system: System) -> Companion:
    """The linear system, or the sentence that names the part which is not linear.

    Raises
    ------
    NotCoveredError
        If there is a wall, a contact or something nonlinear.
    """
    unit = system.per_unit_mass
    sources = Constant | Harmonic | ParametricNoise | ThermalNoise | WhiteNoise | ColoredNoise | KanaiTajimiNoise
    elements = Dashpot | PolynomialDashpot | Springpot | FractionalMaxwell | Maxwell | PiezoelectricCircuit
    kinds = Spring | PolynomialSpring | elements | sources | PoissonImpulses
    check_kinds(unit, _REACH, kinds, linear=PolynomialSpring | PolynomialDashpot, nonlinear="")
    return Companion(
        stiffness=unit.stiffness,
        damping=unit.damping,
        elements=unit.of(Springpot, FractionalMaxwell, Maxwell),
        circuits=unit.of(PiezoelectricCircuit),
        noises=unit.of(*_NOISES),
        temperature=sum(noise.temperature for noise in unit.of(ThermalNoise)),
        harmonics=unit.of(Harmonic),
        force=sum(part.force for part in unit.of(Constant)),
        parametric=sum(noise.intensity for noise in unit.of(ParametricNoise)),
    )


check_covered = companion_of


def linear_moments(system: System, companion: Companion) -> Moments | str:
    """The stationary moments of a linear system, or why there are none."""
    springs = [e for e in companion.elements if isinstance(e, Springpot) and e.order == 0.0]
    static = companion.stiffness + sum(spring.coefficient for spring in springs)
    if not static > 0.0:
        return "There is no stationary state: no spring pulls the mass back, so that it wanders without end."
    if not companion.dissipates:
        return "There is no stationary state: nothing dissipates energy."
    if static != companion.stiffness:  # a springpot of order 0 is a spring
        kept = tuple(e for e in companion.elements if e not in springs)
        return linear_moments(system, replace(companion, stiffness=static, elements=kept))
    cuts = resonances(companion.dynamic_stiffness, companion.scales)

    def mean_square(density: Callable[[float], float], power: int = 0) -> float:
        def response(w: float) -> float:
            factor = w**power / abs(complex(companion.dynamic_stiffness(np.array([w]))[0]))
            return density(w) * factor * factor

        return integral(response, cuts)

    x_mean = companion.force / static
    x_square = companion.temperature / static  # matched noise shares its energy out evenly
    v_square, power = companion.temperature, 0.0
    if companion.noises:
        x_square += mean_square(companion.noise_density)
        v_square += mean_square(companion.noise_density, 1)
        power += _power(companion, mean_square, companion.noise_density)
    for force in companion.harmonics:
        nu = force.frequency
        response = 0.5 * force.amplitude**2 / abs(complex(companion.dynamic_stiffness(np.array([nu]))[0])) ** 2
        x_square += response
        v_square += response * nu**2
        power += sum(response * _voltage_square(circuit, nu) / circuit.resistance for circuit in companion.circuits)
    x_square += x_mean**2
    if companion.parametric > 0.0:
        x_unit = mean_square(lambda w: 1.0 / (2.0 * math.pi))
        v_unit = mean_square(lambda w: 1.0 / (2.0 * math.pi), 1)
        if not companion.parametric * x_unit < 1.0:
            return "There is no stationary mean square: the noise that multiplies x feeds more than is dissipated."
        x_square = x_square / (1.0 - companion.parametric * x_unit)
        fed = companion.parametric * x_square
        v_square += fed * v_unit
        power += fed * _power(companion, mean_square, lambda w: 1.0 / (2.0 * math.pi))
    harvests = companion.circuits and companion.temperature == 0.0
    return moments_of(system, x_mean, x_square, v_square, harvested=power * system.inertia if harvests else None)


def _power(
    companion: Companion, mean_square: Callable[[Callable[[float], float]], float], density: Callable[[float], float]
) -> float:
    """Mean of V^2 / R of all circuits, per unit mass."""
    return math.fsum(
        mean_square(lambda w, circuit=circuit: density(w) * _voltage_square(circuit, w)) / circuit.resistance  # type: ignore[misc]
        for circuit in companion.circuits
    )


def _voltage_square(circuit: PiezoelectricCircuit, w: float) -> float:
    """\\|V / x\\|^2 at a frequency."""
    return (circuit.coupling / circuit.capacitance * w) ** 2 / (w * w + 1.0 / circuit.time**2)
