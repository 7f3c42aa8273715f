"""Analytical methods: functions that take an oscillator and return a small frozen result.

The names below are loaded when they are first used: the list of methods is then there at once.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from springpot.theory.methods.averaging import Averaging, averaging
    from springpot.theory.methods.closure.method import Closure, closure
    from springpot.theory.methods.envelope.method import Envelope, envelope
    from springpot.theory.methods.exact import Exact, exact
    from springpot.theory.methods.fokker_planck.method import FokkerPlanck, fokker_planck
    from springpot.theory.methods.systems.amplitude import AmplitudeAveraging, averaging_amplitude
    from springpot.theory.methods.systems.energy import ExactLaw
    from springpot.theory.methods.systems.half_cycles import HalfCycles, half_cycles
    from springpot.theory.methods.systems.linear import LinearResponse, linear
    from springpot.theory.methods.systems.linearization import Linearization, linearization
    from springpot.theory.methods.systems.path_integration import path_integration
    from springpot.theory.reliability import Trust, best_guess, recommended, trust, why_none_is_recommended
    from springpot.theory.result import Moments, NoConvergenceError, NoStationaryStateError, NotCoveredError, Result
    from springpot.theory.solve import all_methods, solve_all, solve_one

__all__ = [
    "AmplitudeAveraging",
    "Averaging",
    "Closure",
    "Envelope",
    "Exact",
    "ExactLaw",
    "FokkerPlanck",
    "HalfCycles",
    "LinearResponse",
    "Linearization",
    "Moments",
    "NoConvergenceError",
    "NoStationaryStateError",
    "NotCoveredError",
    "Result",
    "Trust",
    "all_methods",
    "averaging",
    "averaging_amplitude",
    "best_guess",
    "closure",
    "envelope",
    "exact",
    "fokker_planck",
    "half_cycles",
    "linear",
    "linearization",
    "path_integration",
    "recommended",
    "solve_all",
    "solve_one",
    "trust",
    "why_none_is_recommended",
]
_PLACES = {
    "methods.averaging": ("Averaging", "averaging"),
    "methods.closure.method": ("Closure", "closure"),
    "methods.envelope.method": ("Envelope", "envelope"),
    "methods.exact": ("Exact", "exact"),
    "methods.fokker_planck.method": ("FokkerPlanck", "fokker_planck"),
    "methods.systems.amplitude": ("AmplitudeAveraging", "averaging_amplitude"),
    "methods.systems.energy": ("ExactLaw",),
    "methods.systems.half_cycles": ("HalfCycles", "half_cycles"),
    "methods.systems.linear": ("LinearResponse", "linear"),
    "methods.systems.linearization": ("Linearization", "linearization"),
    "methods.systems.path_integration": ("path_integration",),
    "reliability": ("Trust", "best_guess", "recommended", "trust", "why_none_is_recommended"),
    "result": ("Moments", "NoConvergenceError", "NoStationaryStateError", "NotCoveredError", "Result"),
    "solve": ("all_methods", "solve_all", "solve_one"),
}


def __getattr__(name: str) -> Any:
    for module, names in _PLACES.items():
        if name in names:
            return getattr(importlib.import_module(f"springpot.theory.{module}"), name)
    raise AttributeError(f"module 'springpot.theory' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
