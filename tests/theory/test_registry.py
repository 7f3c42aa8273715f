"""The one list of methods: a method that is in it is everywhere, and nowhere else does a name stand."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from springpot.problem.system import System
from springpot.theory import NotCoveredError, registry, solve_all
from tests.golden.systems import system as drawn

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "springpot"

MADE_UP = """
from springpot.theory.result import Moments, Result

def made_up(system):
    return Result("made_up", system, Moments(4.0, 1.0, 2.0, 2.0, 0.5, 1.5, 3.0), (), ())
"""
LINE = '    Method("made_up", "made up", "made_up.made_up", "sky", (2.0, 1.0)),\n'
ASKED = """
import json, sys
from springpot import Oscillator, study
from springpot.cli import main
from springpot.explorer.answers import solve, table
from springpot.explorer.server import method_list
from springpot.figures import METHOD_LINES

assert main(["theory", "--json"]) == 0
system = Oscillator()
tree = study({"name": "one", "methods": ["made_up"], "axes": {"order": [0.5, 1.0]}})
print(json.dumps({
    "page": table(system, {"made_up": solve(system, "made_up")[0]}, {})["methods"]["made_up"]["moments"]["x_mean"],
    "script": method_list(),
    "study": tree["theory"]["x_mean"].values.ravel().tolist(),
    "picture": METHOD_LINES["made_up"],
}))
"""


@pytest.mark.validation  # every day: no script of the page names a method, below
def test_a_made_up_method_takes_one_file_and_one_line(tmp_path: Path) -> None:
    """It is then in `springpot theory`, in the page's table and list, in a study and in pictures."""
    shutil.copytree(SOURCE, tmp_path / "springpot", ignore=shutil.ignore_patterns("*.nbc"))
    (tmp_path / "springpot" / "theory" / "methods" / "made_up.py").write_text(MADE_UP, encoding="utf-8")
    listed = tmp_path / "springpot" / "theory" / "registry.py"
    text = listed.read_text(encoding="utf-8")
    listed.write_text(text.replace(")  # fmt: skip\n\nMETHODS", f"{LINE})  # fmt: skip\n\nMETHODS"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", ASKED], env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True,
        timeout=120, check=True, cwd=tmp_path,
    )  # fmt: skip
    shown, found = json.JSONDecoder().raw_decode(done.stdout), json.loads(done.stdout.splitlines()[-1])
    assert shown[0]["made_up"]["x_mean"] == 1.0
    assert found["page"] == 1.0
    assert found["study"] == [1.0, 1.0]
    assert found["picture"] == ["sky", [0, [2.0, 1.0]]]
    assert '"label": "made up", "color": "sky", "dash": [4.0, 2.0]' in found["script"]


def test_the_list_loads_nothing_heavy() -> None:
    code = (
        "import sys; import springpot.theory.registry\n"
        "print(sorted({'numba', 'xarray', 'matplotlib', 'scipy', 'numpy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == "[]\n"


def test_no_script_of_the_page_names_a_method() -> None:
    names = "|".join(registry.METHODS)
    for script in (SOURCE / "explorer" / "static" / "js").glob("*.js"):
        assert not re.findall(rf'["\'](?:{names})["\']', script.read_text(encoding="utf-8")), script.name


def test_every_method_has_a_row_in_the_readme_and_its_color_in_both_looks() -> None:
    from springpot.figures import COLORS

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    style = (SOURCE / "explorer" / "static" / "style.css").read_text(encoding="utf-8")
    for method in registry.METHODS.values():
        assert f"`{method.function.rpartition('.')[2]}`" in readme
        assert method.color in COLORS
        assert style.count(f"--method-{method.color}: ") == 3  # light, dark, and dark where the system says so
    assert set(COLORS) == set(re.findall(r"--method-(\w+): ", style))


def test_every_method_looks_unlike_the_others_and_each_averaging_without_its_color() -> None:
    looks = {name: (method.color, method.dash) for name, method in registry.METHODS.items()}
    assert len(set(looks.values())) == len(looks)
    averagings = [dash for name, (_, dash) in looks.items() if name.startswith("averaging")]
    assert len(set(averagings)) == len(averagings) == 3


def test_what_a_method_does_not_cover_it_says_without_solving() -> None:
    """The same sentence as when it is asked to solve; and what has an answer is covered."""
    refused = 0
    for number in range(30):
        system = System(*drawn(number)[1])
        for method in registry.METHODS.values():
            sentence = method.covers(system)
            if sentence:
                with pytest.raises(NotCoveredError) as refusal:
                    method.solve(system)
                assert str(refusal.value) == sentence
                refused += 1
        answers, _ = solve_all(system)
        assert not any(registry.METHODS[name].covers(system) for name in answers)
    assert refused > 100
