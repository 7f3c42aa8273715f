"""Modal models from a table in a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import FileError

TABLE = "frequency_hz,mass_kg,damping_ratio,participation,tip,middle\n6,2,.01,1.5,1,.4\n40,1.5,.02,-.8,-1,.7\n"
RIGHT = sp.System.from_modes(
    [6.0, 40.0], [2.0, 1.5], {"tip": [1.0, -1.0], "middle": [0.4, 0.7]}, [0.01, 0.02], [1.5, -0.8], unit="Hz"
)


def read(content: str, place: Path, **given: Any) -> sp.System:
    place.write_text(content, encoding="utf-8")
    return sp.read_modes(place, **given)


@pytest.mark.parametrize(
    ("content", "given"),
    [
        (TABLE, {}),
        (TABLE.replace("hz", "rad/s").replace("6,2", "37.69911184307752,2").replace("40,", "251.32741228718345,"), {}),
        (TABLE.replace("damping_ratio", "Damping (%)").replace(".01", "1").replace(".02", "2"), {}),
        (TABLE.replace("frequency_hz,mass_kg", "Freq [Hz],Generalised mass (g)").replace(",2,", ",2000,")
         .replace(",1.5,.02", ",1500,.02"), {}),
        ("mode," + TABLE.replace("\n6", "\n1,6").replace("\n40", "\n2,40"), {}),
        (TABLE.replace(",", "\t"), {}),
        (TABLE.split("\n", 1)[1], {"columns": TABLE.split("\n")[0].split(",")}),
        ("x," + TABLE.replace("_hz", "").replace("\n6", "\n0,6").replace("\n40", "\n0,40"),
         {"columns": {name: name + "_hz" * (name == "frequency")
                      for name in TABLE.replace("_hz", "").split("\n")[0].split(",")}}),
    ],
)  # fmt: skip
def test_tables(content: str, given: dict[str, Any], tmp_path: Path) -> None:
    found = read(content, tmp_path / "modes.csv", **given)
    assert found.points == RIGHT.points
    for kind, name in ((sp.Mass, "value"), (sp.Mass, "participation"), (sp.Spring, "stiffness"),
                       (sp.Dashpot, "coefficient"), (sp.Point, "shares")):  # fmt: skip
        own, right = (np.ravel([getattr(part, name) for part in system.of(kind)]) for system in (found, RIGHT))
        assert own == pytest.approx(right, rel=1e-12)


def test_what_is_assumed_is_said(tmp_path: Path) -> None:
    with pytest.warns(sp.FileWarning, match=r"its commas are decimal marks\.$") as caught:
        found = read(TABLE.replace(",", ";").replace(".", ","), tmp_path / "modes.csv")
    assert found == RIGHT
    assert caught[0].filename.endswith("test_modal_table.py")
    with pytest.warns(sp.StationarityWarning, match="1 mode has a frequency of 0"):
        read(TABLE.replace("\n6", "\n0"), tmp_path / "modes.csv")


BAD: list[tuple[str, dict[str, Any], str]] = [
    (TABLE.replace("mass_kg", "m"), {}, "line 1: a column of the mass is needed, mass_kg, 1 where shapes have unit"),
    (TABLE.replace("frequency_hz", "mode"), {}, "line 1: a column of the frequency is needed, frequency_hz"),
    (TABLE.replace("_hz", ""), {}, "line 1: the unit of frequency must be Hz, kHz or rad/s, not ''"),
    (TABLE.replace("participation", "mass_g"), {}, "line 1: mass has two columns, and one is needed"),
    (TABLE.replace("middle", "tip"), {}, "line 1: tip has two columns, and one is needed"),
    (TABLE.replace("middle", "the middle"), {}, "each name in shapes must be a word of letters, digits and _, not 't"),
    (TABLE.replace("middle", "mode_1"), {}, "mode_1 cannot be the name of a point, for a mode is called so"),
    (TABLE.replace("40", "forty"), {}, "line 3: frequency_hz must be a number, not 'forty'"),
    (TABLE.replace("\n6", "\n-6"), {}, "frequencies must not be negative, and -6 is among them"),
    ("frequency_hz,mass_kg\n6,2\n", {}, "line 1: a column with the shapes of each point is needed, whose header"),
    (TABLE.split("\n")[0], {}, "has no numbers below its header"),
    (TABLE, {"columns": ["frequency_hz", "mass_kg"]}, "columns must have a header for each of the 6 columns"),
    (TABLE, {"columns": {"f": "frequency_hz"}}, "columns has 'f', and one such column is needed, of 'frequency_hz',"),
    ("", {}, "is empty"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "given", "sentence"), BAD)
def test_what_cannot_be_read_is_refused_in_one_sentence(
    content: str, given: dict[str, Any], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(FileError) as caught:
        read(content, tmp_path / "modes.csv", **given)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
