"""Every density of every method: mass 1, never negative but for the closure's tails, and safe at any argument."""

import math

import numpy as np
import pytest

from springpot.machine.faults import NotCoveredError, per_cent
from springpot.problem.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.theory import averaging, envelope, exact, fokker_planck, memory_closure
from springpot.theory.numerics.panels import panel_rule
from tests.sizes import validation


def make(order, c, b=0.0, r=1.0, free_side="above", omega=1.0, q=1.0):
    return Oscillator(omega, Springpot(order, c), None if b is None else Barrier(b, r, free_side), WhiteNoise(q))


CASES = {
    "averaging": lambda: averaging(make(0.4, 0.5, 0.0, 0.9)),
    "averaging without a wall": lambda: averaging(make(0.4, 0.5, None)),
    "averaging shifted": lambda: averaging(make(0.3, 0.5, 0.0, free_side="below"), form="shifted"),
    "averaging printed": lambda: averaging(make(0.6, 0.5, 0.0, omega=2.0), form="printed"),
    "exact dashpot": lambda: exact(make(1.0, 0.5, 0.7)),
    "exact gap": lambda: exact(make(1.0, 0.5, -1.5, omega=3.0, q=0.2)),
    "exact without a wall": lambda: exact(make(0.3, 0.5, None)),
    "envelope": lambda: envelope(make(0.5, 0.1)),
    "envelope gap": lambda: envelope(make(0.5, 1.0, -1.0, 0.8)),
    "envelope preload": lambda: envelope(make(0.3, 0.1, 0.5, 0.5)),
    "envelope crossing": lambda: envelope(make(0.9, 3.0, -0.2)),
    "envelope dashpot": lambda: envelope(make(1.0, 0.5, 0.0, free_side="below", omega=2.0, q=3.0)),
    "envelope without a wall": lambda: envelope(make(0.4, 1.0, None)),
    "memory_closure": lambda: memory_closure(make(0.5, 1.0)),
    "closure losses": lambda: memory_closure(make(0.2, 0.05, 0.8, 0.6)),
    "closure gap": lambda: memory_closure(make(0.6, 0.3, -0.3, 0.7, omega=2.0)),
    "closure without a wall": lambda: memory_closure(make(0.4, 0.2, None)),
    "fokker_planck": lambda: fokker_planck(make(1.0, 0.3, 0.0, 0.8)),
    "fokker_planck slow": lambda: fokker_planck(make(1.0, 0.3, -0.5, 0.3, free_side="above", omega=2.0)),
}
NAMES = ("x_density", "v_density", "amplitude_density", "energy_density", "impact_speed_density")


EVERY_DAY = {
    "averaging", "averaging shifted", "averaging printed", "exact gap", "exact without a wall",
    "envelope without a wall", "closure losses", "closure without a wall", "fokker_planck",
}  # fmt: skip


@pytest.fixture(
    scope="module",
    params=[name if name in EVERY_DAY else validation(name) for name in CASES],
    ids=lambda name: name.replace(" ", "_"),
)
def result(request):
    return CASES[request.param]()


def densities(result):
    """(name, density) of all there are; at finite times too, where the method knows them."""
    for name in NAMES:
        if not hasattr(result, name):
            continue
        density = getattr(result, name)
        if name == "impact_speed_density" and result.paper.barrier is None:
            with pytest.raises(NotCoveredError):
                density(1.0)
            continue
        yield name, density
        if result.method.startswith("averaging") or (result.method == "envelope" and name[0] in "ae"):
            yield f"{name} at 3 s", lambda value, density=density: density(value, time=3.0)


def dip(result):
    """How far below 0 a density may fall, over its maximum: the closure's polynomials do in their tails."""
    return (
        0.02 if result.method == "memory_closure" else 0.0
    )  # measured: 1e-9 to 0.012, the most behind a lossy preload


