"""From the Monte Carlo of the study files to the atlas: python atlas/make.py STORES ATLAS.npz

Monte Carlo is divided by a base that is nearly right everywhere (`bases`), and the logarithm of what is left is
interpolated by Gaussian processes (C. E. Rasmussen and C. K. I. Williams, "Gaussian Processes for Machine Learning",
2006): each point's standard error is its noise, so neighbours share their errors out, and the process says how far off
it may be between them.  What it says is checked by leaving each point out in turn, and widened where that shows more.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import sys
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from bases import DEEPEST, FARTHEST, LossyTable, Moments, elastic
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from springpot import Barrier, Oscillator, Springpot
from springpot.evidence.atlases.lookup import (
    COEFFICIENTS,
    LOSSY,
    ORDERS,
    PLACES,
    RESTITUTIONS,
    Table,
    crowding,
    error_codes,
    restitution_at,
)
from springpot.studies.question import read_study
from springpot.studies.store import open_store
from springpot.studies.tasks import tasks
from springpot.theory import NotCoveredError, fokker_planck
from springpot.theory.result import MOMENTS

HERE = Path(__file__).parent
FINENESS = 2.0**15  # steps of the values that are kept: 3e-5 of a moment
GRID = {"order": 21, "c": 29, "position": 33, "restitution": 29}
UNKNOWN = 0.05  # relative standard error from which a point tells nothing: a wall that is hardly struck
EXTRAPOLATED = 3e-3  # what is left of the step in impacts behind a lossy wall, at order 1 against Fokker-Planck
SPEEDS = {"impact_speed_mean": 0.5, "impact_speed_mean_square": 1.0}  # power of <v^2> that they go with
KNOWN = 3e-4  # relative error of exact answers as they stand here
FLOOR = 5e-4  # of Monte Carlo: what steps and starts leave
Point = tuple[float, float, float]
Known = dict[Point, tuple[Moments, Moments]]


def simulated(stores: Path, name: str, third: str) -> Known:
    """Values and standard errors of a study, by (order, c, position or restitution)."""
    study = read_study(HERE / f"{name}.toml")
    store = open_store(stores / f"{name}.store", study)
    found = {}
    for task in tasks(study):
        answer = store.find(task)
        if answer is None:
            raise SystemExit(f"{name} is not complete: springpot study run atlas/{name}.toml first.")
        values = {moment: answer.numbers.get(moment, math.nan) for moment in MOMENTS}
        errors = {moment: answer.numbers.get(f"{moment}_se", math.nan) for moment in MOMENTS}
        for moment, value in values.items():
            extrapolated = name != "elastic" and moment.startswith("impact")
            errors[moment] = math.hypot(errors[moment], (EXTRAPOLATED if extrapolated else FLOOR) * abs(value))
        found[task.point["order"], task.point["coefficient"], task.point[third]] = values, errors
    return found


def exactly(moments: Moments, error: float = KNOWN) -> tuple[Moments, Moments]:
    """What is known without dice, as `simulated` has it."""
    return moments, {name: error * abs(value) for name, value in moments.items()}


def order_one(points: Iterable[tuple[float, float, float]], third: str) -> Known:
    """Answers of the Fokker-Planck equation at (c, wall, restitution), where it has them."""
    found = {}
    for c, wall, restitution in points:
        with contextlib.suppress(NotCoveredError):
            stop = Barrier(wall, restitution, free_side="above")
            result = fokker_planck(Oscillator(springpot=Springpot(1.0, c), barrier=stop))
            moments = {name: getattr(result, name) for name in MOMENTS}
            found[1.0, c, wall if third == "position" else restitution] = exactly(moments)
    return found


def reduced(values: Moments, base: Moments, errors: Moments) -> tuple[list[float], list[float]]:
    """What is left of each moment over its base, and its standard error.

    Logarithms; of the mean displacement the difference in root mean squares; of impact speeds what is left besides what
    they owe to the mean square velocity.
    """
    left, noise = [], []
    for name in MOMENTS:
        if name == "x_mean":
            sizes = (math.sqrt(moments["x_mean_square"]) for moments in (values, base))
            ours, its = (moments["x_mean"] / size for moments, size in zip((values, base), sizes, strict=True))
            left.append(ours - its)
            noise.append(errors["x_mean"] / math.sqrt(values["x_mean_square"]))
            continue
        known = math.isfinite(values[name]) and values[name] > 0.0
        if name in SPEEDS:  # of a few impacts not even the standard error is known
            known = known and errors["impact_rate"] < UNKNOWN * values["impact_rate"]
        heat = SPEEDS.get(name, 0.0) * math.log(values["v_mean_square"] / base["v_mean_square"])
        left.append(math.log(values[name] / base[name]) - heat if known else 0.0)
        noise.append(errors[name] / values[name] if known else math.inf)
    return left, noise


def restored(left: np.ndarray, errors: np.ndarray, base: Moments) -> tuple[list[float], list[float]]:
    """What the atlas holds, from what is left over the base: logarithms, but of the mean; and standard errors."""
    of = dict(zip(MOMENTS, zip(left.tolist(), errors.tolist(), strict=True), strict=True))
    heat, its_error = of["v_mean_square"]
    values, spreads = [], []
    for name, (part, error) in of.items():
        power = SPEEDS.get(name, 0.0)
        if name == "x_mean":
            values.append(part + base["x_mean"] / math.sqrt(base["x_mean_square"]))
        else:
            values.append(part + power * heat + math.log(base[name]))
        spreads.append(math.hypot(error, power * its_error))
    return values, spreads


class Fit:
    """A Gaussian process for each moment over coordinates scaled to their range."""

    def __init__(self, title: str, places: np.ndarray, left: np.ndarray, noise: np.ndarray) -> None:
        self.low, self.range = places.min(axis=0), np.ptp(places, axis=0)
        self.processes = []
        self.widened = []
        for column, name in enumerate(MOMENTS):
            known = noise[:, column] < UNKNOWN
            kernel = ConstantKernel(0.1, (1e-6, 1e2)) * Matern([0.7] * 3, (0.05, 20.0), nu=2.5)
            process = GaussianProcessRegressor(kernel, alpha=noise[known, column] ** 2, n_restarts_optimizer=0,
                                               random_state=1)  # fmt: skip
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound: flat along that axis
                process.fit(self._scaled(places[known]), left[known, column])
            # leaving each point out in turn (Rasmussen and Williams, section 5.4.2)
            inverse = np.linalg.inv(process.L_ @ process.L_.T)
            off = (inverse @ left[known, column]) / np.sqrt(np.diag(inverse))
            self.widened.append(max(1.0, float(np.sqrt(np.mean(off**2)))))
            self.processes.append(process)
            print(f"{title} {name}: {known.sum()} points, left-out points off by {self.widened[-1]:.2f} standard "
                  f"deviations; {process.kernel_}", flush=True)  # fmt: skip

    def __call__(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = [process.predict(self._scaled(places), return_std=True) for process in self.processes]
        values = np.stack([value for value, _ in found], axis=-1)
        errors = np.stack([wide * error for wide, (_, error) in zip(self.widened, found, strict=True)], axis=-1)
        return values, errors

    def _scaled(self, places: np.ndarray) -> np.ndarray:
        return (places - self.low) / self.range


def coordinates(points: list[Point], third: str) -> np.ndarray:
    """Coordinates along which what is left over the base changes evenly."""
    rows = np.array(points)
    # less crowded near 1, for the base knows what small losses do
    last = crowding(rows[:, 2], beyond=1.03) if third == "restitution" else rows[:, 2]
    return np.stack([np.log(rows[:, 0]), np.log(rows[:, 1]), last], axis=1)


def nodes(third: str) -> tuple[list[np.ndarray], list[Point]]:
    """The atlas's grid: coordinates along each axis, and every point."""
    orders = np.linspace(*map(math.log, ORDERS), GRID["order"])
    cs = np.linspace(*map(math.log, COEFFICIENTS), GRID["c"])
    if third == "position":
        last = values = np.linspace(*PLACES, GRID["position"])
    else:
        last = np.linspace(*map(crowding, RESTITUTIONS), GRID["restitution"])
        values = restitution_at(last)
    points = list(itertools.product(np.minimum(np.exp(orders), 1.0), np.exp(cs), values))
    return [orders, cs, last], points


