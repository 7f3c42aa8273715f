"""Matrices of finite elements: the lowest modes, what is left out, coordinates without a mass, motion that is free."""

from __future__ import annotations

import itertools
import math
import warnings
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import integrate, linalg, sparse

import springpot as sp
from tests.sizes import validation

Matrices = tuple[Any, Any]


def beam(elements: int, held: bool = True) -> Matrices:
    """The consistent mass and the stiffness of a beam of 1 m, 1 kg and 1 N m2: displacement and angle of each node."""
    h = 1.0 / elements
    bend = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                     [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3  # fmt: skip
    inert = np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                      [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]) * h / 420  # fmt: skip
    mass, stiffness = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for n in range(0, 2 * elements, 2):
        mass[n : n + 4, n : n + 4] += inert
        stiffness[n : n + 4, n : n + 4] += bend
    first = 2 if held else 0
    return mass[first:, first:], stiffness[first:, first:]


MASS, STIFFNESS = beam(12)
TIP, MIDDLE = 22, 10
AT = {"tip": TIP, "middle": MIDDLE}
UP = np.tile([1.0, 0.0], 12)


def precise(mass: Any, stiffness: Any) -> Any:
    """The frequencies of these matrices, with 50 digits on the way."""
    with mpmath.workdps(50):
        root = mpmath.cholesky(mpmath.matrix(mass.tolist())) ** -1
        squares = mpmath.eigsy(root * mpmath.matrix(stiffness.tolist()) * root.T, eigvals_only=True)
        return np.array([float(mpmath.sqrt(each)) for each in squares])


def lyapunov(damping: Any, push: Any) -> Any:
    """The covariance of all coordinates and their velocities in white noise of intensity 1."""
    inverse, still = np.linalg.inv(MASS), np.zeros_like(MASS)
    drift = np.block([[still, np.eye(24)], [-inverse @ STIFFNESS, -inverse @ damping]])
    forced = np.concatenate([np.zeros(24), inverse @ push])
    return linalg.solve_continuous_lyapunov(drift, -np.outer(forced, forced))


def flexibility(system: sp.System, point: str) -> float:
    row = system.coordinates.rows[system.points.index(point)]
    return float(row @ np.linalg.solve(system.stiffness_matrix, row))


def said(make: Any) -> tuple[Any, dict[str, str]]:
    """What is made, and the warnings by their names, each of which names this file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    assert all(each.filename == __file__ for each in caught)
    return made, {each.message.args[0].name: str(each.message) for each in caught}  # type: ignore[union-attr]


@pytest.mark.parametrize("form", [np.asarray, sparse.csr_array, sparse.coo_matrix])
def test_frequencies_of_24_coordinates_to_a_billionth(form: Any) -> None:
    exact = precise(MASS, STIFFNESS)
    assert exact[0] == pytest.approx(1.875104**2, rel=1e-5)
    for count in (1, 4, 8):
        system = sp.System.from_matrices(form(MASS), form(STIFFNESS), modes=count, names=AT, residual=["tip"])
        assert sp.theory.modes(system).frequencies[:count] == pytest.approx(exact[:count], rel=1e-10)
    whole = sp.theory.modes(sp.System.from_matrices(MASS, STIFFNESS, names={"tip": TIP}, ground=UP))
    assert whole.frequencies == pytest.approx(exact, rel=1e-9)
    assert whole.effective_masses.sum() == pytest.approx(UP @ MASS @ UP, rel=1e-9)


@pytest.mark.parametrize(
    ("form", "on"),
    [validation(np.asarray, "tip"), (sparse.csc_array, "ground"), validation(np.asarray, "ground"),
     validation(sparse.csc_array, "tip")],
)  # fmt: skip
def test_a_few_modes_respond_as_all_24_coordinates(form: Any, on: str) -> None:
    """With damping in proportion, and with a damper at the tip beside it, which couples the modes: Lyapunov's."""
    push = np.eye(24)[TIP] if on == "tip" else -MASS @ UP
    for more in (0.0, 0.3):
        damping = 0.05 * MASS + 2e-3 * STIFFNESS
        damping[TIP, TIP] += more
        system = sp.System.from_matrices(
            form(MASS), form(STIFFNESS), form(damping), names=AT, ground=UP, modes=8, residual=["tip"]
        )
        assert len(system.points) == 9 + 2 + (9 if more else 0)
        found = sp.theory.linear(sp.System(*system.parts, sp.WhiteNoise(1.0, on=on)))
        exact = np.diag(lyapunov(damping, push))
        for point, place in AT.items():
            assert found.numbers[f"{point}_x_mean_square"] == pytest.approx(exact[place], rel=1e-6)
            assert found.numbers[f"{point}_v_mean_square"] == pytest.approx(exact[24 + place], rel=3e-2)


