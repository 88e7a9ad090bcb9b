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
        ({"DRJIT_LIBLLVM_PATH": __file__}, "cannot be loaded"),
        ({"DRJIT_LIBLLVM_PATH": _pydantic_core.__file__}, "is no libLLVM 16 or newer"),  # a library, but another
    ],
)
def test_what_cannot_be_used_is_a_sentence(variables: dict[str, str], message: str) -> None:
    code = "import pelagos.jit as j, pelagos.errors as p\ntry: j.Float\nexcept p.DeviceError as e: print(e)"
    environment = {**os.environ, "PELAGOS_DEVICE": "cpu", **variables}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert message in done.stdout


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
