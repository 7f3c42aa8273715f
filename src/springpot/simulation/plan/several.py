"""What is known of a motion of several masses before it is simulated.

The modes of the linear springs, with the stiffness of what has memory at each mode's own frequency, give the rates and
times; nonlinear springs count with their mean stiffness at the size of the motion, which is guessed from a balance of
energy in each mode.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, meant, shown
from springpot.problem.catalogue import owner_of
from springpot.problem.coordinates import product_of
from springpot.problem.parts import (
    Barrier,
    Contact,
    Dashpot,
    Force,
    FractionalMaxwell,
    Friction,
    Harmonic,
    ParametricNoise,
    PoissonImpulses,
    PolynomialDashpot,
    SpectralExcitation,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.parts.hysteresis import Yielding
from springpot.problem.parts.walls import Stop, restitution_at, slow_restitution
from springpot.problem.system import System
from springpot.simulation.plan.boltzmann import BoltzmannOfSeveral, boltzmann_of_several
from springpot.simulation.plan.creep_of_several import CreepOfSeveral
from springpot.simulation.plan.loose import Loose, loose_masses
from springpot.simulation.plan.motion import KeptMean, Motion, StruckWalls, countable_restitution
from springpot.simulation.plan.options import Scheme, SchemeOfRun
from springpot.simulation.plan.parts import (
    beat,
    fed_at,
    rate_of_its_own,
    slow_dashpot,
    slow_springpot,
    stiffness_at_once,
    taken_by_yielding,
    time_of_its_own,
)
from springpot.simulation.plan.pressed import Pressed
from springpot.simulation.plan.scales import Scales, creep_time
from springpot.simulation.plan.schemes import Straight
from springpot.simulation.plan.seen import Seen, levels_of_several, seen_of_several
from springpot.simulation.plan.unsprung import holding_alone
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.normal_modes import free_motion
from springpot.theory.walls import Before

_ROUNDS, _ROUNDS_OF_SIZE = 60, 20  # of frequencies that depend on themselves, and of the size of the motion
_FAR = 3.0  # standard deviations at which a spring is taken for its fastest motion
_HOPPED = 0.2  # step over v_rms / a of hops on a wall
_RIGID = 1e-9  # of the largest frequency: a motion that stretches no spring
_UNDAMPED = 1e-12  # of the frequency
_GUESSED = 1.5  # factor on the forgetting time
_TAKEN, _LEAST_BIAS = (
    0.025,
    1e-3,
)  # bias of <v^2> over what dampers take of a kick in its step; and what is worth saying


@dataclass(frozen=True, eq=False)
class Modes:
    """Free motions of the masses.

    Attributes
    ----------
    frequency : ndarray, shape (modes,)
        In rad/s, rising; 0 of a motion that stretches no spring.
    rate : ndarray, shape (modes,)
        At which each loses its energy, in 1/s.
    shapes : ndarray, shape (coordinates, modes)
        Columns of unit modal mass.
    temperature : ndarray, shape (modes,)
        Mean modal energy by a balance of what excitation feeds in and dampers take out, in J; of a mode that nothing
        damps, or that nothing moves, that of all together.
    excited : bool
        Whether anything feeds energy in.
    stiffness, damping : dict
        Mean numbers of each part with two ends, by its name, without what memory adds.
    """

    frequency: Floats
    rate: Floats
    shapes: Floats
    temperature: Floats
    excited: bool
    stiffness: Mapping[str, float]
    damping: Mapping[str, float]

    @property
    def held(self) -> tuple[Floats, Floats]:
        """Displacements and velocities of the modes that stretch springs, per normal; shape (coordinates, modes)."""
        held = self.frequency > _RIGID * max(float(self.frequency.max()), 1e-300)
        speeds = self.shapes[:, held] * np.sqrt(self.temperature[held])
        return speeds / self.frequency[held], speeds

    def speed(self, row: Floats) -> float:
        """Standard deviation of an elongation's velocity, about."""
        return math.sqrt(float(((row @ self.shapes) ** 2 * self.temperature).sum()))

    def spread(self, row: Floats) -> float:
        """Standard deviation of an elongation, about; modes that stretch no spring do not count."""
        held = self.frequency > _RIGID * max(float(self.frequency.max()), 1e-300)
        squares = (row @ self.shapes[:, held]) ** 2 * self.temperature[held] / self.frequency[held] ** 2
        return math.sqrt(float(squares.sum()))


def modes_of(system: System) -> Modes:
    """The modes of a system at the guessed size of its motion.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, WhiteNoise
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(1.0, between=("ground", "a")), Spring(1.0, between=("a", "b")),
    ...     WhiteNoise(1.0, on="b"), Dashpot(0.1, between=("ground", "a")),
    ... )
    >>> modes_of(pair).frequency.round(6).tolist()
    [0.618034, 1.618034]
    """
    found = _modes(system, _linear(system))
    if any(map(_has_size, system.elements.values())):
        for _ in range(_ROUNDS_OF_SIZE):
            found = _modes(system, _means(system, found))
    return found


def _linear(system: System) -> dict[str, tuple[float, float]]:
    """Stiffness and damping of the linear part of each force."""
    return {name: (part.static_stiffness, part.linear_damping) for name, part in system.elements.items()}


def _has_size(part: Any) -> bool:
    """Whether its stiffness or damping depends on the size of the motion."""
    return part.is_bent or _is_rough(part)


def _stiffness_at(part: Any, spread: float) -> float:
    """E[k1 + 2 k2 u + 3 k3 u^2 + ...] for a normal u of mean 0."""
    whole, moment = 0.0, 1.0
    for n, k in enumerate(part.force_coefficients()):
        if n % 2 == 1:
            whole += n * k * moment
            moment *= n * spread**2
    return whole


def _is_rough(part: Any) -> bool:
    if isinstance(part, PolynomialDashpot):
        return not part.is_linear
    return isinstance(part, Friction | VanDerPol | Yielding)


