"""A method with forms: of the paper's problem in its dimensionless numbers, of other motions of one x, of all."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system

Answer = TypeVar("Answer")


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
