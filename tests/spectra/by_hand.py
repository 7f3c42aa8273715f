"""Programs of the tests' own: exact responses of one mass, from one event to the next, in plain Python."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Piece:
    """x'' + 2 z w x' + w^2 x = a + b s from a state at s = 0, in closed form, for a ratio z below 1."""

    def __init__(self, w: float, z: float, a: float, b: float, x: float, v: float) -> None:
        self.w, self.z, self.turn = w, z, w * math.sqrt(1.0 - z * z)
        self.slope = b / w**2
        self.place = a / w**2 - 2.0 * z * b / w**3
        self.cosine = x - self.place
        self.sine = (v - self.slope + z * w * self.cosine) / self.turn

    def at(self, s: float) -> tuple[float, float]:
        """x and v."""
        fade = math.exp(-self.z * self.w * s)
        c, d = math.cos(self.turn * s), math.sin(self.turn * s)
        away = self.cosine * c + self.sine * d
        rate = self.turn * (self.sine * c - self.cosine * d) - self.z * self.w * away
        return self.place + self.slope * s + fade * away, self.slope + fade * rate


def root(function, low: float, high: float) -> float:  # type: ignore[no-untyped-def]
    """By halving, where the sign changes."""
    first = function(low)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (function(middle) < 0.0) == (first < 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def motion(
    time: Floats,
    u: Floats,
    w: float,
    z: float,
    tail: float,
    wall: float = -math.inf,
    restitution: float = 1.0,
    dense: int = 60,
) -> Iterator[tuple[float, float, float, float]]:
    """t, x, v and u at many times, at all turns and impacts (before and after); u is 0 after its last point.

    Turns are found where they are; the largest velocity and acceleration among the times, ``dense`` in a period.
    """
    x = v = 0.0
    ends = [*zip(time[:-1], time[1:], u[:-1], u[1:], strict=True), (time[-1], time[-1] + tail, 0.0, 0.0)]
    for begin, end, first, last in ends:
        now, slope = float(begin), (last - first) / (end - begin)
        while now < end:
            short = min(2.0 * math.pi / w / dense, 12.0 * (end - begin) / dense, end - now)
            begun = first + slope * (now - begin)
            piece = Piece(w, z, begun, slope, x, v)
            turned = piece.at(short)[1] * v < 0.0
            lowest = root(lambda s, piece=piece: piece.at(s)[1], 0.0, short) if turned else short
            struck = next((s for s in (lowest, short) if piece.at(s)[0] < wall), None)
            if struck is not None:
                struck = root(lambda s, piece=piece: piece.at(s)[0] - wall, 0.0, struck)
                _, fast = piece.at(struck)
                now += struck
                yield now, wall, fast, begun + slope * struck
                x, v = wall, -restitution * fast
                yield now, x, v, begun + slope * struck
                continue
            if turned:
                yield now + lowest, *piece.at(lowest), begun + slope * lowest
            x, v = piece.at(short)
            now += short
            yield now, x, v, begun + slope * short


def largest(
    time: Floats,
    u: Floats,
    w: float,
    z: float,
    tail: float,
    wall: float = -math.inf,
    restitution: float = 1.0,
    dense: int = 60,
) -> dict[str, float]:
    """The largest displacement, velocity, absolute acceleration under the ground's -u, and impact speed."""
    _, x, v, _ = np.array([*motion(time, u, w, z, tail, wall, restitution, dense)]).T
    impacts = np.abs(v[(x == wall) & (v < 0.0)])
    return {
        "displacement": float(np.abs(x).max()), "velocity": float(np.abs(v).max()),
        "acceleration": float(np.abs(w**2 * x + 2.0 * z * w * v).max()),
        "impact_speed": float(impacts.max(initial=0.0)),
    }  # fmt: skip


def at2(place: Path) -> tuple[Floats, Floats]:
    """Times and accelerations of the ground in m/s^2 of a file in the layout of PEER's .AT2."""
    lines = place.read_text(encoding="ascii").splitlines()
    count, step = (float(each.split("=")[1].split()[0].rstrip(",")) for each in lines[3].split(",", 1))
    values = np.array(" ".join(lines[4:]).split(), float)
    assert values.size == count
    return np.arange(values.size) * step, 9.80665 * values
