"""Studies of systems: axes over the numbers of any part, results of every wall, and the same bytes after any end."""

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
from springpot import cli
from springpot.problem.numbers import numbers_of, with_numbers
from springpot.simulation.monte_carlo import simulate
from springpot.studies import tasks
from springpot.studies.export import export
from springpot.studies.question import Study, read_study
from springpot.studies.running import run_study
from springpot.studies.store import StoreError, open_store
from springpot.studies.template import of_system
from tests.struck import rates_of
from tests.studies.samples import DEVICE, STOPS, content, given, named, orphans, replaced, with_device, write_toml


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("systems") / "stops.zarr"
    assert run_study(given(STOPS), path, threads=2).computed == 24
    return path


def test_every_number_is_at_its_place(place: Path) -> None:
    tree = sp.open_study(place)
    theory, simulation = tree["theory"].to_dataset(), tree["simulation"].to_dataset()
    assert dict(simulation.sizes) == {"lower_restitution": 2, "magnet_coefficients_3": 2, "gap": 2, "barrier": 2}
    assert theory["barrier_impact_rate"].dims == ("theory", *simulation["barrier_power"].dims)
    for task in tasks.tasks(given(STOPS)):
        case = STOPS["zipped"]["gap"]["parts.lower.position"].index(task.point["parts.lower.position"])
        r, k = (task.point[name] for name in STOPS["axes"])
        cell = (simulation if task.method == "monte_carlo" else theory.sel(theory=task.method)).sel(
            lower_restitution=r, magnet_coefficients_3=k
        )
        cell = cell.isel(gap=case)
        device = sp.System(
            sp.Mass(0.2), sp.Spring(80.0), sp.Dashpot(0.4), sp.WhiteNoise(5e-5),
            magnet=sp.PolynomialSpring((0.0, 0.0, k)), lower=sp.Barrier([-0.001, -0.002][case], r),
            upper=sp.Barrier([0.002, 0.003][case], free_side="below"),
        )  # fmt: skip
        assert task.system == device
        if task.method == "monte_carlo":
            run = sp.simulate(device, **STOPS["monte_carlo"], seed=task.seed)
            for name, value in ((name, own.value) for name, own in run.estimates.items()):
                wall = next((wall for wall in ("lower", "upper") if name.startswith(wall)), "")
                joined = name.replace(f"{wall}_", "barrier_", 1) if wall else name
                found = cell.sel(barrier=wall) if wall else cell
                np.testing.assert_array_equal(float(found[joined]), value)
                np.testing.assert_array_equal(float(found[f"{joined}_se"]), run[name].error)
        elif r == 1.0 and task.method == "exact":
            exact = sp.theory.exact(device)
            assert (float(cell["x_mean"]), float(cell["impact_rate"])) == (exact.x_mean, exact.impact_rate)
            assert tuple(cell["barrier_impact_rate"].values) == rates_of(exact)
        else:
            assert math.isnan(float(cell["x_mean"]))
            assert str(cell["said"].values)


def test_labels_and_units(place: Path) -> None:
    simulation = sp.open_study(place)["simulation"].to_dataset()
    assert simulation["barrier"].values.tolist() == ["lower", "upper"]
    assert simulation["barrier_power"].attrs["units"] == "W"
    assert simulation["barrier_power_se"].attrs["long_name"] == "Monte Carlo: standard error of power of each wall"
    assert simulation["magnet_coefficients_3"].attrs == {"units": "N m-3", "long_name": "parts.magnet.coefficients.3"}
    assert simulation["lower_position"].dims == ("gap",)
    assert simulation["damping_power"].attrs["units"] == "W"
    assert "lower_power" not in simulation
    assert "x_mean_error" not in simulation


