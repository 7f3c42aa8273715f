"""A store as a labelled data set: lazy, with units, and the same numbers in netCDF and CSV."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import springpot as sp
from springpot.studies import tasks
from springpot.studies.export import export
from springpot.studies.store import Store, open_store
from springpot.studies.tasks import compute
from tests.studies.samples import RUNS, THEORY, given, named

ZIPPED: dict[str, Any] = {
    **RUNS,
    "name": "zipped",
    "axes": {"order": [0.5, 1.0]},
    "zipped": {"case": {"coefficient": [0.3, 0.5, 2.0], "position": [0.0, 0.5, -0.5]}},
}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("dataset") / "study.zarr"
    sp.study(ZIPPED, path, threads=1)
    return path


def test_every_number_is_at_its_place(place: Path) -> None:
    tree = sp.open_study(place)
    for task in tasks.tasks(given(ZIPPED)):
        answer = compute(task)
        case = ZIPPED["zipped"]["case"]["coefficient"].index(task.point["coefficient"]) + 1
        at = {"order": task.point["order"], "case": case}
        part = tree["simulation"] if task.method == "monte_carlo" else tree["theory"].sel(theory=task.method)
        here = part.sel(at)
        for name, number in named(task, answer.numbers):
            if name in here:
                np.testing.assert_array_equal(here[name].item(), number)
            else:
                assert math.isnan(number)
        assert bool(here["done"])
        assert str(here["said"].values) == (answer.statement or " ".join(answer.warnings))
        assert (float(here["coefficient"]), float(here["position"])) == (
            task.point["coefficient"],
            task.point["position"],
        )


def test_labels_and_units(place: Path) -> None:
    tree = sp.open_study(place)
    theory, simulation = tree["theory"].to_dataset(), tree["simulation"].to_dataset()
    assert theory["x_mean"].dims == ("theory", "order", "case")
    assert simulation["x_mean"].dims == ("order", "case")
    assert list(theory["theory"].values) == ["averaging"]
    units = {
        "x_mean": "m", "x_mean_square": "m2", "v_mean_square": "m2 s-2", "amplitude_mean_square": "m2",
        "impact_rate": "s-1", "impact_speed_mean": "m s-1", "impact_speed_mean_square": "m2 s-2",
        "damping_power": "m2 s-3", "damping_force_mean": "m s-2", "damping_virial": "m2 s-2", "barrier_power": "m2 s-3",
        "energy_residual": "1",
    }  # fmt: skip
    for name, unit in units.items():
        assert [simulation[each].attrs["units"] for each in (name, f"{name}_se")] == [unit, unit]
    assert simulation["x_mean_se"].attrs["long_name"] == "Monte Carlo: standard error of x mean"
    assert simulation["x_mean"].attrs["ancillary_variables"] == "x_mean_se"
    assert simulation["coefficient"].attrs["units"] == "s^(alpha-2)"
    assert tree.attrs["Conventions"] == "CF-1.11"
    assert (tree.attrs["title"], tree.attrs["seed"]) == ("zipped", 7)
    assert json.loads(tree.attrs["study"])["axes"] == {"order": [0.5, 1.0]}
    assert json.loads(tree.attrs["fixed"])["restitution"] == 1.0
    assert json.loads(tree.attrs["versions"])[0]["springpot"] == sp.__version__


def test_nothing_is_read_before_it_is_looked_at(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    find, times = Store.find, 0

    def counted(store: Store, task: tasks.Task) -> tasks.Answer | None:
        nonlocal times
        times += 1
        return find(store, task)

    monkeypatch.setattr(Store, "find", counted)
    tree = sp.open_study(place)
    few = tree["simulation"]["x_mean"].sel(order=1.0).isel(case=[0, 2])
    assert repr(tree)
    assert few.shape == (2,)
    assert times == 0
    assert np.all(few.values > 0.0)
    assert times == 6  # Monte Carlo's, and no theory's
    assert np.all(tree["simulation"]["x_mean_se"].values > 0.0)
    assert times == 6  # read once


def test_selections_are_those_of_the_whole(place: Path) -> None:
    lazy, whole = (sp.open_study(place)["simulation"]["impact_rate"] for _ in range(2))
    whole.load()
    for chosen in ({"case": 1}, {"case": [2, 0]}, {"order": slice(None, None, -1)}, {"order": 0, "case": -1}):
        xarray.testing.assert_identical(lazy.isel(chosen).compute(), whole.isel(chosen))


def test_numbers_that_are_not_there_yet_are_nan(place: Path) -> None:
    wider = {**ZIPPED, "axes": {"order": [0.5, 0.75, 1.0]}}
    part = open_store(place)
    from springpot.studies.dataset import to_xarray

    tree = to_xarray(Store(part.path, given(wider), part.versions))
    assert tree["simulation"]["done"].values.tolist() == [[True] * 3, [False] * 3, [True] * 3]
    assert np.isnan(tree["simulation"]["x_mean"].sel(order=0.75).values).all()


@pytest.mark.validation  # every day: an export, in test_commands.py
def test_netcdf_holds_the_same(place: Path, tmp_path: Path) -> None:
    file = export(open_store(place), tmp_path / "out.nc")
    tree = sp.open_study(place)
    with xarray.open_datatree(file, engine="h5netcdf") as found:
        assert found.attrs["study"] == tree.attrs["study"]
        for part in ("theory", "simulation"):
            for name, variable in tree[part].to_dataset().variables.items():
                again = found[part].to_dataset().variables[name]
                assert again.dims == variable.dims
                np.testing.assert_array_equal(again.values, variable.values)
                assert {**again.attrs} == {**variable.attrs}
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.nc"]


def test_a_table_holds_the_same_digits(place: Path, tmp_path: Path) -> None:
    with export(open_store(place), tmp_path / "out.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    every = list(tasks.tasks(given(ZIPPED)))
    assert len(rows) == len(every) == 12
    for row, task in zip(rows, every, strict=True):
        assert (row["method"], row["done"]) == (task.method, "1")
        assert float(row["order"]) == task.point["order"]
        assert float(row["position"]) == task.point["position"]
        answer = dict(named(task, compute(task).numbers))
        for name in ("x_mean", "impact_rate", "x_mean_se", "energy_residual"):
            number = answer.get(name, math.nan)
            assert row[name] == ("" if math.isnan(number) else repr(number))


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("out.txt", r"must end in \.nc \(netCDF\), \.zarr \(a Zarr group\) or \.csv, not 'out\.txt'"),
        ("none/out.csv", "folder that exists"),
    ],
)
def test_where_nothing_can_be_exported(name: str, says: str, place: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=says):
        export(open_store(place), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_rtol_adds_the_total_error() -> None:
    tree = sp.study(
        {
            "name": "rtol", "methods": ["monte_carlo"], "axes": {"order": [0.5]}, "monte_carlo": {"rtol": 0.1},
        }
    )  # fmt: skip
    found = tree["simulation"]
    error = float(found["amplitude_mean_square_error"][0])
    assert (
        0.0 < 1.9 * float(found["amplitude_mean_square_se"][0]) < error < 0.1 * float(found["amplitude_mean_square"][0])
    )
    assert "energy_residual_error" not in found


def test_without_a_store_everything_is_in_memory() -> None:
    tree = sp.study(THEORY)
    assert float(tree["theory"]["x_mean"].sel(theory="exact", order=1.0, coefficient=2.0)) == pytest.approx(
        math.sqrt(2 / math.pi) / 2
    )
    assert "covers" in str(tree["theory"]["said"].sel(theory="exact", order=0.25, coefficient=2.0).values)


def test_failures_are_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(task: tasks.Task, **_: object) -> tasks.Answer:
        raise ArithmeticError("no number")

    monkeypatch.setattr("springpot.studies.running.compute", failing)
    with pytest.warns(UserWarning, match="12 tasks failed, the first of them .*: ArithmeticError: no number"):
        tree = sp.study(THEORY)
    assert not tree["theory"]["done"].values.any()


def test_forces_are_results_of_a_study(tmp_path: Path) -> None:
    device = sp.System(
        sp.Mass(2.0), sp.Spring(8.0), mount=sp.Springpot(0.5, 2.0), shake=sp.WhiteNoise(1.0, on="ground")
    )
    study: dict[str, Any] = {
        "name": "mounts", "system": device, "methods": ["monte_carlo", "linear", "envelope"],
        "quantities": ["mount_force_mean_square"], "axes": {"parts.mount.coefficient": [1.0, 4.0]},
        "monte_carlo": {
            "paths": 64, "duration": 20.0, "step": 0.05, "start": "rest", "window": [4.0, 20.0],
            "forces": ["mount_force", "acceleration"],
        },
    }  # fmt: skip
    sp.study(study, tmp_path / "study.zarr", threads=1)
    tree = sp.open_study(tmp_path / "study.zarr")
    runs, theory = tree["simulation"].to_dataset(), tree["theory"].to_dataset()
    assert runs["mount_force_mean_square"].units == theory["mount_force_mean_square"].units == "N2"
    of_linear = theory.sel(theory="linear")
    for name in ("mount_force", "acceleration"):
        right = [sp.theory.linear(task.system).mean_square(name) for task in tasks.tasks(given(study))][:2]
        assert of_linear[f"{name}_mean_square"].values.tolist() == right
        apart = runs[f"{name}_mean_square"].values - right
        assert np.all(np.abs(apart) < 4.0 * runs[f"{name}_mean_square_se"].values)
    assert theory["mount_force_mean_square"].sel(theory="envelope").isnull().all()
    assert runs["acceleration_mean_square_se"].units == "m2 s-4"
    weak, strong = runs["mount_force_mean_square"].values
    assert 0.0 < weak < strong
    study["quantities"] = ["x_mean_square"]
    with pytest.raises(
        ValueError, match=r"parts\.mount\.coefficient = 1: forces has 'mount', which is no force or acceleration"
    ):
        sp.study({**study, "monte_carlo": {**study["monte_carlo"], "forces": ["mount"]}}, tmp_path / "other.zarr")
    with pytest.raises(ValueError, match="rtol chooses all settings, so forces cannot be given with it"):
        sp.study({**study, "monte_carlo": {"rtol": 0.1, "forces": ["mount_force"]}}, tmp_path / "other.zarr")
    study |= {"quantities": ["x_mean_square", "acceleration_mean_square"], "monte_carlo": {"rtol": 0.05}}
    sp.study(study, tmp_path / "controlled.zarr", threads=1)
    tree = sp.open_study(tmp_path / "controlled.zarr")
    runs, theory = tree["simulation"].to_dataset(), tree["theory"].to_dataset().sel(theory="linear")
    apart = np.abs(runs["acceleration_mean_square"] - theory["acceleration_mean_square"]).values
    assert np.all(apart < runs["acceleration_mean_square_error"].values)
    assert "mount_force_mean_square" not in runs


@pytest.mark.validation  # every day: forces are, above
def test_damage_is_a_result_of_a_study(tmp_path: Path) -> None:
    """Cycles and damage are those of a run, at each level of a test; what no study can keep is refused."""
    shake = sp.SpectralExcitation.from_psd((0.05, 2.0), 0.01, "g2/Hz")
    device = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(1.0), shake=shake)
    how: dict[str, Any] = {"paths": 64, "duration": 20.0, "step": 0.05, "start": "rest"}
    counted = {"x": {"exponent": 4.0, "strength": 0.5, "cycles": 1e6}}
    study: dict[str, Any] = {
        "name": "life", "system": device, "methods": ["monte_carlo"], "axes": {"parts.shake.level": [-6.0, 0.0]},
        "monte_carlo": {**how, "rainflow": counted},
    }  # fmt: skip
    sp.study(study, tmp_path / "study.zarr", threads=1)
    runs = sp.open_study(tmp_path / "study.zarr")["simulation"].to_dataset()
    assert runs["x_damage_rate"].units == "h-1"
    quiet, loud = runs["x_damage_rate"].values
    spread = float(np.hypot(*(runs["x_damage_rate_se"].values / runs["x_damage_rate"].values)))
    assert np.log(loud / quiet) == pytest.approx(np.log(10.0 ** (0.6 * 2.0)), abs=4.0 * spread)  # amplitude^4
    assert runs["x_life"].values[1] == pytest.approx(1.0 / loud)
    for more, sentence in (
        ({"rainflow": {"y": {"exponent": 4.0}}}, "rainflow has 'y', which is no displacement, force or acceleration"),
        ({"rainflow": {"x": {"exponent": 0.5}}}, "exponent"),
        ({"profile": 5}, "'profile' is not a key"),
    ):
        with pytest.raises(ValueError, match=sentence):
            sp.study({**study, "monte_carlo": how | more}, tmp_path / "other.zarr")
