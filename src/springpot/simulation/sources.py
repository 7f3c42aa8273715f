"""Forces in the kernel that do not depend on the motion: coloured, thermal, harmonic and Poisson excitation.

They are drawn once for every group of four steps.  A Gaussian force with a rational spectrum is an output of a linear
filter of white noise, e = c y with y' = A y + white noise.  Its impulses over the four steps, the integrals of e, and
its state after them are jointly normal given the state before them, so they are drawn from that law itself: no error
of the step, however short the correlation time.  The states come in pairs, to which the law is diagonal; the normals of
a pair move its state and all four impulses, and four more normals supply the rest of the impulses' variance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy import linalg

from springpot.simulation.forces import _damp_nothing, _one_named, _wake_nothing
from springpot.simulation.lanes import FAST, GROUP, INLINE, LANES, MOST_FORCES, f64, u32
from springpot.simulation.parts import answers, damp, push, slots, supply, wake
from springpot.simulation.random import draw, philox

__all__ = ["WORDS", "Filter", "Filtered", "Harmonic", "Poisson", "filtered"]

Floats = npt.NDArray[np.float64]

WORDS = 128  # counter words of one source; the second half of them is for its state at time 0


class Filtered(NamedTuple):
    """Gaussian noise through linear filters, as impulses of four steps; `filtered` makes it."""

    word: int  # first counter word
    parts: int  # of a step: with 2 the impulses are sums of two of a run with half the step
    place: int  # of its state among the states of all forces, in lane arrays
    pairs: npt.NDArray[np.float64]  # (pairs, 26)
    rest: npt.NDArray[np.float64]  # (4, 4) lower triangle: impulses due to the four normals that no pair has


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
    >>> variance = slow.pairs[0, 7] ** 2 + slow.pairs[0, 15] ** 2 + slow.rest[0, 0] ** 2
    >>> bool(abs(variance - 2.0 / math.e) < 1e-12)
    True
    """
    blocks = _in_pairs(filters)
    rows: list[list[float]] = []
    rests: list[Floats] = [white * np.eye(GROUP)]
    for block in blocks:
        moved, spread = _over_a_group(block)
        start = _root(np.asarray(linalg.solve_continuous_lyapunov(block.matrix, -block.noise), np.float64))
        state = _root(spread[:2, :2])
        # impulses = known(start) + share(normals of the state) + what is left
        share = linalg.lstsq(state, spread[:2, 2:])[0].T
        rests.append(step**2 * (spread[2:, 2:] - share @ share.T))
        rows.append([*moved[:2].ravel(), state[0, 0], state[1, 0], state[1, 1],
                     *(step * moved[2:]).ravel(), *(step * share).ravel(),
                     start[0, 0], start[1, 0], start[1, 1]])  # fmt: skip
    return Filtered(word, parts, place, np.array(rows).reshape(-1, 26), _root(np.sum(rests, axis=0)))


def _in_pairs(filters: Sequence[Filter]) -> list[Filter]:
    """The same filters as filters of two states each: single ones are joined two by two."""
    pairs = [filter for filter in filters if filter.output.size == 2]
    single = [filter for filter in filters if filter.output.size == 1]
    if len(single) % 2:
        single.append(Filter(-np.ones((1, 1)), np.zeros((1, 1)), np.zeros(1)))
    for first, second in zip(single[::2], single[1::2], strict=True):
        pairs.append(
            Filter(
                linalg.block_diag(first.matrix, second.matrix),
                linalg.block_diag(first.noise, second.noise),
                np.concatenate([first.output, second.output]),
            )
        )
    return pairs


