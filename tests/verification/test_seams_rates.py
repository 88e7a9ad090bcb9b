"""A rate is the derivative of what it is a rate of, an arm turns with what carries it, a normal stands upright."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.hull_waves import Waterplane, hull_waves
from pelagos.report.navigation import _dvl_on
from pelagos.sensors.navigation.collision import Collision
from pelagos.sim.channel import _place
from pelagos.vehicles.actuators.curve import CurveThrusterConfig
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.inertia import ExplicitMass, mass_and_inertia
from pelagos.vehicles.shape.parts import ShapePart
from pelagos.vehicles.terms.damping import LinearDampingConfig
from pelagos.vehicles.terms.ditching import DitchingConfig
from pelagos.vehicles.wetness import Wetness
from pelagos.world.bathymetry.nodes import SurveyNodes


def values(parts) -> np.ndarray:
    return np.array([np.array(p, dtype=np.float64).ravel() for p in parts])


@pytest.mark.parametrize(
    ("twin", "towards", "speed"), [(False, 75.0, None), (True, -110.0, None), (False, 10.0, 2.5), (True, -140.0, 1.5)]
)
def test_acceleration_of_the_water_at_a_hull_is_the_change_of_its_velocity(
    twin: bool, towards: float, speed: float | None
) -> None:
    """Central differences over 2 h of a wave of frequency w err by (w h)^2 / 6, here 3e-6 of w times the velocity; of a
    hull under way, which takes its sheet of water along, at the frequency of encounter.
    """
    waves = {"type": "regular", "height_m": 0.8, "period_s": 4.7, "towards_deg": towards, "phase_deg": 25.0}
    sea = build_ocean(OceanConfig.model_validate({"waves": waves})).waves
    plane, h = Waterplane(9.0, 1.7, 0.6, twin), 3e-3
    heading = jit.Float64(math.cos(0.6)), jit.Float64(math.sin(0.6))
    times = np.array([0.4, 1.3, 2.9])

    t = np.concatenate([times - h, times, times + h])
    way = (speed or 0.0) * (t - np.tile(times, 3))  # ahead of where the hull is at each time
    places = jit.Float64(4.0 + math.cos(0.6) * way), jit.Float64(-7.0 - math.sin(0.6) * way)
    ahead = None if speed is None else jit.Float64(np.full(9, speed))
    found = hull_waves(sea, *places, heading, jit.Float64(t), plane, speed=ahead)
    (before, velocity, after), (_, acceleration, _) = (
        np.split(values(parts), 3, axis=1) for parts in (found.velocity, found.acceleration)
    )
    assert (np.abs(velocity).max(axis=1) > 1e-3).all()  # all six move
    size = 1e-5 * np.abs(acceleration).max(axis=1, keepdims=True)
    assert (np.abs(acceleration - (after - before) / (2 * h)) < size).all()


@pytest.mark.parametrize(("a", "b"), [(0.3, -0.7), (-0.2, 0.5)])
def test_normals_of_a_surveys_own_nodes_stand_upwards_on_a_tilted_plane(a: float, b: float) -> None:
    """z = a x + b y has the normal (-a, -b, 1); curvature of the Earth's grid over 200 m: 1e-5."""
    origin = GeoOrigin(45.0, 13.0)
    u, v = 45.0 + 1e-4 * np.arange(-9, 10), 13.0 + 1e-4 * np.arange(-7, 8)
    flat = SurveyNodes(0.0, 0.0, 11.0, np.zeros((len(u), len(v))), origin, "EPSG:4326", u, v)
    places = flat.vertices().reshape(len(u), len(v), 3)
    tilted = SurveyNodes(0.0, 0.0, 11.0, a * places[..., 0] + b * places[..., 1], origin, "EPSG:4326", u, v)
    expected = np.array([-a, -b, 1.0]) / math.sqrt(a * a + b * b + 1)
    assert tilted.normals() == pytest.approx(np.broadcast_to(expected, (*flat.z.shape, 3)), abs=1e-5)