def test_a_springpot_at_a_point_of_a_few_modes() -> None:
    """Against the integral of the response of all 24 coordinates."""
    damping = 0.05 * MASS + 2e-3 * STIFFNESS
    system = sp.System.from_matrices(MASS, STIFFNESS, damping, names=AT, modes=6, residual=["tip", "middle"])
    pot = sp.Springpot(0.4, 0.8, between=("ground", "tip"))
    found = sp.theory.linear(sp.System(*system.parts, pot, sp.WhiteNoise(1.0, on="middle")))

    def response(w: Any) -> Any:
        dynamic = STIFFNESS + 1j * w * damping - w**2 * MASS
        dynamic[TIP, TIP] += 0.8 * (1j * w) ** 0.4
        return np.abs(np.linalg.solve(dynamic, np.eye(24)[MIDDLE])[[TIP, MIDDLE]]) ** 2 / np.pi

    ends = [0.0, *np.sort(np.outer(precise(MASS, STIFFNESS)[:12], [0.97, 1.03]).ravel()), 1e4]
    parts = [integrate.quad_vec(response, *pair, epsrel=1e-9)[0] for pair in itertools.pairwise(ends)]
    exact = np.sum(parts, axis=0)
    for point, value in zip(AT, exact, strict=True):
        assert found.numbers[f"{point}_x_mean_square"] == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(("modes", "residual"), [validation(8, []), (7, ["tip"])])
def test_300_coordinates_and_a_stop(modes: int, residual: list[str]) -> None:
    """In thermal noise the mean square at an elastic stop at 0 is kT times the whole model's static flexibility."""
    system = sp.System.from_matrices(
        *map(sparse.csr_array, beam(150)), modes=modes, names={"tip": 298}, damping_ratios=0.1, residual=residual
    )
    assert len(system.coordinates.names) == 8
    assert sp.theory.modes(system).frequencies[0] == pytest.approx(1.875104069**2, rel=1e-7)
    stopped = sp.System(
        *system.parts, sp.ThermalNoise(0.6), stop=sp.Barrier(0.0, 1.0, free_side="above", between=("ground", "tip"))
    )
    exact = sp.theory.exact(stopped)
    assert exact.numbers["tip_x_mean_square"] == pytest.approx(0.2, rel=1e-6 if residual else 3e-4)
    run = sp.simulate(stopped, paths=400, duration=20.0, window=(5.0, 20.0), seed=1)
    for name in ("tip_x_mean_square", "tip_x_mean", "stop_impact_rate"):
        assert abs(run[name].value - exact.numbers[name]) < 4.0 * run[name].error
        assert run[name].error < 0.02 * abs(exact.numbers[name])


@pytest.mark.parametrize("form", [np.asarray, sparse.csc_array])
def test_what_is_left_out_is_said(form: Any) -> None:
    """Against the flexibility of the matrices themselves."""

    def few(modes: int, **more: Any) -> tuple[Any, dict[str, str]]:
        return said(lambda: sp.System.from_matrices(form(MASS), form(STIFFNESS), names=AT, modes=modes, **more))

    system, words = few(1, ground=UP)
    left = 1.0 - flexibility(system, "middle") * STIFFNESS_AT_MIDDLE
    assert 0.05 < left < 0.2
    assert list(words) == ["modes_left_out"]
    assert words["modes_left_out"].startswith("1 of 24 modes are kept, up to 0.5596 Hz: those left out have ")
    assert f"{100.0 * left:.2g} % of the static flexibility at middle, " in words["modes_left_out"]
    assert words["modes_left_out"].endswith("% of the mass that the ground moves.")
    kept, words = few(2, residual=["middle"])
    assert words == {}
    assert flexibility(kept, "middle") * STIFFNESS_AT_MIDDLE == pytest.approx(1.0, rel=1e-10)
    assert few(5)[1] == {}
    assert flexibility(few(1, residual=["middle", "tip"])[0], "tip") == pytest.approx(1.0 / 3.0, rel=1e-10)


STIFFNESS_AT_MIDDLE = 1.0 / np.linalg.inv(STIFFNESS)[MIDDLE, MIDDLE]


