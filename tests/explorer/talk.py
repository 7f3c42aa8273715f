"""A tab without a browser: asks over the WebSocket as the page does."""

from __future__ import annotations

import json
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt
from websockets.sync.client import ClientConnection, connect

from tests.explorer.conftest import Server


def numbers(
    *,
    order: float = 0.5,
    coefficient: float = 1.0,
    natural_frequency: float = 1.0,
    intensity: float = 1.0,
    position: float = 0.0,
    restitution: float = 1.0,
) -> dict[str, float]:
    """The numbers of the paper's oscillator by the names of their sliders."""
    return {
        "springpot-order": order, "springpot-coefficient": coefficient, "spring-stiffness": natural_frequency**2,
        "white_noise-intensity": intensity, "barrier-position": position, "barrier-restitution": restitution,
    }  # fmt: skip


def link(paths: int = 640, *, more: str = "", **given: float) -> str:
    """What stands behind the address of the page for the paper's oscillator with these numbers."""
    return "&".join(f"{name}={value}" for name, value in numbers(**given).items()) + f"&paths={paths}{more}"


def unpack(frame: bytes) -> tuple[int, int, list[npt.NDArray[np.float32]]]:
    """The inverse of `springpot.explorer.protocol.pack`: kind, generation, arrays."""
    kind, generation, count = struct.unpack_from("<3I", frame)
    sizes = struct.unpack_from(f"<{count}I", frame, 12)
    numbers = np.frombuffer(frame, "<f4", offset=12 + 4 * count)
    return kind, generation, np.split(numbers, np.cumsum(sizes)[:-1])


class Tab:
    """One connection."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket

    def say(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def hear(self, timeout: float = 30.0) -> tuple[str, Any]:
        """The next message: its kind and content; a binary frame's kind is its number."""
        message = self.socket.recv(timeout)
        if isinstance(message, bytes):
            kind, generation, arrays = unpack(message)
            return str(kind), (generation, arrays)
        content = json.loads(message)
        return content["kind"], content

    def until(self, kind: str, seconds: float = 60.0, **wanted: Any) -> Any:
        """The next message of a kind that holds what is wanted."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            found, content = self.hear(max(end - time.monotonic(), 0.01))
            if found == kind and all(content[name] == value for name, value in wanted.items()):
                return content
        raise AssertionError(f"no {kind} with {wanted} within {seconds} s")

    def count(self, seconds: float) -> int:
        """Binary frames that come within a time."""
        end, counted = time.monotonic() + seconds, 0
        while (left := end - time.monotonic()) > 0.0:
            try:
                counted += self.hear(left)[0].isdigit()
            except TimeoutError:
                break
        return counted


@contextmanager
def tab(server: Server, *, origin: str | None = None) -> Iterator[Tab]:
    ours: Any = origin or server.origin
    # frames that nobody has read yet must not keep the closing handshake from being read
    with connect(server.live, origin=ours, max_size=None, max_queue=None, open_timeout=30, close_timeout=2) as socket:
        yield Tab(socket)
