"""Straight flights with impacts in lanes: masses that strike each other and walls, one impact after another."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.kernel.lanes import LANES
from tests.simulation.kernel.flights import FAINT, in_lanes

Floats = np.ndarray
ROW = 1.0, 0.5, 3.0  # kg
ENDS = 0.0, 1.0  # m


def _row_of_masses(masses: tuple[float, ...], restitution: float) -> sp.System:
    """Masses on a line between two walls, each of which stops at the next; hardly anything else acts."""
    names = "abcd"[: len(masses)]
    parts: list[Any] = [sp.Mass(mass, at=name) for name, mass in zip(names, masses, strict=True)]
    parts += [sp.Barrier(0.0, restitution, between=pair) for pair in pairwise(names)]
    parts += [sp.Barrier(ENDS[0], restitution, between=("ground", names[0]))]
    parts += [sp.Barrier(ENDS[1], restitution, "below", between=("ground", names[-1]))]
    parts += [sp.WhiteNoise(FAINT, on=name) for name in names]
    parts += [sp.Spring(FAINT, between=("ground", name)) for name in names]
    return sp.System(*parts)


def _starts(count: int) -> Floats:
    rng = np.random.default_rng(5)
    return np.hstack([np.sort(rng.uniform(*ENDS, (LANES, count)), axis=1), rng.normal(size=(LANES, count))])


def _one_after_another(masses: tuple[float, ...], restitution: float, start: Floats, times: Floats) -> Floats:
    """Displacements of the masses at some times."""
    m = np.array([math.inf, *masses, math.inf])
    x, v = (
        np.concatenate([[a], each, [b]]) for (a, b), each in zip((ENDS, (0.0, 0.0)), np.split(start, 2), strict=True)
    )
    seen, now = [], 0.0
    for time in times:
        while True:
            closing = v[:-1] - v[1:]
            until = np.where(closing > 0.0, np.maximum(np.diff(x), 0.0) / np.maximum(closing, 1e-300), math.inf)
            k = int(np.argmin(until))
            if now + until[k] >= time:
                break
            now, x = now + until[k], x + until[k] * v
            reduced = 1.0 / (1.0 / m[k] + 1.0 / m[k + 1])
            impulse = (1.0 + restitution) * closing[k] * reduced
            v[k], v[k + 1] = v[k] - impulse / m[k], v[k + 1] + impulse / m[k + 1]
        now, x = time, x + (time - now) * v
        seen.append(x[1:-1])
    return np.array(seen)


@pytest.mark.parametrize(("masses", "restitution"), [(ROW[:2], 1.0), (ROW, 0.9), (ROW[:1], 0.7)])
@pytest.mark.parametrize("step", [0.02, 0.4])
def test_masses_in_a_row_strike_one_after_another(masses: tuple[float, ...], restitution: float, step: float) -> None:
    """Two masses that strike each other and both walls, up to a dozen times within a long step."""
    steps, starts = round(2.0 / step), _starts(len(masses))
    seen, _ = in_lanes(_row_of_masses(masses, restitution), starts, step, steps)
    for path in range(LANES):
        by_hand = _one_after_another(masses, restitution, starts[path], step * np.arange(1.0, steps + 1.0))
        np.testing.assert_allclose(seen[path, 1:, : len(masses), 0], by_hand, atol=1e-9)
