"""A problem as a sum of parts: one mass with any springs, dampers, walls, contacts, circuits and excitations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import checked_name
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, listed, meant, nearest, shown
from springpot.problem.catalogue import check_result_names
from springpot.problem.coordinates import MOST_PARTS, Coordinates
from springpot.problem.matrices import parts_of_matrices
from springpot.problem.modes import FrequencyUnit, parts_of_modes
from springpot.problem.parts import (
    Barrier,
    Constant,
    Contact,
    Mass,
    ParametricNoise,
    Point,
    RecordedExcitation,
    SpectralExcitation,
    Springpot,
    ThermalNoise,
)
from springpot.problem.parts.checks import fields_of, plain
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.excitations import Excitation
from springpot.problem.parts.registration import Element, Part, kind_of
from springpot.problem.parts.springpots import resonance
from springpot.problem.parts.walls import Stop
from springpot.problem.potential import Potential

Kind = TypeVar("Kind")

MOST_CONTACTS = 16

_ROUNDING = 1e-12

KINDS: dict[str, type[Part]] = dict(sorted(Part.kinds.items(), key=lambda item: item[1].__name__))
"""Every kind of part by its name in a file."""


def owners_of(word: str) -> str:
    """The words "; did you mean Spring(stiffness=...)?" for a number of parts, their kind, or what is near; or nothing.

    Examples
    --------
    >>> owners_of("e"), owners_of("barier")
    ('; did you mean Barrier(restitution=...)?', '; did you mean Barrier(...)?')
    """
    numbers = {kind: [own.name for own in fields_of(kind) if own.repr] for kind in KINDS.values()}
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


def _by_name(kind: type[Kind], said: str) -> cached_property[dict[str, Kind]]:
    """A property of systems: the parts of a kind by name, in the order given."""

    def parts_of(system: System) -> dict[str, Kind]:
        return {name: part for name, part in system.named() if isinstance(part, kind)}

    parts_of.__doc__ = said
    return cached_property(parts_of)


@dataclass(frozen=True, init=False)
class System:
    """One mass on one coordinate x, or several, with the parts that act on them.

    Parameters
    ----------
    *parts
        The parts, of `springpot.problem.parts`.  With a `Mass` they are in SI units; without one, everything is per
        unit mass.  Several masses have names, ``at=``; parts say which they are `between`, excitations which they are
        `on`.  A `Point` moves as a combination of masses does.
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
        If the parts do not fit together: two masses of one name, walls that leave no room, a potential that lets a mass
        escape.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, Springpot, WhiteNoise
    >>> device = System(Mass(0.2), Spring(80.0), Springpot(0.5, 1.2), Barrier(-0.003, 0.7), WhiteNoise(0.02))
    >>> device.names
    ('mass', 'spring', 'springpot', 'barrier', 'white_noise')
    >>> device.natural_frequency
    20.0
    >>> System(Spring(2.0), stop=Barrier(-1.0))
    System(Spring(stiffness=2.0), stop=Barrier(position=-1.0, restitution=1.0, free_side='above'))

    An instrument on a panel, which shakes:

    >>> pair = System(
    ...     Mass(5.0, at="panel"), Mass(0.4, at="box"), Spring(8e4, between=("ground", "panel")),
    ...     Spring(900.0, between=("panel", "box")), WhiteNoise(2.0, on="panel"),
    ... )
    >>> pair.coordinates.elongations["spring_2"].tolist()
    [-1.0, 1.0]
    """

    parts: tuple[Any, ...]
    names: tuple[str, ...]

    def __init__(self, /, *parts: object, **named: object) -> None:
        for part in parts:
            _check_part(part)
        for name, part in named.items():
            _check_part(part, checked_name(name, "the name of a part"))
        object.__setattr__(self, "parts", (*parts, *named.values()))
        object.__setattr__(self, "names", (*_names(parts, set(named)), *named))
        _check_together(self)

    def __repr__(self) -> str:
        """As a call, with the names that were given."""
        kinds, count = [kind_of(part) for part in self.parts], len(self.parts)
        while [*self.names[:count]] != usual_names(kinds[:count]):
            count -= 1
        named = (f"{name}={part!r}" for name, part in [*self.stated()][count:])
        return f"System({', '.join([*map(repr, self.parts[:count]), *named])})"

    @classmethod
    def from_matrices(
        cls,
        mass: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike | None = None,
        *,
        names: Sequence[str] | Mapping[str, ArrayLike] | None = None,
        ground: ArrayLike | None = None,
        modes: int | None = None,
        damping_ratios: ArrayLike | None = None,
        residual: Sequence[str] = (),
    ) -> System:
        """Masses, springs and dashpots from their matrices, or the lowest modes of those of a finite element model.

        With a diagonal mass matrix each number off the diagonal is a spring or dashpot between two masses, and each sum
        of a row one to the ground; those of 0 are left out.  In other cases the
        masses are the modes, ``mode_1``, ``mode_2``, ..., as from `from_modes`, and the names are points on them: the
        mass matrix is another, no dashpots have that damping, as of beams, there are more than 48 springs and
        dashpots, or ``modes``, ``damping_ratios`` or points are given.  Dampers that couple the modes are between the
        ground and points ``damper_1``, ``damper_2``, ...

        Parameters
        ----------
        mass : array_like or sparse matrix, shape (coordinates, coordinates)
            Symmetric, in kg.  Coordinates whose rows are 0 follow the others statically (Guyan); the rest of the matrix
            is not singular.
        stiffness, damping : array_like or sparse matrix, shape (coordinates, coordinates)
            Symmetric, in N/m and N s/m.
        names : sequence of str, or dict, optional
            Of the coordinates, ``m1``, ``m2``, ... if they are left out; or of points: each is a coordinate, by its
            number from 0, ``{"tip": 298}``, or moves as several do, by its displacement where each moves by 1 alone,
            ``{"middle": [0.5, 0.5]}``.
        ground : array_like, optional
            How far each coordinate moves where everything moves by 1.  Without it that is 1, and with points nothing:
            then no acceleration of the ground can act.
        modes : int, optional
            How many of the lowest modes are taken, of matrices with up to 3,000 rows, or sparse ones with up to
            200,000.  A simulation holds 8.
        damping_ratios : array_like, optional
            Of the modes, over the critical damping, beside what ``damping`` has; one number is that of all.
        residual : sequence of str
            Points whose static flexibility is kept: each adds a mode, which has what the others leave out there
            (MacNeal, Rubin).  So does a stop there have its stiffness.

        Returns
        -------
        System
            Without excitation: add it, and other parts, as ``System(*frame.parts, WhiteNoise(0.1, on="ground"))``.

        Raises
        ------
        TypeError, ValueError
            If a matrix is not one, has another shape, is not symmetric, or has a motion without a mass.

        Warns
        -----
        AccuracyWarning
            If modes that are left out have more than 1 % of the static flexibility at a point, or 10 % of the mass that
            the ground moves.
        ProblemWarning
            If coordinates have no mass.
        StationarityWarning
            If modes have a frequency of 0.

        Examples
        --------
        >>> frame = System.from_matrices([[2.0, 0.0], [0.0, 1.0]], [[50.0, -20.0], [-20.0, 20.0]])
        >>> frame.parts[2:]
        (Spring(stiffness=30.0, between=('ground', 'm1')), Spring(stiffness=20.0, between=('m1', 'm2')))

        Two modes of a rod of 300 elements, free at one end, with its static stiffness there:

        >>> from scipy.sparse import diags_array
        >>> stiffness = diags_array([-3e5, 6e5, -3e5], offsets=[-1, 0, 1], shape=(300, 300)).tolil()
        >>> stiffness[299, 299] = 3e5
        >>> rod = System.from_matrices(
        ...     diags_array([0.01] * 299 + [0.005]), stiffness, modes=2, damping_ratios=0.01, names={"end": 299},
        ...     residual=["end"],
        ... )
        >>> rod.points
        ('mode_1', 'mode_2', 'mode_3', 'end')
        """
        return cls(*parts_of_matrices(
            mass, stiffness, damping, names, ground, modes, damping_ratios, residual
        ))  # fmt: skip

    @classmethod
    def from_modes(
        cls,
        frequencies: ArrayLike,
        masses: ArrayLike,
        shapes: Mapping[str, ArrayLike],
        damping_ratios: ArrayLike = 0.0,
        participations: ArrayLike = 0.0,
        *,
        unit: FrequencyUnit = "rad/s",
    ) -> System:
        """A structure by its modes, from a measurement or a finite element program.

        Parameters
        ----------
        frequencies : array_like, shape (modes,)
            Of each mode; 0 of one that no spring holds.
        masses : array_like, shape (modes,)
            Modal masses in kg, those of the shapes given; one number is that of all modes.
        shapes : dict of array_like, shape (modes,)
            For each point the value of every mode's shape there, by the name of the point.
        damping_ratios : array_like, shape (modes,)
            Over the critical damping; one number is that of all modes.
        participations : array_like, shape (modes,)
            How far each mode moves where everything moves by 1, phi^T M 1 / modal mass.  Without them no acceleration
            of the ground can act.
        unit : {"rad/s", "Hz"}
            Of the frequencies.

        Returns
        -------
        System
            Of masses ``mode_1``, ``mode_2``, ..., each with its spring and dashpot, and of a `Point` for each shape.
            Without excitation: add it, and other parts, as ``System(*frame.parts, WhiteNoise(0.1, on="tip"))``.

        Raises
        ------
        TypeError, ValueError
            If numbers are not as many as the modes, not finite or negative, or a shape has no name.

        Warns
        -----
        StationarityWarning
            If a frequency is 0.

        See Also
        --------
        springpot.read_modes : The same from a table in a file.

        Examples
        --------
        >>> mast = System.from_modes([6.0, 40.0], [2.0, 1.5], {"top": [1.0, -1.0], "middle": [0.4, 0.7]}, 0.01)
        >>> mast.points
        ('mode_1', 'mode_2', 'top', 'middle')
        """
        return cls(*parts_of_modes(frequencies, masses, shapes, damping_ratios, participations, unit))

    def of(self, *kinds: type[Kind]) -> tuple[Kind, ...]:
        """The parts of these kinds, in the order given."""
        return tuple(part for part in self._acting if isinstance(part, kinds))

    @cached_property
    def _acting(self) -> tuple[Any, ...]:
        return tuple(part.together for part in self.parts)

    def named(self) -> Iterator[tuple[str, Any]]:
        """Each part with its name, as it acts: several equal ones as the one that does what they do together."""
        return zip(self.names, self._acting, strict=True)

    def stated(self) -> Iterator[tuple[str, Any]]:
        """Each part with its name, as it was given."""
        return zip(self.names, self.parts, strict=True)

    def but(self, **parts: Any) -> System:
        """The same with other parts of these names, or with more."""
        return System(**dict(self.stated()) | parts)

    def name_of(self, part: object) -> str:
        """The name of one of its parts."""
        return next(name for name, own in (*self.named(), *self.stated()) if own is part)

    elements = _by_name(Element, "Its parts with two ends by name, in the order given.")
    stops = _by_name(Stop, "Its walls and contacts by name, in the order given.")
    walls = _by_name(Barrier, "Its rigid walls by name.")
    contacts = _by_name(Contact, "Its soft contacts by name.")
    springpots = _by_name(Springpot, "By name, of any order; not those in series with a spring.")
    excitations = _by_name(Excitation, "By name, in the order given.")
    constants = _by_name(Constant, "Its constant forces by name.")
    records = _by_name(RecordedExcitation, "Its recorded excitations by name.")
    densities = _by_name(SpectralExcitation, "Its noises of a given spectral density, by name.")
    circuits = _by_name(Circuit, "By name, in the order given.")
    multiplied = _by_name(ParametricNoise, "Its noises that multiply elongations, by name.")
    masses = _by_name(Mass, "The masses by name, that of each as a part.")
    combined = _by_name(Point, "The points that move as masses do together, by name, that of each as a part.")

    @cached_property
    def noises(self) -> dict[str, Excitation]:
        """Its excitations by name, without constant forces and the noise of all that dissipates."""
        kept = self.excitations.items()
        return {name: part for name, part in kept if name not in self.constants and part is not self.thermal}

    @cached_property
    def thermal(self) -> ThermalNoise | None:
        """The noise of all that dissipates, if there is one."""
        return next(iter(self.of(ThermalNoise)), None)

    @property
    def temperature(self) -> float:
        """kT of that noise, an energy in J; 0 without it."""
        return self.thermal.temperature if self.thermal else 0.0

    @property
    def counts(self) -> dict[str, int]:
        """How many equal ones there are of each part of which there are several, and of each group of such, by name.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> four = {"count": 4, "group": "mount"}
        >>> System(Spring(8.0, **four), Springpot(0.3, 2.0, **four)).counts
        {'spring': 4, 'springpot': 4, 'mount': 4}
        """
        found = {name: part.count for name, part in self.stated() if part.has_ends and part.count > 1}
        for group, names in self.groups.items():
            if names[0] in found and len({found.get(name) for name in names}) == 1:
                found[group] = found[names[0]]
        return found

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """The parts of each group by its name, in the order given: their forces are seen as one.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> System(Spring(8.0, group="mount"), Springpot(0.3, 2.0, group="mount")).groups
        {'mount': ('spring', 'springpot')}
        """
        found: dict[str, tuple[str, ...]] = {}
        for name, part in self.elements.items():
            if part.group:
                found[part.group] = (*found.get(part.group, ()), name)
        return found

    @property
    def grounded(self) -> dict[str, float]:
        """The parts between the ground and a point by name: 1, or -1 where the ground is the second end.

        Examples
        --------
        >>> from springpot.problem.parts import Mass, Spring, WhiteNoise
        >>> System(Mass(2.0), Spring(8.0), WhiteNoise(1.0)).grounded
        {'spring': 1.0}
        """
        ends = {name: part.between or ("ground", self.points[0]) for name, part in self.elements.items()}
        return {name: 1.0 if pair[0] == "ground" else -1.0 for name, pair in ends.items() if "ground" in pair}

    @property
    def with_functions(self) -> list[str]:
        """The names of parts that are or have functions of the user."""
        return [name for name, part in self.named() if part.has_function]

    @property
    def has_mass(self) -> bool:
        """Whether its numbers are in SI units, and not per unit mass."""
        return bool(self.masses)

    @cached_property
    def points(self) -> tuple[str, ...]:
        """The names of its masses, ``("mass",)`` of a single one without a name, and after them of its other points."""
        masses = tuple(mass.at for mass in self.masses.values() if mass.at) or ("mass",)
        return (*masses, *(point.at for point in self.combined.values()))

    @cached_property
    def coordinates(self) -> Coordinates:
        """The coordinates and their masses, and the row of numbers of each point and part."""
        masses, points = [*self.masses.values()] or [Mass(1.0)], self.combined.values()
        alone = Coordinates.of_masses(self.points[: len(masses)], [mass.value for mass in masses])
        shares = np.zeros((len(points), len(masses)))
        for row, point in zip(shares, points, strict=True):
            row[[alone.names.index(name) for name in point.of]] = point.shares
        at = replace(
            alone, points=self.points, rows=np.vstack([alone.rows, shares]),
            participations=np.array([mass.participation for mass in masses]),
        )  # fmt: skip
        parts = dict(self.named())
        whole = replace(
            at, ends={name: ends for name, part in parts.items() if (ends := getattr(part, "between", None))},
            elongations={name: row for name, part in parts.items() if (row := part.elongation(at)) is not None},
            forces={name: row for name, part in parts.items() if (row := part.push(at)) is not None},
        )  # fmt: skip
        inertial = {name: part.inertia for name, part in self.elements.items() if part.inertia}
        return replace(whole, mass=whole.mass + whole.sum_of(inertial))

    @property
    def stiffness_matrix(self) -> Floats:
        """Of the linear springs, and of the linear part of the others, on the coordinates."""
        springs = {name: part.static_stiffness for name, part in self.elements.items()}
        return np.asarray(self.coordinates.sum_of(springs))

    @property
    def constant_force(self) -> Floats:
        """On the coordinates."""
        forces = (part.force * self.coordinates.push(part.on) for part in self.constants.values())
        return np.asarray(sum(forces, np.zeros(len(self.coordinates.names))))

    @property
    def mass(self) -> float:
        """m in kg, which the ground accelerates; 1 without a `Mass`.

        Raises
        ------
        NotCoveredError
            If there are several masses, as for all that has one coordinate x.
        """
        check_single(self)
        return next((mass.value for mass in self.masses.values()), 1.0)

    @property
    def inertia(self) -> float:
        """The mass, and what other parts add to the inertia of the motion, in kg; in units of the mass without one."""
        return self.mass + sum(part.inertia for part in self.elements.values())

    @cached_property
    def per_unit_mass(self) -> System:
        """The same motion with every part divided by the inertia; forces of the ground are forces on the mass."""
        inertia, mass = float(self.inertia), float(self.mass)  # not marked ones: no number follows two of them
        return System(**{
            name: part.alone().per_mass(inertia, mass / inertia)
            for name, part in self.named()
            if "inertia" not in part.powers
        })  # fmt: skip

    @cached_property
    def potential(self) -> Potential:
        """The potential energy per unit of inertia, with the walls."""
        forces = [part.force_coefficients() for part in self._acting]
        size = max(1, *map(len, forces))
        coefficients = [sum(force[n] / self.inertia for force in forces if n < len(force)) + 0.0 for n in range(size)]
        last = max((n for n, c in enumerate(coefficients) if c != 0.0), default=0)
        walls = self.walls.values()
        return Potential(
            tuple(coefficients[: last + 1]),
            tuple(part.soft_stop.per_mass(float(self.inertia)) for part in self._acting if part.soft_stop is not None),
            max((wall.position for wall in walls if wall.free_side == "above"), default=-math.inf),
            min((wall.position for wall in walls if wall.free_side == "below"), default=math.inf),
        )

    @property
    def stiffness(self) -> float:
        """Of the linear springs, in N/m."""
        linear: float = sum((part.linear_stiffness for part in self._acting), 0.0)
        return linear

    @property
    def damping(self) -> float:
        """Coefficient of the linear dampers, without springpots of order 1, in N s/m."""
        linear: float = sum((part.linear_damping for part in self._acting), 0.0)
        return linear

    @property
    def dashpots(self) -> float:
        """Coefficient of the linear dampers, with springpots of order 1, in N s/m."""
        return self.damping + sum(
            springpot.coefficient for springpot in self.springpots.values() if springpot.order == 1.0
        )

    @property
    def natural_frequency(self) -> float:
        """The root of the linear springs' stiffness over the inertia, in rad/s; NaN where that is not positive."""
        return math.sqrt(self.stiffness / self.inertia) if self.stiffness > 0.0 else math.nan

    @property
    def resonance(self) -> float:
        """Frequency of small motion with the stiffness of elements with memory, in rad/s; NaN without a linear spring.

        The root w of m w^2 = k + Re K(iw), with k the stiffness of the linear springs and K the modulus of springpots,
        arms and circuits.

        Examples
        --------
        >>> from springpot.problem.parts import Spring, Springpot
        >>> held = System(Spring(1.0), Springpot(0.5, 1.0))
        >>> held.natural_frequency, round(held.resonance, 4)
        (1.0, 1.3496)
        """
        if not self.stiffness > 0.0:
            return math.nan
        damping = [part for part in self.per_unit_mass.parts if "damping" in part.powers and part.is_linear]
        return resonance(self.natural_frequency**2, damping)

    def to_dict(self) -> dict[str, Any]:
        """The parts as a file has them: a name, a kind and the numbers of each.

        Examples
        --------
        >>> from springpot.problem.parts import Spring
        >>> System(Spring(80.0)).to_dict()
        {'parts': [{'name': 'spring', 'kind': 'spring', 'stiffness': 80.0}]}
        """
        return {"parts": [{"name": name, "kind": kind_of(part), **plain(part)} for name, part in self.stated()]}


