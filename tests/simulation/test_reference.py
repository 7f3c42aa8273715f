"""The kernel takes the steps of the reference, for every part and law: the same normals give the same paths."""

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.paths.simulation import Ensemble, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.result.results import Run
from tests.reference import Path, walk, walk_as_printed
from tests.sizes import validation

from .systems import of_many_kinds

PATHS, STEPS, STEP, SEED = 3, 2000, 0.05, 5
DOUBLE = 1e-10  # relative error of the memory, with which all is in double precision
ROUNDING = 2e-6  # of the normals, which the kernel has in single precision, over the size of the motion
APART = 5e-3  # what becomes of it in 2,000 steps where impacts and bent springs pull neighbouring paths apart
START = {"a": 0.4, "b": 0.3}
WORDS = 16  # counter word of the first excitation that is not white

A, AB = ("ground", "a"), ("a", "b")
SHAKEN = sp.RecordedExcitation(np.linspace(0.0, 60.0, 300), np.sin(np.linspace(0.0, 60.0, 300) ** 1.2), on="ground")


def pushed(t: float, x: float, v: float) -> float:
    """A force of the user."""
    return -0.3 * x * x * x - 0.1 * v * abs(v) + 0.1 * t**0.5


OF_TWO: dict[str, tuple[Any, ...]] = {
    "springs": (),
    "springpot": (sp.Springpot(0.4, 0.5, between=A), sp.Dashpot(0.2, between=AB)),
    "two springpots": (sp.Springpot(0.1, 0.5, between=AB), sp.Springpot(0.8, 0.3, between=AB)),
    "Maxwell": (sp.Maxwell(0.8, 0.5, between=A), sp.Springpot(0.2, 0.3, between=A)),
    "cubic": (sp.PolynomialSpring((0.2, 0.1, 0.3), between=AB), sp.Constant(0.2, on="b")),
    "fifth power": (sp.PolynomialSpring((0.0, 0.0, 0.0, 0.0, 0.02), between=A),),
    "friction": (sp.Friction(0.2, between=A),),
    "polynomial dashpot": (sp.PolynomialDashpot((0.1, 0.2, 0.3), between=AB),),
    "van der Pol": (sp.VanDerPol(0.4, 0.5, between=A),),
    "dampers of three kinds": (
        sp.Friction(0.1, between=A), sp.VanDerPol(0.4, 0.5, between=A), sp.PolynomialDashpot((0.0, 0.2), between=AB),
    ),
    "Jenkins": (sp.Jenkins(0.9, 0.3, between=A),),
    "Bouc-Wen": (sp.BoucWen(0.9, 0.3, between=A),),
    "Bouc-Wen, n = 2": (sp.BoucWen(0.9, 0.3, 2.0, 0.7, between=AB),),
    "Bouc-Wen, n = 2.5": (sp.BoucWen(0.9, 0.3, 2.5, 0.7, between=AB),),
    "wall": (sp.Springpot(0.4, 0.5, between=A), sp.Barrier(-0.3, 0.7, between=A)),
    "wall above": (sp.Barrier(0.4, 0.8, between=AB, free_side="below"), sp.Constant(0.2, on="b")),
    "two walls of one row": (sp.Barrier(-0.6, 0.5, between=A), sp.Barrier(0.9, 0.6, between=A, free_side="below")),
    "walls of two rows": (sp.Barrier(-0.3, 1.0, between=A), sp.Barrier(-0.2, 0.6, between=AB)),
    "restitution by speed": (
        sp.Barrier(-0.3, sp.PowerRestitution(0.8, 0.5, 0.25), between=A), sp.Barrier(-0.5, 0.6, between=AB),
    ),
    "contact": (sp.Contact(-0.3, 20.0, between=A),),
    "contact of Hertz that dissipates": (sp.Contact(-0.3, 20.0, 1.5, 0.4, between=A),),
    "multiplied noise": (sp.ParametricNoise(0.2, between=A),),
    "harmonic": (sp.Harmonic(0.8, 1.3, on="b"),),
    "harmonic and wall": (sp.Harmonic(0.8, 1.3, on="b"), sp.Barrier(-0.3, 0.7, between=A)),
    "Poisson": (sp.PoissonImpulses(2.0, 0.4, on="b"),),
    "record": (SHAKEN,),
    "three sources": (SHAKEN, sp.Harmonic(0.8, 1.3, on="b"), sp.PoissonImpulses(2.0, 0.4, on="a")),
}  # fmt: skip