@pytest.mark.validation  # every day: the exports of a study of oscillators, in test_dataset.py and test_labelled.py
def test_a_finished_store_opens_without_us_and_exports_hold_the_same(place: Path, tmp_path: Path) -> None:
    tree = sp.open_study(place)
    with xarray.open_datatree(place / "labelled", engine="zarr") as found:
        np.testing.assert_array_equal(found["simulation"]["barrier_power"], tree["simulation"]["barrier_power"])
    file = export(open_store(place), tmp_path / "stops.nc")
    with xarray.open_datatree(file, engine="h5netcdf") as found:
        np.testing.assert_array_equal(found["theory"]["barrier_impact_rate"], tree["theory"]["barrier_impact_rate"])
    with export(open_store(place), tmp_path / "stops.csv").open(newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    one = tree["simulation"].to_dataset().isel(lower_restitution=1, magnet_coefficients_3=0, gap=1)
    row = rows[16 + 4 + 1]
    assert (row["lower_restitution"], row["upper_position"], row["method"]) == ("0.8", "0.003", "monte_carlo")
    assert float(row["lower_power"]) == float(one["barrier_power"].sel(barrier="lower"))


def test_a_file_beside_its_system_is_the_same_study(place: Path, tmp_path: Path, monkeypatch: Any) -> None:
    """From any folder, by dotted keys or by tables in tables; and its store is that of the dict's study."""
    (tmp_path / "elsewhere").mkdir()
    file = with_device(tmp_path / "stops.toml", STOPS)
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert read_study(file) == given(STOPS)
    text = file.read_text(encoding="utf-8").replace('"parts.lower.restitution"', "parts.lower.restitution")
    assert "\nparts.lower.restitution = " in text
    file.write_text(text.replace('"parts.magnet.coefficients.3"', "parts.magnet.coefficients.3"), encoding="utf-8")
    assert read_study(file) == given(STOPS)
    assert run_study(read_study(file), place, threads=1).computed == 0


def test_the_store_holds_the_whole_system(place: Path) -> None:
    kept = open_store(place).study
    assert kept == given(STOPS)
    assert kept.system == DEVICE
    assert json.loads(sp.open_study(place).attrs["study"])["system"]["parts"][4]["coefficients"] == [0.0, 0.0, 4e5]


@pytest.mark.parametrize(
    ("number", "says"),
    [
        ("parts.spring.stiffness", "different: system (spring)"),
        ("parts.upper.restitution", "different: system (upper)"),
        ("parts.magnet.coefficients.1", "different: system (magnet)"),
    ],
)
def test_a_store_of_another_system_is_refused(number: str, says: str, place: Path) -> None:
    before = content(place)
    with pytest.raises(StoreError) as caught:
        open_store(place, given(STOPS, system=with_numbers(DEVICE, {number: 0.5})))
    assert says in str(caught.value)
    renamed = sp.System(**{{"spring": "coil"}.get(name, name): part for name, part in DEVICE.named()})
    with pytest.raises(StoreError, match=r"different: system \(spring, coil\)"):
        open_store(place, given(STOPS, system=renamed))
    assert content(place) == before


def test_a_number_that_varies_may_have_another_value_in_the_file(tmp_path: Path) -> None:
    """The axis replaces it, so the results are the same ones; and a longer axis keeps them."""
    asked = {**STOPS, "methods": ["exact"], "monte_carlo": None}
    asked.pop("monte_carlo")
    path = tmp_path / "study.zarr"
    run_study(given(asked), path, threads=1)
    other = with_numbers(DEVICE, {"parts.lower.restitution": 0.3, "parts.magnet.coefficients.3": 1.0})
    axes = {**STOPS["axes"], "parts.magnet.coefficients.3": [2e5, 4e5, 8e5]}
    found = run_study(given(asked, system=other, axes=axes), path, threads=1)
    assert (found.found, found.computed) == (8, 4)


def test_keys_come_from_content() -> None:
    def first(**changes: Any) -> tasks.Task:
        return next(tasks.tasks(given(STOPS, methods=["monte_carlo"], **changes)))

    base = first()
    assert first(name="other").key == base.key
    others = [base, first(seed=8), first(system=with_numbers(DEVICE, {"parts.upper.restitution": 0.9}))]
    others.append(first(system=sp.System(**{**dict(DEVICE.named()), "more": sp.Dashpot(0.1)})))
    assert len({task.key for task in others}) == len({task.seed for task in others}) == len(others)


def test_a_part_that_is_left_out_at_a_point_keeps_the_names_of_a_system() -> None:
    """Without its hardening the device is an oscillator: its results are a system's, there too."""
    device = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.5), sp.WhiteNoise(1.0), stop=sp.Barrier(-0.5, 0.8),
                       magnet=sp.PolynomialSpring((0.0, 0.0, 1.0)))  # fmt: skip
    monte_carlo = {"paths": 256, "duration": 40.0, "step": 0.05}
    tree = sp.study(
        {"name": "bare", "system": device, "methods": ["averaging", "envelope", "monte_carlo"],
         "axes": {"parts.magnet.coefficients.3": [0.0]}, "monte_carlo": monte_carlo}
    )  # fmt: skip
    cell = tree["simulation"].to_dataset().isel(magnet_coefficients_3=0)
    balance = float(cell["input_power"] - cell["damping_power"] - cell["barrier_power"].sel(barrier="stop"))
    assert abs(balance) < 0.1 * float(cell["input_power"])
    alone = sp.simulate(with_numbers(device, {"parts.magnet.coefficients.3": 0.0}), **monte_carlo, seed=2)
    for name in ("x_mean_square", "impact_rate"):
        gap = float(cell[name]) - alone[name].value
        assert abs(gap) < 5.0 * math.hypot(alone[name].error, float(cell[f"{name}_se"]))
    envelope = tree["theory"].to_dataset().isel(magnet_coefficients_3=0).sel(theory="envelope")
    assert float(envelope["barrier_impact_rate"].sel(barrier="stop")) == float(envelope["impact_rate"]) > 0.0


