"""Keep today's bits, or compare with those that were kept.

    python -m tests.golden keep FILE [KIND | KIND:i/N ...]
    python -m tests.golden compare FILE [KIND | KIND:i/N ...]
    python -m tests.golden kinds
    python -m tests.golden few

``systems:2/4`` is the second quarter of that kind.  With kinds, ``keep`` replaces only these in the file.  The bits are
those of one machine and its libraries; keep the file out of the repository.  ``few`` writes the numbers that the test
beside compares on any machine, with room for rounding.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MKL_NUM_THREADS="1")


def _computed(kinds: tuple[str, ...]) -> Iterator[tuple[str, dict[str, str]]]:
    """Each case with the bits of its numbers; the time of each kind is printed."""
    from tests.golden.numbers import KINDS, digested

    for words in kinds or tuple(KINDS):
        kind, _, part = words.partition(":")
        number, count = (int(each) for each in (part or "1/1").split("/"))
        begun, spent, size = time.perf_counter(), time.process_time(), 0
        for place, (case, numbers) in enumerate(KINDS[kind]()):
            if place % count != number - 1:
                continue
            name, found = f"{kind}/{case}", {}
            try:
                found = {f"{name}/{rest}": digested(value) for rest, value in numbers()}
            except Exception as fault:  # the others are wanted all the same
                found[f"{name}/failed"] = f"{type(fault).__name__}: {fault}"
                print(f"{name}: {found[f'{name}/failed']}", file=sys.stderr)
            size += len(found)
            yield name, found
        wall, spent = time.perf_counter() - begun, time.process_time() - spent
        print(f"{words}: {size} numbers in {wall:.0f} s, {spent:.0f} s of processor", flush=True)


def main(what: str, file: str = "", *kinds: str) -> int:
    from tests.golden.comparison import compared, told

    if what == "few":  # for the test, after a change that was meant
        from tests.golden.numbers import FEW, few

        kept = {kind: {name: value for name, (value, _) in few(kind)} for kind in FEW}
        (Path(__file__).parent / "kept.json").write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        return 0
    if what == "kinds":
        from tests.golden.numbers import KINDS

        print(*KINDS, sep="\n")
        return 0
    now = dict(_computed(kinds))
    place = Path(file)
    if what == "keep":
        before = json.loads(place.read_text(encoding="utf-8")) if kinds and place.exists() else {}
        place.write_text(json.dumps(before | now, indent=0), encoding="utf-8")
        print(f"{sum(map(len, now.values()))} kept")
        return 0
    before = json.loads(place.read_text(encoding="utf-8"))
    if not any(":" in kind for kind in kinds):  # a case that is gone is missing
        wanted = [kind.partition(":")[0] for kind in kinds]
        now = {case: {} for case in before if not kinds or case.split("/")[0] in wanted} | now
    before = {case: before.get(case, {}) for case in now}
    return told(compared(before, now))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
