"""Lossy walls in the envelope: what it takes over from order 1, and that densities and moments stay one thing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.theory import envelope, fokker_planck
from springpot.theory.methods.envelope.losses import DAMPINGS, RESTITUTIONS, _rows, _tables
from springpot.theory.methods.envelope.method import _largest_amplitude
from tests.sizes import validation

from .test_envelope import make

PLACES = [
    (0.2, 0.45, 0.0), (1.5, 0.55, -1.0), (0.02, 0.95, 0.5),
    validation(0.05, 0.65, 0.9), validation(0.3, 0.75, -0.6), validation(0.7, 0.35, 0.4),
]  # fmt: skip


@pytest.mark.parametrize(("c", "r", "b"), PLACES)
def test_order_one_between_the_nodes(c: float, r: float, b: float) -> None:
    found, exact = envelope(make(1.0, c, b, r)), fokker_planck(make(1.0, c, b, r))
    for name in ("amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=3e-3)
    for name in ("impact_rate", "impact_speed_mean", "impact_speed_mean_square"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=5e-3)


@pytest.mark.parametrize(
    ("c", "r", "b", "x", "v", "u"), [validation(0.1, 0.5, 1.0, 0.05, 0.07, 0.02), (0.3, 0.5, 0.0, 0.05, 0.08, 0.02)]
)
def test_densities_are_near_those_of_the_fokker_planck_equation(
    c: float, r: float, b: float, x: float, v: float, u: float
) -> None:
    """Area between them; without what is taken over it was 0.15, 0.14 and 0.06 at least."""
    found, exact = envelope(make(1.0, c, b, r)), fokker_planck(make(1.0, c, b, r))
    for name, largest, place in (
        ("x", x, np.linspace(b, b + 12.0, 3001)[1:]),
        ("v", v, np.linspace(-8.0, 8.0, 3001)),
        ("impact_speed", u, np.linspace(0.0, 12.0, 3001)),
    ):
        between = [getattr(one, f"{name}_density")(place) for one in (found, exact)]
        assert integrate.trapezoid(np.abs(between[0] - between[1]), place) < largest


@pytest.mark.parametrize(
    ("order", "c", "b", "r"),
    [validation(1.0, 0.1, 1.0, 0.5), validation(0.5, 1.0, 0.0, 0.5), (0.3, 0.3, -0.7, 0.3)],
)
def test_densities_have_the_moments(order: float, c: float, b: float, r: float) -> None:
    found = envelope(make(order, c, b, r))
    x, v, u = np.linspace(b, b + 40.0, 80_001), np.linspace(-30.0, 30.0, 60_001), np.linspace(0.0, 30.0, 60_001)
    p, q, s = found.x_density(x), found.v_density(v), found.impact_speed_density(u)
    assert integrate.trapezoid(p * x, x) == pytest.approx(found.x_mean, rel=2e-4)
    assert integrate.trapezoid(p * x * x, x) == pytest.approx(found.x_mean_square, rel=2e-4)
    assert integrate.trapezoid(q * v, v) == pytest.approx(0.0, abs=2e-4)
    assert integrate.trapezoid(q * v * v, v) == pytest.approx(found.v_mean_square, rel=2e-4)
    assert integrate.trapezoid(s * u, u) == pytest.approx(found.impact_speed_mean, rel=5e-4)
    assert integrate.trapezoid(s * u * u, u) == pytest.approx(found.impact_speed_mean_square, rel=1e-3)
    a = np.linspace(max(b, 0.0), 45.0, 90_001)
    squares = integrate.trapezoid(found.amplitude_density(a) * a * a, a)
    assert squares == pytest.approx(found.amplitude_mean_square, rel=2e-3)


def test_the_stretch_goes_back_to_where_it_came_from() -> None:
    stretch = envelope(make(0.3, 0.1, 0.5, 0.5)).balance.stretch
    x, v = 0.5 + np.array([0.0, 0.01, 0.3, 2.0]), np.array([-1.5, 0.0, 0.2, 3.0])
    back = stretch.origin(stretch.x(x), stretch.v(v))
    assert back[0] == pytest.approx(x, abs=1e-12)
    assert back[1] == pytest.approx(v, abs=1e-12)
    step = 1e-6
    across = (stretch.x(x + step) - stretch.x(x - step * (x > 0.5))) / (step * (1.0 + (x > 0.5)))
    along = (stretch.v(v + step) - stretch.v(v - step)) / (2.0 * step)
    assert back[2] == pytest.approx(across * along, rel=1e-4)


def test_more_time_is_spent_on_the_way_out_which_is_slower() -> None:
    v = np.linspace(0.0, 20.0, 20_001)
    for side, way in (("above", 1.0), ("below", -1.0)):
        wall = sp.Barrier(restitution=0.5, free_side=side)
        found = envelope(sp.Oscillator(springpot=sp.Springpot(0.5, 0.1), barrier=wall))
        out, back = (integrate.trapezoid(found.v_density(sign * way * v), v) for sign in (1.0, -1.0))
        assert out + back == pytest.approx(1.0, abs=1e-6)
        assert 0.52 < out < 0.58
        assert found.joint_density(way, way * 0.5) != found.joint_density(way, -way * 0.5)


@pytest.mark.validation
@pytest.mark.parametrize(("c", "b", "r"), [(0.3, -0.5, 0.5), (0.1, 1.0, 0.5), (0.1, 0.0, 0.8)])
def test_the_joint_density_is_near_that_of_the_fokker_planck_equation(c: float, b: float, r: float) -> None:
    """And displacement and velocity are not correlated, as in every stationary state."""
    found, exact = envelope(make(1.0, c, b, r)), fokker_planck(make(1.0, c, b, r))
    x, v = b + np.linspace(0.0, 1.0, 57)[1:] ** 1.5 * 8.0, np.linspace(-7.0, 7.0, 71)
    joint = [one.joint_density(x[:, None], v) for one in (found, exact)]
    between = integrate.trapezoid(integrate.trapezoid(np.abs(joint[0] - joint[1]), v), x)
    assert between < (0.07 if r == 0.8 else 0.18)
    moving = integrate.trapezoid(integrate.trapezoid(joint[0] * v, v) * (x - b), x)
    assert abs(moving) < 0.02 * np.sqrt(found.v_mean_square * found.x_mean_square)


@pytest.mark.parametrize(("b", "r"), [(None, 1.0), (0.0, 1.0), (-0.5, 1.0), (0.0, 0.5)])
def test_a_strong_dashpot_is_answered(b: float | None, r: float) -> None:
    assert envelope(make(1.0, 30.0, b, r)).amplitude_mean_square == pytest.approx(
        fokker_planck(make(1.0, 30.0, b, r)).amplitude_mean_square if r < 1.0 else exact_answer(30.0, b), rel=0.01
    )


def exact_answer(c: float, b: float | None) -> float:
    return sp.theory.exact(make(1.0, c, b)).amplitude_mean_square


@pytest.mark.parametrize(("order", "c", "b", "r"), [(0.5, 1.0, 0.5, 0.5), (0.3, 0.1, -0.5, 0.7), (0.8, 0.3, 2.0, 0.6)])
def test_the_mean_forces_of_spring_and_wall_cancel(order: float, c: float, b: float, r: float) -> None:
    found = envelope(make(order, c, b, r))
    assert (1.0 + r) * found.impact_rate * found.impact_speed_mean == pytest.approx(found.x_mean, rel=1e-9)


def test_an_amplitude_is_reached_as_often_as_its_law_says() -> None:
    """A level that is exceeded for a part of the time is exceeded by at least as large a part of the cycles."""
    found = envelope(make(1.0, 0.1, 1.0, 0.5))
    level = 3.0 * np.sqrt(found.amplitude_mean_square)
    a = np.linspace(level, 5.0 * level, 20_001)
    above = integrate.trapezoid(found.amplitude_density(a), a)
    cells = found._law.cells
    largest = _largest_amplitude(cells, 1.0)
    assert cells.diffusion.mass[largest > level].sum() > above > 1e-5


def test_an_elastic_wall_changes_nothing() -> None:
    nearly, elastic = envelope(make(0.5, 0.3, 0.2, 1.0 - 1e-9)), envelope(make(0.5, 0.3, 0.2, 1.0))
    for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean_square"):
        assert getattr(nearly, name) == pytest.approx(getattr(elastic, name), rel=1e-6)


@pytest.mark.validation
def test_the_tables_are_made_by_their_own_recipe() -> None:
    below, above = _tables()
    rows = np.array(_rows((0.2, 0.7)))
    (damping,), (restitution,) = np.flatnonzero(DAMPINGS == 0.2), np.flatnonzero(RESTITUTIONS == 0.7)
    kept = np.vstack([below.values[damping, restitution], above.values[damping, restitution][1:]])
    assert rows == pytest.approx(kept, abs=1e-5)
