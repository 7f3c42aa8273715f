"""Spectral densities of a device's data sheet, and the intensity of the white noise: every factor of 2 is here.

A device of mass m on a spring k and a springpot k_alpha moves by x relative to its base,

    m x'' + k_alpha D^alpha x + k x = -m a_base(t)      shaken base,
    m x'' + k_alpha D^alpha x + k x = F(t)              force on the mass.

Divided by m this is the equation of `Oscillator`: Omega = sqrt(k / m), C = k_alpha / m, and zeta = -a_base or F / m.

White noise with E[zeta(t) zeta(s)] = q delta(t - s) has the two-sided spectral density
S(f) = int R(tau) exp(-2 pi i f tau) dtau = q per Hz, at all f from -inf to inf.  The one-sided density per Hz, which
test equipment and standards state, has the same power on f > 0 only: G(f) = 2 q.  Hence q = G / 2.  A density of force
is divided by m^2 first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, get_args

from springpot.files.units import FREQUENCY_UNITS, STANDARD_GRAVITY
from springpot.machine.arguments import LARGEST, check_plain, finite_number, one_of, positive_number

__all__ = ["STANDARD_GRAVITY", "intensity_from_psd", "psd_from_intensity"]

DensityUnit = Literal["g2/Hz", "m2/s4/Hz", "N2/Hz"]
FrequencyUnit = Literal["Hz", "kHz", "rad/s"]
Excited = Literal["base", "force"]
Sides = Literal[1, 2]


def _density_of_one(unit: object, sides: object, mass: object) -> float:
    """Intensity of the noise, in m^2/s^3, whose spectral density is 1 in this unit."""
    one_of(unit, "psd_unit", get_args(DensityUnit), "N2/Hz is a density of force, the others are of acceleration.")
    one_of(sides, "sides", get_args(Sides), "1: positive frequencies only, as in test practice; 2: both signs.")
    if unit == "N2/Hz":
        if mass is None:
            raise ValueError("mass must be given with psd_unit='N2/Hz': a density of force is divided by mass^2.")
        scale = 1.0 / positive_number(mass, "mass", "It is in kg.")
    else:
        scale = STANDARD_GRAVITY if unit == "g2/Hz" else 1.0
    return scale**2 * (0.5 if sides == 1 else 1.0)


def intensity_from_psd(psd: float, unit: DensityUnit, *, sides: Sides = 1, mass: float | None = None) -> float:
    """Intensity q of the white noise that has this spectral density.

    Parameters
    ----------
    psd : float
        Spectral density, at least 0.
    unit : {"g2/Hz", "m2/s4/Hz", "N2/Hz"}
        Of an acceleration, in standard gravity or in m/s^2, or of a force.
    sides : {1, 2}
        1 for a one-sided density (positive frequencies only, as test equipment and standards state it), 2 for a
        two-sided one.
    mass : float, optional
        In kg; needed for a density of force, and not used otherwise.

    Returns
    -------
    float
        q in m^2/s^3: the two-sided density of the acceleration in (m/s^2)^2/Hz, which is half of a one-sided one.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range, or a word is not one of those above.

    Examples
    --------
    >>> round(intensity_from_psd(0.01, "g2/Hz"), 4)  # 0.01 * 9.80665^2 / 2
    0.4809
    >>> intensity_from_psd(8.0, "N2/Hz", mass=2.0)
    1.0
    """
    psd = finite_number(psd, "psd", low=0.0, high=LARGEST, hint="It is a spectral density.")
    check_plain(psd, "psd", "mark the intensity of a WhiteNoise instead")
    return psd * _density_of_one(unit, sides, mass)


def psd_from_intensity(intensity: float, unit: DensityUnit, *, sides: Sides = 1, mass: float | None = None) -> float:
    """Spectral density of the white noise with this intensity: the inverse of `intensity_from_psd`.

    Parameters
    ----------
    intensity : float
        q in m^2/s^3.
    unit, sides, mass
        Those of `intensity_from_psd`.

    Returns
    -------
    float

    Raises
    ------
    TypeError, ValueError
        Those of `intensity_from_psd`.

    Examples
    --------
    >>> psd_from_intensity(1.0, "m2/s4/Hz")
    2.0
    """
    intensity = finite_number(intensity, "intensity", low=0.0, high=LARGEST, hint="It is q in m^2/s^3.")
    return intensity / _density_of_one(unit, sides, mass)


def check_excited(of: object, unit: DensityUnit) -> None:
    """What a density is said to be of must agree with its unit.

    Raises
    ------
    ValueError
        If it does not.
    """
    if of is None:
        return
    one_of(of, "of", get_args(Excited), "It says what the spectral density is of.")
    if of != ("force" if unit == "N2/Hz" else "base"):
        right = "psd_unit='N2/Hz'" if of == "force" else "psd_unit='g2/Hz' or psd_unit='m2/s4/Hz'"
        raise ValueError(f"of={of!r} needs {right}, not {unit!r}.")


OCTAVE = 10.0 * math.log10(2.0)
"""dB of a density that is proportional to the frequency, in an octave."""


def one_sided_si(psd: Sequence[float], unit: DensityUnit, sides: Sides) -> tuple[float, ...]:
    """One-sided densities in (m/s^2)^2/Hz or N^2/Hz."""
    size = 2.0 * _density_of_one(unit, sides, 1.0)
    return tuple(size * value for value in psd)


def in_hertz(frequency: Sequence[float], unit: FrequencyUnit) -> tuple[float, ...]:
    """Frequencies in Hz."""
    one_of(unit, "frequency_unit", get_args(FrequencyUnit), "The density is per Hz whatever it is.")
    return tuple(FREQUENCY_UNITS[unit] * value for value in frequency)


def along_slopes(frequency: Sequence[float], slopes: Sequence[float], psd: float, at: float) -> tuple[float, ...]:
    """Densities at break points from the slopes between them, in dB per octave, and the density at a frequency.

    Examples
    --------
    >>> [round(value, 4) for value in along_slopes((20.0, 80.0, 350.0, 2000.0), (3.0, 0.0, -3.0), 0.04, 100.0)]
    [0.01, 0.04, 0.04, 0.007]
    """
    if len(slopes) != len(frequency) - 1:
        raise ValueError(
            f"slopes must be one for each piece between two frequencies, {len(frequency) - 1}, not {len(slopes)}."
        )
    if not frequency[0] <= at <= frequency[-1]:
        raise ValueError(f"at must lie between {frequency[0]:g} and {frequency[-1]:g}, not {at:g}: there psd is given.")
    rises = [
        slope / OCTAVE * math.log(high / low)
        for slope, low, high in zip(slopes, frequency, frequency[1:], strict=False)
    ]
    logs = [math.fsum(rises[:n]) for n in range(len(frequency))]
    place = max(n for n in range(len(slopes)) if frequency[n] <= at)
    there = logs[place] + slopes[place] / OCTAVE * math.log(at / frequency[place])
    return tuple(psd * math.exp(log - there) for log in logs)