def test_a_record_is_run_from_its_beginning() -> None:
    shaken = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), shake=sp.RecordedExcitation((0.0, 1.0, 2.0), (0.0, 1.0, 0.0)))
    asked = {**STOPS, "system": shaken, "methods": ["monte_carlo"], "axes": {"parts.spring.stiffness": [1.0]},
             "quantities": ["x_mean_square"], "monte_carlo": {"paths": 2, "step": 0.05}}  # fmt: skip
    asked.pop("zipped")
    (task,) = tasks.tasks(read_study(asked))
    assert "start" not in task.settings
    assert tasks.check_some(read_study(asked), 10) == 1


SPRINGLESS = sp.System(sp.Dashpot(1.0), sp.WhiteNoise(1.0), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below"))


def test_without_a_linear_spring_the_quantity_is_that_of_a_run() -> None:
    asked = {"name": "free", "system": SPRINGLESS, "methods": ["exact"], "axes": {"parts.dashpot.coefficient": [1.0]}}
    assert read_study(asked).quantities == ("v_mean_square",)
    assert read_study({**asked, "system": DEVICE, "axes": {"parts.mass.value": [1.0]}}).quantities == (
        "amplitude_mean_square",
    )


AXES = "axes: "
BAD: list[tuple[dict[str, Any], str]] = [
    ({"axes": {"parts.lwr.position": [0.1]}}, f"{AXES}the system has no part 'lwr'; did you mean lower?"),
    ({"axes": {"parts.stop.position": [0.1]}}, f"{AXES}the system has no part 'stop': its parts are mass, spring, "),
    ({"axes": {"parts.lower.restituton": [0.1]}}, f"{AXES}lower (barrier) has no number 'restituton'; did you mean "),
    (
        {"axes": {"parts.lower.free_side": [0.1]}},
        f"{AXES}lower (barrier) has no number 'free_side'; its numbers are position",
    ),
    ({"axes": {"parts.magnet.coefficients.4": [0.1]}}, f"{AXES}magnet (polynomial_spring) has no number 'coef"),
    ({"axes": {"restitution": [0.1]}}, f"{AXES}'restitution' must be parts.<name>.<number>; did you mean parts.lower."),
    ({"axes": {"parts": {"lower": {"restitution": 0.5}}}}, "axes.parts.lower.restitution: an axis must be a list of"),
    (
        {"axes": {"parts.lower.restitution": [0.5, 1.5]}, "zipped": {}},
        "at parts.lower.restitution = 1.5: lower.restitution must be in [0, 1], not 1.5. An elastic wall has 1, a "
        "plastic impact 0.",
    ),
    (
        {"axes": {"parts.lower.position": [-0.1, 0.2], "parts.upper.position": [0.1, 0.3]}, "zipped": {}},
        "at parts.lower.position = 0.2, parts.upper.position = 0.1: the walls must leave room: x >= 0.2 and x <= 0.1",
    ),
    ({"axes": {"parts.lower.position": [-0.1]}}, "parts.lower.position is on two axes: leave out one of the two."),
    ({"axes": {}, "zipped": {}}, "there must be an axis, such as [axes] parts.mass.value = [0.25, 0.5]."),
    ({"zipped": {"gap": {"parts.uppr.position": [0.1]}}}, "zipped.gap: the system has no part 'uppr'; did you mean"),
    ({"zipped": {"barrier": {"parts.upper.position": [0.1]}}}, "zipped axis 'barrier' needs a name of its own"),
    ({"quantities": ["left_impact_rate"]}, "quantities, number 1: must be 'amplitude_mean_square', "),
    ({"fixed": {"order": 0.5}}, "fixed is for oscillators: the system has its numbers, so change them there."),
    ({"monte_carlo": {"path_times": 1e5}}, "'path_times' is not a key of [monte_carlo]"),
    ({"system": "nowhere.toml"}, "system: there is no file 'nowhere.toml'."),
    ({"system": 3}, "system must be a System, not 3. In a file it is the place of the system's file, in quotes."),
    (
        {
            "system": sp.System(sp.Spring(1.0), sp.Dashpot(1.0), magnet=sp.Force(lambda t, x, v: 0.0)),
            "axes": {"parts.spring.stiffness": [1.0]},
            "zipped": {},
            "quantities": ["x_mean"],
        },
        "system: magnet has a function, which cannot be kept in a store.",
    ),
    (
        {
            "system": sp.System(
                sp.Spring(1.0),
                sp.Dashpot(1.0),
                a=sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(1.0)),
                a_spring=sp.Spring(1.0),
            ),
            "axes": {"parts.a.spring.stiffness": [1.0], "parts.a_spring.stiffness": [1.0]},
            "zipped": {},
            "quantities": ["x_mean"],
        },
        "parts.a.spring.stiffness would be a_spring_stiffness in the results, as another number is: rename the part.",
    ),
]


