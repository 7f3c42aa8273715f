"""Theory beside Monte Carlo in a picture: densities and spectrum as overlays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.figures.style import COLOURS, new_grid
from springpot.simulation import Run
from springpot.theory import NoStationaryState, NotCovered, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_comparison"]

DENSITIES = {
    "x": ("displacement x (m)", "density (1/m)"),
    "v": ("velocity v (m/s)", "density (s/m)"),
    "amplitude": ("amplitude A (m)", "density (1/m)"),
    "impact_speed": ("speed just before an impact (m/s)", "density (s/m)"),
}
LINES = {
    "exact": ("black", "-"),
    "fokker_planck": ("black", "--"),
    "envelope": ("vermilion", "-"),
    "closure": ("blue", "--"),
    "averaging_shifted": ("green", "-."),
    "averaging": ("purple", ":"),
}
"""Colour and line of each method, told apart without colour as well."""


def draw_comparison(observed: Run, answers: Mapping[str, Result]) -> Figure:
    """Draw densities of x, v, amplitude and impact speed, and the spectrum of x.

    Parameters
    ----------
    observed : Run
        With distributions and a spectrum (`springpot.comparison.observe`).
    answers : mapping
        Names of methods and their results; each is drawn where it has the quantity.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, panels = new_grid(10.5, 6.2, 2, 3)
    for panel, name in zip((panels[0], panels[1], panels[3], panels[4]), DENSITIES, strict=True):
        _density(panel, name, observed, answers)
    _spectrum(panels[2], observed, answers)
    panels[5].set_axis_off()
    handles: dict[str, Any] = {}
    for panel in panels[:5]:
        handles |= dict(zip(*reversed(panel.get_legend_handles_labels()), strict=True))
    panels[5].legend(handles.values(), handles.keys(), loc="center left", frameon=False, title=_title(observed))
    return figure


def _title(observed: Run) -> str:
    o = observed.oscillator
    wall = "no wall" if o.barrier is None else f"$b$ = {o.barrier.position:g} m, $r$ = {o.barrier.restitution:g}"
    return (
        rf"$\alpha$ = {o.springpot.order:g}, $C$ = {o.springpot.coefficient:g} s$^{{\alpha-2}}$"
        "\n"
        rf"$\Omega$ = {o.natural_frequency:g} rad/s, $q$ = {o.excitation.intensity:g} m$^2$/s$^3$"
        f"\n{wall}\n"
    )


def _density(panel: Axes, name: str, observed: Run, answers: Mapping[str, Result]) -> None:
    across, up = DENSITIES[name]
    panel.set(xlabel=across, ylabel=up)
    edges, density, error = observed.distributions[name].density()
    if density.size == 0:
        panel.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=panel.transAxes)
        return
    middle = 0.5 * (edges[1:] + edges[:-1])
    panel.errorbar(
        middle, density, 2.0 * error, fmt="o", ms=2.5, lw=0.8, color="0.45", label="Monte Carlo, 2 standard errors"
    )
    place = np.linspace(edges[0], edges[-1], 400)
    for method, answer in answers.items():
        _line(panel, method, answer, f"{name}_density", place)
    panel.set_ylim(bottom=0.0)


def _spectrum(panel: Axes, observed: Run, answers: Mapping[str, Result]) -> None:
    panel.set(xlabel="frequency (rad/s)", ylabel=r"spectral density of $x$ (m$^2$ s)", yscale="log")
    found = observed.spectrum
    if found is None:
        raise ValueError("the run must have a spectrum: springpot.comparison.observe makes one.")
    panel.errorbar(found.frequency, found.density, 2.0 * found.standard_error, fmt="o", ms=2.5, lw=0.8, color="0.45")
    for method, answer in answers.items():
        _line(panel, method, answer, "spectrum", found.frequency)


def _line(panel: Axes, method: str, answer: Result, quantity: str, place: np.ndarray[Any, Any]) -> None:
    """Draw one method's curve, if it has one here."""
    curve = getattr(answer, quantity, None)
    if curve is None or method not in LINES:
        return
    try:
        values = curve(place)
    except (NotCovered, NoStationaryState):
        return
    colour, line = LINES[method]
    panel.plot(place, values, line, color=COLOURS[colour], lw=1.4, label=method.replace("_", " "))
