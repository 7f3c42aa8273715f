"""From the plan of a system of several masses to the arguments of its kernel, and from its sums to results.

Each part is lowered as in a system of one mass (`springpot.simulation.lowering.parts.lower`), per unit of mass of the
kernel, and what it adds goes to its row: parts between the same two ends share one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.memory import ExponentialSum
from springpot.problem.coordinates import Coordinates
from springpot.problem.parts import Barrier, Contact, ThermalNoise
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.walls import PowerRestitution, Restitution, Stop
from springpot.simulation.kernel import excitations, forces, hysteresis, laws, offspring, sources, watch
from springpot.simulation.kernel import advance as kernel
from springpot.simulation.kernel.branches import NO_BRANCHES
from springpot.simulation.kernel.compiled import kernel_in
from springpot.simulation.kernel.lanes import GROUP, LANES
from springpot.simulation.kernel.questions import Start
from springpot.simulation.kernel.motion import CUBIC, LINEAR, NINTH, NO_SPRING
from springpot.simulation.kernel.of_users import force_of, restitution_of
from springpot.simulation.kernel.rest import MOST_POINTS, MOST_WALLS
from springpot.simulation.kernel.striking import FIXED, POWER
from springpot.simulation.kernel.tables import Tables, packed
from springpot.simulation.kernel.turning import NUMBERS
from springpot.simulation.kernel.watching import Observer
from springpot.simulation.lowering.composed import Composed
from springpot.simulation.lowering.felt import lowered_felt
from springpot.simulation.lowering.kernel_units import Units
from springpot.simulation.lowering.memory import Tap, answer_of, memory_of, rough_answer_of, taps_of
from springpot.simulation.lowering.parts import (
    MOST_SUBSTEPS,
    SUBSTEPS,
    Lowered,
    Named,
    contact_time,
    lower,
    modulated_noise,
    numbers_of,
    thermal_noise,
)
from springpot.simulation.lowering.precision import is_random
from springpot.simulation.lowering.readings import Reading
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import SINGLE_PRECISION, Settings

_ENDS = "x_end", "v_end"
_TOUCHING_SPEED = 6.0  # in the kernel's units, which are those of the motion: of a rare flight
_OF_A_WALL = "impacts", "speeds", "squares", "loss", "momentum"


@dataclass(frozen=True, eq=False, kw_only=True)
class PartsOfSeveral(Composed):
    """The arguments of the kernel of several masses.

    Attributes
    ----------
    tables : Tables
    kept : tuple
        Functions of the user, whose addresses the tables have.
    unit_mass : float
        The kernel's unit, in kg.
    taken_at_once : float
        What dampers and memory take of the expected power within the kicks that bring it; the sums of a run do not have
        it.
    moved : tuple of float
        The mass in which the work of each named source is counted, in that of the kernel.
    points, gauged : tuple of str
        Names in the columns: of the coordinates, and of all rows.
    others : ndarray, shape (other points, coordinates)
        The rows of points that are no coordinates.
    """

    tables: Tables
    kept: tuple[Any, ...]
    unit_mass: float
    taken_at_once: float
    moved: tuple[float, ...]
    points: tuple[str, ...]
    gauged: tuple[str, ...]
    others: Floats

    @property
    def columns(self) -> dict[str, float]:
        """The numbers of a row by name, each with the factor from the kernel's units."""
        length, speed, time = self.units.length, self.units.speed, self.units.time
        energy = self.unit_mass * speed**2
        of_walls = 1.0, speed, speed**2, energy, self.unit_mass * speed
        return {
            **{f"x of {point}": length for point in self.points},
            **{f"x^2 of {point}": length**2 for point in self.points},
            **{f"v^2 of {point}": speed**2 for point in self.points},
            **{f"u of {row}": length for row in self.gauged},
            **{f"u^2 of {row}": length**2 for row in self.gauged},
            **{f"w^2 of {row}": speed**2 for row in self.gauged[: self.tables.count("shown")]},
            "power": energy / time,
            **{f"work of {each.name}": mass * energy for each, mass in zip(self.named, self.moved, strict=True)},
            **{
                f"{wall} {name}": factor
                for wall in self.walls
                for name, factor in zip(_OF_A_WALL, of_walls, strict=True)
            },
            **{tap.name: tap.factor**2 * self.unit_mass for tap in self.taps},
            "energy_first": energy,
            "energy_last": energy,
            **{f"x_end of {point}": length for point in self.points},
            **{f"v_end of {point}": speed for point in self.points},
            "collapses": 1.0,
            "halts": 1.0,
            **{f"early x^2 of {point}": length**2 for point in self.points},
            **{f"early v^2 of {point}": speed**2 for point in self.points},
        }

    @property
    def halves(self) -> dict[str, tuple[str, str]]:
        """Of x and v of every coordinate."""
        return {
            f"{point}_{name}_mean_square": (f"{name}^2 of {point}", f"early {name}^2 of {point}")
            for point in self.points
            for name in "xv"
        }

    @property
    def shape_of_state(self) -> tuple[int, ...]:
        """Of x and v of all points at a time."""
        return len(self.points) + len(self.others), 2

    def start_of_record(self, states: Floats) -> Floats:
        """x and v at time 0 as the record has them."""
        of_coordinates = states.reshape(-1, 2, len(self.points)).swapaxes(1, 2)
        return np.concatenate([of_coordinates, self.others @ of_coordinates], axis=1)

    def frequency_and_wall(self, observer: Observer) -> tuple[float, float]:
        """No frequency, and the place of the observer's wall."""
        return 1.0, observer.place / self.units.length

    @property
    def numbers_kept(self) -> tuple[int, int, int, npt.DTypeLike, int, npt.DTypeLike]:
        """All in the precision of the sweep."""
        kind, count = self.tables.sweep.dtype, self.tables.count
        states = count("states") + (count("walls") + 1 if count("resting") else 0)  # which rows rest
        return count("points"), count("rows"), count("modes"), kind, states, kind

    def states(self, settings: Settings, first: int, paths: int, stream: int) -> Floats:
        """x and v at time 0: of every path from ``first`` on if they are drawn, otherwise once for all."""
        if self.law is None or settings.start != "stationary":
            return self.start.states
        drawn = []
        for block in range(first // LANES, (first + paths) // LANES):  # each is the same whatever the others are
            normals = np.random.Generator(np.random.Philox(key=settings.seed, counter=[0, 0, stream, block]))
            drawn.append(np.hstack(self.law.drawn(normals, LANES)))
        size = len(self.points)
        return np.asarray(np.concatenate(drawn) / np.repeat([self.units.length, self.units.speed], size))

    def kernel(self) -> Callable[..., None]:
        """The kernel, with all arguments that are the same for all blocks."""

        advance, (integers, double, sweep) = kernel_in(self.tables.sweep.dtype), self.tables

        def run(states: Floats, first: int, blocks: int, settings: Settings, *given: Any) -> None:
            k0, k1, stream, halved, observers, record, stop, rows, *branches = given
            (low, high), watched = settings.window_steps, watch.table_of(observers)
            table, *kept = offspring.table_of(*(branches or (NO_BRANCHES,)))
            states = np.ascontiguousarray(states)
            arrays = (integers, sweep, double, states)
            advance(
                *(array.ctypes.data for array in arrays), len(states), first, blocks, settings.steps, low, high,
                int(k0), int(k1), stream, halved, watched.ctypes.data, table.ctypes.data, record.ctypes.data,
                record.shape[0], len(self.points) + len(self.others), settings.record_every, record.shape[1],
                stop.ctypes.data, rows.ctypes.data,
            )  # fmt: skip
            record[:, :, len(self.points) :] = self.others @ record[:, :, : len(self.points)]

        return run


@dataclass(frozen=True, eq=False)
class _Frame:
    """The rows of a system in the kernel's units, and what lies on each, at one step.

    Attributes
    ----------
    at : Coordinates
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
    """

    at: Coordinates
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

    @property
    def power(self) -> float:
        """The kernel's unit, in W."""
        return self.unit_mass * self.units.speed**2 / self.units.time

    def accelerations(self, forces: Floats) -> Floats:
        """Those of the coordinates under forces on them, in the kernel's units."""
        return self.unit_mass * self.at.accelerations(forces)


def _frame(plan: Plan) -> _Frame:
    at, parts, (units, unit_mass) = plan.system.coordinates, dict(plan.system.named()), _units(plan)
    step = plan.settings.step / units.time
    found: dict[tuple[float, ...], dict[str, Lowered]] = {row: {} for row in at.numbers}
    for name, row in at.elongations.items():
        if not parts[name].inertia:
            found[tuple(row)][name] = lower(parts[name].per_mass(unit_mass), name, units, step)
    totals, g = [sum(own.values(), Lowered()) for own in found.values()], np.array([*found]).reshape(-1, len(at.names))
    answers = np.array([answer_of(total, step) for total in totals])
    reduced = 1.0 / (g * unit_mass * at.accelerations(g)).sum(axis=1)
    jumps = unit_mass * at.accelerations(reduced[:, None] * g)
    solve = np.linalg.inv(at.mass / unit_mass + step * g.T @ (answers[:, None] * g))
    return _Frame(at, units, unit_mass, step, g, [*found.values()], totals, answers, reduced, jumps, solve)


def compose_several(plan: Plan, parts_of_step: int) -> PartsOfSeveral:
    """The arguments of the kernel; with 2 parts of a step the excitation is that of half the step, summed in pairs.

    Raises
    ------
    NotCoveredError
        If a part of the system cannot be simulated yet.
    ValueError
        If the system has more of something than the kernel holds.
    """
    settings, frame = plan.settings, _frame(plan)
    at, units, totals, many = frame.at, frame.units, frame.totals, len(frame.at.names)
    memories = _memories(frame, settings)
    noises, given, constant = _excitation(plan, frame, parts_of_step)
    walls = {name: wall for total in totals for name, wall in total.barriers}
    touched = [(n, name, contact) for n, total in enumerate(totals) for name, contact in total.contacts]
    dampers = [*_dampers(frame, sum(each.named.states for each in given))]
    shaken = [*_shaken(frame, settings)]
    named = *(each.named for each in given), *(each.named for each in dampers), *(each.named for each in shaken)
    rests = [float(name in plan.motion.rested_on and not touched) for name in walls]
    rules = [_restitution(wall, name, units.speed) for name, wall in walls.items()]
    random = bool(len(noises) or shaken) or any(is_random(each.law) for each in given)
    kind = np.dtype(_precision(settings, random))
    fed = 0.5 * float((noises * frame.accelerations(noises)).sum())
    kept = 0.5 * float(np.trace(noises @ frame.solve @ noises.T)) if len(noises) else 0.0
    # twice the energy that a kick along a row brings and dampers leave
    keep = np.einsum("ei,ij,ej->e", frame.rows, frame.solve, frame.rows)
    x0, v0 = start_of(plan)
    names = *walls, *(name for _, name, _ in touched)
    tables = _tables(
        frame, settings, memories, noises, given, constant, walls, rules, rests, dampers, touched, shaken,
        kind, parts_of_step,
    )  # fmt: skip
    whole = PartsOfSeveral(
        tables=tables,
        kept=(*(each.law for each in dampers), *rules),
        start=Start(np.concatenate([x0 / units.length, v0 / units.speed])[None, :], 0.0),
        half_drift=(1.0, 0.5 * frame.step, 0.0),
        units=units,
        unit_mass=frame.unit_mass,
        history=memories.history,
        expected_power=frame.power * fed,
        taken_at_once=frame.power * (fed - kept),
        law=plan.motion.drawn_about(x0) if settings.start == "stationary" else None,
        named=named,
        moved=(*(1.0 for _ in given), *(each.numbers[-1] for each in dampers), *(1.0 for _ in shaken)),
        damped={
            "power": 1.0,
            **{f"work of {each.named.name}": (1.0 - keep[each.row] * frame.reduced[each.row]) / settings.step
               for each in shaken},
        },
        taps=memories.taps,
        points=at.names,
        others=at.rows[many:],
        gauged=tuple(f"row {n}" for n in range(len(totals))),
        walls=names,
        contacts=tuple(name for _, name, _ in touched),
        struck={name: f"{name} impacts" for name in names},
    )  # fmt: skip
    _check_sizes(whole.tables)
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
    felt = lowered_felt(
        plan, frame.parts, frame.rows, lack, frame.unit_mass / units.time**2, units.length, frame.step, whole.named,
        modulated,
    )  # fmt: skip
    readings = *_readings(plan, whole, lacking, shaking), *_of_thermal_noise(plan, whole, frame)
    return replace(whole, readings=readings, felt=felt)


def _tables(
    frame: _Frame, settings: Settings, memories: _Memories, noises: Floats, given: Sequence[_Given], constant: Floats,
    walls: Mapping[str, Barrier], rules: Sequence[_Rule], rests: Sequence[float], dampers: Sequence[_Damper],
    touched: Sequence[tuple[int, str, Contact]], shaken: Sequence[_Shaken], kind: np.dtype[Any], parts_of_step: int,
) -> Tables:  # fmt: skip
    """The tables of the kernel; long lists are those of sources, of noise with an envelope and of given forces."""
    at, step, many, g = frame.at, frame.step, len(frame.at.names), frame.rows
    struck = [at.numbers[tuple(at.elongations[name])] for name in walls]
    turned, soft = [each.row for each in dampers], [n for n, _, _ in touched]
    lean = g[struck] @ frame.solve
    heavy = 1.0 / np.einsum("wi,wi->w", lean, g[struck])
    springs = step * np.array([[*total.springs, *(0.0,) * 10][:10] for total in frame.totals]).reshape(-1, 10)
    sources_of, waves, long = [], [], []
    for each in given:
        told, wave, own = _told(each.law)
        sources_of += [*told, len(long), len(own)]
        waves.append(wave)
        long.append(own)
    envelopes = [len(long) + n if each.squares.size else -1 for n, each in enumerate(shaken)]
    long += [each.squares for each in shaken]
    counts = dict(
        points=many, rows=len(g), gauged=len(g), shown=len({*map(tuple, at.rows[many:])}), walls=len(walls),
        noises=len(noises), sources=len(given), dampers=len(dampers), contacts=len(touched), shaken=len(shaken),
        taps=len(memories.taps), modes=memories.modes, resting=int(sum(rests)),
        states=sum(each.named.states for each in (*given, *dampers)), parts=parts_of_step,
        substeps=_substeps(frame, touched),
    )  # fmt: skip
    (row_begin, row_at, row), (noise_begin, noise_at, noise), (source_begin, source_at, source_row) = (
        _sparse(rows) for rows in (g, math.sqrt(step) * noises, np.array([each.row for each in given]).reshape(-1, many))
    )
    lists = dict(
        row_begin=row_begin, row_at=row_at, noise_begin=noise_begin, noise_at=noise_at, source_begin=source_begin,
        source_at=source_at, source=sources_of, spring_kind=[_kind_of(law) for law in springs],
        mode_count=memories.count, mode_begin=memories.begin, mode_table=memories.table, turned=memories.turned,
        turned_table=memories.turned_table, drive=[-1] * len(g), drive_steps=[0] * len(g),
        tapped=[tap.mode for tap in memories.taps], wall_at=struck, wall_kind=[rule.kind for rule in rules],
        damper_at=turned, damper_kind=[each.kind for each in dampers], damper_place=[each.place for each in dampers],
        contact_at=soft, shaken_at=[each.row for each in shaken], shaken_begin=envelopes,
        shaken_steps=[each.squares.size for each in shaken],
    )  # fmt: skip
    numbers = dict(
        step=step, rounding=4.0 * float(np.finfo(kind).eps), row=row, noise=noise, source_row=source_row, wave=waves,
        smooth=[float(each.is_smooth) for each in given], constant=step * constant, spring=springs, kick=springs,
        damping=2.0 * frame.answers, answer=frame.answers, near=memories.near, solve=frame.solve,
        side=[wall.inwards for wall in walls.values()], place=[wall.position for wall in walls.values()],
        restitution=[rule.numbers for rule in rules], jump=frame.jumps[struck], along=frame.jumps[struck] @ g.T,
        reduced=frame.reduced[struck], rests=rests, lean=heavy[:, None] * lean, heavy=heavy,
        mass=at.mass / frame.unit_mass, damper=[each.padded for each in dampers], damper_jump=frame.jumps[turned],
        damper_along=frame.jumps[turned] @ g.T,
        contact=[[*numbers_of(contact), frame.reduced[n]] for n, _, contact in touched],
        contact_jump=frame.jumps[soft], contact_along=frame.jumps[soft] @ g.T,
        shaken=[[each.square, 0.5 * each.square / frame.reduced[each.row]] for each in shaken], turn=np.zeros(8 * many),
        modes=memories.numbers, turns_of_modes=memories.turns,
    )  # fmt: skip
    return packed(counts, lists, numbers, long, kind)


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
        return _Rule(POWER, (law.restitution, law.speed / unit, law.exponent))
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
    named : Named
    """

    row: int
    square: float
    squares: Floats
    named: Named

    def mean_square(self, settings: Settings) -> float:
        """The mean variance in the window."""
        return self.square * float(self.squares[slice(*settings.window_steps)].mean() if self.squares.size else 1.0)


def _shaken(frame: _Frame, settings: Settings) -> Iterator[_Shaken]:
    for n, total in enumerate(frame.totals):
        if total.parametric > 0.0:
            named = Named(f"parametric {n}", _no_law, 0, "expected")
            yield _Shaken(n, frame.step * total.parametric, np.zeros(0), named)
        for noise in total.modulated:
            squares = noise.squares(frame.units, frame.step, settings.steps)
            named = Named(f"parametric {noise.name}", _no_law, 0, "expected")
            yield _Shaken(n, frame.step * noise.intensity, squares, named)


def _check_sizes(tables: Tables) -> None:
    count = tables.count
    for what, has, most in (
        ("masses", count("points"), MOST_POINTS), ("points and pairs of ends", count("rows"), kernel.MOST_ROWS),
        ("walls and contacts", count("walls") + count("contacts"), MOST_WALLS),
        ("sources of white noise", count("noises") + count("shaken"), kernel.MOST_NOISES),
        ("sources of other excitation", count("sources"), excitations.MOST_SOURCES),
        ("nonlinear dampers and forces", count("dampers"), kernel.MOST_DAMPERS),
        ("memory modes", count("modes"), kernel.MOST_MODES), ("circuits", count("taps"), kernel.MOST_TAPS),
        ("states of noise, of what yields and of walls", count("states") + count("walls") + 1, kernel.MOST_STATES),
    ):  # fmt: skip
        if has > most:
            raise ValueError(f"the system has {has} {what}, but the kernel holds at most {most}.")


def _units(plan: Plan) -> tuple[Units, float]:
    """Powers of two near the largest length, the shortest time and the usual mass of the motion."""
    scales, (x0, v0) = plan.motion.scales, start_of(plan)
    walls = [abs(wall.position) for wall in plan.system.of(Barrier)]
    longest = max(scales.length, *np.abs(x0), *(np.abs(v0) / scales.fastest_rate), *walls)
    masses = np.diag(plan.system.coordinates.mass)
    return Units.near(longest, scales.fastest_rate), 2.0 ** round(float(np.log2(masses).mean()))


def _kind_of(springs: Floats) -> int:
    degree = max((n for n, k in enumerate(springs) if k != 0.0), default=-1)
    return NO_SPRING if degree < 0 else LINEAR if degree <= 1 else CUBIC if degree <= 3 else NINTH


def start_of(plan: Plan) -> tuple[Floats, Floats]:
    """x(0) and x'(0) in the order of the coordinates, in m and m/s."""
    names = plan.system.coordinates.names
    if plan.settings.initial_position is None:
        raise ValueError("initial_position of a stationary start is known after its pilot runs only.")
    both = plan.settings.initial_position, plan.settings.initial_velocity
    x0, v0 = (np.array([given[name] for name in names]) for given in both)  # type: ignore[index]
    return x0, v0


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


def _memories(frame: _Frame, settings: Settings) -> _Memories:
    totals, step, tables = frame.totals, frame.step, dict[Any, tuple[int, int, Any, ExponentialSum]]()
    begin, count, table, turned, turned_table = (np.zeros(len(totals), np.int64) for _ in range(5))
    near = np.zeros((len(totals), GROUP, 5))
    numbers, turns = (list[Any]([np.zeros(0)]) for _ in range(2))
    modes, histories, taps = 0, [], list[Tap]()
    for e, total in enumerate(totals):
        key = total.springpots, total.arms
        if key not in tables:
            own, history = memory_of(*key, settings.numerical_scheme, step, settings)
            tables[key] = sum(part.size for part in numbers), sum(part.size for part in turns), own, history
            numbers.append(np.hstack([own.powers.reshape(-1, GROUP), own.weights.reshape(-1, GROUP)]).ravel())
            turns.append(own.turns)
        table[e], turned_table[e], own, history = tables[key]
        begin[e], count[e], turned[e] = modes, own.powers.size // GROUP, own.turns.size // NUMBERS
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
        begin, count, turned, table, turned_table, near, np.concatenate(numbers), np.concatenate(turns), modes, together,
        tuple(taps),
    )  # fmt: skip


