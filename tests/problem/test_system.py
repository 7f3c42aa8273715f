"""Systems of parts: names, units, what is refused, and when a system is an Oscillator."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.problem.file import schema
from springpot.problem.system import KINDS
from springpot.theory.registry import METHODS
from tests.problem.test_numbers import MODAL

KICK = sp.WhiteNoise(0.02)


def test_parts_are_called_by_their_kind_or_as_one_likes() -> None:
    system = sp.System(
        sp.Spring(80.0), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below"), shaker=sp.WhiteNoise(0.02)
    )
    assert system.names == ("spring", "barrier_1", "barrier_2", "shaker")
    assert system.name_of(system.parts[2]) == "barrier_2"
    with pytest.raises(ValueError, match="spring is the name of two parts"):
        sp.System(sp.Spring(80.0), spring=sp.Spring(1.0))


def test_the_mass_moves_on_the_side_of_zero() -> None:
    """A gap on either side; at 0 the paper's x >= 0; a preload has to be stated, and is named."""
    for kind in (
        lambda place, **side: sp.Barrier(place, 0.7, **side),
        lambda place, **side: sp.Contact(place, 50.0, **side),
    ):
        assert [kind(place).free_side for place in (-0.006, 0.0, -0.0, 0.006)] == ["above", "above", "above", "below"]
        assert kind(0.006, free_side="above").free_side == "above"
        gap = sp.free("gap", 0.006, (-0.01, 0.01))
        assert [kind(-gap).free_side, kind(gap).free_side] == ["above", "below"]
        device = sp.System(sp.Mass(2.0), sp.Spring(80.0), low=kind(-0.006), high=kind(0.006))
        assert "preload" not in sp.explain(device)
        pressed = sp.System(sp.Mass(2.0), sp.Spring(80.0), stop=kind(0.006, free_side="above"))
        assert "preload: the mass is pressed against it with 0.48 N" in sp.explain(pressed)
        assert sp.read_system({"parts": sp.System(*device.parts).to_dict()["parts"]}) == sp.System(*device.parts)
    assert sp.Oscillator.from_numbers(position=0.3) == sp.Oscillator(barrier=sp.Barrier(0.3, free_side="below"))


def test_an_oscillator_is_a_system_and_back() -> None:
    for asked in (
        {},
        {"natural_frequency": 3.0, "springpot": sp.Springpot(0.3, 0.5), "barrier": sp.Barrier(-0.5, 0.8, "below"),
         "excitation": sp.WhiteNoise(2.0)},
        {"barrier": None, "springpot": sp.Springpot(0.0, 2.0)},
    ):  # fmt: skip
        assert sp.Dimensionless.of(sp.Oscillator(**asked)) == sp.Dimensionless(**asked)


def test_a_device_in_si_units_is_the_oscillator_of_from_device() -> None:
    device = sp.System(
        sp.Mass(0.05), sp.Spring(1234.0), sp.Dashpot(0.2), sp.Barrier(-0.004, 0.6),
        sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    )  # fmt: skip
    same = sp.Oscillator.from_device(
        mass=0.05, stiffness=1234.0, springpot=(1.0, 0.2), gap=0.004, restitution=0.6, psd=0.01, psd_unit="g2/Hz"
    )
    found, whole = sp.Dimensionless.of(device), sp.Dimensionless.of(same)
    assert found.barrier == whole.barrier
    assert found.natural_frequency == pytest.approx(whole.natural_frequency, rel=1e-14)
    assert found.springpot.coefficient == pytest.approx(whole.springpot.coefficient, rel=1e-14)
    assert found.excitation.intensity == pytest.approx(whole.excitation.intensity, rel=1e-14)
    pushed = sp.Dimensionless.of(sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.WhiteNoise.from_psd(3.0, "N2/Hz", sides=2)))
    assert (pushed.natural_frequency, pushed.excitation.intensity) == (2.0, 3.0 / 4.0)


