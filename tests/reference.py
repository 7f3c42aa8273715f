"""What a step is, in plain Python: one path of any system, with nothing of the compiled code in it.

Read this file first.  The simulation takes steps of equal length h.  In the middle of each step stands a **kick**: all
forces act at once, with the impulse that they have in the whole step.  Between two kicks lies a **drift** over h, free
of forces but for impacts, or turning on the circle of one linear spring.  The state is observed in the middle of the
drift, at the times h, 2h, ... .  Everything that a part knows of the masses is its elongation g.x, along its row g.

Masses can **rest** on a lossy wall along whose row only smooth forces act.  A row comes to rest where a force presses
and the next hop would be shorter than a step.  From then on each kick leaves it the velocity 0, and the wall takes the
impulse, as long as there is something to take; else the row leaves with half of what the kick gives, because by the
middle of the step it has begun to move.

The memory of a springpot is the sum over all its earlier increments, as long as the path: slow, and without error.

The impulses of the excitations are made in `tests/reference_sources.py`.  What is made of a path, means, counts, first
passages and so on, is in `tests/reference_observers.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import Any

import mpmath
import numpy as np

import springpot as sp
from tests.reference_sources import GIVEN, Floats, Numbers, dashpots_in, envelope_of, matched, normals

Sources = dict[str, tuple[Floats, Floats]]  # impulses of each step, and the forces on the coordinates per unit
ROUNDING = 1e-9  # of what an impact or a kick changes: the velocity of a row that rests


# -------------------------------------------------------------------------------------------------------- memory
def memory_of(part: Any, h: float, count: int) -> tuple[Floats, float, float]:
    """Of a kernel K(t): its means over the steps, newest first; its answer; and its first moment.

    A unit impulse, spread evenly over a step, moves the elongation within this step already.  The mean force of that is
    the answer, the integral of K(t) (h - t)^2 / 2 over the step, over h^2.  The moment is what impulses of earlier
    steps lack where all of them are taken for jumps: the sum over all steps of K(t) (middle of the step - t) / h.
    """
    lag = np.arange(count, dtype=float)
    if isinstance(part, sp.Dashpot | sp.Springpot | sp.PolynomialDashpot):
        order = getattr(part, "order", 1.0)
        c = part.coefficients[0] if isinstance(part, sp.PolynomialDashpot) else part.coefficient
        jump = c * h ** (1.0 - order)
        integral = jump * np.append(0.0, (lag + 1.0) ** (1.0 - order)) / math.gamma(2.0 - order)
        zeta = float(mpmath.zeta(order - 1.0))
        return np.diff(integral) / h, jump / math.gamma(4.0 - order), -zeta * jump / math.gamma(2.0 - order)
    if isinstance(part, sp.FractionalMaxwell):  # exp(u) = rate: its spectrum over the logarithm, in fine steps
        order, k = part.springpot.order, part.spring.stiffness
        centre, turn = math.log(k / part.springpot.coefficient) / order, math.pi * order
        u = np.arange(-40.0, 40.0, 0.02) / order
        spectrum = math.sin(turn) / math.pi / (np.exp(order * u) + 2.0 * math.cos(turn) + np.exp(-order * u))
        arms = zip(k * spectrum * 0.02 / order, np.exp(centre + u), strict=True)
    else:
        arms = iter([(part.stiffness, part.stiffness / part.coefficient)])
    means, answer, moment = np.zeros(count), 0.0, 0.0
    for strength, rate in arms:
        y = rate * h
        slow = y < 1e-3
        means += strength * (1.0 if slow else -math.expm1(-y) / y) * np.exp(-y * lag)
        answer += strength * h * (1 / 6 - y / 24 if slow else (0.5 * y * y - y - math.expm1(-y)) / y**3)
        moment += strength * h * (1 / 12 if slow else (0.5 / math.tanh(0.5 * y) - 1.0 / y) / y)
    return means, answer, moment


class Increments:
    """Of an elongation in each step, newest first."""

    def __init__(self, most: int) -> None:
        self._all, self._newest = np.zeros(most), most

    def add(self, increment: float) -> None:
        self._newest -= 1
        self._all[self._newest] = increment

    def weighed(self, weights: Floats) -> float:
        known = self._all[self._newest :]
        return float(weights[: known.size] @ known)


@dataclass
class Row:
    """Everything that lies on one elongation g.x."""

    g: Floats
    mass: float  # that moves along it: 1 / (g M^-1 g)
    jump: Floats  # change of the velocities per change of its own
    springs: Floats = field(default_factory=lambda: np.zeros(10))  # force k0 + k1 u + k2 u^2 + ...
    weights: Floats = field(default_factory=lambda: np.zeros(0))  # of the increments, newest first
    answer: float = 0.0
    memories: list[Any] = field(default_factory=list)
    shaken: list[sp.ParametricNoise] = field(default_factory=list)
    dampers: list[tuple[str, Damper]] = field(default_factory=list)
    contacts: list[tuple[str, sp.Contact]] = field(default_factory=list)
    increments: Increments = field(default_factory=lambda: Increments(0))
    drive: Floats = field(default_factory=lambda: np.zeros(0))  # forces of a jump before time 0

    def remember(self, part: Any, h: float, steps: int) -> None:
        """Add the memory of one more part.

        The velocity at the kick stands for the newest increment: its weight, twice the answer, is taken from that of
        the increment.  The last kick has all of the moment.
        """
        means, answer, moment = memory_of(part, h, steps + 1)
        last = (moment - answer) / h
        means[:2] += last - 2.0 * answer / h, -last
        self.weights = means + (self.weights if self.weights.size else 0.0)
        self.increments = Increments(steps)
        self.answer += answer
        self.memories.append(part)

    def jumped(self, jump: float, h: float, steps: int) -> float:
        """Remember a jump before time 0; the displacement at the first kick by what it does before that.

        Its force there falls as a power of the time: the share of it that a kick in the middle of the step misses.
        """
        self.drive, early = np.zeros(steps), 0.0
        for part in self.memories:
            forces = jump * memory_of(part, h, steps)[0]
            self.drive = self.drive + forces
            early -= forces[0] / self.mass * h**2 * 0.5 * part.order / (2.0 - part.order)
        return early

    def pull(self, rate: float) -> float:
        """The force of dashpots and memory at a kick, without the answer to it."""
        past = self.increments.weighed(self.weights) if self.weights.size else 0.0
        return past + 2.0 * self.answer * rate

    def push(self, u: float) -> float:
        """The force of its springs."""
        force = 0.0
        for k in self._highest_first:
            force = force * u + k
        return -force

    @cached_property
    def _highest_first(self) -> list[float]:
        return np.trim_zeros(self.springs, "b")[::-1].tolist()


# ------------------------------------------------------------------------------------------------ nonlinear dampers
class Damper:
    """A part that is followed alone for half a step before the kick and half a step after it, in reverse order."""

    def __init__(self, part: Any, mass: float, h: float) -> None:
        self.part, self.mass, self.h = part, mass, h
        self.slider, self.last = 0.0, (0.0, 0.0)  # of a part that yields; elongation and rate after the last kick

    def follow(self, n: int, u: float, rate: float, after: bool) -> float:
        """The rate after half of step n."""
        part, half = self.part, 0.5 * self.h / self.mass
        if isinstance(part, sp.Friction):
            return math.copysign(max(abs(rate) - half * part.force, 0.0), rate)
        if isinstance(part, sp.PolynomialDashpot):
            _, c2, c3 = (*part.coefficients, 0.0, 0.0)[:3]
            laws = [
                lambda w: w / (1.0 + half * c2 * abs(w)),
                lambda w: w / math.sqrt(1.0 + 2.0 * half * c3 * w * w),
            ]
            for law in reversed(laws) if after else laws:
                rate = law(rate)
            return rate
        if isinstance(part, sp.VanDerPol):  # to second order, and never beyond 0
            a = half * part.coefficient * (u * u - part.length**2)
            growth = 1.0 + abs(a) + 0.5 * a * a
            return rate / growth if a > 0.0 else rate * growth
        if isinstance(part, sp.Force):  # by the midpoint rule
            t = self.h * (n + 0.5)
            middle = rate + 0.5 * half * part.share * part.function(t, u, rate)
            return rate + half * part.share * part.function(t, u, middle)
        return self._yield(half, u, rate, after)

    def _yield(self, half: float, u: float, rate: float, after: bool) -> float:
        if not after:  # the way since the last kick: one straight line, or two where it turned round
            begin, before = self.last
            way = u - begin
            if before * rate < 0.0:
                there = before * min(max((way - rate * self.h) / (before - rate), 0.0), self.h)
                self._stroke(begin, there)
                self._stroke(begin + there, way - there)
            else:
                self._stroke(begin, way)
        rate -= half * self.part.stiffness * (u - self.slider)
        if after:
            self.last = u, rate
        return rate

    def _stroke(self, begin: float, way: float) -> None:
        part, limit = self.part, self.part.yield_displacement
        if isinstance(part, sp.Jenkins):
            self.slider = min(max(self.slider, begin + way - limit), begin + way + limit)
        elif way != 0.0:
            sign = math.copysign(1.0, way)
            self.slider += sign * self._slip(sign * (begin - self.slider), abs(way), limit)

    def _slip(self, z: float, length: float, limit: float) -> float:
        """How far the slider goes: dz/dx = 1 - r^n, or 1 + (2 beta - 1) r^n before z turns round; r = abs(z) / limit.

        An exponential step of second order in the length, that never overshoots.
        """
        n, turn = self.part.exponent, 2.0 * self.part.beta - 1.0

        def eased(s: float) -> float:
            return (s / 2 + s * s / 3 + s**3 / 6) / (1.0 + s + s * s / 2 + s**3 / 6)

        bent = (abs(z) / limit) ** (n - 1.0)
        steep = 1.0 if z >= 0.0 else -turn
        power = steep * bent * abs(z) / limit
        ease = eased(abs(steep) * n * bent / limit * length)
        whole = max(length * (ease + (1.0 - ease) * power), z + length - limit)
        if z >= 0.0 or z + length - whole <= 0.0:
            return whole
        mean = 2.0 - power  # it passes z = 0 on the way
        left = max(length + 2.0 * z / mean, 0.0)
        start = n / limit if n == 1.0 else 0.0
        return max(left * eased(start * left), left - limit) - z * power / mean


# ------------------------------------------------------------------------------------------------------------ steps
@dataclass
class Path:
    """What was seen of a path: the state at 0, h, 2h, ..., and each impact; and what its kicks were made of."""

    x: Floats
    v: Floats
    impacts: list[Impact]
    rest: list[Rest] = field(default_factory=list)
    touches: list[Touch] = field(default_factory=list)
    kicks: list[Kick] = field(default_factory=list)


@dataclass
class Impact:
    """Where and when, and its closing speed; and the momentum that the wall took."""

    step: int  # of the drift; -1 before the first kick
    wall: str
    speed: float
    momentum: float
    late: bool = False  # in the second half of the drift, after its observation
    rests: bool = False  # the masses would not part, no faster than they are pressed: no impact for observers


@dataclass
class Touch:
    """Of a soft contact: as an impact, and the largest force of the contact, once it is over."""

    step: int
    wall: str
    speed: float
    late: bool
    force: float = 0.0
    ended: tuple[int, bool] | None = None  # in which drift, and whether late in it


@dataclass
class Kick:
    """What observers are told of a kick, along each row and of all sources but white noise and impulses."""

    elongation: dict[tuple[float, ...], float]
    rate: dict[tuple[float, ...], float]  # mean of those before and after it
    pull: dict[tuple[float, ...], float]  # force of dashpots and memory
    yielding: dict[str, float]  # forces of the parts that yield
    given: dict[str, float]  # impulses of these sources
    work: float


@dataclass
class Rest:
    """What a wall takes of masses that come to rest on it, rest or leave it."""

    step: int
    wall: str
    momentum: float
    energy: float


def complementary(a: Floats, w: Floats) -> Floats:
    """c >= 0 with w + a c >= 0, in each row one of them 0: by trying which rows are pressed."""
    for count in range(len(w), -1, -1):
        for rows in map(list, combinations(range(len(w)), count)):
            c = np.zeros(len(w))
            c[rows] = np.linalg.lstsq(a[np.ix_(rows, rows)], -w[rows])[0]
            if (c[rows] >= 0.0).all() and (w + a @ c >= -ROUNDING * np.abs(w).max()).all():
                return c
    raise ArithmeticError("no set of rows is complementary")


def walk(
    system: sp.System, h: float, steps: int, *, seed: int, path: int = 0, words: int = 1, flight: float = 0.0,
    x: Floats | float = 0.0, v: Floats | float = 0.0, remembered: float = 0.0, substeps: int = 1,
    draw: Callable[..., Floats] = normals,
) -> Path:  # fmt: skip
    """One path, from the displacements ``x`` and velocities ``v`` and an empty memory.

    ``words`` is the counter word of the first excitation that is not white; those after it are 128 apart.  With
    ``flight`` the one mass turns with this frequency between the kicks, which have what the springs have beyond it;
    without, drifts are straight.  ``remembered`` is a jump of the one mass just before time 0, which its springpots
    remember: x itself with the derivative of Riemann and Liouville.  ``draw`` gives the normals of white noise.
    """
    at, parts = system.coordinates, dict(system.named())
    solve_mass = np.linalg.inv(at.mass)
    rows: dict[tuple[float, ...], Row] = {}
    walls: list[tuple[str, sp.Barrier, Row]] = []
    for name, g in at.elongations.items():
        mass = 1.0 / float(g @ solve_mass @ g)
        row = rows.setdefault(tuple(g), Row(g, mass, mass * solve_mass @ g))
        part = parts[name]
        if isinstance(part, sp.Barrier):
            walls.append((name, part, row))
        elif isinstance(part, sp.Contact):
            row.contacts.append((name, part))
        elif isinstance(part, sp.Spring | sp.PolynomialSpring):
            own = part.force_coefficients()
            row.springs[: len(own)] += own
        elif isinstance(part, sp.Dashpot | sp.Springpot | sp.Maxwell | sp.FractionalMaxwell):
            row.remember(part, h, steps)
        elif isinstance(part, sp.PolynomialDashpot):
            row.remember(part, h, steps)
            row.dampers.append((name, Damper(part, row.mass, h)))
        elif isinstance(part, sp.ParametricNoise):
            row.shaken.append(part)
        else:
            row.dampers.append((name, Damper(part, row.mass, h)))
    if flight:
        (only,) = rows.values()
        only.springs[1] -= only.mass * flight**2
    contacts = [(name, part, row) for row in rows.values() for name, part in row.contacts]
    dampers = [(name, each, row) for row in rows.values() for name, each in row.dampers]
    solve = np.linalg.inv(at.mass + h * sum(row.answer * np.outer(row.g, row.g) for row in rows.values()))
    constant, impulses, smooth, sources = _excitation(system, [*rows.values()], h, steps, seed, path, words, draw)

    impacts: list[Impact] = []
    rest: list[Rest] = []
    touches: list[Touch] = []
    kicks: list[Kick] = []
    x, v = x + np.zeros(len(at.names)), v + np.zeros(len(at.names))
    pressing = constant
    by_name = {name: (wall, row) for name, wall, row in walls}
    restful = {name for name, wall, row in walls if not wall.is_elastic and not _is_rough(system, wall, row)}
    resting = [name for name in by_name if name in restful and _lies(*by_name[name], x, v)]
    touching: dict[str, Touch] = {}
    leant: dict[str, float] = {}  # impulses of the walls in the last kick
    given = 0.0  # the acceleration by the last kick of a mass that turns

    def presses(name: str) -> float:
        """The acceleration with which all but the wall itself presses on it."""
        wall, row = by_name[name]
        if flight:
            return wall.inwards * (flight**2 * wall.position - given)
        forces = pressing + h * sum(r.push(float(r.g @ x)) * r.g for r in rows.values())
        forces = forces + sum(by_name[n][0].inwards * p * by_name[n][1].g for n, p in leant.items() if n != name)
        return -wall.inwards * float(forces @ row.jump) / row.mass / h

    def book(n: int, name: str, momentum: float, energy: float) -> None:
        rest.append(Rest(n, name, momentum, energy))

    def between(turned: dict[str, Floats]) -> tuple[Floats, Floats]:
        """Of resting rows: changes of their velocities by a unit impulse on each other, and the velocities."""
        sides = {name: by_name[name][0].inwards * by_name[name][1].g for name in resting}
        a = np.array([[float(g @ turned[other]) for other in resting] for g in sides.values()])
        return a, np.array([float(g @ v) for g in sides.values()])

    def hold(n: int) -> None:
        """The walls take what presses on resting rows; those that nothing presses on leave with half of the kick."""
        nonlocal v, leant
        turned = {name: by_name[name][0].inwards * solve @ by_name[name][1].g for name in resting}
        a, w = between(turned)
        p = complementary(a, w)
        scale = max(np.abs(w).max(), *(abs(leant.get(name, 0.0)) / by_name[name][1].mass for name in resting))
        opened = w + a @ p > ROUNDING * scale
        left = np.where(opened, w + a @ p, 0.0)
        if opened.any():
            p = p + np.linalg.lstsq(a, -0.5 * left)[0]
        v = v + sum(each * turned[name] for each, name in zip(p, resting, strict=True))
        leant |= {name: leant.get(name, 0.0) + each for name, each in zip(resting, p, strict=True)}
        for name, each, later in zip(resting, p, 0.5 * left, strict=True):
            book(n, name, each, -0.5 * each * later)
        resting[:] = [name for name, leaves in zip(resting, opened, strict=True) if not leaves]

    def hold_turning(n: int, step_gives: float, moving: float, settled: bool) -> float:
        """The same of one mass, on which its spring acts in the flight; its speed away from the wall."""
        nonlocal v, given
        (name,) = resting
        wall, row = by_name[name]
        given = wall.inwards * step_gives / h
        leaves = presses(name) < 0.0 and moving > 0.0
        later = 0.5 * moving if leaves else 0.0
        v = v * 0.0 + wall.inwards * later
        if settled:
            book(n, name, row.mass * (-later if leaves else -step_gives), 0.0)
            if presses(name) < 0.0:
                resting.clear()
        return later

    def advance(time: float) -> None:
        nonlocal x, v
        c, s = math.cos(flight * time), math.sin(flight * time)
        x, v = (c * x + s / flight * v, c * v - s * flight * x) if flight else (x + time * v, v)

    def bear(n: int, name: str, left: float) -> None:
        """The wall takes the force of the spring of the flight on a mass that stays there until its end."""
        wall, row = by_name[name]
        book(n, name, row.mass * wall.inwards * flight**2 * wall.position * left, 0.0)

    def come_to_rest(n: int, name: str, speed: float, true: float) -> None:
        """The row, and with it all rows that rest, has the velocity 0; the walls take the energy that was left."""
        nonlocal v
        if name not in resting:
            resting.append(name)
        turned = {one: by_name[one][0].inwards * by_name[one][1].jump / by_name[one][1].mass for one in resting}
        a, w = between(turned)
        p = complementary(a, w)
        v = v + sum(each * turned[one] for each, one in zip(p, resting, strict=True))
        later = w + a @ p
        for one, each, mean in zip(resting, p, 0.5 * (w + later), strict=True):
            book(n, one, each, -each * mean * (true / speed) ** 2)
        resting[:] = [one for one, rate in zip(resting, later, strict=True) if rate <= ROUNDING * speed]

    def fly(left: float, since: float, n: int) -> None:
        """Half a drift: the earliest impact first.  It begins at ``since`` after the middle between two kicks."""
        nonlocal x, v
        end, late, most = since + left, since >= 0.0, 0.0  # the largest change of a velocity by an impact
        if flight and resting:
            if presses(resting[0]) > 0.0 or _is_bent(by_name[resting[0]][0]):
                bear(n, resting[0], left)
                return
            resting.clear()
        if flight and any(_is_bent(wall) and _lies(wall, row, x, v) for _, wall, row in walls):
            return  # one that lies still on a wall against which its spring presses goes nowhere
        while True:
            moving = [each for each in walls if each[0] not in resting or -_rate(*each[1:], v) > ROUNDING * most > 0.0]
            found = min(_meetings(moving, x, v, flight, left), default=None, key=lambda each: each[0])
            if found is None:
                break
            time, (name, wall, row) = found
            advance(time)
            left -= time
            side = wall.inwards
            speed = -side * float(row.g @ v)
            x = x + (wall.position - row.g @ x) * row.jump  # onto the wall, where rounding left it beside it
            # a kick gives all of a step's impulse at once, half a step too soon or too late
            press = presses(name)
            can_rest = name in restful and press > 0.0
            by_kicks = press - side * flight**2 * wall.position  # without what the circle of a flight pulls with
            later = speed + by_kicks * (end - left)
            if can_rest:
                closing = speed if name in leant or name in resting else max(later, 0.0)
            else:
                closing = speed if flight or later <= 0.0 else later
            r = restitution_of(wall, closing)
            most = max(most, closing + r * closing, speed)
            if can_rest and r * closing <= 0.5 * press * h:
                come_to_rest(n, name, speed, closing)
                if flight:
                    x, v = x * 0.0 + wall.position, v * 0.0
                    bear(n, name, left)
                    return
                continue
            change = max(closing + r * closing, speed)
            v = v + side * change * row.jump
            rests = not flight and closing + r * closing <= speed and closing <= press * h
            impacts.append(Impact(n, name, closing, row.mass * change, late, rests))
            resting[:] = [one for one in resting if one != name and _rate(*by_name[one], v) <= ROUNDING * most]
            if flight and change == speed and _is_bent(wall):  # held by the spring until the end
                resting.append(name)
                bear(n, name, left)
                return
        advance(left)
        for one in resting:
            wall, row = by_name[one]
            x = x + (wall.position - row.g @ x) * row.jump

    def drift(since: float, n: int) -> None:
        """Half a drift; with contacts in short steps, in the middle of each a kick by the contacts alone."""
        if not contacts:
            fly(0.5 * h, since, n)
        short = 0.5 * h / substeps
        for k in range(substeps if contacts else 0):
            fly(0.5 * short, since + k * short, n)
            touch(n, since >= 0.0)
            squeeze(short)
            fly(0.5 * short, since + (k + 0.5) * short, n)
            touch(n, since >= 0.0)

    def squeeze(short: float) -> None:
        """A kick by the contacts alone; the dissipation k d^p chi d' with the mean of the rates before and after."""
        nonlocal v
        for name, part, row in contacts:
            rate, force = float(row.g @ v), _elastic(part, float(row.g @ x))
            share = 0.5 * short * abs(force) * part.dissipation / row.mass
            change = (short * force / row.mass - 2.0 * share * rate) / (1.0 + share)
            v = v + change * row.jump
            if name in touching:
                touching[name].force = max(touching[name].force, part.inwards * change * row.mass / short)

    def touch(n: int, late: bool) -> None:
        """Touches begin and end where flights do."""
        for name, part, row in contacts:
            is_inside = _elastic(part, float(row.g @ x)) != 0.0
            if is_inside and name not in touching:
                touching[name] = Touch(n, name, abs(float(row.g @ v)), late)
                touches.append(touching[name])
            elif not is_inside and name in touching:
                touching.pop(name).ended = n, late

    def told(n: int, middle: Floats) -> Kick:
        rates = {g: float(row.g @ middle) for g, row in rows.items()}
        pulls = {g: row.pull(rates[g]) for g, row in rows.items()}
        work = sum(row[n] * float(force @ middle) for row, force in sources.values())
        u = {g: float(row.g @ x) for g, row in rows.items()}
        yielding = {
            name: damper.part.stiffness * (float(row.g @ x) - damper.slider) for name, damper, row in dampers
            if isinstance(damper.part, sp.Jenkins | sp.BoucWen)
        }  # fmt: skip
        return Kick(u, rates, pulls, yielding, {name: float(row[n]) for name, (row, _) in sources.items()}, work)

    seen = [(x.copy(), v.copy())]
    before = x.copy()
    fly(0.5 * h, 0.0, -1)
    early = [row.jumped(remembered, h, steps) for row in rows.values()] if remembered else []
    x = x + sum(early)
    for n in range(steps):
        for row in rows.values():
            if row.weights.size:
                row.increments.add(float(row.g @ (x - before)))
        before = x.copy()
        pushed = np.zeros(len(v))  # by dampers; friction does not press
        for _, damper, row in dampers:
            rate = float(row.g @ v)
            more = (damper.follow(n, float(row.g @ x), rate, False) - rate) * row.jump
            v, pushed = v + more, pushed + more * (not isinstance(damper.part, sp.Friction))
        impulse = constant + impulses(n, x)
        for row in rows.values():
            u, rate = float(row.g @ x), float(row.g @ v)
            force = row.push(u) - row.pull(rate) - (row.drive[n] if remembered else 0.0)
            impulse = impulse + h * force * row.g
        leant, change, leaving = {}, solve @ impulse, v
        v = v + change
        held = bool(flight and resting)
        if held:
            wall, row = by_name[resting[0]]
            share = 1.0 / (row.mass * float(row.g @ solve @ row.g))  # without the answer of springpots and dashpots
            moving = wall.inwards * float(v[0])
            leaving = hold_turning(n, share * moving, moving, not dampers)
        elif resting:
            hold(n)
        kicks.append(told(n, 0.5 * (leaving + v)))
        for _, damper, row in reversed(dampers):
            rate = float(row.g @ v)
            more = (damper.follow(n, float(row.g @ x), rate, True) - rate) * row.jump
            v, pushed = v + more, pushed + more * (not isinstance(damper.part, sp.Friction))
        if held and dampers:  # all is settled when they have acted after the kick, too
            own = wall.inwards * float(v[0]) - leaving
            hold_turning(n, share * moving + own, moving + own, True)
        elif resting and dampers:
            hold(n)
        if flight and not held:
            given = float((change + pushed)[0]) / h
        pressing = constant + smooth(n)
        drift(-0.5 * h, n)
        seen.append((x.copy(), v.copy()))
        drift(0.0, n)
    return Path(*(np.array(each) for each in zip(*seen, strict=True)), impacts, rest, touches, kicks)


