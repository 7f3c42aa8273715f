"""Half cycles between two unlike stops, against Monte Carlo, the exact law and the sentences about their error."""

from __future__ import annotations

import math

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.cells import cell_of
from springpot.evidence.recommendation import recommended
from springpot.evidence.reliability import trust, warnings_of
from springpot.theory import NotCoveredError, envelope, half_cycles, solve_all
from tests.sizes import thinned
from tests.struck import rates_of, speeds_of

SOFT = sp.PolynomialSpring((0.0, 0.0, -0.1))
WALLS = ("near_impact_rate", "far_impact_rate")


def between(order: float, c: float, gaps: tuple[float, float], losses: tuple[float, float]) -> sp.System:
    """Unit frequency, <x^2> = 1 without stops by the harmonic formula; the first gap and restitution are below."""
    pot = sp.Dashpot(c) if order == 1.0 else sp.Springpot(order, c)
    stops = {
        "near": sp.Barrier(-gaps[0], losses[0]),
        "far": sp.Barrier(gaps[1], losses[1], free_side="below"),
    }
    return sp.System(sp.Spring(1.0), pot, sp.WhiteNoise(2.0 * c * math.sin(order * math.pi / 2.0)), **stops)


def simulated_rates(system: sp.System, paths: int, seed: int, unit: float = 1.0) -> np.ndarray:
    """Impact rates of both walls, and their standard errors, at 240 units of time a path."""
    run = sp.simulate(
        system, paths=paths, duration=300.0 * unit, window=(60.0 * unit, 300.0 * unit), start="rest", seed=seed,
        distributions=False,
    )  # fmt: skip
    return np.array([[run[name].value, run[name].error] for name in WALLS])


TABLE = [  # order, c, gaps, restitutions; largest error of the near and the far stop in per cent
    (1.0, 0.2, (1.5, 2.2), (0.6, 0.6), 7.0, 6.0),
    (0.5, 0.3, (1.5, 2.2), (0.6, 0.6), 7.0, 10.0),
    (1.0, 0.2, (2.5, 3.2), (0.6, 0.6), 7.0, 6.0),
    (1.0, 0.05, (1.5, 2.0), (0.6, 0.6), 7.0, 6.0),
    (1.0, 0.5, (1.2, 1.8), (0.6, 0.6), 7.0, 6.0),
    (1.0, 0.2, (1.0, 2.5), (0.8, 0.5), 7.0, 6.0),
    (0.5, 0.1, (1.5, 2.2), (0.6, 0.6), 7.0, 10.0),
    (0.3, 0.2, (1.5, 2.2), (0.7, 0.7), 7.0, 10.0),
    (0.25, 0.5, (2.5, 3.5), (0.6, 0.6), 7.0, 10.0),
]


@pytest.mark.parametrize(("order", "c", "gaps", "losses", "near", "far"), thinned(TABLE, 5))
def test_rates_of_unlike_stops(
    order: float, c: float, gaps: tuple[float, float], losses: tuple[float, float], near: float, far: float
) -> None:
    system = between(order, c, gaps, losses)
    (first, first_se), (second, second_se) = simulated_rates(system, 4000, seed=11)
    found = rates_of(half_cycles(system))
    assert abs(found[0] - first) < 0.01 * near * first + 2.0 * first_se
    assert abs(found[1] - second) < 0.01 * far * second + 2.0 * second_se


@pytest.mark.validation
@pytest.mark.parametrize("number", range(10))
def test_ten_random_systems(number: int) -> None:
    """Drawn with seed 2711: orders 0.2 to 1, light to moderate damping, gaps of 1 to 3.5 standard deviations."""
    rng = np.random.default_rng((2711, number))
    order = float(rng.choice([1.0, rng.uniform(0.2, 0.9)]))
    c, nearer = math.exp(rng.uniform(math.log(0.05), math.log(0.4))), rng.uniform(1.0, 2.5)
    losses = tuple(rng.uniform(0.5, 0.9, 2).tolist())
    system = between(order, c, (nearer, nearer + rng.uniform(0.3, 1.0)), losses)
    (first, first_se), (second, second_se) = simulated_rates(system, 20_000, seed=1000 + number)
    found = rates_of(half_cycles(system))
    assert abs(found[0] - first) < 0.07 * first + 2.0 * first_se
    assert abs(found[1] - second) < (0.06 if order == 1.0 else 0.10) * second + 2.0 * second_se


