"""Observables, distributions and extremes against exact laws and against the moments of the same run."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.simulation import Distribution, Run, simulate
from tests.simulation.problems import errors_of, oscillator, values_of
from tests.sizes import validation


@pytest.fixture(scope="module")
def watched() -> Run:
    """Order 1, wall at 0, C = Omega = q = 1: x half normal, v normal, impact speed Rayleigh."""
    return simulate(
        oscillator(1.0),
        paths=20_000,
        duration=50.0,
        step=0.04,
        window=(20.0, 50.0),
        observables={"kinetic": lambda t, x, v: 0.5 * v * v, "place": lambda t, x, v: x, "instant": lambda t, x, v: t},
        impact_observables={"dose": lambda speed: speed**2, "hard": lambda speed: 1.0 if speed > 1.0 else 0.0},
        distributions=True,
        start="rest",
    )


def test_observables_equal_the_moments_of_the_same_run(watched: Run) -> None:
    """The moments add up four steps, and their impacts, in single precision, observables all of them in double."""
    values, errors = values_of(watched), errors_of(watched)
    assert values["kinetic"] == pytest.approx(0.5 * values["v_mean_square"], rel=1e-8)
    assert errors["kinetic"] == pytest.approx(0.5 * errors["v_mean_square"], rel=1e-6)
    assert values["place"] == pytest.approx(values["x_mean"], rel=1e-8)
    assert values["instant"] == pytest.approx(35.02, rel=1e-12)  # middle of the steps that end in (20, 50]
    assert values["dose"] == pytest.approx(values["impact_rate"] * values["impact_speed_mean_square"], rel=1e-8)
    assert abs(values["hard"] - math.exp(-1.0) / math.pi) < 4.0 * errors["hard"]
    assert errors["hard"] < 0.005 * values["hard"]


def test_observables_are_in_the_units_of_the_user_and_of_the_right_side() -> None:
    """Omega = 300, q = 1e6, wall above the motion at 2 mm: numbers far from 1, and negative places.

    With a memory in double precision everything is; at an elastic wall v^2 is summed where observers see it.
    """
    problem = sp.Oscillator(300.0, sp.Springpot(1.0, 20.0), sp.Barrier(0.002, 1.0, "below"), sp.WhiteNoise(1e3))
    found = simulate(
        problem,
        paths=500,
        duration=1.0,
        observables={"cube": lambda t, x, v: x * v * v, "place": lambda t, x, v: x, "speed": lambda t, x, v: v * v},
        impact_observables={"first": lambda speed: speed},
        distributions=True,
        start="rest",
        memory_tolerance=1e-8,
    )
    values = values_of(found)
    assert values["place"] == pytest.approx(values["x_mean"], rel=1e-12)
    assert values["place"] < 0.0
    assert values["cube"] < 0.0
    assert values["speed"] == pytest.approx(values["v_mean_square"], rel=1e-12)
    assert values["first"] == pytest.approx(values["impact_rate"] * values["impact_speed_mean"], rel=1e-12)
    assert 0.001999 < found.distributions["x"].edges.max() <= 0.002
    assert found.extremes["x_maximum"].max() <= 0.002
    assert found.extremes["x_minimum"].min() >= found.distributions["x"].edges.min()


LAWS = {"x": "halfnorm", "v": "norm", "amplitude": "rayleigh", "impact_speed": "rayleigh"}  # of scipy.stats


@pytest.mark.parametrize("name", LAWS)
def test_distributions_are_the_exact_ones(watched: Run, name: str) -> None:
    law, found = getattr(scipy.stats, LAWS[name])(scale=math.sqrt(0.5)), watched.distributions[name]
    p = np.array([0.01, 0.1, 0.4, 0.75, 0.9, 0.99, 0.999])
    quantile, error = found.quantile(p)
    assert np.all(np.abs(quantile - law.ppf(p)) < 4.0 * error)
    assert np.all(error < 0.03 * law.std())
    edges, density, its_error = found.density()
    exact = np.diff(law.cdf(edges)) / np.diff(edges)
    gaps = (density - exact) / its_error
    assert np.abs(gaps).max() < 5.0
    assert 0.5 < np.mean(gaps**2) < 2.0  # the errors are what they say, over 50 bins
    assert np.sum(density * np.diff(edges)) == pytest.approx(1.0, abs=3e-4)
    assert 30 < density.size <= 80


def test_extremes_bound_the_distributions(watched: Run) -> None:
    extremes = watched.extremes
    assert extremes["x_maximum"].shape == (20_000,)
    assert np.all(extremes["x_minimum"] >= 0.0)
    # sketches see one step in four: their last bin begins below the largest value of all
    for name, top in (("x", "x_maximum"), ("impact_speed", "impact_speed_largest"), ("v", "v_largest")):
        assert watched.distributions[name].edges[-2] <= extremes[top].max()
        assert watched.distributions[name].quantile(0.999)[0] < extremes[top].max()
    # 1 - exp(-expected number of upcrossings) of a high level by 30 s of a Gaussian linear oscillator |y|
    level = 2.6
    rate = 2.0 * math.exp(-(level**2)) / (2.0 * math.pi)
    expected = 1.0 - math.exp(-30.0 * rate)
    share = np.mean(extremes["x_maximum"] > level)
    assert abs(share - expected) < 0.1 * expected + 4.0 * math.sqrt(expected / 20_000)


def test_the_same_bits_for_any_number_of_threads_and_no_effect_on_the_run() -> None:
    def observed(threads: int, distributions: bool = True) -> Run:
        return simulate(
            oscillator(0.5, restitution=0.8),
            paths=700,
            duration=15.0,
            step=0.02,
            threads=threads,
            distributions=distributions,
            observables={"cube": lambda t, x, v: x**3} if distributions else None,
            start="rest",
        )

    first, *others = (observed(threads) for threads in (1, 2, 3))
    for other in others:
        assert other["cube"].value == first["cube"].value
        for name, sketch in first.distributions.items():
            assert sketch.counts.tobytes() == other.distributions[name].counts.tobytes()
        for name, samples in first.extremes.items():
            assert samples.tobytes() == other.extremes[name].tobytes()
    plain = observed(2, distributions=False)
    assert all(plain[name].value == first[name].value for name in plain.estimates)
    assert not plain.distributions
    assert not plain.extremes


def test_dataset_and_json_hold_quantiles_and_densities(watched: Run) -> None:
    data = watched.to_xarray()
    assert data["x_density"].attrs["units"] == "m-1"
    assert data["v_density"].attrs["units"] == "s m-1"
    assert float((data["x_density"] * data["x_bin_width"]).sum()) == pytest.approx(1.0, abs=3e-4)
    assert data["impact_speed_quantile"].sizes == {"probability": 9}
    assert float(data["kinetic"]) == watched["kinetic"].value
    assert float(data["x_maximum_quantile"].sel(probability=0.5)) == pytest.approx(
        float(np.median(watched.extremes["x_maximum"]))
    )
    numbers = json.loads(json.dumps(watched.to_dict(), allow_nan=False))
    assert numbers["probability"][4] == 0.5
    assert numbers["x_quantile"][4] == pytest.approx(math.sqrt(0.5) * 0.6745, rel=0.01)


@pytest.mark.parametrize(("order", "side"), [validation(0.5, None), (1.0, "below")])
def test_the_spectrum_is_the_exact_one(order: float, side: str | None) -> None:
    """No wall: q / (2 pi) over the squared dynamic stiffness; order 1 with a wall: that of the modulus."""
    problem = sp.Oscillator(2.0, sp.Springpot(order, 0.8), None if side is None else sp.Barrier(free_side="below"))  # type: ignore[arg-type]
    frequency = np.linspace(0.2, 6.4, 32)
    found = simulate(
        problem, paths=4000, duration=320.0, step=0.02, window=(20.0, 320.0), spectrum=frequency, start="rest"
    )
    if side is None:
        exact = 1.0 / (2.0 * np.pi) / np.abs(4.0 - frequency**2 + 0.8 * (1j * frequency) ** order) ** 2
    else:
        lag = np.linspace(0.0, 40.0, 20_001)
        damped = math.sqrt(4.0 - 0.16)
        rho = np.exp(-0.4 * lag) * (np.cos(damped * lag) + 0.4 / damped * np.sin(damped * lag))
        of_modulus = np.sqrt(1.0 - rho**2) + rho * np.arcsin(rho) - 1.0
        waves = np.cos(np.outer(frequency, lag))
        exact = 1.0 / (2 * 0.8 * 4.0) * 2.0 / np.pi * np.trapezoid(waves * of_modulus, lag, axis=1) / np.pi
    gaps = (found.spectra["x"].density - exact) / found.spectra["x"].standard_error
    assert np.all(found.spectra["x"].standard_error < 0.025 * exact)
    assert np.abs(gaps).max() < 4.5
    assert np.mean(gaps**2) < 2.0
    assert found.spectra["x"].resolution == pytest.approx(math.sqrt(4.0 / 3.0) * math.pi / 300.0)
    data = found.to_xarray()
    assert data["x_spectrum"].attrs["units"] == "m2 s rad-1"
    assert data["x_spectrum"].sizes == {"frequency": 32}


@pytest.mark.parametrize("window", [(0.0, 10.0), (3.05, 19.95)])  # the last samples are fewer than are added together
def test_the_spectrum_is_that_of_recorded_paths(window: tuple[float, float]) -> None:
    step, w = 0.05, np.array([1.5, 2.0])
    run = simulate(
        oscillator(), paths=3, duration=20.0, step=step, window=window, spectrum=w, start="rest", record=3,
        record_every=1,
    )  # fmt: skip
    low, high = (round(end / step) for end in window)
    n = np.arange(-(-low // 4) * 4, high, 4)
    taper = np.sin(np.pi * (n + 0.5 - low) / (high - low)) ** 2
    x = run.record[:, n + 1, 0]
    mean = (x @ taper).mean() / taper.sum()
    sums = ((x - mean) * taper) @ np.exp(-1j * np.outer(n, w * step))
    power = (np.abs(sums) ** 2).mean(axis=0) * 4.0 * step / (2.0 * np.pi * (taper**2).sum())
    assert run.spectra["x"].density == pytest.approx(power, rel=1e-10)


def test_the_spectrum_has_the_same_bits_for_any_number_of_threads() -> None:
    one, other = (
        simulate(oscillator(), paths=200, duration=60.0, step=0.05, spectrum=[0.5, 1.0, 2.0], threads=threads)
        for threads in (1, 3)
    )
    assert one.spectra["x"].density.tobytes() == other.spectra["x"].density.tobytes()


def test_a_short_window_blurs_a_peak_as_it_is_said_to() -> None:
    problem = oscillator(1.0, 0.2, position=None)  # a Lorentzian peak of half-width 0.1 at 1 rad/s
    found = simulate(problem, paths=8000, duration=180.0, step=0.05, window=(60.0, 180.0), spectrum=[1.0], start="rest")
    exact = 1.0 / (2.0 * math.pi * 0.2**2)
    lowered = 1.0 - float(found.spectra["x"].density[0]) / exact
    said = (found.spectra["x"].resolution / 0.1) ** 2
    assert abs(lowered - said) < 0.35 * said + 4.0 * float(found.spectra["x"].standard_error[0]) / exact


def test_low_frequencies_alone_are_not_disturbed_by_what_lies_above() -> None:
    """Samples follow the oscillator, not the frequencies asked for: nothing folds back."""
    problem = oscillator(1.0, 0.5, position=None)
    given: dict[str, Any] = {"paths": 4000, "duration": 420.0, "step": 0.05, "window": (20.0, 420.0)}
    alone = simulate(problem, spectrum=[0.05], **given, start="rest").spectra["x"]
    beside = simulate(problem, spectrum=[0.05, 2.5], **given, start="rest").spectra["x"]
    assert alone is not None
    assert beside is not None
    exact = 1.0 / (2.0 * math.pi) / ((1.0 - 0.05**2) ** 2 + (0.5 * 0.05) ** 2)
    for found in (alone, beside):
        assert abs(found.density[0] - exact) < 4.0 * found.standard_error[0]
        assert found.standard_error[0] < 0.02 * exact


def test_only_paths_of_the_run_are_counted() -> None:
    """One path, of the 64 that a block advances: its distribution is that of its own record."""
    found = simulate(
        oscillator(restitution=0.8), paths=1, duration=60.0, step=0.04, record=1, distributions=True, start="rest"
    )
    own = found.record[0, 751:, 0][::4]
    assert found.distributions["x"].size == pytest.approx(own.size, abs=1)
    assert float(found.distributions["x"].quantile(0.5)[0]) == pytest.approx(float(np.median(own)), rel=0.03)
    assert found.distributions["x"].edges[-2] <= found.record[0, :, 0].max()
    assert found.distributions["impact_speed"].size == pytest.approx(found["impact_rate"].value * 30.0, rel=1e-12)
    assert np.isnan(found.distributions["x"].quantile(0.5)[1])
    assert found.to_dict()["x_maximum_quantile_se"] == [None] * 9


@pytest.mark.parametrize(
    ("position", "intensity", "paths"),
    [validation(1.0, 1e-4, 20_000), (1.0, 3e-3, 3000), validation(3.0, 1.0, 20_000), (-2.0, 0.5, 4000)],
)
def test_distributions_near_a_wall_far_from_the_equilibrium(position: float, intensity: float, paths: int) -> None:
    """A preload presses the mass to the wall: bins are counted from there."""
    found = simulate(
        oscillator(1.0, 0.5, 1.0, intensity, position),
        paths=paths,
        duration=40.0,
        step=0.02,
        distributions=True,
        start="rest",
    )
    spread = math.sqrt(intensity)
    law = scipy.stats.truncnorm(position / spread, math.inf, scale=spread)
    p = np.array([0.05, 0.25, 0.5, 0.75, 0.95])
    quantile, error = found.distributions["x"].quantile(p)
    assert np.all(np.abs(quantile - law.ppf(p)) < 4.0 * error)
    assert np.all(error < 0.02 * (law.ppf(p) - position))


def test_an_observable_takes_what_it_captures_as_it_is_now() -> None:
    factor = 1.0
    captured = np.array([1.0])

    def scaled(t: float, x: float, v: float) -> float:
        return factor * captured[0] * x

    def value() -> float:
        return simulate(oscillator(), paths=64, duration=4.0, step=0.04, observables={"scaled": scaled}, start="rest")[
            "scaled"
        ].value

    once = value()
    factor = 2.0
    assert value() == pytest.approx(2.0 * once)
    captured[0] = 3.0
    assert value() == pytest.approx(6.0 * once)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_an_observable_that_raises_is_no_number(capfd: pytest.CaptureFixture[str]) -> None:
    def picky(t: float, x: float, v: float) -> float:
        if x > 0.5:
            raise ValueError("too far")
        return x

    found = simulate(oscillator(), paths=64, duration=8.0, step=0.04, observables={"picky": picky}, start="rest")
    assert math.isnan(found["picky"].value)
    assert any("observable picky is not a finite number" in sentence for sentence in found.warnings)
    assert math.isfinite(found["x_mean"].value)


def test_the_error_of_an_observable_does_not_depend_on_its_origin() -> None:
    found = simulate(
        oscillator(),
        paths=640,
        duration=20.0,
        step=0.05,
        start="stationary",
        observables={"one": lambda t, x, v: 1.0, "v_far": lambda t, x, v: 1000.0 + x, "near": lambda t, x, v: x},
    )
    assert found["one"].error < 1e-12
    assert found["v_far"].error == pytest.approx(found["near"].error, rel=1e-6)


def test_a_window_of_one_step_is_sampled() -> None:
    for begin in (1.9, 1.92, 1.94, 1.96):
        window = (begin, begin + 0.02)
        found = simulate(
            oscillator(), paths=128, duration=2.0, step=0.02, window=window, distributions=True, start="rest"
        )
        assert found.distributions["x"].size == 128.0
        assert np.isfinite(found.extremes["x_maximum"]).all()


def test_the_papers_scheme_shows_how_far_it_goes_behind_the_wall() -> None:
    found = simulate(
        oscillator(), paths=640, duration=40.0, step=0.02, scheme="grunwald", distributions=True, start="rest"
    )
    assert found.distributions["x"].edges[0] < -0.01
    assert float(found.distributions["x"].quantile(0.001)[0]) < 0.0


def test_without_impacts_there_is_no_speed_to_sketch() -> None:
    found = simulate(
        oscillator(0.5, position=None), paths=64, duration=4.0, step=0.02, distributions=True, start="rest"
    )
    speeds = found.distributions["impact_speed"]
    assert speeds.size == 0.0
    assert np.isnan(speeds.quantile([0.5])[0]).all()
    assert speeds.density()[1].size == 0
    assert found.to_dict()["impact_speed_quantile"] == [None] * 9
    assert found.distributions["x"].edges[0] < 0.0


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        *(
            ({"observables": {name: lambda t, x, v: x}}, "the run already has a result of that name")
            for name in ("x_mean", "x_quantile", "time", "settings", "power_se", "v", "x_maximum_quantile")
        ),
        ({"observables": {"lambda": lambda t, x, v: x}}, "must not be .lambda"),
        ({"observables": {1: abs, "b": abs}}, "must be a word"),
        ({"observables": {"root": math.sqrt}}, "wrap it in a lambda"),
        ({"observables": {"power": lambda t, x, v: x.nothing}}, "Unknown attribute 'nothing'"),
        ({"observables": []}, "must be a dict"),
        ({"observables": {"2x": lambda t, x, v: x}}, "must be a word"),
        ({"observables": {"power": 3.0}}, "must be a function of"),
        ({"observables": {"power": lambda t, x: x}}, "Numba can compile"),
        ({"observables": {"power": lambda t, x, v: str(x)}}, "Numba can compile"),
        ({"impact_observables": {"power": lambda t, x, v: x}}, "Numba can compile"),
        ({"observables": [abs]}, "must be a dict"),
        ({"distributions": 1}, "must be True or False"),
        ({"spectrum": 1.0}, "must be a sequence of frequencies"),
        ({"spectrum": []}, "at least one frequency"),
        ({"spectrum": [0.5, -1.0]}, "spectrum frequency must be"),
        ({"spectrum": [50.0]}, "too fast for a step of 0.02 s"),
        ({"spectrum": [0.5]}, "too low for a window of 0.5 s: use a window of at least 25.1 s"),
        ({"spectrum": (w for w in ())}, "at least one frequency"),
        ({"spectrum": [0.5], "rtol": 0.1}, "cannot be given with rtol"),
        ({"distributions": True, "rtol": 0.1}, "cannot be given with rtol"),
        ({"observables": {"a": lambda t, x, v: x}, "impact_observables": {"a": lambda s: s}}, "at once"),
    ],
)
def test_bad_observers_are_refused_in_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        simulate(oscillator(), **({} if "rtol" in given else {"paths": 64, "duration": 1.0, "step": 0.02}), **given)


def test_a_quantile_needs_a_probability() -> None:
    sketch = Distribution("m", "m-1", np.array([0.0, 1.0]), np.array([[1.0]]))
    with pytest.raises(ValueError, match=r"in \[0, 1\]"):
        sketch.quantile(1.5)
    assert np.isnan(sketch.quantile(0.5)[1])  # one batch says nothing about its error


@pytest.mark.parametrize("places", [(0.25, 1.0), (-0.8, -0.2)])
def test_two_walls_on_one_side_of_0_are_the_extremes(places: tuple[float, float]) -> None:
    """An impact may be on either, so only what is seen counts."""
    low, high = places
    walls = sp.Barrier(low, 0.8, free_side="above"), sp.Barrier(high, 0.8, free_side="below")
    run = sp.simulate(
        sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.5), *walls), paths=64, duration=20.0, step=0.02,
        window=(1.0, 20.0), start="rest", initial_position=low, distributions=True,
    )  # fmt: skip
    for name, wall in (("x_minimum", low), ("x_maximum", high)):
        assert (np.abs(run.extremes[name] - wall) < 0.4 * (high - low)).all()
