"""Forces of parts and absolute accelerations of masses, which observers see beside displacements."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from springpot.machine.faults import listed
from springpot.problem.parts import (
    Barrier,
    Constant,
    Contact,
    Dashpot,
    FractionalMaxwell,
    Maxwell,
    PiezoelectricCircuit,
    PolynomialDashpot,
    PolynomialSpring,
    Spring,
    Springpot,
    ThermalNoise,
)
from springpot.problem.parts.hysteresis import Yielding
from springpot.problem.parts.registration import Element
from springpot.problem.system import System

__all__ = ["Felt", "felt_in"]

_FELT = (
    Spring, PolynomialSpring, Dashpot, PolynomialDashpot, Springpot, Maxwell, FractionalMaxwell, PiezoelectricCircuit,
    Yielding, Contact,
)  # fmt: skip


@dataclass(frozen=True)
class Felt:
    """A force, or an acceleration, as a sum of the forces of parts.

    Attributes
    ----------
    shares : dict
        Of each part's force in it; of an acceleration over the mass.
    constant : float
        Added to it.
    reason : str
        Why there is none, in words; empty if there is one.
    """

    shares: dict[str, float] = field(default_factory=dict)
    constant: float = 0.0
    reason: str = ""


def felt_in(system: System) -> dict[str, Felt]:
    """The force of each part, of all on the ground, and the absolute acceleration of each mass or point, by name.

    Examples
    --------
    >>> from springpot.problem.parts import Mass, Spring, Springpot, WhiteNoise
    >>> device = System(Mass(2.0), Spring(8.0), Springpot(0.5, 1.0), WhiteNoise(1.0, on="ground"))
    >>> for name, felt in felt_in(device).items():
    ...     print(name, felt.shares)
    spring_force {'spring': 1.0}
    springpot_force {'springpot': 1.0}
    force_on_ground {'spring': 1.0, 'springpot': 1.0}
    acceleration {'spring': -0.5, 'springpot': -0.5}
    """
    at, parts = system.coordinates, dict(system.named())
    single = len(system.points) == 1
    elements = {n: part for n, part in system.elements.items() if not isinstance(part, Barrier)}
    rows = at.elongations
    unseen = [name for name, part in elements.items() if not _is_felt(part)]
    found = {}
    for name in (name for name in elements if name not in unseen):
        alike = [n for n, each in elements.items() if _is_in_memory(each) and np.array_equal(rows[n], rows[name])]
        own = -part.inwards if isinstance(part := elements[name], Contact) else 1.0  # of a stop how hard it is pressed
        reason = _alone(name, alike) or _hot(system, [name])
        found[f"{name}_force"] = Felt({name: own}, reason=reason)
        if count := system.counts.get(name):
            found[f"{name}_force_of_one"] = Felt({name: own / count}, reason=reason)
    below = {n: sign for n, sign in system.grounded.items() if n in elements}
    if below:
        reason = _beside([n for n in below if n in unseen]) or _hot(system, below)
        found["force_on_ground"] = Felt({n: sign for n, sign in below.items() if n not in unseen}, reason=reason)
    pushed = [n for n in at.forces if not parts[n].of_ground]
    loads = [n for n in pushed if not isinstance(parts[n], Constant)]
    if unseen or loads:
        reason = _beside(unseen) or f"{listed(loads)} would be in it: it is seen where the ground moves"
    else:
        reason = _hot(system, elements)
    constant = sum((parts[n].force * at.forces[n] for n in pushed if n not in loads), np.zeros(len(at.names)))
    for point, row in zip(at.points, at.rows, strict=True):
        name = "acceleration" if single else f"{point}_acceleration"
        light = at.accelerations(row)
        shares = {n: -float(light @ rows[n]) for n in elements if n not in unseen}
        found[name] = Felt({n: share for n, share in shares.items() if share}, float(light @ constant), reason)
    return found


def _alone(name: str, alike: list[str]) -> str:
    if name not in alike or len(alike) == 1:
        return ""
    return f"{listed(alike)} have the same ends, and the memory of both is one: only the sum of their forces is known"


def _is_in_memory(part: Element) -> bool:
    return part.remembers and part.is_linear  # a part that yields has a state of its own


def _hot(system: System, names: Iterable[str]) -> str:
    parts = dict(system.named())
    lossy = [name for name in names if parts[name].dissipates]
    if not lossy or not system.of(ThermalNoise):
        return ""
    return f"the matched noise of {listed(lossy)} belongs to it, and has no finite mean square"


def _beside(unseen: list[str]) -> str:
    return f"the force of {listed(unseen)} is not seen" if unseen else ""


def _is_felt(part: Element) -> bool:
    return isinstance(part, _FELT) and (part.is_linear or not isinstance(part, PolynomialDashpot))
