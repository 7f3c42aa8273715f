"""The impact rate behind a lossy wall, with the slow impacts that a step cannot resolve put back by their known law.

Behind a lossy wall the impacts slower than u are a share of all that goes like u^m, with the m of
`springpot.theory.mckean.slow_impact_power`.  A step h resolves impacts faster than about sqrt(q h) only, so a plain
count is too low by a share that goes like h^(m / 2), which is slow: 8 % at r = 0.41 and a step of 0.05 / Omega.

What is used instead is the number N(u) of impacts faster than u, at two speeds: the law says that N(0) is
N(u) + (N(u) - N(2 u)) / (2^m - 1).  At u = k sqrt(q h) with the k of `resolved_speed` what the step still takes from
N(u) and what it takes from N(2 u) cancel.  k was measured against the Fokker-Planck equation at order 1 (b = 0,
C = 0.2, h = 0.05, 100,000 paths): 0.59, 0.60, 0.61, 0.65 and 0.69 at r = 0.25, 0.3, 0.35, 0.41 and 0.5.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import cfunc

from springpot.oscillator import Oscillator
from springpot.simulation.lanes import FAST, LANES
from springpot.simulation.observers import HEADER, ON_IMPACTS, Observer
from springpot.simulation.simulation import Simulation
from springpot.simulation.slow_impacts import impacts_are_countable
from springpot.theory.mckean import slow_impact_power

__all__ = ["are_crowded", "completed_rate", "counts_of_fast_impacts", "resolved_speed", "with_completed_rate"]

Floats = npt.NDArray[np.float64]

_FIRST = len(HEADER)


def are_crowded(oscillator: Oscillator) -> bool:
    """Is the wall lossy, and is the impact rate finite all the same?"""
    return oscillator.restitution < 1.0 and impacts_are_countable(oscillator)


def resolved_speed(restitution: float) -> float:
    """The lower of the two speeds, in units of sqrt(q h)."""
    return 0.47 + 0.43 * restitution


def counts_of_fast_impacts(simulation: Simulation) -> Observer:
    """Counts, for each path, the impacts faster than the resolved speed and those faster than twice that speed."""
    oscillator, step = simulation.oscillator, simulation.settings.step
    speed = resolved_speed(oscillator.restitution) * math.sqrt(oscillator.excitation.intensity * step)
    initial = np.zeros(3 * LANES)
    initial[:LANES] = speed / simulation.parts.units.speed
    return Observer(None, _counter(), initial, per_path=True)


@cache
def _counter() -> Any:
    @cfunc(ON_IMPACTS, **FAST)
    def count_fast(count, speed, lane, array):  # type: ignore[no-untyped-def]
        limit = array[_FIRST + lane]
        if speed > limit:
            array[_FIRST + LANES + lane] += count
        if speed > 2.0 * limit:
            array[_FIRST + 2 * LANES + lane] += count

    return count_fast


def completed_rate(simulation: Simulation, counted: Floats) -> Floats:
    """Impacts per second of each path, with those that the step cannot resolve.

    Parameters
    ----------
    simulation : Simulation
    counted : ndarray, shape (paths, 3)
        What the observer of `counts_of_fast_impacts` left.

    Returns
    -------
    ndarray, shape (paths,)
    """
    low, high = simulation.settings.window_steps
    fast, faster = counted[:, 1], counted[:, 2]
    slower = (fast - faster) / (2.0 ** slow_impact_power(simulation.oscillator.restitution) - 1.0)
    return np.asarray((fast + slower) / ((high - low) * simulation.settings.step))


def with_completed_rate(simulation: Simulation, samples: dict[str, Floats], counted: Floats) -> dict[str, Floats]:
    """Samples of each estimate with the completed impact rate, and ``plain_rate`` for the one that was counted."""
    completed, rates = completed_rate(simulation, counted), samples["impact_rate"]
    found = samples | {"impact_rate": completed, "plain_rate": rates}
    rate = float(completed.mean())
    if not rate > 0.0:
        return found
    # what the impacts put back hand over is next to nothing
    for name in ("impact_speed_mean", "impact_speed_mean_square"):
        plain = float(samples[name].mean())
        flux = plain * rates + float(rates.mean()) * (samples[name] - plain)  # its mean is rate times speed
        speed = float(flux.mean()) / rate
        found[name] = speed + (flux - speed * completed) / rate
    return found
