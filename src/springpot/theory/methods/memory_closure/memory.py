"""Memory of a springpot with a wall: a Gaussian correlation and its equivalent linear element, iterated.

Everything here is dimensionless (Omega = q = 1).  The displacement from the wall is unfolded, x - b = \\|y\\|, and y is
assumed Gaussian with correlation coefficient rho(s).  The best linear regression of sgn(y_t) \\|y_(t-s)\\| is

    (2/pi) sqrt(1 - rho^2) y_t + (2/pi) arcsin(rho) y_(t-s),

so that the springpot acts as the linear element

    K(iw) = (alpha / Gamma(1-alpha)) int_0^inf s^(-alpha-1) [1 - (2/pi) sin(theta) - (1 - 2 theta/pi) e^(-iws)] ds

with theta = arccos rho.  Two things keep this accurate from alpha -> 0 to alpha = 1 and for any damping:

- theta starts like kappa s, kappa = sigma_v / sigma_y.  With 1 - e^(-kappa s) in place of sin(theta) and with
  (pi/2) (1 - e^(-2 kappa s / pi)) in place of theta the integral is (iw + 2 kappa/pi)^alpha - (2/pi) kappa^alpha;
  only the remainder, of order s^2 at 0 and 0 at infinity, is computed by quadrature, with a factor 0 at alpha = 1.
- After some ten half periods rho is a cosine with a slow envelope.  There only the mean and the first harmonic of
  sin(theta) and theta matter (complete elliptic integrals of the envelope), which are slow and need few nodes for any
  length of the memory.  Near and far lags are blended smoothly, to avoid spurious ripples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy import special

from springpot.machine.arrays import Complexes, Floats
from springpot.theory.methods.memory_closure.quadrature import oscillating_weights
from springpot.theory.numerics.equations import Anderson
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.result import NoConvergenceError

_LOW, _HIGH = 18, 14  # octaves of frequency below and above the resonance
_ACTIVE = 8.0  # multiple of the resonance above which the remainder of K follows its asymptote w^(alpha-2)
_FADED = 25.0  # decay times after which the envelope is 0
_MIXED = 6  # depth of the acceleration
_HARMONICS = range(2, 26, 2)  # of f(rho) over one period, kept at the far lags; the next is 1e-5 of the first
_PHASES = 64
_ORDER = 8  # of its quadrature near 0


@dataclass(frozen=True)
class Grid:
    """Frequencies, lags, and the matrices from spectra to correlations and from correlations to the element.

    Built by `make_grid` around one resonance; lags and frequencies are dimensionless.
    """

    alpha: float
    resonance: float
    decay: float
    detail: int
    edges: Floats
    order: int
    w: Floats
    weights: Floats
    near_edges: Floats
    lag: Floats
    lag_weights: Floats
    far_edges: Floats
    far_lag: Floats
    far_weights: Floats
    to_drop: Floats = field(repr=False)
    to_slope: Floats = field(repr=False)
    to_envelope: Complexes = field(repr=False)
    near_kernel: Complexes = field(repr=False)
    far_kernel: Complexes = field(repr=False)

    @property
    def strength(self) -> float:
        """alpha / Gamma(1 - alpha), 0 at alpha = 1."""
        return self.alpha * float(special.rgamma(1.0 - self.alpha))

    def far_share(self, lag: Floats) -> Floats:
        """The smooth step from 0 at the near lags to 1 at the far ones."""
        centre, width = _handover(self.detail)
        return np.asarray(special.erfc((centre - lag * self.resonance) / (width * math.sqrt(2.0))) / 2.0)

    def moments(self, spectrum: Floats) -> tuple[float, float]:
        """<y^2> and <y'^2> of a two-sided spectrum that ends like 1 / (2 pi w^4)."""
        top = float(self.edges[-1])
        y2 = 2.0 * float(self.weights @ spectrum) + 1.0 / (3.0 * math.pi * top**3)
        return y2, 2.0 * float(self.weights @ (self.w**2 * spectrum)) + 1.0 / (math.pi * top)

    def free_element(self, spectrum: Floats) -> tuple[float, float]:
        """Stiffness and damping of D^alpha y itself as regressed on y and y', both dimensionless."""
        y2, v2 = self.moments(spectrum)
        power = self.w**self.alpha * spectrum * self.weights
        half = self.alpha * math.pi / 2.0
        damping = 2.0 * math.sin(half) * float(self.w @ power) + self.damping_above
        return 2.0 * math.cos(half) * float(power.sum()) / y2, damping / v2

    @property
    def damping_above(self) -> float:
        """Power at frequencies above the grid, for an element that ends like (iw)^alpha."""
        top = math.pow(float(self.edges[-1]), self.alpha - 2.0) / (2.0 - self.alpha)
        return math.sin(self.alpha * math.pi / 2.0) / math.pi * top


