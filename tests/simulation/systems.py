"""Systems of many kinds of parts at once, and their exact laws, by quadrature: what the tests of systems compare with.

Parts that a test does not need are there with hardly any strength, or far away: they must change nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import integrate

import springpot as sp
from springpot.problem.parts import PiezoelectricCircuit

__all__ = [
    "AWAY", "NEARLY_LINEAR", "boltzmann", "circuit", "filtered", "of_many_kinds", "poisson_fourth_moment",
    "rates_of_walls", "white",
]  # fmt: skip

NEARLY_LINEAR = sp.PolynomialSpring((0.0, 0.0, 1e-12))
AWAY = sp.Barrier(-200.0), sp.Barrier(200.0, free_side="below")

_HARDLY_ANY = (
    sp.ParametricNoise(1e-14), sp.VanDerPol(1e-14), sp.PolynomialDashpot((0.0, 0.0, 1e-14)),
    sp.PoissonImpulses(0.5, 2e-14), sp.Harmonic(0.0, 1.2), sp.Contact(200.0, 50.0, free_side="below"),
    sp.Barrier(-300.0),
)  # fmt: skip


def of_many_kinds(*parts: Any) -> sp.System:
    """A system of these parts and hardly any of every kind of force and wall that is not among them."""
    kinds = tuple(type(part) for part in _HARDLY_ANY)
    rest = [part for part in parts if not isinstance(part, kinds)]
    for faint in _HARDLY_ANY:
        rest += [part for part in parts if isinstance(part, type(faint))] or [faint]
    return sp.System(*rest)


def boltzmann(
    temperature: float, energy: Callable[[np.ndarray], np.ndarray], low: float, high: float
) -> dict[str, float]:
    """Moments of exp(-(v^2 / 2 + U) / kT) between two places, and the density at both."""
    x = np.linspace(low, high, 200_001)
    weights = np.exp(-(energy(x) - energy(x).min()) / temperature)
    total = float(np.trapezoid(weights, x))
    return {
        "x_mean": float(np.trapezoid(weights * x, x)) / total,
        "x_mean_square": float(np.trapezoid(weights * x * x, x)) / total,
        "v_mean_square": temperature,
        "low": float(weights[0]) / total,
        "high": float(weights[-1]) / total,
    }


def rates_of_walls(law: dict[str, float], names: Sequence[str] = ("barrier_1", "barrier_2")) -> dict[str, float]:
    """The moments of that law, and what elastic walls at its two ends count."""
    theta = law["v_mean_square"]
    speed = math.sqrt(theta / (2.0 * math.pi))
    found = {name: law[name] for name in ("x_mean", "x_mean_square", "v_mean_square")}
    for name, end in zip(names, ("low", "high"), strict=False):
        found[f"{name}_impact_rate"] = law[end] * speed
        found[f"{name}_impact_speed_mean"] = math.sqrt(0.5 * math.pi * theta)
    return found


def filtered(
    modulus: Callable[[complex], complex], density: Callable[[float], float], peaks: Sequence[float] = (1.0,)
) -> dict[str, float]:
    """Moments of x'' + modulus x = noise with a two-sided spectral density; ``modulus`` has the spring in it."""
    ends = sorted({0.0, *(f * peak for peak in peaks for f in (0.5, 0.9, 1.0, 1.1, 1.5, 3.0, 10.0)), math.inf})

    def moment(power: int) -> float:
        return 2.0 * sum(
            integrate.quad(lambda w: w**power * density(w) / abs(modulus(1j * w) - w * w) ** 2, a, b, limit=400)[0]
            for a, b in pairwise(ends)
        )

    return {"x_mean_square": moment(0), "v_mean_square": moment(2)}


def white(intensity: float) -> Callable[[float], float]:
    """Density of white noise."""
    return lambda w: intensity / (2.0 * math.pi)


def circuit(part: PiezoelectricCircuit) -> Callable[[complex], complex]:
    """The modulus of a circuit: theta V per displacement."""
    return lambda p: part.coupling**2 * p / (part.capacitance * p + 1.0 / part.resistance)


def poisson_fourth_moment(stiffness: float, damping: float, rate: float, mean_square: float) -> float:
    """E x^4 of a linear oscillator under Poisson impulses: 3 E[x^2]^2 and the fourth cumulant."""
    w = math.sqrt(stiffness - 0.25 * damping**2)

    def answer(t: float) -> float:
        return math.exp(-0.5 * damping * t) * math.sin(w * t) / w

    square, fourth = (integrate.quad(lambda t, n=n: answer(t) ** n, 0.0, 80.0 / damping, limit=800)[0] for n in (2, 4))
    return float(3.0 * (rate * mean_square * square) ** 2 + 3.0 * rate * mean_square**2 * fourth)
