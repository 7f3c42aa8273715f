"""Pictures of a system's run: every wall is drawn, and each impact is marked on the wall that was struck."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import springpot as sp
from springpot import figures
from springpot.machine.faults import NotCoveredError


@cache
def run() -> sp.simulation.Run:  # type: ignore[name-defined]
    slot = sp.System(
        sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 0.2)), sp.Springpot(0.5, 0.2), sp.Barrier(-0.5, 0.8),
        sp.Barrier(1.0, 0.8, "below"), sp.WhiteNoise(1.0),
    )  # fmt: skip
    return sp.simulate(slot, paths=4, duration=40.0, step=0.02, start="rest", record=4)


@pytest.mark.parametrize("draw", [figures.plot_path, figures.plot_phase_portrait])
def test_both_walls_and_the_impacts_on_each(draw) -> None:
    axes = draw(run(), member=2)
    lines = {line.get_label(): line for line in axes.get_lines()}
    across = draw is figures.plot_path
    places = [line.get_ydata()[0] if across else line.get_xdata()[0] for line in axes.get_lines()
              if len(line.get_xdata()) == 2 and line.get_linewidth() == 2.0]  # fmt: skip
    assert sorted(places) == [-0.5, 1.0]
    struck = np.asarray(lines["impact"].get_ydata() if across else lines["impact"].get_xdata())
    assert {*struck} == {-0.5, 1.0}
    # as many as the path turned round at a wall
    x, v = run().record[2].T
    turned = np.sum((v[:-1] < 0.0) & (v[1:] > 0.0) & (np.minimum(x[:-1], x[1:]) < -0.45))
    assert abs(np.sum(struck == -0.5) - turned) <= 1 + 0.1 * turned


def test_a_soft_contact_is_dashed_and_has_no_instant_of_impact() -> None:
    stop = sp.System(sp.Spring(1.0), sp.Dashpot(0.2), sp.Contact(-0.5, 50.0), sp.WhiteNoise(1.0))
    axes = figures.plot_path(sp.simulate(stop, paths=1, duration=20.0, step=0.02, start="rest", record=1))
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert lines["contact"].get_linestyle() == "--"
    assert lines["impact"].get_xdata().size == 0


def test_what_needs_an_oscillator_says_so() -> None:
    with pytest.raises(ValueError, match="polynomial_spring cannot be part of an Oscillator"):
        figures.plot_transient(run(), at=[0.0, 1.0])


def test_a_path_of_several_masses_is_that_of_a_mass_or_of_a_part() -> None:
    """A wall between two masses, and one stated the other way round, bound their elongation."""
    ends = {"between": ("a", "b")}
    pair = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.0, between=("ground", "a")), sp.Spring(1.0, **ends),
        sp.Springpot(0.5, 0.2, **ends), sp.WhiteNoise(0.5, on="b"), low=sp.Barrier(-0.3, 0.9, **ends),
        high=sp.Barrier(-0.6, 0.9, between=("b", "a")), foot=sp.Barrier(-2.0, between=("ground", "a")),
    )  # fmt: skip
    shaken = sp.simulate(pair, paths=2, duration=40.0, record=2)
    x = shaken.record[1, :, :, 0].T
    axes = figures.plot_path(shaken, of="low", member=1)
    assert axes.get_ylabel() == "elongation of low (m)"
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert np.array_equal(axes.get_lines()[0].get_ydata(), x[1] - x[0])
    assert sorted(line.get_ydata()[0] for line in axes.get_lines() if line.get_linewidth() == 2.0) == [-0.3, 0.6]
    assert {*lines["impact"].get_ydata()} == {-0.3, 0.6}
    back = figures.plot_path(shaken, of="high", member=1)
    assert sorted(line.get_ydata()[0] for line in back.get_lines() if line.get_linewidth() == 2.0) == [-0.6, 0.3]
    of_a = figures.plot_phase_portrait(shaken, of="a")
    assert (of_a.get_xlabel(), of_a.get_ylabel()) == ("displacement of a (m)", "velocity of a (m/s)")
    assert [line.get_xdata()[0] for line in of_a.get_lines() if line.get_linewidth() == 2.0] == [-2.0]
    correlation = figures.plot_correlation(shaken, at=[0.0, 1.0], since=20.0, of="low")
    assert correlation.get_xlabel() == "lag (s)"
    for draw in (figures.plot_path, figures.plot_phase_portrait):
        with pytest.raises(ValueError, match="of must be one of a, b, spring_1, spring_2, springpot, low, "):
            draw(shaken)
    with pytest.raises(ValueError, match="of must be mass, not 'wall'"):
        figures.plot_path(run(), of="wall")
    with pytest.raises(NotCoveredError, match="one mass is needed"):
        figures.plot_transient(shaken)


def test_a_run_with_a_function_of_the_user_is_drawn() -> None:
    wall = sp.Barrier(-0.3, lambda speed: 0.8 / (1.0 + speed))
    lossy = sp.System(sp.Spring(8.0), sp.Dashpot(0.4), sp.WhiteNoise(1.0), wall)
    run = sp.simulate(lossy, paths=64, duration=20.0, distributions=True)
    assert sp.figures.plot_density(run, "impact_speed").get_ylabel() == "density (s/m)"
