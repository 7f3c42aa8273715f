"""From data to numbers: moduli, spectra, frequency responses, records, impacts and statistics."""

from springpot.fitting.fitted import fit
from springpot.fitting.frequency_response import FrequencyResponse
from springpot.fitting.motion_data import Record, Spectrum
from springpot.fitting.part_data import Impacts, Moduli
from springpot.fitting.reading import read_data
from springpot.fitting.result import Check, Choice, Fit, Profile
from springpot.fitting.statistics import Statistics

__all__ = [
    "Check", "Choice", "Fit", "FrequencyResponse", "Impacts", "Moduli", "Profile", "Record", "Spectrum", "Statistics",
    "fit", "read_data",
]  # fmt: skip
