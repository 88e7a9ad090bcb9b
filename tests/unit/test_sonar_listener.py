"""How a sonar hears one direction: by which beam, through which pattern, at which range, from whose pulse."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.sensors.sonar.ping.aperture import Aperture, round_aperture
from pelagos.sensors.sonar.ping.fan import steered_directions
from pelagos.sensors.sonar.ping.levels import disturbance
from pelagos.sensors.sonar.ping.listener import Hearing, Listener
from pelagos.sensors.sonar.ping.ping_spec import Disturber
from pelagos.sensors.sonar.ping.targets import _quaternion

WATER = np.array([1470.0, 1525.0])
TURN = Rotation.random(2, random_state=9)
VELOCITY = np.array([[1.4, -0.6, 0.3], [-2.0, 0.5, 0.9]])


def device(rows: np.ndarray, kind: Any = jit.Array3f) -> Any:
    return kind(np.ascontiguousarray(np.asarray(rows).T))


def lanes() -> Any:
    return SimpleNamespace(
        attitude=device(np.roll(TURN.as_quat(), 1, axis=1), jit.Array4f64), profile=None, around=None,
        medium=SimpleNamespace(sound_speed=jit.Float(WATER), absorption=jit.Float([0.03, 0.05])),
    )  # fmt: skip


def listener(aperture: Aperture, **more: Any) -> Listener:
    keys: dict[str, Any] = {"rays_per_sr": 1e3, "wave_cycles": 2e5, "wavelength": 0.015, "reach": 90.0,
                            "coupling_s": 0.05, "doppler": True}  # fmt: skip
    hearing = Hearing(aperture, len(aperture.axis), **(keys | more))
    return Listener(lanes(), aperture.facing(), hearing, device(VELOCITY, jit.Array3f64))


def array(angles_deg: list[float], **more: Any) -> Aperture:
    """A line along y that steers beams in the plane of x and y."""
    a = np.radians(angles_deg)
    axis = np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=-1)
    return Aperture(axis, np.eye(3)[1], np.eye(3)[2], 20.0, 4.0, steered=True, **more)


def around(count: int = 400, seed: int = 1) -> np.ndarray:
    way = np.random.default_rng(seed).normal(size=(count, 3))
    return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True))


@pytest.mark.parametrize("ways", [1, 2])
def test_a_direction_belongs_to_the_sector_that_it_lies_in(ways: int) -> None:
    """Beams at 40, 25, 5 and -30 deg: edges half way, and as far outside of the outermost as inside; the pattern that
    is no array's is the fan's, and nothing where it comes from behind."""
    angles = [40.0, 25.0, 5.0, -30.0]
    way = around()
    beam, power = (np.array(v) for v in listener(array(angles, ways=ways)).sector(device(way)))
    azimuth = np.degrees(np.arctan2(way[:, 1], way[:, 0]))
    edges = [47.5, 32.5, 15.0, -12.5, -47.5]
    expected = np.full(len(way), 4)
    for k in range(4):
        expected[(azimuth <= edges[k]) & (azimuth > edges[k + 1])] = k
    assert (beam == expected).all()
    axis = array(angles).axis[np.minimum(expected, 3)]
    fan = np.where((way * axis).sum(axis=1) > -0.2, np.sinc(4.0 * way[:, 2]) ** (2 * ways), 0.0)
    assert power == pytest.approx(fan, abs=1e-5)


def test_a_single_beam_hears_all_around() -> None:
    beam, _ = listener(array([10.0])).sector(device(around()))
    assert (np.array(beam) == 0).all()


def test_cones_hear_what_is_nearest_to_their_axes_through_both_ways() -> None:
    axes = around(5, 3)
    cones = round_aperture(axes, math.radians(20.0))
    way = around(300, 4)
    beam, power = (np.array(v) for v in listener(cones).sector(device(way)))
    ahead = way @ axes.T
    assert (beam == ahead.argmax(axis=1)).all()
    length = 0.8858929413789 / (2 * math.sin(math.radians(10.0)))
    best = ahead.max(axis=1)
    expected = np.where(best > -0.2, np.sinc(length * np.sqrt(1 - best**2)) ** 4, 0.0)
    assert power == pytest.approx(expected, abs=2e-5)


def test_transducers_fill_their_nulls_and_hear_that_alone_behind() -> None:
    """(sinc^2 + f)/(1 + f) before, f/(1 + f) behind; both ways squared, times that along the array."""
    axis, side, up = (np.tile(v, (2, 1)) for v in np.eye(3))
    axis[1], side[1] = -axis[1], -side[1]
    sides = Aperture(axis, side, up, 3.0, 2.0, floor=0.05)
    hears, way = listener(sides), around(200, 7)
    beam, power = (np.array(v) for v in hears.sector(device(way)))
    assert (beam == np.where(way[:, 0] > 0, 0, 1)).all()
    up_way = (np.sinc(2.0 * way[:, 2]) ** 2 + 0.05) / 1.05
    assert power == pytest.approx(up_way**2 * np.sinc(3.0 * way[:, 1]) ** 4, abs=1e-5)
    first = np.array(sides.one_way_up(sides.facing(), jit.UInt32(np.zeros(200)), device(way)))
    assert first == pytest.approx(np.where(way[:, 0] > 0, up_way, 0.05 / 1.05), abs=1e-5)


@pytest.mark.parametrize("assumed", [None, 1600.0])
def test_an_array_takes_directions_by_the_sound_speed_that_it_assumes(assumed: float | None) -> None:
    """sin a c'/c in place of sin a; what lies beyond looks square to it."""
    way, lane = around(200, 5), np.arange(200) % 2
    hears = listener(array([30.0, 0.0]), assumed_speed=assumed)
    found = np.array(hears.apparent(device(way), jit.UInt32(lane))).T
    local = np.stack([TURN[k].inv().apply(w) for k, w in zip(lane, way, strict=True)])
    if assumed is None:
        assert found == pytest.approx(local, abs=1e-5)
        return
    left = np.clip(local[:, 1] * assumed / WATER[lane], -1, 1)
    rest = np.sqrt((1 - left**2) / (1 - local[:, 1] ** 2))
    assert found == pytest.approx(np.stack([local[:, 0] * rest, left, local[:, 2] * rest], axis=-1), abs=2e-4)
    cones = listener(round_aperture(around(2, 8), 0.3), assumed_speed=assumed)
    assert pytest.approx(local, abs=1e-5) == np.array(cones.apparent(device(way), jit.UInt32(lane))).T


