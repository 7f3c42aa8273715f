"""The numbers of a system by their names, ``parts.<name>.<number>``: listed, replaced, and with their units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from springpot.machine.faults import listed, meant, shown
from springpot.problem.parts.checks import Checked, fields_of, is_said
from springpot.problem.parts.registration import Number, Part, in_range, kind_of
from springpot.problem.system import System

ROOT = "parts."


def numbers_of(system: System) -> dict[str, float]:
    """Every number of a system by its name, in the order of the parts.

    A coefficient of a polynomial is called by its power, as ``coefficients.3`` for that of x^3; a number of a part of a
    part by both, as ``parts.arm.springpot.order``.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> numbers_of(System(Spring(80.0), stop=Barrier(-0.003, 0.7)))
    {'parts.spring.stiffness': 80.0, 'parts.stop.position': -0.003, 'parts.stop.restitution': 0.7}
    """
    return {f"{ROOT}{name}.{path}": value for name, part in system.stated() for path, value, _, _ in _numbers(part)}


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
    >>> from springpot.problem.parts import Barrier, PolynomialSpring, Spring
    >>> device = System(Spring(80.0), PolynomialSpring((0.0, 0.0, 4e5)), stop=Barrier(-0.003, 0.7))
    >>> other = with_numbers(device, {"parts.stop.position": -0.001, "parts.polynomial_spring.coefficients.3": 0.0})
    >>> other.parts
    (Spring(stiffness=80.0), Barrier(position=-0.001, restitution=0.7, free_side='above'))
    """
    changes: dict[str, dict[tuple[str, ...], float]] = {}
    for name, value in values.items():
        owner, path = _split(system, name)
        changes.setdefault(owner, {})[path] = value
    parts = {}
    for name, part in system.stated():
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
    >>> from springpot.problem.parts import Barrier, Spring
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
    >>> from springpot.problem.parts import Mass, Spring
    >>> unit_of(System(Mass(2.0), Spring(80.0)), "parts.spring.stiffness")
    'N m-1'
    """
    part, number, place = number_of(system, name)
    return number.unit_of(system.has_mass and not part.of_ground, place)


def number_of(system: System, name: str) -> tuple[Part, Number, int]:
    """The part of a number, what the number is, and of a coefficient its place from 1, otherwise 0.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> part, number, _ = number_of(System(Spring(80.0)), "parts.spring.stiffness")
    >>> part, number.symbol
    (Spring(stiffness=80.0), 'k')
    """
    owner, path = _split(system, name)
    part = dict(system.stated())[owner]
    if path[0] in part.instead:
        return part, part.instead[path[0]].number, 0
    number, place = next((number, place) for found, _, number, place in _numbers(part) if found == ".".join(path))
    return part, number, place


def _numbers(part: Any, said: Mapping[str, Any] | None = None) -> Iterator[tuple[str, float, Number, int]]:
    """Path, value, what it is, and place among coefficients, of each number of a part that is written."""
    left_out = {own.name for own in fields_of(type(part)) if not is_said(own, part)}
    for name, number in (said or part.numbers).items():
        if name in left_out:
            continue
        value = getattr(part, name)
        if isinstance(value, Checked):
            inner = number if isinstance(number, dict) else None
            for path, *rest in _numbers(value, inner):
                yield f"{name}.{path}", *rest  # type: ignore[misc]
        elif isinstance(value, float):
            yield name, value, number, 0
        elif isinstance(number, Number) and number.per:
            for power, coefficient in enumerate(value, start=1):
                yield f"{name}.{power}", coefficient, number, power


def _split(system: System, name: str) -> tuple[str, tuple[str, ...]]:
    """The part's name and the path within it."""
    if not name.startswith(ROOT) or name.count(".") < 2:
        known = [*numbers_of(system)]
        ending = [each for each in known if each.endswith(f".{name}")]
        near = meant(ending[0] if ending else name, known) or f", such as {known[0] if known else 'parts.mass.value'}."
        raise ValueError(f"{shown(name)} must be parts.<name>.<number>{near}")
    _, owner, *path = name.split(".")
    part = dict(system.stated()).get(owner)
    if part is None:
        near = meant(owner, system.names) or f": its parts are {listed(system.names)}."
        raise ValueError(f"the system has no part {shown(owner)}{near}")
    known = [*(found for found, *_ in _numbers(part)), *part.instead]
    if ".".join(path) not in known:
        its = f"; its numbers are {listed(known)}."
        near = meant(".".join(path), known) or its
        raise ValueError(f"{owner} ({kind_of(part)}) has no number {shown('.'.join(path))}{near}")
    return owner, tuple(path)


def _changed(part: Any, changes: Mapping[tuple[str, ...], float], where: str) -> Any:
    """The part with other numbers; None for a polynomial of zeros."""
    updates: dict[str, Any] = {}
    for field in {path[0] for path in changes}:
        below = {path[1:]: value for path, value in changes.items() if path[0] == field}
        if field in getattr(part, "instead", ()):
            other = part.instead[field]
            if other.field in updates or (other.field,) in changes:
                raise ValueError(f"{where}.{field} and another of its numbers both say what {other.field} is.")
            updates[other.field] = other.value(part, in_range(below[()], f"{where}.{field}", other.number))
            continue
        now = getattr(part, field)
        if () in below:
            updates[field] = below[()]
        elif isinstance(now, Checked):
            updates[field] = _changed(now, below, f"{where}.{field}")
        else:
            updates[field] = tuple(below.get((str(n),), value) for n, value in enumerate(now, start=1))
    if any(isinstance(new, tuple) and not any(new) for new in updates.values()):
        return None
    try:
        return replace(part, **updates)
    except (TypeError, ValueError) as fault:
        raise ValueError(f"{where}.{fault}") from None
