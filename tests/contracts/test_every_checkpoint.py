"""A run that goes on and one that is restored are the same bytes: every vehicle, every sensor of the registry."""

from __future__ import annotations

import hashlib
import pickle
from typing import Any

import numpy as np
import pytest
from test_every_sensor import SMALL as USUAL

import pelagos as pl
from cases import KIN, slow
from pelagos.config import registry
from pelagos.vehicles.load import catalogue_names

SMALL: dict[str, dict[str, Any]] = {
    name: {**keys, **({"width_px": 16, "height_px": 16} if "width_px" in keys else {})} for name, keys in USUAL.items()
} | {"range_finder": {"azimuth_deg": [0.0, 35.0, -50.0], "elevation_deg": [10.0, -20.0, -35.0]}}  # rays and lanes
AFLOAT = {
    "otter", "wamv", "surface_vessel", "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate",
    "zeefakkel", "navalvessel",
}  # fmt: skip
IN_AIR = {"quadrotor", "fixed_wing"}
SHIPS = AFLOAT - {"otter", "wamv", "surface_vessel"}


def digest(readings: dict[str, pl.Reading]) -> dict[str, str]:
    found = {}
    for name, r in readings.items():
        h = hashlib.blake2b(r.t_ns.to_bytes(8, "little"), digest_size=8)
        for values in (r.data, r.truth, r.valid, *(r.extras[k] for k in sorted(r.extras))):
            h.update(np.ascontiguousarray(values).tobytes())
        found[name] = h.hexdigest()
    return found


def trace(sim: pl.Simulation, ticks: int) -> list[Any]:
    """Readings and states of the ticks that follow, which a difference of one bit changes."""
    found: list[Any] = []
    for _ in range(ticks):
        obs = sim.step()
        found.append({agent: digest(readings) for agent, readings in obs.items()})
        for name, state in sim.state.items():
            found.append((name, *(np.asarray(v).tobytes() for v in vars(state).values())))
            found.append(sim.stepper.contact(name).tobytes())
    return found


def sensors() -> dict[str, Any]:
    names = sorted(registry.entries("sensor", plugins=False))
    return {
        name: {"type": name, "rate_hz": 10, "position_m": [0.9, 0.1, -0.2], **SMALL.get(name, {})} for name in names
    }


SCENARIO: dict[str, Any] = {
    "seed": 11,
    "tick_rate_hz": 100,
    "world": {
        "type": "flat",
        "depth_m": 8.0,
        "movers": [
            {
                "name": "boat",
                "body": "box",
                "path": {"kind": "waypoints", "points_m": [[4, 3, -1], [7, 0, -1], [9, -3, -1]], "speed_mps": 2.0},
            }
        ],
    },
    "ocean": {"tracers": {"chlorophyll": 2.0, "oxygen": 240.0, "turbidity": 1.5}},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 3.0, "heading_deg": 40.0, "speed_mps": 1.2},
            "mission": [
                {"type": "waypoints", "points": [[4.0, -4.0], [0.0, 0.0]], "depth_m": 3.5, "speed_mps": 1.3},
                {"type": "hold", "seconds": 5},
            ],
            "sensors": sensors(),
        },
        "rov": {
            "vehicle": "bluerov2",
            "start": {"position_m": [3.0, 1.0], "depth_m": 7.8},
            "sensors": {"touch": {"type": "collision", "rate_hz": 20}},
        },
    },
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")  # of sonars too fast for their rate
@pytest.mark.filterwarnings("ignore::pelagos.errors.MountWarning")
def test_every_sensor_goes_on_from_a_checkpoint():
    """With a second vehicle on the ground, a boat under way, a prop that was moved, and a mission under way."""
    sim = pl.Simulation.load(SCENARIO, n=2)
    box = sim.spawn(pl.Prop("box", position=(3, -1, -4), size=(1, 1, 2)))
    sim.set_mode("rov", "actuators")
    sim.step(ticks=33)
    box.move(position=[(2.5, -1.0, -4.0), (2.6, -1.2, -4.1)], velocity=(0.1, 0.0, 0.0))
    names = sim.model.agents["rov"].vehicle.command_names("actuators")
    sim.step({"rov": np.linspace(-0.4, 0.6, 2 * len(names)).reshape(2, -1)}, ticks=7)
    kept = pickle.loads(pickle.dumps(sim.checkpoint()))
    fork = sim.fork()
    wanted = trace(sim, 24)
    assert any("collision" in str(part) for part in wanted)
    assert trace(fork, 24) == wanted  # its scene was another's in the meantime
    box.remove()
    sim.spawn(pl.Prop("sphere", position=(2, 0, -4)))
    trace(sim, 3)
    sim.restore(kept)
    assert trace(sim, 24) == wanted
    assert [b.name for b in sim.bodies.bodies] == ["boat", "box1"]
    other = pl.Simulation.load(SCENARIO, n=2, seed=12)
    other.restore(kept)
    assert (other.seed, other.time_ns) == (11, kept.time_ns)
    assert trace(other, 24) == wanted


