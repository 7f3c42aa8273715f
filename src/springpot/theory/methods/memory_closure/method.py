"""Gaussian memory closure: the springpot's memory from a Gaussian correlation, the rest from the plane of (x, v).

Two steps, repeated until they agree:

1. x is unfolded at the wall, x - b = \\|y\\|, and y is assumed Gaussian.  Its correlation gives an equivalent linear
   element for the springpot, which determines the spectrum and so the correlation (`memory`).
2. That correlation gives the mean force of the springpot for each present (x, v).  The stationary density of (x, v)
   with this force, and with position and losses of the wall, is computed without linearization (`plane`).  A stiffness
   and a damping are added to step 1 so that its <y^2> and <v^2> are those of step 2.

The derivation, and the alternatives that were tried, are in the documentation, page "The Gaussian memory closure".
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import finite_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, per_cent
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system
from springpot.theory.densities import DensitiesOfAmplitude
from springpot.theory.distributions import Normals
from springpot.theory.methods.exact import exact, exact_state
from springpot.theory.methods.memory_closure.memory import (
    Loop,
    folded_correlation,
    folded_spectrum,
    unfolded_correlation,
)
from springpot.theory.methods.memory_closure.plane import Plane
from springpot.theory.methods.memory_closure.steps import least_loss, light_loss, solve_with_wall
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.problem import Units, at_rest, endless, paper_covered, problem_and_units
from springpot.theory.result import ROUNDED, Moments

_REACH = 1.0  # the farthest wall, in units of sqrt(q / Omega^3)
_GAP = 1.5  # the widest gap times c: beyond, impacts are rare and |y| is a poor model
_LOSSY = 0.5  # the smallest restitution
_STRONG = 10.0  # the largest c
_DIP = 2e-3  # largest negative value of a density, over its maximum, without a warning
_MAPPED = 3.0  # the largest c on the validity map
_FAR = 40.0  # standard deviations at which every density is exactly 0 in double precision


@dataclass(frozen=True)
class MemoryClosure(DensitiesOfAmplitude["_Solved | Normals"]):
    """Result of the memory closure: stationary moments, densities, correlation and spectrum.

    Parameters
    ----------
    iterations : int
        Number of solutions of step 2; 0 without a wall, where the result is exact.
    residual : float
        Last change of the stiffness and damping by which the two steps differ, over Omega^2 and Omega.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.

    With a wall every density is a Gaussian times a polynomial of degree 9: its integral is 1 to rounding, but with a
    lossy wall and in the tails it may be negative; ``warnings`` says so above 0.2 % of the maximum.
    """

    iterations: int
    residual: float

    @np.errstate(all="ignore")  # at the ends of double precision
    def correlation(self, lag: ArrayLike) -> Floats:
        """<x(t) x(t + lag)> in the stationary state, in m^2: <x^2> at lag 0, the squared mean far away.

        Without a wall it is exact; with one the shape of its covariance is that of the folded Gaussian of step 1.

        Parameters
        ----------
        lag : array_like
            In s, of either sign.

        Raises
        ------
        NoStationaryStateError, TypeError, ValueError
            As in `x_density`, or if a lag is not finite.

        Examples
        --------
        >>> import springpot as sp
        >>> result = memory_closure(sp.Oscillator())
        >>> bool(abs(result.correlation(0.0) / result.x_mean_square - 1.0) < 1e-12)
        True
        """
        law = self._stationary_law()
        time = np.abs(finite_array(lag, "lag")) * self.paper.natural_frequency
        if time.size == 0:
            return time
        if isinstance(law, Normals):
            return exact(self.system).correlation(lag)
        shape = folded_correlation(unfolded_correlation(law.loop, time.ravel()).reshape(time.shape))
        return np.asarray(self.x_mean**2 + self._variance * shape)

    @np.errstate(all="ignore")  # at the ends of double precision
    def spectrum(self, frequency: ArrayLike) -> Floats:
        """Two-sided spectral density of x - <x>, in m^2 s per rad.

        Its integral over the real line is the variance of x.  Without a wall it is exact; with one its shape is that
        of the folded Gaussian of step 1.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.

        Raises
        ------
        NoStationaryStateError, TypeError, ValueError
            As in `x_density`, or if a frequency is not finite.

        Examples
        --------
        >>> import springpot as sp
        >>> result = memory_closure(sp.Oscillator(barrier=None))
        >>> float(result.spectrum(0.0).round(6)) == round(0.5 / np.pi, 6)
        True
        """
        law, omega = self._stationary_law(), self.paper.natural_frequency
        w = np.abs(finite_array(frequency, "frequency")) / omega
        if w.size == 0:
            return np.asarray(w)
        if isinstance(law, Normals):
            return exact(self.system).spectrum(frequency)
        return np.asarray(self._variance / omega * folded_spectrum(law.loop, w.ravel()).reshape(w.shape))

    def _more(self) -> dict[str, object]:
        return {"iterations": self.iterations, "residual": self.residual}

    @property
    def _variance(self) -> float:
        return self.x_mean_square - self.x_mean**2


@dataclass(frozen=True)
class _Solved:
    """Result of the iteration, and its densities in units of sigma_y and sigma_v, measured from the wall."""

    loop: Loop
    plane: Plane
    units: Units
    wall: float

    def x(self, x: Floats) -> Floats:
        """Density of the distance from the wall."""
        return np.asarray(np.where(x < 0.0, 0.0, self.plane.y_density(np.clip(x, 0.0, _FAR))))

    def v(self, v: Floats) -> Floats:
        """Density of the velocity away from the wall."""
        return self.plane.v_density(np.clip(v, -_FAR, _FAR))

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of both."""
        return np.where(x < 0.0, 0.0, self.plane.joint(np.clip(x, 0.0, _FAR), np.clip(v, -_FAR, _FAR)))

    def amplitude(self, amplitude: Floats) -> Floats:
        """Density of the amplitude: the joint density's integral over the phase on the circle of one amplitude."""
        pace = self.plane.sigma_y / self.plane.sigma_v  # Omega over that of the units
        a = np.clip(amplitude, 0.0, 2.0 * _FAR * (1.0 + 1.0 / pace))  # which is never reached
        with np.errstate(divide="ignore", invalid="ignore"):
            half = np.arccos(np.clip(np.where(a > 0.0, self.wall / a, np.sign(self.wall)), -1.0, 1.0))
        node, weight = panel_rule(np.linspace(-1.0, 1.0, 7), 12)
        phase = half[..., None] * node
        y, v = a[..., None] * np.cos(phase) - self.wall, pace * a[..., None] * np.sin(phase)
        along = half * (self.joint(np.maximum(y, 0.0), v) @ weight)
        return np.where(amplitude < 0.0, 0.0, pace * a * along)

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed just before an impact."""
        return self.plane.impact_speed_density(np.clip(speed, 0.0, _FAR))


@np.errstate(all="ignore")  # what is not finite is no answer
def memory_closure(system: System) -> MemoryClosure:
    """Solve the paper's problem by the Gaussian memory closure.

    Parameters
    ----------
    system : System
        A linear spring, one springpot or dashpot and white noise.  Without a wall the answer is exact.  A wall must be
        within sqrt(q / Omega^3) of equilibrium, with a restitution of at least 0.5 and c = C Omega^(alpha-2) at most
        10.

    Returns
    -------
    Closure

    Raises
    ------
    NotCoveredError
        If it has other parts, the wall is farther away or more lossy, or the springpot is stronger.
    NoConvergenceError
        If the iteration does not reach its tolerance.
    TypeError
        If it is not a System.

    Examples
    --------
    >>> import springpot as sp
    >>> result = memory_closure(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0)))
    >>> [round(value, 6) for value in (result.x_mean_square, result.v_mean_square, result.impact_rate * np.pi)]
    [0.5, 0.5, 1.0]
    """
    system = checked_system(system)
    paper = check_covered(system)
    problem, units = problem_and_units(paper)
    alpha = problem.order if problem.coefficient > 0.0 else 1.0  # without a springpot, as a dashpot of strength 0
    iterations, residual = 0, 0.0
    law: _Solved | Normals | None = None
    doubts: tuple[str, ...] = ()
    stationary: Moments | str
    if statement := endless(paper):
        stationary = statement
    elif paper.excitation.intensity == 0.0:
        stationary = at_rest(system, paper)
    elif paper.barrier is None:
        stationary, law = exact_state(system, paper)
    else:
        b = problem.position
        loop, plane, iterations, residual = solve_with_wall(alpha, problem.coefficient, problem.restitution, b)
        own = replace(
            units, length=plane.sigma_y * units.length, speed=plane.sigma_v * units.speed,
            origin=paper.barrier.position,
        )  # fmt: skip
        law, doubts = _Solved(loop, plane, own, b / plane.sigma_y), _about_negative_densities(plane)
        square = plane.y_moment(2) + 2.0 * b * plane.y_moment(1) + b * b
        hit = plane.impact_rate, plane.impact_speed_moment(1), plane.impact_speed_moment(2)
        stationary = units.moments(system, b + plane.y_moment(1), square, plane.v_mean_square, hit)
    return MemoryClosure(
        method="memory_closure",
        system=system,
        stationary=stationary,
        assumptions=_assumptions(paper),
        warnings=(*_warnings(paper), *doubts),
        is_exact=paper.barrier is None,
        iterations=iterations,
        residual=residual,
        _law=law,
    )


def check_covered(system: System) -> Dimensionless:
    """The paper's problem, where it is covered; otherwise `NotCoveredError`."""
    paper = paper_covered(system)
    wall, c, b = paper.barrier, paper.dimensionless_coefficient, paper.dimensionless_position
    alpha = paper.springpot.order if c > 0.0 else 1.0
    if c > _STRONG * ROUNDED:
        raise NotCoveredError(f"The memory closure covers c = C Omega^(alpha-2) up to {_STRONG:g}, not {c:.3g}.")
    if wall is None:
        return paper
    if wall.position != 0.0 and abs(b) > _REACH * ROUNDED:
        raise NotCoveredError(
            f"The memory closure covers no wall, or a wall within {_REACH:g} sqrt(q / Omega^3) of equilibrium, "
            f"not one at {b:g} times that."
        )
    if -b * c > _GAP * ROUNDED:
        raise NotCoveredError(
            f"The memory closure covers a gap up to {_GAP:g} / c in units of sqrt(q / Omega^3) "
            f"(c = C Omega^(alpha-2) = {c:.3g}), not {-b:g}."
        )
    if paper.restitution < _LOSSY / ROUNDED:
        raise NotCoveredError(
            f"The memory closure covers a restitution of at least {_LOSSY:g}, not {paper.restitution:g}."
        )
    if not paper.dissipates:
        return paper
    if alpha == 0.0:
        raise NotCoveredError(
            "The memory closure covers alpha > 0: at alpha = 0 the springpot is a spring without memory."
        )
    loss = light_loss(alpha, c, paper.restitution)
    if loss < least_loss(c):
        raise NotCoveredError(
            f"The memory closure with a wall covers losses of at least {least_loss(c):.2g} Omega per unit of energy "
            f"and time, not {loss:.2g}: averaging is accurate there."
        )
    return paper


