"""A linear system as a state with first-order equations: displacement, velocity, modes of the memory and of the noise.

The memory of a springpot is a sum of modes: C p^alpha = (C sin(pi alpha) / pi) int p / (p + s) s^(alpha - 1) ds.  With
s = e^u the trapezoidal rule converges like exp(-pi^2 / h), h its spacing, and its rates do not depend on the numbers
that are found; the modes beyond both ends are geometric series, each replaced by one mode with their first two moments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springpot.fitting.likelihood import FloatArray
from springpot.fitting.motion_data import Of
from springpot.fitting.spectral_density import row_of
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    CloughPenzienNoise,
    ColoredNoise,
    Constant,
    FractionalMaxwell,
    Harmonic,
    KanaiTajimiNoise,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    RecordedExcitation,
    ResonantCircuit,
    SpectralExcitation,
    Springpot,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.parts.excitations import Excitation
from springpot.problem.parts.registration import Element
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import Companion, companion_of

__all__ = ["Sampled", "StateSpace", "state_space"]

_SPACING = 0.55  # of the logarithms of the rates: exp(-pi^2 / h) is 2e-8
_SLOWEST = 0.05  # of one over the duration
_FASTEST = 40.0  # of the highest frequency of the samples, pi / step


@dataclass(frozen=True, eq=False)
class Sampled:
    """The state at the samples: X' = transition X + noise, value = row X + mean + measurement noise.

    Attributes
    ----------
    transition : ndarray, shape (states, states)
    stationary : ndarray, shape (states, states)
        Covariance of the state.
    row : ndarray, shape (states,)
    mean : float
    """

    transition: FloatArray
    stationary: FloatArray
    row: FloatArray
    mean: float

    def correlation(self, samples: int) -> FloatArray:
        """Covariance of the value with that of 0, 1, ... samples before."""
        at = self.stationary @ self.row
        found = np.empty(samples)
        for n in range(samples):
            found[n] = self.row @ at
            at = self.transition @ at
        return found


@dataclass(frozen=True, eq=False)
class StateSpace:
    """dX = rates X dt + noise.

    Attributes
    ----------
    rates : ndarray, shape (states, states)
    noise : ndarray, shape (states, states)
        Intensity of the white noise in each.
    row : ndarray, shape (states,)
        The measured value.
    mean : float
    """

    rates: FloatArray
    noise: FloatArray
    row: FloatArray
    mean: float

    def sampled(self, step: float) -> Sampled:
        """The same at samples."""
        from scipy import linalg

        stationary = np.array(linalg.solve_continuous_lyapunov(self.rates, -self.noise)).astype(np.float64)
        transition = np.asarray(linalg.expm(self.rates * step))
        return Sampled(transition, 0.5 * (stationary + stationary.T), self.row, self.mean)


def state_space(system: System, of: Of, step: float, duration: float, at: str | None = None) -> StateSpace:
    """The state of a linear system whose samples have this step and duration.

    Parameters
    ----------
    system : System
        Linear, without walls, under white, colored, filtered or thermal noise.
    of : {"x", "v", "a"}
    step, duration : float
        In s: they set the range of the rates.
    at : str, optional
        The mass, where there are several.

    Returns
    -------
    StateSpace

    Raises
    ------
    NotCoveredError
        If a part is not linear, or the excitation is not a Gaussian stationary noise.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> own = state_space(System(Spring(4.0), Springpot(0.5, 1.0), WhiteNoise(1.0)), "x", 0.1, 100.0)
    >>> own.rates.shape
    (32, 32)
    """
    for name, part in system.named():
        if isinstance(part, Harmonic | ParametricNoise | RecordedExcitation | PoissonImpulses):
            raise NotCoveredError(f"{name} is no stationary Gaussian noise: a fit of a record does not cover it.")
        if isinstance(part, SpectralExcitation | CloughPenzienNoise):
            raise NotCoveredError(f"{name} has a density without a short state: a fit of a record does not cover it.")
    own = companion_of(system)
    noises = [part for part in system.of(Excitation) if not isinstance(part, Constant | ThermalNoise)]
    if not own.noises and not own.temperature:
        raise NotCoveredError("a system without noise does not move: add a WhiteNoise or another noise.")
    if of == "a" and (not all(part.of_ground for part in noises) or own.temperature > 0.0):
        raise NotCoveredError(
            "an acceleration is covered for noise of the ground only: with a force on the mass it has no "
            "finite variance, or is not that of the state."
        )
    if of == "a" and any(part.inertia for part in system.of(Element)):
        raise NotCoveredError("an acceleration is covered where the mass is all of the inertia.")
    return _assembled(own, of, row_of(system, at), _SLOWEST / duration, _FASTEST * math.pi / step)


def _assembled(own: Companion, of: Of, seen_by: FloatArray, slowest: float, fastest: float) -> StateSpace:
    points = seen_by.size
    stiffness, damping = own.stiffness, own.damping
    coils = [circuit for circuit in own.circuits if isinstance(circuit, ResonantCircuit)]
    modes = [
        (c.coupling**2 / c.capacitance, 1.0 / c.time, own.row(c))
        for c in own.circuits
        if isinstance(c, PiezoelectricCircuit)
    ]
    for element in own.elements:
        row = own.row(element)
        match element:
            case Springpot(order=0.0, coefficient=c):
                stiffness = stiffness + own.along(element, c)
            case Springpot(order=1.0, coefficient=c):
                damping = damping + own.along(element, c)
            case Maxwell(stiffness=k, coefficient=c):
                modes.append((k, k / c, row))
            case FractionalMaxwell(springpot=pot, spring=spring) if pot.order == 1.0:
                modes.append((spring.stiffness, spring.stiffness / pot.coefficient, row))
            case _:
                modes += [(weight, rate, row) for weight, rate in _memory(element, slowest, fastest)]
    if not np.linalg.eigvalsh(stiffness)[0] > 0.0:
        raise NotCoveredError("a fit of a record needs a positive stiffness of the linear springs.")
    modes = [(weight, rate, row) for weight, rate, row in modes if weight > 0.0]
    first = 2 * points + len(modes)
    for coil in coils:  # its voltage, which x drives, and its current, where the resistor is
        row = own.row(coil)
        modes += [(coil.coupling**2 / coil.capacitance, 0.0, row), (1.0, coil.rate, 0.0 * row)]
    extra = sum(1 if isinstance(n, ColoredNoise) else 2 for n in own.noises if not isinstance(n, WhiteNoise))
    size = 2 * points + len(modes) + extra
    x, v = slice(0, points), slice(points, 2 * points)
    # roots of stiffness and mass times x and v: the energy is half of their squares
    root, light = np.linalg.cholesky(stiffness), np.linalg.inv(np.linalg.cholesky(own.mass))
    rates, noise = np.zeros((size, size)), np.zeros((size, size))
    rates[x, v], rates[v, x], rates[v, v] = root.T @ light.T, -light @ root, -light @ damping @ light.T
    noise[v, v] = 2.0 * own.temperature * light @ damping @ light.T
    for n, (weight, rate, row) in enumerate(modes, start=2 * points):
        rates[n, n], rates[n, v], rates[v, n] = (
            -rate,
            math.sqrt(weight) * (light @ row),
            -math.sqrt(weight) * (light @ row),
        )
        noise[n, n] = 2.0 * own.temperature * rate
    for n, coil in enumerate(coils):
        at = first + 2 * n
        rates[at, at + 1], rates[at + 1, at] = -coil.frequency, coil.frequency
    at = 2 * points + len(modes)
    for part in own.noises:
        push = light @ own.push(part)
        match part:
            case WhiteNoise(intensity=q):
                noise[v, v] += q * np.outer(push, push)
            case ColoredNoise(variance=s2, correlation_time=tau):
                rates[at, at], rates[v, at], noise[at, at] = -1.0 / tau, push, 2.0 * s2 / tau
                at += 1
            case KanaiTajimiNoise(frequency=w, damping=z, intensity=q):  # w u and u'
                rates[at, at + 1], rates[at + 1, at], rates[at + 1, at + 1] = w, -w, -2.0 * z * w
                rates[v, at], rates[v, at + 1], noise[at + 1, at + 1] = w * push, 2.0 * z * w * push, q
                at += 2
    value, mean = np.zeros(size), 0.0
    if of == "x":
        value[x] = np.linalg.solve(root, seen_by)
        mean = float(seen_by @ np.linalg.solve(stiffness, own.force))
    elif of == "v":
        value[v] = light @ seen_by
    else:  # all forces of the parts
        value[: 2 * points + len(modes)] = (light @ seen_by) @ rates[v, : 2 * points + len(modes)]
    return StateSpace(rates, noise, value, mean)


def _memory(element: Springpot | FractionalMaxwell, slowest: float, fastest: float) -> list[tuple[float, float]]:
    """Weights and rates of modes whose sum is the modulus of an element."""

    def weight(rate: FloatArray) -> FloatArray:
        """Of the modes at these rates, per unit of their logarithm."""
        return np.asarray(np.imag(element.modulus(rate * np.exp(1j * np.pi))) / np.pi)

    count = max(math.ceil(math.log(fastest / slowest) / _SPACING), 2)
    rates = slowest * np.exp(_SPACING * np.arange(count + 1))
    weights = _SPACING * weight(rates)
    slow = _beyond(weight, rates[0], -_SPACING, (0.0, 1.0))
    fast = _beyond(weight, rates[-1], _SPACING, (-1.0, -2.0))
    ends = [(slow[0], slow[1] / slow[0])]
    if fast[1] > 0.0:
        rate = fast[0] / fast[1]
        ends.append((fast[0] * rate, rate))
    return [*ends, *zip(weights.tolist(), rates.tolist(), strict=True)]


def _beyond(
    weight: Callable[[FloatArray], FloatArray], rate: float, spacing: float, powers: tuple[float, float]
) -> tuple[float, float]:
    """Sums of weight times a power of the rate over the modes beyond an end: geometric series."""
    near = np.array([rate, rate * math.exp(spacing)])
    first, second = weight(near)
    ratios = [second / first * math.exp(power * spacing) for power in powers]
    one, two = (abs(spacing) * first * rate**p * r / (1.0 - r) for p, r in zip(powers, ratios, strict=True))
    return float(one), float(two)
