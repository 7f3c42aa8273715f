"""Records of one mass with a wall, a soft contact or a nonlinear spring under noise that was not measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.fitting import Fit
from springpot.fitting.impact_filter import Flow, _bounded_twice, _strike, filtered
from springpot.fitting.kalman import innovations_of
from springpot.fitting.nonlinear_records import NonlinearRecordLikelihood, equivalent_stiffness, stationary
from springpot.fitting.state_space import state_space
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from tests.sizes import validation

STEP = 0.01
TRUTH = {"k": 40.0, "order": 0.5, "C": 3.0, "gap": -0.08, "r": 0.7, "q": 12.0}
DUFFING = {"k": 40.0, "order": 0.5, "C": 3.0, "k3": 300.0, "q": 12.0}
SOFT = {"k": 40.0, "order": 0.5, "C": 3.0, "gap": -0.08, "kc": 1000.0, "q": 12.0}
BOUNDS = {
    "k": (4.0, 400.0), "order": (0.02, 0.98), "C": (0.03, 300.0), "gap": (-0.3, -0.005), "r": (0.05, 1.0),
    "q": (0.1, 1000.0), "k3": (1.0, 1e4), "kc": (10.0, 1e5),
}  # fmt: skip


def wall(k: float, order: float, C: float, gap: float, r: float, q: float, on: str = "mass") -> sp.System:
    return sp.System(
        sp.Spring(k), sp.Springpot(order, C), sp.Barrier(gap, r, free_side="above"), sp.WhiteNoise(q, on=on)
    )


def on_ground(**numbers: float) -> sp.System:
    return wall(**numbers, on="ground")


def duffing(k: float, order: float, C: float, k3: float, q: float) -> sp.System:
    return sp.System(sp.Spring(k), sp.Springpot(order, C), sp.PolynomialSpring((0.0, 0.0, k3)), sp.WhiteNoise(q))


def soft(k: float, order: float, C: float, gap: float, kc: float, q: float) -> sp.System:
    return sp.System(sp.Spring(k), sp.Springpot(order, C), sp.Contact(gap, kc, free_side="above"), sp.WhiteNoise(q))


def free(system: Callable[..., sp.System], start: dict[str, float]) -> sp.System:
    return system(**{name: sp.free(name, value, BOUNDS[name]) for name, value in start.items()})


def acceleration(x: Floats, step: float) -> Floats:
    """-(k x + C D^order x) of paths from rest: exact for a velocity that is constant in each step."""
    order = TRUTH["order"]
    spacing = 0.25 * np.log(10.0)
    rates = np.exp(np.arange(np.log(1e-3), np.log(6.0 / step), spacing))
    weights = TRUTH["C"] * np.sin(np.pi * order) / np.pi * rates**order * spacing
    fast = TRUTH["C"] * np.sinc(1.0 - order) * (rates[-1] * np.exp(0.5 * spacing)) ** (order - 1.0)
    kept, gained = np.exp(-rates * step), -np.expm1(-rates * step) / (rates * step)
    modes, found = np.zeros((len(x), rates.size)), np.zeros_like(x)
    for n in range(1, x.shape[1]):
        moved = x[:, n] - x[:, n - 1]
        modes = modes * kept + gained * moved[:, None]
        found[:, n] = -(TRUTH["k"] * x[:, n] + modes @ weights + fast * moved / step)
    return found


@cache
def twins(system: Callable[..., sp.System], of: str, paths: int, duration: float, step: float, seed: int) -> Floats:
    """Samples of paths after 20 s from rest."""
    truth: dict[str, float] = {"duffing": DUFFING, "soft": SOFT}.get(system.__name__, TRUTH)
    every = round(STEP / step)
    run = sp.simulate(
        system(**truth), paths=paths, record=paths, duration=20.0 + duration, step=step, seed=seed,
        record_every=1 if of == "a" else every,
    )  # fmt: skip
    if of == "a":
        return acceleration(run.record[:, :, 0], step)[:, ::every][:, round(20.0 / STEP) :]
    return np.asarray(run.record[:, round(20.0 / STEP) :, "xv".index(of)])


def record(values: Floats, seed: int, of: Any = "x", noise: float | None = None) -> tuple[sp.MeasuredRecord, float]:
    """With sensor noise of 1 % of the rms."""
    spread = 0.01 * float(values.std())
    noisy = values + spread * np.random.default_rng(seed).standard_normal(values.shape)
    return sp.MeasuredRecord(STEP * np.arange(values.shape[-1]), noisy, of=of, noise=noise), spread


def test_without_walls_it_is_the_exact_likelihood() -> None:
    """Memory of few fixed rates, and the start, change -2 ln L of 600 samples by 0.5 at most."""
    data, spread = record(twins(duffing, "x", 1, 10.0, 1e-3, 3)[0, :600], 1)
    for order, C in ((0.3, 2.0), (0.5, 3.0), (0.7, 4.0)):
        exact = sp.System(sp.Spring(40.0), sp.Springpot(order, C), sp.WhiteNoise(12.0))
        own = NonlinearRecordLikelihood(exact, data)
        own._spread = 0.0
        space = state_space(exact, "x", STEP, 6.0)
        assert abs(own.deviance(np.array([spread])) - innovations_of(space, spread, data.values)[0]) < 0.5


RATES = np.array([0.5, 5.0, 50.0])


def flow_at(wall: float, intensity: float, cubic: float = 0.0) -> Flow:
    powers = np.array([0.0, cubic]) if cubic else RATES[:0]
    return Flow(40.0, 0.7, intensity, np.array([0.4, 1.1, 3.0]), RATES, np.array([[wall, 1.0, 0.7]]), powers,
                np.empty((0, 5)))  # fmt: skip


@pytest.mark.parametrize("cubic", [0.0, 6e4])
def test_saltation_is_the_derivative_of_the_impact(cubic: float) -> None:
    """Against paths from both sides: each flies to the wall, strikes, and flies to the same time.

    A nonlinear force is nearly that at the wall: the last entry of the state, which is 1.
    """
    from scipy.linalg import expm

    flow = flow_at(-0.08, 0.0, cubic)
    drift, at = np.zeros((6, 6)), np.array([-0.08, -1.3, 0.02, -0.05, -0.02, 1.0])
    drift[:5, :5] = flow.drift()
    drift[1, 5] = cubic * 0.08**3

    def struck(deviation: Floats) -> Floats:
        """The deviation before the impact of the mean is one after it: the impact of this path is at another time."""
        state, shift = at + np.append(deviation, 0.0), 0.0
        for _ in range(50):
            shift -= ((expm(drift * shift) @ state)[0] + 0.08) / (expm(drift * shift) @ state)[1]
        there = expm(drift * shift) @ state
        there[1] *= -0.7
        return np.asarray(expm(-drift * shift) @ there)[:5]

    slopes = np.stack([(struck(1e-6 * way) - struck(-1e-6 * way)) / 2e-6 for way in np.eye(5)], axis=1)
    before = np.diag([1.0, 2.0, 3.0, 4.0, 5.0]) + 0.1
    expected, mean, cov, clone = slopes @ before @ slopes.T, at[:5].copy(), 1e-14 * before, np.arange(1.0, 8.0)
    _strike(flow, flow.walls[0], 0.01, mean, cov, clone)
    assert np.allclose(1e14 * cov, expected, rtol=1e-5, atol=1e-5)
    assert np.allclose(mean, [-0.08, 0.91, 0.02, -0.05, -0.02])
    assert np.allclose(clone, [*(slopes @ np.arange(1.0, 6.0)), 6.0, 7.0], rtol=1e-5)


@pytest.mark.parametrize(("side", "gap", "gap_0"), [(1.0, 0.3, 0.2), (-1.0, -0.4, 0.9), (1.0, -1.5, 0.1)])
def test_the_moments_between_two_bounds(side: float, gap: float, gap_0: float) -> None:
    """Against a million draws of (x, v, x_0), of which those inside at both times are kept."""
    whole = np.array([[0.5, 0.2, -0.45], [0.2, 2.0, 0.3], [-0.45, 0.3, 0.6]])
    center = np.array([0.1 + side * gap, -0.3, 0.1 + side * gap_0])
    drawn = np.random.default_rng(1).multivariate_normal(center, whole, 1_000_000)
    kept = drawn[(side * (drawn[:, 0] - 0.1) > 0.0) & (side * (drawn[:, 2] - 0.1) > 0.0), :2]
    mean, cov = center[:2].copy(), whole[:2, :2].copy()
    share = _bounded_twice(mean, cov, np.array([-0.45, 0.3, center[2], 0.6]), 0.1, side)
    assert share == pytest.approx(len(kept) / len(drawn), abs=4.0 * (share / len(drawn)) ** 0.5)
    assert mean == pytest.approx(kept.mean(axis=0), abs=5.0 * (2.0 / len(kept)) ** 0.5)
    assert cov == pytest.approx(np.cov(kept.T), abs=8.0 * 2.0 / len(kept) ** 0.5)


def counted(samples: Floats, seen: int, noise: float, gap: float, particles: int) -> float:
    """ln L by a bootstrap filter: many paths in small steps, drawn anew by how well they agree with each sample."""
    rng, fine = np.random.default_rng(5), 20
    h, flow = STEP / fine, flow_at(gap, 12.0)
    x, v = 0.03 * rng.standard_normal(particles), 0.5 * rng.standard_normal(particles)
    z, total, inside = np.zeros((3, particles)), 0.0, x > gap
    for n, sample in enumerate(samples):
        for _ in range(fine if n else 0):
            pull = flow.stiffness * x + flow.damping * v + flow.weights @ z
            u = v - h * pull + (12.0 * h) ** 0.5 * rng.standard_normal(particles)
            moved = 0.5 * h * (u + v)
            struck = x + moved < gap
            x, v = np.where(struck, gap - 0.7 * (x + moved - gap), x + moved), np.where(struck, -0.7 * u, u)
            z += np.where(struck, 0.0, moved) - h * RATES[:, None] * z
        weights = np.exp(-0.5 * ((sample - (x, v)[seen]) / noise) ** 2) * (inside if n == 0 else 1.0)
        total += float(np.log(weights.mean() / (noise * (2.0 * np.pi) ** 0.5)))
        kept = rng.choice(particles, particles, p=weights / weights.sum())
        x, v, z = x[kept], v[kept], z[:, kept]
    return total


@pytest.mark.parametrize(("seen", "noise", "within"), [(0, 0.002, 0.3), validation(0, 0.01, 0.4), (1, 0.02, 0.8)])
def test_the_likelihood_is_that_of_many_paths(seen: int, noise: float, within: float) -> None:
    """Twelve samples about an impact; of velocities a part of the law is not normal.

    Differences between two walls, for what is known at the start counts in all.
    """
    gaps, found = (-0.021, -0.024), []
    t = STEP * np.arange(12)
    place = np.where(t < 0.047, 0.014 - 0.8 * t, -0.0236 + 0.56 * (t - 0.047))
    speed = np.where(t < 0.047, -0.8, 0.56)
    samples = (place, speed)[seen] + noise * np.random.default_rng(2).standard_normal(12)
    for gap in gaps:
        room = [np.zeros((1, 12)) for _ in range(3)]
        start = np.diag([0.03**2, 0.5**2, 0.0, 0.0, 0.0])
        hits = filtered(samples[None], STEP, 2, 1, seen, noise**2, start, flow_at(gap, 12.0), *room)
        assert 0.1 < hits < 1.5
        found.append(float(room[0].sum()) - counted(samples, seen, noise, gap, 40_000))
    assert abs(found[1] - found[0]) < within
    assert abs(found[0]) < within + 0.3


def test_a_short_record_with_a_wall() -> None:
    """10 s: the truth within four standard errors, and as many impacts as there were."""
    data, spread = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    fit = sp.fit(free(wall, {**TRUTH, "k": 52.0, "gap": -0.1, "r": 0.6, "q": 9.0}), data)
    for name in ("gap", "r", "q", "noise"):
        true = TRUTH.get(name, spread)
        assert abs(fit.values[name] - true) < 4.0 * fit.errors[name], name
    assert abs(fit.values["gap"] + 0.08) < 0.004
    assert fit.table.at.size == data.size
    own = fit._likelihood
    assert isinstance(own, NonlinearRecordLikelihood)
    assert 5 < own._run(fit._theta)[3] < 40
    best = fit.log_likelihood(fit.values)
    assert best >= fit.log_likelihood({**TRUTH, "noise": spread})
    assert fit.log_likelihood({**fit.values, "r": 1.01}) == -np.inf
    assert [*fit.bounds] == [*fit.names] == [*fit.values]
    starts = fit.start_ensemble(16)
    assert all(np.isfinite(fit.log_prior(each)) for each in starts)
    assert "(profile)" in fit.report()  # an order is not known from 10 s
    assert any("apart" in said for said in fit.warnings)


def test_a_short_record_of_a_hardening_spring() -> None:
    data, spread = record(twins(duffing, "x", 1, 10.0, 1e-3, 3)[0], 5)
    model = sp.System(
        sp.Spring(40.0), sp.Springpot(0.5, 3.0), sp.PolynomialSpring((0.0, 0.0, sp.free("k3", 200.0, (1.0, 1e4)))),
        sp.WhiteNoise(sp.free("q", 8.0, (0.1, 100.0))),
    )  # fmt: skip
    fit = sp.fit(model, data)
    for name, true in {"k3": 300.0, "q": 12.0, "noise": spread}.items():
        assert abs(fit.values[name] - true) < 4.0 * fit.errors[name], name


def test_the_equivalent_spring_of_a_cubic_one() -> None:
    """3 k3 <x^2>."""
    flow = NonlinearRecordLikelihood(free(duffing, DUFFING), record(twins(duffing, "x", 1, 10.0, 1e-3, 3)[0], 1)[0])
    own, _ = flow.flow(np.array([*DUFFING.values(), 0.01]))
    more = equivalent_stiffness(own, 1.0)
    assert more == pytest.approx(3.0 * 300.0 * stationary(own, more)[0, 0], rel=1e-6)


def struck(**more: Any) -> sp.System:
    """With the gap, the restitution and the noise free."""
    numbers = {"gap": (-0.1, -0.3, -0.005), "r": (0.6, 0.05, 1.0), "q": (9.0, 0.1, 100.0)}
    found = {name: sp.free(name, at, (low, high)) for name, (at, low, high) in numbers.items()}
    return wall(40.0, 0.5, 3.0, **{**found, **more})


@pytest.mark.parametrize(
    ("noise", "bounds"), [(1e-6, (-0.3, -0.005)), validation(0.0, (-0.3, -0.005)), validation(None, (-1000.0, 1000.0))],
    ids=["small noise", "none", "wide bounds"],
)  # fmt: skip
def test_a_gap_has_an_error_that_holds(noise: float | None, bounds: tuple[float, float]) -> None:
    """Of samples without noise the one that is farthest out said all of it, with an error of 1e-7."""
    values = twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0]
    data = (
        record(values, 5)[0] if noise is None else sp.MeasuredRecord(STEP * np.arange(values.size), values, noise=noise)
    )
    fit = sp.fit(struck(gap=sp.free("gap", -0.1, bounds)), data)
    assert abs(fit.values["gap"] + 0.08) < 4.0 * fit.errors["gap"] < 0.01


def test_numbers_without_an_influence_are_refused_by_name() -> None:
    data, _ = record(twins(duffing, "x", 1, 10.0, 1e-3, 3)[0], 1)
    lowest = float(data.values.min())
    far = sp.free("gap", 3.0 * lowest, (4.0 * lowest, 2.5 * lowest))
    with pytest.raises(
        ValueError, match=r"^gap and r must not be free: the record, in which no wall is struck, does not"
    ):
        sp.fit(struck(gap=far), data)
    q = sp.free("q", 9.0, (0.1, 100.0))
    linear = sp.System(sp.Spring(40.0), sp.Springpot(0.5, 3.0), sp.WhiteNoise(q))
    with pytest.warns(UserWarning, match="A model is left out of the comparison: gap and r must not be free"):
        assert sp.fit([linear, struck(gap=far)], data).model.of(sp.Barrier) == ()
    contact = sp.Contact(2.0 * lowest, sp.free("kc", 1e3, (10.0, 1e5)), free_side="above")
    with pytest.raises(ValueError, match=r"^kc must not be free: the record does not depend on it"):
        sp.fit(sp.System(sp.Spring(40.0), sp.Springpot(0.5, 3.0), contact, sp.WhiteNoise(12.0)), data)


@pytest.mark.parametrize("low", [0.0, validation(-100.0)])
def test_a_search_goes_round_numbers_without_a_stationary_state(low: float) -> None:
    """A negative cubic spring holds no mass, and a part with one of 0 is refused: of a linear record."""
    linear = sp.simulate(
        sp.System(sp.Spring(40.0), sp.Springpot(0.5, 3.0), sp.WhiteNoise(12.0)), paths=1, record=1, duration=30.0,
        step=STEP, seed=2,
    ).record[0, -1000:, 0]  # fmt: skip
    data, _ = record(linear, 1)
    cubic = sp.PolynomialSpring((0.0, 0.0, sp.free("k3", 50.0, (low, 1e3))))
    fit = sp.fit(sp.System(sp.Spring(40.0), sp.Springpot(0.5, 3.0), cubic, sp.WhiteNoise(12.0)), data)
    assert 0.0 <= fit.values["k3"] < 4.0 * fit.errors["k3"] + 1.0


@pytest.mark.validation  # every day: that of few impacts, below
def test_a_small_restitution_is_said() -> None:
    data, _ = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    fit = sp.fit(struck(r=0.2), data)
    assert any(said.endswith("follow each other within a sample, and this fit is inexact.") for said in fit.warnings)
    found = sp.fit(struck(r=sp.free("r", 0.2, (0.05, 0.25))), data)
    assert any("this fit finds it too low by up to a half" in said for said in found.warnings)


def test_few_impacts_are_said() -> None:
    data, _ = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    short = sp.MeasuredRecord(data.time[:60], data.values[0, :60], noise=0.002)
    few = [said for said in sp.fit(struck(r=0.7), short).warnings if "impacts" in said]
    assert [said.split(" has ")[0] for said in few] == ["The record"]


@pytest.mark.validation  # every day: a short record with a wall, above
def test_two_walls_are_mirror_images() -> None:
    data, _ = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    mirrored = sp.MeasuredRecord(data.time, -data.values)
    q = sp.free("q", 10.0, (0.1, 100.0))
    parts = sp.Spring(40.0), sp.Springpot(0.5, 3.0), sp.WhiteNoise(q)
    walls = sp.Barrier(-0.08, 0.7, free_side="above"), sp.Barrier(2.0, 0.5, free_side="below")
    other = sp.Barrier(0.08, 0.7, free_side="below"), sp.Barrier(-2.0, 0.5, free_side="above")
    here, there = sp.fit(sp.System(*parts, *walls), data), sp.fit(sp.System(*parts, *other), mirrored)
    assert there.values["q"] == pytest.approx(here.values["q"], rel=1e-6)


def test_a_mass_between_two_walls() -> None:
    """10 s in which both are struck often."""

    def between(low: float, high: float, r: float, q: float) -> sp.System:
        walls = sp.Barrier(low, r, free_side="above"), sp.Barrier(high, r, free_side="below")
        return sp.System(sp.Spring(40.0), sp.Springpot(0.5, 3.0), *walls, sp.WhiteNoise(q))

    truth = {"low": -0.08, "high": 0.1, "r": 0.7, "q": 12.0}
    run = sp.simulate(between(**truth), paths=1, record=1, duration=30.0, step=2.5e-4, seed=5, record_every=40)
    data, _ = record(run.record[0, -1000:, 0], 5)
    starts = {
        "low": (-0.1, (-0.3, -0.005)),
        "high": (0.13, (0.005, 0.3)),
        "r": (0.6, (0.05, 1.0)),
        "q": (9.0, (0.1, 100.0)),
    }
    fit = sp.fit(between(**{name: sp.free(name, *own) for name, own in starts.items()}), data)
    for name, value in truth.items():
        assert abs(fit.values[name] - value) < 4.0 * fit.errors[name], name
    assert max(fit.errors["low"], fit.errors["high"]) < 3e-4


@pytest.mark.validation  # every day: the likelihood of velocities, above
def test_a_short_record_of_the_velocity() -> None:
    """10 s: it tells the restitution and the noise, and hardly where the wall is."""
    data, _ = record(twins(wall, "v", 1, 10.0, 2.5e-4, 5)[0], 5, "v")
    start = {"gap": -0.1, "r": 0.5, "q": 9.0}
    fit = sp.fit(wall(40.0, 0.5, 3.0, **{name: sp.free(name, at, BOUNDS[name]) for name, at in start.items()}), data)
    for name in ("gap", "r", "q"):
        assert abs(fit.values[name] - TRUTH[name]) < 4.0 * fit.errors[name], name
    assert fit.errors["r"] < 0.05
    assert 0.005 < fit.errors["gap"] < 0.1


@pytest.mark.validation  # every day: a short record with a wall, and one of a hardening spring
def test_a_short_record_of_the_acceleration() -> None:
    """20 s from a start near the truth: within four standard errors."""
    data, spread = record(twins(on_ground, "a", 1, 20.0, 2.5e-4, 5)[0], 5, "a")
    fit = sp.fit(free(on_ground, {**TRUTH, "gap": -0.1, "r": 0.6, "q": 9.0}), data)
    for name, true in {**TRUTH, "noise": spread}.items():
        assert abs(fit.values[name] - true) < 4.0 * fit.errors[name], name


@pytest.mark.parametrize(
    ("model", "of", "words"),
    [
        (lambda: wall(**TRUTH), "a", "the acceleration under white_noise on the mass has no finite variance"),
        (lambda: sp.System(*wall(**TRUTH).parts[:3], sp.ColoredNoise(1.0, 0.1)), "x", "white noise, not colored_noise"),
        (lambda: sp.System(*wall(**TRUTH).parts, sp.PolynomialDashpot((0.0, 1.0))), "x",
         "white noise, not polynomial_dashpot"),
        (lambda: sp.System(*wall(**TRUTH).parts[:3]), "x", "a system without noise does not move"),
        (lambda: sp.System(sp.Spring(1.0), sp.Barrier(-1.0, sp.PowerRestitution(0.5, 1.0)), sp.WhiteNoise(1.0)), "x",
         "not the law of restitution of barrier"),
        (lambda: sp.System(sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
                           sp.Barrier(-1.0, between=("ground", "b")), sp.WhiteNoise(1.0, on="ground")), "x",
         "one mass is needed, and the system has 2"),
    ],
)  # fmt: skip
def test_what_is_not_covered(model: Callable[[], sp.System], of: Any, words: str) -> None:
    time = STEP * np.arange(200)
    with pytest.raises(NotCoveredError, match=words):
        sp.fit(model(), sp.MeasuredRecord(time, np.sin(9.0 * time), of=of, at=None))


SETS = [
    (wall, "x", 2.5e-4, TRUTH, 12),
    (wall, "v", 2.5e-4, TRUTH, 12),
    (on_ground, "a", 2.5e-4, TRUTH, 12),
    (soft, "x", 1e-3, SOFT, 12),
    (duffing, "x", 1e-3, DUFFING, 12),
]


@pytest.mark.validation
@pytest.mark.parametrize(("system", "of", "step", "truth", "seed"), SETS)
def test_intervals_hold_the_truth(system: Any, of: str, step: float, truth: dict[str, float], seed: int) -> None:
    """20 twins of 60 s, all numbers free, starts 30 % off, of order and r by 0.2."""
    inside, ratios, gaps = [], [], []
    for n, values in enumerate(twins(system, of, 20, 60.0, step, seed)):
        data, spread = record(values, 1000 + n, of)
        signs = np.random.default_rng(n).choice([-1.0, 1.0], len(truth))
        start = {
            name: value + 0.2 * sign if name in ("order", "r") else value * 1.3**sign
            for (name, value), sign in zip(truth.items(), signs, strict=True)
        }
        fit: Fit = sp.fit(free(system, start), data)
        true = {**truth, "noise": spread}
        ends = [fit.intervals[name] for name in true]
        inside += [low <= value <= high for (low, high), value in zip(ends, true.values(), strict=True)]
        ratios.append(2.0 * (fit.log_likelihood(fit.values) - fit.log_likelihood(true)))
        gaps.append((fit.values["gap"] - true["gap"]) / fit.errors["gap"] if "gap" in true else 0.0)
    print(system.__name__, of, sum(inside), len(inside), np.mean(ratios), np.mean(gaps))
    assert 0.9 * len(inside) <= sum(inside) <= 0.985 * len(inside)
    assert len(truth) - 1 <= np.mean(ratios) <= len(truth) + 3
    assert abs(np.mean(gaps)) < 0.5
