"""Results of a study: panels of curves of theory and Monte Carlo, of lines for two axes, or maps over two axes."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.figures.style import COLORS, CONFIDENCE, LOOKS, METHOD_LINES, bars, method_label, named, new_grid
from springpot.figures.sweeps import MOMENTS, PARAMETER_LABELS
from springpot.machine.faults import known_word, shown
from springpot.problem.catalogue import owner_of

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS, MOST_COLUMNS = 48, 6
LONGEST_LINE = 30  # letters of a panel's title, so that it does not reach that of the next one
WIDE = 30.0  # ratio of largest to smallest value from which an axis is logarithmic


def plot_study(
    tree: xarray.DataTree,
    *,
    quantities: Sequence[str] | None = None,
    kind: str | None = None,
    along: str | None = None,
) -> Figure:
    """Draw a study: a panel for each quantity and each value of the axes that remain.

    The panels of a quantity have the same axes, and maps the same colors, so that they can be compared by eye.

    Parameters
    ----------
    tree : xarray.DataTree
        As `springpot.study` and `springpot.open_study` return it.
    quantities : sequence of str, optional
        Such as ``("amplitude_mean_square", "impact_rate")``; the study's own if left out.  Of systems any result,
        such as ``"upper_power"``; ``"barrier_power"`` has a panel for each wall.
    kind : {"curves", "lines", "map"}, optional
        Curves along one axis, of every theory and of Monte Carlo with bars over 95 % intervals; lines along one axis,
        in a color for each value of a second, of Monte Carlo with these bars and of the last theory; or a map over two
        axes, of Monte Carlo where the study has it, else of its last theory.  Curves if left out.
    along : str, optional
        Axis along which curves or maps run, as the data set names it; the longest if left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If a name is wrong, the study has too few axes for lines or a map, or there would be more than 48 panels.

    Examples
    --------
    >>> import springpot as sp
    >>> tree = sp.study({"name": "orders", "methods": ["averaging"], "axes": {"order": [0.25, 0.5, 1.0]}})
    >>> len(sp.figures.plot_study(tree).axes)
    1
    """
    import json

    parts: dict[str, Any] = {
        name: tree[name].to_dataset() for name in ("theory", "simulation", "exceedance") if name in tree.children
    }
    some = next(iter(parts.values()))
    content = json.loads(tree.attrs["study"])
    known = _drawable(parts)
    names = list(content.get("quantities", ["amplitude_mean_square"]) if quantities is None else quantities)
    for name in names:
        known_word(name, known, "quantities", "must be among")
    if kind not in (None, "curves", "lines", "map"):
        raise ValueError(f"kind must be 'curves', 'lines' or 'map', not {shown(kind)}.")
    dimensions = [str(dimension) for dimension in some["done"].dims if dimension != "theory"]
    if along is not None and along not in dimensions:
        raise ValueError(f"along must be an axis of the study, {' or '.join(dimensions)}, not {shown(along)}.")
    by_length = sorted(dimensions, key=lambda dimension: -some.sizes[dimension])
    used = [along or by_length[0]]
    if kind in ("map", "lines"):
        used += [dimension for dimension in by_length if dimension != used[0]][:1]
        if len(used) < 2:
            raise ValueError(f"kind='{kind}' needs a study with two axes.")
    if kind == "lines" and some.sizes[used[1]] > len(LOOKS):
        raise ValueError(
            f"kind='lines' has a color for at most {len(LOOKS)} values, and {used[1]} has {some.sizes[used[1]]}: "
            "choose along=, or draw a map."
        )
    rest = {dimension: range(some.sizes[dimension]) for dimension in dimensions if dimension not in used}
    places = [dict(zip(rest, numbers, strict=True)) for numbers in itertools.product(*rest.values())]
    quantities_at = [each for name in names for each in _at_walls(parts, name)]
    if len(quantities_at) * len(places) > MOST_PANELS:
        raise ValueError(
            f"quantities and the axes make {len(quantities_at) * len(places)} panels, more than {MOST_PANELS}: "
            "draw fewer, or a map."
        )
    # a column for each value of the last axis that remains, or for each quantity; other values below each other
    last = len([*rest.values()][-1]) if len(rest) > 1 else len(places) if rest else len(quantities_at)
    columns = last if len(rest) > 1 and last <= MOST_COLUMNS else min(4, last)
    rows_of_one = -(-len(places) // columns)
    rows = len(quantities_at) * rows_of_one if rest else -(-len(quantities_at) // columns)
    figure, panels = new_grid(3.6 * columns + 0.4, 3.0 * rows + 0.5, rows, columns)
    legend: dict[str, Any] = {}
    free = [*panels]
    for number, (name, wall) in enumerate(quantities_at):
        begin = number * rows_of_one * columns if rest else number
        group = panels[begin : begin + len(places)]
        here = {part: _at(dataset, name, wall) for part, dataset in parts.items() if name in dataset}
        for ax, place in zip(group, places, strict=True):
            free.remove(ax)
            if ax is not group[0]:  # what is compared has the same axes
                ax.sharex(group[0])
                ax.sharey(group[0])
            own = {part: dataset.isel(place) for part, dataset in here.items()}
            if kind == "map":
                _map(ax, own, name, used, _limits(here, name))
            elif kind == "lines":
                _lines(ax, own, name, used)
            else:
                _curves(ax, own, name, used[0])
            ax.set_title(_in_lines([*filter(None, [wall]), *_title(some, place)]), fontsize="medium")
            legend |= {label: handle for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)}
        if kind == "map":
            figure.colorbar(group[0].collections[0], ax=group, label=_named(_drawn(here)[name]))
        else:
            _scale(group[0], "y", np.hstack([[], *(line.get_ydata() for ax in group for line in ax.lines)]))
        for at, ax in enumerate(group):
            if at % columns:
                ax.set_ylabel("")
                ax.tick_params(labelleft=False)
            if at + columns < len(group):
                ax.set_xlabel("")
                ax.tick_params(labelbottom=False)
    for ax in free:
        ax.set_axis_off()
    if legend:
        title = _named(some[used[1]]) if kind == "lines" else None
        figure.legend(
            legend.values(), legend.keys(), title=title, loc="outside upper center", ncols=min(len(legend), 4)
        )
    return figure


def _drawable(parts: Mapping[str, xarray.Dataset]) -> tuple[str, ...]:
    """The quantities of a study, with those of each wall by its name."""
    found: dict[str, None] = {}
    for dataset in parts.values():
        for variable in map(str, dataset.data_vars):
            if variable.endswith(("_se", "_error", "_low", "_high")) or variable in ("done", "said"):
                continue
            found[variable] = None
            if "barrier" in dataset[variable].dims:
                what = variable.removeprefix("barrier_")
                found |= dict.fromkeys(f"{wall}_{what}" for wall in dataset["barrier"].values)
    return tuple(found)


def _at_walls(parts: Mapping[str, xarray.Dataset], name: str) -> list[tuple[str, str]]:
    """The variable of a quantity, and its wall; all walls where it names none."""
    for dataset in parts.values():
        if name in dataset:
            if level := _level_of(dataset, name):
                return [(name, words) for words in _each_level(dataset[level])]
            own = dataset["barrier"].values if "barrier" in dataset[name].dims else [""]
            return [(name, str(wall)) for wall in own]
    wall = owner_of(name, next(map(str, dataset["barrier"].values) for dataset in parts.values()))
    return [(f"barrier_{name.removeprefix(f'{wall}_')}", wall)]


def _at(dataset: xarray.Dataset, name: str, wall: str) -> xarray.Dataset:
    """What a panel needs of a group."""
    kept = dataset[[part for part in (name, *(f"{name}_{end}" for end in ("se", "low", "high"))) if part in dataset]]
    if level := _level_of(dataset, name):
        return kept.isel({level: _each_level(dataset[level]).index(wall)}, drop=True)
    return kept.sel(barrier=wall, drop=True) if wall else kept


def _level_of(dataset: xarray.Dataset, name: str) -> str:
    """The dimension of a variable's levels, if it is of exceedance."""
    more = {*map(str, dataset[name].dims)} - {*map(str, dataset["done"].dims), "barrier"}
    return more.pop() if more else ""