@pytest.mark.parametrize("form", [np.asarray, sparse.csr_array])
def test_coordinates_without_a_mass_are_condensed(form: Any) -> None:
    """Guyan's condensation of the angles, written out; it is exact where nothing acts on them."""
    lumped = np.where(np.arange(24) % 2, 0.0, np.where(np.arange(24) == TIP, 0.5, 1.0) / 12.0)
    heavy, light = np.arange(0, 24, 2), np.arange(1, 24, 2)
    follow = -np.linalg.solve(STIFFNESS[np.ix_(light, light)], STIFFNESS[np.ix_(light, heavy)])
    condensed = STIFFNESS[np.ix_(heavy, heavy)] + STIFFNESS[np.ix_(heavy, light)] @ follow
    squares = linalg.eigh(condensed, np.diag(lumped[heavy]), eigvals_only=True)
    points = {"tip": TIP, "slope": TIP + 1}
    matrices = form(np.diag(lumped)), form(STIFFNESS)
    few, words = said(lambda: sp.System.from_matrices(*matrices, names=points, modes=5, residual=["tip"]))
    assert sp.theory.modes(few).frequencies[:5] ** 2 == pytest.approx(squares[:5], rel=1e-9)
    assert words["massless_coordinates"].startswith("coordinates without a mass, 12 of 24, follow the others")
    whole, words = said(lambda: sp.System.from_matrices(*matrices, names=points))
    assert sp.theory.modes(whole).frequencies ** 2 == pytest.approx(squares, rel=1e-8)
    assert flexibility(whole, "tip") == pytest.approx(1.0 / 3.0, rel=1e-10)
    row = follow[-1]
    own = row @ np.linalg.solve(condensed, row)
    assert flexibility(whole, "slope") == pytest.approx(own, rel=1e-9)
    assert f"{100.0 * (1.0 - own):.2g} % of the static flexibility at slope." in words["modes_left_out"]
    with pytest.raises(ValueError, match="residual must name points where what is left out has a mass"):
        sp.System.from_matrices(*matrices, names=points, modes=12, residual=["slope"])


def test_springs_in_a_row_around_a_coordinate_without_a_mass() -> None:
    """A mass on two springs in a row, of 1 and 3 N/m: one of 0.75 N/m, with a point between them."""
    with pytest.warns(sp.ProblemWarning, match="1 of 2"), pytest.warns(sp.AccuracyWarning, match="flexibility at m1"):
        pair = sp.System.from_matrices([[0.0, 0.0], [0.0, 2.0]], [[4.0, -3.0], [-3.0, 3.0]])
    assert pair.points == ("mode_1", "m1", "m2")
    assert pair.stiffness_matrix == pytest.approx(np.array([[0.75]]))
    assert pair.of(sp.Point)[0].shares == pytest.approx((0.75,))


@pytest.mark.parametrize("form", [np.asarray, sparse.csc_array])
def test_a_beam_that_nothing_holds(form: Any) -> None:
    """It is said; residual modes have the flexibility of the elastic motion, and what it leaves alone stays finite."""
    mass, stiffness = beam(20, held=False)
    bend = np.zeros(42)
    bend[[0, 20, 40]] = 0.5, -1.0, 0.5
    points = {"middle": 20, "bend": bend}

    def free() -> sp.System:
        return sp.System.from_matrices(
            form(mass), form(stiffness), names=points, modes=5, residual=["middle"], damping_ratios=0.05
        )

    system, words = said(free)
    assert words["free_modes"].startswith("2 modes have a frequency of 0: unless a part that you add holds it")
    own = sp.theory.modes(system)
    assert own.frequencies[:2].tolist() == [0.0, 0.0]
    assert np.sqrt(own.frequencies[2:5]) == pytest.approx([4.730041, 7.853205, 10.995608], rel=1e-4)
    squares, shapes = linalg.eigh(stiffness, mass)
    exact = (shapes[20, 2:] ** 2 / squares[2:]).sum()
    at = system.points.index("middle")
    assert (own.shapes[at, 2:] ** 2 / own.frequencies[2:] ** 2).sum() == pytest.approx(exact, rel=1e-8)
    noise = sp.WhiteNoise(1.0, on="middle")
    assert "no spring pulls mode_1, mode_2" in sp.theory.linear(sp.System(*system.parts, noise)).stationary
    run = sp.simulate(sp.System(*system.parts, noise), paths=300, duration=6.0, window=(3.0, 6.0), start="rest")
    elastic = sum(
        (own.shapes[system.points.index("bend"), n] * own.shapes[at, n]) ** 2 / (4.0 * 0.05 * own.frequencies[n] ** 3)
        for n in (2, 4, 5)
    )
    found = run["bend_x_mean_square"]
    assert found.value == pytest.approx(elastic, abs=4.0 * found.error + 0.01 * elastic)
    assert run["middle_x_mean_square"].value > 10.0 * found.value


