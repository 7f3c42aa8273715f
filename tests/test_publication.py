"""What a publication needs: one version in every place, and a paper whose sources and numbers are the project's."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import springpot
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP
from springpot.machine import versions
from springpot.paper.errata import ERRATA

ROOT = Path(__file__).resolve().parents[1]
PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")


def entries(place: str) -> dict[str, str]:
    found = re.findall(r"^@\w+\{(\w+),(.*?)\}\}$", (ROOT / place).read_text(encoding="utf-8"), flags=re.M | re.S)
    return dict(found)


def test_the_version_is_the_same_everywhere() -> None:
    """It stands in `machine/versions.py`, from which the package is built; these places repeat it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    assert project["project"]["dynamic"] == ["version"]
    assert Path(versions.__file__).samefile(ROOT / project["tool"]["hatch"]["version"]["path"])
    version = springpot.__version__
    changes = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.M)
    assert changes[0] == "Unreleased"
    day = changes[1].removeprefix(f"[{version}] - ")
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", day)
    written = {
        "CITATION.cff": f"\nversion: {version}\ndate-released: {day}\n",
        "docs/citing.md": f"version = {{{version}}}",
    }
    for place, words in written.items():
        assert words in (ROOT / place).read_text(encoding="utf-8"), place


def test_the_paper_cites_what_it_lists() -> None:
    sources, of_the_docs = entries("paper/paper.bib"), entries("docs/references.bib")
    assert set(re.findall(r"@(\w+)", PAPER.split("---", 2)[2])) == set(sources)
    assert [key for key in sources if key in of_the_docs and sources[key] != of_the_docs[key]] == []
    assert len(of_the_docs) > 50


def test_the_paper_has_its_parts() -> None:
    """Those that JOSS asks for, one picture that exists, and not more than 1000 words or so."""
    for part in ("Summary", "Statement of need", "State of the field", "Limits", "References"):
        assert f"\n# {part}\n" in PAPER
    (picture,) = re.findall(r"!\[.*?\]\((.*?)\)", PAPER, flags=re.S)
    assert (ROOT / "paper" / picture).is_file()
    assert 750 < len(PAPER.split("---", 2)[2].split()) < 1200


def test_the_errors_of_the_paper_that_is_reproduced_are_counted() -> None:
    counted = {7: "seven", 8: "eight", 9: "nine"}[len(ERRATA)]
    assert f"[{counted} errors](docs/theory/errata.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_numbers_of_the_paper_are_those_measured() -> None:
    words = " ".join(PAPER.split())
    cells = [len(each.file.read_text(encoding="utf-8").splitlines()) - 1 for each in (PAPER_MAP, SYSTEMS_MAP)]
    assert f"on {cells[0]} points of the dimensionless problem and {cells[1]} systems" in words
    table = (ROOT / "benchmarks" / "results" / "table.csv").read_text(encoding="utf-8")
    steps = [float(n) for n in re.findall(r'"springpot, best step, h = [^"]*",([\d.]+),ns per path-step', table)]
    assert f"takes {min(steps):.0f} to {max(steps):.0f} nanoseconds of processor time" in words


def test_what_the_checklist_names_is_there() -> None:
    text = (ROOT / "paper" / "checklist.md").read_text(encoding="utf-8")
    named = re.findall(r"`([\w./]*(?:/|\.[a-z])[\w./]*)`", text)
    assert len(named) > 40
    assert [name for name in named if not (ROOT / name).exists() and not list((ROOT / "src").rglob(name))] == []
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.M))
    assert set(re.findall(r"`make (\w+)`", text)) <= targets