def test_parts_of_one_kind_add_up() -> None:
    parts = sp.Spring(3.0), sp.PolynomialSpring((1.0,)), sp.Dashpot(0.1), sp.Springpot(1.0, 0.2), sp.WhiteNoise(1.0)
    found = sp.Dimensionless.of(sp.System(*parts, sp.WhiteNoise(2.0, on="ground")))
    assert found.natural_frequency == 2.0
    assert found.springpot.coefficient == pytest.approx(0.3)
    assert found.excitation.intensity == 3.0


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0))), "polynomial_spring cannot be part of an Oscillator"),
        ((sp.Spring(1.0), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), "barrier_2 is a second wall"),
        ((sp.Spring(1.0), sp.Springpot(0.5, 1.0), sp.Dashpot(1.0)), "orders 0.5 and 1 are more than one"),
        ((sp.Spring(-1.0), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), "barrier_2 is a second wall"),
        ((sp.Dashpot(1.0),), "the stiffness of the springs is 0, not positive"),
        ((sp.Spring(1.0), sp.ColoredNoise(1.0, 1.0)), "colored_noise cannot be part"),
    ],
)
def test_what_is_no_oscillator_says_which_part(parts: tuple[object, ...], sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        sp.Dimensionless.of(sp.System(*parts, KICK))


BAD = [
    (lambda: sp.System(), ValueError, "a system must have parts"),
    (lambda: sp.System(sp.Spring), TypeError, r"made with their numbers, as Spring\(...\), not the class"),
    (lambda: sp.System(sp.Dimensionless()), TypeError, "must be objects such as Spring"),
    (lambda: sp.System(80.0), TypeError, "not 80.0"),
    (lambda: sp.System(sp.Spring(1.0), stop=3), TypeError, "not 3"),
    (lambda: sp.System(sp.Mass(1.0)), ValueError, "must have parts beside a mass"),
    (lambda: sp.System(sp.Mass(1e-30), sp.Spring(1e40)), ValueError, "divided by the mass must be as without one"),
    (lambda: sp.System(sp.Spring(-1.0), KICK), ValueError, "falls without limit to the left and right"),
    (lambda: sp.System(sp.Spring(1.0), sp.PolynomialSpring((0.0, 1.0))), ValueError, "falls without limit to the left"),
    (lambda: sp.System(sp.Constant(1.0), sp.Barrier(0.0)), ValueError, "falls without limit to the right"),
    (
        lambda: sp.System(sp.Barrier(1.0, free_side="above"), sp.Barrier(0.0, free_side="below")),
        ValueError,
        "x >= 1 and x <= 0 cannot both",
    ),
    (lambda: sp.System(sp.Barrier(1.0), sp.Barrier(2.0)), ValueError, "barrier_2 at 2 must not lie behind barrier_1"),
    (lambda: sp.System(sp.Barrier(0.0), sp.Barrier(-1.0)), ValueError, "barrier_2 at -1 must not lie behind barrier_1"),
    (lambda: sp.System(sp.Barrier(0.0), sp.Contact(-1.0, 5.0)), ValueError, "contact at -1 must not lie behind a wall"),
    (lambda: sp.System(sp.ThermalNoise(1.0), sp.ThermalNoise(1.0)), ValueError, "one ThermalNoise at most"),
    (lambda: sp.System(sp.Spring(1.0), sp.ThermalNoise(1.0), sp.VanDerPol(1.0)), ValueError, "van_der_pol cannot be"),
    (lambda: sp.Mass(0.0), ValueError, r"value must be in \(0, 1e\+50\], not 0"),
    (lambda: sp.Spring(math.inf), ValueError, "stiffness must be in"),
    (lambda: sp.PolynomialSpring(1.0), TypeError, "coefficients must be a tuple of numbers, not 1.0"),
    (lambda: sp.PolynomialSpring(()), ValueError, "coefficients must be 1 to 9 numbers, not 0"),
    (lambda: sp.PolynomialSpring((0.0, 0.0)), ValueError, "coefficients must not all be 0"),
    (lambda: sp.PolynomialSpring((1.0, "2")), TypeError, r"coefficients\[1\] must be a real number"),
    (lambda: sp.Barrier(0.0, lambda v: v.unknown), ValueError, "function of the speed, but at 1 m/s it failed"),
    (lambda: sp.Barrier(0.0, lambda v: "0.5"), TypeError, "restitution of an impact at 1 m/s must be a real number"),
    (lambda: sp.Barrier(0.0, float), TypeError, "or a function of the speed, not the type float"),
    (lambda: sp.PowerRestitution(0.5, 0.0), ValueError, "speed must be"),
    (lambda: sp.Dimensionless(barrier=sp.Barrier(0.0, sp.PowerRestitution(0.5, 1.0))), ValueError, "a number as rest"),
    (lambda: sp.Dashpot(-1.0), ValueError, "coefficient must be in"),
    (lambda: sp.PolynomialDashpot((1.0, -1.0)), ValueError, "must not end with -1"),
    (lambda: sp.VanDerPol(0.1, 0.0), ValueError, "length must be a finite number greater than 0|length must be in"),
    (lambda: sp.FractionalMaxwell(sp.Spring(1.0), sp.Spring(1.0)), TypeError, "springpot must be a Springpot"),
    (
        lambda: sp.FractionalMaxwell(sp.Springpot(0.0, 1.0), sp.Spring(1.0)),
        ValueError,
        "an order and a coefficient above 0",
    ),
    (
        lambda: sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(-1.0)),
        ValueError,
        "positive stiffness in a series",
    ),
    (lambda: sp.Maxwell(1.0, 0.0), ValueError, "coefficient must be"),
    (lambda: sp.Contact(0.0, 1.0, exponent=0.5), ValueError, "exponent must be in"),
    (lambda: sp.Contact(0.0, 1.0, dissipation=-0.5), ValueError, "dissipation must be in"),
    (lambda: sp.Contact(0.0, 1.0, free_side="left"), ValueError, "free_side must be 'above'"),
    (lambda: sp.PiezoelectricCircuit(1.0, 0.0, 1.0), ValueError, "resistance must be"),
    (lambda: sp.WhiteNoise(1.0, on="the roof"), ValueError, "on must be 'mass'"),
    (lambda: sp.System(sp.Spring(1.0), sp.WhiteNoise(1.0, on="roof")), ValueError, "on of white_noise must be 'mass'"),
    (lambda: sp.WhiteNoise.from_psd(1.0, "N/Hz"), ValueError, "psd_unit must be|unit must be"),
    (lambda: sp.ColoredNoise(1.0, 0.0), ValueError, "correlation_time must be"),
    (lambda: sp.KanaiTajimiNoise(1.0, 2.0, 1.0), ValueError, "damping must be in"),
    (lambda: sp.Harmonic(1.0, -1.0), ValueError, "frequency must be"),
    (lambda: sp.PoissonImpulses(0.0, 1.0), ValueError, "rate must be"),
    (lambda: sp.ParametricNoise(True), TypeError, "intensity must be a real number"),
    (lambda: sp.ThermalNoise("hot"), TypeError, "temperature must be a real number"),
    (
        lambda: sp.Dimensionless(excitation=sp.WhiteNoise(1.0, on="ground")),
        ValueError,
        "excitation must act on the mass",
    ),
    (lambda: sp.Constant(math.nan), ValueError, "force must be"),
]


