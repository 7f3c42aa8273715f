"""McKean's law (1963) of the return of a free mass to the wall it was thrown from, under white noise of unit intensity.

With v0 = 1 the return speed u has the density (3 / 2 pi) u^(3/2) / (1 + u^3), so E ln u = pi / sqrt(3); this number
makes the collapse at restitutions below exp(-pi / sqrt(3)).  One path in T^(1/4) has not returned after a time T, so a
simulation is compared with the joint law of speed and time on the paths that return before a stated time.
"""

import math

import numpy as np
import pytest
from scipy import integrate, special

from springpot.simulation import simulate

from .problems import oscillator


def density(speed: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Joint density of return speed and time after a start from the wall with speed 1."""
    spread = math.sqrt(2.0 / 3.0) * special.erf(np.sqrt(6.0 * speed / time))
    fading = np.exp(-2.0 * (1.0 - speed + speed**2) / time)
    return np.asarray(3.0 * speed / (math.pi * math.sqrt(2.0) * time**2) * fading * spread)


def returned_before(latest: float) -> tuple[float, float, float]:
    """Probability of a return before ``latest``, and mean and variance of ln u on it."""
    a, b = np.linspace(-14.0, 6.0, 2001), np.linspace(-7.0, math.log(latest), 2001)
    speed, time = np.exp(a)[:, None], np.exp(b)[None, :]
    weights = integrate.simpson(density(speed, time) * speed * time, x=b, axis=1)
    share, first, second = (float(integrate.simpson(weights * a**k, x=a)) for k in range(3))
    return share, first / share, second / share - (first / share) ** 2


def test_the_joint_law_has_mckeans_marginal_whose_mean_logarithm_is_pi_over_root_3() -> None:
    for speed in (0.2, 1.0, 3.0):
        # in 1 / t, where it is an exponential tail times a power
        found = integrate.quad(lambda s, u=speed: float(density(u, 1.0 / s)) / s**2, 0.0, np.inf, epsabs=1e-10)[0]
        assert found == pytest.approx(1.5 / math.pi * speed**1.5 / (1.0 + speed**3), rel=1e-6)
    law = lambda a: 1.5 / math.pi * math.exp(2.5 * a) / (1.0 + math.exp(3.0 * a))  # noqa: E731
    assert integrate.quad(law, -40.0, 80.0, limit=200)[0] == pytest.approx(1.0, rel=1e-9)
    mean = integrate.quad(lambda a: a * law(a), -40.0, 80.0, limit=200)[0]
    assert mean == pytest.approx(math.pi / math.sqrt(3.0), rel=1e-9)


def test_mean_logarithm_of_the_return_speed_is_mckeans() -> None:
    """The same noise with and without the wall: paths part at the first impact, where velocities are u and -u."""
    paths, latest, step = 4096, 4.0, 0.008
    walled, free = (
        simulate(
            oscillator(1.0, 0.0, 1e-4, 1.0, position), paths=paths, duration=latest, step=step, initial_velocity=1.0,
            record=paths,
        ).record
        for position in (0.0, None)
    )  # fmt: skip
    parted = np.abs(walled[:, :, 0] - free[:, :, 0]) > 1e-5  # more than rounding
    first = np.where(parted.any(axis=1), parted.argmax(axis=1), latest / step + 1).astype(int)
    share, mean, variance = returned_before(latest)
    back = np.flatnonzero(first <= round(latest / step))
    assert abs(back.size / paths - share) < 4.0 * math.sqrt(share * (1.0 - share) / paths)
    # a kick between impact and observation is the same in both
    speeds = 0.5 * (walled[back, first[back], 1] - free[back, first[back], 1])
    measured, error = float(np.log(speeds).mean()), math.sqrt(variance / back.size)
    assert error < 0.02
    assert abs(measured - mean) < 4.0 * error, f"before {latest}: {measured} +- {error}, McKean {mean}"
