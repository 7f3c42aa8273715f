"""The server of the page: static files, the list of methods as a script, one WebSocket per tab, checks of requests.

Everyone who can reach the port can use the page, so by default the server is bound to this computer.  Other pages in
the same browser must not use it: a request with the Host of another server (DNS rebinding), or a WebSocket with the
Origin of another page, is refused at once.
"""

from __future__ import annotations

import asyncio
import ipaddress
import json
import mimetypes
import signal
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from springpot.explorer.engine import MOST_SESSIONS, Engine
from springpot.explorer.protocol import LONGEST_MESSAGE, Problem, parse
from springpot.explorer.question import Opened
from springpot.explorer.session import Session
from springpot.explorer.views import opened_script
from springpot.machine.interrupt import sigterm_as_ctrl_c
from springpot.machine.platforms import claim_port
from springpot.theory.registry import METHODS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from starlette.requests import Request
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

STATIC = Path(__file__).with_name("static")
FRAMES_PER_SECOND = 60.0
PATIENCE = 1.0  # s to wait for the first page before loading
FIRST_MESSAGE_SECONDS = 5.0  # after which a tab that has sent nothing is closed
MOST_REFUSED = 20  # messages of one tab, before it is closed
MESSAGES_PER_SECOND, MOST_AT_ONCE = 100.0, 200.0
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
PLACE = "system"  # in the address: which system of the shelf a tab shows
_LOCAL_NAMES = ("localhost", "127.0.0.1", "[::1]")
LINE_WIDTH = 2.0  # px, of the page's curves


