"""Start states: changed copy by copy, on the sea of each copy, and where something stands."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Final

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.config.agent import Start
from pelagos.errors import ScenarioError
from pelagos.sim import initial
from pelagos.sim.initial import StartState, _start, on_its_sea, start_states, starts

WHERE: Final = np.array([True, False, True])


def quaternion(turns: Rotation) -> np.ndarray:
    found = turns.as_quat()[..., [3, 0, 1, 2]]
    return np.asarray(found * np.sign(found[..., :1]))


def test_states_are_changed_in_the_copies_that_are_asked_for() -> None:
    """One for all, a row for each copy, or one for each that begins anew; what is not given stays, rates begin at 0."""
    turns = quaternion(Rotation.from_rotvec([[0.1, 0.2, 0.3], [-0.4, 0.1, 0.0], [0.2, -0.3, 0.5]]))
    begin = {
        name: StartState(k + np.arange(9.0).reshape(3, 3), turns, -np.arange(9.0).reshape(3, 3))
        for k, name in enumerate("ab")
    }
    state = {"b": {
        "position": [[100.0, 0, 0], [0, 200.0, 0]], "velocity": np.arange(9.0).reshape(3, 3) * 7,
        "angular_velocity": (1.0, 2.0, 3.0), "attitude": [[0.0, 3.0, 0, 0], [0, 0, -2.0, 0]],
    }}  # fmt: skip
    found = starts(begin, state, WHERE)
    assert found["a"] is begin["a"]
    np.testing.assert_array_equal(found["b"].position, [[100, 0, 0], [4, 5, 6], [0, 200, 0]])
    np.testing.assert_array_equal(found["b"].velocity, [[0, 7, 14], [-3, -4, -5], [42, 49, 56]])
    np.testing.assert_array_equal(found["b"].attitude, [[0, 1, 0, 0], turns[1], [0, 0, -1, 0]])
    np.testing.assert_array_equal(found["b"].angular_velocity, [[1, 2, 3], [0, 0, 0], [1, 2, 3]])
    only = starts(found, {"b": {"position": (7.0, 8.0, 9.0), "attitude": (0.0, 0.0, 0.0, 5.0)}}, ~WHERE)["b"]
    np.testing.assert_array_equal(only.attitude, [[0, 1, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]])
    np.testing.assert_array_equal(only.position, [[100, 0, 0], [7, 8, 9], [0, 200, 0]])
    np.testing.assert_array_equal(only.velocity, found["b"].velocity)
    np.testing.assert_array_equal(only.angular_velocity, found["b"].angular_velocity)


def agent(start: dict[str, Any], name: str = "it") -> Any:
    return SimpleNamespace(name=name, config=SimpleNamespace(start=Start.model_validate(start)))


def model(inside: str | None = None, close: bool = True) -> Any:
    world = SimpleNamespace(inside=lambda places: inside, near=lambda places, radius: np.full(len(places), close))
    return SimpleNamespace(world=world, n=2, scenario=SimpleNamespace(where=lambda *path: "/".join(path)))


def test_a_start_is_turned_as_its_angles_say_and_goes_with_its_water(monkeypatch: pytest.MonkeyPatch) -> None:
    """Yaw, pitch and roll of forward-right-down in north-east-down; the water's motion is that of the world."""
    monkeypatch.setattr(initial, "_touched", lambda *_: None)
    it = agent({"position_m": [1, 2], "roll_deg": 20, "pitch_deg": -35, "heading_deg": 110, "speed_mps": 1.5})
    water = np.array([0.3, -0.2, 0.5])
    found = _start(it, model(), np.array([1.0, 2.0, -3.0]), water, close=True)
    flip = np.diag([1.0, -1.0, -1.0])
    turn = flip @ Rotation.from_euler("ZYX", [110, -35, 20], degrees=True).as_matrix() @ flip
    np.testing.assert_allclose(found.position, [[1, 2, -3]] * 2)
    np.testing.assert_allclose(Rotation.from_quat(found.attitude[1, [1, 2, 3, 0]]).as_matrix(), turn, atol=1e-12)
    np.testing.assert_allclose(found.velocity, [turn.T @ water + [1.5, 0, 0]] * 2)
    still = _start(it, model("lies in a wall"), np.zeros(3), None, close=False)  # nothing is near: nobody looks
    np.testing.assert_allclose(still.velocity, [[1.5, 0, 0]] * 2)
    with pytest.raises(ScenarioError, match="it cannot start here: lies in a wall"):
        _start(it, model("lies in a wall"), np.zeros(3), None, close=True)
    monkeypatch.setattr(initial, "_touched", lambda *_: "its hull would touch it")
    with pytest.raises(ScenarioError, match="would touch it"):
        _start(it, model(), np.zeros(3), None, close=True)
    anywhere = agent({"position_m": [1, 2], "anywhere": True})
    _start(anywhere, model("lies in a wall"), np.zeros(3), None, close=True)


