"""What a start still does to the means of a run, from the run itself.

A springpot whose elongation started at m and has the mean x pulls back with C (x - m) t^-alpha / Gamma(1 - alpha).  In
equilibrium a small force moves a mean by the variance of the elongation over its temperature, m <v^2>: so far is x from
its stationary value.  Walls and nonlinear springs are in the variance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from springpot.simulation.plan.plan import Plan


@dataclass(frozen=True)
class Left:
    """What is left of a start in a mean.

    Attributes
    ----------
    name : str
        How the names of its results begin.
    off, error : float
        How far it is from its stationary value, about, and the standard error of that; over its root mean square.
    order : float
        Of the springpot.
    """

    name: str
    off: float
    error: float
    order: float


def left_of_start(plan: Plan, values: Mapping[str, float], errors: Mapping[str, float]) -> Iterator[Left]:
    """What is left in the mean of each elongation with a springpot, where that need not be 0."""
    motion, (begin, end) = plan.motion, plan.settings.window
    if not motion.searched:
        return
    start = motion.system.coordinates.places_of(plan.settings.initial_position)
    speeds = np.array([values[f"{name.removesuffix('x_mean')}v_mean_square"] for name in motion.mean_names])
    for kept in motion.kept_means:
        mean, square = (values[f"{kept.name}_{of}"] for of in ("mean", "mean_square"))
        speed = float(kept.row**2 @ speeds)
        if not (square > 0.0 and speed > 0.0 and f"{kept.name}_mean" not in motion.zeros):
            continue
        later = 1.0 - kept.order
        fading = (end**later - begin**later) / ((end - begin) * later * math.gamma(later))
        size = math.sqrt(motion.square_about_origin(values, f"{kept.name}_mean"))
        moved = kept.coefficient * fading * (square - mean * mean) / speed / size
        off, error = abs(mean - float(kept.row @ start)), errors[f"{kept.name}_mean"]
        yield Left(kept.name, moved * off, moved * error, kept.order)
