"""What is known of a motion before it is simulated: its scales, walls and memory, and which results it can have.

One coordinate with all parts on its row has a potential, and its size is guessed from Boltzmann's law on a grid of
places; any other motion is guessed from its normal modes.  All else is the same for any number of coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, few, listed, meant, shown
from springpot.problem.catalogue import owner_of
from springpot.problem.coordinates import product_of
from springpot.problem.outputs import Output, outputs_of
from springpot.problem.parts import Barrier, Springpot
from springpot.problem.parts.walls import Stop, restitution_at, restitution_of_missed, slow_restitution
from springpot.problem.system import System, along
from springpot.simulation.kernel.outputs import MOST_OUTPUTS
from springpot.simulation.plan.boltzmann import BoltzmannOfModes, FromPotential, boltzmann_of_modes
from springpot.simulation.plan.creep import Creep
from springpot.simulation.plan.creep_of_paper import CreepOfPaper
from springpot.simulation.plan.guess import BoltzmannLaw, guessed_law
from springpot.simulation.plan.loose import Loose, holding_alone, loose_masses
from springpot.simulation.plan.modes import Modes, modes_of
from springpot.simulation.plan.options import Scheme, SchemeOfRun
from springpot.simulation.plan.rest import within_walls
from springpot.simulation.plan.scales import Scales
from springpot.simulation.plan.schemes import NumericalScheme, scheme_of
from springpot.simulation.plan.signals import Signal, levels_of, signals_of
from springpot.simulation.plan.struck import (
    Pressed,
    StruckWalls,
    countable_restitution,
    intensity_along,
    step_that_misses,
)
from springpot.simulation.plan.symmetry import Symmetry
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.walls import Before

_LATER = 1.2  # ratio of the times at which a transient is looked at
_EVEN = 1e-9  # standard deviations of a mean that counts as 0
_RIGID = 1e-9  # of the largest stiffness
_MISSED = 0.003  # share of the impacts that a default step misses
_FINEST = 0.1  # of the default step without walls, behind lossy ones
_BEHIND = 1e-12  # of the places: as far behind a wall rounding leaves a sum of displacements
_LEAST_BIAS = 1e-3  # which is worth saying


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
class Potential:
    """That of one coordinate: all parts lie on its row.

    Attributes
    ----------
    system : System
        As seen from the place from which it is measured.
    guess : BoltzmannLaw or None
        From which the scales are; None where they have closed forms.
    """

    system: System
    guess: BoltzmannLaw | None = None

    @cached_property
    def law(self) -> BoltzmannLaw:
        """Boltzmann's law at the guessed temperature."""
        return self.guess or guessed_law(self.system)


@dataclass(frozen=True, eq=False)
class ModesNear:
    """What normal modes can bring to a quantity.

    Attributes
    ----------
    placed, moved : ndarray, shape (modes, coordinates)
        What displacements from the place of rest, and velocities, bring of each mode, over the usual size of the
        quantity.  The root of the sum of both squares is what the mode can bring in a cycle.
    rest : ndarray, shape (coordinates,)
    usual : float
        The usual size, in the units of the quantity.
    """

    placed: Floats
    moved: Floats
    rest: Floats
    usual: float


