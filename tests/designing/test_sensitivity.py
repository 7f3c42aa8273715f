"""Sensitivities against exact exponents."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.designing.approximation import leading
from springpot.designing.quantities import chosen_method
from springpot.designing.search import DesignProgress
from springpot.designing.sensitivities import BACKWARD, CENTRAL, FORWARD, Stencil, _difference, extrapolated

LINEAR = sp.Oscillator(natural_frequency=2.0, springpot=sp.Springpot(1.0, 0.4), barrier=None,
                       excitation=sp.WhiteNoise(3.0))  # fmt: skip
# order 1, elastic wall at the equilibrium: x^2 = q / (2 c k), v^2 = q / 2c, rate = sqrt(k) / pi, speed ~ sqrt(v^2)
EXPONENTS = {
    "x_mean_square": {"spring_stiffness": -1.0, "springpot_coefficient": -1.0, "white_noise_intensity": 1.0},
    "v_mean_square": {"spring_stiffness": 0.0, "springpot_coefficient": -1.0, "white_noise_intensity": 1.0},
    "impact_rate": {"spring_stiffness": 0.5, "springpot_coefficient": 0.0, "white_noise_intensity": 0.0},
    "impact_speed_mean": {"spring_stiffness": 0.0, "springpot_coefficient": -0.5, "white_noise_intensity": 0.5},
}


@pytest.mark.parametrize("method", ["theory", "exact", "averaging"])
def test_theory_has_the_exponents_of_the_closed_forms(method: str) -> None:
    wall = sp.Oscillator(natural_frequency=2.0, springpot=sp.Springpot(1.0, 0.4), excitation=sp.WhiteNoise(3.0))
    found = sp.sensitivity(wall, [*EXPONENTS], method=method)
    no_restitution = math.isnan(found.values["x_mean_square"]["barrier_restitution"])
    assert bool(found.warnings) == (method != "averaging") == no_restitution
    for quantity, row in EXPONENTS.items():
        for name, exponent in row.items():
            assert found.values[quantity][name] == pytest.approx(exponent, abs=1e-6)
            assert found.errors[quantity][name] < 1e-6


def test_theory_away_from_power_laws_equals_the_derivative_of_the_closed_form() -> None:
    """Elastic wall at b, order 1: rate = Omega exp(-b^2 / 2 s^2) / (2 pi Phi(-b / s)), s^2 = q / (2 c Omega^2)."""
    b, frequency, c, q = -0.7, 2.0, 0.4, 3.0
    wall = sp.Oscillator(frequency, sp.Springpot(1.0, c), sp.Barrier(b, free_side="above"), sp.WhiteNoise(q))
    u = b / math.sqrt(q / (2.0 * c * frequency**2))
    # d ln rate / d ln b = u d/du [-u^2/2 - ln Phi(-u)] = u (-u + phi(u) / Phi(-u))
    hazard = math.exp(-0.5 * u * u) / math.sqrt(2.0 * math.pi) / (0.5 * math.erfc(u / math.sqrt(2.0)))
    exact = u * (hazard - u)
    row = sp.sensitivity(wall, "impact_rate", method="exact").values["impact_rate"]
    assert row["barrier_position"] == pytest.approx(exact, abs=1e-6)
    assert row["springpot_coefficient"] == pytest.approx(exact / 2.0, abs=1e-6)
    assert row["white_noise_intensity"] == pytest.approx(-exact / 2.0, abs=1e-6)
    assert row["spring_stiffness"] == pytest.approx(0.5 * (1.0 + exact), abs=1e-6)


@pytest.mark.validation  # every day: the example of `sp.sensitivity`
def test_monte_carlo_has_the_exponents_within_three_standard_errors() -> None:
    wall = sp.Oscillator(natural_frequency=2.0, springpot=sp.Springpot(1.0, 0.4), excitation=sp.WhiteNoise(3.0))
    found = sp.sensitivity(wall, [*EXPONENTS], method="monte_carlo", paths=1000, duration=30.0, step=0.025)
    worst = max(
        abs(found.values[quantity][name] - exponent) / max(found.errors[quantity][name], 1e-4)
        for quantity, row in EXPONENTS.items()
        for name, exponent in row.items()
    )
    assert worst < 3.5
    assert found.gains["x_mean_square"]["springpot_coefficient"] > 2.0
    # paths are the same but for their scale and rounding
    assert found.gains["x_mean_square"]["white_noise_intensity"] > 1e10
    assert found.errors["x_mean_square"]["springpot_coefficient"] < 0.1
    assert "less variance" in found.report()
    assert found.to_xarray()["gain"].sel(quantity="x_mean_square", number="springpot_coefficient") > 2.0


def test_a_free_natural_frequency_moves_the_stiffness_as_its_square() -> None:
    wall = sp.Oscillator(sp.free("w", 2.0, (1.0, 4.0)), sp.Springpot(1.0, 0.4), excitation=sp.WhiteNoise(3.0))
    found = sp.sensitivity(wall, ["x_mean_square", "impact_rate"], method="exact")
    assert found.values["x_mean_square"] == {"w": pytest.approx(-2.0, abs=1e-6)}
    assert found.values["impact_rate"] == {"w": pytest.approx(1.0, abs=1e-6)}


def test_free_numbers_alone_are_moved_and_a_number_of_two_parts_moves_both() -> None:
    free = sp.free("c", 0.2, (0.1, 1.0))
    device = sp.System(
        sp.Mass(2.0), sp.Spring(8.0), one=sp.Dashpot(free), two=sp.Dashpot(free), noise=sp.WhiteNoise(1.0)
    )
    found = sp.sensitivity(device, "x_mean_square", method="theory")
    assert found.values["x_mean_square"] == {"c": pytest.approx(-1.0, abs=1e-6)}
    assert found.numbers == {"c": 0.2}


def test_a_number_at_the_end_of_its_range_has_a_one_sided_difference() -> None:
    wall = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=sp.Barrier(0.0, sp.free("r", 1.0, (0.5, 1.0))))
    edge = sp.sensitivity(wall, "v_mean_square", method="envelope").values["v_mean_square"]["r"]

    def at(r: float) -> float:
        wall = sp.Barrier(0.0, r)
        return sp.theory.envelope(sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=wall)).v_mean_square

    slope = (3.0 * at(1.0) + at(0.998) - 4.0 * at(0.999)) / 0.002
    assert edge == pytest.approx(slope / at(1.0), rel=1e-3)


@pytest.mark.parametrize("own", [CENTRAL, BACKWARD, FORWARD])
def test_differences_are_exact_to_the_orders_they_state(own: Stencil) -> None:
    steps = [0.04, 0.02, 0.01]
    differences = [
        np.array([sum(w * math.exp(3.0 * o * h) for o, w in zip(own.offsets, own.weights, strict=True)) / h])
        for h in steps
    ]
    value, error = extrapolated(differences, own.powers)
    assert abs(value[0] - 3.0) <= error[0] + 1e-12
    assert error[0] < 3e-4


def test_the_gain_is_that_of_the_covariance() -> None:
    random = np.random.default_rng(1)
    common, own = random.standard_normal((2, 100_000))
    a, b = 10.0 + common, 10.0 + 0.8 * common + 0.6 * own  # correlation 0.8: 1 / (1 - 0.8) = 5
    _, error, gain = _difference([(10.0, a, 0.0), (10.0, b, 0.0)], CENTRAL, 0.1)
    assert gain == pytest.approx(5.0, rel=0.02)
    assert error == pytest.approx(math.sqrt(0.4 / 100_000) / 10.0 / 0.2, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("spring", "x_mean"), "model must be a System"),
        ((LINEAR, []), "quantities must name at least one"),
        ((LINEAR, [1]), "quantities must be names"),
        ((LINEAR, "impact_rat"), "quantities must be among"),
        ((LINEAR, "force_on_groud_mean_square"), "; did you mean force_on_ground_mean_square"),
        ((sp.Oscillator(springpot=sp.Springpot(0.5, 0.0)), "x_mean"), "sensitivity needs a stationary state"),
    ],
)
def test_bad_input_is_one_sentence(arguments: tuple[Any, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        sp.sensitivity(*arguments)


def test_unknown_methods_and_changes_are_refused() -> None:
    with pytest.raises(ValueError, match="did you mean envelope"):
        sp.sensitivity(LINEAR, "x_mean_square", method="envelop")
    with pytest.raises(ValueError, match="change must be in"):
        sp.sensitivity(LINEAR, "x_mean_square", change=0.9)


def test_monte_carlo_is_chosen_where_no_method_is_recommended() -> None:
    lossy = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=sp.Barrier(-9.0, 0.7))
    assert chosen_method(lossy, None)[0] == "monte_carlo"
    assert "is a guess" in chosen_method(lossy, "theory")[1]


def test_monte_carlo_is_chosen_for_a_force_that_linear_theory_does_not_cover() -> None:
    to_a, to_b = ("ground", "a"), ("ground", "b")
    model = sp.System(
        sp.Mass(2.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(8.0, between=to_a), sp.Spring(1.0, between=to_b),
        sp.Dashpot(0.5, between=to_b), sp.WhiteNoise(1.0, on="ground"), sp.ParametricNoise(0.1, between=to_a),
        mount=sp.Dashpot(sp.free("c", 1.0, (0.5, 2.0)), between=to_a),
    )  # fmt: skip
    with pytest.raises(ValueError, match="a noise that multiplies an elongation is not covered in mount_force"):
        sp.sensitivity(model, "mount_force_mean_square", method="linear")
    found = sp.sensitivity(model, "mount_force_mean_square", paths=64, duration=20.0, step=0.05)
    assert found.method == "monte_carlo"
    assert leading([model], ("mount_force_mean_square",), DesignProgress(None, None, 1)) == "monte_carlo"


def test_a_force_changes_with_the_order_of_its_mount() -> None:
    """By linear theory, against its own difference, and by Monte Carlo."""

    def device(order: Any) -> sp.System:
        mount = sp.Springpot(order, 2.0)
        return sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=mount, shaking=sp.WhiteNoise(1.0, on="ground"))

    names = ["mount_force_mean_square", "acceleration_mean_square", "x_mean_square"]
    model = device(sp.free("order", 0.5, (0.1, 1.0)))
    found = sp.sensitivity(model, names)
    assert found.method == "linear"
    low, high = (sp.theory.linear(device(order)) for order in (0.499, 0.501))
    for name in names[:2]:
        square = name.removesuffix("_mean_square")
        ratio = math.log(high.mean_square(square) / low.mean_square(square)) / math.log(0.501 / 0.499)
        assert found.values[name]["order"] == pytest.approx(ratio, rel=1e-4)
    run = sp.sensitivity(model, names, method="monte_carlo", paths=2000, duration=40.0, step=0.05)
    for name in names[:2]:
        error = run.errors[name]["order"]
        assert error < 0.02
        assert abs(run.values[name]["order"] - found.values[name]["order"]) < 3.5 * error + 0.005
