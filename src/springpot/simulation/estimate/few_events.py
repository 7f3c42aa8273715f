"""Events that were seen rarely or not at all: nothing seen is not 0 +- 0.

Where none is seen in a time T, of all paths together, the rate is below 3 / T with a probability of 95 % ("rule of
three": exp(-3) = 0.05).  Where a few are seen the interval is Poisson's.  Impacts of one path may come in bursts, so
the number that follows Poisson's law is that of the paths with impacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.messages import Message, say
from springpot.simulation.paths.statistics import NORMAL, UPPER, error_of_unseen, poisson_interval

FEW = 10  # events, from which on a standard error says enough


@dataclass(frozen=True, eq=False)
class Watched:
    """What was seen of impacts, and for how long.

    Attributes
    ----------
    impacts : dict
        Those of each path: on each wall and contact by its name, on all of them under an empty one; empty without them.
    time : float
        Of all windows together, in s.
    """

    impacts: Mapping[str, Floats]
    time: float


def chance_below(bound: float, error: float) -> float:
    """The probability that the rate of events that were not seen is below a bound, from its error.

    Examples
    --------
    >>> round(chance_below(0.0015, error_of_unseen(2000.0)), 3)
    0.95
    """
    return -math.expm1(-max(bound, 0.0) * UPPER / (NORMAL * error))


def errors_of_unseen(values: Mapping[str, float], watched: Watched) -> dict[str, float]:
    """The errors of results that are 0 because an event was not seen: of a rate a bound, of all else NaN.

    Parameters
    ----------
    values : dict
        Results by name.
    watched : Watched

    Examples
    --------
    >>> watched = Watched({"": np.zeros(4), "barrier": np.zeros(4)}, 3.0)
    >>> errors_of_unseen({"impact_rate": 0.0, "barrier_power": 0.0}, watched)
    {'impact_rate': 0.5102..., 'barrier_power': nan}
    """
    found = {}
    for name, impacts in watched.impacts.items():
        if impacts.any():
            continue
        before = f"{name}_" if name else ""
        if values.get(f"{before}impact_rate") == 0.0:
            found[f"{before}impact_rate"] = error_of_unseen(watched.time)
        of_walls = [f"{before}power", f"{before}force_mean"] if name else ["contact_share", "contact_penetration"]
        found |= {quantity: math.nan for quantity in of_walls if values.get(quantity) == 0.0}
    return found


def interval(impacts: Floats, time: float) -> tuple[float, float]:
    """The 95 % interval of a rate of which fewer than `FEW` events were seen, from the events of each path.

    Examples
    --------
    >>> low, high = interval(np.array([1.0, 0.0, 1.0, 1.0]), 3.0)
    >>> round(low, 3), round(high, 3)
    (0.206, 2.922)
    """
    paths, seen = int(np.count_nonzero(impacts)), float(impacts.sum())
    low, high = poisson_interval(paths)
    of_a_path = seen / paths / time if paths else 1.0 / time
    return of_a_path * low, of_a_path * high


def about_few(watched: Watched, walls: Iterable[str]) -> Iterator[Message]:
    """One sentence for each of these walls of which fewer than `FEW` impacts were seen."""
    for name in walls:
        seen = int(watched.impacts[name].sum())
        if seen >= FEW:
            continue
        low, high = interval(watched.impacts[name], watched.time)
        rate, within = f"{name}_impact_rate", f"{watched.time:.3g} s"
        if not seen:
            yield say("unseen_impacts", rate=rate, high=high, time=within)
        else:
            count = f"{seen} impact{'s' if seen > 1 else ''}"
            yield say("few_impacts", rate=rate, low=low, high=high, seen=count, time=within)