def walk_as_printed(
    problem: sp.System, h: float, steps: int, *, seed: int, path: int = 0, x: float = 0.0, remembered: float = 0.0,
    contact: float = 1e-5, draw: Callable[..., Floats] = normals,
) -> Path:  # fmt: skip
    """One path of the paper's scheme: Grunwald and Letnikov's derivative, Euler's step, and an impact where the mass
    comes within ``contact`` of the wall below it, or is beyond it, and moves towards it.
    """
    parts = {type(part): part for part in problem.parts}
    spring, pot, noise = parts[sp.Spring], parts[sp.Springpot], parts[sp.WhiteNoise]
    wall, g = parts.get(sp.Barrier), math.sqrt(noise.intensity * h) * draw(seed, path, steps, 0)
    lag = np.arange(1.0, steps + 1.0)
    weights = pot.coefficient * h**-pot.order * np.append(1.0, np.cumprod(1.0 - pot.order / lag))
    increments, v, impacts, seen = Increments(steps + 1), 0.0, [], [(x, 0.0)]
    increments.add(0.0)
    for n in range(steps):
        memory = increments.weighed(weights) + weights[n] * remembered
        v += g[n] - h * (spring.stiffness * x + memory)
        moved = x + h * v
        if wall and moved <= wall.position + contact and v < 0.0:
            impacts.append(Impact(n, "barrier", -v, -(1.0 + wall.restitution) * v))
            v *= -wall.restitution
        increments.add(moved - x)
        x = moved
        seen.append((x, v))
    return Path(*np.array(seen).T[..., None], impacts)


