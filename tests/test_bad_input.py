"""Bad input: one clear sentence that names the argument, from Python and from the command, and exit code 2."""

from __future__ import annotations

import math
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas
import pytest

import springpot as sp
from springpot import Barrier, Oscillator, Springpot, WhiteNoise, cli
from springpot.simulation import simulate
from springpot.simulation.watch.distributions import Distribution
from tests.sizes import thinned, validation

PARTS: dict[str, Any] = {
    "order": lambda value: Springpot(order=value, coefficient=1.0),
    "coefficient": lambda value: Springpot(order=0.5, coefficient=value),
    "natural_frequency": lambda value: Oscillator(natural_frequency=value),
    "intensity": lambda value: WhiteNoise(intensity=value),
    "position": lambda value: Barrier(position=value),
    "restitution": lambda value: Barrier(restitution=value),
    "free_side": lambda value: Barrier(free_side=value),
    "springpot": lambda value: Oscillator(springpot=value),
    "barrier": lambda value: Oscillator(barrier=value),
    "excitation": lambda value: Oscillator(excitation=value),
}

OUT_OF_RANGE = [
    ("order", -0.1),
    ("order", 1.1),
    ("coefficient", -1.0),
    ("natural_frequency", 0.0),
    ("natural_frequency", -2.0),
    ("intensity", -1e-9),
    ("restitution", -0.5),
    ("restitution", 1.1),
    ("free_side", "left"),
    *[
        (name, value)
        for name in ("order", "coefficient", "natural_frequency", "intensity", "position", "restitution")
        for value in (math.nan, math.inf, -math.inf)
    ],
]

WRONG_KIND = [
    *[
        (name, value)
        for name in ("order", "coefficient", "natural_frequency", "intensity", "position", "restitution")
        for value in (True, "1", None, 1j, [0.5], np.array([0.5, 0.5]))
    ],
    ("springpot", 0.5),
    ("springpot", None),
    ("barrier", 0.0),
    ("barrier", "none"),
    ("excitation", 1.0),
]

# What is asked of a run, the argument that its sentence must name, and the same as the words of a command (None: the
# command has no such flag, or the words would mean something else).
RUNS: list[tuple[dict[str, Any], str, str | None]] = [
    ({"paths": 0}, "paths", "--paths 0"),
    ({"paths": -5}, "paths", "--paths -5"),
    ({"paths": 2.5}, "paths", "--paths 2.5"),
    ({"paths": 100.0}, "paths", "--paths 100.0"),
    ({"paths": True}, "paths", None),
    ({"paths": "many"}, "paths", "--paths many"),
    ({"paths": 2**40}, "paths", f"--paths {2**40}"),
    ({"duration": 0.0}, "duration", "--duration 0"),
    ({"duration": -1.0}, "duration", "--duration -1"),
    ({"duration": math.nan}, "duration", "--duration nan"),
    ({"duration": math.inf}, "duration", "--duration inf"),
    ({"duration": "long"}, "duration", "--duration long"),
    ({"step": 0.0}, "step", "--step 0"),
    ({"step": -0.01}, "step", "--step -0.01"),
    ({"step": math.nan}, "step", "--step nan"),
    ({"step": 2.0, "duration": 10.0}, "step", "--step 2 --duration 10"),
    ({"step": 0.3, "duration": 0.2}, "step", "--step 0.3 --duration 0.2"),
    ({"step": 1e-12, "duration": 100.0}, "duration", "--step 1e-12 --duration 100"),
    ({"step": [0.01]}, "step", None),
    ({"window": (8.0, 2.0), "duration": 10.0}, "window", "--window 8 2 --duration 10"),
    ({"window": (2.0, 2.0), "duration": 10.0}, "window", "--window 2 2 --duration 10"),
    ({"window": (2.0, 11.0), "duration": 10.0}, "window", "--window 2 11 --duration 10"),
    ({"window": (-1.0, 5.0), "duration": 10.0}, "window", "--window -1 5 --duration 10"),
    ({"window": (math.nan, 5.0), "duration": 10.0}, "window", "--window nan 5 --duration 10"),
    ({"window": (1.0, math.inf), "duration": 10.0}, "window", "--window 1 inf --duration 10"),
    ({"window": (1.0,), "duration": 10.0}, "window", "--window 1 --duration 10"),
    ({"window": (1.0, 2.0, 3.0), "duration": 10.0}, "window", None),
    ({"window": 5.0, "duration": 10.0}, "window", None),
    ({"window": "ab", "duration": 10.0}, "window", None),
    ({"window": ("a", "b"), "duration": 10.0}, "window", "--window a b --duration 10"),
    ({"seed": -1}, "seed", "--seed -1"),
    ({"seed": 2**64}, "seed", f"--seed {2**64}"),
    ({"seed": 1.5}, "seed", "--seed 1.5"),
    ({"seed": None}, "seed", None),
    ({"threads": 0}, "threads", "--threads 0"),
    ({"threads": -2}, "threads", "--threads -2"),
    ({"threads": 1.5}, "threads", "--threads 1.5"),
    ({"scheme": "euler"}, "scheme", "--scheme euler"),
    ({"scheme": None}, "scheme", None),
    ({"start": "running"}, "start", "--start running"),
    ({"derivative": "grunwald"}, "derivative", "--derivative grunwald"),
    ({"initial_position": -0.1}, "initial_position", "--initial-position -0.1"),
    ({"initial_position": math.nan}, "initial_position", "--initial-position nan"),
    ({"initial_position": "here"}, "initial_position", "--initial-position here"),
    ({"initial_position": 1.0, "start": "stationary"}, "initial_position", "--initial-position 1 --start stationary"),
    ({"initial_velocity": math.nan}, "initial_velocity", "--initial-velocity nan"),
    ({"initial_velocity": math.inf}, "initial_velocity", "--initial-velocity inf"),
    ({"initial_velocity": "fast"}, "initial_velocity", "--initial-velocity fast"),
    ({"memory_tolerance": 0.0}, "memory_tolerance", "--memory-tolerance 0"),
    ({"memory_tolerance": -1e-6}, "memory_tolerance", "--memory-tolerance -1e-6"),
    ({"memory_tolerance": 1.0}, "memory_tolerance", "--memory-tolerance 1"),
    ({"memory_tolerance": 1e-30}, "memory_tolerance", "--memory-tolerance 1e-30"),
    ({"memory_tolerance": math.nan}, "memory_tolerance", "--memory-tolerance nan"),
    ({"record": -1}, "record", None),
    ({"record": 11, "paths": 10}, "record", None),
    ({"record": 0.5}, "record", None),
]

