"""The probability that a quantity exceeds levels within a time, however small, and how often it does."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import (
    LARGEST,
    check_called,
    check_folder,
    checked_path,
    finite_number,
    finite_numbers,
    text,
)
from springpot.machine.arrays import Floats
from springpot.machine.bar import Bar
from springpot.machine.faults import listed, name_results, shown
from springpot.machine.progress import Clock, part_of
from springpot.problem.messages import Message, say
from springpot.problem.system import System, checked_system
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.sizes import GROUP
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.options import Options, StartKind
from springpot.simulation.plan.plan import Plan, default_start, plan_of
from springpot.simulation.plan.settings import MOST_STEPS, Settings
from springpot.simulation.rare.event import Quantity, event_of, quantity_of
from springpot.simulation.rare.levels import ExceedanceLevel, Sought, sought_curve
from springpot.simulation.rare.saved import Saved, SavedFile
from springpot.simulation.rare.search import ExceedanceCurve, search, unknown
from springpot.theory.distributions import level_probabilities

LONG = 10.0  # windows in a time from which on it is long against the motion
WINDOW = 8.0  # relaxation times of a window that shows the rate, or if more:
CYCLES = 20.0
EARLY = 2.0  # relaxation times before the time that counts from which on paths of a stationary start are split
SETTLED = 8.0  # and from which on they move: a tail feels what is left of the transient of x^2 many times over

_BELOW = " below"  # after the name of a quantity whose level is exceeded downwards


@dataclass(frozen=True, eq=False)
class Exceedance:
    """Probabilities that quantities exceed levels within a time.

    Attributes
    ----------
    system : System
    settings : Settings
        Of the paths, of all repetitions; those of a stationary start begin before the time that counts, which is
        ``settings.window``.
    curves : dict
        `ExceedanceCurve` of each quantity, by name; ``found["x"]`` is one of them.
    level : dict
        `ExceedanceLevel` of each quantity of which probabilities were asked, by name: the levels that have them.
    other_warnings : tuple of str
        Those that are of no curve alone.
    """

    system: System
    settings: Settings
    curves: dict[str, ExceedanceCurve]
    level: dict[str, ExceedanceLevel] = field(default_factory=dict)
    other_warnings: tuple[Message, ...] = ()

    def __post_init__(self) -> None:
        name_results(self, "curves")

    def __getitem__(self, name: str) -> ExceedanceCurve:
        """One curve; of an unknown name the error says which one was probably meant."""
        return self.curves[text(name, "the name of a curve")]

    @property
    def probability(self) -> dict[str, Floats]:
        """Of exceeding each level, by quantity."""
        return {name: curve.probability for name, curve in self.curves.items()}

    @property
    def error(self) -> dict[str, Floats]:
        """The standard errors of these."""
        return {name: curve.error for name, curve in self.curves.items()}

    @property
    def return_period(self) -> dict[str, Floats]:
        """Mean times between exceedances of each level in s, by quantity."""
        return {name: curve.return_period for name, curve in self.curves.items()}

    @property
    def warnings(self) -> tuple[Message, ...]:
        """One sentence for each reason to doubt a number."""
        return (*(sentence for curve in self.curves.values() for sentence in curve.warnings), *self.other_warnings)

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain numbers, words, lists and dicts; what is not finite is None."""
        return {
            "curves": {name: curve.to_dict() for name, curve in self.curves.items()},
            **({"level": {name: found.to_dict() for name, found in self.level.items()}} if self.level else {}),
            "system": self.system.to_dict(),
            "settings": self.settings.to_dict(),
            "warnings": [*map(str, self.warnings)],
        }

    def __repr__(self) -> str:
        """What it holds; printed, it shows its numbers."""
        begin, end = self.settings.window
        held = ", ".join(f"{curve.levels.size} levels of {name}" for name, curve in self.curves.items())
        return f"Exceedance({held} in {end - begin:g} s: {len(self.warnings)} warnings)"

    def __str__(self) -> str:
        begin, end = self.settings.window
        lines = [*map(str, self.level.values()), f"in {end - begin:g} s:", *map(str, self.curves.values())]
        return "\n".join(lines)  # its warnings were raised


