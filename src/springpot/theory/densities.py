"""Base classes of results with densities: they convert units and side, and handle arrays, NaN and infinity.

A method gives a `Law` in its own units; where its formulas are in other units it overrides one of the methods that
begin with an underscore.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.problem.dimensionless import Dimensionless
from springpot.theory.distributions import numbers_only, real_array
from springpot.theory.problem import Units
from springpot.theory.result import NotCoveredError, Result

__all__ = ["Densities", "DensitiesOfAmplitude", "Law"]

FloatArray = NDArray[np.float64]


class Law(Protocol):
    """Densities in the units ``units``, for arrays of finite numbers; x is positive away from the wall."""

    @property
    def units(self) -> Units:
        """Conversion to m and m/s."""

    def x(self, x: FloatArray) -> FloatArray:
        """Of the displacement."""

    def v(self, v: FloatArray) -> FloatArray:
        """Of the velocity."""

    def joint(self, x: FloatArray, v: FloatArray) -> FloatArray:
        """Of both, for arrays of one shape."""

    def impact_speed(self, speed: FloatArray) -> FloatArray:
        """Of the speed just before an impact."""


@dataclass(frozen=True)
class Densities(Result):
    """A result with the densities of displacement, velocity and impact speed.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`.  A density takes a number or an array of any shape; it
    is 0 at infinity and NaN at NaN.
    """

    _law: Law | None = field(default=None, repr=False, compare=False, kw_only=True)

    @cached_property
    def paper(self) -> Dimensionless:
        """The paper's problem, which the system is."""
        return Dimensionless.of(self.system)

    @numbers_only
    def x_density(self, displacement: ArrayLike, time: float | None = None) -> FloatArray:
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
        return self._x(real_array(displacement, "displacement"), time)

    @numbers_only
    def v_density(self, velocity: ArrayLike, time: float | None = None) -> FloatArray:
        """Density of the velocity, in s/m; with a lossy wall it is not symmetric.

        Parameters and errors are those of `x_density`, with v in m/s.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).v_density(0.0).round(4))
        0.3723
        """
        return self._v(real_array(velocity, "velocity"), time)

    @numbers_only
    def joint_density(self, displacement: ArrayLike, velocity: ArrayLike, time: float | None = None) -> FloatArray:
        """Density of (x, v), in s/m^2; the arguments are broadcast.

        Parameters and errors are those of `x_density`, with x in m and v in m/s.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).joint_density(0.0, 0.0).round(4))
        0.2772
        """
        return self._joint(real_array(displacement, "displacement"), real_array(velocity, "velocity"), time)

    @numbers_only
    def impact_speed_density(self, speed: ArrayLike, time: float | None = None) -> FloatArray:
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
        u = real_array(speed, "speed")
        if not self.system.stops:
            raise NotCoveredError("There is no impact speed: this system has no wall to strike.")
        return self._impact_speed(u, time)

    def _at(self, time: float | None) -> Law:
        """The law at a time from rest, or in the stationary state."""
        if time is not None:
            raise NotCoveredError(
                f"This density of {self.method} is known in the stationary state only, not at a time."
            )
        _ = self.moments  # raises where there is no stationary state
        if self._law is None:
            raise ValueError("there is no density: without noise the mass is at rest.")
        return self._law

    def _x(self, x: FloatArray, time: float | None) -> FloatArray:
        law = self._at(time)
        return np.asarray(law.x(law.units.place(x)) / law.units.length)

    def _v(self, v: FloatArray, time: float | None) -> FloatArray:
        law = self._at(time)
        return np.asarray(law.v(law.units.side * v / law.units.speed) / law.units.speed)

    def _joint(self, x: FloatArray, v: FloatArray, time: float | None) -> FloatArray:
        law = self._at(time)
        units = law.units
        return np.asarray(law.joint(units.place(x), units.side * v / units.speed) / (units.length * units.speed))

    def _impact_speed(self, u: FloatArray, time: float | None) -> FloatArray:
        law = self._at(time)
        return np.asarray(law.impact_speed(u / law.units.speed) / law.units.speed)


@dataclass(frozen=True)
class DensitiesOfAmplitude(Densities):
    """A result that also has the densities of amplitude and energy."""

    @numbers_only
    def amplitude_density(self, amplitude: ArrayLike, time: float | None = None) -> FloatArray:
        """Density of A = sqrt(x^2 + v^2 / Omega^2), in 1/m.

        Parameters and errors are those of `x_density`, with A in m.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).amplitude_density(1.0).round(4))
        0.5635
        """
        return self._amplitude(real_array(amplitude, "amplitude"), time)

    @numbers_only
    def energy_density(self, energy: ArrayLike, time: float | None = None) -> FloatArray:
        """Density of the energy per unit mass, H = v^2 / 2 + Omega^2 x^2 / 2 = (Omega A)^2 / 2, in s^2/m^2.

        Parameters and errors are those of `x_density`, with H in m^2/s^2.

        Examples
        --------
        >>> import springpot as sp
        >>> float(sp.theory.averaging(sp.Oscillator()).energy_density(1.0).round(4))
        0.3645
        """
        return self._energy(real_array(energy, "energy"), time)

    def _amplitude(self, a: FloatArray, time: float | None) -> FloatArray:
        raise NotImplementedError

    def _energy(self, h: FloatArray, time: float | None) -> FloatArray:
        omega = self.paper.natural_frequency
        a = np.sqrt(np.maximum(2.0 * h, np.finfo(float).tiny)) / omega
        return np.where(h >= 0.0, self._amplitude(a, time) / (omega * omega * a), 0.0)
