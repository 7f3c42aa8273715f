"""How often a stationary Gaussian response exceeds a level: formulas from its spectral density."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import optimize, special

from springpot.machine.arguments import LARGEST, finite_number, finite_numbers
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, known_word, shown
from springpot.problem.system import System
from springpot.theory.distributions import level_probabilities
from springpot.theory.methods.envelope.method import Envelope, envelope
from springpot.theory.methods.systems.linear import LinearResponse, linear, motions

_LEAST_LEVEL = 1e-9  # over the deviation: a level that lies less far off is the mean
_CLOSE, _SURE = 0.02, 1e-5  # of the levels by the envelope, in standard deviations
_NEAREST = 1e-3  # standard deviations between the mean and a level that is sought, least
_EVEN = 1e-6  # standard deviations of a mean that counts as 0
MEASURED = {
    "rice": "Counts every crossing: a bound on the probability. On one side its rate was within 6 % of Monte Carlo at "
    "a bandwidth of 0.4 or more, 18 to 61 % above it at 0.25 and 150 to 390 % at 0.11; on both sides twice as far.",
    "vanmarcke": "On one side it was within 6 % of Monte Carlo at a bandwidth of 0.33 or more, up to 22 % above it at "
    "0.2 to 0.25 and 28 to 73 % at 0.11; on both sides 17 % below to 16 % above it at 0.2 or more.",
    "envelope": "On one side and on both it was within 6 % of Monte Carlo, mostly within 3 %, at a bandwidth of 0.09 "
    "to 0.4.",
}
"""How far each rate was from Monte Carlo, of oscillators under white noise at 2 to 4 standard deviations."""


@dataclass(frozen=True, eq=False)
class LevelRates:
    """Rates at which a displacement first exceeds levels, by formulas, in the stationary state.

    Attributes
    ----------
    name : str
    levels : ndarray
        In m.
    at_start : ndarray
        Probability to be beyond each level at any given time.
    rate : dict of ndarray
        Of first exceedances in 1/s, by each formula: ``"rice"``, ``"vanmarcke"`` and, where it covers the system,
        ``"envelope"``.
    crossing_rate : float
        Upward crossings of the mean, in 1/s.
    bandwidth : float
        Vanmarcke's, sqrt(1 - m_1^2 / (m_0 m_2)) of the spectral moments: 0 of a single frequency.
    """

    name: str
    levels: Floats
    at_start: Floats
    rate: Mapping[str, Floats]
    crossing_rate: float
    bandwidth: float

    @property
    def measured(self) -> Mapping[str, str]:
        """Of each formula, how far it was from Monte Carlo at levels of 2 to 4 standard deviations."""
        return {name: MEASURED[name] for name in self.rate}

    @property
    def return_period(self) -> Mapping[str, Floats]:
        """Mean time between exceedances in s, one over the rate, by each formula."""
        return {name: 1.0 / rate for name, rate in self.rate.items()}

    def probability(self, duration: float) -> Mapping[str, Floats]:
        """Probability that each level is exceeded within a time, by each formula; that of Rice's rate is a bound.

        Parameters
        ----------
        duration : float
            In s.

        Raises
        ------
        TypeError, ValueError
            If it is not a positive number.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
        >>> within = exceedance(device, {"x": 3.2})["x"].probability(20.0)
        >>> round(float(within["rice"]), 5), round(float(within["vanmarcke"]), 5)
        (0.01971, 0.01538)
        """
        time = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in seconds.")
        found = {name: self.at_start - (1.0 - self.at_start) * np.expm1(-r * time) for name, r in self.rate.items()}
        return {**found, "rice": np.minimum(self.at_start + self.rate["rice"] * time, 1.0)}


@dataclass(frozen=True, eq=False)
class LevelsOfProbability:
    """Levels that a displacement exceeds with given probabilities within a time, by formulas, in the stationary state.

    Attributes
    ----------
    name : str
    probability : ndarray
    duration : float
        In s.
    level : dict of ndarray
        In m, by each formula, as the rates of `LevelRates`; that of Rice is an upper bound.
    """

    name: str
    probability: Floats
    duration: float
    level: Mapping[str, Floats]


def exceedance(system: System, levels: Mapping[str, Any]) -> dict[str, LevelRates]:
    """How often the displacements of a linear system first exceed levels, by Rice's and Vanmarcke's formulas.

    Parameters
    ----------
    system : System
        A linear one.
    levels : dict
        Quantities and their levels in m, one or many, such as ``{"x": [0.004, 0.005], "distance": 0.005}``: ``"x"`` on
        the side of the mean on which the level lies, ``"distance"``, the size of x, on both sides.  Of several masses
        ``"box_x"``, ``"box_distance"``, and of a part with two ends ``"mount_elongation"`` and ``"mount_distance"``.

    Returns
    -------
    dict of LevelRates
        By quantity.

    Raises
    ------
    NotCoveredError
        If the system is not linear, or its response is not Gaussian.
    NoStationaryStateError
        If it has no stationary state.
    TypeError, ValueError
        If there is no such quantity, or a level is no number or not beyond the mean.

    Notes
    -----
    With the number b of standard deviations between the mean and the level, Rice's rate on one side is that of all
    crossings, nu e^(-b^2 / 2).  Of crossings that follow each other in clumps only the first one counts: Vanmarcke's
    rate is that of Rice times (1 - e^(-sqrt(2 pi) s b)) / (1 - e^(-b^2 / 2)) with s the bandwidth to the power 1.2.  On
    both sides the rate doubles, and sqrt(2 pi) is half as large.  Where the mean is not 0, those of both sides are
    added.  ``"envelope"`` is the slowest rate of `springpot.theory.envelope`'s diffusion of the amplitude.

    S. O. Rice, Bell System Technical Journal 24, 1945; E. H. Vanmarcke, "On the distribution of the first-passage time
    for normal stationary random processes", Journal of Applied Mechanics 42, 1975.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    >>> found = exceedance(device, {"x": [3.2, 4.8], "distance": 3.2})
    >>> found["x"].rate["vanmarcke"], round(float(found["distance"].return_period["rice"]))
    (array([7.40...e-04, 1.41...e-06]), 526)
    """
    if not isinstance(levels, Mapping) or not levels:
        raise TypeError(f"levels must be a dict of names and levels, such as {{'x': [0.01]}}, not {shown(levels)}.")
    response = linear(system)
    return {name: _rates(response, name, given) for name, given in levels.items()}


def exceedance_level(system: System, probability: Mapping[str, Any], duration: float) -> dict[str, LevelsOfProbability]:
    """The levels that displacements of a linear system exceed with given probabilities within a time: the inverse of
    `exceedance`.

    Parameters
    ----------
    system : System
        A linear one.
    probability : dict
        Quantities, as in `exceedance`, and probabilities, one or many, in [1e-15, 0.5]; of ``"x"`` above the mean.
    duration : float
        In s.

    Returns
    -------
    dict of LevelsOfProbability
        By quantity.

    Raises
    ------
    NotCoveredError, NoStationaryStateError, TypeError, ValueError
        As `exceedance`; also if a probability is out of its range, or larger than that of a level next to the mean.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    >>> found = exceedance_level(device, {"x": [1e-3, 1e-6]}, 20.0)["x"].level["vanmarcke"]
    >>> found.round(3), exceedance(device, {"x": found})["x"].probability(20.0)["vanmarcke"].round(9)
    (array([3.982, 5.462]), array([1.e-03, 1.e-06]))
    """
    if not isinstance(probability, Mapping) or not probability:
        raise TypeError(
            f"probability must be a dict of names and probabilities, such as {{'x': 1e-6}}, not {shown(probability)}."
        )
    time = finite_number(duration, "duration", low=0.0, open_low=True, hint="It is in seconds.")
    response = linear(system)
    return {name: _levels(response, name, given, time) for name, given in probability.items()}


def _levels(response: LinearResponse, name: str, given: Any, duration: float) -> LevelsOfProbability:
    place, both = _asked(response.system, name, "probability")
    moments = mean, deviation, crossings, _ = _moments(response, place)
    wanted = level_probabilities(given, name)
    middle = abs(mean) if both else mean

    solved = _envelope_of(response.system, place)

    def off(level: float, formula: str, p: float) -> float:
        own = solved if formula == "envelope" else None
        rates = rates_at(name, both, moments, np.array([level]), own)
        return math.log(float(rates.probability(duration)[formula][0]) / p)

    def level_by(formula: str, p: float) -> float:
        """Rice's rate, which bounds the others, falls to p within these standard deviations."""
        b = math.sqrt(2.0 * math.log(max(2.0 * crossings * duration, 1.0) / p)) + 1.0
        near, far = middle + _NEAREST * deviation, middle + b * deviation
        if formula == "envelope":  # each level takes it a while, and Vanmarcke's is close
            at = level_by("vanmarcke", p)
            found = optimize.root_scalar(
                off, (formula, p), "secant", x0=at, x1=at + _CLOSE * deviation, xtol=_SURE * deviation
            )  # fmt: skip
            return float(found.root) if found.converged else math.nan
        if off(near, formula, p) < 0.0:
            raise ValueError(f"probability of {name} must be at most that of a level next to the mean, not {p:g}.")
        return float(optimize.brentq(off, near, far, (formula, p), rtol=1e-12))

    formulas = rates_at(name, both, moments, np.array([middle + 3.0 * deviation]), solved).rate
    found = {formula: [level_by(formula, p) for p in wanted.ravel().tolist()] for formula in formulas}
    shaped = {formula: np.array(own).reshape(wanted.shape) for formula, own in found.items()}
    return LevelsOfProbability(name, wanted, duration, shaped)


