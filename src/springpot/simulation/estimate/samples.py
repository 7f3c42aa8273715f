"""From the kernel's sums to results: moments, impacts of every wall, and powers of every part, with standard errors."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.catalogue import possible_results
from springpot.problem.parts import (
    Barrier,
    ThermalNoise,
)
from springpot.problem.parts.circuits import Circuit
from springpot.problem.parts.walls import SoftStop, Stop
from springpot.problem.system import System
from springpot.simulation.estimate.few_events import Watched, errors_of_unseen
from springpot.simulation.kernel.lanes import GROUP
from springpot.simulation.kernel.soft_contacts import Soft
from springpot.simulation.lowering.compose import Parts
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.statistics import ratio, residual, standard_error
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings

if TYPE_CHECKING:
    from springpot.simulation.lowering.several import PartsOfSeveral

_ENERGIES = "x_mean_square", "v_mean_square", "elongation_mean_square", "_power"
Samples = dict[str, tuple[float, Floats]]


def estimates_of(simulation: Simulation, rows: Floats, seen: Watched) -> tuple[dict[str, float], dict[str, float]]:
    """Values and standard errors, both by name; the errors include that of an adapted start.

    Parameters
    ----------
    simulation : Simulation
    rows : ndarray, shape (paths, columns of the parts)
        Of `Simulation.advance`.
    seen : Watched
        Of `watched`.

    Returns
    -------
    values, errors : dict
        With a single path the errors are NaN; a speed without impacts is NaN, and so are impact rate and speeds where
        impacts cannot be counted.  What is 0 since no impact was seen has the errors of
        `springpot.simulation.estimate.few_events`.
    """
    samples = samples_of(simulation, rows)
    values = {name: value for name, (value, _) in samples.items()}
    start = errors_of_the_start(simulation.plan, values)
    strata = simulation.motion.strata
    errors = {
        name: math.hypot(standard_error(per_path, strata=strata), start[name])
        for name, (_, per_path) in samples.items()
    }
    if simulation.motion.different_paths == 1 and len(rows) == 1:  # there is no other
        errors = {name: 0.0 if math.isfinite(value) else math.nan for name, value in values.items()}
    return values, errors | errors_of_unseen(values, seen)


def watched(simulation: Simulation, rows: Floats) -> Watched:
    """The impacts of each path, and the time in all windows together."""
    column = dict(zip(simulation.parts.columns, rows.T, strict=True))
    at_walls = {name: column[impacts] for name, impacts in simulation.parts.struck.items()}
    whole = {}
    if "impacts" in column:  # of all walls
        at_walls = {name: sums[0] for name, sums in _at_walls(simulation.motion.system, column).items()}
        whole = {"": column["impacts"]} if at_walls else {}
    low, high = simulation.settings.window_steps
    time = len(rows) * (high - low) * simulation.settings.step
    return Watched({**whole, **at_walls}, time)


def samples_of(simulation: Simulation, rows: Floats) -> Samples:
    """Each estimate with its samples, one per path; its mean is that of the samples (ratios are linearized).

    Differences and sums of samples from the same paths give the standard errors of differences and sums.

    Parameters
    ----------
    simulation : Simulation
    rows : ndarray, shape (paths, columns of the parts)
        Of `Simulation.advance`.
    """
    if simulation.parts.readings:
        return _read(simulation, rows)
    system, parts, settings = simulation.motion.system, simulation.parts, simulation.settings
    low, high = settings.window_steps
    steps, time, mass = high - low, (high - low) * settings.step, system.inertia
    column = dict(zip(parts.columns, rows.T, strict=True))
    taken = taken_by_walls(system, column)
    # the sums are those of x - origin; what an x^2 has more than its square
    origin = simulation.motion.origin
    moved = origin * (2.0 * column["x"] / steps + origin)
    found = {
        "x_mean": column["x"] / steps + origin,
        "x_mean_square": column["x_square"] / steps + moved,
        "v_mean_square": column["v_square"] / steps,
    }
    ends = {"x_mean_end": column["x_end"], "x_mean_square_end": column["x_end"] ** 2}
    ends["v_mean_square_end"] = column["v_end"] ** 2
    if system.stiffness > 0.0:
        square = system.natural_frequency**2
        found["amplitude_mean_square"] = (column["x_square"] + column["v_square"] / square) / steps + moved
        ends["amplitude_mean_square_end"] = column["x_end"] ** 2 + column["v_end"] ** 2 / square
    if taken:
        found["impact_rate"] = column["impacts"] / time
    damped = column["power"] / steps + parts.taken_at_once
    if has_damping(system):
        found["damping_force_mean"] = mass * column["force"] / steps
        found["damping_power"] = mass * damped
        found["damping_virial"] = mass * (column["virial"] + origin * column["force"]) / steps
    found |= _balance(parts, column, damped, taken, time, mass)
    found |= {f"{name}_power": mass * energy / time for name, (energy, _) in taken.items()}
    found |= {f"{name}_force_mean": mass * momentum / time for name, (_, momentum) in taken.items()}
    found |= _of_circuits(system, column, settings)
    found |= _of_contacts(parts, column, time)
    found |= ends
    samples = {name: (float(values.mean()), values) for name, values in found.items()} | _of_impacts(
        system, column, time
    )
    return _possible(simulation, samples)


def _possible(simulation: Simulation, samples: Samples) -> Samples:
    """In the order of the catalogue; those of impacts that cannot be counted are NaN."""
    motion = simulation.motion
    undefined = math.nan, np.full_like(next(iter(samples.values()))[1], np.nan)
    samples |= {name: undefined for name in samples if motion.uncounted_because(name)}
    return {name: samples[name] for name in possible_results(motion.system) if name in samples}


def _read(simulation: Simulation, rows: Floats) -> Samples:
    """The results of which the kernel's parts say how they are read from its columns."""
    parts, settings = simulation.parts, simulation.settings
    low, high = settings.window_steps
    over = {"steps": float(high - low), "time": (high - low) * settings.step, "one": 1.0}
    over["groups"] = float(_groups_in(settings))
    column = dict(zip(parts.columns, rows.T, strict=True))
    found: Samples = {}
    for reading in parts.readings:
        whole = sum((factor * column[name] for name, factor in reading.above.items()), np.zeros(len(rows)))
        if reading.over in over:
            values = whole**reading.power / over[reading.over] + reading.added
            found[reading.name] = float(values.mean()), values
        else:
            found[reading.name] = ratio(whole, column[reading.over])
    damped = sum((factor * column[name] for name, factor in parts.damped.items()), np.zeros(len(rows)))
    damped = damped / over["steps"] + parts.taken_at_once
    taken = {name: (column[f"{name} loss"], column[f"{name} momentum"]) for name in parts.struck}
    balance = _balance(parts, column, damped, taken, over["time"], 1.0)
    return _possible(simulation, found | {name: (float(values.mean()), values) for name, values in balance.items()})


