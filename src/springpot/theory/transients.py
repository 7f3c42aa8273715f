"""Mean squares in time of systems from rest, with noise that may have an envelope.

The system and the filters of its noise are a state, dX = A X dt + e(t) b dW with the modes of springpots' memory
(`springpot.theory.methods.systems.states`), and its covariance grows by

    P(t + h) = F P(t) F^T + mean of e^2 in the step * Q,    F = exp(A h),  Q = int_0^h exp(A s) b b^T exp(A s)^T ds,

which is exact for an envelope that is constant in the step, however long that is.  Noise of a given spectral density S
has no state: each of its frequencies drives the system by e(t) exp(i w t), with e a straight line in each step, and

    <x^2> = int S(w) |int_0^t h(t - s) e(s) exp(i w s) ds|^2 dw.

Nonlinear springs and dampers are replaced at each time by the linear ones whose force differs least in mean square, for
Gaussian x and v with the covariance of that time (`springpot.theory.methods.systems.linearization`).  Half of what
these have beyond constant ones acts as an impulse before each step of the constant system, and half after it, so that
the error is of second order in the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arguments import LARGEST, finite_array
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.parts import SpectralExcitation
from springpot.problem.system import System, checked_system
from springpot.theory.methods.systems.linear import companion_of
from springpot.theory.methods.systems.linearization import NearestLinear, nearest_in_time
from springpot.theory.methods.systems.states import States, states_of
from springpot.theory.normal_modes import free_motion
from springpot.theory.numerics.panels import panel_rule

_REACH = "The transient covers systems from rest"
_STEPS = 800  # of the time that is asked for, and of an envelope
_MOST_STEPS = 50_000
_TURN = 0.1  # radians in a step in which a filter or a spring changes
_TRIES = 8  # of steps and memory that resolve the fastest motion, which nonlinear springs decide
_SLOWEST, _FASTEST = 0.02, 300.0  # of one over the time, and of the fastest rate: the range of the memory
_NODES, _WIDE, _FADED = 8, 6.0, 8.0  # of an interval of frequencies; times its width, and the decay of what it resolves
_NEAR, _APART = 20.0, 3.0
_MOST_FREQUENCIES = 60_000
_SMALL = 1e-3
_FADING = (
    "When the noise has died away nonlinear dampers leave more motion than is computed: <x^2> and <v^2> came out up to "
    "19 % too small."
)
_GAUSSIAN = "x and v are Gaussian at each time, and springs and dampers the linear ones that are then nearest to them."


@dataclass(frozen=True, eq=False)
class Transient:
    """Mean squares of a system at times since its start from rest.

    Attributes
    ----------
    time : ndarray
        In s.
    numbers : dict of ndarray
        ``x_mean_square`` and ``v_mean_square``, in m^2 and m^2/s^2; of several masses ``box_x_mean_square``,
        ``box_v_mean_square`` and ``panel_box_elongation_mean_square``.  Each is an attribute too.
    is_exact : bool
        Whether the system is linear; otherwise it is replaced by the nearest linear one of each time.
    assumptions, warnings : tuple of str
        What was assumed, and where that is far from true.
    """

    time: Floats
    numbers: dict[str, Floats] = field(repr=False)
    is_exact: bool = True
    assumptions: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __getattr__(self, name: str) -> Floats:
        try:
            return self.__dict__["numbers"][name]  # type: ignore[no-any-return]
        except KeyError:
            raise AttributeError(f"a transient has no {name!r}.") from None


@np.errstate(over="ignore", invalid="ignore")  # of numbers at the ends of double precision
def transient(system: System, time: npt.ArrayLike) -> Transient:
    """The mean squares in time of a system that starts from rest: exact if it is linear, else by linearization in time.

    Parameters
    ----------
    system : System
        One mass or several with linear springs, dashpots, springpots, arms and circuits; noise of any kind, with or
        without an envelope, but thermal noise and noise that multiplies x.  A filter starts from silence.  Nonlinear
        springs and dampers without mean forces too, with noise of any kind but a given spectral density.
    time : array_like
        In s, none below 0.

    Returns
    -------
    Transient
        Of linear systems to about 1e-4 of the largest value.

    Raises
    ------
    NotCoveredError
        If the system has another part; the sentence says which.
    TypeError, ValueError
        If it is not a System, or a time is below 0.

    Notes
    -----
    Of a nonlinear system this is a Gaussian closure: x and v are taken as Gaussian at each time, and springs and
    dampers as the linear ones that differ least from them in mean square, as in `linearization`.  Of a cubic spring,
    with a dashpot or a springpot, <x^2> came out up to 10 % too small where it holds less than the linear one, 16 %
    where it holds more and 19 % where it is alone; <v^2> was within 6 %.  A warning says where the variance is off by
    more than 5 %.  It stops being true for two wells and dampers that feed small motions, which are refused.

    Examples
    --------
    >>> import springpot as sp
    >>> envelope = sp.ExponentialEnvelope(slow=0.2, fast=0.6)
    >>> shaken = sp.System(sp.Spring(1.0), sp.Springpot(0.5, 0.3), sp.WhiteNoise(1.0, envelope=envelope))
    >>> transient(shaken, [4.0, 10.0]).x_mean_square.round(3).tolist()
    [0.983, 0.778]
    >>> stiffer = sp.System(*shaken.parts, sp.PolynomialSpring((0.0, 0.0, 0.5)))
    >>> found = transient(stiffer, [4.0, 10.0])
    >>> found.x_mean_square.round(3).tolist(), found.is_exact
    ([0.584, 0.529], False)
    """
    system = checked_system(system)
    nearest = nearest_in_time(system)
    own = companion_of(system, over=True) if nearest is None else nearest.companion
    if own.temperature > 0.0 or own.harmonics or own.parametric or own.force.any():
        raise NotCoveredError(f"{_REACH}, not constant or harmonic forces, thermal noise or noise that multiplies x.")
    times = finite_array(time, "time")
    if not times.size or (times < 0.0).any() or times.max() > LARGEST:
        raise ValueError(f"time must be times from 0 to {LARGEST:g} s, at least one.")
    end = float(times.max(initial=0.0))
    if nearest is not None:
        return _linearized(system, nearest, times, end)
    fastest = max([*own.scales, 1.0 / end if end > 0.0 else 1.0])
    states = states_of(own, _SLOWEST / max(end, 1.0 / fastest), _FASTEST * fastest, "a transient")
    rows = _rows(system, states)
    seen = np.array([*rows.values()])
    found = np.zeros((times.size, len(rows)))
    if end > 0.0:
        asked, place = np.unique(times.ravel(), return_inverse=True)
        steps = [*_steps(states, asked)]
        whole = _driven_white(states, seen, steps)
        for noise, vector, _ in states.inputs:
            if noise.filter_order is None:
                whole = whole + _of_density(noise, states, vector, seen, steps, end)
        found = whole[place]
    return Transient(times, {name: found[:, n].reshape(times.shape) for n, name in enumerate(rows)})


def _linearized(system: System, nearest: NearestLinear, times: Floats, end: float) -> Transient:
    """By the linear system of each time, with steps and memory for the fastest of them."""
    own, still = nearest.companion, np.zeros(len(nearest.force))
    if any(noise.filter_order is None for noise in own.noises):
        raise NotCoveredError(f"{_REACH}; with nonlinear parts not a noise of a given spectral density.")
    stiffness, damping, _ = nearest.equivalents(still, np.zeros((len(nearest.bent), 2)))
    span = end if end > 0.0 else 1.0
    if not np.linalg.eigvalsh(stiffness)[0] > 0.0:  # the springs then differ from any other
        stiffness = stiffness + own.mass / span**2
    own = replace(own, stiffness=stiffness, damping=np.zeros_like(damping))
    asked, place = np.unique(times.ravel(), return_inverse=True)
    fastest = 2.0 * _fastest(own.mass, stiffness)
    for _ in range(_TRIES):
        states = states_of(own, _SLOWEST / span, _FASTEST * max([*own.scales, fastest, 1.0 / span]), "a transient")
        rows, beyond = _rows(system, states), _Beyond(nearest, states)
        steps = [*_steps(states, asked, _TURN / fastest)] if end > 0.0 else [(0.0, 0.0, True)]
        found = _driven_white(states, np.array([*rows.values()]), steps, beyond)
        if beyond.fastest <= fastest:
            break
        fastest = 1.1 * beyond.fastest
    else:
        raise NotCoveredError(f"{_REACH}, whose springs do not grow so stiff that no step resolves them.")
    warnings: tuple[str, ...] = ()
    if beyond.spreads.any():
        stiffness, damping, _ = nearest.equivalents(still, beyond.spreads)
        here = replace(own, stiffness=stiffness, damping=damping)
        warnings = tuple(nearest.doubts(here, nearest.joined(still, *beyond.spreads.T)))
        rough = any(row.is_rough for row in nearest.bent)
        warnings += (_FADING,) if rough and any(noise.envelope is not None for noise in own.noises) else ()
    return Transient(
        times, {name: found[place, n].reshape(times.shape) for n, name in enumerate(rows)},
        is_exact=False, assumptions=(_GAUSSIAN,), warnings=warnings,
    )  # fmt: skip


def _fastest(mass: Floats, stiffness: Floats) -> float:
    """The highest natural frequency, in rad/s."""
    squares, _ = free_motion(mass, stiffness)
    return math.sqrt(float(squares[-1]))


class _Beyond:
    """What the linear system of each time has beyond the constant one, as impulses.

    Kept are the fastest of them, and the spreads where the elongations were largest.
    """

    def __init__(self, nearest: NearestLinear, states: States) -> None:
        self.nearest, self.states, self.fastest = nearest, states, 0.0
        self.still = np.zeros(len(states.light))
        self.x = np.array([states.x(row.g) for row in nearest.bent])
        self.v = np.array([states.v(row.g) for row in nearest.bent])
        self.back = np.linalg.inv(states.root).T  # from states to displacements
        self.spreads = np.zeros((len(nearest.bent), 2))

    def equivalents(self, covariance: Floats) -> tuple[Floats, Floats, Floats]:
        """Spreads of the bent rows, stiffness and damping."""
        squares = [np.einsum("ri,ij,rj->r", rows, covariance, rows) for rows in (self.x, self.v)]
        spreads = np.sqrt(np.maximum(squares, 0.0)).T
        return spreads, *self.nearest.equivalents(self.still, spreads)[:2]

    def act(self, covariance: Floats, time: float) -> Floats:
        """What an impulse over a time leaves of a covariance; dampers see the middle of it."""
        if time == 0.0:
            return covariance
        middle = self._moved(covariance, 0.5 * time, *self.equivalents(covariance)[1:])
        spreads, stiffness, damping = self.equivalents(middle)
        if (spreads[:, 0] ** 2).sum() > (self.spreads[:, 0] ** 2).sum():
            self.spreads = spreads
            self.fastest = max(self.fastest, _fastest(self.states.companion.mass, stiffness))
        return self._moved(covariance, time, stiffness, damping)

    def _moved(self, covariance: Floats, time: float, stiffness: Floats, damping: Floats) -> Floats:
        own, light, many = self.states.companion, self.states.light, len(self.still)
        damps = 0.5 * time * light @ (damping - own.damping) @ light.T
        taken: Any = np.linalg.solve(
            np.eye(many) + damps,
            np.hstack([-time * light @ (stiffness - own.stiffness) @ self.back, np.eye(many) - damps]),
        )
        step = np.eye(len(covariance))
        step[many : 2 * many, : 2 * many] = taken
        return np.asarray(step @ covariance @ step.T)


def _rows(system: System, states: States) -> dict[str, Floats]:
    """The state's rows of all results, by name."""
    at, found = system.coordinates, dict[str, Floats]()
    for own, row in at.beginnings.items():
        found |= {f"{own}x_mean_square": states.x(row), f"{own}v_mean_square": states.v(row)}
    return found | {f"{pair}_elongation_mean_square": states.x(row) for pair, row in at.pairs.items()}


