"""Episodes of the copies of a fleet: their numbers, ends, and the names of their random streams."""

from __future__ import annotations

import numpy as np

from pelagos.sim.episodes import Episodes, stream_of


def _mixed(x: int) -> int:
    """Steele, Lea and Flood (2014), Figure 14, in whole numbers."""
    top = (1 << 64) - 1
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9 & top
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB & top
    return (x ^ (x >> 31)) >> 32


def test_episodes_of_copies_begin_and_end_each_by_themselves() -> None:
    made = Episodes(3, 40)
    first = [a.numpy().tolist() for a in made.names()]
    assert first == [[40, 41, 42], [0, 0, 0]]
    made.end(np.array([0, 2]), np.array([9, 7]))
    made.end(np.array([0, 2]), np.array([8, 12]))
    assert (made.ended[[0, 2]].tolist(), made.over.tolist(), made.any_over) == ([8, 7], [True, False, True], True)
    kept = made.memory()
    made.begin(np.array([False, True, True]), 20)
    assert (made.number.tolist(), made.began.tolist(), made.any_over) == ([0, 1, 1], [0, 20, 20], True)
    words = [40, _mixed(41 + (1 << 32)), _mixed(42 + (1 << 32))]
    assert [a.numpy().tolist() for a in made.names()] == [words, [0, 20, 20]]
    made.begin(np.array([True, False, True]), 31)
    assert (made.number.tolist(), made.over.any(), made.any_over) == ([1, 1, 2], False, False)
    made.recall(kept)
    assert (made.any_over, made.over.tolist()) == (True, [True, False, True])
    assert [a.numpy().tolist() for a in made.names()] == first
    made.begin(np.array([False, True, False]), 6)
    made.restart(5)
    assert (made.number.tolist(), made.began.tolist(), made.any_over, made.over.any()) == (
        [5] * 3,
        [0] * 3,
        False,
        False,
    )
    assert made.names()[0].numpy().tolist() == [_mixed(k + (5 << 32)) for k in (40, 41, 42)]
    large = np.array([(1 << 33) + 5, 7])
    assert stream_of(large, np.array([0, 3])).tolist() == [5, _mixed(7 + (3 << 32))]
