"""The view's server: one page, its data from memory, and a WebSocket, behind one guard on one port.

It runs in a thread of its own with its own event loop; nothing that a browser does reaches the thread that steps.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
import threading
from collections.abc import Iterator
from http import HTTPStatus
from importlib.resources import files
from importlib.util import find_spec
from pathlib import PurePosixPath
from typing import Any, Final
from urllib.parse import urlsplit

from pelagos.errors import InputError
from pelagos.viewer.guard import EVERYWHERE, Guard
from pelagos.viewer.hub import Hub

LIVE: Final = "/live"
LOADING: Final = "loading"
"""Key of the message that a page shows until the first "hello"."""
PORT: Final = 8080
_TYPES: Final = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
_PAGE: Final = {"/": "index.html"} | {
    f"/{name}": name for name in ("app.js", "plots.js", "map.js", "drive.js", "stage.js", "style.css")
}
_ANCESTORS: Final = "frame-ancestors 'self' http://localhost:* http://127.0.0.1:*"
_POLICY: Final = (
    "default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:; style-src 'self' 'unsafe-inline'; "
    f"base-uri 'none'; form-action 'none'; {_ANCESTORS}"
)
_MOST: Final = 65536  # of a message from a browser [B]
_SILENT_S: Final = 90.0  # that a browser may be busy drawing before it counts as gone
_GOODBYE_S: Final = 0.5  # that a browser has to answer when the view ends; one that is busy drawing does not


class Server:
    """Serves the page; see the module's docstring.

    Attributes:
        hub: the browsers that look on.
        port: that it listens at.

    Args:
        host: the address to listen at.
        port: None: 8080, or a free one where that is taken; 0: a free one.

    Raises:
        InputError: the port is taken, or the address is not one of this machine.
    """

    def __init__(self, *, host: str = "127.0.0.1", port: int | None = None) -> None:
        self.guard = Guard(host)
        self.hub = Hub()
        self._pictures: dict[str, tuple[str, bytes]] = {}
        self.port = _free(host, port)
        if find_spec("websockets") is None:
            raise InputError("the view needs the package websockets: pip install 'pelagos[viewer]'")
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end: asyncio.Event | None = None
        self._failed: OSError | None = None
        ready = threading.Event()
        self._thread = threading.Thread(target=self._serve, args=(ready,), name="pelagos view server", daemon=True)
        self._thread.start()
        ready.wait()
        if self._failed is not None:
            raise InputError(f"port {self.port} of {host} cannot be listened at: {self._failed.strerror}")

    @property
    def url(self) -> str:
        """Address of the page, with the token."""
        name = "127.0.0.1" if self.guard.host == "localhost" else self.guard.host
        if name in EVERYWHERE:
            name = _own_address(name)
        return f"http://{_bracketed(name)}:{self.port}/?token={self.guard.token}"

    def say_loading(self, what: str) -> None:
        """Have a page that is open before there is anything to see say what it waits for."""
        self.hub.publish(LOADING, {"type": "loading", "text": what})

    def offer(self, name: str, media_type: str, data: bytes) -> None:
        """Serve bytes from memory at "/data/NAME"."""
        self._pictures[f"/data/{name}"] = media_type, data

    def close(self) -> None:
        """Stop serving."""
        if self._loop is not None and self._end is not None:
            with contextlib.suppress(RuntimeError):  # it has ended
                self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(timeout=5.0)

    def _serve(self, ready: threading.Event) -> None:
        asyncio.run(self._listen(ready))

    async def _listen(self, ready: threading.Event) -> None:
        from websockets.asyncio.server import serve

        logging.getLogger("websockets.server").setLevel(logging.CRITICAL)  # a refused handshake is no news
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        try:
            async with serve(
                self.hub.serve, self.guard.host or None, self.port, process_request=self._answer, compression=None,
                max_size=_MOST, origins=None, server_header=None, close_timeout=_GOODBYE_S,
                ping_timeout=_SILENT_S,
            ):  # fmt: skip
                ready.set()
                await self._end.wait()
        except OSError as error:
            self._failed = error
            ready.set()

    def _answer(self, connection: Any, request: Any) -> Any:
        """Response to a request; None lets a WebSocket in."""
        verdict = self.guard.judge(request.path, request.headers, port=self.port)
        path = urlsplit(request.path).path
        if getattr(request, "method", "GET") != "GET":  # websockets before 16 refuses these itself
            return _response(HTTPStatus.METHOD_NOT_ALLOWED, "text/plain", b"405: GET is all\n", {"Allow": "GET"})
        if verdict.answer == "refuse":
            return _response(HTTPStatus.FORBIDDEN, "text/plain", f"403: {verdict.reason}\n".encode())
        if verdict.answer == "enter":
            more = {"Set-Cookie": self.guard.cookie(self.port), "Location": path}
            return _response(HTTPStatus.SEE_OTHER, "text/plain", b"", more)
        upgrade = request.headers.get("Upgrade", "").lower() == "websocket"
        if upgrade and path == LIVE:
            return None
        if path in _PAGE and not upgrade:
            name = _PAGE[path]
            data = files("pelagos.viewer").joinpath("page", name).read_bytes()
            more = {"Content-Security-Policy": _POLICY}
            return _response(HTTPStatus.OK, _TYPES[PurePosixPath(name).suffix], data, more)
        if path in self._pictures and not upgrade:
            return _response(HTTPStatus.OK, *self._pictures[path])
        return _response(HTTPStatus.NOT_FOUND, "text/plain", b"404: there is no such page\n")


def _response(status: HTTPStatus, media_type: str, data: bytes, more: dict[str, str] | None = None) -> Any:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    kind = media_type if media_type.startswith("image/") else f"{media_type}; charset=utf-8"
    headers = Headers({
        "Content-Type": kind, "Content-Length": str(len(data)), "Cache-Control": "no-store",
        "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer", **(more or {}),
    })  # fmt: skip
    return Response(status.value, status.phrase, headers, data)


def _own_address(everywhere: str) -> str:
    """The address of this machine by which its network knows it; no packet is sent to find it."""
    family, other = (socket.AF_INET6, "2001:db8::1") if everywhere == "::" else (socket.AF_INET, "192.0.2.1")
    with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect((other, 9))  # a place of documentation (RFC 5737, RFC 3849): only the route is looked up
        return str(probe.getsockname()[0])
    return "::1" if everywhere == "::" else "127.0.0.1"


def _free(host: str, port: int | None) -> int:
    """A port that can be listened at."""
    for asked in [PORT, 0] if port is None else [port]:
        with _listening(host, asked) as found:
            if found is not None:
                return found
    raise InputError(f"port {port} is taken: give --port another number, or 0 for any that is free")


@contextlib.contextmanager
def _listening(host: str, port: int) -> Iterator[int | None]:
    if not 0 <= port < 65536:
        raise InputError(f"a port is a number from 0 to 65535, not {port}")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
            probe.listen()
        except socket.gaierror:
            raise InputError(f"--host {host}: this is no address of this machine") from None
        except OSError as error:
            if error.errno == 99:  # cannot assign requested address
                raise InputError(f"--host {host}: this is no address of this machine") from None
            yield None
            return
        yield int(probe.getsockname()[1])


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
