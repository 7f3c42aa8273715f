"""Stochastic averaging: the paper's closed form (Eq. 18-20), as printed, corrected, and at a shifted frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import finite_array, finite_number, real_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, shown
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts.springpots import resonance
from springpot.problem.system import System, checked_system
from springpot.theory.decay import impact_decay, mean_square_amplitude, memory_decay, stiffness_share
from springpot.theory.densities import DensitiesOfAmplitude
from springpot.theory.distributions import Normals, modulus_correlation, times
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.problem import Units, at_rest, endless, paper_covered
from springpot.theory.result import Moments, NoStationaryStateError, moments_of

_NOTHING = 1e-200  # m^2, of a motion that has not begun
_MOST_HARMONICS = 10_000  # of lines in a spectrum, which takes some tenths of a second
_METHODS = {"corrected": "averaging", "printed": "averaging_printed", "shifted": "averaging_amplitude"}
_LIGHT = 0.1  # the largest c at which <A^2> without a wall is within 2 % of the exact one, at every order
_CHECKED = 1.0  # the largest c at which it was compared with the exact one at several orders
_MAPPED = 3.0  # the largest c on the validity map, which has the errors with a wall
_POWERS = 64  # of the squared correlation, summed one by one; higher ones in blocks
_BLOCKS = 22  # each twice as long: the terms fall like k^-3
_BLOCK_NODES = 8
_HARMONICS = 24  # of the spectrum, beyond the highest frequency asked for


@dataclass(frozen=True)
class Averaging(DensitiesOfAmplitude[Normals]):
    """Result of stochastic averaging: moments, densities, correlation, spectrum and transients.

    With a^2 = x^2 + v^2 / w^2 the amplitude obeys the Ito equation
    da = [-beta a + q / (4 w^2 a)] dt + sqrt(q / 2) / w dB, so that mu = <a^2> obeys the paper's Eq. 19,
    mu' = -2 beta mu + q / w^2.  From rest a is Rayleigh distributed at every time, with mean square mu(t).  The
    frequency w is Omega, and a is A, but in the shifted form.

    Parameters
    ----------
    decay_rate : float
        beta >= 0, in 1/s: the rate at which the free amplitude decays.
    frequency : float
        w in rad/s, at which the motion between impacts is averaged.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.
    """

    decay_rate: float
    frequency: float

    @np.errstate(all="ignore")  # at the ends of double precision
    def drift(self, amplitude: ArrayLike) -> Floats:
        """Ito drift of the amplitude a = sqrt(x^2 + v^2 / w^2), -beta a + q / (4 w^2 a), in m/s.

        Parameters
        ----------
        amplitude : array_like
            a > 0 in m.

        Raises
        ------
        TypeError, ValueError
            If an amplitude is not a positive finite number.

        Examples
        --------
        >>> import springpot as sp
        >>> float(averaging(sp.Oscillator()).drift(1.0).round(4))
        0.0323
        """
        a = real_array(amplitude, "amplitude")
        if not np.all((a > 0.0) & np.isfinite(a)):
            raise ValueError("amplitude must be positive and finite: the drift grows like 1 / A towards 0.")
        return np.asarray(-self.decay_rate * a + self.diffusion / (2.0 * a))

    @property
    def diffusion(self) -> float:
        """Growth per second of the amplitude's variance, q / (2 w^2), in m^2/s; the same at every amplitude."""
        return self.paper.excitation.intensity / (2.0 * self.frequency**2)

    def mean_square(self, time: ArrayLike, initial: float = 0.0) -> Floats:
        """mu(t) = <x^2 + v^2 / w^2>, the solution of the paper's Eq. 19, with and without a stationary state.

        Parameters
        ----------
        time : array_like
            t >= 0 in s; at infinity it is the stationary mean square.
        initial : float
            mu at t = 0, in m^2; 0 is rest.

        Returns
        -------
        ndarray
            In m^2, same shape as ``time``.

        Raises
        ------
        TypeError, ValueError
            If ``initial`` is negative or not a number, or a time is negative, NaN or not a number.
        NoStationaryStateError
            If a time is infinite and there is no stationary state.

        Examples
        --------
        >>> import springpot as sp
        >>> float(averaging(sp.Oscillator(springpot=sp.Springpot(order=0.0, coefficient=1.0))).mean_square(10.0))
        10.0
        """
        from scipy import special  # slow to import, and most runs need none of it

        start = finite_number(initial, "initial", low=0.0)
        t = times(time, "time")
        if np.any(np.isinf(t)) and isinstance(self.stationary, str):
            raise NoStationaryStateError(self.stationary)
        if self.decay_rate > 0.0:
            t = np.minimum(t, 400.0 / self.decay_rate)  # e^-800 is 0: nothing changes any more
        exponent = -2.0 * self.decay_rate * t
        # exprel(z) = (e^z - 1) / z is 1 at z = 0, where the mean square grows in proportion to time.
        return np.asarray(start * np.exp(exponent) + 2.0 * self.diffusion * t * special.exprel(exponent))

    def correlation(self, lag: ArrayLike) -> Floats:
        """<x(t) x(t + lag)> in the stationary state, in m^2: <x^2> at lag 0, the squared mean far away.

        The averaged motion is a cos(wt) - b sin(wt), with a and b independent normal processes of correlation
        exp(-beta lag), lag > 0: it is normal, of correlation coefficient rho = exp(-beta lag) cos(w lag).  Without a
        wall that is x.  With one, x is its modulus, and <x x'> = (2/pi) <x^2> [sqrt(1 - rho^2) + rho arcsin rho].

        Parameters
        ----------
        lag : array_like
            In s, of either sign.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError, ValueError
            If a lag is NaN or not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> averaging(sp.Oscillator()).correlation([0.0, 1.0, 100.0]).round(4)
        array([1.1481, 0.8011, 0.7309])
        """
        variance = self.x_mean_square
        t = np.minimum(times(lag, "lag", either_sign=True), 800.0 / self.decay_rate)  # e^-800 is 0
        rho = np.exp(-self.decay_rate * t) * np.cos(self.frequency * t)
        if self.paper.barrier is not None:
            rho = modulus_correlation(rho)
        return np.asarray(variance * rho)

    @np.errstate(all="ignore")  # at the ends of double precision
    def spectrum(self, frequency: ArrayLike) -> Floats:
        """Two-sided spectral density of x, in m^2 s per rad, of the motion described at `correlation`.

        Its integral over the real line is the variance <x^2> - <x>^2; the mean is a spike at 0, left out.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError, ValueError
            If a frequency is not a finite number.

        Notes
        -----
        Without a wall it is one pair of Lorentzian lines at +-w.  With one, the arcsine law is a series in rho^2k, and
        each power a sum of lines at 0, +-2w, ... +-2kw of half width 2k beta.

        Examples
        --------
        >>> import springpot as sp
        >>> averaging(sp.Oscillator()).spectrum([0.0, 1.0, 2.0]).round(4)
        array([0.1466, 0.0383, 0.0789])
        """
        variance = self.x_mean_square
        w = np.abs(finite_array(frequency, "frequency"))
        if self.paper.barrier is None:
            return np.asarray(variance * _lines(w, self.frequency, np.array([self.decay_rate]), np.ones(1)))
        if (most := float(np.max(w, initial=0.0))) > (highest := _MOST_HARMONICS * 2.0 * self.frequency):
            raise ValueError(f"frequency must be at most {highest:.3g} rad/s behind a wall, not {most:g}.")
        power, count = _power_rule()
        total = np.zeros(w.shape)
        highest = math.ceil(float(np.max(w, initial=0.0)) / (2.0 * self.frequency))
        for harmonic in range(highest + _HARMONICS):
            weight = count * _line_strength(power, harmonic)
            total += _lines(w, 2.0 * harmonic * self.frequency, 2.0 * power * self.decay_rate, weight)
        return np.asarray(2.0 / math.pi * variance * total)

    def _more(self) -> dict[str, object]:
        shifted = {"frequency": self.frequency} if self.method == _METHODS["shifted"] else {}
        return {"decay_rate": self.decay_rate, **shifted}

    def _at(self, time: float | None) -> Normals:
        if time is not None and real_array(time, "time").ndim:
            raise TypeError(f"time must be one number, not {shown(time)}.")
        mu = 2.0 * self.x_mean_square if time is None else float(self.mean_square(time))
        if mu < _NOTHING:
            raise ValueError("there is no density: the amplitude is always zero (at rest, or without noise).")
        # x = a cos p and v = w a sin p with a uniform phase p and a Rayleigh amplitude a
        omega, side, spread = self.paper.natural_frequency, self.paper.direction, math.sqrt(mu / 2.0)
        return Normals(
            Units(omega, 1.0, omega, side or 1.0), spread, spread * self.frequency / omega, 0.0 if side else math.nan
        )


