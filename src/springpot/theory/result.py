"""The common result of all analytical methods."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from springpot.problem.catalogue import stated_in
from springpot.problem.parts.checks import put
from springpot.problem.system import System
from springpot.theory.walls import about_walls

ROUNDED = 1.0 + 1e-9
"""Factor on limits of what is covered, so that rounding errors do not exceed them."""

MOMENTS = (
    "amplitude_mean_square",
    "x_mean",
    "x_mean_square",
    "v_mean_square",
    "impact_rate",
    "impact_speed_mean",
    "impact_speed_mean_square",
)
"""Names of the stationary moments, the same in every method, in the simulation and in files."""
OF_A_POINT = ("x_mean", "x_mean_square", "v_mean_square")
"""What there is of each point, after how its names begin."""
OF_ENDS = ("elongation_mean", "elongation_mean_square")
"""What there is of each pair of masses with a part between them."""
OF_A_WALL = ("impact_rate", "impact_speed_mean", "impact_speed_mean_square", "force_mean")
NEVER_STRUCK = 0.0, math.nan, math.nan
"""Rate, mean and mean square speed of the impacts on a wall without any."""


class NoStationaryStateError(ValueError):
    """The system has no stationary state."""


class NoConvergenceError(ArithmeticError):
    """An iteration did not reach its tolerance; there is no result."""


@dataclass(frozen=True)
class Moments:
    """Stationary moments.

    Parameters
    ----------
    x_mean, x_mean_square, v_mean_square : float
        In m, m^2 and m^2 s^-2.
    amplitude_mean_square : float
        <A^2> with A^2 = x^2 + v^2 / Omega^2, in m^2, Omega the root of the linear stiffness over the mass; NaN where
        that is not positive.
    impact_rate : float
        Impacts per second on all walls and contacts together; 0 without impacts.
    impact_speed_mean, impact_speed_mean_square : float
        Of the speed just before an impact, in m/s and m^2 s^-2; NaN without impacts.
    of_parts : dict
        Of each wall and contact, by its name in the system: ``<wall>_impact_rate``, ``<wall>_impact_speed_mean`` and
        ``<wall>_impact_speed_mean_square``.  ``<wall>_force_mean``, in N (per kg without a `Mass`), is there for
        elastic walls and, by exact laws, for contacts.  ``harvested_power`` is the mean power in the resistors of the
        circuits, in W (per kg too).  Of several masses all moments are here, by the names of points and parts,
        and those above are NaN.
    """

    amplitude_mean_square: float
    x_mean: float
    x_mean_square: float
    v_mean_square: float
    impact_rate: float
    impact_speed_mean: float
    impact_speed_mean_square: float
    of_parts: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __repr__(self) -> str:
        """The numbers that there are."""
        return f"Moments({_shown({name: self[name] for name in (*MOMENTS, *self.of_parts)})})"

    def __getitem__(self, name: str) -> float:
        """A number by its name; NaN if there is none of this name."""
        return getattr(self, name) if name in MOMENTS else self.of_parts.get(name, math.nan)


def _shown(numbers: Mapping[str, float]) -> str:
    return ", ".join(f"{name}={value:.6g}" for name, value in numbers.items() if not math.isnan(value))


def names_of_results(system: System) -> tuple[str, ...]:
    """Names of the numbers in every method's result for a system; they depend on its parts and their names alone.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier
    >>> names_of_results(System(stop=Barrier(0.0)))[-3:]
    ('stop_impact_rate', 'stop_impact_speed_mean', 'stop_force_mean')
    """
    of_walls = stated_in(system, (f"{wall}_{what}" for wall in system.stops for what in OF_A_WALL))
    power = ["harvested_power"] if any(part.of_load for part in system.parts) else []
    return (*names_of_moments(system), *of_walls, *power)


def names_of_moments(system: System) -> Sequence[str]:
    """Names of the moments of all that moves: the points, the pairs with parts between them, and the one mass."""
    of_points = (f"{point}_{what}" for point in system.points for what in OF_A_POINT)
    of_pairs = (f"{pair}_{what}" for pair in system.coordinates.pairs for what in OF_ENDS)
    return stated_in(system, (*MOMENTS, *of_points, *of_pairs))


def moments_of(
    system: System,
    points: Iterable[Sequence[float]],
    pairs: Iterable[Sequence[float]] = (),
    hits: Sequence[Sequence[float]] = (),
    harvested: float | None = None,
) -> Moments:
    """The moments of a system from those of its points, its pairs and its walls, each in their order.

    Of a point <x>, <x^2> and <v^2>, of a pair those of the elongation.  Of a wall the rate of impacts, their mean and
    mean square speed, and its mean force, which may be left out; where a rate is NaN, that of all walls is.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Mass, Spring
    >>> walls = System(near=Barrier(-1.0), far=Barrier(2.0, free_side="below"))
    >>> moments_of(walls, [(0.0, 1.0, 1.0)], hits=[(1.0, 2.0, 5.0), (3.0, 4.0, 17.0)]).impact_speed_mean
    3.5
    >>> pair = System(Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(1.0, between=("a", "b")))
    >>> moments_of(pair, [(2.0, 5.0, 1.0), (0.0, 1.0, 1.0)], [(-2.0, 6.0)])["a_b_elongation_mean"]
    -2.0
    """
    at, found = system.coordinates, dict[str, float]()
    for begins, moments, words in (
        (at.beginnings, points, OF_A_POINT),
        ([f"{pair}_" for pair in at.pairs], pairs, OF_ENDS),
    ):
        for begin, numbers in zip(begins, moments, strict=True):
            found |= {f"{begin}{what}": float(number) for what, number in zip(words, numbers, strict=False)}
    struck = {wall: _struck(system, wall, *hit) for wall, hit in zip(system.stops, hits, strict=False)}
    found |= {f"{wall}_{what}": hit[i] for i, what in enumerate(OF_A_WALL) for wall, hit in struck.items()}
    found |= {} if harvested is None else {"harvested_power": harvested}
    if "x_mean_square" in found:
        found |= _of_the_whole(system, found, [hit for hit in struck.values() if hit[0] != 0.0])
    return Moments(**{name: found.pop(name, math.nan) for name in MOMENTS}, of_parts=found)


def _struck(system: System, name: str, rate: float, mean: float, square: float, *force: float) -> tuple[float, ...]:
    """The numbers of a wall, with no speeds where there are no impacts, and with the mean force of its impulses."""
    wall, at = system.stops[name], system.coordinates
    if not rate > 0.0:
        _, mean, square = NEVER_STRUCK
    if not force and name in system.walls and not wall.dissipates:  # on others a mass may rest
        force = (2.0 * at.reduced(at.elongations[name]) * rate * mean,)
    return rate, mean, square, *(force or (math.nan,))


def _of_the_whole(system: System, found: Mapping[str, float], struck: Sequence[Sequence[float]]) -> dict[str, float]:
    """A^2 = x^2 + v^2 / Omega^2 of the one mass, and the impacts on all walls that are struck."""
    total = math.fsum(hit[0] for hit in struck)  # NaN with a NaN
    mean, square = (sum(hit[0] * hit[i] for hit in struck) / total if total > 0.0 else math.nan for i in (1, 2))
    return {
        "amplitude_mean_square": found["x_mean_square"] + found["v_mean_square"] / system.natural_frequency**2,
        "impact_rate": total,
        "impact_speed_mean": mean,
        "impact_speed_mean_square": square,
    }


@dataclass(frozen=True)
class Result:
    """The result of one method for one system.

    Parameters
    ----------
    method : str
        Name of the method.
    system : System
        What was solved.
    stationary : Moments or str
        The stationary moments, or the sentence that says why there are none.
    assumptions : tuple of str
        The assumptions of the method, one sentence each.
    warnings : tuple of str
        Reasons to doubt the result, one sentence each, as far as the method itself knows them.  What the validity maps
        say of it is in `springpot.trust`.
    is_exact : bool
        Whether nothing is approximated here, although the method does elsewhere.

    Notes
    -----
    The numbers are attributes of the result, by the names that a run has: ``result.x_mean``, and of a wall
    ``result.<wall>_impact_rate``.  Without a stationary state they raise `NoStationaryStateError`; they are never
    infinite.
    """

    method: str
    system: System
    stationary: Moments | str
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
    is_exact: bool = field(default=False, kw_only=True)

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        cls.__repr__ = Result.__repr__  # type: ignore[method-assign]  # a dataclass does not replace one of the class

    def __repr__(self) -> str:
        """The method and its numbers, or why there are none."""
        if isinstance(self.stationary, str):
            return f"{type(self).__name__}(method={self.method!r}, stationary={self.stationary!r})"
        return f"{type(self).__name__}(method={self.method!r}, {_shown(self.numbers)})"

    def __post_init__(self) -> None:
        if isinstance(found := self.stationary, str):
            return
        rates = {wall: found[f"{wall}_impact_rate"] for wall in self.system.stops}
        doubts = about_walls(self.system, found.x_mean, found.x_mean_square, found.v_mean_square, rates)
        put(self, warnings=tuple(dict.fromkeys((*self.warnings, *doubts.values()))))

    @property
    def moments(self) -> Moments:
        """The stationary moments, all together.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        """
        if isinstance(self.stationary, str):
            raise NoStationaryStateError(self.stationary)
        return self.stationary

    @property
    def numbers(self) -> dict[str, float]:
        """All numbers by name, as `names_of_results` has them; NaN for one that does not exist."""
        found = self.moments
        return {name: found[name] for name in names_of_results(self.system)}

    def __getattr__(self, name: str) -> float:
        if not name.startswith("_") and name in names_of_results(self.system):
            return self.moments[name]
        of_first = f"{self.system.points[0]}_{name}"
        near = f"; did you mean {of_first}?" if name in MOMENTS and of_first in names_of_results(self.system) else ""
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}{near}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *names_of_results(self.system)})

    def to_dict(self) -> dict[str, object]:
        """The result as plain numbers, strings and lists, ready for JSON.

        Returns
        -------
        dict
            The numbers, what else the method has, ``assumptions`` and ``warnings``; a number that does not exist is
            None.  Without a stationary state every moment is None and ``statement`` says why.
        """
        if isinstance(self.stationary, str):
            numbers = no_answer(self.stationary, names_of_moments(self.system))
        else:
            numbers = {name: None if math.isnan(value) else value for name, value in self.numbers.items()}
        return {**numbers, **self._more(), "assumptions": list(self.assumptions), "warnings": list(self.warnings)}

    def _more(self) -> dict[str, object]:
        """What the method has beside the numbers that all have."""
        return {}


def no_answer(statement: str, names: Sequence[str] = MOMENTS) -> dict[str, object]:
    """Every moment as None, and the sentence that says why.

    Examples
    --------
    >>> no_answer("Nothing to say.")["statement"]
    'Nothing to say.'
    """
    return {**dict.fromkeys(names, None), "statement": statement}
