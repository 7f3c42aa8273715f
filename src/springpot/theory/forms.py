"""A method with two forms: one of the paper's problem, in its dimensionless numbers, and one of all other systems."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system

__all__ = ["Form", "Forms"]

Answer = TypeVar("Answer", covariant=True)


@dataclass(frozen=True)
class Form(Generic[Answer]):
    """One form: ``check`` raises `NotCoveredError` without solving, ``solve`` gives the result."""

    check: Callable[[System], object]
    solve: Callable[[System], Answer]


@dataclass(frozen=True)
class Forms(Generic[Answer]):
    """The two forms of a method.  Theory decides here, and nowhere else, whether a system is the paper's problem."""

    paper: Form[Answer]
    others: Form[Answer]

    def check(self, system: System) -> None:
        """Raise `NotCoveredError` for what the form of this system does not cover."""
        self._of(system).check(system)

    def solve(self, system: System) -> Answer:
        """The result, by the form of this system.

        Raises
        ------
        TypeError
            If it is not a System.
        """
        return self._of(checked_system(system)).solve(system)

    def _of(self, system: System) -> Form[Answer]:
        try:
            Dimensionless.of(system)
        except NotCoveredError:
            return self.others
        return self.paper
