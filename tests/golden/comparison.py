"""Bits of before and now, name by name: what is the same, renamed, excepted, and what is not."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from tests.golden.exceptions import EXCEPTIONS, ROUNDED
from tests.golden.renamed import RENAMED

__all__ = ["Compared", "compared", "renamed", "told"]

Cases = Mapping[str, Mapping[str, str]]
MOST = 40  # lines


@dataclass
class Compared:
    """How many numbers are what, and those that are not right."""

    counts: Counter[str] = field(default_factory=Counter)
    wrong: dict[str, tuple[str, str]] = field(default_factory=dict)
    excepted: dict[str, list[float]] = field(default_factory=dict)
    """For each pattern the relative changes; infinite for what is missing or new, NaN where it is no number."""
    unused: list[str] = field(default_factory=list)


def renamed(name: str, names: Mapping[str, str] | None = None) -> str:
    """The name of today."""
    for old, new in (RENAMED if names is None else names).items():
        name = re.sub(rf"(?<![^/]){old}(?![^/])", new, name)
    return name


def _change(before: str, now: str) -> float:
    """How much a number has changed, relative to what it was."""
    try:
        old, new = float.fromhex(before), float.fromhex(now)
    except ValueError:
        return math.nan
    return abs(new - old) / abs(old) if old else math.inf


def _rounded(name: str, before: str, now: str) -> str | None:
    """The pattern of `ROUNDED` that allows this change."""
    change = _change(before, now)
    for pattern, (most, _) in ROUNDED.items():
        if re.search(pattern, name):
            near = math.isnan(change) or change <= most or abs(float.fromhex(now) - float.fromhex(before)) <= 1e-12
            return pattern if near else None
    return None


def compared(
    before: Cases,
    now: Cases,
    names: Mapping[str, str] | None = None,
    exceptions: Mapping[str, str] | None = None,
) -> Compared:
    """Every kept number under its name of today beside today's; by default with the lists of this folder."""
    patterns = EXCEPTIONS if exceptions is None else exceptions
    found = Compared(excepted={pattern: [] for pattern in (*patterns, *(ROUNDED if exceptions is None else ()))})
    old = {name: bits for numbers in before.values() for name, bits in numbers.items()}
    new = {name: bits for numbers in now.values() for name, bits in numbers.items()}
    wanted = {renamed(name, names): (name, bits) for name, bits in old.items()}
    if len(wanted) < len(old):
        raise ValueError("two numbers have one name of today: renamed.py must keep them apart.")
    for name in sorted(wanted.keys() | new.keys()):
        was, bits = wanted.get(name, ("", ""))
        today, both = new.get(name, ""), name in wanted and name in new
        if both and renamed(bits, names) == today:
            found.counts["same" if was == name and bits == today else "renamed"] += 1
            continue
        pattern = next((pattern for pattern in patterns if re.search(pattern, name)), None)
        pattern = pattern or (_rounded(name, bits, today) if both and exceptions is None else None)
        if pattern is not None:
            found.counts["excepted"] += 1
            found.excepted[pattern].append(_change(bits, today) if both else math.inf)
            continue
        found.counts["differ" if both else "missing" if was else "new"] += 1
        found.wrong[name] = bits, today
    found.unused = [pattern for pattern, changes in found.excepted.items() if not changes]
    return found


def told(found: Compared) -> int:
    """Print it all; 1 if something differs or is missing."""
    for name, (bits, today) in [*found.wrong.items()][:MOST]:
        change = _change(bits, today) if bits and today else math.nan
        print(f"{name}: {bits or '-'} -> {today or '-'}{'' if math.isnan(change) else f'  ({change:.1e})'}")
    if len(found.wrong) > MOST:
        parts = Counter((*name.split("/")[:1], name.rsplit("/", 1)[-1]) for name in found.wrong)
        print(f"... and {len(found.wrong) - MOST} more; most often:")
        for (kind, last), count in parts.most_common(MOST):
            print(f"    {count} {kind}/.../{last}")
    for pattern, changes in found.excepted.items():
        known = [change for change in changes if math.isfinite(change)]
        most = f", relative change at most {max(known):.1e}" if known else ""
        print(f"excepted {len(changes)} {pattern}{most}")
    kinds = ("same", "renamed", "excepted", "differ", "missing", "new")
    print(", ".join(f"{found.counts[kind]} {kind}" for kind in kinds))
    return bool(found.counts["differ"] or found.counts["missing"])
