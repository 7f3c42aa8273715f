"""Several designs on the same axes: colors, names in the legend, and limits that fit all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import springpot as sp
from springpot.figures import COLORS
from springpot.figures.designs import CYCLE
from springpot.figures.style import panel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDE, NARROW = (
    sp.Oscillator(springpot=sp.Springpot(1.0, damping), barrier=sp.Barrier(-0.2, 1.0)) for damping in (0.3, 3.0)
)


@pytest.fixture(scope="module")
def runs() -> tuple[sp.simulation.Run, sp.simulation.Run]:
    asked: dict[str, Any] = {
        "paths": 640, "duration": 30.0, "step": 0.02, "distributions": True, "record": 20, "record_every": 5,
        "spectrum": np.linspace(1.0, 3.0, 5), "start": "rest",
    }  # fmt: skip
    return sp.simulate(WIDE, **asked), sp.simulate(NARROW, **asked)


LAGS = np.linspace(0.0, 5.0, 11)
KINDS: dict[str, Callable[..., Axes]] = {
    "density of x": lambda run, axes, **look: sp.figures.plot_density(run, "x", axes, **look),
    "density of impact speed": lambda run, axes, **look: sp.figures.plot_density(run, "impact_speed", axes, **look),
    "spectrum": sp.figures.plot_spectrum,
    "correlation": lambda run, axes, **look: sp.figures.plot_correlation(run, axes, at=LAGS, since=10.0, **look),
    "transient": lambda run, axes, **look: sp.figures.plot_transient(run, "x_mean", axes, **look),
    "survival": lambda run, axes, **look: sp.figures.plot_survival(run, 1.0, axes, **look),
    "path": sp.figures.plot_path,
    "phase portrait": sp.figures.plot_phase_portrait,
}


def drawn_span(axes: Axes) -> tuple[float, float]:
    """Lowest and highest of all that is drawn, error bars included."""
    axes.relim()
    heights = [np.asarray(line.get_ydata(), float) for line in axes.lines if len(line.get_ydata()) > 2]
    for container in axes.containers:
        heights += [np.concatenate(bar.get_segments())[:, 1] for bar in container[2]]
    everything = np.concatenate(heights)
    return float(np.nanmin(everything)), float(np.nanmax(everything))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_both_designs_are_within_the_limits(kind: str, order: tuple[int, int], runs: Any) -> None:
    axes = panel(None)
    for i in order:
        KINDS[kind](runs[i], axes, label=f"design {i}")
    axes.figure.canvas.draw()
    low, high = axes.get_ylim()
    lowest, highest = drawn_span(axes)
    assert high >= (1.0 if kind == "survival" else highest)  # a share is at most 1
    assert low <= max(lowest, 0.0) or kind.startswith("density")
    if kind.startswith("density"):
        assert low == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_each_design_has_its_color_and_its_name(kind: str, runs: Any) -> None:
    axes = panel(None)
    for run, name in zip(runs, ("soft", "stiff"), strict=True):
        KINDS[kind](run, axes, label=name)
    named = [label for label in axes.get_legend_handles_labels()[1] if label not in ("wall", "impact")]
    assert len(named) == len(set(named)) == 2
    assert named[0].startswith("soft")
    assert named[1].startswith("stiff")
    colors = {line.get_color() for line in axes.lines}
    assert {CYCLE[0], CYCLE[1]} <= colors


def test_theory_has_the_color_of_its_design(runs: Any) -> None:
    axes = panel(None)
    for run, oscillator, name in zip(runs, (WIDE, NARROW), ("soft", "stiff"), strict=True):
        sp.figures.plot_density(run, "x", axes, theory=sp.theory.exact(oscillator), label=name)
    by_name = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    assert list(by_name) == ["soft, exact", "stiff, exact", "soft, Monte Carlo, 95 %", "stiff, Monte Carlo, 95 %"]
    assert by_name["soft, exact"].get_color() == by_name["soft, Monte Carlo, 95 %"][0].get_color() == CYCLE[0]
    assert by_name["stiff, exact"].get_color() == CYCLE[1]


def test_the_second_of_two_without_a_name_is_told_apart(runs: Any) -> None:
    axes = panel(None)
    for run in runs:
        sp.figures.plot_density(run, "x", axes)
    assert axes.get_legend_handles_labels()[1] == ["Monte Carlo, 95 %", "2, Monte Carlo, 95 %"]
    assert [container[0].get_color() for container in axes.containers] == ["0.35", CYCLE[1]]
    assert axes.containers[0][0].get_marker() != axes.containers[1][0].get_marker()


def test_a_color_that_is_given_is_taken(runs: Any) -> None:
    axes = sp.figures.plot_density(runs[0], "x", color="tab:red", theory=sp.theory.exact(WIDE))
    assert {axes.lines[-1].get_color(), axes.containers[0][0].get_color()} == {"tab:red"}
    with pytest.raises(TypeError, match=r"^label must be a text, not 3\.$"):
        sp.figures.plot_density(runs[0], "x", label=3)  # type: ignore[arg-type]


def test_designs_of_theory_alone_are_told_apart() -> None:
    axes = panel(None)
    for oscillator in (WIDE, NARROW):
        sp.figures.plot_density(None, "x", axes, theory=sp.theory.exact(oscillator), at=np.linspace(-0.2, 3.0, 50))
    assert axes.get_legend_handles_labels()[1] == ["exact", "2, exact"]
    assert [line.get_color() for line in axes.lines] == [COLORS["black"], CYCLE[1]]


def test_the_cycle_can_be_told_apart_with_any_kind_of_color_vision() -> None:
    """Okabe and Ito's palette, each color once."""
    assert len(set(CYCLE)) == len(CYCLE) == 7
    assert set(CYCLE) <= set(COLORS.values())


def test_sweeps_on_the_same_axes_are_told_apart() -> None:
    axes = panel(None)
    for damping in (0.3, 3.0):
        asked = sp.Oscillator(springpot=sp.Springpot(1.0, damping))
        sp.figures.plot_against("intensity", axes, system=asked, values=[0.5, 1.0], theory=[sp.theory.exact])
    assert [line.get_color() for line in axes.lines] == [COLORS["black"], CYCLE[1]]
