"""Order 1, where the past does not matter: x'' + x' + x = white noise above a wall at 0.  Exactly, <x^2 + v^2> = 1."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from benchmarks.measure import Row, best_wall
from benchmarks.peers import compiled_diffrax, numpy_and_numba, numpy_only
from springpot import Oscillator, Springpot
from springpot.machine.crew import threads_available
from springpot.simulation import simulate

__all__ = ["white_noise_wall"]

Floats = npt.NDArray[np.float64]
STEP = 1e-3


def _row(section: str, case: str, seconds: float, ours: float, kept: Floats, note: str) -> Row:
    error = kept.std(ddof=1) / np.sqrt(kept.size)
    found = f"<x^2 + v^2> = {kept.mean():.4f} +- {error:.4f}"
    return Row(section, case, seconds, "s wall", seconds / ours, "springpot", f"{note}; {found}")


def white_noise_wall(quick: bool) -> list[Row]:
    """Rows of section 4."""
    paths, steps = (500, 1000) if quick else (5000, 50_000)
    threads = threads_available()
    section = f"white noise, order 1, wall: {paths} paths, {steps} steps"
    oscillator = Oscillator(springpot=Springpot(1.0, 1.0))
    times = 1 if quick else 3

    def ours() -> dict[str, float]:
        found = simulate(oscillator, paths=paths, duration=STEP * steps, step=STEP, start="rest")
        return {"mean": found["amplitude_mean_square"].value, "error": found["amplitude_mean_square"].error}

    found = ours()
    least = best_wall(ours, times)
    rows = [
        Row(
            section, "springpot", least, "s wall", 1.0, "springpot",
            f"{threads} threads, all sums, exact impacts; <x^2 + v^2> = {found['mean']:.4f} +- {found['error']:.4f}",
        )
    ]  # fmt: skip
    numpy_and_numba(64, 64, 32, STEP)
    kept = numpy_and_numba(paths, steps, steps // 2, STEP, threads=threads)[0]
    seconds = best_wall(lambda: numpy_and_numba(paths, steps, steps // 2, STEP, threads=threads), times)
    rows.append(_row(section, "NumPy normals, Numba step", seconds, least, kept, f"{threads} threads, single normals"))
    kept = numpy_only(paths, steps, steps // 2, STEP)[0]
    seconds = best_wall(lambda: numpy_only(paths, steps, steps // 2, STEP), times)
    rows.append(_row(section, "NumPy", seconds, least, kept, "vectorised over paths, one thread"))
    try:
        solve = compiled_diffrax(paths, steps, steps // 2, STEP)
    except ImportError:
        return [*rows, Row(section, "diffrax", None, "", note="skipped: not installed (dependency group 'bench')")]
    kept = solve()[0]
    seconds = best_wall(solve, 1 if quick else 2)
    return [*rows, _row(section, "diffrax", seconds, least, kept, "single precision, compiled beforehand")]
