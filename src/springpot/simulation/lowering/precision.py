"""The parts of the kernel in single precision, for the sweep over all lanes.

Within a group of four steps the state changes by little, so its changes are found in single precision and added to a
state in double precision.  What rounding does then is far below the error of any run; docs/memory.md has the numbers.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.simulation.kernel.block import Parts
from springpot.simulation.kernel.forces import Parametric, Sum, White
from springpot.simulation.kernel.questions import Splitting, Sweep
from springpot.simulation.kernel.sources import (
    Filtered,
    Joined,
    Modulated,
    ModulatedParametric,
    ModulatedWhite,
    Poisson,
)

_OURS = Splitting.__module__.rpartition(".")[0] + "."  # the kernel's own parts, which are written for it
_f32 = np.float32
_TRIED = 16  # neighbours of a number on either side, by about a unit in the last place
_STEPS = 1e6
_AXES = (-1, 1, 1), (1, -1, 1), (1, 1, -1)


def sweeps_in_single(exact: Parts) -> bool:
    """Whether the sweep is in single precision.

    Not with the paper's scheme, nor with parts that are not of this package, which may need more; and not without
    noise: one path is the answer then, and its last digits may be wanted.
    """
    return isinstance(exact.scheme, Splitting) and all(map(_is_ours, exact)) and is_random(exact.load)


def single_of(exact: Parts) -> Sweep:
    """The parts in single precision; arrays of the load have it already."""
    scheme = exact.scheme
    turned = {
        **_turn(scheme.half_loss, scheme.half_sine, scheme.half_back, "half_"),
        **_turn(scheme.loss, scheme.sine, scheme.back, ""),
    }
    return Sweep(_rounded(scheme)._replace(**turned), _rounded(exact.wall), _rounded(exact.load), _f32(0.0))


def with_arrays(part: Any, kind: type) -> Any:
    """The same part, and parts of it, with arrays of numbers of another precision."""
    if isinstance(part, np.ndarray):
        return part.astype(kind) if part.dtype.kind == "f" else part
    return _each(part, lambda inner: with_arrays(inner, kind))


def _rounded(part: Any) -> Any:
    """The same part, and parts of it, with single numbers in place of doubles."""
    return _f32(part) if isinstance(part, float) else _each(part, _rounded)


def _each(part: Any, change: Any) -> Any:
    return part._make(map(change, part)) if hasattr(part, "_make") else part


def _is_ours(part: Any) -> bool:
    return not hasattr(part, "_make") or (type(part).__module__.startswith(_OURS) and all(map(_is_ours, part)))


def is_random(load: Any) -> bool:
    """Whether a load is drawn in each step."""
    match load:
        case Sum():
            return is_random(load.first) or is_random(load.second)
        case White():
            return load.strength > 0.0
        case _:
            kinds = Filtered, Joined, Modulated, ModulatedParametric, ModulatedWhite, Parametric, Poisson
            return isinstance(load, kinds)


@lru_cache(maxsize=64)  # the levels of a run ask for the same few steps again and again
def _turn(loss: float, sine: float, back: float, name: str) -> dict[str, np.float32]:
    """The numbers of a rotation in single precision: those neighbours that change an energy least in many steps.

    The energy grows by the determinant in every step, and the ratio of the two sines shares it among x and v.
    """
    losses, sines, backs = (
        _near(number).reshape(shape) for number, shape in zip((loss, sine, back), _AXES, strict=True)
    )
    lost, one, two = losses.astype(float), sines.astype(float), backs.astype(float)
    change = _STEPS * abs(lost * (2.0 + lost) + one * two) + abs(one / sine - two / back)
    i, j, k = np.unravel_index(np.argmin(change), change.shape)
    return {name + "loss": losses[i, 0, 0], name + "sine": sines[0, j, 0], name + "back": backs[0, 0, k]}


def _near(number: float) -> npt.NDArray[np.float32]:
    """Single numbers near one, from a millionth below it to a millionth above."""
    return (number * (1.0 + np.arange(-_TRIED, _TRIED + 1) * 2.0**-24)).astype(_f32)
