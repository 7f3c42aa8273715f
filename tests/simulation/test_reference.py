"""The kernel takes the steps of the reference, for every part and law: the same normals give the same paths.

With the kernel's own normals, which are in single precision, and its sums in double, both agree to rounding: so do all
sources of excitation, and what observers make of a path.
"""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.simulation.kernel.native import FILL_NORMALS, key_words
from springpot.simulation.monte_carlo import simulated
from springpot.simulation.paths.simulation import Ensemble, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.result.results import Run
from tests import reference_observers as observers
from tests.reference import Path, memory_of, walk, walk_as_printed
from tests.sizes import thinned, validation

from .systems import of_many_kinds

PATHS, STEPS, STEP, SEED = 3, 2000, 0.05, 5
ONE_OF_THEM = [PATHS - 1, *(validation(path) for path in range(PATHS - 1))]
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
    "ground noise": (0.3, (sp.KanaiTajimiNoise(3.0, 0.4, 8.0), sp.Barrier(0.3, 0.5, free_side="above"))),
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
@pytest.mark.parametrize("path", ONE_OF_THEM)
@pytest.mark.parametrize("name", OF_TWO)
def test_two_masses(name: str, path: int) -> None:
    system = two_masses(*OF_TWO[name])
    run, start = _run(system, START), np.array([0.4, 0.3])
    short = simulation_of(plan_of(system, paths=PATHS, duration=STEP * STEPS, step=STEP, start="rest")).substeps
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
@pytest.mark.parametrize("path", ONE_OF_THEM)
def test_one_mass(name: str, path: int) -> None:
    """Which turns between the kicks, unless it has contacts."""
    flight, ensemble = _turning(ONE[name])
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
             "yielding", "friction", "ground noise", validation("record"), validation("slot"), validation("weight"),
             validation("law")]
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
@pytest.mark.parametrize("name", thinned(PILES, 2))
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


# --- to rounding ---------------------------------------------------------------------------------------------------
CLOSE = 1e-9
SHAPED = 5e-6  # of a given density: its law of impulses is so ill-conditioned that two ways to solve it differ by 1e-6
SOONER = sp.JenningsHousnerEnvelope(2.0, 4.0, 0.5)
DENSITY = (0.5, 2.0, 8.0), (1.0, 2.0, 1.0)
GROUND = 3.0, 0.4

SOURCES: dict[str, tuple[Any, ...]] = {
    "white": (sp.WhiteNoise(1.0, on="ground"), sp.WhiteNoise(0.3, on="b")),
    "white with an envelope": (sp.WhiteNoise(0.3, on="b"), sp.WhiteNoise(1.0, on="ground", envelope=SOONER)),
    "multiplied": (sp.ParametricNoise(0.3, between=AB, envelope=SOONER), sp.ParametricNoise(0.3, between=A)),
    "Poisson": (sp.PoissonImpulses(2.0, 0.4, on="b"), sp.PoissonImpulses(2.0, 0.4, on="ground", envelope=SOONER)),
    "colored": (sp.ColoredNoise(1.0, 0.5, on="b"), sp.ColoredNoise(1.0, 0.01, on="ground")),
    "colored with an envelope": (sp.ColoredNoise(1.0, 0.5, on="ground", envelope=SOONER),),
    "Kanai-Tajimi": (sp.KanaiTajimiNoise(*GROUND, 1.0),),
    "Kanai-Tajimi that changes": (sp.KanaiTajimiNoise(*GROUND, 1.0, frequency_rate=-0.05, envelope=SOONER),),
    "Clough-Penzien": (sp.CloughPenzienNoise(*GROUND, 0.3, 0.6, 1.0, on="b"),),
    "Clough-Penzien that changes": (
        sp.CloughPenzienNoise(*GROUND, 0.3, 0.6, 1.0, frequency_rate=0.05, envelope=SOONER),
    ),
    "density": (sp.SpectralExcitation(*DENSITY),),
    "density with an envelope": (sp.SpectralExcitation(*DENSITY, on="b", envelope=SOONER),),
    "matched to springpots": (
        sp.Springpot(0.4, 0.5, between=A), sp.Springpot(0.2, 0.3, between=AB), sp.ThermalNoise(0.7),
    ),
    "matched": (sp.Maxwell(0.8, 0.5, between=A), sp.Maxwell(0.4, 0.1, between=A), sp.ThermalNoise(0.7)),
    "harmonic": (sp.Harmonic(0.8, 1.3, on="ground"),),
    "band-limited record": (
        sp.RecordedExcitation(np.arange(60) * 0.2, np.sin(np.arange(60.0) ** 1.2), interpolation="band-limited"),
    ),
    "records, drawn": (
        sp.RecordedExcitation((0.0, 4.0, 7.0), ((1.0, 2.0, 0.0), (2.0, -1.0, 1.0)), taken="at random"),
    ),
}  # fmt: skip


