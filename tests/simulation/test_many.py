"""Many systems at once: each has what it has alone."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.lowering.compose import compose, units_of
from springpot.simulation.many import _simulated
from springpot.simulation.monte_carlo import arguments_of, simulated
from springpot.simulation.paths.simulation import Simulation, simulation_of
from springpot.simulation.paths.together import _calls, advance_devices, advance_together, alike
from springpot.simulation.plan.plan import plan_of
from tests.sizes import thinned, validation


def device(mass: float = 0.2, *parts: Any, order: float = 0.5, gap: float = 0.003, restitution: Any = 0.8) -> sp.System:
    return sp.System(
        sp.Mass(mass), sp.Spring(80.0), sp.Springpot(order, 1.2), sp.WhiteNoise(1e-3), *parts,
        stop=sp.Barrier(-gap, restitution),
    )  # fmt: skip


def pair(gap: float) -> sp.System:
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Spring(100.0, between=("ground", "a")),
        sp.Spring(80.0, between=("a", "b")), sp.Springpot(0.4, 3.0, between=("a", "b")),
        sp.Dashpot(0.5, between=("ground", "a")), sp.WhiteNoise(1e-2, on="b"),
        gap=sp.Barrier(-gap, 0.7, between=("a", "b")),
    )  # fmt: skip


SYSTEMS = (
    device(), pair(0.01), device(0.25, gap=0.002), device(order=0.5, restitution=1.0),
    sp.System(sp.Mass(0.2), sp.Spring(80.0), sp.Springpot(0.3, 1.0), sp.Springpot(0.9, 0.3), sp.WhiteNoise(1e-3)),
    pair(0.02), device(order=0.9),
)  # fmt: skip
SHORT = {"paths": 100, "duration": 4.0, "step": 0.005}


def many(systems: Any, **given: Any) -> list[Any]:
    """As `sp.simulate_many`, without warnings."""
    return _simulated(list(systems), arguments_of(given))


def assert_same(found: Any, alone: Any) -> None:
    np.testing.assert_array_equal(found.path_sums, alone.path_sums)
    np.testing.assert_array_equal(found.record, alone.record)
    assert found.to_xarray().equals(alone.to_xarray())
    assert found.warnings == alone.warnings
    assert replace(found.settings, threads=1) == replace(alone.settings, threads=1)
    without = {**alone.diagnostics, "seconds": found.diagnostics["seconds"]}
    assert found.diagnostics == without


@pytest.mark.parametrize("threads", [validation(1), 2])
def test_each_run_has_the_bits_that_it_has_alone(threads: int) -> None:
    """Seven systems of several structures, with stationary starts and so with pilot runs."""
    for found, system in zip(many(SYSTEMS, **SHORT, threads=threads), SYSTEMS, strict=True):
        assert_same(found, simulated(system, **SHORT, threads=1))


@pytest.mark.parametrize(
    "wish", [{"record": 2}, {"distributions": True}, {"forces": ["spring_force"]}], ids=lambda wish: next(iter(wish))
)
def test_what_is_watched_and_recorded_is_the_same(wish: dict[str, Any]) -> None:
    systems, given = (SYSTEMS[0], SYSTEMS[2], SYSTEMS[4]), {**SHORT, "start": "rest", "threads": 2, **wish}
    for found, system in zip(many(systems, **given), systems, strict=True):
        assert_same(found, simulated(system, **given))


def test_a_tolerance_is_that_of_each() -> None:
    systems = sp.Oscillator(), sp.Oscillator(barrier=None)
    for found, system in zip(many(systems, rtol=0.3, threads=1), systems, strict=True):
        alone = simulated(system, rtol=0.3, threads=1)
        assert found["amplitude_mean_square"].value == alone["amplitude_mean_square"].value
        assert found.diagnostics["path_steps"] == alone.diagnostics["path_steps"]


TIMES = np.linspace(0.0, 1.0, 401)
QUAKE = 0.3 * np.sin(np.linspace(0.0, 25.0, 401)) * np.exp(-np.linspace(0.0, 4.0, 401))


def ready(system: sp.System, **given: Any) -> Simulation:
    return simulation_of(plan_of(system, start="rest", duration=1.0, step=0.005, threads=2, **given))


def smooth(n: int, *parts: Any) -> sp.System:
    """Without white noise, so that masses can rest on the wall."""
    return sp.System(sp.Mass(0.2), sp.Spring(80.0 + n), sp.Springpot(0.5, 1.2), *parts, stop=sp.Barrier(-1e-4, 0.6))


ALIKE: dict[str, Any] = {
    "walls": lambda n: device(0.2 + 0.002 * n, gap=0.002 + 1e-4 * n, restitution=0.5 + 0.01 * n),
    "record": lambda n: device(0.2, sp.RecordedExcitation(TIMES, (1.0 + 0.1 * n) * QUAKE)),
    "noises": lambda n: device(0.2, sp.ColoredNoise(2.0 + n, 1e-3), sp.ParametricNoise(1e-3 * (1 + n))),
    "contact": lambda n: device(0.2, sp.Contact(0.003, 500.0 + n, free_side="below"), sp.Friction(1e-3 * n + 1e-3)),
    "two masses": lambda n: pair(0.01 + 1e-3 * n),
    "rest": lambda n: smooth(n, sp.ColoredNoise(2.0 + n, 1e-3), sp.Constant(-0.05 * n)),
    "waves and shots": lambda n: smooth(
        n, sp.Harmonic(0.02 + 1e-3 * n, 15.0 + n), sp.PoissonImpulses(20.0 + n, 1e-3 + 1e-4 * n)
    ),
    "yields": lambda n: smooth(
        n, sp.BoucWen(20.0 + n, 1e-2), sp.Jenkins(10.0 + n, 1e-2), sp.WhiteNoise(1e-3),
        sp.VanDerPol(0.1 + 0.01 * n, 0.01), sp.PolynomialDashpot((0.1, 0.2, 0.3 + n)),
    ),
    "laws": lambda n: device(
        0.2, sp.PolynomialSpring((0.0, 0.0, 1e5 + n)), restitution=sp.PowerRestitution(0.5 + 0.01 * n, speed=0.1)
    ),
    "envelope": lambda n: sp.System(
        sp.Mass(0.2), sp.Spring(80.0), sp.Springpot(0.5, 1.2 + 0.1 * n), sp.Dashpot(0.1),
        sp.WhiteNoise(1e-3, envelope=sp.ExponentialEnvelope(0.5 + 0.1 * n, 10.0)),
        sp.KanaiTajimiNoise(12.0 + n, 0.6, 1e-3),
    ),
    "own": lambda n: device(0.2 + 0.01 * n, sp.Force(_pull), restitution=_bounce),
    "circuits": lambda n: sp.System(
        sp.Mass(0.2), sp.Spring(80.0), sp.Dashpot(0.2), sp.WhiteNoise(1e-3),
        sp.PiezoelectricCircuit(1e-3, 1e5, 1e-8 * (20 + n)), sp.ResonantCircuit(1e-3, 1e3, 1e-7, 1e4 * (1.0 + 0.1 * n)),
    ),
    "masses at rest and in touch": lambda n: sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(2.0 + 0.1 * n, at="b"), sp.Spring(100.0, between=("ground", "a")),
        sp.Spring(80.0, between=("a", "b")), sp.Dashpot(0.5, between=("ground", "a")),
        sp.ColoredNoise(2.0, 0.1, on="b"), sp.Constant(-1.0, on="a"),
        floor=sp.Barrier(-0.001 * n, 0.5, between=("ground", "a"), free_side="above"),
        pad=sp.Contact(0.002, 1e4, exponent=1.5, dissipation=0.5, between=("a", "b"), free_side="below"),
    ),
}  # fmt: skip
FEW_KINDS = ("walls", "record", "noises", "contact", "two masses")


def _pull(t: float, x: float, v: float) -> float:
    return -3.0 * x**3 - 0.1 * v + 0.01 * t


def _bounce(v: float) -> float:
    return 0.5 + 0.4 / (1.0 + v)


@pytest.mark.parametrize(("kind", "paths"), thinned(itertools.product(FEW_KINDS, (40, 130)), 3))
def test_systems_of_one_structure_share_calls(kind: str, paths: int) -> None:
    """Each has numbers of its own, in both precisions and in long lists, and the bits that it has alone."""
    simulations = [ready(ALIKE[kind](n), paths=paths) for n in range(32)]
    shared = [call for call in _calls(simulations) if len(call.members) > 1]
    assert sum(len(call.members) for call in shared) > 28
    for found, simulation in zip(advance_together(simulations), simulations, strict=True):
        np.testing.assert_array_equal(found.rows, simulation.advance().rows)


@pytest.mark.validation
@pytest.mark.parametrize("paths", [8, 32])
@pytest.mark.parametrize("kind", ALIKE)
def test_devices_of_few_paths_share_blocks(kind: str, paths: int) -> None:
    """Each lane has numbers of its own; what is compiled for that rounds otherwise."""
    plans = [ready(ALIKE[kind](n), paths=paths).plan for n in range(16)]
    simulations = [Simulation(plan, compose(plan, kernel_units=units_of(plans[0]))) for plan in plans]
    assert alike([each.parts.tables for each in simulations]) == (kind != "circuits")
    if kind == "circuits":  # whose modes have rates of their own
        with pytest.raises(ValueError, match="paths must be 64 or a multiple of it"):
            advance_devices(simulations)
        return
    for n, (found, simulation) in enumerate(zip(advance_devices(simulations), simulations, strict=True)):
        alone = simulation.but(paths=16 * paths).advance().rows[n * paths : (n + 1) * paths]
        size = np.abs(alone).max(axis=0) + 1e-300
        np.testing.assert_allclose(found.rows / size, alone / size, atol=1e-3, equal_nan=True)
        assert np.median(np.abs(found.rows - alone) / size) < 1e-6


@pytest.mark.parametrize("alike", thinned([ALIKE[name] for name in FEW_KINDS], 2), ids=FEW_KINDS)
def test_devices_of_whole_blocks_have_the_bits_of_a_plain_run(alike: Any) -> None:
    """Each is compiled as a single system is, and its paths have numbers of their own."""
    plans = [ready(alike(n), paths=64).plan for n in range(12)]
    simulations = [Simulation(plan, compose(plan, kernel_units=units_of(plans[0]))) for plan in plans]
    for n, (found, simulation) in enumerate(zip(advance_devices(simulations), simulations, strict=True)):
        alone = simulation.but(paths=12 * 64).advance().rows[n * 64 : (n + 1) * 64]
        np.testing.assert_array_equal(found.rows, alone)


def test_calls_of_long_runs_are_of_some_blocks() -> None:
    """Of systems with many paths too, so that threads share them."""
    simulations = [ready(device(0.2 + 0.01 * n), paths=64 * 100) for n in range(2)]
    calls = [*_calls(simulations)]
    assert all(len(call.members) == 1 and call.blocks < 100 for call in calls)
    assert sum(call.blocks for call in calls) == 200
    for found, simulation in zip(advance_together(simulations), simulations, strict=True):
        np.testing.assert_array_equal(found.rows, simulation.advance().rows)


def test_starts_that_are_drawn_are_those_of_each_system() -> None:
    """Boltzmann's law of each, in every block."""
    warm = [
        sp.System(sp.Spring(4.0), sp.Dashpot(0.2), sp.ThermalNoise(0.1 * n), sp.Barrier(-0.5, 1.0)) for n in (1, 2, 3)
    ]
    given: dict[str, Any] = {"paths": 130, "duration": 2.0, "step": 0.01}
    for found, system in zip(many(warm, **given), warm, strict=True):
        assert_same(found, simulated(system, **given))