def test_free_motion_is_said_of_springs_and_of_modes() -> None:
    _, words = said(lambda: sp.System.from_matrices(np.eye(2), [[1.0, -1.0], [-1.0, 1.0]]))
    assert words["free_modes"].startswith("1 mode has a frequency of 0")
    _, words = said(lambda: sp.System.from_modes([0.0, 0.0, 3.0], 1.0, {"a": [1.0, 1.0, 1.0]}))
    assert words["free_modes"].startswith("2 modes have a frequency of 0")
    assert said(lambda: sp.System.from_matrices(np.eye(2), [[2.0, -1.0], [-1.0, 2.0]]))[1] == {}


def test_few_masses_among_many_coordinates() -> None:
    """Against the same matrices as arrays."""
    lumped = np.diag(np.where(np.arange(300) % 60 == 58, 0.2, 0.0))
    stiffness = beam(150)[1]
    with pytest.warns(sp.ProblemWarning, match="without a mass, 295 of 300"):
        one, two = (
            sp.System.from_matrices(form(lumped), form(stiffness), names={"tip": 298}, modes=3, residual=["tip"])
            for form in (np.asarray, sparse.csc_array)
        )
    assert sp.theory.modes(one).frequencies == pytest.approx(sp.theory.modes(two).frequencies, rel=1e-7)
    assert flexibility(two, "tip") == pytest.approx(1.0 / 3.0, rel=1e-6)


def test_equal_frequencies_are_all_found() -> None:
    """Twenty beams that are not connected: Lanczos' method alone finds each frequency once."""
    mass, stiffness = (sparse.kron(sparse.csr_array(each), sparse.eye_array(20)) for each in beam(10))
    with pytest.warns(sp.AccuracyWarning, match="flexibility at tip"):
        system = sp.System.from_matrices(mass, stiffness, modes=8, names={"tip": 18 * 20})
    assert sp.theory.modes(system).frequencies == pytest.approx([1.875104**2] * 8, rel=1e-5)


@pytest.mark.parametrize("form", [np.asarray, sparse.csc_array])
def test_a_free_beam_of_seven_digits(form: Any) -> None:
    """Rounding makes the stiffness of rigid motion a little negative, or positive."""
    mass, stiffness = beam(20, held=False)
    factors = np.random.default_rng(3).uniform(-1.0, 1.0, stiffness.shape)
    rounded = stiffness * (1.0 + 2e-9 * (factors + factors.T))
    assert np.linalg.eigvalsh(rounded)[0] < -1e-5
    system, words = said(lambda: sp.System.from_matrices(form(mass), form(rounded), names={"middle": 20}, modes=5))
    assert "frequency of 0" in words["free_modes"]
    assert np.sqrt(sp.theory.modes(system).frequencies[2:5]) == pytest.approx([4.7300, 7.8532, 10.9956], rel=1e-3)


def test_damping_ratios() -> None:
    system = sp.System.from_matrices(MASS, STIFFNESS, names=AT, modes=3, damping_ratios=[0.01, 0.02, 0.03])
    for n, (mass, spring, dashpot) in enumerate(
        zip(system.of(sp.Mass), system.of(sp.Spring), system.of(sp.Dashpot), strict=True), 1
    ):
        ratio = dashpot.coefficient / (2.0 * math.sqrt(spring.stiffness * mass.value))
        assert ratio == pytest.approx(0.01 * n)
    plain = sp.System.from_matrices(np.eye(2), [[2.0, -1.0], [-1.0, 2.0]], damping_ratios=0.1)
    assert plain.points == ("mode_1", "mode_2", "m1", "m2")
    assert len(plain.of(sp.Dashpot)) == 2


def test_frequencies_in_hz() -> None:
    one = sp.System.from_modes([3.0, 4.0], 1.0, {"a": [1.0, 0.5]}, 0.1, unit="Hz")
    assert sp.theory.modes(one).frequencies / (2.0 * np.pi) == pytest.approx([3.0, 4.0])
    with pytest.raises(ValueError, match="unit must be"):
        sp.System.from_modes([3.0], 1.0, {"a": [1.0]}, unit="rpm")  # type: ignore[arg-type]


