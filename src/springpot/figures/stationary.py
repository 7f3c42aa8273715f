"""The stationary state: densities, spectrum and correlation, measured and by theory, alone or in one picture."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.data import Data, Theory, as_dataset, error_of_mean, recorded, result_of
from springpot.figures.designs import design_at, from_zero
from springpot.figures.style import new_grid
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word
from springpot.problem.numbers import label_of, numbers_of
from springpot.problem.system import System
from springpot.theory import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from springpot.simulation import Run

DENSITIES = {
    "x": ("displacement $x$ (m)", "density (1/m)"),
    "v": ("velocity $v$ (m/s)", "density (s/m)"),
    "amplitude": ("amplitude $A$ (m)", "density (1/m)"),
    "impact_speed": ("speed just before an impact (m/s)", "density (s/m)"),
}
_MEASURED = "Monte Carlo, 95 %"
_MOST_LINES = 8  # that fit above the legend


def plot_density(
    data: Data | None,
    quantity: str = "x",
    ax: Axes | None = None,
    *,
    theory: Theory = (),
    at: ArrayLike | None = None,
    of: str = "",
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw the density of x, v, the amplitude or the impact speed: a run's histogram with error bars, theory's curves.

    Parameters
    ----------
    data : Run, xarray.Dataset or None
        With ``distributions=True``; None for theory alone.
    quantity : {"x", "v", "amplitude", "impact_speed"}
        The amplitude is A = sqrt(x^2 + v^2 / Omega^2).
    <ax>
    theory : Result or several
        Each is drawn if it has this density.
    at : array_like, shape (n,), optional
        Where to draw theory, in m or m/s; the range of the histogram if left out.
    of : str
        Of several masses: the mass whose displacement or velocity it is, the part whose elongation it is, or the wall
        whose impact speed it is.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the run has no distributions, there is no such quantity, or neither a run nor ``at`` is given.

    Examples
    --------
    >>> import springpot as sp
    >>> dashpot = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=1.0))
    >>> run = sp.simulate(dashpot, paths=640, duration=20.0, distributions=True)
    >>> sp.figures.plot_density(run, "impact_speed", theory=sp.theory.exact(dashpot)).get_ylabel()
    'density (s/m)'
    """
    known_word(quantity, DENSITIES, "quantity")
    design, place = design_at(data, at, ax, color, label)
    ax = design.ax
    across, up = DENSITIES[quantity]
    ax.set(xlabel=across, ylabel=up)
    if data is not None:
        dataset = as_dataset(data)
        name = result_of(dataset, quantity, of)
        if f"{name}_density" not in dataset:
            raise ValueError(f"data holds no density of {name}: simulate with distributions=True.")
        if of:
            ax.set_xlabel(f"{name.replace('_', ' ')} ({dataset[f'{name}_bin'].units.replace(' s-1', '/s')})")
        middle, value, error = _columns(dataset, f"{name}_bin", f"{name}_density")
        if value.size == 0:
            ax.text(0.5, 0.5, "no impacts", ha="center", va="center", transform=ax.transAxes)
            return ax
        design.bars(middle, value, error, measured=_MEASURED, size=2.5)
        if at is None:
            half = np.asarray(dataset[f"{name}_bin_width"], dtype=float) / 2.0
            place = np.linspace(middle[0] - half[0], middle[-1] + half[-1], 400)
    design.curves(theory, lambda result: None if of else getattr(result, f"{quantity}_density", None), place)
    from_zero(ax)
    return ax


