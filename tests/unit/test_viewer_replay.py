"""Recordings as frames and as films."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.config import registry
from pelagos.config.loader import load_scenario
from pelagos.errors import InputError, LookupFailed, NoRecording
from pelagos.math.rotation import product
from pelagos.sensors.sensor import Reading
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording
from pelagos.viewer.course import Course
from pelagos.viewer.film import FilmOptions, make_film
from pelagos.viewer.frame import ShownPose
from pelagos.viewer.marks import legs, marks
from pelagos.viewer.recorded import truth_at
from pelagos.viewer.replay import Replay, replay_view, subject_of
from pelagos.world.build import build_world

SCENARIO: dict[str, Any] = {
    "seed": 4, "world": {"type": "flat", "depth_m": 11.0},
    "agents": {"auv0": {
        "vehicle": "remus100", "start": {"position_m": [5, -8], "depth_m": 4.0, "heading_deg": 20, "speed_mps": 1.2},
        "control": "depth_heading_speed", "command": [5.0, 0.6, 1.5],
        "sensors": {
            "imu": {"type": "imu", "rate_hz": 20}, "depth": {"type": "depth", "rate_hz": 10},
            "dvl": {"type": "dvl", "rate_hz": 5}, "mbes": {"type": "multibeam", "rate_hz": 5, "beams": 16},
            "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 32},
        },
    }},
}  # fmt: skip


def pose(sim: pl.Simulation) -> tuple[Any, Any]:
    state = sim.state["auv0"]
    return state.position[0].copy(), state.attitude[0].copy()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[int, Any], Any]:
    path = tmp_path_factory.mktemp("replay") / "mission.mcap"
    sim = pl.Simulation.load(SCENARIO)
    true, heard = {}, {}
    with (
        sim.on_tick(lambda s: true.update({s.time_ns: pose(s)})),
        sim.watch(lambda block: heard.update({(n, r.t_ns): r for n in block for r in block[n]})),
    ):  # fmt: skip
        sim.run(2.0, record=path)
    return path, true, heard


def test_poses_and_readings_of_a_recording_are_those_of_the_run(recorded):
    path, true, heard = recorded
    _, sensors = subject_of(Recording(path))
    replay = Replay(Recording(path), sensors)
    assert (replay.first_ns, replay.last_ns) == (0, 2_000_000_000)
    frame = replay.frame(1_500_000_000, since_ns=1_000_000_000)
    position, attitude = true[1_500_000_000]
    assert frame.agents["auv0"].position == pytest.approx(position, abs=1e-6)
    assert abs(frame.agents["auv0"].attitude @ attitude) == pytest.approx(1.0, abs=1e-9)
    by_name: dict[str, list[Any]] = {}
    for placed in frame.samples:
        by_name.setdefault(placed.sample.name, []).append(placed.sample)
    assert [s.t_ns for s in by_name["auv0.mbes"]] == [1_200_000_000, 1_400_000_000]  # waterfalls: every ping
    assert [s.t_ns for s in by_name["auv0.sonar"]] == [1_400_000_000]  # pictures: the newest
    depth = heard["auv0.depth", 1_500_000_000].data[0]
    assert by_name["auv0.depth"][0].numbers["depth [m]"] == pytest.approx(float(np.ravel(depth)[0]), abs=1e-6)
    dvl = heard["auv0.dvl", 1_400_000_000]
    numbers = by_name["auv0.dvl"][0].numbers
    found = [numbers[f"velocity {axis} [m/s]"] for axis in "xyz"]
    assert found == pytest.approx(dvl.data[0], abs=1e-9)
    assert by_name["auv0.dvl"][0].beams[:, 2].mean() == pytest.approx(-float(dvl.extras["altitude"][0]), abs=0.3)
    imu = heard["auv0.imu", 1_500_000_000].data[0]
    assert list(by_name["auv0.imu"][0].numbers.values()) == pytest.approx(imu, abs=1e-9)


def test_seeking_holds_and_jumps(recorded):
    path, _, _ = recorded
    _, sensors = subject_of(Recording(path))
    replay = Replay(Recording(path), sensors)
    replay.paused = True
    assert replay.take(0.0).t_ns == 0
    assert replay.take(0.0) is None
    assert replay.obey({"do": "seek", "t": 1.25})
    assert replay.take(0.0).t_ns == 1_250_000_000
    assert replay.obey({"do": "seek", "t": 0.5})
    back = replay.take(0.0)
    assert back.jump
    assert len([s for s in back.samples if s.sample.name == "auv0.mbes"]) == 3  # all that a waterfall had by then
    assert replay.obey({"do": "seek", "t": 99.0})
    assert replay.take(0.0).t_ns == replay.last_ns
    assert not replay.obey({"do": "spawn"})
    assert not replay.obey({"do": "seek", "t": float("nan")})


def test_legs_are_marked_where_the_vehicle_rounds_the_corners():
    """A track that runs its plan at 2 m/s with a bulge of 3 m; a corner that nobody came near has no mark."""
    plan = np.array([[0.0, 0.0, -5.0], [60.0, 0.0, -5.0], [60.0, -40.0, -5.0], [60.0, 40.0, -9.0], [0.0, 90.0, -9.0]])
    t = np.arange(0.0, 95.0, 0.5)
    x, y = np.clip(2 * t, 0, 60), np.where(t < 30, 3.0, np.where(t < 50, -2 * (t - 30), -40 + 2 * (t - 50)))
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(t), 1))
    way = Course((t * 1e9).astype(np.int64), np.stack([x, y, 0 * t - 5], axis=1), attitude, np.zeros((len(t), 3)))
    found = legs({"auv0": plan, "auv1": plan}, {"auv0": way})
    assert [m["text"] for m in found] == ["auv0: leg 2 of 4", "auv0: leg 3 of 4", "auv0: leg 4 of 4"]
    assert [m["t"] for m in found] == pytest.approx([30.0, 50.0, 90.0], abs=0.51)


def test_contacts_and_a_lost_dvl_are_marked(tmp_path):
    """Two contacts, one too weak to count, a DVL that is silent for 2 s, and one that is never heard again."""
    sensors = {
        name: registry.find("sensor", kind).config.model_validate({"type": kind, **keys})
        for name, kind, keys in (
            ("bump", "collision", {"rate_hz": 10, "least_force_n": 2.0}), ("dvl", "dvl", {"rate_hz": 5}),
        )
    }  # fmt: skip
    valid, zero = np.ones(1, bool), np.zeros((1, 3))
    beams = {"ranges": (1, 4), "beam_valid": (1, 4), "sigma": (1, 4), "beam_velocity": (1, 4), "snr": (1, 4)}
    echoes = {**{k: np.ones(v) for k, v in beams.items()}, "altitude": np.ones(1)}
    with Recorder(tmp_path / "a.mcap", "", 1, {"auv0": sensors}, None, (0.0, 0.0), 10**8) as recorder:
        for tick in range(100):
            t_s = 0.1 * tick
            force = 5.0 if 2.05 < t_s < 3.0 or 4.05 < t_s < 4.5 else 1.5 if 6.0 < t_s < 7.0 else 0.0
            felt = {"force": np.array([[0.6, 0.0, -0.8]]) * force, "moment": zero}
            recorder.write("auv0", "bump", Reading(zero, zero, tick * 10**8, "auv0/bump", valid, felt))
            if tick % 2 == 0 and not 3.0 < t_s < 5.0 and t_s < 8.1:
                recorder.write("auv0", "dvl", Reading(zero, zero, tick * 10**8, "auv0/dvl", valid, echoes))
    recording = Recording(tmp_path / "a.mcap")
    topics = {"auv0.bump": "/auv0/bump/wrench", "auv0.dvl": "/auv0/dvl/dvl"}
    found = marks(recording, topics, {f"auv0.{k}": v for k, v in sensors.items()}, (0, 99 * 10**8))
    assert [(round(m["t"], 3), m["text"]) for m in found] == [
        (2.1, "auv0 touches"), (3.0, "auv0.dvl lost"), (4.1, "auv0 touches"), (8.0, "auv0.dvl lost"),
    ]  # fmt: skip


def test_plan_of_a_recording_is_that_of_the_mission(tmp_path):
    scenario = copy.deepcopy(SCENARIO)
    auv = scenario["agents"]["auv0"]
    auv["sensors"] = {"depth": auv["sensors"]["depth"]}
    del auv["control"], auv["command"]
    auv["mission"] = [{"type": "waypoints", "points": [[40, -8], [40, -60]], "depth_m": 6.0, "speed_mps": 1.5}]
    sim = pl.Simulation.load(scenario)
    sim.run(1.0, record=tmp_path / "mission.mcap")
    subject, _ = subject_of(Recording(tmp_path / "mission.mcap"))
    assert subject.plans["auv0"][-1] == pytest.approx([40.0, -60.0, -6.0], abs=1e-6)
    assert subject.kind == "replay"


def test_films_have_their_pictures(recorded, tmp_path):
    import av

    path, _, _ = recorded
    done: list[tuple[int, int]] = []
    options = FilmOptions(kind="chase", rate_hz=2, size=(320, 180))
    count = make_film(path, tmp_path / "chase.mp4", options, progress=lambda n, of: done.append((n, of)))
    assert count == 5
    assert done[-1] == (5, 5)
    with av.open(str(tmp_path / "chase.mp4")) as film:
        frames = [f.to_ndarray(format="rgb24") for f in film.decode(video=0)]
    assert len(frames) == 5
    assert frames[0].shape == (180, 320, 3)
    assert np.abs(frames[0].astype(float) - frames[-1]).max() > 40  # it moves
    sonar = FilmOptions(kind="sonar", sensor="sonar", rate_hz=1, size=(640, 360))
    make_film(path, tmp_path / "sonar.mp4", sonar)
    with av.open(str(tmp_path / "sonar.mp4")) as film:
        first = next(film.decode(video=0)).to_ndarray(format="rgb24").astype(float)
    assert first[:36, :9].max() < 60  # the sensor's name does not show from behind the line of numbers
    assert first[41:64, :90].max() > 150  # it stands below it
    with pytest.raises(LookupFailed, match="mbes"):
        make_film(path, tmp_path / "x.mp4", FilmOptions(kind="sonar", sensor="sonnar"))
    with pytest.raises(InputError, match=r"ends in \.mp4"):
        make_film(path, tmp_path / "x.avi", FilmOptions())


def test_what_cannot_be_shown_is_told_in_one_sentence(tmp_path):
    from pelagos.sim.mcap_writer import McapWriter

    empty = tmp_path / "empty.mcap"
    McapWriter(empty, library="test").close()
    with pytest.raises(NoRecording, match="this recording has no poses"):
        replay_view(empty)
    with pytest.raises(NoRecording, match="this recording has no poses"):
        make_film(empty, tmp_path / "x.mp4", FilmOptions())


def test_truth_in_a_recording_is_that_at_the_sensor():
    """A vehicle on its nose by 30 degrees, rolled: sensors half a metre from its origin see what they see there."""
    roll, pitch = np.radians([10.0, 30.0])
    rolled, pitched = (
        np.array([np.cos(roll / 2), np.sin(roll / 2), 0, 0]), np.array([np.cos(pitch / 2), 0, np.sin(pitch / 2), 0])
    )  # fmt: skip
    pose = ShownPose(np.array([3.0, -4.0, -5.0]), product(pitched, rolled))
    scenario = load_scenario({"world": {"type": "flat", "depth_m": 12.0}, "agents": {"a": {"vehicle": "remus100"}}})
    world = build_world(scenario.located_world)
    at = [0.5, -0.2, -0.1]

    def config(kind: str) -> Any:
        return registry.find("sensor", kind).config.model_validate({"type": kind, "position_m": at})

    z = -5.0 - 0.5 * np.sin(pitch) + np.cos(pitch) * (-0.2 * np.sin(roll) - 0.1 * np.cos(roll))
    assert truth_at(config("depth"), pose, world)["depth [m]"] == pytest.approx(-z, abs=1e-12)
    slant = (12.0 + z) / (np.cos(pitch) * np.cos(roll))
    assert truth_at(config("altimeter"), pose, world)["range [m]"] == pytest.approx(slant, abs=1e-4)
    assert truth_at(config("imu"), pose, world) == {}


@pytest.mark.parametrize(("keys", "says"), [
    ({"rate_hz": 0}, "--rate is 1 to 120"), ({"rate_hz": 121}, "--rate is 1 to 120"), ({"speed": 0.009}, "0.01 to"),
    ({"speed": 1001.0}, "0.01 to 1000"), ({"rate_hz": 1, "speed": 0.01}, ""), ({"rate_hz": 120, "speed": 1000.0}, ""),
])  # fmt: skip
def test_films_that_cannot_be_are_refused_before_the_recording_is_opened(keys, says, tmp_path, monkeypatch):
    class Opened(Exception):
        pass

    def opened(*_):
        raise Opened

    monkeypatch.setattr("pelagos.viewer.film._Artist", opened)
    with pytest.raises(InputError if says else Opened, match=says or None):
        make_film(tmp_path / "no.mcap", tmp_path / "a.MP4", FilmOptions(**keys))
    with pytest.raises(InputError, match="a file in a folder that exists"):
        make_film(tmp_path / "no.mcap", tmp_path / "nowhere" / "a.mp4", FilmOptions(**keys))
