"""Mean-field envelope: energy diffusion with any wall, any restitution, or no wall.

Physics
-------
Between impacts the motion is an arc x = x_e + A cos(w t), cut by the wall at phase p.  Its action J (the area of the
cycle over 2 pi) diffuses.  The springpot, dimensionless (Omega = q = 1, a = alpha):

1. In phase it acts as a spring about the cycle's mean X0, k1 = c [cos(a pi/2) - (1-a) (beta/w) sin(a pi/2)]
   sum (n w1)^a X_n^2 / sum X_n^2, and w^2 = 1 + k1.  The second term is due to the width beta of the lines.
2. Against slow changes of X0 it acts as a spring k0 about m = E[x].  X0 is a function of the diffusing action, so its
   correlation follows from the spectrum of the diffusion operator, with rates lambda and shares s of the variance:
   k0 = c sum s lambda^a (1 - y) / (1 - y^(1/(1-a))), y = sin(a pi/2) (lambda/w1)^(1-a).  The first factor is that of
   an exponential correlation; the second makes the correlation smooth at lag 0, and k0 = 0 at a = 1.
3. Its stored energy, (1 - a)/4 sum k_n X_n^2, is a part of that of a cycle.  The action is then that of a wave with
   dispersion, J = <v^2>/w1 - (a/4) sum k_n X_n^2 / w1, for which the change of the energy is w1 dJ.
4. It dissipates the power (c/2) sin(a pi/2) sum (n w1)^(1+a) X_n^2 plus, because harmonics are lines of width
   beta (1 + n^2)/2, (c/4) cos(a pi/2) (1-a) beta sum w_n^a (w_n^2/w^2 - 1) X_n^2, less a share lambda^a / w^a of that
   due to the slow line.
5. An impact takes (1-r^2)/2 of the square of the speed before it.  Between impacts the energy grows towards equilibrium
   with the noise: the renewal formula in every cycle, 2/(1+r^2) of the cycle's mean square if undamped.  The flux of
   impacts is corrected for short returns (`impacts`), and for sudden losses as at order 1 (`losses`).

6. Means of positions, and of the momentum and the energy that a wall takes, are per action.  Those of <v^2> and of the
   number of impacts are per area <v^2>/w1 of the plane of x and v, where a memory is part of J.

The stationary density per action is exp(-(2/q) int (loss / <v^2>) w1 dJ): exact for a dashpot with an elastic wall
anywhere.  k0, m, beta and the share in 4 are determined self-consistently.  With an elastic wall no number is
fitted; with a lossy one three are (see the modules in 5).  The derivation, and the alternatives that were tried, are in
the documentation, pages "The energy envelope" and "What was tried".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike
from scipy import optimize

from springpot.machine.arguments import LARGEST, finite_number
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts import (
    ColoredNoise,
    Constant,
    KanaiTajimiNoise,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.potential import Potential
from springpot.problem.system import System, checked_system
from springpot.theory.coverage import ARMS, DAMPERS, INERTIA, SPRINGS, STOPS, Coverage, form_of, unheld
from springpot.theory.densities import DensitiesOfAmplitude
from springpot.theory.distributions import times
from springpot.theory.mckean import COLLAPSE_BELOW
from springpot.theory.methods.envelope.balance import Balance, Cells, balance
from springpot.theory.methods.envelope.cycles import REACH, CyclesInWell, Problem
from springpot.theory.methods.envelope.density import Densities, DensityInWell, Portrait, portrait
from springpot.theory.methods.envelope.impacts import Impacts, impacts
from springpot.theory.methods.envelope.losses import DAMPINGS, changed
from springpot.theory.methods.envelope.walls import endless_walls, is_endless, is_smooth
from springpot.theory.numerics.energy_diffusion import FirstPassage
from springpot.theory.numerics.equations import roots_of
from springpot.theory.numerics.tabulated import Tabulated
from springpot.theory.problem import Problem as PaperProblem
from springpot.theory.problem import Units, at_rest, endless, paper_covered, problem_and_units
from springpot.theory.result import NEVER_STRUCK, ROUNDED, Moments, moments_of

_DEEPEST_PRELOAD = 100.0  # in units of sqrt(q / Omega^3); the cycles are much smaller than a deeper one
_STRONGEST = 3.0  # the largest c between orders 0 and 1, where errors are already large
_NOT_SETTLED = 1e-5  # change per step that gives a warning: a hundredth of the map's resolution of 0.1 %
_LIGHTEST = 0.3  # the largest c at which the first passage of x was right within 10 %
_PLACES = 201  # points of a cycle among which the largest amplitude is sought
_SMALLEST_LOSS = 1e-7  # of c sin(alpha pi/2) plus 1 - r, for double precision
_STRONG = 1.0  # loss in a cycle over the energy, above which it is said
# no ResonantCircuit: two motions that take turns are no slow change of one cycle
_ELEMENTS = SPRINGS | DAMPERS | VanDerPol | Springpot | ARMS | PiezoelectricCircuit
_NOISES = WhiteNoise | ColoredNoise | KanaiTajimiNoise | PoissonImpulses | ParametricNoise | ThermalNoise
_COVERED = Coverage(REACH, INERTIA | _ELEMENTS | STOPS | Constant | _NOISES)


@dataclass(frozen=True)
class Envelope(DensitiesOfAmplitude["_Law"]):
    """Result of the envelope: moments, densities, and transients of the energy.

    Parameters
    ----------
    balance : Balance or None
        The converged balance, of the paper's problem dimensionless; None without a stationary state or without noise.

    Notes
    -----
    The other parameters are those of `springpot.theory.result.Result`.

    The mean of the density of impact speeds is the moment ``impact_speed_mean`` to 0.1 % for c up to 1, b from -1 to 1
    and r from 0.5.  Where cycles of different size cross, those that cross are left out of it, and its mean was up to
    18 % off (c = 3, b = -1, r = 0.5): there the moments are more accurate.

    Of other systems than the paper's problem the densities of x and v, and the transients, are those of the cycles,
    without the correction for sudden losses: behind one lossy wall mean squares by the densities differ from the
    moments, by 1 % at r = 0.7 and up to 4 % at r = 0.5, and the density of v is symmetric.  The densities of amplitude
    and energy, and the first passage of x, are of that problem alone.  Impact speeds have a density on rigid walls
    under white noise.
    """

    balance: Balance | None = field(repr=False, compare=False)

    @property
    def frequency(self) -> float:
        """Mean angular frequency of the arcs, in rad/s: that of the spring and of the springpot in phase with it."""
        law = self._stationary_law()
        return float(law.balance.plane @ np.sqrt(np.maximum(law.balance.cycles.arc, 0.0))) / law.units.time

    @property
    def relaxation_rates(self) -> Floats:
        """Rates at which the density of the energy relaxes, in 1/s, the slowest first."""
        law = self._stationary_law()
        return np.asarray(law.cells.diffusion.modes[0][1:] / law.units.time)

    def amplitude_mean_square_at(self, time: ArrayLike) -> Floats:
        """<A^2> at a time from rest, in m^2.

        Parameters
        ----------
        time : array_like
            t >= 0 in s; infinity is the stationary state.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        TypeError, ValueError
            If a time is negative, NaN or not a number.

        Notes
        -----
        The energy has to change little in one cycle, and the springpot's slow force is that of the stationary state.
        Compared with Monte Carlo from rest it is within 4 % at c <= 0.1 from a third of the relaxation time on.  At
        c = 1, alpha = 0.5 it is 37 % too high in the first cycle and 3 % after some twenty of them; at alpha = 0.1,
        c = 0.3 it is 16 % too high for long, because the influence of the start decays like t^-alpha.

        Examples
        --------
        >>> import springpot as sp
        >>> light = sp.theory.envelope(sp.Oscillator(springpot=sp.Springpot(1.0, 0.1)))
        >>> light.amplitude_mean_square_at([5.0, math.inf]).round(2)  # 10 (1 - e^(-t/10))
        array([ 3.93, 10.  ])
        """
        t = times(time, "time")
        if self._law is None and not isinstance(self.stationary, str):
            return np.full(t.shape, self.amplitude_mean_square)
        law = self._stationary_law()
        if math.isnan(law.kappa):
            raise NotCoveredError("The amplitude is that of a linear spring, and here there is none.")
        cycles, origin = law.cells.cycles, law.balance.problem.origin
        square = cycles.x_square + origin * (2.0 * cycles.mean + origin) + law.kappa * cycles.v_square
        probability = law.cells.diffusion.from_rest(t.ravel() / law.units.time)
        if law.balance.problem.closed:  # the moments of other cycles are means per action
            probability = probability * law.cells.area
        mean = np.asarray(probability @ square / probability.sum(axis=1))
        return mean.reshape(t.shape) * law.units.length**2

    def first_passage(
        self,
        *,
        amplitude: float | None = None,
        energy: float | None = None,
        x: float | None = None,
        distance: float | None = None,
    ) -> FirstPassage:
        """When the amplitude, the energy or the displacement first reaches a level from rest.

        A cycle reaches the level of the amplitude when its largest A = sqrt(x^2 + v^2 / w^2) does; w is the resonance.
        The displacement passes the same level later, often by a factor of 2 or 3: only once in a cycle is x that large.

        Parameters
        ----------
        amplitude : float, optional
            Level of A in m.
        energy : float, optional
            Level of H = v^2 / 2 + Omega^2 x^2 / 2 in m^2/s^2.
        x : float, optional
            Level of x in m, on the side away from the wall: on this side only.
        distance : float, optional
            Level of the size of x in m, on both sides.  Exactly one of the four levels is given.

        Returns
        -------
        FirstPassage
            With ``mean_time`` in s and ``survival(time)``.

        Raises
        ------
        NoStationaryStateError
            If there is no stationary state.
        NotCoveredError
            If the level is one of x or distance, and the wall takes energy or c is above 0.3.
        TypeError, ValueError
            If not exactly one level is given, it is not a positive number, it is below that of rest, or it is so high
            that it is never reached.

        Notes
        -----
        At order 1, c = 0.1 and levels of 1.5 to 2.5 root mean squares the mean time was shorter than simulated: by 4 to
        9 % with an elastic wall, 6 % at r = 0.8, and 20 to 35 % at r = 0.5.  There the amplitude before an impact is
        larger than the mean over the cycle.  Behind an elastic wall with a springpot it was 10 to 25 % short at c = 0.1
        and 0.3 and half at c = 1: w is the resonance without the wall, and behind it A swings within a cycle.

        x is looked at where it is largest: once in a cycle, or twice for ``distance``.  Between two looks the amplitude
        diffuses.  For rare passages this tends to Rice's rate of crossings.  Mean times were compared with simulated
        ones (errors of 1 to 2 %) at two and three root mean squares of x.  Without a wall they were within 2.5 % for c
        up to 0.3 at orders 0.2, 0.5 and 1.  With an elastic wall they were within 5 % at c = 0.1, and 4 to 13 % short
        at c = 0.3.
        Behind lossy walls they were up to 30 % too long.

        Examples
        --------
        >>> import springpot as sp
        >>> light = sp.theory.envelope(sp.Oscillator(springpot=sp.Springpot(1.0, 0.1)))
        >>> passage = light.first_passage(amplitude=3.0)
        >>> round(passage.mean_time, 1), float(passage.survival(20.0).round(2))
        (11.5, 0.14)
        """
        levels = {"amplitude": amplitude, "energy": energy, "x": x, "distance": distance}
        given = {name: level for name, level in levels.items() if level is not None}
        if len(given) != 1:
            raise TypeError("first_passage takes one level: amplitude, energy, x or distance.")
        if x is not None:
            return self._first_passage_of_x(finite_number(x, "x", low=-LARGEST, high=LARGEST), both=False)
        (name, level), law = next(iter(given.items())), self._stationary_law()
        level = finite_number(level, name, low=0.0, open_low=True)
        if distance is not None:
            return self._first_passage_of_x(level, both=True)
        kappa, omega = law.kappa, self.system.natural_frequency
        if math.isnan(omega):
            raise NotCoveredError(f"The first passage of {name} needs a linear spring, and here there is none.")
        if energy is not None:
            level = math.sqrt(2.0 * level) / omega  # of the amplitude with this energy
        else:
            kappa *= (omega / self.system.resonance) ** 2
        largest = _largest_amplitude(law.cells, kappa) * law.units.length
        if not largest[0] < level < largest[-1]:
            ends = largest[0], largest[-1]
            if energy is not None:
                ends = tuple(0.5 * (omega * end) ** 2 for end in ends)
            raise ValueError(
                f"{name} must be a level between {ends[0]:g} (rest) and {ends[1]:g} (which is never reached), not "
                f"{given[name]:g}."
            )
        diffusion = law.cells.diffusion
        return law.in_seconds(diffusion.first_passage(float(np.interp(level**2, largest**2, diffusion.action))))

    def _first_passage_of_x(self, level: float, *, both: bool) -> FirstPassage:
        """First passage of x on one side, or on both: the largest x of a cycle is looked at once in it, or twice."""
        law = self._stationary_law()
        instead = f"otherwise simulate it with first_passage={{'{'distance' if both else 'x'}': level}}."
        if not law.balance.problem.closed:
            raise NotCoveredError(f"first_passage of x covers an Oscillator alone: {instead}")
        paper = self.paper
        if paper.restitution < 1.0 or paper.dimensionless_coefficient > _LIGHTEST * ROUNDED:
            raise NotCoveredError(
                f"first_passage of x covers c up to {_LIGHTEST:g} and an elastic wall or none: {instead}"
            )
        direction = paper.direction
        cells = law.cells
        wall = math.inf if paper.barrier is None else -direction * paper.barrier.position
        wanted = (1.0 if both else direction or math.copysign(1.0, level)) * level / law.units.length
        reached = np.maximum.accumulate(cells.cycles.path(cells.problem, np.zeros(1))[0][:, 0])
        if not max(reached[0], 0.0) < wanted < reached[-1]:
            raise ValueError(f"x must be a level that x can reach on the side away from the wall, not {level:g} m.")
        action = float(np.interp(wanted, reached, cells.diffusion.action))
        # behind a wall that is nearer than the level there is only one side
        looks = 2.0 if both and level <= wall else 1.0
        cycle = float(np.interp(action, cells.diffusion.action, cells.cycles.period))
        return law.in_seconds(cells.diffusion.first_passage_seen(action, cycle / looks))

    def _more(self) -> dict[str, object]:
        return {"frequency": None if self.balance is None else self.frequency}

    def _amplitude(self, a: Floats, time: float | None) -> Floats:
        law = self._stationary_law()
        if time is not None:
            t = finite_number(time, "time", low=0.0, open_low=True, hint="At rest the amplitude has no density.")
            law = law.later(t / law.units.time)
        return law.amplitude(a / law.units.length) / law.units.length


@dataclass(frozen=True)
class _Law:
    """Densities and diffusion of a converged balance, computed at first use; of the paper's problem dimensionless."""

    units: Units
    balance: Balance
    impacts: list[Impacts]
    kappa: float  # (frequency of the units / Omega)^2: A^2 = x^2 + kappa v^2
    ratio: Callable[[Floats], Floats] = np.ones_like  # of the density to the stationary one

    @cached_property
    def cells(self) -> Cells:
        """The diffusion in time."""
        return self.balance.cells()

    @cached_property
    def portrait(self) -> Portrait:
        """The arcs in the plane of x and v."""
        if not self.balance.problem.closed:
            raise NotCoveredError(
                "The envelope has the densities of amplitude and energy of the paper's problem alone: a linear spring "
                "with one springpot or dashpot, white noise and at most one rigid wall."
            )
        return portrait(self.balance, self.ratio)

    @cached_property
    def _in_plane(self) -> Densities:
        """Of displacement and velocity."""
        return self.portrait if self.balance.problem.closed else DensityInWell(self.balance)

    def later(self, time: float) -> _Law:
        """The same at a time from rest."""
        cells = self.cells
        ratio = cells.diffusion.from_rest(np.array([time]))[0] / cells.diffusion.mass
        return replace(self, ratio=lambda label: np.asarray(np.interp(label, cells.label, ratio)))

    def in_seconds(self, passage: FirstPassage) -> FirstPassage:
        """A dimensionless one in units."""
        unit = self.units.time
        return FirstPassage(passage.mean_time * unit, passage.rates / unit, passage.weights)

    def x(self, x: Floats) -> Floats:
        """Density of the displacement."""
        return self._in_plane.x_density(x)

    def v(self, v: Floats) -> Floats:
        """Density of the velocity."""
        return self._in_plane.v_density(v)

    def joint(self, x: Floats, v: Floats) -> Floats:
        """Density of both."""
        return self._in_plane.joint(x, v)

    def amplitude(self, amplitude: Floats) -> Floats:
        """Density of sqrt(x^2 + kappa v^2)."""
        return np.clip(amplitude, 0.0, self._energy_table.end) * self._energy_table.density(amplitude)

    def impact_speed(self, speed: Floats) -> Floats:
        """Density of the speed just before an impact."""
        known = [each for each in self.impacts if each.rate > 0.0 or math.isnan(each.rate)]
        if not known or not all(each.speeds.size for each in known):
            raise NotCoveredError(
                "There is no density of impact speeds here: no impacts happen, or infinitely many of speed 0, or they "
                "are on a soft contact or without white noise, where the envelope has their rate and moments alone."
            )
        of_walls = (each.rate * Tabulated.make(each.speeds, each.density).density(speed) for each in known)
        return np.asarray(sum(of_walls) / sum(each.rate for each in known))

    @cached_property
    def _energy_table(self) -> Tabulated:
        return self.portrait.energy(self.kappa)


