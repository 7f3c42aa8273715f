"""The memory of springpots and arms in the kernel: its modes, and the weights of the newest increments."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from springpot.memory import ExponentialSum, exponential_sum
from springpot.memory.exponential_sum import shared_span
from springpot.simulation.kernel.sizes import GROUP, MOST_MODES
from springpot.simulation.lowering.parts import Arm, Lowered
from springpot.simulation.plan.schemes import NumericalScheme
from springpot.simulation.plan.settings import Settings

_SMOOTHED = 0.27  # by the spectra of the step, at orders from 0.3 to 0.9: within 0.06


class Memory(NamedTuple):
    """Weights of the springpot's memory, in units of force: of the modes and of the newest increments."""

    powers: npt.NDArray[np.floating]  # (4 * modes,) a, a^2, a^3, a^4 - 1 of each mode
    weights: npt.NDArray[np.floating]  # (4 * modes,) w a, w a^2, w a^3, w a^4
    newest: np.floating  # weight of the last increment
    older: np.floating  # extra weight of the one before it, which is in the modes already
    recent1: np.floating  # full weight of the one before the last, which is not in the modes yet; and so on
    recent2: np.floating
    recent3: np.floating
    turns: npt.NDArray[np.floating]  # of circuits with a coil, as in `springpot.simulation.kernel.motion.remember`


def answer_of_springpot(order: float, coefficient: float, step: float) -> float:
    """Mean over a step of a springpot's force due to a unit impulse that is spread evenly over the same step.

    Examples
    --------
    >>> answer_of_springpot(1.0, 3.0, 0.1)  # of a dashpot: half of its coefficient
    1.5
    """
    return float(coefficient * step ** (1.0 - order) / math.gamma(4.0 - order))


def answer_of(total: Lowered, step: float) -> float:
    """Mean force within a step of springpots, dashpots and arms per unit of impulse in that step."""
    answer = sum((answer_of_springpot(order, c, step) for order, c in total.springpots), 0.0)
    return answer + sum(_answer_of_arm(arm, step) for arm in total.arms)


def rough_answer_of(total: Lowered, step: float) -> float:
    """The answer by which matched noise moves the velocity within a step.

    Noise with memory enters a kick as its mean over the step, which is smoother than what the scheme takes out again:
    the velocity lacks (1 - order) times a constant of the answer more than with white noise.
    """
    answer = sum(
        (1.0 + _SMOOTHED * (1.0 - order)) * answer_of_springpot(order, c, step) for order, c in total.springpots
    )
    return answer + (1.0 + _SMOOTHED) * sum(_answer_of_arm(arm, step) for arm in total.arms)


def _answer_of_arm(arm: Arm, step: float) -> float:
    """As that of a springpot: the third integral of the kernel exp(-rate t) over the step, over its square."""
    if arm.turn:
        return arm.strength * step * float(_of_two_states(_third_integral, arm, step)[0, 0])
    y = arm.rate * step
    if y < 1e-2:
        return arm.strength * step * (1.0 / 6.0 - y * (1.0 / 24.0 - y * (1.0 / 120.0 - y / 720.0)))
    return arm.strength * step * (0.5 * y * y - y - math.expm1(-y)) / y**3


def _moment_of_arm(arm: Arm, step: float) -> float:
    """First moments of its kernel over all earlier steps, summed: (coth(y / 2) / 2 - 1 / y) / rate, y = rate step."""
    if arm.turn:
        return arm.strength * step * float(_of_two_states(_summed_moments, arm, step)[0, 0])
    y = arm.rate * step
    if y < 1e-2:
        return arm.strength * step * (1.0 / 12.0 - y * y / 720.0)
    return arm.strength * step * (0.5 / math.tanh(0.5 * y) - 1.0 / y) / y


def _newest_of_arm(arm: Arm, step: float) -> tuple[list[float], float]:
    """What exact means over a step add to the weights of the newest increments, and to the extra weight."""
    answer = _answer_of_arm(arm, step)
    last = (_moment_of_arm(arm, step) - answer) / step
    return [last - 2.0 * answer / step, -last, 0.0, 0.0], -last


def _third_integral(y: complex) -> complex:
    """(exp(-y) - 1 + y - y^2 / 2) / -y^3."""
    if abs(y) < 0.1:
        return sum((-y) ** n / math.factorial(n + 3) for n in range(9))
    return complex(0.5 * y * y - y - np.expm1(-y)) / y**3


def _summed_moments(y: complex) -> complex:
    """(coth(y / 2) / 2 - 1 / y) / y."""
    if abs(y) < 0.1:
        return 1.0 / 12.0 - y**2 / 720.0 + y**4 / 30240.0
    return complex(0.5 / np.tanh(0.5 * y) - 1.0 / y) / y


def _mean(y: complex) -> complex:
    """The mean of exp(-y t) for t from 0 to 1."""
    return complex(-np.expm1(-y) / y)


def _of_two_states(function: Callable[[complex], complex], arm: Arm, step: float) -> Any:
    """An analytic function of the matrix that takes the two states of a circuit with a coil, over a step.

    Where its two eigenvalues meet, a difference of a hundred thousandth between them changes 1e-10 of the result.
    """
    middle = 0.5 * arm.rate * step
    apart = complex((0.5 * arm.rate) ** 2 - arm.turn**2) ** 0.5 * step
    if abs(apart) < 1e-5 * middle:
        apart = 1e-5 * middle
    low, high = function(middle - apart), function(middle + apart)
    matrix = np.array([[0.0, arm.turn * step], [-arm.turn * step, arm.rate * step]]) - middle * np.eye(2)
    return (0.5 * (low + high) * np.eye(2) + (high - low) / (2.0 * apart) * matrix).real


