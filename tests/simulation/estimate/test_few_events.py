"""Events that were seen rarely or never, and walls that are never reached, pressed against or struck all the time."""

import json
import math

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.evidence import comparison, validity
from springpot.evidence.cells import PaperCell
from springpot.explorer.gathering import Gathering
from springpot.simulation.estimate import few_events
from springpot.simulation.estimate.few_events import chance_below, interval
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import error_of_unseen
from springpot.simulation.plan.plan import plan_of
from springpot.theory.walls import about_walls
from tests.simulation.systems import NEARLY_LINEAR, of_many_kinds

SHORT = {"paths": 64, "duration": 8.0, "step": 0.05, "start": "rest", "seed": 1}
TIME = 64 * 4.0  # all windows of SHORT
DAMPED = (sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))


def far_wall(position: float = -5.0) -> sp.Oscillator:
    return sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=sp.Barrier(position, 0.8, free_side="above"))


def between(low: float, high: float) -> sp.System:
    return sp.System(*DAMPED, NEARLY_LINEAR, lower=sp.Barrier(low, 0.8), upper=sp.Barrier(high, 0.8, free_side="below"))


def test_the_interval_is_garwoods() -> None:
    for seen in range(1, few_events.FEW):
        low, high = interval(np.repeat([1.0, 0.0], [seen, 90]), 1.0)
        assert low == pytest.approx(scipy.stats.chi2.ppf(0.025, 2 * seen) / 2, rel=1e-9)
        assert high == pytest.approx(scipy.stats.chi2.ppf(0.975, 2 * seen + 2) / 2, rel=1e-9)


def test_intervals_hold_the_rate_of_rare_events() -> None:
    """Of single impacts at least 95 %; of bursts of three too, where Poisson's law of the impacts would hold fewer."""
    draw, held = np.random.default_rng(3), {1: 0, 3: 0}
    for size in held:
        for _ in range(2000):
            events = size * (draw.random(400) < 0.008)
            low, high = interval(events, 400.0) if np.count_nonzero(events) < few_events.FEW else (0.0, 1.0)
            held[size] += low <= 0.008 * size <= high or not events.any()
    assert all(count >= 0.95 * 2000 for count in held.values())


def test_what_was_not_seen_is_not_certain() -> None:
    bound = error_of_unseen(TIME)
    assert 1.959964 * bound == pytest.approx(3.0 / TIME)
    assert chance_below(3.0 / TIME, bound) == pytest.approx(1.0 - math.exp(-3.0))
    run = sp.simulate(far_wall(), **SHORT)
    assert run["impact_rate"].value == 0.0
    assert run["impact_rate"].error == pytest.approx(bound)
    assert run.to_dict()["impact_rate_se"] == pytest.approx(bound)
    assert float(run.to_xarray()["impact_rate_se"]) == pytest.approx(bound)
    sentence = f"impact_rate is below {3.0 / TIME:.2g} per second with a probability of 95 %: no impact was seen in"
    assert sum(sentence in each for each in run.warnings) == 1
    assert not any("impact" in name for name in sp.simulate(sp.Oscillator(barrier=None), **SHORT))


@pytest.mark.validation  # every day: of two walls each by its name, below
def test_of_each_wall_and_of_what_it_takes() -> None:
    own = {"impact_observables": {"wear": lambda speed: speed**3}, "slowest_counted_impact": 0.1}
    run, bound = sp.simulate(between(-5.0, 5.5), **SHORT, **own), error_of_unseen(TIME)
    rates = ("impact_rate", "lower_impact_rate", "upper_impact_rate", "counted_impact_rate")
    assert {run[name].value for name in rates} == {0.0}
    assert [run[name].error for name in rates] == pytest.approx([bound] * 4)
    for name in ("lower_power", "upper_power", "lower_force_mean", "wear"):
        assert run[name].value == 0.0
        assert math.isnan(run[name].error)
    assert json.loads(json.dumps(run.to_dict()))["lower_power_se"] is None
    assert [name for name in ("lower", "upper") if any(f"{name}_impact_rate is below" in w for w in run.warnings)]
    near = sp.simulate(between(-0.5, 5.5), **SHORT, **own)
    assert near["lower_power"].error > 0.0
    assert near["upper_impact_rate"].error == pytest.approx(bound)
    soft = sp.simulate(of_many_kinds(*DAMPED), **SHORT)
    assert soft["contact_share"].value == 0.0
    assert math.isnan(soft["contact_share"].error)


