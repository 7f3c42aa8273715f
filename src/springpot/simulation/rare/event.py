"""What is asked of the paths, and the coordinate by which splitting tells which of them are near to it.

The coordinate is the energy of mass and springs: how far a path could go if noise and losses stopped.  Where a wall
behind the motion takes all but the share r^2 of it, a path that moves towards it counts with what the next impact will
leave, and one at its highest point, with no time left to rise further, with r.  Of several masses it is the largest
value of the quantity that the modes could make together if all of them came to be in phase; of impacts and functions of
the user their energy.  Any coordinate gives the right mean; a good one a small spread.

Between two kicks one mass moves exactly as the linear spring makes it, so that the extremes of x are those of circular
arcs, and several masses on straight lines, so that they are at the kicks.  Velocities jump at kicks: between two
observations those of white noise of intensity q exceed the observed ones by 0.5826 sqrt(q h) on average, and forces of
dashpots and memory their means over the steps (see `springpot.simulation.watch.first_passage`); with an envelope by
what belongs to the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, cast

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.problem.catalogue import LEVELS, unit_of_result
from springpot.problem.parts.walls import restitution_at
from springpot.simulation.kernel.branches import MARKS
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.kept import Code
from springpot.simulation.kernel.sizes import GROUP, LANES
from springpot.simulation.kernel.watching import HEADER, ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.lowering.outputs import roughness_in_steps
from springpot.simulation.plan.motion import ModesNear, Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.first_passage import SHIFT
from springpot.simulation.watch.observables import is_taken, mean_of

SPACING = 0.05  # of kept states, in units of the mean square of v
FLOOR = 0.25  # share of plain paths below the coordinate under which the first paths keep no states
_RARE = 0.02  # share of plain paths above the coordinate that tells how many iterations are ahead
LEAST_RAISED = 0.8  # share of the potential energy beside a lossy wall: measured best for restitutions of 0.4 to 0.9

_FIRST = len(HEADER)
_TERMS = 12  # of the potential beside the quadratic one
# numbers that all lanes share
_PLACED, _SIGN, _BEGIN, _HALF, _IN_STEPS, _COUNT, _POINTS, _MODES, _IN_PHASE = range(_FIRST, _FIRST + 9)
# then arrays with a number for each lane: marks, room for what is found in a step, and constants
_MARKS = _FIRST + 9
_MOST, _BY_HALF, _POTENTIAL, _SPEED, _TOGETHER = (_MARKS + n * LANES for n in range(1, 6))
_CONSTANTS = _TOGETHER + LANES
(
    _COSINE, _SINE, _TURNING, _SLOW, _LOWEST, _HIGHEST, _CENTRE, _SQUARES, _PUSH, _OVER, _SCALE, _NEAR, _STIFFNESS,
    _BEHIND, _LEFT, _RAISED, _STRUCK, _COEFFICIENTS,
) = (_CONSTANTS + n * LANES for n in range(18))  # fmt: skip
_SHAPES = _COEFFICIENTS + _TERMS * LANES  # of each mode its offset, and what each displacement and velocity adds to it


@dataclass(frozen=True, eq=False)
class Quantity:
    """What can be asked.

    Attributes
    ----------
    name, unit : str
    kind : str
        Its name with one mass; "force" of forces and accelerations, "own" of a function of the user.
    signal : Signal
        The displacement that it is of.
    observer : Observer or None
        Of a function of the user.
    """

    name: str
    unit: str
    kind: str
    signal: Signal
    observer: Observer | None = None

    @property
    def has_sides(self) -> bool:
        """Whether it may be exceeded downwards."""
        return self.kind in ("x", "v", "force")


def quantity_of(
    motion: Motion, name: Any, function: Callable[..., float] | None = None, argument: str = "levels"
) -> Quantity:
    """The quantity of this name, or a function of the user that has it; ``argument`` asks for it.

    Raises
    ------
    TypeError, ValueError, NotCoveredError
        In one sentence.
    """
    if function is not None:
        if name in motion.levels or is_taken(motion.system, str(name)):
            raise ValueError(f"{argument} cannot call a function {shown(name)}: there is a quantity of that name.")
        observer = mean_of(motion, name, function, "state", most=_MOST)
        return Quantity(name, "", "own", Signal(outputs=observer.signal.outputs), observer)
    known = motion.levels | {name: ("impact_speed", each) for name, each in motion.speeds.items()}
    if name not in known and name in motion.outputs:
        return Quantity(
            name, unit_of_result(motion.system, f"{name}_mean"), "force", motion.signal_by_name(name, argument)
        )
    if name not in known:
        near = motion.near(name, [*known, *motion.outputs])
        a, b, *_ = (*(name for name, (kind, _) in motion.levels.items() if kind == "x"), "")
        if b:
            near += f' Anything else is a function: {{"difference": (lambda {a}, {b}: {a} - {b}, levels)}}.'
        raise ValueError(f"{argument} has {shown(name)}, which is no quantity that can be asked{near}")
    kind, signal = known[name]
    if kind == "impact_speed" and not motion.touched:
        raise ValueError(f"{argument} of impact_speed need a wall or a contact, and the system has none.")
    if kind in ("amplitude", "energy") and not motion.system.natural_frequency > 0.0:
        raise ValueError(f"{argument} of {name} need a linear spring: use x, v, speed or distance.")
    return Quantity(name, LEVELS.get(kind, "m s-1"), kind, signal)


@dataclass(frozen=True, eq=False)
class Event:
    """A quantity whose largest value is asked of each path.

    Attributes
    ----------
    name, unit : str
    given : ndarray
        The levels, in the user's units, in the order of rarity.
    levels : ndarray
        Of the mark that the observer keeps, in the kernel's units: a path exceeds a level if its mark does.
    observers : tuple of Observer
        Of the coordinate and of the quantity: they share one array, which holds the marks.
    spacing : float
        By which the coordinate must rise before a state is kept again.
    duration : float
        The time that counts, in s.
    target : float
        The coordinate that a path has, about, when it exceeds the last level; NaN where plain paths must tell.
    floor : float
        No state of the first paths is kept below this coordinate.
    downwards : bool
        Whether levels are exceeded by what is below them.
    iterations : float
        Of splitting until the target, about, as plain paths tell; 0 before.
    """

    name: str
    unit: str
    given: Floats
    levels: Floats
    observers: tuple[Observer, ...]
    spacing: float
    duration: float
    target: float
    floor: float = -math.inf
    downwards: bool = False
    iterations: float = 0.0

    @property
    def marks(self) -> slice:
        """Where in the array, with its header, the marks are."""
        return slice(_MARKS, _MARKS + MARKS * LANES)

    @property
    def constants(self) -> slice:
        """Where those of each lane are; what is behind them is not of a lane."""
        array = self.observers[0].initial
        return slice(_CONSTANTS, int(array[_IN_STEPS - _FIRST]) or _FIRST + array.size)

    def told_by(self, ends: Floats) -> Event:
        """With what plain paths tell of the coordinate: ``ends`` are their marks, (paths, MARKS).

        Half of the first paths will be replaced at once, so that their states below that need not be kept; and where
        the coordinate at the last level is not known, it is that which the largest values of the paths point to.
        """
        reached, most = ends[:, 0], ends[:, 1]
        own, target = np.isfinite(most), self.target
        if not math.isfinite(target):
            least = float(reached.min())
            rooted, values = np.sqrt(reached[own] - least), most[own]
            spread = float(values.var()) if own.any() else 0.0
            slope = float(((values - values.mean()) * rooted).mean()) / spread if spread > 0.0 else 0.0
            there = float(rooted.mean()) + slope * (float(self.levels[-1]) - float(values.mean())) if own.any() else 0.0
            target = least + max(there, float(rooted.max()) if own.any() else 0.0) ** 2
        floor, middle, high = np.quantile(reached, (FLOOR, 0.5, 1.0 - _RARE))
        # the share of the paths beyond a coordinate falls exponentially with it
        far = min((target - middle) / (high - middle), 1e3) if high > middle else 0.0
        return replace(self, target=target, floor=float(floor), iterations=1.0 + math.log2(0.5 / _RARE) * max(far, 0.0))


def event_of(plan: Plan, parts: Parts, quantity: Quantity, levels: Floats, sign: float) -> Event:
    """The quantity, in the window of the plan; the coordinate counts in that of the run.

    Parameters
    ----------
    levels : ndarray
        In the user's units, in the order of rarity.
    sign : float
        1 if levels of a quantity with sides are exceeded upwards, -1 downwards.
    """
    motion, units, (low, high) = plan.motion, parts.units, plan.settings.window_steps
    kind, signal = quantity.kind, quantity.signal
    scale = {"own": 1.0, "energy": units.speed**2}.get(kind, units.speed if quantity.unit == "m s-1" else units.length)
    kernels = np.asarray(levels, float) * (sign if quantity.has_sides else 1.0) / scale
    if kind == "amplitude":
        kernels = 0.5 * (motion.system.resonance * units.time * kernels) ** 2
    own, target, modes = _constants(plan, parts, quantity, float(levels[-1]), sign)
    spacing = SPACING * (motion.law.temperature / units.speed**2 if modes is None else 1.0)
    placed = 1.0 if kind in ("x", "distance", "force") else -1.0 if kind in ("impact_speed", "own") else 0.0
    half, terms = low + (high - low) // (2 * GROUP) * GROUP, max(np.flatnonzero(own[_BEYOND]) + 1, default=0)
    shapes = (0.0, 0.0, 0.0) if modes is None else (modes.rest.size, len(modes.placed), float(not _by_energy(kind)))
    by_lane = np.repeat(own, LANES)
    shared = np.array([placed, sign if quantity.has_sides else 0.0, low, half, 0.0, terms, *shapes])
    rooms, shares = np.concatenate([np.full(MARKS * LANES, -np.inf), np.zeros(3 * LANES)]), np.zeros(0)
    if motion.is_modulated and (own[_of(_OVER)] > 0.0 or own[_of(_SQUARES)] > 0.0):
        shared[_IN_STEPS - _FIRST] = _CONSTANTS + by_lane.size
        shares = np.pad(roughness_in_steps(plan, parts.outputs, signal), (0, GROUP), mode="edge")
    initial = np.concatenate([shared, rooms, by_lane, shares])
    on_energy, on_modes, on_steps, on_impacts = _compiled()
    nearness = Observer(Signal(), on_energy if modes is None else on_modes, None, initial)
    signal = replace(signal, number=signal.number or 0)  # steps also where only impacts are seen
    seeing = Observer(signal, on_steps, on_impacts if kind == "impact_speed" else None, initial)
    observers = nearness, *([quantity.observer] if quantity.observer else []), seeing
    duration = (high - low) * plan.settings.step
    downwards = quantity.has_sides and sign < 0.0
    return Event(
        quantity.name, quantity.unit, levels, kernels, observers, spacing, duration, target, downwards=downwards
    )


def constants_of(
    nominal: tuple[Plan, Parts], devices: Sequence[tuple[Plan, Parts]], quantity: Quantity, event: Event, sign: float,
    factors: Floats,
) -> Floats:  # fmt: skip
    """The constants of devices by lane, shape (devices, constants), where the nominal one has been asked.

    ``factors`` are the levels of each device over those of the nominal one.  What a device reaches, and its coordinate,
    are brought to the scale of the nominal one, so that they have the same levels.
    """
    level = float(event.given[-1])
    _, target, modes = _constants(*nominal, quantity, level, sign)
    found = []
    for (plan, parts), factor in zip(devices, factors.tolist(), strict=True):
        _, signal = plan.motion.levels.get(quantity.name, (None, quantity.signal))  # between walls of its own
        its_quantity = replace(quantity, signal=signal)
        own, its_target, its_modes = _constants(plan, parts, its_quantity, factor * level, sign)
        stretch, near = factor, 1.0 / factor**2
        if quantity.kind == "amplitude":
            stretch = (factor * plan.system.resonance / nominal[0].system.resonance) ** 2
        if modes is not None and its_modes is not None:
            near *= (its_modes.usual / modes.usual) ** 2
        elif math.isfinite(target) and min(target, its_target) > 0.0:
            near = target / its_target
        own[_of(_SCALE)], own[_of(_NEAR)] = 1.0 / stretch, near
        found.append(own)
    return np.array(found)


def _of(place: int) -> int:
    """The number of a constant."""
    return (place - _CONSTANTS) // LANES


def _by_energy(kind: str) -> bool:
    """Whether modes count by their energy: of impacts as good, and better than the speed without the place."""
    return kind in ("own", "impact_speed")


_BEYOND = slice(_of(_COEFFICIENTS), _of(_SHAPES))


def _constants(
    plan: Plan, parts: Parts, quantity: Quantity, level: float, sign: float
) -> tuple[Floats, float, ModesNear | None]:
    """Those of a system, in the kernel's units; the coordinate at a level; and the modes that it is of, if any."""
    motion, units, kind, signal = plan.motion, parts.units, quantity.kind, quantity.signal
    modes = motion.modes_near(signal, of_speed=quantity.unit == "m s-1", by_energy=_by_energy(kind))
    shapes = np.zeros(0)
    if modes is not None:
        rest = -(modes.placed @ modes.rest)[:, None]
        shapes = np.hstack([rest, units.length * modes.placed, units.speed * modes.moved]).ravel()
    found = np.concatenate([np.zeros(_of(_SHAPES)), shapes])

    def put(at: int, value: Any) -> None:
        found[_of(at) : _of(at) + np.size(value)] = value

    if kind == "force":
        over = parts.outputs.exceeding(signal.outputs[0])
    else:  # by which noise lets velocities exceed the observed ones
        over = SHIFT * math.sqrt(motion.intensity_of(signal) * plan.settings.step) / units.speed
    put(_COSINE, (1.0, 0.0, 0.0) if kind == "force" else parts.half_drift)
    put(_SLOW, 1.0 / (parts.outputs.scale if signal.outputs else parts.frequency))
    put(_CENTRE, 0.0 if kind == "force" else parts.place)
    put(_LOWEST, sorted(end / units.length for end in (signal.low, signal.high)))
    put(_SCALE, 1.0)
    put(_NEAR, 1.0)
    if kind in ("v", "speed"):
        put(_PUSH, 1.0)
    if kind in ("v", "speed", "force"):
        put(_OVER, over)
    if kind in ("energy", "amplitude"):
        frequency = motion.system.natural_frequency if kind == "energy" else motion.system.resonance
        put(_SQUARES, (frequency * units.time) ** 2)
        put(_PUSH, over)
    if modes is not None:
        put(_STRUCK, -math.inf)
        return found, math.nan, modes
    ends = sorted(end / parts.units.length for end in (motion.low, motion.high))
    energy = _energy(motion, parts)  # of one mass, and what is lost at a wall behind its motion
    put(_STIFFNESS, energy.stiffness)
    put(_LEFT, (1.0, 1.0))
    put(_STRUCK, min((energy(end) for end in ends if math.isfinite(end)), default=0.0))
    if quantity.kind == "x" and (loss := _loss(motion, sign)):
        put(_BEHIND, energy(loss.place / parts.units.length))
        put(_LEFT, (loss.left, loss.raised))
    put(_COEFFICIENTS, energy.beyond)
    if kind in ("force", "own"):
        return found, math.nan, None
    return found, _target(plan, kind, level, sign) / units.speed**2, None


