"""Groups recorded together: one channel a topic, from which every member's messages come back to the byte."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import pelagos as pl
from pelagos.bridges.door import TopicDoor
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.transport import MemoryTransport
from pelagos.errors import LookupFailed, RecordingError
from pelagos.messages.navigation import IMU_FIELDS
from pelagos.report.report import render_report
from pelagos.sim.record_together import GROUPS
from pelagos.sim.replay import Recording, recover
from pelagos.sim.resume import keep, last_checkpoint, resumed_recorder
from pelagos.sim.run_log import open_recorder

SENSORS = {
    "imu": {"type": "imu", "rate_hz": 50},
    "dvl": {"type": "dvl", "rate_hz": 5, "range_max_m": 14.0},
    "gps": {"type": "gps", "rate_hz": 2},
    "depth": {"type": "depth", "rate_hz": 10},
    "side": {"type": "sidescan", "rate_hz": 1, "bins": 8, "range_max_m": 20.0},
    "modem": {"type": "modem", "rate_hz": 2},
    "up": {"type": "altimeter", "rate_hz": 2},
}


def scenario(groups: str, **keys: Any) -> dict[str, Any]:
    """Eleven vehicles, so that names have two lengths, at depths of which some hear no bottom; two are unlike."""
    auv = {
        "count": 11,
        "vehicle": "remus100",
        "start": {"position_m": [3.0, -4.0], "depth_m": 5.0, "speed_mps": 1.2, "spacing_m": [30.0, 25.0]},
        "mission": [{"type": "waypoints", "points": [[90, 20]], "depth_m": 8.0}],
        "mission_from": "start",
        "sensors": SENSORS,
        "navigation": {"type": "ekf"},
        "distributions": {"start.heading_deg": {"uniform": [-90.0, 90.0]}, "start.depth_m": {"uniform": [2.0, 19.0]}},
        "overrides": {
            3: {"sensors": {"imu": {"rate_hz": 25}, "up": {"type": "velocity", "rate_hz": 2}}},
            5: {"sensors": {"dvl": {"noise_mps": 0.05}, "more": {"type": "pose", "rate_hz": 5}}},
            10: {"navigation": {"type": "truth"}},
        },
    }
    agents = {"first": {"vehicle": "remus100", "start": {"depth_m": 7.0}, "sensors": SENSORS}, "auv": auv, **keys}
    record = {"state_rate_hz": 10, "groups": groups}
    return {
        "seed": 4,
        "tick_rate_hz": 50,
        "world": {"type": "flat", "depth_m": 25.0},
        "agents": agents,
        "record": record,
    }


def everything(recording: Recording) -> dict[str, list[tuple[int, bytes]]]:
    return {topic: [(m.t_ns, m.raw) for m in recording.messages(topic)] for topic in recording.channels}


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("together")
    for groups in ("by_member", "together"):
        pl.Simulation.load(scenario(groups), n=2).run(3.1, record=folder / f"{groups}.mcap")
    return folder / "by_member.mcap", folder / "together.mcap"


def test_members_have_the_same_channels_and_messages_to_the_byte(both: tuple[Path, Path]) -> None:
    apart, together = map(Recording, both)
    assert list(together.channels.items()) == list(apart.channels.items())
    assert together.topics() == apart.topics()
    expected = everything(apart)
    assert everything(together) == expected
    assert {topic: together.count(topic) for topic in together.channels} == {t: len(m) for t, m in expected.items()}
    assert sum(map(len, expected.values())) > 5000
    name = "/env1/auv_7/imu/data_raw"
    for found, wanted in zip(together.table(name, IMU_FIELDS), apart.table(name, IMU_FIELDS), strict=True):
        np.testing.assert_array_equal(found, wanted)
    one = Recording(both[1], topics=[name])
    assert everything(one) == {topic: expected[topic] if topic == name else [] for topic in expected}


def test_the_file_has_a_channel_for_a_group_and_topic(both: tuple[Path, Path]) -> None:
    """All readers of MCAP see the group's channels, and decode them by the schema in the file alone."""
    counts = []
    for path in both:
        with path.open("rb") as file:
            counts.append(len(make_reader(file).get_summary().channels))  # type: ignore[union-attr]
    shared = 2 * (2 + 1 + 1 + 1 + 2)  # two copies of imu, dvl's two, gps, depth, truth, navigation
    assert counts[0] - counts[1] > 9 * shared
    with both[1].open("rb") as file:
        reader = make_reader(file)
        schema, channel, message = next(reader.iter_messages(["/env1/auv/imu/data_raw"], log_time_order=False))
    assert schema is not None
    assert channel.metadata["members"] == " ".join(f"auv[{i}]" for i in range(11))
    assert channel.metadata["message"] == "sensor_msgs/msg/Imu"
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    found = store.deserialize_cdr(message.data, schema.name)
    assert found.header.frame_id == "env1/auv/imu"
    assert [d.size for d in found.layout.dim] == [11, 6]
    assert found.layout.dim[1].label.split(", ")[3] == "linear_acceleration.x"
    assert found.data.shape == (66,)


