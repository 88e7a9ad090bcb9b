"""Laws of what flies, and of thrusters together, written out once more in NumPy over a net of states: limits bind."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from control_scene import ECHO, LANES, H, Scene, drawn, held, lanes, number, short
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.vehicles.control.acceleration import Carried
from pelagos.vehicles.control.airplane import AirplaneConfig
from pelagos.vehicles.control.allocation import Allocation, unsaturated
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.attitude import Attitude, AttitudeConfig
from pelagos.vehicles.control.multirotor import Multirotor, MultirotorConfig
from pelagos.vehicles.control.pose import PoseConfig, PoseControl, attitude_error
from pelagos.vehicles.control.world_acceleration import from_world


def test_an_aeroplane_climbs_banks_and_integrates_within_bounds() -> None:
    gains = {
        "kp_height": 0.01, "ki_height": 0.01, "pitch_limit_deg": 20.0, "kp_pitch": 0.9, "kd_pitch_s": 0.2,
        "kp_heading": 1.1, "bank_limit_deg": 35.0, "kp_roll": 0.7, "kd_roll_s": 0.15, "k_yaw_s": 0.3, "kp_speed": 12.0,
        "ki_speed": 3.0, "trim_drive": 400.0,
    }  # fmt: skip
    names = {"elevator": "e", "aileron": "a", "rudder": "r", "propeller": "p"}
    law = AirplaneConfig.model_validate({"type": "airplane", **names, **gains}).build(None)  # type: ignore[arg-type]
    scene = Scene(17, fast=20.0)
    heights, speeds, height, heading = drawn(18, 30.0, 70.0, 45.0, 3.1)
    speed = np.where(np.arange(LANES) % 4 == 0, 0.3, 25.0)
    demand, kept = law.act(
        [lanes(heights), lanes(speeds)], scene.flow, [lanes(height), lanes(heading), lanes(speed)], lanes(H)
    )
    higher = np.clip(height + scene.place[:, 2], -20, 20)
    asked, most = 0.01 * higher + 0.01 * heights, math.radians(20)
    pitch = np.clip(asked, -most, most)
    bank = np.clip(1.1 * short(heading - scene.euler[:, 2]), -math.radians(35), math.radians(35))
    faster = speed - np.linalg.norm(scene.nu[:, :3] - scene.water, axis=1)
    total = np.clip(speeds + H * faster, -50, 50)
    p, q, r = scene.nu[:, 3:].T
    found = {name: number(demand.actuators[name]) for name in "earp"}
    assert found["e"] == pytest.approx(0.9 * (scene.euler[:, 1] - pitch) + 0.2 * q, rel=1e-9)
    assert found["a"] == pytest.approx(0.7 * (bank - scene.euler[:, 0]) - 0.15 * p, rel=1e-9)
    assert found["r"] == pytest.approx(0.3 * (r - 9.81 * np.tan(bank) / np.maximum(speed, 1)), rel=1e-9)
    assert found["p"] == pytest.approx(400 + 12 * faster + 3 * total, rel=1e-9)
    assert number(kept[0]) == pytest.approx(held(np.abs(asked) < most, heights, H * higher), rel=1e-9)
    assert number(kept[1]) == pytest.approx(total, rel=1e-12)


ROTORS: dict[str, Any] = {
    "frequency_rad_s": 1.5,
    "turn_frequency_rad_s": 8.0,
    "ratio": 0.8,
    "integral": 0.3,
    "reach_m": 3.0,
}
FRAME: Any = (2.5, [0.02, 0.03, 0.05], 9.8, ECHO)  # mass, moments of inertia, gravity


@pytest.mark.parametrize("h", [0.004, 0.05])
def test_sticks_of_a_multirotor_have_their_bounds(h: float) -> None:
    """Frequency of turns min(8, 0.2/h); lag of the nose within 0.5 rad, height within 3 m; thrust of 0.3 g at least."""
    scene, (turned, climbed, roll, pitch, rate, z) = Scene(19), drawn(20, 0.7, 4.0, 0.6, 0.6, 0.9, 35.0)
    law = Attitude(AttitudeConfig.model_validate({"type": "attitude", **ROTORS}), *FRAME)
    given = [lanes(v) for v in (roll, pitch, rate, z)]
    demand, kept = law.act([lanes(climbed), lanes(turned)], scene.flow, given, lanes(h))
    f = min(8.0, 0.2 / h)
    asked = {k: number(v) for k, v in demand.actuators.items()}
    down = scene.rotation[:, 2]
    for k, error in ((0, roll - scene.euler[:, 0]), (1, -pitch - scene.euler[:, 1])):
        moment = FRAME[1][k] * (f * f * short(error) - 2 * 0.8 * f * scene.nu[:, 3 + k])
        assert asked[3 + k] == pytest.approx(moment, rel=1e-9)
    slow = -rate - scene.nu[:, 5]
    lag = np.clip(turned + h * slow, -0.5, 0.5)
    assert asked[5] == pytest.approx(0.05 * f * (slow + 0.25 * f * lag), rel=1e-9)
    near = np.clip(-z - scene.place[:, 2], -3, 3)
    kept_height = np.clip(climbed + h * 1.5 * 0.3 * near, -3, 3)
    sinking = np.einsum("ni,ni->n", down, scene.nu[:, :3])
    wanted = 1.5**2 * (near + kept_height) - 2 * 0.8 * 1.5 * sinking
    lift = np.maximum(9.8 - wanted, 0.3 * 9.8)
    assert asked[2] == pytest.approx(-2.5 * lift / np.maximum(down[:, 2], 0.3), rel=1e-9)
    assert 0.05 < (9.8 - wanted < 0.3 * 9.8).mean() < 0.9
    assert [number(k) for k in kept] == [pytest.approx(kept_height, rel=1e-12), pytest.approx(lag, rel=1e-12)]


@pytest.mark.parametrize("h", [0.004, 0.05])
def test_a_multirotor_tilts_no_further_than_it_may(h: float) -> None:
    """Thrust along the wanted acceleration less gravity, leaning 25 deg at most; turned by Lee's error of attitudes."""
    scene = Scene(21)
    config = MultirotorConfig.model_validate({"type": "multirotor", **ROTORS, "moving": True, "tilt_limit_deg": 25.0})
    law = Multirotor(config, *FRAME)
    sums = np.stack(drawn(22, 4.0, 4.0, 4.0), -1)
    given = np.stack(drawn(23, 30.0, 30.0, 30.0, 3.1, 2.0, 2.0, 2.0), -1)
    demand, kept = law.act([lanes(s) for s in sums.T], scene.flow, [lanes(g) for g in given.T], lanes(h))
    f = min(8.0, 0.2 / h)
    w, flip = min(1.5, f / 5), np.array([1.0, -1.0, -1.0])
    near = np.clip(given[:, :3] * flip - scene.place, -3, 3)
    now = np.clip(sums + h * w * 0.3 * near, -3, 3)
    speed = np.einsum("nij,nj->ni", scene.rotation, scene.nu[:, :3]) - given[:, 4:] * flip
    wanted = w * w * (near + now) - 2 * 0.8 * w * speed
    lift = np.maximum(9.8 - wanted[:, 2], 0.3 * 9.8)
    across = np.hypot(wanted[:, 0], wanted[:, 1])
    share = np.minimum(1.0, math.tan(math.radians(25)) * lift / across)
    assert 0.1 < (share < 1).mean() < 0.95 or h > 0.01
    thrust = np.stack([share * wanted[:, 0], share * wanted[:, 1], -lift], -1)
    down = -thrust / np.linalg.norm(thrust, axis=1, keepdims=True)
    ahead = np.stack([np.cos(given[:, 3]), -np.sin(given[:, 3]), 0 * lift], -1)
    right = np.cross(down, ahead)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    goal = np.stack([np.cross(right, down), right, down], -1)
    turn = np.einsum("nji,njk->nik", goal, scene.rotation)
    error = 0.5 * np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], -1
    )
    asked = np.stack([number(demand.actuators[k]) for k in range(6)], -1)
    moments = np.array(FRAME[1]) * (-f * f * error - 2 * 0.8 * f * scene.nu[:, 3:])
    assert asked[:, 3:] == pytest.approx(moments, rel=1e-6, abs=1e-9)
    assert asked[:, 2] == pytest.approx(
        2.5 * np.einsum("ni,ni->n", thrust, scene.rotation[:, :, 2]), rel=1e-6, abs=1e-9
    )
    assert np.stack([number(k) for k in kept], -1) == pytest.approx(now, rel=1e-12)


