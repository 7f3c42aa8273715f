"""From the kernel's sums to the results of a system: moments, impacts of every wall, and powers of every part."""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt

from springpot.problem.parts import (
    Barrier,
    ColoredNoise,
    Contact,
    FractionalMaxwell,
    KanaiTajimiNoise,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    Springpot,
    ThermalNoise,
    WhiteNoise,
)
from springpot.problem.parts.walls import slow_restitution
from springpot.problem.system import System
from springpot.simulation.estimate.statistics import ratio
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.lowering.walls import Soft
from springpot.simulation.plan.scales import Scales
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.start import Adapted
from springpot.theory.mckean import COLLAPSE_BELOW

__all__ = ["errors_of_the_start_of_system", "impacts_of_system", "samples_of_system", "taken_by_walls", "uncountable"]

Floats = npt.NDArray[np.float64]
Samples = dict[str, tuple[float, Floats]]


def uncountable(system: System) -> str:
    """Why the impacts of a system cannot be counted; empty if they can.

    Examples
    --------
    >>> from springpot.problem.parts import ColoredNoise, Springpot, Spring
    >>> uncountable(System(Spring(1.0), Springpot(0.5, 1.0), Barrier(0.0, 0.8), ColoredNoise(1.0, 0.5)))[:42]
    'barrier is lossy, and no white noise acts '
    """
    white = any(noise.intensity > 0.0 for noise in system.of(WhiteNoise))
    dampers = system.damping + sum(pot.coefficient for pot in system.of(Springpot) if pot.order == 1.0)
    thermal = bool(system.of(ThermalNoise)) and dampers > 0.0
    smooth = system.of(ColoredNoise, KanaiTajimiNoise, PoissonImpulses, ParametricNoise, ThermalNoise)
    for name, wall in system.named():
        if not isinstance(wall, Barrier) or slow_restitution(wall) == 1.0:
            continue
        multiplied = bool(system.of(ParametricNoise)) and wall.position != 0.0
        if smooth and not (white or thermal or multiplied):
            return (
                f"{name} is lossy, and no white noise acts on the mass: a smooth force lets the mass come to rest on "
                "the wall after infinitely many impacts"
            )
        slow = slow_restitution(wall)
        if slow <= COLLAPSE_BELOW and (white or thermal or multiplied):
            return (
                f"restitution {slow:g} of {name} is not above {COLLAPSE_BELOW:.3f} (= exp(-pi/sqrt 3)): "
                "white noise causes infinitely many impacts in a finite time"
            )
    return ""


def samples_of_system(system: System, parts: Parts, settings: Settings, rows: Floats) -> Samples:
    """Each estimate with its samples, one per path, as `springpot.simulation.paths.simulation.Simulation.samples`.

    Parameters
    ----------
    system : System
    parts : Parts
    settings : Settings
    rows : ndarray, shape (paths, columns of the parts)
    """
    low, high = settings.window_steps
    steps, time, mass = high - low, (high - low) * settings.step, system.mass
    column = dict(zip(parts.columns, rows.T, strict=True))
    taken = taken_by_walls(system, column)
    lost = {name: energy for name, (energy, _) in taken.items()}
    found = {
        "x_mean": column["x"] / steps,
        "x_mean_square": column["x_square"] / steps,
        "v_mean_square": column["v_square"] / steps,
    }
    if system.stiffness > 0.0:
        square = system.natural_frequency**2
        found["amplitude_mean_square"] = (column["x_square"] + column["v_square"] / square) / steps
    if system.of(Barrier, Contact):
        found["impact_rate"] = column["impacts"] / time
    damped = column["power"] / steps + parts.taken_at_once
    if _has_damping(system):
        found["damping_force_mean"] = mass * column["force"] / steps
        found["damping_power"] = mass * damped
        found["damping_virial"] = mass * column["virial"] / steps
    works = {named: column[f"work of {named.name}"] / time for named in parts.named}
    gained = (column["energy_last"] - column["energy_first"]) / time
    # the rest of the balance: the work of noise whose increments are independent
    fed = gained + damped + sum(lost.values(), np.zeros(len(rows))) / time
    fed = fed - sum((w for named, w in works.items() if named.does != "expected"), np.zeros(len(rows)))
    if isinstance(parts.wall, Soft):
        fed = fed - (column["contacts' work"] + sum(lost.values(), np.zeros(len(rows)))) / time
    expected = parts.expected_power + sum(float(w.mean()) for named, w in works.items() if named.does == "expected")
    supplied, total = expected, fed
    for named, work in works.items():
        if named.does == "feeds":
            found[f"{named.name}_power"] = mass * work
            supplied, total = supplied + abs(float(work.mean())), total + work
        elif named.does == "works":
            found[f"{named.name}_power"] = mass * work
        elif named.does == "dissipates":
            found[f"{named.name}_power"] = -mass * work
    found["input_power"] = mass * total
    found |= {f"{name}_power": mass * energy / time for name, (energy, _) in taken.items()}
    found |= {f"{name}_force_mean": mass * momentum / time for name, (_, momentum) in taken.items()}
    if expected > 0.0:  # without such noise the balance is an identity, and no check
        balance = parts.expected_power + sum(w for named, w in works.items() if named.does == "expected") - fed
        found["energy_residual"] = balance / supplied
    found |= _of_circuits(system, parts, column, settings)
    found |= _of_contacts(parts, column, time)
    found |= {
        "x_mean_end": column["x_end"],
        "x_mean_square_end": column["x_end"] ** 2,
        "v_mean_square_end": column["v_end"] ** 2,
    }
    samples = {name: (float(values.mean()), values) for name, values in found.items()} | _of_impacts(
        system, column, time
    )
    if uncountable(system):
        undefined = math.nan, np.full(len(rows), np.nan)
        samples |= {name: undefined for name in samples if "impact_" in name}
    return samples


