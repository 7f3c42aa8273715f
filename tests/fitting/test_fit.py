"""From data to numbers: likelihoods against exact ones, and what the result says."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import linalg

import springpot as sp
from springpot import MeasuredImpacts as Impacts
from springpot import MeasuredModuli as Moduli
from springpot.fitting.kalman import innovations_of
from springpot.fitting.likelihood import slopes
from springpot.fitting.moduli import ModuliLikelihood, complex_modulus
from springpot.fitting.records import RecordLikelihood
from springpot.fitting.spectral_density import folded, response, windowed
from springpot.fitting.state_space import Sampled, state_space
from springpot.machine.arrays import Floats
from springpot.machine.faults import Stopped
from springpot.problem.free_numbers import free_numbers
from springpot.theory.methods.systems.linear import companion_of
from tests.sizes import validation

F = np.geomspace(0.1, 100.0, 21)
ORDER, C = sp.free("order", 0.5, (0.02, 0.98)), sp.free("C", 1.0, (0.01, 100.0))
ARMS = sp.System(
    sp.Mass(2.0),
    sp.Spring(sp.free("k", 3.0, (0.1, 50.0))),
    sp.Dashpot(sp.free("c", 0.1, (0.0, 1.0))),
    sp.Springpot(ORDER, C),
    sp.FractionalMaxwell(sp.Springpot(ORDER, 0.7), sp.Spring(sp.free("k1", 4.0, (0.1, 50.0)))),
    sp.Maxwell(2.0, sp.free("c1", 0.3, (0.01, 5.0))),
    sp.PolynomialSpring((sp.free("p1", 0.4, (0.1, 1.0)),)),
    sp.PiezoelectricCircuit(
        sp.free("theta", 0.5, (0.1, 1.0)), sp.free("R", 3.0, (0.1, 9.0)), sp.free("Cp", 0.6, (0.1, 1.0))
    ),
    sp.Barrier(-1.0),
    sp.WhiteNoise(1.0),
)


def moduli(modulus: Any, error: float, seed: int, **given: Any) -> sp.MeasuredModuli:
    noise = 1.0 + error * np.random.default_rng(seed).standard_normal((2, F.size))
    return sp.MeasuredModuli(F, modulus.real * noise[0], modulus.imag * noise[1], **given)


def paths_of(system: sp.System, step: float, samples: int, noise: float, seed: int, paths: int = 1) -> Floats:
    """Samples with the exact law of a system's displacement."""
    own = state_space(system, "x", step, samples * step)
    rng = np.random.default_rng(seed)

    def root(matrix: Floats) -> Floats:
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))

    kick = root(own.stationary - own.transition @ own.stationary @ own.transition.T)
    state = root(own.stationary) @ rng.standard_normal((len(kick), paths))
    found = np.empty((paths, samples))
    for n in range(samples):
        found[:, n] = own.row @ state
        state = own.transition @ state + kick @ rng.standard_normal(state.shape)
    return found + noise * rng.standard_normal(found.shape)


def test_the_modulus_is_that_of_the_linear_theory() -> None:
    plain = sp.System(*(part for part in ARMS.parts if not isinstance(part, sp.Barrier)))
    w = 2.0 * np.pi * F
    expected = companion_of(plain).dynamic_stiffness(w)[:, 0, 0] + 2.0 * w**2
    assert np.allclose(complex_modulus(ARMS, F)[0], expected, rtol=1e-12)
    mount = sp.System(sp.Spring(9.0), sp.Springpot(0.4, 0.2))
    assert np.allclose(complex_modulus(mount, F)[0], 9.0 + 0.2 * (1j * w) ** 0.4, rtol=1e-12)


def test_derivatives_of_the_moduli_are_those_of_differences() -> None:
    own = ModuliLikelihood(ARMS, moduli(complex_modulus(ARMS, F)[0], 0.03, 1))
    theta = np.array([float(number) for number in own.coordinates.free])
    for exact, function in ((own.sensitivity, lambda t: np.log(own.expected(t))), (own.jacobian, own.residuals)):
        differences = slopes(function, theta, own.coordinates.free)
        assert np.abs(exact(theta) - differences).max() < 1e-7 * np.abs(differences).max()


