"""Runs of systems whose points are combinations of masses: the same motion in other coordinates, beams, inerters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.problem.matrices import parts_of_matrices
from springpot.simulation.monte_carlo import simulated
from tests.problem.test_modes import CANTILEVER, in_other_coordinates
from tests.simulation.test_several import A_B, BOLTZMANN, GROUND_A, GROUND_B, check, linear_pair
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

GAP = sp.Barrier(-0.3, 1.0, between=A_B)


@pytest.mark.parametrize(
    "more",
    [
        (sp.WhiteNoise(1.0, on="b"),),
        (sp.WhiteNoise(1.0, on="b"), GAP, sp.Springpot(0.5, 0.2, between=A_B), sp.Friction(0.1, between=GROUND_B)),
        (sp.WhiteNoise(1.0, on="ground"), sp.Contact(-0.1, 20.0, 1.5, 0.2, between=GROUND_A)),
    ],
)
def test_a_pair_in_other_coordinates_has_the_same_paths(more: Any) -> None:
    """With the same noise, until impacts have made rounding visible."""
    runs = [
        simulated(sp.System(*each.parts, *more), paths=64, duration=8.0, step=0.02, window=(0.0, 8.0), record=64)
        for each in (linear_pair(), in_other_coordinates())
    ]
    one, two = runs
    start = two.system.points.index("a")
    path = two.record[:, :, start : start + 2]
    np.testing.assert_allclose(path[:, :100], one.record[:, :100], atol=3e-5)
    for name in two.estimates.keys() & one.estimates.keys():
        own = one[name]
        allowed = 1e-3 * abs(own.value) + 0.02 * own.error if "impact" not in name else 0.3 * own.error
        assert abs(two[name].value - own.value) <= allowed + 1e-9, name
    assert two.to_xarray()["x"].sizes["point"] == len(two.system.points)
    x = two.record[:, 1:, :, 0]
    np.testing.assert_allclose(
        [two[f"{p}_x_mean_square"].value for p in "ab"], (path[:, 1:, :, 0] ** 2).mean((0, 1)), rtol=1e-3
    )
    np.testing.assert_allclose(
        x, x[:, :, : len(two.system.coordinates.names)] @ two.system.coordinates.rows.T, atol=1e-12
    )


@pytest.mark.parametrize("paths", [640, validation(8192)])
def test_a_pair_in_other_coordinates_obeys_boltzmanns_law(paths: int) -> None:
    """Also with an inerter across the gap: x has the same law, and impacts that of the larger reduced mass."""
    warm = *in_other_coordinates().parts, sp.ThermalNoise(0.6)
    run = sp.simulate(sp.System(*warm, gap=GAP), paths=paths, duration=400.0, window=(50.0, 400.0))
    check(run, BOLTZMANN, precise=0.3 / np.sqrt(paths))
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.02
    slower = np.sqrt((1.0 / 3.0) / (1.0 / 3.0 + 0.25))
    exact = {name: value for name, value in BOLTZMANN.items() if "v_" not in name}
    exact |= {name: value * slower for name, value in BOLTZMANN.items() if name[:10] == "gap_impact"}
    light = np.linalg.inv(np.diag([1.0, 0.5]) + 0.25 * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    exact |= {f"{p}_v_mean_square": 0.6 * light[n, n] for n, p in enumerate("ab")}
    for parts in (warm, (*linear_pair().parts, sp.ThermalNoise(0.6))):
        run = sp.simulate(
            sp.System(*parts, sp.Inerter(0.25, between=A_B), gap=GAP), paths=paths, duration=400.0, window=(50.0, 400.0)
        )
        check(run, exact, precise=0.3 / np.sqrt(paths))


def test_an_elastic_impact_in_other_coordinates_conserves_momentum_and_energy() -> None:
    """Of two free masses with an inerter between them."""
    row, change = np.array([-1.0, 1.0]), np.array([[1.0, 0.4], [-0.7, 2.0]])
    mass, back = np.diag([1.0, 0.3]) + 0.2 * np.outer(row, row), np.linalg.inv(change)
    names = {"a": back[0], "b": back[1]}
    free = sp.System(
        *parts_of_matrices(back.T @ mass @ back, np.zeros((2, 2)), None, names), gap=sp.Barrier(-0.2, 1.0, between=A_B)
    )
    inverse = np.linalg.inv(free.coordinates.rows[2:])
    x, v = inverse @ [0.0, 0.1], inverse @ [0.7, -0.5]
    run = simulated(
        free, paths=1, duration=1.0, step=0.01,
        window=(0.0, 1.0), record=1, initial_position={"mode_1": x[0], "mode_2": x[1]},
        initial_velocity={"mode_1": v[0], "mode_2": v[1]},
    )  # fmt: skip
    found = run.record[0, :, 2:, 1]
    assert run["gap_impact_rate"].value == 1.0
    assert np.ptp(found @ mass.sum(axis=0)) < 1e-14
    assert np.ptp(np.einsum("ti,ij,tj->t", found, mass, found)) < 1e-14
    assert found[-1, 1] - found[-1, 0] == pytest.approx(1.2)


def strip(modes: int, *more: object, **named: object) -> sp.System:
    beam = sp.beam(**CANTILEVER, points={"tip": 0.3, "middle": 0.15}, modes=modes, damping_ratios=0.02)
    return sp.System(*beam.parts, *more, **named)


@pytest.mark.validation  # every day: rows of masses, in test_several_numbers.py
def test_a_cantilever_without_a_stop_is_as_linear_theory_has_it() -> None:
    shaken = strip(3, sp.WhiteNoise(1.0, on="ground"), sp.WhiteNoise(2e-4, on="tip"))
    found = sp.theory.linear(shaken)
    wanted = {f"{point}_{of}_mean_square": found.moments[f"{point}_{of}_mean_square"]
              for point in ("mode_1", "tip", "middle") for of in "xv"}  # fmt: skip
    check(sp.simulate(shaken, paths=1280, duration=6.0, window=(2.0, 6.0)), wanted, 0.003, 0.03)


@pytest.mark.validation  # every day: without a stop; pairs in other coordinates
def test_a_cantilever_with_a_tip_stop_balances_its_energy() -> None:
    stopped = strip(3, sp.WhiteNoise(1.0, on="ground"), stop=sp.Barrier(-0.002, 0.7, between=("ground", "tip")))
    run = sp.simulate(stopped, paths=640, duration=4.0, window=(1.0, 4.0), record=64)
    assert abs(run["energy_residual"].value) < 4.0 * run["energy_residual"].error < 0.03
    assert run["stop_impact_rate"].value > 10.0
    assert run.record[:, :, stopped.points.index("tip"), 0].min() > -0.002 - 1e-8
    total = run["damping_power"].value + run["stop_power"].value
    assert total == pytest.approx(run["input_power"].value, rel=0.03)


def test_one_mode_is_one_mass() -> None:
    """In the kernel of several masses, with a wall at the tip."""
    one = strip(1, sp.WhiteNoise(1e-4, on="tip"), stop=sp.Barrier(-0.002, 0.7, between=("ground", "tip")))
    mass, spring, dashpot = one.parts[:3]
    alone = sp.System(
        sp.Mass(mass.value), sp.Spring(spring.stiffness), sp.Dashpot(dashpot.coefficient),
        sp.WhiteNoise(1e-4), stop=sp.Barrier(-0.002, 0.7),
    )  # fmt: skip
    two, single = (
        simulated(each, paths=1280, duration=6.0, window=(2.0, 6.0), step=3e-4, seed=seed, start="rest")
        for seed, each in ((1, one), (2, alone))
    )
    for name in ("x_mean", "x_mean_square", "v_mean_square"):
        for point in ("tip", "mode_1"):
            ours, exact = two[f"{point}_{name}"], single[name]
            assert abs(ours.value - exact.value) < 4.0 * np.hypot(ours.error, exact.error) + 0.003 * exact.value
            assert ours.error < 0.02 * ours.value
    for name in ("stop_impact_speed_mean", "stop_power", "damping_power"):
        assert abs(two[name].value - single[name].value) < 4.0 * np.hypot(two[name].error, single[name].error)
