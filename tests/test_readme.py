"""Every block of the README, and of the two pages that go on from it, runs as it stands and prints what it says.

Commands and targets of make exist, links lead somewhere."""

from __future__ import annotations

import contextlib
import io
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.problem.catalogue import possible_results
from springpot.theory.registry import METHODS

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
TEXT = README.read_text(encoding="utf-8")
RESULTS, COMMAND = (ROOT / "docs" / name for name in ("how_to/results.md", "command.md"))
ALL = "\n".join(page.read_text(encoding="utf-8") for page in (README, RESULTS, COMMAND))
FENCED = dict.fromkeys(re.findall(r"^```(\w*)\n.*?^```$", ALL, flags=re.MULTILINE | re.DOTALL))


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", ALL, flags=re.MULTILINE | re.DOTALL)


ESTIMATE = re.compile(r"(-?[\d.]+) \+- ([\d.]+)")
BOUND = re.compile(r"bias up to ([\d.]+)")


def same_on_other_processors(printed: str, told: str) -> bool:
    """Whether two texts have the same words, estimates to a tenth of their errors, and bounds on a bias to 10 %.

    Compiled code rounds differently on each kind of processor.
    """
    pairs = zip(ESTIMATE.findall(printed), ESTIMATE.findall(told), strict=True)
    near = all(abs(float(a) - float(b)) < 0.1 * float(error) and own == error for (a, own), (b, error) in pairs)
    bounds = (list(map(float, BOUND.findall(text))) for text in (printed, told))
    without_numbers = (BOUND.sub("", ESTIMATE.sub("", text)) for text in (printed, told))
    return near and next(bounds) == pytest.approx(next(bounds), rel=0.1) and len(set(without_numbers)) == 1


def test_estimates_are_compared_in_units_of_their_errors() -> None:
    told = "by theory 1.1, Monte Carlo 1.1577 +- 0.0068 m2"
    assert same_on_other_processors("by theory 1.1, Monte Carlo 1.1575 +- 0.0068 m2", told)
    assert not same_on_other_processors("by theory 1.1, Monte Carlo 1.1500 +- 0.0068 m2", told)
    assert not same_on_other_processors("by theory 1.2, Monte Carlo 1.1577 +- 0.0068 m2", told)
    told = "2.068 +- 0.018 s-1, step bias up to 0.0085"
    assert same_on_other_processors("2.068 +- 0.018 s-1, step bias up to 0.0086", told)
    assert not same_on_other_processors("2.068 +- 0.018 s-1, step bias up to 0.0100", told)


def test_it_is_short() -> None:
    assert TEXT.count("\n") <= 160


def test_every_block_is_of_a_kind_that_runs_here() -> None:
    """Python with its output, commands, the study and the installation."""
    assert set(FENCED) == {"python", "text", "console", "shell", "sh"}


@pytest.mark.parametrize(("example", "output"), list(zip(blocks("python"), blocks("text"), strict=True)))
def test_the_examples_print_and_draw_what_they_say(example: str, output: str, tmp_path: Path) -> None:
    assert len([line for line in example.splitlines() if line]) <= 10
    printed, names = io.StringIO(), dict[str, object]()
    with contextlib.redirect_stdout(printed):
        exec(example, names)
    assert same_on_other_processors(printed.getvalue(), output)
    for picture in tmp_path.glob("*.png"):
        from matplotlib.image import imread

        made, kept = (imread(place) for place in (picture, ROOT / "docs" / "images" / picture.name))
        assert made.shape == kept.shape
        assert np.mean(np.abs(made - kept)) < 0.01  # on other processors and with other fonts a few points differ
    warnings = getattr(names.get("run"), "warnings", ())
    if example in TEXT:
        assert warnings == ()
    if "distributions=True" in example:  # the one warning of which the text speaks
        (warning,) = warnings
        ((low, high),) = re.findall(r"A warning names the (.*? %) and (.*? %) quantiles of the impact speed", ALL)
        assert re.search(rf"quantiles of the impact speed are wrong: {low} \(.*?\), {high} \(", warning)


