"""The two steps of the memory closure, repeated until they agree (dimensionless: Omega = q = 1)."""

from __future__ import annotations

import math

import numpy as np

from springpot.theory.methods.memory_closure.memory import Loop, make_grid
from springpot.theory.methods.memory_closure.plane import Plane, solve_plane
from springpot.theory.numerics.equations import Anderson
from springpot.theory.result import NoConvergenceError

_DEGREE = 9  # of the polynomials of the plane
_TOLERANCE = 1e-6  # of the added stiffness, over that of the oscillator, and of the damping, over the whole
_SWEEPS = 100
_STEPS = 60
_GRIDS = 5


def solve_with_wall(
    alpha: float, c: float, restitution: float, position: float, detail: int = 0, degree: int = _DEGREE
) -> tuple[Loop, Plane, int, float]:
    """Repeat both steps until they agree; dimensionless."""
    stiffness, damping = 0.0, _light_impacts(restitution)
    loop = _light_loop(alpha, c, damping, detail)
    iterations = 0
    for _ in range(_GRIDS):
        mix = Anderson(3)
        for _ in range(_STEPS):
            loop, _ = loop.closed(c, stiffness, damping, _TOLERANCE / 10.0, _SWEEPS)
            plane = solve_plane(loop, c, position, restitution, degree)
            iterations += 1
            point = np.array([stiffness, damping])
            image = np.array([
                plane.v_mean_square / plane.y_moment(2) - 1.0 - c * loop.element_stiffness,
                1.0 / (2.0 * plane.v_mean_square) - c * loop.element_damping,
            ])  # fmt: skip
            residual = float(np.max(np.abs(image - point) * np.array([1.0, 2.0 * plane.v_mean_square])))
            if residual < _TOLERANCE:
                break
            stiffness, damping = (float(value) for value in mix.step(point, image))
        else:
            raise NoConvergenceError(
                f"The memory closure did not converge: after {_STEPS} steps its stiffness and damping still change by "
                f"{residual:.1e} of Omega^2 and Omega."
            )
        resonance, decay = loop.peak(c, stiffness, damping)
        grid = loop.grid
        if abs(resonance - grid.resonance) < 0.5 * decay and 0.5 < decay / grid.decay < 2.0:
            return loop, plane, iterations, residual
        loop = loop.moved(make_grid(alpha, resonance, decay, detail))
    raise NoConvergenceError("The memory closure found no resonance to put its grid on.")


def _light_loop(alpha: float, c: float, damping: float, detail: int) -> Loop:
    """Start of the iteration: the springpot's force for \\|cos t\\|, harmonic by harmonic."""
    stiff, lossy = _light_element(alpha)
    grid = make_grid(alpha, math.sqrt(1.0 + c * stiff), (c * lossy + damping) / 2.0, detail)
    return Loop.driven_by(grid, np.asarray(stiff + 1j * lossy * grid.w), c, 0.0, damping)


def _light_element(alpha: float) -> tuple[float, float]:
    """Stiffness and damping of the springpot for the motion \\|cos t\\|, per unit of c."""
    n = 2.0 * np.arange(1, 1000)
    shares = 16.0 / math.pi**2 / (n * n - 1.0) ** 2
    half = alpha * math.pi / 2.0
    return math.cos(half) * float(shares @ n**alpha), math.sin(half) * float(shares @ n ** (1.0 + alpha))


def _light_impacts(restitution: float) -> float:
    """Damping equivalent to two impacts per period, with the energy growing linearly between them."""
    return 2.0 / math.pi * (1.0 - restitution**2) / (1.0 + restitution**2)


def least_loss(c: float) -> float:
    """Loss rate over Omega below which the equation for the stationary density is too ill-conditioned."""
    return 2e-4 + 3e-3 * c


def light_loss(alpha: float, c: float, restitution: float) -> float:
    """Loss rate of the energy over Omega, for light damping.

    Examples
    --------
    >>> round(light_loss(1.0, 0.2, 1.0), 3)
    0.2
    """
    return c * _light_element(alpha)[1] + _light_impacts(restitution)
