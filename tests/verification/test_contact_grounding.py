"""Surface craft that run aground, and the probes of catamarans."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.vehicles.vehicle import Vehicle

SLOPE = {
    "type": "generated",
    "seed": 3,
    "size_m": [120, 120],
    "grid_m": 1.0,
    "depth_m": 3,
    "terrain": {"kind": "slope", "relief_m": 8},
    "objects": [],
}


@pytest.mark.parametrize("name", ["otter", "wamv"])
def test_no_probe_of_a_catamaran_starts_between_its_hulls(name):
    """Below the deck, what a probe crosses is hull: the gap between the pontoons belongs to whatever floats there."""
    shape = Vehicle.from_catalogue(name).config.hull
    pontoon = next(part for part in shape.parts if part.type == "hull")
    inner = pontoon.position_m[1] - pontoon.size_m[1] / 2
    starts, vectors = Vehicle.from_catalogue(name).probes
    way = starts[:, None] + np.linspace(0, 1, 21)[:, None] * vectors[:, None]
    low = way[..., 2] < pontoon.position_m[2] + 0.25 * pontoon.size_m[2]
    assert low.any()
    assert np.abs(way[low][:, 1]).min() > 0.85 * inner  # propellers reach a little inwards


@pytest.mark.parametrize(
    "name", ["otter", *(pytest.param(n, marks=pytest.mark.slow) for n in ("wamv", "surface_vessel"))]
)
def test_a_craft_that_drives_onto_a_beach_stops_there(name):
    """Neither flies nor sinks in: it stops with its keel on the ground."""
    agent = {"vehicle": name, "start": {"position_m": [22, 0], "heading_deg": 0, "depth_m": 0}, "control": "wrench"}
    sim = pl.Simulation.load({"tick_rate_hz": 100, "world": SLOPE, "agents": {"a": agent}})
    sim.reset()
    assert sim.world.height(50.0, 0.0) > 0 > sim.world.height(22.0, 0.0)
    mass = float(Vehicle.from_catalogue(name).config.body.mass_matrix[0, 0])
    push = {"a": [0.5 * mass, 0, 0, 0, 0, 0]}
    sim.step(push, ticks=1600)
    state = sim.state["a"]
    assert np.linalg.norm(state.velocity[0]) < 0.05
    assert abs(state.position[0, 2]) < 0.2
    assert np.abs(np.degrees(state.euler[0, :2])).max() < 10
    w, x, y, z = state.attitude[0]
    turned = Rotation.from_quat([x, y, z, w]).apply(Vehicle.from_catalogue(name).hull.vertices) + state.position[0]
    depth = sim.world.height(turned[:, 0], turned[:, 1]) - turned[:, 2]
    assert -0.02 < depth.max() < 0.05  # touches, and is not in the ground
