"""Plans, poses and counts of data sets by hand: shards of worlds, what is faced from where, and what a card counts."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.datasets.config import Poses
from pelagos.datasets.distribution import Distribution, stream
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.pose import INNER, PoseSource
from pelagos.datasets.rig import Rig
from pelagos.datasets.sample import Sample, Thing
from pelagos.datasets.shard import Statistics
from pelagos.sensors.camera.picture.annotations import Box
from pelagos.sensors.camera.picture.boxes_3d import Box3d

MOUNT = Rotation.from_euler("ZYX", [0.9, 0.4, -0.3])
LEVER = np.array([0.7, -0.4, 0.25])


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1)


# plans


def plan(**keys: Any) -> Plan:
    given = {"worlds": 4, "samples_per_world": 7, "shard_size": 3, "seed": 5, "split": {"train": 1.0}, **keys}
    return Plan(SimpleNamespace(**given), SimpleNamespace(), {})  # type: ignore[arg-type]


def test_shards_go_world_by_world_and_the_last_of_each_has_the_rest() -> None:
    made = plan()
    assert (made.shards_per_world, made.shards, made.samples) == (3, 12, 28)
    first = 0
    for index in range(12):
        shard, count = made.shard(index), (3, 3, 1)[index % 3]
        assert shard == Shard(index, index // 3, "train", first, count)
        first += count
    assert made.shard(11).name == "shard-000011"
    assert plan(samples_per_world=6).shard(1).count == 3


@pytest.mark.parametrize("worlds", [1, 2, 3, 7, 10, 23])
def test_worlds_are_shared_out_by_largest_remainder(worlds: int) -> None:
    """Hamilton's method: whole parts, then one each where the rest is largest; the order is that of the seed."""
    rng = np.random.default_rng(worlds)
    for _ in range(20):
        share = rng.dirichlet([2.0, 1.0, 1.0])
        split = dict(zip(("train", "val", "test"), share.tolist(), strict=True))
        found = plan(worlds=worlds, split=split).splits
        counts = np.floor(share * worlds).astype(int)
        for k in np.argsort(-(share * worlds - counts))[: worlds - counts.sum()]:
            counts[k] += 1
        assert [found.count(name) for name in split] == counts.tolist()
        assert found == plan(worlds=worlds, split=split).splits
    assert plan(worlds=23).splits == ["train"] * 23
    half = {"train": 0.5, "test": 0.5}
    assert len({tuple(plan(worlds=10, split=half, seed=k).splits) for k in range(5)}) > 1


def test_values_of_a_world_are_named_by_seed_world_and_key() -> None:
    vary = {"ocean.turbidity": Distribution(uniform=(2.0, 5.0)), "world.depth_m": Distribution(integer=(3, 9))}
    made = plan(vary=vary)
    vars(made)["_seeded"] = True
    for world in range(3):
        found = made.values(world)
        assert found["ocean.turbidity"] == stream(5, "world", world, "ocean.turbidity").uniform(2.0, 5.0)
        assert found["world.depth_m"] == stream(5, "world", world, "world.depth_m").integers(3, 10)
        assert found["world.seed"] == stream(5, "world", world, "seed").integers(2**31)
    given = plan(vary={"world.seed": Distribution(choice=(77,))})
    vars(given)["_seeded"] = True
    assert given.values(1) == {"world.seed": 77}
    plain = plan(vary={})
    vars(plain)["_seeded"] = False
    assert plain.values(0) == {}


def test_draws_reach_both_ends_and_no_further() -> None:
    random = stream(1, "draws")
    whole = [Distribution(integer=(2, 5)).draw(random) for _ in range(200)]
    assert set(whole) == {2, 3, 4, 5}
    picked = [Distribution(choice=("a", 7, None)).draw(random) for _ in range(100)]
    assert set(picked) == {"a", 7, None}
    normal = np.array([Distribution(normal=(-4.0, 0.5)).draw(random) for _ in range(2000)])
    assert abs(normal.mean() + 4) < 5 * 0.5 / math.sqrt(2000)
    assert abs(normal.std() / 0.5 - 1) < 5 / math.sqrt(4000)
    decades = np.array([Distribution(log_uniform=(0.01, 10.0)).draw(random) for _ in range(2000)])
    assert abs((decades < 0.1).mean() - 1 / 3) < 5 * math.sqrt(2 / 9 / 2000)
    assert [[*d.ends()] for d in (Distribution(normal=(3.0, 1.0)), Distribution(choice=(1, "b")))] == [[3.0], [1, "b"]]


# poses


