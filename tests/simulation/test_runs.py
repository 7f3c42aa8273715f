"""What a run promises beside its numbers: oracles, symmetries, the same bits, the paper's values, warnings."""

import itertools
import json
import math
import re
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.memory import direct
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.problem.file import read_system
from springpot.simulation import simulate
from springpot.simulation.kernel.motion import NUMBERS_OF_MODE
from springpot.simulation.kernel.native import normals
from springpot.simulation.kernel.tables import MODE_TABLE
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.struck import missed_impacts
from tests.posix import needs_signals
from tests.reference import walk, walk_as_printed
from tests.signals import in_a_terminal
from tests.sizes import thinned, validation

from .problems import assert_agrees, oscillator, truncated_gaussian, values_of


def drawn(seed: int, path: int, steps: int, word: int) -> np.ndarray:
    """The normals of the kernel, in single precision."""
    return normals(seed, path + 1, steps)[path].astype(float)


@pytest.mark.parametrize(
    ("start", "order", "position", "scheme"),
    thinned(itertools.product((None, 0.5), (0.1, 0.5, 0.9, 1.0), (None, 0.0, 0.4), ("default", "grunwald")), 7),
)
def test_exponential_sum_equals_the_direct_sum(
    scheme: str, position: float | None, order: float, start: float | None
) -> None:
    """Path by path, same normals, 10^4 steps; with a wall up to the first impact that one of them does not see."""
    problem = oscillator(order, 1.0, 1.0, 1.0, position, 0.95)
    step = 0.01 if position is None else 0.05
    derivative = "caputo" if start is None else "riemann-liouville"
    settings = {
        "paths": 3, "duration": 10_000 * step, "step": step, "scheme": scheme, "memory_tolerance": 1e-12,
        "initial_position": start, "derivative": derivative,
    }  # fmt: skip
    found = simulate(problem, record=3, **settings, start="rest").record[2]
    taken = {"seed": 1, "path": 2, "x": start or position or 0.0, "remembered": start or 0.0, "draw": drawn}
    if scheme == "grunwald":
        by_hand = walk_as_printed(problem, step, 10_000, **taken)
    else:
        by_hand = walk(problem, step, 10_000, flight=1.0, **taken)
    far = np.abs(found[:, 0] - by_hand.x[:, 0]) > 1e-9 * np.abs(by_hand.x).max()
    until = int(far.argmax()) if far.any() else far.size
    if position is None:
        assert until == far.size
    else:
        assert sum(each.step < until - 1 for each in by_hand.impacts) >= 100


@pytest.mark.parametrize(("order", "wanted"), [(0.5, 2.12), validation(1.0, 1.0)])
def test_amplitude_at_the_papers_setting(order: float, wanted: float) -> None:
    found = simulate(oscillator(order), paths=8000, duration=100.0, window=(50.0, 100.0), start="rest")
    assert found["amplitude_mean_square"].value == pytest.approx(wanted, rel=0.01)
    assert found["amplitude_mean_square"].error < 0.0035 * wanted


@pytest.mark.parametrize(
    ("order", "restitution", "position", "step", "paths"),
    [(0.5, 1.0, 0.0, 2e-3, 500), validation(1.0, 0.8, 0.2, 2.5e-4, 1500)],
)
def test_the_two_schemes_agree_on_the_same_normals(
    order: float, restitution: float, position: float, step: float, paths: int
) -> None:
    """What the paths have in common drops out of the difference, so few of them show a per cent.

    Behind a lossy wall that the spring presses on, the paper's scheme misses 1.3 % of the impacts at a step of 2e-3.
    """
    found = [
        values_of(simulate(
            oscillator(order, 1.0, 1.0, 1.0, position, restitution),
            paths=paths, duration=60.0, step=step, window=(20.0, 60.0), scheme=scheme, seed=3, start="rest",
        ))
        for scheme in ("default", "grunwald")
    ]  # fmt: skip
    names = ["amplitude_mean_square", "x_mean_square", "v_mean_square", "x_mean", "damping_power"]
    for name in [*names, "impact_speed_mean", "impact_speed_mean_square", "impact_rate"]:
        assert found[1][name] == pytest.approx(found[0][name], rel=0.01), name


