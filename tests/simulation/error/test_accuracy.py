"""The error budget: what was asked for is reached, the parts are there, and the truth lies inside."""

import math

import numpy as np
import pytest

import springpot as sp
from springpot.machine.progress import Clock, Estimate
from springpot.problem.dimensionless import Dimensionless
from springpot.simulation import simulate
from springpot.simulation.error import reach as accuracy
from springpot.simulation.error.budget import combine
from springpot.simulation.error.levels import levels_of
from springpot.simulation.error.reach import reach
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.estimate.slow_impacts import extrapolation_step
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import controlled, standard_error
from springpot.simulation.plan.creep_of_paper import missing_variance
from springpot.simulation.plan.plan import plan_of, shares_missing
from springpot.simulation.plan.schemes import Splitting
from springpot.simulation.plan.struck import slow_impact_order
from springpot.theory.result import MOMENTS
from tests.simulation.problems import oscillator, truncated_gaussian
from tests.sizes import validation


@pytest.mark.parametrize("position", [-0.5, validation(0.0), 0.7])
def test_every_quantity_of_an_exact_problem_lies_inside_its_total_interval(position: float) -> None:
    found = simulate(oscillator(1.0, 0.8, 1.3, 2.0, position), rtol=0.01, quantities=MOMENTS)
    exact = truncated_gaussian(position, 0.8, 1.3, 2.0)
    assert not found.warnings
    for name in MOMENTS:
        budget = found[name].budget
        assert budget.total <= 0.01 * found[name].value
        assert abs(found[name].value - exact[name]) < budget.total, name
        assert budget.standard_error == found[name].error > 0.0
        parts = budget.step_bias, budget.memory_bias, budget.transient
        assert min(parts) >= 0.0
        assert budget.total == pytest.approx(1.959964 * budget.standard_error + sum(parts))


def test_with_memory_it_reaches_what_long_runs_at_a_fine_step_found() -> None:
    found = simulate(oscillator(), rtol=0.01)
    assert not found.warnings
    assert found.settings.start == "stationary"
    assert abs(found["amplitude_mean_square"].value - 2.128) < 0.0085 + found["amplitude_mean_square"].budget.total
    assert found["amplitude_mean_square"].budget.total <= 0.01 * found["amplitude_mean_square"].value
    numbers = found.to_dict()
    for part in ("se", "step_bias", "memory_bias", "transient", "error"):
        assert numbers[f"amplitude_mean_square_{part}"] > 0.0


@pytest.mark.parametrize(("seeds", "least", "least_in_total"), [(20, 15, 17), validation(40, 32, 36)])
def test_intervals_cover_over_seeds(seeds: int, least: int, least_in_total: int) -> None:
    """Standard errors alone hold the truth at their level: of 95 % at least what four standard errors leave."""
    held = held_in_total = 0
    for seed in range(seeds):
        found = simulate(oscillator(1.0), rtol=0.05, seed=seed)
        gap = abs(found["amplitude_mean_square"].value - 1.0)
        held += gap < 1.96 * found["amplitude_mean_square"].error
        held_in_total += gap < found["amplitude_mean_square"].budget.total
    assert held >= least
    assert held_in_total >= least_in_total


def test_the_same_seed_gives_the_same_numbers_for_any_number_of_threads() -> None:
    one, two = (simulate(oscillator(0.6), rtol=0.05, threads=n, seed=5) for n in (1, 2))
    assert one.estimates == two.estimates


def test_what_cannot_be_reached_is_said() -> None:
    found = reach(oscillator(), 0.001, most_path_steps=1e7)
    assert found.shortfall.startswith("amplitude_mean_square is known to ")
    assert "not to the 0.1 % asked for" in found.shortfall
    total, value = found.budgets["amplitude_mean_square"].total, found.values["amplitude_mean_square"]
    assert 0.001 * value < total < 0.03 * value  # it went on as far as it may
    assert found.path_steps <= 1.1e7


def test_what_it_takes_is_said_before_the_work_and_as_it_goes() -> None:
    seen: list[float] = []
    found = simulate(oscillator(0.6), rtol=0.01, progress=seen.append)
    estimates = [each.estimate for each in seen if each.estimate is not None]
    assert all(0.0 <= each <= 1.0 for each in seen)
    assert seen[-1].estimate.path_steps == pytest.approx(found.diagnostics["path_steps"], rel=0.05)
    assert 0.02 < estimates[0].path_steps / found.diagnostics["path_steps"] <= 1.0
    assert all(each.seconds >= 0.0 and each.reason for each in estimates)
    assert found.diagnostics["held_up_by"]


class Enough(Exception):
    """Raised by a progress function that has seen what it wanted to see."""