def envelope_of_paper(system: System) -> Envelope:
    """The form of the paper's problem."""
    paper = check_paper_covered(system)
    law = None
    stationary: Moments | str
    if without := _without(paper):
        stationary = without
    elif paper.excitation.intensity == 0.0:
        stationary = at_rest(system, paper)
    else:
        problem, units = problem_and_units(paper, order_0_is_spring=True)
        settled, (mean, square, v_square), struck = _solved(problem)
        law = _Law(units, settled, struck, (units.frequency / paper.natural_frequency) ** 2)
        (hit,) = [(each.rate, each.speed_mean, each.speed_mean_square) for each in struck] or [NEVER_STRUCK]
        stationary = units.moments(system, mean, square, v_square, hit)
    return Envelope(
        method="envelope",
        system=system,
        stationary=stationary,
        assumptions=_assumptions(paper),
        warnings=_warnings(paper, law),
        balance=None if law is None else law.balance,
        _law=law,
    )


def check_paper_covered(system: System) -> Dimensionless:
    """The paper's problem where it is covered; otherwise `NotCoveredError`."""
    paper = paper_covered(system)
    if _without(paper) or paper.excitation.intensity == 0.0:
        return paper
    problem, _ = problem_and_units(paper, order_0_is_spring=True)
    if problem.position > _DEEPEST_PRELOAD * ROUNDED:
        raise NotCoveredError(
            f"The envelope covers preloads up to {_DEEPEST_PRELOAD:g} sqrt(q / Omega^3), not {problem.position:.3g}."
        )
    if problem.order < 1.0 and problem.coefficient > _STRONGEST * ROUNDED:
        raise NotCoveredError(
            f"The envelope covers springpots up to c = C Omega^(alpha-2) = {_STRONGEST:g}, "
            f"not {problem.coefficient:.3g}."
        )
    return paper


