"""Points as combinations of masses: modal models, beams, mass matrices that are not diagonal, inerters; and theory."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import linalg

import springpot as sp
from springpot.problem.numbers import numbers_of, with_numbers

A_B = ("a", "b")
MASS, STIFFNESS, DAMPING = (
    np.diag([1.0, 0.5]),
    np.array([[3.0, -1.0], [-1.0, 1.5]]),
    np.array([[0.3, -0.1], [-0.1, 0.2]]),
)
PAIR = sp.System.from_matrices(MASS, STIFFNESS, DAMPING, names=["a", "b"])
NOISES = (
    sp.WhiteNoise(1.0, on="b"), sp.WhiteNoise(0.3, on="ground"), sp.ThermalNoise(0.6), sp.Harmonic(0.3, 1.1, on="a"),
)  # fmt: skip
BETWEEN = sp.Springpot(0.5, 0.4, between=A_B), sp.PiezoelectricCircuit(0.3, 2.0, 0.5, between=("ground", "b"))


def in_other_coordinates(mass: Any = MASS) -> sp.System:
    """Of q = T x: the mass matrix is full."""
    change = np.array([[1.0, 0.4], [-0.7, 2.0]])
    back = np.linalg.inv(change)
    matrices = (back.T @ matrix @ back for matrix in (mass, STIFFNESS, DAMPING))
    return sp.System.from_matrices(*matrices, names={"a": back[0], "b": back[1]}, ground=change @ np.ones(2))


@pytest.mark.parametrize("noise", NOISES)
def test_a_pair_in_other_coordinates_has_the_same_results(noise: Any) -> None:
    one, two = (sp.theory.linear(sp.System(*each.parts, *BETWEEN, noise)) for each in (PAIR, in_other_coordinates()))
    for name, value in one.numbers.items():
        assert two.numbers[name] == pytest.approx(value, rel=1e-12, abs=1e-30, nan_ok=True), name
    for of in ("x", "v"):
        known = one.covariance(of)  # type: ignore[arg-type]
        # of velocities in equilibrium that of two masses is 0
        np.testing.assert_allclose(two.covariance(of)[2:4, 2:4], known, rtol=1e-11, atol=1e-11 * known.max())  # type: ignore[arg-type]
    w = np.array([0.3, 1.7])
    np.testing.assert_allclose(two.spectral_matrix(w)[:, 2:4, 2:4], one.spectral_matrix(w), rtol=1e-11)
    for of, on in (("b", "ground"), ("springpot", "a")):
        response = one.frequency_response(w, of=of, on=on)
        np.testing.assert_allclose(two.frequency_response(w, of=of, on=on), response, rtol=1e-12)


@pytest.mark.parametrize("noise", NOISES)
def test_a_modal_model_with_all_modes_is_the_chain(noise: Any) -> None:
    own = sp.theory.modes(PAIR)
    modal = sp.System.from_modes(
        own.frequencies, 1.0, dict(zip("ab", own.shapes, strict=True)), participations=own.participations
    )
    dampers = PAIR.of(sp.Dashpot)
    one, two = (
        sp.theory.linear(sp.System(*parts, *BETWEEN, noise)) for parts in (PAIR.parts, (*modal.parts, *dampers))
    )
    for name, value in one.numbers.items():
        assert two.numbers[name] == pytest.approx(value, rel=1e-12, abs=1e-30, nan_ok=True), name
    again = sp.theory.modes(modal)
    assert again.effective_masses == pytest.approx(own.effective_masses)
    assert again.effective_masses.sum() == pytest.approx(1.5)
    np.testing.assert_allclose(again.shapes[2:], own.shapes, atol=1e-14)


@pytest.mark.parametrize("noise", NOISES)
def test_an_inerter_between_two_masses_is_in_the_mass_matrix(noise: Any) -> None:
    """The ground accelerates the masses alone."""
    row = np.array([-1.0, 1.0])
    full = sp.System.from_matrices(MASS + 0.4 * np.outer(row, row), STIFFNESS, DAMPING, names=["a", "b"])
    parts = (*PAIR.parts, sp.Inerter(0.4, between=A_B))
    one, two = (sp.theory.linear(sp.System(*each, *BETWEEN, noise)) for each in (parts, full.parts))
    for name, value in one.numbers.items():
        assert two.numbers[name] == pytest.approx(value, rel=1e-11, abs=1e-30, nan_ok=True), name
    assert one.frequency_response(1e4, of="a", on="a") == pytest.approx(-1e-8 / (1.0 + 0.4 * 0.5 / 0.9), rel=1e-3)


def test_dampers_in_proportion_belong_to_modes() -> None:
    frame = sp.System.from_matrices([[2.0, 0.5], [0.5, 1.0]], STIFFNESS, 0.1 * STIFFNESS)
    assert frame.points == ("mode_1", "mode_2", "m1", "m2")
    assert {part.between for part in frame.of(sp.Dashpot)} == {("ground", "mode_1"), ("ground", "mode_2")}
    assert max(abs(share) for point in frame.of(sp.Point) for share in point.shares) == pytest.approx(1.0)
    assert sp.theory.modes(frame).effective_masses.sum() == pytest.approx(4.0)
    loose = sp.System.from_matrices([[2.0, 0.5], [0.5, 1.0]], [[1.0, -1.0], [-1.0, 1.0]])
    assert len(loose.of(sp.Spring)) == 1


@pytest.mark.parametrize("size", [3, 8])
def test_a_diagonal_mass_with_a_damping_that_no_dashpots_have(size: int) -> None:
    """As of beams, whose stiffness has positive numbers off the diagonal: the modes, and Lyapunov's equation."""
    bend = np.diff(np.eye(size + 2), n=2, axis=0)[:, 2:]
    masses, held = np.diag(np.linspace(1.0, 2.0, size)), bend.T @ bend + 0.02 * np.ones((size, size))
    damped = 0.1 * held + np.diag(np.eye(size)[-1])  # not in proportion
    beam = sp.System.from_matrices(masses, held, damped)
    assert beam.points[-2 * size : -size] == tuple(f"m{n}" for n in range(1, size + 1))
    found = sp.theory.linear(sp.System(*beam.parts, sp.WhiteNoise(1.0, on="m1")))
    inverse, still = np.linalg.inv(masses), np.zeros((size, size))
    drift = np.block([[still, np.eye(size)], [-inverse @ held, -inverse @ damped]])
    push = np.concatenate([still[0], inverse[0]])
    exact = linalg.solve_continuous_lyapunov(drift, -np.outer(push, push))
    assert found.numbers["m1_x_mean_square"] == pytest.approx(exact[0, 0], rel=1e-7)
    assert found.numbers[f"m{size}_v_mean_square"] == pytest.approx(exact[-1, -1], rel=1e-7)