def turned_in_step(arm: Arm, step: float) -> tuple[Any, Any]:
    """By which a step multiplies the two states of a circuit with a coil, and what an increment of x adds to them."""
    return _of_two_states(lambda y: complex(np.exp(-y)), arm, step), _of_two_states(_mean, arm, step)[:, 0]


@dataclass(frozen=True)
class Tap:
    """A mode whose square is summed: its number, what it is of which circuit, and the unit of the mode.

    Attributes
    ----------
    mode : int
    quantity : {"voltage", "current"}
    circuit : str
    factor : float
    """

    mode: int
    quantity: str
    circuit: str
    factor: float


def taps_of(arms: Sequence[Arm], memory: Memory, history: ExponentialSum, step: float, begin: int = 0) -> Iterator[Tap]:
    """The voltages and currents of circuits.

    Parameters
    ----------
    arms : sequence of Arm
    memory, history
        As `memory_of` has made them of these arms.
    step : float
    begin : int
        Number of the first mode of this memory.
    """
    modes = begin + history.rates.size - sum(not arm.turn for arm in arms)
    turning = begin + memory.powers.size // 4
    for arm in arms:
        if arm.turn:
            yield Tap(turning, "voltage", arm.name, arm.volts)
            yield Tap(turning + 1, "current", arm.name, arm.amperes)
            turning += 2
        else:
            if arm.name:  # the memory holds increments, not their decay within the step
                yield Tap(modes, "voltage", arm.name, arm.volts * _mean_in_step(arm.rate * step))
            modes += 1


def _mean_in_step(rate: float) -> float:
    """The mean of exp(-rate t) over a step, ``rate`` per step."""
    return -math.expm1(-rate) / rate if rate > 1e-12 else 1.0


def sums_of(settings: Settings) -> Callable[[float], ExponentialSum]:
    """The shortest sum for the memory of a springpot of each order in a run."""
    family, span = settings.numerical_scheme.family, shared_span(settings.steps + 1)
    return lambda order: exponential_sum(family, order, span, settings.memory_tolerance)


def memory_of(
    springpots: Sequence[tuple[float, float]],
    arms: Sequence[Arm],
    scheme: NumericalScheme,
    step: float,
    settings: Settings,
    sums: Callable[[float], ExponentialSum],
) -> tuple[Memory, ExponentialSum]:
    """The memory of springpots, by order and coefficient, and of arms; and all its modes, those of arms last."""
    rates, strengths, error = np.zeros(0), np.zeros(0), 0.0
    recent, extra = np.zeros(GROUP), 0.0
    for order, coefficient in springpots:
        scale = coefficient * step**-order
        history = sums(order)
        rates, strengths = np.append(rates, history.rates), np.append(strengths, scale * history.weights)
        recent, extra = recent + scale * scheme.recent_weights(order), extra + scale * scheme.extra_weight(order)
        error = max(error, history.relative_error)
    turning = [arm for arm in arms if arm.turn]
    turns = [_turning_mode(arm, step) for arm in turning]
    for arm, (_, seen) in zip(turning, turns, strict=True):
        near, last = _newest_of_arm(arm, step)
        recent, extra = recent + seen + near, extra + last
    for arm in (arm for arm in arms if not arm.turn):
        rate = arm.rate * step
        weight = arm.strength * _mean_in_step(rate)
        rates, strengths = np.append(rates, rate), np.append(strengths, weight)
        near, last = _newest_of_arm(arm, step)
        recent, extra = recent + weight * np.exp(-rate * np.arange(GROUP)) + near, extra + last
    # without any mode the kernel takes the row for one without memory: what acts beside the modes needs one of weight 0
    beside = turns or recent.any() or (springpots and settings.derivative != "caputo")
    size = max(rates.size, 1 if beside else 0)
    if size + 2 * len(turns) > MOST_MODES:
        alone = len(springpots) == 1 and not arms
        whose = "memory_tolerance needs" if alone else "the springpots, arms and circuits need"
        advice = "use a larger one" if alone else "leave some out, or shorten the run"
        count = rates.size + 2 * len(turns)
        raise ValueError(f"{whose} {count} memory modes, but the kernel holds at most {MOST_MODES}: {advice}.")
    padded, weighted = np.zeros(size), np.zeros(size)
    padded[: rates.size], weighted[: rates.size] = rates, strengths
    powers = np.exp(-np.outer(padded, np.arange(1, GROUP + 1)))
    weights_of_modes = weighted[:, None] * powers
    powers[:, -1] = np.expm1(-GROUP * padded)
    precision = settings.precision
    tables = np.concatenate([np.zeros(0), *(table for table, _ in turns)])
    numbers: list[Any] = [
        powers.ravel().astype(precision),
        weights_of_modes.ravel().astype(precision),
        *(np.dtype(precision).type(w) for w in (recent[0], extra, *recent[1:])),
        tables.astype(precision),
    ]
    return Memory(*numbers), ExponentialSum(rates, strengths, error, 1.0, float(settings.steps + 1))


def _turning_mode(arm: Arm, step: float) -> tuple[Any, Any]:
    """The numbers of a circuit with a coil in the kernel, and the weights of the newest increments in its force."""
    turned, moved = turned_in_step(arm, step)
    powers = [np.linalg.matrix_power(turned, n) for n in range(GROUP + 1)]
    added = [powers[n] @ moved for n in range(GROUP)]
    rows = [arm.strength * powers[n][0] for n in range(1, GROUP + 1)]
    table = np.concatenate([(powers[GROUP] - np.eye(2)).ravel(), *added[::-1], *rows])
    return table, arm.strength * np.array([each[0] for each in added])
