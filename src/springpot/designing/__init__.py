"""From wishes to numbers: how much each number matters, and which numbers to choose."""

from springpot.designing.designs import Curve, Design, Promise, Round, design
from springpot.designing.sensitivities import Sensitivity, sensitivity

__all__ = ["Curve", "Design", "Promise", "Round", "Sensitivity", "design", "sensitivity"]
