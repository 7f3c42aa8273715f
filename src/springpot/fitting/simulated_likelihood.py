"""Simulated moments: how well measured statistics agree with a surface through simulated ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.designing.surfaces import Surface
from springpot.fitting.likelihood import Coordinates, LeastSquares, Table, inverse
from springpot.fitting.simulated_moments import Case
from springpot.fitting.simulated_runs import MOST_SHARE
from springpot.fitting.statistics import MeasuredStatistics
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed
from springpot.problem.free_numbers import with_values
from springpot.problem.system import System
from springpot.simulation.estimate.step_biases import impact_biases
from springpot.simulation.plan.motions import motion_of

_MOST_BLUR = 0.8  # of the information that is seen in a direction: where the errors are no longer corrected for it


@dataclass(frozen=True, eq=False)
class StackedStatistics:
    """The statistics of all models in one row.

    Attributes
    ----------
    names : tuple of str
        With the number of the data set where there are several.
    values : ndarray, shape (n,)
    covariance : ndarray, shape (n, n)
    """

    names: tuple[str, ...]
    values: Floats
    covariance: Floats

    @property
    def size(self) -> int:
        """Number of statistics."""
        return int(self.values.size)

    @classmethod
    def of(cls, data: Sequence[MeasuredStatistics]) -> StackedStatistics:
        """Several sets, one after the other; names then begin with the number of the set."""
        from scipy.linalg import block_diag

        numbered = [f"{place}: {name}" for place, own in enumerate(data, start=1) for name in own.names]
        return cls(
            data[0].names if len(data) == 1 else tuple(numbered),
            np.concatenate([own.values for own in data]),
            np.asarray(block_diag(*(own.covariance for own in data))),
        )


class MomentsLikelihood(LeastSquares):
    """Measured statistics beside a surface through simulated ones.

    Parameters
    ----------
    coordinates : Coordinates
    measured : StackedStatistics
    surface : Surface
    far : float
        As far as the surface is used, in units of its region.
    at : ndarray, optional
        Where the weights are taken; the centre of the surface if not given.
    last : bool
        Whether what the surface leaves of the runs counts as an error too; of a plane that only leads there it does
        not.
    cases : sequence of Case
        For what is said of the step.
    said : tuple of str
        Of the search that led here.

    Notes
    -----
    D. McFadden, "A method of simulated moments for estimation of discrete response models without numerical
    integration", Econometrica 57 (1989).  The weights are the inverse of the measured covariance plus that of the
    surface: of its runs, which is found from the samples path by path, so that common random numbers are taken into
    account, and what it leaves of them beyond that.
    """

    known = True
    smooth_start = True
    simulated = is_local = True

    def __init__(
        self,
        coordinates: Coordinates,
        measured: StackedStatistics,
        surface: Surface,
        far: float,
        at: Floats | None = None,
        cases: Sequence[Case] = (),
        said: tuple[str, ...] = (),
        last: bool = False,
    ) -> None:
        self.coordinates, self.data, self.surface, self._far = coordinates, measured, surface, far
        self.stop, n = None, measured.size
        self._cases, self._warnings = cases, said
        at = surface.centre if at is None else at
        self._runs = surface.covariance(at)[:n, :n]
        self._simulated = self._runs + (np.diag(self._misfit(at) ** 2) if last else 0.0)
        whole = measured.covariance + self._simulated
        self._spread = np.sqrt(np.diag(whole))
        self._root, self._root_of_data = (np.linalg.inv(np.linalg.cholesky(c)) for c in (whole, measured.covariance))

    # -- for the search, at coordinates ---------------------------------------------------------------------------

    def minimum(self, u: Floats) -> Floats:
        """The best numbers on the surface."""
        every = np.ones(u.size, bool)
        return self.solve(self.solve(u, every), every)

    def errors_at(self, u: Floats) -> Floats:
        """Standard errors of the coordinates."""
        return np.sqrt(np.diag(self.covariance(self.coordinates.outer(u), np.ones(u.size, bool))))

    def chi_square(self, u: Floats) -> float:
        """The sum of squares, with what the surface leaves of the runs among the errors."""
        left = self.data.values - self.surface(u)[: self.size]
        whole = self.data.covariance + self._runs + np.diag(self._misfit(u) ** 2)
        return float(left @ np.linalg.solve(whole, left))

    def wrong(self, u: Floats) -> float:
        """How far runs are off the surface, in errors: of the statistic that has it worst."""
        return float((self._misfit(u) / np.sqrt(np.diag(self.data.covariance + self._runs))).max())

    def added(self, u: Floats) -> Floats:
        """By how much the simulation enlarges the error of each number, relative to the error from the data alone."""
        every = np.ones(u.size, bool)
        alone = self._covariance(u, every, self._root_of_data, simulated=False)
        return np.sqrt(np.diag(self._covariance(u, every, self._root)) / np.diag(alone)) - 1.0

    def _misfit(self, u: Floats) -> Floats:
        """How far runs are off the surface, in the units of the statistics."""
        n, surface = self.size, self.surface
        return np.asarray(surface.misfit[:n] * np.where(surface.logarithmic[:n], surface(u)[:n], 1.0))

    # -- what every likelihood answers ----------------------------------------------------------------------------

    def limits(self) -> tuple[Floats, Floats]:
        """As far as the surface is used."""
        own, surface = self.coordinates, self.surface
        reach = self._far * surface.reach
        return np.maximum(own.low, surface.centre - reach), np.minimum(own.high, surface.centre + reach)

    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """With the error of the slopes, which makes the information of the data look larger than it is.

        With slopes J + e and weights W the estimates solve (J + e)' W (...) = 0; the information is
        J' W J = (J + e)' W (J + e) - E[e' W e], and the covariance of the score is the first of these terms.
        """
        return self._covariance(self.coordinates.inner(theta), moves, self._root)

    def _covariance(self, u: Floats, moves: NDArray[np.bool_], root: Floats, *, simulated: bool = True) -> Floats:
        """With these weights; without what the error of the slopes adds, if they are not simulated."""
        own = (root @ self.surface.slope(u)[: self.size])[:, moves]
        errors = np.einsum("ij,gjk->gik", root, self.surface.slope_samples(u)[:, : self.size][..., moves])
        seen, excess = own.T @ own, np.einsum("gia,gib->ab", errors, errors)
        # in directions in which the data tell nothing, the excess may be all that is seen
        half = np.linalg.cholesky(inverse(seen))
        shares, turn = np.linalg.eigh(half.T @ excess @ half)
        left = 1.0 - np.minimum(shares, _MOST_BLUR)
        half = half @ turn / (left if simulated else np.sqrt(left))
        return np.asarray(half @ half.T)

    def _expected(self, theta: Floats) -> Floats:
        return self.surface(self.coordinates.inner(theta))[: self.size]

    def residuals(self, theta: Floats) -> Floats:
        """Differences, made independent with unit variance."""
        return np.asarray(self._root @ (self.data.values - self._expected(theta)))

    def sensitivity(self, theta: Floats) -> Floats:
        """Change of the expected statistics, as the residuals are."""
        slope = self.surface.slope(self.coordinates.inner(theta))[: self.size]
        return np.asarray(self._root @ (slope / self.coordinates.slope(theta)))

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """The J-test: the size of the residuals, where there are more statistics than numbers."""
        from scipy import stats

        spare = self.size - moving
        if spare < 1:
            return {}
        meaning = "the model misses more than the stated errors explain"
        return {"size of the residuals (J-test)": (float(stats.chi2.sf(self.deviance(theta), spare)), meaning)}

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """About the simulation: its errors, its step, and whether the search came to an end."""
        said = [*self._warnings]
        added = self.added(self.coordinates.inner(theta))
        if (most := float(added.max())) > MOST_SHARE:
            name = self.coordinates.names[int(added.argmax())]
            said.append(f"The simulation adds {100.0 * most:.0f} % to the error of {name}: give more paths.")
        measured = np.diag(self.data.covariance)
        large = np.diag(self._simulated) > measured
        if large.any():
            names = listed([name for name, own in zip(self.data.names, large, strict=True) if own])
            said.append(f"The simulation's error of {names} is larger than the measured one: give more paths.")
        expected, at, named = self._expected(theta), 0, self.coordinates.named(theta)
        for case in self._cases:
            own = dict(zip(case.data.names, expected[at : at + case.data.size].tolist(), strict=True))
            spread = dict(zip(case.data.names, self._spread[at : at + case.data.size].tolist(), strict=True))
            at += case.data.size
            values = _impacts(case.system, own) | own
            motion = motion_of(with_values(case.system, named))
            for name, bias in impact_biases(motion, case.settings.step, values).items():
                if name in own and bias > 0.3 * spread[name]:
                    said.append(
                        f"The step's bias of {name} may be {bias:.2g}, beside an error of {spread[name]:.2g}: "
                        "slow impacts on a lossy wall are missed."
                    )
        return tuple(said)

    def table(self, theta: Floats) -> Table:
        """Statistic by statistic."""
        expected, data = self._expected(theta), self.data.values
        return Table(
            "statistic", "1", np.arange(1.0, self.size + 1.0), np.array(self.data.names), data, expected,
            (data - expected) / self._spread, self._spread,
        )  # fmt: skip


def _impacts(system: System, own: Mapping[str, float]) -> dict[str, float]:
    """Rate and speeds of the impacts on all walls, and on each, as far as they follow from what was measured."""
    found = dict[str, float]()
    for before in ("", *(f"{wall}_" for wall in system.stops)):
        speed = own.get(f"{before}impact_speed_mean", 0.0)
        square = own.get(f"{before}impact_speed_mean_square", speed**2 * 4.0 / math.pi)  # as Rayleigh has it
        found |= {f"{before}impact_rate": 1.0, f"{before}impact_speed_mean": 1.0}
        found[f"{before}impact_speed_mean_square"] = square
    return found
