"""Keep today's bits, or compare with those that were kept.

    python -m tests.golden keep FILE [KIND ...]
    python -m tests.golden compare FILE [KIND ...]
    python -m tests.golden few

The bits are those of one machine and its libraries; keep the file out of the repository.  The test beside compares
a few numbers on any machine, with room for rounding.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", MKL_NUM_THREADS="1")


def main(what: str, file: str = "", *kinds: str) -> int:
    from tests.golden.numbers import FEW, KINDS, digested, few

    if what == "few":  # for the test, after a change that was meant
        kept = {kind: {name: value for name, (value, _) in few(kind)} for kind in FEW}
        (Path(__file__).parent / "kept.json").write_text(json.dumps(kept, indent=1) + "\n")
        return 0
    now = {f"{kind}/{name}": digested(value) for kind in (kinds or KINDS) for name, value in KINDS[kind]()}
    if what == "keep":
        Path(file).write_text(json.dumps(now, indent=0))
        print(f"{len(now)} kept")
        return 0
    before = {
        name: bits
        for name, bits in json.loads(Path(file).read_text()).items()
        if not kinds or name.split("/")[0] in kinds
    }
    wrong = [name for name in before.keys() | now.keys() if before.get(name) != now.get(name)]
    for name in sorted(wrong)[:40]:
        print(f"{name}: {before.get(name)} -> {now.get(name)}")
    print(f"{len(before)} before, {len(now)} now, {len(wrong)} differ")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
