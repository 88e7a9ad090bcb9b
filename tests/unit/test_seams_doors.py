"""Small signs and factors between parts: each against its own formula, with unequal values of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.ardupilot import _back_to
from pelagos.bridges.autopilot import VehicleMotion
from pelagos.bridges.px4 import Px4Link
from pelagos.cli.doors import doors_of
from pelagos.compat.holoocean.sonars import SidescanSonar
from pelagos.contact.impulse import _Space
from pelagos.envs.tasks.wall_inspection import WallInspection
from pelagos.math.geodesy import GeoOrigin
from pelagos.report.soundings import Grid
from pelagos.report.survey import _extent
from pelagos.sim.guidance.aboard import Aboard, Fix
from pelagos.sim.guidance.plan import _follow
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common
from pelagos.sim.guidance.wait import Station
from pelagos.sim.trajectory import channels
from pelagos.vehicles.terms.ditching import DitchingConfig
from pelagos.viewer.drive import DEPTH_MPS, Axes, drive

Q = np.array([0.8, -0.3, 0.45, 0.26])
Q /= np.linalg.norm(Q)
MOTION = VehicleMotion((12.0, -7.0, 3.0), (0.4, -0.2, 0.1), tuple(Q.tolist()), (0.1, -0.2, 0.3), (1.5, -2.5, -9.0))


def rotation(q: Any) -> np.ndarray:
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def aboard(*headings: float) -> Aboard:
    n = len(headings)
    place = np.array([[3.0 + i, -5.0 * i, -2.0] for i in range(n)])
    fix = Fix(place, np.array(headings), np.zeros((n, 3)))
    return Aboard(fix, 4.0, 0.1, np.full(n, 9.0), np.zeros(n, bool))


@pytest.mark.parametrize(
    ("written", "asked", "opened"),
    [
        ({}, [], {}),
        ({}, ["rosbridge", "foxglove", "rosbridge"], {"rosbridge": "rosbridge", "foxglove": "foxglove"}),
        ({"page": "rosbridge"}, [], {"page": "rosbridge"}),
        ({"page": "rosbridge"}, ["rosbridge"], {"page": "rosbridge"}),
        ({"page": "rosbridge"}, ["foxglove"], {"page": "rosbridge", "foxglove": "foxglove"}),
    ],
)
def test_a_door_that_is_asked_for_by_type_is_opened_where_the_scenario_has_none(
    written: dict[str, str], asked: list[str], opened: dict[str, str]
) -> None:
    """What the scenario says of a door stays; one that it has not got has the defaults of its type."""
    bridges = {name: {"type": kind, "port": 4711} for name, kind in written.items()}
    auv = {"vehicle": "remus100", "start": {"depth_m": 5.0}}
    found = doors_of(pl.load_scenario({"world": {"type": "flat"}, "agents": {"auv": auv}, "bridges": bridges}), asked)
    assert {name: config.type for name, config in found.items()} == opened
    assert all((config.port == 4711) == (name in written) for name, config in found.items())


def test_a_name_that_is_another_type_keeps_its_door() -> None:
    bridges = {"rosbridge": {"type": "foxglove", "port": 4711}, "rosbridge_2": {"type": "foxglove", "port": 4712}}
    auv = {"vehicle": "remus100", "start": {"depth_m": 5.0}}
    scenario = pl.load_scenario({"world": {"type": "flat"}, "agents": {"auv": auv}, "bridges": bridges})
    found = doors_of(scenario, ["rosbridge"])
    assert list(found.items())[:2] == list(scenario.bridges.items())
    assert [(name, config.type) for name, config in list(found.items())[2:]] == [("rosbridge_3", "rosbridge")]


def test_acceleration_of_a_steady_turn_points_to_its_middle() -> None:
    """w x v: a body whose own velocity (2, -0.5, 0.3) does not change, turning at (0.1, -0.2, 0.4), forward-left-up."""
    v, w = np.array([2.0, -0.5, 0.3]), np.array([0.1, -0.2, 0.4])
    vehicle = pl.Vehicle.from_catalogue("remus100")
    state = vehicle.initial_state(np.array([[1.0, -2.0, -3.0]]), Q[None], v[None], w[None])
    found = np.array([np.array(c)[0] for c in channels(state)])
    assert found[7:10] == pytest.approx(v)
    assert found[13:16] == pytest.approx(np.cross(w, v), abs=1e-12)


def test_a_station_keeps_the_heading_that_it_began_with_or_looks_where_it_is_told() -> None:
    start, now = aboard(0.4, -1.1), aboard(2.0, 2.5)
    progress = Progress.begin(start)
    assert Station(9.0).goal(now, progress).face == pytest.approx([0.4, -1.1])
    told = Station(9.0, common=Common(face_rad=-0.7)).goal(now, progress)
    assert told.face == pytest.approx([-0.7, -0.7])


@pytest.mark.parametrize(("at", "first"), [((-40.0, 12.0), -30.0), ((50.0, 3.0), 30.0)])
def test_a_pipeline_is_followed_from_its_nearer_end(at: tuple[float, float], first: float) -> None:
    along = np.linspace(-30, 30, 61)
    corners = np.concatenate([np.column_stack([along, 0.2 * along + y, 0 * along - 9]) for y in (-0.1, 0.1)])
    pipe: Any = SimpleNamespace(name="pipe", vertices=corners)
    planner: Any = SimpleNamespace(
        common=lambda leg, number: Common(), where=lambda number: "mission.0", tolerance_m=2.0,
        world=SimpleNamespace(geometries=(pipe,)),
    )  # fmt: skip
    leg: Any = SimpleNamespace(agent=None, wall=None, pipeline="pipe")
    tasks: Any = _follow(planner, leg, 0, at)
    assert tasks[0].end[0] == pytest.approx(first, abs=1.0)
    assert tasks[-1].end[0] == pytest.approx(-first, abs=1.0)
    assert tasks[0].end[1] == pytest.approx(0.2 * first, abs=0.5)


def test_a_rebooted_autopilot_is_put_back_as_it_was() -> None:
    """NED and FRD to NWU and FLU: F R F, F = diag(1, -1, -1)."""
    data = _back_to(MOTION, "it").data
    flip = np.diag([1.0, -1.0, -1.0])
    assert rotation(data["attitude"]) == pytest.approx(flip @ rotation(Q) @ flip)
    assert data["position"] == [12.0, 7.0, -3.0]


def test_px4_hears_the_true_specific_force_in_thousandths_of_g() -> None:
    told: dict[str, Any] = {}
    link: Any = SimpleNamespace(
        _origin=GeoOrigin(36.8, -121.8),
        _dialect=SimpleNamespace(MAVLink_hil_state_quaternion_message=lambda *values: told.update(values=values)),
    )
    Px4Link._truth(link, MOTION, 77)
    values = told["values"]
    assert values[-3:] == tuple(pytest.approx(1000 * a / 9.80665, abs=1.0) for a in MOTION.force)
    assert values[1] == MOTION.attitude


def test_a_maps_edges_are_half_a_cell_beyond_its_outermost_middles() -> None:
    """East, which is -y, to the right; north upwards."""
    x, y = np.arange(10.0, 31.0, 2.0), np.arange(-7.0, 4.0, 2.0)
    nothing = np.zeros((len(x), len(y)))
    assert _extent(Grid(x, y, 2.0, nothing, nothing.astype(int))) == (-4.0, 8.0, 9.0, 31.0)


def test_a_stick_that_is_pulled_up_raises_the_height_that_is_asked_for() -> None:
    """By 0.4 m/s at full deflection, from the height that it flies at or was told."""
    asked: dict[str, Any] = {}
    vehicle = SimpleNamespace(
        name="plane", modes=("height_heading_speed",), command_names=lambda mode: ("height", "heading", "airspeed"),
        config=SimpleNamespace(envelope=SimpleNamespace(top_mps=30.0)),
    )  # fmt: skip
    state = SimpleNamespace(velocity=np.array([[17.0, 0, 0]]), euler=np.array([[0, 0, -0.6]]), depth=np.array([-42.0]))
    for mode, height in (("height_heading_speed", 55.0), ("other", 42.0)):
        sim: Any = SimpleNamespace(
            model=SimpleNamespace(agents={"it": SimpleNamespace(vehicle=vehicle)}), state={"it": state},
            stepper=SimpleNamespace(mode=lambda agent, mode=mode: mode),
            held_command=lambda agent: np.array([[55.0, 0.2, 16.0]]), command=asked.update,
            set_mode=lambda agent, mode: None,
        )  # fmt: skip
        drive(sim, "it", Axes(heave=0.5), 0.25)
        assert asked["it"][0] == pytest.approx(height + DEPTH_MPS * 0.5 * 0.25)


def test_a_wall_inspector_sees_tenths_of_its_depth_velocities_and_heading() -> None:
    task = WallInspection()
    state = SimpleNamespace(
        depth=np.array([3.0, 7.5]), euler=np.array([[0.1, 0.2, 0.9], [0, 0, -2.0]]),
        angular_velocity=np.array([[0.3, -0.4, 0.5], [0, 0, -0.6]]),
    )  # fmt: skip
    picture = SimpleNamespace(data=np.ones((2, 4, 3)))
    dvl = SimpleNamespace(data=np.array([[0.2, -0.3, 0.1], [9.0, 9.0, 9.0]]), valid=np.array([True, False]))
    sim: Any = SimpleNamespace(state={task.agent: state}, n=2)
    found = task.observe(sim, {"sonar": picture, "dvl": dvl})["state"]
    expected = [[0.3, 0.2, -0.3, 0.1, 0.5, math.sin(0.9)], [0.75, 0, 0, 0, -0.6, math.sin(-2.0)]]
    assert found == pytest.approx(np.array(expected), abs=1e-6)


@pytest.mark.parametrize("bins", [6, 7])
def test_a_sidescan_has_the_farthest_left_first(bins: int) -> None:
    reading: Any = SimpleNamespace(data=np.array([[[1.0, 2, 3, 4], [10.0, 20, 30, 40]]]))
    sonar: Any = SimpleNamespace(bins=bins)
    found = SidescanSonar.value(sonar, None, reading)  # type: ignore[arg-type]
    assert found.tolist() == ([3, 2, 1, 10, 20, 30] if bins == 6 else [4, 3, 2, 1, 10, 20, 30])


def test_drag_of_turning_under_water_grows_with_the_cube_of_the_size() -> None:
    """rho / 2 c A (s / 4)^3 at a quarter of the length: twice the size, eight times the drag, of the largest side."""
    config = DitchingConfig(type="ditching", volume_m3=0.01, area_m2=(0.1, 0.3, 0.2), density_kg_m3=1000.0)

    def drag(size: float) -> list[float]:
        body: Any = SimpleNamespace(length=0.8 * size, beam=0.6 * size, height=0.2 * size, rigid=np.eye(6), gravity=9.8)
        return list(config.build(body).drag)

    assert drag(1.0)[:3] == pytest.approx([50.0, 150.0, 100.0])
    assert drag(1.0)[3:] == pytest.approx([500 * 0.3 * 0.15**3] * 3)
    assert drag(2.0)[3:] == pytest.approx([8 * d for d in drag(1.0)[3:]])


def test_a_body_that_turns_with_what_it_lies_on_does_not_move_against_it() -> None:
    """v = v_0 + w x r, r from the platform to the body."""
    turn, frame = np.array([0.2, -0.1, 0.5]), np.array([1.0, 2.0, -0.3])
    position = np.array([[4.0, -3.0, 0.5], [1.0, 1.0, 0.2]])
    bodies: Any = SimpleNamespace(
        inverse_mass=np.stack([np.diag([2.0, 2, 2, 5, 6, 7.0]), np.zeros((6, 6))]), position=position,
        velocity=np.stack([frame + np.cross(turn, position[0] - position[1]), frame]), spin=np.stack([turn, turn]),
    )  # fmt: skip
    space = _Space(SimpleNamespace(), bodies, np.array([0]))  # type: ignore[arg-type]
    assert space.start(bodies, np.array([1])) == pytest.approx(np.zeros(6), abs=1e-12)
    assert np.abs(space.start(bodies, np.array([], dtype=np.int64))).max() > 0.1
