"""The catalogue of quantities: its page, its names, and that other rooms agree with it."""

from __future__ import annotations

import importlib
import re
import runpy
from pathlib import Path

import pytest

import springpot as sp
from springpot.problem.catalogue import CATALOGUE, is_controlled, possible_results, unit_of, unit_of_result
from springpot.problem.messages import MESSAGES
from springpot.problem.system import OF_THE_WHOLE
from springpot.simulation.watch.observables import COUNTED, EXTREMES

DOCS = Path(__file__).parents[2] / "docs"


SCRIPT = runpy.run_path(str(DOCS / "make_catalogues.py"))
INTERNAL = {"OutOfTimeError", "UntrustedFolderError"}  # are caught before a caller sees them


@pytest.mark.parametrize("page", SCRIPT["PAGES"])
def test_the_page_is_that_of_the_catalogue(page: str) -> None:
    """Made by ``python docs/make_catalogues.py``."""
    assert SCRIPT["PAGES"][page]() == (DOCS / page).read_text(encoding="utf-8")


def test_the_page_of_warnings_and_errors_has_all_of_them() -> None:
    text = (DOCS / "warnings.md").read_text(encoding="utf-8")
    assert [name for name in MESSAGES if f"| `{name}` |" not in text] == []
    source = "".join(file.read_text(encoding="utf-8") for file in (DOCS.parent / "src").rglob("*.py"))
    classes = set(re.findall(r"^class ([A-Z]\w*(?:Error|Warning))\(", source, flags=re.M))
    assert {name for name in classes - {"SpringpotWarning"} if name not in text} == INTERNAL
    for place, (error, _) in SCRIPT["ERRORS"].items():
        module, _, name = place.rpartition(".")
        assert getattr(importlib.import_module(module), name) is error


def test_one_soft_spring_more_renames_nothing() -> None:
    parts = sp.Mass(2.0), sp.Spring(80.0), sp.Springpot(0.5, 1.0), sp.Barrier(-0.01, 0.7), sp.WhiteNoise(1.0)
    more = sp.System(*parts, sp.PolynomialSpring((0.0, 0.0, 1.0)))
    assert possible_results(more) == possible_results(sp.System(*parts))
    assert {unit_of_result(more, name) for name in ("damping_power", "barrier_power", "input_power")} == {"W"}


@pytest.mark.parametrize("entry", CATALOGUE, ids=lambda entry: entry.name)
def test_every_entry_is_found_by_its_name(entry) -> None:
    name = entry.name.replace("<part>", "lower_stop").replace("<point>", "box")
    assert unit_of(name, heavy=True) == entry.unit
    assert is_controlled(name) == entry.controlled
    assert entry.meaning
    assert entry.when


def test_units_with_and_without_a_mass() -> None:
    assert (unit_of("damping_power", True), unit_of("damping_power")) == ("W", "m2 s-3")
    assert (unit_of("stop_force_mean", True), unit_of("stop_force_mean")) == ("N", "m s-2")
    assert (unit_of("damping_virial", True), unit_of("damping_virial")) == ("J", "m2 s-2")
    assert (unit_of("x_density"), unit_of("v_density")) == ("m-1", "s m-1")
    assert unit_of("nothing") == ""


def test_observers_have_the_units_of_the_catalogue() -> None:
    assert {name: unit_of(name) for name in COUNTED} == COUNTED
    assert {name: unit_of(f"{name}_quantile") for name in EXTREMES} == EXTREMES


def test_no_part_can_have_a_result_of_the_whole_system() -> None:
    """Else one of two numbers with one name would be lost."""
    endings = [entry.name.removeprefix("<part>") for entry in CATALOGUE if entry.name.startswith("<part>")]
    of_all = [entry.name for entry in CATALOGUE if not entry.name.startswith("<part>")] + list(COUNTED)
    taken = {name.removesuffix(ending) for name in of_all for ending in endings if name.endswith(ending)}
    assert taken - {""} <= OF_THE_WHOLE.keys()
    for name in OF_THE_WHOLE:
        with pytest.raises(ValueError, match=f"^{name} cannot be the name of a part, for {name}_"):
            sp.System(sp.Spring(1.0), **{name: sp.PolynomialDashpot((0.0, 0.0, 0.5))})
    with pytest.raises(ValueError, match="results of all walls together are called so"):
        sp.System(sp.Spring(1.0), stop=sp.Barrier(0.0), barrier=sp.ColoredNoise(1.0, 2.0))
