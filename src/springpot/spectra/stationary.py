"""The vibration response spectrum by theory: rms and largest values of a linear system under stationary noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy import optimize

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.outputs import outputs_of
from springpot.problem.system import System
from springpot.spectra.largest import name_in_results
from springpot.theory.level_crossings import rates_at
from springpot.theory.methods.systems.linear import LinearResponse, linear

FORMULA = "vanmarcke"
_FASTER = 1.07  # crossings of the mean over the natural frequency


def covered(system: System, words: Sequence[str]) -> bool:
    """Whether theory has these outputs of the system.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2, on="ground"))
    >>> covered(device, ["displacement", "acceleration"]), covered(device, ["impact_speed"])
    (True, False)
    """
    try:
        response = linear(system)
        for word in words:
            _moments(response, word)
    except (NotCoveredError, ValueError):
        return False
    return True


def is_doubtful(system: System, word: str, frequency: float) -> bool:
    """Whether Vanmarcke's largest values may be too high: where a band begins, or faster motion is on the resonance.

    Examples
    --------
    >>> import springpot as sp
    >>> band = sp.SpectralExcitation((1.0, 40.0), (1.0, 1.0))
    >>> def device(f):
    ...     return sp.System(sp.Spring((6.283 * f) ** 2), sp.Dashpot(0.6283 * f), band)
    >>> is_doubtful(device(1.1), "displacement", 1.1), is_doubtful(device(10.0), "displacement", 10.0)
    (True, False)
    """
    response = linear(system)
    _, _, crossings, bandwidth = _moments(response, word)
    begins = (part.frequency[0] for part in system.densities.values())
    return crossings > _FASTER * frequency or any(abs(f / frequency - 1.0) < bandwidth for f in begins)


def rms_and_quantiles(
    system: System, word: str, duration: float, shares: Sequence[float]
) -> tuple[float, Floats]:  # fmt: skip
    """The rms of an output about its mean, and quantiles of its largest size in a time, by Vanmarcke's formula.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2))
    >>> rms, largest = rms_and_quantiles(device, "displacement", 600.0, [0.5])
    >>> round(rms, 6), (largest / rms).round(2).tolist()
    (1.0, [3.15])
    """
    moments = mean, deviation, crossings, _ = _moments(linear(system), word)
    most = deviation * (math.sqrt(2.0 * math.log(max(2.0 * crossings * duration, 1.0) / 1e-9)) + 1.0)
    least = abs(mean) + 1e-6 * deviation

    def below(level: float, share: float) -> float:
        found = rates_at(word, True, moments, np.array([level]), None).probability(duration)
        return 1.0 - float(found[FORMULA][0]) - share

    levels = [
        least if below(least, share) > 0.0 else optimize.brentq(below, least, abs(mean) + most, (share,), rtol=1e-10)
        for share in shares
    ]
    return deviation, np.array(levels)


def _moments(response: LinearResponse, word: str) -> tuple[float, float, float, float]:
    """Mean, standard deviation, rate of upward crossings of the mean, and bandwidth.

    Where a force or an acceleration changes at an infinite rate, as that of a dashpot under white noise, its peaks are
    counted as those of the displacement.
    """
    name, at = name_in_results(word), response.system.coordinates
    known, slow = {**at.elongations, **at.called}, False
    if name in outputs_of(response.system):
        of, place = name, name.removesuffix("force").removesuffix("acceleration").removesuffix("_")
    else:
        slow = name in ("v", *(f"{point}_v" for point in at.called))
        of = place = name.removesuffix("_elongation").removesuffix("v" if slow else "x").removesuffix("_")
    orders = (2.0, 3.0, 4.0) if slow else (0.0, 1.0, 2.0)
    moments = response.spectral_moments(orders, of)
    whole, first, second = (moments[order] for order in orders)
    deviation = math.sqrt(whole)
    if not math.isfinite(deviation):
        raise NotCoveredError(f"{word} has no finite mean square.")
    if not math.isfinite(second):
        if place not in known:
            raise NotCoveredError(f"{word} changes at an infinite rate.")
        whole, first, second = response.spectral_moments((0.0, 1.0, 2.0), place).values()
    mean, frequency = 0.0 if slow else response.mean(of), math.sqrt(second / whole)
    return mean, deviation, frequency / (2.0 * math.pi), math.sqrt(max(1.0 - (first / whole / frequency) ** 2, 0.0))
