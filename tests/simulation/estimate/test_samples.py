"""Powers, and the balance of energy."""

from __future__ import annotations

import pytest

import springpot as sp

HALF = sp.TabulatedEnvelope((0.0, 100.0), (0.5, 0.5))


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize("on", ["mass", "b"])
@pytest.mark.parametrize(
    ("noise", "intensity"),
    [
        (lambda on: sp.PoissonImpulses(4.0, 0.25, on=on), 1.0),
        (lambda on: sp.WhiteNoise(2.0, on=on, envelope=HALF), 0.5),
    ],
    ids=["impulses", "envelope"],
)
def test_noise_with_independent_increments_feeds_in_what_is_expected(on: str, noise: object, intensity: float) -> None:
    """Half its intensity over the mass, whatever it is named in the kernel; the balance of energy is a check of it."""
    ends = None if on == "mass" else ("a", "b")
    masses = () if on == "mass" else (
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
        sp.Dashpot(0.5, between=("ground", "a")),
    )  # fmt: skip
    system = sp.System(*masses, sp.Spring(1.0, between=ends), sp.Dashpot(0.5, between=ends), noise(on))  # type: ignore[operator]
    run = sp.simulate(system, paths=4000, duration=40.0, window=(20.0, 40.0), seed=1)
    power, residual = run["input_power"], run["energy_residual"]
    assert abs(power.value - 0.5 * intensity) < 4.0 * power.error < 0.08 * intensity
    assert abs(residual.value) < 4.0 * residual.error < 0.08
