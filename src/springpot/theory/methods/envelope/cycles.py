"""Cycles of the envelope: harmonic arcs between impacts, and sums over their harmonics.

Everything is dimensionless (time 1/Omega, length sqrt(q/Omega^3)).  A cycle is x(t) = x_e + A cos(w t) for phases
-p ... p: it strikes the wall at phase p < pi, or it is a whole cosine, p = pi.  Its cosine coefficients,
X_n = (A/p) (-1)^n 2 sin p / (1 - (n pi/p)^2), enter only through sums of n^gamma X_n^2, which have a closed form:
with u = (p/pi)^2 and y = sin p / (1 - u),

    sum_n n^gamma X_n^2 = (4 A^2 p^2 / pi^4) [y^2 + sin^2 p sum_{k>=0} (k+1) u^k (zeta(2k+4-gamma) - 1)],

whose terms fall like (u/4)^k: all harmonics are included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import special
from scipy.interpolate import CubicSpline

from springpot.machine.arrays import Floats

_TERMS = 30  # of the series in u / 4: below 1e-16 at u = 1
SMALLEST_PHASE = 1e-10
_NEWTON_STEPS = 8


@lru_cache(maxsize=64)
def _series(gamma: float) -> Floats:
    """Coefficients of the series in u, highest power first."""
    k = np.arange(_TERMS)
    return np.asarray(((k + 1.0) * (special.zeta(2.0 * k + 4.0 - gamma, 2.0)))[::-1])


def harmonic_sum(phase: Floats, gamma: float) -> Floats:
    """sum_n n^gamma X_n^2 for amplitude 1.

    Parameters
    ----------
    phase : ndarray
        p in (0, pi].
    gamma : float
        Below 3, where the sum converges.

    Examples
    --------
    >>> p = np.array([math.pi / 2.0, math.pi])  # half a period, and a whole one
    >>> harmonic_sum(p, 2.0).round(12)  # 2 <v^2> / w1^2: 1/4 at p = pi/2, where w1 is twice the frequency
    array([0.25, 1.  ])
    """
    u = (phase / math.pi) ** 2
    # sin p / (1 - u) without the 0/0 of a whole cosine
    y = math.pi * np.sinc(1.0 - phase / math.pi) / (1.0 + phase / math.pi)
    rest = np.sin(phase) ** 2 * np.polyval(_series(gamma), u)
    return np.asarray(4.0 * phase**2 / math.pi**4 * (y * y + rest))


@dataclass(frozen=True)
class Cycles:
    """The frequency of a cycle as a function of its phase, with the springpot's stiffness in it.

    The in-phase force of the springpot is that of a spring about the cycle's mean,
    k1 = stiffness (pi w/p)^order sum n^order X_n^2 / sum X_n^2, and w^2 = 1 + k1.

    Parameters
    ----------
    order : float
        alpha.
    stiffness : float
        Effective c cos(alpha pi/2) of a harmonic at frequency 1.
    phases : ndarray
        Phases of the table, rising to pi.
    log_frequency : CubicSpline
        ln w as a function of ln p.
    """

    order: float
    stiffness: float
    phases: Floats
    log_frequency: CubicSpline

    def frequency(self, phase: Floats) -> Floats:
        """w of cycles with these phases."""
        return np.asarray(np.exp(self.log_frequency(np.log(phase))))

    def phase_at(self, ratio: Floats, slow_share: float) -> Floats:
        """Phase p of the cycles that rise to a height h above the wall, by Newton's method from the table.

        Parameters
        ----------
        ratio : ndarray
            (b - x_rest) / h, at least -1/2 (grazing); x_rest is the position of rest without impacts.
        slow_share : float
            k0 / (1 + k0) of the slow stiffness k0.
        """
        table, _ = self._ratio(self.phases, slow_share)
        # the table falls from +infinity to -1/2 as the phase grows
        order = np.argsort(-table, kind="stable")
        p = np.interp(-np.arcsinh(ratio), -np.arcsinh(table[order]), self.phases[order])
        for _ in range(_NEWTON_STEPS):
            value, slope = self._ratio(p, slow_share)
            step = np.divide(value - ratio, slope, out=np.zeros_like(p), where=np.abs(slope) > 1e-12)
            p = np.clip(p - step, 0.5 * p, np.minimum(2.0 * p, math.pi))
        return p

    def _ratio(self, phase: Floats, slow_share: float) -> tuple[Floats, Floats]:
        """(b - x_rest) / h as a function of the phase, and its derivative."""
        log_phase = np.log(phase)
        w = np.exp(self.log_frequency(log_phase))
        slope_w = w * self.log_frequency(log_phase, 1) / phase
        stiffness = w * w - 1.0 - slow_share * w * w
        mean = np.sinc(phase / math.pi)
        slope_mean = (np.cos(phase) - mean) / phase
        height = 2.0 * np.sin(phase / 2.0) ** 2
        top = np.cos(phase) + stiffness * mean
        slope = -np.sin(phase) + 2.0 * w * slope_w * (1.0 - slow_share) * mean + stiffness * slope_mean
        return np.asarray(top / height), np.asarray((slope - top * np.sin(phase) / height) / height)


def make_cycles(order: float, stiffness: float) -> Cycles:
    """Tabulate the frequency of the cycles of one oscillator.

    Parameters
    ----------
    order, stiffness : float
        As in `Cycles`.

    Examples
    --------
    >>> cycles = make_cycles(0.5, 0.7)
    >>> bool(abs(cycles.frequency(np.array([math.pi])) ** 2 - 1.0 - 0.7 * cycles.frequency(np.array([math.pi])) ** 0.5)
    ...      < 1e-12)
    True
    """
    p = _phases()
    share = stiffness * (math.pi / p) ** order * harmonic_sum(p, order) / harmonic_sum(p, 0.0)
    w = np.sqrt(1.0 + share) + share ** (1.0 / (2.0 - order))  # above the root of a convex function: Newton is monotone
    for _ in range(60):
        step = (w * w - 1.0 - share * w**order) / (2.0 * w - order * share * w ** (order - 1.0))
        w = w - step
        if np.all(np.abs(step) <= 1e-15 * w):
            break
    return Cycles(order, stiffness, p, CubicSpline(np.log(p), np.log(w)))


@lru_cache(maxsize=1)
def _phases() -> Floats:
    return np.concatenate([np.geomspace(SMALLEST_PHASE, 1.0, 220)[:-1], np.linspace(1.0, math.pi, 240)])
