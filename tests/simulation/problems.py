"""Short ways to state a problem, and the comparison in standard errors that every test of dice uses."""

from __future__ import annotations

import math

import springpot as sp
from springpot.simulation import Run


def oscillator(
    order: float = 0.5,
    coefficient: float = 1.0,
    frequency: float = 1.0,
    intensity: float = 1.0,
    position: float | None = 0.0,
    restitution: float = 1.0,
    free_side: str = "above",
) -> sp.Oscillator:
    barrier = None if position is None else sp.Barrier(position, restitution, free_side)  # type: ignore[arg-type]
    return sp.Oscillator(frequency, sp.Springpot(order, coefficient), barrier, sp.WhiteNoise(intensity))


def values_of(run: Run) -> dict[str, float]:
    """The values of a run by name."""
    return {name: estimate.value for name, estimate in run.estimates.items()}


def errors_of(run: Run) -> dict[str, float]:
    """The standard errors of a run by name."""
    return {name: estimate.error for name, estimate in run.estimates.items()}


def assert_agrees(run: Run, exact: dict[str, float], *, most: float = 4.0, sharp: float = 0.005) -> None:
    """Each value lies within ``most`` standard errors, and these are small enough for 2 % to be noticed."""
    for name, wanted in exact.items():
        value, error = run[name].value, run[name].error
        assert error < sharp * abs(wanted), f"{name}: not sharp enough, {value} +- {error} for {wanted}"
        gap = (value - wanted) / error
        assert abs(gap) < most, f"{name}: {value} +- {error}, exactly {wanted}: {gap:+.1f} standard errors"


def truncated_gaussian(position: float, coefficient: float, frequency: float, intensity: float) -> dict[str, float]:
    """Order 1, r = 1, any wall: the stationary law is the Maxwell-Boltzmann law above the wall."""
    speed = math.sqrt(intensity / (2.0 * coefficient))
    spread = speed / frequency
    k = position / spread
    hazard = math.exp(-0.5 * k * k) / math.sqrt(2.0 * math.pi) / (0.5 * math.erfc(k / math.sqrt(2.0)))
    return {
        "x_mean": spread * hazard,
        "x_mean_square": spread**2 * (1.0 + k * hazard),
        "v_mean_square": speed**2,
        "amplitude_mean_square": spread**2 * (2.0 + k * hazard),
        "impact_rate": hazard * speed / (spread * math.sqrt(2.0 * math.pi)),
        "impact_speed_mean": speed * math.sqrt(math.pi / 2.0),
        "impact_speed_mean_square": 2.0 * speed**2,
    }
