"""The exact stationary law of systems whose density depends on the energy alone."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.faults import NotCovered
from springpot.parts import (
    Barrier,
    Circuit,
    Constant,
    Contact,
    Dashpot,
    Maxwell,
    PolynomialDashpot,
    PolynomialSpring,
    Series,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.potential import Potential
from springpot.system import System
from springpot.theory.distributions import numbers_only, real_array
from springpot.theory.methods.systems.result import SystemMoments, SystemResult, checked_system, walls_of

__all__ = ["ExactLaw", "exact_law"]

FloatArray = NDArray[np.float64]

_FAR = 750.0  # exponent at which a density is 0 in double precision
_PANELS = 96
_NODES = 24
_WIDTHS = np.array([-40.0, -16.0, -8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0, 16.0, 40.0])
_KEPT = (Spring, PolynomialSpring, Constant, Barrier, Contact)  # parts that only shape the potential


@dataclass(frozen=True)
class _EnergyLaw:
    """The density exp(-g(H)) / Z with g = a H + b H^2, H = v^2 / 2 + U(x) less the least U between the walls."""

    potential: Potential
    linear: float
    square: float
    places: FloatArray = field(repr=False)
    weights: FloatArray = field(repr=False)
    least: float
    total: float

    def exponent(self, energy: FloatArray) -> FloatArray:
        return self.linear * energy + self.square * energy * energy

    def speed_integral(self, power: int, potential: FloatArray) -> FloatArray:
        """The integral of v^power exp(-g) over v > 0, at potentials above the least."""
        u = np.atleast_1d(potential)
        if self.square == 0.0:
            theta = 1.0 / self.linear
            half = 0.5 * (power + 1)
            size = 0.5 * math.gamma(half) * (2.0 * theta) ** half
            return np.asarray(size * np.exp(-np.minimum(self.linear * u, _FAR)))
        nodes, weights = _gauss(0.0, 1.0)
        top = np.sqrt(2.0 * _highest(self.linear, self.square, u))[:, None]
        v = top * nodes
        values = v**power * np.exp(-self.exponent(0.5 * v * v + u[:, None]) + self._lowest())
        return np.asarray((values @ weights) * top[:, 0])

    def _lowest(self) -> float:
        """The least of g, so that no exponential overflows."""
        return _least_exponent(self.linear, self.square)

    def x_density(self, x: FloatArray) -> FloatArray:
        inside = (x >= self.potential.low) & (x <= self.potential.high) & np.isfinite(x)
        where = np.where(inside, x, self.places[0])
        found = 2.0 * self.speed_integral(0, (self.potential.energy(where) - self.least).ravel()).reshape(x.shape)
        return np.where(inside, found / self.total, np.where(np.isnan(x), np.nan, 0.0))

    def joint_density(self, x: FloatArray, v: FloatArray) -> FloatArray:
        inside = (x >= self.potential.low) & (x <= self.potential.high) & np.isfinite(x) & np.isfinite(v)
        energy = self.potential.energy(np.where(inside, x, 0.0)) - self.least + 0.5 * np.where(inside, v, 0.0) ** 2
        found = np.exp(-np.minimum(self.exponent(energy) - self._lowest(), _FAR)) / self.total
        return np.where(inside, found, np.where(np.isnan(x) | np.isnan(v), np.nan, 0.0))

    def v_density(self, v: FloatArray) -> FloatArray:
        u = self.potential.energy(self.places) - self.least
        energy = u + 0.5 * np.minimum(np.abs(v.reshape(-1, 1)), 1e150) ** 2
        values = np.exp(-np.minimum(self.exponent(np.minimum(energy, 1e150)) - self._lowest(), _FAR)) @ self.weights
        return np.where(np.isnan(v), np.nan, values.reshape(v.shape) / self.total)


@dataclass(frozen=True)
class ExactLaw(SystemResult):
    """The exact stationary state of a system, with its densities.

    Notes
    -----
    The parameters are those of `SystemResult`.
    """

    _law: _EnergyLaw | None = field(default=None, repr=False, compare=False, kw_only=True)

    @numbers_only
    def x_density(self, displacement: ArrayLike) -> FloatArray:
        """Density of x, in 1/m.

        Parameters
        ----------
        displacement : array_like
            x in m.

        Raises
        ------
        NoStationaryState
            If there is none.

        Examples
        --------
        >>> import springpot as sp
        >>> duffing = sp.System(sp.Spring(1.0), sp.PolynomialSpring((0, 0, 1.0)), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
        >>> float(sp.theory.exact(duffing).x_density(0.0).round(4))
        0.5281
        """
        return self._known().x_density(real_array(displacement, "displacement"))

    @numbers_only
    def v_density(self, velocity: ArrayLike) -> FloatArray:
        """Density of v, in s/m.

        Parameters and errors are those of `x_density`, with v in m/s.
        """
        return self._known().v_density(real_array(velocity, "velocity"))

    @numbers_only
    def joint_density(self, displacement: ArrayLike, velocity: ArrayLike) -> FloatArray:
        """Density of (x, v), in s/m^2; the arguments are broadcast.

        Parameters and errors are those of `x_density`, with x in m and v in m/s.
        """
        x, v = np.broadcast_arrays(real_array(displacement, "displacement"), real_array(velocity, "velocity"))
        return self._known().joint_density(x, v)

    def _known(self) -> _EnergyLaw:
        _ = self.moments
        assert self._law is not None
        return self._law


def exact_law(system: System) -> ExactLaw:
    """The exact stationary law of a system, where its density depends on the energy alone.

    Parameters
    ----------
    system : System
        Any springs, constant forces, elastic walls and conservative contacts, with one of

        - dashpots and white noise;
        - `ThermalNoise`, with any springpots, arms, circuits and dashpots (and white noise, with dashpots alone);
        - dashpots, `VanDerPol` and a cubic `PolynomialDashpot` of the coefficient mu / Omega^2 (mu of VanDerPol),
          white noise, and a linear spring.

    Returns
    -------
    ExactLaw
        Its moments are exact to about 1e-10 of their size.

    Raises
    ------
    NotCovered
        If the system is another one; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    The density is proportional to exp(-(2/q) int_0^H f dH) for a damping force f(H) v and white noise of intensity q
    [1]_, and to exp(-H / kT) for matched noise, whatever the memory [2]_.

    References
    ----------
    .. [1] T. K. Caughey, "Nonlinear theory of random vibrations", Advances in Applied Mechanics 11 (1971).
    .. [2] R. Kubo, "The fluctuation-dissipation theorem", Reports on Progress in Physics 29 (1966).

    Examples
    --------
    Two elastic walls and a hardening spring:

    >>> import springpot as sp
    >>> system = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.1, 1.0)), sp.Dashpot(0.4), sp.WhiteNoise(1.0),
    ...     sp.Barrier(-0.5), sp.Barrier(1.2, side="below"),
    ... )
    >>> result = exact_law(system)
    >>> round(result.x_mean, 5), [round(rate, 5) for rate in result.barrier_impact_rate]
    (0.25606, [0.28165, 0.11139])
    """
    unit = checked_system(system).per_unit_mass
    _check_elastic(unit)
    coefficients = _thermal(unit) if unit.of(ThermalNoise) else _white(unit)
    stationary: SystemMoments | str
    law = None
    if isinstance(coefficients, str):
        stationary = coefficients
    elif not unit.potential.holds():
        stationary = "There is no stationary state: no spring or wall holds the mass on one side."
    else:
        law = _law(unit.potential, *coefficients)
        stationary = _moments(system, law)
    return ExactLaw(
        method="exact",
        system=system,
        stationary=stationary,
        assumptions=("None: this is the stationary solution of the equation of motion as it stands.",),
        warnings=(),
        _law=law,
    )


_REACH = (
    "The exact law covers springs, elastic walls and contacts without dissipation, with dashpots and white noise, or "
    "with ThermalNoise"
)


def _check_elastic(unit: System) -> None:
    for name, part in unit.named():
        if isinstance(part, Barrier) and part.restitution < 1.0:
            raise NotCovered(f"{_REACH}, not {name} of restitution {part.restitution:g}.")
        if isinstance(part, Contact) and part.dissipation > 0.0:
            raise NotCovered(f"{_REACH}, not the dissipation of {name}.")


def _thermal(unit: System) -> tuple[float, float]:
    """1 / kT, and 0: Boltzmann's law."""
    allowed = (*_KEPT, Dashpot, PolynomialDashpot, Springpot, Series, Maxwell, Circuit, ThermalNoise, WhiteNoise)
    _refuse_others(unit, allowed)
    temperature = unit.of(ThermalNoise)[0].temperature
    intensity = sum(noise.intensity for noise in unit.of(WhiteNoise))
    memory = [name for name, part in unit.named() if isinstance(part, Springpot | Series | Maxwell | Circuit)]
    if intensity > 0.0 and memory:
        raise NotCovered(f"{_REACH}, not white noise beside it with {memory[0]}.")
    damping = _dashpots(unit)
    if not damping and not memory:
        raise NotCovered("ThermalNoise needs something that dissipates: a dashpot, a springpot, an arm or a circuit.")
    heated = temperature + (intensity / (2.0 * damping) if intensity > 0.0 else 0.0)
    return 1.0 / heated, 0.0


