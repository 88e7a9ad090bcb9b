"""From detections to soundings: which count, how strong, how sure, and where."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.acoustics.bottom_detection import Series, find_bottom
from pelagos.sensors.sonar.ping.bottom_series import Window
from pelagos.sensors.sonar.ping.soundings import detect, quality, snippets, sounding_places

SAMPLES, BEAMS, SPACING = 64, 6, 0.05
WATER = np.array([1450.0, 1530.0])
START = np.array([[20.0, 4.33, 50.98, 33.0, 25.0, 28.0], [21.0, 4.58, 47.0, 38.0, 52.68, 53.28]])


def config(**more: Any) -> Any:
    keys = {"samples": SAMPLES, "soundings": BEAMS, "sound_speed_mps": None, "detection_snr_db": 10.0,
            "range_min_m": 6.0, "range_max_m": 54.0, "rate_hz": 14.0}  # fmt: skip
    return SimpleNamespace(**(keys | more))


def lanes(**more: Any) -> Any:
    return SimpleNamespace(medium=SimpleNamespace(sound_speed=jit.Float(WATER)), profile=None, **more)


def series(level: np.ndarray) -> Series:
    """A short pulse 30.4 samples behind each start, of an amplitude in both halves together."""
    k = np.arange(SAMPLES) + 0.5
    pulse = np.exp(-(((k - 30.4) / 1.5) ** 2))
    half = 0.5 * np.sqrt(level).reshape(-1, 1) * pulse
    halves = np.stack([half, 0 * half, half, 0 * half], axis=-1)
    count = level.size
    wide = lambda v: jit.Float(np.full(count, v))
    return Series(jit.Float(halves.ravel()), jit.Float(START.ravel()), wide(SPACING), wide(2 * SPACING))


def window(found: np.ndarray) -> Window:
    rng = np.random.default_rng(3)
    axis = START + 1.6
    axis[0, 2] = 70.0
    draw = lambda: jit.Float(rng.uniform(0.01, 0.3, START.size))
    names = ("where", "near", "far", "power", "section")
    return Window(
        found=jit.Bool(found.ravel()), **{n: draw() for n in names}, axis=jit.Float(axis.ravel()),
        label=jit.UInt32(np.arange(12)), instance=jit.UInt32(np.arange(12) + 30),
    )  # fmt: skip


@pytest.mark.parametrize("assumed", [None, 1500.0])
def test_a_sounding_counts_within_range_time_and_noise(assumed: float | None) -> None:
    """Ranges scale by the speed that is assumed; the next ping comes after c/(2 14 Hz) of true range, 51.8 and 54.6 m;
    samples of the pulse above its gate have a mean of 0.52 of its peak or so."""
    noise = 1e-6
    level = np.full((2, BEAMS), 1e-3)
    level[0, 3] = 9e-6  # a mean of 5 or so of the noise
    there = np.ones((2, BEAMS), bool)
    there[1, 0] = False
    seen = window(there)
    made = detect(config(sound_speed_mps=assumed), seen, series(level), lanes(), jit.Float(noise))
    dr.eval(made)
    found = {name: np.array(v).reshape(2, BEAMS) for name, v in made.items()}
    true = START + 30.4 * SPACING
    measured = true * (1.0 if assumed is None else assumed / WATER[:, None])
    counts = there & (level > 1e-4) & (measured >= 6.0) & (measured <= 54.0) & (true <= WATER[:, None] / 28.0)
    assert counts.sum() == (6 if assumed is None else 7)
    assert (np.isfinite(found["range"]) == counts).all()
    assert found["range"][counts] == pytest.approx(measured[counts], abs=2e-3)
    assert (np.isnan(found["uncertainty"]) == ~counts).all()
    errors = np.array(find_bottom(series(level), SAMPLES, noise=jit.Float(noise)).error).reshape(2, BEAMS)
    assert found["uncertainty"][counts] == pytest.approx((errors * measured / true)[counts], rel=1e-4)
    assert (found["detection"] == np.where(counts, 1, 0)).all()
    axis = np.array(seen.axis).reshape(2, BEAMS)
    assert found["truth"] == pytest.approx(np.where(axis <= 54.0, axis, np.nan), nan_ok=True)
    assert found["label"].ravel().tolist() == list(range(12))
    assert found["instance"].ravel().tolist() == list(range(30, 42))
    whole = (np.exp(-2 * ((np.arange(SAMPLES) + 0.5 - 30.4) / 1.5) ** 2)).sum() * level - SAMPLES * noise
    section, power = (np.array(v).reshape(2, BEAMS) for v in (seen.section, seen.power))
    strength = 10 * np.log10(np.maximum(section * whole / power, 1e-12))
    assert found["backscatter"][counts] == pytest.approx(strength[counts], abs=1e-3)
    assert found["snr"][0, 0] - found["snr"][0, 3] == pytest.approx(10 * np.log10(1e-3 / 9e-6), abs=0.5)


def test_places_lie_along_the_axes_in_the_sensor_frame() -> None:
    """By straight rays where there is no profile, or where a sound speed is assumed, whatever the water."""
    turn = Rotation.random(2, random_state=1)
    q = np.roll(turn.as_quat(), 1, axis=1)
    rng = np.random.default_rng(6)
    way, reach = rng.normal(size=(12, 3)), rng.uniform(5, 60, 12)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    world = jit.Array3f(np.ascontiguousarray(way.T, np.float32))
    for profile, assumed in ((None, None), ("any", 1500.0)):
        here = lanes(attitude=jit.Array4f64(np.ascontiguousarray(q.T)))
        here.profile = profile
        found = np.array(sounding_places(config(sound_speed_mps=assumed), world, jit.Float(reach), here)).T
        expected = np.concatenate([turn[k].inv().apply(way[6 * k : 6 * k + 6]) for k in (0, 1)]) * reach[:, None]
        assert found == pytest.approx(expected, abs=1e-3)


def test_snippets_are_both_halves_by_sample() -> None:
    """Two lanes of three beams of four samples: left and right, at the middles of their samples."""
    values = np.random.default_rng(2).normal(size=(2, 3, 4, 4)).astype(np.float32)
    start, spacing = np.arange(6.0) + 10.0, 0.1 * (np.arange(6) + 1)
    made = Series(jit.Float(values.ravel()), jit.Float(start), jit.Float(spacing), jit.Float(spacing))
    found = snippets(made, (2, 3), 4)
    assert found["iq"].shape == (2, 3, 2, 4)
    assert found["iq"].dtype == np.complex64
    assert found["iq"][1, 2, 0] == pytest.approx(values[1, 2, :, 0] + 1j * values[1, 2, :, 1])
    assert found["iq"][0, 1, 1] == pytest.approx(values[0, 1, :, 2] + 1j * values[0, 1, :, 3])
    assert found["iq_range"][1, 1] == pytest.approx(14.0 + 0.5 * np.array([0.5, 1.5, 2.5, 3.5]))


def test_quality_is_a_half_at_two_parts_in_a_thousand_and_a_millimetre() -> None:
    distance = np.array([20.0, 20.0, np.nan, 7.0], np.float32)
    error = np.array([0.041, 0.123, np.nan, 0.0], np.float32)
    assert quality(distance, error) == pytest.approx([0.5, 0.1, 0.0, 1.0], rel=1e-4)
