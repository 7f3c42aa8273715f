"""The normal modes of a system at the guessed size of its motion, and the scales that follow from them.

The modes of the linear springs, with the stiffness of what has memory at each mode's own frequency, give the rates and
times; nonlinear springs count with their mean stiffness at the size of the motion, which is guessed from a balance of
energy in each mode.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts.walls import restitution_at
from springpot.problem.system import System
from springpot.simulation.plan.rest import least_forces, walls_at
from springpot.simulation.plan.scales import Scales, beat, creep_time
from springpot.simulation.plan.schemes import Straight
from springpot.simulation.plan.struck import Pressed, intensity_along
from springpot.theory.normal_modes import free_motion

_ROUNDS, _ROUNDS_OF_SIZE = 60, 20  # of frequencies that depend on themselves, and of the size of the motion
_FAR = 3.0  # standard deviations at which a spring is taken for its fastest motion
_HOPPED = 0.2  # step over v_rms / a of hops on a wall
_RIGID = 1e-9  # of the largest frequency: a motion that stretches no spring
_UNDAMPED = 1e-12  # of the frequency
_GUESSED = 1.5  # factor on the forgetting time


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
    def stretching(self) -> Any:
        """Which of them stretch springs."""
        return self.frequency > _RIGID * max(float(self.frequency.max()), 1e-300)

    @property
    def damped(self) -> Any:
        """Which of them lose energy without walls."""
        return self.rate > _UNDAMPED * np.maximum(self.frequency, 1e-300)

    @property
    def held(self) -> tuple[Floats, Floats]:
        """Displacements and velocities of the modes that stretch springs, per normal; shape (coordinates, modes)."""
        held = self.stretching
        speeds = self.shapes[:, held] * np.sqrt(self.temperature[held])
        return speeds / self.frequency[held], speeds

    def speed(self, row: Floats) -> float:
        """Standard deviation of an elongation's velocity, about."""
        return math.sqrt(float(((row @ self.shapes) ** 2 * self.temperature).sum()))

    def spread(self, row: Floats) -> float:
        """Standard deviation of an elongation, about; modes that stretch no spring do not count."""
        held = self.stretching
        squares = (row @ self.shapes[:, held]) ** 2 * self.temperature[held] / self.frequency[held] ** 2
        return math.sqrt(float(squares.sum()))


def modes_of(system: System) -> Modes:
    """The modes of a system at the guessed size of its motion.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Mass, Spring, WhiteNoise
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(1.0, at="b"), Spring(1.0, between=("ground", "a")), Spring(1.0, between=("a", "b")),
    ...     WhiteNoise(1.0, on="b"), Dashpot(0.1, between=("ground", "a")),
    ... )
    >>> modes_of(pair).frequency.round(6).tolist()
    [0.618034, 1.618034]
    """
    linear, at = _linear(system), system.coordinates
    found = _modes(system, linear)
    of_size = {name: part for name, part in system.elements.items() if part.is_bent or part.is_rough}
    for _ in range(_ROUNDS_OF_SIZE if of_size else 0):
        means = dict(linear)
        for name, part in of_size.items():
            row = at.elongations[name]
            spread, speed = found.spread(row), found.speed(row)
            damping = part.linear_damping + part.damping_beside(spread, speed, at.reduced(row))
            means[name] = part.mean_stiffness(spread), damping
        found = _modes(system, means)
    return found


def _linear(system: System) -> dict[str, tuple[float, float]]:
    """Stiffness and damping of the linear part of each force."""
    return {name: (part.static_stiffness, part.linear_damping) for name, part in system.elements.items()}


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
        (springpot.coefficient / at.reduced(at.elongations[name])) ** (1.0 / (2.0 - springpot.order))
        for name, springpot in system.springpots.items()
    ]
    return max(rates, default=0.0)


def _temperatures(system: System, frequency: Floats, rate: Floats, shapes: Floats) -> tuple[Floats, bool]:
    if system.thermal:
        return np.full(len(rate), system.thermal.temperature), True
    fed, coordinates = np.zeros(len(rate)), system.coordinates
    for name, row in coordinates.forces.items():
        fed += (row @ shapes) ** 2 * [system.excitations[name].fed_into_mode(w) for w in frequency]
    fed = _with_multiplied(system, frequency, rate, fed, shapes)
    # where nothing dissipates, what is fed in within a radian
    whole = float(fed.sum()) / (float(rate.sum()) if rate.sum() > 0.0 else max(float(frequency.max()), 1e-300))
    damped = rate > _UNDAMPED * frequency
    return np.where(damped & (fed > 0.0), fed / np.where(damped, rate, 1.0), whole), bool(fed.any())


def _with_multiplied(system: System, frequency: Floats, rate: Floats, fed: Floats, shapes: Floats) -> Floats:
    """The power fed into each mode with that of noise which multiplies elongations, and so grows with the motion.

    Where such noise feeds in more than is taken out, nothing of it is counted.
    """
    noises = system.multiplied
    if not noises or not rate.all():
        return fed
    seen = np.array([(system.coordinates.elongations[name] @ shapes) ** 2 for name in noises])
    w = np.maximum(frequency, _RIGID * max(float(frequency.max()), 1e-300))
    # of power with each temperature
    grows = 0.5 * (seen.T * [part.intensity for part in noises.values()]) @ (seen / w**2)
    if not np.abs(np.linalg.eigvals(grows / rate[:, None])).max() < 1.0:
        return fed
    return np.asarray(rate * np.linalg.solve(np.diag(rate) - grows, fed))


