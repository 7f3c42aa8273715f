"""One simulation, from an oscillator to named numbers with standard errors."""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
import numpy.typing as npt

from springpot.faults import meant
from springpot.oscillator import Oscillator
from springpot.simulation.accuracy import Budget, Reached, reach
from springpot.simulation.adapted import Adapted, adapt, owed_to_the_start
from springpot.simulation.ensemble import Progress, Tables, advance, tables
from springpot.simulation.first_passage import from_the_start
from springpot.simulation.kernel import COLUMNS
from springpot.simulation.observers import EXTREMES, Distribution, sample_quantiles
from springpot.simulation.passage_times import PassageTimes
from springpot.simulation.settings import (
    Options,
    Settings,
    default_start,
    energy_time,
    fastest_rate,
    impacts_are_countable,
    mirror,
    relaxation_time,
    resolve,
)
from springpot.simulation.slow_impacts import missed_impacts, slow_impact_order
from springpot.simulation.spectral import Spectrum
from springpot.simulation.statistics import estimates, standard_error
from springpot.simulation.step_biases import about_quantiles, step_biases
from springpot.simulation.watched import Observable, watched
from springpot.simulation.without_effect import without_effect
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.units import UNITS

if TYPE_CHECKING:
    import xarray

__all__ = ["Run", "about_slow_impacts", "doubts", "is_stationary", "measured", "run", "simulate"]

FAR_OFF = 5.0  # standard errors of the energy balance beyond which a run is called into question
COARSE = {"default": 0.1, "grunwald": 0.005}  # step * fastest rate beyond which errors of 1 % are to be expected
MOST_RESIDUAL = 0.01  # of an adapted start
MOST_TRANSIENT = 0.01  # left where the window begins
MOST_REMEMBERED = 0.03  # mean force of the springpot over the spring's, in the window
MOST_MISSED = 0.01  # of the impacts, by estimate
_DEFAULT_QUANTITIES = ("amplitude_mean_square",)
_OWN_ARGUMENTS = (
    "rtol", "quantities", "observables", "impact_observables", "distributions", "spectrum", "first_passage", "progress",
)  # fmt: skip
PROBABILITIES = (0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999)  # of the quantiles in files