def test_few_impacts_have_poissons_interval() -> None:
    system = far_wall(-2.6)
    run = sp.simulate(system, **SHORT)
    seen = simulation_of(plan_of(system, **SHORT)).parts.sums(run.path_sums)["impacts", "barrier"]
    assert 0 < seen.sum() < few_events.FEW
    low, high = interval(seen, TIME)
    assert low < run["impact_rate"].value < high
    between = f"barrier_impact_rate is between {low:.2g} and {high:.2g} per s"
    said = [each for each in run.warnings if each.startswith(between)]
    assert len(said) == 1


def test_the_bound_is_in_budgets_maps_studies_and_on_the_page() -> None:
    far = far_wall()
    with_rtol = sp.simulate(far, rtol=0.3, quantities=("v_mean_square",))
    low, high = with_rtol.settings.window
    budget = with_rtol["impact_rate"].budget
    assert with_rtol["impact_rate"].value == 0.0
    assert budget.total == pytest.approx(1.959964 * with_rtol["impact_rate"].error)
    assert budget.total >= 3.0 / (with_rtol.settings.paths * (high - low))
    gap = comparison.compare(far, rtol=0.3, quantities=("v_mean_square",)).gaps("envelope")["impact_rate"]
    assert math.isnan(gap.percent)
    assert abs(gap.standard_errors) < 0.01
    cell = validity.simulate_cell(PaperCell(1.0, 0.5, 0.8, -5.0))
    assert cell["impact_rate"] == 0.0 < cell["impact_rate_se"]
    page = Gathering(simulation_of(plan_of(far, **SHORT)))
    while not page.complete:
        page.grow()
    assert page.estimates()[1]["impact_rate"] == pytest.approx(error_of_unseen(TIME))
    assert any("impact_rate is below" in each for each in page.warnings())


# --- walls ----------------------------------------------------------------------------------------------------------

FAR = "standard deviations of x away from its mean, so no path comes near it"
PRESSED = "is pressed against by the springs all the time"
CHATTER = "times in a natural period: this is chatter"
WALLS = [
    (sp.Barrier(-40.0, 0.8), FAR),
    (sp.Barrier(40.0, 0.8, free_side="below"), FAR),
    (sp.Barrier(30.0, free_side="above"), PRESSED),
    (sp.Barrier(-30.0, free_side="below"), PRESSED),
    (sp.Barrier(2.0, 0.3, free_side="above"), CHATTER),
]


@pytest.mark.parametrize(("wall", "sentence"), WALLS)
def test_a_run_says_what_is_odd_about_a_wall(wall: sp.Barrier, sentence: str) -> None:
    problem = sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=wall)
    run = sp.simulate(problem, **{**SHORT, "step": 0.01})
    said = [each for each in run.warnings if sentence in each]
    assert len(said) == 1
    assert said[0].startswith(f"barrier at {wall.position:g} m is ")
    assert not any("is below" in each for each in run.warnings)


def test_of_two_walls_each_is_said_by_its_name() -> None:
    run = sp.simulate(between(-30.0, -2.0), **{**SHORT, "step": 0.01})
    assert [each.split(" at ")[0] for each in run.warnings if " m is " in each] == ["lower"]
    assert not any("standard deviations" in each for each in sp.simulate(between(-0.5, 0.5), **SHORT).warnings)


@pytest.mark.parametrize(("wall", "sentence"), WALLS[:4])
def test_theory_says_so_too(wall: sp.Barrier, sentence: str) -> None:
    oscillator = sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=wall)
    system = sp.System(
        *DAMPED, sp.PolynomialSpring((0.0, 0.0, 0.01)), stop=sp.Barrier(wall.position, free_side=wall.free_side)
    )
    for problem, name in ((oscillator, "barrier"), (system, "stop")):
        answers, _ = sp.theory.solve_all(problem)
        told = [each for answer in answers.values() for each in answer.warnings if sentence in each]
        assert told
        assert all(each.startswith(f"{name} at ") for each in told)


def test_usual_walls_are_not_spoken_of() -> None:
    for wall in (sp.Barrier(0.0), sp.Barrier(1.0, 0.8, free_side="above"), sp.Barrier(-2.0, 0.8)):
        problem = sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=wall)
        assert not about_walls(problem, 1.0, 1.5, 1.0, {"barrier": 0.5})
        assert not any(" m is " in each for each in sp.theory.envelope(problem).warnings)