def plot_spectrum(
    data: Data | None,
    ax: Axes | None = None,
    *,
    theory: Theory = (),
    at: ArrayLike | None = None,
    of: str = "",
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw the two-sided spectral density of x on a logarithmic axis: a run's with error bars, theory's curves.

    Parameters
    ----------
    data : Run, xarray.Dataset or None
        With ``spectrum=`` frequencies; None for theory alone.
    <ax>
    theory : Result or several
        Each is drawn if it has a spectrum.
    at : array_like, shape (n,), optional
        Frequencies in rad/s at which to draw theory; those of the run if left out.
    <of>
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the run has no spectrum, or neither a run nor ``at`` is given.

    Examples
    --------
    >>> import numpy as np, springpot as sp
    >>> free = sp.Oscillator(barrier=None)
    >>> axes = sp.figures.plot_spectrum(None, theory=sp.theory.exact(free), at=np.linspace(0.1, 3.0, 50))
    >>> axes.get_xlabel()
    'frequency $\\\\omega$ (rad/s)'
    """
    design, place = design_at(data, at, ax, color, label)
    ax = design.ax
    of_what = f"the displacement of {of}" if of else "$x$"
    ax.set(xlabel=r"frequency $\omega$ (rad/s)", ylabel=f"spectral density of {of_what} (m$^2$ s/rad)", yscale="log")
    if data is not None:
        dataset = as_dataset(data)
        name = f"{result_of(dataset, 'x', of)}_spectrum"
        if name not in dataset:
            raise ValueError("data holds no spectrum: simulate with spectrum= frequencies in rad/s.")
        frequency, value, error = _columns(dataset, "frequency", name)
        design.bars(frequency, value, error, measured=_MEASURED, size=2.5)
        place = frequency if at is None else place
    design.curves(theory, lambda result: _spectrum_of(result, of), place)
    return ax


def plot_correlation(
    data: Data | None,
    ax: Axes | None = None,
    *,
    theory: Theory = (),
    at: ArrayLike,
    of: str = "",
    since: float = 0.0,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw <x(t) x(t + lag)> against the lag: from recorded paths with error bars, and theory's curves.

    Parameters
    ----------
    data : Run, xarray.Dataset or None
        With recorded paths (``record=``); None for theory alone.
    <ax>
    theory : Result or several
        Each is drawn if it has a correlation.
    at : array_like, shape (n,)
        Lags in s, at least 0; for recorded paths the nearest whole numbers of steps.
    <of>
    since : float
        Time in s before which recorded paths are not yet stationary, and left out.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the run has no recorded paths, or a lag is negative or longer than they are.

    Notes
    -----
    Products are averaged over time in each path; the standard error is that of the mean over the paths.

    Examples
    --------
    >>> import springpot as sp
    >>> free = sp.Oscillator(barrier=None)
    >>> axes = sp.figures.plot_correlation(None, theory=sp.theory.exact(free), at=[0.0, 1.0, 2.0])
    >>> axes.lines[0].get_ydata().round(3)
    array([ 0.532,  0.209, -0.16 ])
    """
    design, place = design_at(data, at, ax, color, label)
    ax = design.ax
    if not np.all(place >= 0.0):
        raise ValueError("at must hold lags of at least 0 s.")
    ax.set(xlabel="lag (s)", ylabel=r"$\langle x(t)\, x(t + \mathrm{lag})\rangle$ (m$^2$)")
    if data is not None:
        _, time, x, _ = recorded(data, of)
        x = x[:, time >= since]
        shifts = np.rint(place / (time[1] - time[0])).astype(int)
        if not shifts.max(initial=0) < x.shape[1]:
            raise ValueError(f"at must hold lags shorter than the {time[-1] - since:g} s that were recorded.")
        count = x.shape[1]
        means = np.array([(x[:, : count - shift] * x[:, shift:]).mean(axis=1) for shift in shifts])
        lags = shifts * (time[1] - time[0])
        design.bars(lags, means.mean(axis=1), error_of_mean(means.T), measured=_MEASURED, size=2.5)
    design.curves(theory, lambda result: getattr(result, "correlation", None), place)
    return ax


def _spectrum_of(result: Any, of: str) -> Any:
    curve = getattr(result, "spectrum", None)
    return partial(curve, of=of) if of and curve is not None else curve


def _columns(dataset: Any, place: str, value: str) -> tuple[Floats, Floats, Floats]:
    first, second, third = (np.asarray(dataset[name], dtype=float) for name in (place, value, f"{value}_se"))
    return first, second, third


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


def _title(system: System) -> str:
    """Its first numbers, a line each."""
    lines = [f"{label_of(name)} = {value:.4g}" for name, value in numbers_of(system).items()]
    more = [f"and {len(lines) - _MOST_LINES} more numbers"] if len(lines) > _MOST_LINES else []
    return "\n".join([*lines[:_MOST_LINES], *more, ""])
