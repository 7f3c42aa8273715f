"""Facts that are exact, compared in standard errors sharp enough that a wrong factor of 2 % fails."""

import math
from functools import cache, partial
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import scipy
from scipy import integrate, linalg

import springpot as sp
from springpot.simulation import simulate
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.options import Scheme
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.schemes import scheme_of
from tests.reference import walk, walk_as_printed
from tests.sizes import validation

from .problems import assert_agrees, errors_of, oscillator, truncated_gaussian, values_of

DOUBLE = 1e-9  # relative error of the memory: without noise, all else is in double precision anyway


@pytest.mark.parametrize(
    ("step", "position"),
    [
        validation(0.02, -1.0),
        validation(0.02, -0.3),
        validation(0.02, 0.0),
        (0.02, 0.5),
        validation(0.02, 1.0),
        (0.3, -1.0),
        validation(0.3, -0.3),
        (0.3, 0.0),
        validation(0.3, 0.5),
        (0.3, 1.0),
    ],
)
def test_order_1_elastic_wall_is_exact_at_any_step(position: float, step: float) -> None:
    problem = oscillator(1.0, 0.8, 1.3, 2.0, position)
    found = simulate(problem, paths=12_000, duration=120.0, step=step, window=(20.0, 120.0), start="rest")
    assert_agrees(found, truncated_gaussian(position, 0.8, 1.3, 2.0))
    assert abs(found["energy_residual"].value) < 4 * found["energy_residual"].error


def test_order_1_displacement_is_half_normal_and_impact_speed_rayleigh() -> None:
    found = simulate(oscillator(1.0), paths=40_000, duration=20.0, step=0.1, record=40_000, start="rest")
    x, v = found.record[:, -1].T
    assert scipy.stats.kstest(x, scipy.stats.halfnorm(scale=math.sqrt(0.5)).cdf).pvalue > 1e-3
    assert scipy.stats.kstest(v, scipy.stats.norm(scale=math.sqrt(0.5)).cdf).pvalue > 1e-3
    assert abs(np.corrcoef(x, v)[0, 1]) < 4 / math.sqrt(x.size)


@pytest.mark.parametrize(
    ("scheme", "time"),
    [
        ("default", 0.7),
        ("default", 2.0),
        ("default", 5.0),
        ("grunwald", 0.7),
        validation("grunwald", 2.0),
        validation("grunwald", 5.0),
    ],
)
def test_order_1_transient_from_rest(time: float, scheme: str) -> None:
    c, w, q = 0.5, 1.2, 1.5
    zeta = c / (2 * w)
    wd = w * math.sqrt(1 - zeta**2)
    sine, double = math.sin(wd * time), math.sin(2 * wd * time)
    bow = 2 * (zeta * w / wd) ** 2 * sine**2
    fading = math.exp(-c * time)
    exact = {
        "x_mean_square_end": q / (2 * c * w**2) * (1 - fading * (1 + zeta * w / wd * double + bow)),
        "v_mean_square_end": q / (2 * c) * (1 - fading * (1 - zeta * w / wd * double + bow)),
    }
    step = 0.01 if scheme == "default" else 1e-3
    found = simulate(oscillator(1.0, c, w, q), paths=120_000, duration=time, step=step, scheme=scheme, start="rest")
    assert_agrees(found, exact)


@pytest.mark.parametrize("position", [None, 0.0])
def test_order_0_stores_and_does_not_dissipate(position: float | None) -> None:
    found = simulate(oscillator(0.0, 0.6, 1.0, 1.0, position), paths=100_000, duration=15.0, step=0.02, start="rest")
    rows = values_of(found), errors_of(found)
    energy = 0.5 * (rows[0]["v_mean_square_end"] + 1.6 * rows[0]["x_mean_square_end"])
    error = 0.5 * (rows[1]["v_mean_square_end"] + 1.6 * rows[1]["x_mean_square_end"])
    assert error < 0.005 * 7.5
    assert abs(energy - 7.5) < 4 * error