def test_moduli_without_errors_give_back_their_numbers() -> None:
    w = 2j * np.pi * F
    exact = 3.0 + 2.0 * w**0.4
    found = sp.fit(
        sp.System(sp.Spring(sp.free("k", 1.0, (0.01, 100.0))), sp.Springpot(ORDER, C)),
        sp.MeasuredModuli(F, exact.real, exact.imag, relative_error=0.01),
    )
    assert found.values == pytest.approx({"k": 3.0, "order": 0.4, "C": 2.0}, rel=1e-6)
    assert found.model.of(sp.Springpot)[0].order == pytest.approx(0.4)
    assert free_numbers(found.model) == {}


def test_zener_and_maxwell_arms_and_one_modulus_alone() -> None:
    w = 2j * np.pi * F
    arm = sp.FractionalMaxwell(sp.Springpot(0.6, 0.5), sp.Spring(8.0))
    data = moduli(3.0 + arm.modulus(w), 0.01, 2)
    model = sp.System(
        sp.Spring(sp.free("k", 1.0, (0.01, 100.0))),
        sp.FractionalMaxwell(sp.Springpot(ORDER, C), sp.Spring(sp.free("k1", 2.0, (0.1, 100.0)))),
    )
    found = sp.fit(model, data)
    truth = {"k": 3.0, "order": 0.6, "C": 0.5, "k1": 8.0}
    assert all(abs(found.values[name] - truth[name]) < 4.0 * found.errors[name] for name in truth)
    assert found.extras["relative_error"] == pytest.approx(0.01, rel=0.4)
    loss = sp.fit(sp.Springpot(ORDER, C), sp.MeasuredModuli(F, loss=(2.0 * w**0.3).imag, relative_error=0.02))
    assert loss.values == pytest.approx({"order": 0.3, "C": 2.0}, rel=1e-5)


@pytest.mark.validation  # every day: several models, in test_nonlinear_records.py
def test_the_number_of_elements_is_chosen() -> None:
    w = 2j * np.pi * F
    low, high = sp.free("order_1", 0.3, (0.02, 0.45)), sp.free("order_2", 0.7, (0.5, 0.98))
    one = sp.Springpot(ORDER, C)
    two = sp.System(sp.Springpot(low, C), sp.Springpot(high, sp.free("C2", 1.0, (0.001, 100.0))))
    single, double = 2.0 * w**0.3, 3.0 * w**0.2 + 0.5 * w**0.7
    assert [sp.fit([one, two], moduli(single, 0.02, seed)).choices[0].label for seed in range(5)] == ["springpot"] * 5
    found = sp.fit([one, two], moduli(double, 0.02, 1))
    assert [choice.label for choice in found.choices] == ["springpot + springpot", "springpot"]
    assert found.values["order_2"] == pytest.approx(0.7, abs=0.05)
    assert not sp.fit(one, moduli(double, 0.02, 1)).check().passed


def test_numbers_at_their_bounds_are_said_so() -> None:
    w = 2j * np.pi * F
    found = sp.fit(sp.Springpot(sp.free("order", 0.5, (0.4, 0.9)), C), moduli(2.0 * w**0.3, 0.02, 1))
    assert found.at_bounds == {"order": "low"}
    assert found.values["order"] == 0.4
    assert np.isnan(found.errors["order"])
    assert found.errors["C"] > 0.0
    assert "order is held at its lower bound, 0.4" in found.report()


