"""What the page is sent: of its problem when it is opened, and of each system that it asks for."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from springpot.explorer.examples import examples
from springpot.explorer.excitation import charts_of_excitation, table_of
from springpot.explorer.question import Opened, papers_of
from springpot.explorer.requests import followed, offered
from springpot.explorer.sliders import described_parts, sliders, titled, written
from springpot.machine.faults import listed
from springpot.problem.catalogue import stated_in, unit_of_result
from springpot.problem.system import System
from springpot.theory.result import names_of_results

_DEVIATIONS = 4.5  # of x and v that are seen at first


def opened_script(opened: Opened, others: Sequence[tuple[str, str]] = (), place: str | None = "") -> str:
    """A script with what the page shows: its parts, their sliders, and examples.

    Parameters
    ----------
    opened : Opened
    others : list of tuple of str
        Places and names of other systems to choose from.
    place : str or None
        Where this one is; None if nothing was found where it should be.

    Examples
    --------
    >>> opened_script(Opened())[:41]
    'globalThis.OPENED = {"file": "", "place":'
    """
    system = opened.nominal
    seen = _seen(system)
    content = {
        "file": opened.file,
        "place": place,
        "systems": others,
        "writable": not system.with_functions,
        "heavy": system.has_mass,
        "sliders": [asdict(one) for one in sliders(opened.system, seen["sizes"])],
        "parts": described_parts(system),
        **seen,
        "points": [
            {"name": name, "title": titled(name), "massive": number < len(system.coordinates.masses)}
            for number, name in enumerate(system.points)
        ],
        "densities": [*densities_of(system)],
        "examples": [*examples(system, opened.file)],
        "offered": offered(system),
        "table": table_of(system, seen["sizes"]["frequency"]),
    }
    return f"globalThis.OPENED = {json.dumps(content)};\n"


def view_of(system: System) -> dict[str, Any]:
    """The equations of a system, how far it moves, the columns of its tables, and what the paper's problem adds."""
    from springpot.evidence.explanation import equation

    lines, masses = [*equation(system)], system.coordinates.names
    seen = _seen(system)
    seen["excitation"] = [*charts_of_excitation(system, seen["sizes"]["frequency"])]
    if len(masses) > 1:
        title = f"{len(masses)} masses: {listed([*map(titled, masses)])}"
        return {"equation": [title, *lines[len(masses) :]], "equations": lines[: len(masses)], **seen}
    return {"equation": lines, "equations": [], **seen}


def _seen(system: System) -> dict[str, Any]:
    return {
        "sizes": sizes(system),
        "paper": paper_view(system),
        "followed": [*followed(system)],
        "groups": [*_groups(system)],
    }


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


def sizes(system: System) -> dict[str, Any]:
    """How far and how fast the masses move, roughly: what the pictures show before there are numbers.

    ``of`` has the places and speeds of each of what the page can follow.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, WhiteNoise
    >>> ends = ("ground", "a"), ("a", "b")
    >>> pair = System(Mass(1.0, at="a"), Mass(1.0, at="b"), *(Spring(1.0, between=pair) for pair in ends))
    >>> len(sizes(pair)["of"])  # of a, b, and b less a
    3
    """
    from springpot.simulation.plan.motions import motion_of

    motion = motion_of(system)
    found = [(signal, *motion.size_of(signal)) for signal in motion.signals if "x" in signal.names]
    return {
        "frequency": float(motion.scales.frequency),
        "length": max(math.hypot(mean, spread) for _, mean, spread, _ in found),
        "of": [
            {
                "low": max(mean - _DEVIATIONS * spread, signal.low),
                "high": min(mean + _DEVIATIONS * spread, signal.high),
                "fastest": _DEVIATIONS * speed,
            }
            for signal, mean, spread, speed in found
        ],
    }


def densities_of(system: System) -> Iterator[str]:
    """The quantities whose densities are drawn, in the order in which they are sent."""
    names = "x", "v", "amplitude", "impact_speed", *(f"{point}_x" for point in system.points)
    return (name for name in names if stated_in(system, [f"{name}_density"]))


def _groups(system: System) -> Iterator[dict[str, Any]]:
    """The tables of results: what stands in front of the names of a row, and the columns that follow it.

    Of one mass there is one, with a row of all methods; of several one of the masses, and one of what is between them.
    """
    rows = [(one["name"], one["title"], one["pair"]) for one in followed(system)]
    for pair, head, columns in (
        (False, "mass", [*_quantities(system)]),
        (True, "between", [("rms", "elongation rms"), ("mean", "mean elongation")]),
    ):
        own = [(name, title) for name, title, is_pair in rows if is_pair == pair]
        if own:
            yield {"head": head if len(rows) > 1 else "method", "rows": own, "columns": columns}


def _quantities(system: System) -> Iterator[tuple[str, str]]:
    """The columns of the table of methods: of walls and circuits those that belong to a row."""
    own, known = next(iter(system.coordinates.beginnings)), names_of_results(system)
    yield from (("amplitude_mean_square", "⟨A²⟩") for _ in papers_of(system))
    yield from (("x_rms", "x rms"), ("x_mean", "⟨x⟩"), ("v_mean_square", "⟨v²⟩"))
    walls = [*system.stops]
    columns = [("impact_rate", "impact rate"), ("impact_speed_mean", "impact speed")] if walls else []
    columns += [(f"{name}_impact_rate", f"rate, {titled(name)}") for name in walls if len(walls) > 1]
    columns += [("harvested_power", "harvested")]
    yield from (column for column in columns if f"{own}{column[0]}" in known)


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
    titles = {name: titled(name) for name in system.names}
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
        yield f"{name}_current_mean_square", f"mean square current of {titles[name]}"
        yield f"{name}_current_of_one_mean_square", f"mean square current of one {titles[name]}"
