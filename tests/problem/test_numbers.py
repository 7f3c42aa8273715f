"""The numbers of a system by their names: every one is listed, can be replaced, and has a unit."""

from __future__ import annotations

import math

import numpy as np
import pytest

import springpot as sp
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.problem.numbers import label_of, numbers_of, unit_of, with_numbers
from springpot.problem.parts import Force
from springpot.problem.system import KINDS, System
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of

RECORD = sp.RecordedExcitation((0.0, 0.5, 1.0), (0.0, 0.3, -0.1))
ONE_OF_EACH: tuple[object, ...] = (
    sp.Mass(0.5),
    sp.Spring(3.0),
    sp.PolynomialSpring((0.0, 0.2, 0.5)),
    sp.Dashpot(0.1),
    sp.PolynomialDashpot((0.1, 0.2, 0.3)),
    sp.VanDerPol(0.1),
    sp.Friction(0.1),
    sp.BoucWen(1.0, 0.1, 2.0, 0.8),
    sp.Jenkins(1.0, 0.1),
    sp.Springpot(0.5, 0.2),
    sp.FractionalMaxwell(sp.Springpot(0.4, 0.3), sp.Spring(2.0)),
    sp.Maxwell(1.0, 0.5),
    sp.PiezoelectricCircuit(0.1, 2.0, 0.5),
    sp.ResonantCircuit(0.1, 2.0, 0.5, 0.7),
    sp.WhiteNoise(0.1),
    sp.ColoredNoise(0.1, 0.5),
    sp.KanaiTajimiNoise(2.0, 0.3, 0.1),
    sp.CloughPenzienNoise(2.0, 0.3, 0.2, 0.4, 0.1),
    sp.Constant(0.1),
    sp.Harmonic(0.1, 2.0),
    RECORD,
    sp.SpectralExcitation((0.1, 1.0), (0.2, 0.1), 0.5),
    sp.PoissonImpulses(0.5, 0.1),
    sp.ParametricNoise(0.01),
    sp.Barrier(-2.0, 0.8),
)
SMOOTH = System(*ONE_OF_EACH)
KINDS_OF_FORCES = (
    sp.Friction, sp.VanDerPol, sp.ColoredNoise, sp.CloughPenzienNoise, sp.RecordedExcitation, sp.SpectralExcitation,
    sp.BoucWen, sp.Jenkins,
)  # fmt: skip
FEWER = System(*(part for part in ONE_OF_EACH if not isinstance(part, KINDS_OF_FORCES)))  # a kernel holds twelve forces
OTHERS = System(*(part for part in ONE_OF_EACH if isinstance(part, (sp.Mass, sp.Spring, *KINDS_OF_FORCES))))
SOFT = System(sp.Spring(1.0), sp.Contact(-1.0, 5.0), sp.Contact(1.0, 5.0, free_side="below"),
              yielding=sp.Barrier(-2.0, sp.PowerRestitution(0.7, 0.1)))  # fmt: skip
WARM = System(sp.Spring(1.0), sp.Springpot(0.5, 0.1), sp.ThermalNoise(0.5), sp.PiezoelectricCircuit(0.1, 2.0, 0.5))

MODAL = System(
    sp.Mass(2.0, at="first", participation=0.7), sp.Mass(1.0, at="second", participation=-0.2),
    *(sp.Spring(k, between=("ground", mode)) for mode, k in (("first", 3.0), ("second", 9.0))),
    sp.Point("tip", ("first", "second"), (1.0, -1.0)), sp.Inerter(0.3, between=("ground", "tip")),
)  # fmt: skip


def test_every_number_of_every_part_can_be_replaced() -> None:
    for system in (SMOOTH, SOFT, WARM, MODAL):
        for name, value in numbers_of(system).items():
            other = with_numbers(system, {name: 0.75 * value + 0.01})
            changed = {key for key, number in numbers_of(other).items() if number != numbers_of(system)[key]}
            assert changed == {name}
            assert other.names == system.names
    kinds = {type(part) for system in (SMOOTH, SOFT, WARM, MODAL) for part in system.parts}
    assert kinds | {Force} == {*KINDS.values()}
    assert with_numbers(SMOOTH, numbers_of(SMOOTH)) == SMOOTH


def test_numbers_are_replaced_together() -> None:
    """Walls that pass each other's place one after the other, and coefficients that are all 0 in between."""
    room = System(sp.Spring(1.0), lower=sp.Barrier(-1.0), upper=sp.Barrier(1.0, free_side="below"))
    moved = with_numbers(room, {"parts.lower.position": 2.0, "parts.upper.position": 3.0})
    assert [wall.position for wall in moved.of(sp.Barrier)] == [2.0, 3.0]
    bent = System(sp.Spring(1.0), bend=sp.PolynomialSpring((0.0, 0.0, 1.0)))
    swapped = with_numbers(bent, {"parts.bend.coefficients.3": 0.0, "parts.bend.coefficients.1": 2.0})
    assert swapped.parts[1] == sp.PolynomialSpring((2.0, 0.0, 0.0))
    assert with_numbers(bent, {"parts.bend.coefficients.3": 0.0}).names == ("spring",)


