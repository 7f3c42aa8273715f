"""A problem in words: its equation with its numbers, its scales, what dissipates, and which methods cover it."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from springpot import theory  # each method when it is asked for: the equation alone needs none
from springpot.evidence.recommendation import NONE_COVERS
from springpot.machine.faults import NotCoveredError, few, per_cent
from springpot.problem.parts.checks import signed
from springpot.problem.parts.registration import Part, in_words
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System, checked_system
from springpot.theory.solve import grouped

_X = re.compile(r"\bx\b")
MOST_TERMS = 12  # of one side of the equation
_STIFFENED = 1.001  # resonance over natural frequency from which it is said


def explain(system: System) -> str:
    """The equation of a system with its numbers and units, its scales, what dissipates, and which methods cover it.

    Parameters
    ----------
    system : System

    Returns
    -------
    str
        Several lines.  The methods are asked, which takes up to some seconds.

    Raises
    ------
    TypeError
        If it is something else.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Mass(0.2), sp.Spring(80.0), sp.Dashpot(0.4), sp.WhiteNoise(0.02))
    >>> print("\\n".join(explain(device).splitlines()[:4]))
    0.2 x'' + 80 x + 0.4 x' = w(t)
    in SI units: x in m, t in s, forces in N
    w(t): white noise (white_noise), intensity 0.02 N^2 s
    natural frequency 20 rad/s, 3.1831 Hz; period 0.314159 s
    """
    system = checked_system(system)
    names = [name for name, part in system.named() if part.dissipates]
    losses = f"energy is taken by: {few(names)}" if names else "nothing takes energy"
    return "\n".join([*equation(system), *_scales(system), *_filters(system), losses, *_coverage(system)])


def equation(system: System) -> Iterator[str]:
    """The equation of motion of each mass, and a line for each excitation, wall and circuit."""
    excitations = [*_excitations(system)]
    for place, point in enumerate(system.coordinates.names):
        left = [term for name, part in system.named() if (term := _term(system, name, part, place))]
        right = [push for name, symbol, _ in excitations if (push := _push(system, name, symbol, place))]
        sides = _some(left, ""), _some(right, " + ").replace("+ -", "- ") or "0"
        mass = f"{system.coordinates.masses[place]:.6g} " if system.has_mass else ""
        yield f"{mass}{system.coordinates.symbol(point)}''{' = '.join(sides)}"
    yield "in SI units: x in m, t in s, forces in N" if system.has_mass else "per unit mass: x in m, t in s"
    for _, symbol, words in excitations:
        if words:
            yield f"{symbol.removeprefix('x ')}: {words}"
    for name, part in system.named():
        preload = _preload(system, part) if name in system.stops else ""
        if count := system.counts.get(name):
            yield f"{name}: {count} equal ones, written as one part"
        if line := part.line(name) or (preload and f"{part.said} ({name})"):
            yield _with_ends(line, _elongation(system, name)) + preload


def _push(system: System, name: str, symbol: str, place: int) -> str:
    """The symbol of an excitation in the equation of one mass, with what stands before it there."""
    at = system.coordinates
    row = at.elongations.get(name, at.forces.get(name))
    if row is not None and symbol.startswith("x "):  # noise that multiplies the elongation
        symbol, row = _with_ends(symbol, _elongation(system, name, -1 if row[place] < 0.0 else 1)), abs(row)
    if row is None:
        return symbol
    before = {1.0: "", -1.0: "-"}.get(float(share := f"{row[place]:.6g}"), f"{share} ")
    return f"{before}{symbol}" if row[place] else ""


def _term(system: System, name: str, part: Part, place: int) -> str:
    """A part's force in the equation of one mass; the other way round for its first end."""
    term, row = "" if name in system.excitations else part.term(), system.coordinates.elongations.get(name)
    if row is None or not term:
        return term
    if row[place] == 1.0:
        return _with_ends(term, _elongation(system, name))
    if row[place] == 0.0:
        return ""
    if row[place] != -1.0:
        whole = _with_ends(term, _elongation(system, name)).removeprefix(" + ").strip()
        return signed(float(row[place]), f"[{whole}]")
    back = _elongation(system, name, -1)
    if part.is_linear and _X.search(term) and back[0] != "-":
        return _with_ends(term, back)
    if part.soft_stop is not None:
        other = " + " if term.startswith(" - ") else " - "
        return _with_ends(other + term[len(other) :], _elongation(system, name))
    return f" - [{_with_ends(term, _elongation(system, name)).removeprefix(' + ').strip()}]"