@pytest.mark.parametrize(
    "name",
    [slow(n) if n in SHIPS | set(KIN) else n for n in sorted(catalogue_names())],
)
def test_every_vehicle_goes_on_from_a_checkpoint(name, tmp_path):
    """In each of its control modes, with actuators, integrators and radiated waves that are not at rest."""
    waves = {"waves": {"type": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}}
    scenario = {
        "world": {"type": "flat", "depth_m": 60.0},
        "ocean": {
            "currents": [{"type": "uniform", "speed_mps": 0.3, "towards_deg": 70.0}],
            **(waves if name in AFLOAT else {}),
        },
        "agents": {
            "it": {
                "vehicle": name,
                "start": {"position_m": [0.0, 0.0], "depth_m": 0.0 if name in AFLOAT | IN_AIR else 5.0},
            }
        },
    }
    sim = pl.Simulation.load(scenario, n=2)
    for mode in sim.model.agents["it"].vehicle.modes:
        sim.reset()
        sim.set_mode("it", mode)
        command = np.linspace(0.05, 0.4, 2 * len(sim.model.agents["it"].vehicle.command_names(mode))).reshape(2, -1)
        sim.step({"it": command}, ticks=20)
        kept = sim.checkpoint()
        kept.save(tmp_path / "kept.npz")
        sim.run(0.2)
        wanted = sim.stepper.memory()["runs"]["it"]
        sim.reset()
        sim.restore(pl.Checkpoint.load(tmp_path / "kept.npz"))
        assert sim.stepper.mode("it") == mode
        sim.run(0.2)
        found = sim.stepper.memory()["runs"]["it"]
        assert found["vehicle"].tobytes() == wanted["vehicle"].tobytes(), mode
        assert found["row"].tobytes() == wanted["row"].tobytes(), mode


def test_checkpoints_of_something_else_are_refused(tmp_path):
    base = {
        "world": {"type": "flat"},
        "agents": {"a": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 5}}},
    }
    sim = pl.Simulation.load(base)
    kept = sim.checkpoint()
    with pytest.raises(pl.CommandError, match="2 copies"):
        sim.restore(pl.Simulation.load(base, n=2).checkpoint())
    with pytest.raises(pl.CommandError, match="environment 3"):
        sim.restore(pl.Simulation.load(base, environment=3).checkpoint())
    with pytest.raises(pl.CommandError, match="depth_m: 6"):
        sim.restore(pl.Simulation.load(base, overrides={"agents.a.start.depth_m": 6.0}).checkpoint())
    with pytest.raises(pl.CommandError, match="not dict"):
        sim.restore({})
    with sim.on_tick(lambda s: s.restore(kept)), pytest.raises(pl.CommandError, match="restore was called"):
        sim.step()
    (tmp_path / "text").write_text("no checkpoint")
    for path in (tmp_path / "text", tmp_path / "missing"):
        with pytest.raises(pl.RecordingError, match=path.name):
            pl.Checkpoint.load(path)
    kept.save(tmp_path / "whole")
    damaged = bytearray((tmp_path / "whole").read_bytes())
    damaged[len(damaged) // 2] ^= 0x10
    (tmp_path / "damaged").write_bytes(damaged)
    with pytest.raises(pl.RecordingError, match="damaged"):
        pl.Checkpoint.load(tmp_path / "damaged")
    with pytest.raises(pl.RecordingError, match="cannot be written"):
        kept.save(tmp_path / "no" / "folder")
