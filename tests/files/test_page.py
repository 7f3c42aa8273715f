"""Each example of the page on files is read as it stands there, with what it says was assumed."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest

import springpot as sp

PAGE = Path(__file__).parents[2] / "docs" / "how_to" / "files.md"
FENCED = re.compile(r"^```text\n(.*?)^```\n\n```py\n(.*?)^```$", re.MULTILINE | re.DOTALL)
EXAMPLES = FENCED.findall(PAGE.read_text(encoding="utf-8"))


def test_the_page_has_examples() -> None:
    assert len(EXAMPLES) >= 12


@pytest.mark.parametrize(("text", "call"), EXAMPLES)
def test_an_example_is_read(text: str, call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call, _, said = call.strip().partition("  # FileWarning: ")
    name = re.search(r'"([\w.]+)"', call)
    assert name is not None
    if "control" in name[1]:  # three lines of it are 0
        text += "".join(f"{0.625 * n:g},{0.02 if n > 16 else 0}\n" for n in range(3, 400))
    Path(name[1]).write_text(text, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scope: dict[str, object] = {"sp": sp}
        exec(call if "=" in call.partition("(")[0] else f"shake = {call}", scope)
    assert scope["shake"] is not None
    sentences = [str(each.message).split(": ", 1)[1] for each in caught]
    assert sentences == ([said] if said else []) or "tolerance" in call
