"""Dynamics of one's own, through control scheme 2: `pelagos holoocean custom_dynamics.py`.

A script works out the accelerations, from mass, thruster places and so on that the agent's class tells.
"""

import holoocean
import numpy as np
from holoocean.agents import HoveringAUV
from scipy.spatial.transform import Rotation

scenario = {
    "name": "own", "world": "SimpleUnderwater", "package_name": "Ocean", "ticks_per_sec": 100,
    "agents": [{
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 2, "location": [0, 0, -10],
        "sensors": [{"sensor_type": "DynamicsSensor", "configuration": {"UseCOM": True, "UseRPY": False}}],
    }],
}  # fmt: skip


def accelerations(state, thrusts):
    """Thrust, weight, buoyancy and a drag of 20 kg/s, as accelerations in the world."""
    x = state["DynamicsSensor"]
    velocity, turn, body = x[3:6], x[12:15], Rotation.from_quat(x[15:19])
    force = (HoveringAUV.thruster_d * thrusts[:, None]).sum(axis=0)
    moment = np.cross(HoveringAUV.thruster_p, HoveringAUV.thruster_d * thrusts[:, None]).sum(axis=0)
    lift = HoveringAUV.water_density * 9.8 * HoveringAUV.volume
    moment = moment + np.cross(HoveringAUV.cob, body.inv().apply([0, 0, lift]))
    linear = body.apply(force) + np.array([0, 0, lift - HoveringAUV.mass * 9.8]) - 20.0 * velocity
    angular = np.linalg.inv(HoveringAUV.I) @ (moment - 2.0 * body.inv().apply(turn))
    return np.concatenate([linear / HoveringAUV.mass, body.apply(angular)])


with holoocean.make(scenario_cfg=scenario) as env:
    state = env.tick()
    for _ in range(500):
        state = env.step(accelerations(state, np.array([0, 0, 0, 0, 10.0, 10, 10, 10])))
speed = 4 * 10 / np.sqrt(2) / 20
print(f"{state['DynamicsSensor'][3]:.3f} m/s ahead of {speed:.3f} at the end")