@pytest.mark.parametrize(("changes", "says"), BAD, ids=[str(number) for number in range(len(BAD))])
def test_a_bad_study_is_refused_in_one_sentence(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=r"^the study is not right: ") as caught:
        given(STOPS, **changes)
    sentence = str(caught.value)
    assert sentence.removeprefix("the study is not right: ").startswith(says)
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))


def test_other_sentences(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match=r"^source must be a study file .*'system': \.\.\.\}, not System\(.*\)\.$"):
        sp.study(DEVICE)  # type: ignore[arg-type]
    theory = {"name": "orders", "methods": ["linear"], "axes": {"order": [0.5]}}
    assert read_study(theory).methods == ("linear",)  # every method takes every problem
    with pytest.raises(ValueError, match=r"'parts\.lower\.position' is a number of a system: name its file too"):
        read_study({**theory, "axes": {"parts.lower.position": [0.1]}})
    with pytest.raises(ValueError, match=r"^the system is not right: parts\[0\] \(spring\) needs stiffness"):
        given(STOPS, system={"parts": [{"kind": "spring"}]})
    (tmp_path / "device.toml").write_text("[[parts]]\nkind = 'sprig'\n", encoding="utf-8")
    file = write_toml(tmp_path / "study.toml", {**STOPS, "system": "device.toml"})
    with pytest.raises(ValueError, match=r"^system file '.*device\.toml' is not right: parts\[0\]\.kind must be"):
        read_study(file)


def test_what_only_the_settings_know_is_told_before_work_with_its_point() -> None:
    coarse = given(STOPS, monte_carlo={"paths": 2, "duration": 5.0, "step": 1.0})
    with pytest.raises(ValueError, match=r"^at parts\.lower\.restitution = 1, parts\.magnet.* step is 1 s, too coarse"):
        tasks.check_some(coarse, 4)
    axes = {"parts.upper.restitution": [0.1, 0.9]}
    crowded = given(STOPS, axes=axes, zipped={}, monte_carlo={"rtol": 0.1})
    with pytest.raises(ValueError, match=r"^at .* = 0\.1: quantities must not have upper_impact_rate, which has"):
        tasks.check_some(crowded, 4)


def test_a_bad_corner_of_a_large_grid_is_found_when_it_is_read() -> None:
    """Too many points to try them all: the corners are."""
    axes = {
        "parts.lower.position": {"linspace": [-1.0, 0.1, 1000]},
        "parts.upper.position": {"linspace": [0.1, 1, 999]},
    }
    with pytest.raises(ValueError, match=r"at parts\.lower\.position = 0\.1, parts\.upper\.position = 0\.1: the walls"):
        given(STOPS, axes=axes, zipped={})


def test_the_schema_knows_both_kinds() -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    validator = jsonschema.Draft202012Validator(Study.model_json_schema())
    right = {**STOPS, "system": "device.toml"}
    nested = {**right, "axes": {"parts": {"lower": {"restitution": [0.5]}}}}
    for good in (right, nested, {**right, "system": DEVICE.to_dict()}):
        assert list(validator.iter_errors(json.loads(json.dumps(good)))) == []
    for change in ({"axes": {"order": [0.5]}}, {"fixed": {}}, {"system": 3}, {"methods": ["linea"]}):
        assert list(validator.iter_errors({**right, **change})), change
    alone = {name: value for name, value in right.items() if name != "system"}
    assert list(validator.iter_errors(alone))