def exceedance(
    system: System,
    levels: Mapping[str, Any] | None = None,
    *,
    duration: float | None = None,
    probability: Mapping[str, Any] | None = None,
    return_period: Mapping[str, Any] | None = None,
    rtol: float = 0.1,
    start: StartKind | None = None,
    initial_position: float | None = None,
    initial_velocity: float | None = None,
    step: float | None = None,
    memory_tolerance: float = Options.memory_tolerance,
    seed: int = 1,
    threads: int | None = None,
    max_time: float | None = None,
    save: str | Path | None = None,
    progress: Progress | None = None,
) -> Exceedance:
    """The probability that a quantity exceeds a level within a time, however small it is, for many levels at once; or
    the level that is exceeded with a given probability.

    Rare events are reached by splitting: paths that come near to them are branched, and weighted so that every
    probability is right on average; events that are not rare are counted on plain paths.  Which of the two is cheaper,
    the first paths tell.

    Parameters
    ----------
    system : System
    levels : dict
        Quantities and their levels, one or many, such as ``{"x": [0.004, 0.005, 0.006]}``.  ``"x"`` (m) and ``"v"``
        (m/s) count upwards if the levels lie above the start, else downwards.  ``"distance"`` (m) and ``"speed"`` (m/s)
        are the size of x and of v.  ``"amplitude"`` (m) is sqrt(x^2 + v^2 / w^2) with w the ``resonance``, and
        ``"energy"`` (m^2/s^2) is (v^2 + Omega^2 x^2) / 2.  ``"impact_speed"`` (m/s) is that of the fastest impact.  Of
        several masses there are, as in ``first_passage`` of `springpot.simulate`, ``"a_x"``, ``"a_b_elongation"``,
        ``"stop_distance"`` and so on, and ``"stop_impact_speed"`` of a wall.  Forces and accelerations have the
        names that its ``forces`` takes: ``"spring_force"``, ``"force_on_ground"``, upwards if the levels are positive.
        Any other name is that of a function of your own, with its levels: ``{"stress": (function, [1e6, 2e6])}``, whose
        arguments are those of an observable.
    duration : float
        The time in s.  For a time that is long against the motion, such as an hour, ask for some periods of the
        stationary state, and take ``found["x"].within(3600.0)``: it costs less.  May be left out with
        ``return_period``.
    probability : dict
        In place of ``levels``: quantities and probabilities, one or many, each up to 0.5, such as ``{"x": 1e-6}``, or
        ``{"x below": 1e-6}`` for a level that is exceeded downwards; of a function ``{"stress": (function, 1e-6)}``.
        ``found.level["x"]`` has the levels with their errors and intervals, and ``found["x"]`` the probabilities of
        levels close to them.  Where the time is more than ten times as long as the motion needs to show its rate (8
        relaxation times or 20 periods) and the start stationary, the paths have this shorter time, and the rate of
        their first exceedances is taken to go on: as a Poisson process, which rare crossings are.
    return_period : dict
        In place of ``levels`` or ``probability``: quantities and return periods in s, one or many, such as
        ``{"x": 3600.0}``.  ``found.level["x"]`` has the levels that are exceeded so often, by the same assumption.
    rtol : float
        Standard error of the probability at each level, relative to it, in [0.01, 1].
    start : {"stationary", "rest"}
        As in `springpot.simulate`: if left out, stationary where there is a stationary state and no initial state is
        given.  The time then begins when the motion has settled, and paths beyond the level at that time count.
    initial_position, initial_velocity, step, memory_tolerance
        As in `springpot.simulate`.  The step is shortened to a part of the time.
    seed : int
        The same seed gives the same bits for any number of threads, but with ``max_time``.
    threads : int
        All available ones if left out.
    max_time : float
        Seconds after which it ends with what is known by then: a level that no path has exceeded has an upper bound.
        A compilation, up to half a minute, counts too.
    save : str or Path
        A file, made if missing, to which each repetition is written with a checksum when it has ended.  The same call
        goes on from them, after a kill too, to the same bits; with a smaller ``rtol`` it begins with them.  What was
        damaged is computed again.  Repetitions are then advanced one after another, which takes up to a quarter more
        time.  Where the file cannot be written any more, the run goes on, and a warning says so.
    progress : callable
        Called with the fraction done, about; if it is a `springpot.machine.progress.FractionDone`, its ``estimate`` has
        the seconds that are left.  What it raises ends the call.  If left out, a call of more than two seconds shows a
        bar on a terminal, and one that will take more than ten says so on stderr before it does it, and if
        `springpot.theory.exceedance` has the same at once.

    Returns
    -------
    Exceedance
        Printed, it is a table.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; nothing has been computed then.
    NotCoveredError
        Of a force or an acceleration that cannot be seen.
    FileError
        If ``save`` is a file of something else, no file, too large, or cannot be read or written.
    TimeoutError
        If ``max_time`` is too short for any result.  Where it is too short for some quantities only, their
        probabilities are NaN, and the bound is 1.

    Warns
    -----
    SpringpotWarning
        For each sentence of ``warnings``.

    Notes
    -----
    With random phases, or several records, the probability is that over them too.

    A coarse step distorts a tail more than a mean: a relative error e of the mean square changes a probability at b
    standard deviations by about e b^2 / 2.

    Examples
    --------
    >>> import springpot as sp
    >>> oscillator = sp.Oscillator(
    ...     springpot=sp.Springpot(0.5, 0.2), barrier=sp.Barrier(-0.3, 0.8), excitation=sp.WhiteNoise(0.2)
    ... )
    >>> found = sp.exceedance(oscillator, {"x": [2.6, 3.6]}, duration=20.0, start="rest", step=0.05, rtol=0.2)
    >>> bool(abs(found.probability["x"][1] / 1.5e-6 - 1.0) < 0.8), found["x"].method
    (True, 'splitting')

    The level that is exceeded once in a thousand times:

    >>> found = sp.exceedance(oscillator, probability={"x": 1e-3}, duration=20.0, start="rest", step=0.05, rtol=0.2)
    >>> bool(abs(found.level["x"].level - 2.68) < 0.2)
    True
    """
    given: dict[str, Any] = {
        "duration": duration, "probability": probability, "return_period": return_period, "rtol": rtol, "start": start,
        "initial_position": initial_position, "initial_velocity": initial_velocity, "step": step,
        "memory_tolerance": memory_tolerance, "seed": seed, "threads": threads, "max_time": max_time, "save": save,
    }  # fmt: skip
    quantities, time = levels or probability or return_period, duration if levels else None
    hint = hint_of(system, quantities, "max_time= ends it earlier", duration=time)
    bar = Bar("splitting paths", first="simulating", hint=hint) if progress is None else nullcontext(progress)
    with bar as told:
        result = exceeded(system, levels, **given, progress=told)
    for sentence in result.warnings:
        warnings.warn(sentence, sentence.category, stacklevel=2)
    return result


