"""Paths of one structure under a known input, with other numbers in each lane: what a search of numbers runs.

An ensemble begins anew each time: it plans, draws, watches and sums.  Here all of that is done once.  A call takes
systems with other numbers, each with its own x(0) and x'(0), and runs them beside each other, up to 64 in a block.
So a path and its derivatives by all numbers, as differences, take one call.  The impulses of the input stand once, for
all lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.crew import work_together
from springpot.memory import ExponentialSum
from springpot.memory.common_rates import CommonRates, common_rates
from springpot.memory.exponential_sum import shared_span
from springpot.problem.system import System
from springpot.simulation.kernel.native import key_words
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.kernel.tables import by_lane, common, with_common_records
from springpot.simulation.lowering.compose import Parts, compose, units_of
from springpot.simulation.lowering.memory import sums_of
from springpot.simulation.lowering.parts import denser, impulses_of
from springpot.simulation.paths.simulation import addresses_of
from springpot.simulation.plan.motions import motion_of, near_motion_of
from springpot.simulation.plan.plan import COARSEST, Plan, plan_of

_WIDE = 0.15, 0.02, 0.002  # on either side of an order: those that have the same rates of memory, if such are found
_NEAR = 0.01  # orders that are never parted
_AT_ONCE = 100_000  # steps of blocks that Ctrl-C can wait for: a thread takes as long as 2,000 of them


@dataclass(frozen=True, eq=False, kw_only=True)
class Driven:
    """A system under a known input, prepared to run with other numbers.  Made by `driven_by`.

    Attributes
    ----------
    plan : Plan
        Of the system with a short stub in place of the input.
    step : float
        Of the input's samples, in s.
    every : int
        Steps of the kernel in one of these.
    inputs : tuple of ndarray, shape (samples,)
        Several records are those of one lane after another, in turn.
    is_sampled : bool
        Whether they are samples of a band-limited signal; otherwise straight lines are between them.
    accelerates : bool
        Whether accelerations are wanted too.
    delay : float
        In s, by which the inputs come later.
    samples : int
        So many are run, the first ones.
    points : tuple of ndarray
        Of each of the inputs, so dense that lines between them are straight.
    """

    plan: Plan
    step: float
    every: int
    inputs: tuple[Floats, ...]
    is_sampled: bool = True
    accelerates: bool = False
    delay: float = 0.0
    samples: int
    points: tuple[Floats, ...]
    _rates: list[CommonRates] = field(default_factory=list, repr=False)

    def delayed(self, delay: float) -> Driven:
        """The same whose inputs come so much later, in s."""
        return self if delay == self.delay else replace(self, delay=delay)

    def first(self, samples: int) -> Driven:
        """The same that ends after so many samples."""
        length = self.plan.settings.step * ((samples - 1) * self.every + self.accelerates)
        return replace(self, plan=self.plan.but(duration=length, window=(0.0, length)), samples=samples)

    def paths(self, systems: Sequence[System], starts: Floats, threads: int = 1) -> Floats:
        """x and v of all points at the samples, and x'' if it is wanted.

        Parameters
        ----------
        systems : sequence of System
            With the structure of the plan's, and numbers near those of the first; each as often as there are
            inputs, one after another.
        starts : ndarray, shape (systems, 2 coordinates)
            x and v at time 0.
        threads : int

        Returns
        -------
        ndarray, shape (systems, samples, points, 2 or 3)
            Not finite where a path grows without limit.
        """
        memory, alike = self._memory(systems), dict[bytes, list[int]]()
        motion, known, units = motion_of(systems[0]), dict[int, Parts](), units_of(self.plan)
        for system in systems:
            if id(system) not in known:
                near = Plan(motion if system is systems[0] else near_motion_of(system, motion), self.plan.settings)
                known[id(system)] = compose(near, kernel_units=units, memory=memory, is_read=False)
        composed = [known[id(system)] for system in systems]
        for n, parts in enumerate(composed):
            alike.setdefault(common(parts.tables), []).append(n)
        most = LANES // len(self.inputs) * len(self.inputs)
        blocks = [own[n : n + most] for own in alike.values() for n in range(0, len(own), most)]
        points = len(composed[0].points) + len(composed[0].others)
        found = np.empty((len(systems), self.samples, points, 3 if self.accelerates else 2))
        left, stop, impulses = iter(blocks), np.zeros(1, np.uint8), self._impulses

        def work() -> None:
            for own in left:
                found[own] = self._block([composed[n] for n in own], starts[own], impulses, stop)

        if len(blocks) * self.plan.settings.steps <= _AT_ONCE:
            work()
        else:
            work_together(work, min(threads, len(blocks)), stop=partial(stop.fill, 1))
        return found

    def _block(self, parts: Sequence[Parts], starts: Floats, impulses: Floats, stop: npt.NDArray[np.uint8]) -> Floats:
        """Of systems that have the common numbers, in the first lanes of a block: lane n has input n % their number."""
        one, settings, turns, used = parts[0], self.plan.settings, len(self.inputs), len(parts)
        which = np.arange(LANES) * (np.arange(LANES) < used)
        own = np.stack([each.tables.numbers for each in parts])
        tables = with_common_records(by_lane(one.tables, own, own, which), turns, impulses)
        whole, usual = replace(one, tables=tables), np.repeat([one.units.length, one.units.speed], len(one.points))
        away = np.array([np.repeat([each.place, 0.0], len(one.points)) for each in parts])
        states = (starts / usual - away)[which]
        record = np.empty((used, settings.recorded_points, *one.shape_of_state))
        whole.kernel()(
            states, 0, 1, settings, *key_words(settings.seed), 0, False, addresses_of((), (), whole), record, stop,
            np.empty((LANES, len(one.columns))),
        )  # fmt: skip
        for n, each in enumerate(parts):
            record[n, 0] = each.start_of_record(states[n : n + 1])[0]
        moved = (record * one.units.state).reshape(used, settings.recorded_points, -1, 2)
        if not self.accelerates:
            return moved
        rate = np.gradient(moved[..., 1], settings.step, axis=1)
        return np.concatenate([moved, rate[..., None]], axis=3)[:, : moved.shape[1] - 1 : self.every]

    @property
    def input_at_samples(self) -> Floats:
        """What acts at the samples, shape (inputs, samples): with the delay."""
        if self.delay == 0.0:
            return np.array(self.inputs)[:, : self.samples]
        rows, end = self.points, self.step * (len(self.inputs[0]) - 1)
        at = np.linspace(0.0, end, len(self.inputs[0])) - self.delay
        return np.array([np.interp(at[: self.samples], np.linspace(0.0, end, row.size), row) for row in rows])

    @cached_property
    def _impulses(self) -> Floats:
        """Of all inputs, one after another, in the units of the kernel."""
        (units, mass), end = units_of(self.plan), self.step * (len(self.inputs[0]) - 1)
        step, steps, size = self.plan.settings.step / units.time, self.plan.settings.steps, units.time**2 / units.length
        (record,) = self.plan.system.records.values()
        size = -size if record.of_ground else size / mass
        rows = [
            impulses_of(np.linspace(0.0, end / units.time, own.size), size * own, step, steps, self.delay / units.time)
            for own in self.points
        ]
        return np.concatenate([np.pad(row, (0, steps - row.size)) for row in rows])

    def _memory(self, systems: Sequence[System]) -> Callable[[float], ExponentialSum]:
        """Sums by the order: near orders have the same rates, so that a small change of one moves no path by a jump."""
        alone, groups = sums_of(self.plan.settings), list[list[float]]()
        for order in sorted({springpot.order for system in systems for springpot in system.springpots.values()}):
            if groups and (order - groups[-1][0] < _WIDE[0] or order - groups[-1][-1] < _NEAR):
                groups[-1].append(order)
            else:
                groups.append([order])
        wide = [own for own in groups if len(own) > 1 and own[0] > 0.0 and own[-1] < 1.0]
        rates = [(own, self._rates_of(own[0], own[-1])) for own in wide]
        sums = {order: common(order) for own, common in rates if common is not None for order in own}
        return lambda order: sums.get(order) or alone(order)

    def _rates_of(self, low: float, high: float) -> CommonRates | None:
        """Rates for all orders between two: those that were used before, if they serve; None where there are none."""
        known = next((each for each in self._rates if each.low <= low and high <= each.high), None)
        settings, span = self.plan.settings, shared_span(len(self.inputs[0]) * self.every)  # also of a first part
        for wide in _WIDE if known is None else ():
            ends = max(low - wide, 0.5 * low), min(high + wide, 0.5 * (1.0 + high))
            try:
                known = common_rates(settings.numerical_scheme.family, *ends, span, settings.memory_tolerance)
            except ValueError:  # near 0 and 1 a range must be narrow
                continue
            self._rates.append(known)
            break
        return known


def driven_by(
    system: System, source: str, step: float, inputs: Sequence[Floats], *, every: int,
    is_sampled: bool = True, accelerates: bool = False,
) -> Driven:  # fmt: skip
    """Prepare a system to run under a known input.

    Parameters
    ----------
    system : System
        With a `RecordedExcitation` as its only excitation that changes in time.
    source : str
        The name of that part, whose points are not used.
    step : float
        Of the samples of the inputs, in s.
    inputs : sequence of ndarray, shape (samples,)
    every : int
        Steps of the kernel in one of these; more are taken where these are too long for any simulation.
    is_sampled, accelerates : bool
        As of `Driven`.

    Raises
    ------
    TypeError, ValueError
        As of `springpot.simulate`.

    Examples
    --------
    >>> from springpot.problem.parts import RecordedExcitation, Spring
    >>> system = System(Spring(4.0), shaker=RecordedExcitation((0.0, 1.0), (0.0, 0.0), "mass"))
    >>> driven = driven_by(system, "shaker", 0.1, [np.sin(0.5 * np.arange(50))], every=2)
    >>> path = driven.paths([system], np.zeros((1, 2)))
    >>> path.shape, driven.every
    ((1, 50, 1, 2), 2)
    """
    stub = with_stub(system, source, step, inputs)
    count = max(every, math.ceil(step * motion_of(stub).scales.fastest_rate / COARSEST))
    steps = (len(inputs[0]) - 1) * count + accelerates
    plan = plan_of(
        stub, duration=step / count * steps, step=step / count, paths=1, record=1,
        record_every=1 if accelerates else count, start="rest", threads=1,
    )  # fmt: skip
    times: Floats = step * np.arange(len(inputs[0]), dtype=np.float64)
    points = tuple(denser(times, own, step / count)[1] if is_sampled else own for own in inputs)
    return Driven(
        plan=plan, step=step, every=count, inputs=tuple(inputs), is_sampled=is_sampled, accelerates=accelerates,
        samples=len(inputs[0]), points=points,
    )  # fmt: skip


def with_stub(system: System, source: str, step: float, inputs: Sequence[Floats]) -> System:
    """The system with two points in place of its record, which have the mean square of the inputs."""
    part, parts = dict(system.stated())[source], dict(system.stated())
    size = math.sqrt(3.0 * float(np.mean(np.square(inputs))))
    own = (size, -size)
    values = (own,) * len(inputs) if len(inputs) > 1 else own
    return System(**parts | {source: replace(part, time=(0.0, step), values=values, scale=1.0, interpolation="linear")})