@pytest.mark.validation
@pytest.mark.parametrize(("order", "restitution", "position"), [(0.5, 1.0, 0.0), (1.0, 0.8, 0.2)])
def test_the_two_schemes_agree_at_the_papers_step(order: float, restitution: float, position: float) -> None:
    problem = oscillator(order, 1.0, 1.0, 1.0, position, restitution)
    runs = [
        simulate(
            problem,
            paths=21_000,
            duration=100.0,
            step=step,
            window=(50.0, 100.0),
            scheme=scheme,
            seed=seed,
            start="rest",
        )
        for scheme, seed, step in (("default", 3, 5e-3), ("grunwald", 4, 1e-3))
    ]
    names = ["amplitude_mean_square", "x_mean_square", "v_mean_square", "x_mean", "damping_power"]
    if restitution == 1.0:
        names += ["impact_speed_mean", "impact_speed_mean_square", "impact_rate"]
    for name in names:
        values, errors = ([getattr(r[name], what) for r in runs] for what in ("value", "error"))
        assert max(errors) < (0.0032 if name == "amplitude_mean_square" else 0.005) * values[0], name
        assert abs(values[0] - values[1]) < 3 * math.hypot(*errors), name
    # a lossy wall makes many slow impacts, of which the paper's scheme sees more (1 % off in rate and mean speed
    # at this step); momentum and energy exchanged with the wall per second are hardly theirs
    for power in ("impact_speed_mean", "impact_speed_mean_square"):
        exchanged = [r["impact_rate"].value * r[power].value for r in runs]
        errors = [e * r[power].error / r[power].value for e, r in zip(exchanged, runs, strict=True)]
        assert abs(exchanged[0] - exchanged[1]) < 3 * math.hypot(*errors), power


@pytest.mark.parametrize("paths", [2500, validation(10_000)])
def test_omega_three(paths: int) -> None:
    """Where the printed formula gives 3.519 and the corrected one 1.173."""
    found = simulate(oscillator(0.7, 0.2, 3.0), paths=paths, start="rest")
    assert found["amplitude_mean_square"].value == pytest.approx(1.173, rel=0.02)
    assert not found.warnings


@pytest.mark.parametrize("paths", [3000, validation(12_000)])
def test_adapted_start_reaches_the_stationary_state_that_rest_has_not_forgotten(paths: int) -> None:
    runs = {
        start: simulate(oscillator(0.3), paths=paths, duration=200.0, window=(100.0, 200.0), start=start)
        for start in ("rest", "stationary")
    }
    assert runs["stationary"]["impact_rate"].value == pytest.approx(0.300, rel=0.01)
    assert runs["stationary"]["x_mean"].value == pytest.approx(1.044, rel=0.01)
    assert runs["rest"]["impact_rate"].value == pytest.approx(0.335, rel=0.01)
    assert runs["rest"]["x_mean"].value == pytest.approx(1.007, rel=0.01)
    assert runs["stationary"].diagnostics["start_residual"] < 0.01
    assert runs["rest"].diagnostics["start_residual"] is None
    start = runs["stationary"].settings.initial_position
    assert start == pytest.approx(runs["stationary"]["x_mean"].value, rel=0.01)


@pytest.mark.parametrize(
    ("order", "coefficient", "position", "restitution"),
    [
        validation(0.1, 1.0, 0.0, 1.0),
        validation(0.5, 3.0, 0.0, 0.5),
        (0.4, 0.6, 0.5, 0.8),
        (0.35, 0.8, -0.4, 0.85),
        validation(0.2, 0.01, 0.0, 1.0),
    ],
)
def test_adapted_starts_leave_less_than_a_per_cent(
    order: float, coefficient: float, position: float, restitution: float
) -> None:
    found = simulate(oscillator(order, coefficient, 1.0, 1.0, position, restitution), paths=64, start="stationary")
    assert found.diagnostics["start_residual"] < 0.01


