"""`Transport`: what carries messages, as bytes in CDR; it never sees a message object.

A fake in memory stands beside it for tests.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Protocol, TypeAlias

from pelagos.errors import InputError, LookupFailed, PelagosError

Buffer: TypeAlias = bytes | bytearray | memoryview
Write: TypeAlias = Callable[[Buffer, int], None]
"""`(cdr, t_ns)`: send one message."""
Receive: TypeAlias = Callable[[bytes], None]
"""`(cdr)`: called in the transport's own thread."""
Answer: TypeAlias = Callable[[bytes], bytes]
"""Request in CDR to response in CDR; called in the transport's own thread."""


def ros2_name(name: str) -> str:
    """A type's name as ROS 2 has it: "geometry_msgs/Twist", as web programs say, is "geometry_msgs/msg/Twist"."""
    package, _, short = name.partition("/")
    return f"{package}/msg/{short}" if short and "/" not in short else name


class BridgeError(PelagosError):
    """A door cannot be opened."""


class BridgeMismatch(BridgeError, InputError):
    """A door's configuration does not fit the scenario: `pelagos check` finds it too."""


class Unsupported(BridgeError):
    """A transport cannot do what it was asked."""


@dataclass(frozen=True)
class Qos:
    """Quality of service of one topic; history is always "keep last".

    Attributes:
        depth: how many messages are kept for a reader that lags.
        reliable: whether lost ones are sent again.
        latched: whether late joiners get the last `depth` messages.
        large: messages may have megabytes; a transport that would lose those of a burst holds them back while its
            readers take the last ones.
    """

    depth: int = 10
    reliable: bool = True
    latched: bool = False
    large: bool = False


ONLY_HERE: Final = "this machine only"
STREAM: Final = Qos(depth=10)
LATCHED: Final = Qos(depth=1, latched=True)
CLOCK: Final = Qos(depth=1)
COMMAND: Final = Qos(depth=10, reliable=False)
"""A best-effort reader matches every writer."""


class Transport(Protocol):
    """One way to other programs.

    Attributes:
        name: for messages to the user.
        blocks: whether a write may wait for a peer, so that it needs a thread of its own.
        troubles: what the transport itself dropped or refused, counted, by reason.
    """

    name: str
    blocks: bool
    troubles: Counter[str]

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """Announce a topic ("/auv0/imu/data_raw") of a type ("sensor_msgs/msg/Imu")."""
        ...

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """Have `receive` called with every message on a topic."""
        ...

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """Answer a service ("/reset") of a type ("std_srvs/srv/Trigger").

        Raises:
            Unsupported: the transport has no services.
        """
        ...

    def close(self) -> None:
        """Leave; nothing is called or sent any more."""
        ...


class Stage(Transport, Protocol):
    """A transport that a recording can be played to: it knows who listens.

    Attributes:
        reach: who can reach it, in words.
    """

    reach: str

    def readers(self) -> int:
        """Number of readers that the topics have, or of topics that are read; 0: nobody listens."""
        ...

    def settle(self, wait_s: float) -> None:
        """Wait until readers have what was sent, for at most so long."""
        ...


class MemoryTransport:
    """A transport that keeps what was written, and lets a test speak."""

    name = "memory"
    blocks = False
    reach = "this process"

    def __init__(self) -> None:
        self.written: dict[str, list[tuple[int, bytes]]] = {}
        self.types: dict[str, str] = {}
        self.order: list[tuple[int, str]] = []
        self.closed = False
        self.troubles: Counter[str] = Counter()
        self.listening = 0
        self._receivers: dict[str, Receive] = {}
        self._services: dict[str, Answer] = {}

    def readers(self) -> int:
        """See `Stage`; what a test sets."""
        return self.listening

    def settle(self, wait_s: float) -> None:
        """See `Stage`; nothing is on its way."""

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`."""
        kept = self.written.setdefault(topic, [])
        self.types[topic] = type_name

        def write(cdr: Buffer, t_ns: int) -> None:
            kept.append((t_ns, bytes(cdr)))
            self.order.append((t_ns, topic))

        return write

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        self.types[topic] = type_name
        self._receivers[topic] = receive

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        self.types[service] = type_name
        self._services[service] = answer

    def close(self) -> None:
        """See `Transport`."""
        self.closed = True

    def say(self, topic: str, cdr: bytes) -> None:
        """Send a message as a peer would."""
        _known(topic, self._receivers)(cdr)

    def call(self, service: str, cdr: bytes) -> bytes:
        """Call a service as a peer would."""
        answer: Answer = _known(service, self._services)
        return answer(cdr)


def _known(name: str, table: dict[str, Any]) -> Any:
    if name not in table:
        raise LookupFailed("topic or service", name, table)
    return table[name]
