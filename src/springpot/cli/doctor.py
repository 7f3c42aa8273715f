"""What this machine gives to a run, and a check of about a second that a run here can be trusted."""

from __future__ import annotations

import math
import platform
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from springpot.machine.extras import EXTRAS
from springpot.machine.processors import control_group_quota, threads_available
from springpot.machine.trusted import UntrustedFolderError, make_folder
from springpot.machine.versions import versions
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Springpot

# The vector extensions that decide the speed of the compiled step, widest last; the full list runs to a hundred.
_VECTOR_FEATURES = ("sse2", "avx", "fma", "avx2", "avx512f", "neon", "sve")
_TOLERANCE = 0.01


def diagnose() -> dict[str, Any]:
    """Everything ``springpot doctor`` prints, by name.

    Returns
    -------
    dict
        ``versions``, ``extras`` (those that are complete), ``processor``, ``threads``, ``cache`` and ``self_check``;
        JSON can hold all of it.

    Examples
    --------
    >>> diagnose()["self_check"]["passed"]
    True
    """
    return {
        "versions": {"python": platform.python_version()} | versions("numpy", "numba", "llvmlite", "scipy"),
        "extras": [name for name, modules in EXTRAS.items() if all(map(find_spec, modules))],
        "processor": processor(),
        "threads": threads(),
        "cache": cache_folder(),
        "self_check": self_check(),
    }


def processor() -> dict[str, Any]:
    """The processor that Numba compiles for: ``NUMBA_CPU_NAME`` where it is set, otherwise this machine's.

    Returns
    -------
    dict
        ``machine`` and ``name`` of the target, ``host`` of this machine, and the ``vector`` extensions that it may use.

    Examples
    --------
    >>> sorted(processor())
    ['host', 'machine', 'name', 'vector']
    """
    from llvmlite import binding
    from numba.core import codegen
    from numba.core.config import CPU_FEATURES, CPU_NAME  # set while Numba starts

    host = binding.get_host_cpu_name()
    name = CPU_NAME or host
    # NUMBA_CPU_NAME alone leaves the host's extensions switched on; only NUMBA_CPU_FEATURES replaces them.
    features = codegen.get_host_cpu_features() if CPU_FEATURES is None else CPU_FEATURES
    switched_on = features.split(",")
    vector = [feature for feature in _VECTOR_FEATURES if f"+{feature}" in switched_on]
    return {"machine": platform.machine(), "name": name, "host": host, "vector": vector or [f"those of {name}"]}


def threads() -> dict[str, Any]:
    """Threads that a run takes unless told otherwise, and what the control group grants (None without a limit).

    Examples
    --------
    >>> threads()["available"] >= 1
    True
    """
    quota = control_group_quota()
    return {"available": threads_available(), "control_group_limit": quota if math.isfinite(quota) else None}


def cache_folder() -> dict[str, Any]:
    """Where compiled kernels and sums of the memory are kept between runs, and whether they are.

    Returns
    -------
    dict
        ``folder`` and ``memory_folder``, each with ``used`` or ``memory_used``; and ``reason`` or ``memory_reason``,
        the sentence that says why it is not used, or None.  Where no folder is used, every process computes anew.

    Examples
    --------
    >>> sorted(cache_folder())
    ['folder', 'memory_folder', 'memory_reason', 'memory_used', 'reason', 'used']
    """
    from springpot.memory import store
    from springpot.simulation.kernel.compiled import find_kernels

    folder, reason = find_kernels()
    memory = store.folder()
    against = "this user has no home folder" if memory is None else _against(memory)
    return {
        "folder": folder, "used": folder is not None, "reason": reason,
        "memory_folder": None if memory is None else str(memory), "memory_used": against is None,
        "memory_reason": against,
    }  # fmt: skip


def _against(folder: Path) -> str | None:
    """Why files cannot be kept in a folder, or None."""
    try:
        make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            return None
    except UntrustedFolderError as error:
        return str(error)
    except OSError:
        return f"{str(folder)!r} cannot be written"


def self_check() -> dict[str, Any]:
    """Run a case with an exact answer: a linear damper at an elastic wall at 0.

    With order 1 and C = Omega = q = r = 1 the mean square of the amplitude is exactly 1 and the impact rate 1 / pi.
    Enough paths are taken for a standard error of about 0.25 %, and 1 % is allowed.

    Returns
    -------
    dict
        For each quantity its ``value``, ``standard_error`` and ``exact`` value; ``seconds``, compilation included;
        ``passed``, and a ``statement`` that says all this.

    Examples
    --------
    >>> self_check()["passed"]
    True
    """
    from springpot.simulation.monte_carlo import simulated

    began = time.perf_counter()
    answer = simulated(
        Oscillator(springpot=Springpot(order=1.0, coefficient=1.0)),
        paths=4096,
        duration=100.0,
        step=5e-3,
        window=(20.0, 100.0),
        start="rest",  # soon forgotten at order 1: no pilot runs are needed
        seed=1,
    ).to_dict()
    seconds = time.perf_counter() - began
    checked = {
        name: {"value": answer[name], "standard_error": answer[name + "_se"], "exact": exact}
        for name, exact in (("amplitude_mean_square", 1.0), ("impact_rate", 1.0 / math.pi))
    }
    passed = all(abs(number["value"] / number["exact"] - 1.0) <= _TOLERANCE for number in checked.values())
    numbers = "; ".join(
        f"{name} {number['value']:.4f} +- {number['standard_error']:.4f}, exact {number['exact']:.4f}"
        for name, number in checked.items()
    )
    statement = f"self-check {'passed' if passed else 'failed'} in {seconds:.1f} s (within 1 %): {numbers}"
    return {**checked, "seconds": seconds, "passed": passed, "statement": statement}
