"""Numbers chosen so that limits hold and a cost is least: by theory first, then corrected by Monte Carlo."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from springpot.arguments import finite_number
from springpot.designing.numbers import as_simulated, checked_model
from springpot.designing.quantities import MONTE_CARLO, chosen_method, theory_values
from springpot.designing.search import CLOSE, Found, Model, search
from springpot.designing.sensitivities import _samples
from springpot.designing.statement import Cost, Limit, Space, checked_cost, checked_limits, cost_of
from springpot.faults import NotCovered, listed, meant
from springpot.free_numbers import free_numbers, with_values
from springpot.oscillator import Oscillator
from springpot.simulation.accuracy import checked_quantities
from springpot.simulation.run import run
from springpot.simulation.settings import check_stationary, checked_seed, resolve
from springpot.system import System
from springpot.theory.registry import METHODS, SYSTEM_METHODS

if TYPE_CHECKING:
    import xarray

__all__ = ["Curve", "Design", "Promise", "Round", "design"]

Floats = NDArray[np.float64]

MOST_ROUNDS = 4
SPARE = 0.25  # errors beyond those that the wanted probability needs
FURTHER = 0.5  # errors more in each round after the second
NEAR = 1.5  # errors between what a search expects and what Monte Carlo then finds
PILOT_PATHS = 1000  # where Monte Carlo takes the place of theory
AT_BOUND = 1e-4  # of the whole range


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
        return Curve(name, _name_of(self._cost), wanted, costs, tuple(each.values for each in found))

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
        lines = [f"least {_name_of(self._cost)}{f' at which {limits}' if limits else ''}"]
        wide = max(map(len, self.values)) + 2
        for name, value in self.values.items():
            end = {"low": " (its lower bound)", "high": " (its upper bound)"}.get(self.at_bounds.get(name, ""), "")
            lines.append(f"{name:{wide}}{value:.6g}{end}")
        error = f" +- {self.cost_error:.2g}" if self.cost_error > 0.0 else ""
        lines.append(f"cost: {self.cost:.6g}{error}")
        for own in self.promises:
            lines.append(
                f"{own.limit} holds with a probability of {_per_cent(own.probability)}: it is {own.value:.4g} "
                f"+- {own.error:.2g} by Monte Carlo"
            )
        count = len(self.history)
        lines.append(f"search by {self.method}, {count} round{'s' if count > 1 else ''} of Monte Carlo")
        return "\n".join([*lines, *(self.warnings if warnings else ())])

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values; NaN is None."""

        def plain(values: Mapping[str, float]) -> dict[str, float | None]:
            return {name: value if math.isfinite(value) else None for name, value in values.items()}

        return {
            "values": self.values,
            "quantities": plain(self.quantities),
            "errors": plain(self.errors),
            **plain({"cost": self.cost, "cost_error": self.cost_error}),
            "promises": [vars(promise) for promise in self.promises],
            "at_bounds": self.at_bounds,
            "method": self.method,
            "history": [
                {"values": each.values, "quantities": plain(each.quantities), "cost": each.cost,
                 "probability": each.probability}
                for each in self.history
            ],
            "warnings": [*self.warnings],
        }  # fmt: skip

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


