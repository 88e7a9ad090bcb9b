"""Tasks with sensors in the loop: the ways of their scripted baselines, and what these see.

python examples/learning_gallery.py PICTURE.png [--seconds 60]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from pelagos import envs

COPIES = 3
HALF_APERTURE_DEG = 60.0  # of the sonar of ObstacleAvoidance-v0
SONAR_M = 10.0


def flown(name: str, seconds: float) -> tuple[Any, np.ndarray, dict[str, np.ndarray]]:
    """The environment, ways `(steps, COPIES, 3)` NWU [m], and what was seen half-way."""
    env: Any = envs.make(f"pelagos/{name}", COPIES, autoreset="disabled")
    seen, _ = env.reset(seed=4)
    ways, middle, steps = [env.state["position"]], seen, round(seconds * env.task.rate_hz)
    for k in range(steps):
        seen, _, terminated, truncated, _ = env.step(env.task.script(seen))
        ways.append(env.state["position"])
        middle = seen if k == steps // 2 else middle
        if (terminated | truncated).all():
            break
    return env, np.array(ways), middle


def terrain(axes: Any, seconds: float) -> None:
    """Height over ground along the way."""
    env, ways, _ = flown("TerrainFollowing-v0", seconds)
    for i in range(COPIES):
        x, y, z = ways[:, i].T
        line = axes[0].plot(x, z)[0]
        ground = env.sim.world.height(x, y)
        axes[0].fill_between(x, ground, ground - 0.3, color=line.get_color(), alpha=0.4)
        axes[1].plot(x, z - ground, color=line.get_color())
    axes[0].set(title="TerrainFollowing-v0: three ways and their ground", xlabel="north [m]", ylabel="z [m]")
    axes[1].axhline(4.0, color="0.5", lw=0.8)
    axes[1].set(title="height over ground", xlabel="north [m]", ylabel="[m]", ylim=(0, 8))


def obstacles(axes: Any, seconds: float) -> None:
    """A chart of the pillars with ways, and a ping."""
    env, ways, seen = flown("ObstacleAvoidance-v0", seconds)
    for north, west in env.task.pillars:
        axes[0].add_patch(plt.Circle((-west, north), 0.5, color="0.4"))
    for i in range(COPIES):
        axes[0].plot(-ways[:, i, 1], ways[:, i, 0])
    axes[0].set(title="ObstacleAvoidance-v0", xlabel="east [m]", ylabel="north [m]", xlim=(-20, 20), aspect="equal")
    picture = seen["sonar"][0]
    extent = (HALF_APERTURE_DEG, -HALF_APERTURE_DEG, 0, SONAR_M)  # the first beam looks to the left
    axes[1].imshow(picture.T, origin="lower", aspect="auto", extent=extent, cmap="inferno")
    axes[1].set(title="what its sonar sees, on the way", xlabel="to the left [deg]", ylabel="range [m]")


def pipeline(axes: Any, seconds: float) -> None:
    """A chart of the pipe with ways, and a picture."""
    env, ways, seen = flown("PipelineFollowing-v0", seconds)
    things = env.task.scenario()["world"]["things"]
    for thing in things:
        (north, west, _), length = thing["at_m"], thing["size_m"][2]
        turn = np.radians(thing["orientation_deg"][2])
        ends = np.array([-0.5, 0.5]) * length
        axes[0].plot(-(west + ends * np.sin(turn)), north + ends * np.cos(turn), color="0.6", lw=5)
    for i in range(COPIES):
        axes[0].plot(-ways[:, i, 1], ways[:, i, 0])
    axes[0].set(title="PipelineFollowing-v0", xlabel="east [m]", ylabel="north [m]", aspect="equal", xlim=(-12, 12))
    axes[1].imshow(seen["camera"][0])
    axes[1].set(title="what its camera sees, on the way", xticks=[], yticks=[])


def main() -> None:
    """Draw all three."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0, help="of each task")
    given = parser.parse_args()
    figure, axes = plt.subplots(2, 3, figsize=(12, 7.5), layout="constrained")
    for column, draw in enumerate((terrain, obstacles, pipeline)):
        draw(axes[:, column], given.seconds)
    given.picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(given.picture, dpi=90)


if __name__ == "__main__":
    main()
