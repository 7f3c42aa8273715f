"""The result of a run: values with errors, budgets, warnings and paths, also as a dict, a dataset and a file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from itertools import chain, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.machine.arguments import text
from springpot.machine.arrays import Columns, Floats
from springpot.machine.faults import name_results, with_error
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.catalogue import (
    OF_A_POINT,
    OF_A_WALL,
    PARTS_OF_ERROR,
    possible_results,
    results_on_request,
    unit_of_result,
)
from springpot.problem.system import System
from springpot.simulation.plan.plan import Adapted
from springpot.simulation.plan.settings import Settings

if TYPE_CHECKING:
    import xarray

    from springpot.simulation.error.budget import Budget
    from springpot.simulation.watch.distributions import Distribution
    from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
    from springpot.simulation.watch.profiles import Profile
    from springpot.simulation.watch.spectrum import Spectrum

PROBABILITIES = (0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999)  # of the quantiles in files


KINDS = {
    "distributions": "distributions", "spectra": "a spectrum", "first_passages": "first passages",
    "profiles": "profiles",
}  # fmt: skip
"""The results of observers that say their own columns: the fields of `Run`, with words for them."""
_BOUNDS = {
    "step_bias": "the step's bias of", "memory_bias": "the memory's bias of", "transient": "what the start leaves in",
}  # fmt: skip


@dataclass(frozen=True)
class Estimate:
    """A number with its errors and its unit; it prints as ``0.2590 +- 0.0021 m``.

    After ``+-`` stands ``error``, or with ``rtol`` ``budget.total``, half of a 95 % interval, marked ``(total error)``.

    Attributes
    ----------
    value : float
    error : float
        Standard error, from the spread between independent paths; NaN of a single path.
    unit : str
        Empty of a user's own observable.
    budget : Budget or None
        With ``rtol``: the parts of the total error, and their sum ``budget.total``.
    step_bias : float or None
        Without ``rtol``: a bound on what the step leaves, where there is one.

    Examples
    --------
    >>> from springpot.simulation import Budget
    >>> print(Estimate(0.25904, 0.00213, "m")), f"{Estimate(2.0, 0.1):.1f}", float(Estimate(2.0, 0.1))
    0.2590 +- 0.0021 m
    (None, '2.0', 2.0)
    >>> print(Estimate(1.0, 0.1, "m", Budget(0.1, 0.05, 0.0, 0.0)))
    1.00 +- 0.25 m (total error)
    >>> Estimate(1.0, float("nan")) == Estimate(1.0, float("nan")), Estimate(1.0, 0.1) == Estimate(1.0, 0.2)
    (True, False)
    """

    value: float
    error: float
    unit: str = ""
    budget: Budget | None = None
    step_bias: float | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Estimate) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    @property
    def _numbers(self) -> tuple[object, ...]:
        """All of it, with nothing where a number is NaN, so that estimates that are both unknown are equal."""
        budget = () if self.budget is None else astuple(self.budget)
        whole = self.value, self.error, self.unit, self.step_bias, *budget
        return tuple(None if isinstance(each, float) and math.isnan(each) else each for each in whole)

    def __float__(self) -> float:
        return self.value

    def __format__(self, spec: str) -> str:
        return format(self.value, spec) if spec else str(self)

    def __str__(self) -> str:
        unit = self.unit or "1"
        if self.budget is None:
            return with_error(self.value, self.error, unit)
        return f"{with_error(self.value, self.budget.total, unit)} (total error)"


def estimates_from(
    system: System,
    values: Mapping[str, float],
    errors: Mapping[str, float],
    budgets: Mapping[str, Budget] | None = None,
    step_biases: Mapping[str, Any] | None = None,
) -> dict[str, Estimate]:
    """Estimates by name, from their parts by name."""
    budgets, step_biases = budgets or {}, step_biases or {}
    known = {*possible_results(system)}
    if not known >= values.keys():  # those on request are many
        known |= {*results_on_request(system)}
    return {
        name: Estimate(
            value, errors[name], unit_of_result(system, name) if name in known else "",
            budgets.get(name), step_biases.get(name),
        )
        for name, value in values.items()
    }  # fmt: skip


@dataclass(frozen=True, eq=False)
class Run:
    """The result of one simulation.

    Attributes
    ----------
    system : System
        The user's own.
    settings : Settings
        Complete; with a stationary start, ``initial_position`` is the x(0) that the pilot runs gave.
    estimates : dict of Estimate
        By name; ``run["impact_rate"]`` is one of them.
    diagnostics : dict
        How it was computed: memory terms and their error, residual of the stationary start, chattering sequences that
        ended at rest (``collapses``), versions, time.
    warnings : tuple of str
        One sentence for each reason to doubt a number.
    time : ndarray, shape (points,)
        Times of the recorded paths, in s; empty if none were recorded.
    record : ndarray, shape (recorded, points, 2)
        x and v of the recorded paths, at time 0 and after every ``record_every`` steps.
    distributions : dict
        `springpot.simulation.Distribution` of ``x``, ``v``, ``amplitude`` and ``impact_speed`` in the window, if
        requested; of several masses ``box_x``, ``box_v``, ``panel_box_elongation``, ``stop_impact_speed``.
    extremes : dict
        Smallest and largest x, largest speed and impact speed of each path in the window, if requested: arrays of shape
        (paths,), taken at the ends of the steps and at the impacts.
    spectra : dict
        `springpot.simulation.Spectrum` of ``x`` in the window, if requested, or of the displacements of several masses.
    first_passages : dict
        `springpot.simulation.PassageTimes` by quantity; `springpot.simulation.PassagesOfLevels` of a list of levels.
    path_sums : ndarray, shape (paths, sums)
        Sums over the window of each path, from which `springpot.extend` goes on; empty with ``rtol``.
    adapted : Adapted or None
        How x(0) of a stationary start was found.
    profiles : dict
        `springpot.simulation.Profile` of each quantity in bins of time, if requested, by its name in the data set.
    forces : dict
        Forces and accelerations of the recorded paths, if both were requested, by name: arrays of shape (recorded,
        points).  They are those of half a step before ``time``, at time 0 of half a step after it.
    step_biases : dict
        Bounds on the step bias of quantiles and densities that have a relevant one, of a run without ``rtol``: arrays
        over the probabilities of the quantiles and the bins of the densities.
    """

    system: System
    settings: Settings
    estimates: dict[str, Estimate]
    diagnostics: dict[str, Any]
    warnings: tuple[str, ...]
    time: Floats
    record: Floats
    distributions: dict[str, Distribution] = field(default_factory=dict)
    extremes: dict[str, Floats] = field(default_factory=dict)
    spectra: dict[str, Spectrum] = field(default_factory=dict)
    first_passages: dict[str, PassageTimes | PassagesOfLevels] = field(default_factory=dict)
    path_sums: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    adapted: Adapted | None = None
    step_biases: dict[str, Floats] = field(default_factory=dict)
    profiles: dict[str, Profile] = field(default_factory=dict)
    forces: dict[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        name_results(self, "estimates", "distributions", "extremes", "first_passages", "profiles", "forces")

    def __repr__(self) -> str:
        """How long it is, and what it holds; printed, it shows its numbers."""
        own = self.settings
        held = f"{len(self.estimates)} estimates, {len(self.warnings)} warnings"
        return f"Run(paths={own.paths!r}, duration={own.duration!r}, step={own.step!r}: {held})"

    def __getitem__(self, name: str) -> Estimate:
        """One estimate; of an unknown name the error says which one was probably meant."""
        return self.estimates[text(name, "the name of a result")]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and name in self.estimates

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __str__(self) -> str:
        wide = max(map(len, (*self.estimates, *self.profiles)), default=0) + 2
        lines = [
            f"{name:{wide}}{own}" + ("" if own.step_bias is None else f", step bias up to {own.step_bias:.2g}")
            for name, own in self.estimates.items()
        ]
        lines += [f"{name:{wide}}{own}" for name, own in self.profiles.items()]
        lines += [f"first passage of {own}" for each in self.first_passages.values() for own in str(each).splitlines()]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def to_dict(self) -> dict[str, Any]:
        """Everything but the recorded paths, as plain numbers, strings, lists and dicts; NaN is None.

        Returns
        -------
        dict
            Every estimate and its ``_se`` by name, then ``system``, ``settings``, ``diagnostics`` and ``warnings``.
            Distributions and extremes are there as their quantiles at PROBABILITIES.

        Examples
        --------
        >>> from springpot import Oscillator, simulate
        >>> words = simulate(Oscillator(), paths=1, duration=1.0).to_dict()
        >>> words["x_mean_se"] is None, words["settings"]["paths"]
        (True, 1)
        """
        bins = {f"{name}_bin" for name in self.distributions}  # of densities
        numbers = {
            **{name: value for name, (value, _, _) in self._numbers().items()},
            **{name: values for name, (axes, values, _) in self._observed().items() if bins.isdisjoint(axes)},
        }
        return plain(numbers) | {
            "system": self.system.to_dict(),
            "settings": self.settings.to_dict(),
            "diagnostics": self.diagnostics,
            "warnings": [*map(str, self.warnings)],
        }

    def _numbers(self) -> dict[str, tuple[float, str, str]]:
        """Every number by its public name: value, unit and description."""
        numbers = {}
        for name, own in self.estimates.items():
            numbers[name] = own.value, own.unit, name.replace("_", " ")
            numbers[f"{name}_se"] = own.error, own.unit, f"standard error of {name}"
            if own.budget is not None:
                for part, words in _BOUNDS.items():
                    numbers[f"{name}_{part}"] = getattr(own.budget, part), own.unit, f"bound on {words} {name}"
                total = own.budget.total
                numbers[f"{name}_error"] = total, own.unit, f"half-width of the total 95 % interval of {name}"
            elif own.step_bias is not None:
                numbers[f"{name}_step_bias"] = own.step_bias, own.unit, f"bound on the step's bias of {name}"
        return numbers

    @property
    def units(self) -> dict[str, str]:
        """The unit of every estimate, by name; of an observable it is empty."""
        return {name: estimate.unit for name, estimate in self.estimates.items()}

    def _observed(self) -> Columns:
        """What was asked for beside numbers."""
        found: Columns = {}
        for name, own in chain.from_iterable(getattr(self, kind).items() for kind in KINDS):
            found |= own.columns(name, PROBABILITIES)
        for name, samples in self.extremes.items():
            from springpot.simulation.watch.distributions import sample_quantiles  # for who asked for extremes

            unit = {"units": unit_of_result(self.system, f"{name}_quantile")}
            for end, values in zip(("", "_se"), sample_quantiles(samples, PROBABILITIES), strict=True):
                found[f"{name}_quantile{end}"] = ("probability",), values, unit
        for name, bias in self.step_biases.items():
            axes, _, unit = found[name]
            found[f"{name}_step_bias"] = axes, bias, unit
        return found

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset: every estimate and its ``_se`` with units, the rest as attributes.

        Returns
        -------
        xarray.Dataset
            With the names of ``estimates``; see `springpot.simulate`.

        Examples
        --------
        >>> from springpot import Oscillator, simulate
        >>> simulate(Oscillator(), paths=8, duration=1.0).to_xarray()["impact_rate"].units
        's-1'
        """
        need("files", "run.to_xarray()")
        import json

        import pandas
        import xarray

        attributes = {
            "system": json.dumps(self.system.to_dict()),
            "settings": json.dumps(self.settings.to_dict()),
            "diagnostics": json.dumps(self.diagnostics),
            "warnings": [*map(str, self.warnings)],
            "Conventions": "CF-1.11",
        }
        # arrays of NumPy and indices of Pandas: of others xarray asks whether they are dask's, and imports it for that
        variables, places = (
            {
                name: xarray.Variable(
                    axes, (pandas.Index if name == axes else np.asarray)(values), attrs=dict(*words), fastpath=True
                )
                for name, (axes, values, *words) in columns.items()
            }
            for columns in self.columns()
        )
        return xarray.Dataset(variables, places, attributes)

    def columns(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """The variables and the coordinates of the Dataset: of each its axes, values and attributes."""
        data: dict[str, Any] = {
            name: ((), value, {"units": unit, "long_name": text})
            for name, (value, unit, text) in self._numbers().items()
        }
        coordinates: dict[str, Any] = {}
        walls, points = [*self.system.stops], [*self.system.points]
        if walls:
            self._join(data, "barrier", walls, {name: f"barrier_{name}" for name in OF_A_WALL}, "wall")
            coordinates["barrier"] = ("barrier", walls)
        if self._join(data, "point", points, {name: name for name in OF_A_POINT}, "mass"):
            coordinates["point"] = ("point", points)
        if self.settings.record:
            coordinates["path"] = ("path", np.arange(len(self.record)))
            coordinates["time"] = ("time", self.time, {"units": "s"})
            axes = ("path", "time", "point")[: self.record.ndim - 1]
            data["x"] = (axes, self.record[..., 0], {"units": "m"})
            data["v"] = (axes, self.record[..., 1], {"units": "m s-1"})
            for name, column in self.forces.items():
                data[name] = (("path", "time"), column, {"units": unit_of_result(self.system, name)})
        for name, (axes, values, words) in self._observed().items():
            axis = axes[0] if len(axes) == 1 else axes
            (coordinates if name in (axis, f"{axis}_width") else data)[name] = axis, values, words
        return data, coordinates

    @staticmethod
    def _join(data: dict[str, Any], axis: str, owners: Sequence[str], names: dict[str, str], word: str) -> bool:
        """Join the numbers of several owners to arrays over them; whether there are any.

        ``names``: those of the arrays, by what the numbers are called after their owners.
        """
        joined = False
        for (quantity, whole), ending in product(names.items(), ("", *PARTS_OF_ERROR)):
            each = [f"{own}_{quantity}{ending}" for own in owners]
            if each and all(name in data for name in each):
                parts = [data.pop(name) for name in each]
                one, text = f"{owners[0]}_{quantity}", f"{quantity.replace('_', ' ')} of each {word}"
                text = parts[0][2]["long_name"].replace(one, text).replace(one.replace("_", " "), text)
                attributes = {"units": parts[0][2]["units"], "long_name": text}
                data[f"{whole}{ending}"] = (axis, [part[1] for part in parts], attributes)
                joined = True
        return joined

    def save(self, path: str | Path, *, overwrite: bool = False, path_sums: bool = False) -> Path:
        """Write the run to a file: see `springpot.simulation.result.save.save_run`, whose arguments are the same.

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
        >>> from springpot import Oscillator, simulate
        >>> simulate(Oscillator(), paths=8, duration=1.0).save(Path(tempfile.mkdtemp()) / "run.csv").name
        'run.csv'
        """
        from springpot.simulation.result.save import save_run

        return save_run(self, path, overwrite=overwrite, path_sums=path_sums)
