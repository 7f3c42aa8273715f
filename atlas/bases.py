"""What the atlas interpolates Monte Carlo over: oscillators of order 1 that stand for the one with memory.

An oscillator of order 1 has exact answers behind an elastic wall and those of the Fokker-Planck equation behind a lossy
one.  The better it stands for the one with memory, the flatter is what Monte Carlo is divided by it, and the less is
left to interpolation.  Here natural frequency and intensity are 1.

Elastic wall: stiffness and damping are those that give the exact variances of x and v without a wall (so a wall that is
never struck is exact, and so is order 1), and the springpot's in-phase force acts about the mean.
Lossy wall: what the losses change is that of the oscillator which has the atlas's own mean, mean square displacement
and mean square velocity behind the elastic wall at the same place; the atlas's elastic moments are changed so.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import interpolate, optimize, special

from springpot import Barrier, Oscillator, Springpot
from springpot.evidence.atlases.lookup import crowding
from springpot.theory import envelope, exact, fokker_planck
from springpot.theory.result import MOMENTS, NotCoveredError, Result

Moments = dict[str, float]
Floats = npt.NDArray[np.float64]

LIGHTEST = 0.02  # damping at which the Fokker-Planck solution is asked at least
HEAVIEST = 45.0
FARTHEST, DEEPEST = -5.5, 3.5  # wall, in standard deviations of the oscillator without one


@dataclass(frozen=True)
class Equivalent:
    """An oscillator of order 1: x'' + damping x' + stiffness (x - rest) = white noise of intensity 1."""

    stiffness: float
    damping: float
    rest: float

    @property
    def spread(self) -> float:
        """Standard deviation of x without a wall."""
        return math.sqrt(0.5 / (self.damping * self.stiffness))


def truncated(wall: float) -> tuple[float, float]:
    """Mean and mean square of a standard normal number above a wall; the mean is its density at the wall as well."""
    mean = math.sqrt(2.0 / math.pi) / float(special.erfcx(wall / math.sqrt(2.0)))
    return mean, 1.0 + wall * mean


def behind_an_elastic_wall(found: Equivalent, wall: float) -> Moments:
    """Exact moments: a normal density cut off at the wall, and an independent normal velocity."""
    spread, speed = found.spread, math.sqrt(0.5 / found.damping)
    mean, square = truncated((wall - found.rest) / spread)
    x_square = spread**2 * square + 2.0 * found.rest * spread * mean + found.rest**2
    return {
        "amplitude_mean_square": x_square + speed**2,
        "x_mean": found.rest + spread * mean,
        "x_mean_square": x_square,
        "v_mean_square": speed**2,
        "impact_rate": mean / spread * speed / math.sqrt(2.0 * math.pi),
        "impact_speed_mean": speed * math.sqrt(0.5 * math.pi),
        "impact_speed_mean_square": 2.0 * speed**2,
    }


def elastic(order: float, coefficient: float, wall: float) -> Moments:
    """Moments of the oscillator that stands for one with memory behind an elastic wall."""
    free = exact(Oscillator(springpot=Springpot(order, coefficient), barrier=None))
    stiffness, damping = free.v_mean_square / free.x_mean_square, 0.5 / free.v_mean_square
    share = max(stiffness - 1.0, 0.0) / stiffness  # of the in-phase force, about the mean

    def off(mean: float) -> float:
        return behind_an_elastic_wall(Equivalent(stiffness, damping, share * mean), wall)["x_mean"] - mean

    low, high = max(wall, 0.0), max(wall, 0.0) + 20.0 * math.sqrt(free.x_mean_square)
    mean = optimize.brentq(off, low, high) if off(low) > 0.0 else low
    return behind_an_elastic_wall(Equivalent(stiffness, damping, share * mean), wall)


def with_these_moments(mean: float, mean_square: float, speed_square: float, wall: float) -> Equivalent:
    """The oscillator that has these moments behind an elastic wall at ``wall``."""
    above, variance = mean - wall, mean_square - mean**2

    def shape(place: float) -> float:  # variance over square of the mean distance from the wall
        first, second = truncated(place)
        return (second - first**2) / (first - place) ** 2 - variance / above**2

    low, high = -30.0, 30.0
    place = optimize.brentq(shape, low, high) if shape(low) * shape(high) < 0.0 else low
    first, _ = truncated(place)
    spread = above / (first - place)
    return Equivalent(speed_square / spread**2, 0.5 / speed_square, wall - place * spread)


