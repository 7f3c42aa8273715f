"""What every kind of data answers: how well numbers agree with it, and how well it determines them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.machine.faults import Stopped, listed
from springpot.problem.free_numbers import free_numbers, restarted
from springpot.problem.system import System


@dataclass(frozen=True)
class How:
    """How a fit is computed: see `springpot.fit`."""

    seed: int = 1
    paths: int | None = None
    threads: int | None = None
    progress: Callable[[float], None] | None = None
    stop: Callable[[], bool] | None = None


USUAL = How()


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Free numbers as the search sees them: logarithms where only positive numbers are allowed.

    Parameters
    ----------
    free : tuple of Free

    Examples
    --------
    >>> own = Coordinates((Free(1.0, "C", 0.1, 10.0), Free(0.0, "b", -1.0, 1.0)))
    >>> own.inner(own.outer(np.array([0.5, 0.25]))).tolist()
    [0.5, 0.25]
    """

    free: tuple[Free, ...]

    @classmethod
    def of(cls, model: Any) -> Coordinates:
        """Those of a model, or of several."""
        return cls(tuple(free_numbers(model).values()))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers."""
        return tuple(number.name for number in self.free)

    @property
    def given(self) -> Floats:
        """The numbers from which a search starts."""
        return np.array([float(number) for number in self.free])

    @property
    def logarithmic(self) -> NDArray[np.bool_]:
        """Whether each is searched by its logarithm."""
        return np.array([number.low > 0.0 for number in self.free])

    @property
    def low(self) -> Floats:
        """Inner coordinates of the lower bounds."""
        return self.inner(np.array([number.low for number in self.free]))

    @property
    def high(self) -> Floats:
        """Inner coordinates of the upper bounds."""
        return self.inner(np.array([number.high for number in self.free]))

    @property
    def start(self) -> Floats:
        """Inner coordinates of the starts."""
        return self.inner(self.given)

    def inner(self, theta: Floats) -> Floats:
        """Numbers to coordinates."""
        log = self.logarithmic
        return np.where(log, np.log(np.where(log, theta, 1.0)), theta)

    def outer(self, u: Floats) -> Floats:
        """Coordinates to numbers, which are within their bounds."""
        log = self.logarithmic
        found = np.where(log, np.exp(np.where(log, u, 0.0)), u)
        return np.clip(found, [number.low for number in self.free], [number.high for number in self.free])

    def slope(self, theta: Floats) -> Floats:
        """Derivative of each number by its coordinate."""
        return np.where(self.logarithmic, theta, 1.0)

    def relative(self, theta: Floats, errors: Floats) -> Floats:
        """Errors of the coordinates relative to the numbers; of numbers of either sign, to a tenth of their range."""
        reach = np.array([0.1 * (number.high - number.low) for number in self.free])
        return np.where(self.logarithmic, errors, errors / np.maximum(np.abs(theta), reach))

    def named(self, theta: Floats) -> dict[str, float]:
        """Numbers by name."""
        return dict(zip(self.names, map(float, theta), strict=True))

    def named_at(self, u: Floats) -> dict[str, float]:
        """Numbers by name, from their coordinates."""
        return self.named(self.outer(u))

    def moved(self, theta: Floats) -> Coordinates:
        """Those of the same numbers, which start elsewhere.

        Examples
        --------
        >>> Coordinates((Free(1.0, "C", 0.1, 10.0),)).moved(np.array([20.0])).free
        (free('C', 10.0, (0.1, 10.0)),)
        """
        within = np.clip(theta, [number.low for number in self.free], [number.high for number in self.free])
        pairs = zip(self.free, within.tolist(), strict=True)
        return Coordinates(tuple(Free(start, number.name, number.low, number.high) for number, start in pairs))


@dataclass(frozen=True, eq=False)
class Table:
    """Data beside the fit, point by point.

    Attributes
    ----------
    axis, unit : str
        Name and unit of the horizontal axis.
    at : ndarray, shape (n,)
    group : ndarray of str, shape (n,)
        What each point is of.
    data, fitted, residual : ndarray, shape (n,)
        Measured, fitted, and their difference in standard deviations.
    error : ndarray, shape (n,), optional
        Standard deviation of each difference.
    """

    axis: str
    unit: str
    at: Floats
    group: NDArray[np.str_]
    data: Floats
    fitted: Floats
    residual: Floats
    error: Floats | None = None

    @classmethod
    def of_record(cls, time: Floats, names: Sequence[str], data: Floats, fitted: Floats, residual: Floats) -> Table:
        """Of samples in rows, each of which has a name where there are several."""
        rows, samples = data.shape
        groups = np.repeat(names if rows > 1 else ["path"], samples)
        return cls("time", "s", np.tile(time, rows), groups, data.ravel(), fitted.ravel(), residual.ravel())


class Likelihood(ABC):
    """How well numbers agree with data.

    Parameters
    ----------
    system : System
        With free numbers.
    data : one of the ``Measured...`` classes
    how : How

    Attributes
    ----------
    coordinates : Coordinates
    known : bool
        Whether the scatter of the data is known; if not, it is estimated from the residuals.
    stopped : bool
        Whether the search was stopped, as was asked.
    least : (float, ndarray) or None
        The least deviance so far and its numbers.
    """

    known: bool = True
    smooth_start: bool = False  # whether one start is enough
    stopped: bool = False
    least: tuple[float, Floats] | None = None
    ended: bool = False  # whether the search is over: what follows are profiles
    is_local: bool = False  # whether it knows the model near its solution alone
    simulated: bool = False  # whether it has checked by itself that every number has an influence

    def __init__(self, system: System, data: Any, how: How = USUAL) -> None:
        self.system, self.data, self.how = system, data, how
        self.stop = how.stop  # tells whether to end with the best numbers so far
        self.coordinates = Coordinates.of(system)

    @property
    def size(self) -> int:
        """Number of data."""
        return int(self.data.size)

    @abstractmethod
    def misfit(self, theta: Floats) -> float:
        """-2 ln L, up to a constant; the sum of squares where the scatter is not known."""

    @abstractmethod
    def solve(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Coordinates of the minimum, where only some of them move."""

    @abstractmethod
    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Of the coordinates that move; infinite where the data do not determine them."""

    @abstractmethod
    def table(self, theta: Floats) -> Table:
        """Data, fit and residuals."""

    def deviance(self, theta: Floats) -> float:
        """The same at a place of the search, which may be stopped there, and remembers the best."""
        self.ask()
        found = self.misfit(theta)
        self.note(found, theta)
        return found

    def restarted(self, theta: Floats) -> System:
        """The model, whose free numbers start at these."""
        return restarted(self.system, self.coordinates.named(theta))

    def scatter(self, theta: Floats, moving: int) -> float:
        """Estimated variance of the residuals; 1 where it is known."""
        return 1.0

    def constant(self) -> float:
        """What completes -2 ln L, of the data alone."""
        return 0.0

    def whole(self, deviance: float) -> float:
        """-2 ln L with its constant; where the scatter is not known, of the one that agrees best."""
        n = self.size
        own = deviance if self.known else n * math.log(max(deviance, 1e-300) / n) + n
        return own + self.constant()

    def extras(self, theta: Floats) -> dict[str, float]:
        """Numbers that belong to the fit and are not free."""
        return {}

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """Probability of so large a misfit by chance, for each test, and what a small one means."""
        return {}

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """One sentence for each reason to doubt the numbers that lies in how the fit was made."""
        return ("The fit was stopped: these are the best numbers so far.",) if self.stopped else ()

    def without_influence(self, theta: Floats, moves: NDArray[np.bool_]) -> str:
        """One sentence about numbers that change nothing where the search has ended; empty if there are none."""
        return ""

    def ask(self) -> None:
        """Ask whether to go on with the search.

        Raises
        ------
        Stopped
            If not.
        """
        if self.stop is not None and self.stop():
            self.stop, self.stopped = None, True
            raise Stopped("the fit was stopped before it had found anything.")

    def note(self, deviance: float, theta: Floats) -> None:
        """Keep these numbers if they are the best so far."""
        if self.least is None or deviance < self.least[0]:
            self.least = deviance, theta.copy()

    def lost(self, u: Floats, deviance: float) -> NDArray[np.bool_]:
        """Which numbers the data may not find: they are held at their lower bound if the data agree as well there."""
        return np.zeros(u.size, bool)

    def at_bound(self, name: str, end: str, value: float) -> str:
        """One sentence about a number that is held."""
        return (
            f"{name} is held at its {'lower' if end == 'low' else 'upper'} bound, {value:.6g}: it has no error, and "
            "the errors of the others hold for this value of it."
        )


class LeastSquares(Likelihood):
    """A sum of squares of residuals that are independent and of equal variance: 1 where it is known."""

    @abstractmethod
    def residuals(self, theta: Floats) -> Floats:
        """Whose sum of squares is the deviance."""

    @abstractmethod
    def sensitivity(self, theta: Floats) -> Floats:
        """Derivatives of the expected data by the numbers, in standard deviations: shape (n, numbers)."""

    def jacobian(self, theta: Floats) -> Floats:
        """Derivatives of the residuals by the numbers."""
        return -self.sensitivity(theta)

    def spread(self, sensitivity: Floats) -> Floats:
        """Covariance for residuals of variance 1: the inverse of the expected information."""
        return inverse(sensitivity.T @ sensitivity)

    def pearson(self, theta: Floats) -> Floats:
        """Differences to the expected data in standard deviations."""
        return self.residuals(theta)

    def misfit(self, theta: Floats) -> float:
        """The sum of squares."""
        found = self.residuals(theta)
        return float(found @ found)

    def standardized(self, theta: Floats) -> Floats:
        """Differences to the expected data in standard deviations, which are estimated where they are not known."""
        return np.asarray(self.pearson(theta) / self.scatter(theta, len(self.coordinates.free)) ** 0.5)

    def scatter(self, theta: Floats, moving: int) -> float:
        """Mean square of the residuals, for the degrees of freedom that are left."""
        if self.known:
            return 1.0
        found = self.pearson(theta)
        return float(found @ found) / max(self.size - moving, 1)

    def extras(self, theta: Floats) -> dict[str, float]:
        """The relative error, where it was estimated."""
        return {} if self.known else {"relative_error": self.scatter(theta, len(self.coordinates.free)) ** 0.5}

    def limits(self) -> tuple[Floats, Floats]:
        """Coordinates between which the minimum is searched."""
        return self.coordinates.low, self.coordinates.high

    def solve(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """By the trust-region reflective method of `scipy.optimize.least_squares`."""
        from scipy.optimize import least_squares

        own = self.coordinates
        low, high = (ends[moves] for ends in self.limits())

        def full(part: Floats) -> Floats:
            return own.outer(replaced(begin, moves, part))

        def slope(part: Floats) -> Floats:
            theta = full(part)
            return np.asarray((self.jacobian(theta) * own.slope(theta))[:, moves])

        def residuals(part: Floats) -> Floats:
            self.ask()
            found = self.residuals(theta := full(part))
            self.note(float(found @ found), theta)
            return found

        inside = np.clip(begin[moves], low + 1e-9 * (high - low), high - 1e-9 * (high - low))
        found = least_squares(
            residuals, inside, slope, bounds=(low, high), x_scale="jac",
            xtol=1e-8, ftol=1e-10, gtol=1e-9, max_nfev=100,
        )  # fmt: skip
        return replaced(begin, moves, found.x)

    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """From the expected information."""
        own = (self.sensitivity(theta) * self.coordinates.slope(theta))[:, moves]
        return self.spread(own) * self.scatter(theta, int(moves.sum()))

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """The size of the residuals where their variance is known, and their order."""
        from scipy import stats

        residual, groups = self.pearson(theta), self.table(theta).group
        found = {}
        if self.known:
            chi, count = float(residual @ residual), self.size - moving
            meaning = "the model misses more than the stated errors explain"
            found["size of the residuals (chi-square)"] = (float(stats.chi2.sf(chi, max(count, 1))), meaning)
        ordered = [residual[groups == group] for group in np.unique(groups)]
        long = [part / np.sqrt(np.mean(part**2)) for part in ordered if part.size > 5]
        if long:
            total = sum(float(part[1:] @ part[:-1]) for part in long) + 0.5 * moving
            z = total / np.sqrt(sum(part.size - 1 for part in long))
            meaning = "neighbouring residuals have the same sign: the model has the wrong shape"
            found["order of the residuals (neighbours)"] = (float(stats.norm.sf(z)), meaning)
        return found


class GammaSquares(LeastSquares):
    """Data that scatter with a variance proportional to the square of what is expected: the gamma quasi-likelihood.

    Attributes
    ----------
    values : ndarray, shape (n,)
        The data.
    certainty : float
        One over their relative error; 1 where it is not known.
    axis : (str, str)
        Name and unit of what they are measured against.
    at : ndarray, shape (n,)
        Their places on it.
    group : ndarray of str, shape (n,)
    """

    axis: tuple[str, str] = ("frequency_hz", "Hz")
    values: Floats
    certainty: float = 1.0
    at: Floats
    group: NDArray[np.str_]

    @abstractmethod
    def expected(self, theta: Floats) -> Floats:
        """What the data are expected to be."""

    def residuals(self, theta: Floats) -> Floats:
        """Signed roots of the deviance."""
        return self.certainty * gamma_residuals(self.values / self.expected(theta))

    def jacobian(self, theta: Floats) -> Floats:
        """Of the residuals."""
        return np.asarray(gamma_slope(self.values / self.expected(theta))[:, None] * self.sensitivity(theta))

    def pearson(self, theta: Floats) -> Floats:
        """Relative differences, in standard deviations."""
        return np.asarray(self.certainty * (self.values / self.expected(theta) - 1.0))

    def constant(self) -> float:
        """The logarithms of the data."""
        return float(2.0 * np.log(self.values / self.certainty).sum() + self.size * np.log(2.0 * np.pi))

    def table(self, theta: Floats) -> Table:
        """Data in their order."""
        return Table(*self.axis, self.at, self.group, self.values, self.expected(theta), self.standardized(theta))


def refuse_idle(idle: Sequence[str], why: str) -> None:
    """No number may be free that changes nothing; ``why`` completes the sentence.

    Raises
    ------
    ValueError
        If one is.
    """
    if idle:
        raise ValueError(f"{listed(idle)} must not be free: {why}.")


def replaced(numbers: Floats, which: NDArray[np.bool_], part: Floats) -> Floats:
    """The same numbers with others in some places."""
    found = numbers.copy()
    found[which] = part
    return found


def inverse(information: Floats) -> Floats:
    """The inverse of an information matrix, scaled; infinite variances where it is singular.

    Examples
    --------
    >>> inverse(np.diag([4.0, 0.5])).round(9).tolist()
    [[0.25, 0.0], [0.0, 2.0]]
    """
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(size, size))
    values = np.maximum(values, 1e-13)
    return np.asarray((vectors / values) @ vectors.T / np.outer(size, size))


def slopes(function: Callable[[Floats], Floats], theta: Floats, free: tuple[Free, ...]) -> Floats:
    """Derivatives by central differences, within the bounds: shape (n, numbers).

    Examples
    --------
    >>> free = (Free(2.0, "a", 0.0, 10.0),)
    >>> slopes(lambda t: t**2, np.array([3.0]), free).round(8).tolist()
    [[6.0]]
    """
    columns: list[Any] = []
    for place, number in enumerate(free):
        step = 1e-5 * max(abs(theta[place]), 1e-3 * (number.high - number.low))
        ends = []
        for sign in (1.0, -1.0):
            moved = theta.copy()
            moved[place] = min(max(theta[place] + sign * step, number.low), number.high)
            ends.append((moved[place], function(moved)))
        columns.append((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
    return np.stack(columns, axis=-1)


def gamma_residuals(ratio: Floats) -> Floats:
    """Signed roots of the deviance of gamma distributed data of unit shape: data over expectation.

    Their sum of squares is least where the likelihood is greatest.

    Examples
    --------
    >>> gamma_residuals(np.array([1.0, 1.01, 2.0])).round(5).tolist()
    [0.0, 0.00997, 0.78339]
    """
    z = ratio - 1.0
    near = np.abs(z) < 1e-4
    half = np.where(near, z * z * (0.5 - z / 3.0 + z * z / 4.0), z - np.log1p(np.where(near, 0.0, z)))
    return np.asarray(np.sign(z) * np.sqrt(2.0 * np.maximum(half, 0.0)))


def gamma_slope(ratio: Floats) -> Floats:
    """Derivative of `gamma_residuals` by the logarithm of the expectation.

    Examples
    --------
    >>> gamma_slope(np.array([1.0, 2.0])).round(4).tolist()
    [-1.0, -1.2765]
    """
    z, d = ratio - 1.0, gamma_residuals(ratio)
    near = np.abs(z) < 1e-6
    return np.asarray(-np.where(near, 1.0 + z / 3.0, z / np.where(near, 1.0, d)))