def _white(unit: System) -> tuple[float, float] | str:
    """The coefficients of g: of a dashpot, or of damping that depends on the energy."""
    _refuse_others(unit, (*_KEPT, Dashpot, PolynomialDashpot, VanDerPol, Springpot, WhiteNoise))
    intensity = sum(noise.intensity for noise in unit.of(WhiteNoise))
    if not intensity > 0.0:
        return "There is no random stationary state: nothing excites the motion."
    pumps = unit.of(VanDerPol)
    feed = sum(pump.coefficient * pump.length**2 for pump in pumps)
    mu = sum(pump.coefficient for pump in pumps)
    linear, square = 2.0 / intensity * (_dashpots(unit) - feed), 0.0
    if pumps:
        _check_rayleigh(unit, mu)
        square = 2.0 / intensity * mu / unit.stiffness
    if not (linear > 0.0 or square > 0.0):
        return "There is no stationary state: nothing dissipates energy, so it grows without end."
    return linear, square


def _check_rayleigh(unit: System, mu: float) -> None:
    """Van der Pol's damping is a function of the energy with the cubic damper that completes it."""
    potential, cubic = unit.potential, _cubic(unit)
    if len(potential.coefficients) != 2 or potential.contacts:
        raise NotCovered(f"{_REACH}; with a VanDerPol it needs a linear spring and no other.")
    wanted = mu / unit.stiffness
    if not math.isclose(cubic, wanted, rel_tol=1e-9):
        raise NotCovered(
            f"{_REACH}; with a VanDerPol it needs a PolynomialDashpot with c3 = mu / Omega^2, here {wanted:.6g} per "
            f"unit mass and not {cubic:.6g}."
        )


