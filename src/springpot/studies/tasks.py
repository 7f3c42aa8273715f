"""The tasks of a study: one point of the grid and one method each.

A task's key is a digest of everything that its result depends on, so that it and the seed of Monte Carlo do not change
when the grid grows.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.machine.faults import FileError, NotCoveredError
from springpot.machine.record import digest
from springpot.problem.basquin import Basquin
from springpot.problem.system import System
from springpot.simulation.plan.options import Options, own_seed
from springpot.studies.axes import some_points
from springpot.studies.columns import columns_of, numbers_of_curves, numbers_of_run
from springpot.studies.question import Point, Study, system_at
from springpot.studies.tables import SIMULATED

if TYPE_CHECKING:
    from springpot.simulation import Run
    from springpot.simulation.rare.exceedance import Exceedance

SYSTEMS_TRIED, AXES_TRIED = 4, 3  # points, and axes of the corners, at which settings for systems are checked
ANSWERS_FORMAT = 1  # part of every key: to be raised when the meaning of a result changes


@dataclass(frozen=True)
class Task:
    """What to compute.

    Attributes
    ----------
    method : str
    point : dict
        The numbers that vary; where no system is named, all of the oscillator.
    settings : dict
        Of Monte Carlo or exceedance, without the seed; of linear theory its forces.
    quantities : tuple of str
        Quantities that ``rtol`` controls; empty otherwise.
    seed : int
        From the study's seed and the content; 0 for a theory.
    key : str
        Of its result in a store.
    base : System
        Whose numbers vary.
    """

    method: str
    point: Point
    settings: dict[str, Any]
    quantities: tuple[str, ...]
    seed: int
    key: str
    base: System

    @property
    def system(self) -> System:
        """What is to be solved."""
        return system_at(self.point, self.base)


@dataclass(frozen=True)
class Answer:
    """Result of one task.

    Attributes
    ----------
    numbers : dict
        By the names of the method's columns; those without a value are not there.
    statement : str
        Why there is no result; empty if there is one.
    warnings : tuple of str
    """

    numbers: dict[str, float]
    statement: str
    warnings: tuple[str, ...]

    @property
    def said(self) -> str:
        """The warnings, or why there is no result."""
        return self.statement or " ".join(self.warnings)


def tasks(study: Study) -> Iterator[Task]:
    """Every task of a study: method by method, each in the order of the grid's points.

    Examples
    --------
    >>> from springpot.studies.question import read_study
    >>> study = read_study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5]}})
    >>> [task.point["order"] for task in tasks(study)]
    [0.25, 0.5]
    """
    for method in study.methods:
        yield from map(_maker(study, method), study.points())


def task_at(study: Study, method: str, index: int) -> Task:
    """A method's task at the point with this index."""
    return _maker(study, method)(study.point(index))


def _maker(study: Study, method: str) -> Callable[[Point], Task]:
    """What makes a method's task at a point."""
    base, settings = study.system, _settings(study, method)
    quantities = tuple(sorted(study.quantities)) if method == "monte_carlo" and "rtol" in settings else ()
    content: dict[str, Any] = {"format": ANSWERS_FORMAT, "method": method}
    if study.unvaried:
        content["system"] = hashlib.sha256(json.dumps(study.unvaried, sort_keys=True).encode()).hexdigest()
    if settings:
        content |= {"settings": settings, "quantities": quantities, "seed": study.seed}

    def task(point: Point) -> Task:
        numbers = {name: value + 0.0 if isinstance(value, float) else value for name, value in point.items()}
        whole = {**content, "point": numbers}
        seed = own_seed(study.seed, whole) if method in SIMULATED else 0
        return Task(method, point, settings, quantities, seed, digest(whole), base)

    return task


def _settings(study: Study, method: str) -> dict[str, Any]:
    """The settings of a method, for Monte Carlo with the default start made explicit.

    So a point without a stationary state gives a statement, not a run from rest among stationary ones.  A record or
    an envelope is run from its beginning.
    """
    given = study.settings(method)
    if method != "monte_carlo" or not given or any(each.duration for each in study.system.excitations.values()):
        return given
    given_state = {"start", "initial_position", "initial_velocity"} & given.keys()
    if "rtol" in given or given_state or given.get("derivative", "caputo") != "caputo":
        return given
    return {**given, "start": "stationary"}


