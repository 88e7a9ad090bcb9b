"""The page on learning: its Python, its own task, and the commands on a task."""

from __future__ import annotations

import json
import runpy
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_cli_docs import blocks

from pelagos import envs
from pelagos.cli.main import main

PAGE = Path(__file__).parents[2] / "docs" / "learning.md"


def test_the_task_of_the_page_works_and_its_vehicles_differ() -> None:
    namespace: dict[str, Any] = {"__name__": "page"}
    exec(blocks(PAGE, "python")[-1].replace("1024", "16"), namespace)
    env = namespace["env"]
    seen, _ = env.reset(seed=1)
    np.testing.assert_allclose(seen[:, 0], env.state["task.goal"] - env.state["position"][:, 2], atol=0.05)
    for _ in range(20):
        seen, reward, *_ = env.step(np.full((16, 1), 0.5))
    assert len({r.tobytes() for r in reward}) == 16
    assert (np.sort(env.state["vary.mass"])[[0, -1]] - 1.0 != 0).all()
    assert (np.abs(env.state["vary.mass"] - 1.0) < 0.02).all()
    assert (env.state["velocity"][:, 2] > 0.1).all()  # throttle up drives up


def test_the_gallery_draws_ways_and_what_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["learning_gallery.py", str(tmp_path / "g.png"), "--seconds", "1"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        runpy.run_path(str(PAGE.parents[1] / "examples" / "learning_gallery.py"), run_name="__main__")
    assert (tmp_path / "g.png").stat().st_size > 30_000


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # the libraries' own
def test_pictures_are_learned_from_and_the_curve_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("stable_baselines3")
    example, folder = str(PAGE.parents[1] / "examples" / "train_pictures.py"), str(tmp_path / "wall")
    monkeypatch.setattr(sys, "argv", [example, "WallInspection-v0", "8192", folder])
    runpy.run_path(example, run_name="__main__")
    rows = (tmp_path / "wall" / "curve.csv").read_text().splitlines()
    assert rows[0] == "steps,seconds,return"
    assert float(rows[-1].split(",")[2]) < 0  # it has only begun
    assert "'stand_off_error_m'" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", [example, "draw", str(tmp_path / "c.png"), folder])
    with pytest.raises(SystemExit):
        runpy.run_path(example, run_name="__main__")
    assert (tmp_path / "c.png").stat().st_size > 5_000


def test_commands_score_and_refuse(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    def run(*words: str) -> int:
        with pytest.raises(SystemExit) as caught:
            main(words)
        return int(caught.value.code or 0)

    picture = tmp_path / "way.png"
    words = ("evaluate", "DepthHeading-v0", "--episodes", "4", "--json", "--film", str(picture))
    assert run(*words) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["episodes"] == 4
    assert told["depth_error_m"] < 0.05
    assert picture.stat().st_size > 10_000
    for given, message in (
        (("evaluate", "Hovver-v0"), "did you mean 'pelagos/Hover-v0'"),
        (("evaluate", "Hover-v0", "--policy", "sript", "--episodes", "4"), "did you mean 'script'"),
        (("evaluate", "Hover-v0", "--set", "depth=3"), "did you mean 'depth_m'"),
    ):
        assert run(*given) == 2
        assert message in " ".join(capsys.readouterr().err.split())
    assert run("list", "tasks") == 0
    told = capsys.readouterr().out
    assert all(name in told for name in envs.task_names())