ONE: dict[str, sp.System] = {
    "paper": sp.Oscillator(),
    "gap": sp.Oscillator(barrier=sp.Barrier(-0.4, 0.7)),
    "preload": sp.Oscillator(barrier=sp.Barrier(0.4, 0.7, free_side="above")),
    "below": sp.Oscillator(barrier=sp.Barrier(0.8, 0.7, free_side="below")),
    "free": sp.Oscillator(barrier=None),
    "two walls": sp.System(
        sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0), sp.PolynomialSpring((0.0, 0.0, 0.3)),
        sp.Barrier(-0.5, 0.7), sp.Barrier(0.6, 0.6, free_side="below"),
    ),
    "many kinds": of_many_kinds(
        sp.Spring(1.0), sp.Springpot(0.5, 0.5), sp.WhiteNoise(1.0), sp.ParametricNoise(0.1), sp.VanDerPol(0.1, 0.5),
        sp.PolynomialDashpot((0.0, 0.0, 0.1)), sp.Barrier(-0.4, 0.7),
    ),
}  # fmt: skip


SINES = sp.Harmonic(2.5, 1.7), sp.Harmonic(3.0, 4.1)
RESTING: dict[str, tuple[float, tuple[Any, ...]]] = {
    "preload": (1.0, (*SINES, sp.Barrier(1.0, 0.5, free_side="above"))),
    "light losses": (1.0, (*SINES, sp.Barrier(1.0, 0.9, free_side="above"))),
    "plastic": (1.0, (*SINES, sp.Barrier(1.0, 0.0, free_side="above"))),
    "gap": (0.0, (*SINES, sp.Barrier(-0.1, 0.5))),
    "plastic with a gap": (0.0, (*SINES, sp.Barrier(-0.1, 0.0))),
    "below": (-1.0, (*SINES, sp.Barrier(-1.0, 0.5, free_side="below"))),
    "springpot": (1.0, (*SINES, sp.Springpot(1.0, 0.5), sp.Barrier(1.0, 0.5, free_side="above"))),
    "record": (0.5, (SHAKEN, sp.Barrier(0.5, 0.5, free_side="above"))),
    "slot": (1.0, (*SINES, sp.Barrier(1.0, 0.5, free_side="above"), sp.Barrier(1.05, 0.7, free_side="below"))),
    "weight": (0.0, (
        *SINES, sp.PolynomialSpring((1e-9, 0.0, 0.5)), sp.Constant(-4.0), sp.Barrier(-0.5, 0.5, free_side="above"),
    )),
    "law": (1.0, (*SINES, sp.Barrier(1.0, sp.PowerRestitution(0.5, 1.0), free_side="above"))),
    "yielding": (1.0, (*SINES, sp.Jenkins(4.0, 0.4), sp.Barrier(1.0, 0.5, free_side="above"))),
    "friction": (1.0, (*SINES, sp.Friction(0.4), sp.Barrier(1.0, 0.5, free_side="above"))),
}  # fmt: skip

PRESSED = sp.Constant(-9.81, on="a"), sp.Constant(-4.905, on="b")
LIFTED = sp.Harmonic(8.0, 3.0, on="b"), sp.Harmonic(9.0, 1.7, on="a")
PILE = sp.Barrier(0.0, 0.6, free_side="above", between=A), sp.Barrier(0.0, 0.6, free_side="above", between=AB)
PILES: dict[str, tuple[Any, ...]] = {
    "floor": (*PRESSED, *LIFTED, sp.Spring(3.0, between=AB), PILE[0]),
    "pile": (*PRESSED, *LIFTED, *PILE),
    "plastic": (*PRESSED, *LIFTED, *(sp.Barrier(0.0, 0.0, free_side="above", between=ends) for ends in (A, AB))),
    "springpot": (*PRESSED, *LIFTED, sp.Springpot(0.5, 0.5, between=AB), *PILE),
    "friction": (*PRESSED, *LIFTED, sp.Friction(0.5, between=A), *PILE),
    "record": (
        *PRESSED, SHAKEN, PILE[0], sp.Barrier(0.0, sp.PowerRestitution(0.6, 0.5), free_side="above", between=AB),
    ),
}  # fmt: skip


