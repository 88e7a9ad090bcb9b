"""The files for clusters: what a scheduler would start makes the data set that one call makes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from pelagos.datasets.config import load_config
from pelagos.datasets.factory import make_dataset
from pelagos.datasets.plan import plan_of

ROOT = Path(__file__).parents[2]
CONFIG: dict[str, Any] = {
    "seed": 9,
    "worlds": 3,
    "samples_per_world": 2,
    "batch": 2,
    "split": {"train": 0.67, "test": 0.33},
    "scenario": {
        "world": {"type": "generated", "size_m": [40, 30], "depth_m": 12, "objects": [{"kind": "boulder", "count": 9}]},
        "agents": {"rov": {"vehicle": "bluerov2_heavy", "sensors": {"depth": {"type": "depth", "rate_hz": 10}}}},
    },
}


@pytest.fixture
def pelagos(tmp_path: Path) -> dict[str, str]:
    """The environment of a shell that knows the command `pelagos`."""
    command = tmp_path / "bin" / "pelagos"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m pelagos "$@"\n')
    command.chmod(0o755)
    source = os.pathsep.join(filter(None, [str(ROOT / "src"), os.environ.get("PYTHONPATH", "")]))
    return {**os.environ, "PATH": f"{command.parent}{os.pathsep}{os.environ['PATH']}", "PYTHONPATH": source}


def reference(folder: Path) -> tuple[Path, str]:
    """A configuration, and the manifest of the data set that one call makes of it."""
    config = folder / "set.yaml"
    config.write_text(yaml.safe_dump(CONFIG))
    make_dataset(plan_of(load_config(config)), folder / "one", command="pelagos dataset set.yaml FOLDER")
    return config, (folder / "one" / "manifest.json").read_text()


def run(words: list[str], shell: dict[str, str], **more: str) -> None:
    done = subprocess.run(words, env=shell | more, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="bash")
def test_slurms_array_makes_what_one_call_makes(tmp_path: Path, pelagos: dict[str, str]) -> None:
    config, wanted = reference(tmp_path)
    script = ["bash", str(ROOT / "examples/cluster/dataset.sbatch"), str(config), str(tmp_path / "set")]
    for number in ("1", "0"):
        run(script, pelagos, SLURM_ARRAY_TASK_ID=number, SLURM_ARRAY_TASK_COUNT="2", SLURM_CPUS_PER_TASK="1")
    run([*script, "finish"], pelagos, SLURM_CPUS_PER_TASK="1")
    assert (tmp_path / "set" / "manifest.json").read_text() == wanted


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="sh")
def test_pods_make_what_one_call_makes(tmp_path: Path, pelagos: dict[str, str]) -> None:
    config, wanted = reference(tmp_path)
    job = yaml.safe_load((ROOT / "examples/cluster/dataset_job.yaml").read_text())["spec"]
    assert (job["completionMode"], job["template"]["spec"]["restartPolicy"]) == ("Indexed", "Never")
    (pod,) = job["template"]["spec"]["containers"]
    (line,) = pod["args"]
    assert line.endswith(f"--shard $JOB_COMPLETION_INDEX/{job['completions']}")
    line = line.replace("/config/dataset_harbour.yaml", str(config)).replace("/data/harbour_set", str(tmp_path / "set"))
    threads = {entry["name"]: entry["value"] for entry in pod["env"]}
    for index in reversed(range(job["completions"])):  # more pods than worlds: one has nothing to do
        run([*pod["command"], line], pelagos, JOB_COMPLETION_INDEX=str(index), **threads)
    run(["pelagos", "dataset", str(config), str(tmp_path / "set")], pelagos)
    assert (tmp_path / "set" / "manifest.json").read_text() == wanted
