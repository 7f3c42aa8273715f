"""Mean squares in time of linear systems from rest, with noise that may have an envelope.

x = int h(t - s) e(s) dW(s) for a white noise that drives a filter G and a system D, with h the inverse of G / D, so
that <x^2> = q int h^2(t - s) e^2(s) ds, and <v^2> the same with h'.  H = G / D has poles in the plane that is cut along
the negative axis, with springpots one pair of D, and h is their residues and an integral over the cut,

    h(t) = 2 Re sum e^(s0 t) / (1 / H)'(s0) + int_0^inf K(r) e^(-r t) dr,  K(r) = -Im[H(r e^(i pi))] / pi.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    CloughPenzienNoise,
    Dashpot,
    KanaiTajimiNoise,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    WhiteNoise,
)
from springpot.problem.system import System, checked_system
from springpot.theory.distributions import real_array
from springpot.theory.methods.systems.coverage import check_kinds

__all__ = ["Transient", "transient"]

FloatArray = npt.NDArray[np.float64]

_REACH = (
    "The transient covers one mass with linear springs, dashpots and springpots, and white, Kanai-Tajimi and "
    "Clough-Penzien noise"
)
_PER_SCALE = 60  # points of the shortest time scale
_MOST_POINTS = 400_000
_CUT = np.arange(-46.0, 46.0, 0.05)  # logarithms of rates beside the frequency


@dataclass(frozen=True, eq=False)
class Transient:
    """Mean squares of a linear system at times since its start from rest.

    Attributes
    ----------
    time : ndarray
        In s.
    x_mean_square, v_mean_square : ndarray
        In m^2 and m^2/s^2.
    """

    time: FloatArray
    x_mean_square: FloatArray
    v_mean_square: FloatArray


@np.errstate(over="ignore", under="ignore")
def transient(system: System, time: npt.ArrayLike) -> Transient:
    """The exact mean squares in time of a linear system that starts from rest.

    Parameters
    ----------
    system : System
        One mass with linear springs, dashpots and springpots; white, Kanai-Tajimi and Clough-Penzien noise, with or
        without an envelope.  A filter starts from silence.
    time : array_like
        In s, none below 0.

    Returns
    -------
    Transient
        To about 1e-4 of the largest value: trapezoids of a sixtieth of the shortest time scale.

    Raises
    ------
    NotCoveredError
        If the system has another part, or is damped so strongly that it does not oscillate; the sentence says which.
    TypeError, ValueError
        If it is not a System, or a time is below 0.

    Examples
    --------
    >>> import springpot as sp
    >>> envelope = sp.ExponentialEnvelope(slow=0.2, fast=0.6)
    >>> shaken = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0, envelope=envelope))
    >>> transient(shaken, [4.0, 10.0]).x_mean_square.round(3).tolist()
    [0.983, 0.778]
    """
    system = checked_system(system)
    if len(system.points) > 1:
        raise NotCoveredError(f"{_REACH}, not {len(system.points)} masses.")
    unit = system.per_unit_mass
    memory = Spring | PolynomialSpring | Dashpot | PolynomialDashpot | Springpot
    kinds = memory | WhiteNoise | KanaiTajimiNoise | CloughPenzienNoise
    check_kinds(unit, _REACH, kinds, linear=PolynomialSpring | PolynomialDashpot, nonlinear="the nonlinear ", over=True)
    times = real_array(time, "time")
    if (times < 0.0).any():
        raise ValueError("time must not be below 0.")
    found = np.zeros((2, times.size))
    noises: Any = unit.of(WhiteNoise, KanaiTajimiNoise, CloughPenzienNoise)
    for noise in noises:
        found += noise.intensity * _mean_squares(_Response(unit, noise), noise, times.ravel())
    return Transient(times, found[0].reshape(times.shape), found[1].reshape(times.shape))


@dataclass(frozen=True, eq=False)
class _Response:
    """Displacement per white noise that drives a system through the filter of a noise, in the Laplace variable."""

    unit: System
    noise: Any

    def of_system(self, p: Any) -> Any:
        """D(p)."""
        return p * p + sum(part.modulus(p) for part in self.unit.parts if not hasattr(part, "density"))

    def of_filter(self, p: Any) -> Any:
        """The denominator of G."""
        return math.prod((p * p + 2.0 * z * w * p + w * w for w, z in self.filters), start=1.0 + 0.0 * p)

    @property
    def filters(self) -> list[tuple[float, float]]:
        """Frequency and damping ratio of each."""
        match self.noise:
            case KanaiTajimiNoise(frequency=w, damping=z):
                return [(w, z)]
            case CloughPenzienNoise(frequency=w, damping=z, base_frequency=wf, base_damping=zf):
                return [(w, z), (wf, zf)]
        return []

    def above(self, p: Any) -> Any:
        """The numerator of G."""
        if not self.filters:
            return 1.0 + 0.0 * p
        w, z = self.filters[0]
        passed = w * w + 2.0 * z * w * p
        return passed * p * p if len(self.filters) > 1 else passed

    def under(self, p: Any) -> Any:
        """The denominator of all."""
        return self.of_system(p) * self.of_filter(p)

    @property
    def poles(self) -> list[complex]:
        """Those above the real axis.

        Raises
        ------
        NotCoveredError
            If there is none of the system, or two are one.
        """
        if not any(pot.remembers and pot.coefficient > 0.0 for pot in self.unit.of(Springpot)):
            stiffness, damping = self.of_system(0.0), self.of_system(1.0) - 1.0 - self.of_system(0.0)
            found = [complex(-0.5 * damping, math.sqrt(max(stiffness - 0.25 * damping**2, 0.0)))]
        else:
            found = [_newton(self.of_system, 1j * self.unit.resonance)]
        found += [complex(-z * w, w * math.sqrt(1.0 - z * z)) for w, z in self.filters]
        apart = [abs(a - b) > 1e-6 * abs(a) for n, a in enumerate(found) for b in found[:n]]
        if not all(pole.imag > 1e-9 * abs(pole) for pole in found) or not all(apart):
            raise NotCoveredError(f"{_REACH}, all with oscillations of their own and each with another.")
        return found

    def at(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """h and h' at times."""
        h, slope = np.zeros_like(time), np.zeros_like(time)
        for pole in self.poles:
            small = 1e-6 * abs(pole)
            derivative = (self.under(pole + small) - self.under(pole - small)) / (2.0 * small)
            wave = 2.0 * self.above(pole) / derivative * np.exp(pole * time)
            h += wave.real
            slope += (pole * wave).real
        rates = abs(self.poles[0]) * np.exp(_CUT)
        behind = rates * np.exp(1j * math.pi)
        behind = behind.real + 1j * 0.0  # above the cut
        weights = -(self.above(behind) / self.under(behind)).imag / math.pi * rates * (_CUT[1] - _CUT[0])
        kept = np.abs(weights) * (1.0 + rates) > 1e-16 * np.abs(weights * (1.0 + rates)).max()
        for weight, rate in zip(weights[kept], rates[kept], strict=True):
            fading = weight * np.exp(-rate * time)
            h += fading
            slope -= rate * fading
        return h, slope