def test_an_adapted_start_that_would_take_too_long_to_find_is_averaging_s_and_says_so() -> None:
    found = simulate(oscillator(0.5, 1e-4), paths=64, duration=200.0, step=0.1, start="stationary")
    assert found.diagnostics["start_residual"] is None
    assert any("adapted start was taken from a rough theory" in w for w in found.warnings)
    assert found.settings.initial_position == pytest.approx(85.5, rel=0.01)


def test_a_lossy_wall_out_of_reach_does_not_shorten_the_default_run() -> None:
    found = simulate(oscillator(1.0, 0.01, position=-1000.0, restitution=0.5), paths=700, start="rest")
    assert abs(found["amplitude_mean_square"].value - 100.0) < 4 * found["amplitude_mean_square"].error
    assert found.settings.duration >= 1000.0


def test_a_strong_springpots_creep_is_warned_about() -> None:
    found = simulate(oscillator(0.5, 1000.0, position=None), paths=64, duration=5.0, start="rest")
    assert any("of the transient is left" in w for w in found.warnings)


def test_a_motion_that_still_grows_is_warned_about() -> None:
    """A springpot whose slow part averaging does not know: x(0) far out, long forgotten by its energy estimate."""
    found = simulate(
        oscillator(1.0, 0.01, position=-3.0, restitution=0.5),
        paths=3000,
        duration=60.0,
        window=(2.0, 60.0),
        start="rest",
    )
    assert any("transient" in w or "not stationary" in w for w in found.warnings)


def test_memory_tables_in_single_precision_keep_their_rates() -> None:
    """What the kernel multiplies with, after rounding: the weights of the past over a million steps."""
    problem = oscillator()
    plan = plan_of(problem, duration=10_000.0, step=0.01, start="rest")
    assert plan.settings.precision == "float32"
    tables = simulation_of(plan).parts.tables
    begin = tables.integers[tables.integers[MODE_TABLE]]
    modes = tables.sweep[begin : begin + NUMBERS_OF_MODE * tables.count("modes")].reshape(-1, NUMBERS_OF_MODE)
    powers, weights = np.split(modes.astype(np.float64), 2, axis=1)
    assert modes.dtype == np.float32
    groups = np.unique(np.geomspace(1, 240_000, 300).astype(int))
    kept = (weights[:, 0] * (1.0 + powers[:, 3]) ** groups[:, None]).sum(axis=1)
    wanted = direct("average", 0.5, 1_000_000)[4 * groups + 1] * 0.01**-0.5
    assert np.abs(kept / wanted - 1.0).max() < 3e-6


@pytest.mark.parametrize("scale", [1e-40, 1e-9, 1e12, 1e24])
def test_any_unit_of_length_gives_the_same_motion(scale: float) -> None:
    one = simulate(oscillator(position=0.3), paths=64, duration=20.0, step=0.02, start="rest")
    other = simulate(
        oscillator(intensity=scale**2, position=0.3 * scale), paths=64, duration=20.0, step=0.02, start="rest"
    )
    assert other["x_mean"].value / scale == pytest.approx(one["x_mean"].value, rel=1e-4)
    assert other["impact_rate"].value == pytest.approx(one["impact_rate"].value, rel=1e-2)
    assert not any("balance" in w for w in other.warnings)


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_any_unit_of_time_gives_the_same_motion(scale: float) -> None:
    one = simulate(oscillator(), paths=64, duration=20.0, step=0.02, start="rest")
    other = simulate(
        oscillator(0.5, scale**1.5, scale, scale**3), paths=64, duration=20.0 / scale, step=0.02 / scale, start="rest"
    )
    assert other["x_mean"].value == pytest.approx(one["x_mean"].value, rel=1e-3)
    assert other["v_mean_square"].value / scale**2 == pytest.approx(one["v_mean_square"].value, rel=1e-3)


