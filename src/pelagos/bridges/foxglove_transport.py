"""Topics and services over Foxglove's WebSocket, for its viewer and Lichtblick: the recording's messages, live.

Protocol: https://github.com/foxglove/ws-protocol, subprotocol foxglove.sdk.v1; made by `foxglove-sdk`.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import Field

from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed, listening
from pelagos.bridges.door import CLOCK_TOPIC
from pelagos.bridges.extras import require
from pelagos.bridges.transport import ONLY_HERE, Answer, BridgeError, Buffer, Qos, Receive, Write, ros2_name
from pelagos.errors import did_you_mean
from pelagos.messages.store import schema

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

BACKLOG: Final = 1024
"""Messages that wait for a client that reads slowly; then its oldest are dropped, by the library."""

FLUSH_S: Final = 0.2
"""Time in which the library sends what it holds for clients that read [s]."""

MOST_TROUBLES: Final = 1000
"""Troubles that are told apart."""


class FoxgloveConfig(BridgeConfig):
    """Foxglove: the recording's messages live, for Foxglove and Lichtblick."""

    type: Literal["foxglove"]
    host: str = LOOPBACK
    """Address to listen at; the protocol has no passwords."""
    port: int = Field(default=8765, ge=0, le=65535)
    """TCP port of the WebSocket; 0 takes a free one."""
    topics: tuple[str, ...] = ()
    """Beginnings of the topics that are shown; all where empty."""
    commands: bool = True
    """Obey commands that a panel publishes, on the topics of the ROS 2 door."""
    services: bool = True
    """Offer services (pause, reset, step ...)."""

    def listens(self) -> str:
        """See `BridgeConfig`."""
        return listening("tcp", self.host, self.port)

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        from pelagos.bridges.services import serve_topics

        transport = FoxgloveTransport(host=self.host, port=self.port)
        serve_topics(exchange, transport, only=self.topics, commands=self.commands, services=self.services)
        note = f", {transport.reach}" if exposed(self.host) else ""
        return f"Foxglove at ws://{self.host}:{transport.port}{note}"


class FoxgloveTransport:
    """A WebSocket server.

    Attributes:
        port: where it listens.
        reach: who can reach it, in words.
    """

    name = "Foxglove"
    blocks = False

    def __init__(self, *, host: str = LOOPBACK, port: int = 8765) -> None:
        self.reach = "open to the network, without passwords" if exposed(host) else ONLY_HERE
        self._sdk = require("foxglove", extra="foxglove", purpose="Foxglove")
        self._ws = require("foxglove.websocket", extra="foxglove", purpose="Foxglove")
        self._context = self._sdk.Context()
        self._receivers: dict[str, tuple[str, Receive]] = {}
        self._latched: dict[int, tuple[Any, bytes, int]] = {}
        self._lock = threading.Lock()
        self._listening: set[tuple[int, int]] = set()  # client, channel
        self.troubles: Counter[str] = Counter()
        capability = self._ws.Capability
        try:
            self._server = self._sdk.start_server(
                name="Pelagos", host=host, port=port, context=self._context, server_listener=_listener(self, self._ws),
                capabilities=[capability.ClientPublish, capability.Services, capability.Time],
                supported_encodings=["cdr"], message_backlog_size=BACKLOG,
            )  # fmt: skip
        except RuntimeError as error:
            raise BridgeError(f"foxglove: {host}:{port} cannot be used: {error}") from None
        self.port = int(self._server.port)

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`; the clock is no topic, but the time that the protocol itself tells."""
        if topic == CLOCK_TOPIC:
            return lambda cdr, t_ns: self._server.broadcast_time(t_ns)
        channel = self._sdk.Channel(
            topic, schema=self._sdk.Schema(name=type_name, encoding="ros2msg", data=schema(type_name)),
            message_encoding="cdr", context=self._context,
        )  # fmt: skip

        def write(cdr: Buffer, t_ns: int) -> None:
            raw = bytes(cdr)
            if qos.latched:
                with self._lock:
                    self._latched[channel.id()] = (channel, raw, t_ns)
            channel.log(raw, log_time=t_ns)

        return write

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        self._receivers[topic] = (type_name, receive)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        halves = [
            self._ws.MessageSchema(
                encoding="cdr",
                schema=self._sdk.Schema(
                    name=f"{type_name}_{half}", encoding="ros2msg", data=schema(f"{type_name}_{half}")
                ),
            )
            for half in ("Request", "Response")
        ]
        kind = self._ws.ServiceSchema(name=type_name, request=halves[0], response=halves[1])

        def handle(request: Any) -> bytes:
            try:
                return answer(bytes(request.payload))
            except Exception as error:
                self.troubles[f"{service}: requests without an answer ({type(error).__name__})"] += 1
                raise

        made = self._ws.Service(name=service, schema=kind, handler=handle)
        self._server.add_services([made])

    def close(self) -> None:
        """See `Transport`."""
        self._server.stop()

    def heard(self, topic: str, encoding: str, type_name: str, data: bytes) -> None:
        """A client published; what is not in CDR, of another type or on no topic of ours is counted and dropped."""
        found = self._receivers.get(topic)
        if found is None:
            self._count(f"{topic!r}: nobody takes messages on this topic{did_you_mean(topic, self._receivers)}")
        elif encoding != "cdr":
            self._count(f"{topic}: messages in {encoding!r}, not in 'cdr'")
        elif ros2_name(type_name) != found[0]:
            self._count(f"{topic}: messages of {type_name!r}, not of {found[0]!r}")
        else:
            found[1](data)

    def _count(self, trouble: str) -> None:
        """Names in it were chosen by a client: they do not fill memory."""
        known = trouble in self.troubles or len(self.troubles) < MOST_TROUBLES
        self.troubles[trouble if known else "further troubles"] += 1

    def readers(self) -> int:
        """See `Stage`."""
        return len(self._listening)

    def settle(self, wait_s: float) -> None:
        """See `Stage`; the library tells nobody who has what, and its queues are short."""
        if self._listening:
            time.sleep(min(wait_s, FLUSH_S))

    def left(self, client_id: int, channel_id: int) -> None:
        """Somebody does not listen any more."""
        self._listening.discard((client_id, channel_id))

    def joined(self, client_id: int, channel_id: int) -> None:
        """Somebody subscribed: what is latched is said again, to all."""
        self._listening.add((client_id, channel_id))
        with self._lock:
            found = self._latched.get(channel_id)
        if found is not None:
            channel, raw, t_ns = found
            channel.log(raw, log_time=t_ns)


def _listener(transport: FoxgloveTransport, ws: Any) -> Any:
    """The library's callbacks, bound to a transport."""

    class Listener(ws.ServerListener):  # type: ignore[misc]
        def __init__(self) -> None:
            self.channels: dict[tuple[int, int], tuple[str, str, str]] = {}

        def on_subscribe(self, client: Any, channel: Any) -> None:
            transport.joined(client.id, channel.id)

        def on_unsubscribe(self, client: Any, channel: Any) -> None:
            transport.left(client.id, channel.id)

        def on_client_advertise(self, client: Any, channel: Any) -> None:
            self.channels[client.id, channel.id] = (channel.topic, channel.encoding, channel.schema_name or "")

        def on_client_unadvertise(self, client: Any, client_channel_id: int) -> None:
            self.channels.pop((client.id, client_channel_id), None)

        def on_message_data(self, client: Any, client_channel_id: int, data: bytes) -> None:
            known = self.channels.get((client.id, client_channel_id))
            if known is None:
                transport.troubles["messages on a channel that was never announced"] += 1
            else:
                transport.heard(*known, bytes(data))

    return Listener()