class Sea:
    """A slope with nothing on it, but a ball at (5, -3) whose radius is 2 m; no ground west of 40 m."""

    bounds = np.array([[-20.0, -30.0, -40.0], [60.0, 50.0, 0.0]])
    user_labels: tuple[Any, ...] = ()
    geometries: tuple[Any, ...] = ()

    def height(self, x: Any, y: Any) -> Any:
        return np.where(np.asarray(y) > 40, np.nan, -25.0 + 0.1 * np.asarray(x))

    def inside(self, place: Any, radius: float) -> Any:
        return "ball" if math.dist(place, (5.0, -3.0, -10.0)) < 2.0 + radius else None


def source(boxes: list[Box3d] | None = None, **keys: Any) -> PoseSource:
    made = PoseSource(Poses(**keys), Sea(), (LEVER.tolist(), wxyz(MOUNT).tolist()))  # type: ignore[arg-type]
    made._objects = boxes or []
    return made


def test_a_faced_object_is_in_view_at_its_distance() -> None:
    """The place that is looked at, seen from the sensor: ahead, off the axis by both signs of both angles."""
    turn = Rotation.from_euler("ZYX", [0.5, 0.2, -0.7])
    size, centre = np.array([2.0, 4.0, 1.0]), np.array([1.0, 2.0, -12.0])
    made = source(
        [Box3d(7, 3, np.array([9.0, 9.0, -9.0]), np.zeros(3), np.eye(3)), Box3d(8, 3, centre, np.zeros(3), np.eye(3))],
        distance_m=(3.0, 8.0), off_axis_deg=20.0, facing=1.0, roll_deg=(-30, 40), pitch_deg=(-20, 35),
    )  # fmt: skip
    random, seen, faced = np.random.default_rng(3), [], set()
    for _ in range(90):
        pose = made.draw(random)
        body = Rotation.from_quat(np.roll(pose.attitude, -1))
        middle = next(b.centre for b in made._objects if b.instance == pose.facing)
        away = MOUNT.inv().apply(body.inv().apply(middle - pose.position) - LEVER)
        seen.append([np.linalg.norm(away), *np.degrees(np.arctan2(away[1:], away[0]))])
        faced.add(pose.facing)
    seen_ = np.array(seen)
    assert faced == {7, 8}
    assert (seen_[:, 0].min() >= 3.0 - 1e-9, seen_[:, 0].max() <= 8.0 + 1e-9, np.ptp(seen_[:, 0]) > 4) == (True,) * 3
    for angle in seen_[:, 1:].T:
        assert -20 - 1e-9 <= angle.min() < -15
        assert 15 < angle.max() <= 20 + 1e-9
    assert abs(np.corrcoef(seen_[:, 1:].T)[0, 1]) < 0.5
    near = source([Box3d(8, 3, centre, size, turn.as_matrix())], distance_m=(5.0, 5.0), off_axis_deg=0.0)
    points = []
    for _ in range(200):
        pose = near._faced(random, np.array([1.0, 0.0, 0.0, 0.0]))
        aimed = pose.position + LEVER + 5.0 * MOUNT.apply([1.0, 0.0, 0.0])
        points.append(turn.inv().apply(aimed - centre) / size)
    most = np.abs(points).max(axis=0)
    assert (most <= INNER + 1e-9).all()
    assert (most > 0.9 * INNER).all()
    assert (np.min(points, axis=0) < -0.9 * INNER).all()


def test_attitudes_are_compass_heading_pitch_up_and_roll_to_starboard() -> None:
    """In NED, Z Y X; the bow's elevation and bearing and the starboard side's are read off the axes."""
    made = source(roll_deg=(10, 20), pitch_deg=(-40, -30), heading_deg=(100, 130))
    random = np.random.default_rng(1)
    for _ in range(50):
        ahead, left, _ = Rotation.from_quat(np.roll(made._attitude(random), -1)).as_matrix().T
        assert 100 <= math.degrees(math.atan2(-ahead[1], ahead[0])) <= 130
        assert -40 <= math.degrees(math.asin(ahead[2])) <= -30
        assert 10 <= math.degrees(math.asin(left[2] / math.hypot(ahead[0], ahead[1]))) <= 20


def test_places_are_above_the_ground_or_below_the_surface() -> None:
    random = np.random.default_rng(2)
    high = np.array([source(area_m=((10, 20), (-15, -5)), altitude_m=(2, 5))._place(random) for _ in range(80)])
    above = high[:, 2] - (-25 + 0.1 * high[:, 0])
    assert (high[:, :2].min(axis=0) >= [-15, -5]).all()
    assert (high[:, :2].max(axis=0) <= [10, 20]).all()
    assert (np.ptp(high[:, :2], axis=0) > 20).all()
    assert 2 <= above.min() < 2.5 < 4.5 < above.max() <= 5
    deep = np.array([source(depth_m=(4, 9))._place(random)[2] for _ in range(80)])
    assert -9 <= deep.min() < -8 < -5 < deep.max() <= -4


