"""The catalogue of quantities: its page, its names, and that other rooms agree with it."""

from __future__ import annotations

import importlib
import random
import re
import runpy
from itertools import pairwise
from pathlib import Path

import pytest

import springpot as sp
from springpot.problem import catalogue
from springpot.problem.catalogue import CATALOGUE, is_controlled, possible_results, unit_of, unit_of_result
from springpot.problem.messages import MESSAGES
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.watch.counted_impacts import COUNTED
from springpot.simulation.watch.extremes import EXTREMES

DOCS = Path(__file__).parents[2] / "docs"


SCRIPT = runpy.run_path(str(DOCS / "make_catalogues.py"))
INTERNAL = {"MissingSymbolError", "OutOfTimeError", "UntrustedFolderError"}  # are caught before a caller sees them


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
    assert [unit_of(name) for name in COUNTED] == ["s-1", "m s-1", "m2 s-2"]
    assert [unit_of(f"{name}_quantile") for name in EXTREMES] == ["m", "m", "m s-1", "m s-1"]


TWO = sp.Mass(1.0, at="box"), sp.Mass(1.0, at="lid"), sp.Spring(1.0, between=("ground", "box"))
LINK, LID = ("box", "lid"), ("ground", "lid")
FOUR = "a", "a_b", "b_c", "c"
COLLIDING = {
    "a result of the whole": (
        (sp.Spring(1.0),), {"damping": sp.PolynomialDashpot((0.0, 0.0, 0.5))}, "damping_power"),
    "a force on request": ((sp.Spring(1.0),), {"damping": sp.Dashpot(0.5)}, "damping_force_mean"),
    "power that is fed in": ((sp.Spring(1.0),), {"input": sp.ColoredNoise(1.0, 2.0)}, "input_power"),
    "all walls": ((sp.Spring(1.0),), {"stop": sp.Barrier(0.0), "barrier": sp.ColoredNoise(1.0, 2.0)}, "barrier_power"),
    "counted impacts": (
        (sp.Spring(1.0),), {"stop": sp.Barrier(-1.0), "stop_counted": sp.Barrier(1.0, free_side="below")},
        "stop_counted_impact_rate"),
    "counted impacts of several": (
        (*TWO, sp.Spring(1.0, between=LINK)),
        {"stop": sp.Barrier(-1.0, between=LINK), "stop_counted": sp.Barrier(-1.0, between=LID)},
        "stop_counted_impact_rate"),
    "peak forces": (
        (sp.Spring(1.0),), {"stop": sp.Contact(-1.0, 9.0), "stop_peak": sp.Contact(1.0, 9.0, free_side="below")},
        "stop_peak_force_mean"),
    "a part like a mass": ((*TWO, sp.Spring(1.0, between=LINK)), {"box": sp.Dashpot(1.0, between=LID)}, "box_distance"),
    "a part like a pair": (
        (*TWO, sp.Spring(1.0, between=LINK)), {"box_lid": sp.Dashpot(1.0, between=LID)}, "box_lid_elongation"),
    "a mass like a speed": (
        (*TWO, sp.Mass(1.0, at="stop_impact"), sp.Spring(1.0, between=LINK),
         sp.Spring(1.0, between=("box", "stop_impact"))),
        {"stop": sp.Barrier(-1.0, between=LID)}, "stop_impact_speed"),
    "two pairs": (
        (*(sp.Mass(1.0, at=name) for name in FOUR), *(sp.Spring(1.0, between=("ground", name)) for name in FOUR),
         sp.Spring(1.0, between=("a", "b_c")), sp.Spring(1.0, between=("a_b", "c"))), {}, "a_b_c_elongation_mean"),
}  # fmt: skip


@pytest.mark.parametrize("case", COLLIDING)
def test_no_two_things_have_a_result_of_one_name(case: str) -> None:
    """Else one of two numbers with one name would be lost; the sentence names both, and the result."""
    parts, named, result = COLLIDING[case]
    with pytest.raises(
        ValueError, match=rf"^{result} would be the name of two results, of the .+ and of the .+: give .+\.$"
    ):
        sp.System(*parts, **named)


