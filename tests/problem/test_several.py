"""Several masses: how they are stated, written and read, what is refused, and the equations in words."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.machine.faults import NotCoveredError
from springpot.problem.catalogue import possible_results, unit_of_result
from springpot.problem.file import read_system
from springpot.problem.free_numbers import with_values
from springpot.problem.numbers import numbers_of, with_numbers

A, B, C = sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Mass(0.5, at="c")
LEFT, LINK, RIGHT = ("ground", "a"), ("a", "b"), ("ground", "b")
HELD = A, B, sp.Spring(3.0, between=LEFT), sp.Spring(2.0, between=LINK)
SHAKEN = sp.WhiteNoise(0.1, on="ground")
EVERYTHING = sp.System(
    *HELD,
    sp.PolynomialSpring((0.0, 0.1, 1.0), between=LINK),
    sp.Dashpot(0.3, between=LEFT),
    sp.Springpot(0.5, 0.2, between=LINK),
    sp.FractionalMaxwell(sp.Springpot(0.4, 2.0), sp.Spring(3.0), between=RIGHT),
    sp.Maxwell(1.0, 2.0, between=LINK),
    sp.Friction(0.1, between=LINK),
    sp.PiezoelectricCircuit(0.3, 2.0, 0.5, between=LINK),
    sp.Contact(-0.4, 50.0, between=LEFT),
    sp.WhiteNoise(0.3, on="b"),
    sp.ColoredNoise(1.0, 0.5, on="a"),
    sp.KanaiTajimiNoise(3.0, 0.4, 1.0),
    sp.Harmonic(0.2, 2.0, on="b"),
    sp.Constant(-1.0, on="a"),
    sp.RecordedExcitation((0.0, 1.0), (0.0, 0.2), on="b"),
    sp.SpectralExcitation((1.0, 9.0), (0.1, 0.2), on="b"),
    gap=sp.Barrier(-0.2, sp.PowerRestitution(sp.free("r", 0.7, (0.1, 0.9)), 0.1), between=LINK),
)


def test_points_and_rows() -> None:
    pair = sp.System(*HELD, sp.Dashpot(0.1, between=("b", "a")), SHAKEN, sp.WhiteNoise(1.0, on="b"))
    assert pair.points == ("a", "b")
    at = pair.coordinates
    assert at.masses.tolist() == [1.0, 2.0]
    rows = {name: row.tolist() for name, row in at.elongations.items()}
    assert rows == {"spring_1": [1.0, 0.0], "spring_2": [-1.0, 1.0], "dashpot": [1.0, -1.0]}
    assert {name: force.tolist() for name, force in at.forces.items()} == {
        "white_noise_1": [-1.0, -2.0],
        "white_noise_2": [0.0, 1.0],
    }
    assert at.sum_of({"spring_1": 3.0, "spring_2": 2.0}).tolist() == [[5.0, -2.0], [-2.0, 2.0]]
    alone = sp.System(sp.Spring(3.0), sp.WhiteNoise(1.0)).coordinates
    assert (alone.points, alone.elongations["spring"].tolist(), alone.forces["white_noise"].tolist()) == (
        ("mass",),
        [1.0],
        [1.0],
    )


def test_names_are_written_where_they_are_given() -> None:
    assert repr(sp.Spring(2.0)) == "Spring(stiffness=2.0)"
    assert repr(sp.Spring(2.0, between=LINK)) == "Spring(stiffness=2.0, between=('a', 'b'))"
    assert repr(sp.Mass(2.0, at="a")) == "Mass(value=2.0, at='a')"
    assert repr(sp.Constant(2.0)) == "Constant(force=2.0)"
    assert repr(sp.Constant(2.0, on="a")) == "Constant(force=2.0, on='a')"
    assert repr(EVERYTHING.parts[7]) == (
        "FractionalMaxwell(springpot=Springpot(order=0.4, coefficient=2.0), spring=Spring(stiffness=3.0), "
        "between=('ground', 'b'))"
    )
    plain = sp.System(sp.Mass(2.0), sp.Spring(3.0), sp.Constant(1.0)).to_dict()["parts"]
    assert [*map(tuple, plain)] == [
        ("name", "kind", "value"),
        ("name", "kind", "stiffness"),
        ("name", "kind", "force"),
    ]
    stated = sp.System(*HELD, sp.Constant(1.0, on="b")).to_dict()["parts"]
    assert stated[0] == {"name": "mass_1", "kind": "mass", "value": 1.0, "at": "a"}
    assert stated[3] == {"name": "spring_2", "kind": "spring", "stiffness": 2.0, "between": ("a", "b")}
    assert stated[4] == {"name": "constant", "kind": "constant", "force": 1.0, "on": "b"}


def test_a_file_gives_the_same_system_back(tmp_path) -> None:
    place = tmp_path / "pair.toml"
    place.write_text(sp.to_toml(EVERYTHING), encoding="utf-8")
    assert 'stiffness = 2.0\nbetween = ["a", "b"]' in place.read_text(encoding="utf-8")
    assert read_system(place) == EVERYTHING
    assert read_system(json.loads(json.dumps(EVERYTHING.to_dict()))) == with_values(EVERYTHING, {"r": 0.7})
    density = {"kind": "white_noise", "psd": 0.01, "psd_unit": "N2/Hz", "on": "b"}
    found = read_system({"parts": [*sp.System(*HELD).to_dict()["parts"], density]})
    assert found.parts[-1] == sp.WhiteNoise.from_psd(0.01, "N2/Hz", on="b")


def test_numbers_are_those_of_the_parts_and_names_are_none() -> None:
    found = numbers_of(EVERYTHING)
    assert found["parts.spring_2.stiffness"] == 2.0
    assert not [name for name in found if name.endswith((".between", ".at", ".on"))]
    other = with_numbers(EVERYTHING, {"parts.spring_2.stiffness": 4.0, "parts.mass_2.value": 3.0})
    assert dict(other.named())["spring_2"] == sp.Spring(4.0, between=LINK)
    assert dict(other.named())["mass_2"] == sp.Mass(3.0, at="b")
    assert with_values(EVERYTHING, {"r": 0.5}).parts[-1].between == LINK


def test_one_mass_with_a_name_is_one_mass() -> None:
    """Its numbers are those without a name, to the last bit."""
    parts = sp.Spring(8.0), sp.Springpot(0.5, 0.4), sp.Barrier(-0.2, 0.8), sp.WhiteNoise(1.0), sp.Constant(0.5)
    away = sp.Barrier(200.0, free_side="below")
    plain = sp.System(sp.Mass(2.0), *parts, away)
    named = sp.System(
        sp.Mass(2.0, at="box"),
        sp.Spring(8.0, between=("ground", "box")),
        sp.Springpot(0.5, 0.4),
        sp.Barrier(-0.2, 0.8, between=("ground", "box")),
        sp.WhiteNoise(1.0, on="box"),
        sp.Constant(0.5, on="box"),
        away,
    )
    assert named.points == ("box",)
    assert named.per_unit_mass == plain.per_unit_mass
    assert named.potential == plain.potential
    assert named.natural_frequency == 2.0
    assert possible_results(named) == possible_results(plain)
    assert sp.explain(named) == sp.explain(plain)
    one, other = (sp.simulate(each, paths=4, duration=2.0, seed=1, threads=1) for each in (plain, named))
    assert one["x_mean_square"].value == other["x_mean_square"].value


def test_results_of_several_masses() -> None:
    found = possible_results(sp.System(*HELD, sp.Dashpot(0.1, between=LINK), SHAKEN))
    assert {"a_x_mean", "b_v_mean_square", "a_b_elongation_mean_square", "damping_power"} <= {*found}
    assert not {"x_mean", "x_mean_square", "amplitude_mean_square", "x_mean_end", "damping_virial"} & {*found}
    assert unit_of_result(sp.System(*HELD), "b_x_mean_square") == "m2"


def test_each_pair_of_masses_has_one_elongation() -> None:
    """However many parts are between them; that to the ground is the displacement itself."""
    back = sp.Spring(1.0, between=LINK[::-1]), sp.Barrier(-1.0, between=LINK)
    found = possible_results(sp.System(*HELD, sp.Dashpot(0.1, between=LINK), *back, SHAKEN))
    assert [name for name in found if "elongation" in name] == ["a_b_elongation_mean", "a_b_elongation_mean_square"]
    with pytest.raises(ValueError, match="a_b_c_elongation_mean would be the name of two results"):
        sp.System(
            *(sp.Mass(1.0, at=name) for name in ("a", "b_c", "a_b", "c")),
            sp.Spring(1.0, between=("a", "b_c")), sp.Spring(1.0, between=("a_b", "c")),
        )  # fmt: skip


def test_matrices() -> None:
    stiffness = np.array([[5.0, -2.0, 0.0], [-2.0, 3.5, -1.5], [0.0, -1.5, 2.5]])
    damping = 0.1 * stiffness
    frame = sp.System.from_matrices(np.diag([1.0, 0.7, 0.5]), stiffness, damping, names=["a", "b", "c"])
    assert frame.parts[:3] == (sp.Mass(1.0, at="a"), sp.Mass(0.7, at="b"), sp.Mass(0.5, at="c"))
    assert [part.between for part in frame.of(sp.Spring)] == [LEFT, LINK, ("b", "c"), ("ground", "c")]
    at = frame.coordinates
    for wanted, name in ((stiffness, "linear_stiffness"), (damping, "linear_damping")):
        found = at.sum_of({each: getattr(part, name) for each, part in frame.named() if each in at.elongations})
        np.testing.assert_allclose(found, wanted, atol=1e-15)
    assert sp.System.from_matrices([[2.0]], [[8.0]]).points == ("m1",)


PARTS_OF_PARTS = sp.Springpot(0.5, 1.0), sp.Spring(1.0)
ONE, TWO = [[1.0, 0.0], [0.0, 1.0]], [[2.0, -1.0], [-1.0, 2.0]]
BAD = [
    (lambda: sp.System(sp.Mass(1.0), B, sp.Spring(1.0)), ValueError, "each of the 2 masses must have a name"),
    (
        lambda: sp.System(A, sp.Mass(2.0, at="a"), sp.Spring(1.0, between=LEFT)),
        ValueError,
        "a is the name of two masses",
    ),
    (
        lambda: sp.System.from_matrices(ONE, TWO, names=["a", "a"]),
        ValueError,
        "names must be different, but 'a' is the name of two masses",
    ),
    (lambda: sp.Mass(1.0, at="ground"), ValueError, "other than 'ground' and 'mass', not 'ground'"),
    (lambda: sp.Mass(1.0, at="mass"), ValueError, "other than 'ground' and 'mass', not 'mass'"),
    (lambda: sp.Mass(1.0, at="the box"), ValueError, "at must be a name for the mass"),
    (lambda: sp.System(*HELD, sp.Dashpot(1.0)), ValueError, "dashpot must say between which masses it acts"),
    (
        lambda: sp.System(*HELD, sp.Dashpot(1.0, between=("ground", "d"))),
        ValueError,
        "'d' is no mass; there are ground, a",
    ),
    (
        lambda: sp.System(sp.Mass(1.0, at="panel"), B, sp.Spring(1.0, between=("panle", "b"))),
        ValueError,
        "'panle' is no mass; did you mean panel",
    ),
    (lambda: sp.System(sp.Spring(1.0, between=("ground", "box"))), ValueError, "'box' is no mass"),
    (
        lambda: sp.System(A, sp.Spring(1.0, between=("a", "ground"))),
        ValueError,
        "in this order: x is measured from the",
    ),
    (lambda: sp.Barrier(-0.1, between=("a", "a")), ValueError, "between must be two different ends, not 'a' twice"),
    (lambda: sp.Spring(1.0, between="ab"), TypeError, "between must be the names of two ends"),
    (lambda: sp.Spring(1.0, between=("a", "b", "c")), TypeError, "between must be the names of two ends"),
    (
        lambda: sp.FractionalMaxwell(*PARTS_OF_PARTS[:1], sp.Spring(1.0, between=LINK)),
        ValueError,
        "spring must be without between in a series",
    ),
    (
        lambda: sp.FractionalMaxwell(sp.Springpot(0.5, 1.0, between=LINK), sp.Spring(1.0)),
        ValueError,
        "springpot must be without between in a series",
    ),
    (
        lambda: sp.System(*HELD, sp.WhiteNoise(1.0)),
        ValueError,
        "on of white_noise must be 'a', 'b' or 'ground', not 'mass'",
    ),
    (
        lambda: sp.System(*HELD, sp.WhiteNoise(1.0, on="d")),
        ValueError,
        "on of white_noise must be 'a', 'b' or 'ground'",
    ),
    (lambda: sp.System(*HELD, sp.Constant(1.0)), ValueError, "on of constant must be 'a' or 'b', not 'mass'"),
    (lambda: sp.Constant(1.0, on="ground"), ValueError, "on must be the name of a mass here, not 'ground'"),
    (lambda: sp.Force(lambda t, x, v: -x, on="ground"), ValueError, "on must be the name of a mass here"),
    (lambda: sp.WhiteNoise.from_psd(1.0, "g2/Hz", on="a"), ValueError, "on must be left out with a density in g2/Hz"),
    (lambda: sp.System(*HELD, sp.ParametricNoise(0.1)), ValueError, "parametric_noise must say between which masses"),
    (
        lambda: sp.System(*HELD, sp.Barrier(0.2, free_side="above", between=LINK), sp.Barrier(0.1, between=LINK)),
        ValueError,
        "x_b - x_a >= 0.2 and x_b - x_a <= 0.1 cannot both hold",
    ),
    (
        lambda: sp.System(
            *HELD, sp.Barrier(0.2, free_side="above", between=LINK), sp.Barrier(-0.1, between=("b", "a"))
        ),
        ValueError,
        "x_b - x_a >= 0.2 and x_b - x_a <= 0.1 cannot both hold",
    ),
    (
        lambda: sp.System(*HELD, sp.Barrier(-0.2, between=LEFT), sp.Barrier(-0.1, between=LEFT)),
        ValueError,
        "barrier_1 at -0.2 must not lie behind barrier_2, at -0.1",
    ),
    (
        lambda: sp.System(*HELD, sp.Barrier(-0.2, between=LEFT), sp.Contact(-0.3, 5.0, between=LEFT)),
        ValueError,
        "contact at -0.3 must not lie behind a wall",
    ),
    (
        lambda: sp.System(
            *HELD,
            sp.Barrier(0.1, free_side="above", between=LEFT),
            sp.Barrier(0.1, free_side="above", between=LINK),
            sp.Barrier(0.15, between=RIGHT),
        ),
        ValueError,
        "the walls must leave room: barrier_.* cannot all hold",
    ),
    (
        lambda: sp.System(*HELD, sp.Spring(-3.5, between=LEFT)),
        ValueError,
        "falls without limit where a and b move: add",
    ),
    (lambda: sp.System(*HELD, sp.Spring(-4.0, between=RIGHT)), ValueError, "falls without limit where b moves: add"),
    (
        lambda: sp.System(*HELD, sp.PolynomialSpring((0.0, 0.0, -1.0), between=LINK)),
        ValueError,
        "falls without limit where a",
    ),
    (
        lambda: sp.System(*HELD, sp.Friction(0.1, between=LINK), sp.ThermalNoise(1.0)),
        ValueError,
        "friction cannot be combined with ThermalNoise",
    ),
    (lambda: sp.System.from_matrices([[1.0, 0.1], [0.2, 1.0]], TWO), ValueError, "mass must be a symmetric matrix"),
    (lambda: sp.System.from_matrices([[1.0, 1.0], [1.0, 1.0]], TWO), ValueError, "mass must not be singular"),
    (
        lambda: sp.System.from_matrices(ONE, [[2.0, -1.0], [-1.1, 2.0]]),
        ValueError,
        "stiffness must be a symmetric matrix",
    ),
    (lambda: sp.System.from_matrices(ONE, [[2.0]]), ValueError, "stiffness must be a matrix of 2 rows"),
    (lambda: sp.System.from_matrices(ONE, [2.0, 1.0]), ValueError, "stiffness must be a square matrix"),
    (lambda: sp.System.from_matrices(ONE, TWO, "soft"), TypeError, "damping must be a matrix of numbers"),
    (lambda: sp.System.from_matrices(ONE, [[2.0, math.nan], [math.nan, 1.0]]), ValueError, "matrix of finite numbers"),
    (
        lambda: sp.System.from_matrices(ONE, TWO, [[0.1, 0.5], [0.5, 0.1]]),
        ValueError,
        "damping must take energy from every motion, but one has a coefficient of -0.4",
    ),
    (
        lambda: sp.System.from_matrices(ONE, TWO, names=["a"]),
        ValueError,
        "names must be a name for each of the 2 masses",
    ),
    (
        lambda: sp.System.from_matrices(ONE, [[1.0, -2.0], [-2.0, 1.0]]),
        ValueError,
        "falls without limit where m1 and m2",
    ),
    (
        lambda: read_system(
            {"parts": [{"kind": "mass", "value": 1.0, "at": "a"}, {"kind": "spring", "stiffness": 1.0, "between": "a"}]}
        ),
        ValueError,
        r"parts\[1\] \(spring\).between must be the names of two ends",
    ),
]


@pytest.mark.parametrize(("make", "kind", "sentence"), BAD)
def test_bad_systems_are_refused_in_one_sentence(make, kind, sentence) -> None:
    with pytest.raises(kind, match=sentence) as caught:
        make()
    assert "\n" not in str(caught.value)
    assert not isinstance(caught.value, NotCoveredError)


def test_what_is_not_held_may_still_be_stated() -> None:
    """A free pair moves for ever: there is no stationary state, but runs of a fixed time."""
    free = sp.System(A, B, sp.Spring(2.0, between=LINK), sp.Barrier(-0.2, between=LINK))
    assert free.coordinates.elongations["barrier"].tolist() == [-1.0, 1.0]
    loose = sp.System(*HELD, C, sp.WhiteNoise(1.0, on="c"))
    assert loose.points == ("a", "b", "c")
    chain = sp.Barrier(-0.1, between=LEFT), sp.Barrier(-0.1, between=LINK), sp.Barrier(0.3, between=RIGHT)
    assert len(sp.System(*HELD, *chain).stops) == 3


def test_what_has_one_coordinate_says_that_there_are_several() -> None:
    pair = sp.System(*HELD, SHAKEN)
    for name in ("mass", "inertia", "per_unit_mass", "potential", "natural_frequency", "resonance"):
        with pytest.raises(NotCoveredError, match="one mass is needed, and the system has 2, a and b"):
            getattr(pair, name)


def test_the_equations_in_words() -> None:
    lines = sp.explain(EVERYTHING).splitlines()
    assert lines[0].startswith("1 x_a'' + 3 x_a + 2 (x_a - x_b) - [0.1 (x_b - x_a)^2 + 1 (x_b - x_a)^3] + 0.3 x_a'")
    assert lines[1].startswith("2 x_b'' + 2 (x_b - x_a) + 0.1 (x_b - x_a)^2 + 1 (x_b - x_a)^3 + 0.2 D^0.5 (x_b - x_a)")
    assert lines[0].endswith(" = u(t) - y(t) - 1")
    assert lines[1].endswith(" = w(t) - 2 y(t) + z(t) + a(t) + b(t)")
    assert any(line.startswith("wall (gap): x_b - x_a >= -0.2 m, restitution min(1, 0.7") for line in lines)
    assert any(line.startswith("natural frequencies 0.7419") for line in lines)
    assert any("0.3 (x_b - x_a)'" in line for line in lines if line.startswith("V (piezoelectric_circuit)"))


def test_the_force_of_a_contact_is_opposite_on_its_two_ends() -> None:
    for contact, signs in ((sp.Contact(-0.2, 30.0, between=LINK), "+-"), (sp.Contact(0.2, 30.0, between=LINK), "-+")):
        lines = sp.explain(sp.System(*HELD, contact, SHAKEN)).splitlines()[:2]
        assert all(f" {sign} 30 d^1.5" in line for sign, line in zip(signs, lines, strict=True))


FREE = sp.System(
    A, B, sp.Spring(sp.free("k", 3.0, (1.0, 5.0)), between=LEFT), *HELD[3:], sp.Dashpot(0.3, between=LINK), SHAKEN
)
HERTZ = np.array([0.1, 0.2, 0.3])
DOORS = {
    "fit of moduli": lambda: sp.fit(FREE, sp.MeasuredModuli(HERTZ, HERTZ, HERTZ)),
    "atlas": lambda: sp.atlas(FREE),
    "paper": lambda: sp.Dimensionless.of(FREE),
}


@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_doors_of_what_covers_one_mass_say_so(door) -> None:
    with pytest.raises(NotCoveredError, match="one mass is needed, and the system has 2, a and b") as caught:
        door()
    assert "\n" not in str(caught.value)


def test_the_linear_theory_is_recommended_and_nothing_where_there_is_no_answer() -> None:
    assert sp.recommended(FREE).method == "linear"
    walled = sp.recommended(sp.System(*FREE.parts, sp.Barrier(-0.2, between=LINK)))
    assert (walled.method, walled.why_none) == ("", "no method is recommended here: no analytical method covers this.")
    assert not sp.trust(FREE, "envelope").judges


def test_the_command_prints_the_results_of_each_mass(tmp_path, capsys) -> None:
    place = tmp_path / "pair.toml"
    place.write_text(sp.to_toml(FREE), encoding="utf-8")
    assert cli.main(["theory", str(place)]) == 0
    printed = capsys.readouterr().out
    assert "b_x_mean_square" in printed
    assert "* recommended here: linear" in printed
    assert cli.main(["atlas", str(place)]) == 2
    assert "one mass is needed" in capsys.readouterr().err
