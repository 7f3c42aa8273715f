"""Pictures of response spectra and of fragility curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from springpot.figures.style import COLORS, LOOKS, named, panel, plain_ticks
from springpot.machine.faults import known_word
from springpot.spectra import Fragility, ResponseSpectrum

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MOST_LINES = 60  # records that are drawn one by one
_POINTS = 200


def plot_response_spectrum(
    found: ResponseSpectrum, output: str | None = None, *, frequency: bool = False, color: str = "blue",
    label: str = "", ax: Axes | None = None,
) -> Axes:  # fmt: skip
    """Draw a response spectrum: each record, and the quantiles over them with their 95 % intervals.

    Of so few records that the intervals have no ends, the records and their median.

    Parameters
    ----------
    found : ResponseSpectrum
        Of `springpot.response_spectrum`.
    output : str, optional
        The first if left out.
    frequency : bool
        Against the frequency in Hz in place of the period.
    color : str
        Of the library's palette, ``springpot.figures.COLORS``.
    label : str
        Of the line in the middle.
    <ax>

    <returns axes>

    Raises
    ------
    ValueError
        If there is no such output.

    Examples
    --------
    >>> import springpot as sp
    >>> pulse = sp.RecordedExcitation((0.0, 0.005, 0.01), (0.0, 100.0, 0.0))
    >>> ax = sp.figures.plot_response_spectrum(sp.response_spectrum(pulse, [0.01, 0.02, 0.04]), "acceleration")
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('period (s)', 'largest acceleration (m s$^{-2}$)')
    """
    name = next(iter(found)) if output is None else known_word(output, found, "output")
    own, place = found[name], found.frequencies if frequency else found.periods
    order = np.argsort(place)
    place = place[order]
    ax, tone = panel(ax), COLORS[known_word(color, COLORS, "color")]
    # ends of intervals that a small sample does not have are not drawn; where it has none, the records themselves are
    low = np.where(own.low > 0.0, own.low, np.nan)
    high = np.where(np.isfinite(own.high), own.high, np.nan)
    enough, count = bool(np.isfinite(low + high).all()), own.values.shape[1]
    if 1 < count <= _MOST_LINES:
        ax.plot(place, own.values[order], color="0.8" if enough else tone, linewidth=0.5, alpha=0.7, zorder=1)
        ax.plot([], [], color="0.7" if enough else tone, linewidth=0.6, label="each record")
    middle = int(np.argmin(np.abs(np.array(own.shares) - 0.5)))
    for n in reversed(range(len(own.shares) if count != 1 else 0)):
        words = "median" if own.shares[n] == 0.5 else f"{100.0 * own.shares[n]:.3g} % are below"
        if n == middle:
            ax.plot(
                place, own.quantiles[n][order], color=tone, linewidth=1.6, zorder=3,
                label=f"{label}, {words}" if label else words,
            )  # fmt: skip
        elif enough or own.rms is not None:
            ax.plot(place, own.quantiles[n][order], "--", color=tone, linewidth=1.2, label=words, zorder=3)
        if enough:
            ax.fill_between(place, low[n][order], high[n][order], color=tone, alpha=0.2, linewidth=0.0, zorder=2)
    if count == 1:
        ax.plot(place, own.middle[order], color=tone, linewidth=1.6, label=label or None)
    if own.rms is not None:
        ax.plot(place, own.rms[order], ":", color=tone, linewidth=1.6, label="rms")
    ax.set(
        xscale="log", yscale="log", xlabel="frequency (Hz)" if frequency else "period (s)",
        ylabel=named(f"largest {name.replace('_', ' ')}", own.unit),
    )  # fmt: skip
    plain_ticks(ax)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(frameon=False)
    return ax


def plot_fragility(found: Fragility, *, measure: str = "intensity", unit: str = "", ax: Axes | None = None) -> Axes:
    """Draw fragility curves with their 95 % bands, and the shares of the paths that exceed the limit.

    Parameters
    ----------
    found : Fragility
        Of `springpot.fragility`.
    measure, unit : str
        What the intensity is, for the axis.
    <ax>

    <returns axes>

    Examples
    --------
    >>> import springpot as sp
    >>> device = lambda rms: sp.System(
    ...     sp.Mass(1.0), sp.Spring(400.0), sp.Dashpot(2.0), sp.WhiteNoise((0.01 * rms) ** 2, on="ground")
    ... )
    >>> found = sp.fragility(device, {"displacement": 0.012}, [10.0, 14.0, 18.0, 25.0], duration=20.0, paths=64)
    >>> sp.figures.plot_fragility(found, measure="rms", unit="m s-2").get_xlabel()
    'rms (m s$^{-2}$)'
    """
    ax = panel(ax)
    reached = [own.intensities if own.intensities.size else own.places.ravel() for own in found.curves.values()]
    least, most = (float(end(np.concatenate(reached))) for end in (np.min, np.max))
    at = np.geomspace(0.9 * least, 1.1 * most, _POINTS)
    for n, own in enumerate(found.curves.values()):
        color, mark = LOOKS[n % len(LOOKS)]
        low, high = own.band(at)
        limit = named(f"{own.output.replace('_', ' ')} > {own.limit:g}", "").strip()
        units = named("", own.unit).strip().strip("()")
        ax.fill_between(at, low, high, color=COLORS[color], alpha=0.18, linewidth=0.0)
        ax.plot(at, own.probability(at), color=COLORS[color], linewidth=1.6, label=f"{limit} {units}".strip())
        if own.intensities.size:
            share, least_share, most_share = own.shares
            about = np.maximum(np.stack([share - least_share, most_share - share]), 0.0)
            ax.errorbar(
                own.intensities, share, about, fmt=mark, color=COLORS[color], markersize=4, elinewidth=0.9, capsize=1.5
            )
        else:
            over = own.demands.ravel() > own.limit
            ax.plot(own.places.ravel(), np.where(over, 1.0, 0.0), mark, color=COLORS[color], markersize=4.0, alpha=0.5)
    ax.set(xlabel=named(measure, unit), ylabel="probability to exceed the limit")
    if found.method == "splitting":
        ax.set_yscale("log")
    ax.legend(frameon=False)
    return ax
