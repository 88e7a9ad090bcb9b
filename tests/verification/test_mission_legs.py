"""Every leg, flown by a vehicle of every family that can do it, in a current of 0.2 m/s and small waves.

What must hold is the leg's own tolerance. Runs are short and coarse; the whole matrix is slow.
"""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl

CURRENT = [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 60}]
SEA = {"currents": CURRENT, "waves": [{"type": "regular", "height_m": 0.2, "period_s": 3.0, "towards_deg": 20}]}
ALTIMETER = {"alt": {"type": "altimeter", "rate_hz": 10, "position_m": [0, 0, -0.2]}}
FLAT = {"type": "flat", "depth_m": 30}


def fly(vehicle, mission, seconds, *, start, speed=0.0, world=FLAT, sensors=None, others=None, tick=50, waves=True):
    """The track `(k, 3)` at 2 Hz and the simulation, run until the mission ends."""
    agent = {"vehicle": vehicle, "start": {"position_m": start, "speed_mps": speed}, "mission": mission}
    data = {
        "tick_rate_hz": tick, "duration_s": seconds, "world": world, "ocean": SEA if waves else {"currents": CURRENT},
        "agents": {"a": {**agent, "sensors": sensors or {}}, **(others or {})},
    }  # fmt: skip
    sim = pl.Simulation.load(data)
    track = [sim.state["a"].position[0]]
    while sim.time_ns < seconds * 1e9 and not sim.stepper.missions_done():
        sim.run(seconds=0.5)
        track.append(sim.state["a"].position[0])
    return np.array(track), sim


def off_line(track, a, b):
    """Largest distance from the line a -> b of the points beside it [m]."""
    along = (np.array(b) - a) / np.hypot(*(np.array(b) - a))
    run = (track[:, :2] - a) @ along
    beside = (run > 0) & (run < np.hypot(*(np.array(b) - a)))
    across = (track[:, :2] - a) @ np.array([-along[1], along[0]])
    return np.abs(across[beside]).max()


# one leg of every kind, each by a vehicle for which it is hardest or most usual


def test_a_line_abeam_of_the_current():
    """The issue's figure: 20 m abeam of 0.3 m/s within 0.5 m of the line, at 0.3 m/s."""
    strong = [{"type": "uniform", "speed_mps": 0.3, "towards_deg": 0}]
    data = {
        "tick_rate_hz": 100, "duration_s": 120, "world": FLAT, "ocean": {"currents": strong},
        "agents": {"a": {"vehicle": "bluerov2_heavy", "start": {"position_m": [0, 0, -8]}, "mission": [
            {"type": "goto", "points": [[0, -20, -8]], "heading_deg": 0, "speed_mps": 0.3}]}},
    }  # fmt: skip
    sim = pl.Simulation.load(data)
    track = []
    while not sim.stepper.missions_done():
        assert sim.time_ns < 119e9
        sim.run(seconds=1.0)
        track.append(sim.state["a"].position[0])
    assert np.abs(np.array(track)[:, 0]).max() < 0.2
    assert track[-1] == pytest.approx([0, -20, -8], abs=0.35)
    assert abs(sim.state["a"].euler[0, 2]) < np.deg2rad(10)


def test_goto_and_station_keeping_of_an_rov():
    mission = [
        {"type": "goto", "points": [[4, 0, -6], [4, -5, -7]], "face": [0, 0], "acceptance_m": 0.2},
        {"type": "station_keeping", "seconds": 15, "face": [0, 0]},
    ]
    track, sim = fly("bluerov2_heavy", mission, 90, start=[0, 0, -6])
    assert sim.stepper.missions_done()
    assert np.linalg.norm(track[-20:] - [4, -5, -7], axis=1).max() < 0.3
    bearing = np.arctan2(-5.0, -4.0)  # NWU yaw towards the origin is atan2(+5, -4): the vehicle is at y = -5
    assert np.angle(np.exp(1j * (sim.state["a"].euler[0, 2] + bearing))) == pytest.approx(0, abs=0.15)


def test_survey_at_altitude_then_land():
    mission = [
        {"type": "survey", "area": [[2, 0], [10, 0], [10, -8], [2, -8]], "swath_deg": 90, "altitude_m": 3,
         "speed_mps": 0.6},
        {"type": "land"},
    ]  # fmt: skip
    track, sim = fly(
        "bluerov2_heavy", mission, 150, start=[0, 0, -8], world={"type": "flat", "depth_m": 12}, sensors=ALTIMETER
    )
    assert sim.stepper.missions_done()
    assert track[-1][2] < -11.6  # on the bottom: half of its height above 12 m
    lines = (2.4, 7.2)  # half swath 3 m x 0.8 from each edge
    for y in lines:
        assert np.abs(track[:, 1] + y).min() < 0.3


