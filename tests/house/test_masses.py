"""One mass is the case of one row: the code does not ask for the number of masses in more places than it does."""

from __future__ import annotations

import pytest

from tests.house.masses import asked, asked_in

MOST = {"simulation": 3, "elsewhere": 1}
"""Lines that ask.  Nobody may add one; who removes some lowers the number."""


@pytest.mark.parametrize("where", MOST)
def test_nothing_more_asks_how_many_masses_there_are(where: str) -> None:
    there = [each for each in asked() if (each.package == "simulation") == (where == "simulation")]
    assert len(there) <= MOST[where], "\n".join(f"{each.file}:{each.line}  {each.text}" for each in there)


def test_questions_are_found_however_they_are_written() -> None:
    lines = (
        "if len(points := motion.system.points) > 1: pass",
        "single = 1 == len(masses)",
        "found = one if isinstance(motion, MotionOfSeveral) else other",
        "from springpot.simulation.lowering.several import parts",
        "def check(parts: Parts | PartsOfSeveral) -> None: ...",
        "match len(system.points):\n    case 1: pass",
        "answer = not (len(self.points) - 0) or len(self.points) and True",
    )
    for line in lines:
        assert asked_in(line), line
    for line in ("size = len(points)", "x = 'several masses'  # several", "def f():\n    '''Of several masses.'''"):
        assert asked_in(line) == {}, line
