"""No task tells port from starboard but by its sign: an episode in the mirror earns what the episode earned.

Each copy begins at the image of where it would have begun, in the image of its current and waves, and the task's own
script acts on what it sees there. A wrong sign in a start, an observation, a command, a reward or a script on one side
makes another episode of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from mirrored_sea import EVEN, mirrored

import pelagos as pl
from cases import slow
from pelagos import envs
from pelagos.envs import scripted
from pelagos.envs.draws import Draws
from pelagos.envs.registry import TASKS, has_sensors, make_task
from pelagos.envs.task import Sea, Start, Task
from pelagos.envs.tasks import oceanscale_hover
from pelagos.envs.tasks.gyre import GyreTransect

ODD = {"goal_y", "yaw", "heading", "amplitude"}
"""What tasks keep that is the other way round in the mirror."""
STEPS = 6
AKIN = {"MarineGymHover-v0", "OceanScaleHover-v0", "StationKeeping-v0", "Waypoint-v0"}
"""Tasks that earn as others do, `Hover-v0` among them."""
ONE_WAVE = {"waves": {"type": "regular", "height_m": 0.3, "period_s": 4.0, "towards_deg": 30.0}}
"""In place of a sea, whose waves' directions are drawn, not mirrored."""


def image_of(task: Task) -> Task:
    """The task in the mirror, port for starboard."""
    begins = task.draw

    def draw(random: Draws) -> Start:
        s = begins(random)
        (x, y, z), (w, i, j, k), (u, v, heave), (p, q, r) = s.position, s.attitude, s.velocity, s.angular_velocity
        return Start(
            [x, -y, z], [w, -i, j, -k], [u, -v, heave], [-p, q, -r],
            {name: -kept if name in ODD else kept for name, kept in s.memory.items()},
            None if s.current is None else [s.current[0], -s.current[1], s.current[2]],
            None if s.sea is None else Sea(s.sea.scale, -s.sea.turn_rad, s.sea.moment_s),
        )  # fmt: skip

    task.draw = draw  # type: ignore[method-assign]
    task.ocean = mirrored(task.ocean)
    if isinstance(task, GyreTransect):
        (gyre,) = task.ocean["currents"]
        task.ocean = {"currents": [{**gyre, "period_s": -gyre["period_s"]}]}  # turns the other way
    return task


@pytest.fixture
def no_hands(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Scripts share out thrust as if no thruster twisted the hull, and nothing that is seen has noise."""

    class Even:
        from_catalogue = staticmethod(lambda name: pl.Vehicle.from_dict(without_hands(name)))

    caches = (scripted.mixer, oceanscale_hover._sharing)
    for cache in caches:
        cache.cache_clear()
    monkeypatch.setattr(scripted, "Vehicle", Even)
    monkeypatch.setattr(oceanscale_hover, "_NOISE", 0.0)
    yield
    for cache in caches:
        cache.cache_clear()


def without_hands(vehicle: str | Mapping[str, Any]) -> Mapping[str, Any]:
    """The vehicle with thrusters that do not twist it: all of one hand, they have no image."""
    given = {"type": vehicle} if isinstance(vehicle, str) else dict(vehicle)
    parts = pl.Vehicle.from_dict(given).config.actuators
    told = given.get("actuators", {})
    even = {n: {**told.get(n, {}), "torque_m": 0.0} for n, part in parts.items() if hasattr(part, "torque_m")}
    return given | {"actuators": even}


def other_sides(names: list[str]) -> list[int]:
    """Which number of an observation is what one is in the mirror, but for its sign."""
    pairs = {"left_propeller": "right_propeller", "right_propeller": "left_propeller"}
    pairs |= {f"throttle_{i}": f"throttle_{i ^ 1}" for i in range(8)}  # starboard and port in turn
    return [names.index(pairs.get(n, n)) for n in names]


def episode(task: Task) -> tuple[np.ndarray, np.ndarray]:
    """What was seen (steps, copies, numbers) and earned (steps, copies) under the task's script."""
    task.vehicle = EVEN if task.vehicle == "remus100" else without_hands(task.vehicle)
    if "waves" in task.ocean:
        sign = np.sign(task.ocean["waves"]["towards_deg"])
        task.ocean = ONE_WAVE if sign > 0 else mirrored(ONE_WAVE)
    env = envs.FleetEnv(task, 5, seed=3)
    seen, _ = env.reset(seed=3)
    views, rewards = [seen], []
    for _ in range(STEPS):
        seen, reward, *_ = env.step(task.script(seen))
        views.append(seen)
        rewards.append(reward)
    return np.array(views), np.array(rewards)


@pytest.mark.parametrize(
    "name", [slow(n) if n in AKIN else n for n in sorted(TASKS) if not has_sensors(f"pelagos/{n}")]
)
@pytest.mark.usefixtures("no_hands")
def test_an_episode_in_the_mirror_earns_the_same(name: str) -> None:
    (seen, earned), (image, likewise) = (episode(t) for t in (make_task(name), image_of(make_task(name))))
    np.testing.assert_allclose(likewise, earned, rtol=2e-5, atol=2e-5)
    expected = np.abs(seen)[..., other_sides(list(make_task(name).observations))]
    np.testing.assert_allclose(np.abs(image), expected, rtol=1e-3, atol=2e-4 * expected.max())  # triangles of hulls
    assert not np.allclose(image, seen)
    assert np.ptp(earned) > 0