CANTILEVER = {"length": 0.3, "bending_stiffness": 0.6, "mass": 0.05}


def test_a_cantilever() -> None:
    strip = sp.beam(**CANTILEVER, points={"tip": 0.3, "middle": 0.15}, modes=8, damping_ratios=0.01)
    own, unit = sp.theory.modes(strip), math.sqrt(0.6 / (0.05 * 0.3**3))
    roots = np.sqrt(own.frequencies / unit)
    assert roots[:4] == pytest.approx([1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349], rel=1e-10)
    assert own.effective_masses[:3] / 0.05 == pytest.approx([0.6130760, 0.1883004, 0.0647322], rel=1e-6)
    softness = [(own.shapes[strip.points.index("tip"), :n] ** 2 / own.frequencies[:n] ** 2).sum() for n in (1, 3, 8)]
    errors = 1.0 - np.array(softness) * 3.0 * 0.6 / 0.3**3
    every = np.append(roots, np.pi * (np.arange(8, 300) + 0.5))
    left = [(12.0 / every[n:] ** 4).sum() for n in (1, 3, 8)]  # of modes that are left out
    assert errors == pytest.approx(left, rel=1e-4)
    assert own.effective_masses.sum() / 0.05 == pytest.approx(1.0 - 4.0 / (math.pi**2 * 8), rel=1e-3)
    middle = strip.coordinates.rows[strip.points.index("middle")]
    assert middle[:3] == pytest.approx([0.339523, -0.713666, 0.019688], abs=1e-6)
    assert strip.of(sp.Dashpot)[1].coefficient == pytest.approx(2.0 * 0.01 * own.frequencies[1] * 0.0125)


