"""Box-shaped frames in a flow from any side: closed forms, and ROVs that stay upright at speed."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro import frame
from pelagos.hydro.coriolis import coriolis_force

QUADRATIC = [141.0, 217.0, 190.0]
TURNING = [1.19, 0.47, 1.5]
SIZE = (0.457, 0.575, 0.254)
ADDED = np.diag([6.36, 7.12, 18.68, 0.189, 0.135, 0.222])


def numbers(load: list) -> np.ndarray:
    return np.array([float(jit.Float64(c)[0]) for c in load])


def drag(*nu: float) -> np.ndarray:
    places, rest = frame.frame_places(QUADRATIC, TURNING, SIZE)
    return numbers(frame.frame_drag(QUADRATIC, rest, places, [0.0] * 3, [jit.Float64(v) for v in nu]))


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("speed", [0.7, -1.3])
def test_a_flow_along_one_axis_and_turning_alone_meet_the_published_drag(axis: int, speed: float) -> None:
    nu = np.zeros(6)
    nu[axis] = speed
    expected = np.zeros(6)
    expected[axis] = -[*QUADRATIC, *TURNING][axis] * speed * abs(speed)
    assert drag(*nu) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("r", [0.3, -0.8])
def test_a_frame_that_drags_along_one_axis_alone_turns_freely_about_it(r: float) -> None:
    """No drag along x and z, and none on turning: all of it attacks in the middle, and turning meets nothing."""
    places, rest = frame.frame_places([0.0, 217.0, 0.0], [0.0] * 3, SIZE)
    assert rest == [0.0] * 3
    assert np.abs(places).max() == 0
    load = frame.frame_drag([0.0, 217.0, 0.0], rest, places, [0.0] * 3, [jit.Float64(v) for v in (0, -0.7, 0, 0, 0, r)])
    assert numbers(load) == pytest.approx([0, 217.0 * 0.49, 0, 0, 0, 0], abs=1e-12)


def test_a_slight_flow_across_a_fast_one_is_resisted_by_the_product_of_both() -> None:
    """F = -k |V| V with V = (u, v, w): |V| = sqrt(1.2^2 + 0.05^2 + 0.03^2)."""
    u, v, w = 1.2, -0.05, 0.03
    speed = math.sqrt(u * u + v * v + w * w)
    expected = [-k * speed * c for k, c in zip(QUADRATIC, (u, v, w), strict=True)]
    assert drag(u, v, w, 0, 0, 0)[:3] == pytest.approx(expected, rel=1e-12)


def test_drag_takes_energy_from_any_motion() -> None:
    rng = np.random.default_rng(4)
    pairs = frame.blunt_pairs(ADDED, SIZE)
    for nu in rng.normal(size=(50, 6)):
        assert drag(*nu) @ nu < 0
        assert numbers(frame.blunt_lift(pairs, [jit.Float64(c) for c in nu])) @ nu <= 1e-12


@pytest.mark.parametrize("u", [1.1, -0.9])
def test_a_box_has_the_lift_of_its_base_and_half_of_munks_moment(u: float) -> None:
    """Allen and Perkins 1951, eq. 8 and 10, at small angles with S_b = V / L and the moment's centre in the middle:
    normal force (k2 - k1) S_b q 2 a = (A22 - A11) / L |u| v, moment (V - S_b L / 2) (k2 - k1) q 2 a = half of Munk's.
    """
    v, w = 0.06, -0.04
    nu = [jit.Float64(c) for c in (u, v, w, 0, 0, 0)]
    lift = numbers(frame.blunt_lift(frame.blunt_pairs(ADDED, SIZE), nu))
    munk = -numbers(coriolis_force(ADDED.tolist(), nu))
    a = np.diag(ADDED)
    length, beam = SIZE[0], SIZE[1]
    assert lift[1] == pytest.approx(-(a[1] - a[0]) / length * abs(u) * v, rel=1e-12)
    across = (a[2] - a[0]) / length * abs(u) + (a[2] - a[1]) / beam * abs(v)
    assert lift[2] == pytest.approx(-across * w, rel=1e-12)
    assert lift[3:] == pytest.approx(-0.5 * munk[3:], rel=1e-12)


@pytest.mark.parametrize(("name", "forces"), [("bluerov2", (20, 60)), ("bluerov2_heavy", (20, 90))])
def test_a_pushed_rov_stays_upright_and_on_its_course(name: str, forces: tuple[float, ...]) -> None:
    """Free in every angle, pushed ahead; its drag then gives the speed. As published both turn over from 0.5 m/s on."""
    for force in forces:
        sim = pl.Simulation.load(
            {
                "tick_rate_hz": 50,
                "world": {"type": "flat", "depth_m": 100.0},
                "agents": {"it": {"vehicle": name, "control": "wrench",
                                  "start": {"position_m": [0, 0], "depth_m": 30, "pitch_deg": 5, "roll_deg": -4}}},
            }
        )  # fmt: skip
        tilt = []
        for k in range(200):
            sim.step({"it": np.array([force, 0, 0, 0, 0, 0.02])}, ticks=5)
            roll, pitch, _ = sim.state["it"].euler[0]
            tilt.append((abs(roll) + abs(pitch)) if k > 50 else 0.0)
        body = pl.Vehicle.from_catalogue(name).config
        linear, square = body.terms["linear_damping"].diagonal[0], body.terms["quadratic_damping"].diagonal[0]
        speed = (-linear + math.sqrt(linear**2 + 4 * square * force)) / (2 * square)
        assert max(tilt) < math.radians(10)
        assert sim.state["it"].velocity[0, 0] == pytest.approx(speed, rel=0.03)
        assert abs(sim.state["it"].velocity[0, 1]) < 0.05 * speed


def test_bluerov2_goes_ahead_at_the_makers_speed_without_pitch_control() -> None:
    """1.5 m/s, as the maker's data sheet has it, level to 3 degrees: thrusters cancel their reactions ahead."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 100.0},
            "agents": {"it": {"vehicle": "bluerov2", "control": "velocity",
                              "start": {"position_m": [0, 0], "depth_m": 30, "pitch_deg": 2}}},
        }
    )  # fmt: skip
    sim.step({"it": np.array([1.5, 0, 0, 0])}, ticks=1500)
    roll, pitch, yaw = np.degrees(sim.state["it"].euler[0])
    assert sim.state["it"].velocity[0, 0] == pytest.approx(1.5, abs=0.02)
    assert max(abs(roll), abs(pitch), abs(yaw)) < 3.0


