"""Each dialect is read with the right numbers, and what was assumed is said in one line."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import FileError
from tests.files.dialects import DIALECTS, OF_G, RECORD, Dialect, cosmos, matlab, peer, universal, wide
from tests.sizes import validation

NAMES = [dialect.name for dialect in DIALECTS]
READERS: dict[str, Any] = {
    "record": sp.RecordedExcitation.from_file, "density": sp.SpectralExcitation.from_file, "data": sp.read_data
}  # fmt: skip


def read(dialect: Dialect, folder: Path) -> tuple[Any, list[str]]:
    """What is read, and what is said."""
    if dialect.needs:
        pytest.importorskip(dialect.needs)
    place = folder / "file.dat"
    place.write_bytes(dialect.content)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = READERS[dialect.kind](place, **dialect.given)
    assert all(issubclass(each.category, sp.FileWarning) for each in caught)
    return found, [str(each.message) for each in caught]


def numbers_of(found: Any) -> tuple[Any, Any]:
    """Times or frequencies, and values."""
    if isinstance(found, sp.MeasuredStatistics):
        return (), found.values
    if isinstance(found, sp.MeasuredModuli):
        return found.frequency_hz, found.storage
    if isinstance(found, sp.MeasuredFrequencyResponse):
        return found.frequency_hz, np.abs(found.response)
    if isinstance(found, sp.SpectralExcitation):
        return found.frequency, found.psd
    return found.time, found.values if isinstance(found, sp.RecordedExcitation) else found.values[0]


def test_there_are_as_many_as_are_promised() -> None:
    assert len({*NAMES}) == len(NAMES) >= 25


@pytest.mark.parametrize("dialect", DIALECTS, ids=NAMES)
def test_a_dialect_is_read(dialect: Dialect, tmp_path: Path) -> None:
    found, said = read(dialect, tmp_path)
    for own, right in zip(numbers_of(found), dialect.right, strict=True):
        assert list(own)[: len(right)] == pytest.approx(right, rel=2e-5, abs=1e-12)
    assert len(said) == bool(dialect.assumed), said
    assert not said or (dialect.assumed in said[0] and "\n" not in said[0])


@pytest.mark.parametrize(
    ("content", "given", "sentence"),
    [
        (peer(f"{OF_G}NPTS= 12, DT= .02", RECORD, wide, 5), {}, "states NPTS = 12, and has 11 numbers: correct"),
        (peer(f"{OF_G}NPTS= 11, DT= .02 x", RECORD, wide, 5), {"rate": 50.0}, "rate must be left out of .*, which st"),
        (peer(f"{OF_G}NPTS= 11, DT= 0", RECORD, wide, 5), {}, "line 4: NPTS and DT must be greater than 0"),
        (peer(f"{OF_G}NPTS= eleven, DT= .02", RECORD, wide, 5), {}, "line 4: it must state the points and their step"),
        (peer("NPTS= 11, DT= .02", RECORD, wide, 5), {}, "does not say the unit of its numbers: give"),
        (peer("IN UNITS OF G\nNPTS= 11, DT= .02", RECORD, wide, 5), {"unit": "m/s2"}, "unit must be left out of .* g"),
        (peer("UNITS OF FURLONG\nNPTS= 11, DT= .02", RECORD, wide, 5), {}, "its first lines must name one unit, such"),
        (peer("VELOCITY IN UNITS OF G\nNPTS= 11, DT= .02", RECORD, wide, 5), {}, "g is no unit of what its first"),
        (peer(f"{OF_G}UNITS OF CM/S/S\nNPTS= 11, DT= .02", RECORD, wide, 5), {}, "must name one unit, such as UNITS"),
        (cosmos(2), {}, r"has channel 1, channel 2, and one is read: choose it, such as columns={'channel 1': ''}"),
        (cosmos(2), {"columns": {"channel 3": ""}}, "and one is read: choose it"),
        (cosmos(2), {"columns": {"channel 1": "a_g"}}, "and one is read: choose it"),
        (cosmos(2).replace(b"Real-header", b"Other", 1), {"columns": {"channel 1": ""}}, "seems damaged"),
        (cosmos().replace(b"  0 secs", b" 90 secs"), {}, "does not state the step of its 11 values in about 90 s"),
        (b"0,5\n0,6\n", {}, r"has no header: give columns=.*if its commas are decimal marks, give decimal=','"),
        (b"time_s;a_g\n1,000;1\n2,000;2\n", {}, "line 2: the comma of '1,000' may be a decimal mark or may separate"),
        (b"time_s;a_g\n0,1;1\n0.2;2\n", {}, "line 3: time_s must be a number with a decimal comma, as the others, not"),
        (b"time_s,a_g\n0,0,0,5\n0,1,0,6\n", {}, "2 names, and the rows have 4 numbers; .*save it with semicolons"),
        (b"Time (s),Acc\n0,1\n1,2\n", {}, "line 1: Acc must have its unit, as Acc_m/s2: unit= states it"),
        (b"Time,Acc (g)\n0,1\n1,2\n", {}, "line 1: Time must have its unit, as Time_s: columns= states it"),
        (b"Time (s),X (g),Y (g)\n0,1,2\n1,1,2\n", {}, r"has columns of several names, 'X \(g\)' and 'Y \(g\)': col"),
        (b"Time (s),Temp (C),Acc (g)\n0,1,2\n1,1,2\n", {}, r"'Temp \(C\)' is not a column: .*leaves the column out"),
        (b"time_s,a_g\n0,1\n1,2\n", {"columns": ["time_s"]}, "columns must have a header for each of the 2 columns"),
        (b"time_s,a_g\n0,1\n1,2\n", {"columns": {"b": "a_g"}}, "columns has 'b', and the file has no column of that"),
        (b"time_s,a_g\n0.x,1\n1,2\n2,3\n", {}, "line 2: time_s must be a number, not '0.x'"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\0", {}, "is not text, nor a kind of file that is read here: save it as CSV"),
        (b"time_s,a_g\n0,1\n1,\x072\n", {}, "line 3: it has a control character, so it is not text"),
        (matlab(acc=np.ones((1, 4)), t=np.ones((1, 3))), {"unit": "g"}, r"vectors of different lengths \(acc 4, t 3\)"),
        (matlab(acc=np.ones((1, 4)), fs=-1.0), {"unit": "g"}, "must have one rate or step above 0, such as fs ="),
        (matlab(name="x"), {}, "has no vectors of numbers"),
        (b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + b" " * 200, {}, r"of version 7\.3, which is not read: save"),
    ],
)  # fmt: skip
def test_a_refusal_says_what_to_do(content: bytes, given: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    place = tmp_path / "file.dat"
    place.write_bytes(content)
    with pytest.raises(FileError, match=sentence) as caught:
        sp.RecordedExcitation.from_file(place, **given)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"unit": "furlong"}, "unit must be a unit such as 'g'"),
        ({"decimal": ";"}, "decimal must be"),
        ({"columns": "time_s"}, "columns must be a header for each column"),
        ({"columns": [1]}, "columns must be a header for each column"),
        ({"columns": {}}, "columns must be a header for each column"),
        ({"rate": 0.0}, r"rate must be in \(0,"),
    ],
)
def test_what_is_stated_is_checked(given: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    place = tmp_path / "a.csv"
    place.write_text("time_s,a_g\n0,1\n1,2\n", encoding="utf-8")
    with pytest.raises((TypeError, ValueError), match=f"^{sentence}"):
        sp.RecordedExcitation.from_file(place, **given)


def test_a_channel_of_a_cosmos_file_is_chosen(tmp_path: Path) -> None:
    """The second one is read whole, with nothing of the first."""
    place = tmp_path / "two.v2"
    place.write_bytes(cosmos() + cosmos().replace(b"   0.06800", b"   0.13600"))
    first, second = (
        sp.RecordedExcitation.from_file(place, columns={f"channel {number}": ""}).values for number in (1, 2)
    )
    assert first == pytest.approx(tuple(RECORD))
    assert second == pytest.approx((2.0 * RECORD[0], *RECORD[1:]))


def test_functions_of_a_universal_file_are_chosen_by_name(tmp_path: Path) -> None:
    pytest.importorskip("pyuff")
    place, wave = tmp_path / "two.uff", np.sin(0.3 * np.arange(40.0))
    place.write_bytes(
        universal(wave, 0.01, 1, ("g", "NONE")) + universal(0.5 * wave, 0.01, 1, ("g", "NONE"), reference=7)
    )
    with pytest.raises(FileError, match=r"columns of several names, '3\+Z' and '3\+Z/7\+Z'"):
        sp.RecordedExcitation.from_file(place)
    one = sp.RecordedExcitation.from_file(place, columns={"3+Z/7+Z": ""})
    assert one.values[1] == pytest.approx(0.5 * 9.80665 * 0.29552)
    place.write_bytes(universal(wave, 0.01, 1, ("NONE", "NONE")))
    with pytest.raises(FileError, match=r"the unit of '3\+Z' is 'NONE', which does not say enough: give unit="):
        sp.RecordedExcitation.from_file(place)
    assert sp.RecordedExcitation.from_file(place, unit="m/s2").values[1] == pytest.approx(0.29552)
    place.write_bytes(universal(wave, 0.01, 2))
    with pytest.raises(FileError, match="does not say enough: give unit=, such as unit='g2/Hz'"):
        sp.SpectralExcitation.from_file(place)


def test_a_clean_file_says_nothing(tmp_path: Path, capsys: Any) -> None:
    place = tmp_path / "a.csv"
    place.write_text("# a test\ntime_s,acceleration_m/s2,acceleration_m/s2\n0,0,1\n1,2,3\n", encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sp.RecordedExcitation.from_file(place)
    assert not re.search(r"\S", "".join(capsys.readouterr()))


@pytest.mark.parametrize("rows", [2000, validation(200_000)])
def test_time_grows_with_the_file(rows: int, tmp_path: Path) -> None:
    import time

    place = tmp_path / "long.csv"
    place.write_text(
        "time_s;a_g\n" + "".join(f"{n / 512:.6f};{n % 7}\n".replace(".", ",") for n in range(rows)), encoding="utf-8"
    )
    begin = time.perf_counter()
    with pytest.warns(sp.FileWarning):
        sp.RecordedExcitation.from_file(place)
    assert time.perf_counter() - begin < 2.0 + 3e-5 * rows