def make_grid(alpha: float, resonance: float, decay: float, detail: int = 0) -> Grid:
    """Grid for spectra that peak at ``resonance`` with the width ``decay``.

    Parameters
    ----------
    alpha : float
        Order in (0, 1].
    resonance, decay : float
        Frequency of the peak and its half width, dimensionless.
    detail : int
        0 for results to about 1e-6; each step more has 4 more nodes per panel and uses the envelope at later lags.

    Examples
    --------
    >>> grid = make_grid(0.5, 1.0, 0.05)
    >>> y2, v2 = grid.moments(1.0 / (2.0 * math.pi * ((1.0 - grid.w**2) ** 2 + (0.1 * grid.w) ** 2)))
    >>> [round(value, 6) for value in (y2, v2)]
    [5.0, 5.0]
    """
    order, near_order = 8 + 4 * detail, 6 + 4 * detail
    edges = _frequency_edges(resonance, decay)
    w, weights = panel_rule(edges, order)
    centre, width = _handover(detail)
    near_end, far_start = (centre + 4.2 * width) / resonance, (centre - 4.2 * width) / resonance

    # The first panel integrates the weight s^(1-alpha) of the s^2 remainder exactly; the others are graded to the
    # corners that theta has, for light damping, at the extremes of rho.
    first = 0.25 / resonance
    x, jacobi = special.roots_jacobi(8 + 4 * detail, 0.0, 1.0 - alpha)
    early = (x + 1.0) / 2.0 * first
    early_weights = jacobi * (first / 2.0) ** (2.0 - alpha) / early**2
    near_edges = _near_edges(resonance, decay, first, near_end)
    near, near_weights = panel_rule(near_edges, near_order)
    near_part = special.erfc((near * resonance - centre) / (width * math.sqrt(2.0))) / 2.0 * near ** (-alpha - 1.0)
    far_edges = list(np.linspace(far_start, near_end, 7))
    while far_edges[-1] < _FADED / decay:
        far_edges.append(2.0 * far_edges[-1])
    far, far_weights = panel_rule(np.array(far_edges), order)
    far_part = special.erfc((centre - far * resonance) / (width * math.sqrt(2.0))) / 2.0 * far ** (-alpha - 1.0)

    lag = np.concatenate([early, near])
    waves = oscillating_weights(edges, lag, order)
    active = w[w < _ACTIVE * resonance]
    # The envelope is that of the resonance alone: at far lags the smooth rest of the spectrum does not contribute.
    around = -np.expm1(-((w / (0.4 * resonance)) ** 4))
    early_waves = np.exp(-1j * np.multiply.outer(active, early)) * early_weights
    return Grid(
        alpha=alpha,
        resonance=resonance,
        decay=decay,
        detail=detail,
        edges=edges,
        order=order,
        w=w,
        weights=weights,
        near_edges=near_edges,
        lag=lag,
        lag_weights=np.concatenate([early_weights, near_part * near_weights]),
        far_edges=np.array(far_edges),
        far_lag=far,
        far_weights=far_part * far_weights,
        to_drop=2.0 * (weights - waves.real),
        to_slope=-2.0 * waves.imag * w,
        to_envelope=2.0 * oscillating_weights(edges, far, order) * around,
        near_kernel=np.hstack((early_waves, oscillating_weights(near_edges, -active, near_order) * near_part)),
        far_kernel=oscillating_weights(np.array(far_edges), resonance - active, order)
        * (far_part * np.exp(-1j * resonance * far)),
    )


def _handover(detail: int) -> tuple[float, float]:
    """Centre and width of the step from near to far lags, in rad of the resonance."""
    return 22.0 * (1 + detail), 3.5 * (1 + detail)


def _frequency_edges(resonance: float, decay: float) -> Floats:
    low = resonance * 2.0 ** np.arange(-_LOW, 0.0, 2.0)
    high = resonance * 2.0 ** np.concatenate([np.arange(1.0, 6.0), np.arange(6.0, _HIGH + 1.0, 2.0)])
    depth = max(1, math.ceil(math.log2(resonance / decay)))
    offsets = resonance / 2.0 * 2.0 ** -np.arange(0.0, depth + 1)
    return np.unique(np.concatenate([[0.0, resonance], low, resonance - offsets, resonance + offsets, high]))