def _solved(problem: PaperProblem) -> tuple[Balance, tuple[float, float, float], list[Impacts]]:
    """The balance, its moments and its impacts."""
    try:
        settled = balance(problem)
        if isinstance(settled, str):
            raise NotCoveredError(settled)
        return changed(settled, impacts(settled))
    except NotCoveredError as unsettled:
        raise NotCoveredError(
            f"The envelope does not converge at c = C Omega^(alpha-2) = {problem.coefficient:.3g} with a wall at "
            f"{problem.position:.3g} sqrt(q / Omega^3): its iteration finds no cycles that agree with their own mean."
        ) from unsettled


def _without(paper: Dimensionless) -> str | None:
    """Why there is no stationary state."""
    loss = paper.dimensionless_coefficient * math.sin(paper.springpot.order * math.pi / 2.0)
    if paper.barrier is not None:
        loss += 1.0 - paper.restitution
    if (statement := endless(paper)) or loss >= _SMALLEST_LOSS:
        return statement
    return f"There is no stationary state in floating point: the loss {loss:.2g} of a cycle is too small."


def _largest_amplitude(cells: Cells, kappa: float) -> Floats:
    """Largest sqrt(x^2 + kappa v^2) along each cycle, at its ends or between them."""
    x, v = cells.cycles.path(cells.problem, np.linspace(0.0, 1.0, _PLACES))
    ways = [(x + cells.problem.origin, v)]
    if cells.stretch is not None:
        ways = [(cells.stretch.x(x), cells.stretch.v(way * v)) for way in (-1.0, 1.0)]
    largest = np.max([np.max(x * x + kappa * v * v, axis=1) for x, v in ways], axis=0)
    return np.asarray(np.maximum.accumulate(np.sqrt(largest)))


