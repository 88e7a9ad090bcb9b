"""Same bytes of every sensor with a second vehicle, a prop and a mover in view: copies, threads, blocks, processes."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from test_every_sensor import SMALL

import pelagos as pl
from pelagos.config import registry

Digests: TypeAlias = dict[str, str]
TICKS = 40
NAMES = sorted(registry.entries("sensor", plugins=False))
VARIED = {  # else no copy could be taken for another
    "agents.auv0.start.position_m.0": {"uniform": [-0.6, 0.6]},
    "agents.auv0.start.position_m.1": {"uniform": [-0.6, 0.6]},
    "agents.auv0.start.position_m.2": {"uniform": [-3.3, -2.7]},
    "agents.auv0.start.heading_deg": {"uniform": [25.0, 55.0]},
    "agents.auv1.start.position_m.0": {"uniform": [3.5, 4.5]},
    "ocean.current_mps.0": {"uniform": [-0.2, 0.2]},
    "ocean.current_mps.1": {"uniform": [-0.2, 0.2]},
}
TRACERS = {"chlorophyll": 2.0, "oxygen": 240.0, "turbidity": 1.5}
QUICK = {"bit_rate_bps": 9000.0, "preamble_s": 0.005}  # packets end within the run
MOVES = {"kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, 2.0, -3.5]], "speed_mps": 0.5}


def falling(value: float) -> dict[str, Any]:
    """By a third from the surface to the ground."""
    return {"depth_m": [0.0, 8.0], "value": [value, 0.67 * value]}


def scenario() -> dict[str, Any]:
    sensors = {
        name: {"type": name, "rate_hz": 10, "position_m": [0.3, 0.0, 0.3], **SMALL.get(name, {})} for name in NAMES
    }
    sensors["modem"] |= QUICK
    sensors["range_finder"] |= {"elevation_deg": [-40.0], "azimuth_deg": [20.0]}
    for kind, key in (("lbl", "transponders"), ("range_bearing", "targets")):
        sensors[kind] |= {key: {**sensors[kind][key], "carried": {"agent": "auv1", "position_m": [0.1, 0.0, 0.1]}}}
    return {
        "seed": 11,
        "tick_rate_hz": 100,
        "vary": VARIED,
        "world": {
            "type": "flat",
            "depth_m": 8.0,
            "things": [{"shape": "box", "at_m": [6.0, 3.0, -6.0], "size_m": [2.0, 1.0, 3.0]}],
            "movers": [{"name": "drum", "body": "cylinder", "size_m": 1.0, "path": MOVES}],
        },
        "ocean": {"tracers": {n: falling(v) for n, v in TRACERS.items()}},
        "agents": {
            "auv0": {
                "vehicle": "remus100",
                "start": {"position_m": [0.0, 0.0, -3.0], "heading_deg": 40.0},
                "control": "depth_heading",
                "command": [4.0, 0.9, 700.0],
                "sensors": sensors,
            },
            "auv1": {
                "vehicle": "remus100",
                "start": {"position_m": [4.0, -3.0], "depth_m": 3.5, "heading_deg": 80.0},
                "control": "depth_heading",
                "command": [4.0, 0.9, 700.0],
                "sensors": {
                    "modem": {"type": "modem", "rate_hz": 20, "position_m": [0.2, 0.0, 0.2], **QUICK},
                    "optical_modem": {"type": "optical_modem", "rate_hz": 20, "orientation_deg": [0, 0, 180]},
                },
            },
        },
    }


def simulation(**options: Any) -> pl.Simulation:
    sim = pl.Simulation.load(scenario(), **options)
    sim.reset()
    sphere = sim.spawn(pl.Prop("sphere", position=(5.0, 1.0, -4.0), size=(0.8, 0.8, 0.8), material="steel"))
    sphere.move(position=[(5.0, 1.0 + 0.1 * (sim.model.first_environment + k), -4.0) for k in range(sim.n)])
    for modem in ("modem", "optical_modem"):
        sim.send("auv1", modem, b"here")
    return sim


def followed(sim: pl.Simulation, copies: Sequence[int] = (0,)) -> tuple[list[Digests], dict[str, pl.Reading]]:
    """A digest of everything that each sensor said of each of some copies, tick by tick; and the last readings."""
    digests = [{name: hashlib.blake2b(digest_size=8) for name in NAMES} for _ in copies]
    newest: dict[str, pl.Reading] = {}
    for _ in range(TICKS):
        readings = sim.step()["auv0"]
        newest |= readings
        for (name, reading), (copy, kept) in itertools.product(readings.items(), zip(copies, digests, strict=True)):
            if reading.valid[copy]:
                kept[name].update(reading.t_ns.to_bytes(8, "little"))
                fixed = [v for v in reading.extras.values() if len(v) != sim.n]  # the same for every copy
                own = [v[copy] for v in reading.extras.values() if len(v) == sim.n]
                for values in (reading.data[copy], reading.truth[copy], *own, *fixed):
                    words = isinstance(values, tuple)  # of packets
                    kept[name].update(repr(values).encode() if words else np.ascontiguousarray(values).tobytes())
    return [{name: d.hexdigest() for name, d in kept.items()} for kept in digests], newest


def stepped(sim: pl.Simulation) -> Digests:
    """Of the first copy alone."""
    return followed(sim)[0][0]


def elsewhere(**environment: str) -> Digests:
    """The same in another process."""
    program = (
        "import json, sys; sys.path.insert(0, sys.argv[1]); import test_every_sensor_in_company as t; "
        "print(json.dumps(t.stepped(t.simulation())))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, os.path.dirname(__file__)],
        env={**os.environ, **environment}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found: Digests = json.loads(done.stdout)
    return found


def differing(one: Digests, other: Digests) -> list[str]:
    return [name for name in NAMES if one[name] != other[name]]


@pytest.fixture(scope="module")
def single() -> tuple[Digests, dict[str, pl.Reading]]:
    digests, newest = followed(simulation())
    return digests[0], newest


@pytest.fixture(scope="module")
def alone(single: tuple[Digests, dict[str, pl.Reading]]) -> Digests:
    return single[0]


def test_copies_are_environments_of_their_own(alone: Digests) -> None:
    fleet, _ = followed(simulation(n=6), (0, 5))
    assert differing(fleet[0], alone) == []
    assert differing(fleet[1], stepped(simulation(environment=5))) == []


@pytest.mark.parametrize("threads", ["1", *(pytest.param(n, marks=pytest.mark.slow) for n in ("2", "4"))])
def test_threads_and_processes(alone: Digests, threads: str) -> None:
    assert differing(elsewhere(PELAGOS_THREADS=threads), alone) == []


@pytest.mark.slow
def test_cold_caches_change_nothing(alone: Digests, tmp_path: Path) -> None:
    for _ in range(2):  # cold, then warm
        assert differing(elsewhere(HOME=str(tmp_path)), alone) == []
    assert any(tmp_path.rglob("*.bin")) or any((tmp_path / ".drjit").iterdir())


def test_blocks_are_ticks(single: tuple[Digests, dict[str, pl.Reading]]) -> None:
    other, newest = simulation(), single[1]
    ran = other.run(TICKS * other.dt_ns * 1e-9).observations["auv0"]
    assert set(ran) == set(newest)
    for name, reading in newest.items():
        assert reading.t_ns == ran[name].t_ns
        assert reading.data.tobytes() == ran[name].data.tobytes(), name
        assert reading.truth.tobytes() == ran[name].truth.tobytes(), name


def test_looking_between_readings_changes_none(alone: Digests) -> None:
    """Looked at on every third tick: within ten of them, at each distance from a reading."""
    sim = simulation()
    step = sim.step
    look = lambda: sim.read("auv0") if sim.time_ns // sim.dt_ns % 3 == 0 else None
    sim.step = lambda: (look(), step())[1]  # type: ignore[method-assign]
    assert differing(stepped(sim), alone) == []