@pytest.mark.parametrize(
    ("speed", "current", "lean", "depth"), [(0.8, 0.0, 15, 0.8), (1.2, 0.0, 15, 1.2), (0.8, 0.5, 15, 1.6)]
)
def test_bluerov2_stays_upright_while_a_pilot_keeps_its_depth_by_heave(
    speed: float, current: float, lean: float, depth: float
) -> None:
    """Four headings in the `velocity` mode. Without the law for free pitch all four turned over: 150 deg and more.

    What it leans by is about what the law allows, 0.2 rad (11 deg), and what that takes from depth before a set-point
    of 0.3 1/s brings it back.
    """
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 200.0},
            "ocean": {"currents": [{"type": "uniform", "speed_mps": current, "towards_deg": 60}]},
            "agents": {"it": {"vehicle": "bluerov2", "control": "velocity",
                              "start": {"position_m": [0, 0], "depth_m": 30, "pitch_deg": 2}}},
        },
        n=4,
    )  # fmt: skip
    yaw = np.array([0.0, math.pi / 2, math.pi, -2.0])
    sim.set_state("it", attitude=np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1))
    tilt, off = [], []
    for _ in range(60):
        up = -30.0 - sim.state["it"].position[:, 2]
        sim.step({"it": np.stack([0 * yaw + speed, 0 * yaw, 0.3 * up, 0 * yaw], axis=-1)}, ticks=50)
        tilt.append(np.degrees(np.abs(sim.state["it"].euler[:, :2])).max())
        off.append(np.abs(up).max())
    assert max(tilt) < lean
    assert max(off) < depth


