"""Records with their input that are not right: one sentence each, which says what."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from tests.sizes import validation

RATE = 250.0  # per s
TIME = np.arange(500) / RATE


def mount(k: Any, C: Any, *more: Any) -> sp.System:
    return sp.System(sp.Mass(0.2), sp.Spring(k), sp.Springpot(0.5, C), *more)


@cache
def shaken() -> tuple[Floats, Floats]:
    """A force, and the displacement of a mount of 80 N/m and 2 N s^0.5/m, with noise of 1 %."""
    rng = np.random.default_rng(1)
    band = scipy.signal.butter(4, (2.0, 40.0), "bandpass", fs=RATE, output="sos")
    force = scipy.signal.sosfilt(band, rng.standard_normal(TIME.size))
    shaker = sp.RecordedExcitation(tuple(TIME), tuple(force), "mass", interpolation="band-limited")
    run = sp.simulate(
        mount(80.0, 2.0, shaker), paths=1, record=1, start="rest", step=0.1 / RATE, record_every=10, duration=TIME[-1],
        seed=1,
    )  # fmt: skip
    x = run.record[0, :, 0]
    return force, x + 0.01 * x.std() * rng.standard_normal(x.size)


def record(**changes: Any) -> sp.MeasuredRecord:
    force, x = shaken()
    return sp.MeasuredRecord(**{"time": TIME, "values": x, "input": force, "start": "rest"} | changes)


def holed(values: Floats) -> Floats:
    return np.where(np.arange(values.size) == 17, np.nan, values)


WRONG: list[tuple[str, Callable[[Floats, Floats], dict[str, Any]], str]] = [
    ("unequal lengths", lambda f, _: {"input": f[:-1]}, r"input must have one number for each of the 500 times.*499"),
    ("no force", lambda f, _: {"input": 0.0 * f}, "input must not be constant: nothing drove the device."),
    ("constant force", lambda f, _: {"input": 0.0 * f + 3.0}, "input must not be constant"),
    ("hole in the force", lambda f, _: {"input": holed(f)}, r"input\[17\] must be a finite number, not nan"),
    ("hole in the response", lambda _, x: {"values": holed(x)}, r"values\[17\] must be a finite number, not nan"),
    ("no motion", lambda _, x: {"values": 0.0 * x}, "values must not all be equal: there is no motion"),
    ("uneven times", lambda *_: {"time": TIME + 0.01 * (TIME > 1.0)}, r"time\[251\] must follow at equal steps"),
    ("times fall", lambda *_: {"time": np.abs(TIME - 1.0)}, r"time\[1\] must be later than the time before"),
    ("too few", lambda f, x: {"time": TIME[:20], "values": x[:20], "input": f[:20]}, "at least 32 samples, not 20"),
    ("long skip", lambda *_: {"skip": 1.5}, r"skip must be in \[0, 0.998\], not 1.5. It is the part of the beginning"),
    ("long delay", lambda *_: {"delay": 1.0}, r"delay must be in \[-0.08, 0.08\], not 1"),
    ("one row of two", lambda *_: {"at": ("box", "lid")}, "values must have a row for each of the 2 points, not 1"),
    ("two of three", lambda *_: {"at": ("a", "b", "c"), "of": ("x", "v")}, "of and at must be of as many points"),
    ("two inputs", lambda f, _: {"input": [f, f]}, "input must have one row, not 2"),
    ("no input", lambda *_: {"input": None}, "start must be left out of a record without an input"),
    ("other start", lambda *_: {"start": "still"}, "start must be 'free' or 'rest', not 'still'"),
    ("other signal", lambda *_: {"interpolation": "cubic"}, "interpolation must be 'linear' or 'band-limited'"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "sentence"), [pytest.param(*own, id=name) for name, *own in WRONG])
def test_a_wrong_record_is_one_sentence(changes: Callable[[Floats, Floats], dict[str, Any]], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence) as caught:
        record(**changes(*shaken()))
    assert "\n" not in str(caught.value)


def free_mount(*more: Any) -> sp.System:
    return mount(sp.free("k", 60.0, (10.0, 500.0)), sp.free("C", 1.5, (0.1, 50.0)), *more)


def test_a_record_that_cannot_be_one_of_its_model_is_one_sentence() -> None:
    force, x = shaken()
    coarse = {"time": 0.16 * np.arange(TIME.size)}
    short = {"time": TIME[:80], "values": x[:80], "input": force[:80]}
    for model, changes, sentence in (
        (free_mount(), coarse, "time must have more than 4 samples in a period of the model"),
        (free_mount(), short, "time must last at least 2 periods of the model"),
        (
            free_mount(sp.WhiteNoise(1.0)),
            {},
            "model must have no excitation where the input was measured: leave out wh",
        ),
        (free_mount(), {"on": "lid"}, "on of the data must be 'ground' or 'mass', not 'lid'"),
        (free_mount(), {"at": "lid"}, "at of the data must be 'mass', not 'lid'"),
        (mount(sp.free("offset", 60.0, (10.0, 500.0)), 2.0), {}, "offset must not be the name of a free number"),
    ):
        with pytest.raises(ValueError, match=sentence):
            sp.fit(model, record(**changes))
    with pytest.raises(NotCoveredError, match="an acceleration is not covered where a rigid wall is struck"):
        sp.fit(free_mount(sp.Barrier(-0.01)), record(of="a"))


@pytest.mark.parametrize(("what", "factor"), [("values", -1.0), validation("values", 1e3), validation("input", 1e3)])
def test_a_wrong_unit_and_an_inverted_phase_are_no_fit(what: str, factor: float) -> None:
    force, x = shaken()
    with pytest.raises(ValueError, match="no numbers were found with which the model follows the record"):
        sp.fit(
            mount(sp.free("k", 60.0, (10.0, 500.0)), 2.0), record(**{what: factor * (x if what == "values" else force)})
        )


def test_a_clipped_response_is_said() -> None:
    _, x = shaken()
    most = 0.6 * float(np.abs(x).max())
    found = sp.fit(free_mount(), record(values=np.clip(x, -most, most)))
    assert any(said.startswith("The values may be clipped: ") for said in found.warnings)


@pytest.mark.filterwarnings(
    "ignore:.*encountered in:RuntimeWarning"
)  # a column of zeros is inverted before it is refused
def test_a_gap_that_is_never_closed_must_not_be_free() -> None:
    _, x = shaken()
    most = float(np.abs(x).max())
    gap = sp.free("gap", -10.0 * most, (-20.0 * most, -5.0 * most))
    with pytest.raises(ValueError, match="gap must not be free"):
        sp.fit(mount(80.0, 2.0, sp.Contact(gap, 1e4, 1.0)), record())


@pytest.mark.parametrize("on", ["lid", validation("ground"), validation("box")])
def test_the_input_acts_as_that_of_a_simulation(on: str) -> None:
    """On the ground, and on each mass of two: the numbers of the truth leave the noise."""
    force, _ = shaken()
    two = {
        "box": sp.Mass(0.8, at="box"), "lid": sp.Mass(0.3, at="lid"),
        "below": sp.Spring(900.0, between=("ground", "box")),
        "above": sp.Spring(300.0, between=("box", "lid")), "damper": sp.Dashpot(1.0, between=("box", "lid")),
    }  # fmt: skip
    freed = sp.System(**two | {"below": sp.Spring(sp.free("k", 850.0, (100.0, 5000.0)), between=("ground", "box"))})
    drive = sp.RecordedExcitation(tuple(TIME), tuple(force), on, interpolation="band-limited")
    run = sp.simulate(
        sp.System(**two, drive=drive), paths=1, record=1, start="rest", step=0.1 / RATE, record_every=10,
        duration=TIME[-1], seed=1,
    )  # fmt: skip
    found = sp.fit(freed, record(values=run.record[0, :, 1, 0], on=on, at="lid", interpolation="band-limited"))
    assert found.values["k"] == pytest.approx(900.0, rel=0.01)
    assert found.extras["left"] < 0.01 * run.record[0, :, 1, 0].std()
    labels = [axes.get_ylabel() for axes in sp.figures.plot_fit(found).axes]
    assert labels == ["x of lid (m)", "residual (sd)"]


def test_more_pieces_than_a_block_has_lanes_are_refused() -> None:
    time, many = 0.1 * np.arange(64), np.random.default_rng(1).standard_normal((33, 64))
    with pytest.raises(ValueError, match="values must have at most 32 rows with an input, not 33"):
        sp.MeasuredRecord(time, many, input=many)
