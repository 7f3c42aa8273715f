"""The study file: what it may say, what it means, and one clear sentence for what is wrong in it."""

from __future__ import annotations

import copy
import json
import math
import sys
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.recommendation import all_methods
from springpot.machine.faults import FileError
from springpot.simulation.plan.plan import COARSEST
from springpot.studies.axes import spread
from springpot.studies.question import Method, Study, read_study, system_at
from springpot.studies.tables import PARAMETERS
from springpot.studies.tasks import check_some, task_at, tasks
from springpot.studies.template import OF_OSCILLATORS, TEMPLATE
from springpot.theory.result import MOMENTS
from tests.posix import link, make_pipe
from tests.studies.samples import DEVICE, RUNS, THEORY, given, write_toml

SCHEMA = Path(__file__).resolve().parents[2] / "docs" / "study.schema.json"
GIVEN: dict[str, Any] = {"name": "orders", "methods": ["averaging"], "axes": {"order": [0.5]}}
FORMS = "an axis must be a list of numbers, {linspace = [start, end, count]} or {geomspace = [start, end, count]}"
MONTE_CARLO = {"methods": ["monte_carlo"]}

BAD: list[tuple[dict[str, Any], str]] = [
    ({"name": ""}, "name: must not be empty."),
    ({"name": 3}, "name: must be a text in quotes, not 3."),
    ({"sed": 1}, "'sed' is not a key of a study file; did you mean seed?"),
    ({"methods": []}, "methods: must not be empty."),
    ({"methods": "averaging"}, "methods: must be a list, not 'averaging'."),
    ({"methods": ["averaging", "averaging"]}, "methods names averaging twice."),
    ({"seed": -1}, "seed: must be greater than or equal to 0, not -1."),
    ({"seed": 1.5}, "seed: must be a whole number, not 1.5."),
    ({"seed": True}, "seed: must be a whole number, not True."),
    ({"quantities": []}, "quantities: must not be empty."),
    ({"quantities": ["x_mean", "x_mean"]}, "quantities names x_mean twice."),
    ({"fixed": 3}, "fixed: must be a table, not 3."),
    (
        {"fixed": {"wall": 1.0}},
        "'wall' is not a key of [fixed]: its keys are order, coefficient, natural_frequency, intensity, position, "
        "restitution, free_side and barrier.",
    ),
    (
        {"axes": {"naturl_frequency": [1.0]}},
        "'naturl_frequency' is not a key of [axes]; did you mean natural_frequency?",
    ),
    ({"zipped": {"case": {"ordr": [1.0]}}}, "'ordr' is not a key of [zipped.case]; did you mean order?"),
    (
        {"fixed": {"natural_frequency": 0.0}},
        "fixed.natural_frequency must be in [1e-50, 1e+50], not 0. It is Omega in rad/s.",
    ),
    ({"fixed": {"natural_frequency": "3"}}, "fixed.natural_frequency: must be a number, not '3'."),
    (
        {"quantities": ["x_mean", "impact_rat"]},
        "quantities, number 2: must be 'amplitude_mean_square', 'x_mean', 'x_mean_square', 'v_mean_square', "
        "'impact_rate', 'impact_speed_mean', 'impact_speed_mean_square', 'barrier_impact_rate', "
        "'barrier_impact_speed_mean', 'barrier_force_mean', 'damping_force_mean', 'damping_power', 'damping_virial', "
        "'input_power', 'barrier_power', 'energy_residual', 'x_mean_end', 'x_mean_square_end', "
        "'v_mean_square_end' or 'amplitude_mean_square_end', not 'impact_rat'; did you mean impact_rate?",
    ),
    ({"seed": 16**5000}, "seed: must be less than or equal to 9223372036854775807, not a very long number."),
    (
        {"axes": {"position": {"linspace": [-1e308, 1e308, 3]}}},
        "axes.position: linspace's start and end are too far apart for double precision.",
    ),
    (
        {"zipped": {"case": {"coefficient": [1.0, -1.0]}}},
        "zipped.case.coefficient must be in [0, 1e+50], not -1. It is the springpot's force per unit of D^alpha x.",
    ),
    (
        {"axes": {"order": {"linspace": [0, 1, 510_000]}, "coefficient": {"linspace": [0, 1, 510_000]}}},
        "the axes have more than 1,000,000 values together: make them shorter.",
    ),
    ({"methods": ["averaging"] * 400_000}, "methods: must have at most 13 items, not 400000."),
    (
        {"fixed": {"restitution": 1.5}},
        "fixed.restitution must be in [0, 1], not 1.5. An elastic wall has 1, a plastic impact 0.",
    ),
    ({"fixed": {"restitution": "1"}}, "fixed.restitution: must be a number, not '1'."),
    ({"fixed": {"intensity": math.inf}}, "fixed.intensity: must be a finite number, not inf."),
    ({"fixed": {"side": "below"}}, "'side' is not a key of [fixed]; did you mean free_side?"),
    ({"fixed": {"free_side": "left"}}, "fixed.free_side: must be 'above' or 'below', not 'left'."),
    ({"fixed": {"order": 0.5}}, "order is fixed and is also on an axis: leave out one of the two."),
    (
        {"fixed": {"barrier": False, "position": 0.5}},
        "fixed.barrier = false cannot be combined with position, restitution or free_side: there is no wall.",
    ),
    ({"axes": {}}, "there must be an axis, such as [axes] order = [0.25, 0.5]."),
    ({"axes": [0.5]}, "axes: must be a table."),
    ({"axes": {"order": []}}, "axes.order: an axis must have at least one value."),
    ({"axes": {"order": 0.5}}, f"axes.order: {FORMS}, not 0.5."),
    ({"axes": {"order": {"logspace": [0, 1, 5]}}}, f"axes.order: {FORMS}, not {{'logspace': [0, 1, 5]}}."),
    ({"axes": {"order": ["a"]}}, "axes.order: every value must be a real number, not 'a' (str)."),
    ({"axes": {"order": [math.nan]}}, "axes.order: every value must be a finite number, not nan."),
    ({"axes": {"order": [0.5, 0.5]}}, "axis order holds 0.5 twice."),
    (
        {"axes": {"order": [1.5]}},
        "axes.order must be in [0, 1], not 1.5. It runs from 0 (a spring) to 1 (a dashpot).",
    ),
    ({"axes": {"order": {"linspace": [0, 1]}}}, "axes.order: linspace must be [start, end, count], not [0, 1]."),
    (
        {"axes": {"order": {"linspace": [0, 1, 2.5]}}},
        "axes.order: linspace's count must be a whole number from 1 to 1,000,000, not 2.5.",
    ),
    (
        {"axes": {"order": {"linspace": [0, 1, 10**9]}}},
        "axes.order: linspace's count must be a whole number from 1 to 1,000,000, not 1000000000.",
    ),
    ({"axes": {"order": {"geomspace": [0, 1, 5]}}}, "axes.order: geomspace's start and end must be positive."),
    ({"zipped": {"case": {"order": [0.5]}}}, "order is on two axes: leave out one of the two."),
    (
        {"zipped": {"case": {"coefficient": [1.0], "intensity": [1.0, 2.0]}}},
        "zipped axis case needs at least one column, and columns of equal length.",
    ),
    ({"zipped": {"order": {"coefficient": [1.0]}}}, "zipped axis 'order' needs a name of its own, such as case."),
    ({"zipped": {"said": {"coefficient": [1.0]}}}, "zipped axis 'said' needs a name of its own, such as case."),
    ({"zipped": {"my case": {"coefficient": [1.0]}}}, "zipped axis 'my case' needs a name of its own, such as case."),
    (
        {"zipped": {"case": {"coefficient": [1.0, 1.0], "intensity": [2.0, 2.0]}}},
        "axis case holds (1.0, 2.0) twice.",
    ),
    (MONTE_CARLO, 'methods must name "monte_carlo" if, and only if, there is a table [monte_carlo].'),
    (
        {"monte_carlo": {"rtol": 0.1}},
        'methods must name "monte_carlo" if, and only if, there is a table [monte_carlo].',
    ),
    (
        MONTE_CARLO | {"monte_carlo": {}},
        "monte_carlo: say how: rtol = 0.02, or settings such as paths and duration.",
    ),
    (
        MONTE_CARLO | {"monte_carlo": {"rtol": 0.1, "paths": 5}},
        "monte_carlo: rtol chooses all settings, so paths cannot be given with it.",
    ),
    (MONTE_CARLO | {"monte_carlo": {"rtol": 2}}, "monte_carlo.rtol: must be less than or equal to 0.5, not 2."),
    (MONTE_CARLO | {"monte_carlo": {"paths": 5.5}}, "monte_carlo.paths: must be a whole number, not 5.5."),
    (MONTE_CARLO | {"monte_carlo": {"path": 5}}, "'path' is not a key of [monte_carlo]; did you mean paths?"),
    (
        {"axes": {"order": {"linspace": [0, 1, 5000]}, "coefficient": {"linspace": [0, 1, 5000]}}},
        "there are more than 10,000,000 tasks: make the axes shorter.",
    ),
]


