"""The settings of a run, and checks of single numbers among them."""

from __future__ import annotations

import numbers
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.crew import threads_available
from springpot.machine.faults import shown
from springpot.simulation.plan.options import Derivative, Options, SchemeOfRun, StartKind
from springpot.simulation.plan.schemes import NumericalScheme, scheme_of

MOST_STEPS = 100_000_000
MOST_PATHS = 50_000_000  # 5.6 GB of sums
LONGEST_SINGLE = 5_000_000  # steps; in longer runs the rounding of single-precision memory would be visible
SINGLE_PRECISION = 1e-7  # memory tolerance below which the memory is kept in double precision


@dataclass(frozen=True)
class Settings:
    """All settings of a run, given and default.  Made by `springpot.simulation.plan.plan.plan_of`.

    Attributes
    ----------
    paths : int
    duration, step : float
        In s; the step divides the duration.
    window : tuple of float
        Averages are taken over window[0] < t <= window[1], both whole numbers of steps.
    seed : int
    threads : int
    scheme : {"default", "grunwald", "straight"}
        The last is that of several masses.
    start : {"rest", "stationary"}
        ``"rest"`` is also the start of a run whose initial state was given.
    initial_position, initial_velocity : float
        x(0) and x'(0), in m and m/s, of several masses by the names of the points; x(0) of a stationary start is None
        until its pilot runs are over.
    derivative : {"caputo", "riemann-liouville"}
        They differ by x(0) t^-alpha / Gamma(1 - alpha).
    memory_tolerance : float
        Relative error allowed in the exponential sum of the memory.
    contact_tolerance : float
        The paper's epsilon, in m; used by the ``grunwald`` scheme only.
    record : int
        How many paths are stored.
    record_every : int
        Steps between two stored points of a path.
    """

    paths: int
    duration: float
    step: float
    window: tuple[float, float]
    seed: int
    threads: int
    scheme: SchemeOfRun = "default"
    start: StartKind = "stationary"
    initial_position: float | dict[str, float] | None = None
    initial_velocity: float | dict[str, float] = 0.0
    derivative: Derivative = "caputo"
    memory_tolerance: float = Options.memory_tolerance
    contact_tolerance: float = Options.contact_tolerance
    record: int = 0
    record_every: int = 1

    @property
    def numerical_scheme(self) -> NumericalScheme:
        """The scheme that ``scheme`` names."""
        return scheme_of(self.scheme, self.contact_tolerance)

    @property
    def steps(self) -> int:
        """Number of steps of the run."""
        return round(self.duration / self.step)

    @property
    def window_steps(self) -> tuple[int, int]:
        """First step of the window, and the first one after it (step n ends at (n + 1) h)."""
        return round(self.window[0] / self.step), round(self.window[1] / self.step)

    @property
    def middles(self) -> Floats:
        """Times of the middles of all steps, in s."""
        return np.asarray(self.step * (np.arange(self.steps) + 0.5))

    @property
    def recorded_points(self) -> int:
        """Points stored of each recorded path, that at time 0 included."""
        return self.steps // self.record_every + 1

    @property
    def recorded_times(self) -> Floats:
        """Times of the recorded points, in s; empty if no path is recorded."""
        return self.step * np.arange(0, self.steps + 1 if self.record else 0, self.record_every, dtype=np.float64)

    @property
    def precision(self) -> str:
        """NumPy's name of the type in which memory modes are kept."""
        return "float32" if self.memory_tolerance >= SINGLE_PRECISION and self.steps <= LONGEST_SINGLE else "float64"

    def to_dict(self) -> dict[str, Any]:
        """All settings as plain numbers, words and lists."""
        return {**asdict(self), "window": list(self.window)}


def checked_seed(seed: int) -> int:
    """A seed, if it is one.

    Raises
    ------
    TypeError, ValueError
        If it is not a whole number from 0 to 2^64 - 1.
    """
    return whole_number(seed, "seed", 0, 2**64 - 1)


def checked_threads(threads: int | None) -> int:
    """The number of threads to use: all available ones for None.

    Raises
    ------
    TypeError, ValueError
        If it is not a whole number from 1 to 4096.
    """
    return threads_available() if threads is None else whole_number(threads, "threads", 1, 4096)


def whole_number(value: object, name: str, low: int, high: int, hint: str = "") -> int:
    """``value`` as an int, or one sentence, and the hint, that names the argument and its range."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        raise TypeError(f"{name} must be a whole number, not {shown(value)}.{hint}")
    if not low <= int(value) <= high:
        raise ValueError(f"{name} must be in [{low}, {high}], not {value}.{hint}")
    return int(value)
