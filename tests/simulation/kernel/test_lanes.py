"""A path's bits are its own: the lanes beside it may do whatever they like."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.simulation.kernel.lanes import LANES
from tests.simulation.kernel.flights import in_lanes

OWN = 7  # the lane that is looked at
SPRUNG = sp.Spring(1.0), sp.Springpot(0.5, 0.5), sp.WhiteNoise(1.0)


def _row(names: str, *more: Any) -> sp.System:
    """Masses in a row on springs and springpots, each driven, with walls and more at the first two."""
    pairs = [("ground", names[0]), *pairwise(names)]
    return sp.System(
        *(sp.Mass(1.0 + 0.3 * n, at=name) for n, name in enumerate(names)),
        *(sp.Spring(1.0, between=pair) for pair in pairs),
        *(sp.Springpot(0.5, 0.3, between=pair) for pair in pairs),
        *(sp.WhiteNoise(1.0, on=name) for name in names),
        *more,
    )


def _pile() -> sp.System:
    """Two masses that lie on each other and on the ground, shaken smoothly."""
    return sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Barrier(0.0, 0.5, between=("ground", "a")),
        sp.Barrier(0.0, 0.5, between=("a", "b")), sp.Constant(-5.0, on="a"), sp.Constant(-2.5, on="b"),
        sp.ColoredNoise(20.0, 0.2, on="a"), sp.Spring(0.1, between=("ground", "b")),
    )  # fmt: skip


SYSTEMS = {
    "a wall, on a circle": sp.System(*SPRUNG, sp.Barrier(-0.3, 0.7)),
    "two walls, on a circle": sp.System(*SPRUNG, sp.Barrier(-0.2, 0.7), sp.Barrier(0.3, free_side="below")),
    "a wall, straight": sp.System(*SPRUNG, sp.PoissonImpulses(2.0, 0.1), sp.Barrier(-0.3, 0.7)),
    "a contact": sp.System(*SPRUNG, sp.Contact(-0.2, 400.0, exponent=1.5, dissipation=0.2)),
    "a contact before a wall": sp.System(*SPRUNG, sp.Contact(-0.2, 60.0), sp.Barrier(-0.3, 0.8)),
    "a wall and a contact of two masses": _row(
        "ab", sp.Barrier(-0.5, 0.8, between=("ground", "a")), sp.Contact(-0.2, 200.0, between=("a", "b"))
    ),
    "four masses": _row(
        "abcd", sp.Barrier(-0.4, 0.8, between=("ground", "a")), sp.Barrier(-0.3, 0.9, between=("a", "b"))
    ),
    "masses that lie on each other": _pile(),
}  # fmt: skip


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8], ids=["single", "double"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_bits_of_a_path_do_not_depend_on_the_lanes_beside_it(name: str, tolerance: float) -> None:
    """Among neighbours from other starts, which strike at other times, as among those that began as it did."""
    system, rng = SYSTEMS[name], np.random.default_rng(2)
    many = len(system.coordinates.names)
    starts = np.hstack([rng.uniform(0.0, 0.1, (LANES, many)).cumsum(axis=1), 2.0 * rng.normal(size=(LANES, many))])
    given: Any = {"noisy": True, "memory_tolerance": tolerance}
    among, sums = in_lanes(system, starts, 0.02, 200, **given)
    alike, others = in_lanes(system, np.tile(starts[OWN], (LANES, 1)), 0.02, 200, **given)
    np.testing.assert_array_equal(among[OWN], alike[OWN])
    for column, each in sums.items():
        np.testing.assert_array_equal(each[OWN], others[column][OWN], err_msg=column)
    assert not np.array_equal(among[OWN + 1], alike[OWN + 1])
    assert sum(float(each[OWN]) for (quantity, _), each in sums.items() if quantity == "impacts") > 0.0
