"""From a problem and settings to the kernel's parts, and from its sums back: units and side are converted here.

In the kernel a lone wall of the paper's problem is always below the motion; a wall above is mirrored, x -> -x.  The
kernel's units are powers of two near the problem's scales, so that its numbers are near 1 and a change of scale by a
power of two changes no bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.memory import direct
from springpot.problem.parts import ThermalNoise
from springpot.simulation.kernel import block as kernel
from springpot.simulation.kernel import questions as parts
from springpot.simulation.kernel.block import COLUMNS, Memory, modes_of
from springpot.simulation.kernel.branches import NO_BRANCHES
from springpot.simulation.kernel.lanes import GROUP, MOST_FORCES
from springpot.simulation.kernel.normals import start_normals
from springpot.simulation.kernel.questions import Start
from springpot.simulation.kernel.rigid_wall import Rigid
from springpot.simulation.kernel.watching import Observer
from springpot.simulation.lowering.composed import Composed
from springpot.simulation.lowering.felt import lowered_felt
from springpot.simulation.lowering.kernel_units import Units
from springpot.simulation.lowering.memory import answer_of, memory_of, taps_of
from springpot.simulation.lowering.modulated import mean_squares
from springpot.simulation.lowering.parts import Lowered, forces_of, lower, modulated_noise, thermal_noise, wall_of
from springpot.simulation.lowering.precision import single_of, sweeps_in_single, with_arrays
from springpot.simulation.lowering.walls import sums_of
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings

if TYPE_CHECKING:
    from springpot.simulation.lowering.several import PartsOfSeveral

_FASTEST_FLIGHT = 6.0  # standard deviations of the speed for which contacts are resolved


@dataclass(frozen=True, eq=False, kw_only=True)
class Parts(Composed):
    """The arguments of the kernel of one mass.

    Attributes
    ----------
    scheme, load, memory
        Parts of the kernel, in its units; ``load`` is the sum of all forces.
    drive : ndarray
        Force in each step due to x(0); empty with Caputo's derivative, or if x(0) = 0.
    tapped : ndarray of int
        The modes of the taps in the memory.
    states_of_sources : int
        Numbers that the forces keep for each path.
    """

    scheme: parts.Splitting | parts.Euler
    load: Any
    memory: Memory
    drive: npt.NDArray[np.floating]
    tapped: npt.NDArray[np.int64]
    states_of_sources: int

    def of_kernel(self) -> tuple[kernel.Parts, parts.Sweep]:
        """Scheme, wall and load in double precision, and as the sweep over all lanes takes them."""
        exact = kernel.Parts(self.scheme, self.wall, self.load)
        if self.memory.newest.dtype == np.float64 or not sweeps_in_single(exact):
            return exact, parts.Sweep(*exact, 0.0)
        exact = exact._replace(load=with_arrays(self.load, np.float32))
        return exact, single_of(exact)

    def kernel(self) -> Callable[..., None]:
        """The kernel, with all arguments that are the same for all blocks."""
        exact, sweep = self.of_kernel()

        def advance(states: Floats, first: int, blocks: int, settings: Settings, *given: Any) -> None:
            k0, k1, stream, halved, observers, record, stop, rows, *branches = given
            low, high = settings.window_steps
            kernel.block(
                exact, sweep, self.memory, self.drive, self.start._replace(states=states), self.tapped,
                self.frequency**2, self.units.shift, first, blocks, settings.steps, low, high, k0, k1, stream, halved,
                observers, record, settings.record_every, stop, rows, *(branches or (NO_BRANCHES,)),
            )  # fmt: skip

        return advance

    @property
    def numbers_kept(self) -> tuple[int, int, int, npt.DTypeLike, int, npt.DTypeLike]:
        """Those of one coordinate and one row."""
        of_sources = np.dtype(type(self.of_kernel()[1].zero))
        return 1, 1, modes_of(self.memory), self.memory.newest.dtype, self.states_of_sources, of_sources

    def states(self, settings: Settings, first: int, paths: int, stream: int) -> Floats:
        """x, v and energy at time 0: of every path from ``first`` on if they are drawn, otherwise once for all."""
        if self.law is None or settings.start != "stationary":
            return self.start.states
        from scipy import special  # slow to import, and most runs need none of it

        normals = start_normals(settings.seed, first, paths, stream=stream).astype(float)
        x = self.law.drawn(special.ndtr(normals[:, 0])) / self.units.length
        v = math.sqrt(self.law.temperature) / self.units.speed * normals[:, 1]
        return np.stack([x, v, 0.5 * (v * v + self.frequency**2 * x * x)], axis=1)

    def frequency_and_wall(self, observer: Observer) -> tuple[float, float]:
        """The same for all observers, which see x with its shift."""
        return self.frequency, self.wall_position + self.units.shift

    @property
    def shape_of_state(self) -> tuple[int, ...]:
        """Of x and v at a time."""
        return (2,)

    def start_of_record(self, states: Floats) -> Floats:
        """x and v at time 0 as the record has them."""
        return states[:, :2] + (self.units.shift, 0.0)

    @property
    def taken_at_once(self) -> float:
        """What springpots and dashpots take of the expected power within the kicks that bring it; in m^2/s^3.

        The sums of a run do not have it: the mean of the velocities before and after a kick does not show it.
        """
        return self.expected_power * (1.0 - self.scheme.share)

    @property
    def wall_position(self) -> float:
        """Place of a single rigid wall in the kernel's units; 0 without one."""
        return self.wall.position if isinstance(self.wall, Rigid) else 0.0

    @property
    def halves(self) -> dict[str, tuple[str, str]]:
        """Of x and v."""
        return {f"{name}_mean_square": (f"{name}_square", f"{name}_square_early") for name in "xv"}

    @property
    def columns(self) -> dict[str, float]:
        """The numbers of a row by name, each with the factor from the kernel's units."""
        units = self.units
        square = units.speed**2
        extra = {f"work of {named.name}": square for named in self.named}
        speed = units.speed
        factors = {"impacts": 1.0, "speeds": speed, "momentum": speed, "time": units.time, "depth": units.length}
        extra |= {name: factors.get(name.split()[-1], square) for name in sums_of(self.wall)}
        extra |= {tap.name: tap.factor**2 for tap in self.taps}
        return {**dict(zip(COLUMNS, units.columns, strict=True)), **extra}


