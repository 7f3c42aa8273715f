"""Frequency responses: the closed form against the linear theory, fits, files and bad data."""

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
from springpot.machine.faults import FileError, NotCoveredError

F = np.geomspace(0.5, 20.0, 41)
DEVICE = sp.System(
    sp.Mass(sp.free("m", 2.0, (0.5, 8.0))), sp.Spring(sp.free("k", 800.0, (80.0, 8000.0))), sp.Dashpot(0.3),
    sp.Springpot(sp.free("order", 0.4, (0.05, 0.95)), sp.free("C", 30.0, (1.0, 300.0))), sp.Maxwell(50.0, 4.0),
    sp.PiezoelectricCircuit(0.5, 3.0, 0.6), sp.WhiteNoise(1.0),
)  # fmt: skip


def measured(system: sp.System, seed: int, averages: float = 40.0, **given: Any) -> sp.MeasuredFrequencyResponse:
    """With complex errors whose size follows from the coherence."""
    exact, _ = response_of(system, F, given.get("of", "x"), given.get("on", "mass"))
    coherence = 0.98 - 0.3 * np.abs(np.log(F / 3.0)) / 3.0
    z = np.random.default_rng(seed).standard_normal((2, F.size)) * np.sqrt((1 - coherence) / (2 * averages * coherence))
    return sp.MeasuredFrequencyResponse(
        F, exact * (1.0 + z[0] + 1j * z[1]), averages=averages, coherence=coherence, **given
    )


def test_the_response_is_that_of_the_linear_theory() -> None:
    linear, w = sp.theory.linear(DEVICE), 2.0 * np.pi * F
    exact = linear.frequency_response(w)
    assert np.allclose(response_of(DEVICE, F, "x", "mass")[0], exact, rtol=1e-12)
    assert np.allclose(response_of(DEVICE, F, "a", "mass")[0], -(w**2) * exact, rtol=1e-12)
    assert np.allclose(response_of(DEVICE, F, "v", "ground")[0], -2.0j * w * exact, rtol=1e-12)
    assert np.allclose(response_of(DEVICE, F, "a", "ground")[0], 1.0 + w**2 * 2.0 * exact, rtol=1e-9)
    mount = sp.System(sp.Spring(9.0), sp.Springpot(0.4, 0.2))
    assert np.allclose(response_of(mount, F, "x", "mass")[0], 1.0 / (9.0 + 0.2 * (1j * w) ** 0.4 - w**2))


@pytest.mark.parametrize(("of", "on"), [("x", "mass"), ("v", "mass"), ("a", "mass"), ("x", "ground"), ("a", "ground")])
def test_derivatives_are_those_of_differences(of: Any, on: Any) -> None:
    own = ResponseLikelihood(DEVICE, measured(DEVICE, 1, of=of, on=on))
    theta = np.array([float(number) for number in own.coordinates.free])
    differences = slopes(own.residuals, theta, own.coordinates.free)
    assert np.abs(own.jacobian(theta) - differences).max() < 1e-6 * np.abs(differences).max()


def test_the_ground_accelerates_the_mass_and_not_an_inerter() -> None:
    inertance = sp.free("b", 3.0, (0.5, 9.0))
    device = sp.System(*DEVICE.parts[:3], sp.Inerter(inertance), sp.WhiteNoise(0.5, on="ground"))
    linear, w = sp.theory.linear(device), 2.0 * np.pi * F
    exact = linear.frequency_response(w)
    assert np.allclose(response_of(device, F, "x", "mass")[0], exact, rtol=1e-12)
    assert np.allclose(response_of(device, F, "x", "ground")[0], -device.mass * exact, rtol=1e-12)
    whole = 1.0 + w**2 * device.mass * exact
    assert np.allclose(response_of(device, F, "a", "ground")[0], whole, rtol=1e-9)
    assert np.allclose(response(device, "x")(F), 2.0 * 0.5 * np.abs(device.mass * exact) ** 2, rtol=1e-9)
    assert np.allclose(response(device, "a")(F), 2.0 * 0.5 * np.abs(whole) ** 2, rtol=1e-9)
    for of, on in (("x", "mass"), ("v", "ground"), ("a", "ground")):
        own = ResponseLikelihood(device, measured(device, 1, of=of, on=on))
        assert "b" in own.coordinates.names
        theta = np.array([float(number) for number in own.coordinates.free])
        differences = slopes(own.residuals, theta, own.coordinates.free)
        assert np.abs(own.jacobian(theta) - differences).max() < 1e-6 * np.abs(differences).max()
    with pytest.raises(NotCoveredError, match="where the mass is all of the inertia"):
        state_space(device, "a", 0.01, 10.0)


