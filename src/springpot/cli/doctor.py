"""What this machine gives to a run, and a check of about a second that a run here can be trusted."""

from __future__ import annotations

import math
import platform
import tempfile
import time
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from springpot.machine.crew import control_group_quota, threads_available
from springpot.machine.installed import EXTRAS, versions
from springpot.machine.trusted import UntrustedFolderError, make_folder
from springpot.problem.basquin import Basquin
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Barrier, Mass, Spring, Springpot, WhiteNoise
from springpot.problem.system import System

# The vector extensions that decide the speed of the compiled step, widest last; the full list runs to a hundred.
_VECTOR_FEATURES = ("sse2", "avx", "fma", "avx2", "avx512f", "neon", "sve")
_TOLERANCE = 0.01


def diagnose() -> dict[str, Any]:
    """Everything ``springpot doctor`` prints, by name.

    Returns
    -------
    dict
        ``versions``, ``extras`` (those that are complete), ``processor``, ``threads``, ``compiled_code``, ``cache`` and
        ``self_check``; JSON can hold all of it.

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
        "compiled_code": compiled_code(),
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


def compiled_code() -> dict[str, Any]:
    """Where the compiled code of a run comes from: this installation, the disk, or Numba, which then compiles it now.

    Returns
    -------
    dict
        ``target``, the kind of processors it is for; ``lanes`` of its vectors; and each function with the words on it.

    Examples
    --------
    >>> compiled_code()["lanes"] in (32, 64)
    True
    """
    from springpot.simulation.kernel.native import ENTRIES
    from springpot.simulation.kernel.targets import target

    return {"target": target().name, "lanes": target().width, **{entry.name: entry.load().how for entry in ENTRIES}}


def compile_ahead() -> None:
    """Have the compiled code of runs, but for that of a user's own functions, and keep it for later processes.

    Short runs ask for all that a run can find out, so that nothing they need is forgotten here.
    """
    one = System(Mass(1.0), Spring(1.0), Springpot(0.5, 0.3), WhiteNoise(1.0), Barrier(-0.5, 0.7))
    two = System(
        *(Mass(1.0, at=name) for name in "ab"), *(Spring(1.0, between=("ground", name)) for name in "ab"),
        Springpot(0.5, 0.3, between=("a", "b")), WhiteNoise(1.0, on="a"), Barrier(-0.5, 0.7, between=("a", "b")),
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # such short runs say little
        for system, point in ((one, ""), (two, "a_")):
            _ask_for_all(system, point)


def _ask_for_all(system: System, point: str) -> None:
    from springpot.simulation.monte_carlo import simulated
    from springpot.simulation.rare.exceedance import exceedance

    simulated(
        system, paths=64, duration=20.0, step=0.05, start="rest", distributions=True, spectrum=[2.0], profile=1.0,
        slowest_counted_impact=0.1, rainflow={f"{point}x": Basquin(3.0, 1.0)}, forces=["springpot_force"],
        first_passage={f"{point}{name}": 9.0 for name in ("x", "v", "distance", "speed")},
    )  # fmt: skip
    exceedance(system, {f"{point}distance": 9.0}, duration=1.0, step=0.1, start="rest", rtol=1.0)


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
    from springpot.simulation.kernel import kept

    folder, reason = kept.folder()
    memory = store.folder()
    against = "this user has no home folder" if memory is None else _against(memory)
    return {
        "folder": folder and str(folder), "used": folder is not None, "reason": reason,
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
