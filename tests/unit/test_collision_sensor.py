"""The collision sensor: silent in open water, true while a hull touches, and through the whole of its period."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.messages.encoders import encoder
from pelagos.messages.encoding import Site
from pelagos.sensors.navigation.collision import CollisionConfig


def sinking(rate_hz: float, *, n: int = 1, **sensor: Any) -> pl.Simulation:
    """A heavy ROV 1 m over the ground, without drive."""
    return pl.Simulation.load(
        {
            "seed": 3,
            "world": {"type": "flat", "depth_m": 10.0},
            "agents": {
                "rov": {
                    "vehicle": "bluerov2",
                    "start": {"position_m": [0.0, 0.0], "depth_m": 8.5},
                    "control": "wrench",
                    "sensors": {"bump": {"type": "collision", "rate_hz": rate_hz, **sensor}},
                }
            },
        },
        n=n,
    )


def readings(sim: pl.Simulation, ticks: int, dive: float) -> list[pl.Reading]:
    found, obs = [], sim.reset()
    command = np.zeros((sim.n, 6))
    command[:, 2] = 100 * dive  # [N], FRD: down
    for _ in range(ticks):
        obs = sim.step({"rov": command})
        found += [obs["rov"]["bump"]] if "bump" in obs["rov"] else []
    return found


def test_it_is_silent_until_the_hull_touches_the_ground_and_says_how_hard():
    sim = sinking(50.0)
    first, *_ = found = readings(sim, 1600, dive=0.6)
    assert first.data.shape == (1, 1)
    assert first.data.dtype == bool
    touched = np.array([bool(r.data[0, 0]) for r in found])
    assert not touched[:5].any()
    assert touched.any()
    begin = int(touched.argmax())
    force = np.array([r.extras["force"][0] for r in found])
    assert (force[:begin] == 0).all()
    assert force[touched][:, 2].max() > 1.0  # upwards, body FLU
    assert (np.linalg.norm(force[touched], axis=1) > 0).all()


def test_where_a_vehicle_was_free_is_remembered_and_nothing_else():
    """The step loop looks at the world's map once for many ticks; it must find what a look at every tick finds."""
    sim = sinking(50.0)
    contacts, looks, near = sim.stepper.contacts, [], sim.world.near
    counted: Any = SimpleNamespace(near=lambda *asked: looks.append(asked) or near(*asked))
    contacts._model = SimpleNamespace(world=counted)
    rng = np.random.Generator(np.random.PCG64(7))
    place, found = np.array([[1.0, -2.0, -5.0]]), []
    for k in range(3000):
        place = place + rng.normal(0.0, 0.02, (1, 3))
        if k % 500 == 499:  # set anew, from outside
            place = rng.uniform([-30.0, -30.0, -10.5], [30.0, 30.0, -1.0], (1, 3))
        reach = np.array([rng.uniform(0.4, 0.7)])
        found.append(contacts._grounds("rov", place, reach))
        assert found[-1] == bool(near(place, reach)[0])
    assert {True, False} == set(found)
    assert len(looks) < sum(found) + 0.2 * len(found)
    assert contacts._grounds("rov", np.full((1, 3), np.nan), np.ones(1))


def test_a_slow_sensor_misses_no_blow():
    """Whatever a sensor of every tick has felt in its period, one of 5 Hz says too."""
    fast, slow = (readings(sinking(rate), 1600, dive=0.6) for rate in (200.0, 5.0))
    felt = {r.t_ns: bool(r.data[0, 0]) for r in fast}
    assert any(felt.values())
    assert not all(felt.values())
    for reading in slow:
        since = [hit for t, hit in felt.items() if reading.t_ns - 200_000_000 < t <= reading.t_ns]
        assert bool(reading.data[0, 0]) == any(since)


def test_weak_contacts_may_not_count():
    strong = readings(sinking(50.0, least_force_n=1e6), 1200, dive=0.6)
    assert not any(r.data.any() for r in strong)


def test_every_copy_has_its_own():
    found = readings(sinking(50.0, n=3), 200, dive=0.6)
    assert found[-1].data.shape == (3, 1)


def test_its_message_is_a_wrench():
    made = encoder(CollisionConfig(), Site("rov/bump", 0.0, 0.0))
    assert [t.type for t in made.topics] == ["geometry_msgs/msg/WrenchStamped"]


def test_least_force_is_not_negative():
    with pytest.raises(ValueError, match="least_force_n"):
        CollisionConfig(least_force_n=-1)
