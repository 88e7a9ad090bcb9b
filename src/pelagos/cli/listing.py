"""`pelagos list`: what a scenario can name, one line each, and the keys of one of them."""

from __future__ import annotations

from typing import Final

from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import out
from pelagos.config import registry
from pelagos.config.described import descriptions
from pelagos.errors import InputError
from pelagos.sensors.sonar.keys.devices import DEVICES

KINDS: Final[dict[str, registry.Kind]] = {
    "vehicles": "vehicle",
    "sensors": "sensor",
    "worlds": "world",
    "bridges": "bridge",
}


def print_list(what: str) -> None:
    """Print a table's names, each with one line about it and the package that brought it."""
    if what == "devices":
        _print_devices()
        return
    if what == "tasks":
        _print_tasks()
        return
    entries = registry.entries(KINDS[what])
    width = max(len(name) for name in entries)
    for name, entry in entries.items():
        source = f" (from {entry.package})" if entry.package else ""
        out.print(f"[bold]{name:{width}}[/bold]  {escape(entry.title + source)}")


def print_keys(what: str, name: str) -> None:
    """Print the keys of one sensor, world or bridge: default, and what it is for.

    Raises:
        LookupFailed: there is none of that name.
        InputError: `what` has names without keys of their own.
    """
    if what not in ("sensors", "worlds", "bridges"):
        raise InputError(
            f"`list {what}` takes no name; keys are listed of sensors, worlds and bridges: `list sensors camera`"
        )
    entry = registry.find(KINDS[what], name)
    out.print(f"[bold]{name}[/bold]: {escape(entry.title)}")
    table = Table("key", "default", "", box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    texts = descriptions(entry.config)
    for key, field in entry.config.model_fields.items():
        default = "required" if field.is_required() else str(field.get_default(call_default_factory=True))
        table.add_row(key, escape(default), escape(texts.get(key, "")))
    out.print(table, soft_wrap=False)


def _print_devices() -> None:
    """Print the sonars of the catalogue: name, the sensor type whose `device` it is, title, source of its numbers."""
    width = max(len(name) for devices in DEVICES.values() for name in devices)
    for kind, devices in DEVICES.items():
        for name, device in devices.items():
            out.print(f"[bold]{name:{width}}[/bold]  {kind}: {escape(device.title)} ({escape(device.source)})")


def _print_tasks() -> None:
    """Print what `pelagos train` and `pelagos.envs.make` take, with the first line of each task's account."""
    from pelagos.envs.registry import task_class, task_names

    width = max(len(name) for name in task_names())
    for name in task_names():
        line = (task_class(name).__doc__ or "").strip().splitlines()[0]
        out.print(f"[bold]{name:{width}}[/bold]  {escape(line)}")
