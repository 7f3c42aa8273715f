"""What each kind of part says of itself, once: its numbers with their units, and what the rest asks of every part.

Units, files and their schema, sliders, sentences and sums over the parts iterate over this; a kind that leaves an entry
out is refused when its file is imported.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from inspect import get_annotations
from sys import modules
from types import SimpleNamespace
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Protocol,
    Self,
    get_args,
    get_origin,
    get_type_hints,
)

from springpot.machine.arguments import LARGEST, check_whole, checked_name, finite_number
from springpot.machine.faults import listed, meant, shown
from springpot.problem.parts.checks import Checked, as_call, put

if TYPE_CHECKING:
    from springpot.machine.arrays import Floats
    from springpot.problem.coordinates import Coordinates

Power = Literal["inertia", "stored", "damping", "taken", "fed", "work", "input", "stop"]
"""What becomes of a part's power: none of an inertia, stored in a potential, or in the sum of all that damps; a result
of its own, taken from the motion, fed in or of either sign; fed in, with a mean known beforehand; taken by a stop."""
Noise = Literal["", "white", "impulses", "filtered"]
"""None; white; impulses at random times; or one with a value at every time, which filters make of a white one."""
Range = Literal["positive", "unsigned", "signed", "share", "fraction", "order", "exponent"]
Slopes = list[tuple[float, Any]]
"""Numbers of a part, and the derivative of its modulus by each."""

Ends = tuple[str, str] | None
"""The two points between which a part acts, or the ground and a point; not given, the ground and the one mass."""
PointName = Annotated[str, "the name of a mass or point"]
Names = Annotated[tuple[str, ...], "the names of masses"]
Count = Annotated[int, "how many equal parts"]
GroupName = Annotated[str, "the name of parts whose forces are seen as one"]


class Law(Protocol):
    """A guessed law of a motion of unit mass: what a part is told of it."""

    @property
    def temperature(self) -> float:
        """The mean square velocity."""

    @property
    def frequency(self) -> float:
        """Of the linear spring with the same variance."""

    @property
    def mean(self) -> float:
        """Of the displacement."""

    @property
    def variance(self) -> float:
        """Of the displacement."""

    def density_at(self, place: float) -> float:
        """Of the displacement, at a place."""

    def mean_of(self, function: Callable[[Any], Any]) -> float:
        """Of a function of the displacement, which takes an array."""


class Cycles(Protocol):
    """Periodic motions of several sizes: what a part is told of them, an array of means over each."""

    @property
    def v_square(self) -> Any:
        """Of v^2."""

    @property
    def v_third(self) -> Any:
        """Of \\|v\\|^3."""

    @property
    def v_fourth(self) -> Any:
        """Of v^4."""

    @property
    def xv_square(self) -> Any:
        """Of x^2 v^2."""


class Filter(NamedTuple):
    """Noise as the output of a filter, z' = A z + sqrt(q) b w with white w of intensity 1, and c z.

    Attributes
    ----------
    rates : tuple of tuple of float
        A.
    output : tuple of float
        c.
    driven : int
        The one state whose b is 1.
    intensity : float
        q.
    """

    rates: tuple[tuple[float, ...], ...]
    output: tuple[float, ...]
    driven: int
    intensity: float


_UNMEASURED = (Ends, PointName, Names, Count, GroupName)

_MANY = 100  # numbers of a record
MOST_EQUAL = 1000  # parts that are counted
_PER_MASS = {"N": (("m", 1), ("s", -2)), "J": (("m", 2), ("s", -2)), "W": (("m", 2), ("s", -3)), "kg": ()}
_WORD = re.compile(r"([A-Za-z]+)(?:\^(-?[a-z]+)|(-?\d+))?")


@dataclass(frozen=True)
class Number:
    """What a number of a part is.

    Parameters
    ----------
    symbol, said : str
        In equations, and in words.
    unit : str
        In a system with a `Mass`, such as ``"N s^alpha m-1"``, where alpha is the part's order; of the coefficients of
        a polynomial that of the force.  What has newtons in it is divided by the mass.
    range : {"positive", "unsigned", "signed", "share", "fraction", "order", "exponent"}
        Of what it may be, and of its slider; a fraction may be 0, a share may not.
    hint : str
        Ends the sentence where it is something else.
    per : str
        Of the coefficients of a polynomial: the nth is in ``unit`` over the nth power of this.
    mass : float, optional
        The power of the mass that divides it, where it is not that of the newtons in the unit.
    turns : bool
        Whether it changes its sign where an acceleration of the ground becomes a force.
    own : bool
        Whether the part itself checks it: it may be more than a number.

    Examples
    --------
    >>> stiffness = Number("k", "stiffness", "N m-1")
    >>> stiffness.mass_power, stiffness.unit_of(True), stiffness.unit_of(False)
    (1, 'N m-1', 's-2')
    >>> Number("k", "of a power", "N", per="m").unit_of(False, 3)
    'm-2 s-2'
    """

    symbol: str
    said: str
    unit: str = "1"
    range: Range = "positive"
    hint: str = ""
    per: str = ""
    mass: float | None = None
    turns: bool = False
    own: bool = False

    @property
    def mass_power(self) -> float:
        """The power of the mass that divides it."""
        newtons = (power for base, (power, _) in _parsed(self.unit).items() if base in _PER_MASS)
        return sum(newtons) if self.mass is None else self.mass

    def unit_of(self, heavy: bool, place: int = 0) -> str:
        """Its unit, with a mass or per unit mass; of a polynomial that of the coefficient at that place, from 1."""
        unit = unit_times(self.unit, self.per, -place)
        if heavy or not self.mass_power or unit == "1":
            return unit
        return per_unit_mass(unit) if self.mass is None else f"{unit} kg{-self.mass:g}"


class Instead(NamedTuple):
    """Another word for a number of a part: which number, what the word is, and the number from it."""

    field: str
    number: Number
    value: Callable[[Any, float], float]


def _parsed(unit: str) -> dict[str, tuple[int, str]]:
    """The powers of a unit's words, each with the name that is added to it."""
    found = {}
    for word in unit.split() if unit != "1" else ():
        base, named, power = _WORD.fullmatch(word).groups()  # type: ignore[union-attr]
        found[base] = (0 if named else int(power or 1), named or "")
    return found


