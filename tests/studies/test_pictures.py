"""Pictures of studies: the panels, labels and numbers are those of the store."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import xarray

import springpot as sp
from springpot.figures import plot_study
from springpot.figures.style import COLORS, LOOKS
from tests.studies.samples import DEVICE, RUNS


@pytest.fixture(scope="module")
def tree() -> xarray.DataTree:
    return sp.study(RUNS, threads=2)


def test_small_multiples_of_curves(tree: xarray.DataTree) -> None:
    figure = plot_study(tree)
    drawn = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title() for axes in drawn] == ["restitution 1", "restitution 0.8"] * 2
    assert all("order" in axes.get_xlabel() for axes in drawn)  # one row of panels for each quantity
    assert len({axes.get_ylabel() for axes in drawn[::2]}) == 2
    assert [axes.get_ylabel() for axes in drawn[1::2]] == ["", ""]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "Monte Carlo, 95 %" in legend
    assert len(legend) == 2
    theory = tree["theory"]["amplitude_mean_square"].sel(theory="averaging", restitution=0.8)
    (line,) = [line for line in drawn[1].lines if len(line.get_xdata()) == 3 and line.get_linestyle() != "None"][:1]
    np.testing.assert_array_equal(line.get_xdata(), [0.4, 0.7, 1.0])
    np.testing.assert_array_equal(line.get_ydata(), theory.values)


def test_along_another_axis(tree: xarray.DataTree) -> None:
    figure = plot_study(tree, quantities=["impact_rate"], along="restitution")
    drawn = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title() for axes in drawn] == ["order 0.4", "order 0.7", "order 1"]
    assert {"restitution" in axes.get_xlabel() for axes in drawn} == {True}


def test_a_map(tree: xarray.DataTree) -> None:
    figure = plot_study(tree, quantities=["impact_rate"], kind="map")
    panel, bar = figure.axes
    (mesh,) = panel.collections
    shown = np.asarray(mesh.get_array())
    np.testing.assert_array_equal(shown, tree["simulation"]["impact_rate"].transpose("restitution", "order").values)
    assert ("order" in panel.get_xlabel(), "restitution" in panel.get_ylabel()) == (True, True)
    assert "s$^{-1}$" in bar.get_ylabel() or "s⁻¹" in bar.get_ylabel() or "1/s" in bar.get_ylabel()


THREE = {
    "name": "three", "methods": ["averaging"], "quantities": ["amplitude_mean_square"],
    "axes": {"order": [0.3, 0.5, 0.7, 1.0], "coefficient": [0.1, 0.3, 1.0], "intensity": [1.0, 3.0]},
}  # fmt: skip


@pytest.fixture(scope="module")
def three() -> xarray.DataTree:
    return sp.study(THREE, threads=1)


def test_panels_of_three_parameters_have_the_same_axes(three: xarray.DataTree) -> None:
    """A row for each value of the one, a column for each of the other, which is the same for the eye."""
    figure = plot_study(three)
    drawn = [axes for axes in figure.axes if axes.axison]
    assert len(drawn) == 6
    assert {axes.get_xlim() for axes in drawn} == {drawn[0].get_xlim()}
    assert {axes.get_ylim() for axes in drawn} == {drawn[0].get_ylim()}
    assert {axes.get_yscale() for axes in drawn} == {"log"}  # from 0.3 to 50
    columns = {round(axes.get_position().x0, 3) for axes in drawn}
    assert len(columns) == 2
    assert [bool(axes.get_ylabel()) for axes in drawn] == [True, False] * 3
    assert [bool(axes.get_xlabel()) for axes in drawn] == [False] * 4 + [True] * 2


def test_lines_have_a_color_and_a_mark_for_each_value(three: xarray.DataTree) -> None:
    """In colors that are told apart with any color vision, and the numbers are those of the study."""
    figure = plot_study(three, kind="lines")
    drawn = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title() for axes in drawn] == ["intensity 1", "intensity 3"]
    assert drawn[0].get_ylim() == drawn[1].get_ylim()
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["0.1", "0.3", "1"]
    assert "coefficient" in figure.legends[0].get_title().get_text()
    for number, axes in enumerate(drawn):
        assert [line.get_color() for line in axes.lines] == [COLORS[color] for color, _ in LOOKS[:3]]
        for coefficient, line in enumerate(axes.lines):
            theory = three["theory"]["amplitude_mean_square"].isel(theory=0, coefficient=coefficient, intensity=number)
            np.testing.assert_array_equal(line.get_ydata(), theory.values)


def test_lines_of_monte_carlo_have_bars(tree: xarray.DataTree) -> None:
    (panel,) = (axes for axes in plot_study(tree, kind="lines", quantities=["impact_rate"]).axes if axes.axison)
    assert [bar.lines[0].get_marker() for bar in panel.containers] == [mark for _, mark in LOOKS[:2]]
    found = tree["simulation"]["impact_rate"].isel(restitution=1).values
    np.testing.assert_array_equal(panel.containers[1].lines[0].get_ydata(), found)


def test_maps_of_one_quantity_have_the_same_colors(three: xarray.DataTree) -> None:
    figure = plot_study(three, kind="map")
    *panels, bar = figure.axes
    assert len(panels) == 2
    assert bar.get_ylabel().startswith("mean square amplitude")
    limits = [panel.collections[0].get_clim() for panel in panels]
    values = three["theory"]["amplitude_mean_square"].values
    assert limits == [(values.min(), values.max())] * 2


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"quantities": ["x"]}, "quantities must be among amplitude_mean_square, "),
        ({"along": "position"}, "along must be an axis of the study, order or restitution, not 'position'"),
        ({"kind": "pie"}, "kind must be 'curves', 'lines' or 'map', not 'pie'"),
    ],
)
def test_what_cannot_be_drawn(how: dict[str, object], says: str, tree: xarray.DataTree) -> None:
    with pytest.raises(ValueError, match=says):
        plot_study(tree, **how)  # type: ignore[arg-type]


def test_long_titles_do_not_reach_their_neighbours() -> None:
    axes = {
        "parts.magnet.coefficients.3": [4e5, 6e5, 8e5], "parts.lower.position": [-1e-3, -2e-3],
        "parts.white_noise.intensity": [5e-5, 1e-4], "parts.spring.stiffness": [80.0, 90.0],
    }  # fmt: skip
    asked = {"name": "long", "system": DEVICE, "methods": ["linearization"], "axes": axes}
    figure = plot_study(sp.study({**asked, "quantities": ["x_mean_square"]}, threads=1))
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    boxes = [axes.title.get_window_extent(canvas.get_renderer()) for axes in figure.axes if axes.axison]
    assert len(boxes) == 8
    assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


def test_too_many_panels_and_too_few_axes() -> None:
    grid = {"coefficient": list(np.linspace(0.1, 1.0, 50)), "order": [0.5, 1.0]}
    wide = sp.study({"name": "wide", "methods": ["averaging"], "axes": grid, "fixed": {"restitution": 1.0}}, threads=1)
    with pytest.raises(ValueError, match="quantities and the axes make 50 panels, more than 48: draw fewer"):
        plot_study(wide, along="order")
    with pytest.raises(ValueError, match="kind='map' needs a study with two axes"):
        plot_study(wide.isel(coefficient=0, drop=True), kind="map")
    with pytest.raises(ValueError, match="kind='lines' has a color for at most 7 values, and coefficient has 50"):
        plot_study(wide, kind="lines", along="order")
