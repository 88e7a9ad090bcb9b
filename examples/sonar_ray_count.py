"""Rays that a sonar image needs: mean level, level of each range bin and of each cell against a converged image.

python examples/sonar_ray_count.py
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.world.generate.harbour import HarbourConfig
from pelagos.world.material import MATERIALS

CONVERGED = 1536
COUNTS = (12, 24, 48, 96, 192, 384)


def flat() -> Any:
    """A flat bottom, 6 m below the sonar."""
    corners = np.array([[-300.0, -300, -16], [300, -300, -16], [300, 300, -16], [-300, 300, -16]])
    ground = Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), 0, 1, 1)
    return SimpleNamespace(palette=(MATERIALS["sand"],), geometries=()), Scene([ground])


def harbour() -> Any:
    """The harbour's wreck."""
    world = HarbourConfig().build()
    return world, world.scene()


def image(place: Any, position: Any, rays: int) -> Any:
    """Mean intensity of a look, without speckle and noise, `(beams, bins)`."""
    world, scene = place
    context = SensorContext(
        path="study.sonar", seed=0, dt_ns=5_000_000, scene=scene, world=world, ocean=build_ocean(OceanConfig()),
        own_body=np.array([NO_BODY], np.uint32),
    )  # fmt: skip
    config = ImagingSonarConfig(
        range_max_m=40.0, range_min_m=16.0, bins=256, orientation_deg=(0, 15, 0), rays_per_beam=rays, scale="linear",
        texture_db=0.0,
    )  # fmt: skip
    return ImagingSonar(config, context).sense(lanes([0], dt_ns=5_000_000, position=position)).truth[0]


def main() -> None:
    """Print a table for a flat bottom and for a wreck in a harbour."""
    for name, place, position in (("flat bottom", flat(), (0, 0, -10)), ("wreck", harbour(), (-2, -8, -11.5))):
        best = image(place, position, CONVERGED)
        by_bin = best.sum(axis=0)
        heard = best > 1e-3 * np.median(best[best > 0])
        print(f"{name}: {best.shape[0]} beams, error against {CONVERGED} rays a beam")
        print("  rays   all energy   bins (rms, median)   cells (median)   empty cells")
        for rays in COUNTS:
            found = image(place, position, rays)
            total = 10 * np.log10(found.sum() / best.sum())
            error = np.abs(found.sum(axis=0) / by_bin - 1)
            bins, typical = np.sqrt(np.mean(error**2)), np.median(error)
            cells = np.median(np.abs(10 * np.log10(np.maximum(found[heard], 1e-12) / best[heard])))
            empty = np.mean(found[heard] == 0)
            levels = f"  {rays:4d}  {total:+8.3f} dB   {100 * bins:7.2f} % {100 * typical:7.2f} %"
            print(f"{levels}   {cells:10.2f} dB   {100 * empty:8.2f} %")


if __name__ == "__main__":
    main()
