"""Diffusion of an action or energy in one dimension: a conservative finite-volume operator, its modes, first passage.

The probability per action J obeys  dp/dt = d/dJ [D f d/dJ (p / f)]  with the stationary density f and diffusion D: no
flux at rest or far away.  Cells hold the masses m_i of f; neighbours exchange probability through conductances g,

    dP_i/dt = g_{i-1/2} (P_{i-1}/m_{i-1} - P_i/m_i) + g_{i+1/2} (P_{i+1}/m_{i+1} - P_i/m_i),

so probability is conserved, stays positive and settles on m, all to rounding.  In the variables P_i / sqrt(m_i) the
operator is B^T B with a bidiagonal B, a row for each conductance: the squares of its singular values are the rates, and
the right singular vectors the modes, which give the solution at every time.  Cells near rest, or near grazing, exchange
probability up to 1e15 times as fast as the slowest mode decays; eigenvalues of the product would lose that mode in
rounding errors, but singular values of B give every rate to many digits (J. Demmel and W. Kahan, "Accurate singular
values of bidiagonal matrices", SIAM J. Sci. Stat. Comput. 11, 1990).  The conductances integrate 1 / (D f) between
cells with D f / J exponential in ln J (as Scharfetter and Gummel), which is exact where D is proportional to J, as near
rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import linalg

from springpot.machine.arrays import Floats
from springpot.theory.distributions import times

_ABOUT, _FINE = 3.0, 0.06  # of a level that is looked at: change of -ln of the density, and in one cell
_REST = 1e-8  # stationary probability of the cells near rest that are left out: their fast rates spoil the slow ones


@dataclass(frozen=True)
class FirstPassage:
    """When a level is first reached from rest.

    Parameters
    ----------
    mean_time : float
        In s.
    rates, weights : ndarray
        The survival probability is sum of weights e^(-rates t), rates in 1/s.
    """

    mean_time: float
    rates: Floats
    weights: Floats

    def survival(self, time: float | Floats) -> Floats:
        """Probability that the level has not been reached yet.

        Parameters
        ----------
        time : array_like
            t >= 0 in s.

        Raises
        ------
        TypeError
            If a time is not a number.
        ValueError
            If a time is negative or NaN.

        Examples
        --------
        >>> passage = FirstPassage(mean_time=2.0, rates=np.array([0.5]), weights=np.array([1.0]))
        >>> float(passage.survival(2.0).round(4))
        0.3679
        """
        decay = np.exp(-np.multiply.outer(np.minimum(times(time, "time"), 800.0 / self.rates.min()), self.rates))
        return np.asarray(np.clip(decay @ self.weights, 0.0, 1.0))


@dataclass(frozen=True)
class EnergyDiffusion:
    """The operator, on cells of the action.

    Parameters
    ----------
    action : ndarray
        J of the cells, rising.
    mass : ndarray
        Stationary probabilities of the cells, positive, with sum 1.
    strength : ndarray
        D f / J at the cells, with which the conductances are made.
    """

    action: Floats
    mass: Floats
    strength: Floats

    @cached_property
    def conductance(self) -> Floats:
        """Between neighbouring cells, in 1/s."""
        return _conductance(self.action[:-1], self.action[1:], self.strength[:-1], self.strength[1:])

    @cached_property
    def modes(self) -> tuple[Floats, Floats]:
        """Rates (the first is 0, the stationary state) and orthonormal modes in the symmetric variables."""
        rates, vectors = self._spectrum(self.action.size, 0.0)
        rates[0] = 0.0
        vectors[:, 0] = np.sqrt(self.mass)
        return rates, vectors

    def spectrum(self, values: Floats) -> tuple[Floats, Floats]:
        """Rates of the modes, and the squares of the fluctuation's components: the variance, mode by mode.

        From eigenvalues of the product, in half the time of `modes`; accurate enough for sums over all modes.

        Parameters
        ----------
        values : ndarray
            A quantity on the cells.

        Examples
        --------
        >>> cells = make_energy_diffusion(np.array([1.0, 2.0]), np.array([0.5, 0.5]), np.array([1.0, 1.0]))
        >>> rates, squares = cells.spectrum(np.array([-1.0, 1.0]))
        >>> float(squares.sum().round(12))
        1.0
        """
        root, flow = np.sqrt(self.mass), self.conductance
        diagonal = (np.r_[0.0, flow] + np.r_[flow, 0.0]) / self.mass
        rates, vectors = linalg.eigh_tridiagonal(diagonal, -flow / (root[1:] * root[:-1]))
        components = vectors.T @ (root * (values - self.mass @ values))
        return np.maximum(rates[1:], 0.0), np.asarray(components[1:] ** 2)

    def from_rest(self, time: Floats) -> Floats:
        """Probabilities of the cells at these times after a start in the lowest cell.

        Parameters
        ----------
        time : ndarray, shape (n,)
            t >= 0; infinity is the stationary state.

        Returns
        -------
        ndarray, shape (n, cells)
            Rows with sum 1.
        """
        rates, vectors = self.modes
        root = np.sqrt(self.mass)
        decay = np.exp(-np.multiply.outer(np.minimum(time, 1e3 / rates[1]), rates[1:]))
        start = vectors[0, 1:] / root[0]
        probability = np.maximum(self.mass + (decay * start) @ vectors[:, 1:].T * root, 0.0)
        return np.asarray(probability / probability.sum(axis=1, keepdims=True))

    def first_passage(self, level: float) -> FirstPassage:
        """When the action first reaches a level from rest.

        Parameters
        ----------
        level : float
            Between the lowest and the highest cell.

        Raises
        ------
        ValueError
            If the level is outside the cells.
        """
        inside = int(np.searchsorted(self.action, level))
        if not 0 < inside < self.action.size:
            raise ValueError("the level must lie between rest and the far end of the stationary law.")
        strength = math.exp(float(np.interp(math.log(level), np.log(self.action), np.log(self.strength))))
        last = inside - 1
        escape = float(
            _conductance(
                self.action[last : last + 1], np.array([level]), self.strength[last : last + 1], np.array([strength])
            )[0]
        )
        # mean time = sum over the cells of (mass below) / (conductance above): all terms positive, so no cancellation
        above = np.r_[self.conductance[:last], escape]
        mean_time = float(np.sum(np.cumsum(self.mass[:inside]) / above))
        rates, vectors = self._spectrum(inside, escape)
        root = np.sqrt(self.mass[:inside])
        weights = vectors[0] / root[0] * (root @ vectors)
        return FirstPassage(mean_time, np.maximum(rates, 0.0), weights)

    def first_passage_seen(self, level: float, every: float) -> FirstPassage:
        """When the action is first seen at a level or above, looked at in equal intervals after a start at rest.

        Between two looks it may pass the level and come back.  Where it changes little between looks this is the first
        passage of a somewhat higher level; where it changes much, each look is a chance of its own.

        Parameters
        ----------
        level : float
            Between the lowest and the highest cell.
        every : float
            Time between looks.

        Raises
        ------
        ValueError
            If the level is outside the cells.
        """
        if not self.action[0] < level < self.action[-2]:
            raise ValueError("the level must lie between rest and the far end of the stationary law.")
        return self._finer_about(level)._seen(level, every)

    def _finer_about(self, level: float) -> EnergyDiffusion:
        """The same law with narrow cells about a level, between which its density changes little."""
        action, edges = self.action, _edges(self.action)
        logarithm = np.log(self.mass / np.diff(edges))
        fall = np.minimum.accumulate(-logarithm[::-1])[::-1]  # rising but for the first cells
        here = float(np.interp(level, action, fall))
        first, last = np.interp([here - _ABOUT, here + _ABOUT], fall, action)
        wanted = np.interp(np.arange(here - _ABOUT, here + _ABOUT, _FINE), fall, action)
        inside = np.unique(wanted[(wanted > max(first, action[0])) & (wanted < min(last, action[-1]))])
        if inside.size < 2:
            return self
        apart = 0.5 * (inside[1] - inside[0]), 0.5 * (inside[-1] - inside[-2])
        finer = np.r_[action[action < inside[0] - apart[0]], inside, action[action > inside[-1] + apart[1]]]
        mass = np.exp(np.interp(finer, action, logarithm)) * np.diff(_edges(finer))
        strength = np.exp(np.interp(np.log(finer), np.log(action), np.log(self.strength)))
        return EnergyDiffusion(finer, mass / mass.sum(), strength / mass.sum())

    def _seen(self, level: float, every: float) -> FirstPassage:
        """As `first_passage_seen`, on these cells."""
        between = _edges(self.action)[1:-1]
        above = min(max(int(np.searchsorted(between, level)), 1), between.size - 1)
        rates, vectors = self.modes
        step = (vectors * np.exp(-rates * every)) @ vectors.T
        low, high = (self._mean_time_inside(step, inside) for inside in (above, above + 1))
        part = (level - between[above - 1]) / (between[above] - between[above - 1])
        mean_time = every * low ** (1.0 - part) * high**part
        root = np.sqrt(self.mass[:above])
        kept, shapes = linalg.eigh(step[:above, :above])
        found = -np.log(np.clip(kept[::-1], 1e-300, 1.0 - 1e-15)) / every
        weights = (shapes[0] / root[0] * (root @ shapes))[::-1]
        slow = (mean_time - float(np.sum(weights[1:] / found[1:]))) / weights[0]
        return FirstPassage(mean_time, np.r_[1.0 / slow if slow > 0.0 else found[0], found[1:]], weights)

    def _mean_time_inside(self, step: Floats, inside: int) -> float:
        """Mean number of steps from rest until a cell beyond the first so many is seen.

        By elimination without a subtraction (W. K. Grassmann, M. I. Taksar and D. P. Heyman, Operations Research 33,
        1985), so that the rarest passage has all its digits.
        """
        root = np.sqrt(self.mass)
        moved = np.maximum(step[:inside] * root / root[:inside, None], 0.0)
        kept, left, steps = moved[:, :inside].copy(), moved[:, inside:].sum(axis=1), np.ones(inside)
        for k in range(inside - 1, 0, -1):
            share = kept[:k, k] / (left[k] + kept[k, :k].sum())
            kept[:k, :k] += np.multiply.outer(share, kept[k, :k])
            left[:k] += share * left[k]
            steps[:k] += share * steps[k]
        return float(steps[0] / left[0])

    def _spectrum(self, cells: int, escape: float) -> tuple[Floats, Floats]:
        """Rates, rising, and modes of the lowest cells; ``escape`` is the conductance at the upper end."""
        root = np.sqrt(self.mass[:cells])
        flow = np.sqrt(np.r_[self.conductance[: cells - 1], escape])
        bidiagonal = np.diag(flow / root) - np.diag(flow[:-1] / root[1:], 1)
        # this driver keeps a bidiagonal matrix as it is, and small singular values are relatively accurate
        _, values, modes = linalg.svd(bidiagonal, lapack_driver="gesvd", check_finite=False)
        return np.asarray(values[::-1] ** 2), np.asarray(modes[::-1].T)


def make_energy_diffusion(action: Floats, mass: Floats, strength: Floats) -> EnergyDiffusion:
    """Check and normalize the cells, without those of negligible mass and those near rest.

    Parameters
    ----------
    action, mass, strength : ndarray
        As in `EnergyDiffusion`; the masses need not have sum 1, ``strength`` is scaled with them.

    Raises
    ------
    ValueError
        If the actions do not rise from above 0, or a mass or strength is negative.

    Examples
    --------
    >>> cells = make_energy_diffusion(np.array([1.0, 2.0, 4.0]), np.array([2.0, 1.0, 1.0]), np.ones(3))
    >>> cells.mass
    array([0.5 , 0.25, 0.25])
    """
    if np.any(np.diff(action) <= 0.0) or action[0] <= 0.0 or np.any(mass < 0.0) or np.any(strength < 0.0):
        raise ValueError("action must be positive and increasing, and mass and strength must not be negative.")
    total = float(mass.sum())
    kept = (mass > 1e-30 * total) & (strength > 0.0) & (np.cumsum(mass) > _REST * total)
    share = mass[kept] / mass[kept].sum()
    return EnergyDiffusion(action[kept], share, strength[kept] / total)


def _edges(action: Floats) -> Floats:
    """Of the cells, halfway in the root of the action; the first and last are as wide inwards as outwards."""
    root = np.sqrt(action)
    middle = 0.5 * (root[1:] + root[:-1])
    return np.asarray(np.r_[max(2.0 * root[0] - middle[0], 0.0), middle, 2.0 * root[-1] - middle[-1]] ** 2)


def _conductance(low: Floats, high: Floats, at_low: Floats, at_high: Floats) -> Floats:
    """1 / int dJ / (D f), with D f / J exponential in ln J."""
    tilt = np.log(at_high / at_low)
    # int_0^1 e^(-tilt s) ds / at_low
    resistance = np.where(np.abs(tilt) < 1e-9, 1.0 - tilt / 2.0, -np.expm1(-tilt) / np.where(tilt == 0.0, 1.0, tilt))
    return np.asarray(at_low / (np.log(high / low) * resistance))