def hint_of(
    system: System, quantities: Any, ends: str, theory: str = "springpot.theory.exceedance",
    duration: float | None = None,
) -> Callable[[], str]:  # fmt: skip
    """What can be done where a call will take long: how it ends earlier, whether a shorter ``duration`` would do, and
    whether theory has the same.
    """

    def words() -> str:
        from springpot.theory.level_crossings import covers  # slow to import

        names, said, window = [name for name in quantities if covers(system, name)], ends, window_of(motion_of(system))
        if duration is not None and duration > LONG * window:
            said += f"; duration={window:.2g} and .within({duration:g}) of the curve take less time"
        return f"{said}; {theory} has {listed(names)} at once, by formulas of the stationary state" if names else said

    return words


def stated(
    system: System, levels: object, *, duration: float | None, probability: object = None,
    return_period: object = None, rtol: float = 0.1, max_time: float | None = None, **given: Any,
) -> tuple[Plan, list[tuple[Quantity, Floats, float]]]:  # fmt: skip
    """The plan of `exceedance`, and what is asked; raises its errors of arguments, before any work.

    The plan has a shorter time where that shows the rate of what is asked.
    """
    checked_system(system)
    finite_number(rtol, "rtol", low=0.01, high=1.0)
    if max_time is not None:
        finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    motion = motion_of(system)
    window = window_of(motion)
    if duration is None and return_period is not None:
        time = window
    else:
        time = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in seconds.")
    if given.get("start") is None:  # the time counts when the motion has settled
        given["start"], _ = default_start(motion, given)
    if return_period is not None and not motion.settles:
        raise ValueError("return_period must be of a motion with a stationary state: without, no rate is constant.")
    if probability is not None and given["start"] == "stationary" and time > LONG * window:
        time = window
    plan = plan_of(system, duration=time, **given)
    if not plan.motion.is_random:
        raise ValueError("system must have noise, a random phase or records at random: without, nothing is by chance.")
    if sum(each is not None for each in (levels, probability, return_period)) != 1:
        raise TypeError("levels, probability or return_period must be given, and only one of them.")
    if levels is not None:
        return plan, _checked(plan, levels)
    if probability is not None:
        return plan, _checked_sought(plan, probability, "probability")
    return plan, _checked_sought(plan, return_period, "return_period")


