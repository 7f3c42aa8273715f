"""Base classes of results with densities: they convert units and side, and handle arrays, NaN and infinity.

A method gives a `Law` in its own units; where that is known at a time from rest too, it overrides a method that begins
with an underscore.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.theory.distributions import numbers_only
from springpot.theory.problem import Units
from springpot.theory.result import Result


class Law(Protocol):
    """Densities in the units ``units``, for arrays of finite numbers; x is positive away from the wall."""

    @property
    def units(self) -> Units:
        """Conversion to m and m/s."""

    def x(self, x: Floats) -> Floats:
        """Of the displacement."""

    def v(self, v: Floats) -> Floats:
        """Of the velocity."""

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Of both, for arrays of one shape."""

    def impact_speed(self, speed: Floats) -> Floats:
        """Of the speed just before an impact."""


class LawOfAmplitude(Law, Protocol):
    """A law that also has the density of A = sqrt(x^2 + v^2 / Omega^2)."""

    def amplitude(self, amplitude: Floats) -> Floats:
        """Of A over the unit of length."""


L = TypeVar("L", bound=Law, covariant=True)
A = TypeVar("A", bound=LawOfAmplitude, covariant=True)
Kept = TypeVar("Kept", covariant=True)


@dataclass(frozen=True)
class WithLaw(Result, Generic[Kept]):
    """A result that keeps the law from which its moments are."""

    _law: Kept | None = field(default=None, repr=False, compare=False, kw_only=True)

    def _stationary_law(self) -> Kept:
        _ = self.moments  # raises where there is no stationary state
        if self._law is None:
            raise ValueError("there is no density: without noise the mass is at rest.")
        return self._law


@dataclass(frozen=True)
class Densities(WithLaw[L]):
    """A result with the densities of displacement, velocity and impact speed.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`.  A density takes a number or an array of any shape; it
    is 0 at infinity and NaN at NaN.
    """

    @cached_property
    def paper(self) -> Dimensionless:
        """The paper's problem, which the system is."""
        return Dimensionless.of(self.system)

    @numbers_only
    def x_density(self, displacement: ArrayLike, time: float | None = None) -> Floats:
        """Density of x, in 1/m.

        Parameters
        ----------
        displacement : array_like
            x in m.
        time : float, optional
            One time from rest in s, if the method covers it; without it, the stationary density.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state and no time is given.
        NotCoveredError
            If the method does not cover the density at a time.
        TypeError
            If an argument is not a number, or ``time`` is more than one.
        ValueError
            If there is no density because the mass rests: without noise, or at time 0.

        Examples
        --------
        >>> import springpot as sp
        >>> sp.theory.averaging(sp.Oscillator()).x_density([-0.1, 0.0]).round(4)
        array([0.    , 0.7446])
        """
        law = self._at(time)
        return np.asarray(law.x(law.units.place(displacement)) / law.units.length)

    @numbers_only
    def v_density(self, velocity: ArrayLike, time: float | None = None) -> Floats:
        """Density of the velocity, in s/m; with a lossy wall it is not symmetric, where a method has that.

        Parameters and errors are those of `x_density`, with v in m/s.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).v_density(0.0).round(4))
        0.3723
        """
        law = self._at(time)
        return np.asarray(law.v(law.units.pace(velocity)) / law.units.speed)

    @numbers_only
    def joint_density(self, displacement: ArrayLike, velocity: ArrayLike, time: float | None = None) -> Floats:
        """Density of (x, v), in s/m^2; the arguments are broadcast.

        Parameters and errors are those of `x_density`, with x in m and v in m/s.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).joint_density(0.0, 0.0).round(4))
        0.2772
        """
        law, units = self._at(time), self._at(time).units
        return np.asarray(law.joint(units.place(displacement), units.pace(velocity)) / (units.length * units.speed))

    @numbers_only
    def impact_speed_density(self, speed: ArrayLike, time: float | None = None) -> Floats:
        """Density of the speed just before an impact, in s/m.

        Parameters and errors are those of `x_density`, with the speed in m/s.

        Raises
        ------
        NotCoveredError
            If the system has no wall, or slow impacts are infinitely many.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).impact_speed_density(1.0).round(4))
        0.5635
        """
        if not self.system.stops:
            raise NotCoveredError("There is no impact speed: this system has no wall to strike.")
        law = self._at(time)
        return np.asarray(law.impact_speed(np.asarray(speed) / law.units.speed) / law.units.speed)

    def _at(self, time: float | None) -> L:
        """The law at a time from rest, or in the stationary state."""
        if time is not None:
            raise NotCoveredError(
                f"This density of {self.method} is known in the stationary state only, not at a time."
            )
        return self._stationary_law()


@dataclass(frozen=True)
class DensitiesOfAmplitude(Densities[A]):
    """A result that also has the densities of amplitude and energy."""

    @numbers_only
    def amplitude_density(self, amplitude: ArrayLike, time: float | None = None) -> Floats:
        """Density of A = sqrt(x^2 + v^2 / Omega^2), in 1/m.

        Parameters and errors are those of `x_density`, with A in m.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).amplitude_density(1.0).round(4))
        0.5635
        """
        return self._amplitude(np.asarray(amplitude), time)

    @numbers_only
    def energy_density(self, energy: ArrayLike, time: float | None = None) -> Floats:
        """Density of the energy per unit mass, H = v^2 / 2 + Omega^2 x^2 / 2 = (Omega A)^2 / 2, in s^2/m^2.

        Parameters and errors are those of `x_density`, with H in m^2/s^2.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).energy_density(1.0).round(4))
        0.3645
        """
        omega, h = self.system.natural_frequency, np.asarray(energy)
        a = np.sqrt(np.maximum(2.0 * h, np.finfo(float).tiny)) / omega
        return np.where(h >= 0.0, self._amplitude(a, time) / (omega * omega * a), 0.0)

    def _amplitude(self, a: Floats, time: float | None) -> Floats:
        law = self._at(time)
        return np.asarray(law.amplitude(a / law.units.length) / law.units.length)
