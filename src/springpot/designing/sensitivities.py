"""How much each quantity changes with each number: by theory, or by Monte Carlo on common random numbers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from springpot.designing.quantities import (
    MONTE_CARLO,
    chosen_method,
    if_allowed,
    if_stationary,
    samples_of,
    theory_values,
)
from springpot.designing.sensitivity_results import Sensitivity
from springpot.machine.arguments import check_called, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import known_word, shown
from springpot.machine.progress import counted
from springpot.problem.free_numbers import free_numbers, with_values
from springpot.problem.numbers import label_of, numbers_of, with_numbers
from springpot.problem.outputs import output_squares
from springpot.problem.system import System, checked_system
from springpot.simulation.paths.simulation import Progress
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import check_stationary, plan_of
from springpot.simulation.plan.settings import Settings

THEORY_STEP = 0.04  # of the logarithm of a number; halved twice
USUAL_CHANGE = 0.1


@dataclass(frozen=True)
class Numbers:
    """Numbers of a system by name, and the system with others.

    Attributes
    ----------
    system : System
    values : dict
        Where the system stands.
    at : callable
        From values by name to the system that has them; raises a ValueError where a part refuses one.
    """

    system: System
    values: dict[str, float]
    at: Callable[[Mapping[str, float]], System]

    def moved(self, name: str, distance: float) -> System:
        """The system with one number changed by this distance of its logarithm."""
        return self.at({**self.values, name: self.values[name] * math.exp(distance)})


def moved_numbers(system: System) -> Numbers:
    """The free numbers of a system; all numbers that are not 0 if none is free.

    Examples
    --------
    >>> import springpot as sp
    >>> moved_numbers(sp.System(sp.Spring(80.0), sp.Dashpot(0.1))).values
    {'spring_stiffness': 80.0, 'dashpot_coefficient': 0.1}
    >>> moved_numbers(sp.System(sp.Spring(sp.free("k", 80.0, (10.0, 200.0))), sp.Dashpot(0.1))).values
    {'k': 80.0}
    """
    if found := free_numbers(system):
        return Numbers(
            system, {name: float(number) for name, number in found.items()}, lambda v: with_values(system, v)
        )
    values = {name: value for name, value in numbers_of(system).items() if value and math.isfinite(value)}
    names = {label_of(name): name for name in values}
    return Numbers(
        system,
        {label: values[name] for label, name in names.items()},
        lambda v: with_numbers(system, {names[label]: value for label, value in v.items()}),
    )


@dataclass(frozen=True)
class Stencil:
    """Places in units of the step, and weights times the step.

    Attributes
    ----------
    offsets, weights : tuple of float
    powers : tuple of int
        Powers of the step in the error, the lowest first.
    """

    offsets: tuple[float, ...]
    weights: tuple[float, ...]
    powers: tuple[int, ...]


CENTRAL = Stencil((-1.0, 1.0), (-0.5, 0.5), (2, 4, 6))
BACKWARD = Stencil((-1.0, -0.5, 0.0), (1.0, -4.0, 3.0), (2, 3, 4))
FORWARD = Stencil((0.0, 0.5, 1.0), (-3.0, 4.0, -1.0), (2, 3, 4))


def stencil(allowed: Callable[[float], bool], step: float) -> Stencil | None:
    """Central where both sides are allowed, one-sided where one is; None if neither is.

    Parameters
    ----------
    allowed : callable
        Whether the function exists at this distance.
    step : float

    Examples
    --------
    >>> stencil(lambda distance: distance <= 0.0, 0.1).offsets
    (-1.0, -0.5, 0.0)
    """
    below, above = allowed(-step), allowed(step)
    if below and above:
        return CENTRAL
    return BACKWARD if below else FORWARD if above else None


def extrapolated(differences: Sequence[Floats], powers: Sequence[int]) -> tuple[Floats, Floats]:
    """Richardson's extrapolation of differences at a step and its halves, with an estimate of the error.

    Parameters
    ----------
    differences : sequence of ndarray
        The largest step first, each half of the one before.
    powers : sequence of int
        Of the step in the error.

    Returns
    -------
    value, error : ndarray
        The error is the last change, of the orders and of the steps, whichever is larger.

    Examples
    --------
    >>> f = lambda h: np.array([(np.exp(h) - np.exp(-h)) / (2.0 * h)])
    >>> value, error = extrapolated([f(0.04), f(0.02), f(0.01)], (2, 4, 6))
    >>> bool(abs(value[0] - 1.0) < error[0] < 1e-8)
    True
    """
    column = list(differences)
    error = np.abs(column[-1] - column[0])
    for power in powers[: len(differences) - 1]:
        finer = [later + (later - before) / (2.0**power - 1.0) for before, later in itertools.pairwise(column)]
        error = np.abs(finer[-1] - column[-1])
        if len(finer) > 1:
            error = np.maximum(error, np.abs(finer[-1] - finer[-2]))
        column = finer
    return column[-1], error


def sensitivity(
    model: System,
    quantities: Sequence[str] | str,
    *,
    method: str | None = None,
    change: float = USUAL_CHANGE,
    paths: int = 5000,
    seed: int = 1,
    duration: float | None = None,
    step: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Sensitivity:
    """How much each quantity changes with each free number: d ln(quantity) / d ln(number).

    Parameters
    ----------
    model : System
        With a stationary state.  Its free numbers are moved (`springpot.free`), or all of its numbers if none is free.
    quantities : str or sequence of str
        Names of results, such as ``"impact_rate"``, and mean squares of forces and absolute accelerations, such as
        ``"force_on_ground_mean_square"``, by linear theory or Monte Carlo.
    method : {"theory", "monte_carlo", None} or str
        ``"theory"`` is the recommended method or the best guess, a name that method (``"envelope"``).  If left out, the
        recommended method, or Monte Carlo where none is.
    change : float
        Relative change of each number to either side by Monte Carlo, in [0.001, 0.3].  A larger one has a smaller
        standard error, and an error of the difference of about its square over 6 times the third derivative.
    paths, seed, duration, step, threads
        Of each run by Monte Carlo, as in `springpot.simulate`.
    progress : callable
        Called with the fraction of the work done.

    Returns
    -------
    Sensitivity

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong, a quantity unknown, or there is no stationary state.

    Notes
    -----
    By theory differences at three steps are extrapolated (Richardson).  By Monte Carlo both sides have the same random
    numbers (Glasserman, "Monte Carlo methods in financial engineering", 2003, chapter 7), the same step, duration and
    window; the standard error is that of the differences path by path.  Impacts separate paths with the same random
    numbers, and the gain in variance is then small.  Where a part refuses one side, as a restitution above 1, the
    difference is taken from three points on the other side.

    Examples
    --------
    >>> import springpot as sp
    >>> linear = sp.System(sp.Spring(9.0), sp.Dashpot(sp.free("c", 0.3, (0.1, 1.0))), sp.WhiteNoise(1.0))
    >>> round(sp.sensitivity(linear, "x_mean_square").values["x_mean_square"]["c"], 6)
    -1.0
    >>> wall = sp.Oscillator(springpot=sp.Springpot(sp.free("order", 0.5, (0.1, 1.0)), 1.0))
    >>> found = sp.sensitivity(wall, "impact_rate", method="monte_carlo", paths=256, duration=40.0)
    >>> 0.0 < found.errors["impact_rate"]["order"] < 0.1
    True
    """
    system = checked_system(model, "model")
    given = (quantities,) if isinstance(quantities, str) else quantities
    if not isinstance(given, Sequence) or not all(isinstance(each, str) for each in given):
        raise TypeError(f"quantities must be names of quantities, such as 'impact_rate', not {shown(quantities)}.")
    if not given:
        raise ValueError("quantities must name at least one quantity, such as 'impact_rate'.")
    names = tuple(dict.fromkeys(given))
    finite_number(change, "change", low=0.001, high=0.3)
    check_called(progress, "progress")
    check_stationary(system, "sensitivity")
    numbers = moved_numbers(system)
    if not numbers.values:
        raise ValueError("model must have a number that is not 0.")
    chosen, doubt = chosen_method(system, method)
    known = method in (None, "linear", MONTE_CARLO)  # other methods have no outputs
    outputs = output_squares(system) if known else {}
    if method is None and chosen != MONTE_CARLO and not outputs.keys().isdisjoint(names):  # of theory linear theory
        chosen, doubt = "linear" if {*names} <= {*theory_values(system, "linear", names)[0]} else MONTE_CARLO, ""
    said = [doubt] if doubt else []
    said += [f"{name} is 0: it has no relative change." for name, value in numbers.values.items() if value == 0.0]
    moved = replace(numbers, values={name: value for name, value in numbers.values.items() if value != 0.0})
    if not moved.values:
        raise ValueError("model must have a free number that is not 0: the others have no relative change.")
    settings = None
    if chosen == MONTE_CARLO:
        settings = plan_of(system, paths=paths, seed=seed, duration=duration, step=step, threads=threads).settings
        base, found, more = _by_monte_carlo(moved, names, outputs, settings, math.log1p(change), progress)
    else:
        base, found, more = _by_theory(moved, names, outputs, chosen, progress)
    values, errors, gains = (
        {quantity: {name: float(found[name][place][n]) for name in moved.values} for n, quantity in enumerate(names)}
        for place in range(3)
    )
    return Sensitivity(
        system, chosen, moved.values, {name: base[name] for name in names}, values, errors,
        {} if settings is None else gains, settings, (*said, *more),
    )  # fmt: skip


Found = tuple[dict[str, float], dict[str, tuple[Any, ...]], list[str]]
"""Quantities by name; by the name of a number the derivatives of all, their errors, and the gains; and doubts."""


def _by_theory(
    numbers: Numbers, names: tuple[str, ...], outputs: Mapping[str, str], method: str, progress: Progress | None
) -> Found:
    base, statement = theory_values(numbers.system, method, names)
    if not base:
        raise ValueError(f"method {shown(method)} has no answer for this model: {statement}")
    for name in names:
        known_word(name, [*base, *outputs], "quantities", "must be among")
    unknown, derivatives, said = np.full(len(names), math.nan), {}, []
    for name in counted(numbers.values, progress):

        def logarithms(distance: float, name: str = name) -> Floats | None:
            if not (found := if_allowed(lambda: theory_values(numbers.moved(name, distance), method, names)[0])):
                return None
            return np.array([_logarithm(found.get(quantity, math.nan), base[quantity]) for quantity in names])

        own = stencil(lambda distance: logarithms(distance) is not None, THEORY_STEP)
        result = None if own is None else _extrapolated(own, logarithms)
        if result is None:
            said.append(f"{method} has no answer on either side of {name} = {numbers.values[name]:g}.")
        derivatives[name] = *(result or (unknown, unknown)), unknown
    return base, derivatives, said


def _extrapolated(own: Stencil, logarithms: Any) -> tuple[Floats, Floats] | None:
    differences = []
    for level in range(3):
        step = THEORY_STEP / 2**level
        found = [logarithms(offset * step) for offset in own.offsets]
        if any(each is None for each in found):
            return None
        differences.append(np.asarray(sum(w * f for w, f in zip(own.weights, found, strict=True)) / step))
    return extrapolated(differences, own.powers)


def _by_monte_carlo(
    numbers: Numbers, names: tuple[str, ...], outputs: Mapping[str, str], settings: Settings, step: float,
    progress: Progress | None,
) -> Found:  # fmt: skip
    said: list[str] = []
    forces = [of for square, of in outputs.items() if square in names]
    stencils: dict[str, Stencil] = {}
    for name, value in numbers.values.items():

        def allowed(distance: float, name: str = name) -> bool:
            return if_stationary(lambda: numbers.moved(name, distance), "sensitivity") is not None

        own = stencil(allowed, step)
        if own is None:
            said.append(f"{name} cannot be changed from {value:g}: its part refuses both sides.")
        else:
            stencils[name] = own
    runs = 1 + sum(1 for own in stencils.values() for offset in own.offsets if offset)
    done = 0

    def simulated(system: System) -> dict[str, tuple[float, Floats, float]]:
        nonlocal done
        found = samples_of(system, settings, progress, done, runs, forces)
        done += 1
        return found

    base, motion = simulated(numbers.system), motion_of(numbers.system)
    for name in names:
        known_word(name, [*base, *outputs], "quantities", "must be among")
    lossy = [speed.removesuffix("impact_speed") for speed, walls in motion.struck_in(settings.step).items()
             if walls.restitution < 1.0]  # fmt: skip
    if any("impact_" in name and name.startswith(before) for before in lossy for name in names):
        said.append("The walls are lossy: impacts slower than the step resolves are not counted, on neither side.")
    for name in names:
        if math.isnan(base[name][0]):
            why = motion.uncounted_because(name)
            said.append(f"{name} has no value for this model{f': {why}' if why else ''}.")
        elif base[name][0] == 0.0:
            said.append(f"{name} is 0 for this model: it has no relative change.")
    derivatives = {}
    for name in numbers.values:
        sides = (
            [base if offset == 0.0 else simulated(numbers.moved(name, offset * step)) for offset in own.offsets]
            if (own := stencils.get(name)) else []
        )  # fmt: skip
        found = []
        for quantity in names:
            found.append((math.nan, math.nan, math.nan))
            if math.isnan(base[quantity][0]) or base[quantity][0] == 0.0:
                continue
            values = np.array([side[quantity][0] for side in (*sides, base)])
            if own is not None and ((values > 0.0).all() or (values < 0.0).all()):
                found[-1] = _difference([side[quantity] for side in sides], own, step)
            elif own is not None:
                said.append(f"{quantity} changes its sign, or is not known, near {name} = {numbers.values[name]:g}.")
        derivatives[name] = (*zip(*found, strict=True),)
    return {name: value for name, (value, _, _) in base.items()}, derivatives, said


def _difference(sides: Sequence[tuple[float, Floats, float]], own: Stencil, step: float) -> tuple[float, float, float]:
    """The derivative of the logarithm, its standard error, and the gain of common random numbers.

    Examples
    --------
    >>> common = np.array([1.0, 2.0, 4.0, 3.0])
    >>> sides = [(2.5, common, 0.0), (5.0, 2.0 * common, 0.0)]
    >>> [float(round(number, 3)) for number in _difference(sides, Stencil((-1.0, 1.0), (-0.5, 0.5), (2,)), 0.1)]
    [3.466, 0.0, inf]
    """
    weights = [weight / step for weight in own.weights]
    value = sum(w * math.log(abs(side[0])) for w, side in zip(weights, sides, strict=True))
    relative = [w * samples / mean for w, (mean, samples, _) in zip(weights, sides, strict=True)]
    common = standard_error(np.sum(relative, axis=0))
    apart = math.hypot(*(standard_error(each) for each in relative))
    start = math.hypot(*(w * error / mean for w, (mean, _, error) in zip(weights, sides, strict=True)))
    gain = (apart / common) ** 2 if common > 1e-12 * apart else math.inf
    return value, math.hypot(common, start), gain


def _logarithm(new: float, old: float) -> float:
    """ln(new / old); NaN if they differ in sign or one is 0."""
    return math.log(new / old) if old != 0.0 and new / old > 0.0 else math.nan
