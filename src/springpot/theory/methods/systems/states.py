"""A linear system as a state with first-order equations: displacement, velocity, modes of the memory and of the noise.

The memory of a springpot is a sum of modes: C p^alpha = (C sin(pi alpha) / pi) int p / (p + s) s^(alpha - 1) ds.  With
s = e^u the trapezoidal rule converges like exp(-pi^2 / h), h its spacing, and its rates do not depend on the system's
numbers; the modes beyond both ends are geometric series, each replaced by one mode with their first two moments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    CloughPenzienNoise,
    ColoredNoise,
    FractionalMaxwell,
    KanaiTajimiNoise,
    Maxwell,
    PiezoelectricCircuit,
    PoissonImpulses,
    ResonantCircuit,
    SpectralExcitation,
    Springpot,
    WhiteNoise,
)
from springpot.theory.methods.systems.linear import Companion

_SPACING = 0.55  # of the logarithms of the rates: exp(-pi^2 / h) is 2e-8


@dataclass(frozen=True, eq=False)
class States:
    """dX = rates X dt + noise.

    The states of displacements and velocities are such that the energy is half of the sum of their squares.

    Attributes
    ----------
    companion : Companion
    rates : ndarray, shape (states, states)
        Of a filter that changes at time 0.
    own : int
        States of the system; after them are those of the filters of noise.
    inputs : tuple of (noise, ndarray, int)
        What each noise changes per white noise of intensity 1 that drives it, of a given spectral density per unit of
        the noise; and where the states of its filter begin.
    root, light : ndarray, shape (coordinates, coordinates)
        A root of the stiffness, and the inverse of one of the mass.
    """

    companion: Companion
    rates: Floats
    own: int
    inputs: tuple[tuple[Any, Floats, int], ...]
    root: Floats
    light: Floats

    def x(self, row: Floats) -> Floats:
        """The state's row of a displacement."""
        found = np.zeros(len(self.rates))
        found[: len(row)] = np.linalg.solve(self.root, row)
        return found

    def v(self, row: Floats) -> Floats:
        """The state's row of a velocity."""
        found = np.zeros(len(self.rates))
        found[len(row) : 2 * len(row)] = self.light @ row
        return found

    def rates_at(self, time: float) -> Floats:
        """With filters that change, at a time in s."""
        rates = self.rates.copy()
        for noise, _, at in self.inputs:
            if getattr(noise, "frequency_rate", 0.0):
                _filter(rates, noise, at, self.light @ self.companion.push(noise), time)
        return rates


def states_of(companion: Companion, slowest: float, fastest: float, who: str) -> States:
    """The state of a linear system, with rates of its memory in a range.

    Parameters
    ----------
    companion : Companion
    slowest, fastest : float
        In rad/s.
    who : str
        What needs it, in words.

    Raises
    ------
    NotCoveredError
        If the linear springs leave a motion without stiffness.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> from springpot.problem.system import System
    >>> from springpot.theory.methods.systems.linear import companion_of
    >>> own = states_of(companion_of(System(Spring(4.0), Springpot(0.5, 1.0), WhiteNoise(1.0))), 5e-4, 1e3, "this")
    >>> own.rates.shape
    (32, 32)
    """
    own = companion
    points, stiffness, damping = len(own.mass), own.stiffness, own.damping
    coils = [circuit for circuit in own.circuits if isinstance(circuit, ResonantCircuit)]
    simple = [circuit for circuit in own.circuits if isinstance(circuit, PiezoelectricCircuit)]
    modes = [(c.coupling**2 / c.capacitance, 1.0 / c.time, own.row(c)) for c in simple]
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
        raise NotCoveredError(f"{who} needs a positive stiffness of the linear springs.")
    modes = [(weight, rate, row) for weight, rate, row in modes if weight > 0.0]
    for coil in coils:  # its voltage, which x drives, and its current, where the resistor is
        row = own.row(coil)
        modes += [(coil.coupling**2 / coil.capacitance, 0.0, row), (1.0, coil.rate, 0.0 * row)]
    begin = 2 * points + len(modes)
    sizes = [_states_of_filter(noise) for noise in own.noises]
    x, v, size = slice(0, points), slice(points, 2 * points), begin + sum(sizes)
    root: Floats = np.linalg.cholesky(stiffness).astype(float)
    light: Floats = np.linalg.inv(np.linalg.cholesky(own.mass)).astype(float)
    rates = np.zeros((size, size))
    rates[x, v], rates[v, x], rates[v, v] = root.T @ light.T, -light @ root, -light @ damping @ light.T
    for n, (weight, rate, row) in enumerate(modes, start=2 * points):
        coupled = math.sqrt(weight) * (light @ row)
        rates[n, n], rates[n, v], rates[v, n] = -rate, coupled, -coupled
    for at, coil in zip(range(begin - 2 * len(coils), begin, 2), coils, strict=True):
        rates[at, at + 1], rates[at + 1, at] = -coil.frequency, coil.frequency
    inputs, at = [], begin
    for noise, states in zip(own.noises, sizes, strict=True):
        push, vector = light @ own.push(noise), np.zeros(size)
        if states:
            vector[at + min(states - 1, 1)] = math.sqrt(_filter(rates, noise, at, push, 0.0))
        else:
            vector[v] = math.sqrt(getattr(noise, "intensity", 1.0)) * push
        inputs.append((noise, vector, at))
        at += states
    return States(own, rates, begin, tuple(inputs), root, light)


def _states_of_filter(noise: Any) -> int:
    match noise:
        case WhiteNoise() | PoissonImpulses() | SpectralExcitation():
            return 0
        case ColoredNoise():
            return 1
        case KanaiTajimiNoise():
            return 2
    return 4


def _filter(rates: Floats, noise: Any, at: int, push: Floats, time: float) -> float:
    """Write a filter and its output, and return the intensity of the white noise that drives it."""
    v = slice(len(push), 2 * len(push))
    if isinstance(noise, ColoredNoise):
        rates[at, at], rates[v, at] = -1.0 / noise.correlation_time, push
        return 2.0 * noise.variance / noise.correlation_time
    first, w, twice = noise.frequency, noise.frequency_at(time, "the noise"), 2.0 * noise.damping
    seen = np.zeros(len(rates))
    seen[at : at + 2] = w * w / first, twice * w  # of w u and u' with the first w
    rates[at, at + 1], rates[at + 1] = first, -seen
    if isinstance(noise, CloughPenzienNoise):
        f = noise.base_frequency
        rates[at + 2, at + 3] = f
        seen[at + 2 : at + 4] = -f, -2.0 * noise.base_damping * f
        rates[at + 3] = seen
    rates[v] += np.outer(push, seen) - rates[v] * (seen != 0.0)
    return float(noise.intensity)


def _memory(element: Springpot | FractionalMaxwell, slowest: float, fastest: float) -> list[tuple[float, float]]:
    """Weights and rates of modes whose sum is the modulus of an element."""

    def weight(rate: Floats) -> Floats:
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
    weight: Callable[[Floats], Floats], rate: float, spacing: float, powers: tuple[float, float]
) -> tuple[float, float]:
    """Sums of weight times a power of the rate over the modes beyond an end: geometric series."""
    near = np.array([rate, rate * math.exp(spacing)])
    first, second = weight(near)
    ratios = [second / first * math.exp(power * spacing) for power in powers]
    one, two = (abs(spacing) * first * rate**p * r / (1.0 - r) for p, r in zip(powers, ratios, strict=True))
    return float(one), float(two)
