"""The stationary density of (x, v) under the mean force that the memory exerts, given the present (x, v).

Dimensionless (Omega = q = 1), with y = x - b >= 0.  Whatever the memory, the stationary density p(x, v) obeys exactly

    E[v phi_x - (x + c F(x, v)) phi_v + phi_vv / 2] + int_0^inf u p(b, -u) [phi(b, r u) - phi(b, -u)] du = 0

for every smooth phi, where F(x, v) = E[D^alpha x \\| x, v] and the last term is due to impacts.  The only approximation
is to take F from the Gaussian y of the memory closure: given the present, y_(t-s) is normal with a known mean and
variance, and the mean of \\|y_(t-s)\\| is that of a folded normal.  D^alpha x has mean 0, which fixes F's constant.

p is a Gaussian times a polynomial (half range in y, Hermite in v), and phi runs over the same polynomials.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate, special

from springpot.machine.arrays import Floats
from springpot.theory.methods.memory_closure.memory import Loop
from springpot.theory.methods.memory_closure.quadrature import half_normal_rule
from springpot.theory.result import NoConvergenceError

_PHASES = 4  # in a quarter period of the far lags
_RADII = 24
_BALANCE = 1e-10  # of the springpot's mean force, over Omega^2 sigma_y


@dataclass(frozen=True)
class Plane:
    """Density of Y = y / sigma_y > 0 and V = v / sigma_v: a Gaussian times sum_ij a_ij Y^i He_j(V).

    Parameters
    ----------
    sigma_y, sigma_v : float
        Scales, dimensionless.
    coefficients : ndarray
        a_ij.

    Examples
    --------
    >>> plane = Plane(1.0, 2.0, np.array([[1.0, 0.0, 0.0]]))
    >>> [round(value, 12) for value in (plane.y_moment(2), plane.v_mean_square, plane.impact_rate * math.pi)]
    [1.0, 4.0, 2.0]
    """

    sigma_y: float
    sigma_v: float
    coefficients: Floats = field(repr=False)

    def joint(self, y: Floats, v: Floats) -> Floats:
        """Joint density of Y and V at Y >= 0, broadcast."""
        y, v = np.broadcast_arrays(y, v)
        height, width = self.coefficients.shape
        rows = np.polynomial.polynomial.polyvander(y.ravel(), height - 1) @ self.coefficients
        value = np.sum(rows * np.polynomial.hermite_e.hermevander(v.ravel(), width - 1), axis=-1)
        return np.asarray(np.exp(-(y * y + v * v) / 2.0) / math.pi * value.reshape(y.shape))

    def y_density(self, y: Floats) -> Floats:
        """Density of Y at Y >= 0."""
        value = np.polynomial.polynomial.polyval(y, self.coefficients[:, 0])
        return np.asarray(math.sqrt(2.0 / math.pi) * np.exp(-y * y / 2.0) * value)

    def v_density(self, v: Floats) -> Floats:
        """Density of V."""
        height = self.coefficients.shape[0]
        over_y = np.array([_half_normal_moment(i) for i in range(height)]) @ self.coefficients
        return np.asarray(np.exp(-v * v / 2.0) / math.sqrt(2.0 * math.pi) * np.polynomial.hermite_e.hermeval(v, over_y))

    def impact_speed_density(self, u: Floats) -> Floats:
        """Density of -V just before an impact, at -V = u >= 0."""
        value = np.polynomial.hermite_e.hermeval(-u, self.coefficients[0])
        return np.asarray(u * np.exp(-u * u / 2.0) / math.pi * value / self._flux_moment(0))

    def y_moment(self, power: int) -> float:
        """<y^power>, dimensionless."""
        a = self.coefficients[:, 0]
        value = sum(a[i] * _half_normal_moment(i + power) for i in range(a.size))
        return float(value * self.sigma_y**power)

    @property
    def v_mean_square(self) -> float:
        """<v^2>, dimensionless."""
        a = self.coefficients
        second = 2.0 * a[:, 2] if a.shape[1] > 2 else np.zeros(a.shape[0])
        value = sum((a[i, 0] + second[i]) * _half_normal_moment(i) for i in range(a.shape[0]))
        return float(value * self.sigma_v**2)

    @property
    def impact_rate(self) -> float:
        """Impacts per unit of time, dimensionless."""
        return self._flux_moment(0) * self.sigma_v / self.sigma_y

    def impact_speed_moment(self, power: int) -> float:
        """Mean power of the speed before an impact, dimensionless."""
        return self._flux_moment(power) / self._flux_moment(0) * self.sigma_v**power

    def _flux_moment(self, power: int) -> float:
        u, w = half_normal_rule(self.coefficients.shape[1] // 2 + 6)
        value = np.polynomial.hermite_e.hermeval(-u, self.coefficients[0])
        return float((w * u ** (power + 1)) @ value / math.sqrt(2.0 * math.pi))


def solve_plane(loop: Loop, c: float, position: float, restitution: float, degree: int) -> Plane:
    """Stationary density of the plane, given the correlation of the unfolded displacement.

    Parameters
    ----------
    loop : Loop
        The closed memory loop.
    c, position, restitution : float
        The dimensionless problem.
    degree : int
        Total degree of the polynomials.

    Raises
    ------
    NoConvergenceError
        If there is no density with positive moments and flux.
    """
    basis = _basis(degree)
    # The Gaussian must be as wide as the tail of the density for convergence; with a preload sigma_y is smaller.
    sigma_y = math.sqrt(max(loop.y2, loop.v2 / (1.0 + c * max(loop.element_stiffness, 0.0))))
    sigma_v = math.sqrt(loop.v2)
    force = _mean_force(loop, basis, sigma_y)
    weighted = basis.weights[:, None] * basis.value
    conservative = position + sigma_y * basis.y + c * force
    generator = (
        sigma_v / sigma_y * (basis.v[:, None] * basis.by_y)
        - (conservative / sigma_v)[:, None] * basis.by_v
        + basis.by_vv / (2.0 * loop.v2)
    ).T @ weighted + sigma_v / sigma_y * _impacts(degree, restitution)
    constant_force = -basis.by_v.T @ weighted / sigma_v  # of a constant force 1
    mass = basis.weights @ basis.value
    first = np.zeros(mass.size)
    first[0] = 1.0

    def solve(constant: float) -> tuple[Floats, float]:
        matrix = generator - c * constant * constant_force
        matrix[0] = mass  # the equation of phi = 1 is trivial: the normalization replaces it
        try:
            solution = np.asarray(np.linalg.solve(matrix, first), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise NoConvergenceError("The memory closure found no stationary density of x and v.") from None
        return solution, float((weighted @ solution) @ force) - constant

    old = float(basis.weights @ force)
    solution, excess = solve(old)
    constant = old + excess
    for _ in range(30):
        previous = excess
        solution, excess = solve(constant)
        if c * abs(excess) <= _BALANCE * sigma_y or excess == previous:
            break
        old, constant = constant, constant - excess * (constant - old) / (excess - previous)
    else:
        raise NoConvergenceError("The memory closure did not balance the springpot's mean force.")
    coefficients = np.zeros((degree + 1, degree + 1))
    coefficients[basis.rows, basis.columns] = basis.to_monomials @ solution
    plane = Plane(sigma_y, sigma_v, coefficients)
    if not (plane.y_moment(2) > 0.0 and plane.v_mean_square > 0.0 and plane.impact_rate > 0.0):
        raise NoConvergenceError("The memory closure found no positive stationary density of x and v.")
    return plane


@dataclass(frozen=True)
class _Basis:
    """Orthonormal polynomials at the nodes of a product rule, their derivatives, and their Y^i He_j(V) coefficients."""

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    y: Floats
    v: Floats
    weights: Floats
    value: Floats
    by_y: Floats
    by_v: Floats
    by_vv: Floats
    to_monomials: Floats


@lru_cache(maxsize=8)
def _basis(degree: int) -> _Basis:
    pairs = np.array([(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)])
    rows, columns = pairs.T
    y0, wy = half_normal_rule(2 * degree + 4)
    v0, wv = np.polynomial.hermite_e.hermegauss(2 * degree + 2)
    y, v = (grid.ravel() for grid in np.meshgrid(y0, v0, indexing="ij"))
    weights = np.outer(wy, wv / wv.sum()).ravel()
    power, hermite = np.polynomial.polynomial.polyvander(y, degree), np.polynomial.hermite_e.hermevander(v, degree)
    less, lesser = np.maximum(columns - 1, 0), np.maximum(columns - 2, 0)
    value = power[:, rows] * hermite[:, columns]
    _, triangle = np.linalg.qr(value * np.sqrt(weights)[:, None])
    change = np.linalg.inv(triangle)
    return _Basis(
        rows=rows,
        columns=columns,
        y=y,
        v=v,
        weights=weights,
        value=value @ change,
        by_y=(rows * power[:, np.maximum(rows - 1, 0)] * hermite[:, columns]) @ change,
        by_v=(columns * power[:, rows] * hermite[:, less]) @ change,
        by_vv=(columns * (columns - 1) * power[:, rows] * hermite[:, lesser]) @ change,
        to_monomials=change,
    )


def _impacts(degree: int, restitution: float) -> Floats:
    """int_0^inf u p(0, -u) [phi(0, r u) - phi(0, -u)] du for every pair of basis functions."""
    basis = _basis(degree)
    u, w = half_normal_rule(degree + 4)
    at_wall = basis.rows == 0
    change = basis.to_monomials[at_wall]
    columns = basis.columns[at_wall]
    before = np.polynomial.hermite_e.hermevander(-u, degree)[:, columns] @ change
    after = np.polynomial.hermite_e.hermevander(restitution * u, degree)[:, columns] @ change
    return np.asarray((after - before).T @ ((w * u)[:, None] * before) / math.sqrt(2.0 * math.pi))


def _mean_force(loop: Loop, basis: _Basis, scale: float) -> Floats:
    """E[D^alpha x \\| Y, V] up to a constant: that of D^alpha y less that of D^alpha (y - \\|y\\|) of the history."""
    grid, v = loop.grid, basis.v
    stretch = scale / math.sqrt(loop.y2)
    y = stretch * basis.y
    stiffness, damping = grid.free_element(loop.spectrum)
    rho = 1.0 - loop.drop
    rho_v = grid.to_slope @ loop.spectrum / math.sqrt(loop.y2 * loop.v2)
    spread = np.sqrt(np.maximum(1.0 - rho**2 - rho_v**2, 1e-14))
    conditional_mean = (np.multiply.outer(y, rho) + np.multiply.outer(v, rho_v)) / spread
    near = _folded_excess(conditional_mean) @ (grid.lag_weights * spread)
    # At far lags the conditional mean is e A cos(phase), whose effect averaged over the phase depends on A only.
    size = np.minimum(np.abs(loop.envelope), 1.0 - 1e-12)
    spread = np.sqrt(1.0 - size**2)
    amplitude = np.hypot(y, v)
    radii = np.linspace(0.0, float(amplitude.max()), _RADII)
    far = np.zeros(_RADII)
    for phase in (np.arange(_PHASES) + 0.5) / _PHASES * math.pi / 2.0:
        conditional_mean = np.multiply.outer(radii, size * math.cos(phase) / spread)
        far += (_folded_excess(conditional_mean) + conditional_mean) @ (grid.far_weights * spread) / _PHASES
    memory = near + interpolate.CubicSpline(radii, far)(amplitude)
    sigma_y, sigma_v = math.sqrt(loop.y2), math.sqrt(loop.v2)
    force = sigma_y * (stiffness * y - grid.strength * memory) + sigma_v * damping * v
    # Under the Gaussian its mean is 0 and its products with y and v are those of the equivalent element, exactly: this
    # corrects the quadrature error at the corner of \\|y_(t-s)\\|.
    probes = np.stack([np.ones_like(y), y, v])
    weighted = probes * basis.weights * stretch * np.exp((basis.y**2 - y**2) / 2.0)
    exact = np.array([0.0, sigma_y * loop.element_stiffness, sigma_v * loop.element_damping])
    wanted = np.linalg.solve(weighted @ probes.T, exact - weighted @ force)
    return np.asarray(force + wanted @ probes)


def _folded_excess(z: Floats) -> Floats:
    """E\\|z + N\\| - z for a standard normal N."""
    return np.asarray(2.0 * (np.exp(-z * z / 2.0) / math.sqrt(2.0 * math.pi) - z * special.ndtr(-z)))


def _half_normal_moment(power: int) -> float:
    return math.exp2(power / 2.0) * math.gamma((power + 1) / 2.0) / math.sqrt(math.pi)