def test_light_damping_says_what_takes_the_time_before_it_begins() -> None:
    """The first round alone used to take 5e10 path-steps, without a word."""
    seen: list[Estimate] = []

    def watch(done: float) -> None:
        if done.estimate is not None:
            seen.append(done.estimate)
            raise Enough

    with pytest.raises(Enough):
        simulate(oscillator(frequency=1e3), rtol=0.05, progress=watch)
    assert "the damping is light: each path runs for" in seen[0].sentence
    assert "path-steps in all" in seen[0].sentence
    assert seen[0].path_steps < 2e9
    assert seen[0].seconds > 0.0


def test_too_little_time_for_any_result_is_said() -> None:
    with pytest.raises(TimeoutError, match=r"max_time of 1e-06 s is too short for any result: the pilot runs"):
        simulate(oscillator(), rtol=0.05, max_time=1e-6)


class ThreeMeasures(Clock):
    """A clock whose time is over after it has measured three pieces of work: the rehearsal and two rounds."""

    measured = 0

    def measure(self, path_steps: float, seconds: float) -> None:
        super().measure(path_steps, seconds)
        self.measured += 1

    @property
    def left(self) -> float:
        return math.inf if self.measured < 3 else 0.0


def test_max_time_ends_after_a_whole_round_whose_bits_are_those_of_the_same_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(accuracy, "Clock", ThreeMeasures)
    short = reach(oscillator(0.7), 1e-3, max_time=2.0, seed=3)
    assert "max_time of 2 s is over" in short.shortfall
    assert short.shortfall.startswith("amplitude_mean_square is known to ")
    value, budget = short.values["amplitude_mean_square"], short.budgets["amplitude_mean_square"]
    assert 1e-3 * value < budget.total < 0.1 * value
    finer = round(math.log2(Splitting.coarsest_step / short.settings.step)) - 1
    again = levels_of(short.simulation.plan.but(step=Splitting.coarsest_step)).with_step(finer)
    again = again.extended(short.settings.paths - 2 * short.pairs, short.pairs, None)
    estimates = combine(again)
    assert estimates.values == short.values
    assert estimates.errors == short.errors
    assert again.path_steps == short.path_steps


@pytest.mark.validation  # every day: intervals cover over seeds, in this file
def test_a_tighter_tolerance_gives_no_worse_result() -> None:
    """0.0002 used to end at 0.94 %, for the start and the memory stood in its way."""
    most = 5e6
    loose, tight = (reach(oscillator(), rtol, most_path_steps=most) for rtol in (1e-3, 7e-4))
    assert "would take more than" in tight.shortfall
    name = "amplitude_mean_square"
    assert tight.budgets[name].total < 1.2 * loose.budgets[name].total
    assert tight.budgets[name].memory_bias + tight.budgets[name].transient < 2e-4 * tight.values[name]
    assert tight.settings.precision == "float64"


@pytest.mark.validation
def test_a_strong_springpot_needs_no_run_of_many_creep_times() -> None:
    """C = 50: slow displacements are forgotten like a power of the time, and are a small part of <A^2>."""
    strong = oscillator(0.5, 50.0, restitution=0.8)
    found = simulate(strong, rtol=0.05, max_time=300.0)
    assert found.diagnostics["path_steps"] < 1e9  # it was 3e10 for the first round alone
    # with two seeds of six the pilots' start was off by a little more than 1 %, nothing else
    assert {message.name for message in found.warnings} <= {"start_was_off"}
    # the same x(0), other normals, a step half as long and a window that begins twice as late
    begin, step = found.settings.window[0], 0.5 * found.settings.step
    later = simulate(
        strong, seed=2, paths=128, step=step, duration=3.0 * begin, window=(2.0 * begin, 3.0 * begin),
        initial_position=found.settings.initial_position,
    )  # fmt: skip
    assert later["amplitude_mean_square"].error < 0.004 * later["amplitude_mean_square"].value
    gap = abs(found["amplitude_mean_square"].value - later["amplitude_mean_square"].value)
    assert gap < found["amplitude_mean_square"].budget.total + 2.0 * later["amplitude_mean_square"].error


def lacking_of(problem: sp.Oscillator, time: float) -> float:
    return missing_variance(Dimensionless.of(problem), time)


def test_what_a_run_lacks_of_the_variance_is_bounded() -> None:
    """Against the integral of the squared response without a wall, from the spectrum's own long-time run."""
    weak = oscillator(0.3, 5.0, position=None)
    assert lacking_of(weak, 50.0) < lacking_of(weak, 5.0)
    assert lacking_of(oscillator(0.0), 1.0) == lacking_of(oscillator(0.5, 0.0), 1.0) == 0.0
    late = simulate(weak, paths=200_000, duration=2.0, step=0.02, start="stationary")
    free = sp.theory.exact(weak).x_mean_square
    lacking = free - late["x_mean_square_end"].value
    bound = lacking_of(weak, 2.0)
    assert 4.0 * late["x_mean_square_end"].error < 0.3 * bound
    assert 0.3 * bound < lacking < bound


