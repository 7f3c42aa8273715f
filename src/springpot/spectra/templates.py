"""From a template and a period to a system: one part of it is varied until the slowest mode has the period."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import optimize

from springpot.machine.faults import known_word, listed, shown
from springpot.problem.parts import Dashpot, Mass, Spring
from springpot.problem.parts.excitations import Excitation
from springpot.problem.system import System, checked_system
from springpot.theory.normal_modes import free_motion

Template = System | Callable[[float], System] | None

USUAL_DAMPING = 0.05
_FARTHEST = 1e12  # factor on a stiffness


def systems_of(
    template: Template, excitation: Excitation, periods: Sequence[float], damping: float | None,
    varied: str | Sequence[str] | None,
) -> list[System]:  # fmt: skip
    """The system of each period, with the excitation.

    Raises
    ------
    TypeError, ValueError
        If the template is none, or cannot have a period.
    """
    if template is None:
        ratio = damping or 0.0
        return [System(excitation=excitation, **_oscillator(2.0 * math.pi / period, ratio)) for period in periods]
    if not callable(template):
        parts = dict(checked_system(template, "system").stated())
        names = _varied(template, varied)
        return [
            System(**_reached(parts, names, period, damping), **{_free_name(parts): excitation}) for period in periods
        ]
    if damping is not None or varied is not None:
        given = "damping" if damping is not None else "varied"
        raise ValueError(f"{given} must be left out where system is a function of the period, which decides it.")
    found = []
    for period in periods:
        parts = dict(checked_system(template(period), f"system({period:g})").stated())
        found.append(System(**parts, **{_free_name(parts): excitation}))
    return found


def _oscillator(frequency: float, ratio: float) -> dict[str, Any]:
    damper = {"dashpot": Dashpot(2.0 * ratio * frequency)} if ratio > 0.0 else {}
    return {"mass": Mass(1.0), "spring": Spring(frequency**2), **damper}


def _free_name(parts: Mapping[str, Any]) -> str:
    return next(name for name in ("excitation", *(f"excitation_{n}" for n in range(len(parts) + 1)))
                if name not in parts)  # fmt: skip


def _varied(system: System, given: str | Sequence[str] | None) -> list[str]:
    """The names of the parts whose stiffness is varied."""
    linear = [name for name, part in system.named() if isinstance(part, Spring)]
    known = [name for name, part in system.named() if name in linear or part.yields]
    if given is None:
        springs = linear or known
        if len(springs) != 1:
            there = f"there are {listed(springs)}" if springs else "there is no spring"
            raise ValueError(f"varied must name the springs whose stiffness gives the period: {there}.")
        return springs
    if not isinstance(given, str | list | tuple) or not given:
        raise TypeError(f"varied must be the name of a part or a list of them, not {shown(given)}.")
    names = [given] if isinstance(given, str) else [*given]
    return [known_word(name, known, "varied", "must be of the springs and parts that yield,") for name in names]


def _reached(
    parts: Mapping[str, Any], names: Sequence[str], period: float, damping: float | None
) -> dict[str, Any]:  # fmt: skip
    """The parts, with the stiffness of some so that the slowest mode has the period."""
    system = System(**parts)
    at, own = system.coordinates, dict[str, float]()
    for name, part in system.elements.items():
        own[name] = float(part.stiffness_at_once if part.yields else part.static_stiffness)
    rest = at.sum_of({name: 0.0 if name in names else stiff for name, stiff in own.items()})
    moved = at.sum_of({name: stiff if name in names else 0.0 for name, stiff in own.items()})
    wanted = (2.0 * math.pi / period) ** 2

    def off(log_factor: float) -> float:
        squares, _ = free_motion(at.mass, np.asarray(rest + math.exp(log_factor) * moved))
        return float(np.asarray(squares).min()) / wanted - 1.0

    least, most = -math.log(_FARTHEST), math.log(_FARTHEST)
    if off(least) > 0.0 or off(most) < 0.0:
        ends = [2.0 * math.pi / math.sqrt(wanted * max(off(end) + 1.0, 1e-300)) for end in (most, least)]
        raise ValueError(
            f"periods must be ones that {listed(names)} can give, from {ends[0]:.4g} to {ends[1]:.4g} s, and "
            f"{period:g} s is none: other parts decide it."
        )
    factor = math.exp(float(optimize.brentq(off, least, most, xtol=1e-14, rtol=1e-14)))
    found = {**parts, **{name: replace(parts[name], stiffness=factor * parts[name].stiffness) for name in names}}
    if damping is not None and damping > 0.0:
        (first, *more), name = names, "dashpot"
        if more or at.mass.size > 1:
            raise ValueError("damping must be left out of systems of several masses or springs: give it dashpots.")
        coefficient = 2.0 * damping * float(at.mass[0, 0]) * 2.0 * math.pi / period
        while name in found:
            name += "_added"
        found[name] = Dashpot(coefficient, between=parts[first].between)
    return found