@cache
def of_kernel(seed: int, path: int, steps: int, word: int) -> np.ndarray:
    """The normals of the kernel."""
    out = np.empty((1, steps), np.float32)
    FILL_NORMALS(path, 0, word, *key_words(seed), 1, steps, out)
    return out[0].astype(float)


@pytest.mark.parametrize("name", SOURCES)
def test_sources(name: str) -> None:
    dampers = sp.Dashpot(0.2, between=A), sp.Dashpot(0.1, between=AB)
    springs = sp.Spring(1.3, between=A), sp.Spring(0.7, between=AB)
    system = sp.System(sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), *springs, *dampers, *SOURCES[name])
    paths, steps = 1 if name in ("band-limited record", "harmonic") else 2, 200
    run = simulated(
        system, paths=paths, duration=STEP * steps, step=STEP, window=(0.0, STEP * steps), record=paths, start="rest",
        initial_position=START, memory_tolerance=DOUBLE, seed=SEED,
    )  # fmt: skip
    by_hand = walk(
        system, STEP, steps, seed=SEED, path=paths - 1, words=WORDS, x=np.array([0.4, 0.3]), draw=of_kernel
    )  # fmt: skip
    found = run.record[-1].reshape(steps + 1, -1, 2)[:, :2]
    close = SHAPED if "density" in name else CLOSE
    assert found[..., 0] == pytest.approx(by_hand.x, rel=close, abs=close)
    assert found[..., 1] == pytest.approx(by_hand.v, rel=close, abs=close)


def swing(t: float, x: float, v: float) -> float:
    """An observable of one mass."""
    return x * v + 0.1 * t


def pounded(t: float, a_x: float, b_v: float) -> float:
    """One of two masses."""
    return a_x * b_v + 0.1 * t


def cubed(speed: float) -> float:
    """Of an impact."""
    return speed**3


CURVES = sp.Basquin(5.0, strength=2.0), sp.Basquin(3.5)
FREQUENCIES = np.array([0.9, 1.3, 2.0])


@dataclass
class Both:
    """A run with observers, and its paths by hand."""

    system: sp.System
    start: Any
    window: observers.Window
    steps: int
    asked: dict[str, Any]
    turns: bool

    @cached_property
    def options(self) -> dict[str, Any]:
        low, high, h = self.window.low, self.window.high, self.window.h
        return {
            "paths": PATHS, "duration": h * self.steps, "step": h, "window": (h * low, h * high), "start": "rest",
            "initial_position": self.start, "memory_tolerance": 1e-13, "seed": SEED,
        }  # fmt: skip

    @cached_property
    def run(self) -> Run:
        return simulated(self.system, record=PATHS, **self.options, **self.asked)

    @cached_property
    def simulation(self) -> Any:
        return simulation_of(plan_of(self.system, **self.options))

    @cached_property
    def paths(self) -> list[Path]:
        start = np.array([*self.start.values()]) if isinstance(self.start, dict) else self.start
        flight = self.simulation.motion.scales.flight_frequency if self.turns else 0.0
        return [
            walk(self.system, self.window.h, self.steps, seed=SEED, path=path, words=WORDS, x=start, flight=flight,
                 substeps=self.simulation.substeps, draw=of_kernel)
            for path in range(PATHS)
        ]  # fmt: skip

    @cached_property
    def forces(self) -> list[dict[str, np.ndarray]]:
        return [observers.forces(self.system, path, self.window.h) for path in self.paths]

    def moved(self, g: Sequence[float] = (1.0,)) -> list[tuple[np.ndarray, np.ndarray]]:
        """Displacements and rates along a row."""
        return [(path.x @ g, path.v @ g) for path in self.paths]

    def edges(self) -> list[int]:
        """Of the bins of profiles, in steps."""
        return np.rint(next(iter(self.run.profiles.values())).edges / self.window.h).astype(int).tolist()

    def every(self, share: float, fastest: float) -> int:
        """Groups between two samples, which are this share of a time apart."""
        return max(1, int(share / (observers.GROUP * self.window.h * fastest)))


