"""Numbers that are to be found: parts keep them, everything else takes them for their start."""

from __future__ import annotations

import copy
import itertools
import json
import pickle
import tomllib
from typing import Any

import jsonschema
import numpy as np
import pytest

import springpot as sp
from springpot.machine.arguments import Free, Lost
from springpot.problem.file import read_system, schema, to_toml
from springpot.problem.free_numbers import free_numbers, restarted, uncertain_numbers, with_values
from springpot.simulation.monte_carlo import simulated
from springpot.theory import solve_all
from tests.sizes import validation


def marked() -> sp.System:
    order, coefficient = sp.free("order", 0.5, (0.1, 0.9)), sp.free("C", 1.2, (0.1, 10.0))
    return sp.System(
        sp.Mass(0.2), sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.Springpot(order, coefficient),
        sp.PolynomialSpring((0.0, 0.0, sp.free("k3", 4e5, (0.0, 1e6)))),
        sp.FractionalMaxwell(sp.Springpot(order, 0.3), sp.Spring(20.0)), sp.Barrier(-0.003, 0.7), sp.WhiteNoise(0.02),
    )  # fmt: skip


def test_parts_keep_what_is_free_in_order_and_once_for_each_name() -> None:
    found = free_numbers(marked())
    assert [*found] == ["k", "order", "C", "k3"]
    assert found["order"] == 0.5
    assert (found["C"].low, found["C"].high) == (0.1, 10.0)
    oscillator = sp.Oscillator(sp.free("w", 2.0, (1.0, 3.0)), sp.Springpot(0.5, sp.free("c", 1.0, (0.0, 2.0))))
    assert [*free_numbers(oscillator)] == ["w", "c"]
    assert free_numbers(sp.Oscillator()) == {}


def test_theory_and_simulation_take_the_start() -> None:
    free, fixed = (
        sp.Oscillator(2.0, sp.Springpot(sp.free("a", 0.4, (0.1, 0.9)), sp.free("c", 1.0, (0.5, 2.0)))),
        (sp.Oscillator(2.0, sp.Springpot(0.4, 1.0))),
    )
    assert free == fixed
    assert sp.theory.envelope(free).impact_rate == sp.theory.envelope(fixed).impact_rate
    found = [sp.simulate(each, paths=8, duration=2.0, seed=3).estimates for each in (free, fixed)]
    assert repr(found[0]) == repr(found[1])
    walls = sp.Barrier(-0.5), sp.Barrier(1.2, free_side="below")
    stiffening = sp.PolynomialSpring((0.0, 0.0, sp.free("k3", 1.0, (0.0, 2.0))))
    spring = sp.Spring(sp.free("k", 1.0, (0.5, 2.0)))
    system = sp.System(spring, stiffening, sp.Dashpot(0.4), *walls, sp.WhiteNoise(1.0))
    plain = with_values(system, {name: float(number) for name, number in free_numbers(system).items()})
    found = [sp.simulate(each, paths=8, duration=0.5, seed=3).estimates for each in (system, plain)]
    assert repr(found[0]) == repr(found[1])


def test_values_replace_free_numbers_wherever_they_stand() -> None:
    found = with_values(marked(), {"order": 0.3, "k3": 1.0})
    assert found.names == marked().names
    assert found.of(sp.Springpot)[0].order == found.of(sp.FractionalMaxwell)[0].springpot.order == 0.3
    assert found.of(sp.PolynomialSpring)[0].coefficients == (0.0, 0.0, 1.0)
    assert [*free_numbers(found)] == ["k", "C"]
    again = free_numbers(restarted(marked(), {"k": 90.0}))["k"]
    assert (again, again.high) == (90.0, 200.0)
    assert isinstance(again, Free)


