"""The parts of the kernel in single precision, for the sweep over all lanes.

Within a group of four steps the state changes by little, so its changes are found in single precision and added to a
state in double precision.  What rounding does then is far below the error of any run: the page on numbers says which
parts are advanced so.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.simulation.kernel import Parts
from springpot.simulation.parts import Splitting, Sweep

__all__ = ["single_of", "sweeps_in_single", "with_arrays"]

_f32 = np.float32
_TRIED = 16  # neighbours of a number on either side, by about a unit in the last place
_AXES = (-1, 1, 1), (1, -1, 1), (1, 1, -1)


def sweeps_in_single(scheme: Any, load: Any) -> bool:
    """Whether the sweep can be in single precision: not with the paper's scheme, nor with forces of a user's own."""
    return isinstance(scheme, Splitting) and not _is_of_user(load)


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
        return part.astype(kind)
    return _each(part, lambda inner: with_arrays(inner, kind))


def _rounded(part: Any) -> Any:
    """The same part, and parts of it, with single numbers in place of doubles."""
    return _f32(part) if isinstance(part, float) else _each(part, _rounded)


def _each(part: Any, change: Any) -> Any:
    return part._make(map(change, part)) if hasattr(part, "_make") else part


def _is_of_user(part: Any) -> bool:
    return type(part).__module__ == "__user__" or (hasattr(part, "_make") and any(map(_is_of_user, part)))


def _turn(loss: float, sine: float, back: float, name: str) -> dict[str, np.float32]:
    """The numbers of a rotation in single precision, whose determinant is 1 as nearly as their neighbours allow.

    The energy of an undamped oscillator grows by the determinant in every step.
    """
    losses, sines, backs = (_near(number).reshape(shape) for number, shape in zip((loss, sine, back), _AXES, strict=True))
    lost = losses.astype(float)
    off = abs(lost * (2.0 + lost) + sines.astype(float) * backs)
    i, j, k = np.unravel_index(np.argmin(off), off.shape)
    return {name + "loss": losses[i, 0, 0], name + "sine": sines[0, j, 0], name + "back": backs[0, 0, k]}


def _near(number: float) -> npt.NDArray[np.float32]:
    """Single numbers near one, from a millionth below it to a millionth above."""
    return (number * (1.0 + np.arange(-_TRIED, _TRIED + 1) * 2.0**-24)).astype(_f32)