def _balance(
    parts: Parts | PartsOfSeveral,
    column: dict[str, Floats],
    damped: Floats,
    taken: dict[str, tuple[Floats, Floats]],
    time: float,
    mass: float,
) -> dict[str, Floats]:
    """The powers of forces with a name, the input power, and what the balance of energy leaves."""
    works = {named: column[f"work of {named.name}"] / time for named in parts.named}
    none = np.zeros(damped.size)
    walls = sum((energy for energy, _ in taken.values()), none)
    gained = (column["energy_last"] - column["energy_first"]) / time
    # what noise whose increments are independent must have fed in
    fed = damped + walls / time + gained
    fed = fed - sum((work for named, work in works.items() if named.does != "expected"), none)
    if isinstance(parts.wall, Soft):
        fed = fed - (column["contacts' work"] + walls) / time
    multiplied = sum((work for named, work in works.items() if named.does == "expected"), none)
    expected = supplied = parts.expected_power + float(multiplied.mean())
    total, found = fed, {}
    for named, work in works.items():
        if named.does == "feeds":
            supplied, total = supplied + abs(float(work.mean())), total + work
        if named.does in ("feeds", "works", "dissipates"):
            found[f"{named.name}_power"] = (-mass if named.does == "dissipates" else mass) * work
    found["input_power"] = mass * total
    if expected > 0.0:  # without such noise the balance is an identity, and no check
        found["energy_residual"] = (parts.expected_power + multiplied) / supplied - fed / supplied
    elif not any(named.does in ("feeds", "works") for named in works):
        found["energy_residual"] = residual(fed, 0.0, column["energy_first"] / time)
    return found


def has_damping(system: System) -> bool:
    """Whether the sums of springpots, dashpots, arms and circuits are of anything."""
    linear = (part.dissipates and part.is_linear and "damping" in part.powers for part in system.parts)
    return bool(system.damping) or any(linear)


def _at_walls(system: System, column: dict[str, Floats]) -> dict[str, tuple[Floats, Floats, Floats]]:
    """Impacts, speeds and squares of each wall and contact, by its name."""
    whole = column["impacts"], column["impact_speeds"], column["impact_speed_squares"]
    contacts, found, left = itertools.count(), {}, ""
    for name, part in system.named():
        if isinstance(part, SoftStop):
            found[name] = _sums(column, f"contact {next(contacts)}")
        elif isinstance(part, Barrier) and part.side == "below" and "upper impacts" in column:
            found[name] = _sums(column, "upper")
        elif isinstance(part, Barrier):  # its impacts are what is left of all
            left = name
    if left:
        for other in [*found.values()]:
            whole = whole[0] - other[0], whole[1] - other[1], whole[2] - other[2]
        found[left] = whole
    return {name: found[name] for name, _ in system.named() if name in found}


def _sums(column: dict[str, Floats], where: str) -> tuple[Floats, Floats, Floats]:
    return column[f"{where} impacts"], column[f"{where} speeds"], column[f"{where} squares"]


