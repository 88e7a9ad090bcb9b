"""Whole episodes of every task by its script and by chance, with other options than the usual ones: what is seen, paid
and measured, how they end, begin anew, and are kept by Minari and LeRobot; a formation; networks."""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from known import EXACT, SINGLE, check, on_one_scale
from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.flat import as_rows, row_size
from pelagos.envs.fleet import FleetEnv
from pelagos.envs.picture import Track
from pelagos.envs.policy import Network, policy_of
from pelagos.envs.registry import has_sensors, make_task, task_class
from pelagos.envs.sensing import SensingEnv
from pelagos.envs.single import SingleEnv
from pelagos.envs.trajectories import collect, save_minari

STEPS = 14
OTHER_FACTOR = 0.8  # of every number that a task is made with
OTHERWISE = ("Docking-v0", "PathInCurrent-v0", "WallInspection-v0")  # of which other numbers are other kernels
PICTURES = ("ObstacleAvoidance-v0", "PipelineFollowing-v0")  # worlds and pictures that take long to compile


def made(name: str, *, otherwise: bool, n: int = 3, **options: Any) -> Any:
    """A task of a few decisions; with other numbers than it usually has."""
    given: dict[str, Any] = {}
    if otherwise:
        parameters = inspect.signature(task_class(name)).parameters.values()
        given = {p.name: OTHER_FACTOR * p.default for p in parameters if isinstance(p.default, float)}
    task: Any = make_task(name, **given)
    task.seconds = (STEPS // 2 if name.endswith(PICTURES) else STEPS) / task.rate_hz
    env = SensingEnv(task, n, **options) if has_sensors(name) else FleetEnv(task, n, **options)
    return env, given


@pytest.mark.parametrize("name", envs.task_names())
def test_episodes_by_script_and_by_chance(name: str) -> None:
    short = name.removeprefix("pelagos/")
    usual, _ = made(name, otherwise=False, n=2 if short in PICTURES else 3, seed=5, environment=2)
    other, given = made(name, otherwise=True, n=2, seed=8) if short in OTHERWISE else (usual, {})
    found: dict[str, Any] = {"names": [list(getattr(usual, "names", [])), given, usual.metadata["render_modes"]]}
    for label, env in (("usual", usual), ("other", other)):
        if label == "other" and not given:
            continue
        quick, script = short not in PICTURES, getattr(env.task, "script", None)
        for policy in ("script", "random") if script and quick else ("random",):
            seen, acted, paid = [], [], []
            episodes = collect(env, policy_of(policy, env, seed=4), seed=6, episodes=(1 + quick) * env.num_envs)
            for e in episodes:
                seen.append(e.observations)
                acted.append(e.actions)
                paid.append([e.rewards, e.terminations, e.truncations, e.seed, e.environment, e.episode])
            found |= {f"{label} {policy} seen": seen, f"{label} {policy} acts": acted, f"{label} {policy} paid": paid}
            if not quick:  # what the script would do: it chooses, so that a last bit may turn it elsewhere
                found["would act"] = [env.task.script(e.observations) for e in episodes if script]
        if not quick:
            continue
        scores = evaluate(env, policy_of("zero", env), seed=3)
        found[f"{label} scores"] = [scores.summary(), scores.metrics, scores.returns, scores.lengths]
    share = SINGLE if has_sensors(name) else 1e-4
    check("episodes", short, {part: on_one_scale(v) for part, v in found.items()}, share)


@pytest.mark.parametrize("name", ["pelagos/Hover-v0", "pelagos/TerrainFollowing-v0"])
def test_ways_to_begin_anew(name: str) -> None:
    """Next step, none, and some copies alone; actions that are too large; the states of copies."""
    found: dict[str, Any] = {}
    for mode in ("next_step", "disabled"):
        env, _ = made(name, otherwise=False, seed=5, autoreset=mode)
        shown: list[Any] = [env.reset(seed=9)[0]]
        acts = np.random.default_rng(2).uniform(-1.7, 1.7, (STEPS + 4, *env.action_space.shape))
        for k, action in enumerate(acts):
            seen, reward, terminated, truncated, info = env.step(action)
            shown.append([seen, reward, terminated, truncated, {m: v for m, v in info.items() if m != "final_info"}])
            if k in (4, 9):
                shown.append(env.reset(options={"reset_mask": np.array([True, False, k > 5])})[0])
        shown.append(env.reset()[0])
        found[mode] = shown
        found[f"{mode} state"] = [env.state, env.first_environment, env.not_finite, getattr(env, "clipped", 0)]
    check(
        "episodes",
        f"beginnings {name.removeprefix('pelagos/')}",
        {k: on_one_scale(v) for k, v in found.items()},
        SINGLE,
    )


def test_a_single_copy_and_its_chart() -> None:
    env = SingleEnv(made("pelagos/Hover-v0", otherwise=False, n=1, autoreset="disabled")[0], render_mode="rgb_array")
    told: list[Any] = [env.reset(seed=3)]
    track = Track([1.0, -2.0, -3.0])
    for k in range(6):
        told.append(env.step(np.linspace(-0.8, 0.9, env.action_space.shape[0]) * (-1) ** k))
        track.note(env.fleet.state)
    picture = env.render()
    assert picture is not None
    rows = np.array([[place, bow] for place, bow in zip(track._places, [track._bow] * 6, strict=True)])
    dark = (picture.reshape(12, 40, 16, 40, 3).mean(axis=(1, 3)) / 255).round(1)
    found = {"told": told, "track": [rows, env._track._goal, picture.shape], "rate": env.metadata}
    check("episodes", "single", {k: on_one_scale(v) for k, v in found.items()}, SINGLE)
    check("episodes", "single, chart", {"blocks": dark}, 0.1)  # fonts and lines are Matplotlib's


def test_a_formation() -> None:
    from pelagos.envs.team import FormationEnv

    env = FormationEnv(3, radius_m=2.5, speed_mps=0.3, seconds=2.0)
    found: dict[str, Any] = {"about": [env.possible_agents, env._even]}
    for label in ("script", "turning"):
        seen, _ = env.reset(seed=4)
        shown: list[Any] = [seen]
        while env.agents:
            turning = {a: np.array([1.4, -0.6, 0.8]) * (-1) ** i / (1 + i) for i, a in enumerate(env.agents)}
            seen, *rest = env.step(env.script(seen) if label == "script" else turning)
            shown.append([seen, rest])
        found[label] = shown
    found["next"] = [env.reset()[0]]
    check("episodes", "formation", {k: on_one_scale(v) for k, v in found.items()}, SINGLE)


def numbers_in(table: Any) -> dict[str, list[Any]]:
    """Columns of a table; of pictures their checksums."""
    return {
        name: [v["bytes"] if isinstance(v, dict) else v for v in table[name].to_pylist()] for name in table.column_names
    }


@pytest.mark.parametrize("name", ["pelagos/DepthHeading-v0", "pelagos/WallInspection-v0"])
def test_data_sets(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All tables of LeRobot's form, and what Minari reads back."""
    import pyarrow.parquet as pq

    from pelagos.envs.lerobot import save_lerobot

    env, _ = made(name, otherwise=False, n=2, seed=5)
    episodes = collect(env, policy_of("random", env, seed=4), seed=6, episodes=4)
    folder = save_lerobot(episodes, env, tmp_path / "set", task="do it", file_mb=1e-3)
    files = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*.*"))
    info, stats = (json.loads((folder / f"meta/{part}.json").read_text()) for part in ("info", "stats"))
    found: dict[str, Any] = {"files": files, "info": info, "stats": stats}
    for k, file in enumerate(f for f in files if ".parquet" in f):
        columns = numbers_in(pq.read_table(folder / file))
        found[f"table {k}"] = [[n, v] for n, v in columns.items() if not n.startswith("stats/")]
        found[f"table {k} stats"] = [[n, v] for n, v in columns.items() if n.startswith("stats/")]
    schema = [pq.read_schema(folder / f) for f in files if ".parquet" in f]
    found["types"] = [[[field.name, str(field.type)] for field in s] for s in schema]
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    import minari

    save_minari(episodes, env, "pelagos/it/random-v3", policy="random", what="chance")
    read = minari.load_dataset("pelagos/it/random-v3")
    kept = [
        [e.id, e.observations, e.actions, e.rewards, e.terminations, e.truncations] for e in read.iterate_episodes()
    ]
    found["minari"] = [kept, read.total_episodes, read.total_steps, read.spec.dataset_id]
    check(
        "episodes", f"data of {name.removeprefix('pelagos/')}", {k: on_one_scale(v) for k, v in found.items()}, SINGLE
    )


def test_pictures_in_a_data_set() -> None:
    """Columns and statistics of colours, by LeRobot's own form, and rows of several arrays."""
    import pyarrow as pa

    from pelagos.envs import lerobot

    rng = np.random.default_rng(3)
    pictures = (rng.uniform(0, 1, (5, 6, 4, 3)) * [90, 180, 250]).astype(np.uint8)
    parts = [pictures[:2], pictures[2:]]
    kinds = {
        "p": pictures,
        "grid": rng.uniform(-1, 1, (5, 3, 2)),
        "row": rng.uniform(-1, 1, (5, 3)).astype("f4"),
        "one": np.arange(5),
    }
    columns = {name: lerobot._column(pa, values) for name, values in kinds.items()}
    rows = {"sonar": pictures[..., 0].reshape(5, -1)[:, :4].astype("f4"), "state": kinds["row"]}
    found = {
        "statistics": [
            lerobot._of_picture(parts),
            lerobot._statistics([{"row": kinds["row"][:3]}, {"row": kinds["row"][3:]}]),
        ],
        "columns": [[str(c.type), c.to_pylist() if name != "p" else len(c)] for name, c in columns.items()],
        "names": [lerobot._feature(name, values) for name, values in kinds.items()],
        "rows": as_rows(rows),
    }
    check("episodes", "pictures", {k: on_one_scale(v) for k, v in found.items()}, EXACT)


def test_networks(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    env, _ = made("pelagos/Waypoint-v0", otherwise=False, n=2)
    size, acts = row_size(env.single_observation_space), env.single_action_space.shape[0]
    shapes = [(7, size), (5, 7), (acts, 5)]
    network = Network(
        rng.normal(size=size).astype("f4"),
        rng.uniform(0.5, 2, size).astype("f4"),
        [rng.normal(size=s).astype("f4") / 2 for s in shapes],
        [rng.normal(size=s[0]).astype("f4") / 3 for s in shapes],
        "it",
    )
    network.save(tmp_path / "it.npz")
    seen = (3 * rng.normal(size=(4, size))).astype("f4")
    seen[0, 0] = 1e5
    back = policy_of(str(tmp_path / "it.npz"), env)
    check("episodes", "network", {"acts": on_one_scale([network(seen), back(seen)])}, SINGLE)
