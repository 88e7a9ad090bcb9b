"""The plan of a data set: which shard holds which samples of which world, and everything that its bytes depend on."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from typing import Any, Final

from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.datasets.config import SPLITS, DatasetConfig
from pelagos.datasets.distribution import stream
from pelagos.datasets.rig import Rig, rig_of
from pelagos.errors import InputError, ScenarioError

PACKAGES: Final = ("pelagos", "mitsuba", "drjit", "numpy", "pillow")


@dataclass(frozen=True)
class Shard:
    """Samples that are made together: all of one world.

    Attributes:
        index: of the shard.
        world: its number.
        split: "train", "val" or "test".
        first: number of its first sample in the data set.
        count: samples.
    """

    index: int
    world: int
    split: str
    first: int
    count: int

    @property
    def name(self) -> str:
        """Name of its files."""
        return f"shard-{self.index:06d}"


@dataclass(frozen=True)
class Plan:
    """A data set before it is made.

    Attributes:
        config: as given.
        rig: what reads.
        versions: of the packages that its bytes depend on.
    """

    config: DatasetConfig
    rig: Rig
    versions: Mapping[str, str]

    @property
    def shards_per_world(self) -> int:
        """Shards of each world."""
        return -(-self.config.samples_per_world // self.config.shard_size)

    @property
    def shards(self) -> int:
        """Number of shards."""
        return self.config.worlds * self.shards_per_world

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.config.worlds * self.config.samples_per_world

    def shard(self, index: int) -> Shard:
        """The shard of a number from 0 on."""
        world, part = divmod(index, self.shards_per_world)
        size = self.config.shard_size
        count = min(size, self.config.samples_per_world - part * size)
        first = world * self.config.samples_per_world + part * size
        return Shard(index, world, self.splits[world], first, count)

    @cached_property
    def splits(self) -> list[str]:
        """The split of each world: shares by largest remainder, worlds in random order."""
        given: dict[str, float] = {str(name): share for name, share in self.config.split.items()}
        worlds, shares = self.config.worlds, [given.get(name, 0.0) for name in SPLITS]
        counts = [int(share * worlds + 1e-9) for share in shares]
        rest = sorted(range(3), key=lambda k: counts[k] - shares[k] * worlds)
        for k in rest[: worlds - sum(counts)]:
            counts[k] += 1
        order = stream(self.config.seed, "split").permutation(worlds)
        found = [""] * worlds
        for place, name in enumerate(name for name, count in zip(SPLITS, counts, strict=True) for _ in range(count)):
            found[int(order[place])] = name
        return found

    def values(self, world: int) -> dict[str, Any]:
        """Values drawn for a world, by key of the scenario."""
        found = {k: d.draw(stream(self.config.seed, "world", world, k)) for k, d in self.config.vary.items()}
        if "world.seed" not in found and self._seeded:
            found["world.seed"] = int(stream(self.config.seed, "world", world, "seed").integers(2**31))
        return found

    @cached_property
    def _seeded(self) -> bool:
        return hasattr(self.scenario.world, "seed")

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario of the rig."""
        return load_scenario(self.rig.scenario, trust=True)

    @cached_property
    def text(self) -> str:
        """The plan as JSON: two plans of the same text make the same bytes on one kind of processor."""
        config = self.config.model_dump(mode="json", exclude={"scenario"})
        data = {"config": config, "scenario": self.rig.scenario, "versions": dict(self.versions)}
        return json.dumps(data, indent=1, sort_keys=True) + "\n"

    @cached_property
    def digest(self) -> str:
        """SHA-256 of `text`."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def plan_of(config: DatasetConfig, *, trust: bool = False) -> Plan:
    """The plan of a configuration; everything is checked that can be without a device.

    Args:
        config: see `load_config`.
        trust: let the scenario name functions of Python.

    Raises:
        InputError: something is wrong; says where, what was given and what is allowed.
    """
    scenario = load_scenario(config.scenario, trust=trust)
    versions = {name: version(name) for name in PACKAGES} | {"zlib": zlib.ZLIB_RUNTIME_VERSION}
    plan = Plan(config, rig_of(config, scenario), versions)
    _check_varied(plan)
    several = [name for name, share in config.split.items() if share > 0]
    alike = not plan._seeded and not any(key.startswith("world.") for key in config.vary)
    if alike and config.worlds > 1 and len(several) > 1:
        raise InputError(
            f"a world of type {plan.scenario.world.type!r} has no seed, and 'vary' has no key of the world: all worlds "
            "would be the same one, in several splits. Vary a key of the world, or give split: {train: 1}"
        )
    _check_classes(plan)
    return plan


def _check_varied(plan: Plan) -> None:
    sensors = f"agents.{plan.rig.agent}.sensors."
    for key, distribution in plan.config.vary.items():
        if not key.startswith(("world.", "ocean.", sensors)):
            raise ScenarioError(
                f"keys of 'world', 'ocean' and of the sensors ({sensors}...) can be drawn", where=f"vary.{key}"
            )
        for value in distribution.ends():
            try:
                load_scenario(plan.rig.scenario, overrides=plan.rig.follow({key: value}), trust=True)
            except InputError as error:
                raise ScenarioError(str(error), where=f"vary.{key}") from None


def _check_classes(plan: Plan) -> None:
    from pelagos.world.label import label_number

    for name in plan.config.classes + plan.config.poses.facing_labels:
        label_number(name, dict(getattr(plan.scenario.world, "labels", {}) or {}))
