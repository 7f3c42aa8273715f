"""Linear systems of several masses: against Lyapunov's equation, closed forms, and what has no stationary state."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy import integrate, linalg, optimize

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts.registration import Element
from springpot.theory import NoStationaryStateError, linear, modes, solve_all
from springpot.theory.registry import METHODS
from tests.sizes import thinned

BASE, STOREY = ("ground", "base"), ("base", "storey")
POINTS = ("ground", "a", "b", "c", "d")
ENDS = [*itertools.pairwise(POINTS)]


def isolated(*base: Element) -> sp.System:
    """A storey on a base on a soft mount, shaken."""
    return sp.System(
        sp.Mass(0.2, at="base"),
        sp.Mass(1.0, at="storey"),
        sp.Spring(1.2 * 0.16, between=BASE),
        *base,
        sp.Spring(4.0, between=STOREY),
        sp.Dashpot(0.08, between=STOREY),
        sp.WhiteNoise(0.1, on="ground"),
    )


def chain(*parts: object, between: float = 0.0) -> sp.System:
    """Four masses in a row, with a springpot beside each spring or, with ``between``, a dashpot."""
    masses = [sp.Mass(m, at=point) for m, point in zip((1.0, 1.0, 0.8, 0.6), POINTS[1:], strict=True)]
    springs = [sp.Spring(k, between=ends) for k, ends in zip((6.0, 5.0, 4.0, 3.0), ENDS, strict=True)]
    dampers = [sp.Dashpot(between, between=e) if between else sp.Springpot(0.5, 0.3, between=e) for e in ENDS]
    return sp.System(*masses, *springs, *dampers, *parts)


THREE = sp.System(
    sp.Mass(1.0, at="a"),
    sp.Mass(0.7, at="b"),
    sp.Mass(0.5, at="c"),
    *(sp.Spring(k, between=ends) for k, ends in zip((3.0, 2.0, 1.5, 1.0), (*ENDS[:3], ("ground", "c")), strict=True)),
    *(sp.Dashpot(c, between=ends) for c, ends in zip((0.3, 0.1, 0.2, 0.05), (*ENDS[:3], ("ground", "c")), strict=True)),
    sp.WhiteNoise(0.4, on="a"),
    sp.WhiteNoise(0.2, on="c"),
)


def lyapunov(system: sp.System) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Covariances of displacements and velocities at order 1, under white and filtered noise; the dampers' matrix."""
    at = system.coordinates
    parts = {name: part for name, part in system.named() if name in at.elongations}
    stiffness = at.sum_of({name: part.linear_stiffness for name, part in parts.items()})
    damping = at.sum_of({name: part.linear_damping for name, part in parts.items()})
    n, filters = len(at.points), system.of(sp.ColoredNoise, sp.KanaiTajimiNoise)
    size = 2 * n + 2 * len(filters)
    rates, noise = np.zeros((size, size)), np.zeros((size, size))
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n, :n] = -stiffness / at.masses[:, None]
    rates[n : 2 * n, n : 2 * n] = -damping / at.masses[:, None]
    for name, part in system.named():
        if isinstance(part, sp.WhiteNoise):
            push = at.forces[name] / at.masses
            noise[n : 2 * n, n : 2 * n] += part.intensity * np.outer(push, push)
    for place, part in enumerate(filters):
        u, push = 2 * n + 2 * place, at.push(part.on) / at.masses
        if isinstance(part, sp.ColoredNoise):
            rates[u, u], rates[u + 1, u + 1] = -1.0 / part.correlation_time, -1.0
            noise[u, u], rates[n : 2 * n, u] = 2.0 * part.variance / part.correlation_time, push
        else:
            w, z = part.frequency, part.damping
            rates[u, u + 1], rates[u + 1, u], rates[u + 1, u + 1] = 1.0, -w * w, -2.0 * z * w
            noise[u + 1, u + 1] = part.intensity
            rates[n : 2 * n, u], rates[n : 2 * n, u + 1] = w * w * push, 2.0 * z * w * push
    found = linalg.solve_continuous_lyapunov(rates, -noise)
    return found[:n, :n], found[n : 2 * n, n : 2 * n], damping


