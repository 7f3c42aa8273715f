"""With which probability limits hold, and what is said where they cannot."""

from __future__ import annotations

import math

from springpot.designing.results import Promise
from springpot.designing.search import Found
from springpot.designing.statement import Limit
from springpot.machine.faults import listed, per_cent
from springpot.simulation.estimate.few_events import chance_below

__all__ = ["each_probability", "impossible", "promise_of", "tightened"]


def tightened(limit: Limit, distance: float) -> Limit:
    """A limit moved inwards.

    Examples
    --------
    >>> str(tightened(Limit("impact_rate", 0.2, True), 0.01))
    'impact_rate < 0.19'
    """
    return Limit(limit.name, limit.bound - distance if limit.upper else limit.bound + distance, limit.upper)


def promise_of(limit: Limit, value: float, error: float) -> Promise:
    """The promise of a limit whose quantity has this value and error; NaN without an error, as without events.

    Examples
    --------
    >>> round(promise_of(Limit("impact_rate", 0.2, True), 0.19, 0.01).probability, 4)
    0.8413
    """
    from scipy import stats

    if not error > 0.0:
        return Promise(str(limit), value, error, math.nan)
    if value == 0.0:  # of an event that was not seen
        return Promise(str(limit), value, error, chance_below(limit.bound, error) if limit.upper else 0.0)
    distance = limit.bound - value if limit.upper else value - limit.bound
    return Promise(str(limit), value, error, float(stats.norm.cdf(distance / error)))


def each_probability(probability: float, limits: int) -> float:
    """The probability of each limit that makes that of all (Bonferroni's inequality)."""
    return 1.0 - (1.0 - probability) / max(limits, 1)


def impossible(limits: tuple[Limit, ...], found: Found) -> str:
    """Which limit is missed, and by how much, where that is least."""
    missed = max(limits, key=lambda limit: limit.excess(found.quantities.get(limit.name, math.inf)))
    value = found.quantities.get(missed.name, math.nan)
    where = listed([f"{name} = {value:.4g}" for name, value in found.values.items()])
    off = abs(value / missed.bound - 1.0) if missed.bound else math.nan
    share = f" by {per_cent(off, 3)}" if math.isfinite(off) else ""
    wanted = "a limit that can be reached" if len(limits) == 1 else "limits that can hold together"
    nearest = f"the nearest design, at {where}, has {missed.name} = {value:.4g}"
    return f"subject_to must have {wanted}: {nearest}, which misses {missed}{share}."