def _damping_at(part: Any, spread: float, speed: float, reduced: float = 1.0) -> float:
    """Power over the mean square velocity, for a normal one, of what a damper does beside its linear part.

    Of a part that yields with the mass that moves along its row.
    """
    match part:
        case Friction():
            return math.sqrt(2.0 / math.pi) * part.force / max(speed, 1e-300)
        case VanDerPol():
            return float(part.coefficient * (spread**2 - part.length**2))
        case PolynomialDashpot():
            _, c2, c3 = (*part.coefficients, 0.0, 0.0)[:3]
            return math.sqrt(8.0 / math.pi) * c2 * speed + 3.0 * c3 * speed**2
        case Yielding() if speed > 0.0:
            return reduced * taken_by_yielding(part.per_mass(reduced), speed**2, 0.0) / speed**2
    return 0.0


def _means(system: System, modes: Modes) -> dict[str, tuple[float, float]]:
    """Mean stiffness and damping of each part with two ends at the size of a motion."""
    found = {}
    for name, part in system.elements.items():
        stiffness, damping = part.static_stiffness, part.linear_damping
        if _has_size(part):
            row = system.coordinates.elongations[name]
            spread, speed = modes.spread(row), modes.speed(row)
            stiffness = _stiffness_at(part, spread)
            damping += _damping_at(part, spread, speed, system.coordinates.reduced(row))
        found[name] = stiffness, damping
    return found


def _modes(system: System, means: Mapping[str, tuple[float, float]]) -> Modes:
    """The modes with these stiffnesses and dampings of parts, and what memory adds."""
    at, parts = system.coordinates, system.elements
    stiffness, damping = ({name: each[i] for name, each in means.items()} for i in (0, 1))

    def modulus(name: str, p: complex) -> complex:
        (k, c), part = means[name], parts[name]
        return complex(part.modulus(p)) + (k - part.static_stiffness) + (c - part.linear_damping) * p

    squares, moved = free_motion(at.mass, at.sum_of(stiffness))
    frequency, rate = np.sqrt(np.maximum(squares, 0.0)), np.zeros(len(squares))
    remembers = any(part.remembers for part in parts.values())
    for i in range(len(rate)):
        w = frequency[i]
        if remembers:
            w = w or _alone(system)
            for _ in range(_ROUNDS):
                squares, shapes = free_motion(at.mass, at.sum_of({name: modulus(name, 1j * w).real for name in parts}))
                new = math.sqrt(max(float(squares[i]), 0.0))
                if abs(new - w) <= 1e-10 * w or new == 0.0:
                    break
                w = 0.5 * (w + new)
            frequency[i], moved[:, i] = w if new > 0.0 else 0.0, shapes[:, i]
        p = 1j * max(frequency[i], 1e-9 * max(frequency.max(), 1e-300))
        losses = at.sum_of({name: modulus(name, p).imag / p.imag for name in parts})
        rate[i] = moved[:, i] @ losses @ moved[:, i]
    temperature, excited = _temperatures(system, frequency, rate, moved)
    return Modes(frequency, rate, moved, temperature, excited, stiffness, damping)


def _alone(system: System) -> float:
    """A frequency with springpots alone."""
    at = system.coordinates
    rates = [
        (pot.coefficient / at.reduced(at.row(pot.between))) ** (1.0 / (2.0 - pot.order)) for pot in system.of(Springpot)
    ]
    return max(rates, default=0.0)


def _temperatures(system: System, frequency: Floats, rate: Floats, shapes: Floats) -> tuple[Floats, bool]:
    if thermal := system.of(ThermalNoise):
        return np.full(len(rate), thermal[0].temperature), True
    fed, coordinates, parts = np.zeros(len(rate)), system.coordinates, dict(system.named())
    for name, row in coordinates.forces.items():
        fed += (row @ shapes) ** 2 * [_density(parts[name], w) for w in frequency]
    fed = _with_multiplied(system, frequency, rate, fed, shapes)
    # where nothing dissipates, what is fed in within a radian
    whole = float(fed.sum()) / (float(rate.sum()) if rate.sum() > 0.0 else max(float(frequency.max()), 1e-300))
    damped = rate > _UNDAMPED * frequency
    return np.where(damped & (fed > 0.0), fed / np.where(damped, rate, 1.0), whole), bool(fed.any())


def _with_multiplied(system: System, frequency: Floats, rate: Floats, fed: Floats, shapes: Floats) -> Floats:
    """The power fed into each mode with that of noise which multiplies elongations, and so grows with the motion.

    Where such noise feeds in more than is taken out, nothing of it is counted.
    """
    noises = [(name, part) for name, part in system.named() if isinstance(part, ParametricNoise)]
    if not noises or not rate.all():
        return fed
    seen = np.array([(system.coordinates.elongations[name] @ shapes) ** 2 for name, _ in noises])
    w = np.maximum(frequency, _RIGID * max(float(frequency.max()), 1e-300))
    grows = 0.5 * (seen.T * [part.intensity for _, part in noises]) @ (seen / w**2)  # of power with each temperature
    if not np.abs(np.linalg.eigvals(grows / rate[:, None])).max() < 1.0:
        return fed
    return np.asarray(rate * np.linalg.solve(np.diag(rate) - grows, fed))


def _density(part: Any, w: float) -> float:
    """Power that a force of unit modal mass feeds in at a frequency."""
    if isinstance(part, SpectralExcitation):
        return part.power_into(max(w, 1e-300), 0.0)
    if isinstance(part, Harmonic):  # as if it were spread over its own frequency
        return 0.5 * part.amplitude**2 / part.frequency
    return fed_at(part, max(w, 1e-300))


