"""The rates, times and sizes of any system: a rough guess of its stationary state, which sets step, duration and units.

The energy is guessed by a balance: what the excitation feeds in at the system's own frequency, against what dampers,
memory and walls take out, both for a Maxwell-Boltzmann law at an unknown temperature.  The step is set from the
fastest motion of that law, the duration from its slowest; nothing else depends on the guess.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.without_scipy import root_between
from springpot.problem.parts import Springpot
from springpot.problem.parts.springpots import resonance
from springpot.problem.parts.walls import Stop, restitution_at
from springpot.problem.potential import Potential
from springpot.problem.system import System
from springpot.simulation.plan.loose import held_by_springpots, springpot_alone
from springpot.simulation.plan.scales import Scales, beat, creep_time
from springpot.simulation.plan.schemes import Splitting
from springpot.simulation.plan.struck import Pressed

_FARTHEST = 25.0  # energy, in kT above the least, that a long run of many paths hardly exceeds
_POINTS = 4001
_LEAST_SHARE = 1e-200
_CLOSE = {"xtol": 1e-300, "rtol": 1e-14}  # of a root
_GUESSED = 1.5  # factor on the forgetting time
OF_HOPS = 0.1  # of the rate that the default step follows on a pressed wall: what longer steps must follow
_NOT_HELD = "system must have a spring, or a wall on each side: without them nothing holds the mass in place."
_DRIFTS = "system must have a spring, or a wall on each side: with parts that yield alone the mass drifts without end."


@dataclass(frozen=True, eq=False)
class BoltzmannLaw:
    """exp(-U(x) / kT), on a grid of places between the walls.

    Attributes
    ----------
    temperature : float
        kT per unit mass.
    places, shares : ndarray
        The grid and the probability of each place.
    """

    temperature: float
    places: Floats
    shares: Floats

    @property
    def mean(self) -> float:
        """E[x]."""
        return float(self.shares @ self.places)

    @property
    def variance(self) -> float:
        """Of x."""
        return float(self.shares @ (self.places - self.mean) ** 2)

    @property
    def frequency(self) -> float:
        """That of the linear spring with the same variance; infinite if double precision shows none."""
        return math.sqrt(self.temperature / self.variance) if self.variance > 0.0 else math.inf

    @property
    def is_resolved(self) -> bool:
        """Whether its places differ, in double precision."""
        return self.variance > 0.0 and bool(self.places[1] > self.places[0])

    def density_at(self, place: float) -> float:
        """p(x) at a place on the grid or at its end."""
        spacing = float(self.places[1] - self.places[0])
        return float(np.interp(place, self.places, self.shares)) / spacing if spacing > 0.0 else math.inf

    def mean_of(self, function: Callable[[Floats], Floats]) -> float:
        """Of a function of x."""
        return float(self.shares @ function(self.places))

    def drawn(self, chance: Floats) -> Floats:
        """Places below which x lies with these probabilities."""
        edges = np.concatenate([[0.0], np.cumsum(0.5 * (self.shares[1:] + self.shares[:-1]))])
        return np.interp(chance, edges / edges[-1], self.places)


def boltzmann_law(potential: Potential, temperature: float) -> BoltzmannLaw:
    """The law of x at a temperature (per unit mass)."""
    grid = _around_the_wells(potential)
    depth = potential.energy(grid)
    limit = float(depth.min()) + _FARTHEST * temperature
    within = np.flatnonzero(depth <= limit)
    low, high = (potential.edge(grid[within[end]], sign, limit) for end, sign in ((0, -1.0), (-1, 1.0)))
    if not math.isfinite(high - low):
        raise ValueError(_NOT_HELD)
    places = np.linspace(low, high, _POINTS)
    energy = potential.energy(places)
    weights = np.exp(-np.minimum((energy - energy.min()) / temperature, 700.0))
    weights[[0, -1]] *= 0.5
    return BoltzmannLaw(temperature, places, weights / weights.sum())


@lru_cache(maxsize=16)
def _around_the_wells(potential: Potential) -> Floats:
    """Places between the walls: all where the potential is least, and a grid from the first to the last of them."""
    powers = np.array(potential.coefficients[::-1])
    # a power that matters only at lengths beyond all use has no root there, and a ratio of coefficients no overflow
    roots = np.roots(np.where(np.abs(powers) > _LEAST_SHARE * np.abs(powers).max(), powers, 0.0))
    real = roots[np.abs(roots.imag) < 1e-9 * (1.0 + np.abs(roots))].real
    touches = [contact.position for contact in potential.contacts]
    low, high = max(potential.low, -1e300), min(potential.high, 1e300)
    inside = [min(max(float(place), low), high) for place in (*real, *touches, 0.0)]
    first, last = (_uphill(potential, end, sign) for end, sign in ((min(inside), -1.0), (max(inside), 1.0)))
    grid = np.linspace(first, last, 2001)
    force = potential.force(grid)
    wells = [
        root_between(potential.force, float(grid[i]), float(grid[i + 1]), **_CLOSE)
        for i in np.flatnonzero((force[:-1] < 0.0) & (force[1:] > 0.0))
    ]
    return np.unique(np.concatenate([grid, inside, wells]))


def _uphill(potential: Potential, start: float, sign: float) -> float:
    """The first place from ``start`` on where the potential rises, or the wall."""
    end = potential.low if sign < 0.0 else potential.high
    place, reach = start, max(abs(start) * 1e-12, 1e-30)
    while sign * float(potential.force(place)) < 0.0 and sign * (end - place) > 0.0:
        place, reach = start + sign * reach, 2.0 * reach
    return float(min(place, end) if sign > 0.0 else max(place, end))


def dissipated(parts: Iterable[Any], law: BoltzmannLaw, frequency: float | None = None) -> float:
    """Power taken out by dampers, memory and walls per unit mass; at the frequency of the law if none is given."""
    w, rate, power = law.frequency if frequency is None else frequency, 0.0, 0.0
    for part in parts:
        own_rate, own_power = part.taken_from(law, w)
        rate, power = rate + own_rate, power + own_power
    return rate * law.temperature + power


def _fed(unit: System, law: BoltzmannLaw) -> float:
    """Power fed in by the excitation at this law, per unit mass."""

    def rate() -> float:
        return dissipated(unit.parts, law) / law.temperature

    square = law.variance + law.mean**2
    return sum((part.fed_into(law.frequency, rate, square) for part in unit.parts), 0.0)


def guessed_law(system: System) -> BoltzmannLaw:
    """The Boltzmann law at the temperature at which as much is fed in as is taken out.

    Raises
    ------
    ValueError
        If nothing holds the mass, or it moves less than numbers can tell.
    """
    unit = system.per_unit_mass
    potential = _holding(unit)
    if not potential.holds():
        raise ValueError(_DRIFTS if any(part.yields for part in unit.parts) else _NOT_HELD)
    law = boltzmann_law(potential, _temperature(unit, potential))
    if not law.is_resolved:
        raise ValueError(f"system must move by more than rounding: its motion about {law.places[0]:g} m is too small.")
    return law


def _holding(unit: System) -> Potential:
    """The potential, or that of the stiffness of springpots where they alone hold."""
    return held_by_springpots(unit) if springpot_alone(unit) else unit.potential


def guessed_scales(system: System, law: BoltzmannLaw) -> Scales:
    """The rates, times and sizes of a system, from its guessed law.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, PolynomialSpring, Spring, WhiteNoise
    >>> bent = System(Spring(1.0), PolynomialSpring((0, 0, 1.0)), Dashpot(0.5), WhiteNoise(1.0))
    >>> scales = guessed_scales(bent, guessed_law(bent))
    >>> round(scales.length, 3), round(scales.energy_time, 6)
    (0.684, 2.0)
    """
    unit, theta = system.per_unit_mass, law.temperature
    potential = _holding(unit)
    linear = potential.coefficients[1] if len(potential.coefficients) > 1 else 0.0
    frequency = math.sqrt(linear) if linear > 0.0 else law.frequency
    smooth = replace(potential, contacts=())
    curved = float(np.abs(smooth.curvature(law.places) - frequency**2).max())
    near = law.places[law.shares > 0.01 * law.shares.max()]
    rates = [frequency, math.sqrt(float(np.abs(smooth.curvature(near)).max())), 0.5 * math.sqrt(curved)]
    rates += [_hops(smooth, law, frequency, stop) for stop in unit.stops.values()]
    hops = rate_on_pressed_walls(unit, law)
    rates.append(OF_HOPS * hops)
    rates += [part.fastest_rate(law) for part in unit.parts]
    creep = [_creep_time(part, law.frequency) for part in unit.springpots.values()]
    # the motion is faster, and loses its energy more slowly, by the stiffness of what has memory
    stiffened = resonance(law.frequency**2, [part for part in unit.parts if part.remembers])
    taken = dissipated(unit.parts, law, stiffened) + sum(part.fed_beside(law) for part in unit.parts)
    energy_time = beat(unit) * theta / taken if taken > 0.0 else math.inf
    # the dashpots that the fast motion makes of parts that yield, for slow displacements
    yielded = sum(part.slow_dashpot(law.frequency**2, theta) for part in unit.parts)
    own_time, yielding = max(part.time_of_its_own for part in unit.parts), _overdamped_time(yielded, law.frequency)
    settled = max(energy_time, own_time, _hopping_time(law, potential))
    forgetting = _GUESSED * max(energy_time, own_time, 2.0 / law.frequency, 0.5 * yielding)
    return Scales(
        frequency=law.frequency,
        fastest_rate=max(rates),
        resolved_rate=hops,
        energy_time=settled,
        creep_time=max([_overdamped_time(unit.dashpots, law.frequency), yielding, *creep]),
        forgetting_time=forgetting,
        settling_time=max(settled, forgetting),
        flight_frequency=frequency,
        length=math.sqrt(law.variance + law.mean**2),
        spread=math.sqrt(law.variance),
        mean=law.mean,
        guessed=True,
    )


def _temperature(unit: System, potential: Potential) -> float:
    """kT at which as much is fed in as is taken out; that of the thermal noise where there is one."""
    if unit.thermal:
        return unit.thermal.temperature
    size = _natural_energy(potential)
    if not any(part.feeds for part in unit.parts):
        return size

    def is_fed(theta: float) -> bool:
        return not _surplus(unit, potential, theta) <= 0.0

    for powers in (np.linspace(12.0, -12.0, 97), np.linspace(90.0, -90.0, 361)):  # the second where size means nothing
        thetas = (size * 10.0**powers).tolist()
        # these feed in most at some frequency: the hottest of several is found by a walk
        if any(part.is_banded for part in unit.excitations.values()):
            hot = next((n for n, theta in enumerate(thetas) if is_fed(theta)), len(thetas))
        else:
            hot = bisect_left(thetas, True, key=is_fed)
        if 0 < hot < len(thetas) and not math.isnan(_surplus(unit, potential, thetas[hot])):
            return root_between(lambda theta: _surplus(unit, potential, theta), thetas[hot], thetas[hot - 1], **_CLOSE)
    return size


def _surplus(unit: System, potential: Potential, theta: float) -> float:
    """Power fed in and not taken out at a temperature; NaN where double precision shows no motion."""
    law = boltzmann_law(potential, theta)
    return _fed(unit, law) - dissipated(unit.parts, law) if law.is_resolved else math.nan


def _natural_energy(potential: Potential) -> float:
    """An energy of the potential itself: of the room between the walls, or of a length of its own; 1 if it has none."""
    ends = [end for end in (potential.low, potential.high) if math.isfinite(end)]
    if len(ends) == 2:
        places = np.linspace(ends[0], ends[1], 101)
    else:
        touches = [contact.position for contact in potential.contacts]
        length = max((abs(end) for end in (ends or touches)), default=0.0) or 1.0
        near = ends[0] if ends else 0.0
        places = np.linspace(near - (potential.low != near) * length, near + (potential.high != near) * length, 101)
    return float(np.ptp(potential.energy(places))) or 1.0


def _hopping_time(law: BoltzmannLaw, potential: Potential) -> float:
    """Mean time to cross the highest barrier between two wells, by Kramers' rate; 0 for a single well."""
    depth = potential.energy(law.places) / law.temperature
    rising = np.sign(np.diff(depth))
    tops = 1 + np.flatnonzero((rising[:-1] > 0.0) & (rising[1:] < 0.0))
    times = [0.0]
    for top in tops:
        climb = depth[top] - max(depth[:top].min(), depth[top:].min())
        if climb > 1.0:
            times.append(2.0 * math.pi / law.frequency * math.exp(min(float(climb), 700.0)))
    return max(times)


