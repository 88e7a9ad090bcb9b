"""Teach a team of BlueROV2 Heavies to keep a ring: PPO of Pelagos, one policy that all members share.

Needs `pip install 'pelagos[learn]' pettingzoo`. Run it with `PELAGOS_THREADS=1` on a machine with few cores:

    python examples/train_team.py 90000 runs/formation
"""

import sys
from pathlib import Path

import numpy as np

from pelagos.envs.policy import Network
from pelagos.envs.ppo import Recipe, train
from pelagos.envs.shared import SharedTeams, acts_of
from pelagos.envs.team import FormationEnv

MEMBERS, TEAMS, EPISODES = 3, 4, 8


def score(act) -> dict[str, float]:
    """Means over the first episodes of seed 3: the return of a member, and what the team comes to."""
    team, rows = FormationEnv(MEMBERS), []
    for i in range(EPISODES):
        seen, infos = team.reset(seed=3) if not i else team.reset()
        total = 0.0
        while team.agents:
            seen, rewards, terminated, _, infos = team.step(act(seen))
            total += rewards["rov0"]
        rows.append({"return": total, "lost": float(terminated["rov0"]), **infos["rov0"]})
    return {name: round(float(np.mean([row[name] for row in rows])), 3) for name in rows[0]}


def main(steps: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    numbers = np.random.default_rng(3)
    print("random", score(lambda seen: {a: numbers.uniform(-1, 1, 3).astype(np.float32) for a in seen}), flush=True)
    print("script", score(FormationEnv(MEMBERS).script), flush=True)
    teams = SharedTeams([FormationEnv(MEMBERS) for _ in range(TEAMS)])
    made = train(
        teams, Recipe(steps=steps, horizon=128), name="formation",
        each=lambda row: print({name: round(value, 3) for name, value in row.items()}, flush=True),
    )  # fmt: skip
    made.policy.save(folder / "policy.npz")
    policy = Network.load(folder / "policy.npz")
    print("PPO", score(lambda seen: acts_of(policy, seen)), flush=True)


if __name__ == "__main__":
    count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 90_000
    main(count, Path(sys.argv[2]) if len(sys.argv) > 2 else Path("runs") / "formation")