def test_places_are_refused_for_what_is_there() -> None:
    made = source(area_m=((-10, -20), (30, 45)), clearance_m=1.5)
    for place, why in (
        ((0, 0, -5), None),
        ((np.nan, 0, -5), "no ground below"),
        ((0, 0, 0.1), "above the water"),
        ((0, 0, 0.0), None),
        ((-10.1, 0, -5), "outside the area"),
        ((0, 45.1, -5), "outside the area"),
        ((30.1, -20.1, -5), "outside the area"),
        ((10, 0, -22.4), None),
        ((10, 0, -22.6), "too near to the seabed"),
        ((0, 41, -35), None),
        ((5, -3, -6.6), "too near to something"),
        ((5, -3, -6.4), None),
    ):
        assert made._refused(np.array(place, dtype=float)) == why, place


# what is counted


def sample(z: float, *areas: int, facing: int | None = None, y: float = 0.0) -> Any:
    things = [Thing(Box(9, 4, 3, 2, 8, 6, area), k % 2, "ab"[k % 2], None) for k, area in enumerate(areas)]
    pose: Any = SimpleNamespace(
        position=np.array([10.0, y, z]), attitude=np.array([0.5, -0.5, 0.5, 0.5]), facing=facing
    )
    return Sample(12, 3, "val", pose, {}, things, {"drawn": 1})


def test_a_card_counts_samples_objects_areas_and_heights() -> None:
    found, maker = Statistics(), SimpleNamespace(simulation=SimpleNamespace(world=Sea()))
    for one in (sample(-5.0, 3, 4, 7, facing=2), sample(-8.25, y=41.0), sample(-20.5, 8, 2**21, 2**22, facing=0)):
        found.add(maker, one)  # type: ignore[arg-type]
    told = found.told
    assert (found.samples, told["facing"], told["without_objects"], told["objects"]) == (3, 2, 1, {"a": 4, "b": 2})
    areas = np.array(told["areas"])
    assert (len(areas), told["area_edges_px"][:3], told["area_edges_px"][-1]) == (21, [4, 8, 16], 2**21)
    assert {int(k): int(areas[k]) for k in np.flatnonzero(areas)} == {0: 1, 1: 2, 2: 1, 20: 2}
    assert (told["depth_m"], told["altitude_m"]) == ([5.0, 8.25, 20.5], [19.0, 3.5])


def test_a_sample_tells_its_pose_and_its_objects() -> None:
    told = sample(-5.0, 40, facing=9).meta
    assert (told["key"], told["world"], told["split"], told["drawn"]) == ("000000012", 3, "val", 1)
    assert (told["position_m"], told["attitude_wxyz"]) == ([10.0, 0.0, -5.0], [0.5, -0.5, 0.5, 0.5])
    (thing,) = told["objects"]
    assert (thing["class"], thing["class_number"], thing["area_px"]) == ("a", 0, 40)
    box = Box(9, 4, 3, 2, 8, 6, 40)
    assert thing["bbox_px"] == [box.column, box.row, box.width, box.height]
    space = Box3d(9, 4, np.array([1.0, 2, 3]), np.array([4.0, 5, 6]), np.diag([1.0, -1, -1]))
    one = Sample(1, 0, "train", sample(-1.0).pose, {}, [Thing(box, 0, "a", space)], {})
    assert one.meta["objects"][0]["box_3d"] == {
        "centre_m": [1, 2, 3], "size_m": [4, 5, 6], "rotation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    }  # fmt: skip


def test_cameras_of_labels_follow_the_view_of_their_camera_alone() -> None:
    rig = Rig({}, "rov", ("eye", "sonar", "eye_depth"), "eye", {"depth": "eye_depth", "instance": "eye_instance"})
    key = "agents.rov.sensors."
    given = {f"{key}eye.width_px": 64, f"{key}eye.rate_hz": 3, f"{key}side.height_px": 9, "ocean.turbidity": 2}
    found = rig.follow(given)
    assert found[f"{key}eye_depth.width_px"] == found[f"{key}eye_instance.width_px"] == 64
    assert not [name for name in set(found) - set(given) if name.rpartition(".")[2] not in ("width_px", "rate_hz")]
    assert rig.aim == "eye"
    assert Rig({}, "rov", ("sonar", "imu"), None, {}).aim == "sonar"