@pytest.mark.parametrize(
    ("order", "coefficient", "frequency"),
    [(0.2, 0.5, 1.0), validation(0.5, 1.0, 1.0), (0.7, 0.4, 2.0), validation(0.9, 3.0, 1.0)],
)
def test_no_wall_stationary_spectrum(order: float, coefficient: float, frequency: float) -> None:
    def power(w: float, moment: int) -> float:
        return w**moment / abs(frequency**2 - w * w + coefficient * (1j * w) ** order) ** 2 / math.pi

    peak = frequency * 1.2
    pieces = [(0.0, peak), (peak, 4 * peak), (4 * peak, math.inf)]
    exact = {
        name: sum(integrate.quad(power, *piece, args=(moment,), limit=400)[0] for piece in pieces)
        for name, moment in (("x_mean_square", 0), ("v_mean_square", 2))
    }
    problem = oscillator(order, coefficient, frequency, 1.0, None)
    found = simulate(problem, paths=10_000, duration=150.0, step=0.02, start="stationary")
    assert_agrees(found, exact)
    assert not any("impact" in name for name in found.estimates)


@pytest.mark.parametrize("tolerance", [DOUBLE, validation(1e-6)])
@pytest.mark.parametrize("step", [0.2, 0.05])
def test_paper_scheme_without_wall_obeys_its_own_lyapunov_equation(step: float, tolerance: float) -> None:
    """At order 1 the Grunwald-Letnikov scheme is a linear map: its moments are known with the error of its step.

    In double precision, of which the kernel is needed anyway, and in single.
    """
    c, w, q = 1.0, 1.0, 1.0
    matrix = np.array([[1 - step**2 * w**2, step - step**2 * c], [-step * w**2, 1 - step * c]])
    noise = math.sqrt(q * step) * np.array([[step], [1.0]])
    covariance = linalg.solve_discrete_lyapunov(matrix, noise @ noise.T)
    exact = {"x_mean_square": covariance[0, 0], "v_mean_square": covariance[1, 1]}
    assert covariance.trace() > 1.01  # the step shows, so this is no test of the continuous limit
    found = simulate(
        oscillator(1.0, c, w, q, None), paths=30_000, duration=200.0, step=step, scheme="grunwald", start="rest",
        memory_tolerance=tolerance,
    )  # fmt: skip
    assert_agrees(found, exact, sharp=0.002)


def _one_normal(seed: int, path: int, steps: int, word: int) -> np.ndarray:
    return np.append(1.0, np.zeros(steps - 1))


@pytest.mark.parametrize("order", [validation(0.1), validation(0.3), 0.5, validation(0.7), validation(0.9), 1.0])
@pytest.mark.parametrize(("word", "steps", "left"), [("default", (0.2, 0.05), 1e-3), ("grunwald", (0.08, 0.02), 0.011)])
def test_weak_order_of_a_scheme_is_what_it_states(
    word: Scheme, steps: tuple[float, float], left: float, order: float
) -> None:
    """Without a wall a scheme is linear: stationary moments are sums of squares of its response to one normal."""
    problem = oscillator(order, 1.0, 1.0, 1.0, None)

    def power(w: float, moment: int) -> float:
        return w**moment / abs(1.0 - w * w + (1j * w) ** order) ** 2 / math.pi

    pieces = [(0.0, 1.0), (1.0, 2.0), (2.0, 8.0), (8.0, math.inf)]
    exact = [sum(integrate.quad(power, *p, args=(m,), limit=400, epsabs=1e-12)[0] for p in pieces) for m in (0, 2)]
    biases = []
    for step in steps:
        step_by_step = partial(walk, flight=1.0) if word == "default" else walk_as_printed
        path = step_by_step(problem, step, round(240.0 / step), seed=0, draw=_one_normal)
        biases.append([float((a**2).sum()) / e - 1.0 for a, e in zip((path.x, path.v), exact, strict=True)])
    for coarse, fine in zip(*biases, strict=True):
        assert abs(fine) < left
        assert abs(fine) < 2e-5 or math.log(abs(coarse / fine), 4.0) > 0.9 * scheme_of(word).order


