"""Order 1, where the past does not matter: x'' + x' + x = white noise above a wall at 0.  Exactly, <x^2 + v^2> = 1."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import numpy.typing as npt
from numba import njit

from benchmarks.measure import Row, best_wall
from springpot import Oscillator, Springpot
from springpot.processors import threads_available
from springpot.simulation import run

__all__ = ["white_noise_wall"]

Floats = npt.NDArray[np.float64]
STEP = 1e-3
_BATCH = 64  # steps of normals drawn at once
_CHUNK = 250  # paths of one task


def _numpy(paths: int, steps: int) -> Floats:
    """Vectorised over paths, semi-implicit Euler step, mirrored at the wall; x^2 + v^2 of each path, averaged."""
    random = np.random.Generator(np.random.SFC64(1))
    x, v, kept, g = np.zeros(paths), np.zeros(paths), np.zeros(paths), np.empty(paths)
    for n in range(steps):
        random.standard_normal(out=g)
        v += np.sqrt(STEP) * g - STEP * (x + v)
        x += STEP * v
        behind = x < 0.0
        np.negative(x, out=x, where=behind)
        np.negative(v, out=v, where=behind)
        if n >= steps // 2:
            kept += x * x + v * v
    return kept / (steps - steps // 2)


@njit(nogil=True, fastmath=True, error_model="numpy")
def _steps(x, v, kept, g, keep, step):
    noise = np.sqrt(step)
    for n in range(g.shape[0]):
        for i in range(x.size):
            v_next = v[i] - step * (x[i] + v[i]) + noise * g[n, i]
            x_next = x[i] + step * v_next
            sign = -1.0 if x_next < 0.0 else 1.0
            x[i], v[i] = sign * x_next, sign * v_next
            kept[i] += keep * (x_next * x_next + v_next * v_next)


def _hybrid_chunk(steps: int, task: tuple[int, np.random.SeedSequence]) -> Floats:
    paths, seed = task
    random = np.random.Generator(np.random.SFC64(seed))
    x, v, kept = np.zeros(paths), np.zeros(paths), np.zeros(paths)
    g = np.empty((_BATCH, paths), np.float32)
    half = steps // 2 // _BATCH * _BATCH
    for n in range(0, steps, _BATCH):
        part = g[: min(_BATCH, steps - n)]
        random.standard_normal(dtype=np.float32, out=part)
        _steps(x, v, kept, part, 1.0 if n >= half else 0.0, STEP)
    return kept / (steps - half)


def _hybrid(paths: int, steps: int, threads: int) -> Floats:
    """NumPy's normals and a Numba step, chunks of paths on threads."""
    sizes = [min(_CHUNK, paths - first) for first in range(0, paths, _CHUNK)]
    tasks = zip(sizes, np.random.SeedSequence(1).spawn(len(sizes)), strict=True)
    with ThreadPoolExecutor(threads) as pool:
        return np.concatenate(list(pool.map(partial(_hybrid_chunk, steps), tasks)))


def _diffrax(paths: int, steps: int) -> Callable[[], Floats]:
    """All paths as one state of a compiled solve in single precision, the wall inside a solver of its own.

    Raises
    ------
    ImportError
        If diffrax is not installed.
    """
    os.environ.setdefault("EQX_ON_ERROR", "nan")  # no checks at run time
    import diffrax
    import jax
    import jax.numpy as jnp

    duration, half = STEP * steps, STEP * (steps // 2)

    class Walled(diffrax.Euler):  # type: ignore[misc]
        def step(self, terms, t0, t1, y0, args, solver_state, made_jump):  # type: ignore[no-untyped-def]
            x, v, kept = y0
            _, dv, _ = terms.vf_prod(t0, y0, args, terms.contr(t0, t1))
            v = v + dv
            x = x + (t1 - t0) * v
            sign = jnp.where(x < 0.0, -1.0, 1.0)
            x, v = sign * x, sign * v
            y1 = (x, v, kept + jnp.where(t1 > half, x * x + v * v, 0.0))
            return y1, None, {"y0": y0, "y1": y1}, None, diffrax.RESULTS.successful

    class Kick(diffrax.ControlTerm):  # type: ignore[misc]
        def prod(self, vf, control):  # type: ignore[no-untyped-def]
            return jnp.zeros_like(vf), vf * control, jnp.zeros_like(vf)

    zero = jnp.zeros(paths, jnp.float32)

    def solve(key):  # type: ignore[no-untyped-def]
        path = diffrax.UnsafeBrownianPath((paths,), key)
        force = diffrax.ODETerm(lambda t, y, args: (zero, -y[0] - y[1], zero))
        terms = diffrax.MultiTerm(force, Kick(lambda t, y, args: zero + 1.0, path))
        solution = diffrax.diffeqsolve(
            terms, Walled(), 0.0, duration, STEP, (zero, zero, zero), saveat=diffrax.SaveAt(t1=True),
            adjoint=diffrax.ForwardMode(), max_steps=steps + 10, throw=False,
        )  # fmt: skip
        return solution.ys[2][-1] / (steps - steps // 2)

    key = jax.random.key(1)
    compiled = jax.jit(solve).lower(key).compile()
    return lambda: np.asarray(compiled(key).block_until_ready(), np.float64)


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
        found = run(oscillator, paths=paths, duration=STEP * steps, step=STEP, start="rest")
        return {"mean": found.values["amplitude_mean_square"], "error": found.errors["amplitude_mean_square"]}

    found = ours()
    least = best_wall(ours, times)
    rows = [
        Row(
            section, "springpot", least, "s wall", 1.0, "springpot",
            f"{threads} threads, all sums, exact impacts; <x^2 + v^2> = {found['mean']:.4f} +- {found['error']:.4f}",
        )
    ]  # fmt: skip
    _hybrid(_CHUNK, _BATCH, 1)
    kept = _hybrid(paths, steps, threads)
    seconds = best_wall(lambda: _hybrid(paths, steps, threads), times)
    rows.append(_row(section, "NumPy normals, Numba step", seconds, least, kept, f"{threads} threads, single normals"))
    kept = _numpy(paths, steps)
    seconds = best_wall(lambda: _numpy(paths, steps), times)
    rows.append(_row(section, "NumPy", seconds, least, kept, "vectorised over paths, one thread"))
    try:
        solve = _diffrax(paths, steps)
    except ImportError:
        return [*rows, Row(section, "diffrax", None, "", note="skipped: not installed (dependency group 'bench')")]
    kept = solve()
    seconds = best_wall(solve, 1 if quick else 2)
    return [*rows, _row(section, "diffrax", seconds, least, kept, "single precision, compiled beforehand")]
