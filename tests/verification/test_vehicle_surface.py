"""Vehicles at the surface and above it: falls, water entry and exit, thrust near the surface, capsizing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro import immersion, lift, restoring
from pelagos.vehicles.shape.pontoon import PontoonConfig, displaced, pontoon_mesh


def load(vehicle: Any, height: float = 0.0, control: str = "actuators", **given: Any) -> pl.Simulation:
    """One vehicle with its origin `height` [m] above the water."""
    ocean = {"waves": [given.pop("wave")]} if "wave" in given else {}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 100.0},
            "ocean": ocean,
            "agents": {"it": {"vehicle": vehicle, "control": control,
                              "start": {"position_m": [0, 0], "depth_m": max(0.0, -height), **given}}},
        }
    )  # fmt: skip
    if height > 0:
        sim.set_state("it", position=(0.0, 0.0, height))
    return sim


def ball(mass_ratio: float) -> dict[str, Any]:
    """A smooth ball of 0.2 m, weightless, that knows where the surface is."""
    radius, rho = 0.2, 1000.0
    volume = 4 / 3 * math.pi * radius**3
    mass, half = mass_ratio * rho * volume, 0.5 * rho * volume
    return {
        "type": "custom", "gravity_m_s2": 0.0, "density_kg_m3": rho, "length_m": 2 * radius, "diameter_m": 2 * radius,
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [0.4 * mass * radius**2] * 3,
                 "volume_m3": volume},
        "added_mass": {"type": "diagonal", "diagonal": [half, half, half, 0, 0, 0]},
        "terms": {"restoring": {"type": "submerged"}},
        "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
    }  # fmt: skip


@pytest.mark.parametrize("ratio", [0.4, 1.7])
def test_entering_water_takes_the_momentum_of_the_added_mass_and_leaving_gives_none_back(ratio: float) -> None:
    """(m + m_a) v stays (von Karman 1929), in every component.

    Each step keeps it to rounding; shares that steps of an eighth of the ball add up to are whole to 2 %.
    """
    sim = load(ball(ratio), 0.4, "wrench")
    start = np.array([3.0, -1.0, -5.0])
    sim.set_state("it", velocity=start)
    sim.run(0.4)
    after = sim.state["it"].velocity[0]
    assert sim.state["it"].position[0, 2] < -0.2
    assert after == pytest.approx(start * ratio / (ratio + 0.5), rel=0.02)
    sim.set_state("it", velocity=(1.0, 2.0, 4.0))
    sim.run(0.6)
    assert sim.state["it"].position[0, 2] > 0.2
    assert sim.state["it"].velocity[0] == pytest.approx([1.0, 2.0, 4.0], rel=0.02)


def test_a_ball_slows_as_von_karman_says_all_the_way_in() -> None:
    """w = w_0/(1 + s m_a/m) at every depth (NACA TN 321), s = z^2 (3 - 2 z) the wet share of its volume at z diameters.

    Steps of 1/80 diameter foresee the share by its slope at their beginning. What they miss adds up to half a step
    times the slope, at most 1.5/160, and times m_a/m = 0.625 to 6e-3.
    """
    sim = load(ball(0.8), 0.25, "wrench")
    start = np.array([0.3, -0.1, -0.5])
    sim.set_state("it", velocity=start)
    partly = 0
    for _ in range(120):
        sim.step()
        state = sim.state["it"]
        z = min(max((0.2 - state.position[0, 2]) / 0.4, 0.0), 1.0)
        share = z * z * (3 - 2 * z)
        partly += 0.05 < share < 0.95
        assert state.velocity[0] * (1 + share * 0.5 / 0.8) == pytest.approx(start, rel=6e-3)
    assert partly > 60
    assert share == 1.0


@pytest.mark.parametrize("name", ["otter", "wamv", "surface_vessel", "remus100", "bluerov2", "glider", "lrauv"])
def test_in_the_air_everything_falls_and_the_water_stops_it(name: str) -> None:
    """v = g t in the air whatever the thrusters do; at rest after it where it floats or was neutral, from 10 m."""
    sim = load(name, 10.0)
    g = pl.Vehicle.from_catalogue(name).config.gravity_m_s2
    assert sim.state["it"].position[0, 2] == 10.0
    limits = [a.lag.high for a in pl.Vehicle.from_catalogue(name).model.actuators.values()]
    sim.step({"it": np.array(limits, dtype=float)}, ticks=50)
    assert sim.state["it"].velocity[0] == pytest.approx([0, 0, -0.5 * g], abs=0.01)
    sim.step({"it": np.zeros(len(limits))}, ticks=1)
    lowest = 0.0
    for _ in range(150):
        sim.run(0.2)
        lowest = min(lowest, sim.state["it"].position[0, 2])
    assert lowest > -9.0
    assert np.abs(sim.state["it"].velocity[0]).max() < 0.4  # of 14 m/s: a glider glides on


@pytest.mark.parametrize("seakeeping", ["pressure", "slope"])
def test_a_dropped_boat_comes_back_to_its_draught(seakeeping: str) -> None:
    rest, drop = load({"type": "otter", "seakeeping": seakeeping}), load({"type": "otter", "seakeeping": seakeeping}, 6)
    for sim in (rest, drop):
        sim.run(30.0)
    here, there = rest.state["it"], drop.state["it"]
    assert there.position[0, 2] == pytest.approx(here.position[0, 2], abs=1e-3)
    assert there.euler[0, :2] == pytest.approx(here.euler[0, :2], abs=1e-3)


@pytest.mark.parametrize(
    ("name", "seconds"),
    [
        ("surface_vessel", 8.0),
        *(pytest.param(*x, marks=pytest.mark.slow) for x in (("otter", 12.0), ("wamv", 8.0), ("mariner", 60))),
    ],
)
def test_a_wave_of_a_tenth_of_a_millimetre_changes_nothing(name: str, seconds: float) -> None:
    """Linear hydrostatics and pressure on the mesh: trim within 0.1 degree, the period of roll within 2 %."""
    found = []
    for wave in ({}, {"wave": {"type": "regular", "height_m": 1e-4, "period_s": 6.0}}):
        sim = load(name, **wave)
        sim.run(60.0)
        trim = math.degrees(sim.state["it"].euler[0, 1])
        place = tuple(sim.state["it"].position[0])
        sim.set_state("it", attitude=(math.cos(0.008), math.sin(0.008), 0.0, 0.0), position=place)
        step = seconds / 400
        roll = []
        for _ in range(400):
            sim.run(max(0.01, round(step, 2)))
            roll.append(sim.state["it"].euler[0, 0])
        found.append((trim, _first_swing(np.array(roll))))
    (trim, swing), (trim_waves, swing_waves) = found
    assert trim_waves == pytest.approx(trim, abs=0.1)
    assert swing_waves == pytest.approx(swing, rel=0.02)


def _first_swing(roll: np.ndarray) -> float:
    """Samples from the first to the second passage through zero, linear between samples."""
    at = np.flatnonzero(np.diff(np.sign(roll)) != 0)[:2]
    places = at + roll[at] / (roll[at] - roll[at + 1])
    return float(places[1] - places[0])


@pytest.mark.parametrize(("angle", "upright"), [(45.0, True), (75.0, False), (-120.0, False)])
def test_a_catamaran_rights_itself_until_its_weight_passes_over_the_lower_pontoon(angle: float, upright: bool) -> None:
    """Otter: pontoons 0.395 m from the middle, weight 0.247 m above the water: atan(0.395 / 0.247) = 58 degrees."""
    sim = load("otter", roll_deg=angle)
    sim.run(40.0)
    roll = abs(math.degrees(sim.state["it"].euler[0, 0]))
    assert roll == pytest.approx(0.0 if upright else 180.0, abs=3.0)


@pytest.mark.parametrize(("waterplane", "section"), [(0.75, 0.5333), (0.9, 0.62), (1.0, 0.8), (0.7, 1.0)])
def test_a_pontoon_holds_its_block_coefficient(waterplane: float, section: float) -> None:
    """Volume Cw Cm L B T to the waterline, and its moments, of breadths B (1 - u^p)(1 - v^q) with means Cw and Cm.

    The centre lies a share (q + 1)/(2 (q + 2)) of the draught deep, and the mean square of u over the hull is
    (p + 1)/(3 (p + 3)), where p = Cw/(1 - Cw). Strips: errors fall with the square of their number, 1e-3 at 200 by 60.
    """
    draught = 0.4
    hull = PontoonConfig(
        length_m=3.1, beam_m=0.7, freeboard_m=0.2, position_x_m=0.3, position_y_m=0.9, mirror=True,
        waterplane_coefficient=waterplane, section_coefficient=section,
    )  # fmt: skip
    whole = 2 * 3.1 * 0.7 * draught * waterplane * section
    assert hull.volume_per_draught * draught == pytest.approx(whole, rel=1e-12)
    vertices, faces = pontoon_mesh(hull, draught, along=200, down=60)
    topsides = 2 * 3.1 * 0.7 * 0.2 * waterplane
    assert displaced(vertices, faces) == pytest.approx(whole + topsides, rel=1e-3)
    corners = vertices[faces]
    corners[..., 2] = np.maximum(corners[..., 2], 0.0)  # without what is above the water
    signed = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    middle = corners.sum(axis=1) / 4
    assert signed.sum() == pytest.approx(whole, rel=1e-3)
    means = [(signed * middle[:, k]).sum() / signed.sum() for k in range(3)]
    square = np.einsum("f,fij->", signed, (corners[..., 0] - 0.3)[:, :, None] * (corners[..., 0] - 0.3)[:, None, :])
    own = np.einsum("f,fi->", signed, (corners[..., 0] - 0.3) ** 2)
    inertia = (square + own) / 20 / signed.sum()
    q = math.inf if section == 1 else section / (1 - section)
    p = math.inf if waterplane == 1 else waterplane / (1 - waterplane)
    deep = 0.5 if section == 1 else (q + 1) / (2 * (q + 2))
    long = 1 / 3 if waterplane == 1 else (p + 1) / (3 * (p + 3))
    assert means == pytest.approx([0.3, 0.0, deep * draught], rel=2e-3, abs=1e-9)
    assert inertia == pytest.approx(long * (3.1 / 2) ** 2, rel=2e-3)


def test_propellers_lose_thrust_as_minsaas_measured() -> None:
    """1 - 0.675 (1 - 0.769 h/R)^1.258 (Minsaas, Faltinsen and Persson 1983) to 1.3 radii; nothing in the air."""
    depth = np.array([-3.0, -0.6, 0.0, 0.5, 1.0, 1.29, 1.31, 9.0])
    found = np.array(immersion.propeller_share(jit.Float64(0.3 * depth), 0.3))
    whole = 1 - 0.675 * (1 - 0.769 * depth[2:6]) ** 1.258
    assert found[2:6] == pytest.approx(whole, abs=1e-9)
    assert found[2] == pytest.approx(0.325)
    assert list(found[:2]) == [0.0, 0.0]
    assert list(found[6:]) == [1.0, 1.0]


def test_righting_moments_without_geometry_are_linear_first_and_gone_when_capsized() -> None:
    a = np.radians(np.linspace(-180, 180, 7201))
    g = np.array(restoring.righting_angle(jit.Float64(a)))
    small = np.abs(a) < math.radians(14.9)
    assert (g[small] == a[small]).all()
    assert np.abs(np.diff(g)).max() < 1.5 * (a[1] - a[0])
    assert np.abs(g).max() == pytest.approx(math.radians(35), rel=1e-6)
    assert g[-1] == pytest.approx(0, abs=1e-9)
    assert (g[(a > math.radians(97)) & (a < 3.14)] < 0).all()  # towards 180


@pytest.mark.parametrize("name", ["quadrotor", "fixed_wing"])
def test_what_flies_ditches(name: str) -> None:
    """From 10 m with everything off: into the water and slowly on; under water no rotor lifts it out."""
    sim = load(name, 10.0)
    sim.run(6.0)
    assert np.abs(sim.state["it"].velocity[0]).max() < 0.7
    assert sim.state["it"].position[0, 2] < 0.05
    count = len(pl.Vehicle.from_catalogue(name).model.actuators)
    if name == "quadrotor":
        sim.set_state("it", position=(0.0, 0.0, -3.0), velocity=(0, 0, 0))
        sim.step({"it": np.full(count, 900.0)}, ticks=300)
        assert sim.state["it"].position[0, 2] < -3.0


@pytest.mark.parametrize("name", ["bluerov2_heavy", "otter"])
def test_the_seabed_stops_what_commanded_accelerations_drive_into_it(name: str) -> None:
    """A hull that is told to accelerate downwards at 0.3 m/s2 lies on the ground at 4 m, and does not sink into it."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 4.0},
            "agents": {"it": {"vehicle": name, "control": "acceleration", "start": {"position_m": [0, 0]}}},
        }
    )
    sim.step({"it": np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0])}, ticks=900)
    z = sim.state["it"].position[0, 2]
    assert -4.0 < z < -3.2
    assert sim.state["it"].velocity[0] == pytest.approx([0, 0, 0], abs=0.05)


