"""A filter for the samples of one mass that strikes rigid walls or has nonlinear springs and soft contacts.

The state is s = (x, v, z_1, ..., z_n), with x' = v, v' = -K x - c v - sum w_j z_j + nonlinear forces + white noise
and z_j' = -s_j z_j + v.  Between impacts the flow is linear and exact: Phi = exp(A t) by its series, and the noise
adds Q(t), q times the integral of b b' with b = Phi e_v, by Gauss's rule.

**Histories.**  The law of the state is a sum of normal laws, one for each history of impacts that the samples allow.
Each of them is a Kalman filter.  In a substep that may reach a wall it becomes two.  *Free*: the wall was not reached,
so x is inside at the end.  *Struck*: the free flight x_f would have ended beyond the wall, from x_0 inside.  There the
state is, to first order in what is left of the substep, x = a - r (x_f - a), v = -r v_f + e (x_f - a),
z = z_f - (1 + r) (x_f - a), with e = -(1 + r) (K a + sum w_j z_j - f(a)) / v_f: the saltation matrix.  Memory that is
fast has forgotten a part of the impact: a time t after it, (1 + r) v (1 - exp(-s t)) / s of v t (1 + r) is left.  The
next sample weighs the two.  Nothing is decided, so no sample is left out and the likelihood has no jumps to speak of.

**Inside.**  That x is inside is a bound on a normal law.  While the mass approaches a wall, the bound of each step
holds all that were before; the law is kept as it is, and its weight is the probability of the last bound.  Where it
turns back or strikes, the law is replaced by the normal law with the mean and covariance that it has within its bounds:
one bound, or two after an impact (x inside now, x_0 inside before).  A second impact within a substep is not seen: it
is slow, and the noise hides it.  At a restitution below 0.25 many impacts follow each other within any substep, and
this is untrue: estimates of r are then too low.

**Nonlinear forces** act at both ends of each substep.  Their mean, slope and the rest of their variance are taken over
the present normal law of x at the three points of Gauss and Hermite, which is exact for a cubic mean.

References
----------
Sums of normal laws: Alspach and Sorenson 1972, IEEE Trans. Autom. Control 17, 439.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.cache import cached

_TERMS = 16  # of the series of exp(A t): 4e-7 where the fastest rate times t is 3
_MOST = 8  # histories after a substep
_NEAR = 5.0  # standard deviations of x, within which the wall may be reached
_SURE = 7.0  # standard deviations, from which a bound changes nothing
_LEAST = 1e-7  # weight of a history
_ALIKE = 0.1  # of the sum of their variances, below which the squares of differences of x and v make histories one
_FREE, _STRUCK = 0, 1
_NODES, _SHARES = np.polynomial.legendre.leggauss(6)
_NODES, _SHARES = 0.5 * (_NODES + 1.0), 0.5 * _SHARES
_FINE_NODES, _FINE_SHARES = np.polynomial.legendre.leggauss(20)
_FINE_NODES, _FINE_SHARES = 0.5 * (_FINE_NODES + 1.0), 0.5 * _FINE_SHARES
_COMPILED: dict[str, Any] = {"error_model": "numpy", "fastmath": {"reassoc", "contract"}, "nogil": True}


class Flow(NamedTuple):
    """One mass of 1 kg.

    Attributes
    ----------
    stiffness, damping, intensity : float
        K and c with what the slowest and the fastest memory add, and the intensity of the white noise.
    weights, rates : ndarray, shape (n,)
        w_j and s_j of the memory.
    walls : ndarray, shape (walls, 3)
        Position, side (1: the mass is above, -1: below) and restitution.
    powers : ndarray
        k_2, k_3, ... of the force k_2 x^2 + k_3 x^3 + ...
    contacts : ndarray, shape (contacts, 5)
        Position, side, stiffness, exponent and dissipation.
    """

    stiffness: float
    damping: float
    intensity: float
    weights: Floats
    rates: Floats
    walls: Floats
    powers: Floats
    contacts: Floats

    def drift(self) -> Floats:
        """The matrix A of the linear part."""
        size = 2 + self.rates.size
        found = np.zeros((size, size))
        found[0, 1] = 1.0
        found[1] = [-self.stiffness, -self.damping, *-self.weights]
        found[2:, 1] = 1.0
        found[range(2, size), range(2, size)] = -self.rates
        return found


class Histories(NamedTuple):
    """Normal laws of the state.

    Attributes
    ----------
    weights : ndarray, shape (n,)
        Logarithms.
    means : ndarray, shape (n, size)
    covs : ndarray, shape (n, size, size)
    held : ndarray, shape (n,)
        Probability of the bound that the weight contains and the law does not.
    walls : ndarray of int, shape (n,)
        The wall of this bound, or -1.  Within a substep: the wall that is near.
    hits : ndarray, shape (n,)
        Impacts so far.
    kinds : ndarray of int, shape (n,)
        Within a substep: `_FREE` or `_STRUCK`.
    clones : ndarray, shape (n, size + 2)
        Within a substep: covariances with x_0 at its beginning, its mean and its variance.
    """

    weights: Floats
    means: Floats
    covs: Floats
    held: Floats
    walls: Any
    hits: Floats
    kinds: Any
    clones: Floats


@cached
@njit(**_COMPILED)
def filtered(values, step, substeps, halvings, seen, noise, start, flow, terms, expected, spread):  # type: ignore[no-untyped-def]
    """Log-likelihood of each sample in ``terms``, what was expected in ``expected`` and ``spread``; number of impacts.

    The flow of a substep is that of its 2^``halvings``-th part, doubled.  ``seen`` is 0 for x, 1 for v, 2 for the
    acceleration by the parts; ``noise`` the variance of the measurement, ``start`` the covariance at the first sample.
    """
    paths, samples = values.shape
    size = 2 + flow.rates.size
    room, column = np.empty((size, size)), np.zeros(size)
    fine, random = np.empty((size, size)), np.empty((size, size))
    _advance(flow, step / substeps / 2**halvings, fine, random)
    for _ in range(halvings):
        part = fine.copy()
        added = random.copy()
        _apply(part, added, column, random, room)
        fine[:] = part @ part
    whole, whole_random = fine.copy(), random.copy()
    for _ in range(substeps - 1):
        _apply(fine, random, column, whole_random, room)
        whole = fine @ whole
    linear = flow.powers.size == 0 and flow.contacts.shape[0] == 0
    now, then = _histories(np.int64(_MOST), size), _histories(2 * _MOST, size)
    impacts = 0.0
    for k in range(paths):
        count = np.int64(1)  # a plain 1 has a type of its own, for which another `_branched` would be compiled
        now.weights[0], now.means[0], now.covs[0], now.hits[0] = 0.0, 0.0, start, 0.0
        now.held[0], now.walls[0] = 1.0, -1
        for n in range(samples):
            at_once = linear and substeps > 1 and count == 1 and _is_far(flow, whole, whole_random, step, now)
            turns = 1 if n == 0 or at_once else substeps
            duration = 0.0 if n == 0 else step / turns
            moves, adds = (whole, whole_random) if at_once else (fine, random)
            for turn in range(turns):
                found = _branched(flow, duration, moves, adds, now, count, then, room)
                last = turn == turns - 1
                if last:
                    _measured(flow, seen, noise, values[k, n], then, found, expected[k], spread[k], n)
                total = _inside(flow, then, found)
                if not total > -np.inf:
                    terms[k, n:] = -np.inf
                    terms[k + 1 :] = -np.inf
                    return impacts
                if last:
                    terms[k, n] = total
                count = _merged(then, found, total, now)
        for c in range(count):
            impacts += np.exp(now.weights[c]) * now.hits[c]
    return impacts


@njit(**_COMPILED)
def _is_far(flow, whole, random, step, now):  # type: ignore[no-untyped-def]
    """Whether the only history stays away from all walls for a step."""
    size, mean, cov = now.means.shape[1], now.means[0], now.covs[0]
    x, v, variance = 0.0, 0.0, random[0, 0]
    for i in range(size):
        x += whole[0, i] * mean[i]
        v += whole[1, i] * mean[i]
        for j in range(size):
            variance += whole[0, i] * cov[i, j] * whole[0, j]
    reach = _NEAR * np.sqrt(max(variance, cov[0, 0])) + 0.25 * step * (abs(v) + abs(mean[1]))
    for wall in flow.walls:
        if wall[1] * (mean[0] - wall[0]) < reach or wall[1] * (x - wall[0]) < reach:
            return False
    return now.walls[0] < 0


@njit(**_COMPILED)
def _histories(most, size):  # type: ignore[no-untyped-def]
    """Room for so many."""
    return Histories(
        np.zeros(most), np.zeros((most, size)), np.zeros((most, size, size)), np.ones(most), np.zeros(most, np.int64),
        np.zeros(most), np.zeros(most, np.int64), np.zeros((most, size + 2)),
    )  # fmt: skip


@njit(**_COMPILED)
def _branched(flow, h, fine, random, now, count, then, room):  # type: ignore[no-untyped-def]
    """The free flight of each history in a substep, and beside it the impact, where a wall is near."""
    size = now.means.shape[1]
    nonlinear = flow.powers.size > 0 or flow.contacts.shape[0] > 0
    found = 0
    for c in range(count):
        mean, cov, clone = now.means[c], now.covs[c], then.clones[found]
        if h > 0.0:
            if nonlinear:
                _kick(flow, 0.5 * h, mean, cov, clone[:0])
            clone[size], clone[size + 1] = mean[0], cov[0, 0]
            clone[:size] = fine @ cov[0]
            _apply(fine, random, mean, cov, room)
            if nonlinear:
                _kick(flow, 0.5 * h, mean, cov, clone)
        wall, least = now.walls[c], _NEAR * np.sqrt(cov[0, 0])
        if wall < 0:
            for w in range(flow.walls.shape[0]):
                gap = flow.walls[w, 1] * (mean[0] - flow.walls[w, 0])
                if gap < least:
                    wall, least = w, gap
        free = found
        then.weights[free], then.held[free], then.hits[free] = now.weights[c], now.held[c], now.hits[c]
        then.means[free], then.covs[free], then.walls[free], then.kinds[free] = mean, cov, wall, _FREE
        found += 1
        if wall >= 0 and h > 0.0:
            then.weights[found], then.held[found], then.hits[found] = now.weights[c], now.held[c], now.hits[c] + 1.0
            then.means[found], then.covs[found], then.walls[found], then.kinds[found] = mean, cov, wall, _STRUCK
            then.clones[found] = then.clones[free]
            _strike(flow, flow.walls[wall], h, then.means[found], then.covs[found], then.clones[found])
            found += 1
    return found


@njit(**_COMPILED)
def _strike(flow, wall, h, mean, cov, clone):  # type: ignore[no-untyped-def]
    """The state after an impact, from that after a free flight of a time ``h``."""
    size, at, side, r = mean.size, wall[0], wall[1], wall[2]
    deviation = np.sqrt(cov[0, 0])
    beyond = deviation * _mills(-side * (mean[0] - at) / deviation) - side * (mean[0] - at)  # of those that struck
    back = cov[0, 1] / cov[0, 0]
    speed = -side * (mean[1] + back * (at - side * beyond - mean[0]))
    speed = max(speed, 0.5 * np.sqrt(max(cov[1, 1] - back * cov[0, 1], 0.0)))
    left = min(max(beyond / speed, 0.0), h)
    turn = (1.0 + r) * _pull(flow, wall, mean) / (side * speed)
    depth = mean[0] - at
    by_x, by_v = np.ones(size), np.zeros(size)  # what the impact changes in the memory: -(1 + r) v (1 - e^-y) / s_j
    for i in range(2, size):
        y, given = flow.rates[i - 2] * left, 1.0
        if y > 1e-6:
            given = (1.0 - np.exp(-y)) / y
            by_x[i] = np.exp(-y)
            by_v[i] = left * (given - by_x[i])
        flown = -side * speed * left
        mean[i] -= (1.0 + r) * (given * flown + by_x[i] * (depth - flown) + by_v[i] * (mean[1] + side * speed))
    mean[0], mean[1] = at - r * depth, turn * depth - r * mean[1]
    for j in range(size):
        x, v = cov[0, j], cov[1, j]
        cov[0, j], cov[1, j] = -r * x, turn * x - r * v
        for i in range(2, size):
            cov[i, j] -= (1.0 + r) * (by_x[i] * x + by_v[i] * v)
    for j in range(size):
        x, v = cov[j, 0], cov[j, 1]
        cov[j, 0], cov[j, 1] = -r * x, turn * x - r * v
        for i in range(2, size):
            cov[j, i] -= (1.0 + r) * (by_x[i] * x + by_v[i] * v)
    x, v = clone[0], clone[1]
    clone[0], clone[1] = -r * x, turn * x - r * v
    for i in range(2, size):
        clone[i] -= (1.0 + r) * (by_x[i] * x + by_v[i] * v)
    more = (1.0 - r * r) * flow.intensity  # the noise after the impact is not reflected
    cov[1, 1] += more * left
    cov[0, 1] += more * left**2 / 2.0
    cov[1, 0] = cov[0, 1]
    cov[0, 0] += more * left**3 / 3.0


@njit(**_COMPILED)
def _measured(flow, seen, noise, value, then, found, expected, spread, n):  # type: ignore[no-untyped-def]
    """Each law, with its weight, given a sample; what was expected of it."""
    size = then.means.shape[1]
    nonlinear = flow.powers.size > 0 or flow.contacts.shape[0] > 0
    row, gain = np.zeros(size), np.zeros(size)
    shares, first, second = 0.0, 0.0, 0.0
    for c in range(found):
        mean, cov, clone = then.means[c], then.covs[c], then.clones[c]
        row[:] = 0.0
        variance = noise
        if seen < 2:
            row[seen] = 1.0
            level = mean[seen]
        else:
            row[0], row[1], row[2:] = -flow.stiffness, -flow.damping, -flow.weights
            level = 0.0
            for j in range(size):
                level += row[j] * mean[j]
            if nonlinear:
                force, by_x, by_v, rest = _force(flow, mean, cov)
                level += force
                row[0] += by_x
                row[1] += by_v
                variance += rest
        for i in range(size):
            gain[i] = 0.0
            for j in range(size):
                gain[i] += cov[i, j] * row[j]
            variance += row[i] * gain[i]
        share = np.exp(then.weights[c])
        if then.walls[c] >= 0:
            wall = flow.walls[then.walls[c]]
            share *= _probability(wall[1] * (mean[0] - wall[0]) / np.sqrt(cov[0, 0])) / then.held[c]
        shares += share
        first += share * level
        second += share * (variance + level * level)
        error, own = value - level, 0.0
        for j in range(size):
            own += clone[j] * row[j]
        clone[size] += own * error / variance
        clone[size + 1] -= own * own / variance
        for i in range(size):
            clone[i] -= own * gain[i] / variance
            mean[i] += gain[i] * error / variance
            for j in range(size):
                cov[i, j] -= gain[i] * gain[j] / variance
        then.weights[c] -= 0.5 * (np.log(2.0 * np.pi * variance) + error * error / variance)
    first /= shares
    expected[n], spread[n] = first, np.sqrt(max(second / shares - first * first, 1e-300))


@njit(**_COMPILED)
def _inside(flow, then, found):  # type: ignore[no-untyped-def]
    """Laws and weights given that x is inside of the walls; the logarithm of the sum of the weights."""
    most = -np.inf
    for c in range(found):
        if then.walls[c] >= 0:
            wall, mean, cov, held = flow.walls[then.walls[c]], then.means[c], then.covs[c], then.held[c]
            leaving = wall[1] * mean[1] / np.sqrt(max(cov[1, 1], 1e-300))
            pending = False
            if then.kinds[c] == _STRUCK:
                factor = _bounded_twice(mean, cov, then.clones[c], wall[0], wall[1]) / held
                factor *= _probability(wall[1] * mean[1] / np.sqrt(max(cov[1, 1], 1e-300)))
            elif leaving < 0.0:
                gap = wall[1] * (mean[0] - wall[0]) / np.sqrt(cov[0, 0])
                now = max(_probability(gap), 1e-300)
                factor = now / held
                pending = gap < _SURE
                if pending:
                    then.held[c] = now
            else:
                now = _bounded(mean, cov, wall[0], wall[1])
                factor = min(now / held, 1.0) if held < 1.0 else now + (1.0 - now) * _probability(leaving)
            if not pending:
                then.held[c], then.walls[c] = 1.0, -1
            then.weights[c] += np.log(factor)
        most = max(most, then.weights[c])
    if not most > -np.inf:
        return most
    total = 0.0
    for c in range(found):
        total += np.exp(then.weights[c] - most)
    return most + np.log(total)


@njit(**_COMPILED)
def _merged(then, found, total, now):  # type: ignore[no-untyped-def]
    """The histories that go on, the heaviest first; those that are alike are one."""
    size, count = then.means.shape[1], 0
    for _ in range(found):
        c = np.argmax(then.weights[:found])
        share = np.exp(then.weights[c] - total)
        then.weights[c] = -np.inf
        if share < _LEAST:
            break
        mean, cov, alone = then.means[c], then.covs[c], True
        for d in range(count):
            if then.walls[c] >= 0 or now.walls[d] >= 0:
                continue
            x, v = mean[0] - now.means[d, 0], mean[1] - now.means[d, 1]
            wide_x, wide_v = cov[0, 0] + now.covs[d, 0, 0], cov[1, 1] + now.covs[d, 1, 1]
            if x * x < _ALIKE * wide_x and v * v < _ALIKE * wide_v:
                own = share / (now.weights[d] + share)
                for i in range(size):
                    for j in range(size):
                        apart = (mean[i] - now.means[d, i]) * (mean[j] - now.means[d, j])
                        now.covs[d, i, j] += own * (cov[i, j] - now.covs[d, i, j]) + own * (1.0 - own) * apart
                now.means[d] += own * (mean - now.means[d])
                now.hits[d] += own * (then.hits[c] - now.hits[d])
                now.weights[d] += share
                alone = False
                break
        if alone and count < now.weights.size:
            now.weights[count], now.means[count], now.covs[count], now.hits[count] = share, mean, cov, then.hits[c]
            now.held[count], now.walls[count] = then.held[c], then.walls[c]
            count += 1
    total = now.weights[:count].sum()
    now.weights[:count] = np.log(now.weights[:count] / total)
    return count


@njit(**_COMPILED)
def _probability(z):  # type: ignore[no-untyped-def]
    """That a standard normal number is below z."""
    return 0.5 * math.erfc(-z * math.sqrt(0.5))


@njit(**_COMPILED)
def _mills(z):  # type: ignore[no-untyped-def]
    """The normal density at z over the probability below it."""
    if z < -8.0:
        return -z - 1.0 / z
    return math.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi) / _probability(z)


@njit(**_COMPILED)
def _bounded(mean, cov, at, side):  # type: ignore[no-untyped-def]
    """The probability that x is inside; mean and covariance become those of the law given that it is."""
    deviation = math.sqrt(cov[0, 0])
    gap = side * (mean[0] - at) / deviation
    if gap > _SURE:
        return 1.0
    slope = cov[:, 0] / deviation
    ratio = _mills(gap)
    less = min(ratio * (ratio + gap), 0.999)
    mean += side * ratio * slope
    for i in range(mean.size):
        for j in range(mean.size):
            cov[i, j] -= less * slope[i] * slope[j]
    return _probability(gap)


@njit(**_COMPILED)
def _bounded_twice(mean, cov, clone, at, side):  # type: ignore[no-untyped-def]
    """The same where x_0, at the beginning of the substep, was inside as well.

    Moments of (x, x_0) are integrals over x by Gauss's rule; the rest of the state follows by its regression on them.
    """
    size = mean.size
    variance, own = cov[0, 0], max(clone[size + 1], 1e-300)
    gap, gap_0 = side * (mean[0] - at), side * (clone[size] - at)
    if gap_0 > _SURE * math.sqrt(own):
        return _bounded(mean, cov, at, side)
    deviation, slope = math.sqrt(variance), clone[0] / variance
    rest = math.sqrt(max(own - clone[0] * slope, 1e-6 * own))
    low, high = max(0.0, gap - _SURE * deviation), gap + _SURE * deviation
    if slope < 0.0:
        high = min(high, gap - (gap_0 + _SURE * rest) / slope)
    elif slope > 0.0:
        low = max(low, gap - (gap_0 + _SURE * rest) / slope)
    if not high > low:
        return 0.0
    whole, x, xx, y, yy, xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for node, share in zip(_FINE_NODES, _FINE_SHARES):  # noqa: B905
        here = low + (high - low) * node
        middle = gap_0 + slope * (here - gap)
        weight = share * (high - low) * math.exp(-0.5 * ((here - gap) / deviation) ** 2) * _probability(middle / rest)
        ratio = _mills(middle / rest)
        there = middle + rest * ratio
        whole += weight
        x += weight * here
        xx += weight * here * here
        y += weight * there
        yy += weight * (middle * there + rest * rest)
        xy += weight * here * there
    if not whole > 1e-290:
        return 0.0
    x, xx, y, yy, xy = x / whole, xx / whole, y / whole, yy / whole, xy / whole
    own = rest * rest + clone[0] * slope
    less_x, less_xy, less_y = variance - (xx - x * x), clone[0] - (xy - x * y), own - (yy - y * y)
    by_x, by_y = np.empty(size), np.empty(size)
    for i in range(size):
        by_y[i] = side * (clone[i] - slope * cov[i, 0]) / (rest * rest)
        by_x[i] = side * cov[i, 0] / variance - slope * by_y[i]
    mean += by_x * (x - gap) + by_y * (y - gap_0)
    for i in range(size):
        for j in range(size):
            cov[i, j] -= by_x[i] * (less_x * by_x[j] + less_xy * by_y[j])
            cov[i, j] -= by_y[i] * (less_xy * by_x[j] + less_y * by_y[j])
    return whole / (deviation * math.sqrt(2.0 * math.pi))


@njit(**_COMPILED)
def _pull(flow, wall, mean):  # type: ignore[no-untyped-def]
    """The force of springs, contacts and memory at a wall."""
    found = flow.stiffness * wall[0] - _at(flow, wall[0])[0]
    for j in range(flow.weights.size):
        found += flow.weights[j] * mean[j + 2]
    return found


@njit(**_COMPILED)
def _series(flow, size):  # type: ignore[no-untyped-def]
    """A^k / k!"""
    found = np.zeros((_TERMS + 1, size, size))
    for i in range(size):  # `np.eye` takes a second to compile
        found[0, i, i] = 1.0
    for k in range(1, _TERMS + 1):
        for j in range(size):
            found[k, 0, j] = found[k - 1, 1, j] / k
            pulled = flow.stiffness * found[k - 1, 0, j] + flow.damping * found[k - 1, 1, j]
            for i in range(2, size):
                pulled += flow.weights[i - 2] * found[k - 1, i, j]
                found[k, i, j] = (found[k - 1, 1, j] - flow.rates[i - 2] * found[k - 1, i, j]) / k
            found[k, 1, j] = -pulled / k
    return found


@njit(**_COMPILED)
def _advance(flow, t, phi, random):  # type: ignore[no-untyped-def]
    """Phi(t) and Q(t)."""
    size = phi.shape[0]
    series = _series(flow, size)
    phi[:] = series[_TERMS]
    for k in range(_TERMS - 1, -1, -1):
        for i in range(size):
            for j in range(size):
                phi[i, j] = phi[i, j] * t + series[k, i, j]
    random[:] = 0.0
    push = np.empty(size)
    for g in range(_NODES.size):
        s = t * _NODES[g]
        push[:] = series[_TERMS, :, 1]
        for k in range(_TERMS - 1, -1, -1):
            for i in range(size):
                push[i] = push[i] * s + series[k, i, 1]
        for i in range(size):
            for j in range(size):
                random[i, j] += flow.intensity * t * _SHARES[g] * push[i] * push[j]


@njit(**_COMPILED)
def _apply(phi, random, mean, cov, room):  # type: ignore[no-untyped-def]
    """Phi m and Phi P Phi' + Q."""
    size = mean.size
    for i in range(size):
        room[0, i] = 0.0
        for j in range(size):
            room[0, i] += phi[i, j] * mean[j]
    mean[:] = room[0]
    room[:] = 0.0
    for i in range(size):
        for k in range(size):
            for j in range(size):
                room[i, j] += phi[i, k] * cov[k, j]
    for i in range(size):
        for j in range(i + 1):
            total = random[i, j]
            for k in range(size):
                total += room[i, k] * phi[j, k]
            cov[i, j] = total
            cov[j, i] = total


