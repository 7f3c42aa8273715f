"""A problem in words: its equation with its numbers, its scales, what dissipates, and which methods cover it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from springpot.machine.faults import few
from springpot.problem.parts.excitations import Excitation
from springpot.problem.parts.registration import Part, in_words
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System, checked_system
from springpot.theory import solve_all

__all__ = ["equation", "explain"]

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
    return "\n".join([*equation(system), *_scales(system), *_losses(system), *_coverage(system)])


def equation(system: System) -> Iterator[str]:
    """The equation of motion with its numbers, and a line for each excitation, wall and circuit."""
    inertia = f"{system.mass:.6g} x''" if system.has_mass else "x''"
    left = _some([part.term() for part in system.parts if not isinstance(part, Excitation) and part.term()], "")
    excitations = [*_excitations(system)]
    right = _some([symbol for symbol, _ in excitations], " + ").replace("+ -", "- ") or "0"
    yield f"{inertia}{left} = {right}"
    yield "in SI units: x in m, t in s, forces in N" if system.has_mass else "per unit mass: x in m, t in s"
    for symbol, words in excitations:
        if words:
            yield f"{symbol.removeprefix('-').removeprefix('m ').removeprefix('x ')}: {words}"
    for name, part in system.named():
        preload = _preload(system, part) if isinstance(part, Stop) else ""
        if line := part.line(name) or (preload and f"{part.said} ({name})"):
            yield line + preload


def _preload(system: System, wall: Stop) -> str:
    """The words of what presses the mass against a wall at the place of the wall; empty where a gap is left."""
    alone = replace(system.potential, contacts=())
    pressed = system.inertia * float(alone.force(wall.position)) * wall.inwards
    unit = "N" if system.has_mass else "m/s^2"
    return f"; preload: the mass is pressed against it with {pressed:.6g} {unit}" if pressed > 0.0 else ""


def _some(terms: list[str], between: str) -> str:
    """The terms of one side of the equation; of many the first ones."""
    left = len(terms) - MOST_TERMS
    return between.join(terms if left <= 1 else [*terms[:MOST_TERMS], f"{'' if between else ' + '}({left} more terms)"])


def _excitations(system: System) -> Iterator[tuple[str, str]]:
    """The symbol of each excitation in the equation, and what it is."""
    letters = "wuyzabcdefghijklnopqrs"
    symbols = itertools.chain(letters, (f"{letter}{n}" for n in itertools.count(2) for letter in letters))
    for name, part in system.named():
        if not isinstance(part, Excitation):
            continue
        if words := part.words(name, partial(_unit, system, part)):
            ground = ", acceleration of the ground" if part.of_ground else ""
            yield f"{part.factor(system.has_mass)}{next(symbols)}(t)", words + ground
        else:
            yield part.term(), ""


def _unit(system: System, part: Part, number: str) -> str:
    unit: str = part.numbers[number].unit_of(system.has_mass and not part.of_ground)
    return in_words(unit)


def _scales(system: System) -> Iterator[str]:
    omega = system.natural_frequency
    if math.isfinite(omega):
        period = 2.0 * math.pi / omega
        yield f"natural frequency {omega:.6g} rad/s, {1.0 / period:.6g} Hz; period {period:.6g} s"
        if (found := system.resonance) > _STIFFENED * omega:
            yield f"resonance with all that has memory: {found:.6g} rad/s, {0.5 * found / math.pi:.6g} Hz"
        yield from filter(None, (part.measure(name, omega) for name, part in system.per_unit_mass.named()))


def _losses(system: System) -> Iterator[str]:
    names = [name for name, part in system.named() if part.dissipates]
    yield f"energy is taken by: {few(names)}" if names else "nothing takes energy"


def _coverage(system: System) -> Iterator[str]:
    answers, statements = solve_all(system)
    yield f"analytical methods with an answer: {', '.join(answers) or 'none'}"
    for statement in dict.fromkeys(statements.values()):
        names = [name for name, said in statements.items() if said == statement]
        yield f"  {few(names)}: {statement}"
