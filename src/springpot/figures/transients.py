"""Pictures against time: growth of the response from rest, results in bins of time, and first passage of a level."""

from __future__ import annotations

import json
from collections.abc import Callable
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.data import Data, Theory, as_dataset, error_of_mean, paper_of, recorded, results
from springpot.figures.designs import Design, design_at, next_design
from springpot.figures.style import panel
from springpot.figures.sweeps import MOMENTS
from springpot.machine.arguments import without_axis
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word, listed, shown
from springpot.problem.dimensionless import Dimensionless
from springpot.theory import Averaging, Result
from springpot.theory.transients import Transient

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 40  # of Monte Carlo, so that the bars do not overlap


def plot_transient(
    data: Data | None,
    quantity: str = "amplitude_mean_square",
    ax: Axes | None = None,
    *,
    theory: Theory = (),
    at: ArrayLike | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw a moment against time from rest: from recorded paths with error bars, and theory's curves.

    Parameters
    ----------
    data : Run, xarray.Dataset or None
        From rest (``start="rest"``), with recorded paths (``record=``, the more the better); None for theory alone.
    quantity : {"amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square"}
    <ax>
    theory : Result or several
        Each is drawn if it has this moment as a function of time.
    at : array_like, shape (n,), optional
        Times in s at which to draw theory; those of the run if left out.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the run has no recorded paths or did not start from rest, there is no such quantity, or neither a run nor
        ``at`` is given.

    Examples
    --------
    >>> import springpot as sp
    >>> dashpot = sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=0.5))
    >>> axes = sp.figures.plot_transient(None, theory=sp.theory.exact(dashpot), at=[0.0, 2.0, 100.0])
    >>> axes.lines[0].get_ydata().round(3)
    array([0.   , 1.179, 2.   ])
    """
    known_word(quantity, _OF_PATHS, "quantity")
    design, times = design_at(data, at, ax, color, label, "when")
    if data is not None:
        paper, time, x, v = _from_rest(data)
        values = _OF_PATHS[quantity](x, v, paper.natural_frequency)
        _bars(design, time, values.mean(axis=0), error_of_mean(values), len(values))
        times = time if at is None else times
    design.curves(theory, lambda result: _moment_at(result, quantity), times)
    design.ax.set(xlabel="time from rest $t$ (s)", ylabel=MOMENTS[quantity])
    return design.ax


def plot_survival(
    data: Data | None,
    level: float,
    ax: Axes | None = None,
    *,
    theory: Theory = (),
    at: ArrayLike | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw the probability that the amplitude has not yet reached a level, against time from rest.

    Parameters
    ----------
    data : Run, xarray.Dataset or None
        From rest (``start="rest"``), with recorded paths (``record=``); None for theory alone.
    level : float
        Of the amplitude A = sqrt(x^2 + v^2 / w^2) with w the `resonance` of the system, in m.
    <ax>
    theory : Result or several
        Each is drawn if it has a ``first_passage``.
    at : array_like, shape (n,), optional
        Times in s at which to draw theory; those of the run if left out.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the run has no recorded paths or did not start from rest, the level is not positive, or neither a run nor
        ``at`` is given.

    Notes
    -----
    Only the ends of the steps are checked, so a short passage between two of them is missed: use a small step.  The
    error bars are those of a share of independent paths.

    Examples
    --------
    >>> import springpot as sp
    >>> light = sp.theory.envelope(sp.Oscillator(springpot=sp.Springpot(order=1.0, coefficient=0.1)))
    >>> axes = sp.figures.plot_survival(None, 3.0, theory=light, at=[0.0, 20.0])
    >>> axes.lines[0].get_ydata().round(2)
    array([1.  , 0.14])
    """
    level = without_axis(level)
    if not (isinstance(level, Real) and level > 0.0):
        raise ValueError(f"level must be a positive amplitude in m, not {shown(level)}.")
    design, times = design_at(data, at, ax, color, label, "when")
    if data is not None:
        paper, time, x, v = _from_rest(data)
        below = np.logical_and.accumulate(np.hypot(x, v / paper.resonance) < level, axis=1)
        share = below.mean(axis=0)
        _bars(design, time, share, np.sqrt(share * (1.0 - share) / len(below)), len(below))
        times = time if at is None else times
    for result in results(theory):
        if (first_passage := getattr(result, "first_passage", None)) is not None:
            design.curve(result.method, times, first_passage(amplitude=level).survival(times))
    label = f"probability that $A$ was always below {level:g} m"
    design.ax.set(xlabel="time from rest $t$ (s)", ylabel=label, ylim=(0.0, 1.03))
    return design.ax


