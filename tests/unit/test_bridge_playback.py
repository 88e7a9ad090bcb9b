"""A recording is played out again, byte for byte and in order; and becomes a bag that rosbags' own reader opens."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.part import Part
from pelagos.bridges.playback import LOOK_S, QUIET_S, Playback
from pelagos.bridges.rosbag import write_rosbag
from pelagos.bridges.transport import LATCHED, MemoryTransport, Qos
from pelagos.cli.main import main

SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 20.0},
    "agents": {"auv0": {
        "vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 5.0, "speed_mps": 1.5},
        "sensors": {"imu": {"type": "imu", "rate_hz": 50}, "depth": {"type": "depth", "rate_hz": 10}},
    }},
}  # fmt: skip


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("played") / "mission.mcap"
    pl.Simulation.load(SCENARIO).run(2.0, record=path)
    return path


def test_every_message_is_played_in_order(recording: Path) -> None:
    playback, transport = Playback(Part(recording), rate=0), MemoryTransport()
    playback.add(transport)
    count = playback.play()
    source = pl.Recording(recording)
    assert count == sum(source.count(t) for t in source.topics())
    for topic in source.topics():
        assert [(m.t_ns, m.raw) for m in source.messages(topic)] == transport.written[topic]
    times = [t for t, topic in transport.order if topic not in ("/labels", "/tf_static")]
    assert times == sorted(times)
    assert transport.written["/clock"][0][0] == 0
    playback.close()
    assert transport.closed


def test_a_part_of_it_at_its_own_pace(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One second, four times as fast, by a clock that goes on in sleeps alone."""
    now = [7.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds

    monkeypatch.setattr("pelagos.bridges.playback.time.perf_counter", lambda: now[0])
    monkeypatch.setattr("pelagos.bridges.playback.time.sleep", sleep)
    part = Part(recording, start_s=0.5, end_s=1.5, only=("/auv0/imu", "/tf_static"))
    playback, transport = Playback(part, rate=4.0), MemoryTransport()
    playback.add(transport)
    playback.play()
    assert now[0] - 7.0 == pytest.approx(0.25, abs=0.01)
    times = np.array([t for t, _ in transport.written["/auv0/imu/data_raw"]]) * 1e-9
    assert (times.min(), times.max()) == (0.5, 1.5)
    assert len(transport.written["/tf_static"]) == 1  # latched: said, though it lies before the part
    assert "/auv0/truth" not in transport.written


def test_it_begins_where_the_recording_does(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A recording of the end of a run is not preceded by the time until then."""
    now = [7.0]
    monkeypatch.setattr("pelagos.bridges.playback.time.perf_counter", lambda: now[0])
    monkeypatch.setattr("pelagos.bridges.playback.time.sleep", lambda s: now.__setitem__(0, now[0] + s))
    late = recording.parent / "late.mcap"
    sim = pl.Simulation.load(SCENARIO)
    sim.run(0.5)
    with sim.recording(late):
        sim.step(ticks=25)
    part = Part(late)
    assert part.first_ns >= 500_000_000
    playback, transport = Playback(part), MemoryTransport()
    playback.add(transport)
    playback.play()
    assert now[0] - 7.0 < 0.3
    assert transport.written["/tf_static"][0][0] == part.first_ns
    with pytest.raises(pl.InputError, match=r"recorded from 0\.5.* to 0\.7.* s"):
        Part(late, end_s=0.3)


def test_it_waits_until_no_further_reader_comes(recording: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Readers come after 0.5, 0.6 and 0.7 s: it begins 0.3 s after the last; without any it gives up."""
    now = [3.0]
    transport, playback = MemoryTransport(), Playback(Part(recording))
    playback.add(transport)

    def sleep(seconds: float) -> None:
        now[0] += seconds
        transport.listening = sum(now[0] - 3.0 > t for t in (0.5, 0.6, 0.7))

    monkeypatch.setattr("pelagos.bridges.playback.time.monotonic", lambda: now[0])
    monkeypatch.setattr("pelagos.bridges.playback.time.sleep", sleep)
    assert playback.wait(60.0) == 3
    assert now[0] - 3.0 == pytest.approx(0.7 + QUIET_S, abs=3 * LOOK_S)
    assert "/auv0/imu/data_raw" in transport.written  # announced, for nobody can find what is not there
    assert not transport.written["/auv0/imu/data_raw"]
    monkeypatch.setattr("pelagos.bridges.playback.time.sleep", lambda s: now.__setitem__(0, now[0] + s))
    transport.listening, now[0] = 0, 0.0
    assert playback.wait(1.5) == 0
    assert now[0] == pytest.approx(1.5, abs=LOOK_S)


def test_a_subscriber_that_is_there_gets_all_and_a_late_one_what_is_latched(recording: Path) -> None:
    """Over DDS as fast as it goes: 101 readings of the IMU, none lost at the beginning or at the end."""
    pytest.importorskip("cyclonedds")
    from pelagos.bridges.dds import DdsTransport

    domain = 120 + os.getpid() % 80
    early, late = DdsTransport(domain=domain, node="early"), DdsTransport(domain=domain, node="late")
    imu: list[bytes] = []
    early.subscribe("/auv0/imu/data_raw", "sensor_msgs/msg/Imu", imu.append, qos=Qos(depth=1000))
    playback = Playback(Part(recording), rate=0)
    playback.add(DdsTransport(domain=domain, node="player"))
    try:
        assert playback.wait(20.0) == 1
        playback.play()
        frames: list[bytes] = []
        late.subscribe("/tf_static", "tf2_msgs/msg/TFMessage", frames.append, qos=LATCHED)
        end = time.monotonic() + 20.0
        while time.monotonic() < end and not (frames and len(imu) == 101):
            time.sleep(0.01)
    finally:
        troubles = playback.close()
        early.close()
        late.close()
    source = pl.Recording(recording)
    assert [raw[4:] for raw in imu] == [m.raw[4:] for m in source.messages("/auv0/imu/data_raw")]
    assert [raw[4:] for raw in frames] == [m.raw[4:] for m in source.messages("/tf_static")]
    assert not troubles


def test_a_bag_for_ros2(recording: Path, tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader

    count = write_rosbag(recording, tmp_path / "bag")
    with Reader(tmp_path / "bag") as bag:
        assert bag.message_count == count
        raw = [bytes(data) for c, _, data in bag.messages() if c.topic == "/auv0/imu/data_raw"]
        labels = [bytes(data) for c, _, data in bag.messages() if c.topic == "/labels"]
        kinds = {c.topic: (c.msgtype, c.digest) for c in bag.connections}
    assert raw == [m.raw for m in pl.Recording(recording).messages("/auv0/imu/data_raw")]
    golden = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    assert kinds["/auv0/imu/data_raw"] == ("sensor_msgs/msg/Imu", golden)
    assert len(labels) == 1  # as a run with ROS 2 says them
    played = Part(tmp_path / "bag")  # and a bag is a recording
    assert played.legend == ""
    assert len(list(played.messages())) == count
    assert {c.topic for c in played.channels.values() if c.latched} == {"/labels", "/tf_static"}
    assert write_rosbag(recording, tmp_path / "part", start_s=1.0, only=("/auv0/imu",)) == 51
    (tmp_path / "other").mkdir()
    for name, said in (("bag_0.db3", "in SQLite"), ("a.mcap", "give one of its recordings: .*a.mcap")):
        (tmp_path / "other" / name).touch()
        with pytest.raises(pl.InputError, match=said):
            Part(tmp_path / "other")
    with pytest.raises(pl.InputError, match="exists already"):
        write_rosbag(recording, tmp_path / "bag")


@pytest.mark.parametrize(
    ("words", "said"),
    [([], "replay where to"), (["--ros2", "--rate", "-1"], "--rate"),
     (["--foxglove", "--from", "3", "--to", "2"], "--from"),
     (["--ros2", "--topic", "/nobody"], "no topic begins with"), (["--ros2", "--from", "9"], "from 0 to 2 s"),
     (["--rosbag", "bag", "--loop", "--rate", "2"], "leave out --loop, --rate"), (["--ros2", "--wait", "-1"], "--wait"),
     (["--ros2", "--port", "1"], "--port is that of --foxglove")],
)  # fmt: skip
def test_what_cannot_be_is_said(
    recording: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["replay", str(recording), *words])
    assert left.value.code == 2
    assert said in capsys.readouterr().err
