"""The numbers of a system that are moved: the free ones, or all of its parts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from springpot.machine.arguments import Free, Uncertain
from springpot.problem.free_numbers import free_numbers, with_values
from springpot.problem.numbers import label_of, numbers_of, unit_of, with_numbers
from springpot.problem.system import System
from springpot.problem.uncertain import centre_of


@dataclass(frozen=True)
class Numbers:
    """Numbers of a system by name, and the system with others.

    Attributes
    ----------
    system : System
    values : dict
        Where the system stands.
    at : callable
        From values by name to the system that has them; raises a ValueError where a part refuses one.
    """

    system: System
    values: dict[str, float]
    at: Callable[[Mapping[str, float]], System]

    def moved(self, name: str, distance: float) -> System:
        """The system with one number changed by this distance of its logarithm."""
        return self.at({**self.values, name: self.values[name] * math.exp(distance)})


def moved_numbers(system: System) -> Numbers:
    """The free numbers of a system; all numbers that are not 0 if none is free.

    Examples
    --------
    >>> import springpot as sp
    >>> moved_numbers(sp.System(sp.Spring(80.0), sp.Dashpot(0.1))).values
    {'spring_stiffness': 80.0, 'dashpot_coefficient': 0.1}
    >>> moved_numbers(sp.System(sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.Dashpot(0.1))).values
    {'k': 80.0}
    """
    if found := free_numbers(system):
        return Numbers(
            system, {name: float(number) for name, number in found.items()}, lambda v: with_values(system, v)
        )
    values = {name: value for name, value in numbers_of(system).items() if value and math.isfinite(value)}
    names = {label_of(name): name for name in values}
    return Numbers(
        system,
        {label: values[name] for label, name in names.items()},
        lambda v: with_numbers(system, {names[label]: value for label, value in v.items()}),
    )


def units_of_free(system: System) -> dict[str, str]:
    """The unit of each free number; empty for one that stands for numbers of different units.

    Examples
    --------
    >>> import springpot as sp
    >>> units_of_free(sp.System(sp.Mass(2.0), sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.WhiteNoise(1.0)))
    {'k': 'N m-1'}
    >>> units_of_free(sp.System(sp.Spring(sp.free("w", 2.0, (1.0, 3.0)) ** 2)))
    {'w': 'rad s-1'}
    """
    found: dict[str, set[str]] = {}
    for name, stated in numbers_of(system).items():
        value = centre_of(stated) if isinstance(stated, Uncertain) else stated
        if isinstance(value, Free):
            unit = unit_of(system, name)
            if value.power != 1.0:  # the root of a stiffness per unit mass is a frequency
                unit = "rad s-1" if (unit, value.power) == ("s-2", 2.0) else ""
            found.setdefault(value.name, set()).add(unit)
    return {name: units.pop() if len(units) == 1 else "" for name, units in found.items()}