def _cubic(unit: System) -> float:
    return sum(part.coefficients[2] for part in unit.of(PolynomialDashpot) if len(part.coefficients) > 2)


def _dashpots(unit: System) -> float:
    """Coefficient of the linear dampers, springpots of order 1 among them."""
    found = sum(part.coefficient for part in unit.of(Dashpot))
    found += sum(part.coefficients[0] for part in unit.of(PolynomialDashpot))
    return found + sum(part.coefficient for part in unit.of(Springpot) if part.order == 1.0)


def _refuse_others(unit: System, allowed: tuple[type, ...]) -> None:
    thermal = bool(unit.of(ThermalNoise))
    for name, part in unit.named():
        if not isinstance(part, allowed):
            raise NotCovered(f"{_REACH}, not {name}.")
        if isinstance(part, PolynomialDashpot):
            higher = part.coefficients[1:]
            if any(higher) and (thermal or not unit.of(VanDerPol) or higher[0] != 0.0):
                raise NotCovered(f"{_REACH}, not the nonlinear {name}.")
        if isinstance(part, Springpot) and 0.0 < part.order < 1.0 and part.coefficient > 0.0 and not thermal:
            raise NotCovered(f"{_REACH}, not {name} of order {part.order:g} without ThermalNoise.")


def _law(potential: Potential, linear: float, square: float) -> _EnergyLaw:
    """The law on a grid of places that covers all that double precision can tell from 0."""
    turning = _turning_points(potential)
    least = min(float(potential.energy(place)) for place in turning)
    highest = least + float(_highest(linear, square, np.zeros(1))[0])
    reached = [place for place in turning if float(potential.energy(place)) <= highest]
    ends = _edge(potential, min(reached), -1.0, highest), _edge(potential, max(reached), 1.0, highest)
    cuts = [np.linspace(*ends, _PANELS + 1), np.array(reached)]
    for place in reached:  # a well may be narrow beside the whole range
        curvature = float(potential.curvature(place))
        if curvature > 0.0:
            cuts.append(place + math.sqrt(1.0 / (abs(linear) * curvature)) * _WIDTHS if linear else _WIDTHS[:0])
    edges = np.unique(np.concatenate(cuts))
    edges = edges[(edges >= ends[0]) & (edges <= ends[1])]
    grids = [_gauss(low, high) for low, high in itertools.pairwise(edges)]
    places, weights = (np.concatenate(each) for each in zip(*grids, strict=True))
    least = min(least, float(potential.energy(places).min()))
    empty = _EnergyLaw(potential, linear, square, places, weights, least, 1.0)
    total = 2.0 * float(weights @ empty.speed_integral(0, potential.energy(places) - least))
    return _EnergyLaw(potential, linear, square, places, weights, least, total)


