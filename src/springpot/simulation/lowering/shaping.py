"""The shaping filter of a noise with a given spectral density: a rational density, fitted to the table.

The noise is white noise through second-order sections in a row, whose density is

    S(f) = exp(c) f^4 prod_z |f_z, zeta_z| / prod_p |f_p, zeta_p|,   |g, zeta| = (g^2 - f^2)^2 + 4 zeta^2 g^2 f^2.

The fit is one of log S, by Levenberg and Marquardt's method: elliptic filters at the two ends of the band, and a
section more wherever the density is farthest from the table, until it is near enough.  In a tenth of the frequency on
either side of an end the density passes from the table to 0; there only its area is kept.  All sections have poles of
their own, so that the filter is also a sum of them, which the kernel advances side by side, driven by one normal in
each step (`springpot.simulation.lowering.filters`).  The fit depends on the table alone, not on the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts import SpectralExcitation
from springpot.problem.system import System
from springpot.simulation.lowering.sources import Filter

EDGE = 0.1  # relative width of a band's end, and of a narrow band in its logarithm
WINDOW = 0.4  # of that width, over which densities are averaged before they are compared: no resonance is narrower
NEAR, RMS = 0.01, 0.002  # the fit is good: worst and root mean square error within the band
FAR = 0.03  # largest error that is accepted
MOST = 24  # sections
_SECTIONS = 4  # of an elliptic filter at an end of the band
_STOP = 4.5 * math.log(10.0)  # of the logarithm of the density beyond an end, 45 dB; it falls further
_FALL = 2.0
_OUTSIDE = 0.03  # weight of what is outside
_UNIT = 0.01  # an error of the logarithm that counts as 1
_ROUNDS, _CALM, _GAIN = 300, 3, 1e-4
_LEAST = 0.1  # damping ratio, over the width of an end: nothing narrow hides between the points of the fit
_MOST_DAMPED, _ZERO = math.log(0.97), 1.5  # logarithms of damping ratios
_BEYOND = 6.0  # logarithms of frequencies, from the ends
_DIGITS = 9
_GRID = 40_001  # frequencies of `moments_off`
FLOOR = 1e-8  # of the variance of an impulse, as white noise: without it the law of impulses is ill-conditioned


@dataclass(frozen=True, eq=False)
class Shape:
    """A rational density.

    Attributes
    ----------
    zeros, poles : ndarray, shape (sections, 2)
        Logarithms of the frequencies in Hz and of the damping ratios.
    gain : float
        Logarithm of the factor: the density is that of the table over its largest value.
    worst, rms : float
        Error of the density within the band.
    at : float
        Frequency of the worst, in Hz.
    """

    zeros: Floats
    poles: Floats
    gain: float
    worst: float
    rms: float
    at: float

    def density(self, f: Floats) -> Floats:
        """The one-sided density over the largest of the table."""
        return np.asarray(np.exp(_logarithm(self.zeros, self.poles, self.gain, np.log(f))[0]))


def shape_of(part: SpectralExcitation, name: str) -> Shape:
    """The shaping filter of a noise, whatever its size.

    Raises
    ------
    ValueError
        If the table is too ragged for a filter of so many sections; the sentence says where, and what to do.

    Examples
    --------
    >>> band = shape_of(SpectralExcitation((10.0, 2000.0), (1.0, 1.0)), "band")
    >>> len(band.poles), bool(band.worst < 0.01)
    (8, True)
    """
    largest = max(part.psd)
    found = _fitted(part.frequency, tuple(round(math.log(value / largest), _DIGITS) for value in part.psd))
    if not found.worst <= FAR:
        raise ValueError(
            f"{name} has a density that no filter of {MOST} sections follows: at {found.at:.4g} Hz it is off by "
            f"{100.0 * found.worst:.2g} %. Thin the table to the points that matter, as from_file "
            "does with tolerance=0.05 or more."
        )
    return found


def filter_of(shape: Shape, intensity: float, turn: float) -> Filter:
    """The filter of white noise, as the sum of its sections.

    Parameters
    ----------
    shape : Shape
    intensity : float
        Of the white noise before the filter, in a step: half the table's largest density.
    turn : float
        Radians in a step at 1 Hz.

    Examples
    --------
    >>> band = shape_of(SpectralExcitation((10.0, 2000.0), (1.0, 1.0)), "band")
    >>> found = filter_of(band, 1.0, 0.001)
    >>> driven = np.sqrt(found.noise.diagonal())
    >>> response = found.output @ np.linalg.solve(0.1j * np.eye(16) - found.matrix, driven)  # at 100 Hz
    >>> bool(abs(abs(response) ** 2 - 1.0) < 0.005)
    True
    """
    (f, zeta), (g, eta) = np.exp(shape.poles.T), np.exp(shape.zeros.T)
    poles = f * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    residues = np.empty(len(f), complex)
    for n, s in enumerate(poles):  # in logarithms: the products of so many would overflow
        others = np.arange(len(f)) != n
        above = np.log(s * s + 2.0 * eta * g * s + g * g).sum() + 2.0 * np.log(s)
        below = np.log(s * s + 2.0 * (zeta * f)[others] * s + f[others] ** 2).sum() + np.log(s - s.conjugate())
        residues[n] = np.exp(above - below + 0.5 * shape.gain)
    size, w = 2 * len(f), turn * f
    matrix, even, odd = np.zeros((size, size)), np.arange(0, size, 2), np.arange(1, size, 2)
    matrix[even, odd], matrix[odd, even], matrix[odd, odd] = w, -w, -2.0 * zeta * w  # of w u and u'
    output, driven = np.empty(size), np.zeros(size)
    output[even], output[odd] = -2.0 * (residues * poles.conj()).real / f**2, 2.0 * residues.real / f
    driven[odd] = w
    return Filter(matrix, intensity * np.outer(driven, driven), output)


def moments_off(part: SpectralExcitation, shape: Shape, unit: System, stiffness: float) -> tuple[float, float]:
    """By which shares the filter changes the mean squares of x and v of a linear system.

    Parameters
    ----------
    part : SpectralExcitation
    shape : Shape
        Its filter.
    unit : System
        One mass, per unit mass; of its parts the linear dampers and memory count.
    stiffness : float
        Of its springs.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot
    >>> band = SpectralExcitation((10.0, 2000.0), (1.0, 1.0))
    >>> max(map(abs, moments_off(band, shape_of(band, "band"), System(Dashpot(30.0)), 1e5))) < 1e-3  # at 50 Hz
    True
    """
    w0 = math.sqrt(stiffness)
    ends = np.log([part.frequency[0] / 30.0, part.frequency[-1] * 30.0, w0 / 60.0, w0 / 0.6])
    u = np.linspace(ends.min(), ends.max(), _GRID)
    w = 2.0 * np.pi * np.exp(u)
    loss = sum(each.modulus(1j * w) for each in unit.parts if "damping" in each.powers and each.is_linear)
    response = np.exp(u) / np.abs(stiffness - w**2 + loss) ** 2
    inside = (u >= math.log(part.frequency[0])) & (u <= math.log(part.frequency[-1]))
    table = np.exp(np.interp(u, np.log(part.frequency), np.log(part.psd))) * inside / max(part.psd)
    fitted = shape.density(np.exp(u))
    x, v = ((fitted * response) @ k / ((table * response) @ k) - 1.0 for k in (np.ones_like(w), w**2))
    return float(x), float(v)


def _logarithm(zeros: Floats, poles: Floats, gain: float, u: Floats) -> tuple[Floats, Floats]:
    """The logarithm of the density at logarithms of frequencies, and its derivatives by all parameters."""
    above, by_zeros = _sections(zeros, u)
    below, by_poles = _sections(poles, u)
    slopes = np.concatenate([by_zeros, -by_poles, np.ones((1, len(u)))])
    return above - below + 4.0 * u + gain, slopes


def _sections(sections: Floats, u: Floats) -> tuple[Floats, Floats]:
    log_f, squared = sections[:, :1], 4.0 * np.exp(2.0 * sections[:, 1:])
    ratio = np.exp(2.0 * (u - log_f))
    size = (1.0 - ratio) ** 2 + squared * ratio
    by_f, by_zeta = 4.0 - 2.0 * ratio * (2.0 * ratio - 2.0 + squared) / size, 2.0 * squared * ratio / size
    whole = (np.log(size) + 4.0 * log_f).sum(axis=0)
    return whole, np.stack([by_f, by_zeta], axis=1).reshape(-1, len(u))


class _Table:
    """A table in logarithms, and how far a rational density is from it."""

    def __init__(self, u: Floats, log_psd: Floats) -> None:
        low, high = float(u[0]), float(u[-1])
        edge = min(math.log1p(EDGE), EDGE * (high - low))
        near, far = edge * np.geomspace(1.0, 20.0, 24), edge * np.geomspace(1.0, 60.0, 30)
        self.u, self.log_psd, self.ends, self.edge = u, log_psd, (low, high), edge
        between = 3 if len(u) <= 50 else 1  # points within each piece of the table
        self.at = self._inside(
            np.linspace(low + edge, high - edge, 300), low + near, high - near, self._points(between)
        )
        self.wanted = np.interp(self.at, u, log_psd)
        self.dense = self._inside(np.linspace(low + edge, high - edge, 3000), self._points(7))
        self.averages = self._averaged(np.exp(np.interp(self.dense, u, log_psd)))
        spacing = np.gradient(self.at)
        self.weight = np.sqrt(spacing / spacing.mean())
        self.outside = np.concatenate([low - far, high + far])
        self.allowed = np.concatenate([log_psd[0] - _STOP - _FALL * far, log_psd[-1] - _STOP - _FALL * far])
        self.strips = [np.linspace(low - 4.0 * edge, low + edge, 60), np.linspace(high - edge, high + 4.0 * edge, 60)]
        self.areas = [self._area(low, low + edge), self._area(high - edge, high)]

    def _points(self, between: int) -> Floats:
        """The table's points, and so many between each two."""
        places = np.arange(0.0, len(self.u) - 1.0, 1.0 / (between + 1))
        return np.asarray(np.interp(places, np.arange(len(self.u)), self.u))

    def _inside(self, *at: Floats) -> Floats:
        """Those within the band, without its ends."""
        low, high = self.ends
        whole, edge = np.unique(np.concatenate(at)), self.edge * (1.0 - 1e-9)
        return whole[(whole >= low + edge) & (whole <= high - edge)]

    def _area(self, low: float, high: float) -> float:
        u = np.linspace(low, high, 400)
        return float(np.trapezoid(np.exp(np.interp(u, self.u, self.log_psd) + u), u))

    def residuals(self, zeros: Floats, poles: Floats, gain: float) -> tuple[Floats, Floats]:
        """What the squares are summed of, and its derivatives."""
        inside, by_inside = _logarithm(zeros, poles, gain, self.at)
        outside, by_outside = _logarithm(zeros, poles, gain, self.outside)
        above = _OUTSIDE * (outside > self.allowed)
        values = [self.weight * (inside - self.wanted), above * (outside - self.allowed)]
        slopes = [self.weight * by_inside, above * by_outside]
        for u, area in zip(self.strips, self.areas, strict=True):
            there, by_there = _logarithm(zeros, poles, gain, u)
            share = np.exp(np.minimum(there, 30.0) + u) / area
            values.append(np.array([np.trapezoid(share, u) - 1.0]))
            slopes.append(np.asarray(np.trapezoid(share * by_there, u))[:, None])
        return np.concatenate(values) / _UNIT, np.concatenate(slopes, axis=1) / _UNIT

    def errors(self, zeros: Floats, poles: Floats, gain: float) -> Floats:
        """Of the logarithm of the density, averaged over a window, at more points than it is fitted at."""
        return np.asarray(np.log(self._averaged(np.exp(_logarithm(zeros, poles, gain, self.dense)[0])) / self.averages))

    def _averaged(self, density: Floats) -> Floats:
        pieces = 0.5 * (density[1:] + density[:-1]) * np.diff(self.dense)
        whole, half = np.concatenate([[0.0], np.cumsum(pieces)]), 0.5 * WINDOW * self.edge
        above, below = (np.interp(self.dense + side, self.dense, whole) for side in (half, -half))
        return np.asarray(above - below)