def test_numbers_that_the_data_do_not_tell_apart_are_named() -> None:
    both = sp.System(
        sp.Spring(sp.free("k1", 1.0, (0.1, 10.0))), sp.Spring(sp.free("k2", 1.0, (0.1, 10.0))), sp.Dashpot(1.0)
    )
    found = sp.fit(both, moduli(4.0 + 2j * np.pi * F, 0.02, 1, relative_error=0.02))
    assert [own.names for own in found.not_told_apart] == [("k1", "k2")]
    assert found.not_told_apart[0].correlation < -0.999
    assert "The data do not tell k1 and k2 apart" in found.report()


def test_what_is_known_of_two_numbers_together_is_said() -> None:
    """In a narrow band C (2 pi f)^order is known, neither of them as well; small errors were not spoken of."""
    f = np.geomspace(50.0, 60.0, 16)
    p, rng = 2j * np.pi * f, np.random.default_rng(1)
    modulus = 2.0 * p**0.5 * (1.0 + 0.01 * rng.standard_normal(16))
    found = sp.fit(sp.Springpot(ORDER, C), sp.MeasuredModuli(f, modulus.real, modulus.imag, relative_error=0.01))
    assert abs(found.correlation("order", "C")) > 0.95
    assert not found.not_told_apart
    (said,) = found.known_together
    assert said in found.report()
    numbers = re.findall(r"order C\^(\S+) is known to \+?-? ?(\S+) %, order alone to (\S+) %", said)
    assert len(numbers) == 1
    power, together, alone = map(float, numbers[0])
    assert together < 0.3 * alone
    assert power > 0.0


def test_a_profile_agrees_with_the_interval_and_reaches_its_level() -> None:
    found = sp.fit(sp.Springpot(ORDER, C), moduli(2.0 * (2j * np.pi * F) ** 0.3, 0.02, 3))
    own = found.profile("order")
    assert own.limits == pytest.approx(found.interval("order"), rel=1e-3)
    assert own.rise.min() == pytest.approx(0.0, abs=1e-6)
    assert own.rise[0] > own.level < own.rise[-1]


def test_folds_and_leakage_of_a_density_are_exact() -> None:
    """The sampled density of an Ornstein-Uhlenbeck process is known in closed form, and so is its correlation."""
    a, step = 0.7, 0.5
    f = np.linspace(0.05, 1.0, 20)

    def density(frequency: Floats) -> Floats:
        return np.asarray(4.0 * a / (a**2 + (2.0 * np.pi * frequency) ** 2))

    phi = np.exp(-a * step)
    exact = 2.0 * step * (1.0 - phi**2) / np.abs(1.0 - phi * np.exp(-2j * np.pi * f * step)) ** 2
    assert np.allclose(folded(density, 1.0 / step)(f), exact, rtol=1e-6)
    length = 32
    for window, shape in (
        ("boxcar", np.ones(length)),
        ("hann", 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)),
    ):
        lags = np.abs(np.subtract.outer(np.arange(length), np.arange(length)))
        waves = np.exp(-2j * np.pi * np.outer(np.arange(17), np.arange(length)) / length) * shape
        periodogram = 2.0 * step * np.einsum("ki,ij,kj->k", waves, phi**lags, waves.conj()).real / (shape @ shape)
        found = windowed(folded(density, 1.0 / step), 1.0 / step, window, length, 512)
        assert np.allclose(found, periodogram, rtol=1e-4)


def test_the_response_is_that_of_the_theory() -> None:
    system = sp.System(
        sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.4, 0.7), sp.WhiteNoise(1.0), sp.ColoredNoise(0.5, 0.3),
        sp.KanaiTajimiNoise(3.0, 0.4, 0.2, on="mass"), sp.CloughPenzienNoise(3.0, 0.4, 0.8, 0.5, 0.3, on="mass"),
    )  # fmt: skip
    f = np.array([0.1, 0.3, 1.0])
    expected = 4.0 * np.pi * sp.theory.linear(system).spectrum(2.0 * np.pi * f)
    assert np.allclose(response(system, "x")(f), expected, rtol=1e-12)
    assert np.allclose(response(system, "v")(f), expected * (2.0 * np.pi * f) ** 2, rtol=1e-12)