def test_orbit_looking_inwards():
    mission = [{"type": "orbit", "center": [6, 0], "radius_m": 4, "turns": 1, "look": "center", "speed_mps": 0.5}]
    track, sim = fly("hovering_auv", mission, 100, start=[0, 0, -6])
    assert sim.stepper.missions_done()
    radius = np.hypot(track[:, 0] - 6, track[:, 1])
    assert np.abs(radius[15:] - 4).max() < 0.4


def test_torpedo_profile_repeat_and_until():
    mission = [
        {"type": "profile", "upper_depth_m": 3, "lower_depth_m": 10, "cycles": 1, "heading_deg": 0},
        {"type": "repeat", "times": 1},
        {"type": "dive", "depth_m": 28, "until": {"sensor": "alt", "below": 12}},
        {"type": "drift", "seconds": 5},
    ]
    track, sim = fly("remus100", mission, 240, start=[0, 0, -3], speed=1.5, sensors=ALTIMETER)
    assert sim.stepper.missions_done()
    depth = -track[:, 2]
    turns = np.flatnonzero((depth[1:-1] > depth[:-2]) & (depth[1:-1] >= depth[2:]) & (depth[1:-1] > 9))
    assert len(turns) >= 2
    assert 17 < depth.max() < 22  # 30 m of water less 12 of altitude, and what the dive overshoots


def test_surface_craft_stops_docks_and_drifts():
    mission = [
        {"type": "goto", "points": [[20, 0]]},
        {"type": "station_keeping", "seconds": 50, "point": [20, 0]},
        {"type": "dock", "point": [0, 0], "heading_deg": 180, "approach_m": 15, "tolerance_m": 1.0},
        {"type": "drift", "seconds": 10},
    ]
    track, sim = fly("otter", mission, 300, start=[0, 0, 0], waves=False)
    assert sim.stepper.missions_done()
    kept = np.hypot(track[:, 0] - 20, track[:, 1]) < 1.5
    assert kept.sum() > 60  # half a minute of two points a second, bow against the current
    assert np.hypot(*track[-22:, :2].T).min() < 1.1


def test_follow_another_vehicle():
    leader = {"vehicle": "remus100", "start": {"position_m": [6, 0, -6], "speed_mps": 0.6}, "mission": [
        {"type": "waypoints", "points": [[60, 0]], "depth_m": 6, "speed_mps": 0.6}]}  # fmt: skip
    mission = [{"type": "follow", "agent": "b", "offset_m": [-4, 2, 1], "seconds": 90}]
    track, sim = fly("bluerov2_heavy", mission, 60, start=[0, 0, -5], others={"b": leader}, waves=False)
    other = sim.state["b"]
    yaw = other.euler[0, 2]
    place = other.position[0] + [
        -4 * np.cos(yaw) - 2 * np.sin(yaw), -4 * np.sin(yaw) + 2 * np.cos(yaw), 1.0,
    ]  # fmt: skip
    assert np.linalg.norm(track[-1] - place) < 1.5


def test_follow_a_wall():
    """Beside the long side of a box, at 4 m, by an altimeter that looks to port."""
    wall = {"type": "flat", "depth_m": 20, "objects": []}
    sonar = {"side": {"type": "altimeter", "rate_hz": 10, "orientation_deg": [90, 0, 0]}}
    data = {
        "tick_rate_hz": 20, "duration_s": 60, "world": wall, "ocean": {"currents": CURRENT},
        "agents": {"a": {"vehicle": "bluerov2_heavy", "start": {"position_m": [0, 0, -8], "heading_deg": 0},
                         "mission": [{"type": "follow", "wall": "side", "distance_m": 4, "seconds": 55}],
                         "sensors": sonar}},
    }  # fmt: skip
    data["world"].pop("objects")
    sim = pl.Simulation.load(data)
    half = np.deg2rad(10) / 2  # a wall that leads 10 degrees to starboard of the start's heading
    turn = (np.cos(half), 0, 0, -np.sin(half))
    sim.spawn(pl.Prop("box", position=(20, 3.0, -10), size=(80, 2, 18), attitude=turn))
    sim.run(seconds=35)
    x, y, _ = sim.state["a"].position[0]
    normal = np.array([np.sin(np.deg2rad(10)), np.cos(np.deg2rad(10))])  # of the wall, to port
    distance = normal @ (np.array([20, 3.0]) - [x, y]) - 1.0
    assert distance == pytest.approx(4.0, abs=0.5)
    assert x > 12


