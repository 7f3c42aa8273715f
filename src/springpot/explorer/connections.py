"""Limits on the number of connections of the page's server and on their duration, which uvicorn does not have.

A browser sends its whole request at once and reads the answer at once.  Connections that do not - half a request, a
byte now and then, an answer that is not read - are closed after a fixed time, and sooner if there are too many.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, cast

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

if TYPE_CHECKING:
    from uvicorn._types import ASGISendEvent

MOST_CONNECTIONS = 256  # open at once, of both kinds
REQUEST_SECONDS = 5.0  # from the connection, or the answer before, until a request is complete
ANSWER_SECONDS = 30.0  # from the request until its answer has been sent


class HttpConnection(H11Protocol):
    """One HTTP connection, with a time limit on each request and each answer."""

    _deadline: asyncio.TimerHandle | None = None
    _since = 0.0  # start of the wait for a request

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accept a connection; if there are too many, close the one that has waited longest."""
        super().connection_made(transport)
        self._await_request()
        if len(self.connections) > MOST_CONNECTIONS:
            waiting = [one for one in self.connections if isinstance(one, HttpConnection) and one.waiting]
            min(waiting, key=lambda one: one._since).end()  # not empty: this one waits

    @property
    def waiting(self) -> bool:
        """Whether there is no complete request that is being answered."""
        return self.cycle is None or self.cycle.response_complete

    def handle_events(self) -> None:
        """Handle received data; a complete request starts the time limit of its answer."""
        before = self.cycle
        super().handle_events()
        if self.cycle is not before and not self.waiting:
            self._limit(ANSWER_SECONDS)

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self._await_request()
        super().on_response_complete()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over."""
        self._cancel()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the time limit."""
        self._cancel()
        super().connection_lost(exc)

    def shutdown(self) -> None:
        """Close the connection; an answer that is being sent is completed first."""
        if self.waiting:
            self.end()
        else:
            super().shutdown()

    def end(self) -> None:
        """Close the connection at once."""
        self._cancel()
        self.connections.discard(self)  # at once, not when the event loop gets to it
        self.transport.abort()

    def _await_request(self) -> None:
        self._since = self.loop.time()
        self._limit(REQUEST_SECONDS)

    def _limit(self, seconds: float) -> None:
        self._cancel()
        self._deadline = self.loop.call_later(seconds, self.end)

    def _cancel(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None


class WebSocketConnection(WebSocketsSansIOProtocol):
    """One WebSocket; it is closed in time even if the other end reads nothing."""

    def keepalive_timeout(self) -> None:
        """Close the connection if a ping is not answered."""
        super().keepalive_timeout()
        self.transport.abort()

    async def send(self, message: ASGISendEvent) -> None:
        """Send a message; a closing one sets a time limit for the close."""
        await super().send(message)
        if cast("dict[str, Any]", message)["type"] == "websocket.close":
            self.loop.call_later(self.close_timeout, self.transport.abort)
