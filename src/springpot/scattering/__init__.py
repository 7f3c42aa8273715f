"""Devices scatter: `springpot.scatter` simulates many devices whose uncertain numbers are drawn from their laws."""

from springpot.scattering.estimates import Estimates, Interval
from springpot.scattering.result import Scatter
from springpot.scattering.scattered import scatter

__all__ = ["Estimates", "Interval", "Scatter", "scatter"]
