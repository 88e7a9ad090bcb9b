"""A lidar over the water of a harbour: `pelagos holoocean lidar.py [PICTURE.png]`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

scenario = {
    "name": "lidar", "world": "PierHarbor", "package_name": "Ocean", "ticks_per_sec": 30,
    "agents": [{
        "agent_name": "sv0", "agent_type": "SurfaceVessel", "control_scheme": 0, "location": [-20, 10, 0],
        "sensors": [{
            "sensor_type": "RaycastLidar", "Hz": 10, "location": [0, 0, 2],
            "configuration": {"Channels": 64, "Range": 200, "PointsPerSecond": 200_000, "AtmospAttenRate": 0.004,
                              "RandomSeed": 42, "UpperFovLimit": 20, "socket": "Platform"},
        }],
    }],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    points = env.tick()["RaycastLidar"]
figure, axes = plt.subplots(figsize=(7, 7), layout="tight")
axes.scatter(points[:, 0], points[:, 1], c=points[:, 2], s=0.5, cmap="viridis")
axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"RaycastLidar: {len(points)} points")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "lidar.png", dpi=90)
print(f"{points.shape} from {points[:, 2].min():.1f} to {points[:, 2].max():.1f} m high")
