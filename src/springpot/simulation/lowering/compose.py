"""From the plan of a system of several masses to the arguments of its kernel, and from its sums to results.

Each part is lowered as in a system of one mass (`springpot.simulation.lowering.parts.lower`), per unit of mass of the
kernel, and what it adds goes to its row: parts between the same two ends share one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.memory import ExponentialSum, direct
from springpot.problem.coordinates import Coordinates
from springpot.problem.parts import Barrier, Contact, ThermalNoise
from springpot.problem.parts.walls import PowerRestitution, Restitution
from springpot.problem.system import System
from springpot.simulation.kernel import advance as kernel
from springpot.simulation.kernel import excitations, laws
from springpot.simulation.kernel.branches import MARKS, Kept, table_of
from springpot.simulation.kernel.callbacks import restitution_of
from springpot.simulation.kernel.motion import CUBIC, LINEAR, NINTH, NO_SPRING, NUMBERS_OF_TURN
from springpot.simulation.kernel.native import KERNELS, KERNELS_BY_LANE
from springpot.simulation.kernel.rest import MOST_POINTS, MOST_WALLS
from springpot.simulation.kernel.sizes import GROUP, LANES, MOST_MODES
from springpot.simulation.kernel.striking import FIXED, POWER_LAW
from springpot.simulation.kernel.tables import SUMS, Tables, packed
from springpot.simulation.lowering import sources
from springpot.simulation.lowering.memory import Tap, answer_of, memory_of, rough_answer_of, sums_of, taps_of
from springpot.simulation.lowering.observers import Observer
from springpot.simulation.lowering.outputs import OutputsInKernel, lowered_outputs
from springpot.simulation.lowering.parts import (
    MOST_SUBSTEPS,
    SUBSTEPS,
    Damper,
    Lowered,
    contact_time,
    lower,
    modulated_noise,
    numbers_of,
    thermal_noise,
)
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.scales import Units
from springpot.simulation.plan.settings import SINGLE_PRECISION, Settings

Sum = tuple[str, str]
"""A sum over the steps of a path: of which quantity, and whose: of a coordinate, a row, a force, a wall, a circuit."""
_TRIED = 16  # neighbours of a number on either side, by about a unit in the last place
_MANY = 1e6  # steps
_AXES = (-1, 1, 1), (1, -1, 1), (1, 1, -1)


@dataclass(frozen=True)
class Reading:
    """One result as sums over steps, time or other sums.

    Attributes
    ----------
    name : str
        Of the result.
    above : dict
        The sums, each with its factor.
    over : {"steps", "time", "groups", "one"} or tuple of Sum
        What they are divided by: the steps, the time or the groups of steps of the window, nothing, or other sums (a
        ratio of two means over all paths).
    added : float
        To the quotient.
    power : int
        Of the whole of each path.
    squares : dict
        Sums whose squares are added to that, each with its factor.
    """

    name: str
    above: Mapping[Sum, float]
    over: Literal["steps", "time", "groups", "one"] | tuple[Sum, ...] = "steps"
    added: float = 0.0
    power: int = 1
    squares: Mapping[Sum, float] = field(default_factory=dict)


def has_damping(system: System) -> bool:
    """Whether the sums of springpots, dashpots, arms and circuits are of anything."""
    linear = (part.dissipates and part.is_linear and "damping" in part.powers for part in system.parts)
    return bool(system.damping) or any(linear)


_ENDS = "x_end", "v_end"
_TOUCHING_SPEED = 6.0  # in the kernel's units, which are those of the motion: of a rare flight
_OF_A_WALL = "impacts", "speeds", "squares", "loss", "momentum"


@dataclass(frozen=True)
class Worked:
    """A force with a name, whose work is summed.

    Attributes
    ----------
    name : str
    does : {"feeds", "dissipates", "works", "expected", "nothing"}
        How its work is reported: as what is fed in, what is taken out, what a force of unknown kind does, what is
        expected of noise that multiplies x, or not at all.
    mass : float
        In which its work is counted, in that of the kernel.
    """

    name: str
    does: str
    mass: float = 1.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Parts:
    """The arguments of the kernel for one system and one step, and how its sums are read.

    Attributes
    ----------
    tables : Tables
    kept : tuple
        Functions of the user, whose addresses the tables have.
    start : ndarray, shape (1, 2 coordinates)
        x and v at time 0, in the kernel's units.
    half_drift : tuple of float
        Shares of a place, and of a velocity over ``frequency``, in the place half a drift away; and the latter again
        where a drift may turn in between.
    units : Units
    unit_mass : float
        The kernel's unit, in kg.
    history : ExponentialSum
        The memory without units.
    expected_power : float
        Mean input power of the noise whose increments are independent.
    expected_in : callable, optional
        The same between each two of some steps, where it changes in time.
    taken_at_once : float
        What dampers and memory take of the expected power within the kicks that bring it; the sums of a run do not have
        it.
    named : tuple of Worked
        The forces with names, in the order of their works.
    taps : tuple of Tap
        Circuits whose voltage is observed.
    points, gauged : tuple of str
        Whose sums there are: names of the coordinates, and of all rows.
    others : ndarray, shape (other points, coordinates)
        The rows of points that are no coordinates.
    law : object or None
        From which x and v at time 0 are drawn; otherwise they are those of ``start``.
    frequency : float
        Of flights, were they to turn, in the kernel's units.
    place : float
        From which the kernel measures, in its units: `Motion.origin`.
    mass : float
        Of the first coordinate: that of all where there is one.
    walls : tuple of str
        Walls and contacts by the numbers with which observers see their impacts.
    contacts : tuple of str
        The soft ones, in the order of the kernel.
    damped : dict
        The sums of the power of dampers and memory, with their factors; without ``taken_at_once``.
    readings : tuple of Reading
    outputs : OutputsInKernel
    """

    tables: Tables
    kept: tuple[Any, ...]
    start: Floats
    half_drift: tuple[float, float, float]
    units: Units
    unit_mass: float
    history: ExponentialSum
    expected_power: float
    expected_in: Callable[[Sequence[int]], Floats] | None = None
    taken_at_once: float = 0.0
    named: tuple[Worked, ...] = ()
    taps: tuple[Tap, ...] = ()
    points: tuple[str, ...] = ()
    gauged: tuple[str, ...] = ()
    others: Floats
    law: Any = None
    frequency: float = 1.0
    place: float = 0.0
    mass: float = 1.0
    walls: tuple[str, ...] = ()
    contacts: tuple[str, ...] = ()
    damped: Mapping[Sum, float] = field(default_factory=lambda: {("power", ""): 1.0})
    readings: tuple[Reading, ...] = ()
    outputs: OutputsInKernel = field(default_factory=OutputsInKernel)

    @property
    def columns(self) -> dict[Sum, float]:
        """The sums of a row, each with its unit: its factor from that of the kernel."""
        (length, speed, time), count = (self.units.length, self.units.speed, self.units.time), self.tables.count
        energy, momentum = self.unit_mass * speed**2, self.unit_mass * speed
        forced, touched = [""] * count("forced"), [""] * bool(self.contacts)
        of_a_wall = [*zip(_OF_A_WALL, (1.0, speed, speed**2, energy, momentum), strict=True)]

        def each(quantity: str, whose: Iterable[str], unit: float) -> dict[Sum, float]:
            return {(quantity, own): unit for own in whose}

        kinds = {
            "x": each("x", self.points, length),
            "xx": each("x^2", self.points, length**2),
            "vv": each("v^2", self.points, speed**2),
            "u": each("u", self.gauged, length),
            "uu": each("u^2", self.gauged, length**2),
            "ww": each("w^2", self.gauged[: count("shown")], speed**2),
            "power": {("power", ""): energy / time},
            "works": {("work", own.name): own.mass * energy for own in self.named},
            "force": each("force", forced, momentum / time),
            "virial": each("virial", forced, energy),
            "hits": {(name, wall): unit for wall in self.walls for name, unit in of_a_wall},
            "soft": {**each("contact time", touched, time), **each("contact depth", touched, length)},
            "taps": {(tap.quantity, tap.circuit): tap.factor**2 * self.unit_mass for tap in self.taps},
            "energy": each("energy", ("first", "last"), energy),
            "x_end": each("x_end", self.points, length),
            "v_end": each("v_end", self.points, speed),
            "limits": each("limit", ("collapses", "halts"), 1.0),
            "early_xx": each("early x^2", self.points, length**2),
            "early_vv": each("early v^2", self.points, speed**2),
        }
        return {own: unit for kind in SUMS for own, unit in kinds[kind].items()}

    def sums(self, rows: Floats) -> dict[Sum, Floats]:
        """Those of the paths, from their rows."""
        return dict(zip(self.columns, rows.T, strict=True))

    @property
    def sees_v(self) -> bool:
        """Whether v^2 is summed at the observation; otherwise it is that of the mean before and after each kick."""
        return bool(self.tables.count("turns") or self.tables.count("paper"))

    @property
    def halves(self) -> dict[str, tuple[Sum, Sum]]:
        """By the mean squares of each coordinate, the sums over the window and over its first half."""
        lone = self.shape_of_state == (2,)
        return {
            f"{'' if lone else f'{point}_'}{of}_mean_square": ((f"{of}^2", point), (f"early {of}^2", point))
            for point in self.points
            for of in "xv"
        }

    @property
    def shape_of_state(self) -> tuple[int, ...]:
        """Of x and v of all points at a time."""
        points = len(self.points) + len(self.others)
        return (points, 2) if points > 1 else (2,)

    def start_of_record(self, states: Floats) -> Floats:
        """x and v at time 0 as the record has them."""
        of_coordinates = states.reshape(-1, 2, len(self.points)).swapaxes(1, 2) + np.array([self.place, 0.0])
        whole = np.concatenate([of_coordinates, self.others @ of_coordinates], axis=1)
        return whole.reshape(-1, *self.shape_of_state)

    def header_of(self, observer: Observer) -> list[float]:
        """Of an observer's array."""
        (length, speed), frequency, signal = self.units.state, self.frequency, observer.signal
        wall = 0.0 if math.isnan(signal.place) else signal.place / self.units.length
        if signal.outputs:
            frequency, wall = self.outputs.scale, self.outputs.exceeding(signal.outputs[0])
        speed = self.outputs.force if signal.peaks else speed * (signal.impulse or 1.0)
        return [length, speed, self.units.time, frequency, wall, LANES]

    def room_for_states(self, many: int) -> Kept:
        """A pool of states, each in the precision in which the kernel has it; only what is used of it takes memory."""
        points, rows, modes, of_memory, states, of_sources = self.numbers_kept
        return Kept(
            state=np.empty((many, 2 * points + MARKS)),
            memory=np.empty((many, (2 + GROUP) * rows + modes), of_memory),
            sources=np.empty((many, states), of_sources),
            step=np.empty(many, np.int64),
            next=np.empty(many, np.int64),
        )

    def expected_in_bins(self, edges: npt.NDArray[np.int64]) -> Floats:
        """The expected power between each two of some steps."""
        if self.expected_in is None:
            return np.full(edges.size - 1, self.expected_power)
        return self.expected_in(edges.tolist())

    @property
    def numbers_kept(self) -> tuple[int, int, int, npt.DTypeLike, int, npt.DTypeLike]:
        """All in the precision of the sweep."""
        kind, count = self.tables.sweep.dtype, self.tables.count
        states = count("states") + (count("walls") + 1 if count("resting") else 0)  # which rows rest
        return count("points"), count("rows"), count("modes"), kind, states, kind

    def states(self, settings: Settings, first: int, paths: int, stream: int) -> Floats:
        """x and v at time 0: of every path from ``first`` on if they are drawn, otherwise once for all."""
        if self.law is None or settings.start != "stationary":
            return self.start
        drawn = []
        for block in range(first // LANES, (first + paths) // LANES):  # each is the same whatever the others are
            generator = np.random.Generator(np.random.Philox(key=settings.seed, counter=[0, 0, stream, block]))
            drawn.append(np.hstack(self.law.drawn(generator, LANES)))
        size = len(self.points)
        usual, away = np.repeat([self.units.length, self.units.speed], size), np.repeat([self.place, 0.0], size)
        return np.asarray(np.concatenate(drawn) / usual - away)

    def kernel(self) -> Callable[..., None]:
        """The kernel, with all arguments that are the same for all blocks."""
        kernels, (integers, double, sweep) = KERNELS_BY_LANE if self.tables.by_lane else KERNELS, self.tables
        advance = kernels[str(sweep.dtype)]

        def run(states: Floats, first: int, blocks: int, settings: Settings, *given: Any) -> None:
            k0, k1, stream, halved, watched, record, stop, rows, *branches = given
            low, high = settings.window_steps
            table, *_alive = table_of(*branches)  # the arrays whose addresses the table has
            advance(
                integers, sweep, double, np.ascontiguousarray(states), len(states), first, blocks, settings.steps, low,
                high, k0, k1, stream, halved, watched, table, record, record.shape[0],
                len(self.points) + len(self.others), settings.record_every, record.shape[1], stop, rows,
            )  # fmt: skip
            if self.others.size:
                record[:, 1:, len(self.points) :] = self.others @ record[:, 1:, : len(self.points)]

        return run


@dataclass(frozen=True, eq=False)
class _Frame:
    """The rows of a system in the kernel's units, and what lies on each, at one step.

    Attributes
    ----------
    system : System
        As seen from the place from which the kernel measures.
    units : Units
    unit_mass, step : float
        The kernel's unit in kg, and the step in its units.
    rows : ndarray, shape (rows, coordinates)
    parts : list of dict
        What lies on each row, by the names of the parts.
    totals : list of Lowered
        All of it together.
    answers : ndarray, shape (rows,)
        Of dampers and memory to a change of each row's velocity.
    reduced : ndarray, shape (rows,)
        The mass that moves along each.
    jumps : ndarray, shape (rows, coordinates)
        Of velocities, per unit of each row's own.
    solve : ndarray, shape (coordinates, coordinates)
        Changes of velocities per impulse on the masses, with those answers.
    flight : float
        Frequency of the circle on which a lone coordinate turns; 0 of a straight drift.
    place : float
        From which the kernel measures; 0 of several coordinates.
    frequency : float
        That of flights, were they to turn.
    has_potential : bool
        Of one coordinate.
    """

    system: System
    units: Units
    unit_mass: float
    step: float
    rows: Floats
    parts: list[dict[str, Lowered]]
    totals: list[Lowered]
    answers: Floats
    reduced: Floats
    jumps: Floats
    solve: Floats
    flight: float
    place: float
    frequency: float
    has_potential: bool

    @property
    def at(self) -> Coordinates:
        """The coordinates of that system."""
        return self.system.coordinates

    @property
    def half_drift(self) -> tuple[float, float, float]:
        """As of `Parts`."""
        phase = 0.5 * self.flight * self.step
        if not self.flight:
            return 1.0, 0.5 * self.step * self.frequency, 0.0
        return math.cos(phase), math.sin(phase), math.sin(phase)

    @property
    def power(self) -> float:
        """The kernel's unit, in W."""
        return self.unit_mass * self.units.speed**2 / self.units.time

    def accelerations(self, forces: Floats) -> Floats:
        """Those of the coordinates under forces on them, in the kernel's units."""
        return self.unit_mass * self.at.accelerations(forces)


def _frame(plan: Plan, kernel_units: tuple[Units, float]) -> _Frame:
    system, (units, unit_mass) = plan.motion.centred, kernel_units
    at, parts = system.coordinates, dict(system.named())
    step = plan.settings.step / units.time
    found: dict[tuple[float, ...], dict[str, Lowered]] = {row: {} for row in at.numbers}
    for name, row in at.elongations.items():
        if not parts[name].inertia:
            found[tuple(row)][name] = lower(parts[name].per_mass(unit_mass), name, units, step)
    totals, g = [sum(own.values(), Lowered()) for own in found.values()], np.array([*found]).reshape(-1, len(at.names))
    printed = plan.settings.numerical_scheme.family == "grunwald"
    answers = np.array([0.0 if printed else answer_of(total, step) for total in totals])
    reduced = 1.0 / (g * unit_mass * at.accelerations(g)).sum(axis=1)
    jumps = unit_mass * at.accelerations(reduced[:, None] * g)
    solve = np.linalg.inv(at.mass / unit_mass + step * g.T @ (answers[:, None] * g))
    frequency = plan.motion.scales.flight_frequency * units.time
    # a lone coordinate turns between two kicks, or drifts straight; exact flights end on rigid walls only
    struck = bool(system.contacts) or any(part.noise == "impulses" for part in system.excitations.values())
    turns = plan.settings.scheme == "default" and not struck
    return _Frame(
        system, units, unit_mass, step, g, [*found.values()], totals, answers, reduced, jumps, solve,
        frequency if turns else 0.0, plan.motion.origin / units.length, frequency, plan.motion.potential is not None,
    )  # fmt: skip


def compose(
    plan: Plan, *, halved: bool = False, kernel_units: tuple[Units, float] | None = None,
    memory: Callable[[float], ExponentialSum] | None = None, is_read: bool = True,
) -> Parts:  # fmt: skip
    """The arguments of the kernel; with ``halved`` the excitation is that of half the step, summed in pairs.

    Systems that are to share blocks of paths have the ``kernel_units`` of one of them, and a ``memory`` whose sums, by
    the order, have the same rates.  Of a path alone nothing else is read: no sums, and no forces.

    Raises
    ------
    NotCoveredError
        If a part of the system cannot be simulated yet.
    ValueError
        If the system has more of something than the kernel holds.
    """
    settings, parts_of_step = plan.settings, 2 if halved else 1
    frame = _frame(plan, kernel_units or units_of(plan))
    at, units, totals, many = frame.at, frame.units, frame.totals, len(frame.at.names)
    memories = _memories(frame, settings, memory or sums_of(settings))
    noises, given, constant = _excitation(plan, frame, parts_of_step)
    walls = {name: wall for total in totals for name, wall in total.barriers}
    touched = [(n, name, contact) for n, total in enumerate(totals) for name, contact in total.contacts]
    place, dampers = sum(each.named.states for each in given), list[_Damped]()
    for n, (total, mass) in enumerate(zip(totals, frame.reduced.tolist(), strict=True)):
        for law in total.dampers:
            dampers.append(_Damped(law, n, mass, place))
            place += law.states
    shaken = [*_shaken(frame, settings)]
    named = (
        *(Worked(each.named.name, each.named.does) for each in given),
        *(Worked(each.law.name, each.law.does, each.mass) for each in dampers),
        *(Worked(each.name, "expected") for each in shaken),
    )
    follows = settings.numerical_scheme.family != "grunwald" and not touched
    rests = [float(follows and name in plan.motion.rested_on) for name in walls]
    rules = [_restitution(wall, name, units.speed) for name, wall in walls.items()]
    random = bool(len(noises) or shaken) or any(each.law.drawn()[0] > 0.0 for each in given)
    # without noise one path is the answer, and its last digits may be wanted
    single = random and settings.precision == "float32" and settings.memory_tolerance >= SINGLE_PRECISION
    kind = np.dtype("float32" if single else "float64")
    rough = [each for each in given if each.named.does == "nothing"]
    fresh = noises.T @ noises + sum(each.brought / frame.step * np.outer(each.row, each.row) for each in rough)
    fed, kept = (0.5 * float((fresh * inverse).sum()) for inverse in (frame.accelerations(np.eye(many)), frame.solve))
    # twice the energy that a kick along a row brings and dampers leave
    keep = np.einsum("ei,ij,ej->e", frame.rows, frame.solve, frame.rows)
    x0, v0 = start_of(plan)
    is_drawn = settings.start == "stationary" and (many > 1 or plan.motion.is_thermal)
    names = *walls, *(name for _, name, _ in touched)
    tables = _tables(
        frame, settings, memories, noises, given, constant, walls, rules, rests, dampers, touched, shaken,
        kind, parts_of_step, x0 / units.length,
    )  # fmt: skip
    whole = Parts(
        tables=tables,
        kept=(*(each.law.function for each in dampers), *rules),
        start=np.concatenate([x0 / units.length - frame.place, v0 / units.speed])[None, :],
        half_drift=frame.half_drift,
        units=units,
        unit_mass=frame.unit_mass,
        history=memories.history,
        expected_power=frame.power * fed,
        expected_in=_expected_in(frame, noises, rough),
        taken_at_once=frame.power * (fed - kept),
        law=plan.motion.drawn_about(x0) if is_drawn else None,
        named=named,
        damped={
            ("power", ""): 1.0,
            **{("work", each.name): (1.0 - keep[each.row] * frame.reduced[each.row]) / settings.step
               for each in shaken},
        },
        taps=memories.taps,
        points=at.names,
        others=at.rows[many:],
        gauged=tuple(f"row {n}" for n in range(tables.count("gauged"))),
        frequency=frame.frequency,
        place=frame.place,
        mass=float(at.mass[0, 0]),
        walls=names,
        contacts=tuple(name for _, name, _ in touched),
    )  # fmt: skip
    _check_sizes(whole.tables)
    if not is_read:
        return whole
    brought = frame.step * noises.T @ noises + sum(each.brought * np.outer(each.row, each.row) for each in given)
    lack = frame.accelerations(frame.solve @ brought)
    lacking = 0.25 * units.speed**2 * np.einsum("pi,ij,pj->p", at.rows, lack, at.rows)
    shaking = [
        (f"row {n}", 0.25 * each.mean_square(settings) * (units.speed / units.length) ** 2
         * (at.rows @ frame.solve @ frame.rows[n]) * (at.rows @ frame.jumps[n] / frame.reduced[n]))
        for each in shaken for n in (each.row,)
    ]  # fmt: skip
    modulated = [
        (frame.accelerations(frame.solve @ (each.brought * np.outer(each.row, each.row))), each.course)
        for each in given if each.course.size and each.brought > 0.0
    ]  # fmt: skip
    outputs = lowered_outputs(
        plan, frame.parts, frame.rows, frame.place, lack, frame.unit_mass / units.time**2, units.length, frame.step,
        {each.named.name: n for n, each in enumerate(given) if each.named.does == "feeds"},
        {each.law.name: (each.place, each.law.impulses[0]) for each in dampers if each.law.states}, modulated,
    )  # fmt: skip
    readings = *_readings(plan, whole, lacking, shaking), *_of_thermal_noise(plan, frame)
    return replace(whole, readings=readings, outputs=outputs)


def _expected_in(frame: _Frame, noises: Floats, rough: Sequence[_Given]) -> Callable[[Sequence[int]], Floats] | None:
    """The expected power between each two of some steps, where envelopes change it."""
    if not any(each.course.size for each in rough):
        return None
    own = [0.5 * each.brought / frame.step * float(each.row @ frame.accelerations(each.row)) for each in rough]
    white = 0.5 * float((noises * frame.accelerations(noises)).sum())

    def means(edges: Sequence[int]) -> Floats:
        found = np.full(len(edges) - 1, white)
        for power, each in zip(own, rough, strict=True):
            ends = np.concatenate([[0.0], np.cumsum(each.course if each.course.size else np.ones(edges[-1]))])
            whole = ends[np.minimum(edges, ends.size - 1)]
            found += power * np.diff(whole) / np.diff(edges)
        return frame.power * found

    return means


def _tables(
    frame: _Frame, settings: Settings, memories: _Memories, noises: Floats, given: Sequence[_Given], constant: Floats,
    walls: Mapping[str, Barrier], rules: Sequence[_Rule], rests: Sequence[float], dampers: Sequence[_Damped],
    touched: Sequence[tuple[int, str, Contact]], shaken: Sequence[_Shaken], kind: np.dtype[Any], parts_of_step: int,
    x0: Floats,
) -> Tables:  # fmt: skip
    """The tables of the kernel; long lists are those of sources, of noise with an envelope and of given forces."""
    at, step, many, g = frame.at, frame.step, len(frame.at.names), frame.rows
    struck = [at.numbers[tuple(at.elongations[name])] for name in walls]
    turned, soft = [each.row for each in dampers], [n for n, _, _ in touched]
    lean = g[struck] @ frame.solve
    heavy = 1.0 / np.einsum("wi,wi->w", lean, g[struck])
    springs = step * np.array([[*total.springs, *(0.0,) * 10][:10] for total in frame.totals]).reshape(-1, 10)
    sources_of, waves, long = list[int](), list[tuple[float, float]](), list[Floats]()
    for each in given:
        (kind_of_law, one, other), wave, own = each.law.told()
        sources_of += [kind_of_law, each.word, each.place, one, other, 0, len(long), len(own)]
        waves.append(wave)
        long.append(own)
    begun = [_drives(total, float(row @ x0), step, settings) for total, row in zip(frame.totals, g, strict=True)]
    drives = [len(long) + n if force.size else -1 for n, (force, _) in enumerate(begun)]
    long += [force for force, _ in begun]
    kicks, mass = springs.copy(), at.mass / frame.unit_mass
    if frame.flight:  # kicks have what the drift has not; rounding of k - k is nothing
        kicks[0, 1] -= step * mass[0, 0] * frame.flight**2
        kicks[abs(kicks) < 1e-12 * (abs(springs[0, 1]) + step * mass[0, 0] * frame.flight**2)] = 0.0
    printed = settings.numerical_scheme.family == "grunwald"
    near = settings.contact_tolerance / frame.units.length if printed else 0.0
    envelopes = [len(long) + n if each.squares.size else -1 for n, each in enumerate(shaken)]
    long += [each.squares for each in shaken]
    gauged = len(g) if len(at.rows) > many or at.pairs or shaken else 0
    counts = {
        "points": many, "rows": len(g), "gauged": gauged, "shown": len({*map(tuple, at.rows[many:])}),
        "walls": len(walls), "noises": len(noises), "sources": len(given), "dampers": len(dampers),
        "contacts": len(touched), "shaken": len(shaken), "taps": len(memories.taps), "modes": memories.modes,
        "resting": int(sum(rests)), "parts": parts_of_step, "substeps": _substeps(frame, touched),
        "states": sum(each.named.states for each in given) + sum(each.law.states for each in dampers),
        "turns": int(frame.flight > 0.0), "paper": int(printed), "forced": int(frame.has_potential),
    }  # fmt: skip
    (row_begin, row_at, row), (noise_begin, noise_at, noise), (source_begin, source_at, source_row) = (
        _sparse(rows)
        for rows in (g, math.sqrt(step) * noises, np.array([each.row for each in given]).reshape(-1, many))
    )
    lists = {
        "row_begin": row_begin, "row_at": row_at, "noise_begin": noise_begin, "noise_at": noise_at,
        "source_begin": source_begin, "source_at": source_at, "source": sources_of,
        "spring_kind": [max(map(_kind_of, both)) for both in zip(springs, kicks, strict=True)],
        "mode_count": memories.count, "mode_begin": memories.begin, "mode_table": memories.table,
        "turned": memories.turned, "turned_table": memories.turned_table,
        "drive": drives, "drive_steps": [force.size for force, _ in begun],
        "tapped": [tap.mode for tap in memories.taps],
        "wall_at": struck, "wall_kind": [rule.kind for rule in rules],
        "damper_at": turned, "damper_kind": [each.law.kind for each in dampers],
        "damper_place": [each.place for each in dampers],
        "contact_at": soft,
        "shaken_at": [each.row for each in shaken], "shaken_begin": envelopes,
        "shaken_steps": [each.squares.size for each in shaken],
    }  # fmt: skip
    numbers = {
        "step": step, "rounding": 4.0 * float(np.finfo(kind).eps), "row": row, "noise": noise,
        "source_row": source_row, "wave": waves, "smooth": [float(each.is_smooth) for each in given],
        "constant": step * constant, "origin": [frame.place],
        "early": np.full(many, sum(early / m for (_, early), m in zip(begun, frame.reduced, strict=True))),
        "spring": springs, "kick": kicks,
        "damping": 2.0 * frame.answers, "answer": frame.answers, "near": memories.near, "solve": frame.solve,
        "side": [wall.inwards for wall in walls.values()],
        "place": [wall.position + near * wall.inwards for wall in walls.values()],
        "restitution": [rule.numbers for rule in rules],
        "jump": frame.jumps[struck], "along": frame.jumps[struck] @ g.T,
        "reduced": frame.reduced[struck], "rests": rests, "lean": heavy[:, None] * lean, "heavy": heavy, "mass": mass,
        "damper": [each.numbers for each in dampers],
        "damper_jump": frame.jumps[turned], "damper_along": frame.jumps[turned] @ g.T,
        "contact": [[*numbers_of(contact), frame.reduced[n]] for n, _, contact in touched],
        "contact_jump": frame.jumps[soft], "contact_along": frame.jumps[soft] @ g.T,
        "shaken": [[each.square, 0.5 * each.square / frame.reduced[each.row]] for each in shaken],
        "turn": _turn(frame, kind) if frame.flight else np.zeros(7),
        "modes": memories.numbers, "turns_of_modes": memories.turns,
    }  # fmt: skip
    return packed(counts, lists, numbers, long, kind)


def _turn(frame: _Frame, kind: np.dtype[Any]) -> Floats:
    """The numbers of a drift on a circle."""
    w, numbers = frame.flight, list[float]()
    for phase in (0.5 * w * frame.step, w * frame.step):
        exact = -2.0 * math.sin(0.5 * phase) ** 2, math.sin(phase) / w, math.sin(phase) * w
        numbers += exact if kind == np.float64 else turned_in_single(*exact)
    return np.array([*numbers, w])


def _drives(total: Lowered, x0: float, step: float, settings: Settings) -> tuple[Floats, float]:
    """Riemann and Liouville's force x(0) t^-alpha / Gamma(1 - alpha) in each step, and what it moves before the first.

    With the weights of the scheme.
    """
    force, early = np.zeros(0), 0.0
    if settings.derivative == "caputo" or x0 == 0.0:
        return force, early
    for order, c in total.springpots:
        scheme = settings.numerical_scheme
        own = c * step**-order * x0 * direct(scheme.family, order, settings.steps + GROUP)
        early += scheme.early_displacement(order, float(own[0]), step)
        force = own + (force if force.size else 0.0)
    return force, early


def _substeps(frame: _Frame, touched: Sequence[tuple[int, str, Contact]]) -> int:
    """Of half a drift with a contact, such that the shortest contact has many."""
    needed = 1
    for n, name, contact in touched:
        free = replace(contact, stiffness=contact.stiffness / frame.reduced[n])
        parts = math.ceil(min(0.5 * frame.step / (contact_time(free, _TOUCHING_SPEED) / SUBSTEPS), 2.0 * MOST_SUBSTEPS))
        if parts > MOST_SUBSTEPS:
            raise ValueError(
                f"{name} is so stiff that half a step would need more than {MOST_SUBSTEPS} parts: use a Barrier, "
                "which is the limit."
            )
        needed = max(needed, parts)
    return needed


@dataclass(frozen=True, eq=False)
class _Rule:
    """A restitution in the kernel: its kind or an address, three numbers, and the function of the user, if any."""

    kind: int
    numbers: tuple[float, float, float]
    law: Any = None


def _restitution(wall: Barrier, name: str, unit: float) -> _Rule:
    """The rule of a wall; ``unit`` is the kernel's unit of speed."""
    law = wall.restitution
    if isinstance(law, PowerRestitution):
        return _Rule(POWER_LAW, (law.restitution, law.speed / unit, law.exponent))
    if isinstance(law, Restitution):
        own = restitution_of(type(law).formula, name, tuple(law.values))
    elif callable(law):
        own = restitution_of(law, name)
    else:
        return _Rule(FIXED, (law, 0.0, 0.0))
    return _Rule(own.address, (unit, 0.0, 0.0), own)


@dataclass(frozen=True, eq=False)
class _Shaken:
    """A white noise that multiplies an elongation: the variance of its impulses, and its envelope in each step.

    Attributes
    ----------
    row : int
    square : float
    squares : ndarray
        Of the envelope in each step; empty without one.
    name : str
    """

    row: int
    square: float
    squares: Floats
    name: str

    def mean_square(self, settings: Settings) -> float:
        """The mean variance in the window."""
        return self.square * float(self.squares[slice(*settings.window_steps)].mean() if self.squares.size else 1.0)


def _shaken(frame: _Frame, settings: Settings) -> Iterator[_Shaken]:
    for n, total in enumerate(frame.totals):
        if total.parametric > 0.0:
            yield _Shaken(n, frame.step * total.parametric, np.zeros(0), f"parametric {n}")
        for noise in total.modulated:
            squares = noise.squares(frame.units, frame.step, settings.steps)
            yield _Shaken(n, frame.step * noise.intensity, squares, f"parametric {noise.name}")


def _check_sizes(tables: Tables) -> None:
    count = tables.count
    for what, has, most in (
        ("masses", count("points"), MOST_POINTS), ("points and pairs of ends", count("rows"), kernel.MOST_ROWS),
        ("walls and contacts", count("walls") + count("contacts"), MOST_WALLS),
        ("sources of white noise", count("noises") + count("shaken"), kernel.MOST_NOISES),
        ("sources of other excitation", count("sources"), excitations.MOST_SOURCES),
        ("nonlinear dampers and forces", count("dampers"), kernel.MOST_DAMPERS),
        ("memory modes", count("modes"), MOST_MODES), ("circuits", count("taps"), kernel.MOST_TAPS),
        ("states of noise, of what yields and of walls", count("states") + count("walls") + 1, kernel.MOST_STATES),
    ):  # fmt: skip
        if has > most:
            raise ValueError(f"the system has {has} {what}, but the kernel holds at most {most}.")


def units_of(plan: Plan) -> tuple[Units, float]:
    """Powers of two near the largest length, the shortest time and the usual mass of the motion."""
    motion, scales, (x0, v0) = plan.motion, plan.motion.scales, start_of(plan)
    walls = [abs(wall.position) for wall in motion.centred.walls.values()]
    longest = max(scales.length, *np.abs(x0 - motion.origin), *(np.abs(v0) / scales.fastest_rate), *walls)
    masses = np.diag(plan.system.coordinates.mass)
    return Units.near(longest, scales.fastest_rate), 2.0 ** round(float(np.log2(masses).mean()))


def _kind_of(springs: Floats) -> int:
    degree = max((n for n, k in enumerate(springs) if k != 0.0), default=-1)
    return NO_SPRING if degree < 0 else LINEAR if degree <= 1 else CUBIC if degree <= 3 else NINTH


def start_of(plan: Plan) -> tuple[Floats, Floats]:
    """x(0) and x'(0) in the order of the coordinates, in m and m/s."""
    if plan.settings.initial_position is None:
        raise ValueError("initial_position of a stationary start is known after its pilot runs only.")
    of = plan.system.coordinates.places_of
    return of(plan.settings.initial_position), of(plan.settings.initial_velocity)


def _sparse(rows: Floats) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], Floats]:
    begin = np.concatenate([[0], np.cumsum((rows != 0.0).sum(axis=1))]).astype(np.int64)
    return begin, np.nonzero(rows)[1].astype(np.int64), rows[rows != 0.0]