@pytest.mark.parametrize(("make", "kind", "sentence"), BAD)
def test_bad_systems_are_refused_in_one_sentence(make, kind, sentence) -> None:
    with pytest.raises(kind, match=sentence) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_dividing_by_the_mass_keeps_energies_per_unit_mass() -> None:
    system = sp.System(
        sp.Mass(2.0),
        sp.Spring(8.0),
        sp.PiezoelectricCircuit(0.5, 2.0, 1.0),
        sp.Contact(-1.0, 6.0),
        sp.ThermalNoise(3.0),
        sp.Harmonic(4.0, 1.0),
        sp.PoissonImpulses(1.0, 4.0),
        sp.ParametricNoise(4.0),
        sp.ColoredNoise(4.0, 1.0),
        sp.KanaiTajimiNoise(1.0, 0.5, 4.0),
        sp.Constant(2.0),
        sp.Maxwell(2.0, 4.0),
    )
    unit = dict(system.per_unit_mass.named())
    assert "mass" not in unit
    assert unit["spring"].stiffness == 4.0
    assert unit["piezoelectric_circuit"].coupling == pytest.approx(0.5 / math.sqrt(2.0))
    assert unit["contact"].stiffness == 3.0
    assert unit["thermal_noise"].temperature == 1.5
    assert unit["harmonic"].amplitude == 2.0
    assert unit["poisson_impulses"].mean_square == 1.0
    assert unit["parametric_noise"].intensity == 1.0
    assert unit["colored_noise"].variance == 1.0
    assert unit["kanai_tajimi_noise"].intensity == 4.0  # of the ground's acceleration
    assert unit["constant"].force == 1.0
    assert unit["maxwell"] == sp.Maxwell(1.0, 2.0)
    assert float(system.potential.force(-2.0)) == pytest.approx(-8.0 - 1.0 - 3.0)
    assert float(system.potential.energy(-2.0)) == pytest.approx(8.0 + 2.0 + 3.0 / 2.5)


