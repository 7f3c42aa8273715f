"""The parts that a system is a sum of: frozen dataclasses, each checked when it is made."""

from springpot.parts.circuits import Circuit
from springpot.parts.dampers import Dashpot, Friction, PolynomialDashpot, VanDerPol
from springpot.parts.excitations import (
    ColouredNoise,
    Constant,
    FilteredNoise,
    Force,
    Harmonic,
    ParametricNoise,
    PoissonImpulses,
    Recorded,
    ThermalNoise,
    WhiteNoise,
)
from springpot.parts.masses import Mass
from springpot.parts.springpots import Maxwell, Series, Springpot
from springpot.parts.springs import PolynomialSpring, Spring
from springpot.parts.walls import Barrier, Contact

__all__ = [
    "Barrier", "Circuit", "ColouredNoise", "Constant", "Contact", "Dashpot", "FilteredNoise", "Force", "Friction",
    "Harmonic", "Mass", "Maxwell", "ParametricNoise", "PoissonImpulses", "PolynomialDashpot", "PolynomialSpring",
    "Recorded", "Series", "Spring", "Springpot", "ThermalNoise", "VanDerPol", "WhiteNoise",
]  # fmt: skip