@dataclass(frozen=True, eq=False)
class MotionOfSeveral(Motion):
    """The motion of several masses; what it has not, its results do not have."""

    intensity, struck = 0.0, StruckWalls()  # each wall has its own

    @cached_property
    def seen(self) -> tuple[Seen, ...]:
        """Each mass, each pair, and the impacts on each wall."""
        return seen_of_several(self.system)

    @cached_property
    def levels(self) -> dict[str, tuple[str, Seen]]:
        """Displacements and velocities of the masses, and elongations of parts and pairs."""
        return levels_of_several(self.system)

    @property
    def displacements_shown(self) -> int:
        """Coordinates and rows."""
        at = self.system.coordinates
        return len(at.names) + len(at.numbers)

    @cached_property
    def arguments(self) -> dict[str, tuple[str, int]]:
        """The same and the time."""
        return {"t": ("t", 0)} | {
            name: (quantity, seen.number or 0)
            for name, (quantity, seen) in self.levels.items()
            if quantity in ("x", "v")
        }

    def start_of(self, seen: Seen, x: Any, v: Any) -> tuple[float, float]:
        """Along the row of the displacement."""
        names = self.system.coordinates.names
        at_rest = self.as_given(self._nearest_to_rest())
        places, speeds = (np.array([given[name] for name in names]) for given in (x or at_rest, v))
        return float(seen.row @ places), float(seen.row @ speeds)

    def intensity_of(self, seen: Seen, time: Any = None) -> Any:
        """Of white noise and of that of dashpots at a temperature, along the row of the displacement."""
        return self._intensity_along(seen.row, time=time)

    @property
    def settles_at_start(self) -> bool:
        """Where memory keeps a mean, or the start is drawn."""
        return self.searched or self.law is not None

    @property
    def mean_names(self) -> tuple[str, ...]:
        """Of each mass."""
        return tuple(f"{name}_x_mean" for name in self.system.coordinates.names)

    @property
    def near_mean(self) -> Floats:
        """Where they rest."""
        return self._nearest_to_rest()

    def within_walls(self, places: Floats) -> Floats:
        """The least change of the places that puts every elongation before its wall."""
        inward, least = _walls(self.system, places)
        if not (least > 0.0).any():
            return places
        forces = _least_forces(inward, least)
        if forces is None:
            walls = [name for name, part in self.touched.items() if isinstance(part, Barrier)]
            raise ValueError(f"the walls must leave room: {listed(walls)} cannot all be kept.")
        return np.asarray(places + inward.T @ forces)

    def as_given(self, places: Floats) -> dict[str, float]:
        """By the names of the masses."""
        return dict(zip(self.system.coordinates.names, places.tolist(), strict=True))

    def stationary_place(self, seen: Seen) -> float:
        """Where it rests."""
        return float(seen.row @ self._nearest_to_rest())

    @property
    def pilot_time(self) -> float:
        """That of the energy and of the slowest mode: E[x] is a fixed point however long a pilot creeps."""
        return max(self.scales.energy_time, 5.0 / self.scales.frequency)

    @cached_property
    def kept_means(self) -> tuple[KeptMean, ...]:
        """Of each springpot along its row."""
        at, found = self.system.coordinates, []
        for part, pot in self.system.named():
            row = at.elongations.get(part)
            if row is not None and isinstance(pot, Springpot) and pot.remembers:
                alike = (
                    n for n, own in self.displacements.items() if np.array_equal(own, row) or np.array_equal(own, -row)
                )
                if name := next(alike, ""):
                    found.append(KeptMean(name, self.displacements[name], pot.order, pot.coefficient / at.reduced(row)))
        return tuple(found)

    def left_of_start(self, off: float, time: float) -> float | None:
        """It hardly fades: some springpots are stronger than the springs beside them."""
        return None

    @cached_property
    def law(self) -> Any:
        """From which the start is drawn, Boltzmann's or that of loose masses; None where it is not."""
        return boltzmann_of_several(self.system) or self.loose

    @cached_property
    def loose(self) -> Loose | None:
        """The masses that only walls hold; None without any."""
        if self.not_stationary:
            return None
        return loose_masses(self.system, *self.modes.held, self.scales.frequency, self._nearest_to_rest())

    @property
    def loose_points(self) -> tuple[str, ...]:
        """The masses that only walls hold, and that may wait long for their impacts."""
        return () if self.loose is None else self.loose.points

    def waiting_time(self, start: str) -> float:
        """In which what a start does to masses that only walls hold falls by a factor of e, in s; 0 without any."""
        return 0.0 if self.loose is None else self.loose.waiting_time(start)

    def drawn_about(self, places: Floats) -> Any:
        """The law from which a start about these places is drawn; None where it is not."""
        return replace(self.law, rest=places) if isinstance(self.law, Loose) else self.law

    @property
    def springpots(self) -> tuple[Springpot, ...]:
        """Those with memory."""
        return tuple(pot for pot in self.system.of(Springpot) if pot.remembers)

    @property
    def usual_quantities(self) -> tuple[str, ...]:
        """All mean square displacements and velocities."""
        return tuple(
            name
            for of in "xv"
            for point in self.system.points
            if (name := f"{point}_{of}_mean_square") not in self.zeros
        )

    @cached_property
    def displacements(self) -> dict[str, Floats]:
        """The rows of all displacements and elongations that are observed, by how the names of their results begin."""
        at = self.system.coordinates
        points = zip(at.points, at.rows, strict=True)
        return {f"{point}_x": row for point, row in points} | {
            f"{pair}_elongation": row for pair, row in at.pairs.items()
        }

    def mean_square_of(self, name: str) -> str:
        """The mean square displacement with which a result changes: its own, or that of the nearest row."""
        if own := owner_of(name, self.displacements):
            return f"{own}_mean_square"
        rows = self.system.coordinates.elongations
        if not (stop := owner_of(name, self.touched)):
            return next(f"{begin}_mean_square" for begin in self.displacements)
        row = rows[stop]
        alike = {begin: abs(float(own @ row)) / float(np.linalg.norm(own)) for begin, own in self.displacements.items()}
        return f"{max(alike, key=alike.__getitem__)}_mean_square"

    @cached_property
    def zeros(self) -> tuple[str, ...]:
        """The means of displacements that no force with a mean can move, and all of those that no force can move."""
        if self.system.of(ThermalNoise):
            return self._means_of_zero
        coordinates, parts = self.system.coordinates, dict(self.system.named())
        moving = [*coordinates.forces.values()]
        moving += [row for name, row in coordinates.elongations.items() if not parts[name].is_linear]
        ties = np.abs(coordinates.mass) + sum(np.outer(*2 * [np.abs(row)]) for row in coordinates.elongations.values())
        reached = np.abs(np.array([np.zeros(len(coordinates.names)), *moving])).sum(0)
        for _ in coordinates.names:
            reached = (ties @ reached > 0.0).astype(float)
        still = [begin for begin, row in self.displacements.items() if not (np.abs(row) @ reached).any()]
        squares = [f"{begin}_mean_square" for begin in still]
        speeds = [f"{begin[:-2]}_v_mean_square" for begin in still if begin.endswith("_x")]
        return (*self._means_of_zero, *squares, *speeds)

    @property
    def _means_of_zero(self) -> tuple[str, ...]:
        return tuple(f"{begin}_mean" for begin, row in self.displacements.items() if not self._has_mean(row))

    @property
    def remembers_a_mean(self) -> bool:
        """Whether a mean elongation stays in a memory that fades like a power of time."""
        rows = self.system.coordinates.elongations
        slow = [*self.springpots, *self.system.of(FractionalMaxwell)]
        return any(self._has_mean(rows[name]) for name, part in self.system.named() if part in slow)

    def _has_mean(self, row: Floats) -> bool:
        """Whether its mean elongation is not 0 by symmetry."""
        moved = self._moved_by_means
        return moved is None or not (np.abs(row @ moved) <= _RIGID * (np.abs(row) @ np.abs(moved))).all()

    @cached_property
    def _moved_by_means(self) -> Floats | None:
        """How each force that may have a mean displaces the coordinates, in columns; None if nothing holds them."""
        coordinates, parts = self.system.coordinates, dict(self.system.named())
        rows = {**coordinates.forces, **coordinates.elongations}
        stops = {_inwards(rows[name], part): rows[name] for name, part in self.touched.items()}
        pushes = [row for (into, *law), row in stops.items() if (tuple(-n for n in into), *law) not in stops]
        pushes += [rows[name] for name, part in parts.items() if not (part.is_odd or name in self.touched)]
        if pushes:  # what is nonlinear may have a mean force where others have
            pushes += [rows[name] for name, part in parts.items() if not part.is_linear]
        stiffness = self.system.stiffness_matrix
        values = np.linalg.eigvalsh(stiffness)
        if pushes and not values[0] > _RIGID * values[-1]:
            return None
        return np.asarray(np.linalg.solve(stiffness, np.array(pushes).T) if pushes else np.zeros((len(values), 1)))

    @property
    def is_thermal(self) -> bool:
        """Whether x and v at time 0 are drawn from Boltzmann's law, so that a run is stationary at once."""
        return isinstance(self.law, BoltzmannOfSeveral)

    @cached_property
    def resolved_rate(self) -> float:
        """Also those at which contacts stop what touches them, and of hops on lossy walls: a longer step is stable,
        but off.
        """
        at = self.system.coordinates
        contacts = [(at.elongations[name], part) for name, part in self.touched.items() if isinstance(part, Contact)]
        stops = (_stop_rate(part, at.reduced(row), _FAR * self.modes.speed(row)) for row, part in contacts)
        return max(self.scales.fastest_rate, *stops, *self._hops(), 0.0)

    def _hops(self) -> Iterator[float]:
        """Rates at which white noise lets pressed masses hop on lossy walls.

        Of a step of 0.2 v_rms / a the mean square of the velocity lacks 1.5 %, of twice that 3 %; beyond, it grows.
        """
        walls = (part for part in self.system.stops.values() if isinstance(part, Barrier))
        for wall, (row, press) in zip(walls, _pressing(self.system, self.modes), strict=False):
            fed, speed = 0.5 * self._intensity_along(row, wall.position), self.modes.speed(row)
            own = Pressed(press, restitution_at(wall, math.sqrt(2.0) * speed))
            if press > 0.0 and fed > 0.0 and own.restitution < 1.0:
                yield Straight.default_step * press / (_HOPPED * own.speed(fed, fed / speed**2))

    @cached_property
    def struck_alone(self) -> dict[str, StruckWalls]:
        """Each rigid wall: the noise along its row, and how the springs press on it at most."""
        rows = self.system.coordinates.elongations
        return {
            name: StruckWalls(
                slow_restitution(part), self._intensity_along(rows[name], part.position),
                max(part.inwards * part.position, 0.0) * self.scales.fastest_rate**2,
            )
            for name, part in self.system.named()
            if isinstance(part, Barrier)
        }  # fmt: skip

    @property
    def pressed(self) -> dict[str, Pressed]:
        """None: flights press nowhere, and `resolved_rate` has the rates of hops."""
        return {}

    @property
    def rested_on(self) -> frozenset[str]:
        """The lossy walls on which masses can come to rest, by name: only smooth forces act along their rows."""
        at, parts = self.system.coordinates, dict(self.system.named())
        if self.system.of(ThermalNoise):
            return frozenset()
        impulses = [force for name, force in at.forces.items() if isinstance(parts[name], PoissonImpulses)]
        return frozenset(
            name
            for name, alone in self.struck_alone.items()
            if not (parts[name].is_elastic or alone.intensity > 0.0)
            and not any(product_of(at.accelerations(at.elongations[name]), force) for force in impulses)
        )

    def struck_in(self, step: float) -> dict[str, StruckWalls]:
        """Each wall has a distribution of its own."""
        parts = dict(self.system.named())
        return {
            f"{name}_impact_speed": replace(
                alone, restitution=countable_restitution(parts[name], alone.intensity, step)
            )
            for name, alone in self.struck_alone.items()
            if alone.intensity > 0.0 and not self.uncounted_because(f"{name}_impact_rate")
        }

    def _walls_in(self, name: str) -> list[tuple[Barrier, float]]:
        """The wall whose result it is."""
        part = self.touched.get(own := owner_of(name, self.touched))
        return [(part, self.struck_alone[own].intensity)] if isinstance(part, Barrier) else []

    def motions_before_walls(self, values: Mapping[str, float]) -> dict[str, Before]:
        """Where a displacement along the row of a wall is observed; it gives as the springs let it where all else is
        free.
        """
        at, rest = self.system.coordinates, self._equilibrium()
        stiffness, shapes = np.linalg.eigh(at.sum_of(self.modes.stiffness))
        held, found = stiffness > _RIGID * stiffness[-1], {}
        for wall, part in self.touched.items():
            row = at.elongations[wall]
            seen = ((name, float(row @ own) / float(own @ own)) for name, own in self.displacements.items()
                    if np.array_equal(row, own) or np.array_equal(row, -own))  # fmt: skip
            name, sign = next(seen, ("", 0.0))
            if f"{name}_mean_square" not in values:
                continue
            mean, square = sign * values.get(f"{name}_mean", 0.0), values[f"{name}_mean_square"]  # or 0 by symmetry
            moved = row @ shapes
            is_held = held.any() and np.abs(moved[~held]).max(initial=0.0) <= _RIGID * np.abs(moved).max()
            give = float((moved[held] ** 2 / stiffness[held]).sum()) if is_held else math.inf
            frequency = 1.0 / math.sqrt(give * at.reduced(row))
            found[wall] = Before(
                name, mean, math.sqrt(max(square - mean**2, 0.0)), self._speed_of(name, row, values), frequency,
                frequency**2 * part.inwards * (part.position - float(row @ rest)),
            )  # fmt: skip
        return found

    def _speed_of(self, name: str, row: Floats, values: Mapping[str, float]) -> float:
        """Of a displacement; of an elongation, whose speed is no result, as if its ends moved independently."""
        ends = zip(self.system.coordinates.names, row, strict=True)
        parts = [(name[:-2], 1.0)] if name.endswith("_x") else [(end, share) for end, share in ends if share]
        return math.hypot(*(share * math.sqrt(values.get(f"{end}_v_mean_square", 0.0)) for end, share in parts))

    def velocity_biases(self, step: float) -> dict[str, float]:
        """Of noise that is not matched to the dampers, which take a share of each kick within its step."""
        at, rows = self.system.coordinates, self.system.coordinates.elongations
        shares = [
            part.coefficient
            * step ** (2.0 - (part.order if isinstance(part, Springpot) else 1.0))
            / at.reduced(rows[name])
            for name, part in self.system.named()
            if isinstance(part, Springpot | Dashpot) and part.dissipates
        ]
        bias = _TAKEN * max(shares, default=0.0)
        if self.system.of(ThermalNoise) or bias < _LEAST_BIAS:
            return {}
        return {f"{point}_v_mean_square": bias for point in at.points}

    @property
    def completed(self) -> dict[str, StruckWalls]:
        """Each lossy wall with a number of restitution."""
        numbers = [
            name for name, part in self.touched.items() if isinstance(part, Barrier) and not callable(part.restitution)
        ]
        return {f"{name}_": self.struck_alone[name] for name in numbers if self.struck_alone[name].crowded}

    def _intensity_along(self, row: Floats, place: float | None = None, time: Any = None) -> Any:
        """Of the acceleration of an elongation, where it is at a place, by white noise and by that of warm dashpots.

        Noise that multiplies another elongation counts with the usual size of that; at times in s, with envelopes.
        """
        coordinates, parts = self.system.coordinates, dict(self.system.named())
        turned, thermal = coordinates.accelerations(row), self.system.of(ThermalNoise)

        def over(part: WhiteNoise | ParametricNoise) -> Any:
            return 1.0 if time is None else part.square_at(time)

        white = sum(
            over(parts[name]) * parts[name].intensity * product_of(turned, force) ** 2
            for name, force in coordinates.forces.items()
            if isinstance(parts[name], WhiteNoise)
        )
        warm = sum(
            2.0 * thermal[0].temperature * parts[name].linear_damping * product_of(turned, own) ** 2
            for name, own in (coordinates.elongations.items() if thermal else ())
        )
        shaken = 0.0
        for name, part in parts.items():
            if isinstance(part, ParametricNoise):
                own = coordinates.elongations[name]
                alike = np.array_equal(own, row) or np.array_equal(own, -row)
                size = place if alike and place is not None else self.modes.spread(own)
                shaken += over(part) * part.intensity * (size * product_of(turned, own)) ** 2
        return white + warm + shaken

    @cached_property
    def modes(self) -> Modes:
        """At the guessed size of the motion."""
        return modes_of(self.system)

    def size_of(self, seen: Seen) -> tuple[float, float, float]:
        """Mean, deviation and deviation of the velocity of a displacement, about."""
        return 0.0, self.modes.spread(seen.row), self.modes.speed(seen.row)

    def modes_near(self, seen: Seen, *, of_speed: bool, by_energy: bool) -> tuple[Floats, Floats, Floats]:
        """Of each mode what displacements, and velocities, bring to a quantity, over its usual size; and the place of
        rest.

        The root of the sum of both squares is what the mode can bring in a cycle.  With ``by_energy`` it
        is the root of the energy of the mode.
        """
        at, modes, rows = self.system.coordinates, self.modes, self.system.coordinates.elongations
        lowest = min(modes.frequency[modes.frequency > _RIGID * modes.frequency.max()], default=1.0)
        w = np.maximum(modes.frequency, lowest)
        if by_energy:
            shares = w
        elif seen.feels:
            felt, parts = [*self.felt.values()][seen.feels[0]], self.system.elements
            of_parts = [share * (rows[n] @ modes.shapes) * [parts[n].modulus(1j * each) for each in w]
                        for n, share in felt.shares.items()]  # fmt: skip
            shares = np.abs(sum(of_parts))
        else:
            shares = np.abs(seen.row @ modes.shapes) * (w if of_speed else 1.0)
        usual = math.sqrt(float((shares**2 * modes.temperature / w**2).sum())) or 1.0
        placed = (shares / usual)[:, None] * modes.shapes.T @ at.mass
        return placed, placed / w[:, None], np.array([*self.placed(None).values()])

    @property
    def uncountable(self) -> str:
        """Why the impacts on some walls cannot be counted."""
        return next(iter(self.uncounted.values()), "")

    @cached_property
    def uncounted(self) -> dict[str, str]:
        """How the names of results begin that are of impacts which cannot be counted, and why."""
        found = {}
        for name, wall in self.struck_alone.items():
            if wall.intensity > 0.0 and wall.restitution <= COLLAPSE_BELOW:
                found[f"{name}_"] = (
                    f"restitution {wall.restitution:g} of {name} is not above {COLLAPSE_BELOW:.3f} "
                    "(= exp(-pi/sqrt 3)): white noise causes infinitely many impacts in a finite time"
                )
            elif not wall.intensity > 0.0 and wall.restitution < 1.0 and self.modes.excited:
                two = "ground" not in self.system.coordinates.ends[name]
                alike = any(noise.on == "ground" for noise in self.system.of(WhiteNoise))
                found[f"{name}_"] = (
                    f"{name} is lossy, and no white noise drives its two ends apart"
                    f"{' (that of the ground moves both masses alike)' if two and alike else ''}: a smooth force lets "
                    "them come to rest on each other after infinitely many impacts"
                )
        return found

    @cached_property
    def not_stationary(self) -> str:
        """Why there is no stationary state; empty if there is one."""
        if self.ends:
            return self.ends
        if not self.modes.excited and not self.system.of(Force):
            return "without excitation the motion dies out"
        if (free := self._unheld()) and self._unheld(holding_alone(self.system)):
            return f"no spring or wall keeps {listed(free)} near the ground"
        walls = self.system.of(Stop)
        lossy = any(part.dissipates for part in self.system.parts if isinstance(part, Stop) or _is_rough(part))
        damped = self.modes.rate > _UNDAMPED * np.maximum(self.modes.frequency, 1e-300)
        if not lossy and not (damped.any() if walls else damped.all()):
            return "nothing dissipates the energy of some motion, so it grows without limit"
        return ""

    @property
    def held_by(self) -> tuple[Springpot, ...]:
        """The springpots that hold some motion without a spring."""
        alone = holding_alone(self.system)
        return tuple(alone.values()) if alone and self._unheld() else ()

    def _unheld(self, also: Collection[str] = ()) -> list[str]:
        """The points of a motion that stretches no spring, and none of some other parts, and that no wall ends."""
        at = self.system.coordinates
        rows = at.elongations
        held = [any(part.force_coefficients()) or part.modulus(0.0) != 0.0 for part in self.system.elements.values()]
        springs = [rows[name] for name, holds in zip(self.system.elements, held, strict=True) if holds or name in also]
        _, sizes, rows_of_all = np.linalg.svd(np.array(springs).reshape(-1, len(at.names)))
        kept = sizes > max(len(springs), len(at.names)) * np.finfo(float).eps * sizes.max(initial=0.0)
        free = rows_of_all[int(kept.sum()) :].T
        if not free.shape[1]:
            return []
        from scipy import optimize  # slow to import

        walls = [-part.inwards * rows[name] @ free for name, part in self.system.named() if isinstance(part, Stop)]
        # a constant force holds, as weight does
        closing = np.array([*walls, -self.system.constant_force @ free]).reshape(-1, free.shape[1])
        for direction in (*free, *-free):
            room = optimize.linprog(-direction, closing, np.zeros(len(closing)), bounds=(-1.0, 1.0))
            if room.x is not None and float(direction @ room.x) > 1e-9:
                away = np.abs(at.rows @ free @ room.x)
                return [point for point, far in zip(at.points, away, strict=True) if far > 1e-6 * away.max()]
        return []

    def usual_energy(self, values: Mapping[str, float]) -> float:
        """The kinetic energy, in J; without what inertial parts share between masses."""
        at = self.system.coordinates
        masses = zip(at.names, np.diag(at.mass), strict=True)
        return 0.5 * sum(float(mass) * values[f"{point}_v_mean_square"] for point, mass in masses)

    def scheme_for(self, word: Scheme) -> SchemeOfRun:
        """The scheme that a run has."""
        return "straight"

    def placed(self, given: Any) -> dict[str, float]:
        """x(0) of each mass: in equilibrium, or as near to it as the walls let them."""
        if given is None:
            return self.as_given(self._nearest_to_rest())
        places = _by_point(given, "initial_position", self.system.coordinates.names)
        x = np.array([*places.values()])
        for name, part in self.system.named():
            if isinstance(part, Barrier):
                row = self.system.coordinates.elongations[name]
                distance, size = part.inwards * (float(row @ x) - part.position), abs(part.position) + np.abs(x).max()
                if distance < -1e-12 * size:
                    raise ValueError(
                        f"initial_position lies behind {name}: its elongation must be {part.side} {part.position:g}, "
                        f"and is {float(row @ x):g}."
                    )
        return places

    def moving(self, given: Any) -> dict[str, float]:
        """x'(0) of each mass."""
        return _by_point({} if given is None else given, "initial_velocity", self.system.coordinates.names)

    def _equilibrium(self) -> Floats:
        """Where springs and constant forces balance, by Newton's method from 0; 0 where that finds no place."""
        coordinates, parts = self.system.coordinates, dict(self.system.named())
        force = self.system.constant_force
        x = np.zeros(len(force))
        if not force.any():
            return x
        for _ in range(_ROUNDS):
            left, stiffness = np.asarray(-force), np.zeros((x.size, x.size))
            for name, row in coordinates.elongations.items():
                springs, u = parts[name].force_coefficients() or (0.0,), float(row @ x)
                left = left + row * np.polynomial.polynomial.polyval(u, springs)
                slope = float(np.polynomial.polynomial.polyval(u, np.polynomial.polynomial.polyder(springs)))
                stiffness += slope * np.outer(row, row)
            if not np.linalg.eigvalsh(stiffness)[0] > 0.0:
                return np.zeros(x.size)
            change = np.linalg.solve(stiffness, left)
            x = x - change
            if np.abs(change).max() <= 1e-12 * np.abs(x).max():
                return x
        return np.zeros(x.size)

    def _nearest_to_rest(self) -> Floats:
        """The least change from the equilibrium that puts every elongation before its wall."""
        return self.within_walls(self._equilibrium())


