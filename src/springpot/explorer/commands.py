"""``springpot explore`` and `springpot.explore`: open the page."""

from __future__ import annotations

import sys
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

from springpot.machine.interrupt import leave_at_once
from springpot.problem.system import System

if TYPE_CHECKING:
    from springpot.explorer.question import Opened


def explore(system: System, *, host: str = "127.0.0.1", port: int = 8765, browser: bool = True) -> None:
    """Open a page in the browser with a slider for each number of a system, and serve it until Ctrl-C.

    Parameters
    ----------
    system : System
    host : str
        Numerical address to listen on; the default serves this computer only.
    port : int
        0 for any free port.
    browser : bool
        Whether to open the page in the browser, or only print its address.

    Raises
    ------
    TypeError
        If it is something else.
    ValueError, OSError
        One sentence, if address or port cannot be used.

    Examples
    --------
    >>> import springpot as sp
    >>> sp.explore(sp.System(sp.Spring(80.0), sp.Dashpot(0.4), sp.WhiteNoise(1.0)))  # doctest: +SKIP
    """
    with leave_at_once():
        from springpot.explorer.question import Opened
        from springpot.problem.system import checked_system
    open_page(Opened(checked_system(system)), host=host, port=port, browser=browser)


def open_file(file: str | None, *, host: str, port: int, browser: bool) -> None:
    """The same for a system's file, or for the paper's oscillator."""
    with leave_at_once():
        from springpot.explorer.question import Opened
        from springpot.problem.file import read_system
    opened = Opened() if file is None else Opened(read_system(file), Path(file).name)
    open_page(opened, host=host, port=port, browser=browser)


def open_page(opened: Opened, *, host: str, port: int, browser: bool) -> None:
    """Serve the page until Ctrl-C.

    Parameters
    ----------
    opened : Opened
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

    serve([listening], ready, opened)
