"""Ranges and bearings of instruments from given first paths: errors, limits and what is not heard, without water."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.sensors import noise
from pelagos.sensors.comms.hydrophone import PingerConfig, _silent
from pelagos.sensors.comms.lbl import Lbl, LblConfig
from pelagos.sensors.comms.link.transponders import FirstPaths
from pelagos.sensors.comms.range_bearing import RangeBearing, RangeBearingConfig
from pelagos.sensors.example_motion import lanes

DT_NS = 50_000_000
ERRORS = ("range_noise_m", "azimuth_noise_rad", "elevation_noise_rad")
LANES = 1000


class Known:
    """Paths that are known, alike for all lanes but in their places."""

    def __init__(self, time: Any, loss: Any, speed: Any, direction: Any, places: Any) -> None:
        self.given = time, loss, direction, speed, places
        self.fixed = np.asarray(places, float)

    def __len__(self) -> int:
        return len(self.fixed)

    def listen(self, paths: Any, position: Any, t: Any, copy: Any) -> FirstPaths:
        """See `Transponders`."""
        return FirstPaths(*(np.repeat(np.asarray(v, float)[None], len(position), axis=0) for v in self.given))


def instrument(kind: Any, config: Any, known: Known, noise_db: float) -> Any:
    """One whose water is left out."""
    made = kind.__new__(kind)
    made.__dict__.update(
        _config=config, _paths=None, _transponders=known, _targets=known, _noise_db=noise_db,
        _key=noise.opaque_key(noise.stream_key(3, "a.x", "time")),
        _sigma=np.array([getattr(config, name, 0.0) for name in ERRORS]),
    )  # fmt: skip
    return made


def moved(count: int = LANES, **keys: Any) -> Any:
    return lanes([9], dt_ns=DT_NS, environments=range(count), **keys)


@pytest.mark.parametrize("one_way", [False, True])
@pytest.mark.parametrize("told", [None, 1530.0])
def test_an_lbl_range_errs_by_its_detections_and_one_turnaround(one_way: bool, told: float | None) -> None:
    """There and back two detections and one turn-around, of half of which a range is made; E/N0 behind the filter.

    Heard: 20 dB. Then 0.1 dB above and below detection, beyond the longest range, and no path at all.
    """
    config = LblConfig(
        transponders={str(k): {"position_m": (k, 0, 0)} for k in range(5)}, one_way=one_way, sound_speed_mps=told,
        source_level_db=180.0, detection_db=8.0, bandwidth_hz=3000.0, pulse_s=0.02, turnaround_error_s=2e-5,
        range_max_m=1000.0,
    )  # fmt: skip
    time, speed = np.array([0.4, 0.3, 0.2, 0.72, np.nan]), np.array([1480.0, 1470, 1460, 1490, 1450])
    loss = 180.0 - 60.0 - np.array([20.0, 8.1, 7.9, 20.0, np.nan])
    places = np.array([[300.0, 400, -20], [10, 0, 0], [0, 10, 0], [1, 2, 3], [4, 5, 6]])
    found = instrument(Lbl, config, Known(time, loss, speed, np.zeros((5, 3)), places), 60.0).sense(
        moved(position=(60.0, -40.0, -30.0))
    )
    assert np.isfinite(found.data).all(axis=0).tolist() == [True, True, False, False, False]
    assert found.data[:, 0].mean() == pytest.approx(0.4 * (told or 1480.0), abs=0.04)
    assert found.data[:, 1].mean() == pytest.approx(0.3 * (told or 1470.0), abs=0.04)
    ways = 1 if one_way else 2
    for k, db in ((0, 20.0), (1, 8.1)):
        rms = 3000.0 / math.sqrt(12)
        detection = 1 / (2 * math.pi * rms * math.sqrt(2 * 10 ** (db / 10)))
        sigma = (told or speed[k]) / ways * math.sqrt(ways * detection**2 + 2e-5**2)
        assert found.data[:, k].std() == pytest.approx(sigma, rel=4 / math.sqrt(2 * LANES))
    assert abs(np.corrcoef(found.data[:, 0], found.data[:, 1])[0, 1]) < 4 / math.sqrt(LANES)
    np.testing.assert_allclose(found.truth[7, :2], [np.sqrt(240**2 + 440**2 + 100), np.sqrt(50**2 + 40**2 + 900)])
    assert found.extras["snr_db"][3] == pytest.approx([20.0, 8.1, 7.9, 20.0, np.nan], nan_ok=True)
    assert found.valid is not None
    assert found.valid.all()


def test_an_lbl_that_hears_nothing_has_no_reading() -> None:
    config = LblConfig(transponders={"p": {"position_m": (1, 0, 0)}}, detection_db=10.0)
    known = Known([0.1], [188.0 - 60.0 - 9.9], [1480.0], np.zeros((1, 3)), [[1, 2, 3]])
    assert not instrument(Lbl, config, known, 60.0).sense(moved(4)).valid.any()


MOUNT = {"position_m": (0.4, -0.3, 0.2), "orientation_deg": (20.0, -35.0, 110.0)}


def test_a_bearing_is_that_of_the_ray_in_the_turned_sensors_frame() -> None:
    """Vehicle and sensor both turned, rays from elsewhere than the straight ways; without noise, by scipy."""
    body = Rotation.from_euler("ZYX", [70.0, 25.0, -50.0], degrees=True)
    own = Rotation.from_euler("ZYX", [110.0, -35.0, 20.0], degrees=True)
    config = RangeBearingConfig(
        targets={str(k): {"position_m": (k, 0, 0)} for k in range(3)}, range_noise_m=0.0, azimuth_noise_rad=0.0,
        elevation_noise_rad=0.0, source_level_db=150.0, **MOUNT,
    )  # fmt: skip
    rays = Rotation.from_rotvec([[0.1, 0.4, -2.0], [1.3, -0.2, 0.7], [-0.6, 0.8, 0.1]]).apply([1.0, 0, 0])
    places = np.array([[90.0, -60, -5], [-30, 20, -50], [14, 35, -22]])
    known = Known([0.05, 0.04, 0.03], [60.0, 61, 62], [1480.0, 1490, 1500], rays, places)
    found = instrument(RangeBearing, config, known, 50.0).sense(
        moved(2, position=(3.0, 4.0, -15.0), attitude=[(1.0, 0.0, 0.0, 0.0), tuple(body.as_quat()[[3, 0, 1, 2]])])
    )

    def told(ways: np.ndarray) -> np.ndarray:
        x, y, z = (body * own).inv().apply(ways).T
        return np.stack([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))], axis=-1)

    np.testing.assert_allclose(found.data[1, :, 0], [74.0, 59.6, 45.0])
    np.testing.assert_allclose(found.data[1, :, 1:], told(rays), atol=1e-12)
    np.testing.assert_allclose(found.data[0, :, 1:], told(body.apply(rays)), atol=1e-12)
    way = places - [3.0, 4.0, -15.0] - body.apply(MOUNT["position_m"])
    np.testing.assert_allclose(found.truth[1, :, 0], np.linalg.norm(way, axis=-1))
    np.testing.assert_allclose(found.truth[1, :, 1:], told(way), atol=1e-12)
    assert found.extras["snr_db"][0] == pytest.approx([40.0, 39.0, 38.0])


def test_errors_of_range_and_bearing_stay_within_what_they_can_be() -> None:
    """Unequal for range, azimuth and elevation; astern azimuths go round, above elevations end at the zenith, ranges
    at zero. A target that is too far by its own range, one too weak, and one without a path are not heard."""
    config = RangeBearingConfig(
        targets={str(k): {"position_m": (k, 0, 0)} for k in range(6)}, range_noise_m=5.0, azimuth_noise_rad=0.04,
        elevation_noise_rad=0.015, source_level_db=150.0, detection_db=5.0, range_max_m=700.0, sound_speed_mps=1550.0,
    )  # fmt: skip
    astern, above = [-1.0, 0.01, 0.0], [1e-3, 0.0, 1.0]
    rays = np.array([[0.8, -0.6, 0.0], astern, above, [1.0, 0, 0], [1.0, 0, 0], [np.nan] * 3])
    loss = 150.0 - 60.0 - np.array([20.0, 20, 20, 20, 4.9, np.nan])
    known = Known([0.2, 0.1, 1e-3, 0.46, 0.1, np.nan], loss, [1480.0] * 6, rays, np.ones((6, 3)))
    found = instrument(RangeBearing, config, known, 60.0).sense(moved())
    data = found.data
    assert np.isfinite(data).all(axis=(0, 2)).tolist() == [True, True, True, False, False, False]
    spread = 4 / math.sqrt(2 * LANES)
    assert data[:, 0].std(axis=0) == pytest.approx([5.0, 0.04, 0.015], rel=spread)
    assert data[:, 0].mean(axis=0) == pytest.approx([310.0, math.atan2(-0.6, 0.8), 0.0], abs=0.6)
    assert np.abs(np.corrcoef(data[:, 0].T) - np.eye(3)).max() < 4 / math.sqrt(LANES)
    azimuth = data[:, 1, 1]
    assert azimuth.min() < -3.0 < 3.0 < azimuth.max() < math.pi
    around = np.mod(azimuth, 2 * math.pi)
    assert around.mean() == pytest.approx(math.pi - 0.01, abs=4 * 0.04 / math.sqrt(LANES))
    assert around.std() == pytest.approx(0.04, rel=spread)
    assert data[:, 2, 2].max() == pytest.approx(0.5 * math.pi)
    assert data[:, 2, 2].min() == pytest.approx(0.5 * math.pi - 3.3 * 0.015, abs=0.02)
    assert data[:, 2, 0].min() == 0.0
    assert (data[:, 2, 0] > 0).mean() == pytest.approx(0.62, abs=0.05)  # 1.55 m of 5 m above zero
    assert found.valid.all()


@pytest.mark.parametrize(
    ("span", "silent"),
    [((-0.3, -0.01), True), ((-3.0, -0.01), True),
     ((-0.3, 0.0), False), ((0.0, 0.01), False), ((0.0899, 0.2), False), ((0.0901, 0.2), True),
     ((0.1, 1.99), True), ((0.1, 2.0), False), ((4.05, 4.06), False), ((4.0901, 5.9), True), ((0.1, 7.0), False)],
)  # fmt: skip
def test_no_pulse_lies_between_two_times(span: tuple[float, float], silent: bool) -> None:
    """Of 90 ms every 2 s, the first from 0 on."""
    pinger = PingerConfig(position_m=(0, 0, -5), pulse_s=0.09, period_s=2.0)
    assert _silent(pinger, np.array(span)) == silent
