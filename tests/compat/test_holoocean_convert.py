"""Shipped scenarios as native ones: the same poses to the bit for the same commands."""

from pathlib import Path

import numpy as np
import pytest
import yaml

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