def _no_law(word: int, place: int, parts: int) -> None:
    """The kernel has its numbers elsewhere."""


@dataclass(frozen=True, eq=False)
class _Damper:
    """A nonlinear damper, a part that yields, the dissipation of a contact, or a force of the user.

    Attributes
    ----------
    named : Named
    row, kind : int
        The number of its elongation, and the kind of its law.
    numbers : tuple of float
        Of its law per unit of the reduced mass, and that.
    law : NamedTuple or None
        Of the user's force.
    """

    named: Named
    row: int
    kind: int
    numbers: tuple[float, ...]
    place: int = 0
    law: Any = None

    @property
    def padded(self) -> list[float]:
        """As the kernel has them, the reduced mass last."""
        *own, mass = self.numbers
        return [*own, *(0.0,) * (laws.NUMBERS_OF_DAMPER - len(self.numbers)), mass]


def _dampers(frame: _Frame, place: int) -> Iterator[_Damper]:
    """With the first place of their states."""
    kinds = {hysteresis.Plastic: laws.JENKINS, hysteresis.WholePower: laws.WHOLE, hysteresis.AnyPower: laws.ANY}
    for n, total in enumerate(frame.totals):
        mass = float(frame.reduced[n])
        for named in total.forces:
            match law := named.make(0, place, 1):
                case forces.CoulombDamper():
                    yield _Damper(named, n, laws.COULOMB, (law.impulse / mass, mass))
                case forces.PowerDamper():
                    yield _Damper(named, n, laws.POWERS, (law.quadratic / mass, law.cubic / mass, mass))
                case forces.VanDerPolDamper():
                    yield _Damper(named, n, laws.VAN_DER_POL, (law.rate / mass, law.square, mass))
                case hysteresis.Hysteresis(impulse, _, _, inner):
                    own = replace(named, place=place + 3 - hysteresis.STATES + GROUP, states=laws.STATES_OF_YIELDING)
                    yield _Damper(own, n, kinds[type(inner)], (impulse / mass, *inner, mass), place)
                    place += own.states
                case _:
                    function = law.function
                    yield _Damper(named, n, function.address, (law.half / mass, *law.units, mass), law=function)


