"""Realtime view against path tracing on six fixed views of the harbour: PSNR, SSIM, mean colour; and the pictures.

python examples/camera_against_reference.py [WATER] [SAMPLES] [FOLDER]
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
from pelagos.math.so3 import from_euler
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.exposure import saturation_luminance
from pelagos.optics.image_quality import colour_ratio, psnr, ssim
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.harbour import HarbourConfig

Place = tuple[tuple[float, float, float], tuple[float, float, float]]  # position [m], roll pitch yaw [deg]
VIEWS: dict[str, Place] = {
    "seabed": ((0, 30, -11.8), (0, 90, 0)),
    "wreck": ((18, -14, -12.5), (0, 10, 50)),
    "piles": ((40, 50, -12), (0, -5, 45)),
    "wall": ((0, 55, -6), (0, 0, 90)),
    "chain": ((-98, -36, -6), (0, 0, 10)),
    "upward": ((-30, 52, -6), (0, -55, 60)),
}
SIZE = (120, 80)  # [px]


def still(place: Place, t_s: float) -> Kinematics:
    """A camera at rest."""
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    position = jit.Array3f64(*(zero + float(c) for c in place[0]))
    attitude = jit.Array4f64(*(zero + float(c) for c in from_euler(*(math.radians(a) for a in place[1]))))
    none = jit.Array3f64(zero, zero, zero)
    t_ns = jit.UInt64(u) + round(t_s * 1e9)
    motion = Kinematics(position, attitude, none, none, none, none, t_ns, u, u + 0, u + 0)
    dr.eval(motion)
    return motion


def light(context: SensorContext, place: Place, **camera: Any) -> np.ndarray:
    """Linear light `(height, width, 3)` [cd/m^2], mean of 4 x 4 pixels: path tracing is grainy."""
    config = CameraConfig(
        width_px=4 * SIZE[0], height_px=4 * SIZE[1], ripple=0.0, vignette=0.0, tone="linear", bits=16,
        compensation_ev=-4.0, **camera,
    )  # fmt: skip
    taken = Camera(config, context).sense(still(place, 3.0))
    full = saturation_luminance(config.aperture, taken.extras["exposure_s"][0], taken.extras["iso"][0])
    fine = taken.truth[0].astype(float) * (float(full) / 65535)
    return np.asarray(fine.reshape(SIZE[1], 4, SIZE[0], 4, 3).mean(axis=(1, 3)))


def shown(picture: np.ndarray, white: float) -> np.ndarray:
    """0 .. 255 with the power 1 / 2.2."""
    return np.asarray(255 * np.clip(picture / white, 0, 1) ** (1 / 2.2))


def main() -> None:
    water = sys.argv[1] if len(sys.argv) > 1 else "1C"
    samples = int(sys.argv[2]) if len(sys.argv) > 2 else 256
    folder = Path(sys.argv[3] if len(sys.argv) > 3 else "camera_gallery")
    folder.mkdir(parents=True, exist_ok=True)
    world = build_world(HarbourConfig(type="harbour"))
    ocean = build_ocean(OceanConfig(water_type=water, sun={"elevation_deg": 45}), world)
    hull = np.full(1, NO_BODY, np.uint32)
    context = SensorContext("gallery.camera", 1, 5_000_000, world.scene(1), world, ocean, hull)
    sheet = []
    for name, place in VIEWS.items():
        fast = light(context, place, samples=4)
        slow = light(context, place, samples=samples, renderer="reference")
        white = 4 * float(slow.mean())
        a, b = shown(fast, white), shown(slow, white)
        ratio = " / ".join(f"{r:.2f}" for r in colour_ratio(fast, slow))
        mean = " / ".join(f"{v:.1f}" for v in slow.mean(axis=(0, 1)))
        print(f"{name:8s} PSNR {psnr(a, b):5.1f} dB  SSIM {ssim(a, b):.3f}  mean colour {ratio} of {mean}", flush=True)
        sheet.append(np.concatenate([a, b]))
    Image.fromarray(np.concatenate(sheet, axis=1).astype(np.uint8)).save(folder / f"camera_reference_{water}.png")


if __name__ == "__main__":
    main()
