"""What a run of several masses watches: against exact laws, and the moments and records of the same run."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.simulation import Run
from springpot.simulation.monte_carlo import simulated
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

ENDS = ("ground", "a"), ("a", "b"), ("ground", "b")
MASSES = sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b")
LINEAR = (
    *MASSES, *(sp.Spring(k, between=e) for k, e in zip((2.0, 1.0, 0.5), ENDS, strict=True)),
    *(sp.Dashpot(c, between=e) for c, e in zip((0.4, 0.3, 0.3), ENDS, strict=True)),
)  # fmt: skip
P = np.array([0.01, 0.1, 0.4, 0.75, 0.9, 0.99])


def off(distribution: Any, law: Any) -> float:
    """The largest deviation of a quantile, in standard errors; they are small."""
    at, error = distribution.quantile(P)
    assert np.all(error < 0.04 * law.std())
    return float(np.abs((at - law.ppf(P)) / error).max())


# --- against exact laws ---------------------------------------------------------------------------------------------

DRIVEN = sp.System(
    *LINEAR, sp.WhiteNoise(0.6, on="a"), sp.WhiteNoise(0.3, on="b"), leg=sp.Spring(1e-9, between=ENDS[1])
)
FREQUENCIES = np.array([0.3, 0.8, 1.3, 1.8, 2.4])


@pytest.fixture(scope="module")
def driven() -> Run:
    return simulated(
        DRIVEN, paths=1280, duration=300.0, window=(40.0, 300.0), step=0.04, distributions=True, spectrum=FREQUENCIES,
        observables={
            "product": lambda b_x, a_x: a_x * b_x, "square": lambda leg_elongation: leg_elongation**2,
            "power": lambda t, a_v: (1.0 if t > 40.0 else 2.0) * a_v**2,
        },
    )  # fmt: skip


@pytest.mark.parametrize("name", ["a_x", "b_x", "a_v", "b_v", "a_b_elongation"])
def test_a_linear_motion_is_gaussian(driven: Run, name: str) -> None:
    square = sp.theory.linear(DRIVEN).moments[f"{name}_mean_square"]
    assert off(driven.distributions[name], scipy.stats.norm(scale=math.sqrt(square))) < 4.0
    edges, density, _ = driven.distributions[name].density()
    assert np.sum(density * np.diff(edges)) == pytest.approx(1.0, abs=3e-4)


@pytest.mark.parametrize(("name", "of"), [("a_x", "a"), ("b_x", "b"), ("a_b_elongation", "leg")])
def test_spectra_are_those_of_the_linear_theory(driven: Run, name: str, of: str) -> None:
    found, exact = driven.spectra[name], sp.theory.linear(DRIVEN).spectrum(FREQUENCIES, of=of)
    assert np.all(found.standard_error < 0.05 * exact)
    assert np.abs((found.density - exact) / found.standard_error).max() < 4.0


def test_an_observable_names_what_it_takes(driven: Run) -> None:
    exact = sp.theory.linear(DRIVEN).covariance()[0, 1]
    assert abs(driven["product"].value - exact) < 4.0 * driven["product"].error < 0.1 * abs(exact)
    assert driven["square"].value == pytest.approx(driven["a_b_elongation_mean_square"].value, rel=1e-5)
    assert driven["power"].value == pytest.approx(
        driven["a_v_mean_square"].value, rel=0.01
    )  # of the drift, not the kick
    assert driven.units["product"] == ""


HOT = 0.6
THERMAL = sp.System(*LINEAR, sp.ThermalNoise(HOT), gap=sp.Barrier(-0.3, 1.0, between=ENDS[1]))


@pytest.fixture(scope="module")
def thermal() -> Run:
    return simulated(
        THERMAL, paths=1280, duration=100.0, window=(0.0, 100.0), distributions=True, slowest_counted_impact=1.0,
        impact_observables={"all": lambda speed: 1.0, "sum": lambda gap_impact_speed: gap_impact_speed},
    )  # fmt: skip


def test_an_elongation_before_a_wall_has_boltzmanns_density(thermal: Run) -> None:
    """Normal but for the wall; closing speeds are those of a flux."""
    stiffness = np.array([[3.0, -1.0], [-1.0, 1.5]])
    spread = math.sqrt(HOT * np.array([-1.0, 1.0]) @ np.linalg.solve(stiffness, [-1.0, 1.0]))
    law = scipy.stats.truncnorm(-0.3 / spread, math.inf, scale=spread)
    assert off(thermal.distributions["a_b_elongation"], law) < 4.0
    assert off(thermal.distributions["gap_impact_speed"], scipy.stats.rayleigh(scale=math.sqrt(HOT * 3.0))) < 4.0
    edges, density, error = thermal.distributions["a_b_elongation"].density()
    exact = np.diff(law.cdf(edges)) / np.diff(edges)
    assert thermal.distributions["a_b_elongation"].edges[0] == pytest.approx(-0.3, abs=1e-4)
    assert np.abs((density - exact) / error).max() < 5.0


def test_impacts_are_seen_by_wall_and_by_speed(thermal: Run) -> None:
    rate, speed = thermal["gap_impact_rate"], thermal["gap_impact_speed_mean"]
    assert thermal["all"].value == pytest.approx(rate.value, rel=1e-9)
    assert thermal["all"].error == pytest.approx(rate.error, rel=1e-6)
    assert thermal["sum"].value == pytest.approx(rate.value * speed.value, rel=1e-9)
    fast = thermal["gap_counted_impact_rate"]
    exact = rate.value * math.exp(-0.5 / (3.0 * HOT))
    assert abs(fast.value - exact) < 4.0 * fast.error < 0.03 * exact
    assert (fast.value, fast.unit) == (thermal["counted_impact_rate"].value, "s-1")
    extremes = thermal.extremes
    assert {"a_x_minimum", "b_v_largest", "a_b_elongation_maximum", "gap_impact_speed_largest"} <= extremes.keys()
    struck = np.isfinite(extremes["gap_impact_speed_largest"])
    assert np.allclose(extremes["a_b_elongation_minimum"][struck], -0.3, atol=1e-6)
    assert np.all(extremes["a_b_elongation_minimum"][~struck] > -0.3)


def test_results_are_in_datasets_files_and_pictures(thermal: Run, driven: Run, tmp_path: Path) -> None:
    data = thermal.to_xarray()
    assert data["a_b_elongation_density"].attrs["units"] == "m-1"
    assert data["gap_impact_speed_quantile"].attrs["units"] == data["b_v_largest_quantile"].attrs["units"] == "m s-1"
    assert float(data["barrier_counted_impact_rate"].sel(barrier="gap")) == thermal["counted_impact_rate"].value
    again = sp.load_run(thermal.save(tmp_path / "run.nc"))
    assert again.estimates == thermal.estimates
    assert again.distributions["a_x"].counts.tobytes() == thermal.distributions["a_x"].counts.tobytes()
    few = simulated(THERMAL, paths=2, duration=1.0, record=2)
    few.save(tmp_path / "few.csv")
    first, _, last = (tmp_path / "few_paths.csv").read_text(encoding="utf-8").strip().partition("\n")
    assert first.split(",")[:3] == ["time (s)", '"x of a', ' path 0 (m)"']
    assert [float(each) for each in last.split("\n")[-1].split(",")[1:]] == few.record[:, -1].ravel().tolist()
    words = json.loads(driven.save(tmp_path / "run.json").read_text(encoding="utf-8"))
    assert words["b_x_spectrum"] == driven.spectra["b_x"].density.tolist()
    assert words["a_b_elongation_quantile"][4] == float(driven.distributions["a_b_elongation"].quantile(0.5)[0])
    with pytest.raises(ValueError, match="distributions"):
        sp.extend(thermal, paths=2000)
    for quantity, of, name in (("v", "b", "b_v"), ("x", "gap", "a_b_elongation"), ("impact_speed", "gap", "")):
        axes = sp.figures.plot_density(thermal, quantity, of=of)
        assert axes.get_xlabel().startswith((name or "gap_impact_speed").replace("_", " "))
    axes = sp.figures.plot_spectrum(driven, theory=sp.theory.linear(DRIVEN), of="leg")
    assert np.array_equal(axes.lines[-1].get_ydata(), sp.theory.linear(DRIVEN).spectrum(FREQUENCIES, of="leg"))
    with pytest.raises(ValueError, match=r"of must be one of a, b, spring_1, .* where there are several masses"):
        sp.figures.plot_density(thermal)
    with pytest.raises(ValueError, match="data holds no v of gap"):
        sp.figures.plot_density(thermal, "v", of="gap")


# --- against records ------------------------------------------------------------------------------------------------


def passed(values: np.ndarray, time: np.ndarray, level: float) -> np.ndarray:
    """When each path is first seen beyond a level."""
    beyond = values >= level
    return np.where(beyond.any(axis=1), time[np.argmax(beyond, axis=1)], np.inf)


@pytest.mark.parametrize("restitution", [1.0, 0.4])
def test_first_passages_are_those_of_the_record(restitution: float) -> None:
    """Those that are seen at the ends of steps; between two of them there are few more."""
    walls = {
        "gap": sp.Barrier(-0.3, restitution, between=ENDS[1]),
        "roof": sp.Barrier(0.8, between=ENDS[2], free_side="below"),
    }
    system = sp.System(*LINEAR, sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.5, on="b"), **walls)
    run = simulated(
        system, paths=640, duration=12.0, step=0.04, record=640, distributions=True, start="rest",
        first_passage={
            "a_x": -0.7, "gap_elongation": 0.6, "a_b_distance": 0.6, "gap_distance": {"level": 0.5, "reference": 0.1},
            "a_speed": 1.0, "a_b_elongation": -0.3, "roof_elongation": 0.8, "b_x": 0.8,
        },
    )  # fmt: skip
    x, v = run.record[..., 0], run.record[..., 1]
    u = x[..., 1] - x[..., 0]
    seen = {
        "a_x": (-x[..., 0], 0.7), "gap_elongation": (u, 0.6), "a_b_distance": (np.abs(u), 0.6),
        "gap_distance": (np.abs(u - 0.1), 0.5),
    }  # fmt: skip
    for name, (values, level) in seen.items():
        times, at_ends = run.first_passages[name].times, passed(values, run.time, level)
        assert np.all(times <= at_ends)
        there = np.isfinite(times)
        assert np.mean(there) > 0.2
        assert np.mean(at_ends[there] - times[there] > 0.04 * (1.0 + 1e-9)) < 0.06
    speeds = passed(np.abs(v[..., 0]), run.time, 1.0)  # lowered level: noise exceeds it between the ends
    assert np.all(run.first_passages["a_speed"].times <= speeds)
    for name, wall in (("a_b_elongation", "gap"), ("roof_elongation", "roof"), ("b_x", "roof")):  # an impact is one
        struck = sums_of(run)["impacts", wall] > 0.0
        in_window = np.isfinite(run.first_passages[name].times)
        assert struck.any()
        assert np.array_equal(in_window, struck)


def sums_of(run: Run) -> dict[Any, Any]:
    from springpot.simulation.paths.simulation import simulation_of
    from springpot.simulation.plan.motions import motion_of
    from springpot.simulation.plan.plan import Plan

    return simulation_of(Plan(motion_of(run.system), run.settings)).parts.sums(run.path_sums)


def test_observers_change_nothing_and_have_the_same_bits_for_any_number_of_threads() -> None:
    given: dict[str, Any] = {"paths": 300, "duration": 12.0, "step": 0.05, "window": (2.0, 12.0)}
    watching: dict[str, Any] = {
        "distributions": True,
        "spectrum": [1.5],
        "first_passage": {"a_b_elongation": [0.4, (-0.05, 0.3), 0.2]},
    }
    system = sp.System(*LINEAR, sp.WhiteNoise(1.0, on="a"), gap=sp.Barrier(-0.1, 0.7, between=ENDS[1]))
    plain = simulated(system, **given, first_passage={"a_b_elongation": 0.4})
    one, other = (simulated(system, **given, **watching, threads=threads) for threads in (1, 2))
    assert all(plain[name] == one[name] for name in plain.estimates)
    assert one.spectra["b_x"].density.tobytes() == other.spectra["b_x"].density.tobytes()
    for name in one.distributions:
        assert one.distributions[name].counts.tobytes() == other.distributions[name].counts.tobytes()
    own, same = (run.first_passages["a_b_elongation"] for run in (one, other))
    assert [each.times.tobytes() for each in own] == [each.times.tobytes() for each in same]
    assert own[0].times.tobytes() == plain.first_passages["a_b_elongation"].times.tobytes()
    assert own[1].restricted_mean[0] < own[0].restricted_mean[0]


def test_touches_of_contacts_are_seen() -> None:
    system = sp.System(
        *LINEAR, sp.WhiteNoise(1.0, on="a"), gap=sp.Contact(-0.2, 50.0, between=ENDS[1]),
        floor=sp.Barrier(-0.3, between=ENDS[0]), roof=sp.Contact(0.4, 50.0, between=ENDS[0], free_side="below"),
    )  # fmt: skip
    stops = "gap", "floor", "roof"
    run = simulated(
        system, paths=64, duration=40.0, step=0.02, distributions=True, slowest_counted_impact=0.0,
        impact_observables={"both": lambda speed: 1.0, "above": lambda roof_impact_speed: 1.0},
    )  # fmt: skip
    rates = {name: run[f"{name}_impact_rate"].value for name in stops}
    assert min(rates.values()) > 0.0
    assert {name: run[f"{name}_counted_impact_rate"].value for name in stops} == pytest.approx(rates)
    assert run["both"].value == pytest.approx(sum(rates.values()))
    assert run["above"].value == pytest.approx(rates["roof"])
    sizes = {name: run.distributions[f"{name}_impact_speed"].size for name in stops}
    assert sizes == pytest.approx({name: rate * 64 * 20.0 for name, rate in rates.items()})


# --- impacts that are not slow --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("noise", "paths"),
    [
        (sp.KanaiTajimiNoise(2.0, 0.5, 0.5, on="ground"), 1280), (sp.ColoredNoise(1.0, 0.5, on="a"), 1280),
        validation(sp.KanaiTajimiNoise(2.0, 0.5, 0.5, on="ground"), 32000),
        validation(sp.ColoredNoise(1.0, 0.5, on="a"), 32000),
    ],
)  # fmt: skip
def test_the_rate_of_impacts_that_are_not_slow_does_not_depend_on_the_step(noise: Any, paths: int) -> None:
    """Under smooth forces that of all is infinite: two buildings come to rest on each other."""
    sides = ("ground", "a"), ("ground", "b")
    buildings = sp.System(
        *MASSES, *(sp.Spring(k, between=e) for k, e in zip((1.0, 2.0), sides, strict=True)),
        *(sp.Dashpot(c, between=e) for c, e in zip((0.1, 0.07), sides, strict=True)), noise,
        gap=sp.Barrier(-0.3, 0.6, between=ENDS[1]),
    )  # fmt: skip
    found = [
        simulated(buildings, paths=paths, duration=200.0, window=(50.0, 200.0), step=step, slowest_counted_impact=0.2)
        for step in (0.1, 0.025)
    ]
    assert math.isnan(found[0]["gap_impact_rate"].value)
    for name in ("gap_counted_impact_rate", "gap_counted_impact_speed_mean"):
        one, other = (run[name] for run in found)
        assert abs(one.value - other.value) < 4.0 * math.hypot(one.error, other.error) < 0.03 * one.value


# --- what is said ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"observables": {"y": lambda a_xx: a_xx}}, "observable 'y' has an argument 'a_xx', which is nothing that can "
         "be seen; did you mean a_x?"),
        ({"observables": {"y": lambda t, x, v: x}}, "observable 'y' has an argument 'x', which is nothing"),
        ({"observables": {"y": lambda: 1.0}}, "observable 'y' must have an argument: "),
        ({"observables": {"a_x_mean": lambda a_x: a_x}}, "the run already has a result of that name"),
        ({"observables": {"gap_counted_impact_rate": lambda a_x: a_x}}, "already has a result of that name"),
        ({"observables": {"y": lambda a_x: "far"}}, "that Numba can compile to a real number"),
        ({"impact_observables": {"y": lambda gap_speed: 1.0}}, "'gap_speed', which is nothing that can be seen; did "
         "you mean gap_impact_speed?"),
        ({"impact_observables": {"y": lambda speed, gap_impact_speed: 1.0}}, "must have one argument: "),
        ({"first_passage": {"x": 1.0}}, "first_passage has 'x', which is nothing that can pass a level"),
        ({"first_passage": {"x": [1.0, 2.0]}}, "first_passage has 'x', which is nothing that can pass a level"),
        ({"first_passage": {"mine": (lambda t, x, v: x, 1.0)}}, "first_passage of 'mine' cannot be of a function of"),
        ({"first_passage": {"gap_elongaton": 1.0}}, "did you mean gap_elongation?"),
        ({"first_passage": {"gap_elongation": -0.4}}, "first_passage level of gap_elongation is -0.4 m, behind a wall: "
         "gap_elongation lies between -0.3 and inf."),
        ({"first_passage": {"a_speed": -1.0}}, "first_passage level of a_speed must be"),
        ({"spectrum": [1e-3]}, "spectrum goes down to 0.001 rad/s, too low for a window"),
    ],
)  # fmt: skip
def test_what_cannot_be_watched_is_said_in_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises((TypeError, ValueError)) as fault:
        sp.simulate(THERMAL, paths=64, duration=5.0, **given)
    assert sentence in str(fault.value)


def test_two_masses_without_a_part_between_them_have_no_elongation() -> None:
    springs = (sp.Spring(1.0, between=("ground", at)) for at in "ab")
    apart = sp.System(*(sp.Mass(1.0, at=at) for at in "ab"), *springs, sp.WhiteNoise(1.0, on="a"))
    for ask in (
        lambda: sp.simulate(apart, paths=1, duration=1.0, start="rest", first_passage={"b_a_elongation": 1.0}),
        lambda: sp.exceedance(apart, {"b_a_distance": 1.0}, duration=1.0, start="rest"),
        lambda: sp.simulate(apart, paths=1, duration=1.0, start="rest", rainflow={"b_a_elongation": sp.Basquin(4.0)}),
    ):
        with pytest.raises(ValueError, match="no part acts between b and a"):
            ask()


def test_a_run_says_that_its_window_begins_at_rest() -> None:
    """Not with a window of one's own."""
    system = sp.System(*LINEAR, sp.WhiteNoise(1.0, on="a"))
    given: dict[str, Any] = {"paths": 16, "duration": 60.0, "step": 0.1, "start": "rest"}
    asked: dict[str, Any] = {"profile": 3, "first_passage": {"a_x": 0.4}}
    begins = "the window is the whole run, because "
    for names in (("profile",), ("profile", "first_passage")):
        run, name = simulated(system, **given, **{n: asked[n] for n in names}), " and ".join(f"{n}=" for n in names)
        (said,) = (warning for warning in run.warnings if "transient" in warning)
        assert said.startswith(f"{begins}{name} begins at rest")
        assert "give window=(30, 60)" in said
        assert run.settings.window == (0.0, 60.0)
    run = simulated(system, **given, **asked, window=(30.0, 60.0))
    assert not any(begins in warning for warning in run.warnings)
