"""The kind of a problem is asked at the doors only."""

from __future__ import annotations

from tests.house.types import DOORS, WALKS, questions


def test_nothing_asks_for_the_kind_of_a_problem_after_the_doors() -> None:
    assert [f"{each.file}:{each.line}" for each in questions() if each.at == "after"] == []


def test_each_door_is_still_one() -> None:
    assert {each.file for each in questions()} == {*DOORS, *WALKS}
