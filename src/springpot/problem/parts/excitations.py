"""Excitations: forces on the mass, accelerations of the ground, and noise that multiplies the displacement."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, cast, get_args

from springpot.files.units import Decimal
from springpot.machine.arguments import (
    LARGEST,
    check_plain,
    checked_name,
    checked_path,
    finite_number,
    items_of,
    positive_number,
    without_axis,
)
from springpot.machine.faults import FileError, known_word, listed, meant, per_cent, shown
from springpot.problem.messages import warn_of_file
from springpot.problem.parts.checks import numbers_in, put
from springpot.problem.parts.envelopes import Envelope
from springpot.problem.parts.registration import (
    Element,
    Ends,
    Filter,
    Instead,
    Law,
    Number,
    Part,
    PointName,
    check_between,
    checked_ends,
)
from springpot.problem.spectral_density import (
    STANDARD_GRAVITY,
    DensityUnit,
    FrequencyUnit,
    Sides,
    along_slopes,
    in_hertz,
    intensity_from_psd,
    one_sided_si,
    psd_from_intensity,
)

if TYPE_CHECKING:
    from springpot.files.table import Stated
    from springpot.machine.arrays import Floats
    from springpot.problem.coordinates import Coordinates

__all__ = [
    "CloughPenzienNoise",
    "ColoredNoise",
    "Constant",
    "Excitation",
    "Force",
    "Harmonic",
    "KanaiTajimiNoise",
    "On",
    "ParametricNoise",
    "PoissonImpulses",
    "SpectralExcitation",
    "ThermalNoise",
    "WhiteNoise",
]  # fmt: skip

On = PointName
"""A force on the mass, ``"mass"``, or on one of several by its name, or an acceleration a of the ``"ground"``: x is
then the displacement relative to the ground, and the force is -m a."""
Units = Callable[[str], str]
RmsUnit = Literal["g", "m/s2", "N"]
"""Of a root mean square: of the ground's acceleration in standard gravity or m/s^2, or of a force."""
Over = Envelope | None
"""An envelope by which a stationary noise is multiplied, a function of time."""

MOST_POINTS = 1000  # of a table of densities
MOST_LINES = 100  # at equal steps, of a table in a file that is not thinned unasked
TOLERANCE = 0.05
_GRID = 400
_A_DENSITY = "It is a density, not a level in dB, which is 10 log10 of it."


