"""Times of samples: rates of which rounded times are the print, and signals between samples."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.machine.sampling import band_limited, equal_steps, even_times


@pytest.mark.parametrize(
    ("rate", "size", "decimals"),
    [(256.0, 200, 5), (256.0, 4000, 5), (128.0, 20_000, 3), (1000.0 / 3.0, 500, 4), (119.88, 2000, 4), (16384.0, 64, 7),
     (50.0, 40, 2), (44_100.0, 9000, 6), (1.0 / 0.03, 300, 3)],
)  # fmt: skip
def test_rounded_times_have_their_rate(rate: float, size: int, decimals: int) -> None:
    for start in (0.0, 3.0):
        found = equal_steps(np.round(start + np.arange(size) / rate, decimals))
        assert found is not None
        assert found == pytest.approx(start + np.arange(size) / rate, rel=1e-15, abs=1e-15)
    cut = np.floor(np.arange(size) / rate * 10.0**decimals + 1e-6) / 10.0**decimals  # some programs cut digits off
    assert (found := equal_steps(cut)) is not None
    assert found[-1] == pytest.approx((size - 1) / rate, rel=1e-15)


def test_a_rate_that_nobody_chose_is_that_of_least_squares() -> None:
    rate = 119.880123456
    found = equal_steps(np.round(np.arange(5000) / rate, 4))
    assert found is not None
    assert found[-1] == pytest.approx(4999 / rate, abs=0.3e-4)


def test_nine_digits_are_rounding_too() -> None:
    printed = np.array([float(f"{n / 610.0:.9g}") for n in range(1220)])
    assert equal_steps(printed).tolist() == [n / 610.0 for n in range(1220)]  # type: ignore[union-attr]


def test_what_is_no_rounding_is_not_taken_for_it() -> None:
    time = np.round(np.arange(300) / 256.0, 5)
    later = np.where(np.arange(300) < 150, time, time + 0.0005)  # half of a thousandth of a second is lost
    shaken = np.round(time + 2e-4 * np.random.default_rng(1).normal(size=300), 5)
    for uneven in (np.delete(time, 100), later.round(5), np.sort(shaken), np.array([0.0, 1.0, 2.0, 5.0, 6.0])):
        assert even_times(uneven) is None


def test_what_is_even_keeps_its_bits() -> None:
    time = 0.1 * np.arange(64)
    assert even_times(time) is time
    written = np.array([float(f"{n / 100:.2f}") for n in range(1000)])
    assert (equal_steps(written) == written).all()  # type: ignore[operator]


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_signal_goes_through_its_samples(share: float) -> None:
    """Of half of the sampling rate; away from the ends, where the signal ends."""
    at = np.pi * share
    values = np.sin(at * np.arange(300.0) + 0.3)
    dense = band_limited(values, 8)
    assert dense.size == 299 * 8 + 1
    assert (dense[::8] == values).all()
    off = dense - np.sin(at * np.arange(dense.size) / 8.0 + 0.3)
    assert np.abs(off[320:-320]).max() < 2e-4


def test_lines_stay_lines_between_few_points() -> None:
    """Within the error of the window, of the difference of two points."""
    assert band_limited(np.array([1.0, 3.0]), 4) == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0], abs=6e-4)
    assert band_limited(np.arange(7.0), 3) == pytest.approx(np.arange(19.0) / 3.0, abs=3e-4)
