"""The numbers of a model that are moved: the free ones, or all of its parts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from springpot.machine.arguments import Free
from springpot.machine.faults import NotCoveredError, shown
from springpot.problem.free_numbers import free_numbers, with_values
from springpot.problem.numbers import label_of, numbers_of, with_numbers
from springpot.problem.numbers import unit_of as number_unit
from springpot.problem.oscillator import Oscillator, as_system
from springpot.problem.system import System

__all__ = ["Numbers", "as_simulated", "checked_model", "moved_numbers", "units_of_free"]


@dataclass(frozen=True)
class Numbers:
    """Numbers of a model by name, and the model with others.

    Attributes
    ----------
    values : dict
        Where the model stands.
    at : callable
        From values by name to the model that has them; raises a ValueError where a part refuses one.
    free : bool
        Whether they are those that are marked as free.
    """

    values: dict[str, float]
    at: Callable[[Mapping[str, float]], Oscillator | System]
    free: bool


def checked_model(model: object, name: str) -> Oscillator | System:
    """What was given, if it is a system or an oscillator.

    Raises
    ------
    TypeError
        If it is something else.
    """
    if not isinstance(model, Oscillator | System):
        raise TypeError(f"{name} must be a System or an Oscillator, not {shown(model)}.")
    return model


def moved_numbers(model: Oscillator | System) -> Numbers:
    """The free numbers of a model; all numbers that are not 0 if none is free.

    Examples
    --------
    >>> import springpot as sp
    >>> moved_numbers(sp.Oscillator()).values["order"]
    0.5
    >>> moved_numbers(sp.System(sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.Dashpot(0.1))).values
    {'k': 80.0}
    """
    if found := free_numbers(model):
        return Numbers({name: float(number) for name, number in found.items()}, lambda v: with_values(model, v), True)
    if isinstance(model, System):
        names = {label_of(name): name for name, value in numbers_of(model).items() if value and math.isfinite(value)}
        values = numbers_of(model)
        return Numbers(
            {label: values[name] for label, name in names.items()},
            lambda v: with_numbers(model, {names[label]: value for label, value in v.items()}),
            False,
        )
    own = {
        "natural_frequency": model.natural_frequency,
        "order": model.springpot.order,
        "coefficient": model.springpot.coefficient,
        "intensity": model.excitation.intensity,
    }
    if model.barrier is not None:
        own |= {"position": model.barrier.position, "restitution": model.restitution}
    return Numbers({name: value for name, value in own.items() if value}, lambda v: _changed(model, v), False)


def units_of_free(model: Oscillator | System) -> dict[str, str]:
    """The unit of each free number; empty for one that stands for numbers of different units.

    Examples
    --------
    >>> import springpot as sp
    >>> units_of_free(sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.WhiteNoise(1.0)))
    {'k': 'N m-1'}
    >>> units_of_free(sp.Oscillator(sp.free("w", 2.0, (1.0, 3.0)), barrier=sp.Barrier(sp.free("b", -1.0, (-2.0, 0.0)))))
    {'w': 'rad s-1', 'b': 'm'}
    """
    found: dict[str, set[str]] = {}
    if isinstance(model, Oscillator):
        if isinstance(model.natural_frequency, Free):
            found[model.natural_frequency.name] = {"rad s-1"}
        model = as_system(model)
    for name, value in numbers_of(model).items():
        if isinstance(value, Free):
            found.setdefault(value.name, set()).add(number_unit(model, name))
    return {name: units.pop() if len(units) == 1 else "" for name, units in found.items()}


def as_simulated(model: Oscillator | System) -> Oscillator | System:
    """A system as an oscillator if it is one, as `springpot.run` takes it."""
    if isinstance(model, Oscillator):
        return model
    try:
        return model.canonical()
    except NotCoveredError:
        return model


def _changed(model: Oscillator, values: Mapping[str, float]) -> Oscillator:
    """An oscillator with some of its numbers replaced."""
    wall = model.barrier
    if wall is not None:
        wall = replace(
            wall,
            position=values.get("position", wall.position),
            restitution=values.get("restitution", wall.restitution),
        )
    return replace(
        model,
        natural_frequency=values.get("natural_frequency", model.natural_frequency),
        springpot=replace(
            model.springpot,
            order=values.get("order", model.springpot.order),
            coefficient=values.get("coefficient", model.springpot.coefficient),
        ),
        barrier=wall,
        excitation=replace(model.excitation, intensity=values.get("intensity", model.excitation.intensity)),
    )
