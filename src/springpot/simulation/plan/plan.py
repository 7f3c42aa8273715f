"""The plan of a run: a system, what is known of its motion, and complete settings.  Made once, by `plan_of`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, get_args

from springpot.machine.arguments import LARGEST, finite_number, one_of
from springpot.machine.faults import shown
from springpot.problem.system import System
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.options import Derivative, Options, Scheme, SchemeOfRun, StartKind, is_default
from springpot.simulation.plan.schemes import scheme_of
from springpot.simulation.plan.settings import (
    MOST_PATHS,
    MOST_STEPS,
    Settings,
    checked_seed,
    checked_threads,
    whole_number,
)

_OF_A_START = "initial_position", "initial_velocity", "derivative"
SHORTEST = 1e-30  # duration, over the shortest time of the motion
TOO_FAR_APART = "the problem's numbers must be closer together: double precision does not hold its motion."
USUAL_PATHS = 5000
MOST_TRANSIENT = 0.01  # share left at the start of the window
WALL = 2.0  # a wall changes the slow displacements by less than this factor
LONGEST_DEFAULT = 2_000_000  # steps
MOST_RECORDED = 50_000_000
COARSEST = 0.5  # largest step * fastest rate that is accepted
COARSEST_EXACT = 2.5  # where the step has no error (`keeps_the_law`): a half step is less than a quarter of a cycle


@dataclass(frozen=True)
class Adapted:
    """A stationary start, as pilot runs found it: x(0) and its error.

    Made by `springpot.simulation.estimate.stationary_start.adapt`.

    Attributes
    ----------
    position : float, or dict of float
        x(0), in m; with several masses that of each.
    residual, residual_se : float or None
        |E[x] - x(0)| over the root mean square displacement, and its standard error, measured by an independent pilot
        run before the last correction of x(0); of several masses the largest.  None if pilot runs would take too long;
        x(0) is then that of averaging, or of rest.
    error : float or None
        Standard error of x(0), over the root mean square displacement; None without pilot runs.  With slopes it is that
        along the way by which they were measured.
    pilots : int
        Number of pilot runs.
    slopes : dict of float
        How much each result changes with x(0), over the root mean square displacement, in size: measured by pilot runs
        from places apart.  Empty where the error of x(0) fades, or no pilots were far enough apart.
    """

    position: float | dict[str, float]
    residual: float | None
    residual_se: float | None
    error: float | None
    pilots: int
    slopes: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Plan:
    """A run that is decided: nothing after it asks what kind of problem it has.

    Attributes
    ----------
    motion : Motion
    settings : Settings
        Complete, but for x(0) of a stationary start before its pilot runs.
    adapted : Adapted or None
        How x(0) of a stationary start was found.
    """

    motion: Motion
    settings: Settings
    adapted: Adapted | None = None

    @property
    def system(self) -> System:
        """The user's own."""
        return self.motion.system

    def but(self, **settings: Any) -> Plan:
        """The same with other settings."""
        return replace(self, settings=replace(self.settings, **settings))

    def started_at(self, adapted: Adapted) -> Plan:
        """The same with x(0) of a stationary start."""
        return replace(self.but(initial_position=adapted.position), adapted=adapted)

    @property
    def from_rest(self) -> Plan:
        """The same from rest."""
        return self.but(start="rest", initial_position=self.motion.placed(None))

    @property
    def keeps_the_law(self) -> bool:
        """Whether the scheme leaves the stationary law of this motion as it is, however long the step.

        Stationary averages at the steps, and of impacts, then have no error of the step.
        """
        return self.motion.keeps_the_law and self.settings.numerical_scheme.keeps_the_law

    @property
    def transient_left(self) -> float:
        """Share of the transient that is left at the start of the window; 0 of a start from the stationary law."""
        if self.motion.is_thermal and self.settings.start == "stationary":
            return 0.0
        return self.motion.transient_left(self.settings.start, self.settings.window[0])

    @property
    def energy_left(self) -> float:
        """That of the energy alone, which does not creep."""
        return math.exp(-self.settings.window[0] / self.motion.scales.energy_time)

    @property
    def is_stationary(self) -> bool:
        """Whether averages over the window are stationary.

        Not with a wall, memory and a start from rest, whose transient decays only like t^-alpha.
        """
        remembered = self.settings.start == "rest" and self.motion.searched and bool(self.motion.springpots)
        return not self.motion.not_stationary and self.transient_left <= MOST_TRANSIENT and not remembered


