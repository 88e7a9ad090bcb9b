"""A DDS participant's entry in ROS 2's graph: its node, and the writers and readers of that node."""

from __future__ import annotations

from pelagos.bridges.transport import Write
from pelagos.messages.store import make, typestore

INFO = "rmw_dds_common/msg/ParticipantEntitiesInfo"


class Graph:
    """The latched message on `ros_discovery_info`, sent again whenever something is added."""

    def __init__(self, participant: bytes, node: str, namespace: str, gid_bytes: int, write: Write) -> None:
        self._participant, self._node, self._namespace = participant, node, namespace
        self._gid_bytes, self._write = gid_bytes, write
        self._readers: list[bytes] = []
        self._writers: list[bytes] = []
        self._send()

    def add_reader(self, guid: bytes) -> None:
        """A reader of the node."""
        self._readers.append(guid)
        self._send()

    def add_writer(self, guid: bytes) -> None:
        """A writer of the node."""
        self._writers.append(guid)
        self._send()

    def _send(self) -> None:
        self._write(self.message(), 0)

    def message(self) -> bytes:
        """CDR bytes; ids have the length that the distribution wants."""
        if self._gid_bytes == 16:
            return self._jazzy()
        return self._padded()

    def _jazzy(self) -> bytes:
        import numpy as np

        def gid(guid: bytes) -> object:
            return make("rmw_dds_common/msg/Gid", data=np.frombuffer(guid, dtype=np.uint8))

        node = make(
            "rmw_dds_common/msg/NodeEntitiesInfo",
            node_namespace=self._namespace,
            node_name=self._node,
            reader_gid_seq=[gid(g) for g in self._readers],
            writer_gid_seq=[gid(g) for g in self._writers],
        )
        message = make(INFO, gid=gid(self._participant), node_entities_info_seq=[node])
        return bytes(typestore().serialize_cdr(message, INFO))

    def _padded(self) -> bytes:
        """The same with ids of 24 bytes, which the store's own types (of Jazzy) do not have."""
        import struct

        def gid(guid: bytes) -> bytes:
            return guid.ljust(self._gid_bytes, b"\0")

        out = bytearray(b"\x00\x01\x00\x00") + gid(self._participant)

        def align() -> None:
            out.extend(b"\0" * (-(len(out) - 4) % 4))

        def text(value: str) -> None:
            align()
            raw = value.encode() + b"\0"
            out.extend(struct.pack("<I", len(raw)) + raw)

        align()
        out.extend(struct.pack("<I", 1))
        text(self._namespace)
        text(self._node)
        for guids in (self._readers, self._writers):
            align()
            out.extend(struct.pack("<I", len(guids)) + b"".join(gid(g) for g in guids))
        return bytes(out)
