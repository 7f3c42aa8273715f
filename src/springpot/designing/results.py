"""What a design is: numbers, promises, the rounds that led to them, and the trade-off with a limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from springpot.designing.search import CLOSE, Found
from springpot.designing.statement import Cost, Limit, name_of
from springpot.faults import listed, meant
from springpot.oscillator import Oscillator
from springpot.plain import plain
from springpot.system import System

if TYPE_CHECKING:
    import xarray

__all__ = ["Curve", "Design", "Promise", "Round", "per_cent"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Promise:
    """One limit, and the probability that it holds.

    Attributes
    ----------
    limit : str
        In words, as ``impact_rate < 0.2``.
    value, error : float
        Of the quantity by Monte Carlo, with its standard error and bounds on its biases together.
    probability : float
        That the true value is within the limit: the tail of a normal distribution.
    """

    limit: str
    value: float
    error: float
    probability: float


@dataclass(frozen=True, eq=False)
class Round:
    """One round: numbers chosen, and Monte Carlo of them.

    Attributes
    ----------
    values : dict
        The free numbers.
    theory, expected : dict
        Quantities by theory, and by theory with the corrections of the rounds before.
    quantities, errors : dict
        By Monte Carlo.
    cost : float
    promises : tuple of Promise
    """

    values: dict[str, float]
    theory: dict[str, float]
    expected: dict[str, float]
    quantities: dict[str, float]
    errors: dict[str, float]
    cost: float
    promises: tuple[Promise, ...]

    @property
    def probability(self) -> float:
        """Of the least certain limit; 1 without limits."""
        return min((promise.probability for promise in self.promises), default=1.0)


@dataclass(frozen=True, eq=False)
class Curve:
    """The trade-off between the cost and one limit.

    Attributes
    ----------
    name, cost_name : str
        The limited quantity, and the cost.
    limits, costs : ndarray
        The limit, and the least cost; NaN where it cannot hold.
    values : tuple of dict
        The free numbers at each point.
    """

    name: str
    cost_name: str
    limits: Floats
    costs: Floats
    values: tuple[dict[str, float], ...]


@dataclass(frozen=True, eq=False)
class Design:
    """Numbers of least cost at which the limits hold.

    Attributes
    ----------
    model : System or Oscillator
        With the chosen values in place of the free numbers.
    values : dict
        They, by name.
    quantities, errors : dict
        By Monte Carlo, with errors: standard error and bounds on biases together.
    cost, cost_error : float
        What was minimised; the error is NaN for a function of quantities whose errors are not known.
    promises : tuple of Promise
        Each limit with its probability.
    at_bounds : dict
        ``"low"`` or ``"high"`` for each number that ended at a bound.
    method : str
        Of the search.
    history : tuple of Round
        Every round of theory and Monte Carlo, in order.
    warnings : tuple of str
    """

    model: System | Oscillator
    values: dict[str, float]
    quantities: dict[str, float]
    errors: dict[str, float]
    cost: float
    cost_error: float
    promises: tuple[Promise, ...]
    at_bounds: dict[str, str]
    method: str
    history: tuple[Round, ...]
    warnings: tuple[str, ...]
    _search: Callable[[tuple[Limit, ...]], Found] = field(repr=False)
    _limits: tuple[Limit, ...] = ()
    _cost: Cost = ""

    def curve(self, name: str, limits: Any) -> Curve:
        """The least cost against one upper limit, the other limits as they are.

        It is by theory, corrected by the ratio of Monte Carlo to theory at this design: a single run with other limits
        confirms a point.

        Parameters
        ----------
        name : str
            Of the limited quantity.
        limits : array_like
            Upper limits.

        Returns
        -------
        Curve

        Raises
        ------
        TypeError, ValueError
            If the quantity is unknown or a limit is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
        >>> device = sp.System(sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
        >>> found = sp.design(device, minimise="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.1)
        >>> curve = found.curve("impact_rate", [0.1, 0.2])
        >>> bool(curve.costs[0] > curve.costs[1])
        True
        """
        wanted = np.atleast_1d(np.asarray(limits, float))
        if name not in self.quantities:
            raise ValueError(
                f"name must be among {', '.join(self.quantities)}, not {name}{meant(name, self.quantities) or '.'}"
            )
        if wanted.ndim != 1 or not np.isfinite(wanted).all():
            raise ValueError("limits must be finite numbers, one after the other.")
        others = tuple(limit for limit in self._limits if limit.name != name or not limit.upper)
        found = [self._search((*others, Limit(name, float(bound), upper=True))) for bound in wanted]
        costs = np.array([each.cost if each.excess <= CLOSE else math.nan for each in found])
        return Curve(name, name_of(self._cost), wanted, costs, tuple(each.values for each in found))

    def report(self, warnings: bool = True) -> str:
        """All of it in words.

        Parameters
        ----------
        warnings : bool
            With the warnings at its end.

        Examples
        --------
        >>> import springpot as sp
        >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
        >>> device = sp.System(sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
        >>> found = sp.design(device, minimise="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.1)
        >>> found.report().splitlines()[0]
        'least c at which impact_rate < 0.2'
        """
        limits = listed([promise.limit for promise in self.promises]) if self.promises else ""
        lines = [f"least {name_of(self._cost)}{f' at which {limits}' if limits else ''}"]
        wide = max(map(len, self.values)) + 2
        for name, value in self.values.items():
            end = {"low": " (its lower bound)", "high": " (its upper bound)"}.get(self.at_bounds.get(name, ""), "")
            lines.append(f"{name:{wide}}{value:.6g}{end}")
        error = f" +- {self.cost_error:.2g}" if self.cost_error > 0.0 else ""
        lines.append(f"cost: {self.cost:.6g}{error}")
        for own in self.promises:
            lines.append(
                f"{own.limit} holds with a probability of {per_cent(own.probability)}: it is {own.value:.4g} "
                f"+- {own.error:.2g} by Monte Carlo"
            )
        count = len(self.history)
        lines.append(f"search by {self.method}, {count} round{'s' if count > 1 else ''} of Monte Carlo")
        return "\n".join([*lines, *(self.warnings if warnings else ())])

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values; NaN is None."""
        kept = "values", "quantities", "cost", "probability"
        return plain(
            {
                "values": self.values,
                "quantities": self.quantities,
                "errors": self.errors,
                "cost": self.cost,
                "cost_error": self.cost_error,
                "promises": [vars(promise) for promise in self.promises],
                "at_bounds": self.at_bounds,
                "method": self.method,
                "history": [{name: getattr(each, name) for name in kept} for each in self.history],
                "warnings": self.warnings,
            }
        )

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset over ``number`` (values), ``quantity`` (with errors) and ``limit`` (probabilities)."""
        import xarray

        return xarray.Dataset(
            {
                "value": ("number", [*self.values.values()]),
                "measured": ("quantity", [*self.quantities.values()]),
                "error": ("quantity", [self.errors[name] for name in self.quantities]),
                "probability": ("limit", [promise.probability for promise in self.promises]),
                "cost": self.cost,
            },
            coords={
                "number": [*self.values],
                "quantity": [*self.quantities],
                "limit": [promise.limit for promise in self.promises],
            },
        )


def per_cent(probability: float) -> str:
    """A probability in words."""
    return "over 99.9 %" if probability > 0.999 else f"{100.0 * probability:.3g} %"
