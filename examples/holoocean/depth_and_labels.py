"""A depth camera and a camera of labels at one place: `pelagos holoocean depth_and_labels.py [PICTURE.png]`."""

import sys

import holoocean
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

size = {"CaptureWidth": 512, "CaptureHeight": 512}
scenario = {
    "name": "cameras", "world": "Dam", "package_name": "Ocean", "ticks_per_sec": 30, "main_agent": "rov0",
    "agents": [{
        "agent_name": "rov0", "agent_type": "BlueROV2", "control_scheme": 0, "location": [0, 0, -10],
        "rotation": [0, 0, 180],
        "sensors": [
            {"sensor_type": "DepthCamera", "sensor_name": "DepthForwardCamera", "socket": "CameraSocket", "Hz": 5,
             "configuration": dict(size)},
            {"sensor_type": "SemanticSegmentationCamera", "sensor_name": "SemanticForwardFacingCamera",
             "socket": "CameraSocket", "configuration": dict(size)},
        ],
    }],
}  # fmt: skip
with holoocean.make(scenario_cfg=scenario) as env:
    state = env.tick()
depth, labels = state["DepthForwardCamera"]["depth"], state["SemanticForwardFacingCamera"]
figure, axes = plt.subplots(1, 2, figsize=(10, 5), layout="tight")
axes[0].imshow(depth, cmap="viridis", vmax=60)
axes[1].imshow(labels[:, :, 2::-1])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "depth_and_labels.png", dpi=90)
print(f"nearest {depth.min():.2f} m, {len(set(map(tuple, labels.reshape(-1, 4))))} labels")
