"""A mass on springpots without a spring: a stationary state below order 1/2, none from there on."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.simulation.plan.motions import motion_of
from springpot.theory.result import NoStationaryStateError


def constant_loss(loss: float = 0.1) -> tuple[sp.Springpot, float]:
    """K' of 1000 N/m at the resonance of 1 kg, and this loss factor at every frequency."""
    order = 2.0 / math.pi * math.atan(loss)
    spring, pot = sp.Springpot.from_loss_factor(order, loss, 1000.0, math.sqrt(1000.0) / (2.0 * math.pi))
    assert spring.stiffness == pytest.approx(0.0, abs=1e-9)
    return pot, math.sqrt(1000.0)


def mean_square(stiffness: Any, middle: float, intensity: float = 1.0) -> float:
    """Of x, by quadrature in the logarithm of the frequency."""

    def density(u: float) -> float:
        w = math.exp(u)
        return intensity / math.pi * w / abs(stiffness(1j * w) - w * w) ** 2

    parts = [-math.inf, *(math.log(middle) + d for d in (-1.0, -0.1, 0.1, 1.0)), math.inf]
    return sum(
        integrate.quad(density, max(a, -690.0), min(b, 40.0), limit=2000, epsrel=1e-10)[0] for a, b in pairwise(parts)
    )


def test_a_constant_loss_factor_has_a_stationary_state() -> None:
    pot, middle = constant_loss()
    found = sp.theory.linear(sp.System(sp.Mass(1.0), pot, sp.WhiteNoise(1.0)))
    exact = mean_square(lambda p: pot.coefficient * p**pot.order, middle)
    assert exact == pytest.approx(1.63992e-4, rel=1e-5)
    assert found.x_mean_square == pytest.approx(exact, rel=1e-7)
    assert found.x_mean == 0.0
    assert found.spectral_moments((0,))[0] == pytest.approx(exact, rel=1e-7)
    device = sp.System(sp.Mass(1.0), pot, sp.WhiteNoise(1.0))
    assert sp.recommended(device).method == "linear"
    assert "analytical methods with an answer: linear" in sp.explain(device)


@pytest.mark.parametrize(("order", "coefficient"), [(0.2, 1.0), (0.35, 4.0), (0.45, 0.5), (0.49, 1.0)])
def test_the_slow_end_of_the_spectrum_is_in_the_mean_square(order: float, coefficient: float) -> None:
    """Below order 1/2 by little a share of the mean square is of frequencies that no number resolves."""
    pot = sp.Springpot(order, coefficient)
    found = sp.theory.linear(sp.System(pot, sp.WhiteNoise(1.0))).x_mean_square
    # <x^2> = q / pi times the integral of 1 / |C (iw)^a - w^2|^2, a multiple of C^(-3 / (2 - a)); w = u^(1 / (1 - 2 a))
    power = 1.0 / (1.0 - 2.0 * order)

    def below(u: float) -> float:
        w = u**power
        return power / abs(coefficient * 1j**order - w ** (2.0 - order)) ** 2

    def above(w: float) -> float:
        return 1.0 / abs(coefficient * (1j * w) ** order - w * w) ** 2

    cut = 1e-3
    low = integrate.quad(below, 0.0, cut ** (1.0 / power), epsrel=1e-11)[0]
    places = np.geomspace(cut, 1e4, 60)
    high = sum(integrate.quad(above, a, b, epsrel=1e-11)[0] for a, b in pairwise(places))
    assert found == pytest.approx((low + high) / math.pi, rel=2e-7)


def test_a_springpot_in_series_and_two_springpots() -> None:
    """The slow motion is that of the springpot; beside another one, of both."""
    arm = sp.FractionalMaxwell(sp.Springpot(0.3, 2.0), sp.Spring(5.0))
    pots = sp.Springpot(0.3, 2.0), sp.Springpot(0.42, 1.0)
    for parts in ((arm,), pots, (arm, sp.Dashpot(0.1))):
        found = sp.theory.linear(sp.System(*parts, sp.WhiteNoise(1.0))).x_mean_square
        exact = mean_square(lambda p, own=parts: sum(part.modulus(p) for part in own), 1.5)
        assert found == pytest.approx(exact, rel=1e-5)


def test_from_order_one_half_on_there_is_none() -> None:
    for pot in (
        sp.Springpot(0.5, 1.0),
        sp.Springpot(0.8, 1.0),
        sp.FractionalMaxwell(sp.Springpot(0.6, 1.0), sp.Spring(1.0)),
    ):
        found = sp.theory.linear(sp.System(pot, sp.WhiteNoise(1.0)))
        assert found.stationary == (
            "There is no stationary state: no spring pulls the mass back, and a springpot alone does so below "
            "order 1/2 only, so that it wanders without end."
        )
        with pytest.raises(NoStationaryStateError):
            _ = found.x_mean_square
    dashed = sp.theory.linear(sp.System(sp.Dashpot(1.0), sp.WhiteNoise(1.0))).stationary
    assert dashed == "There is no stationary state: no spring pulls the mass back, so that it wanders without end."