def _steps(states: States, asked: Floats, most: float = math.inf) -> Iterator[tuple[float, float, bool]]:
    """Begin and length of each step, and whether a time that was asked for is its end; one of no length is time 0.

    None is longer than ``most``.

    Raises
    ------
    NotCoveredError
        If there are too many.
    """
    noises, end = [noise for noise, _, _ in states.inputs], float(asked[-1])
    longest = min([end, most * _STEPS, *(noise.duration for noise in noises if noise.duration)]) / _STEPS
    for noise in noises:
        if getattr(noise, "frequency_rate", 0.0):
            longest = min(longest, _TURN / max(*states.companion.scales, noise.frequency_at(end, "the noise")))
    longest = max(longest, np.finfo(float).tiny)
    corners = {t for noise in noises if noise.envelope is not None for t in noise.envelope.corners if 0.0 < t < end}
    times = np.unique([0.0, *asked, *corners])
    counts = np.maximum(np.ceil(np.diff(times) / longest * (1.0 - 1e-9)), 1.0)
    if not counts.sum() <= _MOST_STEPS:
        raise NotCoveredError(f"{_REACH}, over at most {_MOST_STEPS:,} steps in which envelopes change little.")
    if asked[0] == 0.0:
        yield 0.0, 0.0, True
    for begin, stop, count in zip(times[:-1].tolist(), times[1:].tolist(), counts.astype(int).tolist(), strict=True):
        length = float(f"{(stop - begin) / count:.12g}")  # equal steps are one
        for n in range(count):
            yield begin + n * length, length, n == count - 1 and stop in asked


