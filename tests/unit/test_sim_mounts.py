"""Sensors that begin inside something solid, and sonars that begin in the air."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import pelagos as pl
from cases import slow
from pelagos.errors import MountWarning
from pelagos.math.so3 import rotate_np
from pelagos.raycast.geometry import Geometry
from pelagos.sim.mounts import _within, winding_number
from pelagos.world.shapes import sphere


def scenario(arm, *, kind="altimeter", second=None, depth=8.0):
    agents = {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0},
            "sensors": {"it": {"type": kind, "rate_hz": 5, "position_m": list(arm)}},
        }
    }
    if second is not None:
        agents["auv1"] = {"vehicle": "remus100", "start": {"position_m": list(second), "depth_m": 5.0}}
    return {"world": {"type": "flat", "depth_m": depth}, "agents": agents}


def test_a_mount_below_the_seabed_is_told_with_place_and_remedy():
    with pytest.warns(
        MountWarning, match=r"agents\.auv0\.sensors\.it.*\(1\.00, 0\.00, -8\.50\) m lies inside the seabed"
    ) as told:
        pl.Simulation.load(scenario((1.0, 0.0, -3.5)))
    assert "position_m, which is [1, 0, -3.5]" in str(told[0].message)


def test_a_mount_inside_another_hull_is_told():
    with pytest.warns(MountWarning, match="lies inside auv1"):
        pl.Simulation.load(scenario((0.0, 0.6, 0.0), second=(0.0, 0.6)))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_mount_at_the_end_of_a_long_arm_is_told_inside_a_hull_out_there(side):
    """Hulls of 1.6 m, 4 m apart: what is near goes by the arm too."""
    with pytest.warns(MountWarning, match=r"auv0\.sensors\.it.*lies inside auv1"):
        pl.Simulation.load(scenario((0.3, 4.0 * side, 0.05), second=(0.3, 4.0 * side)))


def test_a_mount_inside_a_body_that_moves_by_itself_is_told():
    path = {"kind": "waypoints", "points_m": [[0.1, 1.2, -5.2], [9.0, 1.2, -5.2]], "speed_mps": 0.5}
    said = scenario((0.0, 1.2, 0.0))
    said["world"]["movers"] = [{"name": "crate", "body": "box", "size_m": 1.0, "path": path}]
    with pytest.warns(MountWarning, match=r"\(0\.00, 1\.20, -5\.00\) m lies inside .*crate"):
        pl.Simulation.load(said)


def test_a_mount_turns_with_its_vehicle():
    """Heading east: forward is -y, and to the left +x."""
    said = scenario((1.0, 0.4, -3.5))
    said["agents"]["auv0"]["start"]["heading_deg"] = 90.0
    with pytest.warns(MountWarning, match=r"\(0\.40, -1\.00, -8\.50\) m lies inside the seabed"):
        pl.Simulation.load(said)


def test_a_place_is_within_a_body_where_that_has_turned_to():
    """A ball of 0.3 m off the body's origin: inside are places nearer than that to R c + p."""
    mesh, middle = sphere(0.3, sides=24, rings=12), np.array([0.9, -0.4, 0.2])
    ball = Geometry(np.asarray(mesh.vertices) + middle, mesh.faces, 0, 1, 1)
    half = 0.5 * 1.1 * np.array([2.0, -1.0, 2.0]) / 3.0  # by 1.1 rad
    attitude, position = np.array([np.cos(0.55), *np.sin(0.55) * half / 0.55]), np.array([5.0, -3.0, -7.0])
    (centre,) = rotate_np(attitude[None], middle[None]) + position
    for step in np.concatenate([np.eye(3), -np.eye(3)]):
        assert _within(centre + 0.25 * step, [(ball, position, attitude, "it")]) == "lies inside it"
        assert _within(centre + 0.35 * step, [(ball, position, attitude, "it")]) is None


@pytest.mark.parametrize("arm", [(0.3, 0.0, 0.0), (0.0, 0.0, -2.5)])
def test_mounts_inside_the_own_hull_or_in_the_water_are_fine(arm):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario(arm))


def test_a_sonar_above_the_water_is_told_and_hears_nothing():
    with pytest.warns(MountWarning, match=r"sensors\.it.*lies 1 m above the water: it hears nothing there"):
        sim = pl.Simulation.load(scenario((0.0, 0.0, 6.0), depth=20.0))
    assert "it" not in sim.reset()["auv0"]


TIDE = [{"amplitude_m": 1.5, "period_h": 12.0, "phase_deg": 0.0}]
LOW_TIDE = [{"amplitude_m": 1.5, "period_h": 12.0, "phase_deg": 180.0}]
CREST = {"type": "regular", "height_m": 3.0, "period_s": 9.0}


@pytest.mark.parametrize(
    ("ocean", "height", "told"),
    [
        ({}, 0.04, None),  # its face is 10 cm high
        ({}, 0.06, "0.06"),
        ({"tide": TIDE}, 1.2, None),
        ({"tide": TIDE}, 2.2, "0.7"),
        ({"tide": LOW_TIDE}, 0.8, "0.8"),
        ({"tide": LOW_TIDE}, -0.8, None),
        ({"waves": [CREST]}, 1.2, None),
        ({"waves": [CREST]}, 2.2, "0.7"),
        ({"waves": [CREST | {"phase_deg": 180.0}]}, 0.8, "0.8"),
        ({"waves": [CREST], "tide": TIDE}, 2.7, None),
        ({"waves": [CREST], "tide": TIDE}, 3.4, "0.4"),
    ],
)
def test_a_sonar_is_above_the_water_only_over_both_the_mean_sea_and_its_surface(ocean, height, told):
    """At the origin, where the crest is at the start; 5 m below it begins the vehicle."""
    said = scenario((0.0, 0.0, 5.0 + height), depth=20.0) | {"ocean": ocean}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pl.Simulation.load(said)
    above = [str(w.message) for w in caught if issubclass(w.category, MountWarning)]
    assert len(above) == (told is not None)
    assert told is None or f"lies {told} m above the water" in above[0]


