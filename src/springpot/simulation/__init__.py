"""Monte Carlo of systems with memory and walls, in rooms, in the order in which data passes.

``simulate`` takes the arguments; ``plan/`` checks and completes them, with the rates and times of the motion;
``lowering/`` turns the plan into the arguments of the compiled ``kernel/``; ``paths/`` advances blocks of paths, which
``watch/`` observes; ``estimate/`` turns their sums into values and errors, with the stationary start; ``result/`` holds
the run and its warnings.  With ``rtol``, ``error/`` repeats this in rounds.  ``exceedance`` of ``rare/`` splits paths.

The names below are loaded at first use, so that commands start fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.machine.installed import loaded_later

if TYPE_CHECKING:
    from springpot.simulation.error.budget import Budget
    from springpot.simulation.monte_carlo import simulate
    from springpot.simulation.rare.exceedance import Exceedance
    from springpot.simulation.rare.levels import ExceedanceLevel
    from springpot.simulation.rare.search import ExceedanceCurve, ProbabilityWithin
    from springpot.simulation.result.load import load_run
    from springpot.simulation.result.results import Estimate, Run
    from springpot.simulation.watch.distributions import Distribution
    from springpot.simulation.watch.passage_rates import Bounded, PassageRate
    from springpot.simulation.watch.passage_times import PassagesOfLevels, PassageTimes
    from springpot.simulation.watch.profiles import Profile
    from springpot.simulation.watch.spectrum import Spectrum

__all__ = [
    "Bounded", "Budget", "Distribution", "Estimate", "Exceedance", "ExceedanceCurve", "ExceedanceLevel", "PassageRate",
    "PassageTimes", "PassagesOfLevels", "ProbabilityWithin", "Profile", "Run", "Spectrum", "load_run", "simulate",
]  # fmt: skip
_PLACES = {
    "error.budget": ("Budget",),
    "rare.exceedance": ("Exceedance",),
    "rare.levels": ("ExceedanceLevel",),
    "rare.search": ("ExceedanceCurve", "ProbabilityWithin"),
    "result.load": ("load_run",),
    "result.results": ("Estimate", "Run"),
    "monte_carlo": ("simulate",),
    "watch.distributions": ("Distribution",),
    "watch.passage_rates": ("Bounded", "PassageRate"),
    "watch.passage_times": ("PassageTimes", "PassagesOfLevels"),
    "watch.profiles": ("Profile",),
    "watch.spectrum": ("Spectrum",),
}
__getattr__ = loaded_later(__name__, _PLACES)
