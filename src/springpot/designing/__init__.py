"""From wishes to numbers: how much each number matters, and which numbers to choose."""

from springpot.designing.designs import design
from springpot.designing.results import Curve, Design, Promise, Round
from springpot.designing.sensitivities import sensitivity
from springpot.designing.sensitivity_results import Sensitivity

__all__ = ["Curve", "Design", "Promise", "Round", "Sensitivity", "design", "sensitivity"]