def two_masses(*parts: Any) -> sp.System:
    """Unlike ones, with noise of their own and of the ground."""
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.3, between=A), sp.Spring(0.7, between=AB),
        sp.WhiteNoise(1.0, on="a"), sp.WhiteNoise(0.3, on="ground"), *parts,
    )  # fmt: skip


def largest_deviation(run: Run | Ensemble, path: int, by_hand: Path) -> float:
    """Of the displacements of all masses, over their root mean square."""
    masses = by_hand.x.shape[1]
    found = run.record[path].reshape(STEPS + 1, -1, 2)[:, :masses, 0]
    return float((np.abs(found - by_hand.x) / np.sqrt((by_hand.x**2).mean(axis=0))).max())


def _run(system: sp.System, start: Any, paths: int = PATHS, **given: Any) -> Run:
    return sp.simulate(
        system, paths=paths, duration=STEP * STEPS, step=STEP, window=(0.0, STEP * STEPS), record=paths, start="rest",
        initial_position=start, memory_tolerance=DOUBLE, seed=SEED, **given,
    )  # fmt: skip


def _turning(system: sp.System, **given: Any) -> tuple[float, Ensemble]:
    """The frequency at which one mass turns, 0 where it flies straight, and its paths."""
    plan = plan_of(
        system, paths=PATHS, duration=STEP * STEPS, step=STEP, record=PATHS, start="rest", initial_position=0.6,
        memory_tolerance=DOUBLE, seed=SEED, **given,
    )  # fmt: skip
    simulation = simulation_of(plan)
    turns = simulation.parts.tables.count("turns")
    return turns * plan.motion.scales.flight_frequency, simulation.advance()


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize("name", OF_TWO)
def test_two_masses(name: str) -> None:
    system = two_masses(*OF_TWO[name])
    run, start = _run(system, START), np.array([0.4, 0.3])
    short = simulation_of(plan_of(system, paths=PATHS, duration=STEP * STEPS, step=STEP, start="rest")).substeps
    for path in range(PATHS):
        by_hand = walk(system, STEP, STEPS, seed=SEED, path=path, words=WORDS, x=start, substeps=short)
        bent = by_hand.impacts or any(not part.is_odd or part.is_bent for part in system.elements.values())
        assert largest_deviation(run, path, by_hand) < (APART if bent else ROUNDING)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
def test_impacts_of_two_masses() -> None:
    """Their number, speeds and momentum at each wall."""
    system = two_masses(*OF_TWO["walls of two rows"])
    run = _run(system, START, paths=1)
    impacts = walk(system, STEP, STEPS, seed=SEED, words=WORDS, x=np.array([0.4, 0.3])).impacts
    for wall in ("barrier_1", "barrier_2"):
        own = [each for each in impacts if each.wall == wall]
        assert len(own) > 20
        assert run[f"{wall}_impact_rate"].value * STEP * STEPS == pytest.approx(len(own), rel=1e-12)
        assert run[f"{wall}_impact_speed_mean"].value == pytest.approx(np.mean([each.speed for each in own]), rel=1e-4)
        momentum = sum(each.momentum for each in own) / (STEP * STEPS)
        assert run[f"{wall}_force_mean"].value == pytest.approx(momentum, rel=1e-4)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.validation
