"""The page of several masses: opened from a file or the shelf, drawn, moved, and its numbers those of the library."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.answers import solve, table
from springpot.explorer.examples import examples
from springpot.explorer.fitting import fitted
from springpot.explorer.gathering import BINS, growth_times
from springpot.explorer.motion import Player, marks, record
from springpot.explorer.protocol import Problem
from springpot.explorer.question import Opened, question_of
from springpot.explorer.requests import followed
from springpot.explorer.shelf import GALLERY, MOST_FILES, Shelf, chain, pounding
from springpot.explorer.sliders import changed, described_parts, numbers, sliders
from springpot.explorer.views import densities_of, labels, sizes, view_of
from springpot.fitting.reading import data_of
from springpot.problem.catalogue import possible_results
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from tests.explorer.conftest import Server, running
from tests.explorer.talk import tab as connected
from tests.explorer.test_numbers import gathered
from tests.explorer.test_page import CUT, OVERLAPPING, Tab, opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

POINTS = ("a", "b", "c", "d")
QUICK = "paths=128"
UNSTEADY = pytest.mark.filterwarnings("ignore::springpot.StationarityWarning")
SHORT: dict[str, Any] = {"duration": 4.0, "window": (2.0, 4.0)}
LINK = {"between": ("a", "b")}
PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(2.0, at="b"), sp.Spring(9.0, between=("ground", "a")), sp.Spring(4.0, **LINK),
    sp.Dashpot(0.3, between=("ground", "a")), sp.Springpot(0.5, 0.4, **LINK), sp.Constant(0.5, on="b"),
    sp.WhiteNoise(0.2, on="a"),
)  # fmt: skip


# --- without a browser ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", GALLERY)
def test_the_systems_of_the_shelf_have_all_that_the_page_shows(place: str) -> None:
    opened_here = Shelf(Opened()).at(place)
    system = opened_here.system
    assert len(system.points) > 1
    assert {one.name: one.value for one in sliders(system, sizes(system))} == numbers(system)
    found = view_of(system)
    assert len(found["equations"]) == len(system.points)
    assert len(found["sizes"]["of"]) == len(found["followed"]) == len(system.points) + len(system.coordinates.pairs)
    assert all(one["low"] < 0.0 < one["high"] for one in found["sizes"]["of"])
    cases = [question_of(Problem(numbers=one["numbers"], without=one["without"]), opened_here) for one in
             examples(system, opened_here.file)]  # fmt: skip
    assert (cases[0].start, cases[-1].start) == ("stationary", "stationary")
    assert solve(cases[-1].system, "linear")[0] is not None  # without its walls


@pytest.mark.validation  # every day: a grown ensemble, in test_systems.py
@UNSTEADY
def test_numbers_and_densities_of_an_ensemble_are_those_of_the_run() -> None:
    system = chain()
    ours = gathered(system, paths=192, seed=4, **SHORT)
    run = sp.simulate(system, paths=192, seed=4, distributions=True, step=ours.simulation.settings.step, **SHORT)
    values, errors = ours.estimates()
    np.testing.assert_equal(values, {name: run[name].value for name in run})
    np.testing.assert_equal(errors, {name: run[name].error for name in run})
    assert ours.warnings() == run.warnings
    found = ours.distributions()
    assert found.keys() >= {*densities_of(system)}
    for name, distribution in found.items():
        np.testing.assert_array_equal(distribution.counts.sum(axis=0), run.distributions[name].counts.sum(axis=0))
    mean, error = ours.growth()
    assert mean.shape == error.shape == (len([*followed(system)]), BINS)


@UNSTEADY
def test_growth_is_the_mean_over_recorded_paths() -> None:
    """Of each mass, and of what is between two."""
    given: dict[str, Any] = {"paths": 128, "seed": 3, "duration": 20.0}
    ours, run = gathered(PAIR, **given), sp.simulate(PAIR, record=128, **given)
    mean, _ = ours.growth()
    times, x = growth_times(ours.simulation.plan), run.record[:, 1:, :, 0]
    squares = (np.stack([x[..., 0], x[..., 1], x[..., 1] - x[..., 0]]) ** 2).mean(axis=1)
    edges = np.concatenate([[0.0], 0.5 * (times[1:] + times[:-1]), [np.inf]])
    for at in (BINS // 2, BINS - 1):
        begin, end = np.searchsorted(run.time[1:], edges[at : at + 2])
        np.testing.assert_allclose(mean[:, at], squares[:, begin:end].mean(axis=1), rtol=0.05)


@pytest.mark.validation  # every day: of both walls, in test_systems.py
@UNSTEADY
def test_the_shown_path_is_that_of_the_run_and_strikes_where_it_counts() -> None:
    system, given = chain(), {"paths": 64, "seed": 2, "duration": 4.0, "window": (0.0, 4.0)}
    simulation, run = simulation_of(adapt(plan_of(system, **given))), sp.simulate(system, record=64, **given)  # type: ignore[arg-type]
    shown = record(simulation, 0)
    np.testing.assert_array_equal(shown.x, run.record[0, :, :, 0].T)
    found = [marks(system, run.settings.step, *path.transpose(2, 1, 0))[1] for path in run.record]
    for number, wall in enumerate(system.stops):
        rate = sum((walls == number).sum() for walls in found) / (64 * 4.0)
        assert rate == pytest.approx(run[f"{wall}_impact_rate"].value, rel=0.05)
    player = Player(shown, frequency=10.0)
    player.forward(30.0)
    _, x, v, times, speeds, walls, _ = player.due()
    assert np.shape(x) == np.shape(v) == (4, np.shape(x)[1])
    assert len(times) == len(speeds) == len(walls) > 0
    above = np.array([wall.free_side == "above" for wall in system.stops.values()])[np.asarray(walls)]
    assert ((np.asarray(speeds) > 0.0) == above).mean() > 0.9


def test_theory_has_a_gaussian_density_of_each_mass() -> None:
    answer, _ = solve(PAIR, "linear")
    found: dict[str, Any] = table(PAIR, {"linear": answer}, {})
    for point in PAIR.points:
        x, density = (
            np.array(found["places"][f"{point}_x"]),
            np.array(found["methods"]["linear"]["densities"][f"{point}_x"]),
        )
        mean, square = (np.trapezoid(density * x**power, x) for power in (1, 2))
        assert mean == pytest.approx(answer.numbers[f"{point}_x_mean"], rel=1e-3)
        assert square == pytest.approx(answer.numbers[f"{point}_x_mean_square"], rel=1e-3)
    impulses = sp.System(*PAIR.parts, sp.PoissonImpulses(2.0, 0.1, on="b"))
    answer, _ = solve(impulses, "linear")
    assert table(impulses, {"linear": answer}, {})["methods"]["linear"]["densities"] == {}


def test_the_words_of_parts_say_where_they_are() -> None:
    system = chain()
    parts = {part["name"]: part for part in described_parts(system)}
    assert parts["stop"]["note"] == "wall, x ≥ b, b to c"
    assert parts["stop"]["ends"] == (1, 2)
    assert parts["left_noise"]["note"] == "white noise, on a"
    assert parts["mass_2"]["note"] == "b"
    said = {name: (words, unit) for name, words, unit in labels(system, [*possible_results(system)])}
    assert said["stop_impact_rate"] == ("impacts on stop", "1/s")
    assert said["left_wall_power"] == ("taken by left wall", "W")


def test_a_copied_program_runs(capsys: pytest.CaptureFixture[str]) -> None:
    exec(question_of(Problem(paths=2), Opened(PAIR)).python, {})
    assert "linear: <x_a^2> = " in capsys.readouterr().out


def test_numbers_are_fitted_to_the_response_of_a_mass() -> None:
    hertz = np.linspace(0.1, 1.5, 40)
    response = sp.theory.linear(PAIR).frequency_response(2.0 * np.pi * hertz, of="b", on="a")
    lines = (f"{f},{h.real},{h.imag}" for f, h in zip(hertz, response, strict=True))
    text = "\n".join(["# at = b", "# on = a", "frequency_hz,real_m/N,imaginary_m/N", *lines])
    start = changed(PAIR, {"spring_2-stiffness": 5.0})
    found = fitted(start, ["spring_2-stiffness"], data_of(text.encode(), "b.csv")[0])
    assert found["values"][0]["value"] == pytest.approx(4.0, rel=1e-6)


def test_a_shelf_keeps_some_files_and_says_what_is_wrong_with_others() -> None:
    shelf = Shelf(Opened(PAIR, "pair.toml"))
    assert next(iter(shelf.listed())) == ("", "pair.toml")
    places = [
        shelf.put(sp.to_toml(changed(PAIR, {"spring_1-stiffness": 9.0 + n})), "p.toml") for n in range(MOST_FILES + 1)
    ]
    assert [shelf.has(place) for place in (places[0], places[1], places[-1], "", "chain", "x")] == [
        False, True, True, True, True, False,
    ]  # fmt: skip
    assert shelf.at(places[-1]).system == changed(PAIR, {"spring_1-stiffness": 9.0 + MOST_FILES})
    assert shelf.at(places[0]).system == PAIR
    for wrong, sentence in (("[[parts]]\nkind = 'wal'", "parts\\[0\\].kind must be"), ("[[", "is not TOML")):
        with pytest.raises(ValueError, match=sentence):
            shelf.put(wrong, "x.toml")


def test_a_file_that_is_sent_is_shelved(server: Server) -> None:
    text = sp.to_toml(pounding())
    parts = [text[:700], text[700:]]
    with connected(server) as page:
        for number, part in enumerate(parts):
            page.say(kind="system", name="houses.toml", part=number, of=2, text=part)
        assert page.until("shelved")["place"]
        page.say(kind="system", name="bad.toml", part=0, of=1, text="[[")
        assert "bad.toml' is not TOML" in page.until("shelved", place="")["fault"]
        page.say(kind="system", name="bad.toml", part=1, of=2, text="[[")
        assert page.until("refused")["sentence"] == "system: the parts of the file must come in their order."


# --- in the browser ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    made = browser.new_context(viewport={"width": 1440, "height": 900}, accept_downloads=True)
    yield made
    made.close()


@pytest.fixture(scope="module")
def page(context: BrowserContext, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    """The chain of four, from a file."""
    file = tmp_path_factory.mktemp("several") / "four.toml"
    file.write_text(sp.to_toml(chain()), encoding="utf-8")
    with running(str(file)) as server, opened(context, server, QUICK) as made:
        yield made


def shown(page: Tab) -> dict[str, float]:
    """Every number of Monte Carlo on the page, by name."""
    cells = "[...document.querySelectorAll('tr.measured [data-quantity], #parts-table [data-quantity]')]"
    found = page.page.evaluate(f"{cells}.map((cell) => [cell.dataset.quantity, cell.dataset.value])")
    return {name: float(value) if value else math.nan for name, value in found}


def test_the_page_shows_the_numbers_of_simulate_and_a_slider_changes_them(page: Tab) -> None:
    run, found = sp.simulate(chain(), paths=128, seed=1), shown(page)
    for point in POINTS:
        assert found[f"{point}_x_rms"] == math.sqrt(run[f"{point}_x_mean_square"].value)
        assert found[f"{point}_v_mean_square"] == run[f"{point}_v_mean_square"].value
        assert found[f"{point}_x_mean"] == run[f"{point}_x_mean"].value
    for pair in ("a_b", "b_c", "c_d"):
        assert found[f"{pair}_elongation_rms"] == math.sqrt(run[f"{pair}_elongation_mean_square"].value)
    for wall in ("left_wall", "right_wall", "stop"):
        for what in ("impact_rate", "impact_speed_mean", "power"):
            assert found[f"{wall}_{what}"] == run[f"{wall}_{what}"].value
    page.changed(lambda: page.page.locator("#slider-spring_3-stiffness").press("ArrowRight"))
    value = float(page.page.locator("#field-spring_3-stiffness").input_value())
    other = sp.simulate(changed(chain(), {"spring_3-stiffness": value}), paths=128, seed=1)
    assert shown(page)["b_x_mean"] == other["b_x_mean"].value != run["b_x_mean"].value
    page.changed(lambda: page.page.locator("#example").select_option("0"))
    assert shown(page) == found


PIXELS = """() => {
    const canvas = document.querySelector("#scene canvas"), ratio = devicePixelRatio || 1;
    const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    const g = copy.getContext("2d", { willReadFrequently: true });
    g.drawImage(canvas, 0, 0);
    const { data } = g.getImageData(0, Math.round(84 * ratio), canvas.width, 1);
    const color = getComputedStyle(document.documentElement).getPropertyValue("--mass").trim();
    const wanted = [1, 3, 5].map((i) => parseInt(color.slice(i, i + 2), 16)), edges = [];
    let inside = 0;
    for (let x = 0; x < canvas.width; x += 1) {
        const same = wanted.every((value, i) => Math.abs(data[4 * x + i] - value) < 3) && data[4 * x + 3] === 255;
        if (same) inside += 1; else { if (inside > 15) edges.push(x - inside); inside = 0; }
    }
    return edges;
}"""


def test_four_masses_are_drawn_and_move(page: Tab) -> None:
    before = page.page.evaluate(PIXELS)
    assert len(before) == 4
    at = page.time()
    page.wait(f"springpotExplorer.time > {at} + 0.15 || springpotExplorer.time < {at}")
    page.page.wait_for_timeout(600)
    after = page.page.evaluate(PIXELS)
    assert len(after) == 4
    assert after != before


def test_a_density_of_each_mass_and_what_one_mass_has_is_hidden(page: Tab) -> None:
    cards = page.page.locator("#densities [data-chart]")
    assert cards.locator("h3").all_inner_texts() == [*POINTS]
    for hidden in (".of-paper", "#start"):
        assert not any(one.is_visible() for one in page.page.locator(hidden).all())
    assert len(page.page.locator("header #equation .sum").all()) == 4  # one for each mass, at the head of the page
    assert page.page.locator("#equation small").inner_text().startswith("4 masses: a, b, c and d")


def test_traces_and_large_numbers_follow_what_is_chosen(page: Tab) -> None:
    choice, main = page.page.locator("#seen"), page.page.locator(".tile h3")
    assert choice.locator("option").all_inner_texts() == [*POINTS, "a to b", "b to c", "c to d"]
    assert main.first.inner_text() == "x rms of a"
    choice.select_option(label="b to c")
    main.filter(has_text="elongation rms of b to c").wait_for()
    main.filter(has_text="Impact rate, stop").wait_for()
    choice.select_option(label="a")
    main.filter(has_text="Impact rate, left wall").wait_for()


def test_theory_stands_beside_it_without_walls(page: Tab) -> None:
    page.ask(f"without=left_wall,right_wall,stop&{QUICK}")
    free = question_of(Problem(without=["left_wall", "right_wall", "stop"]), Opened(chain())).system
    exact = sp.theory.linear(free)
    for point in POINTS:
        assert page.theory("linear", f"{point}_x_rms") == pytest.approx(
            math.sqrt(exact.numbers[f"{point}_x_mean_square"]), rel=1e-6
        )
    assert page.page.locator("#density-legend").inner_text().split() == ["Monte", "Carlo", "linear"]
    page.ask(QUICK)


def test_nothing_is_cut_or_overlaps(page: Tab) -> None:
    for width in (1440, 390):
        page.page.set_viewport_size({"width": width, "height": 850})
        page.page.evaluate("controls.open = true")
        page.page.wait_for_timeout(400)
        assert page.page.evaluate("document.documentElement.scrollWidth") <= width
        assert [page.page.evaluate(CUT), page.page.evaluate(OVERLAPPING)] == [[], []]
        assert len(page.page.evaluate(PIXELS)) == 4
    page.page.set_viewport_size({"width": 1440, "height": 900})


@pytest.mark.validation  # every day: the shelf, and a file that is sent to it
def test_another_system_is_opened_from_the_page(context: BrowserContext, server: Server, tmp_path: Path) -> None:
    """From its examples, and from a file; a place that is not there is said."""
    file = tmp_path / "pair.toml"
    file.write_text(sp.to_toml(PAIR), encoding="utf-8")

    with opened(context, server, QUICK) as tab:
        tab.page.locator("#example").select_option("system pounding")
        tab.page.wait_for_url("**/?system=pounding*")
        tab.page.get_by_text("2 masses: tower and annex").wait_for()
        tab.page.set_input_files("#open-file", {"name": "no.toml", "mimeType": "text/plain", "buffer": b"[["})
        tab.page.locator("#banner").filter(has_text="is not TOML").wait_for()
        tab.page.set_input_files("#open-file", str(file))
        tab.page.get_by_text("2 masses: a and b").wait_for()
        assert tab.page.title() == "pair.toml · springpot explorer"
        tab.page.goto(f"{server.address}?system=nowhere#{QUICK}")
        tab.page.locator("#banner").filter(has_text="open its file again").wait_for()
        tab.complete()


@UNSTEADY
def test_a_beam_is_drawn_with_its_points() -> None:
    """Each share is a number of its own, and the tip of a drawn path is the sum of the modes."""
    beam = sp.beam(0.3, 0.34, 0.047, {"tip": 0.3}, modes=2, damping_ratios=0.01)
    system = sp.System(*beam.parts, sp.WhiteNoise(0.05, on="ground"))
    said = {one.name: one.said for one in sliders(system, {"frequency": 50.0, "length": 0.005})}
    assert said["point-shares-2"] == "share of a mass"
    assert said["mass_2-participation"] == "participation"
    path = record(simulation_of(plan_of(system, start="rest", **SHORT)), 0)
    assert path.x.shape[0] == 3
    np.testing.assert_allclose(path.x[2], path.x[0] + path.x[1], atol=1e-12)