def test_noise_without_a_density_at_zero_is_held_at_any_order() -> None:
    band = sp.SpectralExcitation((0.05, 0.4), (1.0, 1.0))
    found = sp.theory.linear(sp.System(sp.Springpot(0.7, 1.0), band))
    w = np.linspace(2.0 * np.pi * 0.05, 2.0 * np.pi * 0.4, 200_001)
    exact = np.trapezoid(1.0 / (2.0 * np.pi) / np.abs((1j * w) ** 0.7 - w * w) ** 2, w)  # one-sided 1 per Hz
    assert found.x_mean_square == pytest.approx(exact, rel=1e-6)
    assert isinstance(sp.theory.linear(sp.System(sp.Springpot(0.7, 1.0), band, sp.WhiteNoise(0.1))).stationary, str)


def test_what_a_springpot_alone_does_not_hold() -> None:
    pot = sp.Springpot(0.3, 1.0)
    held = sp.Springpot(0.3, 1.0, between=("ground", "a"))
    pushed = sp.theory.linear(pair(held, sp.WhiteNoise(1.0, on="b"), sp.Constant(0.2, on="b"))).stationary
    assert pushed == "There is no stationary state: a springpot alone yields to a constant force without end."
    hot = sp.theory.linear(sp.System(pot, sp.ThermalNoise(1.0))).stationary
    assert "thermal noise" in str(hot)


