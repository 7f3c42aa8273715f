"""The oscillator: its springpot, its wall and its excitation.

The equation of motion (paper's Eq. 1, per unit mass) is

    x'' + C D^alpha x + Omega^2 x = zeta(t)      away from the wall,
    x'(+) = -r x'(-)                             at the wall, x = b,

with zeta a Gaussian white noise, E[zeta(t) zeta(s)] = q delta(t - s).  Every number is checked here, once, when the
object is made; nothing else in the package checks an oscillator again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.faults import NotCoveredError, listed, shown
from springpot.problem.parts import (
    Barrier,
    Dashpot,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    WhiteNoise,
)
from springpot.problem.parts.checks import Checked
from springpot.problem.parts.springpots import resonance
from springpot.problem.parts.walls import restitution_at
from springpot.problem.spectral_density import DensityUnit, Excited, Sides, check_excited, intensity_from_psd

if TYPE_CHECKING:
    from springpot.problem.system import System

__all__ = ["Dimensionless"]

_CANONICAL = (
    "an Oscillator is a linear spring, one springpot or dashpot, at most one rigid wall whose restitution "
    "is a number, and white noise"
)


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
        frequency = finite_number(
            self.natural_frequency, "natural_frequency", low=1.0 / LARGEST, high=LARGEST, hint="It is Omega in rad/s."
        )
        object.__setattr__(self, "natural_frequency", frequency)
        if not isinstance(self.springpot, Springpot):
            raise TypeError(f"springpot must be a Springpot, not {shown(self.springpot)}.")
        if not isinstance(self.barrier, Barrier | None):
            raise TypeError(f"barrier must be a Barrier or None, not {shown(self.barrier)}.")
        if self.barrier is not None and callable(self.barrier.restitution):
            raise ValueError("barrier must have a number as restitution: a System takes a law of the speed.")
        if not isinstance(self.excitation, WhiteNoise):
            raise TypeError(f"excitation must be a WhiteNoise, not {shown(self.excitation)}.")
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
        if isinstance(system, cls):
            return system
        unit = system.per_unit_mass
        for name, part in unit.named():
            linear = isinstance(part, PolynomialSpring | PolynomialDashpot) and part.is_linear
            if not linear and not isinstance(part, Spring | Dashpot | Springpot | Barrier | WhiteNoise):
                raise NotCoveredError(f"{name} cannot be part of an Oscillator: {_CANONICAL}.")
            if isinstance(part, Barrier) and callable(part.restitution):
                raise NotCoveredError(f"{name} has a restitution that depends on the speed: {_CANONICAL}.")
        if len(unit.of(Barrier)) > 1:
            raise NotCoveredError(
                f"{unit.names[unit.parts.index(unit.of(Barrier)[1])]} is a second wall: {_CANONICAL}."
            )
        pots = [pot for pot in unit.of(Springpot) if pot.coefficient > 0.0]
        orders = {pot.order for pot in pots} | ({1.0} if unit.damping > 0.0 else set())
        if len(orders) > 1:
            raise NotCoveredError(
                f"springpots and dashpots of orders {listed(sorted(f'{o:g}' for o in orders))} are more "
                f"than one: {_CANONICAL}."
            )
        order = orders.pop() if orders else 1.0
        coefficient = sum(pot.coefficient for pot in pots) + (unit.damping if order == 1.0 else 0.0)
        if not unit.stiffness > 0.0:
            raise NotCoveredError(f"the stiffness of the springs is {system.stiffness:g}, not positive: {_CANONICAL}.")
        return cls(
            natural_frequency=unit.natural_frequency,
            springpot=Springpot(order, coefficient),
            barrier=next(iter(unit.of(Barrier)), None),
            excitation=WhiteNoise(sum(noise.intensity for noise in unit.of(WhiteNoise))),
        )

    @classmethod
    def from_device(
        cls,
        *,
        mass: float,
        stiffness: float,
        springpot: tuple[float, float],
        psd: float,
        psd_unit: DensityUnit,
        gap: float | None = None,
        restitution: float = 1.0,
        side: Literal["above", "below"] = "above",
        sides: Sides = 1,
        of: Excited | None = None,
    ) -> Dimensionless:
        """The oscillator of a device whose data are in SI units.

        The device obeys m x'' + k_alpha D^alpha x + k x = -m a_base(t), or F(t) instead of -m a_base(t), where x is the
        displacement relative to the base.  Then Omega = sqrt(k / m) and C = k_alpha / m.  The intensity q of the
        noise is the two-sided density of the acceleration, in (m/s^2)^2/Hz, which is half of a one-sided density; a
        density of force is divided by m^2.

        Parameters
        ----------
        mass : float
            m > 0 in kg.
        stiffness : float
            k > 0 in N/m: the spring's, without the springpot.
        springpot : (float, float)
            Order alpha in [0, 1], and k_alpha >= 0 in N s^alpha/m.  A dashpot c in N s/m is ``(1, c)``.
        psd : float
            Spectral density of the excitation, flat over the frequencies that matter.
        psd_unit : {"g2/Hz", "m2/s4/Hz", "N2/Hz"}
            Of a base acceleration in standard gravity (9.80665 m/s^2) or in m/s^2, or of a force on the mass.
        gap : float, optional
            Distance in m that the mass moves from its equilibrium before it touches the stop.  0: it just touches; a
            negative gap is a preload: the stop holds the mass that far from the spring's equilibrium.  Without it there
            is no stop.
        restitution : float
            Of the stop, in (0, 1].
        side : {"above", "below"}
            Where the mass moves: ``"above"`` a stop at x = -gap, ``"below"`` a stop at x = gap.
        sides : {1, 2}
            1: the density is one-sided (positive frequencies only), as test equipment and standards state it;
            2: two-sided.
        of : {"base", "force"}, optional
            What the density is of, if you want to state it: it must agree with ``psd_unit``.

        Returns
        -------
        Oscillator

        Raises
        ------
        TypeError, ValueError
            If a number is not one, not finite or out of its range, a word is not one of those above, or two of them
            do not fit together.

        Examples
        --------
        A harvester of 50 g at 25 Hz, shaken with 0.01 g^2/Hz, with a stop at 4 mm:

        >>> harvester = Dimensionless.from_device(
        ...     mass=0.050, stiffness=1234.0, springpot=(1.0, 0.20), gap=0.004, restitution=0.6,
        ...     psd=0.01, psd_unit="g2/Hz",
        ... )
        >>> round(harvester.natural_frequency, 1), harvester.springpot.coefficient
        (157.1, 4.0)
        >>> round(harvester.excitation.intensity, 3)  # 0.01 * 9.80665^2 / 2
        0.481
        >>> harvester.barrier
        Barrier(position=-0.004, restitution=0.6, side='above')
        """
        mass = finite_number(mass, "mass", low=0.0, high=LARGEST, open_low=True, hint="It is in kg.")
        stiffness = finite_number(stiffness, "stiffness", low=0.0, high=LARGEST, open_low=True, hint="It is in N/m.")
        if not isinstance(springpot, tuple | list) or len(springpot) != 2:
            raise TypeError(
                f"springpot must be two numbers, (order, k_alpha), not {shown(springpot)}. A dashpot c in N s/m is "
                "(1, c)."
            )
        order = finite_number(
            springpot[0], "springpot's order", low=0.0, high=1.0, hint="It runs from 0 (a spring) to 1 (a dashpot)."
        )
        k_alpha = finite_number(
            springpot[1], "springpot's k_alpha", low=0.0, high=LARGEST,
            hint="It is in N s^order/m, per device, not per kg.",
        )  # fmt: skip
        intensity = intensity_from_psd(psd, psd_unit, sides=sides, mass=mass)
        check_excited(of, psd_unit)
        return cls(
            natural_frequency=math.sqrt(stiffness / mass),
            springpot=Springpot(order=order, coefficient=k_alpha / mass),
            barrier=_stop(gap, restitution, side),
            excitation=WhiteNoise(intensity=intensity),
        )

    @classmethod
    def from_numbers(
        cls,
        *,
        order: float = 0.5,
        coefficient: float = 1.0,
        natural_frequency: float = 1.0,
        intensity: float = 1.0,
        position: float = 0.0,
        restitution: float = 1.0,
        side: Literal["above", "below"] | None = None,
        barrier: bool = True,
    ) -> Dimensionless:
        """The oscillator with these numbers: those of `Springpot`, `Barrier`, `WhiteNoise` and its own.

        Parameters
        ----------
        order, coefficient : float
            Of the springpot, (1) and s^(order - 2).
        natural_frequency : float
            In rad/s.
        intensity : float
            Of the noise, in m^2 s^-3.
        position, restitution, side
            Of the wall, in m and (1); without a side the mass moves on that of x = 0.
        barrier : bool
            False: without the wall.

        Returns
        -------
        Oscillator

        Raises
        ------
        TypeError, ValueError
            If a number is not one, not finite or out of its range, or something is said of a wall that is not there.

        Examples
        --------
        >>> Dimensionless.from_numbers(order=0.3, position=-0.5).numbers["position"]
        -0.5
        """
        wall = Barrier(position, restitution, side)  # type: ignore[arg-type]
        if not barrier and wall != Barrier():
            raise ValueError("barrier = false cannot be combined with position, restitution or side: there is no wall.")
        return cls(natural_frequency, Springpot(order, coefficient), wall if barrier else None, WhiteNoise(intensity))

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Dimensionless:
        """The oscillator that `to_dict` wrote, here or into a file.

        Parameters
        ----------
        content : mapping
            With ``natural_frequency``, and the numbers of ``springpot``, ``barrier`` (or None) and ``excitation``.

        Returns
        -------
        Oscillator

        Raises
        ------
        TypeError, ValueError
            If a key is missing or unknown, or a number is not what it must be.

        Examples
        --------
        >>> Dimensionless.from_dict(Dimensionless(barrier=None).to_dict()) == Dimensionless(barrier=None)
        True
        """
        content = _with_keys("an oscillator", content, ("natural_frequency", "springpot", "barrier", "excitation"))
        wall = content["barrier"]
        if wall is not None:
            wall = Barrier(**_with_keys("barrier", wall, ("position", "restitution", "side")))
        return cls(
            natural_frequency=content["natural_frequency"],
            springpot=Springpot(**_with_keys("springpot", content["springpot"], ("order", "coefficient"))),
            barrier=wall,
            excitation=WhiteNoise(**_with_keys("excitation", content["excitation"], ("intensity",))),
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
            "springpot": asdict(self.springpot),
            "barrier": None if self.barrier is None else asdict(self.barrier),
            "excitation": {"intensity": self.excitation.intensity},
        }

    @property
    def numbers(self) -> dict[str, Any]:
        """All numbers by name, as `from_numbers` takes them."""
        wall = self.barrier or Barrier()
        return {
            **asdict(self.springpot),
            "natural_frequency": self.natural_frequency,
            "intensity": self.excitation.intensity,
            **asdict(wall),
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
        if self.barrier is None:
            return 0.0
        return 1.0 if self.barrier.side == "above" else -1.0

    @property
    def dissipates(self) -> bool:
        """Whether springpot or wall take energy from the motion, so that there is a stationary state."""
        lossy = self.restitution < 1.0
        return lossy or self.springpot.dissipates


def _with_keys(what: str, content: object, names: tuple[str, ...]) -> Mapping[str, Any]:
    if not isinstance(content, Mapping) or {*content} != {*names}:
        given = listed([*map(str, content)]) if isinstance(content, Mapping) and content else shown(content)
        raise ValueError(f"{what} must have {listed(names)}, not {given}.")
    return content


def _stop(gap: float | None, restitution: float, side: Literal["above", "below"]) -> Barrier | None:
    if gap is None:
        if Barrier(restitution=restitution, side=side) != Barrier():
            raise ValueError("gap must be given with restitution or side: without a gap there is no wall.")
        return None
    distance = finite_number(
        gap,
        "gap",
        low=-LARGEST,
        high=LARGEST,
        hint="It is the distance from equilibrium to the wall in m; a negative gap is a preload.",
    )
    position = distance if side == "below" else -distance
    return Barrier(position=position + 0.0, restitution=restitution, side=side)  # + 0.0: no negative zero
