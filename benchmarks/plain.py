"""The plain kernel: the simplest fast one that one would write in Numba for the oscillator with a wall at 0."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from springpot import Dimensionless, System
from springpot.memory import direct, exponential_sum
from springpot.simulation.kernel.lanes import FAST, GROUP, INLINE, LANES, f32, f64, stack_array, u32
from springpot.simulation.kernel.numba_passes import OptimizedOnce
from springpot.simulation.kernel.random import draw, lane_numbers, number_lanes

__all__ = ["COMPILED", "MODES", "STEP", "Plain", "plain_of"]

MODES = 32  # the most that it holds
STEP = 1e-3  # the paper's
COMPILED: dict[str, Any] = {"nogil": True, "pipeline_class": OptimizedOnce, **FAST}  # as springpot's kernel

_state = stack_array(LANES)
_four = stack_array(GROUP * LANES)
_modes = stack_array(MODES * LANES)


@njit(**INLINE)
def _plain_memory(z, d, h, modes, decay, weights):
    """One step of every mode, z <- decay z + d, and what they exert: four modes a pass."""
    for lane in range(LANES):
        h[lane] = d[lane] * f32(0)
    for k in range(0, modes, 4):
        a0, a1, a2, a3 = decay[k], decay[k + 1], decay[k + 2], decay[k + 3]
        w0, w1, w2, w3 = weights[k], weights[k + 1], weights[k + 2], weights[k + 3]
        i0, i1, i2, i3 = k * LANES, (k + 1) * LANES, (k + 2) * LANES, (k + 3) * LANES
        for lane in range(LANES):
            y0 = a0 * z[i0 + lane] + d[lane]
            y1 = a1 * z[i1 + lane] + d[lane]
            y2 = a2 * z[i2 + lane] + d[lane]
            y3 = a3 * z[i3 + lane] + d[lane]
            z[i0 + lane], z[i1 + lane], z[i2 + lane], z[i3 + lane] = y0, y1, y2, y3
            h[lane] += (w0 * y0 + w1 * y1) + (w2 * y2 + w3 * y3)


@njit(**COMPILED)
def plain_block(decay, weights, newest, steps, burn, step, stiffness, noise, k0, k1, out):
    """Lanes of paths, modes in a flat stack array, one step at a time; a path behind the wall is mirrored.

    ``out`` gets the means of x^2, v^2 and x, and the impacts per step, of each lane.
    """
    zero = newest * f32(0)
    modes = decay.size
    z, d, h, g = _modes(zero), _state(zero), _state(zero), _four(f32(0))
    x, v, xx, vv, xs, impacts = _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0), _state(0.0)
    who = lane_numbers(u32(0))
    number_lanes(0, who)
    for i in range(modes * LANES):
        z[i] = zero
    for lane in range(LANES):
        x[lane] = v[lane] = xx[lane] = vv[lane] = xs[lane] = impacts[lane] = 0.0
        d[lane] = h[lane] = zero
    for n in range(0, steps, GROUP):
        draw(n // GROUP, who, 0, 0, k0, k1, g)
        keep = 1.0 if n >= burn else 0.0
        for j in range(GROUP):
            for lane in range(LANES):
                past = f64(h[lane] + newest * d[lane])
                v_next = v[lane] - step * (stiffness * x[lane] + past) + noise * f64(g[j * LANES + lane])
                x_next = x[lane] + step * v_next
                behind = x_next < 0.0
                x_next = -x_next if behind else x_next
                v_next = -v_next if behind else v_next
                d[lane] = x_next - x[lane]
                x[lane], v[lane] = x_next, v_next
                xx[lane] += keep * x_next * x_next
                vv[lane] += keep * v_next * v_next
                xs[lane] += keep * x_next
                impacts[lane] += keep if behind else 0.0
            _plain_memory(z, d, h, modes, decay, weights)
    for lane in range(LANES):
        out[lane, 0], out[lane, 1] = xx[lane] / (steps - burn), vv[lane] / (steps - burn)
        out[lane, 2], out[lane, 3] = xs[lane] / (steps - burn), impacts[lane] / (steps - burn)


class Plain(NamedTuple):
    """What `plain_block` needs of an oscillator with a wall at 0."""

    decay: npt.NDArray[np.floating]
    weights: npt.NDArray[np.floating]
    newest: np.floating
    step: float
    stiffness: float
    noise: float

    def run(self, steps: int, burn: int, key: tuple[np.uint32, np.uint32]) -> npt.NDArray[np.float64]:
        """Means of x^2, v^2 and x, and the impacts per step, of LANES paths, from step ``burn`` on."""
        out = np.empty((LANES, 4))
        plain_block(
            self.decay, self.weights, self.newest, steps, burn, self.step, self.stiffness, self.noise, *key, out
        )
        return out


def plain_of(
    oscillator: System, steps: int, *, step: float = STEP, modes: int | None = None, precision: str = "float32"
) -> Plain:
    """The plain kernel of an oscillator, with as many modes as it needs for so many steps, or with more."""
    paper = Dimensionless.of(oscillator)
    order = paper.springpot.order
    scale = paper.springpot.coefficient * step**-order
    rates = weights = np.empty(0)  # a dashpot has no memory
    if order < 1.0:
        past = exponential_sum("grunwald", order, steps + 1, 1e-6)
        rates, weights = past.rates, scale * past.weights * np.exp(-past.rates)
    lacking = -rates.size % 4 if modes is None else modes - rates.size  # it takes four at once
    return Plain(
        np.pad(np.exp(-rates), (0, lacking)).astype(precision), np.pad(weights, (0, lacking)).astype(precision),
        np.dtype(precision).type(scale * direct("grunwald", order, 1)[0]), step, paper.natural_frequency**2,
        math.sqrt(paper.excitation.intensity * step),
    )  # fmt: skip
