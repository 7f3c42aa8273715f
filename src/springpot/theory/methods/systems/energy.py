"""The exact stationary law of systems whose density depends on the energy alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Constant,
    PolynomialDashpot,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.potential import Potential
from springpot.problem.system import System
from springpot.theory.coverage import DAMPERS, MEMORY, SPRINGS, STOPS, Coverage
from springpot.theory.numerics.equations import roots_of
from springpot.theory.numerics.panels import on_panels, panel_rule
from springpot.theory.problem import Units
from springpot.theory.result import Moments, NoConvergenceError, moments_of

_FAR = 750.0  # exponent at which a density is 0 in double precision
_PANELS = 96
_NODES = 24
_FINE = panel_rule(np.linspace(0.0, 1.0, 25), _NODES)
_WIDTHS = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 40.0])
_ROUNDS = 60  # of halving the panels that are not fine enough
_SETTLED = 1e-13
_WORTH_A_WARNING = 1e-8
_TOO_MUCH = 1e-2
_REACH = (
    "The exact law covers springs, elastic walls and contacts without dissipation, with dashpots and white noise, or "
    "with ThermalNoise"
)
_KEPT = SPRINGS | Constant | STOPS  # parts that only shape the potential
_THERMAL = Coverage(_REACH, _KEPT | DAMPERS | MEMORY | ThermalNoise | WhiteNoise, linear=PolynomialDashpot)
_WHITE = Coverage(_REACH, _KEPT | DAMPERS | VanDerPol | Springpot | WhiteNoise)


@dataclass(frozen=True)
class EnergyLaw:
    """The density exp(-g(H)) / Z with g = a H + b H^2, H = v^2 / 2 + U(x) less the least U between the walls.

    Potential and places are those seen from the origin, a place of least U: far from x = 0 the terms of U cancel.
    """

    potential: Potential
    linear: float
    square: float
    origin: float
    least: float
    places: Floats = field(repr=False)
    weights: Floats = field(repr=False)
    total: float
    walls: Floats = field(default_factory=lambda: np.zeros(0), repr=False)

    @property
    def _likeliest(self) -> float:
        """The energy at which g is least."""
        return -self.linear / (2.0 * self.square) if self.linear < 0.0 else 0.0

    def exponent(self, energy: Floats) -> Floats:
        """g less its least value."""
        if self.linear < 0.0:
            return np.asarray(self.square * (energy - self._likeliest) ** 2)
        return np.asarray(energy * (self.linear + self.square * energy))

    def speed_integral(self, power: int, potential: Floats) -> Floats:
        """The integral of v^power exp(-g) over v > 0, at potentials above the least."""
        u = np.atleast_1d(potential)
        if self.square == 0.0:
            theta = 1.0 / self.linear
            half = 0.5 * (power + 1)
            size = 0.5 * math.gamma(half) * (2.0 * theta) ** half
            return np.asarray(size * np.exp(-np.minimum(self.linear * u, _FAR)))
        nodes, weights = _FINE
        spread = math.sqrt(_FAR / self.square)
        lowest = np.maximum(self._likeliest - spread - u, 0.0) if self.linear < 0.0 else np.zeros_like(u)
        start = np.sqrt(2.0 * lowest)[:, None]
        length = np.sqrt(2.0 * np.maximum(_highest(self.linear, self.square) - u, 0.0))[:, None] - start
        v = start + length * nodes
        values = v**power * np.exp(-np.minimum(self.exponent(0.5 * v * v + u[:, None]), _FAR))
        return np.asarray((values @ weights) * length[:, 0])

    def above_least(self, place: float | Floats) -> Floats:
        """U less the least U, at places seen from the origin."""
        above = np.asarray(self.potential.energy(place) - self.least)
        return np.maximum(above, -20.0 / self.linear) if self.square == 0.0 else np.maximum(above, 0.0)

    @property
    def units(self) -> Units:
        """m and m/s."""
        return Units(1.0, 1.0, 1.0, 1.0)

    def x(self, x: Floats) -> Floats:
        """Density of the displacement."""
        place, inside = self._place(x)
        found = 2.0 * self.speed_integral(0, self.above_least(place).ravel()).reshape(x.shape)
        return np.where(inside, found / self.total, 0.0)

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of both."""
        place, inside = self._place(x)
        return np.where(inside, self._at(self.above_least(place), v) / self.total, 0.0)

    def v(self, v: Floats) -> Floats:
        """Density of the velocity."""
        values = self._at(self.above_least(self.places), v.reshape(-1, 1)) @ self.weights
        return np.asarray(values.reshape(v.shape) / self.total)

    def amplitude(self, amplitude: Floats) -> Floats:
        """Of the paper's problem alone."""
        raise NotCoveredError("The exact densities of amplitude and energy are those of the paper's problem.")

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed just before an impact, on all walls together."""
        values = self._at(self.walls, speed.reshape(-1, 1)).sum(axis=1) / self.speed_integral(1, self.walls).sum()
        return np.asarray(np.maximum(speed, 0.0) * values.reshape(speed.shape))

    def _at(self, potential: Floats, v: Floats) -> Floats:
        """exp(-g) at potentials above the least, and velocities."""
        energy = potential + 0.5 * np.minimum(np.abs(v), 1e150) ** 2
        return np.asarray(np.exp(-np.minimum(self.exponent(np.minimum(energy, 1e150)), _FAR)))

    def _place(self, x: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Where x is seen from the origin, and whether it is between the walls; elsewhere some place that is."""
        place = x - self.origin
        inside = (place >= self.potential.low) & (place <= self.potential.high) & (np.abs(x) < 1e100)
        return np.where(inside, place, 0.0), inside


