"""Records of the ground or of a force: files, several of them, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp

COLUMNS = "time_s,acceleration_g\n0,0\n0.01,0.1\n0.02,-0.05\n"


def put(folder: Path, text: str, name: str = "ground.csv") -> Path:
    place = folder / name
    place.write_text(text, encoding="utf-8")
    return place


def test_units_times_and_rates(tmp_path: Path) -> None:
    own = sp.RecordedExcitation.from_file(put(tmp_path, COLUMNS))
    assert own == sp.RecordedExcitation((0.0, 0.01, 0.02), (0.0, 0.1 * 9.80665, -0.05 * 9.80665))
    assert (own.on, own.count, own.is_drawn) == ("ground", 1, False)
    force = sp.RecordedExcitation.from_file(put(tmp_path, "# of a hammer\ntime (ms);force (kN)\n0;1\n2;3\n"), on="box")
    assert (force.time, force.values, force.on) == ((0.0, 0.002), (1e3, 3e3), "box")
    rated = sp.RecordedExcitation.from_file(put(tmp_path, "acceleration_gal\n1\n2\n"), rate=200.0, scale=2.0)
    assert (rated.time, rated.values, rated.scale) == ((0.0, 0.005), (0.01, 0.02), 2.0)
    assert rated.mean_square == pytest.approx(4.0 * sp.RecordedExcitation(rated.time, rated.values).mean_square)


def test_several_columns_and_files(tmp_path: Path) -> None:
    two = put(tmp_path, "time_s,acceleration_m/s2,acceleration_m/s2\n0,0,1\n1,2,3\n", "two.csv")
    three = sp.RecordedExcitation.from_file([two, put(tmp_path, COLUMNS)], taken="at random")
    assert (three.count, three.duration, three.is_drawn) == (3, 1.0, True)
    assert three.records[1] == ((0.0, 1.0), (1.0, 3.0))
    shared = sp.RecordedExcitation.from_file(two)
    assert shared.time == (0.0, 1.0)  # said once
    assert sp.RecordedExcitation(shared.time, shared.values) == shared
    assert shared.mean_square == pytest.approx((4.0 + 13.0) / 6.0)
    assert "2 records, taken in turn, of 1 s" in sp.explain(sp.System(sp.Spring(1.0), shared)).replace("\n", " ")
    light = sp.System(
        sp.Mass(2.0), sp.Spring(1.0), sp.RecordedExcitation(*zip(*shared.records, strict=True), on="mass")
    )
    assert light.per_unit_mass.of(sp.RecordedExcitation)[0].values == ((0.0, 1.0), (0.5, 1.5))


@pytest.mark.parametrize(
    ("text", "given", "sentence"),
    [
        ("", {}, "is empty: it needs a header"),
        ("time_s,acceleration_g\n", {}, "has 0 points below its header: a record needs two or more"),
        ("time_s,time_s,acceleration_g\n0,0,1\n1,1,1\n", {}, "has 2 columns of the time"),
        ("time_s,acceleration_g\n0,0\n1,1\n2,2\n5,3\n6,4\n", {}, "line 5: the time goes on by 3 s, and by 1 s in most"),
        ("time_s,acceleration_g\n0,0\n1,1\n2,2\n1.5,3\n4,1\n5,1\n", {}, "line 5: the time goes on by -0.5 s"),
        ("time_s,acceleration_g\n0,0\n1,nan\n", {}, "line 3: acceleration_g must be a finite number, not nan"),
        ("acceleration_g\n0\n1\n", {}, "has no column of the time: give the rate"),
        (COLUMNS, {"rate": 100.0}, "has a column of the time: leave out rate"),
        ("acceleration_g\n0\n1\n", {"rate": 0.0}, "rate must be in (0,"),
        ("time_s,acceleration_mg\n0,0\n1,1\n", {}, "the unit of acceleration must be m/s2, g"),
        (
            "time_s,displacement_m\n0,0\n1,1\n",
            {},
            "has no column of an acceleration or a force: its header must be such as time_s,acceleration_g or "
            "time_s,force_N, and columns= takes those that are meant",
        ),
        ("time_s,acceleration_g,force_N\n0,0,1\n1,1,1\n", {}, "has columns acceleration_g and force_N"),
        ("time_s\n0\n1\n", {}, "has no column of an acceleration or a force"),
        (COLUMNS, {"on": "box"}, "on must be left out of a record of an acceleration"),
        ("time_s,force_N\n0,0\n1,1\n", {"on": "ground"}, "on must be a mass for a record of a force"),
        (COLUMNS, {"taken": "twice"}, "taken must be 'in turn' or 'at random', not 'twice'"),
    ],
)
def test_a_wrong_file_gets_one_sentence(tmp_path: Path, text: str, given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence.replace("(", r"\(")) as caught:
        sp.RecordedExcitation.from_file(put(tmp_path, text), **given)
    assert "\n" not in str(caught.value)


def test_wrong_records_are_named() -> None:
    with pytest.raises(ValueError, match="record 1: time and values must have the same number of points"):
        sp.RecordedExcitation((0.0, 1.0), ((0.0, 1.0), (1.0,)))
    with pytest.raises(ValueError, match="one list for all records, or one for each of 2, not 3"):
        sp.RecordedExcitation(((0.0, 1.0),) * 3, ((0.0, 1.0), (1.0, 2.0)))
    with pytest.raises(FileNotFoundError, match=r"There is no file 'nowhere.csv'"):
        sp.RecordedExcitation.from_file("nowhere.csv")


def test_a_system_file_names_its_records(tmp_path: Path) -> None:
    put(tmp_path, COLUMNS)
    text = '[[parts]]\nkind = "spring"\nstiffness = 4.0\n\n[[parts]]\nkind = "recorded_excitation"\n'
    place = put(
        tmp_path, f'{text}path = ["ground.csv", "ground.csv"]\nscale = 2.0\ntaken = "at random"\n', "device.toml"
    )
    system = sp.read_system(place)
    (record,) = system.of(sp.RecordedExcitation)
    assert (record.count, record.scale, record.taken) == (2, 2.0, "at random")
    assert sp.read_system(put(tmp_path, sp.to_toml(system), "whole.toml")) == system
    assert (
        sp.read_system({"parts": [{"kind": "recorded_excitation", "path": "ground.csv"}]}, tmp_path).parts[0].count == 1
    )
    with pytest.raises(ValueError, match=r"recorded_excitation\).path is read from a system's file only"):
        sp.read_system({"parts": [{"kind": "recorded_excitation", "path": "ground.csv"}]})
    with pytest.raises(ValueError, match=r"parts\[1\] \(recorded_excitation\): There is no file '.*other.csv'"):
        sp.read_system(put(tmp_path, f'{text}path = "other.csv"\n', "device.toml"))
    put(tmp_path, "acceleration_g\n0\n1\n", "bare.csv")
    with pytest.raises(ValueError, match="has no column of the time"):
        sp.read_system(put(tmp_path, f'{text}path = "bare.csv"\n', "device.toml"))
    assert math.isclose(record.mean_square, 4.0 * sp.RecordedExcitation(*record.records[0]).mean_square)


def wave(count: int, rate: float = 256.0, decimals: int = 5) -> str:
    rows = (f"{n / rate:.{decimals}f},{np.sin(0.3 * n):.6f}" for n in range(count))
    return "\n".join(["time_s,acceleration_m/s2", *rows, ""])


def test_rounded_times_are_those_of_the_rate(tmp_path: Path) -> None:
    """By both readers; times of five decimals were kept, or refused."""
    rated = sp.RecordedExcitation.from_file(put(tmp_path, wave(200)))
    assert rated.time == tuple(n / 256.0 for n in range(200))
    motion = wave(200).replace("acceleration_m/s2", "a_m/s2")
    read = sp.read_data(put(tmp_path, motion))
    assert read.time.tolist() == [*rated.time]
    assert read.step == 1.0 / 256.0
    bare = "\n".join(line.partition(",")[2] for line in motion.splitlines())
    for given, rate in ((bare, 256), ("# sampling_rate_hz = 256\n" + bare, None)):
        found = sp.read_data(put(tmp_path, given), rate=rate)
        assert (found.step, found.of) == (1.0 / 256.0, "a")
        assert (found.values == read.values).all()
    for text, rate, sentence in (
        (motion, 256.0, "rate must be left out of data with a column of the time"),
        ("before_m/s,after_m/s\n1,0.7\n2,1.4\n3,2.1\n", 2.0, "rate must be left out of data of another kind"),
        ("quantity,value,error\nimpact_rate (1/s),1,1\n", 2.0, "rate is of a record"),
        ("# sampling_rate_hz = 256\n" + bare, 256.0, "sampling_rate_hz must be left out beside rate"),
        (
            "# sampling_rate_hz = 256\n" + motion,
            None,
            "sampling_rate_hz must be left out beside the column of the time",
        ),
        (bare, None, "time_s .a record, relaxation or creep; or give the rate"),
        (bare, -1.0, "rate must be in .0,.*It is in samples per second"),
    ):
        with pytest.raises(ValueError, match=sentence):
            sp.read_data(put(tmp_path, text), rate=rate)


def test_corners_stay_where_they_were_put(tmp_path: Path) -> None:
    """A few points that may be rounded equal steps are a table of corners."""
    found = sp.RecordedExcitation.from_file(put(tmp_path, "time_s,force_N\n0,0\n1.2,1\n2.3,0\n3.5,2\n"))
    assert found.time == (0.0, 1.2, 2.3, 3.5)


def test_a_file_at_a_rate_holds_samples_and_a_few_points_are_corners(tmp_path: Path) -> None:
    samples, corners = (sp.RecordedExcitation.from_file(put(tmp_path, wave(n))) for n in (32, 31))
    assert (samples.interpolation, corners.interpolation) == ("band-limited", "linear")
    assert sp.RecordedExcitation.from_file(put(tmp_path, wave(32)), interpolation="linear").interpolation == "linear"
    assert sp.RecordedExcitation(samples.time, samples.values).interpolation == "linear"
    system = sp.System(sp.Spring(1.0), samples)
    assert sp.read_system(put(tmp_path, sp.to_toml(system), "whole.toml")) == system
    part = '[[parts]]\nkind = "spring"\nstiffness = 4.0\n[[parts]]\nkind = "recorded_excitation"\npath = "ground.csv"\n'
    put(tmp_path, wave(32))
    for line, kept in (("", "band-limited"), ('interpolation = "linear"\n', "linear")):
        (record,) = sp.read_system(put(tmp_path, part + line, "device.toml")).of(sp.RecordedExcitation)
        assert record.interpolation == kept
    uneven = wave(40).splitlines()
    uneven[20] = "0.0750,1.0"
    assert sp.RecordedExcitation.from_file(put(tmp_path, "\n".join(uneven))).interpolation == "linear"
    with pytest.raises(ValueError, match="interpolation must be 'linear' where points are not at equal steps"):
        sp.RecordedExcitation.from_file(put(tmp_path, "\n".join(uneven)), interpolation="band-limited")
    with pytest.raises(ValueError, match="interpolation must be 'linear' or 'band-limited', not 'sinc'"):
        sp.RecordedExcitation((0.0, 1.0), (0.0, 1.0), interpolation="sinc")