def plan_of(system: System, **given: Any) -> Plan:
    """Check the given `Options`, complete them, and decide all that a run needs.

    Raises
    ------
    TypeError, ValueError
        One sentence that names the argument, what is wrong with it and what would be right.

    Examples
    --------
    >>> from springpot.problem.oscillator import Oscillator
    >>> plan_of(Oscillator(), paths=10, duration=5.0).settings.steps
    50
    """
    motion = motion_of(system)
    options = Options(**given)
    one_of(options.scheme, "scheme", get_args(Scheme))
    one_of(options.derivative, "derivative", get_args(Derivative))
    scheme = scheme_of(options.scheme)
    for name, only_paper in (("scheme", scheme.only_paper), ("derivative", options.derivative != "caputo")):
        if only_paper and motion.beyond_paper:
            raise ValueError(f"{name} must be {getattr(Options, name)!r}: {motion.beyond_paper}")
    start = options.start
    if start is None:
        start, _ = default_start(motion, given)
    one_of(start, "start", get_args(StartKind))
    paths = whole_number(USUAL_PATHS if options.paths is None else options.paths, "paths", 1, MOST_PATHS)
    if motion.different_paths and (motion.recorded or options.paths is None):
        paths = min(paths, motion.different_paths)
    seed = checked_seed(options.seed)
    threads = checked_threads(options.threads)
    whole = motion.recorded
    wanted = whole if options.duration is None and whole else options.duration
    scheme_of_run = motion.scheme_for(options.scheme)
    duration, step, steps = _grid(motion, wanted, options.step, scheme_of_run, start)
    window = _window((0.0, duration) if whole and options.window is None else options.window, duration, step)
    record, record_every = _record(options.record, options.record_every, paths, steps, len(system.points))
    settings = Settings(
        paths=paths,
        duration=duration,
        step=step,
        window=window,
        seed=seed,
        threads=threads,
        scheme=scheme_of_run,
        start=start,
        initial_position=_initial_position(motion, options.initial_position, start, options.derivative),
        initial_velocity=motion.moving(options.initial_velocity),
        derivative=options.derivative,
        memory_tolerance=finite_number(options.memory_tolerance, "memory_tolerance", low=1e-13, high=1e-2),
        contact_tolerance=finite_number(options.contact_tolerance, "contact_tolerance", low=0.0, high=LARGEST),
        record=record,
        record_every=record_every,
    )
    return Plan(motion, settings)


def default_start(motion: Motion, given: Mapping[str, Any] = MappingProxyType({})) -> tuple[StartKind, str]:
    """The start of a run without the argument ``start``, and the reason if there is no stationary state.

    The start is stationary, unless x(0), x'(0) or the Riemann-Liouville derivative is given, which mean a start from a
    given state, or there is no stationary state.

    Parameters
    ----------
    motion : Motion
    given : dict
        `Options` of the caller, by name.

    Returns
    -------
    start : {"rest", "stationary"}
    reason : str
        Why there is no stationary state; otherwise empty.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, WhiteNoise
    >>> default_start(motion_of(System(Spring(1.0), WhiteNoise(1.0))))
    ('rest', 'nothing dissipates energy, so it grows without limit')
    """
    if any(name in given and not is_default(given[name], getattr(Options, name)) for name in _OF_A_START):
        return "rest", ""
    if motion.recorded:
        return "rest", ""
    if motion.not_stationary:
        return "rest", motion.not_stationary
    return "stationary", ""