def _elongation(system: System, name: str, sign: int = 1) -> str:
    """The symbol of what a part sees of the motion."""
    at = system.coordinates
    if name not in at.ends:
        return "x"
    first, second = (at.symbol(end) if end != "ground" else "" for end in at.ends[name][::sign])
    return f"{second} - {first}" if first and second else second or f"-{first}"


def _with_ends(text: str, x: str) -> str:
    """A text about x, of a part that sees something else."""
    within = x if x.isidentifier() else f"({x})"
    return (
        _X.sub(lambda found: x if text[found.end() :].startswith((" >=", " <=")) else within, text)
        if x != "x"
        else text
    )


def _preload(system: System, wall: Stop) -> str:
    """The words of what presses the mass against a wall at the place of the wall; empty where a gap is left."""
    try:
        alone = replace(system.potential, contacts=())
    except NotCoveredError:  # the springs of several masses press none of them alone
        return ""
    pressed = system.inertia * float(alone.force(wall.position)) * wall.inwards
    unit = "N" if system.has_mass else "m/s^2"
    return f"; preload: the mass is pressed against it with {pressed:.6g} {unit}" if pressed > 0.0 else ""


def _some(terms: list[str], between: str) -> str:
    """The terms of one side of the equation; of many the first ones."""
    left = len(terms) - MOST_TERMS
    return between.join(terms if left <= 1 else [*terms[:MOST_TERMS], f"{'' if between else ' + '}({left} more terms)"])


def _excitations(system: System) -> Iterator[tuple[str, str, str]]:
    """The name of each excitation, its symbol in the equation, and what it is."""
    letters = "wuyzabcdefghijklnopqrs"
    symbols = itertools.chain(letters, (f"{letter}{n}" for n in itertools.count(2) for letter in letters))
    for name, part in system.excitations.items():
        if words := part.words(name, partial(_unit, system, part)):
            ground = ", acceleration of the ground" if part.of_ground else ""
            said = _with_ends(words, _elongation(system, name)) + ground
            yield name, f"{part.factor}{next(symbols)}(t)", said
        else:
            yield name, part.term(), ""


def _unit(system: System, part: Part, number: str) -> str:
    unit: str = part.numbers[number].unit_of(system.has_mass and not part.of_ground)
    return in_words(unit)


def _scales(system: System) -> Iterator[str]:
    try:
        unit, omega = system.per_unit_mass, system.natural_frequency
    except NotCoveredError:
        frequencies = few([f"{w:.6g}" for w in theory.modes(system).frequencies])
        yield f"natural frequencies {frequencies} rad/s"
        return
    if math.isfinite(omega):
        period = 2.0 * math.pi / omega
        yield f"natural frequency {omega:.6g} rad/s, {1.0 / period:.6g} Hz; period {period:.6g} s"
        found, own = system.resonance, dict(system.named())
        if found > _STIFFENED * omega:
            yield f"resonance with all that has memory: {found:.6g} rad/s, {0.5 * found / math.pi:.6g} Hz"
        yield from filter(None, (part.measure(name, omega, found, own[name]) for name, part in unit.named()))
    if any(part.yields for part in system.parts) and not system.potential.holds():
        yield "it drifts without end: only parts that yield hold the mass, and x has no stationary state"


def _filters(system: System) -> Iterator[str]:
    """How near the filters of a simulation are to the densities that they stand for."""
    for name, part in system.densities.items():
        from springpot.simulation.lowering.shaping import shape_of  # Numba is slow to import

        try:
            shape = shape_of(part, name)
        except ValueError as fault:
            yield f"{fault} It cannot be simulated."
            continue
        near = f"within {per_cent(shape.worst)} of it, {per_cent(shape.rms)} rms"
        yield f"{name}: simulated by a filter of {len(shape.poles)} sections whose density is {near}"


def _coverage(system: System) -> Iterator[str]:
    answers, statements = theory.solve_all(system)
    yield f"analytical methods with an answer: {', '.join(answers)}" if answers else f"{NONE_COVERS}:"
    yield from (f"  {sentence}" for sentence in grouped(statements))
    if any(part.envelope is not None for part in system.excitations.values()):
        try:
            exact = theory.transient(system, 0.0).is_exact
        except NotCoveredError as reason:
            yield f"  transient: {reason}"
        else:
            yield f"mean squares in time: theory.transient{'' if exact else ', by linearization at each time'}"