def _assumptions(paper: Dimensionless) -> tuple[str, ...]:
    common = (
        "The energy changes little in one cycle: damping and noise are light or moderate.",
        "Between impacts the motion is an arc of one frequency; the springpot acts as a spring about the mean of the "
        "cycle, and as a second, softer spring against slow changes of this mean.",
        "The past motion is stationary: the start no longer matters.",
    )
    if paper.barrier is None or paper.restitution == 1.0:
        return common
    return (*common, "During an impact and the short flight after it the springpot is treated as a dashpot.")


def _warnings(paper: Dimensionless, law: _Law | None) -> tuple[str, ...]:
    c, wall = paper.dimensionless_coefficient, paper.barrier
    sentences: list[str] = []
    if wall is not None and COLLAPSE_BELOW < paper.restitution < 0.5:
        sentences.append(
            "Many impacts are slow: at r = 0.3 the impact rate is within 2 % for c up to 0.3, and 8 % too low at c = 1 "
            "with a preload, where impact speeds are 9 % too high; below r = 0.25 it was compared with Monte Carlo at "
            "order 1 only."
        )
    if wall is not None and paper.restitution < 1.0 and c > DAMPINGS[-1]:
        sentences.append(
            f"The dashpot is too strong for the table of lossy walls (c = C Omega^(alpha-2) = {c:.3g}): at c = 10 "
            "impact rate and speeds were up to 15 % off; use the Fokker-Planck equation."
        )
    if wall is not None and paper.restitution <= COLLAPSE_BELOW:
        sentences.append(
            f"Below restitution {COLLAPSE_BELOW:.3f} there are infinitely many slow impacts: impact rate and speeds "
            "do not exist."
        )
    if law is not None and law.balance.change > _NOT_SETTLED:
        change = law.balance.change
        sentences.append(f"The iteration has not converged: its numbers still change by {change:.2g} per step.")
    return tuple(sentences)


