"""The server: whom it answers, what it withstands, and how it ends."""

from __future__ import annotations

import json
import random
import signal
import socket
import subprocess
import time
import urllib.error
import urllib.request
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from springpot.explorer.engine import MOST_SESSIONS
from springpot.explorer.protocol import LONGEST_MESSAGE
from springpot.explorer.server import allowed_hosts
from tests.explorer.conftest import COMMAND, Server, running
from tests.explorer.talk import Tab, numbers, tab
from tests.posix import needs_signals
from tests.signals import in_a_terminal
from tests.sizes import validation

SMALL = {"kind": "problem", "paths": 256}
LONG = {"kind": "problem", "paths": 100_000, "numbers": {"springpot-coefficient": 0.4}}
# lightly damped, and behind a lossy wall that it seldom strikes, where short steps are taken
SLOW = {
    "springpot-coefficient": 1e-3, "barrier-restitution": 0.2, "barrier-position": -2.0, "white_noise-intensity": 1e-4
}  # fmt: skip
needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc here")


def answer(server: Server, path: str = "/", **headers: str) -> tuple[int, dict[str, str], bytes]:
    request = urllib.request.Request(server.origin + path, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=30) as found:
            return found.status, dict(found.headers), found.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


def raw(server: Server, sent: bytes) -> bytes:
    with socket.create_connection(("127.0.0.1", server.port), timeout=10) as connection:
        connection.sendall(sent)
        connection.settimeout(10)
        received = b""
        try:
            while part := connection.recv(4096):
                received += part
                if b"\r\n\r\n" in received:
                    break
        except TimeoutError:
            pass
        return received


def test_every_file_of_the_page_is_there(server: Server) -> None:
    status, headers, page = answer(server)
    assert status == 200
    assert b"springpot" in page
    assert "default-src 'none'" in headers["content-security-policy"]
    static = Path(__file__).parents[2] / "src" / "springpot" / "explorer" / "static"
    for file in static.rglob("*"):
        if file.is_file():
            status, headers, content = answer(server, f"/static/{file.relative_to(static)}")
            assert (status, content) == (200, file.read_bytes())
            if file.suffix == ".js":
                assert headers["content-type"].startswith("text/javascript")
                # named in the page, or where the cards far below and the charts of the first fit are loaded: a module
                # that is first named by another one is asked for a round later
                loaders = [(static / "js" / name).read_text(encoding="utf-8") for name in ("main.js", "fit.js")]
                later = any(f'import("./{file.name}")' in loader for loader in loaders)
                assert later or f"/static/{file.relative_to(static)}".encode() in page


def test_vendored_code_has_its_licence() -> None:
    vendor = Path(__file__).parents[2] / "src" / "springpot" / "explorer" / "static" / "vendor"
    assert "MIT" in (vendor / "uPlot.LICENSE").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1:1", "localhost.evil.example:{port}", ""]
)
def test_another_host_is_turned_away(server: Server, host: str) -> None:
    """As a page does whose name was made to point here (DNS rebinding)."""
    sent = f"GET / HTTP/1.1\r\nHost: {host.format(port=server.port)}\r\nConnection: close\r\n\r\n"
    assert b" 421 " in raw(server, sent.encode()).splitlines()[0]
    handshake = (
        f"GET /live HTTP/1.1\r\nHost: {host.format(port=server.port)}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Origin: {server.origin}\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    assert b" 403 " in raw(server, handshake.encode()).splitlines()[0]


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "https://127.0.0.1", "null", "http://127.0.0.1:1", "http://localhost", None]
)
def test_another_origin_is_turned_away(server: Server, origin: str | None) -> None:
    with pytest.raises(InvalidStatus) as refusal, connect(server.live, origin=origin):  # type: ignore[arg-type]
        pass
    assert refusal.value.response.status_code == 403


def test_the_names_of_this_computer_are_enough() -> None:
    local, everywhere = allowed_hosts("127.0.0.1", 80), allowed_hosts("0.0.0.0", 8765)
    assert local("LOCALHOST")
    assert local("[::1]:80")
    assert not local("192.168.0.2:80")
    assert everywhere("192.168.0.2:8765")
    assert not everywhere("evil.example:8765")
    assert not everywhere("192.168.0.2")


def test_nothing_outside_the_page_is_served(server: Server) -> None:
    for path in ("/static/../server.py", "/static/%2e%2e/server.py", "/static/..%2fserver.py", "/etc/passwd", "/live"):
        assert answer(server, path)[0] == 404
    assert b" 405 " in raw(
        server, f"POST / HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nContent-Length: 0\r\n\r\n".encode()
    )