def window_of(motion: Motion) -> float:
    """A time in s that shows the rate of first exceedances, of a stationary motion; infinite without one."""
    settled = motion.settled_after("stationary", WINDOW)
    return max(settled, CYCLES * 2.0 * math.pi / motion.scales.frequency) if motion.settles else math.inf


def long_time(motion: Motion, duration: float | None) -> str:
    """What to ask for in place of a time that is long against the motion, as one more sentence; empty of others."""
    window = window_of(motion)
    if duration is None or not duration > LONG * window:
        return ""
    return (
        f" A duration of {duration:g} s is long against the motion: ask for some periods of the stationary state, "
        f"duration={window:.2g}, and take .within({duration:g}) of the curve."
    )


def exceeded(
    system: System, levels: object = None, *, probability: object = None, rtol: float = 0.1,
    return_period: object = None, duration: float | None = None, max_time: float | None = None,
    save: str | Path | None = None, progress: Progress | None = None,
    watch: Callable[[ExceedanceCurve], None] | None = None, **settings: Any,
) -> Exceedance:  # fmt: skip
    """As `exceedance`, but its warnings are only in the result, and ``watch`` is called with curves as they grow."""
    check_called(progress, "progress")
    plan, wanted = stated(
        system, levels, duration=duration, probability=probability, return_period=return_period, rtol=rtol,
        max_time=max_time, **settings,
    )  # fmt: skip
    own_functions = [*system.with_functions, *(each.name for each, _, _ in wanted if each.kind == "own")]
    file = SavedFile(_checked_place(save, own_functions))
    clock = Clock(max_time)
    plan = settled(plan)
    if plan.settings.start == "stationary":
        plan = adapt(plan)
    simulation = simulation_of(split_early(plan))
    curves, level = dict[str, ExceedanceCurve](), dict[str, ExceedanceLevel]()
    for number, (quantity, given, sign) in enumerate(wanted):
        own = Clock(clock.left / (len(wanted) - number))
        told = part_of(progress, number / len(wanted), (number + 1) / len(wanted))

        def saved(levels: Floats, name: str = quantity.name) -> Saved:
            known = () if file.path is None else (system.to_dict(), {**plan.settings.to_dict(), "threads": 1}, name)
            return file.of([VERSION, *known, levels.tolist()], levels.size)

        stream = _STREAMS * number
        try:
            if levels is None:
                sought = _sought(plan, quantity, given, sign, None if probability is None else duration)
                curves[quantity.name], level[quantity.name] = sought_curve(
                    simulation, plan, sought, rtol, own, told, stream, saved
                )
                continue
            order = np.argsort(sign * given.ravel())
            asked = event_of(plan, simulation.parts, quantity, given.ravel()[order], sign)
            arranged = _arranged(watch, np.argsort(order), given.shape)
            found = search(simulation, asked, rtol, own, told, stream, saved(asked.given), arranged)
        except TimeoutError as error:
            if not curves or levels is None:
                raise TimeoutError(f"{error}{long_time(plan.motion, duration) if levels else ''}") from None
            found = unknown(asked)  # what is known of the others is kept
        curves[quantity.name] = found.arranged(np.argsort(order), given.shape)
    paths = sum(curve.repetitions * curve.paths for curve in curves.values())
    lost = (say("not_saved", place=str(file.path), reason=file.failure),) if file.failure else ()
    return Exceedance(system, replace(plan.settings, paths=paths), curves, level, lost)


