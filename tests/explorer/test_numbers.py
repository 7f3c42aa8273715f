"""The page's numbers are those of the library."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.answers import solve, table
from springpot.explorer.gathering import BINS, Gathering, growth_times
from springpot.explorer.motion import Player, blocks, marks, record
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.theory.registry import METHODS
from tests.sizes import validation

FREQUENCY = 2.0
LOSSY = sp.Oscillator(
    natural_frequency=FREQUENCY,
    springpot=sp.Springpot(0.6, 0.4),
    barrier=sp.Barrier(-0.1, 0.8),
    excitation=sp.WhiteNoise(0.5),
)


def gathered(system: sp.System, *, speeds: float = 0.0, **given: object) -> Gathering:
    plan = plan_of(system, **given)  # type: ignore[arg-type]
    gathering = Gathering(simulation_of(adapt(plan) if plan.settings.start == "stationary" else plan), speeds=speeds)
    while not gathering.complete:
        gathering.grow()
    return gathering


@pytest.mark.parametrize("position", [validation(-1.0), validation(0.0), validation(0.5), 5.0])
def test_a_density_of_the_amplitude_is_drawn_where_it_is(position: float) -> None:
    """Under preload too, where it begins far from 0: nearly all of it, and no needle in a wide chart."""
    system = sp.Oscillator(springpot=sp.Springpot(1.0, 0.2), barrier=sp.Barrier(position, 1.0, free_side="above"))
    answers = {name: answer for name in METHODS if (answer := solve(system, name)[0]) is not None}
    found = table(system, answers, {})
    places = np.array(found["places"]["amplitude"])
    density = np.array(found["methods"]["envelope"]["densities"]["amplitude"])
    assert places[0] == max(position, 0.0)
    assert np.trapezoid(density, places) == pytest.approx(1.0, abs=0.03)
    assert np.mean(density > 0.05 * density.max()) > 0.3


@pytest.mark.parametrize("start", ["rest", "stationary"])
@pytest.mark.parametrize("system", [LOSSY, sp.Oscillator(barrier=None)])
def test_the_grown_ensemble_is_the_run(system: sp.System, start: str) -> None:
    """Whatever the blocks: the same numbers to the last bit, with the same errors, warnings and counts."""
    given = {"paths": 300, "seed": 11, "start": start}
    ours = gathered(system, **given)
    run = sp.simulate(system, distributions=True, step=ours.simulation.settings.step, **given)
    values, errors = ours.estimates()
    np.testing.assert_equal(values, {name: run[name].value for name in run})
    np.testing.assert_equal(errors, {name: run[name].error for name in run})
    assert ours.warnings() == run.warnings
    for name, found in ours.distributions().items():
        np.testing.assert_array_equal(found.counts.sum(axis=0), run.distributions[name].counts.sum(axis=0))
        np.testing.assert_array_equal(found.edges, run.distributions[name].edges)


HEAVY = sp.System(
    sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(0.3, 150.0), sp.Barrier(-0.003, 0.7), sp.WhiteNoise(0.5, on="ground")
)  # fmt: skip


def test_what_an_engineer_asks_first_is_the_run_s() -> None:
    """The 99 % impact speed and the peak of the acceleration, with their errors, however the paths were grown."""
    given = {"paths": 2000, "seed": 4, "start": "rest"}
    ours = gathered(HEAVY, **given)
    values, errors = ours.peaks()
    step = ours.simulation.settings.step
    run = sp.simulate(HEAVY, distributions=True, forces=["acceleration"], step=step, **given)
    at, error = run.distributions["impact_speed"].quantile(0.99)
    largest = np.maximum(-run.extremes["acceleration_minimum"], run.extremes["acceleration_maximum"])
    assert values == {"impact_speed_quantile_0.99": float(at), "acceleration_peak_mean": float(largest.mean())}
    assert errors["impact_speed_quantile_0.99"] == pytest.approx(float(error), rel=0.05)
    assert errors["acceleration_peak_mean"] == pytest.approx(largest.std(ddof=1) / 2000**0.5)


def test_impacts_that_cannot_be_counted_have_no_99_per_cent_speed() -> None:
    """Under smooth noise, as their rate; and a force on the mass leaves no acceleration."""
    smooth = sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.Barrier(-0.5, 0.7), sp.ColoredNoise(1.0, 1.0))
    values = gathered(smooth, paths=128, start="rest").peaks()[0]
    assert "impact_speed_quantile_0.99" not in values
    assert gathered(sp.System(*PARTS), paths=128, start="rest").peaks() == ({}, {})


PARTS = sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0)
PAIR = (
    *(sp.Mass(1.0, at=at) for at in "ab"),
    *(part(0.5, between=ends) for part in (sp.Spring, sp.Dashpot) for ends in (("ground", "a"), ("a", "b"))),
)
# what a path moves against, and the share of its time that it spends beyond the place of the wall, at most
MOVING = {
    "a wall below": (LOSSY, 0.0),
    "a wall above": (sp.System(*PARTS, sp.Barrier(0.3, 0.8, free_side="below")), 0.0),
    "a weight on a wall": (sp.System(*PARTS, sp.Constant(-2.0), sp.Barrier(-1.5, 0.8)), 0.0),
    "a soft contact above": (sp.System(*PARTS, sp.Contact(0.3, 20.0, free_side="below")), 0.3),
    "two masses": (
        sp.System(*PAIR, sp.WhiteNoise(1.0, on="b"), sp.Barrier(0.5, 0.8, free_side="below", between=("a", "b"))), 0.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MOVING)
def test_a_shown_path_is_a_path_of_the_run(name: str) -> None:
    """In the coordinates of the system, and on its side of the wall."""
    system, beyond = MOVING[name]
    given = {"paths": 129, "seed": 5, "start": "rest", "duration": 40.0, "window": (20.0, 40.0)}
    plan = plan_of(system, **given)  # type: ignore[arg-type]
    simulation = simulation_of(plan)
    run = sp.simulate(system, record=129, **given)  # type: ignore[arg-type]
    assert blocks(plan.settings) == 3
    for number in range(3):
        shown = record(simulation, number)
        assert shown.path == 64 * number
        found = run.record[shown.path].reshape(len(run.time), -1, 2)
        np.testing.assert_array_equal(shown.x, found[:, :, 0].T)
        np.testing.assert_array_equal(shown.v, found[:, :, 1].T)
        assert len(shown.impacts) > 0
        (wall,) = system.stops.values()
        gap = (1.0 if wall.free_side == "above" else -1.0) * (shown.rows[0] @ shown.x - wall.position)
        past = np.mean(gap < -1e-5)
        assert past <= beyond
        assert (past > 0.0) == (beyond > 0.0)
    later = run.record[:, run.time > 20.0].reshape(129, -1, len(system.points), 2)
    if len(system.points) == 1:  # the mean of the record is that of the sums: no other origin, no other sign
        assert later[..., 0, 0].mean() == pytest.approx(run["x_mean"].value, abs=1e-3)


def test_marked_impacts_are_those_the_kernel_counts() -> None:
    """Within two in a hundred: the kernel also counts those between the ends of a step."""
    for system, frequency in ((sp.Oscillator(), 1.0), (LOSSY, FREQUENCY)):
        end = 100.0 / frequency
        plan = plan_of(system, paths=64, record=64, seed=2, duration=end, window=(0.0, end), start="rest")
        simulation = simulation_of(plan)
        found = simulation.advance()
        sums = simulation.parts.sums(found.rows)
        counted = sum(sums["impacts", wall].sum() for wall in simulation.parts.walls)
        marked = sum(marks(system, plan.settings.step, *path.T[:, None])[0].size for path in found.record)
        assert counted > 1000
        assert abs(marked / counted - 1.0) < 0.02


def test_growth_is_the_mean_over_recorded_paths() -> None:
    gathering = gathered(LOSSY, speeds=FREQUENCY**-2, paths=256, seed=3, start="rest")
    mean, error = (found[0] for found in gathering.growth())
    times = growth_times(gathering.simulation.plan)
    run = sp.simulate(LOSSY, paths=256, seed=3, record=256, start="rest")
    square = (run.record[:, 1:, 0] ** 2 + (run.record[:, 1:, 1] / FREQUENCY) ** 2).mean(axis=0)
    assert mean.shape == error.shape == times.shape == (BINS,)
    width = times[1] - times[0]
    for at in (0, 3, 40, BINS - 1):
        begin, end = np.searchsorted(run.time[1:], [times[at] - 0.5 * width, times[at] + 0.5 * width])
        assert mean[at] == pytest.approx(square[begin:end].mean(), rel=0.05)
    assert 0.02 < np.median(error / mean) < 0.2


def test_a_path_is_shown_once_and_whole() -> None:
    plan = plan_of(LOSSY, paths=64, start="rest")
    settings, shown = plan.settings, record(simulation_of(plan), 0)
    player = Player(shown, frequency=FREQUENCY)
    times, x, struck = [], [], []
    while not player.ended:
        player.forward(0.37)
        if part := player.due():
            (begin, spacing, path, end), here, _, hits, _, walls, voltages = part
            assert (len(walls), len(voltages)) == (len(hits), 0)
            assert path == 0
            assert end == settings.duration
            times.append(begin + spacing * np.arange(here.shape[1]))
            x.append(here[0])
            struck.append(hits)
    time = np.concatenate(times)
    np.testing.assert_allclose(np.diff(time), np.diff(time)[0])
    np.testing.assert_array_equal(np.concatenate(x), shown.x[0, :: round(np.diff(time)[0] / settings.step)])
    np.testing.assert_allclose(np.concatenate(struck), (shown.impacts + 0.5) * settings.step)