def covers(system: System, name: object) -> bool:
    """Whether `exceedance` has the rates of this quantity."""
    try:
        response = linear(system)
        _moments(response, _asked(response.system, name)[0])
    except (NotCoveredError, TypeError, ValueError):
        return False
    return True


def _rates(response: LinearResponse, name: str, given: Any) -> LevelRates:
    place, both = _asked(response.system, name)
    mean, deviation, crossings, bandwidth = _moments(response, place)
    low = 0.0 if both else -LARGEST
    levels = finite_numbers(given, f"levels of {name}", f"level of {name}", low=low, high=LARGEST, open_low=both)
    sides = np.array([levels - mean, levels + mean]) if both else np.abs(levels - mean)[None]
    if not (sides > _LEAST_LEVEL * deviation).all():
        beyond = "beyond the mean on both sides" if both else "off the mean"
        raise ValueError(f"level of {name} must lie {beyond}, {mean:g} m.")
    solved = _envelope_of(response.system, place)
    return rates_at(name, both, (mean, deviation, crossings, bandwidth), levels, solved)


def rates_at(
    name: str, both: bool, moments: tuple[float, float, float, float], levels: Floats, solved: Envelope | None
) -> LevelRates:
    """The rates at levels beyond the mean, from what `_moments` found and the envelope."""
    mean, deviation, crossings, bandwidth = moments
    sides = np.array([levels - mean, levels + mean]) if both else np.abs(levels - mean)[None]
    b = sides / deviation
    rice = crossings * np.exp(-0.5 * b**2)
    even = both and abs(mean) <= _EVEN * deviation
    clumps = math.sqrt((0.5 if even else 2.0) * math.pi) * bandwidth**1.2 * b
    rate = {"rice": rice.sum(axis=0), "vanmarcke": (rice * np.expm1(-clumps) / np.expm1(-0.5 * b**2)).sum(axis=0)}
    rate |= _of_the_envelope(solved, levels, both)
    at_start = 0.5 * special.erfc(b / math.sqrt(2.0)).sum(axis=0)
    return LevelRates(name, levels, np.asarray(at_start), rate, crossings, bandwidth)


