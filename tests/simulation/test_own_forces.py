"""Dry friction, recorded excitation, and a force of one's own: against closed forms, an equation solver and parts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import springpot as sp
from tests.simulation.systems import of_many_kinds
from tests.sizes import validation

NOISE = sp.WhiteNoise(1.0)
# with these the systems with friction and those with a record are of one kind, which is compiled once
NO_FRICTION, NO_RECORD = sp.Friction(0.0), sp.RecordedExcitation((0.0, 100.0), (0.0, 0.0))


ONE = sp.System(sp.Mass(2.0), sp.Spring(2.0), sp.Dashpot(0.0), sp.Friction(0.1), NO_RECORD)
BETWEEN = {"between": ("ground", "a")}
BESIDE_ANOTHER = sp.System(
    sp.Mass(2.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(2.0, **BETWEEN), sp.Friction(0.1, **BETWEEN),
    sp.Spring(1.0, between=("ground", "b")),
)  # fmt: skip


@pytest.mark.parametrize(("slider", "place"), [(ONE, 1.03), (BESIDE_ANOTHER, {"a": 1.03})])
def test_dry_friction_takes_the_same_from_every_half_cycle_and_holds_the_mass_at_rest(
    slider: sp.System, place: float | dict[str, float]
) -> None:
    """Free vibration: the amplitude falls by 2 F / k in each half cycle, until the spring cannot move the mass."""
    run = sp.simulate(
        slider, paths=1, duration=12.0 * math.pi, step=0.01, start="rest", initial_position=place, record=1,
        window=(0.0, 3.0 * math.pi),
    )  # fmt: skip
    moved = run.record.reshape(len(run.time), -1)[:, 0]
    x = np.interp(math.pi * np.arange(11), run.time, moved)
    expected = (1.03 - 0.1 * np.arange(11)) * (-1.0) ** np.arange(11)
    assert x == pytest.approx(expected, abs=2e-4)
    assert abs(moved[-200:]).max() < 0.05 + 1e-4  # where it sticks, the spring is weaker than the friction
    # at rest it creeps: one mass with a time constant of 2 / (Omega^2 h), beside another more slowly
    rate = math.log(moved[-200] / moved[-1]) / (199 * run.settings.step)
    assert rate < 0.4 * run.settings.step or slider is ONE
    assert rate == pytest.approx(0.5 * run.settings.step, rel=0.05) or slider is not ONE
    # energy: in three half cycles the friction took k (x0^2 - x3^2) / 2, which it reports as a power
    taken = run["friction_power"].value * 3.0 * math.pi
    assert taken == pytest.approx(1.03**2 - 0.73**2, rel=1e-3)


def test_a_record_moves_the_mass_as_the_equation_says() -> None:
    """Straight lines between uneven points, of the ground and of a force, against an equation solver."""
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.uniform(0.02, 0.3, 120))
    a = rng.normal(size=t.size)

    def moved(sign: float, mass: float) -> np.ndarray:
        def rates(s: float, y: np.ndarray) -> list[float]:
            return [y[1], -y[0] - 0.2 * y[1] + sign / mass * np.interp(s, t - t[0], a)]

        solved = solve_ivp(
            rates, (0.0, run.time[-1]), [0.0, 0.0], rtol=1e-8, atol=1e-10, max_step=0.02, dense_output=True
        )
        return np.asarray(solved.sol(run.time)[0])

    for on, sign, mass in (("ground", -1.0, 1.0), ("mass", 1.0, 3.0)):
        record = sp.RecordedExcitation(tuple(t), tuple(a), on=on)
        shaken = sp.System(sp.Mass(3.0), sp.Spring(3.0), sp.Dashpot(0.6), NO_FRICTION, record)
        run = sp.simulate(shaken, paths=1, record=1)
        assert run.warnings == ()
        assert (run.settings.start, run.settings.window) == ("rest", (0.0, pytest.approx(t[-1] - t[0])))
        assert run.record[0, :, 0] == pytest.approx(moved(sign, mass), abs=3e-4)
    # all that was fed in was taken out or is still in the motion
    energy = 0.5 * 3.0 * (run["x_mean_square_end"].value + run["v_mean_square_end"].value)
    left = (run["recorded_excitation_power"].value - run["damping_power"].value) * run.settings.duration
    assert left == pytest.approx(energy, rel=1e-6)


@pytest.mark.validation
def test_a_record_alone_strikes_a_lossy_wall_a_finite_number_of_times() -> None:
    t = np.linspace(0.0, 10.0, 101)
    shaken = sp.System(
        sp.Spring(4.0), sp.Dashpot(0.2), sp.RecordedExcitation(tuple(t), tuple(np.sin(2.0 * t))), sp.Barrier(-0.1, 0.5)
    )
    run = sp.simulate(shaken, paths=1)
    assert run.warnings == ()
    assert 2 <= run["impact_rate"].value * run.settings.duration <= 40
    noisy = sp.System(*shaken.parts, sp.ColoredNoise(0.1, 0.2))
    assert np.isnan(sp.simulate(noisy, paths=64)["impact_rate"].value)


def _own(t: float, x: float, v: float) -> float:
    """The force of two dampers, of x and v, and no number far away; one function of one name, so compiled once.

    It makes an array, which the code around it never does.
    """
    forces = np.array([-0.5 * (x * x - 1.0) * v, -0.4 * v**3])
    return forces.sum() if abs(x) < 1e3 else math.nan


@pytest.mark.validation  # every day: one mass's own forces, in this file
def test_a_force_of_ones_own_does_what_the_same_parts_do() -> None:
    """Of x and v, with a mass, against the parts themselves: the same noise gives nearly the same paths."""
    given = {"paths": 1024, "step": 0.02, "duration": 40.0, "window": (10.0, 40.0), "start": "rest"}
    plain = sp.Mass(2.0), sp.Spring(2.0), sp.Dashpot(1.0), sp.WhiteNoise(4.0)
    own = sp.System(*plain, magnet=sp.Force(_own))
    parts = of_many_kinds(*plain, sp.VanDerPol(0.5), sp.PolynomialDashpot((0.0, 0.0, 0.4)))
    one, other = sp.simulate(own, **given), sp.simulate(parts, **given)
    for name in ("x_mean_square", "v_mean_square", "damping_power"):
        assert one[name].value == pytest.approx(other[name].value, rel=1e-3)
    taken = other["van_der_pol_power"].value + other["polynomial_dashpot_power"].value
    assert -one["magnet_power"].value == pytest.approx(taken, rel=2e-3)


@pytest.mark.validation
def test_a_force_of_ones_own_knows_the_time() -> None:
    pushed = sp.System(sp.Spring(1.0), sp.Dashpot(0.4), sp.Force(lambda t, x, v: math.sin(1.3 * t)))
    end = sp.simulate(pushed, paths=1, step=0.01, duration=60.0, start="rest").record  # no path is recorded
    assert end.shape[0] == 0
    run = sp.simulate(pushed, paths=1, step=0.01, duration=60.0, start="rest", record=1)
    response = 1.0 / (1.0 - 1.69 + 0.52j)
    late = run.time > 50.0
    assert run.record[0, late, 0] == pytest.approx((response * np.exp(1.3j * run.time[late])).imag, abs=1e-3)


def _raises(t: float, x: float, v: float) -> float:
    if x > -9.0:
        raise ValueError("no place")
    return x


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        (lambda t, x, v: str(x), "magnet has a function that Numba cannot compile"),
        (lambda t, x, v: missing(x), "magnet has a function that Numba cannot compile.*'missing' is not defined"),  # type: ignore[name-defined]  # noqa: F821
        validation(_raises, "the function of magnet failed during the run: ValueError.'no place'"),
    ],
)
def test_a_function_that_cannot_be_used_is_said_with_the_parts_name(function, sentence: str) -> None:
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), NOISE, magnet=sp.Force(function))
    with pytest.raises(ValueError, match=sentence):
        sp.simulate(system, paths=64, duration=1.0, start="rest")


def test_a_function_that_returns_no_number_is_said_with_the_parts_name(tmp_path: Path) -> None:
    system = sp.System(sp.Mass(2.0), sp.Spring(2.0), sp.WhiteNoise(4.0), sp.Dashpot(1.0), magnet=sp.Force(_own))
    run = sp.simulate(system, paths=64, duration=1.0, step=0.02, start="rest", initial_position=2e3)
    assert any("the function of magnet returns no number" in sentence for sentence in run.warnings)
    with pytest.raises(ValueError, match="magnet cannot be written to a file"):
        run.save(tmp_path / "run.nc")


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.Friction(-1.0), "force must be"),
        (lambda: sp.Force(3.0), "function must be a function f"),
        (lambda: sp.RecordedExcitation((0.0, 1.0), (1.0,)), "must have the same number of points"),
        (lambda: sp.RecordedExcitation((0.0, 0.0), (1.0, 1.0)), "time must increase"),
        (lambda: sp.RecordedExcitation((0.0, 1.0), (1.0, math.nan)), r"values\[1\] must be"),
        (lambda: sp.RecordedExcitation("abc", (1.0,)), "time must be a list of numbers"),
        (
            lambda: sp.System(sp.Spring(1.0), sp.RecordedExcitation((0.0, 1.0), (1.0, 1.0), on="roof")),
            "on of recorded_exc",
        ),
        (lambda: sp.System(sp.Spring(1.0), sp.Friction(0.1), sp.ThermalNoise(1.0)), "friction cannot be combined"),
        (
            lambda: sp.System(sp.Spring(1.0), sp.Contact(-1.0, 9.0, dissipation=0.1), sp.ThermalNoise(1.0)),
            "contact cannot be combined with ThermalNoise",
        ),
    ],
)
def test_wrong_numbers_are_refused(make, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()


def test_an_observable_cannot_take_the_name_of_a_result() -> None:
    slider = sp.System(sp.Spring(1.0), sp.Friction(0.1), NOISE)
    with pytest.raises(ValueError, match="cannot be called 'friction_power'"):
        sp.simulate(slider, paths=64, duration=1.0, observables={"friction_power": lambda t, x, v: v})