WORDS = (
    *("a", "x", "v", "force", "impact", "counted", "speed", "peak"),
    *("a_x", "x_force", "a_counted", "a_impact", "barrier"),
)


def one_of_many(rng: random.Random, ends: tuple[str, str] | None) -> object:
    """A part, whose results are others with every kind."""
    noise = sp.ColoredNoise(1.0, 2.0, **({"on": ends[1]} if ends else {}))
    stops = sp.Barrier(-1.0, between=ends), sp.Contact(-1.0, 2.0, between=ends)
    dampers = sp.Dashpot(1.0, between=ends), sp.PolynomialDashpot((0.0, 0.0, 1.0), between=ends)
    return rng.choice([sp.Spring(1.0, between=ends), noise, *stops, *dampers])


def test_most_systems_need_no_list_of_their_results() -> None:
    """What tells them from the others, in little time, lets no name through that two things have."""
    rng = random.Random(1)
    names = {False: 0, True: 0}
    for _ in range(150):
        masses = rng.sample(WORDS, rng.choice([0, 2, 3]))
        ends = [("ground", mass) for mass in masses] + [*pairwise(masses)] or [None]
        named = {name: one_of_many(rng, rng.choice(ends)) for name in rng.sample(WORDS, 3)}
        held = [sp.Spring(1.0, between=at) for at in ends]
        try:
            with pytest.MonkeyPatch.context() as all_names:
                all_names.setattr(catalogue, "_may_collide", lambda system: True)
                system = sp.System(*(sp.Mass(1.0, at=mass) for mass in masses), *held, **named)
        except ValueError as error:
            if "would be the name of two results" not in str(error):
                continue  # walls that hide each other
            with pytest.raises(ValueError, match="would be the name of two results"):
                sp.System(*(sp.Mass(1.0, at=mass) for mass in masses), *held, **named)
            names[True] += 1
        else:
            owners = [(own, who) for entry in (*catalogue.ASKED, *CATALOGUE) for own, who in entry.owned(system)]
            assert len({own for own, _ in owners}) == len({*owners})
            names[False] += 1
    assert min(names.values()) > 20


def test_what_can_be_asked_for_is_what_the_simulation_sees() -> None:
    """The names that first passages, exceedance and rainflow take are those that the catalogue keeps apart."""
    stop = sp.Barrier(-1.0, between=LINK)
    several = sp.System(
        *TWO, sp.Spring(1.0, between=LINK, count=2, group="link"), sp.Springpot(0.5, 1.0, between=LID), stop=stop
    )
    for system in (several, sp.Oscillator()):
        motion, names = motion_of(system), {name for name, _ in catalogue.asked_for(system)}
        assert names == {*motion.levels, *motion.speeds, *motion.outputs}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("class", "must not be 'class', a keyword of Python: class_ can be a name"),
        ("my stop", "must be a word of letters, digits and _, not 'my stop'"),
        ("a\nb", "must be a word of letters, digits and _"),
        ("", "must be a word of letters, digits and _, not ''"),
        ("\N{LATIN SMALL LIGATURE FI}t", "must be 'fit', in the letters that Python makes of"),
        ("x" * 101, "must have at most 100 letters, not 101"),
    ],
)
def test_names_are_those_of_python(name: str, said: str) -> None:
    """``run.<name>`` finds them, and two that look alike are one."""
    table = {"name": name, "kind": "spring", "stiffness": 1.0}
    for make in (
        lambda: sp.System(**{name: sp.Spring(1.0)}),
        lambda: sp.read_system({"parts": [table]}),
        lambda: sp.Mass(1.0, at=name) if name else sp.Point(name, ("m",), (1.0,)),
        lambda: sp.WhiteNoise(1.0, on=name),
        lambda: sp.free(name, 1.0, (0.5, 2.0)),
        lambda: sp.simulate(sp.Oscillator(), paths=1, duration=1.0, observables={name: lambda t, x, v: x}),
    ):
        with pytest.raises(ValueError, match=re.escape(said) if "digits" not in said else "letters, digits|'mass'"):
            make()
