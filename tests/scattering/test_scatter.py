"""`sp.scatter`: devices through the kernel, against exact results and single runs."""

from __future__ import annotations

import json
import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot import cli
from springpot.machine.faults import NotCoveredError
from springpot.memory.common_rates import common_rates
from springpot.memory.exponential_sum import exponential_sum
from springpot.problem.free_numbers import nominal, uncertain_numbers, with_values
from springpot.problem.uncertain import Bounded, Measured
from tests.scattering.problems import ALONE, DEVIATION, MEAN, NAMES, device
from tests.sizes import validation

GIVEN: dict[str, Any] = {"devices": 256, "paths": 8, "duration": 120.0, "window": (60.0, 120.0), "step": 0.1}


def mount(**numbers: Any) -> sp.System:
    """The device of the README, with scatter."""
    own = {"k": sp.uncertain("k", 3200.0, sd=160.0), "order": sp.uncertain("order", bounds=(0.28, 0.32)),
           "C": sp.uncertain("C", 150.0, cov=0.1), "r": 0.7, **numbers}  # fmt: skip
    return sp.System(
        sp.Mass(0.8), sp.Spring(own["k"]), sp.Springpot(own["order"], own["C"]),
        sp.Barrier(-sp.uncertain("gap", 0.006, sd=0.0006, bounds=(0.003, 0.009)), own["r"]),
        sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    )  # fmt: skip


def test_an_oscillator_with_exact_results() -> None:
    """Mean, scatter and indices of 2,048 paths; those of one device alone would be off by 5 %."""
    found = sp.scatter(device(), ["x_mean_square"], **GIVEN)["x_mean_square"]
    assert abs(found.mean.value - MEAN) < 4.0 * found.mean.error < 0.08
    assert abs(math.log(found.scatter.value / DEVIATION)) < 0.25
    assert all(abs(found.alone[name].value - ALONE[name]) < 0.16 for name in NAMES)
    assert found.path_scatter > 0.4


@pytest.mark.validation  # every day: the exact results by paths, above, and the words, below
def test_theory_of_each_device() -> None:
    """Without paths: the indices of 1,024 devices to a per cent."""
    found = sp.scatter(device(), ["x_mean_square"], method="linear", limits={"x_mean_square": 2.5})["x_mean_square"]
    assert abs(found.mean.value - MEAN) < 4.0 * found.mean.error < 4e-3
    assert found.scatter.value == pytest.approx(DEVIATION, rel=0.01)
    assert all(abs(found.alone[name].value - ALONE[name]) < 0.01 for name in NAMES)
    assert found.path_scatter == 0.0
    assert found.above[2.5].value == pytest.approx(0.029, abs=0.006)


def test_a_report_by_theory() -> None:
    text = sp.scatter(mount(), ["impact_speed_mean"], method="envelope", devices=64).report()
    assert "64 devices, by theory (envelope)" in text
    assert "path to path" not in text
    with pytest.raises(NotCoveredError, match="method must cover the system, and linear does not"):
        sp.scatter(mount(), method="linear")


def test_the_same_bits_for_any_number_of_threads() -> None:
    one, two = (
        sp.scatter(mount(), ["impact_rate"], devices=64, paths=4, duration=2.0, threads=threads) for threads in (1, 2)
    )
    np.testing.assert_array_equal(one.means["impact_rate"], two.means["impact_rate"])
    assert one.report() == two.report()


@pytest.mark.parametrize("paths", [4, validation(64), validation(128)])
def test_devices_are_the_runs_of_each_alone(paths: int) -> None:
    """With a scattered order too: all have the same rates of memory, and weights of their own."""
    system, given = mount(), {"duration": 1.0, "window": (0.2, 1.0), "step": 1e-3}
    found = sp.scatter(system, ["x_mean_square", "impact_rate"], devices=64, paths=paths, **given)
    for row in (0, 17, 63):
        own = with_values(system, dict(zip(found.inputs, found.draws[row].tolist(), strict=True)))
        alone = sp.simulate(
            own, paths=20_000, start="rest", initial_position=found.settings.initial_position, seed=5, **given
        )
        for name in ("x_mean_square", "impact_rate"):
            error = alone[name].error * math.hypot(1.0, math.sqrt(20_000 / paths))
            assert abs(found.means[name][row] - alone[name].value) < 4.0 * error


