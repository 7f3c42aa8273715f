"""Correlation and spectrum of the folded displacement \\|y\\|, from the closed loop of the memory closure.

With rho the correlation coefficient of the Gaussian y, the covariance of \\|y\\| over its variance is
f(rho) = (sqrt(1 - rho^2) + rho arcsin(rho) - 1) / (pi/2 - 1).
"""

from __future__ import annotations

import math

import numpy as np

from springpot.machine.arrays import Floats
from springpot.theory.methods.memory_closure.memory import Loop
from springpot.theory.methods.memory_closure.quadrature import oscillating_weights
from springpot.theory.numerics.panels import panel_rule

_HARMONICS = range(2, 26, 2)  # of f(rho) over one period, kept at the far lags; the next is 1e-5 of the first
_PHASES = 64
_ORDER = 8


def unfolded_correlation(loop: Loop, lag: Floats) -> Floats:
    """rho at any lags >= 0 (one row), dimensionless."""
    grid = loop.grid
    drop = 2.0 * (grid.weights - oscillating_weights(grid.edges, lag, grid.order).real) @ loop.spectrum / loop.y2
    return np.clip(1.0 - drop, -1.0, 1.0)


def folded_correlation(rho: Floats) -> Floats:
    """f(rho), 1 at rho = +-1 and 0 at rho = 0.

    Examples
    --------
    >>> folded_correlation(np.array([-1.0, 0.0, 1.0])).round(12).tolist()
    [1.0, 0.0, 1.0]
    """
    return np.asarray((np.sqrt(1.0 - rho**2) + rho * np.arcsin(rho) - 1.0) / (math.pi / 2.0 - 1.0))


def folded_spectrum(loop: Loop, frequency: Floats) -> Floats:
    """Two-sided spectrum whose integral over the real line is 1, at frequencies >= 0 (one row), dimensionless."""
    grid = loop.grid
    near_edges = np.concatenate([[0.0], grid.near_edges])
    lag, _ = panel_rule(near_edges, _ORDER)
    near = folded_correlation(unfolded_correlation(loop, lag)) * (1.0 - grid.far_share(lag))
    total = (oscillating_weights(near_edges, frequency, _ORDER) @ near).real
    # Far on, f is a cosine series in the phase of the envelope, with slow coefficients.
    turn = loop.envelope * np.exp(-1j * grid.resonance * grid.far_lag)
    size = np.minimum(np.abs(turn), 1.0)
    phase = (np.arange(_PHASES) + 0.5) / _PHASES * math.pi
    values = folded_correlation(np.multiply.outer(size, np.cos(phase))) * grid.far_share(grid.far_lag)[:, None]
    total = total + (oscillating_weights(grid.far_edges, frequency, grid.order) @ values.mean(axis=1)).real
    direction = turn / np.maximum(size, 1e-300)
    for n in _HARMONICS:
        slow = values @ np.cos(n * phase) / _PHASES * direction**n
        total = total + (oscillating_weights(grid.far_edges, n * grid.resonance - frequency, grid.order) @ slow).real
    return np.asarray(total / math.pi)