def table(title: str, third: str, known: Known, base_at: Callable[[Point], Moments]) -> Table:
    """One table: fit what is left over the base, and add the base at every node."""
    rows = [reduced(values, base_at(point), errors) for point, (values, errors) in known.items()]
    left, noise = (np.array([row[part] for row in rows]) for part in (0, 1))
    fit = Fit(title, coordinates(list(known), third), left, noise)
    axes, points = nodes(third)
    rows = [
        restored(*pair, base_at(point)) for *pair, point in zip(*fit(coordinates(points, third)), points, strict=True)
    ]
    values, errors = ([row[part] for row in rows] for part in (0, 1))
    shape = (*(axis.size for axis in axes), len(MOMENTS))
    starts, steps = zip(*((axis[0], axis[1] - axis[0]) for axis in axes), strict=True)
    return Table(starts, steps, np.reshape(values, shape).astype("f4"), np.reshape(errors, shape).astype("f4"))


def main(stores: Path, out: Path) -> None:
    axes = read_study(HERE / "elastic.toml").axes
    orders, cs, walls = (axes[name] for name in ("order", "coefficient", "position"))
    restitutions = read_study(HERE / "losses.toml").axes["restitution"]
    tables = {}
    tables["elastic"] = table(
        "elastic", "position",
        simulated(stores, "elastic", "position")
        | {(1.0, c, wall): exactly(elastic(1.0, c, wall)) for c in cs for wall in walls},
        lambda point: elastic(*point),
    )  # fmt: skip
    dampings = np.geomspace(7e-4, 45.0, 14)
    by_wall = LossyTable(dampings, np.array([LOSSY]), np.linspace(FARTHEST, DEEPEST, 19))
    tables["lossy"] = table(
        "lossy", "position",
        simulated(stores, "lossy", "position")
        | order_one(((c, wall, LOSSY) for c in cs for wall in walls), "position"),
        lambda point: by_wall.changed(tables["elastic"].moments(*point)[0], point[2], LOSSY),
    )  # fmt: skip
    by_loss = LossyTable(dampings, restitution_at(np.linspace(crowding(0.29), crowding(1.0), 21)), np.array([0.0]))
    at_rest = {(order, c): tables["elastic"].moments(order, c, 0.0)[0] for order in (*orders, 1.0) for c in cs}
    tables["losses"] = table(
        "losses", "restitution",
        simulated(stores, "losses", "restitution")
        | order_one(((c, 0.0, r) for c in cs for r in restitutions), "restitution")
        | {(*point, 1.0): exactly(moments, 1e-3) for point, moments in at_rest.items()},
        lambda point: by_loss.changed(tables["elastic"].moments(*point[:2], 0.0)[0], 0.0, point[2]),
    )  # fmt: skip
    content = {}
    for name, found in tables.items():
        content[f"{name}_grid"] = np.array([found.starts, found.steps])
        content[f"{name}_values"] = np.round(found.values * FINENESS) / FINENESS  # so that it packs well
        content[f"{name}_errors"] = error_codes(found.errors)
    np.savez_compressed(out, **content)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