def test_a_turn_of_the_body_leaves_the_velocity_in_the_world() -> None:
    """R' (v + h a)(1 - h fade) with R' turned by the new rates over the step, and rates with a fade of their own."""
    scene, h = Scene(24), 0.05
    push, turn = (np.stack(drawn(s, 3.0, 3.0, 3.0), -1) for s in (25, 26))
    change = from_world(scene.flow, [lanes(p) for p in push.T], [lanes(t) for t in turn.T], lanes(h), 0.7, 1.9)
    found = scene.nu + h * np.stack([number(c) for c in change], -1)
    world = Rotation.from_matrix(scene.rotation)
    rates = world.inv().apply((world.apply(scene.nu[:, 3:]) + h * turn) * (1 - h * 1.9))
    assert found[:, 3:] == pytest.approx(rates, abs=1e-12)
    after = world * Rotation.from_rotvec(h * rates)
    velocity = (world.apply(scene.nu[:, :3]) + h * push) * (1 - h * 0.7)
    assert after.apply(found[:, :3]) == pytest.approx(velocity, abs=1e-12)


def test_what_drifts_along_counts_as_carried() -> None:
    """The share of the velocity that is the water's, by its projection, no less than none and no more than all."""
    scene = Scene(27, fast=1.0)
    scene.nu[:5, :3] = scene.water[:5]
    scene.nu[5:9, :3] = scene.water[5:9] = 0.0
    start = np.stack([number(v) for v in Carried(None).start(scene.flow)], -1)  # type: ignore[arg-type]
    size = np.maximum((scene.water**2).sum(axis=1), 1e-12)
    share = np.clip((scene.nu[:, :3] * scene.water).sum(axis=1) / size, 0, 1)
    drift = share[:, None] * scene.water
    assert start[:, 3:] == pytest.approx(drift, abs=1e-12)
    assert start[:, :3] == pytest.approx(np.einsum("nij,nj->ni", scene.rotation, drift), abs=1e-12)
    for part in (share == 0, share == 1, (share > 0) & (share < 1)):
        assert part.mean() > 0.02


