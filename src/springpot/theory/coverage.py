"""What a method covers: kinds of parts, and nothing that these do beyond that; and in which of its forms."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from types import UnionType
from typing import TypeVar

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts import (
    Barrier,
    Contact,
    Dashpot,
    FractionalMaxwell,
    Inerter,
    Mass,
    Maxwell,
    Point,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
)
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.springpots import order_at_rest
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.system import System, checked_system

Answer = TypeVar("Answer")

INERTIA = Mass | Inerter | Point
SPRINGS = Spring | PolynomialSpring
DAMPERS = Dashpot | PolynomialDashpot
ARMS = FractionalMaxwell | Maxwell
MEMORY = Springpot | ARMS | Circuit
STOPS = Barrier | Contact


@dataclass(frozen=True)
class Coverage:
    """What a method covers, stated once.

    Attributes
    ----------
    reach : str
        What is covered, as the sentence of a refusal begins.
    kinds : type
        A union of the kinds of parts that are covered.
    linear : type
        Those among them that must be linear: `PolynomialSpring`, `PolynomialDashpot`, or both.
    nonlinear : str
        What is said before the name of one that is not.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, PolynomialSpring, Spring
    >>> covered = Coverage("The example covers springs", Spring | PolynomialSpring)
    >>> covered.check(System(Spring(1.0), Dashpot(0.1)))
    Traceback (most recent call last):
        ...
    springpot.machine.faults.NotCoveredError: The example covers springs, not dashpot.
    """

    reach: str
    kinds: type | UnionType
    linear: type | UnionType | tuple[()] = ()
    nonlinear: str = "the nonlinear "

    def check(self, system: System, *, over: bool = False) -> None:
        """Raise `NotCoveredError` for a part that is not covered; ``over`` time envelopes are."""
        for name, part in system.named():
            wall, contact, is_linear = system.walls.get(name), system.contacts.get(name), part.is_linear
            if not isinstance(part, self.kinds):
                raise NotCoveredError(f"{self.reach}, not {name}.")
            if wall and slow_restitution(wall) == 0.0:
                raise NotCoveredError(f"{self.reach}, not {name} with plastic impacts (restitution 0).")
            if not over and getattr(part, "envelope", None) is not None:
                raise NotCoveredError(f"{self.reach}, not the envelope of {name}: it has no stationary state.")
            if isinstance(part, self.linear) and not is_linear:
                raise NotCoveredError(f"{self.reach}, not {self.nonlinear}{name}.")
            if contact and contact.dissipates:
                raise NotCoveredError(f"{self.reach}, not the dissipation of {name}.")

    def check_elastic(self, system: System) -> None:
        """The same for a wall that takes energy."""
        for name, wall in system.walls.items():
            if not wall.is_elastic:
                raise NotCoveredError(f"{self.reach}, not {name} of restitution {wall.law()}.")


def unheld(elements: Iterable[object], cause: str) -> str:
    """That there is no stationary state because of a cause, in one sentence; not where springpots alone may hold.

    Raises
    ------
    NotCoveredError
        If a springpot of an order below 1/2 may hold the mass without a spring.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot
    >>> unheld([Dashpot(1.0)], "no spring holds the mass")
    'There is no stationary state: no spring holds the mass.'
    """
    if any(0.0 < order_at_rest(part) < 0.5 for part in elements):
        raise NotCoveredError("A mass that a springpot holds without a spring is covered by the linear theory only.")
    return f"There is no stationary state: {cause}."


def form_of(
    system: System, paper: Callable[[System], Answer], *others: Callable[[System], Answer]
) -> Callable[[System], Answer]:
    """One of the functions: of the paper's problem, of other motions per unit mass, and the last of all systems.

    Theory decides here, and nowhere else, whether a system is the paper's problem.

    Raises
    ------
    TypeError
        If it is not a System.
    """
    try:
        _ = checked_system(system).per_unit_mass
    except NotCoveredError:
        return others[-1]
    try:
        Dimensionless.of(system)
    except NotCoveredError:
        return others[0]
    return paper
