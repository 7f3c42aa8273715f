"""Random vibration of a mass on a viscoelastic mount that hits a stop.

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
    from springpot.evidence.recommendation import recommended
    from springpot.evidence.reliability import trust
    from springpot.explorer.commands import explore
    from springpot.files.matrices import read_matrix
    from springpot.fitting import (
        MeasuredCreep,
        MeasuredFrequencyResponse,
        MeasuredImpacts,
        MeasuredModuli,
        MeasuredRecord,
        MeasuredRelaxation,
        MeasuredSpectrum,
        MeasuredStatistics,
        fit,
        master_curve,
        read_data,
    )
    from springpot.problem.bands import band_rms
    from springpot.problem.basquin import Basquin
    from springpot.problem.beams import beam
    from springpot.problem.dimensionless import Dimensionless
    from springpot.problem.file import read_system, to_toml
    from springpot.problem.free_numbers import free, nominal, with_values
    from springpot.problem.messages import (
        AccuracyWarning,
        FileWarning,
        NoEffectWarning,
        ProblemWarning,
        RareEventWarning,
        SpringpotWarning,
        StationarityWarning,
    )
    from springpot.problem.modal_table import read_modes
    from springpot.problem.oscillator import Oscillator
    from springpot.problem.parts import *  # noqa: F403
    from springpot.problem.shaking import ground_motion, ground_motion_psd, noise_records, sweep
    from springpot.problem.system import System
    from springpot.problem.temperature import Shift
    from springpot.problem.uncertain import uncertain
    from springpot.scattering import exceedance_over_devices, scatter
    from springpot.simulation.extended import extend
    from springpot.simulation.many import simulate_many
    from springpot.simulation.monte_carlo import simulate
    from springpot.simulation.rare.exceedance import exceedance
    from springpot.simulation.result.load import load_run
    from springpot.spectra import fragility, response_spectrum
    from springpot.studies import open_study, study

    __version__: str

    __all__ = [
        "AccuracyWarning", "Basquin", "Dimensionless", "FileWarning", "MeasuredCreep", "MeasuredFrequencyResponse",
        "MeasuredImpacts", "MeasuredModuli", "MeasuredRecord", "MeasuredRelaxation", "MeasuredSpectrum",
        "MeasuredStatistics", "NoEffectWarning", "Oscillator", "ProblemWarning", "RareEventWarning", "Shift",
        "SpringpotWarning", "StationarityWarning", "System", "atlas", "band_rms", "beam", "design", "exceedance",
        "exceedance_over_devices", "explain", "explore", "extend", "figures", "fit", "fragility", "free",
        "ground_motion", "ground_motion_psd", "load_run", "master_curve", "noise_records", "nominal", "open_study",
        "read_data", "read_matrix", "read_modes", "read_system", "recommended", "response_spectrum", "scatter",
        "sensitivity", "simulate", "simulate_many", "study", "sweep", "theory", "to_toml", "trust", "uncertain",
        "with_values",
    ]  # fmt: skip

_WARNINGS = ("Accuracy", "File", "NoEffect", "Problem", "RareEvent", "Springpot", "Stationarity")
_DATA = ("Creep", "FrequencyResponse", "Impacts", "Moduli", "Record", "Relaxation", "Spectrum", "Statistics")
_LATER = {
    name: f"springpot.{place}"
    for place, names in {
        "designing": ("design", "sensitivity"),
        "evidence.atlases": ("atlas",),
        "evidence.explanation": ("explain",),
        "evidence.recommendation": ("recommended",),
        "evidence.reliability": ("trust",),
        "explorer.commands": ("explore",),
        "figures": ("figures",),
        "files.matrices": ("read_matrix",),
        "fitting": ("fit", "master_curve", "read_data", *(f"Measured{data}" for data in _DATA)),
        "problem.bands": ("band_rms",),
        "problem.basquin": ("Basquin",),
        "problem.beams": ("beam",),
        "problem.dimensionless": ("Dimensionless",),
        "problem.file": ("read_system", "to_toml"),
        "problem.free_numbers": ("free", "nominal", "with_values"),
        "problem.messages": tuple(f"{what}Warning" for what in _WARNINGS),
        "problem.modal_table": ("read_modes",),
        "problem.oscillator": ("Oscillator",),
        "problem.shaking": ("ground_motion", "ground_motion_psd", "noise_records", "sweep"),
        "problem.system": ("System",),
        "problem.temperature": ("Shift",),
        "problem.uncertain": ("uncertain",),
        "scattering": ("exceedance_over_devices", "scatter"),
        "simulation": ("load_run", "simulate"),
        "simulation.extended": ("extend",),
        "simulation.many": ("simulate_many",),
        "simulation.rare.exceedance": ("exceedance",),
        "spectra": ("fragility", "response_spectrum"),
        "studies": ("open_study", "study"),
        "theory": ("theory",),
    }.items()
    for name in names
}  # and the parts, from their own list


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from springpot.machine.installed import __version__

        return __version__
    import importlib

    if name in _LATER:
        module = importlib.import_module(_LATER[name])
        return module if _LATER[name] == f"springpot.{name}" else getattr(module, name)
    if name == "__all__" or name[0].isupper():
        parts = importlib.import_module("springpot.problem.parts")
        if name == "__all__":
            return sorted([*_LATER, *parts.__all__])
        if name in parts.__all__:
            return globals().setdefault(name, getattr(parts, name))
    raise AttributeError(f"module 'springpot' has no attribute {name!r}")


def __dir__() -> list[str]:
    return [*__getattr__("__all__"), "__version__"]
