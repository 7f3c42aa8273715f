"""The oscillator without a wall, exactly: moments, impulse response and correlation by contour integration.

Everything here is dimensionless: x'' + c D^alpha x + x = white noise of intensity 1.  The transfer function
G(s) = 1 / (s^2 + c s^alpha + 1), cut along the negative real axis, has one pair of poles for 0 < alpha < 1, both in the
left half plane.  Since 1 / \\|D\\|^2 = -Im(1 / D) / Im(D) on the imaginary axis, the integral of the spectrum can be
turned onto the positive real axis, where there is no resonance, and its Fourier transform onto the cut, where the
integrand does not oscillate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from springpot.machine.arrays import Complexes, Floats
from springpot.theory.numerics.panels import on_panels

_STEP = 0.2  # of ln s: the integrands are analytic for \|Im ln s\| < pi/2, so the trapezoid rule errs by e^(-pi^2/0.2)
_DECADES = 42.0  # e^-42 is below rounding
_NODES = 14  # of one panel on the cut
_CHUNK = 256  # times handled at once


def mean_squares(alpha: float, c: float) -> tuple[float, float]:
    """Stationary <x^2> and <v^2> for alpha in (0, 1] and c > 0, to rounding.

    With t = tan((1 - alpha) pi / 2) the turned integrals are

        <x^2> = t / ((1 - alpha) pi c) int_0^inf s^-alpha (2 s^2 + alpha c s^alpha) G(s)^2 ds,
        <v^2> = <x^2> + (t / pi) int_0^inf G(s) ds;

    both integrands are positive and smooth in ln s for every c.

    Examples
    --------
    >>> x, v = mean_squares(1.0, 0.2)
    >>> round(x, 12), round(v, 12)
    (2.5, 2.5)
    """
    low, high = _range(alpha, c)
    u = np.arange(low, high, _STEP)
    log_c = math.log(c)
    springpot = log_c + alpha * u
    log_g = -np.logaddexp(np.logaddexp(2.0 * u, springpot), 0.0)
    slope = np.logaddexp(2.0 * u + math.log(2.0), springpot + math.log(alpha))
    first = float(np.sum(np.exp((1.0 - alpha) * u + slope + 2.0 * log_g - log_c))) * _STEP
    second = float(np.sum(np.exp(u + log_g))) * _STEP
    tangent = math.tan((1.0 - alpha) * math.pi / 2.0)
    ratio = tangent / (1.0 - alpha) if alpha < 1.0 else math.pi / 2.0
    x_mean_square = ratio * first / math.pi
    return x_mean_square, x_mean_square + tangent * second / math.pi


def dashpot_motion(c: float, time: Floats) -> tuple[Floats, Floats, Floats]:
    """Displacement and speed after a unit kick, and displacement after a unit displacement, for alpha = 1, c >= 0.

    Examples
    --------
    >>> [float(part.round(4)) for part in dashpot_motion(2.0, np.array(1.0))]
    [0.3679, 0.0, 0.7358]
    """
    half = c / 2.0
    # e^(-ct/2) cos wt and e^(-ct/2) sin(wt) / w with w^2 = 1 - c^2/4
    if half < 1.0:
        frequency = math.sqrt((1.0 - half) * (1.0 + half))
        decay = np.exp(-half * time)
        cosine = decay * np.cos(frequency * time)
        sine = decay * time * np.sinc(frequency * time / math.pi)
    else:
        split = math.sqrt((half - 1.0) * (half + 1.0))
        slow, gap = np.exp(-time / (half + split)), -2.0 * split * time
        cosine = slow * (1.0 + np.exp(gap)) / 2.0
        # (1 - e^-2kt) / 2k, t where k = 0
        sine = slow * (-np.expm1(gap) / (2.0 * split) if split > 0.0 else time)
    return sine, cosine - half * sine, cosine + half * sine


def dashpot_mean_squares(c: float, time: Floats) -> tuple[Floats, Floats]:
    """<x^2> and <v^2> of the oscillator with a dashpot (alpha = 1, c >= 0) at times from rest, in closed form.

    Examples
    --------
    >>> x, v = dashpot_mean_squares(0.0, np.array([2.0]))
    >>> bool(abs(x + v - 2.0) < 1e-15)
    True
    """
    kick, rate, hold = dashpot_motion(c, time)
    grown = _saturating(c, time) / 2.0
    return grown - kick * hold / 2.0, grown + kick * rate / 2.0


def free_spectrum(alpha: float, c: float, w: Floats) -> Floats:
    """Two-sided spectrum of x, 1 / (2 pi \\|1 - w^2 + c (iw)^alpha\\|^2), at frequencies w >= 0.

    Examples
    --------
    >>> round(float(free_spectrum(1.0, 0.5, np.array(1.0))) * 2.0 * math.pi, 12)
    4.0
    """
    element = c * w**alpha
    real = (1.0 - w) * (1.0 + w) + element * math.sin((1.0 - alpha) * math.pi / 2.0)
    imaginary = element * math.sin(alpha * math.pi / 2.0)
    return np.asarray(1.0 / (2.0 * math.pi * (real**2 + imaginary**2)))


@dataclass(frozen=True)
class Relaxation:
    """Impulse response and correlation for 0 < alpha < 1 as one decaying oscillation and many decaying exponentials.

    Parameters
    ----------
    pole : complex
        The pole of G in the second quadrant.
    residue : complex
        Of G there: the impulse response is h(t) = 2 Re[residue e^(pole t)] + sum response_j e^(-rate_j t).
    strength : complex
        The correlation is Re[strength e^(pole t)] + sum memory_j e^(-rate_j t).
    rate, response, memory : ndarray
        Nodes and weights of the integrals along the cut; all positive.

    Notes
    -----
    Accurate to 1e-10 of the stationary value, but for alpha within 1e-6 of 1 at critical damping (c = 2), where pole
    and cut nearly cancel: 1e-9 at alpha = 1 - 1e-6, 2e-6 at 1 - 1e-7.
    """

    pole: complex
    residue: complex
    strength: complex
    rate: Floats
    response: Floats
    memory: Floats

    def impulse_response(self, time: Floats) -> Floats:
        """h(t), the displacement after a unit kick at t = 0."""
        return np.asarray(2.0 * (self.residue * np.exp(self.pole * time)).real + self._decay(self.response, time))

    def correlation(self, lag: Floats) -> Floats:
        """<x(t) x(t + lag)> for lag >= 0 in the stationary state."""
        return np.asarray((self.strength * np.exp(self.pole * lag)).real + self._decay(self.memory, lag))

    def mean_squares(self, time: Floats) -> tuple[Floats, Floats]:
        """<x^2> and <v^2> at times from rest: the integrals of h^2 and h'^2, term by term in closed form."""
        x = self._energy(time, self.residue, self.response)
        return x, self._energy(time, self.residue * self.pole, -self.response * self.rate)

    def _decay(self, weight: Floats, time: Floats) -> Floats:
        total = np.empty(time.size)
        flat = time.reshape(-1)
        for start in range(0, flat.size, _CHUNK):
            part = slice(start, start + _CHUNK)
            total[part] = _fade(flat[part], self.rate) @ weight
        return total.reshape(time.shape)

    def _energy(self, time: Floats, residue: complex, weight: Floats) -> Floats:
        """int_0^t (2 Re[residue e^(ps)] + sum weight_j e^(-rate_j s))^2 ds."""
        p, rate = self.pole, self.rate
        pair = weight / (rate[:, None] + rate)  # of two exponentials
        everything = float(weight @ pair.sum(axis=1))
        cross = residue * weight / (rate - p)
        flat = time.reshape(-1)
        decay = -2.0 * p.real
        total = 2.0 * abs(residue) ** 2 * _saturating(decay, flat)
        # (1 - e^2pt) / 2p is of the size of one oscillation, so cancellation is harmless
        total -= (residue**2 * (1.0 - np.exp(2.0 * p * flat)) / p).real
        for start in range(0, flat.size, _CHUNK):
            part = slice(start, start + _CHUNK)
            fade = _fade(flat[part], rate)
            left = fade * weight
            total[part] += everything - np.einsum("ij,ij->i", left @ pair, fade)
            total[part] += 4.0 * (cross.sum() - np.exp(p * flat[part]) * (fade @ cross)).real
        return np.maximum(total, 0.0).reshape(time.shape)


