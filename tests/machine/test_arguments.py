"""Numbers that a user gives: an array without an axis, as the library's own quantiles are, is its number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.arguments import finite_number, real_array

BOX = sp.System(sp.Mass(1.0), sp.Spring(100.0), sp.Dashpot(1.0), sp.WhiteNoise(0.1, on="ground"))
KINDS = np.array, np.float64, np.float32, np.int64


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_of_numpy_is_a_number(kind: Callable[[int], Any]) -> None:
    found = finite_number(kind(2), "level")
    assert (found, type(found)) == (2.0, float)
    assert real_array([kind(2), 3], "levels").tolist() == [2.0, 3.0]


@pytest.mark.parametrize("wrong", [np.array([2.0]), np.array(True), np.array("2"), np.array(2.0 + 1j), np.array(None)])
def test_another_array_is_none(wrong: Any) -> None:
    with pytest.raises(TypeError, match=r"^level must be a real number, not "):
        finite_number(wrong, "level")


@pytest.mark.parametrize("kind", [np.array, np.float64, np.float32])
def test_a_level_may_be_one_alone_and_in_a_list(kind: Callable[[float], Any]) -> None:
    level = kind(0.06)
    for given in (level, [level]):
        curve = sp.exceedance(BOX, {"distance": given}, duration=0.5, rtol=0.5, max_time=20.0)["distance"]
        assert np.ravel(curve.levels).tolist() == [float(level)]
        run = sp.simulate(BOX, paths=8, duration=2.0, first_passage={"x": given})
        passages = run.first_passages["x"]
        assert (passages[0] if given is not level else passages).level == float(level)
    left = sp.simulate(BOX, paths=8, duration=2.0, first_passage={"x": (-level, level)}, profile=kind(4.0))
    assert left.first_passages["x"].level == float(level)
    assert sp.SpectralExcitation.from_psd((10, 20), level, "g2/Hz").psd[0] == pytest.approx(5.770, rel=1e-3)
    assert sp.Spring(kind(4.0)) == sp.Spring(4.0)