def test_an_integral_goes_on_where_it_asks_for_less() -> None:
    share, asked, step = lanes(np.where(np.arange(LANES) % 2, 1.0, 0.7)), *(lanes(v) for v in drawn(28, 1.0, 1.0))
    free = (number(share) >= 1) | (np.sign(number(asked)) != np.sign(number(step)))
    assert number(unsaturated(share, asked, step)) == pytest.approx(np.where(free, number(step), 0.0))
    assert 0.1 < free.mean() < 0.9
    angles = np.array([np.pi, -np.pi, 3.0, -3.5, 9.5, 100.0])
    assert np.array(smallest_angle(jit.Float64(angles))) == pytest.approx(
        (angles + np.pi) % (2 * np.pi) - np.pi, abs=1e-12
    )


def test_axes_are_cut_down_in_their_order_astern_as_ahead() -> None:
    """Two thrusters, one weaker astern: each group of axes gets the share that the groups before it leave."""
    inverse = [[0.5, 0, 0, 0, 0, 1.0], [0.5, 0, 0, 0, 0, -1.0]]
    limits = [(-30.0, 50.0), (-10.0, 50.0)]
    surge, yaw = drawn(29, 90.0, 40.0)
    wrench = [lanes(surge), 0.0, 0.0, 0.0, 0.0, lanes(yaw)]
    thrusts, shares = Allocation({}, inverse, limits).prioritised(wrench, ((5,), (0,)))

    def most(now: np.ndarray, more: np.ndarray) -> np.ndarray:
        """Largest share of `more` (2, n) that leaves all within limits, by bisection over a fine net."""
        net = np.linspace(0, 1, 20_001)[:, None]
        fits = np.ones((len(net), LANES), bool)
        for k, (low, high) in enumerate(limits):
            total = now[k] + net * more[k]
            fits &= (total >= low - 1e-9) & (total <= high + 1e-9)
        return fits.sum(axis=0) / 20_000 - 1 / 20_000

    turning, ahead = np.stack([yaw, -yaw]), np.stack([0.5 * surge, 0.5 * surge])
    first = np.clip(most(0 * turning, turning), 0, 1)
    second = np.clip(most(first * turning, ahead), 0, 1)
    assert number(shares[5]) == pytest.approx(first, abs=2e-4)
    assert number(shares[0]) == pytest.approx(second, abs=3e-3)
    assert np.stack([number(t) for t in thrusts]) == pytest.approx(first * turning + second * ahead, abs=0.15)
    assert [number(s)[0] for s in shares[1:5]] == [1.0] * 4
    for share in (first, second):
        assert 0.05 < (share < 1).mean() < 0.95


