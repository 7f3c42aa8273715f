"""The paper's Monte Carlo as one would first write it: NumPy, the whole past summed at every step."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time

import numpy as np

from benchmarks.measure import Row, best_cpu, exponent
from springpot import Dimensionless, Oscillator, Springpot, System
from springpot.memory import direct
from springpot.simulation import simulate

__all__ = ["numpy_history", "one_thread", "paper_by_history"]

POINTS, PATHS, STEPS = 63, 5000, 100_000  # Fig. 2
STEP = 1e-3


def numpy_history(oscillator: System, paths: int, steps: int, seed: int = 1) -> float:
    """Mean of x^2 + v^2 / Omega^2 at the end: Grunwald-Letnikov sum, Euler step, velocity reversed at the wall.

    Parameters
    ----------
    oscillator : System
        With its wall at 0 and elastic.
    paths, steps : int
    seed : int

    Returns
    -------
    float
    """
    random = np.random.default_rng(seed)
    paper = Dimensionless.of(oscillator)
    order, frequency = paper.springpot.order, paper.natural_frequency
    # weights of the increments of x, the oldest first, so that the past need not be turned round
    weights = paper.springpot.coefficient * STEP**-order * direct("grunwald", order, steps)[::-1].copy()
    kick = math.sqrt(paper.excitation.intensity * STEP)
    increments = np.empty((steps, paths))
    x, v = np.zeros(paths), np.zeros(paths)
    for n in range(steps):
        force = frequency**2 * x + weights[steps - n :] @ increments[:n]
        v += kick * random.standard_normal(paths) - STEP * force
        increments[n] = STEP * v
        x += increments[n]
        v[(x <= 1e-5) & (v < 0.0)] *= -1.0
    return float(np.mean(x**2 + (v / frequency) ** 2))


def one_thread(paths: int, steps: int) -> float:
    """Processor time in s of `numpy_history` in a process of its own, where BLAS has one thread."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.history", str(paths), str(steps)],
        env={**os.environ, **dict.fromkeys(names, "1")}, check=True, capture_output=True, text=True,
    )  # fmt: skip
    return float(done.stdout)


def paper_by_history(quick: bool) -> list[Row]:
    """Rows of section 3."""
    section = "Fig. 2 of the paper: 63 points, 5000 paths, 1e5 steps"
    paths = 500 if quick else PATHS
    lengths = (200, 400) if quick else (2000, 4000)
    times = [min(one_thread(paths, steps) for _ in range(1 if quick else 2)) for steps in lengths]
    slope = exponent(lengths, times)
    numpy_hours = times[-1] * (STEPS / lengths[-1]) ** 2 * (PATHS / paths) * POINTS / 3600

    ours_paths, ours_steps = (640, 1000) if quick else (PATHS, STEPS)
    orders = (0.1, 0.5, 0.9)

    def point(order: float) -> object:
        return simulate(
            Oscillator(springpot=Springpot(order, 1.0)), scheme="grunwald", paths=ours_paths, threads=1,
            duration=STEP * ours_steps, step=STEP, start="rest",
        )  # fmt: skip

    point(0.5)
    ours = [best_cpu(lambda order=order: point(order), 2) for order in orders]
    ours_hours = float(np.mean(ours)) * PATHS * STEPS / (ours_paths * ours_steps) * POINTS / 3600
    return [
        *(
            Row(section, f"NumPy, whole past, {n} steps", seconds, "s CPU", note=f"one point, {paths} paths, measured")
            for n, seconds in zip(lengths, times, strict=True)
        ),
        Row(
            section, "NumPy, whole past: exponent of the steps", slope, "",
            note="between the two lengths; 2 expected, a little more where the past leaves the processor's caches",
        ),
        Row(
            section, "NumPy, whole past", numpy_hours, "h CPU", numpy_hours / ours_hours, "springpot",
            f"scaled with the square of the steps from {lengths[-1]} steps, and linearly to all points; it would hold "
            f"{PATHS * STEPS * 8 / 1e9:g} GB of past",
        ),
        Row(
            section, "springpot", ours_hours, "h CPU", 1.0, "springpot",
            f"scheme 'grunwald', one thread; scaled linearly from the mean of alpha = {', '.join(map(str, orders))}",
        ),
    ]  # fmt: skip


if __name__ == "__main__":
    begun = time.process_time()
    numpy_history(Oscillator(), int(sys.argv[1]), int(sys.argv[2]))
    print(time.process_time() - begun)
