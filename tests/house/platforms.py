"""Names of Python's own modules that Windows lacks, and text files of which nobody says how they are written.

The names are those that the types of the standard library, which mypy brings, keep for other systems.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import mypy

ROOT = Path(__file__).resolve().parents[2]
TYPES = Path(mypy.__file__).parent / "typeshed" / "stdlib"
WATCHED = ("os", "signal", "socket", "select", "time")
GONE = ("resource", "fcntl", "pwd", "grp", "termios", "tty", "pty", "posix", "syslog")  # some of the modules
NOT_WINDOWS = ("sys.platform != 'win32'", "sys.platform == 'linux'", "sys.platform == 'darwin'")
IN_TEXT = {"read_text": 0, "write_text": 1}  # and how many arguments stand before the encoding
_MAY_LACK = re.compile(rf"\b({'|'.join(WATCHED)})\.[a-zA-Z]|\b(from|import) ({'|'.join((*WATCHED, *GONE))})\b")
_MAY_OPEN = re.compile(r"(_text|\bopen)\(")


def _defined(body: Iterable[ast.stmt], elsewhere: bool = False) -> Iterator[tuple[str, bool]]:
    """Each name of a module, and whether Windows lacks it there."""
    for node in body:
        if isinstance(node, ast.If):
            test = ast.unparse(node.test)
            yield from _defined(node.body, elsewhere or any(each in test for each in NOT_WINDOWS))
            yield from _defined(node.orelse, elsewhere or test == "sys.platform == 'win32'")
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name, elsewhere
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            yield from ((each.id, elsewhere) for each in targets if isinstance(each, ast.Name))
        elif isinstance(node, ast.ImportFrom):
            yield from ((each.asname or each.name, elsewhere) for each in node.names)


@cache
def lacking() -> dict[str, set[str]]:
    """Of each module the names that Windows lacks; of a module that it lacks itself, "import"."""
    found: dict[str, set[str]] = {}
    for file in TYPES.glob("*.pyi"):
        by_system = "\nif sys.platform " in file.read_text(encoding="utf-8")
        if by_system and all(elsewhere for name, elsewhere in _names(file) if not name.startswith("_")):
            found[file.stem] = {"import"}
    for module in WATCHED:
        place = TYPES / module / "__init__.pyi"
        names = [*_names(place if place.exists() else TYPES / f"{module}.pyi")]
        found[module] = {name for name, elsewhere in names if elsewhere} - {name for name, other in names if not other}
    return found


def _names(file: Path) -> Iterator[tuple[str, bool]]:
    body = ast.parse(file.read_text(encoding="utf-8")).body
    taken = [node for node in body if not (isinstance(node, ast.ImportFrom) and node.module != "_socket")]
    yield from _defined(taken)


def not_in_windows(text: str) -> list[tuple[int, str]]:
    """Lines of a file with what Windows lacks."""
    found = []
    for node in ast.walk(ast.parse(text if _MAY_LACK.search(text) else "")):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.attr in lacking().get(node.value.id, ()):
                found.append((node.lineno, ast.unparse(node)))
        elif isinstance(node, ast.Import):
            found += [
                (node.lineno, f"import {each.name}") for each in node.names if lacking().get(each.name) == {"import"}
            ]
        elif isinstance(node, ast.ImportFrom) and node.module in lacking():
            bad = {"import", *(each.name for each in node.names)} & lacking()[node.module]
            found += [(node.lineno, f"from {node.module} import {', '.join(sorted(bad))}")] if bad else []
    return sorted(found)


def without_encoding(text: str) -> list[tuple[int, str]]:
    """Lines of a file with a text file that is opened in whatever encoding the machine has."""
    found = []
    for node in ast.walk(ast.parse(text if _MAY_OPEN.search(text) else "")):
        if not isinstance(node, ast.Call) or any(word.arg in ("encoding", "opener", None) for word in node.keywords):
            continue
        if isinstance(node.func, ast.Attribute) and node.func.attr in IN_TEXT:
            if len(node.args) <= IN_TEXT[node.func.attr]:
                found.append((node.lineno, node.func.attr))
        elif isinstance(node.func, ast.Name) and node.func.id == "open":
            modes = [*node.args[1:2], *(word.value for word in node.keywords if word.arg == "mode")]
            if not any(isinstance(mode, ast.Constant) and "b" in mode.value for mode in modes):
                found.append((node.lineno, "open"))
    return sorted(found)


def files(folder: str) -> Iterator[Path]:
    """The Python files of a folder of the project."""
    return (ROOT / folder).rglob("*.py")
