"""Where the code asks what kind of problem it has.

The rule.  A question is any of these, in src:

1. ``isinstance`` or a ``match`` with `System`, `Oscillator` or `Dimensionless`, and ``type(x) is`` one of them;
2. a try whose body calls ``Dimensionless.of`` and whose handler catches `NotCoveredError`: "is it the paper's problem";
3. a comparison with None, or the truth, of a name that is annotated ``System | None`` or ``Dimensionless | None``, or
   that is called ``paper``, ``dimensionless`` or ``oscillator``;
4. an annotation that allows both a `System` and a `Dimensionless`.

A call of ``Dimensionless.of`` that lets the error pass is no question: the method that calls it covers that problem
only, and the caller is told which part forbids it.

It is asked at a door, once in each file of DOORS and before any plan; everywhere else, and a second time in such a
file, it counts as asked after.  No decision about the problem are the WALKS: a value is written or made again, and a
system is one of the containers, as tuples and mappings are, through which the walk goes.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src" / "springpot"
KINDS = {"System", "Oscillator", "Dimensionless"}
NAMES = {"paper", "dimensionless", "oscillator"}
DOORS = {
    "problem/system.py": "whether what was given is a system, for every function that takes one",
    "theory/coverage.py": "which of its forms a method has",
    "simulation/plan/motions.py": "closed forms or a guess, where the plan is made",
    "evidence/reliability.py": "which of the two validity maps",
    "explorer/question.py": "the paper's view is added on the page",
}
WALKS = {
    "problem/free_numbers.py": "how a model with free numbers is made again",
    "simulation/result/save.py": "how a value of a run is written",
}


@dataclass(frozen=True)
class Question:
    """One place."""

    file: str
    line: int
    text: str
    at: str


@cache
def questions(source: Path = SOURCE) -> list[Question]:
    """All of them, in the order of files and lines."""
    found = []
    for place in sorted(source.rglob("*.py")):
        text = place.read_text(encoding="utf-8")
        if not any(name in text for name in KINDS | NAMES):
            continue
        lines = text.splitlines()
        file = place.relative_to(source).as_posix()
        for count, line in enumerate(sorted({node.lineno for node in _asked(ast.parse(text))})):
            at = "after" if count else "door" if file in DOORS else "walk" if file in WALKS else "after"
            found.append(Question(file, line, lines[line - 1].strip(), at))
    return found


def _asked(tree: ast.Module) -> Iterator[ast.expr | ast.stmt]:
    nodes = [*ast.walk(tree)]
    maybe = NAMES | {node.target.id for node in nodes if isinstance(node, ast.AnnAssign)
                     and isinstance(node.target, ast.Name) and _is_optional(node.annotation)}  # fmt: skip
    maybe |= {arg.arg for arg in nodes if isinstance(arg, ast.arg) and _is_optional(arg.annotation)}
    for node in nodes:
        match node:
            case ast.Call(func=ast.Name(id="isinstance" | "issubclass"), args=[_, kinds]) if _named(kinds) & KINDS:
                yield node
            case ast.Compare(left=ast.Call(func=ast.Name(id="type")), comparators=[kinds]) if _named(kinds) & KINDS:
                yield node
            case ast.Compare(left=ast.Name(id=name), ops=[ast.Is() | ast.IsNot()]) if name in maybe:
                yield node
            case ast.If(test=ast.Name(id=name)) | ast.IfExp(test=ast.Name(id=name)) if name in maybe:
                yield node
            case ast.Match():
                for case in node.cases:
                    for inner in ast.walk(case.pattern):
                        if isinstance(inner, ast.MatchClass) and _named(inner.cls) & KINDS:
                            yield inner.cls
            case ast.Try() if any("NotCoveredError" in _named(handler.type) for handler in node.handlers):
                if any(_is_of(inner) for line in node.body for inner in ast.walk(line)):
                    yield node
            case ast.BinOp(op=ast.BitOr()) if {"System", "Dimensionless"} <= _named(node):
                yield node


def _is_of(node: ast.AST) -> bool:
    match node:
        case ast.Call(func=ast.Attribute(value=ast.Name(id="Dimensionless"), attr="of")):
            return True
    return False


def _is_optional(annotation: ast.expr | None) -> bool:
    return annotation is not None and bool(_named(annotation) & KINDS) and "None" in ast.unparse(annotation)


def _named(node: ast.expr | None) -> set[str]:
    if node is None:
        return set()
    inside = [*ast.walk(node)]
    return {each.id for each in inside if isinstance(each, ast.Name)} | {
        each.attr for each in inside if isinstance(each, ast.Attribute)
    }