def modal_scales(system: System, modes: Modes) -> Scales:
    """The rates, times and sizes of a system, from its modes.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, WhiteNoise
    >>> ends = ("ground", "a"), ("a", "b")
    >>> pair = System(
    ...     Mass(1.0, at="a"), Mass(1.0, at="b"), *(Spring(1.0, between=each) for each in ends), WhiteNoise(1.0, on="b")
    ... )
    >>> round(modal_scales(pair, modes_of(pair)).fastest_rate, 6)
    1.618034
    """
    at = system.coordinates
    rows, size = at.elongations, len(at.names)
    held, pressing = modes.frequency[modes.stretching], _pressing(system, modes)
    elements = [(part, rows[name]) for name, part in system.elements.items()]
    bent = {
        name: (max(part.largest_stiffness(_FAR * modes.spread(rows[name])), part.static_stiffness), part.linear_damping)
        for name, part in system.elements.items()
        if part.is_bent
    }
    fastest = [*(_modes(system, _linear(system) | bent).frequency if bent else held)]
    dampers = sum(
        (part.strongest_damping(modes.spread(row), modes.speed(row)) * np.outer(row, row) for part, row in elements),
        np.zeros((size, size)),
    )
    fastest.append(float(np.linalg.eigvals(at.accelerations(dampers.T).T).real.max()))
    arms = at.sum_of({name: part.stiffness_at_once for name, part in system.elements.items()})
    fastest.append(math.sqrt(max(float(np.linalg.eigvals(at.accelerations(arms.T).T).real.max()), 0.0)))
    fastest += [part.rate_of_its_own for _, part in system.named()]
    touches = [(contact, at.reduced(rows[name]), _FAR * modes.speed(rows[name]))
               for name, contact in system.contacts.items()]  # fmt: skip
    fastest += [contact.fastest_touch(reduced, speed) for contact, reduced, speed in touches]
    stop_rates = [contact.stop_rate(reduced, speed) for contact, reduced, speed in touches]
    fastest += [press / modes.speed(row) for row, press in pressing if modes.speed(row) > 0.0]
    largest = float(max(fastest)) or 1.0  # straight flights between walls alone have no time of their own
    damped = modes.rate[modes.damped]
    energy = [beat(system) / float(damped.min())] if damped.size else []
    if lossy := [(wall, modes.speed(rows[name])) for name, wall in system.walls.items() if wall.dissipates]:
        usual = (restitution_at(wall, math.sqrt(2.0) * speed) for wall, speed in lossy)
        loss = max(1.0 - min(max(share, 0.0), 1.0) ** 2 for share in usual)
        energy = energy or [
            beat(system) * 2.0 * math.pi / (max(loss, 1e-6) * float(held.min() if held.size else largest))
        ]
    spreads = [modes.spread(row) for row in at.rows]
    frequency = float(held.min()) if held.size else largest
    own_times = [part.time_of_its_own for part in system.elements.values() if part.time_of_its_own]
    settled = max([*energy, *own_times], default=math.inf)
    yielding = max(_creep_times(system, _slow_dashpots(system, modes)), default=0.0)
    slow = ((name, *part.slow_springpot) for name, part in system.elements.items())
    forgotten = max(settled, 2.0 / frequency, 0.5 * yielding, _forgetting_time(system, modes))
    if any(not part.is_linear for part in system.parts):  # the size of the motion is a guess
        forgotten *= _GUESSED
    return Scales(
        frequency=frequency,
        fastest_rate=largest,
        resolved_rate=max(largest, 0.0, *stop_rates, *_hops(system, modes, pressing)),
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
    inward, least = walls_at(system, soft @ soft.T @ system.constant_force)
    pressing = least_forces(inward @ soft, least) if (least > 0.0).any() else None
    if pressing is None:
        return []
    return [(row, float(force) / at.reduced(row)) for row, force in zip(inward, pressing, strict=True)]


def _hops(system: System, modes: Modes, pressing: Iterable[tuple[Floats, float]]) -> Iterator[float]:
    """Rates at which white noise lets pressed masses hop on lossy walls.

    Of a step of 0.2 v_rms / a the mean square of the velocity lacks 1.5 %, of twice that 3 %; beyond, it grows.
    """
    for wall, (row, press) in zip(system.walls.values(), pressing, strict=False):
        fed, speed = 0.5 * intensity_along(system, modes.spread, row, wall.position), modes.speed(row)
        own = Pressed(press, restitution_at(wall, math.sqrt(2.0) * speed))
        if press > 0.0 and fed > 0.0 and own.restitution < 1.0:
            yield Straight.default_step * press / (_HOPPED * own.speed(fed, fed / speed**2))


def _slow_dashpots(system: System, modes: Modes) -> Iterator[tuple[str, float, float]]:
    """Order and coefficient of what each part that yields is for slow displacements, by the fast motion."""
    for name, part in system.elements.items():
        row = system.coordinates.elongations[name]
        if part.yields and (speed := modes.speed(row)) > 0.0:
            reduced = system.coordinates.reduced(row)
            dashpot = part.per_mass(reduced).slow_dashpot(0.0, speed**2)
            yield name, 1.0, reduced * dashpot


def _creep_times(system: System, springpots: Iterable[tuple[str, float, float]]) -> Iterator[float]:
    """Of each springpot or dashpot in the place of a part, if it is stronger than the springs along its row."""
    at = system.coordinates
    values, shapes = np.linalg.eigh(system.stiffness_matrix)
    held = values > 1e-12 * max(float(values.max()), 0.0)
    for name, order, coefficient in springpots:
        row = at.elongations[name]
        give, reduced = float(((row @ shapes[:, held]) ** 2 / values[held]).sum()), at.reduced(row)
        if order > 0.0 and give > 0.0 and coefficient / reduced > (give * reduced) ** (0.5 * order - 1.0):
            yield creep_time(coefficient * give, order)
