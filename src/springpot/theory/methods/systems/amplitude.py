"""Averaging of the amplitude: the closed form of the literature for hardening springs with fractional derivatives."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import Barrier, PolynomialDashpot, Springpot, WhiteNoise
from springpot.problem.parts.springpots import springpot_in
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import DAMPERS, SPRINGS, Coverage, unheld
from springpot.theory.decay import memory_decay, stiffness_share
from springpot.theory.densities import WithLaw
from springpot.theory.distributions import numbers_only
from springpot.theory.numerics.panels import Labels, panel_rule
from springpot.theory.result import Moments, moments_of

_REACH = (
    "Averaging of the amplitude covers springs of odd powers that harden, springpots and dashpots, white noise, and "
    "one wall at the equilibrium or none"
)
_COVERED = Coverage(_REACH, SPRINGS | DAMPERS | Springpot | Barrier | WhiteNoise, linear=PolynomialDashpot)
_FAR = 45.0  # exponent at which the density ends
_PANELS = 48
_ANGLES = 48
_SETTLED = 1e-14
_STEPS = 200  # of the frequency: each halves its error at least


@dataclass(frozen=True)
class _Cycle:
    """The cycles y = A cos(phi) of given amplitudes: one entry per amplitude for every array.

    Parameters
    ----------
    amplitude, frequency, stiffness : ndarray
        A, w(A), and the equivalent stiffness K(A) of the memory.
    energy, force : ndarray
        U(A) and U'(A) with K(A) as a linear spring.
    x_mean, x_square, v_square : ndarray
        Means over the cycle of \\|y\\|, y^2 and y'^2.
    """

    amplitude: Floats
    frequency: Floats
    stiffness: Floats
    energy: Floats
    force: Floats
    x_mean: Floats
    x_square: Floats
    v_square: Floats


@dataclass(frozen=True)
class _Problem:
    """The system per unit mass.

    Parameters
    ----------
    springs : tuple of float
        Coefficients of x, x^3, x^5 ...
    springpots : tuple of (order, coefficient)
        Springpots and dashpots.
    intensity : float
    side : float
        1 above a wall, -1 below it, 0 without one.
    restitution : float
    """

    springs: tuple[float, ...]
    springpots: tuple[tuple[float, float], ...]
    intensity: float
    side: float
    restitution: float

    @property
    def is_exact(self) -> bool:
        """Whether nothing is approximated: dashpots, and no loss in impacts."""
        return self.restitution == 1.0 and all(order == 1.0 for order, _ in self.springpots)

    def stiffness(self, w: Floats) -> Floats:
        """Equivalent stiffness of the memory on a cycle of frequency w."""
        found = np.zeros_like(w)
        for order, coefficient in self.springpots:
            if order < 1.0:
                share = stiffness_share(order, self.side != 0.0)
                found = found + coefficient * share * math.cos(order * math.pi / 2.0) * w**order
        return found

    def damping(self, w: Floats) -> Floats:
        """Equivalent damping coefficient."""
        each = (2.0 * memory_decay(order, coefficient, w, self.side != 0.0) for order, coefficient in self.springpots)
        return sum(each, np.zeros_like(w))

    def pace(self, amplitude: Floats, cosine: Floats, stiffness: Floats) -> Floats:
        """nu(A, phi) = sqrt(2 (U(A) - U(A cos phi))) / (A sin phi), for a column of amplitudes."""
        square = np.broadcast_to(stiffness, np.broadcast_shapes(stiffness.shape, cosine.shape))
        for power, k in enumerate(self.springs):
            terms = sum(cosine ** (2 * j) for j in range(power + 1))
            square = square + k / (power + 1) * amplitude ** (2 * power) * terms
        return np.sqrt(square)

    def cycles(self, amplitude: Floats) -> _Cycle:
        """Cycles of these amplitudes; their frequency and the memory's stiffness are found together."""
        a = amplitude[:, None]
        angles, weights = panel_rule([0.0, 0.5 * math.pi], _ANGLES)
        cosine, sine = np.cos(angles), np.sin(angles)
        w = np.ones_like(amplitude)
        for _ in range(_STEPS):
            k = self.stiffness(w)
            nu = self.pace(a, cosine, k[:, None])
            share = weights / nu
            quarter = np.sum(share, axis=1)
            before, w = w, 0.5 * math.pi / quarter
            if np.all(np.abs(w - before) <= _SETTLED * w):
                break
        share = share / quarter[:, None]
        powers = np.arange(len(self.springs))
        terms = [c * amplitude ** (2 * n) for n, c in zip(powers, self.springs, strict=True)]
        return _Cycle(
            amplitude=amplitude,
            frequency=w,
            stiffness=k,
            energy=amplitude**2 * (0.5 * k + sum(t / (2 * n + 2) for n, t in enumerate(terms))),
            force=amplitude * (k + sum(terms)),
            x_mean=amplitude * (share @ cosine),
            x_square=amplitude**2 * (share @ cosine**2),
            v_square=amplitude**2 * ((share * nu * nu) @ sine**2),
        )

    def slope(self, cycles: _Cycle) -> Floats:
        """The derivative by A of the exponent of the density."""
        impacts = -2.0 / math.pi * math.log(self.restitution) * cycles.frequency * cycles.energy / cycles.v_square
        return 2.0 / self.intensity * (self.damping(cycles.frequency) + impacts) * cycles.force