def _mean_square(noise: Any, begin: float, length: float) -> float:
    """Of an envelope in a step, by Simpson's rule."""
    if noise.envelope is None:
        return 1.0
    inside = begin + length * np.array([1e-9, 0.5, 1.0 - 1e-9])  # an envelope may jump at an end
    return float(np.array([1.0, 4.0, 1.0]) @ noise.envelope.at(inside) ** 2) / 6.0


def _driven_white(
    states: States, seen: Floats, steps: list[tuple[float, float, bool]], beyond: _Beyond | None = None
) -> Floats:
    """Mean squares under the noises that white noise drives, at the times that were asked for."""
    from scipy import linalg  # slow to import

    from springpot.theory.numerics.white_noise import gathered

    noises = [(noise, vector) for noise, vector, _ in states.inputs if noise.filter_order is not None]
    changing = any(getattr(noise, "frequency_rate", 0.0) for noise, _ in noises)
    size, known = len(states.rates), dict[float, tuple[Floats, list[Floats]]]()
    covariance, found = np.zeros((size, size)), []
    for begin, length, is_asked in steps:
        if changing or length not in known:
            rates = states.rates_at(begin + 0.5 * length) if changing else states.rates
            half: Any = linalg.expm(0.5 * length * rates)
            vectors = [vector for _, vector in noises]
            brought = [
                _simpson(half, b, length) if changing else gathered(length * rates, length * np.outer(b, b))[1]
                for b in vectors
            ]
            known = {length: (half @ half, brought)} if changing else {**known, length: (half @ half, brought)}
        moved, brought = known[length]
        covariance = beyond.act(covariance, 0.5 * length) if beyond else covariance
        covariance = moved @ covariance @ moved.T
        for (noise, _), more in zip(noises, brought, strict=True):
            covariance += _mean_square(noise, begin, length) * more
        covariance = beyond.act(covariance, 0.5 * length) if beyond else covariance
        if is_asked:
            found.append(np.einsum("ri,ij,rj->r", seen, covariance, seen))
    return np.array(found)


