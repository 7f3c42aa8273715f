"""What a tab may say, and what is said of anything else."""

from __future__ import annotations

import json
import math

import pytest

from springpot.explorer.protocol import LONGEST_MESSAGE, Play, Problem, parse
from springpot.explorer.question import Opened, question_of

NUMBERS = {"springpot-order": 0.25, "springpot-coefficient": 0.5, "barrier-restitution": 0.9}
SOUND = {"kind": "problem", "generation": 3, "numbers": NUMBERS, "paths": 640}


def test_a_sound_problem_is_taken_as_it_is() -> None:
    found = parse(json.dumps(SOUND))
    assert isinstance(found, Problem)
    assert found.model_dump() == {**Problem().model_dump(), **SOUND}
    (paper,) = question_of(found, Opened()).papers
    assert paper.springpot.order == 0.25
    assert paper.restitution == 0.9
    (freed,) = question_of(Problem(without=["barrier"]), Opened()).papers
    assert freed.barrier is None


def test_whole_numbers_are_numbers() -> None:
    found = parse('{"kind": "play", "playing": true, "speed": 3}')
    assert isinstance(found, Play)
    assert found.speed == 3.0


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"numbers": {"springpot-order": "0.5"}}, "springpot-order"),
        ({"numbers": {"springpot-order": True}}, "springpot-order"),
        ({"numbers": {"springpot-order": None}}, "springpot-order"),
        ({"numbers": {"springpot-order": [0.5]}}, "springpot-order"),
        ({"numbers": {"springpot-coefficient": math.nan}}, "springpot-coefficient"),
        ({"numbers": {"spring-stiffness": math.inf}}, "spring-stiffness"),
        ({"numbers": [1.0]}, "numbers"),
        ({"numbers": {f"n{n}": 1.0 for n in range(401)}}, "numbers"),
        ({"without": "barrier"}, "without"),
        ({"without": [1]}, "0"),
        ({"without": ["x" * 201]}, "0"),
        ({"order": 0.5}, "order"),
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
    ("number", "value"),
    [
        ("springpot-order", 1.5), ("springpot-coefficient", -1.0), ("white_noise-intensity", -1.0),
        ("barrier-position", 1e300), ("barrier-restitution", -0.1), ("barrier-order", 0.5),
    ],
)  # fmt: skip
def test_a_number_that_the_system_does_not_take_is_refused_with_its_name(number: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"^({number.replace('-', '.')} must|numbers: this system has no number)"):
        question_of(Problem(numbers={number: value}), Opened())


def test_a_problem_without_what_holds_the_mass_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
        question_of(Problem(without=["spring", "springpot", "barrier"]), Opened()).frequency  # noqa: B018


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