def _stationary_rows(problem: sp.Oscillator, duration: float, paths: int, step: float) -> tuple[dict, float]:
    plan = adapt(plan_of(problem, paths=paths, duration=duration, step=step, start="stationary"))
    simulation, settings = simulation_of(plan), plan.settings
    rows = simulation.advance().rows
    low, high = settings.window_steps
    per_second = ("speeds", "barrier"), ("squares", "barrier"), ("energy", "first"), ("energy", "last")
    scale = dict.fromkeys(per_second, settings.step)
    sums = simulation.parts.sums(rows).items()
    means = {name: own / ((high - low) * scale.get(name, 1.0)) for name, own in sums}
    return means, simulation.parts.expected_power - simulation.parts.taken_at_once


@pytest.mark.parametrize(
    ("order", "coefficient", "restitution", "position", "paths", "step"),
    [
        validation(0.5, 1.0, 1.0, 0.0, 10_000, 0.05),
        (0.5, 1.0, 0.4, -0.4, 10_000, 0.05),
        validation(1.0, 0.5, 0.8, 0.0, 40_000, 0.02),
        validation(1.0, 0.5, 0.4, 0.0, 40_000, 0.02),
        validation(0.5, 1.0, 1.0, 0.0, 40_000, 0.02),
        validation(0.5, 1.0, 0.7, -0.4, 40_000, 0.02),
        validation(0.3, 0.8, 0.9, 0.3, 40_000, 0.02),
    ],
)
def test_stationary_identities(
    order: float, coefficient: float, restitution: float, position: float, paths: int, step: float
) -> None:
    """Means of d/dt of v, x v and the energy vanish: force, virial and energy balance, path by path."""
    problem = oscillator(order, coefficient, 1.0, 1.0, position, restitution)
    mean, fed = _stationary_rows(problem, 300.0, paths, step)
    push = (1 + restitution) * mean["speeds", "barrier"]
    loss = 0.5 * (1 - restitution**2) * mean["squares", "barrier"]
    gain, power = mean["energy", "last"] - mean["energy", "first"], mean["power", ""]
    # each with the terms in it that must be noticed if they are 2 % off
    x, x_square, v_square = (mean[name, "mass"] for name in ("x", "x^2", "v^2"))
    balances = {
        "force": (push - x - mean["force", ""], [push, x]),
        "virial": (
            v_square - x_square - mean["virial", ""] + position * push,
            [v_square, x_square, mean["virial", ""]] if order < 1 else [v_square],
        ),
        "energy": (power + loss + gain - fed, [power, loss] if restitution < 1 else [power]),
    }
    for name, (residual, terms) in balances.items():
        error = residual.std(ddof=1) / math.sqrt(residual.size)
        assert all(error < 0.005 * term.mean() for term in terms), f"{name} is not sharp enough"
        assert abs(residual.mean()) < 4 * error, f"{name}: {residual.mean()} +- {error}"


@pytest.mark.parametrize(
    ("restitution", "energy", "error", "paths"),
    [
        (0.8, 0.2108, 0.0003, 4000),
        (0.5, 0.1100, 0.0002, 4000),
        validation(0.95, 0.3782, 0.0006, 20_000),
        validation(0.8, 0.2108, 0.0003, 20_000),
        validation(0.5, 0.1100, 0.0002, 20_000),
    ],
)
def test_strong_losses_against_published_simulation(
    restitution: float, energy: float, error: float, paths: int
) -> None:
    """Mean energy at c = q = 0.1, from an independent Monte Carlo; near the renewal formula, far from averaging."""
    found = simulate(
        oscillator(1.0, 0.1, 1.0, 0.1, 0.0, restitution), paths=paths, duration=300.0, step=0.01, start="rest"
    )
    value = 0.5 * found["amplitude_mean_square"].value
    spread = 0.5 * found["amplitude_mean_square"].error
    assert spread < 0.005 * energy
    assert abs(value - energy) < 4 * math.hypot(spread, error)


