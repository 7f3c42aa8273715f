"""The README keeps its word: its example prints what it says, its commands exist, its links lead somewhere."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import springpot as sp
from springpot import cli
from springpot.units import UNITS

README = Path(__file__).resolve().parents[1] / "README.md"
TEXT = README.read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, flags=re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(("example", "output"), list(zip(blocks("python"), blocks("text"), strict=True)))
def test_the_examples_print_what_they_say(example: str, output: str) -> None:
    assert len([line for line in example.splitlines() if line]) <= 10
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(example, {})
    assert printed.getvalue() == output


@pytest.mark.parametrize("line", [line for block in blocks("console") for line in block.splitlines()])
def test_the_commands_exist(line: str) -> None:
    program, *words = line.split()
    assert program == "springpot"
    cli.commands.app.parse_args(words, exit_on_error=False, print_error=False)


def test_a_study_from_file_to_chart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (block,) = blocks("shell")
    lines = block.splitlines()
    assert len(lines) <= 5
    monkeypatch.chdir(tmp_path)
    for line in lines:
        program, *words = line.split()
        assert program == "springpot"
        assert cli.main(words) == 0
    made = {place.suffix: place for place in tmp_path.iterdir()}
    assert set(made) == {".toml", ".zarr", ".nc", ".png"}
    assert made[".png"].read_bytes().startswith(b"\x89PNG")
    assert bool(sp.open_study(made[".zarr"])["simulation"]["done"].all())


def test_every_number_has_its_line() -> None:
    table = re.findall(r"^\| (`.*?) \|", TEXT, flags=re.MULTILINE)
    named = {name for cell in table for name in re.findall(r"`(\w+)`", cell)}
    assert {*UNITS, "decay_rate", "_se", "_step_bias", "_memory_bias", "_transient", "_error"} <= named


@pytest.mark.parametrize("target", re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT))
def test_links_lead_somewhere(target: str) -> None:
    assert (README.parent / target).is_file()