class Allowance:
    """Rate limit of messages: ``burst`` at once, ``rate`` per second on average.

    Examples
    --------
    >>> allowance = Allowance(rate=1.0, burst=2.0)
    >>> allowance.take(), allowance.take(), allowance.take()
    (True, True, False)
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._rate, self._burst = rate, burst
        self._left, self._last = burst, time.monotonic()

    def take(self) -> bool:
        """Whether one more message is allowed now."""
        now = time.monotonic()
        self._left = min(self._burst, self._left + (now - self._last) * self._rate)
        self._last = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class Guard:
    """Refuses requests for another host and WebSockets from another page, and adds headers to every answer."""

    def __init__(self, app: ASGIApp, allowed: Callable[[str], bool]) -> None:
        self._app, self._allowed = app, allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        trusted = len(hosts) == 1 and self._allowed(hosts[0])
        if scope["type"] == "websocket":
            if trusted and origins == [f"http://{hosts[0]}"]:
                await self._app(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008})  # before it was accepted: HTTP's 403
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                added = [(name.lower().encode(), value.encode()) for name, value in HEADERS.items()]
                message["headers"] = [*message["headers"], *added]
            await send(message)

        answer: ASGIApp = self._app
        if not trusted:
            answer = PlainTextResponse("This server answers only under its own address.\n", status_code=421)
        await answer(scope, receive, send_with_headers)


def allowed_hosts(address: str, port: int) -> Callable[[str], bool]:
    """A function that says whether a Host header is this server's.

    Bound to one address: that address and, if it is local, ``localhost`` and its numerical forms.  Bound to all
    addresses: these, the name of this computer and any numerical address, because only names can be redirected by DNS.

    Examples
    --------
    >>> mine = allowed_hosts("127.0.0.1", 8765)
    >>> mine("localhost:8765"), mine("localhost:80"), mine("evil.example:8765")
    (True, False, False)
    """
    numerical = ipaddress.ip_address(address)
    shown = f"[{address}]" if numerical.version == 6 else address
    names = {shown}
    if numerical.is_loopback or numerical.is_unspecified:
        names.update(_LOCAL_NAMES)
    if numerical.is_unspecified:
        names.add(socket.gethostname().lower())
    hosts = {f"{name}:{port}" for name in names} | (names if port == 80 else set())

    def allowed(host: str) -> bool:
        if host.lower() in hosts:
            return True
        name, _, its_port = host.rpartition(":")
        if not numerical.is_unspecified or its_port != str(port):
            return False
        try:
            ipaddress.ip_address(name.strip("[]"))
        except ValueError:
            return False
        return True

    return allowed


def application(allowed: Callable[[str], bool], opened: Opened) -> ASGIApp:
    """The page as an ASGI application.

    Parameters
    ----------
    allowed : callable
        Tells whether a Host header is this server's.
    opened : Opened
    """
    mimetypes.add_type("text/javascript", ".js")  # some systems have another type, which browsers refuse
    engine = Engine(opened)
    open_tabs: set[WebSocket] = set()
    first_tab = asyncio.Event()

    async def load() -> None:
        """Load theory and kernel after the first page is served, so that the page comes sooner."""
        with suppress(TimeoutError):
            await asyncio.wait_for(first_tab.wait(), PATIENCE)
        await engine.load()

    @asynccontextmanager
    async def lifespan(_: Starlette) -> AsyncIterator[None]:
        loading = asyncio.create_task(load())
        yield
        loading.cancel()
        engine.close()

    def page(request: Request) -> Response:
        if not (place := request.query_params.get(PLACE, "")):
            return FileResponse(STATIC / "index.html")
        known = place if engine.shelf.has(place) else "none"
        whole = (STATIC / "index.html").read_text(encoding="utf-8")
        return HTMLResponse(whole.replace("/opened.js", f"/opened.js?{PLACE}={known}"))

    def script(place: str, text: Callable[[Request], str]) -> Route:
        return Route(place, lambda request: Response(text(request), media_type="text/javascript"))

    @lru_cache(maxsize=64)
    def opened_at(place: str) -> str:
        return opened_script(engine.shelf.at(place), [*engine.shelf.listed()], place)

    def opened_here(request: Request) -> str:
        place = request.query_params.get(PLACE, "")
        return opened_at(place) if engine.shelf.has(place) else opened_script(opened, [*engine.shelf.listed()], None)

    async def tab(websocket: WebSocket) -> None:
        await websocket.accept()
        first_tab.set()
        if len(open_tabs) >= MOST_SESSIONS:
            await websocket.close(1013, f"{MOST_SESSIONS} pages are open already: close one and reload.")
            return
        open_tabs.add(websocket)
        try:
            await _attend(websocket, Session(engine, websocket.query_params.get(PLACE, "")))
        finally:
            open_tabs.discard(websocket)

    methods = method_list()
    opened_at("")  # before anyone waits for it
    routes = [
        Route("/", page),
        script("/methods.js", lambda _: methods),
        script("/opened.js", opened_here),
        WebSocketRoute("/live", tab),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    return Guard(Starlette(routes=routes, lifespan=lifespan), allowed)


async def _attend(websocket: WebSocket, session: Session) -> None:
    """Listen, compute and send for one tab until it closes."""
    parts = [asyncio.create_task(part) for part in (_listen(websocket, session), _send(websocket, session))]
    parts.append(asyncio.create_task(session.compute()))
    try:
        await asyncio.wait(parts, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for part in parts:
            part.cancel()
        session.close()
        await asyncio.gather(*parts, return_exceptions=True)


async def _listen(websocket: WebSocket, session: Session) -> None:
    allowance, refused = Allowance(MESSAGES_PER_SECOND, MOST_AT_ONCE), 0
    first = True
    while True:
        try:
            event = await asyncio.wait_for(websocket.receive(), FIRST_MESSAGE_SECONDS if first else None)
        except TimeoutError:
            await websocket.close(1008, "the page sent no request: reload it.")
            return
        first = False
        if event["type"] == "websocket.disconnect":
            return
        if not allowance.take():
            await websocket.close(1008, "too many messages: reload the page.")
            return
        asked = None
        try:
            message = parse(event.get("text"))
            if isinstance(message, Problem):
                asked = message.generation
            session.receive(message)
        except (TypeError, ValueError) as error:
            refused += asked is None  # what a system refuses, a person may ask again and again
            if refused > MOST_REFUSED:
                await websocket.close(1008, "too many invalid messages: reload the page.")
                return
            session.refuse(str(error), asked)


async def _send(websocket: WebSocket, session: Session) -> None:
    loop = asyncio.get_running_loop()
    next_frame = loop.time()
    try:
        while True:
            for message in session.due():
                if isinstance(message, bytes):
                    await websocket.send_bytes(message)
                else:
                    await websocket.send_text(message)
            next_frame = max(next_frame + 1.0 / FRAMES_PER_SECOND, loop.time())
            await asyncio.sleep(next_frame - loop.time())
    except (WebSocketDisconnect, RuntimeError):  # the tab is closed, or being closed
        return


def listen_on(address: str, port: int) -> socket.socket:
    """A listening socket.

    Raises
    ------
    ValueError
        If the address is not valid or the port is out of range.
    OSError
        One sentence, if the port cannot be used.
    """
    try:
        family = socket.AF_INET6 if ipaddress.ip_address(address).version == 6 else socket.AF_INET
    except ValueError:
        raise ValueError(f"host must be a numerical address such as 127.0.0.1 or 0.0.0.0, not {address!r}.") from None
    if not 0 <= port <= 65535:
        raise ValueError(f"port must be in [0, 65535], not {port}; 0 takes any free port.")
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        claim_port(listening)
        listening.bind((address, port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        raise OSError(
            f"port {port} of {address} cannot be used ({error.strerror}): choose another with --port, or --port 0 for "
            "any free port."
        ) from None
    return listening


def serve(sockets: Sequence[socket.socket], ready: Callable[[], None], opened: Opened) -> None:
    """Serve the page until Ctrl-C or SIGTERM, which raise KeyboardInterrupt.

    Ctrl-C stays ignored where it was, as in the background of a script.

    Parameters
    ----------
    sockets : sequence of socket
        Listening, see `listen_on`.
    ready : callable
        Called when the server is ready.
    opened : Opened
    """
    import logging

    import uvicorn

    from springpot.explorer.connections import HttpConnection, WebSocketConnection

    address, port = sockets[0].getsockname()[:2]

    class Server(uvicorn.Server):
        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            if self.started:
                ready()

        @contextmanager
        def capture_signals(self) -> Iterator[None]:
            before = signal.getsignal(signal.SIGINT)
            with super().capture_signals():
                if before is signal.SIG_IGN:
                    signal.signal(signal.SIGINT, signal.SIG_IGN)
                yield

    logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)  # errors that hostile clients cause are not logged
    config = uvicorn.Config(
        application(allowed_hosts(address, port), opened),
        lifespan="on",
        log_config=None,
        access_log=False,
        server_header=False,
        http=HttpConnection,
        ws=WebSocketConnection,
        ws_max_size=4 * LONGEST_MESSAGE,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
    )
    with sigterm_as_ctrl_c():
        Server(config).run(list(sockets))


def method_list() -> str:
    """A JavaScript module with the methods by name, the most exact first: label, color, dash in px, ``over_order``.

    Examples
    --------
    >>> method_list().splitlines()[1]
    'export const NAMES = Object.keys(METHODS);'
    """
    listed = {
        method.name: {
            "label": method.label,
            "color": method.color,
            "dash": [LINE_WIDTH * length for length in method.dash],
            "over_order": method.over_order,
        }
        for method in reversed([*METHODS.values()])
    }
    return f"export const METHODS = {json.dumps(listed)};\nexport const NAMES = Object.keys(METHODS);\n"