def dense(correlation: Floats, values: Floats) -> float:
    """-2 ln L from the covariance of all samples."""
    root = np.linalg.cholesky(linalg.toeplitz(correlation))
    z = linalg.solve_triangular(root, values, lower=True)
    return float(z @ z + 2.0 * np.log(np.diag(root)).sum() + values.size * np.log(2.0 * np.pi))


@cache
def exact_correlation(system: sp.System, step: float, samples: int) -> Floats:
    """Of the displacement, from the modulus itself, by quadrature, without a sum of modes."""
    x, weights = np.polynomial.legendre.leggauss(16)
    edges = np.concatenate(
        [np.geomspace(1e-9, 0.01, 60), np.arange(0.02, 40.0, 0.01), np.geomspace(40.0, 4000.0, 4000)]
    )
    half = 0.5 * np.diff(edges)[:, None]
    f, weight = (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * weights).ravel()
    own = response(system, "x")
    mass = own(f) * weight
    correlation = np.array([mass @ np.cos(2.0 * np.pi * f * step * n) for n in range(samples)])
    last = float(own(edges[-1:])[0])
    correlation[0] += last * edges[-1] / 3.0
    lags = step * np.arange(1, samples)
    correlation[1:] -= last * np.sin(2.0 * np.pi * edges[-1] * lags) / (2.0 * np.pi * lags)
    return correlation


@pytest.mark.parametrize(("order", "noise"), [validation(0.3, 0.0), (0.3, 0.05), validation(0.6, 0.05)])
def test_the_likelihood_of_a_record_is_that_of_its_exact_correlation(order: float, noise: float) -> None:
    system = sp.System(sp.Spring(4.0), sp.Springpot(order, 0.4), sp.WhiteNoise(1.0))
    step, samples = 0.1, 300
    correlation = exact_correlation(system, step, samples)
    spread = noise * correlation[0] ** 0.5
    values = paths_of(system, step, samples, spread, 1)
    noisy = correlation.copy()
    noisy[0] += spread**2
    sampled = state_space(system, "x", step, samples * step)
    assert innovations_of(sampled, spread, values)[0] == pytest.approx(dense(noisy, values[0]), rel=1e-6)


@pytest.mark.parametrize("damping", [0.4, 3.999, 4.0])
def test_the_likelihood_holds_where_two_rates_are_nearly_one(damping: float) -> None:
    """At critical damping the eigenvectors of the transition are parallel."""
    system = sp.System(sp.Spring(4.0), sp.Dashpot(damping), sp.WhiteNoise(1.0))
    sampled = state_space(system, "x", 0.2, 40.0)
    values = paths_of(system, 0.2, 200, 0.02, 1)
    noisy = sampled.correlation(200)
    noisy[0] += 0.02**2
    assert innovations_of(sampled, 0.02, values)[0] == pytest.approx(dense(noisy, values[0]), rel=1e-9)


def test_several_paths_velocities_and_every_kind_of_noise_agree_with_the_dense_likelihood() -> None:
    system = sp.System(
        sp.Spring(4.0),
        sp.Dashpot(0.1),
        sp.FractionalMaxwell(sp.Springpot(0.5, 0.7), sp.Spring(2.0)),
        sp.Maxwell(1.0, 0.5),
        sp.PiezoelectricCircuit(0.5, 3.0, 0.6),
        sp.Constant(2.0),
        sp.ColoredNoise(0.5, 0.3),
        sp.KanaiTajimiNoise(3.0, 0.4, 0.2, on="mass"),
        sp.ThermalNoise(0.1),
    )
    for of, power in (("x", 0), ("v", 2)):
        own = state_space(system, of, 0.2, 60.0)  # type: ignore[arg-type]
        correlation = own.correlation(80)
        f = np.concatenate(
            [np.geomspace(1e-7, 0.01, 2000), np.linspace(0.01, 5.0, 20000)[1:], np.geomspace(5.0, 1e5, 20000)[1:]]
        )
        theory = np.trapezoid(response(system, "x")(f) * (2.0 * np.pi * f) ** power, f)
        assert correlation[0] == pytest.approx(theory, rel=2e-4)
        values = np.random.default_rng(1).standard_normal((3, 80)) + own.mean
        correlation[0] += 0.01
        exact = sum(dense(correlation, path - own.mean) for path in values)
        assert innovations_of(own, 0.1, values)[0] == pytest.approx(exact, rel=1e-9)


