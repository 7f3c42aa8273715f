"""Lines of code in src, now or at a commit: without blank lines, docstrings and imports; comment lines count."""

from __future__ import annotations

import ast
import subprocess
from collections import Counter
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src" / "springpot"


def lines_at(commit: str) -> int:
    """Of all Python files below src."""
    return sum(lines_of(_shown(f"{commit}:{name}")) for name in _listed(commit) if name.endswith(".py"))


def lines_now(source: Path = SOURCE) -> Counter[str]:
    """Of each package as the files are now; of the simulation of each of its rooms."""
    found = Counter[str]()
    for place in sorted(source.rglob("*.py")):
        folders = place.relative_to(source).parts[:-1]
        package = "/".join(folders[: 2 if folders[:1] == ("simulation",) else 1])
        found[package or "."] += lines_of(place.read_text(encoding="utf-8"))
    return found


def lines_of(text: str) -> int:
    """Of one file.

    >>> lines_of('x = 1\\n\\nimport os\\n# why\\ndef f():\\n    \"\"\"Words.\"\"\"\\n    return x\\n')
    4
    """
    skipped: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        words = isinstance(node, ast.Expr) and isinstance(getattr(node.value, "value", None), str)
        if words or isinstance(node, ast.Import | ast.ImportFrom):
            skipped.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return sum(bool(line.strip()) and n not in skipped for n, line in enumerate(text.splitlines(), 1))


def _listed(commit: str) -> list[str]:
    return _git("ls-tree", "-r", "--name-only", commit, "src").split()


def _shown(name: str) -> str:
    return _git("show", name)


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], capture_output=True, text=True, check=True).stdout
