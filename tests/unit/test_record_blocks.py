"""A recorder's rows: blocks of readings beside one reading after the other, alone and in groups, copy by copy."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from pelagos.errors import LookupFailed, RecordingError
from pelagos.messages.group import GROUP
from pelagos.messages.motion import ODOMETRY
from pelagos.messages.store import deserialize
from pelagos.sensors.sensor import Measurement, Reading
from pelagos.sim import record
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording

COPIES, TICKS = 3, 4
BEAMS = [[0.5, 0.1, -0.8], [0.1, 0.5, -0.8], [-0.5, 0.2, -0.7], [0.1, -0.6, -0.7]]
MEMBERS = [f"auv[{i}]" for i in range(11)]  # names of two lengths


class Memory:
    """Stands in for the file: what it was asked to hold."""

    def __init__(self) -> None:
        self.metadata: dict[str, Any] = {}
        self.attachments: dict[str, bytes] = {}
        self.schemas: list[str] = []
        self.channels: list[tuple[str, str, Mapping[str, str]]] = []
        self.messages: dict[str, list[tuple[int, bytes]]] = {}
        self.flushed: list[int] = []

    def add_metadata(self, name: str, values: Any) -> None:
        self.metadata[name] = values

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        self.attachments[name] = data

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        self.schemas.append(name)
        return len(self.schemas)

    def add_channel(self, topic: str, schema: int, encoding: str, about: Any) -> int:
        self.channels.append((topic, self.schemas[schema - 1], about))
        self.messages[topic] = []
        return len(self.channels)

    def add_message(self, channel: int, t_ns: int, data: Any) -> None:
        self.messages[self.channels[channel - 1][0]].append((t_ns, bytes(data)))

    def add_messages(self, channel: int, t_ns: Any, rows: Any) -> None:
        for t, row in zip(t_ns.tolist(), rows, strict=True):
            self.add_message(channel, t, row)

    def flush(self) -> None:
        self.flushed.append(sum(map(len, self.messages.values())))

    close = flush


def sensor(kind: str, rate_hz: float = 12.5, **other: Any) -> Any:
    return SimpleNamespace(type=kind, rate_hz=rate_hz, position_m=(1.0, 2.0, 3.0), q_body_sensor=(0, 0, 0, 1), **other)


def fleet(*agents: str) -> dict[str, dict[str, Any]]:
    sensors = {"fix": sensor("pose"), "log": sensor("dvl", 0.25, beams=BEAMS, sound_speed_mps=1470.0)}
    return {agent: {**sensors, "heat": sensor("thermometer", 100)} for agent in agents}


def measured(rng: np.random.Generator, name: str) -> Measurement:
    """Of `TICKS` ticks of `COPIES` copies, the last of which hears nothing."""
    m = TICKS * COPIES
    valid = rng.random((TICKS, COPIES)) < 0.6
    valid[:, 2], valid[1, :2] = False, True
    rows = rng.normal(size=(m, {"fix": 7, "log": 3, "heat": 2}[name]))
    extras = {}
    if name == "log":
        extras = {key: rng.normal(size=(m, 4)) for key in ("ranges", "beam_velocity", "sigma")}
        extras |= {"beam_valid": rng.random((m, 4)) < 0.5, "altitude": rng.normal(size=m)}
    return Measurement(rows, rows, None if name == "heat" else valid.ravel(), extras)


def ticks(first: int) -> np.ndarray:
    return (first + np.arange(TICKS)) * 80_000_000


def fill(r: Recorder, *, blocks: bool, sensors: Any, members: bool = False) -> None:
    """The same readings, in blocks or one by one, in two parts; members' at times of their own."""
    for part in range(2):
        for number, agent in enumerate(sensors):
            rng = np.random.default_rng([7, number, part])
            t_ns = ticks(10 * part + (number % 3 if members else 0))
            for name in ("fix", "log", "heat"):
                found = measured(rng, name)
                if blocks:
                    r.write_block(agent, name, t_ns, found, n=COPIES)
                    continue
                valid = np.ones(TICKS * COPIES, bool) if found.valid is None else found.valid
                for k in range(TICKS):
                    lanes = slice(COPIES * k, COPIES * (k + 1))
                    r.write(agent, name, found.reading(lanes, valid[lanes], int(t_ns[k]), ""))
            motion = [rng.normal(size=(TICKS, COPIES, width)) for width in (3, 4, 3, 3)]
            r.write_truth_block(agent, t_ns, *motion)
        r.flush()


