"""The energy envelope: slow diffusion of the size of the cycles in any single well."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.polynomial import polynomial
from scipy import optimize

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
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
from springpot.theory.methods.envelope.balance import Labels, slow_line
from springpot.theory.methods.envelope.method import Envelope, check_paper_covered, envelope_of_paper
from springpot.theory.methods.systems.cycles import (
    COARSE,
    FINE,
    REACH,
    Cycles,
    Field,
    Ladder,
    Problem,
    check_settled,
    ladder_of,
    speed_at,
)
from springpot.theory.methods.systems.impacts import (
    Spread,
    after_impact,
    endless_walls,
    hits_on_walls,
    is_endless,
    is_smooth,
    with_sudden_losses,
)
from springpot.theory.numerics.energy_diffusion import make_energy_diffusion
from springpot.theory.numerics.equations import Anderson, roots_of
from springpot.theory.result import Moments, Result, moments_of

_LOWEST, _HIGHEST = -50.0, 40.0  # decades of energy that are searched, in m^2/s^2
_FAR = 42.0  # the density ends where its share in the mean energy has fallen by e^-42
_NEAR, _BROAD = 0.25, 1.0  # widths of panels in ln E, up to a hundred times the typical energy and beyond
_DEPTH, _CUTOFF, _FIELD_STEPS, _FIELD_SETTLED = 3, 1e-8, 30, 3e-4  # of the mean field
_STILL = 1e-6  # variance of the cycles' mean over <x^2>, below which slow changes of it are not followed
_STRONG = 1.0  # loss in a cycle over the energy, above which it is said
# no ResonantCircuit: two motions that take turns are no slow change of one cycle
_ELEMENTS = SPRINGS | DAMPERS | VanDerPol | Springpot | ARMS | PiezoelectricCircuit
_NOISES = WhiteNoise | ColoredNoise | KanaiTajimiNoise | PoissonImpulses | ParametricNoise | ThermalNoise
_COVERED = Coverage(REACH, INERTIA | _ELEMENTS | STOPS | Constant | _NOISES)


@dataclass(frozen=True)
class _Rates:
    """What changes the energy of cycles: one entry per cycle.

    Parameters
    ----------
    loss, spread : ndarray
        Mean power that is taken, and the rate D at which the variance of the energy grows.
    action : ndarray
        That of the cycle with its memory: the integral of v dx, less what the memory lends out to a slow change.
    electric : ndarray
        Power in the resistors.
    struck : tuple of ndarray
        The speed at each wall and contact at first touch, before the loss is counted; NaN where it is not reached.
    damped : ndarray
        The part of ``loss`` that is not of impacts.
    """

    loss: Floats
    spread: Floats
    action: Floats
    electric: Floats
    struck: tuple[Floats, ...]
    damped: Floats


def _rates(problem: Problem, cycles: Cycles) -> _Rates:
    unit = problem.unit
    loss = problem.damping * cycles.v_square
    for part in unit.parts:
        for c, mean in zip(part.damping_coefficients()[1:], (cycles.v_third, cycles.v_fourth), strict=False):
            loss = loss + c * mean
    for part in unit.parts:
        loss = loss + part.power_beside(cycles)
    memory, electric = np.zeros_like(loss), np.zeros_like(loss)
    action = cycles.period * cycles.v_square
    if problem.remembers:
        memory = 0.5 * cycles.sum_over(lambda n, w: w * problem.modulus(1j * w).imag) + _broadened(problem, cycles)
        electric = 0.5 * cycles.sum_over(lambda n, w: w * problem.electric(1j * w).imag)
        action = action - 0.5 * math.pi * cycles.sum_over(lambda n, w: n * _slope(problem, w))
    kinetic = problem.damping * cycles.v_square + memory
    spread = 2.0 * problem.unit.temperature * kinetic
    spread = spread + problem.white * cycles.v_square
    spread = spread + problem.multiplied * cycles.xv_square
    colored = [noise for noise in unit.excitations.values() if noise.has_density and not noise.is_white]
    colored.sort(key=lambda noise: noise.filter_order or 0)  # the last bit of a sum depends on its order
    for density in (np.vectorize(noise.density, otypes=[float]) for noise in colored):
        spread = spread + math.pi * cycles.sum_over(lambda n, w, density=density: w * w * density(w))
    loss, struck = loss + memory, []
    taken = loss
    for name, stop in unit.stops.items():
        speed = speed_at(problem, cycles, stop.position - problem.origin)
        struck.append(speed)
        if wall := unit.walls.get(name):
            r, before = after_impact(problem, wall, speed, loss, cycles)
            taken = taken + 0.5 * before * np.nan_to_num(speed) ** 2 * (1.0 - r**2) / cycles.period
    return _Rates(taken, spread, action, electric, tuple(struck), loss)


def _slope(problem: Problem, w: Floats) -> Floats:
    """Derivative of the in-phase stiffness by the frequency."""
    step = 1e-5
    up, down = (problem.modulus(1j * w * factor).real for factor in (1.0 + step, 1.0 - step))
    return np.asarray((up - down) / (2.0 * step * w))


@dataclass(frozen=True)
class _Law:
    """The stationary law on a grid of cycles: their probabilities, how the action diffuses, and `_range`.

    ``plane`` are the probabilities per area of the plane of x and v in place of those per action.
    """

    cycles: Cycles
    rates: _Rates
    weight: Floats
    plane: Floats
    strength: Floats
    range: tuple[float, float, float]
    labels: Labels

    def average(self, values: Floats) -> float:
        return float(self.weight @ values)


def _range(problem: Problem, ladder: Ladder) -> tuple[float, float, float] | str:
    """The least and largest label of interest and their typical size, or why there is no stationary state."""
    low, high = _LOWEST, _HIGHEST
    for count in (361, 241, 241):
        decades = np.linspace(low, high, count)
        label = 10.0**decades
        with np.errstate(all="ignore"):
            cycles = ladder.cycles(problem, label, COARSE)
            rates = _rates(problem, cycles)
            slope = 2.0 * rates.loss / (rates.spread * cycles.period)
            known = np.isfinite(slope) & np.isfinite(rates.action) & (rates.action > 0.0)
        if not np.any(known):
            raise NotCoveredError(f"{REACH}; here the energies are beyond double precision.")
        label, decades, slope, action = label[known], decades[known], slope[known], rates.action[known]
        fall = np.r_[0.0, np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(action))]
        near = np.log(action) - fall
        far = near + np.log(label)
        first = int(np.argmax(near > near.max() - _FAR))
        last = label.size - 1 - int(np.argmax((far > far.max() - _FAR)[::-1]))
        if last == label.size - 1 and (high == _HIGHEST or far[-1] > far.max() - 0.5 * _FAR):
            return "feeds"
        typical = float(np.exp(np.average(np.log(label), weights=np.exp(near - near.max()))))
        low, high = float(decades[max(first - 1, 0)]), float(decades[min(last + 1, decades.size - 1)])
    return 10.0**low, 10.0**high, typical


def _law(problem: Problem) -> _Law | str:
    """The stationary law, with the mean field that it makes itself where the two can be found together."""
    if not problem.springpots or problem.unit.temperature > 0.0:  # matched noise balances the broadened lines too
        return _law_in(problem)
    first, second = (_law_in, _law_in_its_field) if problem.walls == 2 else (_law_in_its_field, _law_in)
    try:
        return first(problem)
    except NotCoveredError:
        return second(problem)


def _law_in_its_field(problem: Problem) -> _Law | str:
    """The law and its mean field, found together."""
    law = _law_in(problem, COARSE)
    if isinstance(law, str):
        return law
    here = np.array(astuple(_field(problem, law)))
    spread = math.sqrt(law.average(law.cycles.x_square))
    mix = Anderson(_DEPTH, _CUTOFF)
    for _ in range(_FIELD_STEPS):
        inside = replace(problem, field=Field(*here.tolist()))
        law = _law_in(inside, COARSE, law)
        if isinstance(law, str):
            return law
        there = np.array(astuple(_field(inside, law)))
        scales = np.array([here[0] + there[0], spread, 1.0, here[3] + there[3]])
        if np.all(np.abs(there - here) <= _FIELD_SETTLED * scales):
            return _law_in(replace(problem, field=Field(*there.tolist())), like=law)
        mixed = mix.part_of_step(here, there, 1.0)
        here = mixed if min(mixed[0], mixed[2], mixed[3]) >= 0.0 else there
    raise NotCoveredError(f"{REACH}; here the mean field of the cycles does not settle: the memory is too strong.")


def _field(problem: Problem, law: _Law) -> Field:
    """The averages of a law, as in the envelope of an oscillator."""
    cycles, rates = law.cycles, law.rates
    mean, decay = law.average(cycles.mean), law.average(rates.loss) / (2.0 * law.average(cycles.v_square))
    width = decay / law.average(np.sqrt(np.maximum(cycles.arc, 0.0)))
    likely = law.weight > 1e-25 * law.weight.max()
    likely &= np.diff(np.maximum.accumulate(rates.action), prepend=0.0) > 0.0
    diffusion = make_energy_diffusion(rates.action[likely], law.weight[likely], law.strength[likely])
    kept = np.flatnonzero(likely)[np.isin(rates.action[likely], diffusion.action)]
    rate, squares = diffusion.spectrum(cycles.mean[kept])
    variance = float(squares.sum())
    # between two walls the mean of a growing cycle turns back at the second one: worse with such a spring than without
    if problem.walls == 2 or variance <= _STILL * law.average(cycles.x_square):
        return Field(0.0, mean, width, 0.0)
    whole = law.average(_broadened(replace(problem, field=Field(extra=decay)), cycles))
    springpots = [(springpot.order, springpot.coefficient) for springpot in problem.springpots]
    stiffness, share = slow_line(springpots, rate, squares, law.average(cycles.frequency), whole)
    return Field(stiffness, mean, width, share * decay)


def _broadened(problem: Problem, cycles: Cycles) -> Floats:
    """Power that springpots take because the harmonics are lines of finite width, beyond that of an arc."""
    found = np.zeros_like(cycles.energy)
    if problem.field.extra == 0.0:
        return found
    arc = np.maximum(cycles.arc, 1e-300)[:, None]
    for springpot in problem.springpots:
        whole = (
            0.25
            * springpot.coefficient
            * math.cos(springpot.order * math.pi / 2.0)
            * (1.0 - springpot.order)
            * problem.field.extra
        )
        found = found + whole * cycles.sum_over(lambda n, w, a=springpot.order: w**a * (w * w / arc - 1.0))
    return np.maximum(found, 0.0)


def _law_in(problem: Problem, size: tuple[int, int] = FINE, like: _Law | None = None) -> _Law | str:
    """The stationary law in a given mean field, found from that in a similar one."""
    ladder = ladder_of(problem)
    found = like.range if like else _range(problem, ladder)
    if isinstance(found, str):
        if problem.multiplied > 0.0:
            return "There is no stationary mean square: the noise that multiplies x feeds more than is dissipated."
        return "There is no stationary state: nothing dissipates energy, so it grows without end."
    low, high, typical = found
    if low > 0.02 * high:
        edges = np.linspace(low, high, 25)
    else:
        least = typical / 30.0
        near = np.arange(math.log(least), math.log(min(high, 100.0 * typical)), _NEAR)
        edges = np.r_[0.0, np.exp(near), np.exp(np.arange(near[-1] + _NEAR, math.log(high), _BROAD)), high]
    cuts = [start for start in ladder.starts if edges[0] < start < edges[-1]]
    edges = np.unique(np.r_[edges, cuts])
    edges = edges[np.r_[True, np.diff(edges) > 1e-9 * edges[1:]]]
    labels = Labels(np.arange(float(edges.size)), 0, 0.0)
    panel = np.repeat(np.arange(edges.size - 1), labels.nodes.shape[1])
    part = labels.nodes.ravel() - panel
    bent = np.isin(edges, [0.0, *cuts])[panel]  # roots of the energy above a place that is just reached
    label = edges[panel] + (edges[panel + 1] - edges[panel]) * np.where(bent, part * part, part)
    cycles = ladder.cycles(problem, label, size, like.cycles if like else None)
    check_settled(cycles)
    rates = _rates(problem, cycles)
    measure = labels.derivative(rates.action)
    fall = labels.integral(2.0 * rates.loss / (rates.spread * cycles.period) * measure)
    weight = labels.weights.ravel() * measure * np.exp(fall.min() - fall)
    if not np.all(np.isfinite(weight)):
        raise NotCoveredError(f"{REACH}; here cycles and their own stiffness do not settle: the memory is too strong.")
    if np.any(weight < -1e-6 * np.abs(weight).sum()):
        raise NotCoveredError(f"{REACH}; here cycles of different size cross: the memory is too strong.")
    weight = plane = np.maximum(weight, 0.0)
    if problem.walls == 1:  # between two, of which a cycle may strike both, rates per action are better
        area = np.maximum(labels.derivative(cycles.period * cycles.v_square), 0.0)
        plane = labels.weights.ravel() * area * np.exp(fall.min() - fall)
    # D f / J of the diffusion of the action: D is half the rate at which its variance grows
    strength = 0.5 * rates.spread * cycles.period**2 * np.exp(fall.min() - fall) / rates.action
    return _Law(cycles, rates, weight / weight.sum(), plane / plane.sum(), strength / weight.sum(), found, labels)


@np.errstate(all="ignore")  # what is not finite is no answer
def envelope(system: System) -> Envelope | Result:
    """Solve a system by diffusion of its energy, with the mean field of the envelope.

    Parameters
    ----------
    system : System
        The paper's problem, a linear spring with one springpot or dashpot and white noise: any order, wall,
        restitution, or no wall; a preload up to 100 sqrt(q / Omega^3); c up to 3 for orders between 0 and 1.  With
        other parts see `envelope_of_system`.

    Returns
    -------
    Envelope or Result
        The former of the paper's problem.

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
    solve: Callable[[System], Envelope | Result] = form_of(system, envelope_of_paper, envelope_of_system)
    return solve(system)