@np.errstate(all="ignore")  # what is not finite is no answer
def envelope(system: System) -> Envelope:
    """Solve a system by diffusion of its energy, with the mean field of the envelope.

    Parameters
    ----------
    system : System
        The paper's problem, a linear spring with one springpot or dashpot and white noise: any order, wall,
        restitution, or no wall; a preload up to 100 sqrt(q / Omega^3); c up to 3 for orders between 0 and 1.  With
        other parts see `envelope_of_system`.

    Returns
    -------
    Envelope

    Raises
    ------
    NotCoveredError
        If the preload is deeper, the springpot stronger, or cycles of different size cross.
    TypeError
        If it is not a System.

    Examples
    --------
    >>> import springpot as sp
    >>> lossy = sp.Oscillator(springpot=sp.Springpot(0.5, 0.1), barrier=sp.Barrier(-1.0, restitution=0.8))
    >>> result = envelope(lossy)
    >>> round(result.amplitude_mean_square, 1), round(result.impact_rate, 3)
    (6.5, 0.207)
    """
    solve: Callable[[System], Envelope] = form_of(system, envelope_of_paper, envelope_of_system)
    return solve(system)


def check_covered(system: System) -> None:
    """Raise `NotCoveredError` for what is not covered."""
    check: Callable[[System], object] = form_of(system, check_paper_covered, check_system_covered)
    check(system)