def _walls(system: System, x: Floats) -> tuple[Floats, Floats]:
    """The rows of rigid walls, turned inwards, and how far some displacements are behind each."""
    walls = {name: part for name, part in system.stops.items() if isinstance(part, Barrier)}
    rows = [part.inwards * system.coordinates.elongations[name] for name, part in walls.items()]
    inward = np.array(rows).reshape(-1, len(x))
    return inward, np.array([part.inwards * part.position for part in walls.values()]) - inward @ x


def _inwards(row: Floats, stop: Stop) -> tuple[Any, ...]:
    """A wall or contact by the way in which it pushes, its place along that way, and its law."""
    return (
        tuple((stop.inwards * row).tolist()),
        stop.inwards * stop.position,
        replace(stop, position=0.0, side="above", between=None),  # type: ignore[call-arg]
    )


def _least_forces(inward: Floats, least: Floats) -> Floats | None:
    """The forces of walls that keep ``inward @ x`` at ``least`` or above with the smallest x; None if nothing does.

    Least distance programming (Lawson and Hanson, "Solving least squares problems", chapter 23); x is then
    ``inward.T @ forces``.
    """
    from scipy import optimize  # slow to import

    unit = float(np.abs(least).max())
    dual, _ = optimize.nnls(np.vstack([inward.T, least / unit]), np.append(np.zeros(inward.shape[1]), 1.0))
    left = float(least / unit @ dual) - 1.0
    return np.asarray(-unit * dual / left) if abs(left) > 1e-9 else None


