"""Forces of parts and absolute accelerations of masses, which theory and observers see beside displacements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import listed
from springpot.problem.coordinates import product_of
from springpot.problem.messages import Message, say
from springpot.problem.parts.registration import Element
from springpot.problem.system import System


@dataclass(frozen=True)
class Output:
    """A force, or an acceleration, as a sum of the forces of parts.

    Attributes
    ----------
    shares : dict
        Of each part's force in it; of an acceleration over the mass.
    constant : float
        Added to it.
    reason : str
        Why a simulation cannot see it, in words; empty if it can.
    row : ndarray or None
        Of an acceleration, that of its point.
    unseen : tuple of str
        Parts whose forces are in it, too, but have no value at every time.
    """

    shares: dict[str, float] = field(default_factory=dict)
    constant: float = 0.0
    reason: str = ""
    row: Floats | None = None
    unseen: tuple[str, ...] = ()


def outputs_of(system: System) -> dict[str, Output]:
    """The force of each part and group, of all on the ground, and the acceleration of each mass or point, by name.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, Springpot, WhiteNoise
    >>> device = System(Mass(2.0), Spring(8.0), Springpot(0.5, 1.0), WhiteNoise(1.0, on="ground"))
    >>> for name, output in outputs_of(device).items():
    ...     print(name, output.shares)
    spring_force {'spring': 1.0}
    springpot_force {'springpot': 1.0}
    force_on_ground {'spring': 1.0, 'springpot': 1.0}
    acceleration {'spring': -0.5, 'springpot': -0.5}
    """
    at, parts = system.coordinates, dict(system.named())
    single = len(system.points) == 1
    elements = {n: part for n, part in system.elements.items() if n not in system.walls}
    rows = at.elongations
    unseen = [name for name, part in elements.items() if not part.is_seen]
    found = {}
    for name in (name for name in elements if name not in unseen):
        alike = _with_one_memory(name, elements, rows)
        own = -stop.inwards if (stop := system.contacts.get(name)) else 1.0  # of a stop how hard it is pressed
        reason = _alone(name, alike) or _hot(system, [name])
        found[f"{name}_force"] = Output({name: own}, reason=reason)
        if count := system.counts.get(name):
            found[f"{name}_force_of_one"] = Output({name: own / count}, reason=reason)
    for group, names in system.groups.items():
        beside = tuple(n for n in names if n not in elements or n in unseen)
        reason = _beside(beside) or _apart(names, elements, rows) or _hot(system, names)
        whole = Output({n: 1.0 for n in names if n not in beside}, reason=reason, unseen=beside)
        found[f"{group}_force"] = whole
        if count := system.counts.get(group):
            found[f"{group}_force_of_one"] = replace(whole, shares=dict.fromkeys(whole.shares, 1.0 / count))
    below = {n: sign for n, sign in system.grounded.items() if n in elements}
    if below:
        beside = tuple(n for n in below if n in unseen)
        shares = {n: sign for n, sign in below.items() if n not in unseen}
        found["force_on_ground"] = Output(shares, reason=_beside(beside) or _hot(system, below), unseen=beside)
    pushed = {n: row for n, row in at.forces.items() if not parts[n].of_ground}
    for point, row in zip(at.points, at.rows, strict=True):
        name = "acceleration" if single else f"{point}_acceleration"
        light = at.accelerations(row)
        loads = {n: share for n, own in pushed.items() if (share := product_of(light, own))}
        constant = sum(share * parts[n].force for n, share in loads.items() if n in system.constants)
        loads = {n: share for n, share in loads.items() if n not in system.constants}
        shares = {n: share for n in elements if n not in unseen and (share := -product_of(light, rows[n]))}
        reason = _beside(unseen) or _pushed(system, loads) or _hot(system, elements)
        found[name] = Output(shares | loads, constant, reason, row)
    return found


def output_squares(system: System) -> dict[str, str]:
    """Mean squares of forces and accelerations that a run can have: the names of these by theirs.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Mass, Spring, WhiteNoise
    >>> system = System(Mass(2.0), Spring(8.0), mount=Dashpot(1.0), shaking=WhiteNoise(1.0, on="ground"))
    >>> output_squares(system)["mount_force_mean_square"]
    'mount_force'
    """
    return {f"{name}_mean_square": name for name, output in outputs_of(system).items() if not output.reason}


def about_shocks(system: System, names: Iterable[str], values: Mapping[str, float]) -> list[Message]:
    """Of accelerations, and of the force on the ground, whose values are those between the impacts on rigid walls.

    Parameters
    ----------
    system : System
    names : iterable of str
        Of forces and accelerations that are seen.
    values : dict
        Results by name: a wall without impacts is not named.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Dashpot, Mass, Spring, WhiteNoise
    >>> box = System(Mass(1.0), Spring(1.0), Dashpot(0.1), Barrier(-1.0), WhiteNoise(0.1, on="ground"))
    >>> [message.name for message in about_shocks(box, ["spring_force", "acceleration"], {"impact_rate": 0.1})]
    ['shocks_left_out']
    """
    at, outputs, found = system.coordinates, outputs_of(system), []
    walls = {
        name: at.elongations[name] for name in system.walls
        if values.get(f"{name}_impact_rate", values.get("impact_rate")) != 0.0
    }  # fmt: skip
    for name in names:
        if name == "force_on_ground":
            struck = [wall for wall in walls if wall in system.grounded]
        elif (row := outputs[name].row if name in outputs else None) is not None:
            struck = [wall for wall, elongation in walls.items() if product_of(at.accelerations(row), elongation)]
        else:
            continue
        if struck:
            found.append(say("shocks_left_out", name=name, walls=listed(struck)))
    return found


def _pushed(system: System, loads: Iterable[str]) -> str:
    """Why forces on a mass leave its acceleration without a value."""
    parts, forces = system.excitations, system.coordinates.forces
    if rough := [name for name in loads if parts[name].noise in ("white", "impulses")]:
        return f"{listed(rough)} would be in it, which has no finite mean square: it is seen where the ground moves"
    white = [name for name in forces if parts[name].noise == "white"]
    if white and len(system.points) == 1 and any(parts[name].noise for name in loads):
        return f"{listed([*loads, *white])} are simulated as one force, of which only the sum is known"
    return ""


def _alone(name: str, alike: list[str]) -> str:
    if name not in alike or len(alike) == 1:
        return ""
    return f"{listed(alike)} have the same ends, and the memory of both is one: only the sum of their forces is known"


def _apart(names: Sequence[str], elements: Mapping[str, Element], rows: Mapping[str, Floats]) -> str:
    """Why the forces of a group are not known: others have a memory in common with some of it."""
    shared = [n for name in names if name in elements for n in _with_one_memory(name, elements, rows)]
    kept = [name for name in names if name in shared]
    return _alone(kept[0], [*dict.fromkeys(shared)]) if kept and {*shared} - {*names} else ""


def _with_one_memory(name: str, elements: Mapping[str, Element], rows: Mapping[str, Floats]) -> list[str]:
    """The parts with the ends of one of them whose memory is kept as one."""
    kept = [n for n, part in elements.items() if part.remembers and not part.yields]  # what yields has its own state
    return [n for n in kept if np.array_equal(rows[n], rows[name])]


def _hot(system: System, names: Iterable[str]) -> str:
    parts = dict(system.named())
    lossy = [name for name in names if parts[name].dissipates]
    if not lossy or not system.thermal:
        return ""
    return f"the matched noise of {listed(lossy)} belongs to it, and has no finite mean square"


def _beside(unseen: Sequence[str]) -> str:
    return f"the force of {listed(unseen)} is not seen" if unseen else ""
