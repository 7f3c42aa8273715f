"""One compilation serves all systems, and the tables say where everything stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.kernel import tables
from springpot.simulation.kernel.native import KERNELS, Entry
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from tests.simulation.systems import of_many_kinds

FEW = sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)
ROW = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
    sp.Spring(1.0, between=("a", "b")), sp.Springpot(0.5, 0.5, between=("ground", "a")), sp.WhiteNoise(1.0, on="b"),
    sp.Barrier(-0.3, between=("a", "b")),
)  # fmt: skip


@pytest.mark.parametrize("scheme", ["default", "grunwald"])
def test_systems_of_every_kind_have_one_kernel(scheme: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """In single precision here; nothing that a system has is compiled."""
    systems = [sp.Oscillator(barrier=None), sp.Oscillator()]
    if scheme == "default":
        yielding = sp.System(*FEW, sp.ColoredNoise(1.0, 0.5), sp.BoucWen(1.0, 0.5, exponent=2.0))
        systems += [of_many_kinds(*FEW), ROW, yielding]
    KERNELS["float32"].load()
    compiled: list[str] = []
    monkeypatch.setattr(Entry, "compiled", lambda entry, goal: compiled.append(entry.name))
    for system in systems:
        sp.simulate(system, paths=64, duration=2.0, step=0.05, start="rest", scheme=scheme)
    assert compiled == []


def test_the_header_says_where_lists_and_numbers_begin() -> None:
    """Those of a system of two masses, whose row with the wall is the difference of both displacements."""
    own = simulation_of(plan_of(ROW, paths=1, duration=1.0, step=0.05, start="rest")).parts.tables
    whole, number = own.integers, own.numbers
    assert (own.count("points"), own.count("walls"), own.count("noises")) == (2, 1, 1)
    wall = whole[whole[tables.WALL_AT]]
    begin, end = whole[whole[tables.ROW_BEGIN] + wall : whole[tables.ROW_BEGIN] + wall + 2]
    at = whole[whole[tables.ROW_AT] + begin : whole[tables.ROW_AT] + end].tolist()
    shares = number[whole[tables.ROW] + begin : whole[tables.ROW] + end].tolist()
    assert dict(zip(at, shares, strict=True)) == {0: -1.0, 1: 1.0}
    assert number[whole[tables.REDUCED]] == pytest.approx(0.5 * number[whole[tables.MASS]])
    np.testing.assert_array_equal(own.sweep[: number.size], number.astype(own.sweep.dtype))


def test_a_long_list_stands_behind_the_numbers_of_the_sweep() -> None:
    """A record: its impulses, one for each step, where the seventh integer of its source says."""
    record = sp.RecordedExcitation([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    own = simulation_of(
        plan_of(sp.System(*FEW, record), paths=1, duration=2.0, step=0.05, start="rest", window=(0.0, 2.0))
    ).parts.tables
    source = own.integers[own.integers[tables.SOURCE] :][: tables.OF_A_SOURCE]
    long = own.sweep[source[6] : source[6] + source[7]]
    assert source[6] >= own.numbers.size
    assert long.size >= 40
    assert abs(long[:40]).argmax() in (19, 20)