@dataclass(frozen=True)
class _Energy:
    """The potential in the kernel's units: quadratic, and coefficients of x, x^2, ... beside that."""

    stiffness: float
    beyond: tuple[float, ...]

    def __call__(self, x: float) -> float:
        return 0.5 * self.stiffness * x * x + sum(c * x ** (n + 1) for n, c in enumerate(self.beyond))


def _energy(motion: Motion, parts: Parts) -> _Energy:
    """Of the springs, with what the elements with memory add at the resonance."""
    units, system = parts.units, motion.system
    force = [c * units.length ** (n - 1) * units.time**2 for n, c in enumerate(system.potential.coefficients)]
    stiffness = force[1] if len(force) > 1 else 0.0
    if system.stiffness > 0.0:
        stiffness += (system.resonance**2 - system.natural_frequency**2) * units.time**2
    beyond = [0.0 if n == 1 else c / (n + 1) for n, c in enumerate(force)]
    while beyond and beyond[-1] == 0.0:
        beyond.pop()
    return _Energy(stiffness, tuple(beyond))


@dataclass(frozen=True)
class _Loss:
    """At a wall, in m: the share of energy that an impact leaves, and that of potential energy which counts."""

    place: float
    left: float
    raised: float


def _loss(motion: Motion, sign: float) -> _Loss | None:
    """That of a usual impact; None where there is no wall."""
    side, place = ("above", motion.low) if sign > 0.0 else ("below", motion.high)
    wall = next((wall for wall in motion.unit.walls.values() if wall.free_side == side), None)
    if wall is None:
        return None
    restitution = restitution_at(wall, math.sqrt(motion.law.temperature))
    return _Loss(place, restitution**2, max(restitution, LEAST_RAISED))