def checked_system(given: object, name: str = "system", wanted: str = "a System") -> System:
    """What was given under this name, if it is a system.

    Raises
    ------
    TypeError
        If it is something else.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> checked_system(System(Spring(80.0))).names
    ('spring',)
    """
    if not isinstance(given, System):
        raise TypeError(f"{name} must be {wanted}, not {shown(given)}.")
    return given


def check_single(system: System) -> None:
    """Refuse several masses, at the doors of what covers one.

    Raises
    ------
    NotCoveredError
        If there are several.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> check_single(System(Spring(80.0)))
    """
    if len(system.points) == 1:
        return
    if len(masses := system.coordinates.names) > 1:
        raise NotCoveredError(f"one mass is needed, and the system has {len(masses)}, {listed(masses)}.")
    raise NotCoveredError(f"one mass without other points is needed, and the system has {listed(system.points[1:])}.")


def system_of(model: object, name: str = "system") -> System:
    """A system, also from one part alone.

    Raises
    ------
    TypeError
        If it is neither.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> system_of(Spring(80.0)).stiffness
    80.0
    """
    whole = System(model) if type(model) in KINDS.values() else model
    return checked_system(whole, name, "a System or a part")


def _check_part(part: object, name: str = "") -> None:
    if isinstance(part, type) and part in KINDS.values():
        raise TypeError(f"a system's parts must be made with their numbers, as {part.__name__}(...), not the class.")
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
    if (contacts := len(system.contacts)) > MOST_CONTACTS:
        raise ValueError(f"a system must have at most {MOST_CONTACTS} contacts, not {contacts}.")
    if all("inertia" in part.powers for part in system.parts):
        raise ValueError("a system must have parts beside a mass, such as Spring(80.0) and WhiteNoise(0.02).")
    _check_ends(system)
    _check_groups(system)
    check_result_names(system)
    if len(system.of(ThermalNoise)) > 1:
        raise ValueError("a system must have one ThermalNoise at most: everything has the same temperature.")
    if system.thermal:
        for name, part in system.named():
            if not part.is_thermal:
                raise ValueError(f"{name} cannot be combined with ThermalNoise, which has no matching noise for it.")
    _check_walls(system)
    if len(system.points) == 1:
        _check_alone(system)
    else:
        _check_held(system)


