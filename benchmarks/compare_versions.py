"""Two versions of springpot on the same 340 systems: every result, in units of the joint standard error.

The systems are those of `benchmarks.drawn_systems`.  Each version simulates them with its own Python and its own seed,
from the folder that holds these files, and appends each finished system to its own file; started again, it goes on::

    /that/version/.venv/bin/python -m benchmarks.compare_versions run before.jsonl --seed 1
    .venv/bin/python -m benchmarks.compare_versions run now.jsonl --seed 2
    .venv/bin/python -m benchmarks.compare_versions show now.jsonl before.jsonl

The results of the commit 97121b9e, with the seed 1, are kept in `KEPT`: ``show now.jsonl`` compares with them.  It
prints a table of the kinds of results, and every difference beyond `LARGEST` standard errors.  Its exit code is 1 if
there is one, if the mean or the rms of a kind differs from 0 or 1 by more than chance allows, or if a result is not
there any more.  Of ten thousand results one may lie beyond by chance: ``run --only "wall 7"`` simulates that system
again, with another seed in each version.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import math
import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy

import springpot as sp
from benchmarks.drawn_systems import OWNERS, Case, cases

__all__ = [
    "KEPT",
    "LARGEST",
    "Deviation",
    "Summary",
    "deviations",
    "kind_of",
    "lines_of",
    "measured",
    "quick",
    "run",
    "show",
    "summary",
]

KEPT = Path(__file__).parent / "results" / "of_97121b9e.jsonl.gz"
LARGEST = 4.0  # standard errors
CHANCE = 1e-4  # that the rms, or the mean, of a kind is called wrong though nothing changed
EXACT = 1e-6  # relative: values with smaller errors are known beforehand, and must agree to ten times this
Pair = tuple[float, float]  # value and standard error
Results = dict[str, Pair]
Line = Mapping[str, Any]  # of a file: a system and its results
_AXES = "barrier", "probability", "frequency", "time_bin"
_PROBABILITIES = 0.05, 0.95  # of ranges the second one: under white noise the smallest cycles are those of the step


class Deviation(NamedTuple):
    """One result of one system in two versions."""

    system: str
    name: str
    before: Pair
    now: Pair

    @property
    def error(self) -> float:
        """Joint standard error."""
        return math.hypot(self.before[1], self.now[1])

    @property
    def is_exact(self) -> bool:
        """Whether the value is known beforehand."""
        return self.error <= EXACT * max(abs(self.before[0]), abs(self.now[0]))

    @property
    def z(self) -> float:
        """Their difference in joint standard errors; of values known beforehand, in ten times EXACT."""
        difference = self.now[0] - self.before[0]
        if self.is_exact:
            return difference / (10.0 * EXACT * max(abs(self.before[0]), abs(self.now[0]), 1e-300))
        return difference / self.error


# --- one version --------------------------------------------------------------------------------------------------


def measured(case: Case, seed: int, threads: int | None = None) -> Results:
    """Every result of a case with its standard error; of curves two points.

    Each case has its own seed, made from this one: with the same normals all would deviate alike.
    """
    seed = int.from_bytes(hashlib.sha256(f"{seed} {case.name}".encode()).digest()[:7], "little")
    if "levels" in case.given:
        return dict(_of_exceedance(case, seed, threads))
    found = sp.simulate(case.system, seed=seed, threads=threads, **case.given).to_xarray()
    return dict((*_of_data(found), *_of_records(found)))


def _of_data(found: Any) -> Iterator[tuple[str, Pair]]:
    """Bins that a version chooses for itself, of densities and of survival, are left out: quantiles have the same."""
    for name in map(str, found.data_vars):
        if f"{name}_se" in found:
            for where, at in _points(found[name]):
                pair = float(found[name].isel(at).values), float(found[f"{name}_se"].isel(at).values)
                if np.isfinite(pair).all():
                    yield name + where, pair


def _points(values: Any) -> Iterator[tuple[str, dict[str, int]]]:
    """Of a curve, in words and by its indices; none if it has other axes."""
    axes = {str(axis): values[axis].values.tolist() for axis in values.dims}
    if all(axis in _AXES or axis.endswith("_level") for axis in axes):
        for at in product(*(range(len(points)) for points in axes.values())):
            own = {axis: points[n] for (axis, points), n in zip(axes.items(), at, strict=True)}
            if own.get("probability") in (None, *_PROBABILITIES["_range_" in values.name :]):
                words = (f"[{each:.6g}]" if isinstance(each, float) else f"[{each}]" for each in own.values())
                yield "".join(words), dict(zip(axes, at, strict=True))


def _of_records(found: Any) -> Iterator[tuple[str, Pair]]:
    """Mean square in time of each recorded path, then mean and error over the paths."""
    for name in map(str, found.data_vars):
        if {"path", "time"} == {*found[name].dims}:
            times = found[name].time
            each = (found[name] ** 2).where(times > 0.5 * times.max()).mean("time").values
            yield f"{name}_recorded", (float(each.mean()), float(each.std(ddof=1) / math.sqrt(each.size)))


def _of_exceedance(case: Case, seed: int, threads: int | None) -> Iterator[tuple[str, Pair]]:
    given = dict(case.given)
    found = sp.exceedance(case.system, given.pop("levels"), seed=seed, threads=threads, **given)
    for name, values in found.probability.items():
        for at, (value, error) in enumerate(zip(values, found.error[name], strict=True)):
            yield f"{name}_exceedance[{at}]", (float(value), float(error))


def run(file: Path, seed: int, threads: int | None, only: str | None = None, few: bool = False) -> None:
    """Simulate what is not yet in the file, and append it."""
    done = {line["name"] for line in lines_of(file)} if file.exists() else set()
    for case in [*map(quick, cases(1))] if few else [*cases()]:  # at once, as their source may be edited meanwhile
        if case.name in done or only not in (None, case.name, case.kind):
            continue
        begun = time.process_time()
        results = measured(case, seed, threads)
        line = {
            "name": case.name, "digest": case.digest, "seed": seed, "version": sp.__version__,
            "cpu": round(time.process_time() - begun, 2),
            "results": {name: (float(f"{pair[0]:.7g}"), float(f"{pair[1]:.4g}")) for name, pair in results.items()},
        }  # fmt: skip
        with file.open("a", encoding="utf-8") as output:
            output.write(json.dumps(line) + "\n")
        print(f"{case.name}: {line['cpu']} CPU s", file=sys.stderr, flush=True)


def quick(case: Case) -> Case:
    """With few paths: it shows that the case runs."""
    few = {"rtol": 1.0} if "levels" in case.given else {"paths": 128}
    return replace(case, given={**case.given, **few})


def lines_of(file: Path) -> list[dict[str, Any]]:
    """What is in a file; the last line may be one that a kill cut short."""
    found = []
    content = gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes()
    for text in content.decode().splitlines():
        try:
            found.append(json.loads(text))
        except json.JSONDecodeError:
            continue
    return found


# --- two versions -------------------------------------------------------------------------------------------------


def kind_of(name: str) -> str:
    """The kind of a result: its name without the point, part or quantity that has it.

    Examples
    --------
    >>> kind_of("stop_impact_rate"), kind_of("a_b_elongation_quantile[2]"), kind_of("x_mean")
    ('impact_rate', 'elongation_quantile', 'x_mean')
    """
    words = name.partition("[")[0].split("_")
    while words[0] in OWNERS - {"x"} and len(words) > 1:
        words = words[1:]
    return "_".join(words)


def deviations(before: Iterable[Line], now: Iterable[Line]) -> tuple[list[Deviation], list[str]]:
    """Of all results that both versions have, and what only one has of the same systems."""
    later = {line["name"]: line for line in now}
    found, missing = [], []
    for line in before:
        other = later.get(line["name"])
        if other is None or other["digest"] != line["digest"]:
            missing.append(f"{line['name']}: {'not simulated' if other is None else 'another problem'}")
            continue
        for name, pair in line["results"].items():
            if name in other["results"]:
                found.append(Deviation(line["name"], name, tuple(pair), tuple(other["results"][name])))
            else:
                missing.append(f"{line['name']}: {name}")
    return found, missing


class Summary(NamedTuple):
    """All deviations of one kind of result."""

    kind: str
    count: int
    systems: int
    mean: float
    rms: float
    largest: float
    is_exact: bool

    @property
    def is_consistent(self) -> bool:
        """Whether mean and rms are what chance makes them: a small error that all systems share shows in the mean.

        Results of one system may depend on each other: the systems are counted as the independent ones.
        """
        if self.is_exact:
            return self.largest <= 1.0
        low, high = scipy.stats.chi2.interval(1.0 - CHANCE, self.systems) / np.float64(self.systems)
        farthest = scipy.stats.norm.isf(0.5 * CHANCE)
        return low <= self.rms**2 <= high and abs(self.mean) * math.sqrt(self.systems) <= farthest


def summary(found: Iterable[Deviation]) -> list[Summary]:
    """The kinds in alphabetical order; what is known beforehand is a kind of its own."""
    kinds = defaultdict[tuple[str, bool], list[Deviation]](list)
    for each in found:
        kinds[kind_of(each.name), each.is_exact].append(each)
    return [_summed(kind, is_exact, own) for (kind, is_exact), own in sorted(kinds.items())]


def _summed(kind: str, is_exact: bool, own: Sequence[Deviation]) -> Summary:
    z, systems = np.array([each.z for each in own]), len({each.system for each in own})
    mean, rms, largest = float(z.mean()), float(np.sqrt((z**2).mean())), float(np.abs(z).max())
    return Summary(kind + " (exact)" * is_exact, len(own), systems, mean, rms, largest, is_exact)


def show(before: Path, now: Path) -> int:
    """Print the table; 1 if the versions differ."""
    found, missing = deviations(lines_of(before), lines_of(now))
    rows = summary(found)
    print(f"{'result':38} {'count':>6} {'systems':>7} {'mean z':>6} {'rms z':>6} {'largest':>7}")
    for row in rows:
        numbers = f"{row.count:6} {row.systems:7} {row.mean:6.2f} {row.rms:6.2f} {row.largest:7.2f}"
        print(f"{row.kind:38} {numbers}{'' if row.is_consistent else '  differs'}")
    sampled = [each for each in found if not each.is_exact]
    rms = math.sqrt(sum(each.z**2 for each in sampled) / max(len(sampled), 1))
    print(f"\n{len(sampled)} results of {len({each.system for each in found})} systems: rms z {rms:.3f}")
    beyond = [each for each in sampled if abs(each.z) > LARGEST]
    by_chance = 2.0 * len(sampled) * scipy.stats.norm.sf(LARGEST)
    print(f"{len(beyond)} beyond {LARGEST:g} standard errors; by chance, if all are independent, {by_chance:.2f}")
    for each in beyond:
        (value, error), (later, its) = each.before, each.now
        print(f"  {each.system}: {each.name} {value:.6g} +- {error:.2g}, now {later:.6g} +- {its:.2g}, z {each.z:.1f}")
    for line in missing:
        print(f"  missing: {line}")
    return int(bool(beyond or missing) or not all(row.is_consistent for row in rows))


def main(words: Sequence[str] | None = None) -> int:
    """One version, or two."""
    parser = argparse.ArgumentParser(prog="compare_versions", description=__doc__.partition("\n")[0])
    doing = parser.add_subparsers(dest="what", required=True)
    one, two = doing.add_parser("run", help="simulate with this version"), doing.add_parser("show", help="compare")
    one.add_argument("file", type=Path)
    one.add_argument("--seed", type=int, required=True, help="another one in each version")
    one.add_argument("--threads", type=int)
    one.add_argument("--only", help="a kind of systems, or one system")
    one.add_argument("--quick", action="store_true", help="few paths: shows that it works, and means nothing")
    two.add_argument("now", type=Path)
    two.add_argument("before", type=Path, nargs="?", default=KEPT)
    chosen = parser.parse_args(words)
    if chosen.what == "show":
        return show(chosen.before, chosen.now)
    run(chosen.file, chosen.seed, chosen.threads, chosen.only, chosen.quick)
    return 0


if __name__ == "__main__":
    warnings.simplefilter("ignore", sp.SpringpotWarning)
    raise SystemExit(main())