AT_ORDER_1 = {
    "isolated": isolated(sp.Dashpot(0.096, between=BASE)),
    "three": THREE,
    "chain": chain(sp.WhiteNoise(0.5, on="d"), between=0.2),
    "chain on the ground": chain(sp.WhiteNoise(0.2, on="ground"), between=0.2),
    "light": chain(sp.WhiteNoise(0.5, on="d"), between=2e-4),
    "locked": sp.System(
        sp.Mass(1.0, at="a"),
        sp.Mass(0.5, at="b"),
        sp.Spring(2.0, between=ENDS[0]),
        sp.Spring(1.0, between=ENDS[1]),
        sp.Dashpot(0.01, between=ENDS[0]),
        sp.Dashpot(1e3, between=ENDS[1]),
        sp.WhiteNoise(0.3, on="b"),
    ),
    "colored": chain(sp.ColoredNoise(0.5, 0.7, on="b"), sp.WhiteNoise(0.1, on="d"), between=0.2),
    "Kanai-Tajimi": chain(sp.KanaiTajimiNoise(3.0, 0.4, 1.0), sp.ColoredNoise(0.5, 0.7, on="ground"), between=0.2),
}


@pytest.mark.parametrize("system", thinned(AT_ORDER_1.values(), 2), ids=AT_ORDER_1)
def test_at_order_1_it_is_lyapunovs_solution(system: sp.System) -> None:
    of_x, of_v, _ = lyapunov(system)
    found = linear(system)
    for place, point in enumerate(system.points):
        assert found.moments[f"{point}_x_mean_square"] == pytest.approx(of_x[place, place], rel=1e-10)
        assert found.moments[f"{point}_v_mean_square"] == pytest.approx(of_v[place, place], rel=1e-10)
        assert found.moments[f"{point}_x_mean"] == 0.0
    assert system.coordinates.pairs
    for name, row in system.coordinates.pairs.items():
        assert found.moments[f"{name}_elongation_mean_square"] == pytest.approx(row @ of_x @ row, rel=1e-9)
    np.testing.assert_allclose(found.covariance(), of_x, atol=1e-10 * of_x.max())
    np.testing.assert_allclose(found.covariance("v"), of_v, atol=1e-10 * of_v.max())
    assert found.is_exact


def test_what_is_fed_is_dissipated() -> None:
    for system, fed in ((AT_ORDER_1["isolated"], 0.06), (THREE, 0.4)):
        damping = lyapunov(system)[2]
        assert np.sum(damping * linear(system).covariance("v")) == pytest.approx(fed, rel=1e-9)


@pytest.mark.parametrize(
    ("base", "wanted"),
    [
        (sp.Dashpot(0.096, between=BASE), (4.030783, 0.00680991, 0.623613, 0.676427)),
        (sp.Springpot(0.5, 0.3, between=BASE), (0.875381, 0.00502586, 0.223175, 0.260335)),
    ],
)
def test_base_isolation(base: Element, wanted: tuple[float, ...]) -> None:
    found = linear(isolated(base))
    drifts = found.base_x_mean_square, found.base_storey_elongation_mean_square
    assert (*drifts, found.base_v_mean_square, found.storey_v_mean_square) == pytest.approx(wanted, rel=2e-6)


def test_three_masses() -> None:
    found = linear(THREE)
    of_x = [found.moments[f"{point}_x_mean_square"] for point in "abc"]
    of_v = [found.moments[f"{point}_v_mean_square"] for point in "abc"]
    assert of_x == pytest.approx([0.192367, 0.425852, 0.410021], abs=6e-7)
    assert of_v == pytest.approx([0.503975, 0.720382, 0.955507], abs=6e-7)
    assert found.covariance()[0, 2] == pytest.approx(0.151020, abs=6e-7)


@pytest.mark.parametrize(
    ("noise", "of_x", "of_v"),
    [
        (
            sp.WhiteNoise(0.5, on="d"),
            (0.323663, 1.186845, 2.311279, 3.365156),
            (0.559014, 1.286159, 2.073149, 3.424681),
        ),
        (
            sp.WhiteNoise(0.2, on="ground"),
            (0.519935, 2.109637, 4.279264, 6.032396),
            (0.499164, 1.830854, 3.591163, 5.158331),
        ),
    ],
)
def test_a_chain_with_springpots(noise: sp.WhiteNoise, of_x: tuple[float, ...], of_v: tuple[float, ...]) -> None:
    found = linear(chain(noise))
    assert [found.moments[f"{point}_x_mean_square"] for point in "abcd"] == pytest.approx(of_x, abs=6e-7)
    assert [found.moments[f"{point}_v_mean_square"] for point in "abcd"] == pytest.approx(of_v, abs=6e-7)
    if noise.on == "d":
        assert found.covariance()[0, 3] == pytest.approx(0.875203, abs=6e-7)