def envelope_of_system(system: System) -> Envelope:
    """Solve a system by diffusion of the energy of its cycles.

    Parameters
    ----------
    system : System
        Any springs, contacts without loss and constant forces that leave one well; rigid walls; dampers, memory and
        circuits; white, colored, filtered, Poisson, parametric and thermal noise.

    Returns
    -------
    Envelope

    Raises
    ------
    NotCoveredError
        If there are two wells, a harmonic force, a contact with loss, or memory so strong that cycles of different size
        cross; the sentence names the part.
    TypeError
        If it is not a System.

    Notes
    -----
    A cycle is a periodic motion in the potential U(x) + k1 (x - X0)^2 / 2 between the walls.  k1 is the mean in-phase
    stiffness of the memory over the harmonics X_n of the cycle, X0 the cycle's mean.  With the power
    P = (1/2) sum n w Im K(n w) X_n^2 that an element of modulus K takes, further losses L, the rate D at which noise
    spreads the energy, and the action J = int v dx - (pi/2) sum n Re K'(n w) X_n^2, the stationary density per action
    is exp(-int 2 (P + L) / (D T) dJ).  The second term makes J that of a wave with dispersion [1]_: for a linear
    oscillator <v^2> is then exact to first order in K.  The number of impacts on a single wall is a mean per area
    T <v^2> of the plane of x and v in place of J.  Springpots also have the mean field of the envelope of an
    oscillator: k1 and P of lines that have a width, and, with at most one wall, a spring against slow changes of X0.

    References
    ----------
    .. [1] G. B. Whitham, "Linear and nonlinear waves", Wiley (1974), chapter 14.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(
    ...     sp.Spring(1.0), sp.PolynomialSpring((0.0, 0.0, 1.0)), sp.Springpot(0.5, 0.2), sp.WhiteNoise(0.5),
    ...     sp.Barrier(-1.0, 0.9), sp.Barrier(0.7, 0.8, free_side="below"),
    ... )
    >>> result = envelope_of_system(device)
    >>> round(result.x_mean_square, 2), round(result.barrier_1_impact_rate, 2), round(result.barrier_2_impact_rate, 2)
    (0.23, 0.17, 0.25)
    """
    system = checked_system(system)
    problem = check_system_covered(system)
    law, warnings = None, tuple[str, ...]()
    stationary: Moments | str
    if isinstance(problem, str):
        stationary = problem
    elif isinstance(settled := balance(problem), str):
        stationary = settled
    else:
        stationary, struck = _moments_of_system(system, settled)
        law = _Law(Units(1.0, 1.0, 1.0, 1.0, settled.problem.origin), settled, struck, system.natural_frequency**-2)
        warnings = tuple(_warnings_of_system(settled))
    return Envelope(
        method="envelope",
        system=system,
        stationary=stationary,
        assumptions=(
            "The energy changes little in one cycle: damping and noise are light or moderate.",
            "The memory acts on a cycle as a spring and as a damper, and on slow changes of its mean as a softer "
            "spring, but not between two walls.",
            "After an impact the energy is that of the whole cycle; with one lossy wall and white noise sudden losses "
            "are corrected as at order 1, and with white noise short returns to a lossy wall are counted.",
        ),
        warnings=warnings,
        is_exact=not isinstance(problem, str) and _is_exact(problem),
        balance=None if law is None else law.balance,
        _law=law,
    )


