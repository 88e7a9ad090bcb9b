"""Real runs that end badly: killed outright, and out of room."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from pelagos.messages.navigation import IMU, IMU_FIELDS
from pelagos.sim.replay import Recording, recover
from pelagos.sim.simulation import Simulation

SCENARIO = {
    "name": "short", "duration_s": 600, "world": {"type": "flat"},
    "agents": {
        "auv0": {
            "vehicle": "remus100", "start": {"position_m": [0, 0, -5], "heading_deg": 30, "speed_mps": 1.5},
            "mission": [{"type": "dive", "depth_m": 8}, {"type": "hold", "seconds": 1000}],
            "sensors": {"imu": {"type": "imu", "rate_hz": 200}, "depth": {"type": "depth", "rate_hz": 50}},
        }
    },
}  # fmt: skip

DOCS = Path(__file__).parents[2] / "docs" / "recording.md"


def test_python_of_the_documentation_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenario = yaml.safe_load(yaml.safe_dump(SCENARIO))
    sensors = scenario["agents"]["auv0"]["sensors"]
    sensors |= {"dvl": {"type": "dvl", "rate_hz": 5}, "multibeam": {"type": "multibeam", "rate_hz": 1, "beams": 16}}
    namespace: dict[str, Any] = {"sim": Simulation.load(scenario)}
    exec(DOCS.read_text(encoding="utf-8").split("```python\n")[1].split("```")[0], namespace)
    assert namespace["values"].shape == (1001, 8)
    assert namespace["cloud"].width == 16
    assert namespace["dvl"].num_good_beams == 4
    assert {f"/auv0/{s}" for s in ("truth", "depth/pose", "dvl/twist")} <= set(namespace["recording"].topics())


KILLED = """
import sys
from pelagos.sim.simulation import Simulation
sim = Simulation.load({scenario!r})
sim.run(600, record={path!r}, realtime=True, progress=lambda t, _: print(t, flush=True))
"""


def test_a_killed_run_is_readable_up_to_the_last_second(tmp_path: Path) -> None:
    file, path = tmp_path / "scenario.yaml", tmp_path / "mission.mcap"
    file.write_text(yaml.safe_dump(SCENARIO))
    code = KILLED.format(scenario=str(file), path=str(path))
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        seen = 0.0
        for line in child.stdout:
            seen = float(line)
            if seen > 3.0:
                break
        os.kill(child.pid, signal.SIGKILL)
        rest = [float(line) for line in child.stdout.read().split("\n")[:-1]]
    seen = max([seen, *rest])
    assert seen > 3.0, "the run ended by itself"
    found = Recording(path)
    assert not found.complete
    assert found.times("/auv0/imu/data_raw")[-1] * 1e-9 > seen - 1.0
    before = found.table("/auv0/imu/data_raw", IMU_FIELDS)[1]
    again = Recording(recover(path).path)
    assert again.complete
    assert again.channels["/auv0/imu/data_raw"].type == IMU
    assert (again.table("/auv0/imu/data_raw", IMU_FIELDS)[1] == before).all()
    assert yaml.safe_load(again.attachments["scenario.yaml"])["agents"]["auv0"]["sensors"]["imu"]["rate_hz"] == 200


def test_a_full_disk_ends_a_run_with_one_clear_error(tmp_path: Path) -> None:
    file, folder = tmp_path / "scenario.yaml", tmp_path / "out"
    file.write_text(yaml.safe_dump(SCENARIO))
    limit = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))"
    code = f"{limit}; from pelagos.cli.main import main; main(sys.argv[1:])"
    done = subprocess.run(
        [sys.executable, "-c", code, "run", str(file), "--duration", "60", "--out", str(folder)],
        capture_output=True, text=True, env={**os.environ, "COLUMNS": "300", "HOME": str(Path.home())}, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert done.stderr.count("cannot write the recording: File too large; it is readable up to simulation time") == 1
    found = Recording(folder / "mission.mcap")
    assert found.count("/auv0/imu/data_raw") > 500
    assert not (folder / "report.html").exists()
