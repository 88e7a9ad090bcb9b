"""The same dive by HoloOcean's interface and by Pelagos's own, and what a tick takes in each."""

import time

import numpy as np

import pelagos as pl
import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean.worlds import native_world

TICKS = 400
COMMAND = np.array([10.0, 10, 10, 10, 0, 0, 0, 0])

scenario = {
    "name": "dive", "world": "SimpleUnderwater", "package_name": "Ocean", "ticks_per_sec": 200,
    "agents": [{
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 0, "location": [0, 0, -10],
        "sensors": [{"sensor_type": "IMUSensor"}, {"sensor_type": "PoseSensor"}],
    }],
}  # fmt: skip
env = holoocean.make(scenario_cfg=scenario, seed=7)
env.tick()
start = time.perf_counter()
for _ in range(TICKS):
    state = env.step(COMMAND)
ours = time.perf_counter() - start
print(f"holoocean: {1e3 * ours / TICKS:.3f} ms a tick, at {state['PoseSensor'][:3, 3].round(3)}")

sim = pl.Simulation.load(
    {
        **native_world("Ocean", "SimpleUnderwater"),
        "tick_rate_hz": 200,
        "agents": {
            "auv0": {
                "vehicle": "hovering_auv",
                "control": "actuators",
                "start": {"position_m": [0, 0, -10]},
                "sensors": {"imu": {"type": "imu"}, "pose": {"type": "pose", "rate_hz": 200}},
            }
        },
    }
)
sim.step()
start = time.perf_counter()
for _ in range(TICKS):
    readings = sim.step({"auv0": COMMAND})
native = time.perf_counter() - start
print(f"pelagos:   {1e3 * native / TICKS:.3f} ms a tick, at {readings['auv0']['pose'].data[0, :3].round(3)}")
