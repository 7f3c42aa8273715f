"""What an engineer sees of the page: units as stated, the numbers asked first, labels, jumps, and the page on paper."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import springpot as sp
from tests.explorer.conftest import running
from tests.explorer.test_page import CUT, OVERLAPPING, Tab, opened
from tests.sizes import validation

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

QUICK = "paths=640"
SIZES = ((1400, 900), (390, 844))
BETWEEN = ("base", "frame"), ("frame", "board")
SYSTEMS = {
    "device": sp.System(  # of the README
        sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(0.3, 150.0), sp.Barrier(-0.006, restitution=0.7),
        sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    ),
    "chain": sp.System(
        sp.Mass(1.0, at="base"), sp.Mass(0.6, at="frame"), sp.Mass(0.3, at="board"),
        sp.Spring(8000.0, between=("ground", "base")), sp.Dashpot(6.0, between=("ground", "base")),
        sp.Spring(5000.0, between=BETWEEN[0]), sp.Springpot(0.3, 60.0, between=BETWEEN[0]),
        sp.Spring(3000.0, between=BETWEEN[1]), sp.Dashpot(2.0, between=BETWEEN[1]),
        sp.Barrier(-0.004, 1.0, between=BETWEEN[0]), sp.Barrier(-0.002, 1.0, between=BETWEEN[1]),
        sp.Barrier(0.003, 1.0, between=BETWEEN[1]), sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
    ),
    "spectrum": sp.System(
        sp.Mass(1.2), sp.Spring(160e3), sp.Springpot(0.2, 5000.0), sp.Barrier(-0.0015, 0.6), sp.Barrier(0.0015, 0.6),
        table=sp.SpectralExcitation.from_psd((20, 80, 350, 2000), (0.01, 0.04, 0.04, 0.007), "g2/Hz"),
    ),
}  # fmt: skip
FEW = ["device", validation("chain"), validation("spectrum")]

# where the words of each canvas stand since it was cleared, in its pixels
LABELS = """(() => {
    const kept = new Map(), own = CanvasRenderingContext2D.prototype, { fillText, clearRect } = own;
    own.clearRect = function (...given) { kept.set(this.canvas, []); return clearRect.apply(this, given); };
    own.fillText = function (text, x, y) {
        const m = this.measureText(text), t = this.getTransform();
        const corners = [[x - m.actualBoundingBoxLeft, y - m.actualBoundingBoxAscent],
            [x + m.actualBoundingBoxRight, y + m.actualBoundingBoxDescent]];
        const ends = corners.map(([a, b]) => t.transformPoint({ x: a, y: b }));
        const xs = ends.map((p) => p.x), ys = ends.map((p) => p.y), { min, max } = Math;
        if (text.trim()) kept.get(this.canvas)?.push([text, min(...xs), min(...ys), max(...xs), max(...ys)]);
        return fillText.call(this, text, x, y);
    };
    window.labelsOf = () => [...kept].filter(([canvas]) => canvas.isConnected && canvas.checkVisibility())
        .map(([canvas, words]) => [canvas.width, canvas.height, words]);
})()"""
# cards that are seen, with neither a drawing nor more words than their heading
EMPTY = """[...document.querySelectorAll(".card, .tile")].filter((card) => card.checkVisibility() &&
        ![...card.querySelectorAll("canvas")].some((canvas) => canvas.checkVisibility()) &&
        card.innerText.replace(card.querySelector(".card-head")?.innerText ?? "", "").trim().length < 3)
    .map((card) => card.id || card.innerText)"""
WATCHED = """() => {
    window.said = [];
    const seen = { subtree: true, childList: true, characterData: true };
    const note = document.getElementById("tile-theory-note");
    const look = () => said.push([note.textContent, table.innerText.includes("computing")]);
    new MutationObserver(look).observe(document.getElementById("results"), seen);
}"""


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    made = browser.new_context(viewport={"width": 1400, "height": 900}, color_scheme="dark")
    made.add_init_script(LABELS)
    yield made
    made.close()


@pytest.fixture(scope="module")
def tabs(context: BrowserContext, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Tab]]:
    """A page of a system, opened when it is first asked for, with the cards that are loaded after the first answer."""
    place = tmp_path_factory.mktemp("looks")
    with ExitStack() as stack:

        @cache
        def tab_of(name: str) -> Tab:
            (path := place / f"{name}.toml").write_text(sp.to_toml(SYSTEMS[name]), encoding="utf-8")
            server = stack.enter_context(running(str(path)))
            found = stack.enter_context(opened(context, server, QUICK))
            found.wait("document.querySelector('#scatter-form') !== null", seconds=20.0)
            return found

        yield tab_of


def words(tab: Tab, place: str) -> str:
    return str(tab.page.locator(place).inner_text())


def test_numbers_are_shown_in_the_units_in_which_they_were_stated(tabs: Callable[[str], Tab]) -> None:
    """0.01 g²/Hz and not 0.480852 m²/s³, -6 mm and not -0.006 m: at the sliders, the head, cards, axes and tables."""
    device = tabs("device")
    page = device.page
    assert page.locator("#field-white_noise-intensity").input_value() == "0.01"
    assert page.locator("#unit-white_noise-intensity").input_value() == "g"
    assert page.locator("#field-barrier-position").input_value() == "-6"
    assert "x ≥ −6 mm" in words(device, "#equation")
    assert "one-sided 0.01 g2/Hz" in words(device, "#equation")
    for tile, unit in (("rms", "mm"), ("rate", "1/s"), ("speed", "mm/s"), ("peak", "g")):
        assert words(device, f"#tile-{tile}").split()[1] == unit
    assert "mm/s" in words(device, "#parts-table [data-quantity=barrier_impact_speed_mean]")
    assert page.locator("#asked-form [name=levels_of] option").first.inner_text() == "x (mm)"
    drawn = {text for _, _, labels in page.evaluate("labelsOf()") for text, *_ in labels}
    assert {"x (mm)", "v (mm/s)"} <= drawn
    assert not any("(m)" in text or "(m/s)" in text for text in drawn)


@pytest.mark.validation  # every day: a density of white noise, above
def test_a_table_is_shown_in_the_units_in_which_it_was_stated(tabs: Callable[[str], Tab]) -> None:
    table = tabs("spectrum")
    assert table.page.locator("#table-text").input_value().startswith("frequency_Hz,psd_g2/Hz\n20,0.01\n80,0.04\n")
    assert words(table, "#tile-peak").split()[1] == "g"
    labels = {text for _, _, own in table.page.evaluate("labelsOf()") for text, *_ in own}
    assert "G (g²/Hz)" in labels
    table.page.locator("#density-unit").select_option("psd")
    table.wait("labelsOf().some(([, , own]) => own.some(([text]) => text === 'G ((m/s²)²/Hz)'))", seconds=10.0)
    table.wait("document.querySelector('#tile-peak').innerText.includes('m/s²')", seconds=10.0)
    table.page.locator("#density-unit").select_option("g")


@pytest.mark.filterwarnings("ignore::springpot.AccuracyWarning", "ignore::springpot.ProblemWarning")
def test_four_numbers_stand_first(tabs: Callable[[str], Tab]) -> None:
    """They are those of the library."""
    run = sp.simulate(SYSTEMS["device"], paths=640)
    more = sp.simulate(
        SYSTEMS["device"], paths=640, step=run.settings.step, forces=["acceleration"], distributions=True
    )
    speed = more.distributions["impact_speed"].quantile(0.99)[0]
    peaks = np.maximum(-more.extremes["acceleration_minimum"], more.extremes["acceleration_maximum"])
    known = {
        "rms": 1e3 * run["x_mean_square"].value ** 0.5, "rate": run["impact_rate"].value, "speed": 1e3 * float(speed),
        "peak": peaks.mean() / 9.80665,
    }  # fmt: skip
    tiles = tabs("device").page.locator("#results .tile h3").all_inner_texts()
    assert tiles[:4] == ["x rms", "Impact rate", "99 % impact speed", "Peak acceleration"]
    for name, value in known.items():
        shown = float(words(tabs("device"), f"#tile-{name}").split()[0])
        assert shown == pytest.approx(value, rel=2e-3), name


@pytest.mark.validation  # every day: the page of several masses, in test_several.py
@pytest.mark.filterwarnings("ignore::springpot.AccuracyWarning", "ignore::springpot.ProblemWarning")
def test_every_stop_has_its_rate(tabs: Callable[[str], Tab]) -> None:
    chain = tabs("chain")
    run = sp.simulate(SYSTEMS["chain"], paths=640)
    for number in (1, 2, 3):
        name = f"barrier_{number}_impact_rate"
        row = chain.page.locator(f"#tile-lines [data-quantity={name}]")
        assert row.locator("dt").inner_text() == f"impacts on barrier {number}"
        assert float(row.locator("dd").inner_text().split()[0]) == pytest.approx(run[name].value, rel=0.01)
    sums = chain.page.locator("header #equation .sum").all_inner_texts()
    assert [re.search("ẍ(base|frame|board)", text)[1] for text in sums] == ["base", "frame", "board"]  # type: ignore[index]


@pytest.mark.parametrize(("width", "height"), SIZES)
@pytest.mark.parametrize("name", FEW)
def test_no_words_touch_and_nothing_is_cut(name: str, width: int, height: int, tabs: Callable[[str], Tab]) -> None:
    """On canvases too: between two numbers of an axis there is room, and the last one is whole."""
    page = tabs(name).page
    page.bring_to_front()
    page.set_viewport_size({"width": width, "height": height})
    page.wait_for_timeout(700)
    seen = page.evaluate("labelsOf()")
    assert sum(len(labels) for _, _, labels in seen) > 40
    for wide, tall, labels in seen:
        for i, (text, left, top, right, bottom) in enumerate(labels):
            assert min(left, top) > -1.5, text
            assert right < wide + 1.5, text
            assert bottom < tall + 1.5, text
            for other, low, above, high, below in labels[:i]:
                touching = left < high + 1 and low < right + 1 and top < below and above < bottom
                assert not touching, (text, other)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert [page.evaluate(CUT), page.evaluate(OVERLAPPING)] == [[], []]
    page.set_viewport_size({"width": 1400, "height": 900})


def test_computing_is_said_until_theory_has_answered(tabs: Callable[[str], Tab]) -> None:
    """From the question on, at the large number and in the table; and no longer after it."""
    tab = tabs("device")
    tab.page.evaluate(WATCHED)
    tab.changed(lambda: tab.page.locator("#field-springpot-order").fill("0.35"))
    said = tab.page.evaluate("said")
    assert ["computing…", True] in said
    assert said[-1][0].startswith("deviation")
    assert said[-1][1] is False
    tab.changed(lambda: tab.page.locator("#field-springpot-order").fill("0.3"))


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_each_part_of_the_page_is_one_click_away(width: int, height: int, tabs: Callable[[str], Tab]) -> None:
    tab = tabs("device")
    tab.page.bring_to_front()
    tab.page.set_viewport_size({"width": width, "height": height})
    tab.page.wait_for_timeout(300)
    link, jumps = tab.page.evaluate("location.hash"), tab.page.locator(".jumps button")
    assert jumps.count() == 12
    for jump in jumps.all():
        if not jump.is_visible():
            continue
        jump.click()
        tab.page.wait_for_timeout(200)
        target = tab.page.locator(f"#{jump.get_attribute('data-to')}")
        top = target.evaluate("(part) => part.getBoundingClientRect().top")
        end = tab.page.evaluate("scrollY + innerHeight >= document.documentElement.scrollHeight - 2")
        assert -1.0 <= top <= 120.0 or (end and top < height), jump.inner_text()
    assert tab.page.evaluate("location.hash") == link
    tab.page.evaluate("scrollTo(0, 0)")
    tab.page.set_viewport_size({"width": 1400, "height": 900})


@pytest.mark.parametrize("name", FEW)
def test_no_card_is_empty_on_paper(name: str, tabs: Callable[[str], Tab], tmp_path: Path) -> None:
    """Cards that were not asked are left out, and so is what is for hands; a dark page is printed light."""
    page = tabs(name).page
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    page.wait_for_timeout(300)
    assert page.evaluate(EMPTY) == []
    for hidden in ("#asked", "#rare", "#scatter", "#fit", "#play", ".jumps", "#save-csv", "#slider-mass-value"):
        assert not any(one.is_visible() for one in page.locator(hidden).all()), hidden
    for seen in ("#equation", "#tile-rms", "#table", "#parts-table", "#traces canvas"):
        assert page.locator(seen).first.is_visible(), seen
    assert page.locator("#excitation").is_visible() == (name == "spectrum")
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    page.emulate_media(media="screen")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("document.documentElement.dataset.theme ?? ''") == ""
    paper = page.pdf(path=tmp_path / "page.pdf")
    assert 2 <= len(re.findall(rb"/Type\s*/Page\b", paper)) <= 8


@pytest.mark.validation  # every day: the sentence, in test_requests.py; a saved file is opened
def test_what_was_assumed_of_a_table_is_said(tabs: Callable[[str], Tab]) -> None:
    """On the page that opens with it; a binary file that is not read is refused beside the button."""
    tab = tabs("spectrum")
    page = tab.page
    page.locator("#table-ask summary").click()
    page.set_input_files(
        "#table-file", {"name": "bad.mat", "mimeType": "application/octet-stream", "buffer": b"MATLAB 5.0 MAT-file\0"}
    )
    tab.wait("document.querySelector('#table-note').textContent.includes('bad.mat')", seconds=10.0)
    content = "# géré\nfrequency_Hz;psd_g2/Hz\n20;0,02\n2000;0,02\n".encode("latin-1")
    with page.expect_navigation():
        page.set_input_files("#table-file", {"name": "levels.csv", "mimeType": "text/csv", "buffer": content})
    tab.complete()
    tab.wait("document.querySelector('#scatter-form') !== null", seconds=20.0)
    assert page.locator("#table-text").input_value() == "frequency_Hz,psd_g2/Hz\n20,0.02\n2000,0.02"
    said = "levels.csv was read; it is not in UTF-8, and is read as Latin-1; its commas are decimal marks."
    assert words(tab, "#table-said") == said
