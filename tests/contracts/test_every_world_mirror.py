"""No world tells port from starboard but by its sign: what is placed, moves or rises across lies on the other side.

Ground, things of every shape on sloping ground, movers on every path and graded, sloped or rippled beds, then all of it
in the mirror; what is drawn from a seed has no image and is left out.
"""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest
from mirrored_sea import mirrored
from scipy.spatial import cKDTree

from pelagos.world.build import build_world, world_config
from pelagos.world.by_hand import ThingConfig
from pelagos.world.mover import MoverConfig
from pelagos.world.world import World

AXIAL, POLAR = np.array([-1.0, 1.0, -1.0]), np.array([1.0, -1.0, 1.0])
SHAPES = sorted(set(get_args(ThingConfig.model_fields["shape"].annotation)) - {"file"})
SLOPE: dict[str, Any] = {
    "type": "large", "size_m": [400.0, 300.0], "resolution_m": 20.0,
    "ground": {"kind": "fractal", "mean_depth_m": 60.0, "relief_m": 1e-7, "gradient": [0.07, -0.11]},
}  # fmt: skip
PATHS: dict[str, dict[str, Any]] = {
    "circle": {"kind": "circle", "centre_m": [3.0, -5.0, -4.0], "radius_m": 7.0, "speed_mps": 0.8, "phase_deg": 25.0},
    "waypoints": {
        "kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [9.0, -6.0, -3.5], [2.0, -14.0, -5.0]], "speed_mps": 0.7,
        "start_s": 0.4, "at_end": "loop",
    },
    "swing": {
        "kind": "swing", "at_m": [4.0, -6.0, -2.0], "amplitude_deg": 25.0, "period_s": 6.0, "towards_deg": 35.0,
        "phase_deg": 15.0,
    },
}  # fmt: skip
BEDS: dict[str, dict[str, Any]] = {
    "slope": {"kind": "slope", "relief_m": 3.0, "wavelength_m": 60.0, "heading_deg": 25.0, "roughness_m": 0.0},
}


def across(config: dict[str, Any]) -> dict[str, Any]:
    """The image of a world's configuration."""
    image = mirrored(config)
    ground = image.get("ground", {})
    if "gradient" in ground:
        ground["gradient"] = [ground["gradient"][0], -ground["gradient"][1]]
    for thing in image.get("things", ()):
        if "step_m" in thing:
            x, y, z = thing["step_m"]
            thing["step_m"] = [x, -y, z]
    return image


def built(config: dict[str, Any]) -> World:
    return build_world(world_config(config))


def same_cloud(a: np.ndarray, b: np.ndarray) -> None:
    """Each point of one set lies at a point of the other."""
    for one, other in ((a, b), (b, a)):
        assert cKDTree(one).query(other)[0].max() < 1e-5  # of vertices kept as float32, within 100 m


@pytest.mark.parametrize("shape", SHAPES)
def test_a_thing_stands_on_the_other_side(shape: str) -> None:
    size = [1.2, 1.2, 1.2] if shape == "corner_reflector" else [2.0, 1.1, 0.7]
    thing = {
        "shape": shape, "at_m": [14.0, -27.0, 0.6], "orientation_deg": [11.0, -8.0, 25.0], "size_m": size,
        "on_ground": True, "repeat": 2, "step_m": [1.3, -2.1, 0.4],
    }  # fmt: skip
    config = {**SLOPE, "things": [thing]}
    one, other = built(config), built(across(config))
    plain = len(built(SLOPE).geometries)
    (a, b) = (np.concatenate([g.vertices for g in w.geometries[plain:]]) for w in (one, other))
    assert len(a) == len(b)
    same_cloud(a * POLAR, b)
    assert abs(a[:, 1].mean()) > 20


@pytest.mark.parametrize("kind", sorted(PATHS))
def test_a_mover_goes_on_the_other_side(kind: str) -> None:
    config = {"name": "it", "body": "ship", "size_m": 12.0, "path": PATHS[kind]}
    path = mirrored({**PATHS[kind], "at_m": PATHS[kind].get("at_m", PATHS[kind].get("centre_m", [0.0, 0.0, 0.0]))})
    image = {**config, "path": path}
    if kind == "circle":
        path["centre_m"] = path.pop("at_m")
        path |= {"phase_deg": -path["phase_deg"], "clockwise": True}
    elif kind == "waypoints":
        del path["at_m"]
    one, other = MoverConfig.model_validate(config), MoverConfig.model_validate(image)
    for t in (0.0, 0.9, 7.7, 23.0):
        a, b = one.pose(t), other.pose(t)
        np.testing.assert_allclose(b.position, a.position * POLAR, atol=1e-12)
        np.testing.assert_allclose(b.velocity, a.velocity * POLAR, atol=1e-12)
        np.testing.assert_allclose(b.angular_velocity, a.angular_velocity * AXIAL, atol=1e-12)
        turned = a.attitude * [1.0, *AXIAL]
        assert abs(turned @ b.attitude) == pytest.approx(1.0, abs=1e-12)  # q and -q are one attitude


@pytest.mark.parametrize("kind", sorted(BEDS))
def test_a_bed_rises_and_is_graded_on_the_other_side(kind: str) -> None:
    config = {
        "type": "generated", "seed": 4, "size_m": [160.0, 120.0], "grid_m": 2.0, "depth_m": 14.0, "terrain": BEDS[kind],
        "grades": [
            {"at_m": [19.0, -16.0], "size_m": [20.0, 12.0], "depth_m": 9.0, "relief": 0.3, "blend_m": 6.0},
            {"at_m": [-29.0, 26.0], "radius_m": 9.0, "depth_m": 17.0, "relief": 0.1, "blend_m": 4.0},
        ],
    }  # fmt: skip
    one, other = built(config), built(across(config))
    x, y = np.random.default_rng(3).uniform(-50.0, 50.0, (2, 400))
    rough = 0.02 * BEDS[kind]["relief_m"]  # what is drawn: its standard deviation
    here, there = one.height(x, y), other.height(x, -y)
    assert np.ptp(here) > 20 * rough
    assert np.sqrt(np.mean((here - there) ** 2)) < 2.5 * rough


def test_sloping_ground_slopes_to_the_other_side() -> None:
    one, other = built(SLOPE), built(across(SLOPE))
    x, y = np.random.default_rng(3).uniform(-120.0, 120.0, (2, 300))
    np.testing.assert_allclose(other.height(x, -y), one.height(x, y), atol=1e-4)
    assert np.ptp(one.height(x, y)) > 20
