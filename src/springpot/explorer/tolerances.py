"""Tolerances of the page: a number of a system, by its slider, as an uncertain number of `springpot.uncertain`.

A tolerance has the name of the uncertain number, so that numbers which follow from one have one tolerance.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from springpot.machine.arguments import Uncertain
from springpot.problem.free_numbers import uncertain_numbers
from springpot.problem.numbers import label_of, number_of, numbers_of, unit_of, with_numbers
from springpot.problem.parts.registration import LIMITS
from springpot.problem.system import System
from springpot.problem.uncertain import Bounded, Lognormal, Measured, Normal, Uniform, uncertain


@dataclass(frozen=True)
class Tolerance:
    """How a number differs from device to device, or how it would.

    Attributes
    ----------
    name : str
        Of the uncertain number.
    kind : {"cov", "sd"}
        Whether it is a share of the value, of a lognormal law, or a standard deviation, of a normal one.
    spread : float
        In the file; 0 if it has none, or a law that this number does not describe.
    other : bool
        Whether the file has such a law.
    follows : (float, float, float)
        Times, plus and power with which the number follows from that of the name.
    """

    name: str
    kind: str
    spread: float = 0.0
    other: bool = False
    follows: tuple[float, float, float] = (1.0, 0.0, 1.0)


def tolerance_of(system: System, name: str) -> Tolerance:
    """The tolerance of a number, by its name in the system.

    In per cent where a number must be positive, and where it is but no place, such as a stiffness.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> device = System(Spring(uncertain("k", 80.0, cov=0.05)), stop=Barrier(-0.003))
    >>> tolerance_of(device, "parts.spring.stiffness")
    Tolerance(name='k', kind='cov', spread=0.05, other=False, follows=(1.0, 0.0, 1.0))
    >>> tolerance_of(device, "parts.stop.position").kind
    'sd'
    """
    value, (_, number, _) = numbers_of(system)[name], number_of(system, name)
    is_place = unit_of(system, name) == "m"
    positive = number.range in ("positive", "unsigned") or (number.range == "signed" and value > 0.0 and not is_place)
    kind = "cov" if positive else "sd"
    if not isinstance(value, Uncertain):
        return Tolerance(label_of(name), kind)
    follows = value.times, value.plus, value.power
    match value.law.law if isinstance(value.law, Bounded) else value.law:
        case Lognormal(variation=spread):
            return Tolerance(value.name, "cov", spread, follows=follows)
        case Normal(deviation=spread):
            return Tolerance(value.name, "sd", spread, follows=follows)
    return Tolerance(value.name, kind, other=True, follows=follows)


def moved(old: Uncertain, value: float) -> float:
    """The same number with the same tolerance about another nominal value.

    A lognormal law, and its bounds, keep their share of the value; any other keeps its width.

    Raises
    ------
    ValueError
        If the law cannot be there.

    Examples
    --------
    >>> moved(-uncertain("gap", 0.006, sd=0.0006, bounds=(0.003, 0.009)), -0.005).itself
    uncertain('gap', 0.005, normal, standard deviation 0.0006, between 0.002 and 0.008)
    """
    if value == old:
        return value
    base = (value - old.plus) / old.times
    if old.power != 1.0 and not base > 0.0:
        raise ValueError(f"{old.name} must stay above 0: this number is a power of it.")
    # rounded: the same one from all numbers that follow from it
    found: float = _following(old, float(f"{base ** (1.0 / old.power):.14g}"), {})
    return found


def toleranced(system: System, opened: System, given: Mapping[str, float]) -> System:
    """The system with other tolerances, by the names of the uncertain numbers; 0 takes one away.

    Parameters
    ----------
    system : System
    opened : System
        The same with other numbers: it decides in what a tolerance is given.
    given : dict of str to float

    Raises
    ------
    ValueError
        If there is no such number, or its law is not possible.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> device = System(Spring(80.0), stop=Barrier(-0.003, 0.7))
    >>> toleranced(device, device, {"spring_stiffness": 0.05}).parts[0]
    Spring(stiffness=uncertain('spring_stiffness', 80.0, lognormal, 5 %))
    >>> toleranced(device, device, {"stop_restitution": 0.1}).parts[1].restitution
    uncertain('stop_restitution', 0.7, normal, standard deviation 0.1, between 0 and 1)
    """
    known, changes, named = numbers_of(system), dict[str, float](), set[str]()
    for name in numbers_of(opened) if given else ():
        own = tolerance_of(opened, name)
        if own.name not in given or name not in known:
            continue
        named.add(own.name)
        value, spread = known[name], given[own.name]
        if spread == 0.0:
            changes[name] = float(value)
        elif isinstance(value, Uncertain):
            changes[name] = _following(value, float(value.itself), {own.kind: spread})
        else:
            changes[name] = _alone(own, float(value), spread, LIMITS[number_of(system, name)[1].range])
    check_known("tolerances", given, named)
    return with_numbers(system, changes) if changes else system


def check_known(kind: str, names: Iterable[str], known: Container[str]) -> None:
    """That a system has the numbers that a message names."""
    for name in names:
        if name not in known:
            raise ValueError(f"{kind}: this system has no number {name[:60]!r}.")


def _alone(own: Tolerance, value: float, spread: float, limits: tuple[float, float]) -> Uncertain:
    """A plain number with a tolerance, within what the number can be."""
    stated: dict[str, Any] = {own.kind: spread}
    number = uncertain(own.name, value, **stated)
    is_inside = limits[0] <= number.low and number.high <= limits[1]
    return number if is_inside else uncertain(own.name, value, bounds=limits, **stated)


def _following(old: Uncertain, base: float, given: Mapping[str, float]) -> Any:
    """A number in the place of another one, with the same law about another value, or another law."""
    law, shift = old.law, base - float(old.itself)
    ends: tuple[float, float] | None = None
    if isinstance(law, Bounded):
        low, high, law = law.low, law.high, law.law
        is_share, times = isinstance(law, Lognormal), base / float(old.itself)
        ends = (low * times, high * times) if is_share else (low + shift, high + shift)
    stated: dict[str, Any] = {**given}
    match law:
        case _ if given:
            pass
        case Lognormal():
            stated["cov"] = law.variation
        case Normal():
            stated["sd"] = law.deviation
        case Uniform():
            ends = law.low + shift, law.high + shift
        case Measured():
            stated["values"] = [value + shift for value in law.values]
        case _:
            raise ValueError(f"{old.name} has a law of its own, {law}, which the page cannot move.")
    number: Any = uncertain(old.name, base, bounds=ends, **stated)
    raised = number if old.power == 1.0 else number**old.power
    return raised if (old.times, old.plus) == (1.0, 0.0) else old.times * raised + old.plus


def laws_of(system: System) -> dict[str, Any]:
    """The laws of the uncertain numbers, by name.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> laws_of(System(Spring(uncertain("k", 80.0, bounds=(70.0, 90.0)))))
    {'k': Uniform(low=70.0, high=90.0)}
    """
    return {name: number.law for name, number in uncertain_numbers(system).items()}