def _target(plan: Plan, kind: str, level: float, sign: float) -> float:
    """The coordinate at a level, in m^2/s^2."""
    motion, system = plan.motion, plan.system
    more = system.resonance**2 - system.natural_frequency**2 if system.stiffness > 0.0 else 0.0

    def potential(x: Floats) -> Floats:
        return system.potential.energy(x) + 0.5 * more * x * x

    def height(end: float) -> float:
        return float(potential(np.linspace(start, end, 257)).max())

    start = float(cast(float, plan.settings.initial_position))
    if kind == "x":
        loss, top = _loss(motion, sign), height(level)
        behind = math.inf if loss is None else float(potential(np.array(loss.place)))
        return top if loss is None or top < behind else behind + loss.raised * (top - behind)
    if kind == "distance":
        ends = (height(end) for end in (-level, level) if motion.low <= end <= motion.high)
        return min(ends, default=height(level))  # of a device whose walls are nearer
    if kind == "amplitude":
        return 0.5 * (system.resonance * level) ** 2
    if kind == "energy":
        return level
    if kind == "impact_speed":
        places = np.array([stop.position for stop in motion.touched.values()])
    else:
        mean, spread, _ = motion.size_of(motion.signals[0])
        places = np.clip(mean + spread * np.linspace(-6.0, 6.0, 257), motion.low, motion.high)
    return 0.5 * level**2 + float(potential(places).min())