@pytest.mark.parametrize(("order", "most"), [(0.2, 20.0), (0.5, 8.0), (0.6, 1.001), (0.8, 1.001), (0.97, 1.001)])
def test_that_bound_holds_at_all_orders(order: float, most: float) -> None:
    """Against the creep summed from its exponentials, on another grid: at order 0.97 the late power
    alone is tens of times too small."""
    strong, c = oscillator(order, 50.0, position=None), 50.0
    creep = c ** (1.0 / order)
    y = np.linspace(-40.0, 12.0, 3000)
    for time in (0.3 * creep, creep, 3.0 * creep):
        rate = np.exp(y) / time
        phase = c * rate**order * np.exp(1j * np.pi * order)
        weight = rate * (phase.imag / np.abs(1.0 + phase) ** 2) / np.pi
        times = time * np.exp(np.linspace(0.0, 12.0, 400))
        response = np.trapezoid(np.exp(-np.outer(times, rate)) * weight, y, axis=1)
        lacking = float(np.trapezoid(response**2 * times, np.log(times)))
        assert 0.998 * lacking < lacking_of(strong, time) < most * lacking


@pytest.mark.parametrize(("order", "coefficient"), [(0.005, 50.0), (1e-9, 50.0), (0.3, 1e-200), (0.7, 1e-200)])
def test_that_bound_is_a_number_at_extremes(order: float, coefficient: float) -> None:
    extreme = oscillator(order, coefficient, position=None)
    assert 0.0 <= lacking_of(extreme, 1e9) <= lacking_of(extreme, 3.0) < 1e-3


@pytest.mark.parametrize("position", [0.0, -0.5, -1.5])
def test_impacts_across_a_gap_lack_a_larger_share(position: float) -> None:
    """At order 1 the law of x is a Gaussian beyond the wall: with a smaller variance the rate is as it says."""
    problem = oscillator(1.0, 2.0, position=position)
    full, lacking = (truncated_gaussian(position, c, 1.0, 1.0) for c in (2.0, 2.0 / 0.99))
    full_rate, rate = full["impact_rate"], lacking["impact_rate"] * 0.99**-0.5  # the speeds are not slow
    time = math.log(200.0)  # when the bound on the variance that is lacking is a hundredth
    share = shares_missing(plan_of(problem).motion, time, full)["impact_rate"]
    assert abs(rate / full_rate - 1.0) < 1.02 * share < 0.1  # to first order


def test_an_overdamped_displacement_is_awaited() -> None:
    """x forgets its start like exp(-Omega^2 t / C) here, far slower than the energy of the motion."""
    found = simulate(oscillator(1.0, 8.0, position=None), rtol=0.05, quantities=("x_mean_square",))
    budget = found["x_mean_square"].budget
    assert abs(found["x_mean_square"].value - 1.0 / 16.0) < budget.total < 0.05 / 16.0
    assert found.settings.window[0] > 16.0


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_a_wall_that_is_never_struck_has_no_known_rate(restitution: float) -> None:
    """It used to end in a division by zero, or to call a mean speed of no impacts known."""
    far = oscillator(1.0, 2.0, position=-8.0, restitution=restitution)
    for name in ("impact_rate", "impact_speed_mean"):
        found = reach(far, 0.3, quantities=(name,), most_path_steps=2e6)
        assert found.shortfall.startswith(f"{name} is not known at all, not to the 30 % asked for: in ")


