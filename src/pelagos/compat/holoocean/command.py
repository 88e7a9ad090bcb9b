"""HoloOcean's commands on the wire, as data: scripts that build them see the same JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Final

from pelagos.compat.holoocean.exceptions import HoloOceanException

BUFFER: Final = 1_048_576  # [B]


class Command:
    """A name, numbers and texts."""

    wire: str = ""

    def __init__(self, *parameters: Any, **named: Any) -> None:
        self._command_type = self.wire
        parameters += tuple(named.values())
        self.numbers = [p for p in _flat(parameters) if isinstance(p, int | float) and not isinstance(p, bool)]
        self.numbers += [int(p) for p in _flat(parameters) if isinstance(p, bool)]
        self.strings = [p for p in _flat(parameters) if isinstance(p, str)]

    def set_command_type(self, command_type: str) -> None:
        """Another name."""
        self._command_type = command_type

    def add_number_parameters(self, number: Any) -> None:
        """A number, or several."""
        self.numbers += list(number) if isinstance(number, list | tuple) else [number]

    def add_string_parameters(self, string: Any) -> None:
        """A text, or several."""
        self.strings += list(string) if isinstance(string, list | tuple) else [string]

    def to_json(self) -> str:
        """As the engine would get it."""
        params = [{"value": n} for n in self.numbers] + [{"value": s} for s in self.strings]
        return json.dumps({"name": self._command_type, "params": params})


def _flat(values: Sequence[Any]) -> list[Any]:
    found: list[Any] = []
    for value in values:
        found += _flat(value) if isinstance(value, list | tuple) else [value]
    return found


class CommandsGroup:
    """Commands that go together."""

    def __init__(self) -> None:
        self._commands: list[Command] = []

    def add_command(self, command: Command) -> None:
        """One more."""
        self._commands.append(command)

    def to_json(self) -> str:
        """As the engine would get them."""
        return '{"commands": [' + ", ".join(c.to_json() for c in self._commands) + "]}"

    def clear(self) -> None:
        """None any more."""
        self._commands.clear()

    @property
    def size(self) -> int:
        """Number of commands."""
        return len(self._commands)


class CommandCenter:
    """A queue of commands."""

    def __init__(self, client: Any = None) -> None:
        self._client, self._commands = client, CommandsGroup()

    def enqueue_command(self, command: Command) -> None:
        """One more."""
        self._commands.add_command(command)

    def handle_buffer(self) -> None:
        """Empty the queue.

        Raises:
            HoloOceanException: more than HoloOcean's buffer takes.
        """
        if len(self._commands.to_json()) > BUFFER:
            raise HoloOceanException(f"commands are longer than the buffer of {BUFFER} bytes")
        self._commands.clear()

    def clear(self) -> None:
        """Forget them."""
        self._commands.clear()

    @property
    def queue_size(self) -> int:
        """Number of commands that wait."""
        return self._commands.size


WIRE_NAMES: Final = (
    "SpawnAgent", "DebugDraw", "TeleportCamera", "AddSensor", "RemoveSensor", "RotateSensor", "OceanCurrents",
    "RenderViewport", "RGBCameraRate", "RaycastLidarRate", "AdjustRenderQuality", "WaterColor", "Tide", "ChangeWeather",
    "SetRainParameters", "ChangeTimeOfDay", "AdjustFPS", "AdjustTPS", "TurnOnFlashlight", "TurnOffFlashlight", "AirFog",
    "WaterFog", "CustomCommand", "SendAcousticMessage", "SendOpticalMessage", "ChangeBuoyancy", "ChangeWorldCollisions",
    "DebugLines", "FFTWave", "SpawnWaterZone",
)  # fmt: skip


class CustomCommand(Command):
    """A command to the level, by its name, with numbers and texts."""

    wire = "CustomCommand"

    def __init__(self, name: str, num_params: Any = None, string_params: Any = None) -> None:
        super().__init__(list(num_params or ()), [name, *(string_params or ())])


globals().update(
    {
        f"{name}Command": type(f"{name}Command", (Command,), {"wire": name, "__doc__": f"The command {name}."})
        for name in WIRE_NAMES
    }
)
