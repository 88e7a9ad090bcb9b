"""Shipped scenarios as native ones: the same poses to the bit for the same commands."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from holoocean_env import agent

import pelagos as pl
import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean import packagemanager
from pelagos.compat.holoocean.convert import converted

pytestmark = pytest.mark.filterwarnings("ignore::pelagos.compat.holoocean.advice.HoloOceanWarning")
COMMANDS = {
    "HoveringAUV": ([5, 4, 5, 6, 10, 10, 6, 6], [-3, 2, 4, -1, -8, 3, 6, 2]),
    "TorpedoAUV": ([10, 5, -10, -5, 60], [-10, 8, 10, -8, 30]),
    "TurtleAgent": ([50, 10], [80, -20]),
}
SHIPPED = {
    Path(path).stem: path
    for package, _ in packagemanager._iter_packages()
    for world in package["worlds"]
    for _, path in packagemanager._iter_scenarios(world["name"])
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_a_native_twin_goes_the_same_way(name):
    scenario = packagemanager.get_scenario(name)
    (agent,) = scenario["agents"]
    agent["sensors"] = []
    env = holoocean.make(scenario_cfg=scenario)
    twin = yaml.safe_load(converted(Path(SHIPPED[name])))
    (own,) = twin["agents"].values()
    assert len(own.pop("sensors")) == len(packagemanager.get_scenario(name)["agents"][0]["sensors"])
    sim = pl.Simulation.load(twin)
    sim.step(ticks=env._pre_start_steps + 1)
    for numbers in COMMANDS[agent["agent_type"]]:
        env.step(np.array(numbers), ticks=100)
        sim.step({agent["agent_name"]: env.agents[agent["agent_name"]].command()}, ticks=100)
    here, there = (s.state[agent["agent_name"]] for s in (env.pelagos, sim))
    np.testing.assert_array_equal(here.position, there.position)
    np.testing.assert_array_equal(here.attitude, there.attitude)
    assert np.linalg.norm(here.position[0] - agent["location"]) > 0.1


@pytest.mark.parametrize(("ticks", "hertz"), [(200, 50), (60, 60), (120, 10)])
def test_noise_of_a_reading_becomes_a_density(tmp_path, ticks, hertz):
    """A deviation s of each reading is s/sqrt(Hz) as density; a bias that is shifted by s at every tick, whatever the
    rate of its sensor, has walked s sqrt(ticks a second) after a second."""
    imu = {
        "AccelSigma": [0.2, 0.3, 0.1],
        "AccelBiasSigma": 0.03,
        "AngVelSigma": 0.01,
        "AngVelBiasSigma": [2e-3, 5e-3, 1e-3],
    }
    beams = {"Elevation": 25.0, "MaxRange": 31.0, "VelSigma": 0.02}
    sensors = [
        {"sensor_type": "IMUSensor", "Hz": hertz, "configuration": imu},
        {"sensor_type": "DVLSensor", "Hz": hertz, "configuration": beams},
        {"sensor_type": "GPSSensor", "Hz": hertz, "configuration": {"Sigma": 0.4}},
        {"sensor_type": "LocationSensor", "Hz": hertz},
    ]
    path = tmp_path / "noisy.json"
    one = agent("HoveringAUV", sensors, location=(2, -3, -10))
    path.write_text(json.dumps({"name": "n", "world": "TestWorld", "package_name": "TestWorlds", "main_agent": "auv0",
                                "ticks_per_sec": ticks, "agents": [one]}))  # fmt: skip
    (own,) = yaml.safe_load(converted(path))["agents"].values()
    kept = {keys["type"]: keys for keys in own["sensors"].values()}
    assert {keys["rate_hz"] for keys in kept.values()} == {hertz}
    assert kept["imu"]["accelerometer_noise_density"] == pytest.approx(0.3 / hertz**0.5)
    assert kept["imu"]["accelerometer_random_walk"] == pytest.approx(0.03 * ticks**0.5)
    assert kept["imu"]["gyroscope_noise_density"] == pytest.approx(0.01 / hertz**0.5)
    assert kept["imu"]["gyroscope_random_walk"] == pytest.approx(0.005 * ticks**0.5)
    assert kept["dvl"]["noise_mps"] == 0.02
    assert kept["dvl"]["range_max_m"] == pytest.approx(31 * np.cos(np.radians(25)))
    assert kept["gps"]["noise_density"] == pytest.approx(0.4 / hertz**0.5)
