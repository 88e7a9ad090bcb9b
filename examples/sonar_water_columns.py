"""Five devices in water that shows what sonar engineers look for in a picture: side lobes, walls, bounces, noise.

    python examples/sonar_water_columns.py [--out FILE]

A Ping360 in a square tank, an Oculus M750d that faces a quay, a BlueView P900 over sand with a cylinder, the water
column of a multibeam over a flat bed with the ring of side lobes at the nadir's range, and a side scan whose surface
line lies before its bottom. Writes sonar_water_columns.png.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import pelagos as pl
from pelagos.sensors.sonar.ping.fan_picture import fan_image


def readings(world: dict[str, Any], start: tuple[float, float, float], sonar: dict[str, Any], count: int) -> list[Any]:
    """Readings of a sonar on a vehicle that is held at (north, west, up), its bow to the north."""
    sim = pl.Simulation.load({
        "seed": 2,
        "tick_rate_hz": 20,
        "world": world,
        "ocean": {"wind": {"speed_mps": 4.0, "from_deg": 200.0}},
        "agents": {"rov": {
            "vehicle": "bluerov2_heavy",
            "start": {"position_m": list(start[:2]), "depth_m": -start[2]},
            "sensors": {"sonar": {"position_m": [0.4, 0, 0], **sonar}},
        }},
    })  # fmt: skip
    found: list[Any] = []
    while len(found) < count:
        place = np.array([start]) + np.array([[0.1 * len(found), 0.0, 0.0]]) * ("sidescan" in sonar["type"])
        sim.set_state("rov", position=place, attitude=np.array([[1.0, 0, 0, 0]]), velocity=np.zeros((1, 3)))
        seen = sim.step()["rov"]
        if "sonar" in seen:
            found.append(seen["sonar"])
    return found


def wall(at: tuple[float, float, float], size: tuple[float, float, float]) -> dict[str, Any]:
    """A wall of concrete."""
    return {"shape": "box", "at_m": list(at), "size_m": list(size), "material": "concrete"}


def tank(axes: Any) -> None:
    """A Ping360 turns in a square tank, 8 by 8 by 4 m."""
    sides = [wall((4.5, 0, -2), (1, 10, 5)), wall((-4.5, 0, -2), (1, 10, 5)), wall((0, 4.5, -2), (10, 1, 5)),
             wall((0, -4.5, -2), (10, 1, 5))]  # fmt: skip
    sonar = {"type": "mechanical_scanning_sonar", "device": "ping360", "range_max_m": 10.0, "bins": 500, "rate_hz": 20,
             "step_deg": 1.8, "multipath": "surface_and_bottom", "scale": "db"}  # fmt: skip
    pings = readings({"type": "flat", "depth_m": 4.0, "things": sides}, (0.9, -0.5, -2.0), sonar, 200)
    angle = np.array([float(np.ravel(p.extras["angle"])[0]) for p in pings])
    level = np.array([p.data[0] for p in pings])
    ranges = np.asarray(pings[0].extras["range"])
    order = np.argsort(angle)
    shown = axes.pcolormesh(angle[order], ranges, level[order].T, cmap="viridis", vmin=-60, vmax=0, rasterized=True)
    axes.set_theta_zero_location("N")
    axes.set_yticks([2, 4, 6, 8, 10])
    plt.colorbar(shown, ax=axes, shrink=0.7, label="[dB]")


def fan(axes: Any, reading: Any, low: float, high: float) -> None:
    """A polar picture as a fan."""
    ranges = np.asarray(reading.extras["range"])
    picture = fan_image(reading.data[0], np.asarray(reading.extras["azimuth"]), ranges, height=700)
    half = ranges[-1] * picture.shape[1] / picture.shape[0] / 2
    axes.imshow(picture, cmap="copper", vmin=low, vmax=high, extent=(-half, half, 0, ranges[-1]))
    axes.set_xlabel("[m]")


def quay(axes: Any) -> None:
    """An M750d faces a quay 14 m ahead, with two piles before it."""
    things = [
        wall((16.0, 0, -3), (4, 60, 8)),
        wall((10.6, -3.0, -3), (0.5, 0.5, 8)),
        wall((11.7, 5.0, -3), (0.8, 0.8, 8)),
    ]
    sonar = {"type": "imaging_sonar", "device": "oculus_m750d", "range_max_m": 25.0, "bins": 700, "scale": "db",
             "orientation_deg": [0, 5, 0], "side_lobe_beams": 24, "beams": 256, "multipath": "surface"}  # fmt: skip
    fan(axes, readings({"type": "flat", "depth_m": 7.0, "things": things}, (0, 0, -3.0), sonar, 1)[0], -55, 0)


def sand(axes: Any) -> None:
    """A P900 over sand, with a cylinder of a metre and its shadow."""
    things = [{"shape": "cylinder", "at_m": [9.0, 1.5, -9.6], "size_m": [0.5, 0.5, 1.5], "material": "concrete"}]
    sonar = {"type": "imaging_sonar", "device": "blueview_p900", "range_max_m": 20.0, "bins": 700, "scale": "db",
             "orientation_deg": [0, 18, 0], "beams": 256}  # fmt: skip
    fan(axes, readings({"type": "flat", "depth_m": 10.0, "things": things}, (0, 0, -7.5), sonar, 1)[0], -55, -15)


def column(axes: Any) -> None:
    """Multibeam over a flat bed 15 m below: the first echo from straight below comes into all beams by side lobes."""
    sonar = {"type": "multibeam", "device": "norbit_wbms", "range_max_m": 40.0, "water_column_bins": 500, "beams": 200}
    reading = readings({"type": "flat", "depth_m": 25.0}, (0, 0, -10.0), sonar, 1)[0]
    level = np.asarray(reading.extras["water_column"][0], dtype=float)
    angle = np.asarray(reading.extras["angle"]).ravel()
    ranges = np.linspace(0.0, 40.0, level.shape[1])
    across, down = ranges[None] * np.sin(angle)[:, None], -ranges[None] * np.cos(angle)[:, None]
    top = np.nanmax(level)
    axes.pcolormesh(across, down, level[:-1, :-1], cmap="viridis", vmin=top - 70, vmax=top, rasterized=True)
    axes.set_aspect("equal")
    axes.set_xlabel("across the track [m]")


def side_scan(axes: Any) -> None:
    """A side scan 6 m below the surface and 12 m above the bed: the surface's line comes first."""
    sonar = {"type": "sidescan", "device": "starfish_450f", "range_max_m": 40.0, "scale": "db", "rate_hz": 10}
    pings = readings({"type": "flat", "depth_m": 18.0}, (0, 0, -6.0), sonar, 150)
    both = np.array([np.hstack([p.data[0, 0][::-1], p.data[0, 1]]) for p in pings])
    axes.imshow(both, cmap="copper", aspect="auto", vmin=-65, vmax=-15, extent=(-40, 40, 0, 15))
    axes.set_xlabel("slant range, port and starboard [m]")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("sonar_water_columns.png"))
    out = parser.parse_args().out
    figure = plt.figure(figsize=(16, 9.5), layout="constrained")
    grid = figure.add_gridspec(2, 6)
    panels = (
        ("Ping360 in a tank, 8 x 8 x 4 m", tank, grid[0, :2]),
        ("Oculus M750d before a quay", quay, grid[0, 2:4]),
        ("BlueView P900 over sand", sand, grid[0, 4:]),
        ("multibeam: ring at the nadir's range", column, grid[1, :4]),
        ("side scan: surface 6 m above, bed 12 m below", side_scan, grid[1, 4:]),
    )
    for title, draw, place in panels:
        axes = figure.add_subplot(place, projection="polar" if draw is tank else None)
        axes.set_title(title)
        draw(axes)
        print(title, flush=True)
    figure.savefig(out, dpi=100)
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