def pair(*parts: Any) -> sp.System:
    return sp.System(
        sp.Mass(2.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(3.0, between=("a", "b")),
        sp.Dashpot(0.2, between=("a", "b")), *parts,
    )  # fmt: skip


@pytest.mark.validation  # every day: one mass, in this file
def test_two_masses_of_which_a_springpot_holds_one() -> None:
    pot = sp.Springpot(0.3, 2.0, between=("ground", "a"))
    found = sp.theory.linear(pair(pot, sp.WhiteNoise(1.0, on="b")))

    def seen(u: float) -> tuple[float, float]:
        w = math.exp(u)
        p = 1j * w
        link = 3.0 + 0.2 * p
        own = np.array([[pot.coefficient * p**0.3 + link - 2.0 * w * w, -link], [-link, link - w * w]])
        a, b = np.linalg.solve(own, [0.0, 1.0])
        return w * abs(a) ** 2 / math.pi, w * abs(b - a) ** 2 / math.pi

    u = np.linspace(-70.0, 12.0, 400_001)
    a, between = np.trapezoid(np.array([seen(each) for each in u[::8]]), u[::8], axis=0)
    assert found.numbers["a_x_mean_square"] == pytest.approx(a, rel=1e-4)
    assert found.numbers["a_b_elongation_mean_square"] == pytest.approx(between, rel=1e-4)
    weak = sp.theory.linear(pair(sp.Springpot(0.6, 2.0, between=("ground", "a")), sp.WhiteNoise(1.0, on="b")))
    assert "no spring pulls a and b back, and a springpot alone does so below order 1/2 only" in str(weak.stationary)


def test_a_constant_force_within_the_pair_has_its_mean() -> None:
    """As the response to a force that grows slowly: the springpot that relaxes last has no force."""
    hung = sp.Springpot(0.3, 2.0, between=("ground", "a"))
    for more in ((), (sp.Springpot(0.45, 5.0, between=("ground", "b")),)):
        system = pair(hung, *more, sp.WhiteNoise(1.0, on="b"), sp.Constant(0.6, on="b"), sp.Constant(-0.6, on="a"))
        numbers = sp.theory.linear(system).numbers
        assert numbers["a_x_mean"] == pytest.approx(0.0, abs=1e-12)
        assert numbers["b_x_mean"] == pytest.approx(0.2)


def test_a_run_of_a_constant_loss_factor_is_stationary_at_once() -> None:
    """Of so small an order nothing is left of the start."""
    pot, _ = constant_loss()
    device = sp.System(sp.Mass(1.0), pot, sp.WhiteNoise(1.0))
    run, exact = sp.simulate(device, paths=2000, seed=1, duration=40.0), sp.theory.linear(device)
    assert run.settings.start == "stationary"
    assert [message.name for message in run.warnings] == []
    for name in ("x_mean_square", "v_mean_square"):
        found = run[name]
        assert abs(found.value - getattr(exact, name)) < 4.0 * found.error
        assert found.error < 0.005 * found.value


def test_a_run_says_what_a_springpot_remembers_of_its_start() -> None:
    """From an empty memory it lacks q times the integral of h^2 from then on; without noise at frequency 0, nothing."""
    device = sp.System(sp.Mass(1.0), sp.Springpot(0.42, 1.0), sp.WhiteNoise(1.0))
    run, exact = sp.simulate(device, paths=1000, seed=1), sp.theory.linear(device)
    (message,) = (each for each in run.warnings if each.name == "springpot_holds_alone")
    said = float(message.split("lacks about ")[1].split(" %")[0]) / 100.0
    lacking, error = 1.0 - run["x_mean_square"].value / exact.x_mean_square, run["x_mean_square"].error
    assert said == pytest.approx(lacking, abs=4.0 * error / exact.x_mean_square + 0.02)
    assert 0.2 < said < 0.35


def test_runs_of_what_nothing_holds_are_refused_or_said() -> None:
    needed = "^system must have a spring, or a wall on each side: without them nothing holds"
    for parts in ((sp.Springpot(0.6, 1.0),), (sp.Springpot(0.3, 1.0), sp.Barrier(-1.0))):
        with pytest.raises(ValueError, match=needed):
            sp.simulate(sp.System(*parts, sp.WhiteNoise(1.0)), paths=64, duration=1.0)
    for order, more in ((0.6, ()), (0.3, (sp.Constant(0.1, on="b"),))):
        loose = pair(sp.Springpot(order, 2.0, between=("ground", "a")), sp.WhiteNoise(1.0, on="b"), *more)
        assert motion_of(loose).not_stationary == "no spring or wall keeps a and b near the ground"


def test_a_run_of_two_masses_says_what_a_springpot_remembers() -> None:
    """What it lacks is that of the linear theory, for each mass."""
    held = pair(sp.Springpot(0.36, 2.0, between=("ground", "a")), sp.WhiteNoise(1.0, on="b"))
    run, exact = sp.simulate(held, paths=3000, seed=1), sp.theory.linear(held).numbers
    (message,) = (each for each in run.warnings if each.name == "springpot_holds_alone")
    name, said = message.split()[0], float(message.split("lacks about ")[1].split(" %")[0]) / 100.0
    lacking, error = 1.0 - run[name].value / exact[name], run[name].error / exact[name]
    assert said == pytest.approx(lacking, abs=4.0 * error + 0.3 * said)
    assert said > 0.03
    for name in ("a_b_elongation_mean_square", "a_v_mean_square", "b_v_mean_square"):
        assert abs(run[name].value - exact[name]) < 4.0 * run[name].error + 0.005 * exact[name]


def test_a_spectrum_gives_back_its_numbers_and_a_record_says_to_take_it() -> None:
    w = 2.0 * np.pi * np.geomspace(0.01, 2.0, 60)
    truth = sp.theory.linear(sp.System(sp.Springpot(0.2, 1.0), sp.WhiteNoise(1.0)))
    density = 4.0 * np.pi * truth.spectrum(w) * np.random.default_rng(1).gamma(50.0, 1.0 / 50.0, w.size)
    model = sp.System(
        sp.Springpot(sp.free("order", 0.3, (0.02, 0.48)), sp.free("C", 2.0, (0.1, 10.0))),
        sp.WhiteNoise(sp.free("q", 0.5, (0.01, 10.0))),
    )
    found = sp.fit(model, sp.MeasuredSpectrum(w / (2.0 * np.pi), density, averages=50))
    for name, value in {"order": 0.2, "C": 1.0, "q": 1.0}.items():
        assert abs(found.values[name] - value) < 4.0 * found.errors[name]
    record = sp.MeasuredRecord(0.1 * np.arange(400), np.sin(0.1 * np.arange(400)), noise=1e-3)
    with pytest.raises(
        ValueError, match=r"^model must have a spring that holds the mass for a record: fit data.spectrum"
    ):
        sp.fit(model, record)


def test_rare_levels_have_the_rates_of_a_gaussian_motion() -> None:
    exact = sp.theory.linear(sp.System(sp.Springpot(0.2, 1.0), sp.WhiteNoise(1.0)))
    rates = sp.theory.exceedance(exact.system, {"x": [3.0]})["x"]
    apart = np.sqrt(exact.v_mean_square / exact.x_mean_square) / (2.0 * np.pi)
    assert rates.crossing_rate == pytest.approx(apart, rel=1e-6)
    beyond = apart * np.exp(-0.5 * 9.0 / exact.x_mean_square)
    assert rates.rate["rice"][0] == pytest.approx(beyond, rel=1e-6)
