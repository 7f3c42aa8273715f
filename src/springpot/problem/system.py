"""A problem as a sum of parts: one mass with any springs, dampers, walls, contacts, circuits and excitations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any, TypeVar

from springpot.machine.faults import listed, meant, nearest, shown
from springpot.problem import parts as kinds
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts import (
    Barrier,
    Constant,
    Contact,
    Dashpot,
    Force,
    FractionalMaxwell,
    Friction,
    Mass,
    Maxwell,
    PiezoelectricCircuit,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
)
from springpot.problem.parts.springpots import resonance
from springpot.problem.potential import Potential

__all__ = ["KINDS", "System", "kind_of", "owners_of", "usual_names"]

Part = TypeVar("Part")

MOST_PARTS, MOST_CONTACTS = 64, 16  # more than a device has, and few enough that every theory answers in seconds


def kind_of(part: object) -> str:
    """The name of a part's kind in files and in names.

    Examples
    --------
    >>> kind_of(Spring(1.0)), kind_of(PolynomialSpring((1.0,)))
    ('spring', 'polynomial_spring')
    """
    name = type(part).__name__ if not isinstance(part, type) else part.__name__
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name)[1:]


KINDS: dict[str, type] = {kind_of(getattr(kinds, name)): getattr(kinds, name) for name in kinds.__all__}
"""Every kind of part by its name in a file."""


def owners_of(word: str) -> str:
    """The words "; did you mean Spring(stiffness=...)?" for a number of parts, their kind, or what is near; or nothing.

    Examples
    --------
    >>> owners_of("e"), owners_of("barier")
    ('; did you mean Barrier(restitution=...)?', '; did you mean Barrier(...)?')
    """
    numbers = {kind: [field.name for field in fields(kind)] for kind in KINDS.values()}
    name = nearest(word, [*KINDS, *(name for names in numbers.values() for name in names)])
    if not name:
        return ""
    simplest_first = sorted(numbers.items(), key=lambda item: len(item[1]))
    kinds = [f"{kind.__name__}({name}=...)" for kind, names in simplest_first if name in names]
    return f"; did you mean {listed([f'{KINDS[name].__name__}(...)'] if name in KINDS else kinds, 'or')}?"


def usual_names(kinds: Sequence[str]) -> list[str]:
    """The names of parts of these kinds: the kind, and a number where there are several.

    Examples
    --------
    >>> usual_names(["barrier", "spring", "barrier"])
    ['barrier_1', 'spring', 'barrier_2']
    """
    return [
        kind if kinds.count(kind) == 1 else f"{kind}_{kinds[: place + 1].count(kind)}"
        for place, kind in enumerate(kinds)
    ]


@dataclass(frozen=True, init=False)
class System:
    """One mass on one coordinate x, with the parts that act on it.

    Parameters
    ----------
    *parts
        The parts, of `springpot.problem.parts`.  With a `Mass` they are in SI units; without one, everything is per
        unit mass.
    **named
        More parts, with names of your own.  A part without one is called by its kind, with a number where there are
        several: ``barrier_1``, ``barrier_2``.

    Attributes
    ----------
    parts : tuple
        All parts, in the order given.
    names : tuple of str
        A name for each.

    Raises
    ------
    TypeError
        If something is not a part.
    ValueError
        If the parts do not fit together: two masses, walls that leave no room, a potential that lets the mass escape.

    Examples
    --------
    >>> from springpot.problem.parts import WhiteNoise
    >>> device = System(Mass(0.2), Spring(80.0), Springpot(0.5, 1.2), Barrier(-0.003, 0.7), WhiteNoise(0.02))
    >>> device.names
    ('mass', 'spring', 'springpot', 'barrier', 'white_noise')
    >>> device.canonical().natural_frequency
    20.0
    """

    parts: tuple[Any, ...]
    names: tuple[str, ...]

    def __init__(self, /, *parts: object, **named: object) -> None:
        for part in parts:
            _check_part(part)
        for name, part in named.items():
            _check_part(part, name)
        object.__setattr__(self, "parts", (*parts, *named.values()))
        object.__setattr__(self, "names", (*_names(parts, set(named)), *named))
        _check_together(self)

    def of(self, *kinds: type[Part]) -> tuple[Part, ...]:
        """The parts of these kinds, in the order given."""
        return tuple(part for part in self.parts if isinstance(part, kinds))

    def named(self) -> Iterator[tuple[str, Any]]:
        """Each part with its name."""
        return zip(self.names, self.parts, strict=True)

    def name_of(self, part: object) -> str:
        """The name of one of its parts."""
        return next(name for name, own in self.named() if own is part)

    @property
    def with_functions(self) -> list[str]:
        """The names of parts that are or have functions of the user."""
        return [
            name
            for name, part in self.named()
            if isinstance(part, Force) or (isinstance(part, Barrier) and _is_function(part.restitution))
        ]

    @property
    def mass(self) -> float:
        """m in kg; 1 without a `Mass`."""
        return next((mass.value for mass in self.of(Mass)), 1.0)

    @cached_property
    def per_unit_mass(self) -> System:
        """The same motion with every part divided by the mass; forces of the ground are forces on the mass."""
        divided = {name: part.per_mass(self.mass) for name, part in self.named() if not isinstance(part, Mass)}
        return System(**divided)

    @cached_property
    def potential(self) -> Potential:
        """The potential energy per unit mass, with the walls."""
        coefficients = [0.0] * 10
        for part in self.of(Spring, PolynomialSpring, Springpot, Constant):
            match part:
                case Spring():
                    coefficients[1] += part.stiffness / self.mass
                case PolynomialSpring():
                    for power, k in enumerate(part.coefficients, start=1):
                        coefficients[power] += k / self.mass
                case Springpot(order=0.0):
                    coefficients[1] += part.coefficient / self.mass
                case Constant():
                    coefficients[0] -= part.force / self.mass
        last = max((n for n, c in enumerate(coefficients) if c != 0.0), default=0)
        walls = self.of(Barrier)
        return Potential(
            tuple(coefficients[: last + 1]),
            tuple(contact.per_mass(self.mass) for contact in self.of(Contact)),
            max((wall.position for wall in walls if wall.side == "above"), default=-math.inf),
            min((wall.position for wall in walls if wall.side == "below"), default=math.inf),
        )

    @property
    def stiffness(self) -> float:
        """Of the linear springs, in N/m."""
        linear = sum(part.stiffness for part in self.of(Spring))
        return linear + sum(part.coefficients[0] for part in self.of(PolynomialSpring))

    @property
    def damping(self) -> float:
        """Coefficient of the linear dampers, without springpots of order 1, in N s/m."""
        linear = sum(part.coefficient for part in self.of(Dashpot))
        return linear + sum(part.coefficients[0] for part in self.of(PolynomialDashpot))

    @property
    def natural_frequency(self) -> float:
        """The root of the linear springs' stiffness over the mass, in rad/s; NaN where that is not positive."""
        return math.sqrt(self.stiffness / self.mass) if self.stiffness > 0.0 else math.nan

    @property
    def resonance(self) -> float:
        """Frequency of small motion with the stiffness of elements with memory, in rad/s; NaN without a linear spring.

        The root w of m w^2 = k + Re K(iw), with k the stiffness of the linear springs and K the modulus of springpots,
        arms and circuits.

        Examples
        --------
        >>> held = System(Spring(1.0), Springpot(0.5, 1.0))
        >>> held.natural_frequency, round(held.resonance, 4)
        (1.0, 1.3496)
        """
        if not self.stiffness > 0.0:
            return math.nan
        return resonance(
            self.natural_frequency**2,
            self.per_unit_mass.of(Springpot, FractionalMaxwell, Maxwell, PiezoelectricCircuit),
        )

    def to_dict(self) -> dict[str, Any]:
        """The parts as a file has them: a name, a kind and the numbers of each.

        Examples
        --------
        >>> System(Spring(80.0)).to_dict()
        {'parts': [{'name': 'spring', 'kind': 'spring', 'stiffness': 80.0}]}
        """
        return {"parts": [{"name": name, "kind": kind_of(part), **_numbers_of(part)} for name, part in self.named()]}

    def canonical(self) -> Dimensionless:
        """The same problem as an `Oscillator`.

        Returns
        -------
        Oscillator

        Raises
        ------
        NotCoveredError
            If it is more than one spring, one springpot, one wall and white noise; the sentence names the part.

        Examples
        --------
        >>> from springpot.problem.parts import WhiteNoise
        >>> System(Spring(4.0), Dashpot(0.1), WhiteNoise(2.0)).canonical().springpot
        Springpot(order=1.0, coefficient=0.1)
        """
        return Dimensionless.of(self)


