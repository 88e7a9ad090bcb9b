"""Topics and services over rosbridge, for roslibjs, roslibpy and other programs that speak JSON over a WebSocket.

Source: https://github.com/RobotWebTools/rosbridge_suite, ROSBRIDGE_PROTOCOL.md, version 2. Not taken: compression (PNG,
CBOR), fragments and authentication; who asks for them is told so.
"""

from __future__ import annotations

import logging
import threading
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final, Literal
from urllib.parse import urlsplit

from pydantic import Field

from pelagos.bridges.clerk import Clerk
from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed, listening
from pelagos.bridges.extras import require
from pelagos.bridges.rosbridge_client import Client
from pelagos.bridges.transport import Answer, BridgeError, Buffer, Qos, Receive, Write, ros2_name
from pelagos.errors import InputError, LookupFailed
from pelagos.messages.json_form import from_json, to_json
from pelagos.messages.store import deserialize, serialize

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

MOST_TROUBLES: Final = 1000
"""Troubles that are told apart: a web page chooses its own name."""
_BESIDE: Final = ("localhost", "127.0.0.1", "::1")


class RosbridgeConfig(BridgeConfig):
    """rosbridge: topics and services in JSON, for roslibjs and roslibpy."""

    type: Literal["rosbridge"]
    host: str = LOOPBACK
    """Address to listen at; the protocol has no passwords."""
    port: int = Field(default=9090, ge=0, le=65535)
    """TCP port of the WebSocket; 0 takes a free one."""
    origins: tuple[str, ...] = ()
    """Hosts of further web pages that may connect ("lab.example.org"); pages of this machine, and programs, always
    may."""
    topics: tuple[str, ...] = ()
    """Beginnings of the topics that are offered; all where empty."""
    commands: bool = True
    """Obey commands, on the topics of the ROS 2 door."""
    services: bool = True
    """Offer services (pause, reset, step ...)."""

    def listens(self) -> str:
        """See `BridgeConfig`."""
        return listening("tcp", self.host, self.port)

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        from pelagos.bridges.services import serve_topics

        transport = RosbridgeTransport(host=self.host, port=self.port, origins=self.origins)
        serve_topics(exchange, transport, only=self.topics, commands=self.commands, services=self.services)
        note = ", open to the network, without passwords" if exposed(self.host) else ""
        return f"rosbridge at ws://{self.host}:{transport.port}{note}"


