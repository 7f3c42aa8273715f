"""The exact Gaussian likelihood of a sampled stationary state, in a time that is linear in the samples.

The covariance of the state's prediction changes by a matrix of rank one from sample to sample, because the start is
stationary (M. Morf, G. S. Sidhu and T. Kailath, "Some new algorithms for recursive estimation in constant, linear,
discrete-time systems", IEEE Transactions on Automatic Control 19, 1974).  So each sample costs two products with the
transition matrix; one, when the gain no longer changes.  In the coordinates of the eigenvectors the time of a product
is linear in the states.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numba.extending import overload

from springpot.fitting.state_space import Sampled
from springpot.machine.arrays import Floats
from springpot.simulation.kernel.cache import cached

_WORST = 1e4  # condition number of the eigenvectors, above which the transition matrix is taken as it is
_SETTLED = 1e-13  # relative change of the variance, and of the gain, below which both stay as they are


_COMPILED: dict[str, Any] = {"error_model": "numpy", "fastmath": {"reassoc", "contract"}}


def _move_by_columns(transition, state, moved):  # type: ignore[no-untyped-def]
    moved[:] = 0.0
    for j in range(state.size):
        for i in range(state.size):
            moved[i] += transition[j, i] * state[j]


def _move_by_bands(transition, state, moved):  # type: ignore[no-untyped-def]
    """The transition has three bands; first and last number of each array are 0."""
    low, middle, high = transition
    for i in range(1, state.size - 1):
        moved[i] = low[i] * state[i - 1] + middle[i] * state[i] + high[i] * state[i + 1]


def _move(transition: Any, state: Floats, moved: Floats) -> None:
    """Write to ``moved`` what becomes of a state in one sampling step."""
    raise NotImplementedError("only in compiled code")


@overload(_move, jit_options=_COMPILED)  # chosen by its type: a function as an argument cannot be kept on disk
def _(transition, state, moved):  # type: ignore[no-untyped-def]
    return _move_by_bands if isinstance(transition, types.BaseTuple) else _move_by_columns


@cached
@njit(**_COMPILED)
def _filtered(transition, row, gain, variance, values, standard, spread):  # type: ignore[no-untyped-def]
    """-2 ln L without its constant; ``standard`` takes the innovations, ``spread`` their standard deviations."""
    paths, samples = values.shape
    size = row.size
    state, moved = np.zeros((paths, size)), np.zeros(size)
    change, scale = gain.copy(), -1.0 / variance
    settled, total = False, 0.0
    for n in range(samples):
        if not variance > 0.0:
            return np.inf
        root = np.sqrt(variance)
        spread[n] = root
        for k in range(paths):
            own = state[k]
            expected = 0.0
            for i in range(size):
                expected += row[i] * own[i]
            error = values[k, n] - expected
            standard[k, n] = error / root
            total += standard[k, n] ** 2 + 2.0 * np.log(root)
            share = error / variance
            _move(transition, own, moved)
            for i in range(size):
                own[i] = moved[i] + gain[i] * share
        if not settled:
            seen = 0.0
            for i in range(size):
                seen += row[i] * change[i]
            before = variance
            variance += scale * seen * seen
            _move(transition, change, moved)
            least = 0.0
            for i in range(size):
                step = scale * seen * moved[i]
                gain[i] += step
                least = max(least, abs(step) - _SETTLED * abs(gain[i]))
            settled = least <= 0.0 and abs(scale * seen * seen) <= _SETTLED * abs(variance)
            for i in range(size):
                change[i] = moved[i] - gain[i] * (seen / variance)
            scale += scale * scale * seen * seen / before
    return total


def innovations_of(sampled: Sampled, noise: float, values: Floats) -> tuple[float, Floats, Floats]:
    """-2 ln L of sampled paths, their innovations in standard deviations, and these.

    Parameters
    ----------
    sampled : Sampled
    noise : float
        Standard deviation of the measurement noise.
    values : ndarray, shape (paths, n)

    Returns
    -------
    deviance : float
        Infinite if rounding leaves no variance.
    innovations : ndarray, shape (paths, n)
    spread : ndarray, shape (n,)

    Examples
    --------
    >>> one = Sampled(np.array([[0.5]]), np.array([[1.0]]), np.array([1.0]), 0.0)
    >>> y = np.array([1.0, 0.5, -1.0])
    >>> exact = np.array([[1.0, 0.5, 0.25], [0.5, 1.0, 0.5], [0.25, 0.5, 1.0]])
    >>> deviance = y @ np.linalg.solve(exact, y) + np.linalg.slogdet(2.0 * np.pi * exact)[1]
    >>> bool(abs(innovations_of(one, 0.0, y[None, :])[0] - deviance) < 1e-12)
    True
    """
    at = sampled.stationary @ sampled.row
    variance = float(sampled.row @ at) + noise**2
    gain = sampled.transition @ at
    centred = np.ascontiguousarray(values - sampled.mean)
    standard, spread = np.zeros_like(centred), np.zeros(centred.shape[1])
    bands, vectors = _modes_of(sampled.transition)
    if np.linalg.cond(vectors) < _WORST:
        row, gain = np.pad(sampled.row @ vectors, 1), np.pad(np.linalg.solve(vectors, gain), 1)
        found = _filtered(bands, row, gain, variance, centred, standard, spread)
    else:  # two of its rates are nearly one
        row, columns = np.ascontiguousarray(sampled.row), np.ascontiguousarray(sampled.transition.T)
        found = _filtered(columns, row, gain, variance, centred, standard, spread)
    return float(found) + values.size * float(np.log(2.0 * np.pi)), standard, spread


def _modes_of(transition: Floats) -> tuple[tuple[Floats, Floats, Floats], Floats]:
    """Real coordinates of the eigenvectors: the bands of the transition in them, and the matrix that leads back.

    Examples
    --------
    >>> whole = np.array([[0.5, 0.2], [-0.2, 0.5]])
    >>> (low, middle, high), back = _modes_of(whole)
    >>> inner = np.diag(middle[1:-1]) + np.diag(high[1:-2], 1) + np.diag(low[2:-1], -1)
    >>> bool(np.allclose(back @ inner @ np.linalg.inv(back), whole))
    True
    """
    from scipy import linalg

    blocks, vectors = linalg.cdf2rdf(*np.linalg.eig(transition))
    low, middle, high = (np.diagonal(blocks, place) for place in (-1, 0, 1))
    return (np.pad(low, (2, 1)), np.pad(middle, 1), np.pad(high, (1, 2))), np.asarray(vectors)
