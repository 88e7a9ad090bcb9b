"""The browsers that look on: each gets the newest of everything as fast as it takes it; what comes late is dropped."""

from __future__ import annotations

import asyncio
import json
import logging
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

_MOST: Final = 65536  # of a message from a browser [B]
_BUNDLE: Final = 262_144  # after so many bytes a message to a browser is sent, whatever else waits [B]
_HEAD: Final = 8  # bytes of a record before its header
_LOG = logging.getLogger(__name__)


class _Browser:
    """One connection: messages that wait, by key."""

    def __init__(self) -> None:
        self.waiting: dict[str, bytes] = {}
        self.some = asyncio.Event()

    def put(self, key: str, data: bytes) -> None:
        """Have a message sent; an older one of the same key that still waits is dropped."""
        self.waiting[key] = data
        self.some.set()


class Hub:
    """Sends to all browsers, and hands on what they say.

    Attributes:
        heard: called with every message of a browser, in the server's thread; must not block.
        sent, dropped: messages so far.
    """

    def __init__(self) -> None:
        self.heard: Callable[[Mapping[str, Any]], None] = lambda message: None
        self.sent = self.dropped = 0
        self._kept: dict[str, bytes] = {}
        self._browsers: set[_Browser] = set()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._number = 0
        self._outgoing: deque[tuple[str, bytes]] = deque()
        self._held = False

    @property
    def count(self) -> int:
        """Number of browsers that look on."""
        return len(self._browsers)

    def publish(self, key: str, header: Mapping[str, Any], blob: bytes = b"", *, keep: bool = True) -> None:
        """Send a message to all; any thread may call this.

        Args:
            key: what it is: the newest message of a key replaces those before it.
            header: JSON types.
            blob: the bytes of a picture.
            keep: late comers get it too.
        """
        data = packed({"key": key, **header}, blob)
        if keep:
            self._kept[key] = data
        if self._browsers:
            self._outgoing.append((key, data))
            if not self._held:
                self._wake()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Hand what is published within to the server at once: to wake its thread costs more than a small message."""
        self._held = True
        try:
            yield
        finally:
            self._held = False
            self._wake()

    def say(self, text: str, *, kind: str = "note") -> None:
        """A line for the user: kind "note" or "error"."""
        self._number += 1
        self.publish(f"say{self._number}", {"type": "say", "text": text, "kind": kind}, keep=False)

    def forget(self, prefix: str, *, whole: bool = False) -> None:
        """Keep no longer what begins so; `whole`: what is this, or a part of it by its path."""
        for key in [k for k in self._kept if k.startswith(prefix)]:
            if not whole or key == prefix or key[len(prefix)] == "/":
                del self._kept[key]

    async def serve(self, connection: Any) -> None:
        """Talk to one browser until it goes."""
        self._loop = asyncio.get_running_loop()
        browser = _Browser()
        for key, data in list(self._kept.items()):
            browser.put(key, data)
        self._browsers.add(browser)
        sender = asyncio.create_task(self._send(connection, browser))
        try:
            async for message in connection:
                self._take(message)
        except Exception as error:  # a browser that vanishes changes nothing
            _LOG.debug("a browser went: %s", error)
        finally:
            self._browsers.discard(browser)
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)

    def _take(self, message: str | bytes) -> None:
        if isinstance(message, bytes) or len(message) > _MOST:
            return
        try:
            found = json.loads(message)
        except ValueError:
            return
        if isinstance(found, dict) and isinstance(found.get("do"), str):
            self.heard(found)

    def _wake(self) -> None:
        loop = self._loop
        if loop is not None and self._outgoing:
            try:
                loop.call_soon_threadsafe(self._spread)
            except RuntimeError:  # the server has ended
                self._loop = None

    def _spread(self) -> None:
        while self._outgoing:
            key, data = self._outgoing.popleft()
            for browser in self._browsers:
                self.dropped += key in browser.waiting
                browser.put(key, data)

    async def _send(self, connection: Any, browser: _Browser) -> None:
        while True:
            await browser.some.wait()
            browser.some.clear()
            while browser.waiting:
                bundle, size = [], 0
                while browser.waiting and size < _BUNDLE:
                    bundle.append(browser.waiting.pop(next(iter(browser.waiting))))
                    size += len(bundle[-1])
                await connection.send(b"".join(bundle))
                self.sent += len(bundle)


def packed(header: Mapping[str, Any], blob: bytes = b"") -> bytes:
    """One record: lengths of header and blob (4 bytes each, little-endian), header as JSON, blob, in whole words."""
    text = json.dumps(header, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    lengths = len(text).to_bytes(4, "little") + len(blob).to_bytes(4, "little")
    return lengths + text + blob + b"\0" * (-len(blob) % 4)


def records(message: bytes) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Headers and blobs of a message to a browser."""
    at = 0
    while at < len(message):
        header, blob = (int.from_bytes(message[i : i + 4], "little") for i in (at, at + 4))
        begin = at + _HEAD + header
        yield json.loads(message[at + _HEAD : begin]), message[begin : begin + blob]
        at = begin + blob + -blob % 4