def restitution_of(wall: sp.Barrier, speed: float) -> float:
    """The share r of its speed with which a mass leaves: a number, the power law, or a function of the user."""
    law: Any = wall.restitution
    if isinstance(law, sp.PowerRestitution):
        r = law.restitution * (speed / law.speed) ** -law.exponent if speed > 0.0 else 1.0
    else:
        r = law(speed) if callable(law) else law
    return min(1.0, max(0.0, r))


def _elastic(part: sp.Contact, u: float) -> float:
    depth = max(part.inwards * (part.position - u), 0.0)
    return part.inwards * part.stiffness * depth**part.exponent


def _lies(wall: sp.Barrier, row: Row, x: Floats, v: Floats) -> bool:
    """Whether a row is at its wall and does not move."""
    return bool(row.g @ x == wall.position and row.g @ v == 0.0)


def _rate(wall: sp.Barrier, row: Row, v: Floats) -> float:
    """With which a row moves away from its wall."""
    return wall.inwards * float(row.g @ v)


def _is_bent(wall: sp.Barrier) -> bool:
    """Whether the spring of a flight presses on a wall."""
    return wall.inwards * wall.position > 0.0


def _is_rough(system: sp.System, wall: sp.Barrier, row: Row) -> bool:
    """Whether noise with independent increments drives the two ends of a wall apart, or together."""
    at, parts = system.coordinates, dict(system.named())
    driven = [
        force for name, force in at.forces.items()
        if isinstance(parts[name], sp.PoissonImpulses | sp.WhiteNoise) and parts[name].intensity > 0.0
    ]  # fmt: skip
    shaken = [at.elongations[name] for name, part in parts.items() if isinstance(part, sp.ParametricNoise)]
    rough = any(abs(row.jump @ each) > 1e-12 * (np.abs(row.jump) @ np.abs(each)) for each in [*driven, *shaken])
    return rough or bool(system.of(sp.ThermalNoise))


