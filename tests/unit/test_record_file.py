"""Recordings as files: what others' decoders read, killed processes, full disks, repeated bytes, recovery."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pelagos.errors import LookupFailed, RecordingError
from pelagos.messages.motion import ODOMETRY, ODOMETRY_FIELDS, TruthEncoder
from pelagos.sensors.sensor import Reading, SensorConfig
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording, recover

DT_NS = 1_000_000


def recorder(path: Path, copies: int = 1) -> Recorder:
    config = SensorConfig(type="thermometer", rate_hz=100, position_m=(1.0, 0.5, 0.0), orientation_deg=(0, 90, 0))
    return Recorder(path, "name: test\n", 7, {"auv0": {"heat": config}}, None, (45.0, 12.5), DT_NS, copies=copies)


def write(r: Recorder, ticks: range, copies: int = 1) -> None:
    for tick in ticks:
        t_ns = tick * DT_NS
        values = np.full((copies, 2), float(tick)) + np.arange(copies)[:, None]
        r.write("auv0", "heat", Reading(values, values, t_ns, "auv0/heat", np.ones(copies, bool), {}))
        one = np.ones((copies, 1))
        r.write_truth(
            "auv0", t_ns, one * [[tick, 2, -3]], one * [[1, 0, 0, 0]], one * [[1.5, 0, 0]], one * [[0, 0, 0.1]]
        )


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "run.mcap"
    with recorder(path) as r:
        write(r, range(2000))
    return path


def test_mcap_ros2_support_decodes_every_message(recording: Path) -> None:
    with recording.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        found: dict[str, list[tuple[int, object]]] = {}
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
        assert reader.get_header().profile == "ros2"
    assert {topic: len(rows) for topic, rows in found.items()} == {
        "/auv0/heat": 2000, "/auv0/truth": 2000, "/tf": 2000, "/tf_static": 1,
    }  # fmt: skip
    t_ns, odometry = found["/auv0/truth"][1500]
    assert t_ns == 1500 * DT_NS
    assert (odometry.header.stamp.sec, odometry.header.stamp.nanosec) == (1, 500_000_000)
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("map", "auv0/base_link")
    p, q = odometry.pose.pose.position, odometry.pose.pose.orientation
    assert (p.x, p.y, p.z) == (-2.0, 1500.0, -3.0)  # NWU (1500, 2, -3) is ENU (-2, 1500, -3)
    assert (q.x, q.y) == (0.0, 0.0)
    assert q.z == pytest.approx(np.sqrt(0.5)) == q.w  # heading north is yaw 90 degrees in ENU
    static = found["/tf_static"][0][1].transforms
    assert [(t.header.frame_id, t.child_frame_id) for t in static] == [("auv0/base_link", "auv0/heat")]
    assert static[0].transform.translation.x == 1.0


def test_rosbags_decodes_with_the_schema_in_the_file_alone(recording: Path) -> None:
    with recording.open("rb") as file:
        reader = make_reader(file)
        rows = list(reader.iter_messages(topics=["/auv0/heat"]))
    schema = rows[0][0]
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    values = [store.deserialize_cdr(message.data, schema.name).data for _, _, message in rows]
    np.testing.assert_array_equal(np.stack(values), np.repeat(np.arange(2000.0)[:, None], 2, axis=1))


def test_rosbags_opens_the_file_as_it_stands(recording: Path) -> None:
    with AnyReader([recording]) as reader:
        assert set(reader.topics) == {"/auv0/heat", "/auv0/truth", "/tf", "/tf_static"}
        truth = [c for c in reader.connections if c.topic == "/auv0/truth"]
        rows = [(t, reader.deserialize(raw, c.msgtype)) for c, t, raw in reader.messages(truth)]
    assert [t for t, _ in rows] == [k * DT_NS for k in range(2000)]
    assert rows[7][1].pose.pose.position.y == 7.0


def test_the_file_says_how_it_was_made(recording: Path) -> None:
    found = Recording(recording)
    assert found.complete
    assert found.attachments["scenario.yaml"] == b"name: test\n"
    assert (found.metadata["seed"], found.metadata["dt_ns"], found.metadata["latitude_deg"]) == ("7", "1000000", "45.0")
    assert {"pelagos_version", "drjit_version", "python"} <= set(found.metadata)
    assert found.channels["/auv0/heat"].about == {
        "agent": "auv0", "sensor": "heat", "type": "thermometer", "rate_hz": "100",
    }  # fmt: skip


def test_tables_equal_the_messages(recording: Path) -> None:
    found = Recording(recording)
    t, table = found.table("/auv0/truth", ODOMETRY_FIELDS)
    np.testing.assert_allclose(t, np.arange(2000) * 1e-3, rtol=0, atol=1e-12)
    for k in (0, 1, 999, 1999):
        m = found.message("/auv0/truth", k).message
        p, q, v = m.pose.pose.position, m.pose.pose.orientation, m.twist.twist
        expected = [
            m.header.stamp.sec, m.header.stamp.nanosec, p.x, p.y, p.z, q.x, q.y, q.z, q.w,
            v.linear.x, v.linear.y, v.linear.z, v.angular.x, v.angular.y, v.angular.z,
        ]  # fmt: skip
        np.testing.assert_array_equal(table[k], expected)
    with pytest.raises(LookupFailed, match="did you mean '/auv0/truth'"):
        found.table("/auv0/trutz", ODOMETRY_FIELDS)


def test_large_messages_are_read_from_the_file(tmp_path: Path) -> None:
    path = tmp_path / "large.mcap"
    with recorder(path) as r:
        for k in range(5):
            data = np.full((1, 40, 100), float(k))  # 32 kB a message, kept in the file
            r.write("auv0", "heat", Reading(data, data, k * 300_000_000, "auv0/heat", np.ones(1, bool), {}))
    found = Recording(path)
    assert [m.message.data.reshape(40, 100)[3, 4] for m in found.messages("/auv0/heat")] == [0, 1, 2, 3, 4]


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    here, there = tmp_path / "here.mcap", tmp_path / "there.mcap"
    with recorder(here) as r:
        write(r, range(600))
    code = f"""
