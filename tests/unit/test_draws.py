"""Random numbers of an episode: words of Philox in their order, stretched, and shapes that they are made into."""

from __future__ import annotations

from typing import Any

import numpy as np

from pelagos import jit
from pelagos.envs.draws import Draws
from pelagos.math.philox import philox

SEED, COPIES, EPISODES, MOMENTS = 9, [3, 4, 70], [1, 5, 2], [8, 0, 6]


def draws() -> Draws:
    u32 = lambda values: jit.from_numpy(jit.UInt32, np.array(values, np.uint32))
    return Draws(u32([SEED] * 3), u32(COPIES), u32(EPISODES), u32(MOMENTS))


def words(blocks: int) -> np.ndarray:
    """Of each copy, `(4 blocks, 3)`, as numbers between 0 and 1; the last of a block's four comes first."""
    u32 = lambda values: jit.from_numpy(jit.UInt32, np.array(values, np.uint32))
    block, copies, episodes = np.repeat(np.arange(blocks), 3), COPIES * blocks, EPISODES * blocks
    four = philox((u32(block), u32(episodes), u32(MOMENTS * blocks), jit.UInt32(0)), (jit.UInt32(SEED), u32(copies)))
    found = [np.array(w) for w in four][::-1]
    table = (np.array(found, dtype=np.float64) + 0.5) / 2**32
    return table.reshape(4, blocks, 3).swapaxes(0, 1).reshape(-1, 3)


def rows(values: Any) -> np.ndarray:
    return np.stack([np.array(v) for v in values])


def test_numbers_are_those_of_seed_copy_episode_moment_and_place() -> None:
    """Nine at once: of three blocks, of which one is begun."""
    random, w = draws(), words(3)
    assert len(np.unique(w)) == 36
    plain = [random.uniform() for _ in range(2)]
    stretched = random.uniform(-3.0, 1.5)
    boxed = random.box((0.0, 5.0), (2.0, 4.0))
    z, turn = -1 + 2 * w[5], np.pi * (2 * w[6] - 1)
    way = random.direction()
    normal = random.normal(2.0, 0.7)
    expected = [w[0], w[1], -3 + 4.5 * w[2], 2 * w[3], 5 - w[4]]
    expected += [np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z]
    expected += [2 + 0.7 * np.sqrt(-2 * np.log(w[7])) * np.cos(2 * np.pi * w[8])]
    np.testing.assert_allclose(rows([*plain, stretched, *boxed, *way, normal]), expected, rtol=1e-12, atol=1e-15)


def test_normal_numbers_and_directions_are_spread_as_they_should_be() -> None:
    """Of 4096 copies: mean and deviation within five standard errors; directions even in all octants."""
    lanes, zero = jit.from_numpy(jit.UInt32, np.arange(4096, dtype=np.uint32)), jit.UInt32(0)
    random = Draws(zero, lanes, zero, zero)
    normal, way = np.array(random.normal()), rows(random.direction())
    assert abs(normal.mean()) < 5 / 64
    assert abs(normal.std() - 1) < 5 / 64 / np.sqrt(2)
    np.testing.assert_allclose(np.linalg.norm(way, axis=0), 1.0, rtol=1e-12)
    octants = np.bincount(((way > 0) * [[1], [2], [4]]).sum(axis=0), minlength=8)
    assert abs(octants - 512).max() < 5 * np.sqrt(512 * 7 / 8)
