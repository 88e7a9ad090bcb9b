"""Cameras without light: depth, labels, instances, normals, flow. Against geometry in closed form."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.depth_camera import DepthCamera, DepthCameraConfig
from pelagos.sensors.camera.instance_camera import InstanceCamera, InstanceCameraConfig
from pelagos.sensors.camera.normal_camera import NormalCamera, NormalCameraConfig
from pelagos.sensors.camera.optical_flow_camera import OpticalFlowCamera, OpticalFlowCameraConfig
from pelagos.sensors.camera.picture.camera_rays import pixel_rays, project_points
from pelagos.sensors.camera.semantic_camera import SemanticCamera, SemanticCameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext

SIZE: dict[str, Any] = {"width_px": 72, "height_px": 50}


def quad(corners: list[list[float]], *, label: int, instance: int) -> Geometry:
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    return Geometry(np.array(corners, dtype=float), faces, 0, label, instance)


def wall(x: float, half: float, label: int, instance: int) -> Geometry:
    """A square facing the camera, `x` ahead, at 10 m depth."""
    return quad(
        [[x, half, -10 - half], [x, -half, -10 - half], [x, -half, -10 + half], [x, half, -10 + half]],
        label=label,
        instance=instance,
    )


def context(geometries: list[Geometry], seed: int = 1) -> SensorContext:
    world: Any = SimpleNamespace()
    ocean = lit_ocean("I")
    scene = Scene(geometries, copies=1)
    return SensorContext("auv0.view", seed, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))


def ahead(
    *, velocity: Any = (0.0, 0.0, 0.0), spin: Any = (0.0, 0.0, 0.0), height: float = -10.0, tick: int = 0
) -> Kinematics:
    """One lane that looks north, velocities in the body frame."""
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)

    def vector(v: Any) -> Any:
        return jit.Array3f64(*(zero + float(c) for c in v))

    motion = Kinematics(
        position=vector((0, 0, height)),
        attitude=jit.Array4f64(zero + 1, zero, zero, zero),
        velocity=vector(velocity),
        angular_velocity=vector(spin),
        acceleration=vector((0, 0, 0)),
        angular_acceleration=vector((0, 0, 0)),
        t_ns=jit.UInt64(u),
        tick=u + tick,
        environment=u + 0,
        copy=u + 0,
    )
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


BOTH = [wall(5.0, 0.5, 13, 1), wall(8.0, 40.0, 53, 2)]


def test_depth_is_along_the_axis():
    got = DepthCamera(DepthCameraConfig(**SIZE), context([wall(2.0, 30.0, 1, 1)])).sense(ahead())
    assert got.data.shape == (1, 50, 72)
    assert got.data == pytest.approx(2.0, rel=1e-5)


def test_depth_is_infinite_where_nothing_is_in_reach():
    got = DepthCamera(DepthCameraConfig(max_range_m=6.0, **SIZE), context(BOTH)).sense(ahead())
    assert np.isinf(got.data[0, 0, 0])
    assert got.data[0, 25, 36] == pytest.approx(5.0, rel=1e-5)


def test_depth_noise_is_stereo_s():
    """sigma = z^2 sigma_d / (f B), here at first order: z sigma_d / (f B) of 0.6 % is far from 1."""
    config = DepthCameraConfig(
        stereo_baseline_m=0.2, disparity_noise_px=0.3, noise_m=0.005, width_px=320, height_px=320
    )
    got = DepthCamera(config, context([wall(6.0, 60.0, 1, 1)])).sense(ahead())
    focal = 160 / np.tan(np.radians(35))
    sigma = np.hypot(36 * 0.3 / (focal * 0.2), 0.005)
    error = (got.data - got.truth).ravel()
    assert error.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * error.size) + 0.01)
    assert abs(np.median(error)) < 4 * 1.2533 * sigma / np.sqrt(error.size)


def test_dropout_is_the_share_asked_for():
    config = DepthCameraConfig(dropout=0.3, width_px=200, height_px=200)
    got = DepthCamera(config, context([wall(2.0, 30.0, 1, 1)])).sense(ahead())
    share = np.isinf(got.data).mean()
    assert share == pytest.approx(0.3, abs=4 * np.sqrt(0.3 * 0.7 / 40_000))


def expected_inside(config: Any) -> Any:
    """Pixels whose ray passes through the small wall 5 m ahead."""
    _, d = pixel_rays(config)
    y, z = d[..., 1] / d[..., 0] * 5, d[..., 2] / d[..., 0] * 5
    return (np.abs(y) < 0.5) & (np.abs(z) < 0.5)


@pytest.mark.parametrize("lens", ["pinhole", "fisheye"])
def test_labels_are_exact_to_the_pixel(lens: str):
    config = SemanticCameraConfig(lens=lens, **SIZE)
    got = SemanticCamera(config, context(BOTH)).sense(ahead())
    inside = expected_inside(config)
    assert inside.sum() > 30
    assert np.array_equal(got.data[0] == 13, inside)
    assert np.array_equal(got.data[0] == 53, ~inside)
    assert got.tables["palette"].shape == (256, 3)


def test_looking_up_shows_the_water_plane():
    got = SemanticCamera(SemanticCameraConfig(max_range_m=100.0, **SIZE), context(BOTH[:1])).sense(ahead(height=-2.0))
    assert got.data[0, 0, 0] == 9
    assert got.data[0, -1, 0] == 0


@pytest.mark.parametrize("height", [-2.0, 3.0])
def test_depth_ends_at_the_sea_surface(height: float):
    """From both sides: the plane z = 0, not the wall that stands behind it."""
    config = DepthCameraConfig(max_range_m=200.0, **SIZE)
    got = DepthCamera(config, context([wall(80.0, 60.0, 1, 1)])).sense(ahead(height=height))
    _, d = pixel_rays(config)
    to_sea = np.where(d[..., 2] * height < 0, -height / d[..., 2] * d[..., 0], 80.0)
    assert got.truth[0] == pytest.approx(np.minimum(to_sea, 80.0), rel=1e-5)


def test_what_stereo_finds_beyond_the_reach_has_failed():
    config = DepthCameraConfig(stereo_baseline_m=0.05, max_range_m=20.0, **SIZE)
    got = DepthCamera(config, context([wall(18.0, 60.0, 1, 1)])).sense(ahead())
    found = got.data[np.isfinite(got.data)]
    assert 0.2 < np.isfinite(got.data).mean() < 0.9
    assert found.max() <= 20.0 * (1 + 1e-6)


def test_instances_stay_and_carry_labels():
    config = InstanceCameraConfig(**SIZE)
    got = InstanceCamera(config, context(BOTH)).sense(ahead())
    inside = expected_inside(config)
    assert np.array_equal(got.data[0], np.where(inside, 1, 2))
    assert np.array_equal(got.extras["label"][0], np.where(inside, 13, 53))


@pytest.mark.parametrize("height", [-2.0, 3.0])
def test_instances_end_at_the_sea_surface(height: float):
    """From both sides: of a wall 20 m ahead that stands in both, only the part on the camera's side of z = 0."""
    config = InstanceCameraConfig(**SIZE)
    got = InstanceCamera(config, context([wall(20.0, 60.0, 13, 7)])).sense(ahead(height=height))
    _, d = pixel_rays(config)
    beyond = (height + 20.0 * d[..., 2] / d[..., 0]) * height < 0
    assert 0.1 < beyond.mean() < 0.9
    assert np.array_equal(got.data[0], np.where(beyond, 0, 7))
    assert np.array_equal(got.extras["label"][0], np.where(beyond, 0, 13))