class Excitation(Part, abstract=True):
    """What is on the right-hand side of the equation of motion."""

    is_linear, remembers, dissipates, is_thermal, is_odd = True, False, False, True, True  # where a kind says no other
    shakes_ground = True  # whether it may act on the ground
    envelope = cast(Any, None)  # a field of the noises that can have one
    filter_order: ClassVar[int | None] = None  # states of the filter that white noise drives; None of other excitation
    factor = ""  # what stands before its symbol in the equation
    is_gaussian = True  # whether linear motion under it is Gaussian
    is_banded = False  # whether it feeds motions of some frequencies alone

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_name(getattr(self, "on", "mass"), "on", "be 'mass' (a force) or 'ground' (its acceleration)")
        if not isinstance(self.envelope, Envelope | None):
            raise TypeError(
                "envelope must be an envelope, such as ExponentialEnvelope(slow=0.2, fast=0.6), not "
                f"{shown(self.envelope)}."
            )

    def push(self, at: Coordinates) -> Floats | None:
        """On its point."""
        return at.push(getattr(self, "on", "mass"))

    def check_ends(self, name: str, points: tuple[str, ...]) -> None:
        """That it acts on one of them."""
        of_one, ground = ["mass"] if len(points) == 1 else [], ["ground"] if self.shakes_ground else []
        known, on = [*dict.fromkeys([*of_one, *points, *ground])], getattr(self, "on", "")
        if on and on not in known:
            near = meant(on, known) or "."
            raise ValueError(f"on of {name} must be {listed([*map(repr, known)], 'or')}, not {shown(on)}{near}")

    @property
    def has_density(self) -> bool:
        """Whether it is stationary noise with a spectral density."""
        return bool(self.noise)

    @property
    def is_white(self) -> bool:
        """Whether this noise has no finite mean square: no filter made it."""
        return self.has_density and self.noise != "filtered"

    @property
    def white_intensity(self) -> float:
        """q of the white noise with its second moments; 0 of noise that is not white."""
        return 0.0

    @property
    def impulses(self) -> tuple[float, float]:
        """How many strike per second, and their mean square; 0 of what is no shot noise."""
        return 0.0, 0.0

    @property
    def correlated_for(self) -> float:
        """The time in which this noise forgets itself, in s."""
        return 0.0

    @property
    def feeds(self) -> bool:
        """Where it is a noise."""
        return bool(self.noise)

    @property
    def excites(self) -> bool:
        """Whether it is noise that moves a mass at rest."""
        return bool(self.noise) and self.sustains

    @property
    def records(self) -> tuple[tuple[tuple[float, ...], tuple[float, ...]], ...]:
        """Times and values of what was recorded, without the scale."""
        return ()

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s of a stationary noise in it; 0 of what has none."""
        return self.white_intensity / (2.0 * math.pi)

    @property
    def slow_intensity(self) -> float:
        """That of the white noise which moves what is slow alike."""
        return 2.0 * math.pi * self.density(0.0)

    @property
    def is_random(self) -> bool:
        """Whether paths differ by chance under it."""
        return bool(self.noise)

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """Of a noise, by its density there; without its envelope it would be stationary."""
        if self.is_white:
            return 0.5 * float(self.white_intensity) * self.largest_square
        return math.pi * self.density(frequency) * self.largest_square

    def fed_into_mode(self, frequency: float) -> float:
        """Power that it feeds into a mode of unit modal mass, about."""
        return float(self.fed_into(max(frequency, 1e-300), lambda: 0.0, 0.0))

    def alone(self) -> Self:
        """On the mass, whatever its name."""
        named = {"on": "mass"} if getattr(self, "on", "mass") not in ("mass", "ground") else {}
        ends = {"between": None} if getattr(self, "between", None) else {}
        return replace(self, **named, **ends) if named or ends else self  # type: ignore[type-var]

    def words(self, name: str, unit: Units) -> str:
        """What it is, where it has a symbol in the equation; ``unit`` gives the units of its numbers."""
        return ""

    def modulated(self, words: str) -> str:
        """What it is, with its envelope."""
        return words if self.envelope is None else f"{words}, modulated by {self.envelope.words()}"

    @property
    def duration(self) -> float:
        """How long it lasts, in s; 0 of what goes on for ever."""
        return 0.0 if self.envelope is None else float(self.envelope.duration)

    @property
    def largest_square(self) -> float:
        """The largest value of the square of its envelope; 1 without one."""
        return 1.0 if self.envelope is None else self.envelope.largest**2

    def square_at(self, time: Any) -> Any:
        """The square of its envelope at times in s; 1 without one."""
        return 1.0 if self.envelope is None else self.envelope.at(time) ** 2


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
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which it is multiplied: there is no stationary state then.

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
    filter_order = 0
    noise, is_of_paper = "white", True

    intensity: Annotated[
        float, Number("q", "intensity", "N2 s", "unsigned", "It is q = sigma^2 of the white noise.")
    ] = 1.0
    on: On = "mass"
    envelope: Over = field(default=None, repr=False, kw_only=True)

    @property
    def feeds(self) -> bool:
        """Whether it is not 0."""
        return bool(self.intensity)

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
        return cls(intensity_from_psd(psd, psd_unit, sides=sides, mass=1.0), driven(psd_unit, on))

    @property
    def white_intensity(self) -> float:
        """q."""
        return self.intensity

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        one_sided = f", one-sided {psd_from_intensity(self.intensity, 'g2/Hz'):.6g} g^2/Hz" if self.of_ground else ""
        return self.modulated(f"white noise ({name}), intensity {self.intensity:.6g} {unit('intensity')}{one_sided}")


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
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which the white noise is multiplied that drives it: there is no stationary state then.

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
    filter_order = 1
    noise = "filtered"

    variance: Annotated[float, Number("s²", "variance", "N2", "positive", "It is the mean square of the noise.")]
    correlation_time: Annotated[float, Number("τ", "correlation time", "s", "positive", "It is in s.")]
    on: On = "mass"
    envelope: Over = field(default=None, repr=False, kw_only=True)

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        return self.variance * self.correlation_time / (math.pi * (1.0 + (w * self.correlation_time) ** 2))

    @property
    def correlated_for(self) -> float:
        """Its correlation time."""
        return self.correlation_time

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """The end of its band."""
        return [1.0 / self.correlation_time]

    def filter_at(self, time: float) -> Filter:
        """Of first order."""
        intensity = 2.0 * self.variance / self.correlation_time
        return Filter(((-1.0 / self.correlation_time,),), (1.0,), 0, intensity)

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        variance = f"{self.variance:.6g} {unit('variance')}"
        return self.modulated(
            f"colored noise ({name}), variance {variance}, correlation time {self.correlation_time:.6g} s"
        )


_Before = Annotated[
    float, Number("q", "intensity", "N2 s", "positive", "It is that of the white noise before filters.")
]


@dataclass(frozen=True)
class GroundNoise(Excitation, abstract=True):
    """White noise filtered by the ground, whose frequency may change in time."""

    said, glyph, powers = "ground noise", "smooth", ("fed",)
    noise = "filtered"

    frequency: Annotated[float, Number("ω", "filter at", "rad s-1", "positive", "It is the filter's, in rad/s.")]
    damping: Annotated[float, Number("ζ", "damping ratio", "1", "share", "It is the filter's damping ratio.")]
    frequency_rate: Annotated[
        float, Number("ω'", "frequency changes by", "rad s-2", "signed", "It is negative of ground that softens.")
    ] = field(default=0.0, repr=False, kw_only=True)
    envelope: Over = field(default=None, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.frequency_rate and self.envelope is None:
            raise ValueError("frequency_rate needs an envelope: without one the noise would have no end.")

    @classmethod
    def from_rms(cls, rms: float, unit: RmsUnit, *, on: str = "", **numbers: Any) -> Self:
        """The noise with this root mean square: without an envelope, and before its frequency changes.

        Parameters
        ----------
        rms : float
            Of the ground's acceleration, or of a force.
        unit : {"g", "m/s2", "N"}
            Of the rms: standard gravity, m/s^2, or N.
        on : str
            The mass on which the force acts, by its name, where there are several.
        **numbers
            The others of the noise: all but ``intensity``.  A frequency in Hz is given as ``frequency_hz`` or
            ``base_frequency_hz``.

        Raises
        ------
        TypeError, ValueError
            If a number or one of the words is not what it must be.

        Examples
        --------
        >>> noise = KanaiTajimiNoise.from_rms(0.1, "g", frequency=15.0, damping=0.6)
        >>> round(noise.intensity, 6), round(noise.rms / 9.80665, 6)
        (0.063063, 0.1)
        >>> KanaiTajimiNoise.from_rms(0.1, "g", frequency_hz=2.0, damping=0.6).frequency == 4.0 * math.pi
        True
        """
        known_word(unit, get_args(RmsUnit), "unit")
        rms = finite_number(rms, "rms", low=0.0, open_low=True, hint="It is the root mean square of the noise.")
        if "intensity" in numbers:
            raise TypeError("intensity must be left out: rms takes its place.")
        for name in [name for name in numbers if name.endswith("frequency_hz")]:
            if (own := name.removesuffix("_hz")) in numbers:
                raise TypeError(f"{name} must be left out where {own} is given.")
            numbers[own] = _turned(numbers.pop(name), name)
        for name in {*numbers} - {"frequency_rate"}:  # all of which the rms depends on
            check_plain(numbers[name], name, f"only rms may be marked, or the numbers of {cls.__name__}(...) itself")
        kind, size = cast(Any, cls), rms * (STANDARD_GRAVITY if unit == "g" else 1.0)
        found = kind(**numbers, intensity=1.0, on=driven(unit, on, "an rms"))
        return cast(Self, replace(found, intensity=(size / found.rms) ** 2))

    def frequency_at(self, time: float, name: str) -> float:
        """That of the ground's filter at a time.

        Raises
        ------
        ValueError
            If it is not above 0 there.
        """
        found = self.frequency + self.frequency_rate * time
        if not found > 0.0:
            raise ValueError(
                f"{name} has a frequency_rate of {self.frequency_rate:g} rad/s^2, which takes its frequency to 0 at "
                f"{-self.frequency / self.frequency_rate:.4g} s: end the run before."
            )
        return found

    def ground_at(self, time: float) -> tuple[tuple[tuple[float, float], ...], tuple[float, float]]:
        """Rates of the states w u and u' of the ground, with w of time 0, and its acceleration by them."""
        first, w = self.frequency, self.frequency_at(time, "the noise")
        pull, drag = w * w / first, 2.0 * self.damping * w
        return ((0.0, first), (-pull, -drag)), (pull, drag)

    @property
    def correlated_for(self) -> float:
        """In which the ground comes to rest."""
        return 1.0 / (self.damping * self.frequency)

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """That of the ground."""
        return [self.frequency]

    def modulated(self, words: str) -> str:
        """What it is, with what changes in time."""
        changing = f", frequency changing by {self.frequency_rate:.6g} rad/s^2" if self.frequency_rate else ""
        return super().modulated(words + changing)


