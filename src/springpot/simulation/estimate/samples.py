"""From the kernel's sums to results: moments, impacts of every wall, and powers of every part, with standard errors."""

from __future__ import annotations

import math

import numpy as np

from springpot.machine.arrays import Floats
from springpot.problem.catalogue import possible_results
from springpot.simulation.estimate.few_events import Watched, errors_of_unseen
from springpot.simulation.kernel.sizes import GROUP
from springpot.simulation.lowering.compose import Parts, Sum
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.statistics import ratio, residual, standard_error
from springpot.simulation.plan.plan import Plan

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
    sums = simulation.parts.sums(rows)
    at_walls = {wall: sums["impacts", wall] for wall in simulation.parts.walls}
    of_all = at_walls and "impact_rate" in possible_results(simulation.motion.system)
    whole = {"": sum(at_walls.values(), np.zeros(len(rows)))} if of_all else {}
    low, high = simulation.settings.window_steps
    time = len(rows) * (high - low) * simulation.settings.step
    return Watched({**whole, **at_walls}, time)


def samples_of(simulation: Simulation, rows: Floats) -> Samples:
    """Each estimate with its samples, one per path; its mean is that of the samples (ratios are linearized).

    They are in the order of the catalogue, and NaN where they are of impacts that cannot be counted.  Differences and
    sums of samples from the same paths give the standard errors of differences and sums.

    Parameters
    ----------
    simulation : Simulation
    rows : ndarray, shape (paths, columns of the parts)
        Of `Simulation.advance`.
    """
    parts, settings = simulation.parts, simulation.settings
    low, high = settings.window_steps
    over = {"steps": float(high - low), "time": (high - low) * settings.step, "one": 1.0}
    over["groups"] = float(max(high // GROUP - low // GROUP, 1))  # groups of steps whose end is in the window
    sums, none = parts.sums(rows), np.zeros(len(rows))
    found: Samples = {}
    for reading in parts.readings:
        whole = sum((factor * sums[own] for own, factor in reading.above.items()), none)
        if isinstance(reading.over, tuple):
            found[reading.name] = ratio(whole, sum((sums[own] for own in reading.over), none))
            continue
        values = whole**reading.power + sum(factor * sums[own] ** 2 for own, factor in reading.squares.items())
        values = values / over[reading.over] + reading.added
        found[reading.name] = float(values.mean()), values
    damped = sum((factor * sums[own] for own, factor in parts.damped.items()), none)
    balance = _balance(parts, sums, damped / over["steps"] + parts.taken_at_once, over["time"])
    found |= {name: (float(values.mean()), values) for name, values in balance.items()}
    motion, undefined = simulation.motion, (math.nan, np.full(len(rows), np.nan))
    found |= {name: undefined for name in found if motion.uncounted_because(name)}
    return {name: found[name] for name in possible_results(motion.system) if name in found}


def _balance(parts: Parts, sums: dict[Sum, Floats], damped: Floats, time: float) -> dict[str, Floats]:
    """The powers of forces with a name, the input power, and what the balance of energy leaves."""
    works = {named: sums["work", named.name] / time for named in parts.named}
    none = np.zeros(damped.size)
    walls = sum((sums["loss", wall] for wall in parts.walls), none)
    gained = (sums["energy", "last"] - sums["energy", "first"]) / time
    # what noise whose increments are independent must have fed in; the work of that with an envelope is hardly known
    fed = damped + walls / time + gained
    known = "feeds", "works", "dissipates"
    fed = fed - sum((work for named, work in works.items() if named.does in known), none)
    multiplied = sum((work for named, work in works.items() if named.does == "expected"), none)
    expected = supplied = parts.expected_power + float(multiplied.mean())
    total, found = fed, {}
    for named, work in works.items():
        if named.does == "feeds":
            supplied, total = supplied + abs(float(work.mean())), total + work
        if named.does in known:
            found[f"{named.name}_power"] = -work if named.does == "dissipates" else work
    found["input_power"] = total
    if expected > 0.0:  # without such noise the balance is an identity, and no check
        found["energy_residual"] = (parts.expected_power + multiplied) / supplied - fed / supplied
    elif not any(named.does in ("feeds", "works") for named in works):
        found["energy_residual"] = residual(fed, 0.0, sums["energy", "first"] / time)
    return found


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
