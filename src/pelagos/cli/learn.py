"""`pelagos train` and `pelagos evaluate`."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from pelagos.cli.console import err, out, shown
from pelagos.errors import CommandError, InputError
from pelagos.files import whole


@dataclass(frozen=True)
class Lesson:
    """Options of `pelagos train`; see its help."""

    steps: int
    seed: int
    copies: int
    out: Path | None
    until: str | None
    max_s: float | None
    discount: float


def learn(task: str, lesson: Lesson, options: Sequence[str]) -> None:
    """Train, and write what came out; stopped by Ctrl-C, nothing is written but the curve so far.

    Raises:
        InputError: no such task, option or metric, or a folder that holds something else.
    """
    from pelagos.envs.ppo import Recipe, train
    from pelagos.envs.registry import PREFIX, has_sensors, make

    short = task.removeprefix(PREFIX)
    folder = lesson.out or Path("runs") / short
    if lesson.steps < 1:
        raise CommandError(f"steps is a number from 1 on, not {lesson.steps}")
    if not 0 < lesson.discount < 1:
        raise CommandError(f"discount is a number between 0 and 1, not {lesson.discount:g}")
    recipe = Recipe(steps=lesson.steps, until=_until(lesson.until), max_s=lesson.max_s, discount=lesson.discount)
    arrays = {} if has_sensors(task) else {"arrays": "torch"}
    env: Any = make(task, lesson.copies, seed=lesson.seed, **arrays, **_pairs(options))
    folder.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, float]] = []

    def each(row: dict[str, float]) -> None:
        rows.append(row)
        if len(rows) % 10 == 1:
            told = ", ".join(f"{k} {v:.3g}" for k, v in row.items() if k not in ("steps", "seconds"))
            err.print(f"{row['steps']:>12,.0f} steps {row['seconds']:6.0f} s  {told}", markup=False)

    try:
        trained = train(env, recipe, seed=lesson.seed, name=PREFIX + short, each=each)
    finally:
        if rows:
            _write_curve(folder / "curve.csv", rows)
    trained.policy.save(folder / "policy.npz")
    _draw_curve(folder / "curve.png", rows, PREFIX + short)
    last = trained.curve[-1]
    what = {"task": PREFIX + short, "options": _pairs(options), "seed": lesson.seed, "copies": lesson.copies}
    (folder / "run.json").write_text(json.dumps(what | {"end": last, "reached": trained.reached}, indent=2) + "\n")
    if recipe.until is not None:
        out.print(f"{recipe.until[0]} <= {recipe.until[1]:g}: {'reached' if trained.reached else 'not reached'}")
    out.print(f"policy: {shown(folder / 'policy.npz')}", markup=False)
    out.print(f"score it: pelagos evaluate {short} --policy {shown(folder / 'policy.npz')}", markup=False)


def score(
    task: str, policy: str, *, episodes: int, seed: int, film: Path | None, as_json: bool, options: Sequence[str]
) -> None:
    """Run whole episodes and print the means.

    Raises:
        InputError: no such task, option or policy.
    """
    from pelagos.envs.evaluate import evaluate
    from pelagos.envs.policy import policy_of
    from pelagos.envs.registry import make

    if episodes < 1:
        raise CommandError(f"episodes is a number from 1 on, not {episodes}")
    env = make(task, min(episodes, 256), seed=seed, **_pairs(options))
    acts = policy_of(policy, env, seed=seed)
    summary = evaluate(env, acts, seed=seed, episodes=episodes).summary()
    if as_json:
        out.print(json.dumps({"task": task, "policy": policy, "seed": seed, **summary}, indent=2), markup=False)
    else:
        width = max(len(name) for name in summary)
        for name, value in summary.items():
            out.print(f"{name:{width}}  {value:.4g}", markup=False)
    if film is not None:
        _draw_way(film, task, policy, seed, _pairs(options))
        err.print(f"written: {shown(film)}", markup=False)


def keep(
    task: str, policy: str, *, minari: str | None, lerobot: Path | None, episodes: int, seed: int,
    options: Sequence[str],
) -> None:  # fmt: skip
    """Run whole episodes and keep them, for Minari by an id and for LeRobot in a folder.

    Raises:
        InputError: no such task, option or policy, an id or a folder that is taken, or a package that is missing.
    """
    from pelagos.envs.lerobot import save_lerobot
    from pelagos.envs.policy import policy_of
    from pelagos.envs.registry import make
    from pelagos.envs.trajectories import collect, save_minari

    env = make(task, min(episodes, 64), seed=seed, **_pairs(options))
    found = collect(env, policy_of(policy, env, seed=seed), seed=seed, episodes=episodes)
    kept = []
    if minari is not None:
        what = f"{task}, policy {policy}, seed {seed}"
        kept.append(save_minari(found, env, minari, policy=policy, what=what))
    if lerobot is not None:
        kept.append(save_lerobot(found, env, lerobot, task=task))
    for folder in kept:
        err.print(f"{len(found)} episodes, {sum(map(len, found))} decisions: {shown(folder)}", markup=False)


def _draw_way(path: Path, task: str, policy: str, seed: int, options: dict[str, Any]) -> None:
    from PIL import Image

    from pelagos.envs.policy import policy_of
    from pelagos.envs.registry import make_single

    env = make_single(task, "rgb_array", seed=seed, **options)
    acts = policy_of(policy, env.fleet, seed=seed)
    seen, _ = env.reset(seed=seed)
    over = False
    while not over:
        rows = {k: v[None] for k, v in seen.items()} if isinstance(seen, dict) else seen[None]
        seen, _, terminated, truncated, _ = env.step(acts(rows)[0])
        over = terminated or truncated
    picture = env.render()
    assert picture is not None
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as fresh:
        Image.fromarray(picture).save(fresh)


def _pairs(options: Sequence[str]) -> dict[str, Any]:
    found = {}
    for text in options:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise InputError(f"--set {text!r}: write OPTION=VALUE")
        found[key] = yaml.safe_load(value)
    return found


def _until(text: str | None) -> tuple[str, float] | None:
    if text is None:
        return None
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise InputError(f"--until {text!r}: write METRIC=VALUE, such as distance_m=0.3") from None


def _write_curve(path: Path, rows: list[dict[str, float]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _draw_curve(path: Path, rows: list[dict[str, float]], title: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    names = [name for name in rows[0] if name not in ("steps", "seconds")]
    figure = Figure(figsize=(7, 2.2 * len(names)), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    for i, name in enumerate(names):
        axes = figure.add_subplot(len(names), 1, i + 1)
        told = [(row["steps"], row[name]) for row in rows if row[name] == row[name]]
        axes.plot([s for s, _ in told], [v for _, v in told])
        axes.set_ylabel(name if name != "reward" else "reward a step")
        axes.grid(alpha=0.3)
        if not i:
            axes.set_title(f"{title}, {rows[-1]['seconds']:.0f} s")
    axes.set_xlabel("decisions of all copies")
    canvas.print_png(str(path))
