"""LiDARs: geometry of the pattern, intensity and dropout as CARLA's documentation defines them, water."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.suspended import with_suspended
from pelagos.optics.water import REFRACTIVE_INDEX, water_optics
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.lidar.lidar import Lidar, LidarConfig, points
from pelagos.sensors.lidar.semantic_lidar import SemanticLidar, SemanticLidarConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables

CLEAN: dict[str, Any] = {"dropoff_general_rate": 0.0, "dropoff_zero_intensity": 0.0, "atmosphere_attenuation_rate": 0.0}


def box(half: float, *, inside: bool = True) -> Geometry:
    """A cube around the origin, label 53."""
    import trimesh

    mesh = trimesh.creation.box(extents=[2 * half] * 3)
    faces = np.array(mesh.faces, dtype=np.uint32)
    corners = np.array(mesh.vertices) + np.array([0, 0, 50.0])
    return Geometry(corners, faces[:, ::-1] if inside else faces, 0, 53, 4)


def floor(z: float) -> Geometry:
    corners = np.array([[-300, -300, z], [300, -300, z], [300, 300, z], [-300, 300, z]], dtype=float)
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 2)


def context(geometries: list[Geometry], *, copies: int = 1) -> SensorContext:
    materials = [MATERIALS["sand"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials))
    ocean = lit_ocean("IB")
    scene = Scene(geometries, copies=copies)
    return SensorContext("auv0.lidar", 1, 5_000_000, scene, world, ocean, np.full(copies, NO_BODY, np.uint32))


def at(
    height: float, *, t_s: float = 0.0, tick: int = 0, copies: int = 1, first: int = 0, velocity: Any = (0, 0, 0)
) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, copies), dr.zeros(jit.UInt32, copies)

    def vector(x: float, y: float, z: float) -> Any:
        return jit.Array3f64(zero + x, zero + y, zero + z)

    motion = Kinematics(
        position=vector(0, 0, height),
        attitude=jit.Array4f64(zero + 1, zero, zero, zero),
        velocity=vector(*velocity),
        angular_velocity=vector(0, 0, 0),
        acceleration=vector(0, 0, 0),
        angular_acceleration=vector(0, 0, 0),
        t_ns=jit.UInt64(u) + round(t_s * 1e9),
        tick=u + tick,
        environment=dr.arange(jit.UInt32, copies) + first,
        copy=dr.arange(jit.UInt32, copies),
    )
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def test_points_lie_on_the_walls_and_rings_on_their_cones():
    config = LidarConfig(channels=8, points_per_second=8 * 360 * 10, upper_fov_deg=20, lower_fov_deg=-50, **CLEAN)
    got = Lidar(config, context([box(12.0)])).sense(at(50.0)).data[0]
    assert got.shape == (8, 360, 4)
    xyz = got[..., :3]
    assert np.abs(xyz).max(axis=-1) == pytest.approx(12.0, rel=1e-5)
    elevation = np.degrees(np.arctan2(xyz[..., 2], np.hypot(xyz[..., 0], xyz[..., 1])))
    assert elevation == pytest.approx(np.broadcast_to(np.linspace(20, -50, 8)[:, None], (8, 360)), abs=1e-3)


def test_a_full_turn_is_covered_once_and_clockwise():
    config = LidarConfig(channels=1, points_per_second=3600, upper_fov_deg=0, lower_fov_deg=0, **CLEAN)
    xyz = Lidar(config, context([box(12.0)])).sense(at(50.0, t_s=0.1)).data[0, 0, :, :3]
    azimuth = np.degrees(np.unwrap(np.arctan2(xyz[:, 1], xyz[:, 0])))
    assert np.diff(azimuth) == pytest.approx(-1.0, abs=2e-3)
    assert abs(azimuth[0]) == pytest.approx(180, abs=1e-3)


def test_part_turns_follow_one_another():
    config = LidarConfig(channels=1, rate_hz=40.0, points_per_second=3600, upper_fov_deg=0, lower_fov_deg=0, **CLEAN)
    lidar = Lidar(config, context([box(12.0)]))
    turns = [lidar.sense(at(50.0, t_s=k * 0.025)).data[0, 0, :, :3] for k in (1, 2, 3, 4)]
    angles = np.degrees(np.unwrap(np.concatenate([np.arctan2(p[:, 1], p[:, 0]) for p in turns])))
    said = [lidar.sense(at(50.0, t_s=k * 0.025)).extras["horizontal_angle_rad"][0] for k in (1, 2, 3, 4)]
    assert np.degrees(said) == pytest.approx([90, 180, 270, 0], abs=1e-6)
    assert len(angles) == 360
    assert np.diff(angles) == pytest.approx(-1.0, abs=2e-3)


def test_intensity_falls_with_the_way_in_air_and_in_water():
    air = LidarConfig(channels=4, **(CLEAN | {"atmosphere_attenuation_rate": 0.01}))
    got = Lidar(air, context([box(12.0)])).sense(at(50.0)).data[0]
    d = np.linalg.norm(got[..., :3], axis=-1)
    assert got[..., 3] == pytest.approx(np.exp(-0.01 * d), rel=1e-5)
    water = LidarConfig(channels=4, lower_fov_deg=-60, upper_fov_deg=-30, **CLEAN)
    got = Lidar(water, context([floor(-9.0)])).sense(at(-5.0)).data[0]
    d = np.linalg.norm(got[..., :3], axis=-1)
    assert got[..., 3] == pytest.approx(np.exp(-2 * water_optics("IB").attenuation[1] * d), rel=1e-4)


def test_murky_water_dims_the_points():
    """Twice the green beam attenuation of the water with its sediment and plankton, at the scanner."""
    ocean = build_ocean(OceanConfig(water_type="IB", tracers={"turbidity": 1.5, "chlorophyll": 0.8}), None)
    config = LidarConfig(channels=4, lower_fov_deg=-60, upper_fov_deg=-30, **CLEAN)
    got = Lidar(config, replace(context([floor(-9.0)]), ocean=ocean)).sense(at(-5.0)).data[0]
    clear = water_optics("IB").arrays()
    murky = with_suspended(clear, jit.Float(0.8), jit.Float(1.5)).attenuation[1].numpy()[0]
    assert murky > 1.5 * water_optics("IB").attenuation[1]
    assert got[..., 3] == pytest.approx(np.exp(-2 * murky * np.linalg.norm(got[..., :3], axis=-1)), rel=1e-4)


def test_general_dropout_is_a_share():
    config = LidarConfig(channels=16, points_per_second=400_000, **(CLEAN | {"dropoff_general_rate": 0.45}))
    got = Lidar(config, context([box(12.0)])).sense(at(50.0)).data[0]
    n = got.shape[0] * got.shape[1]
    lost = np.isnan(got[..., 0]).mean()
    assert lost == pytest.approx(0.45, abs=4 * math.sqrt(0.45 * 0.55 / n))


@pytest.mark.parametrize(("rate", "kept"), [(0.5, None), (0.0, 1.0)])
def test_weak_points_drop_as_documented(rate: float, kept: float | None):
    """Kept: 1 from the limit on, falling linearly to 1 - p0 at intensity 0."""
    keys = CLEAN | {
        "dropoff_zero_intensity": 0.4,
        "dropoff_intensity_limit": 0.8,
        "atmosphere_attenuation_rate": rate / 12,
    }
    config = LidarConfig(channels=64, points_per_second=1_000_000, upper_fov_deg=1, lower_fov_deg=-1, **keys)
    got = Lidar(config, context([box(12.0)])).sense(at(50.0))
    here = np.isfinite(got.data[0, ..., 0])
    expected = 1 - 0.4 * (1 - got.truth[0, ..., 3] / 0.8).clip(0, None)
    n = expected.size
    assert here.mean() == pytest.approx(expected.mean(), abs=4 * 0.5 / math.sqrt(n))
    if kept is not None:
        assert here.all()


def test_noise_is_along_the_pulse():
    config = LidarConfig(channels=32, points_per_second=300_000, noise_stddev_m=0.03, **CLEAN)
    got = Lidar(config, context([box(12.0)])).sense(at(50.0))
    a, b = got.data[0, ..., :3], got.truth[0, ..., :3]
    da, db = np.linalg.norm(a, axis=-1), np.linalg.norm(b, axis=-1)
    assert a / da[..., None] == pytest.approx(b / db[..., None], abs=1e-5)
    error = (da - db).ravel()
    assert error.std() == pytest.approx(0.03, rel=4 / math.sqrt(2 * error.size))
    assert abs(error.mean()) < 4 * 0.03 / math.sqrt(error.size)


def test_semantic_points_know_what_they_hit():
    config = SemanticLidarConfig(channels=3, upper_fov_deg=0, lower_fov_deg=0)
    got = SemanticLidar(config, context([box(12.0)])).sense(at(50.0))
    xyz = got.data[0, ..., :3]
    assert (got.extras["label"] == 53).all()
    assert (got.extras["instance"] == 4).all()
    cosine = 12.0 / np.linalg.norm(xyz, axis=-1)
    assert got.data[0, ..., 3] == pytest.approx(cosine, rel=1e-5)


def test_the_sea_returns_only_when_asked():
    sea = [floor(-4.0)]
    down = {"channels": 4, "upper_fov_deg": -45, "lower_fov_deg": -80}
    assert np.isnan(SemanticLidar(SemanticLidarConfig(**down), context(sea)).sense(at(5.0)).data).all()
    got = SemanticLidar(SemanticLidarConfig(water_points=True, **down), context(sea)).sense(at(5.0))
    assert got.data[0, ..., 2] == pytest.approx(-5.0, rel=1e-5)
    assert (got.extras["label"] == 9).all()
    assert (got.extras["instance"] == 0).all()


def test_the_sea_returns_where_its_waves_and_its_tide_are():
    """Points on the ocean's own elevation at the sample's time, to the 2 cm that its grid is good for."""
    swell = {"type": "regular", "height_m": 1.2, "period_s": 6.0, "towards_deg": 30}
    tide = {"amplitude_m": 0.7, "period_h": 12.42, "phase_deg": 0}
    for keys in ({"waves": [swell]}, {"waves": [swell], "tide": [tide]}, {"tide": [tide]}):
        ocean = build_ocean(OceanConfig(**keys))
        made = replace(context([floor(-30.0)]), ocean=ocean)
        config = SemanticLidarConfig(water_points=True, channels=16, upper_fov_deg=-20, lower_fov_deg=-80)
        got = SemanticLidar(config, made).sense(at(6.0, t_s=40.0))
        xyz = got.data[0][np.isfinite(got.data[0, ..., 0])].astype(float)
        assert (got.extras["label"] == 9).all()
        x, y = jit.Float64(xyz[:, 0]), jit.Float64(xyz[:, 1])
        level = np.array(ocean.elevation(x, y, jit.Float64(40.0))) + 0 * xyz[:, 0]
        assert xyz[:, 2] + 6.0 == pytest.approx(level, abs=0.02)
        assert "waves" not in keys or np.ptp(level) > 0.5


def test_green_pulses_refract_and_are_late():
    """A scanner in air takes the way in water for n times as long."""
    config = SemanticLidarConfig(through_water=True, channels=1, upper_fov_deg=-60, lower_fov_deg=-60)
    got = SemanticLidar(config, context([floor(-4.0)])).sense(at(5.0))
    air = 5.0 / math.sin(math.radians(60))
    angle = math.asin(math.cos(math.radians(60)) / REFRACTIVE_INDEX)
    expected = air + REFRACTIVE_INDEX * 4.0 / math.cos(angle)
    assert np.linalg.norm(got.data[0, ..., :3], axis=-1) == pytest.approx(expected, rel=1e-4)
    assert got.data[0, ..., 3] == pytest.approx(math.cos(angle), rel=1e-4)
    assert (got.extras["label"] == 7).all()


@pytest.mark.parametrize(("past_m", "seen"), [(0.05, True), (-0.05, False)])
def test_pulses_are_late_at_the_end_of_their_range_too(past_m: float, seen: bool):
    """The range is by time: what lies in water counts for n times its way."""
    air, angle = 5.0 / math.sin(math.radians(60)), math.asin(math.cos(math.radians(60)) / REFRACTIVE_INDEX)
    late = air + REFRACTIVE_INDEX * 4.0 / math.cos(angle)
    config = SemanticLidarConfig(
        through_water=True, channels=1, upper_fov_deg=-60, lower_fov_deg=-60, range_m=late + past_m
    )
    got = SemanticLidar(config, context([floor(-4.0)])).sense(at(5.0))
    assert (np.isfinite(got.data[0, ..., 0]) & (got.extras["label"] == 7)).any() == seen


def test_own_motion_shows_when_asked():
    keys: dict[str, Any] = {"channels": 1, "points_per_second": 3600, "upper_fov_deg": 0, "lower_fov_deg": 0}
    config = SemanticLidarConfig(motion_distortion=True, **keys)
    got = SemanticLidar(config, context([box(12.0)])).sense(at(50.0, t_s=0.1, velocity=(2, 0, 0))).data[0, 0]
    front = np.argmin(np.abs(got[:, 1]) + 100 * (got[:, 0] < 0))
    age = (1 - front / 360) * 0.1
    assert got[front, 0] == pytest.approx(12.0 + 2 * age, rel=1e-4)


@pytest.mark.parametrize(("yaw", "spin"), [(0.7, 0.0), (-2.1, 0.9), (0.4, -1.3)])
def test_each_pulse_starts_where_the_scanner_was(yaw: float, spin: float):
    """Turned by `yaw`, with a velocity in its own axes: hits, placed from each pulse's pose, lie on the walls."""
    config = SemanticLidarConfig(
        motion_distortion=True, channels=1, points_per_second=3600, upper_fov_deg=0, lower_fov_deg=0
    )
    motion = at(50.0, t_s=0.1, velocity=(5.0, -3.0, 0))
    zero = dr.zeros(jit.Float64, 1)
    motion = replace(
        motion, attitude=jit.Array4f64(zero + math.cos(yaw / 2), zero, zero, zero + math.sin(yaw / 2)),
        angular_velocity=jit.Array3f64(zero, zero, zero + spin),
    )  # fmt: skip
    got = SemanticLidar(config, context([box(12.0)])).sense(motion).data[0, 0]
    age = (1 - np.arange(360) / 360) * 0.1
    then = yaw - spin * age
    c, s = np.cos(then), np.sin(then)
    x = c * got[:, 0] - s * got[:, 1] - age * (5.0 * math.cos(yaw) + 3.0 * math.sin(yaw))
    y = s * got[:, 0] + c * got[:, 1] - age * (5.0 * math.sin(yaw) - 3.0 * math.cos(yaw))
    np.testing.assert_allclose(np.maximum(np.abs(x), np.abs(y)), 12.0, rtol=1e-4)


def test_copy_of_a_fleet_gives_the_bytes_of_one():
    config = LidarConfig(channels=4, noise_stddev_m=0.02)
    fleet = Lidar(config, context([box(12.0)], copies=3)).sense(at(50.0, copies=3, tick=5))
    for copy in range(3):
        alone = Lidar(config, context([box(12.0)])).sense(at(50.0, tick=5, first=copy))
        assert np.array_equal(fleet.data[copy], alone.data[0], equal_nan=True)


def test_points_are_listed_ring_by_ring():
    config = LidarConfig(channels=4)
    data = Lidar(config, context([box(12.0)])).sense(at(50.0)).data[0]
    rows = points(data)
    assert rows.shape[1] == 5
    assert len(rows) == np.isfinite(data[..., 0]).sum()
    assert (np.diff(rows[:, 4]) >= 0).all()