@cache
def _compiled() -> tuple[Code, ...]:
    @callback(ON_STEPS)
    def on_energy(x: Any, v: Any, step: float, n: int, low: int, high: int, array: Any) -> None:
        if n < low:
            return
        sign, terms = array[_SIGN], int(array[_COUNT])
        for j in range(GROUP):
            at = j * LANES
            if terms > 0:
                for lane in range(LANES):
                    array[_POTENTIAL + lane] = 0.0
                for k in range(terms - 1, -1, -1):
                    for lane in range(LANES):
                        c = array[_COEFFICIENTS + k * LANES + lane]
                        array[_POTENTIAL + lane] = (array[_POTENTIAL + lane] + c) * x[at + lane]
            for lane in range(LANES):
                here, speed, behind = x[at + lane], v[at + lane], array[_BEHIND + lane]
                above = 0.5 * array[_STIFFNESS + lane] * here * here + array[_POTENTIAL + lane] - behind
                energy = 0.5 * speed * speed + above
                above = above if above > 0.0 else 0.0
                left = array[_LEFT + lane] if sign * speed < 0.0 else 1.0
                kept = left * (energy - above) + array[_RAISED + lane] * above
                energy = array[_NEAR + lane] * (behind + (kept if energy > 0.0 else energy))
                top = array[_MARKS + lane]
                array[_MARKS + lane] = energy if energy > top else top

    @callback(ON_STEPS)
    def on_modes(x: Any, v: Any, step: float, n: int, low: int, high: int, array: Any) -> None:
        """At the end of each group, where states are kept."""
        if n < low:
            return
        points, modes, in_phase = int(array[_POINTS]), int(array[_MODES]), array[_IN_PHASE] > 0.0
        for lane in range(LANES):
            array[_TOGETHER + lane] = 0.0
        for m in range(modes):
            at = _SHAPES + m * (2 * points + 1) * LANES
            for lane in range(LANES):
                array[_POTENTIAL + lane], array[_SPEED + lane] = array[at + lane], 0.0
            for k in range(points):
                of_x, i = at + (1 + k) * LANES, (GROUP * (k + 1) - 1) * LANES
                of_v = of_x + points * LANES
                for lane in range(LANES):
                    array[_POTENTIAL + lane] += array[of_x + lane] * x[i + lane]
                    array[_SPEED + lane] += array[of_v + lane] * v[i + lane]
            for lane in range(LANES):
                square = array[_POTENTIAL + lane] ** 2 + array[_SPEED + lane] ** 2
                array[_TOGETHER + lane] += math.sqrt(square) if in_phase else square
        for lane in range(LANES):
            whole, top = array[_TOGETHER + lane], array[_MARKS + lane]
            whole = array[_NEAR + lane] * (0.5 * (whole * whole if in_phase else whole))
            array[_MARKS + lane] = whole if whole > top else top

    @callback(ON_STEPS)
    def on_steps(x: Any, v: Any, step: float, n: int, low: int, high: int, array: Any) -> None:
        if n < low:
            return
        sign, in_steps = array[_SIGN], int(array[_IN_STEPS])
        for j in range(GROUP):
            at = j * LANES
            share = array[in_steps + n + j] if in_steps > 0 else 1.0
            if array[_PLACED] > 0.0:
                for lane in range(LANES):
                    lowest, highest, centre = array[_LOWEST + lane], array[_HIGHEST + lane], array[_CENTRE + lane]
                    cosine, sine, turning = array[_COSINE + lane], array[_SINE + lane], array[_TURNING + lane]
                    here, speed = x[at + lane], abs(v[at + lane]) * array[_SLOW + lane] if sine > 0.0 else 0.0
                    end = highest if here > 0.0 else -lowest
                    out = abs(here)
                    end = end if sign == 0.0 else highest if sign > 0.0 else -lowest
                    out = out if sign == 0.0 else sign * here
                    rest = sign * centre if sign != 0.0 else centre if here > 0.0 else -centre
                    out -= rest
                    far = cosine * out + sine * speed
                    far = math.sqrt(out * out + speed * speed) if turning * out > cosine * speed else far
                    far += rest
                    far = array[_SCALE + lane] * ((far if far < end else end) + array[_OVER + lane] * share)
                    most = array[_MOST + lane]
                    array[_MOST + lane] = far if far > most else most
            elif array[_PLACED] == 0.0:
                for lane in range(LANES):
                    here, speed, squares = x[at + lane], v[at + lane], array[_SQUARES + lane]
                    out = abs(speed) if sign == 0.0 else sign * speed
                    energy = 0.5 * (speed * speed + squares * here * here) if squares > 0.0 else 0.0
                    pushed = array[_PUSH + lane] * (share if squares > 0.0 else 1.0)
                    value = array[_SCALE + lane] * (pushed * out + energy + array[_OVER + lane] * share)
                    most = array[_MOST + lane]
                    array[_MOST + lane] = value if value > most else most
        if n < array[_BEGIN]:  # what comes before the time that counts is forgotten
            for lane in range(LANES):
                array[_MOST + lane] = -np.inf
        if n < array[_HALF]:
            for lane in range(LANES):
                array[_BY_HALF + lane] = array[_MOST + lane]

    @callback(ON_IMPACTS)
    def on_impacts(count: float, speed: float, lane: int, array: Any) -> None:
        energy = array[_NEAR + lane] * (array[_STRUCK + lane] + 0.5 * speed * speed)
        if energy > array[_MARKS + lane]:
            array[_MARKS + lane] = energy
        if array[_SCALE + lane] * speed > array[_MOST + lane]:
            array[_MOST + lane] = array[_SCALE + lane] * speed

    return on_energy, on_modes, on_steps, on_impacts
