"""Frozen calls: other sizes, and garbage that falls due in the middle of a recording."""

import gc
import os
import subprocess
import sys

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit


def test_other_sizes_are_other_recordings() -> None:
    twice = jit.freeze(lambda x: dr.concat([x, 2 * x]))
    for size in (3, 1000, 3, 1, 70_000, 7):
        x = np.arange(size, dtype=np.float64)
        assert np.array_equal(np.array(twice(jit.Float64(x))), np.concatenate([x, 2 * x]))


@pytest.mark.parametrize("count", [1, 3, 511, 4096])
@pytest.mark.parametrize("off", [0, 1, 5, 31])
def test_padded_arrays_begin_at_a_packet(off: int, count: int) -> None:
    """Wherever they began: one kernel does for all."""
    values = np.arange(off + count, dtype=np.float64)[off:] - 2.5
    moved = jit.padded(values)
    assert moved.ctypes.data % 256 == 0
    assert moved.dtype == values.dtype
    assert (moved == values).all()


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
    note = seen.append  # the list itself may not change while a kernel is recorded

    def body(x):
        note(gc.isenabled())
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
    thin = jit.without_constants(fat)
    assert isinstance(thin, Outer)
    assert (thin.none, thin.name, thin.empty, thin.parts[0].count) == (None, "sea", {}, 3)
    assert list(type(thin).DRJIT_STRUCT) == ["parts"]
    frozen = jit.freeze(lambda s, x: s.parts[0].gain * s.parts[0].count + x + len(s.name))
    for x in (1.0, 2.0):
        assert np.array(frozen(thin, dr.opaque(jit.Float64, x))).tolist() == [6 + x, 9 + x]
    other = jit.without_constants(Outer([Inner(jit.Float64([1.0, 2.0]), 5)], None, "sea", {}))
    assert np.array(frozen(other, dr.opaque(jit.Float64, 1.0))).tolist() == [9, 14]


def _at(array: object) -> int:
    """Where its memory begins."""
    return int(np.array(array, copy=False).ctypes.data)


def test_settled_arrays_are_aligned_and_their_own() -> None:
    """Whatever memory they were made of: NumPy's begins anywhere, and what it holds later does not matter."""
    several = np.arange(64, dtype=np.float32)
    rows = np.arange(30, dtype=np.float64).reshape(3, 10)
    whole = {"a": jit.Float(several[1:33]), "b": [jit.Array3f64(rows), jit.UInt32(np.arange(5, dtype=np.uint32))]}
    jit.align(whole, None, 3, "text")
    several[:], rows[:] = -1, -1
    assert np.array_equal(whole["a"], np.arange(1, 33))
    assert np.array_equal(whole["b"][0], np.arange(30).reshape(3, 10))
    assert np.array_equal(whole["b"][1], np.arange(5))
    if str(jit.mi.variant()).startswith("llvm"):
        assert _at(whole["a"]) % 64 == 0
        assert _at(whole["b"][1]) % 64 == 0


def test_tables_are_settled_within_structs() -> None:
    @jit.struct
    class Table:
        values: jit.Array
        size: int

    data = np.arange(65, dtype=np.float64)
    table = Table(jit.Float64(data[1:]), 3)
    jit.align(table)
    data[:] = 0
    assert np.array_equal(table.values, np.arange(1, 65))
    assert table.size == 3
    assert np.array_equal(jit.from_numpy(jit.UInt32, np.array([[1, 2], [3, 4]], dtype=np.uint8)), [1, 2, 3, 4])


SUBNORMAL = """
import numpy as np, drjit as dr
import pelagos as pl
from pelagos import jit
def times(x, y): return x * y
frozen = jit.freeze(times)
for n in (1, 1000, 100_000):
    x = jit.Float(np.full(n, 1e-30, np.float32))
    print(np.count_nonzero(np.array(frozen(x, dr.opaque(jit.Float, 1e-10)))))
print(np.count_nonzero(np.array([3e-310]) * 1e9), np.count_nonzero(np.array([3e-300]) * 1e-9))
"""


@pytest.mark.parametrize("threads", ["1", "2"])
def test_subnormal_numbers_are_nothing_on_any_number_of_threads(threads: str) -> None:
    environment = {**os.environ, "PELAGOS_THREADS": threads, "PELAGOS_DEVICE": "cpu"}
    done = subprocess.run(
        [sys.executable, "-c", SUBNORMAL], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["0"] * 5


def test_no_kernel_reads_beyond_the_last_page() -> None:
    """Arrays that end where the memory that may be read ends; a kernel reads packets of sixteen lanes."""
    code = """
import ctypes, mmap
import numpy as np
import pelagos as pl
from pelagos import jit
size = 4 * mmap.PAGESIZE
area = mmap.mmap(-1, size + mmap.PAGESIZE)
whole = np.frombuffer(area, dtype=np.uint8)
libc = ctypes.CDLL(None, use_errno=True)
libc.mprotect.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
assert libc.mprotect(whole.ctypes.data + size, mmap.PAGESIZE, 0) == 0
for kind, dtype in ((jit.Float, np.float32), (jit.Float64, np.float64), (jit.UInt32, np.uint32)):
    for count in (1, 3, 17, 1003):
        values = whole[size - count * np.dtype(dtype).itemsize : size].view(dtype)
        values[:] = np.arange(count) % 7
        assert (np.array(jit.from_numpy(kind, values)) == np.arange(count) % 7).all()
        assert (jit.padded(values) == values).all()
        far = jit.padded(values)
        assert (far.ctypes.data + far.nbytes <= whole.ctypes.data) or (far.ctypes.data >= whole.ctypes.data + size)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def test_what_casts_rays_is_recorded_once_beside_bodies_that_may_collide(monkeypatch: pytest.MonkeyPatch) -> None:
    """Meshes of collisions are loaded before: a shape more, and Dr.Jit records anew what sees a scene."""
    recorded: list[str] = []
    watched = jit.watched
    monkeypatch.setattr(jit, "watched", lambda owner, *rest: (recorded.append(str(owner)), watched(owner, *rest))[1])
    there = {"kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, -2.0, -3.5]], "speed_mps": 0.5}
    sim = pl.Simulation.load(
        {"tick_rate_hz": 20, "world": {"type": "flat", "movers": [{"name": "drum", "body": "box", "path": there}]},
         "agents": {"it": {"vehicle": "remus100", "start": {"position_m": [0.0, 0.0], "depth_m": 3.0},
                           "sensors": {"altimeter": {"type": "altimeter", "rate_hz": 10}}}}}
    )  # fmt: skip
    assert np.isfinite(sim.reset()["it"]["altimeter"].data).all()
    for _ in range(6):
        sim.step()
    assert len(recorded) > 2
    assert len(recorded) == len({*recorded})
