"""No sensor tells port from starboard but by its sign: the image of a whole scene gives the image of its readings.

Two vehicles, a wall, a mover, currents, wind and water that differ on all axes, and the sensor off every axis of its
vehicle; then all of it in the mirror. What is compared is the truth, of which noise is no part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from mirrored_sea import EVEN, mirrored
from test_every_sensor_key import LINKED, sea, ticks_of

import pelagos as pl
from pelagos.config import registry

POLAR, AXIAL = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
Flip = Callable[[np.ndarray], np.ndarray]


def same(a: np.ndarray) -> np.ndarray:
    return a


def across(a: np.ndarray) -> np.ndarray:
    """Pictures and fans: columns or beams from the other side, the last axis."""
    return a[..., ::-1]


def sides(a: np.ndarray) -> np.ndarray:
    """The second axis the other way round: columns of pictures' vectors, beams of samples, port and starboard."""
    return a[:, ::-1]


SAME = (
    "altimeter", "collision", "ctd", "depth", "fluorometer", "hydrophone", "lbl", "oxygen", "range_finder",
    "singlebeam", "sound_velocity", "tracer", "turbidity",
)  # fmt: skip
VECTORS = ("adcp", "current_meter", "dvl", "gps", "range_bearing", "velocity")
PICTURES = ("depth_camera", "instance_camera", "semantic_camera", "thermal_camera", "multibeam")
SIDES = ("imaging_sonar", "incidence_sonar", "profiling_sonar", "sidescan")
FLIPS: Mapping[str, Flip] = {
    **dict.fromkeys(SAME, same),
    **dict.fromkeys(VECTORS, lambda a: a * POLAR),
    **dict.fromkeys(PICTURES, across),
    **dict.fromkeys(SIDES, sides),
    "camera": lambda a: a[:, :, ::-1],
    "normal_camera": lambda a: a[:, :, ::-1] * POLAR,
    "optical_flow_camera": lambda a: a[:, :, ::-1] * [-1.0, 1.0],
    "pose": lambda a: a * [*POLAR, 1.0, *AXIAL],  # a quaternion turns about an axial vector
    "imu": lambda a: a * [*POLAR, *AXIAL],
}
"""Truth of the image by that of the first scene."""
EDGES: Mapping[str, float] = {"normal_camera": 0.9}
"""Share of a reading that must be its image, where some rays lie on edges and fall to either side."""
SPECKLED: Mapping[str, tuple[int, float]] = {
    "camera": (1, 0.995), "imaging_sonar": (8, 0.93), "profiling_sonar": (16, 0.97), "sidescan": (16, 0.97),
    "singlebeam": (16, 0.999),
}  # fmt: skip
"""Readings with grain that is drawn by place, not mirrored: samples of a mean, and how well means must correlate; as
they are, without the mirror, those with sides do by 0.93 at most."""
ONE_SIDED: Mapping[str, str] = {
    "magnetometer": "the Earth's field has a declination, and is not mirrored with the scene",
    "lidar": "its scanner turns one way while the vehicle moves on",
    "semantic_lidar": "its scanner turns one way while the vehicle moves on",
    "event_camera": "how far each pixel is towards its next event is drawn",
    "mechanical_scanning_sonar": "its head turns one way",
    "synthetic_aperture_sonar": "looks to one side",
    **dict.fromkeys(LINKED, "its data count packets, which see below"),
}
"""Sensors whose truth has no mirror image, and why."""
QUICK = (
    "pose", "velocity", "imu", "depth", "gps", "current_meter", "dvl", "collision", "depth_camera", "altimeter",
    "radio", "usbl",
)  # fmt: skip
NAMES = sorted(registry.entries("sensor", plugins=False))


def truths(scenario: dict[str, Any], ticks: int) -> list[np.ndarray]:
    """Truth of each reading of a run."""
    sim = pl.Simulation.load(scenario)
    obs, found = sim.reset(), []
    for _ in range(ticks):
        if "it" in obs["auv0"]:
            found.append(np.asarray(obs["auv0"]["it"].truth, dtype=np.float64))
        obs = sim.step()
    return found


