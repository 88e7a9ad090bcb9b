"""Makes docs/images/harbour.png from a results folder of the harbour survey.

pelagos run examples/harbour_survey.yaml --out results/picture
python scripts/readme_picture.py results/picture docs/images/harbour.png
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from pelagos.config.loader import load_scenario
from pelagos.report.ground import draw_ground, relief
from pelagos.report.mission import Mission, missions
from pelagos.report.pictures import camera_topics
from pelagos.sim.replay import Recording
from pelagos.world.build import build_world
from pelagos.world.world import World

NIGHT = "#0b1620"
CAMERA_AT_S = (256.5, 354.0)  # the wreck, the pipeline
SONAR_AT_S = (41.8, 248.6)  # the pier, the wreck


def main(results: Path, target: Path) -> None:
    scenario = load_scenario(results / "scenario.yaml")
    world = build_world(scenario.world)
    mission = missions(Recording(results / "mission.mcap"))[0]
    figure = plt.figure(figsize=(12, 5.2), facecolor=NIGHT, layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.05, 1.25, 1.25])
    _map(figure.add_subplot(grid[:, 0]), world, mission)
    for row, t in enumerate(CAMERA_AT_S):
        _picture(figure.add_subplot(grid[row, 1]), _near(mission, camera_topics(mission)[0], t), "camera", row)
    for row, t in enumerate(SONAR_AT_S):
        preview = f"/{mission.agent}/imaging/preview/compressed"
        _picture(figure.add_subplot(grid[row, 2]), _near(mission, preview, t), "imaging sonar", row)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=110)


def _map(axes: plt.Axes, world: World, mission: Mission) -> None:
    track = mission.motion.position
    low, high = track[:, :2].min(axis=0) - 22, track[:, :2].max(axis=0) + 22
    ground = relief(world, low, high)
    draw_ground(axes, ground, matplotlib.colors.Normalize(*np.nanpercentile(ground.height, [2, 98])))
    axes.plot(-track[:, 1], track[:, 0], color="white", lw=1.6)
    axes.set_title("track on the bathymetry", color="white", fontsize=11)
    axes.set_aspect("equal")
    axes.axis("off")


def _near(mission: Mission, topic: str, t_s: float) -> bytes:
    """The picture that was taken nearest to a time."""
    times = [mission.recording.message(topic, k).t_ns * 1e-9 for k in range(mission.recording.count(topic))]
    index = int(np.argmin(np.abs(np.array(times) - t_s)))
    return bytes(mission.recording.message(topic, index).message.data)


def _picture(axes: plt.Axes, jpeg: bytes, title: str, row: int) -> None:
    axes.imshow(np.asarray(Image.open(io.BytesIO(jpeg)).convert("RGB")))
    if row == 0:
        axes.set_title(title, color="white", fontsize=11)
    axes.axis("off")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
