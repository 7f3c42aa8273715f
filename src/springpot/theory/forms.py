"""A method with two forms: one of the paper's problem, in its dimensionless numbers, and one of all other systems."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system

Answer = TypeVar("Answer")


def form_of(
    system: System, paper: Callable[[System], Answer], others: Callable[[System], Answer]
) -> Callable[[System], Answer]:
    """One of two functions.  Theory decides here, and nowhere else, whether a system is the paper's problem.

    Raises
    ------
    TypeError
        If it is not a System.
    """
    try:
        Dimensionless.of(checked_system(system))
    except NotCoveredError:
        return others
    return paper
