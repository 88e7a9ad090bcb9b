"""Vehicle steps: fleets in one call, and one vehicle."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sim.driver import Driver
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.vehicle import Vehicle

SUBSTEPS: Final = 20
H_S: Final = 0.005
RISING: Final = 1000
"""Calls, 100 s, in which a BlueROV2 Heavy rises by 40 m."""
FOSSEN: Final = Reference("Fossen's Python Vehicle Simulator, one vehicle, same step", 0.016)
OCEANSCALE: Final = Reference("OceanScale's kernel on an RTX 5090, as published", 88.0)


class Fleet:
    """A fleet with constant commands to its actuators in a uniform current; `block` advances it by some steps."""

    def __init__(self, name: str, *, n: int, steps: int, command: list[float]) -> None:
        self.vehicle, self.n, self.steps = Vehicle.from_catalogue(name), n, steps
        world: Any = SimpleNamespace(origin=GeoOrigin(45.0, 13.0))
        current = {"type": "uniform", "speed_mps": 0.2, "towards_deg": 30.0}
        self.ocean = build_ocean(OceanConfig.model_validate({"currents": current}), world)
        place = np.random.default_rng(1).uniform((-100, -100, -40), (100, 100, -5), (n, 3))
        level = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
        self.state = self.vehicle.initial_state(place, level, np.tile([1.0, 0.0, 0.0], (n, 1)))
        still = dr.zeros(jit.Array3f64, n)
        self.command = [jit.Float64(np.full(n, c)) for c in command]
        self._rest = (self.command, dr.opaque(jit.Float64, H_S), still)
        dr.make_opaque(self._rest)
        self._frozen = dr.freeze(_block(self.vehicle, steps))

    def block(self) -> None:
        """One call."""
        self.state = self._frozen(self.state, self.ocean, self.vehicle.tables, *self._rest)
        dr.eval(self.state)
        dr.sync_thread()

    def depths(self) -> NDArray[np.float64]:
        """Depth of each [m]."""
        return np.asarray(self.state.position.numpy()[2])

    def timed(self) -> float:
        """Median time of a call [s], after a check that the fleet moves and stays finite."""
        before = self.state.position.numpy()
        took = seconds(self.block, at_least_s=2.0)
        after = self.state.position.numpy()
        must(bool(np.isfinite(after).all()), "a vehicle's position is not finite")
        must(bool((np.abs(after - before).max(axis=0) > 0.001).all()), "a vehicle does not move")
        return took


def _block(vehicle: Vehicle, steps: int) -> Callable[..., VehicleState]:
    def block(state: VehicleState, ocean: Any, tables: Any, command: list[Any], h: Any, still: Any) -> VehicleState:
        def advance(i: Any, state: VehicleState) -> tuple[Any, VehicleState]:
            t = jit.Float64(i) * h
            return i + 1, vehicle.step(state, command, ocean, t, (still, still), h, "actuators", tables)

        if steps == 1:
            return advance(jit.UInt32(0), state)[1]
        first = dr.zeros(jit.UInt32, dr.width(still))
        result: VehicleState = dr.while_loop((first, state), lambda i, _: i < steps, advance, mode="symbolic")[1]
        return result

    return block


def remus_16384_msteps() -> Measured:
    """16384 REMUS 100."""
    fleet = Fleet("remus100", n=16384, steps=SUBSTEPS, command=[0.05, -0.02, 1300.0])
    return Measured(fleet.n * SUBSTEPS / fleet.timed() * 1e-6, detail=f"{SUBSTEPS} steps a call, uniform current")


def bluerov2_4096_msteps() -> Measured:
    """4096 BlueROV2 Heavy under water: their vertical thrusters together neither lift nor push down."""
    command = [0.3, 0.2, 0.25, 0.3, 0.1, -0.1, 0.2, -0.2]
    fleet = Fleet("bluerov2_heavy", n=4096, steps=SUBSTEPS, command=command)
    took = fleet.timed()
    must(bool((fleet.depths() > 2.0).all()), "a vehicle is at the surface")
    return Measured(fleet.n * SUBSTEPS / took * 1e-6, detail=f"{SUBSTEPS} steps a call, uniform current, submerged")


def bluerov2_4096_awash_msteps() -> Measured:
    """4096 BlueROV2 Heavy, each awash: they rise until their thrusters draw air."""
    command = [0.3, 0.2, 0.25, 0.3, 0.3, 0.3, 0.3, 0.3]
    fleet = Fleet("bluerov2_heavy", n=4096, steps=SUBSTEPS, command=command)
    for _ in range(RISING):
        fleet.block()
    took = fleet.timed()
    must(bool((np.abs(fleet.depths()) < 0.5).all()), "a vehicle is not at the surface")
    return Measured(fleet.n * SUBSTEPS / took * 1e-6, detail=f"{SUBSTEPS} steps a call, uniform current, awash")


def _one_s(ticks: int) -> float:
    """Time of a call of the simulator's own step loop with one REMUS 100, the motion of every tick kept [s]."""
    fleet = Fleet("remus100", n=1, steps=1, command=[0.05, -0.02, 1300.0])
    driver = Driver(fleet.vehicle, n=1, dt_ns=round(H_S * 1e9))
    state, tick = driver.pack(fleet.state), 0

    def call() -> None:
        nonlocal state, tick
        state, _ = driver.advance(state, fleet.command, fleet.ocean, mode="actuators", tick=tick, ticks=ticks)
        tick += ticks
        dr.sync_thread()

    took = seconds(call, at_least_s=2.0)
    way = driver.unpack(state).position.numpy() - fleet.state.position.numpy()
    must(bool(np.isfinite(way).all()) and float(np.abs(way).max()) > 1.0, "the vehicle does not move as it should")
    return took


