"""Draw one of every kind of thing that generated worlds can hold, each by itself on the seabed, in air and daylight.

    python examples/world_gallery.py [output.jpg]

takes about two minutes on two cores. Every tile is a world of its own: a few lines that `pelagos run` would take too.
"""

from __future__ import annotations

import argparse
import io
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from pelagos.world.build import build_world, world_config
from pelagos.world.preview import render
from pelagos.world.world import World

TILE = (230, 172)
COLUMNS = 6
FOV_DEG = 46.0
DEPTH_M = {"piling": 6.0, "pier": 6.0, "quay_wall": 8.0, "dam": 25.0, "jacket": 45.0, "turbine": 25.0, "net_pen": 25.0,
           "moored_ship": 12.0, "mooring": 14.0, "moored_mine": 12.0, "crab_trap": 8.0}  # fmt: skip
SIZE_M = {"kelp": 7.0, "dam": 70.0, "jacket": 18.0, "quay_wall": 25.0, "pier": 24.0, "fish_school": 3.0}
COUNT = {"boulder": 7, "seagrass": 60, "coral": 5, "brain_coral": 4, "sponge": 4, "debris": 7, "barrel": 3, "tyre": 3}
FIRST_SIZE_M = {"boulder": [0.6, 1.6], "seagrass": [0.5, 0.8], "coral": [0.5, 1.1], "brain_coral": [0.5, 1.2],
                "sponge": [0.4, 0.9], "debris": [1.0, 2.6]}  # fmt: skip
SPREAD_M = {"boulder": 6.0, "seagrass": 3.0, "coral": 4.0, "brain_coral": 4.5, "sponge": 3.5, "debris": 8.0,
            "barrel": 4.0, "tyre": 4.0}  # fmt: skip
WIDE = ("dam", "turbine", "jacket", "wreck_submarine", "moored_ship", "pier", "quay_wall", "net_pen")
GROUNDS = {"dunes": (5.0, 34.0, 20.0), "seamount": (60.0, 80.0, 30.0), "trench": (45.0, 60.0, -30.0),
           "slope": (14.0, 60.0, 0.0), "flat": (0.8, 60.0, 0.0), "canyon": (24.0, 90.0, 30.0)}  # fmt: skip
AZIMUTH_DEG = {
    "quay_wall": 250.0,
    "dam": 250.0,
    "wreck_boat": 235.0,
    "wreck_aircraft": 235.0,
    "pier": 240.0,
    "wreck_submarine": 285.0,
    "moored_ship": 285.0,
    "anchor": 160.0,
    "ship": 285.0,
    "fish": 270.0,
}


def things(kind: str) -> World:
    """A small world with a few of one kind in its middle, or with one."""
    count = COUNT.get(kind, 1)
    spread = SPREAD_M.get(kind, 0.0)
    one = {"kind": kind, "count": count, "heading_deg": 35.0 if count == 1 else None}
    if kind in SIZE_M:
        one["size_m"] = SIZE_M[kind]
    if kind in FIRST_SIZE_M:
        one["size_m"] = FIRST_SIZE_M[kind]
    turn, away = 2.4 * np.arange(count), spread / 2 * np.sqrt(np.arange(count) / max(count - 1, 1))
    one["at_m"] = np.stack([away * np.cos(turn), away * np.sin(turn)], axis=1).tolist()
    size = (
        260.0
        if kind in ("dam", "turbine", "jacket", "wreck_submarine", "moored_ship", "pier", "quay_wall", "net_pen")
        else 60.0
    )
    rough = {"kind": "flat", "relief_m": 0.3, "wavelength_m": 20, "roughness_m": 0.01}
    grid = 0.25 if size < 100 else 1.0
    return build_world(
        world_config({"type": "generated", "seed": 4, "size_m": [size, size], "grid_m": grid, "terrain": rough,
                      "depth_m": DEPTH_M.get(kind, 16.0), "objects": [one]})
    )  # fmt: skip


def lines(kind: str) -> World:
    """A pipeline or a cable."""
    one = {"kind": kind, "count": 1, "size_m": 0.8 if kind == "pipeline" else 0.18}
    terrain = {"kind": "flat", "relief_m": 0.4, "wavelength_m": 20, "roughness_m": 0.01}
    values = {"type": "generated", "seed": 3, "size_m": [70, 70], "grid_m": 0.25, "depth_m": 16.0, "terrain": terrain}
    return build_world(world_config({**values, "objects": [one]}))


def ground(name: str) -> World:
    """A landform, or sand ripples."""
    relief, wavelength, heading = GROUNDS.get(name, (14.0, 60.0, 30.0))
    terrain = {
        "kind": name,
        "relief_m": relief,
        "wavelength_m": wavelength,
        "heading_deg": heading,
        "roughness_m": 0.15,
    }
    size, grid = 220.0, 0.8
    if name == "ripples":
        terrain = {"kind": "flat", "relief_m": 0.2, "wavelength_m": 12, "roughness_m": 0.004, "ripple_m": 0.08,
                   "ripple_wavelength_m": 0.9, "heading_deg": 30}  # fmt: skip
        size, grid = 24.0, 0.06
    values = {"type": "generated", "seed": 2, "size_m": [size, size], "grid_m": grid, "depth_m": 30, "terrain": terrain}
    return build_world(world_config(values))