def test_two_masses_with_springpots_of_two_orders() -> None:
    found = linear(
        sp.System(
            sp.Mass(1.0, at="a"),
            sp.Mass(0.5, at="b"),
            sp.Spring(2.0, between=ENDS[0]),
            sp.Spring(1.0, between=ENDS[1]),
            sp.Spring(0.5, between=("ground", "b")),
            sp.Springpot(0.5, 0.3, between=ENDS[0]),
            sp.Springpot(0.6, 0.4, between=ENDS[1]),
            sp.WhiteNoise(1.0, on="a"),
            sp.WhiteNoise(0.3, on="b"),
        )
    )
    numbers = [found.moments[f"{point}_{name}_mean_square"] for name in "xv" for point in "ab"]
    assert [*numbers, found.covariance()[0, 1]] == pytest.approx(
        [1.10655, 2.07334, 2.12105, 3.97442, 1.36775], abs=6e-6
    )


def test_one_mass_is_the_case_of_one_row() -> None:
    """A second mass so heavy that it stands still; and a named mass."""
    own = sp.Springpot(0.5, 0.4), sp.Maxwell(1.0, 2.0), sp.PiezoelectricCircuit(0.3, 2.0, 0.5), sp.Spring(8.0)
    noises = sp.WhiteNoise(1.0), sp.Harmonic(0.8, 1.2), sp.Constant(4.0), sp.KanaiTajimiNoise(3.0, 0.4, 1.0, on="mass")
    alone = linear(sp.System(sp.Mass(2.0), *own, *noises))
    link = ("held", "box")
    pair = linear(
        sp.System(
            sp.Mass(1e12, at="held"),
            sp.Mass(2.0, at="box"),
            sp.Spring(1e14, between=("ground", "held")),
            sp.Dashpot(1e13, between=("ground", "held")),
            sp.Springpot(0.5, 0.4, between=link),
            sp.Maxwell(1.0, 2.0, between=link),
            sp.PiezoelectricCircuit(0.3, 2.0, 0.5, between=link),
            sp.Spring(8.0, between=link),
            sp.WhiteNoise(1.0, on="box"),
            sp.Harmonic(0.8, 1.2, on="box"),
            sp.Constant(4.0, on="box"),
            sp.KanaiTajimiNoise(3.0, 0.4, 1.0, on="box"),
        )
    )
    for name in ("x_mean", "x_mean_square", "v_mean_square"):
        assert pair.moments[f"box_{name}"] == pytest.approx(alone.moments[name], rel=1e-9)
    assert pair.held_box_elongation_mean == pytest.approx(0.5)
    assert pair.held_box_elongation_mean_square == pytest.approx(alone.x_mean_square, rel=1e-9)
    assert pair.harvested_power == pytest.approx(alone.harvested_power, rel=1e-9)
    w = np.array([[0.3, 1.3], [2.0, 9.0]])
    assert pair.spectrum(w, of="box") == pytest.approx(alone.spectrum(w), rel=1e-9)
    assert alone.covariance().item() == pytest.approx(alone.x_mean_square - alone.x_mean**2)
    found = alone.frequency_response(w)
    assert np.array_equal(alone.frequency_response(w, of="mass", on="mass"), found)
    assert np.array_equal(alone.frequency_response(w, of="spring"), found)
    assert alone.frequency_response(w, on="ground") == pytest.approx(-2.0 * found)


