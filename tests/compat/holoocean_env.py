"""Environments made as HoloOcean's own tests make them."""

import copy
import uuid

from pelagos.compat.holoocean import packagemanager
from pelagos.compat.holoocean.environments import HoloOceanEnvironment


def agent(kind, sensors=(), *, name="auv0", scheme=0, location=(0, 0, -10), **more):
    return {
        "agent_name": name, "agent_type": kind, "sensors": copy.deepcopy(list(sensors)), "control_scheme": scheme,
        "location": list(location), **more,
    }  # fmt: skip


def opened(*agents, seed=0, **keys):
    main = agents[0]["agent_name"]
    scenario = {"name": "test", "world": "TestWorld", "main_agent": main, "frames_per_sec": False, "agents": [*agents]}
    where = packagemanager.get_binary_path_for_package("TestWorlds")
    return HoloOceanEnvironment(
        scenario={**scenario, **keys}, binary_path=where, show_viewport=False, verbose=True, uuid=str(uuid.uuid4()),
        seed=seed,
    )  # fmt: skip
