"""`simulate`: one simulation, from a system to results with standard errors."""

from __future__ import annotations

import inspect
import math
import platform
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import check_called
from springpot.machine.arrays import Floats
from springpot.machine.faults import few, listed, meant
from springpot.machine.installed import versions
from springpot.machine.progress import Clock, Estimate, FractionDone
from springpot.problem.basquin import Basquin
from springpot.problem.messages import Message, say
from springpot.problem.outputs import about_shocks, output_squares
from springpot.problem.system import System, owners_of
from springpot.simulation.estimate.samples import estimates_of, watched
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.estimate.step_biases import step_biases
from springpot.simulation.lowering.outputs import about_contacts
from springpot.simulation.paths.simulation import Ensemble, Simulation, simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.options import Derivative, Observable, Options, Progress, Scheme, StartKind, is_default
from springpot.simulation.plan.plan import Plan
from springpot.simulation.result.results import PROBABILITIES, Run, estimates_from
from springpot.simulation.result.warnings import (
    about_damage,
    about_forces,
    about_observables,
    about_options,
    about_quantiles,
    about_uncontrolled_impacts,
    doubts,
)
from springpot.simulation.watch.requested import OBSERVERS, Requested, from_the_start, plan_for, requested

_SAID_BY = {"no_stationary_state": "starts_from_rest", "transient_in_window": "window_from_rest"}
LONG = 1e9  # path-steps from which the time of a run is told before it: some seconds
P = ParamSpec("P")
R = TypeVar("R", bound="Run | list[Run]")


def door(function: Callable[P, R]) -> Callable[P, R]:
    """A function of users: of a wrong name it says which was meant, and it raises the warnings of its runs as Python's.

    They are raised at the line of the caller.
    """
    known = inspect.signature(function).parameters

    @wraps(function)
    def called(*args: P.args, **given: P.kwargs) -> R:
        for name in given:
            if name not in known:
                near = meant(name, known) or owners_of(name) or f"; there are {few(sorted(known))}."
                raise TypeError(f"there is no argument {name!r}{near}")
        found = function(*args, **given)
        for run in found if isinstance(found, list) else [found]:
            for sentence in run.warnings:
                warnings.warn(sentence, getattr(sentence, "category", UserWarning), stacklevel=2)
        return found

    return called


def quiet(function: Callable[P, R]) -> Callable[P, R]:
    """What is behind a `door`: its warnings are only in the result."""
    behind: Callable[P, R] = inspect.unwrap(function)
    return behind


@dataclass(frozen=True, eq=False)
class Arguments:
    """The arguments of `simulate`, by what they decide.

    Attributes
    ----------
    options : dict
    wishes : dict
        What observers are to find out.
    rtol : object
        None without it.
    of_rtol : dict
        What is given beside it.
    progress : callable, optional
    """

    options: dict[str, Any]
    wishes: dict[str, Any]
    rtol: Any
    of_rtol: dict[str, Any]
    progress: Progress | None


def arguments_of(given: Mapping[str, Any]) -> Arguments:
    """The arguments that were given, after a check that they can be given together."""
    usual = inspect.signature(simulate).parameters
    chosen = {name: value for name, value in given.items() if not is_default(value, usual[name].default)}
    progress, rtol = chosen.pop("progress", None), chosen.pop("rtol", None)
    check_called(progress, "progress")
    wishes = {name: chosen.pop(name) for name in OBSERVERS if name in chosen}
    options = {each.name: chosen.pop(each.name) for each in fields(Options) if each.name in chosen}
    if rtol is not None and wishes:
        other = next(iter(wishes))
        reason = "which controls moments only: use more paths, and compare with half the step"
        if other == "forces":
            reason = "which controls their mean squares: name these in quantities, such as acceleration_mean_square"
        raise ValueError(f"{other} cannot be given with rtol, {reason}.")
    if rtol is None and "max_time" in chosen:
        raise ValueError("max_time needs rtol: without it, paths and duration determine how long a run takes.")
    if rtol is None and chosen:
        raise ValueError("quantities has no effect without rtol, the relative error to which they must be known.")
    return Arguments(options, wishes, rtol, chosen, progress)