@cache
def one_mass() -> Both:
    system = sp.System(
        sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0), sp.Harmonic(0.5, 1.3), sp.Barrier(-0.4, 0.7)
    )  # fmt: skip
    window, steps = observers.Window(402, 1602, 0.0125), 1603
    of_levels = {"speed": [1.0, 2.0, 2.5], "energy": [1.0, 3.0], "amplitude": [1.0, 2.5], "distance": [1.0, 2.0]}
    asked = {
        "distributions": True, "observables": {"swing": swing}, "impact_observables": {"cubed": cubed},
        "spectrum": FREQUENCIES, "slowest_counted_impact": 0.5, "profile": [402 * 0.0125, 8.0, 13.0, 1602 * 0.0125],
        "forces": ["spring_force", "springpot_force", "force_on_ground", "barrier_impulse"],
        "rainflow": {"x": CURVES, "spring_force": CURVES[0]},
        "first_passage": {
            "x": [1.0, 2.0, 0.3, -0.2, (-0.3, 1.5)], "v": [1.0, 2.0, -2.0, (-2.0, 1.5)], "moving": (swing, 3.0),
            **of_levels, "spring_force": [1.0, 2.0], "springpot_force": [0.2, 0.6],
        },
    }  # fmt: skip
    return Both(system, 0.6, window, steps, asked, turns=True)


@cache
def two_that_touch() -> Both:
    """From the first step on, with a wall and a contact, and forces whose accelerations are seen."""
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.3, between=A), sp.Spring(0.7, between=AB),
        sp.Dashpot(0.2, between=A), sp.Maxwell(0.8, 0.5, between=A), sp.Dashpot(0.1, between=AB),
        sp.Jenkins(0.9, 0.3, between=A), sp.Barrier(-0.3, 0.7, between=A),
        sp.Contact(-0.12, 20.0, 1.5, 0.4, between=AB), sp.ColoredNoise(1.0, 0.5, on="ground"),
        sp.Harmonic(0.8, 1.3, on="b"), sp.WhiteNoise(0.5, on="ground"),
    )  # fmt: skip
    asked = {
        "distributions": True, "observables": {"pounded": pounded}, "slowest_counted_impact": 0.2, "profile": 3,
        "forces": ["maxwell_force", "jenkins_force", "contact_force", "b_acceleration", "contact_peak_force"],
        "rainflow": {"a_b_elongation": CURVES[0], "b_acceleration": CURVES[1]},
        "first_passage": {"b_x": [0.5, 1.0, 1.5], "a_b_distance": [0.6, 1.0]},
    }  # fmt: skip
    return Both(system, START, observers.Window(0, 602, 0.02), 602, asked, turns=False)


def is_close(found: Any, by_hand: Any) -> bool:
    return bool(np.asarray(found, float) == pytest.approx(np.asarray(by_hand, float), rel=CLOSE, abs=1e-12))


def in_bins(run: Run, name: str, counts: Iterable[tuple[float, float]], place: float = 0.0) -> np.ndarray:
    """Counts by hand, in the bins of a distribution."""
    edges = run.distributions[name].edges - place
    found = np.zeros(edges.size - 1)
    for end, count in counts:  # within the bin, which of a negative number lies below its end
        found[np.searchsorted(edges, end * (1.0 + 1.0 / 256.0), side="right") - 1] += count
    return found


