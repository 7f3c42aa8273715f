"""The text to copy from the page: whatever a file is called, it is one Python string and one word of a shell."""

from __future__ import annotations

import ast
import subprocess

import pytest

import springpot as sp
from springpot.explorer.copies import command_of, python_of
from springpot.explorer.protocol import Problem
from springpot.machine.files import shell_word

NAMES = (
    "my device.toml",
    'a".toml',
    "it's.toml",
    "a\nb.toml",
    "--json.toml",
    "$(id).toml",
    "back\\slash.toml",
    "π.toml",
)
RECORD = sp.System(sp.Spring(1.0), sp.RecordedExcitation((0.0, 1.0), (0.0, 1.0)))


@pytest.mark.parametrize("name", NAMES)
def test_a_file_of_any_name_is_one_word(name: str) -> None:
    tree = ast.parse(python_of(RECORD, name, Problem()))
    calls = [
        node for node in ast.walk(tree) if isinstance(node, ast.Call) and ast.unparse(node.func) == "sp.read_system"
    ]
    assert [ast.literal_eval(call.args[0]) for call in calls] == [name]
    words = command_of(name, (), Problem()).removeprefix("springpot simulate ").partition(" --paths")[0]
    assert "\n" not in words
    assert words == shell_word(name)
    said = subprocess.run(["bash", "-c", f"printf '%s' {words}"], capture_output=True, check=True).stdout.decode()
    assert said.removeprefix("./") == name
    assert not said.startswith("-")
