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
from springpot.simulation.settings import Settings, fastest_rate, mirror
from springpot.simulation.spectral import Spectrum, checked_frequencies, spectral, spectrum_in

__all__ = ["Observable", "Watched"]

Observable = Callable[..., float]


@dataclass(frozen=True)
class Watched:
    """What is observed beside the moments: the user's functions, then sketches and extremes, then the spectrum."""

    observables: Mapping[str, Observable]
    impact_observables: Mapping[str, Observable]
    distributions: bool
    spectrum: npt.ArrayLike | None

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
        return bool(self.observables or self.impact_observables or self.distributions or self.spectrum is not None)

    def observers(self, oscillator: Oscillator, settings: Settings) -> tuple[Observer, ...]:
        """The observers, compiled.

        Raises
        ------
        TypeError, ValueError
            If a function cannot be compiled or a frequency is none.
        """
        group = GROUP * settings.step * fastest_rate(oscillator)
        frequencies = None if self.spectrum is None else checked_frequencies(self.spectrum, settings)
        return (
            *(mean_of(name, function, "state") for name, function in self.observables.items()),
            *(mean_of(name, function, "impact") for name, function in self.impact_observables.items()),
            *((sketches(group), extremes()) if self.distributions else ()),
            *(() if frequencies is None else (spectral(frequencies, settings),)),
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
            found.observed[self._first_sketch],
            length=made.length,
            speed=made.length / made.time,
            sign=mirror(oscillator),
            wall=None if oscillator.barrier is None else oscillator.barrier.position,
        )

    def extremes(self, found: Ensemble) -> dict[str, npt.NDArray[np.float64]]:
        """By name, if they were asked for."""
        if not self.distributions:
            return {}
        return dict(zip(EXTREMES, found.observed[self._first_sketch + 1].T, strict=True))

    def spectrum_found(self, settings: Settings, found: Ensemble) -> Spectrum | None:
        """The spectrum, if it was asked for."""
        if self.spectrum is None:
            return None
        return spectrum_in(checked_frequencies(self.spectrum, settings), settings, found.observed[-1])

    @property
    def _first_sketch(self) -> int:
        return len(self.observables) + len(self.impact_observables)