EVERYTHING = sp.System(
    sp.Mass(0.2),
    sp.Spring(80.0),
    sp.PolynomialSpring((0.0, 0.1, 4e5)),
    sp.Dashpot(0.4),
    sp.Springpot(0.5, 1.2),
    sp.PolynomialDashpot((0.0, 2.0)),
    sp.VanDerPol(0.1, 0.5),
    sp.FractionalMaxwell(sp.Springpot(0.4, 2.0), sp.Spring(3.0)),
    sp.Maxwell(1.0, 2.0),
    sp.PiezoelectricCircuit(1e-3, 1e5, 1e-7),
    sp.ResonantCircuit(1e-3, 1e3, 1e-7, 10.0),
    sp.Contact(-0.002, 1e6, 1.5, 0.1),
    sp.Barrier(-0.003, 0.7),
    sp.WhiteNoise(0.02),
    sp.WhiteNoise(0.3, on="ground"),
    sp.ColoredNoise(1.0, 0.1),
    sp.KanaiTajimiNoise(3.0, 0.4, 1.0),
    sp.Constant(-1.0),
    sp.Harmonic(0.1, 20.0),
    sp.PoissonImpulses(1.0, 0.2),
    sp.ParametricNoise(0.1),
    sp.Friction(0.01),
    sp.BoucWen(20.0, 0.1, 2.0, 0.8),
    sp.Jenkins(20.0, 0.1),
    sp.RecordedExcitation((0.0, 0.5, 1.0), (0.0, 0.3, -0.1)),
    sp.SpectralExcitation.from_psd((20.0, 2000.0), 0.02, "g2/Hz", scale=0.5),
    stop=sp.Barrier(0.003, 0.7, "below"),
)


MODULATED = sp.System(
    sp.Spring(1.0),
    sp.CloughPenzienNoise(3.0, 0.4, 0.3, 0.5, 1.0, envelope=sp.JenningsHousnerEnvelope(1.0, 3.0, 0.5)),
    sp.WhiteNoise(0.2, envelope=sp.ExponentialEnvelope(0.2, 0.6, 2.0)),
    sp.ColoredNoise(1.0, 0.1, envelope=sp.TabulatedEnvelope((0.0, 1.0, 2.5), (0.0, 1.5, 0.0))),
)


