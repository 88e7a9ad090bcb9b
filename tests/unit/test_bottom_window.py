"""The window of a multibeam's series about the strongest echo of each beam, against sums written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos.sensors.sonar.ping.bottom_series as series
from pelagos import jit
from pelagos.sensors.sonar.ping.bottom_series import Beams, beam_series

PINGS, COUNT, RAYS, SAMPLES = 2, 3, 5, 64
LOSS, SPEED = np.array([0.05, 0.12]), np.array([1475.0, 1530.0])
RNG = np.random.default_rng(17)
SHAPE = (PINGS, COUNT, RAYS)
DISTANCE = 30.0 + RNG.uniform(-1.0, 1.0, SHAPE) + 4.0 * np.arange(COUNT)[:, None]
DISTANCE[0, 0, 3], DISTANCE[1, 1, 0], DISTANCE[1, 1, 4] = 41.0, 25.0, 46.0  # outside of the gate
ENERGY = RNG.uniform(0.2, 2.0, SHAPE) * 1e-7
ENERGY[0, 1, 2] *= 1e-3  # too faint to count
ENERGY[1, 1] *= [0.4, 1.0, 1.3, 0.9, 0.3]  # what is outside is not the strongest
ENERGY[0, 0, 3] *= 0.1
VALID = np.ones(SHAPE, bool)
VALID[0, 2, 1], VALID[1, 2] = False, False
NEAR, FAR = DISTANCE - RNG.uniform(0.05, 0.5, SHAPE), DISTANCE + RNG.uniform(0.05, 0.9, SHAPE)
SINE = RNG.uniform(0.2, 1.0, SHAPE)
WEIGHT = RNG.uniform(1.0, 3.0, (COUNT, RAYS)) * 1e-4


def rows(values: Any, kind: Any = jit.Float) -> Any:
    return kind(np.ascontiguousarray(values).ravel())


def test_a_window_holds_what_is_heard_with_the_strongest_ray(monkeypatch: pytest.MonkeyPatch) -> None:
    """The strongest after 20 log r; rays of a hundredth of it and within 6 % of its range and 0.2 m, from their near to
    their far ends. Samples are half a resolution apart, or what brings the window into all but eight of them."""
    beams = Beams(COUNT, SAMPLES, 6e-5, 20.0, (1.0,) * RAYS, 0.05, 9.0, 3)
    row = np.arange(PINGS * COUNT * RAYS)
    label, instance = RNG.integers(0, 9, (2, *SHAPE))
    hits = SimpleNamespace(valid=rows(VALID, jit.Bool), t=rows(DISTANCE + 0.3), label=rows(label, jit.UInt32),
                           instance=rows(instance, jit.UInt32))  # fmt: skip
    view: Any = SimpleNamespace(
        lane=jit.UInt32(row // (COUNT * RAYS)), ray=jit.UInt32(row % (COUNT * RAYS)), sine=rows(SINE), hits=hits
    )
    patches: Any = SimpleNamespace(
        valid=rows(VALID, jit.Bool), distance=rows(DISTANCE), energy=rows(ENERGY), near=rows(NEAR), far=rows(FAR)
    )
    medium = SimpleNamespace(absorption=jit.Float(LOSS), sound_speed=jit.Float(SPEED))
    lanes: Any = SimpleNamespace(position=jit.Array3f64(np.zeros((3, PINGS))), medium=medium)
    fan: Any = SimpleNamespace(weight=rows(WEIGHT))
    monkeypatch.setattr(series, "_raw", lambda *_: jit.Float(np.ones(4 * PINGS * COUNT * SAMPLES)))
    window, made = beam_series(beams, view, patches, fan, lanes, jit.Float(0.0), None)  # type: ignore[arg-type]
    found = {name: np.array(getattr(window, name)).reshape(PINGS, COUNT) for name in vars(window)}
    start, spacing, resolution = (
        np.array(v).reshape(PINGS, COUNT) for v in (made.start, made.spacing, made.resolution)
    )
    left_out = 0
    for p, b in np.ndindex(PINGS, COUNT):
        r, energy = DISTANCE[p, b], np.where(VALID[p, b], ENERGY[p, b], 0.0)
        level = energy * r**2 * 10 ** (0.2 * LOSS[p] * r)
        assert found["found"][p, b] == VALID[p, b].any()
        if not VALID[p, b].any():
            continue
        best = int(level.argmax())
        heard = (level > 0.01 * level[best]) & (np.abs(r - r[best]) <= 0.06 * r[best] + 0.2)
        left_out += int((VALID[p, b] & ~heard).sum())
        near, far = NEAR[p, b][heard].min(), FAR[p, b][heard].max()
        section = energy / (WEIGHT[b] * r**-2 * 10 ** (-0.2 * LOSS[p] * r)) * SINE[p, b]
        gap = max(0.5 * SPEED[p] * 6e-5, (far - near) / (SAMPLES - 8))
        assert found["where"][p, b] == pytest.approx(r[best], rel=1e-6)
        assert (found["near"][p, b], found["far"][p, b]) == pytest.approx((near, far), rel=1e-6)
        assert found["power"][p, b] == pytest.approx(2 * energy[heard].sum(), rel=1e-5)  # each sample hears two cells
        assert found["section"][p, b] == pytest.approx((energy * section)[heard].sum() / energy[heard].sum(), rel=1e-4)
        assert spacing[p, b] == pytest.approx(gap, rel=1e-4)
        assert resolution[p, b] == pytest.approx(2 * gap, rel=1e-4)
        assert start[p, b] == pytest.approx(0.5 * (near + far) - 0.5 * SAMPLES * gap, abs=1e-4)
        axis = DISTANCE[p, b, 2] + 0.3 if VALID[p, b, 2] else np.inf
        assert found["axis"][p, b] == pytest.approx(axis, rel=1e-6)
        assert (found["label"][p, b], found["instance"][p, b]) == (label[p, b, 2], instance[p, b, 2])
    assert left_out >= 4
    assert np.unique(np.isclose(spacing, 0.5 * SPEED[:, None] * 6e-5)).tolist() == [False, True]
    pulse = np.array([1.5, *[2.0] * (SAMPLES - 2), 1.5]) * np.sqrt(2 / 1.5)  # of 0.5, 1, 0.5 in cells of 1
    np.testing.assert_allclose(
        np.array(made.halves).reshape(-1, SAMPLES, 4), np.tile(pulse[:, None], (6, 1, 4)), rtol=1e-6
    )
