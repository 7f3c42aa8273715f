"""Statistical linearization: the linear system that is nearest to a nonlinear one, in mean square."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray
from scipy import optimize

from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Constant,
    Dashpot,
    Harmonic,
    ParametricNoise,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.potential import Potential
from springpot.problem.system import System, checked_system
from springpot.theory.methods.systems.energy import exact_law
from springpot.theory.methods.systems.linear import Companion, companion_of, linear_moments
from springpot.theory.result import Moments, NoConvergenceError, NoStationaryStateError, Result

__all__ = ["Linearization", "check_covered", "linearization"]

FloatArray = NDArray[np.float64]

_REACH = "Statistical linearization covers nonlinear springs with one equilibrium and nonlinear dampers, without walls"
_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(40)
_WEIGHTS = _WEIGHTS / math.sqrt(2.0 * math.pi)
_TOLERANCE = 1e-10
_BENT = 0.05  # error of the variance in a bath of springs that bend, beyond which it is said


@dataclass(frozen=True)
class Linearization(Result):
    """The moments of the nearest linear system.

    Parameters
    ----------
    stiffness, damping : float
        Of that system, in N/m and N s/m (per unit mass in a system without a `Mass`).

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.
    """

    stiffness: float
    damping: float


@np.errstate(all="ignore")  # what is not finite is no answer
def linearization(system: System) -> Linearization:
    """Replace nonlinear springs and dampers by the linear ones whose force differs least in mean square.

    Parameters
    ----------
    system : System
        Springs with one equilibrium, nonlinear dampers, and everything that `springpot.theory.linear` covers but
        harmonic and parametric excitation.

    Returns
    -------
    Linearization

    Raises
    ------
    NotCoveredError
        If the system has a wall, two wells, or excitation that is not stationary noise; the sentence names the part.
    NoConvergenceError
        If the equations have no solution that is found.
    TypeError
        If it is not a System.

    Notes
    -----
    x and v are taken as Gaussian and independent at one time.  The stiffness is E[U''(x)], the damping
    E[v F(x, v)] / E[v^2], and the mean of x balances the mean force; memory is kept as it is [1]_.  For a cubic spring
    <x^2> comes out too small; a warning says where it would be by more than 5 % in thermal noise, where the exact law
    is known.

    References
    ----------
    .. [1] J. B. Roberts and P. D. Spanos, "Random vibration and statistical linearization", Wiley (1990).

    Examples
    --------
    >>> import springpot as sp
    >>> duffing = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0)
    ... )
    >>> round(linearization(duffing).x_mean_square, 4)
    0.346
    """
    system = checked_system(system)
    unit = system.per_unit_mass
    companion, stationary = _solve(system, check_covered(system))
    warnings: tuple[str, ...] = ()
    if not isinstance(stationary, str):
        warnings = tuple(_strained(unit, companion, stationary))
    return Linearization(
        method="linearization",
        system=system,
        stationary=stationary,
        assumptions=("x and v are Gaussian, and independent of each other at one time.",),
        warnings=warnings,
        is_exact=_is_linear(unit),
        stiffness=companion.stiffness * system.inertia,
        damping=companion.damping * system.inertia,
    )


def check_covered(system: System) -> Companion:
    """The linear part of a system that is covered; otherwise `NotCoveredError`."""
    unit = system.per_unit_mass
    for name, part in unit.named():
        if isinstance(part, Harmonic | ParametricNoise):
            raise NotCoveredError(f"{_REACH} and with stationary noise, not {name}.")
    if _wells(unit.potential) > 1:
        raise NotCoveredError(f"{_REACH}, not two wells.")
    return companion_of(_without_nonlinear(unit))


def _is_linear(unit: System) -> bool:
    """Whether nothing is approximated."""
    bent = [not part.is_linear for part in unit.of(PolynomialSpring)]
    bent += [not part.is_linear for part in unit.of(PolynomialDashpot)]
    return not any(bent) and not unit.of(VanDerPol)


def _wells(potential: Potential) -> int:
    """How often the force turns from a push to the right to a pull back: between its roots it keeps its sign."""
    coefficients = np.array(potential.coefficients)
    places = np.unique(polynomial.polyroots(coefficients).real)
    if places.size < 2:
        return places.size
    tests = np.concatenate([0.5 * (places[1:] + places[:-1])])
    force = polynomial.polyval(tests, coefficients)
    told_apart = np.abs(force) > 1e-10 * polynomial.polyval(np.abs(tests), np.abs(coefficients))
    signs = np.concatenate([[-1.0], np.sign(force[told_apart]), [1.0]])
    return int(np.count_nonzero((signs[1:] > 0.0) & (signs[:-1] < 0.0)))


def _without_nonlinear(unit: System) -> System:
    """The parts that a linear system keeps; walls stay, and are refused there."""
    kept = {
        name: part
        for name, part in unit.named()
        if not isinstance(part, PolynomialSpring | Spring | PolynomialDashpot | VanDerPol | Dashpot)
    }
    free = "held"
    while free in kept:
        free += "_"
    return System(**kept, **{free: Spring(1.0)})


def _solve(system: System, companion: Companion) -> tuple[Companion, Moments | str]:
    """The linear system whose own moments give its stiffness, damping and mean."""
    unit = system.per_unit_mass
    potential = unit.potential
    quiet = all(isinstance(noise, WhiteNoise) and noise.intensity == 0.0 for noise in companion.noises)
    if quiet and companion.temperature == 0.0:
        return _no_answer(companion), "There is no random stationary state: nothing excites the motion."
    if not companion.dissipates and not _damping(unit, 0.0, 1e20, 1e20) > 0.0:
        return _no_answer(companion), "There is no stationary state: nothing dissipates energy."
    soft = sum(pot.coefficient for pot in unit.of(Springpot) if pot.order == 0.0)  # which the linear system keeps

    def at(state: FloatArray) -> tuple[Companion, Moments | str, float]:
        mean, x_spread, v_spread = float(state[0]), math.exp(float(state[1])), math.exp(float(state[2]))
        places = mean + x_spread * _NODES
        held = float(_WEIGHTS @ potential.curvature(places))  # also by springpots of order 0
        damping = _damping(unit, mean, x_spread, v_spread)
        here = replace(companion, stiffness=held - soft, damping=damping, force=0.0)
        balance = float(_WEIGHTS @ potential.force(places))
        return here, linear_moments(unit, here), balance / held

    def missing(state: FloatArray) -> FloatArray:
        _, moments, shift = at(state)
        if isinstance(moments, str):
            raise NoConvergenceError(
                "statistical linearization found no solution: on the way nothing dissipates energy."
            )
        return np.array(
            [
                shift / math.exp(state[1]),
                0.5 * math.log(moments.x_mean_square) - state[1],
                0.5 * math.log(moments.v_mean_square) - state[2],
            ]
        )

    try:
        start = _start(unit, companion, potential)
        solved = optimize.root(missing, start, method="hybr", options={"xtol": _TOLERANCE})
    except NoStationaryStateError as unstable:
        return _no_answer(companion), str(unstable)
    if not np.abs(missing(solved.x)).max() < 1e-7:
        raise NoConvergenceError("statistical linearization found no solution: its equations did not settle.")
    here, _, _ = at(solved.x)
    force = float(solved.x[0]) * (here.stiffness + soft)  # with which the mean is that
    return here, linear_moments(system, replace(here, force=force))


def _strained(unit: System, companion: Companion, found: Moments) -> Iterator[str]:
    """Where x is far from Gaussian."""
    variance = found.x_mean_square - found.x_mean**2
    memory = 0.0
    if not unit.of(ThermalNoise):  # in a bath memory does not change the law of x
        memory = float(companion.dissipative(np.array([math.sqrt(found.v_mean_square / variance)]))[0].real)
    springs = [part for part in unit.parts if isinstance(part, PolynomialSpring | Spring | Constant)]
    # a bath in which the same springs, and the memory's, have this variance where x is Gaussian
    bath = System(Dashpot(1.0), ThermalNoise((companion.stiffness + memory) * variance), *springs, Spring(memory))
    with contextlib.suppress(NoConvergenceError):
        true = exact_law(bath).moments
        ratio = variance / (true.x_mean_square - true.x_mean**2)
        if not _is_linear(unit) and abs(ratio - 1.0) > _BENT:
            side = "small" if ratio < 1.0 else "large"
            yield f"The springs bend so much that x is far from Gaussian: its variance comes out too {side}."
    if _damping(unit, found.x_mean, 0.0, 0.0) < 0.0:
        yield "The dampers feed small motions: around a limit cycle <x^2> can come out small by a factor of 2."
    impulses = unit.of(PoissonImpulses)
    energy = 0.5 * (found.v_mean_square + companion.stiffness * (found.x_mean_square - found.x_mean**2))
    nonlinear = any(isinstance(p, VanDerPol | PolynomialSpring | PolynomialDashpot) for p in unit.parts)
    if nonlinear and any(0.5 * part.intensity / energy > 0.1 * part.rate for part in impulses):
        yield "The impulses are so rare that x is far from Gaussian: here they act as white noise of equal intensity."


def _no_answer(companion: Companion) -> Companion:
    return replace(companion, stiffness=math.nan, damping=math.nan)


def _start(unit: System, companion: Companion, potential: Potential) -> FloatArray:
    """The equilibrium, and spreads at which the springs hold as much energy as noise feeds in a while."""
    roots = polynomial.polyroots(potential.coefficients)
    mean = float(min(roots, key=lambda root: abs(root.imag)).real) if roots.size else 0.0
    spread, least, most = 1.0, 0.0, math.inf
    for _ in range(400):  # the spread at which the linear system has the spread itself
        places = mean + spread * _NODES
        stiffness = float(_WEIGHTS @ potential.curvature(places))
        damping = _damping(unit, mean, spread, spread * math.sqrt(max(stiffness, 1e-300)))
        ratio = math.inf
        if stiffness > 0.0 and (damping > 0.0 or companion.dissipates):
            moments = linear_moments(unit, replace(companion, stiffness=stiffness, damping=damping, force=0.0))
            if isinstance(moments, str):
                raise NoStationaryStateError(moments)
            ratio = math.sqrt(moments.x_mean_square) / spread
            if abs(math.log(ratio)) < 0.1 or most < least * (1.0 + 1e-9):
                return np.array([mean, 0.5 * math.log(moments.x_mean_square), 0.5 * math.log(moments.v_mean_square)])
        least, most = (spread, most) if ratio > 1.0 else (least, spread)
        step = min(max(math.sqrt(ratio), 0.05), 20.0) if math.isfinite(ratio) else 2.0
        spread = math.sqrt(least * most) if 0.0 < least < most < math.inf else spread * step
    raise NoConvergenceError("statistical linearization found no solution: no spread agrees with itself.")


def _damping(unit: System, mean: float, x_spread: float, v_spread: float) -> float:
    """E[v F] / E[v^2] of all dampers, for Gaussian x and v."""
    found = sum(part.coefficient for part in unit.of(Dashpot))
    for part in unit.of(PolynomialDashpot):
        equivalents = 1.0, 2.0 * math.sqrt(2.0 / math.pi) * v_spread, 3.0 * v_spread**2
        found += math.fsum(c * equivalent for c, equivalent in zip(part.coefficients, equivalents, strict=False))
    for pump in unit.of(VanDerPol):
        found += pump.coefficient * (mean * mean + x_spread**2 - pump.length**2)
    return found