@dataclass(frozen=True, eq=False)
class Planned:
    """A run whose arguments are checked for its system; nothing has been computed.

    Attributes
    ----------
    system : System
    plan : Plan
    wanted : Requested
    options : dict
        As given.
    moved : list of Message
        What is said of the window.
    """

    system: System
    plan: Plan
    wanted: Requested
    options: dict[str, Any]
    moved: list[Message]

    def ready(self, progress: Progress | None) -> Ready:
        """With its start, which takes pilot runs, and prepared for the kernel."""
        begun = time.perf_counter()
        simulation = simulation_of(adapt(self.plan, progress=progress))
        return Ready(self, simulation, time.perf_counter() - begun)


def planned(system: System, arguments: Arguments) -> Planned:
    """Check the arguments for a system, and complete them."""
    options, wishes = arguments.options, arguments.wishes
    plan, moved = from_the_start(plan_for(system, options, wishes), wishes, options.get("window"))
    return Planned(system, plan, requested(plan, wishes), options, moved)


@dataclass(frozen=True, eq=False)
class Ready:
    """A run of which only the paths are lacking.

    Attributes
    ----------
    planned : Planned
    simulation : Simulation
    seconds : float
        That this took.
    """

    planned: Planned
    simulation: Simulation
    seconds: float

    @property
    def is_alone(self) -> bool:
        """Whether its paths cannot be advanced with those of other systems."""
        watched, recorded = self.planned.wanted.observers, self.simulation.settings.record
        return bool(watched or recorded or self.planned.system.with_functions)

    def alone(self, progress: Progress | None) -> Ensemble:
        """Its paths."""
        with _faults_of_own_forces(self.planned.system):
            return self.simulation.advance(observers=self.planned.wanted.observers, progress=progress)

    def run(self, ensemble: Ensemble, seconds: float) -> Run:
        """What its paths tell, which took so many seconds."""
        begun = time.perf_counter() - self.seconds - seconds
        system, simulation, wanted = self.planned.system, self.simulation, self.planned.wanted
        plan = simulation.plan
        seen = watched(simulation, ensemble.rows)
        values, errors = estimates_of(simulation, ensemble.rows, seen)
        results = {**wanted.read(simulation, ensemble)}
        means, estimates, unseen = (results.pop(kind) for kind in ("means", "estimates", "errors"))
        for name, (value, samples) in {**{name: (own.mean(), own) for name, own in means.items()}, **estimates}.items():
            values[name], errors[name] = float(value), standard_error(samples, strata=plan.motion.strata)
        errors |= unseen
        distributions, extremes = results.get("distributions", {}), results.get("extremes", {})
        biases = step_biases(plan.motion, plan.settings.step, values, distributions, extremes, PROBABILITIES)
        in_peaks = extremes or results.get("first_passages")
        chosen = [*about_options(plan, self.planned.options), *self.planned.moved]
        names = {message.name for message in chosen}
        said = [doubt for doubt, cause in _SAID_BY.items() if cause in names]
        counted = wanted.counts_instead(plan.motion)
        doubted = doubts(simulation, values, errors, ensemble.rows, seen, counted=counted)
        doubtful = (
            *chosen,
            *(own for own in doubted if own.name not in said),
            *about_quantiles(simulation, distributions, PROBABILITIES),
            *about_observables(means, values),
            *about_damage(estimates),
            *about_forces(simulation, wanted.seen_in_full(plan.settings), values),
            *about_shocks(system, wanted.output_names, values),
            *about_contacts(plan.motion, plan.settings.step, wanted.output_names if in_peaks else (), values),
            *(sentence for passage in results.get("first_passages", {}).values() for sentence in passage.warnings),
        )
        return Run(
            system=system,
            settings=plan.settings,
            estimates=estimates_from(system, values, errors, step_biases=biases),
            diagnostics=diagnostics_of(simulation, ensemble.rows, time.perf_counter() - begun),
            warnings=doubtful,
            time=plan.settings.recorded_times,
            record=ensemble.record,
            path_sums=ensemble.rows,
            adapted=plan.adapted,
            step_biases={name: bias for name, bias in biases.items() if isinstance(bias, np.ndarray)},
            **results,
        )


