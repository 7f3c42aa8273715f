"""Runs with several records: which path has which, one path where all are alike, and records in studies."""

from __future__ import annotations

import tracemalloc
from itertools import pairwise

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.simulation.lowering.compose import compose
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.result.warnings import _about_records
from tests.simulation.systems import of_many_kinds
from tests.simulation.test_modulated import of_pair

TIME = tuple(np.linspace(0.0, 6.0, 121).tolist())
VALUES = tuple(tuple((size * np.sin(2.1 * size * np.array(TIME))).tolist()) for size in (0.5, 1.0, 1.6))


def shaken(*values: tuple[float, ...], **more: object) -> sp.System:
    return of_pair(sp.RecordedExcitation(TIME, values if len(values) > 1 else values[0], **more))


def test_one_path_is_enough_for_each_record() -> None:
    alone = [sp.simulate(shaken(own), step=0.02) for own in VALUES]
    assert [run.settings.paths for run in alone] == [1, 1, 1]
    assert [run["a_x_mean_square"].error for run in alone] == [0.0] * 3
    assert not any(run.warnings for run in alone)
    together = sp.simulate(shaken(*VALUES), step=0.02, profile=6)
    assert together.settings.paths == 3
    for name in ("a_x_mean_square", "b_v_mean_square", "a_x_mean_end"):
        each = np.array([run[name].value for run in alone])
        assert together[name].value == pytest.approx(each.mean(), rel=1e-12)
        assert together[name].error == pytest.approx(each.std(ddof=1) / np.sqrt(3.0), rel=1e-9)
    many = sp.simulate(shaken(*VALUES), step=0.02, paths=300)
    assert many.settings.paths == 3
    assert many["a_x_mean_square"].value == pytest.approx(together["a_x_mean_square"].value, rel=1e-12)
    assert [str(each) for each in many.warnings] == [
        "paths has no effect beyond 3: without noise there is one path for each record."
    ]


def test_records_are_drawn_by_the_seed_whatever_the_threads_are() -> None:
    alone = np.array([sp.simulate(shaken(own), step=0.02)["a_x_mean_square"].value for own in VALUES])
    system = shaken(*VALUES, taken="at random")
    one, two = (sp.simulate(system, step=0.02, paths=3000, threads=threads, seed=4) for threads in (1, 2))
    assert (one.path_sums == two.path_sums).all()
    found = one.path_sums[:, 2] / one.path_sums[:, 2].max()
    shares = np.unique(found.round(6), return_counts=True)[1] / 3000.0
    assert shares == pytest.approx(1.0 / 3.0, abs=4.0 * np.sqrt(2.0 / 9.0 / 3000.0))
    assert abs(one["a_x_mean_square"].value - alone.mean()) < 4.0 * one["a_x_mean_square"].error
    other = sp.simulate(system, step=0.02, paths=3000, seed=5)
    assert (other.path_sums != one.path_sums).any()


def test_noise_beside_records_needs_its_paths() -> None:
    system = sp.System(*shaken(*VALUES).parts, sp.WhiteNoise(1e-6, on="a"))
    run = sp.simulate(system, step=0.02, paths=384, record=6)
    assert run.warnings == ()
    x = run.record[:, :, 0, 0]
    assert np.abs(x[0] - x[3]).max() < 0.02 * np.abs(x[0] - x[1]).max()


def test_errors_leave_out_how_records_in_turn_differ() -> None:
    """With noise: three runs of a record each have the errors; of drawn records the spread between them is one too."""
    noise = sp.WhiteNoise(0.02, on="a")
    alone = [
        sp.simulate(sp.System(*shaken(own).parts, noise), paths=4000, step=0.05, seed=seed)
        for seed, own in enumerate(VALUES, start=2)
    ]
    turns, drawn = (
        sp.simulate(sp.System(*shaken(*VALUES, taken=taken).parts, noise), paths=12_001, step=0.05)
        for taken in ("in turn", "at random")
    )
    for name in ("a_x_mean_square", "a_v_mean_square"):
        values, errors = (np.array([getattr(run[name], what) for run in alone]) for what in ("value", "error"))
        within = np.sqrt((errors**2).sum()) / 3.0
        assert turns[name].error == pytest.approx(within, rel=0.03)
        assert abs(turns[name].value - values.mean()) < 4.0 * np.hypot(turns[name].error, within)
        whole = np.sqrt(within**2 + values.var() / 12_001)
        assert whole > 1.2 * within
        assert drawn[name].error == pytest.approx(whole, rel=0.03)
        assert abs(drawn[name].value - values.mean()) < 4.0 * np.hypot(drawn[name].error, within)


