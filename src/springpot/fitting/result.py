"""The result of a fit: numbers with errors, what they share, and how good the fit is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from springpot.fitting.estimate import Confusion, Solution, known_together, profile_along, profile_ends
from springpot.fitting.likelihood import Coordinates, Likelihood, Table
from springpot.fitting.posterior import log_likelihood, log_prior, numbers_in, start_ensemble
from springpot.machine.arguments import Free, Uncertain, check_whole, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, known_word, listed, name_results, shown
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.numbers import numbers_of
from springpot.problem.system import system_of
from springpot.problem.uncertain import uncertain

if TYPE_CHECKING:
    import xarray

    from springpot.fitting.driven_records import Prediction

_DOUBTFUL = 0.01
_LARGEST_OF_ORDER = 0.1  # standard error
_BESIDE_ORDER = 0.9  # correlation with a vague order, from which an interval is that of a profile
_BESIDE_HELD = 0.5  # the same, where the order is held at a bound: errors of the others are for that value
_WIDENED = 3  # profiles at most, each three times as wide
_MOST_WALKERS = 100_000


@dataclass(frozen=True)
class Choice:
    """One of several models that were fitted to the same data.

    Attributes
    ----------
    label : str
        Its parts.
    numbers : int
        Of free numbers, with an estimated scatter.
    bic, aicc : float
        Bayesian information criterion, and Akaike's with its correction for few data: smaller is better.
    """

    label: str
    numbers: int
    bic: float
    aicc: float


@dataclass(frozen=True)
class Check:
    """How good a fit is.

    Attributes
    ----------
    probabilities : dict
        For each test the probability of so large a misfit by chance, if the model is right.
    sentences : tuple of str
        What speaks against the fit; empty if nothing does.
    """

    probabilities: dict[str, float]
    sentences: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether no test has a probability below one in a hundred."""
        return not self.sentences


@dataclass(frozen=True, eq=False)
class Profile:
    """How much worse the best fit becomes when one number is moved.

    Attributes
    ----------
    name : str
    values : ndarray, shape (n,)
        Of the number.
    rise : ndarray, shape (n,)
        Of the deviance, -2 ln L; divided by the scatter where that is estimated.
    limits : (float, float)
        Of the 95 % interval; a bound where the data do not limit it.
    level : float
        The rise at these limits.
    """

    name: str
    values: Floats
    rise: Floats
    limits: tuple[float, float]
    level: float


