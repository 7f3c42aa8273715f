"""Riemann's zeta function against mpmath, and what a run does without."""

from __future__ import annotations

import subprocess
import sys

import mpmath
import numpy as np

from springpot.zeta import zeta_beyond_one


def test_it_is_exact_to_rounding_from_the_pole_to_where_it_is_one() -> None:
    excess = np.append(np.geomspace(1e-12, 70.0, 400), np.linspace(0.1, 3.0, 30))
    with mpmath.workdps(30):
        exact = np.array([float(mpmath.zeta(1 + mpmath.mpf(float(e)))) for e in excess])
    np.testing.assert_allclose(zeta_beyond_one(excess), exact, rtol=2e-15)


def test_a_run_does_not_import_what_is_slow_to_import() -> None:
    """Neither for itself nor, by xarray, for its dataset."""
    script = """
import sys
import springpot as sp
numbers = sp.simulate(sp.Oscillator(), paths=64, duration=1.0, seed=1)
assert numbers["x_mean_square"].item() > 0.0
slow = "scipy.special", "scipy.optimize", "scipy.stats", "dask", "matplotlib"
print([name for name in slow if name in sys.modules])
"""
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", script], capture_output=True, text=True, check=True)
    assert ended.stdout == "[]\n"