def test_members_of_batches_start_in_the_order_of_agents_each_with_what_is_near_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made, seen = model(), {}
    made.agents = {f"a{k}": agent({"position_m": [k, -k, -1 - k]}, f"a{k}") for k in range(4)}
    made.batches = {
        name: SimpleNamespace(members=members, vehicle=SimpleNamespace(bounding_radius_m=radius))
        for name, members, radius in (("x", ["a3", "a1"], 0.5), ("y", ["a0", "a2"], 2.0))
    }
    made.ocean = None
    made.world.near = lambda places, radius: places[:, 0] + radius > 2.0
    monkeypatch.setattr(initial, "_rides", lambda who, ocean: who.name == "a1")
    monkeypatch.setattr(initial, "_surface", lambda *_: (np.array([0.7]), np.array([[1.0, 2.0, 3.0]])))

    def start(who: Any, of: Any, place: Any, motion: Any, *, close: bool) -> Any:
        seen[who.name] = (place.tolist(), None if motion is None else motion.tolist(), close)
        return who.name

    monkeypatch.setattr(initial, "_start", start)
    assert list(start_states(made).items()) == [(f"a{k}", f"a{k}") for k in range(4)]
    assert seen == {
        "a0": ([0, 0, -1], None, False), "a1": ([1, -1, 0.7], [1, 2, 3], False), "a2": ([2, -2, -3], None, True),
        "a3": ([3, -3, -4], None, True),
    }  # fmt: skip


def test_who_rides_on_waves_begins_on_those_of_its_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    """The height and the motion of the copy's own sea for those of the scenario's, at the copy's place and heading."""
    turns = Rotation.from_euler("z", [[0.3], [-1.1], [2.0]])
    upright, turned = quaternion(Rotation.from_euler("z", [[0.5]] * 3)), quaternion(turns)
    begin = StartState(np.full((3, 3), 2.0), upright, np.zeros((3, 3)))
    state = StartState(np.arange(9.0).reshape(3, 3), turned, np.full((3, 3), 0.1))
    own, whole = np.array([0.5, -0.4, 0.9]), np.array([0.2, 0.2, 0.2])
    motion, moved = np.arange(9.0).reshape(3, 3) - 4, np.array([[0.3, 0.1, -0.2]] * 3)
    asked = []

    def surface(who: Any, ocean: Any, position: Any, heading: Any, copy: Any) -> Any:
        asked.append((ocean, position, heading, copy.tolist()))
        return (whole, moved) if ocean == "scenario" else (own, motion)

    monkeypatch.setattr(initial, "_surface", surface)
    monkeypatch.setattr(initial, "_rides", lambda *_: True)
    ocean: Any = SimpleNamespace(with_=lambda own_waves: "scenario")
    found = on_its_sea(None, ocean, begin, state)  # type: ignore[arg-type]
    np.testing.assert_allclose(found.position, state.position + np.outer(own - whole, [0, 0, 1]))
    back = Rotation.from_euler("z", 0.5).inv().apply(moved)
    np.testing.assert_allclose(found.velocity, 0.1 + turns.inv().apply(motion) - back)
    np.testing.assert_allclose(asked[0][2], [-0.5] * 3)
    np.testing.assert_allclose(asked[1][2], [-0.3, 1.1, -2.0])
    assert asked[0][1] is begin.position
    assert asked[1][1] is state.position
    assert [a[3] for a in asked] == [[0, 1, 2]] * 2
    monkeypatch.setattr(initial, "_rides", lambda *_: False)
    assert on_its_sea(None, ocean, begin, state) is state  # type: ignore[arg-type]