@dataclass(frozen=True, eq=False)
class Run:
    """The outcome of one simulation.

    Attributes
    ----------
    oscillator : Oscillator
    settings : Settings
        As completed; with an adapted start, ``initial_position`` is what was found.
    values, errors : dict
        Estimates and standard errors by name (`springpot.simulation.UNITS` has names and units).
    budgets : dict
        What each controlled estimate may be off by (`springpot.simulation.Budget`); empty unless ``rtol`` was given.
    diagnostics : dict
        How it was computed: memory terms and their error, adapted start and its residual, collapses, versions, time.
    warnings : tuple of str
        One sentence for each reason to doubt a number.
    time : ndarray, shape (points,)
        Times of the recorded paths, in s; empty if none were recorded.
    record : ndarray, shape (recorded, points, 2)
        x and v of the recorded paths, at time 0 and after every ``record_every`` steps.
    distributions : dict
        `springpot.simulation.Distribution` of x, v, amplitude and impact speed in the window, if they were asked for.
    extremes : dict
        Smallest and largest x, largest speed and impact speed of each path in the window, if they were asked for:
        arrays of shape (paths,), taken at the ends of the steps and at the impacts.
    spectrum : Spectrum or None
        `springpot.simulation.Spectrum` of x in the window, if it was asked for.
    first_passages : dict
        `springpot.simulation.PassageTimes` of each level that was asked for, by quantity.
    """

    oscillator: Oscillator
    settings: Settings
    values: dict[str, float]
    errors: dict[str, float]
    budgets: dict[str, Budget]
    diagnostics: dict[str, Any]
    warnings: tuple[str, ...]
    time: npt.NDArray[np.float64]
    record: npt.NDArray[np.float64]
    distributions: dict[str, Distribution] = field(default_factory=dict)
    extremes: dict[str, npt.NDArray[np.float64]] = field(default_factory=dict)
    spectrum: Spectrum | None = None
    first_passages: dict[str, PassageTimes] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Everything but the recorded paths, as plain numbers, words, lists and dicts; what is not a number is None.

        Returns
        -------
        dict
            Every estimate and its ``_se`` by name, then ``oscillator``, ``settings``, ``diagnostics`` and ``warnings``.
            Distributions and extremes are there as their quantiles at PROBABILITIES.

        Examples
        --------
        >>> found = run(Oscillator(), paths=1, duration=1.0).to_dict()
        >>> found["x_mean_se"] is None, found["settings"]["paths"]
        (True, 1)
        """
        quantiles = {name: (at.tolist(), error.tolist()) for name, (at, error, _) in self._quantiles().items()}
        biases = self._step_biases()
        return {
            **{name: value if math.isfinite(value) else None for name, (value, _, _) in self._numbers().items()},
            **({"probability": list(PROBABILITIES)} if quantiles else {}),
            **{name: _finite(at) for name, (at, _) in quantiles.items()},
            **{f"{name}_se": _finite(error) for name, (_, error) in quantiles.items()},
            **{f"{name}_step_bias": _finite(np.asarray(biases[name]).tolist()) for name in quantiles if name in biases},
            **({} if self.spectrum is None else _spectrum_words(self.spectrum)),
            **{name: _finite(column.tolist()) for name, (_, column, _) in self._curves().items()},
            "oscillator": asdict(self.oscillator),
            "settings": self.settings.to_dict(),
            "diagnostics": self.diagnostics,
            "warnings": list(self.warnings),
        }

    def _step_biases(self) -> dict[str, float | npt.NDArray[np.float64]]:
        """Bounds on the step's bias by name, where there is no budget that has them."""
        if self.budgets:
            return {}
        return step_biases(
            self.oscillator, self.settings.step, self.values, self.distributions, self.extremes, PROBABILITIES
        )

    def _numbers(self) -> dict[str, tuple[float, str, str]]:
        """Every number by its public name: value, unit and what it is."""
        numbers, biases = {}, self._step_biases()
        for name, value in self.values.items():
            unit = UNITS.get(name, "")  # only the user knows the unit of an observable
            numbers[name] = value, unit, name.replace("_", " ")
            numbers[f"{name}_se"] = self.errors[name], unit, f"standard error of {name}"
            if name in self.budgets:
                budget = self.budgets[name]
                numbers[f"{name}_step_bias"] = budget.step_bias, unit, f"bound on the step's bias of {name}"
                numbers[f"{name}_memory_bias"] = budget.memory_bias, unit, f"bound on the memory's bias of {name}"
                numbers[f"{name}_transient"] = budget.transient, unit, f"bound on what the start leaves in {name}"
                numbers[f"{name}_error"] = budget.total, unit, f"half-width of the total 95 % interval of {name}"
            elif name in biases:
                numbers[f"{name}_step_bias"] = float(biases[name]), unit, f"bound on the step's bias of {name}"
        for passage in self.first_passages.values():
            numbers |= passage.numbers()
        return numbers

    def _curves(self) -> dict[str, tuple[str, npt.NDArray[np.float64], str]]:
        """Survival curves and their times, by name: axis, numbers, unit."""
        curves = {}
        for name, passage in self.first_passages.items():
            time, survival, error = passage.curve()
            axis = f"{name}_first_passage_time"
            curves[axis] = axis, time, "s"
            curves[f"{name}_first_passage_survival"] = axis, survival, "1"
            curves[f"{name}_first_passage_survival_se"] = axis, error, "1"
        return curves

    def _quantiles(self) -> dict[str, tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], str]]:
        """Quantiles at PROBABILITIES of what was sketched and of the extremes over the paths: values, errors, unit."""
        found = {
            f"{name}_quantile": (*sketch.quantile(PROBABILITIES), sketch.unit)
            for name, sketch in self.distributions.items()
        }
        for name, samples in self.extremes.items():
            found[f"{name}_quantile"] = (*sample_quantiles(samples, PROBABILITIES), EXTREMES[name])
        for name, passage in self.first_passages.items():
            found[f"{name}_first_passage_quantile"] = (*passage.quantile(PROBABILITIES), "s")
        return found

    def to_dataset(self) -> xarray.Dataset:
        """The same as an xarray Dataset: every estimate and its ``_se`` with units, all else as attributes.

        Returns
        -------
        xarray.Dataset
            As `springpot.simulate` returns it.

        Examples
        --------
        >>> run(Oscillator(), paths=8, duration=1.0).to_dataset()["impact_rate"].units
        's-1'
        """
        import json

        import xarray

        data: dict[str, Any] = {
            name: ((), value, {"units": unit, "long_name": text})
            for name, (value, unit, text) in self._numbers().items()
        }
        coordinates: dict[str, Any] = {}
        biases = self._step_biases()
        if self.settings.record:
            coordinates = {"path": np.arange(self.settings.record), "time": ("time", self.time, {"units": "s"})}
            data["x"] = (("path", "time"), self.record[:, :, 0], {"units": "m"})
            data["v"] = (("path", "time"), self.record[:, :, 1], {"units": "m s-1"})
        for name, (at, error, unit) in self._quantiles().items():
            coordinates["probability"] = ("probability", list(PROBABILITIES), {"units": "1"})
            data[name] = ("probability", at, {"units": unit})
            data[f"{name}_se"] = ("probability", error, {"units": unit})
            if name in biases:
                data[f"{name}_step_bias"] = ("probability", biases[name], {"units": unit})
        if (found := self.spectrum) is not None:
            coordinates["frequency"] = ("frequency", found.frequency, {"units": "rad s-1"})
            data["x_spectrum"] = ("frequency", found.density, {"units": "m2 s rad-1", "resolution": found.resolution})
            data["x_spectrum_se"] = ("frequency", found.standard_error, {"units": "m2 s rad-1"})
        for name, (axis, column, unit) in self._curves().items():
            (coordinates if name == axis else data)[name] = (axis, column, {"units": unit})
        for name, sketch in self.distributions.items():
            edges, density, error = sketch.density()
            where, per_unit = f"{name}_bin", {"units": sketch.density_unit}
            coordinates[where] = (where, 0.5 * (edges[1:] + edges[:-1]), {"units": sketch.unit})
            coordinates[f"{name}_bin_width"] = (where, np.diff(edges), {"units": sketch.unit})
            data[f"{name}_density"] = (where, density, per_unit)
            data[f"{name}_density_se"] = (where, error, per_unit)
            if f"{name}_density" in biases:
                data[f"{name}_density_step_bias"] = (where, biases[f"{name}_density"], per_unit)
        attributes = {
            "oscillator": json.dumps(asdict(self.oscillator)),
            "settings": json.dumps(self.settings.to_dict()),
            "diagnostics": json.dumps(self.diagnostics),
            "warnings": list(self.warnings),
            "Conventions": "CF-1.11",
        }
        return xarray.Dataset(data, coordinates, attributes)

    def save(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the run to a file: see `springpot.simulation.saved.save_run`, whose arguments are the same.

        Returns
        -------
        Path

        Raises
        ------
        ValueError, OSError
            As there.

        Examples
        --------
        >>> import tempfile
        >>> run(Oscillator(), paths=8, duration=1.0).save(Path(tempfile.mkdtemp()) / "run.csv").name
        'run.csv'
        """
        from springpot.simulation.saved import save_run

        return save_run(self, path, overwrite=overwrite)


def run(
    oscillator: Oscillator,
    *,
    rtol: float | None = None,
    quantities: Sequence[str] = ("amplitude_mean_square",),
    max_time: float | None = None,
    observables: Mapping[str, Observable] | None = None,
    impact_observables: Mapping[str, Observable] | None = None,
    distributions: bool = False,
    spectrum: npt.ArrayLike | None = None,
    first_passage: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    **given: Unpack[Options],
) -> Run:
    """Simulate, and return a plain `Run`.  See `simulate` for the arguments, which are the same.

    It raises no Python warnings: they are in the result's ``warnings``.

    Returns
    -------
    Run

    Raises
    ------
    TypeError, ValueError
        As in `simulate`.

    Examples
    --------
    >>> from springpot import Oscillator
    >>> found = run(Oscillator(), paths=64, duration=2.0, step=0.02)
    >>> found.values["x_mean"] > 0.0
    True
    """
    for name in given:
        if name not in Options.__annotations__:
            known = [*Options.__annotations__, *_OWN_ARGUMENTS]
            near = meant(name, known) or f"; there are {', '.join(sorted(known))}."
            raise TypeError(f"there is no argument {name!r}{near}")
    if progress is not None and not callable(progress):
        raise TypeError(f"progress must be a function of the fraction done, not {progress!r}.")
    if rtol is not None:
        more = {
            "observables": observables,
            "impact_observables": impact_observables,
            "distributions": distributions,
            "spectrum": spectrum is not None,
            "first_passage": first_passage,
        }
        if asked := [name for name, value in more.items() if value]:
            raise ValueError(f"{asked[0]} cannot be given with rtol, which controls moments only.")
        return _run_to(oscillator, rtol, quantities, max_time, progress, given)
    if max_time is not None:
        raise ValueError("max_time needs rtol: without it, paths and duration say how long a run takes.")
    if tuple(quantities) != _DEFAULT_QUANTITIES:
        raise ValueError("quantities has no effect without rtol, the relative error to which they must be known.")
    settings = from_the_start(resolve(oscillator, **given), first_passage, given.get("window"))
    watching = watched(
        oscillator,
        settings,
        observables=observables,
        impact_observables=impact_observables,
        distributions=distributions,
        spectrum=spectrum,
        first_passage=first_passage,
    )
    begun = time.perf_counter()
    adapted = None
    if settings.start == "stationary":
        adapted = adapt(oscillator, settings, progress=progress)
        settings = replace(settings, initial_position=adapted.position)
    made = tables(oscillator, settings)
    ensemble = advance(oscillator, settings, made, observers=watching.observers, progress=progress)
    values, errors = measured(oscillator, settings, made, ensemble.rows, adapted)
    observed = watching.read(oscillator, settings, made, ensemble)
    for name, samples in observed.means.items():
        values[name], errors[name] = float(samples.mean()), standard_error(samples)
    return Run(
        oscillator=oscillator,
        settings=settings,
        values=values,
        errors=errors,
        budgets={},
        diagnostics=_diagnostics(settings, made, ensemble.rows, adapted, time.perf_counter() - begun),
        warnings=(
            *_about_default_start(oscillator, given),
            *without_effect(oscillator, given),
            *doubts(oscillator, settings, adapted, values, errors, ensemble.rows),
            *about_slow_impacts(oscillator, settings, values),
            *(
                about_quantiles(oscillator, settings.step, observed.distributions["impact_speed"], PROBABILITIES)
                if distributions
                else ()
            ),
            *(
                f"observable {name} is not a finite number: its function raised, or is not finite everywhere."
                for name in observed.means
                if not math.isfinite(values[name])
            ),
            *(sentence for passage in observed.first_passages.values() for sentence in passage.warnings),
        ),
        time=settings.recorded_times,
        record=mirror(oscillator) * ensemble.record,
        distributions=observed.distributions,
        extremes=observed.extremes,
        spectrum=observed.spectrum,
        first_passages=observed.first_passages,
    )


def _run_to(
    oscillator: Oscillator,
    rtol: float,
    quantities: Sequence[str],
    max_time: float | None,
    progress: Progress | None,
    given: Options,
) -> Run:
    """The run that `reach` decides on."""
    chosen = sorted(set(given) - {"seed", "threads"})
    if chosen:
        raise ValueError(f"{chosen[0]} cannot be given with rtol, which chooses it; only seed and threads can.")
    begun = time.perf_counter()
    found = reach(
        oscillator,
        rtol,
        quantities=quantities,
        seed=given.get("seed", 1),
        threads=given.get("threads"),
        max_time=max_time,
        progress=progress,
    )
    settings, adapted = found.settings, found.adapted
    diagnostics = _diagnostics(settings, found.made, found.rows, adapted, time.perf_counter() - begun)
    # the coarse level's step is corrected for, and part of the budget
    fine = replace(settings, step=min(settings.step, COARSE["default"] / fastest_rate(oscillator)))
    warned = [
        *doubts(oscillator, fine, adapted, found.values, found.errors, found.rows, bounded=True),
        *_about_impacts_not_asked_for(found, quantities, rtol),
        *([found.shortfall] if found.shortfall else []),
    ]
    return Run(
        oscillator=oscillator,
        settings=settings,
        values=found.values,
        errors=found.errors,
        budgets=found.budgets,
        diagnostics={
            **diagnostics,
            "pairs": found.pairs,
            "path_steps": found.path_steps,
            "held_up_by": found.estimate.reason,
            "reached": not found.shortfall,
        },
        warnings=tuple(warned),
        time=np.zeros(0),
        record=np.zeros((0, settings.steps + 1, 2)),
    )


def simulate(
    oscillator: Oscillator,
    *,
    rtol: float | None = None,
    quantities: Sequence[str] = ("amplitude_mean_square",),
    max_time: float | None = None,
    observables: Mapping[str, Observable] | None = None,
    impact_observables: Mapping[str, Observable] | None = None,
    distributions: bool = False,
    spectrum: npt.ArrayLike | None = None,
    first_passage: Mapping[str, Any] | None = None,
    progress: Progress | None = None,
    **given: Unpack[Options],
) -> xarray.Dataset:
    """Monte Carlo of an oscillator: response levels, impact rate and impact speeds, each with its standard error.

    Parameters
    ----------
    oscillator : Oscillator
    rtol : float
        Relative error wanted, in [1e-4, 0.5]: paths, duration, step, start and window are then chosen so that the total
        error (95 % of the sampling error, plus bounds on what step, memory and start leave) of each of ``quantities``
        is below it; of the arguments below only ``seed`` and ``threads`` can be given as well.
    quantities : sequence of str
        What ``rtol`` speaks of, ``("amplitude_mean_square",)`` if left out.
    max_time : float
        With ``rtol``: seconds after which the run ends with what it has reached, and says so.  It ends after a whole
        round of paths; how many rounds there is time for depends on the machine.
    observables : dict
        Names and functions f(t, x, v) of numbers, in s, m and m/s, that Numba can compile: each is averaged over the
        window and comes back under its name, with its standard error.
    impact_observables : dict
        Names and functions f(speed) of the speed just before an impact: each is summed over the impacts in the window
        and comes back per second.
    distributions : bool
        Whether to estimate distributions of x, v, amplitude (sqrt(x^2 + v^2 / Omega^2)) and impact speed in the window,
        and the extremes of each path in it.
    spectrum : array_like
        Frequencies in rad/s at which to estimate the spectral density of x in the window.
    first_passage : dict
        Quantities and levels whose first passage is watched, such as ``{"x": 0.01}``.  Levels of ``"x"`` (m) and
        ``"v"`` (m/s) are passed away from where the run starts; ``"distance"`` (m) is the size of x, or of
        x - reference with a pair ``(level, reference)``; ``"speed"`` (m/s) is the size of v; ``"amplitude"`` (m) is
        sqrt(x^2 + v^2 / Omega^2);
        ``"energy"`` (m^2/s^2) is (v^2 + Omega^2 x^2) / 2.  Any other name is an observable's, with a pair of a function
        f(t, x, v) and its level.  The clock starts with the window; from rest the window is the whole run if left out.
    paths : int
        Independent sample paths; 5000 if left out.
    duration : float
        Simulated time in s; if left out, 100 / Omega or longer, so that half of it outlasts the transient.
    step : float
        Time step in s, shortened to divide the duration; if left out, a hundredth (default scheme) or a thousandth
        (``"grunwald"``) of the shortest time scale, 1 / Omega or C^(-1 / (2 - alpha)).
    window : (float, float)
        Averages are taken over window[0] < t <= window[1]; the second half of the run if left out.
    seed : int
        0 <= seed < 2^64.  The same seed gives the same bits for any number of threads.
    threads : int
        All available ones if left out.
    scheme : {"default", "grunwald"}
        ``"default"``: exact flight of the bare oscillator, impacts in it, between impulses of memory and noise.
        ``"grunwald"``: the paper's Monte Carlo (Grunwald-Letnikov derivative, Euler step, impact when x is within
        ``contact_tolerance`` of the wall or beyond it and moves towards it).
    start : {"stationary", "rest"}
        ``"stationary"`` puts x(0) at the stationary mean, found by pilot runs, so that the springpot has no transient
        of the mean to remember; the standard errors of the moments then include a bound on the error of x(0).
        ``"rest"`` starts from x(0) and x'(0).  If left out, the start is stationary, except that a run whose
        ``initial_position`` or ``initial_velocity`` is given, or whose derivative is Riemann-Liouville's, starts from
        that state, and a run without a stationary state from rest, with a warning.
    initial_position, initial_velocity : float
        x(0) in m and x'(0) in m/s, with ``start="rest"``.  If left out, x(0) is the equilibrium, or the wall if the
        equilibrium lies behind it, and x'(0) is 0.
    derivative : {"caputo", "riemann-liouville"}
        Differ by the force C x(0) t^-alpha / Gamma(1 - alpha), hence only if x(0) is not 0, and not at order 0, where
        both are x itself.  Riemann-Liouville's needs ``start="rest"``.
    memory_tolerance : float
        Relative error of the memory's exponential sum, in [1e-13, 1e-2]; 1e-6 if left out.  Below 1e-7 the memory is
        kept in double precision.
    contact_tolerance : float
        The paper's epsilon in m, 1e-5 if left out; ``"grunwald"`` only.
    record : int
        Number of paths to store (variables ``x`` and ``v``); none if left out.
    record_every : int
        Store every so many steps only; every step if left out.  Memory and the limit of 50 million points count what is
        stored.
    progress : callable
        Called with the fraction done, from any thread.  With ``rtol`` that float also has the attribute ``estimate``
        (None before the pilot runs are over): ``estimate.path_steps``, ``estimate.seconds`` still to come,
        ``estimate.reason`` for what takes the time, and ``estimate.aim``, the relative error that can be reached.

    Returns
    -------
    xarray.Dataset
        Scalars ``x_mean``, ``x_mean_square``, ``v_mean_square``, ``amplitude_mean_square`` (x^2 + v^2 / Omega^2),
        ``impact_rate``, ``impact_speed_mean``, ``impact_speed_mean_square``, ``springpot_force_mean``,
        ``springpot_power``, ``springpot_virial``, ``energy_residual`` over the window and four ``_end`` values at the
        end of the run, each with a twin ``_se``; impact rate and speeds, the quantiles of the impact speed and of the
        largest speed and the density of the impact speed also have ``_step_bias``, a bound on what the step leaves.
        With ``rtol`` the first seven have ``_step_bias``, ``_memory_bias``, ``_transient`` and their total ``_error``.
        Then the observables; with ``distributions`` each has ``_density`` over ``_bin`` and ``_quantile`` over
        ``probability``, and so have the extremes ``x_minimum``, ``x_maximum``, ``v_largest``,
        ``impact_speed_largest`` over the paths; with
        ``spectrum``, ``x_spectrum`` (two-sided, per rad/s) over ``frequency``; with ``first_passage`` each quantity has
        ``_first_passage_mean``, ``_first_passage_restricted_mean`` (of the time cut off at the end of the run),
        ``_first_passage_censored`` (share that has not passed), ``_first_passage_at_start``,
        ``_first_passage_quantile`` over ``probability`` and ``_first_passage_survival`` over
        ``..._first_passage_time``.  Attributes
        ``oscillator``, ``settings``,
        ``diagnostics`` (JSON) and ``warnings``.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; nothing has been computed then.
    TimeoutError
        If ``max_time`` is too short for any result.

    Warns
    -----
    UserWarning
        For each sentence of ``warnings``.

    Notes
    -----
    The motion obeys the paper's Eq. 1 above a wall; with ``side="below"`` it is the mirror image, bit for bit.  Memory
    use is about 230 bytes per path, whatever the number of steps.

    Examples
    --------
    >>> import springpot as sp
    >>> oscillator = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0))
    >>> found = sp.simulate(oscillator, paths=2000, duration=60.0, step=0.05, window=(20.0, 60.0))
    >>> abs(float(found["amplitude_mean_square"]) - 1.0) < 0.05
    True

    What a harvester with a damping of 0.1 per second gains, and how fast the fastest tenth of the impacts is:

    >>> found = sp.simulate(
    ...     oscillator, paths=2000, duration=60.0, step=0.05, window=(20.0, 60.0),
    ...     observables={"harvested_power": lambda t, x, v: 0.1 * v * v}, distributions=True,
    ... )
    >>> abs(float(found["harvested_power"]) - 0.05) < 0.0025
    True
    >>> bool(found["impact_speed_quantile"].sel(probability=0.95) > found["impact_speed_mean"])
    True
    """
    import warnings

    found = run(
        oscillator,
        rtol=rtol,
        quantities=quantities,
        max_time=max_time,
        observables=observables,
        impact_observables=impact_observables,
        distributions=distributions,
        spectrum=spectrum,
        first_passage=first_passage,
        progress=progress,
        **given,
    )
    for sentence in found.warnings:
        warnings.warn(sentence, stacklevel=2)
    return found.to_dataset()


def measured(
    oscillator: Oscillator,
    settings: Settings,
    made: Tables,
    rows: npt.NDArray[np.float64],
    adapted: Adapted | None,
) -> tuple[dict[str, float], dict[str, float]]:
    """Values and standard errors by name, with what they owe to an adapted start that is not known exactly."""
    values, errors = estimates(oscillator, settings, made, rows)
    if adapted is None:
        return values, errors
    owed = owed_to_the_start(oscillator, settings, adapted, values)
    return values, {name: math.hypot(error, owed[name]) for name, error in errors.items()}


def _energy_drift(rows: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Mean energy gained over the window, and its standard error."""
    gained = rows[:, COLUMNS.index("energy_last")] - rows[:, COLUMNS.index("energy_first")]
    return float(gained.mean()), standard_error(gained)


