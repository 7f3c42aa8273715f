"""Exponential sums of several orders with the same rates: so many paths of unlike orders share the powers of a mode.

The weights of an order are least squares in fixed rates, with weights of the lags that are those of the middle order.
They are smooth in the order, so that those of a few orders give all others, by polynomials.
The rates make the largest error over the range of orders small: damped Gauss-Newton
steps in their logarithms, with the weights projected out (G. Golub and V. Pereyra, "Separable nonlinear least squares:
the variable projection method and its applications", Inverse Problems 19, 2003), at five orders at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from springpot.machine.arrays import Floats
from springpot.memory.exponential_sum import ExponentialSum, exponential_sum
from springpot.memory.minimax import lag_grid
from springpot.memory.weights import Family, at_lags

_LAGS, _CHECKED_LAGS = 320, 3000
_MOST_MORE = 12  # terms beyond those of one order
_WIDER = 0.25, 0.5, 0.75, 1.0  # shares of the range of orders, one after another
_ROUNDS, _STEPS = 5, 8  # of new weights of the lags, and of Gauss-Newton steps with each
_SHARPER = 0.7  # power of the error by which a lag weighs more
_DAMPING = 1e-6  # of a step, of the squares of scaled slopes
_NODES = 16  # orders whose weights are fitted


@dataclass(frozen=True, eq=False)
class CommonRates:
    """Sums of all orders of a range with the same rates.

    Attributes
    ----------
    family : {"grunwald", "average"}
    low, high : float
        Ends of the range of orders.
    rates : ndarray
        Per step.
    lags, importance : ndarray
        By which the weights of an order are fitted.
    steps : int
    """

    family: Family
    low: float
    high: float
    rates: Floats
    lags: Floats
    importance: Floats
    steps: int

    def __call__(self, order: float) -> ExponentialSum:
        """The sum of an order in the range."""
        nodes, of_nodes = self._at_nodes
        near = (-1.0) ** np.arange(_NODES) * np.sin((np.arange(_NODES) + 0.5) * np.pi / _NODES)
        away = order - nodes
        shares = near / away if away.all() else (away == 0.0).astype(float)
        weights = self.rates**order * (shares @ of_nodes) / shares.sum()
        return ExponentialSum(self.rates, weights, self._error(order, weights), 1.0, float(self.steps))

    @cached_property
    def _at_nodes(self) -> tuple[Floats, Floats]:
        """Chebyshev's points in the range, and the weights there without their usual power of the rate."""
        places = np.cos((np.arange(_NODES) + 0.5) * np.pi / _NODES)
        nodes = 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * places
        found = [_fitted(self.family, float(order), self.rates, self.lags, self.importance)[0] for order in nodes]
        return nodes, np.array(found) / self.rates ** nodes[:, None]

    @cached_property
    def _checked(self) -> tuple[Floats, Floats]:
        """Lags at which errors are looked for, and the terms there."""
        lags = lag_grid(float(self.steps), _CHECKED_LAGS)
        return lags, np.exp(-np.outer(lags, self.rates))

    def _error(self, order: float, weights: Floats) -> float:
        """The largest relative error on a grid of lags; infinite where a weight is negative."""
        if not (weights > 0.0).all():
            return np.inf
        lags, terms = self._checked
        return float(np.abs(terms @ weights / at_lags(self.family, order, lags) - 1.0).max())


