"""Fatigue damage of a stationary Gaussian response, from its spectral density."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from springpot.machine.faults import NotCoveredError, shown
from springpot.problem.basquin import Basquin
from springpot.problem.system import System

ORDERS = (0.0, 0.75, 1.0, 1.5, 2.0, 4.0)
"""Powers of the frequency in the spectral moments that the formulas take."""


@dataclass(frozen=True)
class Fatigue:
    """What a stationary Gaussian response does to a part that obeys Basquin's curve and Miner's sum.

    Parameters
    ----------
    moments : dict
        Spectral moments m_j = int w^j G(w) dw by their order j, of the one-sided density G per rad/s; m_4 is infinite
        under white noise.
    damage : dict
        Damage per hour by each formula: ``"narrow_band"``, ``"alpha_075"``, ``"tovo_benasciutti"``,
        ``"wirsching_light"`` and ``"dirlik"``.  The last two need m_4, and are missing without it.
    """

    moments: Mapping[float, float]
    damage: Mapping[str, float]

    @property
    def crossing_rate(self) -> float:
        """Upward crossings of the mean, in 1/s."""
        return math.sqrt(self.moments[2.0] / self.moments[0.0]) / (2.0 * math.pi)

    @property
    def peak_rate(self) -> float:
        """Maxima, in 1/s; infinite under white noise."""
        return math.sqrt(self.moments[4.0] / self.moments[2.0]) / (2.0 * math.pi)

    @property
    def life(self) -> Mapping[str, float]:
        """Mean time to failure, in h, by each formula."""
        return {name: 1.0 / rate for name, rate in self.damage.items()}


def damage_rates(moments: Mapping[float, float], exponent: float) -> dict[str, float]:
    """The mean of the sum of S^k over all cycles per second, with S the half range of a cycle.

    Parameters
    ----------
    moments : dict
        Spectral moments by their order: 0, 0.75, 1, 1.5, 2 and 4.
    exponent : float
        k of Basquin's curve.

    Returns
    -------
    dict
        As `Fatigue.damage`, of a curve with the constant 1.

    Notes
    -----
    Narrow band: every cycle of the mean has a Rayleigh amplitude; in practice an upper bound.  Wirsching and Light
    (1980), the 0.75 rule and Tovo and Benasciutti's mean of two bounds (2005) multiply it; Dirlik (1985) fits a
    density of ranges to simulations.  Formulas as collected in D. Benasciutti and R. Tovo, "Comparison of spectral
    methods for fatigue analysis of broad-band Gaussian random processes", Probabilistic Engineering Mechanics 21
    (2006).

    Examples
    --------
    Of a narrow band all agree:

    >>> found = damage_rates({j: 2.0 * 1.001**j for j in (0.0, 0.75, 1.0, 1.5, 2.0)} | {4.0: math.inf}, 3.0)
    >>> {name: round(rate, 3) for name, rate in found.items()}
    {'narrow_band': 1.694, 'alpha_075': 1.694, 'tovo_benasciutti': 1.694}
    """
    m0, m075, m1, m15, m2, m4 = (moments[order] for order in ORDERS)
    k, spread = exponent, math.sqrt(m0)
    rayleigh = math.pow(math.sqrt(2.0), k) * math.gamma(1.0 + 0.5 * k)
    narrow = math.sqrt(m2 / m0) / (2.0 * math.pi) * math.pow(spread, k) * rayleigh
    a1, a2 = m1 / math.sqrt(m0 * m2), m2 / math.sqrt(m0 * m4)
    found = {
        "narrow_band": narrow,
        "alpha_075": narrow * m075**2 / (m0 * m15),
        "tovo_benasciutti": narrow * _share_of_cycles(a1, a2, k),
    }
    if not math.isfinite(m4):
        return found
    a, b = 0.926 - 0.033 * k, 1.587 * k - 2.323
    width = math.sqrt(max(1.0 - a2**2, 0.0))
    found["wirsching_light"] = narrow * (a + (1.0 - a) * math.pow(1.0 - width, b))
    found["dirlik"] = (
        math.sqrt(m4 / m2) / (2.0 * math.pi) * math.pow(spread, k) * _dirlik(m1 / m0 * math.sqrt(m2 / m4), a2, k)
    )
    return found


def _share_of_cycles(a1: float, a2: float, k: float) -> float:
    """Of the narrow-band damage: between that of the range count and that of the level crossings."""
    if a1 >= 1.0 - 1e-12:
        return 1.0
    apart = a1 - a2
    share = apart * (1.112 * (1.0 + a1 * a2 - (a1 + a2)) * math.exp(2.11 * a2) + apart) / (a2 - 1.0) ** 2
    return share + (1.0 - share) * math.pow(a2, k - 1.0)


def _dirlik(middle: float, a2: float, k: float) -> float:
    """Mean of S^k over the ranges of Dirlik's density, over the standard deviation to the power k."""
    rayleigh = math.pow(math.sqrt(2.0), k) * math.gamma(1.0 + 0.5 * k)
    d1 = 2.0 * (middle - a2**2) / (1.0 + a2**2)
    if not d1 > 0.0:  # a single frequency
        return rayleigh
    r = (a2 - middle - d1**2) / (1.0 - a2 - d1 + d1**2)
    d2 = (1.0 - a2 - d1 + d1**2) / (1.0 - r)
    d3 = 1.0 - d1 - d2
    q = 1.25 * (a2 - d3 - d2 * r) / d1
    return d1 * math.pow(q, k) * math.gamma(1.0 + k) + rayleigh * (d2 * math.pow(abs(r), k) + d3)