def test_what_drifts_above_the_water_does_not_feel_its_drag() -> None:
    """`acceleration` counts forces as far as they are wet: in the air no water carries the hull along."""
    stream = {"type": "uniform", "speed_mps": 0.8, "towards_deg": 40}
    found = {}
    for height in (-6.0, 3.0):
        sim = pl.Simulation.load(
            {
                "tick_rate_hz": 50,
                "world": {"type": "flat", "depth_m": 50.0},
                "ocean": {"currents": [stream]},
                "agents": {"it": {"vehicle": "remus100", "control": "acceleration", "start": {"position_m": [0, 0]}}},
            }
        )
        sim.set_state("it", position=(0.0, 0.0, height))
        sim.run(10.0)
        found[height] = np.linalg.norm(sim.state["it"].velocity[0])
    assert found[-6.0] > 0.3
    assert found[3.0] < 0.02


@pytest.mark.parametrize("u", [1.3, -1.3])
def test_a_fin_opposes_the_flow_across_it_from_ahead_and_from_astern(u: float) -> None:
    """The power of its lift by incidence is never positive: force along w has the sign of -w."""
    for w in (0.2, -0.3):
        load = lift.fin(50.0, 0.0, (1.0, 0.0), [-1.0, 0.0, 0.0], 0.0, [u, 0.0, w, 0.0, 0.0, 0.0], incidence=True)
        assert float(load[2]) == pytest.approx(-50.0 * abs(u) * w)


