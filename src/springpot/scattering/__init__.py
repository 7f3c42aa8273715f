"""Devices scatter: `springpot.scatter` simulates many devices whose uncertain numbers are drawn from their laws, and
`springpot.exceedance_over_devices` has the probabilities of rare events over them.
"""

from springpot.scattering.estimates import Estimates, Interval
from springpot.scattering.exceedance import exceedance_over_devices
from springpot.scattering.exceeded import DeviceExceedance, DevicesThatExceed
from springpot.scattering.own_probability import OwnProbability
from springpot.scattering.result import Scatter
from springpot.scattering.scattered import scatter

__all__ = [
    "DeviceExceedance", "DevicesThatExceed", "Estimates", "Interval", "OwnProbability", "Scatter",
    "exceedance_over_devices", "scatter",
]  # fmt: skip
