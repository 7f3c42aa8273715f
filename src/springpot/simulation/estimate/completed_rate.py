"""The impact rate on a lossy wall, with an estimate of the slow impacts that a step cannot resolve.

On a lossy wall the share of the impacts slower than u is proportional to u^m, with m of
`springpot.theory.mckean.slow_impact_power`.  A step h resolves only impacts faster than about sqrt(q h), so the plain
count is too low by a share proportional to h^(m / 2), which decreases slowly: 8 % at r = 0.41 and a step of
0.05 / Omega.

Instead the number N(u) of impacts faster than u is counted at two speeds; by the law,
N(0) = N(u) + (N(u) - N(2 u)) / (2^m - 1).  At u = k sqrt(q h), with k of `StruckWalls.resolved_speed`, the errors
that the step causes in N(u) and N(2 u) cancel.  k was fitted to the Fokker-Planck
equation at order 1 (b = 0, C = 0.2, h = 0.05, 100,000 paths): 0.59, 0.60, 0.61, 0.65 and 0.69 at r = 0.25, 0.3, 0.35,
0.41 and 0.5.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from springpot.machine.arrays import Floats
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.watch.counted_impacts import faster_than
from springpot.theory.mckean import slow_impact_power


def counts_of_fast_impacts(simulation: Simulation) -> tuple[Observer, ...]:
    """For each of the walls that `Motion.completed` has: the impacts of each path that are not slower than the resolved
    speed, and those that are not slower than twice that speed."""
    step = simulation.settings.step
    return tuple(
        faster_than(times * walls.resolved_speed(step), before.removesuffix("_"))
        for before, walls in simulation.motion.completed.items()
        for times in (1.0, 2.0)
    )


def with_completed_rate(simulation: Simulation, samples: dict[str, Floats], counted: Floats) -> dict[str, Floats]:
    """Samples of each estimate with the completed impact rates; the counted rate is ``plain_rate``.

    Parameters
    ----------
    simulation : Simulation
    samples : dict
    counted : ndarray, shape (paths, 2 times the walls that are completed)
        Counts of the observers of `counts_of_fast_impacts`.
    """
    result, completed = samples, simulation.motion.completed
    for n, before in enumerate(completed):
        result = result | _completed(simulation, samples, before, counted[:, 2 * n], counted[:, 2 * n + 1])
    walls = list(simulation.motion.touched)
    for wall in walls if len(walls) == 1 and "" in completed else ():  # its numbers are those of all impacts
        result |= {f"{wall}_{name}": result[name] for name in ("impact_rate", "impact_speed_mean")}
    return result


def _completed(
    simulation: Simulation, samples: Mapping[str, Floats], before: str, fast: Floats, faster: Floats
) -> dict[str, Floats]:
    """Rate and speeds of some walls with the impacts that the step cannot resolve, and the counted rate."""
    low, high = simulation.settings.window_steps
    restitution = simulation.motion.completed[before].restitution
    slower = (fast - faster) / (2.0 ** slow_impact_power(restitution) - 1.0)
    completed = np.asarray((fast + slower) / ((high - low) * simulation.settings.step))
    rates = samples[f"{before}impact_rate"]
    result = {f"{before}impact_rate": completed, f"{before}plain_rate": rates}
    rate = float(completed.mean())
    if not rate > 0.0:
        return result
    # the added impacts are so slow that rate times speed does not change
    for name in (f"{before}impact_speed_mean", f"{before}impact_speed_mean_square"):
        plain = float(samples[name].mean())
        flux = plain * rates + float(rates.mean()) * (samples[name] - plain)  # its mean is rate times speed
        speed = float(flux.mean()) / rate
        result[name] = speed + (flux - speed * completed) / rate
    return result
