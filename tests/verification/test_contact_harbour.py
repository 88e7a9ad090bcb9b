"""A hundred vehicles thrown about in the harbour: none ends inside anything, none explodes."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl

THROWS, SPEED_MPS, SECONDS = 100, 3.0, 3.0
SCENARIO = {
    "tick_rate_hz": 200,
    "world": {"type": "harbour"},
    "agents": {
        "auv0": {"vehicle": "remus100", "start": {"position_m": [-60.0, 40.0], "depth_m": 4.0}, "control": "actuators"}
    },
}


def random_places(world: pl.World, count: int, generator: np.random.Generator) -> np.ndarray:
    """Free places all over the harbour, most of them near the pier, the wreck and the pipeline."""
    low, high = world.bounds
    found = []
    while len(found) < count:
        x, y = generator.uniform(low[:2] + 2, high[:2] - 2)
        bottom = float(np.ravel(world.height(x, y))[0])
        place = np.array([x, y, generator.uniform(bottom + 1.0, -1.0)])
        if bottom < -3.0 and world.inside(place, 1.0) is None:
            found.append(place)
    return np.array(found)


@pytest.fixture(scope="module")
def thrown() -> tuple[pl.Simulation, np.ndarray]:
    sim = pl.Simulation.load(SCENARIO, n=THROWS)
    generator = np.random.default_rng(20)
    velocity = generator.normal(size=(THROWS, 3))
    velocity *= SPEED_MPS * generator.uniform(0.2, 1, (THROWS, 1)) / np.linalg.norm(velocity, axis=1, keepdims=True)
    sim.set_state(
        "auv0",
        position=random_places(sim.world, THROWS, generator),
        attitude=generator.normal(size=(THROWS, 4)),
        velocity=velocity,
    )
    sim.command(
        {"auv0": np.column_stack([generator.uniform(-0.2, 0.2, (THROWS, 2)), generator.uniform(0, 1500, THROWS)])}
    )
    fastest = 0.0
    for _ in range(round(SECONDS * 5)):
        sim.run(0.2)
        fastest = max(fastest, float(np.linalg.norm(sim.state["auv0"].velocity, axis=1).max()))
    return sim, np.array(fastest)


def test_none_ends_inside_anything(thrown):
    sim, _ = thrown
    state = sim.state["auv0"]
    w, x, y, z = state.attitude.T
    ahead = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=-1)
    wrong = []
    for along in (-0.6, 0.0, 0.6):
        places = state.position + along * ahead
        under = places[:, 2] < 0
        wrong += [(i, why) for i in np.flatnonzero(under) if (why := sim.world.inside(places[i], 0.02)) is not None]
    assert not wrong, wrong


def test_none_explodes(thrown):
    """A throw, and 1500 rpm, give at most 3 m/s; a bounce must not add to it."""
    assert thrown[1] < SPEED_MPS * 1.1
