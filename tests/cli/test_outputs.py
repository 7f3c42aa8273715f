"""What the command saves, what it warns of, and flags that have no effect."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.machine.bar import Bar
from springpot.machine.progress import Estimate, FractionDone
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.result.warnings import about_options

SHORT = ["simulate", "--paths", "64", "--duration", "2", "--step", "0.02", "--start", "rest"]


@pytest.mark.parametrize("suffix", ["nc", "json"])
def test_a_run_is_saved_with_thinned_paths(suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = tmp_path / f"run.{suffix}"
    assert cli.main([*SHORT, "--out", str(place), "--record", "2", "--record-every", "10", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    again = sp.load_run(place)
    assert again["x_mean"].value == printed["x_mean"]
    asked: dict[str, Any] = {"paths": 64, "duration": 2.0, "step": 0.02, "start": "rest", "record": 2}
    own = sp.simulate(sp.Oscillator(), **asked)
    assert np.array_equal(again.record, own.record[:, ::10])
    before = place.read_bytes()
    assert cli.main([*SHORT, "--out", str(place)]) == 2
    assert capsys.readouterr() == (
        "", f"springpot: {str(place)!r} exists already: give another name, or --overwrite to replace it.\n"
    )  # fmt: skip
    assert place.read_bytes() == before
    assert cli.main([*SHORT, "--out", str(place), "--overwrite"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(place)
    assert sp.load_run(place).settings.record == 0


def test_a_table_and_its_paths_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, "--out", str(tmp_path / "run.csv"), "--record", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == [str(tmp_path / "run.csv"), str(tmp_path / "run_paths.csv")]
    assert (tmp_path / "run.csv").read_text(encoding="utf-8").startswith("quantity,at,along,value,standard_error,")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["simulate", "--record", "2"], "--record needs --out, the file to save to."),
        (["simulate", "--overwrite"], "--overwrite needs --out, the file to save to."),
        (
            ["simulate", "--out", "x.nc", "--record-every", "2"],
            "--record-every needs --record, the number of paths to save.",
        ),
        (
            ["simulate", "--out", "run.txt"],
            "the file to save to must end in .nc (netCDF), .json or .csv (for spreadsheets), not 'run.txt'.",
        ),
        (["validity", "--threads", "2"], "--threads has no effect without --simulate-again: nothing is computed."),
        (
            ["reproduce", "fig1", "--threads", "2"],
            "--threads has no effect on fig1, the Fourier series: nothing is simulated.",
        ),
        (
            ["simulate", "--rtol", "0.1", "--distributions"],
            "--distributions cannot be given with --rtol, which controls moments only: use more paths, "
            "and compare with half the step.",
        ),
        (
            ["simulate", "--rtol", "0.1", "--first-passage", "x", "2"],
            "--first-passage cannot be given with --rtol, which controls moments only: use more paths, "
            "and compare with half the step.",
        ),
        (
            ["simulate", "--order", "0", "--rtol", "0.01"],
            "--rtol needs a stationary state, and there is none: nothing dissipates energy, so it grows without limit.",
        ),
        (
            ["simulate", "--intensity", "0", "--rtol", "0.01"],
            "--rtol needs a stationary state, and there is none: without excitation the motion dies out.",
        ),
        (
            ["compare", "--order", "0"],
            "compare needs a stationary state, and there is none: nothing dissipates energy, so it grows without "
            "limit.",
        ),
        (
            ["simulate", "--rtol", "0.1", "--quantities", "impactrate"],
            "--quantities must be among x_mean, x_mean_square, v_mean_square, amplitude_mean_square, impact_rate, "
            "impact_speed_mean, impact_speed_mean_square, damping_power, input_power, barrier_power, "
            "barrier_force_mean, barrier_impact_rate, barrier_impact_speed_mean, spring_force_mean_square, "
            "springpot_force_mean_square, force_on_ground_mean_square, not impactrate; did you mean impact_rate?",
        ),
    ],
)
def test_flags_that_do_not_go_together_are_refused(
    words: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(words) == 2
    assert capsys.readouterr() == ("", f"springpot: {sentence}\n")


def test_names_that_are_nearly_right() -> None:
    with pytest.raises(ValueError, match=r"not impactrate; did you mean impact_rate\?$"):
        sp.simulate(sp.Oscillator(), rtol=0.1, quantities=("impactrate",))
    with pytest.raises(TypeError, match=r"^there is no argument 'durration'; did you mean duration\?$"):
        sp.simulate(sp.Oscillator(), durration=1.0)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match=r"^quantities has no effect without rtol"):
        sp.simulate(sp.Oscillator(), quantities=("impact_rate",))


SPRING = sp.Oscillator(springpot=sp.Springpot(0.0, 0.5), barrier=sp.Barrier(0.0, 0.8))
WITHOUT_EFFECT: list[tuple[sp.Oscillator, dict[str, Any], str]] = [
    (sp.Oscillator(), {"contact_tolerance": 1e-4}, "contact_tolerance has no effect without scheme='grunwald'."),
    (
        sp.Oscillator(barrier=None),
        {"contact_tolerance": 1e-4, "scheme": "grunwald", "memory_tolerance": 1e-9},
        "contact_tolerance has no effect without a wall.",
    ),
    (SPRING, {"derivative": "riemann-liouville"}, "derivative has no effect: no springpot has an order above 0."),
    (
        sp.Oscillator(),
        {"derivative": "riemann-liouville"},
        "derivative='riemann-liouville' has no effect with x(0) = 0: both derivatives are the same.",
    ),
    (SPRING, {"memory_tolerance": 1e-5}, "memory_tolerance has no effect: no part has memory."),
]


@pytest.mark.parametrize(("oscillator", "given", "sentence"), WITHOUT_EFFECT)
def test_an_argument_without_effect_is_warned_of(oscillator: sp.Oscillator, given: Any, sentence: str) -> None:
    settings: dict[str, Any] = {"paths": 64, "duration": 1.0, "step": 0.01, "initial_velocity": 0.5}
    found = sp.simulate(oscillator, **settings, **given)
    assert sentence in found.warnings
    plain = sp.simulate(
        oscillator, **settings, **{name: given[name] for name in given if not sentence.startswith(name)}
    )
    for name, estimate in found.estimates.items():
        assert estimate == plain[name] or np.isnan(estimate.value)
    assert sentence not in plain.warnings


def test_arguments_with_an_effect_are_not_warned_of() -> None:
    walled = sp.Oscillator(barrier=sp.Barrier(0.5, 0.8, free_side="above"))
    for oscillator, given in (
        (walled, {"derivative": "riemann-liouville", "memory_tolerance": 1e-9}),
        (sp.Oscillator(), {"derivative": "riemann-liouville", "initial_position": 1.0}),
        (sp.Oscillator(), {"scheme": "grunwald", "contact_tolerance": 1e-4}),
    ):
        assert about_options(plan_of(oscillator, **given), given) == []  # type: ignore[arg-type]


def test_a_warning_names_flags_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, "--contact-tolerance", "1e-4"]) == 0
    err = capsys.readouterr().err
    assert "springpot: warning: --contact-tolerance has no effect without --scheme grunwald.\n" in err
    assert "contact_tolerance" not in err


@pytest.mark.parametrize(
    ("words", "flag"),
    [
        (["--scheme", "grunwald", "--contact-tolerance", "0.1"], "--contact-tolerance is 0.1 m"),
        (["--window", "0", "1"], "--window starts at 0 s"),
        (["--step", "0.2"], "--step is 0.2 s"),
        (["--restitution", "0.1"], "restitution 0.1 of barrier is not above"),
        (["--derivative", "riemann-liouville"], "--derivative riemann-liouville has no effect"),
        (["--restitution", "0.3"], "With --rtol the error is bounded"),
    ],
)
def test_no_warning_names_an_argument_of_python(
    words: list[str], flag: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [word for pair in zip(SHORT[1::2], SHORT[2::2], strict=True) if pair[0] not in words for word in pair]
    assert cli.main(["simulate", *given, *words]) == 0
    warnings = capsys.readouterr().err
    assert flag in warnings
    assert not re.search(r"\w=\S|(?<![\w-])(rtol|contact_tolerance|memory_tolerance|initial_\w+)", warnings)


def test_a_time_that_is_too_short_names_the_flag(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["simulate", "--rtol", "0.05", "--max-time", "1e-6"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("springpot: --max-time of 1e-06 s is too short for any result: ")
    assert err.count("\n") == 1


def test_a_missing_file_is_bad_input(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from springpot.simulation import monte_carlo

    def run(*_: object, **__: object) -> None:
        open("missing.bin", encoding="utf-8")  # noqa: SIM115

    monkeypatch.setattr(monte_carlo, "simulated", run)
    assert cli.main(["simulate"]) == 2
    assert capsys.readouterr() == ("", "springpot: There is no file 'missing.bin'.\n")


@pytest.mark.parametrize("words", [["theory"], ["atlas"]])
def test_the_oscillator_is_shown(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*words, "--order", "0.7"]) == 0
    equation, wall, noise, *_ = capsys.readouterr().out.splitlines()
    assert equation == "x'' + 1 x + 1 D^0.7 x = w(t)"
    print(wall, noise)


def test_work_that_grows_is_announced_again(capsys: pytest.CaptureFixture[str]) -> None:
    bar = Bar("simulating")
    for path_steps, seconds in ((1e9, 5.0), (2e9, 60.0), (2.5e9, 80.0), (9e9, 300.0), (9e9, 8.0), (9e12, 9.0)):
        bar(FractionDone(0.1, Estimate(path_steps, seconds, "the damping is light", 0.01)))
    why = "path-steps in all; the damping is light (--max-time ends it earlier)."
    assert capsys.readouterr().err.splitlines() == [
        f"springpot: this takes about 60 s more, 2.0e+09 {why}",
        f"springpot: this takes longer than was estimated: about 5 min more, 9.0e+09 {why}",
    ]
