"""Densities that several methods share, without overflow at any argument, and checks of arguments."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import finite_numbers, real_array
from springpot.machine.arrays import Floats
from springpot.theory.problem import Units

_RAREST = 1e-15  # probability of which a level is sought
_FAR = 60.0  # standard deviations at which a normal or Rayleigh density is exactly 0 in double precision


def level_probabilities(value: ArrayLike, name: str) -> Floats:
    """Probabilities with which levels of a quantity of this name are exceeded, as an array of floats.

    Raises
    ------
    TypeError, ValueError
        If there is none, or one is not a number in [1e-15, 0.5].

    Examples
    --------
    >>> level_probabilities([1e-3, 1e-6], "x")
    array([1.e-03, 1.e-06])
    """
    word, hint = f"probability of {name}", "It is of exceeding the level within the time."
    return finite_numbers(value, word, word, low=_RAREST, high=0.5, hint=hint)


def times(value: ArrayLike, name: str, *, either_sign: bool = False) -> Floats:
    """Times of at least 0 s, or the sizes of those of either sign, as an array of floats, which may be infinite.

    Raises
    ------
    TypeError, ValueError
        If a value is not a real number, or is NaN or negative.

    Examples
    --------
    >>> times(1, "time")
    array(1.)
    """
    t = np.abs(real_array(value, name)) if either_sign else real_array(value, name)
    if np.any(np.isnan(t)):
        raise ValueError(f"{name} must be {'a time in s' if either_sign else 'at least 0 s'}, not NaN.")
    if np.any(t < 0.0):
        raise ValueError(f"{name} must be at least 0 s, not {np.min(t):g}.")
    return t


def normal(value: Floats, variance: float) -> Floats:
    """Normal density of mean 0.

    Examples
    --------
    >>> float(normal(np.array(0.0), 1.0).round(4))
    0.3989
    """
    far = _FAR * math.sqrt(variance)
    v = np.clip(value, -far, far)
    return np.asarray(np.exp(-v * v / (2.0 * variance)) / math.sqrt(2.0 * math.pi * variance))


def rayleigh(value: Floats, mean_square: float) -> Floats:
    """Rayleigh density: the modulus of two independent normals of variance mean_square / 2.

    Examples
    --------
    >>> float(rayleigh(np.array(1.0), 2.0).round(4))
    0.6065
    """
    r = np.clip(value, 0.0, _FAR * math.sqrt(mean_square))
    return np.asarray(2.0 * r / mean_square * np.exp(-r * r / mean_square))


def hoyt(value: Floats, first: float, second: float) -> Floats:
    """Hoyt's density: the modulus of two independent normals with these variances.

    Examples
    --------
    >>> float(hoyt(np.array(1.0), 1.0, 1.0).round(4)), float(hoyt(np.array(1.0), 1.0, 0.25).round(4))
    (0.6065, 0.6565)
    """
    from scipy import special  # slow to import, and runs need none of it

    wide = max(first, second)
    a = np.clip(value, 0.0, _FAR * math.sqrt(wide))
    # I0(z) exp(-a^2 (1/first + 1/second) / 4) with z = a^2 |1/first - 1/second| / 4, scaled so that nothing overflows
    z = a * a * abs(1.0 / first - 1.0 / second) / 4.0
    return np.asarray(a / math.sqrt(first * second) * special.ive(0, z) * np.exp(-a * a / (2.0 * wide)))


def modulus_correlation(rho: Floats) -> Floats:
    """<|y| |z|> of two standard normals of correlation ``rho``: 1 at rho = +-1, 2 / pi at rho = 0.

    Examples
    --------
    >>> modulus_correlation(np.array([-1.0, 0.0, 1.0])).round(4).tolist()
    [1.0, 0.6366, 1.0]
    """
    return np.asarray(2.0 / math.pi * (np.sqrt((1.0 - rho) * (1.0 + rho)) + rho * np.arcsin(rho)))


def numbers_only(density: Callable[..., Floats]) -> Callable[..., Floats]:
    """Decorator of a density, which is then called with arrays of finite numbers: it is NaN at NaN and 0 at infinity.

    A parameter ``time`` is passed on unchanged.  Overflow is not reported: it gives infinity, where a density is 0.

    Examples
    --------
    >>> numbers_only(lambda self, x: np.exp(-x))(None, [0.0, np.nan, np.inf])
    array([ 1., nan,  0.])
    """
    signature = inspect.signature(density)
    places = [name for name in signature.parameters if name not in ("self", "time")]

    @wraps(density)
    def everywhere(self: Any, *arguments: Any, **named: Any) -> Floats:
        bound = signature.bind(self, *arguments, **named).arguments
        rest = {name: value for name, value in bound.items() if name == "time"}
        with np.errstate(over="ignore"):
            given = np.broadcast_arrays(*(real_array(bound[name], name) for name in places))
            finite = np.logical_and.reduce([np.isfinite(argument) for argument in given])
            if finite.all() and finite.size:
                return density(self, *given, **rest)
            values = np.where(np.logical_or.reduce([np.isnan(argument) for argument in given]), np.nan, 0.0)
            if finite.any():
                values[finite] = density(self, *(argument[finite] for argument in given), **rest)
            return values

    return everywhere


@dataclass(frozen=True)
class Normals:
    """Densities of two independent normals, the first cut off at the wall (NaN for none); dimensionless."""

    units: Units
    x_spread: float
    v_spread: float
    wall: float

    def x(self, x: Floats) -> Floats:
        """Density of the displacement."""
        return normal(x, self.x_spread**2) if math.isnan(self.wall) else _cut_normal(x, self.x_spread, self.wall)

    def v(self, v: Floats) -> Floats:
        """Density of the velocity."""
        return normal(v, self.v_spread**2)

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of both."""
        return np.asarray(self.x(x) * self.v(v))

    def amplitude(self, amplitude: Floats) -> Floats:
        """Density of sqrt(x^2 + v^2)."""
        if math.isnan(self.wall) or self.wall == 0.0:  # which halves every circle
            return hoyt(amplitude, self.x_spread**2, self.v_spread**2)
        return _cut_rayleigh(amplitude, self.x_spread, self.wall)

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed just before an impact."""
        return rayleigh(speed, 2.0 * self.v_spread**2)


def hazard_of(k: float) -> float:
    """phi(k) / (1 - Phi(k)), the inverse of Mills' ratio; 0 where it is below double precision."""
    from scipy import special  # slow to import, and most runs need none of it

    return math.sqrt(2.0 / math.pi) / float(special.erfcx(k / math.sqrt(2.0)))


