"""The walk of a reading: the functions of Pelagos that run while it is computed without a recording."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import pelagos
from pelagos.cli.console import shown

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics
    from pelagos.sim.simulation import Simulation

SOURCE: Final = Path(pelagos.__file__).parent


@dataclass(frozen=True)
class Passed:
    """A function that ran.

    Attributes:
        room: its file, relative to the package ("acoustics/absorption.py").
        line: where it begins.
        name: qualified where Python tells.
    """

    room: str
    line: int
    name: str

    @property
    def address(self) -> str:
        """ "file:line name"."""
        return f"{shown(SOURCE / self.room)}:{self.line} {self.name}"


def last_motion(sim: Simulation, agent: str) -> Kinematics:
    """Motion of an agent at the last tick, one lane a copy, as its sensors are given it."""
    last = sim.stepper.tick
    return sim.stepper.sensing.motion_of(range(last, last + 1), agent)


def walked(work: Callable[[], Any]) -> tuple[list[Passed], Any]:
    """The functions that ran, in the order of their first calls, without those of comprehensions; and the result."""
    found: dict[Any, Passed | None] = {}

    def note(frame: Any, event: str, argument: Any) -> None:
        code = frame.f_code
        if event == "call" and code not in found and code.co_filename.startswith(str(SOURCE)):
            name = getattr(code, "co_qualname", code.co_name)
            room = Path(code.co_filename).relative_to(SOURCE).as_posix()
            found[code] = None if "<" in name.replace("<locals>", "") else Passed(room, code.co_firstlineno, name)

    sys.setprofile(note)
    try:
        result = work()
    finally:
        sys.setprofile(None)
    return [p for p in found.values() if p is not None], result


def rooms(passed: list[Passed]) -> dict[str, list[str]]:
    """Names of the functions by file, in the order of first calls."""
    by_room: dict[str, list[str]] = {}
    for one in passed:
        by_room.setdefault(one.room, []).append(one.name)
    return by_room
