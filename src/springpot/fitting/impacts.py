"""Restitution from the speeds before and after impacts."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from springpot.fitting.likelihood import USUAL, Coordinates, GammaSquares, How, Table, refuse_idle, slopes
from springpot.fitting.part_data import MeasuredImpacts
from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.problem.free_numbers import free_numbers, with_values
from springpot.problem.parts.walls import restitution_at
from springpot.problem.system import System, system_of


class Law:
    """A restitution r(v; numbers), where the numbers that are free are the defaults of its arguments.

    Parameters
    ----------
    function : callable
    free : dict
        The free number of each argument.
    """

    def __init__(self, function: Callable[..., Any], free: dict[str, Free]) -> None:
        self.function, self.arguments = function, free

    @property
    def free(self) -> dict[str, Free]:
        """The free numbers by name."""
        return free_numbers(tuple(self.arguments.values()))

    def restitution(self, speed: Floats, named: dict[str, float]) -> Floats:
        """r at these speeds.

        Raises
        ------
        ValueError
            If the function does not give a positive number for each speed.
        """
        found = np.asarray(
            self.function(speed, **{argument: named[free.name] for argument, free in self.arguments.items()}), float
        )
        found = np.broadcast_to(found, speed.shape)
        if not (np.isfinite(found) & (found > 0.0)).all():
            place = int(np.argmax(~(np.isfinite(found) & (found > 0.0))))
            raise ValueError(
                f"model must give a positive restitution for every speed, not {found[place]:g} at {speed[place]:g} m/s "
                f"for {', '.join(f'{k} = {v:.6g}' for k, v in named.items())}: narrow the bounds."
            )
        return found


def law_of(model: object) -> Law:
    """The restitution that a model states: of its one wall, or a function of the speed.

    Raises
    ------
    TypeError, ValueError
        If it has no such restitution, or something else is free.

    Examples
    --------
    >>> from springpot.problem.free_numbers import free
    >>> from springpot.problem.parts import Barrier
    >>> [*law_of(Barrier(0.0, free("r", 0.7, (0.1, 1.0)))).free]
    ['r']
    """
    if isinstance(model, type):
        raise TypeError(f"model must be a Barrier, a system with one, or a function r(speed, ...), not {shown(model)}.")
    if not callable(model):
        return _law_of_wall(system_of(model, "model"))
    arguments = [*inspect.signature(model).parameters.values()][1:]
    free = {a.name: a.default for a in arguments if isinstance(a.default, Free)}
    if bad := [a.name for a in arguments if a.default is a.empty and a.kind is a.POSITIONAL_OR_KEYWORD]:
        raise ValueError(
            f"model must have defaults for {listed(bad)}, such as {bad[0]}=sp.free({bad[0]!r}, 0.7, (0.1, 1.0))."
        )
    return Law(model, free)


def _law_of_wall(model: System) -> Law:
    walls = [*model.walls.values()]
    if len(walls) != 1:
        raise ValueError(
            f"model must have one wall for data of impacts, not {len(walls)}: give a Barrier, a system with one, or a "
            "function r(speed, ...)."
        )
    wall = walls[0]
    own = free_numbers(wall.restitution)
    refuse_idle([name for name in free_numbers(model) if name not in own], "impacts depend on the restitution only")

    def restitution(speed: Floats, **named: float) -> Floats:
        moved = with_values(wall, named)
        return np.array([restitution_at(moved, each) for each in speed.tolist()])

    return Law(restitution, own)


class ImpactLikelihood(GammaSquares):
    """Speeds after impacts.

    Parameters
    ----------
    law : Law
    data : MeasuredImpacts

    Notes
    -----
    With a known error s of every speed, the squares are those of (v' - r(v) v) / (s sqrt(1 + g^2)) with
    g = d(r v) / dv: the error before the impact counts too, as in the regression of W. E. Deming.  Without one, the
    ratios scatter about r(v) in proportion to it.
    """

    def __init__(self, law: Law, data: MeasuredImpacts, how: How = USUAL) -> None:
        self.law, self.data, self.stop, self.values = law, data, how.stop, data.after
        self.coordinates = Coordinates(tuple(law.free.values()))
        self.known = data.error is not None

    def expected(self, theta: Floats) -> Floats:
        """The speeds after."""
        return self._after(theta, self.data.before)

    def _after(self, theta: Floats, before: Floats) -> Floats:
        return before * self.law.restitution(before, self.coordinates.named(theta))

    def _spread(self, theta: Floats) -> Floats:
        """Standard deviation of what is left."""
        before, step = self.data.before, 1e-5 * self.data.before
        gain = (self._after(theta, before + step) - self._after(theta, before - step)) / (2.0 * step)
        return np.asarray((self.data.error or 1.0) * np.sqrt(1.0 + gain**2))

    def residuals(self, theta: Floats) -> Floats:
        """Signed roots of the deviance."""
        if not self.known:
            return super().residuals(theta)
        return np.asarray((self.values - self.expected(theta)) / self._spread(theta))

    def jacobian(self, theta: Floats) -> Floats:
        """Of the residuals."""
        return slopes(self.residuals, theta, self.coordinates.free) if self.known else super().jacobian(theta)

    def sensitivity(self, theta: Floats) -> Floats:
        """Change of the speeds after, in their standard deviations."""
        found = slopes(self.expected, theta, self.coordinates.free)
        scale = self._spread(theta) if self.known else self.expected(theta)
        return np.asarray(found / scale[:, None])

    def pearson(self, theta: Floats) -> Floats:
        """Differences in standard deviations, or relative ones."""
        return self.residuals(theta) if self.known else super().pearson(theta)

    def constant(self) -> float:
        """Of speeds whose scatter is relative: their logarithms."""
        return 0.0 if self.known else super().constant()

    def table(self, theta: Floats) -> Table:
        """Restitution against the speed before, in its order."""
        order = np.argsort(self.data.before, kind="stable")
        return Table(
            "before", "m/s", self.data.before[order], np.full(self.size, "restitution"),
            (self.values / self.data.before)[order], (self.expected(theta) / self.data.before)[order],
            self.standardized(theta)[order],
        )  # fmt: skip