def turning_points(cycles: Iterable[observers.Cycles], name: str) -> dict[str, list[tuple[float, float]]]:
    """By the names of their distributions, each with its weight."""
    found: dict[str, list[tuple[float, float]]] = {f"{name}_{end}": [] for end in ("range", "peak", "valley")}
    for own in cycles:
        found[f"{name}_range"] += [(observers.bin_of(size), weight) for size, weight in own.ranges]
        found[f"{name}_peak"] += [(observers.bin_of(x), 1.0) for x in own.maxima]
        found[f"{name}_valley"] += [(observers.bin_of(x), 1.0) for x in own.minima]
    return found


def test_observed_means_and_extremes() -> None:
    """Of states and impacts: functions of the user, impacts that are not slow, impulses, the largest values."""
    both = one_mass()
    run, window = both.run, both.window
    impacts = [window.impacts(path) for path in both.paths]
    assert sum(map(len, impacts)) > 10
    assert is_close(run["swing"].value, np.mean([observers.mean_of(swing, x, v, window) for x, v in both.moved()]))
    assert is_close(run["cubed"].value, np.mean([observers.per_second(cubed, own, window) for own in impacts]))
    rate, *of_speed = observers.counted([each.speed for own in impacts for each in own], 0.5, window)
    names = "counted_impact_rate", "counted_impact_speed_mean", "counted_impact_speed_mean_square"
    assert is_close([run[name].value for name in names], [rate / PATHS, *of_speed])
    of_impulses = observers.counted([each.momentum for own in impacts for each in own], 0.0, window)[1:]
    assert is_close([run[f"barrier_impulse_{end}"].value for end in ("mean", "mean_square")], of_impulses)
    for path, ((x, v), own) in enumerate(zip(both.moved(), impacts, strict=True)):
        largest = observers.extremes(x, v, own, -0.4, window)
        assert is_close([run.extremes[name][path] for name in largest], [*largest.values()])


def test_what_noise_presses_on_a_wall_rests_on_it_for_observers() -> None:
    """All that a wall takes is summed; an impact after which the mass would not part is none for observers."""
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.3, between=A), sp.Spring(0.7, between=AB),
        sp.Barrier(-0.3, 0.3, between=A), sp.Constant(-10.0, on="a"), sp.WhiteNoise(0.5, on="a"),
    )  # fmt: skip
    both = Both(system, START, observers.Window(0, 400, 0.02), 400, {"slowest_counted_impact": 0.0}, turns=False)
    run, window = both.run, both.window
    speeds = [each.speed for path in both.paths for each in window.impacts(path)]
    rests = sum(each.rests and window.holds(each.step, each.late) for path in both.paths for each in path.impacts)
    assert min(len(speeds), rests) > 20
    assert is_close(run["counted_impact_rate"].value, observers.counted(speeds, 0.0, window)[0] / PATHS)
    assert is_close(run["barrier_impact_rate"].value, (len(speeds) + rests) / (PATHS * window.length))


def test_observed_distributions() -> None:
    both = one_mass()
    scales, window = both.simulation.motion.scales, both.window
    every, w = both.every(0.1, scales.fastest_rate), scales.flight_frequency
    assert every > 1
    kinds = {
        "x": [lambda n, x=x: x[n + 1] + 0.4 for x, _ in both.moved()],
        "v": [lambda n, v=v: v[n + 1] for _, v in both.moved()],
        "amplitude": [lambda n, x=x, v=v: math.hypot(x[n + 1], v[n + 1] / w) for x, v in both.moved()],
        "spring_force": [lambda n, own=own["spring"]: own[n] for own in both.forces],
    }
    total = {name: sum((observers.distribution(own, window, every) for own in paths), Counter())
             for name, paths in kinds.items()}  # fmt: skip
    speeds = [own.speed for path in both.paths for own in window.impacts(path)]
    total["impact_speed"] = Counter(map(observers.bin_of, speeds))
    for name, counts in total.items():
        found = both.run.distributions[name].counts.sum(axis=0)
        assert np.array_equal(found, in_bins(both.run, name, counts.items(), -0.4 if name == "x" else 0.0))


