"""Linear systems without walls: moments, spectra and frequency response, for any memory and any spectrum."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from springpot.machine.arguments import LARGEST, finite_number, items_of, one_of, real_array, text
from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError, listed, shown
from springpot.problem.coordinates import Coordinates
from springpot.problem.outputs import outputs_of
from springpot.problem.parts import (
    CloughPenzienNoise,
    ColoredNoise,
    Constant,
    Harmonic,
    KanaiTajimiNoise,
    Maxwell,
    ParametricNoise,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    SpectralExcitation,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.registration import Element
from springpot.problem.parts.springpots import order_at_rest, springpot_in
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import DAMPERS, INERTIA, MEMORY, SPRINGS, Coverage
from springpot.theory.methods.systems.outputs import output_mean, output_mean_square, output_spectrum
from springpot.theory.normal_modes import free_motion, unseen_mode
from springpot.theory.numerics.frequencies import integrals, resonances
from springpot.theory.result import Moments, Result, moments_of

Density = Callable[[float], float]

_LOOSE = 1e-14  # of the largest stiffness per mass, of what is no stiffness
_ELONGATION = 1e-20  # error of a mean square elongation, over that of the displacements of its ends
_FAR = 1e6  # of the largest frequency: there a spectral density has its last slope
_GROWS = "There is no stationary mean square: the noise that multiplies x feeds more than is dissipated."
_NOISES = WhiteNoise | ColoredNoise | KanaiTajimiNoise | CloughPenzienNoise | PoissonImpulses | SpectralExcitation
_COVERED = Coverage(
    "The linear theory covers linear springs, dampers, memory and circuits, without walls and contacts",
    INERTIA | SPRINGS | DAMPERS | MEMORY | Constant | Harmonic | _NOISES | ParametricNoise | ThermalNoise,
    linear=PolynomialSpring | PolynomialDashpot,
    nonlinear="",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Companion:
    """A linear system: what its spectra are made of.

    Parameters
    ----------
    coordinates : Coordinates
        Its points, from which the rows of its parts follow.
    mass, stiffness, damping : ndarray, shape (coordinates, coordinates)
        Of springs and dashpots.
    elements : tuple
        Elements with memory: each has ``modulus(p)``.
    circuits : tuple of Circuit
    noises : tuple
        Stationary noises, each with ``density(w)``.
    temperature : float
        kT of matched noise; 0 without.
    harmonics : tuple of Harmonic
    force : ndarray, shape (coordinates,)
        Constant force.
    parametric : tuple of ParametricNoise
        Noises that multiply elongations.
    multiplied : tuple of (ndarray, float)
        What such noise is once its elongation is known: a row, and the intensity of white noise along it.
    """

    coordinates: Coordinates
    mass: Floats
    stiffness: Floats
    damping: Floats
    elements: tuple[Element, ...]
    circuits: tuple[Circuit, ...]
    noises: tuple[Any, ...]
    temperature: float
    harmonics: tuple[Harmonic, ...]
    force: Floats
    parametric: tuple[ParametricNoise, ...]
    multiplied: tuple[tuple[Floats, float], ...] = ()

    def row(self, part: Element) -> Floats:
        """What a part sees of the coordinates."""
        return self.coordinates.row(part.between)

    def push(self, part: Any) -> Floats:
        """The forces of an excitation per unit of it."""
        return self.coordinates.push(part.on)

    def along(self, part: Element, number: Any) -> Any:
        """A number of a part, or one for each frequency, in the equations of motion."""
        return _wide(np.asarray(number)) * np.outer(self.row(part), self.row(part))

    def dissipative(self, w: Floats) -> Complexes:
        """Force over displacement of dampers, memory and circuits, a matrix for each of the frequencies w."""
        p = 1j * np.asarray(w, float)
        found = self.damping * _wide(p)
        for element in (*self.elements, *self.circuits):
            found = found + self.along(element, element.modulus(p))
        return np.asarray(found)

    def dynamic_stiffness(self, w: Floats) -> Complexes:
        """Force over displacement, D(w) = k - m w^2 + ..."""
        return np.asarray(self.stiffness - _wide(np.asarray(w, float) ** 2) * self.mass + self.dissipative(w))

    def response(self, w: Floats) -> Complexes:
        """Displacement over force, the inverse of D(w)."""
        stiffness = self.dynamic_stiffness(w)
        return np.asarray(1.0 / stiffness if stiffness.shape[-1] == 1 else np.linalg.inv(stiffness))

    def displaced(self, w: Floats, forces: Any) -> Complexes:
        """Displacements of the coordinates under forces on them at frequencies w, shape (frequencies, coordinates).

        Of the row of a point, they are what that point sees of forces on each.
        """
        stiffness = self.dynamic_stiffness(w)
        if stiffness.shape[-1] == 1:
            return np.asarray(forces / stiffness[..., 0])
        wide = np.broadcast_to(forces, stiffness.shape[:-1])
        return np.asarray(np.linalg.solve(stiffness, wide[..., None])[..., 0])

    def nearest(self, w: Floats) -> Complexes:
        """The eigenvalue of D(w) per mass that is nearest to 0, which it passes at a resonance."""
        stiffness = self.per_mass(self.dynamic_stiffness(w))
        values = stiffness[..., 0] if stiffness.shape[-1] == 1 else np.linalg.eigvals(stiffness)
        place = np.abs(values).argmin(axis=-1)
        return np.asarray(np.take_along_axis(values, place[..., None], axis=-1)[..., 0])

    def per_mass(self, matrix: Any) -> Any:
        """A matrix divided by the masses from both sides, symmetric as before."""
        return self._root @ matrix @ self._root.T

    @cached_property
    def _root(self) -> Floats:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.mass)))

    def sources(self, w: Floats) -> list[tuple[Floats, Floats]]:
        """Each noise: its push, and its two-sided spectral density per rad/s at frequencies w >= 0."""
        found = [(push, _at(density, w)) for push, density in self.groups]
        if not self.temperature > 0.0:
            return found
        hot = self.temperature / math.pi
        sizes, ways = np.linalg.eigh(self.damping)
        found += [(way, np.full(w.shape, hot * float(size))) for size, way in zip(sizes, ways.T, strict=True)]
        small = np.maximum(w, 1e-150)
        for element in (*self.elements, *self.circuits):
            loss = hot * np.imag(element.modulus(1j * small)) / small
            springpot = springpot_in(element)  # of which the noise is unbounded at low frequency
            fractional = springpot is not None and springpot.remembers
            found.append((self.row(element), np.where((w == 0.0) & fractional, math.inf, loss)))
        return found

    @cached_property
    def free(self) -> Floats:
        """Motions that no spring holds, in columns."""
        squares, shapes = free_motion(self.mass, self.stiffness)
        return shapes[:, squares <= _LOOSE * np.abs(squares).max()]

    @property
    def holding(self) -> list[Element]:
        """Springpots, alone or in series with a spring, that keep a mass near its place without a spring beside them.

        The mean square is that of w^(-2 alpha) where noise has a density at 0: finite below order 1/2.
        """
        noisy = bool(self.parametric) or any(noise.density(0.0) > 0.0 for noise in self.noises)
        return [each for each in self.elements if 0.0 < order_at_rest(each) < (0.5 if noisy else 1.0)]

    @property
    def at_rest(self) -> Floats:
        """Displacements under the constant force after a long time.

        Where only springpots hold, the one of the lowest order relaxes last: its force is 0 there.
        """
        if not self.free.shape[1]:
            return np.asarray(np.linalg.solve(self.stiffness, self.force))
        found = np.linalg.lstsq(self.stiffness, self.force, rcond=None)[0]
        first = min(map(order_at_rest, self.holding))
        last = [
            (each, springpot) for each in self.holding if (springpot := springpot_in(each)) and springpot.order == first
        ]
        pulls = sum(self.along(each, springpot.coefficient) for each, springpot in last)
        slipped = np.linalg.lstsq(self.free.T @ pulls @ self.free, self.free.T @ pulls @ found)[0]
        return np.asarray(found - self.free @ slipped)

    def integrals(self, densities: Callable[[Floats], Floats], within: Floats) -> Floats:
        """Of densities over all frequencies, as `springpot.theory.numerics.frequencies.integrals`."""
        return integrals(densities, self._cuts, within, as_powers=bool(self.free.shape[1]))

    @cached_property
    def _cuts(self) -> list[float]:
        """Where all integrals of this system are cut."""
        return resonances(self.nearest, self.scales)

    @property
    def groups(self) -> list[tuple[Floats, Density]]:
        """The noises but matched noise: their pushes and densities."""
        white = [(row, _flat(intensity)) for row, intensity in self.multiplied]
        return [*((self.push(noise), noise.density) for noise in self.noises), *white]

    @property
    def scales(self) -> list[float]:
        """Frequencies around which something changes."""
        squares, rates = self._squares(self.stiffness) or [0.0], self._squares(self.damping)
        found = [
            *map(math.sqrt, squares),
            *rates,
            *(square / rate for square in squares for rate in rates if rate > 0.0),
        ]
        for element in (*self.elements, *self.circuits):
            share = self._share(element)
            for square in squares:
                found += element.scales(square, share)
        for noise in self.noises:
            found += noise.scales()
        return [scale for scale in found if scale > 0.0]

    def _squares(self, matrix: Any) -> list[float]:
        """Eigenvalues per mass."""
        values = np.linalg.eigvalsh(self.per_mass(matrix))
        return [float(value) for value in values if value > _LOOSE * np.abs(values).max()]

    def _share(self, part: Element) -> float:
        """One over the mass that moves where both ends of a part are free."""
        return float(self.row(part) @ np.linalg.solve(self.mass, self.row(part)))

    @property
    def dissipates(self) -> bool:
        """Whether anything takes energy from the motion."""
        return bool(np.any(self.damping > 0.0)) or bool(self.lossy)

    @property
    def lossy(self) -> list[Element]:
        """The elements and circuits that take energy."""
        return [each for each in (*self.elements, *self.circuits) if each.dissipates]


def _flat(intensity: float) -> Density:
    return lambda w: intensity / (2.0 * math.pi)


def _at(density: Density, w: Floats) -> Floats:
    return np.array([density(each) for each in w.ravel().tolist()]).reshape(w.shape)


def _wide(numbers: Any) -> Any:
    """Numbers before a matrix each."""
    return numbers[..., None, None]


@dataclass(frozen=True)
class LinearResponse(Result):
    """The stationary state of a linear system, and how it responds at a frequency.

    Notes
    -----
    The parameters are those of `springpot.theory.result.Result`, and the linear system.
    """

    companion: Companion = field(compare=False)

    @np.errstate(all="ignore")  # of what is not finite
    def frequency_response(self, frequency: ArrayLike, of: str = "", on: str = "") -> Complexes:
        """Displacement over force, in m/N (s^2 in a system without a `Mass`).

        Parameters
        ----------
        frequency : array_like
            w in rad/s.
        of : str
            The point whose displacement it is, or the part with two ends whose elongation it is; needed where there
            are several masses.
        on : str
            The point on which the force acts, or ``"ground"`` for its acceleration; needed where there are several.

        Raises
        ------
        TypeError, ValueError
            If a frequency is not a number, or there is no such point or part.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(0.4), sp.WhiteNoise(1.0))
        >>> complex(sp.theory.linear(device).frequency_response(2.0))
        -1.25j
        """
        w = real_array(frequency, "frequency")
        row, push = self._row(of), self._push(on)
        return np.asarray(self.companion.response(w) @ push @ row)

    @np.errstate(all="ignore")  # of what is not finite
    def spectrum(self, frequency: ArrayLike, of: str = "") -> Floats:
        """Two-sided spectral density of x, in m^2 s per rad, without the lines of harmonic forces.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.
        of : str
            The point whose displacement it is, or the part with two ends whose elongation it is; needed where there
            are several masses.  Or a force or absolute acceleration by its name in ``forces`` of `springpot.simulate`:
            ``"mount_force"``, ``"force_on_ground"`` (N^2 s per rad), ``"acceleration"``, ``"box_acceleration"``.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        NotCoveredError
            If the force is that of an inerter, or has matched noise in it.
        TypeError, ValueError
            If a frequency is not a number, or there is no such point, part or force.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0))
        >>> response = sp.theory.linear(device)
        >>> float(response.spectrum(1.0).round(4)), float(response.spectrum(1.0, of="springpot_force").round(4))
        (0.1592, 0.1592)
        """
        return self._spectrum(of)(np.abs(real_array(frequency, "frequency")))

    def _spectrum(self, of: str) -> Callable[[Floats], Floats]:
        """The spectral density at frequencies w >= 0: what an integral asks many times."""
        _ = self.moments
        if text(of, "of") in outputs_of(self.system):
            return output_spectrum(self.system, self.companion, of)
        row = self._row(of, *outputs_of(self.system))[None, :]
        return lambda w: np.asarray(_quadratic(self.companion, w, row)[..., 0, 0].real)

    def mean_square(self, of: str) -> float:
        """The mean square of a force or an absolute acceleration; those of displacements are in the moments.

        Parameters
        ----------
        of : str
            As in `spectrum`.

        Returns
        -------
        float
            In N^2, or m^2 s^-4.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        NotCoveredError
            If it is not finite: white noise on the mass itself, or matched noise of the part.
        ValueError
            If there is no such force or acceleration.

        Examples
        --------
        A mass on a springpot mount above a shaking ground:

        >>> import springpot as sp
        >>> device = sp.System(
        ...     sp.Mass(2.0), sp.Spring(8.0), mount=sp.Springpot(0.5, 1.0), shaking=sp.WhiteNoise(1.0, on="ground")
        ... )
        >>> response = sp.theory.linear(device)
        >>> round(response.mean_square("mount_force"), 4), round(response.mean_square("acceleration"), 4)
        (0.9629, 9.6609)
        """
        _ = self.moments
        return output_mean_square(self.system, self.companion, text(of, "of"))

    def spectral_moments(self, orders: Sequence[float], of: str = "") -> dict[float, float]:
        """Integrals of the spectral density times w to some powers, over all frequencies; infinite where they are.

        The law must be Gaussian: that of noise without impulses.

        Parameters
        ----------
        orders : sequence of float
            The powers: 0 for the variance, 2 for that of the rate.
        of : str
            As in `spectrum`.

        Raises
        ------
        NotCoveredError
            If the response is not Gaussian, or as `spectrum`.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(4.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
        >>> {order: round(moment, 6) for order, moment in sp.theory.linear(device).spectral_moments((0, 2, 4)).items()}
        {0: 0.25, 2: 1.0, 4: inf}
        """
        orders = items_of(orders, "orders must be a list of powers")
        for order in orders:
            finite_number(order, "order", low=0.0)
        if rough := [name for name, noise in self.system.excitations.items() if not noise.is_gaussian]:
            raise NotCoveredError(f"Only Gaussian responses are covered, which that to {listed(rough)} is not.")
        spectrum, far = self._spectrum(of), _FAR * max(self.companion.scales)
        last, beyond = spectrum(np.array([far, 2.0 * far]))
        slope = -math.log2(beyond / last) if last > 0.0 else math.inf
        finite = [order for order in orders if slope >= order + 1.01]  # of others the density falls too slowly

        def weighted(w: Floats) -> Floats:
            return np.asarray(spectrum(w)[:, None] * w[:, None] ** finite)

        found = self.companion.integrals(weighted, np.zeros(len(finite))).tolist()
        return {**dict.fromkeys(orders, math.inf), **dict(zip(finite, found, strict=True))}

    def crossing_rate(self, level: float, of: str = "") -> float:
        """Rice's mean rate of upward crossings of a level, in 1/s.

        Parameters
        ----------
        level : float
            In m, N or m/s^2.
        of : str
            As in `spectrum`.

        Returns
        -------
        float
            Infinite where the rate of change has no finite variance, as of a dashpot's force under white noise.

        Raises
        ------
        NotCoveredError
            As `spectral_moments`.

        References
        ----------
        S. O. Rice, "Mathematical analysis of random noise", Bell System Technical Journal 23 and 24 (1944, 1945).

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(4.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
        >>> round(sp.theory.linear(device).crossing_rate(1.0), 4)  # exp(-2) / pi: two standard deviations
        0.0431
        """
        finite_number(level, "level", low=-LARGEST, high=LARGEST)
        variance, speed = self.spectral_moments((0.0, 2.0), of).values()
        if not 0.0 < variance < math.inf:
            return 0.0 if variance == 0.0 else math.inf
        apart = level - self.mean(of)
        return math.sqrt(speed / variance) / (2.0 * math.pi) * math.exp(-0.5 * apart**2 / variance)

    @np.errstate(all="ignore")  # of what is not finite
    def density(self, values: ArrayLike, of: str = "") -> Floats:
        """The probability density, which is Gaussian, in one over the unit.

        Parameters
        ----------
        values : array_like
            In m, N or m/s^2.
        of : str
            As in `spectrum`.

        Raises
        ------
        NotCoveredError
            As `spectral_moments`, or if the variance is not finite.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0, on="ground"))
        >>> sp.theory.linear(device).density([0.0, 2.0], of="acceleration").round(4)
        array([0.1935, 0.1209])
        """
        variance = self.spectral_moments((0.0,), of)[0.0]
        if not 0.0 < variance < math.inf:
            raise NotCoveredError(f"{of or 'x'} has no density: its variance is {variance:g}.")
        apart = real_array(values, "values") - self.mean(of)
        return np.asarray(np.exp(-0.5 * apart**2 / variance) / math.sqrt(2.0 * math.pi * variance))

    def mean(self, of: str = "") -> float:
        """The mean of a displacement, an elongation, a force or an absolute acceleration.

        Parameters
        ----------
        of : str
            As in `spectrum`.

        Returns
        -------
        float
            In m, N or m s^-2.

        Raises
        ------
        NotCoveredError, ValueError
            As `spectrum`.

        Examples
        --------
        >>> import springpot as sp
        >>> hung = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(1.0), sp.Constant(-4.0), sp.WhiteNoise(1.0))
        >>> sp.theory.linear(hung).mean(), sp.theory.linear(hung).mean("spring_force")
        (-0.5, -4.0)
        """
        if text(of, "of") in outputs_of(self.system):
            return output_mean(self.system, self.companion, of)
        row = self._row(of, *outputs_of(self.system))
        return float(row @ self.companion.at_rest)

    @np.errstate(all="ignore")  # of what is not finite
    def spectral_matrix(self, frequency: ArrayLike) -> Complexes:
        """Two-sided spectral and cross-spectral densities of the displacements of all points, in m^2 s per rad.

        Parameters
        ----------
        frequency : array_like
            In rad/s, of either sign.

        Returns
        -------
        ndarray, shape (..., points, points)

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError
            If a frequency is not a number.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0))
        >>> sp.theory.linear(device).spectral_matrix(1.0).real.round(4).tolist()
        [[0.1592]]
        """
        w = real_array(frequency, "frequency")
        _ = self.moments
        found = _quadratic(self.companion, np.abs(w), self.system.coordinates.rows)
        return np.asarray(np.where(_wide(w) < 0.0, found.conj(), found))

    def covariance(self, of: Literal["x", "v"] = "x") -> Floats:
        """Covariances of the displacements, or of the velocities, of all points at one time.

        Parameters
        ----------
        of : {"x", "v"}

        Returns
        -------
        ndarray, shape (points, points)
            In m^2, or m^2 s^-2.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        ValueError
            If ``of`` is another word.

        Examples
        --------
        >>> import springpot as sp
        >>> chain = sp.System(
        ...     sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a")),
        ...     sp.Spring(1.0, between=("a", "b")), sp.Dashpot(0.2, between=("a", "b")), sp.ThermalNoise(1.0),
        ... )
        >>> sp.theory.linear(chain).covariance().round(9).tolist()
        [[1.0, 1.0], [1.0, 2.0]]
        """
        one_of(of, "of", ("x", "v"))
        moments, points = self.moments, self.system.points
        at = self.system.coordinates
        both = [[moments[f"{own}{name}"] for name in ("x_mean", f"{of}_mean_square")] for own in at.beginnings]
        means, squares = np.array(both).T
        squares = squares - means**2 * (of == "x")
        found, size = np.diag(squares), np.sqrt(squares)
        pairs = [each for each in itertools.combinations(range(len(points)), 2) if size[[*each]].all()]
        shares = np.diag(0.5 / np.where(size > 0.0, size, 1.0)) @ at.rows
        rows = np.array([shares[one] + shares[other] for one, other in pairs])  # mean squares: (1 + correlation) / 2
        motions = _Seen(self.companion).motions(rows, (1e-16, 1e-16), of == "v") if pairs else []
        for (one, other), (mean, x_square, v_square) in zip(pairs, motions, strict=True):
            half = x_square - mean**2 if of == "x" else v_square
            found[one, other] = found[other, one] = (2.0 * half - 1.0) * size[one] * size[other]
        return np.asarray(found)

    def _row(self, of: str, *outputs: str) -> Floats:
        """The row of a displacement or an elongation; ``outputs``: what else the caller takes."""
        at = self.system.coordinates
        if text(of, "of") in (known := {**at.elongations, **at.called}):
            return known[of]
        raise ValueError(f"of must be one of {listed([*at.points, *at.elongations, *outputs], 'or')}{_not_one(of)}.")

    def _push(self, on: str) -> Floats:
        at = self.system.coordinates
        if text(on, "on") in (*at.called, "ground"):
            return at.push(on)
        raise ValueError(f"on must be one of {listed([*at.points, 'ground'], 'or')}{_not_one(on)}.")


def _not_one(given: str) -> str:
    """The end of a sentence about a name that is none of those asked for, or was left out."""
    return f", not {shown(given)}" if given else " where there are several masses"


def _quadratic(companion: Companion, w: Floats, rows: Floats) -> Complexes:
    """The spectral densities of what rows see, between each other."""
    found = np.zeros((*w.shape, len(rows), len(rows)), complex)
    response = rows @ companion.response(w)
    for push, density in companion.sources(w):
        seen = response @ push
        both, wide = seen[..., :, None] * seen[..., None, :].conj(), _wide(density)
        found += both.real * np.where(both.real == 0.0, 0.0, wide)  # not infinity times 0
        found += 1j * both.imag * np.where(np.isfinite(wide), wide, 0.0)
    return found


@np.errstate(all="ignore")  # what is not finite is no answer
def linear(system: System) -> LinearResponse:
    """The exact stationary moments of a linear system without walls.

    Parameters
    ----------
    system : System
        Linear springs, dashpots, springpots, arms and circuits; constant, harmonic, white, colored, filtered, Poisson,
        parametric and thermal excitation.

    Returns
    -------
    LinearResponse
        Its moments are those of the equation of motion, to about 1e-9 of their size.

    Raises
    ------
    NotCoveredError
        If the system has a wall, a contact or something nonlinear; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    <x^2> = int S(w) / \\|D(w)\\|^2 dw and <v^2> with w^2.  A harmonic force F cos(nu t + phase) of random phase adds
    F^2 / (2 \\|D(nu)\\|^2).  x does not depend on the future of the noise xi2 that multiplies it.  So the force x xi2
    acts like a white noise of intensity q2 <x^2>, for any memory.  Of several masses this holds with their elongations,
    whose mean squares solve a linear system.

    Examples
    --------
    A harvester with a springpot:

    >>> import springpot as sp
    >>> harvester = sp.System(
    ...     sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.PiezoelectricCircuit(0.5, 3.2, 0.625), sp.WhiteNoise(1.0)
    ... )
    >>> result = linear(harvester)
    >>> round(result.x_mean_square, 5), round(result.harvested_power, 5)
    (1.17038, 0.18032)
    """
    system = checked_system(system)
    companion = companion_of(system)
    settled = _settled(companion)
    stationary = settled if isinstance(settled, str) else linear_moments(system, settled)
    return LinearResponse(
        method="linear",
        system=system,
        stationary=stationary,
        assumptions=("None: this solves the linear equation of motion as it stands, with memory of the whole past.",),
        warnings=(),
        is_exact=True,
        companion=companion if isinstance(settled, str) else settled,
    )


def companion_of(system: System, *, over: bool = False, reach: str = _COVERED.reach) -> Companion:
    """The linear system, or the sentence that names the part which is not linear; ``over`` time, with envelopes.

    ``reach``: how that sentence begins.

    Raises
    ------
    NotCoveredError
        If there is a wall, a contact or something nonlinear.
    """
    replace(_COVERED, reach=reach).check(system, over=over)
    at, parts = system.coordinates, [part for _, part in system.named()]
    return Companion(
        coordinates=at,
        mass=at.mass,
        stiffness=at.sum_of({name: part.linear_stiffness for name, part in system.elements.items()}),
        damping=at.sum_of({name: part.linear_damping for name, part in system.elements.items()}),
        elements=tuple(part for part in parts if part.has_modulus and not part.of_load),
        circuits=tuple(part for part in parts if part.of_load),
        noises=tuple(noise for noise in system.excitations.values() if noise.has_density),
        temperature=system.temperature,
        harmonics=system.of(Harmonic),
        force=system.constant_force,
        parametric=system.of(ParametricNoise),
    )


check_covered = companion_of


def linear_moments(system: System, companion: Companion) -> Moments | str:
    """The stationary moments of a linear system, or why there are none."""
    if isinstance(settled := _settled(companion), str):
        return settled
    companion, power = settled, 0.0
    seen = _Seen(companion)
    if companion.groups:
        power += seen.power(companion.groups)
    for force in companion.harmonics:
        power += seen.power_of_harmonic(force)
    harvested = power if companion.circuits and companion.temperature == 0.0 else None
    at = system.coordinates
    rows = np.array([*at.pairs.values()]).reshape(-1, len(at.masses))
    pairs = seen.motions_within(rows, velocity=False)
    return moments_of(system, seen.motions(at.rows), pairs, harvested=harvested)


def _settled(companion: Companion) -> Companion | str:
    """The system with springpots of order 0 as the springs that they are; or why it has no stationary state.

    Noise that multiplies elongations is then known white noise.
    """
    springs = [element for element in companion.elements if element.has_equivalent]
    if springs:
        static = companion.stiffness + sum(companion.along(spring, spring.static_stiffness) for spring in springs)
        kept = tuple(element for element in companion.elements if element not in springs)
        companion = replace(companion, stiffness=static, elements=kept)
    if statement := _endless(companion):
        return statement
    return _known(companion) if companion.parametric else companion


def _known(companion: Companion) -> Companion | str:
    """With the white noise that stands for noise which multiplies elongations; or that it has no mean square.

    The mean squares of the elongations are those without it, and what each such noise adds to each.
    """
    seen, rows = _Seen(companion), np.array([companion.row(noise) for noise in companion.parametric])
    alone = np.array([x_square for _, x_square, _ in seen.motions(rows, velocity=False)])
    unit = np.array([seen.mean_squares(rows, [(row, _flat(1.0))]) for row in rows]).T
    intensity = np.array([noise.intensity for noise in companion.parametric])
    added = unit * intensity
    if not np.abs(np.linalg.eigvals(added)).max() < 1.0 - _LOOSE:
        return _GROWS
    squares = np.linalg.solve(np.eye(len(rows)) - added, alone)
    return replace(companion, parametric=(), multiplied=tuple(zip(rows, (intensity * squares).tolist(), strict=True)))


def motions(companion: Companion, rows: Sequence[Floats]) -> list[tuple[float, float, float]] | str:
    """Mean and mean square of what each row sees of the displacements, and mean square of its velocity.

    If there is no stationary state, why.
    """
    if isinstance(settled := _settled(companion), str):
        return settled
    return _Seen(settled).motions_within(np.array(rows)) if rows else []


def pulled(companion: Companion, arms: Sequence[Maxwell]) -> list[tuple[float, float]] | str:
    """Mean squares of the velocity of each arm's elongation and of its force under noise; or why there are none."""
    if isinstance(settled := _settled(companion), str):
        return settled
    seen, found = _Seen(settled), []

    def strained(density: Density, arm: Maxwell) -> Density:
        return lambda w: density(w) * abs(arm.modulus(1j * w)) ** 2

    for arm in arms:
        row = companion.row(arm)[None, :]
        forces = [(push, strained(density, arm)) for push, density in settled.groups]
        found.append((seen.motions_within(row)[0][2], float(seen.mean_squares(row, forces)[0])))
    return found