@pytest.mark.parametrize("velocity", [1e20, 1e50])
def test_a_huge_start_ends(velocity: float) -> None:
    found = simulate(oscillator(), paths=2, duration=5.0, initial_velocity=velocity)
    assert math.isfinite(found["x_mean_square"].value)


def test_a_contact_tolerance_too_wide_for_the_motion_is_warned_about() -> None:
    found = simulate(oscillator(intensity=1e-8), paths=64, duration=50.0, step=0.005, scheme="grunwald", start="rest")
    assert any(w.startswith("contact_tolerance") for w in found.warnings)


@pytest.mark.validation
def test_standard_errors_of_adapted_runs_hold_over_seeds() -> None:
    """All paths of a run share x(0), whose own sampling error the spread between paths cannot show."""
    settings = {"paths": 20_000, "duration": 150.0, "step": 0.05, "start": "stationary"}
    runs = [simulate(oscillator(0.1), seed=seed, **settings) for seed in range(16)]
    for name in ("impact_rate", "damping_force_mean", "x_mean", "x_mean_square", "v_mean_square"):
        scatter = np.std([r[name].value for r in runs], ddof=1)
        stated = np.mean([r[name].error for r in runs])
        assert scatter / stated < 1.7, name  # four standard errors of a spread from 16 samples


def test_four_times_the_intensity_doubles_the_path_bit_for_bit() -> None:
    settings = {"paths": 100, "duration": 60.0, "step": 0.02, "record": 100}
    one = simulate(oscillator(), **settings, start="rest")
    assert np.array_equal(simulate(oscillator(intensity=4.0), **settings, start="rest").record, 2.0 * one.record)
    for intensity in (5.0, 10.0):
        scaled = simulate(oscillator(intensity=intensity), **settings, start="rest").record / math.sqrt(intensity)
        # to rounding: of single-precision memory
        assert np.abs(scaled - one.record).max() < 1e-5 * np.abs(one.record).max()


ODD = {"x_mean", "damping_force_mean", "x_mean_end"}
TIMES = np.linspace(0.0, 30.0, 200)
SHAKES = 3.0 * np.sin(np.multiply.outer((1.0, 1.4), TIMES**1.4))  # two records


@pytest.mark.parametrize(("scheme", "shaken"), [("default", False), ("grunwald", False), ("default", True)])
def test_without_noise_a_wall_above_is_the_mirror_image_bit_for_bit(scheme: str, shaken: bool) -> None:
    """Of a motion that dies down, or under records; noise itself is not mirrored."""
    settings = {"paths": 2, "duration": 30.0, "record": 2, "scheme": scheme, "step": 0.01, "window": (0.0, 30.0)}
    runs = []
    for sign, side in ((1.0, "above"), (-1.0, "below")):
        wall = sp.Barrier(-0.3 * sign, 0.8, free_side=side)
        system = sp.Oscillator(1.0, sp.Springpot(0.5, 0.05), wall, sp.WhiteNoise(0.0))
        if shaken:
            records = sp.RecordedExcitation([tuple(TIMES)] * 2, (sign * SHAKES).tolist(), on="mass")
            system = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.05), records, barrier=wall)
        runs.append(simulate(system, **settings, start="rest", initial_velocity=-2.0 * sign))
    above, below = runs
    assert above["impact_rate"].value * 30.0 > (8 if shaken else 4)
    assert np.array_equal(below.record, -above.record)
    assert below.record[:, :, 0].max() <= 0.3 + (0.05 if scheme == "grunwald" else 0.0)
    assert {*above.estimates} == {*possible_results(above.system)}
    for name in above.estimates:
        assert below[name].value == (-above[name].value if name in ODD else above[name].value), name
        assert below[name].error == above[name].error, name


