"""Masses that lie on lossy walls and on each other: forces, powers, one problem in two statements, and hops.

The numbers of systems under smooth noise are from programs of their own that follow rest exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.plan.plan import plan_of
from tests.simulation.systems import AWAY, NEARLY_LINEAR, of_many_kinds
from tests.sizes import validation

DAMPED = sp.Spring(4.0), sp.Dashpot(0.1)
WHITE = sp.WhiteNoise(0.5)
COLORED = sp.ColoredNoise(4.0, 0.5)
NONE = sp.WhiteNoise(0.0)


def preloaded(*parts: Any, place: float = 2.4525, restitution: Any = 0.5) -> sp.System:
    return sp.System(*DAMPED, *parts, floor=sp.Barrier(place, restitution, free_side="above"))


def weighted(*parts: Any, restitution: Any = 0.5) -> sp.System:
    """The same as ``preloaded``, to the last bit of every place: 9.81 / 4 is 2.4525."""
    return sp.System(*DAMPED, *parts, weight=sp.Constant(-9.81), floor=sp.Barrier(0.0, restitution, free_side="above"))


def pressed_by_colored_noise(restitution: float = 0.5) -> sp.System:
    """Of a kind of kernel that other tests have."""
    _, above = AWAY
    return sp.System(
        *DAMPED, NONE, NEARLY_LINEAR, above, COLORED, floor=sp.Barrier(1.0, restitution, free_side="above")
    )  # fmt: skip


def on_a_floor(*parts: Any, restitution: float = 0.5) -> sp.System:
    """A mass with a weight beside one that touches nothing."""
    ends = (sp.Spring(4.0, between=("ground", end)) for end in "ab")
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *ends, sp.Dashpot(0.1, between=("ground", "a")),
        sp.Dashpot(0.1, between=("ground", "b")), *parts,
        floor=sp.Barrier(0.0, restitution, free_side="above", between=("ground", "a")),
    )  # fmt: skip


def pile(*parts: Any) -> sp.System:
    """Two masses on one another on a floor, under their weights."""
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Constant(-9.81, on="a"), sp.Constant(-4.905, on="b"), *parts,
        sp.Dashpot(0.01, between=("ground", "a")), sp.Dashpot(0.01, between=("ground", "b")),
        floor=sp.Barrier(0.0, 0.5, free_side="above", between=("ground", "a")),
        gap=sp.Barrier(0.0, 0.5, free_side="above", between=("a", "b")),
    )  # fmt: skip


def not_balanced(system: sp.System, name: str, sign: float, step: float, start: float, weight: float = 0.0) -> float:
    """What the momentum lacks: the mean force of a wall less what spring, dashpot and weight need, over the force.

    Without noise, from before the first impact to some time at rest.
    """
    run = simulated(system, paths=1, duration=4.0, window=(0.2, 4.0), step=step, initial_position=start, record=1)
    begin, end = run.settings.window
    path = run.record[0, [round(begin / run.settings.step), -1]]
    (x, v), time = path[1] - path[0], end - begin
    wanted = 4.0 * run["x_mean"].value + 0.1 * x / time + v / time - weight
    return float(run[f"{name}_force_mean"].value / (sign * wanted) - 1.0)


@pytest.mark.parametrize("step", [0.02, 0.005])
def test_impacts_and_rest_together_balance_the_momentum(step: float) -> None:
    """The mean of x is that of the observed points, which leaves an error of the order of the step squared."""
    most = 2e-4 * (step / 0.005) ** 2
    assert abs(not_balanced(preloaded(NONE), "floor", 1.0, step, 2.6)) < most
    assert abs(not_balanced(weighted(NONE), "floor", 1.0, step, 0.15, -9.81)) < most
    above = sp.System(*DAMPED, NONE, lid=sp.Barrier(-2.0, 0.5, free_side="below"))
    assert abs(not_balanced(above, "lid", -1.0, step, -2.2)) < most
    lower, upper = AWAY
    slot = sp.System(*DAMPED, NONE, NEARLY_LINEAR, lower, lid=sp.Barrier(-2.0, 0.5, free_side="below"))
    assert abs(not_balanced(slot, "lid", -1.0, step, -2.2)) < most
    slot = sp.System(*DAMPED, NONE, NEARLY_LINEAR, upper, floor=sp.Barrier(2.0, 0.5, free_side="above"))
    assert abs(not_balanced(slot, "floor", 1.0, step, 2.2)) < most


@pytest.mark.validation
@pytest.mark.parametrize("step", [0.02, 0.005])
def test_the_momentum_is_balanced_with_a_law_of_restitution(step: float) -> None:
    law = sp.PowerRestitution(0.5, speed=1.0)
    assert abs(not_balanced(preloaded(NONE, restitution=law), "floor", 1.0, step, 2.6)) < 2e-4 * (step / 0.005) ** 2


@pytest.mark.parametrize("step", [0.01, 0.005])
def test_the_mean_force_of_a_wall_has_the_time_at_rest(step: float) -> None:
    """Noise of 0.2 to 3 Hz is not needed for it: of any smooth noise the mean force is that of the spring."""
    run = simulated(pressed_by_colored_noise(), paths=320, duration=40.0, window=(5.0, 40.0), step=step,
                    initial_position=1.0, seed=2)  # fmt: skip
    force = run["floor_force_mean"]
    assert force.error < 0.01 * force.value
    assert abs(force.value - 4.007) < 3.0 * force.error  # impacts alone gave 2.9
    # and path by path, within what the ends of the window leave
    spring = 4.0 * run["x_mean"].value
    assert abs(force.value - spring) < 3.0 * np.hypot(force.error, 0.002)


@pytest.mark.validation
@pytest.mark.parametrize("step", [None, 0.0025])
def test_the_mean_force_under_a_flat_density(step: float | None) -> None:
    ground = sp.SpectralExcitation.from_psd((0.2, 3.0), 2.0, "m2/s4/Hz")
    for place, force, error in ((1.0, 4.006, 0.001), (2.4525, 9.81, 0.003)):
        shaken = sp.System(sp.Mass(1.0), *DAMPED, ground, floor=sp.Barrier(place, 0.5, free_side="above"))
        given = {} if step is None else {"step": step}
        run = simulated(shaken, paths=300, duration=60.0, window=(10.0, 60.0), initial_position=place, seed=1, **given)
        assert abs(run["floor_force_mean"].value - force) < 3.0 * np.hypot(run["floor_force_mean"].error, error)
    run = sp.simulate(shaken, rtol=0.03, seed=1)
    assert abs(run["floor_force_mean"].value - 9.81) < run["floor_force_mean"].budget.total < 0.3


def test_at_rest_on_a_floor_nothing_is_lost_and_nothing_strikes() -> None:
    for system, start in ((weighted(NONE), 0.1), (preloaded(NONE), 2.5525)):
        run = simulated(system, paths=1, duration=20.0, window=(15.0, 20.0), initial_position=start)
        for name in ("floor_power", "floor_impact_rate", "v_mean_square"):
            assert run[name].value == 0.0
        assert run["floor_force_mean"].value == pytest.approx(9.81, rel=1e-9)


def test_a_weight_above_a_floor_and_a_preload_are_one_problem() -> None:
    """In double precision to rounding, and to what 300 hops in 3 s make of it: a millionth of where it began."""
    given: dict[str, Any] = {"paths": 32, "duration": 3.0, "window": (1.0, 3.0), "record": 32, "start": "rest",
                             "distributions": True, "forces": ["spring_force"], "profile": 2,
                             "memory_tolerance": 1e-9}  # fmt: skip
    one = simulated(preloaded(WHITE), **given, initial_position=2.9525, first_passage={"x": 3.0})
    other = simulated(weighted(WHITE), **given, initial_position=0.5, first_passage={"x": 0.5475})
    assert one.settings.step == other.settings.step
    of_places = ("x_mean", "amplitude", "damping_virial", "spring_force", "acceleration")
    alike = [name for name in one.estimates if not name.startswith(of_places)]
    assert {"floor_power", "floor_force_mean", "input_power", "energy_residual"} <= {*alike}
    for name in alike:
        assert one[name].value == pytest.approx(other[name].value, rel=1e-5, abs=1e-6), name
    moved = other["x_mean"].value + 2.4525
    assert one["x_mean"].value == pytest.approx(moved, abs=1e-8)
    square = other["x_mean_square"].value + 2.4525 * (2.0 * other["x_mean"].value + 2.4525)
    assert one["x_mean_square"].value == pytest.approx(square, abs=1e-7)
    apart = np.abs(one.record[..., 0] - other.record[..., 0] - 2.4525).max(axis=0)
    assert apart[: apart.size // 4].max() < 1e-12
    assert apart.max() < 1e-6
    assert other["spring_force_mean"].value == pytest.approx(one["spring_force_mean"].value - 9.81, abs=1e-6)
    (at, _), (seen, _) = (run.distributions["x"].quantile(0.9) for run in (one, other))
    assert at == pytest.approx(seen + 2.4525, abs=1e-6)
    assert one.extremes["x_maximum"] == pytest.approx(other.extremes["x_maximum"] + 2.4525, abs=1e-6)
    assert one.profiles["x_mean_profile"].value == pytest.approx(
        other.profiles["x_mean_profile"].value + 2.4525, abs=1e-6
    )
    early, later = (run.first_passages["x"].times for run in (one, other))
    assert early == pytest.approx(later, abs=1e-9)


def test_in_single_precision_the_two_have_one_law() -> None:
    given: dict[str, Any] = {"paths": 5120, "duration": 3.0, "window": (1.0, 3.0), "start": "rest"}
    one = simulated(preloaded(WHITE), **given, initial_position=2.9525)
    other = simulated(weighted(WHITE), **given, initial_position=0.5)
    for name in ("v_mean_square", "floor_power", "floor_force_mean", "floor_impact_rate", "floor_impact_speed_mean"):
        error = np.hypot(one[name].error, other[name].error)
        assert abs(one[name].value - other[name].value) < 4.0 * error < 0.06 * one[name].value, name
    moved = one["x_mean"].value - 2.4525 - other["x_mean"].value
    assert abs(moved) < 4.0 * np.hypot(one["x_mean"].error, other["x_mean"].error)


def test_memory_and_rare_levels_do_not_see_the_shift() -> None:
    """Caputo's derivative of a constant is 0; the level of a path is one of x."""
    spring, pot, noise = sp.Spring(4.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0)
    plain = sp.System(spring, pot, noise, stop=sp.Barrier(-0.5, 0.7))
    moved = sp.System(spring, pot, noise, sp.Constant(6.0), stop=sp.Barrier(1.0, 0.7, free_side="above"))  # by 1.5 m
    given: dict[str, Any] = {"paths": 64, "duration": 10.0, "window": (5.0, 10.0), "step": 0.01}
    one, other = (
        simulated(each, **given, start="rest", initial_position=place, memory_tolerance=1e-9)
        for each, place in ((plain, 0.2), (moved, 1.7))
    )
    for name in ("v_mean_square", "stop_impact_rate", "stop_power", "damping_power"):
        assert one[name].value == pytest.approx(other[name].value, rel=1e-6), name
    assert one["x_mean"].value + 1.5 == pytest.approx(other["x_mean"].value, rel=1e-6)
    levels: dict[str, Any] = {"duration": 5.0, "start": "rest", "rtol": 0.3, "seed": 3}
    rare = sp.exceedance(plain, {"x": 1.6}, **levels, initial_position=0.0)
    again = sp.exceedance(moved, {"x": 3.1}, **levels, initial_position=1.5)
    assert again.probability["x"] == pytest.approx(rare.probability["x"], rel=1e-6)
    with pytest.raises(ValueError, match="derivative must be 'caputo': a constant force cannot be part of an Osc"):
        simulated(moved, derivative="riemann-liouville")


