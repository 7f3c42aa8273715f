"""The state of a linear system (`springpot.theory.methods.systems.states`) at the samples of a record."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from springpot.fitting.motion_data import Of
from springpot.fitting.spectral_density import row_of
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    CloughPenzienNoise,
    Harmonic,
    ParametricNoise,
    PoissonImpulses,
    RecordedExcitation,
    SpectralExcitation,
)
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import companion_of
from springpot.theory.methods.systems.states import states_of

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

    transition: Floats
    stationary: Floats
    row: Floats
    mean: float

    def correlation(self, samples: int) -> Floats:
        """Covariance of the value with that of 0, 1, ... samples before."""
        at = self.stationary @ self.row
        found = np.empty(samples)
        for n in range(samples):
            found[n] = self.row @ at
            at = self.transition @ at
        return found


def state_space(system: System, of: Of, step: float, duration: float, at: str | None = None) -> Sampled:
    """The state of a linear system at samples that have this step and duration.

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
    Sampled

    Raises
    ------
    NotCoveredError
        If a part is not linear, or the excitation is not a Gaussian stationary noise.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, Springpot, WhiteNoise
    >>> own = state_space(System(Spring(4.0), Springpot(0.5, 1.0), WhiteNoise(1.0)), "x", 0.1, 100.0)
    >>> own.transition.shape
    (32, 32)
    """
    for name, part in system.named():
        if isinstance(part, Harmonic | ParametricNoise | RecordedExcitation | PoissonImpulses):
            raise NotCoveredError(f"{name} is no stationary Gaussian noise: a fit of a record does not cover it.")
        if isinstance(part, SpectralExcitation | CloughPenzienNoise):
            raise NotCoveredError(f"{name} has a density without a short state: a fit of a record does not cover it.")
    own = companion_of(system)
    if not own.noises and not own.temperature:
        raise NotCoveredError("a system without noise does not move: add a WhiteNoise or another noise.")
    if of == "a" and (not all(part.of_ground for part in system.noises.values()) or own.temperature > 0.0):
        raise NotCoveredError(
            "an acceleration is covered for noise of the ground only: with a force on the mass it has no "
            "finite variance, or is not that of the state."
        )
    if of == "a" and any(part.inertia for part in system.elements.values()):
        raise NotCoveredError("an acceleration is covered where the mass is all of the inertia.")
    from scipy import linalg

    states = states_of(own, _SLOWEST / duration, _FASTEST * math.pi / step, "a fit of a record")
    rates, seen_by, mean = states.rates, row_of(system, at), 0.0
    noise, inner = np.zeros_like(rates), slice(0, states.own)  # its intensity in dX = rates X dt + noise
    noise[inner, inner] = -own.temperature * (rates + rates.T)[inner, inner]  # what dampers take, with both ends
    for _, vector, _ in states.inputs:
        noise += np.outer(vector, vector)
    row = states.x(seen_by) if of == "x" else states.v(seen_by)
    if of == "x":
        mean = float(seen_by @ np.linalg.solve(states.root @ states.root.T, own.force))
    if of == "a":  # all forces of the parts
        row = row @ rates * (np.arange(len(rates)) < states.own)
    stationary = np.array(linalg.solve_continuous_lyapunov(rates, -noise)).astype(np.float64)
    return Sampled(np.asarray(linalg.expm(rates * step)), 0.5 * (stationary + stationary.T), row, mean)
