"""What a sonar makes of things from rays of their own and mirrors' echoes, against sums written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.math.philox import complex_normal32
from pelagos.sensors.sonar.ping.target_sighting import _Asked, _merged, _OwnRays, rays_of
from pelagos.sensors.sonar.ping.targets import BOX, OTHER, SPHERE

LANES, THINGS, RAYS = 2, 4, 3
SHAPE = (LANES, THINGS)
KIND = np.array([[SPHERE, SPHERE, BOX, OTHER], [SPHERE, BOX, SPHERE, SPHERE]])
SPEED = np.array([1480.0, 1530.0])
WAVE_CYCLES = 2 * 30_000.0


def flat(values: Any) -> Any:
    return jit.Float(np.ascontiguousarray(values).ravel())


def three(values: Any) -> Any:
    """Rows of three as columns on the device."""
    return jit.Array3f(np.ascontiguousarray(np.reshape(values, (-1, 3)).T))


def test_few_things_have_four_times_the_rays_of_many() -> None:
    assert [rays_of(n) for n in (1, 64, 65, 900)] == [64, 64, 16, 16]


@pytest.mark.parametrize("steered", [False, True])
def test_a_thing_is_what_its_rays_and_its_mirror_bring(steered: bool) -> None:
    """A mirror's echo by the root of what is coherent and seen, with the loss on the way there and back; the rays share
    out what is not, of spheres as much as their facets and Lambert's law scatter."""
    rng = np.random.default_rng(31)
    draw = rng.uniform
    distance, radius, form, lambert = (
        draw(5, 40, SHAPE),
        draw(0.2, 1, SHAPE),
        draw(0.1, 0.4, SHAPE),
        draw(0, 0.3, SHAPE),
    )
    coherent = np.array([[0.6, 0.0005, 0.3, 0.8], [0.9, 0.4, 0.0, 0.7]])
    echo_size = draw(0.01, 0.1, SHAPE)
    echo_size[0, 3] = 0.0
    here = np.array([[True, True, True, True], [True, False, True, True]])
    way, reach = rng.normal(size=(*SHAPE, 3)) * 12.0, draw(5.0, 40.0, SHAPE)
    energy = draw(0.1, 2.0, (*SHAPE, RAYS)) * 1e-6
    energy[1, 3] = 0.0
    hit, blocked = rng.integers(0, 2, (2, *SHAPE, RAYS))
    blocked = blocked & ~hit & 1
    hit[1, 2], blocked[1, 2] = 0, 0  # nothing met at all
    word = rng.integers(0, 2**32, (*SHAPE, RAYS), dtype=np.uint32)
    beam, label = rng.integers(0, 9, (2, *SHAPE, RAYS))
    ray_distance, moves = draw(5, 40, (*SHAPE, RAYS)), rng.normal(size=(*SHAPE, 3))
    small = draw(size=SHAPE) > 0.5

    def mean_loss(lane: Any, start: Any, end: Any) -> Any:
        return jit.Float(lane) * 0.05 + 0.04 + start + 0.001 * end

    lanes = SimpleNamespace(medium=SimpleNamespace(sound_speed=jit.Float(SPEED), mean_loss=mean_loss))
    listener: Any = SimpleNamespace(
        lanes=lanes, hearing=SimpleNamespace(aperture=SimpleNamespace(steered=steered), wave_cycles=WAVE_CYCLES),
        apparent=lambda way, lane: jit.Array3f(way.y, way.x * (1.0 + jit.Float(lane)), way.z),
        sector=lambda way: (jit.UInt32(jit.Int32(way.y > 0.0)) + 5, 0.3 + 0.2 * way.x * way.x),
        level=lambda way: jit.Array3f(way.x + 7.0, way.y, 0.0),
        measured_range=lambda at, lane, velocity, way: at + 100.0 * jit.Float(lane) + velocity.x + 0.1 * way.x,
    )  # fmt: skip
    place: Any = SimpleNamespace(
        distance=flat(distance), kind=jit.UInt32(KIND.ravel()), radius=flat(radius), form=flat(form),
        lambert=flat(lambert), small=jit.Bool(small.ravel()), velocity=three(moves),
    )  # fmt: skip
    echo: Any = SimpleNamespace(size=flat(echo_size), reach=flat(reach), way=three(way))
    chosen = _Asked(jit.Bool(here.ravel()), jit.Bool(here.ravel()), flat(coherent), echo)
    zero = flat(0 * energy)
    rays = _OwnRays(
        energy=flat(energy), distance=flat(ray_distance), word=jit.UInt32(word.ravel()), beam=jit.UInt32(beam.ravel()),
        label=jit.UInt32(label.ravel()), hit=flat(hit), blocked=flat(blocked), loss=zero,
    )  # fmt: skip
    made = _merged(place, chosen, rays, listener, k=RAYS, count=THINGS)
    found = {n: np.array(getattr(made, n)) for n in vars(made)}

    lane = np.arange(LANES)[:, None]
    unit = way / np.linalg.norm(way, axis=-1, keepdims=True)
    seen = hit.sum(-1) / np.maximum(hit.sum(-1) + blocked.sum(-1), 1)
    heard = 10 ** (-(0.04 + 0.05 * lane + 0.001 * way[..., 2]) * reach / 10)
    in_sensor = np.stack([unit[..., 1], unit[..., 0] * (1 + lane), unit[..., 2]], axis=-1)
    pattern = 0.3 + 0.2 * in_sensor[..., 0] ** 2
    is_coherent = here & (coherent > 1e-3) & (echo_size > 0)
    size = np.where(is_coherent, echo_size * np.sqrt(coherent * seen * pattern) * heard, 0.0)
    np.testing.assert_allclose(found["size"].reshape(SHAPE), size, rtol=1e-5)
    turns = reach * WAVE_CYCLES / SPEED[:, None]
    wave = found["cosine"] + 1j * found["sine"]
    np.testing.assert_allclose(
        wave.reshape(SHAPE), np.exp(-2j * np.pi * np.float32(reach) * WAVE_CYCLES / SPEED[:, None]), atol=2e-2
    )
    assert np.abs(turns).min() > 100
    rough = (1 - coherent) * (form**2 + 2 / 3 * np.pi * lambert * radius**2) * heard**2 * pattern / distance**4
    total = energy.sum(-1)
    share = np.where((KIND == SPHERE) & (total > 0), rough * seen / np.maximum(total, 1e-30), 1 - coherent)
    np.testing.assert_allclose(found["energy"].reshape(energy.shape), energy * share[..., None], rtol=1e-4)
    strength, turn = (np.array(v).reshape(energy.shape) for v in complex_normal32(jit.UInt32(word.ravel())))
    amplitude = np.sqrt(energy * share[..., None] * strength) * np.exp(2j * np.pi * turn)
    pair = (found["real"] + 1j * found["imaginary"]).reshape(energy.shape)
    np.testing.assert_allclose(pair, amplitude, rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(found["dulled"].reshape(SHAPE), 1 - coherent, rtol=1e-5)
    np.testing.assert_allclose(
        found["reach"].reshape(SHAPE), reach + 100.0 * lane + moves[..., 0] + 0.1 * unit[..., 0], rtol=1e-5
    )
    told = in_sensor * [1, 1, 0] + [7, 0, 0] if steered else in_sensor
    np.testing.assert_allclose(found["direction"].T.reshape(*SHAPE, 3), told, atol=1e-5)
    assert found["nearest"].reshape(SHAPE).tolist() == (5 + (in_sensor[..., 1] > 0)).tolist()
    assert found["point"].reshape(SHAPE).tolist() == (KIND == SPHERE).tolist()
    assert found["small"].reshape(SHAPE).tolist() == small.tolist()
    assert found["beam"].tolist() == beam.ravel().tolist()
    assert found["label"].tolist() == label.ravel().tolist()
    np.testing.assert_allclose(found["distance"], ray_distance.ravel(), rtol=1e-6)
