"""What a publication needs: one version in every place, and a paper whose sources and numbers are the project's."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import springpot
from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP
from springpot.machine import installed
from springpot.memory import exponential_sum
from springpot.paper.errata import ERRATA
from springpot.theory.mckean import COLLAPSE_BELOW

ROOT = Path(__file__).resolve().parents[1]
COUNTED = {7: "seven", 8: "eight", 9: "nine"}
PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")


def entries(place: str) -> dict[str, str]:
    found = re.findall(r"^@\w+\{(\w+),(.*?)\}\}$", (ROOT / place).read_text(encoding="utf-8"), flags=re.M | re.S)
    return dict(found)


def test_the_version_is_the_same_everywhere() -> None:
    """It stands in `machine/installed.py`, from which the package is built; these places repeat it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    assert Path(installed.__file__).samefile(ROOT / project["tool"]["hatch"]["version"]["path"])
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
    """Those that JOSS asks for in this order, one picture that exists, and a length within its limits."""
    asked = ("Summary", "Statement of need", "State of the field", "Software design", "Research impact statement",
             "AI usage disclosure", "Acknowledgements", "References")  # fmt: skip
    assert [part for part in re.findall(r"^# (.*)$", PAPER, flags=re.M) if part in asked] == list(asked)
    (picture,) = re.findall(r"!\[.*?\]\((.*?)\)", PAPER, flags=re.S)
    assert (ROOT / "paper" / picture).is_file()
    assert 750 < len(PAPER.split("---", 2)[2].split()) < 1200


def test_the_errors_of_the_paper_that_is_reproduced_are_counted() -> None:
    assert f"[{COUNTED[len(ERRATA)]} errors](docs/theory/errata.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_numbers_of_the_paper_are_those_measured() -> None:
    words = " ".join(PAPER.split())
    cells = [len(each.file.read_text(encoding="utf-8").splitlines()) - 1 for each in (PAPER_MAP, SYSTEMS_MAP)]
    assert f"on {cells[0]} points of the dimensionless problem and {cells[1]} systems" in words
    table = (ROOT / "benchmarks" / "results" / "table.csv").read_text(encoding="utf-8")
    steps = [float(n) for n in re.findall(r'"springpot, best step, h = [^"]*",([\d.]+),ns per path-step', table)]
    assert f"takes {min(steps):.0f} to {max(steps):.0f} nanoseconds of processor time" in words
    assert f"restitution $e^{{-\\pi/\\sqrt3}} = {COLLAPSE_BELOW:.3f}$" in words
    assert f"shows {COUNTED[len(ERRATA)]} errors of the printed text" in words
    sums = [exponential_sum("average", order, steps, 1e-6) for order, steps in ((0.1, 2000), (0.9, 200_000))]
    fewest, most = (found.rates.size for found in sums)
    assert f"{fewest} to {most} terms serve for 2000 to 200 000 steps with an error of at most $10^{{-6}}$" in words
    python = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["classifiers"]
    tried = re.findall(r"Python :: (3[.]\d+)$", "\n".join(python), flags=re.M)
    assert f"CPython {tried[0]} to {tried[-1]}" in words


def test_what_the_paper_compares_with_is_on_the_pages_that_run() -> None:
    """Each source of its comparisons is cited on the page of published numbers, or where a law is checked."""
    compared = PAPER.split("# Research impact statement")[1].split("# Limits")[0]
    pages = "".join(
        (ROOT / "docs" / page).read_text(encoding="utf-8") for page in ("published.md", "theory/system_methods.md")
    )
    keys = set(re.findall(r"@(\w+)", compared))
    assert len(keys) >= 7
    assert [key for key in keys if not re.search(rf"\{{cite:[pt]\}}`[^`]*{key}", pages)] == []


def test_what_the_checklist_names_is_there() -> None:
    text = (ROOT / "paper" / "checklist.md").read_text(encoding="utf-8")
    named = re.findall(r"`([\w./]*(?:/|\.[a-z])[\w./]*)`", text)
    assert len(named) > 40
    assert [name for name in named if not (ROOT / name).exists() and not list((ROOT / "src").rglob(name))] == []
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.M))
    assert set(re.findall(r"`make (\w+)`", text)) <= targets
