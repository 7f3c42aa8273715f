"""A few of the kept numbers, on any machine: other processors round otherwise, so here the last digits are free."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.golden.numbers import FEW, few

KEPT = json.loads((Path(__file__).parent / "kept.json").read_text())


@pytest.mark.parametrize("kind", FEW)
def test_numbers_are_those_of_before(kind: str) -> None:
    now = dict(few(kind))
    before = KEPT[kind]
    assert now.keys() == before.keys()
    for name, (value, room) in now.items():
        assert abs(value - before[name]) <= room, (name, value, before[name])