@lru_cache(maxsize=64)
def _fitted(frequency: tuple[float, ...], log_psd: tuple[float, ...]) -> Shape:
    table = _Table(np.log(frequency), np.array(log_psd))
    zeros, poles = _ends(*table.ends)
    while True:
        zeros, poles, gain = _least_squares(table, zeros, poles)
        errors = table.errors(zeros, poles, gain)
        worst, place = float(np.abs(np.expm1(errors)).max()), int(np.abs(errors).argmax())
        rms = float(np.sqrt(np.average(errors**2, weights=np.gradient(table.dense))))
        if (worst <= NEAR and rms <= RMS) or len(poles) >= MOST:
            return Shape(zeros, poles, gain, worst, rms, float(np.exp(table.dense[place])))
        # a zero beside a pole, as wide as the error has one sign
        alike = np.sign(errors) == np.sign(errors[place])
        first, last = (np.flatnonzero(~alike[:place])[-1:], place + np.flatnonzero(~alike[place:])[:1])
        width = table.dense[last[0] - 1 if last.size else -1] - table.dense[first[0] + 1 if first.size else 0]
        damping, apart = math.log(min(max(width, 0.02), 0.8)), 0.05 * float(np.sign(errors[place]))
        zeros = np.append(zeros, [[table.dense[place], damping - apart]], axis=0)
        poles = np.append(poles, [[table.dense[place], damping + apart]], axis=0)


