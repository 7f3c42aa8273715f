"""A noise by its spectral density: units, break points and files, and a sentence for every wrong table."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.fitting.spectral_density import response
from springpot.problem.numbers import with_numbers

G = 9.80665
NAVMAT = (20.0, 80.0, 350.0, 2000.0)
FROM = sp.SpectralExcitation.from_psd
SLOPES = sp.SpectralExcitation.from_slopes


def integrated(noise: sp.SpectralExcitation) -> float:
    """The mean square from the density itself, two-sided per rad/s."""
    f = np.geomspace(noise.frequency[0], noise.frequency[-1], 200_001)
    middle = np.sqrt(f[1:] * f[:-1])
    return float(
        sum(
            2.0 * noise.density(2.0 * np.pi * at) * 2.0 * np.pi * df
            for at, df in zip(middle[::20], np.diff(f[::20]), strict=False)
        )
    )


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        (sp.KanaiTajimiNoise, {"frequency": 15.0, "damping": 0.6}),
        (sp.CloughPenzienNoise, {"frequency": 12.0, "damping": 0.6, "base_frequency": 1.2, "base_damping": 0.6}),
        (sp.CloughPenzienNoise, {"frequency": 12.0, "damping": 0.2, "base_frequency": 30.0, "base_damping": 0.4}),
    ],
)
def test_ground_noise_has_the_root_mean_square_that_is_given(kind: Any, numbers: dict[str, float]) -> None:
    """The integral of its density over all frequencies."""
    noise = kind.from_rms(0.1, "g", **numbers)
    places = [(0.0, 3.0), (3.0, 20.0), (20.0, 60.0), (60.0, math.inf)]
    square = 2.0 * sum(integrate.quad(noise.density, low, high, epsabs=0.0)[0] for low, high in places)
    assert math.sqrt(square) / G == pytest.approx(0.1, rel=1e-7)
    assert noise.on == "ground"
    force = kind.from_rms(2.0, "N", on="a", **numbers)
    assert (force.on, force.rms) == ("a", pytest.approx(2.0))
    assert "rms 0.9807 m/s^2 (0.1 g)" in sp.explain(sp.System(sp.Mass(2.0), sp.Spring(1.0), noise))
    lasting = {**numbers, "envelope": sp.ExponentialEnvelope(0.2, 0.6)}
    driven = sp.System(sp.Mass(2.0), sp.Spring(1.0), kind.from_rms(2.0, "N", **lasting))
    assert "rms before the envelope 2 N, modulated by" in sp.explain(driven)


def test_the_root_mean_square_is_that_of_the_test() -> None:
    """A flat band: sqrt(G (f2 - f1)); the NAVMAT profile P-9492 is known as 6.06 g."""
    assert sp.SpectralExcitation.from_psd((10, 2000), 0.02, "g2/Hz").rms == pytest.approx(G * math.sqrt(0.02 * 1990.0))
    navmat = sp.SpectralExcitation.from_slopes(NAVMAT, (3, 0, -3), 0.04, "g2/Hz", at=100)
    assert navmat.rms / G == pytest.approx(6.06, abs=0.01)
    falling = sp.SpectralExcitation((1.0, 4.0), (1.0, 0.25))  # 1 / f: the integral is a logarithm
    assert falling.mean_square == pytest.approx(math.log(4.0), rel=1e-14)
    for noise in (navmat, falling, sp.SpectralExcitation((1.0, 3.0, 4.0), (1.0, 9.0, 2.0), 0.5)):
        assert integrated(noise) == pytest.approx(noise.mean_square, rel=2e-3)


def test_units_and_slopes() -> None:
    table = sp.SpectralExcitation.from_psd((10.0, 40.0), (0.01, 0.04), "g2/Hz")
    assert table.psd == pytest.approx((0.01 * G**2, 0.04 * G**2))
    assert table.on == "ground"
    assert sp.SpectralExcitation.from_psd((10.0, 40.0), (0.005, 0.02), "g2/Hz", sides=2) == table
    turned = sp.SpectralExcitation.from_psd(
        (20.0 * math.pi, 80.0 * math.pi), (0.01 * G**2, 0.04 * G**2), "m2/s4/Hz", frequency_unit="rad/s"
    )
    assert turned.frequency == pytest.approx(table.frequency)
    assert turned.psd == pytest.approx(table.psd)
    assert sp.SpectralExcitation.from_psd((1, 2), (3, 4), "N2/Hz").on == "mass"
    assert sp.SpectralExcitation.from_psd((1, 2), (3, 4), "N2/Hz", on="box").on == "box"
    octave = 10.0 * math.log10(2.0)
    slopes = sp.SpectralExcitation.from_slopes((10.0, 40.0), (octave,), 0.02, "g2/Hz", at=20.0)
    assert slopes.psd == pytest.approx(table.psd)
    assert table.one_sided(20.0) == pytest.approx(0.02 * G**2)
    assert [table.one_sided(f) for f in (9.99, 40.01)] == [0.0, 0.0]
    assert table.white_at(frequency_hz=20.0) == sp.WhiteNoise(table.one_sided(20.0) / 2.0, on="ground")


@pytest.mark.parametrize("frequency_hz", [9.99, 40.01, 40.0 * math.pi])
def test_a_table_is_white_at_its_own_frequencies_only(frequency_hz: float) -> None:
    with pytest.raises(
        ValueError, match=r"^frequency_hz must be in \[10, 40\], not .* It is in Hz, as in the table\.$"
    ):
        sp.SpectralExcitation.from_psd((10.0, 40.0), (1.0, 1.0), "g2/Hz").white_at(frequency_hz=frequency_hz)


def test_a_white_noise_is_the_same_where_the_band_is_wide() -> None:
    """Of a force per unit mass, too: the factors of 2 and of the mass are those of WhiteNoise.from_psd."""
    for unit in ("g2/Hz", "N2/Hz"):
        parts = sp.Mass(0.3), sp.Spring(3000.0), sp.Springpot(0.5, 5.0)
        band = sp.System(*parts, sp.SpectralExcitation.from_psd((1e-3, 1e5), 0.02, unit))
        white = sp.System(*parts, sp.WhiteNoise.from_psd(0.02, unit))
        found, exact = sp.theory.linear(band), sp.theory.linear(white)
        assert found.x_mean_square == pytest.approx(exact.x_mean_square, rel=1e-5)
        assert found.v_mean_square == pytest.approx(exact.v_mean_square, rel=1e-3)
        assert found.spectrum(100.0) == pytest.approx(exact.spectrum(100.0))


@pytest.mark.parametrize("order", [0.25, 0.5, 1.0])
def test_linear_theory_integrates_over_the_table(order: float) -> None:
    """Against sums over a million frequencies; what a fit of spectra takes is the same density."""
    w0, profile = 2.0 * math.pi * 40.0, FROM((10, 40, 500, 2000), (0.01, 0.04, 0.04, 0.005), "g2/Hz", scale=0.5)
    pot = sp.Springpot(order, 0.02 * w0 ** (2.0 - order))
    system = sp.System(sp.Mass(2.0), sp.Spring(2.0 * w0**2), sp.Springpot(order, 2.0 * pot.coefficient), profile)
    found = sp.theory.linear(system)
    edges = np.geomspace(10.0, 2000.0, 1_000_001)
    f, df = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    table = np.exp(np.interp(np.log(f), np.log(profile.frequency), np.log(profile.psd)))
    w = 2.0 * np.pi * f
    density = 0.5 * table / np.abs(w0**2 - w**2 + pot.coefficient * (1j * w) ** order) ** 2
    assert found.x_mean_square == pytest.approx(np.sum(density * df), rel=1e-7)
    assert found.v_mean_square == pytest.approx(np.sum(density * w**2 * df), rel=1e-7)
    some = slice(None, None, 50_000)
    assert response(system, "x")(f[some]) == pytest.approx(density[some], rel=1e-9)


def test_fits_of_records_do_not_cover_it() -> None:
    shaken = sp.System(sp.Spring(1.0), sp.Dashpot(sp.free("c", 0.1, (0.01, 1.0))), FROM((0.1, 1.0), 1.0, "m2/s4/Hz"))
    time = np.arange(400) * 0.1
    with pytest.raises(ValueError, match="spectral_excitation has a density without a short state"):
        sp.fit(shaken, sp.MeasuredRecord(time, np.sin(time)))


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("# from the controller\nfrequency_Hz,psd_g2/Hz\n10,0.01\n40,0.04\n", "g2/Hz"),
        ("psd (g2/Hz);frequency (kHz)\n0.01;0.01\n0.04;0.04\n", "g2/Hz"),
        ("Frequency [Hz];PSD [g²/Hz]\n10;0.01\n40;0.04\n", "g2/Hz"),
        ("frequency_Hz,psd_g^2/Hz\n10,0.01\n40,0.04\n", "g2/Hz"),
        ("frequency_Hz,psd_(m/s^2)^2/Hz\n10,0.01\n40,0.04\n", "m2/s4/Hz"),
        (
            "frequency_rad/s,psd_g2/(rad/s)\n62.83185307179586,0.0015915494309189535\n251.32741228718345,"
            "0.006366197723675814\n",
            "g2/Hz",
        ),
        ("frequency (Hz);PSD [(m/s^2)^2/(rad/s)]\n10;0.0015915494309189535\n40;0.006366197723675814\n", "m2/s4/Hz"),
        ("frequency_rad/s\tdensity_N2/Hz\n62.83185307179586\t0.01\n251.32741228718345\t0.04\n", "N2/Hz"),
    ],
)
def test_a_table_in_a_file(tmp_path: Path, text: str, unit: Any) -> None:
    place = tmp_path / "profile.csv"
    place.write_text(text, encoding="utf-8")
    found, given = sp.SpectralExcitation.from_file(place), sp.SpectralExcitation.from_psd((10, 40), (0.01, 0.04), unit)
    assert found.frequency == pytest.approx(given.frequency)
    assert found.psd == pytest.approx(given.psd, rel=1e-15)
    assert found.on == given.on


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is empty: it needs a header"),
        ("frequency_Hz,psd_g2/Hz\n", "is empty below its header: a density needs two points or more."),
        ("frequency_Hz,psd_g2/Hz,psd_g2/Hz\n1,2,3\n", "must have two columns, one of the frequency and one of the"),
        ("psd_g2/Hz,psd_g2/Hz\n1,2\n", "must have two columns, one of the frequency and one of the density"),
        ("frequency_Hz\n1\n", "must have two columns"),
        ("frequency,psd_g2/Hz\n1,2\n", "line 1: frequency must have its unit, as frequency_hz: columns= states it."),
        ("frequency_Hz,psd_g/Hz\n1,2\n", "N2/(rad/s) or kN2/(rad/s), not 'g/Hz'."),
        ("frequency_Hz,level_dB\n1,2\n", "'level_dB' is not a column"),
        ("frequency_Hz,psd_g2/(rad/min)\n1,2\n", "or kN2/(rad/s), not 'g2/(rad/min)'."),
        ("frequency_Hz,psd_g2/Hz\n1,x\n", "line 2: psd_g2/Hz must be a number, not 'x'."),
        ("frequency_Hz,psd_g2/Hz\n2,1\n1,1\n", "line 3: the frequency must increase from each point to the next"),
        (
            "frequency_Hz,psd_g2/Hz\n1,-13\n2,-10\n",
            "line 2: psd_g2/Hz must be a finite number, 0 or above. It is a density, not a",
        ),
    ],
)
def test_a_wrong_file(tmp_path: Path, text: str, sentence: str) -> None:
    place = tmp_path / "profile.csv"
    place.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"profile\.csv") as caught:
        sp.SpectralExcitation.from_file(place)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (lambda: FROM((2000, 10), 0.02, "g2/Hz"), "frequency must increase from each point to the next, but 10 Hz"),
        (lambda: FROM((10, 10), 0.02, "g2/Hz"), "10 Hz follows 10 Hz: a step must be two points some 3 % apart"),
        (
            lambda: FROM((10, 40), (0.02, 0.0), "g2/Hz"),
            r"psd\[1\] must be in \(0, 1e\+50\], not 0. It is a density, not",
        ),
        (lambda: FROM((0, 40), 0.02, "g2/Hz"), r"frequency\[0\] must be in \(0, .* It is in Hz, above 0 on a log"),
        (lambda: FROM((10, 40), (1, 2, 3), "g2/Hz"), "must have the same number of points, two or more, not 2 and 3"),
        (lambda: FROM((), (), "g2/Hz"), "two or more, not 0 and 0"),
        (lambda: FROM((10,), (1,), "g2/Hz"), "two or more, not 1 and 1"),
        (lambda: FROM((10, 40), (1, 2), "g2/hz"), "psd_unit must be 'g2/Hz' or 'm2/s4/Hz' or 'N2/Hz', not 'g2/hz'"),
        (lambda: FROM((10, 40), (1, 2), "g2/Hz", on="mass"), "on must be left out with a density in g2/Hz"),
        (lambda: FROM((10, 40), (1, 2), "N2/Hz", on="ground"), "on must be a mass with a density in N2/Hz"),
        (lambda: FROM((10, 40), (1, 2), "g2/Hz", frequency_unit="Khz"), "frequency_unit must be 'Hz' or 'kHz' or"),
        (lambda: FROM((10, 40), (1, math.nan), "g2/Hz"), r"psd\[1\] must be"),
        (lambda: FROM("abc", 0.02, "g2/Hz"), "frequency must be a list of numbers, not 'abc'"),
        (lambda: FROM((10, 40), ("a", 2), "g2/Hz"), r"psd\[0\] must be a real number"),
        (lambda: FROM((10, 40), (1, sp.free("s", 0.5, (0.1, 1.0))), "g2/Hz"), "the free number s: mark the scale"),
        (lambda: FROM((10, 40), (1, 2), "g2/Hz", scale=0.0), r"scale must be in \(0"),
        (lambda: FROM(range(1, 1002), 1.0, "g2/Hz"), "at most 1000 points, not 1001: thin the table"),
        (lambda: SLOPES(NAVMAT, (3, 0), 0.04, "g2/Hz", at=100), "slopes must be one for each piece .* 3, not 2"),
        (lambda: SLOPES(NAVMAT, (3, 0, -3), 0.04, "g2/Hz", at=5000), "at must lie between 20 and 2000, not 5000"),
        (lambda: SLOPES(NAVMAT[::-1], (3, 0, -3), 0.04, "g2/Hz", at=100), "frequency must increase"),
        (lambda: SLOPES(NAVMAT, (3, 0, -3), -14.0, "g2/Hz", at=100), "psd must be .* not a level in dB"),
    ],
)
def test_a_wrong_table(made: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        made()


def test_a_level_is_in_decibels_above_the_table(tmp_path: Path) -> None:
    """As the axis `level` of a study: by every way to state a table, in files too."""
    place = tmp_path / "profile.csv"
    place.write_text("frequency_Hz,psd_g2/Hz\n20,0.01\n80,0.04\n", encoding="utf-8")
    table: dict[str, Any] = {"frequency": (20, 80), "psd": (0.01, 0.04), "psd_unit": "g2/Hz"}
    slopes: dict[str, Any] = {"frequency": (20, 80), "slopes": (3,), "psd": 0.01, "psd_unit": "g2/Hz", "at": 20}
    kind = sp.SpectralExcitation
    for found in (
        kind.from_psd(**table, level=12), kind.from_slopes(**slopes, level=12), kind.from_file(place, level=12),
        *(sp.read_system({"parts": [{"kind": "spring", "stiffness": 1.0},
                                    {"kind": "spectral_excitation", "level": 12.0, **each}]}).parts[1]
          for each in (table, slopes)),
    ):  # fmt: skip
        assert found.scale == pytest.approx(10.0**1.2, rel=1e-12)
    system = sp.System(sp.Spring(1.0), shake=kind.from_psd(**table))
    assert with_numbers(system, {"parts.shake.level": 12.0}).parts[1].scale == found.scale
    assert kind.from_psd(**table, level=0.0) == kind.from_psd(**table)
    for more, sentence in (
        ({"level": 3.0, "scale": 2.0}, r"scale must be left out with level"),
        ({"level": 400.0}, r"level must be in \[-300, 300\], not 400. It is in dB above the table"),
        ({"level": sp.free("a", 3.0, (0.0, 6.0))}, "level must be a plain number here, .*: mark the scale instead"),
    ):  # fmt: skip
        for make in (lambda more: kind.from_psd(**table, **more), lambda more: kind.from_file(place, **more)):
            with pytest.raises(ValueError, match=f"^{sentence}"):
                make(more)


def test_in_files_it_may_have_units() -> None:
    def read(**numbers: Any) -> Any:
        return sp.read_system(
            {"parts": [{"kind": "spring", "stiffness": 80.0}, {"kind": "spectral_excitation", **numbers}]}
        )

    flat = FROM((10, 2000), 0.02, "g2/Hz")
    assert read(frequency=[10, 2000], psd=0.02, psd_unit="g2/Hz").parts[1] == flat
    assert read(frequency=[10.0, 2000.0], psd=list(flat.psd)).parts[1] == flat
    steep = read(frequency=[*NAVMAT], slopes=[3, 0, -3], psd=0.04, psd_unit="g2/Hz", at=100.0, scale=0.5).parts[1]
    assert steep == SLOPES(NAVMAT, (3, 0, -3), 0.04, "g2/Hz", at=100.0, scale=0.5)
    free = {"free": "level", "start": 0.5, "low": 0.1, "high": 1.0}
    assert read(frequency=[10, 2000], psd=[0.02, 0.02], psd_unit="g2/Hz", scale=free).parts[1].scale == 0.5
    for numbers, sentence in (
        ({"frequency": [10, 2000], "psd": 0.02, "psd_unit": "g2/Hz", "on": "mass"}, "on must be left out"),
        ({"frequency": [10, 2000], "psd_unit": "g2/Hz"}, "needs psd"),
        ({"frequency": [10, 2000], "slopes": [0.0], "psd": 0.02, "psd_unit": "g2/Hz"}, "needs at"),
        ({"frequency": [10, 2000], "psd": [0.02, 0.02], "unit": "g2/Hz"}, "'unit' is not a key of"),
    ):
        with pytest.raises(ValueError, match=sentence):
            read(**numbers)


def test_a_problem_in_words_says_the_overall_level_and_the_filter() -> None:
    shaken = sp.System(sp.Mass(2.0), sp.Spring(8e3), sp.Dashpot(20.0), shake=FROM((10, 2000), 0.02, "g2/Hz"))
    said = sp.explain(shaken)
    assert "= -2 w(t)" in said
    assert "(shake), 10 to 2000 Hz in 2 points, overall rms 61.87 m/s^2 (6.309 g), acceleration of the ground" in said
    assert "at the resonance, 10.0658 Hz: 0.02 g2/Hz, that of white noise of intensity 0.961704 m^2/s^3" in said
    shake = FROM((10, 2000), 0.02, "g2/Hz")
    rubber = sp.System(sp.Mass(2.0), sp.Spring(7e3), sp.Springpot(0.2, 1e3), shake=shake)  # 9.4 Hz without memory
    assert "density of shake at the resonance, 10.8007 Hz: 0.02 g2/Hz" in sp.explain(rubber)
    below = sp.System(sp.Mass(2.0), sp.Spring(8e2), sp.Dashpot(20.0), shake=shake)
    assert "density of shake at the resonance, 3.1831 Hz: 0, outside its band" in sp.explain(below)
    assert "shake: simulated by a filter of 8 sections whose density is within 0.33 % of it" in said
    pushed = sp.System(*shaken.parts[:3], push=FROM((1, 50), (1, 2), "N2/Hz"))
    assert "overall rms 9.171 N" in sp.explain(pushed)


@pytest.mark.validation  # every day: how near a filter is, above
def test_a_density_that_no_filter_follows_is_said() -> None:
    shaken = sp.System(sp.Mass(2.0), sp.Spring(8e3), sp.Dashpot(20.0), shake=FROM((10, 2000), 0.02, "g2/Hz"))
    rough = np.random.default_rng(1).lognormal(0.0, 0.5, 200)
    ragged = sp.System(*shaken.parts[:3], FROM(np.geomspace(10.0, 2000.0, 200), rough, "g2/Hz"))
    assert "has a density that no filter of 24 sections follows" in sp.explain(ragged)
    with pytest.raises(ValueError, match="Thin the table to the points that matter, as from_file"):
        sp.simulate(ragged, paths=1)
