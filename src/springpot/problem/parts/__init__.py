"""The parts that a system is a sum of: frozen dataclasses, each checked when it is made."""

from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.dampers import Dashpot, Friction, PolynomialDashpot, VanDerPol
from springpot.problem.parts.excitations import (
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
from springpot.problem.parts.masses import Mass
from springpot.problem.parts.springpots import Maxwell, Series, Springpot
from springpot.problem.parts.springs import PolynomialSpring, Spring
from springpot.problem.parts.walls import Barrier, Contact

__all__ = [
    "Barrier", "Circuit", "ColouredNoise", "Constant", "Contact", "Dashpot", "FilteredNoise", "Force", "Friction",
    "Harmonic", "Mass", "Maxwell", "ParametricNoise", "PoissonImpulses", "PolynomialDashpot", "PolynomialSpring",
    "Recorded", "Series", "Spring", "Springpot", "ThermalNoise", "VanDerPol", "WhiteNoise",
]  # fmt: skip
