"""A ship over streamed ground: no beam is lost, and the bytes are the same block by block, tick by tick, and again."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.sim.simulation import Simulation

SCENARIO = {
    "seed": 2,
    "tick_rate_hz": 5,
    "world": {
        "type": "large",
        "size_m": [20_000, 20_000],
        "ground": {"kind": "fractal", "seed": 7, "mean_depth_m": 150, "relief_m": 20, "longest_m": 4000},
        "insets": [{"centre_m": [-2500, 0], "size_m": [300, 300], "resolution_m": 0.6}],
        "memory_mb": 600,
    },
    "agents": {
        "ship": {
            "vehicle": "mariner",
            "control": "heading",
            "command": [0.0],
            "start": {"position_m": [-2740, 30, 0], "heading_deg": 0, "speed_mps": 7.7},
            "sensors": {
                "multibeam": {
                    "type": "multibeam", "rate_hz": 0.2, "beams": 32, "range_max_m": 900, "frequency_hz": 70_000,
                    "bandwidth_hz": 2000, "pulse_s": 0.002, "source_level_db": 225, "position_m": [0, 0, -8],
                },
                "dvl": {"type": "dvl", "rate_hz": 1, "position_m": [0, 0, -8]},
            },
        }
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def sim():
    return Simulation.load(SCENARIO)


def _pings(sim, ticks, *, block):
    """Multibeam and DVL until a tick, in blocks or tick by tick, and how often the ground was exchanged."""
    views, found = [], {"multibeam": [], "dvl": []}
    while sim.stepper.tick < ticks:
        for one in sim.stepper.advance(ticks if block else sim.stepper.tick + 1):
            found[one.model.name].append(np.asarray(one.measurement.data))
        view = sim.model.scene._ground.view
        if not views or views[-1] is not view:
            views.append(view)
    return {name: np.concatenate(parts) for name, parts in found.items()}, len(views)


def test_no_beam_is_lost_and_the_bytes_are_the_same_in_any_blocks_again_and_from_a_checkpoint(sim):
    sim.reset()
    once, exchanges = _pings(sim, 100, block=True)
    assert exchanges >= 3
    assert np.isfinite(once["multibeam"]).all()
    sim.world.cast([8000.0, 8000.0, 0.0], (0, 0, -1), 1000.0)  # somebody looks elsewhere
    sim.reset()
    first, _ = _pings(sim, 50, block=False)
    kept = sim.checkpoint()
    _pings(sim, 80, block=False)
    sim.restore(kept)
    rest, _ = _pings(sim, 100, block=False)
    for name in once:
        assert once[name].tobytes() == np.concatenate([first[name], rest[name]]).tobytes(), name
