"""A Kalman filter for the samples of one mass that strikes rigid walls or has nonlinear springs and soft contacts.

The state is s = (x, v, z_1, ..., z_n), with x' = v, v' = -K x - c v - sum w_j z_j + nonlinear forces + white noise
and z_j' = -s_j z_j + v.  Between impacts the flow is linear and exact: Phi = exp(A t) by its series, and the noise
adds Q(t), q times the integral of b b' with b = Phi e_v, by Gauss's rule.

**Impact.**  Paths near the mean strike at their own times.  To first order in their deviation d, the impact at
t + dt, dt = -d_x / v-, brings d to R d + (f+ - R f-) d_x / v-, with R = diag(1, -r, 1, ...) and the drifts f-, f+
before and after.  That is the saltation matrix X: X_xx = X_vv = -r, X_zx = -(1 + r),
X_vx = -(1 + r) (K x + sum w_j z_j) / v-; dashpots cancel, because -c v+ - r c v- = 0.

**Nonlinear forces** act at both ends of each substep.  Their mean, slope and the rest of their variance are taken over
the present Gaussian law of x at the three points of Gauss and Hermite, which is exact for a cubic mean.

**Samples near a wall** are folded by it: where the sample is closer to an impact than its uncertainty it is left out.
Where the impact may as well not have happened (grazing), the wall is switched off, the velocity is unknown, and the
filter starts again from the first sample that is clear of the wall.  The decision to leave a sample out sees nothing
but samples before it that were used: windows made afterwards bias the place of the wall.  All decisions are made in
one pass, ``learn``, and are fixed in all others, where they would make the likelihood jump.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.cache import cached

USED, LEFT_OUT, DROPPED, RESTART = 0, 1, 2, 3
"""What becomes of a sample; those that are dropped lie between a grazing impact and the start after it."""

_TERMS = 16  # of the series of exp(A t): 4e-7 where the fastest rate times t is 3
_NEAR = 2.0  # standard deviations of x, within which a sample may be folded by the wall
_GRAZING = 3.0  # standard deviations of v, below which an impact may not have happened
_LONGEST = 8  # samples in a row that are left out, after which the filter starts again
_MOST = 20  # impacts in a substep
_HALVINGS = 50
_NODES, _SHARES = np.polynomial.legendre.leggauss(6)
_NODES, _SHARES = 0.5 * (_NODES + 1.0), 0.5 * _SHARES
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


class Marks(NamedTuple):
    """What was decided about samples and steps, a row for each path.

    Attributes
    ----------
    kinds : ndarray of int
        `USED`, `LEFT_OUT`, `DROPPED` or `RESTART`.
    walls : ndarray of bool
        Whether walls act in the step before each sample.
    widened : ndarray
        What is added to the variance of v at the beginning of that step.
    """

    kinds: NDArray[np.int8]
    walls: NDArray[np.bool_]
    widened: Floats


@cached
@njit(**_COMPILED)
def filtered(values, step, substeps, seen, noise, start, restart, flow, marks, learn, terms, expected, spread):  # type: ignore[no-untyped-def]
    """Log-likelihood of each sample in ``terms``, what was expected in ``expected`` and ``spread``; number of impacts.

    ``seen`` is 0 for x, 1 for v, 2 for the acceleration by the parts; ``noise`` the variance of the measurement,
    ``start`` the covariance at the first sample, ``restart`` the variance of v after a grazing impact.
    """
    paths, samples = values.shape
    size = 2 + flow.rates.size
    nonlinear = flow.powers.size > 0 or flow.contacts.shape[0] > 0
    series = _series(flow, size)
    fine, fine_random = np.empty((size, size)), np.empty((size, size))
    _advance(series, step / substeps, flow.intensity, fine, fine_random)
    whole, random = fine.copy(), fine_random.copy()
    for _ in range(substeps - 1):
        random = fine @ random @ fine.T + fine_random
        whole = fine @ whole
    mean, kept_mean, kept = np.zeros(size), np.zeros(size), np.zeros((size, size))
    row, gain, room = np.zeros(size), np.zeros(size), np.empty((size, size))
    impacts = 0
    for k in range(paths):
        mean[:] = 0.0
        cov = start.copy()
        unknown = 0.0
        since, folded, grazed, run = np.inf, 0.0, -1, 0
        for n in range(samples):
            struck = 0
            if n > 0:
                if learn and grazed >= 0:
                    marks.widened[k, n] = max(unknown - cov[1, 1], 0.0)
                if not learn or grazed >= 0:
                    cov[1, 1] += marks.widened[k, n]
                kept_mean[:] = mean
                kept[:] = cov
                on = grazed < 0 if learn else marks.walls[k, n]
                if nonlinear or (on and _meets(flow, fine, step / substeps, substeps, mean)):
                    grazing, struck, since, folded = _moved(
                        flow, series, fine, fine_random, step / substeps, substeps, on, learn, nonlinear, mean, cov,
                        room, since, folded,
                    )  # fmt: skip
                else:
                    grazing = -1
                    _apply(whole, random, mean, cov, room)
                    since += step
                impacts += struck
                if learn:
                    if grazed < 0:
                        marks.widened[k, n] = 0.0
                    reach = _NEAR * np.sqrt(cov[0, 0])
                    if on and struck == 0 and grazing < 0:
                        for w in range(flow.walls.shape[0]):  # it turned so near that it may have struck
                            at, side = flow.walls[w, 0], flow.walls[w, 1]
                            turned = side * kept_mean[1] < 0.0 < side * mean[1]
                            if run >= _LONGEST or (turned and side * (mean[0] - at) < reach):
                                grazing = w
                    if grazing >= 0:
                        grazed = grazing
                        j = n - 1  # the approach to it has no impact
                        while j > 0 and marks.kinds[k, j] == LEFT_OUT and (n - j) * step <= since:
                            marks.walls[k, j] = False
                            j -= 1
                        mean[:] = kept_mean
                        cov[:] = kept
                        unknown = _GRAZING**2 * cov[1, 1]
                        cov[1, 1] += unknown
                        marks.widened[k, n] = unknown
                        _moved(
                            flow, series, fine, fine_random, step / substeps, substeps, False, learn, nonlinear, mean,
                            cov, room, since, folded,
                        )  # fmt: skip
            kind = marks.kinds[k, n]
            if learn:
                kind = USED
                if grazed < 0:
                    deviation = np.sqrt(cov[0, 0])
                    for wall in flow.walls:
                        gap, speed = wall[1] * (mean[0] - wall[0]), wall[1] * mean[1]
                        if speed < 0.0 and gap < _NEAR * deviation:
                            kind = LEFT_OUT
                    if since < folded:
                        kind = LEFT_OUT
                    marks.walls[k, n] = struck > 0 or kind == LEFT_OUT or (n > 0 and marks.kinds[k, n - 1] == LEFT_OUT)
                else:
                    kind = DROPPED
                    marks.walls[k, n] = False
            row[:] = 0.0
            if seen < 2:
                row[seen] = 1.0
                level, more = mean[seen], noise
            else:
                level, more = 0.0, noise
                row[0], row[1] = -flow.stiffness, -flow.damping
                for j in range(2, size):
                    row[j] = -flow.weights[j - 2]
                for j in range(size):
                    level += row[j] * mean[j]
                if nonlinear:
                    force, by_x, by_v, rest = _force(flow, mean, cov)
                    level += force
                    row[0] += by_x
                    row[1] += by_v
                    more += rest
            variance = more
            for i in range(size):
                gain[i] = 0.0
                for j in range(size):
                    gain[i] += cov[i, j] * row[j]
                variance += row[i] * gain[i]
            error = values[k, n] - level
            if kind == DROPPED and learn:  # is the mass clear of the wall?
                wall = flow.walls[grazed]
                if seen == 1:
                    clear = wall[1] * (mean[1] + gain[1] / variance * error) > np.sqrt(flow.intensity * step)
                else:
                    place = mean[0] + gain[0] / variance * error
                    width = max(cov[0, 0] - gain[0] ** 2 / variance, 0.0)
                    clear = wall[1] * (place - wall[0]) > _NEAR * np.sqrt(width + flow.intensity * step**3)
                if clear:
                    kind, grazed, since = RESTART, -1, np.inf
            marks.kinds[k, n] = kind
            run = run + 1 if kind == LEFT_OUT else 0
            terms[k, n] = 0.0
            expected[k, n], spread[k, n] = level, np.sqrt(variance)
            if kind == USED:
                if not variance > 0.0:
                    terms[k, n] = -np.inf
                    return impacts
                terms[k, n] = -0.5 * (np.log(2.0 * np.pi * variance) + error * error / variance)
            if kind in (USED, RESTART):
                for i in range(size):
                    mean[i] += gain[i] * error / variance
                    for j in range(size):
                        cov[i, j] -= gain[i] * gain[j] / variance
                if kind == RESTART and seen == 0:
                    mean[1] = 0.0
                    cov[1, :] = 0.0
                    cov[:, 1] = 0.0
                    cov[1, 1] = restart
    return impacts


@njit(**_COMPILED)
def _meets(flow, fine, h, substeps, mean):  # type: ignore[no-untyped-def]
    """Whether the mean meets a wall within a step."""
    here = mean.copy()
    powers = np.empty((_TERMS + 1, mean.size))
    for _ in range(substeps):
        if _crossing(flow, here, h, powers)[0] >= 0:
            return True
        here = fine @ here
    return False


@njit(**_COMPILED)
def _moved(flow, series, fine, random, h, substeps, on, learn, nonlinear, mean, cov, room, since, folded):  # type: ignore[no-untyped-def]
    """Move the state by a step.

    Returns a wall that may not have been struck, or -1; impacts; the time since the last, and how long it folds.
    """
    size, struck = mean.size, 0
    powers = np.empty((_TERMS + 1, size))
    part, part_random = np.empty((size, size)), np.empty((size, size))
    for _ in range(substeps):
        if nonlinear:
            _kick(flow, 0.5 * h, mean, cov)
        left, count = h, 0
        while on and count < _MOST:
            which, tau = _crossing(flow, mean, left, powers)
            if which < 0:
                break
            wall = flow.walls[which]
            if tau > 0.0:
                _advance(series, tau, flow.intensity, part, part_random)
                _apply(part, part_random, mean, cov, room)
            if learn:
                slow = _GRAZING**2 * cov[1, 1] + 2.0 * _NEAR * abs(_pull(flow, wall, mean)) * np.sqrt(cov[0, 0])
                if mean[1] ** 2 < slow:
                    return which, struck, since, folded
            folded = _NEAR * np.sqrt(cov[0, 0]) / abs(mean[1])
            _strike(flow, wall, mean, cov)
            since = 0.0
            left -= tau
            count += 1
        struck += count
        if count == 0:
            _apply(fine, random, mean, cov, room)
        else:
            _advance(series, left, flow.intensity, part, part_random)
            _apply(part, part_random, mean, cov, room)
        since += left
        if nonlinear:
            _kick(flow, 0.5 * h, mean, cov)
    return -1, struck, since, folded


@njit(**_COMPILED)
def _pull(flow, wall, mean):  # type: ignore[no-untyped-def]
    """The force of springs and memory at a wall."""
    found = flow.stiffness * wall[0]
    for j in range(flow.weights.size):
        found += flow.weights[j] * mean[j + 2]
    return found


@njit(**_COMPILED)
def _series(flow, size):  # type: ignore[no-untyped-def]
    """A^k / k!"""
    found = np.zeros((_TERMS + 1, size, size))
    found[0] = np.eye(size)
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
def _advance(series, t, intensity, phi, random):  # type: ignore[no-untyped-def]
    """Phi(t) and Q(t)."""
    size = phi.shape[0]
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
                random[i, j] += intensity * t * _SHARES[g] * push[i] * push[j]


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
def _place(powers, t):  # type: ignore[no-untyped-def]
    """x and v of the mean at a time, from its series."""
    x, v = powers[_TERMS, 0], powers[_TERMS, 1]
    for k in range(_TERMS - 1, -1, -1):
        x, v = x * t + powers[k, 0], v * t + powers[k, 1]
    return x, v


@njit(**_COMPILED)
def _crossing(flow, mean, left, powers):  # type: ignore[no-untyped-def]
    """The wall that the mean meets first in the time that is left, and when; -1 if none."""
    size = mean.size
    powers[0] = mean
    for k in range(1, _TERMS + 1):
        powers[k, 0] = powers[k - 1, 1] / k
        pulled = flow.stiffness * powers[k - 1, 0] + flow.damping * powers[k - 1, 1]
        for i in range(2, size):
            pulled += flow.weights[i - 2] * powers[k - 1, i]
            powers[k, i] = (powers[k - 1, 1] - flow.rates[i - 2] * powers[k - 1, i]) / k
        powers[k, 1] = -pulled / k
    last_v = _place(powers, left)[1]
    which, first = -1, left
    for w in range(flow.walls.shape[0]):
        at, side = flow.walls[w, 0], flow.walls[w, 1]
        gap, speed = side * (mean[0] - at), side * mean[1]
        if gap <= 0.0:
            if speed < 0.0:
                return w, 0.0
            continue
        low, high = 0.0, left
        if speed * side * last_v < 0.0:  # it turns in between
            a, b = 0.0, left
            for _ in range(_HALVINGS):
                t = 0.5 * (a + b)
                if side * _place(powers, t)[1] * speed > 0.0:
                    a = t
                else:
                    b = t
            if speed < 0.0:
                high = b  # the lowest place
            else:
                low = a
        if side * (_place(powers, high)[0] - at) >= 0.0:
            continue
        for _ in range(_HALVINGS):
            t = 0.5 * (low + high)
            if side * (_place(powers, t)[0] - at) > 0.0:
                low = t
            else:
                high = t
        if high <= first:
            which, first = w, high
    return which, first


@njit(**_COMPILED)
def _strike(flow, wall, mean, cov):  # type: ignore[no-untyped-def]
    """The impact of the mean, and of the paths near it."""
    size, r = mean.size, wall[2]
    turn = -(1.0 + r) * _pull(flow, wall, mean) / mean[1]
    mean[0] = wall[0] - r * (mean[0] - wall[0])
    mean[1] = -r * mean[1]
    for j in range(size):
        x, v = cov[0, j], cov[1, j]
        cov[0, j], cov[1, j] = -r * x, turn * x - r * v
        for i in range(2, size):
            cov[i, j] -= (1.0 + r) * x
    for j in range(size):
        x, v = cov[j, 0], cov[j, 1]
        cov[j, 0], cov[j, 1] = -r * x, turn * x - r * v
        for i in range(2, size):
            cov[j, i] -= (1.0 + r) * x


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
def _kick(flow, t, mean, cov):  # type: ignore[no-untyped-def]
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
