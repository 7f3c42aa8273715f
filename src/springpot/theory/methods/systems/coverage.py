"""What a method for systems covers: kinds of parts, and nothing that a contact or a damper does beyond that."""

from __future__ import annotations

from collections.abc import Iterable
from types import UnionType

from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import Barrier, PolynomialDashpot, PolynomialSpring
from springpot.problem.parts.springpots import order_at_rest
from springpot.problem.parts.walls import SoftStop, slow_restitution
from springpot.problem.system import System


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


def check_kinds(
    unit: System,
    reach: str,
    kinds: type | UnionType,
    linear: type | UnionType | tuple[()] = (),
    nonlinear: str = "the nonlinear ",
    *,
    over: bool = False,
) -> None:
    """Raise `NotCoveredError` for a part of another kind, and for a contact that dissipates.

    Parameters
    ----------
    unit : System
    reach : str
        What is covered, as the sentence begins.
    kinds : type
        A union of the kinds of parts that are covered.
    linear : type
        Those among them that must be linear: `PolynomialSpring`, `PolynomialDashpot`, or both.
    nonlinear : str
        What is said before the name of one that is not.
    over : bool
        Whether envelopes are covered.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring
    >>> check_kinds(System(Spring(1.0), Dashpot(0.1)), "The example covers springs", Spring | PolynomialSpring)
    Traceback (most recent call last):
        ...
    springpot.machine.faults.NotCoveredError: The example covers springs, not dashpot.
    """
    for name, part in unit.named():
        if not isinstance(part, kinds):
            raise NotCoveredError(f"{reach}, not {name}.")
        if isinstance(part, Barrier) and slow_restitution(part) == 0.0:
            raise NotCoveredError(f"{reach}, not {name} with plastic impacts (restitution 0).")
        if not over and getattr(part, "envelope", None) is not None:
            raise NotCoveredError(f"{reach}, not the envelope of {name}: it has no stationary state.")
        if isinstance(part, PolynomialSpring | PolynomialDashpot) and isinstance(part, linear) and not part.is_linear:
            raise NotCoveredError(f"{reach}, not {nonlinear}{name}.")
        if isinstance(part, SoftStop) and part.dissipates:
            raise NotCoveredError(f"{reach}, not the dissipation of {name}.")
