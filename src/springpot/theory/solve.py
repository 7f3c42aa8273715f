"""Solve an oscillator or system by all methods, or by one of them given by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, overload

from springpot.machine.faults import shown
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System
from springpot.theory.methods.systems.result import SystemResult
from springpot.theory.problem import checked
from springpot.theory.registry import METHODS, SYSTEM_METHODS, Method
from springpot.theory.reliability import recommended, why_none_is_recommended
from springpot.theory.result import NoConvergenceError, NotCoveredError, Result, no_answer

__all__ = ["all_methods", "methods_for", "solve_all", "solve_one", "trusted"]


@overload
def solve_all(oscillator: Oscillator) -> tuple[dict[str, Result], dict[str, str]]: ...
@overload
def solve_all(oscillator: System) -> tuple[dict[str, Result | SystemResult], dict[str, str]]: ...
def solve_all(oscillator: Oscillator | System) -> tuple[Mapping[str, Result | SystemResult], dict[str, str]]:
    """The results of all methods for one oscillator or system.

    Parameters
    ----------
    oscillator : Oscillator or System

    Returns
    -------
    answers : dict
        Name of the method to its result, for those that have stationary moments.
    statements : dict
        Name of the method to the sentence that says why it has none: it does not cover the oscillator, there is no
        stationary state, or its iteration did not converge.

    Raises
    ------
    TypeError
        If it is not an Oscillator.

    Examples
    --------
    >>> from springpot.problem.oscillator import Springpot
    >>> answers, statements = solve_all(Oscillator(springpot=Springpot(order=1.0, coefficient=1.0)))
    >>> sorted({round(answer.amplitude_mean_square, 3) for answer in answers.values()}), list(statements)
    ([1.0], [])
    """
    if not isinstance(oscillator, System):
        checked(oscillator)
    answers: dict[str, Result | SystemResult] = {}
    statements: dict[str, str] = {}
    for name in methods_for(oscillator):
        result, statement = solve_one(oscillator, name)
        if result is None:
            statements[name] = statement
        else:
            answers[name] = result
    return answers, statements


@overload
def solve_one(oscillator: Oscillator, method: str) -> tuple[Result | None, str]: ...
@overload
def solve_one(oscillator: System, method: str) -> tuple[Result | SystemResult | None, str]: ...
def solve_one(oscillator: Oscillator | System, method: str) -> tuple[Result | SystemResult | None, str]:
    """The result of one method for one oscillator or system.

    Parameters
    ----------
    oscillator : Oscillator or System
    method : str
        A key of `springpot.theory.registry.METHODS`, such as ``"envelope"``; of a system, or of ``SYSTEM_METHODS``.

    Returns
    -------
    result : Result or None
    statement : str
        Why there is no result, as in `solve_all`; empty if there is one.

    Raises
    ------
    ValueError
        If there is no such method.

    Examples
    --------
    >>> result, statement = solve_one(Oscillator(), "envelope")
    >>> round(result.x_mean, 2), statement
    (0.78, '')
    """
    methods = methods_for(oscillator)
    if not isinstance(method, str) or method not in methods:
        raise ValueError(f"method must be one of {', '.join(methods)}, not {shown(method)}.")
    try:
        result = methods[method].solve(oscillator)
    except (NotCoveredError, NoConvergenceError) as refusal:
        return None, str(refusal)
    if isinstance(result.stationary, str):
        return None, result.stationary
    return result, ""


def methods_for(oscillator: Oscillator | System) -> Mapping[str, Method]:
    """The methods that may cover a problem, by name; those for an Oscillator cover a system that is one.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> list(methods_for(System(Spring(1.0))))[-3:]
    ['path_integration', 'linear', 'exact']
    """
    if not isinstance(oscillator, System):
        return METHODS
    return {name: method for name, method in METHODS.items() if name not in SYSTEM_METHODS} | dict(SYSTEM_METHODS)


def all_methods(oscillator: Oscillator | System) -> dict[str, object]:
    """Every method's answer to one oscillator or system, ready for JSON.

    Parameters
    ----------
    oscillator : Oscillator or System

    Returns
    -------
    dict
        Name of the method to its dictionary (see `Result.to_dict`).  A method without an answer has None for every
        moment and a ``statement`` that says why; ``exact`` is None altogether where it has no answer.
        ``recommended`` is the name of the method to trust here, or None; ``why_none_is_recommended`` is then a
        sentence, otherwise None.

    Examples
    --------
    >>> answers = all_methods(Oscillator())
    >>> round(answers["averaging"]["amplitude_mean_square"], 3), answers["exact"]
    (2.296, None)
    """
    answers, statements = solve_all(oscillator)
    dicts: dict[str, object] = {}
    for name in methods_for(oscillator):
        if name in answers:
            dicts[name] = answers[name].to_dict()
        else:
            dicts[name] = None if name == "exact" else no_answer(statements[name])
    best, why_none = trusted(oscillator, answers)
    return {**dicts, "recommended": best or None, "why_none_is_recommended": why_none or None}


def trusted(problem: Oscillator | System, answers: Mapping[str, Any]) -> tuple[str, str]:
    """The recommended method, or why none is; one of the two is empty.

    Parameters
    ----------
    problem : Oscillator or System
    answers : dict
        Of `solve_all`.

    Examples
    --------
    >>> trusted(Oscillator(), {})[0]
    ''
    """
    return recommended(problem, answers), why_none_is_recommended(problem, answers)
