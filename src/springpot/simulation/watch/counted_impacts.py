"""Impacts that are not slower than a speed: their rate and speeds, which exist also where all impacts have no rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np

from springpot.machine.arguments import finite_number
from springpot.machine.arrays import Floats
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.watching import ON_IMPACTS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.paths.statistics import error_of_unseen, ratio
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.requested import Observed, Request

COUNTED = "counted_impact_rate", "counted_impact_speed_mean", "counted_impact_speed_mean_square"

_LAYOUT = layout(number=LANES, speeds=LANES, squares=LANES, least=())
_SPEED_UNIT, _NUMBER, _SPEEDS, _SQUARES, _LEAST = begins(_LAYOUT, "speed", "number", "speeds", "squares", "least")


@dataclass(frozen=True, eq=False)
class CountedImpacts(Request):
    """The impacts on each wall and contact that are not slow, and on all of them under an empty name.

    Of several walls of one mass they are added in the order of the impacts.
    """

    counts_fast_impacts: ClassVar[bool] = True

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[CountedImpacts]:
        motion = plan.motion
        if not motion.touched:
            raise ValueError("slowest_counted_impact needs a wall or a contact: there are no impacts to count.")
        slowest = wishes["slowest_counted_impact"]
        speed = finite_number(slowest, "slowest_counted_impact", low=0.0, hint="It is a speed in m/s.")
        together = [""] if len(motion.touched) > 1 and not motion.arguments else []
        yield cls(tuple(faster_than(speed, wall) for wall in (*together, *motion.touched)))

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        low, high = simulation.settings.window_steps
        time = (high - low) * simulation.settings.step
        sums = {own.signal.stop or "": np.array([*ensemble.observed[own].values()]) for own in self.observers}
        if "" not in sums:
            sums = {"": sum(sums.values(), np.zeros((3, 1))), **sums}
        found, errors = dict[str, tuple[float, Floats]](), dict[str, float]()
        for wall, (number, speeds, squares) in sums.items():
            rate = number / time
            of_fast = (float(rate.mean()), rate), ratio(speeds, number), ratio(squares, number)
            names = [f"{wall}_{name}" if wall else name for name in COUNTED]
            found |= dict(zip(names, of_fast, strict=True))
            if not number.any():
                errors[names[0]] = error_of_unseen(number.size * (high - low) * simulation.settings.step)
        return {"estimates": found, "errors": errors}


def faster_than(speed: float, stop: str) -> Observer:
    """Impacts at this speed, in m/s, or faster: their number, the sum of the speeds and of their squares.

    ``stop``: on which wall or contact; empty for all.
    """
    return counted(Signal(number=None, stop=stop), speed)


def counted(signal: Signal, least: float = 0.0) -> Observer:
    """As `faster_than`, of what is seen of impacts: speeds, impulses or the largest forces of touches."""
    initial = np.zeros((), _LAYOUT)
    initial["least"] = least
    return Observer(signal, None, _on_fast_impacts(), initial, of_paths=("number", "speeds", "squares"))


@cache
def _on_fast_impacts() -> Any:
    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        before = array[_SPEED_UNIT] * speed
        if before >= array[_LEAST]:
            array[_NUMBER + lane] += count
            array[_SPEEDS + lane] += count * before
            array[_SQUARES + lane] += count * before * before

    return on_impacts
