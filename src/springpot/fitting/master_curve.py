"""Master curves: moduli at several temperatures, shifted along the frequency until they are one curve."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.likelihood import inverse, replaced
from springpot.fitting.part_data import MeasuredModuli
from springpot.machine.arguments import finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import shown
from springpot.problem.temperature import Shift

_LOG10 = math.log(10.0)
_MOST_PIECES = 10  # of the spline
_POINTS_A_PIECE = 6
_TRIED = 401  # shifts of one table against the next
_SHARED = 3  # points of either table, at least, in what two tables have in common at a shift that is tried


@dataclass(frozen=True, eq=False)
class MasterCurve:
    """Moduli of several temperatures as one curve.

    Attributes
    ----------
    data : MeasuredModuli
        All points at the frequencies of the reference.
    factors : dict of float
        The shift factor a by the temperature; 1 at the reference.
    errors : dict of float
        Standard error of each log10 a, from the scatter about the curve; 0 at the reference.
    relative_error : float
        The scatter of the moduli about the curve.
    """

    data: MeasuredModuli
    factors: Mapping[float, float]
    errors: Mapping[float, float]
    relative_error: float

    @property
    def shift(self) -> Shift:
        """The factors as a table, for `Shift.at`."""
        return Shift.table([*self.factors], [*self.factors.values()])


def master_curve(tables: Mapping[float, MeasuredModuli], *, reference: float) -> MasterCurve:
    """Shift measured moduli of several temperatures to those of one.

    Parameters
    ----------
    tables : mapping
        Moduli by their temperature in degrees Celsius; all of them storage and loss, or all the same one.  Each must
        share moduli with that of the next temperature.
    reference : float
        One of the temperatures.

    Returns
    -------
    MasterCurve

    Raises
    ------
    TypeError, ValueError
        If the tables are not as said, or have nothing in common when they are shifted.

    Notes
    -----
    The logarithms of the moduli are a cubic spline of that of a f, whose number of pieces has the smallest Bayesian
    information criterion.  Spline and factors are found together by least squares, so that the errors of the factors
    allow for the unknown curve.  Moduli are not shifted vertically.

    Examples
    --------
    A springpot beside a spring, whose times are ten times longer at 0 degrees:

    >>> f = np.geomspace(0.1, 100.0, 20)
    >>> def moduli(a):
    ...     found = 3.0 + 2.0 * (2j * np.pi * a * f) ** 0.4
    ...     return MeasuredModuli(f, found.real, found.imag)
    >>> found = master_curve({0.0: moduli(10.0), 20.0: moduli(1.0)}, reference=20.0)
    >>> round(found.factors[0.0], 2), found.data.size
    (10.0, 80)
    """
    warmth, columns, log_f, values = _checked(tables)
    base = finite_number(reference, "reference")
    if base not in warmth:
        raise ValueError(f"reference must be one of the temperatures, not {base:g}.")
    home = warmth.index(base)
    start = _first(log_f, values, home)
    free = np.arange(len(warmth)) != home
    best: tuple[float, Floats, Floats, float] | None = None
    count = sum(each.size for each in values)
    for pieces in range(1, min(_MOST_PIECES, count // len(columns) // _POINTS_A_PIECE) + 1):
        shifts, slopes, rest = _solved(log_f, values, start, free, pieces)
        numbers = int(free.sum()) + len(columns) * (pieces + 3)
        bic = count * math.log(max(rest, 1e-300) / count) + numbers * math.log(count)
        if best is None or bic < best[0]:
            scatter = rest / (count - numbers)
            best = bic, shifts, inverse(slopes.T @ slopes) * scatter, scatter
    if best is None:
        raise ValueError(f"tables must have more points than {count}.")
    _, shifts, covariance, scatter = best
    _check_shared(warmth, log_f, shifts)
    size = np.zeros(len(warmth))
    size[free] = np.sqrt(np.diag(covariance)) / _LOG10
    where = np.concatenate([own + shift for own, shift in zip(log_f, shifts, strict=True)])
    order = np.argsort(where)
    joined = {name: np.exp(np.concatenate([own[n] for own in values])[order]) for n, name in enumerate(columns)}
    ascending = where[order] + 1e-12 * np.arange(where.size)  # points of two tables may fall on one frequency
    return MasterCurve(
        MeasuredModuli(np.exp(ascending), **joined),
        dict(zip(warmth, np.exp(shifts).tolist(), strict=True)),
        dict(zip(warmth, size.tolist(), strict=True)),
        math.sqrt(scatter),
    )


def _checked(tables: object) -> tuple[list[float], list[str], list[Floats], list[Floats]]:
    """Temperatures, ascending, the names of the columns, and logarithms of frequencies and moduli."""
    if not isinstance(tables, Mapping) or len(tables) < 2:
        raise TypeError(f"tables must be moduli by two temperatures or more, not {shown(tables)}.")
    warmth = sorted(finite_number(celsius, "temperature of tables") for celsius in tables)
    found = [tables[celsius] for celsius in warmth]
    for each in found:
        if not isinstance(each, MeasuredModuli):
            raise TypeError(f"tables must be of MeasuredModuli, not {shown(each)}.")
    columns = [name for name, _ in found[0].columns()]
    if any([name for name, _ in each.columns()] != columns for each in found):
        raise ValueError("tables must all have storage and loss, or all the same one.")
    logs = [np.log(each.frequency_hz) for each in found]
    return warmth, columns, logs, [np.log([values for _, values in each.columns()]) for each in found]


def _first(log_f: Sequence[Floats], values: Sequence[Floats], home: int) -> Floats:
    """Shifts at which each table lies best on that of the next temperature towards the reference."""
    found = np.zeros(len(log_f))
    for n in (*range(home - 1, -1, -1), *range(home + 1, len(log_f))):
        other = n + 1 if n < home else n - 1
        u, v = log_f[n], log_f[other] + found[other]
        tried = np.linspace(v[0] - u[-1], v[-1] - u[0], _TRIED)
        found[n] = tried[np.argmin([_apart(u + shift, values[n], v, values[other]) for shift in tried])]
    return found


def _apart(u: Floats, one: Floats, v: Floats, other: Floats) -> float:
    """Mean square of the difference of two tables where both are; infinite where they share too few points."""
    inside, back = (u >= v[0]) & (u <= v[-1]), (v >= u[0]) & (v <= u[-1])
    if min(inside.sum(), back.sum()) < _SHARED:
        return math.inf
    found = [np.interp(u[inside], v, b) - a[inside] for a, b in zip(one, other, strict=True)]
    return float(np.mean(np.square(found)))


def _solved(
    log_f: Sequence[Floats], values: Sequence[Floats], start: Floats, free: NDArray[np.bool_], pieces: int
) -> tuple[Floats, Floats, float]:
    """The shifts at the least sum of squares about a spline, the slopes of the residuals, and that sum."""
    from scipy.interpolate import BSpline
    from scipy.optimize import least_squares

    first = np.concatenate([own + shift for own, shift in zip(log_f, start, strict=True)])
    knots = np.linspace(first.min(), first.max(), pieces + 1)
    knots = np.concatenate([knots[:1].repeat(3), knots, knots[-1:].repeat(3)])
    joined = np.concatenate(values, axis=1)

    def residuals(part: Floats) -> Floats:
        shifts = replaced(start, free, part)
        where = np.concatenate([own + shift for own, shift in zip(log_f, shifts, strict=True)])
        basis = BSpline.design_matrix(where, knots, 3, extrapolate=True).toarray()
        own, sizes, _ = np.linalg.svd(basis, full_matrices=False)
        own = own[:, sizes > 1e-10 * sizes[0]]
        return np.asarray((joined.T - own @ (own.T @ joined.T)).T.ravel())

    found = least_squares(residuals, start[free], x_scale=1.0, xtol=1e-12, ftol=1e-12, gtol=1e-12, jac="3-point")
    return replaced(start, free, found.x), np.asarray(found.jac), 2.0 * float(found.cost)


def _check_shared(warmth: Sequence[float], log_f: Sequence[Floats], shifts: Floats) -> None:
    """Each table must overlap with the next one, for no shift is known across a gap."""
    for n in range(len(warmth) - 1):
        one, other = (log_f[m][[0, -1]] + shifts[m] for m in (n, n + 1))
        if one[0] > other[1] or other[0] > one[1]:
            raise ValueError(
                f"tables of {warmth[n]:g} and {warmth[n + 1]:g} degrees must share moduli when they are shifted: "
                "measure a temperature between them, or more frequencies."
            )
