"""What is saved from the page: numbers, pictures and tables of one question, never of another."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import pytest

from tests.explorer.conftest import Server
from tests.explorer.talk import link
from tests.explorer.test_page import Tab, opened
from tests.sizes import validation

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator


@pytest.fixture(scope="module")
def saving(browser: Browser, server: Server) -> Iterator[Tab]:
    """In a context of its own: one that grants the clipboard denies all else, a second download too."""
    with browser.new_context(accept_downloads=True) as context, opened(context, server, link(order=0.6)) as tab:
        tab.wait("document.querySelector('#curve-legend').textContent.includes('envelope')")
        yield tab


@pytest.mark.parametrize("every", [4, validation(1)])
def test_downloads(saving: Tab, every: int) -> None:
    tab = saving

    def saved(button: Locator) -> bytes:
        tab.page.wait_for_timeout(150)  # Chromium drops what is beyond ten downloads a second
        with tab.page.expect_download() as download:
            button.click()
        return bytes(download.value.path().read_bytes())

    rows = list(csv.reader(saved(tab.page.locator("#save-csv")).decode().splitlines()[1:]))
    assert rows[0] == ["method", "quantity", "value", "standard_error"]
    found = {(method, name): value for method, name, value, _ in rows[1:]}
    assert float(found["monte_carlo", "amplitude_mean_square"]) == tab.number()
    assert float(found["envelope", "impact_rate"]) == tab.theory("envelope", "impact_rate")
    for card in tab.page.locator("[data-chart]").all()[::every]:
        assert saved(card.get_by_role("button", name="PNG")).startswith(b"\x89PNG")
        if card.get_attribute("data-chart") != "phase":
            table = saved(card.get_by_role("button", name="CSV")).decode().splitlines()
            assert table[0].startswith("# spring-stiffness = 1, springpot-order = 0.6")
            assert len(table) > 30
            assert sum(map(str.isdigit, table[5])) > 5


def test_theory_of_another_question_is_neither_shown_as_this_one_nor_saved(saving: Tab) -> None:
    tab = saving
    old = "[...document.querySelectorAll('.card.old')].map((e) => e.dataset.chart).sort().join()"
    # questions are taken and nothing is answered from here on: the last test of this page
    tab.page.evaluate(
        """(() => {
            const { get } = Object.getOwnPropertyDescriptor(MessageEvent.prototype, "data");
            const taken = (data) => typeof data === "string" && JSON.parse(data).kind === "accepted";
            const own = { get() { const data = get.call(this); return taken(data) ? data : '{"kind": "none"}'; } };
            Object.defineProperty(MessageEvent.prototype, "data", own);
        })()"""
    )

    def now_old(act: Callable[[], object]) -> str:
        before = tab.generation()
        act()
        tab.wait(f"springpotExplorer.generation > {before}")
        return str(tab.page.evaluate(old))

    assert now_old(lambda: tab.page.locator("#seed").fill("5")) == ""
    assert now_old(lambda: tab.page.locator("#start").select_option("rest")) == "growth"
    theory = "amplitude,growth,impact_speed,v,x"
    assert now_old(lambda: tab.page.locator("#field-springpot-order").fill("0.7")) == theory
    assert now_old(lambda: tab.page.locator("#field-barrier-restitution").fill("0.9")) == "amplitude,curve" + theory[9:]
    for button in tab.page.locator(".card.old .tool").all():
        assert button.is_disabled()
    with tab.page.expect_download() as download:
        tab.page.locator("#save-csv").click()
    assert "envelope" not in download.value.path().read_text(encoding="utf-8")
