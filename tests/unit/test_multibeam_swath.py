"""Beams of a moving multibeam by themselves: sectors, course, cones that cross, times that shift ranges."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.acoustics.mills_cross import aberration, crossing, turned
from pelagos.sensors.sonar.ping.swath import (
    Swath,
    attitudes_heard,
    axes_heard,
    delay_ranges,
    motion_of,
    sectors_of,
    steering,
)

TURN = Rotation.from_euler("ZYX", [[0.7, -0.06, 0.09], [-2.1, 0.08, -0.05]])
Q = np.roll(TURN.as_quat(), 1, axis=1)
VELOCITY = np.array([[2.0, -0.7, 0.3], [-1.1, 0.9, 0.4]])  # in the sensor frame
SPIN = np.array([[0.1, -0.2, 0.15], [-0.12, 0.07, 0.2]])
ANGLES = np.radians([55.0, 20.0, -15.0, -50.0])
WATER = np.array([1480.0, 1515.0])


def device(rows: np.ndarray, kind: Any) -> Any:
    return kind(np.ascontiguousarray(np.asarray(rows).T))


def lanes() -> Any:
    medium = SimpleNamespace(sound_speed=jit.Float(WATER))
    return SimpleNamespace(attitude=device(Q, jit.Array4f64), medium=medium, position=jit.Array3f64(np.zeros((3, 2))))


def fan(rays: int) -> Any:
    """Axes in the plane across the track, tilted 0.02 ahead; other rays beside them."""
    axis = np.stack([0.02 + 0 * ANGLES, np.sin(ANGLES), -np.cos(ANGLES)], axis=-1)
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    return SimpleNamespace(
        direction=device(
            np.repeat(axis, rays, axis=0)
            + np.tile(np.eye(3)[0] * 0.3, (4 * rays, 1)) * (np.arange(4 * rays) % rays != rays // 2)[:, None],
            jit.Array3f,
        )
    ), axis


def swath(**more: Any) -> Swath:
    keys: dict[str, Any] = {"beams": 4, "rays": 3, "moves": True, "held": (), "assumed_speed": None, "coupling_s": 0.0}
    return Swath(**(keys | more))


def test_sectors_are_equal_parts_of_the_swath_and_each_has_its_own_loss() -> None:
    """From 60 to -50 deg in three: edges at 60, 23.3, -13.3 and -50 deg, middles at 41.7, 5 and -31.7 deg."""
    made = sectors_of(np.radians([60.0, 35.0, 15.0, -5.0, -25.0, -50.0]), 3, np.array([0.8, 1.0, 1.3]))
    middle = np.radians([125 / 3, 125 / 3, 5.0, 5.0, -95 / 3, -95 / 3])
    assert np.array(made.sine) == pytest.approx(np.sin(middle), abs=1e-6)
    assert np.array(made.cosine) == pytest.approx(np.cos(middle), abs=1e-6)
    assert np.array(made.loss) == pytest.approx([0.8, 0.8, 1.0, 1.0, 1.3, 1.3])


def test_a_course_is_over_ground_and_level_and_a_heading_where_there_is_none() -> None:
    """From 0.3 m/s level on; how fast it sinks does not count."""
    along = TURN.apply([1.0, 0.0, 0.0])
    for speeds, under_way in (([0.32, 0.31], True), ([0.28, 0.29], False)):
        level = np.array([[-0.6, 0.8, 0.0], [0.28, -0.96, 0.0]]) * np.array(speeds)[:, None]
        ground = level + np.array([[0, 0, -0.9], [0, 0, 0.5]])
        found = motion_of(lanes(), device(TURN.inv().apply(ground), jit.Array3f64), device(SPIN, jit.Array3f64))
        course = level if under_way else along * [1, 1, 0]
        course = course / np.linalg.norm(course, axis=1, keepdims=True)
        assert pytest.approx(course, abs=1e-6) == np.array(found.course).T
        assert pytest.approx(ground, abs=1e-6) == np.array(found.velocity).T
        assert pytest.approx(TURN.apply(SPIN), abs=1e-6) == np.array(found.spin).T
        assert pytest.approx(along, abs=1e-6) == np.array(found.ahead).T
        assert pytest.approx(TURN.apply([0.0, 1.0, 0.0]), abs=1e-6) == np.array(found.left).T


def test_where_two_cones_cross_both_angles_are_kept() -> None:
    rng = np.random.default_rng(4)
    sender = Rotation.random(40, random_state=6).as_matrix()[:, :, 0]
    receiver = np.cross(sender, rng.normal(size=(40, 3))) + 0.3 * sender
    receiver /= np.linalg.norm(receiver, axis=1, keepdims=True)
    sent, heard = rng.uniform(-0.3, 0.3, 40), rng.uniform(-0.7, 0.7, 40)
    found = np.array(
        crossing(device(sender, jit.Array3f), device(receiver, jit.Array3f), jit.Float(sent), jit.Float(heard))
    ).T
    assert np.linalg.norm(found, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert (found * sender).sum(axis=1) == pytest.approx(sent, abs=1e-5)
    assert (found * receiver).sum(axis=1) == pytest.approx(heard, abs=1e-5)
    assert (np.einsum("ki,ki->k", found, np.cross(receiver, sender)) > 0.0).all()


@pytest.mark.parametrize("angle", [1e-5, 0.3, 2.5])
def test_a_vector_turns_as_its_rotation_says(angle: float) -> None:
    axis, vector = np.array([0.48, -0.6, 0.64]), np.array([0.3, 0.9, -0.5])
    found = np.array(turned(jit.Array3f(*vector.tolist()), jit.Array3f(*(angle * axis).tolist()))).ravel()
    assert found - vector == pytest.approx(
        Rotation.from_rotvec(angle * axis).apply(vector) - vector, rel=1e-3, abs=3e-7
    )


def test_from_where_the_receiver_has_got_to_a_target_lies_aside() -> None:
    """By places: the target at r d, the receiver after 2 r/c at 2 r v/c; to first order in v/c, 4e-6 here."""
    velocity, way, along, c, r = (
        np.array([2.0, -1.5, 0.7]),
        np.array([0.36, 0.48, -0.8]),
        np.array([0.6, 0.8, 0.0]),
        1500.0,
        90.0,
    )
    back = r * way - velocity * 2 * r / c
    expected = along @ back / np.linalg.norm(back) - along @ way
    found = aberration(*(jit.Array3f(*v.tolist()) for v in (velocity, way, along)), jit.Float(c))
    assert float(found[0]) == pytest.approx(expected, abs=1e-5)
    assert abs(expected) > 4e-4


def test_ranges_are_as_long_as_times_say() -> None:
    """r (1 - v/c) less the chirp's coupling, v the speed at which sounder and target close."""
    moved = motion_of(lanes(), device(VELOCITY, jit.Array3f64), device(SPIN, jit.Array3f64))
    rng = np.random.default_rng(1)
    way, target = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    view = SimpleNamespace(
        of_lane=lambda values: values, hits=SimpleNamespace(velocity=device(target, jit.Array3f)),
        direction=device(way, jit.Array3f),
    )  # fmt: skip
    reach = {"near": [48.0, 97.0], "far": [55.0, 105.0], "distance": [50.0, 100.0]}
    closing = ((TURN.apply(VELOCITY) - target) * way).sum(axis=1)
    for moves in (True, False):
        patches: Any = SimpleNamespace(**{name: jit.Float(v) for name, v in reach.items()})
        delay_ranges(patches, view, lanes(), moved, swath(moves=moves, coupling_s=0.02))
        for name, r in reach.items():
            expected = np.array(r) * (1 - closing / WATER) - 0.02 * closing if moves else np.array(r)
            assert np.array(getattr(patches, name)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("assumed", [None, 1450.0])
def test_a_sounder_places_its_beams_where_times_and_angles_say(assumed: float | None) -> None:
    """From where it sent, the axis lies on the transmitter's cone; from where it has got to after out and home, by the
    sound speed that it takes, on the receiver's as that stands then. To first order in v/c: 1e-5 of the range."""
    rays, axis = fan(3)
    reach = np.array([[70.0, 41.0, 33.0, 60.0], [90.0, 52.0, np.nan, 77.0]])
    moved = motion_of(lanes(), device(VELOCITY, jit.Array3f64), device(SPIN, jit.Array3f64))
    sectors = sectors_of(ANGLES, 1, np.ones(1))
    found = axes_heard(swath(assumed_speed=assumed), sectors, rays, lanes(), moved, jit.Float(reach.ravel()))
    direction, distance, sent = np.array(found[0]).T.reshape(2, 4, 3), *(np.array(v).reshape(2, 4) for v in found[1:])
    for lane in range(2):
        c = WATER[lane] if assumed is None else assumed
        for beam in range(4):
            if np.isnan(reach[lane, beam]):
                assert np.isnan(distance[lane, beam])
                continue
            time = 2 * reach[lane, beam] / c
            ahead = TURN[lane].apply([1.0, 0.0, 0.0])
            spun = Rotation.from_rotvec(TURN[lane].apply(SPIN[lane]) * time) * TURN[lane]
            place = direction[lane, beam] * distance[lane, beam]
            back = place - TURN[lane].apply(VELOCITY[lane]) * time
            home = np.linalg.norm(back)
            assert sent[lane, beam] == pytest.approx(axis[beam, 0], abs=1e-6)
            assert ahead @ direction[lane, beam] == pytest.approx(axis[beam, 0], abs=1e-5)
            assert spun.apply([0.0, 1.0, 0.0]) @ back / home == pytest.approx(axis[beam, 1], abs=2e-5)
            assert distance[lane, beam] + home == pytest.approx(c * time, rel=2e-5)


def test_a_sounder_at_rest_keeps_its_ranges() -> None:
    rays, axis = fan(3)
    moved = motion_of(lanes(), device(VELOCITY, jit.Array3f64), device(SPIN, jit.Array3f64))
    reach = np.linspace(20.0, 55.0, 8)
    found = axes_heard(swath(moves=False), sectors_of(ANGLES, 1, np.ones(1)), rays, lanes(), moved, jit.Float(reach))
    assert np.array(found[1]) == pytest.approx(reach)
    expected = np.concatenate([TURN[lane].apply(axis) for lane in range(2)])
    assert pytest.approx(expected, abs=1e-5) == np.array(found[0]).T


@pytest.mark.parametrize("moves", [True, False])
def test_attitudes_heard_are_those_of_the_echoes_arrivals(moves: bool) -> None:
    """Nothing heard: that of the ping."""
    reach = np.array([70.0, 400.0, 33.0, np.nan, 90.0, 52.0, 700.0, 77.0])
    found = np.array(attitudes_heard(swath(moves=moves), lanes(), device(SPIN, jit.Array3f64), jit.Float(reach))).T
    for row in range(8):
        lane = row // 4
        time = 2 * np.nan_to_num(reach[row]) / WATER[lane] if moves else 0.0
        expected = TURN[lane] * Rotation.from_rotvec(SPIN[lane] * time)
        assert Rotation.from_quat(np.roll(found[row], -1)).as_matrix() == pytest.approx(expected.as_matrix(), abs=1e-4)


def test_held_beams_lie_in_the_plane_of_their_sector() -> None:
    """Pitch and yaw: the plane through the vertical square to the course holds the sector's middle; at most 10 deg."""
    moved = motion_of(lanes(), device(VELOCITY, jit.Array3f64), device(SPIN, jit.Array3f64))
    sectors = sectors_of(ANGLES, 2, np.ones(2))
    middle = np.radians([28.75, 28.75, -23.75, -23.75])  # of 55 to 2.5 and 2.5 to -50 deg
    beam, lane = np.tile(np.arange(4), 2), np.repeat([0, 1], 4)
    axis = np.stack([0.01 + 0 * ANGLES, np.sin(ANGLES), -np.cos(ANGLES)], axis=-1)[beam]
    for held in (("pitch",), ("yaw",), ("pitch", "yaw")):
        sent, heard = steering(
            swath(held=held), sectors, moved, jit.UInt32(lane), jit.UInt32(beam), device(axis, jit.Array3f),
            jit.Float(np.zeros(8)),
        )  # fmt: skip
        assert np.array(heard) == pytest.approx(axis[:, 1], abs=1e-6)
        for row in range(8):
            turn = TURN[lane[row]]
            ahead = turn.apply([1.0, 0.0, 0.0])
            course = turn.apply(VELOCITY[lane[row]]) * [1, 1, 0] if "yaw" in held else ahead * [1, 1, 0]
            course /= np.linalg.norm(course)
            port = np.array([-course[1], course[0], 0.0])
            wanted = 0.01
            wanted += math.sin(middle[beam[row]]) * (port @ ahead) if "yaw" in held else 0.0
            wanted -= math.cos(middle[beam[row]]) * ahead[2] if "pitch" in held else 0.0
            assert np.array(sent)[row] == pytest.approx(np.clip(wanted, -0.174, 0.174), abs=1e-6)
