"""What is known of a motion before it is simulated is the same question for any number of masses."""

from __future__ import annotations

import inspect
from dataclasses import fields, replace
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.options import Options, hints
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.watch.requested import OBSERVERS

GROUND = "ground", "a"


def with_another(*parts: Any) -> sp.System:
    """The parts on a mass ``a``, beside one that has nothing to do with it."""
    on = {"between": GROUND}, {"on": "a"}
    places = [next((place for place in on if hasattr(part, *place)), {}) for part in parts]
    placed = [replace(part, **place) for part, place in zip(parts, places, strict=True)]
    other = sp.Spring(1.0, between=("ground", "b")), sp.Dashpot(0.1, between=("ground", "b"))
    return sp.System(sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), *placed, *other)


SYSTEMS: dict[str, tuple[Any, ...]] = {
    "weight": (sp.Spring(4.0), sp.Dashpot(0.1), sp.Constant(-9.0), sp.WhiteNoise(1.0)),
    "weight on a floor": (sp.Spring(4.0), sp.Dashpot(0.1), sp.Constant(-9.0), sp.Barrier(-1.0, 0.5)),
    "bent": (sp.Spring(4.0), sp.PolynomialSpring((0.0, 0.0, 3.0)), sp.Dashpot(0.1), sp.Constant(-9.0)),
    "preload": (sp.Spring(4.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0), sp.Barrier(0.5, 0.7, "above")),
    "lossy": (sp.Spring(4.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0), sp.Barrier(-0.5, 0.7)),
    "two walls": (
        sp.Spring(4.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0), sp.Barrier(-0.5), sp.Barrier(0.7, free_side="below"),
    ),
    "plastic": (sp.Spring(4.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0), sp.Barrier(-0.5, 0.1)),
    "smooth": (sp.Spring(4.0), sp.Dashpot(0.2), sp.ColoredNoise(1.0, 0.5), sp.Barrier(-0.5, 0.7)),
    "impulses": (sp.Spring(4.0), sp.Dashpot(0.2), sp.PoissonImpulses(1.0, 2.0), sp.Barrier(-0.5, 0.7)),
    "shaken spring": (sp.Spring(4.0), sp.Dashpot(0.2), sp.ParametricNoise(0.3), sp.ColoredNoise(1.0, 0.5),
                      sp.Barrier(-0.5, 0.7)),
    "warm": (sp.Spring(4.0), sp.Dashpot(0.2), sp.ThermalNoise(0.6), sp.Barrier(-0.5)),
    "nothing moves": (sp.Spring(4.0), sp.Dashpot(0.2)),
    "self-excited": (sp.Spring(4.0), sp.VanDerPol(0.2, 1.0)),
    "alone": (sp.Springpot(0.3, 1.0), sp.WhiteNoise(1.0)),
}  # fmt: skip


def own(names: Any) -> set[str]:
    """Results of ``a``, and of walls, by the names that they have alone."""
    return {name.removeprefix("a_") for name in names if not name.startswith("b_")}


def pair_of(name: str) -> tuple[Motion, Motion]:
    return motion_of(sp.System(*SYSTEMS[name])), motion_of(with_another(*SYSTEMS[name]))


@pytest.mark.parametrize("name", SYSTEMS)
def test_one_mass_is_the_case_of_one_row(name: str) -> None:
    """Where it rests, what has no mean, its walls, the noise at them and why there is no stationary state: the same."""
    alone, beside = pair_of(name)
    assert alone.rest[0] == pytest.approx(beside.rest[0], abs=1e-12)
    assert own(alone.zeros) == own(zero for zero in beside.zeros)
    assert alone.rested_on == beside.rested_on
    assert alone.not_stationary == beside.not_stationary
    assert alone.is_thermal == beside.is_thermal
    assert [pot.order for pot in alone.held_by] == [pot.order for pot in beside.held_by]
    for wall, struck in alone.struck_alone.items():
        assert struck.intensity == pytest.approx(beside.struck_alone[wall].intensity, rel=0.02)  # the size is a guess
        assert struck.restitution == beside.struck_alone[wall].restitution
        reasons = [motion.uncounted_because(f"{wall}_impact_rate") for motion in (alone, beside)]
        assert reasons[0] == reasons[1]
        of_speed = [motion.slowest_restitutions(f"{wall}_impact_rate", 0.01) for motion in (alone, beside)]
        assert of_speed[0] == pytest.approx(of_speed[1], rel=1e-3)


@pytest.mark.parametrize("make", [lambda *parts: sp.System(*parts), with_another])
def test_a_run_from_rest_begins_in_equilibrium_or_on_the_wall_before_it(make: Any) -> None:
    """It began at 0 with one mass, which no text said; a wall ended even that."""
    names = "weight", "weight on a floor", "bent", "preload"
    starts = {name: motion_of(make(*SYSTEMS[name])).rest[0] for name in names}
    bent = starts["bent"]
    assert 4.0 * bent + 3.0 * bent**3 == pytest.approx(-9.0)
    assert starts == {"weight": -2.25, "weight on a floor": -1.0, "bent": bent, "preload": 0.5}


@pytest.mark.parametrize("make", [lambda *parts: sp.System(*parts), with_another])
def test_every_run_starts_stationary_if_it_can(make: Any) -> None:
    assert plan_of(make(*SYSTEMS["lossy"])).settings.start == "stationary"
    assert plan_of(make(sp.Spring(4.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0))).settings.start == "stationary"
    assert plan_of(make(*SYSTEMS["nothing moves"])).settings.start == "rest"