@pytest.mark.parametrize(("u", "deflection"), [(1.3, 0.2), (1.3, -0.15), (-1.1, 0.2), (-1.1, -0.15)])
def test_a_deflected_fin_pushes_the_other_way_astern_and_always_drags(u: float, deflection: float) -> None:
    """A plate turned by d in a flow along x: force across it rho/2 A CL u |u| d, drag against the way."""
    load = lift.fin(50.0, 9.0, (0.0, 1.0), [-1.0, 0.0, 0.0], deflection, [u, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert float(load[1]) == pytest.approx(50.0 * u * abs(u) * deflection)
    assert float(load[5]) == pytest.approx(-50.0 * u * abs(u) * deflection)
    assert float(load[0]) == pytest.approx(-9.0 * u * abs(u) * deflection**2)
    same = lift.fin(50.0, 9.0, (0.0, 1.0), [-1.0, 0.0, 0.0], deflection, [u, 0, 0, 0, 0, 0], mirrored=False)
    assert float(same[1]) == pytest.approx(50.0 * u * u * deflection)  # as Fossen's programs have it


def test_a_torpedo_that_goes_astern_turns_with_its_rudder_the_other_way() -> None:
    """The moment about z of the same helm, ahead and astern; published, it keeps its sign."""
    turned = {}
    for astern in ("mirrored", "as_ahead"):
        it = {"type": "remus100", "actuators": {"rudder": {"astern": astern}}}
        for u in (1.0, -1.0):
            sim = pl.Simulation.load(
                {
                    "tick_rate_hz": 50,
                    "world": {"type": "flat", "depth_m": 50.0},
                    "agents": {"it": {"vehicle": it, "control": "actuators", "start": {"depth_m": 20}}},
                }
            )
            sim.set_state("it", velocity=(u, 0.0, 0.0))
            sim.step({"it": np.array([0.2, 0.0, 0.0])}, ticks=25)
            turned[astern, u] = float(sim.state["it"].angular_velocity[0, 2])
    assert turned["mirrored", 1.0] == pytest.approx(turned["as_ahead", 1.0], rel=1e-12)
    assert turned["mirrored", 1.0] * turned["mirrored", -1.0] < 0
    assert turned["as_ahead", 1.0] * turned["as_ahead", -1.0] > 0


@pytest.mark.parametrize(("name", "share"), [("otter", 1.0), ("mariner", None)])
def test_what_floats_starts_on_the_surface_and_moves_with_it(name: str, share: float | None) -> None:
    """z = a cos(k x + phase) under its middle, and the water's velocity a w; a ship of many wavelengths lies level."""
    wave = {"type": "regular", "height_m": 1.6, "period_s": 5.0, "towards_deg": 0, "phase_deg": 50}
    found = pl.Simulation.load(
        {
            "world": {"type": "flat", "depth_m": 500.0},
            "ocean": {"waves": [wave], "tide": {"period_h": 12.0, "amplitude_m": 0.7}},
            "agents": {"it": {"vehicle": name, "start": {"position_m": [7.0, -3.0], "heading_deg": 25}}},
        }
    ).state["it"]
    omega = 2 * math.pi / 5.0
    phase = omega**2 / 9.80665 * 7.0 + math.radians(50)
    z = found.position[0, 2] - 0.7
    if share is None:
        assert abs(z) < 0.15 * 0.8
        return
    assert z == pytest.approx(0.8 * math.cos(phase), abs=0.03)
    assert np.linalg.norm(found.velocity[0]) == pytest.approx(0.8 * omega, rel=0.15)


def test_an_otter_rides_sea_state_7() -> None:
    """It starts on the wave, not under it: for 30 s it leans less than 30 degrees (it was turned over at the start)."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 200.0},
            "ocean": {"waves": [{"type": "sea_state", "state": 7}]},
            "agents": {"it": {"vehicle": "otter"}},
        }
    )
    for _ in range(60):
        sim.run(0.5)
        _, x, y, _ = sim.state["it"].attitude[0]
        assert 1 - 2 * (x * x + y * y) > math.cos(math.radians(30))


def test_a_quadrotor_hovers_at_20_ticks_a_second() -> None:
    """The attitude loop keeps to what its step resolves: it comes to a place 6 m off and rests (it swung)."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 50.0},
            "agents": {"it": {"vehicle": "quadrotor", "start": {"position_m": [0, 0, 10]}}},
        }
    )
    sim.step({"it": np.array([5.0, 3.0, 12.0, 1.0])})
    sim.run(30.0)
    assert sim.state["it"].position[0] == pytest.approx([5, 3, 12], abs=0.1)
    assert sim.state["it"].angular_velocity[0] == pytest.approx([0, 0, 0], abs=0.02)


