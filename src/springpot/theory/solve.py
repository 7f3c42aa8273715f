"""Solve a system by all methods, or by one of them given by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from springpot.machine.faults import NotCoveredError, known_word
from springpot.problem.system import System, checked_system
from springpot.theory.registry import METHODS
from springpot.theory.result import NoConvergenceError, Result

_MOST_NAMES = 6  # before a sentence


def solve_all(system: System) -> tuple[dict[str, Result], dict[str, str]]:
    """The results of all methods for one system.

    Parameters
    ----------
    system : System

    Returns
    -------
    answers : dict
        Name of the method to its result, for those that have stationary moments.
    statements : dict
        Name of the method to the sentence that says why it has none: it does not cover the system, there is no
        stationary state, or its iteration did not converge.

    Raises
    ------
    TypeError
        If it is not a System.

    Examples
    --------
    >>> import springpot as sp
    >>> answers, statements = solve_all(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)))
    >>> sorted({round(answer.amplitude_mean_square, 3) for answer in answers.values()}), len(answers), len(statements)
    ([1.0], 7, 4)
    """
    solved = {name: solve_one(system, name) for name in METHODS}
    answers = {name: result for name, (result, _) in solved.items() if result is not None}
    return answers, {name: statement for name, (result, statement) in solved.items() if result is None}


def grouped(statements: Mapping[str, str]) -> Iterator[str]:
    """The sentences of `solve_all`, each once, after the names of its methods; of many the first ones.

    Examples
    --------
    >>> [*grouped({"linear": "Not a wall.", "exact": "Not friction.", "envelope": "Not a wall."})]
    ['linear, envelope: Not a wall.', 'exact: Not friction.']
    """
    for statement in dict.fromkeys(statements.values()):
        names = [name for name, own in statements.items() if own == statement]
        shown = names if len(names) <= _MOST_NAMES else [*names[:2], f"{len(names) - 2} others"]
        yield f"{', '.join(shown)}: {statement}"


def solve_one(system: System, method: str) -> tuple[Result | None, str]:
    """The result of one method for one system.

    Parameters
    ----------
    system : System
    method : str
        A key of `springpot.theory.registry.METHODS`, such as ``"envelope"``.

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
    >>> import springpot as sp
    >>> result, statement = solve_one(sp.Oscillator(), "envelope")
    >>> round(result.x_mean, 2), statement
    (0.78, '')
    """
    known_word(method, METHODS, "method")
    system = checked_system(system)
    if statement := METHODS[method].covers(system):
        return None, statement
    try:
        result = METHODS[method].solve(system)
    except (NotCoveredError, NoConvergenceError) as refusal:
        return None, str(refusal)
    if isinstance(result.stationary, str):
        return None, result.stationary
    return result, ""