@pytest.mark.parametrize(
    ("part", "pressed"),
    [(sp.Force(lambda t, x, v: -2.0), 6.0), (sp.Force(lambda t, x, v: 3.0), 1.0), (sp.Jenkins(0.9, 0.3), 4.3)],
)
def test_forces_that_act_around_the_kick_press_a_mass_on_its_wall(part: Any, pressed: float) -> None:
    """At x = 1, where the spring presses with 4 N; dashpots take a share of what is given before the kick."""
    system = sp.System(*DAMPED, part, sp.Barrier(1.0, 0.5, free_side="above"))
    run = simulated(system, paths=1, duration=20.0, window=(5.0, 20.0), step=0.02, start="rest", initial_position=1.0)
    assert run["barrier_force_mean"].value == pytest.approx(pressed, rel=2e-3)
    assert (run["x_mean"].value, run["v_mean_square"].value) == (1.0, 0.0)


def test_a_force_of_the_user_lets_a_mass_rest_where_no_spring_presses() -> None:
    system = sp.System(*DAMPED, sp.Force(lambda t, x, v: -2.0), sp.Barrier(-0.2, 0.5))
    run = simulated(system, paths=1, duration=20.0, window=(5.0, 20.0), step=0.02, start="rest", initial_position=0.3)
    assert run["barrier_force_mean"].value == pytest.approx(1.2, rel=2e-3)
    assert (run["v_mean_square"].value, run["barrier_power"].value) == (0.0, 0.0)