@pytest.mark.validation
def test_one_mass_takes_the_same_records() -> None:
    """In the kernel of one mass, in single precision with noise and in double precision without."""
    record = sp.RecordedExcitation(TIME, VALUES)
    one = sp.System(sp.Spring(4.0), sp.Dashpot(0.3), record)
    several, own = sp.simulate(shaken(*VALUES), step=0.01, record=3), sp.simulate(one, step=0.01, record=3)
    assert own.settings.paths == 3
    assert np.abs(own.record[:, :, 0] - several.record[:, :, 0, 0]).max() < 1e-3 * np.abs(own.record).max()
    noisy = sp.simulate(sp.System(*one.parts, sp.WhiteNoise(1e-9)), step=0.01, paths=256, record=200)
    for n in (0, 1, 2, 127, 128, 199):
        assert np.abs(noisy.record[n] - own.record[n % 3]).max() < 1e-3


def test_a_record_in_bins_from_the_command(tmp_path, capsys) -> None:
    (tmp_path / "device.toml").write_text(sp.to_toml(shaken(*VALUES)), encoding="utf-8")
    for bins in (["3"], ["0", "2", "4", "6"]):
        assert cli.main(["simulate", str(tmp_path / "device.toml"), "--step", "0.02", "--profile", *bins]) == 0
        out = capsys.readouterr().out
        assert "0 to 2 s" in out
        assert "input_power" in out
        assert "impact" not in out


def test_a_record_and_an_envelope_in_a_study(tmp_path) -> None:
    (tmp_path / "ground.csv").write_text(
        "\n".join(["time_s,acceleration_m/s2", *(f"{t},{a}" for t, a in zip(TIME, VALUES[1], strict=True))]),
        encoding="utf-8",
    )
    (tmp_path / "device.toml").write_text(
        sp.to_toml(of_pair()) + '[[parts]]\nkind = "recorded_excitation"\npath = "ground.csv"\n'
        '[[parts]]\nkind = "white_noise"\non = "b"\nintensity = 1.0\nenvelope = { form = "jennings_housner", '
        "rise = 1.0, fall = 3.0, decay = 1.0 }\n",
        encoding="utf-8",
    )
    (tmp_path / "study.toml").write_text(
        'name = "scales"\nsystem = "device.toml"\nmethods = ["monte_carlo"]\n[zipped.size]\n'
        '"parts.recorded_excitation.scale" = [1.0, 2.0]\n"parts.white_noise.envelope.fall" = [2.0, 3.0]\n'
        "[monte_carlo]\npaths = 64\nstep = 0.05\nduration = 6.0\n",
        encoding="utf-8",
    )
    found = sp.study(tmp_path / "study.toml")["simulation"].to_dataset()
    a, b = (found[f"{point}_x_mean_square"].values for point in "ab")
    assert a[1] == pytest.approx(4.0 * a[0], rel=1e-5)
    assert b[1] > 1.1 * b[0]


LONG = sp.RecordedExcitation((0.0, 1000.0, 2000.0), (0.0, 1.0, 0.0))
FADING = sp.ExponentialEnvelope(slow=0.2, fast=0.6)


@pytest.mark.parametrize(
    ("system", "duration"),
    [
        pytest.param(sp.System(sp.Spring(1e8), sp.Dashpot(1.0), LONG), 0.05, id="a record that is longer than the run"),
        pytest.param(of_pair(LONG), 0.05, id="of two masses"),
        pytest.param(sp.System(sp.Spring(1e-20), sp.Dashpot(1e-12), sp.WhiteNoise(1.0)), 1.0, id="a slow motion"),
    ],
)
def test_a_short_run_takes_little_memory(system: sp.System, duration: float) -> None:
    """Impulses of a record cover the run, not the record; what a step leaves out is summed over few steps."""
    tracemalloc.start()
    try:
        compose(plan_of(system, start="rest", duration=duration))
        assert tracemalloc.get_traced_memory()[1] < 3e7
    finally:
        tracemalloc.stop()


