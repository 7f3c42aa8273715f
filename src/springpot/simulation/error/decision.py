"""The next move of a run with ``rtol``, as a pure function of the estimates so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from springpot.simulation.paths.statistics import NORMAL

SURE = 3.0  # standard errors beyond which a difference between steps is bias
ROOM = 1.5  # least ratio of the aim to the part of the error that neither paths nor a shorter step reduce
MARGIN = 0.93  # of the aim, for which paths are planned: the difference of the steps changes from round to round
UNKNOWN = 1.6  # standard errors of that difference that its bias may have, on average
LEAST_GROWTH, MOST_GROWTH = 1.2, 4.0  # of the numbers of paths and pairs in one round
FEWEST_PATHS = 128
MOST_FINER = 3  # halvings from the finer step of the pairs to that of the paths
STEPS_PER_IMPACT = 25.0  # an impact takes as long as so many steps: 18 to 40, of one mass and of two
UNSEEN = 1e9  # path-steps after which a run ends if a quantity still has no value


@dataclass(frozen=True)
class Known:
    """One quantity after a round.  All but the name and the orders are in its unit, or its square.

    Attributes
    ----------
    name : str
    value : float
    total : float
        Half-width of its total interval.
    variance, difference_variance : float
        Of the samples: of paths, and of the differences of pairs.
    difference, difference_error : float
        Absolute value of the mean difference of the two steps of the pairs, and its standard error.
    orders : tuple of float
        Between which the order of the bias in the step lies.
    other_bias, other_order : float
        Bound on the bias that depends on the step but is not visible in the difference, and its order.
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
    orders: tuple[float, float]
    other_bias: float
    other_order: float
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
        Without paths the finer members of the pairs stand for them.
    finer : int
        Halvings from the finer step of the pairs to that of the paths.
    steps : int
        Of the coarser path of a pair.
    impacts : float
        Of one path.
    spent : float
        Path-steps so far.
    most_path_steps : float
    most_finer : int
    step_can_be_halved : bool
        Whether the pairs may have half the step.
    """

    rtol: float
    known: Sequence[Known]
    paths: int
    pairs: int
    finer: int
    steps: int
    impacts: float
    spent: float
    most_path_steps: float
    most_finer: int
    step_can_be_halved: bool

    def path_cost(self, finer: int) -> float:
        """Of a path, in steps."""
        return 2.0 ** (finer + 1) * self.steps + STEPS_PER_IMPACT * self.impacts

    @property
    def pair_cost(self) -> float:
        """Of a pair of paths, in steps."""
        return self.path_cost(-1) + self.path_cost(0)

    def path_steps(self, finer: int, paths: float, pairs: float) -> float:
        """Of so many paths and pairs."""
        return self.steps * (2.0 ** (finer + 1) * paths + 3.0 * pairs)

    def unchanged(self, kind: Literal["done", "halve", "stop"], worst: str, aim: float, left: float) -> Move:
        """A move without more paths or pairs at these steps."""
        return Move(kind, worst, aim, self.paths, self.pairs, self.finer, left)


@dataclass(frozen=True)
class Move:
    """What to do next.

    Attributes
    ----------
    kind : {"done", "halve", "more", "stop"}
        "halve": start again with half the step.  "more": go on to ``paths`` and ``pairs``, with paths that are
        ``finer``; these begin anew if that is not what they were.  "stop": ``most_path_steps`` leaves no room for more,
        or a quantity has no value after UNSEEN path-steps.
    worst : str
        The quantity that decided it.
    aim : float
        Relative error that is aimed at: rtol, or the best that can be reached if that is larger.
    paths, pairs, finer : int
    path_steps : float
        Estimate of what is still to do.
    """

    kind: Literal["done", "halve", "more", "stop"]
    worst: str
    aim: float
    paths: int
    pairs: int
    finer: int
    path_steps: float


@dataclass(frozen=True)
class _Plan:
    """Paths of one step, and pairs, that would be enough."""

    finer: int
    paths: float
    pairs: float
    cost: float
    sure: float  # largest share of the aim that is bias for certain


def bias_range(orders: tuple[float, float], finer: int) -> tuple[float, float]:
    """Middle and half-width of the range of the bias of the paths, over the difference of the pairs.

    With steps 2 h and h a bias a h^p leaves the difference (2^p - 1) a h^p; at h / 2^n it is a h^p / 2^(n p).

    Examples
    --------
    >>> [tuple(round(each, 3) for each in bias_range((1.0, 2.0), finer)) for finer in (0, 2)]
    [(0.667, 0.333), (0.135, 0.115)]
    """
    slow, fast = (2.0 ** (-finer * order) / (2.0**order - 1.0) for order in orders)
    return 0.5 * (slow + fast), 0.5 * (slow - fast)


def decide(standing: Standing) -> Move:
    """The next move.

    Examples
    --------
    >>> known = Known("x_mean", 1.0, 0.012, 1.0, 0.2, 1e-3, 1e-3, (1.0, 2.0), 0.0, 1.0, 1e-4)
    >>> decide(Standing(0.02, [known], 0, 1024, 0, 300, 0.0, 1e6, 1e9, 3, True)).kind
    'done'
    >>> decide(Standing(0.005, [known], 0, 1024, 0, 300, 0.0, 1e6, 1e9, 3, True)).kind
    'more'
    """
    rtol, aims = standing.rtol, dict[str, float]()  # total errors aimed at, in the quantities' units
    for known in standing.known:
        if math.isinf(known.off):  # more pairs for a quantity that has no value yet
            more = math.ceil(MOST_GROWTH * standing.pairs)
            cost = standing.path_steps(0, 0.0, more - standing.pairs)
            if standing.spent + cost > min(standing.most_path_steps, UNSEEN):
                return standing.unchanged("stop", known.name, rtol, cost)
            return Move("more", known.name, rtol, standing.paths, more, standing.finer, cost)
        least = known.fixed
        if not standing.step_can_be_halved:
            least += _sure(known, standing, standing.most_finer)
        aims[known.name] = max(rtol * abs(known.value), ROOM * least)
    worst = max(standing.known, key=lambda known: known.total / aims[known.name])
    aim = aims[worst.name] / abs(worst.value)
    if worst.total <= aims[worst.name]:
        return standing.unchanged("done", worst.name, aim, 0.0)
    plans = [_plan(standing, aims, finer) for finer in range(standing.most_finer + 1)]
    sound = [plan for plan in plans if plan.sure <= 0.5]
    plan = min(sound or plans[-1:], key=lambda plan: plan.cost)
    if not sound and standing.step_can_be_halved:
        left = 2.0 * standing.path_steps(plan.finer, plan.paths, plan.pairs)
        return standing.unchanged("halve", worst.name, aim, left)
    kept = standing.paths if plan.finer == standing.finer else 0
    paths, pairs = plan.paths, plan.pairs  # of the next round
    left = standing.path_steps(plan.finer, max(paths - kept, 0.0), pairs - standing.pairs)
    if pairs > MOST_GROWTH * standing.pairs:  # the plan rests on a difference that is hardly known
        kept, paths, pairs, finer = standing.paths, standing.paths, MOST_GROWTH * standing.pairs, standing.finer
    else:
        paths, finer = min(paths, MOST_GROWTH * max(kept, standing.pairs)), plan.finer
        if kept and paths < LEAST_GROWTH * kept and pairs < LEAST_GROWTH * standing.pairs:
            paths, pairs = LEAST_GROWTH * kept, LEAST_GROWTH * standing.pairs
    cost = standing.path_steps(finer, paths - kept, pairs - standing.pairs)
    share = min(1.0, (standing.most_path_steps - standing.spent) / cost)
    if share < 0.05:
        return standing.unchanged("stop", worst.name, aim, left)
    return Move(
        "more", worst.name, aim,
        math.ceil(kept + share * (paths - kept)), math.ceil(standing.pairs + share * (pairs - standing.pairs)),
        finer, max(left, cost),
    )  # fmt: skip


def _sure(known: Known, standing: Standing, finer: int) -> float:
    """The bound on the bias of paths with this step that no number of paths and pairs takes away."""
    _, half = bias_range(known.orders, finer)
    other = _other(known, standing, finer)
    return half * max(known.difference - SURE * known.difference_error, 0.0) + other


def _other(known: Known, standing: Standing, finer: int) -> float:
    """The other bias at this step."""
    return known.other_bias * math.pow(2.0, (standing.finer - finer) * known.other_order)


def _plan(standing: Standing, aims: dict[str, float], finer: int) -> _Plan:
    """The cheapest numbers of paths and pairs with this step."""
    paths, pairs, sure = float(FEWEST_PATHS), float(standing.pairs), 0.0
    for known in standing.known:
        aim = aims[known.name]
        more_paths, more_pairs = _needed(known, standing, MARGIN * aim, finer)
        paths, pairs = max(paths, more_paths), max(pairs, more_pairs)
        sure = max(sure, _sure(known, standing, finer) / aim)
    kept = standing.paths if finer == standing.finer else 0
    cost = standing.path_cost(finer) * max(paths - kept, 0.0) + standing.pair_cost * (pairs - standing.pairs)
    return _Plan(finer, max(paths, kept), pairs, cost, sure)


def _needed(known: Known, standing: Standing, aim: float, finer: int) -> tuple[float, float]:
    """Paths and pairs that one quantity needs: the cheapest split of the error that is left to chance."""
    middle, half = bias_range(known.orders, finer)
    bias = math.sqrt(max(known.difference**2 - known.difference_error**2, 0.0))
    other = _other(known, standing, finer)
    free = aim - known.fixed
    free = max(0.3 * free, free - half * bias - other)
    path, pair = math.sqrt(known.variance), math.sqrt(known.difference_variance)
    spreads = NORMAL * path, (UNKNOWN * half + NORMAL * middle) * pair
    costs = standing.path_cost(finer), standing.pair_cost
    # a / sqrt(n) + b / sqrt(m) costs least if the two are as a^(2/3) and b^(2/3) times cost^(1/3)
    parts = [spread ** (2.0 / 3.0) * cost ** (1.0 / 3.0) for spread, cost in zip(spreads, costs, strict=True)]
    whole = sum(parts)
    paths, pairs = (
        (spread * whole / (part * free)) ** 2 if part > 0.0 else 0.0
        for spread, part in zip(spreads, parts, strict=True)
    )
    if not (paths > 0.0 and pairs > 0.0):
        return paths, pairs
    # errors add up in squares, those of the bound on the bias do not
    chance = NORMAL * math.hypot(path / math.sqrt(paths), middle * pair / math.sqrt(pairs))
    fewer = ((chance + UNKNOWN * half * pair / math.sqrt(pairs)) / free) ** 2
    return fewer * paths, fewer * pairs
