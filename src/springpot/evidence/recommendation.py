"""Which method to use for a system: one order of preference, for the command, the page, comparisons and designs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from springpot.evidence.reliability import FAR, place_of, read_map, trust, warnings_of
from springpot.machine.faults import NotCoveredError, shown
from springpot.problem.system import System, checked_system
from springpot.theory.registry import METHODS
from springpot.theory.result import Result, names_of_moments, no_answer
from springpot.theory.solve import solve_all

NONE_COVERS = "no analytical method covers this"
_PREFERRED = (
    "path_integration",
    "half_cycles",
    "memory_closure",
    "envelope",
    "linearization",
    "averaging",
    "averaging_amplitude",
)
"""Approximate methods by how likely they are to be accurate away from the maps."""
_LIGHT_ONLY = ("averaging", "averaging_amplitude")  # beyond the largest c of the map <A^2> is off by 50 % and more


@dataclass(frozen=True, eq=False)
class Recommendation:
    """The method to use for a system.

    Attributes
    ----------
    method : str
        Name of the recommended method; empty if the errors of all are unknown.
    guess : str
        The same, or the one most likely to be accurate; empty if there is none.
    why_none : str
        Why no method is recommended, in one sentence; empty if one is.
    answers : dict
        Results by the name of the method, as from `springpot.theory.solve_all`.
    """

    method: str
    guess: str
    why_none: str
    answers: Mapping[str, Any] = field(repr=False)

    @property
    def result(self) -> Result:
        """The result of the recommended method or best guess, with all its warnings.

        Raises
        ------
        NotCoveredError
            If there is none.
        """
        if not self.guess:
            raise NotCoveredError(self.why_none)
        found: Result = self.answers[self.guess]
        doubts = (*(doubt for doubt in warnings_of(found) if doubt != FAR), self.why_none)  # which says that it is far
        return replace(found, warnings=tuple(filter(None, doubts)))

    def __str__(self) -> str:
        return self.method or self.why_none


def recommended(system: System, answers: Mapping[str, Any] | None = None) -> Recommendation:
    """The most reliable method for a system, among those that have a result.

    Exact methods first; then the method with the smallest of the largest gaps on the map.  If the map has no cell near,
    or its Monte Carlo is too uncertain, the errors are unknown and none is recommended; the best guess is then path
    integration, or the half cycles, the memory closure, the envelope, statistical linearization, averaging.

    Parameters
    ----------
    system : System
    answers : dict, optional
        Name of a method to its result, as from `springpot.theory.solve_all`, which is asked if it is left out.

    Returns
    -------
    Recommendation

    Raises
    ------
    TypeError
        If ``answers`` is no dict.

    Examples
    --------
    >>> import springpot as sp
    >>> found = recommended(sp.Oscillator(springpot=sp.Springpot(1.0, 0.5)))
    >>> found.method, round(found.result.x_mean, 4)
    ('exact', 0.7979)
    """
    system = checked_system(system)
    answers = solve_all(system)[0] if answers is None else answers
    if not isinstance(answers, Mapping):
        raise TypeError(f"answers must be a dict of results by their methods, not {shown(answers)}.")
    if exact := [name for name, method in METHODS.items() if method.exact and name in answers]:
        return Recommendation(exact[-1], exact[-1], "", answers)  # the list ends with the most exact
    atlas, here, _ = place_of(system)
    judged = {name: trust(system, name) for name in atlas.methods if name in answers}
    if known := [name for name, trusted in judged.items() if trusted.judges]:
        best = min(known, key=lambda name: judged[name].worst)
        return Recommendation(best, best, "", answers)
    if not answers:
        return Recommendation("", "", f"no method is recommended here: {NONE_COVERS}.", answers)
    is_strong = here is not None and here["c"] > float(read_map(atlas.file)["c"].max())
    guesses = (name for name in _PREFERRED if name in answers and not (is_strong and name in _LIGHT_ONLY))
    guess = next(guesses, "")
    why = "the validity map has no cell near this system"
    if any(trust(system, name).mapped for name in atlas.methods):
        why = "the Monte Carlo of the validity map is too uncertain to judge them"
    hint = f"The best guess is {guess}: compare" if guess else "Compare"
    sentence = f"no method is recommended here, because {why}. {hint} with Monte Carlo before you use a number."
    return Recommendation("", guess, sentence, answers)


def all_methods(system: System) -> dict[str, object]:
    """Every method's answer to one system, ready for JSON.

    Parameters
    ----------
    system : System

    Returns
    -------
    dict
        Name of the method to its dictionary (see `springpot.theory.Result.to_dict`), with the warnings of the validity
        map.  A method without an answer has None for every moment and a ``statement`` that says why.  ``recommended``
        is the name of the method to trust here, or None; ``why_none_is_recommended`` is then a sentence, otherwise
        None.

    Examples
    --------
    >>> import springpot as sp
    >>> answers = all_methods(sp.Oscillator())
    >>> round(answers["averaging"]["amplitude_mean_square"], 3), answers["exact"]["amplitude_mean_square"]
    (2.296, None)
    """
    answers, statements = solve_all(system)
    best = recommended(system, answers)
    dicts: dict[str, object] = {
        name: {**answers[name].to_dict(), "warnings": list(warnings_of(answers[name]))}
        if name in answers
        else no_answer(statements[name], names_of_moments(system))
        for name in METHODS
    }
    return {**dicts, "recommended": best.method or None, "why_none_is_recommended": best.why_none or None}
