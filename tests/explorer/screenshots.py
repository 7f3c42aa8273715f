"""Pictures of the page for the documentation, at the widths of a desk, a tablet and a phone, dark and light.

`make screenshots` runs it: ``python -m tests.explorer.screenshots FOLDER``.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from tests.explorer.conftest import Server, launched_browser, running
from tests.explorer.talk import link
from tests.explorer.test_page import Tab

if TYPE_CHECKING:
    from playwright.sync_api import Browser

WIDTHS = (1440, 768, 390)
SHOWN = link(10_000, coefficient=0.3, position=-0.3, restitution=0.8)
TOLERANCES = "tolerance.springpot_coefficient=0.1&tolerance.spring_stiffness=0.05&tolerance.barrier_position=0.05"
SECONDS = 18.0  # of motion, until there is something to see
SYSTEM = Path(__file__).with_name("systems") / "two_walls.toml"
SHOWN_OF_SYSTEM, SECONDS_OF_SYSTEM, SECONDS_OF_SEVERAL = "paths=5000", 0.75, 3.0


def take(
    browser: Browser,
    server: Server,
    width: int,
    scheme: str,
    path: Path,
    *,
    whole: bool = True,
    system: str = "",
    shown: str = SHOWN,
    seconds: float = SECONDS,
) -> None:
    """One picture: the whole page, or what is seen of it at first."""
    ratio = 2 if width == 390 else 1
    context = browser.new_context(
        viewport={"width": width, "height": 900},
        color_scheme="dark" if scheme == "dark" else "light",
        device_scale_factor=ratio,
    )
    tab = Tab(context.new_page())
    tab.page.goto(f"{server.address}{f'?system={system}' if system else ''}#{shown}")
    tab.complete()
    tab.wait(f"springpotExplorer.time > {seconds}")
    tab.page.locator("#play").click()
    if whole:
        tab.page.locator("#asked").scroll_into_view_if_needed()  # cards that are loaded when they come near
        tab.page.locator("#asked-form").wait_for()
        tab.page.evaluate("scrollTo(0, 0)")
        if width <= 900:  # what stays at the lower end of a phone is at the end of the whole page
            tall = tab.page.evaluate("document.documentElement.scrollHeight")
            tab.page.set_viewport_size({"width": width, "height": tall})
    tab.page.wait_for_timeout(300)
    tab.page.screenshot(path=path, full_page=whole)
    context.close()
    shrink(path)


def take_devices(browser: Browser, server: Server, path: Path) -> None:
    """The card of devices that differ, with its result."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.address}#{SHOWN}&{TOLERANCES}")
    Tab(page).complete()
    page.locator("#asked").scroll_into_view_if_needed()
    page.locator("#scatter-run").click()
    page.locator("#scatter-charts canvas").wait_for(timeout=120_000)
    page.wait_for_timeout(300)
    page.locator("#scatter").screenshot(path=path)
    page.close()
    shrink(path)


def shrink(path: Path) -> None:
    """A page has few colors: a third of the bytes."""
    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        few.save(path, optimize=True)


def main(folder: Path) -> None:
    """All of them."""
    folder.mkdir(parents=True, exist_ok=True)
    with running() as server, launched_browser() as browser:
        for width in WIDTHS:
            for scheme in ("light", "dark"):
                path = folder / f"explorer-{width}-{scheme}.png"
                take(browser, server, width, scheme, path)
                print(path)
        take(browser, server, 1440, "light", folder / "explorer.png", whole=False)
        print(folder / "explorer.png")
        take_devices(browser, server, folder / "explorer-devices.png")
        print(folder / "explorer-devices.png")
    with running(str(SYSTEM)) as server, launched_browser() as browser:
        path = folder / "explorer-system.png"
        take(browser, server, 1440, "light", path, shown=SHOWN_OF_SYSTEM, seconds=SECONDS_OF_SYSTEM)
        print(path)
        path = folder / "explorer-several.png"
        take(browser, server, 1440, "light", path, system="chain", shown=SHOWN_OF_SYSTEM, seconds=SECONDS_OF_SEVERAL)
        print(path)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
