"""The memory of springpots and arms in the kernel: its modes, and the weights of the newest increments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springpot.memory import ExponentialSum, exponential_sum
from springpot.simulation.kernel.block import Memory
from springpot.simulation.kernel.lanes import GROUP, MOST_MODES
from springpot.simulation.kernel.questions import answer_of_springpot
from springpot.simulation.lowering.parts import Arm, Lowered
from springpot.simulation.plan.schemes import NumericalScheme
from springpot.simulation.plan.settings import Settings

__all__ = ["answer_of", "memory_of", "rough_answer_of", "tap_of"]

_SMOOTHED = 0.27  # by the spectra of the step, at orders from 0.3 to 0.9: within 0.06


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
    y = arm.rate * step
    if y < 1e-2:
        return arm.strength * step * (1.0 / 6.0 - y * (1.0 / 24.0 - y * (1.0 / 120.0 - y / 720.0)))
    return arm.strength * step * (0.5 * y * y - y - math.expm1(-y)) / y**3


def _moment_of_arm(arm: Arm, step: float) -> float:
    """First moments of its kernel over all earlier steps, summed: (coth(y / 2) / 2 - 1 / y) / rate, y = rate step."""
    y = arm.rate * step
    if y < 1e-2:
        return arm.strength * step * (1.0 / 12.0 - y * y / 720.0)
    return arm.strength * step * (0.5 / math.tanh(0.5 * y) - 1.0 / y) / y


def tap_of(arm: Arm, step: float) -> Arm:
    """A circuit with its voltage per unit of the mode as the memory keeps it: it holds increments, not their decay."""
    return replace(arm, volts=arm.volts * _mean_in_step(arm.rate * step))


def _mean_in_step(rate: float) -> float:
    """The mean of exp(-rate t) over a step, ``rate`` per step."""
    return -math.expm1(-rate) / rate if rate > 1e-12 else 1.0


def memory_of(
    springpots: Sequence[tuple[float, float]],
    arms: Sequence[Arm],
    scheme: NumericalScheme,
    step: float,
    settings: Settings,
) -> tuple[Memory, ExponentialSum]:
    """The memory of springpots, by order and coefficient, and of arms; and all its modes, those of arms last."""
    rates, strengths, error = np.zeros(0), np.zeros(0), 0.0
    recent, extra = np.zeros(GROUP), 0.0
    for order, coefficient in springpots:
        scale = coefficient * step**-order
        history = exponential_sum(scheme.family, order, settings.steps + 1, settings.memory_tolerance)
        rates, strengths = np.append(rates, history.rates), np.append(strengths, scale * history.weights)
        recent, extra = recent + scale * scheme.recent_weights(order), extra + scale * scheme.extra_weight(order)
        error = max(error, history.relative_error)
    for arm in arms:
        rate = arm.rate * step
        weight = arm.strength * _mean_in_step(rate)
        rates, strengths = np.append(rates, rate), np.append(strengths, weight)
        answer = _answer_of_arm(arm, step)
        last = (_moment_of_arm(arm, step) - answer) / step
        recent = recent + weight * np.exp(-rate * np.arange(GROUP)) + [last - 2.0 * answer / step, -last, 0.0, 0.0]
        extra -= last
    if rates.size > MOST_MODES:
        alone = len(springpots) == 1 and not arms
        whose = "memory_tolerance needs" if alone else "the springpots, arms and circuits need"
        advice = "use a larger one" if alone else "leave some out, or shorten the run"
        raise ValueError(f"{whose} {rates.size} memory modes, but the kernel holds at most {MOST_MODES}: {advice}.")
    # an even number of modes, because the kernel takes two at a time; an added one has weight 0
    size = rates.size + rates.size % 2
    padded, weighted = np.zeros(size), np.zeros(size)
    padded[: rates.size], weighted[: rates.size] = rates, strengths
    powers = np.exp(-np.outer(padded, np.arange(1, GROUP + 1)))
    weights_of_modes = weighted[:, None] * powers
    powers[:, -1] = np.expm1(-GROUP * padded)
    precision = settings.precision
    return Memory(
        powers.ravel().astype(precision),
        weights_of_modes.ravel().astype(precision),
        *(np.dtype(precision).type(w) for w in (recent[0], extra, *recent[1:])),
    ), ExponentialSum(rates, strengths, error, 1.0, float(settings.steps + 1))
