"""Pictures that show what the cameras can do: a harbour at noon and dusk, a dam, a reef, a wreck by lamplight, the sea
surface from both sides, ten waters side by side, and what the cameras of geometry see.

    python examples/camera_gallery.py [FOLDER] [--only NAME ...] [--samples 16]

takes about ten minutes on two cores. Every picture is a scenario of its own: an agent that nobody sees carries the
camera.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import pelagos as pl
from pelagos.optics.water import JERLOV_TYPES

Place = tuple[float, float, float]
Picture = NDArray[np.uint8]
Other = tuple[str, Place, float]  # vehicle, position [m], heading [deg]

SHIP = {"name": "coaster", "body": "ship", "size_m": 60,
        "path": {"kind": "swing", "at_m": [52, 40, 0], "amplitude_deg": 0.01, "period_s": 9}}  # fmt: skip
HARBOUR = {"type": "harbour", "movers": [SHIP]}
DAM = {"type": "classic", "name": "dam"}
WRECK = {
    "type": "generated", "seed": 11, "size_m": [120, 120], "grid_m": 0.4, "depth_m": 34, "material": "silt",
    "patches": ["mud", "sand"], "terrain": {"kind": "flat", "relief_m": 1.0, "wavelength_m": 30, "roughness_m": 0.05},
    "objects": [
        {"kind": "wreck_boat", "count": 1, "at_m": [[0, 0]], "size_m": 17, "heading_deg": 25},
        {"kind": "fish_school", "count": 2, "at_m": [[1.5, -5], [-4, 5]], "size_m": 2.5},
        {"kind": "sponge", "density_per_ha": 250, "cluster": 0.5},
        {"kind": "boulder", "density_per_ha": 120, "size_m": [0.3, 1.0]},
        {"kind": "debris", "density_per_ha": 60},
        {"kind": "coral", "density_per_ha": 250, "size_m": [0.2, 0.7]},
    ],
}  # fmt: skip
GROWTH = [
    {"kind": "brain_coral", "density_per_ha": 1300, "size_m": [0.3, 1.3], "cluster": 0.6},
    {"kind": "coral", "density_per_ha": 4800, "size_m": [0.25, 1.0], "cluster": 0.8, "cluster_radius_m": 3},
    {"kind": "sponge", "density_per_ha": 800, "cluster": 0.7},
    {"kind": "seagrass", "density_per_ha": 1500, "cluster": 0.9},
]
REEF = {
    "type": "generated", "seed": 5, "size_m": [70, 70], "grid_m": 0.2, "depth_m": 8, "material": "sand",
    "patches": ["rock"], "patch_m": 6,
    "terrain": {"kind": "reef", "relief_m": 4.5, "wavelength_m": 26, "roughness_m": 0.15, "ripple_m": 0.03},
    "objects": [
        {"kind": "fish_school", "count": 4, "at_m": [[2, 6], [-1, -15], [9, 3], [-9, 10]], "size_m": [2, 3]},
        *GROWTH,
    ],
}  # fmt: skip
LAGOON = {
    "type": "generated", "seed": 5, "size_m": [90, 90], "grid_m": 0.25, "depth_m": 3.2, "material": "sand",
    "patches": ["rock"], "patch_m": 8,
    "terrain": {"kind": "flat", "relief_m": 0.7, "wavelength_m": 14, "roughness_m": 0.08, "ripple_m": 0.03},
    "objects": [
        {"kind": "pier", "count": 1, "at_m": [[20, 12]], "size_m": 34, "heading_deg": -20},
        {"kind": "fish_school", "count": 2, "at_m": [[2.2, 0.5], [6, -2]], "size_m": 1.4},
        *GROWTH,
    ],
}  # fmt: skip


def sea(water: str, elevation_deg: float, azimuth_deg: float = 130.0, *, height_m: float = 0.2, **more: Any) -> Any:
    """An ocean with small waves: Jerlov's water type, and where the sun stands."""
    wind_sea = {"type": "jonswap", "significant_height_m": height_m, "peak_period_s": 2.4, "towards_deg": 60}
    return {"water_type": water, "waves": [wind_sea],
            "sun": {"elevation_deg": elevation_deg, "azimuth_deg": azimuth_deg}, **more}  # fmt: skip


