"""A problem in words: its equation with its numbers, its scales, what dissipates, and which methods cover it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

from springpot.machine.faults import few, shown
from springpot.problem.oscillator import Oscillator, as_system
from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    Constant,
    Contact,
    Dashpot,
    Force,
    FractionalMaxwell,
    Friction,
    Harmonic,
    KanaiTajimiNoise,
    Mass,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    PolynomialDashpot,
    RecordedExcitation,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.system import System
from springpot.theory import solve_all

__all__ = ["equation", "explain"]

MOST_TERMS = 12  # of one side of the equation
_STIFFENED = 1.001  # resonance over natural frequency from which it is said


def explain(problem: System | Oscillator) -> str:
    """The equation of a problem with its numbers and units, its scales, what dissipates, and which methods cover it.

    Parameters
    ----------
    problem : System or Oscillator

    Returns
    -------
    str
        Several lines.  The methods are asked, which takes up to some seconds.

    Raises
    ------
    TypeError
        If it is neither.

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
    if isinstance(problem, Oscillator):
        problem = as_system(problem)
    if not isinstance(problem, System):
        raise TypeError(f"problem must be a System or an Oscillator, not {shown(problem)}.")
    return "\n".join([*equation(problem), *_scales(problem), *_losses(problem), *_coverage(problem)])


def equation(system: System) -> Iterator[str]:
    """The equation of motion with its numbers, and a line for each excitation, wall and circuit."""
    inertia = f"{system.mass:.6g} x''" if system.of(Mass) else "x''"
    left = _some([part.term() for part in system.parts if hasattr(part, "term")], "")
    excitations = [*_excitations(system)]
    right = _some([symbol for symbol, _ in excitations], " + ").replace("+ -", "- ") or "0"
    yield f"{inertia}{left} = {right}"
    yield "in SI units: x in m, t in s, forces in N" if system.of(Mass) else "per unit mass: x in m, t in s"
    for symbol, words in excitations:
        if words:
            yield f"{symbol.removeprefix('-').removeprefix('m ').removeprefix('x ')}: {words}"
    for name, part in system.named():
        if isinstance(part, Barrier):
            relation = ">=" if part.side == "above" else "<="
            yield f"wall ({name}): x {relation} {part.position:.6g} m, restitution {part.law()}{_preload(system, part)}"
        elif isinstance(part, Contact) and (preload := _preload(system, part)):
            yield f"soft contact ({name}){preload}"
        elif isinstance(part, PiezoelectricCircuit):
            yield (
                f"V ({name}): {part.capacitance:.6g} V' + V / {part.resistance:.6g} = {part.coupling:.6g} x', "
                f"R Cp = {part.time:.6g} s"
            )


def _preload(system: System, wall: Barrier | Contact) -> str:
    """The words of what presses the mass against a wall at the place of the wall; empty where a gap is left."""
    alone = replace(system.potential, contacts=())
    pressed = system.mass * float(alone.force(wall.position)) * (1.0 if wall.side == "above" else -1.0)
    unit = "N" if system.of(Mass) else "m/s^2"
    return f"; preload: the mass is pressed against it with {pressed:.6g} {unit}" if pressed > 0.0 else ""


def _some(terms: list[str], between: str) -> str:
    """The terms of one side of the equation; of many the first ones."""
    left = len(terms) - MOST_TERMS
    return between.join(terms if left <= 1 else [*terms[:MOST_TERMS], f"{'' if between else ' + '}({left} more terms)"])


