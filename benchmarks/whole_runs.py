"""What a user waits for: an error asked for, longer runs, the first start and the next ones."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable, Sequence
from functools import partial

from benchmarks.kernels import MODES, block_cpu, parts_of
from benchmarks.measure import Row, best_wall, exponent
from springpot import Barrier, Dimensionless, Oscillator, Springpot, System
from springpot.machine.crew import threads_available
from springpot.simulation import Run, simulate
from springpot.simulation.kernel.lanes import LANES
from springpot.theory import Result, averaging, envelope, exact, fokker_planck, memory_closure

__all__ = ["asked_error", "command", "cost_of_length", "start_up", "theory"]

_SHORT = 5.0  # s; shorter runs are measured again


def asked_error(quick: bool) -> list[Row]:
    """Rows of section 6."""
    rtol = 0.1 if quick else 0.01
    section = f"<A^2> to {rtol:.0%}, Omega = C = q = 1"
    simulate(Oscillator(), rtol=0.3)  # compiles
    rows = []
    for order in (0.5,) if quick else (0.5, 0.1):
        oscillator = Oscillator(springpot=Springpot(order, 1.0))
        found: list[Run] = []
        work = partial(_keep, found, oscillator, rtol)
        seconds = best_wall(work, 1)
        if seconds < _SHORT:
            seconds = best_wall(work, 3)
        last = found[-1]["amplitude_mean_square"]
        value, budget = last.value, last.budget
        settings = found[-1].settings
        note = (
            f"warm, {threads_available()} threads; <A^2> = {value:.4g} +- {budget.total:.2g} (total error); "
            f"{settings.paths:,} paths of {settings.steps:,} steps of {settings.step:.3g} s"
        )
        rows.append(Row(section, f"alpha = {order:g}", seconds, "s wall", note=note))
    return rows


def _keep(found: list[Run], oscillator: System, rtol: float) -> None:
    found.append(simulate(oscillator, rtol=rtol))


def _peak_bytes(paths: int, steps: int) -> int:
    """The most memory that NumPy and Python held during a run."""
    tracemalloc.start()
    try:
        simulate(Oscillator(), paths=paths, duration=0.01 * steps, step=0.01, start="rest", threads=1)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def cost_of_length(quick: bool) -> list[Row]:
    """Rows of section 7."""
    section = "one block of 64 paths, order 0.5, against the steps N"
    lengths = (1000, 4000) if quick else (10_000, 30_000, 100_000, 300_000, 1_000_000)
    oscillator = Oscillator()
    rows = []
    cases: Sequence[tuple[str, int | None]] = ((f"{MODES} modes", MODES), ("memory chosen for N", None))
    for name, modes in cases:
        times = []
        for steps in lengths:
            parts = parts_of(oscillator, steps, modes=modes)
            times.append(block_cpu(parts, 3))
            kept = parts.kernel.tables.count("modes")
            note = f"{1e9 * times[-1] / (LANES * steps):.2f} ns per path-step, {kept} modes"
            rows.append(Row(section, f"{name}, N = {steps}", times[-1], "s CPU", note=note))
        rows.append(Row(section, f"{name}: exponent of N", exponent(lengths, times), ""))
    section = "memory held by a run"
    few, many = (640, 6400) if quick else (6400, 64_000)
    for steps in (40, 400):
        held = (_peak_bytes(many, steps) - _peak_bytes(few, steps)) / (many - few)
        note = f"largest, from {few} to {many} paths"
        rows.append(Row(section, f"{steps} steps", held, "bytes per path", note=note))
    return rows


def command(quick: bool, caches: str | None = None) -> None:
    """Run ``springpot simulate``, with what is kept in this folder; in the usual ones if it is None."""
    more = ["--paths", "64", "--duration", "1"] if quick else []
    own = {} if caches is None else {"NUMBA_CACHE_DIR": caches, "SPRINGPOT_CACHE_DIR": caches}
    subprocess.run(
        [sys.executable, "-m", "springpot", "simulate", *more], env={**os.environ, **own},
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def theory(quick: bool) -> list[Row]:
    """Rows of the section on theory."""
    section = "one oscillator by each analytical method"
    wall = Barrier(-0.5, 0.8)
    cases: dict[str, tuple[Callable[[System], Result], System]] = {
        "averaging": (averaging, Oscillator()),
        "envelope": (envelope, Oscillator(barrier=wall)),
        "closure": (memory_closure, Oscillator(barrier=wall)),
        "Fokker-Planck": (fokker_planck, Oscillator(springpot=Springpot(1.0, 0.5), barrier=wall)),
        "exact": (exact, Oscillator(barrier=None)),
    }
    rows = []
    for name, (solve, oscillator) in cases.items():
        work = partial(solve, oscillator)
        work()
        rows.append(Row(section, name, 1e3 * best_wall(work, 1 if quick else 7), "ms wall", note=_asked(oscillator)))
    return rows


def _asked(oscillator: System) -> str:
    paper = Dimensionless.of(oscillator)
    wall = paper.barrier
    place = "no wall" if wall is None else f"b = {wall.position:g}, r = {wall.restitution:g}"
    return f"alpha = {paper.springpot.order:g}, c = {paper.dimensionless_coefficient:g}, {place}; warm"


def start_up(quick: bool) -> list[Row]:
    """Rows of section 8."""
    section = "the command springpot simulate"
    with tempfile.TemporaryDirectory() as folder:
        cold = best_wall(lambda: command(quick, folder), 1)
        warm = best_wall(lambda: command(quick, folder), 1 if quick else 3)
    size = "64 paths x 100 steps" if quick else "default size: 5000 paths x 10,000 steps"
    return [
        Row(section, "first run", cold, "s wall", cold / warm, "next runs", f"empty caches: it compiles; {size}"),
        Row(section, "next runs", warm, "s wall", 1.0, "next runs", "compiled code and memory from disk"),
    ]
