"""Quantities by theory: the moments of one method, by the names that a run has."""

from __future__ import annotations

import math
from collections.abc import Sequence

from springpot.evidence.recommendation import recommended
from springpot.machine.faults import meant, shown
from springpot.problem.catalogue import unit_of_result
from springpot.problem.oscillator import Oscillator, as_system
from springpot.problem.system import System
from springpot.theory import solve_all, solve_one
from springpot.theory.registry import METHODS

__all__ = ["MONTE_CARLO", "checked_names", "chosen_method", "theory_values", "unit_of"]

MONTE_CARLO = "monte_carlo"


def theory_values(problem: Oscillator | System, method: str) -> tuple[dict[str, float], str]:
    """Every moment of one method that is a number, by name; and why there is none.

    Examples
    --------
    >>> theory_values(Oscillator(), "envelope")[0]["impact_rate"] > 0.1
    True
    """
    result, statement = solve_one(problem, method)
    if result is None:
        return {}, statement
    return {name: float(value) for name, value in result.numbers.items() if not math.isnan(value)}, ""


def chosen_method(problem: Oscillator | System, method: str | None) -> tuple[str, str]:
    """The method to use, and one sentence if it is not a recommended one.

    Parameters
    ----------
    problem : Oscillator or System
    method : str or None
        ``"theory"``: the recommended method, or the best guess.  ``"monte_carlo"``, or the name of a method, is used as
        it is.  None: the recommended method, or Monte Carlo.

    Raises
    ------
    ValueError
        If there is no such method, or no theory has an answer.

    Examples
    --------
    >>> chosen_method(Oscillator(), "envelope")
    ('envelope', '')
    """
    known = [*METHODS, "theory", MONTE_CARLO]
    if method is not None and method not in known:
        raise ValueError(
            f"method must be one of {', '.join(known)}, not {shown(method)}{meant(str(method), known) or '.'}"
        )
    if method not in (None, "theory"):
        return str(method), ""
    answers, statements = solve_all(problem)
    best = recommended(problem, answers)
    if best.method:
        return best.method, ""
    if method is None:
        return MONTE_CARLO, ""
    if not answers:
        reason = next(iter(statements.values()), "")
        raise ValueError(f"method 'theory' has no answer for this problem: {reason}")
    guess = best.guess or next(iter(answers))
    return guess, f"{guess} is a guess: {best.why_none}"


def checked_names(quantities: Sequence[str] | str, name: str) -> tuple[str, ...]:
    """Names of quantities as a tuple without repetitions.

    Raises
    ------
    TypeError, ValueError
        If they are not names, or there are none.
    """
    given = (quantities,) if isinstance(quantities, str) else quantities
    if not isinstance(given, Sequence) or not all(isinstance(each, str) for each in given):
        raise TypeError(f"{name} must be names of quantities, such as 'impact_rate', not {shown(quantities)}.")
    if not given:
        raise ValueError(f"{name} must name at least one quantity, such as 'impact_rate'.")
    return tuple(dict.fromkeys(given))


def unit_of(problem: Oscillator | System, name: str) -> str:
    """The unit of a quantity.

    Examples
    --------
    >>> unit_of(Oscillator(), "impact_rate")
    's-1'
    """
    return unit_of_result(as_system(problem), name)
