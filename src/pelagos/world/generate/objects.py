"""Things in numbers, sizes and clusters as asked, set on any ground: what `objects` means in every world."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Final, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ConfigDict, Field, field_validator, model_validator

from pelagos.config.described import Described
from pelagos.errors import LookupFailed, WorldError
from pelagos.world.config import Positive
from pelagos.world.generate.draw import Distribution, _from_pair, bounded, draw
from pelagos.world.generate.kinds.lost import LOST
from pelagos.world.generate.kinds.natural import NATURAL
from pelagos.world.generate.kinds.structures import STRUCTURES
from pelagos.world.generate.route import add_cable, add_pipeline, route
from pelagos.world.generate.scatter import Places, covering
from pelagos.world.generate.thing import Kind, Thing, stand
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField

KINDS: Final[dict[str, Kind]] = NATURAL | LOST | STRUCTURES
"""Everything that `objects` may name, but for the lines."""

LINES: Final = {"pipeline": (0.3, 0.9), "cable": (0.05, 0.2)}
"""Lines across the ground, with the diameters [m] that they have where a scenario says nothing."""

_HOPELESS: Final = 100  # after so many in a row have found no room, the rest is not tried
_MODEL: Final = ConfigDict(frozen=True, extra="forbid")


class ObjectConfig(Described):
    """Things of one kind."""

    model_config = _MODEL

    kind: str
    """What: boulder, outcrop, kelp, seagrass, coral, wreck_boat, pipeline, ... (all in docs/worlds.md)."""
    count: int | None = Field(default=None, ge=0)
    """How many; instead of `density_per_ha`."""
    density_per_ha: Annotated[Distribution | float, BeforeValidator(_from_pair), bounded(least=0)] | None = None
    """How many in a hectare on average, or a distribution of it; their number is drawn from Poisson's distribution."""
    size_m: Annotated[Distribution | float, BeforeValidator(_from_pair), bounded(above=0)] | None = None
    """Size [m]: a number, [least, greatest], or a distribution; the kind says what is measured."""
    cluster: float = Field(default=0.0, ge=0, le=1)
    """Share that stands in clusters; the rest is spread evenly."""
    cluster_radius_m: float = Field(default=8.0, gt=0)
    """Standard deviation of the distance from a cluster's middle [m]."""
    min_distance_m: float = Field(default=0.0, ge=0)
    """Free ground between a thing and everything else [m]."""
    max_slope_deg: float | None = Field(default=None, gt=0, le=90)
    """Steepest ground that it stands on [deg]; by kind where not given."""
    depth_m: tuple[float, float] | None = None
    """Least and greatest depth of the ground it stands on [m]."""
    heading_deg: float | None = None
    """Heading of all, from x towards y [deg]; random where not given."""
    at_m: tuple[tuple[float, float], ...] = ()
    """Places x, y of the first ones [m]; the rest is placed at random."""
    label: str | int | None = None
    """Semantic label by name or number; by kind where not given."""

    @field_validator("kind")
    @classmethod
    def _known(cls, value: str) -> str:
        known = [*KINDS, *LINES]
        if value not in known:
            raise ValueError(str(LookupFailed("kind of object", value, known)))
        return value

    @model_validator(mode="after")
    def _lines_go_their_own_way(self) -> Self:
        if self.kind in LINES:
            for name in ("cluster", "cluster_radius_m", "max_slope_deg", "depth_m", "heading_deg", "at_m"):
                if getattr(self, name) != type(self).model_fields[name].default:
                    raise ValueError(f"a {self.kind} runs across the world on a way that is drawn: leave out {name}")
        return self


