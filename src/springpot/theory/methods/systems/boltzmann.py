"""The exact law of several masses at one temperature: Boltzmann's, by quadrature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.parts import (
    Constant,
    Contact,
    PolynomialDashpot,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.potential import Potential
from springpot.problem.system import System
from springpot.theory.coverage import DAMPERS, INERTIA, MEMORY, SPRINGS, STOPS, Coverage
from springpot.theory.normal_modes import free_motion, unseen_mode
from springpot.theory.numerics.simplices import cut, facets_on, integral, simplices_of_box
from springpot.theory.result import Moments, NoStationaryStateError, moments_of

_REACH = (
    "The exact law of several masses covers springs, elastic walls and contacts without dissipation, with "
    "ThermalNoise, or with white noise that is to the dashpots as noise of one temperature"
)
_COVERED = Coverage(
    _REACH,
    INERTIA | SPRINGS | DAMPERS | MEMORY | STOPS | Constant | ThermalNoise | WhiteNoise,
    linear=PolynomialDashpot,
)
_MOST = 3  # coordinates that are integrated over together
_ROUGH, _FINE = 1e-2, {1: 1e-8, 2: 1e-8, 3: 1e-6}  # between two rules, by coordinates: more than is left of the finer
_FAR = 36.0  # energy over kT above the least that is left out
_START, _GROWTH, _GROWTHS = 6.0, 1.5, 80  # of the box, in standard deviations
_ROUNDS = 3  # of the box's axes
_SMALL = 1e-10
_CLOSE = 1e-9  # of noise and damping that have one temperature


def exact_of_points(system: System) -> Moments | str:
    """The moments of one or several masses, or why there are none.

    The elongations with walls, contacts or nonlinear springs are the coordinates of a quadrature over simplices that
    are cut at walls and at the ends of contacts; the rest is normal, and independent of them in coordinates in which
    the linear springs do not couple both.  A wall at b is struck at the rate p(b) sqrt(kT / 2 pi m), with p the density
    of its elongation and m the reduced mass of its two ends, and with the mean force kT p(b).
    """
    temperatures = check_points_covered(system)
    try:
        return temperatures if isinstance(temperatures, str) else _moments(system, temperatures)
    except NoStationaryStateError as endless:
        return str(endless)


def check_points_covered(system: System) -> Floats | str:
    """kT at each point, or why there is no stationary state; `NotCoveredError` for what is not covered."""
    _COVERED.check(system)
    _COVERED.check_elastic(system)
    at = system.coordinates
    elements, thermal = system.elements, system.temperature
    damping = at.sum_of({name: part.dashpot for name, part in elements.items()})
    noises = system.excitations
    white = sum((noises[name].white_intensity * np.outer(g, g) for name, g in at.forces.items()), 0.0 * damping)
    found = np.zeros(len(at.masses))
    joined = sum((np.outer(np.abs(row), np.abs(row)) for row in at.elongations.values()), np.abs(at.mass))
    for own in _groups(joined > 0.0):
        here, block = [at.names[place] for place in own], np.ix_(own, own)
        remembers = [name for name, part in elements.items() if part.remembers and at.elongations[name][own].any()]
        if not remembers and not damping[block].any():
            return f"There is no stationary state: nothing dissipates the energy of {listed(here)}."
        found[own] = thermal
        if not white[block].any():
            continue
        if remembers:
            beside = "beside it" if thermal else "without ThermalNoise"
            raise NotCoveredError(f"{_REACH}, not white noise {beside} with {remembers[0]}.")
        hot = float(np.vdot(white[block], damping[block]) / np.vdot(damping[block], damping[block]))
        if np.abs(white[block] - hot * damping[block]).max() > _CLOSE * white[block].max():
            raise NotCoveredError(f"{_REACH}; the white noise of {listed(here)} is not.")
        found[own] += 0.5 * hot
    seen = [at.elongations[name] for name, part in elements.items() if part.dissipates or _is_bent(part)]
    free = unseen_mode(*free_motion(at.mass, system.stiffness_matrix), seen)
    if free is not None:
        return f"There is no stationary state: nothing dissipates the energy of the mode at {free:.6g} rad/s."
    if cold := [point for point, hot in zip(at.names, found, strict=True) if not hot > 0.0]:
        return f"There is no random stationary state: nothing excites the motion of {listed(cold)}."
    return found


def _groups(joined: NDArray[np.bool_]) -> Iterator[NDArray[np.intp]]:
    """The places that are joined, directly or through others."""
    from scipy.sparse.csgraph import connected_components  # slow to import, and runs need none of it

    count, labels = connected_components(joined, directed=False)
    for label in range(count):
        yield np.flatnonzero(labels == label)


@dataclass(frozen=True, eq=False)
class _Law:
    """exp(-U) in some coordinates y, U = y K y / 2 - f y + terms, between walls; energies are over kT.

    Each term has a row, a place from which its elongation counts and its energy; each wall a row that points inwards
    and the least that it leaves.
    """

    stiffness: Floats
    force: Floats
    terms: tuple[tuple[Floats, float, Potential], ...]
    walls: tuple[tuple[Floats, float], ...]

    def energy(self, y: Floats) -> Floats:
        """U of points, shape (points, axes)."""
        found = 0.5 * np.einsum("pi,ij,pj->p", y, self.stiffness, y) - y @ self.force
        for row, place, potential in self.terms:
            found = found + potential.energy(y @ row + place)
        return np.asarray(found)

    @property
    def joined(self) -> NDArray[np.bool_]:
        """Which coordinates a spring couples, or a nonlinear part or wall sees together."""
        size = np.sqrt(np.abs(np.diag(self.stiffness)))
        found = np.abs(self.stiffness) > _SMALL * np.outer(size, size)
        for row in (*(row for row, _, _ in self.terms), *(row for row, _ in self.walls)):
            found |= np.outer(row, row) != 0.0
        return np.asarray(found)

    def on_plane(self, row: Floats, place: float) -> tuple[_Law, Floats, Floats] | None:
        """The law where ``row @ y`` is at a place, y = start + way @ s in its coordinates s; None if walls bar it."""
        start = row * place / float(row @ row)
        way = np.linalg.svd(row[None, :])[2][1:].T
        walls = []
        for own, least in self.walls:
            if np.abs(own @ way).max(initial=0.0) > _SMALL * np.linalg.norm(own):
                walls.append((own @ way, least - float(own @ start)))
            elif float(own @ start) < least - _SMALL * (abs(least) + 1e-300):
                return None
        terms = tuple((own @ way, at + float(own @ start), potential) for own, at, potential in self.terms)
        law = _Law(way.T @ self.stiffness @ way, way.T @ (self.force - self.stiffness @ start), terms, tuple(walls))
        return law, start, way

    def of_block(self, own: NDArray[np.intp]) -> _Law:
        """The law of some coordinates that are independent of the others."""
        terms = tuple((row[own], place, potential) for row, place, potential in self.terms if row[own].any())
        walls = tuple((row[own], least) for row, least in self.walls if row[own].any())
        return _Law(self.stiffness[np.ix_(own, own)], self.force[own], terms, walls)


@dataclass(frozen=True, eq=False)
class _Solved:
    """Moments of a law: the logarithm of its integral, mean, covariance, and means of functions."""

    logarithm: float
    mean: Floats
    covariance: Floats
    means: Floats


def _solved(law: _Law, functions: Sequence[Any] = ()) -> _Solved:
    """The moments of a law; the functions are of points."""
    size = len(law.force)
    if not size:
        point = np.zeros((1, 0))
        means = np.array([float(function(point)[0]) for function in functions])
        return _Solved(-float(law.energy(point)[0]), np.zeros(0), np.zeros((0, 0)), means)
    held = _held(law)
    values, ways = np.linalg.eigh(held)
    middle, axes = np.asarray(np.linalg.solve(held, law.force)), np.asarray(ways / np.sqrt(values))
    for tolerance in (*[_ROUGH] * (_ROUNDS - 1), _FINE[size]):
        simplices, least = _box(law, middle, axes)

        def weighted(s: Floats, middle: Any = middle, axes: Any = axes, least: Any = least) -> Floats:
            y = middle + s @ axes.T
            weight = np.exp(least - law.energy(y))
            squares = [s[:, i] * s[:, j] for i in range(size) for j in range(i, size)]
            more = [function(y) for function in functions]
            return np.asarray(weight * np.array([np.ones(len(s)), *s.T, *squares, *more])).T

        found, _ = integral(weighted, simplices, tolerance, len(functions))
        moments = found[1:] / found[0]
        mean = moments[:size]
        square = np.zeros((size, size))
        square[np.triu_indices(size)] = moments[size : size + size * (size + 1) // 2]
        covariance = np.triu(square) + np.triu(square, 1).T - np.outer(mean, mean)
        logarithm = math.log(float(found[0])) + math.log(abs(float(np.linalg.det(axes)))) - least
        solved = _Solved(
            logarithm,
            middle + axes @ mean,
            axes @ covariance @ axes.T,
            moments[size + size * (size + 1) // 2 :],
        )
        middle, axes = solved.mean, np.asarray(np.linalg.cholesky(solved.covariance))
    return solved


def _held(law: _Law) -> Floats:
    """A stiffness, over kT, of about the size of the law's: where linear springs do not hold, nonlinear ones and walls.

    Only the start of a search.
    """
    values, ways = np.linalg.eigh(law.stiffness)
    found = (ways * np.maximum(values, 0.0)) @ ways.T
    for row, _, potential in law.terms:
        sizes = [abs(k) / (n + 1) for n, k in enumerate(potential.coefficients)]
        widths = [size ** (-1.0 / (n + 1)) for n, size in enumerate(sizes) if size > 0.0]
        widths += [((c.exponent + 1.0) / c.stiffness) ** (1.0 / (c.exponent + 1.0)) for c in potential.contacts]
        if not potential.contacts or _is_loose(found):
            found = found + np.outer(row, row) / min(widths) ** 2
    if _is_loose(found):
        for row, least in law.walls:
            pushed = abs(float(row @ law.force)) / float(row @ row)
            width = max(abs(least), 1.0 / pushed if pushed > 0.0 else 0.0)
            found = found + np.outer(row, row) / width**2
    if _is_loose(found):
        raise NoStationaryStateError("There is no stationary state: no spring or wall holds the masses.")
    return np.asarray(found)


def _is_loose(stiffness: Floats) -> bool:
    values = np.linalg.eigvalsh(stiffness)
    return not values[0] > _SMALL * values[-1]


def _box(law: _Law, middle: Floats, axes: Floats) -> tuple[Floats, float]:
    """Simplices, in units of the axes, of all that is not too high, and the least energy met."""
    size = len(middle)
    low, high = np.full(size, -_START), np.full(size, _START)
    for _ in range(_GROWTHS):
        simplices = simplices_of_box(low, high)
        for row, least in law.walls:
            simplices, _ = cut(simplices, row @ axes, least - float(row @ middle))
        if not len(simplices):
            low, high = low * _GROWTH, high * _GROWTH
            continue
        inside = np.concatenate([simplices.reshape(-1, size), simplices.mean(axis=1)])
        sides = [(axis, end) for axis in range(size) for end in (low, high)]
        on_sides = [facets_on(simplices, axis, float(end[axis])) for axis, end in sides]
        energies = [law.energy(middle + s @ axes.T) for s in (inside, *on_sides)]
        least = min(float(each.min()) for each in energies if each.size)
        growing = [side for side, each in zip(sides, energies[1:], strict=True) if (each < least + _FAR).any()]
        if not growing:
            for row, place, potential in law.terms:
                for contact in potential.contacts:
                    at = contact.position - place - float(row @ middle)
                    simplices = np.concatenate(cut(simplices, row @ axes, at))
            return simplices, least
        for axis, end in growing:
            end[axis] *= _GROWTH
    raise NoStationaryStateError("There is no stationary state: no spring or wall holds the masses.")


def _moments(system: System, temperatures: Floats) -> Moments:
    """The moments at some temperatures, each of points that no part joins to those of another one."""
    at = system.coordinates
    bent = [(name, part, at.elongations[name]) for name, part in system.named() if _is_bent(part)]
    hot = {name: float(temperatures[np.flatnonzero(row)[0]]) for name, _, row in bent}
    stiffness = system.stiffness_matrix / temperatures[:, None]
    force = system.constant_force / temperatures
    rows = _independent([row for _, _, row in bent], len(at.masses))
    ways, rest, spread = _apart(stiffness, rows, at.names)  # x = ways y + rest z
    seen = [(name, part, row @ ways) for name, part, row in bent]
    whole = _Law(
        ways.T @ stiffness @ ways,
        ways.T @ force,
        tuple((row, 0.0, _curve(part, hot[name])) for name, part, row in seen if name not in system.walls),
        tuple((part.inwards * row, part.inwards * part.position) for name, part, row in seen if name in system.walls),
    )
    v_spread = np.linalg.inv(at.mass) * temperatures
    mean, covariance = np.zeros(len(rows)), np.zeros((len(rows), len(rows)))
    hits: dict[str, tuple[float, ...]] = {}
    for own in _groups(whole.joined):
        here = [(name, part, row[own]) for name, part, row in seen if row[own].any()]
        if len(own) > _MOST:
            raise NotCoveredError(
                f"{_REACH}, where at most {_MOST} elongations depend on each other, not the {len(own)} of "
                f"{listed([name for name, *_ in here])}: `simulate` starts from this law."
            )
        law, stops = whole.of_block(own), [each for each in here if each[0] in system.stops]
        soft = {name: _push(part, row) for name, part, row in stops if name in system.contacts}
        solved = _solved(law, [*soft.values()])
        mean[own], covariance[np.ix_(own, own)] = solved.mean, solved.covariance
        pushes = dict(zip(soft, solved.means.tolist(), strict=True))
        for name, part, row in stops:
            density, speed = _density(law, solved, row, part.position), hot[name] / at.reduced(at.elongations[name])
            rate, mean_speed = density * math.sqrt(speed / (2.0 * math.pi)), math.sqrt(0.5 * math.pi * speed)
            hits[name] = rate, mean_speed, 2.0 * speed, pushes.get(name, hot[name] * density)
    x_mean = ways @ mean + rest @ spread @ (rest.T @ force)
    x_spread = ways @ covariance @ ways.T + rest @ spread @ rest.T

    def seen_by(row: Floats) -> tuple[Any, ...]:
        return row @ x_mean, row @ x_spread @ row + (row @ x_mean) ** 2, row @ v_spread @ row

    of_walls = [hits[name] for name in system.stops]
    return moments_of(system, map(seen_by, at.rows), map(seen_by, at.pairs.values()), of_walls)


def _curve(part: Any, hot: float) -> Potential:
    """The energy over kT of a nonlinear spring without its linear part, or of a contact."""
    contacts = () if part.soft_stop is None else (replace(part.soft_stop, stiffness=part.soft_stop.stiffness / hot),)
    return Potential((0.0, 0.0, *(k / hot for k in part.force_coefficients()[2:])), contacts)


def _is_bent(part: Any) -> bool:
    return "stop" in part.powers or part.is_bent


def _push(contact: Contact, row: Floats) -> Any:
    """The force of a contact, as a function of points."""

    def push(y: Floats) -> Floats:
        depth = np.maximum(contact.inwards * (contact.position - y @ row), 0.0)
        return np.asarray(contact.stiffness * depth**contact.exponent)

    return push


def _independent(rows: list[Floats], size: int) -> Floats:
    """As many of the rows as are independent."""
    found = np.zeros((0, size))
    for row in rows:
        more = np.vstack([found, row])
        if np.linalg.matrix_rank(more) == len(more):
            found = more
    return found


def _apart(stiffness: Floats, rows: Floats, points: Sequence[str]) -> tuple[Floats, ...]:
    """x = ways y + rest z with ``rows @ x = y``, such that springs do not couple y and z; and the covariance of z."""
    rest = np.linalg.svd(rows, full_matrices=True)[2][len(rows) :].T if len(rows) else np.eye(len(points))
    ways = np.linalg.pinv(rows)
    held = rest.T @ stiffness @ rest
    if rest.size:
        values, shapes = np.linalg.eigh(held)
        if not values[0] > _SMALL * np.abs(stiffness).max():
            shares = np.abs(rest @ shapes[:, 0])
            loose = [point for point, share in zip(points, shares, strict=True) if share > 1e-6 * shares.max()]
            raise NoStationaryStateError(f"There is no stationary state: no spring pulls {listed(loose)} back.")
        ways = ways - rest @ np.linalg.solve(held, rest.T @ stiffness @ ways)
    return np.asarray(ways), np.asarray(rest), np.asarray(np.linalg.inv(held))


def _density(law: _Law, solved: _Solved, row: Floats, place: float) -> float:
    """Of an elongation at a place."""
    plane = law.on_plane(row, place)
    if plane is None:
        return 0.0
    try:
        there, start, _ = plane
        raised = float(law.energy(start[None, :])[0]) - float(there.energy(np.zeros((1, len(there.force))))[0])
        return math.exp(_solved(there).logarithm - raised - solved.logarithm) / float(np.linalg.norm(row))
    except NoStationaryStateError:  # walls bar it
        return 0.0
