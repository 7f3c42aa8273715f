"""Pictures of a moment against one parameter: curves of theory, points of Monte Carlo."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from springpot.figures.data import Data, as_dataset, paper_of
from springpot.figures.designs import next_design
from springpot.figures.style import MOMENT_WORDS, bars, method_curve, panel
from springpot.machine.faults import known_word
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Oscillator
from springpot.problem.system import System, checked_system
from springpot.theory import NoConvergenceError, NoStationaryStateError, NotCoveredError, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOMENTS = {name: f"{said}{symbol} ({unit})" for name, (said, symbol, unit, _) in MOMENT_WORDS.items()}
"""Labels of the moments, with units."""

Method = Callable[[System], Result]


PARAMETER_LABELS = {
    "order": r"order of the derivative $\alpha$ (1)",
    "coefficient": r"coefficient $C$ (s$^{\alpha-2}$)",
    "natural_frequency": r"natural frequency $\Omega$ (rad/s)",
    "restitution": "restitution $r$ (1)",
    "position": "position of the wall $b$ (m)",
    "intensity": r"intensity of the noise $q$ (m$^2$/s$^3$)",
}
"""Labels of the problem's numbers, with units."""


def plot_against(
    parameter: str,
    ax: Axes | None = None,
    *,
    quantity: str = "amplitude_mean_square",
    system: System | None = None,
    values: ArrayLike = (),
    theory: Iterable[Method] | Mapping[str, Method] = (),
    runs: Iterable[Data] = (),
    color: str | None = None,
    label: str | None = None,
) -> Axes:
    """Draw a moment against one parameter: theory as curves, runs as points with error bars.

    Parameters
    ----------
    parameter : {"order", "coefficient", "natural_frequency", "restitution", "position", "intensity"}
        The parameter on the horizontal axis.
    <ax>
    quantity : str
        A moment, such as ``"amplitude_mean_square"`` or ``"impact_rate"``.
    system : System, optional
        The other parameters, for theory.
    values : array_like, shape (n,)
        Of the parameter, for theory.
    theory : sequence or dict of functions
        Such as ``springpot.theory.averaging``, from a system to a result; the keys of a dict are the labels.
        Where a method has no result its curve has a gap.
    runs : sequence of Run or xarray.Dataset
        Each is one point, at the parameter of its own system.
    color : str, optional
        Color of everything that is drawn; by default the next one of the axes.
    label : str, optional
        Of the points; "Monte Carlo, 95 %" if left out, with a number from the second call on.

    <returns axes>

    Raises
    ------
    TypeError, ValueError
        If there is no such parameter or moment, ``system`` is missing, or a value is outside the parameter's range.

    Examples
    --------
    The paper's Fig. 2, small:

    >>> import springpot as sp
    >>> orders = [0.3, 0.5, 1.0]
    >>> axes = sp.figures.plot_against(
    ...     "order", system=sp.Oscillator(), values=orders, theory=[sp.theory.averaging],
    ...     runs=[sp.simulate(sp.Oscillator(springpot=sp.Springpot(order, 1.0)), rtol=0.1) for order in orders],
    ... )
    >>> axes.lines[0].get_ydata().round(3)
    array([4.25 , 2.296, 1.   ])
    """
    known_word(parameter, PARAMETER_LABELS, "parameter")
    known_word(quantity, MOMENTS, "quantity")
    ax = panel(ax)
    design = next_design(ax, color)
    color = design.color
    place = np.asarray(values, dtype=float)
    methods = tuple(theory.items()) if isinstance(theory, Mapping) else tuple(("", method) for method in theory)
    for title, method in methods:
        known = checked_system(system)
        systems = [_with(known, parameter, float(value)) for value in place]
        curve, name = _curve(method, systems, quantity)
        label_of = title or ("" if name else getattr(method, "__name__", "theory"))
        method_curve(ax, name, place, curve, color=color, label=label_of, gid=design.gid)
    points = [(_number(paper_of(each), parameter), each) for each in map(as_dataset, runs)]
    if points:
        at, datasets = zip(*points, strict=True)
        measured = [float(each[quantity]) for each in datasets]
        error = [float(each[f"{quantity}_se"]) for each in datasets]
        points_label = label or ", ".join(filter(None, [design.label, "Monte Carlo, 95 %"]))
        bars(ax, at, measured, error, color=color or "0.15", size=3.5, label=points_label, gid=design.gid)
    ax.set(xlabel=PARAMETER_LABELS[parameter], ylabel=MOMENTS[quantity])
    return ax


def _number(known: Dimensionless, parameter: str) -> float:
    """One parameter of the paper's problem; NaN if it belongs to a wall and there is none."""
    numbers = known.numbers
    of_a_wall = parameter in ("position", "restitution")
    return math.nan if of_a_wall and not numbers["barrier"] else float(numbers[parameter])


def _with(system: System, parameter: str, value: float) -> System:
    """The system with another value of a parameter."""
    known = Dimensionless.of(system)
    if math.isnan(_number(known, parameter)):
        raise ValueError("system must have a wall if parameter is 'position' or 'restitution'.")
    return Oscillator.from_numbers(**known.numbers | {parameter: value})


def _curve(method: Method, systems: Iterable[System], quantity: str) -> tuple[list[float], str]:
    """One number for each system, NaN where the method has no result, and the name of the method."""
    numbers, name = [], ""
    for system in systems:
        try:
            result = method(system)
            name = result.method
            numbers.append(float(getattr(result, quantity)))
        except (NotCoveredError, NoStationaryStateError, NoConvergenceError):
            numbers.append(math.nan)
    return numbers, name
