"""Props of a scenario: seen by rays, drawn copy by copy and episode by episode, put back by a reset."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import InputError, LookupFailed

PLACE, SIZE = (6.5, -1.5, -7.0), 1.5
START = (-2.0, -1.25, -7.2)
DRAWN = {"props.crate.position_m.0": {"uniform": [4.0, 9.0]}, "props.crate.orientation_deg.2": {"uniform": [-40, 40]}}


def scene(n: int = 1, **more: Any) -> pl.Simulation:
    sensor = {"type": "range_finder", "range_max_m": 30, "azimuth_deg": [0.0], "elevation_deg": [0.0], "rate_hz": 50}
    rov = {"vehicle": "bluerov2", "start": {"position_m": START}, "sensors": {"ranger": sensor}}
    crate = {"shape": "box", "position_m": PLACE, "size_m": SIZE, "orientation_deg": [0, 0, 0]}
    scenario = {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 30.0}, "agents": {"rov": rov}}
    keys = {key: more.pop(key) for key in ("environment", "seed") if key in more}
    return pl.Simulation.load({**scenario, "props": {"crate": crate}, **more}, n=n, **keys)


def ranges(sim: pl.Simulation) -> np.ndarray:
    place = np.array([START])
    return np.array([float(sim.observe("rov", place, copy=i)["ranger"].truth[0, 0]) for i in range(sim.n)])


def test_rays_meet_it_where_it_is_written() -> None:
    sim = scene()
    mount = sim.model.agents["rov"].sensors["ranger"].config.position_m
    assert ranges(sim)[0] == pytest.approx(PLACE[0] - SIZE / 2 - START[0] - mount[0], abs=1e-4)
    sim.props["crate"].move(position=(9.5, -1.5, -7.0))
    moved = ranges(sim)[0]
    assert moved == pytest.approx(9.5 - SIZE / 2 - START[0] - mount[0], abs=1e-4)
    sim.reset()
    assert ranges(sim)[0] == pytest.approx(moved - 3.0, abs=1e-4)
    sim.props["crate"].remove()
    assert "crate" not in sim.props
    assert not ranges(sim)[0] < 29.0
    sim.reset()
    assert ranges(sim)[0] == pytest.approx(moved - 3.0, abs=1e-4)


def test_what_comes_back_keeps_its_number_and_place() -> None:
    crate, ball = {"shape": "box", "position_m": PLACE}, {"shape": "sphere", "position_m": (3.0, 2.0, -6.0)}
    sim = scene(n=2, props={"crate": crate, "ball": ball})
    before = {name: body.geometry.instance for name, body in sim.props.items()}
    for anew in (sim.reset, lambda: sim.reset(where=[0, 1])):
        for removed in (["crate"], ["ball"], ["crate", "ball"]):
            for name in removed:
                sim.props[name].remove()
            spawned = sim.spawn(pl.Prop("box", position=(0, 4, -7)))
            assert spawned.geometry.instance not in before.values()
            anew()
            assert list(sim.props) == ["crate", "ball"]
            assert {name: body.geometry.instance for name, body in sim.props.items()} == before
    assert [body.name for body in sim.bodies.bodies][:2] == ["crate", "ball"]


def test_names_of_props_are_theirs() -> None:
    box1 = {"shape": "box", "position_m": PLACE}
    sim = scene(props={"box1": box1})
    assert sim.spawn(pl.Prop("box", position=(0, 4, -7))).name == "box2"
    with pytest.raises(LookupFailed, match="did you mean 'box1'"):
        sim.props["bax1"]
    assert "bax1" not in sim.props
    sim.props["box1"].remove()
    with pytest.raises(InputError, match="'box1' is a prop of the scenario"):
        sim.spawn(pl.Prop("box", position=(0, 4, -7)), name="box1")
    assert sim.spawn(pl.Prop("box", position=(0, 5, -7))).name == "box3"
    sim.reset()
    assert list(sim.props) == ["box1"]


def test_each_copy_has_its_own_and_is_a_fleet_of_one() -> None:
    sim = scene(n=4, vary=DRAWN, seed=5)
    x, yaw = (sim.drawn[key] for key in DRAWN)
    assert len(set(x)) == len(set(yaw)) == 4
    assert ((x >= 4) & (x <= 9)).all()
    mount = sim.model.agents["rov"].sensors["ranger"].config.position_m
    # the ray at y = off from the middle meets the face n . p = -h with n = (cos yaw, sin yaw)
    off = START[1] + mount[1] - PLACE[1]
    near = x - (SIZE / 2) / np.cos(np.radians(yaw)) - off * np.tan(np.radians(yaw))
    np.testing.assert_allclose(ranges(sim), near - START[0] - mount[0], atol=1e-4)
    for i in range(4):
        one = scene(n=1, vary=DRAWN, seed=5, environment=i)
        assert one.props["crate"].position[0].tolist() == sim.props["crate"].position[i].tolist()
        assert one.props["crate"].attitude[0].tolist() == sim.props["crate"].attitude[i].tolist()


def test_copies_that_begin_anew_draw_anew_and_leave_the_others() -> None:
    sim = scene(n=3, vary=DRAWN, seed=8)
    before = sim.props["crate"].position.copy()
    aside = before + np.array([0.0, 0.25, 0.0])
    sim.props["crate"].move(position=aside)
    sim.step(ticks=3)
    sim.reset(where=[1])
    after = sim.props["crate"].position
    assert after[[0, 2]].tolist() == aside[[0, 2]].tolist()
    assert after[1, 0] == sim.drawn["props.crate.position_m.0"][1] != before[1, 0]
    assert after[1, 1] == PLACE[1]
    again = scene(n=3, vary=DRAWN, seed=8)
    again.reset(episode=1)
    assert again.props["crate"].position[1].tolist() == after[1].tolist()


def test_a_checkpoint_holds_where_it_was_moved() -> None:
    sim = scene(n=2, vary=DRAWN, seed=3)
    sim.props["crate"].move(position=(5.0, -1.0, -7.0))
    kept = pickle.loads(pickle.dumps(sim.checkpoint()))
    sim.reset()
    other = scene(n=2, vary=DRAWN, seed=3)
    for one in (sim, other):
        one.restore(kept)
        assert one.props["crate"].position.tolist() == [[5.0, -1.0, -7.0]] * 2
    twin = sim.fork()
    twin.props["crate"].move(position=(8.0, -1.0, -7.0))
    assert sim.props["crate"].position[0, 0] == 5.0
    assert ranges(twin)[0] == pytest.approx(ranges(sim)[0] + 3.0, abs=1e-4)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"props": {"rov": {"shape": "box", "position_m": [0, 0, -9]}}}, "rov is an agent already"),
        ({"props": {"a b": {"shape": "box", "position_m": [0, 0, -9]}}}, "cannot be the name of a prop"),
        ({"props": {"m": {"shape": "mesh", "position_m": [0, 0, -9]}}}, "'path' goes with shape: mesh"),
        ({"props": {"b": {"shape": "box", "position_m": [0, 0, -9], "size_m": -1}}}, "size_m"),
        ({"props": {"b": {"shape": "box", "position_m": [0, 0, -9], "material": "stel"}}}, "did you mean 'steel'"),
        ({"vary": {"props.crat.position_m.0": {"uniform": [1, 2]}}}, "no 'props.crat'.*did you mean 'crate'"),
        ({"vary": {"props.crate.size_m": {"uniform": [1, 2]}}}, "did you mean 'props.crate.pos"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(keys: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        scene(**keys)


def test_the_written_scenario_has_them() -> None:
    sim = scene(n=1, vary=DRAWN)
    again = pl.Simulation.load(sim.scenario)
    assert again.written == sim.written
    assert "crate" in sim.written


def test_a_recording_holds_where_each_copy_had_it(tmp_path) -> None:
    sim = scene(n=2, vary=DRAWN, seed=4)
    drawn = sim.props["crate"].position.copy()

    def push(now: pl.Simulation) -> None:
        if now.time_ns == 400_000_000:
            now.props["crate"].move(position=(5.5, -1.0, -7.5), velocity=(0.0, 0.25, 0.0))

    sim.on_tick(push, rate_hz=10)
    sim.run(1.0, record=tmp_path / "run.mcap")
    recording = pl.Recording(tmp_path / "run.mcap")
    for copy in range(2):
        topic = f"/env{copy}/props/crate/odometry"
        said = list(recording.messages(topic))
        found = {r.t_ns: r.message.pose.pose.position for r in said}
        assert len(found) == len(said)  # one place at the tick at which it is moved
        assert min(found) == 0
        assert max(found) == 1_000_000_000
        for t_ns, place in found.items():
            at = drawn[copy] if t_ns < 400_000_000 else (5.5, -1.0, -7.5)
            assert [place.y, -place.x, place.z] == pytest.approx(list(at), abs=1e-12)  # ENU


def test_props_stand_behind_what_moves_and_come_back_from_a_checkpoint_as_props() -> None:
    """Their numbers are none of a mover's; one that was removed since is the scenario's again."""
    path = {"kind": "circle", "centre_m": [5.0, -2.0, -14.0], "radius_m": 2.5, "speed_mps": 0.9}
    movers = [{"name": name, "body": "sphere", "size_m": 1.4, "path": path} for name in ("fish", "seal")]
    crate, ball = {"shape": "box", "position_m": PLACE}, {"shape": "sphere", "position_m": (3.0, 2.0, -6.0)}
    sim = scene(props={"crate": crate, "ball": ball}, world={"type": "flat", "depth_m": 30.0, "movers": movers})
    numbers = [body.geometry.instance for body in sim.bodies.bodies]
    assert [body.name for body in sim.bodies.bodies] == ["fish", "seal", "crate", "ball"]
    assert numbers == list(range(numbers[0], numbers[0] + 4))
    kept = sim.checkpoint()
    sim.props["crate"].remove()
    sim.restore(kept)
    assert list(sim.props) == ["crate", "ball"]
    sim.props["crate"].remove()
    sim.reset()
    assert [(body.name, body.geometry.instance) for body in sim.bodies.bodies] == list(
        zip(("fish", "seal", "crate", "ball"), numbers, strict=True)
    )