@lru_cache(maxsize=16)
def relaxation(alpha: float, c: float) -> Relaxation:
    """Pole and cut of G for 0 < alpha < 1 and c > 0.

    Examples
    --------
    >>> h = relaxation(0.5, 1.0).impulse_response(np.array([0.0, 1e-3]))
    >>> bool(abs(h[0]) < 1e-13), round(float(h[1]) / 1e-3, 4)
    (True, 1.0)
    """
    pole = _pole(alpha, c)
    residue = 1.0 / (2.0 * pole + alpha * c * pole ** (alpha - 1.0))
    strength = 1j * residue / (c * math.sin(alpha * math.pi / 2.0) * (-1j * pole) ** alpha)
    u, weight = _cut_rule(alpha, c)
    y = np.exp(u)
    density = c * math.sin(math.pi * alpha) / math.pi * weight * np.exp((1.0 + alpha) * u)
    response = density / np.abs(_below(y, alpha, c)) ** 2
    memory = response / (y * y + c * y**alpha + 1.0)
    fast = response * np.maximum(y, 1.0)
    kept = (fast > 1e-17 * float(np.max(fast))) | (memory > 1e-17 * float(np.max(memory)))
    return Relaxation(pole, residue, strength, y[kept], response[kept], memory[kept])


def _saturating(decay: float, time: Floats) -> Floats:
    """(1 - e^(-decay t)) / decay, which is t for decay = 0."""
    if decay == 0.0:
        return time + 0.0
    return np.asarray(-np.expm1(-decay * time) / decay)


