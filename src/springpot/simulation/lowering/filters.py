"""The law of the impulses of Gaussian noise with a rational spectrum.

A Gaussian force with a rational spectrum is an output of a linear filter of white noise, e = c y and
y' = A y + white noise.  Its impulses in the steps, the integrals of e, are a stationary Gaussian sequence of the same
kind, so they have an innovations form (Anderson and Moore, "Optimal filtering", 1979, chapter 9): one normal for each
step, whatever the number of states,

    impulse = H s + sqrt(S) g,    s <- F s + K sqrt(S) g,

where s is the best guess of y from all earlier impulses, and S the variance of what it does not foresee.  The sequence
has the law of the integrals themselves: there is no error of the step, however short the correlation time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy import linalg

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.sizes import GROUP
from springpot.simulation.lowering.sources import Filter, Filtered
from springpot.theory.numerics.white_noise import gathered

_DOUBLINGS = 80
_FASTER = 1e9  # of two rates


def filtered(filters: Sequence[Filter], step: float, white: float = 0.0, *, floor: float = 0.0) -> Filtered:
    """The law of the impulses over a group of steps of a sum of filters, each with noise of its own.

    Parameters
    ----------
    filters : sequence of Filter
    step : float
        The step, or the part of it; impulses are the integrals of the force in steps, times it.
    white : float
        Variance of a white noise that is added to every impulse.
    floor : float
        White noise that is added too, as a share of the variance: without it the law is ill-conditioned where a
        density falls to nothing within the reach of the step.

    Returns
    -------
    Filtered

    Examples
    --------
    The variance of an impulse of noise with the correlation time of one step is 2 / e times its own:

    >>> one = np.ones((1, 1))
    >>> slow = filtered([Filter(-one, 2.0 * one, np.ones(1))], 1.0)
    >>> variance = slow.newest[0] ** 2 + ((slow.pairs[0, 4:6] @ slow.start) ** 2).sum()
    >>> bool(abs(variance - 2.0 / math.e) < 1e-12)
    True
    """
    blocks = [over_a_step(pair) for pair in _in_pairs(filters)]
    move = linalg.block_diag(*(step_of[:-1, :-1] for step_of, _, _ in blocks))
    seen = step * np.concatenate([step_of[-1, :-1] for step_of, _, _ in blocks])
    spread = linalg.block_diag(*(noise[:-1, :-1] for _, noise, _ in blocks))
    cross = step * np.concatenate([noise[:-1, -1] for _, noise, _ in blocks])
    unseen = step**2 * sum(float(noise[-1, -1]) for _, noise, _ in blocks) + white
    stationary = linalg.block_diag(*(covariance for _, _, covariance in blocks))
    if floor:
        unseen += floor * (float(seen @ stationary @ seen) + unseen)
    guess = _uncertainty(move, seen, spread, cross, unseen)
    variance = float(seen @ guess @ seen) + unseen
    root = math.sqrt(max(variance, 0.0))
    gain = (move @ guess @ seen + cross) / root if root > 0.0 else np.zeros(len(seen))
    rows, newest = [], np.array([root, 0.0, 0.0, 0.0])
    for k in range(len(seen) // 2):
        own = slice(2 * k, 2 * k + 2)
        powers = [np.linalg.matrix_power(move[own, own], n) for n in range(GROUP + 1)]
        shown = [seen[own] @ power for power in powers[:GROUP]]
        moved = [power @ gain[own] for power in powers[GROUP - 1 :: -1]]
        newest[1:] += [float(seen[own] @ power @ gain[own]) for power in powers[: GROUP - 1]]
        rows.append([*(powers[GROUP] - np.eye(2)).ravel(), *np.ravel(shown), *np.ravel(moved)])
    return Filtered(np.array(rows), newest, _root(stationary - guess))


def _uncertainty(move: Floats, seen: Floats, spread: Floats, cross: Floats, unseen: float) -> Floats:
    """Covariance of the state given all earlier impulses: the solution of the discrete Riccati equation.

    By the structure-preserving doubling algorithm (Chu, Fan, Lin and Wang, International Journal of Control 77, 2004),
    which converges quadratically however slow a state is.
    """
    if not unseen > 0.0:
        return np.zeros_like(move)
    a = (move - np.outer(cross, seen) / unseen).T
    g, h = np.outer(seen, seen) / unseen, spread - np.outer(cross, cross) / unseen
    one = np.eye(len(seen))
    for _ in range(_DOUBLINGS):
        inverse = np.linalg.solve(one + g @ h, np.hstack([a, g]))
        through, back = inverse[:, : len(seen)], inverse[:, len(seen) :]
        more = a.T @ h @ through
        a, g, h = a @ through, g + a @ back @ a.T, h + 0.5 * (more + more.T)
        if np.abs(more).max() <= 1e-15 * np.abs(h).max():
            break
    return h


def _in_pairs(filters: Sequence[Filter]) -> Iterator[Filter]:
    """The same filters with an even number of states each: single ones are joined two by two."""
    yield from (filter for filter in filters if filter.output.size > 1)
    single = [filter for filter in filters if filter.output.size == 1]
    silent = Filter(-np.ones((1, 1)), np.zeros((1, 1)), np.zeros(1))
    single += [silent] * (len(single) % 2 if filters else 2)
    for first, second in zip(single[::2], single[1::2], strict=True):
        yield Filter(
            linalg.block_diag(first.matrix, second.matrix),
            linalg.block_diag(first.noise, second.noise),
            np.concatenate([first.output, second.output]),
        )


def over_a_step(block: Filter) -> tuple[Floats, Floats, Floats]:
    """State and impulse after a step from the state before it; the covariance of their noise; that of the state."""
    size = block.output.size + 1
    generator = np.zeros((size, size))
    generator[:-1, :-1], generator[-1, :-1] = block.matrix, block.output
    step, spread = gathered(generator, linalg.block_diag(block.noise, np.zeros((1, 1))))
    return step, spread, _stationary(block)


def _stationary(block: Filter) -> Floats:
    """Covariance of the state; of single filters that are joined in closed form if one is much faster."""
    rates = np.diag(block.matrix)
    alone = not (block.matrix - np.diag(rates)).any()
    if alone and np.abs(rates).max() > _FASTER * np.abs(rates).min():  # where SciPy's solver loses the slower one
        return np.asarray(-block.noise / np.add.outer(rates, rates))
    return np.asarray(linalg.solve_continuous_lyapunov(block.matrix, -block.noise))


def _root(covariance: Floats) -> Floats:
    """The lower triangular root of a covariance, which may be singular.

    Its diagonal is not negative: the signs that libraries give are those of eigenvectors, which processors choose.
    """
    values, vectors = np.linalg.eigh(covariance)
    root = np.tril(np.linalg.qr((vectors * np.sqrt(np.maximum(values, 0.0))).T)[1].T)
    return np.asarray(root * np.where(np.diag(root) < 0.0, -1.0, 1.0))
