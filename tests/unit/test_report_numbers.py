"""What reports count and draw, beside formulas of their own, at mounts, headings and places that are unequal."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.messages.soundings import POINT
from pelagos.report import navigation, soundings, swarm, track
from pelagos.report.mission import Mission, RecordedMotion
from pelagos.report.soundings import Grid, accuracy, grid
from pelagos.report.statistics import sensor_table
from pelagos.report.survey import _difference, _draw_cells, _histogram
from pelagos.report.swarm import Swarm, _approaches, _density, _felt, swarm_section, swarms
from pelagos.sim.replay import Channel

RNG = np.random.default_rng(12)
TURN = Rotation.from_euler("ZYX", [0.7, -0.3, 0.4])
LEVER = np.array([0.8, -0.5, 0.3])


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def motion(t: Any, seed: int = 1) -> RecordedMotion:
    """Smooth in all components."""
    rng, t = np.random.default_rng(seed), np.asarray(t, dtype=np.float64)
    wave = lambda size: rng.normal(size=size) + np.sin(np.outer(t, rng.uniform(0.1, 0.4, size)) + rng.normal(size=size))
    attitude = Rotation.from_euler("ZYX", 0.4 * wave(3))
    return RecordedMotion(t, 5 * wave(3), wxyz(attitude), wave(3))


class Told(Mission):
    """A mission whose tables, mounts and motion are given."""

    def __init__(self, **given: Any) -> None:
        vars(self).update(agent="auv", _tables={}, given=given, **{k: given[k] for k in ("motion",) if k in given})
        about = {"latitude_deg": "12.5", "longitude_deg": "-7.25"}
        vars(self)["recording"] = SimpleNamespace(metadata=about, channels={}, attachments={})

    def table(self, sensor_type: str, message_type: str, fields: Any) -> Any:
        return self.given.get(sensor_type)

    def mount(self, sensor_type: str) -> Any:
        return self.given.get("mounts", {}).get(sensor_type, (np.zeros(3), np.array([1.0, 0, 0, 0])))


# the motion


def test_a_motion_at_other_times_is_drawn_between_its_samples_and_held_beyond() -> None:
    had = RecordedMotion(
        np.array([1.0, 2.0, 4.0]), RNG.normal(size=(3, 3)), RNG.normal(size=(3, 4)), RNG.normal(size=(3, 3))
    )
    found = had.at(np.array([0.0, 1.25, 1.75, 2.9, 3.1, 9.0]))
    assert found.t.tolist() == [0.0, 1.25, 1.75, 2.9, 3.1, 9.0]
    for got, values in ((found.position, had.position), (found.velocity, had.velocity)):
        a, b, c = values
        np.testing.assert_allclose(got, [a, 0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b, 0.55 * b + 0.45 * c,
                                         0.45 * b + 0.55 * c, c], rtol=1e-12, atol=1e-14)  # fmt: skip
    np.testing.assert_array_equal(found.attitude, had.attitude[[0, 0, 1, 1, 2, 2]])


def test_the_table_of_sensors_counts_their_messages_and_rate() -> None:
    """A sensor with three topics is one row: the longest count, and the rate of the first that has one."""
    times = {"/auv/dvl/a": [5], "/auv/dvl/twist": [0, 200, 400, 1000], "/auv/dvl/dvl": [0, 100], "/auv/gps/fix": [],
             "/boat/gps/fix": [1, 2], "/auv/truth": [3]}  # fmt: skip
    about = {t: {"sensor": t.split("/")[2], "type": "x" + t.split("/")[2], "rate_hz": "2.5"} for t in times}
    about["/auv/truth"] = {"agent": "auv"}
    channels = {t: Channel(t, f"kind of {t}", about[t]) for t in times}
    recording: Any = SimpleNamespace(channels=channels, times=lambda t: np.array(times[t], dtype=np.int64) * 10**6)
    dvl, gps = sensor_table(Mission(recording, "auv"))
    assert dvl == {"sensor": "dvl", "type": "xdvl", "rate_hz": 2.5, "count": 4, "recorded_hz": pytest.approx(3.0),
                   "messages": [f"kind of /auv/dvl/{t}" for t in ("a", "twist", "dvl")]}  # fmt: skip
    assert (gps["count"], gps["recorded_hz"]) == (0, None)


# dead reckoning


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    (a, u), (b, v) = (p[0], p[1:]), (q[0], q[1:])
    return np.array([a * b - u @ v, *(a * v + b * u + np.cross(u, v))])


@pytest.mark.parametrize("push", [0.3, -0.3, 0.7, -0.7])
@pytest.mark.parametrize("magnetic", [True, False])
def test_a_step_of_the_filter_turns_towards_gravity_and_north(push: float, magnetic: bool) -> None:
    """Mahony et al. 2008: dq/dt = q (0, w) / 2, w the gyroscopes' plus the errors' axes by their time constants."""
    q, rate, h = wxyz(TURN), np.array([0.2, -0.15, 0.35]), 0.05
    up = TURN.inv().apply([0.3, -0.2, 1.0])
    up *= (9.80665 + push) / np.linalg.norm(up)
    field, declined = np.array([0.4, 0.9, -0.5]), 0.25
    world_up = TURN.inv().apply([0.0, 0.0, 1.0])
    w = rate + (np.cross(up / np.linalg.norm(up), world_up) / 20.0 if abs(push) < 0.5 else 0.0)
    if magnetic:
        north, west, _ = TURN.apply(field)
        w = w + math.remainder(declined - math.atan2(west, north), 2 * math.pi) / 30.0 * world_up
    expected = q + 0.5 * h * product(q, np.array([0.0, *w]))
    given = [*field.tolist(), declined] if magnetic else None
    found = navigation._turned(tuple(q.tolist()), rate.tolist(), up.tolist(), given, h)
    np.testing.assert_allclose(found, expected / np.linalg.norm(expected), rtol=1e-12)


def test_the_filter_starts_level_and_along_its_field_or_the_true_heading() -> None:
    """By what the sensors of a body at rest say; a turn at speed takes its centripetal part away."""
    velocity, rate = np.array([[1.5, -0.4, 0.2]]), np.array([[0.1, -0.05, 0.3]])
    force = TURN.inv().apply([0.0, 0.0, 9.81])[None] + np.cross(rate, velocity)
    field = np.concatenate([TURN.inv().apply([math.cos(0.25), math.sin(0.25), -1.0]), [0.25]])[None]
    true = RecordedMotion(np.zeros(1), np.zeros((1, 3)), wxyz(Rotation.from_euler("ZYX", [[-1.1, 0.2, 0.1]])), velocity)
    for given, yaw in ((field, 0.7), (None, -1.1)):
        found = navigation._attitude(np.zeros(1), rate, force, velocity, given, true)[0]
        expected = Rotation.from_euler("ZYX", [yaw, -0.3, 0.4])
        assert abs(found @ wxyz(expected)) == pytest.approx(1.0, abs=1e-12)


def test_gyroscopes_are_averaged_and_a_logs_velocity_is_that_of_the_origin() -> None:
    mission = Told(mounts={"imu": (LEVER, wxyz(TURN)), "dvl": (LEVER, wxyz(TURN.inv()))})
    t, values = 3.0 + 0.01 * np.arange(23), RNG.normal(size=(23, 6))
    times, rate, force = navigation._averaged(t, values, mission)
    np.testing.assert_allclose(times, 3.0 + 0.05 * np.arange(4))
    for k in range(4):
        mean = values[5 * k : 5 * k + 5].mean(axis=0)
        np.testing.assert_allclose(rate[k], TURN.apply(mean[:3]), rtol=1e-12)
        np.testing.assert_allclose(force[k], TURN.apply(mean[3:]), rtol=1e-12)
    log = RNG.normal(size=(3, 6))
    found = navigation._dvl_on(times, np.array([3.0, 3.1, 3.4]), log, rate, mission)
    for k, share in enumerate((0.0, 0.5)):
        seen = TURN.inv().apply((1 - share) * log[0, :3] + share * log[1, :3])
        np.testing.assert_allclose(found[k] + np.cross(rate[k], LEVER), seen, rtol=1e-12)


def test_dead_reckoning_starts_from_the_first_fix_and_counts_its_drift() -> None:
    """With a fix that is off by a known step; its track is the sum of its own velocities."""
    truth = motion(np.arange(0.0, 12.0, 0.05))
    t, imu = truth.t, RNG.normal([0.0] * 5 + [9.8], [0.02] * 3 + [0.1] * 3, (240, 6))
    dvl, depth = RNG.normal(size=(240, 6)) * 0.3 + 0.5, RNG.uniform(3.0, 4.0, (50, 1))
    off, first = np.array([2.0, -1.5, 0.7]), truth.at(np.array([1.2]))
    antenna = first.position[0] + Rotation.from_quat(np.roll(first.attitude[0], -1)).apply(LEVER) + off
    origin = navigation.origin(Told())
    assert (origin.latitude, origin.longitude) == (12.5, -7.25)
    fix = origin.to_geodetic(antenna[None])
    given = {"motion": truth, "imu": (t, imu), "dvl": (t, dvl), "depth": (np.linspace(0, 12, 50), -depth),
             "gps": (np.array([1.2, 1.3]), np.stack([fix[0], fix[0] + 0.1])),
             "mounts": {"gps": (LEVER, None)}}  # fmt: skip
    found = navigation.dead_reckoning(Told(**given))
    assert found is not None
    assert found.start == "gps"
    np.testing.assert_allclose(found.motion.position[0, :2], truth.position[0, :2] + off[:2], atol=1e-5)
    turns = Rotation.from_quat(np.roll(found.motion.attitude, -1, axis=1))
    steps = turns.apply(dvl[:, :3])[:-1] * 0.05
    way = found.motion.position[0, :2] + np.cumsum(steps, axis=0)[:, :2]
    np.testing.assert_allclose(found.motion.position[1:, :2], way, atol=1e-9)
    np.testing.assert_allclose(found.motion.position[:, 2], np.interp(t, np.linspace(0, 12, 50), -depth[:, 0]))
    away = (found.motion.position - truth.position)[:, :2]
    np.testing.assert_allclose(found.error, np.linalg.norm(away, axis=1), rtol=1e-9)
    np.testing.assert_allclose(found.drift, np.linalg.norm(away - away[0], axis=1), atol=1e-9)
    lengths = [math.dist(a, b) for a, b in zip(truth.position[:-1, :2], truth.position[1:, :2], strict=True)]
    np.testing.assert_allclose(found.distance, [0.0, *np.cumsum(lengths)], atol=1e-9)
    late = navigation.dead_reckoning(Told(**given | {"gps": (np.array([2.1]), fix)}))
    assert late is not None
    assert late.start == "truth"
    np.testing.assert_allclose(late.motion.position[0, :2], truth.position[0, :2])


# soundings


def test_soundings_stand_where_the_pose_and_the_mount_put_them() -> None:
    truth = motion(np.arange(0.0, 3.0, 0.5))
    local = RNG.normal(size=(3, 4, 3)).astype(np.float32)
    local[1, 2] = np.nan
    clouds = np.zeros((3, 4), dtype=POINT)
    for i, name in enumerate("xyz"):
        clouds[name] = local[..., i]
    messages = [
        SimpleNamespace(t_ns=int(k * 5e8), message=SimpleNamespace(data=c.tobytes())) for k, c in enumerate(clouds, 1)
    ]
    mission: Any = SimpleNamespace(
        channels=lambda *_: [SimpleNamespace(topic="/auv/mb", about={"sensor": "mb"})], motion=truth,
        recording=SimpleNamespace(messages=lambda topic: messages), mounts={"mb": (LEVER, wxyz(TURN))},
    )  # fmt: skip
    found = soundings.collect(mission)
    assert found is not None
    turns = Rotation.from_quat(np.roll(truth.attitude, -1, axis=1))
    expected = [
        turns[k + 1].apply(TURN.apply(local[k, i].astype(float)) + LEVER) + truth.position[k + 1]
        for k in range(3) for i in range(4) if (k, i) != (1, 2)
    ]  # fmt: skip
    np.testing.assert_allclose(found.points, expected, rtol=1e-6, atol=1e-6)
    assert (found.pings, found.beams, found.share) == (3, 4, 11 / 12)


def test_cells_are_square_and_hold_their_own_points() -> None:
    points = RNG.uniform([-20.0, 5.0, -9.0], [20.0, 30.0, -3.0], (3000, 3))
    found = grid(points, cells=30)
    low, high = np.percentile(points[:, :2], [0.25, 99.75], axis=0)
    assert found.cell == 2.0  # 39.9 m by 30 cells, to the next of 1, 2, 5
    assert (len(found.x), len(found.y)) == (math.ceil((high - low)[0] / 2), math.ceil((high - low)[1] / 2))
    for i, j in ((0, 0), (3, 7), (len(found.x) - 1, len(found.y) - 1), (11, 2)):
        inside = (abs(points[:, 0] - found.x[i]) < 1) & (abs(points[:, 1] - found.y[j]) < 1)
        assert found.count[i, j] == inside.sum() > 0
        assert found.mean[i, j] == pytest.approx(points[inside, 2].mean())
    assert found.x[0] == pytest.approx(low[0] + 1)
    assert grid(points[:50] * 1e-3).cell == 0.1
    for value, up in ((0.0, 0.0), (-1.0, 0.0), (0.1, 0.1), (0.11, 0.2), (2.1, 5.0), (51.0, 100.0)):
        assert soundings._round_up(value) == pytest.approx(up)


def test_what_stands_on_the_ground_is_no_error_of_the_soundings() -> None:
    """Of a thousand, sixty lie 3 m higher, forty 2 m lower, and fifty have no ground below them."""
    xy = RNG.uniform(0.0, 10.0, (1000, 2))
    error = RNG.normal(0.2, 0.05, 1000)
    error[:60] += 3.0
    error[60:100] -= 2.0
    ground = lambda x, y: np.where(y > 9.99, np.nan, -20 + 0.3 * x - 0.1 * y)
    points = np.column_stack([xy, ground(*xy.T) + error])
    points[900:950, 1], points[900:950, 2] = 9.995, -20.0
    cells = Grid(np.arange(0.5, 10), np.arange(0.5, 10), 1.0, np.zeros((10, 10)), np.zeros((10, 10), dtype=np.int64))
    found = accuracy(points, cells, ground)
    assert found is not None
    kept = np.isfinite(ground(*points.T[:2])) & (np.arange(1000) >= 100)
    assert found.limit == 0.5  # six robust deviations of 0.05 to 0.06 m, to the next of 1, 2, 5
    np.testing.assert_allclose(np.sort(found.error), np.sort((points[:, 2] - ground(*points.T[:2]))[kept]))
    assert (found.bias, found.std) == (pytest.approx(found.error.mean()), pytest.approx(found.error.std()))
    assert found.elsewhere == pytest.approx(100 / np.isfinite(ground(*points.T[:2])).sum())
    inside = kept & (points[:, 0] // 1 == 3) & (points[:, 1] // 1 == 6)
    assert found.cells[3, 6] == pytest.approx(points[inside, 2].mean())


def test_maps_run_east_and_north() -> None:
    """A column of cells runs west, a picture's east: its middle is where the cells' is."""
    x, y = np.array([10.0, 12.0, 14.0]), np.array([-7.0, -5.0])
    mean, true = RNG.normal(size=(2, 3, 2))
    cells = Grid(x, y, 2.0, mean, np.ones((3, 2), dtype=np.int64))
    found: Any = SimpleNamespace(cells=mean + 1, std=0.2)
    for given, shift, limit in ((None, 0.0, 0.5), (found, 1.0, pytest.approx(0.6))):
        axes = MagicMock()
        _difference(axes, cells, true, given)
        (shown,), keys = axes.imshow.call_args
        np.testing.assert_allclose(shown, (mean + shift - true)[:, ::-1])
        assert (keys["extent"], keys["origin"]) == ((4.0, 8.0, 9.0, 15.0), "lower")
        assert (keys["vmin"], keys["vmax"]) == (-limit if given is None else pytest.approx(-0.6), limit)
    axes, hole = MagicMock(), mean.copy()
    hole[0, 0] = np.nan
    from matplotlib.colors import Normalize

    _draw_cells(axes, cells, hole, Normalize(-2, 2))
    (shown,), keys = axes.imshow.call_args
    pale = np.isclose(shown, (0.933, 0.945, 0.957)).all(axis=-1)
    assert (pale.tolist(), keys["extent"]) == ([[False, True], [False, False], [False, False]], (4.0, 8.0, 9.0, 15.0))


def test_the_histogram_says_how_far_most_soundings_are_off_to_either_side() -> None:
    """95 of 100 errors lie within 19 cm, of which 15 are too deep."""
    error = np.concatenate([np.linspace(-0.19, -0.01, 15), np.linspace(0.01, 0.12, 80), np.linspace(-0.5, -0.3, 5)])
    axes = MagicMock()
    _histogram(axes, SimpleNamespace(error=error, bias=float(error.mean()), std=float(error.std())))
    told = axes.text.call_args.args[2]
    assert float(re.search(r"95 % within ([\d.]+) cm", told)[1]) == pytest.approx(19.0, abs=0.7)  # of the next, 30 cm
    assert f"bias {100 * error.mean():+.1f} cm" in told


def test_a_map_is_not_narrower_than_half_its_length_and_ends_at_the_worlds_edge() -> None:
    wide = np.array([[-1e4, -1e4], [1e4, 1e4]])
    points = np.array([[3.0, 40.0], [7.0, 140.0], [5.0, 60.0]])
    low, high = track.around(points, wide, margin=0.1)
    np.testing.assert_allclose([low, high], [[5 - 25 - 5, 90 - 50 - 5], [5 + 25 + 5, 90 + 50 + 5]])
    low, high = track.around(points, np.array([[-10.0, 0.0], [1e4, 142.0]]), margin=0.1)
    room = 0.02 * 55
    np.testing.assert_allclose([low, high], [[-10 - room, 35.0], [35.0, 142 + room]])
    low, high = track.around(points, np.array([[0.0, 50.0], [1e4, 130.0]]), margin=0.1)  # that some points are beyond
    np.testing.assert_allclose([low, high], [[-room, 40 - room], [35.0, 140 + room]])
    low, high = track.around(points[:1], wide, margin=0.0)
    np.testing.assert_allclose([low, high], [[-2, 35], [8, 45]])


# swarms


def school() -> Swarm:
    """Sixteen members of unequal ways, four samples."""
    rng = np.random.default_rng(8)
    members: list[Any] = [SimpleNamespace(name=f"auv_{i}") for i in range(16)]
    t = np.array([0.0, 1.0, 3.0, 4.0])
    return Swarm("auv", members, t, rng.uniform(-30, 30, (4, 16, 3)), np.array([[1.0, 2.0]]))


def test_the_nearest_of_each_member_and_the_pairs_that_came_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    found = school()
    away, whom = found.nearest
    pairs: dict[tuple[str, str], tuple[float, float]] = {}
    for i in range(16):
        mine = {}
        for k in range(4):
            distances = {j: math.dist(found.position[k, i], found.position[k, j]) for j in range(16) if j != i}
            other = min(distances, key=lambda j: distances[j])
            assert (away[k, i], whom[k, i]) == (pytest.approx(distances[other]), other)
            mine[distances[other]] = (k, other)
        least = min(mine)
        k, other = mine[least]
        pair = (f"auv_{min(i, other)}", f"auv_{max(i, other)}")
        pairs[pair] = min(pairs.get(pair, (np.inf, 0.0)), (least, found.t[k]))
    told = _approaches(found, away, whom)
    expected = sorted((d, *pair, t) for pair, (d, t) in pairs.items())[:5]
    assert [(c["member"], c["to"], c["t_s"]) for c in told] == [(a, b, t) for _, a, b, t in expected]
    np.testing.assert_allclose([c["distance_m"] for c in told], [d for d, *_ in expected])
    monkeypatch.setattr(swarm, "_figure", lambda *_: None)
    monkeypatch.setattr(swarm.theme, "as_png", lambda drawn: b"")
    numbers: dict[str, Any] = {}
    text = swarm_section(found, None, numbers).text
    way = [sum(math.dist(*found.position[k : k + 2, i]) for k in range(3)) for i in range(16)]
    said = numbers["swarms"]["auv"]
    assert said["way_m"] == {"mean": pytest.approx(np.mean(way)), "least": pytest.approx(min(way))}
    assert said["separation_m"] == {"least": pytest.approx(away.min()), "median": pytest.approx(np.median(away))}
    assert (said["members"], said["contacts"], "felt 1 contacts" in text) == (16, 1, True)


def test_density_is_vehicle_seconds_on_a_hectare() -> None:
    """All of the time of all of the members, each where it was: east runs to the right, north up."""
    found, axes = school(), MagicMock()
    low, high = np.array([-40.0, -35.0]), np.array([40.0, 35.0])
    _density(MagicMock(), axes, found, low, high)
    (east, north, count), _ = axes.pcolormesh.call_args
    spent = [1.0, 1.5, 1.5, 1.0]  # half of the steps before and behind; at the ends the whole one
    size = 80 / 60
    assert float(count.sum()) * size**2 * 1e-4 == pytest.approx(16 * sum(spent))
    for k in range(4):
        x, y = found.position[k, 2, :2]
        (i,), (j,) = np.nonzero((north[:-1] <= x) & (x < north[1:])), np.nonzero((east[1:] < -y) & (-y <= east[:-1]))
        assert float(count[i[0], j[0]]) >= spent[k] / (size**2 * 1e-4) - 1e-9


def test_contacts_are_counted_where_they_begin() -> None:
    forces = {"a": [0, 0, 2e-3, 5, 0, 1], "b": [3, 3, 0, 0.5e-3, 0, 2e-3]}

    def member(name: str, carries: bool) -> Any:
        values = np.zeros((6, 8))
        values[:, 3] = forces.get(name, 0)
        values[:, 5:] = 9.0  # moments
        recording = SimpleNamespace(table=lambda topic, fields: (np.arange(6) * 0.5, values))
        return SimpleNamespace(channels=lambda *_: [SimpleNamespace(topic="")] * carries, recording=recording)

    assert _felt([member("a", False)]) is None
    found = _felt([member("", False), member("a", True), member("b", True)])
    assert found is not None
    assert found.tolist() == [[0.0, 2.0], [1.0, 1.0], [2.5, 1.0], [2.5, 2.0]]


def test_a_group_is_a_swarm_from_five_members_with_motion_on() -> None:
    agents = {"auv": {"count": 7}, "usv": {"count": 4}, "boat": {"vehicle": "otter"}, "none": None}
    names = [f"auv_{i}" for i in range(7)] + [f"usv_{i}" for i in range(4)] + ["boat", "auv_7"]
    made: list[Any] = []
    for k, name in enumerate(names):
        t = np.arange(1 if name == "auv_0" else 4 + k) * 0.5 + 0.1 * k
        made.append(
            SimpleNamespace(name=name, motion=motion(t, k), scenario={"agents": agents}, channels=lambda *_: [])
        )
    (found,) = swarms(made)
    assert (found.name, [m.name for m in found.members]) == ("auv", [f"auv_{i}" for i in range(1, 7)])
    np.testing.assert_array_equal(found.t, made[1].motion.t)
    for axis, along in enumerate(made[4].motion.position.T):
        np.testing.assert_allclose(found.position[:, 3, axis], np.interp(found.t, made[4].motion.t, along), rtol=1e-12)
    assert (found.contacts, swarms([])) == (None, [])