def check_covered(system: System) -> None:
    """Raise `NotCoveredError` for what is not covered."""
    check: Callable[[System], object] = form_of(system, check_paper_covered, check_system_covered)
    check(system)


def envelope_of_system(system: System) -> Result:
    """Solve a system by diffusion of the energy of its cycles.

    Parameters
    ----------
    system : System
        Any springs, contacts without loss and constant forces that leave one well; rigid walls; dampers, memory and
        circuits; white, colored, filtered, Poisson, parametric and thermal noise.

    Returns
    -------
    Result

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
    warnings: tuple[str, ...] = ()
    stationary: Moments | str
    if isinstance(problem, str):
        stationary = problem
    elif isinstance(law := _law(problem), str):
        stationary = law
    else:
        stationary, warnings = _moments(system, problem, law), tuple(_warnings(problem, law))
    return Result(
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
    origin = _bottom(unit.potential)
    return Problem(
        potential=unit.potential.seen_from(origin),
        origin=origin,
        damping=unit.dashpots,
        elements=tuple(part for part in unit.parts if part.remembers and not part.of_load),
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


def _moments(system: System, problem: Problem, law: _Law) -> Moments:
    cycles, rates = law.cycles, law.rates
    spread = Spread(law.average(cycles.mean), law.average(cycles.x_square), law.average(cycles.v_square))
    hits = hits_on_walls(problem, cycles, law.labels, law.weight, law.plane, rates.struck, rates.damped)
    spread, hits = with_sudden_losses(problem, cycles, law.weight, rates.struck, rates.damped, spread, hits)
    x_square = problem.origin * (problem.origin + 2.0 * spread.mean) + spread.x_square
    harvests = problem.circuits and problem.unit.temperature == 0.0
    power = law.average(rates.electric) * system.inertia if harvests else None
    return moments_of(system, [(problem.origin + spread.mean, x_square, spread.v_square)], (), hits, power)


def _is_exact(problem: Problem) -> bool:
    """Whether the density depends on the energy alone: linear dampers, white noise and elastic walls."""
    unit = problem.unit
    rough = any(part.is_rough for part in unit.parts)
    lossy = any(not wall.is_elastic for wall in unit.walls.values())
    noises = unit.excitations.values()
    other = any(not noise.is_gaussian or (noise.has_density and not noise.is_white) for noise in noises)
    return not (problem.remembers or rough or other or lossy)


def _warnings(problem: Problem, law: _Law) -> Iterator[str]:
    unit, cycles, rates = problem.unit, law.cycles, law.rates
    harmless = problem.damping * cycles.v_square  # exact between elastic walls
    taken = law.average(np.abs(rates.loss - harmless) * cycles.period) / law.average(cycles.energy)
    if taken > _STRONG:
        yield f"Damping is not light, as the envelope assumes: a cycle takes {taken:.2g} times the mean energy."
    yield from endless_walls(unit, lambda wall: is_endless(unit, wall))
    decay = law.average(rates.loss) / law.average(cycles.energy)
    for name, noise in unit.excitations.items():
        if noise.correlated_for * decay > _STRONG:
            yield f"{name} remembers longer than the energy does: its work is not that of a short correlation."
        if 0.5 * noise.impulses[1] > 0.1 * law.average(cycles.energy):
            yield f"The impulses of {name} are so rare that the energy jumps: here they act as white noise."