def moving(body: str, size: float) -> World:
    """A mover that stands still for its picture."""
    path = {"kind": "swing", "at_m": [0, 0, -9.0 if body == "chain" else -14.0], "amplitude_deg": 8,
            "period_s": 6, "phase_deg": 60}  # fmt: skip
    one = {"name": body, "body": body, "size_m": size, "path": path}
    world = build_world(world_config({"type": "flat", "depth_m": 15.5, "size_m": [200, 200], "movers": [one]}))
    return world.at_time(0.0)


def seen(points: NDArray[np.float64], middle: NDArray[np.float64], away: NDArray[np.float64]) -> bool:
    """Whether all points lie well within the picture of an eye that looks at their middle."""
    ahead = -away / np.linalg.norm(away)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    seen_from = points - (middle + away)
    depth = seen_from @ ahead
    half = 0.88 * np.tan(np.radians(FOV_DEG / 2))
    across, height = np.abs(seen_from @ right), np.abs(seen_from @ np.cross(right, ahead)) * TILE[0] / TILE[1]
    return bool((depth > 0).all() and (np.maximum(across, height) < half * depth).all())


def picture(
    world: World, folder: Path, *, samples: int, azimuth_deg: float = 215.0, whole: bool = False
) -> Image.Image:
    """What stands in the world, from obliquely above."""
    points = [g.vertices for g in world.geometries if g.label != 4]
    if whole or not points:
        points = [world.geometries[0].vertices * np.array([0.75, 0.75, 1.0])]
    if any(g.name in ("pipeline", "cable") for g in world.geometries):
        saddles = [g.vertices for g in world.geometries if g.name == "pipe supports"]
        points = [np.concatenate(saddles or points)]
        points = [points[0][np.hypot(*(points[0] - np.median(points[0], axis=0))[:, :2].T) < 10.0]]
    every = np.concatenate(points)
    low, high = every.min(axis=0), every.max(axis=0)
    middle, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    turn, up = np.radians(azimuth_deg), 0.42 if not whole else 0.7
    way = np.array([np.cos(turn), np.sin(turn), up]) / np.hypot(1.0, up)
    eye = middle + next(a for a in np.arange(0.8, 6.0, 0.1) if seen(every, middle, a * radius * way)) * radius * way
    file = folder / "tile.png"
    render(world, file, eye=eye, target=middle, size=TILE, samples=samples, fov_deg=FOV_DEG)
    return Image.open(io.BytesIO(file.read_bytes())).convert("RGB")


def sheet(tiles: list[tuple[str, Image.Image]]) -> Image.Image:
    """Tiles with their names beneath, row by row."""
    strip = 18
    rows = -(-len(tiles) // COLUMNS)
    whole = Image.new("RGB", (COLUMNS * TILE[0], rows * (TILE[1] + strip)), "white")
    font = ImageFont.load_default(size=13)
    for k, (name, tile) in enumerate(tiles):
        x, y = k % COLUMNS * TILE[0], k // COLUMNS * (TILE[1] + strip)
        whole.paste(tile, (x + 1, y + 1))
        ImageDraw.Draw(whole).text((x + 5, y + TILE[1] + 1), name, fill="black", font=font)
    return whole


def main() -> None:
    """Draw the sheet."""
    from pelagos.world.generate.objects import KINDS, LINES

    options = argparse.ArgumentParser(description="Draw one of every kind of thing in generated worlds.")
    options.add_argument("output", nargs="?", type=Path, default=Path("world_gallery.jpg"))
    options.add_argument("--only", nargs="*", help="kinds to draw; all if left out")
    options.add_argument("--samples", type=int, default=96, help="rays for each pixel")
    given = options.parse_args()
    grounds = ["ripples", "ridges", "canyon", "dunes", "seamount", "reef", "trench", "mixed"]
    movers = {"fish": 0.6, "chain": 6.0}
    tiles = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind in given.only or [*KINDS, *LINES, *movers, *grounds]:
            print(kind, flush=True)
            if kind in movers:
                tile = picture(
                    moving(kind, movers[kind]), folder, samples=given.samples, azimuth_deg=AZIMUTH_DEG.get(kind, 215.0)
                )
            elif kind in grounds:
                tile = picture(ground(kind), folder, samples=given.samples, whole=True)
            else:
                world = lines(kind) if kind in LINES else things(kind)
                tile = picture(world, folder, samples=given.samples, azimuth_deg=AZIMUTH_DEG.get(kind, 215.0))
            tiles.append((kind, tile))
    sheet(tiles).save(given.output, quality=80)
    print(f"written: {given.output}")


if __name__ == "__main__":
    main()