def _with_time(simulation: Simulation, progress: Progress | None) -> Progress | None:
    """The progress of a run, with the time that is left if it is long; it is told before the run begins."""
    settings = simulation.settings
    whole = float(settings.paths) * settings.steps
    if progress is None or whole < LONG:
        return progress
    clock = Clock(None)
    clock.measure(*simulation.timed())
    words = f"{settings.paths:,} paths of {settings.steps:,} steps"

    def told(fraction: float) -> None:
        left = (1.0 - fraction) * whole
        progress(FractionDone(fraction, Estimate(whole, clock.seconds(left), words, math.nan)))

    told(0.0)
    return told


@contextmanager
def _faults_of_own_forces(system: System) -> Iterator[None]:
    """An error that a user's own function raises is said with the name of the part."""
    if not system.with_functions:
        yield
        return
    from springpot.simulation.kernel.callbacks import caught  # loads Numba, which such a system needs

    with caught() as faults:
        yield
    if faults:
        own = listed(system.with_functions, "or")
        raise ValueError(f"the function of {own} failed during the run: {faults[0]!r}.") from faults[0]


def run_to(system: System, arguments: Arguments) -> Run:
    """A run with ``rtol``."""
    from springpot.simulation.error.reach import reach  # loaded for rtol only

    rtol, given = arguments.rtol, arguments.options
    chosen = sorted(set(given) - {"seed", "threads"})
    if chosen:
        raise ValueError(f"{chosen[0]} cannot be given with rtol, which chooses it; only seed and threads can.")
    begun = time.perf_counter()
    with _faults_of_own_forces(system):
        reached = reach(system, rtol, progress=arguments.progress, **arguments.of_rtol, **given)
    rows, seen = reached.rows, watched(reached.simulation, reached.rows)
    outputs = [name for square, name in output_squares(system).items() if square in reached.wanted]
    warned = [
        *about_shocks(system, outputs, reached.values),
        *doubts(reached.simulation, reached.values, reached.errors, rows, seen, bounded=True),
        *about_uncontrolled_impacts(reached, rtol),
        *([say("rtol_not_reached", sentence=reached.shortfall)] if reached.shortfall else []),
        *([reached.change.said] if reached.change else []),
    ]
    return Run(
        system=system,
        settings=reached.settings,
        estimates=estimates_from(system, reached.values, reached.errors, reached.budgets),
        diagnostics={
            **diagnostics_of(reached.simulation, rows, time.perf_counter() - begun),
            "pairs": reached.pairs,
            "path_steps": reached.path_steps,
            "held_up_by": reached.reason,
            "reached": not (reached.shortfall or reached.change),
        },
        warnings=tuple(warned),
        time=np.zeros(0),
        record=np.zeros((0, reached.settings.steps + 1, *reached.simulation.parts.shape_of_state)),
    )


