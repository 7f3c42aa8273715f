"""The spectrum of x, estimated in the run: one windowed Fourier sum for each path and frequency.

The whole window of a path is one segment with a Hann taper.  The mean is subtracted, and the periodograms of the paths
are averaged; standard errors come from independent paths.  The estimate is the density averaged over frequencies with a
root mean square width of ``resolution`` = sqrt(4/3) pi / length, which lowers a Lorentzian peak of half-width g by
about (resolution / g)^2.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import items_of, positive_number
from springpot.machine.arrays import Columns, Floats
from springpot.problem.catalogue import unit_of_result
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, LANES, stack_array
from springpot.simulation.kernel.watching import ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.watch.forces import signals_of_forces
from springpot.simulation.watch.requested import Observed, Request

MOST_SUMS = 30_000_000  # stored numbers, 0.24 GB; evaluation needs about four times as much
SAMPLES_PER_CYCLE = 12  # of the fastest rate and the highest frequency, against aliasing
FEWEST_CYCLES = 2.0  # of the lowest frequency in the window


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Two-sided spectral density of a displacement about its mean.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        In rad/s.
    density, standard_error : ndarray, shape (n,)
        In ``unit``, of a displacement m^2 s per rad: the integral of the density over all frequencies, negative ones
        too, is the variance of x.
    resolution : float
        Each value is an average over frequencies with this root mean square width, in rad/s.
    unit : str
        Of the density.
    """

    frequency: Floats
    density: Floats
    standard_error: Floats
    resolution: float
    unit: str

    def columns(self, name: str, probabilities: Sequence[float]) -> Columns:
        """Everything for tables and files."""
        axes = ("frequency",)
        return {
            "frequency": (axes, self.frequency, {"units": "rad s-1"}),
            f"{name}_spectrum": (axes, self.density, {"units": self.unit, "resolution": self.resolution}),
            f"{name}_spectrum_se": (axes, self.standard_error, {"units": self.unit}),
        }


def step_for(highest: float) -> float:
    """The longest step that resolves a frequency in rad/s, in s."""
    return 2.0 * math.pi / (SAMPLES_PER_CYCLE * GROUP * highest)


_HALF = 8  # of the samples of a path that are added together
_one, _halves = stack_array(_HALF), stack_array(_HALF * LANES)