@dataclass(frozen=True, eq=False)
class _Given:
    """A source of excitation: its law in the kernel, its name, and the row on which it acts.

    ``brought`` is the variance of what it brings anew within each step; of a smooth force the impulses of neighbouring
    steps are nearly alike.  ``course`` is that of each step over this, where an envelope changes it.
    """

    named: Named
    law: Any
    row: Floats
    brought: float
    is_smooth: bool
    course: Floats


def _excitation(plan: Plan, frame: _Frame, parts_of_step: int) -> tuple[Floats, list[_Given], Floats]:
    """Rows of white noise with the roots of the intensities; sources of other noise; and the constant force."""
    many, unit_mass, step, parts = len(frame.at.names), frame.unit_mass, frame.step, dict(plan.system.named())
    white, given, constant = [], list[tuple[Named, Floats, float | None]](), np.zeros(many)
    for name, row in plan.system.coordinates.forces.items():
        part = parts[name]
        row = -row / unit_mass if part.of_ground else row  # the sign is in what is lowered
        own = part.per_mass(1.0 if part.of_ground else unit_mass)
        more = lower(own, name, frame.units, step).over(plan.settings.steps)
        if more.white > 0.0:
            white.append(math.sqrt(more.white) * row)
        constant -= sum(more.springs[:1]) * row
        more += modulated_noise(more, frame.units, step, plan.settings.steps, plan.settings.window_steps)
        given += [(replace(named, does="feeds"), row, None) for named in more.forces]
    for thermal in plan.system.of(ThermalNoise):
        name, warm = plan.system.name_of(thermal), _temperature(thermal, frame)
        for n, (total, row) in enumerate(zip(frame.totals, frame.rows, strict=True)):
            if total.remembers:
                own, hot = f"{name} of row {n}", replace(total, temperature=warm)
                noise = thermal_noise(own, hot, step, plan.settings.steps, parts_of_step)
                given.append((noise, row, 4.0 * step * warm * rough_answer_of(total, step)))
            elif total.springpots:
                white.append(math.sqrt(2.0 * warm * total.dashpots) * row)
    placed = [*_placed(given, parts_of_step, plan.settings.window_steps)]
    return np.array(white).reshape(-1, many), placed, constant


