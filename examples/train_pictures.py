"""Teach a BlueROV2 Heavy to follow a wall by sonar or a pipe by camera: PPO of Stable-Baselines3 on small pictures.

Needs `pip install 'pelagos[learn]' stable-baselines3`. Run it with `PELAGOS_THREADS=1` on a machine with few cores:

    python examples/train_pictures.py WallInspection-v0 150000 runs/wall
    python examples/train_pictures.py draw curves.png runs/wall runs/pipeline
"""

import csv
import sys
import time
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.sb3 import SB3Env

COPIES = 16
SIDE = 16  # pictures are averaged to so many pixels, each way


class Small(BaseFeaturesExtractor):
    """Pictures averaged to 16 x 16, against their own mean; two convolutions; and the numbers."""

    def __init__(self, space):
        (self.picture,) = (name for name in space.spaces if name != "state")
        shape = space[self.picture].shape
        self.colour = len(shape) == 3
        channels = 3 if self.colour else 1
        super().__init__(space, 64 + space["state"].shape[0])
        self.layers = torch.nn.Sequential(
            torch.nn.Conv2d(channels, 16, 4, stride=2), torch.nn.ReLU(),
            torch.nn.Conv2d(16, 16, 3, stride=2), torch.nn.ReLU(),
            torch.nn.Flatten(), torch.nn.Linear(16 * 9, 64), torch.nn.ReLU(),
        )  # fmt: skip

    def forward(self, seen):
        picture = seen[self.picture].float()
        if self.colour:
            channels = picture.shape[1] == 3  # SB3 puts colours first where it knows a picture
            picture = picture if channels else picture.permute(0, 3, 1, 2)
        else:
            picture = torch.log1p(picture.clamp(min=0)).unsqueeze(1)
        picture = torch.nn.functional.adaptive_avg_pool2d(picture, SIDE)
        over = (1, 2, 3)
        picture = (picture - picture.mean(over, keepdim=True)) / (picture.std(over, keepdim=True) + 1e-3)
        return torch.cat([self.layers(picture), seen["state"]], dim=1)


class Curve(BaseCallback):
    """A row a rollout: decisions, seconds, mean return of the last episodes."""

    def __init__(self, path):
        super().__init__()
        self.path, self.began, self.rows = path, time.perf_counter(), []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        returns = [episode["r"] for episode in self.model.ep_info_buffer]
        if returns:
            self.rows.append([self.num_timesteps, round(time.perf_counter() - self.began, 1), float(np.mean(returns))])
            print("{:>9,} decisions  {:5.0f} s  return {:7.1f}".format(*self.rows[-1]), flush=True)
            with self.path.open("w", newline="") as file:
                csv.writer(file).writerows([["steps", "seconds", "return"], *self.rows])


def main(task: str, steps: int, folder: Path) -> None:
    torch.set_num_threads(1)
    folder.mkdir(parents=True, exist_ok=True)
    learners = VecNormalize(
        VecMonitor(SB3Env(envs.make(f"pelagos/{task}", n=COPIES))), norm_obs_keys=["state"], gamma=0.97
    )
    model = PPO(
        "MultiInputPolicy", learners, n_steps=128, batch_size=256, n_epochs=4, gamma=0.97, learning_rate=6e-4, seed=0,
        policy_kwargs={"features_extractor_class": Small, "net_arch": [64], "log_std_init": -0.7}, device="cpu",
    )  # fmt: skip
    model.learn(steps, callback=Curve(folder / "curve.csv"))
    model.save(folder / "policy")
    learners.save(str(folder / "normal.pkl"))

    def acts(seen):
        return model.predict(learners.normalize_obs(seen), deterministic=True)[0]

    scores = evaluate(envs.make(f"pelagos/{task}", n=8), acts, seed=3).summary()
    print({name: round(value, 3) for name, value in scores.items()})


def draw(picture: Path, folders: list[Path]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(folders), figsize=(4 * len(folders), 3), squeeze=False, layout="constrained")
    for place, folder in zip(axes[0], folders, strict=True):
        steps, seconds, returns = np.loadtxt(folder / "curve.csv", delimiter=",", skiprows=1).T
        place.plot(steps / 1e3, returns)
        place.set_title(f"{folder.name}, {steps[-1] / 1e3:.0f} 000 decisions in {seconds[-1]:.0f} s", fontsize=9)
        place.set_xlabel("thousand decisions")
        place.grid(alpha=0.3)
    axes[0][0].set_ylabel("return, mean of 100 episodes")
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    if sys.argv[1:2] == ["draw"]:
        draw(Path(sys.argv[2]), [Path(folder) for folder in sys.argv[3:]])
        sys.exit()
    name = sys.argv[1] if len(sys.argv) > 1 else "WallInspection-v0"
    count = int(float(sys.argv[2])) if len(sys.argv) > 2 else 200_000
    main(name, count, Path(sys.argv[3]) if len(sys.argv) > 3 else Path("runs") / name)
