"""Step biases of a run without ``rtol`` that can be larger than its standard errors.

Compared with exact solutions at order 1, and with 1/16 of the step at other orders, energies, mean and quantiles of x
and v have no bias at the default step that 20,000 paths would show.  Impact rate and speeds on a lossy wall have one
(see :mod:`springpot.simulation.estimate.slow_impacts`), and so has the largest speed of a path.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from springpot.problem.oscillator import Oscillator
from springpot.simulation.estimate.slow_impacts import (
    MARGIN,
    density_step_bias,
    impact_step_biases,
    quantile_step_bias,
    slow_impacts,
)
from springpot.simulation.watch.distributions import Distribution

__all__ = ["fastest_speed_step_bias", "step_biases"]

Floats = npt.NDArray[np.float64]

NORMAL = 1.959964  # half-width of a 95 % interval, in standard errors
OVERSHOOT = 0.5826  # -zeta(1/2) / sqrt(2 pi)


def step_biases(
    oscillator: Oscillator,
    step: float,
    values: dict[str, float],
    distributions: Mapping[str, Distribution],
    extremes: Mapping[str, Floats],
    probability: Sequence[float],
) -> dict[str, float | Floats]:
    """Bounds on the step bias of the results that have a relevant one, by name.

    Parameters
    ----------
    step : float
        In s.
    values : dict
        Estimates by name.
    distributions, extremes : dict
        As in `springpot.simulation.Run`; empty if not requested.
    probability : sequence of float
        Of the quantiles.

    Returns
    -------
    dict
        Numbers for ``impact_rate`` and the impact speeds; arrays for ``impact_speed_quantile``, ``v_largest_quantile``
        and ``impact_speed_density`` (over the bins of `Distribution.density`).
    """
    biases: dict[str, float | Floats] = dict(impact_step_biases(oscillator, step, values))
    if (speeds := distributions.get("impact_speed")) is not None:
        missed = slow_impacts(oscillator, step, speeds)
        if missed is not None:
            edges, density, _ = speeds.density()
            biases["impact_speed_quantile"] = quantile_step_bias(missed, speeds, probability)
            biases["impact_speed_density"] = density_step_bias(missed, edges, density)
    if "v_largest" in extremes and oscillator.excitation.intensity > 0.0:
        biases["v_largest_quantile"] = np.full(len(probability), fastest_speed_step_bias(oscillator, step))
    return biases


def fastest_speed_step_bias(oscillator: Oscillator, step: float) -> float:
    """Bound on the step bias of the largest speed of a path, in m/s, which may occur between two steps.

    The largest value of a Brownian motion observed at steps h is too low by -zeta(1/2) / sqrt(2 pi) = 0.5826 sqrt(q h)
    (Asmussen, Glynn and Pitman, "Discretization error in simulation of one-dimensional reflecting Brownian motion",
    Ann. Appl. Probab. 5, 1995).
    """
    return MARGIN * OVERSHOOT * math.sqrt(oscillator.excitation.intensity * step)
