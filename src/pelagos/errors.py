"""Everything that Pelagos raises on purpose.

PelagosError
+-- InputError          the user's input is wrong (command line exits with 2)
|   +-- ScenarioError   a scenario file, key or value        (carries file, line and key path)
|   +-- WorldError      a mesh, survey or generated world
|   +-- LookupFailed    an unknown name, with the nearest match
|   |   +-- UnknownKey  the same of a mapping, such as readings (a KeyError too)
|   +-- NoReading       a sensor has none in this step (a KeyError too)
|   +-- CommandError    a command, state or argument of the Python face
+-- KernelError         a recorded kernel uses what it is not given, or keeps something
+-- DeviceError         no usable LLVM or GPU, with what to install
+-- SimulationError     a run went wrong (non-finite state); names vehicle, term and time
+-- RecordingError      a recording cannot be written or read
|   +-- NoRecording     a file that was given is no recording, or has not what is asked of it (an InputError too)
|   +-- NoPlace         something stands where a recording is to be written, or there is no folder (an InputError too)

Warnings: PelagosWarning <- ValidityWarning (a model used outside its range of validity), MountWarning (a sensor begins
inside something solid), RecordingWarning (a recording is damaged, and its rest is read), EndedWarning (a copy of a
fleet has ended by itself).
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from functools import partial
from typing import Any


class PelagosError(Exception):
    """Root of every error that Pelagos raises on purpose."""


class InputError(PelagosError):
    """The user's input is wrong; nothing was written."""


class ScenarioError(InputError):
    """A scenario is wrong at a known place (`where` is "file:line: key.path" when it came from a file)."""

    def __init__(self, message: str, *, where: str = "") -> None:
        super().__init__(f"{where}: {message}" if where else message)
        self.where = where
        self.message = message

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), where=self.where), (self.message,), self.__dict__


class WorldError(InputError):
    """A mesh, a survey or a generated world cannot be used."""


class CommandError(InputError):
    """A command, state or argument has the wrong shape, or is not finite."""


class KernelError(PelagosError):
    """A kernel cannot be recorded as it is written; the message tells the author of a sensor or term the cure."""


class DeviceError(PelagosError):
    """No usable compute device; the message says what to install."""


class SimulationError(PelagosError):
    """A run went wrong; names the vehicle, the term and the time."""


class RecordingError(PelagosError):
    """A recording cannot be written or read."""


class NoRecording(RecordingError, InputError):
    """A file that was given is no recording, or one without what is to be shown."""


class NoPlace(RecordingError, InputError):
    """A recording is to be written where something stands already, or where no folder is."""


class LookupFailed(InputError):
    """A name is not in a closed set; the message lists what would have worked."""

    def __init__(self, kind: str, given: object, known: Iterable[str], *, where: str = "") -> None:
        names = sorted(known)
        near = did_you_mean(given, names) if isinstance(given, str) else ""
        message = f"unknown {kind} {given!r}{near}; known: {', '.join(names)}"
        super().__init__(f"{where}: {message}" if where else message)
        self.kind = kind
        self.given = given
        self.known = names
        self.where = where

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), where=self.where), (self.kind, self.given, self.known), self.__dict__


class UnknownKey(LookupFailed, KeyError):
    """A name that a mapping does not have; a KeyError, so that `in` and `get` answer as for any mapping."""

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError would show its representation


class NoReading(InputError, KeyError):
    """A sensor that has no reading in a step is asked for one; a KeyError as `UnknownKey` is."""

    def __str__(self) -> str:
        return str(self.args[0])


class PelagosWarning(UserWarning):
    """Root of every warning that Pelagos issues."""


class ValidityWarning(PelagosWarning):
    """A model is used outside its published range of validity."""


class EndedWarning(PelagosWarning):
    """The state of one copy of a fleet is not finite any more; the others go on."""


class MountWarning(PelagosWarning):
    """A sensor begins inside something solid."""


class RecordingWarning(PelagosWarning):
    """A recording is damaged; the warning says where, and all the rest is read."""


def nearest(given: str, known: Iterable[str]) -> str | None:
    """The name in `known` most like `given`, or None."""
    match = difflib.get_close_matches(given, list(known), n=1, cutoff=0.5)
    return match[0] if match else None


def did_you_mean(given: str, known: Iterable[str]) -> str:
    """`" (did you mean 'x'?)"`, or an empty string where nothing is near."""
    match = nearest(given, known)
    return f" (did you mean {match!r}?)" if match else ""
