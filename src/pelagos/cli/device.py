"""`python -m pelagos.cli.device`: say what Pelagos would compute on, or what is missing; `make` asks this."""

from __future__ import annotations

import sys

from pelagos.errors import DeviceError
from pelagos.llvm import find_llvm


def describe_device() -> str:
    """The device in one line, after it has computed something.

    Raises:
        DeviceError: there is no usable device.
    """
    import drjit as dr

    from pelagos import jit

    total = dr.opaque(jit.Float64, 1.0) + 1.0
    dr.eval(total)
    if jit.device == "cuda":
        return "NVIDIA GPU"
    return f"CPU through {find_llvm()}, {dr.thread_count()} threads"


if __name__ == "__main__":
    try:
        print(describe_device())
    except DeviceError as error:
        sys.exit(str(error))