@dataclass(frozen=True)
class KanaiTajimiNoise(GroundNoise):
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
    frequency_rate : float
        By which wg changes in time, in rad/s^2; it needs an envelope.
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which the white noise before the filter is multiplied: there is no stationary state then.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    Examples
    --------
    >>> round(KanaiTajimiNoise(3.0, 0.4, 1.0).density(0.0), 4)  # 1 / (2 pi)
    0.1592
    """

    said, filter_order = "kanai tajimi noise", 2

    intensity: _Before
    on: On = "ground"

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        ratio, twice = abs(w) / self.frequency, 2.0 * self.damping
        if ratio > 1.0:  # the powers of a far frequency would overflow
            passed = (ratio**-2 + twice**2) / ((1.0 / ratio - ratio) * (1.0 / ratio - ratio) + twice**2)
        else:
            passed = (1.0 + (twice * ratio) ** 2) / ((1.0 - ratio**2) ** 2 + (twice * ratio) ** 2)
        return self.intensity / (2.0 * math.pi) * passed

    @property
    def rms(self) -> float:
        """Its root mean square without an envelope, before its frequency changes, in m/s^2 or N."""
        return math.sqrt(self.intensity * self.frequency * (0.25 / self.damping + self.damping))

    def filter_at(self, time: float) -> Filter:
        """That of the ground."""
        rates, output = self.ground_at(time)
        return Filter(rates, output, 1, self.intensity)

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return self.modulated(
            f"Kanai-Tajimi noise ({name}), filter at {self.frequency:.6g} rad/s with damping ratio {self.damping:.6g}, "
            f"{_strength(self, unit)}"
        )


@dataclass(frozen=True)
class CloughPenzienNoise(GroundNoise):
    """Kanai-Tajimi noise without its slow part: u'', with u'' + 2 zf wf u' + wf^2 u = the Kanai-Tajimi noise.

    Its density falls like w^4 below wf, so that the displacement and the velocity of the ground do not grow.

    Parameters
    ----------
    frequency, damping : float
        wg > 0 in rad/s and zg in (0, 1] of the filter of the ground.
    base_frequency, base_damping : float
        wf > 0 in rad/s, often 0.1 wg, and zf in (0, 1] of the second filter.
    intensity : float
        qg > 0 of the white noise before the filters.
    on : str
        The acceleration of the ``"ground"``, or a force on the ``"mass"``, or on one of several by its name.
    frequency_rate : float
        By which wg changes in time, in rad/s^2; it needs an envelope.
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which the white noise before the filters is multiplied: there is no stationary state then.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.

    References
    ----------
    R. W. Clough and J. Penzien, *Dynamics of Structures* (McGraw-Hill, 1975).

    Examples
    --------
    >>> noise = CloughPenzienNoise(15.0, 0.6, 1.5, 0.6, 1.0)
    >>> round(noise.density(15.0) / KanaiTajimiNoise(15.0, 0.6, 1.0).density(15.0), 4)
    1.0055
    """

    said, filter_order = "clough penzien noise", 4

    base_frequency: Annotated[
        float, Number("ω", "second filter at", "rad s-1", "positive", "It is that of the second filter, in rad/s.")
    ]
    base_damping: Annotated[
        float, Number("ζ", "second damping ratio", "1", "share", "It is that of the second filter.")
    ]
    intensity: _Before
    on: On = "ground"

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        ratio, twice = abs(w) / self.base_frequency, 2.0 * self.base_damping
        if ratio > 1.0:  # the powers of a far frequency would overflow
            passed = 1.0 / ((1.0 - ratio**-2) ** 2 + (twice / ratio) ** 2)
        else:
            passed = ratio**4 / ((1.0 - ratio**2) ** 2 + (twice * ratio) ** 2)
        return passed * KanaiTajimiNoise(self.frequency, self.damping, self.intensity).density(w)

    @property
    def rms(self) -> float:
        """Its root mean square without an envelope, before its frequency changes, in m/s^2 or N.

        From the table of such integrals in G. C. Newton, L. A. Gould and J. F. Kaiser, *Analytical Design of Linear
        Feedback Controls* (Wiley, 1957), appendix E, for s^4 + a3 s^3 + a2 s^2 + a1 s + a0 with frequencies over wg.
        """
        ratio, ground, base = self.base_frequency / self.frequency, 2.0 * self.damping, 2.0 * self.base_damping
        a3, a2 = ground + base * ratio, 1.0 + ratio * (ratio + ground * base)
        a1, a0 = ratio * (base + ground * ratio), ratio * ratio
        passed = (ground * ground * (a1 * a2 - a0 * a3) + a1) / (2.0 * (a1 * (a2 * a3 - a1) - a0 * a3 * a3))
        return math.sqrt(self.intensity * self.frequency * passed)

    @property
    def correlated_for(self) -> float:
        """In which the slower of the two filters comes to rest."""
        return max(super().correlated_for, 1.0 / (self.base_damping * self.base_frequency))

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Those of both filters."""
        return [self.frequency, self.base_frequency]

    def filter_at(self, time: float) -> Filter:
        """That of the ground, and f u and u' of the second filter, with f its frequency."""
        rates, pull = self.ground_at(time)
        f = self.base_frequency
        output = (*pull, -f, -2.0 * self.base_damping * f)
        wide = (*((*row, 0.0, 0.0) for row in rates), (0.0, 0.0, 0.0, f), output)
        return Filter(wide, output, 1, self.intensity)

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return self.modulated(
            f"Clough-Penzien noise ({name}), filters at {self.frequency:.6g} and {self.base_frequency:.6g} rad/s with "
            f"damping ratios {self.damping:.6g} and {self.base_damping:.6g}, {_strength(self, unit)}"
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
    is_odd, shakes_ground = False, False

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
    is_gaussian = False
    is_random, is_banded = True, True

    amplitude: Annotated[float, Number("F", "amplitude", "N", "unsigned", "It is that of the force.")]
    frequency: Annotated[float, Number("ν", "frequency", "rad s-1", "positive", "It is in rad/s.")]
    on: On = "mass"

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """At its own frequency."""
        taken = max(rate(), 1e-9 * frequency)
        away = (frequency * frequency - self.frequency**2) ** 2 + (taken * self.frequency) ** 2
        return 0.5 * self.amplitude**2 * taken * self.frequency**2 / away

    def fed_into_mode(self, frequency: float) -> float:
        """As if it were spread over its own frequency."""
        return 0.5 * self.amplitude**2 / self.frequency

    @property
    def feeds(self) -> bool:
        """Whether it is not 0."""
        return bool(self.amplitude)

    @property
    def rate_of_its_own(self) -> float:
        """Half of its frequency."""
        return 0.5 * self.frequency

    @classmethod
    def from_hz(cls, amplitude: float, unit: RmsUnit, frequency_hz: float, *, on: str = "") -> Harmonic:
        """The sine of a test specification.

        Parameters
        ----------
        amplitude : float
            Its largest value, not the rms: of the ground's acceleration, or of a force.
        unit : {"g", "m/s2", "N"}
            Of the amplitude.
        frequency_hz : float
            In Hz.
        on : str
            The mass on which the force acts, by its name, where there are several.

        Raises
        ------
        TypeError, ValueError
            If a number or one of the words is not what it must be.

        Examples
        --------
        >>> Harmonic.from_hz(2.0, "m/s2", 50.0)
        Harmonic(amplitude=2.0, frequency=314.1592653589793, on='ground')
        """
        known_word(unit, get_args(RmsUnit), "unit")
        size = finite_number(amplitude, "amplitude", low=0.0, high=LARGEST, hint="It is the largest value.")
        return cls(size * (STANDARD_GRAVITY if unit == "g" else 1.0), _turned(frequency_hz, "frequency_hz"),
                   driven(unit, on, "a sine"))  # fmt: skip

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        size = f"{self.amplitude:.6g} {unit('amplitude')}"
        return f"{size} cos({self.frequency:.6g} t + a random phase) ({name})"


@dataclass(frozen=True)
class SpectralExcitation(Excitation):
    """A stationary Gaussian noise with a given spectral density: straight lines between points in the log-log plane.

    Parameters
    ----------
    frequency : sequence of float
        Increasing, in Hz; at least two.  The density is 0 below the first and above the last.
    psd : sequence of float
        The one-sided density at each, above 0, in (m/s^2)^2/Hz; of a force in N^2/Hz, per unit mass in (m/s^2)^2/Hz.
        `from_psd`, `from_slopes` and `from_file` take g^2/Hz and other units.
    scale : float
        Factor on the density, above 0: 0.5 for a test at -3 dB.
    on : str
        The acceleration of the ``"ground"``, or a force on the ``"mass"``, or on one of several by its name.
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which it is multiplied itself: there is no stationary state then.

    Raises
    ------
    TypeError, ValueError
        If the frequencies do not increase, the two have different lengths, or a number is not positive.

    Notes
    -----
    It is Gaussian, as the theory assumes: its peaks are not clipped, as those of shakers are at 3 sigma.

    Examples
    --------
    >>> profile = SpectralExcitation.from_psd((10, 40, 500, 2000), (0.01, 0.04, 0.04, 0.005), "g2/Hz")
    >>> round(profile.rms / 9.80665, 2)  # in g, for comparison with the test's own
    6.26
    """

    said, glyph, powers = "noise of a given spectral density", "smooth", ("fed",)
    noise, is_banded = "filtered", True
    instead = {  # noqa: RUF012
        "level": Instead(
            "scale", Number("L", "level above the table", "dB", "signed"), lambda _, dB: 10.0 ** min(0.1 * dB, 99.0)
        ),
        "rms": Instead(
            "scale",
            Number("σ", "overall rms", "N", hint="It is the root mean square."),
            lambda own, rms: own.scale * (rms / own.rms) ** 2,
        ),
    }

    frequency: Annotated[tuple[float, ...], Number("f", "frequency", "Hz", own=True)]
    psd: Annotated[tuple[float, ...], Number("G", "spectral density", "N2 s", own=True)]
    scale: Annotated[float, Number("×", "the density times", "1", "positive", "It is a factor on the density.")] = 1.0
    on: On = "ground"
    envelope: Over = field(default=None, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        put(self, frequency=_positive(self.frequency, "frequency"), psd=_positive(self.psd, "psd"))
        if len(self.frequency) != len(self.psd) or len(self.psd) < 2:
            raise ValueError(
                f"frequency and psd must have the same number of points, two or more, not {len(self.frequency)} and "
                f"{len(self.psd)}."
            )
        if len(self.psd) > MOST_POINTS:
            raise ValueError(
                f"frequency must have at most {MOST_POINTS} points, not {len(self.psd)}: thin the table, as from_file "
                "does with tolerance=0.05."
            )
        for low, high in zip(self.frequency, self.frequency[1:], strict=False):
            if not low < high:
                step = ": a step must be two points some 3 % apart, which filters can follow." if low == high else "."
                raise ValueError(
                    f"frequency must increase from each point to the next, but {high:g} Hz follows {low:g} Hz{step}"
                )
        super().__post_init__()

    @classmethod
    def from_psd(
        cls, frequency: Sequence[float], psd: float | Sequence[float], psd_unit: DensityUnit, *,
        frequency_unit: FrequencyUnit = "Hz", sides: Sides = 1, scale: float = 1.0, level: float | None = None,
        on: str = "", envelope: Over = None,
    ) -> SpectralExcitation:  # fmt: skip
        """The noise of a table as test equipment and standards state it.

        Parameters
        ----------
        frequency : sequence of float
            Increasing; of a flat band its two ends.
        psd : float or sequence of float
            The density at each, or one number for all.
        psd_unit : {"g2/Hz", "m2/s4/Hz", "N2/Hz"}
            Of the ground's acceleration in standard gravity or in m/s^2, or of a force on the mass.
        frequency_unit : {"Hz", "kHz", "rad/s"}
            Of the frequencies; the density is per Hz whatever it is.
        sides : {1, 2}
            1: the density is one-sided (positive frequencies only); 2: two-sided.
        scale : float
            Factor on the density.
        level : float, optional
            In place of ``scale``, in dB above the table: -3 for half of the density.
        on : str
            The mass on which the force acts, by its name, where there are several.
        envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
            e(t), by which it is multiplied.

        Returns
        -------
        SpectralExcitation

        Raises
        ------
        TypeError, ValueError
            If a number or one of the words is not what it must be.

        Examples
        --------
        >>> band = SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz")
        >>> band.on, round(band.rms, 2)
        ('ground', 61.87)

        The same test at -6 dB:

        >>> round(SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz", level=-6).rms, 2)
        31.01
        """
        f = _positive(frequency, "frequency")
        values = (psd,) * len(f) if isinstance(without_axis(psd), Real) else psd
        size = one_sided_si(_positive(values, "psd"), psd_unit, sides)
        return cls(in_hertz(f, frequency_unit), size, _scale_of(scale, level), driven(psd_unit, on), envelope=envelope)

    @classmethod
    def from_slopes(
        cls, frequency: Sequence[float], slopes: Sequence[float], psd: float, psd_unit: DensityUnit, *, at: float,
        scale: float = 1.0, level: float | None = None, on: str = "",
    ) -> SpectralExcitation:  # fmt: skip
        """The noise of a profile by its slopes between break points, as test standards write it.

        Parameters
        ----------
        frequency : sequence of float
            The break points, increasing, in Hz.
        slopes : sequence of float
            From each to the next, in dB per octave.
        psd : float
            The one-sided density at a frequency.
        psd_unit : {"g2/Hz", "m2/s4/Hz", "N2/Hz"}
            As of `from_psd`.
        at : float
            That frequency, in Hz.
        scale, level, on
            As of `from_psd`.

        Returns
        -------
        SpectralExcitation

        Raises
        ------
        TypeError, ValueError
            If a number or one of the words is not what it must be.

        Examples
        --------
        >>> SpectralExcitation.from_slopes((20, 80, 350, 2000), (3, 0, -3), 0.04, "g2/Hz", at=100).rms.__round__(2)
        59.47
        """
        f, steep = _positive(frequency, "frequency"), numbers_in(slopes, "slopes", "It is in dB per octave.")
        density = positive_number(psd, "psd", _A_DENSITY)
        for name, value in (("slopes", steep), ("at", at)):
            check_plain(value, name, "mark the scale instead")
        there = positive_number(at, "at", "It is in Hz.")
        cls(f, f)  # they increase
        return cls.from_psd(
            f, along_slopes(f, steep, density, there), psd_unit, scale=scale, level=level, on=on
        )  # fmt: skip

    @classmethod
    def from_file(
        cls, path: str | Path, *, tolerance: float | None = None, unit: str = "",
        columns: Sequence[str] | Mapping[str, str] | None = None, decimal: Decimal = "", scale: float = 1.0,
        level: float | None = None, on: str = "",
    ) -> SpectralExcitation:  # fmt: skip
        """The noise of a table in a file, whose kind is found from the content.

        Parameters
        ----------
        path : str or Path
            A table in text, whose header has names and units, such as ``frequency_Hz,psd_g2/Hz`` or
            ``Freq (Hz);ASD (G^2/Hz)``, a universal file (dataset 58) or a MATLAB file.  The density is one-sided, of
            the ground's acceleration or of a force.  Densities of 0 at the ends of the table are left out.
        tolerance : float, optional
            The table is thinned to break points, and its mean square changes in no sixth of an octave by more than this
            share; overall it stays.  If it is not given, a table of more than 100 lines at equal steps, or of more than
            1000 points, is thinned to 0.05; 0 keeps every point.
        unit : str, optional
            Of the density, where the file does not say it.
        columns : sequence of str or mapping, optional
            A header for each column of a file without one, empty for one that is left out; or headers by the names in
            the file, of the columns that are wanted.
        decimal : {".", ","}, optional
            The decimal mark, where it cannot be told.
        scale, level, on
            As of `from_psd`.

        Returns
        -------
        SpectralExcitation

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            One sentence that says what is wrong in it, and what to do.

        Warns
        -----
        FileWarning
            With what was assumed, in one line.

        Examples
        --------
        >>> import tempfile
        >>> place = Path(tempfile.mkdtemp()) / "profile.csv"
        >>> _ = place.write_text("frequency_Hz,psd_g2/Hz\\n10,0.02\\n2000,0.02\\n")
        >>> SpectralExcitation.from_file(place) == SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz")
        True
        """
        from springpot.files.table import Stated

        place, stated = checked_path(path, "path"), Stated(unit, columns, None, decimal)
        scale = _scale_of(scale, level)
        title = f"density file {str(place)!r}"
        frequency, psd, of_force, notes = densities_in(place, title, stated, tolerance)
        try:
            found = cls.from_psd(frequency, psd, "N2/Hz" if of_force else "m2/s4/Hz", scale=scale, on=on)
        except (TypeError, ValueError) as fault:
            raise FileError(f"{title} is not right: {fault}") from None
        warn_of_file(title, notes)
        return found

    @property
    def mean_square(self) -> float:
        """The integral of the density over all frequencies."""
        pieces = zip(self.frequency, self.frequency[1:], self.psd, self.psd[1:], strict=False)
        return self.scale * math.fsum(_area(*piece) for piece in pieces)

    @property
    def rms(self) -> float:
        """Its overall root mean square, in m/s^2 or N."""
        return math.sqrt(self.mean_square)

    def one_sided(self, f: float) -> float:
        """The one-sided density at a frequency in Hz.

        Examples
        --------
        >>> SpectralExcitation((1.0, 4.0), (1.0, 16.0)).one_sided(2.0)
        4.0
        """
        place = bisect_right(self.frequency, f)
        if place == 0 or place == len(self.psd):
            return self.scale * self.psd[-1] if f == self.frequency[-1] else 0.0
        (low, high), (first, last) = self.frequency[place - 1 : place + 1], self.psd[place - 1 : place + 1]
        share = math.log(f / low) / math.log(high / low)
        return self.scale * first * math.exp(share * math.log(last / first))

    def density(self, w: float) -> float:
        """Two-sided spectral density per rad/s."""
        return self.one_sided(abs(w) / (2.0 * math.pi)) / (4.0 * math.pi)

    @property
    def correlated_for(self) -> float:
        """The inverse of the width of its band."""
        return 1.0 / (2.0 * math.pi * (self.frequency[-1] - self.frequency[0]))

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """All points of the table."""
        return [2.0 * math.pi * f for f in self.frequency]

    def white_at(self, *, frequency_hz: float) -> WhiteNoise:
        """The white noise of the same density at a frequency, for a response that is narrow about it.

        Parameters
        ----------
        frequency_hz : float
            In Hz, as in the table.

        Returns
        -------
        WhiteNoise

        Raises
        ------
        TypeError, ValueError
            If it is no frequency of the table, which has no density elsewhere.

        Examples
        --------
        >>> SpectralExcitation((1.0, 4.0), (1.0, 1.0)).white_at(frequency_hz=2.0)
        WhiteNoise(intensity=0.5, on='ground')
        """
        low, high = self.frequency[0], self.frequency[-1]
        at = finite_number(frequency_hz, "frequency_hz", low=low, high=high, hint="It is in Hz, as in the table.")
        return WhiteNoise(2.0 * math.pi * self.density(2.0 * math.pi * at), self.on)

    def power_into(self, frequency: float, rate: float) -> float:
        """Power fed into an oscillator of unit mass, also where it is out of the band: roughly, for guesses of scales.

        Parameters
        ----------
        frequency, rate : float
            Of the oscillator, in rad/s, and of its energy, in 1/s.
        """
        import numpy as np  # slow to import

        u = np.linspace(math.log(self.frequency[0]), math.log(self.frequency[-1]), _GRID)
        density = np.exp(np.interp(u, np.log(self.frequency), np.log(self.psd)))
        w, rate = 2.0 * math.pi * np.exp(u), max(rate, 2.0 * float(u[1] - u[0]) * frequency)
        taken = rate * w**2 / ((frequency**2 - w**2) ** 2 + (rate * w) ** 2)
        return self.largest_square * self.scale * float(np.trapezoid(density * taken * np.exp(u), u))

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """That of `power_into`."""
        return self.power_into(frequency, rate())

    def fastest_rate(self, law: Law) -> float:
        """That of its lowest frequency: a motion below the band moves with it."""
        return 2.0 * math.pi * self.frequency[0]

    def measure(self, name: str, frequency: float, resonance: float, own: Any) -> str:
        """Its density at the resonance, in the unit of a table and as white noise."""
        q, hertz = 2.0 * math.pi * self.density(resonance), 0.5 * resonance / math.pi
        level = own.one_sided(hertz)
        size = f"{level / STANDARD_GRAVITY**2:.6g} g2/Hz" if own.on == "ground" else f"{level:.6g} in the unit of psd"
        there = f"{size}, that of white noise of intensity {q:.6g} m^2/s^3" if q else "0, outside its band"
        return f"density of {name} at the resonance, {hertz:.6g} Hz: {there}"

    def words(self, name: str, unit: Units) -> str:
        """What it is, with its root mean square for comparison with the test's own."""
        of = unit("psd") == "N^2 s"
        size = f"{self.rms:.4g} N" if of else _in_gravity(self.rms)
        band = f"{self.frequency[0]:.6g} to {self.frequency[-1]:.6g} Hz in {len(self.psd)} points"
        return self.modulated(f"Gaussian noise of a given spectral density ({name}), {band}, overall rms {size}")


def _strength(noise: KanaiTajimiNoise | CloughPenzienNoise, unit: Units) -> str:
    """Intensity and root mean square, in words."""
    size = f"{noise.rms:.4g} N" if unit("intensity") == "N^2 s" else _in_gravity(noise.rms)
    before = " before the envelope" if noise.envelope is not None else ""
    return f"intensity {noise.intensity:.6g} {unit('intensity')}, rms{before} {size}"


def _in_gravity(acceleration: float) -> str:
    """An acceleration in m/s^2, in words, also in standard gravity."""
    return f"{acceleration:.4g} m/s^2 ({acceleration / STANDARD_GRAVITY:.4g} g)"


def _turned(frequency_hz: float, name: str) -> float:
    """In rad/s."""
    return 2.0 * math.pi * positive_number(frequency_hz, name, "It is a frequency in Hz.")


def driven(unit: DensityUnit | RmsUnit, on: str, what: str = "a density") -> str:
    """What a density or an rms in a unit drives."""
    if not isinstance(on, str):
        raise TypeError(f"on must be 'ground' or the name of a mass, not {shown(on)}.")
    is_force = unit in ("N2/Hz", "N")
    if not is_force and on not in ("", "ground"):
        raise ValueError(f"on must be left out with {what} in {unit}, which is that of the ground.")
    if is_force and on == "ground":
        raise ValueError(f"on must be a mass with {what} in {unit}, which is that of a force.")
    return (on or "mass") if is_force else "ground"


def _scale_of(scale: float, level: float | None) -> float:
    """The factor on a density, given as it is or as a level in dB."""
    if level is None:
        return scale
    check_plain(level, "level", "mark the scale instead")
    if scale != 1.0:
        raise ValueError("scale must be left out with level, which is the same in dB.")
    decibels = finite_number(level, "level", low=-300.0, high=300.0, hint="It is in dB above the table.")
    return float(10.0 ** (0.1 * decibels))


def _positive(values: object, name: str) -> tuple[float, ...]:
    """The numbers of a table, all positive."""
    hint = _A_DENSITY if name == "psd" else "It is in Hz, above 0 on a logarithmic scale."
    found = []
    for place, value in enumerate(items_of(values, f"{name} must be a list of numbers")):
        check_plain(value, f"{name}[{place}]", "mark the scale instead")
        found.append(positive_number(value, f"{name}[{place}]", hint))
    return tuple(found)


def _area(low: float, high: float, first: float, last: float) -> float:
    """The integral of a straight line in the log-log plane."""
    octaves = math.log(high / low)
    steep = math.log(last / first) + octaves  # of the density times the frequency
    return first * low * octaves * (math.expm1(steep) / steep if abs(steep) > 1e-8 else 1.0 + 0.5 * steep)


def densities_in(
    source: str | Path | bytes, title: str, stated: Stated, tolerance: float | None = None
) -> tuple[list[float], list[float], bool, list[str]]:
    """Frequencies in Hz and one-sided densities in SI units of a file or its content, whether they are of a force, and
    what was assumed.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        One sentence that says what is wrong in it.

    Examples
    --------
    >>> from springpot.files.table import Stated
    >>> densities_in(b"frequency_kHz,psd_m2/s4/Hz\\n0.01,0.02\\n2,0.01\\n", "the table", Stated())
    ([10.0, 2000.0], [0.02, 0.01], False, [])
    """
    import numpy as np  # slow to import

    from springpot.files.reading import read_table
    from springpot.problem.bands import are_lines, thinned

    table = read_table(source, title, stated)
    if sorted(column.quantity for column in table.columns) != ["density", "frequency"]:
        raise FileError(f"{title} must have two columns, one of the frequency and one of the density, such as "
                        f"frequency_Hz,psd_g2/Hz, not {listed([shown(column.header) for column in table.columns])}; "
                        "columns= takes those that are meant.")  # fmt: skip
    (of_frequency,), (of_density,) = table.of("frequency"), table.of("density")
    frequency, psd, unit = of_frequency.values, of_density.values, of_density.unit
    if not unit.startswith(("m2/s4", "m2/s3", "g2", "N2", "kN2")):
        raise FileError(f"{title}: {of_density.header} must be of an acceleration or a force, such as psd_g2/Hz.")
    if not len(psd):
        raise FileError(f"{title} is empty below its header: a density needs two points or more.")
    if (wrong := ~((frequency >= 0.0) & (frequency <= LARGEST) & (psd >= 0.0) & (psd <= LARGEST))).any():
        row = int(wrong.argmax())
        if not 0.0 <= frequency[row] <= LARGEST:
            raise FileError(f"{table.where(row)}: {of_frequency.header} must be a finite number, 0 or above.")
        raise FileError(f"{table.where(row)}: {of_density.header} must be a finite number, 0 or above. {_A_DENSITY}")
    if (wrong := np.diff(frequency) <= 0.0).any():
        row = int(wrong.argmax())
        raise FileError(f"{table.where(row + 1)}: the frequency must increase from each point to the next, but "
                        f"{frequency[row + 1]:g} Hz follows {frequency[row]:g} Hz.")  # fmt: skip
    kept = np.flatnonzero((psd > 0.0) & (frequency > 0.0))
    if kept.size < 2:
        raise FileError(f"{title} has fewer than two points above 0: a density needs two or more.")
    cut = slice(int(kept[0]), int(kept[-1]) + 1)
    notes, ends = table.notes, frequency[[cut.start, cut.stop - 1]]
    if cut.stop - cut.start < len(psd):
        count = len(psd) - cut.stop + cut.start
        what = "1 point of 0 at an end is" if count == 1 else f"{count} points of 0 at the ends are"
        notes.append(f"{what} left out, so that the band is from {ends[0]:g} to {ends[1]:g} Hz")
    frequency, psd = frequency[cut], psd[cut]
    many = len(psd) > MOST_POINTS or (len(psd) > MOST_LINES and are_lines(frequency))
    share = finite_number(TOLERANCE if tolerance is None else tolerance, "tolerance", low=0.0, high=1.0)
    if share > 0.0 and (many or tolerance is not None):
        try:
            points, values, worst = thinned(frequency, psd, share)
        except ValueError as fault:
            raise FileError(f"{title} is not right: {fault}") from None
        if tolerance is None and len(points) < len(psd):
            notes.append(f"its {len(psd)} points are thinned to {len(points)}, which changes the mean square by up to "
                         f"{per_cent(worst)} in a sixth of an octave; tolerance=0 keeps all")  # fmt: skip
        frequency, psd = points, values
    return frequency.tolist(), psd.tolist(), "N" in unit, notes


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
    is_linear, is_thermal, is_odd, is_gaussian = False, False, False, False
    shakes_ground = False
    is_placed, sustains, has_function = True, True, True  # it has x in it and goes on, for all that is known of it

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

    def elongation(self, at: Coordinates) -> Floats:
        """Of its two ends, or of its mass."""
        return at.row(self.between) if self.between else at.push(self.on)

    def push(self, at: Coordinates) -> None:
        """None: it sees the motion."""

    def check_ends(self, name: str, points: tuple[str, ...]) -> None:
        """Of its two ends, or of its mass."""
        if self.between:
            check_between(name, self.between, points)
        else:
            super().check_ends(name, points)

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
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which the impulses are multiplied: there is no stationary state then.

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
    is_gaussian, filter_order = False, 0
    noise = "impulses"

    rate: Annotated[float, Number("λ", "rate", "s-1", "positive", "It is the number of impulses per second.")]
    mean_square: Annotated[float, Number("y²", "mean square", "N2 s2", "positive", "It is that of an impulse.")]
    on: On = "mass"
    envelope: Over = field(default=None, repr=False, kw_only=True)

    @property
    def intensity(self) -> float:
        """q of the white noise with the same second moments."""
        return self.rate * self.mean_square

    @property
    def white_intensity(self) -> float:
        """That q."""
        return self.intensity

    @property
    def impulses(self) -> tuple[float, float]:
        """Its two numbers."""
        return self.rate, self.mean_square

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        size = f"mean square {self.mean_square:.6g} {unit('mean_square')}"
        return self.modulated(f"impulses at random times ({name}), {self.rate:.6g} per second, {size}")


@dataclass(frozen=True)
class ParametricNoise(Element, Excitation):
    """A white noise that multiplies the displacement, in the sense of Ito and of Stratonovich alike: the force x xi2.

    Between two masses it multiplies the elongation: a spring whose stiffness is a white noise.

    Parameters
    ----------
    intensity : float
        q2 > 0 of xi2, in N^2 s/m^2; per unit mass in s^-3.
    envelope : JenningsHousnerEnvelope, ExponentialEnvelope or TabulatedEnvelope, optional
        e(t), by which it is multiplied: there is no stationary state then.

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
    is_linear, is_gaussian, factor = False, False, "x "
    noise, has_density = "white", False
    is_placed, sustains = True, False  # what does not move, it leaves at rest

    intensity: Annotated[
        float, Number("q", "intensity", "N2 s m-2", "positive", "It is that of the noise that multiplies x.")
    ]
    envelope: Over = field(default=None, repr=False, kw_only=True)

    def push(self, at: Coordinates) -> None:
        """None: it acts along the row that it sees."""

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """It grows with the elongation."""
        return 0.5 * self.intensity * square

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return self.modulated(f"white noise ({name}) that multiplies x, intensity {self.intensity:.6g}")


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
    noise, has_density = "white", False

    temperature: Annotated[float, Number("kT", "temperature", "J", "positive", "It is kT, an energy.")]

    def push(self, at: Coordinates) -> None:
        """None: it acts along the rows of dissipators."""

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        return f"noise of every dissipator ({name}) at kT = {self.temperature:.6g} {unit('temperature')}"


def _check_on_mass(on: str) -> None:
    if on == "ground":
        raise ValueError("on must be the name of a mass here, not 'ground': it is a force.")
