"""``rtol`` for several masses: the same levels as for one mass, against exact laws, and what is not promised."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.error import reach as accuracy
from springpot.simulation.error.budget import UNCERTAIN_ORDER, combine, orders_of_step
from springpot.simulation.error.levels import levels_of
from springpot.simulation.error.reach import checked_quantities, controllable, reach
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.schemes import Straight, scheme_of
from springpot.simulation.plan.struck import slow_impact_order
from tests.sizes import validation

from ..test_several import A_B, BOLTZMANN, GROUND_A, GROUND_B, chain, linear_pair, masses, thermal_pair, three
from .test_accuracy import ThreeMeasures

POTS = sp.Springpot(0.4, 0.5, between=GROUND_A), sp.Springpot(0.8, 0.3, between=A_B)


def check(run: Any, exact: dict[str, float], rtol: float) -> None:
    assert run.diagnostics["reached"]
    for name, value in exact.items():
        total = run[name].budget.total
        assert total <= rtol * run[name].value, name
        assert abs(run[name].value - value) < total, name


@pytest.mark.parametrize("rtol", [0.05, validation(0.005)])
def test_stated_errors_hold_against_boltzmanns_law(rtol: float) -> None:
    run = simulated(thermal_pair(), rtol=rtol, quantities=tuple(BOLTZMANN))
    assert run.settings.window[0] == 0.0
    check(run, BOLTZMANN, rtol)


def test_without_names_all_mean_squares_are_controlled() -> None:
    system = chain(sp.WhiteNoise(0.5, on="d"))
    run = simulated(system, rtol=0.03)
    names = [f"{point}_{of}_mean_square" for of in "xv" for point in "abcd"]
    assert run.settings.start == "stationary"
    assert run.settings.window[0] > 4.0 * motion_of(system).scales.energy_time
    exact = sp.theory.linear(system).moments
    check(run, {name: exact[name] for name in names}, 0.03)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error


@pytest.mark.parametrize(
    "system",
    [
        linear_pair(sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.3, on="ground")),
        linear_pair(sp.ColoredNoise(1.0, 0.4, on="b"), sp.KanaiTajimiNoise(2.0, 0.5, 0.5, on="ground")),
        linear_pair(sp.PoissonImpulses(2.0, 0.5, on="b"), sp.WhiteNoise(0.3, on="ground")),
        sp.System(*linear_pair().parts, *POTS, sp.ThermalNoise(0.5)),
        linear_pair(*(sp.ColoredNoise(1.0, 0.2 + 0.05 * n, on="ab"[n % 2]) for n in range(12))),
    ],
)
def test_the_coarse_paths_of_a_pair_have_the_excitation_of_the_fine_ones(system: sp.System) -> None:
    """Impulses of half steps are summed in pairs: at a short step the two paths are nearly the same."""
    plan = plan_of(system, paths=64, duration=4.0, step=0.02, window=(0.0, 4.0), start="rest")
    fine = simulation_of(plan.but(step=0.01)).advance(stream=3).rows[:, :4] / 400
    halved = simulation_of(plan, halved=True)
    coarse = halved.advance(stream=3, halved=True).rows[:, :4] / 200
    other = simulation_of(plan).advance(stream=3).rows[:, :4] / 200
    assert (np.abs(fine - coarse).max(axis=0) < 0.02 * np.abs(fine).max(axis=0)).all()
    assert (np.abs(fine - other).max(axis=0) > 0.2 * np.abs(fine).max(axis=0)).all()
    assert [each.added for each in halved.parts.readings] == [each.added for each in simulation_of(plan).parts.readings]


@pytest.mark.parametrize(("pots", "order"), [((), 1.99), (POTS, 1.75)])
def test_weak_order_of_the_scheme_is_what_it_states(pots: tuple[sp.Springpot, ...], order: float) -> None:
    """Without walls it is linear: stationary moments are sums of squares of its response to one impulse."""
    parts = *linear_pair().parts, *pots
    noisy = sp.System(*parts, sp.WhiteNoise(1.0, on="b"))
    exact, fastest = sp.theory.linear(noisy).moments, motion_of(noisy).scales.fastest_rate
    biases = []
    for ratio in (0.2, 0.05):
        step = 200.0 / math.ceil(200.0 * fastest / ratio)
        pushed = sp.RecordedExcitation((0.0, step), (1.0, 1.0), on="b")  # in the first step only
        given: dict[str, Any] = {"duration": 200.0, "window": (0.0, 200.0), "step": step, "start": "rest"}
        simulation = simulation_of(plan_of(sp.System(*parts, pushed), paths=1, **given))
        assert simulation.settings.step == pytest.approx(step, rel=1e-12)
        sums = simulation.parts.sums(simulation.advance().rows[0])
        added = {each.name: each.added for each in simulation_of(plan_of(noisy, paths=1, **given)).parts.readings}
        biases.append(
            [
                (sums[f"{of}^2", point] / step + added[f"{point}_{of}_mean_square"])
                / exact[f"{point}_{of}_mean_square"]
                - 1.0
                for of in "xv"
                for point in "ab"
            ]
        )
    assert max(map(abs, biases[0])) < 0.001
    assert scheme_of("straight").order == 2
    for coarse, fine in zip(*biases, strict=True):
        assert abs(fine) < 1e-6 or math.log(abs(coarse / fine), 4.0) > order, biases


def test_the_same_seed_gives_the_same_numbers_for_any_number_of_threads() -> None:
    one, two = (reach(thermal_pair(), 0.1, quantities=("gap_impact_rate",), threads=n) for n in (1, 2))
    assert (one.values, one.errors, one.budgets) == (two.values, two.errors, two.budgets)
    assert one.rows.tobytes() == two.rows.tobytes()


def test_max_time_ends_after_a_whole_round_whose_bits_are_those_of_the_same_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system = linear_pair(sp.WhiteNoise(1.0, on="a"), sp.Barrier(-0.3, 0.8, between=A_B))
    monkeypatch.setattr(accuracy, "Clock", ThreeMeasures)
    short = reach(system, 1e-3, quantities=("a_v_mean_square",), max_time=2.0, seed=3)
    assert short.shortfall.startswith("a_v_mean_square is known to ")
    assert "max_time of 2 s is over" in short.shortfall
    first = Straight.coarsest_step / motion_of(system).scales.fastest_rate
    again = levels_of(short.simulation.plan.but(step=first)).with_step(
        round(math.log2(first / short.settings.step)) - 1
    )
    again = again.extended(short.settings.paths - 2 * short.pairs, short.pairs, None)
    assert combine(again).values == short.values
    assert combine(again).errors == short.errors


@pytest.mark.parametrize("suffix", [validation(".nc"), ".json"])
def test_a_run_with_rtol_is_saved_and_read(tmp_path: Path, suffix: str) -> None:
    run = simulated(thermal_pair(), rtol=0.2)
    again = sp.load_run(run.save(tmp_path / f"run{suffix}"))
    assert (again.estimates, again.settings, again.system) == (run.estimates, run.settings, run.system)
    assert run.to_xarray()["x_mean_square"].dims == ("point",)


def test_means_that_are_0_by_symmetry_are_not_promised() -> None:
    symmetric = linear_pair(sp.WhiteNoise(1.0, on="a"))
    both = linear_pair(sp.WhiteNoise(1.0, on="a"), *(sp.Barrier(p, 0.8, s, between=A_B) for p, s in
                                                     ((-0.3, "above"), (0.3, "below"))))  # fmt: skip
    one = linear_pair(sp.WhiteNoise(1.0, on="a"), sp.Barrier(-0.3, 0.8, between=A_B))
    assert not [name for name in controllable(motion_of(symmetric)) if name.endswith("_mean")]
    assert [name for name in controllable(motion_of(both)) if name.endswith("_x_mean")] == []
    assert [name for name in controllable(motion_of(one)) if name.endswith("_x_mean")] == ["a_x_mean", "b_x_mean"]
    equal = sp.System(
        *masses(a=1.0, b=1.0), *(sp.Spring(1.0, between=e) for e in (GROUND_A, A_B, GROUND_B)),
        *(sp.WhiteNoise(1.0, on=p) for p in "ab"), *(sp.Dashpot(0.1, between=e) for e in (GROUND_A, GROUND_B)),
        sp.Mass(1.0, at="c"), sp.Spring(1.0, between=("ground", "c")), sp.Dashpot(0.1, between=("ground", "c")),
        sp.Barrier(-0.2, between=A_B),
    )  # fmt: skip
    means = [name for name in controllable(motion_of(equal)) if name.endswith(("x_mean", "elongation_mean"))]
    assert means == ["a_x_mean", "b_x_mean", "a_b_elongation_mean"]  # nothing that has a mean reaches c


@pytest.mark.parametrize("quantity", ["a_x_mean", "amplitude_mean_square", "x_mean_square"])
def test_a_quantity_that_cannot_be_promised_is_refused(quantity: str) -> None:
    """``far`` has infinitely many impacts, ``near`` a rate."""
    near, far = sp.Barrier(-0.2, 0.8, between=A_B), sp.Barrier(-0.3, 0.8, between=("b", "c"))
    system = three(sp.WhiteNoise(0.4, on="a"), near=near, far=far)
    assert "near_impact_rate" in controllable(motion_of(system))
    assert checked_quantities(motion_of(system), ("far_impact_rate", "near_impact_rate")) == ("near_impact_rate",)
    if quantity == "a_x_mean":
        system = three(sp.WhiteNoise(0.4, on="a"))
    with pytest.raises(ValueError, match=f"quantities must be among .*a_v_mean_square.*, not {quantity}"):
        sp.simulate(system, rtol=0.1, quantities=(quantity,))


def test_the_order_of_a_rate_is_that_of_its_own_wall() -> None:
    system = three(
        sp.WhiteNoise(0.4, on="a"), sp.WhiteNoise(0.4, on="c"),
        hard=sp.Barrier(-0.2, 1.0, between=A_B), lossy=sp.Barrier(-0.3, 0.4, between=("b", "c")),
    )  # fmt: skip
    motion = motion_of(system)
    assert orders_of_step(motion, "lossy_impact_rate", 0.02) == (slow_impact_order(0.4) + UNCERTAIN_ORDER, 2.0)
    assert orders_of_step(motion, "hard_impact_rate", 0.02) == orders_of_step(motion, "a_v_mean_square", 0.02)


@pytest.mark.parametrize("time", [30.0, 300.0])
def test_what_a_run_from_rest_lacks_of_the_variance(time: float) -> None:
    """Two masses that do not touch: each is the paper's problem, whose late creep is a power of time."""
    pots = sp.Springpot(0.7, 2.0, between=GROUND_A), sp.Springpot(0.6, 4.0, between=GROUND_B)
    apart = sp.System(
        *masses(a=1.0, b=1.0), *(sp.Spring(1.0, between=e) for e in (GROUND_A, GROUND_B)), *pots,
        *(sp.WhiteNoise(1.0, on=p) for p in "ab"),
    )  # fmt: skip
    (creep,) = motion_of(apart).slow
    for point, pot in zip("ab", pots, strict=True):
        (alone,) = motion_of(sp.Oscillator(1.0, sp.Springpot(pot.order, pot.coefficient), None)).slow
        found = creep.missing(time)[f"{point}_x_mean_square"]
        assert found == pytest.approx(alone.missing(time)["x_mean_square"], rel=0.1)
        late = (pot.order * pot.coefficient / math.gamma(1.0 - pot.order)) ** 2 / (1.0 + 2.0 * pot.order)
        beyond = creep.missing(1e3 * time)[f"{point}_x_mean_square"]
        assert beyond == pytest.approx(late * (1e3 * time) ** (-1.0 - 2.0 * pot.order), rel=0.1)
    run_begins = reach(apart, 0.05, quantities=("b_x_mean_square",)).settings.window[0]
    assert creep.missing(run_begins)["b_x_mean_square"] < 0.01 * creep.free["b_x_mean_square"]