def test_observed_spectrum() -> None:
    both = one_mass()
    fastest = max(both.simulation.motion.scales.fastest_rate, FREQUENCIES.max())
    every = both.every(2.0 * math.pi / 12.0, fastest)
    assert every > 1
    by_hand = observers.spectrum([x for x, _ in both.moved()], FREQUENCIES, both.window, every)
    assert is_close(both.run.spectra["x"].density, by_hand)


@pytest.mark.parametrize("both", [one_mass, two_that_touch])
def test_observed_forces(both: Any) -> None:
    """In each kick, and their mean and mean square without what is known to lack in it."""
    both = both()
    run, (low, high) = both.run, (both.window.low, both.window.high)
    lacking = both.simulation.parts.outputs.lacking
    own = {f"{name}_force": name for name in both.forces[0]} | {"b_acceleration": "acceleration of b"}
    seen = [name for name in run.forces if name in own]
    assert len(seen) > 1
    for name in seen:
        by_hand = [each[own[name]] for each in both.forces]
        assert is_close(run.forces[name][:, 1:], by_hand)
        within = np.array(by_hand)[:, low:high]
        if name != "contact_force":  # whose mean is that of its momentum
            assert is_close(run[f"{name}_mean"].value, within.mean())
        assert is_close(run[f"{name}_mean_square"].value - lacking[name], (within**2).mean())
    if "force_on_ground" in run.forces:
        by_hand = [each["spring"] + each["springpot"] for each in both.forces]
        assert is_close(run.forces["force_on_ground"][:, 1:], by_hand)


def test_observed_touches() -> None:
    """Of a contact: their speeds, the least and largest elongation, and the largest forces."""
    both = two_that_touch()
    run, window = both.run, both.window
    touches = [[own for own in path.touches if window.holds(own.step, own.late)] for path in both.paths]
    speeds, peaks = [own.speed for each in touches for own in each], [
        force for path in both.paths for force in observers.peaks(path, "contact", window)
    ]  # fmt: skip
    assert len(peaks) > 5
    rate, *of_speed = observers.counted(speeds, 0.2, window)
    names = "counted_impact_rate", "counted_impact_speed_mean", "counted_impact_speed_mean_square"
    assert is_close([run[f"contact_{name}"].value for name in names], [rate / PATHS, *of_speed])
    ends = "mean", "mean_square"
    of_peaks = observers.counted(peaks, 0.0, window)[1:]
    assert is_close([run[f"contact_peak_force_{end}"].value for end in ends], of_peaks)
    for path, ((x, v), own) in enumerate(zip(both.moved([-1.0, 1.0]), touches, strict=True)):
        largest = observers.extremes(x, v, own, -0.12, window)
        found = [run.extremes[f"a_b_elongation_{end}"][path] for end in ("minimum", "maximum")]
        assert is_close(found, [largest["x_minimum"], largest["x_maximum"]])
        assert is_close(run.extremes["contact_impact_speed_largest"][path], largest["impact_speed_largest"])
    means = [observers.mean_of(pounded, path.x[:, 0], path.v[:, 1], window) for path in both.paths]
    assert is_close(run["pounded"].value, np.mean(means))


def test_observed_profiles() -> None:
    """Means in bins of time, impacts, and powers."""
    both = one_mass()
    run, window, edges = both.run, both.window, both.edges()
    kinds = {
        "x_mean": [lambda n, x=x: x[n + 1] for x, _ in both.moved()],
        "x_mean_square": [lambda n, x=x: x[n + 1] ** 2 for x, _ in both.moved()],
        "v_mean_square": [lambda n, v=v: v[n + 1] ** 2 for _, v in both.moved()],
        "springpot_force_mean": [lambda n, own=own["springpot"]: own[n] for own in both.forces],
    }
    for name, paths in kinds.items():
        by_hand = [observers.profile(values, edges, window) for values in paths]
        assert is_close(run.profiles[f"{name}_profile"].value, np.mean(by_hand, axis=0))
    bins = [observers.impacts_in_bins(window.impacts(path), edges) for path in both.paths]
    speeds = [np.concatenate(own) for own in zip(*bins, strict=True)]
    width = np.diff(edges) * window.h * PATHS
    assert is_close(run.profiles["impact_rate_profile"].value, [own.size for own in speeds] / width)
    assert is_close(run.profiles["impact_speed_mean_profile"].value, [own.mean() for own in speeds])
    fast = [(own >= 0.5).sum() for own in speeds]
    assert is_close(run.profiles["counted_impact_rate_profile"].value, fast / width)
    taken = [0.5 * (1.0 - 0.7**2) * (own**2).sum() for own in speeds]
    assert is_close(run.profiles["impact_power_profile"].value, taken / width)
    answer = memory_of(sp.Springpot(0.5, 0.3), window.h, 2)[1]
    solve = np.array([[1.0 / (1.0 + window.h * answer)]])
    powers = np.mean([observers.powers(both.system, path, edges, window.h, solve) for path in both.paths], axis=0)
    for name, by_hand in zip(("damping_power", "input_power"), powers.T, strict=True):
        assert is_close(run.profiles[f"{name}_profile"].value, by_hand)