def test_nothing_is_simulated_before_all_systems_are_checked() -> None:
    """An error is that of the system alone, with a note that says which it is."""
    told: list[float] = []
    wrong = sp.System(sp.Spring(1e8), sp.Dashpot(1.0), sp.WhiteNoise(1.0))
    with pytest.raises(ValueError, match="too coarse for a system") as alone:
        simulated(wrong, **SHORT)
    with pytest.raises(ValueError, match="too coarse for a system") as fault:
        many([SYSTEMS[0], wrong], **SHORT, progress=told.append)
    assert str(fault.value) == str(alone.value)
    assert fault.value.__notes__ == ["This is about systems[1]."]
    assert told == []


@pytest.mark.parametrize(
    ("systems", "sentence"),
    [
        (SYSTEMS[0], "systems must be a list of systems, not "),
        ("device", "systems must be a list of systems, not 'device'"),
        (3, "systems must be a list of systems, not 3"),
        ([SYSTEMS[0], 3], r"systems\[1\] must be a System, not 3"),
    ],
    ids=["one", "name", "number", "among them"],
)
def test_what_is_no_list_of_systems_is_refused(systems: Any, sentence: str) -> None:
    with pytest.raises(TypeError, match=sentence):
        sp.simulate_many(systems, **SHORT)  # type: ignore[arg-type]


