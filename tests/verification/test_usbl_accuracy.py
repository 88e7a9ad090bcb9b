"""Errors of ultra-short baselines that no level takes away: bearings, alignment of the array, ranges."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.acoustics.bearing import angles_of, direction_of, scattered, turned
from pelagos.sensors.comms.link.array_error import reported_bearing, reported_range
from pelagos.sensors.comms.link.chance import Chance
from pelagos.sensors.comms.link.devices import DEVICES
from pelagos.sensors.comms.modem import ModemConfig
from pelagos.sensors.comms.usbl import UsblConfig

TOWARDS = [(0.4, -0.3), (-2.5, 0.9), (1.7, -1.2)]


def port(**keys: Any) -> Any:
    return SimpleNamespace(
        **{"path": "usv.usbl", "bearing_noise_deg": 0.0, "alignment_std_deg": (0.0, 0.0, 0.0), "range_noise_m": 0.0}
        | keys
    )


def chance(copies: int = 1, episode: int = 0) -> Chance:
    episodes: Any = SimpleNamespace(environment=np.arange(copies), number=np.full(copies, episode))
    return Chance(lambda: 5, episodes)


def across(found: np.ndarray, azimuth: float, elevation: float) -> np.ndarray:
    """Angles `(n, 2)` of directions to the left and upwards of one [rad]."""
    left = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.array([-np.sin(elevation) * np.cos(azimuth), -np.sin(elevation) * np.sin(azimuth), np.cos(elevation)])
    off = found @ np.stack([left, up], axis=1)
    size = np.linalg.norm(off, axis=1, keepdims=True)
    return off / size * np.arcsin(size)


@pytest.mark.parametrize("turn", [(0.3, -0.7, 0.2), (-1.1, 0.05, 0.6), (0.0, 0.0, 0.0)])
def test_turns_are_those_of_scipy(turn: tuple[float, float, float]) -> None:
    vector = np.array([0.5, -0.2, 0.9])
    np.testing.assert_allclose(
        turned(vector, np.array(turn)), Rotation.from_rotvec(turn).apply(vector), rtol=0, atol=1e-15
    )


@pytest.mark.parametrize("towards", TOWARDS)
@pytest.mark.parametrize("off", [(0.02, -0.005), (-0.3, 0.1), (0.0, 0.04)])
def test_a_scattered_direction_is_as_far_off_as_asked(towards: tuple[float, float], off: tuple[float, float]) -> None:
    """Along the great circle that begins to the left and upwards by that much; both signs, unequal."""
    assert angles_of(direction_of(*towards)) == pytest.approx(towards, abs=1e-14)
    found = scattered(direction_of(*towards), off)
    np.testing.assert_allclose(across(found[None], *towards)[0], off, rtol=0, atol=1e-14)


@pytest.mark.parametrize("towards", TOWARDS)
def test_bearings_scatter_by_their_noise_in_both_directions(towards: tuple[float, float]) -> None:
    """1200 packets at 0.7 deg: mean, deviations and correlation within 4 standard errors.

    At 69 deg of elevation azimuths scatter by 1/cos of it, 2.8 times as much: the noise is across the way, not theirs.
    """
    n, sigma = 1200, np.radians(0.7)
    device, drawn = port(bearing_noise_deg=0.7), chance()
    found = np.array([direction_of(*reported_bearing(device, drawn, 0, k, towards)) for k in range(n)])
    off = across(found, *towards)
    np.testing.assert_allclose(off.mean(axis=0), 0.0, atol=4 * sigma / np.sqrt(n))
    np.testing.assert_allclose(off.std(axis=0), sigma, rtol=4 / np.sqrt(2 * n))
    assert abs(np.corrcoef(off.T)[0, 1]) < 4 / np.sqrt(n)
    assert abs(np.corrcoef(off[:-1, 0], off[1:, 0])[0, 1]) < 4 / np.sqrt(n)


def test_an_array_is_turned_by_one_and_the_same_angle_in_a_run() -> None:
    """600 copies: each a rigid turn, constant over packets, about x, y and z by 0.5, 1.5 and 3 deg (4 standard
    errors); another episode has another one.
    """
    n, std = 600, (0.5, 1.5, 3.0)
    device, drawn = port(alignment_std_deg=std), chance(n)
    axes = [(0.0, 0.0), (np.pi / 2, 0.0), (0.0, np.pi / 2)]
    turns = np.empty((n, 3))
    for c in range(n):
        seen = np.stack([direction_of(*reported_bearing(device, drawn, c, k, a)) for k, a in enumerate(axes)], axis=1)
        assert np.abs(seen.T @ seen - np.eye(3)).max() < 1e-12
        turns[c] = Rotation.from_matrix(seen).as_rotvec(degrees=True)
    np.testing.assert_allclose(turns.std(axis=0), std, rtol=4 / np.sqrt(2 * n))
    np.testing.assert_allclose(turns.mean(axis=0) / std, 0.0, atol=4 / np.sqrt(n))
    assert np.abs(np.corrcoef(turns.T) - np.eye(3)).max() < 4 / np.sqrt(n)
    again = reported_bearing(device, chance(n, episode=1), 7, 0, TOWARDS[0])
    assert again != reported_bearing(device, drawn, 7, 0, TOWARDS[0])


def test_ranges_scatter_by_their_noise_and_stay_positive() -> None:
    """1500 responses at 0.3 m: mean and deviation within 4 standard errors; nothing is nearer than the array itself."""
    n, sigma = 1500, 0.3
    device, drawn = port(range_noise_m=sigma), chance()
    off = np.array([reported_range(device, drawn, 0, k, 83.0) - 83.0 for k in range(n)])
    assert abs(off.mean()) < 4 * sigma / np.sqrt(n)
    assert off.std() == pytest.approx(sigma, rel=4 / np.sqrt(2 * n))
    near = np.array([reported_range(device, drawn, 0, k, 0.1) for k in range(200)])
    assert near.min() == 0.0
    np.testing.assert_allclose(near[near > 0], 0.1 + off[:200][near > 0], atol=1e-12)


def test_without_errors_angles_and_ranges_are_untouched() -> None:
    angles, exact = (1.7, -1.2), port()
    assert reported_bearing(exact, chance(), 0, 3, angles) is angles
    assert reported_range(exact, chance(), 0, 3, 83.1) == 83.1


def fleet(copies: int, seconds: float, **keys: Any) -> np.ndarray:
    """Fixes `(copies, k, 3)` of a modem at rest 60, -80, 25 m away, in deep water, louder than any noise."""
    upright = {"position_m": [0.0, 0.0, -400.0], "heading_deg": 0.0}
    aside = {"position_m": [60.0, -80.0, -425.0]}
    usbl = {"type": "usbl", "interrogate": ["auv"], "interrogate_s": 2.0, "sound_speed_mps": 1495.0,
            "bit_rate_bps": 2000.0, **keys}  # fmt: skip
    modem = {"type": "modem", "device": "x150", "bit_rate_bps": 2000.0}
    sim = pl.Simulation.load(
        {
            "seed": 3, "tick_rate_hz": 20, "world": {"type": "flat", "depth_m": 900.0},
            "agents": {
                "usv": {"vehicle": "bluerov2", "control": "actuators", "start": upright, "sensors": {"usbl": usbl}},
                "auv": {"vehicle": "bluerov2", "control": "actuators", "start": aside, "sensors": {"modem": modem}},
            },
        },
        n=copies,
    )  # fmt: skip
    still = {name: sim.state[name].position[0].copy() for name in ("usv", "auv")}
    found = []
    for _ in range(round(seconds * 20)):
        for name, place in still.items():
            sim.set_state(name, position=place, attitude=np.array([1.0, 0, 0, 0]), velocity=np.zeros(3),
                          angular_velocity=np.zeros(3))  # fmt: skip
        reading = sim.step()["usv"].get("usbl")
        if reading is not None and np.isfinite(reading.extras["fix"]).all():
            found.append(reading.extras["fix"])
    return np.stack(found, axis=1)


EXACT = {"bearing_noise_deg": 0.0, "range_noise_m": 0.0}


def test_fixes_scatter_as_the_devices_sheet_says() -> None:
    """150 copies at 103 m: 1 deg is 1.80 m to the left and upwards, along the way 5 cm, as SeaTrac X150 (device x150);
    within 4 standard errors, with what noise and echoes make without these. Alignment moves all fixes of a copy alike.
    """
    exact = fleet(60, 2.6, **EXACT)[:, 0]
    fixes = fleet(150, 2.6)[:, 0]
    way = exact.mean(axis=0)
    distance = float(np.linalg.norm(way))
    azimuth, elevation = angles_of(way / distance)
    for values, bearing, along in ((exact, 0.0, 0.0), (fixes, np.radians(1.0), 0.05)):
        ranges = np.linalg.norm(values, axis=1)
        off = across(values / ranges[:, None], azimuth, elevation)
        if bearing == 0.0:
            thermal, timing = off.std(axis=0), ranges.std()
            assert thermal.max() < np.radians(0.2)
            assert timing < 0.01
            continue
        error = 4 / np.sqrt(2 * len(values))
        np.testing.assert_allclose(off.std(axis=0), np.hypot(bearing, thermal), rtol=error)
        assert ranges.std() == pytest.approx(np.hypot(along, timing), rel=error)
    aligned = fleet(20, 6.6, **EXACT, alignment_std_deg=(0.5, 1.5, 3.0))
    assert aligned.shape[1] >= 3
    alike = np.linalg.norm(aligned - aligned.mean(axis=1, keepdims=True), axis=2)
    assert alike.max() < 5 * np.hypot(thermal.max() * distance, timing)
    moved = np.linalg.norm(aligned.mean(axis=1) - way, axis=1)
    expected = np.radians([0.5, 1.5, 3.0]) @ np.diag(distance**2 - way**2) @ np.radians([0.5, 1.5, 3.0])  # of |t x r|^2
    assert np.sqrt((moved**2).mean()) == pytest.approx(np.sqrt(expected), rel=4 / np.sqrt(2 * len(moved)))


@pytest.mark.parametrize("name", DEVICES)
def test_every_modem_can_carry_an_array(name: str) -> None:
    """What a sheet, or a recollection of it, says of bearings and ranges counts for a `usbl` alone."""
    found = DEVICES[name]
    config = UsblConfig(device=name)
    for key, value in found.array.items():
        assert getattr(config, key) == value
    assert set(found.assumed) <= {*found.keys, *found.array}
    assert not set(found.array) & set(ModemConfig.model_fields)
    assert UsblConfig.model_validate(config.model_dump()) == config
    assert UsblConfig(device=name, bearing_noise_deg=0.3).bearing_noise_deg == 0.3


def test_errors_that_no_device_has_are_refused() -> None:
    for wrong in ({"bearing_noise_deg": -0.1}, {"range_noise_m": -1.0}, {"alignment_std_deg": (0.0, -1.0, 0.0)}):
        with pytest.raises(ValidationError, match=next(iter(wrong))):
            UsblConfig(**wrong)
    with pytest.raises(ValidationError, match="range_noise_m"):
        ModemConfig(range_noise_m=0.1)
