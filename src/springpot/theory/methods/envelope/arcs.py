"""Cycles of the paper's problem in closed form: harmonic arcs between impacts, and sums over their harmonics.

Everything is dimensionless (time 1/Omega, length sqrt(q/Omega^3), so that q = 1).  A cycle is
x(t) = x_e + A cos(w t) for phases -p ... p: it strikes the wall at phase p < pi, or it is a whole cosine, p = pi.
Its cosine coefficients,
X_n = (A/p) (-1)^n 2 sin p / (1 - (n pi/p)^2), enter only through sums of n^gamma X_n^2, which have a closed form:
with u = (p/pi)^2 and y = sin p / (1 - u),

    sum_n n^gamma X_n^2 = (4 A^2 p^2 / pi^4) [y^2 + sin^2 p sum_{k>=0} (k+1) u^k (zeta(2k+4-gamma) - 1)],

whose terms fall like (u/4)^k: all harmonics are included.  A cycle is labelled by its height above the wall; cycles
below the grazing one have no impact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import special
from scipy.interpolate import CubicSpline

from springpot.machine.arrays import Floats
from springpot.theory.methods.envelope.cycles import Cycles, Problem
from springpot.theory.numerics.panels import Labels

_TERMS = 30  # of the series in u / 4: below 1e-16 at u = 1
SMALLEST_PHASE = 1e-10
_NEWTON_STEPS = 8
_STRIKING_PANELS = 9


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
class ArcFrequencies:
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


def arc_frequencies(order: float, stiffness: float) -> ArcFrequencies:
    """Tabulate the frequency of the cycles of one oscillator.

    Parameters
    ----------
    order, stiffness : float
        As in `ArcFrequencies`.

    Examples
    --------
    >>> cycles = arc_frequencies(0.5, 0.7)
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
    return ArcFrequencies(order, stiffness, p, CubicSpline(np.log(p), np.log(w)))


@lru_cache(maxsize=1)
def _phases() -> Floats:
    return np.concatenate([np.geomspace(SMALLEST_PHASE, 1.0, 220)[:-1], np.linspace(1.0, math.pi, 240)])


@dataclass(frozen=True)
class Heights(Labels):
    """Labels of arcs: A over that of the grazing cycle, less 1, in [-1, 0] without impacts; the square root of the
    height above grazing with them.

    Parameters
    ----------
    clear : int
        Number of panels without impacts, which come first.
    clear_amplitude : float
        A at the end of the cycles without impacts: the grazing amplitude, or the largest of interest; 0 if every cycle
        has impacts.
    """

    clear: int
    clear_amplitude: float


@dataclass(frozen=True)
class Arcs(Cycles):
    """Cycles x = centre + amplitude cos(w t) for phases from -phase to phase, with the impact speed.

    Phase pi, and no speed, is a cycle without impacts.
    """

    phase: Floats
    amplitude: Floats
    centre: Floats
    speed: Floats

    @property
    def w(self) -> Floats:
        """Frequency of the arcs."""
        return np.sqrt(self.arc)

    def sum_of(self, power: float) -> Floats:
        return self.amplitude**2 * harmonic_sum(self.phase, power)

    def speed_at(self, problem: Problem, place: float) -> Floats:
        return self.speed

    def path(self, problem: Problem, part: Floats) -> tuple[Floats, Floats]:
        s, a = self.phase[:, None] * part, self.amplitude[:, None]
        return self.centre[:, None] + a * np.cos(s), self.w[:, None] * a * np.sin(s)


def arcs_up_to(problem: Problem, reach: float) -> tuple[Heights, Arcs]:
    """The arcs of the paper's problem with amplitudes up to about ``reach``, in the mean field of the problem."""
    wall, k0, m = problem.potential.low, problem.field.slow_stiffness, problem.field.about
    rest = k0 / (1.0 + k0) * m  # position of rest without impacts
    labels = _heights(rest - wall, reach)
    first = labels.clear * labels.nodes.shape[1]  # the first node of a striking cycle
    p, a, w = arcs_at(problem, labels, labels.nodes.ravel(), first)
    bulge = a * np.sinc(p / math.pi) * w * w
    bulge[:first] = 0.0
    mean = (bulge + k0 * m) / (1.0 + k0)
    centre = mean - a * np.sinc(p / math.pi)
    centre[:first] = rest
    speed = w * a * np.sin(p)
    speed[:first] = math.nan
    return labels, Arcs(
        period=2.0 * p / w,
        mean=mean,
        x_square=mean**2 + a * a * harmonic_sum(p, 0.0) / 2.0,
        v_square=0.5 * (w * a) ** 2 * missing_sinc(2.0 * p),
        arc=w * w,
        phase=p,
        amplitude=a,
        centre=centre,
        speed=speed,
    )


def arcs_at(problem: Problem, labels: Heights, label: Floats, first: int) -> tuple[Floats, Floats, Floats]:
    """Phase, amplitude and frequency of the arcs with these labels; the first ones are without impacts."""
    k0, (order, stiffness) = problem.field.slow_stiffness, (1.0, 0.0)
    for springpot in problem.springpots:
        order, stiffness = springpot.order, problem.in_phase(springpot)
    frequencies = arc_frequencies(order, stiffness)
    slow_share, p, a = k0 / (1.0 + k0), np.full(label.size, math.pi), np.empty(label.size)
    a[:first] = labels.clear_amplitude * (1.0 + label[:first])
    if first < label.size:
        above_rest = problem.potential.low - slow_share * problem.field.about
        height = 2.0 * labels.clear_amplitude + label[first:] ** 2
        p[first:] = frequencies.phase_at(np.maximum(above_rest / height, -0.5), slow_share)
        a[first:] = height / (2.0 * np.sin(p[first:] / 2.0) ** 2)
    return p, a, frequencies.frequency(p)


def missing_sinc(angle: Floats) -> Floats:
    """1 - sin(angle) / angle, without cancellation."""
    small = angle**2 / 6.0 * (1.0 - angle**2 / 20.0)
    return np.where(angle < 0.01, small, 1.0 - np.sinc(angle / math.pi))


def _heights(clearance: float, reach: float) -> Heights:
    """Panels for cycles up to about ``reach``; ``clearance`` is the grazing amplitude, negative for a preload."""
    clear = np.zeros(0)
    amplitude = 0.0
    if clearance > 0.0:
        amplitude = min(clearance, reach)
        wide = amplitude > 0.2 * reach
        clear = np.array([-1.0, -0.9, -0.8, -0.7, -0.55, -0.33] if wide else [-1.0, -0.6])
    if clearance >= reach:
        return Heights(np.r_[clear, 0.0], clear.size, amplitude)
    largest = math.sqrt(max(reach - clearance, 0.3 * reach) if clearance > 0.0 else reach)
    smallest = max(0.35 * math.sqrt(2.0 * max(clearance, 0.0)), largest * 0.5 ** (_STRIKING_PANELS - 1))
    strike = np.geomspace(min(smallest, 0.3 * largest), largest, _STRIKING_PANELS)
    return Heights(np.r_[clear, 0.0, strike], clear.size, amplitude)
