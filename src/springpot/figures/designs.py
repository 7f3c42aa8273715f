"""Several designs on the same axes: each has its own color and name in the legend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from springpot.figures.style import COLORS, bars, method_curve, method_label

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

__all__ = ["CYCLE", "Design", "from_zero", "next_design"]

CYCLE = tuple(COLORS[name] for name in ("blue", "vermilion", "green", "purple", "orange", "sky", "black"))
"""Colors of the first, second, ... design, safe for color-blind readers."""

_MARKS = ("o", "s", "^", "D", "v", "P", "X")
_TAG = "design "


@dataclass(frozen=True)
class Design:
    """One design on some axes: what one call draws.

    Attributes
    ----------
    ax : matplotlib.axes.Axes
    number : int
        Number of earlier designs on these axes.
    color : str or None
        Color of the whole design; None for the default: Monte Carlo in grey, and the colors of the methods.
    label : str
        Name in the legend; may be empty.
    """

    ax: Axes
    number: int
    color: str | None
    label: str

    def bars(
        self, place: ArrayLike, value: ArrayLike, standard_error: ArrayLike, *, measured: str, size: float = 3.0
    ) -> None:
        """Draw Monte Carlo with its 95 % bars; ``measured`` is its text in the legend."""
        before = set(self.ax.get_children())
        label = ", ".join(filter(None, [self.label, measured]))
        mark = _MARKS[self.number % len(_MARKS)]
        bars(self.ax, place, value, standard_error, color=self.color or "0.35", marker=mark, size=size, label=label)
        self.tag(before)

    def curve(self, method: str, place: ArrayLike, values: ArrayLike) -> None:
        """Draw a curve of the theory."""
        before = set(self.ax.get_children())
        label = ", ".join(filter(None, [self.label, method_label(method)]))
        method_curve(self.ax, method, place, values, color=self.color, label=label)
        self.tag(before)

    def tag(self, before: set[Artist]) -> None:
        """Mark all artists that are on the axes but not in ``before`` as part of this design."""
        for artist in self.ax.get_children():
            if artist not in before:
                artist.set_gid(f"{_TAG}{self.number}")


def next_design(ax: Axes, color: str | None = None, label: str | None = None) -> Design:
    """The next design on these axes.

    The first one without a label has default colors.  Others have one color for Monte Carlo and theory (by default
    the next one of CYCLE) and a label (by default a number).

    Parameters
    ----------
    ax : matplotlib.axes.Axes
    color, label : str, optional

    Returns
    -------
    Design

    Raises
    ------
    TypeError
        If the label is not a text.

    Examples
    --------
    >>> from springpot.figures.style import panel
    >>> ax = panel(None)
    >>> next_design(ax).color is None, next_design(ax, label="soft").color
    (True, '#0072B2')
    >>> next_design(ax, label="soft").curve("exact", [0.0, 1.0], [0.0, 1.0])
    >>> next_design(ax).label, next_design(ax).color, ax.lines[0].get_label()
    ('2', '#D55E00', 'soft, exact')
    """
    if label is not None and not isinstance(label, str):
        raise TypeError(f"label must be a text, not {label!r}.")
    drawn = {gid for artist in ax.get_children() if (gid := artist.get_gid() or "").startswith(_TAG)}
    number = len(drawn)
    if color is None and (number > 0 or label is not None):
        color = CYCLE[number % len(CYCLE)]
    return Design(ax, number, color, label if label is not None else str(number + 1) if number else "")


def from_zero(ax: Axes) -> None:
    """Let the vertical axis begin at 0 and include everything that is drawn, now and later."""
    ax.set_ylim(bottom=0.0, auto=True)
