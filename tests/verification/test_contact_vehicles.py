"""Contact of real vehicles with the seabed: resting force and impulse, for heavier and lighter variants of each."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from cases import slow
from pelagos.vehicles.vehicle import Vehicle

UNDERWATER = ("remus100", "torpedo", "couguv", "lrauv", "glider", "bluerov2", "bluerov2_heavy", "hovering_auv")
FEW = ("remus100", "bluerov2_heavy", "glider")  # a body of revolution, a frame, wings
DEPTH, HZ = 20.0, 200
FRD = np.array([1.0, -1.0, -1.0])


def variant(name: str, *, mass: float, net: float) -> dict:
    """The vehicle with `mass` times its mass, whose buoyancy is short of its weight by the share `net`."""
    config = Vehicle.from_catalogue(name).config
    rigid = config.body.rigid
    kg = mass * float(rigid[0, 0])
    return {
        "type": name,
        "mass": {
            "type": "explicit",
            "mass_kg": kg,
            "volume_m3": kg * (1 - net) / config.density_kg_m3,
            "inertia_kg_m2": [mass * float(x) for x in np.diag(rigid)[3:]],
            "center_of_gravity_m": [float(x) for x in config.body.center_of_gravity],
            "center_of_buoyancy_m": [float(x) for x in config.body.center_of_buoyancy],
        },
    }


class Drop:
    """A vehicle a little above the seabed, and the contact wrench (FRD) and velocity (FRD) of every step."""

    def __init__(self, vehicle: dict, *, height: float, speed: float) -> None:
        low = float(Vehicle.from_dict(vehicle).hull.vertices[:, 2].min())
        start = {"position_m": [0.0, 0.0], "depth_m": DEPTH + low - height}
        agent = {"vehicle": vehicle, "start": start, "control": "wrench"}
        self.sim = pl.Simulation.load(
            {"tick_rate_hz": HZ, "world": {"type": "flat", "depth_m": DEPTH}, "agents": {"a": agent}}
        )
        self.sim.set_state("a", velocity=np.array([[0.0, 0.0, -speed]]))
        self.wrenches: list[np.ndarray] = []
        self.nu: list[np.ndarray] = []

    def fall(self, seconds: float) -> None:
        for _ in range(round(seconds * HZ)):
            state = self.sim.state["a"]
            self.nu.append(np.concatenate([state.velocity[0] * FRD, state.angular_velocity[0] * FRD]))
            self.sim.step()
            self.wrenches.append(self.sim.stepper.contact("a")[0] * np.tile(FRD, 2))


@pytest.mark.parametrize(
    "name", [n if n == "remus100" else pytest.param(n, marks=pytest.mark.slow) for n in UNDERWATER]
)
def test_resting_force_is_weight_minus_buoyancy(name):
    """A tenth too heavy, at rest on the bottom after 4 s; the glider rocks on its wings and takes 7: within 0.2 %."""
    vehicle = variant(name, mass=1.0, net=0.1)
    drop = Drop(vehicle, height=0.05, speed=0.0)
    drop.fall(8.0 if name == "glider" else 5.0)
    config = Vehicle.from_dict(vehicle).config
    force = np.mean(drop.wrenches[-HZ:], axis=0)[:3]
    assert np.linalg.norm(force) == pytest.approx(config.body.weight - config.body.buoyancy, rel=0.002)
    assert np.linalg.norm(drop.sim.state["a"].velocity) < 0.001


@pytest.mark.parametrize("mass", [0.8, slow(1.6)])
@pytest.mark.parametrize("name", UNDERWATER)
def test_impulse_of_an_impact_is_mass_and_added_mass_times_change_of_velocity(name, mass):
    """(M_RB + M_A)(nu_after - nu_before) = sum of h (F, M), for a neutral vehicle that meets the bottom at 1 m/s.

    Over the hardest step and those before it, without drag, so that nothing but Coriolis forces acts beside.
    """
    terms = dict.fromkeys(Vehicle.from_catalogue(name).config.terms)
    vehicle = {**variant(name, mass=mass, net=0.0), "terms": terms}
    drop = Drop(vehicle, height=0.02, speed=1.0)
    drop.fall(1.0)
    touching = np.abs(drop.wrenches).max(axis=1) > 0
    first = int(np.argmax(touching))
    strongest = first + int(np.argmax(np.abs(np.array(drop.wrenches)[first : first + 40, 2])))
    last = strongest + 1  # the step that takes most of the speed, whatever follows
    matrix = Vehicle.from_dict(vehicle).config.body.mass_matrix
    change = matrix @ (drop.nu[last] - drop.nu[first])
    impulse = np.sum(drop.wrenches[first:last], axis=0) / HZ
    assert impulse[2] < 0
    assert change[2] == pytest.approx(impulse[2], rel=0.02)


@pytest.mark.parametrize("name", ["bluerov2_heavy", pytest.param("hovering_auv", marks=pytest.mark.slow)])
def test_static_friction_holds_a_vehicle_on_a_slope(name):
    """A tenth too heavy, on uneven ground of 7 to 20 degrees: once settled it does not creep by 0.025 mm in 5 s."""
    vehicle = variant(name, mass=1.0, net=0.1)
    low = float(Vehicle.from_dict(vehicle).hull.vertices[:, 2].min())
    world = {
        "type": "generated", "seed": 3, "size_m": [120, 120], "grid_m": 1.0, "depth_m": 30,
        "terrain": {"kind": "slope", "relief_m": 120 * np.tan(np.radians(7))}, "objects": [],
    }  # fmt: skip
    agent = {"vehicle": vehicle, "control": "wrench", "start": {"position_m": [0, 0], "depth_m": 5}}
    sim = pl.Simulation.load({"tick_rate_hz": 100, "world": world, "agents": {"a": agent}})
    height = [float(np.ravel(sim.world.height(x, y))[0]) for x, y in ((0, 0), (2, 0), (0, 2))]
    steep = np.degrees(np.arctan(np.hypot(height[1] - height[0], height[2] - height[0]) / 2))
    assert 7 < steep < 20
    sim.set_state("a", position=np.array([[0.0, 0.0, height[0] - low + 0.05]]))
    sim.run(8.0)
    before = sim.state["a"].position[0].copy()
    sim.run(5.0)
    assert np.abs(sim.state["a"].position[0] - before).max() < 2.5e-5