@pytest.mark.parametrize("angle_deg", [45.0, -135.0, 30.0])
@pytest.mark.parametrize("incidence", [False, True])
def test_a_fin_that_is_turned_about_x_feels_the_turned_flow(angle_deg, incidence):
    """A vehicle has no up to its fins: fin and flow turned by the same angle give the force turned by it."""
    g = math.radians(angle_deg)
    turn = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(g), -math.sin(g)], [0.0, math.sin(g), math.cos(g)]])
    place, flow, spin = np.array([-0.7, 0.2, 0.05]), np.array([1.4, 0.5, -0.3]), np.array([0.3, -0.4, 0.6])

    def force(direction, place, flow, spin):
        return lift.fin(
            50.0, 9.0, direction, place.tolist(), 0.2, [*flow.tolist(), *spin.tolist()], incidence=incidence
        )

    there = np.array(force((1.0, 0.0), place, flow, spin)).reshape(2, 3)
    turned = np.array(force((math.cos(g), math.sin(g)), turn @ place, turn @ flow, turn @ spin)).reshape(2, 3)
    assert turned == pytest.approx(there @ turn.T, rel=1e-12)
    if not incidence:
        assert there[0, 2] == pytest.approx(-50.0 * (1.4**2 + 0.3**2) * 0.2)  # and w, across its axis, but not v


