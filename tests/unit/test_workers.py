"""Workers: errors travel between processes, and what cannot work in one is a sentence."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys

import pytest
from pydantic_core import _pydantic_core

from pelagos import errors
from pelagos.errors import LookupFailed, PelagosError, ScenarioError, UnknownKey

MADE = [
    LookupFailed("sensor", "imo", ["imu", "dvl"], where="a.yaml:3"),
    UnknownKey("sensor", "imo", ["imu", "dvl"], where="a.yaml:3"),
    ScenarioError("wrong", where="a.yaml:3: agents"),
    *[kind("what went wrong") for kind in vars(errors).values()
      if isinstance(kind, type) and issubclass(kind, PelagosError) and not issubclass(kind, LookupFailed)],
]  # fmt: skip


@pytest.mark.parametrize("error", MADE, ids=lambda e: type(e).__name__)
def test_errors_pickle(error: PelagosError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"PELAGOS_THREADS": "1000000"}, "PELAGOS_THREADS must be a whole number from 1 to 1024"),
        ({"PELAGOS_THREADS": "²"}, "PELAGOS_THREADS must be a whole number from 1 to 1024"),
        ({"PELAGOS_LANES": "6"}, "PELAGOS_LANES must be 4, 8 or 16, not '6'"),
        ({"DRJIT_LIBLLVM_PATH": __file__}, "cannot be loaded"),
        ({"DRJIT_LIBLLVM_PATH": _pydantic_core.__file__}, "is no libLLVM 16 or newer"),  # a library, but another
    ],
)
def test_what_cannot_be_used_is_a_sentence(variables: dict[str, str], message: str) -> None:
    code = "import pelagos.jit as j, pelagos.errors as p\ntry: j.Float\nexcept p.DeviceError as e: print(e)"
    environment = {**os.environ, "PELAGOS_DEVICE": "cpu", **variables}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert message in done.stdout


def lanes(told: str | None) -> tuple[int, list[float]]:
    """How many lanes the code of a kernel has that another process compiles, and what comes of it."""
    code = """
import re
from pelagos import jit
import drjit as dr
x = jit.Float64([1.5, -2.25, 3.0]) * 1.125 + 0.5
with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
    dr.eval(x)
    text = dr.kernel_history([dr.KernelType.JIT])[-1]["ir"].getvalue()
print(re.search(r"<(\\d+) x double>", text)[1], *x)
"""
    environment = {k: v for k, v in os.environ.items() if k != "PELAGOS_LANES"} | {"PELAGOS_DEVICE": "cpu"}
    environment |= {} if told is None else {"PELAGOS_LANES": told}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    width, *values = done.stdout.split()
    return int(width), [float(v) for v in values]


def test_kernels_have_at_most_the_lanes_that_were_told() -> None:
    most, values = lanes(None)
    assert values == [1.5 * 1.125 + 0.5, -2.25 * 1.125 + 0.5, 3.0 * 1.125 + 0.5]
    for told in ("4", "8", "16"):
        assert lanes(told) == (min(int(told), most), values)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_a_fork_after_use_is_refused() -> None:
    code = """
import os, sys, pelagos as pl
from pelagos import jit
from pelagos.errors import DeviceError
frozen = jit.freeze(lambda x: x + 1)
frozen(jit.Float(1.0))
if os.fork() == 0:
    try: frozen(jit.Float(1.0))
    except DeviceError as error: print(error, flush=True)
    os._exit(0)
os.wait()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert "multiprocessing.get_context('spawn')" in done.stdout
