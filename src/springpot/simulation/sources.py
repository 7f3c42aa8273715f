"""Forces in the kernel that do not depend on the motion: coloured, thermal, harmonic and Poisson excitation.

They are drawn once for every group of four steps.  A Gaussian force with a rational spectrum is an output of a linear
filter of white noise, e = c y and y' = A y + white noise.  Its impulses in the steps, the integrals of e, are a
stationary Gaussian sequence of the same kind, so they have an innovations form (Anderson and Moore, "Optimal
filtering", 1979, chapter 9): one normal for each step, whatever the number of states,

    impulse = H s + sqrt(S) g,    s <- F s + K sqrt(S) g,

where s is the best guess of y from all earlier impulses, and S the variance of what it does not foresee.  The sequence
has the law of the integrals themselves: there is no error of the step, however short the correlation time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy import linalg

from springpot.simulation.forces import _damp_nothing, _one_named, _wake_nothing
from springpot.simulation.lanes import GROUP, INLINE, LANES, LINKED, MOST_FORCES, f64, u32
from springpot.simulation.parts import answers, damp, push, slots, supply, wake
from springpot.simulation.random import draw, philox

__all__ = ["WORDS", "Filter", "Filtered", "Harmonic", "Poisson", "Table", "filtered"]

Floats = npt.NDArray[np.float64]

WORDS = 128  # counter words of one source; the second half of them is for its state at time 0
_DOUBLINGS = 80


class Filtered(NamedTuple):
    """Gaussian noise through linear filters, as impulses of four steps; `filtered` makes it."""

    word: int  # first counter word
    parts: int  # of a step: with 2 the impulses are sums of two of a run with half the step
    place: int  # of its state among the states of all forces, in lane arrays
    pairs: npt.NDArray[np.float64]  # (pairs, 20) of two states each
    newest: npt.NDArray[np.float64]  # (4,) effect of a normal on the impulses of its step and the next three
    start: npt.NDArray[np.float64]  # lower triangle: the states at time 0 from normals


class Harmonic(NamedTuple):
    """A harmonic force whose phase is random, the same for all times of a path."""

    word: int
    place: int
    impulse: float  # amplitude times the step, averaged over it
    turn: float  # radians per step


class Poisson(NamedTuple):
    """Impulses at random times, of normal sizes."""

    word: int
    parts: int  # as in `Filtered`
    rate: float  # impulses expected in a part of a step
    size: float  # standard deviation of an impulse


class Table(NamedTuple):
    """Impulses that are the same for all paths."""

    impulses: npt.NDArray[np.float64]  # of each step; 0 after the last


@dataclass(frozen=True)
class Filter:
    """A linear filter, e = c y and y' = A y + noise, started in its stationary state; time is in steps.

    Attributes
    ----------
    matrix : ndarray, shape (1, 1) or (2, 2)
        A, in units of one over a step.
    noise : ndarray, of that shape
        Covariance of the noise in a step.
    output : ndarray, shape (1,) or (2,)
        c.
    """

    matrix: Floats
    noise: Floats
    output: Floats


def filtered(
    filters: Sequence[Filter], word: int, place: int, step: float, white: float = 0.0, *, parts: int = 1
) -> Filtered:
    """The law of the impulses over a group of steps of a sum of filters.

    Parameters
    ----------
    filters : sequence of Filter
    word, place : int
        Where its random numbers and its state are.
    step : float
        The step, or the part of it; impulses are the integrals of the force in steps, times it.
    white : float
        Variance of a white noise that is added to every impulse.
    parts : int
        1 or 2: of a step.

    Returns
    -------
    Filtered

    Examples
    --------
    The variance of an impulse of noise with the correlation time of one step is 2 / e times its own:

    >>> one = np.ones((1, 1))
    >>> slow = filtered([Filter(-one, 2.0 * one, np.ones(1))], 1, 0, 1.0)
    >>> variance = slow.newest[0] ** 2 + ((slow.pairs[0, 4:6] @ slow.start) ** 2).sum()
    >>> bool(abs(variance - 2.0 / math.e) < 1e-12)
    True
    """
    blocks = [_over_a_step(pair) for pair in _in_pairs(filters)]
    move = linalg.block_diag(*(step_of[:2, :2] for step_of, _, _ in blocks))
    seen = step * np.concatenate([step_of[2, :2] for step_of, _, _ in blocks])
    spread = linalg.block_diag(*(noise[:2, :2] for _, noise, _ in blocks))
    cross = step * np.concatenate([noise[:2, 2] for _, noise, _ in blocks])
    unseen = step**2 * sum(float(noise[2, 2]) for _, noise, _ in blocks) + white
    stationary = linalg.block_diag(*(covariance for _, _, covariance in blocks))
    guess = _uncertainty(move, seen, spread, cross, unseen)
    variance = float(seen @ guess @ seen) + unseen
    root = math.sqrt(max(variance, 0.0))
    gain = (move @ guess @ seen + cross) / root if root > 0.0 else np.zeros(len(seen))
    rows, newest = [], np.array([root, 0.0, 0.0, 0.0])
    for k in range(len(blocks)):
        own = slice(2 * k, 2 * k + 2)
        powers = [np.linalg.matrix_power(move[own, own], n) for n in range(GROUP + 1)]
        shown = [seen[own] @ power for power in powers[:GROUP]]
        moved = [power @ gain[own] for power in powers[GROUP - 1 :: -1]]
        newest[1:] += [float(seen[own] @ power @ gain[own]) for power in powers[: GROUP - 1]]
        rows.append([*powers[GROUP].ravel(), *np.ravel(shown), *np.ravel(moved)])
    return Filtered(word, parts, place, np.array(rows), newest, _root(stationary - guess))


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


def _in_pairs(filters: Sequence[Filter]) -> list[Filter]:
    """The same filters as filters of two states each: single ones are joined two by two."""
    pairs = [filter for filter in filters if filter.output.size == 2]
    single = [filter for filter in filters if filter.output.size == 1]
    silent = Filter(-np.ones((1, 1)), np.zeros((1, 1)), np.zeros(1))
    single += [silent] * (len(single) % 2 if filters else 2)
    for first, second in zip(single[::2], single[1::2], strict=True):
        pairs.append(
            Filter(
                linalg.block_diag(first.matrix, second.matrix),
                linalg.block_diag(first.noise, second.noise),
                np.concatenate([first.output, second.output]),
            )
        )
    return pairs


def _over_a_step(block: Filter) -> tuple[Floats, Floats, Floats]:
    """State and impulse after a step from the state before it; the covariance of their noise; that of the state."""
    generator = np.zeros((3, 3))
    generator[:2, :2], generator[2, :2] = block.matrix, block.output
    step, spread = _transition(generator, linalg.block_diag(block.noise, np.zeros((1, 1))))
    return step, spread, np.asarray(linalg.solve_continuous_lyapunov(block.matrix, -block.noise))


def _transition(generator: Floats, noise: Floats) -> tuple[Floats, Floats]:
    """exp(A) and the covariance that a linear equation gathers in a unit of time, for rates of any size.

    Van Loan's exponential overflows for fast decay, so short times are doubled: P(2 t) = P P, and the covariance of the
    first half is carried through the second.
    """
    halvings = max(0, math.ceil(math.log2(max(float(np.abs(generator).sum(axis=1).max()), 1e-300))) + 1)
    size, short = len(generator), 0.5**halvings
    joint = np.zeros((2 * size, 2 * size))
    joint[:size, :size], joint[:size, size:], joint[size:, size:] = -generator, noise, generator.T
    power = linalg.expm(short * joint)
    step = power[size:, size:].T
    spread = step @ power[:size, size:]
    for _ in range(halvings):
        spread = spread + step @ spread @ step.T
        step = step @ step
    return step, 0.5 * (spread + spread.T)


def _root(covariance: Floats) -> Floats:
    """A lower triangular root of a covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(np.tril(np.linalg.qr((vectors * np.sqrt(np.maximum(values, 0.0))).T)[1].T))