def exact_law(system: System) -> tuple[Moments | str, EnergyLaw | None, tuple[str, ...]]:
    """The moments of one mass, or why there are none; its law, and what rounding leaves of it."""
    unit, coefficients = system.per_unit_mass, check_law_covered(system)
    if isinstance(coefficients, str):
        return coefficients, None, ()
    if not unit.potential.holds():
        return "There is no stationary state: no spring or wall holds the mass on one side.", None, ()
    law = _law(unit.potential, *coefficients)
    places = [wall.position - law.origin for wall in system.stops.values()]
    law = replace(law, walls=np.array([float(law.above_least(place)) for place in places]))
    return _moments(system, law), law, _rounding_warnings(law)


def check_law_covered(system: System) -> tuple[float, float] | str:
    """The coefficients of g, or why there is no stationary state; `NotCoveredError` for what is not covered."""
    unit = system.per_unit_mass
    _WHITE.check_elastic(unit)
    intensity = sum(noise.white_intensity for noise in unit.excitations.values())
    return _thermal(unit, unit.temperature, intensity) if unit.thermal else _white(unit, intensity)


def _thermal(unit: System, temperature: float, intensity: float) -> tuple[float, float]:
    """1 / kT, and 0: Boltzmann's law."""
    _THERMAL.check(unit)
    memory = [name for name, part in unit.named() if part.remembers]
    if intensity > 0.0 and memory:
        raise NotCoveredError(f"{_REACH}, not white noise beside it with {memory[0]}.")
    damping = unit.dashpots
    if not damping and not memory:
        raise NotCoveredError(
            "ThermalNoise needs something that dissipates: a dashpot, a springpot, an arm or a circuit."
        )
    heated = temperature + (intensity / (2.0 * damping) if intensity > 0.0 else 0.0)
    return 1.0 / heated, 0.0


def _white(unit: System, intensity: float) -> tuple[float, float] | str:
    """The coefficients of g: of a dashpot, or of a VanDerPol with a cubic damper, which depends on the energy."""
    _WHITE.check(unit)
    pumps, dampers = unit.of(VanDerPol), [(*part.damping_coefficients(), 0.0, 0.0, 0.0)[:3] for part in unit.parts]
    for (name, part), (_, square_one, cubic) in zip(unit.named(), dampers, strict=True):
        if square_one != 0.0 or (cubic != 0.0 and not pumps):
            raise NotCoveredError(f"{_REACH}, not the nonlinear {name}.")
        if part.remembers:
            raise NotCoveredError(f"{_REACH}, not {name} of order {part.order:g} without ThermalNoise.")
    if not intensity > 0.0:
        return "There is no random stationary state: nothing excites the motion."
    feed = sum(pump.coefficient * pump.length**2 for pump in pumps)
    mu = sum(pump.coefficient for pump in pumps)
    linear, square = 2.0 / intensity * (unit.dashpots - feed), 0.0
    if pumps:
        _check_rayleigh(unit.potential, mu, sum(cubic for *_, cubic in dampers))
        square = 2.0 / intensity * mu / unit.potential.coefficients[1]
    if not (linear > 0.0 or square > 0.0):
        return "There is no stationary state: nothing dissipates energy, so it grows without end."
    return linear, square