def test_glider_and_flyers():
    track, sim = fly(
        "glider", [{"type": "profile", "lower_depth_m": 20, "cycles": 1}, {"type": "surface"}], 400, start=[0, 0, -2],
        tick=20, waves=False,
    )  # fmt: skip
    assert sim.stepper.missions_done()
    assert -23 < track[:, 2].min() < -19.5
    mission = [{"type": "waypoints", "points": [[300, 0], [300, -300]], "height_m": 60}]
    track, sim = fly("fixed_wing", mission, 60, start=[0, 0, 60], speed=25.0, waves=False)
    assert sim.stepper.missions_done()
    assert np.abs(track[:, 2] - 60).max() < 8
    mission = [{"type": "goto", "points": [[8, 0, 9], [8, -6, 9]], "heading_deg": 90}]
    track, sim = fly("quadrotor", mission, 60, start=[0, 0, 5], tick=100, waves=False)
    assert sim.stepper.missions_done()
    assert track[-1] == pytest.approx([8, -6, 9], abs=0.6)
    mission = [{"type": "waypoints", "points": [[900, 0]]}, {"type": "hold", "seconds": 20}]
    track, sim = fly("mariner", mission, 200, start=[0, 0, 0], speed=7.7, tick=10, waves=False)
    assert sim.stepper.missions_done()
    assert off_line(track[:200], (0, 0), (750, 0)) < 25


def test_external_navigation_is_what_a_mission_knows():
    """Told that it is 3 m further west than it is, a vehicle goes 3 m too far east; silent outsiders leave it at its
    start."""
    data = {
        "tick_rate_hz": 50, "duration_s": 60, "world": FLAT,
        "agents": {"a": {"vehicle": "bluerov2_heavy", "start": {"position_m": [0, 0, -6]}, "navigation": "external",
                         "mission": [{"type": "station_keeping", "seconds": 50, "point": [2, 0]}]}},
    }  # fmt: skip
    sim = pl.Simulation.load(data)
    for _ in range(300):
        s = sim.state["a"]
        known = s.position[0] + [0.0, 3.0, 0.0]
        sim.navigate("a", position=known, heading_rad=-s.euler[0, 2], velocity=(0, 0, 0))
        sim.run(seconds=0.1)
    assert sim.state["a"].position[0] == pytest.approx([2.0, -3.0, -6.0], abs=0.3)
    with pytest.raises(pl.errors.CommandError, match="position has shape"):
        sim.navigate("a", position=(1, 2), heading_rad=0.0)
    data["agents"]["a"]["navigation"] = "truth"
    with pytest.raises(pl.errors.CommandError, match="navigation: external"):
        pl.Simulation.load(data).navigate("a", position=(1, 2, 3), heading_rad=0.0)


@pytest.mark.parametrize(
    ("vehicle", "start", "heading_deg"),
    [
        pytest.param("couguv", [10, 10, -4], -40, marks=pytest.mark.slow),
        ("otter", [10, 10, 0], 150),
        pytest.param("couguv", [10, 10, -4], 150, marks=pytest.mark.slow),
        pytest.param("otter", [10, 10, 0], -40, marks=pytest.mark.slow),
    ],
)
def test_a_dock_with_its_default_approach_is_reached_abeam_of_a_current(vehicle, start, heading_deg):
    """The current of 60 degrees meets the axis from abeam; at the first attempt, within 1 m of the point in space."""
    dock = np.array([46.0, -46.0, -6.6] if start[2] else [46.0, -46.0, 0.0])
    leg = {"type": "dock", "point": dock[: 3 if start[2] else 2].tolist(), "heading_deg": heading_deg, "tolerance_m": 1}
    speed = 1.5 if start[2] else 0.0
    track, sim = fly(vehicle, [leg], 480, start=start, speed=speed, tick=20, waves=False)
    assert sim.stepper.missions_done()
    assert np.linalg.norm((track[-5:] - dock)[:, : 3 if start[2] else 2], axis=1).min() < 1.5  # the track is of 2 Hz


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_points_that_are_passed_as_fast_as_a_rov_can_go_hold_it_up_nowhere(side):
    """24 m at nearly its top speed of 0.84 m/s: the reference point waits at a corner without a speed of its own."""
    points = [[-6.4, -9.8 * side], [-10.0, -1.3 * side], [-10.3, -6.8 * side]]
    leg = {"type": "waypoints", "points": points, "depth_m": 9.1, "speed_mps": 0.86}
    _, sim = fly("bluerov2_heavy", [leg], 200, start=[0, 0, -9.1])
    assert sim.stepper.missions_done()
    assert sim.time_ns * 1e-9 < 90