@pytest.mark.validation  # every day: test_mckean.py
def test_return_speed_after_an_impact_is_mckeans() -> None:
    """A free mass thrown from the wall with speed 1 under white noise of unit intensity (McKean, 1963).

    The joint law of the time and the speed of its return, compared on the paths that return before t = 3.
    """
    latest = 3.0

    def density(u: float, t: float) -> float:
        spread = math.sqrt(2 / 3) * math.erf(math.sqrt(6 * u / t))
        return 3 * u / (math.pi * math.sqrt(2) * t * t) * math.exp(-2 * (1 - u + u * u) / t) * spread

    speeds = np.linspace(1e-6, 12.0, 600)
    given = np.array([integrate.quad(lambda t, u=u: density(u, t), 0, latest, limit=200)[0] for u in speeds])
    cumulative = integrate.cumulative_trapezoid(given, speeds, initial=0.0)
    found = simulate(
        oscillator(1.0, 0.0, 1e-4, 1.0, 0.0), paths=4096, duration=latest, step=2e-3, initial_velocity=1.0, record=4096
    )
    x, v = found.record[:, :, 0], found.record[:, :, 1]
    # the step in which the velocity jumps from -u to u
    arriving = (v[:, :-1] < 0) & (v[:, 1:] > 0) & (np.abs(v[:, 1:] + v[:, :-1]) < 0.5) & (x[:, 1:] < 0.02)
    returned = arriving.any(axis=1)
    first = arriving.argmax(axis=1)[returned]
    measured = np.abs(v[returned, first])
    share = cumulative[-1]
    assert abs(returned.mean() - share) < 4 * math.sqrt(share * (1 - share) / 4096)
    law = lambda u: np.interp(u, speeds, cumulative / share)  # noqa: E731
    assert scipy.stats.kstest(measured, law).pvalue > 1e-3


@cache
def _free_response(
    order: float, c: float, w: float, x0: float, v0: float, times: tuple[float, ...], caputo: bool
) -> np.ndarray:
    def transform(s: mp.mpc) -> mp.mpc:
        return (x0 * s + (c * x0 * s ** (order - 1) if caputo else 0) + v0) / (s * s + c * s**order + w * w)

    with mp.workdps(20):
        return np.array([float(mp.invertlaplace(transform, t, method="talbot")) for t in times])


@pytest.mark.parametrize("derivative", ["caputo", "riemann-liouville"])
@pytest.mark.parametrize("scheme", ["default", "grunwald"])
@pytest.mark.parametrize("order", [0.0, validation(0.2), 0.5, validation(0.8), 1.0])
def test_free_response_converges_to_the_laplace_inversion(order: float, scheme: str, derivative: str) -> None:
    times = np.arange(1.0, 11.0)
    # at order 0 both kinds are x itself
    exact = _free_response(order, 0.7, 1.3, 1.0, 0.4, tuple(times), derivative == "caputo" and order > 0.0)
    problem = oscillator(order, 0.7, 1.3, 0.0, None)
    errors = []
    for step in (0.05, 0.0125):
        found = simulate(
            problem, paths=1, duration=10.0, step=step, initial_position=1.0, initial_velocity=0.4, record=1,
            derivative=derivative, memory_tolerance=1e-11, scheme=scheme,
        )  # fmt: skip
        errors.append(np.abs(found.record[0, np.rint(times / step).astype(int), 0] - exact).max())
    if order == 0.0 and scheme == "default":  # a spring, which is flown exactly
        assert max(errors) < 1e-13
        return
    measured_order = math.log(errors[0] / errors[1], 4.0)
    # the force x(0) t^-order of Riemann-Liouville, infinite at t = 0, costs the order of the derivative
    expected = 2.0 if derivative == "caputo" else 2.0 - order
    if scheme == "grunwald":
        expected = 1.0
    assert measured_order > expected - 0.15
    assert errors[1] < (0.02 if scheme == "grunwald" else 2e-4 if derivative == "caputo" else 3e-3)