def test_a_force_of_the_user() -> None:
    system = two_masses(sp.Force(pushed, between=A))
    run = _run(system, START)
    by_hand = walk(system, STEP, STEPS, seed=SEED, path=1, words=WORDS, x=np.array([0.4, 0.3]))
    assert largest_deviation(run, 1, by_hand) < ROUNDING


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize(
    "name", ["paper", "gap", "preload", "below", "free", validation("two walls"), validation("many kinds")]
)  # fmt: skip
def test_one_mass(name: str) -> None:
    """Which turns between the kicks, unless it has contacts."""
    flight, ensemble = _turning(ONE[name])
    for path in range(PATHS):
        by_hand = walk(ONE[name], STEP, STEPS, seed=SEED, path=path, words=WORDS, flight=flight, x=0.6)
        assert largest_deviation(ensemble, path, by_hand) < (
            APART if name in ("two walls", "many kinds") else 10.0 * ROUNDING
        )


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize("derivative", ["caputo", "riemann-liouville"])
@pytest.mark.parametrize("wall", [None, -0.4])
@pytest.mark.parametrize("order", [0.5, 1.0])
def test_the_papers_scheme(order: float, wall: float | None, derivative: Any) -> None:
    """At order 1 as well, where its memory is one weight of the newest increment."""
    barrier = None if wall is None else sp.Barrier(wall, 0.7)
    system = sp.Oscillator(1.0, sp.Springpot(order, 0.3), barrier, sp.WhiteNoise(1.0))
    run = _run(system, 0.6, scheme="grunwald", derivative=derivative)
    remembered, struck = 0.6 if derivative == "riemann-liouville" else 0.0, 0
    for path in range(PATHS):
        by_hand = walk_as_printed(system, STEP, STEPS, seed=SEED, path=path, x=0.6, remembered=remembered)
        struck += len(by_hand.impacts)
        assert largest_deviation(run, path, by_hand) < (APART if wall else ROUNDING)
    if wall:
        assert run["impact_rate"].value * STEP * STEPS * PATHS == pytest.approx(struck)
        assert struck > 50


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize(("order", "noise"), [(0.5, 1.0), (1.0, 1.0), (0.5, 0.0)])
def test_what_springpots_remember_of_a_jump(order: float, noise: float) -> None:
    """Riemann and Liouville's derivative."""
    system = sp.Oscillator(1.0, sp.Springpot(order, 0.3), sp.Barrier(-0.4, 0.7), sp.WhiteNoise(noise))
    flight, ensemble = _turning(system, derivative="riemann-liouville")
    for path in range(PATHS):
        by_hand = walk(system, STEP, STEPS, seed=SEED, path=path, x=0.6, flight=flight, remembered=0.6)
        assert largest_deviation(ensemble, path, by_hand) < (10.0 * ROUNDING if noise else 1e-9)


def momenta(by_hand: Path, wall: str) -> float:
    """What a wall gave, in impacts and at rest."""
    return sum(each.momentum for each in (*by_hand.impacts, *by_hand.rest) if each.wall == wall)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize(
    "name", ["preload", "light losses", "plastic", "gap", "plastic with a gap", "below", "springpot",
             "yielding", "friction", validation("record"), validation("slot"), validation("weight"), validation("law")]
)  # fmt: skip
def test_rest_of_one_mass(name: str) -> None:
    """Its place at each step, and the mean force of its walls."""
    start, parts = RESTING[name]
    system = sp.System(sp.Spring(4.0), sp.Dashpot(0.1), *parts)
    run = _run(system, start, paths=1)
    by_hand = walk(system, STEP, STEPS, seed=SEED, words=WORDS, x=start, flight=2.0)
    assert largest_deviation(run, 0, by_hand) < ROUNDING
    assert len(by_hand.rest) >= 20
    for wall in (each for each, part in system.named() if isinstance(part, sp.Barrier)):
        # the last half of a drift is beyond the window
        own = run[f"{wall}_force_mean"].value * STEP * STEPS
        assert own == pytest.approx(momenta(by_hand, wall), abs=0.3 + 1e-3 * own)


@pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")
@pytest.mark.parametrize("name", PILES)
def test_rest_of_two_masses(name: str) -> None:
    """On a floor, and on one another."""
    dashpots = sp.Dashpot(0.1, between=A), sp.Dashpot(0.1, between=("ground", "b"))
    system = sp.System(sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), *dashpots, *PILES[name])
    start = {"a": 0.3, "b": 0.6}
    run = _run(system, start, paths=1)
    by_hand = walk(system, STEP, STEPS, seed=SEED, words=WORDS, x=np.array([*start.values()]))
    assert largest_deviation(run, 0, by_hand) < ROUNDING
    assert len(by_hand.rest) > 500
    for wall in (each for each, part in system.named() if isinstance(part, sp.Barrier)):
        own = run[f"{wall}_force_mean"].value * STEP * STEPS
        assert own == pytest.approx(momenta(by_hand, wall), abs=0.7 + 1e-3 * own)
        energy = sum(each.energy for each in by_hand.rest if each.wall == wall)
        assert energy >= 0.0
