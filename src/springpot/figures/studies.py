"""Results of a study: panels of curves of theory and Monte Carlo, or maps over two axes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.figures.style import COLOURS, METHOD_LINES, bars, method_label, new_grid
from springpot.figures.sweeps import MOMENTS, PARAMETER_LABELS

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_study"]

MOST_PANELS = 48
WIDE = 30.0  # ratio of largest to smallest value from which an axis is logarithmic


def draw_study(
    tree: xarray.DataTree,
    *,
    quantities: Sequence[str] | None = None,
    kind: str | None = None,
    along: str | None = None,
) -> Figure:
    """Draw a study: a panel for each quantity and each value of the axes that remain.

    Parameters
    ----------
    tree : xarray.DataTree
        As `springpot.study` and `springpot.open_study` return it.
    quantities : sequence of str, optional
        Such as ``("amplitude_mean_square", "impact_rate")``; the study's own if left out.
    kind : {"curves", "map"}, optional
        Curves along one axis, of every theory and of Monte Carlo with bars over 95 % intervals; or a map over two axes,
        of Monte Carlo where the study has it, else of its last theory.  Curves if left out.
    along : str, optional
        Axis along which curves or maps run; the longest if left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If a name is wrong, the study has too few axes for a map, or there would be more than 48 panels.

    Examples
    --------
    >>> import springpot as sp
    >>> tree = sp.study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5, 1.0]}})
    >>> len(draw_study(tree).axes)
    1
    """
    import json

    parts: dict[str, Any] = {
        name: tree[name].to_dataset() for name in ("theory", "simulation") if name in tree.children
    }
    some = next(iter(parts.values()))
    names = json.loads(tree.attrs["study"]).get("quantities", ["amplitude_mean_square"])
    names = list(names if quantities is None else quantities)
    for name in names:
        if name not in MOMENTS:
            raise ValueError(f"quantity must be one of {', '.join(MOMENTS)}, not {name!r}.")
    if kind not in (None, "curves", "map"):
        raise ValueError(f"kind must be 'curves' or 'map', not {kind!r}.")
    dimensions = [str(dimension) for dimension in some["amplitude_mean_square"].dims if dimension != "theory"]
    if along is not None and along not in dimensions:
        raise ValueError(f"along must be an axis of the study, {' or '.join(dimensions)}, not {along!r}.")
    by_length = sorted(dimensions, key=lambda dimension: -some.sizes[dimension])
    used = [along or by_length[0]]
    if kind == "map":
        used += [dimension for dimension in by_length if dimension != used[0]][:1]
        if len(used) < 2:
            raise ValueError("kind='map' needs a study with two axes.")
    places = list(_places(some, [dimension for dimension in dimensions if dimension not in used]))
    if len(places) * len(names) > MOST_PANELS:
        raise ValueError(
            f"quantity and the axes make {len(places) * len(names)} panels, more than {MOST_PANELS}: draw fewer "
            "quantities, or a map."
        )
    columns = min(4, len(places) if len(places) > 1 else len(names))
    rows = -(-len(places) * len(names) // columns)
    figure, panels = new_grid(3.6 * columns + 0.4, 3.0 * rows + 0.5, rows, columns)
    drawn = list(itertools.product(names, places))
    for axes, (name, place) in zip(panels, drawn, strict=False):
        here = {part: dataset.isel(place) for part, dataset in parts.items()}
        if kind == "map":
            _map(axes, here, name, used)
        else:
            _curves(axes, here, name, used[0])
        axes.set_title(_title(some, place), fontsize="medium")
    for axes in panels[len(drawn) :]:
        axes.set_axis_off()
    if kind != "map":
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def _places(some: xarray.Dataset, rest: Sequence[str]) -> Iterator[dict[str, int]]:
    for numbers in itertools.product(*(range(some.sizes[dimension]) for dimension in rest)):
        yield dict(zip(rest, numbers, strict=True))


def _title(some: xarray.Dataset, place: Mapping[str, int]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {float(some[name][number]):g}" for name, number in place.items())


def _curves(axes: Axes, parts: Mapping[str, xarray.Dataset], name: str, along: str) -> None:
    for part in ("theory", "simulation"):
        if part not in parts:
            continue
        dataset = parts[part]
        where = dataset[along].values
        if part == "simulation":
            bars(axes, where, dataset[name].values, dataset[f"{name}_se"].values, label="Monte Carlo, 95 %")
            continue
        for method in dataset["theory"].values:
            color, line = METHOD_LINES[str(method)]
            values = dataset[name].sel(theory=method).values
            axes.plot(where, values, color=COLOURS[color], linestyle=line, label=method_label(str(method)))
    _scale(axes, "x", where)
    axes.set_xlabel(PARAMETER_LABELS.get(along, along))
    axes.set_ylabel(MOMENTS[name])


def _map(axes: Axes, parts: Mapping[str, xarray.Dataset], name: str, used: Sequence[str]) -> None:
    across, up = used
    dataset = parts["simulation"] if "simulation" in parts else parts["theory"].isel(theory=-1)
    values = dataset[name].transpose(up, across).values
    shown = axes.pcolormesh(dataset[across].values, dataset[up].values, values, cmap="cividis", shading="nearest")
    axes.figure.colorbar(shown, ax=axes, label=MOMENTS[name])
    _scale(axes, "x", dataset[across].values)
    _scale(axes, "y", dataset[up].values)
    axes.set_xlabel(PARAMETER_LABELS.get(across, across))
    axes.set_ylabel(PARAMETER_LABELS.get(up, up))


def _scale(axes: Axes, which: str, values: np.ndarray[Any, Any]) -> None:
    if values.min() > 0.0 and values.max() > WIDE * values.min():
        (axes.set_xscale if which == "x" else axes.set_yscale)("log")
