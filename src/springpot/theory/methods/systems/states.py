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
from springpot.problem.parts.registration import Element, Filter
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
                _write(rates, noise.filter_at(time), at, self.light @ self.companion.push(noise))
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
    >>> from springpot.problem.parts import Spring, Springpot, WhiteNoise
    >>> from springpot.problem.system import System
    >>> from springpot.theory.methods.systems.linear import companion_of
    >>> own = states_of(companion_of(System(Spring(4.0), Springpot(0.5, 1.0), WhiteNoise(1.0))), 5e-4, 1e3, "this")
    >>> own.rates.shape
    (32, 32)
    """
    own = companion
    points, stiffness, damping = len(own.mass), own.stiffness, own.damping
    coils: list[Any] = [circuit for circuit in own.circuits if circuit.rate_of_its_own]
    modes = []
    for element in (*(circuit for circuit in own.circuits if circuit not in coils), *own.elements):
        row = own.row(element)
        if element.remembers:
            own_modes = [element.relaxation] if element.relaxation[0] else _memory(element, slowest, fastest)
            modes += [(weight, rate, row) for weight, rate in own_modes]
        else:  # a springpot of order 0 or 1
            stiffness = stiffness + own.along(element, element.static_stiffness)
            damping = damping + own.along(element, element.dashpot)
    if not np.linalg.eigvalsh(stiffness)[0] > 0.0:
        raise NotCoveredError(f"{who} needs a positive stiffness of the linear springs.")
    modes = [(weight, rate, row) for weight, rate, row in modes if weight > 0.0]
    for coil in coils:  # its voltage, which x drives, and its current, where the resistor is
        row = own.row(coil)
        modes += [(coil.stiffness_at_once, 0.0, row), (1.0, coil.rate, 0.0 * row)]
    begin = 2 * points + len(modes)
    sizes = [noise.filter_order or 0 for noise in own.noises]
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
            whole = noise.filter_at(0.0)
            _write(rates, whole, at, push)
            vector[at + whole.driven] = math.sqrt(whole.intensity)
        else:
            vector[v] = (math.sqrt(noise.white_intensity) if noise.is_white else 1.0) * push
        inputs.append((noise, vector, at))
        at += states
    return States(own, rates, begin, tuple(inputs), root, light)


def _write(rates: Floats, noise: Filter, at: int, push: Floats) -> None:
    """The filter of a noise, from a state on, and how its output pushes."""
    v, own = slice(len(push), 2 * len(push)), slice(at, at + len(noise.output))
    rates[own, own], rates[v, own] = noise.rates, np.outer(push, noise.output)


def _memory(element: Element, slowest: float, fastest: float) -> list[tuple[float, float]]:
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