@pytest.mark.validation  # every day: a file with a table, below; several masses share blocks
def test_two_masses_and_a_table_of_values() -> None:
    stiffness = sp.uncertain("k", values=[95.0, 100.0, 103.0, 99.0, 108.0, 91.0])
    pair = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Spring(stiffness, between=("ground", "a")),
        sp.Spring(0.8 * stiffness, between=("a", "b")), sp.Dashpot(1.0, between=("ground", "a")),
        sp.WhiteNoise(sp.uncertain("q", law=scipy.stats.gamma(20.0, scale=5e-4)), on="b"),
        gap=sp.Barrier(-0.02, 0.7, between=("a", "b")),
    )  # fmt: skip
    found = sp.scatter(pair, devices=64, paths=8, duration=20.0)
    assert found.inputs == found.numbers == ("k", "q")
    assert {"a_x_mean_square", "b_v_mean_square", "gap_impact_rate"} <= {*found}
    own = found["b_v_mean_square"]
    assert own.alone["q"].value > own.alone["k"].value
    table = found.to_xarray()
    assert table["gap_impact_rate_of_draw"].sizes == {"draw": 64}
    assert float(table["b_v_mean_square_scatter_low"]) <= float(table["b_v_mean_square_scatter"])
    assert isinstance(uncertain_numbers(pair)["k"].law, Measured)


@pytest.mark.validation  # every day: an order that scatters, above
def test_a_dashpot_beside_a_springpot_whose_order_scatters() -> None:
    """And springpots of fixed orders: they have rates of their own."""
    system = sp.System(
        sp.Mass(1.0), sp.Spring(1000.0), sp.Springpot(sp.uncertain("order", bounds=(0.3, 0.4)), 10.0), sp.Dashpot(2.0),
        sp.Springpot(0.9, 3.0), sp.WhiteNoise(3.0),
    )  # fmt: skip
    found = sp.scatter(system, ["x_mean_square"], devices=64, duration=5.0, seed=2)
    by_theory = sp.scatter(system, ["x_mean_square"], devices=64, method="linear", seed=2)
    ratio = found.means["x_mean_square"] / by_theory.means["x_mean_square"]
    error = found["x_mean_square"].path_scatter / found["x_mean_square"].mean.value / math.sqrt(8 * 64)
    assert abs(ratio.mean() - 1.0) < 4.0 * error < 0.1


def test_each_device_starts_about_its_place_of_rest() -> None:
    """A constant force: the mean displacement scatters as f / k from the start on."""
    system = sp.System(
        sp.Mass(1.0), sp.Spring(300.0), sp.Springpot(0.3, 1500.0), sp.Constant(sp.uncertain("f", 30.0, cov=0.1)),
        sp.WhiteNoise(1.0),
    )  # fmt: skip
    found = sp.scatter(system, ["x_mean"], devices=64, duration=10.0)["x_mean"]
    assert found.scatter.value == pytest.approx(0.01, rel=0.1)


def test_devices_that_differ_in_a_rate_have_blocks_of_their_own() -> None:
    arm = sp.Maxwell(200.0, sp.uncertain("tau", 0.05, cov=0.2))
    system = sp.System(sp.Mass(1.0), sp.Spring(1000.0), arm, sp.WhiteNoise(3.0))
    found = sp.scatter(system, ["x_mean_square"], devices=64, duration=2.0)
    assert found.paths == 64
    with pytest.raises(ValueError, match="paths must be 64 or a multiple of it, not 8"):
        sp.scatter(system, ["x_mean_square"], devices=64, duration=2.0, paths=8)


