"""The probability that a quantity exceeds levels within a time, however small, and how often it does."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import NotCoveredError, few, meant, name_results, per_cent, shown, with_error
from springpot.machine.progress import Clock, OutOfTimeError
from springpot.problem.messages import Message, say
from springpot.problem.system import System, checked_system
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.paths.simulation import Progress, Simulation, simulation_of
from springpot.simulation.plan.options import StartKind
from springpot.simulation.plan.plan import Plan, plan_of
from springpot.simulation.plan.settings import MOST_STEPS, Settings
from springpot.simulation.rare.asked import UNITS, Asked, asked_of
from springpot.simulation.rare.splitting import Tally, repetitions

__all__ = ["Exceedance", "exceedance"]

Floats = npt.NDArray[np.float64]

EARLY = 2.0  # relaxation times before the time that counts from which on paths of a stationary start are split
SETTLED = 8.0  # relaxation times before the time that counts, of a stationary start: the tail feels a percent of x^2
REPETITIONS = 32  # first ones: fewer do not tell their own spread
PLAIN_PATHS, SPLIT_PATHS = 64, 256  # of a repetition
MOST_PATHS = 4096
FREQUENT = 0.01  # probability above which plain paths are cheaper
UNEVEN = 0.7  # standard deviation of the repetitions over their mean above which each gets more paths
LARGEST_SHARE = 0.3  # of one repetition in the sum of all, above which their spread says little
PATHS_AT_ONCE = 65536
MOST_PLAIN = 4_000_000  # paths, where splitting has nothing to split


@dataclass(frozen=True, eq=False)
class Exceedance:
    """Probabilities that quantities exceed levels within a time.

    Each dict has the name of a quantity and an array over its levels.

    Attributes
    ----------
    system : System
    settings : Settings
        Of the paths; those of a stationary start begin before the time that counts, which is ``settings.window``.
    levels : dict
        In the units of `units`.
    probability, error : dict
        That the largest value in the time exceeds the level, and its standard error.
    low, high : dict
        Ends of its 95 % interval; where no path exceeded a level, 0 and an upper bound.
    rate, rate_error : dict
        Of first exceedances in the second half of the time, per second, and its standard error.
    diagnostics : dict
        Of each quantity: ``method``, "plain" or "splitting"; ``repetitions`` and ``paths`` of each; ``spread``, the
        standard deviation of the repetitions over their mean at the last level; ``iterations``, ``path_steps``,
        ``seconds``.
    warnings : tuple of str
    """

    system: System
    settings: Settings
    levels: dict[str, Floats]
    probability: dict[str, Floats]
    error: dict[str, Floats]
    low: dict[str, Floats]
    high: dict[str, Floats]
    rate: dict[str, Floats]
    rate_error: dict[str, Floats]
    diagnostics: dict[str, dict[str, Any]]
    warnings: tuple[Message, ...] = ()

    def __post_init__(self) -> None:
        name_results(self, "levels", "probability", "error", "low", "high", "rate", "rate_error", "diagnostics")

    @property
    def return_period(self) -> dict[str, Floats]:
        """Mean time between exceedances in s, one over the rate; infinite where none was seen."""
        with np.errstate(divide="ignore"):
            return {name: np.where(rate > 0.0, 1.0 / rate, np.inf) for name, rate in self.rate.items()}

    @property
    def units(self) -> dict[str, str]:
        """The unit of the levels of each quantity."""
        return {name: UNITS[name] for name in self.levels}

    def __repr__(self) -> str:
        """What it holds; printed, it shows its numbers."""
        begin, end = self.settings.window
        held = ", ".join(f"{levels.size} levels of {name}" for name, levels in self.levels.items())
        return f"Exceedance({held} in {end - begin:g} s: {len(self.warnings)} warnings)"

    def __str__(self) -> str:
        lines = []
        for name, levels in self.levels.items():
            period = self.return_period[name].ravel()
            numbers = zip(*(each[name].ravel() for each in (self.levels, self.probability, self.error, self.high)), period)
            for level, p, error, high, again in numbers:
                said = with_error(p, error) if p > 0.0 else f"at most {high:.2g}"
                often = f", once in {again:.2g} s" if math.isfinite(again) else ""
                lines.append(f"{name} > {level:g} {UNITS[name]}: {said}{often}")
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
    memory_tolerance: float | None = None,
    seed: int = 1,
    threads: int | None = None,
    max_time: float | None = None,
    progress: Progress | None = None,
) -> Exceedance:
    """The probability that a quantity exceeds a level within a time, however small it is, for many levels at once.

    Rare events are reached by splitting: paths that come near to them are branched, and weighted so that every
    probability is right on average; events that are not rare are counted on plain paths.  Which of the two is cheaper,
    the first paths tell.

    Parameters
    ----------
    system : System
        Of one mass.
    levels : dict
        Quantities and their levels, one or many, such as ``{"x": [0.004, 0.005, 0.006]}``: ``"x"`` (m) and ``"v"``
        (m/s), upwards if the levels lie above the start, else downwards; ``"distance"`` (m), the size of x;
        ``"speed"`` (m/s), the size of v; ``"amplitude"`` (m), sqrt(x^2 + v^2 / w^2) with w the ``resonance``;
        ``"energy"`` (m^2/s^2), (v^2 + Omega^2 x^2) / 2; ``"impact_speed"`` (m/s), of the fastest impact.
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
    progress : callable
        Called with the fraction done, about.

    Returns
    -------
    Exceedance
        Printed, it is a table.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; nothing has been computed then.
    NotCoveredError
        Of several masses.
    TimeoutError
        If ``max_time`` is too short for any result.

    Warns
    -----
    SpringpotWarning
        For each sentence of ``warnings``.

    Notes
    -----
    With random phases, or a record among others, the probability is that over them too.

    A coarse step distorts a tail more than a mean: a relative error e of the mean square changes a probability at b
    standard deviations by about e b^2 / 2.

    Examples
    --------
    >>> import springpot as sp
    >>> system = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    >>> found = sp.exceedance(system, {"x": [3.2, 4.8]}, duration=20.0, start="rest", step=0.05, rtol=0.2)
    >>> bool(abs(found.probability["x"][1] / 8.9e-7 - 1.0) < 4 * 0.2), found.diagnostics["x"]["method"]
    (True, 'splitting')
    """
    checked_system(system)
    if len(system.points) > 1:
        raise NotCoveredError("exceedance is of systems of one mass.")
    rtol = finite_number(rtol, "rtol", low=0.01, high=1.0)
    if max_time is not None:
        max_time = finite_number(max_time, "max_time", low=0.0, open_low=True, hint="It is in seconds.")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress must be a function of the fraction done, not {shown(progress)}.")
    if duration is None:
        raise TypeError("duration must be a real number, not None: it is the time in s within which levels are exceeded.")
    given = {} if memory_tolerance is None else {"memory_tolerance": memory_tolerance}
    plan = plan_of(
        system, duration=duration, step=step, start=start, seed=seed, threads=threads,
        initial_position=initial_position, initial_velocity=initial_velocity, **given,
    )  # fmt: skip
    wanted = _checked(plan, levels)
    if not plan.motion.is_random:
        raise ValueError("system must have noise or a random phase: without, all its paths are alike.")
    clock = Clock(max_time)
    plan = _settled(plan)
    if plan.settings.start == "stationary":
        plan = adapt(plan)
    simulation = simulation_of(_split_early(plan))
    found = []
    for number, (name, (numbers, sign)) in enumerate(wanted.items()):
        own = Clock(clock.left / (len(wanted) - number))
        asked = asked_of(plan, simulation.parts, name, numbers[np.argsort(sign * numbers)], sign, *plan.settings.window_steps)
        told = (lambda _: None) if progress is None else (lambda f, n=number: progress((n + f) / len(wanted)))
        found.append(_Search(simulation, asked, rtol, own, told, 8 * number).found())
    warned, columns = [], {}
    for (name, (numbers, sign)), search in zip(wanted.items(), found, strict=True):
        order = np.argsort(np.argsort(sign * numbers.ravel()))
        shape = np.shape(levels[name])
        columns[name] = {key: value[order].reshape(shape) for key, value in search.columns().items()}
        warned += search.warnings(name, np.sort(sign * numbers) * sign)
    for sentence in warned:
        warnings.warn(sentence, sentence.category, stacklevel=2)
    return Exceedance(
        system,
        plan.settings,
        {name: numbers.reshape(np.shape(levels[name])) for name, (numbers, _) in wanted.items()},
        *({name: own[key] for name, own in columns.items()} for key in _COLUMNS),
        diagnostics={name: search.diagnostics() for name, search in zip(wanted, found, strict=True)},
        warnings=tuple(warned),
    )


_COLUMNS = ("probability", "error", "low", "high", "rate", "rate_error")


def _checked(plan: Plan, levels: object) -> dict[str, tuple[Floats, float]]:
    """The levels of each quantity, and the sign of the direction in which they are exceeded."""
    if not isinstance(levels, Mapping) or not levels:
        raise TypeError(f"levels must be a dict of names and levels, such as {{'x': [0.01, 0.02]}}, not {shown(levels)}.")
    return {name: _checked_levels(plan, name, given) for name, given in levels.items()}


def _checked_levels(plan: Plan, name: object, given: Any) -> tuple[Floats, float]:
    motion = plan.motion
    if not isinstance(name, str) or name not in UNITS:
        near = meant(str(name), UNITS) or f"; there are {few(UNITS)}."
        raise ValueError(f"levels has {shown(name)}, which is no quantity that can be asked{near}")
    if name == "impact_speed" and not motion.touched:
        raise ValueError("levels of impact_speed need a wall or a contact, and the system has none.")
    if name in ("amplitude", "energy") and not motion.system.natural_frequency > 0.0:
        raise ValueError(f"levels of {name} need a linear spring: use x, v, speed or distance.")
    words, signed = f"level of {name}", name in ("x", "v")
    listed = [given] if np.ndim(given) == 0 else [*np.ravel(np.asarray(given, object))]
    if not listed:
        raise ValueError(f"levels of {name} must not be empty.")
    low = -LARGEST if signed else 0.0
    numbers = np.array([finite_number(each, words, low=low, high=LARGEST, open_low=not signed) for each in listed])
    if not signed:
        return numbers, 1.0
    x, v = motion.start_of(motion.seen[0], plan.settings.initial_position, plan.settings.initial_velocity)
    if plan.settings.start == "stationary":
        x = motion.scales.mean
    start = x if name == "x" else float(v)
    sides = {math.copysign(1.0, number - start) for number in numbers if number != start}
    if len(sides) != 1 or (numbers == start).any():
        raise ValueError(
            f"levels of {name} must all lie on one side of the start, {start:.3g} {UNITS[name]}: ask for both in two calls."
        )
    if name == "x" and not ((motion.low < numbers) & (numbers < motion.high)).all():
        raise ValueError(f"levels of x must lie between the walls, {motion.low:g} and {motion.high:g} m.")
    return numbers, sides.pop()


def _settled(plan: Plan) -> Plan:
    """The plan with whole groups of steps, and before the time that counts the one that a stationary start takes."""
    settings, motion = plan.settings, plan.motion
    steps = -(-settings.steps // GROUP) * GROUP
    step, ahead = settings.duration / steps, 0
    if settings.start == "stationary":
        ahead = math.ceil((EARLY if motion.is_thermal else SETTLED) * motion.scales.relaxation_time / (GROUP * step)) * GROUP
    if steps + ahead > MOST_STEPS:
        raise ValueError(f"duration and {ahead * step:.3g} s before it, in which the motion settles, take too many steps.")
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


class _Search:
    """Repetitions of one quantity until their mean is known well enough."""

    def __init__(
        self, simulation: Simulation, asked: Asked, rtol: float, clock: Clock, told: Callable[[float], None], stream: int
    ) -> None:  # fmt: skip
        self.simulation, self.asked, self.rtol, self.clock, self.told = simulation, asked, rtol, clock, told
        self.stream, self.paths, self.splits = stream, PLAIN_PATHS, False
        self.tallies: list[Tally] = []
        self.reason, self.begun, self.path_steps = "", time.perf_counter(), 0.0

    def found(self) -> _Search:
        """Itself, when all is done."""
        try:
            self._add(REPETITIONS)
            if self.exceeded[:, 1, -1].mean() < FREQUENT and self.simulation.motion.is_noisy:
                self._restart(SPLIT_PATHS, True)
            while (more := self._lacking()) > 0:
                self._add(more)
        except OutOfTimeError:
            self.reason = f"max_time of {self.clock.limit:.3g} s is over"
            if not self.tallies:
                raise TimeoutError("max_time is too short for any result: the first paths have not ended.") from None
        return self

    def _restart(self, paths: int, splits: bool) -> None:
        before = self.tallies, self.paths, self.splits
        self.tallies, self.paths, self.splits, self.stream = [], paths, splits, self.stream + 1
        try:
            self._add(REPETITIONS)
        except OutOfTimeError:
            self.tallies, self.paths, self.splits = before
            raise

    def _add(self, count: int) -> None:
        done = sum(map(len, (tally.weights for tally in self.tallies)))
        steps = self.path_steps
        usual = 1.0 + max((float(tally.iterations.mean()) for tally in self.tallies), default=15.0)
        wanted = done + count

        def tell(iterations: float) -> None:
            self.told(min(0.99, (done + count * min(1.0, iterations / usual)) / wanted))

        while done < wanted:
            now = min(wanted - done, PATHS_AT_ONCE // self.paths)
            tally = repetitions(
                self.simulation, self.asked, first=done, count=now, paths=self.paths, stream=self.stream,
                splits=self.splits, clock=self.clock, tell=tell,
            )  # fmt: skip
            if tally.complete or not self.tallies:
                self.tallies.append(tally)
            steps += tally.path_steps
            self.path_steps = steps
            done += now
            if not tally.complete:
                raise OutOfTimeError

    def _lacking(self) -> int:
        """How many repetitions more are needed; with too large a spread, they begin again with more paths each."""
        p = self.exceeded[:, 1].mean(axis=0)
        while self.splits and self.paths < MOST_PATHS and (p[-1] == 0.0 or self.spread > UNEVEN):
            self._restart(4 * self.paths, True)
            p = self.exceeded[:, 1].mean(axis=0)
        done = len(self.exceeded)
        if not p[-1] > 0.0:
            more = 3 * done if not self.splits and self.paths * done < MOST_PLAIN else 0
            self.reason = "" if more else "no path exceeded it"
            return more
        off = float(np.max(self._error(self.exceeded[:, 1]) / p)) / self.rtol
        if off <= 1.0:
            return 0
        return min(max(math.ceil(done * (1.05 * off**2 - 1.0)), REPETITIONS // 4), 3 * done)

    @property
    def exceeded(self) -> Floats:
        """Of all repetitions, by half time and by the end, the probability of each level."""
        return np.concatenate([tally.exceeded for tally in self.tallies])

    @property
    def spread(self) -> float:
        """Standard deviation of the repetitions over their mean, at the last level."""
        last = self.exceeded[:, 1, -1]
        return float(last.std(ddof=1) / last.mean()) if last.mean() > 0.0 else math.inf

    @staticmethod
    def _error(samples: Floats) -> Floats:
        return np.asarray(samples.std(axis=0, ddof=1) / math.sqrt(len(samples)))

    def columns(self) -> dict[str, Floats]:
        """The results, in the order of rarity."""
        from scipy import special  # slow to import

        half, whole = self.exceeded.transpose(1, 0, 2)
        p, error, count = whole.mean(axis=0), self._error(whole), len(whole)
        t = float(special.stdtrit(count - 1, 0.975))
        with np.errstate(divide="ignore", invalid="ignore"):
            wide = np.exp(t * error / p)
            low, high = np.where(p > 0.0, p / wide, 0.0), np.where(p > 0.0, np.minimum(p * wide, 1.0), self._bound(t))
            rate = -2.0 / self.asked.duration * np.log((1.0 - p) / (1.0 - half.mean(axis=0)))
            rate_error = 2.0 / self.asked.duration * self._error(whole - half) / (1.0 - p)
        return dict(zip(_COLUMNS, (p, error, low, high, rate, rate_error), strict=True))

    def _bound(self, t: float) -> float:
        """On a probability of which nothing was seen."""
        weights = np.concatenate([tally.weights for tally in self.tallies])
        if not self.splits:
            return min(1.0, 3.0 / (self.paths * len(weights)))
        return min(1.0, float(weights.mean() + t * self._error(weights)))

    def diagnostics(self) -> dict[str, Any]:
        """How the results were found."""
        return {
            "method": "splitting" if self.splits else "plain",
            "repetitions": len(self.exceeded),
            "paths": self.paths,
            "spread": self.spread,
            "iterations": float(np.concatenate([tally.iterations for tally in self.tallies]).mean()),
            "path_steps": self.path_steps,
            "seconds": time.perf_counter() - self.begun,
        }

    def warnings(self, name: str, levels: Floats) -> list[Message]:
        """What there is to doubt."""
        p, error = self.columns()["probability"], self.columns()["error"]
        unit, said = UNITS[name], []
        if (p == 0.0).any():
            n = int(np.argmax(p == 0.0))
            said.append(say("level_not_reached", name=name, level=levels[n], unit=unit, most=self.columns()["high"][n]))
        elif (error > self.rtol * p).any():
            n = int(np.argmax(error / p))
            numbers = {"reached": per_cent(error[n] / p[n]), "rtol": per_cent(self.rtol), "reason": self.reason}
            said.append(say("rare_not_known", name=name, level=levels[n], unit=unit, **numbers))
        last = self.exceeded[:, 1, -1]
        if self.splits and last.sum() > 0.0 and (self.spread > 1.0 or last.max() > LARGEST_SHARE * last.sum()):
            most = per_cent(float(last.max() / last.sum()))
            said.append(say("uneven_repetitions", name=name, spread=self.spread, most=most))
        return said
