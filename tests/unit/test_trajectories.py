"""Episodes that are kept: what Minari reads back is what happened."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pelagos import envs
from pelagos.envs.lerobot import save_lerobot
from pelagos.envs.policy import policy_of
from pelagos.envs.tasks.depth_heading import DepthHeading
from pelagos.envs.tasks.pipeline import PipelineFollowing
from pelagos.envs.tasks.terrain import TerrainFollowing
from pelagos.envs.trajectories import collect, save_minari
from pelagos.errors import CommandError, InputError


class Short(DepthHeading):
    seconds = 0.7


class Piped(PipelineFollowing):
    seconds = 1.2


class Hilly(TerrainFollowing):
    seconds = 0.6


def test_episodes_are_those_of_their_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import minari

    env = envs.FleetEnv(Short(), 3, environment=4)
    found = collect(env, policy_of("script", env), seed=5, episodes=6)
    assert [(e.environment, e.episode, len(e)) for e in found] == [(4 + i, k, 7) for i in range(3) for k in range(2)]
    alone = envs.FleetEnv(Short(), 1, environment=5, autoreset="disabled")
    seen, _ = alone.reset(seed=5)
    seen, _ = alone.reset()  # episode 1
    for k, action in enumerate(found[3].actions):
        np.testing.assert_array_equal(seen[0], found[3].observations[k])
        seen, reward, _, truncated, _ = alone.step(action[None])
        assert reward[0] == found[3].rewards[k]
        assert truncated[0] == found[3].truncations[k] == (k == 6)
    np.testing.assert_array_equal(seen[0], found[3].observations[7])

    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    save_minari(found, env, "pelagos/depth/script-v0", policy="script")
    read = minari.load_dataset("pelagos/depth/script-v0")
    assert read.total_episodes == 6
    assert read.observation_space == env.single_observation_space
    for mine, theirs in zip(found, read.iterate_episodes(), strict=True):
        np.testing.assert_array_equal(mine.observations, theirs.observations)
        np.testing.assert_array_equal(mine.actions, theirs.actions)
        np.testing.assert_array_equal(mine.rewards, theirs.rewards)
        np.testing.assert_array_equal(mine.truncations, theirs.truncations)
    with pytest.raises(CommandError, match="is there already"):
        save_minari(found, env, "pelagos/depth/script-v0")
    with pytest.raises(CommandError, match="write NAMESPACE/NAME-v0"):
        save_minari(found, env, "depth script")
    assert not list(tmp_path.glob(".part-*"))


def test_observations_by_name_and_a_disk_that_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import minari

    env: Any = envs.SensingEnv(Hilly(), 2)
    found = collect(env, policy_of("script", env), seed=1)
    assert found[1].observations["state"].shape == (4, 8)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    save_minari(found, env, "terrain-v0")
    read = minari.load_dataset("terrain-v0")
    np.testing.assert_array_equal(read[1].observations["state"], found[1].observations["state"])

    monkeypatch.setattr(minari, "create_dataset_from_buffers", full)
    with pytest.raises(Exception, match="terrain-v1 cannot be written"):
        save_minari(found, env, "terrain-v1")
    assert {p.name for p in tmp_path.iterdir()} == {"terrain-v0"}
    with pytest.raises(CommandError, match="autoreset='same_step'"):
        collect(envs.FleetEnv(Short(), 2, autoreset="disabled"), policy_of("zero", env))


def test_lerobots_tables_hold_the_episodes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    env: Any = envs.SensingEnv(Piped(), 2)
    found = collect(env, policy_of("script", env), seed=5, episodes=4)
    folder = save_lerobot(found, env, tmp_path / "set", task="follow the pipe", file_mb=0.05)
    about = json.loads((folder / "meta/info.json").read_text())
    assert (about["codebase_version"], about["fps"], about["total_episodes"]) == ("v3.0", 5, 4)
    assert about["features"]["observation.images.camera"]["shape"] == [84, 84, 3]
    rows = parquet.read_table(folder / "meta/episodes").to_pylist()
    assert [row["data/file_index"] for row in rows] == [0, 1, 2, 3]  # an episode is larger than a file should be
    seen: dict[int, list[Any]] = {0: [], 1: [], 2: []}
    for episode, row in zip(found, rows, strict=True):
        path = about["data_path"].format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
        frames = parquet.read_table(folder / path).to_pylist()
        assert len(frames) == len(episode) == row["length"] == row["dataset_to_index"] - row["dataset_from_index"]
        for k, frame in enumerate(frames):
            assert frame["index"] == row["dataset_from_index"] + k
            assert frame["timestamp"] == pytest.approx(k / 5)
            assert frame["next.reward"] == episode.rewards[k]
            assert frame["next.done"] == (k == len(episode) - 1)
            np.testing.assert_array_equal(np.float32(frame["action"]), episode.actions[k])
            np.testing.assert_array_equal(np.float32(frame["observation.state"]), episode.observations["state"][k])
            picture = np.array(Image.open(io.BytesIO(frame["observation.images.camera"]["bytes"])))
            np.testing.assert_array_equal(picture, episode.observations["camera"][k])
            for channel, values in seen.items():
                values.append(picture[..., channel] / 255)
    told = json.loads((folder / "meta/stats.json").read_text())["observation.images.camera"]
    for channel, values in seen.items():
        for kind in ("min", "max", "mean", "std"):
            assert told[kind][channel][0][0] == pytest.approx(float(getattr(np, kind)(values)), rel=1e-9)
        half = np.array(values) <= told["q50"][channel][0][0]
        assert half.mean() >= 0.5 > (half & (np.array(values) < told["q50"][channel][0][0])).mean()

    with pytest.raises(CommandError, match="is there already"):
        save_lerobot(found, env, folder, task="again")
    monkeypatch.setattr(parquet, "write_table", full)
    with pytest.raises(InputError, match="No space left on device; nothing of it was kept"):
        save_lerobot(found, env, tmp_path / "other", task="again")
    assert {p.name for p in tmp_path.iterdir()} == {"set"}


def full(*_: Any, **__: Any) -> None:
    raise OSError(28, "No space left on device")