@dataclass(frozen=True)
class _Law:
    """The stationary density of the amplitude, at the nodes of panels.

    Parameters
    ----------
    problem : _Problem
    labels : Labels
        Panels of the amplitude.
    cycles : _Cycle
    exponent : ndarray
    total : float
        The integral of the density before it is divided by it.
    """

    problem: _Problem
    labels: Labels
    cycles: _Cycle
    exponent: Floats
    total: float

    def average(self, values: Floats) -> float:
        return float(self.labels.weights.ravel() @ (self.density * values))

    @property
    def density(self) -> Floats:
        """p(A) at the nodes."""
        return np.asarray(self.cycles.force / self.cycles.frequency * np.exp(-self.exponent) / self.total)

    def at(self, amplitude: Floats) -> Floats:
        """p(A) at any amplitudes."""
        inside = (amplitude > 0.0) & (amplitude < self.labels.edges[-1])
        a = np.where(inside, amplitude, self.labels.edges[-1]).ravel()
        cycles = self.problem.cycles(a)
        exponent = self.labels.interpolate(self.exponent[:, None], a)[:, 0]
        found = (cycles.force / cycles.frequency * np.exp(-exponent) / self.total).reshape(amplitude.shape)
        return np.where(inside, found, 0.0)

    def x_at(self, x: Floats) -> Floats:
        """p(x) = int p(A) 2 / (T v) dA over A > \\|x\\|, with s^2 = A^2 - x^2."""
        side = self.problem.side
        inside = (np.abs(x) < self.labels.edges[-1]) & (side * x >= 0.0)
        place = np.abs(np.where(inside, x, 0.0)).ravel()[:, None]
        part, weights = panel_rule(np.linspace(0.0, 1.0, 9), _ANGLES)
        top = np.sqrt(self.labels.edges[-1] ** 2 - place**2)
        s = top * part**2
        a = np.sqrt(place**2 + s * s)
        cycles = self.problem.cycles(a.ravel())
        stiffness, frequency = cycles.stiffness.reshape(a.shape), cycles.frequency.reshape(a.shape)
        pace = self.problem.pace(a, place / a, stiffness)
        values = self.at(a) * frequency / (math.pi * pace * a) * 2.0 * top * part
        found = (values @ weights).reshape(x.shape)
        return np.where(inside, (2.0 if side else 1.0) * found, 0.0)


