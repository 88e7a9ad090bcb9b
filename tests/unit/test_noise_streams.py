"""Streams: the same number for the same name, whichever way it is reached."""

import numpy as np
import pytest

from pelagos import jit
from pelagos.math.philox import normal_pair32
from pelagos.sensors import noise
from pelagos.sensors.example_motion import lanes

DT = 5_000_000

KINDS = {
    "white": lambda key, motion: noise.normals64(key, motion, 5),
    "constant": lambda key, motion: noise.constants64(key, motion, 5),
    "markov": lambda key, motion: noise.gauss_markov(key, motion, 5, correlation_time=3.0),
    "walk": lambda key, motion: noise.random_walk(key, motion, 5),
}


def key(seed: int = 1, path: str = "auv0.imu", purpose: str = "noise"):
    return noise.opaque_key(noise.stream_key(seed, path, purpose))


def rows(found) -> np.ndarray:
    return np.array([np.broadcast_to(np.array(x), len(np.array(found[0]))) for x in found]).T


def test_key_depends_on_all_its_parts() -> None:
    names = [(1, "a.b", "noise"), (2, "a.b", "noise"), (1, "a.c", "noise"), (1, "a.b", "bias"), (-1, "a.b", "noise")]
    keys = [noise.stream_key(*name) for name in names]
    assert len(set(keys)) == len(keys)
    assert all(0 <= word < 2**32 for k in keys for word in k)
    assert noise.stream_key(1, "a.b", "noise") == noise.stream_key(1, "a.b", "noise")


def test_key_of_a_known_name_stays() -> None:
    """It is a hash, the same on every machine; old recordings depend on it."""
    assert noise.stream_key(0, "auv0.imu", "noise") == (4187499036, 1653022711)


@pytest.mark.parametrize("kind", KINDS)
def test_step_by_step_equals_block(kind: str) -> None:
    ticks = range(990, 1010)
    frozen = jit.freeze(KINDS[kind])
    block = rows(frozen(key(), lanes(ticks, dt_ns=DT)))
    steps = np.concatenate([rows(frozen(key(), lanes([t], dt_ns=DT))) for t in ticks])
    assert np.array_equal(block, steps)


@pytest.mark.parametrize("kind", KINDS)
def test_copy_of_a_fleet_equals_a_run_alone(kind: str) -> None:
    ticks = range(100, 108)
    fleet = rows(KINDS[kind](key(), lanes(ticks, dt_ns=DT, environments=range(64)))).reshape(8, 64, 5)
    alone = rows(KINDS[kind](key(), lanes(ticks, dt_ns=DT, environments=(17,))))
    assert np.array_equal(fleet[:, 17], alone)
    if kind != "constant":
        assert not np.array_equal(fleet[0], fleet[1]) or kind == "walk"
    assert len(np.unique(fleet[0, :, 0])) == 64


@pytest.mark.parametrize("kind", KINDS)
def test_frozen_equals_plain(kind: str) -> None:
    motion = lanes(range(5000, 5033), dt_ns=DT, environments=(0, 9))
    frozen = jit.freeze(KINDS[kind])
    frozen(key(), motion)
    assert np.array_equal(rows(frozen(key(), motion)), rows(KINDS[kind](key(), motion)))


@pytest.mark.parametrize("kind", KINDS)
def test_more_numbers_do_not_change_the_first(kind: str) -> None:
    motion = lanes(range(5000, 5033), dt_ns=DT)
    few = {
        "white": lambda: noise.normals64(key(), motion, 2),
        "constant": lambda: noise.constants64(key(), motion, 2),
        "markov": lambda: noise.gauss_markov(key(), motion, 2, correlation_time=3.0),
        "walk": lambda: noise.random_walk(key(), motion, 2),
    }[kind]()
    assert np.array_equal(rows(few), rows(KINDS[kind](key(), motion))[:, :2])


@pytest.mark.parametrize("kind", KINDS)
def test_streams_of_other_names_are_others(kind: str) -> None:
    motion = lanes(range(5000, 5033), dt_ns=DT)
    first = rows(KINDS[kind](key(), motion))
    for other in (key(seed=2), key(path="auv1.imu"), key(purpose="ping")):
        assert not np.isclose(rows(KINDS[kind](other, motion)), first).any()


@pytest.mark.parametrize("kind", ["markov", "walk"])
def test_slow_noise_depends_on_time_not_on_ticks(kind: str) -> None:
    slow = rows(KINDS[kind](key(), lanes(range(40), dt_ns=4 * DT)))
    fast = rows(KINDS[kind](key(), lanes(range(160), dt_ns=DT)))
    assert np.array_equal(slow, fast[::4])


def test_words_of_pixels_differ_by_index_tick_and_environment() -> None:
    import drjit as dr

    index = dr.arange(jit.UInt32, 1000)
    same = jit.UInt32(3)
    base, again, tick, environment = (
        np.array(noise.words32(key(), index, jit.UInt32(e), jit.UInt32(t))[0])
        for e, t in ((3, 3), (3, 3), (3, 4), (4, 3))
    )
    assert np.array_equal(base, again)
    assert len(np.unique(base)) == 1000
    assert not (base == tick).any()
    assert not (base == environment).any()
    a, b = normal_pair32(*noise.words32(key(), index, same, same)[:2])
    assert abs(np.mean(np.array(a))) < 0.2
    assert np.std(np.array(b)) == pytest.approx(1, abs=0.1)
