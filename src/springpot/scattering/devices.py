"""Many devices whose uncertain numbers are drawn: their systems, one plan for all, and their paths."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arguments import Uncertain, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, meant, shown
from springpot.machine.progress import counted
from springpot.memory.common_rates import common_rates
from springpot.memory.exponential_sum import ExponentialSum, shared_span
from springpot.problem.free_numbers import uncertain_numbers, with_values
from springpot.problem.system import System
from springpot.problem.uncertain import LEAST_CHANCE
from springpot.scattering.estimates import SCRAMBLINGS
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.lowering.compose import compose, units_of
from springpot.simulation.lowering.memory import sums_of
from springpot.simulation.paths.simulation import Progress, Simulation
from springpot.simulation.paths.together import advance_devices
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan, default_duration, plan_of
from springpot.simulation.plan.settings import Settings

_LOOKED_AT = 64
_UNLIKE = 2.0  # ratio of the rates of two devices from which on one step for all wastes more than it gives


@dataclass(frozen=True, eq=False)
class Draws:
    """Points of Sobol's sequence, scrambled, and the values of the numbers there.

    Attributes
    ----------
    chances : ndarray, shape (draws, numbers)
        The points: independent of each other, and uniform.
    values : ndarray, shape (draws, numbers)
    """

    chances: Floats
    values: Floats


def drawn(numbers: Mapping[str, Uncertain], devices: int, seed: int, together: Correlation | None = None) -> Draws:
    """So many devices: as many of each of the independent scramblings, one scrambling after another."""
    rng = np.random.default_rng([seed, 0x5CA7])
    chances = np.concatenate([scrambled(len(numbers), devices // SCRAMBLINGS, rng) for _ in range(SCRAMBLINGS)])
    return Draws(chances, values_at(numbers, together, chances))


def scrambled(inputs: int, count: int, rng: np.random.Generator) -> Floats:
    """So many points of Sobol's sequence, scrambled; none has a coordinate of 0 or 1."""
    from scipy.stats import qmc

    points = qmc.Sobol(inputs, scramble=True, seed=rng).random(count)
    return np.clip(points + LEAST_CHANCE, LEAST_CHANCE, 1.0 - LEAST_CHANCE)


def values_at(numbers: Mapping[str, Uncertain], together: Correlation | None, chances: Floats) -> Floats:
    """The values of the numbers at points, shape (points, numbers)."""
    lower = chances if together is None else together.of_numbers(chances)
    return np.stack([number.law.ppf(lower[:, n]) for n, number in enumerate(numbers.values())], axis=1)


@dataclass(frozen=True, eq=False)
class Correlation:
    """Which numbers vary together: the correlations of their normal scores, a Gaussian copula.

    Attributes
    ----------
    matrix : ndarray, shape (numbers, numbers)
    """

    matrix: Floats

    @property
    def groups(self) -> list[list[int]]:
        """Numbers that depend on each other, directly or by others, in the order of the first of each group."""
        left, found = [*range(len(self.matrix))], list[list[int]]()
        while left:
            group = [left.pop(0)]
            for one in group:
                group += [each for each in left if self.matrix[one, each] != 0.0 and each not in group]
            found.append(sorted(group))
            left = [each for each in left if each not in group]
        return found

    def inputs(self, names: Iterable[str]) -> tuple[str, ...]:
        """Of numbers of these names: those of one group in one word."""
        known = [*names]
        return tuple(" and ".join(known[n] for n in group) for group in self.groups)

    @property
    def tied(self) -> list[bool]:
        """Of each number whether it depends on others."""
        return [len(next(group for group in self.groups if n in group)) > 1 for n in range(len(self.matrix))]

    def of_numbers(self, chances: Floats) -> Floats:
        """Probabilities of lower values of the numbers, from independent ones; those that are free stay as they are."""
        from scipy.special import ndtr, ndtri

        scores = ndtri(chances) @ np.linalg.cholesky(self.matrix).T
        found = np.clip(ndtr(scores), LEAST_CHANCE, 1.0 - LEAST_CHANCE)
        return np.asarray(np.where(self.tied, found, chances))


