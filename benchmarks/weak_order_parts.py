"""Weak order with each part of a system: how much <x^2> and <v^2> change when the step is halved, without a wall.

As `benchmarks.weak_order`: the paths of both steps share their noise.  Each part stands beside a linear spring, a
springpot of order 0.5 and, unless it is the excitation, white noise.  The steps are those at which the change is seen:
from a quarter of the shortest time scale down.  ``python -m benchmarks.weak_order_parts`` writes the table; it takes
some twenty minutes of one processor.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import springpot as sp
from benchmarks.measure import folder_for
from benchmarks.weak_order import Change, read, text, write
from springpot.machine.crew import threads_available
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.plan import plan_of

__all__ = ["CASES", "Case", "change", "measure"]

WINDOW = 20.0, 60.0
PATHS = 262_144
QUANTITIES = "x_mean_square", "v_mean_square"
COARSEST = 0.2, 0.25  # s, and of the shortest time scale
HALVINGS = 3

_BASE = sp.Spring(1.0), sp.Springpot(0.5, 1.0)
_WHITE = sp.WhiteNoise(1.0)
_CUBIC = sp.PolynomialSpring((0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Case:
    """A system with a part that is measured.

    Parameters
    ----------
    name : str
    system : System
    start : {"rest", "stationary"}
    """

    name: str
    system: sp.System
    start: str = "rest"

    @property
    def steps(self) -> tuple[float, ...]:
        """Coarse steps in s; each is compared with its half."""
        longest = min(COARSEST[0], COARSEST[1] / motion_of(self.system).scales.fastest_rate)
        return tuple(float(f"{longest / 2**n:.3g}") for n in range(HALVINGS))


CASES = (
    Case("springpot", sp.System(*_BASE, _WHITE)),
    Case("two springpots", sp.System(_BASE[0], sp.Springpot(0.3, 0.5), sp.Springpot(0.8, 0.5), _WHITE)),
    Case("cubic spring", sp.System(*_BASE, _CUBIC, _WHITE)),
    Case("spring of fifth power", sp.System(*_BASE, sp.PolynomialSpring((0.0, 0.0, 0.0, 0.0, 0.2)), _WHITE)),
    Case("bistable spring", sp.System(sp.Spring(-1.0), _BASE[1], _CUBIC, _WHITE)),
    Case("constant force and cubic spring", sp.System(*_BASE, sp.Constant(0.5), _CUBIC, _WHITE)),
    Case("quadratic dashpot", sp.System(*_BASE, sp.PolynomialDashpot((0.0, 0.3)), _WHITE)),
    Case("cubic dashpot", sp.System(*_BASE, sp.PolynomialDashpot((0.0, 0.0, 0.3)), _WHITE)),
    Case("van der Pol", sp.System(*_BASE, sp.VanDerPol(0.5), _WHITE)),
    Case("friction (not smooth)", sp.System(*_BASE, sp.Friction(0.3), _WHITE)),
    Case("Bouc-Wen", sp.System(sp.Spring(0.5), _BASE[1], sp.BoucWen(0.5, 0.5), _WHITE)),
    Case("Jenkins", sp.System(sp.Spring(0.5), _BASE[1], sp.Jenkins(0.5, 0.3), _WHITE)),
    Case("Maxwell", sp.System(*_BASE, sp.Maxwell(1.0, 1.0), _WHITE)),
    Case("series", sp.System(_BASE[0], sp.Dashpot(0.5), sp.FractionalMaxwell(_BASE[1], sp.Spring(1.0)), _WHITE)),
    Case("circuit", sp.System(*_BASE, sp.PiezoelectricCircuit(0.7, 1.0, 1.0), _WHITE)),
    Case("colored noise", sp.System(*_BASE, sp.ColoredNoise(1.0, 0.5))),
    Case("filtered noise", sp.System(*_BASE, sp.KanaiTajimiNoise(2.0, 0.3, 1.0))),
    Case("harmonic", sp.System(*_BASE, sp.Harmonic(1.0, 1.3), _WHITE)),
    Case("Poisson impulses", sp.System(*_BASE, sp.PoissonImpulses(2.0, 0.5))),
    Case("parametric noise", sp.System(*_BASE, sp.ParametricNoise(0.1), _WHITE)),
    Case("thermal noise and cubic spring", sp.System(*_BASE, _CUBIC, sp.ThermalNoise(1.0)), start="stationary"),
    Case("linear contact (not smooth)", sp.System(*_BASE, sp.Contact(-0.3, 10.0, 1.0), _WHITE)),
    Case("Hertz's contact with a loss", sp.System(*_BASE, sp.Contact(-0.3, 10.0, 1.5, 0.2), _WHITE)),
)


def change(case: Case, step: float, *, paths: int = PATHS, stream: int = 5) -> list[Change]:
    """Changes of <x^2> and <v^2> from ``step`` to half of it, with so many pairs of paths."""
    plan = plan_of(
        case.system, paths=paths, duration=WINDOW[1], window=WINDOW, step=step, threads=threads_available(),
        start=case.start,
    )  # fmt: skip
    levels = []
    for at, halved in ((step, True), (0.5 * step, False)):
        simulation = simulation_of(plan.but(step=at, initial_position=0.0), halved=halved)
        levels.append(samples_of(simulation, simulation.advance(stream=stream, halved=halved).rows))
    changes = []
    for name in QUANTITIES:
        value, difference = levels[1][name][0], levels[1][name][1] - levels[0][name][1]
        error = standard_error(difference) / value
        changes.append(Change(case.name, name, step, value, float(difference.mean()) / value, error))
    return changes


def measure(*, paths: int = PATHS) -> list[Change]:
    """Changes of all cases at all their steps."""
    found = []
    for case in CASES:
        for number, step in enumerate(case.steps):
            found += change(case, step, paths=paths, stream=5 + number)
        print(case.name, file=sys.stderr, flush=True)
    return found


def main() -> None:
    """Measure, write the table and print the orders."""
    parser = argparse.ArgumentParser(prog="weak_order_parts", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few paths: shows that it works, and means nothing")
    parser.add_argument("--read", action="store_true", help="measure nothing: print the table that is there")
    parser.add_argument("--out", type=Path, help="folder of the table")
    chosen = parser.parse_args()
    table = folder_for(chosen.out, chosen.quick) / "weak_order_parts.csv"
    if not chosen.read:
        write(measure(paths=1024 if chosen.quick else PATHS), table)
    print(text(read(table)))


if __name__ == "__main__":
    main()