@dataclass(frozen=True)
class AmplitudeAveraging(WithLaw["_Law"]):
    """Result of averaging of the amplitude: moments, densities of the amplitude and of x, and the cycles themselves.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`.
    """

    @numbers_only
    def amplitude_density(self, amplitude: ArrayLike) -> Floats:
        """Density of the amplitude of the cycles, in 1/m.

        Parameters
        ----------
        amplitude : array_like
            The largest \\|x\\| of a cycle, in m.

        Raises
        ------
        NoStationaryStateError
            If there is none.

        Examples
        --------
        >>> import springpot as sp
        >>> duffing = sp.System(
        ...     sp.Spring(1.0), sp.PolynomialSpring((0, 0, 1.0)), sp.Springpot(0.5, 0.1), sp.WhiteNoise(1.0)
        ... )
        >>> averaging_amplitude(duffing).amplitude_density([0.5, 2.0]).round(4)
        array([0.1137, 0.5072])
        """
        return self._stationary_law().at(np.asarray(amplitude))

    @numbers_only
    def x_density(self, displacement: ArrayLike) -> Floats:
        """Density of x, in 1/m.

        Parameters
        ----------
        displacement : array_like
            x in m.

        Raises
        ------
        NoStationaryStateError
            If there is none.

        Examples
        --------
        >>> import springpot as sp
        >>> duffing = sp.System(
        ...     sp.Spring(1.0), sp.PolynomialSpring((0, 0, 1.0)), sp.Springpot(0.5, 0.1), sp.WhiteNoise(1.0)
        ... )
        >>> averaging_amplitude(duffing).x_density([0.0, 2.0]).round(4)
        array([0.2426, 0.1306])
        """
        return self._stationary_law().x_at(np.asarray(displacement))

    @numbers_only
    def frequency(self, amplitude: ArrayLike) -> Floats:
        """Frequency w(A) of a cycle, in rad/s.

        Parameters
        ----------
        amplitude : array_like
            A > 0 in m.

        Raises
        ------
        NoStationaryStateError
            If there is none.
        TypeError, ValueError
            If an amplitude is not a positive finite number.

        Examples
        --------
        >>> import springpot as sp
        >>> cubic = sp.System(sp.PolynomialSpring((0, 0, 1.0)), sp.Dashpot(0.1), sp.WhiteNoise(1.0))
        >>> averaging_amplitude(cubic).frequency([1.0, 2.0]).round(4)
        array([0.8472, 1.6944])
        """
        return self._cycles(amplitude).frequency.reshape(np.shape(amplitude))

    @numbers_only
    def damping(self, amplitude: ArrayLike) -> Floats:
        """Equivalent damping coefficient of springpots and dashpots at an amplitude, in N s/m (per unit mass without).

        Parameters and errors are those of `frequency`.
        """
        found = self._stationary_law().problem.damping(self._cycles(amplitude).frequency) * self.system.inertia
        return found.reshape(np.shape(amplitude))

    def _cycles(self, amplitude: ArrayLike) -> _Cycle:
        law, a = self._stationary_law(), np.asarray(amplitude)
        if not np.all(a > 0.0):
            raise ValueError("amplitude must be positive and finite.")
        return law.problem.cycles(a.ravel())


@np.errstate(all="ignore")  # what is not finite is no answer
def averaging_amplitude(system: System) -> AmplitudeAveraging:
    """Stochastic averaging of the amplitude with an equivalent stiffness and damping, as in much of the literature.

    Parameters
    ----------
    system : System
        Springs of odd powers with coefficients of at least 0, springpots, dashpots and white noise; no wall, or one
        rigid wall at the equilibrium.

    Returns
    -------
    AmplitudeAveraging

    Raises
    ------
    NotCoveredError
        If the system is another one; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    A cycle is x = A cos(phi), or \\|x\\| = A \\|cos(phi)\\| behind a wall, with phi' = nu(A, phi) as for a generalized
    harmonic function [1]_.  On it a springpot acts as the spring K(A) = C cos(alpha pi/2) w^alpha and the dashpot
    B(A) = C sin(alpha pi/2) w^(alpha-1), w(A) = 2 pi / T(A) (generalized harmonic balance [2]_ [3]_).  A wall
    multiplies them by the sums over the harmonics of \\|cos\\|.  With U the potential with K(A) in it,

        p(A) ~ T(A) U'(A) exp(-(2/q) int_0^A (B + impacts) U' dA),

    impacts = -(4 ln r) U / (T <v^2>).  The amplitude must change little in one cycle, and K(A) is held fixed
    when the amplitude is differentiated: the energy that the memory lends out is not counted, so that <x^2> and <v^2>
    have errors of first order in C (the `envelope` has no such error).  At order 1 it is exact, but for impacts with
    loss.  For a linear spring it is `averaging` of the form ``"shifted"``, which has
    its densities, correlation and spectrum in closed form.

    References
    ----------
    .. [1] Z. L. Huang and X. L. Jin, "Response and stability of a SDOF strongly nonlinear stochastic system with light
       damping modeled by a fractional derivative", Journal of Sound and Vibration 319 (2009) 1121.
    .. [2] P. D. Spanos and G. I. Evangelatos, "Response of a non-linear system with restoring forces governed by
       fractional derivatives", Soil Dynamics and Earthquake Engineering 30 (2010) 811.
    .. [3] L. C. Chen, W. H. Wang, Z. S. Li and W. Q. Zhu, "Stationary response of Duffing oscillator with hardening
       stiffness and fractional derivative", International Journal of Non-Linear Mechanics 48 (2013) 44.

    Examples
    --------
    >>> import springpot as sp
    >>> duffing = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 0.1), sp.WhiteNoise(1.0)
    ... )
    >>> round(averaging_amplitude(duffing).x_mean_square, 2)
    1.95
    """
    system = checked_system(system)
    problem = check_covered(system)
    stationary: Moments | str
    law = None
    if not problem.intensity > 0.0:
        stationary = "There is no random stationary state: nothing excites the motion."
    elif not any(problem.springs):
        stationary = unheld(system.elements.values(), "no spring holds the mass")
    elif not problem.springpots and problem.restitution == 1.0:
        stationary = "There is no stationary state: nothing dissipates energy, so it grows without end."
    else:
        law = _law(problem)
        stationary = _moments(system, law)
    return AmplitudeAveraging(
        method="averaging_amplitude",
        system=system,
        stationary=stationary,
        assumptions=(
            "The amplitude changes little in one cycle: damping and noise are light.",
            "The memory acts on a cycle as a spring and a dashpot, of the frequency of its amplitude.",
            "An impact takes little energy: it multiplies the speed by r once in each half period.",
        )[: 3 if problem.restitution < 1.0 else 2],
        warnings=() if law is None else tuple(_warnings(problem, law)),
        is_exact=problem.is_exact,
        _law=law,
    )