def _hops(potential: Potential, law: BoltzmannLaw, frequency: float, wall: Stop) -> float:
    """Rate of the hops on a wall that the kicks press the mass against: they must be shared by many kicks.

    With too few, each impact changes the energy at random, which heats a motion with little damping.
    """
    pressing = wall.inwards * (float(potential.force(wall.position)) - frequency**2 * wall.position)
    return max(pressing, 0.0) / math.sqrt(law.temperature) if _is_reached(potential, law, wall) else 0.0


def rate_on_pressed_walls(unit: System, law: BoltzmannLaw) -> float:
    """The rate that a step must follow where white noise lets a pressed mass hop on a lossy wall; 0 without one."""
    if not any(part.noise == "white" for part in unit.parts):  # under which a mass on a wall never rests
        return 0.0
    theta, smooth = law.temperature, replace(unit.potential, contacts=())
    damping = dissipated((part for name, part in unit.named() if name not in unit.walls), law) / theta
    fed = damping * theta if unit.thermal else _fed(unit, law)
    rates = [0.0]
    for wall in unit.walls.values():
        press = wall.inwards * float(smooth.force(wall.position))
        own = Pressed(press, restitution_at(wall, math.sqrt(2.0 * theta)))
        if press > 0.0 and own.restitution < 1.0 and fed > 0.0 and _is_reached(smooth, law, wall):
            rates.append(own.rate(own.speed(fed, damping), Splitting.default_step))
    return max(rates)


def _is_reached(potential: Potential, law: BoltzmannLaw, wall: Stop) -> bool:
    """Whether the mass is often at a wall: not where it lies high above the least of the potential."""
    depth = float(potential.energy(wall.position) - potential.energy(law.places).min())
    return depth < 5.0 * law.temperature


def _overdamped_time(damping: float, frequency: float) -> float:
    """Time in which x forgets its start where dashpots are stronger than the spring of the same law."""
    return damping / frequency**2 if damping > frequency else 0.0


def _creep_time(springpot: Springpot, frequency: float) -> float:
    """As that of an oscillator of this frequency."""
    if not springpot.remembers or springpot.coefficient <= frequency ** (2.0 - springpot.order):
        return 0.0
    return creep_time(springpot.coefficient / frequency**2, springpot.order)