def check_some(study: Study, most: int) -> int:
    """Check the settings of simulations at up to ``most`` points and the corners of the grid; returns their number.

    Of systems at fewer: their scales take a tenth of a second.

    Raises
    ------
    TypeError, ValueError
        One sentence.  A point without a stationary state is no error.
    """
    from springpot.simulation.error.reach import checked_quantities
    from springpot.simulation.plan.motions import motion_of
    from springpot.simulation.rare.exceedance import stated
    from springpot.simulation.watch.requested import plan_for, requested  # slow to import
    from springpot.theory import NoStationaryStateError

    how = (SYSTEMS_TRIED, AXES_TRIED) if study.unvaried else (most,)
    chosen = some_points(tuple(study.shape.values()), *how)
    if study.monte_carlo is None and study.exceedance is None:
        return len(chosen)
    rare, given = study.settings("exceedance"), _settings(study, "monte_carlo")
    explicit = {name: value for name, value in given.items() if hasattr(Options, name)}
    wishes = {name: value for name, value in _requests(given).items() if name not in (*explicit, "rtol")}
    for point in map(study.point, chosen):
        try:
            system = system_at(point, study.system)
            if "rtol" in given:
                motion = motion_of(system)
                for name in study.quantities:
                    if reason := motion.uncounted_because(name):
                        raise ValueError(f"quantities must not have {name}, which has no value: {reason}.")
                checked_quantities(motion, study.quantities)
            if given:
                plan = plan_for(system, explicit or {"start": "stationary"}, wishes)
            if wishes:
                requested(plan, wishes)
            if rare:
                stated(system, **rare)
        except NoStationaryStateError:
            continue
        except (TypeError, ValueError) as error:
            raise FileError(f"at {study.where(point)}: {error}") from None
    return len(chosen)


def compute(
    task: Task, *, threads: int = 1, progress: Callable[[float], None] | None = None, save: Path | None = None
) -> Answer:
    """Compute one task.  The same task always gives the same bits; ``save`` keeps repetitions of exceedance."""
    from springpot.evidence.reliability import warnings_of
    from springpot.theory import NoStationaryStateError, solve_one

    warnings, numbers, statement = tuple[str, ...](), dict[str, float](), ""
    how: dict[str, Any] = {"seed": task.seed, "threads": threads, "progress": progress}
    try:
        if task.method == "monte_carlo":
            run = _simulated(task, **how)
            numbers, warnings = numbers_of_run(run), run.warnings
        elif task.method == "exceedance":
            found = _exceeded(task, save, **how)
            numbers, warnings = numbers_of_curves(found.curves), found.warnings
        else:
            result, statement = solve_one(task.system, task.method)
            if result is not None:
                outputs, unknown = _outputs(result, task.settings.get("forces", ()))
                numbers, warnings = result.numbers | outputs, (*warnings_of(result), *unknown)
    except NoStationaryStateError as nothing:
        statement = str(nothing)
    names = (column.name for column in columns_of(task.method, task.base, task.settings, task.quantities))
    known = {name: float(numbers[name]) for name in names if not math.isnan(numbers.get(name, math.nan))}
    return Answer(known, statement, warnings)


def _outputs(result: Any, forces: Iterable[str]) -> tuple[dict[str, float], list[str]]:
    """Means and mean squares of forces in linear theory, and why it has none of some."""
    found, unknown = dict[str, float](), []
    for name in forces:
        try:
            found |= {f"{name}_mean": result.mean(name), f"{name}_mean_square": result.mean_square(name)}
        except (NotCoveredError, ValueError) as refusal:
            unknown.append(f"{name}: {refusal}")
    return found, unknown


def _simulated(task: Task, **how: Any) -> Run:
    from springpot.simulation.monte_carlo import simulated

    more: dict[str, Any] = {"quantities": task.quantities} if task.quantities else {}
    return simulated(task.system, **_requests(task.settings), **more, **how)


def _exceeded(task: Task, save: Path | None, **how: Any) -> Exceedance:
    from springpot.simulation.rare.exceedance import exceeded

    try:
        return exceeded(task.system, **task.settings, save=save, **how)
    except TimeoutError as over:  # an OSError would end the study
        raise ValueError(str(over)) from None
    except FileError:
        if save is None:
            raise
        save.unlink(missing_ok=True)  # damaged: the repetitions are computed again, to the same bits
        return _exceeded(task, None, **how)


def _requests(settings: Mapping[str, Any]) -> dict[str, Any]:
    """The settings as arguments of `springpot.simulate`: curves as such, and levels as lists."""
    curves = {name: Basquin(**numbers) for name, numbers in settings.get("rainflow", {}).items()}
    levels = {name: [*own] for name, own in settings.get("first_passage", {}).items()}
    return {**settings, **({"rainflow": curves} if curves else {}), **({"first_passage": levels} if levels else {})}