def correlated(given: Any, numbers: Mapping[str, Uncertain]) -> Correlation:
    """Checked, from the correlations of pairs, and those that the numbers themselves have.

    Raises
    ------
    TypeError, ValueError
        If a pair or a number is wrong, or there are no such numbers.
    """
    names, matrix = [*numbers], np.eye(len(numbers))
    for place, number in enumerate(numbers.values()):
        for name, value in number.correlation:  # with others that are there
            if name in numbers:
                other = names.index(name)
                if matrix[place, other] != 0.0 and abs(matrix[place, other] - value) > 1e-9:
                    raise ValueError(
                        f"correlation of {number.name} and {name} must be the same in both, not {value:g} and "
                        f"{matrix[place, other]:g}."
                    )
                matrix[place, other] = matrix[other, place] = value
    words = "correlation must be a dict of pairs and numbers, such as {('k', 'C'): 0.5}"
    if not isinstance(given, Mapping):
        raise TypeError(f"{words}, not {shown(given)}.")
    for pair, value in given.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1]:
            raise TypeError(f"{words}, and {shown(pair)} is no pair of two names.")
        for name in pair:
            if name not in names:
                raise ValueError(
                    f"correlation must be of {listed(names)}, not of {shown(name)}{meant(str(name), names)}."
                )
        one, other = map(names.index, pair)
        if matrix[one, other] != 0.0:
            raise ValueError(f"correlation must have the pair {pair[0]} and {pair[1]} once.")
        matrix[one, other] = matrix[other, one] = finite_number(
            value, f"correlation of {pair[0]} and {pair[1]}", low=-1.0, high=1.0
        )
    least = float(np.linalg.eigvalsh(matrix)[0])
    if not least > 1e-9:
        raise ValueError(
            f"correlation must be positive definite, but its least eigenvalue is {least:.3g}: no numbers vary together "
            "in this way."
        )
    return Correlation(matrix)


def systems_of(system: System, names: Sequence[str], values: Floats, progress: Progress | None = None) -> list[System]:
    """The devices; parts without an uncertain number are the same in all of them.

    Raises
    ------
    ValueError
        If a part refuses a value, with the values of that device.
    """
    differ = {name: part for name, part in system.stated() if uncertain_numbers(part)}
    found = []
    for row in counted(values.tolist(), progress):
        own = dict(zip(names, row, strict=True))
        try:
            others = {
                name: with_values(part, {of: own[of] for of in uncertain_numbers(part)})
                for name, part in differ.items()
            }
            found.append(system.but(**others))
        except ValueError as fault:
            told = listed([f"{name} = {value:g}" for name, value in own.items()])
            raise ValueError(f"{fault} So it would be in a device with {told}: give bounds to a law.") from None
    return found