# Bad combinations with the oscillator, and bad usage that only a command can have; each with what must be named.
COMMANDS = [
    ("theory --order 2", "--order"),
    ("theory --order nan", "--order"),
    ("theory --order half", "--order"),
    ("theory --order", "--order"),
    ("theory --order 0.5 --order 0.6", "--order"),
    ("theory --coefficient -1", "--coefficient"),
    ("theory --natural-frequency 0", "--natural-frequency"),
    ("theory --intensity inf", "--intensity"),
    ("theory --position nan", "--position"),
    ("theory --restitution -0.1", "--restitution"),
    ("theory --restitution 1.1", "--restitution"),
    ("theory --free-side left", "--free-side"),
    ("theory --no-barrier --position 1", "--no-barrier"),
    ("theory --no-barrier=maybe", "--no-barrier"),
    ("theory --paths 10", "--paths"),
    ("theory 0.5", "0.5"),
    ("simulate --step 0.5 --natural-frequency 100", "--step"),
    ("simulate --free-side below --initial-position 0.1", "--initial-position"),
    ("simulate --start stationary --order 0", "--start stationary"),
    ("simulate --start stationary --coefficient 0", "--start stationary"),
    ("simulate --start stationary --intensity 0", "--start stationary"),
    ("simulate --window 1 2 3 --duration 10", "--window"),
    ("simulate --paths 5000 --rtol .01", "--paths"),
    ("simulate --rtol .01 --start rest", "--start"),
    ("simulate --rtol 2", "--rtol"),
    ("simulate --rtol .01 --quantities speed", "--quantities"),
    ("simulate --rtol .01 --quantities damping_virial", "--quantities"),
    ("simulate --rtol .01 --no-barrier --quantities impact_rate", "--quantities"),
    ("simulate --quantities x_mean", "--rtol"),
    ("simulate --record 3", "--record"),
    ("simulate --pahts 10", "--pahts"),
    ("simulate --json=perhaps", "--json"),
    ("reproduce fig3", "fig3"),
    ("reproduce fig1 fig2", "fig2"),
    ("reproduce --out", "--out"),
    ("reproduce fig1 --threads many", "--threads"),
    ("doctor --verbose", "--verbose"),
    ("simulat", "simulat"),
    ("--jsno", "--jsno"),
]


