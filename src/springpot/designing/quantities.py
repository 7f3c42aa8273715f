"""Quantities by theory: the moments of one method, by the names that a run has."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import TypeVar

from springpot.evidence.recommendation import recommended
from springpot.machine.faults import known_word
from springpot.problem.felt import squares_felt
from springpot.problem.system import System
from springpot.theory import NotCoveredError, solve_all, solve_one
from springpot.theory.methods.systems.linear import LinearResponse
from springpot.theory.registry import METHODS

Answer = TypeVar("Answer")

MONTE_CARLO = "monte_carlo"


def theory_values(system: System, method: str, felt: Collection[str] = ()) -> tuple[dict[str, float], str]:
    """Every moment of one method that is a number, by name; and why there is none.

    ``felt``: the names among `squares_felt` that are wanted too.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Dashpot, Spring, WhiteNoise
    >>> system = System(Spring(1.0), Dashpot(0.5), Barrier(0.0), WhiteNoise(1.0))
    >>> theory_values(system, "envelope")[0]["impact_rate"] > 0.1
    True
    """
    result, statement = solve_one(system, method)
    if result is None:
        return {}, statement
    found = {name: float(value) for name, value in result.numbers.items() if not math.isnan(value)}
    if isinstance(result, LinearResponse):
        try:
            found |= {name: result.mean_square(of) for name, of in squares_felt(system).items() if name in felt}
        except NotCoveredError as refusal:
            return {}, str(refusal)
    return found, ""


def if_allowed(ask: Callable[[], Answer]) -> Answer | None:
    """What a function gives; None where a part refuses its number, or a method does not cover a system.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> if_allowed(lambda: Spring(2.0)), if_allowed(lambda: Spring(float("nan")))
    (Spring(stiffness=2.0), None)
    """
    try:
        return ask()
    except (ValueError, TypeError):
        return None


def chosen_method(system: System, method: str | None) -> tuple[str, str]:
    """The method to use, and one sentence if it is not a recommended one.

    Parameters
    ----------
    system : System
    method : str or None
        ``"theory"``: the recommended method, or the best guess.  ``"monte_carlo"``, or the name of a method, is used as
        it is.  None: the recommended method, or Monte Carlo.

    Raises
    ------
    ValueError
        If there is no such method, or no theory has an answer.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> chosen_method(System(Spring(1.0)), "envelope")
    ('envelope', '')
    """
    known = [*METHODS, "theory", MONTE_CARLO]
    if method is not None:
        known_word(method, known, "method")
    if method not in (None, "theory"):
        return str(method), ""
    answers, statements = solve_all(system)
    best = recommended(system, answers)
    if best.method:
        return best.method, ""
    if method is None:
        return MONTE_CARLO, ""
    if not answers:
        reason = next(iter(statements.values()), "")
        raise ValueError(f"method 'theory' has no answer for this problem: {reason}")
    guess = best.guess or next(iter(answers))
    return guess, f"{guess} is a guess: {best.why_none}"
