"""Quantities by theory: the moments of one method, by the names that a run has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict

from springpot.machine.faults import meant, shown
from springpot.problem.catalogue import unit_of_result
from springpot.problem.oscillator import Oscillator, as_system
from springpot.problem.system import System
from springpot.theory import Result, best_guess, solve_all, solve_one
from springpot.theory.methods.systems.result import SystemResult, walls_of
from springpot.theory.solve import methods_for, trusted

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
    return ({}, statement) if result is None else (_moments(result), "")


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
    known = [*methods_for(problem), "theory", MONTE_CARLO]
    if method is not None and method not in known:
        raise ValueError(
            f"method must be one of {', '.join(known)}, not {shown(method)}{meant(str(method), known) or '.'}"
        )
    if method not in (None, "theory"):
        return str(method), ""
    answers, statements = solve_all(problem)
    best, why = trusted(problem, answers)
    if best:
        return best, ""
    if method is None:
        return MONTE_CARLO, ""
    if not answers:
        reason = next(iter(statements.values()), "")
        raise ValueError(f"method 'theory' has no answer for this problem: {reason}")
    canonical = {name: answer for name, answer in answers.items() if isinstance(answer, Result)}
    guess = best_guess(problem, canonical) if isinstance(problem, Oscillator) else ""
    guess = guess or ("envelope" if "envelope" in answers else next(iter(answers)))
    return guess, f"{guess} is a guess: {why}"


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


def _moments(result: Result | SystemResult) -> dict[str, float]:
    found: dict[str, float] = {}
    for name, value in asdict(result.moments).items():
        if isinstance(value, tuple) and isinstance(result, SystemResult):
            walls = [result.system.name_of(wall) for wall in walls_of(result.system)]
            found |= {
                f"{wall}_{name.removeprefix('barrier_')}": number for wall, number in zip(walls, value, strict=False)
            }
        else:
            found[name] = value
    return {name: float(value) for name, value in found.items() if not math.isnan(value)}