def _simpson(half: Floats, b: Floats, length: float) -> Floats:
    """The same of a short step through a filter, without a matrix twice as large."""
    middle, end = half @ b, half @ (half @ b)
    return np.asarray(length / 6.0 * (np.outer(b, b) + 4.0 * np.outer(middle, middle) + np.outer(end, end)))


def _of_density(
    noise: SpectralExcitation, states: States, vector: Floats, seen: Floats,
    steps: list[tuple[float, float, bool]], end: float,
) -> Floats:  # fmt: skip
    """Mean squares under a noise of a given spectral density, as sums over its frequencies."""
    inner = slice(0, states.own)
    values, ways = np.linalg.eig(states.rates[inner, inner])
    driven, shown = np.linalg.solve(ways, vector[inner].astype(complex)), seen[:, inner] @ ways
    kept = (np.abs(driven) * np.abs(shown).max(axis=0)) > 1e-14 * (np.abs(driven) * np.abs(shown).max(axis=0)).max()
    values, driven, shown = values[kept], driven[kept], shown[:, kept]
    w, weights = _frequencies(noise, values, end)
    weights = 2.0 * weights * np.array([noise.density(each) for each in w.tolist()])
    state, found = np.zeros((len(values), len(w)), complex), []
    known = dict[float, tuple[Any, Any, Any]]()
    envelope: Callable[[Any], Floats] = np.ones_like if noise.envelope is None else noise.envelope.at
    for begin, length, is_asked in steps:
        if length > 0.0:
            if length not in known:
                known[length] = _line(length * (values[:, None] - 1j * w[None, :]), length, driven[:, None])
            moved, first, last = known[length]
            left, right = envelope(begin + length * np.array([1e-9, 1.0 - 1e-9])).tolist()
            state = moved * state + left * first + right * last
        if is_asked:
            found.append(np.abs(shown @ state) ** 2 @ weights)
    return np.array(found)


