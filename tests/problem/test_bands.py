"""The rms in bands against other integrals, and tables of many lines thinned to few break points."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.problem.bands import middles_of, thinned
from springpot.simulation.lowering.shaping import shape_of
from tests.sizes import validation

G = 9.80665
NAVMAT = sp.SpectralExcitation.from_slopes((20, 80, 350, 2000), (3, 0, -3), 0.04, "g2/Hz", at=100)
OSCILLATOR = sp.System(sp.Spring(100.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0))


def test_bands_are_exact_integrals() -> None:
    found = sp.band_rms(NAVMAT)
    assert found.overall == pytest.approx(NAVMAT.rms, rel=1e-12)
    for low, high, rms in zip(found.low, found.high, found.rms, strict=True):
        corners = [f for f in NAVMAT.frequency if low < f < high]
        area, _ = integrate.quad(NAVMAT.one_sided, low, high, points=corners or None)
        assert rms**2 == pytest.approx(area, rel=1e-6)
    assert (found.low[1:] == found.high[:-1]).all()
    assert (found.low[0], found.high[-1]) == (20.0, 2000.0)
    assert sp.band_rms(NAVMAT, low=100.0, high=200.0, fraction=1).overall ** 2 == pytest.approx(0.04 * G**2 * 100.0)
    half = sp.band_rms(sp.SpectralExcitation((20.0, 2000.0), (2.0, 2.0), scale=0.5))
    assert half.overall == pytest.approx(math.sqrt(1980.0))
    assert str(found).splitlines()[1].split()[0] == "19.953"


def test_middles_are_those_of_the_standard() -> None:
    """IEC 61260-1, base 10: 1000 G^(k/b), for even b 1000 G^((2k+1)/(2b))."""
    assert middles_of(900.0, 1100.0, 1) == pytest.approx([1000.0])
    assert middles_of(990.0, 1300.0, 3) == pytest.approx([1000.0, 1258.9254])
    assert middles_of(1020.0, 1040.0, 12) == pytest.approx([1000.0 * 10 ** (0.3 / 24.0)])


def test_bands_of_responses_and_spectra() -> None:
    device = sp.System(sp.Mass(2.0), sp.Spring(2e5), sp.Dashpot(60.0), NAVMAT)
    response = sp.theory.linear(device)
    found = sp.band_rms(response, "acceleration", low=20.0, high=2000.0)
    assert found.overall**2 == pytest.approx(response.mean_square("acceleration"), rel=1e-3)
    moved = sp.band_rms(response, fraction=1, low=20.0, high=2000.0)
    assert moved.overall**2 == pytest.approx(response.x_mean_square, rel=1e-3)
    assert moved.middle[moved.rms.argmax()] == pytest.approx(63.1, abs=0.1)
    f = np.linspace(1.0, 50.0, 50)
    measured = sp.MeasuredSpectrum(f, 3.0 + 0.0 * f, averages=9)
    assert sp.band_rms(measured).overall == pytest.approx(math.sqrt(3.0 * 49.0))
    assert sp.band_rms((f, 3.0 + 0.0 * f)).overall == pytest.approx(math.sqrt(3.0 * 49.0))
    run = sp.simulate(OSCILLATOR, paths=2000, duration=100.0, spectrum=list(np.linspace(8.0, 12.0, 9)), seed=1)
    exact = sp.band_rms(sp.theory.linear(OSCILLATOR), low=8.0 / (2.0 * math.pi), high=12.0 / (2.0 * math.pi))
    assert sp.band_rms(run.spectra["x"]).overall == pytest.approx(exact.overall, rel=0.05)


@pytest.mark.parametrize(
    ("source", "given", "sentence"),
    [
        (NAVMAT, {"fraction": 0}, "fraction must be a whole number of bands"),
        (NAVMAT, {"low": 10.0}, "low and high must be in the table, from 20 to 2000 Hz"),
        (NAVMAT, {"low": -1.0}, "low must be in"),
        ("x", {}, "source must be a SpectralExcitation"),
        (([1.0, 2.0], [1.0, 0.0]), {}, "frequency must increase from above 0, and density"),
        (([1.0, 2.0], [1.0]), {}, "frequency and density must have the same number"),
        (sp.theory.linear(OSCILLATOR), {}, "low and high must be given"),
    ],
)  # fmt: skip
def test_what_has_no_bands(source: Any, given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=f"^{sentence}"):
        sp.band_rms(source, **given)


def lines_of(step: float, freedom: int, notched: bool, seed: int) -> tuple[Any, Any]:
    """The lines of a controller about a profile, which scatter as estimates of so many degrees of freedom do."""
    f = np.arange(20.0, 2000.0 + 0.5 * step, step)
    exact = np.array([NAVMAT.one_sided(min(each, 2000.0)) for each in f])
    exact *= np.where(notched & (f > 95.0) & (f < 105.0), 0.25, 1.0)
    return f, exact * np.random.default_rng(seed).chisquare(freedom, f.size) / freedom


CASES = [(0.625, 120, False, 0.05), validation(2.5, 120, True, 0.05)]
MORE = [validation(step, freedom, notched, tolerance) for step in (0.625, 1.0, 2.5) for freedom in (60, 120, 240)
        for notched in (False, True) for tolerance in (0.03, 0.05, 0.1)]  # fmt: skip


@pytest.mark.parametrize(("step", "freedom", "notched", "tolerance"), [*CASES, *MORE])
def test_lines_are_thinned_within_the_tolerance(step: float, freedom: int, notched: bool, tolerance: float) -> None:
    """By an integral of its own in each sixth of an octave; and a filter of the simulation follows what is left."""
    f, density = lines_of(step, freedom, notched, seed=1)
    points, values, worst = thinned(f, density, tolerance)
    assert worst <= tolerance
    assert len(points) < 0.12 * len(f) + 10
    fine = np.geomspace(20.0, f[-1], 200_001)
    left = np.exp(np.interp(np.log(fine), np.log(points), np.log(values)))
    own, table = (
        integrate.cumulative_trapezoid(each, fine, initial=0.0) for each in (left, np.interp(fine, f, density))
    )
    assert own[-1] == pytest.approx(table[-1], rel=1e-4)
    for low in np.geomspace(30.0, 1700.0, 200):
        place = np.searchsorted(fine, [low, low * 2.0 ** (1.0 / 6.0)])
        if fine[place[1]] - low > 3.0 * step:
            there = np.diff(own[place])[0] / np.diff(table[place])[0] - 1.0
            assert (
                abs(there) < 2.0 * tolerance
            )  # the bands that are checked are others, at half their width from another
    if tolerance >= 0.05:  # a filter of 24 sections cannot follow lines of 60 degrees of freedom to 0.03
        shape_of(sp.SpectralExcitation(points, values), "noise")
    w = 2.0 * math.pi * 180.0
    device = sp.System(sp.Spring(w**2), sp.Dashpot(0.1 * w), sp.SpectralExcitation(points, values))
    response = 1.0 / (w**2 - (2.0 * math.pi * f) ** 2 + 0.1j * w * 2.0 * math.pi * f)
    right = integrate.trapezoid(np.abs(response) ** 2 * density, f)
    assert sp.theory.linear(device).x_mean_square == pytest.approx(right, rel=tolerance)


def written(folder: Path, f: Any, density: Any) -> Path:
    place = folder / "control.csv"
    rows = "".join(f"{a:g},{b:.6e}\n" for a, b in zip(f, density, strict=True))
    place.write_text(f"frequency_Hz,psd_g2/Hz\n{rows}", encoding="utf-8")
    return place


@pytest.mark.validation  # every day: lines are thinned, above; controllers' files, in files/
def test_a_controllers_file(tmp_path: Path) -> None:
    """3,201 lines from 0 Hz, of which those below 20 Hz are 0."""
    f, density = lines_of(0.625, 120, False, seed=2)
    whole = np.arange(0.0, 2000.1, 0.625)
    place = written(tmp_path, whole, np.concatenate([np.zeros(whole.size - f.size), density / G**2]))
    with pytest.warns(
        sp.FileWarning, match="32 points of 0 at the ends are left out.* thinned to .* tolerance=0 keeps all"
    ):
        noise = sp.SpectralExcitation.from_file(place)
    assert noise.mean_square == pytest.approx(integrate.trapezoid(density, f), rel=1e-5)
    assert len(noise.psd) < 50
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match="at most 1000 points, not 3169: thin the table"):
            sp.SpectralExcitation.from_file(place, tolerance=0.0)
    device = sp.System(sp.Mass(0.5), sp.Spring(1e5), sp.Dashpot(20.0), noise)
    run, exact = sp.simulate(device, paths=512, seed=1), sp.theory.linear(device)
    assert abs(run["x_mean_square"].value - exact.x_mean_square) < 5.0 * run["x_mean_square"].error


def test_few_points_stay_and_a_gap_is_named(tmp_path: Path) -> None:
    points = np.array([10.0, 40.0, 500.0, 2000.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(sp.SpectralExcitation.from_file(written(tmp_path, points, [0.01, 0.04, 0.04, 0.005])).psd) == 4
    f = np.arange(10.0, 500.0)
    with pytest.raises(ValueError, match=r"psd is 0 from .* give the bands on either side as two noises"):
        sp.SpectralExcitation.from_file(written(tmp_path, f, np.where((f > 100.0) & (f < 200.0), 0.0, 0.01)))
    with pytest.raises(ValueError, match="has fewer than two points above 0: a density needs two or more"):
        sp.SpectralExcitation.from_file(written(tmp_path, f, 0.0 * f))
    with pytest.raises(ValueError, match="tolerance must be in"):
        sp.SpectralExcitation.from_file(written(tmp_path, f, 1.0 + 0.0 * f), tolerance=-1.0)