def test_copies_and_files_keep_what_is_free() -> None:
    number = sp.free("k", 80.0, (10.0, 200.0))
    for same in (copy.copy(number), copy.deepcopy(number), pickle.loads(pickle.dumps(number))):
        assert repr(same) == "free('k', 80.0, (10.0, 200.0))"
    text = sp.to_toml(marked())
    assert "{ free = \"k\", start = 80.0, low = 10.0, high = 200.0 }" in text  # fmt: skip
    import tomllib

    content = tomllib.loads(text)
    jsonschema.validate(content, schema())
    again = sp.read_system(content)
    assert again == marked()
    assert repr(free_numbers(again)) == repr(free_numbers(marked()))
    assert json.loads(json.dumps(marked().to_dict()))["parts"][1]["stiffness"] == 80.0


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: sp.free("a b", 1.0, (0.0, 2.0)), "name must be a word of letters"),
        (lambda: sp.free("a", 3.0, (0.0, 2.0)), r"start must be in \[0, 2\], not 3. These are the bounds of a"),
        (lambda: sp.free("a", 1.0, (2.0, 0.0)), r"bounds must be in ascending order, not \(2, 0\)"),
        (lambda: sp.free("a", 1.0, 2.0), r"bounds must be two numbers, \(low, high\), not 2.0"),
        (lambda: sp.free("a", "1", (0.0, 2.0)), "start must be a real number, not '1'"),
        (lambda: sp.free("a", sp.free("b", 1.0, (0.0, 2.0)), (0.0, 2.0)), "start and bounds must be plain numbers"),
        (lambda: sp.Springpot(sp.free("a", 0.5, (0.0, 2.0)), 1.0), r"order must be in \[0, 1\], not 2. This is a "
         "bound of the free number a"),
        (lambda: sp.Barrier(0.0, sp.free("r", 0.5, (-0.1, 1.0))), r"restitution must be in \[0, 1\], not -0.1. This"),
        (lambda: sp.WhiteNoise.from_psd(sp.free("s", 0.5, (0.1, 1.0)), "g2/Hz"),
         "psd must be a plain number here, not the free number s: mark the intensity"),
        (lambda: free_numbers(sp.System(sp.Spring(sp.free("a", 1.0, (0.5, 2.0))),
                                        sp.Dashpot(sp.free("a", 1.5, (0.5, 2.0))))), "a must have the same start"),
        (lambda: with_values(marked(), {"ordre": 0.3}), "'ordre' is not a free number of the model: its free numbers "
         "are k, order, C and k3; did you mean order"),
        (lambda: with_values(marked(), {"order": 1.3}), r"springpot.order must be in \[0, 1\], not 1.3"),
        (lambda: restarted(marked(), {"order": 0.95}), r"springpot.start must be in \[0.1, 0.9\], not 0.95"),
        (lambda: sp.read_system({"parts": [{"kind": "spring", "stiffness": {"free": "k", "start": 1.0}}]}),
         r"parts\[0\] \(spring\).stiffness needs low and high"),
        (lambda: sp.read_system({"parts": [{"kind": "spring", "stiffness": {"free": "k", "start": 1.0, "low": 2.0,
                                                                            "high": 3.0}}]}),
         r"parts\[0\] \(spring\).stiffness.start must be in \[2, 3\], not 1"),
    ],
)  # fmt: skip
def test_what_cannot_be_free_is_one_sentence(make: Any, sentence: str) -> None:
    with pytest.raises((TypeError, ValueError), match=sentence):
        make()


def test_one_number_at_two_places() -> None:
    """A symmetric gap by one free number: -gap was silently a fixed number."""
    gap = sp.free("gap", 0.004, (0.001, 0.006))
    spring = sp.Spring(2.0 * sp.free("k", 4.0, (1.0, 9.0)))
    stops = sp.Barrier(-gap, 0.6), sp.Barrier(gap + 0.001, 0.6, free_side="below")
    device = sp.System(sp.Mass(2.0), spring, *stops, sp.WhiteNoise(1.0))
    assert {name: (float(n), n.low, n.high) for name, n in free_numbers(device).items()} == {
        "gap": pytest.approx((0.004, 0.001, 0.006)), "k": pytest.approx((4.0, 1.0, 9.0)),
    }  # fmt: skip
    for model in (device, read_system(tomllib.loads(to_toml(device)))):
        given = with_values(model, {"gap": 0.002, "k": 5.0})
        assert [wall.position for wall in given.of(sp.Barrier)] == pytest.approx([-0.002, 0.003], rel=1e-12)
        assert given.stiffness == 10.0
        moved = restarted(model, {"gap": 0.005})
        assert [wall.position for wall in moved.of(sp.Barrier)] == pytest.approx([-0.005, 0.006], rel=1e-12)
        assert set(free_numbers(moved)) == {"gap", "k"}


