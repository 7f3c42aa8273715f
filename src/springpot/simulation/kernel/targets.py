"""Processors that machine code is made for, and the one that this process uses.

A few of them stand for nearly all machines: code for them is made with a release and comes in the wheel.  In a source
checkout, and on other machines, it is compiled once (:mod:`springpot.simulation.kernel.native`), for the same target
where one of them fits, so that both have the same bits.
"""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from functools import cache

import llvmlite.binding as llvm

_V3 = frozenset({"avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt"})
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}


@dataclass(frozen=True)
class Target:
    """What machine code is made for.

    Attributes
    ----------
    name : str
    system, machine : str
        As Python's ``platform`` has them.
    triple, cpu, features : str
        As LLVM has them.
    width : int
        Lanes of a vector of the kernel: 64 where a register has room for 16 numbers, otherwise 32; measured.
    needs : frozenset of str
        What a processor must have, in LLVM's words.
    """

    name: str
    system: str
    machine: str
    triple: str
    cpu: str
    features: str = ""
    width: int = 32
    needs: frozenset[str] = frozenset()

    @property
    def here(self) -> bool:
        """Whether it is for this system and this processor."""
        ours = (self.system, self.machine) == (platform.system(), platform.machine())
        return ours and self.needs <= _features_of_host()

    @property
    def key(self) -> str:
        """What code for it depends on."""
        return f"{self.triple} {self.cpu} {self.features} {self.width}"

    @property
    def distance(self) -> tuple[str, str]:
        """How code reaches constants and other functions, as LLVM has it: at any distance, as it is loaded alone."""
        return ("static" if self.machine in ("x86_64", "AMD64") else "default"), "large"


TARGETS = (
    Target("linux-x86-64-v4", "Linux", "x86_64", "x86_64-unknown-linux-gnu", "x86-64-v4", width=64, needs=_V4),
    Target("linux-x86-64-v3", "Linux", "x86_64", "x86_64-unknown-linux-gnu", "x86-64-v3", needs=_V3),
    Target("linux-aarch64", "Linux", "aarch64", "aarch64-unknown-linux-gnu", "generic"),
    Target("macos-arm64", "Darwin", "arm64", "arm64-apple-macosx11.0.0", "apple-m1"),
)
"""Those with a name; of those that fit a machine the first is the fastest."""


@cache
def _features_of_host() -> frozenset[str]:
    try:
        return frozenset(name for name, has in llvm.get_host_cpu_features().items() if has)
    except RuntimeError:  # of a system on which LLVM cannot ask
        return frozenset()


@cache
def target() -> Target:
    """The target of this process.

    ``NUMBA_CPU_NAME`` chooses another one, as it does for Numba itself: the name of a processor as LLVM has it.  Then
    ``NUMBA_CPU_FEATURES`` are its extensions.  ``SPRINGPOT_TARGET`` names one, also for another machine, for which code
    is then made.

    Examples
    --------
    >>> target().width in (32, 64)
    True
    """
    if name := os.environ.get("SPRINGPOT_TARGET"):
        return named(name)
    asked, features = os.environ.get("NUMBA_CPU_NAME"), os.environ.get("NUMBA_CPU_FEATURES")
    fitting = [each for each in TARGETS if each.here and asked in (None, "", each.cpu) and not features]
    return fitting[0] if fitting else _of_its_own(asked, features)


def target_to_run() -> Target:
    """The target of this process, whose code is to be run and not only made.

    Raises
    ------
    ValueError
        If this machine cannot run it.
    """
    goal = target()
    if not goal.here:
        able = " or ".join([*(each.name for each in TARGETS if each.here), "not set"])
        raise ValueError(f"SPRINGPOT_TARGET must be {able}, not {goal.name}: this machine cannot run that code.")
    return goal


def named(name: str) -> Target:
    """The target of this name.

    Raises
    ------
    ValueError
        If there is none.
    """
    for each in TARGETS:
        if each.name == name:
            return each
    raise ValueError(f"target must be one of {', '.join(each.name for each in TARGETS)}, not {name!r}.")


def _of_its_own(cpu: str | None, features: str | None) -> Target:
    """A processor that no target stands for."""
    if features is None:
        features = "" if cpu else ",".join(f"+{name}" for name in sorted(_features_of_host()))
    cpu, system = cpu or llvm.get_host_cpu_name(), platform.system()
    return Target(
        f"{system.lower()}-{cpu}", system, platform.machine(), llvm.get_process_triple(), cpu, features,
        width=64 if "+avx512f" in features.split(",") else 32,
    )  # fmt: skip


WIDTH = target().width
"""Lanes of a vector of the kernel in this process."""