@pytest.mark.parametrize(("change", "sentence"), BAD, ids=[sentence[:40] for _, sentence in BAD])
def test_what_is_wrong_is_told_in_one_sentence(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=r"^the study is not right: ") as told:
        read_study({**GIVEN, **change})
    assert str(told.value) == f"the study is not right: {sentence}"


@pytest.mark.parametrize("name", ["methods", "quantities"])
def test_an_unknown_word_is_answered_with_those_there_are(name: str) -> None:
    with pytest.raises(ValueError, match="not 'avering'") as told:
        read_study({**GIVEN, name: ["avering"]})
    words = get_args(Method) if name == "methods" else MOMENTS
    assert all(repr(word) in str(told.value) for word in words)


def test_a_name_that_is_missing() -> None:
    with pytest.raises(ValueError, match=r"^the study is not right: name is missing\.$"):
        read_study({"methods": ["averaging"], "axes": {"order": [0.5]}})


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (b"name = 'x\n", "is not TOML: "),
        (b"\xff\xfe", "is not text in UTF-8."),
        (
            b"name = 'x'\nmethods = ['averaging']\n[axes]\norder = [2.0]\n",
            "is not right: axes.order must be in [0, 1], not 2.",
        ),
    ],
)
def test_a_file_that_is_wrong_is_named(text: bytes, sentence: str, tmp_path: Path) -> None:
    place = tmp_path / "bad.toml"
    place.write_bytes(text)
    with pytest.raises(ValueError, match=r"^study file ") as told:
        read_study(place)
    assert f"study file {str(place)!r} {sentence}" in str(told.value)
    assert "\n" not in str(told.value)


