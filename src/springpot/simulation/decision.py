"""The next move of a run with ``rtol``, as a pure function of the estimates so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

__all__ = ["NORMAL", "Known", "Move", "Standing", "decide"]

NORMAL = 1.959964  # half-width of a 95 % interval, in standard errors
SURE = 3.0  # standard errors beyond which a difference between steps is bias
ROOM = 1.5  # least ratio of the aim to the part of the error that neither paths nor a shorter step reduce
LEAST_GROWTH, MOST_GROWTH = 1.2, 4.0  # of the number of paths in one round
UNSEEN = 1e9  # path-steps after which a run ends if a quantity still has no value


@dataclass(frozen=True)
class Known:
    """One quantity after a round.  All but ``name`` and ``bias_weight`` are in its unit, or its square.

    Attributes
    ----------
    name : str
    value : float
    total : float
        Half-width of its total interval.
    variance, difference_variance : float
        Of the samples: of paths at the coarse step, and of the differences of pairs.
    difference, difference_error : float
        Absolute value of the mean difference of the two steps, and its standard error.
    bias_weight : float
        Bound on the remaining bias over that difference.
    other_bias : float
        Bound on the bias that depends on the step but is not visible in the difference.
    fixed : float
        Bounds that neither more paths nor a shorter step reduce: memory and start.
    """

    name: str
    value: float
    total: float
    variance: float
    difference_variance: float
    difference: float
    difference_error: float
    bias_weight: float
    other_bias: float
    fixed: float

    @property
    def off(self) -> float:
        """Relative total error; infinite without a value, such as the impact rate before the first impact."""
        size = abs(self.value)
        return self.total / size if size > 0.0 and math.isfinite(self.total) else math.inf


@dataclass(frozen=True)
class Standing:
    """State of a run after a round.

    Attributes
    ----------
    rtol : float
    known : sequence of Known
        The quantities that must be known to ``rtol``.
    paths, pairs : int
    steps : int
        Of one path at the coarse step.
    spent : float
        Path-steps so far.
    most_path_steps : float
    step_can_be_halved : bool
    """

    rtol: float
    known: Sequence[Known]
    paths: int
    pairs: int
    steps: int
    spent: float
    most_path_steps: float
    step_can_be_halved: bool


@dataclass(frozen=True)
class Move:
    """What to do next.

    Attributes
    ----------
    kind : {"done", "halve", "more", "stop"}
        "halve": start again with half the step.  "more": go on to ``paths`` and ``pairs``.
        "stop": ``most_path_steps`` leaves no room for more, or a quantity has no value after UNSEEN path-steps.
    worst : str
        The quantity that decided it.
    aim : float
        Relative error that is aimed at: rtol, or the best that can be reached if that is larger.
    paths, pairs : int
    path_steps : float
        Estimate of what is still to do.
    """

    kind: Literal["done", "halve", "more", "stop"]
    worst: str
    aim: float
    paths: int
    pairs: int
    path_steps: float


def decide(standing: Standing) -> Move:
    """The next move.

    Examples
    --------
    >>> known = Known("x_mean", 1.0, 0.012, 1.0, 0.2, 1e-3, 1e-3, 1.0, 0.0, 1e-4)
    >>> decide(Standing(0.02, [known], 2048, 1024, 300, 1e6, 1e9, True)).kind
    'done'
    >>> decide(Standing(0.005, [known], 2048, 1024, 300, 1e6, 1e9, True)).kind
    'more'
    """
    for known in standing.known:
        if math.isinf(known.off):
            return _look_for(known, standing)
    aims = {known.name: _aim(known, standing) for known in standing.known}
    worst = max(standing.known, key=lambda known: known.total / aims[known.name])
    aim = aims[worst.name] / abs(worst.value)
    paths, pairs = standing.paths, standing.pairs
    if worst.total <= aims[worst.name]:
        return Move("done", worst.name, aim, paths, pairs, 0.0)
    needed = [_needed(known, aims[known.name]) for known in standing.known]
    wanted = (
        max(LEAST_GROWTH * paths, *(each for each, _ in needed)),
        max(LEAST_GROWTH * pairs, *(each for _, each in needed)),
    )
    surely = [worst.other_bias]
    if worst.difference > SURE * worst.difference_error:
        surely.append(worst.bias_weight * worst.difference)
    if standing.step_can_be_halved and sum(surely) > 0.5 * aims[worst.name]:
        return Move("halve", worst.name, aim, paths, pairs, 2.0 * standing.steps * (wanted[0] + 3.0 * wanted[1]))
    left = standing.steps * ((wanted[0] - paths) + 3.0 * (wanted[1] - pairs))
    growth = [min(goal / now, MOST_GROWTH) for goal, now in zip(wanted, (paths, pairs), strict=True)]
    cost = standing.steps * ((growth[0] - 1.0) * paths + 3.0 * (growth[1] - 1.0) * pairs)
    room = standing.most_path_steps - standing.spent
    share = min(1.0, room / cost)
    if share * (max(growth) - 1.0) < 0.05:
        return Move("stop", worst.name, aim, paths, pairs, left)
    paths, pairs = (math.ceil(now * (1.0 + share * (g - 1.0))) for now, g in zip((paths, pairs), growth, strict=True))
    return Move("more", worst.name, aim, paths, pairs, left)


def _look_for(known: Known, standing: Standing) -> Move:
    """More paths for a quantity that has no value yet."""
    cost = (MOST_GROWTH - 1.0) * standing.steps * (standing.paths + 3.0 * standing.pairs)
    if standing.spent + cost > min(standing.most_path_steps, UNSEEN):
        return Move("stop", known.name, standing.rtol, standing.paths, standing.pairs, cost)
    paths, pairs = (math.ceil(MOST_GROWTH * number) for number in (standing.paths, standing.pairs))
    return Move("more", known.name, standing.rtol, paths, pairs, cost)


def _aim(known: Known, standing: Standing) -> float:
    """Total error aimed at, in the quantity's unit."""
    least = known.fixed
    if not standing.step_can_be_halved:
        sure = max(known.difference - 2.0 * known.difference_error, 0.0)
        least += known.other_bias + known.bias_weight * sure
    return max(standing.rtol * abs(known.value), ROOM * least)


def _needed(known: Known, aim: float) -> tuple[float, float]:
    """Paths of the coarse level and pairs that are needed: the cheapest split for the allowed standard error."""
    free = aim - known.fixed
    # certain bias is subtracted, but at most 70 % of the allowed error
    sure = known.other_bias + known.bias_weight * max(known.difference - 2.0 * known.difference_error, 0.0)
    free = max(0.3 * free, free - sure)
    goal = free / (NORMAL + 1.6 * known.bias_weight)
    spread = math.sqrt(known.variance) + math.sqrt(3.0 * known.difference_variance)
    return (
        spread * math.sqrt(known.variance) / goal**2 + 1.0,
        spread * math.sqrt(known.difference_variance / 3.0) / goal**2 + 1.0,
    )