def taken_by_walls(system: System, column: dict[str, Floats]) -> dict[str, tuple[Floats, Floats]]:
    """Energy and momentum that each wall and contact took, by its name; of a wall also the momentum at rest."""
    contacts, struck = itertools.count(), _at_walls(system, column)
    taken = {}
    for name, part in system.named():
        if not isinstance(part, Stop):
            continue
        if not isinstance(part, Barrier):
            where = f"contact {next(contacts)}"
            taken[name] = column[f"{where} loss"], column[f"{where} momentum"]
            continue
        # a lone wall is the lower one in the kernel
        where = "upper" if part.side == "below" and "upper impacts" in column else "lower"
        if callable(part.restitution):
            loss, momentum = column[f"{where} loss"], column[f"{where} momentum"]
        else:
            _, speeds, squares = struck[name]
            loss, momentum = 0.5 * (1.0 - part.restitution**2) * squares, (1.0 + part.restitution) * speeds
        taken[name] = loss + column[f"{where} rest loss"], momentum + column[f"{where} rest momentum"]
    return taken


def _of_impacts(system: System, column: dict[str, Floats], time: float) -> Samples:
    """Impact speeds, and rate and speed of every wall."""
    if not system.stops:
        return {}
    found = {
        "impact_speed_mean": ratio(column["impact_speeds"], column["impacts"]),
        "impact_speed_mean_square": ratio(column["impact_speed_squares"], column["impacts"]),
    }
    for name, (impacts, speeds, _) in _at_walls(system, column).items():
        found[f"{name}_impact_rate"] = (float(impacts.mean()) / time, impacts / time)
        found[f"{name}_impact_speed_mean"] = ratio(speeds, impacts)
    return found


def _of_circuits(system: System, column: dict[str, Floats], settings: Settings) -> dict[str, Floats]:
    """Mean square voltage of each circuit and current of each coil, and the power that all deliver."""
    if system.of(ThermalNoise):  # the noise of its resistor is beside the mode, in the matched force
        return {}
    instants = _groups_in(settings)
    found, harvested = {}, np.zeros(column["x"].size)
    for name, part in system.named():
        if isinstance(part, Circuit):
            for what in ("voltage", "current"):
                if (tapped := f"{what} of {name}") in column:
                    found[f"{name}_{what}_mean_square"] = column[tapped] / instants * system.inertia
            if part.of_load == "current" and (count := system.counts.get(name)):
                found[f"{name}_current_of_one_mean_square"] = found[f"{name}_current_mean_square"] / count**2
            harvested = harvested + found[f"{name}_{part.of_load}_mean_square"] / part.load
    return {**found, "harvested_power": harvested} if found else {}


def _groups_in(settings: Settings) -> int:
    """Groups of steps whose end is in the window; at least 1."""
    low, high = settings.window_steps
    return max(high // GROUP - low // GROUP, 1)


def _of_contacts(parts: Parts | PartsOfSeveral, column: dict[str, Floats], time: float) -> dict[str, Floats]:
    if not isinstance(parts.wall, Soft):
        return {}
    return {"contact_share": column["contacts' time"] / time, "contact_penetration": column["contacts' depth"]}


def errors_of_the_start(plan: Plan, values: dict[str, float]) -> dict[str, float]:
    """Standard error of each value due to the sampling error of an adapted x(0), which is the same for all paths.

    Where pilots have measured how results change with x(0), it is that times the error of x(0), which hardly fades.

    Otherwise an x(0) that is off by d leaves the force C d t^-alpha / Gamma(1 - alpha), here taken where the window
    begins.  By simulation it moves mean, impact rate and speeds by less than that over Omega^2, relative to the root
    mean square displacement, and energies by less than half of it (at alpha = 0.1, c = 1: 0.47 of it for the rate, 0.2
    for <v^2>).
    """
    error, motion = plan.adapted.error if plan.adapted else None, plan.motion
    if plan.adapted is None or error is None or not error > 0.0:
        return dict.fromkeys(values, 0.0)
    if plan.adapted.slopes:
        known = {name: slope * error for name, slope in plan.adapted.slopes.items() if math.isfinite(slope)}
        usual = {name: error * abs(value) for name, value in values.items()}
        return {name: {**usual, **known, "energy_residual": 0.0}[name] for name in values}
    left = motion.left_of_start(error, plan.settings.window[0])
    share = error if left is None else left
    errors = {}
    for name, value in values.items():
        energy = any(of in name for of in _ENERGIES) or name.startswith(("amplitude", "damping"))
        errors[name] = (0.5 if energy else 1.0) * share * abs(value)
    for name in motion.mean_names:
        size = math.sqrt(motion.square_about_origin(values, name))
        errors |= dict.fromkeys((name, f"{name}_end"), share * size)
    if "x_mean_square" in values:
        size = math.sqrt(motion.square_about_origin(values))
        errors["damping_force_mean"] = share * plan.system.inertia * motion.scales.frequency**2 * size
    errors["energy_residual"] = 0.0
    return {name: errors[name] for name in values}
