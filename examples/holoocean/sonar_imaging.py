"""An imaging sonar in HoloOcean's interface, drawn as a fan: `pelagos holoocean sonar_imaging.py`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

config = {
    "name": "imaging", "world": "PierHarbor", "package_name": "Ocean", "ticks_per_sec": 20, "frames_per_sec": False,
    "agents": [{
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 0, "location": [-20, 10, -10],
        "sensors": [{
            "sensor_type": "ImagingSonar", "socket": "SonarSocket", "Hz": 2,
            "configuration": {
                "RangeBins": 256, "AzimuthBins": 256, "RangeMin": 1, "RangeMax": 40, "Azimuth": 120, "Elevation": 20,
                "AddSigma": 0.05, "MultSigma": 0.1,
            },
        }],
    }],
}  # fmt: skip
sonar = config["agents"][0]["sensors"][-1]["configuration"]
azimuth = np.radians(np.linspace(-sonar["Azimuth"] / 2, sonar["Azimuth"] / 2, sonar["AzimuthBins"]))
ranges = np.linspace(sonar["RangeMin"], sonar["RangeMax"], sonar["RangeBins"])

with holoocean.make(scenario_cfg=config) as env:
    for _ in range(11):
        state = env.tick()
        if "ImagingSonar" in state:
            image = state["ImagingSonar"]

figure, axes = plt.subplots(subplot_kw={"projection": "polar"}, figsize=(8, 6))
axes.set_theta_zero_location("N")
axes.set_thetamin(-60)
axes.set_thetamax(60)
axes.pcolormesh(azimuth, ranges, image, shading="auto", cmap="copper")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "sonar.png", dpi=100)
print(f"{image.shape} from {image.min():.2f} to {image.max():.2f}")