def check_covered(system: System) -> _Problem:
    """What the method solves, where it is covered; otherwise `NotCoveredError`."""
    unit = system.per_unit_mass
    _COVERED.check(unit)
    for name, wall in unit.walls.items():
        if callable(wall.restitution):
            raise NotCoveredError(f"{_REACH}, not the restitution of {name}.")
        if wall.position != 0.0:
            raise NotCoveredError(f"{_REACH}, not {name} at {wall.position:g} m.")
    walls = [*unit.walls.values()]
    if len(walls) > 1:
        raise NotCoveredError(f"{_REACH}, not two walls.")
    coefficients = (*unit.potential.coefficients, 0.0)
    if any(coefficients[::2]) or any(k < 0.0 for k in coefficients):
        raise NotCoveredError(f"{_REACH}; here the springs have even powers, or soften.")
    springpots = [
        (springpot.order, springpot.coefficient)
        for part in unit.parts
        if (springpot := springpot_in(part)) and springpot.dissipates
    ]
    if unit.damping > 0.0:
        springpots.append((1.0, unit.damping))
    return _Problem(
        springs=coefficients[1::2] or (0.0,),
        springpots=tuple(springpots),
        intensity=sum(noise.white_intensity for noise in unit.excitations.values()),
        side=walls[0].inwards if walls else 0.0,
        restitution=slow_restitution(walls[0]) if walls else 1.0,  # a number
    )


def _law(problem: _Problem) -> _Law:
    """The density on panels that are narrower where amplitudes are small."""
    decades = np.linspace(-75.0, 75.0, 3001)
    amplitude = 10.0**decades
    cycles = problem.cycles(amplitude)
    exponent = problem.slope(cycles) * amplitude  # of the size of the exponent, at least its half
    known = np.isfinite(exponent)
    place = int(np.searchsorted(exponent[known], 4.0 * _FAR))
    if place == np.count_nonzero(known):
        raise NotCoveredError(f"{_REACH}; here the amplitudes are larger than double precision holds.")
    last = float(amplitude[known][place])
    labels = Labels(last * np.linspace(0.0, 1.0, _PANELS + 1) ** 2)
    cycles = problem.cycles(labels.nodes.ravel())
    exponent = labels.integral(problem.slope(cycles))
    density = cycles.force / cycles.frequency * np.exp(-exponent)
    return _Law(problem, labels, cycles, exponent, float(labels.weights.ravel() @ density))


def _moments(system: System, law: _Law) -> Moments:
    cycles, side = law.cycles, law.problem.side
    x_square, v_square = law.average(cycles.x_square), law.average(cycles.v_square)
    hits = cycles.frequency / math.pi
    rate = law.average(hits)
    struck = (
        (rate, law.average(hits * np.sqrt(2.0 * cycles.energy)) / rate, law.average(hits * 2.0 * cycles.energy) / rate),
    )
    x_mean = side * law.average(cycles.x_mean) + 0.0
    return moments_of(system, [(x_mean, x_square, v_square)], hits=struck if side else ())


def _warnings(problem: _Problem, law: _Law) -> Iterator[str]:
    if problem.is_exact:
        return
    cycles = law.cycles
    decay = law.average(problem.slope(cycles) * problem.intensity * cycles.v_square / (2.0 * cycles.force))
    taken = decay * 2.0 * math.pi / law.average(cycles.frequency) / law.average(cycles.energy)
    if taken > 1.0:
        yield f"Damping is not light: a cycle takes {taken:.2g} times the mean energy."
