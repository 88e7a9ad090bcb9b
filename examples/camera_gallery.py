"""Pictures of the harbour: ten Jerlov waters side by side, day and lamplight, up through the surface, a wreck, labels
and depth.

python examples/camera_gallery.py [FOLDER]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np
from PIL import Image

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.water import JERLOV_TYPES
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera import Camera, CameraConfig
from pelagos.sensors.depth_camera import DepthCamera, DepthCameraConfig
from pelagos.sensors.semantic_camera import SemanticCamera, SemanticCameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.harbour import HarbourConfig
from pelagos.world.world import World

Place = tuple[tuple[float, float, float], tuple[float, float, float]]  # position [m], roll pitch yaw [deg]
WRECK: Place = ((18, -14, -12.5), (0, 10, 50))
PIER: Place = ((40, 50, -12), (0, -5, 45))
CHAIN: Place = ((-98, -36, -6), (0, 0, 10))
SEABED: Place = ((0, 30, -11.8), (0, 90, 0))
UPWARD: Place = ((-30, 52, -6), (0, -55, 60))
LAMPS = tuple(
    {
        "position_m": (0.2, side * 0.8, 0.2),
        "orientation_deg": (0, 0, -side * 12),
        "flux_lm": 4000.0,
        "beam_angle_deg": 80.0,
    }
    for side in (1, -1)
)


def still(place: Place, t_s: float) -> Kinematics:
    """A camera at rest."""
    from pelagos.math.so3 import from_euler

    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)

    def vector(v: Any) -> Any:
        return jit.Array3f64(*(zero + float(c) for c in v))

    q = from_euler(*(math.radians(a) for a in place[1]))
    none = vector((0, 0, 0))
    motion = Kinematics(vector(place[0]), jit.Array4f64(*(zero + float(c) for c in q)), none, none, none, none,
                        jit.UInt64(u) + round(t_s * 1e9), u, u + 0, u + 0)  # fmt: skip
    dr.eval(motion)
    return motion


class Studio:
    """The harbour, and pictures of it."""

    def __init__(self, world: World, folder: Path) -> None:
        self.world, self.folder, self.scene = world, folder, world.scene(1)
        folder.mkdir(parents=True, exist_ok=True)

    def context(self, **ocean: Any) -> SensorContext:
        made = build_ocean(OceanConfig(**ocean), self.world)
        return SensorContext(
            "gallery.camera", 1, 5_000_000, self.scene, self.world, made, np.full(1, NO_BODY, np.uint32)
        )

    def shoot(self, place: Place, ocean: dict[str, Any], **camera: Any) -> np.ndarray:
        sensor = Camera(CameraConfig(samples=8, **camera), self.context(**ocean))
        picture: np.ndarray = sensor.sense(still(place, 3.0)).data[0]
        return picture

    def save(self, name: str, rows: list[list[np.ndarray]]) -> None:
        sheet = np.concatenate([np.concatenate(row, axis=1) for row in rows])
        Image.fromarray(sheet).save(self.folder / f"{name}.jpg", quality=85)
        print(self.folder / f"{name}.jpg")


def waters(studio: Studio) -> None:
    """The wreck from 7 m in the ten types, clearest first."""
    small = {"width_px": 320, "height_px": 240}
    shots = [studio.shoot(WRECK, {"water_type": kind}, **small) for kind in JERLOV_TYPES]
    studio.save("camera_waters", [shots[:5], shots[5:]])


def views(studio: Studio) -> None:
    """Noon and low sun, seabed, the view upwards, lamplight at night."""
    day = {"water_type": "1C", "sun": {"elevation_deg": 55}}
    clear = {"water_type": "IB", "sun": {"elevation_deg": 55}}
    low = {"water_type": "1C", "sun": {"elevation_deg": 4}}
    night = {"water_type": "II", "sun": {"elevation_deg": -30}}
    size = {"width_px": 480, "height_px": 360}
    studio.save("camera_views", [
        [studio.shoot(PIER, day, **size), studio.shoot(CHAIN, day, **size), studio.shoot(SEABED, clear, **size)],
        [studio.shoot(PIER, low, **size), studio.shoot(UPWARD, clear, horizontal_fov_deg=100, **size),
         studio.shoot(WRECK, night, lamps=LAMPS, **size)],
    ])  # fmt: skip


def labels(studio: Studio) -> None:
    """The same view as picture, labels and depth."""
    size = {"width_px": 480, "height_px": 360}
    context = studio.context(water_type="IB")
    motion = still(WRECK, 3.0)
    semantic = SemanticCamera(SemanticCameraConfig(**size), context).sense(motion)
    depth = DepthCamera(DepthCameraConfig(**size), context).sense(motion).data[0]
    grey = np.where(np.isfinite(depth), 255 * np.exp(-depth / 12), 0).astype(np.uint8)
    studio.save("camera_labels", [[
        studio.shoot(WRECK, {"water_type": "IB"}, **size),
        semantic.tables["palette"][semantic.data[0]],
        np.repeat(grey[..., None], 3, axis=-1),
    ]])  # fmt: skip


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "camera_gallery")
    studio = Studio(build_world(HarbourConfig(type="harbour")), folder)
    waters(studio)
    views(studio)
    labels(studio)


if __name__ == "__main__":
    main()
