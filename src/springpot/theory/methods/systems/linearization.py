"""Statistical linearization: the linear system that is nearest to a nonlinear one, in mean square."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from scipy import optimize

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import (
    Constant,
    Dashpot,
    Harmonic,
    Maxwell,
    ParametricNoise,
    PolynomialSpring,
    Spring,
    ThermalNoise,
)
from springpot.problem.parts.hysteresis import Yielding
from springpot.problem.potential import Potential
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import unheld
from springpot.theory.methods.systems.energy import exact_law
from springpot.theory.methods.systems.linear import Companion, companion_of, linear_moments, motions, pulled
from springpot.theory.numerics.equations import roots_of
from springpot.theory.result import Moments, NoConvergenceError, NoStationaryStateError, Result

_REACH = "Statistical linearization covers nonlinear springs with one equilibrium and nonlinear dampers, without walls"
_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(40)
_WEIGHTS = _WEIGHTS / math.sqrt(2.0 * math.pi)
_TOLERANCE = 1e-10
_HALFWAY = 40  # steps, before Newton's method, to the arms of parts that yield
_BENT = 0.05  # error of the variance in a bath of springs that bend, beyond which it is said
_NOTHING = 1e-18  # of the largest mean square
_EVEN = 1e-12
_DRIFTS = "The mass drifts, since only parts that yield hold it: x has no stationary law, v has one."
_WEAK = 1e-6  # stiffness that holds such a mass, over that of these parts
_FIRST = np.eye(10)[0]


@dataclass(frozen=True)
class Linearization(Result):
    """The moments of the nearest linear system.

    Parameters
    ----------
    stiffness, damping : float, or ndarray of shape (points, points)
        Of that system, in N/m and N s/m (per unit mass in a system without a `Mass`); matrices of several masses.
    arms : dict of Maxwell
        The spring and dashpot in series that stands for each `BoucWen` and `Jenkins`, by its name.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.
    """

    stiffness: Any = field(compare=False)
    damping: Any = field(compare=False)
    arms: Mapping[str, Any] = field(default_factory=dict, compare=False)


@np.errstate(all="ignore")  # what is not finite is no answer
def linearization(system: System) -> Linearization:
    """Replace nonlinear springs and dampers by the linear ones whose force differs least in mean square.

    Parameters
    ----------
    system : System
        One mass or several.  Springs with one equilibrium, nonlinear dampers, parts that yield, and everything
        that `springpot.theory.linear` covers but harmonic and parametric excitation.

    Returns
    -------
    Linearization

    Raises
    ------
    NotCoveredError
        If the system has a wall, two wells, or excitation that is not stationary noise; the sentence names the part.
    NoConvergenceError
        If the equations have no solution that is found.
    TypeError
        If it is not a System.

    Notes
    -----
    x and v are taken as Gaussian and independent at one time.  Let a part have the elongation u, with the velocity
    w: its stiffness is E[U''(u)] and its damping E[w F(u, w)] / E[w^2].  The means of x balance the mean forces, and
    memory is kept as it is [1]_.  A part that yields becomes a spring and a dashpot in series.  The force
    of a `BoucWen` is taken as Gaussian too; under white noise <x^2> and <v^2> then came out too small by up to 17 %.
    That of a `Jenkins` is taken as a Gaussian variable that is cut off at its limits; a warning says what came out.
    Where only parts that yield hold one mass, x has no stationary law and is NaN; v has one.  For a cubic spring
    <x^2> comes out too small; a warning says where it would be by more than 5 % in thermal noise, where the exact law
    is known.

    References
    ----------
    .. [1] J. B. Roberts and P. D. Spanos, "Random vibration and statistical linearization", Wiley (1990).

    Examples
    --------
    >>> import springpot as sp
    >>> duffing = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 1.0), sp.WhiteNoise(1.0)
    ... )
    >>> round(linearization(duffing).x_mean_square, 4)
    0.346
    """
    system = checked_system(system)
    own = NearestLinear(check_covered(system), _rows(system), system.constant_force)
    yielding = {name: part for name, part in system.named() if part.yields}
    one = len(own.force) == 1
    drifts = one and yielding and not own.force.any() and not any(any(row.forces) for row in own.rows)
    if drifts:
        held = _WEAK * sum(part.stiffness for part in yielding.values())
        own = replace(own, rows=(*own.rows, _Row(np.ones(1), (0.0, held), ())))
    companion, stationary, warnings = own.solved(system, yielding)
    if drifts and not isinstance(stationary, str):
        none, warnings = math.nan, (_DRIFTS, *warnings)
        stationary = replace(stationary, x_mean=none, x_mean_square=none, amplitude_mean_square=none)
        companion = replace(companion, stiffness=0.0 * companion.stiffness)
    return Linearization(
        method="linearization",
        system=system,
        stationary=stationary,
        assumptions=("x and v are Gaussian, and independent of each other at one time.",),
        warnings=warnings,
        is_exact=not (yielding or any(row.is_bent for row in own.rows)),
        stiffness=float(companion.stiffness[0, 0]) if one else companion.stiffness,
        damping=float(companion.damping[0, 0]) if one else companion.damping,
        arms=dict(zip(yielding, companion.elements[len(own.companion.elements) :], strict=False)),
    )


def nearest_in_time(system: System) -> NearestLinear | None:
    """How a system is replaced by a linear one at each time, from the motion at that time; None if it is linear.

    Raises
    ------
    NotCoveredError
        If the system has a part that is not covered, or its mean moves.
    """
    rows, force = _rows(system), system.constant_force
    yielding = [name for name, part in system.named() if part.yields]
    if not yielding and not any(row.is_bent for row in rows):
        return None
    companion = check_covered(system, over=True)
    if yielding:
        raise NotCoveredError(f"{_REACH}; in time not {yielding[0]}.")
    if force.any() or any(any(row.forces[::2]) for row in rows):
        raise NotCoveredError(f"{_REACH}; in time only where the mean of x stays 0 by symmetry.")
    if any(row.damping(0.0, 0.0, 0.0) < 0.0 for row in rows):
        raise NotCoveredError(f"{_REACH}; in time none that feed small motions.")
    return NearestLinear(companion, rows, force)


def check_covered(system: System, *, over: bool = False) -> Companion:
    """The linear part of a system that is covered; otherwise `NotCoveredError`; ``over`` time, with envelopes."""
    for name, part in system.named():
        if isinstance(part, Harmonic | ParametricNoise):
            raise NotCoveredError(f"{_REACH} and with stationary noise, not {name}.")
    companion = companion_of(_without_nonlinear(system), over=over, reach=_REACH)
    rows, force = _rows(system), system.constant_force
    stiffness = sum((row.along(row.forces[1]) for row in rows), np.zeros((len(force), len(force))))
    for row in rows:
        held, pushed = _condensed(stiffness - row.along(row.forces[1]), force, row.g)
        if _wells((row.forces[0] - pushed, row.forces[1] + held, *row.forces[2:])) > 1:
            raise NotCoveredError(f"{_REACH}, not two wells.")
    return companion


@dataclass(frozen=True, eq=False)
class _Row:
    """All springs and dampers with the same ends: the row g, the coefficients of their force, and the parts."""

    g: Floats
    forces: tuple[float, ...]
    parts: tuple[Any, ...]

    @property
    def is_rough(self) -> bool:
        """Whether a damper is not linear."""
        return any(part.is_rough for part in self.parts)

    @property
    def is_bent(self) -> bool:
        """Whether anything is not linear."""
        return any(self.forces[2:]) or self.is_rough

    def along(self, number: float) -> Floats:
        """A number of it in the equations of motion."""
        return number * np.outer(self.g, self.g)

    def spring(self, mean: float, spread: float) -> tuple[float, float]:
        """The mean force and stiffness for a Gaussian elongation."""
        places, curve = mean + spread * _NODES, Potential(self.forces)
        return float(_WEIGHTS @ curve.force(places)), float(_WEIGHTS @ curve.curvature(places))

    def damping(self, mean: float, x_spread: float, v_spread: float) -> float:
        """E[w F] / E[w^2] for Gaussian elongation and velocity w."""
        return sum((part.equivalent_damping(mean, x_spread, v_spread) for part in self.parts), 0.0)


def _rows(system: System) -> tuple[_Row, ...]:
    """The springs and dampers, those with the same ends together."""
    found: dict[tuple[float, ...], tuple[Floats, list[Any]]] = {}
    for name, part in system.named():
        if part.has_equivalent:
            row = system.coordinates.elongations[name]
            if tuple(-row) in found:
                row = -row
            found.setdefault(tuple(row), (row, []))[1].append((name, part))
    rows = []
    for row, parts in found.values():
        forces = np.zeros(10)
        for name, part in parts:
            own = part.force_coefficients()
            turned = system.coordinates.elongations[name] @ row < 0.0
            forces[: len(own)] += [-k if turned and n % 2 == 0 else k for n, k in enumerate(own)]
        last = max([1, *np.flatnonzero(forces)])
        rows.append(_Row(row, tuple(forces[: last + 1].tolist()), tuple(part for _, part in parts)))
    return tuple(rows)


def _condensed(stiffness: Floats, force: Floats, row: Floats) -> tuple[float, float]:
    """The stiffness and the force that an elongation sees of linear springs where the rest is in equilibrium."""
    start, rest = row / float(row @ row), np.linalg.svd(row[None, :])[2][1:].T
    way = start - rest @ np.linalg.pinv(rest.T @ stiffness @ rest) @ (rest.T @ stiffness @ start)
    return float(way @ stiffness @ way), float(way @ force)


def _wells(forces: Sequence[float]) -> int:
    """How often the force turns from a push to the right to a pull back: between its roots it keeps its sign."""
    coefficients = np.array(forces)
    places = np.unique(roots_of(coefficients).real)
    if places.size < 2:
        return places.size
    tests = np.concatenate([0.5 * (places[1:] + places[:-1])])
    force = polynomial.polyval(tests, coefficients)
    told_apart = np.abs(force) > 1e-10 * polynomial.polyval(np.abs(tests), np.abs(coefficients))
    signs = np.concatenate([[-1.0], np.sign(force[told_apart]), [1.0]])
    return int(np.count_nonzero((signs[1:] > 0.0) & (signs[:-1] < 0.0)))


def _without_nonlinear(system: System) -> System:
    """The parts that a linear system keeps; walls stay, and are refused there."""
    kept = {name: part for name, part in system.named() if not (part.has_equivalent or part.yields)}
    free = "held"
    while free in kept:
        free += "_"
    return System(**kept, **{free: Spring(1.0, between=("ground", system.points[0]))})


@dataclass(frozen=True, eq=False)
class NearestLinear:
    """The search for the linear system whose own moments give its stiffness, damping and means.

    Its state is the means of x, unless all are 0 by symmetry, and for each row that is bent the logarithms of the
    standard deviations of elongation and velocity.
    """

    companion: Companion
    rows: tuple[_Row, ...]
    force: Floats

    @property
    def bent(self) -> list[_Row]:
        """The rows of the state."""
        return [row for row in self.rows if row.is_bent]

    def split(self, state: Floats) -> tuple[Floats, Floats]:
        """The means of a state, and the standard deviations of each row, shape (rows, 2)."""
        count = len(state) - 2 * len(self.bent)
        mean = state[:count] if count else np.zeros(len(self.force))
        return mean, np.exp(state[count:].reshape(2, -1)).T

    def joined(self, mean: Floats, x: Floats, v: Floats) -> Floats:
        """The state of means, and standard deviations of elongations and velocities."""
        shifts = self.force.any() or any(any(row.forces[::2]) for row in self.rows)
        return np.concatenate([mean if shifts else mean[:0], np.log(x), np.log(v)])

    def sizes(self, here: Companion) -> tuple[Floats, Floats] | str:
        """Standard deviations of elongations and velocities of a linear system; or why there are none.

        Where an elongation never happens, it is a share of the largest motion, so that its logarithm is no noise.
        """
        axes = np.eye(len(self.force))
        seen = motions(here, [*(row.g for row in self.bent), *axes])
        if isinstance(seen, str):
            return seen
        squares = np.array(seen)[:, 1:]
        x, v = np.sqrt(np.maximum(squares, _NOTHING * squares.max(axis=0))).T[:, : len(self.bent)]
        return x, v

    def solved(
        self, system: System, yielding: Mapping[str, Yielding]
    ) -> tuple[Companion, Moments | str, tuple[str, ...]]:
        """The linear system, its moments or why there are none, and warnings."""
        own = self.companion
        unknown = np.full_like(own.mass, math.nan)
        nothing = replace(own, stiffness=unknown, damping=unknown)
        if own.temperature == 0.0 and not any(noise.excites for noise in own.noises):
            return nothing, "There is no random stationary state: nothing excites the motion.", ()
        if not (own.dissipates or yielding) and not any(row.damping(0.0, 1e20, 1e20) > 0.0 for row in self.rows):
            return nothing, "There is no stationary state: nothing dissipates energy.", ()
        try:
            if yielding:
                own = with_arms(own, [*yielding.values()], lambda known: replace(self, companion=known).settled()[0])
            here, state = replace(self, companion=own).settled()
        except NoStationaryStateError as unstable:
            return nothing, str(unstable), ()
        mean, _ = self.split(state)
        found = linear_moments(system, replace(here, force=here.stiffness @ mean))  # which gives that mean
        warnings = () if isinstance(found, str) else tuple(self.doubts(here, state))
        if not isinstance(found, str):
            by_kind = sorted(yielding.values(), key=lambda part: part.said)
            warnings += tuple(dict.fromkeys(part.doubt for part in by_kind))
        return here, found, warnings

    def settled(self) -> tuple[Companion, Floats]:
        """The linear system that agrees with its own motion, and the state."""
        state = self.start()
        if state.size:
            state = optimize.root(self.missing, state, method="hybr", options={"xtol": _TOLERANCE}).x
        here, _ = self.at(state)
        if not np.abs(self.missing(state)).max(initial=0.0) < 1e-7 or not _is_sound(here):
            raise NoConvergenceError("statistical linearization found no solution: its equations did not settle.")
        return here, state

    def at(self, state: Floats) -> tuple[Companion, Floats]:
        """The linear system at a state, and how far its means are from the balance of forces."""
        stiffness, damping, left = self.equivalents(*self.split(state))
        here = replace(self.companion, stiffness=stiffness, damping=damping, force=np.zeros(len(left)))
        return here, np.asarray(np.linalg.solve(stiffness, left))

    def equivalents(self, mean: Floats, found: Floats) -> tuple[Floats, Floats, Floats]:
        """Stiffness, damping and what is missing of the forces, at the means and the spreads of each bent row."""
        size, spreads = len(self.force), dict(zip(map(id, self.bent), found, strict=True))
        stiffness, damping, left = np.zeros((size, size)), np.zeros((size, size)), -self.force
        for row in self.rows:
            place, (x_spread, v_spread) = float(row.g @ mean), spreads.get(id(row), (0.0, 0.0))
            pushed, stiff = row.spring(place, x_spread)
            stiffness += row.along(stiff)
            damping += row.along(row.damping(place, x_spread, v_spread))
            left = left + pushed * row.g
        return stiffness, damping, left

    def missing(self, state: Floats) -> Floats:
        """What the linear system has beyond what the state says."""
        here, shift = self.at(state)
        sizes = self.sizes(here)
        if isinstance(sizes, str):
            raise NoConvergenceError(
                "statistical linearization found no solution: on the way nothing dissipates energy."
            )
        mean, spreads = self.split(state)
        scale = spreads[:, 0].max() if len(spreads) else max(np.abs(mean).max(), 1e-300)
        x, v = np.array(sizes) / spreads.T
        return self.joined(shift / scale, x, v)

    def start(self) -> Floats:
        """The equilibrium, and spreads at which the springs hold as much energy as noise feeds in a while."""
        size, bent = len(self.force), self.bent
        mean = np.zeros(size)
        if size == 1:
            forces = sum(np.pad(row.forces, (0, 10 - len(row.forces))) for row in self.rows) - self.force * _FIRST
            if not (springs := np.trim_zeros(forces, "b")).size:
                raise NoStationaryStateError(unheld(self.companion.elements, "no spring pulls the mass back"))
            roots = roots_of(springs)
            mean[0] = float(min(roots, key=lambda root: abs(root.imag)).real) if roots.size else 0.0
        spread, least, most = 1.0, 0.0, math.inf
        shape = np.ones(len(bent))
        for _ in range(400):  # the spread at which the linear system has the spread itself
            shift, sizes = self.tried(mean, spread * shape)
            ratio = math.inf
            if sizes is not None:
                x, v = sizes
                mean = mean if size == 1 else mean - shift
                own = float(x.max(initial=0.0)) or spread
                ratio = own / spread
                if abs(math.log(ratio)) < 0.1 or most < least * (1.0 + 1e-9):
                    return self.joined(mean, x, v)
                shape = x / own
            least, most = (spread, most) if ratio > 1.0 else (least, spread)
            step = min(max(math.sqrt(ratio), 0.05), 20.0) if math.isfinite(ratio) else 2.0
            spread = math.sqrt(least * most) if 0.0 < least < most < math.inf else spread * step
        raise NoConvergenceError("statistical linearization found no solution: no spread agrees with itself.")

    def tried(self, mean: Floats, spreads: Floats) -> tuple[Floats, tuple[Floats, Floats] | None]:
        """How far the means are off at some spreads, and those of the linear system; None if it is not held."""
        stiff = [max(row.spring(float(row.g @ mean), s)[1], 1e-300) for row, s in zip(self.bent, spreads, strict=True)]
        here, shift = self.at(self.joined(mean, spreads, spreads * np.sqrt(stiff)))
        if not _is_sound(here):
            return shift, None
        sizes = self.sizes(here)
        if isinstance(sizes, str):
            raise NoStationaryStateError(sizes)
        return shift, sizes

    def doubts(self, here: Companion, state: Floats) -> Iterator[str]:
        """Where x is far from Gaussian."""
        thermal, (mean, spreads) = here.temperature > 0.0, self.split(state)
        sides = []
        for row, (x_spread, v_spread) in zip(self.bent, spreads, strict=True):
            if any(row.forces[2:]):
                sides.append(_strained(row, here, float(row.g @ mean), float(x_spread), float(v_spread), thermal))
        if told := [side for side in dict.fromkeys(sides) if side]:
            yield f"The springs bend so much that x is far from Gaussian: its variance comes out too {told[0]}."
        if any(row.damping(float(row.g @ mean), 0.0, 0.0) < 0.0 for row in self.rows):
            yield "The dampers feed small motions: around a limit cycle <x^2> can come out small by a factor of 2."
        if any(row.is_bent for row in self.rows) and _is_sparse(here):
            yield (
                "The impulses are so rare that x is far from Gaussian: here they act as white noise of equal intensity."
            )


def _is_sparse(here: Companion) -> bool:
    """Whether an impulse alone feeds in more than a tenth of the energy."""
    shots, mass = [noise for noise in here.noises if noise.impulses[0]], here.mass
    moving = motions(here, [*np.eye(len(mass))]) if shots else ""
    if isinstance(moving, str):
        return False
    energy = float(np.diag(mass) @ [v_square for *_, v_square in moving])  # as much potential as kinetic
    pushes = map(here.push, shots)
    fed = [0.5 * p.white_intensity * float(g @ np.linalg.solve(mass, g)) for p, g in zip(shots, pushes, strict=True)]
    return any(each / energy > 0.1 * noise.impulses[0] for each, noise in zip(fed, shots, strict=True))


def _is_sound(here: Companion) -> bool:
    """Whether a linear system is held, and dampers do not feed it where nothing else takes energy."""
    held = np.linalg.eigvalsh(here.stiffness)
    damped = np.linalg.eigvalsh(here.damping)
    damps = damped[-1] > 0.0 and damped[0] >= -_EVEN * damped[-1]
    return bool(held[0] > 0.0 and (damps or here.lossy))


def _strained(row: _Row, here: Companion, mean: float, x_spread: float, v_spread: float, thermal: bool) -> str:
    """To which side the variance of an elongation is off in a bath, "small" or "large"; empty if it is not."""
    held = here.stiffness
    if not thermal:  # in a bath memory does not change the law of x
        held = held + here.dissipative(np.array([v_spread / x_spread]))[0].real
    whole = 1.0 / float(row.g @ np.linalg.solve(held, row.g))
    pushed, stiff = row.spring(mean, x_spread)
    beside = whole - stiff  # of all that is linear
    # a bath in which the same springs, and all others as they are here, have this variance where x is Gaussian
    bent, rest = PolynomialSpring(row.forces[1:]), Spring(beside)
    bath = System(
        Dashpot(1.0), ThermalNoise(whole * x_spread**2), Constant(pushed - row.forces[0] + beside * mean), bent, rest
    )
    with contextlib.suppress(NoConvergenceError):
        true = exact_law(bath)[0]
        if isinstance(true, str):
            return ""
        ratio = x_spread**2 / (true.x_mean_square - true.x_mean**2)
        if abs(ratio - 1.0) > _BENT:
            return "small" if ratio < 1.0 else "large"
    return ""


def with_arms(companion: Companion, parts: Sequence[Yielding], settled: Callable[[Companion], Companion]) -> Companion:
    """A linear system with Maxwell elements that agree with its motion, last among its elements.

    Parameters
    ----------
    companion : Companion
        The linear system without them.
    parts : sequence of BoucWen or Jenkins
    settled : callable
        What makes of a linear system with them one whose springs and dampers agree with its motion too.

    Raises
    ------
    NoConvergenceError, NoStationaryStateError
        If there are none that are found, or no stationary state.
    """
    count = len(parts)

    def arms(state: Floats) -> tuple[list[Maxwell], Floats]:
        speeds = np.exp(state[:count])
        each = (
            part.nearest_arm(speed, part.arm_state(free))
            for part, speed, free in zip(parts, speeds.tolist(), state[count:].tolist(), strict=True)
        )
        found, forces = zip(*each, strict=True)
        return [*found], np.concatenate([speeds, forces])

    def missing(state: Floats) -> Floats:
        found, sizes = arms(state)
        return np.log(_sizes(settled(_with(companion, found)), found) / sizes)

    heaviest = float(np.diag(companion.mass).max())
    speeds = [part.yield_displacement * math.sqrt(part.stiffness / heaviest) for part in parts]
    state = np.concatenate([np.log(speeds), np.zeros(count)])
    for _ in range(_HALFWAY):
        step = missing(state)
        state = state + 0.5 * step
        if np.abs(step).max() < 0.01:
            break
    state = optimize.root(missing, state, method="hybr", options={"xtol": _TOLERANCE}).x
    if not np.abs(missing(state)).max() < 1e-7:
        raise NoConvergenceError("statistical linearization found no solution: its equations did not settle.")
    return _with(companion, arms(state)[0])


def _with(companion: Companion, arms: Sequence[Maxwell]) -> Companion:
    return replace(companion, elements=(*companion.elements, *arms))


def _sizes(companion: Companion, arms: Sequence[Maxwell]) -> Floats:
    """Standard deviations of the velocities of the arms' elongations, and of their forces."""
    found = pulled(companion, arms)
    if isinstance(found, str):
        raise NoStationaryStateError(found)
    return np.asarray(np.sqrt(found)).T.ravel()
