"""The way of a problem through the files of a simulation.

The rule.  A simulation is run under Python's own trace.  A call counts if one of its arguments is the problem or what
carries it: a `System`, `Motion`, `Plan`, `Simulation` or `Run`, whose values the callee can ask.  Each such call from
one file into another is an entry, counted once for each place in the code that calls: a loop over the parts is one.
Properties, the methods of the dataclasses that carry the problem and what they call are its own and do not count.

stays     entries
files     different files entered
returns   stays less files: entries into a file that was entered before
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

import springpot as sp

SOURCE = Path(sp.__file__).resolve().parent


def entries(system: Any, **given: Any) -> Counter[str]:
    """How often each file is entered while a system is simulated."""
    from springpot.problem.system import System
    from springpot.simulation.paths.simulation import Simulation
    from springpot.simulation.plan.motion import Motion
    from springpot.simulation.plan.plan import Plan
    from springpot.simulation.result.results import Run

    carriers = System, Motion, Plan, Simulation, Run
    places: set[tuple[str, int, str]] = set()

    def follow(frame: FrameType, event: str, _: Any) -> None:
        caller = frame.f_back
        if event != "call" or caller is None:
            return
        here, before = frame.f_code.co_filename, caller.f_code.co_filename
        if not here.startswith(str(SOURCE)) or here == before:
            return
        count = frame.f_code.co_argcount + frame.f_code.co_kwonlyargcount
        names = frame.f_code.co_varnames[:count]
        if not names or (isinstance(frame.f_locals.get(names[0]), carriers) and names[0] == "self"):
            return
        if any(isinstance(frame.f_locals.get(name), carriers) for name in names):
            places.add((before, caller.f_lineno, str(Path(here).relative_to(SOURCE))))

    sp.simulate(system, **given).to_xarray()  # what is loaded and compiled at first use is no part of the way
    sys.setprofile(follow)
    try:
        sp.simulate(system, **given).to_xarray()
    finally:
        sys.setprofile(None)
    return Counter(file for _, _, file in places)


@cache
def both() -> dict[str, Counter[str]]:
    """The ways of the paper's oscillator and of a system with two walls."""
    paper = sp.Oscillator(barrier=sp.Barrier(-0.5, 0.8))
    two = sp.System(
        sp.Mass(0.2), sp.Spring(80.0), sp.PolynomialSpring((0.0, 0.0, 4e5)), sp.Springpot(0.5, 1.2),
        sp.WhiteNoise(1e-3), sp.Barrier(-0.003, 0.8), sp.Barrier(0.004, 0.8),
    )  # fmt: skip
    return {name: entries(each, paths=64) for name, each in (("oscillator", paper), ("two walls", two))}


def compared() -> Iterator[str]:
    """One beside the other, in words."""
    found = both()
    for name, ways in found.items():
        stays, files = sum(ways.values()), len(ways)
        most = max(ways.items(), key=lambda item: item[1])
        yield f"{name}: {stays} stays, {files} files, {stays - files} returns; most often {most[0]}, {most[1]} times"
    for file in sorted({*found["oscillator"], *found["two walls"]}):
        yield f"  {found['oscillator'][file]:2d} {found['two walls'][file]:2d}  {file}"
