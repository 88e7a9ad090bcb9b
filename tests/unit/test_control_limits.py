"""Control laws by their own formulas where their limits bind: written out once more in NumPy, over a net of states."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from control_scene import ECHO, LANES, H, Scene, drawn, held, lanes, number, short

from pelagos.errors import ScenarioError
from pelagos.vehicles.actuators.thruster import ForceThrusterConfig
from pelagos.vehicles.control.depth import DepthGains, DepthMemory, stern_plane
from pelagos.vehicles.control.free_pitch import upright_heave
from pelagos.vehicles.control.heading import HeadingGains, HeadingMemory, rudder
from pelagos.vehicles.control.heading_thrust import HeadingThrust, HeadingThrustConfig
from pelagos.vehicles.control.place import PlaceConfig, PlaceControl
from pelagos.vehicles.control.reference import ReferenceModel
from pelagos.vehicles.control.rudder_heading import RudderHeadingConfig
from pelagos.vehicles.control.sawtooth import SawtoothConfig
from pelagos.vehicles.control.speed import SpeedGains, shaft_speed


def test_a_propeller_by_speed_stops_integrating_what_it_cannot_give() -> None:
    gains = SpeedGains(feed_forward_rpm_s_m=300.0, kp_rpm_s_m=150.0, ki_rpm_m=40.0, low_rpm=-200.0, high_rpm=900.0)
    integral, wanted, speed = drawn(2, 30.0, 2.5, 2.0)
    given, kept = shaft_speed(gains, lanes(integral), lanes(wanted), lanes(speed), lanes(H))
    error = wanted - speed
    asked = 300 * wanted + 150 * error + 40 * integral
    free = ((asked < 900) | (error < 0)) & ((asked > -200) | (error > 0))
    assert number(given) == pytest.approx(np.clip(asked, -200, 900), rel=1e-12)
    assert number(kept) == pytest.approx(held(free, integral, H * error), rel=1e-12)


@pytest.mark.parametrize("beyond", [None, 6.0])
def test_a_dive_is_limited_and_its_integrals_wait(beyond: float | None) -> None:
    gains = DepthGains(
        reference_rad_s=0.3, kp_depth=0.09, integral_s=30.0, kp_pitch=1.4, kd_pitch=0.8, ki_pitch=0.3, k_heave=0.2,
        pitch_limit_deg=25.0, dive_beyond_m=beyond, plane_limit_deg=30.0,
    )  # fmt: skip
    reference, z_sum, pitch_sum, wanted, depth, pitch, w, q = drawn(4, 9.0, 20.0, 0.7, 9.0, 9.0, 0.6, 0.3, 0.2)
    memory = DepthMemory(lanes(reference), lanes(z_sum), lanes(pitch_sum))
    found, kept = stern_plane(gains, memory, *(lanes(v) for v in (wanted, depth, pitch, w, q, H)))
    filtered = wanted + (reference - wanted) * math.exp(-0.3 * H)
    limit = math.radians(25.0)
    asked = 0.09 * (depth - filtered + z_sum / 30.0)
    aim = np.clip(asked, -limit, limit)
    if beyond is not None:
        aim = np.where(np.abs(depth - wanted) > beyond, limit * np.sign(depth - wanted), aim)
    plane = 1.4 * (pitch - aim) + 0.8 * q + 0.3 * pitch_sum + 0.2 * w
    within = np.abs(plane) < math.radians(30.0)
    back = plane * (pitch - aim) < 0
    assert number(found) == pytest.approx(plane, rel=1e-9)
    assert number(kept.reference) == pytest.approx(filtered, rel=1e-12)
    assert number(kept.pitch_integral) == pytest.approx(held(within | back, pitch_sum, H * (pitch - aim)), rel=1e-9)
    still = within & (asked == aim)
    assert number(kept.depth_integral) == pytest.approx(held(still, z_sum, H * (depth - filtered)), rel=1e-9)


@pytest.mark.parametrize("wraps", [True, False])
def test_a_rudder_waits_at_its_limit_and_its_reference_turns_no_faster(wraps: bool) -> None:
    gains = HeadingGains(
        nomoto_gain=0.6, nomoto_time_s=2.0, bandwidth=0.3, boundary=0.1, k_damping=0.4, k_switch=0.05,
        reference_rad_s=0.5, reference_damping=0.8, rate_limit_deg_s=6.0, short_way=wraps, rudder_limit_deg=25.0,
    )  # fmt: skip
    integral, x, v, a, wanted, heading, r = drawn(5, 2.0, 3.1, 0.15, 0.3, 3.1, 3.1, 0.2)
    memory = HeadingMemory(*(lanes(s) for s in (integral, x, v, a)))
    found, kept = rudder(gains, memory, lanes(wanted), lanes(heading), lanes(r), lanes(H))
    error = short(heading - x)
    virtual = v - 0.6 * error - 0.09 * integral
    sigma = r - virtual
    helm = (2.0 * (a - 0.6 * (r - v) - 0.09 * error) + virtual - 0.4 * sigma - 0.05 * np.clip(sigma / 0.1, -1, 1)) / 0.6
    free = (np.abs(helm) < math.radians(25.0)) | (helm * error > 0)
    assert number(found) == pytest.approx(helm, rel=1e-9)
    assert number(kept.integral) == pytest.approx(held(free, integral, H * error), rel=1e-9)
    fastest = math.radians(6.0)
    to_go = short(wanted - x) if wraps else wanted - x
    moved = x + H * v
    assert number(kept.heading) == pytest.approx(short(moved) if wraps else moved, abs=1e-12)
    assert number(kept.rate) == pytest.approx(np.clip(v + H * a, -fastest, fastest), rel=1e-12)
    jerk = 0.5**3 * to_go - 2.6 * 0.5**2 * v - 2.6 * 0.5 * a
    assert number(kept.acceleration) == pytest.approx(a + H * jerk, rel=1e-9)
    assert 0.1 < (np.abs(v + H * a) > fastest).mean() < 0.9
    if wraps:
        model = ReferenceModel(0.5, 0.8, 1.0, angle=True)
        assert number(model.step(lanes(3.1), lanes(2.0), lanes(0.0), lanes(0.0), lanes(H))[0])[0] == pytest.approx(
            3.18 - 2 * math.pi
        )


def test_a_helm_by_its_pid_waits_at_its_limit() -> None:
    law = RudderHeadingConfig(
        type="rudder_heading", rudder="helm", kp=1.2, kd_s=0.9, ki_1_s=0.2, limit_deg=30.0, orders={"engine": 1.7}
    ).build(None)  # type: ignore[arg-type]
    scene, (integral, wanted) = Scene(6), drawn(7, 3.0, 4.0)
    demand, kept = law.act([lanes(integral)], scene.flow, [lanes(wanted)], lanes(H))
    error, limit = short(wanted - scene.euler[:, 2]), math.radians(30.0)
    asked = 1.2 * error - 0.9 * scene.nu[:, 5] + 0.2 * integral
    assert demand.actuators["engine"] == 1.7
    assert number(demand.actuators["helm"]) == pytest.approx(np.clip(asked, -limit, limit), rel=1e-9)
    free = (np.abs(asked) < limit) | (asked * error < 0)
    assert number(kept[0]) == pytest.approx(held(free, integral, H * error), rel=1e-9)


@pytest.mark.parametrize("wraps", [True, False])
def test_a_surface_craft_holds_heading_and_speed_as_far_as_it_can(wraps: bool) -> None:
    surge = {"kp_kg_s": 40.0, "ki_kg_s2": 8.0, "drag_kg_s": 5.0, "drag_kg_m": 7.0, "limit_n": 60.0}
    config = HeadingThrustConfig.model_validate({
        "type": "heading_thrust", "inertia_kg_m2": 30.0, "damping_kg_m2_s": 9.0, "frequency_rad_s": 0.8, "ratio": 0.7,
        "reference_rad_s": 0.5, "reference_damping": 1.0, "rate_limit_deg_s": 9.0, "short_way": wraps,
        "moment_limit_n_m": 25.0, "surge": surge,
    })  # fmt: skip
    scene = Scene(8)
    integral, x, v, a, speeds, heading, wanted = drawn(9, 8.0, 3.1, 0.1, 0.02, 6.0, 3.1, 2.5)
    law = HeadingThrust(config, ECHO)
    memory = [lanes(m) for m in (integral, x, v, a, speeds)]
    demand, kept = law.act(memory, scene.flow, [lanes(heading), lanes(wanted)], lanes(H))
    error = scene.euler[:, 2] - x
    error = short(error) if wraps else error
    kp, kd = 30.0 * 0.8**2, 2 * 30.0 * 0.7 * 0.8 - 9.0
    moment = -kp * error - kd * (scene.nu[:, 5] - v) - kp * 0.8 / 10 * integral
    assert number(demand.actuators[5]) == pytest.approx(moment, rel=1e-9)
    free = (np.abs(moment) < 25.0) | (moment * error > 0)
    assert number(kept[0]) == pytest.approx(held(free, integral, H * error), rel=1e-9)
    slow = wanted - (scene.nu[:, 0] - scene.water[:, 0])
    asked = 5.0 * wanted + 7.0 * np.abs(wanted) * wanted + 40.0 * slow + 8.0 * speeds
    assert number(demand.actuators[0]) == pytest.approx(np.clip(asked, -60.0, 60.0), rel=1e-9)
    free = ((asked < 60) | (slow < 0)) & ((asked > -60) | (slow > 0))
    assert number(kept[4]) == pytest.approx(held(free, speeds, H * slow), rel=1e-9)


def test_a_boat_pulls_and_turns_no_harder_than_it_may() -> None:
    config = PlaceConfig(
        type="place", pull_n_m=5.0, brake_kg_s=20.0, pull_limit_n=60.0, turn_n_m=30.0, turn_damping=7.0,
        turn_limit_n_m=40.0,
    )  # fmt: skip
    scene, (x, y) = Scene(10), drawn(11, 25.0, 25.0)
    demand, _ = PlaceControl(config, ECHO).act([], scene.flow, [lanes(x), lanes(y)], lanes(H))
    north, east = x - scene.place[:, 0], -y - scene.place[:, 1]
    bearing = short(np.arctan2(east, north) - scene.euler[:, 2])
    pull = 5.0 * np.hypot(north, east) * np.maximum(np.cos(bearing), 0) - 20.0 * scene.nu[:, 0]
    moment = 30.0 * bearing - 7.0 * scene.nu[:, 5]
    assert number(demand.actuators[0]) == pytest.approx(np.clip(pull, -60, 60), rel=1e-9, abs=1e-9)
    assert number(demand.actuators[5]) == pytest.approx(np.clip(moment, -40, 40), rel=1e-9)
    for asked, most in ((pull, 60.0), (moment, 40.0)):
        assert (np.abs(asked) < most).mean() > 0.05
        assert (asked > most).mean() > 0.05
    assert (moment < -40).mean() > 0.05


def test_heave_that_the_flow_tilts_goes_by_the_square_of_the_way() -> None:
    """w = sinking (1 - (V/V0)^2), undone where that is beyond 1, limited to 0.2 V0^2/V; the water's own w besides."""
    scene, (sinking,) = Scene(12, fast=5.0), drawn(13, 0.8)
    current = drawn(14, 0.5, 0.4, 0.3)
    found = number(upright_heave(scene.flow, lanes(sinking), [lanes(c) for c in current], 2.0))
    water = np.einsum("nji,nj->ni", scene.rotation, np.stack(current, -1))
    way = scene.nu[:, 0] - water[:, 0]
    factor = 1 - (way / 2.0) ** 2
    slow = np.where(np.abs(factor) <= 1, sinking * factor, sinking / factor)
    most = 0.2 * 4.0 / np.abs(way)
    assert 0.05 < (np.abs(slow) > most).mean() < 0.9
    assert 0.1 < (factor < -1).mean() < 0.9
    assert found == pytest.approx(water[:, 2] + np.clip(slow, -most, most), rel=1e-9)