def _written(powers: Mapping[str, tuple[int, str]]) -> str:
    words = []
    for base, (power, named) in powers.items():
        if named and power:
            words.append(f"{base}^({named}{power:+d})" if named[0] != "-" else f"{base}^({power}{named})")
        elif named or power:
            words.append(base + (f"^{named}" if named else "" if power == 1 else str(power)))
    return " ".join(words) or "1"


def per_unit_mass(unit: str) -> str:
    """A unit over kg, to the power at which newtons, joules or watts are in it.

    Examples
    --------
    >>> [per_unit_mass(unit) for unit in ("N", "N2 s", "N s^alpha m-1", "N m^-exponent", "W", "rad s-1")]
    ['m s-2', 'm2 s-3', 's^(alpha-2)', 'm^(1-exponent) s-2', 'm2 s-3', 'rad s-1']
    """
    powers = _parsed(unit)
    if not powers.keys() & _PER_MASS.keys():
        return unit
    found = {"m": (0, ""), "s": (0, "")}
    for base, (power, named) in powers.items():
        for word, size in _PER_MASS.get(base, ((base, 1),)):
            before, name = found.get(word, (0, ""))
            found[word] = (before + size * power, name + named)
    return _written(found)


def powers_of(unit: str, part: Any) -> list[tuple[str, float]]:
    """The words of a unit, each with its power for the numbers of a part.

    Examples
    --------
    >>> from springpot.problem.parts import Springpot
    >>> powers_of("N s^alpha m-1", Springpot(0.3, 1.0))
    [('N', 1.0), ('s', 0.3), ('m', -1.0)]
    """
    found = []
    for base, (power, named) in _parsed(unit).items():
        field = named.removeprefix("-").replace("alpha", "order")
        more = getattr(part, field) * (-1.0 if named[0] == "-" else 1.0) if named else 0.0
        found.append((base, power + more))
    return found


def unit_times(unit: str, other: str, power: int) -> str:
    """A unit times a power of another one.

    Examples
    --------
    >>> unit_times("N", "m s-1", -2)
    'N s2 m-2'
    """
    if not power:
        return unit
    powers = _parsed(unit)
    for base, (size, _) in _parsed(other).items():
        powers[base] = (powers.get(base, (0, ""))[0] + power * size, "")
    return _written(dict(sorted(powers.items(), key=lambda item: item[1][0] < 0)))