def hostile_messages(count: int) -> list[str | bytes]:
    """Of all the kinds that we could think of, the same each time."""
    draw = random.Random(2)
    problem = {"kind": "problem", "generation": 1, "paths": 64}
    values = [
        '{"springpot-order": 7}', '{"springpot-order": 1e999}', '{"spring-stiffness": -1e300}', '["barrier", "spring"]',
        "NaN", "Infinity", "-Infinity", "1e999", "-1e308", "null", "true", '"1"', "[]", "{}", "[[[[1]]]]", "10" * 200,
        '"' + "x" * 900 + '"', "-0.0", "1e-999", '"\\ud800"', "99999999999999999999",
    ]  # fmt: skip
    names = [*problem, "numbers", "without", "start", "seed", "__class__", "order"]
    found: list[str | bytes] = []
    while len(found) < count:
        match draw.randrange(7):
            case 0:
                found.append(bytes(draw.randrange(256) for _ in range(draw.randrange(1, 400))))
            case 1:
                found.append("".join(chr(draw.randrange(1, 0xD000)) for _ in range(draw.randrange(1, 300))))
            case 2:
                found.append("[" * draw.randrange(1, 2000))
            case 3:
                found.append("y" * (LONGEST_MESSAGE + draw.randrange(1, 200_000)))
            case 4:
                found.append(json.dumps({"kind": draw.choice(["problem", "play", "step", "", "admin"]), "x": 1}))
            case _:
                parts = [f'"{name}": {json.dumps(value)}' for name, value in problem.items()]
                parts.append(f'"{draw.choice(names)}": {draw.choice(values)}')
                found.append("{" + ", ".join(parts) + "}")
    return found


@needs_proc
def test_a_thousand_hostile_messages_hurt_nobody(server: Server) -> None:
    """The server stays up, its memory flat, and another tab gets its numbers and its frames as before."""
    with tab(server) as witness:
        witness.say(**{**SMALL, "generation": 42})
        before_them = witness.until("estimates", complete=True)["values"]

        def throw(messages: list[str | bytes]) -> tuple[int, int]:
            """In handfuls, for the server shows a tab out that does not stop; the huge ones end a connection each.

            Returns how many handfuls and how many huge ones were refused.
            """
            huge = [message for message in messages if len(message) > 4 * LONGEST_MESSAGE]
            others = [message for message in messages if len(message) <= 4 * LONGEST_MESSAGE]
            handfuls = [others[begin : begin + 20] for begin in range(0, len(others), 20)]
            refused, closed = 0, 0
            for handful in handfuls:
                with tab(server) as attacker:
                    for message in handful:
                        attacker.socket.send(message)
                    refused += attacker.until("refused", seconds=20.0) is not None
            for message in huge:
                with tab(server) as attacker:
                    try:
                        attacker.socket.send(message)
                        attacker.count(20.0)
                    except ConnectionClosed:
                        closed += 1
            assert (refused, closed) == (len(handfuls), len(huge))
            return refused, closed

        grown = []
        for _ in range(3):  # a leak grows each time; what is imported and cached on the way does so once
            before = server.memory()
            refused, closed = throw(hostile_messages(1000))
            assert refused > 40
            assert closed > 100
            time.sleep(0.5)
            grown.append(server.memory() - before)
        assert min(grown) < 5.0
        assert server.process.poll() is None
        while True:  # what has come in meanwhile: of its own question only
            try:
                kind, content = witness.hear(0.0)
            except TimeoutError:
                break
            assert (content[0] if kind.isdigit() else content["generation"]) == 42
        assert witness.count(1.0) > 10
        witness.say(**{**SMALL, "generation": 43})
        assert witness.until("estimates", complete=True, generation=43)["values"] == before_them


def flood(attacker: Tab) -> None:
    for generation in range(5000):
        attacker.say(**{**LONG, "generation": generation})
    attacker.count(10.0)


@pytest.mark.validation  # every day: a thousand hostile messages, which show tabs out too
@needs_proc
def test_a_flood_is_shown_out(server: Server) -> None:
    with tab(server) as witness:
        for question in (LONG, SMALL):  # what is loaded and kept for one question is no flood
            witness.say(**question)
            awaited = {"theory", "complete"}
            while awaited:
                kind, content = witness.hear(60.0)
                awaited -= {kind, "complete" if kind == "estimates" and content["complete"] else ""}
        before = server.memory()
        with tab(server) as attacker, pytest.raises(ConnectionClosed) as closed:
            flood(attacker)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008
        assert witness.count(1.0) > 10
    assert server.memory() - before < 60.0


def test_a_tab_that_does_not_read_costs_nothing(server: Server) -> None:
    """Frames that nobody takes are not kept."""
    with tab(server) as witness:
        witness.say(**SMALL)
        witness.until("estimates", complete=True)
        # neither read nor buffered: the socket's own buffer fills up
        with socket.create_connection(("127.0.0.1", server.port), timeout=10) as silent:
            silent.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            silent.sendall(
                f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                f"Origin: {server.origin}\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
            )
            text = json.dumps({**LONG, "generation": 1}).encode()
            silent.sendall(bytes([0x81, 0x80 | len(text), 0, 0, 0, 0]) + text)
            time.sleep(2.0)  # what the run itself needs is there by then
            before = server.memory()
            time.sleep(2.0)
            assert server.memory() - before < 60.0
            assert witness.count(0.5) > 5


