"""Results over devices that are known exactly: of an oscillator, of a sum and of a product."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

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


RARE = (
    {"limit": 5.4879, "start": "rest", "probability": 1.070e-4, "times": 4.0, "by_mean": (-1.163, 0.896, -0.452),
     "by_scatter": (1.220, 0.742, 0.198), "quantile": 4.61e-4, "much": 1e-3, "above": 0.0143},
    {"limit": 6.5515, "start": "rest", "probability": 1.064e-6, "times": 17.1, "by_mean": (-1.603, 1.196, -0.605),
     "by_scatter": (2.406, 1.356, 0.359), "quantile": 4.22e-6, "much": 1e-5, "above": 0.0203},
    {"limit": 5.4879, "start": "stationary", "probability": 1.659e-4, "times": 4.1,
     "by_mean": (-1.205, 0.877, -0.442), "by_scatter": (1.314, 0.708, 0.189), "quantile": 7.20e-4, "much": 1e-3,
     "above": 0.0310},
    {"limit": 6.5515, "start": "stationary", "probability": 1.81e-6, "times": 18.1,
     "by_mean": (-1.649, 1.174, -0.594), "by_scatter": (2.551, 1.304, 0.345), "quantile": 7.09e-6, "much": 1e-5,
     "above": 0.0361},
)  # fmt: skip
"""Of `rare_device` in 100 s, step 0.3: a table of `springpot.exceedance` at 7 dampings and 10 levels, known to 2 %, as
a polynomial in logarithms, integrated over the three scores by Gauss and Hermite; shares of devices from two million
draws.
"""


def rare_device(limit: float) -> tuple[sp.System, float]:
    """x'' + 2 z x' + x = white noise, with z = .05 exp(.12 z1), intensity .2 exp(.08 z2); its limit (1 + .02 z3)."""
    c, q = (math.sqrt(math.expm1(s**2)) for s in (0.12, 0.08))
    system = sp.System(
        sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", 0.1 * math.exp(0.5 * 0.12**2), cov=c)),
        sp.WhiteNoise(sp.uncertain("q", 0.2 * math.exp(0.5 * 0.08**2), cov=q)),
    )  # fmt: skip
    return system, sp.uncertain("limit", limit, sd=0.02 * limit)


@dataclass(frozen=True)
class Exact:
    """What is known of a result over devices: mean, deviation, quantiles, and Sobol indices by input."""

    system: sp.System
    result: Callable[[dict[str, Floats]], Floats]
    mean: float
    deviation: float
    quantiles: dict[float, float]
    alone: dict[str, float]
    together: dict[str, float]


def _uniform() -> sp.System:
    """A device of five numbers from 0 to 1."""
    a, b, c, d, e = (sp.uncertain(name, bounds=(0.0, 1.0)) for name in "abcde")
    return sp.System(sp.PolynomialSpring((a, 0.0, b, 0.0, c)), sp.Dashpot(d), sp.Constant(e))


_SUM = dict(zip("abcde", (1.0, 0.7, 0.5, 0.3, 0.0), strict=True))
_PRODUCT = dict(zip("abcde", (0.5, 0.4, 0.3, 0.2, 0.0), strict=True))


def _sum(values: dict[str, Floats]) -> Floats:
    return np.asarray(5.0 + sum(w * math.sqrt(12.0) * (values[name] - 0.5) for name, w in _SUM.items()))


def _product(values: dict[str, Floats]) -> Floats:
    factors = [1.0 + w * math.sqrt(12.0) * (values[name] - 0.5) for name, w in _PRODUCT.items()]
    return np.asarray(np.prod(factors, axis=0))


_VARIANCE = math.prod(1.0 + w * w for w in _PRODUCT.values()) - 1.0
OSCILLATOR = Exact(device(), mean_square, MEAN, DEVIATION, QUANTILES, ALONE, TOGETHER)
SUM = Exact(
    _uniform(), _sum, 5.0, math.sqrt(1.83), {0.05: 2.7695, 0.5: 5.0, 0.95: 7.2305},
    {name: w * w / 1.83 for name, w in _SUM.items()}, {name: w * w / 1.83 for name, w in _SUM.items()},
)  # fmt: skip
PRODUCT = Exact(
    _uniform(), _product, 1.0, math.sqrt(_VARIANCE), {0.05: 0.14505, 0.5: 0.77579, 0.95: 2.63192},
    {name: w * w / _VARIANCE for name, w in _PRODUCT.items()},
    {name: w * w * (1.0 + _VARIANCE) / (1.0 + w * w) / _VARIANCE for name, w in _PRODUCT.items()},
)  # fmt: skip