def _temperature(thermal: ThermalNoise, frame: _Frame) -> float:
    return lower(thermal.per_mass(frame.unit_mass), "", frame.units, frame.step).temperature


def _of_thermal_noise(plan: Plan, parts: PartsOfSeveral, frame: _Frame) -> Iterator[Reading]:
    """The power of matched noise: measured of that with memory, and its known mean of the white noise of dashpots."""
    for thermal in plan.system.of(ThermalNoise):
        name, warm = plan.system.name_of(thermal), _temperature(thermal, frame)
        white = sum(
            warm * total.dashpots / float(mass)
            for total, mass in zip(frame.totals, frame.reduced, strict=True)
            if not total.remembers
        )
        works = {f"work of {each.name}": 1.0 for each in parts.named if each.name.startswith(f"{name} of row ")}
        yield Reading(f"{name}_power", works, "time", frame.power * white)


def _drawn(law: Any, window: tuple[int, int]) -> tuple[float, Floats]:
    """Variance of what a source draws anew for the impulse of a step: its mean over the window, and that of each step
    over this, which is empty without an envelope.
    """
    size, roots = {
        sources.Modulated: lambda: (1.0, law.roots),
        sources.ModulatedWhite: lambda: (1.0, law.roots),
        sources.Poisson: lambda: (float(law.size**2 * law.rate), law.envelope),
        sources.Filtered: lambda: (float(law.newest[0]) ** 2, law.envelope),
    }.get(type(law), lambda: (0.0, np.zeros(0)))()
    mean = float((roots[slice(*window)] ** 2).mean()) if roots.size else 1.0
    return size * mean, np.asarray(roots**2 / mean if mean > 0.0 else np.zeros(0))