def in_words(unit: str) -> str:
    """A unit as sentences have it.

    Examples
    --------
    >>> in_words("m2 s-3"), in_words("N2 s")
    ('m^2/s^3', 'N^2 s')
    """
    words = re.sub(r"([A-Za-z])(-?\d)", r"\1^\2", unit).split()
    above, below = ([word for word in words if ("^-" in word) == down] for down in (False, True))
    under = "/".join(["", *(word.replace("^-", "^").removesuffix("^1") for word in below)])
    return (" ".join(above) or "1") + under


LIMITS = {"positive": (0.0, LARGEST), "unsigned": (0.0, LARGEST), "signed": (-LARGEST, LARGEST), "share": (0.0, 1.0),
           "fraction": (0.0, 1.0), "order": (0.0, 1.0), "exponent": (1.0, 3.0)}  # fmt: skip


def in_range(value: object, name: str, number: Number) -> float:
    """A number that is what it says of itself.

    Raises
    ------
    TypeError, ValueError
        If it is not one, not finite or out of its range.
    """
    (low, high), open_low = LIMITS[number.range], number.range in ("positive", "share")
    return finite_number(value, name, low=low, high=high, open_low=open_low, hint=number.hint)


def kind_of(part: object) -> str:
    """The name of a part's kind in files and in names.

    Examples
    --------
    >>> from springpot.problem.parts import PolynomialSpring, Spring
    >>> kind_of(Spring(1.0)), kind_of(PolynomialSpring)
    ('spring', 'polynomial_spring')
    """
    name = part.__name__ if isinstance(part, type) else type(part).__name__
    return re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()


def stated_numbers(kind: type) -> dict[str, Any]:
    """What each field of a kind of part or law is: a `Number`, a dict of those of a part of a part, or None.

    Raises
    ------
    TypeError
        If a field that holds numbers does not say so.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> stated_numbers(Spring)["stiffness"].unit
    'N m-1'
    """
    return {name: said for each in reversed(kind.__mro__) for name, said in _own_numbers(each).items()}


@cache
def _own_numbers(kind: type) -> dict[str, Any]:
    """Those of the fields that a class declares itself: what all parts and families declare is read once."""
    declared = {name: hint for name, hint in get_annotations(kind).items() if "ClassVar" not in str(hint)}
    own = SimpleNamespace(__annotations__=declared)
    found = {}
    for name, hint in get_type_hints(own, vars(modules[kind.__module__]), include_extras=True).items():
        said = [what for what in getattr(hint, "__metadata__", ()) if isinstance(what, Number | dict)]
        part_or_law = isinstance(hint, type) and issubclass(hint, Checked)
        law_or_none = any(isinstance(one, type) and issubclass(one, Checked) for one in get_args(hint)) and not said
        plain = hint in _UNMEASURED or get_origin(hint) in (Literal, Callable) or part_or_law or law_or_none
        if not said and not plain:
            raise TypeError(
                f"{kind.__name__}.{name} must say its symbol, words and unit, as Annotated[float, Number(...)]."
            )
        found[name] = said[0] if said else None
    return found


class Stated(Checked):
    """What says of its numbers what they are, and whatever else its family needs, when its class is made.

    Attributes
    ----------
    numbers : dict
        What its fields are, by `stated_numbers`.
    """

    numbers: ClassVar[dict[str, Any]]

    @classmethod
    def _state(cls, family: type[Stated], needed: Iterable[str], called: str) -> None:
        """Check that all that its family needs is in the class, and keep what it says of its numbers."""
        if missing := [name for name in needed if getattr(cls, name, None) is getattr(family, name, None)]:
            raise TypeError(f"{cls.__name__} must state {listed(missing)}, as every {called} does.")
        cls.numbers = stated_numbers(cls)
        cls.__repr__ = Stated.__repr__  # type: ignore[method-assign]  # a dataclass does not replace one of the class itself

    def __post_init__(self) -> None:
        for name, number in self.numbers.items():
            if isinstance(number, Number) and not (number.per or number.own):
                put(self, **{name: in_range(getattr(self, name), name, number)})

    def __repr__(self) -> str:
        """As a call on one line; what is said only where there are several masses stands there where it is given."""
        return as_call(self)


