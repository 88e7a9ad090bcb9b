"""Recordings: every reading and the true motion of a run as one MCAP file of ROS 2 messages.

Log time is simulation time. The file carries the resolved scenario, the seed and the versions that it takes to repeat
the run. A chunk ends at least every half second of simulated and of wall time, so that a killed run keeps all but that.
"""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.config.swarm import topic_name
from pelagos.messages.encoders import encoder
from pelagos.messages.encoding import Encoding, Site
from pelagos.messages.motion import (
    ODOMETRY,
    PATH,
    TF,
    WORLD_FRAME,
    TruthEncoder,
    path_message,
    static_message,
    static_transform,
)
from pelagos.messages.store import Message, schema
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Measurement, Reading, SensorConfig
from pelagos.sim.mcap_writer import McapWriter
from pelagos.sim.record_frames import Frames
from pelagos.sim.record_together import Lane, Together

CHUNK_NS: Final = 500_000_000  # [ns] of simulated time in one chunk
CHUNK_WALL_S: Final = 0.5
SCENARIO: Final = "scenario.yaml"
LEGEND: Final = "labels.json"
STATIC: Final = "/tf_static"
LATCHED_KEY: Final = "offered_qos_profiles"  # of a channel's metadata, as rosbag2 has it
PACKAGES: Final = ("pelagos", "mitsuba", "drjit", "numpy", "gsw", "pillow")

Pose: TypeAlias = tuple[Sequence[float], Sequence[float]]
Motion: TypeAlias = Sequence[NDArray[np.float64]]


@dataclass(frozen=True)
class _Track:
    """One sensor of one copy of an agent: its encoding, and of each topic the channel, or its place in its group's."""

    encoding: Encoding
    channels: list[int | Lane]