def test_the_report_says_what_it_is() -> None:
    found = sp.scatter(mount(), ["impact_rate"], devices=64, paths=8, duration=5.0, limits={"impact_rate": 3.0})
    text = str(found)
    for words in (
        "64 devices, 8 paths each",
        "nominal device",
        "mean over devices",
        "device to device",
        "gap",
        "limit 3",
    ):
        assert words in text
    assert "intervals from 64 devices are rough" in text
    assert "bounds leave out" not in text  # 6e-7 of the law
    assert all(len(line) <= 120 for line in text.splitlines() if not line.startswith("warning"))


def test_uncertain_numbers_are_kept_and_copied() -> None:
    k = sp.uncertain("k", 3200.0, cov=0.05)
    for copied in (pickle.loads(pickle.dumps(k)), 1.0 * k, k + 0.0):
        assert (float(copied), copied.name) == (3200.0, "k")
        assert copied.law == k.law
    inverse = 2.0 / k
    assert (float(inverse), inverse.at(100.0), inverse.law) == (2.0 / 3200.0, 0.02, k.law)
    halved = -0.5 * k
    assert (float(halved), halved.low) == (-1600.0, -0.5 * k.high)
    assert nominal(mount()).of(sp.Spring) == (sp.Spring(3200.0),)
    spread = math.sqrt(math.log1p(0.0025))
    lognormal = scipy.stats.lognorm(spread, scale=3200.0 * math.exp(-0.5 * spread**2))
    assert lognormal.mean() == pytest.approx(3200.0)
    assert float(k.law.ppf(0.95)) == pytest.approx(lognormal.ppf(0.95), rel=1e-12)


def test_an_expression_of_two_is_lost_and_a_part_refuses_it() -> None:
    """Elsewhere it is a plain number: theory divides stiffness by mass."""
    k, m = sp.uncertain("k", 80.0, cov=0.1), sp.uncertain("m", 2.0, cov=0.1)
    free = sp.free("f", 2.0, (1.0, 3.0))
    lost = [
        k * m,
        k / m,
        k + m,
        k - m,
        k**m,
        2.0**k,
        k * k,
        free * k,
        free * free,
        2.0 / (k * m),
        -(k / m),
        abs(k - m),
        3.0 - 2 * (m * k) ** 0.5,
    ]
    for number in (*lost, pickle.loads(pickle.dumps(k * m))):
        for make in (sp.Spring, lambda own: sp.PolynomialSpring((1.0, own)), lambda own: sp.Barrier(position=own)):
            with pytest.raises(ValueError, match=r"cannot follow .* through this expression"):
                make(number)
    pair = sp.System(
        sp.Mass(m, at="a"), sp.Mass(2.0 * m, at="b"), sp.Spring(k, between=("ground", "a")), sp.WhiteNoise(1.0, on="b"),
        sp.Spring(k, between=("a", "b")), sp.Dashpot(sp.uncertain("c", 1.0, cov=0.2), between=("ground", "a")),
    )  # fmt: skip
    lone = sp.System(sp.Mass(m), sp.Spring(k), sp.Springpot(0.5, k), sp.Barrier(-0.1, 0.7), sp.WhiteNoise(m))
    assert sp.theory.linear(pair).moments == sp.theory.linear(sp.nominal(pair)).moments
    assert sp.theory.envelope(lone).moments == sp.theory.envelope(sp.nominal(lone)).moments


def test_numbers_have_their_correlation_with_them() -> None:
    one, other = (
        sp.uncertain("k", 3200.0, cov=0.1, correlation={"C": 0.6, "absent": 0.1}),
        sp.uncertain("C", 150.0, cov=0.1),
    )

    def linear(stiffness: Any) -> sp.System:
        return sp.System(sp.Mass(0.8), sp.Spring(stiffness), sp.Dashpot(other), sp.WhiteNoise(1.0))

    given = {"devices": 64, "method": "linear"}
    own = sp.scatter(linear(one), ["x_mean_square"], **given)
    told = sp.scatter(
        linear(sp.uncertain("k", 3200.0, cov=0.1)), ["x_mean_square"], correlation={("k", "C"): 0.6}, **given
    )
    assert own.report() == told.report()
    assert "k and C" in own.inputs
    assert (
        uncertain_numbers(sp.read_system(tomllib.loads(sp.to_toml(mount(k=2.0 * one)))))["k"].correlation
        == one.correlation
    )


