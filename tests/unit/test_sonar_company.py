"""Sonars in company: from where, how loudly and since when each hears the others, by lane, source and beam."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.acoustics.absorption import absorption
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sonar.ping.emitter import Apertures, Emitter
from pelagos.sensors.sonar.ping.interference import Heard, Neighbours
from pelagos.sensors.sonar.ping.ping_spec import Mounting
from pelagos.sensors.sonar.ping.placed import Placed, Pose, ReceiverLanes

DT_NS = 10_000_000
RNG = np.random.default_rng(11)


def turns(count: int, seed: int) -> Rotation:
    return Rotation.random(count, random_state=seed)


def wxyz(turn: Rotation) -> np.ndarray:
    return np.roll(turn.as_quat(), 1, axis=-1)


def mount(seed: int) -> Mounting:
    arm = np.random.default_rng(seed).uniform(-1.5, 1.5, 3)
    return Mounting(tuple(arm.tolist()), tuple(wxyz(turns(1, seed))[0].tolist()))


def body(turn: Any) -> Rotation:
    return Rotation.from_quat(np.roll(np.asarray(turn, float), -1, axis=-1))


def pair_of_beams(seed: int, side_length: float, up_length: float) -> Apertures:
    """Two rectangles that look anywhere."""
    axis, side, up = (turns(2, seed).as_matrix()[:, :, k] for k in range(3))
    return Apertures(axis, side, up, side_length, up_length)


def one_way(beams: Apertures, direction: np.ndarray) -> np.ndarray:
    """Power of rectangles: sinc^2 along both edges, 1e-4 beside all lobes, 1e-3 of that behind."""
    found = []
    for axis, side, up in zip(beams.axis, beams.side, beams.up, strict=True):
        u, v = math.pi * beams.side_length * (side @ direction), math.pi * beams.up_length * (up @ direction)
        pattern = (math.sin(u) / u * math.sin(v) / v) ** 2
        found.append(max(pattern, 1e-4) * (1.0 if axis @ direction > 0.0 else 1e-3))
    return np.array(found)


def sonar(path: str, seed: int, **more: Any) -> Emitter:
    keys: dict[str, Any] = {
        "frequency_hz": 100e3, "bandwidth_hz": 20e3, "pulse_s": 1e-3, "source_level_db": 190.0 + seed,
        "period_ns": 1_000_000 * (7 * seed + 30),
    }  # fmt: skip
    return Emitter(path, mount(seed), pair_of_beams(seed + 50, 0.4 + 0.3 * seed, 1.7 - 0.2 * seed), **(keys | more))


def moving(seed: int, places: np.ndarray, ticks: tuple[int, ...] = (3, 9)) -> Any:
    attitude = wxyz(turns(len(places), seed + 90))
    copies = len(places) // len(ticks)
    return lanes(ticks, dt_ns=DT_NS, environments=range(copies), position=places, attitude=attitude)


def pose(emitter: Emitter, motion: Any, lane: int) -> tuple[np.ndarray, Rotation]:
    turn = body(np.array(motion.attitude)[:, lane])
    place = np.array(motion.position)[:, lane] + turn.apply(emitter.mounting.position_m)
    return place, turn * body(emitter.mounting.q_body_sensor)


def test_sonars_stand_where_their_vehicles_and_mounts_put_them() -> None:
    sources = [sonar("b.s", 1), sonar("c.s", 2)]
    motions = [moving(k, RNG.uniform(-40, 40, (2, 3))) for k in range(2)]
    found = Placed.of(sources, [Pose.of(m) for m in motions])
    for k, (source, motion) in enumerate(zip(sources, motions, strict=True)):
        for lane in range(2):
            place, turn = pose(source, motion, lane)
            assert found.position[k, lane] == pytest.approx(place, abs=1e-9)
            assert body(found.attitude[k, lane]).as_matrix() == pytest.approx(turn.as_matrix(), abs=1e-9)


def test_lanes_of_a_group_go_tick_by_tick_vehicle_by_vehicle_copy_by_copy() -> None:
    """Two ticks of three vehicles in two copies; others have a lane a tick and copy, or are rows of another group."""
    copy = np.tile(np.arange(6, dtype=np.uint32), 2)
    motion: Any = SimpleNamespace(position=jit.Array3f64(np.zeros((3, 12))), copy=jit.UInt32(copy))
    group = ReceiverLanes.of(motion, 3, 2)
    assert (group.carrier == np.tile([0, 0, 1, 1, 2, 2], 2)).all()
    tick, inside = np.repeat([0, 1], 6), np.tile([0, 1], 6)
    assert (group.same(4) == tick * 2 + inside).all()
    assert (group.same(12) == np.arange(12)).all()
    whole = Pose(np.tile(np.arange(16.0)[:, None], 3), np.zeros((16, 4)))  # two ticks of four vehicles in two copies
    assert (whole.of_rows(slice(4, 6), group).position[:, 0] == tick * 8 + 4 + inside).all()
    alone = ReceiverLanes.of(motion, 1, 0)
    assert (alone.carrier == 0).all()
    assert (alone.same(12) == np.arange(12)).all()


def heard_by(heard: Heard, count: int, beams: int) -> list[dict[str, np.ndarray]]:
    """Of each lane what it hears."""
    flat = {name: np.array(getattr(heard, name)).reshape(-1, count) for name in ("distance", "since", "source")}
    way, level = np.array(heard.direction).reshape(3, -1, count), np.array(heard.level).reshape(-1, count, beams)
    found = []
    for lane in range(count):
        there = np.isfinite(flat["distance"][:, lane])
        assert (level[~there, lane] == 0.0).all()
        row = {name: values[there, lane] for name, values in flat.items()}
        found.append(row | {"way": way[:, there, lane].T, "level": level[there, lane]})
    return found


def test_what_a_receiver_hears_is_each_sources_own() -> None:
    """Three mounted sonars at two ticks, one of them with a head that turns, one nearer than spreading begins; a fourth
    is loud enough in the first tick alone: by half of the absorption of warm and fresh water."""
    loss = float(absorption(jit.Float64(100e3), jit.Float64(20.0), jit.Float64(5.0), jit.Float64(0.0))[0])
    faintest = 194.0 - 20.0 * math.log10(300.0) - 0.75 * loss * 300.0
    own = replace(sonar("a.s", 0), faintest_db=faintest)
    head = lambda tick: 0.3 * tick - 1.1
    sources = [sonar("b.s", 1), sonar("c.s", 2, angle=head), sonar("d.s", 3), sonar("e.s", 4)]
    here = moving(20, np.array([[0.0, 0.0, -20.0], [3.0, -1.0, -21.0]]))
    motions = {s.agent: moving(30 + k, RNG.uniform(-30, 30, (2, 3))) for k, s in enumerate(sources)}
    at = [pose(own, here, lane)[0] for lane in range(2)]
    for k, way in (
        ("d", np.array([[0.1, 0.2, -0.1], [9.0, 7.0, 1.0]])),
        ("e", np.array([[0, 300.0, 0], [420.0, 0, 0]])),
    ):
        arm = [
            pose(sources["bcde".index(k)], motions[k], lane)[0] - np.array(motions[k].position)[:, lane]
            for lane in (0, 1)
        ]
        moved = np.array(at) + way - np.array(arm)
        motions[k] = replace(motions[k], position=jit.Array3f64(np.ascontiguousarray(moved.T)))
    neighbours = Neighbours(tuple(s.path for s in sources), motion_of=lambda agent: motions[agent])
    for s in sources:
        neighbours.add(s)
    heard = neighbours.heard(own, neighbours.paths, here)
    assert heard is not None
    assert heard.size_key == (4, 8, 16)
    assert np.array(heard.period) == pytest.approx([s.period_ns * 1e-9 for s in sources])
    assert np.array(heard.frequency) == pytest.approx(100e3)
    for lane, (row, tick) in enumerate(zip(heard_by(heard, 2, 2), (3, 9), strict=True)):
        assert row["source"].tolist() == ([0, 1, 2, 3] if lane == 0 else [0, 1, 2])
        for k, number in enumerate(row["source"]):
            source = sources[number]
            place, turn = pose(source, motions[source.agent], lane)
            mine, facing = pose(own, here, lane)
            distance = np.linalg.norm(place - mine)
            way = (place - mine) / distance
            back = turn.inv().apply(-way)
            if source.angle is not None:
                back = Rotation.from_euler("z", -head(tick)).apply(back)
            sent, received = one_way(source.apertures, back).max(), one_way(own.apertures, facing.inv().apply(way))
            gain = 10.0 ** ((source.source_level_db - own.source_level_db) / 10.0)
            assert row["distance"][k] == pytest.approx(distance, rel=1e-5)
            assert row["way"][k] == pytest.approx(way, abs=1e-5)
            assert row["level"][k] == pytest.approx(gain * sent * received / max(distance, 0.3) ** 2, rel=1e-4)
            assert row["since"][k] == pytest.approx((tick * DT_NS % source.period_ns) * 1e-9, rel=1e-5)


@pytest.mark.parametrize("others", [True, False])
def test_members_of_a_group_hear_all_but_themselves(others: bool) -> None:
    """Of "others" nothing of the own vehicle; of those that are named all but the sonar itself."""
    path = BatchPath.of(("a[0].s", "a[1].s"), range(2))
    own = sonar(path, 0, faintest_db=-200.0)
    far = {"a[0]": 0.0, "a[1]": 50.0, "b": 90.0}
    motions = {
        name: moving(k, np.array([[x, 3.0, -9.0], [x, 5.0, -8.0]]), (4,)) for k, (name, x) in enumerate(far.items())
    }
    both = np.concatenate([np.array(motions[name].position).T for name in ("a[0]", "a[1]")])
    here = moving(7, both, (4,))
    neighbours = Neighbours(motion_of=lambda agent: motions[agent])
    for s in (own, sonar("a[0].head", 1), sonar("a[1].head", 2), sonar("b.s", 3)):
        neighbours.add(s)
    asked = ["a[0].head", "b.s", "a[1].s", "a[0].s"]
    heard = neighbours.heard(own, asked, here, others=others)
    assert heard is not None
    wanted = (
        [{"b.s", "a[1].s"}, {"a[0].head", "b.s", "a[0].s"}]
        if others
        else [{"a[0].head", "b.s", "a[1].s"}, {"a[0].head", "b.s", "a[0].s"}]
    )
    rows = heard_by(heard, 4, 2)
    for lane, row in enumerate(rows):
        assert {asked[k] for k in row["source"]} == wanted[lane // 2]
    place = pose(sonar("a[0].head", 1), motions["a[0]"], 1)[0]  # of the second copy
    mine = pose(own, here, 3)[0]
    assert rows[3]["distance"][0] == pytest.approx(np.linalg.norm(place - mine), rel=1e-5)


def test_a_sonar_alone_does_not_hear_itself_nor_other_bands() -> None:
    own = sonar("a.s", 0)
    neighbours = Neighbours(motion_of=lambda agent: moving(3, np.full((2, 3), -5.0)))
    for s in (own, sonar("b.s", 1, frequency_hz=125e3), sonar("c.s", 2, frequency_hz=80e3)):
        neighbours.add(s)
    here = moving(4, np.zeros((2, 3)))
    assert neighbours.heard(own, ["a.s", "c.s"], here) is None  # bands of 90 to 110 and of 70 to 90 kHz only touch
    assert neighbours.heard(own, ["a.s", "b.s"], here) is None
    assert neighbours.heard(replace(own, bandwidth_hz=31e3), ["b.s"], here) is not None


def test_few_steered_beams_are_each_asked_and_many_by_the_nearest() -> None:
    """The loudest in any direction ahead: of 5 beams exactly; of 40 within what the nearest gives."""
    rng = np.random.default_rng(2)
    for beams in (5, 40):
        azimuth = np.linspace(0.8, -0.8, beams)
        axis = np.stack([np.cos(azimuth), np.sin(azimuth), 0 * azimuth], axis=-1)
        side, up = (np.tile(v, (beams, 1)) for v in ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]))
        array = Apertures(axis, side, up, 12.0, 3.0, "light", True)
        direction = rng.normal(size=(50, 3)) * [0.3, 0.6, 0.2] + [1.0, 0.0, 0.0]
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        share = 0.75
        u = 12.0 * (direction[:, 1, None] - np.sin(azimuth))
        line = (share * np.sinc(u) + 0.5 * (1 - share) * (np.sinc(u - 1) + np.sinc(u + 1))) / share
        power = np.maximum((line * np.sinc(3.0 * direction[:, 2])[:, None]) ** 2, 1e-4)
        power *= np.where(direction @ axis.T > 0.0, 1.0, 1e-3)
        assert array.power(direction) == pytest.approx(power, rel=1e-9)
        inside = np.abs(direction[:, 1]) < 0.7
        found = array.loudest(direction)
        assert found[inside] == pytest.approx(power.max(axis=1)[inside], rel=1e-9 if beams == 5 else 0.02)