def test_every_sensor_has_an_image_or_a_reason() -> None:
    assert set(NAMES) == set(FLIPS) | set(ONE_SIDED), "say in FLIPS how its truth changes in the mirror"


LIKE: tuple[str, ...] = ("travel_time_s", "level_db", "snr_db", "delay_spread_s", "doppler", "range_m", "elevation_rad")
"""What of a packet is the same in the mirror; its azimuth is the other way round."""
SHARP: Mapping[str, dict[str, Any]] = {"usbl": {"bearing_noise_deg": 0.0, "range_noise_m": 0.0}}
"""Linked sensors without the errors that are drawn, not mirrored; what noise leaves is below 1 mrad here."""


def packets(scenario: dict[str, Any], name: str) -> tuple[list[Any], np.ndarray, np.ndarray]:
    """Which packet came to whom, and what became of it; its numbers that are alike in the mirror, and azimuths."""
    sim = pl.Simulation.load(scenario)
    obs, who, alike, turned = sim.reset(), [], [], []
    for tick in range(ticks_of(name)):
        if name != "ais" and tick in (3, 60):
            sim.send(*(("auv0", "it") if tick == 3 else ("auv1", "its")), b"of six", to="*")
        for reading in (r for found in obs.values() for r in found.values()):
            for p in reading.packets:
                who.append((p.kind, p.sender, p.to, reading.frame, p.sent_ns))
                alike += [getattr(p, of) for of in LIKE]
                turned.append(p.azimuth_rad)
            for f in reading.extras["fates"][0]:
                who.append((f.fate, f.kind, f.sender, f.receiver, f.sent_ns))
                alike += [f.level_db, f.snr_db]
        obs = sim.step()
    return who, np.array(alike), np.array(turned)


def means(truth: np.ndarray, count: int) -> np.ndarray:
    """Of so many samples on end along the last axis."""
    whole = truth[..., : truth.shape[-1] // count * count]
    return whole.reshape(*whole.shape[:-1], -1, count).mean(axis=-1)


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in sorted(FLIPS)])
def test_the_image_of_a_scene_is_read_as_the_image(name: str) -> None:
    scenario = sea(name, {})
    if name == "camera":
        scenario["ocean"]["sun"] = {"elevation_deg": 40.0, "azimuth_deg": 25.0}
    for agent in scenario["agents"].values():
        agent["vehicle"] = EVEN
    ticks = 63 if name == "collision" else 9
    one, other = truths(scenario, ticks), truths(mirrored(scenario), ticks)
    assert len(one) == len(other) >= 4
    for before, after in zip(one, other, strict=True):
        expected = FLIPS[name](before)
        if name in SPECKLED:
            count, least = SPECKLED[name]
            both = [means(a, count).ravel() for a in (expected, after)]
            assert np.corrcoef(*both)[0, 1] > least
            continue
        size = np.abs(before, where=np.isfinite(before), out=np.zeros_like(before)).max()
        alike = np.isclose(after, expected, rtol=1e-6, atol=1e-9 * size + 1e-12, equal_nan=True)
        assert alike.mean() >= EDGES.get(name, 1.0)
    if FLIPS[name] is not same:
        assert any(not np.array_equal(a, b, equal_nan=True) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in LINKED])
def test_packets_come_from_the_other_side_in_the_mirror(name: str) -> None:
    scenario = sea(name, SHARP.get(name, {}))
    for agent in scenario["agents"].values():
        agent["vehicle"] = EVEN
    (who, alike, turned), (image, likewise, other) = (packets(s, name) for s in (scenario, mirrored(scenario)))
    assert len(who) >= 2
    assert image == who
    assert likewise == pytest.approx(alike, rel=1e-4, abs=1e-3, nan_ok=True)
    assert other == pytest.approx(-turned, abs=2e-3, nan_ok=True)
    if name == "usbl":
        assert np.abs(turned[np.isfinite(turned)]).max() > 0.1