def test_innovations_without_variance_are_an_infinite_deviance() -> None:
    still = Sampled(np.eye(1), np.zeros((1, 1)), np.ones(1), 0.0)
    assert innovations_of(still, 0.0, np.ones((1, 4)))[0] == np.inf


def oscillating(order: float = 0.6) -> tuple[sp.System, sp.System]:
    """The truth, and a model whose order, coefficient and noise are free."""
    free = sp.System(sp.Spring(4.0), sp.Springpot(ORDER, C), sp.WhiteNoise(sp.free("q", 0.5, (0.01, 100.0))))
    return sp.System(sp.Spring(4.0), sp.Springpot(order, 0.8), sp.WhiteNoise(1.0)), free


def test_a_record_gives_back_its_numbers_and_its_noise() -> None:
    true, model = oscillating()
    data = sp.MeasuredRecord(0.2 * np.arange(500), paths_of(true, 0.2, 500, 0.03, 1, paths=2))
    found = sp.fit(model, data)
    truth = {"order": 0.6, "C": 0.8, "q": 1.0, "noise": 0.03}
    assert all(abs(found.values[name] - truth[name]) < 4.0 * found.errors[name] for name in truth)
    assert found.check().passed
    assert found.residuals.std() == pytest.approx(1.0, abs=0.1)
    again = sp.fit(model, data)
    assert again.values == found.values


@pytest.mark.parametrize(("decimals", "rounding"), [(3, 1e-3 / 12.0**0.5), validation(None, 1e-8)])
def test_a_record_without_noise_says_so_and_has_the_errors_of_one(decimals: int | None, rounding: float) -> None:
    """A noise of 2e-5 +- 0.006 was found, and the errors of the others were too large."""
    true, model = oscillating()
    values = paths_of(true, 0.2, 500, 0.0, 1)
    values = values if decimals is None else values.round(decimals)
    found = sp.fit(model, sp.MeasuredRecord(0.2 * np.arange(500), values))
    assert found.at_bounds == {"noise": "low"}
    size = 1.0 if decimals is not None else float(values.std())
    assert found.values["noise"] == pytest.approx(rounding * size)
    assert "The measurement noise cannot be found" in found.warnings[0]
    known = sp.fit(model, sp.MeasuredRecord(0.2 * np.arange(500), values, noise=found.values["noise"]))
    assert found.errors["q"] == pytest.approx(known.errors["q"], rel=0.05)
    assert found.values["q"] == pytest.approx(known.values["q"], rel=1e-3)


def test_a_fit_to_a_record_that_is_stopped_keeps_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    true = sp.System(sp.Spring(4.0), sp.Springpot(0.5, 0.8), sp.WhiteNoise(1.0))
    model = sp.System(sp.Spring(4.0), sp.Springpot(ORDER, 0.8), sp.WhiteNoise(sp.free("q", 0.5, (0.01, 100.0))))
    data = sp.MeasuredRecord(0.2 * np.arange(1000), paths_of(true, 0.2, 1000, 0.0, 1), noise=0.01)
    asked: list[int] = []
    filtered = RecordLikelihood._filtered

    def counted(own: RecordLikelihood, *args: Any) -> Any:
        asked.append(1)
        return filtered(own, *args)

    monkeypatch.setattr(RecordLikelihood, "_filtered", counted)
    found = sp.fit(model, data, stop=lambda: len(asked) > 3)
    assert "The fit was stopped" in found.warnings[-1]
    assert all(abs(found.values[name] - value) < 4.0 * found.errors[name] for name, value in (("order", 0.5), ("q", 1)))
    assert len(found.profile("order", 5).values) > 4
    with pytest.raises(Stopped):
        sp.fit(model, data, stop=lambda: True)