def test_a_profile_of_power_has_what_masses_lose_as_they_come_to_rest() -> None:
    """To the second order of the step: there the power of a single impact is not that of its restitution."""
    system, apart = sp.System(*DAMPED, COLORED, sp.Barrier(1.0, 0.5, free_side="above")), []
    for step in (0.04, 0.02):
        run = simulated(system, paths=500, duration=60.0, window=(20.0, 60.0), step=step, profile=4, start="rest",
                        initial_position=1.0)  # fmt: skip
        profile = run.profiles["impact_power_profile"].value
        apart.append(abs(profile.mean() / run["barrier_power"].value - 1.0))
    assert apart[1] < 0.005
    assert apart[1] < 0.4 * apart[0]


@pytest.mark.validation
def test_a_contact_moves_with_the_rest_of_the_spring() -> None:
    """Its force and that of the ground are those of the user's places."""
    stop = sp.Contact(0.25, 50.0, free_side="below")
    parts = sp.Spring(4.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
    given: dict[str, Any] = {"paths": 64, "duration": 8.0, "window": (3.0, 8.0), "step": 0.02, "start": "rest",
                             "forces": ["contact_force", "contact_peak_force"]}  # fmt: skip
    plain = simulated(sp.System(*parts, stop), **given, initial_position=0.0)
    moved = simulated(
        sp.System(*parts, sp.Contact(1.25, 50.0, free_side="below"), sp.Constant(4.0)), **given, initial_position=1.0
    )
    for name in ("v_mean_square", "contact_force_mean", "contact_force_mean_square", "contact_peak_force_mean"):
        assert plain[name].value == pytest.approx(moved[name].value, rel=1e-9), name


def test_what_has_a_law_in_x_keeps_the_constant_force_in_the_kick() -> None:
    """There a shift would make another part; the numbers are those of before."""
    spring = sp.PolynomialSpring((4.0, 0.0, 1.0))
    for parts in ((spring,), (sp.Spring(4.0), sp.ParametricNoise(0.1)), (sp.Spring(4.0), sp.VanDerPol(0.1, 1.0))):
        motion = plan_of(sp.System(*parts, sp.Dashpot(0.5), WHITE, sp.Constant(-1.0))).motion
        assert motion.origin == 0.0
    assert plan_of(sp.System(sp.Spring(4.0), sp.Dashpot(0.5), WHITE, sp.Constant(-1.0))).motion.origin == -0.25


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_the_default_step_resolves_the_hops_on_a_pressed_wall(restitution: float) -> None:
    system = weighted(WHITE, restitution=restitution)
    exact = sp.theory.fokker_planck(preloaded(WHITE, restitution=restitution)).v_mean_square
    plan = plan_of(system)
    assert 0.05 < plan.settings.step * 9.81 / exact**0.5 < 0.1
    assert plan.settings.step == plan_of(preloaded(WHITE, restitution=restitution)).settings.step
    # far from a wall that is not pressed the step is as before
    assert plan_of(sp.Oscillator(barrier=sp.Barrier(-0.5, 0.5))).settings.step == pytest.approx(0.01)


def test_hops_of_nearly_plastic_impacts_need_a_finer_step() -> None:
    speed = 0.0457  # measured at r = 0.2
    assert plan_of(preloaded(WHITE, restitution=0.2)).settings.step * 9.81 / speed < 0.03


@pytest.mark.parametrize("finer", [1.0, 0.5])
def test_the_energy_of_hops_is_that_of_the_fokker_planck_equation(finer: float) -> None:
    system = weighted(WHITE)
    step = finer * plan_of(system).settings.step
    run = simulated(system, paths=400, duration=22.0, window=(2.0, 22.0), step=step, start="rest", seed=5)
    v = run["v_mean_square"]
    bias = 0.13 * step * 9.81 / v.value**0.5
    assert v.error < 0.006 * v.value
    assert abs(v.value / (1.0 - bias) - 0.0038977) < 3.0 * v.error
    assert not any(message.name == "coarse_hops" for message in run.warnings)
    force = run["floor_force_mean"]
    assert abs(force.value - 9.811) < 3.0 * force.error


def test_a_step_too_long_for_hops_says_what_it_loses() -> None:
    run = simulated(weighted(WHITE), paths=256, duration=22.0, window=(2.0, 22.0), step=0.005, start="rest", seed=5)
    v = run["v_mean_square"]
    assert v.error < 0.01 * v.value
    (said,) = (message for message in run.warnings if message.name == "coarse_hops")
    low = float(said.split("about ")[1].split(" %")[0]) / 100.0
    assert abs(v.value / (1.0 - low) / 0.0038977 - 1.0) < 0.03
    assert not any("energies are correct" in message for message in run.warnings)
    assert run["floor_power"].value == pytest.approx(0.25, rel=0.02)


NONE_ON_A = sp.WhiteNoise(0.0, on="a")


@pytest.mark.parametrize("step", [0.02, validation(0.01)])
@pytest.mark.parametrize(("restitution", "square", "power"), [(0.5, (0.0062, 0.0003), (0.0148, 0.0005)),
                                                              (0.9, (0.0292, 0.0014), (0.0192, 0.0006)),
                                                              (0.0, (0.0049, 0.0004), (0.0139, 0.0008))])  # fmt: skip
def test_the_power_of_a_pressed_wall_under_colored_noise(
    restitution: float, square: Any, power: Any, step: float
) -> None:
    run = simulated(pressed_by_colored_noise(restitution), paths=960, duration=60.0, window=(20.0, 60.0), step=step,
                    initial_position=1.0, seed=4)  # fmt: skip
    for name, (right, error) in (("v_mean_square", square), ("floor_power", power)):
        assert abs(run[name].value - right) < 3.0 * np.hypot(run[name].error, error)


@pytest.mark.validation
@pytest.mark.parametrize("step", [0.02, 0.01])
@pytest.mark.parametrize("weight", [False, True])
@pytest.mark.parametrize(("restitution", "square", "power"), [(0.95, (0.0655, 0.0050), (0.0210, 0.0011)),
                                                              (0.98, (0.2190, 0.0150), (0.0233, 0.0010))])  # fmt: skip
def test_light_losses_under_colored_noise(
    restitution: float, square: Any, power: Any, weight: bool, step: float
) -> None:
    """Pressed by the spring, and by a weight of the same size: one problem."""
    system = pressed_by_colored_noise(restitution)
    if weight:
        floor = sp.Barrier(0.0, restitution, free_side="above")
        system = sp.System(*DAMPED, COLORED, sp.Constant(-4.0), floor=floor)
    run = simulated(system, paths=960, duration=60.0, window=(20.0, 60.0), step=step, start="rest", seed=4)
    for name, (right, error) in (("v_mean_square", square), ("floor_power", power)):
        assert abs(run[name].value - right) < 3.0 * np.hypot(run[name].error, error)


@pytest.mark.validation
@pytest.mark.parametrize("step", [0.02, 0.005])
def test_a_springpot_and_colored_noise_on_a_pressed_wall(step: float) -> None:
    system = sp.System(
        *DAMPED, sp.Springpot(0.5, 1.0), COLORED, floor=sp.Barrier(1.0, 0.5, free_side="above")
    )  # fmt: skip
    run = simulated(system, paths=640, duration=60.0, window=(20.0, 60.0), step=step, start="rest", seed=4)
    for name, right, error in (("v_mean_square", 0.0050, 0.0003), ("floor_power", 0.0125, 0.0006)):
        assert abs(run[name].value - right) < 3.0 * np.hypot(run[name].error, error)


@pytest.mark.validation
@pytest.mark.parametrize("place", [0.0, -0.5])
def test_a_wall_that_nothing_presses_on_needs_no_rest(place: float) -> None:
    """Colored noise, r = 0.8: a long and a short step have one answer."""
    system = sp.System(*DAMPED, COLORED, floor=sp.Barrier(place, 0.8, free_side="above"))
    long, short = (
        simulated(system, paths=640, duration=80.0, window=(20.0, 80.0), step=step, start="rest", seed=seed)
        for step, seed in ((0.02, 4), (0.005, 5))
    )
    for name in ("v_mean_square", "floor_power"):
        assert abs(long[name].value - short[name].value) < 3.0 * np.hypot(long[name].error, short[name].error)


def test_a_weight_on_a_floor_loses_nothing_in_a_system_of_masses() -> None:
    run = simulated(on_a_floor(sp.Constant(-9.81, on="a"), NONE_ON_A), paths=1, duration=20.0, window=(15.0, 20.0),
                    step=0.005, initial_position={"a": 1.0, "b": 0.0})  # fmt: skip
    assert run["floor_power"].value == 0.0
    assert run["floor_impact_rate"].value == 0.0
    assert run["floor_force_mean"].value == pytest.approx(9.81, rel=1e-9)


def test_a_pile_lies_still() -> None:
    run = simulated(pile(), paths=1, duration=12.0, window=(10.0, 12.0), step=0.005, start="rest")
    for name in ("floor_power", "gap_power", "floor_impact_rate", "gap_impact_rate"):
        assert run[name].value == 0.0
    assert run["floor_force_mean"].value == pytest.approx(14.715, rel=1e-9)
    assert run["gap_force_mean"].value == pytest.approx(4.905, rel=1e-9)


@pytest.mark.validation
def test_the_powers_in_a_shaken_pile() -> None:
    shaken = pile(sp.ColoredNoise(36.0, 0.1, on="ground"))
    run = simulated(shaken, paths=400, duration=22.0, window=(2.0, 22.0), step=0.005, start="rest", seed=6)
    for name, right, error in (("floor_power", 0.1242, 0.0010), ("gap_power", 0.0887, 0.0006)):
        assert run[name].error < 0.05 * right
        assert abs(run[name].value - right) < 3.0 * np.hypot(run[name].error, error)


@pytest.mark.validation
@pytest.mark.parametrize("several", [False, True])
def test_the_power_of_a_weight_under_colored_noise(several: bool) -> None:
    if several:
        system = on_a_floor(sp.Constant(-4.0, on="a"), sp.ColoredNoise(4.0, 0.5, on="a"))
    else:
        floor = sp.Barrier(0.0, 0.5, free_side="above")
        system = sp.System(*DAMPED, COLORED, sp.Constant(-4.0), floor=floor)
    run = simulated(system, paths=320, duration=60.0, window=(20.0, 60.0), step=0.01, start="rest", seed=4)
    assert abs(run["floor_power"].value - 0.0151) < 3.0 * np.hypot(run["floor_power"].error, 0.0008)


@pytest.mark.validation
@pytest.mark.parametrize("step", [0.0025, 0.00125])
def test_the_power_of_a_pressed_wall_under_two_sines(step: float) -> None:
    """Their common period is 62.83 s, which locks with the steps: the error falls like the step, 0.2 % at 0.01 s."""
    sines = sp.Harmonic(2.5, 1.7), sp.Harmonic(3.0, 4.1)
    system = sp.System(*DAMPED, *sines, floor=sp.Barrier(1.0, 0.5, free_side="above"))
    run = simulated(system, paths=64, duration=163.0, window=(163.0 - 62.83, 163.0), step=step, initial_position=1.0)
    assert abs(run["floor_power"].value - 0.10326) < 3.0 * np.hypot(run["floor_power"].error, 1e-4)
    assert abs(run["v_mean_square"].value - 0.023170) < 3.0 * np.hypot(run["v_mean_square"].error, 1e-5)


def test_impulses_and_rates_that_do_not_exist_are_no_number() -> None:
    """A run has them as NaN and says why; `rtol` controls what is left."""
    given: dict[str, Any] = {"paths": 16, "duration": 10.0, "start": "rest", "distributions": True}
    smooth = pressed_by_colored_noise()
    run = simulated(smooth, **given, forces=("floor_impulse",), slowest_counted_impact=0.1)
    for name in ("floor_impulse_mean", "floor_impulse_mean_square", "impact_rate", "floor_impact_speed_mean"):
        assert np.isnan(run[name].value)
    assert np.isnan(run.distributions["floor_impulse"].quantile(0.5)[0])
    assert run["floor_counted_impact_rate"].value > 0.0
    assert any(message.name == "uncountable_impacts" for message in run.warnings)
    plastic = of_many_kinds(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0), sp.Barrier(-0.3, 0.1))
    run = simulated(plastic, **given, forces=("barrier_impulse",))
    assert np.isnan(run["barrier_impulse_mean"].value)
    run = simulated(smooth, rtol=0.2, quantities="impact_rate", seed=1)
    assert np.isnan(run["impact_rate"].value)
    assert run["x_mean_square"].budget is not None


