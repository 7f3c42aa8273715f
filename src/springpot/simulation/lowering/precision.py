"""The numbers of a rotation in single precision."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

_f32 = np.float32
_TRIED = 16  # neighbours of a number on either side, by about a unit in the last place
_STEPS = 1e6
_AXES = (-1, 1, 1), (1, -1, 1), (1, 1, -1)


@lru_cache(maxsize=64)  # the levels of a run ask for the same few steps again and again
def turned_in_single(loss: float, sine: float, back: float) -> tuple[float, float, float]:
    """The numbers of a rotation in single precision: those neighbours that change an energy least in many steps.

    The energy grows by the determinant in every step, and the ratio of the two sines shares it among x and v.
    """
    losses, sines, backs = (
        _near(number).reshape(shape) for number, shape in zip((loss, sine, back), _AXES, strict=True)
    )
    lost, one, two = losses.astype(float), sines.astype(float), backs.astype(float)
    change = _STEPS * abs(lost * (2.0 + lost) + one * two) + abs(one / sine - two / back)
    i, j, k = np.unravel_index(np.argmin(change), change.shape)
    return float(losses[i, 0, 0]), float(sines[0, j, 0]), float(backs[0, 0, k])


def _near(number: float) -> npt.NDArray[np.float32]:
    """Single numbers near one, from a millionth below it to a millionth above."""
    return (number * (1.0 + np.arange(-_TRIED, _TRIED + 1) * 2.0**-24)).astype(_f32)
