"""Measurements whose phase has the other sign, as several programs write them: said before a fit, or after it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.fitting.transfer import response_of
from springpot.machine.faults import FileError

TRUE = sp.System(sp.Mass(0.8), sp.Spring(8000.0), sp.Springpot(0.5, 100.0))
MODEL = sp.System(
    sp.Mass(sp.free("m", 1.0, (0.1, 10.0))), sp.Spring(sp.free("k", 5000.0, (100.0, 1e5))),
    sp.Springpot(sp.free("order", 0.3, (0.02, 0.98)), sp.free("C", 50.0, (1.0, 1e4))),
)  # fmt: skip
NUMBERS = {"m": 0.8, "k": 8000.0, "order": 0.5, "C": 100.0}
F = np.linspace(5.0, 40.0, 40)


def measured(of: Any = "x", on: str = "mass", seed: int = 1) -> np.ndarray:
    z = 0.01 * np.random.default_rng(seed).standard_normal((2, F.size))
    return np.asarray(response_of(TRUE, F, of, on)[0] * (1.0 + z[0] + 1j * z[1]))


@pytest.mark.parametrize(("of", "on"), [("x", "mass"), ("a", "mass"), ("x", "ground"), ("a", "ground")])
def test_the_conjugate_of_a_response_is_refused(of: Any, on: Any) -> None:
    right = measured(of, on)
    for errors in ({"relative_error": 0.01}, {"averages": 40.0, "coherence": np.full(F.size, 0.98)}, {}):
        data = sp.MeasuredFrequencyResponse(F, right, of=of, on=on, **errors)
        with pytest.raises(ValueError, match=r"^response must have .*phase is inverted: give response.conj\(\)") as one:
            sp.MeasuredFrequencyResponse(F, right.conj(), of=of, on=on, **errors)
        assert "\n" not in str(one.value)
    found = sp.fit(MODEL, data)
    assert all(abs(found.values[name] - value) < 4.0 * found.errors[name] for name, value in NUMBERS.items())


def test_a_file_says_what_to_do(tmp_path: Path) -> None:
    rows = (f"{f:.6g},{h.real:.8e},{-h.imag:.8e}" for f, h in zip(F, measured(), strict=True))
    place = tmp_path / "frf.csv"
    place.write_text(
        "\n".join(["# relative_error = 0.01", "frequency_hz,real_m/N,imaginary_m/N", *rows]), encoding="utf-8"
    )
    with pytest.raises(FileError, match=r"must have a negative imaginary part.* at 3. of 40 points: .* times -1; or"):
        sp.read_data(place)


def test_opposite_directions_of_a_mobility_are_refused_and_its_conjugate_is_told_by_the_fit() -> None:
    """The real part of a conjugate is the same: no sign of it is wrong."""
    right = measured("v")
    with pytest.raises(ValueError, match=r"must have a positive real part, .*directions: give -response\.$"):
        sp.MeasuredFrequencyResponse(F, -right, of="v", relative_error=0.01)
    found = sp.fit(MODEL, sp.MeasuredFrequencyResponse(F, right.conj(), of="v", relative_error=0.01))
    assert any("far better with the sign of its phase inverted: give response.conj()" in one for one in found.warnings)
    found = sp.fit(MODEL, sp.MeasuredFrequencyResponse(F, right, of="v", relative_error=0.01))
    assert not any("far better" in one for one in found.warnings)


@pytest.mark.parametrize("turn", ["conj", "negative"])
def test_the_response_of_another_mass_is_told_by_the_fit(turn: str) -> None:
    """Of a transfer no sign is known before."""

    def pair(k: Any) -> sp.System:
        return sp.System(
            sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(k, between=("ground", "a")),
            sp.Spring(3000.0, between=("a", "b")), sp.Springpot(0.4, 60.0, between=("a", "b")),
        )  # fmt: skip

    exact = response_of(pair(6000.0), F, "x", "a", "b")[0]
    turned = exact.conj() if turn == "conj" else -exact
    model = pair(sp.free("k", 5000.0, (100.0, 1e5)))
    data = sp.MeasuredFrequencyResponse(F, turned, relative_error=0.01, on="a", at="b")
    word = "response.conj()" if turn == "conj" else "-response"
    assert any(f"give {word}." in one for one in sp.fit(model, data).warnings)


def test_a_negative_loss_modulus_is_refused(tmp_path: Path) -> None:
    f = np.geomspace(0.1, 10.0, 8)
    modulus = 1e6 * (2j * np.pi * f) ** 0.3
    with pytest.raises(
        ValueError, match=r"^loss must be positive, but all 8 points are negative: the sign of the phase"
    ):
        sp.MeasuredModuli(f, modulus.real, -modulus.imag)
    one = modulus.imag.copy()
    one[3] = -one[3]
    with pytest.raises(ValueError, match=r"loss\[3\] must be greater than 0"):
        sp.MeasuredModuli(f, modulus.real, one)
    rows = (f"{w:g},{g.real:g},{-g.imag:g}" for w, g in zip(f, modulus, strict=True))
    (tmp_path / "a.csv").write_text("\n".join(["frequency_hz,storage_Pa,loss_Pa", *rows]), encoding="utf-8")
    with pytest.raises(FileError, match=r"loss must be positive, but all 8 points are negative.* give -loss"):
        sp.read_data(tmp_path / "a.csv")
