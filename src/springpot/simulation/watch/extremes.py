"""The largest and smallest values of each path in the window, at the ends of the steps and at the impacts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, LANES, greater, lesser
from springpot.simulation.kernel.watching import ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.forces import signals_of_forces
from springpot.simulation.watch.requested import Observed, Request

EXTREMES = "x_minimum", "x_maximum", "v_largest", "impact_speed_largest"  # speeds without sign

_LAYOUT = layout(**dict.fromkeys(EXTREMES, LANES), unplaced=())
_LENGTH, _SPEED_UNIT, _WALL, _LEAST, _MOST, _FASTEST, _HARDEST, _UNPLACED = begins(
    _LAYOUT, "length", "speed", "wall", *EXTREMES, "unplaced"
)


@dataclass(frozen=True, eq=False)
class Extremes(Request):
    """The EXTREMES of a displacement, a force or an acceleration."""

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[Extremes]:
        yield from map(cls.of, (*plan.motion.signals, *signals_of_forces(plan, wishes)))

    @classmethod
    def of(cls, signal: Signal) -> Extremes:
        """Of this one."""
        initial = np.full((), -math.inf, _LAYOUT)
        initial["x_minimum"], initial["unplaced"] = math.inf, math.isnan(signal.place)
        return cls((Observer(signal, *_compiled(), initial, of_paths=EXTREMES),))

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        """NaN without an impact."""
        names, found = self.observer.signal.names, {}
        for name, samples in ensemble.observed[self.observer].items():
            quantity, _, end = name.rpartition("_")
            if quantity in names:
                found[f"{names[quantity]}_{end}"] = np.where(np.isfinite(samples), samples, np.nan)
        return {"extremes": found}


@cache
def _compiled() -> tuple[Any, Any]:
    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        length, speed = array[_LENGTH], array[_SPEED_UNIT]
        first, end = max(low - n, 0), min(high - n, GROUP)
        for lane in range(LANES):
            least, most, fastest = math.inf, -math.inf, -math.inf
            for j in range(GROUP):
                if first <= j < end:
                    here = x[j * LANES + lane]
                    least, most = lesser(least, here), greater(most, here)
                    fastest = greater(fastest, abs(v[j * LANES + lane]))
            if length < 0.0:  # of a wall above
                least, most = most, least
            array[_LEAST + lane] = lesser(array[_LEAST + lane], length * least)
            array[_MOST + lane] = greater(array[_MOST + lane], length * most)
            array[_FASTEST + lane] = greater(array[_FASTEST + lane], speed * fastest)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        # the state just before the impact is an extreme of the step
        wall, reached = array[_LENGTH] * array[_WALL], array[_SPEED_UNIT] * speed
        if array[_UNPLACED] == 0.0:  # else it is not known which wall was struck
            array[_LEAST + lane] = min(array[_LEAST + lane], wall)
            array[_MOST + lane] = max(array[_MOST + lane], wall)
        for at in (_FASTEST + lane, _HARDEST + lane):
            array[at] = max(array[at], reached)

    return on_steps, on_impacts