def _check_ends(system: System) -> None:
    """That the masses have names where there are several, and every part is between, or on, one of them.

    Each sees some motion then, and each acceleration of the ground acts on something.
    """
    masses, points = [*system.masses.values()], system.points
    several = len(masses) > 1 or bool(system.combined)
    if several and not all(mass.at for mass in masses):
        raise ValueError(
            f"each of the {len(masses)} masses must have a name, as Mass({masses[0].value:g}, at='box'), which parts "
            "are between and excitations are on."
        )
    for at in points:
        if points.count(at) > 1:
            raise ValueError(
                f"{at} is the name of two {'points' if system.combined else 'masses'}: give one of them another name."
            )
    named = tuple(mass.at for mass in masses if mass.at)
    for name, point in system.combined.items():
        for one in point.of:
            if one not in named:
                near = meant(one, named) or (f"; there are {listed([*named])}." if named else "; there is none.")
                raise ValueError(f"{name} is a combination of masses, but {one!r} is no mass{near}")
    for name, mass in system.masses.items():  # which alone move with the ground as they are
        if mass.participation != 1.0 and not system.combined:
            raise ValueError(f"participation of {name} must be 1 in a system without a Point, as it moves by itself.")
    for name, part in system.named():
        part.check_ends(name, points)
    if len(points) == 1:
        return
    for name, row in system.coordinates.elongations.items():
        if not row.any():
            ends = system.coordinates.ends[name]
            raise ValueError(f"{name} is between {listed([*ends])}, which always move alike.")
    for name, push in system.coordinates.forces.items():
        if not push.any():
            raise ValueError(f"{name} accelerates the ground, but no mass has a participation.")