def _by_point(given: Any, name: str, points: tuple[str, ...]) -> dict[str, float]:
    """A number for each point; 0 of those not named."""
    if not isinstance(given, Mapping):
        example = f"{ {points[0]: 0.01} }, in the command as {points[0]}=0.01"
        raise TypeError(f"{name} must say of which masses it is, in Python as {example}, not {shown(given)}.")
    for point in given:
        if point not in points:
            near = meant(point, points) if isinstance(point, str) else ""
            raise ValueError(f"{name} has {point!r}, which is no mass{near or f'; there are {listed([*points])}.'}")
    return {
        point: finite_number(given.get(point, 0.0), f"{name} of {point}", low=-LARGEST, high=LARGEST)
        for point in points
    }


def motion_of_several(system: System) -> MotionOfSeveral:
    """What follows from a system of several masses alone."""
    modes = modes_of(system)
    many = f"the paper's problem has one mass, and the system has {len(system.coordinates.names)}."
    motion = MotionOfSeveral(system, _scales(system, modes), 1.0, (), False, False, many)
    if not motion.springpots and not system.of(FractionalMaxwell):
        return motion
    rows = {f"{begin}_mean_square": row for begin, row in motion.displacements.items()}
    free = {name: modes.spread(row) ** 2 for name, row in rows.items()}
    return replace(
        motion,
        slow=(CreepOfSeveral(system, modes.stiffness, motion.scales.fastest_rate, rows, free),),
        searched=motion.remembers_a_mean and not (system.of(ThermalNoise) and motion.is_thermal),
    )