def test_a_pose_is_approached_no_faster_than_its_reach() -> None:
    """Velocity w/(2 ratio) times the error, that within 1.5 m, beside the pose's own; PI by pole placement.

    Turns by 2 sin(angle/2) about their axis, as SciPy has it.
    """
    config = PoseConfig(
        type="pose", frequency_rad_s=0.6, turn_frequency_rad_s=1.7, ratio=0.8, integral=0.2, reach_m=1.5
    )
    mass = [20.0, 30.0, 40.0, 1.0, 2.0, 3.0]
    law, scene = PoseControl(config, mass, ECHO, None), Scene(30)  # type: ignore[arg-type]
    scene.place[::2] *= 0.03
    goal, moving = np.stack(drawn(31, 0.8, 0.8, 0.8, 0.6, 0.5, 3.1), -1), np.stack(drawn(32, 0.5, 0.4, 0.3), -1)
    integral = np.stack(drawn(33, *[0.5] * 6), -1)
    given = [lanes(g) for g in goal.T]
    flip = np.array([1.0, -1.0, -1.0])
    apart = np.einsum("nji,nj->ni", scene.rotation, scene.place - goal[:, :3] * flip)
    size = np.linalg.norm(apart, axis=1)
    assert 0.2 < (size > 1.5).mean() < 0.8
    near = apart * np.minimum(1.0, 1.5 / size)[:, None]
    wanted = -0.6 / 1.6 * near + np.einsum("nji,nj->ni", scene.rotation, moving)
    found = law._approach(scene.flow, given, [lanes(m) for m in moving.T])
    assert np.stack([number(v) for v in found], -1) == pytest.approx(wanted, abs=1e-9)
    turn = Rotation.from_euler("ZYX", goal[:, 5:2:-1] * [-1, -1, 1]).inv() * Rotation.from_matrix(scene.rotation)
    rotvec = turn.as_rotvec()
    angle = np.maximum(np.linalg.norm(rotvec, axis=1, keepdims=True), 1e-12)
    turned = 2 * np.sin(angle / 2) * rotvec / angle
    error = np.stack([number(v) for v in attitude_error(scene.flow, given)], -1)
    kept = (angle < 3.1).ravel()  # half a turn has no axis
    assert error[kept] == pytest.approx(turned[kept], abs=1e-6)
    wrench, steps = law._pull([lanes(i) for i in integral.T], scene.flow, found, [lanes(e) for e in turned.T], lanes(H))
    rates = np.concatenate([wanted, -1.7 / 1.6 * turned], axis=1) - scene.nu
    w = np.array([0.6] * 3 + [1.7] * 3)
    assert np.stack([number(v) for v in wrench], -1) == pytest.approx(
        np.array(mass) * 1.6 * w * (rates + integral), rel=1e-6
    )
    assert np.stack([number(v) for v in steps], -1) == pytest.approx(H * w * 0.2 * rates, rel=1e-6)
