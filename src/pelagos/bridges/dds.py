"""ROS 2 topics and services over DDS, by `cyclonedds`, with no ROS installed.

Names on the wire: `rt/` before topics, `rq/...Request` and `rr/...Reply` for services, types `pkg::msg::dds_::T_`;
see https://design.ros2.org/articles/topic_and_service_names.html. Samples are handed over as the CDR bytes that the
encoder made: no message object is built. A blocking write would hold the interpreter's lock, so every writer keeps the
last messages only ("keep last"), which never waits for a reader.
"""

from __future__ import annotations

import os
import threading
import time
from collections import Counter
from functools import cache, partial
from typing import Any, Final

from pelagos.bridges.clerk import Clerk
from pelagos.bridges.dds_flow import WAITING, Flow, acknowledged
from pelagos.bridges.dds_graph import Graph
from pelagos.bridges.dds_loopback import LOOPBACK, keep_to_loopback
from pelagos.bridges.dds_types import idl_class
from pelagos.bridges.extras import require
from pelagos.bridges.outbox import Outbox
from pelagos.bridges.rihs import type_hash
from pelagos.bridges.transport import ONLY_HERE, Answer, BridgeError, Buffer, Qos, Receive, Write

_FRAME: Final = 16  # bytes of a service's header behind the four of the encapsulation
_HEAD: Final = 4
_TAKE: Final = 64  # samples in one call
_ANY: Final = 0x3 | 0xC | 0x70  # read or not, new or not, alive or not


