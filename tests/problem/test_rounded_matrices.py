"""Matrices of another program: symmetric but for rounding."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp


def test_rounding_of_a_billionth_is_no_asymmetry() -> None:
    found = sp.theory.modes(sp.System.from_matrices(np.eye(2), [[2.0, -1.0], [-1.0 * (1.0 + 3e-12), 2.0]]))
    assert found.frequencies == pytest.approx([1.0, np.sqrt(3.0)], rel=1e-11)
    rounded = sp.System.from_matrices(
        [[1.0, 0.2], [0.2 + 9e-10, 1.0]], [[2.0, -1.0], [-1.0, 2.0]], [[0.2, -0.2 + 1e-10], [-0.2, 0.2]]
    )
    assert np.allclose(rounded.coordinates.mass - np.diag(np.diag(rounded.coordinates.mass)), 0.0)


@pytest.mark.parametrize("place", range(3))
def test_a_larger_difference_is_in_the_sentence(place: int) -> None:
    matrices = [np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([[0.2, -0.1], [-0.1, 0.2]])]
    largest = matrices[place].max()
    matrices[place][1, 0] += 3e-6 * largest
    name = ("mass", "stiffness", "damping")[place]
    with pytest.raises(
        ValueError, match=rf"^{name} must be a symmetric matrix, but .* differ by .*3e-06 of the"
    ) as one:
        sp.System.from_matrices(*matrices)
    assert f"differ by {3e-6 * largest:.3g}," in str(one.value)


def test_modal_damping_with_rounding_stays_modal() -> None:
    """M P diag(2 z w) P' M, of all modes and of a few alone: rounding makes no damper, and none that is negative."""
    rng = np.random.default_rng(0)
    own = rng.normal(size=(20, 20))
    mass = own @ own.T + 20.0 * np.eye(20)
    w = 2.0 * np.pi * np.geomspace(4.0, 68000.0, 20)
    shapes = np.linalg.inv(np.linalg.cholesky(mass)).T @ np.linalg.qr(rng.normal(size=(20, 20)))[0]
    weighted = mass @ shapes
    for modes in (20, 5):
        damping = (weighted * np.where(np.arange(20) < modes, 0.04 * w, 0.0)) @ weighted.T
        damping *= 1.0 + 1e-11 * rng.normal(size=damping.shape)
        stiffness = (weighted * w**2) @ weighted.T
        found = sp.System.from_matrices(mass, stiffness, damping, names={"tip": np.eye(20)[0]})
        dashpots = found.of(sp.Dashpot)
        assert len(dashpots) == modes
        assert all(dashpot.between[1].startswith("mode_") for dashpot in dashpots)
