"""The tasks of a study: one point of the grid and one method each.

A task's key is a digest of everything that its result depends on, so that place in the store and seed of Monte Carlo do
not change when the grid grows.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from springpot.faults import FileFault
from springpot.studies.question import QUANTITIES, MonteCarlo, Point, Study, oscillator_of
from springpot.units import UNITS

__all__ = [
    "MONTE_CARLO_COLUMNS",
    "SLOTS",
    "THEORY_COLUMNS",
    "Answer",
    "Task",
    "check_some",
    "columns_of",
    "compute",
    "spread",
    "task_at",
    "tasks",
]

SLOTS = 2**60
"""Length of a store's arrays: a task's slot is a digest, and only slots with a result take space."""
ANSWERS_FORMAT = 1  # part of every key: to be raised when the meaning of a result changes

THEORY_COLUMNS = QUANTITIES
MONTE_CARLO_COLUMNS = tuple(name + part for name in UNITS for part in ("", "_se", "_error"))


@dataclass(frozen=True)
class Task:
    """What to compute, and the place of the result.

    Attributes
    ----------
    method : str
    point : dict
        Numbers of the oscillator.
    settings : dict
        Of Monte Carlo, without the seed; empty for a theory.
    quantities : tuple of str
        Quantities that ``rtol`` controls; empty otherwise.
    seed : int
        Of Monte Carlo, from the study's seed and the content; 0 for a theory.
    slot : int
        Place in the store's arrays.
    check : int
        52 more bits of the digest, saved with the result, so that a misplaced chunk is detected.
    """

    method: str
    point: Point
    settings: dict[str, Any]
    quantities: tuple[str, ...]
    seed: int
    slot: int
    check: int


@dataclass(frozen=True)
class Answer:
    """Result of one task.

    Attributes
    ----------
    numbers : tuple of float
        By `columns_of` the method; NaN where there is none.
    statement : str
        Why there is no result; empty if there is one.
    warnings : tuple of str
    """

    numbers: tuple[float, ...]
    statement: str
    warnings: tuple[str, ...]


def columns_of(method: str) -> tuple[str, ...]:
    """Names of the numbers in a method's result."""
    return MONTE_CARLO_COLUMNS if method == "monte_carlo" else THEORY_COLUMNS


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
        how = _how(study, method)
        for point in study.points():
            yield _task(method, point, *how)


def task_at(study: Study, method: str, index: int) -> Task:
    """A method's task at the point with this index."""
    return _task(method, study.point(index), *_how(study, method))


def _how(study: Study, method: str) -> tuple[dict[str, Any], tuple[str, ...], int]:
    """Settings, quantities and the study's seed."""
    settings: dict[str, Any] = {}
    if method == "monte_carlo" and study.monte_carlo is not None:
        settings = _settings(study.monte_carlo)
    return settings, tuple(sorted(study.quantities)) if "rtol" in settings else (), study.seed


def _settings(monte_carlo: MonteCarlo) -> dict[str, Any]:
    """The settings of Monte Carlo in the study file, with the default start made explicit.

    So a point without a stationary state gives a statement, not a run from rest among stationary ones.
    """
    given = monte_carlo.given()
    given_state = {"start", "initial_position", "initial_velocity"} & given.keys()
    if "rtol" in given or "path_times" in given or given_state or given.get("derivative", "caputo") != "caputo":
        return given
    return {**given, "start": "stationary"}


def _task(method: str, point: Point, settings: dict[str, Any], quantities: tuple[str, ...], seed: int) -> Task:
    content = {
        "format": ANSWERS_FORMAT,
        "method": method,
        "point": {name: value + 0.0 if isinstance(value, float) else value for name, value in point.items()},
        **({"settings": settings, "quantities": quantities, "seed": seed} if method == "monte_carlo" else {}),
    }
    # Python writes the shortest decimal that reads back as the same double: equal text, equal numbers
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).digest()
    words = [int.from_bytes(digest[8 * i : 8 * i + 8], "little") for i in range(3)]
    own_seed = words[2] >> 1 if method == "monte_carlo" else 0
    return Task(method, point, settings, quantities, own_seed, words[0] >> 4, words[1] >> 12)


