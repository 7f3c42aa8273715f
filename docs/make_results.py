"""Writes the page *All results* from the catalogue of quantities: ``python docs/make_results.py``."""

from __future__ import annotations

from pathlib import Path

from springpot.problem.catalogue import CATALOGUE, Quantity
from springpot.problem.parts.registration import per_unit_mass

__all__ = ["page"]

PAGE = Path(__file__).parent / "results.md"
HEAD = """\
# All results

<!-- written by docs/make_results.py -->

Every number that a run can have, by its name. It has a standard error, under the same name with `_se`. `<part>` stands
for the name of a part, as in `stop_impact_rate`; in the data set of `sp.simulate` the walls and contacts have the
dimension `barrier`, as in `barrier_impact_rate`. Powers, forces and virials are those of the mass, or per unit mass in
a system without a `Mass`: the second unit. $m$ is the mass, $v^-$ the velocity before an impact, $\\nu$ the impacts per
unit time, $r$ the restitution. With `rtol=` the numbers that are marked have a bounded error, under their name with
`_error`.

| name | unit | meaning | formula | when | `rtol` | dimensions |
|---|---|---|---|---|---|---|
"""


def page() -> str:
    """The text of the page."""
    return HEAD + "".join(f"| {' | '.join(_cells(entry))} |\n" for entry in CATALOGUE)


def _cells(entry: Quantity) -> list[str]:
    units = dict.fromkeys((entry.unit, per_unit_mass(entry.unit)))
    return [
        f"`{entry.name}`", ", ".join(units), entry.meaning,
        f"${entry.formula}$".replace("|", r"\vert ") if entry.formula else "", entry.when,
        "yes" if entry.controlled else "", ", ".join(f"`{name}`" for name in entry.dimensions),
    ]  # fmt: skip


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
