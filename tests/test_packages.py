"""The table of packages in CONTRIBUTING, and the imports: data goes one way."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"
TABLE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("## The packages")[1].split("The rooms of")[0]
ROWS = [re.findall(r"`([^`]+)`", row.split("|")[1]) for row in TABLE.splitlines() if row.startswith("| `")]
HEIGHT = {name.removesuffix("/").removesuffix(".py"): level for level, names in enumerate(ROWS) for name in names}


def modules() -> dict[str, Path]:
    """Every module's name and file."""
    files = {file: ".".join(file.relative_to(SOURCE).with_suffix("").parts) for file in SOURCE.rglob("*.py")}
    return {name.removesuffix(".__init__"): file for file, name in files.items()}


def statements(body: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Every statement, at the top or within others, but for those for types only; expressions import nothing."""
    for node in body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        for field in ("body", "orelse", "handlers", "finalbody", "cases"):
            yield from statements(getattr(node, field, ()))


def imports(file: Path, known: dict[str, Path]) -> set[str]:
    """Modules of the library that a file imports, at its top or inside a function; not those for types only."""
    found: set[str] = set()
    for node in statements(ast.parse(file.read_text(encoding="utf-8")).body):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in known else node.module for name in inside}
    return found & known.keys()


@cache
def graph() -> dict[str, set[str]]:
    """What each module imports: read when the first test asks, not whenever the tests are collected."""
    known = modules()
    return {name: imports(file, known) for name, file in known.items()}


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


def test_no_circle_of_imports() -> None:
    left = {module: names - {module} for module, names in graph().items()}
    while left:  # without what imports nothing of the rest, and what nothing of the rest imports
        used = set().union(*left.values())
        ends = {module for module, names in left.items() if not names & left.keys() or module not in used}
        if not ends:
            break
        left = {module: names for module, names in left.items() if module not in ends}
    assert {module: names & left.keys() for module, names in left.items()} == {}


def test_the_files_that_the_contributing_page_names_exist() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([a-z_/]+(?:\.py|\.md|\.toml|\.js|/))`", text))
    inside = (SOURCE / "springpot" / each for each in ("", "problem", "theory", "simulation", "evidence"))
    bases = (ROOT, *inside)
    missing = {name for name in named if not any((base / name).exists() for base in bases)}
    assert missing == set()
