"""The dimensionless problem, the conversion back to units, and the cases without a stationary state or noise.

The unit of time is 1/Omega and that of length sqrt(q/Omega^3), so that the natural frequency and the intensity are 1;
the mass moves above its wall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.system import System
from springpot.theory.numerics.contours import mean_squares
from springpot.theory.result import NEVER_STRUCK, Moments, moments_of


@dataclass(frozen=True)
class Problem:
    """The dimensionless oscillator.

    Parameters
    ----------
    order, coefficient : float
        alpha and c = C Omega^(alpha-2).
    position, restitution : float
        b (positive for a preload, -inf without a wall) and r (1 without a wall).
    """

    order: float
    coefficient: float
    position: float
    restitution: float

    @property
    def in_phase(self) -> float:
        """cos(alpha pi/2), exactly 0 for a dashpot."""
        return 0.0 if self.order == 1.0 else math.cos(self.order * math.pi / 2.0)

    @property
    def out_of_phase(self) -> float:
        """sin(alpha pi/2)."""
        return math.sin(self.order * math.pi / 2.0)


@dataclass(frozen=True)
class Units:
    """Conversion of dimensionless numbers to units.

    Parameters
    ----------
    frequency : float
        In rad/s.
    length, speed : float
        In m and m/s; 0 without noise.
    side : float
        -1 where the mass moves below its wall, otherwise 1.
    origin : float
        Position in m from which displacements are measured.
    """

    frequency: float
    length: float
    speed: float
    side: float
    origin: float = 0.0

    @property
    def time(self) -> float:
        """In s."""
        return 1.0 / self.frequency

    def place(self, displacement: ArrayLike) -> Floats:
        """Dimensionless displacements from the origin, away from the wall."""
        return np.asarray(self.side * (np.asarray(displacement) - self.origin) / self.length)

    def pace(self, velocity: ArrayLike) -> Floats:
        """Dimensionless velocities, away from the wall."""
        return np.asarray(self.side * np.asarray(velocity) / self.speed)

    def moments(
        self, system: System, x_mean: float, x_mean_square: float, v_mean_square: float, hit: tuple[float, float, float]
    ) -> Moments:
        """Moments in units, and on the mass's own side of the wall; rate, mean and mean square speed of the impacts.

        Examples
        --------
        >>> from springpot.problem.parts import Barrier, Spring
        >>> _, units = problem_and_units(Dimensionless(natural_frequency=2.0, barrier=Barrier(free_side="below")))
        >>> units.moments(System(Spring(4.0), Barrier(free_side="below")), 1.0, 1.0, 1.0, (0.5, 1.0, 2.0)).impact_rate
        1.0
        """
        length, speed, (rate, mean, square) = self.length, self.speed, hit
        hits = [(rate * self.frequency, mean * speed, square * speed**2)]
        x = self.side * x_mean * length + 0.0
        return moments_of(system, [(x, x_mean_square * length**2, v_mean_square * speed**2)], hits=hits)


def problem_and_units(paper: Dimensionless, *, order_0_is_spring: bool = False) -> tuple[Problem, Units]:
    """The dimensionless problem and its units.

    Parameters
    ----------
    paper : Dimensionless
    order_0_is_spring : bool
        Whether a springpot of order 0 is added to the spring: the frequency of the units is then sqrt(Omega^2 + C), and
        the problem has no springpot (order 1, c = 0).

    Examples
    --------
    >>> problem, units = problem_and_units(Dimensionless(natural_frequency=4.0))
    >>> problem.coefficient, units.length
    (0.125, 0.125)
    """
    element, wall, q = paper.springpot, paper.barrier, paper.excitation.intensity
    order, c, omega = element.order, paper.dimensionless_coefficient, paper.natural_frequency
    if order == 0.0 and order_0_is_spring:
        order, c, omega = 1.0, 0.0, omega * math.sqrt(1.0 + c)
    speed = math.sqrt(q / omega)
    units = Units(omega, speed / omega, speed, paper.direction or 1.0)
    if wall is None:
        return Problem(order, c, -math.inf, 1.0), units
    position = units.side * wall.position
    if units.length > 0.0:
        position = position / units.length
    elif position:
        position = math.copysign(math.inf, position)
    return Problem(order, c, position, paper.restitution), units


def paper_covered(system: System) -> Dimensionless:
    """The paper's problem.

    Raises
    ------
    NotCoveredError
        If it is another one, or impacts on the wall are plastic.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> paper_covered(System(Spring(1.0), Barrier(0.0, 0.0), WhiteNoise(1.0)))
    Traceback (most recent call last):
        ...
    springpot.machine.faults.NotCoveredError: The methods for one mass cover restitutions above 0, not 0.
    """
    paper = Dimensionless.of(system)
    if paper.barrier is not None and paper.restitution == 0.0:
        raise NotCoveredError("The methods for one mass cover restitutions above 0, not 0.")
    return paper


def endless(paper: Dimensionless) -> str | None:
    """Why there is no stationary state, in one sentence; None if springpot or wall dissipate energy.

    Examples
    --------
    >>> from springpot.problem.parts import Springpot
    >>> endless(Dimensionless(springpot=Springpot(0.5, 0.0)))
    'There is no stationary state: nothing dissipates energy (C is 0), so the energy grows as q t / 2.'
    """
    if paper.dissipates:
        return None
    cause = "C is 0" if paper.springpot.coefficient == 0.0 else "order 0 is a spring of stiffness Omega^2 + C"
    noisy = paper.excitation.intensity > 0.0
    fate = "the energy grows as q t / 2" if noisy else "the energy stays constant"
    return f"There is no stationary state: nothing dissipates energy ({cause}), so {fate}."


def at_rest(system: System, paper: Dimensionless) -> Moments:
    """Moments without noise: the mass rests against the wall under a preload, at 0 otherwise.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> pressed = System(Spring(1.0), Barrier(0.5, free_side="above"), WhiteNoise(0.0))
    >>> at_rest(pressed, Dimensionless.of(pressed)).x_mean
    0.5
    """
    wall, side = paper.barrier, paper.direction
    place = 0.0 if wall is None else side * max(side * wall.position, 0.0) + 0.0
    return moments_of(system, [(place, place**2, 0.0)], hits=[NEVER_STRUCK])


def free_mean_squares(paper: Dimensionless) -> tuple[float, float] | str:
    """Dimensionless <x^2> and <v^2> without a wall, or why there are none."""
    problem, _ = problem_and_units(paper)
    if statement := endless(paper):
        return statement
    if problem.coefficient == 0.0:
        return "There is no stationary state in floating point: C Omega^(alpha-2) is too small."
    with np.errstate(over="ignore"):
        return mean_squares(problem.order, problem.coefficient)
