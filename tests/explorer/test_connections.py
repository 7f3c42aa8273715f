"""Connections that do not play by the rules: half a request, slow bytes, many at once, closed in the middle."""

from __future__ import annotations

import asyncio
import gc
import json
import signal
import socket
import time
import urllib.request
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from typing import Any

import pytest
import uvicorn
from websockets.exceptions import ConnectionClosed

import springpot as sp
from springpot.explorer import connections
from springpot.explorer.connections import MOST_CONNECTIONS, REQUEST_SECONDS
from springpot.explorer.engine import MOST_SESSIONS, Engine
from springpot.explorer.protocol import Problem
from springpot.explorer.question import Opened
from springpot.explorer.server import FIRST_MESSAGE_SECONDS
from springpot.explorer.session import Session
from tests.explorer.conftest import Server, running
from tests.explorer.talk import tab
from tests.posix import needs_signals
from tests.signals import in_a_terminal


def connected(server: Server, sent: str = "") -> socket.socket:
    made = socket.create_connection(("127.0.0.1", server.port), timeout=10)
    made.sendall(sent.format(port=server.port).encode())
    return made


def page_comes(server: Server, seconds: float = 3.0) -> bool:
    with urllib.request.urlopen(server.address, timeout=seconds) as found:
        return found.status == 200 and b"springpot" in found.read()


def closed_within(connection: socket.socket, seconds: float) -> bool:
    """Whether the server ends a connection in time."""
    connection.settimeout(seconds)
    with suppress(ConnectionResetError):
        try:
            while connection.recv(65536):
                pass
        except TimeoutError:
            return False
    return True


HALF = "GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nX-Slow: "


def test_half_requests_keep_nobody_out_and_are_ended(server: Server) -> None:
    """200 connections that have sent half a request: the page comes for others at once, and they are closed in time."""
    with ExitStack() as stack:
        halves = [stack.enter_context(connected(server, HALF)) for _ in range(200)]
        begun = time.monotonic()
        assert page_comes(server)
        assert time.monotonic() - begun < 2.0
        end = begun + REQUEST_SECONDS + 2.0
        assert all(closed_within(half, max(end - time.monotonic(), 0.01)) for half in halves)


def test_more_than_there_is_room_for(server: Server) -> None:
    """Those that have waited longest without a request make room for a new one."""
    with ExitStack() as stack:
        for _ in range(MOST_CONNECTIONS + 40):
            stack.enter_context(connected(server, HALF))
        for _ in range(5):
            assert page_comes(server)


def ended_after(server: Server, begin: str, byte: bytes, every: float = 0.3) -> float:
    """How long a connection is kept that sends a byte now and then, in s."""
    with connected(server, begin) as slow:
        begun = time.monotonic()
        slow.settimeout(every)
        while time.monotonic() - begun < REQUEST_SECONDS + 5.0:
            try:
                slow.sendall(byte)
                if slow.recv(4096) == b"":
                    break
            except TimeoutError:
                continue
            except (ConnectionResetError, BrokenPipeError):
                break
        return time.monotonic() - begun


def test_slow_bytes_do_not_extend_the_time(server: Server) -> None:
    """A byte now and then: before a request, in its headers, in a body that nobody wants, after an answer."""
    body = "POST / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
    slow = [
        ("", b"\n"),
        (HALF, b"a"),
        (body + "Content-Length: 100000\r\n\r\n", b"a"),
        (body + "Transfer-Encoding: chunked\r\n\r\n", b"1\r\na\r\n"),
        ("GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n", b"\n"),
    ]
    with ThreadPoolExecutor(len(slow)) as pool:
        kept = list(pool.map(lambda one: ended_after(server, *one), slow))
    assert max(kept) < REQUEST_SECONDS + 2.0, kept


def test_two_hundred_requests_at_once_are_all_answered(server: Server) -> None:
    with ExitStack() as stack:
        request = "GET /static/js/main.js HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n"
        waiting = [stack.enter_context(connected(server)) for _ in range(200)]
        for one in waiting:
            one.sendall(request.format(port=server.port).encode())

        def status(connection: socket.socket) -> str:
            return connection.recv(64).decode().split()[1]

        with ThreadPoolExecutor(16) as pool:
            assert set(pool.map(status, waiting)) == {"200"}


def test_an_answer_that_nobody_reads_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """More than the system's buffers hold, to a client that reads nothing; and the server then ends at once."""
    monkeypatch.setattr(connections, "ANSWER_SECONDS", 0.5)

    async def endless(scope: Any, _: Any, send: Any) -> None:
        assert scope["type"] == "http"
        await send({"type": "http.response.start", "status": 200, "headers": []})
        for _ in range(1000):
            await send({"type": "http.response.body", "body": bytes(2**20), "more_body": True})

    async def asked() -> tuple[int, float]:
        config = uvicorn.Config(endless, http=connections.HttpConnection, lifespan="off", log_config=None)
        server, listening = uvicorn.Server(config), socket.create_server(("127.0.0.1", 0))
        serving = asyncio.create_task(server.serve([listening]))
        while not server.started:
            await asyncio.sleep(0.01)
        _, writer = await asyncio.open_connection(*listening.getsockname(), limit=1024)
        writer.write(b"GET / HTTP/1.1\r\nHost: here\r\n\r\n")
        await asyncio.sleep(1.2)
        held, begun = len(server.server_state.connections), time.monotonic()
        server.should_exit = True
        await serving
        writer.close()
        return held, time.monotonic() - begun

    held, seconds = asyncio.run(asked())
    assert held == 0
    assert seconds < 1.0


