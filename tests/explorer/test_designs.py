"""The page for a device: units, a second design beside the first, starts, and what fits on a screen."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

import springpot as sp
from springpot.explorer.protocol import Problem
from springpot.explorer.question import Opened, question_of
from springpot.problem.spectral_density import intensity_from_psd, psd_from_intensity
from tests.explorer.conftest import Server
from tests.explorer.talk import link, numbers
from tests.explorer.talk import tab as talking
from tests.explorer.test_page import CUT, OVERLAPPING, Tab, opened

DEVICE = link(order=0.4, coefficient=300, natural_frequency=120, intensity=0.02, position=-0.0001, restitution=0.7)


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    made = browser.new_context(viewport={"width": 1440, "height": 900})
    yield made
    made.close()


@pytest.fixture(scope="module")
def device(context: BrowserContext, server: Server) -> Iterator[Tab]:
    """One page for several tests, in metres at first."""
    with opened(context, server, DEVICE) as made:
        yield made


def in_units_of_a_device(page: Page) -> None:
    for name, unit in (("barrier-position", "mm"), ("spring-stiffness", "Hz"), ("white_noise-intensity", "g")):
        page.locator(f"#unit-{name}").select_option(unit)


@pytest.mark.validation  # every day: millimetres, hertz and densities, in this file
def test_numbers_in_metres_stay_whole(device: Tab) -> None:
    """A power of ten common to a column, and one for a number and its error."""
    page = device.page
    assert [page.evaluate(CUT), page.locator(".scroll.cut").count()] == [[], 0]
    head, value = page.locator("#table thead").inner_text(), 1e6 * device.number("x_rms")
    assert "10⁻⁶\u00a0m" in head
    shown = page.locator("#table tr.measured [data-quantity=x_rms]").inner_text().split()
    assert float(shown[0]) == pytest.approx(value, rel=1e-2)
    line = page.locator("#tile-lines [data-quantity=amplitude_mean_square] dd").inner_text()
    assert line.count("·10⁻⁸") == 1
    tile = page.locator("#tile-rms").inner_text()
    assert "(" not in tile
    assert tile.count("·10⁻⁴") == 2


def test_pin_and_unpin(device: Tab) -> None:
    page = device.page
    assert page.locator("#pinned").is_hidden()
    page.locator("#pin").click()
    page.locator("#pinned-note").filter(has_text="Both designs are the same").wait_for()
    for row in (1, 2):
        cell = page.locator(f"#pinned-table tbody tr:nth-child({row}) [data-quantity=x_rms]")
        assert float(cell.get_attribute("data-value") or "nan") == device.number("x_rms")
    page.locator("#unpin").click()
    page.locator("#pinned").wait_for(state="hidden")


def test_millimetres_hertz_and_spectral_densities(device: Tab) -> None:
    """Units change what is shown and typed, nothing that is computed: conversions are `spectral_density`'s."""
    page, measured, asked = device.page, device.number("x_rms"), device.generation()
    in_units_of_a_device(page)
    names = "barrier-position", "spring-stiffness", "white_noise-intensity"
    shown = {n: float(page.locator(f"#field-{n}").input_value()) for n in names}
    assert shown["barrier-position"] == -0.1
    assert shown["spring-stiffness"] == pytest.approx(120.0 / 6.283185307, rel=1e-5)
    assert shown["white_noise-intensity"] == pytest.approx(psd_from_intensity(0.02, "g2/Hz"), rel=1e-5)
    page.wait_for_timeout(300)
    assert (device.number("x_rms"), device.generation()) == (measured, asked)
    cell = page.locator("#table tr.measured [data-quantity=x_rms]").inner_text()
    assert float(cell.split()[0]) == pytest.approx(1e3 * measured, rel=1e-2)
    assert page.locator("#tile-rms").inner_text().split()[1] == "mm"
    assert "x rms\nmm" in page.locator("#table thead").inner_text().replace("\t", "")
    assert [page.evaluate(CUT), page.evaluate(OVERLAPPING), page.locator(".scroll.cut").count()] == [[], [], 0]


@pytest.mark.validation
def test_no_gaps_and_no_star_beside_a_transient_run(device: Tab) -> None:
    device.ask(link(more="&start=rest"))
    page, gaps = device.page, "#table [data-method] .gap"
    assert page.locator("#transient").is_visible()
    assert set(page.locator(gaps).all_inner_texts()) == {""}
    assert page.locator("#table .best").count() == 0
    assert "start at rest" in page.locator("#growth-note").inner_text()
    device.changed(lambda: page.locator("#use-stationary").click())
    assert page.locator("#transient").is_hidden()
    assert any("%" in gap for gap in page.locator(gaps).all_inner_texts())
    assert page.locator("#table .best").count() == 1
    assert "stationary mean displacement" in page.locator("#growth-note").inner_text()


