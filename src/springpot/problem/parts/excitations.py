"""Excitations: forces on the mass, accelerations of the ground, and noise that multiplies the displacement."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Self

from springpot.machine.faults import shown
from springpot.problem.parts.checks import put, real
from springpot.problem.parts.registration import Element, Ends, Number, Part, PointName, checked_ends
from springpot.problem.spectral_density import DensityUnit, Sides, intensity_from_psd

__all__ = [
    "ColoredNoise",
    "Constant",
    "Excitation",
    "Force",
    "Harmonic",
    "KanaiTajimiNoise",
    "On",
    "ParametricNoise",
    "PoissonImpulses",
    "RecordedExcitation",
    "ThermalNoise",
    "WhiteNoise",
]  # fmt: skip

On = PointName
"""A force on the mass, ``"mass"``, or on one of several by its name, or an acceleration a of the ``"ground"``: x is
then the displacement relative to the ground, and the force is -m a."""
Units = Callable[[str], str]


class Excitation(Part, abstract=True):
    """What is on the right-hand side of the equation of motion."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(on := getattr(self, "on", "mass"), str) or not on.isidentifier():
            raise ValueError(f"on must be 'mass' (a force) or 'ground' (its acceleration), not {shown(on)}.")

    def alone(self) -> Self:
        """On the mass, whatever its name."""
        named = {"on": "mass"} if getattr(self, "on", "mass") not in ("mass", "ground") else {}
        ends = {"between": None} if getattr(self, "between", None) else {}
        return replace(self, **named, **ends) if named or ends else self  # type: ignore[type-var]

    def words(self, name: str, unit: Units) -> str:
        """What it is, where it has a symbol in the equation; ``unit`` gives the units of its numbers."""
        return ""

    def factor(self, heavy: bool) -> str:
        """What stands before its symbol in the equation, with a mass or per unit mass."""
        return ("-m " if heavy else "-") if self.of_ground else ""