def check_stationary(system: System, who: str) -> None:
    """Raise an error if there is no stationary state; ``who`` is the argument or command that needs one.

    Raises
    ------
    NoStationaryStateError
        If nothing moves the mass, or nothing dissipates energy.

    Examples
    --------
    >>> from springpot.problem.oscillator import Oscillator
    >>> check_stationary(Oscillator(), "rtol")
    """
    check_motion(motion_of(system), who)


def check_motion(motion: Motion, who: str) -> None:
    """As `check_stationary`."""
    if motion.not_stationary:
        from springpot.theory.result import NoStationaryStateError

        raise NoStationaryStateError(f"{who} needs a stationary state, and there is none: {motion.not_stationary}.")


def default_duration(motion: Motion, step: float, start: StartKind) -> float:
    """100 over the frequency (as in the paper), or 20 relaxation times if that is longer, or twice the time for which
    loose masses wait; at most 1e4 over the frequency and 2 million steps.

    A slower motion needs an explicit ``duration``.
    """
    frequency = motion.scales.frequency
    waiting = -2.02 * math.log(MOST_TRANSIENT) * motion.waiting_time(start)  # with room for whole steps
    long_enough = max(20.0 * motion.scales.relaxation_time, waiting)
    wanted = 100.0 / frequency if math.isinf(long_enough) else max(100.0 / frequency, long_enough)
    return min(wanted, 1e4 / frequency, LONGEST_DEFAULT * step)


def _grid(
    motion: Motion, duration: float | None, step: float | None, scheme: SchemeOfRun, start: StartKind
) -> tuple[float, float, int]:
    if duration is not None:
        duration = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is the time simulated, in s.")
    fastest = motion.scales.fastest_rate
    if not 0.0 < fastest < math.inf:
        raise ValueError(TOO_FAR_APART)
    if duration is not None and duration * fastest < SHORTEST:
        raise ValueError(
            f"duration is {duration:g} s, too short for a system whose fastest rate is {fastest:g} per s: use at least "
            f"{SHORTEST / fastest:.3g} s."
        )
    if step is None:
        step = min(motion.default_step(scheme_of(scheme)), math.inf if duration is None else duration)
    else:
        step = finite_number(step, "step", low=0.0, open_low=True, hint="It is the time step, in s.")
    if duration is None:
        duration = default_duration(motion, step, start)
        if not duration > 0.0:
            raise ValueError(TOO_FAR_APART)
    if step > duration:
        raise ValueError(f"step must not be longer than the duration of {duration:g} s, but it is {step:g} s.")
    coarsest = COARSEST_EXACT if motion.keeps_the_law and scheme_of(scheme).keeps_the_law else COARSEST
    if step * fastest > coarsest:
        raise ValueError(
            f"step is {step:g} s, too coarse for a system whose fastest rate is "
            f"{fastest:g} per s: use at most {coarsest / fastest:.3g} s, or about "
            f"{motion.default_step(scheme_of(scheme)):.3g} s for errors well below 1 %."
        )
    ratio = duration / step
    if ratio > MOST_STEPS:
        advice = f"a duration of at most {MOST_STEPS * step:.3g} s"
        if duration / MOST_STEPS * fastest <= coarsest:
            advice = f"a step of at least {duration / MOST_STEPS:.3g} s or {advice}"
        raise ValueError(
            f"duration of {duration:g} s takes more than the {MOST_STEPS:,} steps of {step:g} s that are allowed: "
            f"use {advice}."
        )
    # duration / step rounded up, with a margin for rounding errors
    steps = max(1, math.ceil(ratio * (1.0 - 1e-12) - 1e-9))
    return duration, duration / steps, steps


