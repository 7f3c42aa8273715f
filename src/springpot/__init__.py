"""Random vibration of oscillators with power-law memory that strike a wall.

The names below are loaded when they are first used, so that ``import springpot`` (and ``springpot --help``) is quick.
Nothing at all is loaded with this file, so that the command is ready for Ctrl-C at once.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing, which takes longer to load than all the rest here
if TYPE_CHECKING:
    from typing import Any

    from springpot import figures, theory
    from springpot.designing import design, sensitivity
    from springpot.evidence.atlases import atlas
    from springpot.evidence.explanation import explain
    from springpot.explorer.commands import explore
    from springpot.fitting import (
        MeasuredFrequencyResponse,
        MeasuredImpacts,
        MeasuredModuli,
        MeasuredRecord,
        MeasuredSpectrum,
        MeasuredStatistics,
        fit,
        read_data,
    )
    from springpot.problem.file import read_system, to_toml
    from springpot.problem.free_numbers import free
    from springpot.problem.oscillator import Oscillator
    from springpot.problem.parts import (
        Barrier,
        ColoredNoise,
        Constant,
        Contact,
        Dashpot,
        Force,
        FractionalMaxwell,
        Friction,
        Harmonic,
        KanaiTajimiNoise,
        Mass,
        Maxwell,
        ParametricNoise,
        PiezoelectricCircuit,
        PoissonImpulses,
        PolynomialDashpot,
        PolynomialSpring,
        RecordedExcitation,
        Spring,
        Springpot,
        ThermalNoise,
        VanDerPol,
        WhiteNoise,
    )  # fmt: skip
    from springpot.problem.parts.walls import PowerRestitution
    from springpot.problem.system import System
    from springpot.simulation.extended import extend
    from springpot.simulation.monte_carlo import simulate
    from springpot.simulation.result.load import load_run
    from springpot.studies import open_study, study

    __version__: str

__all__ = [
    "Barrier",
    "ColoredNoise",
    "Constant",
    "Contact",
    "Dashpot",
    "Force",
    "FractionalMaxwell",
    "Friction",
    "Harmonic",
    "KanaiTajimiNoise",
    "Mass",
    "Maxwell",
    "MeasuredFrequencyResponse",
    "MeasuredImpacts",
    "MeasuredModuli",
    "MeasuredRecord",
    "MeasuredSpectrum",
    "MeasuredStatistics",
    "Oscillator",
    "ParametricNoise",
    "PiezoelectricCircuit",
    "PoissonImpulses",
    "PolynomialDashpot",
    "PolynomialSpring",
    "PowerRestitution",
    "RecordedExcitation",
    "Spring",
    "Springpot",
    "System",
    "ThermalNoise",
    "VanDerPol",
    "WhiteNoise",
    "atlas",
    "design",
    "explain",
    "explore",
    "extend",
    "figures",
    "fit",
    "free",
    "load_run",
    "open_study",
    "read_data",
    "read_system",
    "sensitivity",
    "simulate",
    "study",
    "theory",
    "to_toml",
]  # fmt: skip
_ROOMS = ("figures", "theory")
_LATER = {
    "MeasuredFrequencyResponse": "springpot.fitting",
    "MeasuredImpacts": "springpot.fitting",
    "MeasuredModuli": "springpot.fitting",
    "MeasuredRecord": "springpot.fitting",
    "MeasuredSpectrum": "springpot.fitting",
    "MeasuredStatistics": "springpot.fitting",
    "fit": "springpot.fitting",
    "Oscillator": "springpot.problem.oscillator",
    "PowerRestitution": "springpot.problem.parts.walls",
    "System": "springpot.problem.system",
    "atlas": "springpot.evidence.atlases",
    "design": "springpot.designing",
    "explain": "springpot.evidence.explanation",
    "explore": "springpot.explorer.commands",
    "figures": "springpot.figures",
    "free": "springpot.problem.free_numbers",
    "extend": "springpot.simulation.extended",
    "load_run": "springpot.simulation",
    "open_study": "springpot.studies",
    "read_data": "springpot.fitting",
    "read_system": "springpot.problem.file",
    "to_toml": "springpot.problem.file",
    "sensitivity": "springpot.designing",
    "simulate": "springpot.simulation",
    "study": "springpot.studies",
    "theory": "springpot.theory",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("springpot")
    if name not in __all__:
        raise AttributeError(f"module 'springpot' has no attribute {name!r}")
    import importlib

    place = _LATER.get(name, "springpot.problem.parts")
    module = importlib.import_module(place)
    return module if name in _ROOMS else getattr(module, name)


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
