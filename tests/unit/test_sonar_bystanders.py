"""Noise of vehicles at a sonar: whose, from where and how loud, by lane, source and beam."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.noise import BatchPath
from pelagos.sensors.sonar.ping.emitter import Apertures, Emitter
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sensors.sonar.ping.ping_spec import Mounting
from pelagos.sensors.sonar.ping.vehicle_noise import Bystanders, NoiseSource, VehicleNoise

GAIN, DT_NS, TICKS = 3e-9, 20_000_000, (5, 60)
TURNS = Rotation.random(16, random_state=5)
AXIS, SIDE, UP = (TURNS[:3].as_matrix()[:, :, k] for k in range(3))
BEAMS = Apertures(AXIS, SIDE, UP, 1.3, 0.6)
MOUNT = Mounting((0.7, -0.4, 0.25), tuple(np.roll(TURNS[3].as_quat(), 1).tolist()))


def current(position: Any, t: Any, copy: Any = None) -> Any:
    """Water that differs by place, time and copy."""
    other = 0.0 if copy is None else 0.2 * jit.Float64(copy)
    return jit.Array3f64(0.3 + 0.01 * position[0], 0.1 * t - 0.02 * position[1], 0.05 * position[2] + other)


OCEAN: Any = SimpleNamespace(current=current)


def source(level_db: float, hull_m: float) -> NoiseSource:
    """Grows with the speed, and falls with the frequency."""
    return NoiseSource(lambda f, v: level_db + 30.0 * np.log10(v) - f * 1e-4, hull_m)


def vehicle(seed: int, places: Any, ticks: tuple[int, ...] = TICKS) -> Any:
    rng, places = np.random.default_rng(seed), np.array(places, float)
    attitude = np.roll(TURNS[[4 + (seed + k) % 12 for k in range(len(places))]].as_quat(), 1, axis=1)
    return lanes(
        ticks, dt_ns=DT_NS, environments=range(len(places) // len(ticks)), position=places, attitude=attitude,
        velocity=rng.uniform(-2, 2, (len(places), 3)),
    )  # fmt: skip


def turn_of(motion: Any, lane: int) -> Rotation:
    return Rotation.from_quat(np.roll(np.array(motion.attitude)[:, lane], -1))


def bystanders(
    which: str, makers: dict[str, NoiseSource], motions: dict[str, Any], path: Any = "a.s", **more: Any
) -> Any:
    own = Emitter(path, MOUNT, BEAMS, 6e4, 1e4, 1e-3, 200.0, 10**8, **more)
    neighbours = Neighbours(noises=makers, motion_of=motions.__getitem__)
    ear = SimpleNamespace(vehicle_noise=which, frequency_hz=6e4)
    return Bystanders(ear, own, neighbours, OCEAN, behind_filter=GAIN, noise=1e-2)


def expected(maker: NoiseSource, motion: Any, here: Any, lane: int, there: int, head: float = 0.0) -> tuple[Any, ...]:
    """Distance, direction and level by beam, or no level where nobody hears it."""
    mine = np.array(here.position)[:, lane] + turn_of(here, lane).apply(MOUNT.position_m)
    place = np.array(motion.position)[:, there]
    distance = float(np.linalg.norm(place - mine))
    way = (place - mine) / distance
    t, copy = float(np.array(here.t_ns)[lane]) * 1e-9, float(np.array(motion.copy)[there])
    water = np.array([0.3 + 0.01 * place[0], 0.1 * t - 0.02 * place[1], 0.05 * place[2] + 0.2 * copy])
    through = turn_of(motion, there).apply(np.array(motion.velocity)[:, there]) - water
    density = maker.level(6e4, np.linalg.norm(through)) - 20.0 * math.log10(max(distance, 1.0))
    mounted = turn_of(here, lane) * Rotation.from_quat(np.roll(MOUNT.q_body_sensor, -1))
    local = Rotation.from_euler("z", -head).apply(mounted.inv().apply(way))
    level = 10.0 ** (density / 10.0) * GAIN * BEAMS.power(local)
    silent = place[2] > maker.hull_m or level.max() < 1e-3 * 1e-2
    return distance, way, np.zeros(3) if silent else level


def rows(noise: VehicleNoise, count: int) -> tuple[np.ndarray, ...]:
    distance = np.array(noise.distance).reshape(-1, count)
    way = np.array(noise.direction).reshape(3, -1, count)
    return distance, np.moveaxis(way, 0, -1), np.array(noise.level).reshape(len(distance), count, -1)


def test_noise_is_each_sources_own() -> None:
    """Of five vehicles one is out of the water, one too faint, one nearer than a source level says anything; the
    sonar's head turns. A ship of which the hull still touches the water is heard."""
    makers = {"b": source(90.0, 2.0), "c": source(95.0, 2.0), "d": source(80.0, 2.0), "e": source(10.0, 2.0),
              "f": source(99.0, 9.0)}  # fmt: skip
    here = vehicle(0, [[0, 0, -12.0], [4.0, 3.0, -11.0]])
    near = np.array(here.position).T + np.stack([turn_of(here, k).apply(MOUNT.position_m) for k in range(2)])
    places = {"b": [[20, -9, -5.0], [6, 30, -1.0]], "c": [[2, 9, 2.5], [5, 1, 2.1]],
              "d": near + np.array([[0.2, 0.3, -0.1], [5, 4, 3]]),
              "e": [[9, 9, -9.0], [8, 8, -8.0]], "f": [[-30, 5, 4.0], [-3, -40, 9.5]]}  # fmt: skip
    motions = {"a": here} | {name: vehicle(k + 1, p) for k, (name, p) in enumerate(places.items())}
    head = lambda tick: 0.2 * tick - 0.7
    noise = bystanders("all", makers, motions, angle=head).heard(here)
    distance, way, level = rows(noise, 2)
    assert noise.size_key == (4, 8, 24)
    assert np.array(noise.hull).tolist() == [2.0, 2.0, 9.0, 0.0]  # silent sources up to a power of two
    assert np.isinf(distance[3]).all()
    for k, name in enumerate("bdf"):
        for lane, tick in enumerate(TICKS):
            d, w, heard = expected(makers[name], motions[name], here, lane, lane, head(tick))
            assert distance[k, lane] == pytest.approx(d, rel=1e-5)
            assert way[k, lane] == pytest.approx(w, abs=1e-5)
            assert level[k, lane] == pytest.approx(heard, rel=1e-4)
    assert (level[2, 1] == 0.0).all()
    assert (level[2, 0] > 0.0).all()
    assert bystanders("all", {"c": makers["c"], "e": makers["e"]}, motions).heard(here) is None


