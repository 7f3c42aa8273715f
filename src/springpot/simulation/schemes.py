"""The schemes by which a path is advanced: what each asks of the memory, and the kernel's numbers for one step size.

A scheme is asked for by its word, "default" or "grunwald"; `scheme_of` gives the class.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from springpot.memory import direct
from springpot.memory.weights import Family
from springpot.options import DEFAULTS, Scheme
from springpot.simulation import parts
from springpot.simulation.lanes import GROUP

__all__ = ["Grunwald", "Splitting", "scheme_of"]

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Splitting:
    """The default: exact flight of the bare oscillator, impacts in it, between kicks of memory and noise.

    Attributes
    ----------
    order : int
        Of stationary moments in the step, without a wall.
    default_step, coarsest_step : float
        The step taken if none is given, and that beyond which errors of 1 % are to be expected, in units of the
        shortest time scale.
    family : {"average", "grunwald"}
        The weights of the history.
    """

    order: ClassVar[int] = 2
    default_step: ClassVar[float] = 0.01
    coarsest_step: ClassVar[float] = 0.1
    family: ClassVar[Family] = "average"

    def at(self, frequency: float, order: float, coefficient: float, step: float, length: float) -> parts.Splitting:
        """The kernel's numbers for one step size, in its units; ``length`` is that of length, in m."""
        return parts.splitting(frequency, order, coefficient, step)

    def recent_weights(self, order: float) -> Floats:
        """Weights of the four newest increments, in units of h^-alpha."""
        weights = direct(self.family, order, GROUP)
        weights[:2] += parts.newest_weights_splitting(order)
        return weights

    def extra_weight(self, order: float) -> float:
        """What the second newest increment weighs beyond its part in the modes."""
        return parts.newest_weights_splitting(order)[1]

    def early_displacement(self, order: float, drive: float, step: float) -> float:
        """Displacement at the first kick due to Riemann-Liouville's force before it.

        That force is largest at once, and the kick that stands for its first step comes later.
        """
        return -drive * step**2 * 0.5 * order / (2.0 - order)


@dataclass(frozen=True)
class Grunwald:
    """The paper's: Grunwald-Letnikov derivative, Euler step, impact when x is near the wall or beyond it and moves in.

    Attributes
    ----------
    contact_tolerance : float
        How near, in m.
    order, default_step, coarsest_step, family
        As in `Splitting`.
    """

    contact_tolerance: float = DEFAULTS["contact_tolerance"]

    order: ClassVar[int] = 1
    default_step: ClassVar[float] = 0.001
    coarsest_step: ClassVar[float] = 0.005
    family: ClassVar[Family] = "grunwald"

    def at(self, frequency: float, order: float, coefficient: float, step: float, length: float) -> parts.Euler:
        """As in `Splitting`."""
        return parts.euler(frequency, step, self.contact_tolerance / length)

    def recent_weights(self, order: float) -> Floats:
        """As in `Splitting`."""
        return direct(self.family, order, GROUP)

    def extra_weight(self, order: float) -> float:
        """As in `Splitting`."""
        return 0.0

    def early_displacement(self, order: float, drive: float, step: float) -> float:
        """None: the force acts on the first step."""
        return 0.0


def scheme_of(word: Scheme, contact_tolerance: float = DEFAULTS["contact_tolerance"]) -> Splitting | Grunwald:
    """The scheme with this word.

    Examples
    --------
    >>> scheme_of("default"), scheme_of("grunwald").order
    (Splitting(), 1)
    """
    return Splitting() if word == "default" else Grunwald(contact_tolerance)