def _placed(
    given: Sequence[tuple[Named, Floats, float | None]], parts_of_step: int, window: tuple[int, int]
) -> Iterator[_Given]:
    """Each source with its own counter words and its place among the states."""
    word, place = kernel.MOST_NOISES, 0
    for named, row, brought in given:
        law = named.make(word, place, parts_of_step)
        whole, course = brought, np.zeros(0)
        if whole is None:  # some laws take long to make
            whole, course = _drawn(law if parts_of_step == 1 else named.make(word, place, 1), window)
        rough = isinstance(law, sources.Poisson | sources.ModulatedWhite)
        yield _Given(named, law, row, whole, brought is None and not rough, course)
        word, place = word + sources.WORDS, place + named.states


def _told(law: Any) -> tuple[list[int], tuple[float, float], Floats]:
    """A law in the kernel, as `springpot.simulation.kernel.excitations` has it: six integers, two numbers, and a long list."""
    word, place, none = law.word, getattr(law, "place", 0), (0.0, 0.0)
    match law:
        case sources.Filtered():
            long = np.concatenate([law.newest, law.pairs.ravel(), law.start.ravel(), law.envelope])
            return [excitations.FILTERED, word, place, len(law.pairs), len(law.start), 0], none, long
        case sources.Harmonic():
            return [excitations.HARMONIC, word, place, 0, 0, 0], (law.impulse, law.turn), np.zeros(0)
        case sources.Poisson():
            return [excitations.POISSON, word, place, 0, 0, 0], (law.rate, law.size), law.envelope
        case sources.Table():
            return [excitations.TABLE, word, place, len(law.impulses), int(law.drawn), 0], none, law.impulses.ravel()
        case sources.ModulatedWhite():
            return [excitations.MODULATED, word, place, 0, law.roots.size, 0], none, law.roots
    long = np.concatenate([law.roots, law.gains.ravel(), law.change.ravel(), law.seen.ravel()])
    return [excitations.MODULATED, word, place, law.seen.shape[1], law.roots.size, 0], none, long


