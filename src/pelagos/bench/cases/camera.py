"""Cameras and LiDAR in the harbour: frames a second until the NumPy arrays, beside the bare ray casts in them."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.depth_camera import DepthCamera, DepthCameraConfig
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.camera_rays import Imager, ViewConfig, view_rays
from pelagos.sensors.camera.picture.pixel_order import pixels
from pelagos.sensors.camera.semantic_camera import SemanticCamera, SemanticCameraConfig
from pelagos.sensors.lidar.lidar import Lidar, LidarConfig
from pelagos.sensors.sensor import Kinematics, Measurement, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.harbour import HarbourConfig

_PLACE: Final = (-66.0, 50.0, -7.0)  # [m], before the pier's piles
_YAW: Final = math.radians(60)


@cache
def _context() -> SensorContext:
    world = build_world(HarbourConfig(type="harbour"))
    return SensorContext(
        path="bench.camera",
        seed=1,
        dt_ns=5_000_000,
        scene=world.scene(1),
        world=world,
        ocean=build_ocean(OceanConfig(water_type="1C"), world),
        own_body=np.full(1, NO_BODY, np.uint32),
    )


def _motion(tick: int) -> Kinematics:
    """Gliding sideways, 1 cm a frame."""
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    x, y, z = _PLACE
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        position=jit.Array3f64(zero + x + 0.01 * tick, zero + y, zero + z),
        attitude=jit.Array4f64(zero + math.cos(_YAW / 2), zero, zero, zero + math.sin(_YAW / 2)),
        velocity=none,
        angular_velocity=none,
        acceleration=none,
        angular_acceleration=none,
        t_ns=jit.UInt64(u) + tick * 5_000_000,
        tick=u + tick,
        environment=u + 0,
        copy=u + 0,
    )
    dr.eval(motion)
    return motion


def _rate(sense: Callable[[Kinematics], Measurement]) -> float:
    """Samples a second, each from another place and time."""
    tick = 0

    def once() -> None:
        nonlocal tick
        tick += 1
        sense(_motion(tick))

    return 1 / seconds(once, warm_up=5, at_least_s=2.0)


def _bare_rate(config: ViewConfig) -> float:
    """Frames a second of the first hits alone, with normals."""
    context = _context()
    view = Imager(config, context)

    def frame(caster: Caster, lens: Any, motion: Kinematics, own: Any) -> Any:
        hits = caster.cast(view_rays(lens, pixels(view.tiling, 1), motion, own, config))
        return hits.t, hits.normal

    shoot = context.scene.compile(frame)
    tick = 0

    def once() -> None:
        nonlocal tick
        tick += 1
        dr.eval(shoot(*view.arguments(_motion(tick))))
        dr.sync_thread()

    return 1 / seconds(once, warm_up=5)


def _camera(width: int, height: int) -> Measured:
    camera = Camera(CameraConfig(width_px=width, height_px=height), _context())
    first, second = camera.sense(_motion(1)).truth, camera.sense(_motion(400)).truth
    must(20 < float(first.mean()) < 235, "the picture is black or white")
    must(float(first.std()) > 5, "the picture shows nothing")
    must(bool((first != second).mean() > 0.2), "the picture does not depend on place and time")
    return Measured(
        _rate(camera.sense),
        Reference("first hits with normals alone, same pixels, same run", _bare_rate(camera.config)),
        f"{width} x {height}, shadows, caustics, in-scatter, noise; mean level {first.mean():.0f} of 255",
    )


def camera_vga_fps() -> Measured:
    """Realtime underwater frames of 640 x 480."""
    return _camera(640, 480)


def camera_256_fps() -> Measured:
    """Realtime underwater frames of 256 x 256."""
    return _camera(256, 256)


def depth_vga_fps() -> Measured:
    """Depth images of 640 x 480."""
    camera = DepthCamera(DepthCameraConfig(noise_share=0.01), _context())
    depth = camera.sense(_motion(1)).truth
    must(bool(np.isfinite(depth).mean() > 0.1), "no depth was measured")
    rate = _rate(camera.sense)
    return Measured(
        rate, Reference("first hits alone", _bare_rate(camera.config)), f"{np.isfinite(depth).mean():.0%} hit"
    )


def semantic_vga_fps() -> Measured:
    """Label images of 640 x 480."""
    camera = SemanticCamera(SemanticCameraConfig(), _context())
    kinds = len(np.unique(camera.sense(_motion(1)).data))
    must(kinds >= 3, "fewer than three labels are seen")
    return Measured(_rate(camera.sense), Reference("first hits alone", _bare_rate(camera.config)), f"{kinds} labels")


def lidar_64x1024_hz() -> Measured:
    """Full turns of 64 channels and 1024 steps."""
    lidar = Lidar(LidarConfig(channels=64, points_per_second=64 * 1024 * 10, range_m=60.0), _context())
    cloud = lidar.sense(_motion(1)).data
    must(cloud.shape == (1, 64, 1024, 4), "the cloud has another size")
    found = float(np.isfinite(cloud[..., 0]).mean())
    must(found > 0.01, "there are no points")
    return Measured(_rate(lidar.sense), None, f"{found:.0%} of 65 536 pulses gave a point")


def _case(name: str, measure: Callable[[], Measured], title: str, unit: str, goal: float) -> Case:
    reference = Reference("first hits with normals alone, same pixels, same run")
    return Case(name, title, measure, unit, goal, "higher", reference)


CASES: Final = (
    _case("camera_vga_fps", camera_vga_fps, "underwater camera 640 x 480, harbour, to NumPy", "frames/s", 25.0),
    _case("camera_256_fps", camera_256_fps, "underwater camera 256 x 256, harbour, to NumPy", "frames/s", 100.0),
    _case("depth_vga_fps", depth_vga_fps, "depth camera 640 x 480, harbour", "frames/s", 30.0),
    _case("semantic_vga_fps", semantic_vga_fps, "semantic camera 640 x 480, harbour", "frames/s", 30.0),
    Case("lidar_64x1024_hz", "LiDAR, 64 channels x 1024 steps, harbour", lidar_64x1024_hz, "turns/s", 50.0, "higher",
         Reference("no reference: a rate of its own")),
)  # fmt: skip