@np.errstate(all="ignore")  # what is not finite is no answer
def averaging(system: System, form: Literal["corrected", "printed", "shifted"] = "corrected") -> Averaging:
    """Solve the paper's problem by stochastic averaging (its Eq. 18-20).

    Parameters
    ----------
    system : System
        A linear spring, one springpot or dashpot and white noise, without a wall, or with a wall at position 0 on
        either side.
    form : {"corrected", "printed", "shifted"}
        ``"corrected"`` has Omega^(alpha-1) in the decay rate,
        beta = (32 C / pi^2) Omega^(alpha-1) sin(alpha pi/2) S(alpha), and adds -(Omega/pi) ln r for a wall that loses
        energy.  ``"printed"`` has the paper's Omega^(alpha-2) (Eq. 18-20), for an elastic wall only; both agree
        at Omega = 1.  ``"shifted"`` is the corrected form at the frequency w > Omega that the springpot's in-phase
        force gives: w^2 = Omega^2 + (16 C / pi^2) cos(alpha pi/2) sum_m (2 m w)^alpha / (4m^2-1)^2 with a wall,
        w^2 = Omega^2 + C w^alpha cos(alpha pi/2) without; here <x^2> and <v^2> / Omega^2 differ.  It is
        `averaging_amplitude` where the spring is linear, in closed form.

    Returns
    -------
    Averaging

    Raises
    ------
    NotCoveredError
        If it has other parts or the wall is not at 0, or the printed form is asked for a wall that loses energy or for
        no wall.
    TypeError
        If it is not a System.
    ValueError
        If ``form`` is another word.

    Examples
    --------
    >>> import springpot as sp
    >>> oscillator = sp.Oscillator(natural_frequency=3.0, springpot=sp.Springpot(order=0.7, coefficient=0.2))
    >>> round(averaging(oscillator).amplitude_mean_square, 3)
    1.173
    >>> round(averaging(oscillator, form="printed").amplitude_mean_square, 3)
    3.519
    """
    if not isinstance(form, str) or form not in _METHODS:
        raise ValueError(f"form must be 'shifted', 'corrected' or 'printed', not {shown(form)}.")
    system = checked_system(system)
    paper = check_covered(system, form)
    frequency = _shifted_frequency(paper) if form == "shifted" else paper.natural_frequency
    springpot = paper.springpot
    beta = memory_decay(springpot.order, springpot.coefficient, frequency, paper.barrier is not None)
    if form == "printed":
        beta /= paper.natural_frequency
    beta += impact_decay(paper, frequency)
    return Averaging(
        method=_METHODS[form],
        system=system,
        stationary=_stationary(system, paper, beta, frequency),
        assumptions=_assumptions(paper, form),
        warnings=_warnings(paper, form),
        decay_rate=beta,
        frequency=frequency,
    )