def test_matched_noise_of_each_element_is_equipartition() -> None:
    dampers = (
        sp.Springpot(0.3, 0.8, between=ENDS[0]),
        sp.Maxwell(1.0, 2.0, between=ENDS[1]),
        sp.Dashpot(0.2, between=ENDS[2]),
        sp.PiezoelectricCircuit(0.5, 2.0, 0.5, between=ENDS[1]),
        sp.FractionalMaxwell(sp.Springpot(0.4, 2.0), sp.Spring(3.0), between=("ground", "c")),
    )
    springs = [sp.Spring(k, between=ends) for k, ends in zip((3.0, 2.0, 1.5), ENDS[:3], strict=True)]
    masses = sp.Mass(1.0, at="a"), sp.Mass(0.7, at="b"), sp.Mass(0.5, at="c")
    found = linear(sp.System(*masses, *springs, *dampers, sp.ThermalNoise(0.6)))
    stiffness = np.array([[5.0, -2.0, 0.0], [-2.0, 3.5, -1.5], [0.0, -1.5, 1.5]])
    np.testing.assert_allclose(found.covariance(), 0.6 * np.linalg.inv(stiffness), rtol=1e-12)
    assert found.covariance("v") == pytest.approx(np.diag([0.6, 0.6 / 0.7, 1.2]), abs=1e-14)
    u = np.linspace(-60.0, 11.0, 6001)
    w = np.exp(u)
    for noise in (
        found.spectrum(w, of="b"),
        found.spectral_matrix(w)[:, 1, 1].real,
    ):  # the spectra of each add up to that
        assert 2.0 * integrate.simpson(noise * w, x=u) == pytest.approx(found.b_x_mean_square, rel=1e-7)
    cross = found.spectral_matrix(w)[:, 0, 2]
    assert 2.0 * integrate.simpson(cross.real * w, x=u) == pytest.approx(found.covariance()[0, 2], rel=1e-7)
    assert found.spectrum(0.0, of="maxwell") == math.inf
    assert np.all(np.isfinite(found.spectrum([1e-3, 1.0], of="maxwell")))


def test_spectra_and_responses_are_those_of_the_matrices() -> None:
    system = chain(sp.WhiteNoise(0.2, on="ground"), sp.ColoredNoise(0.5, 0.7, on="b"))
    found, w = linear(system), np.array([0.7, -2.5])
    at = system.coordinates
    for place, frequency in enumerate(w):
        stiffness = at.sum_of(
            {f"spring_{n}": k for n, k in enumerate((6.0, 5.0, 4.0, 3.0), 1)}
        ) - frequency**2 * np.diag(at.masses)
        modulus = 0.3 * (1j * abs(frequency)) ** 0.5
        modulus = modulus if frequency > 0.0 else modulus.conjugate()
        inverse = np.linalg.inv(stiffness + at.sum_of({f"springpot_{n}": 1.0 for n in range(1, 5)}) * modulus)
        force = 0.2 / (2.0 * np.pi) * np.outer(at.masses, at.masses)
        force[1, 1] += sp.ColoredNoise(0.5, 0.7).density(frequency)
        wanted = inverse @ force @ inverse.conj().T
        np.testing.assert_allclose(found.spectral_matrix(w)[place], wanted, rtol=1e-12)
        assert found.spectrum(w, of="d")[place] == pytest.approx(wanted[3, 3].real)
        row = at.elongations["spring_2"]
        assert found.spectrum(w, of="spring_2")[place] == pytest.approx((row @ wanted @ row).real)
        if frequency > 0.0:
            assert found.frequency_response(frequency, of="a", on="d") == pytest.approx(inverse[0, 3])
            assert found.frequency_response(frequency, of="spring_2", on="ground") == pytest.approx(
                -row @ inverse @ at.masses
            )
    for of, on, sentence in (
        ("", "a", "of must be one of a, b, c, d, spring_1"),
        ("x", "a", "not 'x'"),
        ("a", "", "on must be one of a, b, c"),
    ):
        with pytest.raises(ValueError, match=sentence):
            found.frequency_response(1.0, of=of, on=on)
    with pytest.raises(ValueError, match="of must be one of a, b, c, d, spring_1"):
        found.spectrum(1.0)
    with pytest.raises(ValueError, match="of must be 'x' or 'v', not 'a'"):
        found.covariance("a")  # type: ignore[arg-type]


def absorber(share: float, ratio: float, damping: float, *noise: object) -> sp.System:
    """A tuned mass damper on an undamped mass of 1 with a frequency of 1."""
    return sp.System(
        sp.Mass(1.0, at="a"),
        sp.Mass(share, at="b"),
        sp.Spring(1.0, between=ENDS[0]),
        sp.Spring(share * ratio**2, between=ENDS[1]),
        sp.Dashpot(2.0 * damping * share * ratio, between=ENDS[1]),
        *noise,
    )


def test_den_hartogs_damper_has_two_equal_peaks() -> None:
    share = 0.05
    tuned = absorber(
        share, 1.0 / (1.0 + share), math.sqrt(3.0 * share / (8.0 * (1.0 + share))), sp.WhiteNoise(1.0, on="a")
    )
    found = linear(tuned)

    def peak(low: float, high: float) -> float:
        return -float(
            optimize.minimize_scalar(
                lambda w: -abs(found.frequency_response(float(w), of="a", on="a")),
                bounds=(low, high),
                method="bounded",
                options={"xatol": 1e-9},
            ).fun
        )

    assert (peak(0.7, 0.97), peak(0.97, 1.3)) == pytest.approx((6.4074, 6.4084), abs=1e-4)


