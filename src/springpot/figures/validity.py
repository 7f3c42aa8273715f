"""Pictures of the validity maps: gaps of the methods to Monte Carlo, over order and strength of the springpot."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP, Map, exists, read_map
from springpot.figures.style import MOMENT_WORDS, method_label, new_grid, panel
from springpot.machine.faults import known_word, listed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMES = {name: symbol for name, (_, symbol, _, _) in MOMENT_WORDS.items()}
NAMES["rarest_impact_rate"] = "impact rate of the wall struck least"
LARGEST = 12.0  # per cent at which the colors end

CASES: Mapping[str, Mapping[str, float]] = {
    "no wall\n$\\kappa$ = 0.1": {"walls": 0, "hardening": 0.1},
    "no wall\n$\\kappa$ = 1": {"walls": 0, "hardening": 1.0},
    "no wall\n$\\kappa$ = 10": {"walls": 0, "hardening": 10.0},
    "one wall\n$\\kappa$ = 1, $r$ = 1": {"walls": 1, "hardening": 1.0},
    "one wall\n$\\kappa$ = 1, $r$ = 0.8": {"walls": 1, "restitution": 0.8, "hardening": 1.0},
    "two walls, near\n$\\kappa$ = 0, $r$ = 0.8": {"walls": 2, "position": 0.5, "restitution": 0.8},
    "unlike walls\n$\\kappa$ = 0, $r$ = 0.8": {"walls": 2, "position": 1.0, "apart": 1.0, "restitution": 0.8},
    "no wall, $\\tau$ = 1\n$\\kappa$ = 1": {"walls": 0, "color": 1.0, "hardening": 1.0},
    "one wall, $\\tau$ = 1\n$\\kappa$ = 1, $r$ = 1": {"walls": 1, "color": 1.0, "hardening": 1.0},
}
"""Columns of `plot_system_gaps_of_methods`: what differs from a linear spring, white noise, walls at 0, r = 1."""

_USUAL = {"position": 0.0, "apart": 0.0, "restitution": 1.0, "color": 0.0, "hardening": 0.0}

Cells = Mapping[str, np.ndarray[Any, Any]]


def plot_gaps(
    method: str,
    moment: str = "amplitude_mean_square",
    ax: Axes | None = None,
    *,
    restitution: float = 1.0,
    position: float = 0.0,
    path: Path = PAPER_MAP.file,
) -> Axes:
    """Draw the gap of one method to Monte Carlo, in per cent, over order and strength of the springpot.

    Parameters
    ----------
    method : {"averaging", "averaging_amplitude", "envelope", "memory_closure"}
    moment : str
        Any of `springpot.theory.result.MOMENTS`.
    <ax>
    restitution, position : float
        Of the wall, the position in units of sqrt(q / Omega^3); the map has r = 1, 0.8 and 0.5 at six positions, and
        r = 0.9 and 0.7 at position 0.
    path : Path
        The map; the one that comes with the package if left out.

    <returns axes>
        One cell for each order and c = C Omega^(alpha-2); hatched where the method has no result, blank where Monte
        Carlo is too uncertain, bold for gaps that give a warning.

    Raises
    ------
    ValueError
        If the map has no such method, moment, restitution or position.

    Examples
    --------
    >>> import springpot as sp
    >>> axes = sp.figures.plot_gaps("averaging")
    >>> [text.get_text() for text in axes.texts][-1]  # at order 1 averaging is exact
    '+0.0'
    """
    return _alone(ax, 3.8, PAPER_MAP, path, method, moment, {"restitution": restitution, "position": position})


def _alone(
    ax: Axes | None, height: float, atlas: Map, path: Path, method: str, moment: str, case: Mapping[str, float]
) -> Axes:
    """A panel that stands alone, of the cells of a map with these numbers."""
    known_word(method, atlas.methods, "method")
    known_word(moment, atlas.good, "moment")
    cells = _chosen(read_map(path), case)
    if not cells["c"].size:
        raise ValueError(f"the map has no cells with {listed([f'{name} {value:g}' for name, value in case.items()])}.")
    ax = panel(ax, 4.6, height)
    _panel(ax, cells, f"{method}:{moment}", atlas.good[moment])
    ax.set(xlabel=r"strength $c = C\,\Omega^{\alpha-2}$ (1)", ylabel=r"order $\alpha$ (1)")
    ax.set_title(f"{method_label(method)}: {NAMES[moment]}, gap to Monte Carlo in %", fontsize="medium")
    return ax


def plot_gaps_of_methods(
    moment: str, along: str, *, methods: Sequence[str] = PAPER_MAP.methods, path: Path = PAPER_MAP.file
) -> Figure:
    """Draw the gap of one moment: a row for each method, a column for each restitution or wall position.

    Parameters
    ----------
    moment : str
        Any of `springpot.theory.result.MOMENTS`.
    along : {"restitution", "position"}
        What changes from column to column: the restitution with the wall at 0, or its place with an elastic wall.
    methods : sequence of str
    path : Path
        The map; the one that comes with the package if left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no such moment, or ``along`` is another word.

    Examples
    --------
    >>> len(plot_gaps_of_methods("x_mean", "restitution").axes) > 20
    True
    """
    known_word(moment, PAPER_MAP.good, "moment")
    known_word(along, ("restitution", "position"), "along")
    cells = read_map(path)
    fixed, value, symbol = ("position", 0.0, "r") if along == "restitution" else ("restitution", 1.0, "b")
    columns = {
        f"${symbol}$ = {step:g}": _chosen(cells, {fixed: value, along: step})
        for step in sorted(set(cells[along][cells[fixed] == value]), reverse=along == "restitution")
    }
    size = 2.05 * len(columns) + 1.2, 1.9 * len(methods) + 0.9
    figure = _grid(columns, methods, moment, PAPER_MAP.good[moment], size, "blank: Monte Carlo too uncertain")
    where = "wall at the equilibrium" if along == "restitution" else r"elastic wall at $b\,\sqrt{\Omega^3/q}$"
    figure.suptitle(f"Gap of {NAMES[moment]} to Monte Carlo from an adapted start, {where}", fontsize=10)
    return figure


def plot_system_gaps(
    method: str,
    moment: str = "x_mean_square",
    ax: Axes | None = None,
    *,
    walls: int = 0,
    position: float = 0.0,
    apart: float = 0.0,
    restitution: float = 1.0,
    color: float = 0.0,
    hardening: float = 1.0,
    path: Path = SYSTEMS_MAP.file,
) -> Axes:
    """Draw the gap of one method to Monte Carlo for systems, in per cent, over order and strength of the springpot.

    Parameters
    ----------
    method : {"averaging_amplitude", "linearization", "envelope", "half_cycles", "path_integration"}
    moment : str
        Any that `springpot.evidence.reliability.SYSTEMS_MAP` has gaps of.
    <ax>
    walls, position, apart, restitution, color, hardening
        The other numbers of `springpot.evidence.cells.Cell`.
    path : Path
        The map; the one that comes with the package if left out.

    <returns axes>
        As of `plot_gaps`.

    Raises
    ------
    ValueError
        If the map has no such method, moment or cells.

    Examples
    --------
    >>> import springpot as sp
    >>> axes = sp.figures.plot_system_gaps("linearization", "v_mean_square", hardening=1.0)
    >>> len(axes.texts) >= 12
    True
    """
    case = {
        "walls": walls, "position": position, "apart": apart, "restitution": restitution, "color": color,
        "hardening": hardening,
    }  # fmt: skip
    return _alone(ax, 3.2, SYSTEMS_MAP, path, method, moment, case)


def plot_system_gaps_of_methods(
    moment: str, *, methods: Sequence[str] = SYSTEMS_MAP.methods, path: Path = SYSTEMS_MAP.file
) -> Figure:
    """Draw the gap of one moment of systems: a row for each method, a column for each of some kinds of systems.

    Parameters
    ----------
    moment : str
        Any that `springpot.evidence.reliability.SYSTEMS_MAP` has gaps of.
    methods : sequence of str
    path : Path
        The map; the one that comes with the package if left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If there is no such moment.

    Examples
    --------
    >>> len(plot_system_gaps_of_methods("impact_rate").axes) > 7
    True
    """
    known_word(moment, SYSTEMS_MAP.good, "moment")
    cells = read_map(path)
    columns = {
        title: _chosen(cells, _USUAL | dict(case))
        for title, case in CASES.items()
        if exists(moment, _USUAL | dict(case))
    }
    size, blank = (1.75 * len(columns) + 1.2, 1.6 * len(methods) + 1.1), "blank: no cell, or Monte Carlo too uncertain"
    orders = sorted(set(cells["order"]))
    figure = _grid(columns, methods, moment, SYSTEMS_MAP.good[moment], size, blank, orders, small=True)
    figure.suptitle(f"Systems: gap of {NAMES[moment]}\nto Monte Carlo; walls at or about the equilibrium", fontsize=9)
    return figure


def _grid(
    columns: Mapping[str, Cells], methods: Sequence[str], moment: str, good: float, size: tuple[float, float],
    blank: str, orders: Sequence[float] = (), *, small: bool = False,
) -> Figure:  # fmt: skip
    """A row for each method, a column for each title, and a bar that explains the colors."""
    figure, panels = new_grid(*size, len(methods), len(columns))
    image: Any = None
    words: Any = {"fontsize": 8} if small else {}
    note: Any = {"fontsize": 7} if small else {}
    for ax, (method, (title, here)) in zip(panels, itertools.product(methods, columns.items()), strict=True):
        image = _panel(ax, here, f"{method}:{moment}", good, orders)
        place: Any = ax.get_subplotspec()
        if place.is_first_row():
            ax.set_title(title, **words)
        if place.is_first_col():
            ax.set_ylabel(method.replace("_", "\n") + "\n\n" + r"order $\alpha$", **words)
        else:
            ax.set_yticklabels([])
        if place.is_last_row():
            ax.set_xlabel(r"$c = C\,\Omega^{\alpha-2}$", **words)
        else:
            ax.set_xticklabels([])
    bar = figure.colorbar(image, ax=panels, shrink=0.6, extend="both")
    bar.set_label(
        f"(theory / Monte Carlo - 1) of {NAMES[moment]}, %\nbold: more than {good:g} %; grey: no result; {blank}",
        **note,
    )
    return figure


def _chosen(cells: Cells, numbers: Mapping[str, float]) -> Cells:
    """The cells with these numbers."""
    chosen = np.all([cells[name] == value for name, value in numbers.items()], axis=0)
    return {name: column[chosen] for name, column in cells.items()}


def _panel(panel: Axes, here: Cells, name: str, good: float, orders: Sequence[float] = ()) -> Any:
    from matplotlib.patches import Rectangle

    orders, strengths = orders or sorted(set(here["order"])), sorted(set(here["c"]))
    gaps = np.full((len(orders), len(strengths)), np.nan)
    for order, c, gap in zip(here["order"], here["c"], here[name], strict=True):
        gaps[orders.index(order), strengths.index(c)] = gap
    shown = np.where(np.isfinite(gaps), gaps, np.nan)
    panel.grid(visible=False)
    image = panel.imshow(shown, origin="lower", aspect="auto", cmap="PuOr_r", vmin=-LARGEST, vmax=LARGEST)
    for (row, column), gap in np.ndenumerate(gaps):
        if math.isinf(gap):
            place = column - 0.5, row - 0.5
            panel.add_patch(Rectangle(place, 1.0, 1.0, facecolor="0.8", edgecolor="white", hatch="///", lw=0.0))
        elif math.isfinite(gap):
            far = abs(gap) > 0.7 * LARGEST
            panel.text(
                column, row, f"{gap:+.1f}" if abs(gap) < 9.95 else f"{gap:+.0f}",
                ha="center", va="center", fontsize=6.5,
                color="white" if far else "black", weight="bold" if abs(gap) > good else "normal",
            )  # fmt: skip
    panel.set_xticks(range(len(strengths)), [f"{c:g}" for c in strengths], fontsize=7)
    panel.set_yticks(range(len(orders)), [f"{order:g}" for order in orders], fontsize=7)
    return image