def _fade(time: Floats, rate: Floats) -> Floats:
    """e^(-rate t), a row for each time; logarithms avoid overflow."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(-np.exp(np.minimum(np.add.outer(np.log(time), np.log(rate)), 7.0))))


def _range(alpha: float, c: float) -> tuple[float, float]:
    """Limits of ln s beyond which the integrands are below rounding."""
    log_c = math.log(c)
    # Between s^alpha = 1/c and s^2 = c s^alpha the springpot dominates and the integrands vary like s^(1-2 alpha) or
    # s^(1-alpha): where they grow, their lower part is negligible.
    low = min(0.0, max(-log_c / alpha, -_DECADES / (1.0 - 2.0 * alpha)) if alpha < 0.5 else -log_c / alpha)
    return low - _DECADES, max(0.0, log_c / (2.0 - alpha)) + _DECADES


def _below(y: Floats, alpha: float, c: float) -> Complexes:
    """1 / G on the cut, at s = y e^(i pi)."""
    turn = complex(-math.cos(math.pi * (1.0 - alpha)), math.sin(math.pi * (1.0 - alpha)))
    return np.asarray(y * y + 1.0 + c * y**alpha * turn)


def _cut_rule(alpha: float, c: float) -> tuple[Floats, Floats]:
    """Nodes and weights in ln y: Gauss panels, halved until none is wide against its distance from a zero of 1 / G."""
    low, high = _range(alpha, c)
    edges = np.linspace(low, high, math.ceil((high - low) / 2.0) + 1)
    left, right = edges[:-1], edges[1:]
    turn = c * np.exp(1j * math.pi * alpha)
    done_left: list[Floats] = []
    done_right: list[Floats] = []
    for _ in range(60):
        half = (right - left) / 2.0
        y = np.exp((left + half)[:, None] + half[:, None] * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
        slope = 2.0 * y * y + alpha * turn * y**alpha
        distance = np.min(np.abs(_below(y, alpha, c)) / np.abs(slope), axis=1)  # Newton's step to the zero
        fine = (half <= 0.8 * distance) | (half < 1e-14)
        done_left.append(left[fine])
        done_right.append(right[fine])
        middle = (left + half)[~fine]
        left, right = np.concatenate([left[~fine], middle]), np.concatenate([middle, right[~fine]])
        if left.size == 0:
            break
    start, end = np.concatenate([*done_left, left]), np.concatenate([*done_right, right])
    nodes, weights = on_panels(start, end, _NODES)
    return nodes.ravel(), weights.ravel()


def _pole(alpha: float, c: float) -> complex:
    """Root of s^2 + c s^alpha + 1 in the second quadrant; the fixed point contracts by about alpha / 2, then Newton."""
    s = c ** (1.0 / (2.0 - alpha)) * np.exp(1j * math.pi / (2.0 - alpha)) + 1j
    for _ in range(30):
        s = 1j * np.sqrt(c * s**alpha + 1.0)
    from scipy import optimize  # slow to import, and most runs need none of it

    root = optimize.newton(
        lambda s: s * s + c * s**alpha + 1.0, s, lambda s: 2.0 * s + alpha * c * s ** (alpha - 1.0),
        tol=1e-300, rtol=1e-15, disp=False,
    )  # fmt: skip
    return complex(root)