def words_of(value: object) -> str:
    return f"{value!r:.30}"


def clear(sentence: str, name: str) -> None:
    assert name in sentence
    assert 20 < len(sentence) < 400
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))  # a suggestion ends as a question


@pytest.mark.parametrize(("name", "value"), OUT_OF_RANGE, ids=words_of)
def test_parts_out_of_range(name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"^{name} must be") as caught:
        PARTS[name](value)
    clear(str(caught.value), name)


@pytest.mark.parametrize(("name", "value"), WRONG_KIND, ids=words_of)
def test_parts_of_the_wrong_kind(name: str, value: Any) -> None:
    with pytest.raises(TypeError, match=f"^{name} must be") as caught:
        PARTS[name](value)
    clear(str(caught.value), name)


@pytest.mark.parametrize(("settings", "name", "_words"), RUNS, ids=words_of)
def test_runs_refuse(settings: dict[str, Any], name: str, _words: str | None) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        simulate(Oscillator(), **settings)
    assert str(caught.value).startswith(name)
    clear(str(caught.value), name)


@pytest.mark.parametrize("oscillator", [None, 1.0, Springpot(0.5, 1.0), {"order": 0.5}], ids=words_of)
def test_runs_refuse_what_is_not_an_oscillator(oscillator: Any) -> None:
    with pytest.raises(TypeError, match=r"^system must be"):
        simulate(oscillator)


@pytest.mark.parametrize(
    "oscillator",
    [
        Oscillator(springpot=Springpot(order=0.0, coefficient=1.0)),
        Oscillator(springpot=Springpot(order=0.5, coefficient=0.0)),
        Oscillator(springpot=Springpot(order=0.0, coefficient=1.0), barrier=None),
    ],
    ids=["order-0", "coefficient-0", "order-0-no-wall"],
)
def test_no_stationary_start_where_nothing_is_lost(oscillator: Oscillator) -> None:
    with pytest.raises(ValueError, match="stationary state") as caught:
        simulate(oscillator, start="stationary")
    clear(str(caught.value), "start")


def test_the_wrong_side_of_the_mirrored_wall() -> None:
    below = Oscillator(barrier=Barrier(position=-1.0, free_side="below"))
    with pytest.raises(ValueError, match=r"^initial_position"):
        simulate(below, initial_position=-0.5)


REFUSED = [
    *COMMANDS,
    *[(f"simulate {words}", f"--{name.replace('_', '-')}") for _, name, words in RUNS if words is not None],
]


