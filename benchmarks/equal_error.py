"""Processor time to an equal error: <A^2>, <x> and the impact rate above an elastic wall at 0, C = Omega = q = 1.

The squared error of an estimate is bias(h)^2 + variance.  Each method is run at several steps h, by turns.  This gives
the processor time of a path-step, the bias (at order 1 against the exact law, at order 0.5 against a fine run of
springpot) and the variance for a second of simulated time, once the start is forgotten.  The time to an error then is
the least over the steps of (time of a path-step) x (path-steps after which bias^2 + variance = error^2).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import numpy.typing as npt

from benchmarks.history import one_thread
from benchmarks.measure import Row, load
from benchmarks.peers import compiled_diffrax, mirrored_chain, numpy_and_numba, numpy_only
from benchmarks.plain import plain_of
from springpot import Oscillator, Springpot, System
from springpot.simulation import simulate
from springpot.simulation.kernel.lanes import LANES
from springpot.simulation.kernel.native import key_words
from springpot.theory import exact

__all__ = [
    "METHODS",
    "OURS",
    "QUANTITIES",
    "RTOL",
    "TARGETS",
    "AtStep",
    "Needed",
    "equal_error",
    "is_time",
    "needed",
    "section_of",
]

Floats = npt.NDArray[np.float64]
QUANTITIES = {"amplitude_mean_square": "<A^2>", "x_mean": "<x>", "impact_rate": "impact rate"}
TARGETS = (0.01, 0.002)
OURS, RTOL = "springpot, best step", "springpot, simulate(rtol=)"
HYBRID, PLAIN, NUMPY, DIFFRAX = "NumPy normals, Numba step", "plain kernel", "NumPy", "diffrax"
PAST = "NumPy, whole past"
METHODS = {1.0: (OURS, RTOL, PLAIN, HYBRID, NUMPY, DIFFRAX), 0.5: (OURS, RTOL, PLAIN, PAST)}

_LENGTH, _BURN = 400.0, 40.0  # s, of a path, and of it left out
_SHORT, _SHORT_BURN = 40.0, 20.0  # with the whole past, where long paths cost more
_FINE = 0.025  # step of the reference, in s
_PAST_SIZE = 1000  # paths and steps, at which the whole past is timed


# the reference at order 0.5 starts from rest, as the other methods do; simulate(rtol=) starts from the stationary mean
_OFF = {1.0: "their error", 0.5: "off the runs from rest by"}


@dataclass(frozen=True)
class AtStep:
    """A method at one step size; bias, its standard error and the variance are relative, one of each quantity.

    Parameters
    ----------
    step : float
        In s.
    cost : float
        Processor time of a path-step, in s.
    bias, error : ndarray, shape (3,)
    variance : ndarray, shape (3,)
        Of an average over 1 s, in s.
    """

    step: float
    cost: float
    bias: Floats
    error: Floats
    variance: Floats


@dataclass(frozen=True)
class Needed:
    """The cheapest way of a method to an error: processor time in s, and at which step; infinite if there is none."""

    seconds: float
    at: AtStep | None


def needed(tried: list[AtStep], number: int, target: float) -> Needed:
    """Time to the relative error ``target`` of the quantity ``number``, at the best of the steps.

    The standard error of a measured bias counts as a bias.

    Examples
    --------
    >>> one = np.ones(1)
    >>> coarse, fine = (AtStep(h, 1e-9, h * one, 0.0 * one, one) for h in (0.02, 0.006))
    >>> found = needed([coarse, fine], 0, 0.01)
    >>> found.at is fine, f"{found.seconds:.2g}"  # 1 s / 0.008^2 in steps of 0.006 s
    (True, '0.0026')
    >>> needed([coarse, fine], 0, 0.001).seconds
    inf
    """
    found = Needed(math.inf, None)
    for at in tried:
        left = target**2 - at.bias[number] ** 2 - at.error[number] ** 2
        if left > 0.0:
            seconds = at.cost * at.variance[number] / left / at.step
            if seconds < found.seconds:
                found = Needed(seconds, at)
    return found


def section_of(order: float, word: str, target: float) -> str:
    """The section of the times of one quantity to one error.

    Examples
    --------
    >>> section_of(0.5, "<x>", 0.002)
    'equal error, order 0.5, <x> to 0.2 %'
    """
    return f"equal error, order {order:g}, {word} to {100 * target:g} %"


def is_time(row: Row) -> bool:
    """Whether the row is the time to an error."""
    return row.section.startswith("equal error, order") and row.section.endswith(" %")


# --- measuring ----------------------------------------------------------------------------------------------------


@dataclass
class _Pool:
    """What the turns gave: means with errors, least processor time of a path-step, simulated time in the averages."""

    means: list[Floats] = field(default_factory=list)
    errors: list[Floats] = field(default_factory=list)
    cost: float = math.inf
    averaged: float = 0.0

    def add(self, rows: tuple[Floats, Floats], paths: int, steps: int, step: float, taken: float) -> None:
        self.means.append(rows[0])
        self.errors.append(rows[1])
        self.cost = min(self.cost, taken / (paths * steps))
        self.averaged += paths * (_LENGTH - _BURN)

    def estimate(self) -> tuple[Floats, Floats]:
        errors = np.array(self.errors)
        return np.mean(self.means, axis=0), np.sqrt((errors**2).sum(axis=0)) / len(errors)

    def at(self, step: float, law: tuple[Floats, Floats], cost: float | None = None) -> AtStep:
        mean, error = self.estimate()
        return AtStep(
            step, self.cost if cost is None else cost, mean / law[0] - 1.0,
            np.hypot(error / mean, law[1] / law[0]), (error / mean) ** 2 * self.averaged,
        )  # fmt: skip


_Work = Callable[[float, int, int], tuple[Floats, Floats]]  # step, paths, seed -> means and their standard errors


def _of_paths(kept: Floats) -> tuple[Floats, Floats]:
    return kept.mean(axis=1), kept.std(axis=1, ddof=1) / math.sqrt(kept.shape[1])


def _count(step: float) -> tuple[int, int]:
    return round(_LENGTH / step), round(_BURN / step)


def _ours(oscillator: System, scheme: str, step: float, paths: int, seed: int) -> tuple[Floats, Floats]:
    found = simulate(
        oscillator, paths=paths, duration=_LENGTH, window=(_BURN, _LENGTH), step=step, start="rest", threads=1,
        seed=seed, scheme=scheme,  # type: ignore[arg-type]
    )  # fmt: skip
    return np.array([found[q].value for q in QUANTITIES]), np.array([found[q].error for q in QUANTITIES])


def _plain(oscillator: System, step: float, paths: int, seed: int) -> tuple[Floats, Floats]:
    steps, burn = _count(step)
    plain = plain_of(oscillator, steps, step=step)
    out = np.concatenate([plain.run(steps, burn, key_words((seed << 32) + block)) for block in range(paths // LANES)])
    return _of_paths(np.array([out[:, 0] + out[:, 1], out[:, 2], out[:, 3] / step]))


def _hybrid(step: float, paths: int, seed: int) -> tuple[Floats, Floats]:
    return _of_paths(numpy_and_numba(paths, *_count(step), step, seed))


def _cpu(work: Callable[[], object]) -> tuple[object, float]:
    begun = time.process_time()
    found = work()
    return found, time.process_time() - begun


def _pools(works: dict[str, tuple[_Work, tuple[float, ...], int]], turns: int) -> dict[str, dict[float, _Pool]]:
    """Every method at every step, by turns, each turn with a seed of its own."""
    pools = {name: {step: _Pool() for step in steps} for name, (_, steps, _) in works.items()}
    for work, steps, _ in works.values():
        work(steps[0], LANES, 1)  # compiles
    for turn in range(turns):
        for name, (work, steps, paths) in works.items():
            for step in steps:
                begun = time.process_time()
                rows = work(step, paths, 101 + turn)
                pools[name][step].add(rows, paths, _count(step)[0], step, time.process_time() - begun)
    return pools


def _cost_of_steps(quick: bool, turns: int) -> dict[str, float]:
    """Processor time of a path-step of NumPy and of diffrax, which does not depend on the step; without it if none."""
    paths, steps = (250, 100) if quick else (2000, 1000)
    works = {NUMPY: partial(numpy_only, paths, steps, steps // 10, 0.01)}
    with suppress(ImportError):
        works[DIFFRAX] = compiled_diffrax(paths, steps, steps // 10, 0.01)  # type: ignore[assignment]
    least = dict.fromkeys(works, math.inf)
    for _ in range(turns + 1):
        for name, work in works.items():
            least[name] = min(least[name], _cpu(work)[1] / (paths * steps))
    return least


def _cost_of_past(quick: bool, turns: int) -> float:
    """Processor time of a path with the whole past, over the square of its steps."""
    size = 200 if quick else _PAST_SIZE
    return min(one_thread(size, size) for _ in range(turns)) / size**3


def _asked(oscillator: System, name: str, target: float, truth: float, seeds: int) -> tuple[float, float]:
    """Mean processor time of a run asked for this error, pilot runs included, and the error that it had (rms)."""
    taken, errors = [], []
    for seed in range(1, seeds + 1):
        # half a 95 % interval is 1.96 standard errors: asked for so much, a run has this root mean square error
        work = partial(simulate, oscillator, rtol=1.96 * target, quantities=(name,), threads=1, seed=seed)
        found, seconds = _cpu(work)
        taken.append(seconds)
        errors.append(found[name].value / truth - 1.0)  # type: ignore[attr-defined]
    return float(np.mean(taken)), float(np.sqrt(np.mean(np.square(errors))))


# --- the rows -----------------------------------------------------------------------------------------------------


def _percent(at: AtStep, number: int) -> str:
    error = f"+- {100 * at.error[number]:.2f} %" if at.error[number] > 0.0 else "% (exact)"
    return f"{100 * at.bias[number]:+.2f} {error}"


def _measured(section: str, tried: dict[str, list[AtStep]]) -> list[Row]:
    rows = []
    for name, steps in tried.items():
        if name in (NUMPY, DIFFRAX):
            note = f"at any h; bias that of {HYBRID}"
            rows.append(Row(section, name, 1e9 * steps[0].cost, "ns per path-step", note=note))
            continue
        for at in steps:
            words = ", ".join(f"{word} {_percent(at, number)}" for number, word in enumerate(QUANTITIES.values()))
            rows.append(Row(section, f"{name}, h = {at.step:g}", 1e9 * at.cost, "ns per path-step", note=words))
    return rows


def _times(order: float, tried: dict[str, list[AtStep]], law: Floats, seeds: tuple[int, int]) -> list[Row]:
    oscillator, rows = Oscillator(springpot=Springpot(order, 1.0)), []
    for number, (name, word) in enumerate(QUANTITIES.items()):
        for target, runs in zip(TARGETS, seeds, strict=True):
            section = section_of(order, word, target)
            ours = needed(tried[OURS], number, target).seconds
            for method in METHODS[order]:
                if method == RTOL:
                    seconds, error = _asked(oscillator, name, target, float(law[number]), runs)
                    note = f"whole calls; {_OFF[order]} {error:.2%} (rms of {runs})"
                    rows.append(_row(section, method, seconds, ours, note))
                elif method not in tried:
                    rows.append(
                        Row(section, method, None, "", note="skipped: not installed (dependency group 'bench')")
                    )
                else:
                    rows.append(_time_row(section, method, tried[method], number, target, ours))
    return rows


def _time_row(section: str, method: str, tried: list[AtStep], number: int, target: float, ours: float) -> Row:
    found = needed(tried, number, target)
    if found.at is None:
        least = min(at.step for at in tried)
        return Row(section, method, None, "", note=f"not reached at any step down to h = {least:g}")
    note = f"h = {found.at.step:g}, bias {_percent(found.at, number)}"
    return _row(section, method, found.seconds, ours, note)


def _row(section: str, method: str, seconds: float, ours: float, note: str) -> Row:
    known = math.isfinite(ours)
    return Row(section, method, seconds, "s CPU", seconds / ours if known else None, OURS if known else "", note)


def _order_one(quick: bool, turns: int, paths: int) -> tuple[dict[str, list[AtStep]], Floats, list[Row]]:
    oscillator = Oscillator(springpot=Springpot(1.0, 1.0))
    result = exact(oscillator)
    law = np.array([getattr(result, name) for name in QUANTITIES])
    coarse, fine = (2.5, 2.0, 1.6, 1.0, 0.5, 0.2, 0.05), (0.16, 0.08, 0.04, 0.02, 0.01, 0.005, 0.0025)
    works: dict[str, tuple[_Work, tuple[float, ...], int]] = {
        OURS: (partial(_ours, oscillator, "default"), coarse, 16 * paths),  # so many that the call itself is little
        PLAIN: (partial(_plain, oscillator), fine[:3] if quick else fine, paths),
        HYBRID: (_hybrid, (0.04,) if quick else (0.08, 0.02, 0.01), paths // 2),
    }
    pools, none = _pools(works, turns), np.zeros(3)
    tried = {name: [pool.at(step, (law, none)) for step, pool in pools[name].items()] for name in (OURS, PLAIN)}
    # the other three take the same steps, whose law is known; their bias is exact, and the runs must agree with it
    hybrid = [pool.at(step, (mirrored_chain(step), none)) for step, pool in pools[HYBRID].items()]
    worst = max(float(np.abs(at.bias / at.error).max()) for at in hybrid)
    costs = {HYBRID: min(at.cost for at in hybrid), **_cost_of_steps(quick, turns)}
    for name, cost in costs.items():
        tried[name] = [AtStep(h, cost, mirrored_chain(h) / law - 1.0, none, hybrid[-1].variance) for h in fine]
    note = (
        "biases of NumPy, NumPy and Numba, and diffrax are exact (the mirrored chain of their step); "
        f"{3 * len(hybrid)} measured means differ from these by at most {worst:.1f} standard errors"
    )
    return tried, law, [Row("equal error, order 1, measured", "Euler step mirrored at the wall", None, "", note=note)]


def _order_half(quick: bool, turns: int, paths: int) -> tuple[dict[str, list[AtStep]], Floats]:
    oscillator = Oscillator(springpot=Springpot(0.5, 1.0))
    fine = (0.08, 0.04) if quick else (0.08, 0.04, 0.02, 0.01, 0.005)
    works: dict[str, tuple[_Work, tuple[float, ...], int]] = {
        OURS: (partial(_ours, oscillator, "default"), (0.5, 0.4, 0.2, 0.1, 0.05), 4 * paths),
        PLAIN: (partial(_plain, oscillator), fine, 2 * paths),
        # the same scheme and wall as with the whole past: its bias
        PAST: (partial(_ours, oscillator, "grunwald"), fine, 2 * paths),
        "fine": (partial(_ours, oscillator, "default"), (0.1,) if quick else (_FINE,), 8 * paths),
    }
    pools = _pools(works, turns)
    ((_, reference),) = pools.pop("fine").items()
    law = reference.estimate()
    tried = {name: [pool.at(step, law) for step, pool in pools[name].items()] for name in (OURS, PLAIN)}
    cost = _cost_of_past(quick, turns)
    share = (_SHORT - _SHORT_BURN) / _SHORT  # of a path is averaged
    tried[PAST] = [pool.at(step, law, cost * (_SHORT / step) / share) for step, pool in pools[PAST].items()]
    return tried, law[0]


def equal_error(quick: bool) -> list[Row]:
    """Rows of the section on equal errors."""
    turns, paths = (1, 64) if quick else (3, 1280)
    waiting, begun = load(), time.process_time()
    first, law, more = _order_one(quick, turns, paths)
    rows = [*_measured("equal error, order 1, measured", first), *more]
    times = _times(1.0, first, law, (1, 1) if quick else (4, 1))
    half, law = _order_half(quick, turns, paths)
    rows += _measured("equal error, order 0.5, measured", half)
    times += _times(0.5, half, law, (1, 1) if quick else (4, 1))
    words = f"least of {turns} turns; {time.process_time() - begun:.0f} s CPU in all; load of the machine {waiting:.1f}"
    return [Row("equal error, conditions", "processor time", None, "", note=words), *times, *rows]