class DdsTransport:
    """A participant of a DDS domain, seen by ROS 2 as a node.

    Args:
        domain: ROS domain id.
        node: name of the node.
        namespace: of the node.
        loopback: stay on this machine; else the library's or the user's own configuration (CYCLONEDDS_URI).
        announce: tell ROS 2's graph about the node, its publishers and subscriptions.
        gid_bytes: 16, or 24 for Humble.

    Attributes:
        reach: who can reach it, in words.
    """

    name = "DDS"
    blocks = False

    def __init__(
        self,
        *,
        domain: int = 0,
        node: str = "pelagos",
        namespace: str = "/",
        loopback: bool = True,
        announce: bool = True,
        gid_bytes: int = 16,
    ) -> None:
        self._dds = require("cyclonedds", extra="ros2", purpose="the DDS transport")
        self._c = require("cyclonedds._clayer", extra="ros2", purpose="the DDS transport")
        core = require("cyclonedds.core", extra="ros2", purpose="the DDS transport")
        self._core, self._policy = core, core.Policy
        self._pub = require("cyclonedds.pub", extra="ros2", purpose="the DDS transport")
        self._sub = require("cyclonedds.sub", extra="ros2", purpose="the DDS transport")
        self._topic = require("cyclonedds.topic", extra="ros2", purpose="the DDS transport")
        given = "CYCLONEDDS_URI" in os.environ
        _configure(domain, loopback and not given)
        user_data = core.Qos(self._policy.Userdata(b"enclave=/;"))
        participant = require("cyclonedds.domain", extra="ros2", purpose="the DDS transport").DomainParticipant
        try:
            self._participant = participant(domain, qos=user_data)
        except core.DDSException as error:
            raise BridgeError(f"no DDS participant can be made in domain {domain}: {error}") from None
        self.reach = "as CYCLONEDDS_URI says, without passwords" if given else "open to the network, without passwords"
        if loopback and not given:
            self.reach = ONLY_HERE if keep_to_loopback(domain) else f"{ONLY_HERE}, at ports that others can reach"
        self._gid_bytes = gid_bytes
        self._topics: dict[str, Any] = {}
        self._entities: list[Any] = []
        self._said: list[Any] = []  # the writers of topics
        self._readers: list[tuple[Any, Receive]] = []
        self._waits = core.WaitSet(self._participant)
        self._wake = core.GuardCondition(self._participant)
        self._waits.attach(self._wake)
        self._open = True
        self.troubles: Counter[str] = Counter()
        self._graph: Graph | None = None
        self._large: Outbox | None = None
        self._clerks: list[Clerk] = []
        if announce:
            latched = Qos(depth=1, latched=True)
            writer = self._writer("ros_discovery_info", "rmw_dds_common/msg/ParticipantEntitiesInfo", latched)
            self._graph = Graph(self._participant.guid.bytes, node, namespace, gid_bytes, self._sender(writer))
        self._thread = threading.Thread(target=self._receive, name="pelagos-dds", daemon=True)
        self._thread.start()

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`."""
        writer = self._writer(f"rt{topic}", type_name, qos)
        self._said.append(writer)
        if self._graph is not None:
            self._graph.add_writer(writer.guid.bytes)
        send = self._sender(writer)
        if not qos.large:
            return send
        if self._large is None:
            self._large = Outbox("dds-large", troubles=self.troubles)
        return self._large.lane(topic, Flow(writer, send, qos.depth).write, WAITING)

    @property
    def waiting(self) -> int:
        """Large messages that wait until readers have the last ones."""
        return 0 if self._large is None else self._large.waiting

    def readers(self) -> int:
        """See `Stage`."""
        return sum(len(writer.get_matched_subscriptions()) for writer in self._said)

    def settle(self, wait_s: float) -> None:
        """See `Stage`; a stopped reader is waited for once."""
        end = time.monotonic() + wait_s
        for writer in self._said:
            acknowledged(writer, max(round(1e9 * (end - time.monotonic())), 0))

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        self._listen(f"rt{topic}", type_name, receive, qos)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`; clients on rmw_cyclonedds reach it, those on rmw_fastrtps do not."""
        qos = Qos(depth=10)
        writer = self._writer(f"rr{service}Reply", f"{type_name}_Response", qos, framed=True)
        send = self._sender(writer)

        clerk = Clerk(service, self.troubles)
        self._clerks.append(clerk)

        def serve_one(framed: bytes) -> None:
            request = framed[:_HEAD] + framed[_HEAD + _FRAME :]
            response = answer(request)
            send(response[:_HEAD] + framed[_HEAD : _HEAD + _FRAME] + response[_HEAD:], 0)

        def take(framed: bytes) -> None:
            clerk.ask(partial(serve_one, framed))

        if self._graph is not None:
            self._graph.add_writer(writer.guid.bytes)
        self._listen(f"rq{service}Request", f"{type_name}_Request", take, qos, framed=True)

    def close(self) -> None:
        """See `Transport`."""
        if not self._open:
            return
        if self._large is not None:
            self._large.close()
        for clerk in self._clerks:
            clerk.close()
        self._open = False
        self._wake.set(True)
        self._thread.join(timeout=2.0)
        # at once, whoever still holds a write: a participant that lingers stays in every peer's graph
        for entity in (*reversed(self._entities), self._wake, self._waits, *self._topics.values(), self._participant):
            entity.__del__()
        self._readers.clear()

    def _sender(self, writer: Any) -> Write:
        """Writes with the wall clock as the source timestamp, as every node of ROS does: lifespans, deadlines and the
        ages that tools print count from it. Simulation time is in the messages' own stamps."""
        write, ref = self._c.ddspy_write, writer._ref

        def send(cdr: Buffer, t_ns: int) -> None:
            if self._open and write(ref, cdr) < 0:
                self.troubles["messages that the transport refused"] += 1

        return send

    def _writer(self, topic: str, type_name: str, qos: Qos, *, framed: bool = False) -> Any:
        kind = self._kind(topic, type_name, framed)
        writer = self._pub.DataWriter(self._participant, kind, qos=self._qos(qos, type_name))
        self._entities.append(writer)
        return writer

    def _listen(self, topic: str, type_name: str, receive: Receive, qos: Qos, *, framed: bool = False) -> None:
        kind = self._kind(topic, type_name, framed)
        reader = self._sub.DataReader(self._participant, kind, qos=self._qos(qos, type_name))
        condition = self._core.ReadCondition(reader, _ANY)
        self._entities += [reader, condition]
        self._readers = [*self._readers, (reader, receive)]
        self._waits.attach(condition)
        if self._graph is not None:
            self._graph.add_reader(reader.guid.bytes)

    def _kind(self, topic: str, type_name: str, framed: bool) -> Any:
        if topic not in self._topics:
            data_type = idl_class(type_name, gid_bytes=self._gid_bytes, framed=framed)
            self._topics[topic] = self._topic.Topic(self._participant, topic, data_type)
        return self._topics[topic]

    def _qos(self, qos: Qos, type_name: str) -> Any:
        p = self._policy
        reliable = p.Reliability.Reliable(100_000_000) if qos.reliable else p.Reliability.BestEffort
        policies = [
            reliable, p.History.KeepLast(qos.depth),
            p.Durability.TransientLocal if qos.latched else p.Durability.Volatile,
            p.DataRepresentation(use_cdrv0_representation=True),
        ]  # fmt: skip
        if qos.latched:  # else a late joiner would get the newest one only
            policies.append(p.DurabilityService(0, p.History.KeepLast(qos.depth), -1, -1, -1))
        base = type_name.removesuffix("_Request").removesuffix("_Response") if "/srv/" in type_name else type_name
        policies.append(p.Userdata(f"typehash={type_hash(base)};".encode()))
        return self._core.Qos(*policies)

    def _receive(self) -> None:
        """Hand on what arrives; waiting lets other threads run."""
        while self._open:
            self._waits.wait(500_000_000)
            for reader, receive in self._readers:
                samples = self._c.ddspy_take(reader._ref, _ANY, _TAKE)
                if isinstance(samples, int):
                    continue
                for raw, info in samples:
                    if info.valid_data:
                        self._take(receive, bytes(raw))

    def _take(self, receive: Receive, raw: bytes) -> None:
        try:
            receive(raw)
        except Exception as error:  # bytes from a network; the thread serves all topics, and must not end
            self.troubles[f"requests without an answer ({type(error).__name__})"] += 1


@cache
def _configure(domain: int, loopback: bool) -> Any:
    """The domain's network, set before its first participant; kept for as long as the process lives."""
    if not loopback:
        return None
    found = require("cyclonedds.domain", extra="ros2", purpose="the DDS transport")
    core = require("cyclonedds.core", extra="ros2", purpose="the DDS transport")
    try:
        return found.Domain(domain, LOOPBACK)
    except core.DDSException as error:
        raise BridgeError(
            f"DDS domain {domain} is open in this process already, with another network: {error}"
        ) from None