def _check_rest(unit: System, bottom: float) -> None:
    """A mass that a smooth force lifts now and then from a wall on which it rests does not go round in cycles."""
    for name, wall in unit.walls.items():
        if slow_restitution(wall) == 1.0 or not is_smooth(unit):
            continue
        pressing = float(unit.potential.force(wall.position)) * wall.inwards
        if wall.position == bottom and pressing > 0.0:
            raise NotCoveredError(
                f"{REACH}; here the mass comes to rest on {name}, which is lossy and on which it is pressed, and a "
                "smooth force lifts it now and then."
            )


def check_system_covered(system: System) -> Problem | str:
    """What is solved, or why there is no stationary state; `NotCoveredError` for what is not covered."""
    unit = system.per_unit_mass
    _COVERED.check(unit)
    if not any(noise.excites for noise in unit.excitations.values()):
        return "There is no random stationary state: nothing excites the motion."
    if not unit.potential.holds():
        return unheld(unit.elements.values(), "no spring or wall holds the mass on one side")
    problem = _problem(unit)
    if problem.remembers and not np.any(unit.potential.coefficients) and not unit.potential.contacts:
        raise NotCoveredError(f"{REACH}; with memory it needs a spring or a force to hold a small cycle in its place.")
    if problem.unit.temperature > 0.0 and not problem.remembers and not problem.damping > 0.0:
        raise NotCoveredError(
            "ThermalNoise needs something that dissipates: a dashpot, a springpot, an arm or a circuit."
        )
    _check_rest(unit, problem.origin)
    return problem


def _problem(unit: System) -> Problem:
    origin, springpots = _bottom(unit.potential), tuple(unit.springpots.values())
    return Problem(
        potential=unit.potential.seen_from(origin),
        origin=origin,
        damping=unit.dashpots,
        elements=tuple(part for part in unit.parts if part.remembers and not (part.of_load or part in springpots)),
        circuits=tuple(part for part in unit.parts if part.of_load),
        unit=unit,
    )