def _diagnostics(
    settings: Settings, made: Tables, rows: npt.NDArray[np.float64], adapted: Adapted | None, seconds: float
) -> dict[str, Any]:
    from llvmlite.binding import get_host_cpu_name
    from numba.core.config import CPU_NAME

    return {
        "steps": settings.steps,
        "memory_terms": int(made.sum.rates.size),
        "memory_error": made.sum.relative_error,
        "memory_precision": settings.precision,
        "start_residual": None if adapted is None or math.isnan(adapted.residual) else adapted.residual,
        "start_residual_se": None if adapted is None or math.isnan(adapted.residual) else adapted.residual_se,
        "pilot_runs": None if adapted is None else adapted.pilots,
        "collapses": int(rows[:, COLUMNS.index("collapses")].sum()),
        "seconds": seconds,
        "cpu": CPU_NAME or get_host_cpu_name(),
        "versions": {name: version(name) for name in ("springpot", "numba", "llvmlite", "numpy")}
        | {"python": platform.python_version()},
    }


def doubts(
    oscillator: Oscillator,
    settings: Settings,
    adapted: Adapted | None,
    values: dict[str, float],
    errors: dict[str, float],
    rows: npt.NDArray[np.float64],
    *,
    bounded: bool = False,
) -> tuple[str, ...]:
    """One sentence for each reason to doubt a number; ``bounded`` says that its total error includes the transient."""
    found = [*_about_settings(oscillator, settings, values, bounded), *_about_start(adapted)]
    if not math.isfinite(values["amplitude_mean_square"]):
        return (*found, "the response is not a finite number: a much finer step may help.")
    energy = 0.5 * oscillator.natural_frequency**2 * values["amplitude_mean_square"]
    gained, its_error = _energy_drift(rows)
    settled = oscillator.excitation.intensity > 0.0 and _transient_left(oscillator, settings) <= MOST_TRANSIENT
    if settled and math.isfinite(its_error) and abs(gained) > max(FAR_OFF * its_error, 0.02 * energy):
        found.append(
            f"the mean energy still changed by {100.0 * gained / energy:.2g} % over the window "
            f"({gained / its_error:.0f} standard errors), so it is not stationary yet: use a longer run and a later "
            "window."
        )
    if settled:
        found.extend(_about_memory(oscillator, values, errors))
    residual, error = values["energy_residual"], errors["energy_residual"]
    # what single-precision memory and rounding make of a large energy is no failure
    fed = 0.5 * oscillator.excitation.intensity * (settings.window[1] - settings.window[0])
    floor = max(0.01, 1e-4 * energy / fed) if fed > 0.0 else 0.01
    if math.isfinite(error) and abs(residual) > max(FAR_OFF * error, floor):
        found.append(
            f"the energy balance fails by {100.0 * residual:.2g} % of the power fed in (standard error "
            f"{100.0 * error:.1g} %): do not trust this run before a finer step has confirmed it."
        )
    return tuple(found)


