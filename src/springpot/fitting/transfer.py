"""Measured frequency responses beside those of linear systems, in closed form with their derivatives."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from springpot.fitting.estimate import search
from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.likelihood import USUAL, How, LeastSquares, Table
from springpot.fitting.moduli import slopes_by_name
from springpot.fitting.spectral_density import held_by, moduli, row_of
from springpot.machine.arrays import Complexes, Floats
from springpot.problem.parts.registration import Slopes
from springpot.problem.system import System
from springpot.theory.methods.systems.linear import companion_of

_POOR = 0.3  # deviation from the model with which the data may be turned
_BETTER = 0.3  # of that deviation


def response_of(
    system: System, frequency_hz: Floats, of: str, on: str, at: str | None = None
) -> tuple[Complexes, Slopes]:
    """The response, and the derivative of its logarithm by each number that enters.

    Parameters
    ----------
    system : System
        Linear, without walls.
    frequency_hz : ndarray, shape (n,)
    of : {"x", "v", "a"}
    on, at : str
        As in `MeasuredFrequencyResponse`.

    Raises
    ------
    NotCoveredError
        If there is a wall, or something nonlinear.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Mass, Spring
    >>> device = System(Mass(2.0), Spring(8.0), Dashpot(0.4))
    >>> found, _ = response_of(device, np.array([1.0 / np.pi]), "x", "mass")
    >>> bool(abs(found[0] + 1.25j) < 1e-12)
    True
    """
    own, w = companion_of(system), 2.0 * np.pi * frequency_hz
    p = np.asarray(1j * w, complex)
    seen_by, power = row_of(system, at), {"x": 0, "v": 1, "a": 2}[of]
    seen = own.displaced(w, seen_by)
    of_ground = on == "ground" and of == "a"  # of the mass itself: the ground moves the other ends of all parts but it
    alike = system.coordinates.participations
    push = system.coordinates.push("ground") if on == "ground" else row_of(system, on, "on")
    force = held_by(system, p) if of_ground else np.broadcast_to(push, seen.shape)
    response = (seen * force).sum(axis=1)
    moved = own.displaced(w, force)
    slopes: Slopes = []
    for name, part in system.named():
        if name in system.elements:
            row = system.coordinates.elongations[name]
            change = (seen @ row) * (of_ground * float(row @ alike) - moved @ row) / response
            slopes += [(number, slope * change) for number, slope in (*part.slopes(p), (part.inertia, p**2))]
        elif name in system.masses:
            place = system.points.index(part.at or system.points[0])
            fed = alike[place] if on == "ground" and not of_ground else 0.0
            slopes.append((part.value, -seen[:, place] * (p**2 * moved[:, place] + fed) / response))
            given = _given(system, p, seen)[:, place] if of_ground else -part.value * seen[:, place] * (on == "ground")
            slopes.append((part.participation, given / response))
        elif name in system.combined:
            change = _by_share(system, p, part.at, seen, moved - alike * of_ground)
            change = change + (at == part.at) * moved + (on == part.at) * seen
            rows = [system.points.index(name) for name in part.of]
            slopes += [(share, change[:, row] / response) for share, row in zip(part.shares, rows, strict=True)]
    return np.asarray(response if of_ground else response * p**power), slopes


def _given(system: System, p: Complexes, seen: Complexes) -> Complexes:
    """What is seen of the forces of parts where one coordinate is moved against the ground, shape (n, coordinates)."""
    of_parts = ((modulus * (seen @ row))[:, None] * row for row, modulus in moduli(system, p).values())
    return np.asarray(sum(of_parts, np.zeros_like(seen)))


def _by_share(system: System, p: Complexes, point: str, seen: Complexes, moved: Complexes) -> Complexes:
    """The derivative of ``seen.force`` by each share of a point between which and others parts are."""
    found, ends = np.zeros_like(seen), system.coordinates.ends
    for name, (row, modulus) in moduli(system, p).items():
        if point in ends[name]:
            turned = -modulus if ends[name][0] == point else modulus
            found -= turned[:, None] * (seen * (moved @ row)[:, None] + (seen @ row)[:, None] * moved)
    return found


class ResponseLikelihood(LeastSquares):
    """Magnitudes and phases of a frequency response.

    Parameters
    ----------
    system : System
        Linear, without walls, with free numbers.
    data : MeasuredFrequencyResponse

    Raises
    ------
    ValueError
        If a free number has no influence.

    Notes
    -----
    The error of a measured response H (1 + z) is complex, with parts of equal variance.  The residuals are the real and
    the imaginary part of ln(1 + z).  Its mean is that of z, 0, whatever the size of z is, because the logarithm is
    analytic (but for values beyond |z| = 1): the estimates are not biased by it.
    """

    def __init__(self, system: System, data: MeasuredFrequencyResponse, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self.known = data.errors is not None
        self._unit = np.ones(data.size) if data.errors is None else np.tile(data.errors, 2)

    def _at(self, theta: Floats) -> tuple[Complexes, Slopes]:
        data = self.data
        return response_of(self.restarted(theta), data.frequency_hz, data.of, data.on, data.at)

    def _expected(self, theta: Floats) -> Complexes:
        return self._at(theta)[0]

    def residuals(self, theta: Floats) -> Floats:
        """Logarithms of the ratios of the magnitudes, then differences of the phases."""
        ratio = self.data.response / self._expected(theta)
        return np.asarray(np.concatenate([np.log(np.abs(ratio)), np.angle(ratio)]) / self._unit)

    def sensitivity(self, theta: Floats) -> Floats:
        """Change of the logarithm of the response, in its standard deviations."""
        _, slopes = self._at(theta)
        matrix = slopes_by_name(slopes, self.coordinates.names, self.data.response.size)
        return np.asarray(np.concatenate([matrix.real, matrix.imag]) / self._unit[:, None])

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """Whether it was stopped, or agrees badly, and far better with the response turned."""
        said = super().doubts(theta)
        if said or self._off(theta) < _POOR:
            return said
        for response, words in (
            (self.data.response.conj(), "the sign of its phase inverted: give response.conj()"),
            (-self.data.response, "output and input counted in opposite directions: give -response"),
        ):
            with suppress(ValueError):  # what no passive device has is refused
                turned = ResponseLikelihood(self.system, replace(self.data, response=response))
                best = turned.coordinates.outer(search(turned, 1).u)
                if turned._off(best) < _BETTER * self._off(theta):
                    return (f"The response agrees far better with {words}.",)
        return said

    def _off(self, theta: Floats) -> float:
        """Root mean square deviation from the model, relative to the magnitude."""
        return float(np.sqrt(np.mean((self.residuals(theta) * self._unit) ** 2)))

    def constant(self) -> float:
        """Of the errors, where they are known."""
        return float(2.0 * np.log(self._unit).sum() + self.size * np.log(2.0 * np.pi))

    def table(self, theta: Floats) -> Table:
        """Magnitude and phase against frequency."""
        data, found = self.data.response, self._expected(theta)
        count = data.size
        return Table(
            "frequency_hz", "Hz", np.tile(self.data.frequency_hz, 2), np.repeat(["magnitude", "phase"], count),
            np.concatenate([np.abs(data), np.angle(data)]),
            np.concatenate([np.abs(found), np.angle(data) - np.angle(data / found)]),
            self.standardized(theta),
        )  # fmt: skip
