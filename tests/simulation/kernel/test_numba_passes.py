"""With a Numba that is not known, compilation takes longer, and the results are the same."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import springpot as sp
from tests.sizes import validation

ANOTHER_VERSION = "import numba; numba.__version__ = '99.0.0'"
NO_PASS = "from numba.core import typed_passes; del typed_passes.NopythonRewrites"
NO_LIBRARY = "from numba.core import codegen; del codegen.JITCodeLibrary"
NO_INLINING = "import numba; numba.__version__ = '99.0.0'; del numba.core.cpu._options_mixin.forceinline"

RUN = """
import json
import springpot as sp
from springpot.simulation.kernel import lanes
from springpot.simulation.kernel.native import KERNELS
assert not lanes.QUICK
run = sp.simulate(sp.Oscillator(**{barrier}), paths=64, duration=30.0, seed=5, memory_tolerance={tolerance}, {more})
values = {{name: repr(estimate.value) for name, estimate in run.estimates.items()}}
print(json.dumps([values, KERNELS['{kind}'].load().how]))
"""

COUNTED = "distributions=True"  # by functions that the kernel calls


@pytest.mark.parametrize(
    ("pretended", "barrier", "tolerance", "more", "kept", "agree"),
    [
        validation(ANOTHER_VERSION, "{'barrier': None}", 1e-9, "", True, 1e-9),  # all in double precision
        validation(ANOTHER_VERSION, "{}", 1e-6, COUNTED, True, 1e-5),
        validation(NO_PASS, "{'barrier': None}", 1e-9, "", True, 1e-9),
        validation(NO_LIBRARY, "{'barrier': None}", 1e-9, "", True, 1e-9),
        validation(NO_INLINING, "{'barrier': None}", 1e-9, "", True, 1e-9),
    ],
)
def test_an_unknown_numba(
    pretended: str, barrier: str, tolerance: float, more: str, kept: bool, agree: float, tmp_path: Path
) -> None:
    """Compared with the kernel as it is: the same path-steps to rounding, from the disk with the same bits."""
    kind = "float32" if tolerance > 1e-7 else "float64"
    code = f"{pretended}\n{RUN.format(barrier=barrier, tolerance=tolerance, more=more, kind=kind)}"
    found = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=1800,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout))
    first, again = (how for _, how in found)
    assert first.startswith("compiled ")
    assert again.startswith("kept on disk" if kept else "compiled by Numba 99.0.0 for this process alone")
    assert found[0][0].items() ^ found[1][0].items() == set()
    usual = sp.simulate(
        sp.Oscillator(**eval(barrier)), paths=64, duration=30.0, seed=5, memory_tolerance=tolerance,
        **eval(f"dict({more})"),
    )  # fmt: skip
    for name in ("x_mean_square", "v_mean_square", "damping_power"):
        assert float(found[0][0][name]) == pytest.approx(usual[name].value, rel=agree)