def test_units_are_of_the_mass_or_per_unit_mass() -> None:
    """A force over the mass is an acceleration: with one kilogram the dimensions differ by kg alone."""
    per_mass = System(*ONE_OF_EACH[1:])
    found = {name: (unit_of(SMOOTH, name), unit_of(per_mass, name)) for name in numbers_of(per_mass)}
    assert found["parts.spring.stiffness"] == ("N m-1", "s-2")
    assert found["parts.polynomial_spring.coefficients.3"] == ("N m-3", "m-2 s-2")
    assert found["parts.polynomial_dashpot.coefficients.2"] == ("N s2 m-2", "m-1")
    assert found["parts.polynomial_dashpot.coefficients.3"] == ("N s3 m-3", "m-2 s")
    assert found["parts.fractional_maxwell.springpot.coefficient"] == ("N s^alpha m-1", "s^(alpha-2)")
    assert found["parts.white_noise.intensity"] == ("N2 s", "m2 s-3")
    assert found["parts.kanai_tajimi_noise.intensity"] == ("m2 s-3", "m2 s-3")  # of the ground
    assert found["parts.barrier.restitution"] == ("1", "1")
    # what has no unit is known to have none
    assert {name.rpartition(".")[2] for name, (unit, _) in found.items() if unit == "1"} == {
        "order", "base_damping", "damping", "restitution", "scale", "exponent", "beta",
    }  # fmt: skip
    assert unit_of(SOFT, "parts.contact_1.exponent") == "1"
    assert label_of("parts.fractional_maxwell.springpot.order") == "fractional_maxwell_springpot_order"


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("parts.sprng.stiffness", "the system has no part 'sprng'; did you mean spring?"),
        ("parts.wall.position", "the system has no part 'wall': its parts are mass, spring, "),
        (
            "parts.barrier.free_side",
            "barrier (barrier) has no number 'free_side'; its numbers are position and restitution.",
        ),
        ("parts.barrier.positin", "barrier (barrier) has no number 'positin'; did you mean position?"),
        (
            "parts.recorded_excitation.values",
            "recorded_excitation (recorded_excitation) has no number 'values'; its numbers are scale.",
        ),
        ("restitution", "'restitution' must be parts.<name>.<number>; did you mean parts.barrier.restitution?"),
        ("parts.barrier", "'parts.barrier' must be parts.<name>.<number>; did you mean parts.barrier."),
    ],
)
def test_a_number_that_is_not_there(name: str, sentence: str) -> None:
    with pytest.raises(ValueError, match=r"^.") as caught:
        with_numbers(SMOOTH, {name: 1.0})
    assert str(caught.value).startswith(sentence)


def test_a_part_that_refuses_a_value_is_named() -> None:
    with pytest.raises(ValueError, match=r"^barrier\.restitution must be in \[0, 1\], not 1\.5\. "):
        with_numbers(SMOOTH, {"parts.barrier.restitution": 1.5})
    with pytest.raises(ValueError, match=r"^fractional_maxwell\.springpot\.order must be in \[0, 1\], not 2\. "):
        with_numbers(SMOOTH, {"parts.fractional_maxwell.springpot.order": 2.0})


PARTS_OF_RUNS = [
    FEWER, OTHERS, SOFT, WARM, System(sp.Spring(1.0), sp.PiezoelectricCircuit(0.5, 2.0, 1.0), sp.WhiteNoise(1.0)),
    System(sp.Spring(1.0), sp.Dashpot(0.1), sp.ColoredNoise(1.0, 0.5), sp.Barrier(-1.0, 0.5),
           b=sp.Barrier(1.0, free_side="below")),
    System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0), sp.Contact(-1.0, 5.0),
           push=sp.Force(lambda t, x, v: 0.1 * x)),
    System(sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.0, 1.0), sp.VanDerPol(0.1), sp.ParametricNoise(0.1)),
]  # fmt: skip


@pytest.mark.parametrize("system", PARTS_OF_RUNS)
def test_the_results_of_a_run_are_among_those_foretold(system: System) -> None:
    """By name, whatever the numbers are; what is foretold but missing depends on a number that is zero or negative."""
    few = simulation_of(plan_of(system, paths=1, start="rest", step=0.005, duration=0.1))
    found = {*samples_of(few, np.ones((1, len(few.parts.columns))))}
    foretold = {*possible_results(system)}
    assert found <= foretold
    allowed = {
        "damping_force_mean",
        "damping_power",
        "damping_virial",
        "amplitude_mean_square",
        "energy_residual",
        "amplitude_mean_square_end",
    }
    assert foretold - found <= (allowed if system is PARTS_OF_RUNS[-1] else set())
    assert all(unit_of_result(system, name) for name in foretold)


@pytest.mark.parametrize("order", [0.0955, 0.25, 0.8, 1.0])
def test_a_mount_has_the_stiffness_and_the_loss_factor_that_were_measured(order: float) -> None:
    spring, springpot = sp.Springpot.from_loss_factor(order, 0.15, 136e3, 38.0)
    found = spring.stiffness + springpot.modulus(2j * math.pi * 38.0)
    assert found == pytest.approx(136e3 * (1.0 + 0.15j), rel=1e-12)
    assert spring.stiffness >= 0.0


def test_an_order_below_that_of_the_springpot_alone_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^order must be in \[0\.0947\d*, 1\], not 0\.09\. Below 0\.0948 a springpot"):
        sp.Springpot.from_loss_factor(0.09, 0.15, 136e3, 38.0)
    with pytest.raises(ValueError, match=r"^loss_factor must be in \(0, "):
        sp.Springpot.from_loss_factor(0.5, 0.0, 136e3, 38.0)
