"""Autopilot of torpedo-shaped vehicles: signs, wrapping, saturation, changes of mode."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "verification"))
from vehicle_flight import Still, fly, quaternion

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.vehicles.flow import make_flow, rotation_from_euler
from pelagos.vehicles.vehicle import Vehicle


@pytest.fixture(scope="module")
def remus() -> Vehicle:
    return Vehicle.from_catalogue("remus100")


def wrapped(angle):
    return np.angle(np.exp(1j * angle))


def test_350_to_10_degrees_turns_the_short_way(remus):
    start = np.deg2rad(350)
    flight = fly(
        remus,
        150.0,
        h=0.05,
        command=(50.0, np.deg2rad(10), 1.5),
        attitude=quaternion(yaw=start),
        nu=(1.5, 0, 0, 0, 0, 0),
    )
    turned = np.cumsum(wrapped(np.diff(flight.euler[:, 2])))
    assert turned[-1] == pytest.approx(np.deg2rad(20), abs=np.deg2rad(0.5))
    assert turned.min() > np.deg2rad(-2)
    assert turned.max() < np.deg2rad(25)


@pytest.mark.parametrize("heading", [np.pi, -np.pi, 3 * np.pi, np.deg2rad(-170)])
def test_heading_set_points_may_be_written_with_any_number_of_turns(remus, heading):
    flight = fly(remus, 200.0, h=0.05, command=(50.0, heading, 1.8), nu=(1.5, 0, 0, 0, 0, 0))
    assert abs(wrapped(flight.euler[-1, 2] - heading)) < np.deg2rad(0.5)


def test_the_reference_begins_where_the_vehicle_is(remus):
    """Entering the mode on the set-points moves neither rudder nor plane by more than trim."""
    flight = fly(remus, 20.0, h=0.05, command=(50.0, 2.0, 1.5), attitude=quaternion(yaw=2.0), nu=(1.5, 0, 0, 0, 0, 0))
    assert np.abs(flight.actuators[:, 0]).max() < np.deg2rad(1)
    assert np.abs(flight.position[:, 2] - 50).max() < 0.6


def test_depth_and_speed_are_reached_in_a_current(remus):
    flight = fly(
        remus,
        400.0,
        h=0.05,
        command=(60.0, 1.0, 1.6),
        attitude=quaternion(yaw=1.0),
        nu=(1.5, 0, 0, 0, 0, 0),
        ocean=Still((0.2, 0.3, 0.0)),
    )
    late = flight.t > 350
    assert np.abs(flight.position[late, 2] - 60).max() < 0.3
    current = np.array([0.2, -0.3, 0.0])
    yaw = flight.euler[late, 2]
    through_water = flight.nu[late, 0] - (current[0] * np.cos(yaw) + current[1] * np.sin(yaw))
    assert through_water == pytest.approx(1.6, abs=0.01)
    assert np.abs(flight.euler[late, 1]).max() < np.deg2rad(3)


def test_a_deep_dive_saturates_and_does_not_wind_up(remus):
    """A step of 100 m: pitch stays near its limit, and depth overshoots by less than a tenth."""
    flight = fly(remus, 900.0, h=0.05, command=(150.0, 0.0, 2.0), nu=(2.0, 0, 0, 0, 0, 0))
    assert np.abs(flight.euler[:, 1]).max() < np.deg2rad(35)
    assert flight.position[:, 2].max() < 160
    assert flight.position[-1, 2] == pytest.approx(150, abs=0.5)
    assert np.abs(flight.actuators[:, :2]).max() <= np.deg2rad(15) + 1e-12


@pytest.mark.parametrize(
    ("command", "axis", "sign"),
    [
        ((0.1, 0.0, 1200.0), 2, 1),  # rudder: positive turns to starboard
        ((0.0, 0.1, 1200.0), 1, -1),  # stern plane: positive brings the nose down
    ],
)
def test_signs_of_the_planes(remus, command, axis, sign):
    flight = fly(remus, 5.0, mode="actuators", command=command, nu=(1.8, 0, 0, 0, 0, 0))
    assert sign * flight.euler[-1, axis] > np.deg2rad(3)


def test_an_unknown_mode_is_refused_with_the_nearest(remus):
    with pytest.raises(LookupFailed, match="did you mean 'depth_heading'"):
        remus.command_names("depth_headin")


def test_fins_of_an_x_tail_steer_and_pitch_together(remus):
    """Each gets its share of the rudder's deflection and its share of the plane's, whoever has the others."""
    config = remus.controllers["depth_heading"].config
    flow = make_flow(
        [jit.Float64(v) for v in (3.0, -4.0, 50.0)], rotation_from_euler(*(jit.Float64(a) for a in (0.1, -0.05, 0.4))),
        [jit.Float64(v) for v in (1.5, 0.1, 0.05, 0.02, -0.03, 0.04)], [0.0] * 3,
    )  # fmt: skip
    command = [jit.Float64(v) for v in (57.0, 0.9, 1.5)]

    def asked(rudder, stern_plane):
        law = config.model_copy(update={"rudder": rudder, "stern_plane": stern_plane}).build(None)
        demand = law.act(law.start(flow), flow, command, jit.Float64(0.05))[0].actuators
        return {name: float(jit.Float64(v)[0]) for name, v in demand.items() if name != config.propeller}

    apart = asked({"r": 1.0}, {"s": 1.0})
    assert min(map(abs, apart.values())) > 0.01
    shares = {"a": (1.0, -0.7), "b": (-1.0, -0.8), "c": (0.9, 0.0)}
    found = asked({n: r for n, (r, _) in shares.items()}, {n: s for n, (_, s) in shares.items() if s})
    assert found == pytest.approx({n: r * apart["r"] + s * apart["s"] for n, (r, s) in shares.items()})