class Form(Stated):
    """A function with numbers, one of a family: in a file it is a table of its numbers with a word for its kind.

    Attributes
    ----------
    known : dict
        The kinds of the family, by that word.
    key : str
        What the word is called in files.
    called : str
        What each of them is.
    needed : tuple of str
        What each of them must state.
    """

    known: ClassVar[dict[str, type[Any]]]
    key: ClassVar[str]
    called: ClassVar[str]
    needed: ClassVar[tuple[str, ...]]

    def __init_subclass__(cls) -> None:
        if (family := cls.__bases__[0]) is not Form:
            cls._state(family, cls.needed, cls.called)
            word = kind_of(cls).removesuffix(f"_{kind_of(family)}")
            cls.tag, cls.known[word] = {cls.key: word}, cls

    def words(self) -> str:
        """The formula with its numbers."""
        raise NotImplementedError


class Part(Stated):
    """What every kind of part states beside its fields.

    Each entry that is not given here must be in the class, as a constant or a property; each field that holds numbers
    must be ``Annotated[float, Number(...)]``.

    Attributes
    ----------
    said : str
        Its words on the page.
    glyph : str
        How the page draws it.
    powers : tuple of {"inertia", "stored", "damping", "taken", "fed", "work", "input", "stop"}
        What becomes of its power; of two if that depends on its numbers.
    of_load : {"", "voltage", "current"}
        Of a circuit, what its load turns into power.

    Examples
    --------
    >>> try:
    ...     class Magnet(Part):
    ...         said, glyph, powers = "magnet", "spring", ("stored",)
    ... except TypeError as error:
    ...     print(error)
    Magnet must state is_linear, remembers, dissipates, is_thermal, is_odd and force_coefficients, as every part does.
    """

    kinds: ClassVar[dict[str, type[Part]]] = {}
    instead: ClassVar[dict[str, Instead]] = {}  # other words for a number, on the axes of studies
    said: ClassVar[str]
    glyph: ClassVar[str]
    powers: ClassVar[tuple[Power, ...]]
    beside: ClassVar[tuple[str, ...]] = ()  # what else a family of parts must state
    has_ends: ClassVar[bool] = False  # whether it acts between two points
    noise: ClassVar[Noise] = ""  # in its force
    of_load: ClassVar[Literal["", "voltage", "current"]] = ""
    is_placed: ClassVar[bool] = False  # whether its own law has x in it, beside a spring's: elsewhere it is another one
    has_modulus: ClassVar[bool] = False  # whether its force follows from its modulus alone: a springpot, arm or circuit
    yields: ClassVar[bool] = False  # whether it is a spring until it yields

    @property
    def is_linear(self) -> bool:
        """Whether its force is linear in the motion, or does not depend on it."""
        raise NotImplementedError

    @property
    def remembers(self) -> bool:
        """Whether its force depends on the past motion."""
        raise NotImplementedError

    @property
    def dissipates(self) -> bool:
        """Whether it takes energy from the motion."""
        raise NotImplementedError

    @property
    def is_thermal(self) -> bool:
        """Whether a `ThermalNoise` has the noise that belongs to it, or it needs none."""
        raise NotImplementedError

    @property
    def is_odd(self) -> bool:
        """Whether its force only changes its sign with the motion, or has a law that is the same for both signs."""
        raise NotImplementedError

    def __init_subclass__(cls, abstract: bool = False) -> None:
        if abstract:
            return
        powers = getattr(cls, "powers", ())
        of_powers = (name for power, name in _OF_A_POWER.items() if power in powers)
        cls._state(Part, (*_ENTRIES, *cls.beside, *of_powers), "part")
        if wrong := {*powers} - {*get_args(Power)}:
            raise TypeError(f"{cls.__name__}.powers must be of {listed(get_args(Power))}, not {listed(sorted(wrong))}.")
        Part.kinds[kind_of(cls)] = cls

    # what a part may have beside; a part that does not say so has none of it

    @property
    def inertia(self) -> float:
        """What it adds to the inertia, in kg; the ground accelerates that of the mass alone."""
        return 0.0

    @property
    def linear_stiffness(self) -> float:
        """Of its linear spring, in N/m."""
        return self.static_stiffness if "stored" in self.powers else 0.0

    @property
    def static_stiffness(self) -> float:
        """The same, of a springpot of order 0 too."""
        return (*self.force_coefficients(), 0.0, 0.0)[1]

    @property
    def is_bent(self) -> bool:
        """Whether its force is a nonlinear function of the displacement."""
        return any(self.force_coefficients()[2:])

    def mean_stiffness(self, spread: float) -> float:
        """E[k1 + 2 k2 u + 3 k3 u^2 + ...] for a normal elongation u of mean 0, with this standard deviation."""
        whole, moment = 0.0, 1.0
        for n, k in enumerate(self.force_coefficients()):
            if n % 2 == 1:
                whole += n * k * moment
                moment *= n * spread**2
        return whole

    def largest_stiffness(self, reach: float) -> float:
        """Of its spring, at elongations up to this one."""
        import numpy as np  # here, so that the command starts quickly

        u, polynomial = np.linspace(-reach, reach, 201), np.polynomial.polynomial
        return float(max(polynomial.polyval(u, polynomial.polyder(self.force_coefficients()))))

    def energy_beside(self, elongation: Floats) -> Any:
        """Potential energy at elongations, beside that of its linear spring; infinite behind a wall."""
        from numpy.polynomial import polynomial  # here, so that the command starts quickly

        return polynomial.polyval(elongation, polynomial.polyint([0.0, 0.0, *self.force_coefficients()[2:]]))

    def seen_from(self, origin: float) -> Self:
        """The same part where x is measured from another place."""
        return self

    @property
    def is_of_paper(self) -> bool:
        """Whether the paper's problem can have it."""
        return False

    @property
    def is_seen(self) -> bool:
        """Whether a run can show its force."""
        return False

    @property
    def linear_damping(self) -> float:
        """Of its linear damper, in N s/m."""
        return (*self.damping_coefficients(), 0.0)[0]

    @property
    def dashpot(self) -> float:
        """The same, of a springpot of order 1 too."""
        return self.linear_damping

    @property
    def relaxation(self) -> tuple[float, float]:
        """Weight k and rate r of its modulus where that is k p / (p + r), as of a Maxwell element; 0 of others."""
        return 0.0, 0.0

    def scales(self, stiffness: float = 0.0, share: float = 0.0) -> list[float]:
        """Frequencies about which the motion changes by it, beside a stiffness per mass; share is one over the mass."""
        return []

    @property
    def soft_stop(self) -> Any:
        """The contact with its conservative force."""
        return None

    # what it does to cycles of the motion, and to a motion of which the law is known

    @property
    def has_equivalent(self) -> bool:
        """Whether its force is one of the present elongation and its rate, `force_coefficients` and a damper's."""
        return False

    def equivalent_damping(self, mean: float, spread: float, speed: float) -> float:
        """E[w F] / E[w^2] of a damper for a normal elongation, and a normal rate w that is independent of it."""
        equivalents = 1.0, 2.0 * math.sqrt(2.0 / math.pi) * speed, 3.0 * speed**2
        return math.fsum(c * each for c, each in zip(self.damping_coefficients(), equivalents, strict=False))

    def force_beside(self, x: Any, v: Any) -> Any:
        """Of a damper that is no polynomial of v, at displacements and velocities."""
        return 0.0

    def power_beside(self, cycles: Cycles) -> Any:
        """The mean power of this force over cycles."""
        return 0.0

    # what it does to a motion of which the size and the frequency are known, roughly: for guesses of scales

    @property
    def is_rough(self) -> bool:
        """Whether its damping depends on the size of the motion."""
        return False

    @property
    def stiffness_at_once(self) -> float:
        """Of an arm, a circuit or what yields, before it gives way, in N/m."""
        return 0.0

    @property
    def rate_of_its_own(self) -> float:
        """The frequency of a circuit's own, which the step must follow, in rad/s."""
        return 0.0

    @property
    def time_of_its_own(self) -> float:
        """In which the energy of a circuit with a coil decays where nothing moves, in s."""
        return 0.0

    @property
    def slow_springpot(self) -> tuple[float, float]:
        """Order and coefficient of the springpot that it is for slow motion; the order is 0 if it is none."""
        return 0.0, 0.0

    @property
    def fast_springpot(self) -> tuple[float, float]:
        """The same of the springpot or dashpot that it is for fast motion too, without a spring in series."""
        return (0.0, 0.0) if self.stiffness_at_once else self.slow_springpot

    @property
    def creeps(self) -> bool:
        """Whether its memory fades like a power of time."""
        return False

    def slow_dashpot(self, square: float, theta: float) -> float:
        """The dashpot that a part which yields is for slow displacements, beside a stiffness and a fast motion."""
        return 0.0

    def slowed(self, factor: float) -> Self:
        """The same material where everything takes this many times as long, as in the cold."""
        return self

    @property
    def feeds(self) -> bool:
        """Whether it feeds energy into a motion, whose size follows from that."""
        return False

    @property
    def sustains(self) -> bool:
        """Whether a motion that begins at rest goes on for ever with it."""
        return self.feeds

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """What it takes of a motion of unit mass at a frequency: a rate, times the temperature, and a power beside."""
        return (self.modulus(1j * frequency).imag / frequency if self.has_modulus else 0.0), 0.0

    def fed_beside(self, law: Law) -> float:
        """What a damper feeds in, beside what it takes: the net power says nothing of how fast a motion changes."""
        return 0.0

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """Power that an excitation feeds into a unit mass of this frequency, decay rate and mean square elongation."""
        return 0.0

    def fastest_rate(self, law: Law) -> float:
        """The rate that it adds to those that the step must follow, in 1/s."""
        return max(math.sqrt(self.stiffness_at_once), self.rate_of_its_own)

    def damping_beside(self, spread: float, speed: float, reduced: float) -> float:
        """Mean power over the mean square rate of a normal elongation, of what damps beside the linear part.

        ``spread`` and ``speed`` are its standard deviation and that of its rate; ``reduced`` is the mass that moves.
        """
        return 0.0

    def strongest_damping(self, spread: float, speed: float) -> float:
        """Of a damper, with what it feeds in and what it takes both counted."""
        return 0.0

    @property
    def of_ground(self) -> bool:
        """Whether it is an acceleration of the ground."""
        return getattr(self, "on", "mass") == "ground"

    @property
    def has_function(self) -> bool:
        """Whether it is, or has, a function of the user."""
        return False

    def force_coefficients(self) -> tuple[float, ...]:
        """Those of what it adds to the force U'(x) = c0 + c1 x + c2 x^2 + ..."""
        return ()

    def damping_coefficients(self) -> tuple[float, ...]:
        """Those of what it adds to the damper's force c1 v + c2 v abs(v) + c3 v^3."""
        return ()

    def modulus(self, p: Any) -> Any:
        """Force per displacement at the Laplace variable p: of a number or an array."""
        return self.linear_stiffness + self.linear_damping * p

    def slopes(self, p: Any) -> Slopes:
        """The derivative of the modulus by each of its numbers that is in it."""
        return [(number, slope) for number, slope in ((self.linear_stiffness, 1.0), (self.linear_damping, p)) if number]

    def elongation(self, at: Coordinates) -> Floats | None:
        """The row of the motion that it sees, along which its force acts; None of what sees none."""
        return None

    def push(self, at: Coordinates) -> Floats | None:
        """The forces on the coordinates per unit of what it is; None of what acts along a row that it sees."""
        return None

    def check_ends(self, name: str, points: tuple[str, ...]) -> None:
        """That it acts at points of the system.

        Raises
        ------
        ValueError
            If it is to act at another one, or does not say where.
        """

    @property
    def together(self) -> Self:
        """The one part that does what all of several equal ones do."""
        return self

    def alone(self) -> Self:
        """The same part where there is one mass, which needs no name."""
        return self

    def term(self) -> str:
        """Its force in the equation of motion."""
        return ""

    def line(self, name: str) -> str:
        """A line of its own beside the equation of motion."""
        return ""

    def measure(self, name: str, frequency: float, resonance: float, own: Part) -> str:
        """Its size per unit mass beside that of the springs, in words; ``own`` is the part before the division."""
        return ""

    def per_mass(self, mass: float, share: float = 1.0) -> Self:
        """The same part of a system that is divided by its inertia.

        Parameters
        ----------
        mass : float
            The inertia.
        share : float
            That of the mass in it, which the ground accelerates.
        """
        if mass == 1.0 and not self.of_ground:
            return self
        changes: dict[str, Any] = {}
        for name, number in self.numbers.items():
            value = getattr(self, name)
            if isinstance(value, Part):
                changes[name] = value.per_mass(mass, share)
            elif isinstance(number, Number) and number.mass_power:
                change = self._change(number, mass, share)
                changes[name] = _each(change, value)
        if self.of_ground:
            changes["on"] = "mass"
        return replace(self, **changes) if changes else self  # type: ignore[type-var]

    def _change(self, number: Number, mass: float, share: float) -> Callable[[float], float]:
        power = number.mass_power
        if number.turns:
            factor = -share if self.of_ground else 1.0 / mass
            return lambda value: factor * value
        if self.of_ground:
            return lambda value: value * share**power
        divisor = mass**power
        return lambda value: value / divisor


