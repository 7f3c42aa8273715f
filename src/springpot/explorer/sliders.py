"""The numbers of a problem as sliders of the page: how each is called, its unit, and where its slider begins and ends.

The page knows no part of a system: it draws the sliders of these lists.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from typing import Any

from springpot.arguments import Free
from springpot.parts import (
    Barrier,
    Contact,
    Mass,
    PolynomialDashpot,
    PolynomialSpring,
    Recorded,
    Spring,
)
from springpot.system import System, kind_of

__all__ = ["OSCILLATOR", "Size", "Slider", "changed", "described_parts", "numbers", "sliders"]

_DECADES = 1.0  # on either side of a positive number
_TIMES = 2.0  # the size of a number of either sign, on both sides of 0
_STEPS = 200


@dataclass(frozen=True)
class Slider:
    """One number of the page.

    Attributes
    ----------
    name : str
        Of the number, in messages: of a system the part's name, ``-``, and the name of the field.
    symbol, said, unit, hint : str
        What stands beside it.
    value : float
        At first.
    low, high : float or None
        What a field takes; None where the system itself says what is wrong.
    begin, end : float
        Of the slider.
    log : bool
        Whether the slider is logarithmic.
    steps : int
    kind : str
        Of the units to choose from, by their name in ``units.js``; empty where there is one unit.
    scaled : bool
        Whether the ends are in units of the oscillator's length scale.
    dimensionless : str
        The unit of the dimensionless number.
    other : dict
        Symbol and name in other units.
    """

    name: str
    symbol: str
    said: str
    value: float
    begin: float
    end: float
    steps: int = _STEPS
    log: bool = False
    unit: str = ""
    low: float | None = None
    high: float | None = None
    kind: str = ""
    hint: str = ""
    scaled: bool = False
    dimensionless: str = ""
    other: Mapping[str, Mapping[str, str]] | None = None

    def to_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return asdict(self)


_DENSITY = {"symbol": "S", "said": "one-sided PSD"}
OSCILLATOR = (
    Slider("order", "α", "order", 0.5, 0.0, 1.0, 100, low=0.0, high=1.0, hint="0 spring – 1 dashpot"),
    Slider("coefficient", "C", "springpot", 1.0, 0.01, 10.0, 300, True, "s^(α−2)", 0.0, dimensionless="c = C Ω^(α−2)"),
    Slider("natural_frequency", "Ω", "natural frequency", 1.0, 0.1, 10.0, 200, True, "", 0.01, 1e6, "frequency",
           other={"Hz": {"symbol": "f"}}),
    Slider("intensity", "q", "noise intensity", 1.0, 0.01, 100.0, 200, True, "", 1e-12, 1e12, "excitation",
           other={"psd": _DENSITY, "g": _DENSITY}),
    Slider("position", "b", "wall at", 0.0, -3.0, 3.0, 120, kind="length", hint="gap < 0", scaled=True,
           dimensionless="√(q/Ω³)"),
    Slider("restitution", "r", "restitution", 1.0, 0.05, 1.0, 95, low=0.001, high=1.0, hint="lossy – elastic"),
)  # fmt: skip
"""The numbers of an oscillator; those of a wall beyond the limits of the page are refused by the server."""


@dataclass(frozen=True)
class Size:
    """How large the motion of a system is, roughly: for the sliders of numbers that are 0.

    Attributes
    ----------
    frequency : float
        In rad/s.
    length : float
        In m.
    """

    frequency: float
    length: float

    @property
    def speed(self) -> float:
        """In m/s."""
        return self.frequency * self.length


@dataclass(frozen=True)
class _Kind:
    """How a field of a part is shown: ``si`` is its unit beside a `Mass`, ``unit`` per unit mass or of the ground."""

    symbol: str
    said: str
    si: str = ""
    unit: str = ""
    range: str = "positive"  # or signed, share, order, exponent
    kind: str = ""


_K, _C = "N/m", "N s/m"
_KINDS = {
    "mass-value": _Kind("m", "mass", "kg", "kg"),
    "spring-stiffness": _Kind("k", "stiffness", _K, "s⁻²", "signed"),
    "dashpot-coefficient": _Kind("c", "coefficient", _C, "s⁻¹"),
    "van_der_pol-coefficient": _Kind("μ", "coefficient", "N s/m³", "m⁻² s⁻¹"),
    "van_der_pol-length": _Kind("l", "length", "m", "m", kind="length"),
    "friction-force": _Kind("F", "force", "N", "m/s²"),
    "springpot-order": _Kind("α", "order", range="order"),
    "springpot-coefficient": _Kind("C", "coefficient", "N s^α/m", "s^(α−2)"),
    "series-springpot-order": _Kind("α", "springpot's order", range="share"),
    "series-springpot-coefficient": _Kind("C", "springpot", "N s^α/m", "s^(α−2)"),
    "series-spring-stiffness": _Kind("k", "spring", _K, "s⁻²"),
    "maxwell-stiffness": _Kind("k", "stiffness", _K, "s⁻²"),
    "maxwell-coefficient": _Kind("c", "coefficient", _C, "s⁻¹"),
    "barrier-position": _Kind("b", "position", "m", "m", "signed", "length"),
    "barrier-restitution": _Kind("r", "restitution", range="share"),
    "barrier-restitution-restitution": _Kind("r", "restitution at", range="share"),
    "barrier-restitution-speed": _Kind("v", "this speed", "m/s", "m/s"),
    "barrier-restitution-exponent": _Kind("p", "falls with power", range="share"),
    "contact-position": _Kind("b", "position", "m", "m", "signed", "length"),
    "contact-stiffness": _Kind("k", "stiffness", "N/m^p", "m^(1−p) s⁻²"),
    "contact-exponent": _Kind("p", "exponent", range="exponent"),
    "contact-dissipation": _Kind("χ", "dissipation", "s/m", "s/m"),
    "circuit-coupling": _Kind("θ", "coupling", "N/V", "N/V"),
    "circuit-resistance": _Kind("R", "resistance", "Ω", "Ω"),
    "circuit-capacitance": _Kind("Cp", "capacitance", "F", "F"),
    "white_noise-intensity": _Kind("q", "intensity", "N² s", "", kind="force_noise excitation"),
    "coloured_noise-variance": _Kind("s²", "variance", "N²", "m²/s⁴"),
    "coloured_noise-correlation_time": _Kind("τ", "correlation time", "s", "s"),
    "filtered_noise-frequency": _Kind("ω", "filter at", kind="frequency"),
    "filtered_noise-damping": _Kind("ζ", "damping ratio", range="share"),
    "filtered_noise-intensity": _Kind("q", "intensity", "N² s", "", kind="force_noise excitation"),
    "constant-force": _Kind("F", "force", "N", "m/s²", "signed"),
    "harmonic-amplitude": _Kind("F", "amplitude", "N", "m/s²"),
    "harmonic-frequency": _Kind("ν", "frequency", kind="frequency"),
    "recorded-scale": _Kind("×", "the record times", range="positive"),
    "force-share": _Kind("×", "the function times", range="signed"),
    "poisson_impulses-rate": _Kind("λ", "rate", "s⁻¹", "s⁻¹"),
    "poisson_impulses-mean_square": _Kind("y²", "mean square", "N² s²", "m²/s²"),
    "parametric_noise-intensity": _Kind("q", "intensity", "N² s/m²", "s⁻³"),
    "thermal_noise-temperature": _Kind("kT", "temperature", "J", "m²/s²"),
}
_LINEAR = {"order": (0.0, 1.0, 100), "share": (0.05, 1.0, 95), "exponent": (1.0, 3.0, 80)}
_UNITS_OF_SPEED = (("N s/m", "s⁻¹"), ("N s²/m²", "m⁻¹"), ("N s³/m³", "m⁻² s"))
_OF_SPEED = ("of v", "of v|v|", "of v³")


def numbers(system: System) -> dict[str, float]:
    """Every number of a system by the name of its slider; a record has one, the factor on its values.

    Examples
    --------
    >>> numbers(System(Spring(80.0), PolynomialSpring((0.0, 0.0, 5.0))))["polynomial_spring-coefficients-2"]
    5.0
    """
    return {f"{name}-{path}": value for name, part in system.named() for path, value in _numbers(part)}


def _numbers(part: Any) -> Iterator[tuple[str, float]]:
    if isinstance(part, Recorded):
        yield "scale", 1.0
        return
    for field in fields(part):
        value = getattr(part, field.name)
        if is_dataclass(value):
            yield from ((f"{field.name}-{path}", inner) for path, inner in _numbers(value))
        elif isinstance(value, tuple):
            yield from ((f"{field.name}-{place}", inner) for place, inner in enumerate(value))
        elif isinstance(value, int | float):
            yield field.name, value


def changed(system: System, given: Mapping[str, float]) -> System:
    """The same system with other numbers, by the names of their sliders.

    Raises
    ------
    ValueError
        If there is no such number, or the parts or the system refuse one: the sentence is theirs.

    Examples
    --------
    >>> changed(System(Spring(80.0)), {"spring-stiffness": 90.0}).parts
    (Spring(stiffness=90.0),)
    """
    for name in given:
        if name not in numbers(system):
            raise ValueError(f"numbers: this system has no number {name[:60]!r}.")
    parts = {}
    for name, part in system.named():
        own = {key.removeprefix(f"{name}-"): value for key, value in given.items() if key.startswith(f"{name}-")}
        parts[name] = _with(part, own) if own else part
    return System(**parts)


def _with(part: Any, given: Mapping[str, float]) -> Any:
    if isinstance(part, Recorded):
        return replace(part, values=tuple(given["scale"] * value for value in part.values))
    values: dict[str, Any] = {}
    for field in fields(part):
        value = getattr(part, field.name)
        start = f"{field.name}-"
        inside = {key.removeprefix(start): new for key, new in given.items() if key.startswith(start)}
        if field.name in given:
            values[field.name] = _as_free(value, given[field.name])
        elif inside and is_dataclass(value):
            values[field.name] = _with(value, inside)
        elif inside:
            values[field.name] = tuple(_as_free(old, inside.get(str(place), old)) for place, old in enumerate(value))
    return replace(part, **values)


def _as_free(old: object, new: float) -> float:
    """A number in the place of a free one is free too, within the same bounds."""
    free = isinstance(old, Free) and old.low <= new <= old.high
    return Free(new, old.name, old.low, old.high) if free and isinstance(old, Free) else new


def sliders(system: System, size: Size) -> tuple[Slider, ...]:
    """A slider for each number of a system.

    Positive numbers have a logarithmic one, from a tenth to ten times the value; those of either sign, shares and
    orders a linear one.

    Examples
    --------
    >>> found = sliders(System(Spring(80.0), Barrier(-0.5, 0.8)), Size(9.0, 0.5))
    >>> [(one.name, one.begin, one.end) for one in found]
    [('spring-stiffness', 0.0, 160.0), ('barrier-position', -1.0, 1.0), ('barrier-restitution', 0.05, 1.0)]
    """
    return tuple(
        _slider(system, part, f"{name}-{path}", path, value, size)
        for name, part in system.named()
        for path, value in _numbers(part)
    )


def _slider(system: System, part: Any, name: str, path: str, value: float, size: Size) -> Slider:
    shown = _shown(part, path)
    heavy = bool(system.of(Mass)) and getattr(part, "on", "mass") == "mass"
    kind = shown.kind
    if " " in kind:
        kind = kind.split()[0 if heavy else 1]
    unit = "" if kind else shown.si if heavy else shown.unit
    begin, end, steps, log = _ends(system, part, path, value, shown.range, size)
    return Slider(name, shown.symbol, shown.said, value, begin, end, steps, log, unit, kind=kind)


def _ends(system: System, part: Any, path: str, value: float, of: str, size: Size) -> tuple[float, float, int, bool]:
    """Begin and end of a slider, its steps, and whether it is logarithmic; those of a free number are its bounds."""
    if isinstance(value, Free):
        return value.low, value.high, _STEPS, of == "positive" and value.low > 0.0
    if of in _LINEAR:
        return *_LINEAR[of], False
    if of == "signed":
        end = _TIMES * (abs(value) or _rounded(_natural(system, part, path, size)))
        alone = isinstance(part, Spring) and value > 0.0 and not system.of(PolynomialSpring, Contact)
        return 0.0 if alone else -end, end, _STEPS, False
    if value == 0.0:
        return 0.0, _rounded(_natural(system, part, path, size)), _STEPS, False
    factor = 10.0**_DECADES
    return value / factor, value * factor, _STEPS, True


def _shown(part: Any, path: str) -> _Kind:
    """How a number is shown; coefficients of polynomials by their place."""
    power = int(path.rpartition("-")[2]) + 1 if path.startswith("coefficients-") else 0
    if isinstance(part, PolynomialSpring):
        per_mass = "s⁻²" if power == 1 else f"m{_raised(1 - power)} s⁻²"
        of = "of x" + (_raised(power) if power > 1 else "")
        return _Kind(f"k{_lowered(power)}", of, f"N/m{_raised(power) if power > 1 else ''}", per_mass, "signed")
    if isinstance(part, PolynomialDashpot):
        return _Kind(f"c{_lowered(power)}", _OF_SPEED[power - 1], *_UNITS_OF_SPEED[power - 1], range="signed")
    return _KINDS[f"{kind_of(part)}-{path}"]


def _natural(system: System, part: Any, path: str, size: Size) -> float:
    """How large a number that is 0 would have to be for its part to matter."""
    mass, force = system.mass, system.mass * size.frequency**2 * size.length
    if path.startswith("coefficients-"):
        power = int(path.rpartition("-")[2]) + 1
        return force / (size.length if isinstance(part, PolynomialSpring) else size.speed) ** power
    if path == "position":
        return 1.5 * size.length
    if path == "dissipation":
        return 1.0 / size.speed
    natural = {"stiffness": mass * size.frequency**2, "force": force, "amplitude": force, "share": 1.0}
    return natural.get(path, 2.0 * mass * size.frequency)


def _rounded(value: float) -> float:
    """1, 2 or 5 times a power of ten, not below a value.

    Examples
    --------
    >>> _rounded(0.0031)
    0.005
    """
    if not (value > 0.0 and math.isfinite(value)):
        return 1.0
    decade = 10.0 ** math.floor(math.log10(value))
    return next(float(f"{digit * decade:.3g}") for digit in (1.0, 2.0, 5.0, 10.0) if digit * decade >= 0.999 * value)


def _raised(power: int) -> str:
    return "".join("⁻" if sign == "-" else "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(sign)] for sign in str(power))


def _lowered(power: int) -> str:
    return "₀₁₂₃₄₅₆₇₈₉"[power]


def described_parts(system: System) -> list[dict[str, Any]]:
    """Each part with its name, its kind, and what is chosen in it by a word: for headings and for the picture.

    Examples
    --------
    >>> described_parts(System(Spring(80.0), Barrier(-0.5, side="below")))[1]
    {'name': 'barrier', 'kind': 'barrier', 'title': 'barrier', 'note': 'wall, x ≤ b', 'side': 'below', 'on': ''}
    """
    return [
        {
            "name": name,
            "kind": kind_of(part),
            "title": name.replace("_", " "),
            "note": _note(name, part),
            "side": getattr(part, "side", ""),
            "on": getattr(part, "on", ""),
        }
        for name, part in system.named()
    ]


def _note(name: str, part: object) -> str:
    kind = kind_of(part)
    said = {"barrier": "wall", "contact": "soft contact"}.get(kind, kind.replace("_", " "))
    words = [said] if not name.startswith(kind) or kind in ("barrier", "contact") else []
    if isinstance(part, Barrier | Contact):
        words.append("x ≥ b" if part.side == "above" else "x ≤ b")
    if getattr(part, "on", "") == "ground":
        words.append("of the ground")
    return ", ".join(words)
