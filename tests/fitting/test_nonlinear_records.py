"""Records of one mass with a wall, a soft contact or a nonlinear spring under noise that was not measured."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.fitting import Fit
from springpot.fitting.impact_filter import LEFT_OUT, USED, Flow, _strike
from springpot.fitting.kalman import innovations_of
from springpot.fitting.nonlinear_records import NonlinearRecordLikelihood, equivalent_stiffness, stationary
from springpot.fitting.state_space import state_space
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError

STEP = 0.01
TRUTH = {"k": 40.0, "order": 0.5, "C": 3.0, "gap": -0.08, "r": 0.7, "q": 12.0}
DUFFING = {"k": 40.0, "order": 0.5, "C": 3.0, "k3": 300.0, "q": 12.0}
SOFT = {"k": 40.0, "order": 0.5, "C": 3.0, "gap": -0.08, "kc": 1000.0, "q": 12.0}
BOUNDS = {
    "k": (4.0, 400.0), "order": (0.02, 0.98), "C": (0.03, 300.0), "gap": (-0.3, -0.005), "r": (0.05, 1.0),
    "q": (0.1, 1000.0), "k3": (1.0, 1e4), "kc": (10.0, 1e5),
}  # fmt: skip


def wall(k: float, order: float, C: float, gap: float, r: float, q: float, on: str = "mass") -> sp.System:
    return sp.System(sp.Spring(k), sp.Springpot(order, C), sp.Barrier(gap, r, side="above"), sp.WhiteNoise(q, on=on))


def on_ground(**numbers: float) -> sp.System:
    return wall(**numbers, on="ground")


def duffing(k: float, order: float, C: float, k3: float, q: float) -> sp.System:
    return sp.System(sp.Spring(k), sp.Springpot(order, C), sp.PolynomialSpring((0.0, 0.0, k3)), sp.WhiteNoise(q))


def soft(k: float, order: float, C: float, gap: float, kc: float, q: float) -> sp.System:
    return sp.System(sp.Spring(k), sp.Springpot(order, C), sp.Contact(gap, kc, side="above"), sp.WhiteNoise(q))


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
    return np.asarray(run.record[:, round(20.0 / STEP) :, 0])


def record(values: Floats, seed: int, of: Any = "x", noise: float | None = None) -> tuple[sp.MeasuredRecord, float]:
    """With sensor noise of 1 % of the rms."""
    spread = 0.01 * float(values.std())
    noisy = values + spread * np.random.default_rng(seed).standard_normal(values.shape)
    return sp.MeasuredRecord(STEP * np.arange(values.shape[-1]), noisy, of=of, noise=noise), spread


def test_without_walls_it_is_the_exact_likelihood() -> None:
    """Memory of few fixed rates, and the start, change -2 ln L of 600 samples by 0.5 at most."""
    data, spread = record(twins(duffing, "x", 1, 10.0, 1e-3, 3)[0, :600], 1)
    for order, C in ((0.3, 2.0), (0.5, 3.0), (0.7, 4.0)):
        own = NonlinearRecordLikelihood(free(wall, {**TRUTH, "gap": -0.29}), data)
        own._marks.kinds[:], own._marks.walls[:], own._marks.widened[:] = USED, False, 0.0
        own._spread = 0.0
        exact = sp.System(sp.Spring(40.0), sp.Springpot(order, C), sp.WhiteNoise(12.0))
        space = state_space(exact, "x", STEP, 6.0).sampled(STEP)
        deviance = own.deviance(np.array([40.0, order, C, -0.29, 0.7, 12.0, spread]))
        assert abs(deviance - innovations_of(space, spread, data.values)[0]) < 0.5


def test_saltation_is_the_derivative_of_the_impact() -> None:
    """Against paths from both sides: each flies to the wall, strikes, and flies to the same time."""
    from scipy.linalg import expm

    rates = np.array([0.5, 5.0, 50.0])
    flow = Flow(40.0, 0.7, 1.0, np.array([0.4, 1.1, 3.0]), rates, np.array([[-0.08, 1.0, 0.7]]), rates[:0],
                np.empty((0, 5)))  # fmt: skip
    drift, at = flow.drift(), np.array([-0.08, -1.3, 0.02, -0.05, -0.02])

    def struck(deviation: Floats) -> Floats:
        """The deviation before the impact of the mean is one after it: the impact of this path is at another time."""
        state, shift = at + deviation, 0.0
        for _ in range(50):
            shift -= ((expm(drift * shift) @ state)[0] + 0.08) / (expm(drift * shift) @ state)[1]
        there = expm(drift * shift) @ state
        there[1] *= -0.7
        return np.asarray(expm(-drift * shift) @ there)

    slopes = np.stack([(struck(1e-6 * way) - struck(-1e-6 * way)) / 2e-6 for way in np.eye(5)], axis=1)
    cov = np.diag([1.0, 2.0, 3.0, 4.0, 5.0]) + 0.1
    expected, mean = slopes @ cov @ slopes.T, at.copy()
    _strike(flow, flow.walls[0], mean, cov)
    assert np.allclose(cov, expected, rtol=1e-6, atol=1e-6)
    assert np.allclose(mean, [-0.08, 0.91, 0.02, -0.05, -0.02])


def test_a_short_record_with_a_wall() -> None:
    """10 s: the truth within four standard errors, and which samples were left out."""
    data, spread = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    fit = sp.fit(free(wall, {**TRUTH, "k": 52.0, "gap": -0.1, "r": 0.6, "q": 9.0}), data)
    for name in ("gap", "r", "q", "noise"):
        true = TRUTH.get(name, spread)
        assert abs(fit.values[name] - true) < 4.0 * fit.errors[name], name
    assert abs(fit.values["gap"] + 0.08) < 0.004
    assert fit.table.at.size < data.size
    own = fit._likelihood
    assert isinstance(own, NonlinearRecordLikelihood)
    assert 5 < own.impacts < 40
    assert 0 < (own._marks.kinds == LEFT_OUT).sum() < 200
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


def test_two_walls_are_mirror_images() -> None:
    data, _ = record(twins(wall, "x", 1, 10.0, 2.5e-4, 5)[0], 5)
    mirrored = sp.MeasuredRecord(data.time, -data.values)
    q = sp.free("q", 10.0, (0.1, 100.0))
    parts = sp.Spring(40.0), sp.Springpot(0.5, 3.0), sp.WhiteNoise(q)
    walls = sp.Barrier(-0.08, 0.7, side="above"), sp.Barrier(2.0, 0.5, side="below")
    other = sp.Barrier(0.08, 0.7, side="below"), sp.Barrier(-2.0, 0.5, side="above")
    here, there = sp.fit(sp.System(*parts, *walls), data), sp.fit(sp.System(*parts, *other), mirrored)
    assert there.values["q"] == pytest.approx(here.values["q"], rel=1e-6)


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
        (lambda: wall(**TRUTH), "v", "the velocity of a mass that strikes barrier is not covered"),
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
    (soft, "x", 1e-3, SOFT, 12),
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
        ends = [fit.interval(name) for name in true]
        inside += [low <= value <= high for (low, high), value in zip(ends, true.values(), strict=True)]
        ratios.append(2.0 * (fit.log_likelihood(fit.values) - fit.log_likelihood(true)))
        gaps.append((fit.values["gap"] - true["gap"]) / fit.errors["gap"] if "gap" in true else 0.0)
    print(system.__name__, of, sum(inside), len(inside), np.mean(ratios), np.mean(gaps))
    assert 0.9 * len(inside) <= sum(inside) <= 0.985 * len(inside)
    assert len(truth) - 1 <= np.mean(ratios) <= len(truth) + 3
    assert abs(np.mean(gaps)) < 0.5
