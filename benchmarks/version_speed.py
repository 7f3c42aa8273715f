"""Two versions of springpot by turns: processor time per path-step, and of the first numbers of a fresh process.

Each version is a process of its own Python, which uses public names only.  They run one after the other, turn by turn,
on one thread, and the least time of each counts, so that both have the same chances on a busy machine.  A run's time is
that of many paths less that of few: what does not grow with the paths is not counted.  From the folder with these
files::

    .venv/bin/python -m benchmarks.version_speed steps /that/version/.venv/bin/python [--cpu x86-64-v3]
    .venv/bin/python -m benchmarks.version_speed first /that/version/.venv/bin/python

``steps`` compares path-steps, and what each observer adds to them.  ``first`` starts with empty caches: what three
kinds of systems take, then everything else; and, with the caches that this leaves, one number in a fresh process.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import springpot as sp

__all__ = ["FIRST", "GROUPS", "Timed", "first_numbers", "nanoseconds", "table"]

_ROOT = Path(__file__).resolve().parents[1]
_STEPS = 16_000
_EVERY = -1  # paths are recorded
_FEW, _MANY = 256, 1280  # paths; of systems of several masses a quarter of the difference
_TURNS = 7
_ANY_CPU = 1.1  # the ratio that any group may have where the code is compiled for a processor that is named


# --- what is timed ------------------------------------------------------------------------------------------------


class Timed(NamedTuple):
    """A run, and how much slower than before it may be."""

    name: str
    system: Any
    step: float
    asked: Mapping[str, Any] = {}

    @property
    def label(self) -> str:
        """With its step."""
        return f"{self.name}, step {self.step:g}"


def _one(*parts: Any, order: float = 0.5) -> Any:
    return sp.System(sp.Mass(1.0), sp.Spring(1.0), sp.Springpot(order, 0.3), sp.WhiteNoise(0.3), *parts)


def _row(masses: int, walls: int) -> Any:
    """Masses in a row from the ground, a springpot beside each spring; walls between the first of them."""
    points = [f"m{n}" for n in range(masses)]
    ends = [*pairwise(("ground", *points))]
    return sp.System(
        *(sp.Mass(1.0, at=point) for point in points), *(sp.WhiteNoise(0.3, on=point) for point in points),
        *(part for own in ends for part in (sp.Spring(1.0, between=own), sp.Springpot(0.5, 0.3, between=own))),
        *(sp.Barrier(-0.7 if n else -0.5, 0.7, between=own) for n, own in enumerate(ends[:walls])),
    )  # fmt: skip


def _at(steps: Sequence[float], **systems: Any) -> list[Timed]:
    return [Timed(name.replace("_", " "), system, step) for name, system in systems.items() for step in steps]


_LOW, _HIGH, _CUBIC = sp.Barrier(-0.5, 0.7), sp.Barrier(0.5, 0.7), sp.PolynomialSpring((0.0, 0.0, 0.5))
_STRUCK = _one(_LOW)
_FREQUENCIES = [0.4 + 0.1 * n for n in range(20)]
_OBSERVERS: dict[str, dict[str, Any]] = {
    "nothing": {}, "distributions": {"distributions": True}, "a spectrum": {"spectrum": _FREQUENCIES},
    "first passages": {"first_passage": {"x": [2.0, 3.0]}}, "rainflow": {"rainflow": {"x": sp.Basquin(5.0)}},
    "a profile": {"profile": 20}, "a force": {"forces": ["springpot_force"]},
    "counted impacts": {"slowest_counted_impact": 0.2}, "records": {"record": _EVERY, "record_every": 10},
}  # fmt: skip
GROUPS: dict[str, tuple[float, list[Timed]]] = {
    "no wall": (1.05, _at((0.05, 0.1), no_wall=_one())),
    "walls": (0.85, _at(
        (0.05, 0.1),
        one_wall=_STRUCK,
        a_wall_at_0_and_r_one_half=_one(sp.Barrier(0.0, 0.5)),
        two_walls_and_a_cubic_spring=_one(_LOW, _HIGH, _CUBIC),
        order_1_and_a_wall_at_0=_one(sp.Barrier(0.0, 0.9), order=1.0),
        order_1_and_an_elastic_wall=_one(sp.Barrier(-0.5), order=1.0),
    )),
    "exact flight": (1.25, _at((0.2, 0.4), order_1_and_an_elastic_wall=_one(sp.Barrier(-0.5), order=1.0))),
    "two masses": (0.7, _at((0.05, 0.1), two_masses_with_two_walls=_row(2, 2))),
    "four masses": (0.85, _at((0.05, 0.1), four_masses_with_two_walls=_row(4, 2), four_masses=_row(4, 0))),
    "eight masses": (0.85, _at((0.05, 0.1), eight_masses_with_four_walls=_row(8, 4))),
    "observers": (math.inf, [Timed(name, _STRUCK, 0.05, asked) for name, asked in _OBSERVERS.items()]),
}  # fmt: skip
"""Groups of runs, with the ratio of now to before that their mean may have."""
LARGEST = {"walls": 1.1}
"""That which none of a group may exceed, where that is not the same."""
_CASES = {(group, each.label): each for group, (_, own) in GROUPS.items() for each in own}


def _short(system: Any, **asked: Any) -> Callable[[], object]:
    return partial(sp.simulate, system, **{"paths": 64, "duration": 40.0, "step": 0.05, "threads": 1, **asked})


_PAIR = _row(2, 1)
FIRST: dict[str, Callable[[], object]] = {
    "a wall": _short(_STRUCK, start="rest"),
    "a cubic spring, two walls and coloured noise": _short(_one(_LOW, _HIGH, _CUBIC, sp.ColoredNoise(1.0, 0.5))),
    "two masses": _short(_PAIR),
    "distributions": _short(_STRUCK, distributions=True),
    "a spectrum": _short(_STRUCK, spectrum=[1.0, 2.0]),
    "first passages": _short(_STRUCK, first_passage={"x": 2.0}),
    "rainflow": _short(_STRUCK, rainflow={"x": sp.Basquin(5.0)}),
    "a profile": _short(_STRUCK, profile=4),
    "records": _short(_STRUCK, record=8),
    "observables": _short(_STRUCK, observables={"product": lambda t, x, v: x * x * v * v}),
    "hysteresis": _short(_one(sp.Jenkins(0.5, 0.3))),
    "a contact of Hertz": _short(_one(sp.Contact(-0.5, 100.0))),
    "a circuit with a coil": _short(_one(sp.ResonantCircuit(0.5, 1.0, 1.0, 1.0))),
    "exceedance": partial(sp.exceedance, _STRUCK, {"x": 6.0}, duration=5.0, step=0.1, start="rest", rtol=1.0),
    "exceedance of two masses": partial(
        sp.exceedance, _PAIR, {"m1_x": 8.0}, duration=5.0, step=0.1, start="rest", rtol=1.0
    ),
    "rtol": partial(sp.simulate, _STRUCK, rtol=0.3, threads=1),
    "rtol of two masses": partial(sp.simulate, _PAIR, rtol=0.3, threads=1),
}
"""What is asked of a fresh process, in this order; the first three are three kinds of systems."""
_KINDS = 3


# --- a process of one version -------------------------------------------------------------------------------------


def _cpu(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun


def _answer(question: Mapping[str, Any]) -> Any:
    if question["what"] == "first":
        return [(_cpu(work), _cpu(work)) for work in FIRST.values()]
    if question["what"] == "one":
        return time.process_time(), _cpu(FIRST["a wall"])
    case = _CASES[tuple(question["case"])]
    end = _STEPS * case.step
    asked = {"duration": end, "step": case.step, "window": (0.0, end), "start": "rest", "threads": 1, **case.asked}
    if asked.get("record") == _EVERY:  # else it would cost few and many paths the same
        asked["record"] = question["paths"]
    return _cpu(partial(sp.simulate, case.system, paths=question["paths"], **asked))


def _work() -> None:
    """Answer questions, one a line."""
    for line in sys.stdin:
        print(json.dumps(_answer(json.loads(line))), flush=True)


@contextmanager
def _version(python: str, **environment: str) -> Iterator[Callable[..., Any]]:
    """A process of that Python, as a function from a question to its answer."""
    with subprocess.Popen(
        [python, "-m", "benchmarks.version_speed", "work"], cwd=_ROOT, text=True,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "", **environment},  # else each would compile the package anew
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None

        def ask(**question: Any) -> Any:
            process.stdin.write(json.dumps(question) + "\n")  # type: ignore[union-attr]
            process.stdin.flush()  # type: ignore[union-attr]
            if not (line := process.stdout.readline()):  # type: ignore[union-attr]
                raise RuntimeError(f"{python} ended at {question}")
            return json.loads(line)

        yield ask
        process.stdin.close()


# --- both by turns ------------------------------------------------------------------------------------------------


def nanoseconds(
    pythons: Sequence[str], groups: Sequence[str], turns: int = _TURNS, **environment: str
) -> dict[tuple[str, str], list[float]]:
    """ns per path-step of each case in each version."""
    found = {}
    with _version(pythons[0], **environment) as before, _version(pythons[1], **environment) as now:
        for group, label in _CASES:
            if group not in groups:
                continue
            many = _FEW + (_MANY - _FEW) // (4 if "masses" in group else 1)
            least = {(ask, paths): math.inf for ask in (before, now) for paths in (_FEW, many)}
            for turn in range(turns + 1):
                for ask, paths in least:
                    taken = ask(what="steps", case=(group, label), paths=paths)
                    least[ask, paths] = min(least[ask, paths], taken) if turn else math.inf  # the first one compiles
            own = [1e9 * (least[ask, many] - least[ask, _FEW]) / (_STEPS * (many - _FEW)) for ask in (before, now)]
            found[group, label] = own
            print(f"{group:14} {label:48} {own[0]:7.2f} {own[1]:7.2f} {own[1] / own[0]:6.2f}", flush=True)
    return found


def table(found: Mapping[tuple[str, str], Sequence[float]], limit: float | None = None) -> int:
    """Print the ratios of each group and what each observer adds; 1 if a group is slower than wanted, or ``limit``."""
    slower = False
    for group, (wanted, _) in GROUPS.items():
        ratios = [now / before for (own, _), (before, now) in found.items() if own == group]
        if ratios and wanted < math.inf:
            mean, largest = sum(ratios) / len(ratios), max(ratios)
            most = limit or wanted, limit or LARGEST.get(group, wanted)
            slower |= mean > most[0] or largest > most[1]
            print(f"{group}: mean ratio {mean:.2f}, largest {largest:.2f}; wanted {most[0]:g}, none above {most[1]:g}")
    observers = {label: own for (group, label), own in found.items() if group == "observers"}
    if observers:
        plain, *_ = observers.values()
        for label, own in observers.items():
            before, now = (with_it - without for with_it, without in zip(own, plain, strict=True))
            print(f"{label}: adds {now:.2f} ns, before {before:.2f} ns")
    return int(slower)


def first_numbers(pythons: Sequence[str], turns: int = 3) -> None:
    """Print CPU seconds with empty caches, of the first time less the second; then of one number with full ones."""
    with tempfile.TemporaryDirectory() as own, tempfile.TemporaryDirectory() as other:
        compiled, ready = [], []
        for python, folder in zip(pythons, (own, other), strict=True):
            with _version(python, NUMBA_CACHE_DIR=folder, SPRINGPOT_CACHE_DIR=folder) as ask:
                compiled.append([first - second for first, second in ask(what="first")])
        for _ in range(turns):
            for python, folder in zip(pythons, (own, other), strict=True):
                begun = time.perf_counter()
                with _version(python, NUMBA_CACHE_DIR=folder, SPRINGPOT_CACHE_DIR=folder) as ask:
                    imported, number = ask(what="one")
                ready.append((time.perf_counter() - begun, imported + number, imported))
    rows = dict(zip(FIRST, zip(*compiled, strict=True), strict=True))
    rows[f"the first {_KINDS} together"] = tuple(sum(each[:_KINDS]) for each in compiled)
    least = [np.min(ready[n::2], axis=0) for n in range(2)]
    for n, name in enumerate(("wall time of a fresh process, caches full", "its processor time", "of that the import")):
        rows[name] = tuple(float(each[n]) for each in least)
    for name, taken in rows.items():
        print(f"{name:46}" + "".join(f"{each:8.2f}" for each in taken))


def main(words: Sequence[str] | None = None) -> int:
    """Compare, or answer as one version."""
    parser = argparse.ArgumentParser(prog="version_speed", description=__doc__.partition("\n")[0])
    parser.add_argument("what", choices=("steps", "first", "work"))
    parser.add_argument("before", nargs="?", help="Python of the version to compare with")
    parser.add_argument("--now", default=sys.executable, help="Python of the other version; this one if left out")
    parser.add_argument("--cpu", help="compile for this processor, as x86-64-v3")
    parser.add_argument("--only", choices=list(GROUPS), action="append", help="these groups of path-steps")
    parser.add_argument("--turns", type=int, default=_TURNS)
    chosen = parser.parse_args(words)
    if chosen.what == "work":
        warnings.simplefilter("ignore", sp.SpringpotWarning)
        _work()
        return 0
    if chosen.before is None:
        parser.error("name the Python of the version to compare with")
    pythons = chosen.before, chosen.now
    if chosen.what == "first":
        first_numbers(pythons)
        return 0
    target = {"NUMBA_CPU_NAME": chosen.cpu, "NUMBA_CPU_FEATURES": ""} if chosen.cpu else {}
    return table(nanoseconds(pythons, chosen.only or [*GROUPS], chosen.turns, **target), _ANY_CPU if target else None)


if __name__ == "__main__":
    raise SystemExit(main())
