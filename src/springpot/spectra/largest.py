"""The largest values of each path by the compiled kernel, with what the step leaves in them."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.machine.faults import NotCoveredError, few, per_cent, shown
from springpot.problem.catalogue import unit_of_result
from springpot.problem.outputs import about_shocks
from springpot.problem.system import System
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import Plan, plan_of
from springpot.simulation.rare.exceedance import settled
from springpot.simulation.watch.extremes import Extremes
from springpot.spectra.recursion import Kind

Found = TypeVar("Found")

WORDS = {"displacement": "x", "velocity": "v"}
"""Of one mass: the names of its results by the words of the field."""

_COARSE = 4.0  # of the default step under records, at which halving begins
_MOST_HALVINGS = 7
_FEW_HALVINGS, _FAR = 3, 0.02  # under noise, until largest values are so close in the mean
_COARSEST = 0.5  # step times the fastest rate
_MOST_POINTS = 20_000_000  # of all records at the steps
_ENDS = "_minimum", "_maximum", "_largest"


_SAID = 0.02  # share of the values that depend on the step


@dataclass(frozen=True, eq=False)
class Largest:
    """Of each path, by output.

    Attributes
    ----------
    values, errors : dict of ndarray
        The largest sizes, and how far they were off at twice the step; NaN under noise with an envelope.
    unconverged : float
        Share of the paths whose largest values differ by more than ``rtol`` between the last two steps.
    warnings : tuple of str
    """

    values: dict[str, Floats]
    errors: dict[str, Floats]
    unconverged: float
    warnings: tuple[str, ...]

    @classmethod
    def of_all(cls, found: Sequence[Largest], rtol: float, what: str, why: str = "") -> Largest:
        """Those of several systems, in rows; ``what`` and ``why`` are words about those that the step changes."""
        values, errors = (
            {word: np.stack([own[word] for own in all_of]) for word in all_of[0]}
            for all_of in ([each.values for each in found], [each.errors for each in found])
        )
        warnings = [*dict.fromkeys(sentence for each in found for sentence in each.warnings)]
        if (apart := float(np.mean([each.unconverged for each in found]))) > _SAID:
            share, least = per_cent(apart), per_cent(rtol)
            warnings.append(f"{share} of the {what} change by more than {least} where the step is halved{why}.")
        return cls(values, errors, apart, tuple(warnings))


def name_in_results(word: str) -> str:
    """The name of an output in the results of a run."""
    return WORDS.get(word, word)


def unit_of_output(system: System, word: str) -> str:
    """Its unit in a system.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Mass(2.0), sp.Spring(8.0), stop=sp.Barrier(-0.1))
    >>> [unit_of_output(device, word) for word in ("displacement", "spring_force", "stop_impulse", "impact_speed")]
    ['m', 'N', 'N s', 'm s-1']
    """
    name = name_in_results(word)
    units = (unit_of_result(system, own) for own in (name, f"{name}_maximum", f"{name}_mean"))
    return next(filter(None, units), "")


def check_outputs(motion: Motion, words: Sequence[str], argument: str) -> None:
    """Raise an error if there is no such output."""
    moving = _moving(motion)
    for word in words:
        name = name_in_results(word)
        if name in moving:
            continue
        try:
            motion.signal_by_name(name, argument, forces_only=True)
        except NotCoveredError:
            raise
        except ValueError:
            known = [own for own, name in WORDS.items() if name in moving]
            known += [own for own in moving if own not in WORDS.values()]
            raise ValueError(
                f"{argument} must be of {few([*known, *motion.signals_by_force])}, not {shown(word)}."
            ) from None


def _moving(motion: Motion) -> list[str]:
    return [own for signal in motion.signals for key, own in signal.names.items() if key != "amplitude"]


def largest_values(
    system: System, words: Sequence[str], *, kind: Kind = "maximax", tail: float = 0.0, duration: float | None = None,
    paths: int | None = None, rtol: float = 0.005, step: float | None = None, seed: int = 1, threads: int | None = None,
    argument: str = "output",
) -> Largest:  # fmt: skip
    """The largest sizes of outputs over the time that counts, of each path.

    Under records and noise that ends the time is that of the record and ``tail`` after it, from rest; under noise that
    does not, ``duration`` in the stationary state.  Under records the step is halved for those that have not
    agreed to ``rtol`` twice; under noise until twice the step gives, on the same noise, nearly the same in the mean.
    """
    options: dict[str, Any] = {"seed": seed, "threads": threads, **({"paths": paths} if paths else {})}
    motion = motion_of(system)
    check_outputs(motion, words, argument)
    length = motion.recorded
    if length:
        end = length + tail if duration is None else duration
        options |= {"start": "rest", "duration": end}
    else:
        options |= {"duration": duration}
    names = [name_in_results(word) for word in words]

    def planned(own: System, given: float | None) -> Plan:
        plan = plan_of(own, **options, **({} if given is None else {"step": given}))
        if not length:
            return settled(plan)
        low, high = {"maximax": (0.0, math.inf), "primary": (0.0, length), "residual": (length, math.inf)}[kind]
        window = (
            round(min(end, plan.settings.duration) / plan.settings.step) * plan.settings.step for end in (low, high)
        )
        return plan.but(window=(*window,))

    plan = planned(system, step)
    if plan.settings.start == "stationary":
        plan = adapt(plan)
    coarsest = _COARSEST / motion.scales.fastest_rate
    if motion.is_random and length:  # the noise of an envelope is another one at another step
        if not step:  # of many paths one need not know each to the default step under records
            plan = planned(system, min(_COARSE * plan.settings.step, coarsest))
        fine = _run(plan, names)
        found = fine, {name: np.full(fine[name].size, math.nan) for name in names}, 0.0
    elif motion.is_random:
        found = _by_pairs(plan, names, 0 if step else _FEW_HALVINGS)
    elif step:
        found = _by_halving(system, names, planned, [min(2.0 * step, coarsest), step], rtol)
    else:
        steps = [plan.settings.step * _COARSE * 2.0 ** (1 - n) for n in range(_MOST_HALVINGS + 1)]
        found = _by_halving(system, names, planned, steps, rtol)
    values, errors, unconverged = found
    struck = {"impact_rate": 1.0 if values[_STRUCK].any() else 0.0}
    return Largest(
        {word: values[name] for word, name in zip(words, names, strict=True)},
        {word: errors[name] for word, name in zip(words, names, strict=True)},
        unconverged, tuple(map(str, about_shocks(system, names, struck))),
    )  # fmt: skip


def _by_pairs(plan: Plan, names: Sequence[str], most: int) -> tuple[dict[str, Floats], dict[str, Floats], float]:
    """As `_by_halving`, of noise: until the paths are, in the mean, as with twice the step on the same noise."""
    for halving in range(most + 1):
        coarse, fine = _run(_with_step(plan, 2.0), names, halved=True), _run(plan, names)
        errors = {name: np.abs(fine[name] - coarse[name]) for name in names}
        if halving == most or all(errors[name].mean() <= _FAR * fine[name].mean() for name in names):
            break
        plan = _with_step(plan, 0.5)
    return fine, errors, 0.0


def _by_halving(
    system: System, names: Sequence[str], planned: Callable[[System, float], Plan], steps: Sequence[float], rtol: float
) -> tuple[dict[str, Floats], dict[str, Floats], float]:
    """Values and errors of each record, the last step, and the share of the records that did not agree.

    A record is left alone when it has agreed twice from step to step, since once may be by chance; of two steps once.
    """
    coarse = _run(planned(system, steps[0]), names)
    values, count = {name: own.copy() for name, own in coarse.items()}, coarse[names[0]].size
    errors, members = {name: np.full(count, math.inf) for name in names}, np.arange(count)
    doubtful = np.full(count, len(steps) > 2)
    for step in steps[1:]:
        finer = planned(_of_records(system, members, count), step)
        if finer.settings.steps * members.size > _MOST_POINTS:
            doubtful[:] = True
            break
        fine = _run(finer, names)
        apart = _apart(coarse, fine, rtol)
        left = apart | doubtful
        for name in names:
            own, before = np.abs(fine[name] - coarse[name]), errors[name][members]
            errors[name][members] = np.where(left | ~np.isfinite(before), own, np.fmax(own, before))
        for name, found in fine.items():
            values[name][members] = found
        coarse, members, doubtful = {name: own[left] for name, own in fine.items()}, members[left], apart[left]
        if not members.size:
            break
    return values, errors, float(doubtful.sum() / count)


_STRUCK = "struck"


def _of_records(system: System, members: Any, count: int) -> System:
    """The system with some of its records, where its paths differ by the one record that each has."""
    records = [*system.records.items()]
    if members.size == count or len(records) != 1:
        return system
    (name, part), own = records[0], [records[0][1].records[n] for n in members]
    some = replace(part, time=tuple(time for time, _ in own), values=tuple(values for _, values in own))
    return system.but(**{name: some})


def _with_step(plan: Plan, times: float) -> Plan:
    """With so many times the step, nearly."""
    settings = plan.settings
    step = settings.duration / max(1, round(settings.steps / times))
    begin, end = (round(time / step) * step for time in settings.window)
    return plan.but(step=step, window=(begin, end))


def _run(plan: Plan, names: Sequence[str], halved: bool = False) -> dict[str, Floats]:
    """The largest sizes of each path, by name; and which paths struck something."""
    outputs = [name for name in names if name not in _moving(plan.motion)]
    requests = [*Extremes.asked(plan, {"forces": outputs})]
    simulation = simulation_of(plan, halved=halved)
    ensemble = simulation.advance(observers=[each.observer for each in requests], halved=halved)
    extremes: dict[str, Floats] = {}
    for request in requests:
        extremes |= request.read(simulation, ensemble)["extremes"]
    found = {name: _size(extremes, name) for name in names}
    struck = [np.isfinite(own) for name, own in extremes.items() if name.endswith("impact_speed_largest")]
    return {**found, _STRUCK: np.any(struck, axis=0) if struck else np.zeros(found[names[0]].size, bool)}


def _size(extremes: Mapping[str, Floats], name: str) -> Floats:
    """0 of impacts where there was none."""
    ends = [np.abs(extremes[f"{name}{end}"]) for end in _ENDS if f"{name}{end}" in extremes]
    return np.asarray(np.nan_to_num(np.max(ends, axis=0)))


def _apart(coarse: Mapping[str, Floats], fine: Mapping[str, Floats], rtol: float) -> Floats:
    """Which paths differ by more than this in one of their largest values."""
    return np.asarray(
        np.any(
            [np.abs(fine[name] - coarse[name]) > rtol * np.abs(fine[name]) for name in fine if name != _STRUCK], axis=0
        )
    )


def of_each(do: Callable[[int], Found], count: int, threads: int, progress: Progress | None) -> list[Found]:
    """What a function gives of each number, computed on threads."""
    found, waiting, done, lock = dict[int, Found](), iter(range(count)), 0, threading.Lock()
    stopped = threading.Event()

    def work() -> None:
        nonlocal done
        while not stopped.is_set():
            with lock:
                number = next(waiting, None)
            if number is None:
                return
            found[number] = do(number)
            with lock:
                done += 1
                if progress is not None and not stopped.is_set():
                    progress(done / count)

    work_together(work, min(threads, count), stop=stopped.set)
    return [found[number] for number in range(count)]