def box(upper: float, lower: float = 4e-3) -> sp.System:
    """2.5 kg on four springpots of order 0.25: 68.9 rad/s without them, 96 rad/s with them."""
    mass, bare, with_them, order = 2.5, 68.9, 96.0, 0.25
    pot = mass * (with_them**2 - bare**2) / (with_them**order * math.cos(order * math.pi / 2.0))
    noise = sp.WhiteNoise(5.71)
    stops = {"near": sp.Barrier(-lower, 0.6), "far": sp.Barrier(upper, 0.6, free_side="below")}
    return sp.System(sp.Mass(mass), sp.Spring(mass * bare**2), sp.Springpot(order, pot), noise, **stops)


@pytest.mark.validation
@pytest.mark.parametrize("upper", [3e-3, 5e-3, 6e-3])
def test_a_box_on_four_springpots(upper: float) -> None:
    """The envelope is off by a factor of 1.9 and 3.6 at a far stop at 5 and 6 mm; the half cycles by a sixth."""
    system = box(upper)
    measured = simulated_rates(system, 20_000, seed=5, unit=1.0 / 96.0)
    found, other = rates_of(half_cycles(system)), rates_of(envelope(system))
    assert np.all(np.abs(found - measured[:, 0]) < 0.2 * measured[:, 0] + 2.0 * measured[:, 1])
    assert max(other / measured[:, 0]) > 1.4


@pytest.mark.parametrize(("c", "share"), [(0.05, 0.005), (0.2, 0.02)])
def test_elastic_stops_and_a_dashpot_against_the_exact_law(c: float, share: float) -> None:
    system = between(1.0, c, (1.0, 1.7), (1.0, 1.0))
    found, true = half_cycles(system), sp.theory.exact(system)
    for name in ("x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean"):
        assert getattr(found, name) == pytest.approx(getattr(true, name), rel=share), name
    assert rates_of(found) == pytest.approx(rates_of(true), rel=2.0 * share)


def test_a_cubic_spring_against_the_exact_law() -> None:
    stops = {"near": sp.Barrier(-0.8), "far": sp.Barrier(1.2, free_side="below")}
    cubic = sp.PolynomialSpring((0.0, 0.0, 0.6))
    system = sp.System(sp.Spring(1.0), cubic, sp.Dashpot(0.1), sp.WhiteNoise(0.2), **stops)
    found, true = half_cycles(system), sp.theory.exact(system)
    assert rates_of(found) == pytest.approx(rates_of(true), rel=0.02)
    assert found.x_mean_square == pytest.approx(true.x_mean_square, rel=0.02)


def test_densities_are_those_of_the_moments() -> None:
    found = half_cycles(between(0.5, 0.2, (1.2, 1.9), (0.7, 0.6)))
    x = np.linspace(-1.2, 1.9, 4001)
    density = found.x_density(x)
    assert np.trapezoid(density, x) == pytest.approx(1.0, abs=2e-3)
    assert np.trapezoid(density * x * x, x) == pytest.approx(found.x_mean_square, rel=5e-3)
    u = np.linspace(0.0, 8.0, 4001)
    for name, mean in zip(("near", "far"), speeds_of(found), strict=True):
        speeds = found.impact_speed_density(u, name)
        assert np.trapezoid(speeds, u) == pytest.approx(1.0, abs=5e-3)
        assert np.trapezoid(speeds * u, u) == pytest.approx(mean, rel=2e-2)