class LossyTable:
    """What a lossy wall changes in an oscillator of order 1: splines over damping and restitution, or damping and wall.

    Parameters
    ----------
    dampings : ndarray
        In units of its frequency.
    restitutions, walls : ndarray
        One of the two holds a single number; places of the wall count in standard deviations.
    """

    def __init__(self, dampings: Floats, restitutions: Floats, walls: Floats) -> None:
        points = list(itertools.product(dampings, restitutions, walls))
        with ProcessPoolExecutor() as pool:
            rows = list(pool.map(_relative, points, chunksize=4))
        shape = dampings.size, restitutions.size * walls.size, len(MOMENTS)
        self.by_wall = walls.size > 1
        axis = walls if self.by_wall else crowding(restitutions)
        self.table = interpolate.RegularGridInterpolator(
            (np.log(dampings), axis), np.reshape(rows, shape), method="cubic", bounds_error=False, fill_value=None
        )

    def changed(self, elastic_moments: Moments, wall: float, restitution: float) -> Moments:
        """Moments behind a wall of this restitution, from those behind an elastic wall at the same place."""
        names = ("x_mean", "x_mean_square", "v_mean_square")
        found = with_these_moments(*(elastic_moments[name] for name in names), wall)
        damping = min(found.damping / math.sqrt(found.stiffness), HEAVIEST)
        place = (wall - found.rest) / found.spread
        second = min(max(place, FARTHEST), DEEPEST) if self.by_wall else float(crowding(restitution))
        changes = np.exp(self.table((math.log(damping), second)).ravel())
        near = dict(zip(MOMENTS, changes.tolist(), strict=True))
        mean = wall + (elastic_moments["x_mean"] - wall) * near["x_mean"]
        variance = elastic_moments["x_mean_square"] - elastic_moments["x_mean"] ** 2
        square = mean**2 + variance * near["x_mean_square"]
        moments = {name: elastic_moments[name] * near[name] for name in MOMENTS}
        moments |= {"x_mean": mean, "x_mean_square": square}
        return moments | {"amplitude_mean_square": square + moments["v_mean_square"]}


def _relative(point: tuple[float, float, float]) -> list[float]:
    """Logarithms of moments behind a lossy wall over those behind an elastic one; place in standard deviations."""
    damping, restitution, place = point
    if restitution == 1.0:
        return [0.0] * len(MOMENTS)
    asked = max(damping, LIGHTEST)
    wall = place * math.sqrt(0.5 / asked)
    lossy = Oscillator(springpot=Springpot(1.0, asked), barrier=Barrier(wall, restitution, free_side="above"))
    try:
        result: Result = fokker_planck(lossy)
    except NotCoveredError:  # a strong preload with light damping: many bounces, of little loss each
        result = envelope(lossy)
    found = {name: getattr(result, name) for name in MOMENTS}
    reference = behind_an_elastic_wall(Equivalent(1.0, asked, 0.0), wall)
    logs = _logs(found, reference, wall)
    if damping < LIGHTEST:  # what less damping changes, from the diffusion of energy: impacts do nearly all of it
        light = wall * math.sqrt(asked / damping)
        with contextlib.suppress(NotCoveredError):  # a wall far off at light damping: no oscillator of the atlas
            changes = [_by_diffusion(c, b, restitution) for c, b in ((damping, light), (asked, wall))]
            logs = [log + new - old for log, new, old in zip(logs, *changes, strict=True)]
    return logs


def _by_diffusion(damping: float, wall: float, restitution: float) -> list[float]:
    result = envelope(
        Oscillator(springpot=Springpot(1.0, damping), barrier=Barrier(wall, restitution, free_side="above"))
    )
    found = {name: getattr(result, name) for name in MOMENTS}
    return _logs(found, behind_an_elastic_wall(Equivalent(1.0, damping, 0.0), wall), wall)


def _logs(found: Moments, reference: Moments, wall: float) -> list[float]:
    def shifted(moments: Moments) -> Moments:
        return {
            **moments,
            "x_mean": moments["x_mean"] - wall,
            "x_mean_square": moments["x_mean_square"] - moments["x_mean"] ** 2,
        }

    ours, theirs = shifted(found), shifted(reference)
    return [math.log(ours[name] / theirs[name]) for name in MOMENTS]