def test_a_grazing_impact_between_two_points_above_the_wall_is_not_missed() -> None:
    """C = q = 0, wall at -1: a path that dips under the wall inside the first half step, above it at both ends."""
    u, half = 0.048, 0.2
    depth = 0.3 * u * u / 2
    c, s = math.cos(half), math.sin(half)
    x0, v0 = c * (-1 + depth) + s * u, -c * u + s * (-1 + depth)
    assert x0 > -1.0
    assert math.hypot(x0, v0) > 1.0
    found = simulate(
        oscillator(0.5, 0.0, 1.0, 0.0, -1.0, 0.5), paths=1, duration=1.6, step=0.4, window=(0.0, 1.6),
        initial_position=x0, initial_velocity=v0, memory_tolerance=DOUBLE,
    )  # fmt: skip
    assert found["impact_rate"].value > 0.0


def test_columns_of_the_springpot_where_they_are_known() -> None:
    """Towards order 0 the force is C x, at order 1 it is C v."""
    spring = simulate(oscillator(1e-6, 0.7), paths=2000, duration=20.0, step=0.01, window=(5.0, 20.0), start="rest")
    assert spring["damping_force_mean"].value == pytest.approx(0.7 * spring["x_mean"].value, rel=2e-3)
    assert spring["damping_virial"].value == pytest.approx(0.7 * spring["x_mean_square"].value, rel=2e-3)
    dashpot = simulate(oscillator(1.0, 0.7), paths=2000, duration=20.0, step=0.01, window=(5.0, 20.0), start="rest")
    assert dashpot["damping_power"].value == pytest.approx(0.7 * dashpot["v_mean_square"].value, rel=6e-3)
    start = simulate(oscillator(1.0, 0.7, 1.0, 0.0, None), paths=1, duration=1.0, step=1e-3, window=(0.0, 1.0),
                initial_position=1.0, record=1, memory_tolerance=1e-9)  # fmt: skip
    assert start["damping_force_mean"].value == pytest.approx(0.7 * (start.record[0, -1, 0] - 1.0), rel=1e-3)


@pytest.mark.parametrize("paths", [6000, validation(20_000)])
def test_energies_below_the_collapse_do_not_depend_on_the_step(paths: int) -> None:
    runs = [simulate(oscillator(1.0, 0.5, restitution=0.1), paths=paths, step=step, seed=i, start="rest") for i, step in
            enumerate((0.02, 0.005))]  # fmt: skip
    for name in ("x_mean_square", "v_mean_square"):
        values, errors = ([getattr(r[name], what) for r in runs] for what in ("value", "error"))
        assert max(errors) < 0.005 * values[0]
        assert abs(values[0] - values[1]) < 4 * math.hypot(*errors)


@pytest.mark.parametrize("velocity", [1e-320, 1e-200, 1e-15])
def test_a_touch_too_soft_to_count_is_rest(velocity: float) -> None:
    found = simulate(
        oscillator(0.5, 0.0, 1.0, 0.0, 1.0), paths=1, duration=1.0, initial_velocity=velocity, record=1,
        memory_tolerance=DOUBLE,
    )  # fmt: skip
    assert (found.record[0, :, 0] == 1.0).all()
    assert (np.abs(found.record[0, :, 1]) <= velocity).all()


NEARLY_NONE = 1e-40  # of noise: without any the mass may come to rest on a lossy wall


