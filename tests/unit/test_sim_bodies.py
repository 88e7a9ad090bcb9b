"""Rows, numbers and memory of everything that moves, kept for a scene that writes down what it is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.errors import CommandError
from pelagos.raycast.geometry import Geometry
from pelagos.sim.bodies import Bodies, Body, hull_rows

N = 2


def mesh(instance: int) -> Geometry:
    return Geometry(np.eye(3) * instance, np.array([[0, 1, 2]], dtype=np.uint32), 0, 1, instance)


class Scene:
    """What `Bodies` asks of a scene."""

    def __init__(self) -> None:
        self.holder: Any = None
        self.moving: Any = None
        self.streamed = True
        self.ground, self.told = "", []  # type: tuple[Any, list[Any]]

    def set_moving(self, rows: Any) -> None:
        self.moving = [(geometry.instance, copy) for geometry, copy in rows]

    def holds(self, rows: Any) -> bool:
        return self.moving == [(geometry.instance, copy) for geometry, copy in rows]

    def move(self, *values: Any) -> None:
        self.told.append(values)

    def memory(self) -> Any:
        return self.ground

    def recall(self, ground: Any) -> None:
        self.ground = ground

    def follow(self, places: Any) -> None:
        self.told.append(places)

    def forget(self) -> None:
        self.ground = None


def company(hulls: int = 2) -> tuple[Bodies, Scene]:
    scene: Any = Scene()
    bodies = Bodies(scene, {f"a{k}": mesh(90 + k) for k in range(hulls)}, n=N, first_instance=10)
    scene.ground = "seabed"
    return bodies, scene


def spawned(bodies: Bodies, name: str, **more: Any) -> Body:
    return bodies.add(name, mesh(bodies.new_instance()), (1.0, 2.0, 3.0), **more)


def numbers(bodies: Bodies) -> list[tuple[str, int]]:
    return [(b.name, b.geometry.instance) for b in bodies.bodies]


def test_numbers_follow_hulls_movers_and_props_and_come_back_when_all_is_cleared() -> None:
    """Hulls 10 and 11 where there are two; one alone stands in no scene."""
    bodies, scene = company()
    assert {name: hull.instance for name, hull in bodies.hulls.items()} == {"a0": 10, "a1": 11}
    assert [bodies.hull_of("a1").instance, hull_rows(1, 3).tolist()] == [91, [3, 4, 5]]
    bodies.add_scripted([("ship", mesh(bodies.new_instance()), 1.5), ("fish", mesh(bodies.new_instance()), 0.2)])
    first = bodies.instance_of_prop(0)
    second = bodies.instance_of_prop(1)
    assert [first, second, bodies.instance_of_prop(0)] == [14, 15, 14]
    ball = spawned(bodies, "ball")
    bodies.add("crate", mesh(second), (0, 0, 0), prop=0)
    bodies.add("stone", mesh(first), (0, 0, 0), prop=0)
    assert numbers(bodies) == [("ship", 12), ("fish", 13), ("stone", 14), ("crate", 15), ("ball", 16)]
    rows = [10, 10, 11, 11, 12, 12, 13, 13, 14, 14, 15, 15, 16, 16]
    assert scene.moving == list(zip(rows, [0, 1] * 7, strict=True))
    assert bodies.rows_of(ball).tolist() == [12, 13]
    bodies.spawned = 3
    bodies.clear()
    assert numbers(bodies) == [("ship", 12), ("fish", 13), ("stone", 14), ("crate", 15)]
    assert (bodies.spawned, bodies.new_instance()) == (0, 16)
    for ask in (ball.remove, lambda: ball.move(position=(0, 0, 0)), lambda: bodies.rows_of(ball)):
        with pytest.raises(CommandError, match="'ball' was removed"):
            ask()
    with pytest.raises(CommandError, match="named 'ship' is there already"):
        spawned(bodies, "ship")
    alone, empty = company(hulls=1)
    assert (alone.any, alone.hulls, empty.moving, alone.new_instance()) == (False, {}, None, 10)


def test_a_memory_puts_bodies_back_and_keeps_the_handles_of_those_that_are_here() -> None:
    """What came since goes, what went comes back as another body; scripted ones stay, first in the rows."""
    bodies, scene = company()
    (ship,) = bodies.add_scripted([("ship", mesh(bodies.new_instance()), 1.5)])
    crate = bodies.add("crate", mesh(bodies.instance_of_prop(0)), (0, 0, 0), prop=0)
    ball = spawned(bodies, "ball")
    bodies.spawned = 1
    crate.move(position=[[1, 2, 3], [4, 5, 6]], attitude=(0, 0, 2, 0), velocity=(1, 0, 0), angular_velocity=(0, 3, 0))
    kept = bodies.memory()
    assert crate.attitude.tolist() == [[0, 0, 1, 0]] * 2
    crate.move(position=(7, 7, 7), attitude=(1, 1, 0, 0), velocity=(0, 2, 0), angular_velocity=(0, 0, 0))
    assert kept["spawned"][0]["position"].tolist() == [[1, 2, 3], [4, 5, 6]]
    ball.remove()
    other = spawned(bodies, "ball")  # of the same name, another body
    spawned(bodies, "more")
    bodies.spawned, scene.ground, changes = 2, "elsewhere", bodies.changes
    bodies.changed = False
    bodies.recall(kept)
    assert bodies.bodies[:2] == [ship, crate]
    assert not any(bodies.bodies[2] is gone for gone in (ball, other))
    assert numbers(bodies) == [("ship", 12), ("crate", 13), ("ball", 14)]
    assert [b.of_scenario for b in bodies.bodies] == [False, True, False]
    assert (bodies.spawned, bodies.new_instance(), scene.ground) == (1, 15, "seabed")
    assert (bodies.changes > changes, bodies.changed) == (True, True)
    assert crate.position.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert crate.attitude.tolist() == [[0, 0, 1, 0]] * 2
    assert [crate.velocity[1].tolist(), crate.angular_velocity[1].tolist()] == [[1, 0, 0], [0, 3, 0]]
    crate.position[0] = 0.0
    bodies.recall(kept)  # a memory may be used again
    assert crate.position.tolist() == [[1, 2, 3], [4, 5, 6]]
    changes = bodies.changes
    bodies.recall(kept)
    assert bodies.changes == changes  # the same rows stand in the scene


def test_simulations_that_share_a_scene_take_turns_with_their_ground_and_their_bodies() -> None:
    bodies, scene = company()
    ball, changes = spawned(bodies, "ball"), bodies.changes
    ball.move(position=(4, 5, 6))
    assert bodies.changes == changes + 1
    scene.ground, bodies.script = "north", print
    other = bodies.twin()
    other.bodies[0].move(position=(-1, 0, 0))
    assert bodies.bodies[0].position.tolist() == [[4, 5, 6]] * 2
    other.forget()
    assert (scene.holder, scene.ground) == (other, None)
    assert (bodies.memory()["ground"], other.script) == ("north", None)
    scene.ground = "south"
    bodies.forget()
    assert scene.holder is bodies
    other.remove(other.bodies[0])
    assert (scene.holder, scene.moving) == (other, [(10, 0), (10, 1), (11, 0), (11, 1)])
    assert scene.ground == "south"
    agents: Any = SimpleNamespace(motion=np.zeros((4, 13)))
    bodies.show(agents)
    assert scene.moving == [(10, 0), (10, 1), (11, 0), (11, 1), (12, 0), (12, 1)]


class Agents:
    """Motion of two agents in two copies."""

    def __init__(self) -> None:
        self.motion = np.random.default_rng(3).normal(size=(4, 13))
        self.turns = Rotation.from_rotvec(self.motion[:, :3])
        self.motion[:, 3:7] = self.turns.as_quat()[:, [3, 0, 1, 2]]

    def __len__(self) -> int:
        return len(self.motion)


def test_the_scene_is_told_of_agents_and_then_bodies_in_the_world_frame() -> None:
    bodies, scene = company()
    ball = spawned(bodies, "ball", attitude=[(1, 0, 0, 0), (0, 0, 0, -3)])
    ball.move(velocity=[(1, 2, 3), (4, 5, 6)], angular_velocity=(7, 8, 9))
    agents: Any = Agents()
    bodies.place(agents)
    followed, (position, attitude, velocity, spin) = scene.told
    np.testing.assert_array_equal(followed, agents.motion[:, :3])
    np.testing.assert_allclose(position, [*agents.motion[:, :3], [1, 2, 3], [1, 2, 3]])
    np.testing.assert_allclose(attitude, [*agents.motion[:, 3:7], [1, 0, 0, 0], [0, 0, 0, -1]])
    np.testing.assert_allclose(velocity, [*agents.turns.apply(agents.motion[:, 7:10]), [1, 2, 3], [4, 5, 6]])
    np.testing.assert_allclose(spin, [*agents.turns.apply(agents.motion[:, 10:13]), [7, 8, 9], [7, 8, 9]])
    bodies.show(agents)
    assert len(scene.told) == 3  # agents go on
    alone, still = company(hulls=1)
    spawned(alone, "ball")
    alone.show(agents)
    assert [len(part) for part in still.told[0]] == [2] * 4
    alone.show(agents)
    assert len(still.told) == 1  # nothing was moved since
    ticks: list[int] = []
    alone.script = ticks.append
    alone.follow(0)
    alone.follow(7)
    assert ticks == [0, 7]
