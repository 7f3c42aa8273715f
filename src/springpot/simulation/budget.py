"""Values, standard errors and error budgets of all quantities, from the levels of a run with ``rtol``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from springpot.oscillator import Oscillator
from springpot.parts import Barrier, Contact, ThermalNoise, WhiteNoise
from springpot.parts.walls import restitution_of_missed, slow_restitution
from springpot.simulation.completed_rate import are_crowded
from springpot.simulation.compose import Floats
from springpot.simulation.decision import NORMAL, Known
from springpot.simulation.forgetting import SLOW, shares_missing, system_shares_missing
from springpot.simulation.levels import Levels, forgetting_time_of
from springpot.simulation.simulation import Simulation
from springpot.simulation.slow_impacts import slow_impact_order
from springpot.simulation.statistics import controlled, standard_error
from springpot.system import System
from springpot.system_quantities import UNCONTROLLED
from springpot.theory.result import MOMENTS

__all__ = ["CONTROLLED", "Budget", "Estimates", "combine", "controlled_names"]

CONTROLLED = MOMENTS
"""Quantities that have a budget."""

WITH_MEMORY = 1.5  # bound on the fine step's bias over the difference, with a wall and an order below 1
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
        Every estimate, extrapolated to half the coarse step, with the energy balance as its control, and its standard
        error.
    budgets : dict
        A `Budget` for each of CONTROLLED.
    known : dict
        Input of `springpot.simulation.decision`, for each of CONTROLLED.
    """

    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    known: dict[str, Known]


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples of one estimate: of the paths of the coarse level, and of the differences fine less coarse."""

    many: Floats
    difference: Floats


def combine(levels: Levels) -> Estimates:
    """Values, standard errors and budgets of all quantities."""
    simulation, samples = levels.coarse.simulation, _samples(levels)
    problem, settings = simulation.problem, simulation.settings
    values, errors, budgets, known = {}, {}, {}, {}
    memory = 3.0 * settings.memory_tolerance + (SINGLE_PRECISION if settings.precision == "float32" else 0.0)
    energy = _energy_transient(simulation)
    for name, sample in samples.items():
        values[name] = float(sample.many.mean() + sample.difference.mean())
        errors[name] = math.hypot(standard_error(sample.many), standard_error(sample.difference))
    plain = values.pop("plain_rate", math.nan)
    errors.pop("plain_rate", None)
    restored = 1.0 - plain / values["impact_rate"] if math.isfinite(plain) and values["impact_rate"] > 0.0 else 0.0
    slow = _slow_shares(problem, settings.window[0], values)
    start = simulation.errors_of_the_start(values)
    for name in controlled_names(problem, values):
        many, difference = samples[name].many, samples[name].difference
        size, its_error = abs(float(difference.mean())), standard_error(difference)
        weight = _bias_weight(problem, name, settings.step)
        other = RESTORED * abs(restored * values[name]) if "impact" in name else 0.0
        budgets[name] = Budget(
            standard_error=errors[name],
            step_bias=weight * size + max(weight, 1.0) * its_error + other,
            memory_bias=memory * abs(values[name]),
            transient=(energy + slow[name]) * abs(values[name]) + NORMAL * start[name],
        )
        known[name] = Known(
            name=name,
            value=values[name],
            total=budgets[name].total,
            variance=float(many.var()),
            difference_variance=float(difference.var()),
            difference=size,
            difference_error=its_error,
            bias_weight=weight,
            other_bias=other,
            fixed=budgets[name].memory_bias + budgets[name].transient,
        )
    return Estimates(values, errors, budgets, known)


def _samples(levels: Levels) -> dict[str, _Samples]:
    """The samples of every estimate, with the energy balance as control variate."""
    many, coarse, fine = (level.samples() for level in (levels.coarse, levels.pair_coarse, levels.pair_fine))
    control = "energy_residual"
    if control not in many:
        return {name: _Samples(many[name], fine[name] - coarse[name]) for name in many}
    controls = np.stack([coarse[control], fine[control]], axis=1)
    samples = {
        name: _Samples(controlled(many[name], many[control][:, None]), controlled(fine[name] - coarse[name], controls))
        for name in many
    }
    return samples | {control: _Samples(many[control], fine[control] - coarse[control])}


def controlled_names(problem: Oscillator | System, names: Iterable[str]) -> tuple[str, ...]:
    """The quantities that have a budget: of a system every mean that is not that of a force or at the end.

    Examples
    --------
    >>> controlled_names(Oscillator(), ())[:2]
    ('amplitude_mean_square', 'x_mean')
    """
    if isinstance(problem, Oscillator):
        return CONTROLLED
    return tuple(name for name in names if not name.endswith(UNCONTROLLED))


def _slow_shares(problem: Oscillator | System, time: float, values: dict[str, float]) -> Mapping[str, float]:
    """Relative effect on each quantity of the slow displacements that are missing when the window begins."""
    if isinstance(problem, Oscillator):
        return shares_missing(problem, time, values["x_mean_square"], values["amplitude_mean_square"])
    share = system_shares_missing(problem, time, values["x_mean_square"])
    fast = {name for name in values if name == "v_mean_square" or name.endswith("_power")}
    return {name: 0.0 if name in fast else SLOW.get(name, 1.0 if name.startswith("x_") else 0.5) * share
            for name in values}  # fmt: skip


def _bias_weight(problem: Oscillator | System, name: str, step: float) -> float:
    """Bound on the bias of the fine step over the difference of the two steps: 1 / (2^order - 1).

    The order is 1 at alpha = 1 and without a wall.  With a wall and memory the observed bias is somewhat larger.  If
    slow impacts have been added, the order is that of the next term: about 0.5 more than that of the plain rate.
    """
    if isinstance(problem, System):
        return _system_bias_weight(problem, name, step)
    oscillator = problem
    if name.startswith("impact") and are_crowded(oscillator):
        order = min(1.0, slow_impact_order(oscillator.restitution) + UNCERTAIN_ORDER)
        return float(1.0 / (2.0**order - 1.0))
    if oscillator.barrier is not None and oscillator.springpot.order < 1.0:
        return WITH_MEMORY
    return 1.0


def _system_bias_weight(system: System, name: str, step: float) -> float:
    """As for an oscillator; where slow impacts are not added, the order is that of the lossiest wall's impact rate.

    A law of restitution counts with its value at the slowest impacts that the step resolves, or at slower ones.
    """
    walls = system.of(Barrier)
    intensity = sum(noise.intensity for noise in system.per_unit_mass.of(WhiteNoise))
    lossy = [
        min(slow_restitution(wall), restitution_of_missed(wall, intensity, step))
        for wall in walls
        if not wall.is_elastic
    ]
    if lossy and "impact" in name:
        added = are_crowded(system) and (name.startswith("impact") or len(walls) == 1)
        order = max(slow_impact_order(min(lossy)) + (UNCERTAIN_ORDER if added else 0.0), LEAST_ORDER)
        return float(1.0 / (2.0 ** min(1.0, order) - 1.0))
    return WITH_MEMORY if system.of(Barrier, Contact) else 1.0


def _energy_transient(simulation: Simulation) -> float:
    """Relative effect of the energy's transient on the average over the window."""
    relaxation, (begin, end) = simulation.scales.energy_time, simulation.settings.window
    if isinstance(simulation.problem, System):
        if simulation.problem.of(ThermalNoise):
            return 0.0
        relaxation = max(relaxation, forgetting_time_of(simulation.problem))
    return float(relaxation / (end - begin) * math.exp(-begin / relaxation))
