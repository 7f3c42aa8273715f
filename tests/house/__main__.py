"""Measure the house.

python -m tests.house types        where the code asks what kind of problem it has
python -m tests.house way          how a problem goes through the files in a simulation
python -m tests.house masses       where the code asks how many masses there are
python -m tests.house lines [A]    lines of code in src, now in each package, or at a commit
python -m tests.house kinds        where the code asks of what kind a part is; small modules; what is called once
"""

from __future__ import annotations

import sys
from collections import Counter

from tests.house import kinds
from tests.house.lines import lines_at, lines_now
from tests.house.masses import asked
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
    elif what == "masses":
        for place in asked():
            print(f"{place.kind:<6}  {place.file}:{place.line}  {place.text}")
        for package, count in Counter(place.package for place in asked()).items():
            print(f"{package}: {count}")
    elif what == "kinds":
        for file, count in kinds.questions().most_common():
            print(f"{count:>3}  {file}")
        small, (once, private) = kinds.small_modules(), kinds.called_once()
        print(f"{kinds.questions().total()} questions")
        print(f"{len(small)} modules of less than {kinds.FEW} lines: {', '.join(small)}")
        print(f"{once} private functions of {private} are named once")
    elif what == "lines":
        for commit in more:
            print(f"{commit}: {lines_at(commit):,} lines of code in src")
        if not more:
            now = lines_now()
            for package, count in now.items():
                print(f"{package}: {count:,}")
            print(f"{sum(now.values()):,} lines of code in src")
    else:
        print(__doc__)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