@pytest.mark.parametrize(("on", "wanted"), [("a", 4.445436), ("ground", 4.781537)])
def test_the_best_damper_under_white_noise(on: str, wanted: float) -> None:
    share = 0.05
    if on == "a":
        ratio = math.sqrt(1.0 + share / 2.0) / (1.0 + share)
        damping = math.sqrt(share * (1.0 + 0.75 * share) / (4.0 * (1.0 + share) * (1.0 + share / 2.0)))
    else:
        ratio = math.sqrt(1.0 - share / 2.0) / (1.0 + share)
        damping = math.sqrt(share * (1.0 - share / 4.0) / (4.0 * (1.0 + share) * (1.0 - share / 2.0)))
    best = linear(absorber(share, ratio, damping, sp.WhiteNoise(1.0, on=on))).a_x_mean_square
    assert best == pytest.approx(wanted, abs=6e-7)
    for f, z in ((1.001, 1.0), (0.999, 1.0), (1.0, 1.01), (1.0, 0.99)):
        assert linear(absorber(share, f * ratio, z * damping, sp.WhiteNoise(1.0, on=on))).a_x_mean_square > best


def test_natural_modes() -> None:
    found = modes(isolated(sp.Springpot(0.5, 0.3, between=BASE)))
    assert found.frequencies == pytest.approx([0.393454, 4.980481], abs=6e-7)
    assert found.participations == pytest.approx([1.095330, 0.015901], abs=6e-7)
    four = modes(chain())
    assert four.frequencies == pytest.approx([0.89579, 2.22256, 3.37301, 4.07806], abs=6e-6)
    assert four.effective_masses.sum() == pytest.approx(3.4, rel=1e-13)
    masses = np.diag([1.0, 1.0, 0.8, 0.6])
    np.testing.assert_allclose(four.shapes.T @ masses @ four.shapes, np.eye(4), atol=1e-13)
    one = modes(sp.System(sp.Mass(2.0), sp.Spring(8.0)))
    assert one.points == ("mass",)
    assert (one.frequencies.item(), one.effective_masses.item()) == pytest.approx((2.0, 2.0))
    free = modes(sp.System(sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(0.5, between=ENDS[1])))
    assert free.frequencies.tolist() == pytest.approx([0.0, 1.0])
    assert free.effective_masses == pytest.approx([2.0, 0.0])
    assert modes(sp.System(sp.Springpot(0.0, 4.0), sp.Spring(5.0))).frequencies.item() == pytest.approx(3.0)


TWO = sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b")
NOISE = sp.WhiteNoise(1.0, on="a")


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (
            (sp.Spring(1.0, between=ENDS[1]), sp.Dashpot(1.0, between=ENDS[0])),
            "no spring pulls a and b back, so that they",
        ),
        (
            (sp.Spring(1.0, between=ENDS[0]), sp.Dashpot(1.0, between=ENDS[1])),
            "no spring pulls b back, so that it wanders",
        ),
        ((sp.Spring(1.0, between=ENDS[0]), sp.Spring(1.0, between=ENDS[1])), "nothing dissipates energy"),
        (
            (
                sp.Spring(1.0, between=ENDS[0]),
                sp.Spring(1.0, between=("ground", "b")),
                sp.Springpot(0.5, 1.0, between=ENDS[1]),
            ),
            "nothing dissipates the energy of the mode at 1 rad/s",
        ),
    ],
)
def test_without_a_stationary_state_it_says_why(parts: tuple[Element, ...], sentence: str) -> None:
    found = linear(sp.System(*TWO, *parts, NOISE))
    assert sentence in str(found.stationary)
    with pytest.raises(NoStationaryStateError, match=sentence):
        _ = found.a_x_mean
    assert found.to_dict()["a_x_mean_square"] is None
    assert np.isfinite(found.frequency_response(0.37, of="a", on="a"))


