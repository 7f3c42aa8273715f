"""What a tab may say, and what is said of anything else."""

from __future__ import annotations

import json
import math

import pytest

from springpot.explorer.protocol import LONGEST_MESSAGE, Play, Problem, parse

SOUND = {"kind": "problem", "generation": 3, "order": 0.25, "coefficient": 0.5, "restitution": 0.9, "paths": 640}


def test_a_sound_problem_is_taken_as_it_is() -> None:
    found = parse(json.dumps(SOUND))
    assert isinstance(found, Problem)
    assert found.model_dump() == {**Problem().model_dump(), **SOUND}
    oscillator = found.oscillator()
    assert oscillator.springpot.order == 0.25
    assert oscillator.restitution == 0.9
    assert parse('{"kind": "problem", "wall": false}').oscillator().barrier is None  # type: ignore[union-attr]


def test_whole_numbers_are_numbers() -> None:
    found = parse('{"kind": "play", "playing": true, "speed": 3}')
    assert isinstance(found, Play)
    assert found.speed == 3.0


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"order": 1.5}, "order"),
        ({"order": "0.5"}, "order"),
        ({"order": True}, "order"),
        ({"order": None}, "order"),
        ({"order": [0.5]}, "order"),
        ({"coefficient": -1.0}, "coefficient"),
        ({"coefficient": math.nan}, "coefficient"),
        ({"natural_frequency": math.inf}, "natural_frequency"),
        ({"natural_frequency": 0.0}, "natural_frequency"),
        ({"intensity": 0.0}, "intensity"),
        ({"position": 1e9}, "position"),
        ({"restitution": 0.0}, "restitution"),
        ({"paths": 10**9}, "paths"),
        ({"paths": 2.5}, "paths"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed"),
        ({"start": "sideways"}, "start"),
        ({"generation": 2**40}, "generation"),
        ({"rm": "-rf"}, "rm"),
        ({"kind": "shell"}, "message"),
    ],
)
def test_what_is_not_sound_is_refused_with_its_name(change: dict[str, object], name: str) -> None:
    with pytest.raises(ValueError, match=rf"^{name}: [^\n]+\.$"):
        parse(json.dumps({**SOUND, **change}))


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", "7", '"problem"', "[" * 2000, "{}", '{"kind": null}', "\x00", None, b"{}", 3]
)
def test_what_is_no_message_is_refused(text: object) -> None:
    with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
        parse(text)


def test_a_long_message_is_refused_and_not_repeated() -> None:
    with pytest.raises(ValueError, match="longer than"):
        parse(json.dumps({"kind": "x" * LONGEST_MESSAGE}))
    with pytest.raises(ValueError, match=r"^.{1,260}$"):
        parse(json.dumps({**SOUND, "y" * 1500: 1}))
