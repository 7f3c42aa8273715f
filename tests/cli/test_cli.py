"""The command: what its flags ask of the library, what it prints where, and its exit codes."""

from __future__ import annotations

import contextlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import pytest

import springpot
from springpot import cli
from springpot.cli import doctor
from springpot.machine import bar as progress_bar
from springpot.machine.crew import control_group_quota
from springpot.machine.faults import with_error
from springpot.machine.interrupt import leave_at_once
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.simulation import monte_carlo
from springpot.simulation.kernel.native import ENTRIES
from springpot.simulation.plan.options import Options
from tests.posix import needs_signals
from tests.signals import in_a_terminal
from tests.sizes import validation

COMMAND = [sys.executable, "-m", "springpot"]
PLAIN = springpot.Oscillator()
UNITS = {name: unit_of_result(PLAIN, name) for name in possible_results(PLAIN)}


class Answer:
    """Stands for a run's answer: every quantity the same, one that does not exist (no impacts), one warning."""

    def __init__(self, settings: dict[str, Any], system: springpot.System) -> None:
        self._settings, self.system, self.units = settings, system, UNITS

    def to_dict(self) -> dict[str, Any]:
        numbers = dict.fromkeys(UNITS, 1.2345678) | {f"{name}_se": 0.0123 for name in UNITS}
        if "rtol" in self._settings:
            parts = {"_step_bias": 0.005, "_memory_bias": 1e-7, "_transient": 0.0, "_error": 0.029}
            numbers |= {f"x_mean{part}": value for part, value in parts.items()}
        return {
            **numbers,
            "impact_speed_mean": None,
            "impact_speed_mean_se": None,
            "settings": self._settings,
            "system": self.system.to_dict(),
            "diagnostics": {"modes": [1.0, math.nan, math.inf]},
            "warnings": ["The window is short."],
        }


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the command asked of `simulated`, which only takes note here."""
    note: dict[str, Any] = {}

    def run(system: springpot.System, **settings: Any) -> Answer:
        settings.pop("progress")(0.5)
        note.update(settings, system=system)
        return Answer(settings, system)

    monkeypatch.setattr(monte_carlo, "simulated", run)
    return note


def raising(error: BaseException) -> Callable[..., Any]:
    def run(*_: object, **__: object) -> Any:
        raise error

    return run


def test_without_a_command_help_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    out, err = capsys.readouterr()
    assert all(command in out for command in ("theory", "simulate", "doctor", "reproduce"))
    assert err == ""


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"{springpot.__version__}\n"


COMMANDS = ["explain", "theory", "atlas", "compare", "simulate", "doctor", "reproduce", "validity", "explore", "fit",
            "sensitivity", "design", "exceedance", "scatter"]  # fmt: skip
STUDY_COMMANDS = [f"study {name}" for name in ("new", "schema", "check", "run", "status", "export", "plot")]


@pytest.mark.parametrize("command", [*COMMANDS, *STUDY_COMMANDS])
def test_every_command_has_help_with_an_example_that_it_takes(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*command.split(), "--help"]) == 0
    text = capsys.readouterr().out
    assert f"Usage: springpot {command}" in text
    example = text.partition("Example: springpot ")[2].partition("\n\n")[0].partition("╭")[0].split()
    assert example[: len(command.split())] == command.split()
    cli.commands.app.parse_args(example, exit_on_error=False, print_error=False)


def test_no_command_is_missing_above(capsys: pytest.CaptureFixture[str]) -> None:
    from springpot.cli.studying import app as study

    assert {*COMMANDS, "study"} == {name for name in cli.commands.app if not name.startswith("-")}
    assert {f"study {name}" for name in study if not name.startswith("-")} == set(STUDY_COMMANDS)
    assert cli.main(["--help"]) == 0
    listed = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert f"study {' '.join(study.help.split())}" in listed


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from springpot.cli import main; main(['--help'])\n"
        "print(sorted({'numba', 'xarray', 'matplotlib', 'scipy', 'numpy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_theory_json_has_one_object_per_method(capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--order", "0.7", "--coefficient", "0.2", "--natural-frequency", "3"]
    assert cli.main(["theory", *flags, "--json"]) == 0
    out, _ = capsys.readouterr()
    answer = json.loads(out)
    assert answer["system"]["parts"] == [
        {"name": "spring", "kind": "spring", "stiffness": 9.0},
        {"name": "springpot", "kind": "springpot", "order": 0.7, "coefficient": 0.2},
        {"name": "barrier", "kind": "barrier", "position": 0.0, "restitution": 1.0, "free_side": "above"},
        {"name": "white_noise", "kind": "white_noise", "intensity": 1.0, "on": "mass"},
    ]
    assert answer["averaging_printed"]["amplitude_mean_square"] == pytest.approx(3.519, abs=5e-4)
    assert answer["averaging"]["amplitude_mean_square"] == pytest.approx(1.173, abs=5e-4)
    assert answer["averaging"]["impact_rate"] == pytest.approx(3 / math.pi)
    assert answer["averaging"]["decay_rate"] > 0


@pytest.mark.parametrize("flags", [["--order", "0"], validation(["--position", "1"]), ["--coefficient", "0"]])
def test_theory_states_where_it_has_no_answer(flags: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory", *flags, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    for method in ("averaging", "averaging_printed"):
        assert answer[method]["amplitude_mean_square"] is None
        assert len(answer[method]["statement"]) > 20
    assert cli.main(["theory", *flags]) == 0
    assert answer["averaging"]["statement"] in capsys.readouterr().out


def test_theory_prints_a_table_with_units(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["theory"]) == 0
    out, _ = capsys.readouterr()
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines() if line.startswith("  ")}
    assert out.splitlines()[0].startswith("x'' + 1 x + 1 D^0.5 x = w(t)")
    methods = next(line.split() for line in out.splitlines() if line.lstrip().startswith("averaging_printed"))
    assert [name for name in methods if name != "*"][:3] == ["averaging_printed", "averaging", "averaging_amplitude"]
    assert rows["amplitude_mean_square"][:2] == ["2.2963", "2.2963"]
    assert rows["amplitude_mean_square"][-1] == "m2"
    assert out.splitlines()[-1] in ("* recommended here: memory_closure", "* recommended here: envelope")
    assert "fokker_planck: The Fokker-Planck solution covers order 1" in out


def test_theory_does_without_a_compiler() -> None:
    code = "import sys; from springpot.cli import main; main(['theory']); print('numba' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "False", done.stderr


def test_theory_warns_of_the_method_it_recommends(capsys: pytest.CaptureFixture[str]) -> None:
    flags = ["--order", "0.3", "--coefficient", "3", "--position", "-0.5", "--restitution", "0.5"]
    assert cli.main(["theory", *flags]) == 0
    best = capsys.readouterr()
    name = best.out.splitlines()[-1].rsplit(" ", 1)[-1]
    sentences = best.err.splitlines()
    assert len(sentences) == len(set(sentences)) > 0
    assert all(sentence.startswith(f"springpot: warning: {name}: ") for sentence in sentences)
    assert cli.main(["theory", "--order", "1"]) == 0
    assert capsys.readouterr().err == ""  # exact


def test_simulate_leaves_the_defaults_to_the_library(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--json"]) == 0
    capsys.readouterr()
    assert asked == {"system": springpot.Oscillator()}


def test_help_states_the_librarys_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    stated = {field.name for field in fields(cli.flags.RunFlags)}
    assert {"seed", "scheme", "memory_tolerance"} < stated
    for name, default in asdict(Options()).items():
        if name in stated and default is not None:
            wanted = f"{default if isinstance(default, str) else format(default, 'g')} if not given"
            mentions = text.split(f" --{name.replace('_', '-')} ")[1:]  # its entry, and those of others that name it
            assert any(wanted in mention.partition(" --")[0] for mention in mentions), name


def test_simulate_passes_every_flag_on(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    words = (
        "--order 0.25 --coefficient 2 --natural-frequency 3 --intensity 4 --position -0.5 --restitution 0.9"
        " --free-side below --paths 7 --duration 9 --step 1e-2 --window 3 8.5 --seed 11 --threads 2 --scheme grunwald"
        " --start stationary --initial-position -1.5 --initial-velocity -2 --derivative riemann-liouville"
        " --memory-tolerance 1e-8 --contact-tolerance 2e-5"
    )
    assert cli.main(["simulate", *words.split()]) == 0
    capsys.readouterr()
    assert asked == {
        "system": springpot.Oscillator(
            natural_frequency=3.0,
            springpot=springpot.Springpot(order=0.25, coefficient=2.0),
            barrier=springpot.Barrier(position=-0.5, restitution=0.9, free_side="below"),
            excitation=springpot.WhiteNoise(intensity=4.0),
        ),
        "paths": 7,
        "duration": 9.0,
        "step": 0.01,
        "window": (3.0, 8.5),
        "seed": 11,
        "threads": 2,
        "scheme": "grunwald",
        "start": "stationary",
        "initial_position": -1.5,
        "initial_velocity": -2.0,
        "derivative": "riemann-liouville",
        "memory_tolerance": 1e-8,
        "contact_tolerance": 2e-5,
    }
    assert isinstance(asked["paths"], int)


def test_simulate_passes_an_error_asked_for_on(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    words = "--rtol 0.01 --quantities x_mean impact_rate --seed 3 --threads 2"
    assert cli.main(["simulate", *words.split()]) == 0
    capsys.readouterr()
    assert asked == {
        "system": springpot.Oscillator(),
        "rtol": 0.01,
        "quantities": ["x_mean", "impact_rate"],
        "seed": 3,
        "threads": 2,
    }


def test_no_barrier(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--no-barrier"]) == 0
    capsys.readouterr()
    assert not asked["system"].of(springpot.Barrier)


def test_json_is_one_object_without_nan(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    assert answer["x_mean_square"] == 1.2345678
    assert answer["impact_speed_mean"] is None
    assert answer["diagnostics"] == {"modes": [1.0, None, None]}


def test_the_table_shows_values_with_errors_and_units(
    asked: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["simulate"]) == 0
    out, err = capsys.readouterr()
    table = out.partition("\nsettings: ")[2].splitlines()
    rows = dict(line.split(maxsplit=1) for line in table if line.startswith("  "))
    assert rows.pop("value") == "+- standard error"
    assert rows.keys() == UNITS.keys()
    assert rows["x_mean_square"] == "1.235 +- 0.012 m2"
    assert rows["energy_residual"] == "1.235 +- 0.012"
    assert rows["impact_speed_mean"] == "none"
    assert out.startswith("system:\n  x'' + 1 x + 1 D^0.5 x = w(t)\n")
    assert "  wall (barrier): x >= 0 m, restitution 1\n" in out
    assert err == "springpot: warning: The window is short.\n"


def test_the_table_shows_an_error_and_its_parts(asked: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--rtol", "0.03", "--quantities", "x_mean"]) == 0
    lines = capsys.readouterr().out.partition("\nsettings: ")[2].splitlines()
    cells = [[cell.strip() for cell in line.split("  ") if cell] for line in lines if line.startswith("  ")]
    assert cells[0] == ["value +- total error (95 %)", "standard error", "step", "memory", "transient"]
    assert cells[1] == ["x_mean", "1.235 +- 0.029 m", "0.012", "0.005", "1e-07", "0"]
    assert cells[2] == ["value +- standard error"]
    assert cells[3] == ["x_mean_square", "1.235 +- 0.012 m2"]
    assert {row[0] for row in cells if len(row) > 1} == {*UNITS, "value +- total error (95 %)"}


def test_a_real_run_to_an_error_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--rtol", "0.05", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    name = "amplitude_mean_square"
    bounds = answer[f"{name}_step_bias"] + answer[f"{name}_memory_bias"] + answer[f"{name}_transient"]
    assert answer[f"{name}_error"] == pytest.approx(1.96 * answer[f"{name}_se"] + bounds, rel=1e-3)
    assert answer[f"{name}_error"] < 0.05 * answer[name]


def test_a_real_run_with_distributions(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", "--paths", "700", "--duration", "5", "--step", "0.02", "--distributions"]
    assert cli.main(words) == 0
    rows = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")}
    assert "5 %" in rows["quantile"]
    assert rows["impact_speed"].count("+-") == rows["x_maximum"].count("+-") == 5
    assert rows["impact_speed"].endswith("m s-1")
    assert cli.main([*words, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert len(answer["probability"]) == len(answer["x_quantile"]) == len(answer["v_largest_quantile_se"]) == 9
    assert sorted(answer["amplitude_quantile"]) == answer["amplitude_quantile"]


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (1.23456, 0.0123, "1.235 +- 0.012"),
        (123.456, 12.3, "123 +- 12"),
        (123456.0, 1234.0, "123456 +- 1234"),
        (5.2, 0.1, "5.20 +- 0.10"),
        (5.2, 0.0996, "5.20 +- 0.10"),
        (0.00002, 0.0003, "0.00002 +- 0.00030"),
        (-1.23e-4, 1.2e-6, "-0.0001230 +- 0.0000012"),
        (1.5e-9, 1.5e-11, "(1.500 +- 0.015)e-09"),
        (2.12e50, 1e48, "(2.120 +- 0.010)e+50"),
        (-1234567.0, 1200.0, "(-1.2346 +- 0.0012)e+06"),
        (3.0, 2e7, "(0.0 +- 2.0)e+07"),
        (1.0, 1e-12, "1 +- 1.0e-12"),
        (0.5, 0.0, "0.5 +- 0"),
        (0.5, None, "0.5 (no error known)"),
        (None, None, "none"),
    ],
)
def test_values_have_the_digits_of_their_errors(value: float | None, error: float | None, text: str) -> None:
    assert with_error(value, error) == text


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ValueError("duration must be positive,\nnot -1."), 2),
        (TypeError("paths must be a whole number."), 2),
        (OSError(28, "No space left on device"), 1),
        (RuntimeError("it did not converge."), 1),
        (MemoryError(), 1),
        (KeyboardInterrupt(), 130),
    ],
)
@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_failures_say_one_sentence(
    error: BaseException,
    code: int,
    flags: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(monte_carlo, "simulated", raising(error))
    assert cli.main(["simulate", *flags]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("springpot: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (IsADirectoryError(21, "Is a directory", "out/fig1.png"), "'out/fig1.png' failed: Is a directory."),
        (OSError(28, "No space left on device"), "reading or writing failed: No space left on device."),
        (NotADirectoryError("The folder 'x' is a file."), "The folder 'x' is a file."),
        (MemoryError("Unable to allocate 417. GiB"), "there is not enough memory for this: use fewer --paths."),
    ],
)
def test_failures_of_the_system_are_sentences(
    error: Exception, sentence: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(monte_carlo, "simulated", raising(error))
    assert cli.main(["simulate"]) == 1
    assert capsys.readouterr() == ("", f"springpot: {sentence}\n")


def test_a_refused_argument_is_named_as_its_flag(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    refusal = ValueError("memory_tolerance is 2, but at most 1 is allowed.")
    monkeypatch.setattr(monte_carlo, "simulated", raising(refusal))
    assert cli.main(["simulate"]) == 2
    assert capsys.readouterr().err == "springpot: --memory-tolerance is 2, but at most 1 is allowed.\n"


@pytest.mark.parametrize(
    ("library", "command"),
    [
        ("start='stationary' needs noise.", "--start stationary needs noise."),
        ("initial_position is -1 (free_side='above').", "--initial-position is -1 (--free-side above)."),
        (
            "step cannot be given with rtol; only seed and threads can.",
            "--step cannot be given with --rtol; only seed and threads can.",
        ),
        ("quantities must be among x_mean, not y.", "--quantities must be among x_mean, not y."),
        ("The paths start at the initial_position.", "The paths start at the --initial-position."),
        ('Use start="stationary" for those.', "Use --start stationary for those."),
        ("use record_every=4 or at most 3 paths.", "use --record-every 4 or at most 3 paths."),
        ("give another name, or overwrite=True to replace it.", "give another name, or --overwrite to replace it."),
        ("With rtol= the error is bounded.", "With --rtol the error is bounded."),
        ("quantities does not name these results.", "--quantities does not name these results."),
        ("barrier must be true.", "--barrier must be true."),
        ("barrier at -6 m is far away: check position.", "barrier at -6 m is far away: check position."),  # a part
    ],
)
def test_arguments_become_flags(library: str, command: str) -> None:
    assert cli.flags.in_flags(library) == command


def test_reproduce_prints_what_it_wrote(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.main(["reproduce", "fig1", "--out", str(tmp_path / "here")]) == 0
    out, err = capsys.readouterr()
    assert out == f"{tmp_path / 'here' / 'fig1.png'}\n"
    assert err == ""
    assert (tmp_path / "here" / "fig1.png").read_bytes().startswith(b"\x89PNG")


def test_a_folder_that_cannot_be_made_is_a_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    assert cli.main(["reproduce", "fig1", "--out", str(tmp_path / "file" / "figures")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("springpot: ")
    assert err.count("\n") == 1


def wait_for(condition: Callable[[], object]) -> None:
    for _ in range(500):
        if condition():
            return
        time.sleep(0.01)
    raise AssertionError("waited for 5 s")


def test_the_bar_waits_and_writes_to_stderr_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(progress_bar, "QUIET_SECONDS", 0.3)
    with progress_bar.Bar("working", first="finding its feet") as bar:
        assert capsys.readouterr() == ("", "")
        wait_for(lambda: bar._bar)
        assert bar._bar is not None
        (task,) = bar._bar.tasks
        assert (task.description, task.total) == ("finding its feet", None)
        bar(0.25)
        assert (task.description, task.total, task.completed) == ("working", 1.0, 0.25)
        bar(0.5, "half done")
        bar._bar.refresh()
    out, err = capsys.readouterr()
    assert out == ""
    assert "half done" in err


def test_short_work_shows_no_bar(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with progress_bar.Bar("working") as bar:
        bar(0.5)
    assert capsys.readouterr() == ("", "")
    assert not bar._timer.is_alive() or bar._timer.join(5.0) is None


def test_no_bar_without_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(progress_bar, "QUIET_SECONDS", 0.0)
    before = threading.active_count()
    with progress_bar.Bar("working") as bar:
        bar(0.5)
        assert threading.active_count() == before
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("words", "first"),
    [
        ("", "finding the stationary start"),
        ("--initial-position 1", "simulating"),
        ("--coefficient 0", "simulating"),
        ("--start rest", "simulating"),
        ("--start stationary", "finding the stationary start"),
        ("--rtol 0.01", "finding the stationary start"),
    ],
)
def test_what_the_bar_says_first(
    words: str,
    first: str,
    asked: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    said: list[str] = []
    bar = progress_bar.Bar
    monkeypatch.setattr(cli.commands, "Bar", lambda text, first, **more: said.append(first) or bar(text, first))
    assert cli.main(["simulate", *words.split()]) == 0
    assert said == [first]
    capsys.readouterr()


@pytest.mark.parametrize("passed", [True, False])
def test_doctor_fails_when_its_check_does(
    passed: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    check = {"passed": passed, "statement": "self-check made up", "seconds": 1.0}
    monkeypatch.setattr(doctor, "self_check", lambda: check)
    assert cli.main(["doctor"]) == (0 if passed else 1)
    out, err = capsys.readouterr()
    assert "self-check made up" in out
    assert ("self-check failed" in err) is not passed
    assert cli.main(["doctor", "--json"]) == (0 if passed else 1)
    findings = json.loads(capsys.readouterr().out)
    assert findings["versions"]["springpot"] == springpot.__version__
    assert set(findings["extras"]) == {"files", "plots", "studies", "cluster", "page", "uff", "op4"}
    assert set(findings) == {"versions", "extras", "processor", "threads", "compiled_code", "cache", "self_check"}


def test_doctor_compiles_ahead(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """And then checks as always; where the code comes from is said of every compiled function."""
    asked: list[str] = []
    made = doctor._ask_for_all
    monkeypatch.setattr(doctor, "_ask_for_all", lambda system, point: asked.append(point) or made(system, point))
    monkeypatch.setattr(doctor, "self_check", lambda: {"passed": True, "statement": "left out", "seconds": 1.0})
    assert cli.main(["doctor", "--compile", "--json"]) == 0
    assert asked == ["", "a_"]
    code = json.loads(capsys.readouterr().out)["compiled_code"]
    assert code.pop("lanes") in (32, 64)
    goal = code.pop("target")
    assert code.keys() == {entry.name for entry in ENTRIES}
    assert all(f"for {goal}" in words for words in code.values())


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        ({}, math.inf),
        ({"cpu.max": "max 100000"}, math.inf),
        ({"cpu.max": "150000 100000"}, 1.5),
        ({"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, math.inf),
        ({"cpu/cpu.cfs_quota_us": "400000", "cpu/cpu.cfs_period_us": "100000"}, 4.0),
    ],
)
def test_the_control_groups_quota(files: dict[str, str], expected: float, tmp_path: Path) -> None:
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert control_group_quota(tmp_path) == expected


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--version"], 0),
        validation(["nonsense"], 2),
        (["theory", "--order", "2"], 2),
        validation(["simulate", "--paths", "x"], 2),
    ],
)
def test_exit_codes_of_a_real_process(words: list[str], code: int) -> None:
    done = subprocess.run([*COMMAND, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    if code:
        assert done.stdout == ""
        assert len(done.stderr.splitlines()) == 1


def test_a_reader_that_goes_away_is_no_news() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    words = ["study", "schema"]
    done = subprocess.run([*COMMAND, *words], stdout=writing, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(writing)
    assert done.returncode == 1
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_one_sentence() -> None:
    words = ["study", "schema"]
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([*COMMAND, *words], stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr == "springpot: reading or writing failed: No space left on device.\n"


@pytest.mark.parametrize("encoding", ["cp1252", validation("ascii"), validation("utf-8")])
def test_a_name_may_have_letters_that_the_terminal_lacks(encoding: str, tmp_path: Path) -> None:
    """As a pipe of Windows does: the file is UTF-8 in any case, also with its ends of lines."""
    place, part = (
        tmp_path / "gr\N{LATIN SMALL LETTER O WITH DIAERESIS}\N{GREEK SMALL LETTER OMEGA}.toml",
        "mount_\u03c9",
    )
    parts = 'kind = "spring"\nstiffness = 1.0', f'kind = "dashpot"\nname = "{part}"\ncoefficient = 0.4'
    place.write_bytes("".join(f"[[parts]]\n{each}\n" for each in parts).replace("\n", "\r\n").encode())
    done = subprocess.run(
        [*COMMAND, "explain", str(place)], capture_output=True, timeout=60,
        env={**os.environ, "PYTHONIOENCODING": encoding},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert part.encode(encoding, "backslashreplace") in done.stdout


@needs_signals
@pytest.mark.parametrize("module", ["springpot.cli", "cyclopts", "springpot.theory", "scipy"])
def test_an_interrupt_while_modules_load_ends_with_130(module: str) -> None:
    """The signal arrives just as a module begins to load."""
    code = f"""
