"""A simulation that is looked at: the same bytes, orders between steps, nothing that waits for a browser."""

from __future__ import annotations

import gc
import hashlib
import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.cli.view import ViewOptions, say_where
from pelagos.errors import CommandError
from pelagos.sim.replay import Recording
from pelagos.viewer.drive import Axes, drive
from pelagos.viewer.hub import Hub, records
from pelagos.viewer.live import Live
from pelagos.viewer.orders import Orders
from pelagos.viewer.pilot import Pilot
from pelagos.viewer.server import Server
from pelagos.viewer.session import Session, Watch, currents_of, subject_of
from pelagos.viewer.turns import TURN_S
from pelagos.viewer.view import View

SCENARIO: dict[str, Any] = {
    "seed": 7,
    "world": {"type": "flat", "depth_m": 15.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [2.0, -3.0], "depth_m": 5.0, "speed_mps": 1.0, "heading_deg": 40},
            "control": "depth_heading_speed",
            "command": [6.0, 0.4, 1.5],
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50},
                "depth": {"type": "depth", "rate_hz": 10},
                "mbes": {"type": "multibeam", "rate_hz": 5, "beams": 16},
                "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 16, "bins": 32},
            },
        }
    },
}


@pytest.fixture(scope="module")
def loaded() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


@pytest.fixture
def sim(loaded: pl.Simulation) -> pl.Simulation:
    loaded.reset(seed=7)
    return loaded


def digest(path: Path) -> str:
    found = hashlib.sha256()
    for message in Recording(path).messages():
        found.update(f"{message.topic} {message.t_ns} ".encode() + message.raw)
    return found.hexdigest()


@contextmanager
def taking_little(watch: Watch) -> Iterator[Any]:
    """A browser that asks for every panel, takes the scene, then reads no more; at the end its line breaks."""
    client = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    address = f"ws://127.0.0.1:{watch.view.server.port}/live?token={watch.view.server.guard.token}"
    with client.connect(address, max_size=None, close_timeout=0.1) as browser:
        browser.send(json.dumps({"do": "panels", "names": ["auv0.mbes", "auv0.sonar"]}))
        while not any(header["type"] == "hello" for header, _ in records(browser.recv(timeout=60))):
            pass
        yield browser


def test_same_seed_same_bytes_with_and_without_a_view(sim, tmp_path):
    before = sys.getswitchinterval()
    sim.run(1.5, record=tmp_path / "alone.mcap")
    sim.reset()
    with Watch(sim, port=0) as watch, taking_little(watch) as browser:
        assert sys.getswitchinterval() == pytest.approx(TURN_S, rel=0.01)
        sim.run(1.5, record=tmp_path / "seen.mcap")
        watch.view.hub.publish("x", {"type": "note"})  # nobody takes it
        browser.close_socket()
        for _ in range(200):
            if watch.view.pictures:
                break
            watch.view._closed.wait(0.05)
        assert watch.view.pictures > 0
    assert digest(tmp_path / "alone.mcap") == digest(tmp_path / "seen.mcap")
    assert not sim.watchers
    assert sys.getswitchinterval() == pytest.approx(before, rel=0.01)


def test_what_is_handed_on_owns_its_memory_and_only_the_stepping_thread_collects(sim):
    """The view's thread must not be the last to let go of an array of the device: it would wait for ever."""
    live = Live(sim)
    assert gc.isenabled()
    with Watch(sim, port=0), sim.watch(live.heard):
        assert not gc.isenabled()
        sim.run(1.0)
        live.show()
    assert gc.isenabled()
    readings = [r for found in live._raw.values() for r in found]
    assert {r.frame.split("/")[-1] for r in readings} >= {"imu", "mbes", "sonar"}
    for reading in readings:
        arrays = [reading.data, reading.valid, *reading.extras.values()]
        assert all(a.base is None and a.flags.owndata for a in arrays)
        assert len(reading.data) == 1


