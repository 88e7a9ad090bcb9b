"""What Doppler sonars measure of the water on lanes of two copies, whose seas are not the same, at two moments."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.hydro.bed_load import threshold
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.noise import opaque_key, stream_key
from pelagos.sensors.sonar.adcp import AdcpConfig, profile
from pelagos.sensors.sonar.dvl import DvlConfig, carried_bed, water_track

DT_NS = 250_000_000
TICKS, COPIES = np.repeat([2, 7], 2), np.tile([0, 1], 2)
PLACE = np.array([[1.0, 2.0, -30.0], [-4.0, 9.0, -41.0], [20.0, -3.0, -35.0], [7.0, 7.0, -52.0]])
EULER = np.array([[0.3, 0.1, -0.15], [-2.0, -0.12, 0.06], [1.1, 0.05, 0.2], [2.8, -0.02, -0.1]])
TURN = Rotation.from_euler("ZYX", EULER)
MOVES = np.array([[1.0, -0.3, 0.1], [0.2, 0.6, -0.2], [-0.7, 0.1, 0.3], [0.4, -0.4, 0.0]])
SPEED = np.array([1480.0, 1515.0, 1500.0, 1462.0])
KEY: Any = opaque_key(stream_key(5, "a.it", "noise"))


def flow(x: Any, y: Any, z: Any, t: Any, copy: Any) -> tuple[Any, Any, Any]:
    return (
        0.3 + 0.9 * copy + 0.05 * t + 0.011 * z + 0.004 * x,
        -0.2 + 0.4 * copy - 0.03 * t - 0.007 * z + 0.006 * y,
        0.01 * copy + 0.001 * x - 0.002 * z,
    )


class Sea:
    """Another one in each copy."""

    def current(self, at: Any, t: Any, copy: Any) -> Any:
        return jit.Array3f64(*flow(at.x, at.y, at.z, t, jit.Float64(copy)))


def water(places: np.ndarray) -> np.ndarray:
    """`(4, 3)` at a place of each lane."""
    return np.stack(flow(*places.T, TICKS * DT_NS * 1e-9, COPIES), axis=-1)


def scene(wet: Any = True) -> tuple[Any, Any, Any]:
    """Lanes, motion and velocity in the sensor frame, on the device."""
    quaternion = TURN.as_quat()[:, [3, 0, 1, 2]]
    motion = lanes([2, 7], dt_ns=DT_NS, environments=(3, 8), position=PLACE, attitude=quaternion)
    here = SimpleNamespace(
        position=motion.position, attitude=motion.attitude, medium=SimpleNamespace(sound_speed=jit.Float(SPEED)),
        wet=jit.Bool(np.broadcast_to(wet, 4)),
    )  # fmt: skip
    return here, motion, jit.Array3f64(np.ascontiguousarray(MOVES.T))


def through(beams: np.ndarray, reach: np.ndarray, sign: float) -> np.ndarray:
    """Least squares of the water's speeds over the sensor's along four beams, `reach` from each lane."""
    there = [PLACE + reach[:, None] * TURN.apply(np.tile(b, (4, 1))) for b in beams]
    along = np.stack([sign * (TURN.inv().apply(water(p)) - MOVES) @ b for p, b in zip(there, beams, strict=True)])
    return np.asarray(np.linalg.lstsq(beams, along, rcond=None)[0].T)


@pytest.mark.parametrize("assumed", [None, 1530.0])
def test_cells_of_a_profile_lie_where_their_time_says_in_each_copys_water(assumed: float | None) -> None:
    """On beams: a row of cells a lane, at distances and speeds that the assumed sound speed makes of times and shifts;
    on the axis the truth, where the cell is said to be. Nothing in the air, nor beyond what the nearest beam meets."""
    config = AdcpConfig(
        cells=3, cell_m=2.5, blank_m=1.5, noise_mps=0.0, sound_speed_mps=assumed, beam_tilt_deg=27.0,
        beam_azimuth_deg=(10.0, 110.0, -160.0, -50.0),
    )  # fmt: skip
    wet = np.array([True, True, False, True])
    here, motion, velocity = scene(wet)
    free = np.full((4, 4), np.inf)
    free[2, 1] = 10.2  # by beam and lane
    cells = profile(config, [jit.Float(f) for f in free], here, velocity, motion, Sea(), KEY)  # type: ignore[arg-type]
    ratio = (assumed or SPEED) / SPEED
    cosine = math.cos(math.radians(27.0))
    for k, (data, truth, valid) in enumerate(cells):
        depth = 1.5 + (k + 0.5) * 2.5
        heard = wet & (free.min(axis=0) * cosine > (depth + 1.25) / cosine / ratio)
        assert np.array(valid).tolist() == heard.tolist()
        expected = through(config.beams, depth / cosine / ratio, 1.0) * ratio[:, None]
        np.testing.assert_allclose(np.array(data).T[heard], expected[heard], atol=1e-6)
        place = PLACE + TURN.apply([[0.0, 0.0, -depth]] * 4)
        np.testing.assert_allclose(np.array(truth).T, TURN.inv().apply(water(place)) - MOVES, atol=1e-9)
    assert [int(np.array(c[2]).sum()) for c in cells] == [3, 3, 2]


def test_noise_of_cells_and_beams_is_of_their_own() -> None:
    """In 800 pings no component of a cell tells of another cell's: correlations within 4.5 standard errors."""
    config = AdcpConfig(cells=4, noise_mps=0.02)
    motion = lanes(range(800), dt_ns=DT_NS)
    here = SimpleNamespace(
        position=motion.position,
        attitude=motion.attitude,
        wet=None,
        medium=SimpleNamespace(sound_speed=jit.Float(1500.0)),
    )
    still = SimpleNamespace(current=lambda at, t, copy: jit.Array3f64(0.0 * at.x, 0.0, 0.0))
    free = [jit.Float(np.full(800, 200.0))] * 4
    cells: Any = profile(config, free, here, jit.Array3f64(0.0), motion, still, KEY)  # type: ignore[arg-type]
    errors = np.concatenate([np.array(c[0]) for c in cells])
    related = np.corrcoef(errors)
    apart = np.kron(np.eye(4), np.ones((3, 3))) == 0
    assert np.abs(related[apart]).max() < 4.5 / math.sqrt(800)
    assert np.abs(related[~apart & ~np.eye(12, dtype=bool)]).max() < 4.5 / math.sqrt(800)  # by the beams' symmetry


