"""Walls in the kernel: none, a rigid one below the motion, one on either side, soft contacts before either.

The module's text of `springpot.simulation.kernel.questions` says what the kernel asks a wall.
"""

from __future__ import annotations

from springpot.simulation.kernel.no_wall import NoWall
from springpot.simulation.kernel.restitution import Fixed
from springpot.simulation.kernel.rigid_wall import Rigid
from springpot.simulation.kernel.soft_contacts import Soft
from springpot.simulation.kernel.two_walls import Pair

_TAKEN = "loss", "momentum"  # in impacts
_RESTING = "rest momentum", "rest loss"
_NEAR = 4.0


def is_near(place: float, spread: float) -> bool:
    """Whether vector code may find impacts on a wall at ``place``, which it does in single precision.

    Not if the motion, of the standard deviation ``spread``, is small beside the wall's distance from the spring's rest.

    Examples
    --------
    >>> is_near(0.0, 0.0), is_near(-3.0, 1.0), is_near(1.0, 0.01)
    (True, True, False)
    """
    return abs(place) <= _NEAR * spread


def sums_of(wall: NoWall | Rigid | Pair | Soft) -> tuple[str, ...]:
    """The names of the sums that a wall keeps, in their order.

    Examples
    --------
    >>> sums_of(Rigid(0.0, Fixed(0.5)))
    ('lower rest momentum', 'lower rest loss')
    >>> sums_of(Pair(0.0, 1.0, Fixed(0.5), Fixed(0.5)))[3:5]
    ('lower rest momentum', 'upper rest momentum')
    """
    each = "impacts", "speeds", "squares"
    match wall:
        case Rigid():
            of_rule = () if isinstance(wall.rule, Fixed) else _TAKEN
            return tuple(f"lower {name}" for name in (*_RESTING, *of_rule))
        case Pair():
            rules = ("lower", wall.low_rule), ("upper", wall.high_rule)
            own = (f"{where} {name}" for where, rule in rules if not isinstance(rule, Fixed) for name in _TAKEN)
            resting = (f"{where} {name}" for name in _RESTING for where in ("lower", "upper"))
            return *(f"upper {name}" for name in each), *resting, *own
        case Soft():
            own = (f"contact {n} {name}" for n in range(wall.contacts.size // 5) for name in (*each, *_TAKEN))
            return *sums_of(wall.rigid), "contacts' work", "contacts' time", "contacts' depth", *own
        case _:
            return ()