@pytest.mark.parametrize("line", dict.fromkeys("".join(blocks("console")).splitlines()))
def test_the_commands_run(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    program, *words = line.split()
    assert program == "springpot"
    assert cli.main(words) == 0
    assert capsys.readouterr().out


@pytest.mark.parametrize("line", dict.fromkeys(re.findall(r"`springpot ([^`]+)`", ALL)))
def test_the_commands_named_in_the_text_exist(line: str) -> None:
    words = [word for word in line.split() if word != "--help"]
    assert words[0] in cli.app
    if len(words) > 1:
        cli.app.parse_args(words, exit_on_error=False, print_error=False)


def test_the_methods_cover_what_the_tables_say() -> None:
    """Those of README and theory: every method and form, and the limits at which a method begins to refuse."""
    theory = (ROOT / "docs" / "theory" / "index.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| (.*) \|$", TEXT, flags=re.MULTILINE))
    more = dict(re.findall(r"^\| \{py:func\}`~springpot.theory.(\w+)` \|.*\| (.*) \|$", theory, flags=re.MULTILINE))
    forms = {name: method.options["form"] for name, method in METHODS.items() if method.options}
    assert set(rows) == set(more) == set(METHODS) - set(forms)
    for form in forms.values():
        assert all(f'`form="{form}"`' in text for text in (TEXT, theory))

    def refuses(method: str, order: float, c: float, position: float, restitution: float) -> bool:
        wall = sp.Barrier(position, restitution)
        return bool(METHODS[method].covers(sp.Oscillator(springpot=sp.Springpot(order, c), barrier=wall)))

    assert "c up to 3" in rows["envelope"]
    assert "$c \\le 3$" in more["envelope"]
    assert [refuses("envelope", 0.5, c, 0.0, 0.9) for c in (3.0, 3.1)] == [False, True]
    assert rows["memory_closure"] == "r from 0.5, wall within one length scale"
    assert more["memory_closure"] == "$r \\ge 0.5$, $\\lvert b\\rvert \\le \\sqrt{q/\\Omega^3}$"
    assert [refuses("memory_closure", 0.5, 0.3, 0.0, r) for r in (0.5, 0.49)] == [False, True]
    assert [refuses("memory_closure", 0.5, 0.3, b, 0.9) for b in (-1.0, -1.01)] == [False, True]
    assert rows["fokker_planck"] == "order 1, r from 0.18"
    assert [refuses("fokker_planck", 1.0, 0.3, 0.0, r) for r in (0.18, 0.17)] == [False, True]
    assert refuses("fokker_planck", 0.9, 0.3, 0.0, 0.9)


def test_it_installs_as_it_says() -> None:
    """Its own test installs the wheel; here: the words are pip's for this folder, and the Python asked for is the one
    that the package asks for."""
    (block,) = blocks("sh")
    assert block == 'python3 -m pip install ".[all]"\n'
    package = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert package["name"] == "springpot"
    assert package["requires-python"] == f">={re.findall(r'Python (3[.][0-9]+) or later', TEXT)[0]}"


def test_the_targets_of_make_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    named = set(re.findall(r"(?:^    |`)make (\w+)", TEXT, flags=re.MULTILINE))
    assert {"figures", "test", "docs"} <= named <= targets


def test_the_first_screen() -> None:
    """What it is, a picture, the installation and an example with its output come before anything else."""
    assert "docs/images/first.png" in TEXT
    assert "first.png" in blocks("python")[0]
    order = ["Random vibration", "![", "## Install", "python3 -m pip install", "```python", "```text", "make figures"]
    places = [TEXT.index(word) for word in order]
    assert places == sorted(places)
    assert TEXT[: places[5]].count("\n") < 60


def test_the_study_is_made_of_commands_that_exist() -> None:
    (block,) = blocks("shell")
    for line in block.splitlines():
        program, *words = line.split()
        assert program == "springpot"
        cli.app.parse_args(words, exit_on_error=False, print_error=False)


@pytest.mark.validation
def test_a_study_from_file_to_chart(tmp_path: Path) -> None:
    (block,) = blocks("shell")
    lines = block.splitlines()
    assert len(lines) <= 5
    for line in lines:
        program, *words = line.split()
        assert program == "springpot"
        assert cli.main(words) == 0
    made = {place.suffix: place for place in tmp_path.iterdir()}
    assert set(made) == {".toml", ".store", ".nc", ".png"}
    assert made[".png"].read_bytes().startswith(b"\x89PNG")
    assert bool(sp.open_study(made[".store"])["simulation"]["done"].all())


def test_every_command_has_its_line() -> None:
    named = re.findall(
        r"`springpot (\w+)", "".join(re.findall(r"^\| .*$", COMMAND.read_text(encoding="utf-8"), flags=re.MULTILINE))
    )
    commands = {name for name in cli.app if not name.startswith("-")}
    assert commands <= set(named)


def test_every_variable_of_the_environment_has_its_line() -> None:
    source = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "src" / "springpot").rglob("*.py"))
    named = set(re.findall(r'environ(?:\.get\(|\[)"(\w+)"', source))
    assert named
    assert named <= set(re.findall(r"`(\w+)`", COMMAND.read_text(encoding="utf-8")))


def test_every_number_has_its_line() -> None:
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w<>]+)`", text))
    results = {re.sub("^barrier_", "<part>_", name) for name in possible_results(sp.Oscillator())}
    assert {*results, "decay_rate", "_se", "_step_bias", "_memory_bias", "_transient", "_error"} <= named


@pytest.mark.parametrize("target", re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT))
def test_links_lead_somewhere(target: str) -> None:
    assert (README.parent / target).is_file()