class RosbridgeTransport:
    """A WebSocket server; every client has queues and a thread of its own.

    Attributes:
        port: where it listens.
    """

    name = "rosbridge"
    blocks = False

    def __init__(self, *, host: str = LOOPBACK, port: int = 9090, origins: tuple[str, ...] = ()) -> None:
        server = require("websockets.sync.server", extra="rosbridge", purpose="rosbridge")
        self._origins = (*_BESIDE, *origins)
        self._types: dict[str, str] = {}
        self._latched: dict[str, bytes] = {}
        self._receivers: dict[str, tuple[str, Receive]] = {}
        self._services: dict[str, tuple[str, Answer, Clerk]] = {}
        self._clients: tuple[Client, ...] = ()
        self._lock = threading.Lock()
        self.troubles: Counter[str] = Counter()
        quiet = logging.getLogger("pelagos.rosbridge")  # what is no WebSocket is no news to the user
        quiet.disabled = True
        options: dict[str, Any] = {"process_request": self._welcome, "compression": None, "logger": quiet}
        try:
            self._server = server.serve(self._meet, host, port, **options)
        except OSError as error:
            raise BridgeError(f"rosbridge: TCP {host}:{port} cannot be used: {error.strerror}") from None
        self.port: int = self._server.socket.getsockname()[1]
        self._thread = threading.Thread(target=self._server.serve_forever, name="pelagos-rosbridge", daemon=True)
        self._thread.start()

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`; a message becomes JSON in the thread of each client that wants it."""
        self._types[topic] = type_name

        def write(cdr: Buffer, t_ns: int) -> None:
            if qos.latched:
                self._latched[topic] = bytes(cdr)
            for client in self._clients:
                client.offer(topic, cdr)

        return write

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        self._receivers[topic] = (type_name, receive)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        self._services[service] = (type_name, answer, Clerk(service, self.troubles))

    def close(self) -> None:
        """See `Transport`."""
        self._server.shutdown()
        for client in self._clients:
            client.close()
        for _, _, clerk in self._services.values():
            clerk.close()
        self._thread.join(timeout=2.0)

    def _welcome(self, connection: Any, request: Any) -> Any:
        """Refuse web pages of other machines: any page could command through a browser on this one."""
        origin = request.headers.get("Origin")
        if origin is None or urlsplit(origin).hostname in self._origins:
            return None
        foreign = f"web pages of {urlsplit(origin).hostname} refused"
        known = foreign in self.troubles or len(self.troubles) < MOST_TROUBLES
        self.troubles[foreign if known else "further web pages refused"] += 1
        return connection.respond(403, f"{origin} is not among `origins`\n")

    def _meet(self, connection: Any) -> None:
        """Serve one client until it leaves; in a thread of its own."""
        client = Client(connection, self._operations(), self.troubles)
        with self._lock:
            self._clients = (*self._clients, client)
        try:
            client.listen()
        finally:
            with self._lock:
                self._clients = tuple(other for other in self._clients if other is not client)
            client.close()

    def _operations(self) -> Mapping[str, Callable[[Client, Mapping[str, Any]], None]]:
        return {
            "subscribe": self._subscribe, "unsubscribe": _unsubscribe, "publish": self._publish,
            "call_service": self._call, "advertise": self._advertise, "unadvertise": _nothing,
        }  # fmt: skip

    def _subscribe(self, client: Client, said: Mapping[str, Any]) -> None:
        """As in ROS, a topic may be asked for before it is there; one that a run lacks is told."""
        topic = _name(said, "topic")
        _check_type(topic, said, self._types.get(topic))
        client.want(topic, lambda cdr: to_json(deserialize(self._types[topic], bytes(cdr))), said)
        if self._types and topic not in self._types:
            client.say({"op": "status", "level": "warning", "msg": str(LookupFailed("topic", topic, self._types))})
        if topic in self._latched:
            client.offer(topic, self._latched[topic])

    def _advertise(self, client: Client, said: Mapping[str, Any]) -> None:
        topic = _name(said, "topic")
        if topic not in self._receivers:
            raise LookupFailed("topic for commands", topic, self._receivers)
        _check_type(topic, said, self._receivers[topic][0])

    def _publish(self, client: Client, said: Mapping[str, Any]) -> None:
        self._advertise(client, said)
        kind, receive = self._receivers[_name(said, "topic")]
        receive(serialize(kind, from_json(kind, said.get("msg", {}))))

    def _call(self, client: Client, said: Mapping[str, Any]) -> None:
        service = _name(said, "service")
        about: dict[str, Any] = {
            "op": "service_response",
            "service": service,
            **({"id": said["id"]} if "id" in said else {}),
        }
        if service in _ROSAPI:
            client.say({**about, "values": _ROSAPI[service](self, said.get("args") or {}), "result": True})
            return
        if service not in self._services:
            refusal = str(LookupFailed("service", service, self._services))
            client.say({**about, "values": refusal, "result": False})
            return
        kind, answer, clerk = self._services[service]
        try:
            request = serialize(f"{kind}_Request", from_json(f"{kind}_Request", said.get("args") or {}))
        except (InputError, ValueError, ArithmeticError) as error:  # who calls waits for an answer, not for a status
            self.troubles["requests refused"] += 1
            client.say({**about, "values": str(error), "result": False})
            return

        def respond() -> None:
            found = to_json(deserialize(f"{kind}_Response", answer(request)))
            client.say({**about, "values": found, "result": True})

        clerk.ask(respond)

    def _topics(self) -> dict[str, str]:
        return self._types | {topic: kind for topic, (kind, _) in self._receivers.items()}

    def _told_topics(self, args: Mapping[str, Any]) -> dict[str, Any]:
        found = self._topics()
        return {"topics": list(found), "types": list(found.values())}


_ROSAPI: Final[Mapping[str, Callable[[RosbridgeTransport, Mapping[str, Any]], dict[str, Any]]]] = {
    "/rosapi/topics": RosbridgeTransport._told_topics,
    "/rosapi/topic_type": lambda door, args: {"type": door._topics().get(str(args.get("topic")), "")},
    "/rosapi/services": lambda door, args: {"services": list(door._services)},
    "/rosapi/service_type": lambda door, args: {"type": door._services.get(str(args.get("service")), ("",))[0]},
}
"""Questions about what there is, as ROS's own node `rosapi` answers them."""


def _name(said: Mapping[str, Any], key: str) -> str:
    name = said.get(key)
    if not isinstance(name, str) or not name:
        raise InputError(f"{said.get('op')}: a {key}, such as '/name', is wanted, not {name!r:.60}")
    return name if name.startswith("/") else f"/{name}"


def _check_type(topic: str, said: Mapping[str, Any], kind: str | None) -> None:
    """Refuse a message type that is not the topic's; it may be left out.

    Raises:
        InputError: names both.
    """
    given = said.get("type")
    if kind is not None and given and ros2_name(str(given)) != kind:
        raise InputError(f"{topic} has messages of {kind}, not of {given!r:.60}")


def _unsubscribe(client: Client, said: Mapping[str, Any]) -> None:
    client.leave(_name(said, "topic"))


def _nothing(client: Client, said: Mapping[str, Any]) -> None:
    """Nothing is kept of who advertised."""
