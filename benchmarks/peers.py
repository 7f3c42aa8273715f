"""x'' + x' + x = white noise above an elastic wall at 0, as others would: Euler steps, mirrored at the wall.

Each gives, for each path, <x^2 + v^2>, <x> and the impacts per second after the step ``burn``.  They start from rest.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import numpy.typing as npt
from numba import njit

__all__ = ["compiled_diffrax", "mirrored_chain", "numpy_and_numba", "numpy_only"]

Floats = npt.NDArray[np.float64]
_BATCH = 64  # steps of normals drawn at once
_CHUNK = 250  # paths of one task


def _means(kept: Floats, steps: int, step: float) -> Floats:
    """From sums over steps: rows of <x^2 + v^2>, <x> and impacts per second."""
    return kept / (steps * np.array([1.0, 1.0, step])[:, None])


def numpy_only(paths: int, steps: int, burn: int, step: float, seed: int = 1) -> Floats:
    """Vectorised over paths, semi-implicit Euler step."""
    random = np.random.Generator(np.random.SFC64(seed))
    x, v, kept, g = np.zeros(paths), np.zeros(paths), np.zeros((3, paths)), np.empty(paths)
    for n in range(steps):
        random.standard_normal(out=g)
        v += np.sqrt(step) * g - step * (x + v)
        x += step * v
        behind = x < 0.0
        np.negative(x, out=x, where=behind)
        np.negative(v, out=v, where=behind)
        if n >= burn:
            kept[0] += x * x + v * v
            kept[1] += x
            kept[2] += behind
    return _means(kept, steps - burn, step)


@njit(nogil=True, fastmath=True, error_model="numpy")
def _steps(x, v, kept, g, keep, step):
    noise = np.sqrt(step)
    for n in range(g.shape[0]):
        for i in range(x.size):
            v_next = v[i] - step * (x[i] + v[i]) + noise * g[n, i]
            x_next = x[i] + step * v_next
            sign = -1.0 if x_next < 0.0 else 1.0
            x[i], v[i] = sign * x_next, sign * v_next
            kept[0, i] += keep * (x_next * x_next + v_next * v_next)
            kept[1, i] += keep * sign * x_next
            kept[2, i] += keep * (0.5 - 0.5 * sign)


def _chunk(steps: int, burn: int, step: float, task: tuple[int, np.random.SeedSequence]) -> Floats:
    paths, seed = task
    random = np.random.Generator(np.random.SFC64(seed))
    x, v, kept = np.zeros(paths), np.zeros(paths), np.zeros((3, paths))
    g = np.empty((_BATCH, paths), np.float32)
    burn = burn // _BATCH * _BATCH
    for n in range(0, steps, _BATCH):
        part = g[: min(_BATCH, steps - n)]
        random.standard_normal(dtype=np.float32, out=part)
        _steps(x, v, kept, part, 1.0 if n >= burn else 0.0, step)
    return _means(kept, steps - burn, step)


def numpy_and_numba(paths: int, steps: int, burn: int, step: float, seed: int = 1, threads: int = 1) -> Floats:
    """NumPy's normals in single precision and a Numba step, chunks of paths on threads."""
    sizes = [min(_CHUNK, paths - first) for first in range(0, paths, _CHUNK)]
    tasks = zip(sizes, np.random.SeedSequence(seed).spawn(len(sizes)), strict=True)
    with ThreadPoolExecutor(threads) as pool:
        return np.concatenate(list(pool.map(partial(_chunk, steps, burn, step), tasks)), axis=1)


def compiled_diffrax(paths: int, steps: int, burn: int, step: float, seed: int = 1) -> Callable[[], Floats]:
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

    duration, since = step * steps, step * burn

    class Walled(diffrax.Euler):  # type: ignore[misc]
        def step(self, terms, t0, t1, y0, args, solver_state, made_jump):  # type: ignore[no-untyped-def]
            x, v, *kept = y0
            _, dv, *_ = terms.vf_prod(t0, y0, args, terms.contr(t0, t1))
            v = v + dv
            x = x + (t1 - t0) * v
            behind = x < 0.0
            sign = jnp.where(behind, -1.0, 1.0)
            x, v = sign * x, sign * v
            keep = jnp.where(t1 > since, 1.0, 0.0)
            sums = [k + keep * more for k, more in zip(kept, (x * x + v * v, x, behind), strict=True)]
            y1 = (x, v, *sums)
            return y1, None, {"y0": y0, "y1": y1}, None, diffrax.RESULTS.successful

    class Kick(diffrax.ControlTerm):  # type: ignore[misc]
        def prod(self, vf, control):  # type: ignore[no-untyped-def]
            return (jnp.zeros_like(vf), vf * control, *[jnp.zeros_like(vf)] * 3)

    zero = jnp.zeros(paths, jnp.float32)

    def solve(key):  # type: ignore[no-untyped-def]
        path = diffrax.UnsafeBrownianPath((paths,), key)
        force = diffrax.ODETerm(lambda t, y, args: (zero, -y[0] - y[1], zero, zero, zero))
        terms = diffrax.MultiTerm(force, Kick(lambda t, y, args: zero + 1.0, path))
        solution = diffrax.diffeqsolve(
            terms, Walled(), 0.0, duration, step, (zero,) * 5, saveat=diffrax.SaveAt(t1=True),
            adjoint=diffrax.ForwardMode(), max_steps=steps + 10, throw=False,
        )  # fmt: skip
        return jnp.stack([kept[-1] for kept in solution.ys[2:]])

    key = jax.random.key(seed)
    compiled = jax.jit(solve).lower(key).compile()
    return lambda: _means(np.asarray(compiled(key).block_until_ready(), np.float64), steps - burn, step)


def mirrored_chain(step: float) -> Floats:
    """What these schemes converge to at one step size: <x^2 + v^2>, <x> and impacts per second, exactly.

    Mirrored at the wall, the chain is the modulus of the linear one, which is Gaussian: an impact is a change of sign.

    Examples
    --------
    >>> mirrored_chain(1e-4).round(4)  # 1, 1 / sqrt(pi), 1 / pi
    array([1.    , 0.5642, 0.3183])
    """
    from scipy.linalg import solve_discrete_lyapunov

    advance = np.array([[1.0 - step**2, step * (1.0 - step)], [-step, 1.0 - step]])
    kick = np.sqrt(step) * np.array([step, 1.0])
    covariance = solve_discrete_lyapunov(advance, np.outer(kick, kick))
    xx, vv = np.diag(covariance)
    correlation = (advance @ covariance)[0, 0] / xx
    return np.array([xx + vv, np.sqrt(2.0 * xx / np.pi), np.arccos(correlation) / (np.pi * step)])