def test_the_surface_is_asked_for_where_the_sonar_is():
    """A quarter of a wave north of the crest the surface is at the mean sea, half of one west of it is as high."""
    length = 9.80665 * 9.0**2 / (2 * np.pi)
    said = [scenario((x, y, 6.0), depth=20.0) | {"ocean": {"waves": [CREST]}}
            for x, y in ((0.25 * length, 0.0), (0.0, 0.5 * length))]  # fmt: skip
    with pytest.warns(MountWarning, match="lies 1 m above the water"):
        pl.Simulation.load(said[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(said[1])


def test_a_camera_may_be_in_the_air():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario((0.0, 0.0, 6.0), kind="depth_camera", depth=20.0))


def test_sensors_that_cast_no_rays_may_be_anywhere():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(scenario((0.0, 0.0, -3.5), kind="imu"))


def test_winding_number_of_a_ball():
    mesh = sphere(1.0, sides=24, rings=12)
    ball = Geometry(np.asarray(mesh.vertices), mesh.faces, 0, 1, 1)
    assert winding_number(ball, np.array([0.2, -0.3, 0.4])) == pytest.approx(1.0, abs=1e-9)
    assert winding_number(ball, np.array([0.9, 0.9, 0.0])) == pytest.approx(0.0, abs=1e-9)


def boat(kind, vehicle="otter", **keys):
    sensors = {"it": {"type": kind, **keys}}
    return {"world": {"type": "flat", "depth_m": 30}, "agents": {"usv": {"vehicle": vehicle, "sensors": sensors}}}


@pytest.mark.parametrize(("z", "why"), [(-0.15, "0.15 m below the water line"), (0, "in the water line")])
@pytest.mark.parametrize("kind", ["gps", "ais", "radio"])
def test_an_antenna_under_the_water_line_is_told_with_what_to_write(kind, z, why):
    with pytest.warns(MountWarning) as told:
        pl.Simulation.load(boat(kind, position_m=[0.2, -0.1, z]))
    text = str(told[0].message)
    assert text.startswith(f"agents.usv.sensors.it.position_m: otter has it {why} at rest")
    assert text.endswith("leave out position_m, or write [0, 0, 0.7], its antenna")


def test_an_instrument_for_the_water_above_it_is_told():
    with pytest.warns(
        MountWarning, match=r"it 0\.3 m above the water line at rest: it is in the air there; .* its keel"
    ):
        pl.Simulation.load(boat("ctd", position_m=[0.2, -0.1, 0.3]))


@pytest.mark.parametrize("z", [0.0, -0.1])
def test_an_instrument_in_the_water_line_or_below_it_is_fine(z):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pl.Simulation.load(boat("ctd", position_m=[0.2, -0.1, z]))


WATER = ("dvl", "altimeter", "singlebeam", "multibeam", "adcp", "ctd", "current_meter", "modem", "usbl")
FLOATS = (
    "otter", "wamv", "surface_vessel", "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate",
    "zeefakkel", "navalvessel",
)  # fmt: skip


@pytest.mark.parametrize("vehicle", [n if n in ("otter", "semisub", "frigate") else slow(n) for n in FLOATS])
def test_sensors_of_a_craft_stand_where_they_work_unless_they_say_where(vehicle):
    """In a sea of 0.5 m (state 2) the gps has every fix, and the instruments for the water are below the water line."""
    kinds = {"gps": {"type": "gps", "rate_hz": 1}, "ctd": {"type": "ctd", "rate_hz": 1}}
    scene = boat("dvl", vehicle, rate_hz=1)
    scene["agents"]["usv"]["sensors"] |= kinds
    scene |= {"tick_rate_hz": 10, "ocean": {"waves": [{"type": "sea_state", "state": 2}]}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim = pl.Simulation.load(scene)
        below = boat("gps", vehicle)
        below["agents"]["usv"]["sensors"] = {kind: {"type": kind} for kind in WATER}
        of_water = pl.Simulation.load(below).scenario.agents["usv"].sensors
        assert all(of_water[kind].position_m[2] < 0 for kind in WATER)
    for _ in range(20):
        seen = sim.step(ticks=10)["usv"]
        assert {"gps", "ctd", "it"} <= set(seen)
    mounts = sim.model.agents["usv"].vehicle.config.mounts
    assert sim.scenario.agents["usv"].sensors["gps"].position_m == mounts["antenna"]


def test_a_place_that_is_given_stays():
    sensors = pl.Simulation.load(boat("gps", position_m=[0.3, -0.2, 0.5])).scenario.agents["usv"].sensors
    assert sensors["it"].position_m == (0.3, -0.2, 0.5)
    raised = boat("gps")
    raised["agents"]["usv"]["vehicle"] = {"type": "otter", "mounts": {"antenna": [0.1, -0.3, 1.4]}}
    assert pl.Simulation.load(raised).scenario.agents["usv"].sensors["it"].position_m == (0.1, -0.3, 1.4)
