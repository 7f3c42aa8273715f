"""One path without noise or wall, x'' + 0.5 D^0.5 x + x = 0 with x(0) = 1, against its exact solution."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit
from scipy import special

from benchmarks.measure import Row, best_cpu
from springpot import Oscillator, Springpot, WhiteNoise
from springpot.memory import direct
from springpot.simulation import simulate

__all__ = ["exact", "free_response"]

Floats = npt.NDArray[np.float64]
COEFFICIENT, DURATION = 0.5, 10.0


class Solved(NamedTuple):
    """A solver at one number of steps."""

    name: str
    steps: int
    seconds: float
    error: float


def exact(t: Floats) -> Floats:
    """x(t), from the partial fractions of its Laplace transform in the square root of s.

    Examples
    --------
    >>> exact(np.array([0.0, 1.0])).round(6)
    array([1.      , 0.674306])
    """
    roots = np.roots([1.0, 0.0, 0.0, COEFFICIENT, 1.0]).astype(complex)
    for _ in range(4):  # Newton's method takes the last digits in
        roots -= (roots**4 + COEFFICIENT * roots + 1.0) / (4.0 * roots**3 + COEFFICIENT)
    residues = 1.0 / (4.0 * roots**3 + COEFFICIENT)
    grown = special.wofz(-1j * roots * np.sqrt(t)[:, None])  # exp(z^2) erfc(-z) of z = root sqrt(t)
    return np.asarray(1.0 - np.real(np.sum(residues * (grown - 1.0) / roots, axis=1)))


def _error(t: Floats, x: Floats) -> float:
    return float(np.abs(x - exact(t)).max())


def _ours(steps: int, times: int) -> Solved:
    oscillator = Oscillator(1.0, Springpot(0.5, COEFFICIENT), None, WhiteNoise(0.0))

    def solve() -> tuple[Floats, Floats]:
        found = simulate(
            oscillator, paths=1, record=1, threads=1, duration=DURATION, step=DURATION / steps, initial_position=1.0,
            memory_tolerance=1e-8,
        )  # fmt: skip
        return found.time, found.record[0, :, 0]

    error = _error(*solve())
    return Solved("springpot", steps, best_cpu(solve, times), error)


@njit
def _grunwald(weights, step, x):
    """Semi-implicit Euler with the whole past."""
    v = 0.0
    increments = np.zeros(x.size)
    for n in range(x.size - 1):
        past = 0.0
        for j in range(n):
            past += weights[j] * increments[n - 1 - j]
        v -= step * (x[n] + past)
        increments[n] = step * v
        x[n + 1] = x[n] + increments[n]


def _numba(steps: int, times: int) -> Solved:
    step = DURATION / steps
    weights = COEFFICIENT * step**-0.5 * direct("grunwald", 0.5, steps)
    x = np.ones(steps + 1)
    _grunwald(weights, step, x[:2])
    seconds = best_cpu(lambda: _grunwald(weights, step, x), times)
    return Solved("Numba, whole past", steps, seconds, _error(step * np.arange(steps + 1), x))


def _pycaputo(name: str, steps: int, times: int) -> Solved:
    """A solver of pycaputo, for the system of x, D^0.5 x and x'.

    Raises
    ------
    ImportError
        If pycaputo is not installed.
    """
    from pycaputo.controller import make_fixed_controller
    from pycaputo.derivatives import CaputoDerivative
    from pycaputo.events import StepCompleted, StepFailed
    from pycaputo.fode import caputo
    from pycaputo.stepping import evolve

    step = DURATION / steps

    def source(t: float, y: Floats) -> Floats:
        return np.array([y[1], y[2], -COEFFICIENT * y[1] - y[0]])

    def solve() -> tuple[Floats, Floats]:
        more = {"corrector_iterations": 1} if name == "PECE" else {}
        method = getattr(caputo, name)(
            ds=tuple(CaputoDerivative(order) for order in (0.5, 0.5, 1.0)),
            control=make_fixed_controller(step, tstart=0.0, tfinal=DURATION),
            source=source, y0=(np.array([1.0, 0.0, 0.0]),), **more,
        )  # fmt: skip
        t, x = [], []
        for event in evolve(method, dtinit=step):
            if isinstance(event, StepFailed):
                raise ArithmeticError(f"pycaputo's {name} failed: {event}")
            if isinstance(event, StepCompleted):
                t.append(event.t)
                x.append(event.y[0])
        return np.array(t), np.array(x)

    found: list[tuple[Floats, Floats]] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        seconds = best_cpu(lambda: found.append(solve()), times)
    return Solved(f"pycaputo {name}", steps, seconds, _error(*found[-1]))


def _row(section: str, other: Solved, ladder: list[Solved]) -> Row:
    """What the other took, over what springpot takes for an error at least as small."""
    case = f"{other.name}, {other.steps} steps"
    good = [mine for mine in ladder if mine.error <= other.error]
    note = f"largest error {other.error:.1e}"
    if not good:
        return Row(section, case, other.seconds, "s CPU", note=f"{note}; springpot was not run to so small an error")
    mine = min(good, key=lambda solved: solved.seconds)
    return Row(
        section, case, other.seconds, "s CPU", other.seconds / mine.seconds, "springpot at the same error or less",
        f"{note}; springpot: {mine.steps} steps, {mine.error:.1e}",
    )  # fmt: skip


def free_response(quick: bool) -> list[Row]:
    """Rows of section 5."""
    section = "free response, order 0.5, one path, 10 s"
    times = 1 if quick else 3
    sizes = (100, 200) if quick else (1000, 10_000)
    ladder_sizes = (50, 200, 1000) if quick else (50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000)
    ladder = [_ours(steps, 2 * times) for steps in ladder_sizes]
    others = [_numba(steps, times) for steps in sizes]
    solvers: tuple[Callable[[], Solved], ...] = tuple(
        lambda name=name, steps=steps: _pycaputo(name, steps, 1 if steps > 5000 else times)  # type: ignore[misc]
        for name in ("ExplicitTrapezoidal", "PECE")
        for steps in sizes
    )
    skipped = []
    try:
        others += [solve() for solve in solvers]
    except ImportError:
        skipped = [Row(section, "pycaputo", None, "", note="skipped: not installed (dependency group 'bench')")]
    shown = [mine for mine in ladder if mine.steps in (*sizes, ladder_sizes[-1])]
    note = "a block of 64 paths is computed all the same"
    return [
        *(
            Row(section, f"springpot, {m.steps} steps", m.seconds, "s CPU", note=f"largest error {m.error:.1e}; {note}")
            for m in shown
        ),
        *(_row(section, other, ladder) for other in others),
        *skipped,
    ]