def design(
    model: System | Oscillator,
    minimise: Cost,
    subject_to: Mapping[str, tuple[float | None, float | None]],
    *,
    seed: int = 1,
    rtol: float = 0.02,
    probability: float = 0.95,
    method: str | None = None,
    max_time: float | None = None,
    threads: int | None = None,
) -> Design:
    """Choose the free numbers of a model so that limits hold and a cost is least.

    Parameters
    ----------
    model : System or Oscillator
        With numbers marked by `springpot.free`, and a stationary state.
    minimise : str or callable
        The name of a quantity (``"v_mean_square"``) or of a free number, or a function of all of them by name.
    subject_to : dict
        For each limited quantity ``(low, high)``, None where there is no limit.
    seed : int
        Of the places where the search starts, and of Monte Carlo.
    rtol : float
        Relative error of the limited quantities by Monte Carlo, in [1e-4, 0.5], as in `springpot.run`.
    probability : float
        With which all limits must hold, in [0.5, 0.999].
    method : str
        Of the search: the name of an analytical method, or ``"monte_carlo"``.  If left out, the recommended method or
        the best guess; Monte Carlo where there is none.
    max_time : float
        Of each run by Monte Carlo, in s.
    threads : int

    Returns
    -------
    Design

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, or no numbers satisfy the limits: the sentence says by how much they are missed.

    Notes
    -----
    The search is on theory.  Monte Carlo at its end gives the ratio of each quantity to that of theory, and the search
    is repeated with theory times this ratio, and with a distance to each limit that the error of Monte Carlo needs.
    All rounds have the same random numbers.

    Examples
    --------
    The least damping at which a wall is struck less than once in five seconds:

    >>> import springpot as sp
    >>> damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
    >>> device = sp.System(sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
    >>> found = sp.design(device, minimise="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.05)
    >>> found.promises[0].probability > 0.95, 0.15 < found.values["c"] < 0.18
    (True, True)
    """
    problem = checked_model(model, "model")
    free = free_numbers(problem)
    if not free:
        raise ValueError("model must have a free number, such as Spring(sp.free('k', 80.0, (10.0, 200.0))).")
    limits = checked_limits(subject_to, free)
    checked_seed(seed)
    finite_number(rtol, "rtol", low=1e-4, high=0.5)
    finite_number(probability, "probability", low=0.5, high=0.999)
    check_stationary(as_simulated(problem), "design")
    space = Space(free)
    places = _places(space, seed)
    chosen, quick = _quick(problem, space, places, method, seed, threads)
    known = quick({name: float(number) for name, number in free.items()})
    if not known:  # no answer where the numbers start, but there are others
        known = next((found for place in places if (found := quick(space.values(place)))), {})
    cost = checked_cost(minimise, free, known)
    for limit in limits:
        if limit.name not in known:
            near = meant(limit.name, known) or "."
            raise ValueError(f"subject_to must limit quantities among {', '.join(known)}, not {limit.name}{near}")
    controlled = tuple(dict.fromkeys([*(limit.name for limit in limits), *([cost] if cost in known else [])]))
    if controlled:
        checked_quantities(as_simulated(problem), controlled)
    pilot = Model(space, quick, cost, 2e-2 if chosen == MONTE_CARLO else 1e-4)
    measured = _measured(problem, pilot.at, limits, cost, controlled, rtol, max_time, seed, threads)
    history, factors = _rounds(pilot, limits, places, measured, seed, probability, rtol, _is_exact(chosen))
    return _chosen(problem, space, pilot, limits, places, history, factors, cost, chosen, seed, probability)


def _rounds(
    pilot: Model,
    limits: tuple[Limit, ...],
    places: Floats,
    measured: Callable[[Found], Round],
    seed: int,
    probability: float,
    rtol: float,
    exact: bool,
) -> tuple[list[Round], dict[str, float]]:
    """Searches and runs in turn, until the search stays where it is."""
    from scipy import stats

    wanted = _each(probability, len(limits))
    errors_away = float(stats.norm.ppf(wanted)) + SPARE
    history: list[Round] = []
    factors: dict[str, float] = {}
    spread = {limit.name: 0.5 * rtol * abs(limit.bound) for limit in limits}
    for number in range(MOST_ROUNDS):
        away = errors_away + FURTHER * max(number - 1, 0)
        tightened = tuple(_tightened(limit, away * spread.get(limit.name, 0.0)) for limit in limits)
        found = search(pilot, tightened, places, factors, seed)
        if found.excess > CLOSE:
            if number > 0 and search(pilot, limits, places, factors, seed).excess <= CLOSE:
                break  # it holds, but not with the wanted probability: the rounds before tell with which
            raise ValueError(_impossible(limits, found))
        latest = measured(found)
        history.append(latest)
        if not exact:
            factors = _factors(history, [*latest.quantities], factors)
        near = all(
            abs(latest.expected[limit.name] - latest.quantities[limit.name]) <= NEAR * latest.errors[limit.name]
            for limit in limits
        )
        spread = {limit.name: latest.errors[limit.name] for limit in limits}
        if not limits or (near and latest.probability >= wanted):
            break
    return history, factors