def _check_groups(system: System) -> None:
    """That groups have names of their own, and one elongation."""
    for group, names in system.groups.items():
        if group in system.names:
            raise ValueError(f"group of {names[0]} must be another name: {group} is that of a part.")
        ends = {system.elements[name].between or ("ground", system.points[0]) for name in names}
        if len(ends) > 1:
            raise ValueError(f"group {group} must be of parts with the same ends, but {listed(names)} have others.")


def _check_alone(system: System) -> None:
    """That the potential of one mass holds it, and that its numbers can be per unit mass."""
    if ends := system.potential.open_ends():
        raise ValueError(
            f"the potential must hold the mass, but it falls without limit to the {' and '.join(ends)}. Add a "
            "stiffening spring, as PolynomialSpring((0, 0, k3)), or a wall on that side."
        )
    if system.inertia != 1.0:
        try:
            _ = system.per_unit_mass
        except ValueError as fault:
            raise ValueError(f"the parts divided by the mass must be as without one: {fault}") from None


def _check_held(system: System) -> None:
    """That the energy of several masses does not fall without limit where one, or some of them, move."""
    at = system.coordinates
    values, ways = np.linalg.eigh(system.stiffness_matrix)
    falling = ways.T[values < -_ROUNDING * np.abs(values).max()]
    for way in (*np.eye(len(values)), *falling):
        if along(system, way).open_ends():
            moving = [point for point, share in zip(system.points, at.rows @ way, strict=True) if abs(share) > 1e-6]
            raise ValueError(
                f"the potential must hold the masses, but it falls without limit where {listed(moving)} "
                f"move{'s' if len(moving) == 1 else ''}: add a stiffer spring, a stiffening one or walls."
            )