def _check_rayleigh(potential: Potential, mu: float, cubic: float) -> None:
    """Van der Pol's damping is a function of the energy with the cubic damper that completes it."""
    linear_spring = len(potential.coefficients) == 2 and potential.coefficients[1] > 0.0
    if not linear_spring or potential.coefficients[0] != 0.0 or potential.contacts:
        raise NotCoveredError(
            f"{_REACH}; with a VanDerPol it needs a linear spring, and no other spring or constant force."
        )
    wanted = mu / potential.coefficients[1]
    if not math.isclose(cubic, wanted, rel_tol=1e-9):
        raise NotCoveredError(
            f"{_REACH}; with a VanDerPol it needs a PolynomialDashpot with c3 = mu / Omega^2, here {wanted:.6g} per "
            f"unit mass and not {cubic:.6g}."
        )


def _law(potential: Potential, linear: float, square: float) -> EnergyLaw:
    """The law on a grid of places that covers all that double precision can tell from 0."""
    origin = 0.0
    for _ in range(4):  # places of other wells are known better from nearby
        near = potential.seen_from(origin)
        turning = _turning_points(near)
        lowest = min(turning, key=lambda place: float(near.energy(place)))
        if lowest == 0.0 or origin + lowest == origin:
            break
        origin = min(max(origin + lowest, potential.low), potential.high)
    near = potential.seen_from(origin)
    turning = _turning_points(near)
    least = min(float(near.energy(place)) for place in turning)
    if square > 0.0:  # g is of H itself, with U = 0 at x = 0
        linear += 2.0 * square * float(potential.energy(origin))
    empty = EnergyLaw(near, linear, square, origin, least, np.zeros(1), np.zeros(1), 1.0)
    highest = least + _highest(linear, square)
    reached = [place for place in turning if float(near.energy(place)) <= highest]
    ends = near.edge(min(reached), -1.0, highest), near.edge(max(reached), 1.0, highest)
    scale = 1.0 / max(abs(linear), math.sqrt(square))
    cuts = [np.linspace(*ends, _PANELS + 1), np.array(reached)]
    for place in reached:  # a well, or a layer at a wall, may be narrow beside the whole range
        for sign in (-1.0, 1.0):
            width = abs(near.edge(place, sign, float(near.energy(place)) + scale) - place)
            cuts.append(place + sign * width * _WIDTHS)
    edges = np.unique(np.concatenate(cuts))
    edges = edges[(edges >= ends[0]) & (edges <= ends[1])]
    if near.contacts:  # the least may lie in one of them
        sampled = near.energy(on_panels(edges[:-1], edges[1:], _NODES)[0])
        empty = replace(empty, least=min(least, float(sampled.min())))
    places, weights = _settled_grid(empty, edges[:-1], edges[1:])
    total = 2.0 * float(weights @ empty.speed_integral(0, empty.above_least(places)))
    return replace(empty, places=places, weights=weights, total=total)


