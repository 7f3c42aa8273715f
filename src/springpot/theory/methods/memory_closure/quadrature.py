"""Quadrature for the memory closure: Filon's rule on panels, and a half-normal rule."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from springpot.machine.arrays import Complexes, Floats
from springpot.theory.numerics.panels import panel_rule

_SLOW = 2.0  # phase over half a panel below which Gauss's rule resolves e^(ikx); above, Filon's rule is used


def oscillating_weights(edges: Floats, frequency: Floats, order: int) -> Complexes:
    """Weights W with int f(x) e^(ikx) dx = W @ f(nodes), for the nodes of `panel_rule` and any k.

    On each panel f is replaced by its interpolating polynomial in Legendre form, whose Fourier integrals are spherical
    Bessel functions (Filon's rule).

    Parameters
    ----------
    edges : ndarray
        Edges of the panels, increasing.
    frequency : ndarray, shape (m,)
        k, of either sign.
    order : int
        Nodes per panel.

    Returns
    -------
    ndarray, shape (m, panels * order)

    Examples
    --------
    >>> edges = np.linspace(0.0, 30.0, 31)
    >>> x, _ = panel_rule(edges, 8)
    >>> value = oscillating_weights(edges, np.array([500.0]), 8) @ np.exp(-x)
    >>> bool(abs(value[0] * (1 - 500j) - 1) < 1e-7)
    True
    """
    x, w, to_nodes = _legendre(order)
    half, centre = np.diff(edges) / 2.0, (edges[1:] + edges[:-1]) / 2.0
    phase = np.multiply.outer(frequency, half)
    size = np.maximum(np.abs(phase), _SLOW)
    # Upward recurrence of the spherical Bessel functions: above _SLOW it loses three of sixteen digits at order 8.
    bessel = np.empty((order, *size.shape))
    bessel[0] = np.sin(size) / size
    bessel[1] = (bessel[0] - np.cos(size)) / size
    for n in range(1, order - 1):
        bessel[n + 1] = (2 * n + 1) / size * bessel[n] - bessel[n - 1]
    bessel[1::2] *= np.sign(phase)  # odd orders are odd in the phase
    weights = np.empty((*phase.shape, order), dtype=np.complex128)
    weights.real = np.tensordot(bessel[::2], to_nodes[::2].real, (0, 0))
    weights.imag = np.tensordot(bessel[1::2], to_nodes[1::2].imag, (0, 0))
    slow = np.abs(phase) < _SLOW
    weights[slow] = w * np.exp(1j * np.multiply.outer(phase[slow], x))
    weights *= (np.exp(1j * np.multiply.outer(frequency, centre)) * half)[..., None]
    return np.asarray(weights.reshape(frequency.size, -1))


@lru_cache(maxsize=8)
def half_normal_rule(order: int) -> tuple[Floats, Floats]:
    """Gauss's rule for the mean over a half-normal variable: exact for polynomials of degree below 2 order.

    The three-term recurrence of the polynomials comes from a fine discretization of the half line (Stieltjes).

    Examples
    --------
    >>> x, w = half_normal_rule(6)
    >>> float(round(w @ x**10, 9))
    945.0
    """
    t, dt = panel_rule(np.linspace(0.0, 13.0, 40), 16)
    weight = math.sqrt(2.0 / math.pi) * np.exp(-t * t / 2.0) * dt
    weight /= weight.sum()
    old, new, norm = np.zeros_like(t), np.ones_like(t), 1.0
    diagonal, off = np.empty(order), np.empty(order)
    for n in range(order):
        diagonal[n] = weight @ (t * new * new)
        following = (t - diagonal[n]) * new - (off[n - 1] * old if n else 0.0)
        norm = math.sqrt(weight @ (following * following))
        old, new = new, following / norm
        off[n] = norm
    nodes, vectors = np.linalg.eigh(np.diag(diagonal) + np.diag(off[:-1], 1) + np.diag(off[:-1], -1))
    return nodes, vectors[0] ** 2


@lru_cache(maxsize=8)
def _legendre(order: int) -> tuple[Floats, Floats, Complexes]:
    """Nodes and weights on [-1, 1], and the matrix from spherical Bessel functions j_n to weights at the nodes."""
    x, w = np.polynomial.legendre.leggauss(order)
    n = np.arange(order)
    to_nodes = (np.polynomial.legendre.legvander(x, order - 1) * ((2 * n + 1) * 1j**n) * w[:, None]).T
    return x, w, np.ascontiguousarray(to_nodes, dtype=np.complex128)