HOSTILE = {
    "dotted key": ("a." * 40_000 + "a = 1", "has a key of more than 8 parts (a.b.c has three)."),
    "dotted key in quotes": ('"a" . ' * 20_000 + "a = 1", "has a key of more than 8 parts (a.b.c has three)."),
    "dotted table": ("[" + "a." * 40_000 + "a]", "has a key of more than 8 parts (a.b.c has three)."),
    "arrays": ("a = " + "[" * 40_000 + "]" * 40_000, "is nested deeper than 8 brackets."),
    "open arrays": ("a = " + "[\n" * 40_000, "is nested deeper than 8 brackets."),
    "inline tables": ("a = " + "{a = " * 20_000 + "1" + "}" * 20_000, "is nested deeper than 8 brackets."),
    "size": ("#" * 2_000_001, "cannot be read: it has more than 2,000,000 bytes."),
    "open text": ('name = """' + '\\"' * 200_000, "is not TOML: Unterminated string (at end of document)."),
    "a long key": ("k" * 900_000 + " = 1", "is not a key of a study file: its keys are name, "),
    "many keys": ("\n".join(f"k{i} = 1" for i in range(30_000)), "'k0' is not a key of a study file: its keys are"),
    "a long number": ("seed = " + "9" * 100_000, "holds a number with thousands of digits."),
    "a null byte": ("name = 'a\0b'", "is not TOML: "),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_file_is_refused_in_time_proportional_to_its_length(case: str, tmp_path: Path) -> None:
    text, sentence = HOSTILE[case]
    place = tmp_path / "hostile.toml"
    place.write_text(text, encoding="utf-8")
    begun = time.process_time()
    with pytest.raises(ValueError, match=r"^study file ") as told:
        read_study(place)
    assert time.process_time() - begun < 5.0  # they take some tenths; without bounds a minute, or for ever
    assert sentence in str(told.value)
    assert len(str(told.value)) < 500


@pytest.mark.parametrize(
    "text",
    [
        '"""[[[[[[[[[[ a.b.c.d.e.f.g.h.i.j \\""" \n"""',
        "'''[[[[[[[[[['''",
        '"[[[[[[[[[[\\"["',
        "'[[[[[[[[['",
        '""""a[[[[[[[[["""""',
    ],
)
def test_brackets_within_texts_and_comments_are_no_nesting(text: str, tmp_path: Path) -> None:
    place = tmp_path / "study.toml"
    name = f"\ufeff# [[[[[[[[[[ it's \"\nname = {text}\n"
    place.write_text(f"{name}methods = ['averaging'] # }}}}\n[axes]\norder = [0.5]\n", encoding="utf-8")
    assert "[[[" in read_study(place).name


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda place: place.mkdir(), "it is a folder, not a file"),
        (lambda place: make_pipe(place), "it is not a file, but a pipe or a device"),
        (lambda place: link(place, "/dev/zero"), "it is not a file, but a pipe or a device"),
        (lambda place: link(place, place), "it is a link that leads back to itself"),
    ],
)
def test_what_is_no_file_is_not_read(make: Callable[[Path], None], says: str, tmp_path: Path) -> None:
    place = tmp_path / "study.toml"
    make(place)
    with pytest.raises(ValueError, match=f"^study file .* cannot be read: {says}"):
        read_study(place)


