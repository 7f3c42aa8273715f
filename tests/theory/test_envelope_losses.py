"""Lossy walls in the envelope: what it takes over from order 1, and that densities and moments stay one thing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate

import springpot as sp
from springpot.theory import envelope, fokker_planck
from springpot.theory.envelope_losses import _rows, _tables

from .test_envelope import make

PLACES = [
    (0.05, 0.65, 0.9), (0.2, 0.45, 0.0), (0.3, 0.75, -0.6), (0.7, 0.35, 0.4), (1.5, 0.55, -1.0), (0.02, 0.95, 0.5),
]  # fmt: skip


@pytest.mark.parametrize(("c", "r", "b"), PLACES)
def test_order_one_between_the_nodes(c: float, r: float, b: float) -> None:
    found, exact = envelope(make(1.0, c, b, r)), fokker_planck(make(1.0, c, b, r))
    for name in ("amplitude_mean_square", "x_mean", "x_mean_square", "v_mean_square"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=3e-3)
    for name in ("impact_rate", "impact_speed_mean", "impact_speed_mean_square"):
        assert getattr(found, name) == pytest.approx(getattr(exact, name), rel=5e-3)


@pytest.mark.parametrize(
    ("c", "r", "b", "x", "v", "u"), [(0.1, 0.5, 1.0, 0.12, 0.07, 0.02), (0.3, 0.5, 0.0, 0.12, 0.08, 0.02)]
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


@pytest.mark.parametrize(("order", "c", "b", "r"), [(1.0, 0.1, 1.0, 0.5), (0.5, 1.0, 0.0, 0.5), (0.3, 0.3, -0.7, 0.3)])
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


def test_more_time_is_spent_on_the_way_out_which_is_slower() -> None:
    v = np.linspace(0.0, 20.0, 20_001)
    for side, way in (("above", 1.0), ("below", -1.0)):
        wall = sp.Barrier(restitution=0.5, side=side)
        found = envelope(sp.Oscillator(springpot=sp.Springpot(0.5, 0.1), barrier=wall))
        out, back = (integrate.trapezoid(found.v_density(sign * way * v), v) for sign in (1.0, -1.0))
        assert out + back == pytest.approx(1.0, abs=1e-6)
        assert 0.52 < out < 0.58
        assert found.joint_density(way, way * 0.5) != found.joint_density(way, -way * 0.5)


def test_an_elastic_wall_changes_nothing() -> None:
    nearly, elastic = envelope(make(0.5, 0.3, 0.2, 1.0 - 1e-9)), envelope(make(0.5, 0.3, 0.2, 1.0))
    for name in ("x_mean", "x_mean_square", "v_mean_square", "impact_rate", "impact_speed_mean_square"):
        assert getattr(nearly, name) == pytest.approx(getattr(elastic, name), rel=1e-6)


def test_the_tables_are_made_by_their_own_recipe() -> None:
    below, above = _tables()
    rows = np.array(_rows((0.2, 0.7)))
    kept = np.vstack([below.values[4, 6], above.values[4, 6][1:]])
    assert rows == pytest.approx(kept, abs=1e-5)
