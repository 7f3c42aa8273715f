"""The probability that a quantity exceeds levels within a time, however small, and how often it does."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import name_results, shown
from springpot.machine.progress import Clock, FractionDone
from springpot.problem.messages import Message, say
from springpot.problem.system import System, checked_system
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.options import DEFAULTS, StartKind
from springpot.simulation.plan.plan import Plan, plan_of
from springpot.simulation.plan.settings import MOST_STEPS, Settings
from springpot.simulation.rare.asked import Quantity, asked_of, quantity_of
from springpot.simulation.rare.saved import SavedFile
from springpot.simulation.rare.search import ExceedanceCurve, search, unknown

EARLY = 2.0  # relaxation times before the time that counts from which on paths of a stationary start are split
SETTLED = 8.0  # and from which on they move: a tail feels what is left of the transient of x^2 many times over

_EVEN = 1e-9  # standard deviations of a mean that counts as 0


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
    said : tuple of str
        Warnings that are of no curve alone.
    """

    system: System
    settings: Settings
    curves: dict[str, ExceedanceCurve]
    said: tuple[Message, ...] = ()

    def __post_init__(self) -> None:
        name_results(self, "curves")

    def __getitem__(self, name: str) -> ExceedanceCurve:
        """One curve; of an unknown name the error says which one was probably meant."""
        return self.curves[name]

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
        return (*(sentence for curve in self.curves.values() for sentence in curve.warnings), *self.said)

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain numbers, words, lists and dicts; what is not finite is None."""
        return {
            "curves": {name: curve.to_dict() for name, curve in self.curves.items()},
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
        lines = [f"in {end - begin:g} s:", *map(str, self.curves.values())]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])


def exceedance(
    system: System,
    levels: Mapping[str, Any],
    *,
    duration: float,
    rtol: float = 0.1,
    start: StartKind | None = None,
    initial_position: float | None = None,
    initial_velocity: float | None = None,
    step: float | None = None,
    memory_tolerance: float = DEFAULTS["memory_tolerance"],
    seed: int = 1,
    threads: int | None = None,
    max_time: float | None = None,
    save: str | Path | None = None,
    progress: Progress | None = None,
) -> Exceedance:
    """The probability that a quantity exceeds a level within a time, however small it is, for many levels at once.

    Rare events are reached by splitting: paths that come near to them are branched, and weighted so that every
    probability is right on average; events that are not rare are counted on plain paths.  Which of the two is cheaper,
    the first paths tell.

    Parameters
    ----------
    system : System
    levels : dict
        Quantities and their levels, one or many, such as ``{"x": [0.004, 0.005, 0.006]}``: ``"x"`` (m) and ``"v"``
        (m/s), upwards if the levels lie above the start, else downwards; ``"distance"`` (m), the size of x;
        ``"speed"`` (m/s), the size of v; ``"amplitude"`` (m), sqrt(x^2 + v^2 / w^2) with w the ``resonance``;
        ``"energy"`` (m^2/s^2), (v^2 + Omega^2 x^2) / 2; ``"impact_speed"`` (m/s), of the fastest impact.  Of several
        masses, as in ``first_passage`` of `springpot.simulate`: ``"a_x"``, ``"a_b_elongation"``, ``"stop_distance"``
        and so on, and ``"stop_impact_speed"`` of a wall.  Forces and accelerations, as in its ``forces``:
        ``"spring_force"``, ``"force_on_ground"``, upwards if the levels are positive.  Any other name is that of a
        function of your own, with its levels: ``{"stress": (function, [1e6, 2e6])}``, whose arguments are those of an
        observable.
    duration : float
        The time in s.
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
    save : str or Path
        A file, made if missing, to which each repetition is written with a checksum when it has ended.  The same call
        goes on from them, after a kill too, to the same bits; with a smaller ``rtol`` it begins with them.  What was
        damaged is computed again.  Repetitions are then advanced one after another, which takes up to a quarter more
        time.  Where the file cannot be written any more, the run goes on, and a warning says so.
    progress : callable
        Called with the fraction done, about; if it is a `springpot.machine.progress.FractionDone`, its ``estimate`` has
        the seconds that are left.

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
    """
    result = exceeded(
        system, levels, duration=duration, rtol=rtol, start=start, initial_position=initial_position,
        initial_velocity=initial_velocity, step=step, memory_tolerance=memory_tolerance, seed=seed, threads=threads,
        max_time=max_time, save=save, progress=progress,
    )  # fmt: skip
    for sentence in result.warnings:
        warnings.warn(sentence, sentence.category, stacklevel=2)
    return result


def stated(
    system: System, levels: object, *, duration: float, rtol: float = 0.1, max_time: float | None = None, **given: Any
) -> tuple[Plan, list[tuple[Quantity, Floats, float]]]:
    """The plan of `exceedance`, and what is asked; raises its errors of arguments, before any work."""
    checked_system(system)
    finite_number(rtol, "rtol", low=0.01, high=1.0)
    if max_time is not None:
        finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    duration = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in seconds.")
    plan = plan_of(system, duration=duration, **given)
    if not plan.motion.is_random:
        raise ValueError("system must have noise, a random phase or records at random: without, nothing is by chance.")
    return plan, _checked(plan, levels)


def exceeded(
    system: System, levels: object, *, rtol: float = 0.1, max_time: float | None = None,
    save: str | Path | None = None, progress: Progress | None = None,
    watch: Callable[[ExceedanceCurve], None] | None = None, **settings: Any,
) -> Exceedance:  # fmt: skip
    """As `exceedance`, but its warnings are only in the result, and ``watch`` is called with curves as they grow."""
    if progress is not None and not callable(progress):
        raise TypeError(f"progress must be a function of the fraction done, not {shown(progress)}.")
    plan, wanted = stated(system, levels, rtol=rtol, max_time=max_time, **settings)
    own_functions = [*system.with_functions, *(each.name for each, _, _ in wanted if each.kind == "own")]
    file = SavedFile(_checked_place(save, own_functions))
    clock = Clock(max_time)
    plan = _settled(plan)
    if plan.settings.start == "stationary":
        plan = adapt(plan)
    simulation = simulation_of(_split_early(plan))
    curves = dict[str, ExceedanceCurve]()
    for number, (quantity, given, sign) in enumerate(wanted):
        order = np.argsort(sign * given.ravel())
        asked = asked_of(plan, simulation.parts, quantity, given.ravel()[order], sign)
        own, told = Clock(clock.left / (len(wanted) - number)), _share(progress, number, len(wanted))
        known = () if file.path is None else (system.to_dict(), {**plan.settings.to_dict(), "threads": 1}, quantity.name)
        saved = file.of([VERSION, *known, asked.given.tolist()], asked.given.size)
        arranged = _arranged(watch, np.argsort(order), given.shape)
        try:
            found = search(simulation, asked, rtol, own, told, _STREAMS * number, saved, arranged)
        except TimeoutError:
            if not curves:
                raise
            found = unknown(asked)  # what is known of the others is kept
        curves[quantity.name] = found.arranged(np.argsort(order), given.shape)
    paths = sum(curve.repetitions * curve.paths for curve in curves.values())
    lost = (say("not_saved", place=str(file.path), reason=file.failure),) if file.failure else ()
    return Exceedance(system, replace(plan.settings, paths=paths), curves, lost)


VERSION = 2  # of the numbers that repetitions give
_STREAMS = 64  # of random numbers, for each quantity


def _share(progress: Progress | None, number: int, count: int) -> Callable[[float], None]:
    """The progress of one quantity of several."""

    def told(fraction: float) -> None:
        if progress is not None:
            progress(FractionDone((number + fraction) / count, getattr(fraction, "estimate", None)))

    return told


def _arranged(
    watch: Callable[[ExceedanceCurve], None] | None, order: npt.NDArray[np.int64], shape: tuple[int, ...]
) -> Callable[[ExceedanceCurve], None] | None:
    """What is told of a curve whose levels are in the order of rarity."""
    return None if watch is None else lambda curve: watch(curve.arranged(order, shape))


def _checked(plan: Plan, levels: object) -> list[tuple[Quantity, Floats, float]]:
    """The quantities with their levels, and the sign of the direction in which these are exceeded."""
    if not isinstance(levels, Mapping) or not levels:
        raise TypeError(
            f"levels must be a dict of names and levels, such as {{'x': [0.01, 0.02]}}, not {shown(levels)}."
        )
    return [_checked_levels(plan, name, given) for name, given in levels.items()]


def _checked_levels(plan: Plan, name: object, given: Any) -> tuple[Quantity, Floats, float]:
    motion, function = plan.motion, None
    if isinstance(given, tuple) and len(given) == 2 and callable(given[0]):
        function, given = given
    quantity = quantity_of(motion, name, function)
    words, seen, least = f"level of {name}", quantity.seen, quantity.has_sides or quantity.kind == "own"
    listed = np.asarray(given, object)
    if not listed.size:
        raise ValueError(f"levels of {name} must not be empty.")
    low = -LARGEST if least else 0.0
    checked = [finite_number(each, words, low=low, high=LARGEST, open_low=not least) for each in listed.ravel()]
    numbers = np.array(checked, float).reshape(listed.shape)
    if not quantity.has_sides:
        return quantity, numbers, 1.0
    start = 0.0
    if quantity.kind != "force":
        x, v = motion.start_of(seen, plan.settings.initial_position, plan.settings.initial_velocity)
        mean, spread, _ = motion.size_of(seen)
        x = x if plan.settings.start != "stationary" else mean if abs(mean) > _EVEN * spread else 0.0
        start = x if quantity.kind == "x" else float(v)
    sides = {math.copysign(1.0, number - start) for number in numbers.ravel() if number != start}
    if len(sides) != 1 or (numbers == start).any():
        of = "0" if quantity.kind == "force" else f"the start, {start:.3g}"
        raise ValueError(f"levels of {name} must lie on one side of {of} {quantity.unit}: ask for both in two calls.")
    if quantity.kind == "x" and not ((seen.low < numbers) & (numbers < seen.high)).all():
        raise ValueError(f"levels of {name} must lie between the walls, {seen.low:g} and {seen.high:g} m.")
    return quantity, numbers, sides.pop()


def _checked_place(save: object, functions: list[str]) -> Path | None:
    if save is None:
        return None
    if not isinstance(save, str | Path):
        raise TypeError(f"save must be the place of a file, not {shown(save)}.")
    if functions:
        raise ValueError(f"save cannot be given with the function of {functions[0]}: a file does not know it again.")
    if not Path(save).resolve().parent.is_dir():
        raise ValueError(f"save must lie in a folder that exists, but {str(Path(save).parent)!r} does not.")
    return Path(save)


def _settled(plan: Plan) -> Plan:
    """The plan with whole groups of steps, and before the time that counts the one that a stationary start takes."""
    settings, motion = plan.settings, plan.motion
    steps = -(-settings.steps // GROUP) * GROUP
    step, ahead = settings.duration / steps, 0
    if settings.start == "stationary":
        ahead = (
            math.ceil((EARLY if motion.is_thermal else SETTLED) * motion.scales.relaxation_time / (GROUP * step))
            * GROUP
        )
    if steps + ahead > MOST_STEPS:
        raise ValueError(
            f"duration and {ahead * step:.3g} s before it, in which the motion settles, take too many steps."
        )
    whole = (ahead + steps) * step
    return plan.but(step=step, duration=whole, window=(ahead * step, whole))


def _split_early(plan: Plan) -> Plan:
    """The plan whose window begins before the time that counts: a path that is high then has come from somewhere.

    If it could not branch sooner, all that is rare would come from the few paths that are highest at that time.
    """
    settings = plan.settings
    group = GROUP * settings.step
    early = math.ceil(EARLY * plan.motion.scales.relaxation_time / group) * group if settings.window[0] > 0.0 else 0.0
    return plan.but(window=(max(0.0, settings.window[0] - early), settings.window[1]))