def turned(problem: sp.Oscillator, **given: Any) -> tuple[Any, dict[Any, float]]:
    """Record and mean sums of exact flights."""
    simulation = simulation_of(plan_of(problem, **given))
    ensemble = simulation.advance()
    return ensemble.record, simulation.parts.sums(ensemble.rows.mean(axis=0))


@pytest.mark.parametrize(("tolerance", "rounding"), [(DOUBLE, 1e-10), validation(1e-6, 1e-5)])
def test_without_springpot_and_noise_energy_is_kept_and_lost_at_impacts_only(tolerance: float, rounding: float) -> None:
    """In double precision and, where a tolerance of the memory allows it, in single precision."""
    record, sums = turned(
        oscillator(0.5, 0.0, 1.0, NEARLY_NONE, -0.5, 0.7), paths=1, duration=20.0, step=0.01, window=(0.0, 20.0),
        initial_position=2.0, record=1, memory_tolerance=tolerance,
    )  # fmt: skip
    above = 0.5 * (record[0] ** 2).sum(axis=1) - 0.5 * 0.5**2
    impacts = np.rint(np.log(above / above[0]) / math.log(0.49))
    assert above == pytest.approx(above[0] * 0.49**impacts, rel=rounding)
    assert impacts[-1] == sums["impacts", "barrier"] == 5
    kept = sums["energy", "first"] - sums["loss", "barrier"]
    assert sums["energy", "last"] == pytest.approx(kept, abs=0.1 * rounding)


def test_impact_times_of_a_free_flight_are_exact() -> None:
    """From x(0) = 2 the wall at -0.5 is met at phase arccos(-1/4): the step has nothing to do with it."""
    problem = oscillator(0.5, 0.0, 1.0, NEARLY_NONE, -0.5, 0.7)
    first = math.acos(-0.25)
    for step in (0.4, 0.07):
        given = {"paths": 1, "duration": 4.0, "step": step, "initial_position": 2.0, "record": 1}
        (path,), _ = turned(problem, **given, memory_tolerance=DOUBLE)
        time = plan_of(problem, **given).settings.step * np.arange(len(path))
        after = time > first
        speed = 0.7 * math.sqrt(4.0 - 0.25)
        t = time[after] - first
        assert path[after, 0] == pytest.approx(-0.5 * np.cos(t) + speed * np.sin(t), abs=1e-12)
        assert path[~after, 0] == pytest.approx(2.0 * np.cos(time[~after]), abs=1e-12)


def test_chatter_against_a_preload_ends_at_rest() -> None:
    """x'' + x = 0 above a wall at 1 with r = 0.7: hops shrink geometrically, and those below a step are left out."""
    problem = oscillator(0.5, 0.0, 1.0, 0.0, 1.0, 0.7)
    found = simulate(
        problem, paths=1, duration=20.0, step=0.01, initial_position=2.0, record=1, memory_tolerance=DOUBLE
    )
    speeds = math.sqrt(3.0) * 0.7 ** np.arange(1, 200)
    end = math.acos(0.5) + 2.0 * np.arctan(speeds[speeds > 0.5 * 0.01]).sum()
    x, v = found.record[0].T
    resting = (x == 1.0) & (v == 0.0)
    assert resting[found.time > end + 0.02].all()
    assert not resting[found.time < end - 0.02].any()


def test_chatter_under_noise_ends_too() -> None:
    problem, given = oscillator(0.5, 1.0, 1.0, 1.0, 0.3, 0.05), {"paths": 500, "duration": 50.0, "start": "rest"}
    assert turned(problem, **given)[1]["limit", "collapses"] > 0.0
    found = simulate(problem, **given)
    assert any("impact rate and speeds are undefined" in w for w in found.warnings)
    assert math.isnan(found["impact_rate"].value)
    assert found.to_dict()["impact_speed_mean"] is None
    assert abs(found["energy_residual"].value) < 4 * found["energy_residual"].error