def _endless(companion: Companion) -> str:
    """Why there is no stationary state, in one sentence; empty if there is one."""
    end = "There is no stationary state: {}.".format
    squares, shapes = free_motion(companion.mass, companion.stiffness)
    if companion.free.shape[1] and (statement := _wanders(companion)):
        return end(statement)
    if not companion.dissipates:
        return end("nothing dissipates energy")
    sizes, dashpots = np.linalg.eigh(companion.damping)
    rows = [way for size, way in zip(sizes, dashpots.T, strict=True) if size > _LOOSE * sizes.max()]
    free = unseen_mode(squares, shapes, [*rows, *map(companion.row, companion.lossy)])
    return "" if free is None else end(f"nothing dissipates the energy of the mode at {free:.6g} rad/s")


def _wanders(companion: Companion) -> str:
    """Why motions that no spring holds have no stationary state; empty where springpots keep them near their place."""
    free = companion.free
    if left := _moved(companion.coordinates, free @ _unseen([companion.row(each) for each in companion.holding], free)):
        words = companion.coordinates.said(left)
        fate = "it wanders" if len(left) == 1 else "they wander"
        springpots = any(order_at_rest(each) < 1.0 for each in companion.elements)
        weak = ", and a springpot alone does so below order 1/2 only" if springpots else ""
        return f"no spring pulls {words} back{weak}, so that {fate} without end"
    if companion.temperature > 0.0:
        return "no spring pulls back what thermal noise moves, so that it wanders without end"
    pushed = np.abs(companion.force @ free).max() > _LOOSE * np.abs(companion.force).sum()
    return "a springpot alone yields to a constant force without end" if pushed else ""


