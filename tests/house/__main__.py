"""Measure the house.

python -m tests.house types        where the code asks what kind of problem it has
python -m tests.house way          how a problem goes through the files in a simulation
python -m tests.house lines [A]    lines of code in src, now or at a commit
"""

from __future__ import annotations

import sys

from tests.house.lines import lines_at
from tests.house.types import questions
from tests.house.way import compared


def main(what: str = "", *more: str) -> int:
    if what == "types":
        found = questions()
        for each in found:
            print(f"{each.at:<5}  {each.file}:{each.line}  {each.text}")
        print(", ".join(f"{sum(each.at == at for each in found)} {at}" for at in ("door", "walk", "after")))
    elif what == "way":
        for line in compared():
            print(line)
    elif what == "lines":
        for commit in more or ("HEAD",):
            print(f"{commit}: {lines_at(commit):,} lines of code in src")
    else:
        print(__doc__)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
