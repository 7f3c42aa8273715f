"""`exceedance_over_devices`: probabilities of rare events where the numbers of a system differ from device to device.

The probability over the devices is the mean of their own ones, most of which comes from few devices.  So the numbers of
a path are a part of its state that splitting copies, and they are drawn twice.  Splitting of devices from their laws
tells which devices exceed a level.  Then one in four is drawn from the laws again, and the others from a normal law of
the scores about those that exceeded it; each counts with its probability over that with which it was drawn.

References
----------
F. Cerou and A. Guyader, "Adaptive multilevel splitting for rare event analysis", Stoch. Anal. Appl. 25, 2007; A. Owen
and Y. Zhou, "Safe and effective importance sampling", J. Am. Stat. Assoc. 95, 2000 (mixtures with bounded weights).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np

from springpot.machine.arguments import Uncertain, check_called
from springpot.machine.arrays import Floats
from springpot.machine.bar import Bar
from springpot.machine.faults import shown
from springpot.machine.progress import Clock, OutOfTimeError
from springpot.problem.free_numbers import nominal, uncertain_numbers
from springpot.problem.messages import SpringpotWarning
from springpot.problem.system import System, checked_system
from springpot.scattering.devices import check_alike, correlated, systems_of, values_at
from springpot.scattering.estimates import Interval, jackknifed, one_sided
from springpot.scattering.exceeded import DeviceExceedance, DevicesThatExceed
from springpot.scattering.own_probability import own_probability
from springpot.scattering.scattered import (
    check_numbers,
    check_stops,
    checked_limits,
    doubts_of_laws,
    shares_of_progress,
)
from springpot.scattering.stages import DEVICES, EventOfDevices, Lot, Stage, normal_scores
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.paths.statistics import NORMAL, UPPER
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.options import Options, StartKind
from springpot.simulation.plan.plan import Plan
from springpot.simulation.rare.event import event_of
from springpot.simulation.rare.exceedance import exceeded, long_time, settled, split_early, stated
from springpot.simulation.rare.search import ExceedanceCurve, unknown

_FEW_DEVICES, _LARGEST_SHARE = 50, 0.25
_STREAMS = 64  # of random numbers, for each quantity


def exceedance_over_devices(
    system: System, levels: Mapping[str, Any], *, duration: float, rtol: float = 0.1,
    limits: Mapping[str, float] | None = None, correlation: Mapping[tuple[str, str], float] | None = None,
    start: StartKind | None = None, initial_position: float | None = None, initial_velocity: float | None = None,
    step: float | None = None, memory_tolerance: float = Options.memory_tolerance, seed: int = 1,
    threads: int | None = None, max_time: float | None = None, progress: Progress | None = None,
) -> DevicesThatExceed:  # fmt: skip
    """The probability that a quantity exceeds a level within a time, over devices with uncertain numbers.

    It is the mean of the probabilities of the devices, and seldom near that of the nominal device, which is given
    beside it: few devices have most of it.

    Parameters
    ----------
    system : System
        With numbers that are marked by `springpot.uncertain`.
    levels : dict
        Quantities and their levels, as in `springpot.exceedance`: one or many.  A level may be uncertain too, such as
        the strength of a material; many levels of a quantity are then multiples of one uncertain number.  Forces,
        accelerations and functions of your own cannot be asked yet.
    duration : float
        The time in s.
    rtol : float
        Standard error of the probability at the last level of each quantity, relative to it, in [0.01, 1].
    limits : dict, optional
        Of quantities a probability: the share of the devices whose own probability is above it, at the last level, is
        estimated.
    correlation : dict, optional
        As in `springpot.scatter`.
    start, initial_position, initial_velocity, step, memory_tolerance
        As in `springpot.exceedance`.  If left out, the step is the shortest that one of 64 devices would have.
    seed, threads : optional
        The same seed gives the same bits for any number of threads, but with ``max_time``.
    max_time : float, optional
        Seconds after which it ends with what is known by then.
    progress : callable, optional
        Called with the fraction done, about.  If left out, a call of more than two seconds shows a bar on a terminal.

    Returns
    -------
    DevicesThatExceed
        ``print`` shows it on a screen.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, no number is uncertain, or a device cannot be simulated.
    TimeoutError
        If ``max_time`` is too short for any result.

    Warns
    -----
    SpringpotWarning
        For each sentence of ``warnings``, which ``print`` does not repeat.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(
    ...     sp.Mass(1.0), sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", 0.1, cov=0.2)), sp.WhiteNoise(0.2)
    ... )
    >>> found = sp.exceedance_over_devices(device, {"x": 4.0}, duration=20.0, step=0.1, rtol=0.5)["x"]
    >>> bool(found.probability[0] > found.nominal.probability[0])
    True

    Within an hour; the devices differ, so that it is less than 180 times that of 20 s:

    >>> bool(found.probability[0] < found.within(3600.0).probability < 180.0 * found.probability[0])
    True
    """
    given: dict[str, Any] = {
        "duration": duration, "rtol": rtol, "start": start, "initial_position": initial_position,
        "initial_velocity": initial_velocity, "step": step, "memory_tolerance": memory_tolerance, "seed": seed,
        "threads": threads, "max_time": max_time,
    }  # fmt: skip
    with Bar("splitting paths of devices") if progress is None else nullcontext(progress) as told:
        found = exceeded_by_devices(system, levels, limits=limits, correlation=correlation, progress=told, **given)
    for sentence in found.warnings:
        warnings.warn(sentence, SpringpotWarning, stacklevel=2)
    return found


def exceeded_by_devices(
    system: System, levels: object, *, limits: object = None, correlation: object = None, rtol: float = 0.1,
    max_time: float | None = None, progress: Progress | None = None, **settings: Any,
) -> DevicesThatExceed:  # fmt: skip
    """As `exceedance_over_devices`, but its warnings are only in the result."""
    check_called(progress, "progress")
    plain, marked = _levels(levels)
    numbers = check_numbers(uncertain_numbers((checked_system(system), *marked.values())), "system or levels")
    check_stops(system)
    together, told, clock = correlated(correlation or {}, numbers), shares_of_progress(progress), Clock(max_time)
    middle = nominal(system)
    plan, wanted = stated(middle, plain, rtol=rtol, max_time=max_time, **settings)
    for quantity, _, _ in wanted:
        if quantity.kind in ("force", "own"):
            raise ValueError(
                f"levels of {quantity.name} cannot be asked of devices that differ: ask for x, v or others."
            )
    bounds = checked_limits(
        limits, [quantity.name for quantity, _, _ in wanted], "quantities and probabilities",
        low=0.0, high=1.0, open_low=True, hint="It is a probability.",
    )  # fmt: skip
    plan = _plan_of_all(plan, systems_of(system, [*numbers], _some(numbers, together, plan)), settings.get("step"))
    lot = Lot(system, numbers, together, plan, simulation_of(split_early(plan)))
    settings = {name: value for name, value in settings.items() if value is not None}
    found, said = dict[str, DeviceExceedance](), doubts_of_laws(numbers)
    for n, (quantity, given, sign) in enumerate(wanted):
        share, levels_of_it = 1.0 / len(wanted), given.ravel()[np.argsort(sign * given.ravel())]
        event = EventOfDevices(lot, quantity, levels_of_it, sign, marked.get(quantity.name), n * _STREAMS)
        own_clock = Clock(clock.left / (len(wanted) - n))
        try:
            stage = event.search(rtol, own_clock, told(n * share, 0.8 * share) or (lambda _: None))
        except OutOfTimeError:
            short = "max_time is too short for any result: the first paths have not ended."
            raise TimeoutError(short + long_time(plan.motion, settings["duration"])) from None
        try:
            alone = exceeded(
                middle, {quantity.name: levels_of_it.tolist()}, rtol=max(rtol, 0.1),
                max_time=max(own_clock.left, 1.0) if max_time else None,
                progress=told((n + 0.8) * share, 0.2 * share), **{**settings, "step": lot.plan.settings.step},
            ).curves[quantity.name]  # fmt: skip
        except TimeoutError:  # what is known of the devices is kept
            alone = unknown(event_of(plan, lot.nominal.parts, quantity, levels_of_it, sign))
        found[quantity.name] = curve = _curve(event, stage, alone, bounds.get(quantity.name))
        said += [*_doubts(curve, rtol), *(f"of the nominal device: {each}" for each in alone.warnings)]
    begin, end = lot.plan.settings.window
    return DevicesThatExceed(
        system, lot.plan.settings, tuple(numbers), together.inputs(numbers), found, end - begin, tuple(said)
    )


def _some(numbers: Mapping[str, Uncertain], together: Any, plan: Plan) -> Floats:
    """Values of the numbers of some devices."""
    from scipy.special import ndtr

    return values_at(numbers, together, ndtr(normal_scores(len(numbers), plan.settings.seed, DEVICES)))


def _plan_of_all(plan: Plan, some: Sequence[System], step: float | None) -> Plan:
    """The plan of the nominal device with the step and the time to settle that some devices need."""
    motions = [motion_of(each) for each in some]
    if step is None:
        check_alike(motions)
        scheme = plan.settings.numerical_scheme
        shorter = min(each.default_step(scheme) for each in motions) / plan.motion.default_step(scheme)
        plan = plan.but(step=plan.settings.step * min(shorter, 1.0))
    plan = settled(plan, motions)
    return adapt(plan) if plan.settings.start == "stationary" else plan


def _levels(levels: object) -> tuple[dict[str, Any], dict[str, Uncertain]]:
    """Plain levels, and the uncertain number, at its nominal value, of which those of a quantity are multiples."""
    if not isinstance(levels, Mapping) or not levels:
        raise TypeError(f"levels must be a dict of names and levels, such as {{'x': [0.01]}}, not {shown(levels)}.")
    plain, marked = dict[str, Any](), dict[str, Uncertain]()
    for name, given in levels.items():
        each = [*given] if isinstance(given, list | tuple) else [given]
        own = [level for level in each if isinstance(level, Uncertain)]
        if own:
            tried = np.array(
                [[level.at(share * float(level.itself)) / float(level) for share in (0.9, 1.1)] for level in own]
            )
            if len(own) < len(each) or len({level.name for level in own}) > 1 or np.ptp(tried, axis=0).max() > 1e-9:
                raise ValueError(f"levels of {name} must be plain numbers, or multiples of one uncertain number.")
            marked[name], plain[name] = own[0], [float(level) for level in each]
        else:
            plain[name] = given
    return plain, marked


def _curve(event: EventOfDevices, stage: Stage, alone: ExceedanceCurve, limit: float | None) -> DeviceExceedance:
    """All that is known from the repetitions."""
    lot, count = event.lot, len(stage.found)
    begin, stop = lot.plan.settings.window
    p, error, weights = stage.found.mean(axis=0), stage.error, stage.tally.weights
    wide = np.exp(one_sided(count, 0.975) * error / np.where(p > 0.0, p, 1.0))
    unseen = UPPER / (stage.paths * count)
    all_did = (p == 1.0) & (not stage.splits)
    if stage.splits:
        largest = float(weights.mean() + 2.0 * weights.std(ddof=1) / math.sqrt(count))
        unseen = min(1.0, largest * float(stage.weights.max()))
    ancestors, last = stage.tally.of_ancestors, stage.tally.of_devices[:, -1]
    by_mean, by_scatter = _moments(event, stage)
    return DeviceExceedance(
        name=event.quantity.name, unit=event.quantity.unit, levels=event.levels, probability=p,
        error=np.where(all_did, unseen / NORMAL, error), low=np.where(all_did, math.exp(-unseen), p / wide),
        high=np.where(p > 0.0, np.minimum(p * wide, 1.0), unseen), nominal=alone, splits=stage.splits,
        repetitions=count, paths=stage.paths, path_steps=stage.tally.path_steps, draws=stage.values,
        shares=last / (float(last.sum()) or 1.0), largest=float(ancestors.max()) / (float(ancestors.sum()) or 1.0),
        by_mean=by_mean, by_scatter=by_scatter, limit=limit, downwards=event.quantity.has_sides and event.sign < 0.0,
        of_devices=own_probability(stage, lot, limit), duration=stop - begin,
        stationary=lot.plan.settings.start == "stationary",
    )  # fmt: skip


def _moments(
    event: EventOfDevices, stage: Stage
) -> tuple[dict[str, list[Interval]], dict[str, list[Interval]]]:  # fmt: skip
    """Of the scores of devices that exceed each level, weighted: their means, and their mean squares less 1."""
    found: tuple[dict[str, list[Interval]], dict[str, list[Interval]]] = {}, {}
    added, free = stage.of_repetitions, [not tied for tied in event.lot.together.tied]
    below = added.sum(axis=1)
    for n, name in enumerate(event.lot.numbers):
        scores = stage.scores[:, n].reshape(*added.shape[:2], 1)
        for own, power in zip(found, (1, 2), strict=True):
            above = (added * scores**power).sum(axis=1)
            with np.errstate(invalid="ignore", divide="ignore"):
                values = above.sum(axis=0) / below.sum(axis=0) - (power - 1)
                others = (above.sum(axis=0) - above) / (below.sum(axis=0) - below) - (power - 1)
            if free[n]:
                own[name] = [jackknifed(float(value), each) for value, each in zip(values, others.T, strict=True)]
    return found


def _doubts(curve: DeviceExceedance, rtol: float) -> list[str]:
    name, said, p = curve.name, list[str](), float(curve.probability[-1])
    if not p > 0.0:
        n = int(np.argmin(curve.probability))
        return [f"{name}: no path exceeded {curve.levels[n]:g}; its probability is at most {curve.high[n]:.2g}."]
    if curve.error[-1] > rtol * p:
        reached = 100.0 * curve.error[-1] / p
        said.append(f"{name}: the error of the last probability is {reached:.2g} % of it, not {100.0 * rtol:g} %.")
    if curve.splits and curve.devices_seen < _FEW_DEVICES:
        said.append(f"{name}: only {curve.devices_seen} devices exceeded the last level: use a smaller rtol.")
    if curve.largest > _LARGEST_SHARE:
        said.append(
            f"{name}: {100.0 * curve.largest:.0f} % of the last probability comes from one path at the start, so that "
            "its error may be larger than stated."
        )
    return said