def test_a_restitution_below_0_is_refused() -> None:
    with pytest.raises(ValueError, match=r"restitution must be in \[0, 1\], not -0.1"):
        sp.Barrier(0.0, -0.1)


@pytest.mark.parametrize("step", [0.02, 0.005])
@pytest.mark.parametrize("restitution", [0.5, 0.0])
def test_a_falling_mass_gives_all_its_energy_to_the_floor(restitution: float, step: float) -> None:
    """From 1 m without a spring: 9.81 J, and the weight over the whole time, whatever the step."""
    floor = sp.Barrier(0.0, restitution, free_side="above", between=("ground", "a"))
    ball = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Constant(-9.81, on="a"), sp.Spring(1.0, between=("ground", "b")),
        floor=floor,
    )  # fmt: skip
    run = simulated(ball, paths=1, duration=20.0, window=(0.0, 20.0), step=step, start="rest", record=1,
                    initial_position={"a": 1.0, "b": 0.0})  # fmt: skip
    assert 20.0 * run["floor_power"].value == pytest.approx(9.81, rel=1e-3)
    assert 20.0 * run["floor_force_mean"].value == pytest.approx(196.2, rel=2e-3)  # the ends of the window
    lands = np.sqrt(2.0 / 9.81) * (1.0 + 2.0 * restitution / (1.0 - restitution))
    rests = np.flatnonzero(run.record[0, :, 0, 0] != 0.0)[-1] * step
    assert abs(rests - lands) < 5.0 * step


