"""From an oscillator and settings to the kernel's parts and tables, in the kernel's own units.

The kernel always sees a wall below the motion; a wall above is its mirror image, x -> -x.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.memory import ExponentialSum, direct, exponential_sum
from springpot.memory.weights import Family
from springpot.oscillator import Oscillator
from springpot.simulation.kernel import Memory
from springpot.simulation.lanes import GROUP, MOST_MODES
from springpot.simulation.parts import (
    Euler,
    NoWall,
    Rigid,
    Splitting,
    Start,
    White,
    euler,
    newest_weights_splitting,
    splitting,
)
from springpot.simulation.scales import fastest_rate
from springpot.simulation.settings import Settings

__all__ = ["Tables", "family", "mirror", "recent_weights", "tables"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tables:
    """The parts and tables a kernel needs for one oscillator and one step.

    Attributes
    ----------
    scheme, wall, load, memory, start
        Parts of the kernel.
    drive : ndarray
        Force in each step that stems from x(0), or empty (Caputo's derivative, or x(0) = 0).
    expected_power : float
        Mean power that the noise feeds into this scheme's motion, q/2 up to the order of the step.
    length, time : float
        The kernel's units, powers of two, in m and s: whatever the problem's scales, what it computes with is near 1,
        and a change of scale by a power of two changes no bit.
    sum : ExponentialSum
        The memory before it was given units.
    """

    scheme: Splitting | Euler
    wall: NoWall | Rigid
    load: White
    memory: Memory
    start: Start
    drive: npt.NDArray[np.floating]
    expected_power: float
    length: float
    time: float
    sum: ExponentialSum


def family(settings: Settings) -> Family:
    """The weights of the past that a scheme uses."""
    return "grunwald" if settings.scheme == "grunwald" else "average"


def tables(oscillator: Oscillator, settings: Settings) -> Tables:
    """Everything the kernel needs, computed once per run."""
    length, time = _units(oscillator, settings)
    order, sign = oscillator.springpot.order, mirror(oscillator)
    coefficient = oscillator.springpot.coefficient * time ** (2.0 - order)
    frequency, step = oscillator.natural_frequency * time, settings.step / time
    intensity = oscillator.excitation.intensity / length**2 * time**3
    x0, v0 = sign * settings.initial_position / length, sign * settings.initial_velocity / length * time
    scale = coefficient * step**-order
    past = exponential_sum(family(settings), order, settings.steps + 1, settings.memory_tolerance)
    scheme: Splitting | Euler
    if settings.scheme == "grunwald":
        scheme = euler(frequency, step, settings.contact_tolerance / length)
        older, share = 0.0, 1.0
    else:
        scheme = splitting(frequency, order, coefficient, step)
        older, share = newest_weights_splitting(order)[1], scheme.share
    drive = _drive(order, scale, x0, settings)
    # Riemann-Liouville's force at the start is largest at once, and the kick that stands for its first step comes later
    late = settings.scheme == "default" and drive.size > 0
    early = -float(drive[0]) * step**2 * 0.5 * order / (2.0 - order) if late else 0.0
    barrier = oscillator.barrier
    wall = NoWall(0.0) if barrier is None else Rigid(sign * barrier.position / length, barrier.restitution)
    return Tables(
        scheme=scheme,
        wall=wall,
        load=White(math.sqrt(intensity * step)),
        memory=_memory(past, scale, recent_weights(order, settings), older, settings.precision),
        start=Start(x0, v0, 0.5 * (v0 * v0 + frequency * frequency * x0 * x0), early),
        drive=drive,
        expected_power=0.5 * oscillator.excitation.intensity * share,
        length=length,
        time=time,
        sum=past,
    )


def _units(oscillator: Oscillator, settings: Settings) -> tuple[float, float]:
    """Powers of two near the largest length and the shortest time of the problem."""
    time = 2.0 ** round(-math.log2(fastest_rate(oscillator)))
    lengths = (
        oscillator.length_scale,
        abs(settings.initial_position),
        abs(settings.initial_velocity) / oscillator.natural_frequency,
        0.0 if oscillator.barrier is None else abs(oscillator.barrier.position),
    )
    longest = max(lengths)
    return (2.0 ** round(math.log2(longest)) if longest > 0.0 else 1.0), time


def recent_weights(order: float, settings: Settings) -> Floats:
    """Weights of the four newest increments, in units of h^-alpha."""
    weights = direct(family(settings), order, GROUP)
    if settings.scheme == "default":
        weights[:2] += newest_weights_splitting(order)
    return weights


def _memory(past: ExponentialSum, scale: float, recent: Floats, older: float, precision: str) -> Memory:
    if past.rates.size > MOST_MODES:
        raise ValueError(f"memory_tolerance asks for {past.rates.size} memory modes; the kernel holds {MOST_MODES}.")
    # an even number of modes, for the kernel takes two at a time; the odd one out weighs nothing
    size = past.rates.size + past.rates.size % 2
    rates, strengths = np.zeros(size), np.zeros(size)
    rates[: past.rates.size], strengths[: past.rates.size] = past.rates, scale * past.weights
    powers = np.exp(-np.outer(rates, np.arange(1, GROUP + 1)))
    weights_of_modes = strengths[:, None] * powers
    powers[:, -1] = np.expm1(-GROUP * rates)
    return Memory(
        powers.ravel().astype(precision),
        weights_of_modes.ravel().astype(precision),
        *(np.dtype(precision).type(scale * w) for w in (recent[0], older, *recent[1:])),
    )


def _drive(order: float, scale: float, x0: float, settings: Settings) -> npt.NDArray[np.floating]:
    """Riemann-Liouville's x(0) t^-alpha / Gamma(1 - alpha), as the scheme's own weights see it."""
    if settings.derivative == "caputo" or x0 == 0.0:
        return np.zeros(0, settings.precision)
    weights = direct(family(settings), order, settings.steps + GROUP)
    return np.asarray(scale * x0 * weights, settings.precision)


def mirror(oscillator: Oscillator) -> float:
    """1 for a wall below the motion (or none), -1 for a wall above it."""
    return oscillator.direction or 1.0
