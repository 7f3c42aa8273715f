"""Names and units of everything that a run of a system estimates, from its parts alone."""

from __future__ import annotations

from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    Contact,
    Dashpot,
    Force,
    FractionalMaxwell,
    Friction,
    Harmonic,
    KanaiTajimiNoise,
    Mass,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    RecordedExcitation,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.system import System

__all__ = ["UNCONTROLLED", "UNITS", "is_controlled", "possible_results", "units_of_system"]

UNCONTROLLED = ("_end", "damping_force_mean", "_virial", "energy_residual", "contact_penetration")
"""Endings of results that ``rtol`` does not control."""

UNITS = {
    "x_mean": "m", "x_mean_square": "m2", "v_mean_square": "m2 s-2", "amplitude_mean_square": "m2",
    "impact_rate": "s-1", "impact_speed_mean": "m s-1", "impact_speed_mean_square": "m2 s-2",
    "contact_share": "1", "contact_penetration": "m", "energy_residual": "1", "voltage_mean_square": "V2",
    "x_mean_end": "m", "x_mean_square_end": "m2", "v_mean_square_end": "m2 s-2", "amplitude_mean_square_end": "m2",
}  # fmt: skip

_WORKING = (
    ColoredNoise,
    KanaiTajimiNoise,
    Harmonic,
    RecordedExcitation,
    ThermalNoise,
    Force,
    Friction,
    VanDerPol,
    PolynomialDashpot,
)
"""Kinds whose power is a result."""


def units_of_system(system: System, name: str) -> str:
    """The unit of a result, by its name: powers and forces are those of the mass, or per unit mass without one.

    Examples
    --------
    >>> units_of_system(System(Mass(2.0), Spring(1.0)), "damping_power"), units_of_system(System(Spring(1.0)), "x_mean")
    ('W', 'm')
    """
    if name in UNITS:
        return UNITS[name]
    heavy = bool(system.of(Mass))
    for end, units in (("_power", ("m2 s-3", "W")), ("force_mean", ("m s-2", "N")), ("virial", ("m2 s-2", "J"))):
        if name.endswith(end):
            return units[heavy]
    return next((unit for end, unit in UNITS.items() if name.endswith(end)), "")


def is_controlled(name: str) -> bool:
    """Whether ``rtol`` can control a result.

    Examples
    --------
    >>> is_controlled("x_mean"), is_controlled("x_mean_end")
    (True, False)
    """
    return not name.endswith(UNCONTROLLED)


def possible_results(system: System) -> tuple[str, ...]:
    """Names of all results that a system of these kinds of parts can have, whatever their numbers are.

    Examples
    --------
    >>> [name for name in possible_results(System(Spring(1.0), WhiteNoise(1.0), stop=Barrier(0.0))) if "stop" in name]
    ['stop_power', 'stop_force_mean', 'stop_impact_rate', 'stop_impact_speed_mean']
    """
    walls = [name for name, part in system.named() if isinstance(part, Barrier | Contact)]
    lossy = Springpot, Dashpot, PolynomialDashpot, FractionalMaxwell, Maxwell, PiezoelectricCircuit
    balanced = WhiteNoise, ParametricNoise, PoissonImpulses
    circuits = (
        []
        if system.of(ThermalNoise)
        else [name for name, part in system.named() if isinstance(part, PiezoelectricCircuit)]
    )
    of_walls = [f"{name}_{what}" for name in walls for what in ("impact_rate", "impact_speed_mean")]
    found = [
        "x_mean", "x_mean_square", "v_mean_square",
        *(["amplitude_mean_square"] if system.of(Spring, PolynomialSpring) else []),
        *(["impact_rate", "impact_speed_mean", "impact_speed_mean_square"] if walls else []),
        *(["damping_force_mean", "damping_power", "damping_virial"] if system.of(*lossy) else []),
        *(f"{name}_power" for name, part in system.named() if isinstance(part, _WORKING)),
        "input_power",
        *(f"{name}_power" for name in walls),
        *(f"{name}_force_mean" for name in walls),
        *(["energy_residual"] if system.of(*balanced) else []),
        *(f"{name}_voltage_mean_square" for name in circuits),
        *(["harvested_power"] if circuits else []),
        *(["contact_share", "contact_penetration"] if system.of(Contact) else []),
        *of_walls,
        "x_mean_end", "x_mean_square_end", "v_mean_square_end",
        *(["amplitude_mean_square_end"] if system.of(Spring, PolynomialSpring) else []),
    ]  # fmt: skip
    return tuple(dict.fromkeys(found))