def test_observed_cycles() -> None:
    """Of a displacement, which turns at the wall too: their number, damage, and the turning points."""
    both = one_mass()
    run, window, (low, high) = both.run, both.window, (both.window.low, both.window.high)
    cycles = [
        observers.cycles(observers.turns_of(x, v, window.impacts(path), -0.4, math.inf, window), x[low + 1], x[high])
        for path, (x, v) in zip(both.paths, both.moved(), strict=True)
    ]
    assert is_close(run["x_cycle_rate"].value, np.mean([own.count for own in cycles]) / window.length)
    for number, curve in enumerate(CURVES, 1):
        damage = 3600.0 * np.mean([own.damage(curve) for own in cycles]) / window.length
        assert is_close(run[f"x_damage_rate_{number}"].value, damage)
    for name, counts in turning_points(cycles, "x").items():
        assert np.array_equal(run.distributions[name].counts.sum(axis=0), in_bins(run, name, counts))


def cycles_of_forces(both: Both, name: str) -> list[observers.Cycles]:
    window, forces = both.window, [own[name] for own in both.forces]
    return [
        observers.cycles(observers.turns_of_force(own, window), own[window.low], own[window.high - 1]) for own in forces
    ]


@pytest.mark.parametrize(
    ("both", "name", "own", "curve"),
    [
        (one_mass, "spring_force", "spring", CURVES[0]),
        (two_that_touch, "b_acceleration", "acceleration of b", CURVES[1]),
    ],
)
def test_observed_cycles_of_forces(both: Any, name: str, own: str, curve: sp.Basquin) -> None:
    both = both()
    run, cycles = both.run, cycles_of_forces(both, own)
    length = both.window.length
    assert is_close(run[f"{name}_cycle_rate"].value, np.mean([each.count for each in cycles]) / length)
    damage = 3600.0 * np.mean([each.damage(curve) for each in cycles]) / length
    assert is_close(run[f"{name}_damage_rate"].value, damage)
    points = turning_points(cycles, name)
    for end in ("range", "peak"):
        found = run.distributions[f"{name}_{end}"].counts.sum(axis=0)
        assert np.array_equal(found, in_bins(run, f"{name}_{end}", points[f"{name}_{end}"]))


def test_observed_minima_of_a_force() -> None:
    """As of a displacement, the first state of the window is not among them."""
    both = one_mass()
    points = turning_points(cycles_of_forces(both, "spring"), "spring_force")["spring_force_valley"]
    found = both.run.distributions["spring_force_valley"].counts.sum(axis=0)
    assert np.array_equal(found, in_bins(both.run, "spring_force_valley", points))


def test_observed_cycles_of_an_elongation() -> None:
    """Between two masses, of which one strikes a wall."""
    both = two_that_touch()
    run, window = both.run, both.window
    cycles = [
        observers.cycles(
            observers.turns_of(u, w, window.impacts(path), -math.inf, math.inf, window), u[1], u[window.high]
        )
        for path, (u, w) in zip(both.paths, both.moved([-1.0, 1.0]), strict=True)
    ]  # fmt: skip
    rate = np.mean([own.count for own in cycles]) / window.length
    assert is_close(run["a_b_elongation_cycle_rate"].value, rate)
    for name, counts in turning_points(cycles, "a_b_elongation").items():
        assert np.array_equal(run.distributions[name].counts.sum(axis=0), in_bins(run, name, counts))