def _scales(system: System, modes: Modes) -> Scales:
    at = system.coordinates
    rows, size = at.elongations, len(at.names)
    held = modes.frequency[modes.frequency > _RIGID * max(float(modes.frequency.max()), 1e-300)]
    elements = [(part, rows[name]) for name, part in system.elements.items()]
    bent = {
        name: (max(_curvature(part, modes.spread(rows[name])), part.static_stiffness), part.linear_damping)
        for name, part in system.elements.items()
        if part.is_bent
    }
    fastest = [*(_modes(system, _linear(system) | bent).frequency if bent else held)]
    dampers = sum(
        (
            _strongest_damping(part, modes.spread(row), modes.speed(row)) * np.outer(row, row)
            for part, row in elements
            if isinstance(part, Dashpot | PolynomialDashpot | VanDerPol)
        ),
        np.zeros((size, size)),
    )
    fastest.append(float(np.linalg.eigvals(at.accelerations(dampers.T).T).real.max()))
    arms = at.sum_of({name: stiffness_at_once(part) for name, part in system.elements.items()})
    fastest.append(math.sqrt(max(float(np.linalg.eigvals(at.accelerations(arms.T).T).real.max()), 0.0)))
    fastest += [0.5 * part.frequency for part in system.of(Harmonic)]
    fastest += [rate_of_its_own(part) for part in system.elements.values()]
    fastest += [
        _rate_in(part, at.reduced(row), _FAR * modes.speed(row)) for part, row in elements if isinstance(part, Contact)
    ]
    fastest += [press / modes.speed(row) for row, press in _pressing(system, modes) if modes.speed(row) > 0.0]
    largest = float(max(fastest)) or 1.0  # straight flights between walls alone have no time of their own
    damped = modes.rate[modes.rate > _UNDAMPED * np.maximum(modes.frequency, 1e-300)]
    energy = [beat(system) / float(damped.min())] if damped.size else []
    if lossy := [(part, modes.speed(row)) for part, row in elements if isinstance(part, Barrier) and part.dissipates]:
        usual = (restitution_at(wall, math.sqrt(2.0) * speed) for wall, speed in lossy)
        loss = max(1.0 - min(max(share, 0.0), 1.0) ** 2 for share in usual)
        energy = energy or [
            beat(system) * 2.0 * math.pi / (max(loss, 1e-6) * float(held.min() if held.size else largest))
        ]
    spreads = [modes.spread(row) for row in at.rows]
    frequency = float(held.min()) if held.size else largest
    settled = max([*energy, *filter(None, map(time_of_its_own, system.elements.values()))], default=math.inf)
    yielding = max(_creep_times(system, _slow_dashpots(system, modes)), default=0.0)
    slow = ((name, *slow_springpot(part)) for name, part in system.elements.items())
    forgotten = max(settled, 2.0 / frequency, 0.5 * yielding, _forgetting_time(system, modes))
    if any(not part.is_linear for part in system.parts):  # the size of the motion is a guess
        forgotten *= _GUESSED
    return Scales(
        frequency=frequency,
        fastest_rate=largest,
        energy_time=settled,
        creep_time=max(yielding, *_creep_times(system, slow), 0.0),
        forgetting_time=forgotten,
        settling_time=max(settled, forgotten),
        flight_frequency=largest,
        length=max(spreads),
        spread=max(spreads),
        mean=0.0,
        guessed=True,
    )


