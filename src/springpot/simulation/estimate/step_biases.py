"""Step biases of a run without ``rtol`` that can be larger than its standard errors.

Compared with exact solutions at order 1, and with 1/16 of the step at other orders, energies, mean and quantiles of x
and v have no bias at the default step that 20,000 paths would show.  Impact rate and speeds on a lossy wall have one
(see :mod:`springpot.simulation.estimate.slow_impacts`), and so has the largest speed of a path.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier
from springpot.simulation.estimate.slow_impacts import (
    MARGIN,
    SlowImpacts,
    density_step_bias,
    impact_step_biases,
    quantile_step_bias,
    slow_impacts,
)
from springpot.simulation.plan.motion import Motion, StruckWalls, countable_restitution
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
        Numbers for ``impact_rate`` and the impact speeds; arrays for ``impact_speed_quantile``, ``v_largest_quantile``
        and ``impact_speed_density`` (over the bins of `Distribution.density`); of several masses those of each wall and
        each mass, as ``gap_impact_speed_quantile`` and ``box_v_largest_quantile``.
    """
    biases: dict[str, float | Floats] = dict(impact_biases(motion, step, values))
    biases |= {name: share * values[name] for name, share in motion.velocity_biases(step).items()}
    for name, (speeds, missed) in missed_in(motion, step, distributions).items():
        edges, density, _ = speeds.density()
        biases[f"{name}_quantile"] = quantile_step_bias(missed, speeds, probability)
        biases[f"{name}_density"] = density_step_bias(missed, edges, density)
    for seen in motion.seen:
        intensity = motion.intensity_of(seen) if f"{seen.names.get('v')}_largest" in extremes else 0.0
        if intensity > 0.0:
            bias = fastest_speed_step_bias(intensity, step)
            biases[f"{seen.names['v']}_largest_quantile"] = np.full(len(probability), bias)
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
    """Bounds on the step bias of impact rate and speeds: of the wall where they are largest.

    A law of restitution counts with its value at the speeds that the step resolves.
    """
    biases = _of_each_wall(motion, step, values)
    if motion.uncountable or not motion.intensity > 0.0 or "impact_rate" not in values:
        return biases
    for wall in motion.unit.of(Barrier):
        slow = countable_restitution(wall, motion.intensity, step)
        alone = StruckWalls(slow, motion.intensity, motion.press_on(wall))
        for name, bias in impact_step_biases(alone, step, values).items():
            biases[name] = max(bias, biases.get(name, 0.0))
    return biases


def _of_each_wall(motion: Motion, step: float, values: dict[str, float]) -> dict[str, float]:
    """Those of the results of single walls: by slow impacts that are missed, and by the scheme."""
    scheme = scheme_of(motion.scheme_for("default"))
    whole = scheme.impact_bias * (step * motion.scales.fastest_rate) ** 2
    biases = {}
    for name, wall in motion.struck_alone.items():
        if values.get(f"{name}_impact_rate") == 0.0:
            continue  # no impact was seen
        powers = {"impact_rate": 1.0, "impact_speed_mean": 1.0, "impact_speed_mean_square": 2.0}
        own = {quantity: values.get(f"{name}_{quantity}", math.nan) for quantity in powers}
        part = dict(motion.system.named())[name]
        slow = replace(wall, restitution=countable_restitution(part, wall.intensity, step))
        for quantity, bias in impact_step_biases(slow, step, own).items():
            biases[f"{name}_{quantity}"] = bias + powers[quantity] * whole * own[quantity]
        for quantity in ("force_mean", "power"):
            if (value := values.get(f"{name}_{quantity}", 0.0)) != 0.0:
                biases[f"{name}_{quantity}"] = 2.0 * whole * value
    return biases


def fastest_speed_step_bias(intensity: float, step: float) -> float:
    """Bound on the step bias of the largest speed of a path, in m/s, which may occur between two steps.

    The largest value of a Brownian motion observed at steps h is too low by -zeta(1/2) / sqrt(2 pi) = 0.5826 sqrt(q h)
    (Asmussen, Glynn and Pitman, "Discretization error in simulation of one-dimensional reflecting Brownian motion",
    Ann. Appl. Probab. 5, 1995).
    """
    return MARGIN * OVERSHOOT * math.sqrt(intensity * step)
