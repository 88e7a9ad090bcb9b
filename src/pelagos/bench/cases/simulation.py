"""The public face of a simulation: steps with commands, and runs, of large fleets without sensors."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.cases.vehicles import SUBSTEPS, Fleet
from pelagos.bench.check import must
from pelagos.bench.timing import seconds, seconds_in_turns
from pelagos.sim.simulation import Simulation

RUN_S: Final = 1.0
TURNING: Final = (0.05, -0.02, 1300.0)
BEFORE: Final = Reference("the same in November 2026, before it was mended", 3.2)


def _fleet(vehicle: str, n: int) -> Simulation:
    """Copies at places of their own in a uniform current, far from the ground, driven by their actuators."""
    start = {"position_m": [0.0, 0.0], "depth_m": 20.0, "speed_mps": 1.0}
    scenario: dict[str, Any] = {
        "world": {"type": "flat", "depth_m": 400.0},
        "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 30.0}]},
        "agents": {"auv0": {"vehicle": vehicle, "control": "actuators", "start": start}},
    }
    sim = Simulation.load(scenario, n=n)
    place = np.random.default_rng(1).uniform((-100, -100, -40), (100, 100, -15), (n, 3))
    sim.set_state("auv0", position=place)
    return sim


def _must_have_moved(sim: Simulation, before: Any) -> None:
    after = sim.state["auv0"].position
    must(bool(np.isfinite(after).all()), "a vehicle's position is not finite")
    must(bool((np.abs(after - before).max(axis=0) > 0.001).all()), "a vehicle does not move")


def sim_step_4096_ms() -> Measured:
    """One tick of 4096 BlueROV2 Heavy by `Simulation.step`, every time with other commands for each."""
    sim = _fleet("bluerov2_heavy", 4096)
    commands = np.random.default_rng(2).uniform(-0.4, 0.4, (64, 4096, 8))
    before, count = sim.state["auv0"].position.copy(), 0

    def step() -> None:
        nonlocal count
        sim.step({"auv0": commands[count % 64]})
        count += 1

    took = seconds(step, at_least_s=3.0)
    _must_have_moved(sim, before)
    return Measured(1e3 * took, detail="commands (4096, 8) in NumPy, other ones each step; no sensors")


def fleet_run_16384_msteps() -> Measured:
    """16384 REMUS 100 by `Simulation.run`."""
    sim, bare = _fleet("remus100", 16384), Fleet("remus100", n=16384, steps=SUBSTEPS, command=list(TURNING))
    sim.step({"auv0": TURNING})
    before = sim.state["auv0"].position.copy()
    took, peer = seconds_in_turns(lambda: sim.run(RUN_S), bare.block, at_least_s=2.0)
    _must_have_moved(sim, before)
    rate, limit = sim.n * RUN_S * 1e9 / sim.dt_ns / took * 1e-6, bare.n * SUBSTEPS / peer * 1e-6
    return Measured(rate, Reference("the same model in the bare kernel", limit), f"runs of {RUN_S:g} s, no sensors")


CASES: Final = (
    Case(
        name="sim_step_4096_ms",
        title="One public step of 4096 BlueROV2 Heavy",
        measure=sim_step_4096_ms,
        unit="ms",
        goal=0.6,
        better="lower",
        reference=BEFORE,
    ),
    Case(
        name="fleet_run_16384_msteps",
        title="16384 REMUS 100 through `Simulation.run`",
        measure=fleet_run_16384_msteps,
        unit="M vehicle-steps/s",
        goal=80.0,
        better="higher",
        reference=Reference("the same model in the bare kernel"),
    ),
)