@answers(wake, Filtered)
def _wake_filtered(force, slot, first, stream, k0, k1, forcing):
    size = force.start.shape[0]
    for i in range(size * LANES):
        forcing.state[force.place * LANES + i] = 0.0
    for j in range(size):
        if j % GROUP == 0:
            draw(0, first, stream, force.word + WORDS // 2 + j // GROUP, k0, k1, forcing.normals)
        for i in range(j, size):
            for lane in range(LANES):
                normal = f64(forcing.normals[(j % GROUP) * LANES + lane])
                forcing.state[(force.place + i) * LANES + lane] += force.start[i, j] * normal


@answers(supply, Filtered)
@answers(supply, Poisson)
def _supply_in_parts(force, slot, group, first, stream, k0, k1, forcing):
    if force.parts == 1:
        four_impulses(force, slot, group, first, stream, k0, k1, forcing)
    else:
        four_impulses(force, slot, 2 * group, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 0)
        four_impulses(force, slot, 2 * group + 1, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 2)


def four_impulses(force: Any, slot: Any, group: Any, first: Any, stream: Any, k0: Any, k1: Any, forcing: Any) -> Any:
    """Compiled code only: the impulses of four parts of a step."""
    raise NotImplementedError


@answers(four_impulses, Filtered)
def _four_of_filtered(force, slot, group, first, stream, k0, k1, forcing):
    _next_impulses(force, slot, group, first, stream, k0, k1, forcing)


@answers(four_impulses, Poisson)
def _four_of_poisson(force, slot, group, first, stream, k0, k1, forcing):
    _next_shots(force, slot, group, first, stream, k0, k1, forcing)


@njit(**INLINE)
def _sum_pairs(given, slot, to):
    """Four impulses of half steps become two of steps, which are put at step ``to`` of the group.

    The first two steps are kept beyond the last force, until the second pair is known.
    """
    place, kept = slot * GROUP * LANES, MOST_FORCES * GROUP * LANES
    for lane in range(LANES):
        one = given[place + lane] + given[place + LANES + lane]
        two = given[place + 2 * LANES + lane] + given[place + 3 * LANES + lane]
        if to == 0:
            given[kept + lane], given[kept + LANES + lane] = one, two
        else:
            given[place + lane], given[place + LANES + lane] = given[kept + lane], given[kept + LANES + lane]
            given[place + 2 * LANES + lane], given[place + 3 * LANES + lane] = one, two


@njit(**LINKED)
def _next_impulses(force, slot, group, first, stream, k0, k1, forcing):
    w, g, place = force.newest, forcing.normals, slot * GROUP * LANES
    draw(group, first, stream, force.word, k0, k1, g)
    for lane in range(LANES):
        g0, g1, g2, g3 = f64(g[lane]), f64(g[LANES + lane]), f64(g[2 * LANES + lane]), f64(g[3 * LANES + lane])
        forcing.given[place + lane] = w[0] * g0
        forcing.given[place + LANES + lane] = w[0] * g1 + w[1] * g0
        forcing.given[place + 2 * LANES + lane] = w[0] * g2 + w[1] * g1 + w[2] * g0
        forcing.given[place + 3 * LANES + lane] = w[0] * g3 + w[1] * g2 + w[2] * g1 + w[3] * g0
    for k in range(force.pairs.shape[0]):
        p, at = force.pairs[k], (force.place + 2 * k) * LANES
        for lane in range(LANES):
            y, z = forcing.state[at + lane], forcing.state[at + LANES + lane]
            g0, g1, g2, g3 = f64(g[lane]), f64(g[LANES + lane]), f64(g[2 * LANES + lane]), f64(g[3 * LANES + lane])
            forcing.given[place + lane] += p[4] * y + p[5] * z
            forcing.given[place + LANES + lane] += p[6] * y + p[7] * z
            forcing.given[place + 2 * LANES + lane] += p[8] * y + p[9] * z
            forcing.given[place + 3 * LANES + lane] += p[10] * y + p[11] * z
            forcing.state[at + lane] = p[0] * y + p[1] * z + p[12] * g0 + p[14] * g1 + p[16] * g2 + p[18] * g3
            forcing.state[at + LANES + lane] = p[2] * y + p[3] * z + p[13] * g0 + p[15] * g1 + p[17] * g2 + p[19] * g3


@answers(supply, Table)
def _supply_table(force, slot, group, first, stream, k0, k1, forcing):
    for j in range(GROUP):
        n = GROUP * group + j
        impulse = force.impulses[n] if n < force.impulses.size else 0.0
        for lane in range(LANES):
            forcing.given[(slot * GROUP + j) * LANES + lane] = impulse


@answers(push, Filtered)
@answers(push, Harmonic)
@answers(push, Table)
def _push_given(force, slot, n, x, v, g, forcing, at, lane, weight):
    impulse = forcing.given[slot * GROUP * LANES + at]
    forcing.impulses[slot * LANES + lane] = impulse
    return 0.0, impulse


@answers(push, Poisson)
def _push_poisson(force, slot, n, x, v, g, forcing, at, lane, weight):
    forcing.impulses[slot * LANES + lane] = 0.0  # it has no memory: its mean work is known, as that of white noise
    return forcing.given[slot * GROUP * LANES + at], 0.0


@answers(wake, Harmonic)
def _wake_harmonic(force, slot, first, stream, k0, k1, forcing):
    for lane in range(LANES):
        word, _, _, _ = philox(u32(0), u32(first + lane), u32(stream), u32(force.word), k0, k1)
        phase = 2.0 * math.pi * (f64(word) + 0.5) / 4294967296.0
        forcing.state[force.place * LANES + lane] = math.cos(phase)
        forcing.state[(force.place + 1) * LANES + lane] = math.sin(phase)


@answers(supply, Harmonic)
def _supply_harmonic(force, slot, group, first, stream, k0, k1, forcing):
    for j in range(GROUP):
        angle = force.turn * (GROUP * group + j + 0.5)
        cosine, sine = force.impulse * math.cos(angle), force.impulse * math.sin(angle)
        for lane in range(LANES):
            forcing.given[(slot * GROUP + j) * LANES + lane] = (
                cosine * forcing.state[force.place * LANES + lane]
                - sine * forcing.state[(force.place + 1) * LANES + lane]
            )


@njit(**LINKED)
def _next_shots(force, slot, group, first, stream, k0, k1, forcing):
    none = math.exp(-force.rate)
    for lane in range(LANES):
        words = philox(u32(group), u32(first + lane), u32(stream), u32(force.word), k0, k1)
        a, b, c, d = words
        for j in range(GROUP):
            word = a if j == 0 else b if j == 1 else c if j == 2 else d
            left = (f64(word) + 0.5) / 4294967296.0
            chance, count = none, 0
            while left > chance and chance > 0.0:
                left -= chance
                count += 1
                chance *= force.rate / count
            forcing.given[(slot * GROUP + j) * LANES + lane] = math.sqrt(float(count))
    draw(group, first, stream, force.word + 1, k0, k1, forcing.normals)
    for i in range(GROUP * LANES):
        forcing.given[slot * GROUP * LANES + i] *= force.size * f64(forcing.normals[i])


for _source in (Filtered, Harmonic, Poisson, Table):
    answers(damp, _source)(_damp_nothing)
    answers(slots, _source)(_one_named)
answers(wake, Poisson)(_wake_nothing)
answers(wake, Table)(_wake_nothing)