def _line(turned: Any, length: float, driven: Any) -> tuple[Any, Any, Any]:
    """What a step leaves of a state, and what the values at the ends of a straight line add to it."""
    moved = np.exp(turned)
    small = np.abs(turned) < _SMALL
    safe = np.where(small, 1.0, turned)
    whole = np.where(small, 1.0 + turned / 2.0 + turned**2 / 6.0, (moved - 1.0) / safe)
    last = np.where(small, 0.5 + turned / 6.0 + turned**2 / 24.0, (moved - 1.0 - safe) / safe**2)
    return moved, length * driven * (whole - last), length * driven * last


def _frequencies(noise: SpectralExcitation, values: Any, end: float) -> tuple[Floats, Floats]:
    """Nodes and weights of Gauss's rule in intervals of frequencies, short where the system is at resonance.

    Raises
    ------
    NotCoveredError
        If there are too many.
    """
    cuts = 2.0 * np.pi * np.array(noise.frequency)
    own = values[np.abs(values.imag) > 1e-3 * np.abs(values)]
    centres = np.abs(own.imag)
    width = _WIDE / np.minimum(end, _FADED / np.abs(own.real))
    w, edges = float(cuts[0]), [float(cuts[0])]
    while w < cuts[-1]:
        away = np.maximum(np.abs(w - centres) - _NEAR * width, 0.0)
        size = min([0.5 * w, *(width + away / _APART).tolist()])
        following = float(cuts[np.searchsorted(cuts, w, side="right")])
        w = following if w + size > following * (1.0 - 1e-12) else w + size
        edges.append(w)
        if len(edges) * _NODES > _MOST_FREQUENCIES:
            raise NotCoveredError(f"{_REACH}, with at most {_MOST_FREQUENCIES:,} frequencies of a spectral excitation.")
    return panel_rule(edges, _NODES)