@pytest.mark.parametrize("scheme", ["default", validation("grunwald")])
def test_a_wall_above_has_the_mirrored_law(scheme: str) -> None:
    settings = {"paths": 32_000, "duration": 24.0, "window": (8.0, 24.0), "scheme": scheme, "step": 0.02, "seed": 3}
    above = simulate(oscillator(position=-0.3, restitution=0.8), **settings, start="rest")
    below = simulate(oscillator(position=0.3, restitution=0.8, free_side="below"), **settings, start="rest")
    for name in above.estimates:
        if name in ODD | {"x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean", "damping_power"}:
            one, other = above[name], below[name]
            apart = math.hypot(one.error, other.error)
            assert apart < (0.005 if name not in ODD else 0.02) * abs(one.value), name
            assert abs(other.value - (-one.value if name in ODD else one.value)) < 4.0 * apart, name


def test_the_same_bits_for_any_number_of_threads_and_paths() -> None:
    settings = {"duration": 20.0, "step": 0.02, "record": 65}
    one = simulate(oscillator(), paths=300, threads=1, **settings, start="rest")
    for threads in (2, 3):
        other = simulate(oscillator(), paths=300, threads=threads, **settings, start="rest")
        assert other.estimates == one.estimates
        assert np.array_equal(other.record, one.record)
    assert np.array_equal(simulate(oscillator(), paths=65, **settings, start="rest").record, one.record)
    assert simulate(oscillator(), paths=300, seed=2, **settings, start="rest").estimates != one.estimates


def test_noise_off_gives_the_deterministic_response() -> None:
    settings = {"initial_position": 1.0, "initial_velocity": -0.5, "record": 3}
    found = simulate(oscillator(intensity=0.0), paths=3, duration=10.0, **settings, start="rest", memory_tolerance=1e-9)
    assert (found.record == found.record[0]).all()
    assert found.record[0, 0].tolist() == [1.0, -0.5]
    assert found["x_mean"].error == pytest.approx(0.0, abs=1e-15)
    assert abs(found["energy_residual"].value) < 1e-3


def test_single_precision_memory_is_good_enough() -> None:
    settings = {"paths": 500, "duration": 50.0, "step": 0.005}
    single, double = (simulate(oscillator(), memory_tolerance=t, **settings, start="rest") for t in (1e-6, 1e-9))
    assert (single.settings.precision, double.settings.precision) == ("float32", "float64")
    for name in ("x_mean_square", "v_mean_square", "impact_rate"):
        assert single[name].value == pytest.approx(double[name].value, rel=1e-3)


def test_standard_errors_cover_at_their_level() -> None:
    """Order 1 at a coarse step is exact in law, so z = (value - exact) / se is standard normal over seeds."""
    exact = truncated_gaussian(0.0, 1.0, 1.0, 1.0)
    z = []
    for seed in range(60):
        found = simulate(
            oscillator(1.0), paths=400, duration=40.0, step=0.2, window=(15.0, 40.0), seed=seed, start="rest"
        )
        z.append([(found[name].value - wanted) / found[name].error for name, wanted in exact.items()])
    spread = np.std(z, axis=0, ddof=1)
    assert ((spread > 0.7) & (spread < 1.3)).all()  # four standard errors of a spread from 60 samples
    assert (np.abs(np.mean(z, axis=0)) < 4 / math.sqrt(60)).all()


def test_nothing_is_read_before_it_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """New memory holds what others left there: here numbers that raise as soon as one computes with them."""
    settings: dict[str, Any] = {
        "paths": 70, "record": 70, "duration": 20.0, "step": 0.01, "start": "rest", "initial_position": 0.5,
        "distributions": True, "spectrum": [8.0, 12.0],
    }  # fmt: skip
    problem = oscillator(0.9, 0.3)
    before = simulate(problem, **settings)

    def unwritten(*shape: Any, _empty: Any = np.empty, **kind: Any) -> Any:
        made = _empty(*shape, **kind)
        if made.dtype == np.float64:
            made.view(np.uint64)[...] = 0x7FF0000000000001  # a signalling NaN
        return made

    monkeypatch.setattr(np, "empty", unwritten)
    found = simulate(problem, **settings)
    assert np.array_equal(found.record, before.record)
    assert found.estimates == before.estimates