def _newton(function: Any, start: complex) -> complex:
    p = start
    for _ in range(200):
        small = 1e-6 * abs(p)
        change = function(p) / ((function(p + small) - function(p - small)) / (2.0 * small))
        p -= change
        if abs(change) < 1e-14 * abs(p):
            return complex(p)
        if p.imag <= 0.0 or cmath.phase(p) > math.pi - 1e-9:
            break
    raise NotCoveredError(f"{_REACH}, that oscillate: here none was found.")


def _mean_squares(response: _Response, noise: Any, times: FloatArray) -> FloatArray:
    """Of x and v at each time, of a driving white noise of intensity 1."""
    end = float(times.max(initial=0.0))
    if not end > 0.0:
        return np.zeros((2, times.size))
    shortest = 1.0 / max(map(abs, response.poles))
    count = math.ceil(end / shortest * _PER_SCALE / (2.0 * math.pi)) + 1
    if count > _MOST_POINTS:
        raise NotCoveredError(f"{_REACH}, over at most {_MOST_POINTS} times a sixtieth of their shortest period.")
    from scipy.interpolate import CubicSpline  # slow to import

    grid = np.linspace(0.0, end, max(count, 400))
    squares = [CubicSpline(grid, values**2) for values in response.at(grid)]
    found = np.zeros((2, times.size))
    for n, time in enumerate(times):
        inside = np.linspace(0.0, time, max(int(np.searchsorted(grid, time)) * 2, 50))
        weight = np.ones_like(inside) if noise.envelope is None else noise.envelope.at(time - inside) ** 2
        for k, square in enumerate(squares):
            found[k, n] = np.trapezoid(square(inside) * weight, inside)
    return found