def test_a_run_beyond_its_record_sees_all_of_it() -> None:
    """And one that ends within it what a longer one sees until then."""
    runs = [sp.simulate(shaken(*VALUES), duration=duration, step=0.02, record=3) for duration in (1.3, 6.0, 9.0)]
    for shorter, longer in pairwise(runs):
        seen = shorter.record.shape[1]
        assert (shorter.record == longer.record[:, :seen]).all()
    assert np.abs(runs[2].record[:, -50:]).max() > 0.0


@pytest.mark.parametrize(
    "shaking",
    [
        sp.WhiteNoise(1.0, envelope=FADING),
        sp.ColoredNoise(1.0, 1.0, envelope=FADING),
        sp.KanaiTajimiNoise(2.0, 0.5, 1.0, envelope=FADING, frequency_rate=1e-4),
        sp.RecordedExcitation((0.0, 50.0, 100.0), [(0.0, 1.0, 0.0)] * 4),
    ],
)
def test_a_table_over_the_steps_that_does_not_fit_is_refused_before_it_is_made(shaking: object) -> None:
    plan = plan_of(sp.System(sp.Spring(1.0), sp.Dashpot(0.1), shaking), duration=100.0, step=2e-6)
    tracemalloc.start()
    try:
        with pytest.raises(
            ValueError, match=r"^duration takes 50,000,00\d steps, and \w+ needs a table of \d+ numbers"
        ):
            compose(plan)
        assert tracemalloc.get_traced_memory()[1] < 3e7
    finally:
        tracemalloc.stop()


def coarse() -> tuple[np.ndarray, float]:
    """A record of 61 cosines from 40 to 100 Hz, of 1 s and again, at 610 Hz, and the rms of x by its lines."""
    rng, rate, natural = np.random.default_rng(8), 610, 2.0 * np.pi * 70.0
    lines = np.zeros(306, complex)
    lines[40:101] = np.exp(2j * np.pi * rng.random(61))
    w = 2.0 * np.pi * np.arange(306)
    response = lines / (natural**2 - w**2 + 0.1j * natural * w)
    return np.tile(np.fft.irfft(rate * lines, rate), 2), float(np.sqrt(2.0 * (np.abs(response) ** 2).sum()))


def test_a_coarse_record_loses_nothing_between_its_points(tmp_path) -> None:
    """At 8.7 points in a period straight lines lose 1 - sinc^2 = 4.3 % at the resonance, which a warning says."""
    values, right = coarse()
    natural = 2.0 * np.pi * 70.0
    place = tmp_path / "ground.csv"
    rows = (f"{n / 610.0:.9g},{a:.7g}" for n, a in enumerate(values.tolist()))
    place.write_text("\n".join(["time_s,acceleration_m/s2", *rows]), encoding="utf-8")
    found = {}
    for interpolation in (None, "linear"):
        record = sp.RecordedExcitation.from_file(place, interpolation=interpolation)
        held = of_many_kinds(sp.Mass(2.0), sp.Spring(2.0 * natural**2), sp.Dashpot(0.2 * natural), record)
        run = sp.simulate(held, paths=1, record=1, step=1.0 / 7320.0)
        t, x = run.time, run.record[0, :, 0]
        own = np.interp(0.98 + np.arange(7320) / 7320.0, t, x)
        found[record.interpolation] = np.sqrt((own**2).mean()) / right
        names = [message.name for message in run.warnings]
        assert ("coarse_record" in names) == (interpolation == "linear")
    assert found["band-limited"] == pytest.approx(1.0, abs=1e-3)
    assert found["linear"] == pytest.approx(0.959, abs=3e-3)
    (message,) = (message for message in run.warnings if message.name == "coarse_record")
    assert "8.71 points in a period of the motion, at 70 Hz: straight lines" in message
    assert "lose 4.3 %" in message


def test_a_record_below_the_motion_says_that_nothing_is_in_it() -> None:
    fast = sp.System(
        sp.Spring((2.0 * np.pi * 40.0) ** 2), sp.Dashpot(5.0), *shaken(VALUES[1]).of(sp.RecordedExcitation)
    )
    found = next(doubt for doubt in _about_records(motion_of(fast)))
    assert "0.5 points in a period of the motion, at 40 Hz: what a signal has at half of its sampling rate" in found
    assert not [*_about_records(motion_of(shaken(VALUES[1])))]