@pytest.mark.parametrize("step", [0.05, 0.013])
def test_the_momentum_of_falling_masses_is_balanced_at_any_step(step: float) -> None:
    """Of two masses that fall on one another, and bounce until they rest: to rounding."""
    falling = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Constant(-9.81, on="a"), sp.Constant(-4.905, on="b"), NONE_ON_A,
        floor=sp.Barrier(0.0, 0.6, free_side="above", between=("ground", "a")),
        gap=sp.Barrier(0.0, 0.3, free_side="above", between=("a", "b")),
    )  # fmt: skip
    for steps in (20, 60, 400):
        end = steps * step
        run = simulated(falling, paths=1, duration=end, window=(0.0, end), step=step, start="rest", record=1,
                        initial_position={"a": 0.1, "b": 0.4})  # fmt: skip
        (va, vb) = run.record[0, -1, :2, 1] - run.record[0, 0, :2, 1]
        assert run["floor_force_mean"].value * end == pytest.approx(14.715 * end + va + 0.5 * vb, rel=1e-9)
        assert run["gap_force_mean"].value * end == pytest.approx(4.905 * end + 0.5 * vb, rel=1e-9)
    assert np.abs(run.record[0, -1]).max() < 1e-12


def test_plastic_impacts_leave_masses_together_until_a_spring_pulls() -> None:
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
        sp.Barrier(-0.1, 0.0, between=("a", "b")), NONE_ON_A,
    )  # fmt: skip
    run = simulated(system, paths=1, duration=8.0, window=(0.0, 8.0), step=0.01, start="rest", record=1,
                    initial_position={"a": 0.0, "b": 0.0}, initial_velocity={"a": 0.0, "b": -1.0})  # fmt: skip
    (xa, va), (xb, vb) = run.record[0].transpose(1, 2, 0)
    assert vb[5] == -1.0
    assert va[12] == vb[12] == pytest.approx(-2.0 / 3.0, rel=1e-3)
    parts = int((0.1 + np.pi * np.sqrt(3.0)) / 0.01)  # then the spring begins to hold the first mass back
    assert np.abs(xb - xa + 0.1)[11 : parts - 2].max() < 1e-12
    assert (np.diff(xb - xa)[parts + 3 :] > 0.0).all()
    assert run["barrier_impact_rate"].value * 8.0 == 1.0
    assert run["barrier_power"].value * 8.0 == pytest.approx(1.0 / 3.0, rel=1e-3)


