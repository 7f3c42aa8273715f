"""The curve of level against return period that a tab asks for: found by splitting, further right step by step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.explorer.ends import titled
from springpot.explorer.excitation import chart
from springpot.explorer.protocol import Rare
from springpot.explorer.requests import text_of
from springpot.explorer.sliders import written
from springpot.machine.faults import Stopped

if TYPE_CHECKING:
    from springpot.problem.system import System
    from springpot.simulation.rare.search import ExceedanceCurve

__all__ = ["LEVELS", "growing"]

LEVELS = 13  # of the curve
SHARES = 5, 7, 9, 11, 13  # of these, how many each step asks for: the last one takes about as long as all before it


def growing(
    system: System, asked: Rare, run: Mapping[str, Any], progress: Callable[..., None], stop: Callable[[], bool]
) -> dict[str, Any]:
    """Exceedance of more and more levels, the frequent ones first: numbers as words and texts, a chart, and warnings.

    Parameters
    ----------
    system : System
    asked : Rare
    run : dict
        Seed, start and threads.
    progress : callable
        Told the fraction done, and what is known so far.
    stop : callable
        Tells whether to stop; what is known by then stays.

    Raises
    ------
    TypeError, ValueError
        If it cannot be asked, in one sentence.

    Examples
    --------
    >>> from springpot.problem.oscillator import Oscillator
    >>> wish = Rare(kind="rare", of="x", low=2.0, high=3.0, duration=20.0, rtol=0.5)
    >>> found = growing(Oscillator(), wish, {"start": "rest"}, lambda fraction, **known: None, lambda: False)
    >>> found["charts"][0]["y"], len(found["numbers"])
    (('return period', 's'), 13)
    """
    from springpot.simulation.rare.exceedance import exceeded

    if asked.low == asked.high:
        raise ValueError("the first and the last level must differ: the curve goes from the one to the other.")
    levels = np.linspace(asked.low, asked.high, LEVELS)
    known = dict[str, Any]()
    for number, count in enumerate(SHARES):

        def check(fraction: float, number: int = number, known: dict[str, Any] = known) -> None:
            if stop():
                raise Stopped("it was stopped.")
            progress((number + fraction) / len(SHARES), **known)

        try:
            curve = exceeded(
                system, {asked.of: levels[:count]}, duration=asked.duration, rtol=asked.rtol, **run, progress=check
            )[asked.of]
        except Stopped:
            return known | {"said": [f"Stopped: the curve has {known.get('found', 0)} of {LEVELS} levels."]}
        known = _shown(curve, levels, asked.duration)
    return known


def _shown(curve: ExceedanceCurve, levels: Any, duration: float) -> dict[str, Any]:
    """A curve as the page shows it, on an axis that has room for all levels."""
    title, unit = titled(curve.name), written(curve.unit)
    missing = np.full(levels.size - curve.levels.size, math.nan)
    values, low, high = (np.concatenate([each, missing]) for each in (curve.return_period, *curve.return_interval))
    numbers = [
        (f"{title} past {level:.6g} {unit}, within {duration:.4g} s", text_of(said))
        for level, said in zip(curve.levels, curve.said, strict=True)
    ]
    how = {"splitting": "by splitting", "plain": "on plain paths"}[curve.method]
    note = f"{curve.repetitions} repetitions of {curve.paths} paths {how}. The band is the 95 % interval."
    order = np.argsort(levels)  # those below the start are exceeded downwards
    at = levels[order]
    line = {"name": "return period", "values": values[order], "low": low[order], "high": high[order]}
    drawn = chart(f"{title}: level against return period", (f"level of {title}", unit), ("return period", "s"), at,
                  [line], logarithmic="y", note=note)  # fmt: skip
    return {"numbers": numbers, "charts": [drawn], "said": [*map(str, curve.warnings)], "found": curve.levels.size}
