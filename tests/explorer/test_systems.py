"""The page of a system of parts, in a real Chromium: its sliders, its numbers, what it refuses, and its file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.answers import solve, table
from springpot.explorer.examples import examples
from springpot.explorer.motion import marks, record, voltages
from springpot.explorer.protocol import Problem, parse
from springpot.explorer.question import Opened, question_of
from springpot.explorer.sliders import changed, described_parts, numbers, sliders
from springpot.explorer.views import labels, sizes, view_of
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.theory.registry import METHODS
from tests.explorer.conftest import Server, running
from tests.explorer.test_numbers import gathered
from tests.explorer.test_page import CUT, OVERLAPPING, Tab, opened
from tests.sizes import validation
from tests.struck import rates_of

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page

FOLDER = Path(__file__).with_name("systems")
FILES = sorted(FOLDER.glob("*.toml"))
USUAL = FOLDER / "two_walls.toml"
QUICK = "paths=128"


def asked(**numbers: float) -> Problem:
    return Problem(numbers={name.replace("__", "-"): value for name, value in numbers.items()})


# --- without a browser ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_number_of_a_system_has_a_slider_around_it(file: Path) -> None:
    system = sp.read_system(file)
    found = sliders(system, sizes(system))
    assert {one.name: one.value for one in found} == numbers(system)
    assert changed(system, numbers(system)) == system
    for one in found:
        assert one.begin < one.end
        assert one.begin <= one.value <= one.end
        assert not one.log or one.begin > 0.0
        assert one.symbol
        assert one.said
        moved = one.value * 1.01 if one.value else 0.01 * one.end
        if not one.name.endswith(("order", "restitution")):
            assert changed(system, {one.name: moved}) != system
    assert [part["name"] for part in described_parts(system)] == list(system.names)


def test_every_kind_of_part_has_its_sliders() -> None:
    """Also those that no file here has: none is without words, and a nested part's numbers come back to it."""
    system = sp.System(
        sp.Mass(2.0), sp.Spring(80.0), sp.PolynomialSpring((0.0, 1.0, 5.0)), sp.PolynomialDashpot((0.1, 0.2, 0.3)),
        sp.VanDerPol(0.1, 0.5), sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(2.0)), sp.Maxwell(2.0, 1.0),
        sp.Barrier(-0.3, sp.PowerRestitution(0.7, 0.1)), sp.Barrier(0.4, lambda speed: 0.5, free_side="below"),
        sp.Dashpot(sp.free("c", 0.4, (0.1, 0.9))), sp.Constant(-0.5), sp.Harmonic(0.1, 20.0),
        sp.PoissonImpulses(2.0, 0.1), sp.ParametricNoise(0.1),
        sp.Friction(0.0), sp.Force(abs),
    )  # fmt: skip
    found = {one.name: one for one in sliders(system, {"frequency": 6.0, "length": 0.1})}
    assert found["fractional_maxwell-springpot-order"].value == 0.5
    assert found["friction-force"].end > 0.0
    assert (found["dashpot-coefficient"].begin, found["dashpot-coefficient"].end) == (0.1, 0.9)
    assert found["barrier_1-restitution-exponent"].value == 0.25
    assert "barrier_2-restitution" not in found
    assert found["polynomial_spring-coefficients-2"].unit == "N/m²"
    other = changed(system, {"fractional_maxwell-spring-stiffness": 3.0, "polynomial_dashpot-coefficients-3": 0.4})
    assert other.of(sp.FractionalMaxwell)[0] == sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(3.0))
    assert other.of(sp.Dashpot)[0].coefficient.name == "c"  # type: ignore[attr-defined]
    assert changed(system, {"barrier_1-restitution-speed": 0.2}).of(sp.Barrier)[0].restitution.speed == 0.2  # type: ignore[union-attr]
    assert other.of(sp.PolynomialDashpot)[0].coefficients == (0.1, 0.2, 0.4)


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"lower__restitution": 1.5}, "lower.restitution must"),
        ({"mass__value": -1.0}, "mass.value must"),
        ({"upper__position": -0.01}, "the walls must leave room"),
        ({"nobody__stiffness": 1.0}, "numbers: this system has no number"),
    ],
)
def test_what_the_system_refuses_is_said_in_its_own_words(numbers: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=f"^{sentence}"):
        question_of(asked(**numbers), Opened(sp.read_system(USUAL)))


