"""Exact law and linearization of several masses: closed forms, one mass as the case of one row, and Monte Carlo."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.theory import exact, linear, linearization, solve_all
from springpot.theory.methods.systems.boltzmann import exact_of_points

POINTS = ("ground", "a", "b", "c", "d")
ENDS = [*itertools.pairwise(POINTS)]
LINK, LAST = ("a", "b"), ("ground", "c")
MASSES = sp.Mass(1.0, at="a"), sp.Mass(0.7, at="b"), sp.Mass(0.5, at="c")
SPRINGS = [sp.Spring(k, between=e) for k, e in zip((3.0, 2.0, 1.5, 1.0), (*ENDS[:3], LAST), strict=True)]
HOT = sp.ThermalNoise(0.5)


def cubic(k3: float, ends: Any = None, k2: float = 0.0) -> sp.PolynomialSpring:
    return sp.PolynomialSpring((0.0, k2, k3), between=ends)


# --- the exact law -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damper", [sp.Dashpot(0.3, between=ENDS[0]), sp.Springpot(0.4, 0.3, between=ENDS[0])])
def test_three_masses_that_strike_each_other(damper: object) -> None:
    walls = sp.Barrier(-0.2, between=ENDS[1]), sp.Barrier(-0.3, between=ENDS[2])
    found = exact(sp.System(*MASSES, *SPRINGS, damper, HOT, *walls))
    for what, wanted in {
        "x_mean": (-0.095144, 0.108922, 0.285433),
        "x_mean_square": (0.144533, 0.195483, 0.300795),
        "v_mean_square": (0.5, 0.714286, 1.0),
    }.items():
        assert [found.moments[f"{point}_{what}"] for point in "abc"] == pytest.approx(wanted, abs=6e-7)
    for what, of_two in {
        "impact_rate": (0.609802, 0.574781),
        "impact_speed_mean": (1.381085, 1.640973),
        "force_mean": (0.693567, 0.550200),
    }.items():
        assert [found.moments[f"barrier_{n}_{what}"] for n in (1, 2)] == pytest.approx(of_two, abs=6e-7)
    # the force of both walls, and of the springs, on the last mass
    held = 1.5 * found.b_c_elongation_mean + 1.0 * found.c_x_mean
    assert held == pytest.approx(found.barrier_2_force_mean, rel=1e-8)


def test_two_masses_that_strike_each_other() -> None:
    springs = [sp.Spring(k, between=e) for k, e in zip((2.0, 1.0, 0.5), (*ENDS[:2], ("ground", "b")), strict=True)]
    pair = sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b")
    dashpot = sp.Dashpot(0.1, between=LINK)
    stop = sp.Barrier(-0.3, between=LINK)
    found = exact(sp.System(*pair, *springs, dashpot, sp.ThermalNoise(0.6), stop=stop))
    assert (found.stop_impact_rate, found.stop_force_mean) == pytest.approx((0.434012, 0.486526), abs=6e-7)
    turned = sp.Barrier(0.3, free_side="below", between=("b", "a"))
    again = exact(sp.System(*pair, *springs, dashpot, sp.ThermalNoise(0.6), stop=turned))
    assert again.b_x_mean_square == pytest.approx(found.b_x_mean_square, rel=1e-9)


def test_everything_at_once_against_a_sum_over_a_grid() -> None:
    parts = cubic(1.0, ENDS[0], 0.4), sp.Contact(-0.4, 6.0, between=LINK), sp.Barrier(-0.7, between=("ground", "b"))
    force = sp.Constant(-0.3, on="b")
    found = exact(sp.System(*MASSES[:2], *SPRINGS[:2], sp.Dashpot(0.2, between=LINK), HOT, force, *parts))
    low, high = np.linspace(-4.0, 4.0, 1001), np.linspace(-0.7, 4.5, 1001)
    a, b = np.meshgrid(low, high, indexing="ij")
    depth = np.maximum(-0.4 - (b - a), 0.0)
    energy = 1.5 * a**2 + (b - a) ** 2 + 0.4 * a**3 / 3.0 + a**4 / 4.0 + 6.0 * depth**2.5 / 2.5 + 0.3 * b
    weight = np.exp(-energy / 0.5)

    def mean(what: Any) -> float:
        return float(integrate.simpson(integrate.simpson(weight * what, x=high, axis=1), x=low))

    whole = mean(1.0)
    assert found.a_x_mean == pytest.approx(mean(a) / whole, rel=1e-7)
    assert found.b_x_mean_square == pytest.approx(mean(b * b) / whole, rel=1e-7)
    assert found.a_b_elongation_mean_square == pytest.approx(mean((b - a) ** 2) / whole, rel=1e-7)
    assert found.contact_force_mean == pytest.approx(mean(6.0 * depth**1.5) / whole, rel=1e-6)
    at_wall = float(integrate.simpson(weight[:, 0], x=low)) / whole
    assert found.barrier_impact_rate == pytest.approx(at_wall * math.sqrt(0.5 / 0.7 / (2.0 * math.pi)), rel=1e-7)
    assert found.barrier_force_mean == pytest.approx(0.5 * at_wall, rel=1e-7)


@pytest.mark.parametrize(
    "parts",
    [
        (sp.Spring(1.0), cubic(1.0, None, 0.1), sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")),
        (sp.Spring(-4.0), cubic(1.0)),
        (sp.Spring(1.0), sp.Contact(0.0, 100.0), sp.Constant(-3.0)),
        (sp.Barrier(0.0, free_side="above"), sp.Constant(-9.81)),
        (sp.Spring(1.0), sp.Barrier(-1e-4), sp.Barrier(1e-4, free_side="below")),
        (sp.Barrier(-1.0), sp.Barrier(2.0, free_side="below")),
        (sp.Spring(1.0), sp.Barrier(6.0, free_side="above")),
        (cubic(1e6), sp.Springpot(0.0, 2.0)),
    ],
)
def test_one_mass_is_the_case_of_one_row(parts: tuple[Any, ...]) -> None:
    system = sp.System(sp.Mass(2.0), *parts, sp.Dashpot(0.3), sp.WhiteNoise(0.2))
    ours, theirs = exact_of_points(system), exact(system)
    assert ours.of_parts.keys() == theirs.moments.of_parts.keys()
    spread = math.sqrt(theirs.x_mean_square)
    for name, value in theirs.numbers.items():
        size = spread if name == "x_mean" else 10.0 * abs(value) if name == "contact_force_mean" else abs(value)
        assert ours[name] == pytest.approx(value, abs=1e-9 * size, nan_ok=True), name


def test_weights_stand_on_each_other() -> None:
    walls = [sp.Barrier(0.0, free_side="above", between=e) for e in ENDS[:3]]
    weights = [sp.Constant(-9.81 * m, on=p) for m, p in zip((1.0, 0.7, 0.5), "abc", strict=True)]
    found = exact(sp.System(*MASSES, *walls, *weights, *(sp.Dashpot(0.1, between=e) for e in ENDS[:3]), HOT))
    carried = [found.moments[f"barrier_{n}_force_mean"] for n in (1, 2, 3)]
    assert carried == pytest.approx([9.81 * 2.2, 9.81 * 1.2, 9.81 * 0.5], rel=1e-9)
    assert found.a_x_mean == pytest.approx(0.5 / (9.81 * 2.2), rel=1e-8)


def test_many_masses_with_few_walls_and_what_falls_apart() -> None:
    """The rest is normal whatever its number; independent walls may be many, and each part has its own temperature."""
    size = 8
    points = [f"m{n}" for n in range(size)]
    masses = [sp.Mass(1.0 + n, at=point) for n, point in enumerate(points)]
    chain = [sp.Spring(2.0, between=e) for e in itertools.pairwise(("ground", *points))]
    damped = [sp.Springpot(0.5, 0.1, between=("ground", points[-1]))]
    free = sp.System(*masses, *chain, *damped, HOT)
    ours, theirs = exact(free), linear(free)
    assert ours.m7_x_mean_square == pytest.approx(theirs.m7_x_mean_square, rel=1e-12)
    assert ours.m2_m3_elongation_mean_square == pytest.approx(0.25, rel=1e-12)
    stopped = exact(sp.System(*masses, *chain, *damped, HOT, sp.Barrier(0.0, between=("m2", "m3"))))
    assert stopped.m2_m3_elongation_mean == pytest.approx(math.sqrt(2.0 / math.pi) * 0.5, rel=1e-9)  # a chain: alone
    assert stopped.m3_m4_elongation_mean_square == pytest.approx(0.25, rel=1e-9)
    ends = [("ground", point) for point in points]
    apart = [[sp.Spring(1.0, between=e), sp.Dashpot(0.1, between=e), sp.Barrier(0.0, between=e)] for e in ends]
    noise = [sp.WhiteNoise(0.2 * (n + 1), on=point) for n, point in enumerate(points)]
    each = exact(sp.System(*masses, *itertools.chain(*apart), *noise))
    for n, point in enumerate(points):  # kT = q / 2 c
        assert each.moments[f"{point}_x_mean_square"] == pytest.approx(n + 1.0, rel=1e-9)
        assert each.moments[f"{point}_v_mean_square"] == pytest.approx(1.0, rel=1e-12)


WHITE = sp.WhiteNoise(1.0, on="a")
DAMPED = [sp.Dashpot(0.1, between=e) for e in (*ENDS[:3], LAST)]


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((*DAMPED, HOT, sp.Barrier(-0.2, 0.7, between=LINK)), "not barrier of restitution 0.7"),
        ((*DAMPED, WHITE), "the white noise of a, b and c is not"),
        ((sp.Springpot(0.5, 0.1, between=LINK), WHITE), "not white noise without ThermalNoise with springpot"),
        ((*DAMPED, HOT, sp.Harmonic(1.0, 1.0, on="a")), "not harmonic"),
        ((*DAMPED, WHITE, sp.Friction(1.0, between=LINK)), "not friction"),
    ],
)
def test_what_the_exact_law_does_not_cover(parts: tuple[Any, ...], sentence: str) -> None:
    system = sp.System(*MASSES, *SPRINGS, *parts)
    assert sentence in solve_all(system)[1]["exact"]
    with pytest.raises(NotCoveredError, match=sentence):
        exact(system)


def test_four_that_depend_on_each_other_are_refused() -> None:
    masses = [sp.Mass(1.0, at=point) for point in POINTS[1:]]
    grounded = [sp.Spring(1.0, between=("ground", point)) for point in POINTS[1:]]
    walls = [sp.Barrier(-0.3, between=e) for e in ENDS]
    system = sp.System(*masses, *grounded, *walls, sp.Dashpot(0.1, between=LINK), HOT)
    assert "at most 3 elongations depend on each other, not the 4" in solve_all(system)[1]["exact"]


def test_without_a_stationary_state_it_says_why() -> None:
    wall = sp.Barrier(-0.2, between=LINK)
    for parts, sentence in (
        ((*SPRINGS, wall, HOT), "nothing dissipates the energy of a, b and c"),
        ((SPRINGS[1], wall, *DAMPED, HOT), "no spring"),
        ((*SPRINGS, *DAMPED), "nothing excites the motion of a, b and c"),
    ):
        assert sentence in str(exact(sp.System(*MASSES, *parts)).stationary)
    twins = sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *(sp.Spring(1.0, between=("ground", p)) for p in "ab")
    found = exact(sp.System(*twins, sp.Springpot(0.5, 1.0, between=LINK), HOT, cubic(1.0, LINK)))
    assert "nothing dissipates the energy of the mode at 1 rad/s" in str(found.stationary)


@pytest.mark.validation
def test_the_exact_law_is_that_of_a_run() -> None:
    parts = cubic(1.0, ENDS[0]), sp.Contact(-0.4, 50.0, between=LINK), sp.Barrier(-0.7, between=("ground", "b"))
    system = sp.System(*MASSES[:2], *SPRINGS[:2], sp.Springpot(0.5, 0.3, between=LINK), HOT, *parts)
    found, run = exact(system), sp.simulate(system, paths=4000, duration=60.0, seed=3)
    for name, value in found.numbers.items():
        if name in run:
            own = run[name]
            assert abs(own.value - value) < 4.0 * own.error + 0.005 * abs(value), name


# --- linearization -------------------------------------------------------------------------------------------------


@pytest.mark.validation  # every day: a chain against Monte Carlo, in this file
def test_decoupled_masses_are_those_alone() -> None:
    on = {"a": ("ground", "a"), "b": ("b", "ground")}
    first = sp.Spring(1.0), cubic(1.0), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0)
    second = sp.Spring(2.0), cubic(1.0, None, 0.5), sp.PolynomialDashpot((0.1, 0.2, 0.3)), sp.WhiteNoise(0.5)
    placed: list[Any] = []
    for point, parts in zip("ab", (first, second), strict=True):
        for part in parts:
            where = {"on": point} if isinstance(part, sp.WhiteNoise) else {"between": on[point]}
            placed.append(
                type(part)(**{name: getattr(part, name) for name in part.numbers if name not in where}, **where)
            )
    both = linearization(sp.System(sp.Mass(1.0, at="a"), sp.Mass(0.7, at="b"), *placed))
    for point, mass, parts, sign in (("a", 1.0, first, 1.0), ("b", 0.7, second, -1.0)):
        alone = linearization(sp.System(sp.Mass(mass), *parts))
        for name in ("x_mean_square", "v_mean_square"):
            assert both.moments[f"{point}_{name}"] == pytest.approx(alone.moments[name], rel=1e-8)
        assert both.moments[f"{point}_x_mean"] == pytest.approx(sign * alone.x_mean, abs=1e-9)
    assert both.stiffness.shape == (2, 2)


@pytest.mark.validation  # every day: a chain against Monte Carlo, in this file
def test_a_mass_on_one_that_stands_still_is_that_alone() -> None:
    parts = {"spring": sp.Spring(1.0), "pot": sp.Springpot(0.5, 1.0), "bent": cubic(1.0, None, 0.3)}
    alone = linearization(sp.System(*parts.values(), sp.WhiteNoise(1.0), sp.Constant(0.3)))
    held = sp.Mass(1e12, at="a"), sp.Spring(1e14, between=ENDS[0]), sp.Dashpot(1e13, between=ENDS[0])
    on_it = sp.Spring(1.0, between=LINK), sp.Springpot(0.5, 1.0, between=LINK), cubic(1.0, LINK, 0.3)
    found = linearization(
        sp.System(*held, sp.Mass(1.0, at="b"), *on_it, sp.WhiteNoise(1.0, on="b"), sp.Constant(0.3, on="b"))
    )
    assert found.a_b_elongation_mean == pytest.approx(alone.x_mean, rel=1e-8)
    assert found.a_b_elongation_mean_square == pytest.approx(alone.x_mean_square, rel=1e-8)
    assert found.b_v_mean_square == pytest.approx(alone.v_mean_square, rel=1e-8)


def test_of_a_linear_system_it_is_linear() -> None:
    system = sp.System(*MASSES, *SPRINGS, *DAMPED, WHITE, sp.ColoredNoise(0.5, 0.7, on="c"), sp.Constant(0.4, on="b"))
    ours, theirs = linearization(system), linear(system)
    assert ours.is_exact
    for name, value in theirs.numbers.items():
        assert ours.moments[name] == pytest.approx(value, rel=1e-9)


def test_two_duffing_masses_in_thermal_noise() -> None:
    """Off the exact law as one mass is: <v^2> true, <x^2> some per cent too small, and it says so."""
    bent = cubic(1.0, ENDS[0]), cubic(2.0, LINK)
    system = sp.System(*MASSES[:2], *SPRINGS[:2], *bent, sp.Springpot(0.5, 0.3, between=LINK), sp.ThermalNoise(1.0))
    ours, true = linearization(system), exact(system)
    assert [ours.moments[f"{p}_v_mean_square"] for p in "ab"] == pytest.approx([1.0, 1.0 / 0.7], rel=1e-8)
    for name in ("a_x_mean_square", "b_x_mean_square", "a_b_elongation_mean_square"):
        assert -0.1 < ours.moments[name] / true.moments[name] - 1.0 < -0.005
    assert not ours.is_exact


def test_a_chain_of_duffing_masses_against_monte_carlo() -> None:
    bent = cubic(1.0, ENDS[0]), cubic(2.0, LINK)
    dampers = sp.Dashpot(0.5, between=ENDS[0]), sp.Dashpot(0.3, between=LINK)
    system = sp.System(*MASSES[:2], *SPRINGS[:2], *bent, *dampers, WHITE)
    ours, run = linearization(system), sp.simulate(system, paths=512, duration=150.0, seed=2)
    low = {"x_mean_square": (-0.03, 0.0), "v_mean_square": (-0.01, 0.015), "elongation_mean_square": (-0.05, -0.01)}
    for name in (
        "a_x_mean_square",
        "b_x_mean_square",
        "a_v_mean_square",
        "b_v_mean_square",
        "a_b_elongation_mean_square",
    ):
        least, most = next(limits for what, limits in low.items() if name.endswith(what))
        gap, error = ours.moments[name] / run[name].value - 1.0, 3.0 * run[name].error / run[name].value
        assert least - error < gap < most + error, name


@pytest.mark.validation  # every day: what is not covered, in test_registry.py
def test_what_linearization_of_several_does_not_cover() -> None:
    for parts, sentence in (
        ((sp.Spring(-5.0, between=ENDS[0]), cubic(1.0, ENDS[0])), "not two wells"),
        ((sp.Harmonic(1.0, 1.0, on="a"),), "not harmonic"),
        ((sp.Barrier(0.0, between=LINK),), "not barrier"),
    ):
        assert sentence in solve_all(sp.System(*MASSES, *SPRINGS, *DAMPED, *parts, WHITE))[1]["linearization"]
    held = sp.System(*MASSES, *SPRINGS, sp.Spring(-2.0, between=ENDS[0]), cubic(1.0, ENDS[0]), *DAMPED, WHITE)
    assert linearization(held).a_x_mean == 0.0  # a spring that pushes where others hold


def test_an_elongation_that_never_happens_is_no_difficulty() -> None:
    twins = sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b")
    legs = [part(k, between=("ground", p)) for p in "ab" for part, k in ((sp.Spring, 1.0), (sp.Dashpot, 0.1))]
    found = linearization(sp.System(*twins, *legs, cubic(1.0, LINK), sp.WhiteNoise(0.1, on="ground")))
    assert found.a_x_mean_square == pytest.approx(0.5, rel=1e-9)
    assert found.a_b_elongation_mean_square < 1e-18