def check_covered(system: System, form: str = "corrected") -> Dimensionless:
    """The paper's problem, where it is covered; otherwise `NotCoveredError`."""
    paper = paper_covered(system)
    wall = paper.barrier
    if wall is not None and wall.position != 0.0:
        raise NotCoveredError(
            f"Averaging covers a wall at position 0 or no wall, not a wall at {wall.position:g} m from equilibrium."
        )
    if form == "printed" and wall is None:
        raise NotCoveredError(
            "The printed formula covers an elastic wall at position 0, not an oscillator without a wall."
        )
    if form == "printed" and wall is not None and paper.restitution < 1.0:
        raise NotCoveredError(
            f"The printed formula covers an elastic wall (restitution 1), not restitution {paper.restitution:g}."
        )
    return paper


def _shifted_frequency(paper: Dimensionless) -> float:
    """w of a steady oscillation with the springpot's in-phase force: with a wall that is less than of a free one."""
    springpot = paper.springpot
    share = stiffness_share(springpot.order, paper.barrier is not None)
    return resonance(paper.natural_frequency**2, [replace(springpot, coefficient=share * springpot.coefficient)])


def _stationary(system: System, paper: Dimensionless, beta: float, frequency: float) -> Moments | str:
    if statement := endless(paper):
        return statement
    mu = mean_square_amplitude(paper, beta, frequency)
    if not math.isfinite(mu):
        return f"There is no stationary state in floating point: the decay rate {beta:g} 1/s is too small for <A^2>."
    if mu == 0.0:
        return at_rest(system, paper)
    v_square = paper.excitation.intensity / (4.0 * beta)
    hit = frequency / math.pi, frequency * math.sqrt(math.pi * mu) / 2.0, 2.0 * v_square
    x_mean = paper.direction * math.sqrt(mu / math.pi) + 0.0
    return moments_of(system, [(x_mean, mu / 2.0, v_square)], hits=[hit])


def _assumptions(paper: Dimensionless, form: str) -> tuple[str, ...]:
    common = (
        "The amplitude changes little in one cycle: damping and noise are light.",
        "The motion between impacts is at the frequency Omega: the springpot's stiffness is neglected."
        if form != "shifted"
        else "The motion between impacts is at one frequency w, which the springpot's in-phase force sets.",
        "The past motion is a steady oscillation: the start no longer matters.",
    )
    if paper.barrier is None or paper.restitution == 1.0:
        return common
    return (*common, "An impact takes little energy: it multiplies the amplitude by r once in each half period.")