def _near_edges(resonance: float, decay: float, first: float, end: float) -> Floats:
    edges = [first * resonance * 2.0 ** np.arange(4)]
    for n in range(1, math.ceil(end * resonance / math.pi) + 1):
        corner = math.sqrt(2.0 * math.pi * n * decay / resonance)
        depth = max(0, math.floor(math.log(math.pi / 2.0 / corner, 5.0))) if corner < math.pi / 2.0 else 0
        offsets = math.pi / 2.0 * 5.0 ** -np.arange(0.0, depth + 1)
        places = n * math.pi + np.concatenate([-offsets, [0.0], offsets])
        edges.append(places[places > 10.0 * first * resonance])
    return np.asarray(np.unique(np.round(np.concatenate(edges), 12)) / resonance)


@dataclass(frozen=True)
class Loop:
    """A spectrum of y, with its correlation and element.

    Parameters
    ----------
    grid : Grid
    element : ndarray
        K(iw) at the grid's frequencies.
    spectrum : ndarray
        1 / (2 pi \\|1 + k - w^2 + i w d + c K\\|^2), two-sided.
    drop, envelope : ndarray
        1 - rho at the near lags; the complex envelope of rho, phase included, at the far ones.
    y2, v2 : float
        <y^2> and <y'^2>.
    """

    grid: Grid
    element: Complexes
    spectrum: Floats
    drop: Floats
    envelope: Complexes
    y2: float
    v2: float

    @property
    def element_stiffness(self) -> float:
        """Stiffness of K as regressed on y."""
        return 2.0 * float(self.grid.weights @ (self.element.real * self.spectrum)) / self.y2

    @property
    def element_damping(self) -> float:
        """Damping of K as regressed on y'."""
        power = 2.0 * float((self.grid.weights * self.grid.w) @ (self.element.imag * self.spectrum))
        return (power + self.grid.damping_above) / self.v2

    def peak(self, c: float, stiffness: float, damping: float) -> tuple[float, float]:
        """Frequency and half width of the resonance of this element with another stiffness and damping added."""
        w = self.grid.resonance
        for _ in range(50):
            real = float(np.interp(w, self.grid.w, self.element.real))
            w = (w + math.sqrt(max(1.0 + stiffness + c * real, 0.05))) / 2.0
        loss = c * float(np.interp(w, self.grid.w, self.element.imag)) / w + damping
        return w, max(loss / 2.0, 1e-12)

    def moved(self, grid: Grid) -> Loop:
        """This element on another grid; above the old one it is (iw)^alpha."""
        old = self.grid
        element = np.interp(grid.w, old.w, self.element.real) + 1j * np.interp(grid.w, old.w, self.element.imag)
        element = np.where(grid.w > old.w[-1], (1j * grid.w) ** grid.alpha, element)
        return Loop.driven_by(grid, element, 0.0, 0.0, 0.0)

    @classmethod
    def driven_by(cls, grid: Grid, element: Complexes, c: float, stiffness: float, damping: float) -> Loop:
        """The oscillator with a given element: one spectrum, no iteration."""
        response = 1.0 + stiffness - grid.w**2 + 1j * grid.w * damping + c * element
        spectrum = 1.0 / (2.0 * math.pi * np.abs(response) ** 2)
        y2, v2 = grid.moments(spectrum)
        return cls(grid, element, spectrum, grid.to_drop @ spectrum / y2, grid.to_envelope @ spectrum / y2, y2, v2)

    def driven(self, c: float, stiffness: float, damping: float) -> Loop:
        """The same element with another stiffness and damping: one spectrum, no iteration."""
        return Loop.driven_by(self.grid, self.element, c, stiffness, damping)

    def closed(self, c: float, stiffness: float, damping: float, tolerance: float, sweeps: int) -> tuple[Loop, int]:
        """Iterate spectrum -> correlation -> element until they agree.

        Parameters
        ----------
        c : float
            Dimensionless coefficient of the springpot.
        stiffness, damping : float
            Linear stiffness and damping added to those of the oscillator.
        tolerance : float
            Largest change of rho in the last sweep.
        sweeps : int
            Largest number of sweeps.

        Returns
        -------
        tuple of Loop and int
            The loop and the number of sweeps it took.

        Raises
        ------
        NoConvergenceError
            If the tolerance is not reached.
        """
        mix, loop = Anderson(_MIXED), self.driven(c, stiffness, damping)
        point = loop._state()
        for count in range(1, sweeps + 1):
            n, m = self.grid.lag.size, self.grid.far_lag.size
            envelope = point[n : n + m] + 1j * point[n + m : -1]
            element = _element(self.grid, point[:n], envelope, max(float(point[-1]), 1e-6))
            loop = Loop.driven_by(self.grid, element, c, stiffness, damping)
            image = loop._state()
            change = float(np.max(np.abs(image - point)))
            if change < tolerance:
                return loop, count
            point = mix.step(point, image)
        raise NoConvergenceError(
            f"The memory closure did not converge: after {sweeps} sweeps the correlation still changes by {change:.1e}."
        )

    def _state(self) -> Floats:
        ratio = math.sqrt(self.v2 / self.y2)
        return np.concatenate([self.drop, self.envelope.real, self.envelope.imag, [ratio]])