def passages_by_hand(both: Both, name: str, each: sp.simulation.PassageTimes) -> list[float]:
    """Of x, which may come and go within a step, and of what noise drives; an impact is seen just before it."""
    system, of, level = both.system, observers.Quantity.of, each.level
    roots, states = np.full(both.steps, 0.5826 * math.sqrt(both.window.h)), both.moved()
    if name == "moving":
        quantity = observers.Quantity.of_user(swing, level)
    elif name.endswith("force"):
        states = [(np.append(0.0, own[name.removesuffix("_force")]),) * 2 for own in both.forces]
        roots, quantity = np.full(both.steps, both.simulation.parts.outputs.over[name]), of("force", level)
    elif math.isfinite(each.reference):  # the distance from the middle of an interval
        quantity = of({"x": "distance", "v": "speed"}.get(name, name), level, middle=each.reference)
    else:
        w = {"amplitude": system.resonance, "energy": system.natural_frequency}.get(name, 1.0)
        quantity = of(name, level, above=level > (0.6 if name == "x" else 0.0), w=w)
    return [
        observers.first_passage(
            quantity, x, v, both.window, roots, from_start=False, place=-0.4,
            impacts=[] if name.endswith("force") else both.window.impacts(path),
        )
        for path, (x, v) in zip(both.paths, states, strict=True)
    ]  # fmt: skip


def test_first_passages_of_one_mass() -> None:
    both, passed = one_mass(), 0
    for name, passages in both.run.first_passages.items():
        for each in [passages] if name == "moving" else passages:
            times = passages_by_hand(both, name, each)
            assert is_close(each.times, times)
            passed += np.isfinite(times).sum()
    assert passed > 40


def test_first_passages_under_an_envelope() -> None:
    """The noise of each step has its own intensity."""
    system = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0, envelope=SOONER))
    both = Both(system, 0.0, observers.Window(0, 200, STEP), 200, {"first_passage": {"v": [0.5, 1.0, 1.5]}}, turns=True)
    middles = STEP * (np.arange(200) + 0.5)
    roots = 0.5826 * math.sqrt(STEP) * SOONER.at(middles)
    for each in both.run.first_passages["v"]:
        quantity = observers.Quantity.of("v", each.level)
        times = [observers.first_passage(quantity, x, v, both.window, roots, from_start=True) for x, v in both.moved()]
        assert np.isfinite(times).any()
        assert is_close(each.times, times)


def test_first_passages_from_the_start() -> None:
    """Of several masses; the state at time 0 counts."""
    both = two_that_touch()
    rows = {"b_x": ([0.0, 1.0], "x"), "a_b_distance": ([-1.0, 1.0], "distance")}
    for name, (g, kind) in rows.items():
        for each in both.run.first_passages[name]:
            touches = [path.touches if kind == "distance" else [] for path in both.paths]
            times = [
                observers.first_passage(
                    observers.Quantity.of(kind, each.level), u, w, both.window, np.zeros(both.steps), from_start=True,
                    impacts=own, place=-0.12,
                )
                for (u, w), own in zip(both.moved(g), touches, strict=True)
            ]  # fmt: skip
            assert np.isfinite(times).any()
            assert is_close(each.times, times)


def test_rate_of_passages() -> None:
    """From the times of the paths; and the test that it is constant."""
    run = simulated(
        sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)), paths=256, duration=60.0, start="rest",
        first_passage={"x": 3.0},
    )  # fmt: skip
    passages = run.first_passages["x"]
    events, rate, shares = observers.passage_rate(passages.times, passages.rate.since, passages.horizon)
    assert events == passages.rate.events > 20
    assert is_close(passages.rate.value, rate)
    exact = scipy.stats.cramervonmises(shares, "uniform").pvalue
    assert passages.rate.p_value == pytest.approx(exact, abs=0.01)  # the law in the limit of many