def test_a_fit_gives_back_its_numbers() -> None:
    truth = {"m": 1.7, "k": 600.0, "order": 0.6, "C": 20.0}
    true = sp.System(sp.Mass(1.7), sp.Spring(600.0), sp.Springpot(0.6, 20.0))
    model = sp.System(DEVICE.parts[0], DEVICE.parts[1], DEVICE.parts[3])
    found = sp.fit(model, measured(true, 2))
    assert all(abs(found.values[name] - value) < 4.0 * found.errors[name] for name, value in truth.items())
    assert found.check().passed
    assert found.report().startswith("fit of 4 numbers to 82 magnitudes and phases")
    assert len(sp.figures.plot_fit(found).axes) == 3
    own = measured(true, 2)
    scatter = sp.fit(model, sp.MeasuredFrequencyResponse(F, own.response))
    assert scatter.extras["relative_error"] == pytest.approx(np.sqrt(np.mean(np.square(own.errors))), rel=0.3)


GOOD = "# averages = 20\nfrequency_hz,magnitude_mm/N,phase_deg,coherence_1\n1,2,-10,0.9\n2,4,-90,0.99\n4,0.5,-170,0.9\n"


def test_a_file_is_read_in_si_units(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(GOOD, encoding="utf-8")
    found = sp.read_data(tmp_path / "a.csv")
    assert isinstance(found, sp.MeasuredFrequencyResponse)
    assert found.response[1] == pytest.approx(-4e-3j)
    assert (found.of, found.on, found.averages) == ("x", "mass", 20.0)
    (tmp_path / "a.csv").write_text("frequency_hz;real_1;imaginary_1\n1;1;0\n2;2;-3\n3;-0.1;0\n", encoding="utf-8")
    found = sp.read_data(tmp_path / "a.csv")
    assert isinstance(found, sp.MeasuredFrequencyResponse)
    assert (found.of, found.on, complex(found.response[1])) == ("a", "ground", 2.0 - 3.0j)


BAD = [
    (GOOD.replace("# averages = 20\n", ""), "averages and coherence must be given together"),
    (GOOD.replace("0.99", "1.0"), "line 4: coherence_1 must be above 0 and below 1, not 1"),
    (
        GOOD.replace("0.99", "0.01"),
        "line 4: coherence_1 is too small: with 20 averages the error of this point is 157 %",
    ),
    (GOOD.replace("4,-90", "0,-90"), "line 4: magnitude_mm/N must be a finite number other than 0"),
    (GOOD.replace("phase_deg", "phase_turns"), "the unit of phase must be deg or rad, not 'turns'"),
    (GOOD.replace(",phase_deg", ",real_m/N"), "must have columns magnitude_m/N and phase_deg, or real_m/N and imag"),
    (GOOD.replace("# averages = 20", "# averages = 1"), "averages must be"),
    (
        GOOD.replace("# averages", "# noise = 3\n# averages"),
        "noise is a setting of a spectrum or a record, not of a freq",
    ),
    ("frequency_hz,real_m/N,imaginary_mm/N\n1,1,1\n2,2,2\n3,3,3\n", "real and imaginary must have the same unit"),
]


@pytest.mark.parametrize(("text", "sentence"), BAD)
def test_a_bad_file_is_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match=sentence):
        sp.read_data(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.MeasuredFrequencyResponse(F, F * 1j, averages=10), "averages and coherence must be given together"),
        (lambda: sp.MeasuredFrequencyResponse(F, F[:-1] * 1j), "response must have a number for each of the 41 points"),
        (lambda: sp.fit(DEVICE, sp.MeasuredFrequencyResponse(F, F, on="air")), "on of the data must be 'mass', not"),
        (lambda: sp.MeasuredFrequencyResponse(F, F, on=1), "on must be 'mass'"),
        (lambda: sp.MeasuredFrequencyResponse(F, F, relative_error=0.7), "must be above 0 and at most 0.5"),
        (
            lambda: sp.MeasuredFrequencyResponse(F, F, averages=9, coherence=0.9 + 0 * F, relative_error=0.1),
            "must be left out"),
        (lambda: sp.fit(sp.System(*DEVICE.parts, sp.Barrier(-1.0)), measured(DEVICE, 1)), "not barrier"),
        (lambda: sp.fit(sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.WhiteNoise(sp.free("q", 1.0, (0.1, 2.0)))),
                        measured(DEVICE, 1)), "q must not be free: such data do not depend on it"),
    ],
)  # fmt: skip
def test_what_cannot_be_fitted_is_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()
