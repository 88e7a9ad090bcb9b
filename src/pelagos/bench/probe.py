"""One run of a scenario in a process of its own, which prints what it cost: `python -m pelagos.bench.probe`.

The parent's clock counts, from before the interpreter starts, so that imports are part of the start.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pelagos.bench.check import BenchError, must


def probe(
    scenario: Mapping[str, Any], *, seconds: float, warm_up_s: float = 0.0, home: Path | None = None
) -> dict[str, Any]:
    """Run a scenario in a fresh process.

    Args:
        scenario: as data.
        seconds: simulated time that is measured [s]; 0 stops after the first tick.
        warm_up_s: simulated time before that [s], to compile every kernel.
        home: home folder of the process, which holds the cache of compiled kernels; the user's own if None.

    Returns:
        first_tick_s: from the start of the interpreter to the end of the first tick [s]; real_time_factor; memory_mb;
        counts: readings by "agent.sensor"; ms_per_call: by "agent.part".

    Raises:
        BenchError: the process failed, or its sensors saw nothing.
    """
    environment = dict(os.environ)
    if home is not None:
        environment |= {"HOME": str(home), "XDG_CACHE_HOME": str(home / ".cache")}
    with tempfile.TemporaryDirectory() as folder:
        job = {"scenario": dict(scenario), "seconds": seconds, "warm_up_s": warm_up_s, "folder": folder}
        environment["PELAGOS_PROBE_START"] = repr(time.time())
        done = subprocess.run(
            [sys.executable, "-m", "pelagos.bench.probe"],
            input=json.dumps(job), capture_output=True, text=True, env=environment, check=False,
        )  # fmt: skip
    if done.returncode != 0:
        last = (done.stderr.strip() or "no message").splitlines()[-1]
        raise BenchError(f"the run ended with code {done.returncode}: {last}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _main() -> None:
    job = json.load(sys.stdin)
    from pelagos.sim.memory import peak_memory_mb
    from pelagos.sim.simulation import Simulation

    sim = Simulation.load(job["scenario"])
    first = sim.step()
    found: dict[str, Any] = {"first_tick_s": time.time() - float(os.environ["PELAGOS_PROBE_START"])}
    _check_pictures(first)
    if job["warm_up_s"] > 0:
        sim.run(job["warm_up_s"], record=Path(job["folder"]) / "warm_up.mcap")
    if job["seconds"] > 0:
        result = sim.run(job["seconds"], record=Path(job["folder"]) / "mission.mcap")
        for name, count in result.counts.items():
            may_be_silent = _type(job["scenario"], name) == "gps"  # under water
            must(count > 0 or may_be_silent, f"{name} gave no reading")
        found |= {
            "real_time_factor": result.real_time_factor,
            "counts": dict(result.counts),
            "ms_per_call": dict(result.ms_per_call),
        }
    found["memory_mb"] = peak_memory_mb()
    print(json.dumps(found))


def _type(scenario: Mapping[str, Any], name: str) -> str:
    """Type of the sensor "agent.sensor"."""
    agent, sensor = name.split(".")
    return str(scenario["agents"][agent]["sensors"][sensor].get("type", sensor))


def _check_pictures(observations: Mapping[str, Mapping[str, Any]]) -> None:
    """Sonar and camera images are not blank."""
    for agent, readings in observations.items():
        for name, reading in readings.items():
            if reading.data.ndim >= 3:
                must(float(np.std(reading.data)) > 0.0, f"the first image of {agent}.{name} is blank")


if __name__ == "__main__":
    _main()
