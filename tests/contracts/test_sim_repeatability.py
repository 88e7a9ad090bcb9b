"""Same seed, same bytes: alone or in a fleet, tick by tick or in blocks, on one thread or two, in another process."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import pelagos as pl

SENSORS = {
    "imu": {"type": "imu", "rate_hz": 200},
    "dvl": {"type": "dvl", "rate_hz": 10},
    "depth": {"type": "depth", "rate_hz": 50},
    "gps": {"type": "gps", "rate_hz": 5},
    "magnetometer": {"type": "magnetometer", "rate_hz": 20},
    "altimeter": {"type": "altimeter", "rate_hz": 10},
    "multibeam": {"type": "multibeam", "rate_hz": 5, "beams": 64},
    "imaging": {"type": "imaging_sonar", "rate_hz": 5, "beams": 32, "bins": 64},
    "camera": {"type": "camera", "rate_hz": 2, "width_px": 48, "height_px": 32},
}
SCENARIO = {
    "seed": 3,
    "world": {"type": "flat", "depth_m": 12.0},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 4.0, "heading_deg": 30.0, "speed_mps": 1.2},
            "control": "depth_heading",
            "command": [6.0, 0.9, 900.0],
            "sensors": SENSORS,
        }
    },
}


def readings_of(sim: pl.Simulation, ticks: int, copy: int = 0) -> dict[str, str]:
    """A digest of everything that each sensor said of one copy, tick by tick."""
    digests = {name: hashlib.blake2b(digest_size=8) for name in SENSORS}
    obs = sim.reset()
    for _ in range(ticks + 1):
        for name, reading in obs["auv0"].items():
            if reading.valid[copy]:
                digests[name].update(reading.t_ns.to_bytes(8, "little"))
                digests[name].update(np.ascontiguousarray(reading.data[copy]).tobytes())
                digests[name].update(np.ascontiguousarray(reading.truth[copy]).tobytes())
        obs = sim.step()
    digests["state"] = hashlib.blake2b(sim.state["auv0"].position[copy].tobytes(), digest_size=8)
    return {name: d.hexdigest() for name, d in digests.items()}


@pytest.fixture(scope="module")
def alone() -> dict[str, str]:
    return readings_of(pl.Simulation.load(SCENARIO), 120)


def test_every_copy_of_a_fleet_equals_a_fleet_of_one(alone):
    fleet = pl.Simulation.load(SCENARIO, n=20)  # more than a packet of lanes, and not whole packets
    assert readings_of(fleet, 120) == alone
    assert readings_of(fleet, 120, copy=5) == readings_of(pl.Simulation.load(SCENARIO, environment=5), 120)


def test_copies_have_noise_of_their_own():
    sim = pl.Simulation.load(SCENARIO, n=4)
    imu = sim.step()["auv0"]["imu"]
    assert len({row.tobytes() for row in imu.data}) == 4
    assert len({row.tobytes() for row in imu.truth}) == 1


def test_another_seed_gives_other_noise_and_the_same_truth(alone):
    other = readings_of(pl.Simulation.load(SCENARIO, seed=4), 120)
    assert other["state"] == alone["state"]
    assert all(other[name] != alone[name] for name in SENSORS if name != "gps")


def test_reset_repeats_and_reseeds(alone):
    sim = pl.Simulation.load(SCENARIO, seed=4)
    sim.run(0.3)
    sim.reset(seed=3)
    assert readings_of(sim, 120) == alone


def test_blocks_equal_single_ticks():
    """`run` goes in blocks of up to a second; its last readings and states are those of `step`."""
    stepped, ran = pl.Simulation.load(SCENARIO), pl.Simulation.load(SCENARIO)
    for _ in range(120):
        stepped.step()
    result = ran.run(0.6)
    obs = stepped.stepper.read_now()
    assert ran.time_ns == stepped.time_ns
    for name in ("position", "attitude", "velocity", "angular_velocity", "acceleration", "actuators"):
        assert getattr(ran.state["auv0"], name).tobytes() == getattr(stepped.state["auv0"], name).tobytes()
    for one in obs:
        reading = one.newest(1, ran.dt_ns)
        if reading is not None:
            same = result.observations["auv0"][one.model.name]
            assert same.t_ns == reading.t_ns
            assert same.data.tobytes() == reading.data.tobytes(), one.model.name


def test_sensors_that_wait_read_the_same_bytes():
    """Readings of many blocks in one call, as `run` asks for them, and block by block."""
    found = []
    for wait in (False, True):
        stepper = pl.Simulation.load(SCENARIO).stepper
        read = {name: (bytearray(), bytearray()) for name in SENSORS}
        while stepper.tick < 240:
            sampled = stepper.advance(240, wait=wait)
            for one in sampled + (stepper.catch_up() if stepper.tick % 120 == 0 else []):
                ticks, data = read[one.model.name]
                ticks += np.array(one.ticks).tobytes()
                data += np.ascontiguousarray(one.measurement.data).tobytes()
        found.append(read)
    assert found[0] == found[1]


@pytest.mark.parametrize("threads", [pytest.param("1", marks=pytest.mark.slow), "2"])
def test_other_processes_and_numbers_of_threads(alone, threads):
    program = (
        "import json, sys; sys.path.insert(0, sys.argv[1]); import pelagos as pl; import test_sim_repeatability as t; "
        "print(json.dumps(t.readings_of(pl.Simulation.load(t.SCENARIO), 120)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, os.path.dirname(__file__)],
        env={**os.environ, "PELAGOS_THREADS": threads}, capture_output=True, text=True, check=True)  # fmt: skip
    assert json.loads(done.stdout) == alone