def _each_level(levels: xarray.DataArray) -> list[str]:
    """The title of the panel of each level."""
    unit = levels.attrs["units"]
    return [f"{levels.attrs['long_name']} through {value:g} {unit}" for value in levels.values]


def _title(some: xarray.Dataset, place: Mapping[str, int]) -> list[str]:
    """The numbers of a panel."""
    return [
        f"{_short(some[name])}{' =' if '.' in _short(some[name]) else ''} {float(some[name][number]):g}"
        for name, number in place.items()
    ]


def _in_lines(words: Sequence[str]) -> str:
    """Words with commas between them, in lines that are no longer than a panel is wide.

    Examples
    --------
    >>> _in_lines(["order 0.5", "restitution 1", "intensity 2"])
    'order 0.5, restitution 1,\\nintensity 2'
    """
    lines = [""]
    for word in words:
        longer = f"{lines[-1]}, {word}" if lines[-1] else word
        if lines[-1] and len(longer) > LONGEST_LINE:
            lines[-1] += ","
            lines.append(word)
        else:
            lines[-1] = longer
    return "\n".join(lines)


def _curves(ax: Axes, parts: Mapping[str, xarray.Dataset], name: str, along: str) -> None:
    for part, dataset in parts.items():
        where = dataset[along].values
        if part != "theory":
            label = "Monte Carlo, 95 %" if part == "simulation" else "exceedance, 95 %"
            value, error = _with_error(dataset, name)
            bars(ax, where, value, error, label=label)
            continue
        for method in dataset["theory"].values:
            color, line = METHOD_LINES[str(method)]
            values = dataset[name].sel(theory=method).values
            if np.isnan(values).all():
                continue
            ax.plot(where, values, color=COLORS[color], linestyle=line, label=method_label(str(method)))
    first = next(iter(parts.values()))
    _axes(ax, first[along], first[name])


