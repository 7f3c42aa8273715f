"""The numerical schemes: their default step, memory weights, and constants in the kernel for one step size.

`scheme_of` gives the class of a name, "default" or "grunwald".
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

from springpot.machine.arrays import Floats
from springpot.machine.without_scipy import zeta_beyond_one
from springpot.memory import direct
from springpot.memory.weights import Family
from springpot.simulation.kernel.sizes import GROUP
from springpot.simulation.plan.options import Options, SchemeOfRun


class NumericalScheme(Protocol):
    """What every scheme states of itself, and gives to the kernel.

    Attributes
    ----------
    order : int
        Of stationary moments in the step, without a wall.
    default_step, coarsest_step : float
        The default step without walls, and the step above which errors of 1 % are expected, in units of the shortest
        time scale.
    family : {"average", "grunwald"}
        The memory weights.
    keeps_the_law : bool
        Whether the step leaves the stationary law of a dashpot, white noise and elastic walls as it is, however long.
    only_paper : bool
        Whether it covers the paper's problem only.
    impact_bias : float
        Bound on the relative step bias of impact rates and mean speeds, over the square of the step, which is in units
        of the shortest time scale; beside what slow impacts that are missed leave.
    taken : float
        Relative step bias of mean square velocities over what dampers take of a kick within its step.
    """

    order: ClassVar[int]
    default_step: ClassVar[float]
    coarsest_step: ClassVar[float]
    family: ClassVar[Family]
    keeps_the_law: ClassVar[bool]
    only_paper: ClassVar[bool]
    impact_bias: ClassVar[float] = 0.0
    taken: ClassVar[float] = 0.0

    def recent_weights(self, order: float) -> Floats:
        """Weights of the four newest increments, in units of h^-alpha."""

    def extra_weight(self, order: float) -> float:
        """Extra weight of the second newest increment, which is in the modes already."""

    def early_displacement(self, order: float, drive: float, step: float) -> float:
        """Displacement at the first kick due to the Riemann-Liouville force, which is largest just before it."""


@dataclass(frozen=True)
class Splitting(NumericalScheme):
    """The default: exact flight of the bare oscillator, impacts in it, between kicks of memory and noise.

    Flights and elastic impacts keep the energy exactly.  With a dashpot, the kick between them, an implicit midpoint
    rule, keeps the velocity normal with its exact variance q / (2 C) while x does not move.  At the default step mean
    squares are off by less than 0.2 %: measured against linear theory for orders from 0.3 to 1 and coefficients from
    0.1 to 10.
    """

    order: ClassVar[int] = 2
    default_step: ClassVar[float] = 0.1
    coarsest_step: ClassVar[float] = 0.1
    family: ClassVar[Family] = "average"
    keeps_the_law: ClassVar[bool] = True
    only_paper: ClassVar[bool] = False

    def recent_weights(self, order: float) -> Floats:
        weights = direct(self.family, order, GROUP)
        weights[:2] += newest_weights(order)
        return weights

    def extra_weight(self, order: float) -> float:
        return newest_weights(order)[1]

    def early_displacement(self, order: float, drive: float, step: float) -> float:
        return -drive * step**2 * 0.5 * order / (2.0 - order)


@dataclass(frozen=True)
class Grunwald(NumericalScheme):
    """The paper's: Grunwald-Letnikov derivative, Euler step; impact when x is near the wall or beyond and moves in.

    Attributes
    ----------
    contact_tolerance : float
        Largest distance of an impact from the wall, in m.
    """

    contact_tolerance: float = Options.contact_tolerance

    order: ClassVar[int] = 1
    default_step: ClassVar[float] = 0.001
    coarsest_step: ClassVar[float] = 0.005
    family: ClassVar[Family] = "grunwald"
    keeps_the_law: ClassVar[bool] = False
    only_paper: ClassVar[bool] = True

    def recent_weights(self, order: float) -> Floats:
        return direct(self.family, order, GROUP)

    def extra_weight(self, order: float) -> float:
        return 0.0

    def early_displacement(self, order: float, drive: float, step: float) -> float:
        return 0.0  # the force acts on the first step


@dataclass(frozen=True)
class Straight(Splitting):
    """That of several masses: straight flight and impacts in it, between kicks of springs, memory and noise.

    At a step of 0.1 over the highest frequency moments are off by less than 0.15 %, at 0.4 by 0.4 %; impact rates by
    0.1 times the square of that step, speeds by 0.06, and mean forces by both.  Mean square velocities are lower by up
    to 0.4 % where springpots of an order near 0.8 are stronger than all springs and the noise is not matched to them.
    """

    coarsest_step: ClassVar[float] = 0.2
    keeps_the_law: ClassVar[bool] = False
    impact_bias: ClassVar[float] = 0.12
    taken: ClassVar[float] = 0.025


def weight_of_last_impulse(order: float) -> float:
    """Correction of the memory weight for the velocity jump at the last kick, in units of h^(1 - alpha).

    An impulse stands for a force spread over the step around it, and the springpot's force is its mean over the step
    around a later kick: the integral of the kernel between them, t^(1 - alpha) / Gamma(2 - alpha), averaged twice.
    Summed over all earlier kicks the correction is -1 / Gamma(4 - alpha) - zeta(alpha - 1) / Gamma(2 - alpha).  All of
    it is given to the last kick, which has most of it; for smooth motion only the sum matters up to order h^2.
    """
    return _summed_moments(order) - 1.0 / math.gamma(4.0 - order)


def _summed_moments(order: float) -> float:
    """First moments of the kernel over all earlier steps, summed: -zeta(alpha - 1) / Gamma(2 - alpha).

    By the functional equation this is (2 pi)^(alpha - 1) cos(pi alpha / 2) zeta(2 - alpha) / pi.

    Examples
    --------
    >>> _summed_moments(1.0), round(_summed_moments(0.5), 12)
    (0.5, 0.234574485391)
    """
    rest = 1.0 - order
    if rest == 0.0:
        return 0.5
    zeta = float(zeta_beyond_one(rest))
    return math.pow(2.0 * math.pi, -rest) * math.sin(0.5 * math.pi * rest) * zeta / math.pi


def newest_weights(order: float) -> tuple[float, float]:
    """Corrections to the L1 weights of the newest two displacement increments, in units of h^-alpha.

    The damping term, of weight 2 / Gamma(4 - alpha), uses the present velocity.  It differs from the mean velocity of
    the last step by half a step of the spring's acceleration, as in every earlier step.  The last impulse is the change
    of the mean velocity between the last two steps less twice this difference.
    """
    last = weight_of_last_impulse(order)
    return last - 2.0 / math.gamma(4.0 - order), -last


def scheme_of(word: SchemeOfRun, contact_tolerance: float = Options.contact_tolerance) -> NumericalScheme:
    """The scheme of a name.

    Examples
    --------
    >>> scheme_of("default"), scheme_of("grunwald").order
    (Splitting(), 1)
    """
    if word == "straight":
        return Straight()
    return Splitting() if word == "default" else Grunwald(contact_tolerance)