def test_window_averages_are_the_averages_of_the_record() -> None:
    found = simulate(
        oscillator(), paths=5, duration=3.0, step=0.013, window=(0.7, 2.4), record=5, start="rest",
        memory_tolerance=1e-8,
    )  # fmt: skip
    low, high = found.settings.window_steps
    x = found.record[:, low + 1 : high + 1, 0].mean(axis=1)
    square = (found.record[:, low + 1 : high + 1] ** 2).mean(axis=1)
    assert found["x_mean"].value == pytest.approx(x.mean(), rel=1e-12)
    assert found["x_mean"].error == pytest.approx(x.std(ddof=1) / math.sqrt(5), rel=1e-9)
    assert found["v_mean_square"].value == pytest.approx(square[:, 1].mean(), rel=1e-12)
    assert found["x_mean_end"].value == pytest.approx(found.record[:, -1, 0].mean(), rel=1e-12)
    assert found.settings.steps == 231
    assert found.settings.steps * found.settings.step == pytest.approx(3.0, rel=1e-14)


def test_dataset_has_names_units_errors_and_paths() -> None:
    with pytest.warns(UserWarning, match="of the transient is left"):
        data = sp.simulate(oscillator(), paths=10, duration=1.0, step=0.01, record=2, start="rest").to_xarray()
    system = read_system(json.loads(data.attrs["system"]))
    of_walls = {name for name in possible_results(system) if name.startswith("barrier_")}
    assert {"barrier_impact_rate", "barrier_power"} < of_walls
    assert data["barrier"].values.tolist() == ["barrier"]
    for name in possible_results(system):
        assert data[name].attrs["units"] == data[f"{name}_se"].attrs["units"] == unit_of_result(system, name) != ""
        assert data[name].dims == (("barrier",) if name in of_walls else ())
    assert data["x"].dims == ("path", "time")
    assert data["x"].shape == (2, 101)
    assert json.loads(data.attrs["settings"])["seed"] == 1
    assert [*system.of(sp.Springpot)] == [sp.Springpot(order=0.5, coefficient=1.0)]
    assert json.loads(data.attrs["diagnostics"])["versions"]["springpot"] == sp.__version__


def test_a_coarse_step_and_an_early_window_are_warned_about() -> None:
    coarse = simulate(oscillator(), paths=64, duration=40.0, step=0.2, start="rest")
    assert any(w.startswith("step is 0.2 s") for w in coarse.warnings)
    assert any(
        "of the transient is left" in w
        for w in simulate(oscillator(0.1), paths=64, duration=10.0, start="rest").warnings
    )
    growing = simulate(oscillator(0.0), paths=64, duration=10.0, start="rest")
    assert any("no stationary state" in w for w in growing.warnings)
    assert not simulate(oscillator(0.9), paths=64, start="rest").warnings


