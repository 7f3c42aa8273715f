"""The table of packages in CONTRIBUTING, and the imports: data goes one way."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

from tests.house.way import both

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"
PACKAGES, ROOMS, *_ = (
    (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("## The packages")[1].split("The rooms of")
)
ROOMS = ROOMS.split("I want to change")[0]


def heights(table: str) -> dict[str, int]:
    """The names in the first column of a table, each with its row."""
    rows = [re.findall(r"`([^`]+)`", row.split("|")[1]) for row in table.splitlines() if row.startswith("| `")]
    return {name.removesuffix("/").removesuffix(".py"): level for level, names in enumerate(rows) for name in names}


HEIGHT, HEIGHT_OF_ROOM = heights(PACKAGES), heights(ROOMS)


def modules() -> dict[str, Path]:
    """Every module's name and file."""
    files = {file: ".".join(file.relative_to(SOURCE).with_suffix("").parts) for file in SOURCE.rglob("*.py")}
    return {name.removesuffix(".__init__"): file for file, name in files.items()}


def statements(body: Iterable[ast.AST], types: bool) -> Iterator[ast.AST]:
    """Every statement, at the top or within others, those for types only if asked for; expressions import nothing."""
    for node in body:
        if not types and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        for field in ("body", "orelse", "handlers", "finalbody", "cases"):
            yield from statements(getattr(node, field, ()), types)


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def imports(file: Path, known: dict[str, Path], types: bool) -> set[str]:
    """Modules of the library that a file imports, at its top or inside a function; if asked for, for types too."""
    found: set[str] = set()
    for node in statements(parsed(file).body, types):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in known else node.module for name in inside}
    return found & known.keys()


@cache
def graph(types: bool = False) -> dict[str, set[str]]:
    """What each module imports: read when the first test asks, not whenever the tests are collected."""
    known = modules()
    return {name: imports(file, known, types) for name, file in known.items()}


def package(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def test_every_package_is_in_the_table() -> None:
    assert {package(module) for module in modules()} - {"__init__", "__main__"} == HEIGHT.keys()


@pytest.mark.parametrize("name", sorted(HEIGHT))
def test_a_package_imports_only_those_above_it_in_the_table(name: str) -> None:
    """The first rows stand alone; each row may use those before it, and its own."""
    wrong = {
        (module, imported)
        for module, names in graph().items()
        if package(module) == name
        for imported in names
        if package(imported) in HEIGHT and HEIGHT[package(imported)] > HEIGHT[name]
    }
    assert wrong == set()


def room(module: str) -> str:
    """The room of a module of the simulation; empty for the door and for other packages."""
    parts = module.split(".")
    return parts[2] if parts[1:2] == ["simulation"] and len(parts) > 2 and parts[2] in HEIGHT_OF_ROOM else ""


def test_every_room_is_in_the_table() -> None:
    inside = SOURCE / "springpot" / "simulation"
    assert {folder.parent.name for folder in inside.glob("*/__init__.py")} == HEIGHT_OF_ROOM.keys()


@pytest.mark.parametrize("name", sorted(HEIGHT_OF_ROOM))
def test_a_room_of_the_simulation_imports_only_those_above_it(name: str) -> None:
    """For types too, and nothing from the door."""
    door = {"springpot.simulation"} | {f"springpot.simulation.{each}" for each in ("monte_carlo", "extended")}
    wrong = {
        (module, imported)
        for module, names in graph(types=True).items()
        if room(module) == name
        for imported in names
        if imported in door or (room(imported) and HEIGHT_OF_ROOM[room(imported)] > HEIGHT_OF_ROOM[name])
    }
    assert wrong == set()


def test_no_two_folders_of_methods_import_each_other() -> None:
    def folder(module: str) -> str:
        parts = module.split(".")
        return parts[3] if parts[1:3] == ["theory", "methods"] and len(parts) > 4 else ""

    pairs = {(folder(module), folder(name)) for module, names in graph(types=True).items() for name in names}
    assert {pair for pair in pairs if all(pair) and pair[0] != pair[1] and pair[::-1] in pairs} == set()


def test_no_circle_of_imports() -> None:
    """Nor of those for types only."""
    left = {module: names - {module} for module, names in graph(types=True).items()}
    while left:  # without what imports nothing of the rest, and what nothing of the rest imports
        used = set().union(*left.values())
        ends = {module for module, names in left.items() if not names & left.keys() or module not in used}
        if not ends:
            break
        left = {module: names for module, names in left.items() if module not in ends}
    assert {module: names & left.keys() for module, names in left.items()} == {}


@pytest.mark.parametrize("name", ["oscillator", "two walls"])
def test_the_way_of_a_problem_through_the_files_is_short(name: str) -> None:
    """As `tests.house.way` counts it: `python -m tests.house way` shows the files."""
    way = both()[name]
    assert way.total() <= 60
    assert way.total() - len(way) <= 35
    assert max(way.values()) <= 4, way.most_common(3)


def test_after_the_plan_every_problem_goes_the_same_way() -> None:
    one, other = ({file: n for file, n in way.items() if "/plan/" not in file} for way in both().values())
    assert one == other


def test_the_files_that_the_contributing_page_names_exist() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([a-z_/]+(?:\.py|\.md|\.toml|\.js|/))`", text))
    inside = (SOURCE / "springpot" / each for each in ("", "problem", "theory", "simulation", "evidence"))
    bases = (ROOT, *inside)
    missing = {name for name in named if not any((base / name).exists() for base in bases)}
    assert missing == set()
    files = [SOURCE / "springpot" / name for name in named if name.endswith(".py")]
    assert [
        str(file)
        for file in files
        if file.is_file() and not ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))
    ] == []