def test_water_that_is_looked_up_while_it_runs_changes_no_byte(sim, tmp_path, monkeypatch):
    """Somebody looks on, with a section and arrows that are renewed with every frame by the thread that steps."""
    sim.ocean.set(current=(0.2, -0.3, 0.0))
    sim.reset()
    sim.run(1.5, record=tmp_path / "alone.mcap")
    sim.reset()
    monkeypatch.setattr("pelagos.viewer.soundings._OLD_S", 0.0)
    monkeypatch.setattr("pelagos.viewer.live.EVERY_S", 0.0)
    monkeypatch.setattr(Hub, "count", property(lambda self: 1))
    with Watch(sim, port=0) as watch:
        drawn: list[object] = []
        watch.view.show_section = drawn.append
        watch.view._heard({"do": "section", "what": "sound_speed", "along": "east"})
        sim.run(1.5, record=tmp_path / "seen.mcap")
    assert len(drawn) >= 2
    assert digest(tmp_path / "alone.mcap") == digest(tmp_path / "seen.mcap")
    sim.ocean.set(current=None)


def test_every_ping_is_heard_once_at_the_pose_of_its_time(sim):
    """Also of a sensor that a run reads together afterwards; the pose is that of the recording at that time."""
    heard: list[int] = []
    with sim.watch(lambda block: heard.extend(r.t_ns for r in block.get("auv0.mbes", ()))):
        sim.run(1.0)
    assert heard == [200_000_000 * i for i in range(6)]
    sim.reset()
    live = Live(sim)
    places = {}
    with sim.watch(live.heard), sim.on_tick(lambda s: places.update({s.time_ns: s.state["auv0"].position[0].copy()})):
        sim.run(1.0)
        live.show()
    frame = live.take()
    assert frame is not None
    pings = [p for p in frame.samples if p.sample.name == "auv0.mbes"]
    assert [p.sample.t_ns for p in pings] == heard
    for ping in pings:
        assert ping.pose.position == pytest.approx(places[ping.sample.t_ns], abs=1e-3)
    assert len([p for p in frame.samples if p.sample.name == "auv0.sonar"]) == 1  # of pictures the newest


@pytest.fixture
def pilot(sim, tmp_path) -> tuple[Pilot, Orders, list[tuple[str, str]]]:
    live = Live(sim)
    made = Pilot(sim, live, paused=True)
    live.status = made.status
    said: list[tuple[str, str]] = []
    made.say = lambda text, kind: said.append((kind, text))
    return made, Orders(made, tmp_path / "results"), said


def obey(pilot: Pilot, orders: Orders, **message: Any) -> None:
    assert orders.obey(message)
    pilot._obey()


def test_pause_tick_speed_and_reset(pilot):
    made, orders, said = pilot
    obey(made, orders, do="tick")
    due = made._advance(0.0)
    assert made.sim.time_ns == made.sim.dt_ns
    assert made.paused
    obey(made, orders, do="pause", paused=False)
    obey(made, orders, do="speed", speed=0)
    made._advance(due)
    assert made.sim.time_ns >= 11 * made.sim.dt_ns
    obey(made, orders, do="speed", speed=-1)
    obey(made, orders, do="speed", speed="fast")
    obey(made, orders, do="reset", seed=-4)
    assert [kind for kind, _ in said] == ["error"] * 3
    assert "as fast as it goes" in said[0][1]
    assert made.speed == 0
    obey(made, orders, do="reset", seed=11)
    assert (made.sim.time_ns, made.sim.seed) == (0, 11)
    made.goals["auv0"] = [np.array([30.0, -20.0, -3.0]), np.array([-5.0, 8.0, -4.0])]
    obey(made, orders, do="reset", seed=12)
    assert made.goals == {}
    assert not orders.obey({"do": "format the disk"})