def _numbers_of(part: Any) -> dict[str, Any]:
    """The fields of a part; a function as its name."""
    if isinstance(part, Force):
        return {"function": getattr(part.function, "__qualname__", repr(part.function)), "share": part.share}
    numbers = asdict(part)
    if isinstance(part, Barrier) and _is_function(part.restitution):
        numbers["restitution"] = getattr(part.restitution, "__qualname__", repr(part.restitution))
    return numbers


def _is_function(value: object) -> bool:
    return callable(value) and not is_dataclass(value)


def _check_part(part: object, name: str = "") -> None:
    if isinstance(part, type) and part in KINDS.values():
        raise TypeError(f"a system's parts must be made with their numbers, as {part.__name__}(...), not the class.")
    if isinstance(part, Dimensionless):
        raise TypeError("a system's parts must not be an Oscillator, but the parts of which it is the sum.")
    if type(part) not in KINDS.values():
        if name:
            near = owners_of(name) or "."
            raise TypeError(f"{name} must be a part of that name, as {name}=Spring(80.0), not {shown(part)}{near}")
        near = meant(type(part).__name__, [kind.__name__ for kind in KINDS.values()])
        raise TypeError(f"a system's parts must be objects such as Spring(80.0), not {shown(part)}{near}.")


def _names(parts: tuple[object, ...], taken: set[str]) -> Iterator[str]:
    """A name for each part: its kind, and a number where there are several."""
    for name in usual_names([kind_of(part) for part in parts]):
        if name in taken:
            raise ValueError(f"{name} is the name of two parts: give one of them another name.")
        yield name


