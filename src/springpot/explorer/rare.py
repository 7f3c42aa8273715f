"""The curve of level against return period that a tab asks for: found by splitting, and shown while it grows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from springpot.explorer.excitation import chart
from springpot.explorer.protocol import Rare
from springpot.explorer.requests import text_of, unit_of_level
from springpot.explorer.sliders import shown_in, titled, written
from springpot.machine.faults import Stopped
from springpot.machine.progress import until_stopped

if TYPE_CHECKING:
    from springpot.problem.system import System
    from springpot.simulation.rare.search import ExceedanceCurve

LEVELS = 13  # of the curve


def growing(
    system: System, asked: Rare, run: Mapping[str, Any], progress: Callable[..., None], stop: Callable[[], bool]
) -> dict[str, Any]:
    """Exceedance of many levels by one run: numbers as words and texts, a chart, and warnings.

    While it goes on, the curve has the levels that paths have exceeded so far: first those that are frequent.

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
    levels = np.linspace(asked.low, asked.high, LEVELS) / shown_in(asked.length, unit_of_level(system, asked.of))[0]
    known, told = dict[str, Any](), 0.0

    def tell(fraction: float) -> None:
        nonlocal told
        told = fraction
        progress(fraction, **known)

    check = until_stopped(tell, stop)

    def grow(curve: ExceedanceCurve) -> None:
        nonlocal known
        # larger repetitions begin anew: until they have come as far, what is known stays
        if np.count_nonzero(curve.probability) >= known.get("found", 1):
            known = _shown(curve, asked, curve.probability > 0.0)
        check(told)

    try:
        curve = exceeded(
            system, {asked.of: levels}, duration=asked.duration, rtol=asked.rtol, **run, progress=check, watch=grow
        )[asked.of]
    except Stopped:
        return known | {"said": [f"Stopped: the curve has {known.get('found', 0)} of {LEVELS} levels."]}
    return _shown(curve, asked, np.ones(LEVELS, bool))


def _shown(curve: ExceedanceCurve, asked: Rare, said: npt.NDArray[np.bool_]) -> dict[str, Any]:
    """A curve as the page shows it, on an axis that has room for all levels, with the numbers of some."""
    from springpot.simulation.rare.search import UNSETTLED

    title, seen = titled(curve.name), curve.probability > 0.0
    factor, unit = shown_in(asked.length, written(curve.unit))
    periods = (curve.return_period, *curve.return_interval)
    own = periods if curve.settles else (curve.probability, curve.low, curve.high)
    values, low, high = (np.where(seen, each, math.nan) for each in own)
    numbers = [
        (f"{title} past {level:.6g} {unit}, within {asked.duration:.4g} s", text_of(words))
        for level, words, is_said in zip(factor * curve.levels, curve.said, said, strict=True)
        if is_said
    ]
    how = {"splitting": "by splitting", "plain": "on plain paths"}[curve.method]
    note = f"{curve.repetitions} repetitions of {curve.paths} paths {how}. The band is the 95 % interval."
    order = np.argsort(curve.levels)  # those below the start are exceeded downwards
    at = factor * curve.levels[order]
    note += "" if curve.settles else f" Return periods are {UNSETTLED}."
    name, axis = ("return period", "s") if curve.settles else ("probability", "")
    line = {"name": name, "values": values[order], "low": low[order], "high": high[order]}
    drawn = chart(f"{title}: level against {name}", (f"level of {title}", unit), (name, axis), at, [line],
                  logarithmic="y", note=note)  # fmt: skip
    found = int(np.count_nonzero(seen))
    return {"numbers": numbers, "charts": [drawn], "said": [*map(str, curve.warnings)], "found": found}