def spread(count: int, most: int) -> list[int]:
    """Up to ``most`` numbers below ``count``, in an order whose first few cover the range.

    Examples
    --------
    >>> spread(5, 12), spread(1000, 4)
    ([0, 2, 4, 1, 3], [309, 927, 545, 163])
    """
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    if count <= most:
        return sorted(range(count), key=lambda number: number * golden % 1.0)
    return [*dict.fromkeys(int(((number + 0.5) * golden) % 1.0 * count) for number in range(most))]


def check_some(study: Study, most: int) -> int:
    """Check the Monte Carlo settings at up to ``most`` points and the corners of the grid; returns their number."""
    shape = tuple(study.shape.values())
    count = math.prod(shape)
    chosen = set(spread(count, most))
    for corner in itertools.product(*({0, length - 1} for length in shape[:8])):
        place = 0
        for length, step in itertools.zip_longest(shape, corner, fillvalue=0):
            place = place * length + step
        chosen.add(place)
    _check(study, map(study.point, sorted(chosen)))
    return len(chosen)


def _check(study: Study, points: Iterable[Point]) -> None:
    """Check the Monte Carlo settings at these points.

    Raises
    ------
    TypeError, ValueError
        One sentence.  A point without a stationary state is no error.
    """
    from springpot.simulation.accuracy import checked_quantities
    from springpot.simulation.settings import resolve
    from springpot.theory import NoStationaryState

    if study.monte_carlo is None:
        return
    given = _settings(study.monte_carlo)
    explicit = {name: value for name, value in given.items() if name not in ("rtol", "path_times")}
    for point in points:
        try:
            if "rtol" in given:
                checked_quantities(oscillator_of(point), study.quantities)
            resolve(oscillator_of(point), **(explicit or {"start": "stationary"}))
        except NoStationaryState:
            continue
        except (TypeError, ValueError) as error:
            varied = ", ".join(f"{name} = {point[name]:g}" for name in study.columns)
            raise FileFault(f"at {varied}: {error}") from None


def compute(task: Task, *, threads: int = 1, progress: Callable[[float], None] | None = None) -> Answer:
    """Compute one task.  The same task always gives the same bits."""
    if task.method == "monte_carlo":
        return _simulated(task, threads, progress)
    from springpot.theory import solve_one

    result, statement = solve_one(oscillator_of(task.point), task.method)
    if result is None:
        return Answer((math.nan,) * len(THEORY_COLUMNS), statement, ())
    return Answer(tuple(getattr(result, name) for name in THEORY_COLUMNS), "", result.warnings)


def _simulated(task: Task, threads: int, progress: Callable[[float], None] | None) -> Answer:
    from springpot.simulation.run import run
    from springpot.simulation.scaled import stationary
    from springpot.theory import NoStationaryState

    oscillator = oscillator_of(task.point)
    totals: dict[str, float] = {}
    warnings: tuple[str, ...] = ()
    try:
        if "path_times" in task.settings:
            path_times = task.settings["path_times"]
            scaled = stationary(oscillator, path_times=path_times, seed=task.seed, threads=threads, progress=progress)
            values, errors = scaled.values, scaled.errors
        else:
            more: dict[str, Any] = {"quantities": task.quantities} if task.quantities else {}
            result = run(oscillator, **task.settings, **more, seed=task.seed, threads=threads, progress=progress)
            values, errors, warnings = result.values, result.errors, result.warnings
            totals = {name: budget.total for name, budget in result.budgets.items()}
    except NoStationaryState as nothing:
        return Answer((math.nan,) * len(MONTE_CARLO_COLUMNS), str(nothing), ())
    numbers = [part.get(name, math.nan) for name in UNITS for part in (values, errors, totals)]
    return Answer(tuple(map(float, numbers)), "", warnings)