def test_normals_point_at_the_camera():
    got = NormalCamera(NormalCameraConfig(orientation_deg=(0, 0, 10), **SIZE), context(BOTH)).sense(ahead())
    angle = np.radians(10)  # the camera is turned left: the wall's normal comes from its right
    assert got.data[0, 25, 36] == pytest.approx([-np.cos(angle), np.sin(angle), 0], abs=1e-6)


@pytest.mark.parametrize("distortion", [(0.0,) * 5, (-0.2, 0.05, 1e-3, -1e-3, 0.0)])
def test_flow_is_the_motion_of_projected_points(distortion: Any):
    """Against the projection of fixed points before and after a short time, 1 ms: second order in it, 1e-3 px/s."""
    config = OpticalFlowCameraConfig(distortion=distortion, **SIZE)
    velocity, spin = np.array([0.8, -0.3, 0.2]), np.array([0.1, -0.2, 0.3])
    got = OpticalFlowCamera(config, context([wall(4.0, 40.0, 1, 1)])).sense(ahead(velocity=velocity, spin=spin))
    _, d = pixel_rays(config)
    points = d / d[..., :1] * 4.0
    h = 1e-3
    step = points - velocity * h
    after = step - np.cross(np.broadcast_to(spin * h, step.shape), step)
    before = points + velocity * h
    before = before + np.cross(np.broadcast_to(spin * h, before.shape), before)
    expected = (project_points(after, config) - project_points(before, config)) / (2 * h)
    assert np.abs(got.data[0] - expected).max() < 0.02
    assert np.abs(got.data).max() > 20