def _excitations(system: System) -> Iterator[tuple[str, str]]:
    """The symbol of each excitation in the equation, and what it is."""
    letters = "wuyzabcdefghijklnopqrs"
    symbols = itertools.chain(letters, (f"{letter}{n}" for n in itertools.count(2) for letter in letters))
    si = bool(system.of(Mass))
    for name, part in system.named():
        if isinstance(part, Constant):
            yield f"{part.force:.6g}", ""
            continue
        if isinstance(part, Harmonic):
            unit = "m/s^2" if part.on == "ground" or not si else "N"
            words = f"{part.amplitude:.6g} {unit} cos({part.frequency:.6g} t + a random phase) ({name})"
        elif isinstance(part, WhiteNoise):
            words = f"white noise ({name}), intensity {part.intensity:.6g} {_unit(part.on, si, ' s', 'm^2/s^3')}"
        elif isinstance(part, ColoredNoise):
            variance = f"{part.variance:.6g} {_unit(part.on, si, '', 'm^2/s^4')}"
            words = f"colored noise ({name}), variance {variance}, correlation time {part.correlation_time:.6g} s"
        elif isinstance(part, KanaiTajimiNoise):
            intensity = f"{part.intensity:.6g} {_unit(part.on, si, ' s', 'm^2/s^3')}"
            words = (
                f"filtered noise ({name}), filter at {part.frequency:.6g} rad/s with damping ratio {part.damping:.6g}, "
                f"intensity {intensity}"
            )
        elif isinstance(part, PoissonImpulses):
            mean_square = f"{part.mean_square:.6g} {_unit(part.on, si, ' s^2', 'm^2/s^2')}"
            words = f"impulses at random times ({name}), {part.rate:.6g} per second, mean square {mean_square}"
        elif isinstance(part, ParametricNoise):
            words = f"white noise ({name}) that multiplies x, intensity {part.intensity:.6g}"
        elif isinstance(part, RecordedExcitation):
            unit = "m/s^2" if part.on == "ground" or not si else "N"
            rms = math.sqrt(part.mean_square)
            words = f"a record of {part.duration:.6g} s ({name}), root mean square {rms:.6g} {unit}"
        elif isinstance(part, Force):
            words = f"a function of t, x and v ({name})"
        elif isinstance(part, ThermalNoise):
            unit = "J" if si else "m^2/s^2"
            words = f"noise of every dissipator ({name}) at kT = {part.temperature:.6g} {unit}"
        else:
            continue
        symbol = f"{next(symbols)}(t)"
        ground = getattr(part, "on", "mass") == "ground"
        factor = ("-m " if si else "-") if ground else "x " if isinstance(part, ParametricNoise) else ""
        yield factor + symbol, words + (", acceleration of the ground" if ground else "")


def _unit(on: str, si: bool, time: str, per_mass: str) -> str:
    return f"N^2{time}" if si and on == "mass" else per_mass


def _scales(system: System) -> Iterator[str]:
    omega = system.natural_frequency
    if math.isfinite(omega):
        period = 2.0 * math.pi / omega
        yield f"natural frequency {omega:.6g} rad/s, {1.0 / period:.6g} Hz; period {period:.6g} s"
        if (found := system.resonance) > _STIFFENED * omega:
            yield f"resonance with all that has memory: {found:.6g} rad/s, {0.5 * found / math.pi:.6g} Hz"
    for name, part in system.per_unit_mass.named():
        if isinstance(part, Springpot) and math.isfinite(omega):
            strength = part.coefficient * omega ** (part.order - 2.0)
            yield f"strength of {name}: c = C Omega^(order - 2) / m = {strength:.6g}"
        elif isinstance(part, Dashpot) and math.isfinite(omega):
            yield f"damping ratio of {name}: {part.coefficient / (2.0 * omega):.6g}"


def _losses(system: System) -> Iterator[str]:
    names = [name for name, part in system.named() if _dissipates(part)]
    yield f"energy is taken by: {few(names)}" if names else "nothing takes energy"


def _dissipates(part: object) -> bool:
    match part:
        case Springpot():
            return part.dissipates
        case Barrier():
            return not part.is_elastic
        case Contact(dissipation=dissipation):
            return dissipation > 0.0
        case Dashpot(coefficient=coefficient):
            return coefficient > 0.0
        case _:
            return isinstance(
                part, FractionalMaxwell | Maxwell | PiezoelectricCircuit | PolynomialDashpot | VanDerPol | Friction
            )


def _coverage(system: System) -> Iterator[str]:
    answers, statements = solve_all(system)
    yield f"analytical methods with an answer: {', '.join(answers) or 'none'}"
    for statement in dict.fromkeys(statements.values()):
        names = [name for name, said in statements.items() if said == statement]
        yield f"  {few(names)}: {statement}"