@pytest.mark.parametrize(("depth_m", "wet"), [(0.1, 0.625), (-0.25, 0.1875), (0.3, 0.875), (0.9, 1.0)])
def test_a_box_of_the_engine_floats_by_its_wet_share(depth_m: float, wet: float) -> None:
    """HoloOcean's: a box 0.8 m high whose middle lies d deep is wet to 1/2 + d/0.8; dw/dt = g - rho V g wet/m."""
    native = {
        "type": "engine_forces", "command": "thrusters", "mass_kg": 16.0, "volume_m3": 0.019, "density_kg_m3": 997.0,
        "inertia_kg_m2": [0.3, 1.2, 1.4], "drag_area_m2": 0.06, "damping_1_s": 0.0, "turn_damping_1_s": 0.0,
        "half_height_m": 0.4, "center_of_buoyancy_m": [0.0, 0.0, 0.0], "current": False,
        "thrusters": [{"position_m": [-0.4, 0.2, 0.1], "direction": [1.0, 0.0, 0.0], "limit_n": 9.0}],
    }  # fmt: skip
    vehicle = {"type": "bluerov2", "modes": {"native": native}}
    sim = pl.Simulation.load({
        "tick_rate_hz": 1000, "world": {"type": "flat", "depth_m": 40},
        "agents": {"it": {"vehicle": vehicle, "control": "native", "start": {"position_m": [0, 0, -depth_m]}}},
    })  # fmt: skip
    sim.step({"it": [0.0]})
    down = -sim.state["it"].velocity[0, 2] / 1e-3
    assert down == pytest.approx(9.8 - 997.0 * 0.019 * 9.8 * wet / 16.0, abs=0.02)