def plan_of_all(
    first: Plan, devices: Sequence[System], given: Mapping[str, Any], progress: Progress | None
) -> tuple[Plan, list[Plan]]:
    """The plan of the nominal device, and those of all with its settings and its start.

    ``first`` is a plan of the nominal device alone, with the settings that are ``given``.

    The step is the shortest that one of 64 devices would have, and the duration the longest of theirs: to find them out
    takes longer than the paths of a device.

    Raises
    ------
    ValueError
        If steps differ too much, or a setting is wrong.
    """
    options = dict(given)
    motions, scheme = [motion_of(each) for each in counted(devices, progress)], first.settings.numerical_scheme
    some = [first.motion, *motions[:: max(len(motions) // _LOOKED_AT, 1)]]
    if "step" not in options:
        check_alike(motions)
        options["step"] = min(motion.default_step(scheme) for motion in some)
    if "duration" not in options:
        step, start = options["step"], first.settings.start
        options["duration"] = max(default_duration(motion, step, start) for motion in some)
    whole = adapt(plan_of(first.system, **options))
    return whole, plans_like(whole, motions)


def check_alike(motions: Sequence[Motion]) -> None:
    """Raise an error if one step does not serve all devices."""
    rates = [motion.resolved_rate for motion in motions]
    if max(rates) > _UNLIKE * min(rates):
        raise ValueError(
            f"step must be given: the fastest rates of the devices are from {min(rates):.3g} to {max(rates):.3g} "
            "per s, and all need the same step."
        )


def plans_like(whole: Plan, motions: Sequence[Motion]) -> list[Plan]:
    """Plans of devices with the settings of the nominal one, and its start."""
    plans = []
    for motion in motions:
        plan, moved = Plan(motion, whole.settings, whole.adapted), motion.rest - whole.motion.rest
        if whole.settings.start == "stationary" and moved.any():  # as far as its place of rest
            at = plan.system.coordinates
            begin = at.places_of(whole.settings.initial_position) + moved
            plan = plan.but(initial_position=at.as_given(motion.within_walls(begin)))
        plans.append(plan)
    return plans


def simulations_of(plans: Sequence[Plan], whole: Plan, progress: Progress | None) -> list[Simulation]:
    """Prepared for the kernel, in the same units, and with common rates where orders differ."""
    memory, units = _memory_of_all(plans, whole.settings), units_of(whole)
    return [Simulation(plan, compose(plan, kernel_units=units, memory=memory)) for plan in counted(plans, progress)]


def _memory_of_all(plans: Sequence[Plan], settings: Settings) -> Callable[[float], ExponentialSum]:
    """Sums by the order: with common rates of the orders of a springpot that differ, otherwise the shortest ones."""
    alone, ranges = sums_of(settings), list[tuple[float, float]]()
    orders = np.array([[springpot.order for springpot in plan.system.springpots.values()] for plan in plans])
    for low, high in sorted(zip(orders.min(axis=0).tolist(), orders.max(axis=0).tolist(), strict=True)):
        if low < high and ranges and low <= ranges[-1][1]:  # springpots whose orders overlap have the same rates
            ranges[-1] = ranges[-1][0], max(high, ranges[-1][1])
        elif low < high:
            ranges.append((low, high))
    sums = [
        (ends, common_rates(settings.numerical_scheme.family, *ends, shared_span(settings.steps + 1),
                            settings.memory_tolerance))
        for ends in ranges
    ]  # fmt: skip
    fixed = {*orders[0, orders.min(axis=0) == orders.max(axis=0)].tolist()}

    def memory(order: float) -> ExponentialSum:
        own = next((each for (low, high), each in sums if low <= order <= high and order not in fixed), alone)
        return own(order)

    return memory


def values_of(
    simulations: Sequence[Simulation], names: Sequence[str], progress: Progress | None
) -> dict[str, Floats]:  # fmt: skip
    """Results of each path, shape (devices, paths), by name."""
    found = dict[str, list[Floats]]()
    for simulation, ensemble in zip(simulations, advance_devices(simulations, progress), strict=True):
        samples = samples_of(simulation, ensemble.rows)
        for name in names:
            found.setdefault(name, []).append(samples[name][1])
    return {name: np.array(each) for name, each in found.items()}


def linear_names(simulation: Simulation) -> list[str]:
    """The results that are means over the paths, in the order of the catalogue; not those of the end of the run."""
    ratios = {reading.name for reading in simulation.parts.readings if isinstance(reading.over, tuple)}
    rows = np.zeros((2, len(simulation.parts.columns)))
    with np.errstate(all="ignore"):
        samples = samples_of(simulation, rows)
    motion = simulation.motion
    return [
        name for name in samples
        if not (name in ratios or "impact_speed" in name or name.endswith("_end") or name == "energy_residual")
        and not motion.uncounted_because(name) and name not in motion.zeros
    ]  # fmt: skip
