"""How the page is laid out at each width, and its colors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.explorer.conftest import Server
from tests.explorer.talk import link
from tests.explorer.test_page import CUT, OVERLAPPING, Tab, opened
from tests.sizes import validation

if TYPE_CHECKING:
    from playwright.sync_api import Browser


LONG = link(order=0.35, coefficient=0.123, natural_frequency=2.34, intensity=12.3, position=-1.23, restitution=0.87)


@pytest.fixture(scope="module")
def long_numbers(browser: Browser, server: Server) -> Iterator[Tab]:
    """A page with long numbers, opened as on a phone; wider ones follow."""
    with (
        browser.new_context(viewport={"width": 390, "height": 850}) as context,
        opened(context, server, LONG) as tab,
    ):
        yield tab


@pytest.mark.parametrize("width", [390, validation(768), validation(1024), 1366, validation(1440)])
def test_nothing_is_cut_or_overlaps(long_numbers: Tab, width: int) -> None:
    """At each width: no scrolling sideways, no text wider than its box, no card over another."""
    page = long_numbers.page
    page.set_viewport_size({"width": width, "height": 850})
    page.evaluate("controls.open = true")
    page.wait_for_timeout(400)  # for what is drawn anew at another width
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(CUT) == []
    assert page.evaluate(OVERLAPPING) == []
    cut = "(() => { const e = table.parentElement; return [e.scrollWidth > e.clientWidth, e.matches('.cut')]; })()"
    wider, faded = page.evaluate(cut)
    assert wider == faded
    assert not (wider and width >= 1366)


@pytest.mark.parametrize(("width", "height"), [validation(1440, 900), (1280, 720)])
def test_buttons_are_on_the_first_screen(long_numbers: Tab, width: int, height: int) -> None:
    page = long_numbers.page
    page.set_viewport_size({"width": width, "height": height})
    page.evaluate("scrollTo(0, 0)")
    for button in page.locator(".share .button, .transport .button").all():
        box = button.bounding_box()
        assert box is not None
        assert box["y"] >= 0.0
        assert box["y"] + box["height"] <= height


@pytest.mark.validation  # every day: a dark page on paper, in test_looks.py
def test_dark_and_light(long_numbers: Tab) -> None:
    """As the system has it, then as it was chosen: also when the page is opened again, before its numbers come."""
    page, background = long_numbers.page, "getComputedStyle(document.body).backgroundColor"
    page.emulate_media(color_scheme="dark")
    dark = page.evaluate(background)
    page.locator("#theme").click()
    light = page.evaluate(background)
    assert sum(map(int, dark[4:-1].split(","))) < 120 < 600 < sum(map(int, light[4:-1].split(",")))
    page.reload()
    long_numbers.wait("window.springpotExplorer?.generation > 0")
    assert page.evaluate(background) == light