def _about_memory(oscillator: Oscillator, values: dict[str, float], errors: dict[str, float]) -> list[str]:
    """Of a start that the springpot still remembers: its force has no mean in the stationary state."""
    order = oscillator.springpot.order
    force, error = values["springpot_force_mean"], errors["springpot_force_mean"]
    spring = oscillator.natural_frequency**2 * abs(values["x_mean"])
    if not 0.0 < order < 1.0 or abs(force) <= max(FAR_OFF * error, MOST_REMEMBERED * spring):
        return []
    return [
        f"the springpot remembers the start: its mean force is {_per_cent(abs(force) / spring)} of the spring's, where "
        f"a stationary one has none, and falls only like t^-{order:.2g}; mean displacement and impact rate are not yet "
        "stationary (energies are barely affected). Use start='stationary' for those."
    ]


def _about_settings(oscillator: Oscillator, settings: Settings, values: dict[str, float], bounded: bool) -> list[str]:
    found = []
    fastest, limit = fastest_rate(oscillator), COARSE[settings.scheme]
    if settings.step * fastest > limit * (1.0 + 1e-9):
        found.append(
            f"step is {settings.step:g} s, {settings.step * fastest:.2g} of the shortest time scale: errors of the "
            f"order of 1 % are to be expected above {limit:g}; use at most {limit / fastest:.2g} s."
        )
    left = _transient_left(oscillator, settings)
    if oscillator.excitation.intensity > 0.0 and left > MOST_TRANSIENT and not bounded:
        relaxation = relaxation_time(oscillator)
        found.append(
            "without dissipation there is no stationary state: the averages are those of a growing response."
            if math.isinf(energy_time(oscillator))
            else f"window starts at {settings.window[0]:g} s, inside the transient: about {100.0 * left:.0f} % of it "
            f"is left there; start it after {4.6 * relaxation:.3g} s for stationary values."
        )
    size = math.sqrt(max(values["x_mean_square"], 0.0))
    if settings.scheme == "grunwald" and oscillator.barrier is not None and settings.contact_tolerance > 1e-3 * size:
        found.append(
            f"contact_tolerance is {settings.contact_tolerance:g} m, not small against the root mean square "
            f"displacement of {size:.2g} m: the response is biased by about their ratio; use at most "
            f"{1e-4 * size:.1g} m."
        )
    if oscillator.barrier is not None and not impacts_are_countable(oscillator):
        found.append(
            f"restitution {oscillator.barrier.restitution:g} is not above {COLLAPSE_BELOW:.3f} (= exp(-pi/sqrt 3)): "
            "white noise makes infinitely many impacts in a finite time, so impact rate and speeds are undefined; "
            "energies are not."
        )
    return found


