"""What samplers are given of a fit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import NotCoveredError

F = np.geomspace(0.1, 10.0, 24)
MODULUS = 3.0 + 2.0 * (2j * np.pi * F) ** 0.4
NOISE = 1.0 + 0.03 * np.random.default_rng(1).standard_normal((2, F.size))
SOLID = sp.System(
    sp.Spring(sp.free("k", 1.0, (0.01, 100.0))),
    sp.Springpot(sp.free("order", 0.5, (0.01, 0.99)), sp.free("C", 1.0, (0.01, 100.0))),
)
MOVING = sp.System(
    sp.Spring(4.0), sp.Dashpot(sp.free("c", 0.5, (0.1, 5.0))), sp.WhiteNoise(sp.free("q", 1.0, (0.1, 9.0)))
)
SPECTRUM = 4.0 * np.pi * sp.theory.linear(MOVING).spectrum(2.0 * np.pi * F)
FITS = [
    (SOLID, sp.MeasuredModuli(F, MODULUS.real * NOISE[0], MODULUS.imag * NOISE[1])),
    (SOLID, sp.MeasuredModuli(F, MODULUS.real * NOISE[0], MODULUS.imag * NOISE[1], relative_error=0.03)),
    (MOVING, sp.MeasuredSpectrum(F, SPECTRUM * NOISE[0], averages=1000)),
    (MOVING, sp.MeasuredRecord(0.1 * np.arange(400), np.random.default_rng(2).standard_normal(400).cumsum() * 0.01 +
                               np.sin(0.2 * np.arange(400)))),
]  # fmt: skip


@pytest.mark.parametrize(("model", "data"), FITS)
def test_the_likelihood_is_that_of_the_criterion(model: Any, data: Any) -> None:
    fit = sp.fit(model, data)
    best = fit.log_likelihood(fit.values)
    numbers = len(fit.names) + ("relative_error" in fit.extras)
    assert -2.0 * best + numbers * math.log(data.size if not isinstance(data, sp.MeasuredModuli) else 2 * F.size) == (
        pytest.approx(fit.bic, abs=1e-6)
    )
    there = np.array([fit.values[name] for name in fit.names])
    assert fit.log_likelihood(there) == best
    assert all(fit.log_likelihood(each) <= best + 1e-6 for each in fit.start_ensemble(20))
    low = {**fit.values, fit.names[0]: fit.bounds[fit.names[0]][0] * 0.999}
    assert fit.log_likelihood(low) == fit.log_prior(low) == -math.inf


def test_the_prior_integrates_to_one() -> None:
    fit = sp.fit(*FITS[0])
    low, high = np.log([*fit.bounds.values()]).T
    u = low + (high - low) * np.random.default_rng(1).random((10, 3))
    for each in np.exp(u):  # over values its density is that of the logarithms, over the values
        assert fit.log_prior(each) == pytest.approx(-np.log(high - low).sum() - np.log(each).sum())


def test_what_is_no_number_of_the_fit_is_said() -> None:
    fit = sp.fit(*FITS[0])
    with pytest.raises(ValueError, match=r"^numbers must be 3, k, order and C"):
        fit.log_likelihood([1.0, 2.0])
    with pytest.raises(ValueError, match=r"^numbers must have a value for each of k, order and C"):
        fit.log_prior({"k": 1.0})
    with pytest.raises(ValueError, match=r"^walkers must be a whole number"):
        fit.start_ensemble(0)


def test_simulated_statistics_have_no_likelihood() -> None:
    model = sp.System(sp.Spring(4.0), sp.Dashpot(0.8), sp.WhiteNoise(sp.free("q", 1.0, (0.1, 9.0))))
    fit = sp.fit(model, sp.MeasuredStatistics(x_mean_square=(0.3125, 0.01), v_mean_square=(1.25, 0.03)), paths=1024)
    with pytest.raises(NotCoveredError, match="a fit to MeasuredStatistics has no likelihood"):
        fit.log_likelihood(fit.values)
