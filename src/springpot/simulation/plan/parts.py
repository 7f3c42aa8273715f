"""What single parts do to a motion of a known frequency, roughly: for guesses of scales of one mass and of several."""

from __future__ import annotations

import math
from typing import Any

from springpot.problem.parts import (
    BoucWen,
    CloughPenzienNoise,
    ColoredNoise,
    Dashpot,
    FractionalMaxwell,
    Harmonic,
    KanaiTajimiNoise,
    Maxwell,
    PoissonImpulses,
    RecordedExcitation,
    ResonantCircuit,
    Springpot,
    WhiteNoise,
)
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.hysteresis import Yielding
from springpot.problem.system import System

_HARDLY = 0.01  # of the power of dry friction: a part that takes less of the motion is a spring


def beat(system: System) -> float:
    """How much longer than without a harmonic force the start is felt, and how much more of it is in a mean square.

    What the start leaves beats with the forced motion, 2 exp(-b t) of the square, where without that force only its
    own square is left, exp(-2 b t).

    Examples
    --------
    >>> beat(System(Harmonic(1.0, 2.0))), beat(System(WhiteNoise(1.0)))
    (2.0, 1.0)
    """
    return 2.0 if any(force.amplitude for force in system.of(Harmonic)) else 1.0


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
    """Of an arm, a circuit or what yields, before it gives way; 0 of other parts.

    Examples
    --------
    >>> stiffness_at_once(Maxwell(2.0, 1.0))
    2.0
    """
    match part:
        case Maxwell() | Yielding():
            return part.stiffness
        case FractionalMaxwell():
            return part.spring.stiffness
        case Circuit():
            return part.coupling**2 / part.capacitance
    return 0.0


def rate_of_its_own(part: Any) -> float:
    """The frequency of a circuit's own, which the step must follow; 0 of other parts.

    Examples
    --------
    >>> rate_of_its_own(ResonantCircuit(1.0, 1.0, 0.5, 0.5))
    2.0
    """
    return part.frequency if isinstance(part, ResonantCircuit) else 0.0


def time_of_its_own(part: Any) -> float:
    """In which the energy of a circuit with a coil decays where nothing moves; 0 of other parts.

    Examples
    --------
    >>> time_of_its_own(ResonantCircuit(1.0, 0.1, 0.5, 0.5))
    5.0
    """
    if not isinstance(part, ResonantCircuit):
        return 0.0
    half = 0.5 * part.rate
    slower = part.frequency**2 / (half + math.sqrt(max(half**2 - part.frequency**2, 0.0)))
    return 0.5 / min(half, slower)


def taken_by_yielding(part: Any, theta: float, square: float) -> float:
    """Power that a part which yields takes of a unit mass: that of dry friction times a share; 0 of other parts.

    The share is small where the motion hardly reaches the yield displacement.  ``square`` is the stiffness beside it.

    Examples
    --------
    >>> from springpot.problem.parts import Jenkins
    >>> round(taken_by_yielding(Jenkins(0.9, 0.9), 0.379, 0.1), 3)  # by simulation 0.035
    0.046
    """
    if not isinstance(part, Yielding):
        return 0.0
    reached = max(_reached(part, theta, square), 1e-5)
    if isinstance(part, BoucWen):
        share = 1.0 / (1.0 + reached ** -(part.exponent + 1.0))
    else:
        share = math.erfc(math.sqrt(0.5) / reached)
    return float(share * part.yield_force * math.sqrt(2.0 * theta / math.pi))


def slow_dashpot(part: Yielding, theta: float, square: float) -> float:
    """The dashpot that a part which yields is for slow displacements, beside a fast motion; 0 if it hardly yields.

    That of the Maxwell element with its stiffness that takes the same power of the fast motion, or, where this goes far
    beyond the yield displacement, of the dashpot alone.

    Examples
    --------
    >>> from springpot.problem.parts import BoucWen, Jenkins
    >>> round(slow_dashpot(Jenkins(0.9, 0.9), 0.379, 0.1), 1), slow_dashpot(Jenkins(0.9, 9.0), 0.379, 0.1)
    (6.5, 0.0)
    >>> round(slow_dashpot(BoucWen(0.9, 0.9), 0.234, 0.1), 1)  # that of linearization is 3.1
    2.6
    """
    taken, fast = taken_by_yielding(part, theta, square), square + part.stiffness
    if taken < _HARDLY * part.yield_force * math.sqrt(theta):
        return 0.0
    if _reached(part, theta, square) > 1.0:
        return taken / theta
    half = 0.5 * theta * part.stiffness**2 / (fast * taken)
    return half + math.sqrt(max(half**2 - part.stiffness**2 / fast, 0.0))


def _reached(part: Yielding, theta: float, square: float) -> float:
    """Standard deviation of the elongation over that at which it yields."""
    return math.sqrt(theta / (square + part.stiffness)) / part.yield_displacement


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
        case Circuit():
            return 1.0, part.coupling**2 * part.resistance
    return 0.0, 0.0
