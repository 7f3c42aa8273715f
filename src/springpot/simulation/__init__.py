"""Monte Carlo of oscillators and systems with memory and walls.

A run goes through the modules in this order: ``run`` takes the arguments; ``settings`` checks and completes them, with
the rates and times of ``scales``; ``adapted`` finds x(0) of a stationary start; ``simulation`` makes the `Simulation`,
for which ``compose`` turns the problem into the kernel's ``parts``; the ``kernel`` advances blocks of paths;
``compose`` converts their sums to the user's units; ``statistics`` computes estimates; ``results`` and ``warnings``
are returned.  With ``rtol``, ``accuracy`` repeats this in rounds, with ``levels``, ``budget`` and ``decision``.
"""

from springpot.problem.units import UNITS
from springpot.simulation.error.budget import CONTROLLED, Budget
from springpot.simulation.result.load import load_run
from springpot.simulation.result.results import Run
from springpot.simulation.run import run, simulate
from springpot.simulation.watch.distributions import Distribution
from springpot.simulation.watch.passage_times import PassageTimes
from springpot.simulation.watch.spectrum import Spectrum

__all__ = [
    "CONTROLLED", "UNITS", "Budget", "Distribution", "PassageTimes", "Run", "Spectrum", "load_run", "run", "simulate",
]  # fmt: skip
