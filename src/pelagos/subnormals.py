"""Numbers too small for full precision, taken for 0 in every thread alike."""

from __future__ import annotations

import os
import platform
import threading
from typing import Final

from pelagos.errors import DeviceError

FLUSHING: Final[set[int]] = set()  # threads that do
_FORKED: Final[list[int]] = []  # the process, where it was forked from one that had chosen its device


def forget_threads() -> None:
    """In a process that was forked: its parent's threads are not there."""
    FLUSHING.clear()  # so that the next call looks
    _FORKED.append(os.getpid())


def flush_subnormals() -> None:
    """Have the calling thread take numbers below 1.2e-38 (single), 2.2e-308 (double) for 0, as Dr.Jit's own threads do.

    The calling thread computes a share of a kernel, and all of it where it is the only one: without this, what is that
    small would depend on the number of threads. The mode is bits of a register that C's `fesetenv` sets.
    """
    import ctypes

    if _FORKED:
        raise DeviceError(
            "this process was forked from one that had used Pelagos, whose threads it lacks; start workers with "
            "multiprocessing.get_context('spawn'), or fork before the first simulation is made"
        )
    FLUSHING.add(threading.get_ident())
    x86, system = platform.machine().lower() in ("x86_64", "amd64", "i686"), platform.system()
    if system == "Windows":
        ctypes.CDLL("ucrtbase")._controlfp_s(ctypes.byref(ctypes.c_uint()), 0x01000000, 0x03000000)  # _DN_FLUSH
        return
    # where the register stands in fenv_t [bytes], and its bits: MXCSR's flush-to-zero and denormals-are-zero, FPCR's FZ
    at, bits = ((4 if system == "Darwin" else 28), 0x8040) if x86 else ((8 if system == "Darwin" else 0), 1 << 24)
    library, environment = ctypes.CDLL(None), (ctypes.c_uint32 * 16)()
    if hasattr(library, "fegetenv") and library.fegetenv(environment) == 0:
        environment[at // 4] |= bits
        library.fesetenv(environment)
