"""What is 0 by symmetry: mean elongations that no force with a mean moves, and displacements that no force moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System

_ROUNDED = 1e-9  # of the sum of the sizes of the terms


@dataclass(frozen=True, eq=False)
class Symmetry:
    """Of a system.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> rows = {"x": np.ones(1)}
    >>> Symmetry(System(Spring(1.0))).zero_means(rows), Symmetry(System(Spring(1.0), Barrier(-1.0))).zero_means(rows)
    (('x_mean',), ())
    """

    system: System

    def zero_means(self, displacements: Mapping[str, Floats]) -> tuple[str, ...]:
        """The means, of displacements by how the names of their results begin, that are 0."""
        return tuple(f"{begin}_mean" for begin, row in displacements.items() if not self.has_mean(row))

    def still(self, displacements: Mapping[str, Floats]) -> list[str]:
        """Those that nothing moves at all."""
        at, parts = self.system.coordinates, dict(self.system.named())
        moving = [*at.forces.values()]
        moving += [row for name, row in at.elongations.items() if not parts[name].is_linear]
        ties = np.abs(at.mass) + sum(np.outer(*2 * [np.abs(row)]) for row in at.elongations.values())
        reached = np.abs(np.array([np.zeros(len(at.names)), *moving])).sum(0)
        for _ in at.names:
            reached = (ties @ reached > 0.0).astype(float)
        return [begin for begin, row in displacements.items() if not (np.abs(row) @ reached).any()]

    @property
    def keeps_mean(self) -> bool:
        """Whether a part whose memory fades like a power of time sees a mean elongation."""
        rows = self.system.coordinates.elongations
        return any(self.has_mean(rows[name]) for name, part in self.system.named() if part.creeps)

    def has_mean(self, row: Floats) -> bool:
        """Whether the mean of an elongation is not 0 by symmetry."""
        moved = self._moved
        return moved is None or not (np.abs(row @ moved) <= _ROUNDED * (np.abs(row) @ np.abs(moved))).all()

    @cached_property
    def _moved(self) -> Floats | None:
        """How each force that may have a mean displaces the coordinates, in columns; None if nothing holds them."""
        at, parts = self.system.coordinates, dict(self.system.named())
        rows = {**at.forces, **at.elongations}
        stops = {_inwards(rows[name], part): rows[name] for name, part in self.system.stops.items()}
        pushes = [row for (into, *law), row in stops.items() if (tuple(-n for n in into), *law) not in stops]
        pushes += [rows[name] for name, part in parts.items() if not (part.is_odd or name in self.system.stops)]
        if pushes:  # what is nonlinear may have a mean force where others have
            pushes += [rows[name] for name, part in parts.items() if not part.is_linear]
        stiffness = self.system.stiffness_matrix
        values = np.linalg.eigvalsh(stiffness)
        if pushes and not values[0] > _ROUNDED * values[-1]:
            return None
        return np.asarray(np.linalg.solve(stiffness, np.array(pushes).T) if pushes else np.zeros((len(values), 1)))


def _inwards(row: Floats, stop: Stop) -> tuple[Any, ...]:
    """A wall or contact by the way in which it pushes, its place along that way, and its law."""
    return (
        tuple((stop.inwards * row).tolist()),
        stop.inwards * stop.position,
        replace(stop, position=0.0, free_side="above", between=None),  # type: ignore[call-arg]
    )