def test_bounds_leave_out_what_is_beyond() -> None:
    gap = sp.uncertain("gap", 0.0, sd=1.0, bounds=(-1.96, 2.2))
    assert isinstance(gap.law, Bounded)
    assert gap.law.cut == pytest.approx(0.0389, abs=1e-4)
    assert (gap.low, gap.high) == (pytest.approx(-1.96), pytest.approx(2.2))
    assert float(gap.law.ppf(0.5)) == pytest.approx(scipy.stats.truncnorm(-1.96, 2.2).ppf(0.5), rel=1e-9)


def test_a_file_holds_them_and_the_command_prints_the_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    system = mount(C=sp.uncertain("C", values=[140.0, 150.0, 163.0]))
    file = tmp_path / "device.toml"
    file.write_text(sp.to_toml(system), encoding="utf-8")
    again = uncertain_numbers(sp.read_system(file))
    assert again == uncertain_numbers(system)
    assert [each.law for each in again.values()] == [each.law for each in uncertain_numbers(system).values()]
    words = ["scatter", str(file), "--quantities", "x_mean_square", "--devices", "64", "--duration", "2"]
    assert cli.main([*words, "--plot", str(tmp_path / "a.png")]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("Scatter of 4 inputs: 64 devices, 8 paths each.")
    assert "intervals from 64 devices are rough" in said.err
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert cli.main([*words, "--limit", "impact_rate", "2", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert 0.0 < found["impact_rate"]["above"]["2.0"]["value"] < 1.0
    assert found["x_mean_square"]["index"]["gap"]["low"] < found["x_mean_square"]["index"]["gap"]["high"]
    file.write_text(
        file.read_text(encoding="utf-8").replace("cov", "variation").replace("sd =", "variation ="), encoding="utf-8"
    )
    assert cli.main(words) == 2
    assert "'variation' is not a key of parts[1] (spring).stiffness" in capsys.readouterr().err


FEW = sp.Mass(1.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0)
TWO = sp.Spring(sp.uncertain("k", 1.0, cov=0.1)), sp.Spring(sp.uncertain("k", 2.0, cov=0.1))
BOTH = sp.Spring(sp.free("c", 1.0, (0.5, 2.0))), sp.Friction(sp.uncertain("c", 0.1, cov=0.1))
WRONG: list[Any] = [
    (lambda: sp.uncertain("k", cov=0.1), TypeError, "value must be given with cov"),
    (lambda: sp.uncertain("k", 1.0, cov=0.1, sd=0.2), TypeError, "k must have one of cov, sd, log_sd, law and values"),
    (lambda: sp.uncertain("k", 1.0), TypeError, "or bounds alone, not none of them"),
    (lambda: sp.uncertain("k", -1.0, cov=0.1), ValueError, "value must be above 0 with cov"),
    (lambda: sp.uncertain("k", 1.0, sd=-0.1), ValueError, "sd must be"),
    (lambda: sp.uncertain("k", bounds=(2.0, 1.0)), ValueError, "bounds must be in ascending order"),
    (lambda: sp.uncertain("k", 1.0, sd=1.0, bounds=(0.5, 3.0)), ValueError, "bounds must leave out at most 5 %"),
    (lambda: sp.uncertain("k", values=[1.0, 2.0]), ValueError, "values must be at least 3 numbers"),
    (lambda: sp.uncertain("k", law=3.0), TypeError, "law must have ppf and cdf"),
    (lambda: sp.Springpot(sp.uncertain("order", 0.9, sd=0.05), 1.0), ValueError, "number order: give bounds="),
    (lambda: sp.scatter(sp.System(*FEW, sp.Spring(1.0))), ValueError, "system must have uncertain numbers"),
    (lambda: sp.scatter(sp.System(*FEW, *TWO)), ValueError, "k must have the same value and law"),
    (lambda: sp.uncertain("k", law=scipy.stats.norm), TypeError, "law must have its numbers"),
    (lambda: sp.scatter(sp.System(*FEW, *BOTH)), ValueError, "c must be free or uncertain wherever it stands"),
    (lambda: sp.scatter(mount(), []), TypeError, "quantities must be a list of names"),
    (lambda: sp.scatter(mount(), devices=65536, paths=4096), ValueError, "devices and paths must be fewer"),
    (lambda: sp.scatter(mount(), devices=100), ValueError, "devices must be a power of two, not 100: 64 is one"),
    (lambda: sp.scatter(mount(), ["impact_speed_mean"]), ValueError, "quantities must be of"),
    (lambda: sp.scatter(mount(), limits={"impact_rat": 1.0}), ValueError, "did you mean impact_rate"),
    (lambda: sp.scatter(mount(), correlation={("k", "c"): 0.5}), ValueError, "must be of k, order, C and gap"),
    (lambda: sp.scatter(mount(), correlation={"k": 0.5}), TypeError, "'k' is no pair of two names"),
    (lambda: sp.scatter(mount(), correlation={("k", "C"): 1.5}), ValueError, "correlation of k and C must be"),
    (
        lambda: sp.scatter(mount(), correlation={("k", "C"): 0.9, ("C", "gap"): 0.9, ("k", "gap"): -0.9}),
        ValueError, "correlation must be positive definite, but its least eigenvalue is -0.8",
    ),
    (
        lambda: sp.Spring(sp.uncertain("k", 1.0, cov=0.1) / sp.uncertain("n", 2.0, cov=0.1)),
        ValueError, "stiffness cannot follow k and n through this expression: only sums",
    ),
    (lambda: sp.uncertain("k", 1.0, cov=0.1, correlation={"k": 0.5}), ValueError, "correlation of k must be with"),
    (lambda: sp.uncertain("k", 1.0, cov=0.1, correlation={"C": 2.0}), ValueError, "correlation of k and C must be in"),
    (lambda: sp.uncertain("k", -1.0, log_sd=0.1), ValueError, "value must be above 0 with log_sd"),
    (
        lambda: sp.scatter(mount(k=sp.uncertain("k", 3200.0, cov=0.1, correlation={"C": 0.5}),
                                 C=sp.uncertain("C", 150.0, cov=0.1, correlation={"k": 0.4}))),
        ValueError, "correlation of C and k must be the same in both, not 0.4 and 0.5",
    ),
    (
        lambda: sp.scatter(sp.System(
            sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0), sp.Barrier(-sp.uncertain("gap", 0.1, sd=0.08), 0.7)
        )),
        ValueError, "position must keep its sign in all devices, but 11 % of the law of gap are beyond 0",
    ),
    (lambda: sp.simulate(mount()), ValueError, "plain numbers, but k, order, C and gap are uncertain"),
    (lambda: sp.scatter(mount(k=sp.uncertain("k", bounds=(100.0, 40000.0)))), ValueError, "step must be given"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "kind", "words"), WRONG)
def test_what_is_wrong_is_one_sentence(call: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind) as caught:
        call()
    assert words in str(caught.value), str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("low", "high", "steps", "tolerance"),
    [(0.28, 0.32, 33_000, 1e-6), (0.45, 0.55, 5_000, 1e-4), (0.75, 0.85, 1_000_000, 1e-6), (0.2, 0.6, 20_000, 1e-4)],
)
def test_common_rates_hold_over_their_range(low: float, high: float, steps: int, tolerance: float) -> None:
    """With few modes more than one order needs."""
    sums = common_rates("average", low, high, steps, tolerance)
    assert max(sums(order).relative_error for order in np.linspace(low, high, 21)) <= 1.5 * tolerance
    middle = exponential_sum("average", 0.5 * (low + high), steps, tolerance)
    assert sums.rates.size <= middle.rates.size + 4
