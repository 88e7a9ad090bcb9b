"""Ports on which instruments speak: a serial port (pty), a TCP server, UDP. None of them ever waits for a peer."""

from __future__ import annotations

import os
import socket
import tty
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Final, Protocol

from pelagos.bridges.config import LOOPBACK, exposed
from pelagos.bridges.transport import BridgeError, BridgeMismatch
from pelagos.errors import did_you_mean

HIGHEST_PORT: Final = 65535


class Port(Protocol):
    """One way to a driver.

    Attributes:
        where: what the user connects to.
        troubles: lost bytes and the like, counted.
    """

    where: str
    troubles: Counter[str]

    def write(self, raw: bytes) -> None:
        """Send to everybody who listens; what cannot be taken at once is dropped whole."""
        ...

    def read(self) -> list[tuple[object, bytes]]:
        """Datagrams that came, with their senders."""
        ...

    def reply(self, peer: object, raw: bytes) -> None:
        """Answer one of them."""
        ...

    def close(self) -> None:
        """Leave."""
        ...


def open_port(text: str) -> Port:
    """ "pty:/tmp/gps", "tcp:16171", "tcp:HOST:PORT", "udp:14551" (send there), "udp-server:9092" (answer who asks).

    Raises:
        BridgeMismatch: it is none of these.
        BridgeError: it cannot be used.
    """
    kind, host, number = parsed_port(text)
    kinds: dict[str, Callable[[tuple[str, int]], Port]] = {
        "tcp": TcpPort, "udp": UdpPort, "udp-server": UdpServerPort,
    }  # fmt: skip
    try:
        return PtyPort(host) if kind == "pty" else kinds[kind]((host, number))
    except OSError as error:
        raise BridgeError(f"port {text!r} cannot be used: {error.strerror or error}") from None


def parsed_port(text: str) -> tuple[str, str, int]:
    """Kind, host (of a pty its path) and number of a port.

    Raises:
        BridgeMismatch: it is no port.
    """
    kind, _, rest = text.partition(":")
    if kind == "pty":
        return kind, rest, 0
    if kind not in ("tcp", "udp", "udp-server"):
        near = did_you_mean(kind, ("pty", "tcp", "udp", "udp-server"))
        raise BridgeMismatch(
            f"port {text!r}{near}: use pty:PATH, tcp:[HOST:]PORT, udp:[HOST:]PORT or udp-server:[HOST:]PORT"
        )
    host, _, number = rest.rpartition(":")
    if not (number.isascii() and number.isdigit() and int(number) <= HIGHEST_PORT):
        raise BridgeMismatch(f"port {text!r}: give a number up to {HIGHEST_PORT}, such as {kind}:16171")
    return kind, host or LOOPBACK, int(number)


class PtyPort:
    """A serial port: a pseudo-terminal, under a name of its own where one is given."""

    def __init__(self, link: str = "") -> None:
        self._ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self._ours, False)
        self._theirs = theirs  # held open: without, a driver that hangs up would end the port
        self.where = os.ttyname(theirs)
        self._link = Path(link) if link else None
        if self._link is not None:
            if self._link.is_symlink():
                self._link.unlink()
            self._link.symlink_to(self.where)
            self.where = str(self._link)
        self._rest = b""
        self.troubles: Counter[str] = Counter()

    def write(self, raw: bytes) -> None:
        """See `Port`: a driver that does not read fills the line, and later messages are lost."""
        if not self._sent(self._rest) or not self._sent(raw):
            self.troubles["messages that nobody read in time"] += 1

    def _sent(self, raw: bytes) -> bool:
        """Write; of a message that has begun the rest goes first, next time."""
        try:
            sent = os.write(self._ours, raw) if raw else 0
        except (BlockingIOError, OSError):
            return False
        self._rest = raw[sent:]
        return True

    def read(self) -> list[tuple[object, bytes]]:
        """See `Port`."""
        try:
            raw = os.read(self._ours, 65536)
        except (BlockingIOError, OSError):
            return []
        return [(None, raw)] if raw else []

    def reply(self, peer: object, raw: bytes) -> None:
        """See `Port`."""
        self.write(raw)

    def close(self) -> None:
        """See `Port`."""
        if self._link is not None and self._link.is_symlink() and os.readlink(self._link) == os.ttyname(self._theirs):
            self._link.unlink()  # not another run's, which has taken the name
        os.close(self._ours)
        os.close(self._theirs)