def _moments(system: System, law: _EnergyLaw) -> SystemMoments:
    x, weights = law.places, law.weights
    u = law.potential.energy(x) - law.least
    at = 2.0 * weights * law.speed_integral(0, u) / law.total
    x_mean, x_square = float(at @ x), float(at @ (x * x))
    v_square = float(2.0 * weights @ law.speed_integral(2, u)) / law.total
    rates, speeds, squares = [], [], []
    for wall in walls_of(system):
        there = np.atleast_1d(law.potential.energy(wall.position) - law.least)
        flux, first, second = (float(law.speed_integral(power, there)[0]) for power in (1, 2, 3))
        rates.append(flux / law.total)
        speeds.append(first / flux if flux > 0.0 else math.nan)
        squares.append(second / flux if flux > 0.0 else math.nan)
    struck = [(r, s, q) for r, s, q in zip(rates, speeds, squares, strict=True) if r > 0.0]
    rate = math.fsum(r for r, _, _ in struck)
    omega = system.natural_frequency
    return SystemMoments(
        amplitude_mean_square=x_square + v_square / omega**2,
        x_mean=x_mean,
        x_mean_square=x_square,
        v_mean_square=v_square,
        impact_rate=rate,
        impact_speed_mean=sum(r * s for r, s, _ in struck) / rate if rate > 0.0 else math.nan,
        impact_speed_mean_square=sum(r * q for r, _, q in struck) / rate if rate > 0.0 else math.nan,
        barrier_impact_rate=tuple(rates),
        barrier_impact_speed_mean=tuple(speeds),
    )


def _turning_points(potential: Potential) -> list[float]:
    """Between the walls: the walls, where contacts begin, 0, and where the force of the springs vanishes."""
    places = [0.0, potential.low, potential.high, *(contact.position for contact in potential.contacts)]
    if len(potential.coefficients) > 1:
        roots = np.polynomial.polynomial.polyroots(potential.coefficients)
        places += [float(root.real) for root in roots if abs(root.imag) < 1e-9 * (1.0 + abs(root))]
    return [place for place in places if math.isfinite(place) and potential.low <= place <= potential.high]


def _edge(potential: Potential, start: float, sign: float, energy: float) -> float:
    """Where the potential passes an energy beyond which nothing is left, or the wall before that.

    From the outermost turning point below this energy it rises to it, and stays above.
    """
    wall = potential.low if sign < 0.0 else potential.high
    step = 1e-12 * max(abs(start), 1e-30)
    while abs(step) < abs(wall - start) and float(potential.energy(start + sign * step)) <= energy:
        step *= 2.0
    low, high = 0.5 * step, step
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(potential.energy(start + sign * middle)) <= energy else (low, middle)
    edge = start + sign * high
    return max(edge, wall) if sign < 0.0 else min(edge, wall)


def _least_exponent(linear: float, square: float) -> float:
    """The least of a H + b H^2 over H >= 0."""
    return -linear * linear / (4.0 * square) if linear < 0.0 and square > 0.0 else 0.0


def _highest(linear: float, square: float, above: FloatArray) -> FloatArray:
    """Kinetic energy at which g has risen by all that double precision can tell, at potentials above the least."""
    goal = _FAR + _least_exponent(linear, square)
    if square == 0.0:
        return np.maximum(goal / linear - above, 1e-300)
    top = (-linear + math.sqrt(linear * linear + 4.0 * square * goal)) / (2.0 * square)
    return np.maximum(top - above, 1e-300)


def _gauss(low: float, high: float) -> tuple[FloatArray, FloatArray]:
    nodes, weights = _UNIT
    if (low, high) == (0.0, 1.0):
        return _FINE
    return low + (high - low) * nodes, (high - low) * weights


def _unit_nodes(panels: int) -> tuple[FloatArray, FloatArray]:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    starts = np.arange(panels)[:, None]
    return ((starts + nodes) / panels).ravel(), np.tile(weights / panels, panels)


_UNIT = _unit_nodes(1)
_FINE = _unit_nodes(24)