def impacts_of_system(system: System, column: dict[str, Floats]) -> dict[str, Floats]:
    """Impacts of each path: on each wall and contact by its name, on all of them under an empty one."""
    at_walls = {name: sums[0] for name, sums in _at_walls(system, column).items()}
    return {"": column["impacts"], **at_walls} if at_walls else {}


def _has_damping(system: System) -> bool:
    """Whether the sums of springpots, dashpots, arms and circuits are of anything."""
    pots = [pot for pot in system.of(Springpot) if pot.dissipates]
    return bool(pots or system.damping or system.of(FractionalMaxwell, Maxwell, PiezoelectricCircuit))


def _at_walls(system: System, column: dict[str, Floats]) -> dict[str, tuple[Floats, Floats, Floats]]:
    """Impacts, speeds and squares of each wall and contact, by its name."""
    whole = column["impacts"], column["impact_speeds"], column["impact_speed_squares"]
    contacts = itertools.count()
    found = {}
    for name, part in system.named():
        if isinstance(part, Contact):
            found[name] = _sums(column, f"contact {next(contacts)}")
        elif isinstance(part, Barrier) and part.side == "below":
            found[name] = _sums(column, "upper")
    for name, part in system.named():  # the impacts of a lower wall are what is left of all
        if isinstance(part, Barrier) and part.side == "above":
            others = [*found.values()]
            for other in others:
                whole = whole[0] - other[0], whole[1] - other[1], whole[2] - other[2]
            found[name] = whole
    return {name: found[name] for name, part in system.named() if isinstance(part, Barrier | Contact)}


def _sums(column: dict[str, Floats], where: str) -> tuple[Floats, Floats, Floats]:
    return column[f"{where} impacts"], column[f"{where} speeds"], column[f"{where} squares"]


def taken_by_walls(system: System, column: dict[str, Floats]) -> dict[str, tuple[Floats, Floats]]:
    """Energy and momentum that each wall and contact took, by its name."""
    contacts, struck = itertools.count(), _at_walls(system, column)
    taken = {}
    for name, part in system.named():
        if isinstance(part, Barrier) and not callable(part.restitution):
            _, speeds, squares = struck[name]
            taken[name] = 0.5 * (1.0 - part.restitution**2) * squares, (1.0 + part.restitution) * speeds
        elif isinstance(part, Barrier | Contact):
            side = "lower" if part.side == "above" else "upper"
            where = side if isinstance(part, Barrier) else f"contact {next(contacts)}"
            taken[name] = column[f"{where} loss"], column[f"{where} momentum"]
    return taken


def _of_impacts(system: System, column: dict[str, Floats], time: float) -> Samples:
    """Impact speeds, and rate and speed of every wall."""
    if not system.of(Barrier, Contact):
        return {}
    found = {
        "impact_speed_mean": ratio(column["impact_speeds"], column["impacts"]),
        "impact_speed_mean_square": ratio(column["impact_speed_squares"], column["impacts"]),
    }
    for name, (impacts, speeds, _) in _at_walls(system, column).items():
        found[f"{name}_impact_rate"] = (float(impacts.mean()) / time, impacts / time)
        found[f"{name}_impact_speed_mean"] = ratio(speeds, impacts)
    return found


def _of_circuits(system: System, parts: Parts, column: dict[str, Floats], settings: Settings) -> dict[str, Floats]:
    """Mean square voltage of each circuit, and the power that all deliver."""
    if system.of(ThermalNoise):  # the noise of its resistor is beside the mode, in the matched force
        return {}
    low, high = settings.window_steps
    instants = sum(1 for n in range(GROUP - 1, settings.steps + GROUP, GROUP) if low <= n < high)
    found, harvested = {}, np.zeros(column["x"].size)
    for name, part in system.named():
        if isinstance(part, PiezoelectricCircuit):
            square = column[f"voltage of {name}"] / max(instants, 1) * system.mass
            found[f"{name}_voltage_mean_square"] = square
            harvested = harvested + square / part.resistance
    return {**found, "harvested_power": harvested} if found else {}


def _of_contacts(parts: Parts, column: dict[str, Floats], time: float) -> dict[str, Floats]:
    if not isinstance(parts.wall, Soft):
        return {}
    return {"contact_share": column["contacts' time"] / time, "contact_penetration": column["contacts' depth"]}


def errors_of_the_start_of_system(
    system: System, scales: Scales, settings: Settings, adapted: Adapted | None, values: dict[str, float]
) -> dict[str, float]:
    """As for an oscillator: standard error of each value due to that of x(0), summed over the springpots."""
    errors = dict.fromkeys(values, 0.0)
    if adapted is None or adapted.error is None or not adapted.error > 0.0:
        return errors
    unit, share = system.per_unit_mass, 0.0
    rate = 1.0 / scales.forgetting_time
    frequency = max(scales.fastest_rate, 2.0 * rate)
    for pot in unit.of(Springpot):
        if pot.remembers:
            fading = max(settings.window[0], 1.0 / frequency) ** -pot.order / math.gamma(1.0 - pot.order)
            share += adapted.error * pot.coefficient * fading / frequency**2
    for name, value in values.items():
        errors[name] = share * abs(value)
    size = math.sqrt(max(values["x_mean_square"], 0.0))
    errors |= {name: share * size for name in ("x_mean", "x_mean_end") if name in errors}
    if "damping_force_mean" in errors:
        errors["damping_force_mean"] = share * size * system.mass * frequency**2
    if "energy_residual" in errors:
        errors["energy_residual"] = 0.0
    return errors
