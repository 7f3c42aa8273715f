"""A chain for the law of (y, x, v): the motion of a short step, as a matrix between values on a grid.

In a step h the noise y first goes half a step, then x and v move along the deterministic motion with y held, walls
included, then y goes the other half.  The backward operator of the step takes values of a function at the nodes to its
expected values a step later.  In y it is exact for polynomials up to the number of Gauss-Hermite nodes; in x and v the
function is interpolated where the motion ends, by polynomials of degree 5 (3 with walls) and 3.  The stationary weights
of the nodes are its left eigenvector.  This is path integration [1]_ with the matrix kept; a mass at rest on a lossy
wall is a node.

References
----------
.. [1] H. T. Sykora, R. Kuske and D. Yurchenko, "Stochastic dynamics of mechanical systems with impacts via the step
   matrix multiplication based path integration method", Nonlinear Dynamics (2024).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import hermite_e
from numpy.typing import NDArray
from scipy import sparse, special
from scipy.sparse import linalg

from springpot.machine.arrays import Floats
from springpot.problem.parts import Barrier
from springpot.theory.methods.envelope.walls import restitutions
from springpot.theory.result import NoConvergenceError

Acceleration = Callable[[Floats, Floats, Floats], Floats]
"""Of y, x and v."""

_PARTS = 8  # of a step, for the motion
_SLOW = 2.0, 3.0  # impacts below these times the change of speed in a part, and the spacing of speeds, are not resolved
_CHATTER = 0.3  # impacts that are not resolved, over those that are, above which there is no rate
_VECTORS, _RESTARTS = 24, 15  # of Arnoldi's iteration
_OTHERS = 6  # eigenvalues
_UNSETTLED = 1e-6  # distance of an eigenvalue from 1
_BESIDE = 0.6, 0.75  # part of the spacing of nodes that grows with the distance from a wall, and with the speed


@dataclass(frozen=True)
class Grid:
    """Nodes of y, x and v, and the weights of y."""

    y: Floats
    x: Floats
    v: Floats
    y_weight: Floats

    @cached_property
    def places(self) -> tuple[Floats, Floats, Floats]:
        """y, x and v of all nodes."""
        y, x, v = np.meshgrid(self.y, self.x, self.v, indexing="ij")
        return y.ravel(), x.ravel(), v.ravel()


def grid_over(
    deviation: float, low: float, high: float, fastest: float, walls: tuple[bool, bool], size: tuple[int, int, int]
) -> Grid:
    """Nodes for a normal y of this standard deviation, x between two ends and v up to the fastest.

    Parameters
    ----------
    deviation, low, high, fastest : float
    walls : tuple of bool
        Whether the low and the high end are walls: nodes are denser there, and then at small speeds.
    size : tuple of int
        Number of nodes of y, x and v.
    """
    normal, weight = hermite_e.hermegauss(size[0])
    part = np.linspace(0.0, 1.0, size[1])
    if walls == (True, False):
        part = (1.0 - _BESIDE[0]) * part + _BESIDE[0] * part**2
    elif walls == (False, True):
        part = 1.0 - ((1.0 - _BESIDE[0]) * part + _BESIDE[0] * part**2)[::-1]
    speed = np.linspace(-1.0, 1.0, size[2])  # an odd number of them: a mass at rest is at a node
    if any(walls):
        speed = (1.0 - _BESIDE[1]) * speed + _BESIDE[1] * speed * np.abs(speed)
    return Grid(normal * deviation, low + (high - low) * part, fastest * speed, weight / weight.sum())


@dataclass(frozen=True)
class Chain:
    """The chain on its grid.

    Parameters
    ----------
    grid : Grid
    step : float
    half : ndarray
        The backward operator of y over half a step.
    moved : sparse array
        The transpose of that of x and v over a step, with y held.
    hits : ndarray
        Of each wall and each node, in a step: the impacts that are resolved, those of up to twice and of two to four
        times the slowest of these, the sums of speeds and of their squares, and the impacts that are not resolved.
    """

    grid: Grid
    step: float
    half: Floats
    moved: sparse.csr_array
    hits: Floats

    def forward(self, weights: Floats) -> Floats:
        """Weights of the nodes a step later."""
        return self._half_forward(self.moved @ self._half_forward(weights))

    def _half_forward(self, weights: Floats) -> Floats:
        return np.asarray((self.half.T @ weights.reshape(self.half.shape[0], -1)).ravel())

    def stationary(self, start: Floats | None, together: int, largest: float = math.inf) -> Floats:
        """The stationary weights of the nodes, found by Arnoldi's iteration of some steps together.

        Where interpolation feeds some wave there are eigenvalues above 1, up to ``largest``; correlations need none.

        Raises
        ------
        NoConvergenceError
            If it finds none.
        """
        count = self.grid.places[0].size
        if start is None:
            start = self._start()

        def steps(weights: Floats) -> Floats:
            weights = np.ravel(weights)
            for _ in range(together):
                weights = self.forward(weights)
            return weights

        if not np.all(np.isfinite(self.moved.data)):
            raise NoConvergenceError(
                "path integration found no stationary law: the motion leaves what numbers can hold."
            )
        operator = linalg.LinearOperator((count, count), matvec=steps, dtype=float)
        for wanted in (1, _OTHERS):  # an interpolation that feeds some wave a little has a larger one beside that of 1
            try:
                values, vectors = linalg.eigs(operator, k=wanted, v0=start, ncv=_VECTORS, tol=1e-7, maxiter=_RESTARTS)
            except linalg.ArpackError as failed:
                raise NoConvergenceError(
                    "path integration found no stationary law: its iteration did not settle, as where damping is light."
                ) from failed
            nearest = int(np.argmin(np.abs(values - 1.0)))
            if abs(values[nearest] - 1.0) < _UNSETTLED and np.abs(values).max() < largest:
                found = vectors[:, nearest].real
                return np.asarray(found / found.sum())
        raise NoConvergenceError("path integration found no stationary law: the interpolation is not stable here.")

    def _start(self) -> Floats:
        _, x, v = self.grid.places
        middle, width = 0.5 * (x.max() + x.min()), 0.25 * (x.max() - x.min())
        normal = np.exp(-0.5 * ((x - middle) / width) ** 2 - 8.0 * (v / v.max()) ** 2)
        return np.asarray(normal * np.repeat(self.grid.y_weight, self.grid.x.size * self.grid.v.size))

    def impacts(self, weights: Floats) -> list[tuple[float, float, float]]:
        """Rate at each wall, and the same times mean and mean square of the speed.

        Impacts that are too slow to be resolved are taken from a power law; where they are many, all is NaN.
        """
        half = self._half_forward(weights)
        found = []
        for rate, slow, fast, first, second, chatter in (self.hits @ half / self.step).tolist():
            share = min(max(slow, 0.0) / fast, 0.5) if fast > 0.0 else 0.0  # of a power law: 1/4 at an elastic wall
            known = 1.0 if chatter <= _CHATTER * rate else math.nan
            found.append((known * (rate + max(slow, 0.0) * share / (1.0 - share)), known * first, known * second))
        return found

    def correlation(self, before: Floats, after: Floats, longest: int) -> Floats:
        """E[f(0) g(t)] at steps from 0, until they have decayed.

        Parameters
        ----------
        before : ndarray, shape (nodes,)
            The stationary weights times f.
        after : ndarray, shape (m, nodes)
            Values of the functions g.
        longest : int
            Number of steps at most.
        """
        rows = [after @ before]
        largest = np.abs(rows[0])
        for number in range(1, longest + 1):
            before = self.forward(before)
            rows.append(after @ before)
            largest = np.maximum(largest, np.abs(rows[-1]))
            if number % 50 == 0 and np.all(np.abs(rows[-40:]).max(axis=0) <= 2e-3 * largest + 1e-300):
                break
        return np.array(rows)


def make_chain(
    grid: Grid, step: float, correlation_time: float, acceleration: Acceleration, stops: Sequence[Barrier]
) -> Chain:
    """The chain of a motion with this acceleration between walls."""
    number = np.arange(grid.y.size)
    scale = grid.y[-1] / hermite_e.hermegauss(grid.y.size)[0][-1]
    basis = hermite_e.hermevander(grid.y / scale, grid.y.size - 1) / np.sqrt(special.factorial(number))
    fading = np.exp(-0.5 * number * step / correlation_time)
    half = (basis * fading) @ (basis * grid.y_weight[:, None]).T
    x, v, hits = _move(grid, step, acceleration, stops)
    x_points, v_points = 4 if stops else 6, 4  # at a wall the expected values are not so smooth
    column, x_weight = _lagrange(grid.x, np.clip(x, grid.x[0], grid.x[-1]), x_points)
    row, v_weight = _lagrange(grid.v, np.clip(v, grid.v[0], grid.v[-1]), v_points)
    level = np.repeat(number, grid.x.size * grid.v.size)
    column = (level[:, None] * grid.x.size + column[:, None] + np.arange(x_points)) * grid.v.size + row[:, None]
    places = column[:, :, None] + np.arange(v_points)
    entries = (x_weight[:, :, None] * v_weight[:, None, :]).ravel()
    starts = np.arange(0, entries.size + 1, x_points * v_points)
    moved = sparse.csr_array((entries, places.ravel(), starts), shape=(x.size, x.size)).T.tocsr()
    return Chain(grid, step, half, moved, hits)


def _move(
    grid: Grid, step: float, acceleration: Acceleration, stops: Sequence[Barrier]
) -> tuple[Floats, Floats, Floats]:
    """Where x and v go in a step from every node, and the impacts on the way."""
    y, x, v = grid.places
    part = step / _PARTS
    hits = np.zeros((len(stops), 6, x.size))
    slowest = _SLOW[1] * float(np.diff(grid.v).min())
    for _ in range(_PARTS):
        x, v = _drift(y, x, v, part, acceleration, stops, slowest, hits)
        guess = v + part * acceleration(y, x, v)
        guess = v + part * acceleration(y, x, 0.5 * (v + guess))
        v = v + part * acceleration(y, x, 0.5 * (v + guess))
        x, v = _drift(y, x, v, part, acceleration, stops, slowest, hits)
    return x, v, hits


def _drift(
    y: Floats,
    x: Floats,
    v: Floats,
    part: float,
    acceleration: Acceleration,
    stops: Sequence[Barrier],
    slowest: float,
    hits: Floats,
) -> tuple[Floats, Floats]:
    """Half of a part in a straight line, with an impact at most on each wall; impacts are counted in ``hits``."""
    x = x + 0.5 * part * v
    for stop, counted in zip(stops, hits, strict=True):
        sign = stop.inwards
        beyond = sign * (stop.position - x)
        struck = np.flatnonzero((beyond > 0.0) & (sign * v < 0.0))
        if not struck.size:
            continue
        speed = np.abs(v[struck])
        r = restitutions(stop, speed)
        x = x.copy()
        x[struck] = stop.position + sign * r * beyond[struck]
        v = v.copy()
        v[struck] = sign * r * speed
        pressed = -sign * acceleration(y, np.full_like(y, stop.position), np.zeros_like(y))[struck]
        least = np.maximum(_SLOW[0] * part * pressed, slowest)
        seen = speed > least
        counted[0, struck] += seen
        counted[1, struck] += seen & (speed <= 2.0 * least)
        counted[2, struck] += (speed > 2.0 * least) & (speed <= 4.0 * least)
        counted[3, struck] += speed * seen
        counted[4, struck] += speed**2 * seen
        counted[5, struck] += ~seen
    return x, v


def _lagrange(nodes: Floats, places: Floats, points: int) -> tuple[NDArray[np.intp], Floats]:
    """The first of the nodes nearest to each place, and the weights of the polynomial through them."""
    first = np.clip(np.searchsorted(nodes, places, side="right") - points // 2, 0, nodes.size - points)
    near = nodes[first[:, None] + np.arange(points)]
    weights = np.ones_like(near)
    for a in range(points):
        for b in range(points):
            if a != b:
                weights[:, a] *= (places - near[:, b]) / (near[:, a] - near[:, b])
    return first, weights


def kernel_weights(order: float, step: float, count: int) -> Floats:
    """Weights of the integral of t^-order / Gamma(1 - order) times a correlation that is straight between the steps.

    Where the correlation oscillates to its end, the weights fade out over the last half: the waves beyond cancel.

    Examples
    --------
    >>> t = np.arange(2001) * 0.01
    >>> round(float(kernel_weights(0.5, 0.01, 2000) @ np.exp(-t)), 4)
    1.0
    """
    n = np.arange(1.0, count + 1.0)
    power = 2.0 - order
    later = (n + 1.0) ** power - 2.0 * n**power + (n - 1.0) ** power
    fading = np.cos(0.5 * math.pi * np.clip(2.0 * n / count - 1.0, 0.0, 1.0)) ** 2
    return np.asarray(step ** (1.0 - order) / math.gamma(3.0 - order) * np.r_[1.0, later * fading])