def _forgetting_time(system: System, modes: Modes) -> float:
    """In which the slowest overdamped motion of springs and dashpots loses its square: it has no energy to lose."""
    at = system.coordinates
    stiffness, damping = at.sum_of(modes.stiffness), at.sum_of(modes.damping)
    none, one = np.zeros_like(at.mass), np.eye(len(at.mass))
    pulls = [-np.linalg.solve(at.mass, each) for each in (stiffness, damping)]
    rates = -np.linalg.eigvals(np.block([[none, one], pulls]))
    over = rates.real[(np.abs(rates.imag) <= 1e-9 * rates.real) & (rates.real > 1e-9 * np.abs(rates).max())]
    return 0.5 / float(over.min()) if over.size else 0.0


def _strongest_damping(part: Any, spread: float, speed: float) -> float:
    """Of a damper at the size of the motion, with what it feeds in and takes out both counted."""
    if isinstance(part, VanDerPol):
        return float(part.coefficient * (spread**2 + part.length**2))
    if isinstance(part, PolynomialDashpot) and not part.is_linear:
        positive = PolynomialDashpot(tuple(abs(c) for c in part.coefficients))
        return positive.linear_damping + _damping_at(positive, spread, speed)
    return float(part.linear_damping)


def _pressing(system: System, modes: Modes) -> list[tuple[Floats, float]]:
    """The rows of rigid walls, and the accelerations with which springs and constant forces press on each.

    Many kicks must share in each hop there.  With too few, each impact changes the energy at random, which heats a
    motion with little damping, and a lossy wall takes what the kicks give to masses at rest on it.
    """
    at = system.coordinates
    stiffness = at.sum_of({name: max(modes.stiffness[name], p.static_stiffness) for name, p in system.elements.items()})
    free = (1e-3 * float(modes.frequency.max()) or 1.0) ** 2  # so weakly everything is held
    values, shapes = np.linalg.eigh(stiffness + free * at.mass)
    if not values[0] > 0.0 or not (modes.frequency.any() or modes.rate.any()):  # no size is known
        return []
    soft = shapes / np.sqrt(values)
    inward, least = _walls(system, soft @ soft.T @ system.constant_force)
    pressing = _least_forces(inward @ soft, least) if (least > 0.0).any() else None
    if pressing is None:
        return []
    return [(row, float(force) / at.reduced(row)) for row, force in zip(inward, pressing, strict=True)]