def _with_error(dataset: xarray.Dataset, name: str) -> tuple[Any, Any]:
    """Values and standard errors; of an interval that is not symmetric, what would have it."""
    value, error = dataset[name].where(np.isfinite(dataset[name])).values, dataset[f"{name}_se"].values
    if f"{name}_low" in dataset:
        low, high = dataset[f"{name}_low"].values, dataset[f"{name}_high"].values
        error = np.stack([value - low, high - value]) / CONFIDENCE
    return value, error


def _lines(ax: Axes, parts: Mapping[str, xarray.Dataset], name: str, used: Sequence[str]) -> None:
    """A color and a mark for each value of the second axis: theory as a line, Monte Carlo over it."""
    along, other = used
    drawn = _drawn(parts)
    for number, value in enumerate(drawn[other].values):
        (color, mark), own = LOOKS[number], {part: dataset.isel({other: number}) for part, dataset in parts.items()}
        label = f"{float(value):g}"
        if "theory" in own:
            theory = own["theory"].isel(theory=-1)
            ax.plot(
                theory[along].values, theory[name].values, color=COLORS[color], label=None if len(own) > 1 else label
            )
        for part in own.keys() - {"theory"}:
            found, error = _with_error(own[part], name)
            bars(ax, own[part][along].values, found, error, color=COLORS[color], marker=mark, size=4.0, label=label)
    _axes(ax, drawn[along], drawn[name])


def _drawn(parts: Mapping[str, xarray.Dataset]) -> xarray.Dataset:
    """Monte Carlo, or the last theory of a study without it."""
    found = next((parts[part] for part in ("simulation", "exceedance") if part in parts), None)
    return parts["theory"].isel(theory=-1) if found is None else found


def _limits(parts: Mapping[str, xarray.Dataset], name: str) -> tuple[float, float]:
    """The smallest and the largest value of all panels."""
    values = _drawn(parts)[name].values
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)


def _map(
    ax: Axes, parts: Mapping[str, xarray.Dataset], name: str, used: Sequence[str], limits: tuple[float, float]
) -> None:
    (across, up), dataset, (low, high) = used, _drawn(parts), limits
    values = dataset[name].transpose(up, across).values
    where = dataset[across].values, dataset[up].values
    ax.pcolormesh(*where, values, cmap="cividis", shading="nearest", vmin=low, vmax=high)
    _axes(ax, dataset[across], dataset[up])
    _scale(ax, "y", dataset[up].values)


def _axes(ax: Axes, across: xarray.DataArray, up: xarray.DataArray) -> None:
    _scale(ax, "x", across.values)
    ax.set(xlabel=_named(across), ylabel=_named(up))


def _named(column: xarray.DataArray) -> str:
    """A quantity or a parameter with its unit."""
    name = str(column.name).removeprefix("barrier_")
    if name in MOMENTS or name in PARAMETER_LABELS:
        return (MOMENTS.get(name) or PARAMETER_LABELS[name]).removesuffix(" (1)")
    return named(_short(column), column.attrs.get("units", "1"))


def _short(column: xarray.DataArray) -> str:
    """The name of a quantity or parameter; a number of a system's part is called as in the study's file."""
    words = str(column.attrs.get("long_name", ""))
    if words.startswith("parts."):
        return words.removeprefix("parts.")
    return str(column.name).removeprefix("barrier_").replace("_", " ")


def _scale(ax: Axes, which: str, values: np.ndarray[Any, Any]) -> None:
    values = values[np.isfinite(values)]
    if values.size and values.min() > 0.0 and values.max() > WIDE * values.min():
        (ax.set_xscale if which == "x" else ax.set_yscale)("log")