def compose(plan: Plan, *, halved: bool = False) -> Parts | PartsOfSeveral:
    """The arguments of the kernel.

    With ``halved`` the excitation is that of a run with half the step, summed in pairs; white noise alone is chosen
    when the paths are advanced.

    Raises
    ------
    ValueError
        If x(0) is not known yet, or the memory has too many terms for the kernel.
    NotCoveredError
        If parts of the system cannot be simulated together.
    """
    if len(plan.system.points) > 1:
        from springpot.simulation.lowering.several import compose_several  # loaded for several masses only

        return compose_several(plan, 2 if halved else 1)
    motion, settings, parts_of_step = plan.motion, plan.settings, 2 if halved else 1
    unit, scales = motion.unit, motion.scales
    position, velocity = cast(float | None, settings.initial_position), cast(float, settings.initial_velocity)
    if position is None:
        raise ValueError("initial_position of a stationary start is known after its pilot runs only.")
    units = _units(motion, position, velocity)
    step = settings.step / units.time
    parts_by_name = {name: lower(part, name, units, step).over(settings.steps) for name, part in unit.named()}
    total = reduce(add, parts_by_name.values(), Lowered())
    frequency = scales.flight_frequency * units.time
    steady = total.white + total.poisson
    total += modulated_noise(total, units, step, settings.steps, settings.window_steps)
    # kicks have what the exact flight has not; rounding of k - k is nothing
    remainder = (0.0, -(frequency * frequency), *(0.0,) * 8)
    beside = total + Lowered(springs=remainder)
    linear = sum(abs(k) for k in (total.springs[1:2] or (0.0,))) + frequency**2
    springs = [0.0 if n == 1 and abs(k) < 1e-12 * linear else k for n, k in enumerate(beside.springs)]
    if total.temperature > 0.0:
        name = unit.name_of(unit.of(ThermalNoise)[0])
        beside = beside + Lowered(forces=(thermal_noise(name, total, step, settings.steps, parts_of_step),))
    scheme = settings.numerical_scheme
    answer = answer_of(total, step)
    at_this_step = scheme.at(frequency, answer, step, units.length)
    memory, history = memory_of(total.springpots, total.arms, scheme, step, settings)
    load, named = forces_of(replace(beside, springs=tuple(springs)), at_this_step.share, step, parts_of_step)
    x0, v0 = units.into(position, velocity)
    drives = [_drive(order, c * step**-order, x0 + units.shift, settings) for order, c in total.springpots]
    early = sum(
        scheme.early_displacement(order, float(drive[0]), step)
        for (order, _), drive in zip(total.springpots, drives, strict=True)
        if drive.size > 0
    )
    taps = tuple(taps_of(total.arms, memory, history, step))
    if len(taps) > MOST_FORCES:
        raise ValueError(f"the system has {len(taps)} circuits, but the kernel holds at most {MOST_FORCES}.")
    phase = 0.5 * frequency * step  # of half a drift on the circle of the linear spring
    brought = np.array([[at_this_step.share * step * (total.white + total.poisson)]])
    (low, high), modulated = settings.window_steps, list[tuple[Floats, Floats]]()
    for noise in (each for each in total.modulated if each.intensity > 0.0 and not each.multiplies):
        squares = noise.squares(units, step, settings.steps)
        mean = float(squares[low:high].mean())
        own = np.array([[at_this_step.share * step * noise.intensity * mean]])
        modulated += [(own, squares / mean)] if mean > 0.0 else []
    fastest = _touching_speed(motion, position, velocity) if total.contacts else 0.0

    def expected_in(edges: Sequence[int]) -> Floats:
        own = (np.array(mean_squares(each, units, step, edges)) for each in total.modulated if not each.multiplies)
        return 0.5 * (steady + sum(own, np.zeros(len(edges) - 1))) * units.speed**2 / units.time

    return Parts(
        scheme=at_this_step,
        wall=wall_of(
            total, fastest / units.speed, scales.spread / units.length, units.speed, step, motion.rested_on
        ),
        load=load,
        memory=memory,
        start=Start(np.array([[x0, v0, 0.5 * (v0 * v0 + frequency * frequency * x0 * x0)]]), float(early)),
        half_drift=(math.cos(phase), math.sin(phase), math.sin(phase)),
        drive=reduce(add, drives) if drives else np.zeros(0, settings.precision),
        frequency=frequency,
        expected_power=0.5 * (total.white + total.poisson) * units.speed**2 / units.time,
        expected_in=expected_in if total.modulated else None,
        units=units,
        history=history,
        named=named,
        taps=taps,
        tapped=np.array([tap.mode for tap in taps], np.int64),
        law=motion.law if total.temperature > 0.0 else None,
        mass=plan.system.inertia,
        walls=_walls_of(total),
        contacts=tuple(name for name, _ in total.contacts),
        states_of_sources=sum(force.states for force in beside.forces),
        felt=lowered_felt(
            plan, [parts_by_name], np.ones((1, 1)), brought, plan.system.inertia / units.time**2, units.length, step,
            named, modulated, units.shift,
        ),
    )  # fmt: skip