@pytest.mark.parametrize("assumed", [None, 1530.0])
def test_water_track_is_of_the_layer_in_each_copys_water(assumed: float | None) -> None:
    """Of the sensor through the water, by a scale that is 2 % off."""
    config = DvlConfig(
        water_layer_m=6.0, noise_mps=0.0, noise_relative=0.0, scale_error=0.02, sound_speed_mps=assumed,
        beam_tilt_deg=24.0, beam_azimuth_deg=(10.0, 110.0, -160.0, -50.0),
    )  # fmt: skip
    wet = np.array([True, False, True, True])
    here, motion, velocity = scene(wet)
    free = [jit.Float(np.full(4, 50.0)) for _ in range(4)]
    found = np.array(water_track(config, free, here, velocity, motion, Sea(), KEY)).T  # type: ignore[arg-type]
    ratio = (assumed or SPEED) / SPEED
    expected = through(config.beams, 6.0 / math.cos(math.radians(24.0)) / ratio, -1.0) * 1.02 * ratio[:, None]
    np.testing.assert_allclose(found[wet], expected[wet], atol=1e-6)
    assert np.isnan(found[~wet]).all()


@pytest.mark.parametrize("beam", range(4))
def test_grains_are_carried_by_the_current_where_a_beam_meets_the_bed(beam: int) -> None:
    """Level, along the current a metre above the place, in each copy's water: 1.5 T^0.6 ((s - 1) g d)^(1/2)."""
    config, grain = DvlConfig(bed_grain_mm=0.4, beam_azimuth_deg=(10.0, 110.0, -160.0, -50.0)), 0.4e-3
    here, motion, _ = scene()
    distance = np.array([12.0, 15.0, 9.0, 22.0])
    found = np.array(carried_bed(config, here, beam, jit.Float(distance), motion, Sea()))  # type: ignore[arg-type]
    axis = config.beams[beam]
    place = PLACE + distance[:, None] * TURN.apply(np.tile(axis, (4, 1))) + [0.0, 0.0, 1.0]
    level = water(place) * [1.0, 1.0, 0.0]
    size = np.linalg.norm(level, axis=1)
    stage = np.maximum((size * 0.4 / math.log(12.0 / grain) / threshold(grain)) ** 2 - 1, 0.0)
    grains = 1.5 * np.sqrt(1.65 * 9.81 * grain) * stage**0.6
    assert (grains > 0.01).sum() >= 2
    expected = TURN.inv().apply(level / size[:, None] * grains[:, None]) @ axis
    np.testing.assert_allclose(found, expected, atol=2e-5)
