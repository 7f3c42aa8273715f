"""Functions of the user in the kernel of several masses: a chain of laws, one of which is chosen by its number.

Without any the chain is its end alone, so that one compilation serves all such systems.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from springpot.simulation.kernel.lanes import typed
from springpot.simulation.kernel.questions import answers, damp
from springpot.simulation.kernel.restitution import share_left


class Laws(NamedTuple):
    """A law of number 0, and the chain of the others."""

    first: Any
    others: Any


class NoLaw(NamedTuple):
    """The end of a chain."""

    zero: float


def chain_of(laws: Sequence[Any]) -> Any:
    """The chain of some laws, in their order.

    Examples
    --------
    >>> chain_of(["f", "g"])
    Laws(first='f', others=Laws(first='g', others=NoLaw(zero=0.0)))
    """
    return Laws(laws[0], chain_of(laws[1:])) if laws else NoLaw(0.0)


def share_by(laws: Any, number: Any, speed: Any) -> Any:
    """Compiled code only: `springpot.simulation.kernel.restitution.share_left` of one rule."""
    raise NotImplementedError


@answers(share_by, Laws)
def _share_by(laws, number, speed):
    if number == 0:
        return share_left(laws.first, speed)
    return share_by(laws.others, number - 1, speed)


@answers(share_by, NoLaw)
def _whole_share(laws, number, speed):
    return 1.0


def damp_by(
    laws: Any, number: Any, slot: Any, n: Any, x: Any, v: Any, forcing: Any, lane: Any, weight: Any, after: Any
) -> Any:
    """Compiled code only: `springpot.simulation.kernel.questions.damp` of one force."""
    raise NotImplementedError


@answers(damp_by, Laws)
def _damp_by(laws, number, slot, n, x, v, forcing, lane, weight, after):
    if number == 0:
        return damp(laws.first, slot, n, x, v, forcing, lane, weight, after)
    return damp_by(laws.others, number - 1, slot, n, x, v, forcing, lane, weight, after)


@answers(damp_by, NoLaw)
def _damp_nothing(laws, number, slot, n, x, v, forcing, lane, weight, after):
    return typed(0.0, v)