def test_a_supported_beam() -> None:
    plank = sp.beam(2.0, 500.0, 8.0, {"middle": 1.0, "quarter": 0.5}, kind="simply supported", modes=7)
    own = sp.theory.modes(plank)
    assert own.frequencies == pytest.approx((np.pi * np.arange(1, 8)) ** 2 * math.sqrt(500.0 / (8.0 * 8.0)))
    assert own.effective_masses[:3] / 8.0 == pytest.approx([8.0 / np.pi**2, 0.0, 8.0 / (9.0 * np.pi**2)], abs=1e-12)
    softness = (own.shapes[plank.points.index("middle")] ** 2 / own.frequencies**2).sum()
    assert softness == pytest.approx(8.0 / (48.0 * 500.0), rel=1e-3)
    assert dict(plank.named())["point_1"].of == ("mode_1", "mode_3", "mode_5", "mode_7")  # the others never move it


def test_modes_are_numbers_files_and_words() -> None:
    strip = sp.beam(**CANTILEVER, points={"tip": 0.3}, modes=2, damping_ratios=[0.01, 0.02])
    shaken = sp.System(
        *strip.parts, sp.WhiteNoise(0.1, on="ground"), stop=sp.Barrier(-0.01, 0.8, between=("ground", "tip"))
    )
    assert sp.read_system({"parts": shaken.to_dict()["parts"]}) == shaken
    assert numbers_of(shaken)["parts.point.shares.2"] == pytest.approx(1.0)
    assert numbers_of(shaken)["parts.mass_1.participation"] == pytest.approx(1.5659835)
    assert with_numbers(shaken, {"parts.point.shares.2": -0.5}).of(sp.Point)[0].shares == pytest.approx((1.0, -0.5))
    assert "parts.mass.participation" not in numbers_of(sp.System(sp.Mass(1.0), sp.Spring(1.0)))
    lines = sp.explain(shaken).splitlines()
    assert lines[1].startswith("0.0125 x_mode_2'' + ")
    assert lines[1].endswith("= 0.0108484 w(t)")
    assert "point (point): x_tip = 1 x_mode_1 + 1 x_mode_2" in lines
    assert "wall (stop): x_tip >= -0.01 m, restitution 0.8" in lines
    pushed = sp.explain(sp.System(*PAIR.parts, sp.Point("c", A_B, (0.25, 0.5)), sp.Inerter(0.2, between=("a", "c")),
                                  sp.Friction(0.1, between=("ground", "c")), sp.WhiteNoise(1.0, on="c")))  # fmt: skip
    first, second = pushed.splitlines()[:2]
    assert "- 0.75 [0.2 (x_c - x_a)''] + 0.25 [0.1 sgn(x_c')] = 0.25 w(t)" in first
    assert "+ 0.5 [0.2 (x_c - x_a)''] + 0.5 [0.1 sgn(x_c')] = 0.5 w(t)" in second