def _walls_of(total: Lowered) -> tuple[str, ...]:
    """The rigid wall below the motion, the one above it, and the contacts; a lone wall is below in the kernel."""
    below, above = ([name for name, wall in total.barriers if wall.side == side] for side in ("above", "below"))
    return *(below or [""]), *(above or [""]), *(name for name, _ in total.contacts)


def _touching_speed(motion: Motion, position: float, velocity: float) -> float:
    """Largest speed for which soft contacts are resolved: that of a rare flight, or of a start with more energy."""
    energy = motion.unit.potential.energy(np.append(motion.law.places, position - motion.origin))
    started = velocity**2 + 2.0 * float(energy[-1] - energy.min())
    return math.sqrt(max(_FASTEST_FLIGHT**2 * motion.law.temperature, started))


def _units(motion: Motion, position: float, velocity: float) -> Units:
    """Powers of two near the largest length and the shortest time of the motion."""
    scales = motion.scales
    potential, position = motion.unit.potential, position - motion.origin
    walls = [abs(end) for end in (potential.low, potential.high) if math.isfinite(end)]
    longest = max(scales.length, abs(position), abs(velocity) / scales.flight_frequency, *walls, 0.0)
    return Units.near(longest, scales.fastest_rate, motion.sign, motion.origin)


def _drive(order: float, scale: float, x0: float, settings: Settings) -> npt.NDArray[np.floating]:
    """Riemann-Liouville's force x(0) t^-alpha / Gamma(1 - alpha), with the weights of the scheme."""
    if settings.derivative == "caputo" or x0 == 0.0:
        return np.zeros(0, settings.precision)
    weights = direct(settings.numerical_scheme.family, order, settings.steps + GROUP)
    return np.asarray(scale * x0 * weights, settings.precision)