def test_a_multiple_of_a_free_number_is_fitted() -> None:
    """The derivatives know it: both springs are k."""
    k = sp.free("k", 50.0, (10.0, 500.0))
    model = sp.System(sp.Spring(k), sp.Spring(2.0 * k), sp.Springpot(0.3, sp.free("C", 10.0, (1.0, 100.0))))
    f = np.geomspace(0.1, 100.0, 30)
    modulus = 300.0 + 20.0 * (2j * np.pi * f) ** 0.3
    found = sp.fit(model, sp.MeasuredModuli(f, storage=modulus.real, loss=modulus.imag, relative_error=0.01))
    assert found.values["k"] == pytest.approx(100.0, rel=1e-6)


def test_a_sum_of_multiples_of_one_number_follows_it() -> None:
    c, d = sp.free("c", 2.0, (1.0, 3.0)), sp.free("d", 2.0, (1.0, 3.0))
    both = 0.5 * c + 1.0 + 2.0 * c
    assert (float(both), both.at(3.0), both.low, both.high) == (6.0, 8.5, 3.5, 8.5)
    assert (repr(c - c), (2.0 * c - 3.0 * c).at(3.0), (c**2 + 3.0 * c**2).at(3.0)) == ("0.0", -3.0, 36.0)
    for lost in (c + d, c + c**2, c * d, 40.0 / 0.3**c):
        with pytest.raises(ValueError, match=r"stiffness cannot follow c.* through this expression: only sums with"):
            sp.Spring(lost)


@pytest.mark.parametrize("kind", ["springpots and walls", validation("yielding"), "bent and soft"])
def test_what_theory_and_runs_make_of_free_numbers_is_not_refused(kind: str) -> None:
    """Sums of parts have two free numbers, and stand in parts of other problems."""
    number = itertools.count()

    def free(value: float) -> Any:
        return sp.free(f"n{next(number)}", value, (0.9 * value, 1.1 * value))

    springs, dampers = (sp.Spring(free(6.0)), sp.Spring(free(2.0))), (sp.Dashpot(free(0.2)), sp.Dashpot(free(0.3)))
    walls = {"low": sp.Barrier(-free(0.5), free(0.8)), "high": sp.Barrier(free(0.5), free(0.8), free_side="below")}
    noise = sp.WhiteNoise(free(1.0)), sp.WhiteNoise(free(0.5))
    pots = sp.Springpot(0.5, free(0.2)), sp.Springpot(0.5, free(0.1))
    bent = sp.PolynomialSpring((0.0, 0.0, free(0.5)))
    yielding, soft = sp.BoucWen(free(2.0), free(0.3)), sp.Contact(-free(0.2), free(100.0), 1.5)
    more = {"springpots and walls": pots, "yielding": (yielding,), "bent and soft": (bent, soft)}[kind]
    stops = walls if kind == "springpots and walls" else {}
    system = sp.System(sp.Mass(free(2.0)), *springs, *dampers, *noise, *more, **stops)
    fixed = with_values(system, {name: float(own) for name, own in free_numbers(system).items()})
    answers, refused = solve_all(system)
    same, refused_too = solve_all(fixed)
    assert refused == refused_too
    assert {name: own.numbers for name, own in answers.items()} == {n: own.numbers for n, own in same.items()}
    given: dict[str, Any] = {"paths": 8, "duration": 2.0, "step": 0.02, "start": "rest"}
    assert simulated(system, **given)["v_mean_square"] == simulated(fixed, **given)["v_mean_square"]