def test_a_file_gives_the_same_system_back(tmp_path) -> None:
    place = tmp_path / "device.toml"
    place.write_text(sp.to_toml(EVERYTHING), encoding="utf-8")
    assert sp.read_system(place) == EVERYTHING
    yielding = sp.System(sp.Spring(1.0), sp.Barrier(-1.0, sp.PowerRestitution(sp.free("r", 0.7, (0.1, 0.9)), 0.1)))
    place.write_text(sp.to_toml(yielding), encoding="utf-8")
    assert 'restitution = { law = "power", restitution = { free = "r"' in place.read_text(encoding="utf-8")
    assert sp.read_system(place) == yielding
    assert sp.read_system({"parts": yielding.to_dict()["parts"]}) == yielding
    thermal = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.ThermalNoise(1.0 / 3.0))
    place.write_text(sp.to_toml(thermal), encoding="utf-8")
    assert sp.read_system(str(place)) == thermal
    place.write_text(sp.to_toml(MODAL), encoding="utf-8")
    assert 'of = ["first", "second"]\nshares = [1.0, -1.0]' in place.read_text(encoding="utf-8")
    assert sp.read_system(place) == MODAL
    place.write_text(sp.to_toml(MODULATED), encoding="utf-8")
    assert 'envelope = { form = "jennings_housner", rise = 1.0, fall = 3.0, decay = 0.5 }' in place.read_text(
        encoding="utf-8"
    )
    assert sp.read_system(place) == MODULATED == sp.read_system({"parts": MODULATED.to_dict()["parts"]})
    kinds = {type(part) for part in (*EVERYTHING.parts, *thermal.parts, *MODAL.parts, *MODULATED.parts)}
    assert kinds == {*KINDS.values()} - {sp.Force}  # no kind is forgotten here


def test_a_function_has_no_place_in_a_file() -> None:
    own = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), magnet=sp.Force(lambda t, x, v: 0.1 / (x - 9.0) ** 2))
    with pytest.raises(ValueError, match="magnet cannot be written to a file, because it has a function"):
        sp.to_toml(own)
    with pytest.raises(ValueError, match=r"parts\[0\].kind must be one of"):
        sp.read_system({"parts": [{"kind": "force"}]})


def test_the_schema_is_that_of_the_docs_and_knows_every_kind() -> None:
    place = Path(__file__).parents[2] / "docs" / "system.schema.json"
    assert json.loads(place.read_text(encoding="utf-8")) == schema()
    kinds = [table["properties"]["kind"]["const"] for table in schema()["properties"]["parts"]["items"]["oneOf"]]
    assert sorted({*kinds}) == sorted({*KINDS} - {"force"})


def test_a_white_noise_by_its_density() -> None:
    spring = {"kind": "spring", "stiffness": 1.0}
    found = sp.read_system({"parts": [spring, {"kind": "white_noise", "psd": 0.01, "psd_unit": "g2/Hz"}]})
    assert found.parts[1] == sp.WhiteNoise.from_psd(0.01, "g2/Hz")