@pytest.mark.parametrize("blocks", [True, False])
def test_each_copy_has_its_valid_readings(blocks: bool) -> None:
    held, sensors = Memory(), fleet("boat", "auv")
    with Recorder("a.mcap", "", 3, sensors, None, (1.0, 2.0), 10, copies=COPIES, writer=held) as r:
        fill(r, blocks=blocks, sensors=sensors)
    for number, agent in enumerate(sensors):
        for part in range(2):
            rng = np.random.default_rng([7, number, part])
            found = {name: measured(rng, name) for name in ("fix", "log", "heat")}
            for copy in range(COPIES):
                times = ticks(10 * part).tolist()
                for name, topics in (("fix", ["pose"]), ("log", ["twist", "dvl"]), ("heat", [""])):
                    valid = found[name].valid
                    lanes = np.arange(TICKS) if valid is None else np.flatnonzero(valid.reshape(TICKS, -1)[:, copy])
                    for topic in topics:
                        place = f"/env{copy}/{agent}/{name}" + (f"/{topic}" if topic else "")
                        mine = [m for m in held.messages[place] if (m[0] >= 800_000_000) == part]
                        assert [t for t, _ in mine] == [times[k] for k in lanes]
                        kind = next(kind for t, kind, _ in held.channels if t == place)
                        for k, (_, raw) in zip(lanes, mine, strict=True):
                            told, row = deserialize(kind, raw), k * COPIES + copy
                            seen = found[name].data[row]
                            if name == "fix":
                                p = told.pose.position
                                assert [p.x, p.y, p.z] == [-seen[1], seen[0], seen[2]]
                            elif topic == "dvl":
                                assert (told.altitude, told.velocity.x, told.velocity.y) == (
                                    found[name].extras["altitude"][row], seen[0], -seen[1]
                                )  # fmt: skip
                                assert told.header.frame_id == f"env{copy}/{agent}/log_frd"
                            elif topic == "twist":
                                assert told.twist.twist.linear.z == seen[2]
                            else:
                                assert told.data.tolist() == seen.tolist()


def test_channels_and_frames_are_those_of_each_copy_and_mount() -> None:
    held, sensors = Memory(), fleet("boat", "auv")
    mounts = {
        agent: {name: ((10.0 * i + k, -1.0, 0.5), (0.6, 0.0, 0.8, 0.0)) for k, name in enumerate(fleet("a")["a"])}
        for i, agent in enumerate(sensors)
    }
    for given in (mounts, None):
        held = Memory()
        r = Recorder("a.mcap", "", 3, sensors, given, (1.5, -2.25), 10, copies=2, writer=held)
        ((_, raw),) = held.messages["/tf_static"]
        frames = {
            f.child_frame_id: (f.header.frame_id, f.transform.translation, f.transform.rotation)
            for f in deserialize("tf2_msgs/msg/TFMessage", raw).transforms
        }
        assert len(frames) == 2 * 2 * 4
        for i, agent in enumerate(sensors):
            for copy in range(2):
                for k, name in enumerate(sensors[agent]):
                    parent, at, turn = frames[f"env{copy}/{agent}/{name}"]
                    assert parent == f"env{copy}/{agent}/base_link"
                    assert (at.x, at.y, at.z) == ((1.0, 2.0, 3.0) if given is None else (10.0 * i + k, -1.0, 0.5))
                    assert (turn.w, turn.y, turn.z) == ((0, 0, 1) if given is None else (0.6, 0.8, 0))
                parent, at, turn = frames[f"env{copy}/{agent}/log_frd"]
                assert (parent, at.x, turn.x) == (f"env{copy}/{agent}/log", 0.0, 1.0)
        about = {topic: said for topic, _, said in held.channels}
        assert about["/env1/boat/log/dvl"] == {"agent": "boat", "sensor": "log", "type": "dvl", "rate_hz": "0.25"}
        assert about["/env0/auv/fix/pose"]["rate_hz"] == "12.5"
        assert (about["/env1/auv/truth"], about["/tf"]) == ({"agent": "auv"}, {})
        assert [r.number(topic) for topic, *_ in held.channels] == list(range(1, len(held.channels) + 1))
        assert r.number("/env2/auv/truth") is None
        assert r.latched == {"/tf_static"}
        told = held.metadata["pelagos"]
        assert (told["latitude_deg"], told["longitude_deg"], told["copies"]) == ("1.5", "-2.25", "2")


def test_chunks_end_every_half_second_of_either_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = SimpleNamespace(now=50.0)
    monkeypatch.setattr(record.time, "monotonic", lambda: wall.now)
    held = Memory()
    r = Recorder("a.mcap", "", 3, {"boat": {}}, None, (1.0, 2.0), 10, writer=held)
    row = [np.ones((1, width)) for width in (3, 4, 3, 3)]
    ended = []
    for t_ms, now in (
        (0, 50),
        (499, 50.1),
        (500, 50.2),
        (900, 50.6),
        (990, 50.75),
        (1000, 50.8),
        (1489, 51),
        (1490, 51),
    ):
        before, wall.now = len(held.flushed), now
        r.write_truth("boat", t_ms * 1_000_000, *row)
        ended += [t_ms] * (len(held.flushed) - before)
    assert ended == [500, 990, 1490]  # the second by the wall clock alone


def everything(recording: Recording) -> dict[str, list[tuple[int, bytes]]]:
    return {topic: [(m.t_ns, m.raw) for m in recording.messages(topic)] for topic in recording.channels}