import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from test_record_file import recorder, write
with recorder(Path({str(there)!r})) as r: write(r, range(600))
"""
    subprocess.run([sys.executable, "-c", code], check=True)
    found, wanted = ([(m.topic, m.t_ns, m.raw) for m in Recording(path).messages()] for path in (there, here))
    assert found == wanted


def test_copies_have_topics_of_their_own(tmp_path: Path) -> None:
    with recorder(tmp_path / "fleet.mcap", copies=2) as r:
        write(r, range(3), copies=2)
    found = Recording(tmp_path / "fleet.mcap")
    assert found.topics() == [
        "/tf",
        "/env0/auv0/heat",
        "/env1/auv0/heat",
        "/env0/auv0/truth",
        "/env1/auv0/truth",
        "/tf_static",
    ]
    assert found.message("/env1/auv0/heat", 2).message.data.tolist() == [3.0, 3.0]
    assert found.message("/env1/auv0/truth", 0).message.child_frame_id == "env1/auv0/base_link"


def test_copies_move_each_for_itself(tmp_path: Path) -> None:
    """True motion and navigation of each copy, one by one and in blocks, and where each copy's prop is."""
    rng = np.random.default_rng(3)
    sensors: dict[str, dict[str, SensorConfig]] = {"auv0": {}, "usv": {}}
    motion = {
        name: [rng.normal(size=(4, 3, width)) for width in (3, 4, 3, 3)] for name in ("auv0", "usv", "knows", "crate")
    }
    for parts in motion.values():
        parts[1] /= np.linalg.norm(parts[1], axis=-1, keepdims=True)
    t_ns = np.arange(4) * 50_000_000
    path = tmp_path / "fleet.mcap"
    with Recorder(path, "", 1, sensors, None, (45.0, 12.5), 50_000_000, copies=3) as r:
        r.add_navigation("auv0", "ekf")
        props = [
            (TruthEncoder(f), r.channel(f"/{f}/odometry", ODOMETRY, {})) for f in (f"env{i}/crate" for i in range(3))
        ]
        for name in sensors:
            r.write_truth_block(name, t_ns[:3], *(part[:3] for part in motion[name]))
            r.write_truth(name, int(t_ns[3]), *(part[3] for part in motion[name]))
        r.write_navigation_block("auv0", t_ns, *motion["knows"])
        r.write_odometry(props, t_ns, motion["crate"])
    found = Recording(path)
    topics = {"auv0": "auv0/truth", "usv": "usv/truth", "knows": "auv0/navigation", "crate": "crate/odometry"}
    for name, topic in topics.items():
        for i in range(3):
            numbers = found.table(f"/env{i}/{topic}", ODOMETRY_FIELDS)[1][:, 2:]
            np.testing.assert_array_equal(numbers, TruthEncoder.numbers(*(part[:, i] for part in motion[name])))
    seen = {(m.transforms[0].child_frame_id, k): m.transforms[0].transform.translation
            for k, m in ((r.t_ns, r.message) for r in found.messages("/tf"))}  # fmt: skip
    for name in sensors:
        for i in range(3):
            for k in range(4):
                moved = seen[f"env{i}/{name}/base_link", int(t_ns[k])]
                assert [moved.y, -moved.x, moved.z] == motion[name][0][k, i].tolist()