def refused(words: list[str], name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("springpot: ")
    assert err.count("\n") == 1
    clear(err.strip(), name)


@pytest.mark.parametrize(("words", "name"), REFUSED)
def test_the_command_refuses(words: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused(words.split(), name, capsys)


@pytest.mark.parametrize(
    ("words", "name"),
    thinned([(words, name) for words, name in REFUSED if words.startswith(("theory", "simulate "))], 5),
)
def test_so_it_does_with_json(words: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    refused([*words.split(), "--json"], name, capsys)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("theory foo", "'foo' is one word too many: springpot theory --help shows what it takes."),
        ("simulate --window 10 20 30", "'30' is one word too many: --window takes two times, START and END."),
        ("simulate --window 50", "--window needs two times, START and END."),
        ("simulate --window a b", "--window must be two times, START and END, not 'a'."),
        ("theory --order abc", "--order must be a number, not 'abc'."),
        ("theory --order", "--order needs a value: springpot theory --help says which."),
        ("theory --order .5 --order .6", "--order must be given only once."),
        ("simulate --paths many", "--paths must be a whole number, not 'many'."),
        ("simulate --scheme euler", "--scheme must be 'default' or 'grunwald', not 'euler'."),
        ("simulate --json=perhaps", "--json is a switch: it takes no value such as 'perhaps'."),
        ("simulate --wibble 3", "there is no flag --wibble: springpot simulate --help lists all flags."),
        ("simulate --pahts 3", "there is no flag --pahts; did you mean --paths?"),
        ("theory --side below", "there is no flag --side; did you mean --free-side?"),
        ("reproduce fig3", "WHAT must be 'fig1', 'fig2', 'errata' or 'all', not 'fig3'."),
        ("simulat", "there is no command 'simulat'; did you mean simulate?"),
        (
            "nonsense",
            "there is no command 'nonsense': "
            "the commands are explain, theory, atlas, compare, simulate, fit, exceedance, sensitivity, design, "
            "scatter, study, doctor, reproduce, validity and explore.",
        ),
    ],
)
def test_bad_usage_says_what_would_be_right(words: str, sentence: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(words.split()) == 2
    assert capsys.readouterr() == ("", f"springpot: {sentence}\n")


@pytest.mark.parametrize(
    "words",
    [
        "simulate --paths 0",
        validation("simulate --step 2 --duration 10 --json"),
        validation("simulate --window 8 2 --duration 10"),
    ],
)
def test_a_real_process_refuses(words: str) -> None:
    command = [sys.executable, "-m", "springpot", *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("springpot: ")
    assert done.stderr.count("\n") == 1


class Contrary:
    """Whatever is asked of it fails in its own way."""

    def __repr__(self) -> str:
        raise RuntimeError

    def __float__(self) -> float:
        raise KeyError

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise ZeroDivisionError

    def __len__(self) -> int:
        return -1


STRANGE: dict[str, Any] = {
    "None": None, "a huge number": 10**400, "a denormal number": 5e-324, "infinity": math.inf, "bytes": b"x",
    "a text": "x\n", "a null character": "\0", "a long text": "x" * 500, "complex": 1j, "a ragged list": [[1, 2], [3]],
    "an empty array": np.zeros(0), "a matrix": np.ones((2, 2)), "an array without a dimension": np.array(3.0),
    "objects": np.array([None, {}], dtype=object), "a series": pandas.Series([1.0, 2.0]), "a type": int,
    "a missing number": pandas.NA, "contrary": Contrary(), "a dict": {"a\n": [1]},
}  # fmt: skip


def given(value: Any) -> Any:
    """What None would leave out."""
    return object() if value is None else value


LINEAR = sp.System(sp.Mass(1.0), sp.Spring(1.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
SOLVED = sp.theory.linear(LINEAR)
SKETCH = Distribution("m", "m-1", np.array([0.0, 1.0, 2.0]), np.array([[3.0, 1.0], [1.0, 3.0]]))
COST = {"subject_to": {"x_mean_square": (None, 5.0)}, "method": "linear", "max_time": 1.0}
DOORS: dict[str, Callable[[Any], object]] = {
    "at": lambda value: sp.Mass(1.0, at=value),
    "on": lambda value: sp.SpectralExcitation.from_psd((1.0, 2.0), 0.1, "g2/Hz", on=value),
    "psd": lambda value: sp.SpectralExcitation((1.0, 2.0), value),
    "psd_unit": lambda value: sp.WhiteNoise.from_psd(1.0, value),
    "of": lambda value: sp.Point("p", value, (1.0,)),
    "coefficients": lambda value: sp.PolynomialSpring(value),
    "time": lambda value: sp.RecordedExcitation(value, (0.0, 1.0)),
    "taken": lambda value: sp.RecordedExcitation((0.0, 1.0), (0.0, 1.0), taken=value),
    "envelope": lambda value: sp.TabulatedEnvelope(value, (0.0, 1.0)),
    "barrier": lambda value: Oscillator.from_numbers(barrier=value),
    "kind": lambda value: sp.beam(1.0, 1.0, 1.0, {"tip": 1.0}, kind=value),
    "points": lambda value: sp.beam(1.0, 1.0, 1.0, value),
    "mass": lambda value: sp.System.from_matrices(value, [[1.0]]),
    "names": lambda value: sp.System.from_matrices(np.eye(2), np.eye(2), names=value),
    "modes": lambda value: sp.System.from_matrices(np.eye(2), np.eye(2), modes=given(value)),
    "damping": lambda value: sp.System.from_matrices(np.eye(2), np.eye(2), given(value), modes=1),
    "residual": lambda value: sp.System.from_matrices(np.eye(2), np.eye(2), modes=1, residual=value),
    "damping_ratios": lambda value: sp.System.from_matrices(np.eye(2), np.eye(2), damping_ratios=value),
    "unit of frequencies": lambda value: sp.System.from_modes([1.0], 1.0, {"a": [1.0]}, unit=value),
    "shapes": lambda value: sp.System.from_modes([1.0, 2.0], 1.0, value),
    "frequency_hz": lambda value: sp.MeasuredModuli(value, [1.0, 2.0], [1.0, 2.0]),
    "response": lambda value: sp.MeasuredFrequencyResponse([1.0, 2.0], value, relative_error=0.1),
    "relative_error": lambda value: sp.MeasuredFrequencyResponse([1.0, 2.0], [1.0, 2.0], relative_error=value),
    "correlation": lambda value: sp.MeasuredStatistics(x_rms=(1.0, 0.1), correlation=value),
    "system": lambda value: sp.read_system(value),
    "path of a run": lambda value: sp.load_run(value),
    "path of a matrix": lambda value: sp.read_matrix(value),
    "path of modes": lambda value: sp.read_modes(value),
    "columns of modes": lambda value: sp.read_modes(__file__, columns=given(value)),
    "path of data": lambda value: sp.read_data(value),
    "path of records": lambda value: sp.RecordedExcitation.from_file(value),
    "store": lambda value: sp.open_study(value),
    "study": lambda value: sp.study({"name": "n", "methods": value, "axes": {"order": [0.5]}}),
    "progress": lambda value: sp.design(LINEAR, lambda c: c, progress=value, **COST),
    "transient": lambda value: sp.theory.transient(LINEAR, value),
    "levels": lambda value: sp.theory.exceedance(LINEAR, {"x": value}),
    "orders": lambda value: SOLVED.spectral_moments(value),
    "spectrum of": lambda value: SOLVED.spectrum(1.0, of=value),
    "frequency": lambda value: SOLVED.spectrum(value),
    "probability": lambda value: SKETCH.quantile(value),
    "value": lambda value: SKETCH.share_above(value),
    "bins": lambda value: SKETCH.density(value),
    "answers": lambda value: sp.recommended(LINEAR, given(value)),
    "duration": lambda value: simulate(LINEAR, paths=1, duration=1e-300 if value is None else value),
    "first_passage": lambda value: simulate(LINEAR, paths=1, duration=1.0, first_passage=given(value)),
    "initial_position": lambda value: simulate(LINEAR, paths=1, duration=1.0, initial_position=given(value)),
    "quantities": lambda value: simulate(LINEAR, rtol=0.3, max_time=0.5, quantities=given(value)),
    "forces": lambda value: simulate(LINEAR, paths=1, duration=1.0, forces=[value]),
    "spectrum": lambda value: simulate(LINEAR, paths=1, duration=1.0, spectrum=given(value)),
    "profile": lambda value: simulate(LINEAR, paths=1, duration=1.0, profile=given(value)),
}  # fmt: skip


@pytest.mark.parametrize("door", DOORS)
def test_strange_things_are_refused_where_they_enter(door: str) -> None:
    """By one sentence of the library; what comes from NumPy, Pandas or Python says nothing of the argument."""
    refused = 0
    for name, value in STRANGE.items():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", sp.SpringpotWarning)
                DOORS[door](value)
        except FileNotFoundError:
            refused += 1
        except (TypeError, ValueError) as error:
            words, frames = str(error), traceback.extract_tb(error.__traceback__)
            assert "springpot" in frames[-1].filename, (name, words)
            assert "site-packages/numpy" not in frames[-1].filename, (name, words)
            assert words.endswith((".", "?")), (name, words)
            assert "\n" not in words, (name, words)
            refused += 1
    assert refused > len(STRANGE) // 2


@pytest.mark.parametrize(
    "make",
    [
        lambda: sp.System.from_matrices(np.broadcast_to(1.0, (2_000_000, 2_000_000)), [[1.0]]),
        lambda: sp.System.from_matrices([[1.0]], np.broadcast_to(1.0, (2_000_000, 2_000_000))),
        lambda: sp.System.from_modes(np.broadcast_to(1.0, 10**12), 1.0, {"tip": [1.0]}),
        lambda: sp.beam(1.0, 1.0, 1.0, {f"p{n}": 0.5 for n in range(1000)}),
        lambda: sp.beam(1.0, 1.0, 1.0, {"tip": 1.0}, modes=10**9),
    ],
)
def test_sizes_are_looked_at_before_anything_is_made(make: Callable[[], object]) -> None:
    with pytest.raises(ValueError, match=r"(fewer|whole number|1 to \d+)"):
        make()
