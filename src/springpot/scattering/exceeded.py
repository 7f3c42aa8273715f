"""What `springpot.exceedance_over_devices` returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.machine.arguments import LARGEST, finite_number, text
from springpot.machine.arrays import Floats
from springpot.machine.faults import with_error
from springpot.machine.plain import plain
from springpot.problem.system import System
from springpot.scattering.estimates import BELOW, Interval
from springpot.scattering.own_probability import OwnProbability
from springpot.simulation.plan.settings import Settings
from springpot.simulation.rare.search import ExceedanceCurve, ProbabilityWithin


@dataclass(frozen=True, eq=False, kw_only=True)
class DeviceExceedance:
    """Probabilities over devices that the largest value of a quantity exceeds levels.

    Attributes
    ----------
    name, unit : str
    levels : ndarray
        In the order of rarity; nominal values where they are uncertain.
    probability, error, low, high : ndarray
        Of each level, over the devices: the mean of their own probabilities, its standard error, and the ends of its
        95 % interval.
    nominal : ExceedanceCurve
        Of the nominal device.
    splits : bool
        Whether by splitting; otherwise by plain paths.
    repetitions, paths : int
        Independent repetitions, and the paths of each.
    path_steps : float
    draws : ndarray, shape (devices, numbers)
        The values of the uncertain numbers.
    shares : ndarray, shape (devices,)
        Of each device in the probability of the last level: which devices exceed it.
    largest : float
        The largest share that comes from one path at the start.
    by_mean, by_scatter : dict
        By the names of numbers that depend on no other, of each level an `Interval`: the relative change of the
        probability by the mean of the number's normal score, in standard deviations, and by the logarithm of its
        standard deviation.
    of_devices : OwnProbability or None
        How the devices' own probabilities of the last level differ; None where too few devices exceeded it, or no path
        was split.
    limit : float or None
        Of a device's own probability.
    downwards : bool
        Whether a level is exceeded by what is below it.
    duration : float
        The time in s.
    stationary : bool
        Whether the time begins in the stationary state.
    """

    name: str
    unit: str
    levels: Floats
    probability: Floats
    error: Floats
    low: Floats
    high: Floats
    nominal: ExceedanceCurve
    splits: bool
    repetitions: int
    paths: int
    path_steps: float
    draws: Floats
    shares: Floats
    largest: float
    by_mean: dict[str, list[Interval]]
    by_scatter: dict[str, list[Interval]]
    of_devices: OwnProbability | None
    limit: float | None
    downwards: bool
    duration: float
    stationary: bool

    def within(self, duration: float) -> ProbabilityWithin:
        """The probability over devices that the last level is exceeded within a longer time.

        It is the mean of 1 - (1 - p)^n over the devices, with p the probability of each within the time of the paths
        and n how often that goes into the longer time.  It is smaller than this of the mean of p, since devices that
        exceed the level often do it once.

        Parameters
        ----------
        duration : float
            In s, at least that of the paths.

        Returns
        -------
        ProbabilityWithin

        Raises
        ------
        TypeError, ValueError
            If it is no such number, the time does not begin in the stationary state, or too few devices exceeded the
            level for their own probabilities.

        Notes
        -----
        It assumes that first exceedances of a device follow a Poisson process.  Paths that are beyond the level when
        the time begins count in each part of the longer time: some too many where a part is not long against the
        motion.

        Examples
        --------
        That of :func:`springpot.exceedance_over_devices` has an hour.
        """
        time = finite_number(
            duration, "duration", low=self.duration, high=LARGEST, hint="It is in s, at least that of the paths."
        )
        refused = f"duration must be that of the paths, {self.duration:g} s:"
        if not (self.stationary and self.nominal.settles):
            raise ValueError(f"{refused} their time does not begin in the stationary state.")
        own = self.of_devices
        if own is None:
            raise ValueError(
                f"{refused} the mean over devices of 1 - exp(-rate t) needs the rate of each device, and too few "
                "devices exceeded the last level to tell these."
            )
        p, error, low, high = (float(each[-1]) for each in (self.probability, self.error, self.low, self.high))
        times = own.times_within(time / self.duration)
        found = p * times.value, times.value * error + p * times.error, low * times.low, min(high * times.high, 1.0)
        return ProbabilityWithin(time, *map(np.asarray, found))

    @property
    def devices_seen(self) -> int:
        """How many different devices exceeded the last level."""
        return int(np.count_nonzero(self.shares))

    @property
    def said(self) -> Iterator[str]:
        """The lines of a report."""
        than, alone = "<" if self.downwards else ">", self.nominal
        for n, level in enumerate(self.levels.tolist()):
            p, error = float(self.probability[n]), float(self.error[n])
            yield f"{self.name} {than} {level:g} {self.unit}".strip()
            yield f"  nominal device        {alone.said[n].split(', once')[0]}"
            if not p > 0.0:
                yield f"  over devices          at most {self.high[n]:.2g}"
                continue
            times = f", {p / alone.probability[n]:.3g} times that" if alone.probability[n] > 0.0 else ""
            yield f"  over devices          {with_error(p, error)}, {_brackets(self.low[n], self.high[n])}{times}"
        if not self.probability[-1] > 0.0:
            return
        own = self.of_devices
        if own is not None:
            yield "  from device to device, at the last level"
            for share, found in own.quantiles.items():
                words = f"{found.value:.2g} {_brackets(found.low, found.high)}"
                yield f"    {100.0 * share:4.0f} % of devices are below {words}"
            yield f"    {100.0 * BELOW:4.0f} % of devices are below {own.tolerance:.2g}, 95 % sure"
        if own is not None and own.above is not None:
            share, ends = 100.0 * own.above.value, _brackets(100.0 * own.above.low, 100.0 * own.above.high)
            yield f"  limit {self.limit:<16g}{share:5.1f} % {ends} of the devices are above"
        tied = [] if own is None else [name for name in own.alone if name not in self.by_mean]
        if self.by_mean or tied:
            yield "  which number matters  mean + 0.1 deviation  1 % less scatter   index of the logarithm, total"
        for name in [*sorted(self.by_mean, key=lambda each: -abs(self.by_mean[each][-1].value)), *tied]:
            moments = indices = ""
            if name in self.by_mean:
                mean, scatter = self.by_mean[name][-1], self.by_scatter[name][-1]
                moments = (
                    f"{10.0 * mean.value:+6.1f} +- {10.0 * mean.error:.1f} %"
                    f"{-scatter.value:+13.2f} +- {scatter.error:.2f} %"
                )
            if own is not None:
                indices = f"{100.0 * own.alone[name].value:5.1f} % {100.0 * own.together[name].value:9.1f} %"
            yield f"    {name:18}{moments:39}    {indices}".rstrip()


def _brackets(low: float, high: float) -> str:
    return f"({low:.2g} to {high:.2g})"


@dataclass(frozen=True, eq=False)
class DevicesThatExceed:
    """Probabilities of rare events over devices; made by `springpot.exceedance_over_devices`.

    Attributes
    ----------
    system : System
        With its uncertain numbers.
    settings : Settings
    numbers, inputs : tuple of str
        The uncertain numbers, and the same with those in one word that depend on each other.
    curves : dict of DeviceExceedance
        By quantity; ``found["x"]`` is one of them.
    duration : float
        In s.
    warnings : tuple of str
    """

    system: System
    settings: Settings
    numbers: tuple[str, ...]
    inputs: tuple[str, ...]
    curves: dict[str, DeviceExceedance]
    duration: float
    warnings: tuple[str, ...]

    def __getitem__(self, name: str) -> DeviceExceedance:
        return self.curves[text(name, "the name of a curve")]

    def __iter__(self) -> Iterator[str]:
        return iter(self.curves)

    def __str__(self) -> str:
        return self.report(warnings=False)  # they were raised

    def report(self, *, warnings: bool = True) -> str:
        """All of it on a screen: ``+-`` is one standard error, and brackets hold with 95 %."""
        many, few = len(next(iter(self.curves.values())).draws), len(self.numbers)
        words = f"{few} uncertain number{'s' if few > 1 else ''}, {many} devices"
        lines = [f"Exceedance in {self.duration:g} s, {words}. Brackets hold with 95 %."]
        for curve in self.curves.values():
            lines += ["", *curve.said]
        told = [f"warning: {each}" for each in self.warnings] if warnings else []
        return "\n".join([*lines, *([""] if told else []), *told])

    def to_dict(self) -> dict[str, Any]:
        """All but the draws, as plain numbers, words, lists and dicts; what is not finite is None."""

        def of(curve: DeviceExceedance) -> dict[str, Any]:
            names = "name", "unit", "levels", "probability", "error", "low", "high", "splits", "repetitions", "paths"
            found: dict[str, Any] = {name: getattr(curve, name) for name in (*names, "largest", "limit")}
            found |= {"nominal": curve.nominal.to_dict(), "devices": len(curve.draws)}
            found |= {name: getattr(curve, name) for name in ("devices_seen", "by_mean", "by_scatter")}
            if (own := curve.of_devices) is not None:
                found |= {"quantiles": own.quantiles, "tolerance": own.tolerance, "above": own.above}
                found |= {"index": own.alone, "total_index": own.together}
            return found

        return plain({
            "curves": {name: of(curve) for name, curve in self.curves.items()}, "numbers": self.numbers,
            "inputs": self.inputs, "settings": self.settings.to_dict(), "warnings": self.warnings,
        })  # fmt: skip
