"""From a system to what is known of its motion: the one place in the simulation that asks what kind of problem it is.

The scales of the paper's problem have closed forms, those of other systems of one mass are guessed from a balance of
power, and those of several masses from their modes.  Later rooms take what they need from the `Motion`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.machine.arguments import LARGEST
from springpot.machine.faults import NotCoveredError
from springpot.problem.dimensionless import CANONICAL, Dimensionless
from springpot.problem.parts import FractionalMaxwell, Springpot, WhiteNoise
from springpot.problem.system import System, checked_system
from springpot.simulation.plan.creep import Creep
from springpot.simulation.plan.creep_of_several import CreepOfSeveral
from springpot.simulation.plan.guess import (
    BoltzmannLaw,
    dissipated,
    guessed_law,
    guessed_scales,
    rate_on_pressed_walls,
)
from springpot.simulation.plan.modes import modal_scales, modes_of
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.origin import origin_of, seen_from
from springpot.simulation.plan.rest import nearest_to_rest
from springpot.simulation.plan.scales import Scales, closed_form
from springpot.simulation.plan.symmetry import Symmetry
from springpot.simulation.plan.unsprung import creep_of


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
    >>> from springpot.problem.parts import Barrier, Spring, Springpot
    >>> lone = System(Spring(4.0), Springpot(0.5, 0.1), Barrier(0.5, 0.8, "below"), WhiteNoise(2.0))
    >>> motion_of(lone).sign, motion_of(lone).scales.guessed
    (-1.0, False)
    """
    if not checked_system(system).coordinates.lone:
        return _by_modes(system)
    origin = origin_of(system)
    centred = seen_from(system, origin)
    rest = nearest_to_rest(system)
    try:
        paper = Dimensionless.of(centred)
    except NotCoveredError as reason:
        law = guessed_law(centred)
        scales = guessed_scales(centred, law).seen_from(-origin)
        motion = Motion(system, scales, rest, np.array([scales.mean]), beyond_paper=str(reason), guess=law)
        searched = motion.remembers and Symmetry(centred).has_mean(np.ones(1)) and not motion.is_thermal
        alone = creep_of(motion.unit, law.frequency, law.variance)
        return replace(motion, searched=searched, slow=alone or tuple(map(Creep, _alike(motion, law))))
    elastic = paper.barrier is None or paper.restitution == 1.0
    dashpot = paper.springpot.order == 1.0 and paper.springpot.coefficient > 0.0
    scales = _scales_of(paper, centred).seen_from(-origin)
    return Motion(
        system,
        scales,
        rest,
        np.array([scales.mean]),
        sign=paper.direction or 1.0,
        slow=(Creep(paper),),
        searched=paper.barrier is not None,
        keeps_the_law=elastic and dashpot and paper.excitation.intensity > 0.0,
        beyond_paper=f"a constant force cannot be part of an Oscillator: {CANONICAL}." if origin else "",
    )


def _by_modes(system: System) -> Motion:
    """The motion of coordinates of which no one has a potential alone."""
    modes, rest = modes_of(system), nearest_to_rest(system)
    many = f"the paper's problem has one mass, and the system has {len(system.coordinates.names)}."
    motion = Motion(system, modal_scales(system, modes), rest, rest, beyond_paper=many)
    slow = (*motion.springpots, *system.of(FractionalMaxwell))
    if not slow:
        return motion
    rows = {f"{begin}_mean_square": row for begin, row in motion.displacements.items()}
    free = {name: modes.spread(row) ** 2 for name, row in rows.items()}
    return replace(
        motion,
        slow=(CreepOfSeveral(system, modes.stiffness, motion.scales.fastest_rate, rows, free),),
        searched=Symmetry(system).keeps_mean(slow) and not motion.is_thermal,
    )


def _scales_of(paper: Dimensionless, centred: System) -> Scales:
    """In closed form, but for the rate of hops on a wall that the spring presses on."""
    scales = closed_form(paper)
    if paper.barrier is None or paper.direction * paper.barrier.position <= 0.0 or paper.restitution == 1.0:
        return scales
    hops = rate_on_pressed_walls(centred.per_unit_mass, guessed_law(centred))
    return replace(scales, fastest_rate=max(scales.fastest_rate, hops))


def _alike(motion: Motion, law: BoltzmannLaw) -> tuple[Dimensionless, ...]:
    """For each springpot, the paper's problem with its slow displacements: of the frequency and power guessed.

    A thermal system has none: it starts from its stationary law.
    """
    if motion.is_thermal:
        return ()
    taken = min(max(2.0 * dissipated(motion.unit.parts, law), 0.0), LARGEST)
    pots = (pot for pot in motion.unit.of(Springpot) if pot.remembers)
    return tuple(Dimensionless(law.frequency, pot, None, WhiteNoise(taken)) for pot in pots)