SPRING = {"kind": "spring", "stiffness": 80.0}


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ({}, "it must have a table [[parts]] for each part"),
        ({"parts": []}, "it must have a table [[parts]] for each part"),
        ({"parts": [SPRING], "mass": 1.0}, "'mass' is not a key of it"),
        ({"parts": [3]}, "parts[0] must be a table with a kind, not 3"),
        ({"parts": [{"stiffness": 1.0}]}, "parts[0].kind must be one of"),
        ({"parts": [{"kind": "sprng"}]}, "not 'sprng'; did you mean spring?"),
        ({"parts": [{"kind": "spring"}]}, "parts[0] (spring) needs stiffness."),
        (
            {"parts": [SPRING | {"stiffness_": 1.0}]},
            "'stiffness_' is not a key of parts[0] (spring); did you mean stiffness?",
        ),
        (
            {"parts": [SPRING, {"kind": "barrier", "side": "above"}]},
            "'side' is not a key of parts[1] (barrier); did you mean free_side?",
        ),
        ({"parts": [SPRING | {"stiffness": "80"}]}, "parts[0] (spring).stiffness must be a real number"),
        (
            {"parts": [SPRING, {"kind": "barrier", "restitution": 2.0}]},
            "parts[1] (barrier).restitution must be in [0, 1]",
        ),
        (
            {"parts": [SPRING, {"kind": "barrier", "restitution": {"restitution": 0.5, "speed": 1.0}}]},
            "parts[1] (barrier).restitution.law must be one of power, not None.",
        ),
        (
            {"parts": [SPRING, {"kind": "barrier", "restitution": {"law": "power", "speed": 1.0}}]},
            "parts[1] (barrier).restitution needs restitution.",
        ),
        ({"parts": [SPRING | {"name": "my spring"}]}, "parts[0].name must be a word of letters, digits and _"),
        ({"parts": [SPRING | {"name": "a"}, SPRING | {"name": "a"}]}, "a is the name of two parts"),
        ({"parts": [{"kind": "spring", "stiffness": -1.0}]}, "the potential must hold the mass"),
        (
            {"parts": [{"kind": "fractional_maxwell", "springpot": 1.0, "spring": {}}]},
            "(fractional_maxwell).springpot must be a table of its numbers",
        ),
        (
            {"parts": [{"kind": "fractional_maxwell", "springpot": {"order": 0.5}, "spring": {}}]},
            "(fractional_maxwell).springpot needs coefficient.",
        ),
        ({"parts": [SPRING, {"kind": "white_noise", "psd": 1.0}]}, "parts[1] (white_noise) needs psd_unit."),
        (
            {"parts": [SPRING, {"kind": "white_noise", "psd": 1.0, "psd_unit": "V"}]},
            "parts[1] (white_noise).psd_unit must be",
        ),
        ({"parts": [{"kind": "polynomial_spring", "coefficients": "1"}]}, "coefficients must be a tuple of numbers"),
    ],
)
def test_a_bad_file_says_where(content, sentence: str) -> None:
    with pytest.raises(ValueError, match=re.escape(sentence)) as caught:
        sp.read_system(content)
    assert str(caught.value).startswith("the system is not right: ")


def test_a_file_that_is_none(tmp_path) -> None:
    with pytest.raises(FileNotFoundError, match="There is no file"):
        sp.read_system(tmp_path / "nothing.toml")
    (tmp_path / "bad.toml").write_text("[[parts]\n", encoding="utf-8")
    with pytest.raises(ValueError, match="is not TOML"):
        sp.read_system(tmp_path / "bad.toml")
    with pytest.raises(TypeError, match="system must be a System"):
        sp.to_toml(sp.Dimensionless())  # type: ignore[arg-type]


def test_explain_has_every_part_and_every_method() -> None:
    words = sp.explain(EVERYTHING)
    first = words.splitlines()[0]
    assert first.startswith(
        "0.2 x'' + 80 x + 0.1 x^2 + 400000 x^3 + 0.4 x' + 1.2 D^0.5 x + 2 x'|x'| + 0.1 (x^2 - 0.25) x'"
    )
    assert " = w(t) - 0.2 u(t) + y(t) - 0.2 z(t) - 1 + a(t) + b(t) + x c(t)" in first
    for name, part in EVERYTHING.named():
        if isinstance(part, sp.Barrier | sp.WhiteNoise | sp.ColoredNoise | sp.Harmonic | sp.PiezoelectricCircuit):
            assert f"({name})" in words
    assert "wall (stop): x <= 0.003 m, restitution 0.7" in words
    assert "no analytical method covers this:" in words
    assert all(method in words for method in METHODS)
    assert "analytical methods with an answer: averaging_printed, averaging" in sp.explain(sp.Oscillator())
    with pytest.raises(TypeError, match="system must be a System"):
        sp.explain(3)
    ground = sp.KanaiTajimiNoise(6.0, 0.4, 1.0, envelope=sp.ExponentialEnvelope(0.2, 0.6))
    for more, ends in (
        ((), "\nmean squares in time: theory.transient"),
        ((sp.PolynomialSpring((0.0, 0.0, 1.0)),), "theory.transient, by linearization at each time"),
        ((sp.Friction(0.1),), "not friction."),
    ):
        shaken = sp.explain(sp.System(sp.Spring(1.0), sp.Dashpot(0.1), ground, *more))
        assert shaken.endswith(ends)
        assert "w(t): Kanai-Tajimi noise (kanai_tajimi_noise), filter at 6 rad/s" in shaken
