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
from pelagos.sim.contacts import _wrench
from pelagos.sim.trajectory import CHANNELS


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
    first, *_ = found = readings(sim, 600, dive=0.6)
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
    fast, slow = (readings(sinking(rate), 600, dive=0.6) for rate in (200.0, 5.0))
    felt = {r.t_ns: bool(r.data[0, 0]) for r in fast}
    assert any(felt.values())
    assert not all(felt.values())
    for reading in slow:
        since = [hit for t, hit in felt.items() if reading.t_ns - 200_000_000 < t <= reading.t_ns]
        assert bool(reading.data[0, 0]) == any(since)


def pair_of_three_copies() -> tuple[Any, str]:
    """Contacts of two vehicles in one batch, and its name: rows are the first's three copies, then the second's."""
    agents = {
        name: {"vehicle": "bluerov2", "control": "wrench", "start": {"position_m": [0.0, y], "depth_m": 4.0},
               "sensors": {"bump": {"type": "collision"}}}
        for name, y in (("a", 0.0), ("b", 5.0))
    }  # fmt: skip
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 10.0}, "agents": agents}, n=3)
    (name,) = sim.model.batches
    return sim.stepper.contacts, name


@pytest.mark.parametrize("copy", [0, 1, 2])
def test_a_copy_that_begins_anew_forgets_the_contacts_of_all_its_members(copy: int):
    touching, name = pair_of_three_copies()
    numbers = np.arange(1.0, 37.0).reshape(6, 6)
    touching._now[name] = _wrench(numbers)
    touching.remembered[name] = [(3, numbers + 100), (4, numbers + 200)]
    touching.forget(np.arange(3) == copy)
    stays = np.arange(6) % 3 != copy
    flipped = numbers * [1, -1, -1, 1, -1, -1]
    np.testing.assert_array_equal(touching.wrench(name), flipped * stays[:, None])
    assert [tick for tick, _ in touching.remembered[name]] == [3, 4]
    for (_, kept), more in zip(touching.remembered[name], (100, 200), strict=True):
        np.testing.assert_array_equal(kept, (numbers + more) * stays[:, None])


def test_of_the_contacts_after_a_tick_the_one_of_the_greatest_force_is_told():
    """By row; a larger moment counts nothing, nor does what came before or at that tick."""
    touching, name = pair_of_three_copies()
    steps = np.zeros((4, 6, 6))
    for row in range(6):
        steps[:, row, 1] = -np.roll([9.0, 1.0, 5.0, 3.0], row)  # [N]
        steps[:, row, 4] = np.roll([1.0, 80.0, 2.0, 3.0], row)  # [N m]
    touching.remembered[name] = list(zip((10, 11, 12, 13), steps, strict=True))
    for after, first in ((9, 0), (10, 1), (12, 3)):
        largest = first + np.abs(steps[first:, :, 1]).argmax(axis=0)
        np.testing.assert_array_equal(touching.strongest(name, after), steps[largest, np.arange(6)])
    assert (touching.strongest(name, 13) == 0).all()


def test_what_touches_the_ground_and_another_feels_both():
    touching, name = pair_of_three_copies()
    ground, hit = np.random.default_rng(3).normal(size=(2, 6, 6))
    still: Any = None
    touching._touch = {name: SimpleNamespace(wrench=lambda now, free: _wrench(ground))}
    for more in (ground + hit, ground):
        meets = [(name, hit)] if more is not ground else []
        touching._collisions = SimpleNamespace(any=True, wrenches=lambda rows, free, grounds, m=meets: m)
        felt = touching.act({}, {name: (still, still)})
        assert pytest.approx(more) == np.concatenate([np.array(part) for part in felt[name]]).T


def test_contacts_of_a_second_are_kept():
    touching, name = pair_of_three_copies()
    second = round(1e9 / touching._model.clock.dt_ns)
    for tick in range(3 * second):
        touching._now.clear()
        if tick % 7:
            touching._now[name] = _wrench(np.full((6, 6), float(tick)))
        touching.remember(name, tick)
    kept = touching.remembered[name]
    asked = [t for t in range(2 * second, 3 * second + 1) if (t - 1) % 7]
    assert [tick for tick, _ in kept if tick >= 2 * second] == asked
    assert kept[0][0] >= 2 * second - 1
    assert all((wrench[:, 0] == tick - 1).all() for tick, wrench in kept)


@pytest.mark.parametrize("rows", [1, 3])
def test_what_a_hull_may_touch_within_some_ticks(rows: int):
    """Its radius, 5 cm, and the way at its speed and 2 m/s more; of one vehicle and of many."""
    touching, name = pair_of_three_copies()
    row = np.random.default_rng(8).normal(size=(rows, CHANNELS))
    row[:, 7:10] = ([[2.0, -3.0, 6.0], [0.0, 0.0, -0.5], [-1.0, 2.0, -2.0]])[:rows]
    radius = touching._model.batches[name].vehicle.bounding_radius_m
    elapsed = 8 * touching._model.clock.dt_ns * 1e-9
    expected = radius + 0.05 + (np.array([7.0, 0.5, 3.0])[:rows] + 2.0) * elapsed
    assert touching._reach(name, row, 8) == pytest.approx(expected, rel=1e-12)


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
