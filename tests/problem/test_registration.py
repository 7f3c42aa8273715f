"""What each kind of part states of itself: iterated over, so that a new kind is tested too."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import get_args

import numpy as np
import pytest

import springpot as sp
from springpot.problem.coordinates import Coordinates
from springpot.problem.parts.contacts import SoftStop
from springpot.problem.parts.excitations import Excitation
from springpot.problem.parts.registration import Number, Part, Power, in_words
from springpot.problem.parts.walls import Restitution
from springpot.problem.system import KINDS
from tests.problem.test_numbers import SMOOTH, SOFT, WARM

EXAMPLES: tuple[Part, ...] = (
    *SMOOTH.parts, *SOFT.parts, *WARM.parts, sp.Force(lambda t, x, v: -x), sp.Inerter(3.0),
    sp.Point("tip", ("first", "second"), (1.0, -1.0)),
)  # fmt: skip
EACH = {type(part): part for part in EXAMPLES}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_every_kind_states_what_it_is(kind: type[Part]) -> None:
    part = EACH[kind]
    assert {own.name for own in fields(kind)} == {*kind.numbers}  # type: ignore[arg-type]
    assert {*part.powers} <= {*get_args(Power)}
    assert all(isinstance(getattr(part, name), bool) for name in (
        "is_linear", "remembers", "dissipates", "is_thermal", "is_odd", "of_ground", "has_function"
    ))  # fmt: skip
    assert part.said
    assert part.glyph
    assert kind.__name__ in sp.__all__
    assert getattr(sp, kind.__name__) is kind


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_part_is_divided_by_the_mass_as_its_units_say(kind: type[Part]) -> None:
    """Twice by 4 is once by 16; a number changes where its unit does."""
    part = EACH[kind]
    if part.of_ground:
        assert not part.per_mass(2.0).of_ground
        assert part.per_mass(2.0) == part.per_mass(3.0)
        return
    whole, halved = part.per_mass(16.0), part.per_mass(4.0)
    assert halved.per_mass(4.0) == whole
    for name, number in kind.numbers.items():
        if isinstance(number, Number) and not number.per and number.unit != "1":
            same = getattr(halved, name) == getattr(part, name)
            assert same == (number.unit_of(True) == number.unit_of(False)), name


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_part_acts_along_a_row_that_it_sees_or_pushes_a_point(kind: type[Part]) -> None:
    part, at = EACH[kind].alone(), Coordinates.of_masses(["mass"])
    sees, pushes = part.elongation(at) is not None, part.push(at) is not None
    assert not (sees and pushes)
    assert (sees or pushes) == (kind not in (sp.Mass, sp.Point, sp.ThermalNoise))
    assert sees or not part.has_ends
    assert not part.noise or isinstance(part, Excitation)
    if isinstance(part, Excitation):
        assert part.has_density == (pushes and bool(part.noise))
        assert part.is_white == (pushes and part.noise in ("white", "impulses"))


@pytest.mark.parametrize(
    "part",
    [sp.PolynomialSpring((2.0, 0.0, 3.0)), sp.Contact(-0.3, 5.0), sp.Contact(0.3, 5.0, exponent=2.0)],
    ids=["spring", "contact_below", "contact_above"],
)
def test_energy_is_the_work_of_the_nonlinear_force(part: Part) -> None:
    x = np.array([-0.9, -0.31, 0.2, 0.7])
    force = sp.System(part, sp.Spring(1.0)).potential.force(x) - (1.0 + part.static_stiffness) * x
    work = (part.energy_beside(x + 1e-6) - part.energy_beside(x - 1e-6)) / 2e-6
    assert work == pytest.approx(force, abs=1e-8)


def test_mean_and_largest_stiffness_of_a_spring() -> None:
    spring = sp.PolynomialSpring((2.0, 0.5, 3.0))
    u = 0.4 * np.linspace(-8.0, 8.0, 4001)
    weight = np.exp(-0.5 * (u / 0.4) ** 2)
    stiffness = 2.0 + u + 9.0 * u**2
    assert spring.mean_stiffness(0.4) == pytest.approx(float(weight @ stiffness / weight.sum()), rel=1e-9)
    assert spring.largest_stiffness(0.4) == pytest.approx(2.0 + 0.4 + 9.0 * 0.16)


def test_parts_of_the_memory_have_a_modulus_and_its_slopes() -> None:
    for part in EXAMPLES:
        if (
            part.is_linear
            and "damping" in part.powers
            and isinstance(part, sp.Maxwell | sp.PiezoelectricCircuit | sp.ResonantCircuit)
        ):
            for (number, slope), name in zip(part.slopes(0.3 + 0.4j), _order(part), strict=True):
                up, down = (type(part)(**{**_values(part), name: number * (1.0 + e)}) for e in (1e-6, -1e-6))
                assert slope == pytest.approx((up.modulus(0.3 + 0.4j) - down.modulus(0.3 + 0.4j)) / (2e-6 * number))


def _values(part: Part) -> dict[str, float]:
    return {name: getattr(part, name) for name, number in part.numbers.items() if number}


def _order(part: Part) -> list[str]:
    return [name for number, _ in part.slopes(1.0) for name, value in _values(part).items() if value == number]


_YES_OR_NO = ("is_linear", "remembers", "dissipates", "is_thermal", "is_odd")


def test_what_a_class_forgets_is_named_when_it_is_made() -> None:
    with pytest.raises(TypeError, match="Half must state glyph and is_odd, as every part does"):

        class Half(Part):
            said, powers = "half", ("damping",)
            is_linear, remembers, dissipates, is_thermal = True, False, True, True

    whole = {"said": "half", "glyph": "spring", **dict.fromkeys(_YES_OR_NO, False), "__annotations__": {}}
    for family, powers, words in (
        (Part, ("inertia",), "must state inertia"),
        (Part, ("stored",), "must state force_coefficients"),
        (SoftStop, ("stop",), "must state soft_stop"),
        (Part, ("lost",), "powers must be of inertia, stored, .* not lost"),
    ):
        with pytest.raises(TypeError, match=words):
            type("Half", (family,), {**whole, "powers": powers})

    with pytest.raises(TypeError, match=r"Bare\.stiffness must say its symbol, words and unit"):

        class Bare(Part):
            said, glyph, powers = "bare", "spring", ("damping",)
            is_linear, remembers, dissipates, is_thermal, is_odd = True, False, True, True, True

            stiffness: float

    with pytest.raises(TypeError, match="Wordless must state words, as every law of restitution does"):

        class Wordless(Restitution):
            @staticmethod
            def formula(speed: float) -> float:
                return 0.5


def test_an_inerter_adds_to_the_inertia() -> None:
    """The ground accelerates the mass alone."""
    device = sp.System(sp.Mass(2.0), sp.Inerter(3.0), sp.Spring(80.0), sp.Dashpot(1.5), sp.WhiteNoise(0.5, on="ground"))
    assert (device.mass, device.inertia, device.natural_frequency) == (2.0, 5.0, 4.0)
    assert sp.explain(device).startswith("2 x'' + 3 x'' + 80 x + 1.5 x' = -2 w(t)")
    found = sp.theory.exact(device)
    assert found.x_mean_square == pytest.approx(4.0 * 0.5 / (2.0 * 1.5 * 80.0))
    assert found.v_mean_square == pytest.approx(4.0 * 0.5 / (2.0 * 1.5 * 5.0))
    per_mass = sp.System(sp.Inerter(1.5), sp.Spring(40.0))
    assert per_mass.natural_frequency == pytest.approx(4.0)
    record = sp.RecordedExcitation((0.0, 1.0), (0.0, 2.0))
    (pushed,) = sp.System(sp.Mass(2.0), sp.Inerter(3.0), sp.Spring(1.0), record).per_unit_mass.of(sp.RecordedExcitation)
    assert pushed.values == pytest.approx((0.0, -0.8))
    assert math.isclose(float(device.potential.force(1.0)), 16.0)


def test_units_in_sentences() -> None:
    assert [in_words(unit) for unit in ("N", "m s-2", "N2 s2", "m2 s-3")] == ["N", "m/s^2", "N^2 s^2", "m^2/s^3"]