@pytest.mark.parametrize("kind", ["impacts", "moduli", "spectrum", "response"])
def test_every_fit_can_be_stopped(kind: str) -> None:
    """At any place of the search: with the best numbers so far, or none where there are none yet."""
    speeds = np.linspace(0.1, 1.0, 20)
    device = sp.System(sp.Spring(4.0), sp.Springpot(0.4, sp.free("C", 0.9, (0.1, 10.0))), sp.WhiteNoise(1.0))
    model, data = {
        "impacts": (sp.Barrier(0.0, sp.free("r", 0.2, (0.1, 1.0))), sp.MeasuredImpacts(speeds, 0.7 * speeds**0.9)),
        "moduli": (device, sp.MeasuredModuli(speeds, 4.0 + speeds, speeds**0.3)),
        "spectrum": (device, sp.MeasuredSpectrum(speeds, 1.0 / speeds, 16.0)),
        "response": (
            device,
            sp.MeasuredFrequencyResponse(speeds, 1.0 / (4.0 - speeds + 1j * speeds), relative_error=0.1),
        ),
    }[kind]
    asked: list[int] = []
    found = sp.fit(model, data, stop=lambda: asked.append(1) or len(asked) > 3)  # type: ignore[func-returns-value]
    assert len(asked) == 4
    assert "The fit was stopped: these are the best numbers so far." in found.warnings
    assert found._best.deviance > sp.fit(model, data)._best.deviance * (1.0 - 1e-9)
    with pytest.raises(Stopped):
        sp.fit(model, data, stop=lambda: True)


def test_a_wall_in_a_record_is_noticed() -> None:
    """The model has no wall; the innovations are not Gaussian."""
    true, model = oscillating()
    data = sp.MeasuredRecord(0.2 * np.arange(1000), np.abs(paths_of(true, 0.2, 1000, 0.0, 1)), noise=0.01)
    assert "the motion is not Gaussian" in " ".join(sp.fit(model, data).check().sentences)


def test_a_spectrum_gives_back_its_numbers() -> None:
    true, model = oscillating()
    record = sp.MeasuredRecord(0.2 * np.arange(4096), paths_of(true, 0.2, 4096, 0.0, 2), noise=0.0)
    found = sp.fit(model, record.spectrum(segment=256))
    truth = {"order": 0.6, "C": 0.8, "q": 1.0}
    assert all(abs(found.values[name] - truth[name]) < 4.0 * found.errors[name] for name in truth)
    assert found.check().passed


def test_restitution_and_its_laws() -> None:
    rng = np.random.default_rng(1)
    before = rng.uniform(0.3, 3.0, 60)
    after = 0.75 * before**0.9
    noisy = sp.MeasuredImpacts(
        before + 0.01 * rng.standard_normal(60), after + 0.01 * rng.standard_normal(60), error=0.01
    )

    def law(v: Any, a: float = sp.free("a", 0.5, (0.05, 2.0)), b: float = sp.free("b", 0.01, (-1.0, 1.0))) -> Any:
        return a * v**-b

    found = sp.fit(law, noisy)
    assert abs(found.values["a"] - 0.75) < 4.0 * found.errors["a"]
    assert abs(found.values["b"] - 0.1) < 4.0 * found.errors["b"]
    assert found.check().passed
    wall = sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0)))
    assert not sp.fit(wall, noisy).check().passed
    assert sp.fit([wall, law], noisy).choices[0].label == "law"
    assert sp.fit(wall, noisy).model.restitution == pytest.approx(0.69, abs=0.03)


def test_a_bouncing_ball() -> None:
    flights = 1.2 * 0.8 ** np.arange(8)
    times = np.concatenate([[0.0], np.cumsum(flights)])
    found = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), sp.MeasuredImpacts.from_times(times))
    assert found.values["r"] == pytest.approx(0.8, rel=1e-6)