def _ends(low: float, high: float) -> tuple[Floats, Floats]:
    """Zeros and poles of elliptic filters at the ends of a band, each with one pair of zeros at 0 or at infinity."""
    from scipy import signal  # slow to import

    zeros, poles, _ = signal.ellipap(2 * _SECTIONS, 0.04, 10.0 * _STOP / math.log(10.0))
    beyond = np.log(np.sort(zeros.imag[zeros.imag > 0.0]))[:-1]
    upper = poles[poles.imag > 0.0]
    away, damping = np.log(np.abs(upper)), np.log(-upper.real / np.abs(upper))
    at = np.concatenate([low - beyond, high + beyond])
    return (
        np.column_stack([at, np.full(len(at), -4.0)]),
        np.column_stack([np.concatenate([low - away, high + away]), np.tile(damping, 2)]),
    )


def _least_squares(table: _Table, zeros: Floats, poles: Floats) -> tuple[Floats, Floats, float]:
    """Levenberg and Marquardt's method within bounds, with Nielsen's rule for the damping."""
    cut, size = zeros.size, zeros.size + poles.size

    def parts(x: Floats) -> tuple[Floats, Floats, float]:
        return x[:cut].reshape(-1, 2), x[cut:size].reshape(-1, 2), float(x[size])

    low, high = table.ends
    least = np.append(np.tile([low - _BEYOND, math.log(_LEAST * table.edge)], size // 2), -np.inf)
    most = np.append(np.tile([high + _BEYOND, _ZERO], size // 2), np.inf)
    most[cut + 1 : size : 2] = _MOST_DAMPED
    level = float(np.mean(_logarithm(zeros, poles, 0.0, table.at)[0] - table.wanted))
    x = np.concatenate([zeros.ravel(), poles.ravel(), [-level]])
    x = np.clip(x, least, most)
    values, slopes = table.residuals(*parts(x))
    cost, damping, grow, calm = float(values @ values), 1e-2, 2.0, 0
    for _ in range(_ROUNDS):
        gradient = np.einsum("ji,i->j", slopes, values)  # a product of matrices would depend on the number of threads
        free = ~(((x <= least) & (gradient > 0.0)) | ((x >= most) & (gradient < 0.0)))
        curvature, own = np.einsum("ji,ki->jk", slopes[free], slopes[free]), gradient[free]
        scale = np.diag(curvature) + 1e-9 * np.diag(curvature).max()
        step = np.zeros_like(x)
        step[free] = -np.linalg.solve(curvature + damping * np.diag(scale), own)
        moved = np.clip(x + step, least, most)
        taken = (moved - x)[free]
        new_values, new_slopes = table.residuals(*parts(moved))
        new = float(new_values @ new_values)
        if new < cost:
            foreseen = max(-float(2.0 * own @ taken + taken @ curvature @ taken), 1e-300)
            ratio = min((cost - new) / foreseen, 2.0)
            calm = calm + 1 if cost - new < _GAIN * cost else 0
            damping, grow = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-12), 2.0
            x, values, slopes, cost = moved, new_values, new_slopes, new
            if calm == _CALM:
                break
        else:
            damping, grow = damping * grow, 2.0 * grow
            if damping > 1e12:
                break
    return parts(x)
