"""The place from which one mass is measured, so that constant forces act in the exact flight between kicks.

A linear spring under a constant force is the same spring with another rest.  Seen from there the force is gone: a
weight above a floor and a preload are one problem, with one step and the same bits where the shift has no rounding.
Springpots and other memory follow changes of x only, which a shift leaves as they are.
"""

from __future__ import annotations

from springpot.problem.system import System


def origin_of(system: System) -> float:
    """The rest of the springs under the constant forces, in m; 0 where these stay beside the flight.

    They do without a linear spring, and with parts of which a shift would make another law.

    Examples
    --------
    >>> from springpot.problem.parts import Constant, PolynomialSpring, Spring
    >>> springs = Spring(4.0), PolynomialSpring((4.0, 0.0, 1.0))
    >>> [origin_of(System(spring, Constant(-9.0))) for spring in springs]
    [-2.25, 0.0]
    """
    if not system.constants or any(part.is_placed for part in system.parts):
        return 0.0
    forces = [part.force_coefficients() for _, part in system.named()]
    pulled, stiffness = (sum(force[n] for force in forces if n < len(force)) for n in (0, 1))
    linear = not any(any(force[2:]) for force in forces)
    return -pulled / stiffness + 0.0 if linear and stiffness > 0.0 else 0.0


def seen_from(system: System, origin: float) -> System:
    """The same motion as a function of x - origin, which is that of `origin_of`: without the constant forces.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Constant, Spring
    >>> seen_from(System(Spring(4.0), weight=Constant(-9.0), floor=Barrier(0.0, 0.5)), -2.25)
    System(Spring(stiffness=4.0), floor=Barrier(position=2.25, restitution=0.5, free_side='above'))
    """
    if origin == 0.0:
        return system
    return System(**{name: part.seen_from(origin) for name, part in system.named() if name not in system.constants})
