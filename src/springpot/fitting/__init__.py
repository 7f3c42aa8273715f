"""From data to numbers: moduli, relaxation, creep, spectra, frequency responses, records, impacts and statistics."""

from springpot.fitting.fitted import fit
from springpot.fitting.frequency_response import MeasuredFrequencyResponse
from springpot.fitting.master_curve import MasterCurve, master_curve
from springpot.fitting.motion_data import MeasuredRecord, MeasuredSpectrum
from springpot.fitting.part_data import MeasuredCreep, MeasuredImpacts, MeasuredModuli, MeasuredRelaxation
from springpot.fitting.reading import read_data
from springpot.fitting.result import Check, Choice, Fit, Profile
from springpot.fitting.statistics import MeasuredStatistics

__all__ = [
    "Check",
    "Choice",
    "Fit",
    "MasterCurve",
    "MeasuredCreep",
    "MeasuredFrequencyResponse",
    "MeasuredImpacts",
    "MeasuredModuli",
    "MeasuredRecord",
    "MeasuredRelaxation",
    "MeasuredSpectrum",
    "MeasuredStatistics",
    "Profile",
    "fit",
    "master_curve",
    "read_data",
]  # fmt: skip