@pytest.mark.parametrize("lever", [(0.4, -0.3, 0.2), (-0.7, 0.1, -0.5)])
def test_a_dvl_off_the_origin_is_taken_back_to_it(lever: tuple[float, float, float]) -> None:
    """A body that turns in place moves its DVL by w x r, seen in the DVL's own turned axes."""
    mount = Rotation.from_euler("ZYX", [0.7, -0.2, 0.3])
    x, y, z, w = mount.as_quat()
    mission = SimpleNamespace(mount=lambda sensor: (np.array(lever), np.array([w, x, y, z])))
    rate, own = np.array([[0.3, -0.5, 0.8]]), np.array([0.4, -0.1, 0.2])
    measured = mount.inv().apply(own + np.cross(rate[0], lever))
    t = np.array([0.0, 1.0])
    found = _dvl_on(t[:1], t, np.tile(measured, (2, 1)), rate, mission)
    assert found[0] == pytest.approx(own, abs=1e-12)


@pytest.mark.parametrize("arm", [(0.4, -0.3, 0.2), (-0.7, 0.1, -0.5)])
def test_an_end_of_a_channel_moves_with_the_arm_that_carries_it(arm: tuple[float, float, float]) -> None:
    turned, spin, own = (
        Rotation.from_euler("ZYX", [1.7, -0.2, 0.3]),
        np.array([0.3, -0.5, 0.8]),
        np.array([0.4, -0.1, 0.2]),
    )
    x, y, z, w = turned.as_quat()
    state = SimpleNamespace(
        position=np.array([[5.0, -6.0, -7.0]]), attitude=np.array([[w, x, y, z]]), velocity=own[None],
        angular_velocity=spin[None],
    )  # fmt: skip
    sensor = SimpleNamespace(config=SimpleNamespace(position_m=arm))
    model = SimpleNamespace(agents={"a": SimpleNamespace(sensors={"it": sensor})})
    place, velocity = _place(SimpleNamespace(model=model, state={"a": state}), "a.it", 0)
    assert place == pytest.approx(turned.apply(arm) + np.array([5.0, -6.0, -7.0]))
    assert velocity == pytest.approx(turned.apply(own + np.cross(spin, arm)))


@pytest.mark.parametrize(
    ("force", "moment", "felt"),
    [((1.0, -2.0, 0.5), (90.0, -40.0, 7.0), False), ((-9.0, 2.0, 4.0), (0.1, 0.0, 0.0), True)],
)
def test_a_switch_feels_force_and_not_moment(force, moment, felt: bool) -> None:
    made = object.__new__(Collision)
    wrench = np.array([[*force, *moment]])
    made._least, made._agent, made._ticks = 5.0, "a", 1
    made._blows = SimpleNamespace(latest=lambda agent, ticks: wrench)
    found = made.sense(SimpleNamespace(copy=np.array([0])))
    assert found.data.tolist() == [[felt]]
    assert found.extras["force"][0] == pytest.approx(force)
    assert found.extras["moment"][0] == pytest.approx(moment)


def flow(nu, *, share: float = 0.0, step: float | None = None) -> Flow:
    speeds = [jit.Float64(float(v)) for v in nu]
    level = [[jit.Float64(float(i == j)) for j in range(3)] for i in range(3)]
    still = [jit.Float64(0.0)] * 3
    return Flow(
        still, still[2], level, speeds, speeds, [jit.Float64(0.0)] * 6,
        wet=Wetness(jit.Float64(share), jit.Float64(0.0)), step=None if step is None else jit.Float64(step),
    )  # fmt: skip


def test_a_coupled_damping_acts_on_its_row_by_the_speed_of_its_column() -> None:
    term = LinearDampingConfig(type="linear_damping", diagonal=(1, 2, 3, 4, 5, 6), off_diagonal={"26": 7.0, "53": -8.0})
    nu = np.array([0.3, -0.5, 0.7, 0.2, -0.4, 0.6])
    expected = -np.array([1, 2, 3, 4, 5, 6]) * nu
    expected[1] -= 7.0 * nu[5]
    expected[4] += 8.0 * nu[2]
    assert values(term.build(SimpleNamespace()).wrench(flow(nu)))[:, 0] == pytest.approx(expected)