def test_a_glider_steers_by_the_way_that_it_goes() -> None:
    """Astern its rudder acts the other way; mass and rudder stop at their limits, and the mass's integral with them."""
    law = SawtoothConfig(
        type="sawtooth",
        buoyancy_engine="b",
        moving_mass="m",
        rudder="r",
        volume_m3=3e-4,
        kp_pitch_m=0.1,
        ki_pitch_m_s=0.02,
        mass_limit_m=0.04,
        kp_heading=0.8,
        kd_heading_s=0.5,
        rudder_limit_deg=20.0,
    ).build(None)  # type: ignore[arg-type]
    scene, (integral, heading) = Scene(15), drawn(16, 2.0, 3.1)
    was = np.where(np.arange(LANES) % 2 == 0, 1.0, -1.0)
    upper, lower = lanes(-12.0), lanes(15.0)
    demand, kept = law.act(
        [lanes(was), lanes(integral)], scene.flow, [upper, lower, lanes(0.4), lanes(heading)], lanes(H)
    )
    depth = scene.place[:, 2]
    sinking = np.where(depth >= 15, -1.0, np.where(depth <= -12, 1.0, was))
    error = -sinking * 0.4 - scene.euler[:, 1]
    asked = -0.1 * error - 0.02 * integral
    free = (np.abs(asked) < 0.04) | (asked * error > 0)
    steer = np.sign(scene.nu[:, 0] - scene.water[:, 0]) * (
        0.8 * short(heading - scene.euler[:, 2]) - 0.5 * scene.nu[:, 5]
    )
    limit = math.radians(20.0)
    assert number(demand.actuators["b"]) == pytest.approx(-sinking * 3e-4, rel=1e-12)
    assert number(demand.actuators["m"]) == pytest.approx(np.clip(asked, -0.04, 0.04), rel=1e-9)
    assert number(demand.actuators["r"]) == pytest.approx(np.clip(steer, -limit, limit), rel=1e-9)
    assert number(kept[0]) == pytest.approx(sinking)
    expected = np.where(sinking == was, held(free, integral, H * error), -integral)
    assert number(kept[1]) == pytest.approx(expected, rel=1e-9)


