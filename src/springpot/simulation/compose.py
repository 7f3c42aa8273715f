"""From an oscillator and settings to the kernel's parts, and from its sums back: units and side are converted here.

In the kernel the wall is always below the motion; a wall above is mirrored, x -> -x.  The kernel's units are powers of
two near the problem's scales, so that its numbers are near 1 and a change of scale by a power of two changes no bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from springpot.memory import ExponentialSum, direct, exponential_sum
from springpot.oscillator import Oscillator
from springpot.simulation import parts
from springpot.simulation.forces import White
from springpot.simulation.kernel import COLUMNS, Memory
from springpot.simulation.lanes import GROUP, MOST_MODES
from springpot.simulation.parts import Start
from springpot.simulation.scales import Scales
from springpot.simulation.schemes import NumericalScheme
from springpot.simulation.settings import Settings
from springpot.simulation.walls import NoWall, Rigid

__all__ = ["Floats", "Parts", "Units", "compose"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Units:
    """The kernel's units, and whether the motion is mirrored.

    Attributes
    ----------
    length, time : float
        In m and s.
    sign : float
        -1 if the motion is mirrored, otherwise 1.
    """

    length: float
    time: float
    sign: float

    @property
    def speed(self) -> float:
        """In m/s."""
        return self.length / self.time

    def into(self, x: float, v: float) -> tuple[float, float]:
        """A state in the kernel's units, from one in m and m/s."""
        return self.sign * x / self.length, self.sign * v / self.length * self.time

    @property
    def state(self) -> tuple[float, float]:
        """Factors for x and v of the kernel."""
        return self.sign * self.length, self.sign * self.speed

    @property
    def columns(self) -> list[float]:
        """Factors for the COLUMNS of the kernel."""
        (x, v), square = self.state, self.speed**2
        force, power = v / self.time, square / self.time
        units = {
            "x": x, "x_square": self.length**2, "v_square": square, "force": force, "power": power, "virial": square,
            "impacts": 1.0, "impact_speeds": self.speed, "impact_speed_squares": square, "collapses": 1.0,
            "energy_first": square, "energy_last": square, "x_end": x, "v_end": v,
        }  # fmt: skip
        return [units[name] for name in COLUMNS]


@dataclass(frozen=True, eq=False)
class Parts:
    """The arguments of the kernel for one oscillator and one step.

    Attributes
    ----------
    scheme, wall, load, memory, start
        Parts of the kernel, in its units.
    drive : ndarray
        Force in each step due to x(0); empty with Caputo's derivative, or if x(0) = 0.
    frequency : float
        Omega in the kernel's units.
    expected_power : float
        Mean input power of the noise in this scheme, q/2 plus terms of the order of the step; in m^2/s^3.
    units : Units
    history : ExponentialSum
        The memory without units.
    """

    scheme: parts.Splitting | parts.Euler
    wall: NoWall | Rigid
    load: White
    memory: Memory
    start: Start
    drive: npt.NDArray[np.floating]
    frequency: float
    expected_power: float
    units: Units
    history: ExponentialSum

    @property
    def wall_position(self) -> float:
        """Place of the wall in the kernel's units; 0 without one."""
        return self.wall.position if isinstance(self.wall, Rigid) else 0.0


def compose(oscillator: Oscillator, settings: Settings, scales: Scales) -> Parts:
    """The arguments of the kernel.

    Raises
    ------
    ValueError
        If x(0) is not known yet, or the memory has too many terms for the kernel.
    """
    position = settings.initial_position
    if position is None:
        raise ValueError("initial_position of a stationary start is known after its pilot runs only.")
    units = _units(oscillator, position, settings.initial_velocity, scales)
    length, time, order = units.length, units.time, oscillator.springpot.order
    coefficient = oscillator.springpot.coefficient * time ** (2.0 - order)
    frequency, step = oscillator.natural_frequency * time, settings.step / time
    intensity = oscillator.excitation.intensity / length**2 * time**3
    x0, v0 = units.into(position, settings.initial_velocity)
    scale = coefficient * step**-order
    scheme = settings.numerical_scheme
    history = exponential_sum(scheme.family, order, settings.steps + 1, settings.memory_tolerance)
    at_this_step = scheme.at(frequency, order, coefficient, step, length)
    drive = _drive(order, scale, x0, settings)
    early = scheme.early_displacement(order, float(drive[0]), step) if drive.size > 0 else 0.0
    barrier = oscillator.barrier
    wall = NoWall(0.0) if barrier is None else Rigid(units.into(barrier.position, 0.0)[0], barrier.restitution)
    return Parts(
        scheme=at_this_step,
        wall=wall,
        load=White(math.sqrt(intensity * step)),
        memory=_memory(history, scale, scheme, order, settings.precision),
        start=Start(np.array([[x0, v0, 0.5 * (v0 * v0 + frequency * frequency * x0 * x0)]]), early),
        drive=drive,
        frequency=frequency,
        expected_power=0.5 * oscillator.excitation.intensity * at_this_step.share,
        units=units,
        history=history,
    )


def _units(oscillator: Oscillator, position: float, velocity: float, scales: Scales) -> Units:
    """Powers of two near the largest length and the shortest time of the problem."""
    longest = max(
        oscillator.length_scale,
        abs(position),
        abs(velocity) / oscillator.natural_frequency,
        0.0 if oscillator.barrier is None else abs(oscillator.barrier.position),
    )
    return Units(
        length=2.0 ** round(math.log2(longest)) if longest > 0.0 else 1.0,
        time=2.0 ** round(-math.log2(scales.fastest_rate)),
        sign=oscillator.direction or 1.0,
    )


def _memory(
    history: ExponentialSum, scale: float, scheme: NumericalScheme, order: float, precision: str
) -> Memory:
    if history.rates.size > MOST_MODES:
        raise ValueError(
            f"memory_tolerance needs {history.rates.size} memory modes, but the kernel holds at most "
            f"{MOST_MODES}: use a larger one."
        )
    # an even number of modes, because the kernel takes two at a time; an added one has weight 0
    size = history.rates.size + history.rates.size % 2
    rates, strengths = np.zeros(size), np.zeros(size)
    rates[: history.rates.size], strengths[: history.rates.size] = history.rates, scale * history.weights
    recent = scheme.recent_weights(order)
    powers = np.exp(-np.outer(rates, np.arange(1, GROUP + 1)))
    weights_of_modes = strengths[:, None] * powers
    powers[:, -1] = np.expm1(-GROUP * rates)
    return Memory(
        powers.ravel().astype(precision),
        weights_of_modes.ravel().astype(precision),
        *(np.dtype(precision).type(scale * w) for w in (recent[0], scheme.extra_weight(order), *recent[1:])),
    )


def _drive(order: float, scale: float, x0: float, settings: Settings) -> npt.NDArray[np.floating]:
    """Riemann-Liouville's force x(0) t^-alpha / Gamma(1 - alpha), with the weights of the scheme."""
    if settings.derivative == "caputo" or x0 == 0.0:
        return np.zeros(0, settings.precision)
    weights = direct(settings.numerical_scheme.family, order, settings.steps + GROUP)
    return np.asarray(scale * x0 * weights, settings.precision)