def test_members_recorded_together_are_as_those_recorded_alone(tmp_path: Path) -> None:
    """Eleven whose readings come at other times, one that senses otherwise, and the plans of all."""
    sensors = {**fleet("boat"), **fleet(*MEMBERS)}
    sensors["auv[4]"]["fix"] = sensor("depth", noise_density=0.1, bias_std_m=0.2)  # the topic of others, another type
    sensors["auv[6]"]["heat"] = sensor("pose")  # and a topic that no other has
    paths, halves = [], []
    for together in ((), ("auv",)):
        paths.append(tmp_path / f"{len(together)}.mcap")
        with Recorder(paths[-1], "", 3, sensors, None, (1.0, 2.0), 10, copies=2, together=together) as r:
            for i, agent in enumerate(MEMBERS):
                r.add_plan(agent, np.array([[0.0, i, -1.0], [5.0, -2.0 * i, -3.0]]))
            r.begin()
            for part in range(2):
                for i, agent in enumerate(sensors):
                    rng = np.random.default_rng([i, part])
                    t_ns = ticks(10 * part + i % 3)
                    valid = rng.random(8) < 0.6
                    rows, extras = rng.normal(size=(8, 7)), {k: rng.normal(size=(8, 4)) for k in ("ranges", "sigma")}
                    extras |= {"beam_velocity": rng.normal(size=(8, 4)), "beam_valid": rng.random((8, 4)) < 0.5}
                    log = Measurement(rows[:, :3], rows, valid, extras | {"altitude": rows[:, 5]})
                    fix = Measurement(rows[:, 0] if agent == "auv[4]" else rows, rows)
                    r.write_block(agent, "log", t_ns, log, n=2)
                    if i % 2:
                        r.write_block(agent, "fix", t_ns, fix, n=2)
                        continue
                    for k, t in enumerate(t_ns.tolist()):  # one by one
                        two = fix.data[2 * k : 2 * k + 2]
                        r.write(agent, "fix", Reading(two, two, t, "", np.array([True, k > 1]), {}))
                if part == 0:
                    r.flush()
                    name = "/env1/auv_7/log/dvl"
                    halves.append([(m.t_ns, m.raw) for m in Recording(paths[-1]).messages(name)])
    assert halves[0] == halves[1]
    assert 0 < len(halves[1]) <= TICKS
    apart, joined = map(Recording, paths)
    expected = everything(apart)
    assert everything(joined) == expected
    assert list(joined.channels.items()) == list(apart.channels.items())
    assert {t: joined.count(t) for t in joined.channels} == {t: len(m) for t, m in expected.items()}
    assert joined.topics(type=ODOMETRY) == apart.topics(type=ODOMETRY) == []
    kinds = {c.type for c in apart.channels.values() if apart.count(c.topic)}
    assert len(kinds) == 6
    for kind in kinds:
        assert joined.topics(type=kind) == [t for t in expected if apart.channels[t].type == kind and expected[t]]
    topics = ("fix/pose", "heat/pose", "log/dvl", "log/twist", "plan", "truth")
    assert sorted(joined.groups) == [f"/env{i}/auv/{topic}" for i in range(2) for topic in topics]
    assert apart.groups == {}
    table = joined.together("/env1/auv/log/dvl")
    assert table.members == tuple(MEMBERS)
    assert joined.topics("_7/truth") == []
    assert joined.topics("_7/log/dvl") == ["/env0/auv_7/log/dvl", name]
    assert table.t_s.tolist() == sorted({t * 1e-9 for part in range(2) for i in range(3) for t in ticks(10 * part + i)})
    for i in range(11):
        t_s, values = apart.table(f"/env1/auv_{i}/log/dvl", [f"{f}:float64" for f in ("velocity.x", "altitude")])
        assert table.t_s[table.valid[:, i]].tolist() == t_s.tolist()
        columns = [table.fields.index("velocity.x"), table.fields.index("altitude")]
        assert table.values[table.valid[:, i], i][:, columns].tolist() == values.tolist()
    assert joined.together("/env0/auv/fix/pose").members == tuple(m for m in MEMBERS if m != "auv[4]")
    with pytest.raises(RecordingError, match=r"/env0/auv/plan holds messages of type nav_msgs/msg/Path, one a member"):
        joined.together("/env0/auv/plan")
    with pytest.raises(LookupFailed, match="did you mean '/env0/auv/fix/pose'"):
        joined.together("/env0/auv/fix/poze")
    one = Recording(paths[1], topics=[name])
    assert everything(one) == {topic: expected[topic] if topic == name else [] for topic in expected}
    with paths[1].open("rb") as file:
        ((_, _, message),) = itertools.islice(make_reader(file).iter_messages(["/env0/auv/log/dvl"]), 1)
    assert deserialize(GROUP, message.data).header.frame_id == "env0/auv/log"
    assert [joined.of_first(t) for t in (name, "/env0/auv_7/truth", "/tf", "/env")] == [False, True, True, False]


def test_topics_of_a_single_copy_are_all_of_the_first(tmp_path: Path) -> None:
    """Whatever agents are called."""
    with Recorder(tmp_path / "a.mcap", "", 3, {"env3": {}, "env": {}}, None, (1.0, 2.0), 10):
        pass
    found = Recording(tmp_path / "a.mcap")
    assert {"/env3/truth", "/env/truth"} <= set(found.channels)
    assert all(map(found.of_first, found.channels))