@pytest.mark.parametrize("mark", [lambda name, at: sp.free(name, at, (0.5 * at, 2.0 * at)), sp.uncertain])
@pytest.mark.parametrize(
    "shaking",
    [
        lambda size: sp.WhiteNoise(size, on="ground"), lambda size: sp.ColoredNoise(size, 2.0, on="ground"),
        lambda size: sp.KanaiTajimiNoise(12.0, 0.6, size), lambda size: sp.PoissonImpulses(2.0, size, on="ground"),
        lambda size: sp.Harmonic(size, 2.0, on="ground"),
    ],
)  # fmt: skip
def test_a_marked_mass_is_shaken_by_a_marked_ground(mark: Any, shaking: Any) -> None:
    """Divided by the mass, the size of the noise would be an expression of two."""
    more = {"cov": 0.1} if mark is sp.uncertain else {}
    parts = sp.Mass(mark("m", 2.0, **more)), sp.Spring(mark("k", 8.0, **more)), sp.Dashpot(0.5)
    system = sp.System(*parts, shaking(mark("q", 0.3, **more)))
    fixed = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(0.5), shaking(0.3))
    for name in ("x_mean_square", "v_mean_square"):
        own = sp.theory.linear(system).numbers[name]
        assert own == pytest.approx(sp.theory.linear(fixed).numbers[name], rel=1e-12)


