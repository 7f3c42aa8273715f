"""The transient of a run: exponential for the energy, a power of time for slow displacements."""

from __future__ import annotations

from collections.abc import Mapping

from springpot.simulation.plan.motion import Motion

MOST_TRANSIENT = 0.01  # share left at the start of the window
WALL = 2.0  # a wall changes the slow displacements by less than this factor


def shares_missing(motion: Motion, time: float, values: Mapping[str, float]) -> dict[str, float]:
    """Bound on the missing share of each of some values at a time, due to slow displacements.

    With a gap b the impact rate is proportional to exp(-b^2 / (2 <x^2>)), which adds b^2 / (2 <x^2>) to its relative
    change.
    """
    missing: dict[str, float] = {}
    for creep in () if motion.is_thermal else motion.slow:
        for square, variance in creep.missing(time).items():
            missing[square] = missing.get(square, 0.0) + variance
    wider = WALL if motion.touched or motion.scales.guessed else 1.0
    # of walls beyond the equilibrium, not on its near side as a preload
    rarer = {
        name: 0.5 * (wall.position - motion.origin) ** 2 / _square(motion, name, values)
        for name, wall in motion.touched.items()
        if wall.inwards * (wall.position - motion.origin) < 0.0
    }
    rarest = min(rarer.values(), default=0.0) if len(rarer) == len(motion.touched) else 0.0
    shares = {}
    for name in values:
        square = motion.mean_square_of(name)
        absent = wider * missing.get(square, 0.0)
        if name.endswith(("v_mean_square", "_power")):
            shares[name] = 0.0
        elif name == "amplitude_mean_square":
            shares[name] = min(1.0, absent / values[name])
        else:
            beyond = next((more for wall, more in rarer.items() if name == f"{wall}_impact_rate"), rarest)
            more = beyond if name.endswith(("x_mean", "elongation_mean", "impact_rate")) else 0.0
            weight = 1.0 if name == square else 0.5
            shares[name] = min(1.0, (weight + more) * absent / values[square]) if absent > 0.0 else 0.0
    return shares


def _square(motion: Motion, wall: str, values: Mapping[str, float]) -> float:
    """The mean square displacement with which the impacts on a wall change, about the rest of the springs."""
    square = values[motion.mean_square_of(f"{wall}_impact_rate")]
    return motion.square_about_origin(values) if motion.origin else square