def _precision(settings: Settings, noisy: bool) -> str:
    """Of the sweep: double without noise.

    Without it one path is the answer, and its last digits may be wanted.
    """
    single = noisy and settings.precision == "float32" and settings.memory_tolerance >= SINGLE_PRECISION
    return "float32" if single else "float64"


def _readings(
    plan: Plan, parts: PartsOfSeveral, lacking: Floats, shaking: Sequence[tuple[str, Floats]]
) -> Iterator[Reading]:
    """Every result but the balance of energy.

    ``lacking``: v^2 is summed as the square of the mean of the velocities before and after a kick, which lacks a
    quarter of their difference squared, by noise and by the dampers that take it again.  With S of `compose_several`,
    M and the covariance B of the noise's impulse it is p S B M^-1 p / 4 of a point with the row p: exact for matched
    noise of dashpots, where the square alone is that of the temperature times S, and for one mass with a dashpot and
    white noise.  ``shaking``: the same of noise that multiplies an elongation, per square of that, by its row.
    """
    system, at = plan.system, plan.system.coordinates
    gauged = dict(zip(at.numbers, parts.gauged, strict=True))
    for i, (point, own, lack) in enumerate(zip(at.points, at.rows.tolist(), lacking, strict=True)):
        letters, of = ("xv", point) if point in at.names else ("uw", gauged[tuple(own)])
        yield Reading(f"{point}_x_mean", {f"{letters[0]} of {of}": 1.0})
        yield Reading(f"{point}_x_mean_square", {f"{letters[0]}^2 of {of}": 1.0})
        above = {f"{letters[1]}^2 of {of}": 1.0, **{f"u^2 of {row}": float(lacks[i]) for row, lacks in shaking}}
        yield Reading(f"{point}_v_mean_square", above, added=float(lack))
    for pair, own_row in at.pairs.items():
        row = gauged[tuple(own_row.tolist())]
        yield Reading(f"{pair}_elongation_mean", {f"u of {row}": 1.0})
        yield Reading(f"{pair}_elongation_mean_square", {f"u^2 of {row}": 1.0})
    for name, part in system.named():
        if isinstance(part, Stop):
            yield Reading(f"{name}_impact_rate", {f"{name} impacts": 1.0}, "time")
            yield Reading(f"{name}_impact_speed_mean", {f"{name} speeds": 1.0}, f"{name} impacts")
            yield Reading(f"{name}_impact_speed_mean_square", {f"{name} squares": 1.0}, f"{name} impacts")
            yield Reading(f"{name}_power", {f"{name} loss": 1.0}, "time")
            yield Reading(f"{name}_force_mean", {f"{name} momentum": 1.0}, "time")
    if parts.taps and not system.of(ThermalNoise):  # noise of a resistor is beside the mode, in the matched force
        for tap in parts.taps:
            square, _, name = tap.name.partition(" of ")
            yield Reading(f"{name}_{square}_mean_square", {tap.name: 1.0}, "groups")
            if square == "current" and (count := system.counts.get(name)):
                yield Reading(f"{name}_current_of_one_mean_square", {tap.name: 1.0 / count**2}, "groups")
        circuits = [(name, part) for name, part in system.named() if isinstance(part, Circuit)]
        loads = {f"{part.of_load} of {name}": 1.0 / part.load for name, part in circuits}
        yield Reading("harvested_power", loads, "groups")
    if any(part.dissipates and "damping" in part.powers for part in system.parts):
        yield Reading("damping_power", parts.damped, added=parts.taken_at_once)
    for point, shares in zip(at.points, at.rows.tolist(), strict=True):
        x, v = ({f"{end} of {of}": s for of, s in zip(at.names, shares, strict=True) if s} for end in _ENDS)
        yield Reading(f"{point}_x_mean_end", x, "one")
        yield Reading(f"{point}_x_mean_square_end", x, "one", power=2)
        yield Reading(f"{point}_v_mean_square_end", v, "one", power=2)