class TcpPort:
    """A server for any number of drivers."""

    def __init__(self, address: tuple[str, int]) -> None:
        self._server = socket.create_server(address)
        self._server.setblocking(False)
        host, port = self._server.getsockname()[:2]
        self.where = f"tcp {host}:{port}" + _warned(host)
        self.port = int(port)
        self._peers: list[socket.socket] = []
        self.troubles: Counter[str] = Counter()

    def write(self, raw: bytes) -> None:
        """See `Port`."""
        self._accept()
        for peer in list(self._peers):
            self.reply(peer, raw)

    def read(self) -> list[tuple[object, bytes]]:
        """See `Port`."""
        self._accept()
        found: list[tuple[object, bytes]] = []
        for peer in list(self._peers):
            try:
                raw = peer.recv(65536)
            except BlockingIOError:
                continue
            except OSError:
                raw = b""
            if raw:
                found.append((peer, raw))
            else:
                self._drop(peer)
        return found

    def reply(self, peer: object, raw: bytes) -> None:
        """See `Port`: a driver that took half of a message would be out of step, and is hung up on."""
        assert isinstance(peer, socket.socket)
        try:
            sent = peer.send(raw)
        except BlockingIOError:
            self.troubles["messages that nobody read in time"] += 1
            return
        except OSError:
            self._drop(peer)
            return
        if sent < len(raw):
            self.troubles["drivers that were hung up on, for they did not read"] += 1
            self._drop(peer)

    def close(self) -> None:
        """See `Port`."""
        for peer in self._peers:
            peer.close()
        self._server.close()

    def _accept(self) -> None:
        while True:
            try:
                peer, _ = self._server.accept()
            except OSError:
                return
            peer.setblocking(False)
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._peers.append(peer)

    def _drop(self, peer: socket.socket) -> None:
        if peer in self._peers:
            self._peers.remove(peer)
        peer.close()


class UdpPort:
    """Datagrams to one address."""

    def __init__(self, address: tuple[str, int]) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)  # chart plotters listen to x.x.x.255
        self._address = address
        over = ", over the network, without passwords" if exposed(address[0]) else ""
        self.where = f"udp to {address[0]}:{address[1]}{over}"
        self.troubles: Counter[str] = Counter()

    def write(self, raw: bytes) -> None:
        """See `Port`."""
        self.reply(self._address, raw)

    def read(self) -> list[tuple[object, bytes]]:
        """See `Port`."""
        found: list[tuple[object, bytes]] = []
        while len(found) < 100:
            try:
                raw, peer = self._socket.recvfrom(65536)
            except OSError:
                break
            found.append((peer, raw))
        return found

    def reply(self, peer: object, raw: bytes) -> None:
        """See `Port`."""
        assert isinstance(peer, tuple)
        try:
            self._socket.sendto(raw, peer)
        except OSError:
            self.troubles["messages that nobody took"] += 1

    def close(self) -> None:
        """See `Port`."""
        self._socket.close()


class UdpServerPort(UdpPort):
    """Datagrams to whoever asked last."""

    def __init__(self, address: tuple[str, int]) -> None:
        super().__init__(address)
        self._socket.bind(address)
        self.port = int(self._socket.getsockname()[1])
        self.where = f"udp {address[0]}:{self.port}" + _warned(address[0])
        self._asked: object = None

    def read(self) -> list[tuple[object, bytes]]:
        """See `Port`."""
        found = super().read()
        if found:
            self._asked = found[-1][0]
        return found

    def write(self, raw: bytes) -> None:
        """See `Port`."""
        if self._asked is not None:
            self.reply(self._asked, raw)


def _warned(host: str) -> str:
    return ", open to the network, without passwords" if exposed(host) else ""