@pytest.mark.parametrize(
    ("place", "says"),
    [(Path("n" * 300 + ".toml"), "file name too long"), (Path("/proc/self/mem"), "input/output error")],
)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc")
def test_a_file_that_the_system_cannot_read_is_bad_input(place: str, says: str) -> None:
    with pytest.raises(FileError, match=f"^study file .* cannot be read: {says}\\.$"):
        read_study(place)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"^There is no file '.*none\.toml'\.$"):
        read_study(tmp_path / "none.toml")


def test_large_axes_are_checked_in_time_proportional_to_their_length() -> None:
    """A repeated value among many took the square of their number."""
    values = (np.arange(100_001) % 100_000 / 1e5).tolist()
    begun = time.process_time()
    with pytest.raises(ValueError, match=r"axis order holds 0\.0 twice"):
        read_study({**GIVEN, "axes": {"order": values}})
    study = read_study({**GIVEN, "axes": {"order": {"linspace": [0.1, 1.0, 200_000]}, "restitution": [0.5, 1.0]}})
    assert time.process_time() - begun < 4.0  # half a second
    assert study.shape == {"order": 200_000, "restitution": 2}


def test_a_point_by_its_index_is_that_of_the_grid() -> None:
    study = given(RUNS, zipped={"case": {"coefficient": [0.1, 0.5, 2.0], "position": [0.0, 0.1, 0.2]}})
    assert [study.point(index) for index in range(18)] == list(study.points())


