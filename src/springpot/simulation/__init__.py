"""Monte Carlo of the impacting fractional oscillator."""

from springpot.simulation.budget import CONTROLLED, Budget
from springpot.simulation.distributions import Distribution
from springpot.simulation.passage_times import PassageTimes
from springpot.simulation.results import Run
from springpot.simulation.run import run, simulate
from springpot.simulation.saved import load_run
from springpot.simulation.spectral import Spectrum
from springpot.units import UNITS

__all__ = [
    "CONTROLLED", "UNITS", "Budget", "Distribution", "PassageTimes", "Run", "Spectrum", "load_run", "run", "simulate",
]  # fmt: skip