def test_step_that_takes_long_is_told_to_whoever_waits_for_it(sim, tmp_path, monkeypatch):
    """Kernels that are new to a machine are compiled for half a minute: a page that stands still must say so."""
    told: list[int] = []
    with Session(sim, results=tmp_path, server=Server(port=0), paused=True) as session:
        live, view = session.live, session.view
        publish = view.hub.publish
        monkeypatch.setattr(view.hub, "publish", lambda key, header, *more, **options: (
            told.append(header["s"]) if key == "waiting" else publish(key, header, *more, **options)))  # fmt: skip

        def late(seconds: float) -> None:
            assert live.step_began is not None
            live.step_began -= seconds
            view._tell_of_waiting()

        with monkeypatch.context() as slow, sim.watch(live.heard):
            step = sim.step
            slow.setattr(sim, "step", lambda **options: (late(12.5), step(**options), view._tell_of_waiting()))
            session.pilot._advance(0.0)
        assert told == [12, 0]  # a block that was heard begins the count anew
        assert live.step_began is None
        session.pilot.post(lambda: late(40.5))  # another sea
        session.pilot._obey()
        view._tell_of_waiting()
        assert told == [12, 0, 40, 0]


def test_run_that_a_browser_holds_is_not_said_to_be_late(sim):
    with Watch(sim, port=0) as watch, watch.live.at_work():
        watch.live.step_began = time.monotonic() - 7.5
        assert 7 <= watch.view.waited_s() < 300
        sim.pause()
        assert watch.view.waited_s() == 0
        sim.resume()


def test_way_point_is_gone_to_over_the_ground_and_left_behind(pilot):
    made, orders, said = pilot
    start = made.sim.state["auv0"].position[0].copy()
    obey(made, orders, do="goal", agent="auv0", x=float(start[0] + 12.0), y=float(start[1] - 9.0), depth=40)
    obey(made, orders, do="goal", agent="auv0", x=60.0, y=-20.0)
    assert not said
    assert made.goals["auv0"][0][2] == pytest.approx(-13.0)  # two metres over the ground at 15 m
    assert made.sim.stepper.mode("auv0") == "line_of_sight"
    first = made.goals["auv0"][0].copy()
    for _ in range(200):
        made.sim.step(ticks=20)
        made._follow_goals()
        if len(made.goals["auv0"]) == 1:
            break
    assert float(np.linalg.norm(made.sim.state["auv0"].position[0][:2] - first[:2])) < 3.2
    obey(made, orders, do="goal", agent="auv9", x=1.0, y=1.0)
    assert said[-1][0] == "error"
    assert "auv0" in said[-1][1]  # the nearest name


def test_prop_that_is_dragged_slowly_does_not_climb_upon_itself(pilot):
    """The pointer's ray meets the prop where it still stands; what counts is the ground behind it."""
    made, orders, said = pilot
    obey(made, orders, do="spawn", shape="box", x=4.0, y=-5.0, size=1)
    other = {"do": "spawn", "shape": "box", "x": -7.0, "y": 3.0, "size": 2}
    obey(made, orders, **other)
    body, beside = made.sim.bodies.bodies
    assert made.sim.bodies.rows_of(beside)[0] == made.sim.bodies.rows_of(body)[0] + 1
    for k in range(1, 4):  # steps that are smaller than the box
        at = np.array([4.0 + 0.2 * k, -5.0 - 0.1 * k, -15.0])
        eye = at + np.array([-9.0, 6.0, 7.0])
        obey(made, orders, do="move_seen", name=body.name, eye=eye.tolist(), way=(at - eye).tolist())
        assert body.position[0] == pytest.approx([*at[:2], -14.5], abs=1e-3)  # rays are float32
    obey(made, orders, do="move_seen", name=body.name, eye=[-7.0, 3.0, -5.0], way=[0, 0, -2])
    assert body.position[0] == pytest.approx([-7.0, 3.0, -12.5], abs=1e-3)  # upon another prop it does
    assert not said
    for gone in (body, beside):
        obey(made, orders, do="remove", name=gone.name)


