"""A recording is played out again, byte for byte and in order; and becomes a bag that rosbags' own reader opens."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.playback import Playback, write_rosbag
from pelagos.bridges.transport import MemoryTransport
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
    playback, transport = Playback(recording, rate=0), MemoryTransport()
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
    playback, transport = Playback(recording, rate=4.0, start_s=0.5, end_s=1.5, only=("/auv0/imu", "/tf_static")), None
    transport = MemoryTransport()
    playback.add(transport)
    playback.play()
    assert now[0] - 7.0 == pytest.approx(0.25, abs=0.01)
    times = np.array([t for t, _ in transport.written["/auv0/imu/data_raw"]]) * 1e-9
    assert (times.min(), times.max()) == (0.5, 1.5)
    assert len(transport.written["/tf_static"]) == 1  # latched: said, though it lies before the part
    assert "/auv0/truth" not in transport.written


def test_a_bag_for_ros2(recording: Path, tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader

    count = write_rosbag(recording, tmp_path / "bag")
    with Reader(tmp_path / "bag") as bag:
        assert bag.message_count == count
        raw = [bytes(data) for c, _, data in bag.messages() if c.topic == "/auv0/imu/data_raw"]
        kinds = {c.topic: (c.msgtype, c.digest) for c in bag.connections}
    assert raw == [m.raw for m in pl.Recording(recording).messages("/auv0/imu/data_raw")]
    golden = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    assert kinds["/auv0/imu/data_raw"] == ("sensor_msgs/msg/Imu", golden)
    with pytest.raises(pl.InputError, match="exists already"):
        write_rosbag(recording, tmp_path / "bag")


@pytest.mark.parametrize(
    ("words", "said"),
    [([], "replay where to"), (["--ros2", "--rate", "-1"], "--rate"),
     (["--foxglove", "--from", "3", "--to", "2"], "--from"),
     (["--ros2", "--topic", "/nobody"], "no topic begins with")],
)  # fmt: skip
def test_what_cannot_be_is_said(
    recording: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["replay", str(recording), *words])
    assert left.value.code == 2
    assert said in capsys.readouterr().err