def along(system: System, way: Floats) -> Potential:
    """The potential along a line through the origin, without constant forces.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring
    >>> ends = ("ground", "a"), ("a", "b")
    >>> pair = System(Mass(1.0, at="a"), Mass(1.0, at="b"), *(Spring(2.0, between=each) for each in ends))
    >>> along(pair, np.array([1.0, -1.0])).coefficients[:2]
    (0.0, 10.0)
    """
    coefficients, sizes = np.zeros(10), np.zeros(10)
    contacts: list[Contact] = []
    low, high = -math.inf, math.inf
    for name, row in system.coordinates.elongations.items():
        part, stretch = dict(system.named())[name], float(row @ way)
        if stretch == 0.0:
            continue
        force = np.array([c * stretch ** (n + 1) for n, c in enumerate(part.force_coefficients())])
        coefficients[: len(force)] += force
        sizes[: len(force)] += np.abs(force)
        if name in system.stops:
            stop = part if stretch > 0.0 else part.mirrored()
            place = float(stop.position) / abs(stretch)
            if (soft := stop.soft_stop) is not None:
                power = float(soft.exponent)
                stiffness = float(soft.stiffness) * abs(stretch) ** (power + 1.0)
                contacts.append(Contact(place, stiffness, power, free_side=stop.free_side))
            elif stop.free_side == "above":
                low = max(low, place)
            else:
                high = min(high, place)
    coefficients[np.abs(coefficients) <= _ROUNDING * sizes] = 0.0
    return Potential(tuple(coefficients.tolist()), tuple(contacts), low, high)


