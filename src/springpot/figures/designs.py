"""Several designs on the same axes: each has its own color and name in the legend."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.data import Data, Theory, results
from springpot.figures.style import COLORS, LOOKS, bars, method_curve, method_label, panel
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.theory import NoStationaryStateError, NotCoveredError, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Curve: TypeAlias = Callable[[Floats], Floats]

CYCLE = tuple(COLORS[name] for name, _ in LOOKS)
"""Colors of the first, second, ... design, safe for color-blind readers."""

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
        mark = LOOKS[self.number % len(LOOKS)][1]
        bars(
            self.ax, place, value, standard_error, color=self.color or "0.35", marker=mark, size=size,
            label=self.named(measured), gid=self.gid,
        )  # fmt: skip

    def curve(self, method: str, place: ArrayLike, values: ArrayLike) -> None:
        """Draw a curve of the theory."""
        label = self.named(method_label(method))
        method_curve(self.ax, method, place, values, color=self.color, label=label, gid=self.gid)

    def curves(self, theory: Theory, curve_of: Callable[[Result], Curve | None], place: Floats) -> None:
        """Draw the curve of each result that has one."""
        for result in results(theory):
            curve = curve_of(result)
            if curve is not None:
                with suppress(NotCoveredError, NoStationaryStateError):
                    self.curve(result.method, place, curve(place))

    @property
    def gid(self) -> str:
        """The mark of its lines, by which the designs on some axes are counted."""
        return f"{_TAG}{self.number}"

    def named(self, what: str) -> str:
        """What the legend calls something of this design."""
        return ", ".join(filter(None, [self.label, what]))


def design_at(
    data: Data | None, at: ArrayLike | None, ax: Axes | None, color: str | None, label: str | None, word: str = "where"
) -> tuple[Design, Floats]:
    """The next design on given or new axes, and the places at which theory is drawn; none yet if the run has them.

    Raises
    ------
    ValueError
        If neither a run nor a place is given.
    """
    if data is None and at is None:
        raise ValueError(f"at must say {word} to draw theory, because there is no run.")
    return next_design(panel(ax), color, label), np.zeros(0) if at is None else np.asarray(at, dtype=float)


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
        raise TypeError(f"label must be a text, not {shown(label)}.")
    number = len({gid for line in ax.lines if (gid := line.get_gid() or "").startswith(_TAG)})
    if color is None and (number > 0 or label is not None):
        color = CYCLE[number % len(CYCLE)]
    return Design(ax, number, color, label if label is not None else str(number + 1) if number else "")


def from_zero(ax: Axes) -> None:
    """Let the vertical axis begin at 0 and include everything that is drawn, now and later."""
    ax.set_ylim(bottom=0.0, auto=True)
