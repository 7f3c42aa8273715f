"""Numbers of a model that are to be found: marked, listed, and replaced."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np

from springpot.machine.arguments import Free, Uncertain, checked_name, finite_number
from springpot.machine.faults import listed, meant, shown
from springpot.problem.parts.checks import ends_of
from springpot.problem.system import System
from springpot.problem.uncertain import centre_of, with_law

Model = TypeVar("Model")


def free(name: str, start: float, bounds: tuple[float, float]) -> Free:
    """Mark a number of a part as one that is to be found, from data or for a design.

    Parameters
    ----------
    name : str
        A word of letters, digits and ``_``.  Numbers of the same name are one number: then ``start`` and ``bounds``
        must be the same too.
    start : float
        Where the search starts.  For theory and simulation the number has this value.
    bounds : (float, float)
        The lowest and the highest value.

    Returns
    -------
    Free
        A float, which every part of a `springpot.System` or `springpot.Oscillator` takes and keeps.  Plus, minus, times
        or over a plain number it stays free, and so do a power of one with positive bounds and a sum of its multiples;
        what other arithmetic gives is refused by parts.  Functions of `math` and of NumPy give plain numbers.

    Raises
    ------
    TypeError, ValueError
        If the name is no word, a number is not finite, the bounds are not in ascending order, or do not hold ``start``.

    Examples
    --------
    >>> import springpot as sp
    >>> rubber = sp.Springpot(sp.free("order", 0.4, (0.05, 0.95)), sp.free("C", 150.0, (1.0, 1e4)))
    >>> rubber.order, float(rubber.modulus(1.0))
    (free('order', 0.4, (0.05, 0.95)), 150.0)

    Two stops at one free distance:

    >>> gap = sp.free("gap", 0.004, (0.001, 0.006))
    >>> stops = sp.Barrier(-gap, 0.6), sp.Barrier(gap, 0.6, free_side="below")
    >>> device = sp.System(sp.Mass(2.0), sp.Spring(80.0), *stops)
    >>> [wall.position for wall in with_values(device, {"gap": 0.005}).of(sp.Barrier)]
    [-0.005, 0.005]
    """
    checked_name(name, "name")
    low, high = ends_of(bounds, f"in the free number {name}")
    if isinstance(start, Free):
        raise TypeError(f"start and bounds must be plain numbers, not marked ones, in the free number {name}.")
    begin = finite_number(start, "start", low=low, high=high, hint=f"These are the bounds of {name}.")
    return Free(begin, name, low, high)


def free_numbers(model: object) -> dict[str, Free]:
    """The free numbers of a model by name, in the order in which they stand in it.

    Parameters
    ----------
    model : System or any part

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        If two numbers of one name have different starts or bounds.

    Examples
    --------
    >>> import springpot as sp
    >>> free_numbers(sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 80.0, (10.0, 200.0)))))
    {'k': free('k', 80.0, (10.0, 200.0))}
    """
    return _by_name(model, uncertain=False)


def uncertain_numbers(model: object) -> dict[str, Uncertain]:
    """The uncertain numbers of a model by name, in the order in which they stand in it.

    Parameters
    ----------
    model : System or any part

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        If two numbers of one name have different laws.

    Examples
    --------
    >>> import springpot as sp
    >>> [*uncertain_numbers(sp.System(sp.Mass(2.0), sp.Spring(sp.uncertain("k", 80.0, cov=0.05))))]
    ['k']
    """
    return cast(dict[str, Uncertain], _by_name(model, uncertain=True))


def nominal(system: System) -> System:
    """The device with the nominal value of each uncertain number.

    Parameters
    ----------
    system : System

    Returns
    -------
    System

    Examples
    --------
    >>> import springpot as sp
    >>> nominal(sp.System(sp.Mass(2.0), sp.Spring(sp.uncertain("k", 80.0, cov=0.05)))).of(sp.Spring)
    (Spring(stiffness=80.0),)
    """
    return with_values(system, {name: float(number) for name, number in uncertain_numbers(system).items()})


def check_certain(model: object, what: str) -> None:
    """Raise an error if a model has uncertain numbers; ``what`` is it that needs plain ones."""
    if found := uncertain_numbers(model):
        raise ValueError(
            f"{what} needs plain numbers, but {listed([*found])} {'is' if len(found) == 1 else 'are'} uncertain: "
            "springpot.scatter and springpot.exceedance_over_devices simulate many devices, and springpot.nominal has "
            "the one with the nominal values."
        )


def _by_name(model: object, *, uncertain: bool) -> dict[str, Free]:
    found: dict[str, Free] = {}
    kinds: dict[str, bool] = {}
    for here in _each(model):
        is_uncertain = isinstance(here, Uncertain)
        if kinds.setdefault(here.name, is_uncertain) != is_uncertain:
            raise ValueError(f"{here.name} must be free or uncertain wherever it stands, not both.")
        if is_uncertain != uncertain:
            continue
        number = here.itself
        known = found.setdefault(number.name, number)
        both = np.array([(each, each.low, each.high) for each in (known, number)], float)
        laws = [(each.law, each.correlation) if isinstance(each, Uncertain) else None for each in (known, number)]
        if np.abs(both[1] - both[0]).max() > 1e-12 * np.abs(both).max() or laws[0] != laws[1]:
            same = "start and bounds" if laws[0] is None else "value and law"
            raise ValueError(
                f"{number.name} must have the same {same} wherever it stands, not {known!r} and {number!r}."
            )
    return found


def with_values(model: Model, values: Mapping[str, float]) -> Model:
    """The same model with values in place of its free or uncertain numbers.

    Parameters
    ----------
    model : System or any part
    values : mapping
        A value for each name, or an uncertain number, as ``fit.uncertain()`` has them; marked numbers that are not
        named stay as they are.

    Returns
    -------
    System or part

    Raises
    ------
    TypeError, ValueError
        If a name is unknown, or a part refuses its value.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 80.0, (10.0, 200.0))))
    >>> sp.with_values(device, {"k": 98.0}).natural_frequency
    7.0
    >>> sp.with_values(device, {"k": sp.uncertain("k", 98.0, cov=0.05)}).of(sp.Spring)
    (Spring(stiffness=uncertain('k', 98.0, lognormal, 5 %)),)
    """
    _check_names(model, values)
    found: Model = _mapped(model, lambda number: number.at(values[number.name]) if number.name in values else number)
    return found


def restarted(model: Model, values: Mapping[str, float]) -> Model:
    """The same model with the same free numbers, which start elsewhere.

    Parameters
    ----------
    model : System or any part
    values : mapping
        A value for each name, within its bounds; other free numbers stay as they are.

    Returns
    -------
    System or part

    Raises
    ------
    TypeError, ValueError
        If a name is unknown, or a value is not between its bounds.

    Examples
    --------
    >>> import springpot as sp
    >>> restarted(sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), {"k": 90.0})
    Spring(stiffness=free('k', 90.0, (10.0, 200.0)))
    """
    _check_names(model, values)

    def moved(number: Free) -> float:
        if number.name not in values:
            return number
        own = number.itself
        return number.moved_to(number.at(free(own.name, values[own.name], (own.low, own.high))))

    found: Model = _mapped(model, moved)
    return found


def _check_names(model: object, values: Mapping[str, float]) -> None:
    scatter = uncertain_numbers(model)
    known, kind = {**free_numbers(model), **scatter}, "marked" if scatter else "free"
    for name, value in values.items():
        if name not in known:
            have = f"its {kind} numbers are {listed([*known])}" if known else "it has none"
            raise ValueError(f"{shown(name)} is not a {kind} number of the model: {have}{meant(str(name), known)}.")
        finite_number(value, name)


def _each(thing: Any) -> Iterator[Free]:
    if isinstance(thing, Free):
        yield thing
        if isinstance(thing, Uncertain):
            yield from _each(thing.law)
    elif isinstance(thing, tuple):
        for item in thing if {*map(type, thing)} != {float} else ():
            yield from _each(item)
    elif is_dataclass(thing) and not isinstance(thing, type):
        for field in fields(thing):
            yield from _each(getattr(thing, field.name))


def _mapped(thing: Any, change: Callable[[Free], float]) -> Any:
    """The same thing with every free number changed; made again only where something is free."""
    if isinstance(thing, Free):
        found = change(thing)
        if isinstance(found, Uncertain) and (centre := centre_of(found)) is not None:
            return with_law(found, replace(found.law, mean=change(centre)))
        return found
    if next(_each(thing), None) is None:
        return thing
    if isinstance(thing, tuple):
        return tuple(_mapped(item, change) for item in thing)
    if isinstance(thing, System):
        return System(**{name: _part(name, part, change) for name, part in thing.stated()})
    return replace(thing, **{
        field.name: _mapped(getattr(thing, field.name), change) for field in fields(thing) if field.init
    })  # fmt: skip


def _part(name: str, part: Any, change: Callable[[Free], float]) -> Any:
    try:
        return _mapped(part, change)
    except (TypeError, ValueError) as fault:
        raise type(fault)(f"{name}.{fault}") from None