def about_slow_impacts(oscillator: Oscillator, settings: Settings, values: dict[str, float]) -> list[str]:
    """Of a run at one step: what slow impacts that it misses are likely to be worth."""
    if oscillator.barrier is None or not impacts_are_countable(oscillator):
        return []
    missed = missed_impacts(oscillator, settings.step, values["impact_speed_mean_square"])
    if missed <= MOST_MISSED:
        return []
    order = slow_impact_order(oscillator.barrier.restitution)
    return [
        f"impact rate is about {_per_cent(missed)} too low and the mean impact speed "
        f"{_per_cent(missed / (1.0 - missed))} too high at a step of {settings.step:g} s: the wall is so lossy that "
        f"slow impacts crowd, and the error falls only like step^{order:.2g}; energies are right. Use rtol= to have it "
        "bounded."
    ]


def _about_impacts_not_asked_for(found: Reached, asked: Sequence[str], rtol: float) -> list[str]:
    """Of a run to a tolerance: what is left of the step in the impacts that nobody asked to have bounded."""
    left = {
        name: found.budgets[name].total / abs(found.values[name])
        for name in ("impact_rate", "impact_speed_mean")
        if name not in asked and found.values[name] != 0.0
    }
    off = [f"{name} {_per_cent(share)}" for name, share in left.items() if share > max(3.0 * rtol, 2.0 * MOST_MISSED)]
    if not off:
        return []
    return [f"not asked for, and known to no better than: {', '.join(off)}; name it in quantities to have it bounded."]


