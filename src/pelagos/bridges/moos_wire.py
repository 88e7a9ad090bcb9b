"""MOOS's packets, as pure functions.

Source: core-moos, MOOSMsg.cpp and MOOSCommPkt.cpp: little-endian; a packet is its length, the number of messages and a
byte for compression; a text is its length and its bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

HELLO = b"ELKS CAN'T DANCE 2/8/10".ljust(32, b"\0")
NOTIFY, REGISTER, DATA, NULL, WELCOME, POISON = "N", "R", "i", ".", "W", "K"
LONGEST = 1 << 24


@dataclass(frozen=True)
class MoosMessage:
    """One message; `value` where it is a number ("D"), `text` where it is a text ("S")."""

    kind: str
    key: str = ""
    value: float = 0.0
    text: str = ""
    source: str = ""
    time_s: float = 0.0
    number: int = 0
    is_text: bool = False


def pack(messages: Sequence[MoosMessage]) -> bytes:
    """A packet."""
    body = b"".join(_message(m) for m in messages)
    return struct.pack("<iiB", 9 + len(body), len(messages), 0) + body


def unpack(packet: bytes) -> list[MoosMessage]:
    """The messages of a packet.

    Raises:
        ValueError: it is none.
    """
    try:
        length, count, compressed = struct.unpack_from("<iiB", packet)
        if length != len(packet) or compressed or not 0 <= count <= len(packet):
            raise ValueError("not a whole packet of plain messages")
        found, at = [], 9
        for _ in range(count):
            size = struct.unpack_from("<i", packet, at)[0]
            if not 14 <= size <= len(packet) - at:
                raise ValueError("a message reaches beyond its packet")
            found.append(_parsed(packet[at : at + size]))
            at += size
    except (struct.error, UnicodeDecodeError) as error:
        raise ValueError(str(error)) from None
    return found


def _message(m: MoosMessage) -> bytes:
    body = struct.pack("<icc", m.number, m.kind.encode(), b"S" if m.is_text else b"D")
    body += b"".join(_text(t) for t in (m.source, "", "", m.key))
    body += struct.pack("<3d", m.time_s, m.value, -1.0) + _text(m.text)
    return struct.pack("<i", 4 + len(body)) + body


def _text(text: str) -> bytes:
    raw = text.encode("latin-1", "replace")
    return struct.pack("<i", len(raw)) + raw


def _parsed(raw: bytes) -> MoosMessage:
    number, kind, data = struct.unpack_from("<icc", raw, 4)
    at, texts = 10, []
    for place in range(5):
        if place == 4:
            time_s, value, _ = struct.unpack_from("<3d", raw, at)
            at += 24
        size = struct.unpack_from("<i", raw, at)[0]
        if not 0 <= size <= len(raw) - at - 4:
            raise ValueError("a text reaches beyond its message")
        texts.append(raw[at + 4 : at + 4 + size].decode("latin-1"))
        at += 4 + size
    return MoosMessage(kind.decode("latin-1"), texts[3], value, texts[4], texts[0], time_s, number, data == b"S")
