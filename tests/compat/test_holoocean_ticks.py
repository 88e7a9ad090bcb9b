"""Ticks of an environment whose simulation is a stand-in: how many steps they are, what counts on, what has changed."""

from types import SimpleNamespace

import numpy as np
import pytest
from holoocean_env import agent

from pelagos.compat.holoocean.convert import _Unbuilt

LOCATION = {"sensor_type": "LocationSensor", "Hz": 20}


class Rows:
    """States of agents by name; a speed ahead of n^2 / 100 after n ticks, of the second agent as much astern."""

    def __init__(self, names, now):
        self.names, self.motion = names, np.zeros((len(names), 32))
        self.motion[:, 0], self.motion[:, 3] = now, 1.0
        self.motion[:, 7] = 0.01 * now**2 * (1 - 2 * np.arange(len(names)))

    def __iter__(self):
        return iter(self.names)


class Stepped:
    """Keeps how far it was asked to go each time."""

    def __init__(self, names):
        self.names, self.steps = names, []
        self.stepper = SimpleNamespace(mode=lambda name: "")
        self.set_mode = lambda name, mode: None
        self.command = lambda commands: None

    def step(self, ticks=1):
        self.steps.append(ticks)
        return {name: {} for name in self.names}

    @property
    def state(self):
        return Rows(self.names, sum(self.steps))


def environment(kind="HoveringAUV", more=(), **keys):
    agents = [agent(kind, [LOCATION]), *more]
    env = _Unbuilt(scenario={"name": "t", "world": "TestWorld", "ticks_per_sec": 60, "agents": agents, **keys}, seed=1)
    env._sim, env._stale, env._flat = Stepped([a.native_name for a in env.agents.values()]), False, not more
    env._agent = env.agents["auv0"]
    return env


def test_many_ticks_are_one_step_but_for_the_last_two():
    """Of which the first is there for the acceleration over the second, and has its own from the step before."""
    env, seen = environment(more=[agent("BlueROV2", name="auv1")]), []
    advance = lambda: seen.append(env.motions["auv0"].acceleration[0])
    env.media = SimpleNamespace(flights=[], beams=[], advance=advance)
    for count, steps, ticks in ((10, [8, 1, 1], 10), (2, [1, 1], 12), (3, [1, 1, 1], 15), (1, [1], 16)):
        env._sim.steps, before = env._sim.steps[:], len(env._sim.steps)
        state = env.tick(count)
        assert env._sim.steps[before:] == steps
        assert (env._num_ticks, env._total_ticks) == (ticks, ticks)
        assert state["t"] == pytest.approx((ticks - 1) / 60)  # of the tick that it shows
        assert env.agents["auv0"].sensors["LocationSensor"].tick_count == ticks % 3
        assert ("LocationSensor" in state["auv0"]) == ((ticks - 1) % 3 == 0)
        gained = 0.01 * (ticks**2 - (ticks - 1) ** 2) * 60
        assert seen[-2:] == pytest.approx([gained - 0.02 * 60, gained])
        assert env.motions["auv0"].acceleration == pytest.approx([gained, 0, 0])
        assert env.motions["auv1"].acceleration == pytest.approx([-gained, 0, 0])


EVENTS = {
    "sound": {"media": SimpleNamespace(flights=[1], beams=[], advance=lambda: None)},
    "light": {"media": SimpleNamespace(flights=[], beams=[1], advance=lambda: None)},
    "messages": {"_lcm": object(), "_publish": lambda state: None},
    "something falls": {"_falling": [1], "_fall": lambda: None},
    "fences": {"_fences": True},
    "the sun": {"time_cycle": SimpleNamespace(active=True), "_cycle": lambda: None},
}


@pytest.mark.parametrize("event", [*EVENTS, "an agent that steps"])
def test_where_something_may_happen_each_tick_is_a_step(event):
    env = environment("SphereAgent" if event not in EVENTS else "HoveringAUV")
    for name, value in EVENTS.get(event, {}).items():
        setattr(env, name, value)
    env.tick(7)
    assert env._sim.steps == [1] * 7
    assert env._num_ticks == 7


def test_physics_goes_on_without_the_clock():
    """Time and the phases of sensors stand; what was not due before is not due."""
    env = environment()
    env.tick(4)
    sensor = env.agents["auv0"].sensors["LocationSensor"]
    assert (env._num_ticks, sensor.tick_count) == (4, 1)
    state = env.tick(5, tick_clock=False)
    assert (env._num_ticks, env._total_ticks, sensor.tick_count, state["t"]) == (4, 9, 1, pytest.approx(4 / 60))
    assert env._sim.steps == [2, 1, 1, *[1] * 5]
    env.tick(2)
    assert (env._num_ticks, env._total_ticks, sensor.tick_count) == (6, 11, 0)
    assert "LocationSensor" in env.tick()
