"""A single beam that looks down at OpenWater's ground, ping by ping: `pelagos holoocean sonar_singlebeam.py`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

PINGS = 60
config = {
    "name": "singlebeam", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 20, "frames_per_sec": False,
    "agents": [{
        "agent_name": "auv0", "agent_type": "TorpedoAUV", "control_scheme": 0, "location": [205, 457, -280],
        "sensors": [{
            "sensor_type": "RaycastSinglebeamSonar", "socket": "SonarSocket", "Hz": 10,
            "configuration": {
                "OpeningAngle": 30, "RangeMin": 0.5, "RangeMax": 30, "RangeBins": 300, "AddSigma": 0.02,
                "MultSigma": 0.05,
            },
        }],
    }],
}  # fmt: skip
sonar = config["agents"][0]["sensors"][-1]["configuration"]
ranges = np.linspace(sonar["RangeMin"], sonar["RangeMax"], sonar["RangeBins"])

pings = []
with holoocean.make(scenario_cfg=config) as env:
    env.act("auv0", np.array([0, 0, 0, 0, 75]))
    while len(pings) < PINGS:
        state = env.tick()
        if "RaycastSinglebeamSonar" in state:
            pings.append(state["RaycastSinglebeamSonar"])

figure, axes = plt.subplots(figsize=(8, 4))
axes.pcolormesh(np.arange(PINGS) / 10, -ranges, np.array(pings).T, shading="auto", cmap="copper")
axes.set(xlabel="time [s]", ylabel="below the sonar [m]")
figure.tight_layout()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "singlebeam.png", dpi=90)
print(f"{pings[0].shape}; the nearest strong echo lies {ranges[np.argmax(pings[-1] > 0.5)]:.1f} m below the sonar")