@dataclass(frozen=True, eq=False)
class Fit:
    """The numbers that agree best with data.

    Attributes
    ----------
    model : System, part or function, or a tuple of them
        With the found values in place of the free numbers; a function as it was given.
    given : System, part or function, or a tuple of them
        The same model as it was given, with its free numbers.
    data
        What it was fitted to; a tuple where there are several data sets.
    values, errors : dict
        By name: the value, and its standard error; NaN for a number that is held at a bound.
    at_bounds : dict
        ``"low"`` or ``"high"`` for each number that is held at a bound.
    not_told_apart : tuple of Confusion
        Numbers whose errors have a correlation of 0.95 or more and are larger than a quarter: the data do not tell
        them apart.
    extras : dict
        What was estimated with the rest, such as ``relative_error``.
    covariance, correlations : ndarray, shape (numbers, numbers)
        Of the errors, in the order of ``values``; NaN in the covariance for numbers that are held at a bound.
    deviance : float
        -2 ln L, up to a constant of the data.
    bic, aicc : float
        Bayesian information criterion, and Akaike's with its correction for few data.
    choices : tuple of Choice
        Where several models were given: each of them, the best first.
    table : Table
        Data, fit and residuals, point by point.
    """

    model: Any
    given: Any
    data: Any
    values: dict[str, float]
    errors: dict[str, float]
    at_bounds: dict[str, str]
    not_told_apart: tuple[Confusion, ...]
    extras: dict[str, float]
    covariance: Floats
    correlations: Floats
    deviance: float
    bic: float
    aicc: float
    table: Table
    _likelihood: Likelihood = field(repr=False)
    _best: Solution = field(repr=False)
    choices: tuple[Choice, ...] = ()

    def __post_init__(self) -> None:
        name_results(self, "values", "errors")

    @property
    def residuals(self) -> Floats:
        """Differences of data and fit, in standard deviations."""
        return self.table.residual

    @property
    def degrees_of_freedom(self) -> int:
        """Data less the numbers that were found."""
        return self._likelihood.size - int(self._best.moves.sum())

    @property
    def known_together(self) -> tuple[str, ...]:
        """One sentence for each two numbers whose errors have a correlation of 0.95 or more: what is known of both."""
        return known_together(self.names, self._coordinates.logarithmic, self._inner_covariance)

    def correlation(self, first: str, second: str) -> float:
        """The correlation of the errors of two numbers.

        Raises
        ------
        ValueError
            If a name is unknown.

        Examples
        --------
        >>> import numpy as np
        >>> import springpot as sp
        >>> rubber = sp.Springpot(sp.free("order", 0.4, (0.01, 0.99)), sp.free("C", 1.0, (0.1, 10.0)))
        >>> f = np.geomspace(0.1, 10.0, 12)
        >>> p = 2j * np.pi * f
        >>> fit = sp.fit(rubber, sp.MeasuredModuli(f, (2.0 * p**0.3).real, (2.0 * p**0.3).imag, relative_error=0.02))
        >>> round(fit.correlation("order", "C"), 2)
        -0.78
        """
        return float(self.correlations[self._place(first), self._place(second)])

    def interval(self, name: str, probability: float = 0.95) -> tuple[float, float]:
        """An interval that holds the true number with this probability.

        It is symmetric in the logarithm of a number that can only be positive; Student's distribution is used where
        the scatter of the data is estimated.

        Parameters
        ----------
        name : str
        probability : float

        Returns
        -------
        (float, float)
            NaN for a number that is held at a bound.

        Raises
        ------
        TypeError, ValueError
            If the name is unknown, or the probability not between 0 and 1.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
        >>> fit = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
        >>> [round(end, 3) for end in fit.interval("r")]
        [0.687, 0.716]
        """
        number = self._coordinates.free[self._place(name)]
        wanted = finite_number(probability, "probability", low=0.0, high=1.0, open_low=True)
        low, high = self._ends(name, min(wanted, 1.0 - 1e-12))
        return (math.nan, math.nan) if math.isnan(low) else (max(low, number.low), min(high, number.high))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the free numbers, in the order in which `log_likelihood` takes them."""
        return self._coordinates.names

    @property
    def bounds(self) -> dict[str, tuple[float, float]]:
        """The lowest and the highest value of each number."""
        return {number.name: (number.low, number.high) for number in self._coordinates.free}

    def log_likelihood(self, numbers: ArrayLike | Mapping[str, float]) -> float:
        """The logarithm of the likelihood at any numbers, for samplers such as emcee.

        Where the scatter of the data is not known, it is the one that agrees best at these numbers.

        Parameters
        ----------
        numbers : array_like or mapping
            Values in the order of ``names``, in the units of ``values``; or by name.

        Returns
        -------
        float
            -inf beyond the bounds.

        Raises
        ------
        TypeError, ValueError
            If they are not a number for each name.
        NotCoveredError
            If the fit is to `MeasuredStatistics`.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79], error=0.02)
        >>> fit = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
        >>> round(fit.log_likelihood(fit.values) - fit.log_likelihood([0.69]), 2), fit.log_likelihood([1.2])
        (2.38, -inf)
        """
        return log_likelihood(self._likelihood, numbers_in(self._coordinates, numbers))

    def log_prior(self, numbers: ArrayLike | Mapping[str, float]) -> float:
        """The logarithm of a prior density that is flat between the bounds: in the logarithm, where both are positive.

        Parameters
        ----------
        numbers : array_like or mapping
            Values in the order of ``names``, or by name.

        Returns
        -------
        float
            -inf beyond the bounds.

        Raises
        ------
        TypeError, ValueError
            If they are not a number for each name.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79], error=0.02)
        >>> fit = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
        >>> round(fit.log_prior([0.5]), 3), fit.log_prior([1.2])
        (-0.141, -inf)
        """
        return log_prior(self._coordinates, numbers_in(self._coordinates, numbers))

    def start_ensemble(self, walkers: int, seed: int = 1) -> Floats:
        """Numbers from which the chains of a sampler start: drawn from the errors of the fit, between the bounds.

        Parameters
        ----------
        walkers : int
        seed : int

        Returns
        -------
        ndarray, shape (walkers, numbers)

        Raises
        ------
        ValueError
            If there are none, or too many.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79], error=0.02)
        >>> fit = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
        >>> fit.start_ensemble(8).shape
        (8, 1)
        """
        check_whole(walkers, "walkers", 1, _MOST_WALKERS)
        return start_ensemble(self._coordinates, self._best.u, self._inner_covariance, walkers, seed)

    def uncertain(self) -> dict[str, Uncertain]:
        """The numbers as uncertain ones, for `springpot.scatter`: what is not known of one device.

        They are normal with their errors and correlations, in the logarithm where only positive numbers are allowed,
        within their bounds.  All are one input of `springpot.scatter`, for their errors depend on each other.

        Returns
        -------
        dict of Uncertain
            By name; `springpot.with_values` puts them into a model.

        Raises
        ------
        ValueError
            If a number is held at a bound or its 95 % interval leaves the bounds, or an order has an error above 0.1:
            the errors are not normal then.

        Examples
        --------
        >>> import numpy as np
        >>> import springpot as sp
        >>> f = np.geomspace(0.1, 100.0, 16)
        >>> modulus = 3.0 + 2.0 * (2j * np.pi * f) ** 0.4
        >>> noise = 1.0 + 0.02 * np.random.default_rng(1).standard_normal((2, f.size))
        >>> silicone = sp.System(
        ...     sp.Spring(sp.free("k", 1.0, (0.01, 100.0))),
        ...     sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0))),
        ... )
        >>> fit = sp.fit(silicone, sp.MeasuredModuli(f, modulus.real * noise[0], modulus.imag * noise[1]))
        >>> device = sp.System(*sp.with_values(silicone, fit.uncertain()).parts, sp.WhiteNoise(1.0))
        >>> sp.scatter(device, ["x_mean_square"], method="linear", devices=64).inputs
        ('k and order and C',)
        """
        found, own, orders = dict[str, Uncertain](), self._coordinates, _orders(self.given)
        for place, (number, is_log) in enumerate(zip(own.free, own.logarithmic, strict=True)):
            name, (low, high) = number.name, self._ends(number.name, 0.95)
            if not number.low <= low < high <= number.high:
                ends = "it is held at a bound" if math.isnan(low) else f"its 95 % interval is {low:.4g} to {high:.4g}"
                raise ValueError(
                    f"{name} must be known better to be an uncertain number: {ends}, with bounds of {number.low:g} and "
                    f"{number.high:g}; take rows of a chain, as sp.uncertain({name!r}, values=...)."
                )
            if name in orders and self.errors[name] > _LARGEST_OF_ORDER:
                raise ValueError(
                    f"{name} must be known to {_LARGEST_OF_ORDER:g} to be an uncertain number, not to "
                    f"{self.errors[name]:.2g}: so large errors of an order are not normal."
                )
            size = self.errors[name] / float(own.slope(self._theta)[place])
            found[name] = uncertain(
                name, self.values[name], bounds=(number.low, number.high), **{"log_sd" if is_log else "sd": size},
                correlation={other: self.correlation(name, other) for other in self.values if other != name},
            )  # fmt: skip
        return found

    def _ends(self, name: str, probability: float) -> tuple[float, float]:
        """Of an interval that may leave the bounds."""
        from scipy import stats

        place, value, half = self._place(name), self.values[name], 0.5 * (1.0 + probability)
        law = stats.norm if self._likelihood.known else stats.t(max(self.degrees_of_freedom, 1))
        reach = float(law.ppf(half)) * self.errors[name] / float(self._coordinates.slope(self._theta)[place])
        if self._coordinates.logarithmic[place]:
            return value * math.exp(-min(reach, 600.0)), value * math.exp(min(reach, 600.0))
        return value - reach, value + reach

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """95 % intervals as the report has them.

        They are those of `interval`, or of `profile` where the former reach impossible values, of numbers that are held
        at a bound, where the error of an order is above 0.1, and of numbers that the data do not tell apart from such
        an order.
        """
        return {name: self._profiled.get(name) or self.interval(name) for name in self.values}

    @cached_property
    def _profiled(self) -> dict[str, tuple[float, float]]:
        own, vague = self._likelihood, [self._place(name) for name in self._vague_orders]
        if own.simulated or own.stopped:
            return {}
        least = [_BESIDE_ORDER if self._best.moves[place] else _BESIDE_HELD for place in vague]
        beside = np.any(np.abs(self.correlations[:, vague]) >= least, axis=1).tolist()
        found = {}
        for number, with_order in zip(own.coordinates.free, beside, strict=True):
            low, high = self._ends(number.name, 0.95)
            if with_order or not number.low <= low < high <= number.high:
                place = self._place(number.name)
                level = self._level * own.scatter(self._theta, int(self._best.moves.sum()))
                ends = profile_ends(own, self._best, place, self._covariance_of_all, level)
                found[number.name] = self._outer(place, ends[0]), self._outer(place, ends[1])
        return found

    @property
    def _vague_orders(self) -> list[str]:
        """Orders whose error is large, or that are held at a bound."""
        orders = _orders(self.given)
        return [name for name, error in self.errors.items() if name in orders and not error <= _LARGEST_OF_ORDER]

    def profile(self, name: str, points: int = 21) -> Profile:
        """How the best fit becomes worse when one number is moved and the others follow.

        Parameters
        ----------
        name : str
        points : int
            Number of values, within four standard errors and the bounds; within three times as many, or nine, where
            the fit is not clearly worse there.

        Returns
        -------
        Profile

        Raises
        ------
        TypeError, ValueError
            If the name is unknown, or points fewer than 5.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
        >>> fit = sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts)
        >>> [round(end, 3) for end in fit.profile("r").limits]
        [0.687, 0.716]
        """
        place = self._place(name)
        if isinstance(points, bool) or not isinstance(points, int) or points < 5:
            raise ValueError(f"points must be a whole number, at least 5, not {shown(points)}.")
        likelihood, best, own = self._likelihood, self._best, self._coordinates
        variance, level = float(self._covariance_of_all[place, place]), self._level
        reach = 4.0 * math.sqrt(variance) if 0.0 < variance < math.inf else math.inf
        for _ in range(_WIDENED):
            low, high = max(best.u[place] - reach, own.low[place]), min(best.u[place] + reach, own.high[place])
            u = np.unique(np.append(np.linspace(low, high, points), best.u[place]))
            rise = profile_along(likelihood, best, place, u) - best.deviance
            rise = rise / likelihood.scatter(self._theta, int(best.moves.sum()))
            if (rise[0] > level or low == own.low[place]) and (rise[-1] > level or high == own.high[place]):
                break
            reach *= 3.0
        ends = _crossings(u, rise, level, float(best.u[place]))
        values = [self._outer(place, float(each)) for each in (*u, *ends)]
        return Profile(name, np.array(values[:-2]), np.maximum(rise, 0.0), (values[-2], values[-1]), level)

    def predict(self, record: Any) -> Prediction:
        """What the model with the found numbers makes of another record of the same device, with its measured input.

        x and v at its first sample are found from its first ``skip`` seconds, or from all of it if ``skip`` is 0; all
        other numbers are those of the fit.

        Parameters
        ----------
        record : MeasuredRecord
            Of the same points, with its input.

        Returns
        -------
        Prediction
            With the error that the errors of the numbers bring, and what is left of the record.

        Raises
        ------
        NotCoveredError
            If the fit is not of a record with its measured input.
        TypeError, ValueError
            If the record is another one.

        Examples
        --------
        >>> import numpy as np
        >>> import springpot as sp
        >>> rng, time = np.random.default_rng(1), 0.1 * np.arange(400)
        >>> def shaken(force):
        ...     drive = sp.RecordedExcitation(time, force, "mass")
        ...     return sp.simulate(sp.System(sp.Spring(4.0), sp.Dashpot(0.4), drive), paths=1, record=1, duration=39.9,
        ...                        step=0.1, start="rest", threads=1).record[0, :, 0]
        >>> forces = rng.standard_normal((2, 400))
        >>> first, second = (sp.MeasuredRecord(time, shaken(f) + 0.01 * rng.standard_normal(400), input=f, start="rest",
        ...                                    interpolation="linear") for f in forces)
        >>> model = sp.System(sp.Spring(sp.free("k", 3.0, (1.0, 9.0))), sp.Dashpot(sp.free("c", 0.3, (0.1, 1.0))))
        >>> fit = sp.fit(model, first)
        >>> fit.predict(second).share < 0.1
        True
        """
        predicted = getattr(self._likelihood, "predicted", None)
        if predicted is None:
            raise NotCoveredError("a prediction is of a record with its measured input, and this fit is of other data.")
        return cast("Prediction", predicted(self._theta, self.covariance, record))

    def check(self) -> Check:
        """Tests of the fit: the size and the order of the residuals, as far as the data allow them.

        Returns
        -------
        Check

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79], error=0.02)
        >>> sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts).check().passed
        True
        """
        tests = self._likelihood.checks(self._theta, int(self._best.moves.sum()))
        said = [
            f"{name}: {meaning} (probability {probability:.2g})."
            for name, (probability, meaning) in tests.items() if probability < _DOUBTFUL
        ]  # fmt: skip
        return Check({name: probability for name, (probability, _) in tests.items()}, tuple(said))

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence for each reason to doubt a number."""
        said = [self._likelihood.at_bound(name, end, self.values[name]) for name, end in self.at_bounds.items()]
        for own in self.not_told_apart:
            said.append(
                f"The data do not tell {listed(own.names)} apart: the correlation of their errors is "
                f"{own.correlation:.3f}. Fix one of them, or add data of another kind."
            )
        told = {name for own in self.not_told_apart for name in own.names}
        said += [
            f"The data hardly tell {name} and the coefficient of its springpot apart: the error of {name} is "
            f"{self.errors[name]:.2g}, above {_LARGEST_OF_ORDER:g}."
            for name in self._vague_orders if name not in told and name not in self.at_bounds
        ]  # fmt: skip
        return (*said, *self.check().sentences, *self._likelihood.doubts(self._theta))

    def report(self, warnings: bool = True) -> str:
        """All of it in words.

        Parameters
        ----------
        warnings : bool
            With the warnings at its end.

        Returns
        -------
        str

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
        >>> print(sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts).report())
        fit of 1 number to 4 impacts
        r               0.701042 +- 0.0045     95 % interval 0.686769 to 0.71561
        relative_error  0.0129 (estimated)
        BIC -18.29
        """
        kind = {
            "moduli": "moduli", "relaxation": "relaxation moduli", "creep": "compliances",
            "spectrum": "points of a spectrum", "record": "samples", "impacts": "impacts",
            "frequencyresponse": "magnitudes and phases", "statistics": "statistics", "tuple": "statistics",
        }  # fmt: skip
        count = len(self.values)
        lines = [
            f"fit of {count} number{'s' if count != 1 else ''} to {self._likelihood.size} "
            f"{kind.get(type(self.data).__name__.lower().removeprefix('measured'), 'data')}"
        ]
        intervals = self.intervals
        wide = max(len(name) for name in (*self.values, *self.extras)) + 2
        for name, value in self.values.items():
            (low, high), held = intervals[name], name in self.at_bounds
            number = f"{value:.6g} (held at its bound)" if held else f"{value:.6g} +- {self.errors[name]:.2g}"
            if name in self._profiled or not held:
                how = " (profile)" if name in self._profiled else ""
                number = f"{number:22} 95 % interval {low:.6g} to {high:.6g}{how}"
            lines.append(f"{name:{wide}}{number}")
        lines += [f"{name:{wide}}{value:.3g} (estimated)" for name, value in self.extras.items()]
        lines += self.known_together
        lines.append(f"BIC {self.bic:.2f}")
        lines += [f"{choice.label}: BIC {choice.bic:.2f} with {choice.numbers} numbers" for choice in self.choices]
        return "\n".join([*lines, *(self.warnings if warnings else ())])

    def to_dict(self) -> dict[str, Any]:
        """The numbers as plain values; NaN is None.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
        >>> round(sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts).to_dict()["values"]["r"], 3)
        0.701
        """

        names = "values", "errors", "at_bounds", "known_together", "extras", "deviance", "bic", "aicc", "warnings"
        more = {
            "intervals": self.intervals,
            "not_told_apart": self.not_told_apart,
            "correlations": self.correlations,
            "choices": self.choices,
            "check": self.check().probabilities,
        }
        return plain({name: getattr(self, name) for name in names} | more)

    def to_xarray(self) -> xarray.Dataset:
        """An xarray Dataset: values and errors over ``parameter``, data and fit over ``point``.

        Examples
        --------
        >>> import springpot as sp
        >>> impacts = sp.MeasuredImpacts([1.0, 2.0, 3.0, 4.0], [0.71, 1.38, 2.12, 2.79])
        >>> dict(sp.fit(sp.Barrier(0.0, sp.free("r", 0.5, (0.1, 1.0))), impacts).to_xarray().sizes)
        {'parameter': 1, 'parameter_2': 1, 'point': 4}
        """
        need("files", "to_xarray()")
        import xarray

        names, own = [*self.values], self.table
        spread = {} if own.error is None else {"data_error": ("point", own.error)}
        return xarray.Dataset(
            {
                **spread,
                "value": ("parameter", [*self.values.values()]),
                "error": ("parameter", [*self.errors.values()]),
                "correlation": (("parameter", "parameter_2"), self.correlations),
                "data": ("point", own.data),
                "fitted": ("point", own.fitted),
                "residual": ("point", own.residual),
            },
            {
                "parameter": names,
                "parameter_2": names,
                own.axis: ("point", own.at, {"units": own.unit}),
                "group": ("point", own.group),
            },
            {"deviance": self.deviance, "bic": self.bic, "aicc": self.aicc, "warnings": [*self.warnings]},
        )

    @property
    def _coordinates(self) -> Coordinates:
        return self._likelihood.coordinates

    @property
    def _inner_covariance(self) -> Floats:
        """Of the coordinates."""
        slope = self._coordinates.slope(self._theta)
        return np.asarray(self.covariance / np.outer(slope, slope))

    @cached_property
    def _covariance_of_all(self) -> Floats:
        """Of the coordinates, all of them free: beside a number held at a bound it is larger than `errors` say."""
        return self._likelihood.covariance(self._theta, np.ones(self._best.u.size, bool))

    @property
    def _level(self) -> float:
        """By how much -2 ln L rises at the ends of an interval of 95 %."""
        from scipy import stats

        free = max(self.degrees_of_freedom, 1)
        return float(stats.chi2.ppf(0.95, 1) if self._likelihood.known else stats.t.ppf(0.975, free) ** 2)

    def _outer(self, place: int, u: float) -> float:
        """A number from its coordinate."""
        return float(self._coordinates.outer(np.where(np.arange(self._best.u.size) == place, u, self._best.u))[place])

    @property
    def _theta(self) -> Floats:
        """The numbers as the likelihood has them."""
        return self._coordinates.outer(self._best.u)

    def _place(self, name: str) -> int:
        return [*self.values].index(known_word(name, self.values, "name"))


def _orders(model: Any) -> set[str]:
    """The free numbers that are orders of springpots."""
    models = [] if callable(model) else model if isinstance(model, tuple) else [model]
    named = (item for each in models for item in numbers_of(system_of(each, "model")).items())
    return {value.name for name, value in named if isinstance(value, Free) and name.endswith(".order")}


def _crossings(u: Floats, rise: Floats, level: float, best: float) -> tuple[float, float]:
    """Where the profile reaches a level, on each side of its minimum; the end where it does not."""
    ends = []
    for side in (u <= best, u >= best):
        at, up = u[side], np.sqrt(np.maximum(rise[side], 0.0))
        order = np.argsort(np.abs(at - best))
        at, up = at[order], up[order]
        over = np.flatnonzero(up > level**0.5)
        if not over.size or over[0] == 0:
            ends.append(float(at[-1]))
            continue
        n = int(over[0])
        share = (level**0.5 - up[n - 1]) / (up[n] - up[n - 1]) if np.isfinite(up[n]) else 1.0
        ends.append(float(at[n - 1] + share * (at[n] - at[n - 1])))
    return ends[0], ends[1]