def test_beams_that_are_steered_for_other_water_keep_their_height_over_the_arrays_cone() -> None:
    way = around(50, 2)
    found = np.array(steered_directions(device(way), jit.Float(0.93))).T
    assert np.linalg.norm(found, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert found[:, 1] == pytest.approx(0.93 * way[:, 1], abs=1e-6)
    assert np.arctan2(found[:, 2], found[:, 0]) == pytest.approx(np.arctan2(way[:, 2], way[:, 0]), abs=1e-5)


@pytest.mark.parametrize("keys", [{}, {"assumed_speed": 1500.0}, {"doppler": False}])
def test_an_echos_range_is_what_its_time_means(keys: dict[str, Any]) -> None:
    """r c'/c (1 - v/c) less the coupling, v the closing speed of both."""
    way, lane = around(30, 6), np.arange(30) % 2
    other, reach = np.random.default_rng(5).normal(size=(30, 3)), np.linspace(3.0, 80.0, 30)
    hears = listener(array([30.0, 0.0]), **keys)
    found = np.array(hears.measured_range(jit.Float(reach), jit.UInt32(lane), device(other), device(way)))
    closing = ((VELOCITY[lane] - other) * way).sum(axis=1)
    expected = reach * (keys["assumed_speed"] / WATER[lane] if "assumed_speed" in keys else 1.0)
    if keys.get("doppler", True):
        expected = expected * (1 - closing / WATER[lane]) - 0.05 * closing
    assert found == pytest.approx(expected, rel=1e-5)


def test_another_sonars_pulse_is_in_the_bins_of_its_time() -> None:
    """It pings by a clock of its own from t = 0 on, at 9 Hz for 4 ms, 37 m away: levels less 20 log r and absorption
    one way; of the second lane later and in other water."""
    other: Any = Disturber(9.0, (1.0, 0.0, 0.0), 37.0, 211.0, 0.004)
    spec: Any = SimpleNamespace(source_level_db=203.0)
    t_ns = np.array([40_000_000, 3_276_000_000], np.uint64)
    distance = np.tile(np.linspace(0.2, 160.0, 4000), 2)
    ping = np.repeat([0, 1], 4000)
    cells: Any = SimpleNamespace(ping=jit.Int32(ping), distance=jit.Float(distance))
    moment: Any = SimpleNamespace(lanes=lanes(), t_ns=jit.UInt64(t_ns))
    found = np.array(disturbance(other, spec, cells, moment))
    now = t_ns[ping] * 1e-9 + 2 * distance / WATER[ping]
    arrivals = np.arange(-3, 60)[:, None] / 9.0 + 37.0 / WATER[ping]
    since = np.min(np.where(now >= arrivals, now - arrivals, np.inf), axis=0)
    sure = np.abs(since - 0.004) > 2e-5
    sure &= since > 2e-5
    heard = since < 0.004
    assert {bool(h) for h in heard[:4000]} == {bool(h) for h in heard[4000:]} == {True, False}
    level = 10.0 ** ((211.0 - 203.0 - np.array([0.03, 0.05])[ping] * 37.0) / 10) / 37.0**2
    assert found[sure] == pytest.approx(np.where(heard, level, 0.0)[sure], rel=1e-3)


def test_axes_become_the_quaternion_that_turns_to_them() -> None:
    """Whichever component is largest: small turns, and half turns about x, y and z."""
    for vector in (
        [0.2, -0.1, 0.3],
        [3.0, 0.3, -0.2],
        [0.4, 2.9, 0.5],
        [-0.3, 0.2, 3.1],
        [1.6, 1.7, 1.5],
        [-2.0, 1.0, 2.0],
    ):
        turn = Rotation.from_rotvec(vector)
        found = _quaternion(turn.as_matrix())
        assert np.linalg.norm(found) == pytest.approx(1.0)
        assert Rotation.from_quat(np.roll(found, -1)).as_matrix() == pytest.approx(turn.as_matrix(), abs=1e-9)


def test_a_steered_beam_falls_off_by_the_difference_of_sines() -> None:
    """One way by the shaded line along y; its sign, which tells side lobes of an array, is kept."""
    aperture, way = array([35.0, -20.0], shading="light"), around(60, 3)
    for beam, sine in enumerate(np.sin(np.radians([35.0, -20.0]))):
        found = np.array(aperture.side_amplitude(aperture.facing(), jit.UInt32(np.full(60, beam)), device(way)))
        u = 20.0 * (way[:, 1] - sine)
        line = 0.75 * np.sinc(u) + 0.125 * (np.sinc(u - 1.0) + np.sinc(u + 1.0))
        assert found == pytest.approx(line / 0.75, abs=2e-5)
