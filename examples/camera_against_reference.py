"""Realtime view against path tracing on six fixed views of the harbour: PSNR, SSIM, mean colour; and the pictures.

python examples/camera_against_reference.py [WATER] [SAMPLES] [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from camera_gallery import CHAIN, PIER, SEABED, UPWARD, WRECK, Place, Studio, still
from PIL import Image

from pelagos.optics.exposure import saturation_luminance
from pelagos.optics.image_quality import colour_ratio, psnr, ssim
from pelagos.sensors.camera import Camera, CameraConfig
from pelagos.world.build import build_world
from pelagos.world.generate.harbour import HarbourConfig

WALL: Place = ((0, 55, -6), (0, 0, 90))
VIEWS: dict[str, Place] = {
    "seabed": SEABED, "wreck": WRECK, "piles": PIER, "wall": WALL, "chain": CHAIN, "upward": UPWARD,
}  # fmt: skip
SIZE = (120, 80)  # [px]


def light(studio: Studio, place: Place, ocean: dict[str, Any], **camera: Any) -> np.ndarray:
    """Linear light `(height, width, 3)` [cd/m^2], mean of 4 x 4 pixels: path tracing is grainy."""
    config = CameraConfig(
        width_px=4 * SIZE[0], height_px=4 * SIZE[1], ripple=0.0, vignette=0.0, tone="linear", bits=16,
        compensation_ev=-4.0, **camera,
    )  # fmt: skip
    taken = Camera(config, studio.context(**ocean)).sense(still(place, 3.0))
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
    studio = Studio(build_world(HarbourConfig(type="harbour")), folder)
    ocean = {"water_type": water, "sun": {"elevation_deg": 45}}
    sheet = []
    for name, place in VIEWS.items():
        fast = light(studio, place, ocean, samples=4)
        slow = light(studio, place, ocean, samples=samples, renderer="reference")
        white = 4 * float(slow.mean())
        a, b = shown(fast, white), shown(slow, white)
        ratio = " / ".join(f"{r:.2f}" for r in colour_ratio(fast, slow))
        print(f"{name:8s} PSNR {psnr(a, b):5.1f} dB  SSIM {ssim(a, b):.3f}  mean colour {ratio}", flush=True)
        sheet.append(np.concatenate([a, b]))
    Image.fromarray(np.concatenate(sheet, axis=1).astype(np.uint8)).save(folder / f"camera_reference_{water}.png")


if __name__ == "__main__":
    main()
