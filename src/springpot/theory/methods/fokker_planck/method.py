"""The stationary Fokker-Planck equation with a dashpot and a lossy wall: coverage, moments, densities."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System, checked_system
from springpot.theory.densities import Densities
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.methods.fokker_planck.densities import Laws
from springpot.theory.methods.fokker_planck.equation import COARSE, FINE, difference, moments, solve
from springpot.theory.problem import at_rest, endless, paper_covered, problem_and_units
from springpot.theory.result import Moments

_LIGHTEST = 3e-3  # of c; the time integral is 36/c long
_STRONGEST = 50.0
_DEEPEST = 4.0  # b over the free standard deviation of x, beyond which too many digits are lost
_FAR_BEHIND = -6.0  # below this, impacts are so rare that their rate is lost in rounding errors
_LOWEST = 0.18  # of the restitution: impacts down to 1e-200 of the typical speed matter there

_REACH = (
    f"The Fokker-Planck solution covers order 1 with a wall of restitution above exp(-pi/sqrt 3) = {COLLAPSE_BELOW:.3f}"
)
_REFUSED = 1e-2  # estimated error above which there is no result


@dataclass(frozen=True)
class FokkerPlanck(Densities[Laws]):
    """The stationary density of (x, v) with impacts that lose energy.

    Parameters
    ----------
    error_estimate : float
        Largest relative difference of a moment between the result and one on a coarser grid (of x_mean, relative to the
        root mean square); the error of the result is smaller.
    impact_rate_error : float
        The same for the impact rate alone, to which slow impacts contribute most.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.

    The first call of a density tabulates it, which takes a few tenths of a second; between the knots it is interpolated
    to 1e-7 of its maximum.  Within 0.001 sqrt(q / Omega^3) of the wall, where slow impacts may cause a sharp maximum
    (infinite for r at most 0.5), the density of x follows the power law of that maximum.  The joint density takes 0.1
    to 0.6 s for each different displacement: its density of v is tabulated, so that its integral over v is the density
    of x.  Very near the wall (0.02 sqrt(q / Omega^3), more where speeds are high) the density of slow speeds is that at
    this distance, scaled as (distance)^(1/3).  The error is 1e-3 of its maximum there, 1e-4 elsewhere.

    Examples
    --------
    >>> import springpot as sp
    >>> result = fokker_planck(sp.Oscillator(springpot=sp.Springpot(1.0, 0.2), barrier=sp.Barrier(restitution=0.8)))
    >>> result.x_density([-0.1, 1.0]).round(3), result.v_density([-0.5, 0.0, 0.5]).round(3)
    (array([0.   , 0.451]), array([0.281, 0.325, 0.321]))
    >>> result.impact_speed_density([0.0, 1.0]).round(3), result.joint_density(0.5, [-1.0, 1.0]).round(3)
    (array([0.   , 0.432]), array([0.127, 0.157]))
    """

    error_estimate: float
    impact_rate_error: float

    def _more(self) -> dict[str, object]:
        return {"error_estimate": self.error_estimate, "impact_rate_error": self.impact_rate_error}


@np.errstate(all="ignore")  # what is not finite is no answer
def fokker_planck(system: System) -> FokkerPlanck:
    """Solve the stationary Fokker-Planck equation of a linear spring with a dashpot and a lossy wall.

    Parameters
    ----------
    system : System
        A linear spring, a dashpot, white noise, and a wall of restitution above 0.163; elastic walls are solved the
        same way (`exact` is faster).

    Returns
    -------
    FokkerPlanck
        Moments to about 1e-6, and an estimate of their error from two grids.

    Raises
    ------
    NotCoveredError
        If it has other parts, the order is not 1, there is no wall, the restitution is too low, or too many digits
        would be lost because of the damping or the wall's position.
    TypeError
        If it is not a System.

    Notes
    -----
    See `springpot.theory.methods.fokker_planck.equation`.  From f follow <x> = (1+r) N <u>, the energy balance
    c <v^2> = 1/2 - (1-r^2) N <u^2> / 2 and <x^2> = <v^2> + b <x>, with N the rate and u the speed of the impacts.

    Examples
    --------
    >>> import springpot as sp
    >>> lossy = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=0.2), barrier=sp.Barrier(restitution=0.8))
    >>> result = fokker_planck(lossy)
    >>> round(result.x_mean_square, 4), round(result.impact_rate, 4), result.error_estimate < 1e-4
    (1.4917, 0.3346, True)
    """
    system = checked_system(system)
    paper = check_covered(system)
    problem, units = problem_and_units(paper)
    error, rate_error, law = 0.0, 0.0, None
    stationary: Moments | str
    if statement := endless(paper):
        stationary = statement
    elif units.length == 0.0:
        stationary = at_rest(system, paper)
    else:
        impacts = solve(problem, FINE)
        stationary, coarse = (
            units.moments(system, *moments(problem, found)) for found in (impacts, solve(problem, COARSE))
        )
        error, rate_error = difference(stationary, coarse)
        if not max(error, rate_error) < _REFUSED:
            raise NotCoveredError(
                f"{_REACH} where its numerical solution is accurate; here two grids differ by {error:.1g}."
            )
        x_root = math.sqrt(stationary.x_mean_square) / units.length
        law = Laws(problem, impacts, units, x_root, math.sqrt(stationary.v_mean_square) / units.speed)
    return FokkerPlanck(
        method="fokker_planck",
        system=system,
        stationary=stationary,
        assumptions=("None but the numerical solution: its error is estimated from two grids.",),
        warnings=_warnings(error, rate_error),
        is_exact=True,
        error_estimate=error,
        impact_rate_error=rate_error,
        _law=law,
    )


def _warnings(error: float, rate_error: float) -> tuple[str, ...]:
    if max(error, rate_error) < 1e-4:
        return ()
    return (f"Two grids differ by {error:.1g} of a moment and {rate_error:.1g} of the impact rate.",)


def check_covered(system: System) -> Dimensionless:
    """The paper's problem, where it is covered; otherwise `NotCoveredError`."""
    paper = paper_covered(system)
    wall, alpha, c = paper.barrier, paper.springpot.order, paper.dimensionless_coefficient
    if wall is None:
        raise NotCoveredError(f"{_REACH}, not an oscillator without a wall.")
    if alpha != 1.0:
        raise NotCoveredError(f"{_REACH}, not order {alpha:g}.")
    if not paper.dissipates:
        return paper
    if paper.restitution < _LOWEST:
        raise NotCoveredError(f"{_REACH} (in practice {_LOWEST:g}), not restitution {paper.restitution:g}.")
    if not _LIGHTEST <= c <= _STRONGEST:
        raise NotCoveredError(f"{_REACH} and C/Omega in [{_LIGHTEST:g}, {_STRONGEST:g}], not {c:.3g}.")
    k = paper.dimensionless_position * math.sqrt(2.0 * c)
    if paper.length_scale > 0.0 and not _FAR_BEHIND <= k <= _DEEPEST:
        raise NotCoveredError(
            f"{_REACH} at {_FAR_BEHIND:g} to {_DEEPEST:g} standard deviations sqrt(q / 2 C Omega^2), not at {k:.3g}."
        )
    return paper