def test_messages_of_a_system() -> None:
    found = parse(json.dumps({"kind": "problem", "generation": 2, "numbers": {"mass-value": 2}, "paths": 64}))
    assert isinstance(found, Problem)
    assert found.numbers == {"mass-value": 2.0}
    with pytest.raises(ValueError, match="numbers: this system has no number 'mass-value'"):
        question_of(found, Opened())
    for wrong in ({"numbers": {"mass-value": "2"}}, {"numbers": {"mass-value": math.nan}}, {"numbers": [1.0]}):
        with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
            parse(json.dumps({"kind": "problem", **wrong}))


def test_the_grown_ensemble_of_a_system_is_the_run() -> None:
    """Numbers, errors, warnings and counts, to the last bit."""
    system = sp.read_system(USUAL)
    ours = gathered(system, paths=192, seed=4)
    run = sp.simulate(system, paths=192, seed=4, distributions=True, step=ours.simulation.settings.step)
    values, errors = ours.estimates()
    np.testing.assert_equal(values, {name: run[name].value for name in run})
    np.testing.assert_equal(errors, {name: run[name].error for name in run})
    assert ours.warnings() == run.warnings
    for name, found in ours.distributions().items():
        np.testing.assert_array_equal(found.counts.sum(axis=0), run.distributions[name].counts.sum(axis=0))
    assert {name for name, _, _ in labels(system, [*values])} >= {"lower_power", "upper_impact_rate", "input_power"}


def test_the_shown_path_strikes_both_walls_as_the_run_counts() -> None:
    system = sp.read_system(USUAL)
    simulation = simulation_of(plan_of(system, paths=64, seed=2, start="rest", duration=10.0, window=(0.0, 10.0)))
    run = sp.simulate(system, paths=64, seed=2, start="rest", duration=10.0, window=(0.0, 10.0), record=64)
    shown = record(simulation, 0)
    np.testing.assert_array_equal(shown.x[0], run.record[0, :, 0])
    marked = [marks(system, run.settings.step, *path.T[:, None]) for path in run.record]
    lower = sum((path[steps, 1] < 0.0).sum() for path, (steps, _) in zip(run.record, marked, strict=True))
    upper = sum((path[steps, 1] > 0.0).sum() for path, (steps, _) in zip(run.record, marked, strict=True))
    assert [sum((walls == n).sum() for _, walls in marked) for n in (0, 1)] == [lower, upper]
    assert lower / 640.0 == pytest.approx(run["lower_impact_rate"].value, rel=0.05)
    assert upper / 640.0 == pytest.approx(run["upper_impact_rate"].value, rel=0.05)


def test_a_circuit_s_voltage_along_a_path_obeys_its_equation() -> None:
    """A harmonic motion: V is theta x' over (1 / R + i w Cp), once the start is over."""
    circuit, w, step = sp.PiezoelectricCircuit(2.0, 0.5, 0.7), 3.0, 1e-3
    time = step * np.arange(20_000)
    found = voltages(sp.System(sp.Spring(1.0), circuit), step, np.sin(w * time)[None])[0]
    exact = (2.0 * w / (1.0 / 0.5 + 1j * w * 0.7) * np.exp(1j * w * time)).real
    np.testing.assert_allclose(found[10_000:], exact[10_000:], atol=2e-5 + step)


def test_a_system_that_is_the_paper_s_problem_has_its_numbers_too() -> None:
    """Its powers are the device's, in W; the paper's view is added, with its scales."""
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Springpot(0.5, 1.0), sp.Barrier(-0.2), sp.WhiteNoise(1.0))
    found = question_of(asked(mass__value=4.0), Opened(system, "device.toml"))
    assert found.system == changed(system, {"mass-value": 4.0})
    assert found.file == "device-changed.toml"
    assert labels(system, ["damping_power"]) == [("damping_power", "taken by springpot", "W")]
    view, paper = view_of(system), sp.Dimensionless.of(system)
    assert view["groups"][0]["columns"][0] == ("amplitude_mean_square", "⟨A²⟩")
    assert view["paper"] == {
        "order": 0.5, "strength": paper.dimensionless_coefficient, "wall": paper.dimensionless_position,
        "restitution": 1.0, "frequency": 2.0, "length": paper.length_scale, "mass": 2.0,
    }  # fmt: skip
    assert view_of(sp.read_system(USUAL))["paper"] is None