def test_thrust_by_the_coefficient_for_ahead_needs_thrusters_that_have_one() -> None:
    """Those that are commanded by their force have none: told before a run, and not in its first step."""
    keys = {
        "type": "heading_thrust", "inertia_kg_m2": 30.0, "damping_kg_m2_s": 9.0, "frequency_rad_s": 0.8,
        "reference_rad_s": 0.5, "rate_limit_deg_s": 9.0,
    }  # fmt: skip
    force = {"type": "force_thruster", "low_n": -30, "high_n": 50, "time_constant_s": 0.1, "direction": [1, 0, 0]}
    in_air: Any = SimpleNamespace(in_air=True, density=1.2)
    sides = {
        name: ForceThrusterConfig.model_validate({**force, "position_m": [0, y, 0]}).build(in_air)
        for name, y in (("left", -0.4), ("right", 0.5))
    }
    plant: Any = SimpleNamespace(model=SimpleNamespace(actuators=sides))
    assert HeadingThrustConfig.model_validate(keys).build(plant).allocation.limits == [(-30.0, 50.0)] * 2
    with pytest.raises(ScenarioError, match=r"type thruster, .* 'left' has none: give allocation: saturated"):
        HeadingThrustConfig.model_validate({**keys, "allocation": "forward_coefficient"}).build(plant)
