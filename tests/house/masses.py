"""Where the code asks how many masses there are.

The rule.  One mass is the case of one row, so after the door, which is ``problem/``, nothing needs to ask.  A question
is any line of another package of src, words and comments left out, with one of these:

1. a comparison, or the truth, of the number of points: ``len(system.points) > 1``, also of a name given there;
2. a name with "several" in it, of a class, a function, a module, an argument or a variable: a twin that exists for
   several masses only, wherever it is defined, imported, called or named in an annotation;
3. ``coordinates.lone``, which is the number of points in one word.

One line is one question, however often it asks.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src" / "springpot"
DOOR = "problem"
_TWIN = "several"
_LONE = "lone"
_NUMBERED = {"points", "masses"}


@dataclass(frozen=True)
class Asked:
    """One place."""

    file: str
    line: int
    text: str
    kind: str

    @property
    def package(self) -> str:
        """That of its file."""
        return self.file.partition("/")[0]


@cache
def asked(source: Path = SOURCE) -> list[Asked]:
    """All of them, in the order of files and lines."""
    found = []
    for place in sorted(source.rglob("*.py")):
        file = place.relative_to(source).as_posix()
        if not file.startswith(f"{DOOR}/"):
            text = place.read_text(encoding="utf-8")
            kinds, lines = asked_in(text), text.splitlines()
            found += [Asked(file, line, lines[line - 1].strip(), kinds[line]) for line in sorted(kinds)]
    return found


def asked_in(text: str) -> dict[int, str]:
    """The lines of one file that ask, and how.

    >>> asked_in('if len(system.points) > 1:\\n    parts = compose_several(plan)\\nsize = len(system.points)\\n')
    {1: 'number', 2: 'twin'}
    """
    kinds: dict[int, str] = {}
    counts = "len(" in text and any(name in text for name in _NUMBERED)
    if not (counts or _TWIN in text.lower() or f".{_LONE}" in text):
        return kinds
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.expr | ast.stmt | ast.alias | ast.arg | ast.keyword):
            if any(_TWIN in name.lower() for name in _names(node)):
                kinds.setdefault(node.lineno, "twin")
            if isinstance(node, ast.Attribute) and node.attr == _LONE:
                kinds[node.lineno] = "lone"
            if any(map(_counts, _compared(node))):
                kinds[node.lineno] = "number"
    return kinds


def _names(node: ast.AST) -> Iterator[str]:
    """The names that a node itself has."""
    for field in ("id", "attr", "name", "asname", "arg", "module"):
        if isinstance(name := getattr(node, field, None), str):
            yield name


def _compared(node: ast.AST) -> Iterator[ast.expr]:
    """What is compared with a number, or is itself a condition."""
    match node:
        case ast.Compare(left=left, comparators=[other]) if ast.Constant in map(type, (left, other)):
            yield from (left, other)
        case ast.If(test=test) | ast.IfExp(test=test) | ast.While(test=test):
            yield test
        case ast.Match(subject=subject):
            yield subject
        case ast.BoolOp(values=values):
            yield from values
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield operand


def _counts(node: ast.expr) -> bool:
    """Whether it is the number of masses: the length of something that is called points or masses."""
    match node:
        case ast.Call(func=ast.Name(id="len"), args=[ast.NamedExpr(value=counted) | counted]):
            return isinstance(counted, ast.Attribute | ast.Name) and not _NUMBERED.isdisjoint(_names(counted))
    return False
