"""The atlas: exact answers, scales, mirror images, its range, and fresh Monte Carlo."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest

import springpot as sp
from springpot.evidence.atlases.lookup import ATLAS_FILE, crowding, weights
from springpot.theory import NotCoveredError
from springpot.theory.result import MOMENTS

SAMPLE = 200  # random oscillators of the long test


def oscillator(order: float, c: float, wall: float = 0.0, restitution: float = 1.0) -> sp.System:
    return sp.Oscillator(springpot=sp.Springpot(order, c), barrier=sp.Barrier(wall, restitution, free_side="above"))


def test_the_file_is_small() -> None:
    assert ATLAS_FILE.stat().st_size <= 2_000_000


@pytest.mark.parametrize("c", [0.01, 0.07, 1.3, 10.0])
@pytest.mark.parametrize("wall", [-0.9, 0.0, 1.1])
def test_order_one_behind_an_elastic_wall_is_exact(c: float, wall: float) -> None:
    asked = oscillator(1.0, c, wall)
    found, truth = sp.atlas(asked), sp.theory.exact(asked)
    for name in MOMENTS:
        value = getattr(truth, name)
        if abs(value) > 1e-3:
            assert getattr(found, name) == pytest.approx(value, rel=3e-3), name


@pytest.mark.parametrize(("restitution", "wall"), [(0.33, 0.0), (0.5, 0.0), (0.85, 0.0), (0.8, -0.6), (0.8, 0.7)])
def test_order_one_behind_a_lossy_wall_is_the_fokker_planck_equations(restitution: float, wall: float) -> None:
    asked = oscillator(1.0, 0.4, wall, restitution)
    found, truth = sp.atlas(asked), sp.theory.fokker_planck(asked)
    for name in MOMENTS:
        assert getattr(found, name) == pytest.approx(getattr(truth, name), rel=4e-3), name


def test_scales_are_those_of_the_problem() -> None:
    plain = oscillator(0.4, 0.7, -0.5)
    frequency, intensity = 3.0, 0.02
    length, speed = math.sqrt(intensity / frequency**3), math.sqrt(intensity / frequency)
    scaled = sp.Oscillator(
        natural_frequency=frequency,
        springpot=sp.Springpot(0.4, 0.7 * frequency**1.6),
        barrier=sp.Barrier(-0.5 * length),
        excitation=sp.WhiteNoise(intensity),
    )
    units = dict(zip(MOMENTS, (length**2, length, length**2, speed**2, frequency, speed, speed**2), strict=True))
    found, reference = sp.atlas(scaled), sp.atlas(plain)
    for name in MOMENTS:
        assert getattr(found, name) == pytest.approx(units[name] * getattr(reference, name), rel=1e-9), name
        assert found.errors[name] == pytest.approx(units[name] * reference.errors[name], rel=1e-6), name


def test_a_wall_above_is_the_mirror_image() -> None:
    below = oscillator(0.3, 1.0, -0.4)
    above = sp.Oscillator(springpot=sp.Springpot(0.3, 1.0), barrier=sp.Barrier(0.4, free_side="below"))
    for name in MOMENTS:
        sign = -1.0 if name == "x_mean" else 1.0
        assert getattr(sp.atlas(above), name) == pytest.approx(sign * getattr(sp.atlas(below), name), rel=1e-12)
        assert sp.atlas(above).errors[name] == pytest.approx(sp.atlas(below).errors[name], rel=1e-12)


@pytest.mark.parametrize("order", [0.07, 0.3, 0.8])
@pytest.mark.parametrize("c", [0.03, 1.0, 7.0])
def test_its_tables_agree_where_they_meet(order: float, c: float) -> None:
    """Restitution near 1 against the elastic table; a wall near the equilibrium against the table of losses."""
    for near, far in (
        (oscillator(order, c, 0.0, 1.0), oscillator(order, c, 0.0, 1.0 - 1e-6)),
        (oscillator(order, c, 0.0, 0.8), oscillator(order, c, 1e-6, 0.8)),
    ):
        one, other = sp.atlas(near), sp.atlas(far)
        for name in MOMENTS:
            gap = abs(getattr(one, name) - getattr(other, name))
            allowed = 1.5 * math.hypot(one.errors[name], other.errors[name]) + 2e-3 * abs(getattr(one, name))
            assert gap <= allowed, (name, gap, allowed)


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        (oscillator(0.04, 1.0), "order from 0.05 to 1, not 0.04"),
        (oscillator(0.5, 11.0), "from 0.01 to 10, not 11"),
        (oscillator(0.5, 1.0, 2.1), "from -2 to 2, not 2.1"),
        (oscillator(0.5, 1.0, 0.0, 0.29), "restitution from 0.3 to 1, not 0.29"),
        (oscillator(0.5, 1.0, 0.5, 0.9), "with a restitution of 1 or 0.8 only, not 0.9"),
        (sp.Oscillator(barrier=None), "with a wall"),
        (sp.Oscillator(excitation=sp.WhiteNoise(0.0)), "positive intensities"),
    ],
)
def test_outside_its_range_it_refuses(asked: sp.System, sentence: str) -> None:
    with pytest.raises(NotCoveredError, match=sentence):
        sp.atlas(asked)


def test_what_is_no_oscillator_is_refused() -> None:
    with pytest.raises(TypeError, match="must be a System"):
        sp.atlas(0.5)  # type: ignore[arg-type]


def test_a_system_that_is_an_oscillator_has_its_answer_and_another_names_the_part() -> None:
    parts = sp.Mass(0.5), sp.Spring(50.0), sp.Springpot(0.4, 3.0), sp.WhiteNoise(0.01), sp.Barrier(0.01, 0.8)
    device = sp.System(*parts)
    same = sp.Oscillator.from_numbers(**sp.Dimensionless.of(device).numbers)
    assert sp.atlas(device).moments == sp.atlas(same).moments
    assert sp.atlas(device).impact_rate > 0.0
    with pytest.raises(
        sp.theory.NotCoveredError, match=r"^magnet cannot be part of an Oscillator: an Oscillator is .*\.$"
    ):
        sp.atlas(sp.System(*parts, magnet=sp.PolynomialSpring((0.0, 0.0, 1.0))))


def test_the_corners_of_its_range_are_inside() -> None:
    for order in (0.05, 1.0):
        for c in (0.01, 10.0):
            for wall, restitution in ((-2.0, 1.0), (2.0, 1.0), (-2.0, 0.8), (2.0, 0.8), (0.0, 0.3), (0.0, 1.0)):
                found = sp.atlas(oscillator(order, c, wall, restitution))
                assert found.amplitude_mean_square == pytest.approx(found.x_mean_square + found.v_mean_square, rel=0.02)
                assert found.x_mean >= wall


@pytest.mark.parametrize("position", [0.2, 1.0, 5.7, 8.999])
def test_interpolation_reproduces_cubic_polynomials(position: float) -> None:
    first, share = weights(position, 10)
    nodes = np.arange(first, first + 4.0)
    assert 0 <= first <= 6
    assert share @ nodes**3 == pytest.approx(position**3, rel=1e-12)


def test_crowding_grows_with_restitution() -> None:
    assert np.all(np.diff(crowding(np.linspace(0.3, 1.0, 50))) > 0.0)


def test_the_command_prints_what_the_function_says() -> None:
    words = [sys.executable, "-m", "springpot", "atlas", "--order", "0.3", "--coefficient", "0.5", "--json"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    found, truth = json.loads(done.stdout), sp.atlas(oscillator(0.3, 0.5))
    assert found["impact_rate"] == truth.impact_rate
    assert found["impact_rate_error"] == truth.errors["impact_rate"]


def random_oscillators(count: int, seed: int) -> list[sp.System]:
    """Evenly over the logarithm of c and everything else, a third of them in each table."""
    dice = np.random.default_rng(seed)
    found = []
    for number in range(count):
        order, c = dice.uniform(0.05, 1.0), math.exp(dice.uniform(math.log(0.01), math.log(10.0)))
        wall, restitution = ((dice.uniform(-2.0, 2.0), 1.0), (dice.uniform(-2.0, 2.0), 0.8),
                             (0.0, dice.uniform(0.3, 1.0)))[number % 3]  # fmt: skip
        found.append(oscillator(order, c, wall, restitution))
    return found


def judged(asked: sp.System, rtol: float, seed: int) -> dict[str, tuple[bool, float]]:
    """Of each moment that Monte Carlo knows to 0.5 %: does the atlas's interval hold, and how far off is it."""
    found, fresh = sp.atlas(asked), sp.simulate(asked, rtol=rtol, seed=seed)
    out = {}
    for name in MOMENTS:
        value, error = fresh[name].value, fresh[name].error
        if error < 5e-3 * abs(value):
            gap = getattr(found, name) - value
            out[name] = abs(gap) <= math.hypot(found.errors[name], 1.96 * error), abs(gap / value)
    return out


@pytest.mark.validation  # every day: what is exact, in this file
def test_it_agrees_with_fresh_monte_carlo() -> None:
    results = [item for asked in random_oscillators(4, 5) for item in judged(asked, 0.004, 77).values()]
    assert np.mean([held for held, _ in results]) >= 0.85
    assert np.median([gap for _, gap in results]) < 5e-3


@pytest.mark.validation
def test_its_intervals_cover_two_hundred_random_oscillators() -> None:
    held: dict[str, list[bool]] = {name: [] for name in MOMENTS}
    gaps: dict[str, list[float]] = {name: [] for name in MOMENTS}
    for asked in random_oscillators(SAMPLE, 11):
        for name, (inside, gap) in judged(asked, 0.004, 1234).items():
            held[name].append(inside)
            gaps[name].append(gap)
    for name in MOMENTS:
        print(
            f"{name}: {len(gaps[name])}, covered {np.mean(held[name]):.3f}, median {100 * np.median(gaps[name]):.2f} %"
        )
    for name in MOMENTS:
        assert np.mean(held[name]) >= 0.9, name
        assert np.median(gaps[name]) < 5e-3, name
