"""From a world's configuration to the world."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from pelagos.config import registry
from pelagos.errors import LookupFailed, WorldError
from pelagos.world.by_hand import with_things
from pelagos.world.config import WorldKind
from pelagos.world.doubt import doubts, missing_files
from pelagos.world.files import read_mesh
from pelagos.world.mover import MoverConfig, checked
from pelagos.world.world import World


def build_world(config: WorldKind) -> World:
    """Build a world.

    Raises:
        WorldError: a file cannot be read, or the world cannot be made.
    """
    world = config.build()
    if config.labels:  # a saved world may have some of its own
        world = replace(world, user_labels={**world.user_labels, **config.labels})
    if config.things and not config.PLACES_THINGS:
        world = with_things(world, config.things)
    if not config.movers:
        return world
    movers = (*world.movers, *config.movers)
    try:
        checked(movers)
    except ValueError as error:
        raise WorldError(str(error)) from None
    odd = [note for m in config.movers if m.file is not None for note in _doubts(m)]
    return replace(world, movers=movers, notes=(*world.notes, *odd))


def _doubts(mover: MoverConfig) -> list[str]:
    """Doubts about a mover's mesh file."""
    assert mover.file is not None
    mesh = read_mesh(mover.file).scaled(mover.size_m or 1.0)
    return [*doubts(mesh, f"mover {mover.name}"), *missing_files(mover.file)]


def world_config(values: dict[str, object]) -> WorldKind:
    """A world's configuration from plain values: `{"type": "flat", "depth_m": 20}`.

    Raises:
        LookupFailed: no kind of world has this `type`.
    """
    kind = values.get("type")
    known = registry.entries("world")
    if not isinstance(kind, str) or kind not in known:
        raise LookupFailed("world", str(kind), known)
    made = known[kind].config.model_validate(values)
    return cast(WorldKind, made)


def world_types() -> dict[str, str]:
    """Every kind of world with one line about it."""
    return {name: entry.title for name, entry in registry.entries("world").items()}