def _window(window: tuple[float, float] | None, duration: float, step: float) -> tuple[float, float]:
    if window is None:
        window = 0.5 * duration, duration
    if not isinstance(window, Sequence) or isinstance(window, str) or len(window) != 2:
        raise TypeError(f"window must be a pair of times (start, end), not {shown(window)}.")
    begin = finite_number(window[0], "window start", low=0.0)
    end = finite_number(window[1], "window end", low=0.0)
    if not begin < end:
        raise ValueError(f"window must start before it ends, but it runs from {begin:g} s to {end:g} s.")
    if end > duration * (1.0 + 1e-12):
        raise ValueError(f"window ends at {end:g} s, after the end of the run at {duration:g} s.")
    first, last = round(begin / step), min(round(end / step), round(duration / step))
    if last <= first:
        raise ValueError(f"window from {begin:g} s to {end:g} s holds no step of {step:g} s: make it longer.")
    return first * step, last * step  # whole steps


def _record(record: int, every: int | None, paths: int, steps: int, masses: int) -> tuple[int, int]:
    """How many paths are stored, and every how many steps."""
    record = whole_number(record, "record", 0, paths)
    if every is not None and record == 0:
        raise ValueError("record_every has no effect without record, the number of paths to store.")
    every = 1 if every is None else whole_number(every, "record_every", 1, steps)
    if record * masses * (steps // every) > MOST_RECORDED:
        wanted = math.ceil(record * masses * steps / MOST_RECORDED)
        fewer = MOST_RECORDED // (masses * (steps // every))
        advice = f"record_every={wanted} or more" if wanted <= steps else ""
        if fewer > 0:
            advice += f"{' or ' if advice else ''}at most {fewer} paths"
        raise ValueError(
            f"record asks for {record} paths of {steps // every} points{f' of {masses} masses' if masses > 1 else ''}, "
            f"but at most {MOST_RECORDED:,} points are stored: use {advice}."
        )
    return record, every


def _initial_position(motion: Motion, given: Any, start: StartKind, derivative: Derivative) -> Any:
    """x(0): 0, or the wall beyond which 0 lies, if not given; None before the pilot runs of a stationary start."""
    if start == "stationary":
        if given is not None:
            raise ValueError("initial_position cannot be given with start='stationary', which finds x(0) itself.")
        if derivative != "caputo":
            raise ValueError(
                "derivative must be 'caputo' with start='stationary': the memory of this start is adapted to x(0)."
            )
        check_motion(motion, "start='stationary'")
        return None
    return motion.placed(given)


def shares_missing(motion: Motion, time: float, values: Mapping[str, float]) -> dict[str, float]:
    """Bound on the missing share of each of some values at a time, due to slow displacements.

    The energy forgets its start exponentially, slow displacements like a power of time.
    With a gap b the impact rate is proportional to exp(-b^2 / (2 <x^2>)), which adds b^2 / (2 <x^2>) to its relative
    change.
    """
    missing: dict[str, float] = {}
    for creep in () if motion.is_thermal else motion.slow:
        for square, variance in creep.missing(time).items():
            missing[square] = missing.get(square, 0.0) + variance
    wider = WALL if motion.touched or motion.scales.guessed else 1.0
    rarer = {}
    for name, wall in motion.touched.items():
        if wall.inwards * (wall.position - motion.origin) < 0.0:  # beyond the equilibrium, which a preload is not
            own = values[motion.mean_square_of(f"{name}_impact_rate")]
            about_rest = motion.square_about_origin(values) if motion.origin else own
            rarer[name] = 0.5 * (wall.position - motion.origin) ** 2 / about_rest
    rarest = min(rarer.values(), default=0.0) if len(rarer) == len(motion.touched) else 0.0
    shares = {}
    for name in values:
        square = motion.mean_square_of(name)
        absent = wider * missing.get(square, 0.0)
        if name.endswith(("v_mean_square", "_power")):
            shares[name] = 0.0
        elif name == "amplitude_mean_square":
            shares[name] = min(1.0, absent / values[name])
        else:
            beyond = next((more for wall, more in rarer.items() if name == f"{wall}_impact_rate"), rarest)
            more = beyond if name.endswith(("x_mean", "elongation_mean", "impact_rate")) else 0.0
            weight = 1.0 if name == square else 0.5
            shares[name] = min(1.0, (weight + more) * absent / values[square]) if absent > 0.0 else 0.0
    return shares