@needs_proc
@pytest.mark.parametrize(
    ("asked", "heard"),
    [
        (LONG, "estimates"),
        validation({**LONG, "numbers": numbers(order=0.2, coefficient=0.4), "start": "stationary"}, "searching"),
    ],
)
def test_a_closed_tab_stops_its_computation(server: Server, asked: dict[str, Any], heard: str) -> None:
    with tab(server) as busy:
        busy.say(**asked)
        busy.until(heard)
        begun = server.processor_time()
        time.sleep(1.0)
        assert server.processor_time() - begun > 0.3  # it computes
    time.sleep(1.0)
    begun = server.processor_time()
    time.sleep(1.0)
    assert server.processor_time() - begun < 0.1


def test_so_many_tabs_and_no_more(server: Server) -> None:
    with ExitStack() as stack:
        tabs = [stack.enter_context(tab(server)) for _ in range(MOST_SESSIONS)]
        assert tabs[-1].hear()[0] == "status"
        with tab(server) as one_too_many, pytest.raises(ConnectionClosed) as closed:
            one_too_many.count(10.0)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1013
        assert "close one" in closed.value.rcvd.reason
    time.sleep(0.3)
    with tab(server) as again:
        assert again.hear()[0] == "status"


def test_only_the_newest_question_is_answered(server: Server) -> None:
    """As while a slider is drawn: what is overtaken is dropped, and the last answer is right."""
    with tab(server) as asking:
        for generation in range(1, 31):
            asking.say(**{**SMALL, "generation": generation, "numbers": {"springpot-order": generation / 40.0}})
        last = asking.until("estimates", complete=True, generation=30)
        with tab(server) as alone:
            alone.say(**{**SMALL, "generation": 30, "numbers": {"springpot-order": 30 / 40.0}})
            assert alone.until("estimates", complete=True)["values"] == last["values"]


def test_a_refusal_says_why(server: Server) -> None:
    with tab(server) as asking:
        asking.say(kind="problem", numbers={"springpot-order": 2})
        assert "order" in asking.until("refused")["sentence"]
        asking.say(kind="problem", generation=5, numbers=SLOW, paths=100_000)
        assert "paths" in asking.until("trouble", generation=5)["sentence"]
        asking.say(**{**SMALL, "generation": 6})  # and the tab goes on
        asking.until("estimates", complete=True, generation=6)


def test_a_pause_stops_time_and_paths(server: Server) -> None:
    with tab(server) as pausing:
        pausing.say(kind="play", playing=False, speed=4)
        pausing.say(**{**LONG, "generation": 2})
        awaited = {"curve", "1"}  # the last curve, and the path's first point
        while awaited:
            awaited.discard(pausing.hear()[0])
        assert pausing.count(0.5) == 0
        pausing.say(kind="step")
        stepped = pausing.until("estimates", generation=2)
        assert 0 < stepped["paths"] < stepped["of"]
        pausing.count(0.3)
        assert pausing.count(0.5) == 0
        pausing.say(kind="play", playing=True, speed=4)
        assert pausing.until("estimates")["paths"] > stepped["paths"]


# --- beginning and end ---------------------------------------------------------------------------------------------


@needs_signals
@pytest.mark.parametrize(
    ("busy", "sent"),
    [
        validation(True, signal.SIGINT),
        validation(True, signal.SIGTERM),
        validation(False, signal.SIGINT),
        (False, signal.SIGTERM),
    ],
)
def test_ctrl_c_is_an_orderly_end(busy: bool, sent: signal.Signals) -> None:
    """At once while modules still load, and with a tab in the middle of its work."""
    with in_a_terminal(), running() as started:
        if busy:
            with tab(started) as working:
                working.say(**LONG)
                working.until("estimates")
                started.process.send_signal(sent)
                with pytest.raises(ConnectionClosed):
                    working.count(20.0)
        else:
            started.process.send_signal(sent)
        out, err = started.process.communicate(timeout=30)
    assert started.process.returncode == 130, err
    assert (out, err) == ("", "springpot: interrupted.\n")


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, "explore", "--no-browser", *words], capture_output=True, text=True, timeout=60)


def test_a_port_in_use_is_one_sentence() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        done = run("--port", str(port))
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert f"port {port} of 127.0.0.1 cannot be used" in done.stderr
    assert "--port" in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--port", "70000"], "[0, 65535]"),
        validation(["--port", "x"], "whole number"),
        validation(["--host", "localhst"], "127.0.0.1"),
    ],
)
def test_bad_addresses_are_one_sentence(words: list[str], said: str) -> None:
    done = run(*words)
    assert done.returncode == 2
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)
    assert said in done.stderr