PORTS: dict[str, dict[str, Any]] = {
    "flat": {"port": {"type": "flat", "distance_m": 0.03, "thickness_m": 0.012}},
    "dome": {"port": {"type": "dome", "radius_m": 0.06, "thickness_m": 0.006, "offset_m": (-0.015, 0.01, 0.0)}},
    "flat, wide angle": {"port": {"type": "flat", "distance_m": 0.03}, "distortion": (-0.2, 0.05, 0.001, 0.002, 0.0)},
    "dome, fisheye": {"port": {"type": "dome", "offset_m": (0.01, 0.0, 0.005)}, "lens": "fisheye",
                      "horizontal_fov_deg": 130},
}  # fmt: skip


@pytest.mark.parametrize("height", [-10.0, 10.0], ids=["in water", "in air"])
@pytest.mark.parametrize("kind", PORTS)
def test_flow_through_a_port_is_that_of_known_points(kind: str, height: float):
    """The points that the pixels show move for 2 ms; the rays that then go through them are found by Newton's method,
    through both faces of the port. Central differences: 0.02 px/s, as without a port."""
    config = OpticalFlowCameraConfig(**SIZE, **PORTS[kind])
    outside = 1.34 if height < 0 else 1.0
    velocity, spin = np.array([0.8, -0.3, 0.2]), np.array([0.1, -0.2, 0.3])
    near = wall(1.5, 40.0, 1, 1)
    near.vertices[:, 2] += 10 + height
    got = OpticalFlowCamera(config, context([near])).sense(ahead(velocity=velocity, spin=spin, height=height)).data[0]
    start, d = pixel_rays(config, outside)
    ok = np.isfinite(d).all(axis=-1) & (d[..., 0] > 0.2) & np.isfinite(got).all(axis=-1)
    assert ok.mean() > 0.8
    points = start + d * ((1.5 - start[..., :1]) / d[..., :1])
    h, moved = 1e-3, []
    for sign in (1, -1):
        there = points - sign * h * (velocity + np.cross(spin, points))
        moved.append(pixels_that_see(there, config, outside))
    expected = (moved[0] - moved[1]) / (2 * h)
    assert np.abs(got - expected)[ok].max() < 0.02
    assert np.abs(got[ok]).max() > 15


def pixels_that_see(points: Any, config: Any, outside: float) -> Any:
    """How far right and down of each pixel the ray goes through its point, `(height, width, 2)` [px]."""
    shift = np.zeros((*points.shape[:2], 2))

    def missed(at: Any) -> Any:
        """Across the ray: two components of the way from the ray to the point."""
        start, d = pixel_rays(config, outside, shift=(at[..., 0], at[..., 1]))
        away = (points - start) - d * np.sum((points - start) * d, axis=-1, keepdims=True)
        return away[..., 1:]

    for _ in range(6):
        here, e = missed(shift), 1e-3
        slopes = np.stack([(missed(shift + step) - here) / e for step in np.eye(2) * e], axis=-1)
        fine = np.isfinite(slopes).all(axis=(-2, -1)) & np.isfinite(here).all(axis=-1)
        slopes, here = np.where(fine[..., None, None], slopes, np.eye(2)), np.where(fine[..., None], here, 0)
        shift = shift - np.linalg.solve(slopes, here[..., None])[..., 0]
    return shift


def test_flow_is_nothing_where_nothing_is_seen():
    got = OpticalFlowCamera(OpticalFlowCameraConfig(**SIZE), context(BOTH[:1])).sense(ahead())
    assert np.isnan(got.data[0, 0, 0]).all()
    assert got.data[0, 25, 36] == pytest.approx([0, 0])


def test_every_camera_explains_itself():
    for kind, config in [
        (DepthCamera, DepthCameraConfig(**SIZE)),
        (SemanticCamera, SemanticCameraConfig(**SIZE)),
        (InstanceCamera, InstanceCameraConfig(**SIZE)),
        (NormalCamera, NormalCameraConfig(**SIZE)),
        (OpticalFlowCamera, OpticalFlowCameraConfig(**SIZE)),
    ]:
        found = kind(config, context(BOTH)).explain(ahead())
        assert found[0][0] == "slant range"
        assert np.nanmin(found[0][1]) >= 5.0 - 1e-4