@dataclass(frozen=True, eq=False)
class Motion:
    """A system and what follows from it alone.  Made by `springpot.simulation.plan.motions.motion_of`.

    Attributes
    ----------
    system : System
        The user's own.
    scales : Scales
    rest, near_mean : ndarray
        Where the coordinates are at rest, and the first guess of their means.
    origin : float
        The place in m from which x of a lone row is measured; see `springpot.simulation.plan.rest`.
    sign : float
        -1 where the wall of the paper's problem lies above the motion, else 1.
    slow : tuple of Creep or CreepOfPaper
        The slow displacements of springpots, without walls; none without springpots.
    searched : bool
        Whether E[x], the x(0) of a stationary start, must be found by pilot runs.
    keeps_the_law : bool
        Whether a long step leaves the stationary law as it is: a dashpot, white noise, and an elastic wall at most.
    beyond_paper : str
        Which part the paper's problem does not have, in one sentence; empty if it is that problem.
    potential : Potential or None
        Of a lone row; None of a motion that is guessed from its normal modes.
    """

    system: System
    scales: Scales
    rest: Floats
    near_mean: Floats
    origin: float = 0.0
    sign: float = 1.0
    slow: tuple[Creep | CreepOfPaper, ...] = ()
    searched: bool = False
    keeps_the_law: bool = False
    beyond_paper: str = ""
    potential: Potential | None = None

    @cached_property
    def centred(self) -> System:
        """The system as seen from there: scales, guesses and the kernel have its places."""
        return self.system if self.potential is None else self.potential.system

    @property
    def unit(self) -> System:
        """The system per unit mass, as seen from the origin."""
        return self.centred.per_unit_mass

    @property
    def law(self) -> BoltzmannLaw:
        """The law of x - origin at the guessed temperature, in the potential of a lone row."""
        assert self.potential is not None
        return self.potential.law

    @cached_property
    def modes(self) -> Modes:
        """At the guessed size of the motion."""
        return modes_of(self.system)

    def size_of(self, signal: Signal) -> tuple[float, float, float]:
        """Mean, deviation and deviation of the velocity of a displacement, about."""
        if self.potential is None:
            return float(signal.row @ self.rest), self.modes.spread(signal.row), self.modes.speed(signal.row)
        law = self.law
        return self.origin + law.mean, math.sqrt(law.variance), math.sqrt(law.temperature)

    def _spread(self, row: Floats) -> float:
        """Standard deviation of an elongation, about."""
        return self.size_of(Signal(row=row))[1]

    def square_about_origin(self, values: Mapping[str, float], mean: str = "x_mean") -> float:
        """E[(x - origin)^2] from the results of a run, of one of the means."""
        return max(values[f"{mean}_square"] - self.origin * (2.0 * values[mean] - self.origin), 0.0)

    @cached_property
    def displacements(self) -> dict[str, Floats]:
        """The rows of all displacements and elongations that are observed, by how the names of their results begin."""
        at = self.system.coordinates
        return {f"{own}x": row for own, row in at.beginnings.items()} | {
            f"{pair}_elongation": row for pair, row in at.pairs.items()
        }

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """The displacements whose distributions and spectra a run can have."""
        return signals_of(self.system)

    @cached_property
    def levels(self) -> dict[str, tuple[str, Signal]]:
        """What can pass a level, by name: the quantity, and the displacement that it is of."""
        return levels_of(self.system)

    @property
    def speeds(self) -> dict[str, Signal]:
        """Speeds of impacts by name, each with what it is of."""
        return {one.names["impact_speed"]: one for one in self.signals if "impact_speed" in one.names}

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """Forces of parts and accelerations, in the order in which the kernel shows them."""
        return outputs_of(self.system)

    @property
    def of_impacts(self) -> dict[str, Signal]:
        """The largest forces of the touches of soft contacts, and the impulses of impacts on rigid walls, by name."""
        found, at = dict[str, Signal](), self.system.coordinates
        for stop in self.touched:
            wall = self.system.walls.get(stop)
            if wall is None:
                name = f"{stop}_peak_force"
                found[name] = Signal({"impact_speed": name}, None, stop=stop, peaks=True)
            elif not wall.has_law:
                name, mass = f"{stop}_impulse", (1.0 + restitution_at(wall, 0.0)) * at.reduced(at.elongations[stop])
                found[name] = Signal({"impact_speed": name}, None, stop=stop, place=wall.position, impulse=mass)
        return found

    @property
    def signals_by_force(self) -> list[str]:
        """What may be asked for as a force: all that is not refused."""
        return [*(name for name, one in self.outputs.items() if not one.reason), *self.of_impacts]

    def is_undefined(self, signal: Signal) -> bool:
        """Whether it is of the impulses of impacts that cannot be counted, which have no mean and no distribution."""
        return bool(signal.impulse and self.uncounted_because(f"{signal.stop}_impact_rate"))

    def output_number(self, name: str) -> int:
        """Of a force or acceleration among all.

        Raises
        ------
        NotCoveredError
            With the reason, if it cannot be seen.
        """
        if reason := self.outputs[name].reason:
            raise NotCoveredError(f"{name} cannot be seen: {reason}.")
        number = [*self.outputs].index(name)
        if number >= MOST_OUTPUTS:
            raise NotCoveredError(f"{name} cannot be seen: only the first {MOST_OUTPUTS} forces and accelerations can.")
        return number

    def signal_by_name(self, name: Any, argument: str, *, forces_only: bool = False) -> Signal:
        """A displacement, a force or an absolute acceleration, as observers see it; ``argument`` asks for it.

        With ``forces_only`` no displacement, and those of impacts too, which have no value at every time.

        Raises
        ------
        ValueError, NotCoveredError
            If there is none of that name, or it cannot be seen.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Spring, WhiteNoise
        >>> motion_of(System(Spring(1.0), WhiteNoise(1.0))).signal_by_name("spring_force", "forces").names
        {'x': 'spring_force'}
        """
        moving = {} if forces_only else {own: signal for own, (kind, signal) in self.levels.items() if kind == "x"}
        touches = self.of_impacts if forces_only else {}
        if isinstance(name, str) and name in moving:
            return replace(moving[name], names={"x": name})
        if isinstance(name, str) and name in touches:
            return touches[name]
        if not isinstance(name, str) or name not in self.outputs:
            wall = name.removesuffix("_force") if isinstance(name, str) else ""
            if wall in self.system.walls and name != wall:
                raise NotCoveredError(f"{name} cannot be seen: a rigid wall gives impulses, which last no time; "
                                      f"{wall}_force_mean, their momentum per time, is in every run.")  # fmt: skip
            what = "force or acceleration" if forces_only else "displacement, force or acceleration"
            near = self.near(name, [*moving, *(self.signals_by_force if forces_only else self.outputs)])
            raise ValueError(f"{argument} has {shown(name)}, which is no {what}{near}")
        number = self.output_number(name)
        return Signal({"x": name}, self.displacements_shown + number, outputs=(number,))

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
        """How many displacements the kernel shows before the outputs: of coordinates, and of all rows."""
        at = self.system.coordinates
        return len(at.names) + len(at.numbers)

    @cached_property
    def arguments(self) -> dict[str, tuple[str, int]]:
        """What the arguments of an observable may be called; empty if they are t, x and v in this order.

        Of each x or v, and the number of the displacement; and t.
        """
        moving = {
            name: (kind, signal.number or 0) for name, (kind, signal) in self.levels.items() if kind in ("x", "v")
        }
        return {} if "x" in moving else {"t": ("t", 0)} | moving

    def start_of(self, signal: Signal, x: Any, v: Any) -> tuple[float, float]:
        """A displacement and its velocity from x(0) and x'(0) as settings have them; without x(0) that of rest."""
        places = self.rest if x is None else self.system.coordinates.places_of(x)
        return float(signal.row @ places), float(signal.row @ self.system.coordinates.places_of(v))

    def modes_near(self, signal: Signal, *, of_speed: bool, by_energy: bool) -> ModesNear | None:
        """By which splitting tells how near a motion is to a large value, where its potential does not.

        With ``by_energy`` a mode brings the root of its energy.
        """
        if self.potential is not None:
            return None
        at, modes, rows = self.system.coordinates, self.modes, self.system.coordinates.elongations
        lowest = min(modes.frequency[modes.stretching], default=1.0)
        w = np.maximum(modes.frequency, lowest)
        if by_energy:
            shares = w
        elif signal.outputs:
            output, parts = [*self.outputs.values()][signal.outputs[0]], self.system.elements
            of_parts = [share * (rows[n] @ modes.shapes) * [parts[n].modulus(1j * each) for each in w]
                        for n, share in output.shares.items()]  # fmt: skip
            shares = np.abs(sum(of_parts))
        else:
            shares = np.abs(signal.row @ modes.shapes) * (w if of_speed else 1.0)
        usual = math.sqrt(float((shares**2 * modes.temperature / w**2).sum())) or 1.0
        placed = (shares / usual)[:, None] * modes.shapes.T @ at.mass
        return ModesNear(placed, placed / w[:, None], self.rest, usual)

    def intensity_of(self, signal: Signal, time: Any = None) -> Any:
        """Of white noise in the acceleration of a displacement, in m^2 s^-3; at times in s with its envelopes."""
        return intensity_along(self.system, self._spread, signal.row, time=time)

    @property
    def is_modulated(self) -> bool:
        """Whether an excitation has an envelope."""
        return any(part.envelope is not None for part in self.system.excitations.values())

    @property
    def mean_names(self) -> tuple[str, ...]:
        """The results that are the means of the coordinates."""
        at = self.system.coordinates
        return tuple(f"{own}x_mean" for own in at.beginnings)[: len(at.names)]

    def within_walls(self, places: Floats) -> Floats:
        """The least change of the places that puts every elongation before its wall."""
        return within_walls(self.system, places)

    def placed(self, given: Any) -> Any:
        """x(0) from what was given: that of rest without it, and 0 of masses that are not named."""
        if given is None:
            return self.system.coordinates.as_given(self.rest)
        places = self.system.coordinates.checked(given, "initial_position")
        x = self.system.coordinates.places_of(places)
        for name, wall in self.system.walls.items():
            row = self.system.coordinates.elongations[name]
            distance, size = wall.inwards * (float(row @ x) - wall.position), abs(wall.position) + np.abs(x).max()
            if distance < -_BEHIND * size * (np.count_nonzero(row) > 1):
                raise ValueError(
                    f"initial_position lies behind {name}: its elongation must be {wall.free_side} "
                    f"{wall.position:g}, and is {float(row @ x):g}."
                )
        return places

    def moving(self, given: Any) -> Any:
        """x'(0) from what was given: 0 without it."""
        none = self.system.coordinates.as_given(np.zeros(len(self.rest)))
        return none if given is None else self.system.coordinates.checked(given, "initial_velocity")

    def stationary_place(self, signal: Signal) -> float:
        """About where a displacement is in the stationary state: on which side a level lies."""
        mean, spread, _ = self.size_of(signal)
        return mean if abs(mean) > _EVEN * spread else 0.0

    @property
    def pilot_time(self) -> float:
        """The relaxation time of pilot runs, in s.

        E[x] is a fixed point however long a pilot creeps; where the error of x(0) is said to fade, creep is seen for
        twenty cycles at most.
        """
        cycle = 5.0 / self.scales.frequency
        creep = 0.0 if self.left_of_start(1.0, 0.0) is None else min(self.scales.creep_time, 20.0 * cycle)
        return max(self.scales.energy_time, creep, cycle)

    def left_of_start(self, off: float, time: float) -> float | None:
        """Bound on what an x(0) that is off changes of the mean from a time in s on; both over the root mean square.

        It is the force C t^-alpha / Gamma(1 - alpha) of each springpot over Omega^2.  None of several coordinates,
        where it hardly fades, since some springpots are stronger than the springs beside them: pilots measure it.
        """
        if self.potential is None:
            return None
        frequency, share = self.scales.frequency, 0.0
        for springpot in self.kept_means:
            fading = max(frequency * time, 1.0) ** -springpot.order / math.gamma(1.0 - springpot.order)
            share += off * (springpot.coefficient * frequency ** (springpot.order - 2.0)) * fading
        return share

    @cached_property
    def kept_means(self) -> tuple[KeptMean, ...]:
        """What springpots remember of the start, each along its row."""
        at, found = self.system.coordinates, []
        for part, springpot in self.system.springpots.items():
            row = at.elongations[part]
            alike = (
                n for n, own in self.displacements.items() if np.array_equal(own, row) or np.array_equal(own, -row)
            )
            if springpot.remembers and (name := next(alike, "")):
                found.append(
                    KeptMean(name, self.displacements[name], springpot.order, springpot.coefficient / at.reduced(row))
                )
        return tuple(found)

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

    def drawn_about(self, places: Floats) -> FromPotential | BoltzmannOfModes | Loose | None:
        """The law from which a start about these places is drawn, Boltzmann's or that of loose masses; or None."""
        return replace(self._drawn, rest=places) if isinstance(self._drawn, Loose) else self._drawn

    @cached_property
    def _drawn(self) -> FromPotential | BoltzmannOfModes | Loose | None:
        if self.potential is not None:
            return FromPotential(self.law, self.origin) if self.system.thermal else None
        return boltzmann_of_modes(self.system) or self.loose

    @property
    def is_thermal(self) -> bool:
        """Whether x and v at time 0 are drawn from Boltzmann's law, so that a run is stationary at once."""
        return self._drawn is not None and not isinstance(self._drawn, Loose)

    @cached_property
    def loose(self) -> Loose | None:
        """The masses that only walls hold; None without any."""
        if self.not_stationary:
            return None
        return loose_masses(self.system, lambda: self.modes.held, self.scales.frequency, self.rest)

    @property
    def loose_points(self) -> tuple[str, ...]:
        """The masses that only walls hold, and that may wait long for their impacts."""
        return () if self.loose is None else self.loose.points

    def waiting_time(self, start: str) -> float:
        """In which what a start does to masses that only walls hold falls by a factor of e, in s; 0 without any."""
        return 0.0 if self.loose is None else self.loose.waiting_time(start)

    def scheme_for(self, word: Scheme) -> SchemeOfRun:
        """The name of the scheme that a run has, from the one chosen; only in a potential there is a choice."""
        return "straight" if self.potential is None else word

    def usual_energy(self, values: Mapping[str, float]) -> float:
        """The kinetic energy, in J, from the results of a run; without what inertial parts share between masses."""
        at = self.system.coordinates
        masses = zip(at.beginnings, np.diag(at.mass), strict=False)  # those of coordinates come first
        return 0.5 * sum(float(mass) * values[f"{own}v_mean_square"] for own, mass in masses)

    @property
    def resolved_rate(self) -> float:
        """The rate that the default step follows."""
        return max(self.scales.fastest_rate, self.scales.resolved_rate)

    def default_step(self, scheme: NumericalScheme) -> float:
        """That of a run of a scheme, in s: the longest whose bias in mean squares, impact rates and speeds is below
        0.3 %, about.

        Behind lossy walls under white noise slow impacts decide; it is not shorter than a tenth of that without walls.
        So short it is under records alone, of which one looks at each path.
        """
        longest = scheme.default_step / self.resolved_rate
        if scheme.only_paper:
            return longest
        finest = min(longest, _FINEST * scheme.default_step / self.scales.fastest_rate)
        if self.recorded:
            return finest
        rows = self.system.coordinates.elongations
        speeds = {name: self.size_of(Signal(row=rows[name]))[2] for name in self.crowded}
        steps = [
            step_that_misses(self.struck_in_steps(name, longest), _MISSED, 2.0 * speed**2)
            for name, speed in speeds.items()
            if speed > 0.0
        ]
        return max(min([longest, *steps]), finest)

    @property
    def usual_quantities(self) -> tuple[str, ...]:
        """What ``rtol`` controls where nothing else is asked for: the mean square amplitude, or all mean squares."""
        if self.potential is not None:
            return ("amplitude_mean_square",) if self.system.stiffness > 0.0 else ("v_mean_square",)
        own = self.system.coordinates.beginnings
        return tuple(name for of in "xv" for each in own if (name := f"{each}{of}_mean_square") not in self.zeros)

    @cached_property
    def zeros(self) -> tuple[str, ...]:
        """The means of displacements that no force with a mean can move, and all of those that no force can move."""
        symmetry = Symmetry(self.system)
        means = symmetry.zero_means(self.displacements)
        if self.system.thermal:
            return means
        still = symmetry.still(self.displacements)
        squares = [f"{begin}_mean_square" for begin in still]
        speeds = [f"{begin[:-1]}v_mean_square" for begin in still if begin in self._points]
        return (*means, *squares, *speeds)

    @property
    def _points(self) -> tuple[str, ...]:
        return tuple(f"{own}x" for own in self.system.coordinates.beginnings)

    def mean_square_of(self, name: str) -> str:
        """The mean square displacement with which a result changes: its own, or that of the nearest row."""
        if own := owner_of(name, self.displacements):
            return f"{own}_mean_square"
        rows = self.system.coordinates.elongations
        if not (stop := owner_of(name, self.touched)):
            return next(f"{begin}_mean_square" for begin in self.displacements)
        row = rows[stop]
        alike = {begin: abs(float(own @ row)) / float(np.linalg.norm(own)) for begin, own in self.displacements.items()}
        return f"{max(alike, key=alike.__getitem__)}_mean_square"

    @property
    def low(self) -> float:
        """The lower wall of a lone row, or -inf."""
        return self.system.potential.low

    @property
    def high(self) -> float:
        """The upper wall of a lone row, or inf."""
        return self.system.potential.high

    @property
    def springpots(self) -> tuple[Springpot, ...]:
        """Those with memory."""
        return tuple(springpot for springpot in self.system.springpots.values() if springpot.remembers)

    @property
    def remembers(self) -> bool:
        """Whether a part has memory."""
        return any(part.remembers for part in self.system.parts)

    @property
    def is_random(self) -> bool:
        """Whether its paths differ by chance; without noise, random phases and drawn records they do not."""
        return any(part.is_random for part in self.system.excitations.values())

    @property
    def different_paths(self) -> int:
        """How many paths differ where chance has no part in them: one for each record; 0 where it has."""
        return 0 if self.is_random else self.turns

    @property
    def turns(self) -> int:
        """Of how many paths the records that are taken in turn differ, before they come again; 1 without."""
        return math.lcm(*(record.count for record in self.system.records.values() if not record.is_drawn))

    @property
    def strata(self) -> int:
        """The same where noise makes paths with the same record differ: each record is a stratum; otherwise 1."""
        return self.turns if self.is_random else 1

    @property
    def is_noisy(self) -> bool:
        """Whether chance goes on after the start, so that a path may go on in many ways."""
        return any(part.noise for part in self.system.excitations.values())

    @property
    def recorded(self) -> float:
        """The length of the longest recorded excitation or envelope, in s; 0 without one."""
        return max((part.duration for part in self.system.excitations.values()), default=0.0)

    @property
    def ends(self) -> str:
        """Why the excitation does not last; empty if it does."""
        if not self.recorded:
            return ""
        return f"{'a record' if self.system.records else 'an envelope'} has a beginning and an end"

    @property
    def settles(self) -> bool:
        """Whether there is a stationary state, in which a rate of rare events is constant."""
        return not self.ends and self.scales.relaxation_time < math.inf

    @property
    def walls(self) -> tuple[Barrier, ...]:
        """The rigid walls."""
        return tuple(self.system.walls.values())

    @property
    def touched(self) -> dict[str, Stop]:
        """Walls and contacts by their names."""
        return self.system.stops

    @cached_property
    def whose_impacts(self) -> dict[str, tuple[str, ...]]:
        """The walls and contacts whose impacts are in results, by how the names of these begin."""
        speeds = {each.stop: each.names["impact_speed"] for each in self.signals if "impact_speed" in each.names}
        found = dict[str, tuple[str, ...]]()
        for name in self.touched:
            begin = speeds.get(name, "").removesuffix("impact_speed")  # with none of its own it is among all
            found[begin] = (*found.get(begin, ()), name)
        return found

    @cached_property
    def struck_alone(self) -> dict[str, StruckWalls]:
        """Each rigid wall as slow impacts see it: the noise along its row, and how the springs press on it at most.

        Examples
        --------
        >>> from springpot.problem.parts import Barrier, Dashpot, Spring, WhiteNoise
        >>> from springpot.simulation.plan.motions import motion_of
        >>> motion_of(System(Spring(4.0), Dashpot(0.1), Barrier(0.5, 0.8, "above"), WhiteNoise(2.0))).struck_alone
        {'barrier': StruckWalls(restitution=0.8, intensity=2.0, press=2.0)}
        """
        rows = self.system.coordinates.elongations
        return {
            name: StruckWalls(
                slow_restitution(wall), intensity_along(self.system, self._spread, rows[name], wall.position),
                self._press_on(name),
            )
            for name, wall in self.system.walls.items()
        }  # fmt: skip

    def _press_on(self, name: str) -> float:
        """Acceleration in m/s^2 with which springs and constant forces press on a wall or contact where the masses are
        moved to it as an impulse there moves them; negative where they pull away.
        """
        at, stop = self.system.coordinates, self.touched[name]
        row, reduced = at.elongations[name], at.reduced(at.elongations[name])
        way = reduced * at.accelerations(row)
        rising = float(along(self.system, way).force(stop.position)) - float(self.system.constant_force @ way)
        return stop.inwards * rising / reduced  # of the potential energy there

    def _struck(self, names: Collection[str]) -> StruckWalls | None:
        """Some walls as one, if all are rigid, of one number of restitution, and noise drives masses to each."""
        walls = [self.struck_alone[name] for name in names if name in self.struck_alone]
        numbers = {getattr(self.touched[name], "restitution", None) for name in names}
        if len(numbers) != 1 or any(map(callable, numbers)) or not all(wall.intensity > 0.0 for wall in walls):
            return None
        return max(walls, key=lambda wall: wall.press, default=None)

    @cached_property
    def struck(self) -> StruckWalls:
        """The walls of which all impacts are counted together."""
        return self._struck(self.whose_impacts.get("", ())) or StruckWalls()

    @property
    def crowded(self) -> list[str]:
        """The lossy walls under white noise, behind which slow impacts are frequent."""
        parts = dict(self.system.named())
        return [n for n, wall in self.struck_alone.items() if wall.intensity > 0.0 and not parts[n].is_elastic]

    @property
    def completed(self) -> dict[str, StruckWalls]:
        """The walls to whose impacts slow ones can be added, by how the names of their results begin."""
        each = ((begin, self._struck(names)) for begin, names in self.whose_impacts.items())
        return {begin: walls for begin, walls in each if walls and walls.crowded}

    def struck_in(self, step: float) -> dict[str, StruckWalls]:
        """The rigid walls whose impacts are in each distribution of an impact speed, by its name, as slow impacts see
        them: of unlike ones that behind which a step misses most of them; a law counts with its value at those.
        """
        found = {}
        for begin, names in self.whose_impacts.items():
            walls = [self.struck_in_steps(name, step) for name in names if name in self.struck_alone]
            if walls and all(wall.intensity > 0.0 for wall in walls) and begin not in self.uncounted:
                least, press = min(wall.restitution for wall in walls), max(wall.press for wall in walls)
                found[f"{begin}impact_speed"] = replace(walls[0], restitution=least, press=press)
        return found

    def struck_in_steps(self, name: str, step: float) -> StruckWalls:
        """A rigid wall as the impacts see it that a step misses."""
        alone, wall = self.struck_alone[name], self.system.walls[name]
        return replace(alone, restitution=countable_restitution(wall, alone.intensity, step))

    def velocity_biases(self, step: float) -> dict[str, float]:
        """Bounds on the relative step biases of mean square velocities, where noise is not matched to the dampers,
        which take a share of each kick within its step.
        """
        taken, rows = scheme_of(self.scheme_for("default")).taken, self.system.coordinates.elongations
        springpots = ((name, *part.fast_springpot) for name, part in (self.system.elements.items() if taken else ()))
        shares = [
            coefficient * step ** (2.0 - order) / self.system.coordinates.reduced(rows[name])
            for name, order, coefficient in springpots
            if order > 0.0
        ]
        bias = taken * max(shares, default=0.0)
        if self.system.thermal or bias < _LEAST_BIAS:
            return {}
        return {f"{own}v_mean_square": bias for own in self.system.coordinates.beginnings}

    @cached_property
    def uncounted(self) -> dict[str, str]:
        """How the names of results begin that are of impacts which cannot be counted, and why: of walls whose impacts
        are counted together, and of each lossy one.  Contacts have a rate: what rests on a wall behind touches once.
        """
        found = dict[str, str]()
        for begin, names in self.whose_impacts.items():
            walls = {name: self.struck_alone[name] for name in names if name in self.struck_alone}
            if reason := next(filter(None, (self._uncounted(name, wall) for name, wall in walls.items())), ""):
                lossy = [f"{name}_" for name, wall in walls.items() if wall.restitution != 1.0]
                found |= dict.fromkeys((begin, *lossy), reason)
        return found

    def _uncounted(self, name: str, wall: StruckWalls) -> str:
        if wall.intensity > 0.0 and wall.restitution <= COLLAPSE_BELOW:
            return (
                f"restitution {wall.restitution:g} of {name} is not above {COLLAPSE_BELOW:.3f} (= exp(-pi/sqrt 3)): "
                "white noise causes infinitely many impacts in a finite time"
            )
        excitations = self.system.excitations.values()
        noisy = any(part.noise and part.feeds for part in excitations)
        if wall.intensity > 0.0 or wall.restitution == 1.0 or not noisy:
            return ""
        two = "ground" not in self.system.coordinates.ends.get(name, ("ground",))
        alike = any(part.noise == "white" and part.of_ground for part in excitations)
        return (
            f"{name} is lossy, and no white noise drives its two ends apart"
            f"{' (that of the ground moves both masses alike)' if two and alike else ''}: a smooth force lets "
            "them come to rest on each other after infinitely many impacts"
        )

    @property
    def uncountable(self) -> str:
        """Why the impacts on some walls cannot be counted; empty if they can.

        Examples
        --------
        >>> from springpot.simulation.plan.motions import motion_of
        >>> from springpot.problem.parts import Barrier, ColoredNoise, Spring, Springpot
        >>> smooth = System(Spring(1.0), Springpot(0.5, 1.0), Barrier(0.0, 0.8), ColoredNoise(1.0, 0.5))
        >>> motion_of(smooth).uncountable[:41]
        'barrier is lossy, and no white noise driv'
        """
        return next(iter(self.uncounted.values()), "")

    def uncounted_because(self, name: str) -> str:
        """Why a result is of impacts that cannot be counted; empty of any other."""
        whose, of_impacts, _ = name.rpartition("impact_")
        return self.uncounted.get(whose, "") if of_impacts else ""

    def slowest_restitutions(self, name: str, step: float) -> list[float]:
        """Of each lossy wall in a result: for the slowest impacts that a step resolves, or slower ones."""
        own = owner_of(name, self.touched)  # empty where the impacts on all walls are in it
        return [
            min(slow_restitution(part), restitution_of_missed(part, self.struck_alone[wall].intensity, step))
            for wall, part in self.system.walls.items()
            if own in (wall, "") and not part.is_elastic
        ]

    @property
    def pressed(self) -> dict[str, Pressed]:
        """The lossy walls that springs and constant forces press the mass on under white noise, by name; none where
        flights are straight, so that they press nowhere, and `resolved_rate` has the rates of hops.
        """
        if self.scheme_for("default") == "straight":
            return {}
        speed, walls = math.sqrt(2.0 * self.law.temperature), self.system.walls
        return {
            name: Pressed(alone.press, restitution_at(walls[name], speed))
            for name, alone in self.struck_alone.items()
            if alone.press > 0.0 and alone.intensity > 0.0 and alone.restitution < 1.0
        }

    @property
    def rested_on(self) -> frozenset[str]:
        """The lossy walls on which masses can come to rest, by name: only smooth forces act along their rows."""
        at, parts = self.system.coordinates, dict(self.system.named())
        if self.system.thermal:
            return frozenset()
        impulses = [force for name, force in at.forces.items() if parts[name].noise == "impulses"]
        return frozenset(
            name
            for name, alone in self.struck_alone.items()
            if not (parts[name].is_elastic or alone.intensity > 0.0)
            and not any(product_of(at.accelerations(at.elongations[name]), force) for force in impulses)
        )

    def motions_before_walls(self, values: Mapping[str, float]) -> dict[str, Before]:
        """What moves before each wall and contact, from the results of a run.

        Where a displacement along the row of a wall is observed; it gives as the springs let it where all else is free.
        """
        at = self.system.coordinates
        stiffness, shapes = np.linalg.eigh(at.sum_of(self.modes.stiffness))
        held, found = stiffness > _RIGID * stiffness[-1], {}
        for wall in self.touched:
            row = at.elongations[wall]
            along = ((name, float(row @ own) / float(own @ own)) for name, own in self.displacements.items()
                    if np.array_equal(row, own) or np.array_equal(row, -own))  # fmt: skip
            name, sign = next(along, ("", 0.0))
            if f"{name}_mean_square" not in values:
                continue
            mean, square = sign * values.get(f"{name}_mean", 0.0), values[f"{name}_mean_square"]  # or 0 by symmetry
            moved = row @ shapes
            is_held = held.any() and np.abs(moved[~held]).max(initial=0.0) <= _RIGID * np.abs(moved).max()
            give = float((moved[held] ** 2 / stiffness[held]).sum()) if is_held else math.inf
            frequency = 1.0 / math.sqrt(give * at.reduced(row))
            spread = math.sqrt(max(square - mean**2, 0.0))
            if name in self._points:
                speed = _root_of(values, f"{name[:-1]}v_mean_square")
            else:  # the speed of an elongation is no result: as if its ends moved independently
                ends = zip(at.names, row, strict=True)
                speed = math.hypot(*(share * _root_of(values, f"{end}_v_mean_square") for end, share in ends))
            found[wall] = Before(name, mean, spread, speed, frequency, self._press_on(wall))
        return found

    @cached_property
    def not_stationary(self) -> str:
        """Why there is no stationary state; empty if there is one."""
        if self.ends:
            return self.ends
        if not any(part.sustains for part in self.system.parts):
            return "without excitation the motion dies out"
        if (free := self._unheld()) and self._unheld(holding_alone(self.system)):
            return f"no spring or wall keeps {listed(free)} near the ground"
        elements, rows = self.system.elements, self.system.coordinates.elongations
        losing = {name: part for name, part in elements.items() if part.dissipates}
        if not losing:
            return "nothing dissipates energy, so it grows without limit"
        lossy = any(name in self.touched or part.is_rough for name, part in losing.items())
        if lossy or np.linalg.matrix_rank([rows[name] for name in losing]) == len(self.rest):
            return ""
        damped = self.modes.damped
        if not (damped.any() if self.touched else damped.all()):
            return "nothing dissipates the energy of some motion, so it grows without limit"
        return ""

    @property
    def held_by(self) -> tuple[Springpot, ...]:
        """The springpots that hold some motion without a spring."""
        alone = holding_alone(self.system)
        return tuple(alone.values()) if alone and self._unheld() else ()

    def _unheld(self, also: Collection[str] = ()) -> list[str]:
        """The points of a motion that stretches no spring, and none of some other parts, and that no wall ends."""
        at = self.system.coordinates
        rows = at.elongations
        held = [any(part.force_coefficients()) or part.modulus(0.0) != 0.0 for part in self.system.elements.values()]
        springs = [rows[name] for name, holds in zip(self.system.elements, held, strict=True) if holds or name in also]
        _, sizes, rows_of_all = np.linalg.svd(np.array(springs).reshape(-1, len(at.names)))
        kept = sizes > max(len(springs), len(at.names)) * np.finfo(float).eps * sizes.max(initial=0.0)
        free = rows_of_all[int(kept.sum()) :].T
        if not free.shape[1]:
            return []
        walls = [-stop.inwards * rows[name] @ free for name, stop in self.touched.items()]
        # a constant force holds, as weight does
        closing = np.array([*walls, -self.system.constant_force @ free]).reshape(-1, free.shape[1])
        for direction in (*free, *-free):
            room = _farthest(direction, closing)
            if float(direction @ room) > 1e-9:
                away = np.abs(at.rows @ free @ room)
                return [point for point, far in zip(at.points, away, strict=True) if far > 1e-6 * away.max()]
        return []


def _farthest(direction: Floats, closing: Floats) -> Floats:
    """The point of the unit cube that is farthest in a direction, of those that go no way which is closed."""
    if direction.size == 1:
        return np.sign(direction) * float((closing @ np.sign(direction) <= 0.0).all())
    from scipy import optimize  # slow to import

    found = optimize.linprog(-direction, closing, np.zeros(len(closing)), bounds=(-1.0, 1.0)).x
    return np.zeros(direction.size) if found is None else np.asarray(found)


def _root_of(values: Mapping[str, float], name: str) -> float:
    """Of a mean square; of one near 0 the estimate of paired runs can be below it."""
    return math.sqrt(max(values.get(name, 0.0), 0.0))
