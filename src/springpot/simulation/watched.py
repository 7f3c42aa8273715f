"""What a caller wants observed beside the moments, and what came of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.oscillator import Oscillator
from springpot.simulation.ensemble import Ensemble, Tables
from springpot.simulation.lanes import GROUP
from springpot.simulation.observers import (
    EXTREMES,
    Distribution,
    Observer,
    distributions_in,
    extremes,
    mean_of,
    sketches,
)
from springpot.simulation.settings import Settings, mirror

__all__ = ["Observable", "Watched"]

Observable = Callable[..., float]


@dataclass(frozen=True)
class Watched:
    """What is observed beside the moments: the user's functions first, then sketches and extremes."""

    observables: Mapping[str, Observable]
    impact_observables: Mapping[str, Observable]
    distributions: bool

    def __post_init__(self) -> None:
        for name in ("observables", "impact_observables"):
            if not isinstance(getattr(self, name), Mapping):
                raise TypeError(f"{name} must be a dict of names and functions, not {getattr(self, name)!r}.")
        if both := set(self.observables) & set(self.impact_observables):
            raise ValueError(f"{min(both)!r} cannot name an observable and an impact observable at once.")
        if not isinstance(self.distributions, bool):
            raise TypeError(f"distributions must be True or False, not {self.distributions!r}.")

    @property
    def anything(self) -> bool:
        """Whether there is anything to observe."""
        return bool(self.observables or self.impact_observables or self.distributions)

    def observers(self, step: float) -> tuple[Observer, ...]:
        """The observers, for a step in units of the shortest time scale."""
        return (
            *(mean_of(name, function, "state") for name, function in self.observables.items()),
            *(mean_of(name, function, "impact") for name, function in self.impact_observables.items()),
            *((sketches(GROUP * step), extremes()) if self.distributions else ()),
        )

    def means(self, settings: Settings, found: Ensemble) -> dict[str, npt.NDArray[np.float64]]:
        """Of each observable what every path contributes: a mean over the window, or a sum of impacts per second."""
        low, high = settings.window_steps
        over = [high - low] * len(self.observables) + [(high - low) * settings.step] * len(self.impact_observables)
        names = [*self.observables, *self.impact_observables]
        return {name: sums[:, 0] / n for name, sums, n in zip(names, found.observed, over, strict=False)}

    def sketched(self, oscillator: Oscillator, made: Tables, found: Ensemble) -> dict[str, Distribution]:
        """By name, if they were asked for."""
        if not self.distributions:
            return {}
        return distributions_in(
            found.observed[-2],
            length=made.length,
            speed=made.length / made.time,
            sign=mirror(oscillator),
            wall=None if oscillator.barrier is None else oscillator.barrier.position,
        )

    def extremes(self, found: Ensemble) -> dict[str, npt.NDArray[np.float64]]:
        """By name, if they were asked for."""
        return dict(zip(EXTREMES, found.observed[-1].T, strict=True)) if self.distributions else {}