def test_a_start_from_boltzmanns_law_is_drawn_alike() -> None:
    """Of one mass from its potential, of several by draws that are kept: the same law, walls and all."""
    laws = [motion.drawn_about(motion.near_mean) for motion in pair_of("warm")]
    drawn = [law.drawn(np.random.Generator(np.random.Philox(7)), 40_000) for law in laws if law is not None]
    assert [x.shape[1] for x, _ in drawn] == [1, 2]
    (x, v), (others, speeds) = drawn
    for one, other in ((x[:, 0], others[:, 0]), (v[:, 0], speeds[:, 0])):
        assert one.mean() == pytest.approx(other.mean(), abs=4.0 * one.std() * (2.0 / one.size) ** 0.5)
        assert one.var() == pytest.approx(other.var(), rel=0.03)
    assert min(x.min(), others[:, 0].min()) >= -0.5


@pytest.mark.parametrize("name", ["two springpots", "arm", "alone"])
def test_slow_displacements_are_those_of_all_parts_with_memory(name: str) -> None:
    """One mass took each springpot for an oscillator of its own, and an arm with a springpot for no memory at all."""
    parts = {
        "two springpots": (sp.Spring(1.0), sp.Springpot(0.4, 0.5), sp.Springpot(0.7, 1.0), sp.WhiteNoise(1.0)),
        "arm": (sp.Spring(1.0), sp.FractionalMaxwell(sp.Springpot(0.4, 3.0), sp.Spring(2.0)), sp.WhiteNoise(1.0)),
        "alone": SYSTEMS["alone"],
    }[name]
    (alone,), (beside,) = motion_of(sp.System(*parts)).slow, motion_of(with_another(*parts)).slow
    for time in (20.0, 200.0, 2000.0):
        lacking = alone.missing(time)["x_mean_square"]
        assert lacking > 1e-8 * alone.free["x_mean_square"]
        assert lacking == pytest.approx(beside.missing(time)["a_x_mean_square"], rel=1e-6)


def test_springs_that_hold_nothing_firmly_leave_the_start_at_rest() -> None:
    """A stiffness matrix that is singular up to rounding ended with an error of NumPy's."""
    springs = sp.Spring(0.3, between=("a", "b")), sp.Spring(0.33, between=("b", "c"))
    masses = (sp.Mass(1.0, at=point) for point in "abc")
    noise = sp.WhiteNoise(1.0, on="a")
    loose = sp.System(*masses, *springs, sp.Dashpot(0.1, between=GROUND), sp.Constant(0.3, on="b"), noise)
    assert motion_of(loose).rest.tolist() == [0.0] * 3


def test_what_no_force_with_a_mean_moves_is_0_and_a_function_may_have_one() -> None:
    """That of one mass under a function of the user was said to have none."""
    pushed = sp.Spring(1.0), sp.Dashpot(0.1), sp.WhiteNoise(1.0), sp.Force(lambda t, x, v: 1.0)
    assert motion_of(sp.System(*pushed[:3])).zeros == ("x_mean",)
    assert motion_of(sp.System(*pushed)).zeros == ()


def test_noise_that_multiplies_x_makes_slow_impacts_where_the_wall_is() -> None:
    """Of intensity q x^2.  One mass took such noise for none there: a rate 12 % too low gave no warning, and `rtol`
    took steps four times as short.
    """
    shaken = sp.System(sp.Spring(1.0), sp.Dashpot(0.6), sp.ParametricNoise(0.4), sp.Barrier(-0.5, 0.5))
    assert motion_of(shaken).completed[""].intensity == pytest.approx(0.4 * 0.25)
    elastic = sp.System(sp.Spring(1.0), sp.Dashpot(0.6), sp.ParametricNoise(0.4), sp.Barrier(-0.5))
    assert motion_of(elastic).completed == {}


@pytest.mark.parametrize("many", [False, True])
def test_a_mean_square_that_is_0_but_for_its_error_is_no_speed(many: bool) -> None:
    """A pile at rest has v = 0, and what paired runs make of it lies below 0 as often as above it."""
    parts = sp.Spring(4.0), sp.Dashpot(0.1), sp.Constant(-9.0), sp.Barrier(-1.0, 0.5)
    motion = motion_of(with_another(*parts) if many else sp.System(*parts))
    (name,) = motion.touched
    values = {f"{own}{which}": -1.0 if which == "_mean" else 1.0
              for own in motion.displacements for which in ("_mean", "_mean_square")}  # fmt: skip
    at_rest = {f"{own[:-1]}v_mean_square": -1e-6 for own in motion.displacements}
    before = motion.motions_before_walls(values | at_rest)[name]
    assert before.speed == 0.0


def test_simulate_has_every_option_with_its_type_and_default() -> None:
    """The options of a plan, the arguments that ask for observers, those of a tolerance, and the progress."""
    known = inspect.signature(sp.simulate).parameters
    options = {each.name: each.default for each in fields(Options)}
    assert {name: known[name].default for name in options} == options
    types = get_type_hints(inspect.unwrap(sp.simulate))
    assert {name: types[name] | None for name in options} == {name: get_args(hint)[0] for name, hint in hints().items()}
    assert known.keys() == {"system", *options, *OBSERVERS, "rtol", "quantities", "max_time", "progress"}
    assert all(each.kind == each.KEYWORD_ONLY for name, each in known.items() if name != "system")
    assert [*inspect.signature(sp.simulate_many).parameters] == ["systems", *[*known][1:]]
