"""Theory and Monte Carlo in one picture: densities and spectrum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from springpot.figures.data import as_dataset
from springpot.figures.stationary import DENSITIES, plot_density, plot_spectrum
from springpot.figures.style import new_grid
from springpot.problem.numbers import label_of, numbers_of
from springpot.problem.system import System
from springpot.theory import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from springpot.simulation import Run


def plot_comparison(observed: Run, answers: Mapping[str, Result]) -> Figure:
    """Draw densities of x, v, amplitude and impact speed, and the spectrum of x.

    Parameters
    ----------
    observed : Run
        With distributions and a spectrum; `springpot.evidence.comparison.observe` makes one.
    answers : dict
        Names of methods and their results; each is drawn where it has the quantity.

    Returns
    -------
    matplotlib.figure.Figure
        Six panels, the last one with the legend.

    Raises
    ------
    ValueError
        If the run has no distributions or no spectrum.

    Examples
    --------
    >>> import springpot as sp
    >>> dashpot = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0))
    >>> run = sp.simulate(dashpot, paths=640, duration=60.0, distributions=True, spectrum=[0.5, 1.0, 1.5])
    >>> len(sp.figures.plot_comparison(run, {"exact": sp.theory.exact(dashpot)}).axes)
    6
    """
    figure, panels = new_grid(10.5, 6.2, 2, 3)
    data, theory = as_dataset(observed), tuple(answers.values())
    for panel, name in zip((panels[0], panels[1], panels[3], panels[4]), DENSITIES, strict=True):
        plot_density(data, name, panel, theory=theory)
    plot_spectrum(data, panels[2], theory=theory)
    panels[5].set_axis_off()
    handles: dict[str, Any] = {}
    for panel in panels[:5]:
        handles |= dict(zip(*reversed(panel.get_legend_handles_labels()), strict=True))
    title = _title(observed.system)
    panels[5].legend(handles.values(), handles.keys(), loc="center left", frameon=False, title=title)
    return figure


_MOST_LINES = 8  # that fit above the legend


def _title(system: System) -> str:
    """Its first numbers, a line each."""
    lines = [f"{label_of(name)} = {value:.4g}" for name, value in numbers_of(system).items()]
    more = [f"and {len(lines) - _MOST_LINES} more numbers"] if len(lines) > _MOST_LINES else []
    return "\n".join([*lines[:_MOST_LINES], *more, ""])