def test_the_command_checks_runs_and_draws(place: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = with_device(tmp_path / "stops.toml", STOPS)
    assert cli.main(["study", "check", str(file), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["shape"] == {"lower_restitution": 2, "magnet_coefficients_3": 2, "gap": 2}
    assert found["without_answer"] == {"exact": 0.5, "linear": 1.0, "monte_carlo": 0.0}
    assert 0.0 < found["processor_seconds"]["monte_carlo"] < 60.0
    for number, flags in enumerate([["--kind", "map"], ["--along", "gap", "--quantities", "upper_power"]]):
        out = tmp_path / f"{number}.png"
        assert cli.main(["study", "plot", str(place), "--out", str(out), *flags]) == 0
        assert out.read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()
    assert cli.main(["study", "plot", str(place), "--out", str(tmp_path / "a.png"), "--quantities", "left_power"]) == 2
    assert "--quantities must be among amplitude_mean_square, " in capsys.readouterr().err


def test_new_writes_a_study_of_a_system(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "devices").mkdir()
    device = tmp_path / "devices" / "stops.toml"
    device.write_text(sp.to_toml(DEVICE), encoding="utf-8")
    file = tmp_path / "study.toml"
    assert cli.main(["study", "new", str(file), "--system", str(device)]) == 0
    found = read_study(file)
    assert (found.system, found.shape) == (DEVICE, {"spring_stiffness": 2})
    text = file.read_text(encoding="utf-8")
    every = text.replace("\n# parts.", "\nparts.")
    file.write_text(every, encoding="utf-8")
    assert {*read_study(file).axes} == {*numbers_of(DEVICE)}
    capsys.readouterr()
    assert cli.main(["study", "new", str(tmp_path / "b.toml"), "--system", str(tmp_path / "none.toml")]) == 2
    assert "There is no file" in capsys.readouterr().err
    assert not (tmp_path / "b.toml").exists()


def test_panels_of_walls(place: Path) -> None:
    figure = sp.figures.plot_study(sp.open_study(place), quantities=["barrier_impact_rate"], along="gap")
    drawn = [axes for axes in figure.axes if axes.axison]
    assert len(drawn) == 8
    assert drawn[0].get_title() == "lower, lower.restitution = 1,\nmagnet.coefficients.3 = 400000"
    assert drawn[-1].get_title() == "upper, lower.restitution = 0.8,\nmagnet.coefficients.3 = 800000"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["exact", "Monte Carlo, 95 %"]
    one = sp.figures.plot_study(sp.open_study(place), quantities=["upper_power"], along="lower_restitution")
    assert [axes.get_xlabel() for axes in one.axes][-1] == "lower.restitution"
    assert one.axes[0].get_ylabel() == "power (W)"


@pytest.mark.validation  # every day: that of oscillators, killed
def test_an_interrupted_study_is_completed_to_the_same_bytes(place: Path, tmp_path: Path) -> None:
    path = tmp_path / "study.zarr"
    assert run_study(given(STOPS), path, threads=1, shard=(2, 3)).computed == 8
    replaced(path, 0, b"damaged\n")
    assert run_study(given(STOPS), path, threads=2).computed == 17
    assert content(path) == content(place)
    assert orphans(path) == []


def test_a_task_is_the_run_of_its_system() -> None:
    task = tasks.task_at(given(STOPS), "monte_carlo", 3)
    assert isinstance(task.system, sp.System)
    found = simulate(task.system, **task.settings, seed=task.seed)
    numbers = dict(named(task, tasks.compute(task).numbers))
    values = {name: estimate.value for name, estimate in found.estimates.items()}
    assert {name: numbers[name] for name in values} == pytest.approx(values, rel=0.0, abs=0.0, nan_ok=True)


def test_the_example_of_a_system_names_theories_that_answer() -> None:
    linear = sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0)
    assert of_system(sp.System(*linear), "a.toml")["methods"] == '"linear", "envelope", "linearization", "monte_carlo"'
    assert of_system(sp.System(*linear, sp.Barrier(-1.0)), "a.toml")["methods"] == '"envelope", "monte_carlo"'
