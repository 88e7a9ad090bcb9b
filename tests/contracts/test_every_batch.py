"""Agents that are moved and asked in one call give the bytes of agents alone: every sensor and vehicle there is."""

from __future__ import annotations

from typing import Any

import pytest
from tests.contracts.test_every_checkpoint import AFLOAT, IN_AIR, digest, sensors

import pelagos as pl
from cases import KIN, slow
from pelagos.config import registry
from pelagos.sim import model as sim_model
from pelagos.vehicles.load import catalogue_names

SENSORS = sorted(registry.entries("sensor", plugins=False))
SHIPS = AFLOAT - {"otter", "wamv", "surface_vessel"}
DEEP = {"kvlcc2", "tanker", "semisub"}


def _fleet(vehicle: str, carried: dict[str, Any], count: int = 3) -> dict[str, Any]:
    apart = 100.0 if vehicle in SHIPS else 1.0  # ships that overlap push one another, as rays of their hulls find them
    depth = -6.0 if vehicle in IN_AIR else 0.0 if vehicle in AFLOAT else 3.0
    agents = {
        f"a{i}": {
            "vehicle": vehicle,
            "start": {
                "position_m": [4.0 * apart * i, -9.0 * apart * i, -depth - 0.3 * i],
                "heading_deg": 25.0 * i,
                "speed_mps": 0.4,
            },
            "sensors": carried,
        }
        for i in range(count)
    }
    ocean = {"tracers": {"chlorophyll": 2.0, "oxygen": 240.0, "turbidity": 1.5}}
    return {
        "seed": 5,
        "tick_rate_hz": 100,
        "world": {"type": "flat", "depth_m": 30.0 if vehicle in DEEP else 12.0},  # they draw up to 21 m
        "ocean": ocean,
        "agents": agents,
        "vary": {  # else no copy could be taken for another
            **{f"agents.a{i}.start.heading_deg": {"uniform": [25.0 * i - 9.0, 25.0 * i + 9.0]} for i in range(count)},
            **{f"agents.a{i}.start.position_m.0": {"normal": [4.0 * apart * i, 0.1]} for i in range(count)},
        },
    }


def _trace(scenario: dict[str, Any], ticks: int, n: int) -> list[Any]:
    sim = pl.Simulation.load(scenario, n=n)
    found: list[Any] = []
    for _ in range(ticks):
        obs = sim.step()
        for name, readings in obs.items():
            found.append((name, *((sensor, digest({sensor: reading})) for sensor, reading in readings.items())))
    for name, state in sim.state.items():
        found.append((name, *(values.tobytes() for values in vars(state).values())))
    return found


def _equal(scenario: dict[str, Any], monkeypatch: pytest.MonkeyPatch, *, ticks: int, n: int) -> None:
    together = _trace(scenario, ticks, n)
    monkeypatch.setattr(sim_model, "alike", lambda members, modes: [[name] for name in members])
    alone = _trace(scenario, ticks, n)
    for one, other in zip(together, alone, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a == b


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.filterwarnings("ignore::pelagos.errors.MountWarning")
def test_every_sensor_reads_for_many_as_for_one(monkeypatch):
    """Every sensor of the registry that can, three vehicles in two copies that see one another."""
    carried = sensors()
    assert set(carried) == set(SENSORS)
    single = {name for name in SENSORS if getattr(registry.find("sensor", name).load(), "ONE_VEHICLE", False)}
    assert len(single) <= 6
    fleet = _fleet("remus100", {name: config for name, config in carried.items() if name not in single})
    assert [len(b.members) for b in pl.Simulation.load(fleet).model.batches.values()] == [3]
    _equal(fleet, monkeypatch, ticks=10, n=2)


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.parametrize("vehicle", [slow(n) if n in KIN else n for n in catalogue_names()])
def test_every_vehicle_moves_among_many_as_alone(vehicle, monkeypatch):
    _equal(_fleet(vehicle, {"imu": {"type": "imu", "rate_hz": 50}}), monkeypatch, ticks=20, n=2)
