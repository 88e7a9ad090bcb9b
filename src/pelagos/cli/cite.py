"""`pelagos cite`: where the models come from."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rich.markup import escape

from pelagos.cli.console import out
from pelagos.cli.trusted import load
from pelagos.config import registry


def print_sources(path: Path | None, *, trust: bool = False) -> None:
    """Print the sources of every component, or of those that a scenario uses."""
    for kind in ("vehicle", "sensor"):
        names = registry.entries(kind) if path is None else _used(path, kind, trust)
        for name in names:
            component = registry.find(kind, name).load()
            sources = tuple(getattr(component, "SOURCES", ()))
            if sources:
                out.print(f"[bold]{name}[/bold]")
            for source in sources:
                out.print(f"  {escape(source)}")


def _used(path: Path, kind: registry.Kind, trust: bool) -> Iterable[str]:
    agents = load(path, trust=trust).members.values()
    if kind == "vehicle":
        return sorted({agent.vehicle.type for agent in agents})
    return sorted({config.type for agent in agents for config in agent.sensors.values()})
