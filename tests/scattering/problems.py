"""An oscillator whose results over devices are known exactly."""

from __future__ import annotations

import math

import numpy as np

import springpot as sp
from springpot.machine.arrays import Floats

NAMES = ("k", "c", "m", "q", "f")
MEAN, DEVIATION = 1.714088, 0.377864  # of E[x^2 | device], by quadrature, as all numbers here
ALONE = dict(zip(NAMES, (0.1017, 0.3112, 0.0, 0.1017, 0.4753), strict=True))
TOGETHER = dict(zip(NAMES, (0.1077, 0.3161, 0.0, 0.1061, 0.4802), strict=True))
QUANTILES = {0.05: 1.1534, 0.5: 1.6815, 0.95: 2.3858}


def device(mass: object = None) -> sp.System:
    """m x'' + c x' + k x = f + white noise of intensity q: E[x^2] = q / (2 c k) + (f / k)^2."""
    return sp.System(
        sp.Mass(sp.uncertain("m", bounds=(0.9, 1.1))), sp.Spring(sp.uncertain("k", 1.0, sd=0.05)),
        sp.Dashpot(sp.uncertain("c", 0.1, cov=math.sqrt(math.expm1(0.04)))),
        sp.WhiteNoise(sp.uncertain("q", bounds=(0.16, 0.24)), on="mass"),
        sp.Constant(sp.uncertain("f", 0.8, sd=0.16)),
    )  # fmt: skip


def mean_square(values: dict[str, Floats]) -> Floats:
    """E[x^2] of devices."""
    return np.asarray(values["q"] / (2.0 * values["c"] * values["k"]) + (values["f"] / values["k"]) ** 2)