def fatigue(system: System, curve: Basquin, of: str = "") -> Fatigue:
    """Damage of a linear system's stationary response, by Basquin's curve and Miner's sum.

    Parameters
    ----------
    system : System
        A linear one.
    curve : Basquin
    of : str
        What the cycles are of, as in ``rainflow=`` of `springpot.simulate`: ``"x"``, of several masses ``"box_x"`` or
        ``"mount_elongation"`` of a part, or a force or acceleration, ``"mount_force"``, ``"force_on_ground"``,
        ``"acceleration"``; the displacement if left out, of one mass.

    Returns
    -------
    Fatigue

    Raises
    ------
    NotCoveredError
        If the system is not linear, its response is not Gaussian, or a force crosses its mean infinitely often.
    NoStationaryStateError
        If it has no stationary state.
    TypeError, ValueError
        If the curve is none, or there is no such point or part.

    Notes
    -----
    The mean stress is not counted.  No exact formula is known for the ranges of cycles of stationary Gaussian noise.
    At a damping ratio of 0.05 the narrow-band value is 3 to 11 % above a rainflow count for exponents of 3 to 8, and
    the others within 8 %.  With two modes it is 25 to 31 % above, and Dirlik's 4 % below.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    >>> found = fatigue(device, sp.Basquin(3.0))
    >>> round(found.damage["narrow_band"] / 3600.0, 4), round(found.crossing_rate, 4)
    (0.5984, 0.1592)
    """
    from springpot.theory.methods.systems.linear import linear  # slow to import

    if not isinstance(of, str):
        raise TypeError(f"of must be the name of a displacement, force or acceleration, not {shown(of)}.")
    if not isinstance(curve, Basquin):
        raise TypeError(f"curve must be a Basquin curve, such as sp.Basquin(5.0, strength=0.01), not {shown(curve)}.")
    response = linear(system)
    name = "" if of == "x" else of.removesuffix("_x").removesuffix("_elongation")
    moments = response.spectral_moments(ORDERS, name)
    if math.isinf(moments[2.0]):
        raise NotCoveredError(
            f"{of} crosses its mean infinitely often under white noise, so that the formulas of fatigue do not hold: "
            "count its cycles with rainflow= of simulate."
        )
    rates = damage_rates(moments, curve.exponent)
    return Fatigue(moments, {name: curve.damage_per_hour(rate, 1.0) for name, rate in rates.items()})
