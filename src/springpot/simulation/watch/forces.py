"""Mean and mean square of forces and accelerations, of impulses, and of the largest forces of touches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import few, shown
from springpot.problem.catalogue import possible_results
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, LANES
from springpot.simulation.kernel.watching import ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.paths.statistics import ratio
from springpot.simulation.plan.plan import MOST_RECORDED, Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.counted_impacts import counted
from springpot.simulation.watch.requested import Observed, Request

_LAYOUT = layout(sum=LANES, squares=LANES)
_LENGTH, _SUM, _SQUARES = begins(_LAYOUT, "length", "sum", "squares")


def signals_of_forces(plan: Plan, wishes: Mapping[str, Any]) -> tuple[Signal, ...]:
    """Those that the argument ``forces`` names, also for the other observers.

    Raises
    ------
    TypeError, ValueError
        One sentence.
    """
    motion, settings, names = plan.motion, plan.settings, wishes.get("forces", ())
    if isinstance(names, str) or not isinstance(names, Sequence):
        raise TypeError(
            f"forces must be a list of names of forces and accelerations, not {shown(names)}: "
            f"{few(motion.signals_by_force)}."
        )
    found = [motion.signal_by_name(name, "forces", forces_only=True) for name in names]
    found = [*{(*signal.names.values(),): signal for signal in found}.values()]
    points = settings.record * settings.recorded_points * sum(bool(signal.outputs) for signal in found)
    if points > MOST_RECORDED:
        raise ValueError(
            f"record asks for {points:,} points of forces, but at most {MOST_RECORDED:,} are stored: use a larger "
            "record_every."
        )
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Moments(Request):
    """The moments of one of them, and the record of a force or an acceleration.

    The mean force of a contact is among the results of every run, by its momentum.
    """

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Moments]:
        yield from map(cls.of, signals_of_forces(plan, wishes))

    @classmethod
    def of(cls, signal: Signal) -> Moments:
        """Of this one."""
        if not signal.outputs:
            return cls((counted(signal),))
        return cls((Observer(signal, _on_outputs(), None, np.zeros((), _LAYOUT), of_paths=("sum", "squares")),))

    def in_full(self, settings: Settings) -> bool:
        return bool(settings.record)

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """With what the mean square lacks since the force is seen as its mean over each step."""
        signal, motion, (low, high) = self.observer.signal, simulation.motion, simulation.settings.window_steps
        (name,), found = signal.names.values(), dict[str, tuple[float, Floats]]()
        sums = {of: own / (high - low) for of, own in ensemble.observed[self.observer].items()}
        if motion.is_undefined(signal):
            sums = {of: np.full_like(own, np.nan) for of, own in sums.items()}
        if not signal.outputs:
            ends = ("mean", "speeds"), ("mean_square", "squares")
            return {"estimates": {f"{name}_{end}": ratio(sums[of], sums["number"]) for end, of in ends}}
        square = sums["squares"] + simulation.parts.outputs.lacking[name]
        for end, samples in (("mean", sums["sum"]), ("mean_square", square)):
            if (own := f"{name}_{end}") not in possible_results(motion.system):
                found[own] = float(samples.mean()), samples
        recorded = {name: ensemble.outputs[signal.outputs[0]]} if simulation.settings.record else {}
        return {"estimates": found, "forces": recorded}


@cache
def _on_outputs() -> Any:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        scale = array[_LENGTH]
        first, end = max(low - n, 0), min(high - n, GROUP)
        if end - first == GROUP:
            for lane in range(LANES):
                a, b = scale * x[lane], scale * x[LANES + lane]
                c, d = scale * x[2 * LANES + lane], scale * x[3 * LANES + lane]
                array[_SUM + lane] += (a + b) + (c + d)
                array[_SQUARES + lane] += (a * a + b * b) + (c * c + d * d)
        else:
            for j in range(first, end):
                for lane in range(LANES):
                    here = scale * x[j * LANES + lane]
                    array[_SUM + lane] += here
                    array[_SQUARES + lane] += here * here

    return on_steps
