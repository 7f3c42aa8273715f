"""A root between two places against SciPy, Riemann's zeta function against mpmath, and what a run does without."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from scipy import optimize

from springpot.machine.without_scipy import root_between, zeta_beyond_one
from tests.sizes import thinned


@pytest.mark.parametrize(
    ("function", "low", "high"),
    [
        (lambda x: x * x - 2.0, 0.0, 2.0),
        (lambda x: math.tanh(1e5 * (x - 0.1)), -3.0, 5.0),
        (lambda x: math.exp(50.0 * x) - 1e-8, -4.0, 3.0),
        (lambda x: x**3 - 1e-30, -1.0, 1e6),
        (lambda x: (x - 3.0) ** 5, -1e3, 8.0),
        (lambda x: math.inf if x > 1.0 else x - 0.3, -1.0, 2.0),
    ],
)
def test_roots_are_those_of_scipy(function: Callable[[float], float], low: float, high: float) -> None:
    close = {"xtol": 1e-300, "rtol": 1e-14}
    theirs = optimize.brentq(function, low, high, maxiter=5000, **close)
    assert root_between(function, low, high, **close) == pytest.approx(theirs, rel=1e-13)
    assert root_between(function, high, low, **close) == pytest.approx(theirs, rel=1e-13)


def test_an_end_that_is_a_root_is_it() -> None:
    assert root_between(lambda x: x, 0.0, 1.0) == root_between(lambda x: x, -1.0, 0.0) == 0.0


def test_equal_signs_are_refused() -> None:
    with pytest.raises(ValueError, match="function must have different signs"):
        root_between(lambda x: x + 2.0, 0.0, 1.0)


def test_it_is_exact_to_rounding_from_the_pole_to_where_it_is_one() -> None:
    excess = np.append(np.geomspace(1e-12, 70.0, 400), np.linspace(0.1, 3.0, 30))
    with mpmath.workdps(30):
        exact = np.array([float(mpmath.zeta(1 + mpmath.mpf(float(e)))) for e in excess])
    np.testing.assert_allclose(zeta_beyond_one(excess), exact, rtol=2e-15)


MODELS = {
    "an oscillator": ("sp.Oscillator(), duration=2.0", []),
    # its walls have names in the dataset; the edges of its law are roots
    "a system": ("sp.System(*FEW, NEARLY_LINEAR, *AWAY), duration=1.0", []),
    "a lossy wall": ("sp.Oscillator(barrier=sp.Barrier(-0.5, 0.7)), duration=1.0", ["scipy.special"]),  # of few impacts
}


@pytest.mark.parametrize(("model", "needed"), thinned(MODELS.values(), 2), ids=MODELS)
def test_a_run_does_not_import_what_is_slow_to_import(model: str, needed: list[str]) -> None:
    """Neither for itself nor, by xarray, for its dataset, nor to load compiled code."""
    script = f"""
import sys
import springpot as sp
FEW = sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
NEARLY_LINEAR = sp.PolynomialSpring((0.0, 0.0, 1e-12))
AWAY = sp.Barrier(-200.0), sp.Barrier(200.0, free_side="below")
numbers = sp.simulate({model}, paths=64, seed=1).to_xarray()
assert numbers["x_mean_square"].item() > 0.0
slow = "scipy.special", "scipy.optimize", "scipy.stats", "dask", "matplotlib", "numba.typed.typeddict"
print([name for name in slow if name in sys.modules])
"""

    def imported() -> str:
        words = [sys.executable, "-Wignore", "-c", script]
        return subprocess.run(words, capture_output=True, text=True, check=True).stdout

    if imported() != f"{needed}\n":  # the first may have had to compile, which takes more
        assert imported() == f"{needed}\n"
