"""Response spectra of records and noise, of any system, and the fragility of a system."""

from springpot.spectra.curves import Fragility, FragilityCurve
from springpot.spectra.fragility import fragility
from springpot.spectra.response import response_spectrum
from springpot.spectra.spectrum import ResponseSpectrum, Spectrum

__all__ = ["Fragility", "FragilityCurve", "ResponseSpectrum", "Spectrum", "fragility", "response_spectrum"]