def _element(grid: Grid, drop: Floats, envelope: Complexes, kappa: float) -> Complexes:
    """K(iw) of a correlation."""
    alpha, mu = grid.alpha, 2.0 * kappa / math.pi
    theta = 2.0 * np.arcsin(np.sqrt(np.clip(drop / 2.0, 0.0, 1.0)))
    mean, harmonic = _far_harmonics(envelope)
    local = grid.lag_weights @ (np.sin(theta) + np.expm1(-kappa * grid.lag)) + grid.far_weights @ (mean - 1.0)
    delayed = grid.near_kernel @ (theta + math.pi / 2.0 * np.expm1(-mu * grid.lag)) - grid.far_kernel @ harmonic / 2.0
    above = delayed[-1] * (grid.w[delayed.size :] / grid.w[delayed.size - 1]) ** (alpha - 2.0)
    rest = 2.0 / math.pi * grid.strength * (local - np.concatenate([delayed, above]))
    return np.asarray((1j * grid.w + mu) ** alpha - 2.0 / math.pi * kappa**alpha - rest)


def _far_harmonics(envelope: Complexes) -> tuple[Floats, Complexes]:
    """Over one period of rho = Re(envelope): mean of sqrt(1 - rho^2), and first harmonic of arcsin(rho)."""
    size = np.clip(np.abs(envelope), 1e-300, 1.0)
    m = size * size
    e = special.ellipe(m)
    with np.errstate(invalid="ignore"):
        first = 4.0 / math.pi * (e - (1.0 - m) * special.ellipkm1(np.maximum(1.0 - m, 1e-300))) / m
    return np.asarray(2.0 / math.pi * e), envelope * np.where(m > 1e-4, first, 1.0 + m / 8.0)


def unfolded_correlation(loop: Loop, lag: Floats) -> Floats:
    """rho at any lags >= 0 (one row), dimensionless."""
    grid = loop.grid
    drop = 2.0 * (grid.weights - oscillating_weights(grid.edges, lag, grid.order).real) @ loop.spectrum / loop.y2
    return np.clip(1.0 - drop, -1.0, 1.0)


def folded_correlation(rho: Floats) -> Floats:
    """The covariance f(rho) of \\|y\\| over its variance: 1 at rho = +-1 and 0 at rho = 0.

    Examples
    --------
    >>> folded_correlation(np.array([-1.0, 0.0, 1.0])).round(12).tolist()
    [1.0, 0.0, 1.0]
    """
    return np.asarray((np.sqrt(1.0 - rho**2) + rho * np.arcsin(rho) - 1.0) / (math.pi / 2.0 - 1.0))


def folded_spectrum(loop: Loop, frequency: Floats) -> Floats:
    """Two-sided spectrum whose integral over the real line is 1, at frequencies >= 0 (one row), dimensionless."""
    grid = loop.grid
    near_edges = np.concatenate([[0.0], grid.near_edges])
    lag, _ = panel_rule(near_edges, _ORDER)
    near = folded_correlation(unfolded_correlation(loop, lag)) * (1.0 - grid.far_share(lag))
    total = (oscillating_weights(near_edges, frequency, _ORDER) @ near).real
    # Far on, f is a cosine series in the phase of the envelope, with slow coefficients.
    turn = loop.envelope * np.exp(-1j * grid.resonance * grid.far_lag)
    size = np.minimum(np.abs(turn), 1.0)
    phase = (np.arange(_PHASES) + 0.5) / _PHASES * math.pi
    values = folded_correlation(np.multiply.outer(size, np.cos(phase))) * grid.far_share(grid.far_lag)[:, None]
    total = total + (oscillating_weights(grid.far_edges, frequency, grid.order) @ values.mean(axis=1)).real
    direction = turn / np.maximum(size, 1e-300)
    for n in _HARMONICS:
        slow = values @ np.cos(n * phase) / _PHASES * direction**n
        total = total + (oscillating_weights(grid.far_edges, n * grid.resonance - frequency, grid.order) @ slow).real
    return np.asarray(total / math.pi)