@pytest.mark.validation  # every day: rates of unlike stops, in this file
def test_units_and_sides_do_not_matter() -> None:
    """In SI units, and with the two stops exchanged."""
    mass, length, time = 0.4, 2e-3, 0.01
    force = mass * length / time**2
    here = rates_of(half_cycles(between(0.5, 0.2, (1.2, 1.9), (0.7, 0.6))))
    q = 0.4 * math.sin(math.pi / 4.0)
    there = rates_of(half_cycles(
        sp.System(
            sp.Mass(mass), sp.Spring(mass / time**2), sp.Springpot(0.5, 0.2 * mass * time**-1.5),
            sp.WhiteNoise(q * force**2 * time),
            sp.Barrier(1.2 * length, 0.7, free_side="below"), sp.Barrier(-1.9 * length, 0.6),
        )
    ))  # fmt: skip
    assert [rate * time for rate in there] == pytest.approx(here, rel=1e-9)


def test_the_better_of_half_cycles_and_envelope_is_recommended() -> None:
    """The envelope between like elastic stops; the half cycles where a lossy far stop is struck rarely."""
    for system, better, worse in (
        (between(0.5, 0.1, (1.0, 1.0), (1.0, 1.0)), "envelope", "half_cycles"),
        (between(0.5, 0.1, (1.5, 2.5), (0.6, 0.6)), "half_cycles", "envelope"),
    ):
        assert trust(system, better).worst < trust(system, worse).worst
        assert recommended(system, {"envelope": None, "half_cycles": None}).method == better


@pytest.mark.validation  # every day: the same of the envelope, in test_system_envelope.py
def test_where_no_cell_is_near_no_per_cent_is_stated() -> None:
    system = box(5e-3)
    doubled = sp.System(*[part for _, part in system.named()], sp.Springpot(0.6, 1.0))
    for method in (half_cycles, envelope):
        warnings = warnings_of(method(doubled))
        assert any("has no cell near" in sentence for sentence in warnings)
        assert not any("%" in sentence for sentence in warnings)
    answers, _ = solve_all(doubled)
    assert recommended(doubled, answers).guess == "half_cycles"


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Spring(1.0), sp.Dashpot(0.2), sp.Barrier(-1.0)), "here there is one wall"),
        ((sp.Dashpot(0.2), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), "here there is none"),
        ((sp.Spring(1.0), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), "here there is none"),
        (
            (sp.Spring(1.0), SOFT, sp.Dashpot(0.2), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")),
            "here the springs",
        ),
        ((sp.Spring(1.0), sp.VanDerPol(0.1), sp.Barrier(-1.0), sp.Barrier(1.0, free_side="below")), "not van_der_pol"),
    ],
)  # fmt: skip
def test_what_they_do_not_cover(parts: tuple[object, ...], sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        half_cycles(sp.System(*parts, sp.WhiteNoise(1.0)))


def test_without_noise_there_is_no_stationary_state() -> None:
    stops = sp.Barrier(-1.0), sp.Barrier(1.5, free_side="below")
    still = half_cycles(sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.0), *stops))
    assert "nothing excites" in str(still.stationary)


@pytest.mark.validation
def test_thirty_random_systems_say_their_error() -> None:
    """Two unlike stops, restitutions 0.5 to 1, gaps of 1 to 4 standard deviations."""
    rng = np.random.default_rng(30)
    stated = exceeded = 0
    ratios = []
    for number in range(30):
        order = float(rng.choice([1.0, *rng.uniform(0.2, 0.9, 2)]))
        c = math.exp(rng.uniform(math.log(0.1), 0.0))
        gaps = sorted(rng.uniform(1.0, 4.0, 2).tolist())
        system = between(order, c, (gaps[0], gaps[1]), tuple(rng.uniform(0.5, 1.0, 2).tolist()))
        measured = simulated_rates(system, 6000, seed=500 + number)
        answers, _ = solve_all(system)
        best = recommended(system, answers).method
        if not best:
            continue
        rates, gaps_of = rates_of(answers[best]), trust(system, best).gaps
        pairs = [("impact_rate", sum(rates), measured[:, 0].sum(), math.hypot(*measured[:, 1]))]
        i = int(np.argmin(measured[:, 0]))
        pairs.append(("rarest_impact_rate", rates[i], *measured[i]))
        known = [
            (gaps_of[name], 100.0 * max(abs(value / mc - 1.0) - se / mc, 0.0), 100.0 * se / mc)
            for name, value, mc, se in pairs
            if math.isfinite(gaps_of.get(name, math.nan)) and 0.0 < se < 0.05 * mc
        ]
        if not known:
            continue
        stated += 1
        exceeded += any(gap > 1.5 * said + 2.0 * se for said, gap, se in known)
        ratios += [said / max(gap, 1.0) for said, gap, _ in known]
    assert stated >= 20
    assert exceeded <= 2
    assert np.median(ratios) <= 3.0


