"""Paths under a known input in neighbouring lanes: those of `simulate`, whatever the numbers of the others."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import springpot as sp
from springpot.machine.arrays import Floats
from springpot.problem.system import System
from springpot.simulation.paths.driven import Driven, driven_by, with_stub
from tests.sizes import thinned

STEP, SAMPLES, EVERY = 0.05, 240, 4
FORCE = 3.0 * np.convolve(np.random.default_rng(1).standard_normal(SAMPLES + 4), np.ones(5) / 5.0, "valid")
TIME = STEP * np.arange(SAMPLES)


def driven_system(kind: str, on: str = "mass", force: Floats = FORCE, mass: float = 1.0) -> System:
    parts = {
        "springpot": (sp.Spring(9.0 * mass), sp.Springpot(0.5, 0.8 * mass)),
        "cubic": (sp.Spring(9.0 * mass), sp.Dashpot(0.4 * mass), sp.PolynomialSpring((0.0, 0.3 * mass, 2.0 * mass))),
        "wall": (sp.Spring(9.0 * mass), sp.Dashpot(0.4 * mass), sp.Barrier(-0.1, 0.7)),
        "contact": (sp.Spring(9.0 * mass), sp.Dashpot(0.4 * mass), sp.Contact(-0.1, 200.0 * mass, 1.5)),
        "friction": (sp.Spring(9.0 * mass), sp.Dashpot(0.4 * mass), sp.Friction(0.2 * mass)),
    }[kind]
    drive = sp.RecordedExcitation(TIME, force, on, interpolation="band-limited")
    return sp.System(sp.Mass(mass), *parts, drive=drive)


def alone(system: System) -> Floats:
    run = sp.simulate(
        system, paths=1, record=1, duration=TIME[-1], step=STEP / EVERY, record_every=EVERY, start="rest", threads=1
    )
    return run.record[0]


def prepared(system: System, *forces: Floats, accelerates: bool = False) -> Driven:
    return driven_by(system, "drive", STEP, forces or (FORCE,), every=EVERY, accelerates=accelerates)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize(
    ("kind", "on", "mass"),
    thinned(
        itertools.product(
            ["springpot", "cubic", "wall", "contact", "friction"], ["mass", "ground"], [1.0, 5e-6, 300.0]
        ),
        4,
    ),
)
def test_a_path_is_that_of_a_simulation_bit_for_bit(kind: str, on: str, mass: float) -> None:
    force = FORCE * (mass if on == "mass" else 1.0)
    system = driven_system(kind, on, force, mass)
    stub = with_stub(system, "drive", STEP, (force,))
    path = prepared(system, force).paths([stub], np.zeros((1, 2)))
    assert np.array_equal(path[0, :, 0], alone(system))


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_lanes_have_their_own_numbers_starts_and_inputs() -> None:
    system = driven_system("wall")
    stub = with_stub(system, "drive", STEP, (FORCE, -FORCE))
    harder = sp.System(**{**dict(stub.stated()), "barrier": sp.Barrier(-0.05, 0.9)})
    driven = prepared(system, FORCE, -FORCE)
    starts = np.array([[0.0, 0.0], [0.0, 0.0], [0.2, 1.0], [0.2, 1.0]])
    whole = driven.paths([stub, stub, harder, harder], starts)
    for n, (other, force) in enumerate([(stub, FORCE), (stub, -FORCE), (harder, FORCE), (harder, -FORCE)]):
        one = with_stub(other, "drive", STEP, (force,))
        single = prepared(system, force).paths([one], starts[n : n + 1])
        np.testing.assert_allclose(whole[n], single[0], atol=1e-9)
        assert whole[n, 0, 0].tolist() == pytest.approx(starts[n].tolist())


def test_a_shorter_run_and_a_later_input() -> None:
    system = driven_system("springpot")
    stub = with_stub(system, "drive", STEP, (FORCE,))
    driven, rest = prepared(system), np.zeros((1, 2))
    whole = driven.paths([stub], rest)
    np.testing.assert_allclose(driven.first(100).paths([stub], rest), whole[:, :100], atol=1e-6)
    later = driven.delayed(STEP).paths([stub], rest)
    np.testing.assert_allclose(later[0, 1:], whole[0, :-1], atol=1e-9)


def test_accelerations_are_those_of_the_forces() -> None:
    system = driven_system("cubic")
    stub = with_stub(system, "drive", STEP, (FORCE,))
    x, v, a = prepared(system, accelerates=True).paths([stub], np.zeros((1, 2)))[0, :, 0].T
    forces = FORCE - 9.0 * x - 0.4 * v - 0.3 * x**2 - 2.0 * x**3
    assert np.sqrt(np.mean((a - forces)[1:-1] ** 2)) < 0.03 * a.std()  # a mean over two steps of a rough input


def test_small_changes_of_the_order_make_small_changes_of_the_path() -> None:
    def device(order: float) -> System:
        drive = sp.RecordedExcitation(TIME, FORCE, "mass")
        return with_stub(sp.System(sp.Spring(9.0), sp.Springpot(order, 0.8), drive=drive), "drive", STEP, (FORCE,))

    driven = prepared(device(0.5))
    paths = driven.paths([device(0.5 + shift) for shift in (0.0, 1e-6, 1e-3)], np.zeros((3, 2)))[:, :, 0, 0]
    small, large = (paths[1] - paths[0]) / 1e-6, (paths[2] - paths[0]) / 1e-3
    assert np.abs(small - large).max() < 0.01 * np.abs(large).max()


def test_the_memory_of_a_first_part_serves_the_whole() -> None:
    def device(order: float) -> System:
        drive = sp.RecordedExcitation(TIME, FORCE, "mass")
        return with_stub(sp.System(sp.Spring(9.0), sp.Springpot(order, 0.8), drive=drive), "drive", STEP, (FORCE,))

    pair, rest = [device(0.5), device(0.5 + 1e-6)], np.zeros((2, 2))
    driven = prepared(device(0.5))
    driven.first(32).paths(pair, rest)  # whose rates are kept
    np.testing.assert_array_equal(driven.paths(pair, rest), prepared(device(0.5)).paths(pair, rest))
