"""Exact answers, with one result for all: the paper's problem, one mass in any potential, several masses."""

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
from springpot.theory.coverage import form_of
from springpot.theory.densities import DensitiesOfAmplitude
from springpot.theory.distributions import Normals, hazard_of, modulus_correlation, times
from springpot.theory.methods.systems.boltzmann import check_points_covered, exact_of_points
from springpot.theory.methods.systems.energy import EnergyLaw, check_law_covered, exact_law
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
class Exact(DensitiesOfAmplitude[Normals | EnergyLaw]):
    """The exact stationary state, and where it is known the way there from rest.

    Of a linear spring x and v are independent and normal, with x cut off at a wall; else the density is a function of
    the energy.

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

    def _stationary_law(self) -> Normals | EnergyLaw:
        _ = self.system.per_unit_mass  # of several masses there are moments alone
        return super()._stationary_law()


@np.errstate(all="ignore")  # what is not finite is no answer
def exact(system: System) -> Exact:
    """Solve a system exactly, where that can be done.

    Parameters
    ----------
    system : System
        Linear springs, one springpot or dashpot and white noise without a wall; or any springs, constant forces,
        elastic walls and conservative contacts, on one mass or several, with one of

        - dashpots and white noise, of several masses such that its matrix is 2 kT times that of the dashpots;
        - `ThermalNoise`, with any springpots, arms, circuits and dashpots (and white noise, with dashpots alone);
        - on one mass and a linear spring, dashpots, `VanDerPol` and a cubic `PolynomialDashpot` of the coefficient
          mu / Omega^2 (mu of VanDerPol), and white noise.

        Masses that no part joins to the others may have another temperature.  At most three elongations with walls,
        contacts or nonlinear springs may depend on each other.

    Returns
    -------
    Exact
        Moments of the paper's problem to about 1e-13 of their size, of one mass with other parts to 1e-10 (a warning
        says where rounding leaves less), of several masses to 1e-8, or 1e-6 where three elongations depend on each
        other.  Densities are of one mass; those of amplitude and energy, correlation, spectrum and the way from rest of
        the paper's problem.

    Raises
    ------
    NotCoveredError
        If the system is another one; the sentence names the part.
    NoConvergenceError
        If the density is too narrow beside its range, or rounding of large energies leaves nothing of it.
    TypeError
        If it is not a System.

    Notes
    -----
    The density is proportional to exp(-(2/q) int_0^H f dH) for a damping force f(H) v and white noise of intensity q
    [1]_, and to exp(-H / kT) for matched noise, whatever the memory [2]_; H is the energy, per unit mass in the former.
    A linear spring, a dashpot and one elastic wall thus have normal x, cut off at the wall, and normal v.  Without a
    wall and with memory <x^2> = int S dw and <v^2> = int w^2 S dw with
    S = (q / 2 pi) / \\|Omega^2 - w^2 + C (iw)^alpha\\|^2, by the contours of
    `springpot.theory.numerics.contours`.  Order 0 is a spring of stiffness Omega^2 + C (for the Riemann-Liouville
    derivative, and for Caputo's from x(0) = 0).

    References
    ----------
    .. [1] T. K. Caughey, "Nonlinear theory of random vibrations", Advances in Applied Mechanics 11 (1971).
    .. [2] R. Kubo, "The fluctuation-dissipation theorem", Reports on Progress in Physics 29 (1966).

    Examples
    --------
    >>> import springpot as sp
    >>> wall = sp.Barrier(position=1.0, free_side="above")
    >>> preloaded = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=0.5), barrier=wall)
    >>> round(exact(preloaded).x_mean, 4), round(exact(preloaded).impact_rate, 4)
    (1.5251, 0.6084)
    >>> round(exact(sp.Oscillator(barrier=None)).x_mean_square, 6)
    0.532136

    Two elastic walls and a hardening spring:

    >>> system = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.1, 1.0)), sp.Dashpot(0.4), sp.WhiteNoise(1.0),
    ...     sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below"),
    ... )
    >>> result = exact(system)
    >>> round(result.x_mean, 5), round(result.barrier_1_impact_rate, 5), round(result.barrier_2_impact_rate, 5)
    (0.25606, 0.28165, 0.11139)

    Two masses that strike each other:

    >>> pair = sp.System(
    ...     sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(2.0, between=("ground", "a")),
    ...     sp.Spring(1.0, between=("a", "b")), sp.Spring(0.5, between=("ground", "b")),
    ...     sp.Springpot(0.5, 0.2, between=("a", "b")), sp.ThermalNoise(0.6),
    ...     stop=sp.Barrier(-0.3, between=("a", "b")),
    ... )
    >>> round(exact(pair).stop_impact_rate, 6), round(exact(pair).stop_force_mean, 6)
    (0.434012, 0.486526)
    """
    stationary, law, warnings = form_of(system, _of_paper, exact_law, _of_points)(system)
    return Exact(
        method="exact",
        system=system,
        stationary=stationary,
        assumptions=("None: this solves the equation of motion as it stands, with memory of the whole past.",),
        warnings=warnings,
        is_exact=True,
        _law=law,
    )


def check_covered(system: System) -> None:
    """Raise `NotCoveredError` for what is not covered."""
    check: Callable[[System], object] = form_of(system, _paper_covered, check_law_covered, check_points_covered)
    check(system)


_Solved = tuple[Moments | str, Normals | EnergyLaw | None, tuple[str, ...]]


def _of_paper(system: System) -> _Solved:
    return *exact_state(system, _paper_covered(system)), ()


def _of_points(system: System) -> _Solved:
    return exact_of_points(system), None, ()


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