def _layout(count: int) -> np.dtype[np.void]:
    """Of an array for so many frequencies: sums of each path; tables; how far all have turned; samples that wait."""
    return layout(
        cosines=(count, LANES), sines=(count, LANES), weighed=LANES, every=(), even=(count, _HALF), odd=(count, _HALF),
        turned=(2, count), reached=(2, count), waiting=(2 * _HALF, LANES),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class FourierSums(Request):
    """The spectrum of a displacement, a force or an acceleration, from the Fourier sums of each path.

    Attributes
    ----------
    frequencies : ndarray
        In rad/s.
    """

    frequencies: Floats

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[FourierSums]:
        settings, fastest = plan.settings, plan.motion.scales.fastest_rate
        moving = [signal for signal in (*plan.motion.signals, *signals_of_forces(plan, wishes)) if "x" in signal.names]
        frequencies = _checked(wishes["spectrum"], settings, fastest, len(moving))
        spacing = 2.0 * math.pi / (SAMPLES_PER_CYCLE * max(float(frequencies.max()), fastest))
        every = max(1, int(spacing / (GROUP * settings.step)))
        turns = frequencies * settings.step * GROUP * every  # from one sample to the next
        about = np.outer(turns, np.arange(_HALF) + 0.5)  # from the middle of those that are added together
        initial = np.zeros((), _layout(frequencies.size))
        initial["every"], initial["even"], initial["odd"] = every, np.cos(about), np.sin(about)
        initial["turned"] = np.cos(2 * _HALF * turns), np.sin(2 * _HALF * turns)
        initial["reached"][0] = 1.0  # a turn by which all sums differ makes no difference
        compiled, kept = _compiled(frequencies.size), ("cosines", "sines", "weighed")
        for signal in moving:
            yield cls((Observer(signal, compiled, None, initial, of_paths=kept, every=every),), frequencies)

    @classmethod
    def longest_step(cls, motion: Motion, wishes: Mapping[str, Any]) -> float:
        with contextlib.suppress(TypeError, ValueError):
            return step_for(max(motion.scales.fastest_rate, *map(float, wishes["spectrum"])))
        return math.inf

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        settings, frequencies, sums = simulation.settings, self.frequencies, ensemble.observed[self.observer]
        spacing, (low, high) = GROUP * self.observer.every, settings.window_steps
        n = np.arange(low // GROUP * GROUP, high, spacing)
        n = n[n >= low]
        taper = np.sin(np.pi * (n + 0.5 - low) / (high - low)) ** 2
        since = n - n[0] - (_HALF - 0.5) * spacing
        turned = np.exp(-1j * np.outer(since, frequencies * settings.step)).T @ taper
        paths = sums["cosines"] + 1j * sums["sines"]
        mean = sums["weighed"].mean() / taper.sum()  # over all paths: the mean of one path contains its slow motion
        periodograms = np.abs(paths - mean * turned) ** 2
        periodograms *= spacing * settings.step / (2.0 * np.pi * (taper**2).sum())
        error = np.full(frequencies.size, np.nan)
        if len(paths) > 1:
            error = periodograms.std(axis=0, ddof=1) / math.sqrt(len(paths))
        resolution = math.sqrt(4.0 / 3.0) * math.pi / ((high - low) * settings.step)
        name = self.observer.signal.names["x"]
        unit = unit_of_result(simulation.motion.system, f"{name}_spectrum")
        return {"spectra": {name: Spectrum(frequencies, periodograms.mean(axis=0), error, resolution, unit)}}


def _checked(frequencies: npt.ArrayLike, settings: Settings, fastest: float, spectra: int) -> Floats:
    """The frequencies of so many spectra as an array; ``fastest`` is the fastest rate of the problem, in 1/s.

    Raises
    ------
    TypeError, ValueError
        If they are not positive numbers, too many, too high for the step or too low for the window.
    """
    given = [
        positive_number(w, "spectrum frequency")
        for w in items_of(frequencies, "spectrum must be a sequence of frequencies in rad/s")
    ]
    if not given:
        raise ValueError("spectrum must hold at least one frequency.")
    values = np.array(given)
    if (2 * values.size + 1) * settings.paths * spectra > MOST_SUMS:
        most = MOST_SUMS // (2 * settings.paths * spectra)
        raise ValueError(
            f"spectrum must hold at most {most} frequencies for {settings.paths} paths, not {values.size}."
        )
    length = settings.window[1] - settings.window[0]
    if (lowest := float(values.min())) * length < FEWEST_CYCLES * 2.0 * math.pi:
        raise ValueError(
            f"spectrum goes down to {lowest:g} rad/s, too low for a window of {length:g} s: use a window of at least "
            f"{FEWEST_CYCLES * 2.0 * math.pi / lowest:.3g} s."
        )
    highest = max(float(values.max()), fastest)
    if settings.step > (longest := step_for(highest)) * (1.0 + 1e-9):
        raise ValueError(
            f"spectrum has to resolve {highest:g} rad/s, too fast for a step of {settings.step:g} s: use a step of "
            f"at most {longest:.2g} s."
        )
    return values


@cache
def _compiled(count: int) -> Any:
    """Samples wait until there are enough; what is even and what is odd about their middle needs half the products."""
    length, cosines, sines, weighed, every, even, odd, turned, reached, waiting = begins(
        _layout(count), "length", "cosines", "sines", "weighed", "every", "even", "odd", "turned", "reached", "waiting"
    )

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        if n < low or n >= high:
            return
        spacing = GROUP * int(array[every])
        place = (n - low) // spacing % (2 * _HALF)
        scale = math.sin(math.pi * (n + 0.5 - low) / (high - low)) ** 2 * array[length]
        for lane in range(LANES):
            array[waiting + place * LANES + lane] = scale * x[lane]
        if place < 2 * _HALF - 1 and n + spacing < high:
            return
        for i in range((place + 1) * LANES, 2 * _HALF * LANES):
            array[waiting + i] = 0.0
        plus, minus, a, b = _halves(0.0), _halves(0.0), _one(0.0), _one(0.0)
        for m in range(_HALF):
            for lane in range(LANES):
                later = array[waiting + (_HALF + m) * LANES + lane]
                sooner = array[waiting + (_HALF - 1 - m) * LANES + lane]
                plus[m * LANES + lane], minus[m * LANES + lane] = later + sooner, later - sooner
        for m in range(_HALF):
            for lane in range(LANES):
                array[weighed + lane] += plus[m * LANES + lane]
        for k in range(count):
            c, s = array[reached + k], array[reached + count + k]
            for m in range(_HALF):
                a[m], b[m] = array[even + k * _HALF + m], array[odd + k * _HALF + m]
            for lane in range(LANES):
                real = imaginary = 0.0
                for m in range(_HALF):
                    real += a[m] * plus[m * LANES + lane]
                    imaginary += b[m] * minus[m * LANES + lane]
                array[cosines + k * LANES + lane] += c * real - s * imaginary
                array[sines + k * LANES + lane] -= s * real + c * imaginary
            ahead, aside = array[turned + k], array[turned + count + k]
            array[reached + k], array[reached + count + k] = c * ahead - s * aside, s * ahead + c * aside

    return on_steps
