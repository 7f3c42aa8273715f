"""When a run warns: of each reason to doubt a number, and of each argument without effect.

The sentences are in `springpot.problem.messages`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, per_cent
from springpot.problem.messages import Message, say
from springpot.problem.parts.records import FEWEST_SAMPLES
from springpot.simulation.estimate.few_events import Watched, about_few
from springpot.simulation.estimate.settled import change_in_window, left_of_start, rounded_up
from springpot.simulation.estimate.slow_impacts import quantile_step_bias
from springpot.simulation.estimate.step_biases import impact_biases, missed_in
from springpot.simulation.paths.simulation import Simulation
from springpot.simulation.paths.statistics import NORMAL, spread_by_logarithms
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import MOST_TRANSIENT, Plan, default_start
from springpot.simulation.plan.settings import SINGLE_PRECISION
from springpot.simulation.plan.struck import missed_impacts, slow_impact_order
from springpot.theory.walls import about_each

if TYPE_CHECKING:
    from springpot.simulation.error.reach import Reached
    from springpot.simulation.watch.distributions import Distribution

Values = Mapping[str, float]

FAR_OFF = 5.0  # standard errors beyond which a mean that should be 0 gives a warning
MOST_LEFT = 0.01  # of a start, in a mean over its root mean square
MOST_REMEMBERED = 0.03  # mean force of the memory over the springs', in the window
FEWEST_POINTS = 2.2  # of a record in a period, with which it may have what moves the mass
MOST_MISSED = 0.01  # of the impacts, by estimate
MOST_SHAPED = 0.005  # of the linear mean squares, changed by a filter
LEAST_BIAS = 0.01  # of a quantile; a smaller one gives no warning
FEW_PATHS = 0.2  # relative error of the standard error of a damage
MOST_LACKING = 0.02  # of a mean square force: twice that of a quantile


def doubts(
    simulation: Simulation,
    values: Values,
    errors: Values,
    rows: Floats,
    seen: Watched,
    *,
    bounded: bool = False,
    counted: bool = False,
) -> list[Message]:
    """One message for each reason to doubt a number of a run.

    ``bounded``: the total errors include those of step and transient, so these give no warning; ``counted``: impacts
    that are not slower than a speed are counted, which is what may be done where all of them have no rate.
    """
    system = simulation.motion.system
    moments = [value for name, value in values.items() if name.endswith(("x_mean_square", "v_mean_square"))]
    if not all(map(math.isfinite, moments)):
        cause = ": a much finer step may help."
        if own := system.with_functions:
            cause = f": the function of {listed(own, 'or')} returns no number, or the step is too long."
        return [say("not_finite", cause=cause)]
    plan, settings, motion, step = simulation.plan, simulation.settings, simulation.motion, simulation.settings.step
    found = list[Message]()
    size, speed = (math.sqrt(max(values.get(f"{of}_mean_square", 0.0), 0.0)) for of in "xv")  # of one mass
    if settings.scheme == "grunwald" and motion.walls and settings.contact_tolerance > 1e-3 * size:
        found.append(say("contact_tolerance", tolerance=settings.contact_tolerance, size=size, most=1e-4 * size))
    if not counted and (reason := motion.uncountable):
        walls = [name.removesuffix("_") for name in motion.uncounted if name]
        every = len(motion.uncounted) > len(motion.touched)  # of one mass also all together
        found.append(say("uncountable_impacts", of=_of([] if every else walls), reason=reason))
    found += [*_about_shapes(motion), *_about_records(motion)]
    if not bounded:
        found += _about_springpot_alone(simulation, values)
        fastest = motion.scales.fastest_rate if motion.pressed else motion.resolved_rate  # of hops a warning of its own
        limit, ratio = settings.numerical_scheme.coarsest_step, step * fastest
        if ratio > limit * (1.0 + 1e-9):
            name = "coarse_step_of_transients" if plan.keeps_the_law else "coarse_step"
            found.append(say(name, step=step, ratio=ratio, limit=limit, most=limit / fastest))
        for name, wall in motion.pressed.items() if speed > 0.0 else ():
            if (turned := wall.turned(step, speed)) > wall.most_turned:
                found.append(say(
                    "coarse_hops", wall=name, step=step, turned=turned, low=per_cent(wall.lacking(step, speed)),
                    press=wall.acceleration, speed=speed, most=step * wall.most_turned / turned,
                ))  # fmt: skip
        found += _about_window(simulation)
    found += _about_start(simulation, values, errors)
    if not bounded and plan.transient_left <= MOST_TRANSIENT:  # no transient is known that says of it
        change = change_in_window(simulation, rows)
        found += [] if change is None else [change.said]
    residual, error = values.get("energy_residual", 0.0), errors.get("energy_residual", math.nan)
    supplied = values.get("input_power", 0.0) * (plan.settings.window[1] - plan.settings.window[0])
    # with a large energy the rounding of single-precision memory shows, and is accepted
    floor = max(0.01, 1e-4 * motion.usual_energy(values) / supplied) if supplied > 0.0 else 0.01
    if math.isfinite(error) and abs(residual) > max(FAR_OFF * error, floor):
        found.append(say("energy_balance", share=per_cent(residual), error=per_cent(error, 1)))
    found += _about_memory(simulation, values, errors)
    found += [] if bounded else _about_slow_impacts(simulation, values)
    rates = {name: values[f"{name}_impact_rate"] for name in motion.touched}
    odd = about_each(motion.touched, motion.motions_before_walls(values), rates)
    found += odd.values()
    if motion.is_random:
        found += about_few(seen, (name for name, rate in rates.items() if math.isfinite(rate) and name not in odd))
    # steps in which the kernel did not follow every impact; on a circle what it leaves out are hops of no size
    collapses, halts = (int(simulation.parts.sums(rows)["limit", own].sum()) for own in ("collapses", "halts"))
    if not simulation.parts.tables.count("turns") and collapses:
        found.append(say("impacts_limited", count=collapses, halted=halts))
    return found


def _about_shapes(motion: Motion) -> Iterator[Message]:
    """Of filters that change the linear response, in a potential: it lies where a density begins or ends."""
    if not motion.system.densities or motion.potential is None:
        return
    from springpot.simulation.lowering.shaping import moments_off, shape_of  # SciPy is slow to import

    unit = motion.unit
    stiffness = unit.stiffness if unit.stiffness > 0.0 else motion.scales.frequency**2
    for name, part in unit.densities.items():
        shape = shape_of(part, name)
        x, v = moments_off(part, shape, unit, stiffness)
        if max(abs(x), abs(v)) > MOST_SHAPED:
            yield say("shaped_density", name=name, x=per_cent(x), v=per_cent(v), worst=per_cent(shape.worst))


def _about_records(motion: Motion) -> Iterator[Message]:
    """Of records with few points in a period of the motion, of several masses of the slowest mode."""
    for name, part in motion.system.records.items():
        rate = min((len(time) - 1) / (time[-1] - time[0]) for time, _ in part.records)
        points = 2.0 * math.pi * rate / motion.scales.frequency
        lost = 1.0 - float(np.sinc(1.0 / points)) ** 2
        if points < FEWEST_POINTS:
            fate = "what a signal has at half of its sampling rate and above is not in its samples"
        elif part.interpolation == "linear" and lost > LEAST_BIAS and len(part.records[0][0]) >= FEWEST_SAMPLES:
            fate = f"straight lines between samples of a signal lose {per_cent(lost)} of its amplitude there, and more "
            fate += "at faster modes; interpolation='band-limited' does not"
        else:
            continue
        yield say("coarse_record", name=name, points=points, frequency=rate / points, fate=fate)


def _about_springpot_alone(simulation: Simulation, values: Values) -> Iterator[Message]:
    """Of a start that masses without a spring remember long."""
    motion, begin = simulation.motion, simulation.plan.settings.window[0]
    if not motion.held_by or motion.not_stationary or not begin > 0.0:
        return
    order = min(springpot.order for springpot in motion.held_by)
    missing = {name: value for creep in motion.slow for name, value in creep.missing(begin).items() if name in values}
    shares = {name: value / (value + values[name]) for name, value in missing.items() if value > 0.0}
    name, left = max(shares.items(), key=lambda item: item[1], default=("", 0.0))
    if left > LEAST_BIAS:
        later = begin * (left / LEAST_BIAS) ** (1.0 / (1.0 - 2.0 * order))
        yield say("springpot_holds_alone", name=name, left=per_cent(left), begin=begin, order=order,
                  power=2.0 * order - 1.0, later=later)  # fmt: skip


def _about_window(simulation: Simulation) -> Iterator[Message]:
    plan, left = simulation.plan, simulation.plan.transient_left
    if plan.motion.recorded or left <= MOST_TRANSIENT:
        return
    if reason := plan.motion.not_stationary:
        yield say("no_stationary_state", reason=reason)
    else:
        start, times = plan.settings.start, -math.log(MOST_TRANSIENT)
        waiting = plan.motion.waiting_time(start) > plan.motion.scales.relaxation_time
        cause = f" (of {listed(plan.motion.loose_points)}, which only walls hold)" if waiting else ""
        later = rounded_up(plan.motion.settled_after(start, times))
        yield say("transient_in_window", begin=plan.settings.window[0], left=per_cent(left), cause=cause, later=later)


def _about_start(simulation: Simulation, values: Values, errors: Values) -> Iterator[Message]:
    """Of a stationary start without pilots, and of any that still acts: the run itself tells how far it was off."""
    plan, adapted = simulation.plan, simulation.plan.adapted
    if adapted is not None and adapted.residual is None:
        yield say("unchecked_start")
    settled = not plan.motion.not_stationary and plan.energy_left <= MOST_TRANSIENT
    if not settled or (adapted is None and "damping_force_mean" in values):  # that force tells of it
        return
    left = [
        each for each in left_of_start(plan, values, errors)
        if each.off > MOST_LEFT and each.off > FAR_OFF * each.error
    ]  # fmt: skip
    if left:
        worst = max(left, key=lambda each: each.off)
        off, error = per_cent(worst.off), per_cent(worst.error, 1)
        yield say("start_was_off", name=f"{worst.name}_mean", off=off, error=error, order=worst.order)


def _about_memory(simulation: Simulation, values: Values, errors: Values) -> Iterator[Message]:
    """Of a start that still acts through the memory: its mean force is then not 0."""
    motion, error = simulation.motion, errors.get("damping_force_mean", math.nan)
    if not motion.springpots or motion.not_stationary or simulation.plan.transient_left > MOST_TRANSIENT:
        return
    if not math.isfinite(error):
        return
    stiffness = motion.system.inertia * motion.scales.frequency**2
    away = motion.square_about_origin(values) ** 0.5 if motion.scales.guessed else abs(values["x_mean"] - motion.origin)
    size = stiffness * away
    force = abs(values.get("damping_force_mean", 0.0))
    if force > max(FAR_OFF * error, MOST_REMEMBERED * size):
        yield say(
            "memory_of_start",
            share=per_cent(force / size),
            order=min(springpot.order for springpot in motion.springpots),
        )


def _about_slow_impacts(simulation: Simulation, values: Values) -> Iterator[Message]:
    """Of a step that misses more than MOST_MISSED of the impacts."""
    motion, step, rate = simulation.motion, simulation.settings.step, values.get("impact_rate", 0.0)
    bounds = impact_biases(motion, step, dict(values))
    each = {name: [of.get(f"{name}_impact_rate", 0.0) for of in (bounds, values)] for name in motion.struck_alone}
    off = {name: alone for name, alone in each.items() if alone[0] > MOST_MISSED * alone[1] > 0.0}
    if off:
        worst = max(off.values(), key=lambda alone: alone[0] / alone[1])
        yield say("slow_impacts_of_some_wall", of=_of([*off]), low=_low(*worst), step=step)
    bound = bounds.get("impact_rate", 0.0)
    if not bound > 0.0 or not rate > 0.0:
        return
    missed = missed_impacts(motion.struck, step, values["impact_speed_mean_square"])
    order = slow_impact_order(motion.struck.restitution)
    if motion.struck.crowded and missed > MOST_MISSED:
        high = per_cent(missed / (1.0 - missed))
        yield say("slow_impacts", low=per_cent(missed), high=high, step=step, order=order)
    elif not motion.struck.crowded and bound > MOST_MISSED * rate:
        yield say("slow_impacts_of_some_wall", of="", low=_low(bound, rate), step=step)


def _of(walls: Sequence[str]) -> str:
    """Whose impacts they are, where each wall has its own."""
    return f" of {listed(walls)}" if any(walls) else ""


def _low(bound: float, rate: float) -> str:
    return f"may be {per_cent(bound / rate)} too low" if bound < rate else "is far too low"


def about_uncontrolled_impacts(reached: Reached, rtol: float) -> list[Message]:
    """Of large errors of impact rate and speed in a run with ``rtol`` that does not control them."""
    walls = [
        f"{wall}_" for wall in reached.simulation.parts.walls if not reached.simulation.parts.tables.count("forced")
    ] or [""]
    left = {
        name: reached.budgets[name].total / abs(reached.values[name])
        for name in (f"{wall}{of}" for wall in walls for of in ("impact_rate", "impact_speed_mean"))
        if name not in reached.wanted and name in reached.budgets and reached.values.get(name, 0.0) != 0.0
    }
    off = [f"{name} {per_cent(share)}" for name, share in left.items() if share > max(3.0 * rtol, 2.0 * MOST_MISSED)]
    return [say("uncontrolled_impacts", off=", ".join(off))] if off else []


def about_observables(names: Iterable[str], values: Values) -> list[Message]:
    """Of observables without a finite value."""
    return [say("observable_not_finite", name=name) for name in names if not math.isfinite(values[name])]


def about_damage(counted: Mapping[str, tuple[float, Floats]]) -> Iterator[Message]:
    """Of damage whose standard error is not known to a fifth: it is that of a few paths with the largest cycles.

    This depends on the fourth moment of the samples; and as most groups of 60 paths have none of those that matter with
    an exponent of 7, on that of the law whose logarithms spread as theirs, which is too large where many cycles add up.
    """
    for name, (mean, damage) in counted.items():
        apart = damage - mean
        variance = float((apart**2).mean())
        if "_damage_rate" not in name or damage.size < 2 or not variance > 0.0:
            continue
        usual = 1.0 + spread_by_logarithms(damage) ** 2
        fourths = float((apart**4).mean()) / variance**2, usual**4 + 2.0 * usual**3 + 3.0 * usual**2 - 3.0
        seen, unseen = (0.5 * math.sqrt(max(fourth - 1.0, 0.0) / damage.size) for fourth in fourths)
        off = max(seen, unseen)
        if seen > FEW_PATHS or unseen > 2.0 * FEW_PATHS:
            share = per_cent(float(damage.max()) / (mean * damage.size))
            yield say("damage_of_few_paths", name=name, share=share, paths=damage.size, off=per_cent(off))


def about_forces(simulation: Simulation, names: Iterable[str], values: Values) -> Iterator[Message]:
    """Of forces and accelerations whose means over a step are smaller than they are.

    Parameters
    ----------
    names : iterable of str
        Of which more than moments is wanted.
    """
    for name in names:
        lacking, whole = simulation.parts.outputs.lacking[name], values[f"{name}_mean_square"]
        if lacking > MOST_LACKING * whole:
            yield say("force_over_steps", name=name, share=per_cent(lacking / whole))


def about_options(plan: Plan, given: Mapping[str, Any]) -> list[Message]:
    """Of a start from rest that the user did not choose, and of each argument that changes nothing.

    Parameters
    ----------
    plan : Plan
    given : dict
        The arguments that the user gave, without defaults.

    Returns
    -------
    list of Message

    Examples
    --------
    >>> from springpot.problem.oscillator import Oscillator
    >>> from springpot.simulation.plan.plan import plan_of
    >>> print(*about_options(plan_of(Oscillator()), {"contact_tolerance": 1e-4}))
    contact_tolerance has no effect without scheme='grunwald'.
    """
    motion = plan.motion
    _, reason = default_start(motion, given)
    useless = {}
    if "contact_tolerance" in given and given.get("scheme", "default") != "grunwald":
        useless["contact_tolerance"] = " without scheme='grunwald'"
    elif "contact_tolerance" in given and not motion.walls:
        useless["contact_tolerance"] = " without a wall"
    if "derivative" in given and not any(springpot.order > 0.0 for springpot in motion.system.springpots.values()):
        useless["derivative"] = ": no springpot has an order above 0"
    elif given.get("derivative") == "riemann-liouville" and plan.settings.initial_position == 0.0:
        useless["derivative='riemann-liouville'"] = " with x(0) = 0: both derivatives are the same"
    if motion.recorded and 0 < motion.different_paths < given.get("paths", 0):
        other = "all paths are alike" if motion.different_paths == 1 else "there is one path for each record"
        useless["paths"] = f" beyond {motion.different_paths}: without noise {other}"
    # a smaller tolerance also means double precision, so it has an effect
    if not motion.remembers and given.get("memory_tolerance", 0.0) >= SINGLE_PRECISION:
        useless["memory_tolerance"] = ": no part has memory"
    from_rest = [say("starts_from_rest", reason=reason)] if given.get("start") is None and reason else []
    return from_rest + [say("no_effect", argument=argument, why=why) for argument, why in useless.items()]


def about_quantiles(
    simulation: Simulation, distributions: Mapping[str, Distribution], probability: Sequence[float]
) -> Iterator[Message]:
    """Of quantiles of impact speeds whose step bias is larger than their standard error."""
    step = simulation.settings.step
    for name, (speeds, missed) in missed_in(simulation.motion, step, distributions).items():
        at, error = speeds.quantile(probability)
        bias = quantile_step_bias(missed, speeds, probability)
        off = (bias > NORMAL * error) & (bias > LEAST_BIAS * at)  # False where there is no error
        named = [
            f"{per_cent(p, 3)} (by up to {per_cent(b / x)})"
            for p, b, x in zip(np.asarray(probability)[off], bias[off], at[off], strict=True)
        ]
        if named:
            of = _of([name.removesuffix("impact_speed").removesuffix("_")])
            yield say("slow_impact_quantiles", step=step, of=of, name=name, quantiles=", ".join(named))