def test_props_are_put_moved_and_removed_between_steps(pilot):
    made, orders, said = pilot
    obey(made, orders, do="spawn", shape="box", x=5.0, y=-6.0, size=2)
    body = made.sim.bodies.bodies[0]
    assert body.position[0] == pytest.approx([5.0, -6.0, -14.0])  # on the ground
    obey(made, orders, do="move", name=body.name, x=7.5, y=1.0)
    assert body.position[0] == pytest.approx([7.5, 1.0, -14.0])
    obey(made, orders, do="remove", name=body.name)
    assert not made.sim.bodies.bodies
    obey(made, orders, do="spawn", shape="pyramid", x=0.0, y=0.0)
    obey(made, orders, do="spawn", shape="box", x=float("nan"), y=0.0)
    assert [kind for kind, _ in said] == ["error", "error"]


def test_reset_shows_the_readings_of_the_start(pilot):
    made, orders, said = pilot
    with made.sim.watch(made.live.heard):
        made.sim.step(ticks=30)
        made.live.show()
        assert made.live.take().t_ns > 0
        obey(made, orders, do="reset", seed=7)
        frame = made.live.take()
    assert (frame.t_ns, frame.jump, said) == (0, True, [])
    assert {(p.sample.name, p.sample.t_ns) for p in frame.samples} >= {("auv0.sonar", 0), ("auv0.mbes", 0)}
    assert {p.sample.t_ns for p in frame.samples} == {0}


def test_record_from_the_page(pilot):
    made, orders, said = pilot
    obey(made, orders, do="record", on=True)
    made.sim.step(ticks=40)
    obey(made, orders, do="reset")
    assert "end the recording" in said[-1][1]
    obey(made, orders, do="record", on=False)
    path = Path(said[-1][1].removeprefix("recorded: "))
    recording = Recording(path)
    assert recording.complete
    assert recording.count("/auv0/truth") > 0


def test_sticks_become_set_points(sim):
    """A torpedo's heading turns to port with the stick, so the compass falls; its depth grows downwards."""
    sim.step(ticks=20)
    before = sim.held_command("auv0")[0].copy()
    drive(sim, "auv0", Axes(surge=-1.0, heave=-0.5, yaw=1.0), 0.2)
    depth, heading, speed = sim.held_command("auv0")[0]
    assert depth == pytest.approx(before[0] + 0.4 * 0.5 * 0.2)
    assert heading == pytest.approx(before[1] - np.radians(25) * 0.2)
    assert speed == pytest.approx(before[2] - 0.4 * 0.2)
    drive(sim, "auv0", Axes(yaw=1.0), 600.0)  # a pause between two messages is no long push
    assert sim.held_command("auv0")[0][1] == pytest.approx(heading - np.radians(25) * 0.5)
    with pytest.raises(CommandError, match="a number from -1 to 1"):
        Axes.of({"surge": "full"})
    assert Axes.of({"surge": 7, "yaw": -3}) == Axes(surge=1.0, yaw=-1.0)
    with pytest.raises(CommandError, match="no agent 'auv1'"):
        drive(sim, "auv1", Axes(), 0.1)


def test_a_browser_that_is_slow_drops_pictures_and_nothing_waits(sim):
    """Frames that nobody takes are one frame; a waterfall's lines are all in it, and no more than are kept."""
    live = Live(sim)
    with sim.watch(live.heard):
        for _ in range(8):
            sim.step(ticks=100)
            live.show()
    frame = live.take()
    assert frame is not None
    assert frame.t_ns == sim.time_ns
    assert len([p for p in frame.samples if p.sample.name == "auv0.mbes"]) == 21  # 4 s at 5 Hz, and the start
    assert live.take(0.0) is None