def test_a_wall_that_is_left_out_makes_another_system_the_paper_s() -> None:
    system = sp.System(
        sp.Spring(8.0), sp.Springpot(0.5, 1.0), sp.Barrier(-0.2), sp.Barrier(0.3, free_side="below"), sp.WhiteNoise(1.0)
    )
    opened = Opened(system, "device.toml")
    assert question_of(Problem(), opened).papers == ()
    found = question_of(Problem(without=["barrier_2"]), opened)
    assert found.papers[0].barrier == sp.Barrier(-0.2)
    assert found.command == "springpot simulate device-changed.toml --paths 10000 --seed 1"


def test_examples_are_possible_and_differ() -> None:
    for page in (Opened(), *(Opened(sp.read_system(file), file.name) for file in FILES)):
        found = [*examples(page.system, page.file)]
        assert found[0]["numbers"] == {}
        cases = [question_of(Problem(numbers=one["numbers"], without=one["without"]), page).system for one in found]
        assert cases[0] == page.system
        assert all(one not in cases[:n] for n, one in enumerate(cases))


def test_a_system_without_dampers_has_its_words() -> None:
    system = sp.System(sp.Spring(4.0), sp.Friction(0.1), sp.WhiteNoise(1.0))
    assert [said for _, said, _ in labels(system, ["input_power", "friction_power"])] == [
        "fed in by all excitations", "taken by friction",
    ]  # fmt: skip


def test_theory_of_a_system_for_the_page() -> None:
    system = sp.System(
        sp.Spring(4.0), sp.Dashpot(0.5), sp.Barrier(-0.3), sp.Barrier(0.9, free_side="below"), sp.WhiteNoise(1.0)
    )
    answers = {name: answer for name in METHODS if (answer := solve(system, name)[0]) is not None}
    found: dict[str, Any] = table(system, answers, {})
    exact = sp.theory.exact(system)
    assert found["recommended"] == "exact"
    assert found["methods"]["exact"]["moments"]["barrier_1_impact_rate"] == pytest.approx(rates_of(exact)[0])
    density = np.array(found["methods"]["exact"]["densities"]["x"])
    assert np.trapezoid(density, found["places"]["x"]) == pytest.approx(1.0, abs=1e-3)


# --- in the browser ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    made = browser.new_context(viewport={"width": 1440, "height": 900}, accept_downloads=True)
    made.grant_permissions(["clipboard-read", "clipboard-write"])
    yield made
    made.close()


@pytest.fixture(scope="module")
def usual() -> Iterator[Server]:
    with running(str(USUAL)) as server:
        yield server


def to_file(page: Page) -> None:
    page.locator("#example").select_option("0")


def shown(tab: Tab) -> dict[str, float]:
    """Every number of Monte Carlo on the page, by name."""
    cells = "[...document.querySelectorAll('tr.measured [data-quantity], #parts-table [data-quantity]')]"
    found = tab.page.evaluate(f"{cells}.map((cell) => [cell.dataset.quantity, cell.dataset.value])")
    return {name: float(value) if value else math.nan for name, value in found}


@pytest.mark.validation  # every day: of several masses, in test_several.py
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_page_shows_the_numbers_of_simulate(context: BrowserContext, usual: Server, file: Path) -> None:
    """And its sliders are those of the file; a slider changes the numbers as Python does; the file comes back whole."""
    system = sp.read_system(file)
    serving = nullcontext(usual) if file == USUAL else running(str(file))
    with serving as server, opened(context, server, QUICK) as tab:
        page, run = tab.page, sp.simulate(system, paths=128, seed=1)
        assert page.locator("#sliders [type=range]").count() == len(numbers(system))
        found = shown(tab)
        assert found.keys() - {"x_rms"} <= {*run}
        for name in found.keys() & {*run}:
            np.testing.assert_equal(found[name], run[name].value, err_msg=name)
        assert found["x_rms"] == math.sqrt(run["x_mean_square"].value)
        slider = next(iter(numbers(system)))
        tab.changed(lambda: page.locator(f"#slider-{slider}").press("ArrowRight"))
        if slider == "spring-stiffness":  # per unit mass it is shown as a frequency
            page.locator(f"#unit-{slider}").select_option("k")
        value = float(page.locator(f"#field-{slider}").input_value())
        other = sp.simulate(changed(system, {slider: value}), paths=128, seed=1)
        assert shown(tab)["v_mean_square"] == other["v_mean_square"].value != run["v_mean_square"].value
        with page.expect_download() as loading:
            page.locator("#save-file").click()
        assert loading.value.suggested_filename == f"{file.stem}-changed.toml"
        assert sp.read_system(loading.value.path()) == changed(system, {slider: value})
        for width in (1440, 390):
            page.set_viewport_size({"width": width, "height": 850})
            page.evaluate("controls.open = true")
            page.wait_for_timeout(400)
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert [page.evaluate(CUT), page.evaluate(OVERLAPPING)] == [[], []]
        page.set_viewport_size({"width": 1440, "height": 900})


