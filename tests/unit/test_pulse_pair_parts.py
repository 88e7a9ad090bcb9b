"""What moves on between two pulses, by cell, against sums written out."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos.sensors.sonar.ping.pulse_pairs as module
from pelagos import jit
from pelagos.sensors.sonar.ping.pulse_pairs import PulsePairs

LANES, BEAMS, RAYS, BINS = 3, 2, 4, 7
AXES = np.array([[0.5, 0.2, -0.8], [-0.3, 0.6, -0.7]])
AXES /= np.linalg.norm(AXES, axis=1, keepdims=True)
SPEED, LOSS = np.array([1470.0, 1500.0, 1520.0]), np.array([0.05, 0.02, 0.1])
SCALE = np.array([1.7, 2.2, 1.3])  # radians a metre per second
PULSE = [0.3, 0.9, 0.25]
TURN = Rotation.from_euler("ZYX", [[0.4, 0.1, -0.2], [-1.2, 0.15, 0.1], [2.5, -0.1, 0.05]])
QUATERNION = TURN.as_quat()[:, [3, 0, 1, 2]]


def three(values: Any) -> Any:
    """Rows of three as columns on the device."""
    return jit.Array3f64(np.ascontiguousarray(values.T))


def flat(values: Any) -> Any:
    return jit.Float(np.ascontiguousarray(values).ravel())


def pairs(assumed: float | None, **keys: Any) -> Any:
    made = object.__new__(PulsePairs)
    ping = SimpleNamespace(range_min_m=4.0, bin_width_m=0.5, bins=BINS, sound_speed_mps=assumed, equivalent_m=0.4,
                           mounting=None)  # fmt: skip
    layout = SimpleNamespace(beams=BEAMS, horizontal_width=0.06)
    usual = {"_ping": ping, "_layout": layout, "_axes": AXES, "_rays": RAYS, "_heard": 0.8, "_psi": 2.5,
             "_pulse": PULSE, "_taps": [0.1, 0.5, 1.0, 0.5, 0.1], "_deviation": (0.02, 0.05), "_hazy": True,
             "_layer_samples": 6.0}  # fmt: skip
    vars(made).update(usual | keys)
    return made


def test_speeds_along_beams_are_those_of_their_lane() -> None:
    rng = np.random.default_rng(23)
    vector = rng.normal(size=(LANES, 3))
    row = jit.UInt32(np.arange(LANES * BEAMS))
    found = np.array(pairs(None)._along_axes(three(vector), row))
    np.testing.assert_allclose(found.reshape(LANES, BEAMS), vector @ AXES.T, atol=1e-6)


@pytest.mark.parametrize("assumed", [None, 1540.0])
def test_cells_hear_each_rays_strip_and_turn_by_its_speed_over_the_axiss(assumed: float | None) -> None:
    """Power by the part of the bin that a strip covers; turns over the pulse's length about it; water before what rays
    meet. Ranges by the speed that is assumed."""
    rng = np.random.default_rng(23)
    shape = (LANES, BEAMS, RAYS)
    t = 4.0 + rng.uniform(0.0, 3.6, shape)
    near, far = t - rng.uniform(0.05, 0.6, shape), t + rng.uniform(0.05, 0.6, shape)
    valid, energy, weight = (
        rng.uniform(size=shape) > 0.2,
        rng.uniform(0.5, 2.0, shape),
        rng.uniform(1.0, 2.0, (BEAMS, RAYS)),
    )
    directions, moves = rng.normal(size=(*shape, 3)), 0.2 * rng.normal(size=(*shape, 3))
    velocity, bow = rng.normal(size=(LANES, 3)), rng.normal(size=(LANES, BEAMS))
    index = np.arange(t.size)
    of_lane = lambda values: jit.Float(np.repeat(np.array(values), BEAMS * RAYS))
    view: Any = SimpleNamespace(
        lane=jit.UInt32(index // (BEAMS * RAYS)), ray=jit.UInt32(index % (BEAMS * RAYS)), of_lane=of_lane,
        direction=jit.Array3f(np.ascontiguousarray(directions.reshape(-1, 3).T)),
        hits=SimpleNamespace(t=flat(t), velocity=jit.Array3f(np.ascontiguousarray(moves.reshape(-1, 3).T))),
    )  # fmt: skip
    patches: Any = SimpleNamespace(near=flat(near), far=flat(far), valid=jit.Bool(valid.ravel()), energy=flat(energy))
    lanes: Any = SimpleNamespace(
        attitude=jit.Array4f64(np.ascontiguousarray(QUATERNION.T)), position=jit.Array3f64(np.zeros((3, LANES))),
        medium=SimpleNamespace(sound_speed=jit.Float(SPEED)),
    )  # fmt: skip
    parts = pairs(assumed)._moved(
        view, patches, SimpleNamespace(weight=flat(weight)), lanes, three(velocity), flat(bow),
        jit.Float(SCALE),
    )  # fmt: skip
    power, sunk, tilted, free = (np.array(v).reshape(LANES, BEAMS, BINS) for v in parts)
    own = TURN.apply(velocity)
    for p, b, k in np.ndindex(LANES, BEAMS, BINS):
        ratio = 1.0 if assumed is None else assumed / SPEED[p]
        turn = SCALE[p] * (((own[p] - moves[p, b]) * directions[p, b]).sum(axis=1) - bow[p, b])
        low, high = ((v[p, b] * ratio - 4.0) / 0.5 for v in (near, far))
        density = np.where(valid[p, b], energy[p, b], 0.0) / (high - low) * 0.8
        covered = np.maximum(np.minimum(high, k + 1) - np.maximum(low, k), 0.0)
        wide = density * np.maximum(np.minimum(high, k + 2.0) - np.maximum(low, k - 1.0), 0.0)
        assert power[p, b, k] == pytest.approx((density * covered).sum(), rel=1e-4, abs=1e-5)
        share = wide / wide.sum() if wide.any() else wide
        assert sunk[p, b, k] == pytest.approx((share * (1 - np.cos(turn))).sum(), rel=1e-3, abs=1e-4)
        assert tilted[p, b, k] == pytest.approx((share * np.sin(turn)).sum(), rel=1e-3, abs=1e-4)
        behind = ~valid[p, b] | (t[p, b] * ratio > 4.0 + 0.5 * (k + 0.5))
        assert free[p, b, k] == pytest.approx((weight[b] * behind).sum() / 2.5, rel=1e-5)


def test_surfaces_lose_the_coherence_that_the_sheets_deviation_means() -> None:
    """Independent samples: one over the sum of p_j p_k c_jk of parts p of the power; x/(1 + x) of two samples each."""
    rng = np.random.default_rng(23)
    power = rng.uniform(0.1, 2.0, (LANES, BEAMS, BINS)) ** 3
    bow = rng.normal(size=(LANES, BEAMS))
    found = np.array(pairs(None)._dulled(flat(power), flat(bow), jit.Float(SCALE))).reshape(LANES, BEAMS)
    part = power / power.sum(axis=-1, keepdims=True)
    taps = np.array([0.1, 0.5, 1.0, 0.5, 0.1])
    apart = np.abs(np.arange(BINS)[:, None] - np.arange(BINS))
    alike = np.where(apart <= 2, taps[np.minimum(apart, 2) + 2], 0.0)
    samples = 1.0 / np.einsum("lbj,jk,lbk->lb", part, alike, part)
    x = 2 * samples * (0.02**2 + (0.05 * bow) ** 2) * SCALE[:, None] ** 2
    np.testing.assert_allclose(found, x / (1 + x), rtol=1e-4)


def test_the_pulse_spreads_cells_within_their_beam() -> None:
    rng = np.random.default_rng(23)
    raw = rng.normal(size=(LANES * BEAMS, BINS, 4))
    cell = jit.UInt32(np.arange(LANES * BEAMS * BINS))
    found = np.array(pairs(None)._through_pulse(flat(raw), cell, cell % BINS)).T.reshape(raw.shape)
    padded = np.pad(raw, ((0, 0), (1, 1), (0, 0)))
    expected = 0.3 * padded[:, :-2] + 0.9 * padded[:, 1:-1] + 0.25 * padded[:, 2:]
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize("assumed", [None, 1540.0])
@pytest.mark.parametrize("strength", [-52.0, None])
def test_water_turns_by_its_own_speed_and_is_dulled_by_what_crosses_the_beam(
    assumed: float | None, strength: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In each copy's water, at the moment and place that the echo's time means; a head that turns sweeps over it."""
    rng = np.random.default_rng(23)
    copies, t_ns = np.array([0, 1, 0]), np.array([0, 2_000_000_000, 5_000_000_000])
    place, velocity, spin = (s * rng.normal(size=(LANES, 3)) for s in (20.0, 1.0, 0.3))
    monkeypatch.setattr(module, "sensor_angular_velocity", lambda *_: three(spin))

    def flow(x: Any, y: Any, z: Any, t: Any, copy: Any) -> tuple[Any, Any, Any]:
        return 0.4 + 0.7 * copy + 0.02 * x + 0.05 * t, -0.3 - 0.2 * copy + 0.03 * y, 0.01 * z

    ocean: Any = SimpleNamespace(
        current=lambda at, t, copy: jit.Array3f64(*flow(at.x, at.y, at.z, t, jit.Float64(copy))),
        tracer=lambda name, at, t: -60.0 + 0.1 * at.x + 0.2 * at.z + t,
    )
    lanes: Any = SimpleNamespace(
        position=three(place), attitude=jit.Array4f64(np.ascontiguousarray(QUATERNION.T)),
        medium=SimpleNamespace(sound_speed=jit.Float(SPEED), absorption=jit.Float(LOSS)),
    )  # fmt: skip
    motion: Any = SimpleNamespace(t_ns=jit.UInt64(t_ns.astype(np.uint64)), copy=jit.UInt32(copies))
    count = LANES * BEAMS * BINS
    normals, free = rng.normal(size=(12, count)), rng.uniform(0.2, 1.0, count)
    cell = np.arange(count)
    distance = 4.0 + 0.5 * (cell % BINS + 0.5)
    (power, real, imaginary), later = pairs(assumed, _strength=strength)._water(
        ocean, lanes, motion, three(velocity), jit.UInt32(cell), jit.Float(distance),
        jit.Float(free), jit.Float(SCALE), [jit.Float(n) for n in normals],
    )  # fmt: skip
    lane, axis = cell // (BEAMS * BINS), AXES[cell // BINS % BEAMS]
    r = distance * (1.0 if assumed is None else SPEED[lane] / assumed)
    there = place[lane] + TURN[lane].apply(axis) * r[:, None]
    t = t_ns[lane] * 1e-9
    sv = strength if strength is not None else -60.0 + 0.1 * there[:, 0] + 0.2 * there[:, 2] + t
    expected = free * 10 ** (np.asarray(sv) / 10) * 2.5 * 0.4 * 10 ** (-0.2 * LOSS[lane] * r) / r**2
    np.testing.assert_allclose(np.array(power), expected, rtol=1e-4)
    size = np.sqrt(0.5 * expected)
    first = size * (normals[4] + 1j * normals[5])
    np.testing.assert_allclose(np.array(real) + 1j * np.array(imaginary), first, rtol=1e-4)
    through = velocity[lane] - TURN[lane].inv().apply(np.stack(flow(*there.T, t, copies[lane]), axis=-1))
    closing = (through * axis).sum(axis=1)
    aside = -through + closing[:, None] * axis - np.cross(spin[lane], axis * r[:, None])
    scale = SCALE[lane]
    x = 2 * 6.0 * (0.02**2 + (0.05 * closing) ** 2) * scale**2
    kept = np.exp(-((np.linalg.norm(aside, axis=1) * 0.25 / math.sqrt(math.log(2)) * 0.06 * scale) ** 2)) / (1 + x)
    second = np.sqrt(kept) * first * np.exp(1j * closing * scale)
    second += np.sqrt(1 - kept) * size * (normals[6] + 1j * normals[7])
    np.testing.assert_allclose(np.array(later[0]) + 1j * np.array(later[1]), second, rtol=2e-3, atol=1e-7)