def lamps(spread_m: float, flux_lm: float) -> list[dict[str, Any]]:
    """A lamp to either side of the camera, away from it, so that the water between shines little."""
    return [
        {"position_m": (0.2, side * spread_m, 0.5 * spread_m), "orientation_deg": (0, 4, -6 * side),
         "flux_lm": flux_lm, "beam_angle_deg": 90}
        for side in (1, -1)
    ]  # fmt: skip


class Studio:
    """Takes pictures and keeps them.

    Args:
        folder: where sheets go.
        samples: rays a pixel.
    """

    def __init__(self, folder: Path, samples: int) -> None:
        self.folder, self.samples = folder, samples
        folder.mkdir(parents=True, exist_ok=True)

    def readings(
        self, world: Any, ocean: Any, eye: Place, target: Place, sensors: dict[str, Any],
        others: tuple[Other, ...] = (), *, speed_mps: float = 0.0,
    ) -> dict[str, pl.Reading]:  # fmt: skip
        """The first readings of sensors at `eye` that look at `target`, with other vehicles in view."""
        ahead = np.subtract(target, eye)
        start = {
            "position_m": eye,
            "heading_deg": -math.degrees(math.atan2(ahead[1], ahead[0])),  # compass: y is west
            "pitch_deg": math.degrees(math.atan2(ahead[2], math.hypot(ahead[0], ahead[1]))),
            "speed_mps": speed_mps,
        }
        agents: dict[str, Any] = {"eye": {"vehicle": "hovering_auv", "start": start, "sensors": sensors}}
        for k, (vehicle, position, heading) in enumerate(others):
            agents[f"other{k}"] = {"vehicle": vehicle, "start": {"position_m": position, "heading_deg": heading}}
        return pl.Simulation.load({"world": world, "ocean": ocean, "agents": agents}).reset()["eye"]

    def shoot(
        self, world: Any, ocean: Any, eye: Place, target: Place, *others: Other, size: tuple[int, int] = (640, 400),
        **camera: Any,
    ) -> Picture:  # fmt: skip
        """One colour picture."""
        config = {"type": "camera", "rate_hz": 10, "width_px": size[0], "height_px": size[1], "samples": self.samples,
                  "max_range_m": 200, "horizontal_fov_deg": 80, **camera}  # fmt: skip
        picture: Picture = self.readings(world, ocean, eye, target, {"camera": config}, others)["camera"].data[0]
        return picture

    def save(self, name: str, *rows: list[Picture]) -> None:
        """Pictures side by side, row under row, as a JPEG."""
        sheet = np.concatenate([np.concatenate(row, axis=1) for row in rows])
        Image.fromarray(sheet).save(self.folder / f"{name}.jpg", quality=88)
        print(self.folder / f"{name}.jpg", flush=True)


def harbour(studio: Studio) -> None:
    """Noon and dusk, from a boat and from between the piles."""
    noon, dusk = (sea("1C", *sun, turbidity=0.15) for sun in ((52.0, 120.0), (4.0, 320.0)))
    boat = [
        studio.shoot(
            HARBOUR, light, (-22, 12, 4.2), (10, 66, 6), ("wamv", (-9, 28, 0), -60), compensation_ev=0.7,
            white_temperature_k=kelvin,
        )
        for light, kelvin in ((noon, 4700.0), (dusk, 6000.0))
    ]  # fmt: skip
    piles = [
        studio.shoot(HARBOUR, light, (-18, 52, -2.6), (0, 56.5, -3.6), ("bluerov2", (-15.6, 52.4, -3.1), -30))
        for light in (noon, dusk)
    ]
    studio.save("camera_harbour", boat, piles)