@pytest.mark.validation  # every day: half requests, in this file
def test_a_tab_that_says_nothing_gives_its_place_back(server: Server) -> None:
    with ExitStack() as stack:
        silent = [stack.enter_context(tab(server)) for _ in range(MOST_SESSIONS)]
        end = time.monotonic() + FIRST_MESSAGE_SECONDS + 3.0
        for one in silent:
            with pytest.raises(ConnectionClosed) as closed:
                one.count(end - time.monotonic())
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1008
        with tab(server) as honest:
            honest.say(kind="problem", paths=64)
            honest.until("estimates", complete=True)


@pytest.mark.validation  # every day: the end of a server on which nothing hangs, in test_server.py
@needs_signals
def test_an_orderly_end_whatever_hangs_on_the_server() -> None:
    """Half requests, silent tabs, tabs that ask without an end: one line, at once."""
    with in_a_terminal(), running() as started, ExitStack() as stack:
        with tab(started) as first:
            first.say(kind="problem", paths=64, start="rest")
            first.until("estimates", complete=True)
        for _ in range(50):
            stack.enter_context(connected(started, HALF))
        tabs = [stack.enter_context(tab(started)) for _ in range(8)]
        for generation in range(20):
            for asking in tabs[:6]:
                asking.say(kind="problem", generation=generation, order=0.3 + 0.01 * generation, paths=100_000)
        begun = time.monotonic()
        started.process.send_signal(signal.SIGINT)
        with pytest.raises(ConnectionClosed):
            tabs[0].count(20.0)
        out, err = started.process.communicate(timeout=30)
        assert time.monotonic() - begun < 10.0
    assert started.process.returncode == 130
    assert (out, err) == ("", "springpot: interrupted.\n")


def test_work_that_is_dropped_before_it_begins_leaves_no_warning() -> None:
    """Questions that follow each other at once, and an end in between: every coroutine has been awaited."""

    async def hurried() -> None:
        engine = Engine(Opened())
        for pauses in range(6):
            session = Session(engine)
            computing = asyncio.create_task(session.compute())
            for generation in range(3):
                session.receive(Problem(generation=generation, paths=64))
                for _ in range(pauses):
                    await asyncio.sleep(0)
            computing.cancel()
            await asyncio.gather(computing, return_exceptions=True)
        engine.close()

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        asyncio.run(hurried())
        gc.collect()
    assert [str(warning.message) for warning in said] == []


def test_what_is_asked_before_the_kernel_is_there_is_answered_with_it() -> None:
    async def asked() -> dict[str, Any]:
        engine = Engine(Opened())
        session, said = Session(engine), dict[str, Any]()
        computing = asyncio.create_task(session.compute())

        async def hear(kind: str) -> None:
            while kind not in said:
                texts = [json.loads(text) for text in session.due() if isinstance(text, str)]
                said.update({text["kind"]: text for text in texts})
                await asyncio.sleep(0.01)

        session.receive(Problem(generation=1, without=["barrier"], paths=64))
        await hear("accepted")
        assert (said["status"]["theory"], said["status"]["kernel"]) == (False, False)
        assert "estimates" not in said
        await engine.load()
        await hear("estimates")
        while not said["status"]["kernel"]:
            del said["status"]
            await hear("status")
        computing.cancel()
        await asyncio.gather(computing, return_exceptions=True)
        engine.close()
        return said

    said = asyncio.run(asked())
    run = sp.simulate(sp.Oscillator(barrier=None), paths=64)
    assert said["status"]["kernel"]
    assert said["estimates"]["values"]["x_mean_square"] == run["x_mean_square"].value


def test_frames_cut_off_in_the_middle_hurt_nobody(server: Server) -> None:
    """A WebSocket closed within a frame, and one that leaves a frame unfinished beside an honest tab."""
    handshake = (
        "GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Origin: http://127.0.0.1:{port}\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    text = json.dumps({"kind": "problem", "paths": 100_000}).encode()
    with ExitStack() as stack:
        for length in range(0, 12, 2):
            cut = stack.enter_context(connected(server, handshake))
            cut.recv(4096)
            cut.sendall((bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)[:length])
            if length % 4:
                cut.close()
        with tab(server) as honest:
            honest.say(kind="problem", paths=64)
            honest.until("estimates", complete=True)
