"""Other places from which a search for simulated statistics may begin: the promising ones between the bounds."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np

from springpot.designing.quantities import chosen_method, if_allowed, theory_values
from springpot.fitting.simulated_moments import Case
from springpot.fitting.simulated_runs import SimulatedRuns, misfit_of
from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import with_values

_DRAWN = 24
_TRIED = 6  # by a run
_LONGEST = 8.0  # steps of its runs, over those where the search has been


def other_starts(runs: SimulatedRuns, best: Floats) -> list[Floats]:
    """Places drawn between the bounds, the best first.

    Theory says which are worth a run, where it has an answer; so do short runs then.  Places whose runs would take much
    longer than those where the search has been are left out.

    Parameters
    ----------
    runs : SimulatedRuns
    best : ndarray
        Where the search has ended.

    Returns
    -------
    list of ndarray
    """
    from scipy.stats import qmc

    own = runs.own
    most = _LONGEST * runs.steps(best)
    drawn = qmc.LatinHypercube(own.start.size, rng=np.random.default_rng(runs.seed)).random(_DRAWN)
    places = [own.low + place * (own.high - own.low) for place in drawn]
    places = [u for u in places if runs.steps(u) <= most]
    methods = [_method(case, own.named_at(best)) for case in runs.cases]
    by_theory = []
    for u in places:
        runs.reporter.check()
        by_theory.append(_misfit_by_theory(runs.cases, methods, own.named_at(u)))
    likely = [places[n] for n in np.argsort(by_theory, kind="stable")[:_TRIED]]
    fits = [runs.misfit(u) for u in likely]
    return [likely[n] for n in np.argsort(fits) if math.isfinite(fits[n])]


def _method(case: Case, named: Mapping[str, float]) -> str:
    """The quickest method of theory that has an answer for a model; none is the empty string."""
    system = with_values(case.system, named)
    if _asked(case, theory_values(system, "envelope")[0])[0].size:
        return "envelope"
    return if_allowed(lambda: chosen_method(system, "theory")[0]) or ""


def _misfit_by_theory(cases: Sequence[Case], methods: Sequence[str], named: Mapping[str, float]) -> float:
    """As `springpot.fitting.simulated_runs.misfit_of`, of what theory knows; infinite where it knows nothing."""
    total, known = 0.0, 0
    for case, method in zip(cases, methods, strict=True):
        system = with_values(case.system, named)
        by_theory = if_allowed(lambda: theory_values(system, method)[0]) if method else {}  # noqa: B023
        values, kept = _asked(case, by_theory or {})
        total += misfit_of(values, case.data.values[kept], case.data.errors[kept])
        known += values.size
    return total / known if known else math.inf


def _asked(case: Case, known: Mapping[str, float]) -> tuple[Floats, Floats]:
    """What theory has of the measured statistics: values, and their places among these."""
    found = [(place, value) for place, name in enumerate(case.data.names)
             if math.isfinite(value := _statistic(name, known))]  # fmt: skip
    return np.array([value for _, value in found]), np.array([place for place, _ in found], np.intp)


def _statistic(name: str, known: Mapping[str, float]) -> float:
    """A statistic from moments; NaN if it does not follow from them.

    Examples
    --------
    >>> _statistic("x_rms", {"x_mean_square": 4.0}), _statistic("x_standard_deviation", {"x_mean_square": 4.0})
    (2.0, nan)
    """
    if name == "x_standard_deviation":
        return math.sqrt(max(known.get("x_mean_square", math.nan) - known.get("x_mean", math.nan) ** 2, 0.0))
    if name.endswith("_rms") and name not in known:
        return math.sqrt(known.get(re.sub("_rms$", "_mean_square", name), math.nan))
    return known.get(name, math.nan)
