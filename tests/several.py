"""Systems of several masses that tests of many packages use."""

from __future__ import annotations

from typing import Any

import springpot as sp

__all__ = ["buildings", "chain", "tuned"]


def buildings(*excitations: Any, gap: Any = -0.05) -> sp.System:
    """Two unequal buildings with a wall between them."""
    return sp.System(
        sp.Mass(2e5, at="old"), sp.Mass(4e5, at="new"), sp.Spring(8e6, between=("ground", "old")),
        sp.Spring(6e6, between=("ground", "new")), sp.Dashpot(1e5, between=("ground", "old")),
        sp.Dashpot(1e5, between=("ground", "new")), *excitations, gap=sp.Barrier(gap, 0.6, between=("old", "new")),
    )  # fmt: skip


def tuned(stiffness: Any = 0.0464, coefficient: Any = 0.02, order: Any = 0.5) -> sp.System:
    """A damper with a springpot on a frame without damping of its own."""
    on_the_frame: dict[str, Any] = {"between": ("frame", "damper")}
    return sp.System(
        sp.Mass(1.0, at="frame"), sp.Mass(0.05, at="damper"), sp.Spring(1.0, between=("ground", "frame")),
        sp.WhiteNoise(1.0, on="frame"), tuning=sp.Spring(stiffness, **on_the_frame),
        pot=sp.Springpot(order, coefficient, **on_the_frame),
    )  # fmt: skip


def chain(*excitations: Any) -> sp.System:
    """Four masses, with a spring and a springpot beside it from each to the next."""
    ends = ("ground", "a"), ("a", "b"), ("b", "c"), ("c", "d")
    return sp.System(
        *(sp.Mass(mass, at=point) for point, mass in {"a": 1.0, "b": 1.0, "c": 0.8, "d": 0.6}.items()),
        *(sp.Spring(k, between=pair) for k, pair in zip((6.0, 5.0, 4.0, 3.0), ends, strict=True)),
        *(sp.Springpot(0.5, 0.3, between=pair) for pair in ends), *excitations,
    )  # fmt: skip