@pytest.mark.parametrize("which", ["all", "others", "own"])
def test_members_of_a_group_are_deaf_to_whom_the_key_leaves_out(which: str) -> None:
    """Two vehicles in two copies, two ticks: each hears the same tick and copy of the others."""
    makers = {"a0": source(90.0, 2.0), "a1": source(93.0, 2.0), "b": source(96.0, 2.0)}
    rng = np.random.default_rng(8)
    motions = {name: vehicle(k, rng.uniform([-30, -30, -20], [30, 30, -5], (4, 3))) for k, name in enumerate(makers)}
    of = lambda name: [
        np.array(motions[name].position).T.reshape(2, 2, 3),
        np.array(motions[name].attitude).T.reshape(2, 2, 4),
    ]
    both = [np.concatenate([of(n)[k] for n in ("a0", "a1")], axis=1).reshape(8, -1) for k in range(2)]
    here = lanes(TICKS, dt_ns=DT_NS, environments=range(4), position=both[0], attitude=both[1])
    path = BatchPath.of(("a0.s", "a1.s"), range(2))
    if which == "own":
        with pytest.warns(ValidityWarning, match="leaves out the noise of b$"):
            made = bystanders(which, makers, motions, path)
    else:
        made = bystanders(which, makers, motions, path)
    noise = made.heard(here)
    assert noise.size_key[0] == (2 if which == "own" else 4)
    distance, _, level = rows(noise, 8)
    for k, name in enumerate(["a0", "a1"] if which == "own" else list(makers)):
        for lane in range(8):
            tick, carrier, copy = lane // 4, lane // 2 % 2, lane % 2
            d, _, heard = expected(makers[name], motions[name], here, lane, tick * 2 + copy)
            own = name == f"a{carrier}"
            deaf = own if which == "others" else not own if which == "own" else False
            assert distance[k, lane] == pytest.approx(d, rel=1e-5)
            assert level[k, lane] == pytest.approx(0.0 if deaf else heard, rel=1e-4)


def test_whose_noise_is_left_out_is_told() -> None:
    makers = {name: source(90.0, 2.0) for name in "abcdef"}
    with pytest.warns(ValidityWarning, match=r"vehicle_noise 'own' leaves out the noise of b, c, d and more$"):
        assert bystanders("own", makers, {}).some
    with pytest.warns(ValidityWarning, match=r"vehicle_noise 'others' leaves out the noise of a$"):
        assert bystanders("others", makers, {}).some
    with pytest.warns(ValidityWarning, match="leaves out the noise of b$"):
        assert not bystanders("own", {"b": source(90.0, 2.0)}, {}).some


def test_a_head_hears_a_direction_of_the_sensor_frame_as_it_stands() -> None:
    """By tick and beam; a head that has turned by an angle has what is to its left that much less to its left."""
    towards = np.array([0.6, 0.64, 0.48])
    head = lambda tick: 0.05 * tick
    own = Emitter("a.s", MOUNT, BEAMS, 6e4, 1e4, 1e-3, 200.0, 10**8, angle=head)
    motion = vehicle(1, np.zeros((2, 3)))
    found = np.array(own.hears_from(towards.tolist(), motion)).reshape(2, 3)
    for lane, tick in enumerate(TICKS):
        seen = Rotation.from_euler("z", -head(tick)).apply(towards)
        assert found[lane] == pytest.approx(BEAMS.power(seen), rel=1e-5)
    fixed = np.array(replace(own, angle=None).hears_from(towards.tolist(), motion)).reshape(2, 3)
    assert fixed == pytest.approx(np.tile(BEAMS.power(towards), (2, 1)), rel=1e-5)
