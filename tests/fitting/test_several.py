"""Fits of several masses: the same data as of one, of the mass that was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.fitting.likelihood import slopes
from springpot.fitting.spectral_density import response
from springpot.fitting.state_space import state_space
from springpot.fitting.transfer import ResponseLikelihood, response_of
from springpot.machine.faults import NotCoveredError
from tests.several import chain

F = np.linspace(0.05, 0.8, 30)
W = 2.0 * np.pi * F
NOISES = sp.KanaiTajimiNoise(2.0, 0.5, 0.1, on="ground"), sp.ColoredNoise(0.2, 0.5, on="c")
LINK: dict[str, Any] = {"between": ("a", "b")}


def model(mass: Any = 1.2, stiffness: Any = 2.5, order: Any = 0.5, coefficient: Any = 0.4) -> sp.System:
    return sp.System(
        sp.Mass(mass, at="a"), sp.Mass(0.7, at="b"), sp.Spring(stiffness, between=("ground", "a")),
        sp.Dashpot(0.1, between=("ground", "a")), sp.Springpot(order, coefficient, **LINK), sp.Spring(1.0, **LINK),
        sp.WhiteNoise(1.0, on="a"),
    )  # fmt: skip


FREE = model(stiffness=sp.free("k", 2.0, (1.0, 5.0)), coefficient=sp.free("c", 0.3, (0.1, 1.0)))
ALL_FREE = model(sp.free("m", 1.3, (0.5, 3.0)), sp.free("k", 2.0, (1.0, 5.0)), sp.free("o", 0.4, (0.2, 0.9)),
                 sp.free("c", 0.3, (0.1, 1.0)))  # fmt: skip


def near(fit: sp.fitting.Fit) -> bool:
    return all(abs(fit.values[name] - value) < 3.5 * fit.errors[name] for name, value in {"k": 2.5, "c": 0.4}.items())


def test_responses_are_those_of_the_linear_theory() -> None:
    """Also of a point that is no mass, on a rigid bar between two."""
    system = sp.System(*chain(sp.WhiteNoise(0.5, on="d")).parts, sp.Point("bar", ("b", "c"), (0.4, 0.6)))
    linear = sp.theory.linear(system)
    for point in ("b", "bar"):
        for on in ("d", "ground", "bar"):
            exact = linear.frequency_response(W, of=point, on=on)
            assert np.allclose(response_of(system, F, "x", on, point)[0], exact, rtol=1e-12)
        shaken = linear.frequency_response(W, of=point, on="ground")
        assert np.allclose(response_of(system, F, "a", "ground", point)[0], 1.0 - W**2 * shaken, rtol=1e-10)
        assert np.allclose(response(system, "x", at=point)(F), 4.0 * np.pi * linear.spectrum(W, of=point), rtol=1e-12)


@pytest.mark.parametrize(("of", "on"), [("x", "a"), ("v", "ground"), ("a", "b"), ("a", "ground")])
def test_derivatives_are_those_of_differences(of: Any, on: str) -> None:
    exact = response_of(model(), F, of, on, "b")[0]
    own = ResponseLikelihood(ALL_FREE, sp.MeasuredFrequencyResponse(F, exact, relative_error=0.1, of=of, on=on, at="b"))
    theta = np.array([float(number) for number in own.coordinates.free])
    differences = slopes(own.residuals, theta, own.coordinates.free)
    assert np.abs(own.jacobian(theta) - differences).max() < 1e-6 * np.abs(differences).max()


@pytest.mark.parametrize(
    "system",
    [chain(*NOISES), chain(sp.WhiteNoise(0.5, on="d")), chain(sp.ThermalNoise(0.3), sp.Dashpot(0.1, **LINK))],
    ids=("shaken", "white", "thermal"),
)
def test_states_and_spectra_have_the_moments_of_the_linear_theory(system: sp.System) -> None:
    linear = sp.theory.linear(system)
    for of, power in (("x", 0), ("v", 2)):
        space = state_space(system, of, 0.1, 400.0, "b")
        assert space.row @ space.stationary @ space.row == pytest.approx(
            getattr(linear, f"b_{of}_mean_square"), rel=1e-7
        )
        density = 4.0 * np.pi * linear.spectrum(W, of="b") * W**power
        assert np.allclose(response(system, of, at="b")(F), density, rtol=1e-10)


def test_an_accelerometer_has_the_variance_of_its_spectrum() -> None:
    space = state_space(chain(NOISES[0]), "a", 0.05, 400.0, "b")
    f = np.linspace(1e-4, 20.0, 100001)
    whole = np.trapezoid(response(chain(NOISES[0]), "a", at="b")(f), f)
    assert space.row @ space.stationary @ space.row == pytest.approx(whole, rel=5e-5)


def test_a_response_and_a_spectrum_give_back_their_numbers(tmp_path: Path) -> None:
    """From files with the masses in their settings."""
    rng = np.random.default_rng(1)
    z = 0.02 * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
    measured = response_of(model(), F, "x", "a", "b")[0] * (1.0 + z)
    rows = "\n".join(f"{f},{h.real},{h.imag}" for f, h in zip(F, measured, strict=True))
    (tmp_path / "a.csv").write_text(
        f"# relative_error = 0.02\n# at = b\n# on = a\nfrequency_hz,real_m/N,imaginary_m/N\n{rows}", encoding="utf-8"
    )
    assert near(sp.fit(FREE, sp.read_data(tmp_path / "a.csv")))
    density = response(model(), "x", at="b")(F) * rng.gamma(30.0, 1.0 / 30.0, F.size)
    rows = "\n".join(f"{f},{d}" for f, d in zip(F, density, strict=True))
    (tmp_path / "b.csv").write_text(f"# averages = 30\n# at = b\nfrequency_hz,density_m2/Hz\n{rows}", encoding="utf-8")
    assert near(sp.fit(FREE, sp.read_data(tmp_path / "b.csv")))


def test_a_record_gives_back_its_numbers() -> None:
    run = sp.simulate(model(), paths=1, duration=400.0, window=(100.0, 400.0), record=1, step=0.05, seed=3)
    late = np.flatnonzero(run.time >= 100.0)[::8]
    assert near(sp.fit(FREE, sp.MeasuredRecord(run.time[late], run.record[:, late, 1, 0], at="b", noise=0.0)))


@pytest.mark.validation  # every day: statistics of one mass, in test_statistics.py
def test_statistics_of_points_give_back_their_numbers(tmp_path: Path) -> None:
    """The 0.9 quantile of a normal displacement is at 1.2816 standard deviations."""
    linear = sp.theory.linear(model())
    lines = [f"a_x_rms (mm),{1e3 * linear.a_x_mean_square**0.5},15",
             f"b_v_mean_square (m2/s2),{linear.b_v_mean_square},0.05",
             f"a_b_elongation_rms (m),{linear.a_b_elongation_mean_square**0.5},0.01",
             f"b_x_quantile_0.9 (m),{1.28155 * linear.b_x_mean_square**0.5},0.02",
             f"b_x_standard_deviation (m),{linear.b_x_mean_square**0.5},0.02"]  # fmt: skip
    (tmp_path / "s.csv").write_text("\n".join(["quantity,value,error", *lines]), encoding="utf-8")
    assert near(sp.fit(FREE, sp.read_data(tmp_path / "s.csv"), paths=1024))


RESPONSE = response_of(model(), F, "x", "a", "b")[0]


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        (sp.MeasuredFrequencyResponse(F, RESPONSE, on="a"), "at of the data must be 'a' or 'b', not None"),
        (sp.MeasuredFrequencyResponse(F, RESPONSE, at="b"), "on of the data must be 'a' or 'b', not 'mass'"),
        (sp.MeasuredSpectrum(F, F, 30.0, at="c"), "at of the data must be 'a' or 'b', not 'c'"),
        (sp.MeasuredModuli(F, F, F), "one mass is needed, and the system has 2, a and b"),
        (sp.MeasuredStatistics(x_rms=(1.0, 0.1), b_x_mean=(1.0, 0.1)), "data must be of results of the model, which"),
    ],
)
def test_what_does_not_fit_is_one_sentence(data: Any, sentence: str) -> None:
    with pytest.raises((ValueError, NotCoveredError), match=sentence):
        sp.fit(FREE, data)


@pytest.mark.parametrize(("of", "on"), [("x", "tip"), ("v", "ground"), ("a", "m"), ("a", "ground")])
def test_shapes_and_participations_of_modes_can_be_free(of: Any, on: str) -> None:
    """Of a point with parts to the ground and to another point, which is measured and pushed."""

    def modal(share: Any, other: Any, participation: Any) -> sp.System:
        return sp.System(
            sp.Mass(1.0, at="m", participation=1.3), sp.Mass(0.8, at="n", participation=participation),
            *(sp.Spring(k, between=("ground", mode)) for k, mode in ((2.0, "m"), (9.0, "n"))),
            *(sp.Dashpot(0.1, between=("ground", mode)) for mode in "mn"),
            sp.Point("tip", ("m", "n"), (1.0, share)), sp.Point("middle", ("n", "m"), (0.6, other)),
            sp.Springpot(0.5, 0.3, between=("middle", "tip")), sp.Inerter(0.2, between=("ground", "tip")),
            sp.WhiteNoise(1.0, on="tip"),
        )  # fmt: skip

    true = {"s": -0.8, "o": 0.3, "p": -0.4}
    exact = response_of(modal(*true.values()), F, of, on, "tip")[0]
    given = (sp.free(name, value + 0.05, (-2.0, 2.0)) for name, value in true.items() if name != "p" or on == "ground")
    free = modal(*given, *([] if on == "ground" else [-0.4]))
    data = sp.MeasuredFrequencyResponse(F, exact, relative_error=0.01, of=of, on=on, at="tip")
    own = ResponseLikelihood(free, data)
    theta = np.array([float(number) for number in own.coordinates.free])
    differences = slopes(own.residuals, theta, own.coordinates.free)
    assert np.abs(own.jacobian(theta) - differences).max() < 1e-5 * np.abs(differences).max()
    found = sp.fit(free, data)
    assert {name: found.values[name] for name in own.coordinates.names} == pytest.approx(
        {name: true[name] for name in own.coordinates.names}, abs=1e-6
    )