@dataclass(frozen=True)
class WhiteNoise(Excitation):
    """Gaussian white noise, E[zeta(t) zeta(s)] = q delta(t - s).

    Parameters
    ----------
    intensity : float
        q >= 0; its two-sided spectral density is q / (2 pi) per rad/s.  0 gives the free response.  Of a force it is in
        N^2 s; per unit mass, and of an acceleration of the ground, in m^2 s^-3.
    on : str
        A force on the ``"mass"``, or on one of several by its name, or the acceleration of the ``"ground"``.

    Raises
    ------
    TypeError, ValueError
        If it is not a number, not finite or negative.

    Examples
    --------
    >>> WhiteNoise(intensity=2).intensity
    2.0
    """

    said, glyph, powers = "white noise", "rough", ("input",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    intensity: Annotated[
        float, Number("q", "intensity", "N2 s", "unsigned", "It is q = sigma^2 of the white noise.")
    ] = 1.0
    on: On = "mass"

    @classmethod
    def from_psd(cls, psd: float, psd_unit: DensityUnit, *, sides: Sides = 1, on: str = "") -> WhiteNoise:
        """The noise with a flat spectral density, as test equipment and standards state it.

        Parameters
        ----------
        psd : float
            The density.
        psd_unit : {"g2/Hz", "m2/s4/Hz", "N2/Hz"}
            Of the ground's acceleration in standard gravity or in m/s^2, or of a force on the mass.
        sides : {1, 2}
            1: the density is one-sided (positive frequencies only); 2: two-sided.
        on : str
            The mass on which the force acts, by its name, where there are several.

        Returns
        -------
        WhiteNoise

        Raises
        ------
        TypeError, ValueError
            If the number or one of the words is not what it must be.

        Examples
        --------
        >>> WhiteNoise.from_psd(0.01, "g2/Hz").on
        'ground'
        """
        intensity = intensity_from_psd(psd, psd_unit, sides=sides, mass=1.0)
        if psd_unit != "N2/Hz" and on not in ("", "ground"):
            raise ValueError(f"on must be left out with a density in {psd_unit}, which is that of the ground.")
        return cls(intensity, (on or "mass") if psd_unit == "N2/Hz" else "ground")

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        return self.intensity / (2.0 * math.pi)

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return f"white noise ({name}), intensity {self.intensity:.6g} {unit('intensity')}"


@dataclass(frozen=True)
class ColoredNoise(Excitation):
    """Exponentially correlated (Ornstein-Uhlenbeck) noise, E[y(t) y(s)] = s2 exp(-\\|t - s\\| / tau).

    Parameters
    ----------
    variance : float
        s2 > 0, in N^2; per unit mass, and of the ground, in m^2/s^4.  White noise of the same density at low frequency
        has q = 2 s2 tau.
    correlation_time : float
        tau > 0, in s.
    on : str
        A force on the ``"mass"``, or on one of several by its name, or the acceleration of the ``"ground"``.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Examples
    --------
    >>> round(ColoredNoise(1.0, 0.5).density(0.0), 4)
    0.1592
    """

    said, glyph, powers = "colored noise", "smooth", ("fed",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    variance: Annotated[float, Number("s²", "variance", "N2", "positive", "It is the mean square of the noise.")]
    correlation_time: Annotated[float, Number("τ", "correlation time", "s", "positive", "It is in s.")]
    on: On = "mass"

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        return self.variance * self.correlation_time / (math.pi * (1.0 + (w * self.correlation_time) ** 2))

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        variance = f"{self.variance:.6g} {unit('variance')}"
        return f"colored noise ({name}), variance {variance}, correlation time {self.correlation_time:.6g} s"


@dataclass(frozen=True)
class KanaiTajimiNoise(Excitation):
    """White noise filtered by the ground (Kanai-Tajimi): wg^2 u + 2 zg wg u', with u'' + 2 zg wg u' + wg^2 u = white.

    Parameters
    ----------
    frequency : float
        wg > 0 of the filter, in rad/s.
    damping : float
        zg in (0, 1] of the filter.
    intensity : float
        qg > 0 of the white noise; at low frequency the filter passes it as it is.
    on : str
        The acceleration of the ``"ground"``, or a force on the ``"mass"``, or on one of several by its name.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    Examples
    --------
    >>> round(KanaiTajimiNoise(3.0, 0.4, 1.0).density(0.0), 4)  # 1 / (2 pi)
    0.1592
    """

    said, glyph, powers = "kanai tajimi noise", "smooth", ("fed",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    frequency: Annotated[float, Number("ω", "filter at", "rad s-1", "positive", "It is the filter's, in rad/s.")]
    damping: Annotated[float, Number("ζ", "damping ratio", "1", "share", "It is the filter's damping ratio.")]
    intensity: Annotated[
        float, Number("q", "intensity", "N2 s", "positive", "It is that of the white noise before the filter.")
    ]
    on: On = "ground"

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        ratio, twice = abs(w) / self.frequency, 2.0 * self.damping
        if ratio > 1.0:  # the powers of a far frequency would overflow
            passed = (ratio**-2 + twice**2) / ((1.0 / ratio - ratio) * (1.0 / ratio - ratio) + twice**2)
        else:
            passed = (1.0 + (twice * ratio) ** 2) / ((1.0 - ratio**2) ** 2 + (twice * ratio) ** 2)
        return self.intensity / (2.0 * math.pi) * passed

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return (
            f"filtered noise ({name}), filter at {self.frequency:.6g} rad/s with damping ratio {self.damping:.6g}, "
            f"intensity {self.intensity:.6g} {unit('intensity')}"
        )


@dataclass(frozen=True)
class Constant(Excitation):
    """A constant force, such as a weight.

    Parameters
    ----------
    force : float
        In N; per unit mass in m/s^2.
    on : str
        The mass on which it acts, by its name, where there are several.

    Raises
    ------
    TypeError, ValueError
        If it is not a finite number.

    Examples
    --------
    >>> Constant(-9.81).force
    -9.81
    """

    said, glyph, powers = "constant", "flat", ("stored",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, False

    force: Annotated[float, Number("F", "force", "N", "signed", "It is constant, in N.")]
    on: On = field(default="mass", repr=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_on_mass(self.on)

    def force_coefficients(self) -> tuple[float, ...]:
        """Minus the force."""
        return (-self.force,)

    def term(self) -> str:
        """Its force on the right-hand side."""
        return f"{self.force:.6g}"


@dataclass(frozen=True)
class Harmonic(Excitation):
    """A harmonic force F cos(nu t + phase), the phase of each path random: averages are those over a whole period.

    Parameters
    ----------
    amplitude : float
        F >= 0, in N; per unit mass, and of the ground, in m/s^2.
    frequency : float
        nu > 0, in rad/s.
    on : str
        A force on the ``"mass"``, or on one of several by its name, or the acceleration of the ``"ground"``.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    Examples
    --------
    >>> Harmonic(amplitude=0.1, frequency=20.0).frequency
    20.0
    """

    said, glyph, powers = "harmonic", "sine", ("fed",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    amplitude: Annotated[float, Number("F", "amplitude", "N", "unsigned", "It is that of the force.")]
    frequency: Annotated[float, Number("ν", "frequency", "rad s-1", "positive", "It is in rad/s.")]
    on: On = "mass"

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        size = f"{self.amplitude:.6g} {unit('amplitude')}"
        return f"{size} cos({self.frequency:.6g} t + a random phase) ({name})"


@dataclass(frozen=True)
class RecordedExcitation(Excitation):
    """A force or an acceleration of the ground that was recorded: straight lines between the points, 0 after the last.

    A run begins at the first point.

    Parameters
    ----------
    time : tuple of float
        Increasing, in s; at least two.
    values : tuple of float
        One for each time, in N; per unit mass, and of the ground, in m/s^2.
    on : str
        The acceleration of the ``"ground"``, or a force on the ``"mass"``, or on one of several by its name.

    Raises
    ------
    TypeError, ValueError
        If the times do not increase, the two have different lengths, or something is not a finite number.

    Examples
    --------
    >>> record = RecordedExcitation((0.0, 1.0, 2.0), (0.0, 3.0, 0.0))
    >>> record.duration, record.mean_square
    (2.0, 3.0)
    """

    said, glyph, powers = "recorded excitation", "rough", ("fed",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, False

    time: Annotated[tuple[float, ...], Number("t", "time", "s", own=True)]
    values: Annotated[tuple[float, ...], Number("×", "the record times", "N", turns=True, own=True)]
    on: On = "ground"

    def __post_init__(self) -> None:
        put(self, time=_numbers(self.time, "time"), values=_numbers(self.values, "values"))
        if len(self.time) != len(self.values) or len(self.time) < 2:
            raise ValueError(
                f"time and values must have the same number of points, two or more, not {len(self.time)} and "
                f"{len(self.values)}."
            )
        if any(later <= earlier for earlier, later in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time must increase from each point to the next.")
        super().__post_init__()

    @property
    def duration(self) -> float:
        """From the first point to the last, in s."""
        return self.time[-1] - self.time[0]

    @property
    def mean_square(self) -> float:
        """Of the values, over time."""
        pieces = zip(self.time, self.time[1:], self.values, self.values[1:], strict=False)
        return math.fsum((t1 - t0) * (a * a + a * b + b * b) / 3.0 for t0, t1, a, b in pieces) / self.duration

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        rms = f"root mean square {math.sqrt(self.mean_square):.6g} {unit('values')}"
        return f"a record of {self.duration:.6g} s ({name}), {rms}"


@dataclass(frozen=True)
class Force(Excitation):
    """A force of your own, f(t, x, v), which Numba can compile.

    Parameters
    ----------
    function : callable
        f(t, x, v) in N, of the time since the start of the run in s, x in m and v in m/s; per unit mass in m/s^2.
    share : float
        Factor on it.
    on : str
        The mass on which it acts, by its name, where there are several; x and v are those of this mass.
    between : tuple of str, optional
        Instead the two masses between which it acts, as a part with two ends does: x and v are those of the second
        less those of the first, which feels the opposite force.

    Raises
    ------
    TypeError, ValueError
        If it is not a function, the factor is not a finite number, or both ``on`` and ``between`` are given.

    Notes
    -----
    Monte Carlo knows the function only: no theory covers it, and the step is chosen from the other parts.  A fast
    force needs an explicit ``step``.

    Examples
    --------
    >>> magnet = Force(lambda t, x, v: 0.1 / (x - 2.0) ** 2)
    >>> magnet.share
    1.0
    """

    said, glyph, powers = "force", "sine", ("work",)
    is_linear, remembers, dissipates, is_thermal, is_odd = False, False, False, False, False

    function: Callable[[float, float, float], float]
    share: Annotated[
        float, Number("×", "the function times", "1", "signed", "It is a factor on the function.", mass=1.0)
    ] = 1.0
    on: On = field(default="mass", repr=False, kw_only=True)
    between: Ends = field(default=None, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise TypeError(f"function must be a function f(t, x, v), not {shown(self.function)}.")
        super().__post_init__()
        _check_on_mass(self.on)
        if self.between is not None:
            put(self, between=checked_ends(self.between))
            if self.on != "mass":
                raise ValueError(f"on must be left out of a force between two ends, not {self.on!r}.")

    @property
    def has_function(self) -> bool:
        """It is one."""
        return True

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return f"a function of t, x and v ({name})"


@dataclass(frozen=True)
class PoissonImpulses(Excitation):
    """Random impulses at random times: a Poisson process of impulses of normal, independent sizes of mean zero.

    Parameters
    ----------
    rate : float
        Impulses per second, above 0.
    mean_square : float
        Mean square of an impulse, above 0, in (N s)^2; per unit mass, and of the ground, in m^2/s^2.  White noise with
        the same second moments has q = rate * mean_square.
    on : str
        A force on the ``"mass"``, or on one of several by its name, or the acceleration of the ``"ground"``.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    Examples
    --------
    >>> PoissonImpulses(0.5, 2.0).intensity
    1.0
    """

    said, glyph, powers = "poisson impulses", "spikes", ("input",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    rate: Annotated[float, Number("λ", "rate", "s-1", "positive", "It is the number of impulses per second.")]
    mean_square: Annotated[float, Number("y²", "mean square", "N2 s2", "positive", "It is that of an impulse.")]
    on: On = "mass"

    @property
    def intensity(self) -> float:
        """q of the white noise with the same second moments."""
        return self.rate * self.mean_square

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        return self.intensity / (2.0 * math.pi)

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        size = f"mean square {self.mean_square:.6g} {unit('mean_square')}"
        return f"impulses at random times ({name}), {self.rate:.6g} per second, {size}"


@dataclass(frozen=True)
class ParametricNoise(Element, Excitation):
    """A white noise that multiplies the displacement, in the sense of Ito and of Stratonovich alike: the force x xi2.

    Between two masses it multiplies the elongation: a spring whose stiffness is a white noise.

    Parameters
    ----------
    intensity : float
        q2 > 0 of xi2, in N^2 s/m^2; per unit mass in s^-3.

    Raises
    ------
    TypeError, ValueError
        If it is not a number, not finite or not positive.

    Examples
    --------
    >>> ParametricNoise(0.1).intensity
    0.1
    """

    said, glyph, powers = "parametric noise", "rough", ("input",)
    is_linear, remembers, dissipates, is_thermal, is_odd = False, False, False, True, True

    intensity: Annotated[
        float, Number("q", "intensity", "N2 s m-2", "positive", "It is that of the noise that multiplies x.")
    ]

    def factor(self, heavy: bool) -> str:
        """It multiplies x."""
        return "x "

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return f"white noise ({name}) that multiplies x, intensity {self.intensity:.6g}"


@dataclass(frozen=True)
class ThermalNoise(Excitation):
    """The noise of every dissipator at one temperature: with it, and elastic walls, the motion obeys Boltzmann's law.

    Each dashpot, springpot, arm and circuit has the noise that the fluctuation-dissipation theorem gives it.

    Parameters
    ----------
    temperature : float
        kT > 0, an energy in J; per unit mass in m^2/s^2.

    Raises
    ------
    TypeError, ValueError
        If it is not a number, not finite or not positive.

    References
    ----------
    R. Kubo, "The fluctuation-dissipation theorem", Reports on Progress in Physics 29 (1966).

    Examples
    --------
    >>> ThermalNoise(0.7).temperature
    0.7
    """

    said, glyph, powers = "thermal noise", "rough", ("fed",)
    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True

    temperature: Annotated[float, Number("kT", "temperature", "J", "positive", "It is kT, an energy.")]

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return f"noise of every dissipator ({name}) at kT = {self.temperature:.6g} {unit('temperature')}"


def _check_on_mass(on: str) -> None:
    if on == "ground":
        raise ValueError("on must be the name of a mass here, not 'ground': it is a force.")


def _numbers(values: object, name: str) -> tuple[float, ...]:
    """The numbers of a table, one by one."""
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise TypeError(f"{name} must be a list of numbers, not {shown(values)}.")
    return tuple(real(value, f"{name}[{place}]", "It is a point of the record.") for place, value in enumerate(values))