def _check_together(system: System) -> None:
    """What only the whole can know."""
    if len(system.parts) > MOST_PARTS:
        raise ValueError(f"a system must have at most {MOST_PARTS} parts, not {len(system.parts)}.")
    if len(system.of(Contact)) > MOST_CONTACTS:
        raise ValueError(f"a system must have at most {MOST_CONTACTS} contacts, not {len(system.of(Contact))}.")
    if len(system.of(Mass)) > 1:
        raise ValueError(
            "a system must have one Mass at most, for it has one coordinate. Two equal masses that strike each other "
            "are one coordinate: see 'Two structures that pound each other' in docs/gallery/plot_41_pounding.py."
        )
    if len(system.parts) == len(system.of(Mass)):
        raise ValueError("a system must have parts beside a mass, such as Spring(80.0) and WhiteNoise(0.02).")
    _check_walls(system)
    if ends := system.potential.open_ends():
        raise ValueError(
            f"the potential must hold the mass, but it falls without limit to the {' and '.join(ends)}. Add a "
            "stiffening spring, as PolynomialSpring((0, 0, k3)), or a wall on that side."
        )
    if len(system.of(ThermalNoise)) > 1:
        raise ValueError("a system must have one ThermalNoise at most: everything has the same temperature.")
    if system.of(ThermalNoise):
        for name, part in system.named():
            nonlinear = isinstance(part, PolynomialDashpot) and not part.is_linear
            lossy = isinstance(part, Contact) and part.dissipation > 0.0
            if nonlinear or lossy or isinstance(part, VanDerPol | Friction | Force):
                raise ValueError(f"{name} cannot be combined with ThermalNoise, which has no matching noise for it.")
    if system.of(Mass):
        try:
            _ = system.per_unit_mass
        except ValueError as fault:
            raise ValueError(f"the parts divided by the mass must be as without one: {fault}") from None


def _check_walls(system: System) -> None:
    walls = [(name, part) for name, part in system.named() if isinstance(part, Barrier)]
    for name, wall in walls:
        for other, before in walls:
            hidden = before.position > wall.position if wall.side == "above" else before.position < wall.position
            if other != name and before.side == wall.side and (hidden or before.position == wall.position):
                raise ValueError(f"{name} at {wall.position:g} must not lie behind {other}, at {before.position:g}: "
                                 "it would never be struck.")  # fmt: skip
    low, high = system.potential.low, system.potential.high
    if not low < high:
        raise ValueError(f"the walls must leave room: x >= {low:g} and x <= {high:g} cannot both hold.")
    for name, part in system.named():
        if isinstance(part, Contact):
            out_of_reach = part.position <= low if part.side == "above" else part.position >= high
            if out_of_reach:
                raise ValueError(f"{name} at {part.position:g} must not lie behind a wall: it is never touched.")
