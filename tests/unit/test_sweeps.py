"""Sweeps and Ray: every combination once, the same results wherever they are made."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import Any

import pytest
from fake_jobs import Killed

import pelagos as pl
from pelagos.cli.main import main
from pelagos.datasets.engine import Engine, checked
from pelagos.datasets.sweep import Sweep, axis_of, run_sweep, sweep_of
from pelagos.errors import InputError

SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 20,
    "duration_s": 3,
    "world": {"type": "flat", "depth_m": 30},
    "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.0, "towards_deg": 30}]},
    "agents": {"auv": {"vehicle": "bluerov2_heavy", "start": {"position_m": [1.0, -2.0], "depth_m": 5}}},
}
SPEED = "ocean.currents.0.speed_mps"


def sweep(folder: Path, *vary: str, seconds: float | None = 2.0) -> Sweep:
    return sweep_of(pl.load_scenario(SCENARIO), [axis_of(v) for v in vary], folder, seconds=seconds)


def test_each_combination_runs_as_it_would_alone(tmp_path: Path) -> None:
    made = sweep(tmp_path / "s", f"{SPEED}=0.2,0.7", "agents.auv.start.heading_deg=10:50:2")
    records = run_sweep(made)
    assert [list(r["values"].values()) for r in records] == [[0.2, 10.0], [0.2, 50.0], [0.7, 10.0], [0.7, 50.0]]
    alone = pl.Simulation.load(made.of(2))
    alone.run(2.0)
    x, y, z = alone.state["auv"].position[0]
    assert (records[2]["auv.x_m"], records[2]["auv.y_m"], records[2]["auv.z_m"]) == (x, y, z)
    assert len({r["state_sha256"] for r in records}) == 4
    with (tmp_path / "s" / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row[SPEED], row["simulated_s"]) for row in rows] == [(v, "2.0") for v in ("0.2", "0.2", "0.7", "0.7")]


def test_yes_is_not_one() -> None:
    assert [type(v) for v in axis_of("sensors.dvl.ideal=1,true,0,false").values] == [int, bool, int, bool]


def test_a_sweep_goes_on_where_it_was_ended(tmp_path: Path) -> None:
    made = sweep(tmp_path / "s", f"{SPEED}=0.1,0.3,0.4", seconds=0.5)
    first = run_sweep(made)
    before = {i: made.path(i).stat().st_mtime_ns for i in range(3)}
    made.path(1).write_text(made.path(1).read_text()[:40])
    assert run_sweep(made) == first
    assert [made.path(i).stat().st_mtime_ns != before[i] for i in range(3)] == [False, True, False]
    with pytest.raises(InputError, match="another sweep"):
        run_sweep(sweep(tmp_path / "s", f"{SPEED}=0.1,0.3", seconds=0.5))


def test_a_run_that_cannot_be_is_told_and_the_others_go_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "s.json"
    file.write_text(json.dumps(SCENARIO))
    words = (
        "sweep",
        str(file),
        "--vary",
        "agents.auv.start.depth_m=4,35",
        "--duration",
        "0.5",
        "--out",
        str(tmp_path / "o"),
    )
    with pytest.raises(SystemExit) as caught:
        main(words)
    told = capsys.readouterr()
    assert caught.value.code == 1
    assert "run 1: " in told.err
    assert "lies inside the seabed" in " ".join(told.err.split())
    assert "35" in told.out
    assert json.loads((tmp_path / "o/runs/run-00000.json").read_text())["simulated_s"] == 0.5


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ((), "nothing varies"),
        (("ocean.turbidity",), "write KEY.PATH=VALUES"),
        (("ocean.turbidity=1,,2",), "a value is missing"),
        (("ocean.turbidity=1,1",), "given twice"),
        (("ocean.turbidity=true,1,true",), "True is given twice"),
        (("ocean.turbidity=0:1:2.5",), "a whole count from 2 on, not 2.5"),
        (("ocean.turbidty=1,2",), "did you mean 'turbidity'"),
        (("ocean.turbidity=1,-2",), "at least 0, not -2"),
        (("seed=1,2", "seed=3,4"), "--vary seed is given twice"),
    ],
)
def test_wrong_axes_are_refused(tmp_path: Path, vary: tuple[str, ...], message: str) -> None:
    with pytest.raises(InputError, match=message):
        sweep(tmp_path, *vary)
    assert not list(tmp_path.iterdir())


def test_values_are_lists_ranges_and_yaml() -> None:
    assert axis_of("a.b=1,2.5,x").values == (1, 2.5, "x")
    assert axis_of("a=[[1, 2], {c: 3}]").values == ([1, 2], {"c": 3})
    assert axis_of("a=-1:1:3").values == (-1.0, 0.0, 1.0)


def test_a_ray_that_is_not_there_is_one_sentence(tmp_path: Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed")
    with pytest.raises(InputError, match=r"--ray 127\.0\.0\.1:9: nothing answers there"):
        list(Engine(ray="127.0.0.1:9").run(Killed(tmp_path, 0), range(3)))
    with pytest.raises(InputError, match="give local, auto, HOST:PORT"):
        list(Engine(ray="nowhere").run(Killed(tmp_path, 0), range(3)))
    with pytest.raises(InputError, match=r"--ray 127\.0\.0\.1:9: nothing answers there"):
        checked(2, "127.0.0.1:9")  # before a folder is written


def test_ray_that_is_not_installed_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "ray", None)
    with pytest.raises(InputError, match=r"--ray needs Ray: pip install 'pelagos\[ray\]'"):
        checked(2, "local")
    with pytest.raises(InputError, match=r"--ray needs Ray: pip install 'pelagos\[ray\]'"):
        list(Engine(ray="local").run(Killed(tmp_path, 0), range(3)))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # Ray's own
def test_ray_gives_what_this_process_gives_though_a_worker_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray", reason="Ray is not installed")
    found = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]  # workers of Ray import `fake_jobs` too
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, found)))
    (tmp_path / "tries").mkdir()
    records = list(Engine(workers=2, ray="local").run(Killed(tmp_path / "tries", 1), range(4)))
    assert sorted(r["index"] for r in records) == [0, 1, 2, 3]
    here = run_sweep(sweep(tmp_path / "here", f"{SPEED}=0.1,0.6", seconds=0.5))
    there = run_sweep(sweep(tmp_path / "there", f"{SPEED}=0.1,0.6", seconds=0.5), Engine(workers=2, ray="local"))
    assert here == there
