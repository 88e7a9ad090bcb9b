"""A profiling sonar that looks down at the ground below its way: `pelagos holoocean sonar_profiling.py`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

PINGS, SPEED, NORTH = 40, 0.5, np.array([1.0, 0.0, 0.0])  # m/s
config = {
    "name": "profiling", "world": "OpenWater", "package_name": "Ocean", "ticks_per_sec": 20, "frames_per_sec": False,
    "agents": [{
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 0, "location": [35, -40.5, -292.5],
        "sensors": [{
            "sensor_type": "ProfilingSonar", "rotation": [0, 90, 0], "Hz": 2,
            "configuration": {
                "RangeMin": 1, "RangeMax": 30, "RangeBins": 300, "Azimuth": 120, "AzimuthBins": 240, "Elevation": 1,
                "AddSigma": 0.02, "MultSigma": 0.05,
            },
        }],
    }],
}  # fmt: skip
sonar = config["agents"][0]["sensors"][-1]["configuration"]
azimuth = np.radians(np.linspace(-sonar["Azimuth"] / 2, sonar["Azimuth"] / 2, sonar["AzimuthBins"]))
ranges = np.linspace(sonar["RangeMin"], sonar["RangeMax"], sonar["RangeBins"])

profiles = []
with holoocean.make(scenario_cfg=config) as env:
    start = np.array(config["agents"][0]["location"], dtype=float)
    while len(profiles) < PINGS:
        env.agents["auv0"].teleport(start + SPEED * env._num_ticks / 20 * NORTH, [0, 0, 0])
        state = env.tick()
        if "ProfilingSonar" in state:
            image = state["ProfilingSonar"]
            profiles.append(ranges[image.argmax(axis=0)] * np.cos(azimuth))

figure, (fan, map_) = plt.subplots(1, 2, figsize=(11, 4.5))
across = np.outer(ranges, np.sin(azimuth))
down = np.outer(ranges, np.cos(azimuth))
fan.pcolormesh(across, -down, image, shading="auto", cmap="copper")
fan.set(xlabel="left [m]", ylabel="below the sonar [m]", aspect="equal")
shown = map_.pcolormesh(np.degrees(azimuth), np.arange(PINGS) * SPEED / 2, -np.array(profiles), shading="auto")
map_.set(xlabel="azimuth, left positive [deg]", ylabel="way [m]")
fan.invert_xaxis()
map_.invert_xaxis()
figure.colorbar(shown, ax=map_, label="ground below the sonar [m]")
figure.tight_layout()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "profile.png", dpi=90)
print(f"{image.shape}; the ground lies {np.median(profiles):.1f} m below the sonar")
