"""The settings of a run, checked and completed before the simulation starts."""

from __future__ import annotations

import math
import numbers
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Unpack, cast, get_args

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import shown
from springpot.machine.processors import threads_available
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import (
    ColoredNoise,
    Force,
    Harmonic,
    KanaiTajimiNoise,
    PoissonImpulses,
    RecordedExcitation,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.system import System
from springpot.simulation.plan.options import DEFAULTS, Derivative, Options, Scheme, StartKind
from springpot.simulation.plan.scales import Scales, scales_of
from springpot.simulation.plan.schemes import NumericalScheme, scheme_of
from springpot.simulation.plan.system_scales import scales_of_problem, system_scales, typical_frequency
from springpot.theory.result import NoStationaryStateError

__all__ = [
    "Settings",
    "check_stationary",
    "checked_seed",
    "checked_threads",
    "default_start",
    "keeps_the_law",
    "resolve",
    "whole_number",
]

TOO_FAR_APART = "the problem's numbers must be closer together: double precision does not hold its motion."
MOST_STEPS = 100_000_000
LONGEST_DEFAULT = 2_000_000  # steps
MOST_PATHS = 50_000_000  # 5.6 GB of sums
MOST_RECORDED = 50_000_000
LONGEST_SINGLE = 5_000_000  # steps; in longer runs the rounding of single-precision memory would be visible
SINGLE_PRECISION = 1e-7  # memory tolerance below which the memory is kept in double precision
_WHOSE = ("an oscillator whose fastest rate (the larger of Omega and C^(1/(2-alpha)))", "a system whose fastest rate")
COARSEST = 0.5  # largest step * fastest rate that is accepted
COARSEST_EXACT = 2.5  # where the step has no error (`keeps_the_law`): a half step is less than a quarter of a cycle


@dataclass(frozen=True)
class Settings:
    """All settings of a run, given and default.  Made by :func:`resolve`.

    Attributes
    ----------
    paths : int
    duration, step : float
        In s; the step divides the duration.
    window : tuple of float
        Averages are taken over window[0] < t <= window[1], both whole numbers of steps.
    seed : int
    threads : int
    scheme : {"default", "grunwald"}
    start : {"rest", "stationary"}
        ``"rest"`` is also the start of a run whose initial state was given.
    initial_position, initial_velocity : float
        x(0) and x'(0), in m and m/s; x(0) of a stationary start is None until its pilot runs are over.
    derivative : {"caputo", "riemann-liouville"}
        They differ by x(0) t^-alpha / Gamma(1 - alpha).
    memory_tolerance : float
        Relative error allowed in the exponential sum of the memory.
    contact_tolerance : float
        The paper's epsilon, in m; used by the ``grunwald`` scheme only.
    record : int
        How many paths are stored.
    record_every : int
        Steps between two stored points of a path.
    """

    paths: int
    duration: float
    step: float
    window: tuple[float, float]
    seed: int
    threads: int
    scheme: Scheme = "default"
    start: StartKind = "stationary"
    initial_position: float | None = None
    initial_velocity: float = 0.0
    derivative: Derivative = "caputo"
    memory_tolerance: float = DEFAULTS["memory_tolerance"]
    contact_tolerance: float = DEFAULTS["contact_tolerance"]
    record: int = 0
    record_every: int = 1

    @property
    def numerical_scheme(self) -> NumericalScheme:
        """The scheme that ``scheme`` names."""
        return scheme_of(self.scheme, self.contact_tolerance)

    @property
    def steps(self) -> int:
        """Number of steps of the run."""
        return round(self.duration / self.step)

    @property
    def window_steps(self) -> tuple[int, int]:
        """First step of the window, and the first one after it (step n ends at (n + 1) h)."""
        return round(self.window[0] / self.step), round(self.window[1] / self.step)

    @property
    def recorded_points(self) -> int:
        """Points stored of each recorded path, that at time 0 included."""
        return self.steps // self.record_every + 1

    @property
    def recorded_times(self) -> npt.NDArray[np.float64]:
        """Times of the recorded points, in s; empty if no path is recorded."""
        return self.step * np.arange(0, self.steps + 1 if self.record else 0, self.record_every, dtype=np.float64)

    @property
    def precision(self) -> str:
        """NumPy's name of the type in which memory modes are kept."""
        return "float32" if self.memory_tolerance >= SINGLE_PRECISION and self.steps <= LONGEST_SINGLE else "float64"

    def to_dict(self) -> dict[str, Any]:
        """All settings as plain numbers, words and lists."""
        return {**asdict(self), "window": list(self.window)}


def default_duration(problem: Oscillator | System, scales: Scales, step: float) -> float:
    """100 / Omega (as in the paper), or 20 relaxation times if that is longer; at most 1e4 / Omega and 2 million steps.

    A slower oscillator needs an explicit ``duration``.
    """
    frequency = typical_frequency(problem)
    long_enough = 20.0 * scales.relaxation_time
    wanted = 100.0 / frequency if math.isinf(long_enough) else max(100.0 / frequency, long_enough)
    return min(wanted, 1e4 / frequency, LONGEST_DEFAULT * step)


def resolve(problem: Oscillator | System, **given: Unpack[Options]) -> Settings:
    """Check the given arguments and complete them with defaults.

    Raises
    ------
    TypeError, ValueError
        One sentence that names the argument, what is wrong with it and what would be right.
    """
    if not isinstance(problem, Oscillator | System):
        raise TypeError(f"oscillator must be an Oscillator or a System, not {shown(problem)}.")
    options = cast(Options, {**DEFAULTS, **given})
    _one_of(options["scheme"], "scheme", get_args(Scheme))
    _one_of(options["derivative"], "derivative", get_args(Derivative))
    if isinstance(problem, System) and (options["scheme"], options["derivative"]) != ("default", "caputo"):
        name, word = ("derivative", "caputo") if options["scheme"] == "default" else ("scheme", "default")
        raise ValueError(f"{name} must be {word!r} for a system that is no Oscillator.")
    start = options["start"]
    if start is None:
        start, _ = default_start(problem, options)
    _one_of(start, "start", get_args(StartKind))
    paths = whole_number(options["paths"], "paths", 1, MOST_PATHS)
    seed = checked_seed(options["seed"])
    threads = checked_threads(options["threads"])
    whole = _record_of(problem)
    wanted = whole if options["duration"] is None else options["duration"]
    duration, step, steps = _grid(problem, wanted, options["step"], options["scheme"])
    window = _window((0.0, duration) if whole and options["window"] is None else options["window"], duration, step)
    record, record_every = _record(options["record"], options["record_every"], paths, steps)
    position = _initial_position(problem, options["initial_position"], start, options["derivative"])
    return Settings(
        paths=paths,
        duration=duration,
        step=step,
        window=window,
        seed=seed,
        threads=threads,
        scheme=options["scheme"],
        start=start,
        initial_position=position,
        initial_velocity=_initial_velocity(options["initial_velocity"]),
        derivative=derivative_at(problem, options["derivative"]),
        memory_tolerance=finite_number(options["memory_tolerance"], "memory_tolerance", low=1e-13, high=1e-2),
        contact_tolerance=finite_number(options["contact_tolerance"], "contact_tolerance", low=0.0, high=LARGEST),
        record=record,
        record_every=record_every,
    )


def _record_of(problem: Oscillator | System) -> float | None:
    """The length of the longest recorded excitation, which is that of the run and of its window."""
    records = [] if isinstance(problem, Oscillator) else [record.duration for record in problem.of(RecordedExcitation)]
    return max(records, default=None)


def default_start(problem: Oscillator | System, given: Options = DEFAULTS) -> tuple[StartKind, str]:
    """The start of a run without the argument ``start``, and the reason if there is no stationary state.

    The start is stationary, unless x(0), x'(0) or the Riemann-Liouville derivative is given, which mean a start from a
    given state, or there is no stationary state.

    Returns
    -------
    start : {"rest", "stationary"}
    reason : str
        Why there is no stationary state; otherwise empty.

    Examples
    --------
    >>> from springpot import Springpot
    >>> default_start(Oscillator()), default_start(Oscillator(), {"initial_position": 1.0})
    (('stationary', ''), ('rest', ''))
    >>> default_start(Oscillator(springpot=Springpot(0.5, 0.0)))[0]
    'rest'
    """
    options = {**DEFAULTS, **given}
    if any(options[name] != DEFAULTS[name] for name in ("initial_position", "initial_velocity", "derivative")):
        return "rest", ""
    if isinstance(problem, System) and problem.of(RecordedExcitation):
        return "rest", ""
    if reason := _not_stationary(problem):
        return "rest", reason
    return "stationary", ""


def _not_stationary(problem: Oscillator | System) -> str:
    """Why there is no stationary state; empty if there is one."""
    if isinstance(problem, System):
        return _system_not_stationary(problem)
    oscillator = problem
    if oscillator.excitation.intensity == 0.0:
        return "without noise the motion dies out"
    if math.isinf(scales_of(oscillator).energy_time):
        return "order 0 or coefficient 0 with an elastic wall (or none) dissipates nothing; the energy grows as q t / 2"
    return ""


def _system_not_stationary(system: System) -> str:
    kinds = (WhiteNoise, ColoredNoise, KanaiTajimiNoise, PoissonImpulses, ThermalNoise, Harmonic, VanDerPol)
    sizes = [getattr(part, "intensity", getattr(part, "amplitude", 1.0)) for part in system.of(*kinds)]
    if system.of(RecordedExcitation):
        return "a record has a beginning and an end"
    if not any(sizes) and not system.of(Force):
        return "without excitation the motion dies out"
    if math.isinf(system_scales(system).energy_time):
        return "nothing takes energy from the motion"
    return ""


def check_stationary(problem: Oscillator | System, who: str) -> None:
    """Raise an error if there is no stationary state; ``who`` is the argument or command that needs one.

    Raises
    ------
    ValueError
        If the intensity is 0.
    NoStationaryStateError
        If nothing dissipates energy.

    Examples
    --------
    >>> check_stationary(Oscillator(), "rtol")
    """
    reason = _not_stationary(problem)
    if reason and isinstance(problem, Oscillator) and problem.excitation.intensity == 0.0:
        raise ValueError(f"intensity must be positive with {who}: {reason}.")
    if reason:
        raise NoStationaryStateError(f"{who} needs a stationary state, and there is none: {reason}.")


def _initial_velocity(given: float | None) -> float:
    return 0.0 if given is None else finite_number(given, "initial_velocity", low=-LARGEST, high=LARGEST)


def keeps_the_law(problem: Oscillator | System, scheme: Scheme) -> bool:
    """Whether a scheme leaves the stationary law of this problem as it is, however long the step.

    Stationary averages at the steps, and of impacts, then have no error of the step (`NumericalScheme.keeps_the_law`).

    Examples
    --------
    >>> from springpot import Springpot
    >>> keeps_the_law(Oscillator(springpot=Springpot(1.0, 0.3)), "default"), keeps_the_law(Oscillator(), "default")
    (True, False)
    """
    return (
        isinstance(problem, Oscillator)
        and scheme_of(scheme).keeps_the_law
        and problem.springpot.order == 1.0
        and problem.springpot.coefficient > 0.0
        and problem.excitation.intensity > 0.0
        and (problem.barrier is None or problem.restitution == 1.0)
    )


def _grid(
    problem: Oscillator | System, duration: float | None, step: float | None, scheme: Scheme
) -> tuple[float, float, int]:
    if duration is not None:
        duration = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is the time simulated, in s.")
    scales = scales_of_problem(problem)
    fastest = scales.fastest_rate
    if not 0.0 < fastest < math.inf:
        raise ValueError(TOO_FAR_APART)
    if step is None:
        step = min(scheme_of(scheme).default_step / fastest, math.inf if duration is None else duration)
    else:
        step = finite_number(step, "step", low=0.0, open_low=True, hint="It is the time step, in s.")
    if duration is None:
        duration = default_duration(problem, scales, step)
        if not duration > 0.0:
            raise ValueError(TOO_FAR_APART)
    if step > duration:
        raise ValueError(f"step must not be longer than the duration of {duration:g} s, but it is {step:g} s.")
    coarsest = COARSEST_EXACT if keeps_the_law(problem, scheme) else COARSEST
    if step * fastest > coarsest:
        raise ValueError(
            f"step is {step:g} s, too coarse for {_WHOSE[isinstance(problem, System)]} is "
            f"{fastest:g} per s: use at most {coarsest / fastest:.3g} s, or about "
            f"{0.01 / fastest:.3g} s for errors well below 1 %."
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


def _record(record: int, every: int | None, paths: int, steps: int) -> tuple[int, int]:
    """How many paths are stored, and every how many steps."""
    record = whole_number(record, "record", 0, paths)
    if every is not None and record == 0:
        raise ValueError("record_every has no effect without record, the number of paths to store.")
    every = 1 if every is None else whole_number(every, "record_every", 1, steps)
    if record * (steps // every) > MOST_RECORDED:
        wanted = math.ceil(record * steps / MOST_RECORDED)
        fewer = MOST_RECORDED // (steps // every)
        advice = f"record_every={wanted} or more" if wanted <= steps else ""
        if fewer > 0:
            advice += f"{' or ' if advice else ''}at most {fewer} paths"
        raise ValueError(
            f"record asks for {record} paths of {steps // every} points, but at most {MOST_RECORDED:,} points are "
            f"stored: use {advice}."
        )
    return record, every


def _initial_position(
    problem: Oscillator | System, given: float | None, start: StartKind, derivative: Derivative
) -> float | None:
    if start == "stationary":
        if given is not None:
            raise ValueError("initial_position cannot be given with start='stationary', which finds x(0) itself.")
        if derivative != "caputo":
            raise ValueError(
                "derivative must be 'caputo' with start='stationary': the memory of this start is adapted to x(0)."
            )
        check_stationary(problem, "start='stationary'")
        return None
    if isinstance(problem, System):
        return _position_between(problem, given)
    oscillator, barrier = problem, problem.barrier
    if barrier is None:
        return 0.0 if given is None else finite_number(given, "initial_position", low=-LARGEST, high=LARGEST)
    sign = oscillator.direction
    if given is None:
        return sign * max(sign * barrier.position, 0.0)  # at the equilibrium, or resting on the wall
    given = finite_number(given, "initial_position", low=-LARGEST, high=LARGEST)
    if sign * given < sign * barrier.position:
        wanted = "at least" if sign > 0.0 else "at most"
        raise ValueError(
            f"initial_position is {given:g}, behind the wall: it must be {wanted} {barrier.position:g} "
            f"(side={barrier.side!r})."
        )
    return given


def _position_between(system: System, given: float | None) -> float:
    """x(0) of a system: 0 or the wall beyond which 0 lies, if it is not given."""
    low, high = system.potential.low, system.potential.high
    if given is None:
        return min(max(0.0, low), high)
    position = finite_number(given, "initial_position", low=-LARGEST, high=LARGEST)
    if not low <= position <= high:
        raise ValueError(f"initial_position is {position:g}, behind a wall: it must lie between {low:g} and {high:g}.")
    return position


def derivative_at(problem: Oscillator | System, derivative: Derivative) -> Derivative:
    """The derivative used: at order 0 both are x, which is Riemann-Liouville's D^0 x."""
    spring = isinstance(problem, Oscillator) and problem.springpot.order == 0.0
    return "riemann-liouville" if spring else derivative


def checked_seed(seed: int) -> int:
    """A seed, if it is one.

    Raises
    ------
    TypeError, ValueError
        If it is not a whole number from 0 to 2^64 - 1.
    """
    return whole_number(seed, "seed", 0, 2**64 - 1)


def checked_threads(threads: int | None) -> int:
    """The number of threads to use: all available ones for None.

    Raises
    ------
    TypeError, ValueError
        If it is not a whole number from 1 to 4096.
    """
    return threads_available() if threads is None else whole_number(threads, "threads", 1, 4096)


def whole_number(value: object, name: str, low: int, high: int, hint: str = "") -> int:
    """``value`` as an int, or one sentence, and the hint, that names the argument and its range."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} must be a whole number, not {shown(value)}.{hint}")
    if not low <= int(value) <= high:
        raise ValueError(f"{name} must be in [{low}, {high}], not {value}.{hint}")
    return int(value)


def _one_of(value: object, name: str, words: tuple[str, ...]) -> None:
    if not isinstance(value, str) or value not in words:
        raise ValueError(f"{name} must be {' or '.join(map(repr, words))}, not {shown(value)}.")
