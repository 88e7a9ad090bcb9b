"""Identification of a vehicle: the model ship of `examples/fit_usv.yaml`, by its plan."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import example, must
from pelagos.config.loader import load_scenario
from pelagos.identification import fit, load_plan, read_record
from pelagos.sim.simulation import Simulation

_BEGIN_S: Final = 105.0  # as in the tank's record, of which the plan takes 105 to 373 s
_STEPS: Final = 2681
_STEP_S: Final = 0.1
_HELD: Final = 25  # steps for which a command is held
_SURGE_DRAG: Final = 2.9  # of the ship that sails; the plan's prior is 2.2


def fit_cse1_s() -> Measured:
    """Time of the fit of 195 s, seventeen parameters, and of its judgement on the 65 s after."""
    scenario, plan = example("fit_usv.yaml"), load_plan(example("fit_usv_plan.yaml"))
    vehicle = load_scenario(scenario).members["usv0"].vehicle
    made = fit(vehicle, read_record(_record(scenario), plan), plan)
    must(made.test is not None and min(made.test.r2.values()) > 0.9, "the part that was not fitted is predicted")
    must(abs(made.value("X_uu") / _SURGE_DRAG - 1) < 0.3, "the drag that was changed is found")
    return Measured(
        made.seconds, detail=f"{len(made.estimates)} parameters; a run of the length of the tank's, made up"
    )


def _record(scenario: Path) -> dict[str, NDArray[np.float64]]:
    """A run of a ship with more drag, under commands at random, with 2 mm and 0.2 deg of noise."""
    drag = [_SURGE_DRAG, 8.0, 0.0, 0.0, 0.0, 1.0]
    sim = Simulation.load(
        scenario,
        seed=1,
        overrides={"tick_rate_hz": 1 / _STEP_S, "agents.usv0.vehicle.terms.drag.diagonal": drag,
                   "agents.usv0.control": "actuators"},
    )  # fmt: skip
    random, rows = np.random.default_rng(5), []
    for step in range(_STEPS):
        if step % _HELD == 0:
            told = random.uniform(-0.8, 0.8, 5)
        state = sim.state["usv0"]
        place, yaw = state.position[0], state.euler[0, 2]
        noise = random.normal(0.0, [0.002, 0.002, 0.0035])
        rows.append([_BEGIN_S + step * _STEP_S, place[0] + noise[0], -place[1] + noise[1], -yaw + noise[2], *told])
        sim.step({"usv0": told})
    columns = np.array(rows).T
    columns[3] = np.unwrap(columns[3])
    commands = ("u1_vsp_stbd_or_port_surge", "u2_sway", "u3_surge", "u4_sway", "u5_bow")
    order = ("port_surge", "starboard_surge", "port_sway", "starboard_sway", "bow")  # of the vehicle's actuators
    by_actuator = dict(zip(order, columns[4:], strict=True))
    by_column = zip(commands, ("port_surge", "port_sway", "starboard_surge", "starboard_sway", "bow"), strict=True)
    return {
        "t": columns[0], "x_N": columns[1], "y_E": columns[2], "psi": columns[3],
        **{column: by_actuator[actuator] for column, actuator in by_column},
    }  # fmt: skip


CASES: Final = (
    Case("fit_cse1_s", "a model ship identified from 195 s of a run, by gradients through the simulator", fit_cse1_s,
         "s", 120.0, "lower", Reference("the length of the record that is fitted", 195.0)),
)  # fmt: skip
