"""How fast the amplitude decays, by averaging over a cycle: all that the scales of a simulation take of the theory."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from springpot.machine.arguments import finite_number
from springpot.machine.arrays import Floats
from springpot.machine.without_scipy import zeta_beyond_one
from springpot.problem.dimensionless import Dimensionless

N = TypeVar("N", float, Floats)

_SERIES_TERMS = 30

_PLASTIC = 0.01  # restitution that leaves a ten thousandth of the energy: one below it counts as this


def harmonic_sum(alpha: float) -> float:
    """S(alpha) = sum_{m>=1} m^2 (2m)^(alpha-1) / (4m^2-1)^2, the sum in the paper's Eq. 20.

    Expanding 1 / (4m^2-1)^2 in 1/(4m^2) and summing over m first gives
    (2^(alpha-1) / 16) sum_k (k+1) 4^-k zeta(2k + 3 - alpha), which reaches rounding in 30 terms.

    Parameters
    ----------
    alpha : float
        Order in [0, 1].

    Raises
    ------
    TypeError, ValueError
        If alpha is not a number in [0, 1].

    Examples
    --------
    >>> round(harmonic_sum(1.0) * 64 / math.pi**2, 12)
    1.0
    """
    a = finite_number(alpha, "alpha", low=0.0, high=1.0)
    k = np.arange(_SERIES_TERMS)
    terms = (k + 1.0) * 0.25**k * zeta_beyond_one(2.0 * k + 2.0 - a)
    return math.exp2(a - 5.0) * math.fsum(terms.tolist())


def stiffness_sum(alpha: float) -> float:
    """sum_{m>=1} (2m)^alpha / (4m^2-1)^2, by the expansion of `harmonic_sum`.

    Examples
    --------
    >>> round(stiffness_sum(0.0) - (math.pi**2 / 16 - 0.5), 12)
    0.0
    """
    k = np.arange(_SERIES_TERMS)
    terms = (k + 1.0) * 0.25**k * zeta_beyond_one(2.0 * k + 3.0 - alpha)
    return math.exp2(alpha - 4.0) * math.fsum(terms.tolist())


def decay_rate(paper: Dimensionless) -> float:
    """beta of the corrected form, in 1/s: the amplitude decays like exp(-beta t)."""
    omega, springpot = paper.natural_frequency, paper.springpot
    return memory_decay(springpot.order, springpot.coefficient, omega, paper.barrier is not None) + impact_decay(
        paper, omega
    )


def mean_square_amplitude(paper: Dimensionless, beta: float, frequency: float) -> float:
    """mu = <x^2 + v^2 / w^2> in the stationary state; infinite where nothing dissipates energy."""
    return paper.excitation.intensity / (4.0 * beta) * 2.0 / frequency / frequency if beta > 0.0 else math.inf


def memory_decay(order: float, coefficient: float, frequency: N, wall: bool) -> N:
    """A springpot's part of beta on A cos, or on A \\|cos\\| behind a wall: half its power, divided by the energy."""
    loss: N = coefficient * frequency ** (order - 1.0) * math.sin(order * math.pi / 2.0)
    return 32.0 / math.pi**2 * harmonic_sum(order) * loss if wall else loss / 2.0


def stiffness_share(order: float, wall: bool) -> float:
    """The part of a springpot's stiffness in phase that acts on A cos (all of it), or on A \\|cos\\| behind a wall."""
    return 16.0 / math.pi**2 * stiffness_sum(order) if wall else 1.0


def impact_decay(paper: Dimensionless, frequency: float) -> float:
    """The wall's part of beta: one impact, and a factor r on the amplitude, in each half period."""
    if paper.barrier is None:
        return 0.0
    return -frequency / math.pi * math.log(max(paper.restitution, _PLASTIC)) + 0.0