def test_all_members_are_one_array(both: tuple[Path, Path]) -> None:
    apart, together = map(Recording, both)
    table = together.together("/env0/auv/dvl/twist")
    assert table.members == tuple(f"auv[{i}]" for i in range(11))
    assert table.values.shape == (16, 11, len(table.fields))
    assert table.valid.any(axis=0).sum() not in (0, 11)  # not all hear the bottom
    for i in range(11):
        topic, lanes = f"/env0/auv_{i}/dvl/twist", table.valid[:, i]
        t_s, values = apart.table(topic, [f"{f}:float64" for f in table.fields]) if lanes.any() else (np.zeros(0),) * 2
        np.testing.assert_array_equal(table.t_s[lanes], t_s)
        np.testing.assert_array_equal(table.values[lanes, i].ravel(), values.ravel())
        assert not table.values[~lanes, i].any()
    imu = together.together("/env0/auv/imu/data_raw")
    assert imu.valid[:, 3].sum() * 2 == imu.valid[:, 2].sum() == 156  # half of the rate
    assert set(Recording(both[0]).groups) == set()
    with pytest.raises(LookupFailed, match="did you mean '/env0/auv/imu/data_raw'"):
        together.together("/env0/auv/imu/data_rew")
    with pytest.raises(RecordingError, match="no rows of numbers"):
        together.together("/env0/auv/plan")


def test_a_cut_recording_is_read_and_recovered(both: tuple[Path, Path], tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    data = both[1].read_bytes()
    cut.write_bytes(data[: len(data) // 2])
    expected = everything(Recording(both[0]))
    recovered = recover(cut)
    for path in (cut, recovered.path):
        found = everything(Recording(path))
        assert found["/env0/auv_7/imu/data_raw"]
        for topic, messages in found.items():
            assert messages == expected[topic][: len(messages)]


def test_without_its_attachment_a_group_stays_one_topic(both: tuple[Path, Path], tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.mcap"
    data = bytearray(both[1].read_bytes())
    at = data.index(GROUPS.encode())
    data[at : at + len(GROUPS)] = b"x" * len(GROUPS)
    damaged.write_bytes(data)
    with pytest.warns(pl.errors.RecordingWarning):
        found = Recording(damaged)
    assert found.count("/env0/auv/imu/data_raw") == 156
    assert found.message("/env0/auv/imu/data_raw", 5).message.valid.sum() == 10


@pytest.mark.parametrize("groups", ["by_member", "together"])
@pytest.mark.parametrize("beyond_s", [0.0, 0.3])
def test_a_resumed_run_writes_the_same_recording(beyond_s: float, groups: str, tmp_path: Path) -> None:
    """From a checkpoint that was the end, and from one beyond which the stopped run had gone.

    Commands act from the time of their message on, and navigation is solved when a step begins: both at k / (10 Hz)
    for k = 0 ... 19, once, and not at the end of 2 s.
    """
    asked = scenario(groups)
    asked["record"]["commands"] = True
    whole, parts = tmp_path / "whole.mcap", tmp_path / "parts.mcap"
    pl.Simulation.load(asked, n=2).run(2.0, record=whole)
    sim = pl.Simulation.load(asked, n=2)
    with open_recorder(parts, sim) as recorder:
        sim.run(1.0, record=recorder)
        keep(sim, recorder, tmp_path)
        if beyond_s:
            sim.run(beyond_s, record=recorder)
    sim = pl.Simulation.load(asked, n=2)
    sim.restore(last_checkpoint(tmp_path))
    with resumed_recorder(parts, sim) as recorder:
        sim.run(1.0, record=recorder)
    found, expected = everything(Recording(parts)), everything(Recording(whole))
    told = [topic for topic in expected if topic.endswith(("/actuator_commands", "/navigation"))]
    assert len(told) == 2 * (12 + 10)
    for topic in told:
        assert [t_ns for t_ns, _ in found[topic]] == [100_000_000 * k for k in range(20)]
    assert found == expected


@pytest.mark.usefixtures("no_pictures")
def test_reports_are_the_same(tmp_path: Path) -> None:
    pages = []
    for groups in ("by_member", "together"):
        folder = tmp_path / groups
        folder.mkdir()
        sim = pl.Simulation.load(scenario(groups))
        sim.run(2.0, record=folder / "mission.mcap")
        render_report(folder, folder / "mission.mcap", sim.world, {})
        pages.append(json.loads((folder / "stats.json").read_text()))
    assert pages[0]["swarms"]
    assert pages[0]["recording"].pop("bytes") > 1.2 * pages[1]["recording"].pop("bytes")
    assert pages[0] == pages[1]


def test_doors_speak_of_members_and_so_does_their_recording(tmp_path: Path) -> None:
    shown = {}
    for groups in ("by_member", "together"):
        exchange, transport = Exchange(pl.Simulation.load(scenario(groups))), MemoryTransport()
        exchange.add(TopicDoor(transport))
        exchange.run(0.5, record=tmp_path / f"{groups}.mcap")
        exchange.close()
        shown[groups] = everything(Recording(tmp_path / f"{groups}.mcap"))
    assert shown["together"] == shown["by_member"]
    alone = Exchange(pl.Simulation.load(scenario("together")))
    alone.run(0.5, record=tmp_path / "alone.mcap")
    assert Recording(tmp_path / "alone.mcap").groups
    assert everything(Recording(tmp_path / "alone.mcap")) == shown["by_member"]


def test_a_wrong_word_is_told() -> None:
    with pytest.raises(pl.errors.ScenarioError, match="together"):
        pl.Simulation.load(yaml.safe_load(yaml.safe_dump(scenario("togther"))))
