"""Slow impacts on a lossy wall, by McKean's law of returns, which holds for every oscillator.

A free mass that leaves a wall at speed v0 under white noise returns at a speed u of density
(3 / 2 pi) u^(3/2) v0^(1/2) / (u^3 + v0^3), as tests/simulation/test_mckean.py derives and simulates.  With
restitution below 1 slower and slower impacts follow.
"""

from __future__ import annotations

import math

from springpot.machine.without_scipy import root_between

COLLAPSE_BELOW = math.exp(-math.pi / math.sqrt(3.0))
"""Restitution (0.163) at and below which white noise makes infinitely many impacts in a finite time."""


def slow_impact_power(restitution: float) -> float:
    """The power m: the rate of impacts slower than u is ~ u^m.  r^-m = 2 cos(pi (m - 1) / 3), m between 0 and 2.

    Parameters
    ----------
    restitution : float
        r in (0, 1]; at and below COLLAPSE_BELOW there is no such power, and 0 is returned.

    Examples
    --------
    >>> [round(slow_impact_power(r), 3) for r in (1.0, 0.5, 0.25, 0.1)]
    [2.0, 1.0, 0.25, 0.0]
    """
    if restitution <= COLLAPSE_BELOW:
        return 0.0
    if restitution == 1.0:
        return 2.0
    return root_between(lambda m: restitution**-m - 2.0 * math.cos(math.pi * (m - 1.0) / 3.0), 1e-9, 2.0)
