"""What HoloOcean's own tests ask of its agents and scenarios, written anew from their descriptions."""

import copy
import itertools

import numpy as np
import pytest
from holoocean_env import agent, opened

import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean import packagemanager
from pelagos.compat.holoocean.fossen_dynamics import FossenInterface
from pelagos.compat.holoocean.frames import matrix_of
from pelagos.compat.holoocean.sensors import SensorDefinition

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
LOCATION, ROTATION = {"sensor_type": "LocationSensor"}, {"sensor_type": "RotationSensor"}
DYNAMICS = {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": True}}


def test_limits_of_actions():
    with opened(agent("UavAgent", location=(0, 0, 5))) as env:
        space = env.agents["auv0"].control_schemes[0][1]
        np.testing.assert_allclose(space.get_high(), [5.087, 6.508, 0.8, 5984.4], rtol=1e-5)
        np.testing.assert_allclose(space.get_low(), [-5.087, -6.508, -0.8, -5984.4], rtol=1e-5)
    with opened(agent("SphereAgent")) as env:
        discrete, continuous = (space for _, space in env.agents["auv0"].control_schemes)
        assert (discrete.get_low(), discrete.get_high()) == (0, 4)
        np.testing.assert_allclose([continuous.get_low(), continuous.get_high()], [[-20, -20], [20, 20]])
    with opened(agent("TurtleAgent")) as env:
        space = env.agents["auv0"].control_schemes[0][1]
        np.testing.assert_allclose([space.get_low(), space.get_high()], [[-160, -35], [160, 35]])


@pytest.mark.parametrize("what", ["location", "rotation"])
def test_a_start_at_random_differs_after_every_reset_and_stays_in_its_range(what):
    spread = {f"{what}_randomization": [3, 2, 1], "rotation": [0, 0, 0]}
    with opened(agent("SphereAgent", [LOCATION, ROTATION], location=(10, 10, 5), **spread)) as env:
        name = "LocationSensor" if what == "location" else "RotationSensor"
        middle, seen = np.array([10, 10, 5.0] if what == "location" else [0, 0, 0.0]), []
        for _ in range(4):
            env.reset()
            seen.append(env.tick()[name])
            assert (np.abs(seen[-1] - middle) <= np.array([3, 2, 1]) + 1e-4).all()
        assert all((a != b).any() for a, b in itertools.pairwise(seen))


@pytest.mark.parametrize(
    ("kind", "scheme"),
    [("HoveringAUV", 2), ("BlueROV2", 2), ("TorpedoAUV", 1), ("CougUV", 1), ("SurfaceVessel", 2)],
)
def test_an_acceleration_is_what_was_asked_for(kind, scheme):
    asked = np.array([1, 2, 3, 0.1, 0.2, 0.3])
    with opened(agent(kind, [DYNAMICS], scheme=scheme)) as env:
        state = env.step(asked, ticks=20)["DynamicsSensor"]
        np.testing.assert_allclose(np.r_[state[:3], state[9:12]], asked, rtol=1e-3 if kind == "CougUV" else 1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize(
    ("kind", "asked", "ticks", "rtol", "start"),
    [
        ("HoveringAUV", [2, 2, -12, 0, 20, 45], 200, 0.1, (0, 0, -10)),
        ("BlueROV2", [2, 2, -12, 0, 0, 45], 200, 0.2, (0, 0, -10)),
        ("SurfaceVessel", [20, 20], 300, 1.0, (10, 10, 0.15)),
    ],
)
def test_a_pose_is_reached(kind, asked, ticks, rtol, start, legacy):
    with opened(agent(kind, [LOCATION, ROTATION], scheme=1, location=start), legacy_dynamics=legacy) as env:
        state = env.step(asked, ticks=ticks)
        places = min(3, len(asked))
        np.testing.assert_allclose(state["LocationSensor"][:places], asked[:places], rtol=rtol)


@pytest.mark.parametrize("kind", ["TorpedoAUV", "CougUV"])
def test_fins_by_hand_pitch_and_turn(kind):
    sensor = {"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}}
    more = {"fossen_model": "torpedo", "control_mode": "manualControl"}
    with opened(agent(kind, [sensor, ROTATION], scheme=1, **more), ticks_per_sec=30) as env:
        fossen = FossenInterface(["auv0"], env._scenario)
        fossen.set_u_control("auv0", [-0.087, -0.087, 0.087, 0.087, 800])
        state = env.tick()
        for _ in range(200):
            state = env.step(fossen.update("auv0", state))
        _, pitch, yaw = state["RotationSensor"]
        assert pitch < 0
        assert yaw < 0


@pytest.mark.parametrize("height", [-5, 5])
@pytest.mark.parametrize("legacy", [False, True])
def test_a_vessel_comes_to_the_surface_from_both_sides(height, legacy):
    vessel = agent("SurfaceVessel", [LOCATION], location=(10, 10, height))
    with opened(vessel, legacy_dynamics=legacy) as env:
        assert abs(env.tick(100)["LocationSensor"][2]) < 1


SHIPPED = sorted(
    f"{scenario['world']}-{scenario['name']}"
    for package, _ in packagemanager._iter_packages()
    for world in package["worlds"]
    for scenario, _ in packagemanager._iter_scenarios(world["name"])
    if not any(s["sensor_type"] in SensorDefinition._sonar_sensors for a in scenario["agents"] for s in a["sensors"])
)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scenario_has_agents_and_sensors_after_20_ticks(name):
    scenario = packagemanager.get_scenario(name)
    seen = set()
    with holoocean.make(name, show_viewport=False) as env:
        for _ in range(20):
            seen |= set(env.tick())
        for one in scenario["agents"]:
            assert one["agent_name"] in env.agents
            for sensor in one["sensors"]:
                known = sensor.get("sensor_name", sensor["sensor_type"])
                assert known in env.agents[one["agent_name"]].sensors
                assert known in seen or sensor["sensor_type"] == "GPSSensor"


def test_five_resets_give_the_same_start_and_leave_the_scenario_as_it_is():
    start = agent("SphereAgent", [LOCATION, ROTATION], location=(0.95, -1.75, 0.5), rotation=[10, 20, 30])
    with opened(copy.deepcopy(start)) as env:
        first = env.tick()
        for _ in range(5):
            env.step([0], ticks=5)
            env.reset()
            state = env.tick()
            np.testing.assert_allclose(state["RotationSensor"], first["RotationSensor"], rtol=0.3)
            assert len(env.agents) == 1
            assert list(env.agents["auv0"].sensors) == ["LocationSensor", "RotationSensor"]
            assert env._scenario["agents"][0]["location"] == start["location"]
            assert env._scenario["agents"][0]["rotation"] == start["rotation"]


@pytest.mark.parametrize("turn", [(90, 0, 0), (0, 40, 0), (15, -25, 130)])
def test_a_spawn_a_sensor_and_a_teleport_turn_about_fixed_axes(turn):
    plain = {"sensor_type": "OrientationSensor"}
    with opened(agent("SphereAgent", [plain], rotation=list(turn))) as env:
        np.testing.assert_allclose(env.tick()["OrientationSensor"], matrix_of(turn), atol=1e-5)
    with opened(agent("SphereAgent", [plain | {"rotation": list(turn)}])) as env:
        np.testing.assert_allclose(env.tick()["OrientationSensor"], matrix_of(turn), atol=1e-5)
    with opened(agent("SphereAgent", [plain])) as env:
        env.agents["auv0"].teleport(rotation=list(turn))
        np.testing.assert_allclose(env.tick()["OrientationSensor"], matrix_of(turn), atol=1e-5)


def test_make_runs_ten_ticks():
    scenario = {
        "name": "t", "world": "TestWorld", "package_name": "TestWorlds", "frames_per_sec": False,
        "agents": [agent("SphereAgent", [LOCATION])],
    }  # fmt: skip
    with holoocean.make(scenario_cfg=scenario, show_viewport=False) as env:
        for _ in range(10):
            assert "LocationSensor" in env.tick()