@pytest.mark.parametrize("speed", [3.0, -4.0])
def test_drag_of_ditching_stops_and_never_throws_back(speed: float) -> None:
    """m v' = -d |v| v' over a step of h: v' = v / (1 + h d |v| / m), however long the step."""
    body = SimpleNamespace(length=1.6, beam=0.8, height=0.4, rigid=np.diag([20.0, 20, 20, 2, 3, 4]), gravity=9.8)
    term = DitchingConfig(type="ditching", volume_m3=0.0, area_m2=(0.3, 0.2, 0.5)).build(body)
    for h in (0.01, 5.0):
        force = values(term.wrench(flow([speed, 0, 0, 0, 0, 0], share=0.6, step=h)))[0, 0]
        drag = 0.6 * 0.5 * 1025.0 * 0.3
        assert speed + h * force / 20.0 == pytest.approx(speed / (1 + h * drag * abs(speed) / 20.0))


@pytest.mark.parametrize("rates", [(0.3, -0.5, 0.8), (-0.2, 0.6, -0.4)])
def test_a_thruster_off_the_axis_meets_the_water_of_its_own_place(rates: tuple[float, float, float]) -> None:
    """Thrust falls by a . (v + w x r) over the speed at which it is zero."""
    place, axis = (0.4, -0.3, 0.2), np.array([0.8, 0.6, 0.0])
    body = SimpleNamespace(length=1.0, beam=0.5, height=0.4, density=1000.0, in_air=False, stiffness=np.zeros(6))
    made = CurveThrusterConfig(
        type="curve_thruster", position_m=place, direction=tuple(axis), commands=(-1.0, 0.0, 1.0),
        thrusts_n=(-30.0, 0.0, 40.0), zero_thrust_m_s=3.0, time_constant_s=0.0,
    ).build(body)  # fmt: skip
    velocity = np.array([0.5, -0.2, 0.3])
    found = values(made.wrench(jit.Float64(0.7), flow([*velocity, *rates])))[:, 0]
    thrust = 28.0 * (1 - axis @ (velocity + np.cross(rates, place)) / 3.0)
    assert found == pytest.approx([*(thrust * axis), *np.cross(place, thrust * axis)])


def test_products_of_inertia_stand_where_their_names_say() -> None:
    mass = ExplicitMass(
        type="explicit", mass_kg=20.0, inertia_kg_m2=(1.0, 2.0, 3.0), products_of_inertia_kg_m2=(0.1, -0.2, 0.3)
    )
    _, inertia, volume = mass_and_inertia(mass, 1000.0, 1.0, 0.2)
    assert inertia == pytest.approx(np.array([[1.0, -0.1, 0.2], [-0.1, 2.0, -0.3], [0.2, -0.3, 3.0]]))
    assert volume == pytest.approx(0.02)


@pytest.mark.parametrize("turn", [(20.0, -35.0, 50.0), (-15.0, 25.0, -40.0)])
def test_the_second_of_a_pair_is_the_mirror_image_of_the_first(turn: tuple[float, float, float]) -> None:
    part = ShapePart(type="box", size_m=(0.9, 0.5, 0.2), position_m=(0.3, 0.7, -0.1), turn_deg=turn, mirror=True)
    left, right = (mesh.vertices for mesh in part.meshes())
    apart = np.linalg.norm(left[:, None] * [1.0, -1.0, 1.0] - right[None], axis=-1)
    assert apart.min(axis=1) == pytest.approx(0.0, abs=1e-6)
    corner = Rotation.from_euler("ZYX", np.radians(turn)[::-1]).apply([0.45, 0.25, 0.1]) + np.array([0.3, 0.7, -0.1])
    assert np.linalg.norm(left - corner, axis=1).min() == pytest.approx(0.0, abs=1e-6)
