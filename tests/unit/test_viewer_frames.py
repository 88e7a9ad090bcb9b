"""Poses and readings of frames: between two that were kept, of one copy, at the sensor's own time."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.sensors.sensor import Reading
from pelagos.viewer.course import Course
from pelagos.viewer.frame import ShownPose, between, old_after_s
from pelagos.viewer.live import _pose, own
from pelagos.viewer.marks import marks
from pelagos.viewer.orders import plain_name
from pelagos.viewer.replay import Replay
from pelagos.viewer.soundings import vehicle_place
from pelagos.viewer.view import View
from pelagos.viewer.water import compass


def pose(seed: int) -> ShownPose:
    rng = np.random.default_rng(seed)
    x, y, z, w = Rotation.random(random_state=seed).as_quat()
    q = np.array([w, x, y, z])
    return ShownPose(rng.normal(size=3) * 9, q if w > 0 else -q, rng.normal(size=3), rng.normal(size=2))


def same(a: ShownPose, b: ShownPose) -> bool:
    return all(np.array_equal(getattr(a, k), getattr(b, k)) for k in ("position", "velocity", "actuators")) and bool(
        abs(a.attitude @ b.attitude) > 1 - 1e-12
    )


def test_a_pose_says_where_points_of_its_body_are_and_where_it_looks() -> None:
    """R = Rz Ry Rx of forward-left-up in north-west-up: the compass counts clockwise, pitch is up where Ry is down."""
    roll, pitch, yaw = 0.3, -0.2, 0.7
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    x, y, z, w = turn.as_quat()
    found = ShownPose(np.array([3.0, -4.0, -5.0]), np.array([w, x, y, z]))
    assert found.euler == pytest.approx((np.degrees(roll), -np.degrees(pitch), 360 - np.degrees(yaw)))
    points = np.random.default_rng(2).normal(size=(5, 3))
    np.testing.assert_allclose(found.to_world(points), turn.apply(points) + found.position, atol=1e-12)


def test_all_of_a_pose_lies_between_two_others_and_never_beyond() -> None:
    a, b = pose(1), pose(2)
    found = between((100, a), (300, b), 150)
    np.testing.assert_allclose(found.position, 0.75 * a.position + 0.25 * b.position)
    np.testing.assert_allclose(found.velocity, 0.75 * a.velocity + 0.25 * b.velocity)
    np.testing.assert_array_equal(found.actuators, b.actuators)
    assert np.linalg.norm(found.attitude) == pytest.approx(1.0)
    assert abs(found.attitude @ a.attitude) > abs(found.attitude @ b.attitude)
    for t, end in ((20, a), (100, a), (300, b), (900, b)):
        held = between((100, a), (300, b), t)
        np.testing.assert_allclose(held.position, end.position, atol=1e-12)
        np.testing.assert_allclose(held.velocity, end.velocity, atol=1e-12)
        assert abs(held.attitude @ end.attitude) == pytest.approx(1.0)
    assert between((300, a), (300, b), 300) is b


def test_a_reading_is_drawn_at_the_pose_of_its_own_time() -> None:
    kept = [(100, pose(1)), (200, pose(2)), (400, pose(3))]
    frame: Any = SimpleNamespace(agents={"a": pose(9), "b": pose(8)})
    at = lambda t: _pose(kept, t, frame, "b")
    assert same(at(50), kept[0][1])
    assert same(at(400), kept[2][1])
    assert same(at(700), kept[2][1])
    np.testing.assert_allclose(at(100).position, kept[0][1].position)
    np.testing.assert_allclose(at(250).position, 0.75 * kept[1][1].position + 0.25 * kept[2][1].position)
    np.testing.assert_allclose(at(150).position, 0.5 * kept[0][1].position + 0.5 * kept[1][1].position)
    assert _pose([], 100, frame, "b") is frame.agents["b"]


def test_a_course_is_held_at_both_its_ends() -> None:
    poses = [pose(k) for k in range(3)]
    rows = (np.stack([getattr(p, k) for p in poses]) for k in ("position", "attitude", "velocity"))
    way = Course(np.array([10, 20, 50]), *rows)
    for t, expected in ((-5, poses[0].position), (10, poses[0].position), (20, poses[1].position),
                        (99, poses[2].position), (14, 0.6 * poses[0].position + 0.4 * poses[1].position),
                        (35, 0.5 * poses[1].position + 0.5 * poses[2].position)):  # fmt: skip
        np.testing.assert_allclose(way.at(t).position, expected, atol=1e-12)
    np.testing.assert_allclose(way.at(35).velocity, 0.5 * poses[1].velocity + 0.5 * poses[2].velocity)
    one = Course(np.array([10]), *(np.array([getattr(poses[1], k)]) for k in ("position", "attitude", "velocity")))
    assert [one.at(t).position.tolist() for t in (3, 10, 30)] == [poses[1].position.tolist()] * 3


@pytest.mark.parametrize(("size", "true"), [(8, True), (9, False)])
def test_one_copys_reading_has_its_truth_where_that_is_a_few_numbers(size: int, true: bool) -> None:
    rng = np.random.default_rng(size)
    data, truth = rng.normal(size=(2, 3, size))
    extras = {"angle": rng.normal(size=3), "altitude": rng.normal(size=3), "sigma": rng.normal(size=3)}
    found = own(Reading(data, truth, 7, "a/s", np.array([True, False, True]), extras, "dvl"), 1)
    np.testing.assert_array_equal(found.data, data[1:2])
    np.testing.assert_array_equal(found.truth, (truth if true else data)[1:2])
    assert {k: v.tolist() for k, v in found.extras.items()} == {k: [extras[k][1]] for k in ("angle", "altitude")}
    assert (found.t_ns, found.frame, found.valid.tolist(), found.kind) == (7, "a/s", [False], "dvl")


def test_what_a_sensor_said_is_old_after_three_intervals_or_a_second() -> None:
    assert [old_after_s(rate) for rate in (0.5, 2.0, 3.0, 50.0)] == [6.0, 1.5, 1.0, 1.0]


def test_fixes_after_a_pause_are_marked_and_no_more_than_sixty_of_all() -> None:
    """A GPS that is silent for more than 5 s twice; what lies outside of a recording is left out; by time."""
    at = {"gps": np.array([2.0, 3.0, 7.9, 13.0, 14.0, 19.1, 23.0]), "none": np.zeros(0)}
    recording: Any = SimpleNamespace(
        times=lambda topic: np.round(at[topic] * 1e9).astype(np.int64), count=lambda topic: len(at[topic])
    )
    kind = SimpleNamespace(type="gps", rate_hz=1.0)
    topics, sensors = {"a.gps": "gps", "b.gps": "none"}, {"a.gps": kind, "b.gps": kind}
    others = [{"t": 22.0, "text": "late"}, {"t": 17.0, "text": "leg"}, {"t": 1.0, "text": "early"}]
    found = marks(recording, topics, sensors, (1_500_000_000, 21_000_000_000), others)  # type: ignore[arg-type]
    assert [(m["t"], m["text"]) for m in found] == [(2, "GPS fix"), (13, "GPS fix"), (17, "leg"), (19.1, "GPS fix")]
    many = [{"t": 100.0 - k, "text": str(k)} for k in range(70)]
    found = marks(recording, {}, {}, (0, 10**12), many)
    assert [m["t"] for m in found] == [31.0 + k for k in range(60)]


def play(**changed: Any) -> Any:
    """A replay of nothing but its clock."""
    made: Any = object.__new__(Replay)
    made.__dict__ |= {
        "first_ns": 2 * 10**9, "last_ns": 30 * 10**9, "paused": True, "speed": 1.0, "_now": 10e9, "_jump": False,
        "_lock": threading.Lock(), "_wake": threading.Event(), "_clock": 0.0, **changed,
    }  # fmt: skip
    return made


@pytest.mark.parametrize(("to", "now", "jump"), [
    (11.9, 11.9, False), (12.1, 12.1, True), (9.9, 9.9, True), (10.0, 10.0, False), (0.5, 2.0, True), (99.0, 30.0, True)
])  # fmt: skip
def test_a_small_step_ahead_is_no_jump(to: float, now: float, jump: bool) -> None:
    source = play()
    assert source.obey({"do": "seek", "t": to})
    assert (source._now * 1e-9, source._jump) == (pytest.approx(now), jump)
    again = play(_jump=True)
    assert again.obey({"do": "seek", "t": 10.5})
    assert again._jump  # of the seek before, which nobody has seen yet


def test_a_recording_that_has_ended_begins_anew_when_it_is_let_go_on() -> None:
    source = play(_now=30e9)
    source.obey({"do": "pause", "paused": True})
    assert (source._now, source._jump) == (30e9, False)
    source.obey({"do": "pause", "paused": False})
    assert (source._now, source._jump, source.paused) == (2e9, True, False)
    source = play()
    source.obey({"do": "pause"})
    assert (source._now, source._jump, source.paused) == (10e9, False, False)


@pytest.mark.parametrize(("speed", "done", "then"), [(3, True, 3), (0, True, 20), (100, True, 100), (101, False, 1),
                                                     (-1, False, 1), ("fast", False, 1)])  # fmt: skip
def test_speeds_that_a_recording_is_played_at(speed: Any, done: bool, then: float) -> None:
    source = play()
    assert source.obey({"do": "speed", "speed": speed}) is done
    assert source.speed == then


def test_readings_that_are_due_are_those_since_the_last_frame_as_many_as_a_waterfall_shows() -> None:
    made: Any = object.__new__(Replay)
    made._times = {"t": np.arange(0, 5000, 10)}
    made._sensors = {"w": SimpleNamespace(type="sidescan"), "p": SimpleNamespace(type="imaging_sonar")}
    due = lambda name, t, since: (made._due(name, "t", t, since).start, made._due(name, "t", t, since).stop)
    assert due("w", 95, 40) == (5, 10)  # not the one at 40, which was shown
    assert due("w", 90, 40) == (5, 10)
    assert due("p", 95, 40) == (9, 10)
    assert due("p", 95, 90) == (10, 10)
    assert due("w", 4000, None) == (401 - 240, 401)
    assert due("w", 4000, 0) == (401 - 240, 401)
    assert due("p", 4000, None) == (400, 401)


def test_the_ground_follows_a_vehicle_that_has_moved_eight_metres() -> None:
    view: Any = object.__new__(View)
    asked: list[Any] = []
    view.scene = SimpleNamespace(look_at_ground=lambda x, y: asked.append((x, y)))
    view._looked_at = np.array([5.0, -3.0])
    for x, y in ((12.9, -10.9), (13.1, -3.0), (13.1, 4.9), (6.0, -11.1)):
        view._ground_follows(ShownPose(np.array([x, y, -4.0]), np.array([1.0, 0, 0, 0])))
    assert asked == [(13.1, -3.0), (6.0, -11.1)]


def test_the_water_is_looked_up_under_the_surface_at_the_first_vehicle() -> None:
    state = {"b": SimpleNamespace(position=np.array([[3.0, -4.0, 0.2], [9.0, 9.0, -9.0]])),
             "a": SimpleNamespace(position=np.array([[1.0, 2.0, -3.0]]))}  # fmt: skip
    sim = lambda *names: SimpleNamespace(model=SimpleNamespace(agents=dict.fromkeys(names)), state=state)
    assert vehicle_place(sim("b", "a")).tolist() == [3, -4, -0.5]  # type: ignore[arg-type]
    assert vehicle_place(sim("a", "b")).tolist() == [1, 2, -3]  # type: ignore[arg-type]
    assert vehicle_place(sim()).tolist() == [0, 0, -2]  # type: ignore[arg-type]
    assert state["b"].position[0, 2] == 0.2


def test_directions_of_the_compass_and_names_of_folders() -> None:
    assert [compass(*way) for way in ((1, 0), (0, -1), (-1, 0), (0, 2), (1, 1))] == pytest.approx(
        [0, 90, 180, 270, 315]
    )
    assert [plain_name(n) for n in ("Reef 1 (north)", "a-b_c", "  ", "../x")] == ["Reef_1_north", "a-b_c", "view", "x"]


def asked_of(*messages: dict[str, Any], kind: str = "live", seen: bool = True) -> tuple[Any, list[Any]]:
    """A view of nothing but what it does when browsers ask, and what it did."""
    done: list[Any] = []
    note = lambda name: lambda *values, **keys: done.append((name, *values, *keys.values()))
    view: Any = object.__new__(View)
    view.__dict__ |= {
        "subject": SimpleNamespace(vehicles={"a": 1, "b": 2}, kind=kind), "hub": SimpleNamespace(say=note("say")),
        "scene": SimpleNamespace(**{k: note(k) for k in ("show", "colour_ground", "look_at_ground")}),
        "panels": SimpleNamespace(panels={n: SimpleNamespace(fresh=False) for n in ("a.s", "b.s")}),
        "chart": SimpleNamespace(ask=note("ask"), survey=lambda: "relief", publish=note("publish")),
        "_wanted": {"x"}, "_followed": "a", "_looked_at": np.array([5.0, -3.0 if seen else np.inf]),
        "_asked": list(messages),
    }  # fmt: skip
    view._do_asked()
    assert view._asked == []
    return view, done


def test_a_view_does_what_browsers_ask_for() -> None:
    view, done = asked_of({"do": "follow", "agent": "b"}, {"do": "panels", "names": ["b.s", "c.s"]})
    assert (view._followed, view._wanted, done) == ("b", {"b.s", "c.s"}, [])
    assert [p.fresh for p in view.panels.panels.values()] == [False, True]
    view, done = asked_of({"do": "follow", "agent": "z"}, {"do": "panels"}, {"do": "x" * 99})
    assert (view._followed, view._wanted) == ("a", set())
    assert [d[0] for d in done] == ["say", "say"]
    assert "'follow'" in done[0][1]
    assert repr("x" * 40) in done[1][1]
    assert done[0][2] == "error"
    view, done = asked_of({"do": "look_at", "x": 3, "y": -4.5})
    assert (view._looked_at.tolist(), done) == ([3.0, -4.5], [("look_at_ground", 3.0, -4.5)])
    for wrong in ({"x": 3}, {"x": 3, "y": np.nan}, {"x": "3", "y": 4}):
        view, done = asked_of({"do": "look_at", **wrong})
        assert (view._looked_at.tolist(), done) == ([5.0, -3.0], [])
    _, done = asked_of({"do": "show", "what": "points"}, {"do": "show", "what": "a.s", "visible": True})
    assert done == [("show", "points", False), ("show", "a.s", True)]
    _, done = asked_of({"do": "ground", "by": "material"})
    assert done == [("colour_ground", "material"), ("look_at_ground", 5.0, -3.0)]
    _, done = asked_of({"do": "ground", "by": "material"}, seen=False)
    assert done == [("colour_ground", "material")]


@pytest.mark.parametrize(("kind", "drawn"), [("live", False), ("replay", True), ("world", True)])
def test_the_ground_of_a_simulation_is_looked_at_by_the_thread_that_steps(kind: str, drawn: bool) -> None:
    message = {"do": "chart", "bounds": [1, 2, 3, 4]}
    view, done = asked_of(message, kind=kind)
    assert done == [("ask", message), *([("publish", view.hub, "relief")] if drawn else [])]


def test_a_long_step_is_told_each_second_and_its_end_once() -> None:
    view: Any = object.__new__(View)
    told: list[Any] = []
    view.hub = SimpleNamespace(publish=lambda key, header: told.append((key, header["s"])))
    view._told_s = 0
    for waited in (0.0, 1.99, 2.0, 2.7, 3.1, 0.4, 0.2):
        view.waited_s = lambda waited=waited: waited
        view._tell_of_waiting()
    assert told == [("waiting", 2), ("waiting", 3), ("waiting", 0)]
