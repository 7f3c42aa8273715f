"""Pictures of one recorded path, in time and in the plane of x and v, with the impacts marked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from springpot.figures.data import Data, Wall, recorded, spacing_in_steps, walls_of
from springpot.figures.designs import Design, next_design
from springpot.figures.style import COLORS, panel
from springpot.machine.arguments import check_whole
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LABELS = {"x": "displacement $x$ (m)", "v": "velocity $v$ (m/s)"}
_OF_A_MASS = {"x": "displacement of {} (m)", "v": "velocity of {} (m/s)"}
_OF_A_PART = {"x": "elongation of {} (m)", "v": "rate of elongation of {} (m/s)"}


def plot_path(
    data: Data,
    ax: Axes | None = None,
    *,
    quantity: Literal["x", "v"] = "x",
    of: str = "",
    member: int = 0,
    window: tuple[float, float] | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw x(t) or v(t) of one recorded path, with its impacts marked.

    Parameters
    ----------
    data : Run or xarray.Dataset
        With recorded paths (``record=``).
    <ax>
    quantity : {"x", "v"}
        Displacement in m or velocity in m/s.
    of : str
        Of several masses: the mass whose displacement or velocity it is, or the part whose elongation it is, such as a
        wall between two masses.
    member : int
        Index of the recorded path.
    window : (float, float), optional
        Times in s between which to draw.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If there are no recorded paths, none of that number, no such quantity, or nothing in the window.

    Notes
    -----
    A path is recorded at the ends of the steps.  An impact is detected where the velocity changes its sign in a step
    that would have ended behind the wall; several impacts in one step are marked as one.

    Examples
    --------
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=1, record=1, duration=20.0)
    >>> sp.figures.plot_path(run, window=(10.0, 20.0)).get_ylabel()
    'displacement $x$ (m)'
    """
    if quantity not in _LABELS:
        raise ValueError(f"quantity must be 'x' or 'v', not {shown(quantity)}.")
    piece = _seen(data, of, member, window)
    ax = panel(ax, 7.0, 3.0)
    design = next_design(ax, color, label)
    value = piece.x if quantity == "x" else piece.v
    times, values = (piece.time, value) if quantity == "x" else _broken(piece, piece.time, value)
    ax.plot(times, values, linewidth=1.0, **_look(design))
    if quantity == "x":
        _draw_walls(ax.axhline, piece)
        ax.plot(piece.impact_time, piece.struck_at, **_MARK)
    else:
        at = piece.struck
        ax.plot(piece.impact_time, piece.v[at], **_MARK)
        ax.vlines(piece.impact_time, piece.v[at], piece.v[at + 1], color=COLORS["vermilion"], linewidth=0.6, alpha=0.6)
    ax.set(xlabel="time $t$ (s)", ylabel=piece.labels[quantity], xlim=(piece.time[0], piece.time[-1]))
    return ax


def plot_phase_portrait(
    data: Data,
    ax: Axes | None = None,
    *,
    of: str = "",
    member: int = 0,
    window: tuple[float, float] | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw one recorded path in the plane of displacement and velocity, with its impacts marked.

    Parameters
    ----------
    data, ax, of, member, window, label, color
        As in `plot_path`.

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        As in `plot_path`.

    Examples
    --------
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=1, record=1, duration=20.0)
    >>> axes = sp.figures.plot_phase_portrait(run)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('displacement $x$ (m)', 'velocity $v$ (m/s)')
    """
    piece = _seen(data, of, member, window)
    ax = panel(ax, 4.6, 4.2)
    design = next_design(ax, color, label)
    ax.plot(*_broken(piece, piece.x, piece.v), linewidth=0.9, **_look(design))
    _draw_walls(ax.axvline, piece)
    at, wall = piece.struck, piece.struck_at
    ax.vlines(wall, piece.v[at], piece.v[at + 1], color=COLORS["vermilion"], linewidth=0.6, alpha=0.4)
    ax.plot(wall, piece.v[at], **_MARK)
    ax.locator_params(axis="x", nbins=6)  # long labels of small displacements would overlap
    ax.set(xlabel=piece.labels["x"], ylabel=piece.labels["v"])
    return ax


_MARK: dict[str, Any] = {
    "linestyle": "none", "marker": "o", "markersize": 3.5, "color": COLORS["vermilion"], "label": "impact",
    "clip_on": False, "zorder": 3,
}  # fmt: skip


def _look(design: Design) -> dict[str, Any]:
    return {"color": design.color or COLORS["blue"], "label": design.label or None, "gid": design.gid}


@dataclass(frozen=True)
class _Seen:
    """A piece of one path: labels of x and v, walls, states, steps with an impact, the place of the wall they struck,
    and their times.
    """

    labels: dict[str, str]
    walls: tuple[Wall, ...]
    time: Floats
    x: Floats
    v: Floats
    struck: np.ndarray[Any, np.dtype[np.intp]]
    struck_at: Floats
    impact_time: Floats


def _seen(data: Data, of: str, member: int, window: tuple[float, float] | None) -> _Seen:
    dataset, time, x, v = recorded(data, of)
    check_whole(member, "member", 0, len(x) - 1)
    inside = np.ones(time.size, bool) if window is None else (time >= window[0]) & (time <= window[1])
    if inside.sum() < 2:
        raise ValueError(f"window must hold at least two of the times from 0 to {time[-1]:g} s, not {shown(window)}.")
    time, x, v = time[inside], x[member, inside], v[member, inside]
    walls = walls_of(dataset, of)
    # between points that are several steps apart a path may turn without an impact; a soft contact has no instant
    rigid = () if spacing_in_steps(data) > 1 else tuple(wall for wall in walls if wall.rigid)
    none = np.zeros(0, np.intp), np.zeros(0), np.zeros(0)
    columns = zip(none, *(_impacts(wall, time, x, v) for wall in rigid), strict=True)
    struck, places, when = (np.concatenate(column) for column in columns)
    order = np.argsort(struck, kind="stable")
    words = _LABELS if dataset["x"].ndim == 2 else _OF_A_MASS if of in dataset["point"] else _OF_A_PART
    labels = {name: label.format(of) for name, label in words.items()}
    return _Seen(labels, walls, time, x, v, struck[order], places[order], when[order])


def _impacts(wall: Wall, time: Floats, x: Floats, v: Floats) -> tuple[np.ndarray[Any, Any], ...]:
    """Steps with an impact on a wall, its place, and the times by linear extrapolation."""
    gap, away = wall.direction * (x - wall.position), wall.direction * v
    step = np.diff(time)
    turned = (away[:-1] < 0.0) & (away[1:] > 0.0)
    behind = np.minimum(gap[:-1] + step * away[:-1], gap[1:] - step * away[1:]) <= 0.0
    at = np.flatnonzero(turned & behind)
    return at, np.full(at.size, wall.position), time[at] + np.minimum(gap[at] / -away[at], step[at])


def _broken(piece: _Seen, across: Floats, up: Floats) -> tuple[Floats, Floats]:
    """The curve with a gap at every impact."""
    return np.insert(across, piece.struck + 1, np.nan), np.insert(up, piece.struck + 1, np.nan)


def _draw_walls(line: Any, piece: _Seen) -> None:
    """Rigid walls as lines, soft contacts as dashed ones; one entry of each kind in a legend."""
    for rigid, style, label in ((True, "-", "wall"), (False, "--", "contact")):
        for n, wall in enumerate(wall for wall in piece.walls if wall.rigid is rigid):
            line(wall.position, color="0.35", linewidth=2.0, linestyle=style, zorder=1, label=label if n == 0 else None)
