"""What single parts do to a motion of a known frequency, roughly: for guesses of scales of one mass and of several."""

from __future__ import annotations

import math
from typing import Any

from springpot.problem.parts import (
    CloughPenzienNoise,
    ColoredNoise,
    Dashpot,
    FractionalMaxwell,
    KanaiTajimiNoise,
    Maxwell,
    PiezoelectricCircuit,
    PoissonImpulses,
    RecordedExcitation,
    Springpot,
    WhiteNoise,
)

__all__ = ["fed_at", "slow_springpot", "stiffness_at_once"]


def fed_at(part: Any, frequency: float) -> float:
    """Power that noise or a record feeds into a unit mass of this frequency, whatever its damping; 0 of other parts.

    Examples
    --------
    >>> fed_at(WhiteNoise(3.0), 1.0)
    1.5
    """
    match part:
        case WhiteNoise() | PoissonImpulses():
            return 0.5 * float(part.intensity) * part.largest_square
        case ColoredNoise() | KanaiTajimiNoise() | CloughPenzienNoise():
            return math.pi * part.density(frequency) * part.largest_square
        case RecordedExcitation():  # as noise that is white up to this frequency
            return 0.5 * math.pi * part.mean_square / frequency
    return 0.0


def stiffness_at_once(part: Any) -> float:
    """Of an arm or circuit, before it gives way; 0 of other parts.

    Examples
    --------
    >>> stiffness_at_once(Maxwell(2.0, 1.0))
    2.0
    """
    match part:
        case Maxwell():
            return part.stiffness
        case FractionalMaxwell():
            return part.spring.stiffness
        case PiezoelectricCircuit():
            return part.coupling**2 / part.capacitance
    return 0.0


def slow_springpot(part: Any) -> tuple[float, float]:
    """Order and coefficient of the springpot that a damper, arm or circuit is for slow motion; 0 of other parts.

    Examples
    --------
    >>> slow_springpot(Maxwell(2.0, 1.0))
    (1.0, 1.0)
    """
    match part:
        case Springpot():
            return part.order, part.coefficient
        case FractionalMaxwell():
            return slow_springpot(part.springpot)
        case Dashpot() | Maxwell():
            return 1.0, part.coefficient
        case PiezoelectricCircuit():
            return 1.0, part.coupling**2 * part.resistance
    return 0.0, 0.0
