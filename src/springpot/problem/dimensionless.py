"""The paper's problem in its dimensionless numbers: its springpot, its wall and its excitation, per unit mass.

The equation of motion (paper's Eq. 1, per unit mass) is

    x'' + C D^alpha x + Omega^2 x = zeta(t)      away from the wall,
    x'(+) = -r x'(-)                             at the wall, x = b,

with zeta a Gaussian white noise, E[zeta(t) zeta(s)] = q delta(t - s).  Every number is checked here, once, when the
object is made; nothing else in the package checks an oscillator again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import NotCoveredError, listed, shown
from springpot.problem.parts import Barrier, Springpot, WhiteNoise
from springpot.problem.parts.checks import Checked, plain, put
from springpot.problem.parts.springpots import resonance
from springpot.problem.parts.walls import restitution_at

if TYPE_CHECKING:
    from springpot.problem.system import System

CANONICAL = (
    "an Oscillator is a linear spring, one springpot or dashpot, at most one rigid wall whose restitution "
    "is a number, and white noise"
)


def checked_frequency(natural_frequency: object, springpot: object, barrier: object, excitation: object) -> float:
    """The frequency of an oscillator that is made of these: a number, and its parts of the right kinds."""
    frequency = finite_number(
        natural_frequency, "natural_frequency", low=1.0 / LARGEST, high=LARGEST, hint="It is Omega in rad/s."
    )
    for name, part, kind in (("springpot", springpot, Springpot), ("excitation", excitation, WhiteNoise)):
        if not isinstance(part, kind):
            raise TypeError(f"{name} must be a {kind.__name__}, not {shown(part)}.")
    if not isinstance(barrier, Barrier | None):
        raise TypeError(f"barrier must be a Barrier or None, not {shown(barrier)}.")
    return frequency


@dataclass(frozen=True)
class Dimensionless(Checked):
    """The whole question: x'' + C D^alpha x + Omega^2 x = zeta(t) with an optional wall.

    Parameters
    ----------
    natural_frequency : float
        Omega > 0 in rad/s.
    springpot : Springpot
    barrier : Barrier or None
        None for an oscillator without a wall.
    excitation : WhiteNoise

    Raises
    ------
    TypeError, ValueError
        If a part is of another type or the frequency is not a positive finite number.

    Examples
    --------
    >>> oscillator = Dimensionless(natural_frequency=3.0, springpot=Springpot(0.7, 0.2))
    >>> round(oscillator.dimensionless_coefficient, 4)
    0.0479
    """

    natural_frequency: float = 1.0
    springpot: Springpot = field(default_factory=lambda: Springpot(order=0.5, coefficient=1.0))
    barrier: Barrier | None = field(default_factory=Barrier)
    excitation: WhiteNoise = field(default_factory=WhiteNoise)

    def __post_init__(self) -> None:
        put(self, natural_frequency=checked_frequency(**vars(self)))
        if self.barrier is not None and callable(self.barrier.restitution):
            raise ValueError("barrier must have a number as restitution: a System takes a law of the speed.")
        if self.excitation.envelope is not None:
            raise ValueError("excitation must be stationary: a System takes noise with an envelope.")
        if self.excitation.on != "mass":
            raise ValueError("excitation must act on the mass; white noise of the ground has the same law.")

    @classmethod
    def of(cls, system: System) -> Dimensionless:
        """The paper's problem, from a system that is it.

        Parameters
        ----------
        system : System

        Returns
        -------
        Dimensionless

        Raises
        ------
        NotCoveredError
            If it is more than one spring, one springpot, one wall and white noise; the sentence names the part.

        Examples
        --------
        >>> from springpot.problem.parts import Dashpot, Spring
        >>> from springpot.problem.system import System
        >>> Dimensionless.of(System(Spring(4.0), Dashpot(0.1), WhiteNoise(2.0))).springpot
        Springpot(order=1.0, coefficient=0.1)
        """
        unit = system.per_unit_mass
        for name, part in unit.named():
            if not part.is_of_paper:
                raise NotCoveredError(f"{name} cannot be part of an Oscillator: {CANONICAL}.")
            if name in unit.excitations and part.envelope is not None:
                raise NotCoveredError(f"{name} has an envelope: {CANONICAL}, which is stationary.")
            if name in unit.walls and part.has_law:
                raise NotCoveredError(f"{name} has a restitution that depends on the speed: {CANONICAL}.")
        if len(unit.walls) > 1:
            raise NotCoveredError(f"{[*unit.walls][1]} is a second wall: {CANONICAL}.")
        springpots = [springpot for springpot in unit.springpots.values() if springpot.coefficient > 0.0]
        orders = {springpot.order for springpot in springpots} | ({1.0} if unit.damping > 0.0 else set())
        if len(orders) > 1:
            raise NotCoveredError(
                f"springpots and dashpots of orders {listed(sorted(f'{o:g}' for o in orders))} are more "
                f"than one: {CANONICAL}."
            )
        order = orders.pop() if orders else 1.0
        coefficient = sum(springpot.coefficient for springpot in springpots) + (unit.damping if order == 1.0 else 0.0)
        if not unit.stiffness > 0.0:
            raise NotCoveredError(f"the stiffness of the springs is {system.stiffness:g}, not positive: {CANONICAL}.")
        return cls(
            natural_frequency=unit.natural_frequency,
            springpot=Springpot(order, float(coefficient)),
            barrier=next(iter(unit.walls.values()), None),
            excitation=WhiteNoise(float(sum(noise.white_intensity for noise in unit.excitations.values()))),
        )

    def to_dict(self) -> dict[str, Any]:
        """All numbers by name, those of a part in a dict of their own; None where there is no wall.

        Examples
        --------
        >>> Dimensionless().to_dict()["springpot"]
        {'order': 0.5, 'coefficient': 1.0}
        """
        return {
            "natural_frequency": self.natural_frequency,
            "springpot": plain(self.springpot),
            "barrier": None if self.barrier is None else plain(self.barrier),
            "excitation": {"intensity": self.excitation.intensity},
        }

    @property
    def numbers(self) -> dict[str, Any]:
        """All numbers by name, as `from_numbers` takes them."""
        wall = self.barrier or Barrier()
        return {
            **plain(self.springpot),
            "natural_frequency": self.natural_frequency,
            "intensity": self.excitation.intensity,
            **plain(wall),
            "barrier": self.barrier is not None,
        }

    @property
    def time_scale(self) -> float:
        """1 / Omega, in s."""
        return 1.0 / self.natural_frequency

    @property
    def length_scale(self) -> float:
        """sqrt(q / Omega^3), in m; 0 without noise."""
        return math.sqrt(self.excitation.intensity / self.natural_frequency) / self.natural_frequency

    @property
    def speed_scale(self) -> float:
        """sqrt(q / Omega), in m/s; 0 without noise."""
        return math.sqrt(self.excitation.intensity / self.natural_frequency)

    @property
    def resonance(self) -> float:
        """Frequency of the motion without the wall, with the springpot's stiffness, in rad/s.

        The root w of w^2 = Omega^2 + C w^alpha cos(alpha pi / 2).

        Examples
        --------
        >>> round(Dimensionless().resonance, 4)
        1.3496
        """
        return resonance(self.natural_frequency**2, [self.springpot])

    @property
    def dimensionless_coefficient(self) -> float:
        """c = C Omega^(alpha - 2): the springpot's force over the spring's at frequency Omega."""
        return float(self.springpot.coefficient * self.natural_frequency ** (self.springpot.order - 2.0))

    @property
    def dimensionless_position(self) -> float:
        """b sqrt(Omega^3 / q), positive for a preload; NaN without a wall, +-inf (or 0) without noise."""
        if self.barrier is None:
            return math.nan
        gap = self.direction * self.barrier.position
        if self.length_scale == 0.0:
            return math.copysign(math.inf, gap) if gap else 0.0
        return gap / self.length_scale

    @property
    def restitution(self) -> float:
        """r of the wall; NaN without one."""
        return math.nan if self.barrier is None else restitution_at(self.barrier, 0.0)

    @property
    def direction(self) -> float:
        """1 where the mass moves above its wall, -1 below it, 0 without a wall."""
        return 0.0 if self.barrier is None else self.barrier.inwards

    @property
    def dissipates(self) -> bool:
        """Whether springpot or wall take energy from the motion, so that there is a stationary state."""
        lossy = self.restitution < 1.0
        return lossy or self.springpot.dissipates
