"""Exact answers: the dashpot with an elastic wall anywhere, the springpot without a wall, and what never settles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import real_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System
from springpot.theory.densities import DensitiesOfAmplitude
from springpot.theory.distributions import modulus_correlation, times
from springpot.theory.forms import form_of
from springpot.theory.methods.systems.boltzmann import ExactOfPoints, check_points_covered, exact_of_points
from springpot.theory.methods.systems.energy import ExactLaw, check_law_covered, exact_law
from springpot.theory.normals import Normals, hazard_of
from springpot.theory.numerics.contours import (
    dashpot_mean_squares,
    dashpot_motion,
    free_spectrum,
    relaxation,
)
from springpot.theory.problem import at_rest, free_mean_squares, paper_covered, problem_and_units
from springpot.theory.result import NEVER_STRUCK, Moments, NoStationaryStateError

_LONG = 1e300  # a time that stands for infinity without making phases NaN
_REACH = (
    "The exact answer covers any order without a wall, order 1 with an elastic wall at any position, and a springpot "
    "that dissipates nothing (order 0, or C = 0) with an elastic wall or none"
)


@dataclass(frozen=True)
class Exact(DensitiesOfAmplitude[Normals]):
    """The exact stationary state, and where it is known the way there from rest.

    Without a wall x and v are independent and normal.  With a dashpot and an elastic wall they are the same two
    normals, of equal energy, with x cut off at the wall.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`.
    """

    def x_mean_at(self, time: ArrayLike) -> Floats:
        """Mean displacement at a time from rest, in m.

        Parameters
        ----------
        time : array_like
            t >= 0 in s after a start with x = v = 0; infinity is the stationary state.

        Raises
        ------
        NotCoveredError
            If the wall is not at 0.
        NoStationaryStateError
            If a time is infinite and there is no stationary state.
        TypeError, ValueError
            If a time is negative, NaN or not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> float(exact(sp.Oscillator(springpot=sp.Springpot(1.0, 0.5))).x_mean_at(3.0).round(4))
        0.7143
        """
        side = self.paper.direction
        return np.asarray(side * np.sqrt(2.0 / math.pi * self.x_mean_square_at(time)))

    def x_mean_square_at(self, time: ArrayLike) -> Floats:
        """<x^2> at a time from rest, in m^2.

        Parameters and errors are those of `x_mean_at`.

        Examples
        --------
        >>> import springpot as sp
        >>> result = exact(sp.Oscillator(springpot=sp.Springpot(0.5, 1.0), barrier=None))
        >>> result.x_mean_square_at([1.0, 10.0]).round(4)
        array([0.1844, 0.5309])
        """
        return self._transient(time)[0] * self.paper.length_scale**2

    def v_mean_square_at(self, time: ArrayLike) -> Floats:
        """<v^2> at a time from rest, in m^2 s^-2.

        Parameters and errors are those of `x_mean_at`.

        Examples
        --------
        >>> import springpot as sp
        >>> float(exact(sp.Oscillator(springpot=sp.Springpot(1.0, 0.5))).v_mean_square_at(1.0).round(4))
        0.4848
        """
        return self._transient(time)[1] * self.paper.speed_scale**2

    def amplitude_mean_square_at(self, time: ArrayLike) -> Floats:
        """<A^2> with A^2 = x^2 + v^2 / Omega^2 at a time from rest, in m^2.

        Parameters and errors are those of `x_mean_at`.

        Examples
        --------
        >>> import springpot as sp
        >>> float(exact(sp.Oscillator(springpot=sp.Springpot(1.0, 0.0))).amplitude_mean_square_at(7.0).round(12))
        7.0
        """
        x, v = self._transient(time)
        return (x + v) * self.paper.length_scale**2

    def correlation(self, lag: ArrayLike) -> Floats:
        """<x(t) x(t + lag)> in the stationary state, in m^2: <x^2> at lag 0, the squared mean far away.

        Parameters
        ----------
        lag : array_like
            In s, of either sign.

        Raises
        ------
        NotCoveredError
            If there is a wall that is not at 0.
        NoStationaryStateError
            If there is no stationary state.
        TypeError, ValueError
            If a lag is NaN or not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> result = exact(sp.Oscillator(barrier=None))
        >>> result.correlation([0.0, 1.0, 10.0]).round(4)
        array([0.5321, 0.209 , 0.0175])
        """
        moments = self.moments
        t = np.minimum(times(lag, "lag", either_sign=True) * self.paper.natural_frequency, _LONG)
        if self.paper.barrier is not None and self.paper.barrier.position != 0.0:
            raise NotCoveredError("The exact correlation is known with a wall at 0 or without a wall.")
        alpha, c = self.paper.springpot.order, self.paper.dimensionless_coefficient
        if alpha < 1.0:
            return relaxation(alpha, c).correlation(t) * self.paper.length_scale**2
        free = np.clip(dashpot_motion(c, t)[2], -1.0, 1.0)
        if self.paper.barrier is not None:  # x = |y| with y normal
            free = modulus_correlation(free)
        return free * moments.x_mean_square

    def spectrum(self, frequency: ArrayLike) -> Floats:
        """Two-sided spectral density of x, in m^2 s per rad; its integral over the real line is <x^2>.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.

        Raises
        ------
        NotCoveredError
            If there is a wall.
        NoStationaryStateError
            If there is no stationary state.
        TypeError
            If a frequency is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> float(exact(sp.Oscillator(barrier=None)).spectrum(1.0).round(4))
        0.1592
        """
        if self.paper.barrier is not None:
            raise NotCoveredError("The exact spectrum is known without a wall only.")
        _ = self.moments
        w = np.minimum(np.abs(real_array(frequency, "frequency")) / self.paper.natural_frequency, 1e75)
        shape = free_spectrum(self.paper.springpot.order, self.paper.dimensionless_coefficient, w)
        return np.asarray(self.paper.length_scale**2 / self.paper.natural_frequency * shape)

    def _transient(self, time: ArrayLike) -> tuple[Floats, Floats]:
        """Dimensionless <x^2> and <v^2> without a wall: with an elastic wall at 0, x is the modulus of that x."""
        wall, t = self.paper.barrier, times(time, "time")
        if wall is not None and wall.position != 0.0:
            raise NotCoveredError("The exact motion from rest is known with an elastic wall at 0 or without a wall.")
        if np.any(np.isinf(t)) and isinstance(self.stationary, str):
            raise NoStationaryStateError(self.stationary)
        t = np.minimum(t * self.paper.natural_frequency, _LONG)
        alpha, c = self.paper.springpot.order, self.paper.dimensionless_coefficient
        if alpha == 1.0 or c == 0.0:
            return dashpot_mean_squares(c, t)
        if alpha == 0.0:
            frequency = math.sqrt(1.0 + c)
            x, v = dashpot_mean_squares(0.0, frequency * t)
            return x / frequency**3, v / frequency
        return relaxation(alpha, c).mean_squares(t)


@np.errstate(all="ignore")  # what is not finite is no answer
def exact(system: System) -> Exact | ExactLaw | ExactOfPoints:
    """Solve a system exactly, where that can be done.

    Parameters
    ----------
    system : System
        The paper's problem, a linear spring with one springpot or dashpot and white noise: without a wall; or of order
        1 with an elastic wall anywhere; or with a springpot that dissipates nothing (order 0, or C = 0) and an elastic
        wall or none, where there is no stationary state.  With other parts see
        `springpot.theory.methods.systems.energy.exact_law`, with several masses
        `springpot.theory.methods.systems.boltzmann.exact_of_points`.

    Returns
    -------
    Exact, ExactLaw or ExactOfPoints
        The first of the paper's problem, exact to about 1e-13 of the size of its moments; the second to about 1e-10;
        the last of several masses, to 1e-8 or, with three elongations together, 1e-6.

    Raises
    ------
    NotCoveredError
        If the system is another one; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    Order 1, elastic wall: the joint density is proportional to exp(-(2C/q)(v^2/2 + Omega^2 x^2/2)) beyond the
    wall [1]_.  No wall: <x^2> = int S dw and <v^2> = int w^2 S dw with
    S = (q / 2 pi) / \\|Omega^2 - w^2 + C (iw)^alpha\\|^2, by the contours of
    `springpot.theory.numerics.contours`.  Order 0 is a spring of stiffness Omega^2 + C (for the Riemann-Liouville
    derivative, and for Caputo's from x(0) = 0).

    References
    ----------
    .. [1] T. K. Caughey, "Nonlinear theory of random vibrations", Advances in Applied Mechanics 11 (1971).

    Examples
    --------
    >>> import springpot as sp
    >>> wall = sp.Barrier(position=1.0, side="above")
    >>> preloaded = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=0.5), barrier=wall)
    >>> round(exact(preloaded).x_mean, 4), round(exact(preloaded).impact_rate, 4)
    (1.5251, 0.6084)
    >>> round(exact(sp.Oscillator(barrier=None)).x_mean_square, 6)
    0.532136
    """
    solve: Callable[[System], Exact | ExactLaw | ExactOfPoints] = form_of(
        system, exact_of_paper, exact_law, exact_of_points
    )
    return solve(system)


def exact_of_paper(system: System) -> Exact:
    """The form of the paper's problem."""
    paper = _paper_covered(system)
    stationary, law = exact_state(system, paper)
    return Exact(
        method="exact",
        system=system,
        stationary=stationary,
        assumptions=("None: this solves the equation of motion as it stands, with memory of the whole past.",),
        warnings=(),
        is_exact=True,
        _law=law,
    )


def check_covered(system: System) -> None:
    """Raise `NotCoveredError` for what is not covered."""
    check: Callable[[System], object] = form_of(system, _paper_covered, check_law_covered, check_points_covered)
    check(system)


def _paper_covered(system: System) -> Dimensionless:
    """The paper's problem where it is covered; otherwise `NotCoveredError`."""
    paper = paper_covered(system)
    wall, alpha = paper.barrier, paper.springpot.order
    if wall is None:
        return paper
    if paper.restitution < 1.0:
        raise NotCoveredError(f"{_REACH}, not a wall of restitution {paper.restitution:g}.")
    if alpha < 1.0 and paper.dissipates:
        raise NotCoveredError(f"{_REACH}, not order {alpha:g} with a wall.")
    return paper


def exact_state(system: System, paper: Dimensionless) -> tuple[Moments | str, Normals | None]:
    """The stationary moments, or why there are none, and the law."""
    problem, units = problem_and_units(paper)
    free = free_mean_squares(paper)
    if units.length == 0.0 and paper.dissipates:
        return at_rest(system, paper), None
    if isinstance(free, str):
        return free, None
    x_mean_square, v_mean_square = free
    spread, x_mean, hit = math.sqrt(v_mean_square), 0.0, NEVER_STRUCK
    law = Normals(units, math.sqrt(x_mean_square), spread, math.nan)
    if paper.barrier is not None:
        k = problem.position / spread
        hazard = hazard_of(k)
        x_mean, x_mean_square = spread * hazard, v_mean_square * (1.0 + k * hazard)
        hit = hazard / math.sqrt(2.0 * math.pi), math.sqrt(math.pi / 2.0 * v_mean_square), 2.0 * v_mean_square
        law = Normals(units, spread, spread, problem.position)
    moments = units.moments(system, x_mean, x_mean_square, v_mean_square, hit)
    if not math.isfinite(moments.amplitude_mean_square):
        c = problem.coefficient
        return f"There is no stationary state in floating point: C Omega^(alpha-2) = {c:g} is too small.", None
    return moments, law
