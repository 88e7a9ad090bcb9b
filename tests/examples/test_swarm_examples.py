"""Examples of swarms run: every member moves, and readings of all come together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pelagos as pl

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(
    ("name", "group", "count"),
    [
        ("swarm_200", "auv", 200),
        pytest.param("race_100_wamv", "boat", 100, marks=pytest.mark.slow),
        pytest.param("harbour_traffic", "line", 16, marks=pytest.mark.slow),
    ],
)
def test_examples_of_swarms_run(name, group, count):
    sim = pl.Simulation.load(EXAMPLES / f"{name}.yaml")
    before = sim.state[group].position
    obs = sim.step(ticks=5)
    assert obs[group]["imu"].data.shape == (1, count, 6)
    moved = np.linalg.norm(sim.state[group].position - before, axis=-1)
    assert np.isfinite(moved).all()
    assert (moved > 0.0).all()