VERSION = 2  # of the numbers that repetitions give
_STREAMS = 64  # of random numbers, for each quantity
_SUCH = {
    "levels": "levels, such as {'x': [0.01, 0.02]}", "probability": "probabilities, such as {'x': 1e-6}",
    "return_period": "times, such as {'x': 3600.0}",
}  # fmt: skip


def _arranged(
    watch: Callable[[ExceedanceCurve], None] | None, order: npt.NDArray[np.int64], shape: tuple[int, ...]
) -> Callable[[ExceedanceCurve], None] | None:
    """What is told of a curve whose levels are in the order of rarity."""
    return None if watch is None else lambda curve: watch(curve.arranged(order, shape))


def _asked(plan: Plan, argument: str, asked: object) -> Iterator[tuple[Any, Quantity, Any]]:
    """Each name that was given, its quantity, and what was given for it."""
    if not isinstance(asked, Mapping) or not asked:
        raise TypeError(f"{argument} must be a dict of names and {_SUCH[argument]}, not {shown(asked)}.")
    for name, given in asked.items():
        function, own = None, name
        if isinstance(given, tuple) and len(given) == 2 and callable(given[0]):
            function, given = given
        if argument != "levels" and isinstance(name, str):
            own = name.removesuffix(_BELOW)
        yield name, quantity_of(plan.motion, own, function, argument), given


def _checked(plan: Plan, levels: object) -> list[tuple[Quantity, Floats, float]]:
    """The quantities with their levels, and the sign of the direction in which these are exceeded."""
    found = []
    for name, quantity, given in _asked(plan, "levels", levels):
        words, signal, least = f"level of {name}", quantity.signal, quantity.has_sides or quantity.kind == "own"
        low = -LARGEST if least else 0.0
        numbers = finite_numbers(given, f"levels of {name}", words, low=low, high=LARGEST, open_low=not least)
        if quantity.kind == "distance" and not (numbers < (farther := max(signal.high, -signal.low))).all():
            raise ValueError(f"levels of {name} must be less than that of the farther wall, {farther:g} m.")
        if not quantity.has_sides:
            found.append((quantity, numbers, 1.0))
            continue
        start = _start_of(plan, quantity)
        sides = {math.copysign(1.0, number - start) for number in numbers.ravel() if number != start}
        if len(sides) != 1 or (numbers == start).any():
            of, size = "0" if quantity.kind == "force" else f"the start, {start:.3g}", float(np.abs(numbers).max())
            asks = f"'peak': (lambda {name}: abs({name}), {size:g})"
            if quantity.kind != "force":
                begin = str(name).removesuffix("elongation").removesuffix(quantity.kind)
                asks = f"'{begin}{'speed' if quantity.kind == 'v' else 'distance'}': {size:g}"
            raise ValueError(
                f"levels of {name} must lie on one side of {of} {quantity.unit}: ask for both as {{{asks}}}."
            )
        if quantity.kind == "x" and not ((signal.low < numbers) & (numbers < signal.high)).all():
            raise ValueError(f"levels of {name} must lie between the walls, {signal.low:g} and {signal.high:g} m.")
        found.append((quantity, numbers, sides.pop()))
    return found