def test_a_springpot_of_order_0_is_a_spring() -> None:
    stops = {"near": sp.Barrier(-1.0), "far": sp.Barrier(1.2, free_side="below")}
    parts = sp.Dashpot(0.1), sp.WhiteNoise(0.2)
    split = sp.System(sp.Spring(1.0), sp.Springpot(0.0, 1.0), *parts, **stops)
    whole = sp.System(sp.Spring(2.0), *parts, **stops)
    assert rates_of(half_cycles(split)) == pytest.approx(rates_of(half_cycles(whole)), rel=1e-9)
    assert cell_of(split) == pytest.approx(cell_of(whole))


@pytest.mark.parametrize(("c", "share"), [(1e-3, 0.03), (3e-3, 0.02)])
def test_light_damping_has_narrow_cells(c: float, share: float) -> None:
    """With cells of one width <v^2> was 6 % too large at c = 0.001."""
    system = between(1.0, c, (1.0, 1.7), (1.0, 1.0))
    found, true = half_cycles(system), sp.theory.exact(system)
    assert found.v_mean_square == pytest.approx(true.v_mean_square, rel=share)
    assert rates_of(found) == pytest.approx(rates_of(true), rel=2.5 * share)


def test_what_the_chain_does_not_resolve_is_refused() -> None:
    for system, sentence in (
        (between(1.0, 1e-5, (1.0, 1.7), (1.0, 1.0)), "the damping is very light or the walls are very near"),
        (between(1.0, 0.05, (1e-9, 2e-9), (1.0, 1.0)), "the damping is very light or the walls are very near"),
        (between(0.5, 0.3, (0.1, 0.15), (1.0, 1.0)), "here a wall is nearer"),
    ):
        with pytest.raises(NotCoveredError, match=sentence):
            half_cycles(system)
        answers, _ = solve_all(system)
        assert "half_cycles" not in answers
        assert "envelope" in answers


def test_other_methods_answer_where_nothing_draws_the_mass_at_rest() -> None:
    stops = {"near": sp.Barrier(-1.5, 0.6), "far": sp.Barrier(2.2, 0.6, free_side="below")}
    for springs in ((), (sp.Spring(-1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)))):
        _, statements = solve_all(sp.System(*springs, sp.Springpot(0.7, 0.5), sp.WhiteNoise(0.5), **stops))
        assert "half cycles" in statements["half_cycles"]


@pytest.mark.parametrize("restitution", [sp.PowerRestitution(0.5, 1.0, 1.0), 1e-9])
def test_the_density_of_x_where_all_impacts_end_with_one_speed(restitution: sp.PowerRestitution | float) -> None:
    found = half_cycles(between(1.0, 0.2, (1.2, 1.9), (restitution, restitution)))  # type: ignore[arg-type]
    x = np.linspace(-1.2, 1.9, 20_001)
    density = found.x_density(x)
    assert np.all(np.isfinite(density))
    assert np.trapezoid(density, x) == pytest.approx(1.0, abs=0.02)


def test_a_wall_beyond_the_grid_has_no_rate_and_a_sentence() -> None:
    found = half_cycles(between(1.0, 0.1, (1.0, 6.9), (1.0, 1.0)))
    assert math.isnan(rates_of(found)[1])
    assert found.impact_rate == rates_of(found)[0] > 0.0
    assert found.impact_speed_mean > 0.0
    assert any("too small for the half cycles" in sentence for sentence in found.warnings)