@door
def simulate(
    system: System,
    *,
    rtol: float | None = None,
    quantities: Sequence[str] | None = None,
    max_time: float | None = None,
    observables: Mapping[str, Observable] | None = None,
    impact_observables: Mapping[str, Observable] | None = None,
    distributions: bool = False,
    spectrum: npt.ArrayLike | None = None,
    first_passage: Mapping[str, Any] | None = None,
    slowest_counted_impact: float | None = None,
    profile: npt.ArrayLike | None = None,
    forces: Sequence[str] | None = None,
    rainflow: Mapping[str, Basquin | Sequence[Basquin]] | None = None,
    paths: int | None = None,
    duration: float | None = None,
    step: float | None = None,
    window: tuple[float, float] | None = None,
    seed: int = Options.seed,
    threads: int | None = None,
    scheme: Scheme = Options.scheme,
    start: StartKind | None = None,
    initial_position: float | dict[str, float] | None = None,
    initial_velocity: float | dict[str, float] | None = None,
    derivative: Derivative = Options.derivative,
    memory_tolerance: float = Options.memory_tolerance,
    contact_tolerance: float = Options.contact_tolerance,
    record: int = Options.record,
    record_every: int | None = None,
    progress: Progress | None = None,
) -> Run:
    """Monte Carlo: response levels, impact rate, impact speeds and powers, each with its standard error.

    Parameters
    ----------
    system : System
    rtol : float
        Total relative error of each of ``quantities``, in [1e-4, 0.5]: paths, duration, step, start and window are
        chosen so that the error is below it.  The total error is 95 % of the sampling error, plus bounds on what step,
        memory and start leave.  Of the arguments below only ``seed`` and ``threads`` can be given as well.
    quantities : sequence of str
        Quantities that ``rtol`` controls; ``("amplitude_mean_square",)`` if left out, or ``("v_mean_square",)`` where
        the linear springs have no positive stiffness; of several masses all mean square displacements and velocities.
        Mean squares of forces and accelerations can be among them, ``"acceleration_mean_square"``.
    max_time : float
        With ``rtol``: seconds after which the run ends, with a warning if the tolerance is not reached.  It ends after
        a whole round of paths; the number of rounds depends on the machine.  A compilation, up to half a minute,
        counts too.
    observables : dict
        Names and functions f(t, x, v) of numbers, in s, m and m/s, that Numba can compile: each is averaged over the
        window and comes back under its name, with its standard error.  With several masses the names of the arguments
        say what they are: ``t``, ``box_x``, ``box_v``, ``mount_elongation``.  Any names of ``forces`` can be among
        them, half a step before x and v, and then ``t``, ``x`` and ``v`` of one mass are named too.
    impact_observables : dict
        Names and functions f(speed) of the speed just before an impact: each is summed over the impacts in the window
        and comes back per second.  The argument is called ``speed``, on any wall, or ``stop_impact_speed``, on that
        one.  Where noise keeps a mass pressed on a wall, its hops within a step are counted by ``impact_rate``, but are
        no impacts here.
    distributions : bool
        Whether to estimate distributions of x, v, amplitude (sqrt(x^2 + v^2 / Omega^2)) and impact speed in the window,
        and the extremes of each path in it.  With several masses there are those of x and v of each, of the elongation
        of each pair and of the impact speed of each wall.  Of ``forces`` too.
    spectrum : array_like
        Frequencies in rad/s at which to estimate the spectral density of x in the window; with several masses that of
        each and of the elongation of each pair.  Of ``forces`` too.
    first_passage : dict
        Quantities whose first passage through a level is recorded, or through each of a list of levels, such as
        ``{"x": [0.01, 0.012]}``.  ``"x"`` (m) and ``"v"`` (m/s) are passed away from where the run starts.  A pair in
        brackets, ``(-0.01, 0.012)``, is an interval of them that is left on either side.  ``"distance"`` (m) is the
        size of x, or of x - reference with ``{"level": 0.004, "reference": 0.006}``, and ``"speed"`` (m/s) the size of
        v.  ``"amplitude"`` (m) is sqrt(x^2 + v^2 / w^2) with w the ``resonance`` of the problem, and ``"energy"``
        (m^2/s^2) is (v^2 + Omega^2 x^2) / 2.  Any other name is an observable's, with a pair of a function f(t, x, v)
        and its level or levels.  With several masses there are ``"box_x"``, ``"box_v"``, ``"box_distance"`` and
        ``"box_speed"``, and of a part or a pair ``"mount_elongation"`` and ``"mount_distance"``, the size of it.  Any
        name of ``forces`` can be given: a level that is not negative is passed upwards.  Times count from the start of
        the window; from rest the window is the whole run if left out.
    slowest_counted_impact : float
        A speed in m/s: ``counted_impact_rate`` and the ``counted_`` speeds are those of the impacts at this speed or
        faster, ``stop_counted_impact_rate`` those of one wall or contact.  They exist also where
        the rate of all impacts is infinite.
    profile : int or array_like
        For motions that are not stationary: a number of equal bins of time in the window, or the times in s between
        them.  Each bin has the mean and the mean square of x, the mean square of v, impact rate and mean impact speed,
        the powers of excitations, dampers and rigid walls, and the mean and the mean square of ``forces``.  The times
        are rounded to four steps; from rest the window is the whole run if left out.
    forces : sequence of str
        Forces and absolute accelerations whose mean and mean square are wanted.  ``"mount_force"`` is that of a part or
        of a group of parts, and ``"force_on_ground"`` that of all.  ``"acceleration"`` includes that of the ground;
        with several masses it is ``"box_acceleration"``.  A soft contact has ``"stop_force"``, with which it pushes,
        and ``"stop_peak_force"``, the largest one of each touch.  A rigid wall has ``"stop_impulse"`` of each impact,
        which is in no force.  They are means over the step; where noise is white, the mean square is corrected for
        this.  What has no finite mean square is refused with the reason: an acceleration with white noise on a mass
        itself, or a force with the matched noise of its part.  With ``distributions``, ``spectrum``, ``profile`` and
        ``record`` there are these of them too.
    rainflow : dict
        Names of displacements, elongations, forces and accelerations, each with a `Basquin` curve or a list of them:
        ``{"x": sp.Basquin(5.0, strength=0.01), "mount_force": [...]}``.  Their cycles in the window are counted while
        the simulation runs, and their damage is added up.
    paths : int
        Independent sample paths; 5000 if left out.
    duration : float
        Simulated time in s; if left out, 100 / Omega or longer, so that half of it outlasts the transient.
    step : float
        Time step in s, shortened to divide the duration.  It is at most half of the shortest time scale, 1 / Omega or
        C^(-1 / (2 - alpha)); at most 2.5 of it where the step has no error in stationary averages (a dashpot, white
        noise, no losses at the wall).  If left out, it is the longest whose bias in mean squares, impact rates and
        speeds is below 0.3 %, about: a tenth of that time scale.  Behind lossy walls under white noise it is as much
        less as slow impacts ask for, down to a hundredth.  It is a hundredth for distributions there, for cycles of
        forces and under records alone.  A spectrum is resolved.  The scheme ``"grunwald"`` has a thousandth.
    window : (float, float)
        Averages are taken over window[0] < t <= window[1]; the second half of the run if left out.
    seed : int
        0 <= seed < 2^64.  The same seed gives the same bits for any number of threads.  Runs of different systems with
        one seed have common random numbers: path n of each has the same normals.  So a difference of two systems is
        known better than each of them, but an average over systems is not better for their number.  Give each its own
        seed where errors must be independent, as `springpot.evidence.comparison.compare`, studies and fits do.
    threads : int
        All available ones if left out.
    scheme : {"default", "grunwald"}
        ``"default"``: exact flight of the bare oscillator, impacts in it, between impulses of memory and noise.
        ``"grunwald"``: the paper's Monte Carlo (Grunwald-Letnikov derivative, Euler step, impact when x is within
        ``contact_tolerance`` of the wall or beyond it and moves towards it), for the paper's problem only.
    start : {"stationary", "rest"}
        ``"stationary"`` sets x(0) to the stationary mean, of all masses, so that the memory has no transient of the
        mean.  Pilot runs determine it, and the standard errors of the moments include a bound on the error of x(0).
        ``"rest"`` starts from x(0) and x'(0).  If left out, the start is stationary, with two exceptions.  A run whose
        ``initial_position`` or ``initial_velocity`` is given, or whose derivative is Riemann-Liouville's, starts from
        that state.  A run without a stationary state starts from rest, with a warning.
    initial_position, initial_velocity : float, or dict of float
        x(0) in m and x'(0) in m/s, with ``start="rest"``.  If left out, x(0) is the equilibrium, or the wall if the
        equilibrium lies behind it, and x'(0) is 0.  Of several masses a dict of points and numbers, as
        ``{"box": 0.01}``, 0 where a point is not named; if left out, they start as near to the equilibrium as walls
        allow.
    derivative : {"caputo", "riemann-liouville"}
        Differ by the force C x(0) t^-alpha / Gamma(1 - alpha), hence only if x(0) is not 0, and not at order 0, where
        both are x itself.  Riemann-Liouville's needs ``start="rest"``.
    memory_tolerance : float
        Relative error of the memory's exponential sum, in [1e-13, 1e-2]; 1e-6 if left out.  Below 1e-7 the memory is
        kept in double precision.
    contact_tolerance : float
        The paper's epsilon in m, 1e-5 if left out; ``"grunwald"`` only.
    record : int
        Number of paths to store (variables ``x`` and ``v``, and those of ``forces``, half a step before); none if left
        out.
    record_every : int
        Steps between two stored points; 1 if left out.  At most 50 million points are stored.
    progress : callable
        Called with the fraction done, from any thread.  With ``rtol``, or from 1e9 path-steps on, that float also has
        the attribute ``estimate`` (None before the pilot runs are over).  It has ``path_steps``, ``seconds`` still to
        come, ``reason`` for what takes the time, and with ``rtol`` ``aim``, the relative error that can be reached.

    Returns
    -------
    Run
        ``run["x_mean"]`` is an estimate with its value, error, bounds and unit; ``run.to_xarray()`` is a Dataset of
        all, where each has a twin ``_se``.  Forces and powers are those of the mass, or per unit mass without one.

        - Always: ``x_mean``, ``x_mean_square``, ``v_mean_square``, with a linear spring ``amplitude_mean_square``
          (x^2 + v^2 / Omega^2); ``damping_force_mean``, ``damping_power`` and ``damping_virial`` (springpots, dashpots,
          arms and circuits together); ``input_power``, the ``..._power`` of each nonlinear damper and of each force
          that is not white, ``energy_residual``; and the ``_end`` values at the end of the run.
        - With walls or contacts: ``impact_rate``, ``impact_speed_mean``, ``impact_speed_mean_square``, and over the
          dimension ``barrier`` (walls and contacts) ``barrier_impact_rate``, ``barrier_impact_speed_mean``,
          ``barrier_power`` and ``barrier_force_mean`` (the mean force on each, its momentum per time).
        - With circuits: ``harvested_power`` and each ``..._voltage_mean_square``.
        - With soft contacts: ``contact_share`` (of time) and ``contact_penetration`` (deepest of each path, averaged
          over the paths).
        - With ``slowest_counted_impact``: ``counted_impact_rate`` and its speeds.
        - With ``forces``: ``_mean`` and ``_mean_square`` of each.
        - With ``rainflow``: ``_cycle_rate``, ``_damage_rate`` (per hour) and ``_life`` (in hours; of several curves
          ``_life_1``, ``_life_2``) of each, and the distributions of its ranges, maxima and minima, ``_range``,
          ``_peak`` and ``_valley``.
        - The observables.
        - With ``distributions``: ``_density`` over ``_bin`` and ``_quantile`` over ``probability`` of each, also of the
          extremes ``x_minimum``, ``x_maximum``, ``v_largest``, ``impact_speed_largest`` over the paths.
        - With ``spectrum``: ``x_spectrum`` (two-sided, per rad/s) over ``frequency``.
        - With ``first_passage``, of each quantity: ``_first_passage_mean``, ``_first_passage_restricted_mean`` (of the
          time cut off at the end of the run), ``_first_passage_censored`` (share that has not passed),
          ``_first_passage_at_start``; ``_first_passage_probability`` (by the end of the run), ``_first_passage_rate``
          (from when it is constant) and ``_first_passage_return_period``, all three with ``_low`` and ``_high``;
          ``_first_passage_quantile`` over ``probability`` and ``_first_passage_survival`` over
          ``..._first_passage_time``; all of them also over ``..._first_passage_level`` if there is a list.

        The error of a rate is a bound where no impact was seen: 1.96 of it are 3 / (paths x length of the window).
        Impact rate and speeds, force and power of a wall, the quantiles of the impact speed and of the largest speed,
        and the density of the impact speed also have ``_step_bias``, a bound on what the step leaves.  With ``rtol``
        the means have ``_step_bias``, ``_memory_bias``, ``_transient`` and their total ``_error``.  The Dataset has the
        attributes ``system``, ``settings``, ``diagnostics`` (JSON) and ``warnings``.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; nothing has been computed then.
    TimeoutError
        If ``max_time`` is too short for any result.

    Warns
    -----
    SpringpotWarning
        For each sentence of ``warnings``, of its category (`springpot.AccuracyWarning`, ...).

    Notes
    -----
    An oscillator obeys the paper's Eq. 1 above a wall; with ``free_side="below"`` its law is the mirror image.
    Other systems have Caputo's derivative.

    A system of several masses starts at the stationary means of all where a springpot remembers one of them, otherwise
    in equilibrium, or with thermal noise alone from Boltzmann's law; masses that walls alone hold start in motion
    between them. Its shortest time scale is that of the highest frequency of its free motions. Its results are those of
    each mass by its name, ``box_x_mean_square``, in the dataset over the dimension ``point``;
    ``panel_box_elongation_mean_square`` of each pair of masses with a part between them; impact rate, speeds, power and
    force of each wall; ``damping_power`` and the balance of energy; and on request ``box_x_density``,
    ``panel_box_elongation_quantile``, ``box_x_spectrum`` and so on. With ``rtol`` the means are not offered that are 0
    by symmetry, and the rate of impacts on a lossy wall has those that are too slow for the step.

    Memory use is about 230 bytes per path, whatever the number of steps.

    Examples
    --------
    >>> import springpot as sp
    >>> oscillator = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0))
    >>> run = sp.simulate(oscillator, paths=2000, duration=60.0, step=0.05, window=(20.0, 60.0))
    >>> abs(run["amplitude_mean_square"].value - 1.0) < 0.05
    True

    What a harvester with a damping of 0.1 per second gains, and how fast the fastest tenth of the impacts is:

    >>> run = sp.simulate(
    ...     oscillator, paths=2000, duration=60.0, step=0.05, window=(20.0, 60.0),
    ...     observables={"harvested": lambda t, x, v: 0.1 * v * v}, distributions=True,
    ... )
    >>> abs(run["harvested"].value - 0.05) < 0.0025
    True
    >>> bool(run.distributions["impact_speed"].quantile(0.95)[0] > run["impact_speed_mean"].value)
    True

    Two buildings that pound, 5 cm apart, and the power that this takes:

    >>> pair = sp.System(
    ...     sp.Mass(2e5, at="old"), sp.Mass(4e5, at="new"), sp.Spring(8e6, between=("ground", "old")),
    ...     sp.Spring(6e6, between=("ground", "new")), sp.Dashpot(1e5, between=("ground", "old")),
    ...     sp.Dashpot(1e5, between=("ground", "new")), sp.WhiteNoise(0.1, on="ground"),
    ...     gap=sp.Barrier(-0.05, 0.6, between=("old", "new")),
    ... )
    >>> pounding = sp.simulate(pair, paths=64, duration=100.0)
    >>> pounding["gap_power"].value > 0.0, pounding["new_x_mean_square"].unit
    (True, 'm2')

    A system in SI units, and the power that each of its two walls takes:

    >>> walls = sp.Barrier(-0.003, 0.8), sp.Barrier(0.004, 0.8, free_side="below")
    >>> springs = sp.Spring(80.0), sp.PolynomialSpring((0.0, 0.0, 4e5))
    >>> device = sp.System(sp.Mass(0.2), *springs, sp.Springpot(0.5, 1.2), sp.WhiteNoise(1e-3), *walls)
    >>> run = sp.simulate(device, paths=200, duration=10.0)
    >>> run["barrier_1_power"].unit, run["barrier_2_power"].value > 0.0
    ('W', True)
    """
    given = {name: value for name, value in locals().items() if name != "system"}
    arguments = arguments_of(given)
    if arguments.rtol is not None:
        return run_to(system, arguments)
    ready = planned(system, arguments).ready(arguments.progress)
    begun = time.perf_counter()
    ensemble = ready.alone(_with_time(ready.simulation, arguments.progress))
    return ready.run(ensemble, time.perf_counter() - begun)


simulated = quiet(simulate)


def diagnostics_of(simulation: Simulation, rows: Floats, seconds: float) -> dict[str, Any]:
    """How a run was computed; ``rows`` are the sums of its paths."""
    from llvmlite.binding import get_host_cpu_name
    from numba.core.config import CPU_NAME

    settings, memory, adapted = simulation.settings, simulation.parts.history, simulation.plan.adapted
    return {
        "steps": settings.steps,
        "memory_terms": int(memory.rates.size),
        "memory_error": memory.relative_error,
        "memory_precision": settings.precision,
        "start_residual": None if adapted is None else adapted.residual,
        "start_residual_se": None if adapted is None else adapted.residual_se,
        "pilot_runs": None if adapted is None else adapted.pilots,
        **{name: int(simulation.parts.sums(rows)["limit", name].sum()) for name in ("collapses", "halts")},
        "seconds": seconds,
        "cpu": CPU_NAME or get_host_cpu_name(),
        "versions": versions("numba", "llvmlite", "numpy") | {"python": platform.python_version()},
    }
