"""Identification of a USV from a tank run: parameters, their intervals, and open loop on what was not fitted.

Run: python examples/fit_usv.py cse1_random_run4.csv.gz   (NTNU-MCS/CS_EnterpriseI_archive; fit_usv_plan.yaml)
Without a file, a run of an Otter with known parameters is made up and fitted: python examples/fit_usv.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import pelagos as pl
from pelagos.config.loader import load_scenario
from pelagos.identification import Fit, fit, load_plan, read_record

HERE = Path(__file__).parent
TRUE = {"surge_kg_s": 62.0, "yaw_s": 1.25}
PLAN = {
    "columns": {"north": "x", "east": "y", "heading": "psi"},
    "commands": {"left_propeller": "left", "right_propeller": "right"},
    "segment_s": 4,
    "iterations": 12,
    "parameters": {
        "surge": {"path": "terms.damping.surge_kg_s"},
        "yaw": {"path": "terms.damping.yaw_s"},
        "offset.heading": {"spread": 0.1},
    },
}


def made_up_run(seconds: float = 40.0) -> dict[str, np.ndarray]:
    """Poses of an Otter with `TRUE` damping, every 0.1 s, with 1 cm and 0.3 deg of noise."""
    vehicle = {"type": "otter", "terms": {"damping": TRUE}, "integrator": "runge_kutta"}  # ticks of 0.1 s are long
    agent = {"vehicle": vehicle, "control": "actuators", "start": {"position_m": [0, 0, 0]}}
    sim = pl.Simulation.load({"name": "run", "tick_rate_hz": 10, "world": {"type": "flat", "depth_m": 20},
                              "agents": {"usv0": agent}})  # fmt: skip
    sim.reset(seed=1)
    random = np.random.default_rng(5)
    rows = []
    for k in range(int(seconds * 10)):
        if k % 20 == 0:
            command = random.uniform(20, 95, 2)
        state = sim.state["usv0"]
        w, x, y, z = state.attitude[0]
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        north, west = state.position[0, :2]
        noise = random.normal(0, [0.01, 0.01, 0.005])
        rows.append([k / 10, north + noise[0], -west + noise[1], -yaw + noise[2], *command])
        sim.step({"usv0": command})
    return dict(zip(("t", "x", "y", "psi", "left", "right"), np.array(rows).T, strict=True))


def show(made: Fit) -> None:
    for e in made.estimates:
        print(f"{e.parameter.name:16s} {e.value:9.4f}  [{e.low:.4f}, {e.high:.4f}]  identified: {e.identified}")
    assert made.test is not None
    print("unseen part, R2:", {k: round(v, 3) for k, v in made.test.r2.items()})


def main(record: str | None = None) -> Fit:
    if record is None:
        plan = load_plan(PLAN)
        made = fit({"type": "otter"}, read_record(made_up_run(), plan), plan)
    else:
        plan = load_plan(HERE / "fit_usv_plan.yaml")
        vehicle = load_scenario(HERE / "fit_usv.yaml").members["usv0"].vehicle
        made = fit(vehicle, read_record(record, plan), plan, tell=print)
    show(made)
    return made


if __name__ == "__main__":
    main(*sys.argv[1:2])