def _asked(system: System, name: object, argument: str = "levels") -> tuple[str, bool]:
    """The point or part, and whether both sides count; ``argument`` asks for it."""
    at = system.coordinates
    known = {f"{own}{what}": (own[:-1], what != "x") for own in at.beginnings for what in ("x", "distance")}
    known |= {f"{part}_{what}": (part, what == "distance") for part in at.ends for what in ("elongation", "distance")}
    return known[known_word(name, known, argument, "must be of")]


def _moments(response: LinearResponse, place: str) -> tuple[float, float, float, float]:
    """Mean, standard deviation, rate of upward crossings of the mean, and bandwidth."""
    whole, first = response.spectral_moments((0.0, 1.0), place).values()
    at = response.system.coordinates
    row = at.elongations[place] if place in at.elongations else at.push(place or response.system.points[0])
    found = motions(response.companion, [row])
    assert not isinstance(found, str)
    ((mean, x_square, v_square),) = found
    if not v_square > 0.0:
        raise ValueError("levels are not exceeded: without noise the displacement is at rest.")
    frequency, deviation = math.sqrt(v_square / (x_square - mean**2)), math.sqrt(x_square - mean**2)
    bandwidth = math.sqrt(max(1.0 - (first / whole / frequency) ** 2, 0.0))
    return mean, deviation, frequency / (2.0 * math.pi), bandwidth


def _envelope_of(system: System, place: str) -> Envelope | None:
    """The diffusion of the amplitude, if it covers this system and displacement."""
    if place not in ("", *system.points):
        return None
    try:
        return envelope(system)
    except ValueError:
        return None


def _of_the_envelope(solved: Envelope | None, levels: Floats, both: bool) -> dict[str, Floats]:
    """The rate from the diffusion of the amplitude, if it covers these levels."""
    name = "distance" if both else "x"
    try:
        rates = [] if solved is None else [solved.first_passage(**{name: float(x)}).rates.min() for x in levels.flat]
    except ValueError:
        return {}
    return {"envelope": np.array(rates).reshape(levels.shape)} if rates else {}