def _settled_grid(law: EnergyLaw, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Places and weights of panels, halved until the integrals of the density and of its kinetic energy stay.

    Panels whose integrals change by no more than the rounding of the energies does are not halved.
    """

    def integrals(places: Floats, weights: Floats) -> Floats:
        u = law.above_least(places)
        density, kinetic = (law.speed_integral(p, u.ravel()).reshape(u.shape) for p in (0, 2))
        each = density, kinetic, density * _rounding(law, places)
        return np.stack([np.sum(weights * values, axis=1) for values in each])

    places, weights = on_panels(low, high, _NODES)
    found = integrals(places, weights)
    grids: list[tuple[Floats, Floats, Floats]] = []
    for _ in range(_ROUNDS):
        total = found.sum(axis=1, keepdims=True) + sum(done for _, _, done in grids)
        middle = 0.5 * (low + high)
        halves = np.stack([low, middle], 1).ravel(), np.stack([middle, high], 1).ravel()
        half_places, half_weights = on_panels(*halves, _NODES)
        finer = integrals(half_places, half_weights)
        error = np.abs(finer.reshape(3, -1, 2).sum(axis=2) - found)[:2]
        least = np.fmax(_SETTLED, 4.0 * found[2] / total[0]) * total[:2]
        open_ = np.any(error > least, axis=0) & (middle > low) & (middle < high)
        grids.append((places[~open_].ravel(), weights[~open_].ravel(), found[:, ~open_].sum(axis=1, keepdims=True)))
        if not np.any(open_):
            break
        both = np.repeat(open_, 2)
        low, high = halves[0][both], halves[1][both]
        places, weights, found = half_places[both], half_weights[both], finer[:, both]
    else:
        raise NoConvergenceError(
            "the exact law's integrals did not settle: the density is too narrow beside its range."
        )
    return np.concatenate([grid[0] for grid in grids]), np.concatenate([grid[1] for grid in grids])


def _rounding(law: EnergyLaw, places: Floats) -> Floats:
    """Relative error of the density by rounding of the energies."""
    if law.square:
        return np.zeros_like(places)
    return np.asarray(1e-16 * abs(law.linear) * law.potential.size(places))


def _rounding_warnings(law: EnergyLaw) -> tuple[str, ...]:
    """What rounding of the energies leaves of the answer, if that is worth a warning."""
    density = law.weights * law.speed_integral(0, law.above_least(law.places))
    left = float(density @ _rounding(law, law.places)) / float(density.sum())
    if not left < _TOO_MUCH:
        raise NoConvergenceError(
            "the exact law needs energies of the springs that double precision can tell apart: they are more than 1e14 "
            "times that of the noise."
        )
    if left < _WORTH_A_WARNING:
        return ()
    return (
        f"The springs' energies are so large beside that of the noise that rounding changes the density by {left:.0e}.",
    )


def _moments(system: System, law: EnergyLaw) -> Moments:
    weights, u = law.weights, law.above_least(law.places)
    at = 2.0 * weights * law.speed_integral(0, u) / law.total
    shift, square = float(at @ law.places), float(at @ (law.places * law.places))
    x_mean, x_square = law.origin + shift, law.origin * (law.origin + 2.0 * shift) + square
    v_square = float(2.0 * weights @ law.speed_integral(2, u)) / law.total
    hits: list[tuple[float, ...]] = []
    for there, name in zip(law.walls, system.stops, strict=True):
        flux, first, second = (float(law.speed_integral(power, there)[0]) for power in (1, 2, 3))
        speeds = (first / flux, second / flux) if flux > 0.0 else (math.nan, math.nan)
        force = []
        if contact := system.contacts.get(name):
            depth = np.maximum(contact.inwards * (contact.position - law.origin - law.places), 0.0)
            force = [float(at @ (contact.stiffness * depth**contact.exponent))]
        hits.append((flux / law.total, *speeds, *force))
    return moments_of(system, [(x_mean, x_square, v_square)], hits=hits)


def _turning_points(potential: Potential) -> list[float]:
    """Between the walls: the walls, 0, where contacts begin or hold the mass, and where the springs' force vanishes."""
    from scipy import optimize  # slow to import, and most runs need none of it

    places = [0.0, potential.low, potential.high]
    for contact in potential.contacts:
        start, sign = contact.position, -1.0 if contact.free_side == "above" else 1.0
        end = potential.edge(start, sign, float(potential.energy(start)))
        deepest = optimize.minimize_scalar(
            lambda place: float(potential.energy(place)), bounds=(min(start, end), max(start, end)), method="bounded",
            options={"xatol": 1e-9 * abs(end - start)},
        )  # fmt: skip
        places += [start, float(deepest.x)]
    if len(potential.coefficients) > 1:
        roots = roots_of(potential.coefficients)
        places += [float(root.real) for root in roots if abs(root.imag) < 1e-9 * (1.0 + abs(root))]
    return [place for place in places if math.isfinite(place) and potential.low <= place <= potential.high]


def _highest(linear: float, square: float) -> float:
    """Energy above the least at which g has risen by all that double precision can tell."""
    if square == 0.0:
        return _FAR / linear
    if linear < 0.0:
        return -linear / (2.0 * square) + math.sqrt(_FAR / square)
    return 2.0 * _FAR / (linear + math.sqrt(linear * linear + 4.0 * square * _FAR))