def _per_cent(share: float) -> str:
    """With two digits at most, and no powers of ten."""
    return f"{float(f'{100.0 * share:.2g}'):g} %"


def _transient_left(oscillator: Oscillator, settings: Settings) -> float:
    """Share of the transient that is left where the window begins."""
    return math.exp(-settings.window[0] / relaxation_time(oscillator))


def is_stationary(oscillator: Oscillator, settings: Settings) -> bool:
    """Whether averages over the window are those of the stationary state, as far as the settings say.

    A springpot at a wall remembers a start from rest like t^-alpha, so such a run is not.
    """
    remembered = settings.start == "rest" and oscillator.barrier is not None and 0.0 < oscillator.springpot.order < 1.0
    settled = _transient_left(oscillator, settings) <= MOST_TRANSIENT
    return oscillator.excitation.intensity > 0.0 and settled and not remembered


def _about_default_start(oscillator: Oscillator, given: Options) -> list[str]:
    """Of a run that nobody asked to start from rest, and that does."""
    if given.get("start") is not None:
        return []
    initial = given.get("initial_position"), given.get("initial_velocity")
    _, reason = default_start(oscillator, *initial, given.get("derivative", "caputo"))
    return [f"the run starts from rest, for there is no stationary state: {reason}."] if reason else []


def _about_start(adapted: Adapted | None) -> list[str]:
    if adapted is None:
        return []
    if math.isnan(adapted.residual):
        return ["the adapted start is that of averaging: pilot runs long enough to check it would take too long."]
    if adapted.residual > MOST_RESIDUAL:
        return [
            f"the adapted start was off by {100.0 * adapted.residual:.2g} % of the root mean square displacement "
            f"(standard error {100.0 * adapted.residual_se:.1g} %) before its last correction."
        ]
    return []


def _finite(numbers: list[float]) -> list[float | None]:
    return [number if math.isfinite(number) else None for number in numbers]


def _spectrum_words(found: Spectrum) -> dict[str, list[float | None]]:
    return {
        "frequency": _finite(found.frequency.tolist()),
        "x_spectrum": _finite(found.density.tolist()),
        "x_spectrum_se": _finite(found.standard_error.tolist()),
    }
