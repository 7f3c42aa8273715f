"""The numbers of a system by their names, ``parts.<name>.<number>``: listed, replaced, and with their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from springpot.machine.faults import listed, meant, shown
from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    Constant,
    Contact,
    Dashpot,
    Friction,
    Harmonic,
    KanaiTajimiNoise,
    Mass,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.parts.walls import PowerRestitution
from springpot.problem.system import System, kind_of

__all__ = ["ROOT", "check_number", "label_of", "numbers_of", "unit_of", "with_numbers"]

ROOT = "parts."
_POLYNOMIALS = PolynomialSpring, PolynomialDashpot


def numbers_of(system: System) -> dict[str, float]:
    """Every number of a system by its name, in the order of the parts.

    A coefficient of a polynomial is called by its power, as ``coefficients.3`` for that of x^3; a number of a part of a
    part by both, as ``parts.arm.springpot.order``.

    Examples
    --------
    >>> numbers_of(System(Spring(80.0), stop=Barrier(-0.003, 0.7)))
    {'parts.spring.stiffness': 80.0, 'parts.stop.position': -0.003, 'parts.stop.restitution': 0.7}
    """
    return {f"{ROOT}{name}.{path}": value for name, part in system.named() for path, value, _ in _numbers(part)}


def with_numbers(system: System, values: Mapping[str, float]) -> System:
    """The system with some of its numbers replaced, all at once.

    A polynomial whose coefficients are then all 0 is left out.

    Parameters
    ----------
    system : System
    values : dict
        New values by the names that `numbers_of` gives.

    Returns
    -------
    System

    Raises
    ------
    ValueError
        If there is no such number, or a part or the whole refuses a value; the sentence names the part.

    Examples
    --------
    >>> device = System(Spring(80.0), PolynomialSpring((0.0, 0.0, 4e5)), stop=Barrier(-0.003, 0.7))
    >>> other = with_numbers(device, {"parts.stop.position": -0.001, "parts.polynomial_spring.coefficients.3": 0.0})
    >>> other.parts
    (Spring(stiffness=80.0), Barrier(position=-0.001, restitution=0.7, side='above'))
    """
    changes: dict[str, dict[tuple[str, ...], float]] = {}
    for name, value in values.items():
        owner, path = _split(system, name)
        changes.setdefault(owner, {})[path] = value
    parts = {}
    for name, part in system.named():
        if name not in changes:
            parts[name] = part
        elif (changed := _changed(part, changes[name], name)) is not None:
            parts[name] = changed
    return System(**parts)


def check_number(system: System, name: str) -> None:
    """Raise an error if a system has no number of that name.

    Raises
    ------
    ValueError
        One sentence with what there is.

    Examples
    --------
    >>> try:
    ...     check_number(System(Spring(80.0), stop=Barrier(0.0)), "parts.stop.restituton")
    ... except ValueError as error:
    ...     print(error)
    stop (barrier) has no number 'restituton'; did you mean restitution?
    """
    _split(system, name)


def label_of(name: str) -> str:
    """A number's name where it stands beside those of results.

    Examples
    --------
    >>> label_of("parts.stop.restitution"), label_of("parts.magnet.coefficients.3")
    ('stop_restitution', 'magnet_coefficients_3')
    """
    return name.removeprefix(ROOT).replace(".", "_")


def unit_of(system: System, name: str) -> str:
    """The unit of a number: in SI units with a `Mass`, per unit mass without one.

    Examples
    --------
    >>> unit_of(System(Mass(2.0), Spring(80.0)), "parts.spring.stiffness")
    'N m-1'
    """
    owner, path = _split(system, name)
    part = dict(system.named())[owner]
    kind, last = next((kind, last) for found, _, (kind, last) in _numbers(part) if found == ".".join(path))
    heavy = bool(system.of(Mass)) and getattr(part, "on", "mass") == "mass"
    if kind in _POLYNOMIALS:
        return _of_coefficient(kind, int(last), heavy)
    return _UNITS.get((kind, last), ("1", "1"))[heavy]


_UNITS: dict[tuple[type, str], tuple[str, str]] = {
    (Mass, "value"): ("kg", "kg"),
    (Spring, "stiffness"): ("s-2", "N m-1"),
    (Dashpot, "coefficient"): ("s-1", "N s m-1"),
    (VanDerPol, "coefficient"): ("m-2 s-1", "N s m-3"),
    (VanDerPol, "length"): ("m", "m"),
    (Friction, "force"): ("m s-2", "N"),
    (Springpot, "coefficient"): ("s^(alpha-2)", "N s^alpha m-1"),
    (Maxwell, "stiffness"): ("s-2", "N m-1"),
    (Maxwell, "coefficient"): ("s-1", "N s m-1"),
    (PiezoelectricCircuit, "coupling"): ("N V-1 kg-0.5", "N V-1"),
    (PiezoelectricCircuit, "resistance"): ("ohm", "ohm"),
    (PiezoelectricCircuit, "capacitance"): ("F", "F"),
    (WhiteNoise, "intensity"): ("m2 s-3", "N2 s"),
    (ColoredNoise, "variance"): ("m2 s-4", "N2"),
    (ColoredNoise, "correlation_time"): ("s", "s"),
    (KanaiTajimiNoise, "frequency"): ("rad s-1", "rad s-1"),
    (KanaiTajimiNoise, "intensity"): ("m2 s-3", "N2 s"),
    (Constant, "force"): ("m s-2", "N"),
    (Harmonic, "amplitude"): ("m s-2", "N"),
    (Harmonic, "frequency"): ("rad s-1", "rad s-1"),
    (PoissonImpulses, "rate"): ("s-1", "s-1"),
    (PoissonImpulses, "mean_square"): ("m2 s-2", "N2 s2"),
    (ParametricNoise, "intensity"): ("s-3", "N2 s m-2"),
    (ThermalNoise, "temperature"): ("m2 s-2", "J"),
    (Barrier, "position"): ("m", "m"),
    (PowerRestitution, "speed"): ("m s-1", "m s-1"),
    (Contact, "position"): ("m", "m"),
    (Contact, "stiffness"): ("s-2 m^(1-exponent)", "N m^-exponent"),
    (Contact, "dissipation"): ("s m-1", "s m-1"),
}
"""Per unit mass and with a mass; what is not here has no unit."""


def _of_coefficient(kind: type, power: int, heavy: bool) -> str:
    """Of k_n x^n or c_n v^n."""
    if kind is PolynomialSpring:
        powers = {"N": 1, "m": -power} if heavy else {"m": 1 - power, "s": -2}
    else:
        powers = {"N": 1, "s": power, "m": -power} if heavy else {"m": 1 - power, "s": power - 2}
    return " ".join(f"{unit}{n if n != 1 else ''}" for unit, n in powers.items() if n)


def _numbers(part: Any) -> Iterator[tuple[str, float, tuple[type, str]]]:
    """Path, value, and kind and last name of each number of a part."""
    for field in fields(part):
        value = getattr(part, field.name)
        if isinstance(value, float):
            yield field.name, value, (type(part), field.name)
        elif is_dataclass(value):
            for path, number, source in _numbers(value):
                yield f"{field.name}.{path}", number, source
        elif isinstance(part, _POLYNOMIALS):
            for power, number in enumerate(value, start=1):
                yield f"{field.name}.{power}", number, (type(part), str(power))


def _split(system: System, name: str) -> tuple[str, tuple[str, ...]]:
    """The part's name and the path within it."""
    if not name.startswith(ROOT) or name.count(".") < 2:
        known = [*numbers_of(system)]
        ending = [each for each in known if each.endswith(f".{name}")]
        near = meant(ending[0] if ending else name, known) or f", such as {known[0] if known else 'parts.mass.value'}."
        raise ValueError(f"{shown(name)} must be parts.<name>.<number>{near}")
    _, owner, *path = name.split(".")
    part = dict(system.named()).get(owner)
    if part is None:
        near = meant(owner, system.names) or f": its parts are {listed(system.names)}."
        raise ValueError(f"the system has no part {shown(owner)}{near}")
    known = [found for found, _, _ in _numbers(part)]
    if ".".join(path) not in known:
        its = f"; its numbers are {listed(known)}." if known else ", nor any other."
        near = meant(".".join(path), known) or its
        raise ValueError(f"{owner} ({kind_of(part)}) has no number {shown('.'.join(path))}{near}")
    return owner, tuple(path)


def _changed(part: Any, changes: Mapping[tuple[str, ...], float], where: str) -> Any:
    """The part with other numbers; None for a polynomial of zeros."""
    updates: dict[str, Any] = {}
    for field in {path[0] for path in changes}:
        below = {path[1:]: value for path, value in changes.items() if path[0] == field}
        now = getattr(part, field)
        if () in below:
            updates[field] = below[()]
        elif is_dataclass(now):
            updates[field] = _changed(now, below, f"{where}.{field}")
        else:
            updates[field] = tuple(below.get((str(n),), value) for n, value in enumerate(now, start=1))
    if isinstance(part, _POLYNOMIALS) and not any(updates.get("coefficients", (1.0,))):
        return None
    try:
        return replace(part, **updates)
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{where}.{fault}") from None