def _bars(design: Design, time: Floats, value: Floats, error: Floats, paths: int) -> None:
    """Monte Carlo at some of the times."""
    some = slice(None, None, max(1, time.size // _POINTS))
    design.bars(time[some], value[some], error[some], measured=f"Monte Carlo, {paths} paths, 95 %")


def _from_rest(data: Data) -> tuple[Dimensionless, Floats, Floats, Floats]:
    """The recorded paths of a run whose paths all start at rest."""
    dataset = as_dataset(data)
    paper = paper_of(dataset)
    _, time, x, v = recorded(dataset)
    if json.loads(dataset.attrs["settings"])["start"] != "rest" and paper.barrier is not None:
        raise ValueError("data must be of a run from rest: simulate with start='rest'.")
    return paper, time, x, v


_OF_PATHS: dict[str, Callable[[Floats, Floats, float], Floats]] = {
    "amplitude_mean_square": lambda x, v, frequency: x**2 + (v / frequency) ** 2,
    "x_mean": lambda x, v, frequency: x,
    "x_mean_square": lambda x, v, frequency: x**2,
    "v_mean_square": lambda x, v, frequency: v**2,
}


def _moment_at(result: Result, quantity: str) -> Any:
    """The method that gives this moment at a time, if there is one."""
    if isinstance(result, Averaging):
        # at a shifted frequency its mean square is not <A^2>
        own = quantity == "amplitude_mean_square" and result.frequency == result.system.natural_frequency
        return result.mean_square if own else None
    return getattr(result, f"{quantity}_at", None)


def plot_over_time(
    data: Data,
    quantity: str = "x_mean_square",
    ax: Axes | None = None,
    *,
    theory: Transient | None = None,
    label: str | None = None,
    color: str | None = None,
) -> Axes:
    """Draw a result against time, with its 95 % bars in the middle of each bin.

    Parameters
    ----------
    data : Run or xarray.Dataset
        With ``profile=`` bins.
    quantity : str
        Such as ``"x_mean_square"``, ``"impact_rate"``; of several masses ``"box_x_mean_square"``.
    <ax>
    theory : Transient, optional
        Of `springpot.theory.transient`: drawn as a line if it has this quantity.
    <label, color>

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If the data are no run, or hold no such profile.

    Examples
    --------
    >>> import springpot as sp
    >>> run = sp.simulate(sp.Oscillator(), paths=128, duration=4.0, start="rest", profile=10)
    >>> sp.figures.plot_over_time(run, "impact_rate").get_ylabel()
    'impact rate (s-1)'
    """
    dataset = as_dataset(data)
    known = [str(name).removesuffix("_profile") for name in dataset.data_vars if str(name).endswith("_profile")]
    if quantity not in known:
        have = f"it has {listed(known)}" if known else "simulate with profile= bins"
        raise ValueError(f"data holds no profile of {shown(quantity)}: {have}.")
    name = f"{quantity}_profile"
    design = next_design(panel(ax), color, label)
    time, value, error = (np.asarray(dataset[each], float) for each in ("time_bin", name, f"{name}_se"))
    design.bars(time, value, error, measured="Monte Carlo, 95 %", size=2.5)
    if theory is not None and quantity in theory.numbers:
        design.curve("linear", theory.time, theory.numbers[quantity])
    design.ax.set(xlabel="time $t$ (s)", ylabel=f"{quantity.replace('_', ' ')} ({dataset[name].units})")
    return design.ax