def integral(density, *, corner, low, high, panels=20_000, dip=0.0):
    """By Gauss's rule on many panels, even in the cube root of the distance from a corner."""
    nodes, weights = panel_rule(np.linspace(*np.cbrt(np.array([low, high]) - corner), panels + 1), 6)
    if low < corner < high:
        left, right = (panel_rule(np.linspace(*ends, panels // 2 + 1), 6) for ends in (
            (np.cbrt(low - corner), 0.0), (0.0, np.cbrt(high - corner))))  # fmt: skip
        nodes, weights = np.concatenate([left[0], right[0]]), np.concatenate([left[1], right[1]])
    values = density(corner + nodes**3)
    assert values.min() >= -dip * values.max()
    return float(np.sum(weights * 3.0 * nodes**2 * values))


def test_mass_is_one(result):
    wall, omega = result.paper.barrier, result.paper.natural_frequency
    place = 0.0 if wall is None else wall.position
    far = abs(place) + 16.0 * math.sqrt(result.amplitude_mean_square)
    for name, density in densities(result):
        kind = name.split("_")[0]
        if kind == "x":
            ends = {"corner": place, "low": -far, "high": far}
        elif kind == "v":
            ends = {"corner": 0.0, "low": -far * omega, "high": far * omega}
        elif kind == "amplitude":
            ends = {"corner": abs(place), "low": 0.0, "high": far}
        elif kind == "energy":
            ends = {"corner": (omega * place) ** 2 / 2.0, "low": 0.0, "high": (omega * far) ** 2 / 2.0}
        else:  # down to the slowest impacts, which may be as frequent as u^-0.9
            u, du = panel_rule(
                np.append(np.linspace(-330.0, -20.0, 2001), np.linspace(-20.0, math.log(far * omega), 40_001)[1:]), 6
            )
            assert du @ (np.exp(u) * density(np.exp(u))) == pytest.approx(1.0, abs=1e-10), name
            continue
        panels = 1000 if result.method == "memory_closure" else 20_000  # it is smooth, and slow
        assert integral(density, **ends, panels=panels, dip=dip(result)) == pytest.approx(1.0, abs=1e-10), name


def test_joint_density_over_the_speeds_is_that_of_the_place(result):
    """So its mass is 1 too.  The envelope's is integrated in energy and angle, in tests/theory/test_envelope.py."""
    if result.method == "envelope":
        pytest.skip("integrated elsewhere")
    far = 16.0 * math.sqrt(result.v_mean_square)
    for x in result.x_mean + math.sqrt(result.x_mean_square) * np.array([-0.45, 0.003, 0.9]):
        total = integral(
            lambda v, x=x: result.joint_density(x, v), corner=0.0, low=-far, high=far, panels=2000, dip=dip(result)
        )
        assert total == pytest.approx(float(result.x_density(x)), abs=1e-10 / math.sqrt(result.x_mean_square))


@pytest.mark.filterwarnings("error")
def test_any_argument_is_safe(result):
    extreme = np.array([0.0, 5e-324, 1e-305, 1e-160, 1e160, 1e300, 1e305, 1.7e308, math.inf])
    for name, density in densities(result):
        values = density(np.concatenate([extreme, -extreme]))
        assert np.all(values >= 0.0), name
        assert not np.isnan(values).any(), name
        assert np.all(values[[4, 5, 6, 7, 8, 13, 14, 15, 16, 17]] == 0.0), name
        assert np.isnan(density(math.nan)), name
        assert density([]).shape == (0,), name
    for x in (0.3, 1e305, -1e305, math.inf):
        assert np.all(result.joint_density(x, np.array([1e305, -1e305, 1e160, math.inf])) == 0.0)
    assert np.isnan(result.joint_density(math.nan, 0.0))


def test_a_spectrum_takes_nothing_and_refuses_what_is_no_number():
    problems = (Oscillator(barrier=None), Oscillator())
    for result in [method(problem) for method in (averaging, memory_closure) for problem in problems]:
        for function in (result.spectrum, getattr(result, "correlation", result.spectrum)):
            assert function([]).shape == (0,)
            with pytest.raises(ValueError, match=r"must be finite|must be a time"):
                function([0.5, math.nan])
            with pytest.raises(TypeError, match="must be a real number"):
                function("fast")


def test_densities_below_zero_are_said():
    lossy = memory_closure(Oscillator(springpot=Springpot(0.7, 0.03), barrier=Barrier(1.0, 0.5, "above")))
    v = np.linspace(-5.0, 5.0, 401) * math.sqrt(lossy.v_mean_square)
    dip = float(-lossy.v_density(v).min() / lossy.v_density(v).max())
    assert dip > 0.02
    assert any(f"below 0 by up to {per_cent(dip, 1)}" in sentence for sentence in lossy.warnings)
    assert not any("below 0" in sentence for sentence in memory_closure(Oscillator()).warnings)