def vehicle_1_us() -> Measured:
    """One REMUS 100, a call a step."""
    return Measured(_one_s(1) * 1e6, detail="the simulator's step loop, motion kept")


def vehicle_1_substeps_us() -> Measured:
    """One REMUS 100, twenty steps a call."""
    return Measured(_one_s(SUBSTEPS) / SUBSTEPS * 1e6, detail=f"{SUBSTEPS} steps a call, the motion of each kept")


CASES: Final = (
    Case(
        name="remus_16384_msteps",
        title="16384 REMUS 100, full model in float64",
        measure=remus_16384_msteps,
        unit="M vehicle-steps/s",
        goal=100.0,
        better="higher",
        reference=OCEANSCALE,
    ),
    Case(
        name="bluerov2_4096_msteps",
        title="4096 BlueROV2 Heavy under water: eight T200 tables, lag, battery, current",
        measure=bluerov2_4096_msteps,
        unit="M vehicle-steps/s",
        goal=60.0,
        better="higher",
        reference=OCEANSCALE,
    ),
    Case(
        name="bluerov2_4096_awash_msteps",
        title="The same at the surface: buoyancy, drag, added mass and thrust by immersion",
        measure=bluerov2_4096_awash_msteps,
        unit="M vehicle-steps/s",
        goal=15.0,
        better="higher",
        reference=OCEANSCALE,
    ),
    Case(
        name="vehicle_1_us",
        title="One REMUS 100, one step a call",
        measure=vehicle_1_us,
        unit="us",
        goal=30.0,
        better="lower",
        reference=Reference("Fossen's Python Vehicle Simulator, a step", 1 / FOSSEN.value if FOSSEN.value else None),
    ),
    Case(
        name="vehicle_1_substeps_us",
        title="One REMUS 100, a step of a call of twenty",
        measure=vehicle_1_substeps_us,
        unit="us",
        goal=5.0,
        better="lower",
        reference=Reference("Fossen's Python Vehicle Simulator, a step", 1 / FOSSEN.value if FOSSEN.value else None),
    ),
)
