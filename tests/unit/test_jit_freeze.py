"""Frozen calls: other sizes, and garbage that falls due in the middle of a recording."""

import gc

import drjit as dr
import numpy as np

from pelagos import jit


def test_other_sizes_are_other_recordings() -> None:
    twice = jit.freeze(lambda x: dr.concat([x, 2 * x]))
    for size in (3, 1000, 3, 1, 70_000, 7):
        x = np.arange(size, dtype=np.float64)
        assert np.array_equal(np.array(twice(jit.Float64(x))), np.concatenate([x, 2 * x]))


def test_numbers_among_the_arguments_are_not_taken_for_sizes() -> None:
    """Dr.Jit tells an object that it met before in the same call by its address, and Python has only one 2."""
    twice = jit.freeze(lambda x, held: dr.concat([x, held[0] * x]))
    held = [2.0, 0, 1, 2, 3, 4, 5]
    for size in (1, 2, 3, 4, 3, 5, 2):
        x = np.arange(size, dtype=np.float64)
        assert np.array_equal(np.array(twice(jit.Float64(x), held)), np.concatenate([x, 2 * x]))


def test_arguments_of_several_sizes() -> None:
    gather = jit.freeze(lambda table, pair: dr.gather(jit.Float64, table, pair[0]) + pair[1])
    for rows in (2, 5, 9):
        table = jit.Float64(np.arange(rows) * 10.0)
        pair = (jit.UInt32([rows - 1, 0, 1]), jit.Float64(0.5))
        assert np.array(gather(table, pair)).tolist() == [10.0 * (rows - 1) + 0.5, 0.5, 10.5]


def test_garbage_is_not_collected_while_recording() -> None:
    class Cycle:
        def __init__(self) -> None:
            self.me = self
            self.shared = jit.Float64(np.arange(100_000.0))

    seen: list[bool] = []

    def body(x):
        seen.append(gc.isenabled())
        return x + 1

    Cycle()
    assert np.array(jit.freeze(body)(jit.Float64(1, 2))).tolist() == [2, 3]
    assert seen == [False]
    assert gc.isenabled()


def test_the_same_sizes_are_recorded_once() -> None:
    @jit.struct
    class Pair:
        left: object = None
        right: object = None

    class Count:  # a list would be an input of the frozen function
        calls = 0

    def body(pair, vector, key):
        Count.calls += 1
        return pair.left + vector[0] + pair.right + dr.gather(jit.Float64, key[0], jit.UInt32(0))

    frozen = jit.freeze(body)
    for k in range(5):
        pair = Pair(left=dr.opaque(jit.Float64, float(k)), right=jit.Float64([1.0, 2.0]))
        vector, key = jit.Array3f64([3.0, 4.0], 0.0, 0.0), (jit.Float64([7.0, 8.0, 9.0]),)
        dr.make_opaque(pair.right, vector, key)
        assert np.array(frozen(pair, vector, key)).tolist() == [k + 11.0, k + 13.0]
    assert Count.calls == 1


def test_slim_structs_keep_their_values_and_leave_only_arrays_to_look_at() -> None:
    @jit.struct
    class Inner:
        gain: object = None
        count: int = 0

    @jit.struct
    class Outer:
        parts: list
        none: object
        name: str
        empty: dict

    fat = Outer([Inner(jit.Float64([1.0, 2.0]), 3)], None, "sea", {})
    thin = jit.slim(fat)
    assert isinstance(thin, Outer)
    assert (thin.none, thin.name, thin.empty, thin.parts[0].count) == (None, "sea", {}, 3)
    assert list(type(thin).DRJIT_STRUCT) == ["parts"]
    frozen = jit.freeze(lambda s, x: s.parts[0].gain * s.parts[0].count + x + len(s.name))
    for x in (1.0, 2.0):
        assert np.array(frozen(thin, dr.opaque(jit.Float64, x))).tolist() == [6 + x, 9 + x]
    other = jit.slim(Outer([Inner(jit.Float64([1.0, 2.0]), 5)], None, "sea", {}))
    assert np.array(frozen(other, dr.opaque(jit.Float64, 1.0))).tolist() == [9, 14]