class ExclusionConfig(Described):
    """A disc, or a rectangle along x and y, where nothing is placed."""

    model_config = _MODEL

    at_m: tuple[float, float]
    """Its middle x, y [m]."""
    radius_m: float | None = Field(default=None, gt=0)
    """Radius of a disc [m]."""
    size_m: tuple[Positive, Positive] | None = None
    """Extent of a rectangle along x and y [m], instead of `radius_m`."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.radius_m is None) == (self.size_m is None):
            raise ValueError("give radius_m of a disc, or size_m of a rectangle")
        return self

    @property
    def discs(self) -> NDArray[np.float64]:
        """`(k, 3)` discs that cover it: x, y and radius [m]."""
        middle = np.array(self.at_m)
        if self.size_m is None:
            return np.array([[*middle, self.radius_m]])
        half = np.array(self.size_m) / 2
        return covering(middle - half, middle + half)


class Placer:
    """Sets things on a ground, one kind after the other.

    Attributes:
        site: the world under construction.
        places: what is taken, and the extent [m].
        ground: what things stand on; pipelines dig into it.
    """

    def __init__(self, site: Site, places: Places, ground: HeightField) -> None:
        self.site, self.places, self.ground = site, places, ground

    def place(self, config: ObjectConfig, rng: np.random.Generator) -> int:
        """Set as many as asked for and as find room; returns how many. The site notes what found none."""
        wanted = self._wanted(config, rng)
        placed = (self._lines if config.kind in LINES else self._things)(config, wanted, rng)
        if placed < wanted:
            self.site.notes.append(f"{config.kind}: {placed} of {wanted} were placed; no room was found for the rest")
        return placed

    def _wanted(self, config: ObjectConfig, rng: np.random.Generator) -> int:
        if config.count is not None:
            return config.count
        if config.density_per_ha is None:
            return max(1, len(config.at_m))
        (x0, x1), (y0, y1) = self.places.x, self.places.y
        return int(rng.poisson(draw(config.density_per_ha, rng) * (x1 - x0) * (y1 - y0) / 1e4))

    def _things(self, config: ObjectConfig, wanted: int, rng: np.random.Generator) -> int:
        ground = self.ground
        kind = KINDS[config.kind]
        size_of = config.size_m if config.size_m is not None else Distribution(uniform=kind.size)
        low, high = np.array([self.places.x[0], self.places.y[0]]), np.array([self.places.x[1], self.places.y[1]])
        heaps = [rng.uniform(low, high) for _ in range(max(1, wanted // 12))]
        typical = -float(np.median(ground.z))
        models: list[tuple[float, Thing]] = []
        placed, missed = 0, 0
        for k in range(wanted):
            if missed >= _HOPELESS:
                break
            size = max(draw(size_of, rng), 1e-2)
            if kind.variants and len(models) >= kind.variants:
                made, thing = models[k % kind.variants]
                thing = thing.scaled(size / made)
            else:
                thing = kind.build(size, rng, typical)
                models.append((size, thing))
            clustered = rng.uniform() < config.cluster
            heap = (heaps[int(rng.integers(len(heaps)))], config.cluster_radius_m) if clustered else None
            yaw = rng.uniform(0, 2 * np.pi) if config.heading_deg is None else float(np.radians(config.heading_deg))
            radius = thing.radius + config.min_distance_m / 2
            suits = _Suits(ground, config, kind, size)
            if k < len(config.at_m):
                at: NDArray[np.float64] | None = np.array(config.at_m[k])
                if not ((low <= config.at_m[k]) & (config.at_m[k] <= high)).all():
                    raise WorldError(
                        f"{config.kind}: at_m {list(config.at_m[k])} lies outside x {low[0]:g} .. {high[0]:g}, "
                        f"y {low[1]:g} .. {high[1]:g} m"
                    )
                self.places.take(*config.at_m[k], radius)
            else:
                at = self.places.find(rng, radius, around=heap, accept=suits, tries=120)
                if at is None and heap is not None:
                    at = self.places.find(rng, radius, accept=suits, tries=120)
            if at is None:
                missed += 1
                continue
            missed = 0
            z, slope = _ground_at(ground, at)
            if kind.make_deep is not None:
                thing = kind.build(size, rng, max(-z, 0.5))
            if config.label is not None:
                thing = replace(thing, label=config.label)
            stand(self.site, thing, at, z, slope, yaw)
            placed += 1
        return placed

    def _lines(self, config: ObjectConfig, wanted: int, rng: np.random.Generator) -> int:
        size_of = config.size_m if config.size_m is not None else Distribution(uniform=LINES[config.kind])
        placed = 0
        for _ in range(wanted):
            diameter = draw(size_of, rng)
            path = route(self.places, self.ground, rng, diameter / 2 + 0.7 + config.min_distance_m / 2)
            if path is None:
                continue
            if config.kind == "pipeline":
                add_pipeline(
                    self.site, path, self.ground, diameter, rng, label="pipe" if config.label is None else config.label
                )
            else:
                add_cable(
                    self.site, path, self.ground, diameter, label="cable" if config.label is None else config.label
                )
            placed += 1
        return placed


class _Suits:
    """Whether ground suits a thing: its slope, its depth, water enough above."""

    def __init__(self, ground: HeightField, config: ObjectConfig, kind: Kind, size: float) -> None:
        self.ground = ground
        self.limit = np.tan(np.radians(config.max_slope_deg or kind.max_slope_deg))
        least, most = config.depth_m or (-np.inf, np.inf)
        self.depth = (max(least, kind.needs_depth * size if kind.needs_depth > 0 else -np.inf), most)

    def __call__(self, x: float, y: float) -> bool:
        z, slope = _ground_at(self.ground, np.array([x, y]))
        return bool(self.depth[0] <= -z <= self.depth[1] and np.hypot(*slope) <= self.limit)


def _ground_at(ground: HeightField, at: NDArray[np.float64]) -> tuple[float, tuple[float, float]]:
    """Height [m] and slope (dz/dx, dz/dy) over one cell."""
    d = ground.spacing
    x = min(max(float(at[0]), ground.x0 + d), ground.x0 + (ground.z.shape[0] - 2) * d)
    y = min(max(float(at[1]), ground.y0 + d), ground.y0 + (ground.z.shape[1] - 2) * d)
    z = ground.height(np.array([x, x + d, x - d, x, x]), np.array([y, y, y, y + d, y - d]))
    return float(z[0]), (float(z[1] - z[2]) / (2 * d), float(z[3] - z[4]) / (2 * d))