def test_no_systems_have_no_runs() -> None:
    assert sp.simulate_many([], **SHORT) == []


def _softer(speed: float) -> float:
    return 0.9 / (1.0 + speed)


def test_systems_with_functions_of_the_user_are_among_others() -> None:
    systems, given = (device(restitution=_softer), device(), device(0.3, restitution=_softer)), {**SHORT, "seed": 3}
    for found, system in zip(many(systems, **given), systems, strict=True):
        assert_same(found, simulated(system, **given))


@pytest.mark.parametrize("more", [{}, {"record": 1}, {"rtol": 0.4}], ids=["together", "alone", "rtol"])
def test_progress_is_that_of_all(more: dict[str, Any]) -> None:
    told: list[float] = []
    given = more if "rtol" in more else {**SHORT, "start": "rest", **more}
    many([sp.Oscillator(), sp.Oscillator(barrier=None)], **given, threads=1, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert len({*told}) > 2


def test_an_exception_of_progress_ends_the_runs() -> None:
    def interrupt(fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        many(SYSTEMS, **SHORT, start="rest", progress=interrupt)


def test_warnings_are_raised_where_the_call_stands() -> None:
    few = sp.System(sp.Spring(4.0), sp.Dashpot(0.2), sp.WhiteNoise(0.1), sp.Barrier(-50.0))
    with pytest.warns(sp.SpringpotWarning) as raised:
        runs = sp.simulate_many([few], paths=64, duration=20.0)
    assert [str(own.message) for own in raised] == [str(sentence) for sentence in runs[0].warnings]
    assert {own.filename for own in raised} == {__file__}
