"""`pelagos holoocean`: run a program in which `import holoocean` is Pelagos, or turn a scenario into a native one."""

from __future__ import annotations

import importlib.util
import os
import runpy
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from pelagos.compat.holoocean.importing import install
from pelagos.compat.holoocean.settings import LEGACY, SEED, STRICT
from pelagos.errors import InputError, PelagosError


def run_program(
    arguments: Sequence[str], *, module: str | None, legacy_dynamics: bool, seed: int | None, strict: bool
) -> None:
    """Run a script, or a module, with its arguments.

    Raises:
        InputError: neither, or the script is not there.
    """
    if legacy_dynamics:
        os.environ[LEGACY] = "1"
    if strict:
        os.environ[STRICT] = "1"
    if seed is not None:
        os.environ[SEED] = str(seed)
    install()
    if module is not None:
        sys.argv = [module, *arguments]
        sys.path.insert(0, str(Path.cwd()))
        _known(module)
        with _own_traceback():
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        return
    if not arguments:
        raise InputError("give a script: pelagos holoocean SCRIPT.py [ARGS...], or -m MODULE [ARGS...]")
    script = Path(arguments[0])
    if not script.is_file():
        raise InputError(f"there is no script {script}")
    sys.argv = [str(script), *arguments[1:]]
    sys.path.insert(0, str(script.resolve().parent))
    with _own_traceback():
        runpy.run_path(str(script), run_name="__main__")


def _known(module: str) -> None:
    """Refuse a module that is not there.

    Raises:
        InputError: there is no such module.
    """
    try:
        there = importlib.util.find_spec(module) is not None
    except ModuleNotFoundError:
        there = False
    if not there:
        raise InputError(f"there is no module {module!r} to run")


@contextmanager
def _own_traceback() -> Iterator[None]:
    """Tell a program's errors as Python does: from its own first line on, with exit status 1."""
    try:
        yield
    except PelagosError:
        raise
    except Exception as error:
        trace, inside = error.__traceback__, False
        while trace is not None and (not inside or _of_runpy(trace)):
            inside = inside or _of_runpy(trace)
            trace = trace.tb_next
        traceback.print_exception(type(error), error, trace)
        raise SystemExit(1) from None


def _of_runpy(trace: TracebackType) -> bool:
    return "runpy" in trace.tb_frame.f_code.co_filename


def convert(scenario: Path, rest: Sequence[str]) -> None:
    """Write a native scenario that simulates the same, to the file that `rest` names.

    Raises:
        InputError: there is not one such file, or the scenario cannot be read, or cannot be.
    """
    if len(rest) != 1:
        raise InputError("give one file to write to: pelagos holoocean --convert SCENARIO.json OUT.yaml")
    out = Path(rest[0])
    from pelagos.compat.holoocean.convert import converted

    out.write_text(converted(scenario), encoding="utf-8")