def test_the_power_of_matched_noise_is_that_of_all_dampers() -> None:
    system = sp.System(*linear_pair().parts, *POTS, sp.ThermalNoise(0.5))
    run = sp.simulate(system, paths=640, duration=60.0, step=0.05)
    assert run["thermal_noise_power"].value == pytest.approx(run["damping_power"].value, rel=0.015)
    assert run["thermal_noise_power"].error < 0.01 * run["damping_power"].value


def test_a_run_is_extended_to_an_error() -> None:
    run = sp.extend(simulated(thermal_pair(), paths=256, duration=20.0), rtol=0.05, quantities=("a_v_mean_square",))
    assert abs(run["a_v_mean_square"].value - 0.6) < run["a_v_mean_square"].budget.total < 0.05 * 0.6


def test_the_rate_on_a_lossy_wall_hardly_depends_on_the_step() -> None:
    """Slow impacts are added; the counted rates differ by 6 %."""
    system = linear_pair(sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.5, on="b"), sp.Barrier(-0.1, 0.3, between=A_B))
    plan = plan_of(system, paths=2048, duration=100.0, step=0.08, window=(20.0, 100.0), start="rest")
    levels = levels_of(plan).extended(0, 2048, None)
    coarse, fine = levels.pair_coarse.samples(), levels.pair_fine.samples()
    changes = {name: fine[f"barrier_{name}"].mean() / coarse[f"barrier_{name}"].mean() - 1.0 for name in
               ("plain_rate", "impact_rate")}  # fmt: skip
    assert changes["plain_rate"] > 0.04
    assert abs(changes["impact_rate"]) < 0.3 * changes["plain_rate"]


def test_uncontrolled_impacts_are_said_of_each_wall() -> None:
    rare = linear_pair(sp.WhiteNoise(1.0, on="a"), sp.Barrier(-2.5, between=A_B))
    run = simulated(rare, rtol=0.1, quantities=("a_v_mean_square",))
    assert any(sentence.startswith("quantities does not name") and "barrier_impact_rate" in sentence
               for sentence in run.warnings)  # fmt: skip
