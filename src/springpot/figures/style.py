"""The common style of all pictures; a method's color stands beside the method, in ``theory/registry.py``."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.files import write
from springpot.theory.registry import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["COLORS", "METHOD_LINES", "bars", "method_curve", "method_label", "new_figure", "new_grid", "panel", "save"]

# Okabe and Ito's palette: safe for color-blind readers, and distinct in grey
COLORS = {
    "black": "#000000",
    "blue": "#0072B2",
    "orange": "#E69F00",
    "green": "#009E73",
    "vermilion": "#D55E00",
    "sky": "#56B4E9",
    "purple": "#CC79A7",
}

METHOD_LINES: dict[str, tuple[str, str | tuple[int, tuple[float, ...]]]] = {
    name: (method.color, (0, method.dash) if method.dash else "-") for name, method in METHODS.items()
}
"""Color and line of each method of the theory; the lines are distinct without color too."""

_CONFIDENCE = 1.96  # standard errors on either side of a 95 % interval


def method_label(method: str) -> str:
    """The name of a method in a legend.

    Examples
    --------
    >>> method_label("fokker_planck")
    'Fokker-Planck'
    """
    return METHODS[method].label if method in METHODS else method.replace("_", ", ")


def method_curve(
    ax: Axes, method: str, place: ArrayLike, values: ArrayLike, *, color: str | None = None, label: str = ""
) -> None:
    """Draw a curve of the theory with the line of its method.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    method : str
        A key of METHOD_LINES; another one is drawn as a black line.
    place, values : array_like, shape (n,)
    color, label : str, optional
        Instead of those of the method.

    Examples
    --------
    >>> own = panel(None)
    >>> method_curve(own, "memory_closure", [0.0, 1.0], [1.0, 2.0])
    >>> own.lines[0].get_label()
    'memory closure'
    """
    own, line = METHOD_LINES.get(method, ("black", "-"))
    ax.plot(
        place, values, linestyle=line, linewidth=1.4, color=color or COLORS[own],
        label=label or method_label(method),
    )  # fmt: skip


def panel(ax: Axes | None, width: float = 5.6, height: float = 3.8) -> Axes:
    """The given axes, or those of a new figure with one panel.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or None
    width, height : float
        Size of a new figure in inches.

    Returns
    -------
    matplotlib.axes.Axes

    Examples
    --------
    >>> own = panel(None)
    >>> panel(own) is own
    True
    """
    return new_figure(width, height)[1][0] if ax is None else ax


def bars(
    ax: Axes,
    place: ArrayLike,
    value: ArrayLike,
    standard_error: ArrayLike,
    *,
    color: str = "0.35",
    marker: str = "o",
    size: float = 3.0,
    hollow: bool = False,
    label: str | None = None,
) -> None:
    """Draw Monte Carlo: a mark for each value, and a bar for its 95 % interval.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    place, value, standard_error : array_like, shape (n,)
        The bars reach 1.96 standard errors up and down.
    color, marker, size, hollow, label
        Of the marks.

    Examples
    --------
    >>> own = panel(None)
    >>> bars(own, [1.0, 2.0], [1.0, 4.0], [0.1, 0.2], label="Monte Carlo")
    >>> len(own.containers)
    1
    """
    error = _CONFIDENCE * np.asarray(standard_error, dtype=float)
    look: dict[str, Any] = {"markeredgewidth": 0.9, "elinewidth": 0.9, "capsize": 1.5}
    ax.errorbar(
        place, value, yerr=error, fmt=marker, color=color, markersize=size, fillstyle="none" if hollow else "full",
        label=label, **look,
    )  # fmt: skip


def new_figure(width: float, height: float, ratios: tuple[float, ...] = (1.0,)) -> tuple[Figure, list[Axes]]:
    """Make a figure with one panel for each ratio, stacked on a common horizontal axis.

    Parameters
    ----------
    width, height : float
        Size in inches.
    ratios : tuple of float
        Heights of the panels, from the top, relative to each other.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Without a window and without global state.
    axes : list of matplotlib.axes.Axes
        The panels from the top.

    Examples
    --------
    >>> figure, axes = new_figure(5.0, 4.0, ratios=(2.0, 1.0))
    >>> len(axes)
    2
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    grid = figure.subplots(len(ratios), 1, sharex=True, squeeze=False, height_ratios=list(ratios))
    axes: list[Axes] = list(grid[:, 0])
    _plain(axes)
    return figure, axes


def new_grid(width: float, height: float, rows: int, columns: int) -> tuple[Figure, list[Axes]]:
    """Make a figure with panels in rows and columns, each with axes of its own.

    Parameters
    ----------
    width, height : float
        Size in inches.
    rows, columns : int

    Returns
    -------
    figure : matplotlib.figure.Figure
    axes : list of matplotlib.axes.Axes
        The panels row by row, from the top left.

    Examples
    --------
    >>> len(new_grid(6.0, 4.0, 2, 3)[1])
    6
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes: list[Axes] = list(figure.subplots(rows, columns, squeeze=False).ravel())
    _plain(axes)
    return figure, axes


def _plain(axes: list[Axes]) -> None:
    for panel in axes:
        panel.grid(visible=True, color="0.9", linewidth=0.6)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG at 160 dots per inch and return where it is.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : Path

    Returns
    -------
    Path

    Raises
    ------
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> figure, _ = new_figure(2.0, 2.0)
    >>> save(figure, Path(tempfile.mkdtemp()) / "empty.png").name
    'empty.png'
    """
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=160)
    write(str(path), content.getbuffer())
    return path
