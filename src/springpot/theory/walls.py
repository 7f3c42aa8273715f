"""What is said of a wall that is never reached, always pressed against, or struck all the time: often a slip."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from springpot.problem.messages import Message, say
from springpot.problem.parts.walls import Stop
from springpot.problem.system import System

FAR = 8.0  # standard deviations of x between its mean and a wall
NEVER = 1e-6  # impacts in a natural period, at most, of a wall that is far
PRESSED = 8.0  # force on a wall over that of the springs at a usual amplitude, Omega times the root mean square of v
CLOSE = 3.0  # standard deviations between the mean of x and a wall that is pressed against, at most
CHATTER = 20.0  # impacts in a natural period


@dataclass(frozen=True)
class Before:
    """The displacement that a wall bounds, as it is without regard to that wall's impacts.

    Attributes
    ----------
    name : str
        Of the displacement.
    mean, spread, speed : float
        Its mean and standard deviation, and the root mean square of its velocity, in m and m/s.
    frequency : float
        Of its free motion, in rad/s; 0 where no spring holds it.
    press : float
        The acceleration in m/s^2 with which springs press it on the wall; negative where they pull it away.
    """

    name: str
    mean: float
    spread: float
    speed: float
    frequency: float
    press: float


def about_wall(name: str, wall: Stop, before: Before, rate: float) -> Message | None:
    """One sentence at most; ``rate`` is that of its impacts, NaN where it is not known."""
    if not (0.0 < before.spread < math.inf and 0.0 < before.speed < math.inf):
        return None
    period = 2.0 * math.pi / (before.frequency if before.frequency > 0.0 else before.speed / before.spread)
    away, struck = wall.inwards * (before.mean - wall.position) / before.spread, rate * period
    held = wall.soft_stop is None and before.frequency > 0.0
    words = f"{name} at {wall.position:g} m"
    if away > FAR and not struck > NEVER:
        return say("far_wall", wall=words, away=away, x=before.name)
    if held and before.press > PRESSED * before.frequency * before.speed and away < CLOSE:
        return say("pressed_wall", wall=words, spread=before.spread, x=before.name)
    return say("chatter", wall=words, rate=rate, often=struck) if struck > CHATTER else None


def about_walls(
    system: System, x_mean: float, x_mean_square: float, v_mean_square: float, rates: Mapping[str, float]
) -> dict[str, Message]:
    """One sentence at most for each wall, by its name.

    Parameters
    ----------
    system : System
        Of one mass.
    x_mean, x_mean_square, v_mean_square : float
        By theory or Monte Carlo.
    rates : dict
        The impact rate of each wall, as far as it is known.

    Returns
    -------
    dict

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> about_walls(System(Spring(1.0), Barrier(-400.0)), 0.0, 0.25, 0.25, {"barrier": 0.0})["barrier"][:60]
    'barrier at -400 m is 800 standard deviations of x away from '
    """
    before = before_walls(system, x_mean, x_mean_square, v_mean_square)
    return about_each(system.stops, before, rates)


def before_walls(system: System, x_mean: float, x_mean_square: float, v_mean_square: float) -> dict[str, Before]:
    """What one mass does before each of its walls and contacts, from its moments; NaN, as of several, is nothing."""
    if math.isnan(x_mean):
        return {}
    spread, speed = math.sqrt(max(x_mean_square - x_mean**2, 0.0)), math.sqrt(max(v_mean_square, 0.0))
    press = {name: wall.inwards * float(system.potential.force(wall.position)) for name, wall in system.stops.items()}
    return {name: Before("x", x_mean, spread, speed, system.natural_frequency, own) for name, own in press.items()}


def about_each(
    stops: Mapping[str, Stop], before: Mapping[str, Before], rates: Mapping[str, float]
) -> dict[str, Message]:
    """One sentence at most for each wall and contact, by its name."""
    said = {name: about_wall(name, stops[name], own, rates.get(name, math.nan)) for name, own in before.items()}
    return {name: message for name, message in said.items() if message is not None}