def test_numbers_of_one_name_that_differ_are_two() -> None:
    one, other = sp.free("k", 1.0, (0.5, 2.0)), sp.free("k", 3.0, (2.0, 5.0))
    assert type(one + other) is Lost
    assert float(one + other) == 4.0
    assert (repr(0.3 * one - 0.1 * one - 0.2 * one), one**1, abs(-one)) == ("0.0", one, one)
    assert [type(each) for each in (one // 2, 2 % one, abs(sp.free("x", 0.0, (-1.0, 1.0))))] == [Lost] * 3
    assert (one * np.int64(2)).at(1.5) == (one * np.float32(2.0)).at(1.5) == 3.0


def test_a_power_of_a_free_number_stays_free() -> None:
    """The spring of a free natural frequency: its stiffness was silently a fixed number."""
    w = sp.free("w", 3.0, (1.0, 4.0))
    stiffness = 2.0 * w**2
    assert (float(stiffness), stiffness.low, stiffness.high) == (18.0, 2.0, 32.0)
    assert (stiffness.slope, stiffness.at(4.0), stiffness.itself) == (12.0, 32.0, 3.0)
    assert [type(each) for each in (w**0, w**True)] == [float] * 2
    assert [type(each) for each in (w**w, (w + 1.0) ** 2, (-w) ** 2, 2.0**w, w * w)] == [Lost] * 5
    assert not isinstance(sp.free("x", 0.0, (-1.0, 1.0)) ** 2, Free)
    for same in (copy.deepcopy(stiffness), pickle.loads(pickle.dumps(stiffness))):
        assert repr(same) == repr(stiffness) == "2.0 * free('w', 3.0, (1.0, 4.0)) ** 2.0"
    device = sp.System(sp.Mass(2.0), sp.Spring(stiffness), sp.WhiteNoise(1.0))
    jsonschema.validate(tomllib.loads(to_toml(device)), schema())
    for model in (device, read_system(tomllib.loads(to_toml(device)))):
        assert free_numbers(model) == {"w": 3.0}
        assert with_values(model, {"w": 4.0}).stiffness == 32.0
        assert restarted(model, {"w": 4.0}).natural_frequency == 4.0


@pytest.mark.parametrize("numbers", ["power = 0", "low = 0, power = 2", "low = -1, power = 2"])
def test_a_power_that_cannot_be_is_one_sentence(numbers: str) -> None:
    low = "" if "low" in numbers else "low = 1, "
    spring = f'[[parts]]\nkind = "spring"\nstiffness = {{ free = "w", start = 3, high = 4, {low}{numbers} }}\n'
    with pytest.raises(ValueError, match=r"must not be 0|must be greater than 0 of a number with a power"):
        read_system(tomllib.loads(spring))


def test_a_square_of_a_free_number_is_fitted() -> None:
    """The derivatives know it."""
    spring = sp.Spring(sp.free("w", 2.0, (0.5, 9.0)) ** 2)
    model = sp.System(spring, sp.Springpot(0.3, sp.free("C", 10.0, (1.0, 100.0))))
    f = np.geomspace(0.1, 100.0, 30)
    modulus = 36.0 + 20.0 * (2j * np.pi * f) ** 0.3
    found = sp.fit(model, sp.MeasuredModuli(f, storage=modulus.real, loss=modulus.imag, relative_error=0.01))
    assert found.values["w"] == pytest.approx(6.0, rel=1e-6)


MARKS = [lambda name, value: sp.free(name, value, (0.9 * value, 1.1 * value)),
         lambda name, value: sp.uncertain(name, value, sd=0.01 * value)]  # fmt: skip


@pytest.mark.parametrize("mark", MARKS)
@pytest.mark.parametrize("marked_one", ["loss_factor", "stiffness", "frequency_hz"])
def test_both_parts_of_a_loss_factor_follow_the_number_that_is_marked(mark: Any, marked_one: str) -> None:
    given = {"order": 0.2, "loss_factor": 0.18, "stiffness": 40e3, "frequency_hz": 25.0}
    parts = sp.Springpot.from_loss_factor(**given | {marked_one: mark("a", given[marked_one])})
    moved = 1.05 * given[marked_one]
    found = [with_values(part, {"a": moved}) if {**free_numbers(part), **uncertain_numbers(part)} else part
             for part in parts]  # fmt: skip
    wanted = sp.Springpot.from_loss_factor(**given | {marked_one: moved})
    assert found[0].stiffness == pytest.approx(wanted[0].stiffness, rel=1e-12)
    assert found[1].coefficient == pytest.approx(wanted[1].coefficient, rel=1e-12)


@pytest.mark.parametrize("mark", MARKS)
@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda mark: sp.Springpot.from_loss_factor(mark("a", 0.2), 0.18, 40e3, 25.0),
         "order must be a plain number here, not the (free|uncertain) number a: the stiffness and the coefficient "
         "cannot follow it, so mark numbers of the parts themselves"),
        (lambda mark: sp.Springpot.from_loss_factor(0.2, mark("a", 0.18), mark("b", 40e3), 25.0),
         "stiffness must be a plain number here, .* number b: only one of the three"),
        (lambda mark: sp.KanaiTajimiNoise.from_rms(0.1, "g", frequency=mark("a", 15.0), damping=0.6),
         "frequency must be a plain number here, .* number a: only rms may be marked, or the numbers of KanaiTaj"),
        (lambda mark: sp.SpectralExcitation.from_psd((10, 200), mark("a", 0.1), "g2/Hz"), r"psd\[0\] must be a plain"),
        (lambda mark: sp.SpectralExcitation.from_slopes((20, 80), (3,), 0.04, "g2/Hz", at=mark("a", 30.0)),
         "at must be a plain .*: mark the scale instead"),
        (lambda mark: sp.SpectralExcitation.from_slopes((20, 80), (mark("a", 3.0),), 0.04, "g2/Hz", at=30.0),
         "slopes must be a plain"),
        (lambda mark: sp.Contact.dissipation_of(mark("a", 0.6), 0.3), "restitution must be a plain .* dissipation of"),
        (lambda mark: sp.Shift.wlf(mark("a", 8.86), 101.6, reference=20.0), "c1 must be a plain"),
        (lambda mark: sp.Shift.arrhenius(mark("a", 9e4), reference=20.0), "energy must be a plain"),
        (lambda mark: sp.Shift.table([0.0, 20.0], [mark("a", 4.0), 1.0]), "factors must be a plain"),
        (lambda mark: sp.Shift.wlf(8.86, 101.6, reference=20.0).at(mark("a", 40.0), sp.Dashpot(1.0)), "celsius must"),
        (lambda mark: sp.Shift.wlf(8.86, 101.6, reference=20.0).at(40.0, sp.Springpot(mark("a", 0.3), 2.0)),
         r"order must be a plain .*: C a\^order cannot follow it"),
        (lambda mark: sp.System.from_modes([mark("a", 6.0)], [2.0], {"top": [1.0]}), "frequencies must be a plain"),
        (lambda mark: sp.System.from_matrices([[2.0]], [[mark("a", 8.0)]]), "stiffness must be a plain"),
        (lambda mark: sp.sweep(mark("a", 1.0), "g", 5.0, 80.0, duration=2.0), "amplitude must be a plain"),
    ],
)  # fmt: skip
def test_what_cannot_follow_a_marked_number_is_refused(mark: Any, make: Any, sentence: str) -> None:
    """Before, it was made once at the nominal value, without a word."""
    with pytest.raises(ValueError, match=f"^{sentence}"):
        make(mark)
