"""The common style of all pictures; a method's color stands beside the method, in ``theory/registry.py``."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.files import write
from springpot.theory.registry import METHODS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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

LOOKS = (
    ("blue", "o"), ("vermilion", "s"), ("green", "^"), ("purple", "D"), ("orange", "v"), ("sky", "P"), ("black", "X"),
)  # fmt: skip
"""Color and mark of the first, second, ... of several things in one picture."""

METHOD_LINES: dict[str, tuple[str, str | tuple[int, tuple[float, ...]]]] = {
    name: (method.color, (0, method.dash) if method.dash else "-") for name, method in METHODS.items()
}
"""Color and line of each method of the theory; the lines are distinct without color too."""

MOMENT_WORDS = {
    "amplitude_mean_square": ("mean square amplitude ", r"$\langle A^2\rangle$", "m$^2$", r"$\,\Omega^3/q$"),
    "x_mean": ("mean displacement ", r"$\langle x\rangle$", "m", r"$\,\sqrt{\Omega^3/q}$"),
    "x_mean_square": ("mean square displacement ", r"$\langle x^2\rangle$", "m$^2$", r"$\,\Omega^3/q$"),
    "v_mean_square": ("mean square velocity ", r"$\langle v^2\rangle$", "m$^2$/s$^2$", r"$\,\Omega/q$"),
    "impact_rate": ("", "impact rate", "1/s", r" / $\Omega$"),
    "impact_speed_mean": ("", "mean impact speed", "m/s", r" $\cdot\,\sqrt{\Omega/q}$"),
    "impact_speed_mean_square": ("", "mean square impact speed", "m$^2$/s$^2$", r" $\cdot\,\Omega/q$"),
}
"""Of each moment: words before its symbol, its symbol or short name, its unit, and what makes it dimensionless."""

_COMMON = {
    "ax": "ax : matplotlib.axes.Axes, optional\n        Where to draw; a new figure if left out.",
    "label, color": "label, color : str, optional\n"
                    "        Name of this design in the legend, and its color; by default the next ones of the axes.",
    "of": "of : str\n"
          "        Of several masses: the mass whose displacement it is, or the part whose elongation it is.",
    "returns axes": "Returns\n    -------\n    matplotlib.axes.Axes",
}  # fmt: skip
"""What docstrings of pictures have in common: it stands there as ``<ax>``."""
CONFIDENCE = 1.96  # standard errors on either side of a 95 % interval


def with_common_words(picture: Any) -> None:
    """Fill in what the docstring of a picture has in common with others."""
    for word, meaning in _COMMON.items():
        picture.__doc__ = (picture.__doc__ or "").replace(f"    <{word}>\n", f"    {meaning}\n")


def method_label(method: str) -> str:
    """The name of a method in a legend.

    Examples
    --------
    >>> method_label("fokker_planck")
    'Fokker-Planck'
    """
    return METHODS[method].label if method in METHODS else method.replace("_", ", ")


def method_curve(
    ax: Axes, method: str, place: ArrayLike, values: ArrayLike, *, color: str | None = None, label: str = "",
    gid: str | None = None,
) -> None:  # fmt: skip
    """Draw a curve of the theory with the line of its method.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    method : str
        A key of METHOD_LINES; another one is drawn as a black line.
    place, values : array_like, shape (n,)
    color, label : str, optional
        Instead of those of the method.
    gid : str, optional
        Of the line.

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
        label=label or method_label(method), gid=gid,
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
    gid: str | None = None,
) -> None:
    """Draw Monte Carlo: a mark for each value, and a bar for its 95 % interval.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    place, value, standard_error : array_like, shape (n,)
        The bars reach 1.96 standard errors up and down; of shape (2, n) they are those down and those up.
    color, marker, size, hollow, label, gid
        Of the marks.

    Examples
    --------
    >>> own = panel(None)
    >>> bars(own, [1.0, 2.0], [1.0, 4.0], [0.1, 0.2], label="Monte Carlo")
    >>> len(own.containers)
    1
    """
    error = CONFIDENCE * np.asarray(standard_error, dtype=float)
    ax.errorbar(
        place, value, yerr=error, fmt=marker, color=color, markersize=size, fillstyle="none" if hollow else "full",
        label=label, gid=gid, markeredgewidth=0.9, elinewidth=0.9, capsize=1.5,
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
    return _panels(width, height, len(ratios), 1, sharex=True, height_ratios=ratios)


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
    return _panels(width, height, rows, columns)


def _panels(width: float, height: float, rows: int, columns: int, **how: Any) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes: list[Axes] = list(figure.subplots(rows, columns, squeeze=False, **how).ravel())
    for ax in axes:
        ax.grid(visible=True, color="0.9", linewidth=0.6)
        ax.set_axisbelow(True)
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def named(words: str, unit: str) -> str:
    r"""The words for a quantity or a number, with its unit, whose powers are exponents.

    Examples
    --------
    >>> named("x mean", "s-1"), named("c", "m^(1-exponent) s^alpha kg"), named("order", "1")
    ('x mean (s$^{-1}$)', 'c (m$^{1-exponent}$ s$^{\\alpha}$ kg)', 'order')
    """
    if unit in ("", "1"):
        return words
    raised = re.sub(r"([a-zA-Z])(?:\^\(?([^) ]+)\)?|(-?[\d.]+))", r"\1$^{\2\3}$", unit).replace("alpha", r"\alpha")
    return f"{words} ({raised})"


def plain_ticks(ax: Axes) -> None:
    """Numbers, not powers of ten, on logarithmic axes of few decades.

    Examples
    --------
    >>> ax = panel(None)
    >>> ax.set(xscale="log", xlim=(0.2, 3.0))  # doctest: +ELLIPSIS
    [...]
    >>> plain_ticks(ax)
    >>> ax.xaxis.get_major_formatter()(0.5)
    '0.5'
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for axis in (ax.xaxis, ax.yaxis):
        if axis.get_scale() == "log":
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())


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