def test_a_result_is_words_and_a_dataset() -> None:
    found = sp.fit(sp.Springpot(ORDER, C), moduli(2.0 * (2j * np.pi * F) ** 0.3, 0.02, 3))
    data = found.to_xarray()
    assert dict(data.sizes) == {"parameter": 2, "parameter_2": 2, "point": 42}
    assert float(data["correlation"].sel(parameter="order", parameter_2="C")) == found.correlation("order", "C")
    assert found.to_dict()["values"] == found.values
    assert found.degrees_of_freedom == 40


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.fit(sp.Spring(1.0), Moduli(F, F)), "model must have a free number"),
        (lambda: sp.fit(sp.Springpot(ORDER, C), F), "data must be MeasuredModuli, MeasuredRelaxation, MeasuredC"),
        (lambda: sp.fit(3.0, Moduli(F, F)), "model must be a System or a part"),
        (lambda: sp.fit([sp.Springpot(ORDER, C)], Moduli(F, F)), "model must be a model, or a list of at least two"),
        (lambda: sp.fit(sp.Springpot(ORDER, C), Moduli(F, F), seed=-1), "seed must be a whole number from 0"),
        (lambda: sp.fit(sp.System(sp.Mass(sp.free("m", 1.0, (0.5, 2.0))), sp.Springpot(0.5, 1.0)), Moduli(F, F)),
         "m must not be free: moduli depend on springs"),
        (lambda: sp.fit(sp.System(sp.Dashpot(sp.free("c", 1.0, (0.5, 2.0)))), Moduli(F, F)),
         "model must have a positive storage modulus at every frequency, not 0"),
        (lambda: sp.fit(sp.System(sp.PolynomialSpring((0.0, sp.free("c", 1.0, (0.5, 2.0))))), Moduli(F, F)),
         "a linear system is needed, but polynomial_spring is not linear|the potential must hold the mass"),
        (lambda: sp.fit(oscillating()[1], Moduli(F, F)), "q must not be free"),
        (lambda: sp.fit(sp.Oscillator(springpot=sp.Springpot(ORDER, C)), sp.MeasuredSpectrum(F, F, 3)),
         "covers linear springs, .* not barrier"),
        (lambda: sp.fit(sp.System(sp.Spring(1.0), sp.Springpot(ORDER, C)), sp.MeasuredSpectrum(F, F, 3)),
         "a system without noise has no spectrum"),
        (lambda: sp.fit(oscillating()[1], sp.MeasuredRecord(0.1 * np.arange(64), np.sin(np.arange(64)), of="a")),
         "the acceleration under white_noise on the mass has no finite variance"),
        (lambda: sp.fit(sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.Constant(C), sp.WhiteNoise(1.0)),
                        sp.MeasuredSpectrum(F, F, 3)), "C must not be free: such data do not depend on it"),
        (lambda: sp.fit(sp.System(sp.Spring(1.0), sp.Dashpot(sp.free("noise", 1.0, (0.1, 2.0))), sp.WhiteNoise(1.0)),
                        sp.MeasuredSpectrum(F, F, 3, noise=None)), "noise must not be the name of a free number"),
        (lambda: sp.fit(sp.Spring(1.0), Impacts(F, F)),
         "model must have one wall .*, not 0: give a Barrier, a system with one, or a function"),
        (lambda: sp.fit(lambda v, a: a * v, Impacts(F, F)),
         r"model must have defaults for a, such as a=sp.free\('a'"),
        (lambda: sp.fit(sp.System(sp.Spring(1.0)), Impacts(F, F)),
         "model must have one wall for data of impacts, not 0"),
        (lambda: sp.fit(lambda v, a=C: a - 1000.0 * v, Impacts(F, F)),
         "model must give a positive restitution for every speed"),
    ],
)  # fmt: skip
def test_what_cannot_be_fitted_is_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()