M, K = map(sparse.csr_array, beam(150))
DENSE = MASS, STIFFNESS
BAD: list[tuple[Matrices, dict[str, Any], str]] = [
    ((M, K), {"modes": 0}, "modes must be a whole number from 1 to 300, those of the matrices, not 0."),
    ((M, K), {"modes": 2.0}, "modes must be a whole number from 1 to 300"),
    ((M, K), {"modes": 301}, "modes must be a whole number from 1 to 300"),
    ((M, K), {"modes": None}, "mass must have fewer rows than 64, the most parts of a system, not 300: give modes"),
    ((M, K), {"names": None}, "names must be of some points, as {'tip': 299} for the last coordinate: a system has at"),
    ((M, K), {"names": {"tip": 300}}, "names of tip must be a coordinate from 0 to 299, not 300."),
    ((M, K), {"names": {"tip": [1.0]}}, "names of tip must be 300 numbers, one for each coordinate, not 1."),
    ((M, K), {"names": {"tip": True}}, "names of tip must be numbers in a row, one for each coordinate"),
    ((M, K), {"ground": [1.0]}, "ground must be 300 numbers, one for each coordinate, not 1."),
    ((M, K), {"residual": ["top"]}, "residual must have names of points: tip, not 'top'."),
    ((M, K), {"residual": "tip"}, "residual must be names of points, not 'tip'."),
    ((M, K), {"damping_ratios": [0.1]}, "damping_ratios must be 2 numbers, one for each mode, not 1."),
    ((M, K), {"damping_ratios": -0.1}, "damping_ratios must not be negative, and -0.1 is among them."),
    ((M, K), {"damping": -M}, "damping must take energy from every motion, but one has a coefficient of -"),
    (DENSE, {"damping": np.diag(UP), "names": {"damper_2": 0}}, "damper_2 cannot be the name of a point, for that of"),
    (DENSE, {"modes": None, "residual": ["tip"]}, "residual must be left out without modes=, for all modes are kept"),
    (DENSE, {"residual": ["tip", "middle"], "names": {"tip": 22, "middle": 22}}, "residual must not name points that"),
    ((M, -K), {}, "stiffness must not be negative for any motion, and must hold each coordinate that has no mass."),
    ((MASS, -STIFFNESS), {}, "stiffness must not be negative for any motion"),
    ((-M, K), {}, "mass must be positive definite: of one coordinate the mass is -0.0"),
    ((sparse.csr_array(sparse.eye_array(300, k=1) + sparse.eye_array(300, k=-1)) + 0.1 * M, K), {}, "mass must be"),
    ((np.ones((24, 24)), STIFFNESS), {}, "mass must not be singular: each motion must have a mass"),
    ((sparse.csr_array((300, 300)), K), {}, "mass must not be 0 everywhere."),
    ((1j * M, K), {}, "mass must be a matrix of real numbers, not of complex128."),
    ((M, K[:200]), {}, "stiffness must be a square matrix, not an array of shape (200, 300)."),
    ((M, K[:200, :200]), {}, "stiffness must be a matrix of 300 rows as the masses, not of 200."),
    ((M * np.nan, K), {}, "mass must be a matrix of finite numbers."),
    ((sparse.eye_array(300_000), K), {}, "mass must have at most 200,000 rows and 20,000,000 numbers."),
    ((np.broadcast_to(1.0, (4000, 4000)), K), {}, "mass must have at most 3,000 rows; one of scipy.sparse may have"),
    ((M, sparse.csr_array(sparse.triu(K))), {}, "rounding leaves 1e-09 at most; of a matrix that is stored on one"),
    ((np.diag([1.0, 1.0, 0.0]), np.diag([1.0, 1.0, 0.0])), {}, "mass and stiffness must not both be 0 in a row, as"),
    (beam(20, held=False), {"modes": 1}, "modes must be more than 1, for nothing holds the motion of 1 or more."),
]  # fmt: skip


@pytest.mark.parametrize(("matrices", "given", "sentence"), BAD)
def test_bad_input_is_refused_in_one_sentence(matrices: Matrices, given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        sp.System.from_matrices(*matrices, **{"names": {"tip": 2}, "modes": 2} | given)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert str(caught.value).endswith((".", "?"))