@njit(**_COMPILED)
def _at(flow, x):  # type: ignore[no-untyped-def]
    """Nonlinear force f and damping d at a place: the acceleration is f - d v."""
    force, damping = 0.0, 0.0
    for n in range(flow.powers.size - 1, -1, -1):
        force = (force - flow.powers[n]) * x
    force *= x
    for contact in flow.contacts:
        depth = contact[1] * (contact[0] - x)
        if depth > 0.0:
            own = contact[2] * depth ** contact[3]
            force += contact[1] * own
            damping += contact[4] * own
    return force, damping


@njit(**_COMPILED)
def _force(flow, mean, cov):  # type: ignore[no-untyped-def]
    """The nonlinear acceleration over the law of x: mean, slopes by x and v, and the variance of the rest."""
    deviation = np.sqrt(3.0 * max(cov[0, 0], 1e-300))
    lower, damped_lower = _at(flow, mean[0] - deviation)
    middle, damped = _at(flow, mean[0])
    upper, damped_upper = _at(flow, mean[0] + deviation)
    by_v = -(damped_lower + 4.0 * damped + damped_upper) / 6.0
    turn = -(damped_upper - damped_lower) / (2.0 * deviation)
    lower, middle, upper = lower - damped_lower * mean[1], middle - damped * mean[1], upper - damped_upper * mean[1]
    force = (lower + 4.0 * middle + upper) / 6.0
    by_x = (upper - lower) / (2.0 * deviation)
    rest = (lower**2 + 4.0 * middle**2 + upper**2) / 6.0 - force**2 - by_x**2 * cov[0, 0]
    return force + turn * cov[0, 1], by_x, by_v, max(rest, 0.0)


@njit(**_COMPILED)
def _kick(flow, t, mean, cov, clone):  # type: ignore[no-untyped-def]
    """What the nonlinear forces do in a time t."""
    force, by_x, by_v, rest = _force(flow, mean, cov)
    size = mean.size
    own = np.expm1(t * by_v) / by_v if by_v < 0.0 else t  # the damping alone is exact
    mean[1] += own * force
    a, b = own * by_x, 1.0 + own * by_v
    for j in range(size):
        cov[1, j] = a * cov[0, j] + b * cov[1, j]
    for j in range(size):
        cov[j, 1] = a * cov[j, 0] + b * cov[j, 1]
    cov[1, 1] += own**2 * rest
    if clone.size:
        clone[1] = a * clone[0] + b * clone[1]
