"""Ground and walls that vehicles with a `boundary` term feel in simulations."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl

SUCTION = {"terms": {"near": {"type": "boundary"}}}
STUBBY = {"type": "hovering_auv", **SUCTION}
"""A hull of few dipoles, which is quick to compile."""


def scenario(count=1, depth=9.75, **vehicle):
    return {
        "world": {"type": "flat", "depth_m": 10.0}, "tick_rate_hz": 50, "duration_s": 10,
        "agents": {
            f"auv{i}": {
                "vehicle": {"type": "remus100", **vehicle}, "control": "actuators",
                "start": {"position_m": [0.0, 30.0 * i], "depth_m": depth - 0.1 * i, "speed_mps": 1.5},
            }
            for i in range(count)
        },
    }  # fmt: skip


@pytest.mark.slow  # a minute to compile
def test_bottom_of_the_world_is_the_plane_below():
    """The acceleration of the first step is that of `Vehicle.accelerations` with the bottom 0.25 m below."""
    sim = pl.Simulation.load(scenario(**SUCTION))
    far = pl.Simulation.load(scenario(depth=5.0, **SUCTION))
    plain = pl.Simulation.load(scenario(depth=5.0))
    for one in (sim, far, plain):
        one.step(ticks=1)
    assert far.state["auv0"].velocity == pytest.approx(plain.state["auv0"].velocity, abs=1e-9)
    vehicle = pl.Vehicle.from_dict({"type": "remus100", **SUCTION})
    still = np.zeros((1, len(vehicle.actuator_names)))
    eta, nu = [[0, 0, 9.75, 0, 0, 0]], [[1.5, 0, 0, 0, 0, 0]]
    near = vehicle.accelerations(eta, nu, still, still, walls=[[0, 0, -1.0, 0.25]])[0]
    away = vehicle.accelerations(eta, nu, still, still)[0]
    drawn = (sim.state["auv0"].velocity - far.state["auv0"].velocity)[0] * 50
    assert near[0, 2] - away[0, 2] > 1e-3  # down
    assert drawn * [1, -1, -1] == pytest.approx((near - away)[0, :3], rel=1e-2, abs=1e-5)


@pytest.mark.slow  # as long
def test_lanes_and_blocks_are_as_alone():
    """Vehicles in one batch, and ticks in one call or one by one, give the same bytes."""
    both, alone, again = (pl.Simulation.load(scenario(k, **SUCTION)) for k in (2, 1, 1))
    both.step(ticks=40)
    alone.step(ticks=40)
    for _ in range(40):
        again.step()
    assert (both.state["auv0"].position == alone.state["auv0"].position).all()
    assert (again.state["auv0"].position == alone.state["auv0"].position).all()


def test_checkpoint_goes_on_near_the_bottom():
    sim = pl.Simulation.load(scenario(depth=9.5, **STUBBY))
    sim.step(ticks=17)
    kept = sim.checkpoint()
    sim.step(ticks=20)
    there = sim.state["auv0"].position.copy()
    sim.restore(kept)
    sim.step(ticks=20)
    assert (sim.state["auv0"].position == there).all()


@pytest.mark.parametrize("heading_deg", [0.0, 25.0, -15.0])
def test_wall_and_ground_are_told_apart(heading_deg):
    """A block 0.6 m to port of the axis, however the vehicle lies before it, and the ground beyond two lengths."""
    given = scenario(depth=4.0, **STUBBY)
    given["agents"]["auv0"]["start"]["heading_deg"] = heading_deg
    block = {"at_m": [0, 1.6, -4], "size_m": [6, 2, 4]}
    given["world"] = {"type": "built", "depth_m": 10.0, "things": [block]}
    sim = pl.Simulation.load(given)
    batch = next(iter(sim.model.batches.values()))
    found = sim.stepper._boundaries.walls(batch, sim.stepper.runs[batch.name].row)
    points, normals = (np.array([np.array(v).ravel() for v in part]) for part in (found.points, found.normals))
    assert points[0, 2] > 1e5
    assert normals[1] == pytest.approx([0, 1, 0], abs=1e-6)  # NED: to starboard
    assert points[1, 1] == pytest.approx(-0.6, abs=1e-5)
    sim.step({"auv0": [0.0] * 8}, ticks=5)
    assert heading_deg or sim.state["auv0"].velocity[0, 1] > 1e-6  # to port


def quay_scenario(*places, walls):
    """Ships of few dipoles in a dock, which go north."""
    terms = {
        "float": {"type": "hydrostatic", "heave_n_m": 60000, "roll_n_m": 9000, "pitch_n_m": 120000},
        "walls": {"type": "bank", "draught_m": 0.5},
    }
    vehicle = {
        "type": "custom", "length_m": 6.0, "beam_m": 1.8, "height_m": 1.0, "density_kg_m3": 1025, "gravity_m_s2": 9.81,
        "default_mode": "actuators", "terms": terms, "modes": {"actuators": {"type": "actuators"}},
        "mass": {"type": "explicit", "mass_kg": 2800, "inertia_kg_m2": [500, 6000, 6100]},
        "added_mass": {"type": "diagonal", "diagonal": [150, 2200, 5000, 100, 4000, 3000]},
    }  # fmt: skip
    return {
        "world": {"type": "built", "depth_m": 1.0, "things": [
            {"at_m": [0, y, 0], "size_m": [40, 2, 4], "name": f"quay{i}"} for i, y in enumerate(walls)
        ]},
        "tick_rate_hz": 50, "duration_s": 10,
        "agents": {
            f"ship{i}": {
                "vehicle": vehicle, "control": "actuators",
                "start": {"position_m": [x, y, 0], "heading_deg": heading, "speed_mps": 1.4},
            } for i, (x, y, heading) in enumerate(places)
        },
    }  # fmt: skip


def test_ships_are_drawn_to_quays_by_the_acceleration_of_the_vehicle():
    """Of the first step: quay 1.8 m to port, another 3.4 m to starboard, ground at 1 m; another ship, turned."""
    both = pl.Simulation.load(quay_scenario((0.0, 0.0, 0.0), (9.0, 0.3, 10.0), walls=(2.8, -4.4)))
    alone = pl.Simulation.load(quay_scenario((0.0, 0.0, 0.0), walls=(2.8, -4.4)))
    for sim in (both, alone):
        sim.step(ticks=1)
    assert (both.state["ship0"].velocity == alone.state["ship0"].velocity).all()
    vehicle = next(iter(both.model.batches.values())).vehicle
    walls = [[0, 0, -1.0, 1.0], [0, 1.0, 0, 1.8], [0, -1.0, 0, 3.4]]
    found = vehicle.accelerations([[0] * 6], [[1.4, 0, 0, 0, 0, 0]], [[]], [[]], walls=walls)[0][0]
    single = vehicle.accelerations([[0] * 6], [[1.4, 0, 0, 0, 0, 0]], [[]], [[]], walls=walls[:2])[0][0]
    drawn = both.state["ship0"].velocity[0, 1] * 50
    assert drawn == pytest.approx(-found[1], rel=1e-2)  # to port
    assert found[1] < 0
    assert abs(found[1] / single[1] - 1) > 0.05  # the other quay counts
    turned = both.state["ship1"].velocity[0]
    assert np.isfinite(turned).all()
    assert turned[1] > 0
