"""What is known of a motion before it is simulated: its scales, walls and memory, and which results it can have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, few, meant, shown
from springpot.problem.catalogue import LEVELS
from springpot.problem.felt import Felt, felt_in
from springpot.problem.parts import (
    Barrier,
    CloughPenzienNoise,
    ColoredNoise,
    Excitation,
    Force,
    Harmonic,
    KanaiTajimiNoise,
    ParametricNoise,
    PoissonImpulses,
    RecordedExcitation,
    SpectralExcitation,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.parts.walls import SoftStop, Stop, restitution_at, restitution_of_missed, slow_restitution
from springpot.problem.system import System
from springpot.simulation.kernel.feeling import MOST_FELT
from springpot.simulation.plan.creep import Creep
from springpot.simulation.plan.guess import BoltzmannLaw, guessed_law
from springpot.simulation.plan.options import Scheme, SchemeOfRun
from springpot.simulation.plan.origin import origin_of, seen_from
from springpot.simulation.plan.pressed import Pressed
from springpot.simulation.plan.scales import Scales
from springpot.simulation.plan.seen import Seen
from springpot.simulation.plan.unsprung import CreepAlone
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.walls import Before, before_walls

if TYPE_CHECKING:
    from springpot.simulation.plan.creep_of_several import CreepOfSeveral

_COUNTABLE = 1.0001 * COLLAPSE_BELOW
_FED = (ColoredNoise, KanaiTajimiNoise, CloughPenzienNoise, SpectralExcitation, PoissonImpulses, ThermalNoise)
_LATER = 1.2  # ratio of the times at which a transient is looked at
_EVEN = 1e-9  # standard deviations of a mean that counts as 0
_SMOOTH = (*_FED, ParametricNoise)
"""Noise under which a mass can come to rest on a lossy wall after infinitely many impacts."""


@dataclass(frozen=True)
class StruckWalls:
    """Walls as slow impacts see them.

    Attributes
    ----------
    restitution : float
        1 also where there is no wall, or walls of different restitutions.
    intensity : float
        Of the white noise per unit mass, in m^2 s^-3.
    press : float
        Acceleration with which the springs press the mass on a wall, in m/s^2; not positive without a preload.
    """

    restitution: float = 1.0
    intensity: float = 0.0
    press: float = 0.0

    @property
    def crowded(self) -> bool:
        """Whether slow impacts are frequent and can be added: the walls are lossy, and the impact rate is finite."""
        return COLLAPSE_BELOW < self.restitution < 1.0 and self.intensity > 0.0

    def resolved_speed(self, step: float) -> float:
        """The lower of the two speeds in m/s at which impacts are counted so that the errors of a step cancel.

        In units of sqrt(q h); see `springpot.simulation.estimate.completed_rate`.
        """
        return (0.47 + 0.43 * self.restitution) * math.sqrt(self.intensity * step)


def countable_restitution(wall: Barrier, intensity: float, step: float) -> float:
    """The restitution of the impacts that a step misses; of a law at least one with which impacts have a rate.

    A law may be below that limit for them and above it for slower ones.

    Examples
    --------
    >>> countable_restitution(Barrier(-1.0, 0.5), 1.0, 0.01)
    0.5
    """
    return max(restitution_of_missed(wall, intensity, step), _COUNTABLE)


@dataclass(frozen=True, eq=False)
class KeptMean:
    """An elongation whose mean a springpot remembers.

    Attributes
    ----------
    name : str
        How the names of its results begin.
    row : ndarray
        Its elongation in displacements of the masses.
    order, coefficient : float
        Of the springpot, per unit of the mass that moves along the row.
    """

    name: str
    row: Floats
    order: float
    coefficient: float


@dataclass(frozen=True, eq=False)
class Motion:
    """A system and what follows from it alone.  Made by `springpot.simulation.plan.motions.motion_of`.

    Attributes
    ----------
    system : System
        The user's own.
    scales : Scales
    sign : float
        -1 where the wall of the paper's problem lies above the motion, else 1.
    slow : tuple of Creep or CreepOfSeveral
        The slow displacements of springpots, without walls.
    searched : bool
        Whether E[x], the x(0) of a stationary start, must be found by pilot runs.
    keeps_the_law : bool
        Whether a long step leaves the stationary law as it is: a dashpot, white noise, and an elastic wall at most.
    beyond_paper : str
        Which part the paper's problem does not have, in one sentence; empty if it is that problem.
    guess : BoltzmannLaw or None
        From which the scales are; None where they have closed forms.
    """

    system: System
    scales: Scales
    sign: float
    slow: tuple[Creep | CreepOfSeveral | CreepAlone, ...]
    searched: bool
    keeps_the_law: bool
    beyond_paper: str = ""
    guess: BoltzmannLaw | None = None

    @cached_property
    def origin(self) -> float:
        """The place in m from which the kernel measures x; see `springpot.simulation.plan.origin`."""
        return origin_of(self.system)

    @cached_property
    def centred(self) -> System:
        """The system as seen from there: scales, guesses and the kernel have its places."""
        return seen_from(self.system, self.origin)

    def square_about_origin(self, values: Mapping[str, float], mean: str = "x_mean") -> float:
        """E[(x - origin)^2] from the results of a run, of one of the means."""
        return max(values[f"{mean}_square"] - self.origin * (2.0 * values[mean] - self.origin), 0.0)

    @cached_property
    def seen(self) -> tuple[Seen, ...]:
        """The displacements whose distributions and spectra a run can have."""
        names = {name: name for name in ("x", "v", "amplitude", "impact_speed")}
        if not self.system.natural_frequency > 0.0:
            del names["amplitude"]
        return (Seen(names, stop="", low=self.low, high=self.high),)

    @cached_property
    def levels(self) -> dict[str, tuple[str, Seen]]:
        """What can pass a level, by name: the quantity, and the displacement that it is of."""
        # an impact is reported without its place: of several walls it may be any, and the ends of steps have to do
        one_wall = len(self.touched) == len(self.walls) <= 1
        own = Seen(stop="" if one_wall else None, low=self.low, high=self.high)
        return {name: (name, own) for name in LEVELS}

    @property
    def speeds(self) -> dict[str, Seen]:
        """Speeds of impacts by name, each with what it is of."""
        return {one.names["impact_speed"]: one for one in self.seen if "impact_speed" in one.names}

    @cached_property
    def felt(self) -> dict[str, Felt]:
        """Forces of parts and accelerations, in the order in which the kernel shows them."""
        return felt_in(self.system)

    @property
    def of_impacts(self) -> dict[str, Seen]:
        """The largest forces of the touches of soft contacts, and the impulses of impacts on rigid walls, by name."""
        found, at = dict[str, Seen](), self.system.coordinates
        for stop, part in self.touched.items():
            if isinstance(part, SoftStop):
                name = f"{stop}_peak_force"
                found[name] = Seen({"impact_speed": name}, None, stop=stop, peaks=True)
            elif isinstance(part, Barrier) and not callable(part.restitution):
                name, mass = f"{stop}_impulse", (1.0 + part.restitution) * at.reduced(at.elongations[stop])
                found[name] = Seen({"impact_speed": name}, None, stop=stop, place=part.position, impulse=mass)
        return found

    @property
    def seen_by_force(self) -> list[str]:
        """What may be asked for as a force: all that is not refused."""
        return [*(name for name, one in self.felt.items() if not one.reason), *self.of_impacts]

    def is_undefined(self, seen: Seen) -> bool:
        """Whether it is of the impulses of impacts that cannot be counted, which have no mean and no distribution."""
        return bool(seen.impulse and self.uncounted_because(f"{seen.stop}_impact_rate"))

    def number_felt(self, name: str) -> int:
        """Of a force or acceleration among all.

        Raises
        ------
        NotCoveredError
            With the reason, if it cannot be seen.
        """
        if reason := self.felt[name].reason:
            raise NotCoveredError(f"{name} cannot be seen: {reason}.")
        number = [*self.felt].index(name)
        if number >= MOST_FELT:
            raise NotCoveredError(f"{name} cannot be seen: only the first {MOST_FELT} forces and accelerations can.")
        return number

    def seen_by_name(self, name: Any, argument: str, *, forces_only: bool = False) -> Seen:
        """A displacement, a force or an absolute acceleration, as observers see it; ``argument`` asks for it.

        With ``forces_only`` no displacement, and those of impacts too, which have no value at every time.

        Raises
        ------
        ValueError, NotCoveredError
            If there is none of that name, or it cannot be seen.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Spring
        >>> motion_of(System(Spring(1.0), WhiteNoise(1.0))).seen_by_name("spring_force", "forces").names
        {'x': 'spring_force'}
        """
        moving = {} if forces_only else {own: seen for own, (kind, seen) in self.levels.items() if kind == "x"}
        touches = self.of_impacts if forces_only else {}
        if isinstance(name, str) and name in moving:
            return replace(moving[name], names={"x": name})
        if isinstance(name, str) and name in touches:
            return touches[name]
        if not isinstance(name, str) or name not in self.felt:
            wall = name.removesuffix("_force") if isinstance(name, str) else ""
            if isinstance(self.touched.get(wall), Barrier) and name != wall:
                raise NotCoveredError(f"{name} cannot be seen: a rigid wall gives impulses, which last no time; "
                                      f"{wall}_force_mean, their momentum per time, is in every run.")  # fmt: skip
            what = "force or acceleration" if forces_only else "displacement, force or acceleration"
            near = self.near(name, [*moving, *(self.seen_by_force if forces_only else self.felt)])
            raise ValueError(f"{argument} has {shown(name)}, which is no {what}{near}")
        number = self.number_felt(name)
        return Seen({"x": name}, self.displacements_shown + number, feels=(number,))

    def near(self, name: Any, known: Sequence[str]) -> str:
        """What an unknown name may have meant, or which there are; of two masses, that nothing acts between them."""
        if not isinstance(name, str):
            return f"; there are {few(known)}."
        for a, b in permutations(self.system.points, 2):
            pairs = (f"{one}_{end}" for one in (f"{a}_{b}", f"{b}_{a}") for end in ("elongation", "distance"))
            if name in (f"{a}_{b}_elongation", f"{a}_{b}_distance") and not {*pairs} & {*known}:
                return f": no part acts between {a} and {b}."
        return meant(name, known) or f"; there are {few(known)}."

    @property
    def displacements_shown(self) -> int:
        """How many displacements the kernel shows before what is felt: of coordinates, and of all rows."""
        at = self.system.coordinates
        return len(at.names) + len(at.numbers)

    @property
    def arguments(self) -> dict[str, tuple[str, int]]:
        """What the arguments of an observable may be called; empty if they are t, x and v in this order.

        Of each x or v, and the number of the displacement; and t.
        """
        return {}

    def start_of(self, seen: Seen, x: Any, v: Any) -> tuple[float, float]:
        """A displacement and its velocity from x(0) and x'(0) as settings have them; without x(0) that of rest."""
        return self.position_of_rest if x is None else x, v

    def modes_near(self, seen: Seen, *, of_speed: bool, by_energy: bool) -> tuple[Any, Any, Any] | None:
        """By which splitting tells how near several masses are to a large value; of one mass it is its energy."""
        return None

    def intensity_of(self, seen: Seen, time: Any = None) -> Any:
        """Of the white noise in the acceleration of a displacement, in m^2 s^-3; at times in s with its envelopes."""
        if time is None:
            return self.intensity
        return sum(noise.intensity * noise.square_at(time) for noise in self.unit.of(WhiteNoise))

    @property
    def is_modulated(self) -> bool:
        """Whether an excitation has an envelope."""
        return any(part.envelope is not None for part in self.system.of(Excitation))

    @property
    def settles_at_start(self) -> bool:
        """Whether a stationary start is another than one from rest, so that it is the default of a run."""
        return True

    @property
    def mean_names(self) -> tuple[str, ...]:
        """The results that are E[x], of all masses."""
        return ("x_mean",)

    @property
    def near_mean(self) -> Floats:
        """First guess of E[x], of each mass."""
        return np.array([self.scales.mean])

    def within_walls(self, places: Floats) -> Floats:
        """The nearest places of all masses that are not behind a wall."""
        return np.array([min(max(self.low, float(places[0])), self.high)])

    def as_given(self, places: Floats) -> Any:
        """Places of all masses in the form of ``initial_position``."""
        return float(places[0])

    def stationary_place(self, seen: Seen) -> float:
        """About where a displacement is in the stationary state: on which side a level lies."""
        mean, spread, _ = self.size_of(seen)
        return mean if abs(mean) > _EVEN * spread else 0.0

    @property
    def pilot_time(self) -> float:
        """The relaxation time of pilot runs, in s: creep is seen for twenty cycles at most."""
        cycle = 5.0 / self.scales.frequency
        return max(self.scales.energy_time, min(self.scales.creep_time, 20.0 * cycle), cycle)

    def left_of_start(self, off: float, time: float) -> float | None:
        """Bound on what an x(0) that is off changes of the mean from a time in s on; both over the root mean square.

        It is the force C t^-alpha / Gamma(1 - alpha) of each springpot over Omega^2.  None if it hardly fades, and is
        measured by pilots.
        """
        frequency, share = self.scales.frequency, 0.0
        for pot in self.springpots:
            fading = max(frequency * time, 1.0) ** -pot.order / math.gamma(1.0 - pot.order)
            share += off * (pot.coefficient * frequency ** (pot.order - 2.0)) * fading
        return share

    @property
    def kept_means(self) -> tuple[KeptMean, ...]:
        """What springpots remember of the start."""
        one = np.ones(1)
        return tuple(KeptMean("x", one, pot.order, pot.coefficient) for pot in self.springpots)

    def transient_left(self, start: str, time: float) -> float:
        """About the share of the transient that is left at a time in s.

        From E[x] the mean does not creep.  What is left then are the slow displacements of the noise before the start.
        """
        waiting = self.waiting_time(start)
        waited = math.exp(-time / waiting) if waiting > 0.0 else 0.0
        if not self._creeps_less(start):
            return max(math.exp(-time / self.scales.relaxation_time), waited)
        slow = max((creep.left(time) for creep in self.slow), default=0.0) if time > 0.0 else 1.0
        slow = min(slow, math.exp(-time / self.scales.relaxation_time))
        return max(math.exp(-time / self.scales.energy_time), slow, waited)

    def settled_after(self, start: str, times: float) -> float:
        """The time in s at which no more of the transient is left than after so many relaxation times."""
        latest = times * max(self.scales.relaxation_time, self.waiting_time(start))
        if not self._creeps_less(start):
            return latest
        time = times * max(self.scales.energy_time, self.waiting_time(start))
        while time < latest and self.transient_left(start, time) > math.exp(-times):
            time *= _LATER
        return min(time, latest)

    def _creeps_less(self, start: str) -> bool:
        return start == "stationary" and self.searched and self.scales.creep_time > self.scales.energy_time

    def drawn_about(self, places: Floats) -> Any:
        """The law from which a start about these places is drawn; None where it is not."""
        return self.law

    @property
    def loose_points(self) -> tuple[str, ...]:
        """The masses that only walls hold, and that may wait long for their impacts."""
        return ()

    def waiting_time(self, start: str) -> float:
        """In which what a start does to masses that only walls hold falls by a factor of e, in s; 0 without any."""
        return 0.0

    def scheme_for(self, word: Scheme) -> SchemeOfRun:
        """The name of the scheme that a run has, from the one chosen."""
        return word

    def placed(self, given: Any) -> Any:
        """x(0) from what was given: 0 without it, or the wall beyond which 0 lies."""
        if given is None:
            return self.position_of_rest
        position = finite_number(given, "initial_position", low=-LARGEST, high=LARGEST)
        if not self.low <= position <= self.high:
            raise ValueError(
                f"initial_position is {position:g}, behind a wall: it must lie between {self.low:g} and {self.high:g}."
            )
        return position

    def moving(self, given: Any) -> Any:
        """x'(0) from what was given: 0 without it."""
        return 0.0 if given is None else finite_number(given, "initial_velocity", low=-LARGEST, high=LARGEST)

    def usual_energy(self, values: Mapping[str, float]) -> float:
        """An energy of the motion per unit mass, from the results of a run."""
        if self.scales.guessed:
            return 0.5 * values["v_mean_square"]
        whole = 0.5 * (values.get("amplitude_mean_square", math.nan) * self.system.natural_frequency**2)
        moved = self.origin * (2.0 * values["x_mean"] - self.origin) if self.origin else 0.0
        return whole - 0.5 * self.system.natural_frequency**2 * moved

    @property
    def resolved_rate(self) -> float:
        """The rate that the default step follows."""
        return self.scales.fastest_rate

    @property
    def usual_quantities(self) -> tuple[str, ...]:
        """What ``rtol`` controls where nothing else is asked for."""
        return ("amplitude_mean_square",) if self.system.stiffness > 0.0 else ("v_mean_square",)

    @property
    def zeros(self) -> tuple[str, ...]:
        """The results that are 0 by symmetry."""
        return ("x_mean",) if self.is_symmetric and self.origin == 0.0 else ()

    def mean_square_of(self, name: str) -> str:
        """The mean square displacement with which a result changes."""
        return "x_mean_square"

    @property
    def unit(self) -> System:
        """The system per unit mass, as seen from the origin."""
        return self.centred.per_unit_mass

    @property
    def law(self) -> BoltzmannLaw:
        """The law of x - origin at the guessed temperature."""
        return self.guess or guessed_law(self.centred)

    def size_of(self, seen: Seen) -> tuple[float, float, float]:
        """Mean, deviation and deviation of the velocity of a displacement, about."""
        law = self.law
        return self.origin + law.mean, math.sqrt(law.variance), math.sqrt(law.temperature)

    @property
    def low(self) -> float:
        """The lower wall, or -inf."""
        return self.system.potential.low

    @property
    def high(self) -> float:
        """The upper wall, or inf."""
        return self.system.potential.high

    @property
    def position_of_rest(self) -> float:
        """0, or the wall beyond which it lies."""
        return min(max(0.0, self.low), self.high)

    @property
    def intensity(self) -> float:
        """Of the white noise per unit mass, in m^2 s^-3."""
        return sum((noise.intensity for noise in self.unit.of(WhiteNoise)), 0.0)

    @property
    def springpots(self) -> tuple[Springpot, ...]:
        """Those with memory, per unit mass."""
        return tuple(pot for pot in self.unit.of(Springpot) if pot.remembers)

    @property
    def remembers(self) -> bool:
        """Whether a part has memory."""
        return any(part.remembers for part in self.system.parts)

    @property
    def is_thermal(self) -> bool:
        """Whether x and v at time 0 are drawn from Boltzmann's law, so that a run is stationary at once."""
        return bool(self.system.of(ThermalNoise))

    @property
    def is_random(self) -> bool:
        """Whether its paths differ by chance; without noise, random phases and drawn records they do not."""
        drawn = any(record.is_drawn for record in self.system.of(RecordedExcitation))
        return self.is_noisy or drawn or bool(self.system.of(Harmonic))

    @property
    def different_paths(self) -> int:
        """How many paths differ where chance has no part in them: one for each record; 0 where it has."""
        return 0 if self.is_random else self.turns

    @property
    def turns(self) -> int:
        """Of how many paths the records that are taken in turn differ, before they come again; 1 without."""
        records = self.system.of(RecordedExcitation)
        return math.lcm(*(record.count for record in records if not record.is_drawn))

    @property
    def strata(self) -> int:
        """The same where noise makes paths with the same record differ: each record is a stratum; otherwise 1."""
        return self.turns if self.is_random else 1

    @property
    def is_noisy(self) -> bool:
        """Whether chance goes on after the start, so that a path may go on in many ways."""
        return bool(self.system.of(WhiteNoise, *_SMOOTH))

    @property
    def recorded(self) -> float:
        """The length of the longest recorded excitation or envelope, in s; 0 without one."""
        return max((part.duration for part in self.system.of(Excitation)), default=0.0)

    @property
    def ends(self) -> str:
        """Why the excitation does not last; empty if it does."""
        if not self.recorded:
            return ""
        return f"{'a record' if self.system.of(RecordedExcitation) else 'an envelope'} has a beginning and an end"

    @property
    def settles(self) -> bool:
        """Whether there is a stationary state, in which a rate of rare events is constant."""
        return not self.ends and self.scales.relaxation_time < math.inf

    @property
    def walls(self) -> tuple[Barrier, ...]:
        """The rigid walls."""
        return self.system.of(Barrier)

    @property
    def touched(self) -> dict[str, Stop]:
        """Walls and contacts by their names."""
        return self.system.stops

    @property
    def is_symmetric(self) -> bool:
        """Whether E[x] is the origin because both directions from there have the same law.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Spring
        >>> motion_of(System(Spring(1.0))).is_symmetric, motion_of(System(Spring(1.0), Barrier(-1.0))).is_symmetric
        (True, False)
        """
        potential = self.centred.potential
        odd = not any(potential.coefficients[::2]) and potential.low == -potential.high
        contacts = self.centred.of(SoftStop)
        mirrored = {contact.mirrored() for contact in contacts}
        return odd and len({wall.restitution for wall in self.walls}) <= 1 and mirrored == {*contacts}

    @cached_property
    def struck(self) -> StruckWalls:
        """The walls as slow impacts see them: near a wall only noise and what presses on it matter.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Dashpot, Spring
        >>> motion_of(System(Spring(4.0), Dashpot(0.1), Barrier(0.5, 0.8, "above"), WhiteNoise(2.0))).struck
        StruckWalls(restitution=0.8, intensity=2.0, press=2.0)
        """
        unit = self.unit
        walls = unit.of(Barrier)
        numbers = {wall.restitution for wall in walls}
        if len(numbers) != 1 or any(map(callable, numbers)) or unit.of(SoftStop) or not self.intensity > 0.0:
            return StruckWalls()
        return StruckWalls(restitution_at(walls[0], 0.0), self.intensity, max(self.press_on(wall) for wall in walls))

    def struck_in(self, step: float) -> dict[str, StruckWalls]:
        """The rigid walls whose impacts are in each distribution of an impact speed, by its name, as slow impacts see
        them: of unlike ones that behind which a step misses most of them; a law counts with its value at those.
        """
        if self.uncountable or not self.walls or not self.intensity > 0.0:
            return {}
        least = min(countable_restitution(wall, self.intensity, step) for wall in self.unit.of(Barrier))
        press = max(self.press_on(wall) for wall in self.unit.of(Barrier))
        return {"impact_speed": StruckWalls(least, self.intensity, press)}

    def velocity_biases(self, step: float) -> dict[str, float]:
        """Bounds on the relative step biases of mean square velocities that strong dampers leave: of one mass none."""
        return {}

    @property
    def completed(self) -> dict[str, StruckWalls]:
        """The walls to whose impacts slow ones can be added, by how the names of their results begin."""
        return {"": self.struck} if self.struck.crowded else {}

    @property
    def uncounted(self) -> dict[str, str]:
        """How the names of results begin that are of impacts which cannot be counted, and why: of all walls together,
        and of each lossy one.  Contacts have a rate: what rests on a wall behind touches them once.
        """
        if not self.uncountable:
            return {}
        lossy = (
            name for name, wall in self.touched.items() if isinstance(wall, Barrier) and slow_restitution(wall) != 1.0
        )
        return dict.fromkeys(("", *(f"{name}_" for name in lossy)), self.uncountable)

    def uncounted_because(self, name: str) -> str:
        """Why a result is of impacts that cannot be counted; empty of any other."""
        whose, of_impacts, _ = name.rpartition("impact_")
        return self.uncounted.get(whose, "") if of_impacts else ""

    @property
    def struck_alone(self) -> dict[str, StruckWalls]:
        """Each wall as slow impacts see it, by its name, where its results have biases of their own: none has."""
        return {}

    def slowest_restitutions(self, name: str, step: float) -> list[float]:
        """Of each lossy wall in a result: for the slowest impacts that a step resolves, or slower ones."""
        return [
            min(slow_restitution(wall), restitution_of_missed(wall, intensity, step))
            for wall, intensity in self._walls_in(name)
            if not wall.is_elastic
        ]

    def _walls_in(self, name: str) -> list[tuple[Barrier, float]]:
        """The walls whose impacts are in a result, and the intensity of the noise that drives the mass to each."""
        return [(wall, self.intensity) for wall in self.walls]

    def motions_before_walls(self, values: Mapping[str, float]) -> dict[str, Before]:
        """What moves before each wall and contact, from the results of a run."""
        return before_walls(self.system, *(values[name] for name in ("x_mean", "x_mean_square", "v_mean_square")))

    def press_on(self, wall: Barrier) -> float:
        """Acceleration with which the springs press the mass on a wall, in m/s^2; negative where they pull it away."""
        direction = {"above": 1.0, "below": -1.0}[wall.side]
        return direction * float(self.unit.potential.force(wall.position))

    @property
    def pressed(self) -> dict[str, Pressed]:
        """The lossy walls that springs and constant forces press the mass on under white noise, by name."""
        walls = ((name, wall) for name, wall in self.unit.named() if isinstance(wall, Barrier))
        return {
            name: Pressed(press, restitution_at(wall, math.sqrt(2.0 * self.law.temperature)))
            for name, wall in walls
            if (press := self.press_on(wall)) > 0.0 and self._is_rough_at(wall) and slow_restitution(wall) < 1.0
        }

    @property
    def rested_on(self) -> frozenset[str]:
        """The lossy walls on which a mass can come to rest, by name: only smooth forces act on it there."""
        if self.system.of(PoissonImpulses, ThermalNoise):
            return frozenset()
        walls = ((name, wall) for name, wall in self.unit.named() if isinstance(wall, Barrier))
        return frozenset(name for name, wall in walls if not (wall.is_elastic or self._is_rough_at(wall)))

    def _is_rough_at(self, wall: Barrier) -> bool:
        """Whether noise with independent increments acts on the mass where it is at a wall."""
        if self.intensity > 0.0 or (wall.position != 0.0 and self.system.of(ParametricNoise)):
            return True
        return self.is_thermal and self.system.dashpots > 0.0

    @cached_property
    def uncountable(self) -> str:
        """Why the impacts cannot be counted; empty if they can.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Spring
        >>> smooth = System(Spring(1.0), Springpot(0.5, 1.0), Barrier(0.0, 0.8), ColoredNoise(1.0, 0.5))
        >>> motion_of(smooth).uncountable[:42]
        'barrier is lossy, and no white noise acts '
        """
        system = self.system
        smooth = system.of(*_SMOOTH)
        for name, wall in system.named():
            if not isinstance(wall, Barrier) or slow_restitution(wall) == 1.0:
                continue
            rough = self._is_rough_at(wall)
            if smooth and not rough:
                return (
                    f"{name} is lossy, and no white noise acts on the mass: a smooth force lets the mass come to rest "
                    "on the wall after infinitely many impacts"
                )
            slow = slow_restitution(wall)
            if slow <= COLLAPSE_BELOW and rough:
                return (
                    f"restitution {slow:g} of {name} is not above {COLLAPSE_BELOW:.3f} (= exp(-pi/sqrt 3)): "
                    "white noise causes infinitely many impacts in a finite time"
                )
        return ""

    @property
    def held_by(self) -> tuple[Springpot, ...]:
        """The springpots that hold the mass without a spring."""
        return tuple(creep.springpot for creep in self.slow if isinstance(creep, CreepAlone))

    @property
    def not_stationary(self) -> str:
        """Why there is no stationary state; empty if there is one."""
        kinds = (WhiteNoise, *_FED, Harmonic, VanDerPol)
        sizes = [getattr(part, "intensity", getattr(part, "amplitude", 1.0)) for part in self.system.of(*kinds)]
        if self.ends:
            return self.ends
        if not any(sizes) and not self.system.of(Force):
            return "without excitation the motion dies out"
        if math.isinf(self.scales.energy_time):
            return "nothing dissipates energy, so it grows without limit"
        return ""