def underwater(studio: Studio) -> None:
    """A reef at noon, a wreck at night, a dam by day and one of its gates by lamplight."""
    reef = studio.shoot(REEF, sea("IA", 60, 200), (-3, -22, -6.47), (4, -4, -7.5), white_balance="grey_world")
    wreck = studio.shoot(
        WRECK, sea("IA", -10), (5.5, -4.5, -30.6), (0.2, 0.8, -31.2), ("bluerov2", (1.0, 0.0, -29.6), -150),
        lamps=lamps(2.0, 15000), shutter_s=0.04, marine_snow_per_m3=0.4, horizontal_fov_deg=92, compensation_ev=-0.5,
    )  # fmt: skip
    face = studio.shoot(
        DAM, sea("IB", 65, turbidity=0.5), (-16, -8.5, -16), (-25.6, 3, -19.5), ("bluerov2", (-19.6, -4.2, -17.6), 130),
        white_balance="grey_world",
    )  # fmt: skip
    gate = studio.shoot(
        DAM, sea("IB", -10), (-21.2, 5.2, -22.7), (-25.6, 1.9, -24.0), ("bluerov2", (-23.9, 2.9, -23.0), 155),
        lamps=lamps(1.2, 6000), shutter_s=0.04, horizontal_fov_deg=90, compensation_ev=-0.5,
    )  # fmt: skip
    studio.save("camera_underwater", [reef, wreck], [face, gate])


def surface(studio: Studio) -> None:
    """Upward through Snell's window, under a ship, and both sides of the waterline in one picture."""
    clear = sea("IB", 50, 110, height_m=0.15)
    window = studio.shoot(HARBOUR, clear, (-2, 49, -6), (2, 51.5, 0), lens="fisheye", horizontal_fov_deg=150)
    below = studio.shoot(HARBOUR, clear, (22, 36, -7), (34, 46, 0), ("wamv", (26, 44, 0), 30), horizontal_fov_deg=100)
    split = studio.shoot(
        LAGOON, sea("IA", 55, 150, height_m=0.12), (-5, -3, 0.06), (12, 5, -0.6), ("wamv", (7, -1.5, 0), 30),
        ("bluerov2", (-3.2, -2.9, -0.75), 40), horizontal_fov_deg=90, port={"type": "dome", "radius_m": 0.2},
        size=(1280, 720), white_temperature_k=5000.0, compensation_ev=0.5,
    )  # fmt: skip
    studio.save("camera_surface", [split], [window, below])