@pytest.fixture(scope="module")
def device(context: BrowserContext, usual: Server) -> Iterator[Tab]:
    with opened(context, usual, QUICK) as tab:
        yield tab


def test_a_number_that_is_not_possible_is_said_beside_it_and_the_last_state_stays(device: Tab) -> None:
    page, before, asked_before = device.page, shown(device), device.generation()
    field, said = page.locator("#field-lower-restitution"), page.locator("#range-lower-restitution")
    for wrong, sentence in (("1.5", "lower.restitution must"), ("-0.1", "lower.restitution must")):
        field.fill(wrong)
        said.filter(has_text=sentence).wait_for()
        assert field.get_attribute("aria-invalid") == "true"
        assert field.input_value() == wrong
    assert (shown(device), device.generation()) == (before, asked_before)
    at = device.time()
    device.wait(f"springpotExplorer.time !== {at}")  # the motion goes on
    page.locator("#field-upper-restitution").focus()
    assert field.input_value() == "0.7"
    assert said.is_hidden()
    page.locator("#field-upper-position").fill("-7")  # mm
    page.locator("#range-upper-position").filter(has_text="the walls must leave room").wait_for()
    device.changed(lambda: page.locator("#field-upper-position").fill("4.5"))
    assert page.locator("#range-upper-position").is_hidden()
    assert shown(device)["upper_impact_rate"] > before["upper_impact_rate"]
    device.changed(lambda: to_file(page))
    assert shown(device) == before


SEEN = """(id) => {
    const { left, top, width, height } = document.getElementById(id).getBoundingClientRect();
    const at = (x, y) => document.elementFromPoint(left + x * width, top + y * height)?.closest(`#${id}`);
    return Boolean(at(0.1, 0.1) && at(0.1, 0.9));
}"""


@pytest.mark.parametrize(("width", "height"), [(1440, 900), validation(1280, 600), (390, 844)])
def test_the_reason_of_a_refusal_is_seen_where_the_slider_is(device: Tab, width: int, height: int) -> None:
    """The slider was the last that was seen above the buttons, and the reason was behind them."""
    page = device.page
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("controls.open = true")
    page.wait_for_timeout(300)
    page.evaluate("""() => {
        const slider = document.getElementById("slider-upper-position"), wide = innerWidth > 900;
        const end = wide ? document.querySelector(".share").getBoundingClientRect().top : innerHeight;
        (wide ? controls : document.scrollingElement).scrollTop += slider.getBoundingClientRect().bottom + 2 - end;
    }""")
    page.locator("#slider-upper-position").evaluate(
        "(slider) => { slider.value = 0; slider.dispatchEvent(new Event('input', { bubbles: true })); }"
    )
    page.locator("#range-upper-position").filter(has_text="the walls must leave room").wait_for()
    assert page.evaluate(SEEN, "range-upper-position")
    assert page.evaluate(SEEN, "slider-upper-position")
    to_file(page)
    page.set_viewport_size({"width": 1440, "height": 900})


def test_a_panel_that_scrolls_has_a_bar(device: Tab) -> None:
    """One of its own, for systems hide theirs until something is scrolled."""
    panel = device.page.locator("#controls")
    assert panel.evaluate("(panel) => panel.scrollHeight > panel.clientHeight")
    assert panel.evaluate("(panel) => getComputedStyle(panel, '::-webkit-scrollbar').width") == "9px"


def test_on_a_phone_the_picture_stays_while_the_sliders_are_scrolled(device: Tab) -> None:
    page = device.page
    page.set_viewport_size({"width": 390, "height": 844})
    page.evaluate("controls.open = true")
    page.wait_for_timeout(300)
    for name in ("mass-value", "springpot-order", "shaking-intensity"):
        page.locator(f"#slider-{name}").evaluate("(slider) => slider.scrollIntoView({ block: 'center' })")
        assert page.evaluate(SEEN, "scene")
        assert page.evaluate(SEEN, f"slider-{name}")
    page.set_viewport_size({"width": 1440, "height": 900})
    device.wait("document.querySelector('#results > #motion') !== null", seconds=5.0)