def test_elastic_hops_on_a_preload_are_counted_not_walked() -> None:
    """With r = 1 a mass that hops with speed 1e-4 makes thousands of impacts in a second; it must not take long."""
    found = simulate(
        oscillator(0.5, 0.0, 1.0, 0.0, 1.0), paths=1, duration=2.0, step=0.1, window=(0.0, 2.0),
        initial_velocity=1e-4, memory_tolerance=DOUBLE, impact_observables={"wear": lambda speed: speed},
    )  # fmt: skip
    assert found["impact_rate"].value == pytest.approx(1.0 / (2.0 * math.atan(1e-4)), rel=1e-3)
    assert found["wear"].value == pytest.approx(1e-4 * found["impact_rate"].value, rel=1e-6)
    assert found["impact_speed_mean"].value == pytest.approx(1e-4, rel=1e-6)


def test_hundreds_of_impacts_in_a_step_between_two_close_walls() -> None:
    """At a speed of 1 between walls 1e-4 apart: five hundred in each drift."""
    walls = sp.Barrier(-0.5, free_side="above"), sp.Barrier(-0.4999, free_side="below")
    found = simulate(
        sp.System(sp.Spring(4.0), *walls), paths=1, duration=10.0, step=0.05, window=(0.0, 10.0),
        initial_position=-0.49995, initial_velocity=1.0,
    )  # fmt: skip
    assert found["barrier_1_impact_rate"].value == pytest.approx(5000.0, rel=1e-3)
    assert found["v_mean_square"].value == pytest.approx(1.0, rel=1e-3)


def test_the_reference_agrees_with_quadrature() -> None:
    """Joint density exp(-(2C/q)(v^2/2 + Omega^2 x^2/2)): its mean, and the flux p(b) sqrt(q / (4 pi C)) at the wall."""
    exact = truncated_gaussian(0.5, 0.8, 1.3, 2.0)
    density = lambda x: math.exp(-0.8 * 1.3**2 * x * x / 2.0)  # noqa: E731
    mass = integrate.quad(density, 0.5, 20.0)[0]
    assert integrate.quad(lambda x: x * density(x), 0.5, 20.0)[0] / mass == pytest.approx(exact["x_mean"], rel=1e-9)
    assert density(0.5) / mass * math.sqrt(2.0 / (4 * math.pi * 0.8)) == pytest.approx(exact["impact_rate"], rel=1e-9)


@pytest.mark.parametrize(("scheme", "step", "within"), [("default", 0.01, 1e-4), ("grunwald", 0.001, 2e-3)])
@pytest.mark.parametrize("derivative", ["caputo", "riemann-liouville"])
def test_at_order_zero_the_element_is_a_spring(scheme, step, within, derivative):
    """Whatever the start and the derivative's kind: D^0 x is x."""
    problem = oscillator(0.0, 1.0, intensity=0.0, position=None)
    found = simulate(
        problem, paths=1, record=1, duration=10.0, step=step, window=(0.0, 10.0), initial_position=1.0, scheme=scheme,
        derivative=derivative, memory_tolerance=1e-9,
    )  # fmt: skip
    assert np.abs(found.record[0, :, 0] - np.cos(math.sqrt(2.0) * found.time)).max() < within


@pytest.mark.parametrize("paths", [4000, validation(20_000)])
def test_a_stationary_start_at_order_zero_remembers_nothing(paths):
    """Equal to the same oscillator with its springs put together."""
    element = simulate(oscillator(0.0, 1.0, restitution=0.8), paths=paths, start="stationary")
    spring = simulate(oscillator(0.0, 0.0, 2.0**0.5, restitution=0.8), paths=paths, start="stationary", seed=2)
    for name in ("x_mean", "v_mean_square", "impact_rate"):
        error = math.hypot(element[name].error, spring[name].error)
        assert abs(element[name].value - spring[name].value) < 4.0 * error < 0.04 * spring[name].value