def common_rates(family: Family, low: float, high: float, steps: int, tolerance: float = 1e-6) -> CommonRates:
    """Rates for all orders from ``low`` to ``high``, with errors within a tolerance.

    Parameters
    ----------
    family : {"grunwald", "average"}
    low, high : float
        Orders, in (0, 1).
    steps : int
        Longest lag, in steps.
    tolerance : float
        Relative.

    Raises
    ------
    ValueError
        If it is not reached: the range of orders is too wide.

    Examples
    --------
    >>> sums = common_rates("average", 0.28, 0.32, 33_000, 1e-6)
    >>> sums.rates.size, max(sums(order).relative_error for order in (0.28, 0.293, 0.3, 0.32)) <= 1e-6
    (18, True)
    >>> exponential_sum("average", 0.3, 33_000, 1e-6).rates.size  # of one order alone
    17
    """
    middle, lags = 0.5 * (low + high), lag_grid(float(max(steps, 2)), _LAGS)
    one = exponential_sum(family, middle, steps, tolerance)
    begin = np.log(one.rates)
    for more in range(1, _MOST_MORE):
        count = one.rates.size + more
        logs = np.interp(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, begin.size), begin)  # in the same row
        for share in _WIDER:
            orders = middle + share * (np.linspace(low, high, 5) - middle)
            found = _adapted(family, logs, orders, lags, steps, (low, high))
            logs = np.log(found.rates)
        error = max(found(order).relative_error for order in np.linspace(low, high, 9))
        if error <= tolerance:
            return found
        begin = logs if np.isfinite(error) else begin
    raise ValueError(
        f"orders from {low:g} to {high:g} are too far apart for common modes of memory with a tolerance of "
        f"{tolerance:g}: use a larger memory_tolerance, or a narrower law of the order."
    )


def _adapted(
    family: Family, logs: Floats, orders: Floats, lags: Floats, steps: int, ends: tuple[float, float]
) -> CommonRates:  # fmt: skip
    importance, best = np.ones(lags.size), (np.inf, logs, np.ones(lags.size))
    for _ in range(_ROUNDS):
        for _ in range(_STEPS):
            errors, slopes = _joint(family, logs, orders, lags, importance)
            size = np.sqrt((slopes**2).sum(axis=0)) + 1e-300
            rows = slopes / size
            step = np.linalg.solve(rows.T @ rows + _DAMPING * np.eye(size.size), rows.T @ errors) / size
            tried = logs - step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-300))
            if (np.diff(tried) <= 0.0).any():
                break
            after = _joint(family, tried, orders, lags, importance)[0]
            if not after @ after < errors @ errors:
                break
            logs = tried
            if after @ after > 0.97 * (errors @ errors):
                break
        sizes = np.abs(
            [_fitted(family, float(order), np.exp(logs), lags, importance)[1] for order in orders]
        ).max(axis=0)  # fmt: skip
        if sizes.max() < best[0]:
            best = float(sizes.max()), logs, importance
        importance = importance * (sizes / sizes.max() + 1e-3) ** _SHARPER
        importance = importance / importance.max()
    return CommonRates(family, *ends, np.exp(best[1]), lags, best[2], steps)


def _joint(
    family: Family, logs: Floats, orders: Floats, lags: Floats, importance: Floats
) -> tuple[Floats, Floats]:  # fmt: skip
    """Errors of all orders, and their derivatives by the logarithms of the rates, what weights can do projected out."""
    rates, errors, slopes = np.exp(logs), list[Floats](), list[Floats]()
    decay = np.exp(-np.outer(lags, rates))
    for order in orders:
        scaled = decay / at_lags(family, float(order), lags)[:, None] * importance[:, None]
        basis, triangle = np.linalg.qr(scaled)
        weights = np.linalg.solve(triangle, basis.T @ importance)
        errors.append(scaled @ weights - importance)
        moved = -np.outer(lags, rates) * scaled * weights
        slopes.append(moved - basis @ (basis.T @ moved))
    return np.concatenate(errors), np.concatenate(slopes)


def _fitted(
    family: Family, order: float, rates: Floats, lags: Floats, importance: Floats
) -> tuple[Floats, Floats]:  # fmt: skip
    """Weights of one order, and its relative errors at the lags."""
    terms = np.exp(-np.outer(lags, rates)) / at_lags(family, order, lags)[:, None]
    size = np.sqrt((terms**2).sum(axis=0))
    weights = np.linalg.lstsq(terms / size * importance[:, None], importance, rcond=None)[0] / size
    return weights, terms @ weights - 1.0
