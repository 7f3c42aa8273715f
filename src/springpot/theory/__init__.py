"""Analytical methods: functions that take a system and return a small frozen result.

The names below are loaded when they are first used: the list of methods is then there at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.machine.faults import NotCoveredError
from springpot.machine.installed import loaded_later

if TYPE_CHECKING:
    from springpot.theory.level_crossings import LevelRates, LevelsOfProbability, exceedance, exceedance_level
    from springpot.theory.methods.averaging import Averaging, averaging
    from springpot.theory.methods.envelope.method import Envelope, envelope
    from springpot.theory.methods.exact import Exact, exact
    from springpot.theory.methods.fokker_planck.method import FokkerPlanck, fokker_planck
    from springpot.theory.methods.memory_closure.method import MemoryClosure, memory_closure
    from springpot.theory.methods.systems.amplitude import AmplitudeAveraging, averaging_amplitude
    from springpot.theory.methods.systems.half_cycles import HalfCycles, half_cycles
    from springpot.theory.methods.systems.linear import LinearResponse, linear
    from springpot.theory.methods.systems.linearization import Linearization, linearization
    from springpot.theory.methods.systems.path_integration import path_integration
    from springpot.theory.normal_modes import Modes, modes
    from springpot.theory.result import Moments, NoConvergenceError, NoStationaryStateError, Result
    from springpot.theory.solve import solve_all, solve_one
    from springpot.theory.spectral_fatigue import Fatigue, fatigue
    from springpot.theory.transients import Transient, transient

__all__ = [
    "AmplitudeAveraging",
    "Averaging",
    "Envelope",
    "Exact",
    "Fatigue",
    "FokkerPlanck",
    "HalfCycles",
    "LevelRates",
    "LevelsOfProbability",
    "LinearResponse",
    "Linearization",
    "MemoryClosure",
    "Modes",
    "Moments",
    "NoConvergenceError",
    "NoStationaryStateError",
    "NotCoveredError",
    "Result",
    "Transient",
    "averaging",
    "averaging_amplitude",
    "envelope",
    "exact",
    "exceedance",
    "exceedance_level",
    "fatigue",
    "fokker_planck",
    "half_cycles",
    "linear",
    "linearization",
    "memory_closure",
    "modes",
    "path_integration",
    "solve_all",
    "solve_one",
    "transient",
]
_PLACES = {
    "level_crossings": ("LevelRates", "LevelsOfProbability", "exceedance", "exceedance_level"),
    "methods.averaging": ("Averaging", "averaging"),
    "methods.memory_closure.method": ("MemoryClosure", "memory_closure"),
    "methods.envelope.method": ("Envelope", "envelope"),
    "methods.exact": ("Exact", "exact"),
    "methods.fokker_planck.method": ("FokkerPlanck", "fokker_planck"),
    "methods.systems.amplitude": ("AmplitudeAveraging", "averaging_amplitude"),
    "methods.systems.half_cycles": ("HalfCycles", "half_cycles"),
    "methods.systems.linear": ("LinearResponse", "linear"),
    "methods.systems.linearization": ("Linearization", "linearization"),
    "methods.systems.path_integration": ("path_integration",),
    "normal_modes": ("Modes", "modes"),
    "result": ("Moments", "NoConvergenceError", "NoStationaryStateError", "Result"),
    "solve": ("solve_all", "solve_one"),
    "spectral_fatigue": ("Fatigue", "fatigue"),
    "transients": ("Transient", "transient"),
}
__getattr__ = loaded_later(__name__, _PLACES)


def __dir__() -> list[str]:
    return sorted(__all__)