@dataclass(frozen=True, eq=False)
class _Memories:
    """The modes of the springpots and arms of each row; rows with the same parts share their numbers.

    Attributes
    ----------
    begin, count, turned : ndarray of int
        Of each row: its first mode, how many there are, and how many modes of circuits with a coil follow.
    table, turned_table : ndarray of int
        Where their numbers begin.
    near : ndarray, shape (rows, GROUP, 5)
        Weights of the newest increments in each step of a group.
    numbers, turns : ndarray
        Of the modes, and of circuits with a coil.
    modes : int
        How many numbers all of them keep.
    history : ExponentialSum
        All modes together.
    taps : tuple of Tap
    """

    begin: npt.NDArray[np.int64]
    count: npt.NDArray[np.int64]
    turned: npt.NDArray[np.int64]
    table: npt.NDArray[np.int64]
    turned_table: npt.NDArray[np.int64]
    near: Floats
    numbers: Floats
    turns: Floats
    modes: int
    history: ExponentialSum
    taps: tuple[Tap, ...]


def _memories(frame: _Frame, settings: Settings, sums: Callable[[float], ExponentialSum]) -> _Memories:
    totals, step, tables = frame.totals, frame.step, dict[Any, tuple[int, int, Any, ExponentialSum]]()
    begin, count, table, turned, turned_table = (np.zeros(len(totals), np.int64) for _ in range(5))
    near = np.zeros((len(totals), GROUP, 5))
    numbers, turns = (list[Any]([np.zeros(0)]) for _ in range(2))
    modes, histories, taps = 0, [], list[Tap]()
    for e, total in enumerate(totals):
        key = total.springpots, total.arms
        if key not in tables:
            own, history = memory_of(*key, settings.numerical_scheme, step, settings, sums)
            tables[key] = sum(part.size for part in numbers), sum(part.size for part in turns), own, history
            numbers.append(np.hstack([own.powers.reshape(-1, GROUP), own.weights.reshape(-1, GROUP)]).ravel())
            turns.append(own.turns)
        table[e], turned_table[e], own, history = tables[key]
        begin[e], count[e], turned[e] = modes, own.powers.size // GROUP, own.turns.size // NUMBERS_OF_TURN
        taps += taps_of(total.arms, own, history, step, modes)
        modes += int(count[e] + 2 * turned[e])
        histories.append(history)
        new, old, r1, r2, r3 = (float(number) for number in own[2:7])
        near[e] = [[old, new, 0, 0, 0], [0, r1, new, 0, 0], [0, r2, r1, new, 0], [0, r3, r2, r1, new]]
    together = ExponentialSum(
        np.concatenate([np.zeros(0), *(history.rates for history in histories)]),
        np.concatenate([np.zeros(0), *(history.weights for history in histories)]),
        max((history.relative_error for history in histories), default=0.0), 1.0, float(settings.steps + 1),
    )  # fmt: skip
    return _Memories(
        begin, count, turned, table, turned_table, near, np.concatenate(numbers), np.concatenate(turns), modes,
        together, tuple(taps),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Damped:
    """A damper on a row, the mass that moves along it, and the first place of its states."""

    law: Damper
    row: int
    mass: float
    place: int

    @property
    def numbers(self) -> list[float]:
        """As the kernel has them, the reduced mass last."""
        own = [*(impulse / self.mass for impulse in self.law.impulses), *self.law.numbers]
        return [*own, *(0.0,) * (laws.NUMBERS_OF_DAMPER - 1 - len(own)), self.mass]


@dataclass(frozen=True, eq=False)
class _Given:
    """A source of excitation: its law, its name, the row on which it acts, and its place in the kernel.

    ``brought`` is the variance of what it brings anew within each step; of a smooth force the impulses of neighbouring
    steps are nearly alike.  ``course`` is that of each step over this, where an envelope changes it.
    """

    named: sources.Named
    law: Any
    row: Floats
    brought: float
    is_smooth: bool
    course: Floats
    word: int
    place: int


def _excitation(plan: Plan, frame: _Frame, parts_of_step: int) -> tuple[Floats, list[_Given], Floats]:
    """Rows of white noise with the roots of the intensities; sources of other noise; and the constant force."""
    many, unit_mass, step, parts = len(frame.at.names), frame.unit_mass, frame.step, dict(frame.system.named())
    white, given, constant = [], list[tuple[sources.Named, Floats, float | None]](), np.zeros(many)
    for name, row in frame.at.forces.items():
        part = parts[name]
        row = -row / unit_mass if part.of_ground else row  # the sign is in what is lowered
        own = part.per_mass(1.0 if part.of_ground else unit_mass)
        more = lower(own, name, frame.units, step).over(plan.settings.steps)
        if more.white > 0.0:
            white.append(math.sqrt(more.white) * row)
        constant -= sum(more.springs[:1]) * row
        noises = *more.sources, *modulated_noise(more, frame.units, step, plan.settings.steps)
        given += [(named, row, None) for named in noises]
    if (thermal := plan.system.thermal) is not None:
        name, warm = plan.system.name_of(thermal), _temperature(thermal, frame)
        for n, (total, row) in enumerate(zip(frame.totals, frame.rows, strict=True)):
            if total.remembers:
                own, hot = _of_row(name, n), replace(total, temperature=warm)
                noise = thermal_noise(own, hot, step, plan.settings.steps, parts_of_step)
                given.append((noise, row, 4.0 * step * warm * rough_answer_of(total, step)))
            elif total.springpots:
                white.append(math.sqrt(2.0 * warm * total.dashpots) * row)
    # each source has counter words of its own, and a place for its states
    placed, word, place = list[_Given](), kernel.MOST_NOISES, 0
    for named, row, brought in given:
        law = named.make(parts_of_step)
        whole, course = brought, np.zeros(0)
        if whole is None:  # some laws take long to make
            whole, course = _drawn(law if parts_of_step == 1 else named.make(1), plan.settings.window_steps)
        smooth = brought is None and named.does == "feeds"
        placed.append(_Given(named, law, row, whole, smooth, course, word, place))
        word, place = word + excitations.WORDS, place + named.states
    return np.array(white).reshape(-1, many), placed, constant


def _of_row(noise: str, row: int) -> str:
    """The name of the force of a matched noise on a row."""
    return f"{noise} of row {row}"


def _temperature(thermal: ThermalNoise, frame: _Frame) -> float:
    return lower(thermal.per_mass(frame.unit_mass), "", frame.units, frame.step).temperature


def _of_thermal_noise(plan: Plan, frame: _Frame) -> Iterator[Reading]:
    """The power of matched noise: measured of that with memory, and its known mean of the white noise of dashpots."""
    if (thermal := plan.system.thermal) is not None:
        name, warm = plan.system.name_of(thermal), _temperature(thermal, frame)
        works, white = dict[Sum, float](), 0.0
        for n, (total, mass) in enumerate(zip(frame.totals, frame.reduced, strict=True)):
            if total.remembers:
                works["work", _of_row(name, n)] = 1.0
            else:
                white += warm * total.dashpots / float(mass)
        yield Reading(f"{name}_power", works, "time", frame.power * white)


def _drawn(law: Any, window: tuple[int, int]) -> tuple[float, Floats]:
    """Variance of what a source draws anew for the impulse of a step: its mean over the window, and that of each step
    over this, which is empty without an envelope.
    """
    size, roots = law.drawn()
    mean = float((roots[slice(*window)] ** 2).mean()) if roots.size else 1.0
    return size * mean, np.asarray(roots**2 / mean if mean > 0.0 else np.zeros(0))


def _readings(plan: Plan, parts: Parts, lacking: Floats, shaking: Sequence[tuple[str, Floats]]) -> Iterator[Reading]:
    """Every result but the balance of energy.

    ``lacking``: v^2 is summed as the square of the mean of the velocities before and after a kick, which lacks a
    quarter of their difference squared, by noise and by the dampers that take it again.  With S of `compose`,
    M and the covariance B of the noise's impulse it is p S B M^-1 p / 4 of a point with the row p: exact for matched
    noise of dashpots, where the square alone is that of the temperature times S, and for one mass with a dashpot and
    white noise.  ``shaking``: the same of noise that multiplies an elongation, per square of that, by its row.
    """
    system, at = plan.system, plan.system.coordinates
    gauged = dict(zip(at.numbers, parts.gauged, strict=False))
    everywhere = zip(at.beginnings, at.points, at.rows.tolist(), lacking, strict=True)
    for i, (called, point, own, lack) in enumerate(everywhere):
        letters, of = ("xv", point) if point in at.names else ("uw", gauged[tuple(own)])
        away = plan.motion.origin  # from where the kernel measures x
        squares = {(f"{letters[0]}^2", of): 1.0, (letters[0], of): 2.0 * away}
        yield Reading(f"{called}x_mean", {(letters[0], of): 1.0}, added=away)
        yield Reading(f"{called}x_mean_square", squares, added=away**2)
        above = {(f"{letters[1]}^2", of): 1.0, **{("u^2", row): float(lacks[i]) for row, lacks in shaking}}
        if parts.sees_v:
            above, lack = {("v^2", of): 1.0}, 0.0
        yield Reading(f"{called}v_mean_square", above, added=float(lack))
        if plan.motion.potential is not None and system.stiffness > 0.0:
            share = system.natural_frequency**-2
            whole = {**squares, **{own: share * factor for own, factor in above.items()}}
            yield Reading("amplitude_mean_square", whole, added=away**2 + share * float(lack))
    for pair, own_row in at.pairs.items():
        row = gauged[tuple(own_row.tolist())]
        yield Reading(f"{pair}_elongation_mean", {("u", row): 1.0})
        yield Reading(f"{pair}_elongation_mean_square", {("u^2", row): 1.0})
    for name in system.stops:
        yield from _impacts(f"{name}_", [name])
        yield Reading(f"{name}_power", {("loss", name): 1.0}, "time")
        yield Reading(f"{name}_force_mean", {("momentum", name): 1.0}, "time")
    if parts.taps and not system.thermal:  # noise of a resistor is beside the mode, in the matched force
        for tap in parts.taps:
            own, name = (tap.quantity, tap.circuit), f"{tap.circuit}_{tap.quantity}"
            yield Reading(f"{name}_mean_square", {own: 1.0}, "groups")
            if tap.quantity == "current" and (count := system.counts.get(tap.circuit)):
                yield Reading(f"{name}_of_one_mean_square", {own: 1.0 / count**2}, "groups")
        loads: dict[Sum, float] = {(part.of_load, name): 1.0 / part.load for name, part in system.circuits.items()}
        yield Reading("harvested_power", loads, "groups")
    if any(part.dissipates and "damping" in part.powers for part in system.parts):
        yield Reading("damping_power", parts.damped, added=parts.taken_at_once)
    if parts.tables.count("forced"):  # of a lone mass: its amplitude, impacts on all stops, the force of its dampers
        if system.stiffness > 0.0:
            share = system.natural_frequency**-2
            ends = ((end, parts.points[0]) for end in _ENDS)
            yield Reading("amplitude_mean_square_end", {}, "one", squares=dict(zip(ends, (1.0, share), strict=True)))
        if parts.walls:
            yield from _impacts("", parts.walls)
        if has_damping(system):
            yield Reading("damping_force_mean", {("force", ""): 1.0})
            yield Reading("damping_virial", {("virial", ""): 1.0, ("force", ""): plan.motion.origin})
        if parts.contacts:
            yield Reading("contact_share", {("contact time", ""): 1.0}, "time")
            yield Reading("contact_penetration", {("contact depth", ""): 1.0}, "one")
    for called, shares in at.beginnings.items():
        x, v = ({(end, of): s for of, s in zip(at.names, shares, strict=True) if s} for end in _ENDS)
        yield Reading(f"{called}x_mean_end", x, "one")
        yield Reading(f"{called}x_mean_square_end", x, "one", power=2)
        yield Reading(f"{called}v_mean_square_end", v, "one", power=2)


def _impacts(begin: str, walls: Sequence[str]) -> Iterator[Reading]:
    """Rate and speeds of the impacts on some walls together."""
    impacts, speeds, squares = (tuple((of, wall) for wall in walls) for of in _OF_A_WALL[:3])
    yield Reading(f"{begin}impact_rate", dict.fromkeys(impacts, 1.0), "time")
    yield Reading(f"{begin}impact_speed_mean", dict.fromkeys(speeds, 1.0), impacts)
    yield Reading(f"{begin}impact_speed_mean_square", dict.fromkeys(squares, 1.0), impacts)


_f32 = np.float32


@lru_cache(maxsize=64)  # the levels of a run ask for the same few steps again and again
def turned_in_single(loss: float, sine: float, back: float) -> tuple[float, float, float]:
    """The numbers of a rotation in single precision: those neighbours that change an energy least in many steps.

    The energy grows by the determinant in every step, and the ratio of the two sines shares it among x and v.
    """
    losses, sines, backs = (
        _near(number).reshape(shape) for number, shape in zip((loss, sine, back), _AXES, strict=True)
    )
    lost, one, two = losses.astype(float), sines.astype(float), backs.astype(float)
    change = _MANY * abs(lost * (2.0 + lost) + one * two) + abs(one / sine - two / back)
    i, j, k = np.unravel_index(np.argmin(change), change.shape)
    return float(losses[i, 0, 0]), float(sines[0, j, 0]), float(backs[0, 0, k])


def _near(number: float) -> npt.NDArray[np.float32]:
    """Single numbers near one, from a millionth below it to a millionth above."""
    return (number * (1.0 + np.arange(-_TRIED, _TRIED + 1) * 2.0**-24)).astype(_f32)
