"""Step biases of a run without ``rtol`` that can be larger than its standard errors.

Compared with exact solutions at order 1, and with 1/16 of the step at other orders, energies, mean and quantiles of x
and v have no bias at the default step that 20,000 paths would show, but for mean square velocities where dampers take
much of a kick within its step.  Impact rate and speeds on a lossy wall have one (see
:mod:`springpot.simulation.estimate.slow_impacts`), and so have its force and power and the largest speed of a path.

These are bounds of what the step leaves.  What chance leaves, the standard error, is the scatter of the values of the
paths, over the root of their number (:mod:`springpot.simulation.paths.statistics`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from springpot.machine.arrays import Floats
from springpot.simulation.estimate.slow_impacts import (
    MARGIN,
    SlowImpacts,
    density_step_bias,
    impact_step_biases,
    quantile_step_bias,
    slow_impacts,
)
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.schemes import scheme_of

if TYPE_CHECKING:
    from springpot.simulation.watch.distributions import Distribution

OVERSHOOT = 0.5826  # -zeta(1/2) / sqrt(2 pi)


def step_biases(
    motion: Motion,
    step: float,
    values: dict[str, float],
    distributions: Mapping[str, Distribution],
    extremes: Mapping[str, Floats],
    probability: Sequence[float],
) -> dict[str, float | Floats]:
    """Bounds on the step bias of the results that have a relevant one, by name.

    Parameters
    ----------
    motion : Motion
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
        Numbers for ``impact_rate``, the impact speeds, the mean force and the power of each wall, and for mean squares
        of velocities where dampers take much of a kick; arrays for ``impact_speed_quantile``, ``v_largest_quantile``
        and ``impact_speed_density`` (over the bins of `Distribution.density`); of several masses those of each wall and
        each mass, as ``gap_impact_speed_quantile`` and ``box_v_largest_quantile``.
    """
    biases: dict[str, float | Floats] = dict(impact_biases(motion, step, values))
    biases |= {name: share * values[name] for name, share in motion.velocity_biases(step).items()}
    for name, (speeds, missed) in missed_in(motion, step, distributions).items():
        edges, density, _ = speeds.density()
        biases[f"{name}_quantile"] = quantile_step_bias(missed, speeds, probability)
        biases[f"{name}_density"] = density_step_bias(missed, edges, density)
    for signal in motion.signals:
        intensity = motion.intensity_of(signal) if f"{signal.names.get('v')}_largest" in extremes else 0.0
        if intensity > 0.0:
            bias = fastest_speed_step_bias(intensity, step)
            biases[f"{signal.names['v']}_largest_quantile"] = np.full(len(probability), bias)
    return biases


def missed_in(
    motion: Motion, step: float, distributions: Mapping[str, Distribution]
) -> dict[str, tuple[Distribution, SlowImpacts]]:
    """Each distribution of an impact speed in which slow impacts are missing, by its name, and these impacts."""
    found = {}
    for name, walls in motion.struck_in(step).items():
        speeds = distributions.get(name)
        if speeds is not None and (missed := slow_impacts(walls, step, speeds)) is not None:
            found[name] = speeds, missed
    return found


def impact_biases(motion: Motion, step: float, values: dict[str, float]) -> dict[str, float]:
    """Bounds on the step bias of impact rate and speeds, of the wall where they are largest, and of forces and powers.

    A law of restitution counts with its value at the speeds that the step resolves.
    """
    scheme = scheme_of(motion.scheme_for("default"))
    whole = scheme.impact_bias * (step * motion.scales.fastest_rate) ** 2
    powers = {"impact_rate": 1.0, "impact_speed_mean": 1.0, "impact_speed_mean_square": 2.0}
    biases: dict[str, float] = {}
    for begin, names in motion.whose_impacts.items():
        if values.get(f"{begin}impact_rate", math.nan) == 0.0:
            continue  # no impact was seen
        uncounted = begin in motion.uncounted
        own = {quantity: math.nan if uncounted else values.get(f"{begin}{quantity}", math.nan) for quantity in powers}
        for name in (name for name in names if name in motion.struck_alone):
            if not (whole or motion.struck_alone[name].intensity):
                continue
            for quantity, bias in impact_step_biases(motion.struck_in_steps(name, step), step, own).items():
                bias += powers[quantity] * whole * own[quantity]
                biases[f"{begin}{quantity}"] = max(bias, biases.get(f"{begin}{quantity}", 0.0))
            for quantity in ("force_mean", "power"):
                if whole * (value := values.get(f"{name}_{quantity}", 0.0)) != 0.0:
                    biases[f"{name}_{quantity}"] = 2.0 * whole * value
    return biases


def fastest_speed_step_bias(intensity: float, step: float) -> float:
    """Bound on the step bias of the largest speed of a path, in m/s, which may occur between two steps.

    The largest value of a Brownian motion observed at steps h is too low by -zeta(1/2) / sqrt(2 pi) = 0.5826 sqrt(q h)
    (Asmussen, Glynn and Pitman, "Discretization error in simulation of one-dimensional reflecting Brownian motion",
    Ann. Appl. Probab. 5, 1995).
    """
    return MARGIN * OVERSHOOT * math.sqrt(intensity * step)
