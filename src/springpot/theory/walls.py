"""What is said of a wall that is never reached, always pressed against, or struck all the time: often a slip."""

from __future__ import annotations

import math
from collections.abc import Mapping

from springpot.problem.messages import Message, say
from springpot.problem.parts import Barrier
from springpot.problem.system import System

FAR = 8.0  # standard deviations of x between its mean and a wall
NEVER = 1e-6  # impacts in a natural period, at most, of a wall that is far
PRESSED = 8.0  # force on a wall over that of the springs at a usual amplitude, Omega times the root mean square of v
CLOSE = 3.0  # standard deviations between the mean of x and a wall that is pressed against, at most
CHATTER = 20.0  # impacts in a natural period


def about_walls(
    system: System, x_mean: float, x_mean_square: float, v_mean_square: float, rates: Mapping[str, float]
) -> dict[str, Message]:
    """One sentence at most for each wall, by its name.

    Parameters
    ----------
    system : System
    x_mean, x_mean_square, v_mean_square : float
        By theory or Monte Carlo.
    rates : dict
        The impact rate of each wall, as far as it is known.

    Returns
    -------
    dict

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> about_walls(System(Spring(1.0), Barrier(-400.0)), 0.0, 0.25, 0.25, {"barrier": 0.0})["barrier"][:60]
    'barrier at -400 m is 800 standard deviations of x away from '
    """
    spread = math.sqrt(max(x_mean_square - x_mean**2, 0.0))
    if not (0.0 < spread < math.inf and 0.0 < v_mean_square < math.inf):
        return {}
    speed = math.sqrt(v_mean_square)
    omega = system.natural_frequency
    period = 2.0 * math.pi / (omega if omega > 0.0 else speed / spread)
    said: dict[str, Message] = {}
    for name, wall in system.stops.items():
        away = wall.inwards * (x_mean - wall.position) / spread
        struck = rates.get(name, math.nan) * period
        # of the force per mass with which the springs press on a wall from inside
        pressing = wall.inwards * float(system.potential.force(wall.position))
        push = pressing / (omega * speed) if isinstance(wall, Barrier) and omega > 0.0 else 0.0
        words = f"{name} at {wall.position:g} m"
        if away > FAR and not struck > NEVER:
            said[name] = say("far_wall", wall=words, away=away)
        elif push > PRESSED and away < CLOSE:
            said[name] = say("pressed_wall", wall=words, spread=spread)
        elif struck > CHATTER:
            said[name] = say("chatter", wall=words, rate=rates[name], often=struck)
    return said
