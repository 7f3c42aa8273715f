"""Transition densities of the oscillator with a dashpot and white noise, without impacts, from a start at the wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from springpot.machine.arrays import Floats
from springpot.theory.numerics.contours import dashpot_mean_squares, dashpot_motion
from springpot.theory.numerics.panels import panel_rule
from springpot.theory.problem import Problem

_EXPONENTIALS = 2_000_000  # evaluated at once


def free_spread(problem: Problem) -> float:
    """Standard deviation of x and of v without the wall."""
    return math.sqrt(0.5 / problem.coefficient)


def nothing_beyond(problem: Problem) -> float:
    """Displacement and speed at which every density is below rounding."""
    return 8.5 * free_spread(problem) + abs(problem.position)


@dataclass(frozen=True)
class QuadraticForm:
    """A density of arrival = height exp(-z' form z) with z = (arrival, departure, 1), for many times."""

    form: Floats  # of shape (times, 3, 3)
    height: Floats

    @classmethod
    def at(cls, problem: Problem, time: Floats, gap: float = 0.0) -> QuadraticForm:
        """The form of P_t(b + gap, v | b, v')."""
        flow = Flow.at(problem.coefficient, time)
        dx = _row(0.0 * time, -flow.kick, gap + problem.position * flow.slip)
        dv = _row(1.0 + 0.0 * time, -flow.kick_rate, problem.position * flow.kick)
        mixed = _product(dx, dv, flow.x_v)
        form = _product(dx, dx, flow.v_v) + _product(dv, dv, flow.x_x) - mixed - mixed.transpose(0, 2, 1)
        height = 1.0 / (2.0 * math.pi * np.sqrt(flow.determinant))
        return cls(form / (2.0 * flow.determinant)[:, None, None], height)

    @classmethod
    def of_one(cls, line: Floats, variance: Floats) -> QuadraticForm:
        """The form of one normal variable: the line is zero at its mean."""
        return cls(_product(line, line, 0.5 / variance), 1.0 / np.sqrt(2.0 * math.pi * variance))

    @property
    def arrival_width(self) -> float:
        """Smallest standard deviation in the arrival."""
        return 1.0 / math.sqrt(2.0 * float(np.max(self.form[:, 0, 0])))

    @property
    def departure_width(self) -> float:
        """Smallest standard deviation in the departure."""
        return 1.0 / math.sqrt(2.0 * float(np.max(self.form[:, 1, 1])))

    def integrate(self, weight: Floats, arrive: Floats, depart: Floats) -> Floats:
        """Sum over the times of weight times the density, a row for each arrival, a column for each departure."""
        total = np.zeros((arrive.size, depart.size))
        features = np.stack([arrive**2, arrive, np.ones_like(arrive)])
        chunk = max(1, _EXPONENTIALS // total.size)
        for start in range(0, weight.size, chunk):
            m = self.form[start : start + chunk]
            size = weight[start : start + chunk] * self.height[start : start + chunk]
            slope = 2.0 * (m[:, 0, 1, None] * depart + m[:, 0, 2, None])
            rest = depart * (m[:, 1, 1, None] * depart + 2.0 * m[:, 1, 2, None]) + m[:, 2, 2, None]
            factors = np.stack([np.broadcast_to(m[:, 0, 0, None], slope.shape), slope, rest], axis=2)
            exponent = factors @ features  # times, departures, arrivals
            np.exp(np.negative(exponent, out=exponent), out=exponent)
            total += np.tensordot(size, exponent, axes=1).T
        return total


def x_form(problem: Problem, time: Floats) -> QuadraticForm:
    """Density of x at a time after leaving the wall, behind it included."""
    flow = Flow.at(problem.coefficient, time)
    return QuadraticForm.of_one(_row(1.0 + 0.0 * time, -flow.kick, problem.position * (flow.slip - 1.0)), flow.x_x)


def v_form(problem: Problem, time: Floats) -> QuadraticForm:
    """Density of v at a time after leaving the wall."""
    flow = Flow.at(problem.coefficient, time)
    return QuadraticForm.of_one(_row(1.0 + 0.0 * time, -flow.kick_rate, problem.position * flow.kick), flow.v_v)


def _row(arrival: Floats, departure: Floats, constant: Floats) -> Floats:
    return np.stack([arrival, departure, constant], axis=1)


def _product(a: Floats, b: Floats, factor: Floats) -> Floats:
    return np.asarray(factor[:, None, None] * a[:, :, None] * b[:, None, :])


@dataclass(frozen=True)
class Flow:
    """Mean and covariance of the free motion after some times, exact at small times too."""

    kick: Floats  # displacement after a unit speed
    kick_rate: Floats  # its derivative
    slip: Floats  # 1 less the displacement after a unit displacement
    x_x: Floats
    x_v: Floats
    v_v: Floats
    determinant: Floats

    @classmethod
    def at(cls, c: float, time: Floats) -> Flow:
        """Closed forms; at small times, integrals that do not cancel."""
        kick, kick_rate, hold = dashpot_motion(c, time)
        x_x, v_v = dashpot_mean_squares(c, time)
        x_v = kick**2 / 2.0
        determinant = x_x * v_v - x_v**2
        slip = 1.0 - hold
        early = time < 0.5 / max(c, 1.0)
        if np.any(early):
            nodes, weights = panel_rule([0.0, 1.0], 16)
            t = time[early, None]
            h, h_rate, _ = dashpot_motion(c, t * nodes)
            w = t * weights
            x_x[early], v_v[early], slip[early] = (np.sum(w * f, axis=1) for f in (h * h, h_rate * h_rate, h))
            # of a Gram matrix: half the double integral of (h(s) h'(s') - h'(s) h(s'))^2
            cross = h[:, :, None] * h_rate[:, None, :]
            cross = (cross - cross.transpose(0, 2, 1)) ** 2
            determinant[early] = np.einsum("ti,tj,tij->t", w, w, cross) / 2.0
        return cls(kick, kick_rate, slip, x_x, x_v, v_v, determinant)


def interpolation(low: float, high: float, width: float, points: Floats) -> tuple[Floats, Floats]:
    """Chebyshev nodes enough for a normal density of this width, and the matrix from them to the points."""
    half = (high - low) / 2.0
    n = math.ceil(4.0 * half / width) + 10
    nodes = chebyshev.chebpts1(n)
    to_coefficients = 2.0 / n * chebyshev.chebvander(nodes, n - 1).T
    to_coefficients[0] /= 2.0
    at_points = chebyshev.chebvander((points - low) / half - 1.0, n - 1)
    return low + half * (nodes + 1.0), at_points @ to_coefficients