def _rate_in(contact: Contact, reduced: float, speed: float) -> float:
    """Of the linear spring as stiff as a contact where it is deepest, at a speed of touch."""
    power = contact.exponent + 1.0
    depth = (0.5 * power * reduced * speed**2 / contact.stiffness) ** (1.0 / power)
    return math.sqrt(contact.exponent * contact.stiffness * depth ** (contact.exponent - 1.0) / reduced)


def _stop_rate(contact: Contact, reduced: float, speed: float) -> float:
    """At which its dissipation alone stops a speed of touch, m v dv/dd = -k d^p chi v."""
    power = contact.exponent + 1.0
    stop = (contact.stiffness * contact.dissipation / (power * reduced)) ** (1.0 / power)
    return float(stop * speed ** (1.0 - 1.0 / power))


def _curvature(part: Any, spread: float) -> float:
    """The largest stiffness within `_FAR` standard deviations."""
    u = np.linspace(-_FAR * spread, _FAR * spread, 201)
    return float(max(np.polynomial.polynomial.polyval(u, np.polynomial.polynomial.polyder(part.force_coefficients()))))


def _slow_dashpots(system: System, modes: Modes) -> Iterator[tuple[str, float, float]]:
    """Order and coefficient of what each part that yields is for slow displacements, by the fast motion."""
    for name, part in system.elements.items():
        row = system.coordinates.elongations[name]
        if isinstance(part, Yielding) and (speed := modes.speed(row)) > 0.0:
            reduced = system.coordinates.reduced(row)
            dashpot = slow_dashpot(part.per_mass(reduced), speed**2, 0.0)
            yield name, 1.0, reduced * dashpot


def _creep_times(system: System, pots: Iterable[tuple[str, float, float]]) -> Iterator[float]:
    """Of each springpot or dashpot in the place of a part, if it is stronger than the springs along its row."""
    at = system.coordinates
    values, shapes = np.linalg.eigh(system.stiffness_matrix)
    held = values > 1e-12 * max(float(values.max()), 0.0)
    for name, order, coefficient in pots:
        row = at.elongations[name]
        give, reduced = float(((row @ shapes[:, held]) ** 2 / values[held]).sum()), at.reduced(row)
        if order > 0.0 and give > 0.0 and coefficient / reduced > (give * reduced) ** (0.5 * order - 1.0):
            yield creep_time(coefficient * give, order)
