"""The numbers of a problem as sliders of the page: how each is called, its unit, and where its slider begins and ends.

The page knows no part of a system: it draws the sliders of these lists.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.explorer.tolerances import Tolerance, check_known, moved, tolerance_of
from springpot.machine.arguments import Free, Uncertain
from springpot.problem.numbers import ROOT, number_of, numbers_of, unit_of, with_numbers
from springpot.problem.parts.registration import Number, Part, kind_of, powers_of
from springpot.problem.system import System
from springpot.problem.uncertain import Lognormal, Normal

GROUND = -1
_DECADES = 1.0  # on either side of a positive number
_TIMES = 2.0  # the size of a number of either sign, on both sides of 0
_STEPS = 200


@dataclass(frozen=True)
class Slider:
    """One number of the page.

    Attributes
    ----------
    name : str
        Of the number, in messages: the part's name, ``-``, and the name of the field.
    symbol, said, unit, hint : str
        What stands beside it.
    value : float
        At first.
    begin, end : float
        Of the slider.
    log : bool
        Whether the slider is logarithmic.
    steps : int
    kind : str
        Of the units to choose from, by their name in ``units.js``; empty where there is one unit.
    free : bool
        Whether the number is free in the system's file: then it is ticked for a fit.
    tolerance : Tolerance
    """

    name: str
    symbol: str
    said: str
    value: float
    begin: float
    end: float
    tolerance: Tolerance
    steps: int = _STEPS
    log: bool = False
    unit: str = ""
    kind: str = ""
    hint: str = ""
    free: bool = False


_UNITS_TO_CHOOSE = {"m": "length", "rad s-1": "frequency", "N2 s": "force_noise", "m2 s-3": "excitation"}
_LINEAR = {
    "order": (0.0, 1.0, 100), "share": (0.05, 1.0, 95), "fraction": (0.0, 1.0, 100), "exponent": (1.0, 3.0, 80)
}  # fmt: skip


def numbers(system: System) -> dict[str, float]:
    """Every number of a system by the name of its slider.

    Examples
    --------
    >>> from springpot.problem.parts import PolynomialSpring, Spring
    >>> numbers(System(Spring(80.0), PolynomialSpring((0.0, 0.0, 5.0))))["polynomial_spring-coefficients-3"]
    5.0
    """
    return {name.removeprefix(ROOT).replace(".", "-"): value for name, value in numbers_of(system).items()}


def changed(system: System, given: Mapping[str, float]) -> System:
    """The same system with other numbers, by the names of their sliders.

    Raises
    ------
    ValueError
        If there is no such number, or the parts or the system refuse one: the sentence is theirs.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> changed(System(Spring(80.0)), {"spring-stiffness": 90.0}).parts
    (Spring(stiffness=90.0),)
    """
    known = numbers(system)
    check_known("numbers", given, known)
    moved_to = {}
    for name, value in given.items():
        old, new = known[name], value
        if isinstance(old, Uncertain):  # it keeps its law
            new = moved(old, value)
        elif isinstance(old, Free) and old.low <= value <= old.high:  # and this one its bounds
            new = old.moved_to(value)
        moved_to[ROOT + name.replace("-", ".")] = new
    return with_numbers(system, moved_to)


def sliders(system: System, size: Mapping[str, float]) -> tuple[Slider, ...]:
    """A slider for each number of a system; the ``frequency`` and ``length`` of its motion are for numbers that are 0.

    Positive numbers have a logarithmic one, from a tenth to ten times the value; those of either sign, shares and
    orders a linear one.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Mass, Spring
    >>> found = sliders(System(Mass(1.0), Spring(80.0), Barrier(-0.5, 0.8)), {"frequency": 9.0, "length": 0.5})
    >>> [(one.name, one.begin, one.end) for one in found[1:]]
    [('spring-stiffness', 0.0, 160.0), ('barrier-position', -1.0, 1.0), ('barrier-restitution', 0.0, 1.0)]
    """
    certain = {name: float(value) if isinstance(value, Uncertain) else value for name, value in numbers(system).items()}
    return tuple(_slider(system, name, value, size) for name, value in certain.items())


def _slider(system: System, name: str, value: float, size: Mapping[str, float]) -> Slider:
    part, number, place = number_of(system, path := ROOT + name.replace("-", "."))
    plain = number.unit_of(system.has_mass and not part.of_ground, place)
    kind = "stiffness" if _is_the_spring(system, part, place) and plain == "s-2" else _UNITS_TO_CHOOSE.get(plain, "")
    unit = "" if kind else written(plain)
    symbol = number.symbol + ("₀₁₂₃₄₅₆₇₈₉"[place] if place else "")
    said = f"of {_power(number.said, place)}" if place and number.per != "1" else number.said  # a share has no power
    begin, end, steps, log = _ends(system, part, number, place, value, size)
    if kind == "stiffness" and not isinstance(value, Free):  # the square of a natural frequency
        begin, end, log = value / 100.0, 100.0 * value, True
    return Slider(
        name, symbol, said, value, begin, end, tolerance_of(system, path), steps, log, unit, kind=kind,
        hint=_multiple(numbers(system)[name]), free=isinstance(value, Free),
    )  # fmt: skip


def _power(symbol: str, power: int) -> str:
    """A power as polynomials of parts have it: that of a speed keeps its sign."""
    if symbol == "v" and power == 2:
        return "v|v|"
    return symbol + (raised(power) if power > 1 else "")


def _multiple(value: float) -> str:
    """How a number follows from the marked one that the file names, such as that of one of four mounts.

    Examples
    --------
    >>> k = Free(80.0, "k", 10.0, 200.0)
    >>> _multiple(4 * k), _multiple(-k), _multiple(2 * k + 5), _multiple(k**2), _multiple(k), _multiple(80.0)
    ('4 × k', '−k', '2 × k + 5', 'k^2', '', '')
    """
    if not isinstance(value, Free) or value.itself is value:
        return ""
    times = {1.0: "", -1.0: "−"}.get(value.times, f"{value.times:g} × ")
    plus = f" {'−' if value.plus < 0.0 else '+'} {abs(value.plus):g}" if value.plus else ""
    power = f"^{value.power:g}" if value.power != 1.0 else ""
    return f"{times}{value.name}{power}{plus}"


def _ends(
    system: System, part: Part, number: Number, place: int, value: float, size: Mapping[str, float]
) -> tuple[float, float, int, bool]:
    """Begin and end of a slider, its steps, and whether it is logarithmic; those of a free number are its bounds."""
    if isinstance(value, Free):
        return value.low, value.high, _STEPS, number.range in ("positive", "unsigned") and value.low > 0.0
    if number.range in _LINEAR:
        return *_LINEAR[number.range], False
    if number.range == "signed":
        end = _TIMES * (abs(value) or _rounded(_natural(system, part, number, place, size)))
        # a negative one would let the mass escape
        return 0.0 if _is_the_spring(system, part, place) else -end, end, _STEPS, False
    if value == 0.0:
        return 0.0, _rounded(_natural(system, part, number, place, size)), _STEPS, False
    factor = 10.0**_DECADES
    return value / factor, value * factor, _STEPS, True


def _is_the_spring(system: System, part: Part, place: int) -> bool:
    """Whether a number is the stiffness of a spring that holds the mass without any that is not linear."""
    linear = all(len(one.force_coefficients()) <= 2 and one.soft_stop is None for one in system.parts)
    return linear and not place and part.linear_stiffness > 0.0


def _natural(system: System, part: Part, number: Number, place: int, size: Mapping[str, float]) -> float:
    """How large a number that is 0 would have to be for its part to matter: that of its unit of the whole motion."""
    mass = float(np.diag(system.coordinates.mass).mean())
    force = (1.0 if part.of_ground else mass) * size["frequency"] ** 2 * size["length"]
    units = {"N": force, "m": size["length"], "s": 1.0 / size["frequency"]}
    words = powers_of(number.unit_of(True, place), part)
    return float(math.prod(units.get(base, 1.0) ** power for base, power in words))


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


def written(unit: str) -> str:
    """A unit as the page writes it.

    Examples
    --------
    >>> [written(unit) for unit in ("1", "m2 s-3", "N s^alpha m-1", "s-1", "N m^-exponent", "s^(alpha-2)")]
    ['', 'm²/s³', 'N s^α/m', '1/s', 'N/m^p', 's^(α−2)']
    """
    above: list[str] = []
    below: list[str] = []
    for word in unit.removeprefix("1").replace("alpha", "α").replace("exponent", "p").replace("ohm", "Ω").split():
        base, power = re.fullmatch(r"([^\d^-]+)(.*)", word).groups()  # type: ignore[union-attr]
        size = power.replace("^-", "-").removeprefix("-")
        sign = "" if size in ("", "1") else raised(int(size)) if size.isdigit() else f"^{size.removeprefix('^')}"
        (below if power.startswith(("-", "^-")) else above).append(base + sign.replace("-", "−"))
    return " ".join(above or ["1"] * bool(below)) + (f"/{' '.join(below)}" if below else "")


def shown_in(length: str, unit: str) -> tuple[float, str]:
    """The factor and the name of a unit in which lengths and speeds are shown, m or mm.

    Examples
    --------
    >>> shown_in("mm", "m/s"), shown_in("mm", "m²"), shown_in("mm", "m/s²"), shown_in("m", "m")
    ((1000.0, 'mm/s'), (1000000.0, 'mm²'), (1.0, 'm/s²'), (1.0, 'm'))
    """
    powers = {"m": 1, "m/s": 1, "m²": 2, "m²/s²": 2}
    return (1000.0 ** powers[unit], f"m{unit}") if length == "mm" and unit in powers else (1.0, unit)


def raised(power: int) -> str:
    """A power as a superscript.

    Examples
    --------
    >>> raised(12)
    '¹²'
    """
    return "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(digit)] for digit in str(power))


def described_parts(system: System) -> list[dict[str, Any]]:
    """Each part with its name, its kind, how it is drawn, and what is chosen in it: for headings and the picture.

    Its ends are the numbers of points, -1 of the ground.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> wall = described_parts(System(Spring(80.0), Barrier(-0.5, free_side="below")))[1]
    >>> wall["glyph"], wall["title"], wall["note"], wall["ends"]
    ('stop', 'barrier', 'wall, x ≤ b', (-1, 0))
    """
    ends = ends_of(system)
    return [
        {
            "name": name,
            "kind": kind_of(part),
            "glyph": part.glyph,
            "said": part.said,
            "linear": part.is_linear,
            "soft": part.soft_stop is not None,
            "title": name.replace("_", " "),
            "note": _note(system, name, part),
            "ends": ends.get(name),
            "free_side": getattr(part, "free_side", ""),
            "on": getattr(part, "on", ""),
        }
        for name, part in system.stated()
    ]


def _note(system: System, name: str, part: Part) -> str:
    kind = kind_of(part)
    words = [part.said] if not name.startswith(kind) or part.said != kind.replace("_", " ") else []
    if count := system.counts.get(name):
        words.append(f"{count} of them")
    if group := getattr(part, "group", ""):
        words.append(f"of {group}")
    if (stop := system.stops.get(name)) is not None:
        words.append("x ≥ b" if stop.free_side == "above" else "x ≤ b")
    if between := getattr(part, "between", None):
        words.append(" to ".join(between))
    if part.of_ground:
        words.append("of the ground")
    elif f"{(point := getattr(part, 'on', '') or getattr(part, 'at', ''))}_" in system.coordinates.beginnings:
        words.append(f"on {point}" if hasattr(part, "on") else point)
    return ", ".join(words)


def laws_in_words(system: System) -> dict[str, str]:
    """In words, by name, the laws that more than one number describes.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> from springpot.problem.uncertain import uncertain
    >>> device = System(Mass(uncertain("m", 2.0, cov=0.01)), Spring(uncertain("k", bounds=(70.0, 90.0))))
    >>> laws_in_words(device)
    {'k': 'from 70 to 90 N/m'}
    """
    found = dict[str, str]()
    for path, value in numbers_of(system).items():
        if isinstance(value, Uncertain) and not isinstance(value.law, Lognormal | Normal):
            words = written(unit_of(system, path)) if value.power == 1.0 else ""
            found.setdefault(value.name, f"{value.law} {words}".rstrip())
    return found


def ends_of(system: System) -> dict[str, tuple[int, int]]:
    """The numbers of the two points of each part, `GROUND` of the ground.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> ends_of(System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(2.0, between=("ground", "b"))))
    {'spring': (-1, 1)}
    """
    points = system.points
    known = {"ground": GROUND} | {point: number for number, point in enumerate(points)}
    found = {}
    for name, part in system.elements.items():
        first, second = part.between or ("ground", points[0])
        found[name] = known.get(first, 0), known.get(second, 0)  # a mass alone is called mass too
    return found


def titled(name: str) -> str:
    """A name as the page writes it.

    Examples
    --------
    >>> titled("left_wall")
    'left wall'
    """
    return name.replace("_", " ")