def test_a_copy_without_a_reading_says_nothing(tmp_path: Path) -> None:
    with recorder(tmp_path / "fleet.mcap", copies=2) as r:
        data = np.zeros((2, 1))
        r.write("auv0", "heat", Reading(data, data, 0, "auv0/heat", np.array([True, False]), {}))
    found = Recording(tmp_path / "fleet.mcap")
    assert (found.count("/env0/auv0/heat"), found.count("/env1/auv0/heat")) == (1, 0)


KILLED = """
import sys, time; sys.path.insert(0, {folder!r})
from pathlib import Path
from test_record_file import recorder, write
r = recorder(Path({path!r}))
start = time.monotonic()
tick = 0
while True:
    now = int((time.monotonic() - start) * 1000)
    write(r, range(tick, now))
    tick = max(tick, now)
    print(tick, flush=True)
    time.sleep(0.001)
"""


def test_a_killed_run_loses_less_than_a_second(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    code = KILLED.format(folder=str(Path(__file__).parent), path=str(path))
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        ticks = 0
        while ticks < 1800:
            ticks = int(child.stdout.readline())
        os.kill(child.pid, signal.SIGKILL)
        ticks = max([ticks, *(int(line) for line in child.stdout.read().split("\n")[:-1])])
    cut = Recording(path)
    assert not cut.complete
    count = cut.count("/auv0/truth")
    assert count > ticks - 1000
    before = [(m.topic, m.t_ns, m.raw) for m in cut.messages()]
    with path.open("rb") as file:  # others' sequential readers read it as it is
        try:
            others = sum(1 for _ in NonSeekingReader(file).iter_messages(topics="/auv0/truth", log_time_order=False))
        except McapError:
            others = -1
    assert others in (count, -1)
    raw = path.read_bytes()
    found = recover(path)
    assert (found.path.name, found.messages, found.damage) == ("killed.recovered.mcap", len(before), [])
    assert path.read_bytes() == raw
    whole = Recording(found.path)
    assert whole.complete
    assert [(m.topic, m.t_ns, m.raw) for m in whole.messages()] == before
    assert whole.metadata == cut.metadata
    assert whole.attachments == cut.attachments
    with found.path.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(before)


@pytest.mark.parametrize("cut", [9, 60, 400, 5000, 20_011, 40_000])
def test_any_cut_can_be_read_and_recovered(recording: Path, cut: int) -> None:
    whole = recording.read_bytes()
    recording.write_bytes(whole[:cut])
    complete = [(m.topic, m.t_ns, m.raw) for m in Recording(recording).messages()]
    new = recover(recording).path
    assert recording.read_bytes() == whole[:cut]
    assert [(m.topic, m.t_ns, m.raw) for m in Recording(new).messages()] == complete
    assert Recording(new).complete


def test_recovering_a_whole_recording_changes_nothing(recording: Path) -> None:
    before = recording.read_bytes()
    found = recover(recording)
    assert (found.whole, found.path, found.messages) == (True, recording, 6001)
    assert recording.read_bytes() == before
    assert [p.name for p in recording.parent.iterdir()] == [recording.name]


FULL = """
import resource, sys; sys.path.insert(0, {folder!r})
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
from pathlib import Path
from pelagos.errors import RecordingError
from test_record_file import recorder, write
try:
    with recorder(Path({path!r})) as r: write(r, range(100_000))
except RecordingError as error:
    print(error)
"""


@pytest.mark.parametrize("limit", [pytest.param(100_000, marks=pytest.mark.slow), 333_333])
def test_a_full_disk_ends_with_one_sentence_and_keeps_what_was_written(tmp_path: Path, limit: int) -> None:
    path = tmp_path / "full.mcap"
    code = FULL.format(folder=str(Path(__file__).parent), path=str(path), limit=limit)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1
    assert "cannot write the recording: File too large; it is readable up to simulation time" in done.stdout
    found = Recording(path)
    last = float(done.stdout.rsplit("time ", 1)[1].split()[0])
    assert found.times("/auv0/truth")[-1] * 1e-9 == pytest.approx(last, abs=2e-3)
    assert Recording(recover(path).path).complete


def test_a_full_disk_at_the_start_keeps_the_old_recording(recording: Path) -> None:
    before = recording.read_bytes()
    code = FULL.format(folder=str(Path(__file__).parent), path=str(recording), limit=300)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "nothing was recorded" in done.stdout
    assert recording.read_bytes() == before
    assert [p.name for p in recording.parent.iterdir()] == [recording.name]


def test_what_is_no_recording_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(b"something else entirely")
    with pytest.raises(RecordingError, match=r"x\.mcap: is not an MCAP recording"):
        Recording(tmp_path / "x.mcap")
    with pytest.raises(RecordingError, match=r"missing\.mcap: No such file"):
        recover(tmp_path / "missing.mcap")
    with pytest.raises(RecordingError, match="cannot be written: No such file"):
        recorder(tmp_path / "no" / "folder.mcap")


def test_writing_after_the_end_is_refused(tmp_path: Path) -> None:
    r = recorder(tmp_path / "a.mcap")
    r.close()
    r.close()
    with pytest.raises(RecordingError, match="was closed"):
        write(r, range(1000))
    assert Recording(tmp_path / "a.mcap").complete


@pytest.mark.parametrize(("copies", "agent"), [(1, "envoy"), (1, "auv0"), (3, "auv0")])
def test_the_first_copy_has_its_topics_whatever_agents_are_named(copies: int, agent: str, tmp_path: Path) -> None:
    with Recorder(tmp_path / "it.mcap", "", 1, {agent: {}}, None, (45.0, 12.5), 50_000_000, copies=copies) as recorder:
        still = (np.zeros((copies, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (copies, 1)), *np.zeros((2, copies, 3)))
        recorder.write_truth(agent, 0, *still)
    recording = Recording(tmp_path / "it.mcap")
    of_first = [t for t in recording.topics("/truth") if recording.of_first(t)]
    assert of_first == [f"/{agent}/truth" if copies == 1 else f"/env0/{agent}/truth"]