def test_a_wall_that_is_too_far_away_to_be_drawn_is_said(device: Tab) -> None:
    said = device.page.locator("#out-of-view")
    assert said.is_hidden()
    device.page.locator("#field-upper-position").fill("6000")
    said.filter(has_text="Out of view: upper at 6000 mm →").wait_for()
    device.changed(lambda: to_file(device.page))
    said.wait_for(state="hidden")


def test_the_equation_and_what_is_not_covered(device: Tab) -> None:
    said = device.page.locator("#equation").inner_text()
    assert said.startswith("0.8 ẍ + 3200 x + 3·107 x3 + 150 D0.3 x")
    assert "x ≥ −6 mm" in said
    silent = device.page.locator("#silent").inner_text()
    assert "closure" in silent
    assert "no answer here: hardening cannot be part of an Oscillator" in silent
    assert device.theory("envelope", "lower_impact_rate") > 0.5


def test_a_link_and_the_copies_have_the_changed_numbers(device: Tab, tmp_path: Path) -> None:
    page = device.page
    device.changed(lambda: page.locator("#field-springpot-order").fill("0.4"))
    page.locator("#copy-link").click()
    link = page.evaluate("navigator.clipboard.readText()")
    assert link.endswith("#springpot-order=0.4&seed=1&paths=128&start=stationary")
    page.locator("#copy-command").click()
    page.locator("#copied").filter(has_text="Command copied").wait_for()
    command = page.evaluate("navigator.clipboard.readText()")
    assert command == "springpot simulate two_walls-changed.toml --paths 128 --seed 1"
    page.locator("#copy-python").click()
    page.locator("#copied").filter(has_text="Python copied").wait_for()
    program = page.evaluate("navigator.clipboard.readText()")
    found: dict[str, Any] = {}
    exec(program[: program.index("run = ")], found)
    assert found["system"] == changed(sp.read_system(USUAL), {"springpot-order": 0.4})
    held = shown(device)
    device.changed(lambda: to_file(page))
    device.ask("springpot-order=0.4&paths=128")
    assert shown(device) == held


@pytest.mark.validation  # every day: an unsound link, in test_page.py
def test_a_link_that_is_not_possible_opens_the_file(context: BrowserContext, usual: Server) -> None:
    with opened(context, usual, "upper-position=-0.01&paths=128", wait=False) as tab:
        tab.wait("springpotExplorer.generation > 0")
        banner = tab.page.locator("#banner").inner_text()
        assert banner.startswith("The link's numbers are not possible: the walls must leave room")
        assert tab.page.locator("#field-upper-position").input_value() == "5"  # mm


@pytest.mark.validation  # every day: what has no answer, in test_page.py
def test_a_number_without_a_value_says_why(device: Tab) -> None:
    """White noise at a restitution that makes infinitely many impacts."""
    device.ask("lower-restitution=0.1&paths=128")
    page = device.page
    assert page.locator("#tile-rate").inner_text() == "no value"
    assert "restitution 0.1 of lower is not above" in page.locator("#warnings").inner_text()
    assert math.isnan(shown(device)["lower_impact_rate"])
    assert shown(device)["lower_power"] > 0.0
    device.ask("paths=128")
    assert page.locator("#tile-rate").inner_text() != "no value"


@pytest.mark.validation
def test_a_kernel_that_is_compiled_is_said_and_holds_nothing_up(
    context: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes ten seconds and more: meanwhile numbers can be changed, and theory answers."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    with running(str(FOLDER / "kanai_tajimi.toml")) as server, opened(context, server, QUICK, wait=False) as tab:
        page = tab.page
        page.locator("#status").filter(has_text="compiling, once for all systems").wait_for()
        page.locator("#table tr[data-method=linear]").wait_for()
        asked_before = tab.generation()
        page.locator("#field-springpot-order").fill("0.7")
        tab.wait(f"springpotExplorer.generation > {asked_before}", seconds=5.0)
        tab.complete(asked_before)
        assert page.locator("#status").inner_text() == "live"
        run = sp.simulate(changed(sp.read_system(FOLDER / "kanai_tajimi.toml"), {"springpot-order": 0.7}), paths=128)
        assert shown(tab)["x_mean"] == run["x_mean"].value