def test_bluerov2_holds_its_pose_against_a_fast_current_level() -> None:
    """0.8 m/s from ahead, abeam, astern and a bow, beyond the speed at which flow tilts it more than weight rights it.

    Where the flow along it is near that speed (fourth copy) depth is nearly beyond control: it only stays upright.
    Held in depth alone it leans by 68 degrees from ahead, and by 44 from the bow.
    """
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 60.0},
            "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.8, "towards_deg": 180}]},
            "agents": {"it": {"vehicle": "bluerov2", "control": "pose",
                              "start": {"position_m": [0, 0], "depth_m": 20, "pitch_deg": 3}}},
        },
        n=4,
    )  # fmt: skip
    yaw = np.array([0.0, math.pi / 2, math.pi, -math.pi / 4])
    sim.set_state("it", attitude=np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1))
    goal = np.stack([0 * yaw, 0 * yaw, 0 * yaw - 19.7, 0 * yaw, yaw], axis=-1)
    far, tilt = [], []
    for _ in range(40):
        sim.step({"it": goal}, ticks=50)
        far.append(np.linalg.norm(sim.state["it"].position - goal[:, :3], axis=1))
        tilt.append(np.degrees(np.abs(sim.state["it"].euler[:, :2]).max(axis=1)))
    assert np.max(tilt) < 25
    assert (np.max(far[-10:], axis=0) < [0.1, 0.1, 0.1, 1.0]).all()
    assert (np.max(tilt[-10:], axis=0)[:3] < 2).all()


@pytest.mark.parametrize(("vehicle", "speed"), [
    ("bluerov2_heavy", 0.55),
    ({"type": "bluerov2_heavy", "variant": "wu_2018"}, 0.8),
    ({"type": "bluerov2_heavy", "variant": "wu_2018"}, 1.4),
])  # fmt: skip
def test_bluerov2_heavy_holds_its_pose_against_a_current_from_any_side(vehicle: object, speed: float) -> None:
    """Eight headings, within 0.3 m from the start on.

    With the drag of von Benzon (217 N s^2/m^2 abeam, four thrusters at 45 deg) full thrust makes 0.83 m/s ahead, 0.71
    astern, 0.66 abeam and 0.57 on a quarter, where two of the four push: it can hold no more. With Wu's drag, a tenth
    of it, it holds nearly the 1.5 m/s that the maker gives.
    """
    yaw = np.arange(8) * math.pi / 4 + 0.1
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 60.0},
            "ocean": {"currents": [{"type": "uniform", "speed_mps": speed, "towards_deg": 180}]},
            "agents": {"it": {"vehicle": vehicle, "control": "pose",
                              "start": {"position_m": [0, 0], "depth_m": 20}}},
        },
        n=8,
    )  # fmt: skip
    sim.set_state("it", attitude=np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=-1))
    goal = np.stack([0 * yaw, 0 * yaw, 0 * yaw - 19.8, 0 * yaw, 0 * yaw, yaw], axis=-1)
    far, tilt = [], []
    for _ in range(25):
        sim.step({"it": goal}, ticks=50)
        far.append(np.linalg.norm(sim.state["it"].position - goal[:, :3], axis=1))
        tilt.append(np.degrees(np.abs(sim.state["it"].euler[:, :2]).max(axis=1)))
    assert np.max(far) < 0.3
    assert np.max(far[-10:]) < 0.05
    assert np.max(tilt[-10:]) < 2.0


def test_the_neutral_speed_of_the_bluerov2_is_that_of_its_righting_moment() -> None:
    """B BG = (A33 - A11)/2 V^2, half of Munk's moment; the same for both published sets within a tenth."""
    for variant in (None, "von_benzon_2022"):
        config = pl.Vehicle.from_catalogue("bluerov2", variant=variant).config
        body = config.body
        apart = float(body.center_of_gravity[2] - body.center_of_buoyancy[2])
        destabilising = 0.5 * float(body.added[2, 2] - body.added[0, 0])
        neutral = math.sqrt(float(body.buoyancy) * apart / destabilising)
        assert config.modes["pose"].neutral_speed_mps == pytest.approx(neutral, rel=0.1)


def test_a_neutral_speed_is_refused_where_thrusters_pitch() -> None:
    with pytest.raises(
        pl.errors.PelagosError, match="neutral_speed_mps is for axes with surge and heave, without pitch"
    ):
        pl.Vehicle.from_dict({"type": "bluerov2_heavy", "modes": {"velocity": {"neutral_speed_mps": 0.5}}})
    with pytest.raises(pl.errors.PelagosError, match="neutral_speed_mps is for axes with z and without pitch"):
        pl.Vehicle.from_dict({"type": "bluerov2_heavy", "modes": {"pose": {"neutral_speed_mps": 0.5}}})