def test_who_comes_while_nothing_moves_sees_the_sensors_pictures(sim):
    """A paused run, or a recording at its end: what is asked for is drawn, though no frame comes any more."""
    websockets = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
    live = Live(sim)
    with sim.watch(live.heard):
        sim.step(ticks=100)
        live.show()
    with View(subject_of(sim), live).start() as view:
        while not view.pictures:
            time.sleep(0.01)
        address = f"ws://127.0.0.1:{view.server.port}/live?token={view.server.guard.token}"
        with websockets.connect(address, max_size=None) as browser:
            browser.send(json.dumps({"do": "panels", "names": ["auv0.sonar"]}))
            for _ in range(50):
                found = [
                    blob
                    for header, blob in records(browser.recv(timeout=60))
                    if header.get("name") == "auv0.sonar" and header.get("pictured")
                ]
                if found:
                    break
    assert found[0].endswith(b"\xff\xd9")  # the end of a JPEG


def test_current_is_drawn_where_it_sets(sim):
    assert currents_of(sim).shape == (0, 2, 3)  # still water
    sim.ocean.set(current=(0.3, -0.4, 0.0))
    lines = currents_of(sim)
    shafts = lines[: len(lines) // 3]
    ways = shafts[:, 1] - shafts[:, 0]
    assert len(shafts) >= 9
    assert ways[:, 2] == pytest.approx(0.0, abs=1e-6)
    assert ways[:, 1] / ways[:, 0] == pytest.approx(np.full(len(ways), -4 / 3), rel=1e-4)
    assert (ways[:, 0] > 0).all()
    assert shafts[:, :, 2] == pytest.approx(-float(sim.state["auv0"].depth[0]), abs=1e-4)
    barbs = lines[len(shafts) :]
    assert ((barbs[:, 1] - barbs[:, 0]) @ ways[0] < 0).all()  # they point back from the tip


def test_way_point_by_a_ray_of_the_scene(pilot):
    made, orders, said = pilot
    obey(made, orders, do="goal_seen", agent="auv0", eye=[10.0, -4.0, -5.0], way=[2.0, 1.0, -4.0])
    assert said == []
    assert made.goals["auv0"][0][:2] == pytest.approx([15.0, -1.5], abs=0.01)  # the ground is 10 m below the eye
    obey(made, orders, do="goal_seen", agent="auv0", eye=[10.0, -4.0, -5.0], way=[0.0, 0.3, 1.0])
    assert "nothing under the pointer" in said[-1][1]
    obey(made, orders, do="goal_seen", agent="auv0", eye=[10.0, None, -5.0], way=[0.0, 0.3, 1.0])
    assert "eye is a number" in said[-1][1]


def test_props_are_put_and_dragged_by_rays_of_the_scene(pilot):
    """They stand on what the ray meets: the ground at 15 m."""
    made, orders, said = pilot
    obey(made, orders, do="spawn_seen", shape="cylinder", size=1.6, eye=[10.0, -4.0, -5.0], way=[2.0, 1.0, -4.0])
    (body,) = made.sim.bodies.bodies
    assert body.position[0] == pytest.approx([15.0, -1.5, -14.2], abs=0.01)
    assert made.status()["props"] == [body.name]
    obey(made, orders, do="move_seen", name=body.name, eye=[10.0, -4.0, -5.0], way=[-1.0, -3.0, -4.0])
    assert body.position[0] == pytest.approx([7.5, -11.5, -14.2], abs=0.01)
    obey(made, orders, do="move_seen", name=body.name, eye=[10.0, -4.0, -5.0], way=[0.0, 0.0, 0.0])
    assert said[-1][1] == "the way of a ray has a length"
    obey(made, orders, do="move_seen", name="nothing", eye=[10.0, -4.0, -5.0], way=[0.0, 0.0, -1.0])
    assert "unknown prop 'nothing'" in said[-1][1]
    assert body.position[0] == pytest.approx([7.5, -11.5, -14.2], abs=0.01)


def test_no_browser_is_said_in_one_sentence(monkeypatch, capsys):
    monkeypatch.setattr("webbrowser.open", lambda url: False)
    say_where("http://127.0.0.1:1/?token=x", ViewOptions())
    assert "no browser was found here: open the address in one" in " ".join(capsys.readouterr().out.split())
    say_where("http://127.0.0.1:1/?token=x", ViewOptions(browser=False))
    assert "no browser" not in capsys.readouterr().out
