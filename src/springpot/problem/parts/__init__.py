"""The parts that a system is a sum of: frozen dataclasses, each checked when it is made.

A file here holds a family; what a kind of part must say of itself is in `springpot.problem.parts.registration`.
"""

from springpot.problem.parts.circuits import *  # noqa: F403
from springpot.problem.parts.contacts import *  # noqa: F403
from springpot.problem.parts.dampers import *  # noqa: F403
from springpot.problem.parts.envelopes import *  # noqa: F403
from springpot.problem.parts.envelopes import Envelope
from springpot.problem.parts.excitations import *  # noqa: F403
from springpot.problem.parts.hysteresis import *  # noqa: F403
from springpot.problem.parts.masses import *  # noqa: F403
from springpot.problem.parts.records import *  # noqa: F403
from springpot.problem.parts.registration import Part
from springpot.problem.parts.springpots import *  # noqa: F403
from springpot.problem.parts.springs import *  # noqa: F403
from springpot.problem.parts.walls import *  # noqa: F403
from springpot.problem.parts.walls import Restitution

__all__ = sorted(kind.__name__ for each in (Part.kinds, Restitution.known, Envelope.known) for kind in each.values())
