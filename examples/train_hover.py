"""Teach a BlueROV2 Heavy to hover: PPO over 512 copies, scores beside chance and a scripted baseline.

Needs `pip install 'pelagos[learn]'`. Run it with `PELAGOS_THREADS=1` on a machine with few cores. With a number it
takes so many decisions: `python examples/train_hover.py 2000000`.
"""

import sys
from pathlib import Path

from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.policy import policy_of
from pelagos.envs.ppo import Recipe, train


def main(steps: int, folder: Path) -> None:
    learners = envs.make("pelagos/Hover-v0", n=512, arrays="torch")
    trained = train(
        learners,
        Recipe(steps=steps),
        seed=0,
        each=lambda row: print(f"{row['steps']:>9,.0f} steps  {row['seconds']:5.0f} s  reward {row['reward']:.3f}"),
    )
    folder.mkdir(parents=True, exist_ok=True)
    trained.policy.save(folder / "hover.npz")
    judges = envs.make("pelagos/Hover-v0", n=64)
    for name in ("random", "script", str(folder / "hover.npz")):
        scores = evaluate(judges, policy_of(name, judges), seed=3).summary()
        print(f"{name:>24}: return {scores['return']:6.1f}, {scores['distance_m']:.2f} m from the pose")


if __name__ == "__main__":
    main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 2_000_000, Path("runs"))
