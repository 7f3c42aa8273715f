"""What a design is: numbers, promises, the rounds that led to them, and the trade-off with a limit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.designing.search import CLOSE, Found
from springpot.designing.statement import Cost, Limit, quantile_in
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word, listed, name_results, per_cent
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.catalogue import unit_of_result
from springpot.problem.system import System
from springpot.simulation.estimate.few_events import chance_below

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Promise:
    """One limit, and the probability that it holds.

    Attributes
    ----------
    limit : str
        In words, as ``impact_rate < 0.2``.
    value, error : float
        Of the quantity by Monte Carlo: its standard error together with its biases, each as uniform between its bounds
        (JCGM 100, "Guide to the expression of uncertainty in measurement", 2008, section 4.3.7).
    probability : float
        That the true value is within the limit: the tail of a normal distribution, or that of Poisson's where Monte
        Carlo saw no event.  NaN if it saw too few for an error.
    """

    limit: str
    value: float
    error: float
    probability: float

    @classmethod
    def of(cls, limit: Limit, value: float, error: float) -> Promise:
        """The promise of a limit whose quantity has this value and error; NaN without an error, as without events.

        Examples
        --------
        >>> round(Promise.of(Limit("impact_rate", 0.2, True), 0.19, 0.01).probability, 4)
        0.8413
        """
        from scipy import stats

        if not error > 0.0:
            probability = math.nan
        elif value == 0.0:  # of an event that was not seen
            probability = chance_below(limit.bound, error) if limit.upper else 0.0
        else:
            distance = limit.bound - value if limit.upper else value - limit.bound
            probability = float(stats.norm.cdf(distance / error))
        return cls(str(limit), value, error, probability)


@dataclass(frozen=True, eq=False)
class Round:
    """One round: numbers chosen, and Monte Carlo of them.

    Attributes
    ----------
    values : dict
        The free numbers.
    theory, expected : dict
        Quantities by theory, and by theory with the corrections of the rounds before.
    measured, measured_errors : dict
        By the Monte Carlo of this round alone.
    quantities, errors : dict
        By Monte Carlo, this round and those before it together.
    cost : float
    promises : tuple of Promise
    """

    values: dict[str, float]
    theory: dict[str, float]
    expected: dict[str, float]
    measured: dict[str, float]
    measured_errors: dict[str, float]
    quantities: dict[str, float]
    errors: dict[str, float]
    cost: float
    promises: tuple[Promise, ...]

    @property
    def probability(self) -> float:
        """Of the least certain limit; 1 without limits, 0 where one is not known."""
        return min((0.0 if math.isnan(own.probability) else own.probability for own in self.promises), default=1.0)


@dataclass(frozen=True, eq=False)
class Curve:
    """The trade-off between the cost and one limit.

    Attributes
    ----------
    name, cost_name : str
        The limited quantity, and the cost.
    unit, cost_unit : str
        Theirs; empty where only the user knows it.
    upper : bool
        Whether the quantity must stay below the limit, and not above.
    limits, costs : ndarray
        The limit, and the least cost; NaN where it cannot hold.
    values : tuple of dict
        The free numbers at each point; where the limit cannot hold, those of the nearest, or of the design.
    greatest : bool
        Whether the costs are the greatest, and not the least.
    """

    name: str
    cost_name: str
    unit: str
    cost_unit: str
    upper: bool
    limits: Floats
    costs: Floats
    values: tuple[dict[str, float], ...]
    greatest: bool = False


@dataclass(frozen=True, eq=False)
class Design:
    """Numbers of least cost at which the limits hold.

    Attributes
    ----------
    model : System
        With the chosen values in place of the free numbers.
    values : dict
        They, by name.
    quantities, errors : dict
        By Monte Carlo of all rounds, with errors: standard error, biases and, if these numbers were not
        simulated themselves but some that are close, what theory's ratio may change between them.
    cost, cost_error : float
        What was minimized or maximized: by theory and without an error where the method of the search is exact, else by
        Monte Carlo.  The error is NaN for a function of quantities whose errors are not known.
    margin : float
        By how much the cost is above the least one (below the greatest) at the limits themselves, relative to it, as
        corrected theory has it: the price of the distance to the limits.
    promises : tuple of Promise
        Each limit with its probability.
    at_bounds : dict
        ``"low"`` or ``"high"`` for each number that ended at a bound.
    method : str
        Of the search.
    history : tuple of Round
        Every round of theory and Monte Carlo, in order; the design is one of them, or close to the last.
    warnings : tuple of str
    """

    model: System
    values: dict[str, float]
    quantities: dict[str, float]
    errors: dict[str, float]
    cost: float
    cost_error: float
    margin: float
    promises: tuple[Promise, ...]
    at_bounds: dict[str, str]
    method: str
    history: tuple[Round, ...]
    warnings: tuple[str, ...]
    _search: Callable[[tuple[Limit, ...], Found | None], Found] = field(repr=False)
    _limits: tuple[Limit, ...] = ()
    _cost: Cost = field(default=Cost("", ("",)), repr=False)
    _units: Mapping[str, str] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        name_results(self, "values", "quantities", "errors")

    @property
    def units(self) -> dict[str, str]:
        """The unit of every quantity and of every chosen number, by name.

        Examples
        --------
        >>> import springpot as sp
        >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
        >>> device = sp.System(sp.Spring(4.0), damper, sp.WhiteNoise(1.0))
        >>> sp.design(device, minimize="c", subject_to={"v_mean_square": (None, 1.5)}, rtol=0.1).units["v_mean_square"]
        'm2 s-2'
        """
        own = {name: unit_of_result(self.model, quantile_in(name)[0]) for name in self.quantities}
        return own | dict(self._units)

    def curve(self, name: str | None = None, limits: Any = None) -> Curve:
        """The least cost (or greatest, if it is maximized) against one limit, the other limits as they are.

        It is by theory, corrected by the ratio of Monte Carlo to theory at this design: a single run with other limits
        confirms a point.

        Parameters
        ----------
        name : str
            Of the limited quantity; that of the first limit if left out.  A quantity without a limit gets an upper one.
        limits : array_like
            From half the limit to twice it if left out.

        Returns
        -------
        Curve

        Raises
        ------
        TypeError, ValueError
            If the quantity is unknown, a limit is not a number, or limits are left out and there is none.

        Examples
        --------
        >>> import springpot as sp
        >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
        >>> device = sp.System(sp.Spring(4.0), damper, sp.WhiteNoise(1.0))
        >>> found = sp.design(device, minimize="c", subject_to={"v_mean_square": (None, 1.5)}, rtol=0.1)
        >>> curve = found.curve("v_mean_square", [1.0, 1.5])
        >>> bool(curve.costs[0] > curve.costs[1])
        True
        """
        if name is None and self._limits:
            name = self._limits[0].name
        name = known_word(name, self.quantities, "name", "must be among")
        own = [limit for limit in self._limits if limit.name == name]
        upper = not own or any(limit.upper for limit in own)
        if limits is None:
            bound = next((limit.bound for limit in own if limit.upper == upper), 0.0)
            if bound == 0.0:
                raise ValueError(f"limits must be given: {name} has no limit, or one of 0.")
            limits = bound * np.geomspace(0.5, 2.0, 13)
        wanted = np.atleast_1d(np.asarray(limits, float))
        if wanted.ndim != 1 or not np.isfinite(wanted).all():
            raise ValueError("limits must be finite numbers, one after the other.")
        others = tuple(limit for limit in self._limits if limit.name != name or limit.upper != upper)
        costs, values = np.full(wanted.size, math.nan), [self.values] * wanted.size
        near: Found | None = None
        for place in np.argsort(-wanted if upper else wanted):  # where one cannot hold, a tighter one cannot either
            near = self._search((*others, Limit(name, float(wanted[place]), upper)), near)
            values[place] = near.values
            if near.excess > CLOSE:
                break
            costs[place] = self._cost.signed(near.cost)
        units = self.units[name], self.units.get(self._cost.name, "")
        return Curve(name, self._cost.name, *units, upper, wanted, costs, tuple(values), self._cost.greatest)

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
        >>> device = sp.System(sp.Spring(4.0), damper, sp.WhiteNoise(1.0))
        >>> found = sp.design(device, minimize="c", subject_to={"v_mean_square": (None, 1.5)}, rtol=0.1)
        >>> found.report().splitlines()[0]
        'least c at which v_mean_square < 1.5'
        """
        limits = listed([promise.limit for promise in self.promises]) if self.promises else ""
        lines = [f"{self._cost.extreme} {self._cost.name}{f' at which {limits}' if limits else ''}"]
        wide = max(map(len, self.values)) + 2
        for name, value in self.values.items():
            end = {"low": " (its lower bound)", "high": " (its upper bound)"}.get(self.at_bounds.get(name, ""), "")
            lines.append(f"{name:{wide}}{value:.6g}{self._unit(name)}{end}")
        error = f" +- {self.cost_error:.2g}" if self.cost_error > 0.0 else ""
        unit = self._unit(self._cost.name)
        above = f", {per_cent(self.margin)} for the distance to the limits" if self.margin > 0.0 else ""
        lines.append(f"{'gain' if self._cost.greatest else 'cost'}: {self.cost:.6g}{error}{unit}{above}")
        for own in self.promises:
            if math.isnan(own.probability):
                lines.append(f"{own.limit}: Monte Carlo saw too few events to tell with which probability it holds")
                continue
            lines.append(
                f"{own.limit} holds with a probability of {in_words(own.probability)}: it is {own.value:.4g} "
                f"+- {own.error:.2g}{self._unit(own.limit.split()[0])} by Monte Carlo"
            )
        count = len(self.history)
        lines.append(f"search by {self.method}, {count} round{'s' if count > 1 else ''} of Monte Carlo")
        return "\n".join([*lines, *(self.warnings if warnings else ())])

    def _unit(self, name: str) -> str:
        """The unit of a quantity or a number after a space; empty where there is none, or only the user knows it."""
        unit = self.units.get(name, "")
        return f" {unit}" if unit not in ("", "1") else ""

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values; NaN is None."""
        names = "values", "quantities", "errors", "cost", "cost_error", "margin", "at_bounds", "method", "warnings"
        of_round = "values", "quantities", "cost", "probability"
        more = {
            "promises": self.promises,
            "history": [{name: getattr(each, name) for name in of_round} for each in self.history],
        }
        return plain({name: getattr(self, name) for name in names} | more)

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset over ``number`` (values), ``quantity`` (with errors) and ``limit`` (probabilities)."""
        need("files", "to_xarray()")
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


def in_words(probability: float) -> str:
    """A probability in per cent; one of nearly 1 is not stated closer than it is known."""
    return "over 99.9 %" if probability > 0.999 else per_cent(probability, 3)
