"""Answers with dice: Monte Carlo of the impacting fractional oscillator."""

from springpot.simulation.run import Run, run, simulate
from springpot.simulation.statistics import UNITS

__all__ = ["UNITS", "Run", "run", "simulate"]