def _is_exact(method: str) -> bool:
    """Whether nothing is approximated, so that Monte Carlo has nothing to correct."""
    return method != MONTE_CARLO and {**METHODS, **SYSTEM_METHODS}[method].exact


def _factors(history: list[Round], names: list[str], now: Mapping[str, float]) -> dict[str, float]:
    """Monte Carlo over theory of each quantity: a mean over the rounds, weighted by their errors."""
    factors = dict(now)
    for name in names:
        ratios, weights = [], []
        for each in history:
            theory, value, error = each.theory.get(name, 0.0), each.quantities[name], each.errors[name]
            if theory != 0.0 and value / theory > 0.0 and error > 0.0:
                ratios.append(math.log(value / theory))
                weights.append((value / error) ** 2)
        if ratios:
            factors[name] = math.exp(float(np.average(ratios, weights=weights)))
    return factors


def _measured(
    problem: Oscillator | System,
    plain: Callable[[Floats], dict[str, float]],
    limits: tuple[Limit, ...],
    cost: Cost,
    controlled: tuple[str, ...],
    rtol: float,
    max_time: float | None,
    seed: int,
    threads: int | None,
) -> Callable[[Found], Round]:
    """Monte Carlo of what a search found."""

    def at(found: Found) -> Round:
        model = as_simulated(with_values(problem, found.values))
        wanted: dict[str, Any] = {"quantities": controlled} if controlled else {}
        result = run(model, rtol=rtol, max_time=max_time, seed=seed, threads=threads, **wanted)
        errors = {name: math.nan if error is None else float(error) for name, error in result.errors.items()}
        for name, budget in result.budgets.items():
            parts = budget.standard_error, budget.step_bias, budget.memory_bias, budget.transient
            errors[name] = math.hypot(*parts)
        promises = tuple(_promise(limit, result.values[limit.name], errors[limit.name]) for limit in limits)
        whole = cost_of(cost, {**found.quantities, **result.values, **found.values})
        names = [name for name in result.values if name in found.quantities or name in controlled]
        return Round(
            found.values,
            plain(found.u),
            found.quantities,
            {name: result.values[name] for name in names},
            {name: errors[name] for name in names},
            whole,
            promises,
        )

    return at


def _chosen(
    problem: Oscillator | System,
    space: Space,
    pilot: Model,
    limits: tuple[Limit, ...],
    places: Floats,
    history: list[Round],
    factors: dict[str, float],
    cost: Cost,
    method: str,
    seed: int,
    probability: float,
) -> Design:
    """The cheapest round at which the limits hold, or the most probable one."""
    wanted = _each(probability, len(limits))
    held = [each for each in history if each.probability >= wanted]
    best = min(held, key=lambda each: each.cost) if held else max(history, key=lambda each: each.probability)
    said = []
    if not held:
        said.append(
            f"The limits hold with a probability of {_per_cent(best.probability)} only, not {_per_cent(wanted)}: a "
            "smaller rtol helps."
        )
    ends = {}
    for name, number in free_numbers(problem).items():
        width = AT_BOUND * (number.high - number.low)
        if abs(best.values[name] - number.low) <= width or abs(best.values[name] - number.high) <= width:
            ends[name] = "low" if abs(best.values[name] - number.low) <= width else "high"
            said.append(
                f"{name} is at its {'lower' if ends[name] == 'low' else 'upper'} bound, {best.values[name]:.6g}."
            )
    return Design(
        with_values(problem, best.values),
        best.values,
        best.quantities,
        best.errors,
        best.cost,
        _cost_error(cost, best),
        best.promises,
        ends,
        method,
        tuple(history),
        tuple(said),
        lambda other: search(pilot, other, places, factors, seed),
        limits,
        cost,
    )