def _meetings(
    walls: list[tuple[str, sp.Barrier, Row]], x: Floats, v: Floats, flight: float, left: float
) -> Iterator[tuple[float, Any]]:
    """The times after which a flight meets each wall, if it does within the time that is left."""
    for wall in walls:
        side, place = wall[1].inwards, wall[1].inwards * wall[1].position
        y, rate = side * float(wall[2].g @ x), side * float(wall[2].g @ v)
        if flight:
            size = math.hypot(y, rate / flight)
            if y <= place and rate < 0.0:
                time = 0.0
            elif size <= abs(place):
                continue
            else:
                time = (math.acos(place / size) - math.atan2(-rate / flight, y)) % (2.0 * math.pi) / flight
        else:
            time = max(y - place, 0.0) / -rate if rate < 0.0 else math.inf
        if time < left:
            yield time, wall


def _excitation(
    system: sp.System, rows: list[Row], h: float, steps: int, seed: int, path: int, words: int,
    draw: Callable[..., Floats],
) -> tuple[Floats, Callable[[int, Floats], Floats], Callable[[int], Floats], Sources]:  # fmt: skip
    """The impulses on the masses in a step: constant; those of step n, at x; of these what changes little; the sources.

    White noise has the first counter words, one each; all else has 128 words each behind them.
    """
    at, parts = system.coordinates, dict(system.named())
    constant, rough, shaken, given = np.zeros(len(at.names)), [], [], []
    sources: Sources = {}  # that feed something in

    def numbers() -> Numbers:
        return Numbers(draw, seed, path, words + 128 * len(given))

    for name, force in at.forces.items():
        part = parts[name]
        if part.of_ground and not isinstance(part, sp.RecordedExcitation):
            force = -force  # all else is drawn, and its sign means nothing
        if isinstance(part, sp.Constant):
            constant = constant + h * part.force * force
        elif isinstance(part, sp.WhiteNoise) and part.envelope is None:
            rough.append(math.sqrt(part.intensity * h) * force)
        else:
            impulses = GIVEN[type(part)](part, h, steps, numbers())
            is_smooth = not isinstance(part, sp.PoissonImpulses | sp.WhiteNoise)
            given.append((impulses, force, is_smooth))
            sources |= {name: (impulses, force)} if is_smooth else {}
    for thermal in system.of(sp.ThermalNoise):
        for row in rows:
            if any(not isinstance(part, sp.Dashpot) for part in row.memories):
                impulses = matched(row.memories, thermal.temperature, h, steps, numbers())
                given.append((impulses, row.g, False))
                sources[f"{thermal} of row {len(given)}"] = impulses, row.g
            elif row.memories:
                rough.append(math.sqrt(2.0 * thermal.temperature * h * dashpots_in(row.memories)) * row.g)
    for row in rows:
        for part in row.shaken:
            shaken.append((row.g, math.sqrt(part.intensity * h) * envelope_of(part, h, steps)[1:]))
    drawn = [draw(seed, path, steps, word) for word in range(len(rough) + len(shaken))]

    def at_step(n: int, x: Floats) -> Floats:
        found = np.zeros(len(at.names))
        for force, sizes in zip(rough, drawn, strict=False):
            found = found + force * sizes[n]
        for (g, root), sizes in zip(shaken, drawn[len(rough) :], strict=True):
            found = found + root[n] * abs(float(g @ x)) * sizes[n] * g
        return found + sum((row[n] * force for row, force, _ in given), np.zeros(len(at.names)))

    def smooth(n: int) -> Floats:
        return sum((row[n] * force for row, force, slow in given if slow), np.zeros(len(at.names)))

    return constant, at_step, smooth, sources