def _start_of(plan: Plan, quantity: Quantity) -> float:
    """From which a quantity with sides exceeds its levels; 0 of others."""
    if quantity.kind not in ("x", "v"):
        return 0.0
    motion, signal = plan.motion, quantity.signal
    x, v = motion.start_of(signal, plan.settings.initial_position, plan.settings.initial_velocity)
    x = motion.stationary_place(signal) if plan.settings.start == "stationary" else x
    return x if quantity.kind == "x" else float(v)


def _checked_sought(plan: Plan, asked: object, argument: str) -> list[tuple[Quantity, Floats, float]]:
    """The quantities with their probabilities or return periods, and the sign of the direction in which levels are
    exceeded.
    """
    found = []
    for name, quantity, given in _asked(plan, argument, asked):
        below = str(name).endswith(_BELOW)
        if below and not quantity.has_sides:
            raise ValueError(f"{argument} has {name!r}, but {quantity.name} has no sides: leave out{_BELOW}.")
        if argument == "probability":
            numbers = level_probabilities(given, quantity.name)
        else:
            word, least = f"return_period of {quantity.name}", 2.0 * plan.settings.duration
            hint = "It is in seconds, at least twice the time that shows the rate."
            numbers = finite_numbers(given, word, word, low=least, high=1e15 * least, hint=hint)
        found.append((quantity, numbers, -1.0 if below else 1.0))
    if len({quantity.name for quantity, _, _ in found}) < len(found):
        raise ValueError(f"{argument} must have each quantity once: ask for both sides in two calls.")
    return found


def _sought(plan: Plan, quantity: Quantity, given: Floats, sign: float, duration: float | None) -> Sought:
    """What the search for levels needs: where they begin, and how far a wall lets them be."""
    start, signal = _start_of(plan, quantity), quantity.signal
    end = {"x": signal.high if sign > 0.0 else -signal.low, "distance": max(signal.high, -signal.low)}.get(
        quantity.kind, math.inf
    )
    begin, whole = plan.settings.window
    window = whole - begin
    if duration is not None and duration < 2.0 * window:  # the same, but for rounding
        duration = window
    farthest = min(end - sign * start, LARGEST) * (1.0 - 1e-9)
    return Sought(quantity, given, duration, window, sign, start, farthest)


def _checked_place(save: object, functions: list[str]) -> Path | None:
    if save is None:
        return None
    save = checked_path(save, "save")
    if functions:
        raise ValueError(f"save cannot be given with the function of {functions[0]}: a file does not know it again.")
    check_folder(save, "save")
    return save


def settled(plan: Plan, others: Sequence[Motion] = ()) -> Plan:
    """The plan with whole groups of steps, and before the time that counts the one that a stationary start takes, for
    other devices too.
    """
    settings = plan.settings
    steps = -(-settings.steps // GROUP) * GROUP
    step, ahead = settings.duration / steps, 0
    if settings.start == "stationary":
        times = EARLY if plan.motion.is_thermal else SETTLED
        latest = max(motion.settled_after(settings.start, times) for motion in (plan.motion, *others))
        ahead = math.ceil(latest / (GROUP * step)) * GROUP
    if steps + ahead > MOST_STEPS:
        raise ValueError(
            f"duration and {ahead * step:.3g} s before it, in which the motion settles, take too many steps."
        )
    whole = (ahead + steps) * step
    return plan.but(step=step, duration=whole, window=(ahead * step, whole))


def split_early(plan: Plan) -> Plan:
    """The plan whose window begins before the time that counts: a path that is high then has come from somewhere.

    If it could not branch sooner, all that is rare would come from the few paths that are highest at that time.
    """
    settings = plan.settings
    group = GROUP * settings.step
    early = (
        math.ceil(plan.motion.settled_after(settings.start, EARLY) / group) * group if settings.window[0] > 0.0 else 0.0
    )
    return plan.but(window=(max(0.0, settings.window[0] - early), settings.window[1]))
