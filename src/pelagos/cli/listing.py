"""`pelagos list`: what a scenario can name, one line each."""

from __future__ import annotations

from typing import Final

from rich.markup import escape

from pelagos.cli.console import out
from pelagos.config import registry
from pelagos.sensors.sonar_catalogue import DEVICES

KINDS: Final[dict[str, registry.Kind]] = {"vehicles": "vehicle", "sensors": "sensor", "worlds": "world"}


def print_list(what: str) -> None:
    """Print a table's names, each with one line about it and the package that brought it."""
    if what == "devices":
        _print_devices()
        return
    entries = registry.entries(KINDS[what])
    width = max(len(name) for name in entries)
    for name, entry in entries.items():
        source = f" (from {entry.package})" if entry.package else ""
        out.print(f"[bold]{name:{width}}[/bold]  {escape(entry.title + source)}")


def _print_devices() -> None:
    """Print the sonars of the catalogue: name, the sensor type whose `device` it is, title, source of its numbers."""
    width = max(len(name) for devices in DEVICES.values() for name in devices)
    for kind, devices in DEVICES.items():
        for name, device in devices.items():
            out.print(f"[bold]{name:{width}}[/bold]  {kind}: {escape(device.title)} ({escape(device.source)})")