def test_an_elongation_that_never_happens_is_no_difficulty() -> None:
    """Two equal masses on equal springs move together with the ground."""
    found = linear(
        sp.System(
            *TWO,
            sp.Spring(1.0, between=ENDS[0]),
            sp.Spring(1.0, between=("ground", "b")),
            sp.Spring(1.0, between=ENDS[1]),
            sp.Dashpot(0.1, between=ENDS[0]),
            sp.Dashpot(0.1, between=("ground", "b")),
            sp.WhiteNoise(0.2, on="ground"),
        )
    )
    assert found.a_x_mean_square == pytest.approx(1.0, rel=1e-10)
    assert found.a_b_elongation_mean_square < 1e-20
    assert found.covariance() == pytest.approx(np.ones((2, 2)), rel=1e-10)


def test_what_is_not_covered_is_named() -> None:
    held = sp.Spring(1.0, between=ENDS[0]), sp.Spring(1.0, between=ENDS[1]), sp.Dashpot(0.1, between=ENDS[0])
    for part, name in (
        (sp.Barrier(-0.1, between=ENDS[1]), "barrier"),
        (sp.Contact(-0.1, 5.0, between=ENDS[1]), "contact"),
        (sp.PolynomialSpring((0.0, 0.0, 1.0), between=ENDS[1]), "polynomial_spring"),
        (sp.Friction(0.1, between=ENDS[0]), "friction"),
        (sp.RecordedExcitation((0.0, 1.0), (0.0, 1.0)), "recorded_excitation"),
    ):
        system = sp.System(*TWO, *held, part, NOISE)
        assert METHODS["linear"].covers(system).endswith(f"without walls and contacts, not {name}.")
        with pytest.raises(NotCoveredError, match=f"not {name}"):
            linear(system)


@pytest.mark.validation  # every day: what is not covered, in test_registry.py
def test_every_other_method_says_that_it_covers_one_mass() -> None:
    answers, statements = solve_all(THREE)
    assert [*answers] == ["linearization", "linear"]
    assert answers["linearization"].numbers == pytest.approx(answers["linear"].numbers, rel=1e-9)
    assert "white noise of a, b and c is not" in statements.pop("exact")
    assert {*statements} == {*METHODS} - {"linearization", "linear", "exact"}
    assert {*statements.values()} == {"one mass is needed, and the system has 3, a, b and c."}
    (line,) = [line for line in sp.explain(THREE).splitlines() if "one mass is needed" in line]
    assert line.startswith("  averaging_printed, averaging, 6 others: one mass")
    assert sp.recommended(THREE).method == "linear"


def test_of_several_masses_the_map_has_no_cell_and_it_is_said_once() -> None:
    bent = sp.System(*THREE.parts, sp.PolynomialSpring((0.0, 0.0, 1.0), between=ENDS[1]))
    best = sp.recommended(bent)
    assert (best.method, best.guess) == ("", "linearization")
    assert "the validity map has no cell near this system. The best guess is linearization" in best.why_none
    assert sum("map" in warning for warning in best.result.warnings) == 1
    assert "validity map has no cell near" in sp.trust(bent, "linearization").warnings[0]
    assert sp.recommended(sp.System(*THREE.parts, sp.Barrier(-1.0, 0.5, between=ENDS[1]))).guess == ""


def test_names_of_several_masses_are_those_of_their_points() -> None:
    answers = solve_all(THREE)[0]
    with pytest.raises(AttributeError, match="has no attribute 'x_mean'; did you mean a_x_mean"):
        _ = answers["linear"].x_mean
    assert "d_x_mean" not in dir(answers["linear"])
    assert "c_x_mean" in dir(answers["linear"])


def test_results_and_systems_are_shown_in_short() -> None:
    found = linear(THREE)
    assert repr(found).startswith("LinearResponse(method='linear', a_x_mean=0, a_x_mean_square=0.192367, ")
    assert repr(found.moments).startswith("Moments(a_x_mean=0, a_x_mean_square=0.192367, ")
    assert not any(word in repr(found) for word in ("nan", "array", "Companion"))
    assert eval(repr(THREE), {**vars(sp.problem.parts), "System": sp.System}) == THREE
    named = sp.System(*TWO, sp.Spring(1.0, between=ENDS[0]), stop=sp.Barrier(-1.0, between=ENDS[1]))
    assert repr(named).endswith("stop=Barrier(position=-1.0, restitution=1.0, free_side='above', between=('a', 'b')))")
    assert "stationary='There is no stationary state: no spring pulls b back" in repr(
        linear(sp.System(*named.parts[:3], NOISE))
    )
    run = sp.simulate(THREE, paths=64, step=0.02, duration=2.0)
    assert repr(run).startswith("Run(paths=64, duration=2.0, step=0.02: ")