class Recorder:
    """Writes a recording; use it as a context manager.

    Attributes:
        path: the file.
        latched: topics that were said once, at the beginning.

    Args:
        path: the file; its folder exists.
        scenario_yaml: the resolved scenario.
        seed: the run's seed.
        sensors: configuration by agent and sensor name.
        mounts: (position [m], quaternion wxyz) in the body frame by agent and sensor; from the configurations if None.
        origin: latitude and longitude of the world's origin [deg].
        dt_ns: the tick [ns].
        copies: how many copies of the fleet are recorded. One copy has topics "/auv0/imu", more have "/env0/auv0/imu".
        legend: what labels, instances and materials are called: data for the attachment "labels.json".
        together: groups of agents whose members share a channel for each topic.
        writer: stands in for the file, with the methods of `McapWriter`.

    Raises:
        RecordingError: the file cannot be written (also from every method).
    """

    def __init__(
        self,
        path: str | Path,
        scenario_yaml: str,
        seed: int,
        sensors: Mapping[str, Mapping[str, SensorConfig]],
        mounts: Mapping[str, Mapping[str, Pose]] | None,
        origin: tuple[float, float],
        dt_ns: int,
        *,
        copies: int = 1,
        legend: Mapping[str, Any] | None = None,
        together: Collection[str] = (),
        writer: Any = None,
    ) -> None:
        self.path = Path(path)
        self._writer = writer or McapWriter(self.path, library=f"pelagos {installed('pelagos')}")
        self._writer.add_metadata("pelagos", _metadata(seed, dt_ns, origin, copies))
        self._writer.add_attachment(SCENARIO, "application/yaml", scenario_yaml.encode())
        if legend is not None:
            self.attach(LEGEND, json.dumps(legend).encode())
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._copies = copies
        self._tracks: dict[tuple[str, str], list[_Track]] = {}
        self._truth: dict[str, list[tuple[TruthEncoder, int | Lane]]] = {}
        self._navigation: dict[str, list[tuple[TruthEncoder, int | Lane]]] = {}
        self._movers: dict[str, tuple[TruthEncoder, int]] = {}
        self.latched: set[str] = set()
        self._together, self._order = Together(together), list[str]()
        self._tf, self._frames = self.channel("/tf", TF, {}), Frames()
        self._chunk_ns, self._chunk_wall = 0, time.monotonic()
        self._transforms: list[Message] = []
        for agent, configs in sensors.items():
            poses: Mapping[str, Pose] = {name: (c.position_m, c.q_body_sensor) for name, c in configs.items()}
            self._add_agent(agent, configs, poses if mounts is None else mounts[agent], origin)
        self.latch(STATIC, TF, [static_message(self._transforms)], {})
        self._writer.flush()

    def write(self, agent: str, sensor: str, reading: Reading) -> None:
        """Record one reading: the copies of it that are valid."""
        for copy, track in enumerate(self._tracks[agent, sensor]):
            if reading.valid[copy]:
                self._encode(track, reading, copy)
        self._end_chunk(reading.t_ns)

    def write_block(
        self, agent: str, sensor: str, t_ns: NDArray[np.int64], measurement: Measurement, *, n: int
    ) -> None:
        """Record a sensor's readings at k times [ns] in one go: a measurement of k times `n` lanes.

        The messages are those of `write`, time by time; a sensor whose messages are numbers takes a tenth of its time.
        """
        k = len(t_ns)
        valid = np.ones((k, n), bool) if measurement.valid is None else measurement.valid.reshape(k, n)
        for copy, track in enumerate(self._tracks[agent, sensor]):
            if not track.encoding.tables:
                self._one_by_one(track, t_ns, measurement, valid[:, copy], copy, n)
                continue
            lanes = np.flatnonzero(valid[:, copy])
            if not len(lanes):
                continue
            times, rows = t_ns[lanes], lanes * n + copy
            extras = {name: values[rows] for name, values in measurement.extras.items()}
            for channel, table in zip(track.channels, track.encoding.tables, strict=True):
                self._add_rows(channel, times, table.template, table.values(measurement.data[rows], extras))
        self._end_chunk(int(t_ns[-1]))

    def _one_by_one(
        self, track: _Track, t_ns: NDArray[np.int64], measurement: Measurement, valid: NDArray[np.bool_], copy: int,
        n: int,
    ) -> None:  # fmt: skip
        for k in np.flatnonzero(valid).tolist():
            self._encode(track, measurement.reading(slice(k * n, (k + 1) * n), valid, int(t_ns[k]), ""), copy)

    def _encode(self, track: _Track, reading: Reading, copy: int) -> None:
        """Record one copy of a reading."""
        found = track.encoding.encode(reading, copy)
        for channel, template, data in zip(track.channels, track.encoding.templates, found, strict=True):
            if data is not None:
                self._add(channel, reading.t_ns, template, data)

    def _add(self, channel: int | Lane, t_ns: int, template: Template | None, data: Buffer) -> None:
        """Record a message on its channel, or keep its numbers for its group's."""
        if isinstance(channel, int):
            self._writer.add_message(channel, t_ns, data)
        else:
            assert template is not None, "only topics whose messages are numbers are recorded together"
            numbers = template.numbers(np.frombuffer(data, dtype=np.uint8)[None])
            channel.keep(np.array([t_ns]), numbers[:, len(STAMP) :])

    def _add_rows(
        self, channel: int | Lane, t_ns: NDArray[np.int64], template: Template, numbers: NDArray[np.float64]
    ) -> None:
        """Record messages of numbers on their channel, or keep them for that of their group."""
        if isinstance(channel, int):
            self._writer.add_messages(channel, t_ns, template.rows(t_ns, numbers))
        else:
            channel.keep(t_ns, numbers)

    def write_truth(self, agent: str, t_ns: int, *motion: NDArray[np.float64]) -> None:
        """Record the true motion.

        Args:
            agent: its name.
            t_ns: time [ns].
            *motion: position `(n, 3)` NWU [m], attitude `(n, 4)` wxyz, velocity `(n, 3)` FLU [m/s], angular velocity
                `(n, 3)` FLU [rad/s].
        """
        self._write_frames()
        for i, (encode, channel) in enumerate(self._truth[agent]):
            odometry, transform = encode.encode(t_ns, *(values[i] for values in motion))
            self._add(channel, t_ns, encode.odometry, odometry)
            self._writer.add_message(self._tf, t_ns, transform)
        self._end_chunk(t_ns)

    def write_truth_block(self, agent: str, t_ns: NDArray[np.int64], *motion: NDArray[np.float64]) -> None:
        """Record the true motion at k times [ns]: arrays of `write_truth` with a leading axis k."""
        for i, (encode, channel) in enumerate(self._truth[agent]):
            numbers = encode.numbers(*(values[:, i] for values in motion))
            self._add_rows(channel, t_ns, encode.odometry, numbers)
            self._frames.keep(t_ns, encode.transforms(t_ns, numbers))
        self._end_chunk(int(t_ns[-1]))

    def add_navigation(self, agent: str, kind: str) -> None:
        """Declare what an agent's navigation knows: topic "/AGENT/navigation" beside "/AGENT/truth"."""
        self._navigation[agent] = self._motion(agent, "navigation", {"agent": agent, "kind": kind})

    def add_plan(self, agent: str, corners: NDArray[np.float64]) -> None:
        """Say once which way an agent's mission means to go: corners `(k, 3)` NWU [m], topic "/AGENT/plan"."""
        message, about = path_message(corners), {"agent": agent}
        for place in self.places(agent):
            topic = f"/{place}/plan"
            if self._together.single(topic, PATH, about, message):
                self._order.append(topic)
            else:
                self.latch(topic, PATH, [message], about)

    def begin(self) -> None:
        """Declare what groups have together, once all agents, plans and movers are declared."""
        self._together.open(self, self._order)

    def gather(self) -> None:
        """Write what was kept for topics that agents share, whose messages of the same times are all there."""
        self._write_frames()
        for channel, t_ns, rows in self._together.gathered():
            self.write_rows(channel, t_ns, rows)

    def _write_frames(self) -> None:
        for t_ns, rows in self._frames.ordered():
            self.write_rows(self._tf, t_ns, rows)

    def write_rows(self, channel: int, t_ns: NDArray[np.int64], rows: NDArray[np.uint8]) -> None:
        """Record k messages of one size `(k, size)` on a channel, at times `(k,)` [ns]."""
        self._writer.add_messages(channel, t_ns, rows)
        self._end_chunk(int(t_ns[-1]))

    def write_navigation_block(self, agent: str, t_ns: NDArray[np.int64], *motion: NDArray[np.float64]) -> None:
        """Record solutions of navigation at k times [ns], arrays as of `write_truth_block`; no transforms."""
        self.write_odometry(self._navigation[agent], t_ns, motion)

    def write_odometry(
        self, copies: Sequence[tuple[TruthEncoder, int | Lane]], t_ns: NDArray[np.int64], motion: Motion
    ) -> None:
        """Record the motion of something in each copy at k times [ns], arrays as of `write_truth_block`."""
        for i, (encode, channel) in enumerate(copies):
            self._add_rows(channel, t_ns, encode.odometry, encode.numbers(*(values[:, i] for values in motion)))
        self._end_chunk(int(t_ns[-1]))

    def add_mover(self, name: str, about: Mapping[str, str]) -> None:
        """Declare a body on a scripted path, the same in every copy: topic "/movers/NAME/odometry"."""
        frame = f"movers/{name}"
        self._movers[name] = TruthEncoder(frame), self.channel(f"/{frame}/odometry", ODOMETRY, about)

    @property
    def movers(self) -> Collection[str]:
        """Those that were declared."""
        return self._movers

    def write_mover_block(self, name: str, t_ns: NDArray[np.int64], *motion: NDArray[np.float64]) -> None:
        """Record the motion of a mover at k times [ns]: arrays of `write_truth` with k in place of n."""
        encode, channel = self._movers[name]
        numbers = encode.numbers(*motion)
        self._add_rows(channel, t_ns, encode.odometry, numbers)
        self._frames.keep(t_ns, encode.transforms(t_ns, numbers))
        self._end_chunk(int(t_ns[-1]))

    def number(self, topic: str) -> int | None:
        """The number of a topic's channel, None where nothing writes it."""
        return self._channels.get(topic)

    def copy(self, channel: int, t_ns: int, data: bytes) -> None:
        """Record a message as another recording has it."""
        self._writer.add_message(channel, t_ns, data)
        self._end_chunk(t_ns)

    def flush(self) -> None:
        """Hand everything recorded until now to the operating system."""
        self.gather()
        self._writer.flush()

    def sync(self) -> None:
        """Have everything recorded until now on the disk."""
        self.gather()
        self._writer.sync()

    def rename(self, path: Path) -> None:
        """Give the file another name, in place of the file that has it."""
        self._writer.rename(path)
        self.path = path

    def close(self) -> None:
        """Finish the file with the index that lets readers seek."""
        self.gather()
        self._writer.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def places(self, agent: str) -> list[str]:
        """Beginning of an agent's topics and frames in each copy."""
        name = topic_name(agent)
        return [name] if self._copies == 1 else [f"env{i}/{name}" for i in range(self._copies)]

    def _add_agent(
        self, agent: str, configs: Mapping[str, SensorConfig], poses: Mapping[str, Pose], origin: tuple[float, float]
    ) -> None:
        places = self.places(agent)
        for name, config in configs.items():
            about = {"agent": agent, "sensor": name, "type": config.type, "rate_hz": f"{config.rate_hz:g}"}
            tracks = self._tracks[agent, name] = []
            for place in places:
                frame = f"{place}/{name}"
                encoding = encoder(config, Site(frame, *origin))
                position, attitude = poses[name]
                self._transforms += [
                    static_transform(f"{place}/base_link", frame, position=position, attitude=attitude),
                    *(static_transform(frame, frame + f.suffix, attitude=f.attitude) for f in encoding.frames),
                ]
                channels = [
                    self._lane(
                        "/" + "/".join(filter(None, (place, name, topic.suffix))), topic.type, about, frame, made
                    )
                    for topic, made in zip(encoding.topics, encoding.templates, strict=True)
                ]
                tracks.append(_Track(encoding, channels))
        self._truth[agent] = self._motion(agent, "truth", {"agent": agent})

    def _motion(self, agent: str, topic: str, about: Mapping[str, str]) -> list[tuple[TruthEncoder, int | Lane]]:
        """A topic of an agent's motion, true or estimated, of each copy."""
        found = []
        for place in self.places(agent):
            encode = TruthEncoder(f"{place}/base_link")
            found.append((encode, self._lane(f"/{place}/{topic}", ODOMETRY, about, WORLD_FRAME, encode.odometry)))
        return found

    def _lane(
        self, topic: str, type_name: str, about: Mapping[str, str], frame: str, template: Template | None
    ) -> int | Lane:
        """A channel of its own, or a place in that of the agent's group."""
        lane = None if template is None else self._together.lane(topic, frame, about, template)
        if lane is None:
            return self.channel(topic, type_name, about)
        self._order.append(topic)
        return lane

    def channel(self, topic: str, type_name: str, about: Mapping[str, str]) -> int:
        """Declare a topic and its type; the number is that of its channel."""
        if type_name not in self._schemas:
            self._schemas[type_name] = self._writer.add_schema(type_name, "ros2msg", schema(type_name))
        self._order.append(topic)
        self._channels[topic] = self._writer.add_channel(topic, self._schemas[type_name], "cdr", about)
        return self._channels[topic]

    def latch(self, topic: str, type_name: str, messages: Sequence[bytes], about: Mapping[str, str]) -> None:
        """Declare a topic that says its messages once, at the beginning."""
        channel = self.channel(topic, type_name, {**about, LATCHED_KEY: _LATCHED})
        for data in messages:
            self._writer.add_message(channel, 0, data)
        self.latched.add(topic)

    def attach(self, name: str, data: bytes) -> None:
        """Write a file of JSON within the recording."""
        self._writer.add_attachment(name, "application/json", data)

    def _end_chunk(self, t_ns: int) -> None:
        if t_ns - self._chunk_ns >= CHUNK_NS or time.monotonic() - self._chunk_wall >= CHUNK_WALL_S:
            self._writer.flush()
            self._chunk_ns, self._chunk_wall = t_ns, time.monotonic()


_LATCHED: Final = (
    "- history: keep_last\n  depth: 1\n  reliability: reliable\n  durability: transient_local\n"
    "  deadline: {sec: 0, nsec: 0}\n  lifespan: {sec: 0, nsec: 0}\n  liveliness: system_default\n"
    "  liveliness_lease_duration: {sec: 0, nsec: 0}\n  avoid_ros_namespace_conventions: false\n"
)


def installed(package: str) -> str:
    """The version of an installed package, "unknown" where there is none."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def _metadata(seed: int, dt_ns: int, origin: tuple[float, float], copies: int) -> dict[str, str]:
    found = {name: installed(name) for name in PACKAGES}
    return {
        "seed": str(seed), "dt_ns": str(dt_ns), "copies": str(copies), "latitude_deg": repr(float(origin[0])),
        "longitude_deg": repr(float(origin[1])), "python": platform.python_version(), "machine": platform.machine(),
        **{f"{name}_version": value for name, value in found.items()},
    }  # fmt: skip
