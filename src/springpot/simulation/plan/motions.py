"""From a system to what is known of its motion: the one place in the simulation that asks what kind of problem it is.

The scales of the paper's problem have closed forms, those of other systems of one mass are guessed from a balance of
power, and those of several masses from their modes.  Later rooms take what they need from the `Motion`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import CANONICAL, Dimensionless
from springpot.problem.free_numbers import check_certain
from springpot.problem.system import System, checked_system
from springpot.simulation.plan.creep import Creep
from springpot.simulation.plan.creep_of_paper import CreepOfPaper
from springpot.simulation.plan.guess import (
    OF_HOPS,
    guessed_law,
    guessed_scales,
    rate_on_pressed_walls,
)
from springpot.simulation.plan.loose import springpot_alone
from springpot.simulation.plan.modes import modal_scales, modes_of
from springpot.simulation.plan.motion import Motion, Potential
from springpot.simulation.plan.rest import nearest_to_rest, origin_of, seen_from
from springpot.simulation.plan.scales import closed_form
from springpot.simulation.plan.signals import Signal
from springpot.simulation.plan.symmetry import Symmetry


def motion_of(system: System) -> Motion:
    """What follows from a system alone.

    Raises
    ------
    TypeError
        If it is not a system.
    ValueError
        If nothing holds the mass, or it moves less than numbers can tell.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, Springpot, WhiteNoise
    >>> lone = System(Spring(4.0), Springpot(0.5, 0.1), Barrier(0.5, 0.8, "below"), WhiteNoise(2.0))
    >>> motion_of(lone).sign, motion_of(lone).scales.guessed
    (-1.0, False)
    """
    check_certain(checked_system(system), "a simulation")
    if not system.coordinates.lone:
        return _by_modes(system)
    origin = origin_of(system)
    centred = seen_from(system, origin)
    rest = nearest_to_rest(system)
    try:
        paper = Dimensionless.of(centred)
    except NotCoveredError as reason:
        law = guessed_law(centred)
        scales = guessed_scales(centred, law).seen_from(-origin)
        motion = Motion(system, scales, rest, np.array([scales.mean]), origin, beyond_paper=str(reason),
                        potential=Potential(centred, law))  # fmt: skip
        searched = motion.remembers and Symmetry(centred).has_mean(np.ones(1)) and not motion.is_thermal
        held = 0.0 if springpot_alone(motion.unit) else law.frequency**2
        free = {"x_mean_square": law.variance, "amplitude_mean_square": 2.0 * law.variance}
        return _with_slow(replace(motion, searched=searched), np.array([[system.inertia * held]]), free)
    elastic = paper.barrier is None or paper.restitution == 1.0
    dashpot = paper.springpot.order == 1.0 and paper.springpot.coefficient > 0.0
    scales = closed_form(paper)
    pressed = paper.barrier is not None and paper.direction * paper.barrier.position > 0.0
    if pressed and not elastic:  # but for the rate of hops on a wall that the spring presses on
        hops = rate_on_pressed_walls(centred.per_unit_mass, guessed_law(centred))
        scales = replace(scales, fastest_rate=max(scales.fastest_rate, OF_HOPS * hops), resolved_rate=hops)
    scales = scales.seen_from(-origin)
    return Motion(
        system,
        scales,
        rest,
        np.array([scales.mean]),
        origin,
        sign=paper.direction or 1.0,
        slow=(CreepOfPaper(paper),),
        searched=paper.barrier is not None,
        keeps_the_law=elastic and dashpot and paper.excitation.intensity > 0.0,
        beyond_paper=f"a constant force cannot be part of an Oscillator: {CANONICAL}." if origin else "",
        potential=Potential(centred),
    )


def near_motion_of(system: System, other: Motion) -> Motion:
    """That of a system with almost the numbers of another, with the scales of that one.

    The kernel takes its units and the circle of its drift from them.  Guesses take most of the time of `motion_of`.
    """
    if other.potential is None:
        return motion_of(system)
    origin = origin_of(system)
    potential = replace(other.potential, system=seen_from(system, origin))
    return replace(other, system=system, rest=nearest_to_rest(system), origin=origin, potential=potential)


def _by_modes(system: System) -> Motion:
    """The motion of coordinates of which no one has a potential alone."""
    modes, rest = modes_of(system), nearest_to_rest(system)
    many = f"the paper's problem has one mass, and the system has {len(system.coordinates.names)}."
    motion = Motion(system, modal_scales(system, modes), rest, rest, beyond_paper=many)
    searched = Symmetry(system).keeps_mean and not motion.is_thermal
    free = {f"{begin}_mean_square": modes.spread(row) ** 2 for begin, row in motion.displacements.items()}
    return _with_slow(replace(motion, searched=searched), system.coordinates.sum_of(modes.stiffness), free)


def _with_slow(motion: Motion, stiffness: Floats, free: dict[str, float]) -> Motion:
    """With the slow displacements of its springpots; ``free`` are mean squares without walls, about."""
    if not any(part.creeps for part in motion.system.parts):
        return motion
    system, rows = motion.system, motion.system.coordinates.elongations
    shaken = {name: math.hypot(*motion.size_of(Signal(row=rows[name]))[:2]) for name in system.multiplied}
    seen = {f"{begin}_mean_square": row for begin, row in motion.displacements.items()}
    return replace(motion, slow=(Creep(system, stiffness, motion.scales.fastest_rate, seen, free, shaken),))