import os, runpy, signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.argv = ["springpot", "theory"]
runpy.run_module("springpot", run_name="__main__", alter_sys=True)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 130, done.stderr
    assert (done.stdout, done.stderr) == ("", "springpot: interrupted.\n")


def test_the_callers_own_handling_of_signals_stays() -> None:
    for handler in (signal.SIG_IGN, signal.default_int_handler):
        before = signal.signal(signal.SIGINT, handler)
        try:
            with leave_at_once():
                assert (signal.getsignal(signal.SIGINT) is handler) == (handler is signal.SIG_IGN)
            assert signal.getsignal(signal.SIGINT) is handler
        finally:
            signal.signal(signal.SIGINT, before)


@needs_signals
def test_an_interrupted_run_ends_with_130() -> None:
    """A run of hours, interrupted while it computes."""
    words = ["simulate", "--paths", "1000000", "--duration", "1000", "--step", "1e-3", "--threads", "1", "--json"]
    with in_a_terminal():
        process = subprocess.Popen(
            [*COMMAND, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
    try:
        time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
    assert process.returncode == 130, err
    assert out == ""
    *first, last = err.splitlines()  # none if the interrupt comes while the kernel is compiled
    assert all(line.startswith("springpot: this takes about ") for line in first)
    assert last == "springpot: interrupted."