def test_a_study_without_a_wall_has_points_without_one() -> None:
    content = read_study(
        {"name": "free", "methods": ["linear"], "fixed": {"barrier": False}, "axes": {"order": [0.5, 1]}}
    )
    assert [task.point["order"] for task in tasks(content)] == [0.5, 1.0]
    assert [system_at(point, content.system) for point in content.points()] == [
        sp.Oscillator.from_numbers(order=order, barrier=False) for order in (0.5, 1.0)
    ]


def test_a_task_by_its_index_is_that_of_the_list() -> None:
    study = given(RUNS)
    mine = [task for task in tasks(study) if task.method == "monte_carlo"]
    assert [task_at(study, "monte_carlo", index) for index in range(len(mine))] == mine


def test_a_sample_is_from_all_over_the_grid() -> None:
    chosen = sorted(spread(10_000_000, 500))
    assert len(chosen) == 500
    assert max(np.diff(chosen)) < 2.7 * 10_000_000 / 500
    assert sorted(spread(500, 500)) == [*range(500)]


def test_the_corners_of_a_large_grid_are_checked() -> None:
    """The step is too coarse for the fastest oscillators only, one point in a thousand."""
    axes = {"order": {"linspace": [0.1, 1.0, 1000]}, "natural_frequency": {"linspace": [1.0, 10.0, 1000]}}
    settings = {"paths": 10, "duration": 5.0, "step": COARSEST / 9.999}
    study = read_study({**GIVEN, **MONTE_CARLO, "axes": axes, "monte_carlo": settings})
    with pytest.raises(ValueError, match=r"^at order = 0\.1, natural_frequency = 10: step is .*, too coarse"):
        check_some(study, 4)
    finer = read_study({**GIVEN, **MONTE_CARLO, "axes": axes, "monte_carlo": {**settings, "step": COARSEST / 10.001}})
    assert check_some(finer, 4) == 8


def test_a_setting_that_fits_nowhere_is_told_before_work() -> None:
    study = read_study({**GIVEN, **MONTE_CARLO, "monte_carlo": {"paths": 10, "duration": 5.0, "window": [3.0, 9.0]}})
    with pytest.raises(ValueError, match=r"^at order = 0\.5: window "):
        check_some(study, 500)