def test_without_a_wall_only_what_exists_can_be_asked_for() -> None:
    free = oscillator(position=None)
    found = simulate(free, rtol=0.03, quantities=("x_mean_square", "v_mean_square"))
    assert found["x_mean_square"].value == pytest.approx(0.5318, rel=0.03)
    with pytest.raises(ValueError, match="quantities must be among"):
        simulate(free, rtol=0.03, quantities=("impact_rate",))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rtol": 0.0}, "rtol must be in"),
        ({"rtol": math.nan}, "rtol must be in"),
        ({"rtol": 0.01, "max_time": 0.0}, "max_time must be"),
        ({"max_time": 3.0}, "max_time needs rtol"),
        ({"rtol": 0.01, "paths": 100}, "paths cannot be given with rtol"),
        ({"rtol": 0.01, "start": "rest"}, "start cannot be given with rtol"),
        ({"rtol": 0.01, "quantities": ()}, "quantities must be among"),
        ({"rtol": 0.01, "quantities": ("energy",)}, "quantities must be among"),
        ({"rtol": 0.01, "seed": -1}, "seed must be in"),
    ],
)
def test_bad_requests(given: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate(oscillator(), **given)


def test_a_springpot_that_is_a_spring_behind_a_lossy_wall_has_a_budget() -> None:
    """It used to be refused: without the wall nothing dissipates, but with it there is a stationary state."""
    found = simulate(oscillator(0.0, 0.5, restitution=0.7), rtol=0.2)
    assert not found.warnings


def test_no_stationary_state_no_budget() -> None:
    with pytest.raises(ValueError, match="stationary state"):
        simulate(oscillator(0.0), rtol=0.1)


def test_dataset_holds_the_budget() -> None:
    data = sp.simulate(oscillator(1.0), rtol=0.1, quantities=("x_mean",)).to_xarray()
    assert float(data["x_mean_error"]) <= 0.1 * float(data["x_mean"])
    assert data["x_mean_step_bias"].attrs["units"] == "m"


def test_order_of_slow_impacts() -> None:
    for restitution in (0.2, 0.4, 0.9):
        s = -2.0 * slow_impact_order(restitution)
        assert restitution**s == pytest.approx(2.0 * math.cos(math.pi * (1.0 + s) / 3.0), abs=1e-9)
    assert slow_impact_order(0.163) == 0.0


@pytest.mark.parametrize(
    ("order", "restitution", "position"), [(0.3, 0.7, 0.0), validation(0.5, 1.0, 0.4), (1.0, 0.9, -0.5)]
)
def test_the_energy_balance_has_mean_zero_at_any_step(order: float, restitution: float, position: float) -> None:
    """So it may serve as a control: a bias of the balance would be a bias of everything controlled by it."""
    found = simulate(
        oscillator(order, 1.0, 1.0, 1.0, position, restitution), paths=100_000, duration=30.0, step=0.4, start="rest"
    )
    assert found["energy_residual"].error < 2e-3
    assert abs(found["energy_residual"].value) < 4.0 * found["energy_residual"].error


def test_the_control_takes_out_most_of_the_spread_and_no_mean() -> None:
    problem = oscillator(1.0)
    simulation = simulation_of(
        plan_of(problem, paths=20_000, duration=60.0, step=0.1, window=(20.0, 60.0), start="rest")
    )
    found = samples_of(simulation, simulation.advance().rows)
    raw = found["amplitude_mean_square"][1]
    kept = controlled(raw, found["energy_residual"][1][:, None])
    assert standard_error(kept) < 0.5 * standard_error(raw)
    assert abs(kept.mean() - 1.0) < 4.0 * standard_error(kept)  # the truth is 1 at any step
    assert standard_error(kept) < 0.001


@pytest.mark.parametrize(
    ("restitution", "c", "position", "left"),
    [(0.5, 0.1, -0.5, 0.006), validation(0.65, 0.3, 0.0, 0.006), validation(0.5, 0.3, 1.0, 0.015)],
)
def test_slow_impacts_that_the_steps_miss_are_made_good(
    restitution: float, c: float, position: float, left: float
) -> None:
    """Against the Fokker-Planck equation: what is said holds for 95 of 100 seeds, and they are not all off to one side.

    Of four seeds two may miss it in 1.4 % of all tests, but none by twice as much.
    """
    problem = oscillator(1.0, c, position=position, restitution=restitution)
    exact = sp.theory.fokker_planck(problem)
    runs = [simulate(problem, rtol=0.02, quantities=("impact_rate",), seed=seed) for seed in range(1, 5)]
    for name in ("impact_rate", "impact_speed_mean", "impact_speed_mean_square"):
        wanted = getattr(exact, name)
        off = [found[name].value - wanted for found in runs]
        ratios = sorted(abs(gap) / found[name].budget.total for gap, found in zip(off, runs, strict=True))
        assert ratios[-2] < 1.0
        assert ratios[-1] < 2.0
        assert abs(sum(off)) / len(off) < left * wanted


@pytest.mark.validation  # every day: every quantity of an exact problem, in this file
def test_a_preload_needs_shorter_steps() -> None:
    problem = oscillator(1.0, 0.3, position=1.0, restitution=0.5)
    names = ("amplitude_mean_square", "x_mean", "impact_rate", "impact_speed_mean")
    exact, found = sp.theory.fokker_planck(problem), simulate(problem, rtol=0.008, quantities=names)
    for name in names:
        wanted = getattr(exact, name)
        assert found[name].value == pytest.approx(wanted, abs=4.0 * found[name].error + 0.003 * wanted)
        assert found[name].error < 0.004 * wanted
    for position, restitution in ((1.0, 1.0), (1e-200, 0.5), (0.0, 0.5)):
        other = plan_of(oscillator(1.0, 0.3, position=position, restitution=restitution)).motion.struck
        assert math.isinf(extrapolation_step(other))
