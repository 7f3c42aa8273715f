"""Riemann's zeta function against mpmath, and what a run does without."""

from __future__ import annotations

import subprocess
import sys

import mpmath
import numpy as np
import pytest

from springpot.memory.zeta import zeta_beyond_one


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


@pytest.mark.parametrize(("model", "needed"), MODELS.values(), ids=MODELS)
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
