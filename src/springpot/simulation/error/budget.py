"""Values, standard errors and error budgets of all quantities, from the levels of a run with ``rtol``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.catalogue import is_controlled
from springpot.simulation.error.decision import Known, bias_range
from springpot.simulation.error.levels import Levels
from springpot.simulation.estimate.few_events import errors_of_unseen
from springpot.simulation.estimate.samples import errors_of_the_start, watched
from springpot.simulation.paths.statistics import NORMAL, controlled, standard_error, without_doubtful
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import shares_missing
from springpot.simulation.plan.scales import beat
from springpot.simulation.plan.struck import slow_impact_order

BALANCE = "energy_residual"
WITH_MEMORY = 0.737  # least order of the step's bias with a wall and an order of the springpot below 1
HIGHEST_ORDER = 2.0
RESTORED = 0.03  # bound on the relative error of the number of slow impacts that is added
UNCERTAIN_ORDER = 0.4  # the rate with slow impacts added has at least this much higher order than the plain rate
LEAST_ORDER = 0.02  # a law of restitution can be below 0.163 at the speeds that a step resolves
SINGLE_PRECISION = 1e-4  # twice the largest relative effect of single-precision memory observed


@dataclass(frozen=True)
class Budget:
    """The parts of the error of one estimate, in its unit.

    Attributes
    ----------
    standard_error : float
        Of the value, from the spread between independent paths.
    step_bias, memory_bias, transient : float
        Bounds on the biases due to the step, the approximation of the memory and the start.
    """

    standard_error: float
    step_bias: float
    memory_bias: float
    transient: float

    @property
    def total(self) -> float:
        """Half-width of the total interval: 95 % of the sampling error plus the three bounds."""
        return NORMAL * self.standard_error + self.step_bias + self.memory_bias + self.transient


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimates from all levels.

    Attributes
    ----------
    values, errors : dict
        Every estimate, with control variates, and its standard error.  To those that have a budget the middle of the
        range of the step's bias is added.
    budgets : dict
        A `Budget` for each controlled quantity.
    known : dict
        Input of `springpot.simulation.error.decision`, for each controlled quantity.
    """

    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    known: dict[str, Known]


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples of one estimate, after the controls: of the paths, and of the differences of pairs, fine less coarse.

    Attributes
    ----------
    many, difference : ndarray
    paired : bool
        Whether ``many`` are the finer members of the pairs.
    of_many, of_pairs : int
        Numbers of control variates of the two; both have those of the pairs if ``paired``.
    """

    many: Floats
    difference: Floats
    paired: bool
    of_many: int
    of_pairs: int

    def value(self, share: float) -> float:
        """The mean, with this share of the mean difference."""
        return float(self.many.mean() + share * self.difference.mean())

    def error(self, share: float) -> float:
        """Its standard error."""
        if self.paired:
            return standard_error(self.many + share * self.difference, self.of_pairs)
        return math.hypot(standard_error(self.many, self.of_many), share * self.difference_error)

    @property
    def difference_error(self) -> float:
        """Standard error of the mean difference."""
        return standard_error(self.difference, self.of_pairs)


def combine(levels: Levels) -> Estimates:
    """Values, standard errors and budgets of all quantities."""
    simulation, samples = levels.best.simulation, _samples(levels)
    motion, settings = simulation.motion, simulation.settings
    memory = 3.0 * settings.memory_tolerance + (SINGLE_PRECISION if settings.precision == "float32" else 0.0)
    energy, (begin, end) = 0.0, settings.window  # relative effect of its transient on the average over the window
    if not motion.is_thermal:
        relaxation = motion.scales.settling_time
        energy = float(beat(motion.system) * relaxation / (end - begin) * math.exp(-begin / relaxation))
        if (waiting := motion.waiting_time(settings.start)) > 0.0:
            energy += waiting / (end - begin) * math.exp(-begin / waiting)
    plain = {before: samples.pop(f"{before}plain_rate", None) for before in motion.completed}
    values = {name: sample.value(0.0) for name, sample in samples.items()}
    errors = {name: sample.error(0.0) for name, sample in samples.items()}
    shares = {}
    for name in filter(is_controlled, [*samples]):
        orders = orders_of_step(motion, name, settings.step)
        middle, half = bias_range(orders, levels.finer)
        values[name], errors[name] = samples[name].value(middle), samples[name].error(middle)
        shares[name] = orders, half
    errors |= errors_of_unseen(values, watched(simulation, levels.best.rows))
    restored = {}
    for before, counted in plain.items():
        rate = values.get(f"{before}impact_rate", math.nan)
        restored[before] = 1.0 - counted.value(0.0) / rate if counted is not None and rate > 0.0 else 0.0
    slow = shares_missing(motion, settings.window[0], values)
    start = errors_of_the_start(simulation.plan, values)
    budgets, known = {}, {}
    for name, (orders, half) in shares.items():
        sample = samples[name]
        size, its_error = abs(float(sample.difference.mean())), sample.difference_error
        whose = next((before for before in restored if name.startswith(before)), None)
        other = RESTORED * abs(restored[whose] * values[name]) if whose is not None and "impact" in name else 0.0
        budgets[name] = Budget(
            standard_error=errors[name],
            step_bias=half * (size + its_error) + other,
            memory_bias=memory * abs(values[name]),
            transient=(energy + slow[name]) * abs(values[name]) + NORMAL * start[name],
        )
        known[name] = Known(
            name=name,
            value=values[name],
            total=budgets[name].total,
            variance=float(sample.many.var()),
            difference_variance=float(sample.difference.var()),
            difference=size,
            difference_error=its_error,
            orders=orders,
            other_bias=other,
            other_order=0.0 if whose is None else slow_impact_order(motion.completed[whose].restitution),
            fixed=budgets[name].memory_bias + budgets[name].transient,
        )
    return Estimates(values, errors, budgets, known)


def _samples(levels: Levels) -> dict[str, _Samples]:
    """The samples of every estimate, after regression on the control variates; the balance itself has none."""
    coarse, fine = (level.samples() for level in (levels.pair_coarse, levels.pair_fine))
    of_pairs = np.concatenate([levels.pair_coarse.controls(coarse), levels.pair_fine.controls(fine)], axis=1)
    paired = levels.best is levels.pair_fine
    many = fine if paired else levels.many.samples()
    of_pairs = without_doubtful(of_pairs)
    of_many = of_pairs if paired else without_doubtful(levels.many.controls(many))
    each = of_many.shape[1], of_pairs.shape[1]
    samples = {
        name: _Samples(controlled(many[name], of_many), controlled(fine[name] - coarse[name], of_pairs), paired, *each)
        for name in many
        if name != BALANCE
    }
    if BALANCE in many:
        samples[BALANCE] = _Samples(many[BALANCE], fine[BALANCE] - coarse[BALANCE], paired, 0, 0)
    return samples


def orders_of_step(motion: Motion, name: str, step: float) -> tuple[float, float]:
    """Between which the order of a quantity's bias in the step lies.

    The scheme has order 2, but order 1 behind a wall at alpha = 1, and less has been seen behind a wall with memory.
    If slow impacts have been added, the least order is that of the next term: about 0.5 more than that of the plain
    rate.  Where they are not added, it is that of the impact rate of the lossiest wall; a law of restitution counts
    with its value at the slowest impacts that the step resolves, or at slower ones.
    """
    lossy = motion.slowest_restitutions(name, step) if "impact" in name else []
    if lossy:
        alone = motion.struck.crowded and len(motion.walls) == 1
        added = alone or any(name.startswith(f"{before}impact") for before in motion.completed)
        order = max(slow_impact_order(min(lossy)) + (UNCERTAIN_ORDER if added else 0.0), LEAST_ORDER)
        return min(1.0, order), HIGHEST_ORDER
    remembered = bool(motion.touched) and (motion.remembers or motion.scales.guessed)
    return WITH_MEMORY if remembered else 1.0, HIGHEST_ORDER