def waters(studio: Studio) -> None:
    """A colour chart over a coral garden at 1.7 m in the ten types, clearest first."""
    patches = ("white", "red", "ochre_coral", "yellow", "green", "blue", "purple_coral", "black")
    chart = [
        {"name": name, "body": "box", "size_m": 0.21, "material": name,
         "path": {"kind": "swing", "at_m": [-3.3, -2.5 + 0.22 * (1.5 - k % 4), -1.72 - 0.22 * (k // 4)],
                  "amplitude_deg": 0.01, "period_s": 9}}
        for k, name in enumerate(patches)
    ]  # fmt: skip
    world = {**LAGOON, "depth_m": 3.6, "movers": chart}
    shots = [
        studio.shoot(world, sea(kind, 60, 200, height_m=0.12), (-5, -3, -1.7), (0, -2.3, -2.3), size=(320, 240))
        for kind in JERLOV_TYPES
    ]
    studio.save("camera_waters", shots[:5], shots[5:])


def murk(studio: Studio) -> None:
    """A murky layer over the ground by day and by lamplight, and a cloud of sediment between the piles."""
    layer = {"turbidity": {"depth_m": [0, 5.6, 6.0, 30], "value": [0.03, 0.03, 2.5, 2.5]}}
    cloud = {"turbidity": [
        {"type": "patch", "center_m": [-62.5, 55.0, -6.6], "radius_m": 1.1, "height_m": 0.6, "value": 6.0},
        {"type": "patch", "center_m": [-61.0, 56.5, -5.6], "radius_m": 1.3, "height_m": 0.5, "value": 3.0},
    ]}  # fmt: skip
    eye, target = (-66.0, 50.0, -5.2), (-61.0, 58.0, -6.0)
    rov: Other = ("bluerov2", (-64.2, 52.4, -5.6), -30)
    shots = [
        studio.shoot(HARBOUR, sea("IB", 55, 120, tracers=tracers), eye, target, rov, **more)
        for tracers, more in (
            (layer, {}), (cloud, {}),
        )
    ]  # fmt: skip
    night = sea("IB", -10, tracers=layer)
    lit = studio.shoot(HARBOUR, night, eye, target, rov, lamps=lamps(0.8, 12000), shutter_s=0.04)
    studio.save("camera_murk", [shots[0], lit, shots[1]])


def geometry(studio: Studio) -> None:
    """One view as picture, depth, labels, instances, normals and motion."""
    view = {"rate_hz": 10, "width_px": 426, "height_px": 280, "horizontal_fov_deg": 80, "max_range_m": 60}
    kinds = {"camera": {"samples": studio.samples, "white_balance": "grey_world"}, "depth_camera": {},
             "semantic_camera": {}, "instance_camera": {}, "normal_camera": {}, "optical_flow_camera": {}}  # fmt: skip
    sensors = {kind: {"type": kind, **view, **more} for kind, more in kinds.items()}
    eye: Place = (-3, -22, -6.47)
    others: tuple[Other, ...] = (("bluerov2", (-1.6, -19, -6.9), 60),)
    seen = studio.readings(REEF, sea("IA", 60, 200), eye, (4, -4, -7.5), sensors, others, speed_mps=0.5)
    depth, labels = seen["depth_camera"].data[0], seen["semantic_camera"]
    near = np.where(np.isfinite(depth), 255 * np.exp(-depth / 12), 0).astype(np.uint8)
    ids = seen["instance_camera"].data[0].astype(np.uint64) * np.uint64(2654435761)
    instances = np.stack([(ids >> np.uint64(s)) & np.uint64(255) for s in (8, 16, 24)], axis=-1).astype(np.uint8)
    normals = (127.5 + 127.5 * seen["normal_camera"].data[0]).astype(np.uint8)
    studio.save(
        "camera_geometry",
        [seen["camera"].data[0], np.repeat(near[..., None], 3, axis=-1), normals],
        [labels.extras["palette"][labels.data[0]], instances, _wheel(seen["optical_flow_camera"].data[0])],
    )


def _wheel(flow: NDArray[np.float32]) -> Picture:
    """Motion as colour: its direction as hue, its speed as brightness; black for none."""
    u, v = np.nan_to_num(flow[..., 0]), np.nan_to_num(flow[..., 1])
    speed = np.hypot(u, v)
    turn = np.arctan2(v, u)[..., None] - np.array([0.0, 2.0, 4.0]) * np.pi / 3
    bright = np.minimum(speed / np.percentile(speed, 95), 1.0)[..., None]
    return np.asarray(255 * bright * (0.5 + 0.5 * np.cos(turn)), dtype=np.uint8)


SHEETS: dict[str, Callable[[Studio], None]] = {
    "harbour": harbour, "underwater": underwater, "surface": surface, "waters": waters, "murk": murk,
    "geometry": geometry,
}  # fmt: skip


def main() -> None:
    """Draw the sheets."""
    options = argparse.ArgumentParser(description="Pictures that show what the cameras can do.")
    options.add_argument("folder", nargs="?", type=Path, default=Path("camera_gallery"))
    options.add_argument("--only", nargs="*", choices=SHEETS, help="sheets to draw; all if left out")
    options.add_argument("--samples", type=int, default=16, help="rays for each pixel")
    given = options.parse_args()
    studio = Studio(given.folder, given.samples)
    for name in given.only or SHEETS:
        SHEETS[name](studio)


if __name__ == "__main__":
    main()