def _bottom(potential: Potential) -> float:
    """The place of the one well.

    Raises
    ------
    NotCoveredError
        If there are several.
    """
    low, high = potential.low, potential.high
    roots = roots_of(potential.coefficients).real if len(potential.coefficients) > 1 else np.zeros(0)
    starts = [contact.position for contact in potential.contacts]
    walls = [place for place in (low, high) if math.isfinite(place)]
    marks = np.unique([*roots, *starts, *walls, 0.0])
    steps = np.geomspace(1e-12, 1e6, 400) * max(float(np.abs(marks).max()), _length(potential))
    places = np.concatenate([*(mark + sign * steps for mark in marks for sign in (-1.0, 1.0)), marks])
    places = np.unique(places[(places >= low) & (places <= high)])
    force = potential.force(places)
    size = polynomial.polyval(np.abs(places), np.abs(potential.coefficients))
    told = np.abs(force) > 1e-10 * (size + np.abs(force))
    places, signs = places[told], np.sign(force[told])
    if not places.size:
        return 0.5 * (low + high)
    wells = [(a, b) for a, b, s, t in zip(places, places[1:], signs, signs[1:], strict=False) if s < 0.0 < t]
    at_walls = [low] * bool(signs[0] > 0.0) + [high] * bool(signs[-1] < 0.0)
    if len(wells) + len(at_walls) > 1:
        raise NotCoveredError(f"{REACH}, not two wells.")
    if at_walls:
        return float(at_walls[0])
    return float(optimize.brentq(lambda x: float(potential.force(x)), *wells[0], xtol=1e-300, rtol=1e-15))


def _length(potential: Potential) -> float:
    """Some length of the potential, where no place has one."""
    terms = [(n, abs(c)) for n, c in enumerate(potential.coefficients) if c != 0.0 and n > 0]
    if len(terms) < 2:
        return 1.0
    (n, first), (m, last) = terms[0], terms[-1]
    return math.exp(min(max(math.log(first / last) / (m - n), -100.0), 100.0))


def _is_exact(problem: Problem) -> bool:
    """Whether the density depends on the energy alone: linear dampers, white noise and elastic walls."""
    unit = problem.unit
    rough = any(part.is_rough for part in unit.parts)
    lossy = any(not wall.is_elastic for wall in unit.walls.values())
    noises = unit.excitations.values()
    other = any(not noise.is_gaussian or (noise.has_density and not noise.is_white) for noise in noises)
    return not (problem.remembers or rough or other or lossy)


def _moments_of_system(system: System, law: Balance) -> tuple[Moments, list[Impacts]]:
    problem = law.problem
    _, (mean, square, v_square), struck = changed(law, impacts(law))
    x_square = problem.origin * (problem.origin + 2.0 * mean) + square
    harvests = problem.circuits and problem.unit.temperature == 0.0
    power = law.average(law.rates.electric) * system.inertia if harvests else None
    hits = [(each.rate, each.speed_mean, each.speed_mean_square) for each in struck]
    return moments_of(system, [(problem.origin + mean, x_square, v_square)], (), hits, power), struck


def _warnings_of_system(law: Balance) -> Iterator[str]:
    problem, unit, cycles, rates = law.problem, law.problem.unit, law.cycles, law.rates
    assert isinstance(cycles, CyclesInWell)
    energy = law.average(cycles.energy)
    harmless = problem.damping * cycles.v_square  # exact between elastic walls
    taken = law.average(np.abs(rates.loss - harmless) * cycles.period) / energy
    if taken > _STRONG:
        yield f"Damping is not light, as the envelope assumes: a cycle takes {taken:.2g} times the mean energy."
    yield from endless_walls(unit, lambda wall: is_endless(unit, wall))
    decay = law.average(rates.loss) / energy
    for name, noise in unit.excitations.items():
        if noise.correlated_for * decay > _STRONG:
            yield f"{name} remembers longer than the energy does: its work is not that of a short correlation."
        if 0.5 * noise.impulses[1] > 0.1 * energy:
            yield f"The impulses of {name} are so rare that the energy jumps: here they act as white noise."
