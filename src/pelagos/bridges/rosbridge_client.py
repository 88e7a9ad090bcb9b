"""One client of rosbridge: what it subscribed to, and the queues and the thread that send it."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Final

from pelagos.bridges.outbox import Outbox
from pelagos.bridges.transport import Buffer, Write
from pelagos.errors import InputError

MOST_WAITING: Final = 100
"""Messages of one topic that wait for a client; then its oldest is dropped and counted."""
_REPLIES: Final = "answers"


class Client:
    """Speaks with one connection; `offer` never waits.

    Args:
        connection: of `websockets.sync.server`.
        operations: by name ("subscribe"): `(client, message)`; an InputError becomes a status message.
        troubles: counts what is malformed or dropped.
    """

    def __init__(
        self,
        connection: Any,
        operations: Mapping[str, Callable[[Client, Mapping[str, Any]], None]],
        troubles: Counter[str],
    ) -> None:
        self._connection, self._operations, self._troubles = connection, operations, troubles
        self._outbox = Outbox("rosbridge-client", troubles=troubles)
        self._wanted: dict[str, Write] = {}
        self._reply = self._outbox.lane(_REPLIES, lambda text, _: self._connection.send(bytes(text).decode()), 1000)

    def listen(self) -> None:
        """Take what the client says until it leaves, in whatever way."""
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed):
            for text in self._connection:
                self.take(text)

    def take(self, text: str | bytes) -> None:
        """Do what a message says; what cannot be done is answered by a status, and counted."""
        try:
            said = json.loads(text)
            operation = self._operations.get(str(said.get("op"))) if isinstance(said, dict) else None
            if operation is None:
                raise InputError(f"no operation of this server; there are {', '.join(self._operations)}")
            operation(self, said)
        except (ValueError, TypeError, AttributeError, ArithmeticError, RecursionError, InputError) as error:
            self._troubles["malformed packets" if not isinstance(error, InputError) else "requests refused"] += 1
            self.say({"op": "status", "level": "error", "msg": str(error)})

    def want(self, topic: str, form: Callable[[Buffer], Any], said: Mapping[str, Any]) -> None:
        """Send a topic from now on, at most every `throttle_rate` milliseconds, with `queue_length` that wait.

        Raises:
            InputError: an option that this server has not.
        """
        if said.get("compression", "none") != "none" or said.get("fragment_size"):
            raise InputError(f"{topic}: neither compression nor fragments are offered")
        pause_s, depth = 1e-3 * _number(said, "throttle_rate", 0.0), int(_number(said, "queue_length", MOST_WAITING))
        due = 0.0

        def send(cdr: Buffer, t_ns: int) -> None:
            text = json.dumps({"op": "publish", "topic": topic, "msg": form(cdr)}, allow_nan=False)
            self._connection.send(text)

        lane = self._outbox.lane(topic, send, min(max(depth, 1), MOST_WAITING))

        def offer(cdr: Buffer, t_ns: int) -> None:
            nonlocal due
            now = time.monotonic()
            if now >= due:
                due = now + pause_s
                lane(cdr, t_ns)

        self._wanted[topic] = offer

    def leave(self, topic: str) -> None:
        """Send a topic no longer."""
        self._wanted.pop(topic, None)

    def offer(self, topic: str, cdr: Buffer) -> None:
        """A message, for who wants it."""
        write = self._wanted.get(topic)
        if write is not None:
            write(cdr, 0)

    def say(self, message: Mapping[str, Any]) -> None:
        """An answer."""
        self._reply(json.dumps(message, allow_nan=False).encode(), 0)

    def close(self) -> None:
        """Let it go, at once."""
        self._outbox.close(wait_s=0.0)
        self._connection.socket.close()


def _number(said: Mapping[str, Any], key: str, default: float) -> float:
    value = said.get(key) or default
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < float("inf"):
        raise InputError(f"{key}: a number of 0 or more is wanted, not {value!r:.60}")
    return float(value)
