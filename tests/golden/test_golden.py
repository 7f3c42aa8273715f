"""A few of the kept numbers, on any machine: other processors round otherwise, so here the last digits are free.

Also what the whole net covers, and how it compares.
"""

from __future__ import annotations

import json
from collections import Counter
from itertools import combinations
from pathlib import Path

import pytest

from tests.golden.comparison import compared, renamed
from tests.golden.numbers import FEW, few
from tests.golden.systems import CHOSEN, PARTS, pairs_in, system

KEPT = json.loads((Path(__file__).parent / "kept.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("kind", FEW)
def test_numbers_are_those_of_before(kind: str) -> None:
    now = dict(few(kind))
    before = KEPT[kind]
    assert now.keys() == before.keys()
    for name, (value, room) in now.items():
        assert abs(value - before[name]) <= room, (name, value, before[name])


def test_every_kind_of_part_and_every_pair_is_in_the_net() -> None:
    """But for pairs that no system may have: thermal noise with what has no matching noise, two walls on one side."""
    names = [system(number)[0] for number in range(len(CHOSEN))]
    counts = Counter(name for kinds in names for name in kinds)
    assert min(counts[name] for name in PARTS) >= 3
    unmatched = ("contact_lossy", "force", "friction", "polynomial_dashpot", "van_der_pol")
    apart = {pair for name in unmatched for pair in pairs_in((name, "thermal_noise"))}
    for side in (("wall", "wall_elastic", "wall_power"), ("wall_below", "wall_law")):
        apart |= pairs_in(side)
    assert set(combinations(sorted(PARTS), 2)) - set().union(*map(pairs_in, names)) <= apart


def test_each_number_is_the_same_renamed_excepted_or_wrong() -> None:
    before = {"runs/a": {"runs/a/x_mean": "0x1.0p+0", "runs/a/springpot_power": "0x1.0p+1", "runs/a/best": "closure",
                         "runs/a/none": "", "runs/a/rate": "0x1.0p+0", "runs/a/lost": "0x1.0p+0",
                         "runs/a/x": "0x1.0p+0"}}  # fmt: skip
    now = {"runs/a": {"runs/a/x_mean": "0x1.0p+0", "runs/a/damping_power": "0x1.0p+1", "runs/a/best": "gaussian",
                      "runs/a/none": "", "runs/a/rate": "0x1.8p+0", "runs/a/x": "0x1.1p+0",
                      "runs/a/more": "0x1.0p+0"}}  # fmt: skip
    names = {"springpot_power": "damping_power", "closure": "gaussian"}
    found = compared(before, now, names, {"/rate$": "half as much again", "/nothing": "never"})
    assert found.counts == {"same": 2, "renamed": 2, "excepted": 1, "differ": 1, "missing": 1, "new": 1}
    assert found.wrong.keys() == {"runs/a/x", "runs/a/lost", "runs/a/more"}
    assert (found.excepted["/rate$"], found.unused) == ([0.5], ["/nothing"])
    assert renamed("runs/springpot_power_se/x", names) == "runs/springpot_power_se/x"
    assert renamed("a/b/c", {"(a/.*)/c": r"\1/d"}) == "a/b/d"