@needs_signals
@pytest.mark.validation  # every day: that of the command, in tests/cli/test_cli.py
def test_an_interrupt_stops_a_long_run_at_once() -> None:
    code = (
        "import os; import springpot as sp; from springpot.simulation import simulate; "
        "begun = lambda done: os.write(1, b'go\\n'); "
        "simulate(sp.Oscillator(), paths=10**6, duration=1e4, start='rest', progress=begun)"
    )
    with in_a_terminal():
        process = subprocess.Popen(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "go\n"  # it is in the middle of its work
        process.send_signal(signal.SIGINT)
        begun = time.perf_counter()
        try:
            _, said = process.communicate(timeout=30)
        finally:
            process.kill()  # a run that goes on would take the machine for hours
    assert time.perf_counter() - begun < 3.0
    assert "KeyboardInterrupt" in said


def test_progress_reaches_one() -> None:
    seen: list[float] = []
    simulate(oscillator(), paths=300, duration=5.0, progress=seen.append, start="rest")
    assert max(seen) == 1.0
    assert len(seen) == 5


def test_statistics_refuse_nothing_and_hide_nothing_with_one_path() -> None:
    found = simulate(oscillator(), paths=1, duration=20.0, start="rest")
    assert math.isnan(found["x_mean"].error)
    assert found.to_dict()["x_mean_se"] is None
    json.dumps(found.to_dict(), allow_nan=False)


@pytest.mark.validation  # every day: the scheme path by path, in test_reference.py
def test_grunwald_also_obeys_the_exact_law_at_its_fine_step() -> None:
    found = simulate(oscillator(1.0), paths=5000, duration=60.0, scheme="grunwald", start="rest")
    assert_agrees(found, {"amplitude_mean_square": 1.0, "impact_rate": 1 / math.pi, "x_mean": math.pi**-0.5})


def test_a_lossy_wall_warns_of_slow_impacts_where_they_count() -> None:
    def warned(restitution: float, step: float) -> list[str]:
        found = simulate(
            oscillator(0.5, restitution=restitution), paths=64, duration=8.0, window=(6.0, 8.0), step=step, start="rest"
        )
        return [sentence for sentence in found.warnings if "slow impacts" in sentence]

    assert re.search(r"about [123](\.\d)? % too low", warned(0.5, 0.01)[0])
    assert "step^0.5" in warned(0.5, 0.01)[0]
    assert not warned(0.5, 0.001)
    assert not warned(0.8, 0.01)
    assert not warned(1.0, 0.1)


@pytest.mark.parametrize(
    ("restitution", "c"), [validation(0.25, 1.0), validation(0.3, 0.1), validation(0.4, 2.0), (0.5, 1.0)]
)
def test_the_impacts_that_a_step_misses_are_told(restitution: float, c: float) -> None:
    """Against the Fokker-Planck equation, that has no step."""
    problem = oscillator(1.0, c, restitution=restitution)
    wanted = sp.theory.fokker_planck(problem)
    found = simulate(problem, paths=5000, step=0.05 / max(1.0, c), start="stationary")
    told = missed_impacts(plan_of(problem).motion.struck, found.settings.step, found["impact_speed_mean_square"].value)
    missed = 1.0 - found["impact_rate"].value / wanted.impact_rate
    error = found["impact_rate"].error / wanted.impact_rate
    assert abs(missed - told) < 0.15 * missed + 3.0 * error
    assert error < 0.1 * missed


def test_a_start_that_is_remembered_is_told() -> None:
    def told(problem: Any, **given: Any) -> list[str]:
        return [each for each in simulate(problem, **given).warnings if "the memory still acts of the start" in each]

    small = oscillator(0.2, 1.0)
    assert "32 %" in told(small, paths=1500, start="rest")[0]
    assert not told(small, paths=1500)
    assert not told(oscillator(0.8, 1.0), paths=1500, start="rest")
    assert not told(oscillator(0.2, 1.0, position=None), paths=1500, start="rest")


def test_what_a_springpot_remembers_moves_every_mass_alike() -> None:
    """The same accelerations, at once and later, whatever the kernel's unit of mass is."""
    ends = [
        simulate(
            sp.System(sp.Mass(mass), sp.Spring(mass), sp.Springpot(0.5, 0.5 * mass)), derivative="riemann-liouville",
            initial_position=1.0, paths=1, duration=1.0, step=0.1, record=1, start="rest",
        ).record[0, :, 0]
        for mass in (1.0, 1.3, 2.6)
    ]  # fmt: skip
    np.testing.assert_allclose(ends, [ends[0]] * 3, rtol=1e-8)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_the_papers_scheme_sums_each_velocity_once_where_nothing_is_random() -> None:
    free = sp.Oscillator(1.0, sp.Springpot(0.5, 0.3), sp.Barrier(-0.4, 0.7), sp.WhiteNoise(0.0))
    run = simulate(free, scheme="grunwald", initial_position=1.0, record=1, paths=1, duration=20.0, window=(0.0, 20.0),
                   step=0.01)  # fmt: skip
    assert run["v_mean_square"].value == pytest.approx((run.record[0, 1:, 1] ** 2).mean(), rel=1e-12)
