"""The memory: the weights of a fractional derivative, direct and as a short sum of exponentials."""

from springpot.memory.exponential_sum import ExponentialSum, exponential_sum, power_law_sum
from springpot.memory.weights import direct

__all__ = ["ExponentialSum", "direct", "exponential_sum", "power_law_sum"]
