"""Response spectra of records and noise, of any system, and the fragility of a system."""

from springpot.spectra.response import response_spectrum
from springpot.spectra.spectrum import ResponseSpectrum, Spectrum

__all__ = ["ResponseSpectrum", "Spectrum", "response_spectrum"]
