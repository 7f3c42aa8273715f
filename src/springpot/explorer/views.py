"""What the page is sent: of its problem when it is opened, and of each system that it asks for."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from springpot.explorer.examples import examples
from springpot.explorer.question import Opened, papers_of
from springpot.explorer.sliders import described_parts, sliders, written
from springpot.machine.faults import listed
from springpot.problem.catalogue import unit_of_result
from springpot.problem.parts import PiezoelectricCircuit
from springpot.problem.system import System

__all__ = ["labels", "opened_script", "paper_view", "sizes", "view_of"]

_DEVIATIONS = 4.5  # of x and v that are seen at first


def opened_script(opened: Opened) -> str:
    """A JavaScript module with what the page was opened with: its parts, their sliders, and examples.

    Examples
    --------
    >>> opened_script(Opened())[:42]
    'export const OPENED = {"file": "", "writab'
    """
    system = opened.system
    seen = _seen(system)
    content = {
        "file": opened.file,
        "writable": not system.with_functions,
        "heavy": system.has_mass,
        "sliders": [asdict(one) for one in sliders(system, seen["sizes"])],
        "parts": described_parts(system),
        **seen,
        "examples": [*examples(system, opened.file)],
    }
    return f"export const OPENED = {json.dumps(content)};\n"


def view_of(system: System) -> dict[str, Any]:
    """The equation of a system, how far it moves, the columns of its table, and what the paper's problem adds."""
    from springpot.evidence.explanation import equation

    return {"equation": [*equation(system)], **_seen(system)}


def _seen(system: System) -> dict[str, Any]:
    return {"sizes": sizes(system), "paper": paper_view(system), "quantities": [*_quantities(system)]}


def paper_view(system: System) -> dict[str, Any] | None:
    """The dimensionless numbers of the paper's problem, and the scales that make them so; None of any other system.

    Examples
    --------
    >>> paper_view(Opened().system)["strength"]
    1.0
    """
    for paper in papers_of(system):
        return {
            "order": paper.springpot.order,
            "strength": paper.dimensionless_coefficient,
            "wall": None if paper.barrier is None else paper.dimensionless_position,
            "restitution": None if paper.barrier is None else paper.restitution,
            "frequency": paper.natural_frequency,
            "length": paper.length_scale,
            "mass": system.inertia,
        }
    return None


def sizes(system: System) -> dict[str, float]:
    """How far and how fast the mass moves, roughly: what the picture shows before there are numbers."""
    from springpot.simulation.plan.motions import motion_of

    motion, potential = motion_of(system), system.potential
    law = motion.law
    spread, speed = math.sqrt(law.variance), math.sqrt(law.temperature)
    low, high = law.mean - _DEVIATIONS * spread, law.mean + _DEVIATIONS * spread
    return {
        "frequency": motion.scales.frequency,
        "length": math.sqrt(law.variance + law.mean**2),
        "low": max(low, potential.low),
        "high": min(high, potential.high),
        "fastest": _DEVIATIONS * speed,
    }


def _quantities(system: System) -> Iterator[tuple[str, str]]:
    """The columns of the table of methods."""
    yield from (("amplitude_mean_square", "⟨A²⟩") for _ in papers_of(system))
    yield from (("x_rms", "x rms"), ("x_mean", "⟨x⟩"), ("v_mean_square", "⟨v²⟩"))
    walls = [*system.stops]
    if walls:
        yield from (("impact_rate", "impact rate"), ("impact_speed_mean", "impact speed"))
    if len(walls) > 1:
        yield from ((f"{name}_impact_rate", f"rate, {name.replace('_', ' ')}") for name in walls)
    if system.of(PiezoelectricCircuit):
        yield "harvested_power", "harvested"


_ALL = {"input_power": "fed in by all excitations", "harvested_power": "delivered by the circuits"}
_LAST = {
    "contact_share": "share of time in contact",
    "contact_penetration": "deepest penetration, mean over the paths",
    "energy_residual": "energy balance: share of the power that is missing",
}


def labels(system: System, names: list[str]) -> list[tuple[str, str, str]]:
    """Name, words and unit of each number of a run that belongs to parts: powers, impacts of walls, circuits.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, WhiteNoise
    >>> labels(System(Spring(1.0), WhiteNoise(1.0)), ["x_mean", "input_power"])
    [('input_power', 'fed in by all excitations', 'm²/s³')]
    """
    words = _ALL | dict(_of_parts(system)) | _LAST
    return [(name, said, written(unit_of_result(system, name))) for name, said in words.items() if name in names]


def _of_parts(system: System) -> Iterator[tuple[str, str]]:
    """The words of the numbers of each part, and of the dampers together."""
    titles = {name: name.replace("_", " ") for name in system.names}
    dampers = [titles[name] for name, part in system.named() if "damping" in part.powers]
    fed = [name for name, part in system.named() if {"fed", "input"} & {*part.powers}]
    if dampers:
        yield "damping_power", f"taken by {listed(dampers)}" + (" together" if len(dampers) > 1 else "")
    for name, part in system.named():
        if name not in fed or len(fed) > 1:
            does = "fed in by" if name in fed else "work of" if "work" in part.powers else "taken by"
            yield f"{name}_power", f"{does} {titles[name]}"
        yield f"{name}_impact_rate", f"impacts on {titles[name]}"
        yield f"{name}_impact_speed_mean", f"mean impact speed on {titles[name]}"
        yield f"{name}_voltage_mean_square", f"mean square voltage of {titles[name]}"
