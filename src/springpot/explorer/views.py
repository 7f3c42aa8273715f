"""What the page is told of its problem when it is opened, and of each system that it asks for."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from springpot.explorer.question import Opened
from springpot.explorer.sliders import OSCILLATOR, Size, described_parts, sliders, written
from springpot.machine.faults import listed
from springpot.problem.catalogue import unit_of_result
from springpot.problem.parts import PiezoelectricCircuit
from springpot.problem.system import System

__all__ = ["labels", "opened_script", "sizes"]

_DEVIATIONS = 4.5  # of x and v that are seen at first


def opened_script(opened: Opened | None) -> str:
    """A JavaScript module with what the page was opened with: its sliders and, of a system, its parts.

    Examples
    --------
    >>> opened_script(None)[:45]
    'export const OPENED = {"kind": "oscillator", '
    """
    content: dict[str, Any] = {"kind": "oscillator", "sliders": [one.to_dict() for one in OSCILLATOR]}
    if opened is not None:
        system = opened.system
        size = sizes(system)
        content = {
            "kind": "system",
            "file": opened.title,
            "writable": opened.is_writable,
            "sliders": [one.to_dict() for one in sliders(system, Size(size["frequency"], size["length"]))],
            "parts": described_parts(system),
            "sizes": size,
            "quantities": [*_quantities(system)],
        }
    return f"export const OPENED = {json.dumps(content)};\n"


def sizes(system: System) -> dict[str, float]:
    """How far and how fast the mass moves, roughly: what the picture shows before there are numbers."""
    from springpot.simulation.plan.system_scales import system_scales

    law, potential = system_scales(system).law, system.potential
    spread, speed = math.sqrt(law.variance), math.sqrt(law.temperature)
    low, high = law.mean - _DEVIATIONS * spread, law.mean + _DEVIATIONS * spread
    return {
        "frequency": law.frequency,
        "length": math.sqrt(law.variance + law.mean**2),
        "low": max(low, potential.low),
        "high": min(high, potential.high),
        "fastest": _DEVIATIONS * speed,
    }


def _quantities(system: System) -> Iterator[tuple[str, str]]:
    """The columns of the table of methods."""
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
_FEEDS = ("noise", "impulses", "harmonic", "recorded_excitation")


def labels(system: System, names: list[str]) -> list[tuple[str, str, str]]:
    """Name, words and unit of each number of a run that belongs to parts: powers, impacts of walls, circuits.

    Examples
    --------
    >>> from springpot.problem.parts import Spring, WhiteNoise
    >>> labels(System(Spring(1.0), WhiteNoise(1.0)), ["x_mean", "input_power"])
    [('input_power', 'fed in by all excitations', 'm²/s³')]
    """
    words = _ALL | dict(_of_parts(system)) | _LAST
    if "springpot_power" in names:  # an oscillator's run is per unit mass
        said = words.get("springpot_power", "taken by dampers")
        words["springpot_power"] = f"{said}, per unit mass" if system.mass != 1.0 else said
        names = ["springpot_power", "energy_residual"]
    return [(name, said, _unit(unit_of_result(system, name))) for name, said in words.items() if name in names]


def _of_parts(system: System) -> Iterator[tuple[str, str]]:
    """The words of the numbers of each part, and of the dampers together."""
    described = {part["name"]: part for part in described_parts(system)}
    fed = [name for name, part in described.items() if any(word in part["kind"] for word in _FEEDS)]
    linear = ("springpot", "dashpot", "fractional_maxwell", "maxwell", "piezoelectric_circuit", "polynomial_dashpot")
    dampers = [part["title"] for part in described.values() if part["kind"] in linear]
    if dampers:
        together = f"taken by {listed(dampers)}" + (" together" if len(dampers) > 1 else "")
        yield from (("damping_power", together), ("springpot_power", together))  # the second where it is an oscillator
    for name, part in described.items():
        if name in fed and len(fed) > 1:
            yield f"{name}_power", f"fed in by {part['title']}"
        elif name not in fed and part["kind"] not in linear:
            yield f"{name}_power", f"taken by {part['title']}"
        yield f"{name}_impact_rate", f"impacts on {part['title']}"
        yield f"{name}_impact_speed_mean", f"mean impact speed on {part['title']}"
        yield f"{name}_voltage_mean_square", f"mean square voltage of {part['title']}"


def _unit(unit: str) -> str:
    return "" if unit == "1" else written(unit)