TIP = sp.Point("tip", ("m", "n"), (1.0, -1.0))
TWO_MODES = (
    sp.Mass(1.0, at="m", participation=0.0), sp.Mass(1.0, at="n", participation=0.0),
    *(sp.Spring(1.0, between=("ground", mode)) for mode in "mn"),
)  # fmt: skip
BAD = [
    (lambda: sp.System.from_matrices([[1.0, 1.0], [1.0, 1.0]], STIFFNESS), "mass must not be singular: each motion"),
    (lambda: sp.System.from_matrices([[1.0, 0.2], [0.1, 1.0]], STIFFNESS), "mass must be a symmetric matrix"),
    (lambda: sp.System.from_matrices(MASS, STIFFNESS, names={"a": [1.0]}), "names of a must be 2 numbers, one for"),
    (lambda: sp.System.from_matrices(MASS, STIFFNESS, ground=[1.0]), "ground must be 2 numbers, one for each coord"),
    (
        lambda: sp.System.from_matrices([[1.0, 0.1], [0.1, 1.0]], STIFFNESS, [[0.1, 0.5], [0.5, 0.1]]),
        "damping must take energy from every motion, but one has a coefficient of -0.4",
    ),
    (lambda: sp.System.from_modes([1.0, 2.0], [1.0], {"a": [1.0, 1.0]}), "masses must be 2 numbers, one for each mode"),
    (lambda: sp.System.from_modes([1.0, 2.0], 1.0, {"a": 1.0}), "shapes of a must be numbers in a row"),
    (lambda: sp.System.from_modes([1.0, -2.0], 1.0, {"a": [1.0, 1.0]}), "frequencies must not be negative, and -2"),
    (lambda: sp.System.from_modes([1.0, 2.0], 0.0, {"a": [1.0, 1.0]}), "masses must be positive, and 0 is among them"),
    (lambda: sp.System.from_modes([1.0, math.nan], 1.0, {"a": [1.0, 1.0]}), "frequencies must be finite numbers"),
    (lambda: sp.System.from_modes("fast", 1.0, {"a": [1.0]}), "frequencies must be numbers, one for each mode"),
    (lambda: sp.System.from_modes([1.0], 1.0, [1.0]), "shapes must say how points move, as {'tip': "),
    (lambda: sp.System.from_modes([1.0], 1.0, {"mode_1": [1.0]}), "mode_1 cannot be the name of a point"),
    (lambda: sp.System.from_modes([1.0], 1.0, {"a": [0.0]}), "shares must not all be 0: the point would never move"),
    (lambda: sp.beam(**CANTILEVER, points={"tip": 0.31}), "place of tip must be"),
    (lambda: sp.beam(**CANTILEVER, points={"tip": 0.3}, kind="simply supported"), "place of tip must be where the"),
    (lambda: sp.beam(**CANTILEVER, points={"tip": 0.3}, kind="cantilver"), "kind must be 'cantilever' or 'simply sup"),
    (lambda: sp.beam(**CANTILEVER, points={}), "points must be places by name, as {'tip': 0.3}"),
    (lambda: sp.beam(**CANTILEVER, points={"tip": 0.3}, modes=9), "modes must be a whole number from 1 to 8, not 9"),
    (lambda: sp.beam(**CANTILEVER, points={"tip": 0.3}, damping_ratios=[0.1]), "damping_ratios must be 3 numbers, one"),
    (lambda: sp.Point("tip", ("m", "n"), (1.0,)), "shares must be a number for each of the 2 masses in of, not 1"),
    (lambda: sp.Point("tip", "mn", (1.0, 1.0)), "of must be a tuple of names of masses, not 'mn'"),
    (lambda: sp.Point("tip", ("m", "m"), (1.0, 1.0)), "of must be the names of different masses"),
    (lambda: sp.Point("ground", ("m",), (1.0,)), "at must be a name for the point"),
    (lambda: sp.System(*TWO_MODES, sp.Point("tip", ("m", "o"), (1.0, 1.0))), "of masses, but 'o' is no mass"),
    (lambda: sp.System(sp.Spring(1.0), TIP), "combination of masses, but 'm' is no mass; there is none"),
    (lambda: sp.System(*TWO_MODES, TIP, sp.Point("n", ("m",), (1.0,))), "n is the name of two points"),
    (lambda: sp.System(*TWO_MODES), "participation of mass_1 must be 1 in a system without a Point"),
    (lambda: sp.System(*TWO_MODES, TIP, sp.Barrier(-1.0, between=("ground", "top"))), "'top' is no mass"),
    (lambda: sp.System(*TWO_MODES, TIP, sp.WhiteNoise(1.0, on="top")), "on of white_noise must be 'm', 'n', 'tip' or"),
    (lambda: sp.System(*TWO_MODES, TIP, sp.WhiteNoise(1.0, on="ground")), "white_noise accelerates the ground, but no"),
    (
        lambda: sp.System(*TWO_MODES, TIP, replace(TIP, at="top"), sp.Barrier(-1.0, between=("tip", "top"))),
        "barrier is between tip and top, which always move alike",
    ),
    (lambda: sp.Inerter(-1.0), "inertance must be"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "sentence"), BAD)
def test_bad_input_is_refused_in_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        make()
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_combination_of_masses_may_fall_without_limit() -> None:
    """A negative spring at the tip that the modes do not hold; and a start beyond a wall."""
    with pytest.raises(ValueError, match="falls without limit where m, n and tip move"):
        sp.System(*TWO_MODES, TIP, sp.Spring(-1.0, between=("ground", "tip")))
    walled = sp.System(*TWO_MODES, TIP, sp.Barrier(-1.0, between=("ground", "tip")), sp.WhiteNoise(1.0, on="tip"))
    with pytest.raises(ValueError, match="initial_position lies behind barrier"):
        sp.simulate(walled, initial_position={"n": 1.5})
    with pytest.raises(ValueError, match="initial_position has 'tip', which is no mass; there are m and n"):
        sp.simulate(walled, initial_position={"tip": 1.5})
