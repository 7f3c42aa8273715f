"""Random vibration of oscillators with power-law memory that strike a wall."""

from importlib.metadata import version

from springpot import theory
from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.simulation import simulate

__all__ = ["Barrier", "Oscillator", "Springpot", "WhiteNoise", "simulate", "theory"]
__version__ = version("springpot")
