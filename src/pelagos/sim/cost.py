"""Memory of a run, estimated from its scenario before anything is allocated.

The factors are upper bounds of what was measured (peak resident memory of one process, LLVM, November 2026): a bare
vehicle takes 2.4 kB a copy, an IMU 0.48 kB a lane, a camera 0.13 kB a pixel, an imaging sonar 0.15 kB a ray, a
multibeam's water column 0.03 kB a cell, a LiDAR 0.11 kB a point.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pelagos.config import registry
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError

BLOCK_S: Final = 1.0  # the longest block of a run
_BASE: Final = 250e6  # [B], the process with its compiler
_COPY: Final = 3e3  # [B] of each agent and copy
_TICK: Final = 200.0  # [B] of each agent, copy and tick of a block
_LANE: Final = 600.0  # [B] of each reading of a block
_RAY: Final = 200.0  # [B]
_CELL: Final = 64.0  # [B] of each bin, sample or pixel that is summed
_NODE: Final = 150.0  # [B] of each node of a ground: vertices, faces, tree
_SHARE: Final = 0.8  # of what is free
_COUNTS: Final = (  # keys whose product is the number of rays of one reading
    ("width_px", "height_px"),
    ("beams", "rays_per_beam"),
    ("beams", "samples", "rays_along"),
    ("rays",),
    ("rays_per_side",),
)
_SUMS: Final = (("beams", "bins"), ("bins",), ("beams", "water_column_bins"), ("water_column_bins",), ("cells",))


@dataclass(frozen=True)
class Part:
    """One part of a run.

    Attributes:
        path: of the key, "agents.auv0.sensors.camera".
        memory: [B].
        rays_per_s: cast for all copies in a simulated second.
        advice: keys that make it smaller.
    """

    path: str
    memory: float
    rays_per_s: float
    advice: str


@dataclass(frozen=True)
class Cost:
    """Memory and work of a run, by part.

    Attributes:
        parts: the largest first.
        ticks: of the whole run.
    """

    parts: tuple[Part, ...]
    ticks: float

    @property
    def memory(self) -> float:
        """Of all parts [B]."""
        return _BASE + sum(part.memory for part in self.parts)

    @property
    def rays_per_s(self) -> float:
        """Cast for all copies in a simulated second."""
        return sum(part.rays_per_s for part in self.parts)


def cost_of(scenario: Scenario, n: int = 1, *, block_s: float = BLOCK_S) -> Cost:
    """Cost of a run of `n` copies, in blocks of at most so long; needs no device and builds nothing."""
    parts = [*_world(scenario)]
    for name, agent in scenario.agents.items():
        members = float(n * (agent.count or 1))
        sees, sensors = False, []
        for sensor, config in agent.sensors.items():
            sensors.append(_sensor(f"agents.{name}.sensors.{sensor}", config, members, block_s))
            sees |= getattr(registry.find("sensor", config.type).load(), "SEES_SCENE", True)
        longest = 1.0 if sees else max(1.0, scenario.tick_rate_hz * block_s)
        parts.append(Part(f"agents.{name}", members * (_COPY + _TICK * longest), 0.0, "n, count or tick_rate_hz"))
        parts += sensors
    order = sorted(parts, key=lambda part: -part.memory)
    return Cost(tuple(order), scenario.duration_s * scenario.tick_rate_hz)


def check_memory(scenario: Scenario, n: int, limit: float | None = None, *, block_s: float = 0.0) -> None:
    """Refuse a run that would not fit.

    Args:
        scenario: of the run.
        n: copies.
        limit: [B]; four fifths of what is free where not given.
        block_s: of simulated time in one call; 0: single steps.

    Raises:
        InputError: with the part that takes most, and what makes it smaller.
    """
    allowed = _SHARE * free_memory() if limit is None else limit
    cost = cost_of(scenario, n, block_s=block_s)
    if cost.memory <= allowed:
        return
    worst = cost.parts[0] if cost.parts else Part("the process", _BASE, 0.0, "nothing")
    copies = f" with {n} copies" if n > 1 else ""
    raise InputError(
        f"this run{copies} needs about {size(cost.memory)} of memory, and may take {size(allowed)}; "
        f"{size(worst.memory)} are for {worst.path}: lower {worst.advice}, or raise the memory limit"
    )


def free_memory() -> float:
    """Memory that this process could still get [B]; infinite where the system does not say."""
    found = [math.inf]
    meminfo = Path("/proc/meminfo")
    if meminfo.exists():
        lines = dict(line.split(":") for line in meminfo.read_text().splitlines() if ":" in line)
        found.append(float(lines["MemAvailable"].split()[0]) * 1024)
    elif hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found.append(float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))
    of_group, used = Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory.current")
    if of_group.exists() and used.exists() and (text := of_group.read_text().strip()) != "max":
        statistics = dict(line.split() for line in Path("/sys/fs/cgroup/memory.stat").read_text().splitlines())
        cached = float(statistics.get("inactive_file", 0))  # files that are given back when somebody needs the room
        found.append(max(0.0, float(text) - float(used.read_text()) + cached))
    return min(found)


def size(count: float) -> str:
    """A number of bytes in words."""
    for unit, scale in (("EB", 1e18), ("PB", 1e15), ("TB", 1e12), ("GB", 1e9)):
        if count >= 0.9995 * scale:  # three digits of it are the next unit's
            return f"{count / scale:.3g} {unit}"
    return f"{count / 1e6:.3g} MB"


def parsed_size(text: str) -> float:
    """Bytes of "8G", "500M" or "2e9".

    Raises:
        InputError: it is no size.
    """
    scale = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}.get(text.strip().upper().removesuffix("B")[-1:], 1.0)
    digits = text.strip().upper().removesuffix("B").rstrip("KMGT")
    try:
        found = float(digits) * scale
    except ValueError:
        found = math.nan
    if not found > 0:
        raise InputError(f"--memory-limit is a size such as 8G, 500M or 2e9, not {text!r}")
    return found


def _sensor(path: str, config: Any, copies: float, block_s: float) -> Part:
    rays = max((_product(config, keys) for keys in _COUNTS), default=0.0)
    if hasattr(config, "points_per_second"):
        rays = max(rays, config.points_per_second / config.rate_hz)
    cells = max(_product(config, keys) for keys in _SUMS)
    if hasattr(config, "sample_rate_hz"):
        cells = max(
            cells, config.sample_rate_hz / config.rate_hz * max(1, len(getattr(config, "elements_m", ()) or ()))
        )
    pulse = getattr(config, "pulse_s", 0.0) * getattr(config, "bandwidth_hz", 0.0)
    cls = registry.find("sensor", config.type).load()
    lanes = 1.0 if getattr(cls, "SEES_SCENE", True) else max(1.0, config.rate_hz * block_s)
    memory = copies * (lanes * _LANE + rays * _RAY + cells * _CELL) + pulse * _CELL
    keys = {key for group in (*_COUNTS, *_SUMS) for key in group if hasattr(config, key)}
    keys |= {key for key in ("points_per_second", "sample_rate_hz") if hasattr(config, key)}
    if pulse * _CELL > 0.5 * memory:
        keys = {"pulse_s", "bandwidth_hz"}
    return Part(path, memory, rays * config.rate_hz * copies, ", ".join([*sorted(keys), "n or rate_hz"]))


def _world(scenario: Scenario) -> Iterator[Part]:
    """The ground, where its size and its spacing say how many nodes it has; a streamed one keeps to its own limit."""
    world = scenario.world
    spacing = getattr(world, "grid_m", None) or getattr(world, "resolution_m", None)
    wide = getattr(world, "size_m", None)
    if spacing and wide and not hasattr(world, "memory_mb"):
        across, along = (float(side) for side in wide)
        yield Part("world", across / spacing * along / spacing * _NODE, 0.0, "size_m, or raise the spacing of its grid")


def _product(config: Any, keys: tuple[str, ...]) -> float:
    values = [getattr(config, key, None) for key in keys]
    numbers = [float(v) for v in values if isinstance(v, int | float)]
    return math.prod(numbers) if len(numbers) == len(keys) else 0.0