def _each(change: Callable[[Any], Any], value: Any) -> Any:
    if not isinstance(value, tuple):
        return change(value)
    if len(value) > _MANY and {*map(type, value)} == {float} and type(change(value[0])) is float:
        import numpy as np  # slow to import; the same bits, and ten times faster for a long record

        return tuple(np.asarray(change(np.array(value))).tolist())
    return tuple(_each(change, own) if isinstance(own, tuple) else change(own) for own in value)


@dataclass(frozen=True, kw_only=True)
class Element(Part, abstract=True):
    """A part with two ends: its displacement is that of the second end less that of the first, its elongation.

    Attributes
    ----------
    between : tuple of str, optional
        The names of the two masses, or ``"ground"`` and that of a mass.  It is not needed where there is one mass.
    count : int
        How many such parts act side by side.  The numbers are those of one; powers are those of all, and
        ``<name>_force_of_one`` is the force of one, ``<name>_force`` that of all.
    group : str, optional
        A name that parts with the same ends have in common, as the spring and the springpot of a mount:
        ``<group>_force`` is the sum of their forces, wherever forces are asked for.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> Spring(80.0, between=("panel", "box")).between
    ('panel', 'box')
    >>> Spring(80.0, count=4).together
    Spring(stiffness=320.0)
    """

    has_ends = True

    between: Ends = field(default=None, repr=False)
    count: Count = field(default=1, repr=False)
    group: GroupName = field(default="", repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.between is not None:
            put(self, between=checked_ends(self.between))
        check_whole(self.count, "count", 1, MOST_EQUAL)
        if self.count > 1 and ("input" in self.powers or self.together == replace(self, count=1)):
            raise ValueError(f"count must be left out of a {type(self).__name__}: it says nothing of several of them.")
        if not isinstance(self.group, str) or self.group:
            checked_name(self.group, "group")

    @property
    def together(self) -> Self:
        """The one part that does what all ``count`` equal ones do side by side."""
        return self if self.count == 1 else replace(self, count=1).per_mass(1.0 / self.count)

    def elongation(self, at: Coordinates) -> Floats:
        """That of its two ends."""
        return at.row(self.between)

    def check_ends(self, name: str, points: tuple[str, ...]) -> None:
        """That they are two points, or the ground and a point."""
        check_between(name, self.between, points)

    def alone(self) -> Self:
        """Without its ends, and without a group."""
        return self if self.between is None and not self.group else replace(self, between=None, group="")


def checked_ends(given: object) -> tuple[str, str]:
    """The names of two different ends.

    Raises
    ------
    TypeError, ValueError
        If they are not.

    Examples
    --------
    >>> checked_ends(["ground", "box"])
    ('ground', 'box')
    """
    if not isinstance(given, tuple | list) or len(given) != 2 or not all(isinstance(end, str) for end in given):
        raise TypeError(f"between must be the names of two ends, as ('ground', 'box'), not {shown(given)}.")
    first, second = given
    if first == second:
        raise ValueError(f"between must be two different ends, not {first!r} twice.")
    return first, second


def check_between(name: str, between: Ends, points: tuple[str, ...]) -> None:
    """Check that a part of this name acts between two of these points, or the ground and one of them.

    Raises
    ------
    ValueError
        If it does not, or does not say between which.
    """
    known = ("ground", *points)
    if between is None:
        if len(points) > 1:
            raise ValueError(f"{name} must say between which masses it acts, as between=({known[0]!r}, {known[1]!r}).")
        return
    for end in between:
        if end not in known:
            near = meant(end, known) or f"; there are {listed([*known])}."
            raise ValueError(f"{name} is between {between[0]!r} and {between[1]!r}, but {end!r} is no mass{near}")
    if len(points) == 1 and between[0] != "ground":
        raise ValueError(
            f"{name} must be between ('ground', {points[0]!r}), in this order: x is measured from the ground."
        )


_OF_A_POWER = {"stored": "force_coefficients", "inertia": "inertia"}
_ENTRIES = ("said", "glyph", "powers", "is_linear", "remembers", "dissipates", "is_thermal", "is_odd")
