"""From data to numbers: moduli, spectra, records and impacts."""

from springpot.fitting.data import Impacts, Moduli, Record, Spectrum
from springpot.fitting.fitted import fit
from springpot.fitting.reading import read_data
from springpot.fitting.result import Check, Choice, Fit, Profile

__all__ = ["Check", "Choice", "Fit", "Impacts", "Moduli", "Profile", "Record", "Spectrum", "fit", "read_data"]