def test_ranges() -> None:
    study = read_study(
        {**GIVEN, "axes": {"order": {"linspace": [0.1, 0.9, 9]}, "coefficient": {"geomspace": [0.01, 10, 4]}}}
    )
    assert study.axes["order"] == (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
    assert study.axes["coefficient"] == (0.01, 0.1, 1.0, 10.0)
    points = list(study.points())
    assert len(points) == 36
    assert [(point["order"], point["coefficient"]) for point in points[:5]] == [
        (0.1, 0.01),
        (0.1, 0.1),
        (0.1, 1.0),
        (0.1, 10.0),
        (0.2, 0.01),
    ]


def test_a_finer_range_meets_the_points_of_the_coarser_one() -> None:
    def orders(count: int) -> set[int]:
        study = read_study({**GIVEN, "axes": {"order": {"linspace": [0.1, 0.9, count]}}})
        return {task.key for task in tasks(study)}

    assert orders(5) < orders(9) < orders(17)


def test_an_array_is_an_axis_too() -> None:
    assert read_study({**GIVEN, "axes": {"order": np.linspace(0.25, 1.0, 4)}}).axes["order"] == (0.25, 0.5, 0.75, 1.0)


def test_zipped_columns_run_together() -> None:
    study = read_study({**GIVEN, "zipped": {"case": {"coefficient": [0.1, 0.5], "natural_frequency": [1.0, 2.0]}}})
    assert study.shape == {"order": 1, "case": 2}
    assert [(point["coefficient"], point["natural_frequency"]) for point in study.points()] == [(0.1, 1.0), (0.5, 2.0)]


def test_keys_come_from_content() -> None:
    """Neither the place in the grid nor the way a number is written changes a task; everything in its answer does."""

    def only(**changes: Any) -> Any:
        (task,) = tasks(read_study({**RUNS, **MONTE_CARLO, "axes": {"order": [0.5]}, **changes}))
        return task

    def runs(**settings: Any) -> Any:
        return only(monte_carlo={**RUNS["monte_carlo"], **settings})

    base = only()
    for same in (
        only(axes={"order": [0.5]}, fixed={"coefficient": 1}),
        only(name="otherwise"),
        only(quantities=["x_mean"]),
        runs(duration=20),
        list(tasks(read_study({**RUNS, **MONTE_CARLO, "axes": {"order": [0.1, 0.5]}})))[1],
    ):
        assert (same.key, same.seed) == (base.key, base.seed)
    others = [
        base,
        only(seed=8),
        runs(paths=129),
        only(fixed={"free_side": "below"}),
        only(axes={"order": [0.5000001]}),
    ]
    assert len({task.key for task in others}) == len({task.seed for task in others}) == len(others)


def test_monte_carlo_starts_stationary_unless_the_file_says_otherwise() -> None:
    """A start left out is the stationary one, with the same key; with an initial state the run starts from that."""

    def task(**settings: Any) -> Any:
        monte_carlo = {"paths": 128, "duration": 20.0, **settings}
        return next(tasks(read_study({**RUNS, "methods": ["monte_carlo"], "monte_carlo": monte_carlo})))

    left_out, stationary, rest = task(), task(start="stationary"), task(start="rest")
    assert left_out == stationary
    assert left_out.key != rest.key
    assert "start" not in task(initial_velocity=1.0).settings
    assert "start" not in task(derivative="riemann-liouville").settings
    by_rtol = read_study({**RUNS, "methods": ["monte_carlo"], "monte_carlo": {"rtol": 0.1}})
    assert next(tasks(by_rtol)).settings == {"rtol": 0.1}


def test_names_are_those_of_the_library() -> None:
    both = {*all_methods(sp.Oscillator()), *all_methods(DEVICE)} - {"recommended", "why_none_is_recommended"}
    assert {*get_args(Method)} == {*both, "monte_carlo", "exceedance"}
    assert set(PARAMETERS) < set(Study.model_fields["fixed"].annotation.model_fields)  # type: ignore[union-attr]


def test_a_study_survives_its_document(tmp_path: Path) -> None:
    for content in (RUNS, THEORY):
        assert read_study(write_toml(tmp_path / "study.toml", content)) == read_study(content)


def example() -> dict[str, Any]:
    places = {"file": "f", "store": "s", "picture": "p", "table": "t"}
    return tomllib.loads(TEMPLATE.format(name='"example"', **places, **OF_OSCILLATORS))


def test_the_example_is_a_study() -> None:
    study = read_study(example())
    assert study.shape == {"order": 9, "restitution": 3}
    check_some(study, 500)


def test_the_published_schema_is_current() -> None:
    """Made by ``springpot study schema > docs/study.schema.json``."""
    assert json.loads(SCHEMA.read_text(encoding="utf-8")) == Study.model_json_schema()


def test_the_schema_tells_right_from_wrong() -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    validator = jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text(encoding="utf-8")))
    for right in (example(), RUNS, THEORY):
        assert list(validator.iter_errors(right)) == []
    for place, wrong in (
        (("axes", "order"), 0.5),
        (("axes", "order"), {"linspace": [0, 1]}),
        (("axes", "ordr"), [0.5]),
        (("methods",), ["avering"]),
        (("seed",), -1),
        (("sed",), 1),
        (("monte_carlo", "rtol"), 2.0),
        (("fixed", "free_side"), "left"),
    ):
        content = copy.deepcopy(example())
        table = content
        for name in place[:-1]:
            table = table[name]
        table[place[-1]] = wrong
        assert list(validator.iter_errors(content)), place