def _warnings(paper: Dimensionless, form: str) -> tuple[str, ...]:
    alpha, c = paper.springpot.order, paper.dimensionless_coefficient
    sentences: list[str] = []
    if form == "printed" and paper.natural_frequency != 1.0:
        sentences.append(
            "The printed formula is dimensionally inconsistent: it has Omega^(alpha-2) where Omega^(alpha-1) belongs, "
            f"so away from Omega = 1 its <A^2> is wrong by a factor Omega = {paper.natural_frequency:g}."
        )
    if alpha == 0.0 and c > 0.0:
        sentences.append(
            "At order 0 the springpot is a spring, which the amplitude of averaging does not include: use "
            "sqrt(Omega^2 + C) as the natural frequency, or the envelope."
        )
    if 0.0 < alpha < 1.0:
        sentences += _with_a_wall(c, form) if paper.barrier is not None else _without_a_wall(c, form)
    return tuple(sentences)


def _with_a_wall(c: float, form: str) -> list[str]:
    """Errors against Monte Carlo beyond the validity map."""
    if c <= _MAPPED:
        return []
    here = f"The springpot is strong (c = C Omega^(alpha-2) = {c:.3g}) and this result is unchecked"
    if form == "shifted":
        return [f"{here}: at c = 3 the impact rate is already 43 to 62 % too high."]
    return [
        f"{here}: at alpha = 0.5 the error of the corrected <A^2> is +8, +7, -2, -19, -40 % at c = 1, 3, 10, 30, 100, "
        "and the impact rate is up to 4 times too high."
    ]


def _without_a_wall(c: float, form: str) -> list[str]:
    """Errors against the exact spectrum; the validity map has only cases with a wall."""
    here = f"c = C Omega^(alpha-2) = {c:.3g}"
    if c <= _LIGHT:
        return []
    if form == "shifted":
        return [
            f"The springpot is not light ({here}): without a wall the shifted <A^2> is 12, 12, 8, 3 % too low at c = 1 "
            "for alpha = 0.7, 0.5, 0.3, 0.1 (the corrected one 1, 2, 3, 5 %), and 24, 19, 11, 4 % at c = 3 "
            "(3, 8, 14, 18 %)."
        ]
    if c <= _CHECKED:
        return [f"The springpot is not light ({here}): at c = 1, alpha = 0.5, <A^2> without a wall is 2 % too low."]
    return [
        f"The springpot is strong ({here}) and this result is unchecked: at alpha = 0.5 <A^2> without a wall is 2, 8, "
        "25, 43, 61 % too low at c = 1, 3, 10, 30, 100."
    ]


@lru_cache(maxsize=1)
def _power_rule() -> tuple[Floats, Floats]:
    """Nodes and weights for a sum over k = 1, 2, ... of terms that are smooth in ln k and fall like k^-3.

    Beyond the first k the sum is an integral between half integers, by Gauss nodes in blocks of doubling length: the
    error is that of the midpoint rule, below 1e-8 of the sum.
    """
    nodes, weights = panel_rule(_POWERS * np.exp2(np.arange(_BLOCKS + 1)) + 0.5, _BLOCK_NODES)
    first = np.arange(1.0, _POWERS + 1.0)
    return np.concatenate([first, nodes]), np.concatenate([np.ones_like(first), weights])


def _line_strength(power: Floats, harmonic: int) -> Floats:
    """Share of cos(2 harmonic p) in the term rho^2k, rho = cos p, of sqrt(1 - rho^2) + rho arcsin rho.

    That is C(2k-2, k-1) 4^(1-k) / (2k (2k-1)) times C(2k, k-harmonic) 4^-k, twice that for harmonic > 0.
    """
    from scipy import special  # slow to import, and most runs need none of it

    k, log_gamma = power, special.gammaln
    with np.errstate(divide="ignore"):
        coefficient = log_gamma(2.0 * k - 1.0) - 2.0 * log_gamma(k) - np.log(2.0 * k * (2.0 * k - 1.0))
        share = log_gamma(2.0 * k + 1.0) - log_gamma(k - harmonic + 1.0) - log_gamma(k + harmonic + 1.0)
    strength = np.exp(coefficient + share - (4.0 * k - 2.0) * math.log(2.0)) * (2.0 if harmonic else 1.0)
    return np.asarray(np.where(k >= harmonic, strength, 0.0))


def _lines(frequency: Floats, centre: float, half_width: Floats, weight: Floats) -> Floats:
    """Sum of weight times the transform of exp(-half_width \\|t\\|) cos(centre t), which has unit integral."""
    near, far = ((frequency + shift)[..., None] ** 2 for shift in (-centre, centre))
    square = half_width**2
    return np.asarray((1.0 / (square + near) + 1.0 / (square + far)) @ (weight * half_width) / (2.0 * math.pi))
