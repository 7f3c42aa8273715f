"""The largest values of each path by the compiled kernel, with what the step leaves in them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.machine.faults import few, shown
from springpot.problem.catalogue import unit_of_result
from springpot.problem.felt import about_shocks
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

_COARSE = 8.0  # of the default step under records, at which halving begins; it ends with that step
_MOST_HALVINGS = 4
_ENDS = "_minimum", "_maximum", "_largest"


@dataclass(frozen=True, eq=False)
class Largest:
    """Of each path, by output.

    Attributes
    ----------
    values, errors : dict of ndarray
        The largest sizes, and how far they were off at twice the step.
    step : float
        In s.
    unconverged : float
        Share of the paths whose largest values differ by more than ``rtol`` between the last two steps.
    warnings : tuple of str
    """

    values: dict[str, Floats]
    errors: dict[str, Floats]
    step: float
    unconverged: float
    warnings: tuple[str, ...]


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
    if name.endswith("impact_speed"):
        return "m s-1"
    for own in (name, f"{name}_maximum", f"{name}_largest"):
        try:
            return unit_of_result(system, own)
        except KeyError:
            continue
    return ""


def check_outputs(motion: Motion, words: Sequence[str], argument: str) -> None:
    """Raise an error if there is no such output."""
    moving = _moving(motion)
    for word in words:
        name = name_in_results(word)
        if name not in moving:
            if not isinstance(name, str) or name not in [*motion.felt, *motion.of_impacts]:
                known = [*dict.fromkeys([*(w for w, own in WORDS.items() if own in moving),
                                         *(own for own in moving if own not in WORDS.values()),
                                         *motion.seen_by_force])]  # fmt: skip
                raise ValueError(f"{argument} must be of {few(known)}, not {shown(word)}.")
            motion.seen_by_name(name, argument, forces_only=True)


def _moving(motion: Motion) -> list[str]:
    return [own for seen in motion.seen for key, own in seen.names.items() if key != "amplitude"]


def largest_values(
    system: System, words: Sequence[str], *, kind: Kind = "maximax", tail: float = 0.0, duration: float | None = None,
    paths: int | None = None, rtol: float = 0.005, step: float | None = None, seed: int = 1, threads: int | None = None,
    argument: str = "output",
) -> Largest:  # fmt: skip
    """The largest sizes of outputs over the time that counts, of each path.

    Under records and noise that ends the time is that of the record and ``tail`` after it, from rest; under noise that
    does not, ``duration`` in the stationary state.  Under records the step is halved until all paths agree to ``rtol``;
    under noise a run with twice the step, on the same noise, shows what the step leaves.
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
    plan = plan_of(system, **options, **({"step": step} if step else {}))
    if not length:
        plan = settled(plan)
    elif kind == "primary":
        plan = plan.but(window=(0.0, _whole(plan, length)))
    else:
        plan = plan.but(window=(_whole(plan, length) if kind == "residual" else 0.0, plan.settings.duration))
    if plan.settings.start == "stationary":
        plan = adapt(plan)
    names = [name_in_results(word) for word in words]
    if motion.is_random:
        coarse, fine = (_run(each, names, halved) for each, halved in ((_with_step(plan, 2.0), True), (plan, False)))
        last = plan.settings.step
    else:
        divided = 1.0 if step else _COARSE
        coarse = _run(_with_step(plan, 2.0 * divided), names)
        for halving in range(_MOST_HALVINGS):
            fine, last = _run(own := _with_step(plan, divided), names), own.settings.step
            if step or halving == _MOST_HALVINGS - 1 or not _apart(coarse, fine, rtol).any():
                break
            coarse, divided = fine, 0.5 * divided
    errors = {name: np.abs(fine[name] - coarse[name]) for name in names}
    struck = {"impact_rate": 1.0 if fine[_STRUCK].any() else 0.0}
    return Largest(
        {word: fine[name] for word, name in zip(words, names, strict=True)},
        {word: errors[name] for word, name in zip(words, names, strict=True)}, last,
        0.0 if motion.is_random else float(_apart(coarse, fine, rtol).mean()),
        tuple(map(str, about_shocks(system, names, struck))),
    )  # fmt: skip


_STRUCK = "struck"


def _whole(plan: Plan, time: float) -> float:
    return round(time / plan.settings.step) * plan.settings.step


def _with_step(plan: Plan, times: float) -> Plan:
    """The plan with so many times the step, or nearly so many."""
    settings = plan.settings
    steps = max(1, round(settings.steps / times))
    step = settings.duration / steps
    begin, end = (round(time / step) * step for time in settings.window)
    return plan.but(step=step, window=(begin, end))


def _run(plan: Plan, names: Sequence[str], halved: bool = False) -> dict[str, Floats]:
    """The largest sizes of each path, by name; and which paths struck something."""
    felt = [name for name in names if name not in _moving(plan.motion)]
    requests = [*Extremes.asked(plan, {"forces": felt})]
    simulation = simulation_of(plan, halved=halved)
    ensemble = simulation.advance(observers=[each.observer for each in requests], halved=halved)
    extremes: dict[str, Floats] = {}
    for request in requests:
        extremes |= request.read(simulation, ensemble)["extremes"]
    found = {name: _size(extremes, name) for name in names}
    struck = [np.isfinite(own) for name, own in extremes.items() if name.endswith("impact_speed_largest")]
    return {**found, _STRUCK: np.any(struck, axis=0) if struck else np.zeros(1, bool)}


def _size(extremes: Mapping[str, Floats], name: str) -> Floats:
    """0 of impacts where there was none."""
    ends = [np.abs(extremes[f"{name}{end}"]) for end in _ENDS if f"{name}{end}" in extremes]
    return np.asarray(np.nan_to_num(np.max(ends, axis=0)))


def _apart(coarse: Mapping[str, Floats], fine: Mapping[str, Floats], rtol: float) -> Floats:
    """Which paths differ by more than this in one of their largest values."""
    return np.any(
        [np.abs(fine[name] - coarse[name]) > rtol * np.abs(fine[name]) for name in fine if name != _STRUCK], axis=0
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
