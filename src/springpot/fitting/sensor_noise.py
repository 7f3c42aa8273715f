"""The noise of a sensor: an autoregressive process, with the filter that makes it white; tests of what a fit leaves.

What is left of a record is noise if it depends on nothing that a better model might have, and if no sample stands at
the end of the sensor's range.
"""

from __future__ import annotations

import numpy as np

from springpot.machine.arrays import Floats

MOST_LAGS = 12
_MEMORY = 4096  # samples after which noise has forgotten


def lags_of(rows: Floats) -> Floats:
    """The coefficients of an autoregressive model of noise, by Yule and Walker; none of white noise.

    The order is the one with the least Bayesian information criterion, at most twelve.

    Parameters
    ----------
    rows : ndarray, shape (rows, samples)
        Records of the same noise.

    Returns
    -------
    ndarray, shape (order,)
        a of e_t = a_1 e_(t-1) + ... + white noise.

    Examples
    --------
    >>> white = np.random.default_rng(1).standard_normal((1, 2000))
    >>> lags_of(white).size
    0
    >>> red = white.copy()
    >>> for n in range(1, 2000):
    ...     red[0, n] += 0.9 * red[0, n - 1]
    >>> lags_of(red).round(2).tolist()
    [0.9]
    """
    centred = rows - rows.mean()
    most = min(MOST_LAGS, rows.shape[1] // 4)
    shared = [float((centred[:, k:] * centred[:, : rows.shape[1] - k]).sum()) for k in range(most + 1)]
    if not shared[0] > 0.0:
        return np.zeros(0)
    own, variance = np.zeros(0), 1.0
    best, found = 0.0, own
    for order in range(1, most + 1):  # Levinson's recursion
        new = (shared[order] - float(own @ shared[order - 1 : 0 : -1][: own.size])) / (shared[0] * variance)
        own = np.append(own - new * own[::-1], new)
        variance *= max(1.0 - new * new, 1e-15)
        criterion = rows.size * np.log(variance) + order * np.log(rows.size)
        if criterion < best:
            best, found = criterion, own
    return found


def coloured_square(columns: Floats, lags: Floats) -> Floats:
    """J^T S J of columns J and the covariance S of noise that a filter makes white of unit variance.

    Parameters
    ----------
    columns : ndarray, shape (numbers, rows, samples)
    lags : ndarray

    Examples
    --------
    >>> coloured_square(np.ones((1, 1, 3)), np.zeros(0)).round(9).tolist()
    [[3.0]]
    >>> coloured_square(np.ones((1, 1, 2)), np.array([0.5])).round(9).tolist()  # 2 (1 + 1/2) / (1 - 1/4)
    [[4.0]]
    """
    many, _, samples = columns.shape
    size = 1 << (2 * samples + _MEMORY).bit_length()
    gain = np.fft.rfft(np.concatenate([[1.0], -lags]), size)
    ends = np.fft.rfft(columns, size, axis=2).reshape(many, -1, size // 2 + 1)
    weight = np.full(size // 2 + 1, 2.0)
    weight[[0, -1]] = 1.0
    density = weight / np.abs(gain) ** 2 / size
    return np.asarray(np.einsum("irf,jrf,f->ij", ends, ends.conj(), density, optimize=True).real)


def filtered(rows: Floats, lags: Floats) -> Floats:
    """Rows less what follows from the samples before; the first samples are left out.

    Examples
    --------
    >>> filtered(np.array([[1.0, 2.0, 4.0]]), np.array([0.5])).tolist()
    [[1.5, 3.0]]
    """
    samples = rows.shape[-1]
    found = rows[..., lags.size :].copy()
    for n, lag in enumerate(lags.tolist(), start=1):
        found -= lag * rows[..., lags.size - n : samples - n]
    return found


def noise_probability(residual: Floats, slopes: Floats, beyond: Floats, moving: int) -> float:
    """The probability of what is left, if it is white noise, by a score test (C. R. Rao, 1948).

    Parameters
    ----------
    residual : ndarray, shape (samples,)
    slopes : ndarray, shape (samples, numbers)
        Its derivatives by all numbers of the fit.
    beyond : ndarray, shape (samples, more)
        What a better model might have.
    moving : int
        How many numbers the fit has found.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 400)
    >>> noise, line = np.random.default_rng(1).standard_normal(400), t[:, None]
    >>> more = np.stack([t**2, np.sin(9.0 * t)], axis=1)
    >>> noise_probability(noise, line, more, 1) > 0.05, noise_probability(noise + np.sin(9.0 * t), line, more, 1) < 1e-9
    (True, True)
    """
    from scipy import linalg, stats

    variance = float(residual @ residual) / max(residual.size - moving, 1)
    basis, _ = np.linalg.qr(slopes / np.maximum(np.sqrt((slopes**2).sum(axis=0)), 1e-300))
    extra = beyond - basis @ (basis.T @ beyond)
    size = np.sqrt((extra**2).sum(axis=0))
    q, r, _ = linalg.qr(extra[:, size > 0.0] / size[size > 0.0], mode="economic", pivoting=True)
    rank = int((np.abs(np.diag(r)) > 1e-6).sum())
    score = float(np.sum((q[:, :rank].T @ residual) ** 2)) / variance
    return float(stats.chi2.sf(score, max(rank, 1)))


def clipped(rows: Floats) -> int:
    """How many samples stand in a row at the largest or least value of all, three or more each time.

    Examples
    --------
    >>> clipped(np.array([[0.0, 1.0, 1.0, 1.0, 0.5, -1.0]]))
    3
    """
    count = 0
    for extreme in (rows.max(), rows.min()):
        at = (rows == extreme).astype(int)
        run = np.zeros_like(at)
        run[:, 2:] = at[:, 2:] * at[:, 1:-1] * at[:, :-2]
        for _ in range(2):
            run[:, :-1] |= run[:, 1:]
        count += int(run.sum())
    return count
