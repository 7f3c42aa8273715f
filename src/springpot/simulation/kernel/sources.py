"""Forces in the kernel that do not depend on the motion: colored, thermal, harmonic and Poisson excitation.

They are drawn once for every group of four steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.forces import _damp_nothing, _one_named, _wake_nothing
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED, SPARE, f64, typed, u32, u64
from springpot.simulation.kernel.questions import answers, damp, push, slots, supply, wake
from springpot.simulation.kernel.random import draw, philox

WORDS = 128  # counter words of one source; the second half of them is for its state at time 0


class Filtered(NamedTuple):
    """Gaussian noise through linear filters, as impulses of four steps (`springpot.simulation.lowering.filters`)."""

    word: int  # first counter word
    parts: int  # of a step: with 2 the impulses are sums of two of a run with half the step
    place: int  # of its state among the states of all forces, in lane arrays
    pairs: npt.NDArray[np.floating]  # (pairs, 20) of two states each; what they keep of themselves is less 1
    newest: npt.NDArray[np.floating]  # (4,) effect of a normal on the impulses of its step and the next three
    start: npt.NDArray[np.floating]  # lower triangle: the states at time 0 from normals
    envelope: npt.NDArray[np.floating] = np.zeros(0)  # of each step, by which impulses are multiplied; empty: 1


class Joined(NamedTuple):
    """Gaussian noise through linear filters and white noise: one normal for both, since only their sum moves the mass.

    The power of the filtered noise is that of its best guess from the sum so far, whose mean is the same.
    """

    filtered: Filtered  # of the sum
    white: float  # best guess of the impulse of white noise in a step, per unit of the step's normal


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
    envelope: npt.NDArray[np.floating] = np.zeros(0)  # as in `Filtered`


class ModulatedWhite(NamedTuple):
    """White noise whose strength changes with time (`springpot.simulation.lowering.modulated`)."""

    word: int
    roots: npt.NDArray[np.floating]  # (steps,) standard deviations of the impulses


class ModulatedParametric(NamedTuple):
    """White noise that multiplies the displacement, and whose strength changes with time."""

    word: int
    roots: npt.NDArray[np.floating]  # (steps,) standard deviations of the impulses per displacement
    share: float = 1.0  # of the power that is left by what dampers and memory take within the step


class Modulated(NamedTuple):
    """Filtered noise that is driven by white noise whose strength changes with time."""

    word: int
    place: int  # of its states and, after them, their changes in a step
    change: npt.NDArray[np.floating]  # (1 or steps, states, states) of the best guess of the state in a step, by itself
    seen: npt.NDArray[np.floating]  # (1 or steps, states) its effect on the impulse
    roots: npt.NDArray[np.floating]  # (steps,) effect of the normal on the impulse
    gains: npt.NDArray[np.floating]  # (steps, states) and on the guess


class Table(NamedTuple):
    """Impulses of records; each path has one of them, that of its number in turn, or one that is drawn."""

    word: int
    place: int  # of the number of the record, where there are several
    drawn: bool
    impulses: npt.NDArray[np.floating]  # (records, steps); 0 after the last


@dataclass(frozen=True)
class Filter:
    """A linear filter, e = c y and y' = A y + noise, started in its stationary state; time is in steps.

    Attributes
    ----------
    matrix : ndarray, shape (1, 1) or (2 n, 2 n)
        A, in units of one over a step: blocks of two states on the diagonal.
    noise : ndarray, of that shape
        Covariance of the noise in a step, of blocks with each other too.
    output : ndarray, shape (1,) or (2 n,)
        c.
    """

    matrix: Floats
    noise: Floats
    output: Floats


@answers(wake, Joined)
def _wake_joined(force, slot, who, stream, k0, k1, forcing):
    wake(force.filtered, slot, who, stream, k0, k1, forcing)


@answers(wake, Filtered)
def _wake_filtered(force, slot, who, stream, k0, k1, forcing):
    size = force.start.shape[0]
    for i in range(size * LANES):
        forcing.state[force.place * LANES + i] = 0.0
    for j in range(size):
        if j % GROUP == 0:
            draw(0, who, stream, force.word + WORDS // 2 + j // GROUP, k0, k1, forcing.normals)
        for i in range(j, size):
            for lane in range(LANES):
                normal = forcing.normals[(j % GROUP) * LANES + lane]
                forcing.state[(force.place + i) * LANES + lane] += force.start[i, j] * normal


@answers(supply, Joined)
def _supply_joined(force, slot, group, who, stream, k0, k1, forcing):
    """From the normals of white noise; with parts of a step from those that they were made of."""
    if force.filtered.parts == 1:
        _next_impulses(force.filtered, slot, forcing.white, forcing)
    else:
        for half in range(2):
            draw(2 * group + half, who, stream, 0, k0, k1, forcing.normals)
            _next_impulses(force.filtered, slot, forcing.normals, forcing)
            _sum_pairs(forcing.given, slot, 2 * half)


@answers(supply, Filtered)
@answers(supply, Poisson)
def _supply_in_parts(force, slot, group, who, stream, k0, k1, forcing):
    if force.parts == 1:
        four_impulses(force, slot, group, who, stream, k0, k1, forcing)
    else:
        four_impulses(force, slot, 2 * group, who, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 0)
        four_impulses(force, slot, 2 * group + 1, who, stream, k0, k1, forcing)
        _sum_pairs(forcing.given, slot, 2)
    for j in range(GROUP if force.envelope.size > 0 else 0):
        factor, to = _at_step(force.envelope, GROUP * group + j), (slot * GROUP + j) * LANES
        for lane in range(LANES):
            forcing.given[to + lane] *= factor


@njit(**INLINE)
def _at_step(values, n):
    return f64(values[n]) if n < values.size else 0.0


def four_impulses(force: Any, slot: Any, group: Any, who: Any, stream: Any, k0: Any, k1: Any, forcing: Any) -> Any:
    """Compiled code only: the impulses of four parts of a step."""
    raise NotImplementedError


@answers(four_impulses, Filtered)
def _four_of_filtered(force, slot, group, who, stream, k0, k1, forcing):
    draw(group, who, stream, force.word, k0, k1, forcing.normals)
    _next_impulses(force, slot, forcing.normals, forcing)


@answers(four_impulses, Poisson)
def _four_of_poisson(force, slot, group, who, stream, k0, k1, forcing):
    _next_shots(force, slot, group, who, stream, k0, k1, forcing)


@njit(**INLINE)
def _sum_pairs(given, slot, to):
    """Four impulses of half steps become two of steps, which are put at step ``to`` of the group.

    The first two steps are kept beyond the last force, until the second pair is known.
    """
    place, kept = slot * GROUP * LANES, SPARE * GROUP * LANES
    for lane in range(LANES):
        one = given[place + lane] + given[place + LANES + lane]
        two = given[place + 2 * LANES + lane] + given[place + 3 * LANES + lane]
        if to == 0:
            given[kept + lane], given[kept + LANES + lane] = one, two
        else:
            given[place + lane], given[place + LANES + lane] = given[kept + lane], given[kept + LANES + lane]
            given[place + 2 * LANES + lane], given[place + 3 * LANES + lane] = one, two


@njit(**LINKED)
def _next_impulses(force, slot, g, forcing):
    w, place = force.newest, slot * GROUP * LANES
    for lane in range(LANES):
        g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
        forcing.given[place + lane] = w[0] * g0
        forcing.given[place + LANES + lane] = w[0] * g1 + w[1] * g0
        forcing.given[place + 2 * LANES + lane] = w[0] * g2 + w[1] * g1 + w[2] * g0
        forcing.given[place + 3 * LANES + lane] = w[0] * g3 + w[1] * g2 + w[2] * g1 + w[3] * g0
    for k in range(force.pairs.shape[0]):
        p, at = force.pairs[k], (force.place + 2 * k) * LANES
        for lane in range(LANES):
            y, z = forcing.state[at + lane], forcing.state[at + LANES + lane]
            g0, g1, g2, g3 = g[lane], g[LANES + lane], g[2 * LANES + lane], g[3 * LANES + lane]
            forcing.given[place + lane] += p[4] * y + p[5] * z
            forcing.given[place + LANES + lane] += p[6] * y + p[7] * z
            forcing.given[place + 2 * LANES + lane] += p[8] * y + p[9] * z
            forcing.given[place + 3 * LANES + lane] += p[10] * y + p[11] * z
            forcing.state[at + lane] = y + (p[0] * y + p[1] * z + p[12] * g0 + p[14] * g1 + p[16] * g2 + p[18] * g3)
            forcing.state[at + LANES + lane] = z + (
                p[2] * y + p[3] * z + p[13] * g0 + p[15] * g1 + p[17] * g2 + p[19] * g3
            )


@answers(wake, Modulated)
def _wake_modulated(force, slot, who, stream, k0, k1, forcing):
    for i in range(2 * force.seen.shape[1] * LANES):
        forcing.state[force.place * LANES + i] = 0.0


@answers(supply, ModulatedParametric)
@answers(supply, ModulatedWhite)
def _supply_modulated_white(force, slot, group, who, stream, k0, k1, forcing):
    draw(group, who, stream, force.word, k0, k1, forcing.normals)
    for j in range(GROUP):
        root, to = _at_step(force.roots, GROUP * group + j), (slot * GROUP + j) * LANES
        for lane in range(LANES):
            forcing.given[to + lane] = root * forcing.normals[j * LANES + lane]


@answers(supply, Modulated)
def _supply_modulated(force, slot, group, who, stream, k0, k1, forcing):
    last, size = force.seen.shape[0] - 1, force.seen.shape[1]
    draw(group, who, stream, force.word, k0, k1, forcing.normals)
    for j in range(GROUP):
        n, to = GROUP * group + j, (slot * GROUP + j) * LANES
        inside, law = n < force.roots.size, min(n, last)
        root = _at_step(force.roots, n)
        for lane in range(LANES):
            forcing.given[to + lane] = root * forcing.normals[j * LANES + lane]
        for i in range(size):
            own, new = (force.place + i) * LANES, (force.place + size + i) * LANES
            seen, gain = force.seen[law, i], f64(force.gains[n, i]) if inside else 0.0
            for lane in range(LANES):
                forcing.given[to + lane] += seen * forcing.state[own + lane]
                forcing.state[new + lane] = gain * forcing.normals[j * LANES + lane]
            for k in range(size):
                factor, other = force.change[law, i, k], (force.place + k) * LANES
                for lane in range(LANES):
                    forcing.state[new + lane] += factor * forcing.state[other + lane]
        for i in range(size):
            own, new = (force.place + i) * LANES, (force.place + size + i) * LANES
            for lane in range(LANES):
                forcing.state[own + lane] += forcing.state[new + lane]


@answers(wake, Table)
def _wake_table(force, slot, who, stream, k0, k1, forcing):
    records = u64(force.impulses.shape[0])
    for lane in range(LANES if records > u64(1) else 0):
        taken = u64(who[lane]) % records
        if force.drawn:
            word, _, _, _ = philox(u32(0), who[lane], u32(stream), u32(force.word), k0, k1)
            taken = (u64(word) * records) >> u64(32)
        forcing.state[force.place * LANES + lane] = taken


@answers(supply, Table)
def _supply_table(force, slot, group, who, stream, k0, k1, forcing):
    records, steps = force.impulses.shape
    for j in range(GROUP):
        n, to = GROUP * group + j, (slot * GROUP + j) * LANES
        if records == 1 or n >= steps:
            impulse = f64(force.impulses[0, n]) if n < steps else 0.0
            for lane in range(LANES):
                forcing.given[to + lane] = impulse
        else:
            for lane in range(LANES):
                forcing.given[to + lane] = force.impulses[int(forcing.state[force.place * LANES + lane]), n]


@answers(push, Filtered)
@answers(push, Harmonic)
@answers(push, Modulated)
@answers(push, Table)
def _push_given(force, slot, n, x, v, g, forcing, at, lane, weight):
    impulse = forcing.given[slot * GROUP * LANES + at]
    forcing.impulses[slot * LANES + lane] = impulse
    return typed(0.0, x), typed(impulse, x)


@answers(push, Joined)
def _push_joined(force, slot, n, x, v, g, forcing, at, lane, weight):
    impulse = forcing.given[slot * GROUP * LANES + at]
    forcing.impulses[slot * LANES + lane] = impulse - force.white * g
    return typed(0.0, x), typed(impulse, x)


@answers(push, ModulatedWhite)
@answers(push, Poisson)
def _push_poisson(force, slot, n, x, v, g, forcing, at, lane, weight):
    forcing.impulses[slot * LANES + lane] = 0.0  # it has no memory: its mean work is known, as that of white noise
    return typed(forcing.given[slot * GROUP * LANES + at], x), typed(0.0, x)


@answers(push, ModulatedParametric)
def _push_modulated_parametric(force, slot, n, x, v, g, forcing, at, lane, weight):
    root = typed(_at_step(force.roots, n), x)
    forcing.impulses[slot * LANES + lane] = 0.0
    forcing.works[slot * LANES + lane] += weight * (typed(0.5, x) * force.share) * (root * x) * (root * x)
    return forcing.given[slot * GROUP * LANES + at] * x, typed(0.0, x)


@answers(wake, Harmonic)
def _wake_harmonic(force, slot, who, stream, k0, k1, forcing):
    for lane in range(LANES):
        word, _, _, _ = philox(u32(0), who[lane], u32(stream), u32(force.word), k0, k1)
        phase = 2.0 * math.pi * (f64(word) + 0.5) / 4294967296.0
        forcing.state[force.place * LANES + lane] = math.cos(phase)
        forcing.state[(force.place + 1) * LANES + lane] = math.sin(phase)


@answers(supply, Harmonic)
def _supply_harmonic(force, slot, group, who, stream, k0, k1, forcing):
    for j in range(GROUP):
        angle = force.turn * (GROUP * group + j + 0.5)
        like = forcing.state[0]
        cosine, sine = typed(force.impulse * math.cos(angle), like), typed(force.impulse * math.sin(angle), like)
        for lane in range(LANES):
            forcing.given[(slot * GROUP + j) * LANES + lane] = (
                cosine * forcing.state[force.place * LANES + lane]
                - sine * forcing.state[(force.place + 1) * LANES + lane]
            )


@njit(**LINKED)
def _next_shots(force, slot, group, who, stream, k0, k1, forcing):
    none = math.exp(-force.rate)
    for lane in range(LANES):
        words = philox(u32(group), who[lane], u32(stream), u32(force.word), k0, k1)
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
    draw(group, who, stream, force.word + 1, k0, k1, forcing.normals)
    for i in range(GROUP * LANES):
        forcing.given[slot * GROUP * LANES + i] *= force.size * f64(forcing.normals[i])


for _source in (Filtered, Harmonic, Joined, Modulated, ModulatedParametric, ModulatedWhite, Poisson, Table):
    answers(damp, _source)(_damp_nothing)
    answers(slots, _source)(_one_named)
answers(wake, ModulatedParametric)(_wake_nothing)
answers(wake, ModulatedWhite)(_wake_nothing)
answers(wake, Poisson)(_wake_nothing)