def _quick(
    problem: Oscillator | System, space: Space, places: Floats, method: str | None, seed: int, threads: int | None
) -> tuple[str, Callable[[Mapping[str, float]], dict[str, float]]]:
    """The method of the search, and quantities by it; the one with an answer at most of the first places."""
    models = [with_values(problem, space.values(place)) for place in places[:4]]
    names: list[str] = []
    for model in models[:3] if method is None else models[:1]:
        try:
            names.append(chosen_method(model, "theory" if method is None else method)[0])
        except ValueError:
            if method is not None:
                raise
    names = [*dict.fromkeys(names)]
    name = names[0] if len(names) == 1 else MONTE_CARLO
    if len(names) > 1:
        name = max(names, key=lambda each: sum(bool(theory_values(model, each)[0]) for model in models))
    if name != MONTE_CARLO:

        def by_theory(values: Mapping[str, float]) -> dict[str, float]:
            try:
                return theory_values(with_values(problem, values), name)[0]
            except (ValueError, TypeError, NotCovered):
                return {}

        return name, by_theory
    settings = resolve(as_simulated(problem), paths=PILOT_PATHS, seed=seed, threads=threads)

    def by_chance(values: Mapping[str, float]) -> dict[str, float]:
        try:
            found = _samples(as_simulated(with_values(problem, values)), settings, None, 0, 1)
        except (ValueError, TypeError):
            return {}
        return {name: value for name, (value, _, _) in found.items() if math.isfinite(value)}

    return name, by_chance


def _places(space: Space, seed: int) -> Floats:
    """The start, and places spread evenly (Sobol's sequence)."""
    from scipy.stats import qmc

    many = {1: 3, 2: 4, 3: 5}.get(len(space.free), 6)
    spread = qmc.Sobol(len(space.free), rng=seed).random_base2(many)
    return np.vstack([space.start, spread])


def _tightened(limit: Limit, distance: float) -> Limit:
    return Limit(limit.name, limit.bound - distance if limit.upper else limit.bound + distance, limit.upper)


def _promise(limit: Limit, value: float, error: float) -> Promise:
    from scipy import stats

    distance = limit.bound - value if limit.upper else value - limit.bound
    probability = float(stats.norm.cdf(distance / error)) if error > 0.0 else float(distance >= 0.0)
    return Promise(str(limit), value, error, probability)


def _each(probability: float, limits: int) -> float:
    """The probability of each limit that makes that of all (Bonferroni's inequality)."""
    return 1.0 - (1.0 - probability) / max(limits, 1)


def _impossible(limits: tuple[Limit, ...], found: Found) -> str:
    """Which limit is missed, and by how much, where that is least."""
    missed = max(limits, key=lambda limit: limit.excess(found.quantities.get(limit.name, math.inf)))
    value = found.quantities.get(missed.name, math.nan)
    where = listed([f"{name} = {value:.4g}" for name, value in found.values.items()])
    off = abs(value / missed.bound - 1.0) if missed.bound else math.nan
    share = f", {100.0 * off:.3g} % beyond the limit" if math.isfinite(off) else ""
    return f"subject_to cannot hold: {missed} is missed least with {value:.4g}{share}, at {where}."


def _cost_error(cost: Cost, best: Round) -> float:
    """The error of the cost, from those of the quantities that it depends on."""
    if isinstance(cost, str):
        return best.errors.get(cost, 0.0)
    whole = {**best.expected, **best.quantities, **best.values}
    total = 0.0
    for name, error in best.errors.items():
        change = cost_of(cost, {**whole, name: whole[name] + error}) - best.cost if math.isfinite(error) else 0.0
        total = math.hypot(total, change)
    return total


def _name_of(cost: Cost) -> str:
    return cost if isinstance(cost, str) else getattr(cost, "__name__", "cost")


def _per_cent(probability: float) -> str:
    return "over 99.9 %" if probability > 0.999 else f"{100.0 * probability:.3g} %"