def _assumptions(paper: Dimensionless) -> tuple[str, ...]:
    if paper.barrier is None:
        return ("The past motion is stationary: this is exact without a wall.",)
    return (
        "The past motion is a Gaussian process reflected at the wall, |y| with y Gaussian.",
        "The past motion is stationary: the start no longer matters.",
    )


def _warnings(paper: Dimensionless) -> tuple[str, ...]:
    """Errors against Monte Carlo, beyond the validity map."""
    c = paper.dimensionless_coefficient
    if paper.barrier is None or c <= _MAPPED or paper.springpot.order == 1.0:
        return ()
    return (
        f"The springpot is strong (c = C Omega^(alpha-2) = {c:.3g}): at c = 10 <A^2> was 1.4 % too high, 3 and 8 % too "
        "low and the impact rate 4, 6, 7 % too high at alpha = 0.8, 0.5, 0.2.",
    )


def _about_negative_densities(plane: Plane) -> tuple[str, ...]:
    far = np.linspace(0.0, 6.0, 121)
    both = np.concatenate([-far[::-1], far])
    densities = (plane.y_density(far), plane.v_density(both), plane.impact_speed_density(far))
    dip = max(float(-density.min() / density.max()) for density in densities)
    if dip <= _DIP:
        return ()
    return (
        f"The densities fall below 0 by up to {per_cent(dip, 1)} of their maximum: polynomials of this degree cannot "
        "describe the slow impacts at a lossy wall.  The moments are more accurate.",
    )
