"""The paper's oscillator, as a user writes it: four parts, from which a `System` is made.

The equation of motion (paper's Eq. 1, per unit mass) is

    x'' + C D^alpha x + Omega^2 x = zeta(t)      away from the wall,
    x'(+) = -r x'(-)                             at the wall, x = b,

with zeta a Gaussian white noise, E[zeta(t) zeta(s)] = q delta(t - s).
"""

from __future__ import annotations

from inspect import signature
from typing import TYPE_CHECKING, Literal, Never

from springpot.machine.arguments import LARGEST, finite_number, positive_number, switch
from springpot.machine.faults import shown
from springpot.problem.dimensionless import checked_frequency
from springpot.problem.parts import Barrier, Mass, Spring, Springpot, WhiteNoise
from springpot.problem.parts.checks import check_names, real
from springpot.problem.spectral_density import DensityUnit, Excited, Sides, check_excited
from springpot.problem.system import System

_SPRINGPOT, _WALL, _NOISE = Springpot(order=0.5, coefficient=1.0), Barrier(), WhiteNoise()


class Oscillator(System if TYPE_CHECKING else object):  # type: ignore[misc]
    """The paper's oscillator x'' + C D^alpha x + Omega^2 x = zeta(t), with a wall: a way to write a `System`.

    What it returns is a `System` of the parts ``spring`` (of stiffness Omega^2), ``springpot``, ``barrier`` and
    ``white_noise``, per unit mass.  `springpot.Dimensionless` has its dimensionless numbers.

    Parameters
    ----------
    natural_frequency : float
        Omega > 0 in rad/s.
    springpot : Springpot
    barrier : Barrier or None
        None for an oscillator without a wall.
    excitation : WhiteNoise

    Returns
    -------
    System

    Raises
    ------
    TypeError, ValueError
        If a part is of another type or the frequency is not a positive finite number.

    Examples
    --------
    >>> oscillator = Oscillator(natural_frequency=3.0, springpot=Springpot(0.7, 0.2))
    >>> oscillator.names, oscillator.natural_frequency
    (('spring', 'springpot', 'barrier', 'white_noise'), 3.0)
    """

    def __new__(  # type: ignore[misc]
        cls,
        natural_frequency: float = 1.0,
        springpot: Springpot = _SPRINGPOT,
        barrier: Barrier | None = _WALL,
        excitation: WhiteNoise = _NOISE,
        **others: Never,
    ) -> System:
        check_names("Oscillator", others, ["natural_frequency", "springpot", "barrier", "excitation"])
        frequency = checked_frequency(natural_frequency, springpot, barrier, excitation)
        # sqrt(fl(w^2)) = w in binary arithmetic: the frequency comes back without a rounding error
        return System(Spring(frequency**2), springpot, *([] if barrier is None else [barrier]), excitation)

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
        free_side: Literal["above", "below"] = "above",
        sides: Sides = 1,
        of: Excited | None = None,
        **others: Never,
    ) -> System:
        """A device in SI units: its results are in newtons and watts.

        The device obeys m x'' + k_alpha D^alpha x + k x = -m a_base(t), or F(t) instead of -m a_base(t), where x is the
        displacement relative to the base.

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
            Of the stop, from 0 to 1.
        free_side : {"above", "below"}
            Of the stop, where the mass moves: ``"above"`` a stop at x = -gap, ``"below"`` a stop at x = gap.
        sides : {1, 2}
            1: the density is one-sided (positive frequencies only), as test equipment and standards state it;
            2: two-sided.
        of : {"base", "force"}, optional
            What the density is of, if you want to state it: it must agree with ``psd_unit``.

        Returns
        -------
        System

        Raises
        ------
        TypeError, ValueError
            If a number is not one, not finite or out of its range, a word is not one of those above, or two of them
            do not fit together.

        Examples
        --------
        A harvester of 50 g at 25 Hz, shaken with 0.01 g^2/Hz, with a stop at 4 mm:

        >>> harvester = Oscillator.from_device(
        ...     mass=0.050, stiffness=1234.0, springpot=(1.0, 0.20), gap=0.004, restitution=0.6,
        ...     psd=0.01, psd_unit="g2/Hz",
        ... )
        >>> round(harvester.natural_frequency, 1), harvester.names
        (157.1, ('mass', 'spring', 'springpot', 'barrier', 'white_noise'))
        """
        check_names("Oscillator.from_device", others, [*signature(cls.from_device).parameters][:-1])
        mass = positive_number(mass, "mass", "It is in kg.")
        stiffness = positive_number(stiffness, "stiffness", "It is in N/m.")
        if not isinstance(springpot, tuple | list) or len(springpot) != 2:
            raise TypeError(
                f"springpot must be two numbers, (order, k_alpha), not {shown(springpot)}. A dashpot c in N s/m is "
                "(1, c)."
            )
        order = finite_number(
            springpot[0], "springpot's order", low=0.0, high=1.0, hint="It runs from 0 (a spring) to 1 (a dashpot)."
        )
        hint = "It is in N s^order/m, per device, not per kg."
        k_alpha = finite_number(springpot[1], "springpot's k_alpha", low=0.0, high=LARGEST, hint=hint)
        noise = WhiteNoise.from_psd(psd, psd_unit, sides=sides)
        check_excited(of, psd_unit)
        stop = _stop(gap, restitution, free_side)
        return System(Mass(mass), Spring(stiffness), Springpot(order, k_alpha), *([stop] if stop else []), noise)

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
        free_side: Literal["above", "below"] | None = None,
        barrier: bool = True,
        **others: Never,
    ) -> System:
        """The oscillator with these numbers: those of `Springpot`, `Barrier`, `WhiteNoise` and its own.

        Parameters
        ----------
        order, coefficient : float
            Of the springpot, (1) and s^(order - 2).
        natural_frequency : float
            In rad/s.
        intensity : float
            Of the noise, in m^2 s^-3.
        position, restitution, free_side
            Of the wall, in m and (1); without a free side it is that of x = 0.
        barrier : bool
            False: without the wall.

        Returns
        -------
        System

        Raises
        ------
        TypeError, ValueError
            If a number is not one, not finite or out of its range, or something is said of a wall that is not there.

        Examples
        --------
        >>> Oscillator.from_numbers(order=0.3, position=-0.5).potential.low
        -0.5
        """
        check_names("Oscillator.from_numbers", others, [*signature(cls.from_numbers).parameters][:-1])
        wall = Barrier(position, restitution, free_side)  # type: ignore[arg-type]
        if not switch(barrier, "barrier") and wall != Barrier():
            raise ValueError(
                "barrier = false cannot be combined with position, restitution or free_side: there is no wall."
            )
        return cls(natural_frequency, Springpot(order, coefficient), wall if barrier else None, WhiteNoise(intensity))


def _stop(gap: float | None, restitution: float, free_side: Literal["above", "below"]) -> Barrier | None:
    if gap is None:
        if Barrier(restitution=restitution, free_side=free_side) != Barrier():
            raise ValueError("gap must be given with restitution or free_side: without a gap there is no wall.")
        return None
    distance = real(gap, "gap", "It is the distance from equilibrium to the wall in m; a negative gap is a preload.")
    position = distance if free_side == "below" else -distance
    return Barrier(position=position + 0.0, restitution=restitution, free_side=free_side)  # + 0.0: no negative zero