def _check_walls(system: System) -> None:
    """That no wall is hidden by another one, and that they leave room."""
    places = ("ground", *system.points)
    pairs: dict[tuple[str, str], list[tuple[str, Stop, Stop]]] = {}  # name, as it stands, and between ends in order
    for name, stop in system.stops.items():
        first, second = stop.between or ("ground", system.points[0])
        turned = places.index(first) > places.index(second)
        pair, oriented = ((second, first), stop.mirrored()) if turned else ((first, second), stop)
        pairs.setdefault(pair, []).append((name, stop, oriented))
    for (first, second), stops in pairs.items():
        _check_pair(stops, "x" if len(places) == 2 else f"x_{second}" + (f" - x_{first}" if first != "ground" else ""))
    if len(pairs) > 2:
        _check_rounds(pairs)


def _check_pair(stops: list[tuple[str, Stop, Stop]], x: str) -> None:
    walls = [each for each in stops if each[1].soft_stop is None]
    for name, stop, wall in walls:
        for other, seen, before in walls:
            hidden = (before.position - wall.position) * wall.inwards >= 0.0
            if other != name and before.free_side == wall.free_side and hidden:
                raise ValueError(f"{name} at {stop.position:g} must not lie behind {other}, at {seen.position:g}: "
                                 "it would never be struck.")  # fmt: skip
    low = max((wall.position for _, _, wall in walls if wall.free_side == "above"), default=-math.inf)
    high = min((wall.position for _, _, wall in walls if wall.free_side == "below"), default=math.inf)
    if not low < high:
        raise ValueError(f"the walls must leave room: {x} >= {low:g} and {x} <= {high:g} cannot both hold.")
    for name, stop, soft in stops:
        if soft.soft_stop is not None and (
            soft.position <= low if soft.free_side == "above" else soft.position >= high
        ):
            raise ValueError(f"{name} at {stop.position:g} must not lie behind a wall: it is never touched.")


def _check_rounds(pairs: dict[tuple[str, str], list[tuple[str, Stop, Stop]]]) -> None:
    """That walls between several pairs leave room: around any round of masses the gaps must not add up to 0 or less."""
    gaps: dict[tuple[str, str], tuple[float, tuple[str, ...]]] = {}  # the most that the second is ahead of the first
    for (first, second), stops in pairs.items():
        for name, _, wall in stops:
            if wall.soft_stop is None:
                way, most = (
                    ((first, second), wall.position) if wall.free_side == "below" else ((second, first), -wall.position)
                )
                gaps[way] = min(gaps.get(way, (math.inf, ())), (most, (name,)))
    ends = [*dict.fromkeys(end for way in gaps for end in way)]
    for through in ends:
        for first in ends:
            for second in ends:
                if (first, through) in gaps and (through, second) in gaps:
                    (one, names), (other, more) = gaps[first, through], gaps[through, second]
                    if first == second and one + other <= 0.0:
                        raise ValueError(f"the walls must leave room: {listed([*names, *more])} cannot all hold.")
                    gaps[first, second] = min(gaps.get((first, second), (math.inf, ())), (one + other, (*names, *more)))