@pytest.mark.validation
def test_what_is_typed_in_these_units_is_asked_in_metres_and_seconds(context: BrowserContext, server: Server) -> None:
    with opened(context, server, DEVICE) as tab:
        page = tab.page
        in_units_of_a_device(page)
        tab.changed(lambda: page.locator("#field-barrier-position").fill("-0.2"))
        tab.changed(lambda: page.locator("#field-white_noise-intensity").fill("1e-4"))
        page.wait_for_timeout(400)
        shown = page.evaluate("location.hash").removeprefix("#")
        words = dict(word.split("=") for word in shown.split("&"))
        assert words["barrier-position"] == "-0.0002"
        assert float(words["white_noise-intensity"]) == pytest.approx(intensity_from_psd(1e-4, "g2/Hz"), rel=1e-12)
        assert (words["length"], words["stiffness"], words["excitation"]) == ("mm", "Hz", "g")
        page.locator("#unit-white_noise-intensity").select_option("psd")
        q = float(words["white_noise-intensity"])
        assert float(page.locator("#field-white_noise-intensity").input_value()) == pytest.approx(2.0 * q, rel=1e-5)
    wall, noise = sp.Barrier(-0.0002, 0.7), sp.WhiteNoise(q)
    run = sp.simulate(sp.Oscillator(120.0, sp.Springpot(0.4, 300.0), wall, noise), paths=640, seed=1)
    with opened(context, server, shown) as again:
        assert again.page.locator("#field-barrier-position").input_value() == "-0.2"
        assert again.number("impact_rate") == run["impact_rate"].value
        assert again.number("x_rms") == pytest.approx(run["x_mean_square"].value ** 0.5, rel=1e-14)


@pytest.mark.validation
def test_a_second_design_pinned_beside_the_first(context: BrowserContext, server: Server) -> None:
    """Its numbers and curves stay while the sliders move, in either kind of units, until it is unpinned."""
    given = link(coefficient=0.8, natural_frequency=2, intensity=3, position=-0.3, restitution=0.9)
    with opened(context, server, given) as tab:
        page = tab.page
        first, length = {name: tab.number(name) for name in ("x_rms", "impact_rate")}, (3.0 / 8.0) ** 0.5
        assert page.locator("#pinned").is_hidden()
        page.locator("#pin").click()
        page.locator("#pinned-note").filter(has_text="Both designs are the same").wait_for()
        tab.changed(lambda: page.locator("#field-barrier-restitution").fill("0.6"))

        def pinned(name: str, row: int = 1) -> float:
            cell = page.locator(f"#pinned-table tbody tr:nth-child({row + 1}) [data-quantity={name}]")
            return float(cell.get_attribute("data-value") or "nan")

        for name, value in first.items():
            assert (pinned(name), pinned(name, 0)) == (value, tab.number(name))
        change = page.locator("#pinned-table tbody tr:nth-child(3) [data-quantity=x_rms]").inner_text()
        wanted = 100.0 * (tab.number("x_rms") / first["x_rms"] - 1.0)
        assert float(change.split()[0].replace("−", "-")) == pytest.approx(wanted, abs=0.06)
        assert "pinned" in page.locator("#density-legend").inner_text()
        assert (
            "The pinned design has r of barrier = 0.9; all else is the same."
            in page.locator("#pinned-note").inner_text()
        )
        page.get_by_text("dimensionless", exact=True).click()
        page.wait_for_timeout(300)
        for name, scale in (("x_rms", length), ("impact_rate", 2.0)):
            cell = page.locator(f"#pinned-table tbody tr:nth-child(2) [data-quantity={name}]")
            assert float(cell.inner_text().split()[0]) == pytest.approx(first[name] / scale, rel=0.02)
            assert pinned(name) == first[name]
        assert page.locator("#tile-rate").inner_text().split()[1] == "Ω"
        assert "per second" not in page.locator("body").inner_text()
        assert "Ωt" in page.locator("#speed-shown").inner_text()
        page.get_by_text("SI units", exact=True).click()
        assert "× real time" in page.locator("#speed-shown").inner_text()
        tab.changed(lambda: page.locator("#pin-return").click())
        assert tab.number("x_rms") == first["x_rms"]
        page.locator("#unpin").click()
        page.locator("#pinned").wait_for(state="hidden")


def test_the_curve_over_the_order_comes_in_parts(server: Server) -> None:
    """Averaging first, before Monte Carlo is complete; then more of the envelope from one to the next.

    Without a wall, where an envelope is quick.
    """
    with talking(server) as asking:
        given = numbers(order=0.31, coefficient=0.77)
        asking.say(kind="problem", generation=3, numbers=given, without=["barrier"], paths=100_000)
        kinds, curves = [], []
        while not curves or curves[-1]["missing"]:
            kind, content = asking.hear()
            if kind == "estimates" and content["complete"]:
                kinds.append(kind)
            if kind == "curve":
                kinds.append(kind)
                curves.append(content)
    assert kinds[0] == "curve"
    assert all(len(values) == len(curves[0]["orders"]) for values in curves[0]["methods"].values())
    assert None not in curves[0]["methods"]["averaging"]
    sizes = [len(curve["missing"]) for curve in curves]
    assert sizes[0] > sizes[len(sizes) // 2] > sizes[-1] == 0
    assert None not in curves[-1]["methods"]["envelope"]


def test_a_stiff_springpot_of_a_fast_device_is_taken() -> None:
    """100 Hz needs a thousand times what 1 rad/s does: the system itself says what is too much."""
    given = numbers(natural_frequency=628.0, coefficient=15000.0)
    (paper,) = question_of(Problem(numbers=given), Opened()).papers
    assert paper.springpot.coefficient == 15000.0
    with pytest.raises(ValueError, match=r"^springpot.coefficient must be"):
        question_of(Problem(numbers=numbers(coefficient=1e300)), Opened())


@pytest.mark.validation
def test_slider_ends_follow_a_device(context: BrowserContext, server: Server) -> None:
    """A slider whose value lies far beyond its usual ends still moves it by little."""
    with opened(context, server, DEVICE) as tab:
        slider = tab.page.locator("#slider-spring-stiffness")
        slider.focus()
        tab.changed(lambda: slider.press("ArrowRight"))
        moved = float(tab.page.locator("#field-spring-stiffness").input_value())
        assert 0.95 < moved / 120.0 < 1.1
