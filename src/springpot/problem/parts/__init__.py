"""The parts that a system is a sum of: frozen dataclasses, each checked when it is made."""

from springpot.problem.parts.circuits import PiezoelectricCircuit
from springpot.problem.parts.dampers import Dashpot, Friction, PolynomialDashpot, VanDerPol
from springpot.problem.parts.excitations import (
    ColoredNoise,
    Constant,
    Force,
    Harmonic,
    KanaiTajimiNoise,
    ParametricNoise,
    PoissonImpulses,
    RecordedExcitation,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.parts.masses import Mass
from springpot.problem.parts.springpots import FractionalMaxwell, Maxwell, Springpot
from springpot.problem.parts.springs import PolynomialSpring, Spring
from springpot.problem.parts.walls import Barrier, Contact

__all__ = [
    "Barrier",
    "ColoredNoise",
    "Constant",
    "Contact",
    "Dashpot",
    "Force",
    "FractionalMaxwell",
    "Friction",
    "Harmonic",
    "KanaiTajimiNoise",
    "Mass",
    "Maxwell",
    "ParametricNoise",
    "PiezoelectricCircuit",
    "PoissonImpulses",
    "PolynomialDashpot",
    "PolynomialSpring",
    "RecordedExcitation",
    "Spring",
    "Springpot",
    "ThermalNoise",
    "VanDerPol",
    "WhiteNoise",
]  # fmt: skip
