"""Simulated data of known truth, 200 times each: intervals hold it, and the estimates are not biased."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.designing.quantities import sampled_run
from springpot.fitting import Fit
from springpot.fitting.transfer import response_of
from springpot.simulation.paths.statistics import controlled
from springpot.simulation.plan.plan import plan_of
from tests.fitting.test_fit import paths_of

pytestmark = pytest.mark.validation

TIMES = 200
F = np.geomspace(0.01, 100.0, 31)
P = 2j * np.pi * F
ORDER, C = sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0))
ONE = sp.Springpot(ORDER, C)
TWO = sp.System(sp.Spring(sp.free("k", 1.0, (0.01, 100.0))), ONE)
TWO_POTS = sp.System(
    sp.Springpot(sp.free("order_1", 0.3, (0.01, 0.45)), sp.free("C_1", 1.0, (0.01, 100.0))),
    sp.Springpot(sp.free("order_2", 0.6, (0.46, 0.99)), sp.free("C_2", 1.0, (0.01, 100.0))),
)
MOVING = sp.System(sp.Spring(4.0), sp.Springpot(ORDER, C), sp.WhiteNoise(sp.free("q", 0.5, (0.01, 100.0))))


def check(truth: Mapping[str, float], fitted: Callable[[int], Fit]) -> None:
    """Coverage of the 95 % intervals within 90 to 98 %, bias below a fifth of the standard error and its own error."""
    fits = [fitted(seed) for seed in range(TIMES)]
    for name, value in truth.items():
        inside = sum(low <= value <= high for low, high in (fit.interval(name) for fit in fits))
        assert 0.90 * TIMES <= inside <= 0.985 * TIMES, f"{name}: {inside} of {TIMES}"
        found = np.array([fit.values[name] for fit in fits])
        bias = (found.mean() - value) / found.std(ddof=1)
        assert abs(bias) < 0.2 + 1.0 / TIMES**0.5, f"{name}: {bias}"
    wrong = sum(not fit.check().passed for fit in fits)
    assert wrong <= 0.06 * TIMES


@pytest.mark.parametrize("error", [None, 0.03])
@pytest.mark.parametrize(
    ("truth", "modulus", "model"),
    [
        ({"order": 0.3, "C": 2.0}, 2.0 * P**0.3, ONE),
        ({"k": 3.0, "order": 0.4, "C": 2.0}, 3.0 + 2.0 * P**0.4, TWO),
        ({"order_1": 0.2, "C_1": 3.0, "order_2": 0.7, "C_2": 0.5}, 3.0 * P**0.2 + 0.5 * P**0.7, TWO_POTS),
    ],
)
def test_moduli(truth: dict[str, float], modulus: Any, model: Any, error: float | None) -> None:
    def fitted(seed: int) -> Fit:
        noise = 1.0 + 0.03 * np.random.default_rng(seed).standard_normal((2, F.size))
        return sp.fit(
            model, sp.MeasuredModuli(F, modulus.real * noise[0], modulus.imag * noise[1], relative_error=error)
        )

    check(truth, fitted)


@pytest.mark.parametrize("order", [0.3, 0.6])
def test_a_spectrum(order: float) -> None:
    true = sp.System(sp.Spring(4.0), sp.Springpot(order, 0.8), sp.WhiteNoise(1.0))

    def fitted(seed: int) -> Fit:
        record = sp.MeasuredRecord(0.2 * np.arange(8192), paths_of(true, 0.2, 8192, 0.0, seed), noise=0.0)
        return sp.fit(MOVING, record.spectrum(segment=512))

    check({"order": order, "C": 0.8, "q": 1.0}, fitted)


@pytest.mark.parametrize("order", [0.3, 0.6])
def test_a_record_with_noise_of_5_percent(order: float) -> None:
    true = sp.System(sp.Spring(4.0), sp.Springpot(order, 0.8), sp.WhiteNoise(1.0))
    spread = 0.05 * sp.theory.linear(true).x_mean_square ** 0.5

    def fitted(seed: int) -> Fit:
        return sp.fit(MOVING, sp.MeasuredRecord(0.2 * np.arange(2000), paths_of(true, 0.2, 2000, spread, seed)))

    check({"order": order, "C": 0.8, "q": 1.0, "noise": spread}, fitted)


@pytest.mark.parametrize("error", ["coherence", None])
@pytest.mark.parametrize(("of", "on"), [("x", "mass"), ("a", "ground")])
def test_a_frequency_response(of: Any, on: Any, error: str | None) -> None:
    """A quality factor of some 3, errors of 5 to 13 %."""
    frequency = np.geomspace(0.5, 10.0, 60)
    true = sp.System(sp.Spring(600.0), sp.Springpot(0.5, 60.0))
    model = sp.System(
        sp.Spring(sp.free("k", 700.0, (10.0, 1e4))), sp.Springpot(ORDER, sp.free("C", 40.0, (0.01, 1000.0)))
    )
    exact, _ = response_of(true, frequency, of, on)
    coherence = np.linspace(0.95, 0.75, frequency.size)
    size = np.sqrt((1.0 - coherence) / (2.0 * 10.0 * coherence)) if error else np.full(frequency.size, 0.08)
    given: dict[str, Any] = {"averages": 10, "coherence": coherence} if error == "coherence" else {}

    def fitted(seed: int) -> Fit:
        z = np.random.default_rng(seed).standard_normal((2, frequency.size)) * size
        return sp.fit(
            model, sp.MeasuredFrequencyResponse(frequency, exact * (1.0 + z[0] + 1j * z[1]), of=of, on=on, **given)
        )

    check({"k": 600.0, "order": 0.5, "C": 60.0}, fitted)


def power_law(v: Any, a: float = sp.free("a", 0.5, (0.05, 2.0)), b: float = sp.free("b", 0.05, (-1.0, 1.0))) -> Any:
    return a * v**-b


def viscoelastic(v: Any, k: float = sp.free("k", 0.1, (0.001, 0.6))) -> Any:
    return 1.0 - k * v**0.2


@pytest.mark.parametrize("error", [None, 0.02])
@pytest.mark.parametrize(
    ("truth", "model", "law"),
    [
        ({"r": 0.7}, sp.Barrier(0.0, sp.free("r", 0.5, (0.05, 1.0))), lambda v: 0.7),
        ({"a": 0.75, "b": 0.1}, power_law, lambda v: 0.75 * v**-0.1),
        ({"k": 0.25}, viscoelastic, lambda v: 1.0 - 0.25 * v**0.2),
    ],
)
def test_impacts(truth: dict[str, float], model: Any, law: Any, error: float | None) -> None:
    def fitted(seed: int) -> Fit:
        rng = np.random.default_rng(seed)
        before = rng.uniform(0.3, 3.0, 40)
        after = law(before) * before
        if error is None:
            return sp.fit(model, sp.MeasuredImpacts(before, after * (1.0 + 0.03 * rng.standard_normal(40))))
        noise = error * rng.standard_normal((2, 40))
        return sp.fit(model, sp.MeasuredImpacts(before + noise[0], after + noise[1], error=error))

    check(truth, fitted)


ANSWERS = ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean", "impact_speed_mean_square")
STOPPED = {"order": 0.5, "C": 0.3, "r": 0.8, "q": 1.0}
STOPPED_FREE = {
    "order": sp.free("order", 0.47, (0.05, 0.95)),
    "C": sp.free("C", 0.32, (0.05, 3.0)),
    "r": sp.free("r", 0.77, (0.3, 1.0)),
    "q": sp.free("q", 0.9, (0.1, 10.0)),
}


SPRINGS = ((1.0, -2.0), (0.4, -0.3))  # natural frequency, place of the stop


def stopped(frequency: float, gap: float, order: float, C: float, r: float, q: float) -> Any:
    return sp.Oscillator(frequency, sp.Springpot(order, C), sp.Barrier(gap, r, free_side="above"), sp.WhiteNoise(q))


@cache
def precisely(frequency: float, gap: float) -> dict[str, float]:
    """A quarter of a million paths with half the step and another seed: errors below a tenth of those of the data."""
    problem = stopped(frequency, gap, **STOPPED)
    whole = plan_of(problem, paths=2**18, seed=987654).settings
    run = sampled_run(plan_of(problem, paths=2**18, step=0.5 * whole.step, seed=987654))
    control = run.samples["energy_residual"][1][:, None]
    return {name: float(controlled(run.samples[name][1], control).mean()) for name in ANSWERS}


def fit_of_statistics(seed: int) -> Fit:
    """Six numbers with errors of 1 % of a device with each of two springs."""
    rng = np.random.default_rng(seed)
    cases = []
    for spring in SPRINGS:
        measured = {
            name: (value * (1.0 + 0.01 * rng.standard_normal()), 0.01 * value)
            for name, value in precisely(*spring).items()
        }
        cases.append((stopped(*spring, **STOPPED_FREE), sp.MeasuredStatistics(**measured)))
    return sp.fit(cases, seed=seed + 1000, paths=1024, threads=1)


def test_statistics_with_a_wall() -> None:
    """Order, coefficient, restitution and noise; half an hour."""
    check(STOPPED, fit_of_statistics)


def test_a_narrow_resonance_does_not_tell_order_from_coefficient() -> None:
    """A quality factor of 60: beside the stiffness only the damping at the resonance matters."""
    true = sp.System(sp.Spring(4.0), sp.Springpot(0.5, 0.05), sp.WhiteNoise(1.0))
    model = sp.System(
        sp.Spring(sp.free("k", 3.9, (1.0, 10.0))),
        sp.Springpot(ORDER, sp.free("C", 0.07, (0.001, 10.0))),
        sp.WhiteNoise(sp.free("q", 0.7, (0.01, 100.0))),
    )
    frequency = np.linspace(0.005, 1.0, 200)
    exact = 4.0 * np.pi * sp.theory.linear(true).spectrum(2.0 * np.pi * frequency)
    named = 0
    for seed in range(TIMES):
        density = exact * np.random.default_rng(seed).gamma(10.0, 0.1, frequency.size)
        fit = sp.fit(model, sp.MeasuredSpectrum(frequency, density, averages=10))
        named += any({"order", "C"} <= {*own.names} for own in fit.not_told_apart)
    assert named >= 0.95 * TIMES