def _unseen(rows: Sequence[Floats], motions: Floats) -> Floats:
    """The combinations of some motions that no row sees, in columns."""
    _, sizes, ways = np.linalg.svd(np.array(rows).reshape(-1, len(motions)) @ motions)
    return np.asarray(ways[(sizes > 1e-9 * sizes.max(initial=0.0)).sum() :].T)


def _moved(at: Coordinates, motions: Floats) -> list[str]:
    """The points that some of these motions move."""
    sizes = np.abs(at.rows @ motions).max(axis=1, initial=0.0)
    return [point for point, size in zip(at.points, sizes, strict=True) if size > 1e-6 * sizes.max()]


class _Seen:
    """What rows of numbers see of the motion: means and mean squares, by integrals over frequency."""

    def __init__(self, companion: Companion) -> None:
        self.companion = companion

    def under(self, force: Harmonic, row: Floats) -> float:
        """The mean square displacement that a row sees of a harmonic force."""
        own = self.companion
        response = complex(row @ own.response(np.array([force.frequency]))[0] @ own.push(force))
        return 0.5 * force.amplitude**2 * abs(response) ** 2

    def mean_squares(
        self,
        rows: Floats,
        groups: list[tuple[Floats, Density]],
        power: int = 0,
        within: float | Floats = 0.0,
    ) -> Floats:
        """Of what rows see of the displacement, or with ``power=1`` of the velocity, under noises."""

        def together(w: Floats) -> Floats:
            response = rows @ self.companion.response(w)
            found = np.zeros((len(w), len(rows)))
            for push, density in groups:
                found += (_at(density, w) * w ** (2 * power))[:, None] * np.abs(response @ push) ** 2
            return found

        return self.companion.integrals(together, np.broadcast_to(within, len(rows)))

    def motions(
        self, rows: Floats, within: tuple[Any, Any] = (0.0, 0.0), velocity: bool = True
    ) -> list[tuple[float, float, float]]:
        """Mean and mean square of the displacement that each row sees, and mean square of its velocity if asked.

        ``within`` are errors of the two mean squares that do not matter.
        """
        own = self.companion
        x_noise = v_noise = np.zeros(len(rows))
        if own.groups:
            x_noise = self.mean_squares(rows, own.groups, 0, within[0])
            v_noise = self.mean_squares(rows, own.groups, 1, within[1]) if velocity else v_noise
        return [self._motion(*each) for each in zip(rows, x_noise.tolist(), v_noise.tolist(), strict=True)]

    def motions_within(self, rows: Floats, velocity: bool = True) -> list[tuple[float, float, float]]:
        """The same, where an elongation that never happens is known within a share of the motion of its ends."""
        if rows.shape[1] == 1 or not len(rows):
            return self.motions(rows, velocity=velocity)
        sizes = np.sqrt(np.array(self.motions(np.eye(rows.shape[1]), velocity=velocity))[:, 1:])
        x, v = (_ELONGATION * (np.abs(rows) @ sizes) ** 2).T
        return self.motions(rows, (x, v), velocity)

    def _motion(self, row: Floats, x_noise: float, v_noise: float) -> tuple[float, float, float]:
        own = self.companion
        # matched noise shares its energy out evenly
        light, x_mean, x_square = np.linalg.solve(own.mass, row), float(row @ own.at_rest), x_noise
        if own.temperature > 0.0:
            x_square += own.temperature * float(np.linalg.solve(own.stiffness, row) @ row)
        v_square = own.temperature * float(light @ row) + v_noise
        for force in own.harmonics:
            response = self.under(force, row)
            x_square += response
            v_square += response * force.frequency**2
        return x_mean, x_square + x_mean**2, v_square

    def power(self, groups: list[tuple[Floats, Density]]) -> float:
        """Mean of the power that all circuits deliver under noises."""

        def weighted(density: Density, circuit: Circuit) -> Density:
            return lambda w: density(w) * circuit.load_square(w)

        found = []
        for circuit in self.companion.circuits:
            volts = [(push, weighted(density, circuit)) for push, density in groups]
            found.append(float(self.mean_squares(self.companion.row(circuit)[None, :], volts)[0]) / circuit.load)
        return math.fsum(found)

    def power_of_harmonic(self, force: Harmonic) -> float:
        """The same under a harmonic force."""
        return sum(
            self.under(force, self.companion.row(c)) * c.load_square(force.frequency) / c.load
            for c in self.companion.circuits
        )
