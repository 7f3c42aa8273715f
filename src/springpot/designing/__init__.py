"""From wishes to numbers: how much each number matters, and which numbers to choose."""

from springpot.designing.sensitivities import Sensitivity, sensitivity

__all__ = ["Sensitivity", "sensitivity"]
