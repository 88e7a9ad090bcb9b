"""Kernels that compile in a fraction of the time: half of what the tests take on an empty cache is to compile.

Nothing of it changes what is computed, but for sums over lanes, which four take in another order than eight.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import sys
from pathlib import Path
from typing import Final

import numpy as np

from pelagos import jit
from pelagos.errors import DeviceError
from pelagos.llvm import find_llvm

LANES: Final = "4"  # doubles of AVX2: with eight, each instruction on them is compiled twice
THREADS: Final = 1  # most kernels of tests are small: several threads would only wait for one another
OPTIONS: Final = (b"tests", b"-optimize-regalloc=false")
"""Registers are given block by block, without looking far ahead."""
LIGHTER: Final = (
    (b"default<O2>", b"default<O0>"),  # passes: what Dr.Jit hands over is free of repetitions and dead code
    (b'"no-stack-arg-probe"', b"noinline optnone    "),  # on a function: instructions are chosen without looking around
)
"""What Dr.Jit asks LLVM for, and what tests ask for, letter by letter in its place."""
ALIGNED: Final = 128  # bytes, those of sixteen doubles
_GET_HANDLER, _SET_HANDLER = 305, 304  # in the table of NumPy's C API
_NAME: Final = ctypes.create_string_buffer(b"mem_handler")  # a capsule keeps only where it lies


class _Handler(ctypes.Structure):
    """NumPy's `PyDataMem_Handler`."""

    _fields_ = (
        ("name", ctypes.c_char * 127),
        ("version", ctypes.c_uint8),
        *((name, ctypes.c_void_p) for name in ("context", "malloc", "calloc", "realloc", "free")),
    )


_HANDLER: Final = _Handler(b"aligned", 1)


def quicken() -> None:
    """Have kernels of this process, and lanes of those that it starts, compile as said above."""
    if os.name == "posix":
        os.environ.setdefault("PELAGOS_LANES", LANES)
    if sys.platform == "linux":
        align_numpy()
        try:
            library = ctypes.CDLL(str(find_llvm()))
        except DeviceError:  # a test says so, with what to install
            return
        library.LLVMParseCommandLineOptions(len(OPTIONS), (ctypes.c_char_p * len(OPTIONS))(*OPTIONS), None)
    start = jit._start

    def start_in_one_thread() -> None:
        start()
        import drjit as dr

        if sys.platform == "linux":
            for usual, lighter in LIGHTER:
                replace_text("libdrjit-core", usual, lighter)
        if "PELAGOS_THREADS" not in os.environ:
            dr.set_thread_count(THREADS)

    jit._start = start_in_one_thread


def replace_text(library: str, text: bytes, by: bytes) -> None:
    """Replace a text of equal length among the constants of a loaded library; one that has it not stays as it is."""
    for line in Path("/proc/self/maps").read_text().splitlines():
        if library not in line or " r--p " not in line:
            continue
        start, end = (int(address, 16) for address in line.split()[0].split("-"))
        place = ctypes.string_at(start, end - start).find(text)
        if place >= 0:
            protect = ctypes.CDLL(None).mprotect
            protect.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
            protect(start, end - start, mmap.PROT_READ | mmap.PROT_WRITE)
            ctypes.memmove(start + place, by, len(by))
            protect(start, end - start, mmap.PROT_READ)


def align_numpy() -> None:
    """Have NumPy's arrays begin at multiples of `ALIGNED`.

    Kernels read memory that is not aligned by other instructions: with NumPy's sixteen bytes, one of n arrays is
    compiled for up to 2^n cases, by chance.
    """
    core = sys.modules.get("numpy._core._multiarray_umath") or sys.modules["numpy.core._multiarray_umath"]  # 2, 1.26
    pointer, capsule = ctypes.pythonapi.PyCapsule_GetPointer, ctypes.pythonapi.PyCapsule_New
    pointer.restype, pointer.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    capsule.restype, capsule.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
    table = ctypes.cast(pointer(core._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p))
    usual = _Handler.from_address(pointer(ctypes.PYFUNCTYPE(ctypes.py_object)(table[_GET_HANDLER])(), _NAME.value))
    _HANDLER.context = ALIGNED  # which C's aligned_alloc takes first, as malloc(context, size)
    _HANDLER.malloc = ctypes.cast(ctypes.CDLL(None).aligned_alloc, ctypes.c_void_p).value
    _HANDLER.calloc, _HANDLER.realloc, _HANDLER.free = usual.calloc, usual.realloc, usual.free
    made = capsule(ctypes.addressof(_HANDLER), ctypes.addressof(_NAME), None)
    ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.py_object)(table[_SET_HANDLER])(made)
    assert np.ones(3).ctypes.data % ALIGNED == 0