@pytest.mark.parametrize("place", [0.0, 0.5])
def test_plastic_impacts_under_white_noise_converge(place: float) -> None:
    """The energy that is fed in, and the moments at half the step."""
    system = sp.System(
        sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0), sp.Barrier(place, 0.0, free_side="above")
    )  # fmt: skip
    coarse, fine = (
        simulated(system, paths=640, duration=60.0, window=(20.0, 60.0), step=step, start="rest", seed=3)
        for step in (0.02, 0.01)
    )  # fmt: skip
    for name in ("x_mean", "v_mean_square", "barrier_power"):
        assert abs(coarse[name].value - fine[name].value) < 0.01 * fine[name].value + 3.0 * fine[name].error
    assert abs(fine["energy_residual"].value) < 3.0 * fine["energy_residual"].error
    assert np.isnan(fine["impact_rate"].value)
    answers, statements = sp.theory.solve_all(system)
    assert not answers
    assert all(statements.values())
    with pytest.raises(NotCoveredError, match="cover restitutions above 0, not 0"):
        sp.theory.averaging(system)


@pytest.mark.validation
def test_rest_is_kept_where_splitting_begins() -> None:
    """A level that a resting mass passes rarely: by splitting, and by plain paths."""
    system = on_a_floor(sp.Constant(-4.0, on="a"), sp.ColoredNoise(4.0, 0.5, on="a"))
    given: dict[str, Any] = {"duration": 20.0, "start": "rest"}
    rare = sp.exceedance(system, {"a_x": 0.7}, **given, rtol=0.1, seed=3)
    run = simulated(system, paths=3200, **given, step=rare.settings.step, first_passage={"a_x": 0.7}, seed=5)
    times = np.asarray(run.first_passages["a_x"].times)
    share = float((times < 20.0).mean())
    error = np.hypot(rare.error["a_x"], np.sqrt(share * (1.0 - share) / times.size))
    assert 0.0 < share < 0.1
    assert abs(rare.probability["a_x"] - share) < 3.0 * error
