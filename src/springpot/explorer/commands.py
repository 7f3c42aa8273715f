"""``springpot explore``: open the page."""

from __future__ import annotations

import sys
import threading
import webbrowser

from springpot.interrupt import leave_at_once

__all__ = ["open_page"]


def open_page(*, host: str, port: int, browser: bool) -> None:
    """Serve the page until Ctrl-C.

    Parameters
    ----------
    host : str
        Numerical address to bind to.
    port : int
        0 for any free port.
    browser : bool
        Whether to open the page in the browser.

    Raises
    ------
    ValueError, OSError
        One sentence, if address or port cannot be used.
    """
    with leave_at_once():
        from springpot.explorer.server import listen_on, serve

    listening = listen_on(host, port)
    shown = f"[{host}]" if ":" in host else host
    if host in ("0.0.0.0", "::"):
        shown = "localhost"
        print(
            "springpot: warning: every computer that can reach this one can use the page; it asks for no password.",
            file=sys.stderr,
        )
    address = f"http://{shown}:{listening.getsockname()[1]}/"

    def ready() -> None:
        print(f"The page is at {address} (Ctrl-C ends it).", flush=True)
        if browser:
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    serve([listening], ready)