def _cut_normal(value: Floats, spread: float, wall: float) -> Floats:
    """Normal density on value >= wall, normalized there."""
    from scipy import special  # slow to import, and most runs need none of it

    k = wall / spread
    z = np.clip(value / spread - k, -1.0, _FAR + abs(k))
    if k > 0.0:  # k^2 is taken out by hand: under a deep preload it is huge
        shape = hazard_of(k) * np.exp(-z * (k + z / 2.0))
    else:
        shape = np.exp(-((z + k) ** 2) / 2.0) / (math.sqrt(2.0 * math.pi) * float(special.ndtr(-k)))
    return np.asarray(np.where(z >= 0.0, shape, 0.0) / spread)


def _cut_rayleigh(amplitude: Floats, spread: float, wall: float) -> Floats:
    """Rayleigh density of an amplitude whose phase is uniform on the arc beyond the wall."""
    from scipy import special  # slow to import, and most runs need none of it

    k = wall / spread
    a = np.clip(amplitude / spread, 0.0, _FAR + abs(k))
    with np.errstate(divide="ignore", invalid="ignore"):
        arc = np.arccos(np.clip(np.nan_to_num(k / a), -1.0, 1.0)) / math.pi
    if k > 0.0:  # 1 - Phi(k) = exp(-k^2 / 2) erfcx(k / sqrt 2) / 2
        shape = np.exp(-np.maximum(a - k, 0.0) * (a + k) / 2.0) * 2.0 / float(special.erfcx(k / math.sqrt(2.0)))
    else:
        shape = np.exp(-a * a / 2.0) / float(special.ndtr(-k))
    return np.asarray(a * arc * shape / spread)