def _over_a_group(block: Filter) -> tuple[Floats, Floats]:
    """State after four steps and impulses in them: as a function of the state before, and their covariance."""
    size = 3
    generator = np.zeros((size, size))
    generator[:2, :2], generator[2, :2] = block.matrix, block.output
    noise = linalg.block_diag(block.noise, np.zeros((1, 1)))
    step, spread = _transition(generator, noise)
    # one row for each of y and the impulses; columns: y before, then the independent parts of the four steps
    now, columns = np.hstack([np.eye(2), np.zeros((2, size * GROUP))]), [np.zeros((0, 2 + size * GROUP))]
    for k in range(GROUP):
        own = np.zeros((size, 2 + size * GROUP))
        own[:, 2 + size * k : 2 + size * (k + 1)] = np.eye(size)
        after = step[:, :2] @ now + own
        now, columns = after[:2], [*columns, after[2:]]
    joint = np.vstack([now, *columns])
    parts = joint[:, 2:].reshape(2 + GROUP, GROUP, size)
    return joint[:, :2], np.einsum("ikm,mn,jkn->ij", parts, spread, parts)


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
    for k in range(force.pairs.shape[0]):
        law = force.pairs[k]
        if k % 2 == 0:
            draw(0, first, stream, force.word + WORDS // 2 + k // 2, k0, k1, forcing.normals)
        at = (force.place + 2 * k) * LANES
        for lane in range(LANES):
            one = f64(forcing.normals[2 * (k % 2) * LANES + lane])
            two = f64(forcing.normals[(2 * (k % 2) + 1) * LANES + lane])
            forcing.state[at + lane] = law[23] * one
            forcing.state[at + LANES + lane] = law[24] * one + law[25] * two


@answers(supply, Filtered)
def _supply_filtered(force, slot, group, first, stream, k0, k1, forcing):
    if force.parts == 1:
        _next_impulses(force, slot, group, first, stream, k0, k1, forcing)
    else:
        _next_impulses(force, slot, 2 * group, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 0)
        _next_impulses(force, slot, 2 * group + 1, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 2)


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


@njit(**FAST)
def _next_impulses(force, slot, group, first, stream, k0, k1, forcing):
    r, g, place = force.rest, forcing.normals, slot * GROUP * LANES
    draw(group, first, stream, force.word, k0, k1, g)
    for lane in range(LANES):
        g0, g1, g2, g3 = f64(g[lane]), f64(g[LANES + lane]), f64(g[2 * LANES + lane]), f64(g[3 * LANES + lane])
        forcing.given[place + lane] = r[0, 0] * g0
        forcing.given[place + LANES + lane] = r[1, 0] * g0 + r[1, 1] * g1
        forcing.given[place + 2 * LANES + lane] = r[2, 0] * g0 + r[2, 1] * g1 + r[2, 2] * g2
        forcing.given[place + 3 * LANES + lane] = r[3, 0] * g0 + r[3, 1] * g1 + r[3, 2] * g2 + r[3, 3] * g3
    for k in range(force.pairs.shape[0]):
        law = force.pairs[k]
        if k % 2 == 0:
            draw(group, first, stream, force.word + 1 + k // 2, k0, k1, g)
        at, drawn = (force.place + 2 * k) * LANES, 2 * (k % 2) * LANES
        for lane in range(LANES):
            y, z = forcing.state[at + lane], forcing.state[at + LANES + lane]
            one, two = f64(g[drawn + lane]), f64(g[drawn + LANES + lane])
            for j in range(GROUP):
                forcing.given[place + j * LANES + lane] += (
                    law[7 + 2 * j] * y + law[8 + 2 * j] * z + law[15 + 2 * j] * one + law[16 + 2 * j] * two
                )
            forcing.state[at + lane] = law[0] * y + law[1] * z + law[4] * one
            forcing.state[at + LANES + lane] = law[2] * y + law[3] * z + law[5] * one + law[6] * two


@answers(push, Filtered)
@answers(push, Harmonic)
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


@answers(supply, Poisson)
def _supply_poisson(force, slot, group, first, stream, k0, k1, forcing):
    if force.parts == 1:
        _next_shots(force, slot, group, first, stream, k0, k1, forcing)
    else:
        _next_shots(force, slot, 2 * group, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 0)
        _next_shots(force, slot, 2 * group + 1, first, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 2)


@njit(**FAST)
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


for _source in (Filtered, Harmonic, Poisson):
    answers(damp, _source)(_damp_nothing)
    answers(slots, _source)(_one_named)
answers(wake, Poisson)(_wake_nothing)
