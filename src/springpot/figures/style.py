"""The look that all pictures share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["COLOURS", "new_figure", "new_grid", "save"]

# Okabe and Ito's palette: told apart with any kind of colour vision, and in grey by their lightness.
COLOURS = {
    "black": "#000000",
    "blue": "#0072B2",
    "orange": "#E69F00",
    "green": "#009E73",
    "vermilion": "#D55E00",
    "sky": "#56B4E9",
    "purple": "#CC79A7",
}


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
        Drawn without a screen: it belongs to no window and no global state.
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
    figure.savefig(path, format="png", dpi=160)
    return path
