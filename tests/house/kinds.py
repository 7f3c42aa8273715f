"""Where the code asks of what kind a part is, modules of few lines, and private functions that are called once.

Three counts that say how much a reader must carry along.  A question is an ``isinstance`` with a kind of part, a
``case`` of one, or ``system.of(Kind)``, outside the parts themselves and the kernel, whose laws are of kinds.
"""

from __future__ import annotations

import ast
import inspect
from collections import Counter
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from springpot.problem import parts
from springpot.problem.parts.registration import Part
from tests.house.lines import lines_of

SOURCE = Path(__file__).resolve().parents[2] / "src" / "springpot"
HOME = "problem/parts/", "simulation/kernel/"
FEW = 40  # lines of code


@cache
def kinds() -> frozenset[str]:
    """The names of the classes of parts."""
    modules = (import_module(f"{parts.__name__}.{each.name}") for each in iter_modules(parts.__path__))
    classes = (each for module in modules for each in vars(module).values() if inspect.isclass(each))
    return frozenset(each.__name__ for each in classes if issubclass(each, Part))


def questions() -> Counter[str]:
    """How often each file asks."""
    found = Counter[str]()
    for file, tree in _trees():
        if not file.startswith(HOME):
            found[file] += sum(map(_asks, ast.walk(tree)))
    return +found


def _asks(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Name(id="isinstance"), args=[_, kind]):
            return _names_a_kind(kind)
        case ast.Call(func=ast.Attribute(attr="of"), args=args):
            return any(map(_names_a_kind, args))
        case ast.MatchClass(cls=kind):
            return _names_a_kind(kind)
    return False


def _names_a_kind(node: ast.AST) -> bool:
    return any(isinstance(each, ast.Name) and each.id in kinds() for each in ast.walk(node))


def small_modules() -> list[str]:
    """Those with fewer than 40 lines of code, but for the faces of packages."""
    places = (place for place in sorted(SOURCE.rglob("*.py")) if not place.name.startswith("__"))
    return [str(place.relative_to(SOURCE)) for place in places if lines_of(place.read_text(encoding="utf-8")) < FEW]


def called_once() -> tuple[int, int]:
    """How many private functions and methods are named in one place beside their definition, and how many there are."""
    defined, named = Counter[str](), Counter[str]()
    for _, tree in _trees():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and node.name.startswith("_") and not node.name.startswith("__"):
                defined[node.name] += 1
            elif isinstance(node, ast.Name):
                named[node.id] += 1
            elif isinstance(node, ast.Attribute):
                named[node.attr] += 1
    alone = [name for name, count in defined.items() if count == 1]  # of twins it is not known which one is meant
    return sum(named[name] == 1 for name in alone), sum(defined.values())


def _trees() -> Iterator[tuple[str, ast.Module]]:
    for place in sorted(SOURCE.rglob("*.py")):
        yield place.relative_to(SOURCE).as_posix(), ast.parse(place.read_text(encoding="utf-8"))
