"""The problem: its parts, its dimensionless numbers, and what it refuses (more of that in test_bad_input)."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from springpot import Barrier, Dimensionless, Oscillator, Spring, Springpot, System, WhiteNoise, read_system

positive = st.floats(min_value=1e-3, max_value=1e3)


def test_the_default_problem_is_the_papers() -> None:
    wall = Barrier(position=0.0, restitution=1.0, free_side="above")
    parts = Spring(1.0), Springpot(order=0.5, coefficient=1.0), wall, WhiteNoise(intensity=1.0)
    assert Oscillator() == System(*parts)
    assert Dimensionless.of(Oscillator()) == Dimensionless() == Dimensionless(1.0, *parts[1:])


def test_whole_numbers_become_floats() -> None:
    oscillator = Oscillator(natural_frequency=2, springpot=Springpot(order=1, coefficient=3))
    assert isinstance(oscillator.natural_frequency, float)
    assert isinstance(oscillator.of(Springpot)[0].order, float)


def test_a_problem_cannot_be_changed_and_can_be_a_key() -> None:
    oscillator = Oscillator()
    with pytest.raises(dataclasses.FrozenInstanceError):
        oscillator.parts = ()  # type: ignore[misc]
    assert {oscillator: "found"}[Oscillator()] == "found"


@given(frequency=positive, intensity=positive, order=st.floats(0.0, 1.0), coefficient=positive, factor=positive)
def test_dimensionless_numbers_do_not_feel_the_unit_of_time(
    frequency: float, intensity: float, order: float, coefficient: float, factor: float
) -> None:
    """Measured in a unit of time 1/factor as long, rates grow by the factor; C has s^(alpha-2), q has s^-3."""
    here = Dimensionless(
        frequency, Springpot(order, coefficient), Barrier(0.7, free_side="above"), WhiteNoise(intensity)
    )
    there = Dimensionless(
        frequency * factor,
        Springpot(order, coefficient * factor ** (2.0 - order)),
        Barrier(0.7, free_side="above"),
        WhiteNoise(intensity * factor**3),
    )
    assert there.dimensionless_coefficient == pytest.approx(here.dimensionless_coefficient, rel=1e-9)
    assert there.dimensionless_position == pytest.approx(here.dimensionless_position, rel=1e-9)
    assert there.length_scale == pytest.approx(here.length_scale, rel=1e-9)
    assert there.speed_scale == pytest.approx(here.speed_scale * factor, rel=1e-9)
    assert there.time_scale == pytest.approx(here.time_scale / factor, rel=1e-9)


@given(intensity=positive, position=st.floats(-10.0, 10.0), factor=positive)
def test_dimensionless_position_does_not_feel_the_unit_of_length(
    intensity: float, position: float, factor: float
) -> None:
    here = Dimensionless(barrier=Barrier(position, free_side="above"), excitation=WhiteNoise(intensity))
    there = Dimensionless(
        barrier=Barrier(position * factor, free_side="above"), excitation=WhiteNoise(intensity * factor**2)
    )
    assert there.dimensionless_position == pytest.approx(here.dimensionless_position, rel=1e-9)


def test_known_values() -> None:
    oscillator = Dimensionless(2.0, Springpot(0.5, 3.0), Barrier(position=-1.0, restitution=0.9), WhiteNoise(4.0))
    assert oscillator.dimensionless_coefficient == pytest.approx(3.0 * 2.0**-1.5)
    assert oscillator.length_scale == pytest.approx(math.sqrt(4.0 / 8.0))
    assert oscillator.speed_scale == pytest.approx(math.sqrt(2.0))
    assert oscillator.dimensionless_position == pytest.approx(-math.sqrt(2.0))
    assert oscillator.restitution == 0.9


def test_the_mirror_image_has_the_same_dimensionless_position() -> None:
    above = Dimensionless(barrier=Barrier(position=0.3, free_side="above"))
    below = Dimensionless(barrier=Barrier(position=-0.3, free_side="below"))
    assert above.dimensionless_position == below.dimensionless_position == pytest.approx(0.3)


def test_without_a_wall_there_is_no_wall_to_describe() -> None:
    free = Dimensionless(barrier=None)
    assert math.isnan(free.restitution)
    assert math.isnan(free.dimensionless_position)


def test_without_noise_there_is_no_length_to_compare_with() -> None:
    silent = WhiteNoise(intensity=0.0)
    assert Dimensionless(excitation=silent).length_scale == 0.0
    assert Dimensionless(excitation=silent).dimensionless_position == 0.0
    assert Dimensionless(barrier=Barrier(0.5, free_side="above"), excitation=silent).dimensionless_position == math.inf
    assert Dimensionless(barrier=Barrier(-0.5), excitation=silent).dimensionless_position == -math.inf


def test_numbers_and_dicts_make_the_same_oscillator() -> None:
    for asked in (
        Oscillator(),
        Oscillator(2.0, Springpot(0.3, 0.5), Barrier(-0.5, 0.8, "below")),
        Oscillator(barrier=None),
    ):
        assert read_system(json.loads(json.dumps(asked.to_dict()))) == asked
        assert Oscillator.from_numbers(**Dimensionless.of(asked).numbers) == asked


@pytest.mark.parametrize(
    ("name", "change", "sentence"),
    [
        ("springpot", {"kind": "springpot", "order": 0.5}, r"parts\[1\] \(springpot\) needs coefficient."),
        ("barrier", 3, r"parts\[2\] must be a table with a kind, not 3."),
        ("white_noise", {"kind": "white_noise", "intensity": 1.0, "mass": 1.0}, "'mass' is not a key of"),
        ("springpot", {"kind": "springpot", "order": 2.0, "coefficient": 1.0}, r"order must be in \[0, 1\], not 2."),
    ],
)
def test_a_dict_that_is_no_oscillator(name: str, change: object, sentence: str) -> None:
    content = Oscillator().to_dict()
    content["parts"] = [change if part["name"] == name else part for part in content["parts"]]
    with pytest.raises(ValueError, match=sentence):
        read_system(content)


def test_a_wall_that_is_not_there_has_no_numbers() -> None:
    with pytest.raises(ValueError, match="barrier = false cannot be combined with"):
        Oscillator.from_numbers(barrier=False, restitution=0.5)
